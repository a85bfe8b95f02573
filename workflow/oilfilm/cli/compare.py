"""The command `oilfilm compare`: fits of several oils or campaigns side by side.

Decides: how a comparison of fits is shown.
"""

import argparse
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import chain
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from oilfilm import tables
from oilfilm.base.errors import OilfilmError, printable
from oilfilm.cli.arguments import campaign_folder, quantity, typed_conditions
from oilfilm.cli.plot_file import refuse_plot, write_plot
from oilfilm.fits.fitted import SLIP
from oilfilm.fits.oil_pairs import MeasuredOil, Obstacle, OilPair, oil_pair, read_oil
from oilfilm.fits.side_by_side import MU_COLUMNS, RATIO_COLUMNS, middle_of_tested, side_by_side
from oilfilm.fits.support_sentences import why_no_support
from oilfilm.surface.reduction import box_of
from oilfilm.surface.support import Support
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.traction.law import CONDITIONS, QUANTITIES

_CONSTANT_COLUMNS = ("value", "lower", "upper")
# Slide-roll ratios where none is typed.
_DEFAULT_SLIPS = (0.01, 0.03, 0.05, 0.1, 0.2)
_POINTS_PER_DRAWN_CURVE = 100
_UNKNOWN_RIG = "unknown"
_OBSTACLES = {
    Obstacle.SAME_RUNS: "both fits have the same runs",
    Obstacle.OTHER_CONDITIONS: "a law takes other conditions than pressure, speed and temperature",
    Obstacle.UNKNOWN_CONDITIONS: "the runs do not tell pressure, speed and temperature",
    Obstacle.FEW_PAIRS: "too few conditions were tested with both oils",
}


class NamedFit(NamedTuple):
    """The configured fit of one oil, and its origin.

    Attributes:
        source: Law, campaign and kind of data, in words.
        oil: The fitted law, and the runs.
        constants: Rows of the table of coefficients.
    """

    source: str
    oil: MeasuredOil
    constants: pd.DataFrame


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    refuse_plot(options.plot)
    named_fits = read_fits(options.folders, options.oil)
    fits = {name: named.oil.fit for name, named in named_fits.items()}
    conditions = middle_of_tested(fits, typed_conditions(options))
    largest_slip = min(float(fit.coefficients.tested_box[-1, 1]) for fit in fits.values())
    slips = [quantity(slip, "dimensionless", "--slip") for slip in options.slip or ()]
    if not slips:
        slips = [slip for slip in _DEFAULT_SLIPS if slip <= largest_slip] or [largest_slip]
    (_, first_fit), *other_fits = named_fits.items()
    pairs = {name: oil_pair(first_fit.oil, named.oil) for name, named in other_fits}
    table = side_by_side(fits, conditions, slips, pairs)
    lines = chain(
        _lines_of_origins(named_fits),
        _lines_of_mu(table, conditions, list(fits)),
        _lines_of_ratios(table, list(fits), pairs),
        _lines_of_constants(named_fits),
    )
    print("\n".join(lines))
    if options.plot:
        drawn_slips = np.linspace(0, largest_slip, _POINTS_PER_DRAWN_CURVE + 1)[1:]
        curves = side_by_side(fits, conditions, drawn_slips, pairs)
        has_simulated_data = any("simulated" in named.source for named in named_fits.values())
        # imported here, because it needs matplotlib
        from oilfilm.cli.compare_plot import draw  # noqa: PLC0415

        write_plot(
            draw(curves, _conditions_text(conditions), has_simulated_data=has_simulated_data),
            options.plot,
        )
        print(f"Written: {options.plot}")
    return 0


def read_fits(folders: Sequence[Path], oils: Sequence[str] | None) -> dict[str, NamedFit]:
    """The configured fits in folders of results, by folder and oil.

    Raises:
        OilfilmError: There are fewer than two.
    """
    named_fits = {}
    for typed in folders:
        folder, footer = campaign_folder(typed)
        coefficients = CampaignTables.in_folder(folder).configured.coefficients
        for oil in map(str, coefficients["oil"].unique()):
            constants = coefficients[coefficients["oil"] == oil]
            is_fitted = constants["value"].notna().any()
            if is_fitted and (not oils or oil in oils):
                measured = read_oil(folder, oil)
                source = (
                    f"{measured.fit.law.name}, from campaign {footer['campaign']}, "
                    f"{footer['data']} data"
                )
                named_fits[printable(f"{folder} {oil}")] = NamedFit(source, measured, constants)
    if len(named_fits) < 2:
        raise OilfilmError(
            f"{', '.join(map(str, folders))}: found {len(named_fits)} fitted oils; expected at "
            f"least two. Name another folder of results{', or leave out --oil' if oils else ''}."
        )
    return named_fits


def _lines_of_origins(named_fits: Mapping[str, NamedFit]) -> Iterator[str]:
    """The origin of each fit, and the reasons why it is not sound."""
    for name, named in named_fits.items():
        yield f"{name}: {named.source}"
        for reason in named.oil.fit.warnings:
            yield f"{name} is NOT SOUND: {reason}"


def _lines_of_mu(
    table: pd.DataFrame, conditions: Mapping[str, float], names: Sequence[str]
) -> Iterator[str]:
    """mu of each fit, one row per slide-roll ratio."""
    yield ""
    yield f"mu with the interval of the next good run, at {_conditions_text(conditions)}"
    yield _table_by_slip(table, names, _mu_cell)
    if table["outside"].any():
        yield "!: outside the tested conditions of that fit"
    if table["over_limit"].any():
        yield "IMPOSSIBLE: above the limiting shear stress, which no film carries"


