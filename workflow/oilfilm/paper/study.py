"""What a campaign with `studies: [paper]` has beside tables and figures."""

from collections.abc import Collection, Mapping
from typing import Any

from oilfilm.exports.campaign import in_folders
from oilfilm.home import reference_file
from oilfilm.paper.printed_exports import describe_printed
from oilfilm.paper.sections import sections
from oilfilm.settings.resolved import Settings
from oilfilm.studies import Study

# Beside the folders of fits; no identifier has a hyphen.
_FOLDER = "printed-constants"


def _exports(
    oils: Collection[str], settings: Settings, provenance: Mapping[str, Any]
) -> dict[str, bytes]:
    """The printed constants of these oils, in every form."""
    path, tested = reference_file("printed_coefficients"), settings.printed.boxes.tested
    described = describe_printed(path, tested, settings.exports)
    chosen = [each for each in described if each.oil in oils]
    files = in_folders(chosen, provenance) if chosen else {}
    return {f"{_FOLDER}/{file}": content for file, content in files.items()}


STUDY = Study(
    name="paper",
    exports=_exports,
    sections=sections,
    exported="The constants that the paper prints of these oils: "
    f"[{_FOLDER}]({_FOLDER}/README.md).",
)
