"""The command `oilfilm plan`: the rig conditions to test next."""

import argparse
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from oilfilm import tables
from oilfilm.bearing.geometry import Bearing
from oilfilm.cli.arguments import campaign_folder, config_folder, quantity
from oilfilm.cli.parser import DUTY_EXAMPLE
from oilfilm.errors import OilfilmError
from oilfilm.settings.bearing import BearingFile
from oilfilm.settings.messages import load
from oilfilm.settings.resolve import resolve
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.torque.next_tests import BEARING_TARGETS, NextTests, Request, plan_oil, request_of

_DUTY_UNITS = ("N", "rpm", "degC")
# How each target's uncertainty is printed: name, factor, unit.
_SHOWN = {
    "torque": ("friction torque", 100.0, " %"),
    "cage_slip": ("cage slip", 1.0, ""),
    "traction": ("mu", 100.0, " %"),
}
ASSUMPTION = (
    "The plan assumes that the law's form is right: errors of that form beyond the measured "
    "conditions are not covered. Only the uncertainty from the law's constants is planned for; the "
    "other terms of the torque have their own (bearing.term_uncertainty)."
)


class PlannedPoint(BaseModel):
    """One operating point and how uncertain it is."""

    model_config = ConfigDict(extra="forbid")

    at: str = Field(description="axial load, speed and oil temperature, or rig conditions")
    value: float = Field(description="torque in N m, cage slip, or mu")
    uncertainty_now: float = Field(description="standard uncertainty by the measured curves")
    uncertainty_with_plan: float = Field(description="the same after the planned tests")


class PlannedTests(BaseModel):
    """The tests to run next for one oil."""

    model_config = ConfigDict(extra="forbid")

    campaign: str = Field(description="campaign whose fit the plan is for")
    data: str = Field(description="measured or simulated")
    oil: str = Field(description="name of the oil")
    target: str = Field(description="what shall become more certain: torque, cage_slip, traction")
    bearing: str = Field(description="the bearing; empty for traction")
    uncertainty_now: float = Field(
        description="standard uncertainty from the law's constants, root mean square over the "
        "operating points; relative for torque and traction, of the slip itself for cage_slip"
    )
    uncertainty_now_without_calibration: float = Field(
        description="the same with exact sensors of the traction rig"
    )
    tests: list[dict[str, Any]] = Field(
        description="the chosen tests in their order; keys are columns of the table test_plan"
    )
    operating_points: list[PlannedPoint] = Field(description="what the uncertainty is of")
    left_out: list[str] = Field(description="operating points left out, with the reason")
    conditions_left_out: dict[str, int] = Field(
        description="number of conditions that the rig cannot run, by reason"
    )
    calibration_known: bool = Field(description="whether the calibration of the rig is stated")
    assumption: str = Field(description="what the plan assumes")


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    folder, about = campaign_folder(options.results, options.campaign)
    config = config_folder(options.config)
    settings = resolve(config, {"campaign": about["campaign"]})
    results = CampaignTables.in_folder(folder)
    fitted = [oil for oil in settings.oils if oil in set(results.coefficients["oil"])]
    oils = fitted if options.oil is None else [options.oil]
    if not set(oils) <= set(fitted):
        raise OilfilmError(
            f"{folder}: no fit of oil {options.oil!r}; there are fits of "
            f"{', '.join(fitted) or 'none'}. Name one of these with --oil."
        )
    request = _request(options, settings, config)
    plans = [plan for oil in oils for plan in plan_oil(results, settings, oil, request)]
    if options.json:
        print("\n".join(as_json(plan, about).model_dump_json() for plan in plans))
    else:
        print("\n\n".join(as_text(plan) for plan in plans))
        print(f"\n{ASSUMPTION}\nfrom campaign {about['campaign']}, {about['data']} data")
    return 0


def _request(options: argparse.Namespace, settings: Settings, config: Path) -> Request:
    """What is asked for: the options over the settings."""
    request = request_of(settings, _bearing(options.bearing, config))
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


