"""The contract of the tables: what cannot be written, what footers and hashes say, what is read."""

from pathlib import Path

import numpy as np
import pandas as pd
import pandera.errors
import pyarrow as arrow
import pyarrow.parquet as parquet
import pytest
from hypothesis import given
from hypothesis import strategies as st

from campaigns import Campaign, rows
from oilfilm import tables
from oilfilm.base.errors import OilfilmError
from oilfilm.tables import refuse_oversized
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.tables.samples_content import (
    digests_of_runs,
    reader_of_samples,
    samples_digest_and_row_count,
)

ABOUT = {"campaign": "test", "data": "simulated"}


@pytest.fixture
def quarantine() -> pd.DataFrame:
    row = {name: "x" for name in tables.columns("quarantine")}
    row |= {"stage": "ingest", "first_row": 1, "last_row": 2, "refused_rows": 2}
    return tables.from_rows([row], "quarantine")


def test_what_is_written_is_read_back(quarantine: pd.DataFrame, tmp_path: Path) -> None:
    path = tmp_path / "deep" / "q.parquet"
    tables.write(quarantine, "quarantine", path, ABOUT)
    pd.testing.assert_frame_equal(tables.read("quarantine", path), quarantine)
    assert [file.name for file in path.parent.iterdir()] == ["q.parquet"]


def test_footer_says_units_and_that_data_are_simulated(tmp_path: Path) -> None:
    path = tmp_path / "p.parquet"
    tables.write(tables.empty_table("points"), "points", path, ABOUT)
    footer = tables.read_footer(path)
    assert footer["data"] == "simulated"
    field = parquet.read_schema(path).field("load_n")
    assert field.metadata[b"unit"] == b"N"
    assert b"load" in field.metadata[b"description"]
    assert parquet.ParquetFile(path).metadata.created_by.startswith("parquet-cpp-arrow")


@pytest.mark.parametrize(
    ("column", "value", "expected"),
    [
        ("load_n", np.inf, ["'load_n'", "normal load", "inf"]),
        ("film_judgement", "thick", ["'film_judgement'", "thick"]),
        ("lambda_ratio", -1.0, ["'lambda_ratio'", "-1"]),
        ("entrainment_speed_m_s", np.nan, ["'entrainment_speed_m_s'", "nan"]),
        ("n_samples", "many", ["'n_samples'", "many"]),
    ],
)
def test_forbidden_value_is_told(demo, column: str, value: object, expected: list[str]) -> None:
    frame = demo.curated.points.head(3).astype(object)
    frame.loc[1, column] = value
    with pytest.raises(OilfilmError) as mistake:
        tables.conform(frame, "points", "here")
    for text in expected:
        assert text.lower() in str(mistake.value).lower()


NUMBERS = st.floats() | st.sampled_from(
    [-tables.LARGEST_NUMBER, tables.LARGEST_NUMBER, 2 * tables.LARGEST_NUMBER]
)


FLOATS = [("points", "time_s"), ("points", "lambda_ratio"), ("runs", "nominal_load_n")]
COUNTS = [("points", "n_samples"), ("points", "first_row")]
TEXTS = ["continuous", "step", "", None]


@pytest.mark.slow
@given(
    st.tuples(st.sampled_from(FLOATS), NUMBERS)
    | st.tuples(st.sampled_from(COUNTS), st.integers(-2, 2))
    | st.tuples(st.just(("runs", "log_kind")), st.sampled_from(TEXTS))
)
def test_short_cut_past_pandera_is_as_strict(demo, changed: tuple[tuple[str, str], object]) -> None:
    (table, column), value = changed
    frame = getattr(demo.curated, table).head(3).copy()
    frame[column] = pd.Series([*frame[column][:2], value], dtype=frame[column].dtype)
    try:
        tables.TABLES[table].schema.validate(frame)
    except pandera.errors.SchemaError:
        with pytest.raises(OilfilmError, match=column):
            tables.conform(frame, table, "here")
    else:
        tables.conform(frame, table, "here")


def test_list_is_read_back_as_it_was_written_whatever_its_texts_hold(tmp_path: Path) -> None:
    path = tmp_path / "soundness.parquet"
    runs: list[tuple[str, ...]] = [("a, b.csv", "c; d.csv"), (), ("",)]
    frame = rows("soundness", *({"oil": str(row)} for row in range(3)))
    frame = frame.assign(
        law_verdict="adequate", campaign_verdict="steady", change_course="", changed_runs=runs
    )
    tables.write(frame, "soundness", path, ABOUT)
    assert tables.read("soundness", path)["changed_runs"].tolist() == runs
    assert parquet.read_table(path).schema.field("changed_runs").type.value_type == arrow.string()
    refuse_oversized(path)


