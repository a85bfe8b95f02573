"""Meaning of a comparison with SIMULATED torque (table `torque_control`), and bistable plateaus.

Decides: what a comparison with simulated torque shows; which plateaus are left out of it because
the cage may roll or skid.
"""

import pandas as pd

from oilfilm import tables
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.traction import PAPER_LAW

# Columns that name a plateau. The table `torque` has one row per plateau and load variable. A load
# variable is a way to evaluate the fitted law, or the name of a law on load.
_PLATEAU_COLUMNS = ["run_id", "first_row"]


def torque_control_table(results: CampaignTables, settings: Settings) -> pd.DataFrame:
    """The table `torque_control`: one row per oil with simulated torque logs.

    It has no rows where the torque was measured.

    Args:
        results: Table `fit_quality`, and `torque_truth` of the package that simulates logs. Its
            `law_misfit` is the relative difference of mu between the traction behind the torque
            logs and that behind the traction logs; 0 where one law is behind both.
        settings: Section `torque_logs`, and `oils`, `torque` and `twin` of the campaign.
    """
    torque_test = settings.campaign.torque
    if torque_test is None or torque_test.twin is None:
        return tables.empty_table("torque_control")
    law_name_of_oil = results.configured_fits.fit_quality.set_index("oil")["law"]
    law_misfit_of_oil = results.torque_truth.groupby("oil")["law_misfit"].first()
    control_rows = []
    for oil in settings.campaign.oils:
        if oil not in law_misfit_of_oil.index:
            continue
        law_misfit = law_misfit_of_oil[oil]
        if law_misfit > settings.torque_logs.twin_misfit_max:
            # different traction is behind the two kinds of logs: the comparison shows nothing
            verdict = "two truths"
        elif settings.campaign.truth_is_law and law_name_of_oil.get(oil) == PAPER_LAW.name:
            # the fitted law itself made the logs of both rigs: the comparison checks the code
            verdict = "positive control"
        else:
            # other physics, or another law, made the logs of both rigs: this checks the fitted law
            verdict = "one truth"
        control_rows.append({"oil": oil, "verdict": verdict, "law_misfit": law_misfit})
    return tables.from_rows(control_rows, "torque_control")


def is_bistable(torque_table: pd.DataFrame) -> "pd.Series[bool]":
    """Whether the cage of each row may both roll and skid; false where that is not known."""
    return torque_table["bistable"].eq(True).fillna(False).astype(bool)


def drop_bistable_plateaus(torque_table: pd.DataFrame) -> pd.DataFrame:
    """Rows of the table `torque` without the bistable plateaus.

    A plateau is bistable if the cage may both roll and skid by any of its rows, so that all laws
    are compared at the same plateaus. Plateaus where it is not known remain, with the torque that
    was calculated. `undecided_plateau_count` counts them.
    """
    plateau_keys = [torque_table[name] for name in _PLATEAU_COLUMNS]
    is_bistable_plateau = is_bistable(torque_table).groupby(plateau_keys).transform("any")
    return torque_table[~is_bistable_plateau]


def undecided_plateau_count(torque_table: pd.DataFrame) -> int:
    """Number of plateaus of which it is not known, by some row, whether they are bistable."""
    remaining = drop_bistable_plateaus(torque_table)
    return len(remaining[remaining["bistable"].isna()].drop_duplicates(_PLATEAU_COLUMNS))


def bistable_points_text(torque_table: pd.DataFrame) -> str:
    """Bistable operating points of the table `torque`, as text."""
    bistable_plateaus = torque_table[is_bistable(torque_table)].drop_duplicates(_PLATEAU_COLUMNS)
    return "; ".join(
        f"{row['oil']} at {row['inner_speed_rpm']:.0f} rpm, {row['axial_load_n']:.0f} N, "
        f"{row['inlet_temperature_c']:.0f} degC"
        for row in tables.rows(bistable_plateaus)
    )
