"""All exports of a campaign, as the contents of files.

Decides: which forms of exports there are.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import pandas as pd

from oilfilm import studies
from oilfilm.exports.adore import adore_csv, adore_obstacle
from oilfilm.exports.csv_table import csv_table
from oilfilm.exports.description import Description, describe
from oilfilm.exports.index import index
from oilfilm.exports.json_text import json_text
from oilfilm.exports.languages import FORTRAN, MATLAB, MODELICA, PYTHON, C
from oilfilm.exports.names import identifiers
from oilfilm.exports.workbook import workbook
from oilfilm.settings.resolved import Settings
from oilfilm.traction import LAWS

# Form -> its file, and what writes it. These need all coefficients of the law.
FORMS: dict[str, tuple[str, Callable[[Description], str | bytes]]] = {
    "Python": ("traction_{}.py", PYTHON.source),
    "spreadsheet": ("traction_{}.xlsx", workbook),
    "C": ("traction_{}.h", C.source),
    "Fortran": ("traction_{}.f90", FORTRAN.source),
    "Modelica": ("Traction_{}.mo", MODELICA.source),
    "MATLAB, Octave": ("traction_coefficient_{}.m", MATLAB.source),
    "ADORE": ("adore_{}.csv", adore_csv),
}


def export_campaign(
    points: pd.DataFrame,
    coefficients: pd.DataFrame,
    quality: pd.DataFrame,
    settings: Settings,
    provenance: Mapping[str, Any],
) -> dict[str, bytes]:
    """Every oil's fit in every form, and what the campaign's studies export beside them.

    Args:
        points: Table of points of the campaign, for the level of what did not vary.
        coefficients: Table of coefficients.
        quality: Table of fit quality.
        settings: `campaign`, `fit`, `exports` and `printed` of them.
        provenance: Digests of code, settings and inputs.

    Returns:
        File, relative to the folder of the exports -> its content. A form that cannot be
        written is named in the JSON file, with the reason.
    """
    law = LAWS[settings.fit.law]
    names = identifiers(quality.loc[quality["law"] == law.name, "oil"])
    fits = [
        describe(oil, name, points, coefficients, quality, law, settings)
        for oil, name in names.items()
    ]
    sources = {key: provenance[key] for key in ("code", "settings", "inputs")}
    files: dict[str, bytes] = {}
    links = []
    for study in studies.load(settings.campaign.studies):
        if of_study := study.exports(names, settings, sources):
            files |= of_study
            links.append(f"\n{study.exported}\n")
    return in_folders(fits, sources, "".join(links)) | files


def in_folders(
    descriptions: Sequence[Description], provenance: Mapping[str, Any], below: str = ""
) -> dict[str, bytes]:
    """Several oils in every form, and the page that lists them: file -> its content.

    Args:
        descriptions: One per oil; its files are in a folder of its name.
        provenance: What they were made from, as digests.
        below: A line below the list.
    """
    files = {"README.md": index(descriptions, below).encode()}
    for each in descriptions:
        contents = export(each, provenance).items()
        files |= {f"{each.identifier}/{file}": content for file, content in contents}
    return files


def export(fit: Description, provenance: Mapping[str, Any]) -> dict[str, bytes]:
    """One oil's constants in every form: file -> its content."""
    name = fit.identifier
    files, not_written = {"CSV": f"traction_{name}.csv"}, {}
    texts: dict[str, str | bytes] = {files["CSV"]: csv_table(fit)}
    for form, (file, write) in FORMS.items():
        obstacle = fit.obstacle or (adore_obstacle(fit) if form == "ADORE" else "")
        if obstacle:
            not_written[form] = obstacle
        else:
            files[form] = file.format(name)
            texts[files[form]] = write(fit)
    texts[f"traction_{name}.json"] = json_text(fit, files, not_written, provenance)
    return {
        file: text if isinstance(text, bytes) else text.encode() for file, text in texts.items()
    }
