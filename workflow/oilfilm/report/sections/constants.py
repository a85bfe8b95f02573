"""The constants of each fit with their intervals, and which of them the data determine."""

import numpy as np
import pandas as pd

from oilfilm import tables
from oilfilm.fits.conditions import from_text
from oilfilm.report.document import Section, facts
from oilfilm.report.shown_table import ShownTable, number, show_declared, significant
from oilfilm.tables.campaign_tables import CampaignTables

# Constants that move together so closely replace each other.
_STRONG = 0.95


def constants(results: CampaignTables) -> Section:
    """A table per oil, and a sentence for each constant that the data do not determine."""
    fits = results.configured
    if fits.coefficients.empty:
        return Section("constants", "Constants")
    coefficients = with_partners(fits.coefficients, fits.correlations)
    oils = coefficients["oil"].unique()
    quality = {row["oil"]: row for row in tables.rows(fits.fit_quality)}
    made = facts(
        "report/sections/constants.jinja",
        fits=[
            {
                "oil": oil,
                "curves": quality[str(oil)]["n_curves"],
                "constants": tables.rows(rows),
                "fixed": [
                    each.sentence() for each in from_text(quality[str(oil)]["fixed_conditions"])
                ],
            }
            for oil, rows in coefficients.groupby("oil", sort=False)
            if rows["value"].notna().any()
        ],
    )
    return Section(
        "constants",
        "Constants",
        made,
        [_of_oil(coefficients, oil, place) for place, oil in enumerate(oils)],
        downloads={"coefficients.csv": fits.coefficients},
    )


def with_partners(coefficients: pd.DataFrame, correlations: pd.DataFrame) -> pd.DataFrame:
    """Constants, each with the one that may replace it.

    Args:
        coefficients: Table of coefficients.
        correlations: Table of correlations.

    Returns:
        The coefficients with columns `partner` (the constant that moves most with this one, empty
        where none does so closely) and `correlation`.
    """
    other_way = correlations.rename(columns={"constant": "other", "other": "constant"})
    both = pd.concat([correlations, other_way], ignore_index=True)
    both = both.assign(size=both["correlation"].abs()).query("size >= @_STRONG")
    closest = both.sort_values("size", ascending=False).drop_duplicates(["oil", "law", "constant"])
    partners = closest[["oil", "law", "constant", "other", "correlation"]]
    paired = coefficients.merge(partners, how="left", on=["oil", "law", "constant"])
    return paired.assign(partner=paired["other"].fillna(""))


def _of_oil(coefficients: pd.DataFrame, oil: str, place: int) -> ShownTable:
    """Constants of one oil with their errors. Digits beyond the second of the error say nothing."""
    rows = coefficients[coefficients["oil"] == oil]
    lower, upper = "lower", "upper"
    errors = "standard_error", "systematic_standard_error"
    names = ["value", *errors, lower, upper]
    texts = rows.astype(object)
    for index, row in rows.iterrows():
        error = row["standard_error"]
        form = number(significant(row["naive_standard_error"] if np.isnan(error) else error))
        texts.loc[index, names] = [form(row[name]) for name in names]
    interval = texts[lower] + " \N{HORIZONTAL ELLIPSIS} " + texts[upper]
    texts[lower] = texts[lower].where(rows[lower].isna(), interval)
    return show_declared(texts, "constants", oil, f"constants{place}")
