"""The command `oilfilm plan`: the rig conditions to test next."""

import argparse
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from oilfilm import tables
from oilfilm.cli.arguments import campaign_folder, config_folder, quantity
from oilfilm.cli.parser import DUTY_EXAMPLE
from oilfilm.errors import OilfilmError
from oilfilm.settings.base import Group, Result, key
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
    "The plan assumes that the law's form is right: errors of that form beyond the measured "
    "conditions are not covered. Only the uncertainty from the law's constants is planned for; the "
    "other terms of the torque have their own (bearing.term_uncertainty)."
)


class PlannedPoint(Group):
    """One operating point and how uncertain it is."""

    at: str = key("Axial load, speed and oil temperature, or rig conditions.")
    value: Result = key("Torque in N m, cage slip, or mu.")
    uncertainty_now: Result = key("Standard uncertainty by the measured curves.")
    uncertainty_with_plan: Result = key("The same after the planned tests.")


class PlannedTests(Group):
    """The tests to run next for one oil."""

    campaign: str = key("Campaign whose fit the plan is for.")
    data: str = key("measured or simulated.")
    oil: str = key("Name of the oil.")
    target: str = key("What shall become more certain: torque, cage_slip, traction.")
    bearing: str = key("The bearing; empty for traction.")
    uncertainty_now: Result = key(
        "Standard uncertainty from the law's constants, root mean square over the operating "
        "points; relative for torque and traction, of the slip itself for cage_slip."
    )
    uncertainty_now_without_calibration: Result = key(
        "The same with exact sensors of the traction rig."
    )
    tests: list[dict[str, Any]] = key(
        "The chosen tests in their order; keys are columns of the table test_plan."
    )
    operating_points: list[PlannedPoint] = key("What the uncertainty is of.")
    left_out: list[str] = key("Operating points left out, with the reason.")
    conditions: int = key("Number of conditions of plan.levels that the rig can run.")
    conditions_left_out: dict[str, int] = key(
        "Number of conditions that the rig cannot run, by reason."
    )
    calibration_known: bool = key("Whether the calibration of the rig is stated.")
    assumption: str = key("What the plan assumes.")

    def text(self) -> str:
        """The plan in sentences and a table."""
        name, factor, unit = _SHOWN[self.target]

        def shown(uncertainty: float | None) -> str:
            return "unknown" if uncertainty is None else f"{factor * uncertainty:.3g}{unit}"

        points = self.operating_points
        worst = max(points, key=lambda point: point.uncertainty_now or 0)
        worst_then = max(points, key=lambda point: point.uncertainty_with_plan or 0)
        where = f" in {self.bearing}" if self.bearing else ""
        lines = [
            f"{self.oil}{where}: standard uncertainty of the {name} from the law's constants, root "
            f"mean square over {len(points)} operating points: {shown(self.uncertainty_now)}; "
            f"largest {shown(worst.uncertainty_now)} at {worst.at}.",
            f"With exact sensors it would be {shown(self.uncertainty_now_without_calibration)}: "
            "the rest is their calibration, which all tests on this rig share."
            if self.calibration_known
            else "The calibration of the rig's sensors is not stated, so it is not included.",
            *(f"left out: {reason}" for reason in self.left_out),
        ]
        reasons = [f"{reason} ({count})" for reason, count in self.conditions_left_out.items()]
        beyond = f"; the others are beyond {', '.join(reasons)}." if reasons else "."
        lines.append(f"{self.conditions} conditions of plan.levels can be run{beyond}")
        heads = [head for head, *_ in _TEST_COLUMNS]
        rows = [
            [
                str(test["test_order"]),
                *(f"{test[column]:{digits}}" for _, column, digits in _TEST_COLUMNS),
                shown(test["uncertainty_with_plan"]),
            ]
            for test in self.tests
        ]
        lines += text_table([["no.", *heads, "uncertainty then"], *rows], right=len(heads) + 1)
        lines.append(
            f"Largest after the plan: {shown(worst_then.uncertainty_with_plan)} at {worst_then.at}."
        )
        return "\n".join(lines)


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
    plans = [
        planned_tests(plan, about)
        for oil in oils
        for plan in plan_oil(results, settings, oil, request)
    ]
    if options.json:
        print("\n".join(plan.model_dump_json() for plan in plans))
    else:
        print("\n\n".join(plan.text() for plan in plans))
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
    parts = text.split(",")
    if len(parts) != len(_DUTY_UNITS):
        raise OilfilmError(
            f"--duty: found {text!r}; expected axial load, speed and oil temperature, as "
            f"{DUTY_EXAMPLE}."
        )
    values = [quantity(part, unit, "--duty") for part, unit in zip(parts, _DUTY_UNITS, strict=True)]
    if min(values) <= 0:
        raise OilfilmError(
            f"--duty: found {text!r}; expected three numbers above 0, as {DUTY_EXAMPLE}."
        )
    return values


def planned_tests(plan: NextTests, about: Mapping[str, str]) -> PlannedTests:
    """A plan as plain values: what is known, the tests in their order, what they bring."""
    wanted, known = plan.wanted, plan.known.information
    table = plan.table()
    chosen = table[table["test_order"] > 0].sort_values("test_order")
    points = zip(
        wanted.labels,
        wanted.values,
        known.uncertainties(wanted.gradients),
        plan.design.end.uncertainties(wanted.gradients),
        strict=True,
    )
    return PlannedTests(
        campaign=about["campaign"],
        data=about["data"],
        oil=plan.oil,
        target=wanted.target,
        bearing=plan.where,
        uncertainty_now=plan.design.before,
        uncertainty_now_without_calibration=float(
            known.without_calibration().uncertainty(wanted.gradients)
        ),
        tests=tables.rows(chosen[[name for name in tables.columns("test_plan") if name in chosen]]),
        operating_points=[
            PlannedPoint(at=label, value=value, uncertainty_now=now, uncertainty_with_plan=then)
            for label, value, now, then in points
        ],
        left_out=list(wanted.left_out),
        conditions=len(plan.candidates.tests),
        conditions_left_out={
            reason: int(count) for reason, count in plan.candidates.left_out.items() if count
        },
        calibration_known=bool(plan.known.calibration.any()),
        assumption=ASSUMPTION,
    )
