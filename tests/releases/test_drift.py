"""Two releases compared: a sensor that is off is named and stopped, equal ones pass silently."""

import json
import re
import shutil
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pyarrow as arrow
import pytest
from pyarrow import parquet

from campaigns import LABORATORY, ROOT, Campaign
from nights import nightly
from oilfilm import tables
from oilfilm.base.errors import OilfilmError
from oilfilm.base.text_table import markdown_table
from oilfilm.cli import main
from oilfilm.curation.curate import collect, curate_samples
from oilfilm.curation.traction_rig import TractionRig
from oilfilm.releases.compare import Comparison, compare
from oilfilm.releases.manifest import canonical_json, read_manifest
from oilfilm.releases.statements import changed_lines
from oilfilm.releases.stored_release import StoredRelease, pin
from oilfilm.settings.resolve import resolve
from oilfilm.settings.resolved import Settings
from oilfilm.traction.laws.deng2026 import traction_coefficient
from releases import alter_file, finished_run, project, released, tables_of

OILS = ("4102", "4050")
CONFIG = ["--config", str(ROOT / "config")]
DRIFT = resolve(LABORATORY, {}).drift
LOGS = {"4050.csv": b"1", "4102.csv": b"1"}
Make = Callable[..., Path]


@pytest.fixture(scope="module")
def fifth(demo: Campaign) -> Campaign:
    """Every fifth run of each oil of the demonstration: all its temperatures and pressures."""
    runs = demo.curated.runs
    chosen = runs[runs.groupby("oil").cumcount() % 5 == 0]
    points = demo.curated.points
    points = points[points["run_id"].isin(chosen["run_id"])].reset_index(drop=True)
    curated = replace(demo.curated, runs=chosen.reset_index(drop=True), points=points)
    return replace(demo, curated=curated)


@pytest.fixture(scope="module")
def frames(fifth: Campaign) -> dict[str, pd.DataFrame]:
    """Tables of two oils of these runs."""
    seen = pd.DataFrame({"oil": OILS, "law": "deng2026", "seen_step_zero": [1e-4, 2e-4]})
    return {**tables_of(fifth, OILS), "soundness": tables.filled_table(seen, "soundness")}


@pytest.fixture(scope="module")
def make(
    demo: Campaign, frames: dict[str, pd.DataFrame], tmp_path_factory: pytest.TempPathFactory
) -> Make:
    """Releases of these tables, some of them, the logs or settings replaced."""

    def release(
        config: Settings = demo.config, raw: dict[str, bytes] = LOGS, **replaced: pd.DataFrame
    ) -> Path:
        root = project(tmp_path_factory.mktemp("drift") / "p")
        return released(finished_run(root, config, raw, {**frames, **replaced}))

    return release


@pytest.fixture(scope="module")
def before(make: Make) -> Path:
    """A release that no test changes."""
    return make()


@pytest.fixture(scope="module")
def miscalibrated(fifth: Campaign, frames: dict[str, pd.DataFrame], make: Make) -> Path:
    """The same after the load cell read 1 % too much in every run of 4102."""
    run_ids = frames["runs"].query("oil == '4102'")["run_id"]
    ingested = fifth.ingested
    samples, runs = ingested.samples_of_oil["4102"], ingested.runs
    samples, runs = (table[table["run_id"].isin(run_ids)] for table in (samples, runs))
    heavier = samples.assign(load_n=1.01 * samples["load_n"])
    curated = collect(curate_samples(heavier, runs, TractionRig(fifth.config)), fifth.config)
    again = tables_of(replace(fifth, curated=curated), OILS[:1])
    both = {
        name: pd.concat([frame, frames[name].query("oil == '4050'")], ignore_index=True)
        for name, frame in again.items()
    }
    return make(raw={**LOGS, "4102.csv": b"2"}, **both)


@pytest.mark.slow
@pytest.mark.parametrize("pinned", [False, True])
def test_load_cell_one_percent_off_is_stopped_by_the_gate_of_a_release_and_of_its_pin(
    before: Path,
    miscalibrated: Path,
    tmp_path: Path,
    pinned: bool,
    capsys: pytest.CaptureFixture[str],
) -> None:
    reference = pin(before, tmp_path) if pinned else before
    assert main(["diff", str(reference), str(miscalibrated), "--gate", *CONFIG]) == 1
    printed = capsys.readouterr().out
    section = printed.split("\n\n")[1]
    moved = [line.split() for line in section.splitlines()[2:]]
    assert {line[0] for line in moved} == {"4102"}
    assert "mu" in {line[1] for line in moved}
    assert main(["diff", str(before), str(before), *CONFIG]) == 0
    assert capsys.readouterr().out.endswith("no difference\n")
    if pinned:
        assert sum(path.stat().st_size for path in reference.rglob("*.*")) < 300_000
        assert main(["diff", str(reference), str(before), "--gate", *CONFIG]) == 0
        assert capsys.readouterr().out == ""


