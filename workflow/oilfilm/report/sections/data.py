"""What was read, accepted and refused, and why; what torque logs and the bearing come to."""

from dataclasses import replace
from typing import Any
from urllib.parse import quote

import numpy as np
import pandas as pd

from oilfilm import tables
from oilfilm.curation.coverage import planned_states
from oilfilm.fits.interval import normal_quantile
from oilfilm.logs.run_sheet import REMARKS
from oilfilm.report.document import Section, ShownTable, facts, show_table
from oilfilm.report.enough import shortfalls, unread_logs
from oilfilm.report.explorer import LEVEL, plain
from oilfilm.report.words import gate_name
from oilfilm.settings.resolved import Settings
from oilfilm.tables import failed_gates
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.torque.operating_grid import AXES
from oilfilm.torque.torque_control import bistable_points, without_bistable

_STATES = ("accepted", "refused", "missing")


def data(results: CampaignTables, settings: Settings) -> Section:
    """What was read and accepted, which conditions are covered, what is known of the film."""
    points = results.points
    has_matrix = results.coverage["planned"].any()
    conditions = planned_states(results.coverage) if has_matrix else results.coverage
    unjudged = points["accepted"] & (points["film_judgement"] == "cannot be judged")
    made = facts(
        "report/sections/data.jinja",
        results=results,
        settings=settings,
        unread=len(unread_logs(results)),
        shortfalls=shortfalls(results, settings.campaign),
        has_matrix=has_matrix,
        conditions=conditions["state"].value_counts().reindex(_STATES, fill_value=0),
        unjudged=points.loc[unjudged, "oil"],
        stand_ins=[name for name, oil in settings.oils.items() if oil and oil.stand_in],
    )
    return Section("data", "Data", made, [run_list(results, settings.report.rows_max)])


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
    shown = [show_table(counts, "gate_counts"), listed]
    return Section("refused", "Refused", made, shown)


def refusals(quarantine: pd.DataFrame, name: str, most: int, caption: str = "") -> ShownTable:
    """What was refused, why, and what to do; remarks on the run sheet refuse nothing."""
    quarantine = quarantine[~quarantine["rule"].isin(REMARKS)]
    return show_table(quarantine, "quarantine", caption, name, most)


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


def bearing(results: CampaignTables, settings: Settings) -> Section:
    """Logs and plateaus, errors, soundness, what traction decides, heat; empty without logs."""
    runs, refused, torque = results.torque_runs, results.torque_quarantine, results.torque
    if runs.empty and refused.empty:
        return Section("bearing", "Bearing")
    kept = {run_id.rpartition(":")[0] or run_id for run_id in runs["run_id"]}
    # of a refused run no plateau is kept
    read = kept | set(refused.loc[refused["stage"] == "curate", "file"])
    logs = read | set(refused.loc[~refused["rule"].isin(REMARKS), "file"])
    without_torque = runs[runs["accepted"] & ~runs["oil"].isin(torque["oil"])]
    sound = torque[torque["converged"]]
    sure = without_bistable(sound)
    by_stress = sound[sound["load_variable"] == "stress"]
    made = facts(
        "report/sections/bearing.jinja",
        kept=len(kept),
        read=len(read),
        logs=len(logs),
        plateaus=runs,
        limits_gpa=settings.bearing.pressure_limits_gpa,
        refused_plateaus=refused_points(runs),
        cases=first_cases(refused),
        not_calculated=without_torque["oil"].value_counts().to_dict(),
        torque=torque,
        sound=sound,
        plateaus_calculated=len(sound.drop_duplicates(["run_id", "first_row"])),
        bistable=len(sound[sound["bistable"]].drop_duplicates(["run_id", "first_row"])),
        bistable_points=bistable_points(sound),
        why_lost=torque.loc[~torque["converged"], "why"].unique().tolist(),
        has_uncertainty=not len(sound) or (sure["verdict"] != "not known").any(),
        control=_control(results.torque_control),
        by_stress=by_stress,
        inversion=results.torque_inversion["verdict"].tolist(),
        **_heat(results.heat_balance),
    )
    caption = "Refused torque logs, runs and plateaus"
    listed = refusals(refused, "torque_quarantine", settings.report.rows_max, caption)
    return Section("bearing", "Bearing", made, [_error_table(sure), listed])


