"""The campaign in five lines: data, fit, certainty, trouble, paper."""

import pandas as pd

from oilfilm import tables
from oilfilm.outputs.captions import credit
from oilfilm.outputs.facts import (
    accepted_points,
    accepted_runs,
    condition_counts,
    film_not_judged,
    stand_in_oils,
    unread_logs,
)
from oilfilm.outputs.report.contents import percent
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables

_TWO = percent(2)


def verdict(
    results: CampaignTables, sure: pd.DataFrame, settings: Settings
) -> list[tuple[str, str]]:
    """Five lines, each with its subject; `sure` is that of `sections.certainty`."""
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
        else f"Measured{credit(settings.campaign)}"
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


def _error(coefficients: pd.DataFrame, sure: pd.DataFrame) -> str:
    intervals = [
        f"\N{PLUS-MINUS SIGN}{_TWO(median)} for {oil} (at worst {_TWO(largest)})"
        for oil, median, largest in sure.dropna().itertuples()
    ]
    sentence = "No fit has honest errors: too few curves"
    if intervals:
        known_to = "With 95 % confidence mu of the fitted curves is known to"
        sentence = f"{known_to} {', '.join(intervals)}"
    given = coefficients[coefficients["value"].notna()]
    sentence += f". {(given['verdict'] == 'known').sum()} of {len(coefficients)} constants known"
    for state in ("sign unknown", "at a bound"):
        rows = given[given["verdict"] == state]
        if len(rows):
            sentence += f"; {state}: {', '.join(rows['oil'] + ' ' + rows['constant'])}"
    lost = (~coefficients["identifiable"]).sum()
    return sentence + (f"; {lost} not identifiable." if lost else ".")


def _trouble(results: CampaignTables, settings: Settings) -> str:
    rules = results.runs.loc[results.runs["verdict"] == "refused", "rule"]
    gates = ", ".join(
        str(gate).replace("_", " ") + (f" {count}" if count > 1 else "")
        for gate, count in rules.value_counts().items()
    )
    pulling = results.fit_quality.loc[results.fit_quality["pulling_curves"] != "", "oil"]
    stand_ins = stand_in_oils(settings.oils)
    unread, points = len(unread_logs(results)), (~results.points["accepted"]).sum()
    torque_logs = results.torque_quarantine["file"].nunique()
    troubles = {
        f"{len(rules)} runs refused ({gates})": len(rules),
        f"{unread} logs could not be read": unread,
        f"{points} points refused in all": points,
        f"{torque_logs} torque logs refused in whole or in part": torque_logs,
        f"single curves pull the fit of {', '.join(pulling)}": len(pulling),
        f"film thickness from STAND-IN properties for {', '.join(stand_ins)}": len(stand_ins),
        "film thickness NOT JUDGED": film_not_judged(settings.campaign),
    }
    sentence = "; ".join(text for text, is_true in troubles.items() if is_true) or "none found"
    return f"{sentence[0].upper()}{sentence[1:]}."


def _paper(results: CampaignTables) -> str:
    refit = results.claims[results.claims["basis"] == "refit"]
    if refit.empty:
        return "No claim of the paper was checked."
    counts = refit["verdict"].value_counts()
    verdicts = [
        f"{counts[verdict]} {verdict}"
        for verdict in ("holds", "holds in part", "fails", "cannot be checked")
        if verdict in counts
    ]
    sentence = f"Of {len(refit)} claims on this campaign's fits: {', '.join(verdicts)}."
    by_stress = results.torque[results.torque["load_variable"] == "stress"]
    error = by_stress["relative_error"].dropna().abs()
    if error.empty:
        return sentence
    return (
        f"{sentence} Bearing torque by stress is off by {percent(1)(error.median())} in the "
        f"median, {percent(1)(error.max())} at worst."
    )