@pytest.mark.slow
def test_load_cell_one_percent_off_is_named(
    before: Path, miscalibrated: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Which logs of which oil, which constants, how much of mu."""
    assert main(["diff", str(before), str(miscalibrated), *CONFIG]) == 0
    text = capsys.readouterr().out
    assert re.search(r"Raw logs: 1\n.*\n  data/raw/demo/4102\.csv  ", text)
    assert "4050" not in text
    comparison = comparison_of(before, miscalibrated)
    titles = {section.title for section in comparison.sections}
    assert not titles & {"Configuration", "Code", "Packages"}
    moved = comparison.changes
    largest = moved.loc[moved["change"].idxmax()]
    assert (largest["oil"], largest["what"]) == ("4102", "A0")
    change = moved[moved["what"] == "mu"].set_index("oil")["change"]
    assert change["4050"] == 0
    # force over a load read 1 % too high is 1/1.01 of mu, found at a pressure 1.01^(1/3) higher
    true = traction_coefficient(_values(before), 1.25 * 1.01 ** (-1 / 3), 30.0, 70.0, 0.05)
    new = traction_coefficient(_values(miscalibrated), 1.25, 30.0, 70.0, 0.05)
    assert float(new) == pytest.approx(float(true) / 1.01, rel=5e-4)
    assert 0.01 < change["4102"] < 0.03


def _values(release: Path) -> np.ndarray:
    coefficients = StoredRelease.open(release).read_table("coefficients")
    assert coefficients is not None
    return coefficients.loc[coefficients["oil"] == "4102", "value"].to_numpy()


# ---------------------------------------------------------------- what else can differ


def comparison_of(before: Path, after: Path) -> Comparison:
    return compare(StoredRelease.open(before), StoredRelease.open(after), DRIFT)


@pytest.mark.slow
def test_each_difference_is_in_its_section(
    make: Make, before: Path, demo: Campaign, frames: dict[str, pd.DataFrame]
) -> None:
    points, coefficients = frames["points"].copy(), frames["coefficients"].copy()
    first = points.index[points["accepted"]][0]
    points.at[first, "accepted"] = False
    points.at[first, "failed_gates"] = ("thin_film",)
    coefficients.loc[3, "verdict"] = "sign unknown"
    config = demo.config.with_changes({"gates": {"lambda_limit": 2.5}})
    after = make(config, points=points, coefficients=coefficients)
    environment = read_manifest(after)[0].made_from.environment.model_dump()
    packages = {**environment["packages"], "numpy": "99.0"}
    alter_file(
        after, "environment.json", canonical_json({**environment, "packages": packages}).encode()
    )
    rows = {each.title: each.rows for each in comparison_of(before, after).sections}
    row = points.loc[first]
    point = f"{row['run_id']}, {row['first_row']}"
    assert rows["Statements"] == [
        ("coefficients", "4102, deng2026, A3", "verdict", "known", "sign unknown"),
        ("points", point, "accepted", "True", "False"),
        ("points", point, "failed_gates", "none", "thin_film"),
    ]
    assert rows["Configuration"] == [("gates.lambda_limit", "3.0", "2.5")]
    ((what, _, new),) = rows["Packages"]
    assert (what, new) == ("environment.packages.numpy", "99.0")
    assert {name for name, _, _ in rows["Files"]} == {
        *("config.yaml", "environment.json", "report.html", "tables/datapackage.json"),
        *("tables/coefficients.parquet", "tables/points.parquet"),
    }


@pytest.mark.slow
def test_releases_of_a_campaign_that_is_not_configured_here_are_compared_but_not_gated(
    make: Make, demo: Campaign, capsys: pytest.CaptureFixture[str]
) -> None:
    config = demo.config.with_changes({"campaign": {"name": "elsewhere"}})
    both = [str(make(config)), str(make(config))]
    assert main(["diff", *both, *CONFIG]) == 0
    assert main(["diff", *both, "--gate", *CONFIG]) == 2
    assert "elsewhere" in capsys.readouterr().err


@pytest.mark.slow
def test_lost_fits_are_stopped(make: Make, before: Path, frames: dict[str, pd.DataFrame]) -> None:
    """4050 has no fit any more, and 4102 has no C3."""
    kept = {name: frames[name] for name in ("coefficients", "fit_quality", "refits")}
    kept = {name: frame[frame["oil"] == "4102"].copy() for name, frame in kept.items()}
    kept["coefficients"].loc[kept["coefficients"]["constant"] == "C3", "value"] = np.nan
    rows = comparison_of(before, make(**kept)).beyond_limits[0].rows
    assert {row[0] for row in rows} == set(OILS)
    assert "4050 is fitted in one release only" in str(rows)
    lost = {row[:2] for row in rows if row[3:5] == ("none", "in one release only")}
    assert {("4102", "C3"), ("4050", "A0")} <= lost
    assert not re.search(r"\b(inf|nan)\b", str(rows))


@pytest.mark.slow
def test_fits_of_other_laws_are_not_compared(
    make: Make, before: Path, frames: dict[str, pd.DataFrame]
) -> None:
    """Each law has a fit for each oil; the campaign uses one."""
    fits = ("coefficients", "fit_quality")
    other = {name: frames[name].assign(law="tanh") for name in fits}
    other["fit_quality"]["configured"] = False
    other["coefficients"]["value"] *= 2
    both = {name: pd.concat([frames[name], other[name]], ignore_index=True) for name in fits}
    assert (comparison_of(before, make(**both)).changes["change"] == 0).all()


@pytest.mark.slow
@pytest.mark.parametrize(("scale", "stopped"), [(1.0099, False), (1.0101, True)])
def test_gate_closes_at_its_limit(
    make: Make, before: Path, frames: dict[str, pd.DataFrame], scale: float, stopped: bool
) -> None:
    """mu is A + B S times an exponential that C decides: A and B by 1 % move mu by 1 %."""
    coefficients = frames["coefficients"].copy()
    heads = (coefficients["oil"] == "4102") & coefficients["constant"].isin(["A0", "B0"])
    coefficients.loc[heads, "value"] *= scale
    comparison = comparison_of(before, make(coefficients=coefficients))
    moved = comparison.changes.set_index(["oil", "what"])["change"]
    assert moved["4102", "mu"] == pytest.approx(scale - 1, rel=1e-9)
    assert ("mu" in str(comparison.beyond_limits)) == stopped


@pytest.mark.slow
@pytest.mark.parametrize("law", ["no-such-law", nightly("tanh")])
def test_tables_that_contradict_each_other_end_in_a_sentence(
    make: Make,
    before: Path,
    frames: dict[str, pd.DataFrame],
    law: str,
    capsys: pytest.CaptureFixture[str],
) -> None:
    after = make(coefficients=frames["coefficients"].assign(law=law))
    assert main(["diff", str(after), str(before), *CONFIG]) == 2
    printed = capsys.readouterr().err
    assert ("tables/" in printed, printed.count("\n")) == (True, 1)


Plant = Callable[[dict[str, pd.DataFrame]], None]


def planted(table: str, column: str, change: Callable[[Any], Any]) -> Plant:
    """Change one value: that of the first row in which the change makes another one."""

    def plant(frames: dict[str, pd.DataFrame]) -> None:
        values = frames[table][column].astype(object)
        row = next(row for row, value in values.items() if change(value) != value)
        values[row] = change(values[row])
        frames[table][column] = values.astype(frames[table][column].dtype)

    return plant


def widened(frames: dict[str, pd.DataFrame]) -> None:
    """Make one interval wider on both sides; its constant and its error stay."""
    row = frames["coefficients"]["lower"].first_valid_index()
    width = frames["coefficients"].loc[row, "upper"] - frames["coefficients"].loc[row, "lower"]
    frames["coefficients"].loc[row, "lower"] -= 0.06 * width
    frames["coefficients"].loc[row, "upper"] += 0.06 * width


@pytest.mark.slow
@pytest.mark.parametrize(
    ("plant", "column"),
    [
        (planted("coefficients", "standard_error", lambda error: 10 * error), "standard_error"),
        nightly(
            planted("coefficients", "standard_error", lambda size: size / 10), "standard_error"
        ),
        nightly(planted("coefficients", "standard_error", lambda size: np.nan), "standard_error"),
        (widened, "lower"),
        nightly(planted("coefficients", "verdict", lambda verdict: "sign unknown"), "verdict"),
        nightly(planted("coefficients", "identifiable", lambda flag: not flag), "identifiable"),
        nightly(planted("fit_quality", "certified", lambda flag: not flag), "certified"),
        nightly(planted("fit_quality", "n_points", lambda count: count - 1), "n_points"),
        nightly(planted("fit_quality", "active_bounds", lambda bounds: ("B1",)), "active_bounds"),
        nightly(planted("runs", "verdict", lambda verdict: "refused"), "verdict"),
        (planted("soundness", "seen_step_zero", lambda size: 1.5 * size), "seen_step_zero"),
    ],
)
def test_gate_names_a_changed_statement_and_nothing_else(
    make: Make, before: Path, frames: dict[str, pd.DataFrame], plant: Plant, column: str
) -> None:
    changed = {name: frame.copy() for name, frame in frames.items()}
    plant(changed)
    (section,) = comparison_of(before, make(**changed)).beyond_limits
    ((_, _, named, old, new),) = section.rows
    assert named == column
    assert old != new


def of_another_version(
    release: Path, folder: Path, table_name: str, lost: str, added: str = "colour"
) -> Path:
    """A copy of a release, in which a table lacks a column and has another one."""
    copy = Path(shutil.copytree(release, folder / "other"))
    for path in (copy, *copy.rglob("*")):
        path.chmod(0o755 if path.is_dir() else 0o644)
    file = copy / f"tables/{table_name}.parquet"
    content = parquet.read_table(file).drop_columns([lost])
    content = content.append_column(added, arrow.nulls(content.num_rows, arrow.string()))
    parquet.write_table(content, file)
    alter_file(copy, f"tables/{table_name}.parquet", file.read_bytes())
    return copy


@pytest.mark.slow
def test_columns_of_one_version_are_named_and_pass(before: Path, tmp_path: Path) -> None:
    """Versions add columns; every version 1.x compares what another one made."""
    other = of_another_version(before, tmp_path, "runs", lost="warning")
    comparison = compare(StoredRelease.open(before), StoredRelease.open(other), DRIFT)
    assert comparison.statements == []
    assert comparison.beyond_limits == []
    (section,) = [part for part in comparison.sections if part.title == "Columns of tables"]
    assert section.rows == [("runs.colour", "", "there"), ("runs.warning", "there", "")]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("table_name", "lost"), [("runs", "run_id"), ("fit_quality", "configured")]
)
def test_columns_without_which_nothing_can_be_compared_are_named(
    before: Path, tmp_path: Path, table_name: str, lost: str
) -> None:
    other = of_another_version(before, tmp_path, table_name, lost)
    with pytest.raises(OilfilmError, match=lost):
        compare(StoredRelease.open(before), StoredRelease.open(other), DRIFT)


@pytest.mark.slow
def test_added_log_changes_counts_and_passes(
    make: Make, before: Path, frames: dict[str, pd.DataFrame]
) -> None:
    """The verdict on an old run does not pass, nor does a lost certificate."""
    quality = frames["fit_quality"].assign(n_points=frames["fit_quality"]["n_points"] + 10)
    runs = frames["runs"]
    more = pd.concat([runs, runs.iloc[:1].assign(run_id="new.csv")], ignore_index=True)
    raw = {**LOGS, "new.csv": b"1"}
    comparison = comparison_of(before, make(raw=raw, runs=more, fit_quality=quality))
    assert {statement.column_name for statement in comparison.statements} == {"", "n_points"}
    assert not comparison.beyond_limits
    uncertified = quality.assign(certified=False)
    (section,) = comparison_of(before, make(raw=raw, fit_quality=uncertified)).beyond_limits
    assert {row[2] for row in section.rows} == {"certified"}


@pytest.mark.slow
def test_new_oil_of_added_logs_passes_and_a_lost_one_does_not(
    make: Make, before: Path, frames: dict[str, pd.DataFrame]
) -> None:
    tables_of_one_oil = {
        name: frame.query("oil == '4102'") for name, frame in frames.items() if "oil" in frame
    }
    one_oil = make(raw={"4102.csv": b"1"}, **tables_of_one_oil)
    assert not comparison_of(one_oil, before).beyond_limits
    (moved, *_) = comparison_of(before, one_oil).beyond_limits
    assert {row[0] for row in moved.rows} == {"4050"}


@pytest.mark.slow
def test_errors_may_move_by_their_limit(
    make: Make, before: Path, frames: dict[str, pd.DataFrame]
) -> None:
    coefficients = frames["coefficients"].copy()
    errors = ["standard_error", "naive_standard_error", "systematic_standard_error"]
    coefficients[errors] *= 1 + 0.99 * DRIFT.errors
    assert not comparison_of(before, make(coefficients=coefficients)).beyond_limits


def test_other_words_and_counts_are_other_sentences_and_other_numbers_are_not() -> None:
    before = ["mu = 0.0312 at 1.2 GPa", "33 of 75 points agree", "4102 is best"]
    moved = ["mu = 0.0313 at 1.2 GPa", "33 of 75 points agree", "4102 is best"]
    assert list(changed_lines(before, moved, with_numbers=False)) == []
    assert list(changed_lines(before, moved)) == [("A", before[0]), ("B", moved[0])]
    table, wider_table = (
        markdown_table(["oil", "T (degC)"], [["4102", temperature]])
        for temperature in ("99.998", "-100.001")
    )
    assert list(changed_lines(table, wider_table, with_numbers=False)) == []
    other = [before[0], "34 of 75 points agree", "4102 is good"]
    changed = list(changed_lines(before, other, with_numbers=False))
    assert changed == [*(("A", line) for line in before[1:]), *(("B", line) for line in other[1:])]


# ---------------------------------------------------------------- kernels

HASWELL = {"blas": ["openblas 0.3.31 Haswell"], "cpu": "X86_V3"}
OTHER_KERNELS: list[tuple[dict[str, Any], str]] = [
    (HASWELL, ""),
    (
        {**HASWELL, "blas": ["openblas 0.3.31 SkylakeX"]},
        "Made with another kernel:\n"
        "  A openblas 0.3.31 Haswell; NumPy X86_V3\n"
        "  B openblas 0.3.31 SkylakeX; NumPy X86_V3\n",
    ),
    (
        {**HASWELL, "cpu": ""},
        "Made with another kernel:\n"
        "  A openblas 0.3.31 Haswell; NumPy X86_V3\n"
        "  B openblas 0.3.31 Haswell; NumPy baseline\n",
    ),
    # a manifest made before manifests named the kernel
    (
        {"cpu": "X86_V3"},
        "Perhaps made with another kernel:\n"
        "  A openblas 0.3.31 Haswell; NumPy X86_V3\n"
        "  B BLAS unknown; NumPy X86_V3\n",
    ),
]


def with_kernels(release: Path, folder: Path, kernels: dict[str, Any]) -> Path:
    """A copy of a release whose manifest names these kernels."""
    copied = shutil.copytree(release, folder)
    environment = read_manifest(release)[0].made_from.environment.model_dump(exclude={"blas"})
    alter_file(copied, "environment.json", canonical_json({**environment, **kernels}).encode())
    return copied


@pytest.mark.slow
@pytest.mark.parametrize(("kernels", "sentence"), OTHER_KERNELS)
def test_another_kernel_is_named_with_the_differences_that_it_makes(
    release: Path,
    tmp_path: Path,
    kernels: dict[str, Any],
    sentence: str,
    capsys: pytest.CaptureFixture[str],
) -> None:
    one = with_kernels(release, tmp_path / "one", HASWELL)
    two = with_kernels(release, tmp_path / "two", kernels)
    assert main(["diff", str(one), str(two), *CONFIG]) == 0
    printed = capsys.readouterr().out
    _, names, *rest = re.split(r"(A .*\nB .*\n\n)", printed, maxsplit=1)
    assert names
    assert rest[0].startswith(sentence or "no difference")
    expected = "Differences of up to 1e-06 standard errors are expected; of verdicts, none."
    assert (expected in printed) == bool(sentence)


def test_manifest_without_kernels_is_read_as_it_was_written(release: Path, tmp_path: Path) -> None:
    old = with_kernels(release, tmp_path / "old", {"cpu": "X86_V3"})
    environment = read_manifest(old)[0].made_from.environment
    assert environment.blas is None
    assert "blas" not in (old / "environment.json").read_text(encoding="utf-8")


@pytest.mark.parametrize("blas", [[], [""] * 21, ["x" * 201], "openblas", [1], None])
def test_kernels_that_no_release_names_are_refused(
    release: Path, tmp_path: Path, blas: Any, capsys: pytest.CaptureFixture[str]
) -> None:
    named = with_kernels(release, tmp_path / "named", HASWELL)
    path = named / "manifest.json"
    content = json.loads(path.read_text(encoding="utf-8"))
    content["made_from"]["environment"]["blas"] = blas
    path.chmod(0o644)
    path.write_text(canonical_json(content), encoding="utf-8")
    assert main(["verify", str(named)]) == 2
    printed = capsys.readouterr().err
    assert "manifest.json: " in printed
    assert len(printed) < 2000
