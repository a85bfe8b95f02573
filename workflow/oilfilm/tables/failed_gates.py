"""The gates that a plateau failed: the column `failed_gates` of `points` and of `torque_runs`.

Decides: how the failed gates of a plateau are counted and told.
"""

from collections.abc import Iterable

import pandas as pd

from oilfilm.tables import list_column

# Name of the column.
COLUMN = "failed_gates"
# The gates of a plateau, as a table has them.
GateNames = tuple[str, ...]


def gate_name_lists(has_failed: pd.DataFrame) -> "pd.Series[GateNames]":  # type: ignore[type-var]
    """The names of the failed gates of each plateau; none where it passed them all.

    Args:
        has_failed: One boolean column per gate, one row per plateau.
    """
    gate_names = has_failed.columns.to_numpy(dtype=object)
    return list_column(
        [tuple(gate_names[has_failed_row]) for has_failed_row in has_failed.to_numpy(dtype=bool)],
        has_failed.index,
    )


def with_gate_of_run(points: pd.DataFrame, gate_of_run: dict[str, str]) -> pd.DataFrame:
    """Plateaus with the gate that refused their run, if one did, before their own gates.

    Args:
        points: With `run_id` and `failed_gates`.
        gate_of_run: Gate by run.
    """
    names_of_plateaus: list[GateNames] = []
    for run_id, own_names in zip(points["run_id"], points[COLUMN], strict=True):
        gate_name = gate_of_run.get(run_id, "")
        names_of_plateaus.append((gate_name, *own_names) if gate_name else own_names)
    points = points.assign(failed_gates=list_column(names_of_plateaus, points.index))
    return points.assign(accepted=passed_all(points))


def passed_all(points: pd.DataFrame) -> "pd.Series[bool]":
    """Whether each plateau passed every gate."""
    return ~points[COLUMN].astype(bool)


def one_row_per_gate(points: pd.DataFrame) -> pd.DataFrame:
    """The refused plateaus, each once for every gate that it failed, which is in `rule`."""
    refused = points[~passed_all(points)]
    return refused.assign(rule=refused[COLUMN]).explode("rule")


def refusal_counts(points: pd.DataFrame) -> "pd.Series[int]":
    """How many plateaus each gate refused, the largest number first."""
    return one_row_per_gate(points)["rule"].value_counts()


def failed_any_of(points: pd.DataFrame, gate_names: Iterable[str]) -> "pd.Series[bool]":
    """Whether each plateau failed at least one of these gates."""
    gate_name_set = set(gate_names)
    return (
        points[COLUMN]
        .map(lambda failed_names: not gate_name_set.isdisjoint(failed_names))
        .astype(bool)
    )


def passed_all_but(points: pd.DataFrame, gate_name: str) -> "pd.Series[bool]":
    """Whether each plateau passed every gate other than this one."""
    return points[COLUMN].map(lambda failed_names: set(failed_names) <= {gate_name}).astype(bool)
