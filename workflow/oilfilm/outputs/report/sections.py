"""What each section of the report shows, from the finished tables."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from markupsafe import Markup

from oilfilm import tables
from oilfilm.fitting.fitted import FittedLaw
from oilfilm.outputs.bearing_sentences import bearing_words
from oilfilm.outputs.report.contents import (
    Choice,
    Column,
    Shown,
    number,
    percent,
    show,
    significant,
    yes_or_no,
)
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.traction import LAWS
from oilfilm.traction.typeset import mathml


@dataclass(frozen=True)
class Certainty:
    """How sure one fit is of mu at the accepted points: half of the 95 % interval over mu.

    Null where the fit has no interval.
    """

    median: float
    largest: float


def certainty(results: CampaignTables, oil: str) -> Certainty:
    """How sure the fit of one oil is of the points it was made of."""
    fit = FittedLaw.of(results.coefficients, oil, results.refits, results.fit_quality)
    points = results.points
    own = points[points["accepted"] & (points["oil"] == oil)]
    found = fit.predict(
        own[list(fit.law.conditions)].to_numpy(float), own["slide_roll_ratio"].to_numpy(float)
    )
    size = np.abs(found.traction_coefficient)
    half = (found.upper - found.lower)[size > 0] / 2 / size[size > 0]
    half = half[~np.isnan(half)]
    return Certainty(np.median(half), half.max()) if len(half) else Certainty(np.nan, np.nan)


def fit_table(results: CampaignTables, sure: Mapping[str, Certainty]) -> Shown:
    """One row per fit: misfit, 95 % interval of mu, certificate."""
    quality = results.fit_quality
    shown = show(
        quality,
        "fit_quality",
        "How near the law comes to the points, and how sure the fitted curves are",
        [
            Choice("oil", "Oil"),
            Choice("law", "Law"),
            Choice("n_points", "Points"),
            Choice("n_curves", "Curves"),
            Choice("relative_rms", "Misfit, rms of mu", percent(2), ""),
            Choice("max_error", "Largest error of mu", number(".2e"), ""),
            Choice("certified", "Certified", yes_or_no, is_verdict=True),
            Choice("certificate", "Why"),
        ],
    )
    meaning = (
        "half of the 95 % interval of the fitted curve over mu, at the accepted points: random "
        "errors of whole curves and calibration, true as far as the law is"
    )
    interval = [
        Column("mu known to, median", "", meaning, True),
        Column("at worst", "", meaning, True),
    ]
    form = percent(2)
    rows = [
        [*row[:6], form(sure[row[0]].median), form(sure[row[0]].largest), *row[6:]]
        for row in shown.rows
    ]
    columns = [*shown.columns[:6], *interval, *shown.columns[6:]]
    return Shown(shown.name, shown.caption, columns, rows, 0, shown.source)


def constants(coefficients: pd.DataFrame, oil: str, number_of_oil: int) -> Shown:
    """Constants of one oil with their errors; digits beyond the second of the error say nothing."""
    rows = coefficients[coefficients["oil"] == oil]
    names = ["value", "standard_error", "lower", "upper", "systematic_standard_error"]
    texts = rows.astype(object)
    for place, row in zip(rows.index, tables.rows(rows), strict=True):
        error = row["standard_error"]
        form = number(significant(row["naive_standard_error"] if np.isnan(error) else error))
        for name in names:
            texts.loc[place, name] = form(row[name])
        # every digit of the print
        texts.loc[place, "printed_value"] = number(".10g")(row["printed_value"])
    interval = texts["lower"] + " \N{HORIZONTAL ELLIPSIS} " + texts["upper"]
    texts["lower"] = texts["lower"].where(rows["lower"].isna(), interval)
    shown = show(
        texts,
        "coefficients",
        "",
        [
            Choice("constant", "Constant"),
            Choice("value", "Value", unit=""),
            Choice("lower", "95 % interval", unit=""),
            Choice("standard_error", "\N{PLUS-MINUS SIGN} random", unit=""),
            Choice("systematic_standard_error", "\N{PLUS-MINUS SIGN} calibration", unit=""),
            Choice("verdict", "Verdict", is_verdict=True),
            Choice("printed_value", "Printed", unit=""),
        ],
    )
    printed = not rows["printed_value"].isna().all()
    keep = slice(None) if printed else slice(-1)
    return Shown(
        f"constants{number_of_oil}",
        oil,
        shown.columns[keep],
        [row[keep] for row in shown.rows],
        0,
        shown.source,
    )


def equations(results: CampaignTables) -> list[tuple[Markup, str]]:
    """Equation, as MathML, and source of each fitted law."""
    laws = (LAWS[name] for name in dict.fromkeys(results.coefficients["law"]))
    return [(Markup(mathml(law)), law.source) for law in laws]  # noqa: S704  (our own text)


_REFUSED = [
    Choice("file", "Log"),
    Choice("rule", "Rule"),
    Choice("reason", "What was found"),
    Choice("advice", "What to do"),
]


def refused(quarantine: pd.DataFrame, name: str, caption: str, most: int) -> Shown:
    """What was refused, why, and what to do."""
    choices = list(_REFUSED)
    if (quarantine["run_id"] != quarantine["file"]).any():
        choices.insert(1, Choice("run_id", "Run"))
    return show(quarantine, "quarantine", caption, choices, name=name, most=most)


def gates(results: CampaignTables) -> Shown:
    """How much each gate refused."""
    return show(
        results.gate_counts,
        "gate_counts",
        "How much each gate refused; a point counts at every gate that refused it",
        [
            Choice("gate", "Gate"),
            Choice("what", "Judges"),
            Choice("files", "Logs"),
            Choice("runs_refused", "Runs refused"),
            Choice("points", "Points"),
            Choice("rows", "Rows"),
            Choice("advice", "What to do"),
        ],
    )


def claims(results: CampaignTables) -> list[dict[str, Any]]:
    """Each claim with its rows, one per basis."""
    return [
        {"claim": claim, **tables.rows(rows)[0], "bases": tables.rows(rows)}
        for claim, rows in results.claims.groupby("claim", sort=False)
    ]


def comparison(results: CampaignTables) -> Shown:
    """The laws side by side."""
    two = percent(2)
    return show(
        results.comparison,
        "comparison",
        "Laws fitted to the same points by the same fit: errors relative to mu "
        "where they were fitted, and at ends of the matrix that were left out",
        [
            Choice("oil", "Oil"),
            Choice("law", "Law"),
            Choice("n_constants", "Constants"),
            Choice("relative_rms", "Fitted", two, ""),
            Choice("pressure_end_out_relative_rms", "P ends left out", two, ""),
            Choice("speed_end_out_relative_rms", "U ends left out", two, ""),
            Choice("temperature_end_out_relative_rms", "T ends left out", two, ""),
            Choice("left_out_rmse", "Curve left out, rms", number(".2e"), ""),
            Choice("zero_slip_traction", "mu at no slip", number(".1e"), ""),
            Choice("bic", "BIC", number(".0f"), ""),
            Choice("certified", "Certified", yes_or_no, is_verdict=True),
        ],
    )


def torque(results: CampaignTables) -> Shown:
    """How far the calculated torque lies from the measured one, by oil and basis of the law."""
    known = results.torque.dropna(subset=["relative_error"])
    columns = [
        Column("Oil"),
        Column("Load variable"),
        Column("Points", is_number=True),
        Column("Median error", is_number=True),
        Column("Largest error", is_number=True),
        Column("Traction's share of torque, median", is_number=True),
    ]
    one = percent(1)
    rows = []
    for (oil, basis), of_basis in known.groupby(["oil", "load_variable"], sort=False):
        size = of_basis["relative_error"].abs()
        share = of_basis["traction_torque_n_m"] / of_basis["torque_n_m"]
        rows.append(
            [
                str(oil),
                str(basis).replace("_", " "),
                str(len(of_basis)),
                one(size.median()),
                one(size.max()),
                one(share.median()),
            ]
        )
    caption = "Calculated against measured friction torque; nothing is fitted to torque"
    return Shown("torque", caption, columns, rows, 0, "tables/torque.parquet")


def bearing(results: CampaignTables) -> list[str]:
    """Findings on the bearing, one sentence per line; none without torque logs."""
    if results.torque_runs.empty:
        return []
    return [line.strip() for line in bearing_words(results)[1:] if line]
