"""The parts of a campaign that a table needs, for the rules of the workflow.

`FIT_TABLES` and `SURFACE_TABLES` are the tables of one fit and of one surface. What each table
holds is declared in the YAML files of this folder.

Decides: which tables a campaign does not have.
"""

from itertools import chain

from oilfilm.base import studies
from oilfilm.settings.campaign import Campaign

# Names of the tables that need some parts of a campaign beside its traction logs, by these parts.
_TABLE_NAMES_BY_NEED: dict[tuple[str, ...], tuple[str, ...]] = {
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
} | {
    (package_name, *needed_parts): table_names
    for package_name in studies.available()
    for needed_parts, table_names in studies.table_names_by_need(package_name).items()
}
# Names of the tables that one fit writes: one fit per oil and law.
FIT_TABLES = (
    "coefficients",
    "fit_quality",
    "refits",
    "correlations",
    "profiles",
    "curve_residuals",
    "law_points",
)
# Names of the tables that the surface of one oil writes.
SURFACE_TABLES = ("surfaces", "surface_sizes", "surface_constants")
# Names of the tables that some campaigns do not have.
OPTIONAL_TABLES = tuple(chain.from_iterable(_TABLE_NAMES_BY_NEED.values()))


def lacking_table_names(campaign: Campaign) -> frozenset[str]:
    """The names of the tables that a campaign does not have, because it lacks a part they need.

    A part is a study, the torque logs, or the rig twin: the settings that simulate the logs.
    """
    present_parts = set(campaign.studies)
    if campaign.torque is not None:
        present_parts.add("torque")
    if campaign.twin is not None:
        present_parts.add("twin")
    lacking_names: set[str] = set()
    for needed_parts, table_names in _TABLE_NAMES_BY_NEED.items():
        if not present_parts.issuperset(needed_parts):
            lacking_names.update(table_names)
    return frozenset(lacking_names)
