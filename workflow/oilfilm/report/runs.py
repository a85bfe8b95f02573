"""The runs of a campaign: their list, what the page of each one tells, and their points."""

from dataclasses import replace
from typing import Any
from urllib.parse import quote

import numpy as np
import pandas as pd

from oilfilm import tables
from oilfilm.fits.interval import normal_quantile
from oilfilm.report.document import sentence
from oilfilm.report.explorer import LEVEL, plain
from oilfilm.report.shown_table import ShownTable, show_declared
from oilfilm.report.words import gate_name
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.torque.operating_grid import AXES
from oilfilm.traction.law import CONDITIONS

_DIGITS = 6  # of a drawn value


def shown_runs(results: CampaignTables, most: int) -> pd.DataFrame:
    """The runs that the page lists, refused ones first."""
    is_accepted = results.runs["verdict"] == "accepted"
    return results.runs.loc[is_accepted.sort_values(kind="stable").index[:most]]


def run_list(results: CampaignTables, most: int) -> ShownTable:
    """One row per run with its conditions and verdict; its name links to its page."""
    runs = shown_runs(results, most)
    of_runs = results.points.groupby("run_id")["accepted"].agg(["sum", "size"])
    counts = of_runs.reindex(runs["run_id"], fill_value=0).astype(int)
    shown = runs.assign(
        passed=[f"{good} of {size}" for good, size in counts.to_numpy()],
        why=runs["rule"],
        warned=np.where(runs["warning"] != "", "yes", ""),
    )
    listed = show_declared(shown.dropna(axis="columns", how="all"), "run-list")
    links = [f"#run?name={quote(name, safe='')}" for name in runs["run_id"]]
    return replace(listed, links=links, left_out=len(results.runs) - len(runs))


def run_pages(results: CampaignTables, most: int) -> list[dict[str, Any]]:
    """What the page of each listed run tells, beside its row in the list.

    Args:
        results: The tables of the campaign.
        most: Runs at most, as in `run_list`.
    """
    runs = shown_runs(results, most)
    means = results.points.groupby("run_id")[list(CONDITIONS)].mean().reindex(runs["run_id"])
    quarantine = results.quarantine
    rules = quarantine["run_id"].map(runs.set_index("run_id")["rule"])
    decisive = quarantine[quarantine["rule"] == rules].drop_duplicates("run_id")
    advice = decisive.set_index("run_id")["advice"]
    return [
        {
            "name": run["run_id"],
            "oil": run["oil"],
            "refused": f"Refused ({gate_name(run['rule'])}): {sentence(run['reason'])} "
            f"{advice.get(run['run_id'], '')}"
            if run["verdict"] != "accepted"
            else "",
            "warning": run["warning"],
            "condition": plain(means.loc[run["run_id"]], _DIGITS),
        }
        for run in tables.rows(runs)
    ]


def drawn_points(points: pd.DataFrame, most: int) -> dict[str, Any]:
    """The points that the page draws, evenly chosen, as columns of numbers.

    Args:
        points: Table of points.
        most: Points at most.
    """
    accepted = int(points["accepted"].sum())
    if len(points) > most:
        points = points.iloc[:: -(-len(points) // most)]
    run, names = pd.factorize(points["run_id"])
    half = normal_quantile(LEVEL) * points["traction_coefficient_se"]
    return {
        "names": names.tolist(),
        "run": run.tolist(),
        "oil": points["oil"].tolist(),
        "axes": [plain(points[name], _DIGITS) for name in AXES],
        "mu": plain(points["traction_coefficient"], _DIGITS),
        "half": plain(half.fillna(0), 2),
        "accepted": points["accepted"].astype(int).tolist(),
        "left_out": accepted - int(points["accepted"].sum()),
    }
