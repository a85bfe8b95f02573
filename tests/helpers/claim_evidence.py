"""Planted constants and the evidence made of them, for the audit of claims and the selection."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from oilfilm.paper.audit.audit import printed_evidence
from oilfilm.paper.audit.evidence import Evidence
from oilfilm.settings.resolved import Settings

OILS = ("4102", "4050", "4010")
# |A|, its exponents; B, its exponents; C, its exponents: falls with U and T, rises with P
PLAIN = [-0.02, 1.0, -0.5, -0.5, 0.5, 1.0, -0.5, -0.5, 30.0, 0.0, 0.0, 0.0]


def evidence_of(
    constants: Mapping[str, Sequence[float]], config: Settings, **changes: Any
) -> Evidence:
    rows = {oil: np.array(values) for oil, values in constants.items()}
    return replace(printed_evidence(rows, OILS, config), **changes)


def planted(size: float = 1.0, **changes: float) -> list[float]:
    """The plain constants with A0 and B0 times `size`, and others changed by name."""
    names = [f"{letter}{number}" for letter in "ABC" for number in range(4)]
    values = dict(zip(names, PLAIN, strict=True))
    values |= {"A0": values["A0"] * size, "B0": values["B0"] * size} | changes
    return list(values.values())
