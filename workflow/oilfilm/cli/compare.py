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
from oilfilm.cli.arguments import results_and_footer, typed_conditions, typed_quantity
from oilfilm.cli.plot_file import refuse_plot, write_plot
from oilfilm.fits.fitted import SLIP
from oilfilm.fits.oil_pairs import MeasuredOil, Obstacle, OilPair, oil_pair, read_oil
from oilfilm.fits.side_by_side import (
    MU_COLUMNS,
    RATIO_COLUMNS,
    comparison_conditions,
    comparison_table,
)
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
_OBSTACLE_IN_WORDS = {
    Obstacle.SAME_RUNS: "both fits have the same runs",
    Obstacle.OTHER_CONDITIONS: "a law takes other conditions than pressure, speed and temperature",
    Obstacle.UNKNOWN_CONDITIONS: "the runs do not tell pressure, speed and temperature",
    Obstacle.FEW_PAIRS: "too few conditions were tested with both oils",
}


class ComparedFit(NamedTuple):
    """The configured fit of one oil that is compared, and its origin.

    Attributes:
        origin: Law, campaign and kind of data, in words.
        is_simulated: Whether the data are simulated.
        measured_oil: The fitted law, and the runs.
        constants: Rows of the table of coefficients.
    """

    origin: str
    is_simulated: bool
    measured_oil: MeasuredOil
    constants: pd.DataFrame


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    refuse_plot(options.plot)
    fit_by_name = read_fits(options.folders, options.oil)
    law_by_name = {name: fit.measured_oil.fit for name, fit in fit_by_name.items()}
    conditions = comparison_conditions(law_by_name, typed_conditions(options))
    largest_slip = min(float(law.coefficients.tested_box[-1, 1]) for law in law_by_name.values())
    slips = [typed_quantity(slip, "dimensionless", "--slip") for slip in options.slip or ()]
    if not slips:
        slips = [slip for slip in _DEFAULT_SLIPS if slip <= largest_slip] or [largest_slip]
    (_, first_fit), *other_fits = fit_by_name.items()
    pair_by_name = {
        name: oil_pair(first_fit.measured_oil, fit.measured_oil) for name, fit in other_fits
    }
    comparison = comparison_table(law_by_name, conditions, slips, pair_by_name)
    lines = chain(
        _lines_of_origins(fit_by_name),
        _lines_of_mu(comparison, conditions, list(law_by_name)),
        _lines_of_ratios(comparison, list(law_by_name), pair_by_name),
        _lines_of_constants(fit_by_name),
    )
    print("\n".join(lines))
    if options.plot:
        drawn_slips = np.linspace(0, largest_slip, _POINTS_PER_DRAWN_CURVE + 1)[1:]
        curves = comparison_table(law_by_name, conditions, drawn_slips, pair_by_name)
        has_simulated_data = any(fit.is_simulated for fit in fit_by_name.values())
        # imported here, because it needs matplotlib
        from oilfilm.cli.compare_plot import comparison_figure  # noqa: PLC0415

        write_plot(
            comparison_figure(
                curves, _conditions_text(conditions), has_simulated_data=has_simulated_data
            ),
            options.plot,
        )
        print(f"Written: {options.plot}")
    return 0


def read_fits(folders: Sequence[Path], oil_names: Sequence[str] | None) -> dict[str, ComparedFit]:
    """The configured fits in folders of results, by their names: folder and oil.

    Raises:
        OilfilmError: There are fewer than two.
    """
    fit_by_name = {}
    for typed_folder in folders:
        folder, footer = results_and_footer(typed_folder)
        coefficients = CampaignTables.from_folder(folder).configured_fits.coefficients
        for oil_name in map(str, coefficients["oil"].unique()):
            constants = coefficients[coefficients["oil"] == oil_name]
            is_fitted = constants["value"].notna().any()
            if is_fitted and (not oil_names or oil_name in oil_names):
                measured_oil = read_oil(folder, oil_name)
                origin = (
                    f"{measured_oil.fit.law.name}, from campaign {footer['campaign']}, "
                    f"{footer['data']} data"
                )
                fit_name = printable(f"{folder} {oil_name}")
                fit_by_name[fit_name] = ComparedFit(
                    origin, "simulated" in footer["data"], measured_oil, constants
                )
    if len(fit_by_name) < 2:
        other_advice = ", or leave out --oil" if oil_names else ""
        raise OilfilmError(
            f"{', '.join(map(str, folders))}: found {len(fit_by_name)} fitted oils; expected at "
            f"least two. Name another folder of results{other_advice}."
        )
    return fit_by_name


def _lines_of_origins(fit_by_name: Mapping[str, ComparedFit]) -> Iterator[str]:
    """The origin of each fit, and the reasons why it is not sound."""
    for fit_name, compared_fit in fit_by_name.items():
        yield f"{fit_name}: {compared_fit.origin}"
        for reason in compared_fit.measured_oil.fit.warnings:
            yield f"{fit_name} is NOT SOUND: {reason}"


def _lines_of_mu(
    comparison: pd.DataFrame, conditions: Mapping[str, float], fit_names: Sequence[str]
) -> Iterator[str]:
    """mu of each fit, one row per slide-roll ratio."""
    yield ""
    yield f"mu with the interval of the next good run, at {_conditions_text(conditions)}"
    yield _table_by_slip(comparison, fit_names, _mu_cell)
    if comparison["outside"].any():
        yield "!: outside the tested conditions of that fit"
    if comparison["over_limit"].any():
        yield "IMPOSSIBLE: above the limiting shear stress, which no film carries"


