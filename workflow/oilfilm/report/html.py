"""The report as one HTML page that needs no network.

Decides: how verdicts look, and which pictures and files a page has room for.
"""

import base64
import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined, Template
from markupsafe import Markup

from oilfilm import tables
from oilfilm.base.figure_catalogue import figures
from oilfilm.report import captions
from oilfilm.report.bearing_explorer import bearing_explorer_data
from oilfilm.report.document import Section, meaning_by_word
from oilfilm.report.explorer import explorer_data, law_script
from oilfilm.report.names import unchanged_text_pattern, with_print_symbols
from oilfilm.report.release_id import UNRELEASED
from oilfilm.report.sections.build import drawn_points
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.traction import LAWS
from oilfilm.traction.typeset import mathml

_FOLDER = Path(__file__).parent
# The look of each verdict, by how good it is. A cell may have more words behind its verdict.
_LOOK_BY_VERDICT = {
    "known": "good",
    "holds": "good",
    "yes": "good",
    "best": "good",
    "tie": "good",
    "not shown": "good",
    "accepted": "good",
    "certified": "good",
    "sound": "good",
    "ties": "good",
    "sign unknown": "fair",
    "in step": "fair",
    "no interval": "fair",
    "no other law": "fair",
    "no other fit": "fair",
    "constants left open": "fair",
    "holds in part": "fair",
    "criteria disagree": "fair",
    "too few curves": "fair",
    "no surface": "fair",
    "no repeats": "fair",
    "shown": "fair",
    "at a bound": "bad",
    "not identifiable": "bad",
    "fails": "bad",
    "another law is better": "bad",
    "refused": "bad",
    "not certified": "bad",
    "no fit": "bad",
    "no": "bad",
    "not sound": "bad",
    "worse": "bad",
}
# Columns with names that users give, by table.
_COLUMNS_OF_NAMES = {
    "runs": ["run_id", "file", "oil", "rig"],
    "quarantine": ["run_id", "file", "oil"],
    "torque_runs": ["run_id", "file", "oil", "bearing"],
    "torque_quarantine": ["run_id", "file", "oil"],
}
# Most bytes that the tag of a picture takes in the page.
_LARGEST_TAG = 200


@dataclass(frozen=True)
class Picture:
    """A picture of the page.

    Attributes:
        png: The picture.
        file: Its path below the campaign's results. The page shows the path where the picture has
            no room.
        title: Its title.
        caption: Its caption.
    """

    png: Path
    file: str
    title: str
    caption: str


def html_report(
    sections: Sequence[Section],
    results: CampaignTables,
    pngs: Sequence[Path],
    refused_folder: Path,
    settings: Settings,
    provenance: Mapping[str, Any],
) -> str:
    """The text of report.html: sections, explorer, figures and signals of refused runs.

    Args:
        sections: Sections of the campaign's report.
        results: The tables of the campaign.
        pngs: The figures by name, in the order in which they are shown.
        refused_folder: Folder of the pages of refused runs, which the table `refused_pages` names.
        settings: All settings of the campaign.
        provenance: Of the job that writes the report.

    Returns:
        HTML. The same arguments give the same text.
    """
    pictures_by_category = _pictures_by_category(pngs)
    signal_pictures = _signal_pictures(results, refused_folder)
    page_data = explorer_data(results, settings)
    page_data["points"] = drawn_points(results, settings.report.points_max)
    page_data["bearing"] = bearing_explorer_data(results, settings)
    context = {
        "sections": sections,
        "as_written": unchanged_text_pattern(_names_of_users(results, settings)),
        "glossary": meaning_by_word(sections).items(),
        "settings": settings,
        "provenance": provenance,
        "origin": captions.data_origin(settings.campaign),
        "unreleased": UNRELEASED,
        "style": _asset("page.css"),
        "equations": [
            (Markup(mathml(LAWS[name])), LAWS[name].source)  # noqa: S704  (our own text)
            for name in dict.fromkeys(results.configured_fits.coefficients["law"])
        ],
        "gallery": pictures_by_category,
        "signals": signal_pictures,
        "data": page_data,
        "scripts": [
            Markup(law_script(LAWS.values())),  # noqa: S704  (our own text)
            _asset("page.js"),
            _asset("bearing.js"),
        ],
    }
    page_without_pictures = _template().render(context, embedded={})
    room_bytes = settings.report.size_max_mb * 1e6 - len(page_without_pictures.encode())
    pictures = [
        picture
        for pictures_of_category in pictures_by_category.values()
        for picture in pictures_of_category
    ]
    return _template().render(context, embedded=_data_urls(pictures + signal_pictures, room_bytes))


