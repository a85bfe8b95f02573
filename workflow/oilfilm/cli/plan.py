"""The command `oilfilm plan`: the runs that a campaign lacks, and the tests to run next."""

import argparse
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd

from oilfilm.api.folders import config_folder, project_folder
from oilfilm.base.errors import OilfilmError
from oilfilm.base.units import FloatArray
from oilfilm.cli.arguments import results_and_footer, typed_quantity
from oilfilm.cli.parser import DUTY_EXAMPLE
from oilfilm.fits.measured_curves import rms_uncertainty, uncertainties
from oilfilm.settings.resolve import named_content, resolve
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.torque.answers import CAUSE_BY_NAME, UncertaintyBudget
from oilfilm.torque.feasible_tests import limits_with_counts
from oilfilm.torque.next_tests import NextTests, PlanRequest, plan_tests, request_from_settings
from oilfilm.torque.run_plan import MeasuredRuns, RunPlan, plan_runs
from oilfilm.torque.wanted_quantities import BEARING_TARGETS
from oilfilm.traction.law import CONDITIONS, QUANTITIES

# The value of --for that plans runs; the others are targets of `oilfilm.torque.wanted_quantities`.
_CAMPAIGN_TARGET = "campaign"
_DUTY_UNITS = ("N", "rpm", "degC")
# How the uncertainty of each target is printed: name, factor that converts it to the unit, unit.
_PRINTED_TARGETS = {
    "torque": ("friction torque", 100.0, " %"),
    "cage_slip": ("cage slip", 1.0, ""),
    "traction": ("mu", 100.0, " %"),
}
_RUN_COLUMNS = [*CONDITIONS, "load_n", "slide_roll_ratio", "lambda_ratio"]
# Why a run is made, by the codes of the column `run_reason`.
_SENTENCE_BY_REASON = {
    "reference": (
        "every sixth run, always at the same condition. It shows whether the rig has changed, and "
        "joins the new runs to the old ones"
    ),
    "planned": "the campaign's matrix has the condition, and no accepted run does",
    "third_level": "a law cannot be checked between two levels of a condition",
    "not_varied": "the effect of a condition is not known where it has one level",
    "corner": "no run is near this corner of the tested ranges, where a law is least certain",
    "repeat": "a condition that was measured, to know how runs scatter and drift",
    "first_plan": "nothing was measured yet: three pressures, four speeds, six temperatures",
}
_CONDITION_IN_WORDS = {
    "max_hertz_pressure_gpa": "pressure",
    "entrainment_speed_m_s": "speed",
    "inlet_temperature_c": "temperature",
}
ASSUMPTION = (
    "The plan allows for an error of the law's form: what the measured surface leaves open, and "
    "bearing.law_error_beyond where it has no interval. Only the uncertainty from the law is "
    "planned for. `oilfilm bearing` shows all shares of the variance, with the ranges that were "
    "drawn."
)


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    settings_folder = config_folder(options.config)
    if options.campaign is not None:
        if options.results is not None:
            raise OilfilmError(
                "--campaign: found beside --results; expected one of the two: --results names a "
                "campaign that has results, --campaign one that need not have any."
            )
        results_folder = project_folder(options.config) / "results" / options.campaign
        if not (results_folder / "tables").is_dir():
            settings = resolve(settings_folder, {"campaign": options.campaign})
            return _print_first_plan(options, settings)
        options.results = results_folder
    results_folder, footer = results_and_footer(options.results)
    settings = resolve(settings_folder, {"campaign": footer["campaign"]})
    results = CampaignTables.from_folder(results_folder)
    texts, reasons = _plans_of_runs(options, results, settings, str(results_folder))
    if options.target == _CAMPAIGN_TARGET:
        _refuse_options_of_tests(options, "--for campaign plans no tests")
    else:
        request = _requested_plan(options, settings, settings_folder)
        more_texts, more_reasons = _plans_of_tests(
            options, results, settings, request, str(results_folder)
        )
        texts += more_texts
        reasons += more_reasons
    if not texts:
        raise OilfilmError(" ".join(dict.fromkeys(reasons)))
    texts += [f"not planned: {reason}" for reason in dict.fromkeys(reasons)]
    print("\n\n".join(texts))
    print(f"from campaign {footer['campaign']}, {footer['data']} data")
    return 0


