"""What simulated torque can show, and what the claims on torque make of it."""

from typing import Any

import numpy as np
import pandas as pd
import pytest

from campaigns import ROOT, printed
from claim_evidence import claims_of, evidence_of
from oilfilm import tables
from oilfilm.paper.audit.audit import audit
from oilfilm.settings.resolve import resolve
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.torque.torque_control import torque_control
from reports import rows


def settings_of(campaign: str) -> Settings:
    return resolve(ROOT / "config", {"campaign": campaign})


def results(misfit: float = 0.0, law: str = "deng2026", **changed: Any) -> CampaignTables:
    """Errors of the torque of 4102: 1 and 2 % by stress, 60 % by load."""
    errors = [("stress", 0.01), ("stress", -0.02), ("load", 0.6), ("load", 0.6)]
    frames: dict[str, pd.DataFrame] = {
        "torque": rows(
            "torque",
            *(
                {
                    **{"oil": "4102", "run_id": f"{row % 2}", "axial_load_n": 5000.0},
                    **{"inner_speed_rpm": 12000.0, "inlet_temperature_c": 100.0},
                    **{"load_variable": by, "relative_error": e},
                }
                for row, (by, e) in enumerate(errors)
            ),
        ),
        "torque_truth": rows("torque_truth", {"oil": "4102", "law_misfit": misfit}),
        "fit_quality": rows("fit_quality", {"oil": "4102", "law": law, "configured": True}),
    }
    return CampaignTables.in_memory(**frames | changed)


def judged(results: CampaignTables, settings: Settings) -> dict[str, pd.DataFrame]:
    control = torque_control(results, settings)
    evidence = evidence_of(printed(), settings, torque=results.torque, torque_control=control)
    return audit(claims_of("torque-stress", "torque-load"), [evidence])


def verdicts(results: CampaignTables, settings: Settings) -> pd.DataFrame:
    """Rows of the claims on torque."""
    return judged(results, settings)["claims"].set_index("claim")


@pytest.mark.parametrize(
    ("campaign", "law", "misfit", "verdict"),
    [
        ("demo", "deng2026", 0.0, "positive control"),
        ("demo", "tanh", 0.0, "one truth"),  # another law is fitted than the one behind the logs
        ("thermal", "deng2026", 0.001, "one truth"),
        ("thermal", "deng2026", 0.4, "two truths"),
        ("demo", "deng2026", 0.4, "two truths"),
    ],
)
def test_only_the_fitted_law_behind_both_rigs_is_a_positive_control(
    campaign: str, law: str, misfit: float, verdict: str
) -> None:
    control = torque_control(results(misfit, law), settings_of(campaign))
    assert list(control["verdict"]) == [verdict]
    assert control["median_torque_error"].iloc[0] == pytest.approx(0.015)
    assert control["largest_torque_error"].iloc[0] == pytest.approx(0.02)
    assert control["n_plateaus"].iloc[0] == 2


def test_measured_torque_has_no_control_and_its_claims_are_judged() -> None:
    settings = settings_of("demo")
    measured = results().replace(torque_truth=tables.empty("torque_truth"))
    assert torque_control(measured, settings).empty
    assert list(verdicts(measured, settings)["verdict"]) == ["holds", "holds in part"]


def test_limit_of_the_configuration_decides_which_truths_are_two() -> None:
    thermal = settings_of("thermal")
    loose = thermal.with_changes({"audit": {"twin_misfit_max": 0.5}})
    apart = results(misfit=0.4)
    assert set(verdicts(apart, loose)["verdict"]) == {"holds", "holds in part"}
    refused = verdicts(apart, thermal)
    assert set(refused["verdict"]) == {"cannot be checked"}
    assert set(refused["reason_code"]) == {"two truths"}


def test_claims_on_torque_are_not_confirmed_by_the_law_that_made_it() -> None:
    refused = verdicts(results(), settings_of("demo"))
    assert set(refused["verdict"]) == {"cannot be checked"}
    assert set(refused["reason_code"]) == {"positive control"}
    assert refused["share"].isna().all()


def test_points_where_the_cage_may_roll_or_skid_are_not_averaged_in() -> None:
    settings = settings_of("thermal")
    plain = results(0.001)
    skids = plain.torque.assign(bistable=plain.torque["run_id"] == "1")
    control = torque_control(plain.replace(torque=skids), settings)
    assert control["n_plateaus"].iloc[0] == 1
    assert control["largest_torque_error"].iloc[0] == pytest.approx(0.01)
    made = judged(plain.replace(torque=skids), settings)
    assert made["claims"]["cases"].tolist() == [1, 1]
    left_out = made["claim_numbers"].query("number == 'bistable'")
    assert left_out.set_index("claim")["value"].to_dict() == {"torque-stress": 1, "torque-load": 1}


def test_control_without_a_calculated_torque_has_no_error() -> None:
    empty = results(torque=tables.empty("torque"))
    control = torque_control(empty, settings_of("demo"))
    assert np.isnan(control["largest_torque_error"]).all()
