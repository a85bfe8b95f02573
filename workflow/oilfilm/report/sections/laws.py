"""The configured law beside the others."""

from typing import Any

import pandas as pd

from oilfilm import tables
from oilfilm.fits.best_law import FEWEST_CURVES
from oilfilm.report.captions import tie
from oilfilm.report.document import Fact, Section, facts
from oilfilm.report.shown_table import Column, ShownTable, number, percent, show, yes_or_no
from oilfilm.report.words import law_name
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.traction import LAWS
from oilfilm.traction.law import QUANTITIES

_TWO, _SMALL, _WHOLE = percent(2), percent(3), number(".0f")


def laws(results: CampaignTables, settings: Settings) -> Section:
    """Which law describes each oil best, what to do, and every law's errors side by side."""
    made = law_facts(results.law_verdicts, results.fit_quality, tie(settings.campaign))
    return Section("laws", "Laws", made, [_verdicts(results), _errors(results)])


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
    ties = [law for law in _laws(row["left_out_ties"]) if law in _laws(row["bic_ties"])]
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


def _laws(ties: str) -> list[str]:
    return ties.split(", ") if ties else []


def _names(ties: str) -> str:
    return ", ".join(map(law_name, _laws(ties)))


def _verdicts(results: CampaignTables) -> ShownTable:
    return show(
        results.law_verdicts,
        "law_verdicts",
        "The configured law beside the best of the laws compared",
        [
            Column("oil", "Oil"),
            Column("law", "Configured law", law_name),
            Column("verdict", "Verdict", is_verdict=True),
            Column("left_out_ties", "Best at curves left out, with ties", _names),
            Column("left_out_relative_rms", "Configured, rms of mu", _TWO, ""),
            Column("left_out_difference", "rms higher by", _SMALL, ""),
            Column("left_out_difference_error", "\N{PLUS-MINUS SIGN} of it", _SMALL, ""),
            Column("bic_ties", "Best by BIC, with ties", _names),
            Column("bic_difference", "BIC higher by", _WHOLE, ""),
            Column("bic_difference_error", "\N{PLUS-MINUS SIGN} of it", _WHOLE, ""),
        ],
        in_text=True,
    )


def _errors(results: CampaignTables) -> ShownTable:
    return show(
        results.fit_quality,
        "fit_quality",
        "Laws fitted to the same points by the same fit: errors relative to mu "
        "where they were fitted, and at ends of the matrix that were left out",
        [
            Column("oil", "Oil"),
            Column("law", "Law", law_name),
            Column("n_constants", "Constants"),
            Column("relative_rms", "Fitted", _TWO, ""),
            Column("pressure_end_out_relative_rms", "P ends left out", _TWO, ""),
            Column("speed_end_out_relative_rms", "U ends left out", _TWO, ""),
            Column("temperature_end_out_relative_rms", "T ends left out", _TWO, ""),
            Column("left_out_rmse", "Curve left out, rms", number(".2e"), ""),
            Column("zero_slip_traction", "mu at no slip", number(".1e"), ""),
            Column("bic", "BIC", _WHOLE, ""),
            Column("active_bounds", "At bounds"),
            Column("certified", "Certified", yes_or_no, is_verdict=True),
        ],
        name="comparison",
    )
