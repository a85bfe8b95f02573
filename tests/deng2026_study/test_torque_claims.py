"""What simulated torque can show, and what the claims on torque make of it."""

from typing import Any

import pandas as pd
import pytest
from claim_evidence import claims_of, evidence_of

from campaigns import ROOT, printed
from deng2026_study.audit.audit import audit
from oilfilm import tables
from oilfilm.settings.resolve import resolve
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.torque.torque_control import torque_control_table
from reports import rows


def settings_of(campaign: str) -> Settings:
    return resolve(ROOT / "config", {"campaign": campaign})


def results(misfit: float = 0.0, law: str = "deng2026", **changed: Any) -> CampaignTables:
    """Errors of the torque of 4102: 1 and 2 % by stress, 60 % by load."""
    errors = [("stress", 0.01), ("stress", -0.02), ("load", 0.6), ("load", 0.6)]
    point = {"oil": "4102", "axial_load_n": 5e3, "inner_speed_rpm": 1.2e4}
    frames: dict[str, pd.DataFrame] = {
        "torque": rows(
            "torque",
            *(
                point | {"run_id": f"{row % 2}", "load_variable": by, "relative_error": error}
                for row, (by, error) in enumerate(errors)
            ),
        ),
        "torque_truth": rows("torque_truth", {"oil": "4102", "law_misfit": misfit}),
        "fit_quality": rows("fit_quality", {"oil": "4102", "law": law, "configured": True}),
    }
    return CampaignTables.from_frames(**frames | changed)


def judged(results: CampaignTables, settings: Settings) -> dict[str, pd.DataFrame]:
    control = torque_control_table(results, settings)
    evidence = evidence_of(printed(), settings, torque=results.torque, torque_control=control)
    return audit(claims_of("torque-stress", "torque-load"), [evidence])


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
def test_one_law_is_a_positive_control(
    campaign: str, law: str, misfit: float, verdict: str
) -> None:
    control = torque_control_table(results(misfit, law), settings_of(campaign))
    assert list(control["verdict"]) == [verdict]


@pytest.mark.parametrize(
    ("campaign", "misfit", "limit", "reason"),
    [
        ("thermal", 0.4, 0.05, "two truths"),
        ("thermal", 0.4, 0.5, ""),  # the limit of the configuration decides
        ("demo", 0.0, 0.05, "positive control"),  # the law that made the torque confirms nothing
        ("demo", None, 0.05, ""),  # measured torque has no control
    ],
)
def test_claims_on_torque_are_judged_where_nothing_but_the_law_is_compared(
    campaign: str, misfit: float | None, limit: float, reason: str
) -> None:
    settings = settings_of(campaign).with_changes({"torque_logs": {"twin_misfit_max": limit}})
    campaign_results = results(misfit or 0.0)
    if misfit is None:
        campaign_results = campaign_results.replace(torque_truth=tables.empty_table("torque_truth"))
        assert torque_control_table(campaign_results, settings).empty
    claims = judged(campaign_results, settings)["claims"]
    assert set(claims["reason_code"]) == {reason}
    unchecked = ["cannot be checked"] * 2
    assert claims["verdict"].tolist() == (unchecked if reason else ["holds", "holds in part"])
    assert claims["share"].isna().all() == bool(reason)


def test_points_where_the_cage_may_roll_or_skid_are_not_averaged_in() -> None:
    settings = settings_of("thermal")
    plain = results(0.001)
    skids = plain.torque.assign(bistable=plain.torque["run_id"] == "1")
    campaign_results = judged(plain.replace(torque=skids), settings)
    assert campaign_results["claims"]["cases"].tolist() == [1, 1]
    left_out = campaign_results["claim_numbers"].query("number == 'bistable'")
    assert left_out.set_index("claim")["value"].to_dict() == {"torque-stress": 1, "torque-load": 1}


def test_claims_on_torque_count_the_plateaus_of_which_the_motion_is_not_known() -> None:
    plain = results(0.001)
    flags = plain.torque["bistable"].astype(object).mask(plain.torque["run_id"] == "1", None)
    campaign_results = judged(
        plain.replace(torque=plain.torque.assign(bistable=flags)), settings_of("thermal")
    )
    assert campaign_results["claims"]["cases"].tolist() == [2, 2]
    numbers = campaign_results["claim_numbers"].set_index(["claim", "number"])["value"]
    assert numbers["torque-stress", "undecided"] == 1
    assert "bistable" not in numbers["torque-stress"]
