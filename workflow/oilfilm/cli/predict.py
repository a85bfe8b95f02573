"""The command `oilfilm predict`: the traction coefficient of a fitted or printed oil.

Decides: when a prediction is refused; what is said of a prediction outside the tested box.
"""

import argparse
from collections.abc import Mapping

import numpy as np

import oilfilm
from oilfilm import tables
from oilfilm.cli.arguments import campaign_folder, quantity
from oilfilm.cli.parser import CONDITION_OPTIONS
from oilfilm.errors import OilfilmError
from oilfilm.fits.fitted import FittedLaw, read_fit
from oilfilm.settings.base import Group, Result, key
from oilfilm.traction.law import QUANTITIES


class OutsideBox(Group):
    """A condition outside its tested range."""

    quantity: str = key("Name with unit.")
    value: float = key("Value that was asked for.")
    minimum: float = key("Smallest tested value.")
    maximum: float = key("Largest tested value.")


class PredictedTraction(Group):
    """The traction coefficient of one oil at one operating point."""

    oil: str = key("Name of the oil.")
    law: str = key("Name of the law.")
    source: str = key("Campaign and kind of its data, or the paper.")
    at: dict[str, Result] = key(
        "Conditions and slide-roll ratio by name with unit; null where the tested level of a "
        "condition is unknown."
    )
    traction_coefficient: float = key("mu.")
    lower: Result = key("Lower end of the 95 % interval; null without interval.")
    upper: Result = key("Upper end of the 95 % interval; null without interval.")
    fixed: list[str] = key("Conditions that the fit does not follow, in sentences.")
    outside: list[OutsideBox] = key("Conditions outside the tested box.")
    tested_ranges_outside: Result = key(
        "How far outside the tested box, in tested ranges; null where it is unknown."
    )
    no_interval: str = key("Why there is no interval; empty where there is one.")

    def text(self) -> str:
        """The prediction in sentences."""
        interval = self.no_interval or f"95 % interval {self.lower:.5f} to {self.upper:.5f}"
        lines = [f"{self.oil}, {self.law}: mu = {self.traction_coefficient:.5f}, {interval}"]
        lines += [
            f"mu and its interval are those where it was tested: {each}" for each in self.fixed
        ]
        lines += [
            f"OUTSIDE the tested box: {each.quantity} {each.value:g}, tested "
            f"{each.minimum:.4g} to {each.maximum:.4g} {tables.COLUMNS[each.quantity].shown_unit}"
            for each in self.outside
        ]
        if self.tested_ranges_outside:
            lines.append(
                f"{self.tested_ranges_outside:.1f} tested ranges outside: the interval holds only "
                "if the law does"
            )
        lines.append(self.source)
        return "\n".join(line.rstrip() for line in lines)


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    at = {"slide_roll_ratio": quantity(options.slip, "dimensionless", "--slip")}
    for option, (name, _, _) in CONDITION_OPTIONS.items():
        typed = getattr(options, option.removeprefix("--"))
        if typed is not None:
            at[name] = quantity(typed, QUANTITIES[name].unit, option)
    if options.printed:
        fit, source = oilfilm.printed(options.oil), "constants as the paper prints them"
    else:
        folder, about = campaign_folder(options.results, options.campaign)
        fit = read_fit(folder, options.oil)
        source = f"from campaign {about['campaign']}, {about['data']} data"
    predicted = prediction(fit, options.oil, at, source)
    print(predicted.model_dump_json() if options.json else predicted.text())
    return 0


def prediction(
    fit: FittedLaw, oil: str, at: Mapping[str, float], source: str = ""
) -> PredictedTraction:
    """Prediction of a fit at one operating point.

    Args:
        fit: The fitted law.
        oil: Name of its oil.
        at: Slide-roll ratio and conditions by their columns' names. A condition that the fit does
            not follow may be left out: mu is then given at its tested level.
        source: Where the constants are from, in words.

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
    line = dict(zip(fit.law.conditions, fit.on_line(conditions)[0].tolist(), strict=True))
    where = {
        each: each.sentence() + ("" if np.isnan(line[name]) else f"; here that is {line[name]:.4g}")
        for name, each in fixed.items()
    }
    if away := fit.away_from(conditions):
        unknown = any(each.level is None for each in away)
        advice = "Give a point on it. Without the option the tested value is used."
        raise OilfilmError(
            f"{oil}: mu is not known there: {'; '.join(where[each] for each in away)}."
            + ("" if unknown else f" {advice}")
        )
    at = {**line, "slide_roll_ratio": at["slide_roll_ratio"]}
    mu, lower = float(predicted.traction_coefficient[0]), float(predicted.lower[0])
    if not np.isfinite(mu):
        raise OilfilmError(f"{oil}: the law {fit.law.name} has no value there.")
    return PredictedTraction(
        oil=oil,
        law=fit.law.name,
        source=source,
        at=dict(at),
        traction_coefficient=mu,
        lower=lower,
        upper=float(predicted.upper[0]),
        fixed=[*where.values()],
        outside=list(_outside(fit, at)),
        tested_ranges_outside=float(predicted.distance[0]),
        no_interval=_no_interval(fit) if np.isnan(lower) else "",
    )


def _no_interval(fit: FittedLaw) -> str:
    if np.isnan(fit.coefficients.box).all():
        return "no interval, because the paper states none"
    return "no interval, because too few curves were tested (fit.min_curves_to_resample)"


def _outside(fit: FittedLaw, at: Mapping[str, float]) -> list[OutsideBox]:
    """The conditions outside the tested box."""
    box = zip(at.items(), fit.reach.tolist(), strict=True)
    return [
        OutsideBox(quantity=name, value=value, minimum=low, maximum=high)
        for (name, value), (low, high) in box
        if np.isfinite([low, value]).all() and not low <= abs(value) <= high
    ]


def _refuse_other_conditions(fit: FittedLaw, oil: str, at: Mapping[str, float]) -> None:
    """Refuse conditions that the law does not take, and missing ones that it needs."""
    fixed = {each.condition for each in fit.coefficients.fixed}
    wanted = set(fit.law.conditions)
    for name in at:
        if name not in (*wanted, "slide_roll_ratio"):
            taken = ", ".join(fit.law.conditions)
            raise OilfilmError(
                f"{oil}: the law {fit.law.name} does not take {name}. It takes {taken}."
            )
    for option, (name, _, example) in CONDITION_OPTIONS.items():
        if name in wanted and name not in at and name not in fixed:
            raise OilfilmError(
                f"{oil}: {option} is missing; the fit depends on {name}. Give it, as {option} "
                f"{example}."
            )
