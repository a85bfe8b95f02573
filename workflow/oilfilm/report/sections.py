"""What each section of the report shows, from the finished tables.

Decides: where the equations are in the report, and what each table of it shows.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd
from markupsafe import Markup

from oilfilm import tables
from oilfilm.fits.fitted import FittedLaw
from oilfilm.logs.run_sheet import REMARKS
from oilfilm.paper.selection import OUTSIDE
from oilfilm.report.facts import (
    LACKING,
    accepted_torque_logs,
    oil_heat,
    plateaus_not_calculated,
)
from oilfilm.report.labels import (
    BASES,
    OTHER_CHOICES,
    gate_name,
    in_words,
    law_name,
    law_names,
    load_variable,
)
from oilfilm.report.shown_table import (
    Column,
    Form,
    ShownTable,
    number,
    percent,
    show,
    significant,
    yes_or_no,
)
from oilfilm.tables import failed_gates
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.torque.torque_control import bistable_points, without_bistable
from oilfilm.traction import LAWS
from oilfilm.traction.typeset import mathml


def certainty(results: CampaignTables) -> pd.DataFrame:
    """How sure each fit is of mu at the accepted points: half of the 95 % interval over mu.

    Columns median and largest by oil; null where the fit has no interval.
    """
    certainties = {}
    accepted = results.points[results.points["accepted"]]
    for oil in results.configured.fit_quality["oil"]:
        fit = FittedLaw.of_configured(results, oil)
        points = accepted[accepted["oil"] == oil]
        conditions, slip = points[list(fit.law.conditions)], points["slide_roll_ratio"]
        prediction = fit.predict(conditions.to_numpy(float), slip.to_numpy(float))
        size = np.abs(prediction.traction_coefficient)
        half = pd.Series((prediction.upper - prediction.lower)[size > 0] / 2 / size[size > 0])
        certainties[oil] = half.median(), half.max()
    return pd.DataFrame.from_dict(certainties, "index", columns=["median", "largest"])


def fit_table(results: CampaignTables, sure: pd.DataFrame) -> ShownTable:
    """One row per fit: misfit, 95 % interval of mu (`certainty`), certificate."""
    two = percent(2)
    meaning = (
        "half of the 95 % interval of the fitted curve over mu, at the accepted points: random "
        "errors of whole curves and calibration, true as far as the law is"
    )
    return show(
        results.configured.fit_quality.join(sure, on="oil"),
        "fit_quality",
        "How near the law comes to the points, and how sure the fitted curves are",
        [
            Column("oil", "Oil"),
            Column("law", "Law", law_name),
            Column("n_points", "Points"),
            Column("n_curves", "Curves"),
            Column("relative_rms", "Misfit, rms of mu", two, ""),
            Column("max_error", "Largest error of mu", number(".2e"), ""),
            Column("median", "mu known to, median", two, "", meaning, is_number=True),
            Column("largest", "at worst", two, "", meaning, is_number=True),
            Column("certified", "Certified", yes_or_no, is_verdict=True),
        ],
    )


def certificates(results: CampaignTables) -> list[tuple[str, str]]:
    """Oil, and why its fit is certified or not."""
    return [(row["oil"], row["certificate"]) for row in tables.rows(results.configured.fit_quality)]


def laws(results: CampaignTables) -> ShownTable:
    """The configured law of each oil beside the best of those compared, by both criteria."""
    two, small = percent(2), percent(3)
    return show(
        results.law_verdicts,
        "law_verdicts",
        "The configured law beside the best of the laws compared",
        [
            Column("oil", "Oil"),
            Column("law", "Configured law", law_name),
            Column("verdict", "Verdict", is_verdict=True),
            Column("left_out_ties", "Best at curves left out, with ties", law_names),
            Column("left_out_relative_rms", "Configured, rms of mu", two, ""),
            Column("left_out_difference", "rms higher by", small, ""),
            Column("left_out_difference_error", "\N{PLUS-MINUS SIGN} of it", small, ""),
            Column("bic_ties", "Best by BIC, with ties", law_names),
            Column("bic_difference", "BIC higher by", number(".0f"), ""),
            Column("bic_difference_error", "\N{PLUS-MINUS SIGN} of it", number(".0f"), ""),
        ],
    )


def noise(results: CampaignTables) -> ShownTable:
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


def constants(coefficients: pd.DataFrame, oil: str, number_of_oil: int) -> ShownTable:
    """Constants of one oil with their errors, those first that the data determine.

    Digits beyond the second of the error say nothing.

    Args:
        coefficients: As `outputs.constants.by_certainty` gives them.
        oil: Of which they are.
        number_of_oil: In the page.
    """
    rows = coefficients[coefficients["oil"] == oil]
    lower, upper = "lower", "upper"
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
        Column("standard_error", "Standard error, random", unit=""),
        Column("systematic_standard_error", "Standard error, calibration", unit=""),
        Column("verdict", "Verdict", is_verdict=True),
    ]
    if rows["printed_value"].notna().any():
        columns.append(Column("printed_value", "Printed", unit=""))
    return show(texts, "coefficients", oil, columns, name=f"constants{number_of_oil}")


def equations(results: CampaignTables) -> list[tuple[Markup, str]]:
    """Equation, as MathML, and source of each fitted law."""
    laws = (LAWS[name] for name in dict.fromkeys(results.configured.coefficients["law"]))
    return [(Markup(mathml(law)), law.source) for law in laws]  # noqa: S704  (our own text)


def refused(quarantine: pd.DataFrame, name: str, caption: str, most: int) -> ShownTable:
    """What was refused, why, and what to do; remarks on the run sheet refuse nothing."""
    quarantine = quarantine[~quarantine["rule"].isin(REMARKS)]
    columns = [
        Column("file", "Log"),
        Column("rule", "Gate", gate_name),
        Column("reason", "What was found"),
        Column("advice", "What to do"),
    ]
    if (quarantine["run_id"] != quarantine["file"]).any():
        columns.insert(1, Column("run_id", "Run"))
    return show(quarantine, "quarantine", caption, columns, name=name, most=most)


def gates(results: CampaignTables) -> ShownTable:
    """How much each gate refused; without gates that refused nothing."""
    counts = results.gate_counts
    return show(
        counts[~counts["gate"].isin(REMARKS)],
        "gate_counts",
        "Everything that was refused, by gate; a point counts at every gate that refused it",
        [
            Column("gate", "Gate", gate_name),
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
    known = results.claims.assign(
        basis=results.claims["basis"].replace(BASES),
        finding=results.claims["finding"].map(in_words),
    )
    return [
        {"claim": claim, **tables.rows(rows)[0], "bases": tables.rows(rows)}
        for claim, rows in known.groupby("claim", sort=False)
    ]


def comparison(results: CampaignTables) -> ShownTable:
    """The laws side by side."""
    two = percent(2)
    return show(
        results.fit_quality,
        "fit_quality",
        "Laws fitted to the same points by the same fit: errors relative to mu "
        "where they were fitted, and at ends of the matrix that were left out",
        [
            Column("oil", "Oil"),
            Column("law", "Law", law_name),
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


def torque(results: CampaignTables) -> ShownTable:
    """How far the calculated torque lies from the measured one, by oil and load variable."""
    sure = without_bistable(results.torque)
    known = sure.dropna(subset=["relative_error"])
    known = known.assign(
        size=known["relative_error"].abs(),
        share=known["traction_torque_n_m"] / known["torque_n_m"],
        agrees=known["verdict"] == "compatible",
        is_judged=known["verdict"] != "not known",
    )
    errors = known.groupby(["oil", "load_variable"], sort=False, as_index=False).agg(
        points=("size", "size"),
        median=("size", "median"),
        largest=("size", "max"),
        agrees=("agrees", "sum"),
        judged=("is_judged", "sum"),
        share=("share", "median"),
    )
    errors["agreeing"] = [
        f"{good} of {judged}" if judged else "not known"
        for good, judged in zip(errors["agrees"], errors["judged"], strict=True)
    ]
    form = percent(1)
    agreeing = "points where the difference is within twice its standard uncertainty"
    return show(
        errors,
        "torque",
        "Calculated against measured friction torque, without points where the cage may roll or "
        "skid; nothing is fitted to torque",
        [
            Column("oil", "Oil", meaning=""),
            Column("load_variable", "Law and load variable", load_variable, meaning=""),
            Column("points", "Points", is_number=True),
            Column("median", "Median error", form, is_number=True),
            Column("largest", "Largest error", form, is_number=True),
            Column("agreeing", "Agree within uncertainty", meaning=agreeing),
            Column("share", "Traction's share of torque, median", form, is_number=True),
        ],
    )


def torque_control(results: CampaignTables) -> ShownTable:
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


def bearing(results: CampaignTables) -> list[ShownTable]:
    """Torque logs, equilibria, traction, choice of oil and heat in numbers; none without logs."""
    if results.torque_runs.empty:
        return []
    facts = [
        *_torque_logs(results),
        *(_equilibria(results.torque) if len(results.torque) else []),
        *_inverted(results.torque_inversion),
        *_heat(results.heat_balance),
    ]
    shown = _quantities("bearing-numbers", "The calculation of the bearing in numbers", facts)
    return [shown, *_choice(results.slip_advice, results.advice_band)]


Fact = tuple[str, str, str]  # quantity, value, table


def _quantities(name: str, caption: str, facts: Sequence[Fact]) -> ShownTable:
    columns = [Column("quantity", "Quantity"), Column("value", "Value"), Column("table", "Table")]
    return ShownTable(name, caption, columns, facts, 0, "")


def _torque_logs(results: CampaignTables) -> list[Fact]:
    read, logs, kept = accepted_torque_logs(results)
    runs = results.torque_runs
    facts = [
        ("Torque logs read", f"{read} of {logs}", "torque_runs"),
        ("Torque logs with runs that were not refused", f"{kept} of {logs}", "torque_runs"),
        ("Plateaus accepted", f"{runs['accepted'].sum()} of {len(runs)}", "torque_runs"),
    ]
    gates = failed_gates.counts(runs)
    refused = [(f"Plateaus refused: {gate_name(str(gate))}", str(n)) for gate, n in gates.items()]
    facts += [(quantity, value, "torque_runs") for quantity, value in refused]
    for oil, count in plateaus_not_calculated(results).items():
        what = f"Plateaus of {oil} not calculated"
        facts.append((what, f"{count}: the oil {LACKING}", "torque"))
    return facts


def _equilibria(torque: pd.DataFrame) -> list[Fact]:
    sound = torque[torque["converged"]]
    lost = torque.loc[~torque["converged"], "why"]
    sizes = number(".0e")
    facts = [("Equilibria not found", f"{len(lost)} of {len(torque)}", "torque")]
    facts += [("Reason", str(why), "torque") for why in lost.unique()]
    if sound.empty:
        return facts
    by_stress = sound[sound["load_variable"] == "stress"]
    share = by_stress["traction_torque_n_m"] / by_stress["torque_n_m"]
    beyond = [
        (f"Heat of traction beyond the tested {name}, mean", by_stress[f"share_beyond_{name}"])
        for name in ("pressure", "speed", "slip")
    ]
    whole = percent(0)
    skidding = bistable_points(sound) or "none"
    facts += [
        ("Largest residual force, of the ball load", sizes(sound["residual"].max()), "torque"),
        ("Largest error of the energy balance", sizes(sound["energy_error"].abs().max()), "torque"),
        ("Largest error of integration", sizes(sound["quadrature_error"].abs().max()), "torque"),
        ("Operating points where the cage may roll or skid, left out", skidding, "torque"),
        ("Share of traction in the torque", _range(share, whole), "torque"),
    ]
    return facts + [(name, whole(values.mean()), "torque") for name, values in beyond]


def _range(values: "pd.Series[float]", form: Form) -> str:
    return f"{form(values.min())} to {form(values.max())}"


def _inverted(inversion: pd.DataFrame) -> list[Fact]:
    if inversion.empty:
        return []
    known = (inversion["verdict"] == "determined").sum()
    quantity = "Plateaus whose measured torque determines the traction coefficient"
    return [(quantity, f"{known} of {len(inversion)}", "torque_inversion")]


def _heat(balance: pd.DataFrame) -> list[Fact]:
    """What the oil's own heating changes on the map of cage slip."""
    heat = oil_heat(balance)
    if heat is None:
        return []
    outlet = _range(heat.outlet_temperature_c, number(".0f"))
    other = f"{heat.other_best_oil} of {heat.points}"
    facts = [
        ("Oil temperature at the outlet (\N{DEGREE SIGN}C)", outlet),
        ("Change of the torque by the heated oil", _range(heat.torque_change, percent(0))),
        ("Operating points where the heated oil changes the best oil", other),
    ]
    if heat.unbalanced:
        facts.append(("Cases without a steady temperature", f"{heat.unbalanced} of {heat.cases}"))
    return [(quantity, value, "heat_balance") for quantity, value in facts]


