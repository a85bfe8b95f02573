"""The command `oilfilm predict`: the traction coefficient of a fitted or printed oil.

Decides: when a prediction is refused; what is said of a prediction outside the tested box.
"""

import argparse
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from oilfilm import studies, tables
from oilfilm.cli.arguments import campaign_folder, json_line, quantity, typed_conditions
from oilfilm.cli.parser import CONDITION_OPTIONS
from oilfilm.errors import OilfilmError
from oilfilm.fits.fitted import SLIP, FittedLaw, read_fit, refuse_impossible


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    at = {SLIP: quantity(options.slip, "dimensionless", "--slip"), **typed_conditions(options)}
    fit: FittedLaw
    if options.printed:
        (study,) = studies.load(studies.available())
        fit, source = study.published_law(options.oil), "constants as the paper prints them"
    else:
        folder, about = campaign_folder(options.results)
        fit = read_fit(folder, options.oil)
        source = f"from campaign {about['campaign']}, {about['data']} data"
    found, sentences = prediction(fit, options.oil, at)
    if options.json:
        print(json_line({**found, "law": fit.law.name, "sentences": [*sentences, source]}))
    else:
        print("\n".join([*sentences, source]))
    return 0


def prediction(
    fit: FittedLaw, oil: str, at: Mapping[str, float]
) -> tuple[dict[str, Any], list[str]]:
    """Prediction of a fit at one operating point: a row of `Prediction.to_frame`, and sentences.

    Args:
        fit: The fitted law.
        oil: Name of its oil.
        at: Slide-roll ratio and conditions by their columns' names. A condition that the fit does
            not follow may be left out: mu is then given at its tested level.

    Raises:
        OilfilmError: The fit has no value there, or a condition is missing or too many.
    """
    _refuse_other_conditions(fit, oil, at)
    for name, value in at.items():
        refuse_impossible(np.array([value]), name)
    slip = np.array([at[SLIP]])
    conditions = np.array([[at.get(name, np.nan) for name in fit.law.conditions]])
    try:
        predicted = fit.predict(conditions, slip)
    except ValueError as error:
        raise OilfilmError(f"{oil}: {error}.") from None
    if np.isnan(fit.coefficients.constants).any():
        raise OilfilmError(f"{oil}: nothing could be fitted; see results/*/summary.txt.")
    if away := fit.away_from(conditions):
        advice = "Give a point on it. Without the option the tested value is used."
        if any(each.level is None for each in away):
            advice = (
                "Leave the option out. For a pressure fill in `ball_radius_m`, `ball` and `disc` "
                "of the rig's file (roughness is not needed) and run again, or fit a law of load."
            )
        there = "; ".join(each.sentence() for each in away)
        raise OilfilmError(f"{oil}: mu is not known there: {there}. {advice}")
    (found,) = tables.rows(predicted.to_frame())
    if not np.isfinite(found["traction_coefficient"]):
        raise OilfilmError(f"{oil}: the law {fit.law.name} has no value there.")
    line = fit.on_line(conditions)
    return found, [
        *_intervals(fit, oil, found),
        *fit.remarks(line, slip),
        *(f"NOT SOUND: {each}" for each in fit.wrong),
        *(
            f"mu and its interval are those where it was tested: {each.sentence()}"
            for each in fit.coefficients.fixed
        ),
        *_marks(fit, [*line[0], at[SLIP]], found),
    ]


def _intervals(fit: FittedLaw, oil: str, found: Mapping[str, Any]) -> Iterator[str]:
    mu = f"{oil}, {fit.law.name}: mu = {found['traction_coefficient']:.5f}"
    if np.isnan(found["obs_ci_lower"]):
        yield f"{mu}, no interval, because {fit.no_interval}"
        return
    level = f"{fit.coefficients.unseen.at(0.95)[0]:.0%} interval of the next good run"
    yield f"{mu}, {level} {found['obs_ci_lower']:.5f} to {found['obs_ci_upper']:.5f}"
    own = "if the law is true, mu is {mean_ci_lower:.5f} to {mean_ci_upper:.5f}"
    yield own.format_map(found)


def _marks(fit: FittedLaw, at: Sequence[float], found: Mapping[str, Any]) -> Iterator[str]:
    """What must be known of mu beyond what was tested, or above what any film carries."""
    names = (*fit.law.conditions, SLIP)
    for name, value, (low, high) in zip(names, at, fit.reach.tolist(), strict=True):
        if np.isfinite([low, value]).all() and not low <= abs(value) <= high:
            tested = f"{name} {value:g}, tested {low:.4g} to {high:.4g}"
            yield f"OUTSIDE the tested box: {tested} {tables.COLUMNS[name].shown_unit}".rstrip()
    if found["over_limit"]:
        yield (
            "IMPOSSIBLE: mu is the mean shear stress over the mean pressure; no film of the oil "
            f"carries more than {fit.coefficients.limiting_stress_ratio:g} of it"
        )
    if found["spacings"] > 1:
        steps = f"{found['spacings']:.1f} of their own steps away"
        yield f"OUTSIDE: the nearest tested conditions are {steps}"
    if (ranges := found["distance"]) > 0:
        yield f"{ranges:.1f} tested ranges outside: the interval holds only if the law does"


def _refuse_other_conditions(fit: FittedLaw, oil: str, at: Mapping[str, float]) -> None:
    """Refuse conditions that the law does not take, and missing ones that it needs."""
    wanted, fixed = fit.law.conditions, {each.condition for each in fit.coefficients.fixed}
    if others := ", ".join(at.keys() - {*wanted, SLIP}):
        takes = f"It takes {', '.join(wanted)}."
        raise OilfilmError(f"{oil}: the law {fit.law.name} does not take {others}. {takes}")
    for option, (name, _, example) in CONDITION_OPTIONS.items():
        if name in {*wanted} - fixed - at.keys():
            raise OilfilmError(f"{oil}: the fit depends on {name}. Give it, as {option} {example}.")
