"""The report as one HTML page that needs no network.

Decides: how verdicts look, and which pictures a page has room for.
"""

import base64
import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from importlib.metadata import version
from pathlib import Path
from platform import python_version
from typing import Any

import numpy as np
import pandas as pd
from jinja2 import Environment, FileSystemLoader, StrictUndefined, Template
from markupsafe import Markup

from oilfilm import __version__, tables
from oilfilm.figure_catalogue import figures
from oilfilm.report import chart, runs
from oilfilm.report.captions import caption, film_unjudged_oils
from oilfilm.report.document import Section
from oilfilm.report.explorer import explorer
from oilfilm.report.law_script import law_script
from oilfilm.report.pictures import packed, png_addresses, size_of
from oilfilm.report.release_id import UNRELEASED
from oilfilm.report.spreadsheet import csv_text
from oilfilm.report.words import meanings, printed
from oilfilm.settings.resolved import Settings
from oilfilm.settings.yaml_file import as_yaml
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.traction import LAWS
from oilfilm.traction.typeset import mathml

_HERE = Path(__file__).parent
_PACKAGES = (
    *("numpy", "scipy", "pandas", "pandera", "pyarrow", "matplotlib", "snakemake"),
    *("bokeh", "jinja2"),
)
_FIGURE_PX, _REFUSED_PX = 1250, 900
_TAG = 500  # bytes around a picture, at most
_SCALE = 0.4  # CSS pixels a pixel: a single column of a journal is 400 of them
# Texts of verdicts -> how they look.
_LOOKS = {
    **dict.fromkeys(("known", "holds", "yes", "best", "tie", "not shown", "accepted"), "good"),
    **dict.fromkeys(
        (
            *("sign unknown", "no interval", "holds in part", "no", "criteria disagree"),
            *("too few curves", "no repeats", "shown"),
        ),
        "fair",
    ),
    **dict.fromkeys(
        ("at a bound", "not identifiable", "fails", "another law is better", "refused"), "bad"
    ),
}


@dataclass(frozen=True)
class Picture:
    """A figure in the page.

    Attributes:
        png: Its file; a figure of the campaign has its drawing beside it as SVG.
        title: A few words, also for those who cannot see it; the paper's number before them.
        caption: Its caption.
        category: Heading of its gallery.
        size: Width and height on a wide screen, in CSS pixels.
    """

    png: Path
    title: str
    caption: str
    category: str
    size: tuple[int, int]

    @classmethod
    def of(cls, png: Path, title: str, caption: str, category: str) -> "Picture":
        """The picture with the size of its file."""
        width, height = size_of(png)
        return cls(png, title, caption, category, (round(width * _SCALE), round(height * _SCALE)))

    @property
    def name(self) -> str:
        """Name of its files."""
        return self.png.stem


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
        pngs: The figures by name, in the order in which they are shown, each with an SVG beside it.
        refused: Folder of the pages of refused runs, as `refused_pages` names them.
        settings: All settings of the campaign.
        provenance: Of the job that writes the report.

    Returns:
        HTML; the same results give the same text.
    """
    declared, unjudged = figures(), film_unjudged_oils(results.points)
    gallery: dict[str, list[Picture]] = {}
    for png in pngs:
        figure = declared[png.stem]
        text = caption(png.stem, settings.campaign, unjudged)
        picture = Picture.of(png, figure.numbered_title, text, figure.category)
        gallery.setdefault(figure.category, []).append(picture)
    pages = [row for row in tables.rows(results.refused_pages) if row["page"]]
    signals = [
        Picture.of(
            refused / row["page"],
            f"Signals of {row['run_id']}",
            f"{row['run_id']}: {row['reason']}",
            row["rule"],
        )
        for row in pages
    ]
    listed = runs.listed(results, settings.report.rows_max, settings.report.points_max)
    exploring = explorer(results, settings)
    context = {
        "sections": sections,
        "words": {section.anchor: _words(section) for section in sections},
        "settings": settings,
        "provenance": provenance,
        "configuration": as_yaml(settings.plain()),
        "packages": {"python": python_version(), "oilfilm": __version__}
        | {name: version(name) for name in _PACKAGES},
        "unreleased": UNRELEASED,
        "downloads": {
            name: _json(frame) if name.endswith(".json") else csv_text(frame)
            for section in sections
            for name, frame in section.downloads.items()
        },
        "style": _asset("page.css"),
        "looks": _LOOKS,
        "equations": [
            (Markup(mathml(LAWS[name])), LAWS[name].source)  # noqa: S704  (our own text)
            for name in dict.fromkeys(results.configured.coefficients["law"])
        ],
        "run_count": len(results.runs),
        "run_pages": runs.run_pages(
            results, listed, {row["run_id"]: Path(row["page"]).stem for row in pages}
        ),
        "gallery": gallery,
        "signals": signals,
        "exploring": exploring,
        "chart": chart.chart([oil["colour"] for oil in exploring["oils"]]),
        "licence": chart.licence(),
        "scripts": [chart.library(), Markup(law_script(LAWS.values())), _asset("page.js")],  # noqa: S704
    }
    shown = [picture for pictures in gallery.values() for picture in pictures]
    return _with_pictures(context, shown, signals, int(settings.report.size_max_mb * 1e6))


def _words(section: Section) -> list[tuple[str, str]]:
    """The words of a section that need a meaning."""
    texts = [fact.text for fact in section.facts]
    texts += [verdict for entry in section.entries for _, verdict in entry.verdicts]
    for table in section.tables:
        texts += [table.caption, *(column.heading for column in table.columns)]
        texts += [cell for row in table.rows for cell in row]
    return meanings(" | ".join(texts), section.words)


def _with_pictures(
    context: dict[str, Any], pictures: Sequence[Picture], signals: Sequence[Picture], size_max: int
) -> str:
    """The page with as many pictures as its largest size allows, in bytes."""
    render = _template().render
    without_pictures = {**context, "addresses": {}, "drawings": {}}
    room = size_max - len(render(without_pictures).encode())
    if room < 0:  # the one table in the page that grows with the number of refusals
        context["downloads"].pop("quarantine.csv")
        room = size_max - len(render(without_pictures).encode())
    figures_of, logs = [each.png for each in pictures], [each.png for each in signals]
    svgs = {each.name: each.png.with_suffix(".svg") for each in pictures}
    packing = [
        *zip(figures_of, png_addresses(figures_of, _FIGURE_PX), strict=True),
        *zip(logs, png_addresses(logs, _REFUSED_PX), strict=True),
        *((svg, packed(svg)) for svg in svgs.values()),
    ]
    addresses: dict[Path, str] = {}
    for path, address in packing:
        size = len(address) + _TAG
        if size <= room:
            addresses[path] = address
            room -= size
    drawings = {name: addresses[svg] for name, svg in svgs.items() if svg in addresses}
    return render(context, addresses=addresses, drawings=drawings)


def _json(frame: pd.DataFrame) -> str:
    # JSON has neither NaN nor infinity
    plain = frame.astype(object).where(frame.notna() & ~frame.isin([np.inf, -np.inf]), None)
    return json.dumps(tables.rows(plain), indent=1, ensure_ascii=False, allow_nan=False) + "\n"


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
    # Bokeh reads a model where it first stands, and elsewhere by its number
    environment.policies["json.dumps_kwargs"] = {"sort_keys": False, "allow_nan": False}
    environment.filters |= {"source_hash": _source_hash, "printed": printed}
    return environment.get_template("page.html.jinja")