def _lines_of_ratios(
    comparison: pd.DataFrame, fit_names: Sequence[str], pair_by_name: Mapping[str, OilPair]
) -> Iterator[str]:
    """The ratio of each fit to the first one, one row per slip, and what it is computed from."""
    first_name, *other_names = fit_names
    yield ""
    yield f"Ratio to {first_name}"
    yield _table_by_slip(comparison, other_names, _ratio_cell)
    rows_of_others = comparison[comparison["fit"] != first_name]
    if rows_of_others["ratio_outside"].any():
        yield "!: outside the tested conditions of one of the two; nothing is certain there"
    for fit_name in other_names:
        yield f"{fit_name}: {_basis_of_ratio(pair_by_name[fit_name])}"
        ratio = pair_by_name[fit_name].ratio_or_obstacle
        if isinstance(ratio, Obstacle):
            continue
        rows_of_fit = rows_of_others[rows_of_others["fit"] == fit_name]
        for support_code in np.unique(rows_of_fit["ratio_support"]):
            if support_code != Support.SUPPORTED:
                reason = why_no_support(Support(support_code).name.lower(), ratio.limits)
                yield f"{fit_name}: no support: {reason}"
    if (rows_of_others["ratio_of"] == "runs").any():
        yield (
            "Not covered by the interval: a gain of the force that all runs of one oil share, as "
            "after a calibration or a change of the ball between the oils."
        )


def _basis_of_ratio(pair: OilPair) -> str:
    """What a ratio is computed from, and what its interval does not cover, in sentences."""
    if isinstance(pair.ratio_or_obstacle, Obstacle):
        return (
            f"{_OBSTACLE_IN_WORDS[pair.ratio_or_obstacle]}. This is the ratio of the two laws. "
            "Its interval takes both as independent and their forms as true, so nothing is certain."
        )
    confidence = pair.ratio_or_obstacle.interval_factors.level
    sentences = [
        f"ratio by the runs at {pair.paired_count} conditions of both oils; they allow an "
        f"interval of {confidence:.0%}."
    ]
    if pair.unpaired_count:
        sentences.append(
            f"{pair.unpaired_count} conditions of one oil alone count with what both oils have in "
            "common."
        )
    has_two_levels = box_of(pair.ratio_or_obstacle.runs.stacked).has_two_levels
    for condition in np.array(CONDITIONS)[has_two_levels]:
        meaning = QUANTITIES[str(condition)].short_meaning
        sentences.append(f"The {meaning} has two levels: a bend of the ratio between is not seen.")
    if not pair.ratio_or_obstacle.converged:
        sentences.append("The search of the sizes of errors found no maximum: do not rely on it.")
    sentences.append(_rigs_text(*pair.rig_names))
    return " ".join(sentences)


def _rigs_text(first_rigs: frozenset[str], second_rigs: frozenset[str]) -> str:
    """Whether the calibration of the rigs cancels in a ratio."""
    if _UNKNOWN_RIG in first_rigs | second_rigs:
        return (
            "Their rigs are not known: if the oils were tested on different rigs, the calibration "
            "does not cancel and is not in the interval."
        )
    if first_rigs == second_rigs:
        return "The calibration of the rig cancels."
    return (
        f"Their rigs differ ({', '.join(sorted(first_rigs))}; {', '.join(sorted(second_rigs))}): "
        "the calibration does not cancel and is not in the interval."
    )


def _table_by_slip(
    comparison: pd.DataFrame,
    fit_names: Sequence[str],
    cell_text: Callable[[Mapping[str, Any]], str],
) -> str:
    """Values as text: one row per slide-roll ratio, one column per fit.

    Args:
        comparison: Rows of `comparison_table`.
        fit_names: Names of the fits that get a column.
        cell_text: Function of a row that returns the text of its cell.
    """
    is_first_fit = comparison["fit"] == comparison["fit"].iloc[0]
    cells_by_column: dict[str, Any] = {"S": comparison.loc[is_first_fit, SLIP]}
    for fit_name in fit_names:
        rows_of_fit = tables.rows(comparison[comparison["fit"] == fit_name])
        cells_by_column[fit_name] = [cell_text(row) for row in rows_of_fit]
    return pd.DataFrame(cells_by_column).to_string(index=False)


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


def _lines_of_constants(fit_by_name: Mapping[str, ComparedFit]) -> Iterator[str]:
    """The constants of each fit with their intervals, one row per constant."""
    cells_by_fit = {}
    for fit_name, compared_fit in fit_by_name.items():
        constant_rows = tables.rows(compared_fit.constants)
        cells_by_fit[fit_name] = {
            row["constant"]: _interval_text(row, _CONSTANT_COLUMNS, digits=5)
            for row in constant_rows
        }
    yield ""
    yield "Constants with their 95 % intervals"
    yield pd.DataFrame(cells_by_fit).fillna("-").to_string()


def _conditions_text(value_by_condition: Mapping[str, float]) -> str:
    """The conditions of a comparison with symbols and units."""
    return ", ".join(
        f"{QUANTITIES[condition].symbol} = {value:.4g} {QUANTITIES[condition].unit}"
        for condition, value in value_by_condition.items()
    )


def _interval_text(row: Mapping[str, Any], columns: Sequence[str], digits: int) -> str:
    """A value with its interval."""
    value, lower, upper = (row[column] for column in columns)
    if np.isnan(value):
        return "not known"
    text = f"{value:.{digits}f}"
    if not np.isnan(lower):
        text += f" ({lower:.{digits}f} to {upper:.{digits}f})"
    return text
