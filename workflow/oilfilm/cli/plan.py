"""The command `oilfilm plan`: the rig conditions to test next."""

import argparse
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from oilfilm import tables
from oilfilm.cli.arguments import campaign_folder, config_folder, json_text, quantity
from oilfilm.cli.parser import DUTY_EXAMPLE
from oilfilm.errors import OilfilmError
from oilfilm.fits.measured_curves import uncertainties, uncertainty
from oilfilm.settings.resolve import named_file, resolve
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.text_table import text_table
from oilfilm.torque.next_tests import BEARING_TARGETS, NextTests, Request, plan_oil, request_of

_DUTY_UNITS = ("N", "rpm", "degC")
# How each target's uncertainty is printed: name, factor, unit.
_SHOWN = {
    "torque": ("friction torque", 100.0, " %"),
    "cage_slip": ("cage slip", 1.0, ""),
    "traction": ("mu", 100.0, " %"),
}
# Columns of the table of tests as text, after their order: head, column, digits.
_TEST_COLUMNS = (
    ("P GPa", "max_hertz_pressure_gpa", "g"),
    ("U m/s", "entrainment_speed_m_s", "g"),
    ("T degC", "inlet_temperature_c", "g"),
    ("W N", "load_n", ".1f"),
    ("S up to", "slide_roll_ratio", ".2f"),
    ("lambda", "lambda_ratio", ".1f"),
)
ASSUMPTION = (
    "The plan allows for an error of the law's form (plan.form_error). Only the uncertainty from "
    "the law is planned for; the other terms of the torque have their own "
    "(bearing.term_uncertainty)."
)


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    folder, about = campaign_folder(options.results, options.campaign)
    config = config_folder(options.config)
    settings = resolve(config, {"campaign": about["campaign"]})
    results = CampaignTables.in_folder(folder)
    fitted = [oil for oil in settings.oils if oil in set(results.configured.coefficients["oil"])]
    oils = fitted if options.oil is None else [options.oil]
    if not set(oils) <= set(fitted):
        raise OilfilmError(
            f"{folder}: no fit of oil {options.oil!r}; there are fits of "
            f"{', '.join(fitted) or 'none'}. Name one of these with --oil."
        )
    request = _request(options, settings, config)
    plans = [plan for oil in oils for plan in plan_oil(results, settings, oil, request)]
    if options.json:
        print("\n".join(json_text({**about, **_plain(plan)}) for plan in plans))
    else:
        print("\n\n".join("\n".join(_lines(plan, _plain(plan))) for plan in plans))
        print(f"\n{ASSUMPTION}\nfrom campaign {about['campaign']}, {about['data']} data")
    return 0


def _request(options: argparse.Namespace, settings: Settings, config: Path) -> Request:
    """What is asked for: the options over the settings."""
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
    of_units = zip(text.split(","), _DUTY_UNITS, strict=False)
    values = [quantity(part, unit, "--duty") for part, unit in of_units]
    if text.count(",") != len(_DUTY_UNITS) - 1 or min(values) <= 0:
        raise OilfilmError(
            f"--duty: found {text!r}; expected axial load, speed and oil temperature, three "
            f"numbers above 0, as {DUTY_EXAMPLE}."
        )
    return values


def _plain(plan: NextTests) -> dict[str, Any]:
    """A plan as plain values: what is known, the tests in their order, what they bring."""
    known, wanted, gradients = plan.known, plan.wanted, plan.gradients
    without_calibration = uncertainty(*known.without_calibration(known.precision, gradients))
    tests = plan.table()
    tests = tests[[name for name in tables.columns("test_plan") if name in tests]]
    points = {
        "at": wanted.labels,
        "value": wanted.values,
        "uncertainty_now": uncertainties(known.precision, gradients),
        "uncertainty_with_plan": uncertainties(plan.design.end, gradients),
    }
    return {
        "oil": plan.oil,
        "target": wanted.target,
        "bearing": plan.where,
        "uncertainty_now": plan.design.before,
        "uncertainty_now_without_calibration": float(without_calibration),
        "tests": tables.rows(tests[tests["test_order"] > 0].sort_values("test_order")),
        "operating_points": tables.rows(pd.DataFrame(points)),
        "left_out": list(wanted.left_out),
        "conditions": len(plan.candidates.tests),
        "conditions_left_out": {name: int(n) for name, n in plan.candidates.left_out.items() if n},
        "calibration_known": bool(known.calibration.any()),
        "assumption": ASSUMPTION,
    }


def _lines(plan: NextTests, plain: Mapping[str, Any]) -> Iterator[str]:
    """The plan in sentences and a table."""
    name, factor, unit = _SHOWN[plain["target"]]
    points, tests = plain["operating_points"], plain["tests"]

    def shown(uncertainty: float) -> str:
        return "unknown" if np.isnan(uncertainty) else f"{factor * uncertainty:.3g}{unit}"

    def largest(column: str) -> str:
        worst = max(points, key=lambda point: float(np.nan_to_num(point[column])))
        return f"{shown(worst[column])} at {worst['at']}"

    where = f" in {plan.where}" if plan.where else ""
    yield (
        f"{plan.oil}{where}: standard uncertainty of the {name} from the law, root mean square "
        f"over {len(points)} operating points: {shown(plan.design.before)}; largest "
        f"{largest('uncertainty_now')}."
    )
    if plain["calibration_known"]:
        exact = shown(plain["uncertainty_now_without_calibration"])
        rest = "the rest is their calibration, which all tests on this rig share"
        yield f"With exact sensors it would be {exact}: {rest}."
    else:
        yield "The calibration of the rig's sensors is not stated, so it is not included."
    yield from (f"left out: {reason}" for reason in plain["left_out"])
    reasons = ", ".join(f"{reason} ({n})" for reason, n in plain["conditions_left_out"].items())
    beyond = f"; the others are beyond {reasons}" if reasons else ""
    yield f"{plain['conditions']} conditions of plan.levels can be run{beyond}."
    heads = ["no.", *(head for head, *_ in _TEST_COLUMNS), "uncertainty then"]
    rows = [
        [
            str(test["test_order"]),
            *(f"{test[column]:{digits}}" for _, column, digits in _TEST_COLUMNS),
            shown(test["uncertainty_with_plan"]),
        ]
        for test in tests
    ]
    if rows:
        yield from text_table([heads, *rows], right=len(heads) - 1)
        yield f"Largest after the plan: {largest('uncertainty_with_plan')}."
    if len(rows) < plan.count:
        more = "more " if rows else ""
        yield (
            f"No {more}test is worth measuring: each makes the {name} more certain "
            f"by less than {plan.smallest_gain:.2g} of its uncertainty (plan.smallest_gain)."
        )
