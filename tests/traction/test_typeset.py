"""Equations as mathematics: each symbol has one meaning, and numbers are written as in print."""

import re
import xml.etree.ElementTree as ET

import pytest

from oilfilm.traction import ALL_LAWS
from oilfilm.traction.typeset import mathml

BY_NAME = {law.name: law for law in ALL_LAWS}


def formulas(law_name: str) -> ET.Element:
    return ET.fromstring(f"<div>{mathml(BY_NAME[law_name])}</div>")


def test_euler_number_differs_from_a_part_that_is_called_e() -> None:
    # m = -L (e^(-e/L) - 1): the base is Euler's number, the e in its exponent is a part of the law
    (power,) = [
        element
        for element in formulas("eyring").iter("msup")
        if element.find("mrow/mfrac") is not None and element[0].tag == "mi"
    ]
    base, exponent = power
    assert (base.text, base.get("mathvariant")) == ("e", "normal")
    part = exponent.find("mfrac/mrow/mi")
    assert part is not None
    assert (part.text, part.get("mathvariant")) == ("e", None)


@pytest.mark.parametrize("law_name", BY_NAME)
def test_no_number_is_written_as_a_program_writes_it(law_name: str) -> None:
    texts = [element.text or "" for element in formulas(law_name).iter()]
    assert not [text for text in texts if re.search(r"\de[-+]?\d", text)]
