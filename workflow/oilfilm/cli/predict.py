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
from oilfilm.cli.arguments import json_line, results_and_footer, typed_conditions, typed_quantity
from oilfilm.cli.parser import CONDITION_OPTIONS
from oilfilm.fits.fitted import SLIP, FittedLaw, read_fit, refuse_impossible_values
from oilfilm.fits.support_sentences import why_no_support
from oilfilm.fits.surface_sentences import next_rig_sentences

_PRESSURE_COLUMN, _LOAD_COLUMN = "max_hertz_pressure_gpa", "load_n"


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    operating_point = {SLIP: typed_quantity(options.slip, "dimensionless", "--slip")}
    operating_point |= typed_conditions(options)
    fitted_law: FittedLaw
    if options.printed:
        fitted_law, source = studies.published_law(options.oil), "published constants"
    else:
        folder, footer = results_and_footer(options.results)
        fitted_law = read_fit(folder, options.oil)
        source = f"from campaign {footer['campaign']}, {footer['data']} data"
    predicted_row, sentences = prediction(fitted_law, options.oil, operating_point, options.rig)
    sentences.append(source)
    if options.json:
        print(json_line({**predicted_row, "law": fitted_law.law.name, "sentences": sentences}))
    else:
        print("\n".join(sentences))
    return 0


def prediction(
    fitted_law: FittedLaw,
    oil_name: str,
    operating_point: Mapping[str, float],
    rig_name: str | None = None,
) -> tuple[dict[str, Any], list[str]]:
    """Prediction of a fit at one operating point: a row of `Prediction.to_frame`, and sentences.

    Args:
        fitted_law: The fitted law.
        oil_name: Name of its oil.
        operating_point: Slide-roll ratio and conditions by their columns' names. A condition that
            the fit does not follow may be left out. mu is then given at its tested level.
        rig_name: Rig of the next run, as `FittedLaw.predict` takes it.

    Raises:
        OilfilmError: The fit has no value there, or a condition is missing or too many.
    """
    operating_point, pressure_sentences = _with_pressure(fitted_law, operating_point)
    _refuse_other_conditions(fitted_law, oil_name, operating_point)
    for column, value in operating_point.items():
        refuse_impossible_values(np.array([value]), column)
    slip = np.array([operating_point[SLIP]])
    law_columns = fitted_law.law.conditions
    conditions = np.array([[operating_point.get(column, np.nan) for column in law_columns]])
    if rig_name is not None and fitted_law.surface is None:
        raise OilfilmError(
            f"{oil_name}: --rig {rig_name} needs the interval of a run; "
            f"{fitted_law.why_no_interval}."
        )
    try:
        predicted = fitted_law.predict(conditions, slip, rig=rig_name)
    except ValueError as error:
        raise OilfilmError(f"{oil_name}: {error}.") from None
    if np.isnan(fitted_law.coefficients.constants).any():
        raise OilfilmError(f"{oil_name}: nothing could be fitted; see results/*/summary.txt.")
    conditions_off_tested = fitted_law.off_tested_levels(conditions)
    if conditions_off_tested:
        advice = "Give a tested value. Without the option the tested value is used."
        if any(fixed_condition.line_reaches_zero for fixed_condition in conditions_off_tested):
            advice = "Leave the option out. mu is then that of the tests."
        if any(fixed_condition.is_unmeasured for fixed_condition in conditions_off_tested):
            advice = (
                "Leave the option out. For a pressure, fill in `ball_radius_m`, `ball` and `disc` "
                "of the rig's file (roughness is not needed). Then run again. Or fit a law of load."
            )
        reasons = "; ".join(fixed_condition.sentence() for fixed_condition in conditions_off_tested)
        raise OilfilmError(f"{oil_name}: mu is not known there: {reasons}. {advice}")
    (row,) = tables.rows(predicted.to_frame())
    if not np.isfinite(row["traction_coefficient"]):
        raise OilfilmError(f"{oil_name}: the law {fitted_law.law.name} has no value there.")
    evaluated_conditions = fitted_law.at_tested_levels(conditions)
    sentences = [*_lines_of_intervals(fitted_law, oil_name, row), *pressure_sentences]
    if fitted_law.surface is not None and not fitted_law.surface.sizes.converged:
        sentences.append(
            "NOT SURE: the search of the surface ended before its maximum; the interval rests on "
            "its last step"
        )
    if fitted_law.surface is not None:
        sentences += next_rig_sentences(fitted_law.surface, rig_name)
    sentences += fitted_law.remarks(evaluated_conditions, slip)
    sentences += [f"NOT SOUND: {reason}" for reason in fitted_law.warnings]
    for fixed_condition in fitted_law.coefficients.fixed_conditions:
        sentences.append(
            f"mu and its interval are those where it was tested: {fixed_condition.sentence()}"
        )
    evaluated_point = [*evaluated_conditions[0], operating_point[SLIP]]
    sentences += _lines_of_warnings(fitted_law, evaluated_point, row)
    return row, sentences


