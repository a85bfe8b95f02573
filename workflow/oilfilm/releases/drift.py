"""The drift gate: which constants and traction changed by more than the configured limits.

Decides: the drift gate: when a refit has moved too far.
"""

from oilfilm import tables
from oilfilm.releases.compare import Comparison, Section
from oilfilm.settings.config import DriftSettings


def drift_table(comparison: Comparison, drift: DriftSettings) -> Section:
    """Every change beyond its limit; no rows where there is none.

    Args:
        comparison: The reference release compared with a newer one.
        drift: `drift` of the configuration.
    """
    errors, limit = drift.standard_errors, drift.traction
    constants, traction = comparison.constants, comparison.traction
    rows = [
        (
            row["oil"],
            row["constant"],
            f"{row['before']:.6g}",
            f"{row['after']:.6g}",
            f"{row['change']:.2f} standard errors",
            f"{errors:g}",
        )
        for row in tables.rows(constants[constants["change"] > errors])
    ]
    too_far = (traction["measure"] == "relative") & (traction["change"] > limit)
    rows += [
        (
            row["oil"],
            "mu",
            f"{row['before']:.5f}",
            f"{row['after']:.5f}",
            f"{100 * row['change']:.3g} % at {row['where']}",
            f"{100 * limit:g} %",
        )
        for row in tables.rows(traction[too_far])
    ]
    columns = ("oil", "what", "A", "B", "change", "limit")
    return Section("Moved by more than the drift gate lets pass", columns, rows)
