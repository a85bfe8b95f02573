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
# Keys of groups and indices of lists, from the outermost one to the innermost one.
KeyPath = tuple[Any, ...]


def key_paths_below(value: Any) -> list[KeyPath]:
    """The path to everything in a group or list."""
    if not isinstance(value, dict | list):
        return []
    paths: list[KeyPath] = []
    for key in value if isinstance(value, dict) else range(len(value)):
        paths.append((key,))
        paths += [(key, *path) for path in key_paths_below(value[key])]
    return paths


def alter(values: Any, random: np.random.Generator) -> None:
    """Remove something, wrap it, repeat it, name it anew, or put another value in its place."""
    paths = key_paths_below(values)
    *outer_keys, last_key = paths[int(random.integers(len(paths)))]
    for key in outer_keys:
        values = values[key]
    kind_of_alteration = int(random.integers(7))
    if kind_of_alteration == 0:
        del values[last_key]
    elif kind_of_alteration == 1:
        values[last_key] = {"x": values[last_key]}
    elif kind_of_alteration == 2:
        values[last_key] = [values[last_key], values[last_key]]
    elif kind_of_alteration == 3 and isinstance(values, dict):
        values[str(any_value(random))] = values.pop(last_key)
    else:
        values[last_key] = any_value(random)


def any_value(random: np.random.Generator) -> Any:
    """One of `VALUES`."""
    return VALUES[int(random.integers(len(VALUES)))]
