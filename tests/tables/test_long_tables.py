"""Tables that do not fit into memory: some columns of them, parts, and rows in order."""

from pathlib import Path
from typing import Any

import pandas as pd
import pyarrow.parquet as parquet
import pytest

from campaigns import Campaign
from oilfilm import tables
from oilfilm.curation.curate import compare_runs
from oilfilm.tables import sorted_rows
from oilfilm.tables.campaign_tables import CampaignTables

ABOUT = {"campaign": "test", "data": "simulated"}
ROWS_OF_GROUP = 1000


class NeverWhole(CampaignTables):
    """Tables of which nobody reads `points` with all its columns."""

    def table(self, name: str, columns: Any = None, **wanted: str) -> pd.DataFrame:
        assert name != "points" or columns is not None
        return super().table(name, columns, **wanted)


@pytest.fixture
def points(demo: Campaign) -> pd.DataFrame:
    return demo.curated.points


def test_columns_and_rows_that_are_not_asked_for_are_not_read(
    points: pd.DataFrame, tmp_path: Path
) -> None:
    path = tmp_path / "points.parquet"
    tables.write(points, "points", path, ABOUT)
    names = ["traction_coefficient", "run_id", "failed_gates"]
    part = CampaignTables({"points": [path]}).table("points", names, oil="4050")
    expected = points.loc[points["oil"] == "4050", names].reset_index(drop=True)
    pd.testing.assert_frame_equal(part, expected)
    in_memory = CampaignTables.from_frames(points=points).table("points", names, oil="4050")
    pd.testing.assert_frame_equal(part, in_memory)


def test_blocks_of_runs_have_whole_runs_and_all_rows(points: pd.DataFrame, tmp_path: Path) -> None:
    path = tmp_path / "points.parquet"
    ordered = points.sort_values(["run_id", "first_row"], ignore_index=True)
    with tables.writing("points", path, ABOUT, ROWS_OF_GROUP) as add:
        add(ordered)
    names = ["run_id", "first_row", "accepted"]
    read = CampaignTables({"points": [path]})
    parts = list(read.blocks_of_runs("points", names))
    assert len(parts) > 2
    pd.testing.assert_frame_equal(pd.concat(parts, ignore_index=True), ordered[names])
    runs_of_parts = [set(part["run_id"]) for part in parts]
    assert sum(map(len, runs_of_parts)) == points["run_id"].nunique()
    (nothing,) = CampaignTables({"points": []}).blocks_of_runs("points", names)
    assert nothing.empty


def test_row_groups_without_wanted_rows_are_left_out(points: pd.DataFrame, tmp_path: Path) -> None:
    path = tmp_path / "points.parquet"
    with tables.writing("points", path, ABOUT, ROWS_OF_GROUP) as add:
        add(points.sort_values("oil", kind="stable", ignore_index=True))
    every = sum(map(len, tables.arrow_blocks("points", path)))
    some = sum(map(len, tables.arrow_blocks("points", path, row_filter={"oil": "4050"})))
    of_oil = int((points["oil"] == "4050").sum())
    assert of_oil <= some < of_oil + 2 * ROWS_OF_GROUP < every
    names = ["run_id", "first_row"]
    read = tables.read("points", path, columns=names, row_filter={"oil": "4050"})
    expected = points.loc[points["oil"] == "4050", names].reset_index(drop=True)
    pd.testing.assert_frame_equal(read, expected)


def test_bytes_of_a_table_do_not_depend_on_its_parts(points: pd.DataFrame, tmp_path: Path) -> None:
    written = []
    for parts in (1, 7, 60):
        path = tmp_path / f"{parts}.parquet"
        length = -(-len(points) // parts)
        with tables.writing("points", path, ABOUT, ROWS_OF_GROUP) as add:
            for start in range(0, len(points), length):
                add(points.iloc[start : start + length])
        written.append(path.read_bytes())
        footer = parquet.read_metadata(path)
        groups = [footer.row_group(number).num_rows for number in range(footer.num_row_groups)]
        assert set(groups[:-1]) == {ROWS_OF_GROUP}
        assert sum(groups) == len(points)
    assert written[0] == written[1] == written[2]


def test_rows_of_many_files_are_sorted_range_by_range(
    points: pd.DataFrame, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sorted_rows, "_RANGE_ROW_COUNT", 300)
    paths = [tmp_path / f"{share}.parquet" for share in range(5)]
    shuffled = points.sample(frac=1, random_state=1)
    for share, path in enumerate(paths):
        tables.write(shuffled.iloc[share::5], "points", path, ABOUT)
    counts = points.groupby("run_id").size()
    counts["zz_without_plateaus.csv"] = 0
    parts = list(sorted_rows.sorted_rows("points", paths, counts, tmp_path))
    assert len(parts) > 5
    assert max(map(len, parts)) < 300 + counts.max()
    expected = points.sort_values(["run_id", "first_row"], ignore_index=True)
    pd.testing.assert_frame_equal(pd.concat(parts, ignore_index=True), expected)
    # nothing stays beside the files
    assert sorted(tmp_path.iterdir()) == paths


def test_rows_before_the_first_range_stay_first(
    points: pd.DataFrame, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sorted_rows, "_RANGE_ROW_COUNT", 300)
    path = tmp_path / "share.parquet"
    tables.write(points, "points", path, ABOUT)
    counts = points.groupby("run_id").size()
    # as of a run that was refused when the runs were compared
    counts[counts.index.min()] = 0
    parts = sorted_rows.sorted_rows("points", [path], counts, tmp_path)
    expected = points.sort_values(["run_id", "first_row"], ignore_index=True)
    pd.testing.assert_frame_equal(pd.concat(parts, ignore_index=True), expected)


@pytest.mark.slow
def test_runs_are_compared_without_all_columns_of_their_points(demo: Campaign) -> None:
    # runs are compared with those of their oil
    points, runs = (
        table[table["oil"] == "4050"].reset_index(drop=True)
        for table in (demo.curated.points, demo.curated.runs)
    )
    shares = NeverWhole.from_frames(points=points, runs=runs, quarantine=demo.curated.quarantine)
    compared = compare_runs(shares, demo.config)
    assert (compared.runs["verdict"] == "refused").any()
    pd.testing.assert_frame_equal(compared.runs, runs)
