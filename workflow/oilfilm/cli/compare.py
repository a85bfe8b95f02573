"""The command `oilfilm compare`: fits of several oils or campaigns side by side.

Decides: how a comparison of fits is shown.
"""

import argparse
from collections.abc import Iterator, Mapping, Sequence
from itertools import chain
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from oilfilm import tables
from oilfilm.base.errors import OilfilmError, printable
from oilfilm.base.units import BoolArray
from oilfilm.cli.arguments import campaign_folder, quantity, typed_conditions
from oilfilm.fits.fitted import SLIP, FittedLaw, read_fit
from oilfilm.fits.side_by_side import middle_of_tested, side_by_side
from oilfilm.report.figures import style
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.traction.law import QUANTITIES

_MU = ("traction_coefficient", "obs_ci_lower", "obs_ci_upper")
_RATIO = ("ratio", "ratio_lower", "ratio_upper")
_CONSTANT = ("value", "lower", "upper")
# Slide-roll ratios where none is typed.
_DEFAULT_SLIPS = (0.01, 0.03, 0.05, 0.1, 0.2)
_POINTS_PER_DRAWN_CURVE = 100
_DOTTED = ". Dotted: not tested, or above the limiting shear stress"


class NamedFit(NamedTuple):
    """The configured fit of one oil, and its origin.

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
    named_fits = read_fits(options.folders, options.oil)
    fits = {name: named.fit for name, named in named_fits.items()}
    conditions = middle_of_tested(fits, typed_conditions(options))
    largest_slip = min(float(fit.coefficients.box[-1, 1]) for fit in fits.values())
    slips = [quantity(slip, "dimensionless", "--slip") for slip in options.slip or ()]
    if not slips:
        slips = [slip for slip in _DEFAULT_SLIPS if slip <= largest_slip] or [largest_slip]
    table = side_by_side(fits, conditions, slips)
    lines = chain(_origins(named_fits), _mu(table, conditions, list(fits)), _constants(named_fits))
    print("\n".join(lines))
    if options.plot:
        drawn_slips = np.linspace(0, largest_slip, _POINTS_PER_DRAWN_CURVE + 1)[1:]
        curves = side_by_side(fits, conditions, drawn_slips)
        simulated = any("simulated" in named.source for named in named_fits.values())
        _draw(curves, conditions, simulated=simulated).savefig(options.plot)
        print(f"Written: {options.plot}")
    return 0


def read_fits(folders: Sequence[Path], oils: Sequence[str] | None) -> dict[str, NamedFit]:
    """The configured fits in folders of results, by folder and oil.

    Raises:
        OilfilmError: There are fewer than two.
    """
    named_fits = {}
    for folder in folders:
        _, footer = campaign_folder(folder)
        coefficients = CampaignTables.in_folder(folder).configured.coefficients
        for oil in map(str, coefficients["oil"].unique()):
            constants = coefficients[coefficients["oil"] == oil]
            is_fitted = constants["value"].notna().any()
            if is_fitted and (not oils or oil in oils):
                fit = read_fit(folder, oil)
                source = (
                    f"{fit.law.name}, from campaign {footer['campaign']}, {footer['data']} data"
                )
                named_fits[printable(f"{folder} {oil}")] = NamedFit(source, fit, constants)
    if len(named_fits) < 2:
        raise OilfilmError(
            f"{', '.join(map(str, folders))}: found {len(named_fits)} fitted oils; expected at "
            "least two. Name another folder of results, or leave out --oil."
        )
    return named_fits


def _origins(named_fits: Mapping[str, NamedFit]) -> Iterator[str]:
    """The origin of each fit, and the reasons why it is not sound."""
    for name, named in named_fits.items():
        yield f"{name}: {named.source}"
        for reason in named.fit.wrong:
            yield f"{name} is NOT SOUND: {reason}"


def _mu(
    table: pd.DataFrame, conditions: Mapping[str, float], names: Sequence[str]
) -> Iterator[str]:
    """mu of each fit and its ratio to the first one, one row per slide-roll ratio."""
    first, *others = names
    yield ""
    yield f"mu with the interval of the next good run, at {_conditions_text(conditions)}"
    yield _by_slip(table, names, _MU, digits=5)
    yield ""
    yield f"Ratio to {first}"
    yield _by_slip(table, others, _RATIO, digits=3)
    if table["outside"].any():
        yield "!: outside the tested conditions of that fit"
    if table["over_limit"].any():
        yield "IMPOSSIBLE: above the limiting shear stress, which no film carries"


def _by_slip(
    table: pd.DataFrame, names: Sequence[str], columns: Sequence[str], *, digits: int
) -> str:
    """A value with its interval, as text: one row per slide-roll ratio, one column per fit."""
    is_first_fit = table["fit"] == table["fit"].iloc[0]
    cells: dict[str, Any] = {"S": table.loc[is_first_fit, SLIP]}
    for name in names:
        rows_of_fit = tables.rows(table[table["fit"] == name])
        cells[name] = [_cell(row, columns, digits) for row in rows_of_fit]
    return pd.DataFrame(cells).to_string(index=False)


def _constants(named_fits: Mapping[str, NamedFit]) -> Iterator[str]:
    cells = {}
    for name, named in named_fits.items():
        rows = tables.rows(named.constants)
        cells[name] = {row["constant"]: _cell(row, _CONSTANT, digits=5) for row in rows}
    yield ""
    yield "Constants with their 95 % intervals"
    yield pd.DataFrame(cells).fillna("-").to_string()


def _draw(curves: pd.DataFrame, conditions: Mapping[str, float], *, simulated: bool) -> Figure:
    """mu over slip of each fit with its interval; beside it the ratios to the first fit."""
    figure = Figure(figsize=(style.DOUBLE_COLUMN_IN, 2.9), layout="constrained")
    left, right = figure.subplots(1, 2)
    curve_of_fit = {str(name): curve for name, curve in curves.groupby("fit", sort=False)}
    names = list(curve_of_fit)
    doubtful = {
        name: (curve["outside"] | curve["over_limit"]).to_numpy()
        for name, curve in curve_of_fit.items()
    }
    first = names[0]
    for name, curve in curve_of_fit.items():
        colour = style.oil_colour(name, names)
        _draw_curve(left, curve, _MU, doubtful[name], colour, name)
        if name != first:
            # a ratio is doubtful where one of the two is
            _draw_curve(right, curve, _RATIO, doubtful[name] | doubtful[first], colour, name)
    right.axhline(1, color=style.GREY, linewidth=0.6)
    for axis, label in ((left, style.TRACTION_LABEL), (right, f"Ratio to {first}")):
        axis.set(xlabel=style.CONDITION_LABELS[SLIP], ylabel=label)
        axis.legend()
    title = _conditions_text(conditions)
    if simulated:
        title = f"SIMULATED data. {title}"
    if any(marks.any() for marks in doubtful.values()):
        title += _DOTTED
    figure.suptitle(title, fontsize=8)
    return figure


def _draw_curve(
    axis: Axes,
    curve: pd.DataFrame,
    columns: Sequence[str],
    doubtful: BoolArray,
    colour: str,
    label: str,
) -> None:
    """Draw a value over slip with its interval; dotted where it is doubtful."""
    value, lower, upper = (curve[column] for column in columns)
    axis.plot(curve[SLIP], value.mask(doubtful), color=colour, label=label)
    axis.plot(curve[SLIP], value.where(doubtful), ":", color=colour)
    axis.fill_between(curve[SLIP], lower, upper, color=colour, alpha=0.2, linewidth=0)


def _conditions_text(conditions: Mapping[str, float]) -> str:
    return ", ".join(
        f"{QUANTITIES[name].symbol} = {value:.4g} {QUANTITIES[name].unit}"
        for name, value in conditions.items()
    )


def _cell(row: Mapping[str, Any], columns: Sequence[str], digits: int) -> str:
    """A value with its interval and a mark where it is doubtful."""
    value, low, high = (row[name] for name in columns)
    if np.isnan(value):
        return "not known"
    text = f"{value:.{digits}f}"
    if not np.isnan(low):
        text += f" ({low:.{digits}f} to {high:.{digits}f})"
    if row.get("over_limit"):
        text += " IMPOSSIBLE"
    elif row.get("outside"):
        text += " !"
    return text
