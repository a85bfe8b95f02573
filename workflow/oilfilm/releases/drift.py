"""The drift gate: has a refit moved by more than the configuration lets pass."""

from collections.abc import Mapping
from typing import Any

from oilfilm.releases.compare import Comparison, Section


def moved(comparison: Comparison, drift: Mapping[str, Any]) -> Section:
    """Everything that moved too far; no rows where nothing did.

    Args:
        comparison: Of a release that counts as right with a newer one.
        drift: `drift` of the configuration.
    """
    errors, share = drift["standard_errors"], drift["traction"]
    rows = [
        (
            one.oil,
            one.name,
            f"{one.before:.6g}",
            f"{one.after:.6g}",
            f"{one.change:.2f} standard errors",
            f"{errors:g}",
        )
        for one in comparison.constants
        if one.change > errors
    ]
    rows += [
        (
            one.oil,
            "mu",
            f"{one.relative.before:.5f}",
            f"{one.relative.after:.5f}",
            f"{100 * one.relative.change:.3g} % at {one.relative.where}",
            f"{100 * share:g} %",
        )
        for one in comparison.traction
        if one.relative.change > share
    ]
    columns = ("oil", "what", "A", "B", "change", "limit")
    return Section("Moved by more than the drift gate lets pass", columns, rows)
