"""The command `oilfilm compare`: fits of several oils or campaigns side by side.

Decides: how a comparison of fits is shown.
"""

import argparse
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from oilfilm.cli.arguments import campaign_folder, json_text, quantity, typed_conditions
from oilfilm.errors import OilfilmError
from oilfilm.fits.fitted import SLIP, FittedLaw, read_fit
from oilfilm.fits.side_by_side import middle_of_tested, side_by_side
from oilfilm.report.figures import style
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.text_table import text_table
from oilfilm.traction.law import QUANTITIES

_SLIPS = (0.01, 0.03, 0.05, 0.1, 0.2)
_DRAWN = 100  # slips of a drawn curve


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    fits, constants, sources = read_fits(options.folders, options.oil)
    at = middle_of_tested(fits, typed_conditions(options))
    tested = min(float(fit.coefficients.box[-1, 1]) for fit in fits.values())
    slips = [quantity(slip, "dimensionless", "--slip") for slip in options.slip or ()]
    slips = slips or [slip for slip in _SLIPS if slip <= tested] or [tested]
    table = side_by_side(fits, at, slips)
    if options.json:
        print(json_text({"at": at, "sources": sources, "points": table.to_dict("records")}))
    else:
        print("\n".join(_lines(table, constants, at, sources, fits)))
    if options.plot:
        curves = side_by_side(fits, at, np.linspace(0, tested, _DRAWN + 1)[1:])
        _draw(curves, at, sources).savefig(options.plot)
        if not options.json:
            print(f"Written: {options.plot}")
    return 0


def read_fits(
    folders: Sequence[Path], oils: Sequence[str] | None
) -> tuple[dict[str, FittedLaw], dict[str, pd.DataFrame], dict[str, str]]:
    """The configured fits in folders of results: law, constants and source of each, by one name.

    The name is the shortest that tells them apart: oil, campaign, or both.

    Raises:
        OilfilmError: There are fewer than two fits.
    """
    found = []
    for given in folders:
        folder, about = campaign_folder(given, None)
        coefficients = CampaignTables.in_folder(folder).configured.coefficients
        of_oil = dict(list(coefficients.groupby("oil", sort=False)))
        chosen = [oil for oil in of_oil if oils is None or oil in oils]
        found += [
            (folder, about, oil, of_oil[oil])
            for oil in chosen
            if of_oil[oil]["value"].notna().any()
        ]
    names = [
        [oil for _, _, oil, _ in found],
        [about["campaign"] for _, about, _, _ in found],
        [f"{about['campaign']} {oil}" for _, about, oil, _ in found],
        [f"{folder} {oil}" for folder, _, oil, _ in found],
    ]
    labels = next((each for each in names if len({*each}) == len(found)), [])
    if len(found) < 2 or not labels:
        raise OilfilmError(
            f"{', '.join(map(str, folders))}: found {len({*names[-1]})} fitted oils; expected at "
            "least two. Name another folder of results, or leave out --oil."
        )
    fits = {label: read_fit(each[0], each[2]) for label, each in zip(labels, found, strict=True)}
    sources = {
        label: f"{fits[label].law.name}, from campaign {about['campaign']}, {about['data']} data"
        for label, (_, about, _, _) in zip(labels, found, strict=True)
    }
    return fits, {label: each[3] for label, each in zip(labels, found, strict=True)}, sources


