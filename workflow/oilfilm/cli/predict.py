"""The command `oilfilm predict`: the traction coefficient of a fitted or printed oil.

Decides: when a prediction is refused; what is said of a prediction outside the tested box.
"""

import argparse
from collections.abc import Mapping
from typing import Any

import numpy as np

import oilfilm
from oilfilm import tables
from oilfilm.cli.arguments import campaign_folder, json_text, quantity, typed_conditions
from oilfilm.cli.parser import CONDITION_OPTIONS
from oilfilm.errors import OilfilmError
from oilfilm.fits.fitted import INTERVALS, SLIP, FittedLaw, read_fit, refuse_impossible
from oilfilm.paper.printed_law import PrintedLaw


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    at = {SLIP: quantity(options.slip, "dimensionless", "--slip"), **typed_conditions(options)}
    fit: FittedLaw
    if options.printed:
        fit, source = oilfilm.printed(options.oil), "constants as the paper prints them"
    else:
        folder, about = campaign_folder(options.results)
        fit = read_fit(folder, options.oil)
        source = f"from campaign {about['campaign']}, {about['data']} data"
    predicted = prediction(fit, options.oil, at, source)
    if isinstance(fit, PrintedLaw):
        line = np.array([[predicted["at"][name] for name in fit.law.conditions]])
        ends = fit.sign_range(line, np.array([at[SLIP]]))
        predicted |= {"signs": dict(fit.signs), "sign_range": [float(end[0]) for end in ends]}
    print(json_text(predicted) if options.json else _text(predicted))
    return 0


def prediction(
    fit: FittedLaw, oil: str, at: Mapping[str, float], source: str = ""
) -> dict[str, Any]:
    """Prediction of a fit at one operating point, as plain values; NaN where unknown.

    Args:
        fit: The fitted law.
        oil: Name of its oil.
        at: Slide-roll ratio and conditions by their columns' names. A condition that the fit does
            not follow may be left out: mu is then given at its tested level.
        source: Where the constants are from, in words.

    Raises:
        OilfilmError: The fit has no value there, or a condition is missing or too many.
    """
    _refuse_other_conditions(fit, oil, at)
    for name, value in at.items():
        refuse_impossible(np.array([value]), name)
    conditions = np.array([[at.get(name, np.nan) for name in fit.law.conditions]])
    try:
        predicted = fit.predict(conditions, np.array([at[SLIP]]))
    except ValueError as error:
        raise OilfilmError(f"{oil}: {error}.") from None
    if np.isnan(fit.coefficients.constants).any():
        raise OilfilmError(f"{oil}: nothing could be fitted; see results/*/summary.txt.")
    line = dict(zip(fit.law.conditions, fit.on_line(conditions)[0].tolist(), strict=True))
    if away := fit.away_from(conditions):
        advice = "Give a point on it. Without the option the tested value is used."
        if any(each.level is None for each in away):
            advice = (
                "Leave the option out. For a pressure fill in `ball_radius_m`, `ball` and `disc` "
                "of the rig's file (roughness is not needed) and run again, or fit a law of load."
            )
        there = "; ".join(each.sentence() for each in away)
        raise OilfilmError(f"{oil}: mu is not known there: {there}. {advice}")
    at = {**line, SLIP: at[SLIP]}
    mu, ranges = float(predicted.traction_coefficient[0]), float(predicted.distance[0])
    intervals = {name: float(getattr(predicted, name)[0]) for name in INTERVALS}
    if not np.isfinite(mu):
        raise OilfilmError(f"{oil}: the law {fit.law.name} has no value there.")
    why = "too few curves were tested (fit.min_curves_for_errors)"
    if isinstance(fit, PrintedLaw):
        why = "the paper states none"
    return {
        "oil": oil,
        "law": fit.law.name,
        "source": source,
        "at": at,
        "traction_coefficient": mu,
        "level": fit.coefficients.unseen.at(0.95)[0],
        **intervals,
        "fixed": [each.sentence() for each in fit.coefficients.fixed],
        "outside": [
            {"quantity": name, "value": value, "minimum": low, "maximum": high}
            for (name, value), (low, high) in zip(at.items(), fit.reach.tolist(), strict=True)
            if np.isfinite([low, value]).all() and not low <= abs(value) <= high
        ],
        "tested_ranges_outside": ranges,
        "spacings": float(predicted.spacings[0]),
        "limiting_stress_ratio": fit.coefficients.limiting_stress_ratio,
        "over_limiting_stress": bool(predicted.over_limit[0]),
        "wrong": [*fit.wrong],
        "no_interval": f"no interval, because {why}" if np.isnan(intervals["obs_ci_lower"]) else "",
    }


def _text(predicted: Mapping[str, Any]) -> str:
    """A prediction in sentences."""
    found = "{oil}, {law}: mu = {traction_coefficient:.5f}, ".format_map(predicted)
    interval = "{level:.0%} interval of the next good run {obs_ci_lower:.5f} to {obs_ci_upper:.5f}"
    lines = [found + (predicted["no_interval"] or interval.format_map(predicted))]
    if not predicted["no_interval"]:
        own = "if the law is true, mu is {mean_ci_lower:.5f} to {mean_ci_upper:.5f}"
        lines.append(own.format_map(predicted))
    if "signs" in predicted:
        signs = ", ".join(f"{name} {sure}" for name, sure in predicted["signs"].items())
        lines.append(f"restored signs: {signs}")
        lines.append("over the open signs mu is {:.5f} to {:.5f}".format(*predicted["sign_range"]))
    lines += [f"NOT SOUND: {each}" for each in predicted["wrong"]]
    lines += [
        f"mu and its interval are those where it was tested: {each}" for each in predicted["fixed"]
    ]
    for each in predicted["outside"]:
        tested = "{quantity} {value:g}, tested {minimum:.4g} to {maximum:.4g}".format_map(each)
        unit = tables.COLUMNS[each["quantity"]].shown_unit
        lines.append(f"OUTSIDE the tested box: {tested} {unit}".rstrip())
    if predicted["over_limiting_stress"]:
        lines.append(
            "IMPOSSIBLE: mu is the mean shear stress over the mean pressure; no film of the oil "
            "carries more than {limiting_stress_ratio:g} of it".format_map(predicted)
        )
    if predicted["spacings"] > 1:
        away = "OUTSIDE: the nearest tested conditions are {spacings:.1f} of their own steps away"
        lines.append(away.format_map(predicted))
    if (ranges := predicted["tested_ranges_outside"]) > 0:
        lines.append(f"{ranges:.1f} tested ranges outside: the interval holds only if the law does")
    return "\n".join([*lines, predicted["source"]])


def _refuse_other_conditions(fit: FittedLaw, oil: str, at: Mapping[str, float]) -> None:
    """Refuse conditions that the law does not take, and missing ones that it needs."""
    wanted, fixed = fit.law.conditions, {each.condition for each in fit.coefficients.fixed}
    if others := ", ".join(at.keys() - {*wanted, SLIP}):
        takes = f"It takes {', '.join(wanted)}."
        raise OilfilmError(f"{oil}: the law {fit.law.name} does not take {others}. {takes}")
    for option, (name, _, example) in CONDITION_OPTIONS.items():
        if name in {*wanted} - fixed - at.keys():
            raise OilfilmError(f"{oil}: the fit depends on {name}. Give it, as {option} {example}.")
