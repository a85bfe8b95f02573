"""Facts about a campaign that its summary and its report both state."""

from collections.abc import Mapping
from dataclasses import dataclass

import pandas as pd

from oilfilm import tables
from oilfilm.curation.coverage import planned_states
from oilfilm.fits.law_comparison import TIE
from oilfilm.logs.run_sheet import REMARKS
from oilfilm.report.fit_verdicts import noise_finding
from oilfilm.settings.campaign import Campaign
from oilfilm.settings.oil import OilFile
from oilfilm.tables.campaign_tables import CampaignTables


def accepted_runs(results: CampaignTables) -> str:
    """Accepted of all runs, as `212 of 218`."""
    accepted = (results.runs["verdict"] == "accepted").sum()
    return f"{accepted} of {len(results.runs)}"


def accepted_points(results: CampaignTables) -> str:
    """Accepted of all points."""
    return f"{results.points['accepted'].sum()} of {len(results.points)}"


def circular(campaign: Campaign) -> str:
    """What verdicts on the claims are worth where the points were simulated; empty elsewhere."""
    if campaign.truth_is_law:
        return (
            "CIRCULAR on the refit: the points were SIMULATED with the printed constants. "
            f"The verdicts are about these constants, not about the oils. Wang-Deng: {TIE}."
        )
    if campaign.data == "simulated":
        return "The points were SIMULATED: verdicts on the refit say nothing of the real oils."
    return ""


def condition_counts(results: CampaignTables) -> dict[str, int]:
    """Number of conditions by state, `accepted`, `refused` or `missing`.

    Of the matrix, or of what was tested where the campaign has no matrix.
    """
    has_matrix = results.coverage["planned"].any()
    states = (planned_states(results.coverage) if has_matrix else results.coverage)["state"]
    counts = states.value_counts().reindex(["accepted", "refused", "missing"], fill_value=0)
    return {str(state): int(count) for state, count in counts.items()}


def counted(count: int, what: str) -> str:
    """A number of things, as `1 log` or `2 logs`."""
    return f"{count} {what}{'' if count == 1 else 's'}"


def unread_logs(results: CampaignTables) -> set[str]:
    """Logs of which no run could be read."""
    return refused_files(results.quarantine) - set(results.runs["file"])


def noise_sentences(misfits: pd.DataFrame) -> list[str]:
    """What each fit misses beside the noise; one sentence for all oils without repeated runs.

    Args:
        misfits: Table `lack_of_fit`.
    """
    sentences = []
    for verdict, rows in misfits.groupby("verdict", sort=False):
        if verdict == "no repeats":
            sentences.append(
                f"{', '.join(rows['oil'])}: noise and lack of fit cannot be told apart, because no "
                "runs repeat a condition."
            )
        else:
            sentences += [f"{row['oil']}: {noise_finding(row)}." for row in tables.rows(rows)]
    return sentences


def refused_files(quarantine: pd.DataFrame) -> set[str]:
    """Logs that were refused in whole or in part; remarks refuse nothing."""
    return set(quarantine.loc[~quarantine["rule"].isin(REMARKS), "file"])


def accepted_torque_logs(results: CampaignTables) -> tuple[int, int, int]:
    """Torque logs that could be read, all of them, and those with runs that were not refused."""
    runs, refused = results.torque_runs, results.torque_quarantine
    kept = {run_id.rpartition(":")[0] or run_id for run_id in runs["run_id"]}
    # of a refused run no plateau is kept
    read = kept | set(refused.loc[refused["stage"] == "curate", "file"])
    return len(read), len(read | refused_files(refused)), len(kept)


# Why no torque is calculated for an oil.
LACKING = (
    "lacks properties, a fitted law that follows each condition, or a traction rig whose contact "
    "is known"
)


def plateaus_not_calculated(results: CampaignTables) -> dict[str, int]:
    """Number of accepted torque plateaus of each oil for which no torque is calculated."""
    accepted = results.torque_runs.loc[results.torque_runs["accepted"], "oil"]
    counts = accepted[~accepted.isin(results.torque["oil"])].value_counts()
    return {str(oil): int(count) for oil, count in counts.items()}


def stand_in_oils(oils: Mapping[str, OilFile | None]) -> list[str]:
    """Oils with the properties of another oil."""
    return [name for name, oil in oils.items() if oil is not None and oil.stand_in]


def film_unjudged_oils(points: pd.DataFrame) -> list[str]:
    """Oils with accepted points of which no film thickness could be calculated."""
    unjudged = points["accepted"] & (points["film_judgement"] == "cannot be judged")
    return list(dict.fromkeys(points.loc[unjudged, "oil"]))


@dataclass(frozen=True)
class OilHeat:
    """What the oil's own heating changes on the map of cage slip.

    Attributes:
        outlet_temperature_c: Temperatures of the oil that leaves, of the cases with a balance.
        torque_change: Relative change of their torque, rounded to 0.01.
        other_best_oil: Number of operating points where the heated oil changes the best oil.
        points: Number of operating points.
        unbalanced: Number of cases without a steady temperature.
        cases: Number of cases.
    """

    outlet_temperature_c: pd.Series
    torque_change: pd.Series
    other_best_oil: int
    points: int
    unbalanced: int
    cases: int


def oil_heat(balance: pd.DataFrame) -> OilHeat | None:
    """What table `heat_balance` says of the map of cage slip; None without a steady case."""
    on_map = balance[balance["run_id"] == ""]
    hot = on_map[on_map["balanced"]]
    if hot.empty:
        return None
    points = on_map.drop_duplicates(["inner_speed_rpm", "axial_load_n"])
    return OilHeat(
        outlet_temperature_c=hot["outlet_temperature_c"],
        # + 0.0 takes the minus sign from a rounded zero
        torque_change=(hot["heated_torque_n_m"] / hot["torque_n_m"] - 1).round(2) + 0.0,
        other_best_oil=int((points["best_oil"] != points["heated_best_oil"]).sum()),
        points=len(points),
        unbalanced=len(on_map) - len(hot),
        cases=len(on_map),
    )
