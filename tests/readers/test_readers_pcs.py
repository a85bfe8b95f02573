"""PCS exports: the real logs with their known defects, and damaged copies of a small one."""

from pathlib import Path

import numpy as np
import pytest

from bad_logs import PCS_CONFIG, PCS_ROW, PCS_TABLE, pcs
from campaigns import Campaign, without
from oilfilm.curation.curate import check_logs, curate
from oilfilm.readers.base import Reading
from oilfilm.readers.ingest import read_log

# docs/physics.md, PCS logs: rows where one force direction had not reversed
HALF_REVERSED_STEPS = [
    28, 60, 65, 91, 100, 134, 161, 165, 220, 281, 296, 344, 367, 389, 398, 454, 489, 509,
]  # fmt: skip


def read(content: bytes) -> Reading:
    return read_log(content, "log.txt", PCS_CONFIG)[1]


def test_real_etm_log_keeps_every_row_or_lists_it(etm: Campaign) -> None:
    # 20 560 data rows: 500 sweeps of 41 and one timed step of 60 (docs/physics.md, PCS logs)
    (samples,) = etm.ingested.samples.values()
    assert (len(etm.ingested.runs), len(samples)) == (500, 20_500)
    assert len(samples) + etm.curated.quarantine["refused_rows"].sum() == 20_560
    timed = etm.curated.quarantine.query("rule == 'not_a_sweep'")
    assert timed["refused_rows"].tolist() == [60]


def test_step_dated_after_the_next_one_is_flagged(etm: Campaign) -> None:
    misdated = etm.curated.quarantine.query("rule == 'misdated_step'")
    assert len(misdated) == 1
    assert "step 1 is dated 10/05/2019" in misdated["reason"].iloc[0]


def test_exactly_the_half_reversed_rows_are_refused_as_such(etm: Campaign) -> None:
    points = etm.curated.points
    refused = points[points["failed_gates"].str.contains("force_not_reversed")]
    steps = refused["run_id"].str.extract(r"step(\d+)")[0].astype(int)
    assert steps.tolist() == HALF_REVERSED_STEPS


def test_speed_spike_is_refused_and_nothing_else(etm: Campaign) -> None:
    points = etm.curated.points
    spike = points[points["failed_gates"].str.contains("speed_off_nominal|slip_out_of_range")]
    assert spike["run_id"].tolist() == ["ETM_slim_mapper.txt:step161"]
    assert spike["time_s"].tolist() == [154.0]
    assert spike["slide_roll_ratio"].iloc[0] == pytest.approx(-0.278, abs=5e-4)
    assert (~points["accepted"]).sum() == len(HALF_REVERSED_STEPS)


def test_film_of_unrecorded_geometry_is_not_judged_and_the_campaign_says_why(
    etm: Campaign,
) -> None:
    assert (etm.curated.points["film_judgement"] == "cannot be judged").all()
    assert etm.curated.points["lambda_ratio"].isna().all()
    assert etm.config.campaign.film_unjudged.reason


def test_without_the_switch_no_point_of_unjudged_film_passes(etm: Campaign) -> None:
    (samples,) = etm.ingested.samples.values()
    strict = curate(samples, etm.ingested.runs, without(etm.config, "film_unjudged"))
    assert not strict.points["accepted"].any()
    assert strict.points["failed_gates"].str.contains("film_not_judged").all()
    assert (strict.runs["verdict"] == "refused").all()


def test_real_ehd_log_confirms_the_speed_exponent_of_the_film(real_pcs: Path) -> None:
    content = (real_pcs / "demo_12.txt").read_bytes()
    reading = read_log(content, "demo_12.txt", PCS_CONFIG)[1]
    assert reading.rows == 94
    assert len(reading.runs) == 3  # 40, 60 and 80 degC
    slopes = []
    for run in reading.runs:
        film = run.samples["measured_film_thickness_um"]
        speed = (run.samples["ball_speed_m_s"] + run.samples["disc_speed_m_s"]) / 2
        # at 80 degC seven rows have the wrong fringe order (228-251 nm); films of a few nm are
        # within the method's own error of 1-2 nm
        good = (film < 0.2) & (film > 0.008)
        slopes.append(np.polyfit(np.log(speed[good]), np.log(film[good]), 1)[0])
    # docs/physics.md, PCS logs: 0.74, 0.72, 0.78
    np.testing.assert_allclose(slopes, [0.74, 0.72, 0.78], atol=0.01)


def test_good_row_becomes_a_sample() -> None:
    (run,) = read(pcs(PCS_ROW)).runs
    sample = {name: values[0] for name, values in run.samples.items()}
    assert sample["ball_speed_m_s"] == pytest.approx(0.0225)
    assert sample["disc_speed_m_s"] == pytest.approx(0.0275)
    assert sample["traction_force_n"] == 50
    assert run.kind == "steps"


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


HALF_A_ROW = "\t".join(PCS_ROW.split("\t")[:2])


@pytest.mark.parametrize(
    ("log", "rows"),
    [
        (pcs(PCS_ROW, PCS_ROW).partition(b"0\n\nAll")[0], 2),
        (pcs(PCS_ROW, HALF_A_ROW, PCS_ROW), 3),
    ],
)
def test_cut_row_is_counted_and_refused(log: bytes, rows: int) -> None:
    reading = read(log)
    assert reading.rows == rows
    assert [(r.rule, r.first_row) for r in reading.refusals] == [("unreadable_row", 2)]


def test_degree_sign_of_western_windows_is_understood() -> None:
    content = pcs(PCS_ROW).decode().replace("Lube RTD Temp (degC)", "Lube Temp (°C)")
    (run,) = read(content.encode("cp1252")).runs
    assert np.isfinite(run.samples["inlet_temperature_c"]).all()


def test_table_without_its_line_of_names_is_refused_row_by_row(real_pcs: Path) -> None:
    content = (real_pcs / "ETM_slim_mapper.txt").read_bytes()
    lines = content.split(b"\n")
    names = [number for number, line in enumerate(lines) if b"Step Time (s)" in line]
    starts = [number for number, line in enumerate(lines) if b" started at " in line]
    for damaged in (names[5], next(start for start in starts if start > names[5])):
        spoiled = b"\n".join([*lines[:damaged], b"#?", *lines[damaged + 1 :]])
        reading = read_log(spoiled, "log", PCS_CONFIG)[1]
        assert reading.rows == 20_560  # docs/physics.md, PCS logs
        rows = np.concatenate([run.samples["row"] for run in reading.runs])
        assert len(np.unique(rows)) == len(rows)


def test_export_without_a_temperature_is_judged_by_the_other_gates() -> None:
    rows = [PCS_ROW.replace("\t6\t", f"\t{6 * step}\t") for step in range(1, 9)]
    table = PCS_TABLE.replace("Lube RTD Temp (degC)", "Room")
    verdict = check_logs([("log", pcs(*rows, table=table))], PCS_CONFIG)
    assert verdict.runs["reason"].tolist() == [""]
    assert verdict.points["inlet_temperature_c"].isna().all()
