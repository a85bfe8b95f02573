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
from oilfilm.report.bearing_explorer import bearing_explorer
from oilfilm.report.document import Section, meanings
from oilfilm.report.explorer import explorer, law_script
from oilfilm.report.names import printed
from oilfilm.report.release_id import UNRELEASED
from oilfilm.report.sections.build import drawn_points
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.traction import LAWS
from oilfilm.traction.typeset import mathml

_FOLDER = Path(__file__).parent
# How good each verdict is. A cell may have more words behind its verdict.
_LOOK_OF_VERDICT = {
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
    "no interval": "fair",
    "holds in part": "fair",
    "criteria disagree": "fair",
    "too few curves": "fair",
    "no repeats": "fair",
    "shown": "fair",
    "at a bound": "bad",
    "not identifiable": "bad",
    "fails": "bad",
    "another law is better": "bad",
    "refused": "bad",
    "not certified": "bad",
    "no": "bad",
    "not sound": "bad",
    "worse": "bad",
}
# Bytes of a picture in the page beside its content: its tag, at most.
_LARGEST_TAG = 200


@dataclass(frozen=True)
class Picture:
    """A picture of the page.

    Attributes:
        png: The picture.
        file: Its path below the campaign's results, which the page shows where it has no room.
        title: Its title.
        caption: Its caption.
    """

    png: Path
    file: str
    title: str
    caption: str


def html(
    sections: Sequence[Section],
    results: CampaignTables,
    pngs: Sequence[Path],
    refused_folder: Path,
    settings: Settings,
    provenance: Mapping[str, Any],
) -> str:
    """The page: the sections, the explorer, the figures and the signals of refused runs.

    Args:
        sections: Sections of the campaign's report.
        results: The tables of the campaign.
        pngs: The figures by name, in the order in which they are shown.
        refused_folder: Folder of the pages of refused runs, which the table `refused_pages` names.
        settings: All settings of the campaign.
        provenance: Of the job that writes the report.

    Returns:
        HTML; the same results give the same text.
    """
    gallery = _gallery(pngs)
    signals = _signals(results, refused_folder)
    data = explorer(results, settings)
    data["points"] = drawn_points(results, settings.report.points_max)
    data["bearing"] = bearing_explorer(results, settings)
    context = {
        "sections": sections,
        "glossary": meanings(sections).items(),
        "settings": settings,
        "provenance": provenance,
        "origin": captions.provenance(settings.campaign),
        "unreleased": UNRELEASED,
        "style": _asset("page.css"),
        "equations": [
            (Markup(mathml(LAWS[name])), LAWS[name].source)  # noqa: S704  (our own text)
            for name in dict.fromkeys(results.configured.coefficients["law"])
        ],
        "gallery": gallery,
        "signals": signals,
        "data": data,
        "scripts": [
            Markup(law_script(LAWS.values())),  # noqa: S704  (our own text)
            _asset("page.js"),
            _asset("bearing.js"),
        ],
    }
    page_without_pictures = _template().render(context, embedded={})
    room_bytes = settings.report.size_max_mb * 1e6 - len(page_without_pictures.encode())
    pictures = [
        picture for pictures_of_category in gallery.values() for picture in pictures_of_category
    ]
    return _template().render(context, embedded=_embedded(pictures + signals, room_bytes))


def _gallery(pngs: Sequence[Path]) -> dict[str, list[Picture]]:
    """The figures by category."""
    gallery: dict[str, list[Picture]] = {}
    for png in pngs:
        figure = figures()[png.stem]
        picture = Picture(png, f"figures/{png.name}", figure.full_title, figure.caption)
        gallery.setdefault(figure.category, []).append(picture)
    return gallery


def _signals(results: CampaignTables, refused_folder: Path) -> list[Picture]:
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


def _embedded(pictures: Sequence[Picture], room_bytes: float) -> dict[str, str]:
    """Pictures as data URLs, by file: as many as fit into the room, the smallest ones first."""
    base64_of_file = {
        picture.file: base64.b64encode(picture.png.read_bytes()).decode() for picture in pictures
    }
    embedded: dict[str, str] = {}
    for file in sorted(base64_of_file, key=lambda file: len(base64_of_file[file])):
        room_bytes -= len(base64_of_file[file]) + _LARGEST_TAG
        if room_bytes > 0:
            embedded[file] = f"data:image/png;base64,{base64_of_file[file]}"
    return embedded


def _look(text: str) -> str:
    """How good a verdict is: good, fair or bad; empty for another text.

    The longest verdict with which the text begins decides.
    """
    verdicts = [verdict for verdict in _LOOK_OF_VERDICT if f"{text} ".startswith(f"{verdict} ")]
    return _LOOK_OF_VERDICT[max(verdicts, key=len)] if verdicts else ""


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
    environment.filters |= {"source_hash": _source_hash, "printed": printed, "look": _look}
    return environment.get_template("page.html.jinja")