def _lines(
    table: pd.DataFrame,
    constants: Mapping[str, pd.DataFrame],
    at: Mapping[str, float],
    sources: Mapping[str, str],
    fits: Mapping[str, FittedLaw],
) -> list[str]:
    first, *others = fits
    lines = [f"{label}: {source}" for label, source in sources.items()]
    lines += [f"{label} is NOT SOUND: {why}" for label, fit in fits.items() for why in fit.wrong]
    lines += ["", f"mu with the interval of the next good run, at {_where(at)}"]
    by_slip = {slip: rows.set_index("fit") for slip, rows in table.groupby(SLIP, sort=False)}
    mu = ("traction_coefficient", "obs_ci_lower", "obs_ci_upper")
    rows = [["S", *fits]]
    rows += [
        [f"{slip:g}", *(_cell(of.loc[name], mu, 5) for name in fits)]
        for slip, of in by_slip.items()
    ]
    lines += text_table(rows, right=len(fits))
    ratio = ("ratio", "ratio_lower", "ratio_upper")
    lines += ["", f"Ratio to {first}"]
    rows = [["S", *others]]
    rows += [
        [f"{slip:g}", *(_cell(of.loc[name], ratio, 3) for name in others)]
        for slip, of in by_slip.items()
    ]
    lines += text_table(rows, right=len(others))
    if table["outside"].any():
        lines.append("!: outside the tested conditions of that fit")
    if table["over_limit"].any():
        lines.append("IMPOSSIBLE: above the limiting shear stress, which no film carries")
    names = list(dict.fromkeys(name for of in constants.values() for name in of["constant"]))
    rows = [["constant", *fits]]
    for name in names:
        cells = [of.set_index("constant").reindex([name]).iloc[0] for of in constants.values()]
        rows.append([name, *(_constant(cell) for cell in cells)])
    return [*lines, "", "Constants with their 95 % intervals", *text_table(rows, right=len(fits))]


def _draw(curves: pd.DataFrame, at: Mapping[str, float], sources: Mapping[str, str]) -> Figure:
    """mu over slip of each fit with its interval; beside it the ratios to the first fit."""
    figure = Figure(figsize=(style.DOUBLE_COLUMN_IN, 2.9), layout="constrained")
    left, right = figure.subplots(1, 2)
    names = list(sources)
    for name, of_fit in curves.groupby("fit", sort=False):
        colour, slip = style.oil_colour(str(name), names), of_fit[SLIP]
        left.plot(slip, of_fit["traction_coefficient"], color=colour, label=name)
        left.fill_between(
            slip,
            of_fit["obs_ci_lower"],
            of_fit["obs_ci_upper"],
            color=colour,
            alpha=0.2,
            linewidth=0,
        )
        if name != names[0]:
            right.plot(slip, of_fit["ratio"], color=colour, label=name)
            right.fill_between(
                slip,
                of_fit["ratio_lower"],
                of_fit["ratio_upper"],
                color=colour,
                alpha=0.2,
                linewidth=0,
            )
    right.axhline(1, color=style.GREY, linewidth=0.6)
    for axis, label in ((left, style.TRACTION_LABEL), (right, f"Ratio to {names[0]}")):
        axis.set(xlabel=style.CONDITION_LABELS[SLIP], ylabel=label)
        axis.legend()
    simulated = "SIMULATED data. " * any("simulated" in source for source in sources.values())
    figure.suptitle(f"{simulated}{_where(at)}", fontsize=8)
    return figure


def _where(at: Mapping[str, float]) -> str:
    return ", ".join(
        f"{QUANTITIES[name].symbol} = {value:.4g} {QUANTITIES[name].unit}"
        for name, value in at.items()
    )


def _cell(row: "pd.Series[float]", names: Sequence[str], digits: int) -> str:
    value, low, high = (row[name] for name in names)
    if np.isnan(value):
        return "not known"
    interval = "" if np.isnan(low) else f" ({low:.{digits}f} to {high:.{digits}f})"
    mark = " IMPOSSIBLE" if row["over_limit"] else " !" if row["outside"] else ""
    return f"{value:.{digits}f}{interval}{mark}"


def _constant(row: "pd.Series[float]") -> str:
    if np.isnan(row["value"]):
        return "-"
    interval = "" if np.isnan(row["lower"]) else f" ({row['lower']:.4g} to {row['upper']:.4g})"
    return f"{row['value']:.5g}{interval}"
