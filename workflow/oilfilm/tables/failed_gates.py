"""The gates that a plateau failed: the column `failed_gates` of `points` and of `torque_runs`.

Decides: how the failed gates of a plateau are counted and told.
"""

from collections.abc import Iterable

import pandas as pd

from oilfilm.tables import lists

COLUMN = "failed_gates"
# The gates of a plateau, as a table has them.
Gates = tuple[str, ...]


def names_of(failed: pd.DataFrame) -> "pd.Series[Gates]":  # type: ignore[type-var]
    """The names of the failed gates of each plateau; none where it passed them all.

    Args:
        failed: One boolean column per gate, one row per plateau.
    """
    gates = failed.columns.to_numpy(dtype=object)
    return lists([tuple(gates[row]) for row in failed.to_numpy(dtype=bool)], failed.index)


def with_gate_of_run(points: pd.DataFrame, gate_of_run: dict[str, str]) -> pd.DataFrame:
    """Plateaus with the gate that refused their run, if one did, before their own gates.

    Args:
        points: With `run_id` and `failed_gates`.
        gate_of_run: Gate by run.
    """
    names: list[Gates] = []
    for run_id, own_gates in zip(points["run_id"], points[COLUMN], strict=True):
        gate = gate_of_run.get(run_id, "")
        names.append((gate, *own_gates) if gate else own_gates)
    points = points.assign(failed_gates=lists(names, points.index))
    return points.assign(accepted=passed_all(points))


def passed_all(points: pd.DataFrame) -> "pd.Series[bool]":
    """Whether each plateau passed every gate."""
    return ~points[COLUMN].astype(bool)


def one_row_per_gate(points: pd.DataFrame) -> pd.DataFrame:
    """The refused plateaus, each once for every gate that it failed, which is in `rule`."""
    refused = points[~passed_all(points)]
    return refused.assign(rule=refused[COLUMN]).explode("rule")


def counts(points: pd.DataFrame) -> "pd.Series[int]":
    """How many plateaus each gate refused, the largest number first."""
    return one_row_per_gate(points)["rule"].value_counts()


def failed_any(points: pd.DataFrame, gates: Iterable[str]) -> "pd.Series[bool]":
    """Whether each plateau failed at least one of these gates."""
    wanted = set(gates)
    return points[COLUMN].map(lambda names: not wanted.isdisjoint(names)).astype(bool)


def failed_none_but(points: pd.DataFrame, gate: str) -> "pd.Series[bool]":
    """Whether each plateau passed every gate other than this one."""
    return points[COLUMN].map(lambda names: set(names) <= {gate}).astype(bool)
