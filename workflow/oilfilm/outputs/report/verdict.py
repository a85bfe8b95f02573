"""The campaign in five lines: data, fit, certainty, trouble, paper."""

from collections.abc import Mapping

import numpy as np
import pandas as pd

from oilfilm import tables
from oilfilm.outputs.facts import (
    accepted_points,
    accepted_runs,
    condition_counts,
    film_not_judged,
    stand_in_oils,
    unread_logs,
)
from oilfilm.outputs.report.contents import percent
from oilfilm.outputs.report.sections import Certainty
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables

_TWO = percent(2)


def verdict(
    results: CampaignTables, sure: Mapping[str, Certainty], settings: Settings
) -> list[tuple[str, str]]:
    """Five lines, each with its subject."""
    return [
        ("Data", _data(results, settings)),
        ("Fit", _fit(results.fit_quality)),
        ("Error", _error(results.coefficients, sure)),
        ("Trouble", _trouble(results, settings)),
        ("Paper", _paper(results)),
    ]


def _data(results: CampaignTables, settings: Settings) -> str:
    source = (
        "SIMULATED by the rig twin, not a measurement"
        if settings.campaign.data == "simulated"
        else "Measured"
    )
    sentence = (
        f"{source}: {accepted_runs(results)} runs and {accepted_points(results)} points accepted"
    )
    if not results.coverage["planned"].any():
        return f"{sentence}; no test matrix is given."
    counts = condition_counts(results)
    missing = f", {counts['missing']} never measured" if counts["missing"] else ""
    covered = f"{counts['accepted']} of {sum(counts.values())} planned conditions covered"
    return f"{sentence}; {covered}{missing}."


def _fit(quality: pd.DataFrame) -> str:
    fitted = quality.dropna(subset=["rmse"])
    if fitted.empty:
        return "Nothing could be fitted."
    rows = [f"{_TWO(row['relative_rms'])} for {row['oil']}" for row in tables.rows(fitted)]
    proven = int(fitted["certified"].sum())
    certified = "every fit" if proven == len(quality) else f"{proven} of {len(quality)} fits"
    return (
        f"The law {', '.join(fitted['law'].unique())} misses the points by (rms, of mu) "
        f"{', '.join(rows)}; {certified} certified to be the best one."
    )


def _error(coefficients: pd.DataFrame, sure: Mapping[str, Certainty]) -> str:
    known = {oil: one for oil, one in sure.items() if not np.isnan(one.median)}
    intervals = (
        "with 95 % confidence mu of the fitted curves is known to "
        + ", ".join(
            f"\N{PLUS-MINUS SIGN}{_TWO(one.median)} for {oil} (at worst {_TWO(one.largest)})"
            for oil, one in known.items()
        )
        if known
        else "no fit has honest errors: too few curves"
    )
    given = coefficients[coefficients["value"].notna()]
    counts = given["verdict"].value_counts()
    words = f"{intervals}. {counts.get('known', 0)} of {len(coefficients)} constants known"
    for state in ("sign unknown", "at a bound"):
        rows = tables.rows(given[given["verdict"] == state])
        names = [f"{row['oil']} {row['constant']}" for row in rows]
        if names:
            words += f"; {state}: {', '.join(names)}"
    lost = int((~coefficients["identifiable"]).sum())
    if lost:
        words += f"; {lost} not identifiable"
    return words[0].upper() + words[1:] + "."


def _trouble(results: CampaignTables, settings: Settings) -> str:
    refused = results.runs[results.runs["verdict"] == "refused"]
    gates = refused["rule"].value_counts()
    unread = unread_logs(results)
    parts = []
    if len(refused):
        named = ", ".join(
            str(gate).replace("_", " ") + (f" {count}" if count > 1 else "")
            for gate, count in gates.items()
        )
        parts.append(f"{len(refused)} runs refused ({named})")
    if unread:
        parts.append(f"{len(unread)} logs could not be read")
    points = (~results.points["accepted"]).sum()
    if points:
        parts.append(f"{points} points refused in all")
    torque_logs = results.torque_quarantine["file"].nunique()
    if torque_logs:
        parts.append(f"{torque_logs} torque logs refused in whole or in part")
    pulling = results.fit_quality.loc[results.fit_quality["pulling_curves"] != "", "oil"]
    if len(pulling):
        parts.append(f"single curves pull the fit of {', '.join(pulling)}")
    stand_ins = stand_in_oils(settings.oils)
    if stand_ins:
        parts.append(f"film thickness from STAND-IN properties for {', '.join(stand_ins)}")
    if film_not_judged(settings.campaign):
        parts.append("film thickness NOT JUDGED")
    words = "; ".join(parts) or "none found"
    return words[0].upper() + words[1:] + "."


def _paper(results: CampaignTables) -> str:
    refit = results.claims[results.claims["basis"] == "refit"]
    if refit.empty:
        return "No claim of the paper was checked."
    counts = refit["verdict"].value_counts()
    named = [
        f"{counts[verdict]} {verdict}"
        for verdict in ("holds", "holds in part", "fails", "cannot be checked")
        if verdict in counts
    ]
    words = f"Of {len(refit)} claims on this campaign's fits: {', '.join(named)}"
    by_stress = results.torque.loc[
        results.torque["load_variable"] == "stress", "relative_error"
    ].dropna()
    if len(by_stress):
        size = by_stress.abs()
        words += (
            f". Bearing torque by stress is off by {percent(1)(size.median())} in the median, "
            f"{percent(1)(size.max())} at worst"
        )
    return words + "."
