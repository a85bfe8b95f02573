"""The measured curves that ship in data/raw/etm-slim, with the defects that its README lists."""

import numpy as np
import pytest

from campaigns import Campaign, without
from oilfilm.curation.curate import curate_samples
from oilfilm.curation.traction_rig import TractionRig
from oilfilm.tables.failed_gates import failed_any_of
from pcs_exports import shipped_numbers

# docs/physics.md, PCS logs: rows where one force direction had not reversed
HALF_REVERSED_STEPS = [
    28, 60, 65, 91, 100, 134, 161, 165, 220, 281, 296, 344, 367, 389, 398, 454, 489, 509,
]  # fmt: skip


def test_every_measured_row_is_kept_or_listed(etm: Campaign) -> None:
    # 20 560 data rows: 500 sweeps of 41 and one timed step of 60 (docs/physics.md, PCS logs)
    (samples,) = etm.ingested.samples_of_oil.values()
    assert (len(etm.ingested.runs), len(samples)) == (500, 20_500)
    assert set(etm.ingested.runs["log_kind"]) == {"steps"}
    assert set(etm.ingested.runs["refused_rows"]) == {0}


def test_exactly_the_half_reversed_rows_are_refused(etm: Campaign) -> None:
    """By the ground truth of docs/physics.md, and by its description on the bare numbers."""
    points = etm.curated.points
    refused = points[~points["accepted"]]
    assert (len(refused), points["accepted"].sum()) == (18, 20_482)
    assert failed_any_of(refused, ["force_not_reversed"]).all()
    steps = refused["run_id"].str.extract(r"step(\d+)")[0].astype(int)
    assert steps.tolist() == HALF_REVERSED_STEPS
    step, time_s, slip, mu = shipped_numbers()
    described = (np.abs(slip) > 0.10) & (mu < 0.045)
    np.testing.assert_array_equal(step[described], steps)
    np.testing.assert_array_equal(time_s[described], refused["time_s"])


def test_force_is_half_the_difference_of_both_directions(etm: Campaign) -> None:
    # docs/physics.md, PCS logs: TF = (TF1 - TF2)/2, all three to 1e-4 N
    (samples,) = etm.ingested.samples_of_oil.values()
    half = (samples["traction_force_1_n"] - samples["traction_force_2_n"]) / 2
    np.testing.assert_allclose(samples["traction_force_n"], half, rtol=0, atol=1.001e-4)


def test_speed_spike_is_refused_and_nothing_else(etm: Campaign) -> None:
    points = etm.curated.points
    spike = points[failed_any_of(points, ["speed_off_nominal", "slip_out_of_range"])]
    assert spike["run_id"].tolist() == ["step161.csv.gz"]
    assert spike["time_s"].tolist() == [154.0]
    assert spike["slide_roll_ratio"].iloc[0] == pytest.approx(-0.278, abs=5e-4)


def test_without_the_switch_no_point_of_unjudged_film_passes(etm: Campaign) -> None:
    (samples,) = etm.ingested.samples_of_oil.values()
    runs = etm.ingested.runs.iloc[:20]
    samples = samples[samples["run_id"].isin(runs["run_id"])]
    strict = curate_samples(samples, runs, TractionRig(without(etm.config, "film_unjudged")))
    assert not strict.points["accepted"].any()
    assert failed_any_of(strict.points, ["film_not_judged"]).all()
    assert (strict.runs["verdict"] == "refused").all()
