"""The campaign in a few lines: data, fit, best law, noise, certainty, trouble, paper.

Decides: the verdict of a campaign at the top of the report.
"""

import pandas as pd

from oilfilm import tables
from oilfilm.report.bearing_sentences import control_sentences
from oilfilm.report.captions import credit
from oilfilm.report.enough import shortfalls
from oilfilm.report.facts import (
    accepted_points,
    accepted_runs,
    circular,
    condition_counts,
    counted,
    film_unjudged_oils,
    noise_sentences,
    refused_files,
    stand_in_oils,
    unread_logs,
)
from oilfilm.report.fit_verdicts import law_advice, law_head, noise_advice
from oilfilm.report.labels import gate_name, in_words
from oilfilm.report.shown_table import percent
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.torque.torque_control import without_bistable

_TWO = percent(2)


def verdict(
    results: CampaignTables, sure: pd.DataFrame, settings: Settings
) -> list[tuple[str, str]]:
    """A few lines, each with its subject; `sure` is that of `sections.certainty`.

    The paper has a line where the campaign has oils that it tested.
    """
    lines = [
        ("Data", _data(results, settings)),
        ("Fit", _fit(results.configured.fit_quality)),
        ("Law", _law(results.law_verdicts, results.fit_quality)),
        ("Noise", _noise(results.lack_of_fit)),
        ("Error", _error(results.configured.coefficients, sure)),
        ("Trouble", _trouble(results, settings)),
    ]
    if len(results.claims):
        lines.append(("Paper", _paper(results, settings)))
    elif torque := _torque(results):
        lines.append(("Bearing", " ".join(torque)))
    return [(subject, in_words(sentence)) for subject, sentence in lines]


def _data(results: CampaignTables, settings: Settings) -> str:
    campaign = settings.campaign
    source = f"Measured{credit(campaign)}"
    if campaign.data == "simulated":
        by = f" ({campaign.simulator})" if campaign.simulator else ""
        source = f"SIMULATED data{by}, not a measurement"
    sentence = (
        f"{source}: {accepted_runs(results)} runs and {accepted_points(results)} points accepted"
    )
    if not results.coverage["planned"].any():
        return f"{sentence}; no test matrix is given."
    counts = condition_counts(results)
    covered = f"{counts['accepted']} of {sum(counts.values())} planned conditions covered"
    if counts["refused"]:
        covered += f", {counts['refused']} measured and refused"
    if counts["missing"]:
        # what a log that cannot be read was to cover, nobody knows
        covered += f", {counts['missing']} without a run that could be read"
    return f"{sentence}; {covered}."


def _fit(quality: pd.DataFrame) -> str:
    fitted = quality.dropna(subset=["rmse"])
    if fitted.empty:
        return "Nothing could be fitted."
    rows = [f"{_TWO(row['relative_rms'])} for {row['oil']}" for row in tables.rows(fitted)]
    proven = int(fitted["certified"].sum())
    certified = "every fit is" if proven == len(fitted) else f"{proven} of {len(fitted)} fits are"
    lost = quality.loc[quality["rmse"].isna(), "oil"]
    return (
        f"The rms misfit of {', '.join(fitted['law'].unique())}, relative to mu, is "
        f"{', '.join(rows)}; {certified} certified: no other constants of this law fit better"
        + (f"; not fitted: {', '.join(lost)}." if len(lost) else ".")
    )


def _law(verdicts: pd.DataFrame, quality: pd.DataFrame) -> str:
    """The verdict on the configured law of each oil, and what to do; the numbers are in a table."""
    sentences = [
        " ".join(
            f"{text}."
            for text in (f"{row['oil']}: {law_head(row, quality)}", law_advice(row, quality))
            if text
        )
        for row in tables.rows(verdicts)
    ]
    return " ".join(sentences) or "No law was compared."


def _noise(misfits: pd.DataFrame) -> str:
    """What the laws miss beside the noise, and what to do."""
    advice = dict.fromkeys(filter(None, map(noise_advice, tables.rows(misfits))))
    advised = [f"{each}." for each in advice]
    return " ".join([*noise_sentences(misfits), *advised]) or "Nothing is known of the noise."


