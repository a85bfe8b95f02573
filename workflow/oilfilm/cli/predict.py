"""The command `oilfilm predict`: the traction coefficient of a fitted or printed oil.

Decides: when a prediction is refused; which marks a prediction outside the tested box gets.
"""

import argparse
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from oilfilm import tables
from oilfilm.base import studies
from oilfilm.base.errors import OilfilmError
from oilfilm.cli.arguments import campaign_folder, json_line, quantity, typed_conditions
from oilfilm.cli.parser import CONDITION_OPTIONS
from oilfilm.fits.fitted import SLIP, FittedLaw, read_fit, refuse_impossible
from oilfilm.fits.support_sentences import why_no_support
from oilfilm.fits.surface_sentences import next_rig_sentences

_PRESSURE, _LOAD = "max_hertz_pressure_gpa", "load_n"


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    operating_point = {SLIP: quantity(options.slip, "dimensionless", "--slip")}
    operating_point |= typed_conditions(options)
    fit: FittedLaw
    if options.printed:
        fit, source = studies.published_law(options.oil), "published constants"
    else:
        folder, campaign_facts = campaign_folder(options.results)
        fit = read_fit(folder, options.oil)
        source = f"from campaign {campaign_facts['campaign']}, {campaign_facts['data']} data"
    predicted, sentences = prediction(fit, options.oil, operating_point, options.rig)
    sentences.append(source)
    if options.json:
        print(json_line({**predicted, "law": fit.law.name, "sentences": sentences}))
    else:
        print("\n".join(sentences))
    return 0


def prediction(
    fit: FittedLaw, oil: str, operating_point: Mapping[str, float], rig: str | None = None
) -> tuple[dict[str, Any], list[str]]:
    """Prediction of a fit at one operating point: a row of `Prediction.to_frame`, and sentences.

    Args:
        fit: The fitted law.
        oil: Name of its oil.
        operating_point: Slide-roll ratio and conditions by their columns' names. A condition that
            the fit does not follow may be left out. mu is then given at its tested level.
        rig: Rig of the next run, as `FittedLaw.predict` takes it.

    Raises:
        OilfilmError: The fit has no value there, or a condition is missing or too many.
    """
    operating_point, pressure_of_load = _with_pressure(fit, operating_point)
    _refuse_other_conditions(fit, oil, operating_point)
    for name, value in operating_point.items():
        refuse_impossible(np.array([value]), name)
    slip = np.array([operating_point[SLIP]])
    conditions = np.array([[operating_point.get(name, np.nan) for name in fit.law.conditions]])
    if rig is not None and fit.surface is None:
        raise OilfilmError(
            f"{oil}: --rig {rig} needs the interval of a run; {fit.why_no_interval}."
        )
    try:
        predicted = fit.predict(conditions, slip, rig=rig)
    except ValueError as error:
        raise OilfilmError(f"{oil}: {error}.") from None
    if np.isnan(fit.coefficients.constants).any():
        raise OilfilmError(f"{oil}: nothing could be fitted; see results/*/summary.txt.")
    conditions_off_tested = fit.off_tested_levels(conditions)
    if conditions_off_tested:
        advice = "Give a tested value. Without the option the tested value is used."
        if any(condition.level is None for condition in conditions_off_tested):
            advice = (
                "Leave the option out. For a pressure, fill in `ball_radius_m`, `ball` and `disc` "
                "of the rig's file (roughness is not needed). Then run again. Or fit a law of load."
            )
        reasons = "; ".join(condition.sentence() for condition in conditions_off_tested)
        raise OilfilmError(f"{oil}: mu is not known there: {reasons}. {advice}")
    (row,) = tables.rows(predicted.to_frame())
    if not np.isfinite(row["traction_coefficient"]):
        raise OilfilmError(f"{oil}: the law {fit.law.name} has no value there.")
    evaluated_conditions = fit.at_tested_levels(conditions)
    sentences = [*_lines_of_intervals(fit, oil, row), *pressure_of_load]
    if fit.surface is not None and not fit.surface.sizes.converged:
        sentences.append(
            "NOT SURE: the search of the surface ended before its maximum; the interval rests on "
            "its last step"
        )
    if fit.surface is not None:
        sentences += next_rig_sentences(fit.surface, rig)
    sentences += fit.remarks(evaluated_conditions, slip)
    sentences += [f"NOT SOUND: {reason}" for reason in fit.warnings]
    for condition in fit.coefficients.fixed_conditions:
        sentences.append(
            f"mu and its interval are those where it was tested: {condition.sentence()}"
        )
    sentences += _lines_of_warnings(fit, [*evaluated_conditions[0], operating_point[SLIP]], row)
    return row, sentences