def _names_of_users(results: CampaignTables, settings: Settings) -> set[str]:
    """Names of the campaign, of logs, runs, oils, rigs and bearings."""
    names = {settings.campaign.name, *settings.oils, *settings.rigs, *settings.bearings}
    for table_name, columns in _COLUMNS_OF_NAMES.items():
        names.update(results.table(table_name, columns).to_numpy().ravel())
    return names


def _pictures_by_category(pngs: Sequence[Path]) -> dict[str, list[Picture]]:
    """The figures by category."""
    pictures_by_category: dict[str, list[Picture]] = {}
    for png in pngs:
        figure = figures()[png.stem]
        picture = Picture(png, f"figures/{png.name}", figure.full_title, figure.caption)
        pictures_by_category.setdefault(figure.category, []).append(picture)
    return pictures_by_category


def _signal_pictures(results: CampaignTables, refused_folder: Path) -> list[Picture]:
    """The pages of refused runs.

    Args:
        results: Table `refused_pages`.
        refused_folder: Folder of the pages.
    """
    return [
        Picture(
            png=refused_folder / row["page"],
            file=f"refused/{row['page']}",
            title=f"Signals of {row['run_id']}",
            caption=f"{row['run_id']}: {row['reason']}",
        )
        for row in tables.rows(results.refused_pages)
        if row["page"]
    ]


def _data_urls(pictures: Sequence[Picture], room_bytes: float) -> dict[str, str]:
    """Data URLs of pictures, by file: of as many as fit into some bytes, the smallest first."""
    base64_of_file = {
        picture.file: base64.b64encode(picture.png.read_bytes()).decode() for picture in pictures
    }
    url_of_file: dict[str, str] = {}
    for file in sorted(base64_of_file, key=lambda file: len(base64_of_file[file])):
        room_bytes -= len(base64_of_file[file]) + _LARGEST_TAG
        if room_bytes > 0:
            url_of_file[file] = f"data:image/png;base64,{base64_of_file[file]}"
    return url_of_file


def _look_of_verdict(text: str) -> str:
    """The look of the verdict in a cell: good, fair or bad; empty for a text without a verdict.

    The longest verdict with which the text begins decides.
    """
    verdicts = [verdict for verdict in _LOOK_BY_VERDICT if f"{text} ".startswith(f"{verdict} ")]
    return _LOOK_BY_VERDICT[max(verdicts, key=len)] if verdicts else ""


def _asset(name: str) -> Markup:
    """Content of a file beside this module, which the page takes as it is."""
    return Markup((_FOLDER / name).read_text(encoding="utf-8"))  # noqa: S704  (our own file)


def _source_hash(script: str) -> str:
    """Hash by which a content security policy allows an inline script."""
    return base64.b64encode(hashlib.sha256(script.encode()).digest()).decode("ascii")


@cache
def _template() -> Template:
    """The page's template."""
    environment = Environment(
        loader=FileSystemLoader(_FOLDER),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.policies["json.dumps_kwargs"] = {"sort_keys": False, "allow_nan": False}
    environment.filters |= {
        "source_hash": _source_hash,
        "with_print_symbols": with_print_symbols,
        "look": _look_of_verdict,
    }
    return environment.get_template("page.html.jinja")