def _plans_of_runs(
    options: argparse.Namespace, results: CampaignTables, settings: Settings, results_folder: str
) -> tuple[list[str], list[str]]:
    """Plans of runs as texts, unless only tests are wanted, and the reasons for missing plans."""
    texts: list[str] = []
    reasons: list[str] = []
    if options.target not in (None, _CAMPAIGN_TARGET):
        return texts, reasons
    for oil_name in _chosen_oils(options, list(settings.oils), f"{results_folder}: no oil"):
        try:
            measured_runs = MeasuredRuns.from_results(results, settings, oil_name)
            plan = plan_runs(measured_runs, settings, oil_name)
            texts.append("\n".join(_lines_of_runs(plan)))
        except OilfilmError as reason:
            reasons.append(str(reason))
    return texts, reasons


def _plans_of_tests(
    options: argparse.Namespace,
    results: CampaignTables,
    settings: Settings,
    request: PlanRequest,
    results_folder: str,
) -> tuple[list[str], list[str]]:
    """Plans of tests as texts, one per oil and target, and the reasons for missing plans."""
    texts: list[str] = []
    reasons: list[str] = []
    fitted_oils = set(results.configured_fits.coefficients["oil"])
    for oil_name in _chosen_oils(options, list(settings.oils), f"{results_folder}: no oil"):
        if oil_name not in fitted_oils:
            known_names = ", ".join(name for name in settings.oils if name in fitted_oils) or "none"
            reasons.append(
                f"{results_folder}: no fit of oil {oil_name!r}; there are fits of {known_names}. "
                "A plan of tests needs a fit."
            )
            continue
        try:
            for next_tests in plan_tests(results, settings, oil_name, request):
                lines = _lines_of_tests(next_tests, request.test_count, settings)
                texts.append("\n".join(lines))
        except OilfilmError as reason:
            reasons.append(str(reason))
    if texts:
        texts.append(ASSUMPTION)
    return texts, reasons


def _print_first_plan(options: argparse.Namespace, settings: Settings) -> int:
    """Print the runs to make first in a campaign without results."""
    campaign_name = settings.campaign.name
    if options.target not in (None, _CAMPAIGN_TARGET):
        raise OilfilmError(
            f"--for {options.target}: needs a fit, and the campaign {campaign_name} has no results "
            "yet. Leave out --for: then the first runs are planned."
        )
    _refuse_options_of_tests(options, f"the campaign {campaign_name} has no results yet")
    message_start = f"config/campaigns/{campaign_name}.yaml: no oil"
    oil_names = _chosen_oils(options, list(settings.oils), message_start)
    texts = []
    for oil_name in oil_names:
        plan = plan_runs(MeasuredRuns.empty(), settings, oil_name)
        texts.append("\n".join(_lines_of_runs(plan)))
    print("\n\n".join(texts))
    print(f"from campaign {campaign_name}, which has no results yet")
    return 0


def _refuse_options_of_tests(options: argparse.Namespace, why_no_tests: str) -> None:
    """Refuse options of tests where none is planned.

    Args:
        options: The typed options.
        why_no_tests: The reason, for the message.

    Raises:
        OilfilmError: There is such an option.
    """
    for option in ("bearing", "duty", "count"):
        if getattr(options, option) is not None:
            raise OilfilmError(
                f"--{option}: is for tests that are planned with a fit, and {why_no_tests}. Leave "
                f"out --{option}: then the runs to make next are planned."
            )


def _chosen_oils(
    options: argparse.Namespace, oil_names: list[str], message_start: str
) -> list[str]:
    """The typed oil, else all oils.

    Raises:
        OilfilmError: The typed oil is not among them; the sentence begins with `message_start`.
    """
    if options.oil is None:
        return oil_names
    if options.oil not in oil_names:
        raise OilfilmError(
            f"{message_start} {options.oil!r}; there are {', '.join(oil_names) or 'none'}. Name "
            "one of these with --oil."
        )
    return [options.oil]


