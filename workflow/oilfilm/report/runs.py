"""The runs of a campaign: their list, and what the page of each one shows."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any
from urllib.parse import quote

import numpy as np
import pandas as pd

from oilfilm import tables
from oilfilm.curation.gate import TRACTION, Gate
from oilfilm.curation.plateau_gates import PLATEAU_GATES
from oilfilm.curation.run_gates import RUN_GATES
from oilfilm.report.shown_table import Column, ShownTable, number, show
from oilfilm.report.words import gate_name
from oilfilm.tables import failed_gates
from oilfilm.tables.campaign_tables import CampaignTables

_SHORT = number(".3g")
_DIGITS = 4  # of a drawn value
_CONDITIONS = {
    "max_hertz_pressure_gpa": "Maximum Hertz pressure P (GPa)",
    "entrainment_speed_m_s": "Entrainment speed U (m/s)",
    "inlet_temperature_c": "Inlet temperature T (\N{DEGREE SIGN}C)",
}
_FACTS = (
    *("Oil", "Rig", "Log", *_CONDITIONS.values()),
    "Smallest film thickness over roughness \N{GREEK SMALL LETTER LAMDA}",
    *("Readings", "Plateaus accepted"),
)


def listed(results: CampaignTables, rows_max: int, points_max: int) -> pd.DataFrame:
    """The runs that the page has room for, refused ones first.

    Args:
        results: The tables of the campaign.
        rows_max: Runs at most.
        points_max: Points of all these runs together, at most.
    """
    runs = results.runs.assign(is_accepted=results.runs["verdict"] == "accepted")
    runs = runs.sort_values("is_accepted", kind="stable")[:rows_max]
    counts = results.points["run_id"].value_counts()
    points = runs["run_id"].map(counts).fillna(0).cumsum()
    return runs[points <= points_max]


def run_list(results: CampaignTables, runs: pd.DataFrame) -> ShownTable:
    """One row per run with its conditions and verdict; its name links to its page."""
    of_runs = results.points.groupby("run_id")["accepted"].agg(["sum", "size"])
    counts = of_runs.reindex(runs["run_id"], fill_value=0).astype(int)
    texts = [f"{good} of {size}" for good, size in counts.to_numpy()]
    shown = show(
        runs.assign(
            passed=texts,
            why=runs["rule"].map(gate_name),
            warned=runs["warning"] != "",
        ),
        "runs",
        "Runs: conditions and verdict",
        [
            Column("run_id", "Run"),
            Column("oil", "Oil"),
            *_conditions(runs),
            Column("passed", "Plateaus accepted"),
            Column("verdict", "Verdict", is_verdict=True),
            Column("why", "Refused by"),
            Column("warned", "Warning", lambda value: "yes" if value else "", ""),
        ],
        name="run-list",
    )
    links = [f"#run?name={quote(name, safe='')}" for name in runs["run_id"]]
    return replace(shown, links=links, left_out=len(results.runs) - len(runs))


def _conditions(runs: pd.DataFrame) -> list[Column]:
    """Set points that the runs have."""
    columns = [
        Column("nominal_max_hertz_pressure_gpa", "P", _SHORT),
        Column("nominal_load_n", "Load", _SHORT),
        Column("nominal_entrainment_speed_m_s", "U", _SHORT),
        Column("nominal_inlet_temperature_c", "T", _SHORT),
    ]
    return [column for column in columns if runs[column.name].notna().any()]


def _advice(quarantine: pd.DataFrame, runs: pd.DataFrame) -> pd.Series:
    """What to do about each refused run: the advice of the rule that refused it, by run."""
    rule = quarantine["run_id"].map(runs.set_index("run_id")["rule"])
    return (
        quarantine[quarantine["rule"] == rule]
        .drop_duplicates("run_id")
        .set_index("run_id")["advice"]
    )


def run_pages(
    results: CampaignTables, runs: pd.DataFrame, pictures: Mapping[str, str]
) -> dict[str, Any]:
    """What `page.js` draws of each run: its facts, curve and gates.

    Args:
        results: The tables of the campaign.
        runs: Those with a page, as `listed` gives them.
        pictures: Name of the picture of its signals by run, of refused runs.
    """
    advice = _advice(results.quarantine, runs)
    shown = results.points[results.points["run_id"].isin(runs["run_id"])]
    points = dict(list(shown.groupby("run_id", sort=False)))
    none = results.points[:0]
    pages = []
    for run in tables.rows(runs):
        name = run["run_id"]
        own = points.get(name, none)
        pages.append(
            {
                **{key: run[key] for key in ("oil", "verdict", "rule", "reason", "warning")},
                "name": name,
                "advice": str(advice.get(name, "")) if run["verdict"] != "accepted" else "",
                "facts": _facts(run, own),
                "picture": pictures.get(name, ""),
                "condition": _plain(own[list(_CONDITIONS)].mean()),
                "S": _plain(own["slide_roll_ratio"]),
                "mu": _plain(own["traction_coefficient"]),
                "se": _plain(own["traction_coefficient_se"], 2),
                "accepted": "".join(own["accepted"].astype(int).astype(str)),
                "gates": {gate: int(n) for gate, n in failed_gates.counts(own).items()},
            }
        )
    return {"facts": _FACTS, "gates": _gates(results.points), "runs": pages}


def _facts(run: Mapping[str, Any], own: pd.DataFrame) -> list[str]:
    """Values of `_FACTS`."""
    means = [_SHORT(own[name].mean()) for name in _CONDITIONS]
    accepted = f"{own['accepted'].sum()} of {len(own)}"
    least = _SHORT(own["lambda_ratio"].min())
    return [run["oil"], run["rig"], run["file"], *means, least, str(run["samples"]), accepted]


def _gates(points: pd.DataFrame) -> list[str]:
    """All gates of traction logs in the order in which they judge, then others that refused."""
    gates: tuple[Gate[Any], ...] = (*RUN_GATES, *PLATEAU_GATES)
    declared = [gate.name for gate in gates if TRACTION in gate.rigs]
    return list(dict.fromkeys([*declared, *failed_gates.counts(points).index]))


def _plain(values: "pd.Series[float]", digits: int = _DIGITS) -> list[float | None]:
    """Numbers as JSON has them, with the digits that a drawing shows."""
    return [
        float(f"{value:.{digits}g}") if np.isfinite(value) else None
        for value in values.to_numpy(float)
    ]
