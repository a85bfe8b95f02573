"""Oils and hashes of the raw logs at the time of the run."""

from collections.abc import Callable, Collection
from dataclasses import dataclass

import pandas as pd


@dataclass(frozen=True)
class Log:
    """Oil and digest of one raw log in a table of runs."""

    oil: str
    sha256: str


def logs_read(
    campaign: str, table: Callable[[str], pd.DataFrame | None], raw: Collection[str]
) -> dict[str, Log]:
    """The logs behind the runs of a campaign, by their paths from the top folder.

    Args:
        campaign: Name of the campaign.
        table: Gives the table of a name, None where there is none.
        raw: Paths of all raw logs.
    """
    logs = {}
    runs, torque_runs = table("runs"), table("torque_runs")
    if runs is not None:
        for row in runs[["file", "oil", "sha256"]].drop_duplicates().to_dict("records"):
            logs[f"data/raw/{campaign}/{row['file']}"] = Log(row["oil"], row["sha256"])
    if torque_runs is not None:
        for row in torque_runs[["run_id", "oil", "sha256"]].drop_duplicates().to_dict("records"):
            path = f"data/raw/{campaign}-torque/{row['run_id']}"
            # the name of a run is that of its log, or file:group
            path = path if path in raw else path.rpartition(":")[0]
            logs[path] = Log(row["oil"], row["sha256"])
    return logs
