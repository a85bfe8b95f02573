"""What a comparison with SIMULATED torque can show: table `torque_control`.

Decides: what a comparison with simulated torque shows.
"""

import pandas as pd

from oilfilm import tables
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.traction import PAPER_LAW


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


def without_bistable(torque: pd.DataFrame) -> pd.DataFrame:
    """Rows of the table `torque` without plateaus at which, by any law, the cage may roll or skid.

    All laws are compared at the same plateaus.
    """
    return torque[~torque.groupby(["run_id", "first_row"])["bistable"].transform("any")]


def bistable_points(torque: pd.DataFrame) -> str:
    """Operating points of the table `torque` at which the cage may roll or skid, by name."""
    return "; ".join(
        f"{row['oil']} at {row['inner_speed_rpm']:.0f} rpm, {row['axial_load_n']:.0f} N, "
        f"{row['inlet_temperature_c']:.0f} degC"
        for row in tables.rows(torque[torque["bistable"]].drop_duplicates(["run_id", "first_row"]))
    )