def _error(coefficients: pd.DataFrame, sure: pd.DataFrame) -> str:
    intervals = [
        f"\N{PLUS-MINUS SIGN}{_TWO(median)} for {oil} (at worst {_TWO(largest)})"
        for oil, median, largest in sure.dropna().itertuples()
    ]
    fitted = coefficients.groupby("oil")["value"].transform("count") > 0
    if not fitted.any():
        return "Without a fit nothing is known."
    coefficients = coefficients[fitted]
    sentence = "No fit has honest errors: too few curves"
    if intervals:
        known_to = "With 95 % confidence mu of the fitted curves is known to"
        sentence = f"{known_to} {', '.join(intervals)}"
    given = coefficients[coefficients["value"].notna()]
    sentence += f". {(given['verdict'] == 'known').sum()} of {len(coefficients)} constants known"
    for state, words in (
        ("sign unknown", "Sign unknown (zero is in the joint interval)"),
        ("at a bound", "At a bound"),
        ("in step", "Exponents along the tested line, of no condition alone"),
    ):
        rows = given[given["verdict"] == state]
        if len(rows):
            sentence += f". {words}: {', '.join(rows['oil'] + ' ' + rows['constant'])}"
    lost = (~coefficients["identifiable"]).sum()
    return sentence + (f"; {lost} not identifiable." if lost else ".")


def _counts(rules: "pd.Series[str]") -> str:
    """Gates in words, the most frequent first, with their number where it is above one."""
    return ", ".join(
        gate_name(str(gate)) + (f" {count}" if count > 1 else "")
        for gate, count in rules.value_counts().items()
    )


def _trouble(results: CampaignTables, settings: Settings) -> str:
    rules = results.runs.loc[results.runs["verdict"] == "refused", "rule"]
    residuals = results.configured.curve_residuals
    pulling = residuals.loc[residuals["odd"], "oil"].unique()
    stand_ins = stand_in_oils(settings.oils)
    without_run = results.quarantine[results.quarantine["file"].isin(unread_logs(results))]
    reasons = without_run.drop_duplicates("file")["rule"]
    points = (~results.points["accepted"]).sum()
    torque_logs = len(refused_files(results.torque_quarantine))
    unjudged, lacking = film_unjudged_oils(results.points), shortfalls(results, settings.campaign)
    troubles = {
        f"TOO FEW ACCEPTED RUNS ({'; '.join(lacking)})": len(lacking),
        f"{counted(len(rules), 'run')} refused ({_counts(rules)})": len(rules),
        f"{counted(len(reasons), 'log')} without a run ({_counts(reasons)})": len(reasons),
        f"{counted(points, 'point')} refused in all": points,
        f"{counted(torque_logs, 'torque log')} refused in whole or in part": torque_logs,
        f"single curves pull the fit of {', '.join(pulling)}": len(pulling),
        f"film thickness from STAND-IN properties for {', '.join(stand_ins)}": len(stand_ins),
        f"film thickness NOT JUDGED for {', '.join(unjudged)}": len(unjudged),
    }
    sentence = "; ".join(text for text, is_true in troubles.items() if is_true) or "none found"
    return f"{sentence[0].upper()}{sentence[1:]}."


def _paper(results: CampaignTables, settings: Settings) -> str:
    refit = results.claims[results.claims["basis"] == "refit"]
    if refit.empty:
        return "No claim of the paper was checked."
    counts = refit["verdict"].value_counts()
    findings = refit["finding"].str.removeprefix("cannot be checked: ").unique()
    if len(findings) == 1 and set(counts.index) == {"cannot be checked"}:
        return f"No claim of the paper is judged on this campaign's fits: {findings[0]}."
    verdicts = [
        f"{verdict} {counts[verdict]}"
        for verdict in ("holds", "by construction", "holds in part", "fails", "cannot be checked")
        if verdict in counts
    ]
    sentence = f"Verdicts on {len(refit)} claims by this campaign's fits: {', '.join(verdicts)}."
    about = [sentence, *filter(None, [circular(settings.campaign)])]
    return " ".join([*about, *_torque(results)])


def _torque(results: CampaignTables) -> list[str]:
    """How far the calculated torque is from the measured one, or what simulated torque shows."""
    if len(results.torque_control):
        control = control_sentences(results.torque_control)
        return [f"Bearing torque, {sentences}" for sentences in control]
    sure = without_bistable(results.torque)
    by_stress = sure[sure["load_variable"] == "stress"]
    error = by_stress["relative_error"].dropna().abs()
    if error.empty:
        return []
    return [
        f"The torque of the pressure-based law is off by {percent(1)(error.median())} in the "
        f"median, {percent(1)(error.max())} at worst."
    ]