def test_unknown_list_is_null_and_no_empty_list(tmp_path: Path) -> None:
    path = tmp_path / "law_verdicts.parquet"
    frame = rows("law_verdicts", *({"oil": oil, "verdict": "best"} for oil in "abc"))
    frame["bic_ties"] = [None, (), ("tanh",)]
    tables.write(frame, "law_verdicts", path, ABOUT)
    assert tables.read("law_verdicts", path)["bic_ties"].tolist() == [None, (), ("tanh",)]
    filled = tables.filled_table(pd.DataFrame({"oil": ["a"], "verdict": "no fit"}), "law_verdicts")
    assert filled["bic_ties"].tolist() == [None]


@pytest.mark.parametrize("value", ["thin_film", None, (1,), ("thin_film", None)])
def test_what_is_no_list_of_texts_is_refused(demo, value: object) -> None:
    frame = demo.curated.points.head(1).copy()
    frame.at[0, "failed_gates"] = value
    frame["accepted"] = False
    with pytest.raises(OilfilmError, match="'failed_gates'"):
        tables.conform(frame, "points", "here")


@pytest.mark.parametrize(
    "kind", [arrow.list_(arrow.list_(arrow.string())), arrow.list_(arrow.int8())]
)
def test_other_nested_columns_are_not_unpacked(tmp_path: Path, kind: arrow.DataType) -> None:
    path = tmp_path / "nested.parquet"
    parquet.write_table(arrow.table({"a": arrow.array([None], kind)}), path)
    with pytest.raises(OilfilmError, match="list"):
        refuse_oversized(path)


def test_column_that_a_file_has_twice_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "quarantine.parquet"
    tables.write(tables.empty_table("quarantine"), "quarantine", path, ABOUT)
    content = parquet.read_table(path)
    parquet.write_table(content.append_column("file", content["file"]), path)
    with pytest.raises(OilfilmError, match=r"repeats the columns \['file'\]"):
        tables.read("quarantine", path)


def test_list_that_unpacks_to_more_than_memory_holds_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "bomb.parquet"
    texts = arrow.array([["x" * 10_000] * 100] * 100, arrow.list_(arrow.string()))
    parquet.write_table(arrow.table({"a": texts}), path, use_dictionary=["a.list.element"])
    assert path.stat().st_size < 100_000
    with pytest.raises(OilfilmError, match="unpacks to"):
        refuse_oversized(path, bytes_max=10_000_000)


def test_accepted_point_with_a_reason_is_a_contradiction(demo) -> None:
    frame = demo.curated.points.head(3).copy()
    frame.at[0, "failed_gates"] = ("thin_film",)
    with pytest.raises(OilfilmError, match="accepted with a failed gate"):
        tables.conform(frame, "points", "here")


def test_repeated_key_is_refused(demo) -> None:
    frame = pd.concat([demo.curated.runs.head(2)] * 2)
    with pytest.raises(OilfilmError, match="2 rows repeat run_id"):
        tables.conform(frame, "runs", "here")


def test_missing_and_unknown_columns_are_named() -> None:
    frame = tables.empty_table("runs").drop(columns="oil").assign(colour="red")
    with pytest.raises(OilfilmError, match=r"lacks .*\['oil'\].*unknown .*\['colour'\]"):
        tables.conform(frame, "runs", "here")


def test_other_table_and_damage_are_refused(quarantine: pd.DataFrame, tmp_path: Path) -> None:
    path = tmp_path / "q.parquet"
    tables.write(quarantine, "quarantine", path, ABOUT)
    with pytest.raises(OilfilmError, match="holds table 'quarantine'"):
        tables.read("runs", path)
    path.write_bytes(path.read_bytes()[:-20])
    with pytest.raises(OilfilmError, match="cannot be read as Parquet"):
        tables.read("quarantine", path)
    pd.DataFrame({"a": [1]}).to_parquet(path)
    with pytest.raises(OilfilmError, match="not a table of oilfilm"):
        tables.read("quarantine", path)


@pytest.mark.parametrize(
    ("load", "expected"),
    [
        ({"unit": "kN"}, r"column 'load_n' is in 'kN'; expected 'N'"),
        (None, r"lacks the columns \['load_n'\]"),
    ],
)
def test_table_by_another_declaration_is_refused(
    tmp_path: Path, load: dict[str, str] | None, expected: str
) -> None:
    path = tmp_path / "points.parquet"
    tables.write(tables.empty_table("points"), "points", path, ABOUT)
    content = parquet.read_table(path)
    place = content.schema.get_field_index("load_n")
    field = content.schema.field(place)
    content = content.remove_column(place)
    if load:
        content = content.add_column(place, field.with_metadata(load), arrow.array([], field.type))
    parquet.write_table(content, path)
    with pytest.raises(OilfilmError, match=f"{expected}.*another version of oilfilm"):
        tables.read("points", path)


