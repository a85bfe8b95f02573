"""The report as one HTML page that needs no network.

Decides: how verdicts look, and which pictures and files a page has room for.
"""

import base64
import hashlib
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined, Template
from markupsafe import Markup

from oilfilm import tables
from oilfilm.base.figure_catalogue import figures
from oilfilm.report import captions
from oilfilm.report.document import Section, meanings
from oilfilm.report.explorer import explorer, law_script
from oilfilm.report.release_id import UNRELEASED
from oilfilm.report.sections.build import drawn_points
from oilfilm.report.words import printed
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.traction import LAWS
from oilfilm.traction.typeset import mathml

_HERE = Path(__file__).parent
# How verdicts look; the first one that a text begins with.
_LOOKS = {
    "good": "known, holds, yes, best, tie, not shown, accepted, certified, sound, ties",
    "fair": "sign unknown, no interval, holds in part, criteria disagree, too few curves, "
    "no repeats, shown",
    "bad": "at a bound, not identifiable, fails, another law is better, refused, not certified, "
    "no, not sound, worse",
}


# Of a picture in the page, beside its content.
_LONGEST_TAG = 200


def html(
    sections: Sequence[Section],
    results: CampaignTables,
    pngs: Sequence[Path],
    refused: Path,
    settings: Settings,
    provenance: Mapping[str, Any],
) -> str:
    """The page: the sections, and what only a page can show.

    Args:
        sections: Of the campaign's report.
        results: The tables of the campaign.
        pngs: The figures by name, in the order in which they are shown.
        refused: Folder of the pages of refused runs, as `refused_pages` names them.
        settings: All settings of the campaign.
        provenance: Of the job that writes the report.

    Returns:
        HTML; the same results give the same text.
    """
    gallery: dict[str, list[dict[str, Any]]] = {}
    for png in pngs:
        figure = figures()[png.stem]
        picture = {
            "png": png,
            "file": f"figures/{png.name}",
            "title": figure.full_title,
            "caption": figure.caption,
        }
        gallery.setdefault(figure.category, []).append(picture)
    signals = [
        {
            "png": refused / row["page"],
            "file": f"refused/{row['page']}",
            "title": f"Signals of {row['run_id']}",
            "caption": f"{row['run_id']}: {row['reason']}",
        }
        for row in tables.rows(results.refused_pages)
        if row["page"]
    ]
    data = {
        **explorer(results, settings),
        "points": drawn_points(results.points, settings.report.points_max),
    }
    context = {
        "sections": sections,
        "words": meanings(sections).items(),
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
        "scripts": [Markup(law_script(LAWS.values())), _asset("page.js")],  # noqa: S704
    }
    pictures = [*(each for shown in gallery.values() for each in shown), *signals]
    files = {each["file"]: base64.b64encode(each["png"].read_bytes()).decode() for each in pictures}
    embedded: dict[str, str] = {}
    page = _template().render(context, embedded=embedded)
    room = settings.report.size_max_mb * 1e6 - len(page.encode())
    # the smallest files first: as many as there is room for
    for file, content in sorted(files.items(), key=lambda each: len(each[1])):
        room -= len(content) + _LONGEST_TAG
        if room > 0:
            embedded[file] = f"data:image/png;base64,{content}"
    return _template().render(context, embedded=embedded)


def _look(verdict: str) -> str:
    """How a verdict looks: good, fair or bad."""
    looks = {text: look for look, texts in _LOOKS.items() for text in texts.split(", ")}
    fitting = [text for text in looks if f"{verdict} ".startswith(f"{text} ")]
    return looks[max(fitting, key=len)] if fitting else ""


def _asset(name: str) -> Markup:
    return Markup((_HERE / name).read_text(encoding="utf-8"))  # noqa: S704  (our own file)


def _source_hash(script: str) -> str:
    """What a content security policy knows an inline script by."""
    return base64.b64encode(hashlib.sha256(script.encode()).digest()).decode("ascii")


@cache
def _template() -> Template:
    environment = Environment(
        loader=FileSystemLoader(_HERE),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.policies["json.dumps_kwargs"] = {"sort_keys": False, "allow_nan": False}
    environment.filters |= {"source_hash": _source_hash, "printed": printed, "look": _look}
    return environment.get_template("page.html.jinja")
