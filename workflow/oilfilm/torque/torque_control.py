"""What a comparison with SIMULATED torque can show: table `torque_control`.

Decides: what a comparison with simulated torque shows.
"""

import pandas as pd

from oilfilm import tables
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.traction import PAPER_LAW

_PLATEAU = ["run_id", "first_row"]


def torque_control(results: CampaignTables, settings: Settings) -> pd.DataFrame:
    """One row per oil with simulated torque logs; none where the torque was measured.

    Args:
        results: Tables `torque_truth` and `fit_quality`.
        settings: `audit` and the campaign's `oils` and `twin`.
    """
    fitted = results.configured.fit_quality.set_index("oil")["law"]
    rows = []
    planted = results.torque_truth.groupby("oil")["law_misfit"].first()
    for oil in settings.campaign.oils:
        if oil not in planted.index:
            continue
        verdict, misfit = "one truth", planted[oil]
        if settings.campaign.truth_is_law and fitted.get(oil) == PAPER_LAW.name:
            verdict = "positive control"
        if misfit > settings.audit.twin_misfit_max:
            verdict = "two truths"
        rows.append({"oil": oil, "verdict": verdict, "law_misfit": misfit})
    return tables.from_rows(rows, "torque_control")


def is_bistable(torque: pd.DataFrame) -> "pd.Series[bool]":
    """Rows at which the cage is known to roll or skid; false where that is not known."""
    return torque["bistable"].eq(True).fillna(False).astype(bool)


def without_bistable(torque: pd.DataFrame) -> pd.DataFrame:
    """Rows of the table `torque` without plateaus at which, by any law, the cage may roll or skid.

    All laws are compared at the same plateaus. Those of which it is not known stay: their torque is
    the one that was found. `undecided_plateaus` counts them.
    """
    either = is_bistable(torque).groupby([torque[name] for name in _PLATEAU]).transform("any")
    return torque[~either]


def undecided_plateaus(torque: pd.DataFrame) -> int:
    """Number of plateaus without a known answer, by any law, to whether the cage rolls or skids."""
    left = without_bistable(torque)
    return len(left[left["bistable"].isna()].drop_duplicates(_PLATEAU))


def bistable_points(torque: pd.DataFrame) -> str:
    """Operating points of the table `torque` at which the cage may roll or skid, by name."""
    return "; ".join(
        f"{row['oil']} at {row['inner_speed_rpm']:.0f} rpm, {row['axial_load_n']:.0f} N, "
        f"{row['inlet_temperature_c']:.0f} degC"
        for row in tables.rows(torque[is_bistable(torque)].drop_duplicates(_PLATEAU))
    )