def _requested_plan(
    options: argparse.Namespace, settings: Settings, settings_folder: Path
) -> PlanRequest:
    """What the plan shall contain, by the options, else by the settings."""
    bearing_name = options.bearing
    geometry = None
    if bearing_name:
        bearing_file = named_content(settings_folder, "bearing", bearing_name, "--bearing")
        geometry = bearing_file.bearing(bearing_name)
    request = request_from_settings(settings, geometry)
    if options.duty:
        request = replace(request, duty=np.array([_duty_point(text) for text in options.duty]))
    if options.count is not None:
        if not 1 <= options.count <= 50:
            raise OilfilmError(f"--count: found {options.count}; expected 1 to 50, as --count 5.")
        request = replace(request, test_count=options.count)
    target = (options.target or request.targets[0]).replace("-", "_")
    if request.bearing is None and (target in BEARING_TARGETS or options.duty):
        option = "--duty" if options.duty else f"--for {options.target}"
        raise OilfilmError(
            f"{option}: needs a bearing, and the campaign has none. Name one of config/bearings "
            "with --bearing, or plan --for traction."
        )
    return replace(request, targets=(target,))


def _duty_point(text: str) -> list[float]:
    """Axial load in N, speed in rpm and oil temperature in degC of an operating point."""
    number_texts = text.split(",")
    texts_with_units = zip(number_texts, _DUTY_UNITS, strict=False)
    values = [typed_quantity(number_text, unit, "--duty") for number_text, unit in texts_with_units]
    if len(number_texts) != len(_DUTY_UNITS) or min(values) <= 0:
        raise OilfilmError(
            f"--duty: found {text!r}; expected axial load, speed and oil temperature, three "
            f"numbers above 0, as {DUTY_EXAMPLE}."
        )
    return values


def _table_text(table: pd.DataFrame) -> str:
    """A table of a plan as text."""
    return table.to_string(index=False, float_format="{:.4g}".format)


def _lines_of_runs(plan: RunPlan) -> Iterator[str]:
    """The runs that a campaign lacks, as a table, with their reasons in sentences."""
    if plan.runs:
        runs = "1 run" if len(plan.runs) == 1 else f"{len(plan.runs)} runs"
        order = "" if len(plan.runs) == 1 else ", in this order"
        yield f"{plan.oil_name}: {runs} to make next on {plan.rig_name}{order}."
        table = plan.table()
        reasons = []
        for reason, new_levels in zip(table["run_reason"], table["new_levels"], strict=True):
            symbols = ", ".join(QUANTITIES[condition].symbol for condition in new_levels)
            reasons.append(f"{reason} of {symbols}" if symbols else reason)
        yield _table_text(table[["run_order", *_RUN_COLUMNS]].assign(reason=reasons))
        for reason, sentence in _SENTENCE_BY_REASON.items():
            if reason in set(table["run_reason"]):
                yield f"{reason}: {sentence}."
    else:
        yield f"{plan.oil_name}: the campaign lacks no run that {plan.rig_name} can make."
    not_planned = limits_with_counts(plan.left_out_count_by_limit)
    if not_planned:
        yield f"Lacking runs that are not planned, because they are beyond {not_planned}."
    if not plan.film_is_judged:
        yield "The film of these runs is not judged: the properties of the oil are not known."
    if plan.ordered_by:
        condition_in_words = _CONDITION_IN_WORDS[plan.ordered_by]
        yield (
            f"The names of the accepted runs are in the order of {condition_in_words}. If the "
            "runs were made in this order, a drift of the rig looks like an effect of the "
            f"{condition_in_words}. In simulated "
            "campaigns of 24 such runs five reference runs raised the share of faults that are "
            "named from 46 to 82 % where the law is true, and from 12 to 62 % where it is wrong."
        )


def _lines_of_budget(
    oil_name: str, target: str, budget: UncertaintyBudget, irreducible: float
) -> Iterator[str]:
    """The whole uncertainty of a target in a bearing, and what to measure in place of traction.

    Args:
        oil_name: Name of the oil.
        target: The target.
        budget: What makes the target uncertain.
        irreducible: Part of the uncertainty that no test of traction reduces.
    """
    target_in_words, _, _ = _PRINTED_TARGETS[target]
    yield (
        f"{oil_name}: standard uncertainty of the {target_in_words} from everything that is known "
        f"to be uncertain: {_uncertainty_text(target, budget.uncertainty)}. Traction has a share "
        f"of {budget.law_share:.0%} in its variance. With exact traction it would be "
        f"{_uncertainty_text(target, irreducible)}."
    )
    if budget.tests_may_help:
        return
    cause = CAUSE_BY_NAME[budget.largest_cause]
    yield (
        f"The largest share is {budget.largest_share:.0%}: {cause.meaning}. "
        f"Measure {cause.quantity_to_measure} instead."
    )
    if target == "torque":
        yield (
            "No test of traction is planned for the torque. For the cage slip and the best oil "
            "plan with --for cage-slip."
        )


