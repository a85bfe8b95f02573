"""All exports of a campaign, as the contents of files.

Decides: which forms of exports there are.
"""

import html
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

from oilfilm import studies
from oilfilm.exports.data_files import adore_csv, adore_obstacle, csv_table, json_text
from oilfilm.exports.description import Description, describe
from oilfilm.exports.languages import FORTRAN, MATLAB, MODELICA, PYTHON, C
from oilfilm.exports.names import identifiers, plain
from oilfilm.exports.workbook import workbook
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.traction import LAWS


class _Form(NamedTuple):
    """One form: its file, whom it is for, how it is used, and what writes it."""

    file: str
    users: str
    use: str
    write: Callable[[Description], str | bytes]


# These need all coefficients of the law.
FORMS = {
    "Python": _Form("traction_*.py", "Python", "import it; needs NumPy; arrays too", PYTHON.source),
    "spreadsheet": _Form("traction_*.xlsx", "Excel, LibreOffice", "type P, U, T and S", workbook),
    "C": _Form("traction_*.h", "C99, C++11", "include it; needs libm (`-lm`) only", C.source),
    "Fortran": _Form("traction_*.f90", "Fortran 2008", "compile it; arrays too", FORTRAN.source),
    "Modelica": _Form("Traction_*.mo", "Modelica", "load it; Pa, m/s, K", MODELICA.source),
    "MATLAB, Octave": _Form(
        "traction_coefficient_*.m", "MATLAB, GNU Octave", "put it on the path", MATLAB.source
    ),
    "ADORE": _Form("adore_*.csv", "ADORE", "A to D of (A + B u) exp(-C u) + D", adore_csv),
}
_INDEX = """\
# Traction coefficients for bearing codes

{origins}

| oil | folder | mu depends on | certificate |
| --- | --- | --- | --- |
{oils}
{below}
| file | for | how |
| --- | --- | --- |
{forms}
| `traction_*.json`, `.csv` | everything else | constants with errors and verdicts; tested box |

The functions take the slide-roll ratio S with either sign, mu(-S) = -mu(S), and say whether a point
lies outside the tested box, where mu is extrapolated. The names of the arguments carry the units.
The head of each file has the law, its source, where its constants come from, the tested box and the
certificate.
"""


def export_campaign(
    results: CampaignTables, settings: Settings, provenance: Mapping[str, Any]
) -> dict[str, bytes]:
    """Every oil's fit in every form, and what the campaign's studies export beside them.

    Args:
        results: Tables `points`, `coefficients`, `fit_quality` and `soundness`.
        settings: `campaign`, `fit`, `exports` and `printed` of them.
        provenance: Digests of code, settings and inputs.

    Returns:
        File, relative to the folder of the exports -> its content. A form that cannot be
        written is named in the JSON file, with the reason.
    """
    law, quality = LAWS[settings.fit.law], results.fit_quality
    names = identifiers(quality.loc[quality["law"] == law.name, "oil"])
    fits = [describe(results, oil, name, law, settings) for oil, name in names.items()]
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
    files = {"README.md": _index(descriptions, below).encode()}
    for each in descriptions:
        contents = export(each, provenance).items()
        files |= {f"{each.identifier}/{file}": content for file, content in contents}
    return files


def export(fit: Description, provenance: Mapping[str, Any]) -> dict[str, bytes]:
    """One oil's constants in every form: file -> its content."""
    name = fit.identifier
    files, not_written = {"CSV": f"traction_{name}.csv"}, {}
    texts: dict[str, str | bytes] = {files["CSV"]: csv_table(fit)}
    for name_of_form, form in FORMS.items():
        obstacle = fit.obstacle or (adore_obstacle(fit) if name_of_form == "ADORE" else "")
        if obstacle:
            not_written[name_of_form] = obstacle
        else:
            files[name_of_form] = form.file.replace("*", name)
            texts[files[name_of_form]] = form.write(fit)
    texts[f"traction_{name}.json"] = json_text(fit, files, not_written, provenance)
    return {
        file: text if isinstance(text, bytes) else text.encode() for file, text in texts.items()
    }


def _index(fits: Sequence[Description], below: str) -> str:
    """The page that says which file is for whom, in Markdown."""
    origins = dict.fromkeys(f"- {html.escape(fit.origin, quote=False)}." for fit in fits)
    forms = [f"| `{each.file}` | {each.users} | {each.use} |" for each in FORMS.values()]
    rows = []
    for fit in fits:
        symbols = ", ".join([*(condition.symbol for condition in fit.arguments), "S"])
        where = fit.where_known and f"; {fit.where_known}"
        depends = "unknown" if fit.obstacle else symbols + where
        cells = (plain(fit.oil), f"`{fit.identifier}/`", depends, fit.certificate)
        rows.append(f"| {' | '.join(html.escape(cell, quote=False) for cell in cells)} |")
    parts = {"origins": origins, "oils": rows, "forms": forms}
    return _INDEX.format(**{name: "\n".join(each) for name, each in parts.items()}, below=below)
