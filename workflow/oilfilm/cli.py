"""The command `oilfilm`: check logs, predict traction, verify and compare releases.

Everything else is a target of snakemake.
"""

import argparse
import re
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from oilfilm import tables
from oilfilm.curation.curate import Curated, check_logs
from oilfilm.curation.refusals import advice_for
from oilfilm.curation.rig_kind import RigKind
from oilfilm.curation.torque_rig import TORQUE_RIG
from oilfilm.curation.traction_rig import TRACTION_RIG
from oilfilm.errors import OilfilmError
from oilfilm.fitting.fitted import FittedLaw, read_fit
from oilfilm.readers.base import LARGEST_READING
from oilfilm.readers.ingest import read_bytes
from oilfilm.releases.commands import add_commands
from oilfilm.releases.manifest import printable
from oilfilm.settings.resolve import resolve
from oilfilm.tables import failed_gates
from oilfilm.traction.law import QUANTITIES
from oilfilm.units import conversion


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; exit code 0 for success, 1 for a refused log, 2 for a mistake."""
    options = _parser().parse_args(arguments)
    try:
        return int(options.run(options))
    except OilfilmError as mistake:
        # the message may quote a file of unknown origin
        print("\n".join(map(printable, str(mistake).splitlines())), file=sys.stderr)
        return 2
    except OSError as error:
        print(f"{error.filename}: {error.strerror}.", file=sys.stderr)
        return 2


# Options of `predict`: condition of a law, example.
_OPTIONS = {
    "--stress": ("max_hertz_pressure_gpa", "1.2GPa"),
    "--load": ("load_n", "50N"),
    "--speed": ("entrainment_speed_m_s", "30m/s"),
    "--temperature": ("inlet_temperature_c", "70degC"),
}


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="oilfilm", description=__doc__)
    commands = parser.add_subparsers(required=True)
    check = commands.add_parser("check", help="read logs and apply every gate")
    check.add_argument("logs", nargs="+", type=Path, metavar="FILE")
    check.add_argument(
        "--campaign", help="campaign with the rig, oils and limits (config/campaigns)"
    )
    check.add_argument("--config", type=Path, default=Path("config"), help="configuration folder")
    check.add_argument("--torque", action="store_true", help="they are logs of a torque rig")
    check.set_defaults(run=_check)
    predict = commands.add_parser("predict", help="traction coefficient of a fitted oil")
    predict.add_argument("--oil", required=True)
    for option, (name, example) in _OPTIONS.items():
        meaning = f"{QUANTITIES[name].meaning}, as {example}"
        predict.add_argument(option, metavar=example, help=meaning)
    predict.add_argument("--slip", required=True, help="slide-roll ratio, as 0.05 or 5%%")
    predict.add_argument("--campaign", default="demo", help="campaign of the fit (default: demo)")
    predict.add_argument("--results", type=Path, default=Path("results"), help="results folder")
    predict.set_defaults(run=_predict)
    add_commands(commands)
    return parser


def _check(options: argparse.Namespace) -> int:
    overrides = {"campaign": options.campaign} if options.campaign else {}
    config = resolve(options.config, overrides)
    logs = [(str(path), read_bytes(path)) for path in dict.fromkeys(options.logs)]
    kind: RigKind = TORQUE_RIG if options.torque else TRACTION_RIG
    verdict = check_logs(logs, config, kind)
    print(report(verdict, kind))
    unread = set(verdict.quarantine["file"]) - set(verdict.runs["file"])
    return int(bool((verdict.runs["verdict"] == "refused").any() or unread))


def _predict(options: argparse.Namespace) -> int:
    at = {"slide_roll_ratio": quantity(options.slip, "dimensionless", "--slip")}
    for option, (name, _) in _OPTIONS.items():
        typed = getattr(options, option.removeprefix("--"))
        if typed is not None:
            at[name] = quantity(typed, QUANTITIES[name].unit, option)
    folder = options.results / options.campaign
    footer = tables.read_footer(folder / "tables" / "coefficients.parquet")
    print(prediction(read_fit(folder, options.oil), options.oil, at))
    print(f"from campaign {footer['campaign']}, {footer['data']} data")
    return 0


def quantity(text: str, unit: str, option: str) -> float:
    """Convert a typed number with its unit to `unit`; a bare number is in `unit` already.

    Raises:
        OilfilmError: It is no number, or its unit measures something else.
    """
    number = re.fullmatch(r"\s*([-+]?[0-9.]+(?:[eE][-+]?[0-9]+)?)\s*(\S*)\s*", text)
    expected = f"expected a number in {unit}, as 0.5{'' if unit == 'dimensionless' else unit}"
    if number is None:
        raise OilfilmError(f"{option}: found {text!r}; {expected}.")
    try:
        value = float(number[1])
        if abs(value) >= LARGEST_READING:
            raise ValueError(f"no quantity is {LARGEST_READING:g} or more")
        return float(conversion(number[2] or unit, (unit,)).of(np.array(value)))
    except ValueError as error:
        raise OilfilmError(f"{option}: found {text!r}: {error}; {expected}.") from None


def prediction(fit: FittedLaw, oil: str, at: Mapping[str, float]) -> str:
    """Prediction of a fit at one operating point, as text.

    Args:
        fit: The fitted law.
        oil: Name of its oil.
        at: Slide-roll ratio and conditions by their columns' names. A condition that the fit does
            not follow may be left out: mu is then given at its tested level.

    Raises:
        OilfilmError: The fit has no value there, or a condition is missing or too many.
    """
    fixed = {each.condition: each for each in fit.coefficients.fixed}
    _refuse_other_conditions(fit, oil, at)
    conditions = np.array([[at.get(name, np.nan) for name in fit.law.conditions]])
    try:
        predicted = fit.predict(conditions, np.array([at["slide_roll_ratio"]]))
    except ValueError as error:
        raise OilfilmError(f"{oil}: {error}.") from None
    where = [each.sentence() for each in fixed.values()]
    if predicted.away[0]:
        raise OilfilmError(
            f"{oil}: mu is not known there: {'; '.join(where)}. Ask for a point on it, or leave "
            "the option out to be given the tested value."
        )
    values = predicted.traction_coefficient, predicted.lower, predicted.upper
    mu, lower, upper = (float(value[0]) for value in values)
    if np.isnan(mu):
        raise OilfilmError(f"{oil}: nothing could be fitted; see results/*/summary.txt.")
    interval = "no interval" if np.isnan(lower) else f"95 % interval {lower:.5f} to {upper:.5f}"
    lines = [f"{oil}, {fit.law.name}: mu = {mu:.5f}, {interval}", *where]
    box = dict(zip((*fit.law.conditions, "slide_roll_ratio"), fit.coefficients.box, strict=True))
    for name, value in at.items():
        low, high = box[name]
        if name not in fixed and np.isfinite(low) and not low <= abs(value) <= high:
            unit = tables.COLUMNS[name].shown_unit
            lines.append(
                f"OUTSIDE the tested box: {name} {value:g}, tested {low:.4g} to {high:.4g} {unit}"
            )
    if predicted.outside[0]:
        lines.append(
            f"{predicted.distance[0]:.1f} tested ranges outside: the interval holds only if "
            "the law does"
        )
    return "\n".join(line.rstrip() for line in lines)


def _refuse_other_conditions(fit: FittedLaw, oil: str, at: Mapping[str, float]) -> None:
    """Raise a sentence where a law is asked for conditions that are not its own."""
    fixed = {each.condition for each in fit.coefficients.fixed}
    wanted = set(fit.law.conditions)
    for name in at:
        if name not in (*wanted, "slide_roll_ratio"):
            raise OilfilmError(f"{oil}: the law {fit.law.name} does not take {name}.")
    for option, (name, example) in _OPTIONS.items():
        if name in wanted and name not in at and name not in fixed:
            raise OilfilmError(
                f"{oil}: {option} is missing; the fit depends on {name}. Give it, as {option} "
                f"{example}."
            )


# A file of more clean runs than this has them in one line.
_RUNS_LISTED = 10


def report(verdict: Curated, kind: RigKind = TRACTION_RIG) -> str:
    """One line per run, and what to do about everything that was refused."""
    runs, points = verdict.runs, verdict.points
    clean = runs["accepted_points"] == runs["plateaus"]
    lines = []
    for file, in_file in runs[clean].groupby("file"):
        if len(in_file) > _RUNS_LISTED:
            lines.append(
                f"{file}: {len(in_file)} runs ACCEPTED with all {in_file['plateaus'].sum()} "
                "plateaus"
            )
            runs = runs.drop(in_file.index)
    for run in runs.to_dict("records"):
        lines.append(
            f"{run['run_id']}: {run['verdict'].upper()}, {run['accepted_points']} of "
            f"{run['plateaus']} plateaus, {run['samples']} rows"
        )
        of_run = points[(points["run_id"] == run["run_id"]) & ~points["accepted"]]
        by_gate = failed_gates.one_row_per_gate(of_run)
        for gate, count in failed_gates.counts(of_run).items():
            rows = by_gate.loc[by_gate["rule"] == gate, "first_row"]
            lines += [
                f"  {gate}: {count} plateaus, first at row {rows.min()}",
                f"    -> {advice_for(str(gate), kind)}",
            ]
    for refused in verdict.quarantine.to_dict("records"):
        where = refused["run_id"] or refused["file"]
        lines += [
            f"{where}: {refused['rule']}: {refused['reason']}",
            f"  -> {refused['advice']}",
        ]
    return "\n".join(lines)