def _bearing(name: str | None, config: Path) -> Bearing | None:
    """The bearing that is named, from its file."""
    if name is None:
        return None
    files = {path.stem: path for path in sorted((config / "bearings").glob("*.yaml"))}
    if name not in files:
        raise OilfilmError(
            f"--bearing: there is no {config / 'bearings' / name}.yaml. Known: {', '.join(files)}. "
            "Name one of them, or describe the bearing in that file."
        )
    return load(files[name], BearingFile).bearing(name)


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


def as_json(plan: NextTests, about: Mapping[str, str]) -> PlannedTests:
    """A plan as plain values: what is known, the tests in their order, what they bring."""
    start = plan.known.information
    return PlannedTests(
        campaign=about["campaign"],
        data=about["data"],
        oil=plan.oil,
        target=plan.wanted.target,
        bearing=plan.where,
        uncertainty_now=plan.design.before,
        uncertainty_now_without_calibration=float(
            start.without_calibration().uncertainty(plan.wanted.gradients)
        ),
        tests=[
            {name: row[name] for name in tables.columns("test_plan") if name in row}
            for row in _chosen(plan)
        ],
        operating_points=[
            PlannedPoint(at=label, value=value, uncertainty_now=now, uncertainty_with_plan=then)
            for label, value, now, then in zip(*_points(plan), strict=True)
        ],
        left_out=list(plan.wanted.left_out),
        conditions_left_out=dict(plan.candidates.left_out),
        calibration_known=bool(plan.known.calibration.any()),
        assumption=ASSUMPTION,
    )


def _chosen(plan: NextTests) -> list[dict[str, Any]]:
    table = plan.table()
    return tables.rows(table[table["test_order"] > 0].sort_values("test_order"))


def _points(plan: NextTests) -> tuple[Sequence[str], list[float], list[float], list[float]]:
    """Operating points with their value and its uncertainty before and after the plan."""
    wanted = plan.wanted
    now = plan.known.information.uncertainties(wanted.gradients)
    then = plan.design.end.uncertainties(wanted.gradients)
    return wanted.labels, wanted.values.tolist(), now.tolist(), then.tolist()


def as_text(plan: NextTests) -> str:
    """A plan in sentences and a table."""
    name, factor, unit = _SHOWN[plan.wanted.target]

    def shown(uncertainty: float) -> str:
        return f"{factor * uncertainty:.3g}{unit}"

    labels, _, now, then = _points(plan)
    worst = int(np.argmax(now))
    where = f" in {plan.where}" if plan.where else ""
    exact = plan.known.information.without_calibration().uncertainty(plan.wanted.gradients)
    lines = [
        f"{plan.oil}{where}: standard uncertainty of the {name} from the law's constants, root "
        f"mean square over {len(labels)} operating points: {shown(plan.design.before)}; largest "
        f"{shown(now[worst])} at {labels[worst]}.",
    ]
    if plan.known.calibration.any():
        lines.append(
            f"With exact sensors it would be {shown(float(exact))}: the rest is their "
            "calibration, which all tests on this rig share."
        )
    else:
        lines.append("The calibration of the rig's sensors is not stated, so it is not included.")
    lines += [f"left out: {reason}" for reason in plan.wanted.left_out]
    reasons = [f"{reason} ({count})" for reason, count in plan.candidates.left_out.items() if count]
    lines.append(
        f"{len(plan.candidates.tests)} conditions of plan.levels can be run"
        + (f"; the others are beyond {', '.join(reasons)}." if reasons else ".")
    )
    lines.append("no.  P GPa  U m/s  T degC    W N  S up to  lambda  uncertainty then")
    for row in _chosen(plan):
        lines.append(
            f"{row['test_order']:>3}  {row['max_hertz_pressure_gpa']:>5g}  "
            f"{row['entrainment_speed_m_s']:>5g}  {row['inlet_temperature_c']:>6g}  "
            f"{row['load_n']:>5.1f}  {row['slide_roll_ratio']:>7.2f}  {row['lambda_ratio']:>6.1f}  "
            f"{shown(row['uncertainty_with_plan'])}"
        )
    lines.append(f"Largest after the plan: {shown(max(then))} at {labels[int(np.argmax(then))]}.")
    return "\n".join(lines)
