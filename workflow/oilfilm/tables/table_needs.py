"""The parts of a campaign that a table needs; read by the Snakefile without importing pandas.

Decides: which tables a campaign does not have.
"""

from itertools import chain

from oilfilm.base import studies
from oilfilm.settings.campaign import Campaign

# Tables by the parts that a campaign must have for them, beside its traction logs.
NEEDS: dict[tuple[str, ...], tuple[str, ...]] = {
    ("torque",): (
        "torque_runs",
        "torque_quarantine",
        "torque",
        "torque_control",
        "torque_inversion",
        "cage_slip",
        "cage_slip_by_temperature",
        "bearing_answers",
        "variance_shares",
        "heat_balance",
        "size_effect",
        "test_plan",
    )
}
for study in studies.available():
    for parts, names in studies.tables_by_need(study).items():
        NEEDS[study, *parts] = names
# Tables that one fit writes: one fit per oil and law.
FIT_TABLES = (
    "coefficients",
    "fit_quality",
    "refits",
    "correlations",
    "profiles",
    "curve_residuals",
    "law_points",
)
# Tables of the surface of one oil.
SURFACE_TABLES = ("surfaces", "surface_sizes", "surface_constants")
# Tables that some campaigns do not have.
NOT_IN_EVERY_CAMPAIGN = tuple(chain.from_iterable(NEEDS.values()))


def lacking(campaign: Campaign) -> frozenset[str]:
    """Names of the tables that a campaign does not have."""
    parts = set(campaign.studies)
    if campaign.torque is not None:
        parts.add("torque")
    if campaign.twin is not None:
        parts.add("twin")
    missing: set[str] = set()
    for needed_parts, names in NEEDS.items():
        if not parts.issuperset(needed_parts):
            missing.update(names)
    return frozenset(missing)
