"""Traction laws by name. `oilfilm.traction.laws` lists them."""

from pathlib import Path
from types import ModuleType

from oilfilm.physics.contact import Contact
from oilfilm.physics.oils import Oil
from oilfilm.traction import laws
from oilfilm.traction.law import Law


def _files_of_laws() -> dict[str, Path]:
    """The file of each law, by the law's name."""
    file_of_law = {}
    for module in vars(laws).values():
        if not isinstance(module, ModuleType):
            continue
        for member in vars(module).values():
            if isinstance(member, Law):
                file_of_law[member.name] = Path(str(module.__file__))
    return file_of_law


# Every law, in the order of `laws`. A law that needs properties of the oil or the contact has only
# its equation here; `laws_for` gives it these properties.
ALL_LAWS = [law for law in vars(laws).values() if isinstance(law, Law)]
LAW_NAMES = tuple(law.name for law in ALL_LAWS)
LAW_TITLES = {law.name: law.title or law.name for law in ALL_LAWS}
# The laws that need no properties of the oil or the contact, by name.
LAWS = {law.name: law for law in ALL_LAWS if law.for_oil(None, None) is not None}
# The file of each law.
LAW_FILES = _files_of_laws()
# The law of Deng et al. (2026), whose constants are printed.
PAPER_LAW = laws.DENG2026
# Laws on load that are evaluated in bearings beside the campaign's law.
BEARING_LAW_NAMES = tuple(law.name for law in ALL_LAWS if law.is_evaluated_in_bearings)


def reason_for_comparison_only(law_name: str) -> str:
    """Why a law of `compare.laws` cannot be the configured law of fits; empty where it can.

    Args:
        law_name: Name of a law.
    """
    if law_name in LAWS or law_name not in LAW_NAMES:
        return ""
    return (
        f"the law {law_name!r} needs properties of the oil or the contact, which saved fits and "
        "exports do not carry: it is compared only. Name it in compare.laws"
    )


def laws_for(oil: Oil | None, contact: Contact | None) -> dict[str, Law]:
    """The laws that are available for an oil in a contact, by name.

    Args:
        oil: The oil; None if its properties are not known.
        contact: The contact; None if geometry and materials are not known or not all the same.
    """
    available = {}
    for law in ALL_LAWS:
        law_of_oil = law.for_oil(oil, contact)
        if law_of_oil is not None:
            available[law.name] = law_of_oil
    return available
