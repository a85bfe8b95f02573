"""The configured law beside the others."""

from typing import Any

import pandas as pd

from oilfilm import tables
from oilfilm.fits.best_law import FEWEST_CURVES
from oilfilm.report.captions import tie
from oilfilm.report.document import Fact, Section, facts
from oilfilm.report.shown_table import show_declared
from oilfilm.report.words import law_name
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.traction import LAWS
from oilfilm.traction.law import QUANTITIES


def laws(results: CampaignTables, settings: Settings) -> Section:
    """Which law describes each oil best, what to do, and every law's errors side by side."""
    made = law_facts(results.law_verdicts, results.fit_quality, tie(settings.campaign))
    errors = show_declared(results.fit_quality, "comparison")
    verdicts = show_declared(results.law_verdicts, "law_verdicts")
    return Section("laws", "Laws", made, [verdicts, errors])


def law_facts(verdicts: pd.DataFrame, quality: pd.DataFrame, tie: str = "") -> list[Fact]:
    """What the comparison says of the configured law of each oil, and what to do.

    Args:
        verdicts: Table `law_verdicts`.
        quality: Table of fit quality, of every law.
        tie: What must be said of the laws of this campaign.
    """
    rows = [_compared(row, quality) for row in tables.rows(verdicts)]
    return facts("report/sections/laws.jinja", rows=rows, tie=tie, fewest_curves=FEWEST_CURVES)


def _compared(row: dict[str, Any], quality: pd.DataFrame) -> dict[str, Any]:
    """One row of `law_verdicts` with what the sentences say of the laws in question."""
    rows = tables.rows(quality[quality["oil"] == row["oil"]])
    by_law = {each["law"]: each for each in rows}
    by_bic = row["bic_ties"].split(", ")
    ties = [law for law in row["left_out_ties"].split(", ") if law and law in by_bic]
    fewest = min(ties, key=lambda law: by_law[law]["n_constants"]) if ties else ""
    better = row["better_law"]
    taken = {law: LAWS[law].conditions for law in (row["law"], better) if law in LAWS}
    other_conditions = len(taken) == 2 and taken[row["law"]] != taken[better]
    return {
        **row,
        "shared": [law_name(law) for law in ties if law != row["law"]],
        "fewest": fewest,
        "can_be_set": [law for law in (fewest, better) if law in LAWS],
        "old": by_law.get(row["law"]),
        "new": by_law.get(better),
        "takes": {
            law: [QUANTITIES[name].short_meaning for name in names] for law, names in taken.items()
        }
        if other_conditions
        else {},
    }
