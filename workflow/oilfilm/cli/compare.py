"""The command `oilfilm compare`: fits of several oils or campaigns side by side.

Decides: how a comparison of fits is shown.
"""

import argparse
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from oilfilm import tables
from oilfilm.cli.arguments import campaign_folder, quantity, typed_conditions
from oilfilm.errors import OilfilmError, printable
from oilfilm.fits.fitted import SLIP, FittedLaw, read_fit
from oilfilm.fits.side_by_side import middle_of_tested, side_by_side
from oilfilm.report.figures import style
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.traction.law import QUANTITIES

_MU = ("traction_coefficient", "obs_ci_lower", "obs_ci_upper")
_RATIO = ("ratio", "ratio_lower", "ratio_upper")
_CONSTANT = ("value", "lower", "upper")
_SLIPS = (0.01, 0.03, 0.05, 0.1, 0.2)
_DRAWN = 100  # slips of a drawn curve
_DOTTED = ". Dotted: not tested, or above the limiting shear stress"


class NamedFit(NamedTuple):
    """The configured fit of one oil, and where it is from.

    Attributes:
        source: Law, campaign and kind of data, in words.
        fit: The fitted law.
        constants: Rows of the table of coefficients.
    """

    source: str
    fit: FittedLaw
    constants: pd.DataFrame


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    found = read_fits(options.folders, options.oil)
    fits = {name: each.fit for name, each in found.items()}
    at = middle_of_tested(fits, typed_conditions(options))
    tested = min(float(fit.coefficients.box[-1, 1]) for fit in fits.values())
    slips = [quantity(slip, "dimensionless", "--slip") for slip in options.slip or ()]
    slips = slips or [slip for slip in _SLIPS if slip <= tested] or [tested]
    table = side_by_side(fits, at, slips)
    print("\n".join([*_lines(found), *_mu(table, at, [*fits]), *_constants(found)]))
    if options.plot:
        curves = side_by_side(fits, at, np.linspace(0, tested, _DRAWN + 1)[1:])
        simulated = any("simulated" in each.source for each in found.values())
        _draw(curves, at, simulated=simulated).savefig(options.plot)
        print(f"Written: {options.plot}")
    return 0


def read_fits(folders: Sequence[Path], oils: Sequence[str] | None) -> dict[str, NamedFit]:
    """The configured fits in folders of results, by folder and oil.

    Raises:
        OilfilmError: There are fewer than two.
    """
    found = {}
    for folder in folders:
        _, about = campaign_folder(folder)
        coefficients = CampaignTables.in_folder(folder).configured.coefficients
        for oil in map(str, coefficients["oil"].unique()):
            constants = coefficients[coefficients["oil"] == oil]
            if oil in (oils or [oil]) and constants["value"].notna().any():
                fit = read_fit(folder, oil)
                source = f"{fit.law.name}, from campaign {about['campaign']}, {about['data']} data"
                found[printable(f"{folder} {oil}")] = NamedFit(source, fit, constants)
    if len(found) < 2:
        raise OilfilmError(
            f"{', '.join(map(str, folders))}: found {len(found)} fitted oils; expected at "
            "least two. Name another folder of results, or leave out --oil."
        )
    return found


def _lines(found: Mapping[str, NamedFit]) -> Iterator[str]:
    """Where each fit is from, and what keeps it from being sound."""
    for name, each in found.items():
        yield f"{name}: {each.source}"
        yield from (f"{name} is NOT SOUND: {why}" for why in each.fit.wrong)


def _mu(table: pd.DataFrame, at: Mapping[str, float], names: Sequence[str]) -> Iterator[str]:
    """mu of each fit and its ratio to the first one, one row per slide-roll ratio."""
    first, *others = names
    for title, columns, shown, digits in (
        (f"mu with the interval of the next good run, at {_where(at)}", _MU, names, 5),
        (f"Ratio to {first}", _RATIO, others, 3),
    ):
        cells = {"S": table.loc[table["fit"] == first, SLIP]} | {
            name: [_cell(row, columns, digits) for row in tables.rows(table[table["fit"] == name])]
            for name in shown
        }
        yield from ("", title, pd.DataFrame(cells).to_string(index=False))
    if table["outside"].any():
        yield "!: outside the tested conditions of that fit"
    if table["over_limit"].any():
        yield "IMPOSSIBLE: above the limiting shear stress, which no film carries"


def _constants(found: Mapping[str, NamedFit]) -> Iterator[str]:
    cells = {
        name: {row["constant"]: _cell(row, _CONSTANT, 5) for row in tables.rows(each.constants)}
        for name, each in found.items()
    }
    table = pd.DataFrame(cells).fillna("-").to_string()
    yield from ("", "Constants with their 95 % intervals", table)


def _draw(curves: pd.DataFrame, at: Mapping[str, float], *, simulated: bool) -> Figure:
    """mu over slip of each fit with its interval; beside it the ratios to the first fit."""
    figure = Figure(figsize=(style.DOUBLE_COLUMN_IN, 2.9), layout="constrained")
    left, right = figure.subplots(1, 2)
    names = list(dict.fromkeys(curves["fit"]))
    marked = (curves["outside"] | curves["over_limit"]).groupby(curves["fit"], sort=False)
    marks = {name: each.to_numpy() for name, each in marked}
    first = marks[names[0]]
    for axis, label, columns, shown, beside in (
        (left, style.TRACTION_LABEL, _MU, names, np.zeros_like(first)),
        (right, f"Ratio to {names[0]}", _RATIO, names[1:], first),
    ):
        for name in shown:
            of_fit, unsure = curves[curves["fit"] == name], marks[name] | beside
            slip, (value, low, high) = of_fit[SLIP], (of_fit[column] for column in columns)
            colour = style.oil_colour(name, names)
            axis.plot(slip, value.mask(unsure), color=colour, label=name)
            axis.plot(slip, value.where(unsure), ":", color=colour)
            axis.fill_between(slip, low, high, color=colour, alpha=0.2, linewidth=0)
        axis.set(xlabel=style.CONDITION_LABELS[SLIP], ylabel=label)
        axis.legend()
    right.axhline(1, color=style.GREY, linewidth=0.6)
    dotted = any(each.any() for each in marks.values())
    title = f"{'SIMULATED data. ' * simulated}{_where(at)}{_DOTTED * dotted}"
    figure.suptitle(title, fontsize=8)
    return figure


def _where(at: Mapping[str, float]) -> str:
    return ", ".join(
        f"{QUANTITIES[name].symbol} = {value:.4g} {QUANTITIES[name].unit}"
        for name, value in at.items()
    )


def _cell(row: Mapping[str, Any], columns: Sequence[str], digits: int) -> str:
    value, low, high = (row[name] for name in columns)
    if np.isnan(value):
        return "not known"
    interval = "" if np.isnan(low) else f" ({low:.{digits}f} to {high:.{digits}f})"
    mark = " IMPOSSIBLE" if row.get("over_limit") else " !" if row.get("outside") else ""
    return f"{value:.{digits}f}{interval}{mark}"