def _lines_of_ratios(
    table: pd.DataFrame, names: Sequence[str], pairs: Mapping[str, OilPair]
) -> Iterator[str]:
    """The ratio of each fit to the first one, one row per slip, and what it stands on."""
    first_name, *other_names = names
    yield ""
    yield f"Ratio to {first_name}"
    yield _table_by_slip(table, other_names, _ratio_cell)
    rows_of_others = table[table["fit"] != first_name]
    if rows_of_others["ratio_outside"].any():
        yield "!: outside the tested conditions of one of the two; nothing is certain there"
    for name in other_names:
        yield f"{name}: {_basis_of_ratio(pairs[name])}"
        ratio = pairs[name].ratio_or_obstacle
        if isinstance(ratio, Obstacle):
            continue
        for code in np.unique(rows_of_others.loc[rows_of_others["fit"] == name, "ratio_support"]):
            if code != Support.SUPPORTED:
                reason = why_no_support(Support(code).name.lower(), ratio.limits)
                yield f"{name}: no support: {reason}"
    if (rows_of_others["ratio_of"] == "runs").any():
        yield (
            "Not covered by the interval: a gain of the force that all runs of one oil share, as "
            "after a calibration or a change of the ball between the oils."
        )


def _basis_of_ratio(pair: OilPair) -> str:
    """What a ratio stands on, and what is not in its interval, in sentences."""
    if isinstance(pair.ratio_or_obstacle, Obstacle):
        return (
            f"{_OBSTACLES[pair.ratio_or_obstacle]}. This is the ratio of the two laws. Its "
            "interval takes both as independent and their forms as true, so nothing is certain."
        )
    level = pair.ratio_or_obstacle.interval_factors.level
    sentences = [
        f"ratio by the runs at {pair.paired_count} conditions of both oils; they allow an "
        f"interval of {level:.0%}."
    ]
    if pair.unpaired_count:
        sentences.append(
            f"{pair.unpaired_count} conditions of one oil alone count with what both oils have in "
            "common."
        )
    two_levels = box_of(pair.ratio_or_obstacle.runs.stacked).has_two_levels
    for name in np.array(CONDITIONS)[two_levels]:
        meaning = QUANTITIES[str(name)].short_meaning
        sentences.append(f"The {meaning} has two levels: a bend of the ratio between is not seen.")
    if not pair.ratio_or_obstacle.converged:
        sentences.append("The search of the sizes of errors found no maximum: do not rely on it.")
    sentences.append(_rigs_text(*pair.rig_names))
    return " ".join(sentences)


def _rigs_text(first: frozenset[str], second: frozenset[str]) -> str:
    """Whether the calibration of the rigs cancels in a ratio."""
    if _UNKNOWN_RIG in first | second:
        return (
            "Their rigs are not known: if the oils were tested on different rigs, the calibration "
            "does not cancel and is not in the interval."
        )
    if first == second:
        return "The calibration of the rig cancels."
    return (
        f"Their rigs differ ({', '.join(sorted(first))}; {', '.join(sorted(second))}): the "
        "calibration does not cancel and is not in the interval."
    )


def _table_by_slip(
    table: pd.DataFrame, names: Sequence[str], cell: Callable[[Mapping[str, Any]], str]
) -> str:
    """Values as text: one row per slide-roll ratio, one column per fit."""
    is_first_fit = table["fit"] == table["fit"].iloc[0]
    cells: dict[str, Any] = {"S": table.loc[is_first_fit, SLIP]}
    for name in names:
        cells[name] = [cell(row) for row in tables.rows(table[table["fit"] == name])]
    return pd.DataFrame(cells).to_string(index=False)


def _mu_cell(row: Mapping[str, Any]) -> str:
    """mu with its interval, and a mark where it is doubtful."""
    text = _interval_text(row, MU_COLUMNS, digits=5)
    if np.isnan(row["traction_coefficient"]):
        return text
    if row["over_limit"]:
        return f"{text} IMPOSSIBLE"
    return f"{text} !" if row["outside"] else text


def _ratio_cell(row: Mapping[str, Any]) -> str:
    """A ratio with its interval, and whether it is certain; or what keeps it from being so."""
    text = _interval_text(row, RATIO_COLUMNS, digits=3)
    if np.isnan(row["ratio"]):
        return text
    marks = []
    if row["ratio_of"] == "laws":
        marks.append("of laws")
    elif row["ratio_support"] != Support.SUPPORTED:
        marks.append("no support")
    elif row["certain"]:
        marks.append(row["certain"])
    if row["ratio_outside"]:
        marks.append("!")
    return " ".join([text, *marks])


def _lines_of_constants(named_fits: Mapping[str, NamedFit]) -> Iterator[str]:
    cells = {}
    for name, named in named_fits.items():
        rows = tables.rows(named.constants)
        cells[name] = {
            row["constant"]: _interval_text(row, _CONSTANT_COLUMNS, digits=5) for row in rows
        }
    yield ""
    yield "Constants with their 95 % intervals"
    yield pd.DataFrame(cells).fillna("-").to_string()


def _conditions_text(conditions: Mapping[str, float]) -> str:
    """The conditions of a comparison with symbols and units."""
    return ", ".join(
        f"{QUANTITIES[name].symbol} = {value:.4g} {QUANTITIES[name].unit}"
        for name, value in conditions.items()
    )


def _interval_text(row: Mapping[str, Any], columns: Sequence[str], digits: int) -> str:
    """A value with its interval."""
    value, low, high = (row[name] for name in columns)
    if np.isnan(value):
        return "not known"
    text = f"{value:.{digits}f}"
    if not np.isnan(low):
        text += f" ({low:.{digits}f} to {high:.{digits}f})"
    return text
