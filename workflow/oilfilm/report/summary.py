"""The short summary that a run ends with, as plain text in headed sections.

Decides: the sections of the summary on the terminal.
"""

from collections.abc import Mapping

import pandas as pd

from oilfilm import tables
from oilfilm.curation.coverage import describe_condition, planned_states
from oilfilm.paper.sentences import claim_lines, printed_lines
from oilfilm.report.bearing_sentences import bearing_lines
from oilfilm.report.enough import shortfalls
from oilfilm.report.facts import (
    accepted_points,
    accepted_runs,
    condition_counts,
    counted,
    film_unjudged_oils,
    stand_in_oils,
    unread_logs,
)
from oilfilm.report.fit_sentences import constant_lines, fit_lines, law_lines
from oilfilm.report.labels import gate_name
from oilfilm.report.meanings import meanings
from oilfilm.report.plain_text import listed, section, sentence, text_table
from oilfilm.report.refused_sentences import refused_lines
from oilfilm.settings.campaign import Campaign
from oilfilm.settings.config import FilmSettings
from oilfilm.settings.oil import OilFile
from oilfilm.settings.resolved import Settings
from oilfilm.tables import failed_gates
from oilfilm.tables.campaign_tables import CampaignTables

# Missing conditions that are named; the table coverage has them all.
_NAMED = 3
# Lines of a summary that a run prints at its end.
_LINES_MAX = 75
_WORDS, _PLACES = "Words", "Where to find what"


def summarise(results: CampaignTables, settings: Settings) -> str:
    """What was made, how good each fit is and where to look, as text.

    Args:
        results: The campaign's tables.
        settings: Settings `campaign`, `oils`, `film` and `gates`.
    """
    campaign = settings.campaign
    source = ", ".join(filter(None, ["MEASURED", campaign.credit]))
    if campaign.data == "simulated":
        source = ", ".join(filter(None, ["SIMULATED data", campaign.simulator]))
    has_torque_logs = len(results.torque_runs) + len(results.torque_quarantine) > 0
    lines = [
        sentence(f"Campaign {campaign.name} ({source}): {campaign.description}"),
        "",
        *section("Data", _data(results, settings)),
        *_refused(results),
        *fit_lines(results),
        *law_lines(results),
        *constant_lines(results),
        *printed_lines(results, campaign),
        *claim_lines(results.claims, campaign),
        *(bearing_lines(results) if has_torque_logs else []),
    ]
    words = meanings(" ".join(lines))
    lines += section(_WORDS, [f"- {word}: {sentence(meaning)}" for word, meaning in words])
    return "\n".join([*lines, *section(_PLACES, _places(results, campaign.name))]).rstrip() + "\n"


def at_the_end_of_a_run(summary: str, path: str) -> str:
    """A summary as a terminal gets it: without the meanings of words, and not too long.

    Args:
        summary: The whole of it.
        path: The file that has the whole.
    """
    body, heading, places = summary.rstrip().rpartition(f"\n{_PLACES}\n")
    body, words, _ = body.partition(f"\n{_WORDS}\n")
    lines = body.rstrip().split("\n")
    if (left_out := len(lines) - _LINES_MAX) > 0:
        lines = [*lines[:_LINES_MAX], f"... {left_out} more lines: {path}"]
    if words:
        lines.append(f"The meaning of words is in {path}.")
    return "\n".join(lines) + f"\n{heading}{places}"


def _places(results: CampaignTables, name: str) -> list[str]:
    folder = f"results/{name}"
    lines = [
        f"Report:  {folder}/report.html (open it in a browser; it needs no network)",
        f"Tables:  {folder}/tables (start with quarantine.csv)",
        f"Figures: {folder}/figures",
        f"Exports: {folder}/exports (the fits for bearing codes; start with README.md)",
    ]
    if (results.quarantine["stage"] == "curate").any():
        lines.append(f"Refused: {folder}/refused (one picture per run; index.parquet lists them)")
    return lines