@pytest.mark.slow
@pytest.mark.parametrize(("in_footer", "every"), [(False, 7), (True, 29)])
def test_no_flipped_bit_is_read_as_another_number(
    quarantine: pd.DataFrame, tmp_path: Path, in_footer: bool, every: int
) -> None:
    """Each page carries a CRC-32: compression alone lets some bits pass. A footer has none."""
    path = tmp_path / "quarantine.parquet"
    tables.write(quarantine, "quarantine", path, ABOUT)
    content, as_written = path.read_bytes(), tables.read("quarantine", path)
    footer = len(content) - int.from_bytes(content[-8:-4], "little") - 8
    refused = 0
    for offset in range(footer, len(content), every) if in_footer else range(0, footer, every):
        damaged = bytearray(content)
        damaged[offset] ^= 1 << offset % 8
        path.write_bytes(damaged)
        try:
            assert tables.read("quarantine", path).equals(as_written) or in_footer
        except OilfilmError:
            refused += 1
    assert refused > 0


PROVENANCE = {"campaign": "june", "data": "measured"}


class Inputs(dict[str, str | list[str]]):
    """Named inputs as Snakemake gives them."""


def test_table_is_read_when_it_is_used_and_a_table_without_files_is_empty(tmp_path: Path) -> None:
    path = tmp_path / "torque.parquet"
    results = CampaignTables.from_job(Inputs(torque=[], points=str(path), claims="claims.yaml"))
    pd.testing.assert_frame_equal(results.torque, tables.empty_table("torque"))
    with pytest.raises(OilfilmError, match="there is no such table"):
        results.points  # noqa: B018
    tables.write(tables.empty_table("points"), "points", path, PROVENANCE)
    assert results.points.empty


def test_table_that_the_rule_does_not_list_is_refused_by_its_name() -> None:
    results = CampaignTables.from_job(Inputs(torque=[], runs=[]))
    with pytest.raises(OilfilmError, match=r"'points' is not among the inputs.*runs, torque"):
        results.points  # noqa: B018


def test_campaign_without_torque_logs_has_empty_tables_of_torque(tmp_path: Path) -> None:
    results = CampaignTables.from_folder(tmp_path)
    assert results.torque_quarantine.empty
    with pytest.raises(OilfilmError, match=r"coefficients\.parquet: there is no such table"):
        results.coefficients  # noqa: B018


@pytest.fixture(scope="module")
def samples(demo: Campaign) -> pd.DataFrame:
    """Of four runs, the rows of a run together."""
    of_oil = next(iter(demo.ingested.samples_of_oil.values()))
    few = of_oil[of_oil["run_id"].isin(of_oil["run_id"].unique()[:4])]
    return few.astype({"run_id": str}).reset_index(drop=True)


def write(samples: pd.DataFrame, path: Path) -> Path:
    content = {**ABOUT, "content": digests_of_runs(samples)}
    tables.write(samples, "samples", path, content)
    return path


def test_hash_of_samples_does_not_depend_on_files(samples: pd.DataFrame, tmp_path: Path) -> None:
    first, *others = samples["run_id"].unique()
    one_file = [write(samples, tmp_path / "all.parquet")]
    parts = [samples[samples["run_id"].isin(others)], samples[samples["run_id"] == first]]
    two_files = [write(part, tmp_path / f"{len(part)}.parquet") for part in parts]
    assert samples_digest_and_row_count(one_file) == samples_digest_and_row_count(two_files)
    assert samples_digest_and_row_count(one_file)[1] == len(samples)
    read = reader_of_samples(two_files)
    for run_id in samples["run_id"].unique():
        expected = samples[samples["run_id"] == run_id].reset_index(drop=True)
        assert read(run_id).astype({"run_id": str}).equals(expected)


def test_hash_of_samples_changes_with_one_value_of_a_run(samples: pd.DataFrame) -> None:
    before = digests_of_runs(samples)
    assert len(before) == 4
    assert digests_of_runs(samples.head(0)) == {}
    changed = samples.copy()
    changed.loc[len(samples) - 1, "load_n"] += 1e-9
    after = digests_of_runs(changed)
    assert [run for run in before if before[run] != after[run]] == [samples["run_id"].iloc[-1]]
