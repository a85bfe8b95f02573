"""One HTML text from the finished tables and figures of a campaign.

Decides: which pictures are in the page of the report.
"""

import base64
import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from importlib.metadata import version
from itertools import chain
from pathlib import Path
from platform import python_version
from typing import Any

import numpy as np
import pandas as pd
from jinja2 import Environment, FileSystemLoader, StrictUndefined, Template
from markupsafe import Markup

from oilfilm import __version__, tables
from oilfilm.figure_catalogue import figures
from oilfilm.report import chart, runs, sections
from oilfilm.report.captions import caption, tie
from oilfilm.report.constants import by_certainty
from oilfilm.report.explorer import explorer
from oilfilm.report.facts import circular, film_unjudged_oils
from oilfilm.report.labels import printed
from oilfilm.report.law_script import law_script
from oilfilm.report.meanings import meanings
from oilfilm.report.pictures import packed, png_addresses, size_of
from oilfilm.report.release_id import UNRELEASED
from oilfilm.report.shown_table import ShownTable
from oilfilm.report.spreadsheet import csv_text
from oilfilm.report.verdict import verdict
from oilfilm.settings.resolved import Settings
from oilfilm.settings.yaml_file import as_yaml
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.traction import LAWS

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
    **dict.fromkeys(("sign unknown", "no interval", "holds in part", "no"), "fair"),
    **dict.fromkeys(("criteria disagree", "too few curves", "no repeats", "shown"), "fair"),
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
    """

    png: Path
    title: str
    caption: str
    category: str

    @property
    def name(self) -> str:
        """Name of its files."""
        return self.png.stem

    @property
    def svg(self) -> Path:
        """File of the drawing."""
        return self.png.with_suffix(".svg")

    @cached_property
    def size(self) -> tuple[int, int]:
        """Width and height on a wide screen, in CSS pixels."""
        width, height = size_of(self.png)
        return round(width * _SCALE), round(height * _SCALE)


def page(
    results: CampaignTables,
    pngs: Sequence[Path],
    refused: Path,
    settings: Settings,
    provenance: Mapping[str, Any],
) -> str:
    """The report of a campaign.

    Args:
        results: The tables of the campaign.
        pngs: The figures by name, in the order in which they are shown, each with an SVG beside it.
        refused: Folder of the pages of refused runs, as `refused_pages` names them.
        settings: All settings of the campaign.
        provenance: Of the job that writes the report.

    Returns:
        HTML that needs no network; the same results give the same text.
    """
    declared, unjudged = figures(), film_unjudged_oils(results.points)
    pictures = [
        Picture(
            png,
            declared[png.stem].numbered_title,
            caption(png.stem, settings.campaign, unjudged),
            declared[png.stem].category,
        )
        for png in pngs
    ]
    pages = [
        Picture(
            refused / row["page"],
            f"Signals of {row['run_id']}",
            f"{row['run_id']}: {row['reason']}",
            row["rule"],
        )
        for row in tables.rows(results.refused_pages)
        if row["page"]
    ]
    listed = runs.listed(results, settings.report.rows_max, settings.report.points_max)
    pictured = {row["run_id"]: Path(row["page"]).stem for row in tables.rows(results.refused_pages)}
    gallery: dict[str, list[Picture]] = {}
    for picture in pictures:
        gallery.setdefault(picture.category, []).append(picture)
    context = {
        **_tables(results, settings),
        **_explorer(results, settings),
        "settings": settings,
        "provenance": provenance,
        "configuration": as_yaml(settings.plain()),
        "packages": {"python": python_version(), "oilfilm": __version__}
        | {name: version(name) for name in _PACKAGES},
        "unreleased": UNRELEASED,
        "downloads": _downloads(results),
        "style": _asset("page.css"),
        "looks": _LOOKS,
        "run_count": len(results.runs),
        "run_list": runs.run_list(results, listed),
        "run_pages": runs.run_pages(results, listed, pictured),
        "gallery": gallery,
        "pages": pages,
    }
    pictures = [picture for shown in gallery.values() for picture in shown]
    return _with_pictures(context, pictures, pages, int(settings.report.size_max_mb * 1e6))


def _tables(results: CampaignTables, settings: Settings) -> dict[str, Any]:
    """Verdict and tables of the page."""
    rows_max = settings.report.rows_max
    sure = sections.certainty(results)
    said, fits = verdict(results, sure, settings), sections.fit_table(results, sure)
    certificates = sections.certificates(results)
    laws, noise = sections.laws(results), sections.noise(results)
    ranked = by_certainty(results.configured.coefficients, results.configured.correlations)
    constants = [
        sections.constants(ranked, oil, number)
        for number, oil in enumerate(dict.fromkeys(ranked["oil"]))
    ]
    return {
        "verdict": said,
        "laws": laws,
        "noise": noise,
        "meanings": {
            "verdict": meanings(_texts(said, laws)),
            "constants": meanings(_texts(certificates, *constants, fits, noise)),
            "claims": meanings(" ".join(results.claims["verdict"])),
        },
        "equations": sections.equations(results),
        "fits": fits,
        "certificates": certificates,
        "constants": constants,
        "quarantine": sections.refused(
            results.quarantine,
            "quarantine",
            "Everything that was refused: logs, runs and rows",
            rows_max,
        ),
        "gates": sections.gates(results),
        "claims": sections.claims(results),
        "comparison": sections.comparison(results),
        "torque": sections.torque(results),
        "torque_control": sections.torque_control(results),
        "circular": circular(settings.campaign),
        "tie": tie(settings.campaign),
        "bearing": sections.bearing(results),
        "torque_quarantine": sections.refused(
            results.torque_quarantine, "torque_quarantine", "Refused torque logs", rows_max
        ),
    }


def _texts(lines: Sequence[tuple[str, str]], *shown: ShownTable) -> str:
    """Everything that is read there."""
    cells = [cell for each in shown for row in each.rows for cell in row]
    headings = [column.heading for each in shown for column in each.columns]
    captions = [each.caption for each in shown]
    return " | ".join([*(sentence for _, sentence in lines), *captions, *headings, *cells])


def _explorer(results: CampaignTables, settings: Settings) -> dict[str, Any]:
    """Data and scripts of the explorer."""
    exploring = explorer(results, settings)
    return {
        "exploring": exploring,
        "chart": chart.chart([oil["colour"] for oil in exploring["oils"]]),
        "licence": chart.licence(),
        "scripts": [chart.library(), Markup(law_script(LAWS.values())), _asset("page.js")],  # noqa: S704
    }


def _with_pictures(
    context: dict[str, Any], pictures: Sequence[Picture], pages: Sequence[Picture], size_max: int
) -> str:
    """The page with as many pictures as its largest size allows, in bytes."""
    render = _template().render
    without_pictures = {**context, "addresses": {}, "drawings": {}}
    room = size_max - len(render(without_pictures).encode())
    if room < 0:  # the one table in the page that grows with the number of refusals
        context["downloads"].pop("quarantine.csv")
        room = size_max - len(render(without_pictures).encode())
    pngs, logs = [picture.png for picture in pictures], [page.png for page in pages]
    svgs = [picture.svg for picture in pictures]
    packing = (
        zip(pngs, png_addresses(pngs, _FIGURE_PX), strict=True),
        zip(logs, png_addresses(logs, _REFUSED_PX), strict=True),
        zip(svgs, map(packed, svgs), strict=True),
    )
    addresses: dict[Path, str] = {}
    for path, address in chain.from_iterable(packing):
        size = len(address) + _TAG
        if size <= room:
            addresses[path] = address
            room -= size
    drawings = {picture.name: addresses.get(picture.svg) for picture in pictures}
    drawings = {name: svg for name, svg in drawings.items() if svg}
    return render(context, addresses=addresses, drawings=drawings)


def _downloads(results: CampaignTables) -> dict[str, str]:
    """Files that the page can save or copy, by name."""
    named = {
        "coefficients": results.configured.coefficients,
        "fit_quality": results.configured.fit_quality,
        "quarantine": results.quarantine,
        "claims": results.claims,
    }
    if results.claims.empty:  # of oils that the paper did not test
        named.pop("claims")
    texts = {f"{name}.csv": csv_text(frame) for name, frame in named.items()}
    return texts | {"coefficients.json": _json(results.configured.coefficients)}


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
    environment.filters["source_hash"] = _source_hash
    environment.filters["printed"] = printed
    return environment.get_template("page.html.jinja")
