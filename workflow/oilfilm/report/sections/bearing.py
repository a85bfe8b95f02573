"""What torque logs and the bearing's model come to."""

from typing import Any

import pandas as pd

from oilfilm import tables
from oilfilm.logs.run_sheet import REMARKS
from oilfilm.report.document import Section, facts
from oilfilm.report.sections.data import first_cases, refusals, refused_points
from oilfilm.report.shown_table import ShownTable, show_declared
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.torque.torque_control import bistable_points, without_bistable


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
    listed = refusals(refused, "torque_quarantine", settings.report.rows_max)
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
    return show_declared(errors, "torque")
