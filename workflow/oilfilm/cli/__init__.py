"""The command `oilfilm`: check logs, predict traction, plan tests, verify and compare releases.

Everything else is a target of snakemake.
"""

import argparse
import io
import os
import sys
from collections.abc import Mapping, Sequence

import numpy as np

from oilfilm import tables
from oilfilm.cli import check, plan
from oilfilm.cli.arguments import add_results, campaign_folder
from oilfilm.cli.arguments import quantity as quantity
from oilfilm.errors import OilfilmError
from oilfilm.fitting.fitted import FittedLaw, read_fit
from oilfilm.releases.commands import add_commands
from oilfilm.traction.law import QUANTITIES


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command; exit code 0 for success, 1 for a refused log, 2 for a mistake."""
    if isinstance(sys.stdout, io.TextIOWrapper):
        # a terminal that cannot show a letter of a log gets its number
        sys.stdout.reconfigure(errors="backslashreplace")
    options = _parser().parse_args(arguments)
    try:
        code = int(options.run(options))
        sys.stdout.flush()
        return code
    except OilfilmError as mistake:
        print(mistake, file=sys.stderr)
        return 2
    except BrokenPipeError:
        # whoever read the output has enough of it; nothing more must be written at the end
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 2
    except OSError as error:
        print(f"{error.filename or 'the output'}: {error.strerror}.", file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return 130


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
    check.add_command(commands)
    predict = commands.add_parser("predict", help="traction coefficient of a fitted oil")
    predict.add_argument("--oil", required=True)
    for option, (name, example) in _OPTIONS.items():
        meaning = f"{QUANTITIES[name].meaning}, as {example}"
        predict.add_argument(option, metavar=example, help=meaning)
    predict.add_argument("--slip", required=True, help="slide-roll ratio, as 0.05 or 5%%")
    add_results(predict)
    predict.set_defaults(run=_predict)
    plan.add_command(commands)
    add_commands(commands)
    return parser


def _predict(options: argparse.Namespace) -> int:
    at = {"slide_roll_ratio": quantity(options.slip, "dimensionless", "--slip")}
    for option, (name, _) in _OPTIONS.items():
        typed = getattr(options, option.removeprefix("--"))
        if typed is not None:
            at[name] = quantity(typed, QUANTITIES[name].unit, option)
    folder, about = campaign_folder(options.results, options.campaign)
    fit = read_fit(folder, options.oil)
    print(prediction(fit, options.oil, at))
    print(f"from campaign {about['campaign']}, {about['data']} data")
    return 0


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
    if np.isnan(fit.coefficients.constants).any():
        raise OilfilmError(f"{oil}: nothing could be fitted; see results/*/summary.txt.")
    line = dict(zip(fit.law.conditions, fit.on_line(conditions)[0], strict=True))
    where = [
        each.sentence() + ("" if np.isnan(line[name]) else f"; here that is {line[name]:.4g}")
        for name, each in fixed.items()
    ]
    if predicted.away[0]:
        unknown = any(each.level is None for each in fixed.values())
        advice = "Ask for a point on it, or leave the option out to be given the tested value."
        raise OilfilmError(
            f"{oil}: mu is not known there: {'; '.join(where)}." + ("" if unknown else f" {advice}")
        )
    values = predicted.traction_coefficient, predicted.lower, predicted.upper
    mu, lower, upper = (float(value[0]) for value in values)
    interval = f"95 % interval {lower:.5f} to {upper:.5f}"
    if np.isnan(lower):
        interval = "no interval, because too few curves were tested (fit.min_curves_to_resample)"
    lines = [f"{oil}, {fit.law.name}: mu = {mu:.5f}, {interval}"]
    lines += [f"mu and its interval are those where it was tested: {each}" for each in where]
    at = dict(at) | line
    box = dict(zip((*fit.law.conditions, "slide_roll_ratio"), fit.reach, strict=True))
    for name, value in at.items():
        low, high = box[name]
        if np.isfinite([low, value]).all() and not low <= abs(value) <= high:
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
    """Refuse conditions that the law does not take, and missing ones that it needs."""
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
