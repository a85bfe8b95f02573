"""The reference files of the study: what the paper printed and claimed.

Our copy of the paper has lost the numbers of its Tables 1 to 3 and the signs of its constants.

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


# A `Group` is a pydantic model: it declares the keys of a group in a YAML file.
class PaperStatement(Group):
    """What the paper's text says of a number that its table has lost."""

    says: Text = key("Value in the unit of the table, or words.")
    where: Text | None = key("Section, figure or abstract that says it.", default=None)


class PaperTables(Group):
    """reference/paper_tables.yaml: what the text says of Tables 1 to 3, by quantity."""

    tab01: dict[str, PaperStatement] = key("Oils.")
    tab02: dict[str, PaperStatement] = key("Test matrix.")
    tab03: dict[str, PaperStatement] = key("Bearing.")


class Claim(Group):
    """A claim of the paper. Its check judges it in each case: an oil at an operating condition.

    `quantity` is a text with the format of one number. `numbers` gives the meaning of each further
    number by its name, not the numbers themselves. The check calculates the numbers.
    """

    id: Annotated[str, Field(pattern=r"^[a-z0-9-]+$")] = key("Name of the claim and of its check.")
    section: Text = key("Section of the paper; YAML needs quotes where it is a number.")
    claim: Text = key("The claim in short.")
    wording: Text = key("The paper's own words.")
    holds_where: Text = key(
        "Test by which the claim holds in a case, as a sentence. Names of settings in braces are "
        "replaced by their values."
    )
    without_doubtful: bool = key(
        "Whether the claim is judged again without oils whose printed constants may be damaged.",
        default=True,
    )
    readings: dict[str, Text] = key("Other fair readings of the claim, by name.", default={})
    caveat: Text | None = key("What the verdict cannot show.", default=None)
    judged_on: Literal["tested", "extrapolated", "data", "formula"] = key(
        "Box of operating conditions that is judged. Without a box: `data` for tables of the "
        "campaign, `formula` for a formula with numbers that the paper states."
    )
    worst: Literal["largest", "smallest"] = key(
        "Whether the case with the largest or the smallest `quantity` is farthest from holding."
    )
    quantity: Text = key("Number that is judged in each case, with its format in braces.")
    numbers: dict[str, Text] = key(
        "Meaning of the further numbers that the check returns, by name. A number without a format "
        "in braces is a share.",
        default={},
    )


class Claims(Group):
    """reference/claims.yaml: the paper's claims."""

    source: Text = key("Author, year, address.")
    claims: Annotated[list[Claim], Field(min_length=1)] = key("Claims in the paper's order.")
    cannot_be_checked: dict[str, Text] = key(
        "Reasons why a claim cannot be checked, by `reason_code` of the table `claims`."
    )


class PublishedRow(Group):
    """What a published test found at one operating point."""

    inner_speed_rpm: SpeedRpm = key("Speed of the inner ring.")
    axial_load_n: LoadN = key("Axial load.")
    power_w: PowerW | None = key("Power loss.", default=None)
    largest_cage_slip: Share | None = key(
        "Largest cage slip of the test, at whichever of its loads; the same in each of its rows.",
        default=None,
    )


class PublishedBearingTest(Group):
    """A published test of one bearing."""

    bearing: Name = key("A file of config/bearings.")
    oil: Name = key("An oil of config/oils.")
    inlet_temperature_c: TemperatureC = key("Oil temperature.")
    source: Text = key("Source of the values.")
    assumed: Text = key("What the calculation assumes because the source does not state it.")
    rows: Annotated[list[PublishedRow], Field(min_length=1)] = key("Operating points.")


class PublishedBearingTests(Group):
    """reference/bearing_tests.yaml: published tests of bearings."""

    tests: Annotated[list[PublishedBearingTest], Field(min_length=1)] = key("The tests.")


_MODEL_BY_FILE: dict[str, type[Group]] = {
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
    return load(path, _MODEL_BY_FILE[path.stem])


def read_claims(path: Path) -> Claims:
    """The claims of the paper.

    Raises:
        OilfilmError: The file is missing or has a mistake.
    """
    return load(path, Claims)
