"""The gates that a plateau failed: the column `failed_gates` of `points` and of `torque_runs`.

The names are one text, so that any program can read the column. Only this module joins and splits
them.

Decides: how the failed gates of a plateau are stored.
"""

from collections.abc import Iterable

import pandas as pd

COLUMN = "failed_gates"
_BETWEEN = ";"


def as_text(failed: pd.DataFrame) -> "pd.Series[str]":
    """The names of the failed gates of each plateau; empty where it passed them all.

    Args:
        failed: One boolean column per gate, one row per plateau.
    """
    refused = failed[failed.any(axis=1)]
    names = [_BETWEEN.join(failed.columns[row]) for row in refused.to_numpy()]
    return pd.Series(names, refused.index, dtype=str).reindex(failed.index, fill_value="")


def with_gate_of_run(points: pd.DataFrame, gate_of_run: dict[str, str]) -> pd.DataFrame:
    """Plateaus with the gate that refused their run, if one did, before their own gates.

    Args:
        points: With `run_id` and `failed_gates`.
        gate_of_run: Gate by run.
    """
    gates = pd.Series(gate_of_run, dtype=str).reindex(points["run_id"], fill_value="")
    names = (gates.set_axis(points.index) + _BETWEEN + points[COLUMN]).str.strip(_BETWEEN)
    return points.assign(failed_gates=names, accepted=names == "")


def one_row_per_gate(points: pd.DataFrame) -> pd.DataFrame:
    """The refused plateaus, each once for every gate that it failed, which is in `rule`."""
    refused = points[points[COLUMN] != ""]
    return refused.assign(rule=refused[COLUMN].str.split(_BETWEEN)).explode("rule")


def counts(points: pd.DataFrame) -> "pd.Series[int]":
    """How many plateaus each gate refused, the largest number first."""
    return one_row_per_gate(points)["rule"].value_counts()


def failed_any(points: pd.DataFrame, gates: Iterable[str]) -> "pd.Series[bool]":
    """Whether each plateau failed at least one of these gates."""
    wanted = set(gates)
    split = points[COLUMN].str.split(_BETWEEN)
    return split.map(lambda names: not wanted.isdisjoint(names)).astype(bool)


def failed_none_but(points: pd.DataFrame, gate: str) -> "pd.Series[bool]":
    """Whether each plateau passed every gate other than this one."""
    return points[COLUMN].isin(["", gate])
