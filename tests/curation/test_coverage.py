"""Coverage and gate counts lose nothing."""

from typing import Any

import numpy as np
import pandas as pd
import pytest

from campaigns import Campaign, without
from oilfilm import tables
from oilfilm.curation.coverage import coverage, gate_counts, planned_states
from oilfilm.tables import failed_gates
from oilfilm.tables.set_points import describe_condition


def condition(covered: pd.DataFrame, oil: str, *levels: float) -> dict[str, Any]:
    names = ("max_hertz_pressure_gpa", "entrainment_speed_m_s", "inlet_temperature_c")
    rows = covered[covered["oil"] == oil]
    for name, level in zip(names, levels, strict=True):
        rows = rows[np.isclose(rows[f"nominal_{name}"], level)]
    (row,) = rows.to_dict("records")
    return row


@pytest.mark.slow
@pytest.mark.parametrize("name", ["demo", "etm"])
def test_no_run_and_no_point_is_lost(name: str, request: pytest.FixtureRequest) -> None:
    campaign: Campaign = request.getfixturevalue(name)
    covered = coverage(campaign.curated.runs, campaign.config)
    counted = covered.filter(regex="^(runs|points)_").sum().to_dict()
    for what, accepted in (
        ("runs", campaign.curated.runs["verdict"] == "accepted"),
        ("points", campaign.curated.points["accepted"]),
    ):
        assert counted[f"{what}_accepted"] == accepted.sum()
        assert counted[f"{what}_refused"] == (~accepted).sum()


def test_planted_defects_are_where_they_were_planted(demo: Campaign) -> None:
    covered = coverage(demo.curated.runs, demo.config)
    # two of the defects of config/campaigns/demo.yaml, one of them outside the matrix
    for *at, planned in (("4102", 1.25, 30, 70, True), ("4010", 1.5, 12, 120, False)):
        row = condition(covered, *at)
        assert (row["state"], row["planned"]) == ("refused", planned)
    twice = condition(covered, "4050", 1.25, 30, 70)
    assert (twice["state"], twice["runs_accepted"], twice["runs_refused"]) == ("accepted", 1, 1)
    assert covered["state"].value_counts().to_dict() == {"accepted": 212, "refused": 5}
    assert len(planned_states(covered)) == 216


def test_planned_condition_without_a_run_is_missing(demo: Campaign) -> None:
    runs = demo.curated.runs
    covered = coverage(runs[runs["run_id"] != "4102_P1.25_U35_T085.csv"], demo.config)
    row = condition(covered, "4102", 1.25, 35, 85)
    assert (row["state"], row["planned"], row["rig"]) == ("missing", True, "ball-on-disc-20mm")
    assert (covered["state"] == "missing").sum() == 1
    assert describe_condition(row) == "P = 1.25 GPa, U = 35 m/s, T = 85 degC"
    planned = coverage(tables.empty_table("runs"), demo.config)
    assert planned["state"].tolist() == ["missing"] * 216


@pytest.mark.parametrize(
    ("column", "factor", "shift"),
    [
        ("nominal_entrainment_speed_m_s", 1 + 1e-9, 0.0),  # a unit's round trip
        ("nominal_entrainment_speed_m_s", 1.004, 0.0),  # rounded to three digits
        ("nominal_inlet_temperature_c", 1.0, 0.4),  # rounded to a degree
    ],
)
def test_notes_join_one_condition(demo: Campaign, column: str, factor: float, shift: float) -> None:
    runs = demo.curated.runs.copy()
    runs.loc[::2, column] = runs[column] * factor + shift
    for settings in (demo.config, without(demo.config, "matrix")):
        covered = coverage(runs, settings)
        assert len(covered) == 217
        assert not (covered["state"] == "missing").any()


def test_load_set_point_covers_the_pressure_of_the_matrix(demo: Campaign) -> None:
    runs = demo.curated.runs.assign(nominal_max_hertz_pressure_gpa=np.nan)
    runs["nominal_load_n"] = runs["nominal_load_n"].round(1)
    covered = coverage(runs, demo.config)
    assert not (covered["state"] == "missing").any()
    assert covered["nominal_load_n"].isna().all()


def test_gates_count_every_refused_run_and_row_once(demo: Campaign) -> None:
    curated = demo.curated
    counts = gate_counts(curated.runs, curated.points, curated.quarantine)
    assert counts["runs_refused"].sum() == (curated.runs["verdict"] == "refused").sum()
    assert counts["rows"].sum() == curated.quarantine["refused_rows"].sum()
    assert counts["points"].sum() == len(failed_gates.one_row_per_gate(curated.points))
    assert counts.set_index("gate").at["stuck_sensor", "points"] == 31
    runs = {"duplicate_condition", "stuck_sensor", "swapped_sign", "truncated"}
    assert set(counts.loc[counts["what"] == "run", "gate"]) == runs
    assert counts.loc[counts["what"] == "rows", "gate"].tolist() == ["cut_row"]
    assert {"load_off_nominal", "thin_film"} <= set(counts.loc[counts["what"] == "point", "gate"])