def _data(results: CampaignTables, settings: Settings) -> list[str]:
    """What was read and accepted, and what is known of the film."""
    campaign = settings.campaign
    read, unread = set(results.runs["file"]), unread_logs(results)
    return [
        f"- Logs: {len(read)} of {len(read | unread)} have runs.",
        f"- Runs: {accepted_runs(results)} are accepted.",
        *(f"- NOT ENOUGH: {sentence(lacking)}" for lacking in shortfalls(results, campaign)),
        f"- Points: {accepted_points(results)} are accepted.",
        f"- Samples: {results.runs['samples'].sum()} rows. Refused rows, unreadable or no part of "
        f"a sweep: {results.quarantine['refused_rows'].sum()}.",
        *_covered(results),
        *_unjudged(results.points, campaign),
        *_stand_ins(settings.oils),
        *_film(settings.film, settings.gates.lambda_limit),
        *_without_set_points(results.runs),
    ]


def _covered(results: CampaignTables) -> list[str]:
    """Coverage of the matrix, or of the tested conditions where the campaign has no matrix."""
    counts, coverage = condition_counts(results), results.coverage
    of_all = f"{counts['accepted']} of {sum(counts.values())}"
    if not coverage["planned"].any():
        return [
            f"- Tested conditions: {of_all} are accepted. "
            "The campaign has no test matrix, so that no condition can be missing."
        ]
    line = (
        f"- Conditions of the test matrix: {of_all} are accepted. Refused: {counts['refused']}. "
        f"Missing: {counts['missing'] or 'none'}{_may_be_unread(counts, results)}."
    )
    outside = (~coverage["planned"]).sum()
    if outside:
        line += f" Tested outside the matrix: {outside}."
    conditions = planned_states(coverage)
    missing = tables.rows(conditions[conditions["state"] == "missing"])
    lines = [f"  - Missing: {row['oil']} at {describe_condition(row)}." for row in missing[:_NAMED]]
    if len(missing) > _NAMED:
        lines.append(f"  - Missing: {len(missing) - _NAMED} more (coverage.parquet).")
    return [line, *lines]


def _may_be_unread(counts: Mapping[str, int], results: CampaignTables) -> str:
    unread = len(unread_logs(results))
    return f" ({counted(unread, 'log')} without a run)" if unread and counts["missing"] else ""


def _unjudged(points: pd.DataFrame, campaign: Campaign) -> list[str]:
    unjudged = points["accepted"] & (points["film_judgement"] == "cannot be judged")
    if not unjudged.any():
        return []
    reason = campaign.film_unjudged.reason if campaign.film_unjudged else ""
    oils = ", ".join(film_unjudged_oils(points))
    why = f" {sentence(reason)}" if reason else ""
    return [f"- FILM NOT JUDGED for {unjudged.sum()} accepted points of {oils}.{why}"]


def _stand_ins(oils: Mapping[str, OilFile | None]) -> list[str]:
    names = stand_in_oils(oils)
    if not names:
        return []
    return [f"- Film thickness: STAND-IN properties are used for {', '.join(names)} (config/oils)."]


def _film(film: FilmSettings, limit: float) -> list[str]:
    heat = "with" if film.thermal_reduction else "without"
    return [
        f"- Lambda: {film.thickness} film thickness {heat} thermal reduction, over the combined "
        f"roughness {film.roughness.capitalize()}. Above {limit:g} the film is a full film."
    ]


def _without_set_points(runs: pd.DataFrame) -> list[str]:
    labels = {
        "nominal_load_n": "load",
        "nominal_entrainment_speed_m_s": "speed",
        "nominal_inlet_temperature_c": "temperature",
    }
    missing = runs[list(labels)].isna().sum().rename(labels)
    missing = missing[missing > 0]
    if missing.empty:
        return []
    return [f"- Runs without a set point, which are not compared with one: {listed(missing)}."]


def _refused(results: CampaignTables) -> list[str]:
    """What was refused and why, with what to do."""
    gates = failed_gates.counts(results.points)
    lines = refused_lines(results.quarantine, "quarantine")
    by_gate = [[gate_name(str(gate)), str(count)] for gate, count in gates.items()]
    nothing = [] if lines or by_gate else ["Nothing was refused."]
    return section("Refused", lines, text_table(["gate", "refused points"], by_gate), nothing)
