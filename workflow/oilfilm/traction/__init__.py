"""Traction laws by name. `oilfilm.traction.laws` lists them."""

from oilfilm.physics.oils import Oil
from oilfilm.physics.rigs import Contact
from oilfilm.traction import laws
from oilfilm.traction.law import Law

# Laws that need nothing but the conditions.
LAWS: dict[str, Law] = {law.name: law for law in vars(laws).values() if isinstance(law, Law)}
# Laws that need the oil's properties and the contact besides.
OF_CONTACT = {"wang-deng-groups": laws.wang_deng_groups}

LAW_NAMES = (*LAWS, *OF_CONTACT)


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
    return LAWS | {name: law(oil, contact) for name, law in OF_CONTACT.items()}