def _with_pressure(
    fit: FittedLaw, operating_point: Mapping[str, float]
) -> tuple[dict[str, float], list[str]]:
    """The operating point with the pressure in place of the load, and a sentence that says so.

    The contact is that of the runs behind the fit. Nothing changes where the law takes the load, or
    where the pressure is given as well.

    Raises:
        OilfilmError: The contact is not known, or the runs have several.
    """
    point = dict(operating_point)
    if _LOAD not in point or _LOAD in fit.law.conditions or _PRESSURE in point:
        return point, []
    load_n = point.pop(_LOAD)
    refuse_impossible(np.array([load_n]), _LOAD)
    load_at_1_gpa = np.nan if fit.surface is None else fit.surface.contact.load_at_1_gpa
    if not np.isfinite(load_at_1_gpa):
        raise OilfilmError(
            "--load: the law takes the maximum Hertz pressure, and the contact that gives it is "
            "not known: the runs of the fit have no load, several contacts or no surface. Give the "
            "pressure: --stress 1.2GPa."
        )
    point[_PRESSURE] = float(np.cbrt(load_n / load_at_1_gpa))
    sentence = (
        f"{load_n:g} N is a maximum pressure of {point[_PRESSURE]:.4g} GPa in the rig's contact"
    )
    return point, [sentence]


def _lines_of_intervals(fit: FittedLaw, oil: str, row: Mapping[str, Any]) -> Iterator[str]:
    """mu with its two intervals, or the reason why there are none."""
    source = "surface of measured mu" if row["from_surface"] else fit.law.name
    mu = f"{oil}, {source}: mu = {row['traction_coefficient']:.5f}"
    if row["from_surface"]:
        yield f"no law fits (misfit {fit.misfit:.1%}): mu is that of the measurements"
    if np.isnan(row["obs_ci_lower"]):
        reason = fit.why_no_interval
        if fit.surface is not None:
            reason = why_no_support(row["support"], fit.surface.limits) or "mu is 0 at pure rolling"
        yield f"{mu}, no interval, because {reason}"
        return
    name_of_interval = f"{fit.interval_level():.0%} interval of the next good run"
    yield f"{mu}, {name_of_interval} {row['obs_ci_lower']:.5f} to {row['obs_ci_upper']:.5f}"
    mean_curve = "mean curve of the oil, with calibration and misfit of the law"
    yield f"{mean_curve}: {row['mean_ci_lower']:.5f} to {row['mean_ci_upper']:.5f}"


def _lines_of_warnings(
    fit: FittedLaw, values: Sequence[float], row: Mapping[str, Any]
) -> Iterator[str]:
    """Warnings about mu outside the tested conditions, or above what any film carries."""
    names = (*fit.law.conditions, SLIP)
    for name, value, (low, high) in zip(names, values, fit.widened_box.tolist(), strict=True):
        # a condition without tested levels has no range
        if np.isfinite([low, value]).all() and not low <= abs(value) <= high:
            tested = f"{name} {value:g}, tested {low:.4g} to {high:.4g}"
            yield f"OUTSIDE the tested box: {tested} {tables.COLUMNS[name].shown_unit}".rstrip()
    if row["over_limit"]:
        yield (
            "IMPOSSIBLE: mu is the mean shear stress over the mean pressure; no film of the oil "
            f"carries more than {fit.coefficients.limiting_stress_ratio:g} of it"
        )
    if row["spacings"] > 1:
        steps = f"{row['spacings']:.1f} of their own steps away"
        yield f"OUTSIDE: the nearest tested conditions are {steps}"
    if row["distance"] > 0:
        ranges = f"{row['distance']:.1f} tested ranges outside"
        yield f"{ranges}: the interval holds only if the law does"


def _refuse_other_conditions(
    fit: FittedLaw, oil: str, operating_point: Mapping[str, float]
) -> None:
    """Refuse conditions that the law does not take, and missing ones that it needs.

    Raises:
        OilfilmError: There is one.
    """
    conditions = set(fit.law.conditions)
    conditions_too_many = operating_point.keys() - conditions - {SLIP}
    if conditions_too_many:
        option_by_condition = {name: option for option, (name, _, _) in CONDITION_OPTIONS.items()}
        raise OilfilmError(
            f"{oil}: the law {fit.law.name} does not take "
            f"{', '.join(option_by_condition[name] for name in sorted(conditions_too_many))}. "
            "It takes "
            f"{', '.join(option_by_condition.get(name, name) for name in fit.law.conditions)}."
        )
    not_followed = {fixed.condition for fixed in fit.coefficients.fixed_conditions}
    missing = conditions - not_followed - operating_point.keys()
    for option, (name, _, example) in CONDITION_OPTIONS.items():
        if name in missing:
            raise OilfilmError(f"{oil}: the fit depends on {name}. Give it, as {option} {example}.")
