"""All exports of a campaign, as the texts of files."""

from collections.abc import Callable, Mapping
from typing import Any

import pandas as pd

from oilfilm.outputs.exports.adore import adore_csv, adore_obstacle
from oilfilm.outputs.exports.c_header import c_header
from oilfilm.outputs.exports.csv_table import csv_table
from oilfilm.outputs.exports.description import Description, describe
from oilfilm.outputs.exports.fortran_module import fortran_module
from oilfilm.outputs.exports.index import index
from oilfilm.outputs.exports.json_text import json_text
from oilfilm.outputs.exports.matlab_function import matlab_function
from oilfilm.outputs.exports.modelica_package import modelica_package
from oilfilm.outputs.exports.names import identifiers
from oilfilm.traction import LAWS

Form = Callable[[Description], str]

# Form -> its file, and what writes it. These need all coefficients of the law.
FORMS: dict[str, tuple[str, Form]] = {
    "C": ("traction_{}.h", c_header),
    "Fortran": ("traction_{}.f90", fortran_module),
    "Modelica": ("Traction_{}.mo", modelica_package),
    "MATLAB, Octave": ("traction_coefficient_{}.m", matlab_function),
    "ADORE": ("adore_{}.csv", adore_csv),
}


def export_campaign(
    points: pd.DataFrame,
    coefficients: pd.DataFrame,
    quality: pd.DataFrame,
    config: Mapping[str, Any],
    provenance: Mapping[str, Any],
) -> dict[str, str]:
    """Every oil's fit in every form.

    Args:
        points: Table of points of the campaign, for the level of what did not vary.
        coefficients: Table of coefficients.
        quality: Table of fit quality.
        config: The resolved configuration.
        provenance: Digests of code, settings and inputs.

    Returns:
        File, relative to the folder of the exports -> its text. A form that cannot be
        written is named in the JSON file, with the reason.
    """
    law = LAWS[config["fit"]["law"]]
    names = identifiers(quality.loc[quality["law"] == law.name, "oil"])
    fits = [
        describe(oil, name, points, coefficients, quality, law, config)
        for oil, name in names.items()
    ]
    files = {"README.md": index(fits)}
    for fit in fits:
        files |= {
            f"{fit.identifier}/{file}": text for file, text in export(fit, provenance).items()
        }
    return files


def export(fit: Description, provenance: Mapping[str, Any]) -> dict[str, str]:
    """One oil's fit in every form: file -> its text."""
    name = fit.identifier
    not_written = {form: why for form in FORMS if (why := _obstacle(fit, form))}
    written = {form: FORMS[form] for form in FORMS if form not in not_written}
    files = {"CSV": f"traction_{name}.csv"}
    files |= {form: file.format(name) for form, (file, _) in written.items()}
    texts = {files[form]: write(fit) for form, (_, write) in written.items()}
    texts[files["CSV"]] = csv_table(fit)
    texts[f"traction_{name}.json"] = json_text(fit, files, not_written, provenance)
    return texts


def _obstacle(fit: Description, form: str) -> str:
    """Why a form cannot be written; empty where it can."""
    return fit.obstacle or (adore_obstacle(fit) if form == "ADORE" else "")
