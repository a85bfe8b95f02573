"""Alterations of what people write by hand, or strangers send: groups and lists of values.

Each alteration changes the form, and not only the bytes.
"""

from typing import Any

import numpy as np

# Values that no key has, or that other keys have.
VALUES = [
    *(None, True, 0, -1, 1.5, 2**70, 1e308, float("nan")),
    *("", "x", "\x1b[31m", "\u202e", "..", "/etc/passwd", "2026-02-30", "1e9", "A" * 100_000),
    *([], {}, [None], [[]], {"x": 1}),
]
Steps = tuple[Any, ...]


def steps_below(value: Any) -> list[Steps]:
    """The steps to everything in a group or list."""
    if not isinstance(value, dict | list):
        return []
    found: list[Steps] = []
    for step in value if isinstance(value, dict) else range(len(value)):
        found.append((step,))
        found += [(step, *below) for below in steps_below(value[step])]
    return found


def alter(values: Any, random: np.random.Generator) -> None:
    """Remove something, wrap it, repeat it, name it anew, or put another value in its place."""
    found = steps_below(values)
    *groups, last = found[int(random.integers(len(found)))]
    for step in groups:
        values = values[step]
    kind = int(random.integers(7))
    if kind == 0:
        del values[last]
    elif kind == 1:
        values[last] = {"x": values[last]}
    elif kind == 2:
        values[last] = [values[last], values[last]]
    elif kind == 3 and isinstance(values, dict):
        values[str(any_value(random))] = values.pop(last)
    else:
        values[last] = any_value(random)


def any_value(random: np.random.Generator) -> Any:
    """One of `VALUES`."""
    return VALUES[int(random.integers(len(VALUES)))]
