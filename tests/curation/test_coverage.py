"""Coverage and gate counts lose nothing, and the map shows what the tables hold."""

from typing import Any

import numpy as np
import pandas as pd
import pytest

from campaigns import Campaign, without
from oilfilm import tables
from oilfilm.curation.coverage import coverage, describe_condition, gate_counts, planned_states
from oilfilm.report.figures import style
from oilfilm.settings.resolved import Settings
from oilfilm.tables import failed_gates
from oilfilm.tables.campaign_tables import CampaignTables
from pictures import draw


@pytest.fixture(scope="module")
def results(demo: Campaign) -> CampaignTables:
    curated = demo.curated
    covered = coverage(curated.runs, demo.config)
    return CampaignTables.in_memory(points=curated.points, runs=curated.runs, coverage=covered)


def condition(covered: pd.DataFrame, oil: str, *levels: float) -> dict[str, Any]:
    names = ("max_hertz_pressure_gpa", "entrainment_speed_m_s", "inlet_temperature_c")
    rows = covered[covered["oil"] == oil]
    for name, level in zip(names, levels, strict=True):
        rows = rows[np.isclose(rows[f"nominal_{name}"], level)]
    (row,) = rows.to_dict("records")
    return row


def map_of(covered: pd.DataFrame, config: Settings) -> tuple[Any, pd.DataFrame, str]:
    figure, cells = draw("coverage", CampaignTables.in_memory(coverage=covered), config)
    figure.canvas.draw()
    texts = [each.get_text() for axis in figure.axes for each in axis.texts]
    return figure, cells, " ".join(texts)


def test_no_run_and_no_point_is_lost(demo: Campaign, etm: Campaign) -> None:
    for campaign in (demo, etm):
        covered = coverage(campaign.curated.runs, campaign.config)
        runs, points = campaign.curated.runs, campaign.curated.points
        assert covered["runs_accepted"].sum() == (runs["verdict"] == "accepted").sum()
        assert covered["runs_refused"].sum() == (runs["verdict"] == "refused").sum()
        assert covered["points_accepted"].sum() == points["accepted"].sum()
        assert covered["points_refused"].sum() == (~points["accepted"]).sum()


def test_planted_defects_are_where_they_were_planted(results: CampaignTables) -> None:
    # the defects of config/campaigns/demo.yaml
    refused = [
        ("4102", 1.25, 30, 70),
        ("4102", 1.0, 25, 50),
        ("4050", 1.5, 35, 85),
        ("4010", 1.0, 40, 100),
    ]
    for at in refused:
        row = condition(results.coverage, *at)
        assert (row["state"], row["planned"]) == ("refused", True)
    outside = condition(results.coverage, "4010", 1.5, 12, 120)
    assert (outside["state"], outside["planned"]) == ("refused", False)
    twice = condition(results.coverage, "4050", 1.25, 30, 70)
    assert (twice["state"], twice["runs_accepted"], twice["runs_refused"]) == ("accepted", 1, 1)
    assert results.coverage["state"].value_counts().to_dict() == {"accepted": 212, "refused": 5}
    assert len(planned_states(results.coverage)) == 216


def test_run_that_was_never_made_is_missing(demo: Campaign, results: CampaignTables) -> None:
    runs = demo.curated.runs
    covered = coverage(runs[runs["run_id"] != "4102_P1.25_U35_T085.csv"], demo.config)
    row = condition(covered, "4102", 1.25, 35, 85)
    assert (row["state"], row["planned"], row["rig"]) == ("missing", True, "ball-on-disc-20mm")
    assert (covered["state"] == "missing").sum() == 1
    assert describe_condition(row) == "P = 1.25 GPa, U = 35 m/s, T = 85 degC"


def test_nothing_is_missing_without_a_matrix(demo: Campaign) -> None:
    covered = coverage(demo.curated.runs.iloc[:5], without(demo.config, "matrix"))
    assert set(covered["state"]) <= {"accepted", "refused"}
    assert not covered["planned"].any()
    assert covered["runs_accepted"].sum() + covered["runs_refused"].sum() == 5
    planned = coverage(tables.empty("runs"), demo.config)
    assert (planned["state"] == "missing").sum() == len(planned) == 216


@pytest.mark.parametrize(
    ("column", "factor", "shift"),
    [
        ("nominal_entrainment_speed_m_s", 1 + 1e-9, 0.0),  # a unit's round trip
        ("nominal_entrainment_speed_m_s", 1.004, 0.0),  # rounded to three digits
        ("nominal_inlet_temperature_c", 1.0, 0.4),  # rounded to a degree
    ],
)
def test_notes_of_one_set_point_are_one_condition(
    demo: Campaign, column: str, factor: float, shift: float
) -> None:
    runs = demo.curated.runs.copy()
    runs.loc[::2, column] = runs[column] * factor + shift
    covered = coverage(runs, demo.config)
    assert len(covered) == 217
    assert not (covered["state"] == "missing").any()
    free = coverage(runs, without(demo.config, "matrix"))
    assert len(free) == 217


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
    names = failed_gates.one_row_per_gate(curated.points)
    assert counts["points"].sum() == len(names)
    assert counts.set_index("gate").at["stuck_sensor", "points"] == 31
    assert {what: set(gates) for what, gates in counts.groupby("what")["gate"]} == {
        "run": {"duplicate_condition", "stuck_sensor", "swapped_sign", "truncated"},
        "point": {
            "load_off_nominal",
            "not_steady",
            "thin_film",
            "traction_missing",
            "traction_unphysical",
            "transient_not_ended",
        },
        "rows": {"cut_row"},
    }


def test_map_draws_each_condition_once_with_symbol_and_numbers(
    demo: Campaign, results: CampaignTables
) -> None:
    figure, cells, text = map_of(results.coverage, demo.config)
    assert len(cells) == 217
    assert text.split().count("0/1") == 5
    assert text.split().count("1/2") == 1
    for state, count in (("refused", 5), ("accepted", 212)):
        marker = style.STATE_MARKERS[state]
        lines = [line for axis in figure.axes for line in axis.get_lines()]
        assert sum(len(at.get_xdata()) for at in lines if at.get_marker() == marker) == count
    assert figure.get_figwidth() == pytest.approx(style.DOUBLE_COLUMN_IN)
