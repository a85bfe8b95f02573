"""What was read, accepted and refused, and why."""

import numpy as np
import pandas as pd

from oilfilm import tables
from oilfilm.curation.coverage import describe_condition, planned_states
from oilfilm.logs.run_sheet import REMARKS
from oilfilm.report import runs
from oilfilm.report.document import Section, facts
from oilfilm.report.enough import shortfalls, unread_logs
from oilfilm.report.shown_table import ShownTable, show_declared
from oilfilm.report.words import gate_name
from oilfilm.settings.resolved import Settings
from oilfilm.tables import failed_gates
from oilfilm.tables.campaign_tables import CampaignTables

# Missing conditions that are named; the table coverage has them all.
_NAMED = 3
_STATES = ("accepted", "refused", "missing")
_SET_POINTS = {
    "nominal_load_n": "load",
    "nominal_entrainment_speed_m_s": "speed",
    "nominal_inlet_temperature_c": "temperature",
}


def data(results: CampaignTables, settings: Settings) -> Section:
    """What was read and accepted, which conditions are covered, what is known of the film."""
    points = results.points
    has_matrix = results.coverage["planned"].any()
    conditions = planned_states(results.coverage) if has_matrix else results.coverage
    missing = tables.rows(conditions[conditions["state"] == "missing"])
    without = results.runs[list(_SET_POINTS)].isna().sum().rename(_SET_POINTS)
    unjudged = points["accepted"] & (points["film_judgement"] == "cannot be judged")
    made = facts(
        "report/sections/data.jinja",
        results=results,
        settings=settings,
        unread=len(unread_logs(results)),
        shortfalls=shortfalls(results, settings.campaign),
        has_matrix=has_matrix,
        conditions=conditions["state"].value_counts().reindex(_STATES, fill_value=0),
        missing=[f"{row['oil']} at {describe_condition(row)}" for row in missing[:_NAMED]],
        more_missing=max(len(missing) - _NAMED, 0),
        unjudged=points.loc[unjudged, "oil"],
        stand_ins=[name for name, oil in settings.oils.items() if oil and oil.stand_in],
        without_set_point=without[without > 0].to_dict(),
    )
    return Section("data", "Data", made, [runs.run_list(results, settings.report.rows_max)])


def refused(results: CampaignTables, settings: Settings) -> Section:
    """Everything that was refused, the first case of each gate in words."""
    counts = results.gate_counts
    counts = counts[~counts["gate"].isin(REMARKS)]
    made = facts(
        "report/sections/refused.jinja",
        verdicts=_named(results.runs.query("verdict == 'refused'")["rule"].value_counts()),
        unread=_named(_of_unread_logs(results).value_counts()),
        points=(~results.points["accepted"]).sum(),
        cases=first_cases(results.quarantine),
        other_gates=counts[~counts["gate"].isin(results.quarantine["rule"])].to_dict("records"),
    )
    listed = refusals(results.quarantine, "quarantine", settings.report.rows_max)
    shown = [show_declared(counts, "gate_counts"), listed]
    saved = {"quarantine.csv": results.quarantine}
    return Section("refused", "Refused", made, shown, downloads=saved)


def refusals(quarantine: pd.DataFrame, name: str, most: int) -> ShownTable:
    """What was refused, why, and what to do, where sentences have only each gate's first case.

    Remarks on the run sheet refuse nothing.
    """
    quarantine = quarantine[~quarantine["rule"].isin(REMARKS)]
    if not quarantine["rule"].duplicated().any():
        quarantine = quarantine[:0]
    if not (quarantine["run_id"] != quarantine["file"]).any():
        quarantine = quarantine.drop(columns="run_id")
    return show_declared(quarantine, "quarantine", name=name, most=most)


def first_cases(quarantine: pd.DataFrame) -> list[dict[str, object]]:
    """The first case of each gate with the number of cases; most cases first."""
    quarantine = quarantine[~quarantine["rule"].isin(REMARKS)]
    sizes = quarantine["rule"].value_counts()
    first = quarantine.drop_duplicates("rule").set_index("rule").loc[sizes.index]
    names = np.where(first["run_id"] != "", first["run_id"], first["file"])
    return tables.rows(
        first.assign(gate=first.index.map(gate_name), name=names, count=sizes).reset_index()
    )


def refused_points(points: pd.DataFrame) -> dict[str, int]:
    """How many points each gate refused, most first."""
    return _named(failed_gates.counts(points))


def _of_unread_logs(results: CampaignTables) -> "pd.Series[str]":
    """The rule that refused each log of which no run could be read."""
    of_logs = results.quarantine[results.quarantine["file"].isin(unread_logs(results))]
    return of_logs.drop_duplicates("file")["rule"]


def _named(counts: "pd.Series[int]") -> dict[str, int]:
    return {gate_name(str(gate)): int(count) for gate, count in counts.items()}
