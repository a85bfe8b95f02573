"""The command `oilfilm plan`: the rig conditions to test next."""

import argparse
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from oilfilm.base.errors import OilfilmError
from oilfilm.base.units import FloatArray
from oilfilm.cli.arguments import campaign_folder, config_folder, quantity
from oilfilm.cli.parser import DUTY_EXAMPLE
from oilfilm.fits.measured_curves import uncertainties, uncertainty
from oilfilm.settings.resolve import named_file, resolve
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.torque.next_tests import NextTests, Request, plan_oil, request_of
from oilfilm.torque.wanted_quantities import BEARING_TARGETS
from oilfilm.traction.law import CONDITIONS

_DUTY_UNITS = ("N", "rpm", "degC")
# How the uncertainty of each target is printed: name, factor, unit.
_PRINTED = {
    "torque": ("friction torque", 100.0, " %"),
    "cage_slip": ("cage slip", 1.0, ""),
    "traction": ("mu", 100.0, " %"),
}
_TEST_COLUMNS = ["test_order", *CONDITIONS, "load_n", "slide_roll_ratio", "lambda_ratio"]
ASSUMPTION = (
    "The plan allows for an error of the law's form (plan.form_error). Only the uncertainty from "
    "the law is planned for; the other terms of the torque have their own "
    "(bearing.term_uncertainty)."
)


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    folder, footer = campaign_folder(options.results)
    config = config_folder(options.config)
    settings = resolve(config, {"campaign": footer["campaign"]})
    results = CampaignTables.in_folder(folder)
    fitted = [oil for oil in settings.oils if oil in set(results.configured.coefficients["oil"])]
    oils = fitted if options.oil is None else [options.oil]
    if not set(oils) <= set(fitted):
        raise OilfilmError(
            f"{folder}: no fit of oil {options.oil!r}; there are fits of "
            f"{', '.join(fitted) or 'none'}. Name one of these with --oil."
        )
    request = _request(options, settings, config)
    texts = []
    for oil in oils:
        for plan in plan_oil(results, settings, oil, request):
            texts.append("\n".join(_lines(plan, request.count, settings)))
    print("\n\n".join(texts))
    print(f"\n{ASSUMPTION}\nfrom campaign {footer['campaign']}, {footer['data']} data")
    return 0


def _request(options: argparse.Namespace, settings: Settings, config: Path) -> Request:
    """What the plan shall contain, by the options, else by the settings."""
    name = options.bearing
    bearing = named_file(config, "bearing", name, "--bearing").bearing(name) if name else None
    request = request_of(settings, bearing)
    if options.duty:
        request = replace(request, duty=np.array([_duty(text) for text in options.duty]))
    if options.count is not None:
        if not 1 <= options.count <= 50:
            raise OilfilmError(f"--count: found {options.count}; expected 1 to 50, as --count 5.")
        request = replace(request, count=options.count)
    target = (options.target or request.targets[0]).replace("-", "_")
    if request.bearing is None and (target in BEARING_TARGETS or options.duty):
        option = "--duty" if options.duty else f"--for {options.target}"
        raise OilfilmError(
            f"{option}: needs a bearing, and the campaign has none. Name one of config/bearings "
            "with --bearing, or plan --for traction."
        )
    return replace(request, targets=(target,))


def _duty(text: str) -> list[float]:
    """Axial load in N, speed in rpm and oil temperature in degC of an operating point."""
    numbers = text.split(",")
    pairs = zip(numbers, _DUTY_UNITS, strict=False)
    values = [quantity(number, unit, "--duty") for number, unit in pairs]
    if len(numbers) != len(_DUTY_UNITS) or min(values) <= 0:
        raise OilfilmError(
            f"--duty: found {text!r}; expected axial load, speed and oil temperature, three "
            f"numbers above 0, as {DUTY_EXAMPLE}."
        )
    return values


def _lines(plan: NextTests, count: int, settings: Settings) -> Iterator[str]:
    """The plan in sentences and a table."""
    name, factor, unit = _PRINTED[plan.wanted.target]
    measured = plan.information

    def printed(standard_uncertainty: float) -> str:
        if np.isnan(standard_uncertainty):
            return "unknown"
        return f"{factor * standard_uncertainty:.3g}{unit}"

    def largest(precision: FloatArray) -> str:
        at_points = np.nan_to_num(uncertainties(precision, plan.gradients))
        worst = int(at_points.argmax())
        return f"{printed(at_points[worst])} at {plan.wanted.labels[worst]}"

    bearing = f" in {plan.bearing}" if plan.bearing else ""
    yield (
        f"{plan.oil}{bearing}: standard uncertainty of the {name} from the law, root mean square "
        f"over {len(plan.wanted.labels)} operating points: {printed(plan.design.before)}; largest "
        f"{largest(measured.precision)}."
    )
    if measured.calibration.any():
        precision, gradients = measured.without_calibration(measured.precision, plan.gradients)
        exact = printed(float(uncertainty(precision, gradients)))
        rest = "the rest is their calibration, which all tests on this rig share"
        yield f"With exact sensors it would be {exact}: {rest}."
    else:
        yield "The calibration of the rig's sensors is not stated, so it is not included."
    for reason in plan.wanted.left_out:
        yield f"left out: {reason}"
    excluded = plan.candidates.left_out.items()
    reasons = ", ".join(f"{reason} ({number})" for reason, number in excluded if number)
    beyond = f"; the others are beyond {reasons}" if reasons else ""
    yield f"{len(plan.candidates.tests)} conditions of plan.levels can be run{beyond}."
    tests = plan.table().query("test_order > 0").sort_values("test_order")
    if len(tests):
        after = tests["uncertainty_with_plan"].map(printed)
        table = tests[_TEST_COLUMNS].assign(uncertainty_then=after)
        yield table.to_string(index=False, float_format="{:.4g}".format)
        yield f"Largest after the plan: {largest(plan.design.end)}."
    if len(tests) < count:
        more = "more " if len(tests) else ""
        yield (
            f"No {more}test is worth measuring: each makes the {name} more certain by less "
            f"than {settings.plan.smallest_gain:.2g} of its uncertainty (plan.smallest_gain)."
        )
