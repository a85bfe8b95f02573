"""The reference files of the study: what the paper printed and claimed.

Decides: the paper's claims, and published tests of bearings (in `reference`).
"""

from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field

from oilfilm.settings.base import Group, key
from oilfilm.settings.messages import load
from oilfilm.settings.quantities import LoadN, Name, Share, SpeedRpm, TemperatureC, Text
from simulated_lab.printed import PrintedCoefficients

PowerW = Annotated[float, Field(gt=0, json_schema_extra={"unit": "W"})]


class PaperStatement(Group):
    """What the paper's text says of a lost number."""

    says: Text = key("Value in the unit of the table, or words.")
    where: Text | None = key("Place in the paper.", default=None)


class PaperTables(Group):
    """reference/paper_tables.yaml: what the text says of Tables 1 to 3, by quantity."""

    tab01: dict[str, PaperStatement] = key("Oils.")
    tab02: dict[str, PaperStatement] = key("Test matrix.")
    tab03: dict[str, PaperStatement] = key("Bearing.")


class Claim(Group):
    """A claim of the paper."""

    id: Annotated[str, Field(pattern=r"^[a-z0-9-]+$")] = key("Name of the claim and of its check.")
    section: Text = key("Section of the paper, in quotes where it is a number.")
    claim: Text = key("The claim in short.")
    wording: Text = key("The paper's own words.")
    holds_where: Text = key("What makes the claim hold, read strictly; settings in braces.")
    readings: dict[str, Text] = key("Other fair readings of it, by name.", default={})
    judged_on: Literal["tested", "extrapolated", "data", "formula"] = key(
        "Box on which the verdict rests; `data` where the check looks at tables, `formula` where "
        "it looks at the paper's Eq. 1, and at no box."
    )
    worst: Literal["largest", "smallest"] = key("Which `quantity` is the worst.")
    quantity: Text = key("What is judged in each case, with its format in braces.")
    numbers: dict[str, Text] = key("What the claim's further numbers are.", default={})


class Claims(Group):
    """reference/claims.yaml: the paper's claims."""

    source: Text = key("Author, year, address.")
    claims: Annotated[list[Claim], Field(min_length=1)] = key("Claims in the paper's order.")
    cannot_be_checked: dict[str, Text] = key("Why a claim may not be checked, by code.")


class PublishedRow(Group):
    """What a published test found at one operating point."""

    inner_speed_rpm: SpeedRpm = key("Speed of the inner ring.")
    axial_load_n: LoadN = key("Axial load.")
    power_w: PowerW | None = key("Power loss.", default=None)
    largest_cage_slip: Share | None = key("Largest cage slip of the whole test.", default=None)


class PublishedBearingTest(Group):
    """A published test of one bearing."""

    bearing: Name = key("A file of config/bearings.")
    oil: Name = key("An oil of config/oils.")
    inlet_temperature_c: TemperatureC = key("Oil temperature.")
    source: Text = key("Source of the values.")
    assumed: Text = key("What the source does not give.")
    rows: Annotated[list[PublishedRow], Field(min_length=1)] = key("Operating points.")


class PublishedBearingTests(Group):
    """reference/bearing_tests.yaml: published tests of bearings."""

    tests: Annotated[list[PublishedBearingTest], Field(min_length=1)] = key("The tests.")


_MODELS: dict[str, type[Group]] = {
    "bearing_tests": PublishedBearingTests,
    "claims": Claims,
    "paper_tables": PaperTables,
    "printed_coefficients": PrintedCoefficients,
}


def read_reference(path: Path) -> Group:
    """Content of a reference file, by the model of its name.

    Raises:
        OilfilmError: The file is missing or has a mistake.
    """
    return load(path, _MODELS[path.stem])


def read_claims(path: Path) -> Claims:
    """The claims of the paper.

    Raises:
        OilfilmError: The file is missing or has a mistake.
    """
    return load(path, Claims)
