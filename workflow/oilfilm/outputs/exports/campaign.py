"""All exports of a campaign, as the texts of files."""

from collections.abc import Callable, Mapping
from typing import Any

import pandas as pd

from oilfilm.outputs.exports.adore import adore_csv
from oilfilm.outputs.exports.c_header import c_header
from oilfilm.outputs.exports.csv_table import csv_table
from oilfilm.outputs.exports.description import Description, describe
from oilfilm.outputs.exports.fortran_module import fortran_module
from oilfilm.outputs.exports.index import index
from oilfilm.outputs.exports.json_text import json_text
from oilfilm.outputs.exports.matlab_function import matlab_function
from oilfilm.outputs.exports.modelica_package import modelica_package
from oilfilm.outputs.exports.names import identifiers

Form = Callable[[Description], str]

# Form -> its file, and what writes it. These need values of A, B and C.
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
        File, relative to the folder of the exports -> its text. A fit that gives no curve is in
        JSON and CSV only, with the reason.
    """
    of_law = quality[quality["law"] == config["fit"]["law"]]
    names = identifiers(of_law["oil"])
    fits = [
        describe(oil, name, points, coefficients, of_law, config) for oil, name in names.items()
    ]
    files = {"README.md": index(fits)}
    for fit in fits:
        files |= {
            f"{fit.identifier}/{file}": text for file, text in export(fit, provenance).items()
        }
    return files


def export(fit: Description, provenance: Mapping[str, Any]) -> dict[str, str]:
    """One oil's fit in every form: file -> its text."""
    name, obstacle = fit.identifier, fit.obstacle
    csv, json = f"traction_{name}.csv", f"traction_{name}.json"
    functions = {} if obstacle else {form: file.format(name) for form, (file, _) in FORMS.items()}
    texts = {file: FORMS[form][1](fit) for form, file in functions.items()}
    texts[csv] = csv_table(fit)
    not_written = dict.fromkeys(FORMS, obstacle) if obstacle else {}
    texts[json] = json_text(fit, {"CSV": csv, **functions}, not_written, provenance)
    return texts
