"""What each section of the report shows, from the finished tables."""

from typing import Any

import numpy as np
import pandas as pd
from markupsafe import Markup

from oilfilm import tables
from oilfilm.fitting.fitted import FittedLaw
from oilfilm.outputs.bearing_sentences import bearing_lines
from oilfilm.outputs.report.contents import (
    Column,
    Shown,
    number,
    percent,
    show,
    significant,
    yes_or_no,
)
from oilfilm.studies.torque_control import without_bistable
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.traction import LAWS
from oilfilm.traction.typeset import mathml


def certainty(results: CampaignTables) -> pd.DataFrame:
    """How sure each fit is of mu at the accepted points: half of the 95 % interval over mu.

    Columns median and largest by oil; null where the fit has no interval.
    """
    certainties = {}
    accepted = results.points[results.points["accepted"]]
    for oil in results.fit_quality["oil"]:
        fit = FittedLaw.of(results.coefficients, oil, results.refits, results.fit_quality)
        points = accepted[accepted["oil"] == oil]
        conditions, slip = points[list(fit.law.conditions)], points["slide_roll_ratio"]
        prediction = fit.predict(conditions.to_numpy(float), slip.to_numpy(float))
        size = np.abs(prediction.traction_coefficient)
        half = pd.Series((prediction.upper - prediction.lower)[size > 0] / 2 / size[size > 0])
        certainties[oil] = half.median(), half.max()
    return pd.DataFrame.from_dict(certainties, "index", columns=["median", "largest"])


def fit_table(results: CampaignTables, sure: pd.DataFrame) -> Shown:
    """One row per fit: misfit, 95 % interval of mu (`certainty`), certificate."""
    two = percent(2)
    meaning = (
        "half of the 95 % interval of the fitted curve over mu, at the accepted points: random "
        "errors of whole curves and calibration, true as far as the law is"
    )
    return show(
        results.fit_quality.join(sure, on="oil"),
        "fit_quality",
        "How near the law comes to the points, and how sure the fitted curves are",
        [
            Column("oil", "Oil"),
            Column("law", "Law"),
            Column("n_points", "Points"),
            Column("n_curves", "Curves"),
            Column("relative_rms", "Misfit, rms of mu", two, ""),
            Column("max_error", "Largest error of mu", number(".2e"), ""),
            Column("median", "mu known to, median", two, "", meaning, is_number=True),
            Column("largest", "at worst", two, "", meaning, is_number=True),
            Column("certified", "Certified", yes_or_no, is_verdict=True),
            Column("certificate", "Why"),
        ],
    )


def laws(results: CampaignTables) -> Shown:
    """The configured law of each oil beside the best of those compared, by both judges."""
    two, small = percent(2), percent(3)
    return show(
        results.law_verdicts,
        "law_verdicts",
        "The configured law beside the best of the laws compared",
        [
            Column("oil", "Oil"),
            Column("law", "Configured"),
            Column("verdict", "Verdict", is_verdict=True),
            Column("left_out_ties", "Best at curves left out, with ties"),
            Column("left_out_relative_rms", "Configured, rms of mu", two, ""),
            Column("left_out_difference", "rms higher by", small, ""),
            Column("left_out_difference_error", "\N{PLUS-MINUS SIGN} of it", small, ""),
            Column("bic_ties", "Best by BIC, with ties"),
            Column("bic_difference", "BIC higher by", number(".0f"), ""),
            Column("bic_difference_error", "\N{PLUS-MINUS SIGN} of it", number(".0f"), ""),
        ],
    )


def noise(results: CampaignTables) -> Shown:
    """Misfit of each fit, parted into noise and lack of fit."""
    two = percent(2)
    return show(
        results.lack_of_fit,
        "lack_of_fit",
        "Noise and lack of fit, rms of mu",
        [
            Column("oil", "Oil"),
            Column("relative_rms", "Misfit", two, ""),
            Column("repeat_relative_rms", "Noise, by repeats", two, ""),
            Column("lack_of_fit_relative_rms", "Lack of fit", two, ""),
            Column("plateau_relative_rms", "Noise within plateaus", two, ""),
            Column("n_repeats", "Repeats"),
            Column("lack_of_fit_ratio", "F", number(".3g"), ""),
            Column("lack_of_fit_limit", "Limit of F", number(".3g"), ""),
            Column("verdict", "Lack of fit is", is_verdict=True),
        ],
    )