def _control(control: pd.DataFrame) -> list[dict[str, Any]]:
    """What a comparison with simulated torque shows, by verdict."""
    return [
        {"verdict": verdict, "misfit": rows["law_misfit"].max(), "oils": rows["oil"].tolist()}
        for verdict, rows in control.groupby("verdict", sort=False)
    ]


def _heat(balance: pd.DataFrame) -> dict[str, Any]:
    """What the oil's own heating changes on the map of cage slip."""
    on_map = balance[balance["run_id"] == ""]
    hot = on_map[on_map["balanced"]]
    points = on_map.drop_duplicates(["inner_speed_rpm", "axial_load_n"])
    return {
        "heat_cases": len(on_map),
        "balanced": len(hot),
        "outlet": hot["outlet_temperature_c"],
        # + 0.0 takes the minus sign from a rounded zero
        "change": (hot["heated_torque_n_m"] / hot["torque_n_m"] - 1).round(2) + 0.0,
        "other_best_oil": (points["best_oil"] != points["heated_best_oil"]).sum(),
        "map_points": len(points),
    }


def _error_table(sure: pd.DataFrame) -> ShownTable:
    """How far the calculated torque is from the measured one, by oil and load variable."""
    known = sure.dropna(subset=["relative_error"])
    known = known.assign(
        size=known["relative_error"].abs(),
        share=known["traction_torque_n_m"] / known["torque_n_m"],
        agrees=known["verdict"] == "compatible",
        is_judged=known["verdict"] != "not known",
    )
    errors = known.groupby(["oil", "load_variable"], sort=False, as_index=False).agg(
        points=("size", "size"),
        median=("size", "median"),
        largest=("size", "max"),
        agrees=("agrees", "sum"),
        judged=("is_judged", "sum"),
        share=("share", "median"),
    )
    errors["agreeing"] = [
        f"{row['agrees']} of {row['judged']}" if row["judged"] else "not known"
        for row in tables.rows(errors)
    ]
    return show_table(errors, "torque")


_DIGITS = 6  # of a drawn value


def run_list(results: CampaignTables, most: int) -> ShownTable:
    """One row per run with its conditions and verdict, refused ones first.

    Its name leads to its operating point in the chart, or to its signals.
    """
    runs = results.runs.assign(refused=results.runs["verdict"] != "accepted")
    runs = runs.sort_values("refused", ascending=False, kind="stable")
    of_runs = results.points.groupby("run_id")["accepted"].agg(["sum", "size"])
    counts = of_runs.reindex(runs["run_id"], fill_value=0).astype(int)
    passed = [f"{good} of {size}" for good, size in counts.to_numpy()]
    shown = runs.assign(passed=passed, why=runs["rule"]).dropna(axis="columns", how="all")
    listed = show_table(shown, "run-list", most=most)
    pages = results.refused_pages.query("page != ''").set_index("run_id")["page"]
    anchors = "refused-" + pages.str.removesuffix(".png")
    links = [f"#{anchors.get(name, f'run?name={quote(name)}')}" for name in runs["run_id"]]
    return replace(listed, links=links[:most])


def drawn_points(points: pd.DataFrame, most: int) -> dict[str, Any]:
    """The accepted points that the page draws, evenly chosen, as columns of numbers.

    Args:
        points: Table of points.
        most: Points at most.
    """
    accepted = points[points["accepted"]]
    points = accepted.iloc[:: max(-(-len(accepted) // most), 1)]
    run, names = pd.factorize(points["run_id"])
    half = normal_quantile(LEVEL) * points["traction_coefficient_se"]
    return {
        "names": names.tolist(),
        "run": run.tolist(),
        "oil": points["oil"].tolist(),
        "axes": [plain(points[name], _DIGITS) for name in AXES],
        "mu": plain(points["traction_coefficient"], _DIGITS),
        "half": plain(half.fillna(0), 2),
        "left_out": len(accepted) - len(points),
    }
