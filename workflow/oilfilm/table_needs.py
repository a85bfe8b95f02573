"""Which part of a campaign a table needs; the Snakefile asks without importing pandas.

Decides: which tables a campaign does not have.
"""

from oilfilm import studies
from oilfilm.settings.campaign import Campaign

# By what a campaign must have, beside its traction logs.
NEEDS: dict[tuple[str, ...], tuple[str, ...]] = {
    ("torque",): (
        *("torque_runs", "torque_quarantine", "torque", "torque_control", "torque_inversion"),
        *("cage_slip", "heat_balance", "size_effect", "test_plan"),
    )
}
for study in studies.available():
    for needs, names in studies.table_needs(study).items():
        NEEDS[study, *needs] = names
# What one fit writes: one fit per oil and law.
OF_FIT = (
    *("coefficients", "fit_quality", "refits", "correlations", "profiles", "curve_residuals"),
    "law_points",
)
# Tables that some campaigns do not have.
NOT_IN_EVERY_CAMPAIGN = tuple(name for names in NEEDS.values() for name in names)


def lacking(campaign: Campaign) -> frozenset[str]:
    """Names of the tables that a campaign does not have."""
    parts = {"torque": campaign.torque, "twin": campaign.twin}
    has = {*campaign.studies, *(name for name, part in parts.items() if part is not None)}
    missing = (names for needs, names in NEEDS.items() if not has.issuperset(needs))
    return frozenset(name for names in missing for name in names)