def _with_pressure(
    fitted_law: FittedLaw, operating_point: Mapping[str, float]
) -> tuple[dict[str, float], list[str]]:
    """The operating point with the pressure in place of the load, and a sentence that says so.

    The contact is that of the runs behind the fit. Nothing changes where the law takes the load, or
    where the pressure is given as well.

    Raises:
        OilfilmError: The contact is not known, or the runs have several.
    """
    new_point = dict(operating_point)
    law_takes_load = _LOAD_COLUMN in fitted_law.law.conditions
    if _LOAD_COLUMN not in new_point or law_takes_load or _PRESSURE_COLUMN in new_point:
        return new_point, []
    load_n = new_point.pop(_LOAD_COLUMN)
    refuse_impossible_values(np.array([load_n]), _LOAD_COLUMN)
    load_at_1_gpa = np.nan
    if fitted_law.surface is not None:
        load_at_1_gpa = fitted_law.surface.contact.load_at_1_gpa
    if not np.isfinite(load_at_1_gpa):
        raise OilfilmError(
            "--load: the law takes the maximum Hertz pressure, and the contact that gives it is "
            "not known: the runs of the fit have no load, several contacts or no surface. Give the "
            "pressure: --stress 1.2GPa."
        )
    pressure_gpa = float(np.cbrt(load_n / load_at_1_gpa))
    new_point[_PRESSURE_COLUMN] = pressure_gpa
    sentence = f"{load_n:g} N is a maximum pressure of {pressure_gpa:.4g} GPa in the rig's contact"
    return new_point, [sentence]


def _lines_of_intervals(
    fitted_law: FittedLaw, oil_name: str, row: Mapping[str, Any]
) -> Iterator[str]:
    """mu with its two intervals, or the reason why there are none."""
    source = "surface of measured mu" if row["from_surface"] else fitted_law.law.name
    mu_text = f"{oil_name}, {source}: mu = {row['traction_coefficient']:.5f}"
    if row["from_surface"]:
        misfit_text = f"misfit {fitted_law.misfit_of_surface_law:.1%}"
        yield f"no law fits ({misfit_text}): mu is that of the measurements"
    if np.isnan(row["obs_ci_lower"]):
        reason = fitted_law.why_no_interval
        if fitted_law.surface is not None:
            reason = why_no_support(row["support"], fitted_law.surface.limits)
            reason = reason or "mu is 0 at pure rolling"
        yield f"{mu_text}, no interval, because {reason}"
        return
    interval_name = f"{fitted_law.interval_level():.0%} interval of the next good run"
    yield f"{mu_text}, {interval_name} {row['obs_ci_lower']:.5f} to {row['obs_ci_upper']:.5f}"
    mean_curve_name = "mean curve of the oil, with calibration and misfit of the law"
    yield f"{mean_curve_name}: {row['mean_ci_lower']:.5f} to {row['mean_ci_upper']:.5f}"


def _lines_of_warnings(
    fitted_law: FittedLaw, values: Sequence[float], row: Mapping[str, Any]
) -> Iterator[str]:
    """Warnings about mu outside the tested conditions, or above what any film carries."""
    columns = (*fitted_law.law.conditions, SLIP)
    box = fitted_law.widened_box.tolist()
    for column, value, (lowest, highest) in zip(columns, values, box, strict=True):
        # mu has the same size at the opposite slip; no other condition has a mirror image
        tested_side_value = abs(value) if column == SLIP else value
        # a condition without tested levels has no range
        if np.isfinite([lowest, value]).all() and not lowest <= tested_side_value <= highest:
            value_and_range = f"{column} {value:g}, tested {lowest:.4g} to {highest:.4g}"
            unit = tables.COLUMNS[column].shown_unit
            yield f"OUTSIDE the tested box: {value_and_range} {unit}".rstrip()
    if row["over_limit"]:
        yield (
            "IMPOSSIBLE: mu is the mean shear stress over the mean pressure; no film of the oil "
            f"carries more than {fitted_law.coefficients.limiting_stress_ratio:g} of it"
        )
    if row["spacings"] > 1:
        steps_away = f"{row['spacings']:.1f} of their own steps away"
        yield f"OUTSIDE: the nearest tested conditions are {steps_away}"
    if row["distance"] > 0:
        distance_text = f"{row['distance']:.1f} tested ranges outside"
        yield f"{distance_text}: the interval holds only if the law does"


def _refuse_other_conditions(
    fitted_law: FittedLaw, oil_name: str, operating_point: Mapping[str, float]
) -> None:
    """Refuse conditions that the law does not take, and missing ones that it needs.

    Raises:
        OilfilmError: There is one.
    """
    law_conditions = set(fitted_law.law.conditions)
    other_conditions = operating_point.keys() - law_conditions - {SLIP}
    if other_conditions:
        option_by_condition = {
            condition: option for option, (condition, _, _) in CONDITION_OPTIONS.items()
        }
        refused_options = [option_by_condition[name] for name in sorted(other_conditions)]
        taken_options = [option_by_condition.get(name, name) for name in fitted_law.law.conditions]
        raise OilfilmError(
            f"{oil_name}: the law {fitted_law.law.name} does not take "
            f"{', '.join(refused_options)}. It takes {', '.join(taken_options)}."
        )
    not_followed = {
        fixed_condition.condition for fixed_condition in fitted_law.coefficients.fixed_conditions
    }
    missing_conditions = law_conditions - not_followed - operating_point.keys()
    for option, (condition, _, example) in CONDITION_OPTIONS.items():
        if condition in missing_conditions:
            raise OilfilmError(
                f"{oil_name}: the fit depends on {condition}. Give it, as {option} {example}."
            )