def constants(coefficients: pd.DataFrame, oil: str, number_of_oil: int) -> Shown:
    """Constants of one oil with their errors, those first that the data determine.

    Digits beyond the second of the error say nothing.

    Args:
        coefficients: As `outputs.constants.by_certainty` gives them.
        oil: Of which they are.
        number_of_oil: In the page.
    """
    rows = coefficients[coefficients["oil"] == oil]
    lower, upper = "joint_lower", "joint_upper"  # the interval that the verdict uses
    errors = "standard_error", "systematic_standard_error"
    names = ["value", *errors, lower, upper]
    texts = rows.astype(object)
    for index, row in rows.iterrows():
        error = row["standard_error"]
        form = number(significant(row["naive_standard_error"] if np.isnan(error) else error))
        texts.loc[index, names] = [form(row[name]) for name in names]
    # every digit of the print
    texts["printed_value"] = rows["printed_value"].map(number(".10g"))
    interval = texts[lower] + " \N{HORIZONTAL ELLIPSIS} " + texts[upper]
    texts[lower] = texts[lower].where(rows[lower].isna(), interval)
    columns = [
        Column("constant", "Constant"),
        Column("value", "Value", unit=""),
        Column(lower, "Joint interval", unit=""),
        Column("standard_error", "\N{PLUS-MINUS SIGN} random", unit=""),
        Column("systematic_standard_error", "\N{PLUS-MINUS SIGN} calibration", unit=""),
        Column("verdict", "Verdict", is_verdict=True),
    ]
    if rows["printed_value"].notna().any():
        columns.append(Column("printed_value", "Printed", unit=""))
    return show(texts, "coefficients", oil, columns, name=f"constants{number_of_oil}")


def equations(results: CampaignTables) -> list[tuple[Markup, str]]:
    """Equation, as MathML, and source of each fitted law."""
    laws = (LAWS[name] for name in dict.fromkeys(results.coefficients["law"]))
    return [(Markup(mathml(law)), law.source) for law in laws]  # noqa: S704  (our own text)


def refused(quarantine: pd.DataFrame, name: str, caption: str, most: int) -> Shown:
    """What was refused, why, and what to do."""
    columns = [
        Column("file", "Log"),
        Column("rule", "Rule"),
        Column("reason", "What was found"),
        Column("advice", "What to do"),
    ]
    if (quarantine["run_id"] != quarantine["file"]).any():
        columns.insert(1, Column("run_id", "Run"))
    return show(quarantine, "quarantine", caption, columns, name=name, most=most)


def gates(results: CampaignTables) -> Shown:
    """How much each gate refused."""
    return show(
        results.gate_counts,
        "gate_counts",
        "How much each gate refused; a point counts at every gate that refused it",
        [
            Column("gate", "Gate"),
            Column("what", "Judges"),
            Column("files", "Logs"),
            Column("runs_refused", "Runs refused"),
            Column("points", "Points"),
            Column("rows", "Rows"),
            Column("advice", "What to do"),
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
            Column("oil", "Oil"),
            Column("law", "Law"),
            Column("n_constants", "Constants"),
            Column("relative_rms", "Fitted", two, ""),
            Column("pressure_end_out_relative_rms", "P ends left out", two, ""),
            Column("speed_end_out_relative_rms", "U ends left out", two, ""),
            Column("temperature_end_out_relative_rms", "T ends left out", two, ""),
            Column("left_out_rmse", "Curve left out, rms", number(".2e"), ""),
            Column("zero_slip_traction", "mu at no slip", number(".1e"), ""),
            Column("bic", "BIC", number(".0f"), ""),
            Column("active_bounds", "At bounds"),
            Column("certified", "Certified", yes_or_no, is_verdict=True),
        ],
    )


def torque(results: CampaignTables) -> Shown:
    """How far the calculated torque lies from the measured one, by oil and load variable."""
    sure = without_bistable(results.torque)
    known = sure.dropna(subset=["relative_error"])
    known = known.assign(
        size=known["relative_error"].abs(),
        share=known["traction_torque_n_m"] / known["torque_n_m"],
        load_variable=known["load_variable"].str.replace("_", " "),
    )
    errors = known.groupby(["oil", "load_variable"], sort=False, as_index=False).agg(
        points=("size", "size"),
        median=("size", "median"),
        largest=("size", "max"),
        share=("share", "median"),
    )
    form = percent(1)
    return show(
        errors,
        "torque",
        "Calculated against measured friction torque, without points where the cage may roll or "
        "skid; nothing is fitted to torque",
        [
            Column("oil", "Oil", meaning=""),
            Column("load_variable", "Load variable", meaning=""),
            Column("points", "Points", is_number=True),
            Column("median", "Median error", form, is_number=True),
            Column("largest", "Largest error", form, is_number=True),
            Column("share", "Traction's share of torque, median", form, is_number=True),
        ],
    )


def torque_control(results: CampaignTables) -> Shown:
    """What a comparison with simulated torque shows, by oil."""
    form = percent(2)
    return show(
        results.torque_control,
        "torque_control",
        "Controls: what the comparison with SIMULATED torque shows",
        [
            Column("oil", "Oil"),
            Column("verdict", "Shows"),
            Column("law_misfit", "Difference of the two rigs' traction, of mu", form, ""),
            Column("n_plateaus", "Plateaus"),
            Column("median_torque_error", "Median error", form, ""),
            Column("largest_torque_error", "Largest error", form, ""),
        ],
    )


def bearing(results: CampaignTables) -> list[str]:
    """Findings on the bearing, one sentence per line; none without torque logs."""
    if results.torque_runs.empty:
        return []
    return [line.strip() for line in bearing_lines(results)[1:] if line]