def _lines_of_tests(plan: NextTests, count: int, settings: Settings) -> Iterator[str]:
    """The tests that make a target more certain, in sentences and a table.

    Args:
        plan: The tests.
        count: Number of tests that were asked for.
        settings: The settings.
    """
    target = plan.wanted.target
    if plan.budget is not None and plan.budget.largest_cause:
        yield from _lines_of_budget(
            plan.oil_name, target, plan.budget, plan.irreducible_uncertainty
        )
        if target == "torque" and not plan.budget.tests_may_help:
            return
    target_in_words, _, _ = _PRINTED_TARGETS[target]
    information = plan.information
    in_bearing = f" in {plan.bearing_name}" if plan.bearing_name else ""
    yield (
        f"{plan.oil_name}{in_bearing}: standard uncertainty of the {target_in_words} from the "
        f"law, root mean square over {len(plan.wanted.labels)} operating points: "
        f"{_uncertainty_text(target, plan.curve_plan.uncertainty_before)}; largest "
        f"{_largest_with_point(plan, information.precision)}."
    )
    if information.calibration_uncertainties.any():
        precision, gradients = information.without_calibration(
            information.precision, plan.gradients
        )
        with_exact_sensors = _uncertainty_text(target, float(rms_uncertainty(precision, gradients)))
        what_is_left = "the rest is their calibration, which all tests on this rig share"
        yield f"With exact sensors it would be {with_exact_sensors}: {what_is_left}."
    else:
        yield "The calibration of the rig's sensors is not stated, so it is not included."
    for reason in plan.wanted.left_out_reasons:
        yield f"left out: {reason}"
    limits_in_words = limits_with_counts(plan.candidates.left_out_count_by_limit)
    note_on_beyond = f"; the others are beyond {limits_in_words}" if limits_in_words else ""
    yield f"{len(plan.candidates.tests)} conditions of plan.levels can be run{note_on_beyond}."
    # tests that can be run and are not chosen have the order 0
    tests = plan.table().query("test_order > 0").sort_values("test_order")
    if len(tests):
        new_columns = {
            "law_uncertainty_then": [
                _uncertainty_text(target, law_uncertainty)
                for law_uncertainty in plan.curve_plan.uncertainty_after
            ]
        }
        if plan.irreducible_uncertainty:
            new_columns["uncertainty_then"] = [
                _uncertainty_text(target, whole_uncertainty)
                for whole_uncertainty in tests["uncertainty_with_plan"]
            ]
        yield _table_text(tests[["test_order", *_RUN_COLUMNS]].assign(**new_columns))
        largest_part = _largest_with_point(plan, plan.curve_plan.final_precision)
        yield f"Largest part by the law after the plan: {largest_part}."
    if len(tests) < count:
        more = "more " if len(tests) else ""
        yield (
            f"No {more}test is worth measuring: each reduces the law's part of the uncertainty of "
            f"the {target_in_words} by less than {settings.plan.smallest_gain:.2g} of it "
            "(plan.smallest_gain)."
        )


def _uncertainty_text(target: str, standard_uncertainty: float) -> str:
    """A standard uncertainty of a target as text, with its unit."""
    if np.isnan(standard_uncertainty):
        return "unknown"
    _, factor, unit = _PRINTED_TARGETS[target]
    return f"{factor * standard_uncertainty:.3g}{unit}"


def _largest_with_point(plan: NextTests, precision: FloatArray) -> str:
    """The largest uncertainty of the wanted quantities, and its operating point.

    Args:
        plan: The plan.
        precision: Precision of the parameters, shape (n, n).
    """
    uncertainty_of_points = uncertainties(precision, plan.gradients)
    # an unknown uncertainty (NaN) counts as the largest
    worst_index = int(np.argmax(uncertainty_of_points))
    return (
        f"{_uncertainty_text(plan.wanted.target, uncertainty_of_points[worst_index])} at "
        f"{plan.wanted.labels[worst_index]}"
    )
