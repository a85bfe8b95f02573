"""Traction laws: each is one module; adding one touches its module and this list."""

from oilfilm.physics.oils import Oil
from oilfilm.physics.rigs import Contact
from oilfilm.traction.carreau import Carreau
from oilfilm.traction.deng2026 import Deng2026
from oilfilm.traction.eyring import Eyring
from oilfilm.traction.law import Law
from oilfilm.traction.saturating import Saturating
from oilfilm.traction.wang_deng import WangDengCriticalLoad, WangDengGroups, WangDengLoad

# Laws that need nothing but the conditions.
LAWS: dict[str, Law] = {
    law.name: law
    for law in (
        Deng2026(),
        WangDengLoad(),
        WangDengCriticalLoad(),
        Eyring(),
        Carreau(),
        Saturating(),
    )
}
# Laws that need the oil's properties and the contact besides.
_OF_CONTACT: tuple[type[WangDengGroups], ...] = (WangDengGroups,)

LAW_NAMES = (*LAWS, *(law.name for law in _OF_CONTACT))


def laws_for(oil: Oil | None, contact: Contact | None) -> dict[str, Law]:
    """Every law that can be had for an oil in a contact, by name.

    Args:
        oil: None where its properties are not known.
        contact: None where its geometry and materials are not known, or not all the same.

    Returns:
        LAWS, and those that need both where both are known.
    """
    if oil is None or contact is None:
        return LAWS
    return LAWS | {law.name: law(oil, contact) for law in _OF_CONTACT}
