"""Traction laws by name. `oilfilm.traction.laws` lists them."""

from pathlib import Path
from types import ModuleType

from oilfilm.physics.contact import Contact
from oilfilm.physics.oils import Oil
from oilfilm.traction import laws
from oilfilm.traction.law import Law

_EVERY_LAW = [law for law in vars(laws).values() if isinstance(law, Law)]
LAW_NAMES = tuple(law.name for law in _EVERY_LAW)
LAW_TITLES = {law.name: law.title or law.name for law in _EVERY_LAW}
# Laws that need only the conditions.
LAWS = {law.name: law for law in _EVERY_LAW if law.of(None, None)}
# The module of each law.
LAW_FILES = {
    law.name: Path(str(module.__file__))
    for module in vars(laws).values()
    if isinstance(module, ModuleType)
    for law in vars(module).values()
    if law in _EVERY_LAW
}
# The law of Deng et al. (2026), whose constants are printed.
PAPER_LAW = laws.DENG2026
# Laws on load that are evaluated in bearings beside the campaign's law.
BEARING_LAW_NAMES = tuple(law.name for law in _EVERY_LAW if law.in_bearings)


def laws_for(oil: Oil | None, contact: Contact | None) -> dict[str, Law]:
    """Every law that can be had for an oil in a contact, by name.

    Args:
        oil: None where its properties are not known.
        contact: None where its geometry and materials are not known, or not all the same.
    """
    return {law.name: known for law in _EVERY_LAW if (known := law.of(oil, contact))}
