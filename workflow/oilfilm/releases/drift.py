"""The drift gate: which constants and traction changed by more than the configured limits."""

from oilfilm.releases.compare import Comparison, Section
from oilfilm.settings.config import DriftSettings


def drift_table(comparison: Comparison, drift: DriftSettings) -> Section:
    """Every change beyond its limit; no rows where there is none.

    Args:
        comparison: The reference release compared with a newer constant.
        drift: `drift` of the configuration.
    """
    errors, limit = drift.standard_errors, drift.traction
    rows = [
        (
            constant.oil,
            constant.name,
            f"{constant.before:.6g}",
            f"{constant.after:.6g}",
            f"{constant.change:.2f} standard errors",
            f"{errors:g}",
        )
        for constant in comparison.constants
        if constant.change > errors
    ]
    rows += [
        (
            traction.oil,
            "mu",
            f"{traction.relative.before:.5f}",
            f"{traction.relative.after:.5f}",
            f"{100 * traction.relative.change:.3g} % at {traction.relative.where}",
            f"{100 * limit:g} %",
        )
        for traction in comparison.traction
        if traction.relative.change > limit
    ]
    columns = ("oil", "what", "A", "B", "change", "limit")
    return Section("Moved by more than the drift gate lets pass", columns, rows)
