"""PCS exports: of measured curves and planted films, as published, and with damaged rows."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import formats
from bad_logs import CONFIG, PCS_CONFIG, PCS_ROW, PCS_TABLE, pcs
from campaigns import ETM, ROOT, Campaign, carry_logs
from oilfilm.curation.curate import curate_logs
from oilfilm.logs.base import ParsedLog
from oilfilm.logs.ingest import read_log
from oilfilm.settings.resolve import resolve
from oilfilm.tables.failed_gates import failed_any_of
from pcs_exports import FILM_EXPONENT, WRONG_ORDERS, film_export, shipped_steps, traction_export


def read(content: bytes) -> ParsedLog:
    return read_log(content, "log.txt", PCS_CONFIG)[1]


STEPS = shipped_steps()[:42]


@pytest.fixture(scope="module")
def exported() -> Campaign:
    """Measured curves as an ETM exports them, curated: a mapping, a timed step and 40 sweeps."""
    return carried(traction_export(STEPS))


def carried(content: bytes) -> Campaign:
    return carry_logs(PCS_CONFIG, [("export.txt", content)])


def assert_same_curves(export: Campaign, shipped: Campaign) -> None:
    """Curation finds the same points in the export and in its csv form."""

    def by_step(points: pd.DataFrame) -> pd.DataFrame:
        step = points["run_id"].astype(str).str.extract(r"step(\d+)")[0].astype(int)
        rows = ["run_id", "first_row", "last_row"]  # an export counts through
        ordered = points.assign(step=step).sort_values(["step", "first_row"], ignore_index=True)
        return ordered.drop(columns=rows)

    of_export, of_csv = (by_step(each.curated.points) for each in (export, shipped))
    # mm/s become m/s in another order of operations: the last bits may differ
    pd.testing.assert_frame_equal(of_export, of_csv, rtol=1e-12, atol=1e-15)


def test_export_keeps_every_row_or_lists_it(exported: Campaign) -> None:
    # sweeps of 41 rows and one timed step of 60 (docs/physics.md, PCS logs)
    (samples,) = exported.ingested.samples_of_oil.values()
    assert (len(exported.ingested.runs), len(samples)) == (40, 40 * 41)
    timed = exported.curated.quarantine.query("rule == 'not_a_sweep'")
    assert timed["refused_rows"].tolist() == [60]


def test_export_and_csv_of_the_same_readings_give_the_same_points(exported: Campaign) -> None:
    files = [ETM / f"step{number:03d}.csv.gz" for number in STEPS]
    logs = [(path.name, path.read_bytes()) for path in files]
    settings = resolve(ROOT / "config", {"campaign": "etm-slim"})
    assert_same_curves(exported, carry_logs(settings, logs))


@pytest.mark.nightly
def test_export_as_published_gives_the_points_of_its_csv(real_pcs: Path, etm: Campaign) -> None:
    published = carried((real_pcs / "ETM_slim_mapper.txt").read_bytes())
    assert_same_curves(published, etm)
    # 20 560 data rows: 500 sweeps of 41 and one timed step of 60
    assert sum(map(len, published.ingested.samples_of_oil.values())) == 20_500
    listed = published.curated.quarantine
    assert sorted(listed["rule"]) == ["not_a_sweep"]
    assert listed["refused_rows"].sum() == 60


def film_slopes(reading: ParsedLog, thickest_um: float) -> list[float]:
    """Slopes d ln h/d ln U of each step, films of a few nm and of a wrong order left out."""
    slopes = []
    for run in reading.runs:
        film = run.samples["measured_film_thickness_um"]
        speed = (run.samples["ball_speed_m_s"] + run.samples["disc_speed_m_s"]) / 2
        good = (film < thickest_um) & (film > 0.008)
        slopes.append(float(np.polyfit(np.log(speed[good]), np.log(film[good]), 1)[0]))
    return slopes


def test_films_of_an_export_keep_their_planted_exponent() -> None:
    reading = read(film_export())
    assert [len(run) for run in reading.runs] == [31, 31, 31]  # 40, 60 and 80 degC
    *sound, wrong_orders = film_slopes(reading, 1.0)
    np.testing.assert_allclose(sound, FILM_EXPONENT, atol=0.002)
    assert abs(wrong_orders - FILM_EXPONENT) > 0.05


def test_films_of_a_wrong_fringe_order_are_found_in_an_export() -> None:
    points = carried(film_export()).curated.points
    off = failed_any_of(points, ["film_off_trend"]).to_numpy()
    expected = np.zeros(93, dtype=bool)
    expected[62:][WRONG_ORDERS] = True
    np.testing.assert_array_equal(off, expected)


def test_film_export_as_published_has_its_slopes_and_its_wrong_orders(real_pcs: Path) -> None:
    content = (real_pcs / "demo_12.txt").read_bytes()
    reading = read(content)
    assert reading.row_count == 94
    # docs/physics.md, PCS logs: slopes at 40, 60, 80 degC; seven wrong orders, 228 to 251 nm
    np.testing.assert_allclose(film_slopes(reading, 0.2), [0.74, 0.72, 0.78], atol=0.01)
    points = carried(content).curated.points
    off = points[failed_any_of(points, ["film_off_trend"])]
    assert len(off) == 7
    assert off["measured_film_thickness_um"].between(0.228, 0.252).all()


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("50.0000\t0.0500", "60.0000\t0.0600"),  # TF is not (TF1 - TF2)/2
        ("50.0000\t0.0500", "50.0000\t0.0700"),  # coefficient is not |TF|/W
        ("25.00\t5.00", "26.00\t5.00"),  # rolling speed is not the mean
        ("25.00\t5.00", "25.00\t6.00"),  # sliding speed is not the difference
        ("5.00\t20.000", "5.00\t22.000"),  # SRR is not 100 sliding/rolling
    ],
)
def test_row_that_contradicts_itself_is_refused(old: str, new: str) -> None:
    assert old in PCS_ROW
    reading = read(pcs(PCS_ROW, PCS_ROW.replace(old, new), PCS_ROW))
    (refusal,) = reading.refusals
    assert (refusal.rule, refusal.first_row, refusal.last_row) == ("identity_broken", 2, 2)
    assert reading.runs[0].samples["row"].tolist() == [1, 3]


@pytest.mark.parametrize(
    ("forces", "is_refused"),
    [("1.23\t-1.24\t1.24\t0.0413", False), ("1.23\t-1.24\t1.26\t0.0420", True)],
)
def test_row_with_fewer_digits_agrees_to_its_own_rounding(forces: str, is_refused: bool) -> None:
    row = PCS_ROW.replace("50.0000\t-50.0000\t50.0000\t0.0500", forces)
    row = row.replace("\t1000.000\t", "\t30.0\t")
    reading = read(pcs(row, row, row))
    assert [refusal.rule for refusal in reading.refusals] == ["identity_broken"] * is_refused


def test_blank_column_does_not_loosen_the_comparison_of_a_row_with_itself() -> None:
    cells = PCS_ROW.split("\t")
    one_way = "\t".join([*cells[:5], "", cells[6], "", *cells[8:]])
    assert read(pcs(one_way, one_way)).refusals == []
    (refusal,) = read(pcs(one_way, one_way.replace("25.00\t5.00", "25.05\t5.00"))).refusals
    assert (refusal.rule, refusal.first_row) == ("identity_broken", 2)


@pytest.mark.parametrize("title", ["# Traction Test Data File", "Test Data File of rig 7"])
@pytest.mark.parametrize("delimiter", [",", ";", "\t"])
def test_table_with_the_title_of_a_pcs_file_is_a_csv_log(title: str, delimiter: str) -> None:
    content = formats.csv(formats.columns(40)).replace(b",", delimiter.encode())
    reader, reading = read_log(f"{title}\n".encode() + content, "log", CONFIG)
    assert (reader, len(reading.runs[0])) == ("csv", 40)


HALF_A_ROW = "\t".join(PCS_ROW.split("\t")[:2])


@pytest.mark.parametrize(
    ("log", "rows", "rule"),
    [
        (pcs(PCS_ROW, PCS_ROW).partition(b"0\n\nAll")[0], 2, "unterminated_row"),
        (pcs(PCS_ROW, PCS_ROW).rpartition(b"\t")[0], 2, "cut_row"),
        (pcs(PCS_ROW, HALF_A_ROW, PCS_ROW), 3, "unreadable_row"),
    ],
)
def test_cut_row_is_counted_and_refused(log: bytes, rows: int, rule: str) -> None:
    reading = read(log)
    assert reading.row_count == rows
    assert [(r.rule, r.first_row) for r in reading.refusals] == [(rule, 2)]


def test_row_cut_after_any_cell_is_refused_as_cut_where_names_repeat() -> None:
    blanks = 8 * "\t"
    table = f"SRR (%)\tTraction Coeff (-)\t{PCS_TABLE}{blanks}"
    row = f"20.000\t0.0500\t{PCS_ROW}{blanks}"
    cells = row.split("\t")
    for count in range(1, len(cells)):
        cut_row = "\t".join(cells[:count])
        log = pcs(row, cut_row, table=table).partition(b"\n\nAll")[0]
        assert [refusal.rule for refusal in read(log).refusals] == ["cut_row"], count


def test_table_without_its_line_of_names_is_refused_row_by_row() -> None:
    lines = traction_export(range(2, 13)).split(b"\n")
    names = [number for number, line in enumerate(lines) if b"Step Time (s)" in line]
    starts = [number for number, line in enumerate(lines) if b" started at " in line]
    for damaged in (names[5], next(start for start in starts if start > names[5])):
        spoiled = b"\n".join([*lines[:damaged], b"#?", *lines[damaged + 1 :]])
        reading = read_log(spoiled, "log", PCS_CONFIG)[1]
        assert reading.row_count == 60 + 10 * 41  # a timed step and ten sweeps
        rows = np.concatenate([run.samples["row"] for run in reading.runs])
        assert len(np.unique(rows)) == len(rows)


def test_export_without_a_temperature_is_judged_by_the_other_gates() -> None:
    rows = [PCS_ROW.replace("\t6\t", f"\t{6 * step}\t") for step in range(1, 9)]
    table = PCS_TABLE.replace("Lube RTD Temp (degC)", "Room")
    for set_point, celsius in (None, np.nan), (40.0, 40.0):
        changes = {"campaign": {"set_points": {"inlet_temperature_c": set_point}}}
        settings = PCS_CONFIG.with_changes(changes)
        verdict = curate_logs([("log", pcs(*rows, table=table))], settings)
        assert verdict.runs["reason"].tolist() == [""]
        # a set point stands for the column of settled readings
        np.testing.assert_array_equal(verdict.points["inlet_temperature_c"], 8 * [celsius])