def _choice(advice: pd.DataFrame, band: pd.DataFrame) -> list[ShownTable]:
    """The paper's choice of oil by cage slip beside the best oil, counted over operating points."""
    judged = advice[~advice["judgement"].isin(["no film", OUTSIDE])]
    if judged.empty:
        return []
    total, others = len(judged), judged[judged["judgement"] != "agree"]
    facts = [("The advice agrees with the best oil", f"{total - len(others)} of {total}")]
    facts += [
        (OTHER_CHOICES.get(str(judgement), str(judgement)), f"{count} of {total}")
        for judgement, count in others["judgement"].value_counts().items()
    ]
    facts += [
        (f"{oil} is the best oil where the advice differs", f"{count} of {total}")
        for oil, count in others["best_oil"].value_counts().items()
    ]
    shown = [(quantity, value, "slip_advice") for quantity, value in facts]
    if len(band):
        fraction = band["oil_volume_fraction"]
        drag = _range(fraction, number(".2g"))
        shown += [
            (
                f"The advice agrees, with oil volume fraction {drag} and "
                f"{band['refit'].max()} refits of the law",
                f"{_range(band['agreeing_points'], number('.0f'))} of {total}",
                "advice_band",
            ),
            (
                "The best oil is as good as any other with every drag and refit",
                f"{(judged['best_oil_share'] == 1).sum()} of {total}",
                "slip_advice",
            ),
        ]
    caption = "The paper's choice of oil by cage slip beside the calculated best oil"
    return [_quantities("oil-choice", f"{caption}, counted over operating points", shown)]
