"""The configured law beside the others."""

from collections.abc import Mapping
from typing import Any

import pandas as pd

from oilfilm import tables
from oilfilm.fits.best_law import FEWEST_CURVES
from oilfilm.fits.law_comparison import TIE
from oilfilm.report.document import Fact, Section, facts
from oilfilm.report.shown_table import show_declared
from oilfilm.report.words import law_name
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.traction import LAWS
from oilfilm.traction.law import QUANTITIES


def laws(results: CampaignTables, settings: Settings) -> Section:
    """Which law describes each oil best, what to do, and every law's errors side by side."""
    # what must be said wherever the laws of a simulated campaign are compared
    tie = f"Wang-Deng here: {TIE}" if settings.campaign.truth_is_law else ""
    made = law_facts(results.law_verdicts, results.fit_quality, tie)
    errors = show_declared(results.fit_quality, "comparison")
    verdicts = show_declared(results.law_verdicts, "law_verdicts")
    return Section("laws", "Laws", made, [verdicts, errors])


def law_facts(verdicts: pd.DataFrame, quality: pd.DataFrame, tie: str = "") -> list[Fact]:
    """What the comparison says of the configured law of the oils, and what to do.

    Oils of which the same is true have one sentence.

    Args:
        verdicts: Table `law_verdicts`.
        quality: Table of fit quality, of every law.
        tie: What must be said of the laws of this campaign.
    """
    groups: dict[str, dict[str, Any]] = {}
    for row in tables.rows(verdicts):
        of_oil = tables.rows(quality[quality["oil"] == row["oil"]])
        told, misfits = _compared(row, {fit["law"]: fit for fit in of_oil})
        group = groups.setdefault(repr(told), {**told, "oils": [], "misfits": []})
        group["oils"].append(row["oil"])
        group["misfits"].append(misfits)
    rows = list(groups.values())
    return facts("report/sections/laws.jinja", rows=rows, tie=tie, fewest_curves=FEWEST_CURVES)


def _compared(
    row: dict[str, Any], fits: Mapping[str, dict[str, Any]]
) -> tuple[dict[str, Any], list[float]]:
    """What a row of `law_verdicts` says, and the misfits of the better and the configured law."""
    by_bic, law, better = row["bic_ties"].split(", "), row["law"], row["better_law"]
    ties = [each for each in row["left_out_ties"].split(", ") if each and each in by_bic]
    taken = {each: LAWS[each].conditions for each in (law, better) if each in LAWS}
    others = len(taken) == 2 and taken[law] != taken[better]
    meanings = {key: [QUANTITIES[each].short_meaning for each in taken[key]] for key in taken}
    both = [fits[each] for each in (better, law) if each in fits]
    judged = len(both) == 2
    told = {
        "verdict": row["verdict"],
        "law": law,
        "better_law": better,
        "shared": sorted(law_name(each) for each in ties if each != law),
        "fewest": min(ties, key=lambda each: fits[each]["n_constants"], default=""),
        "can_be_set": list(LAWS),
        "constants": [fit["n_constants"] for fit in both] if judged else [],
        "unconfirmed": judged and not both[0]["certified"],
        "beyond": row["ends_out_law"] if better != row["ends_out_law"] and better else "",
        "takes": meanings if others else {},
    }
    return told, [fit["relative_rms"] for fit in both] if judged else []
