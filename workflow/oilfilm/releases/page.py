"""A comparison of two releases, and the list of all, as self-contained HTML pages.

Decides: the page that lists releases.
"""

import base64
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from oilfilm.atomic_write import write_text
from oilfilm.errors import OilfilmError
from oilfilm.releases.compare import Comparison, Section, compare, drift_table
from oilfilm.releases.manifest import MANIFEST
from oilfilm.releases.stored_release import StoredRelease
from oilfilm.settings.config import DriftSettings

_PNG = b"\x89PNG\r\n\x1a\n"
_LARGEST_PNG = 1 << 24
_INDEX, _CHANGES, _REPORT = "index.html", "changes", "report.html"
# Nothing of a release is markup, whatever the name of the template.
_TEMPLATES = Environment(
    loader=FileSystemLoader(Path(__file__).parent),
    autoescape=True,
    undefined=StrictUndefined,
    trim_blocks=True,
)


def page(comparison: Comparison, moved: Section) -> str:
    """The page of a comparison, figures side by side. Nothing in it runs or is fetched."""
    before, after = comparison.before, comparison.after
    names = sorted(
        path
        for path in before.files.keys() | after.files.keys()
        if path.startswith("figures/") and path.endswith(".png")
    )
    differ = [name for name in names if before.files.get(name) != after.files.get(name)]
    return _TEMPLATES.get_template("compare.html.jinja").render(
        before=before.name,
        after=after.name,
        simulated="simulated" in {stored.manifest.made_from.data for stored in (before, after)},
        moved=moved,
        sections=comparison.sections,
        same=[name for name in names if name not in differ],
        figures={name: [_picture(stored, name) for stored in (before, after)] for name in differ},
    )


def _picture(stored: StoredRelease, path: str) -> Mapping[str, str]:
    """A figure of a release as an `address` that holds it; or why it is `lacking`."""
    if path not in stored.files:
        return {"lacking": "no such figure"}
    if not stored.holds(path):
        return {"lacking": "not kept in the pin"}
    if stored.files[path].size > _LARGEST_PNG:
        return {"lacking": f"larger than {_LARGEST_PNG} bytes"}
    content = stored.file(path).read_bytes()
    # a browser would guess what other bytes are
    if not content.startswith(_PNG):
        return {"lacking": "no PNG"}
    return {"address": "data:image/png;base64," + base64.b64encode(content).decode("ascii")}


def list_releases(releases: Path, drift: DriftSettings) -> Path:
    """Write the page that lists the releases in a folder, and a page of changes for each new one.

    The order is that of the folders' time stamps: nothing in a release depends on a clock.

    Args:
        releases: Folder of the campaign's releases.
        drift: `drift` of the configuration.

    Returns:
        The page.
    """
    folders = [path.parent for path in releases.glob(f"*/{MANIFEST}")]
    folders = [folder for folder in folders if not folder.is_symlink()]
    by_age = sorted(folders, key=lambda folder: (folder.stat().st_mtime_ns, folder.name))
    pairs = zip([None, *by_age], by_age, strict=False)
    listed = [_listed(before, folder, drift) for before, folder in pairs]
    link = releases / "latest"
    text = _TEMPLATES.get_template("listing.html.jinja").render(
        campaign=releases.name,
        newest_first=listed[::-1],
        latest=link.readlink().name if link.is_symlink() else "",
        report=_REPORT,
    )
    write_text(text, releases / _INDEX)
    return releases / _INDEX


def _listed(before: Path | None, folder: Path, drift: DriftSettings) -> dict[str, Any]:
    """What the list says of a release; its changes are written to a page of their own."""
    listed: dict[str, Any] = {"version": folder.name, "changes": "", "not_compared": ""}
    try:
        stored = StoredRelease.open(folder)
        runs = stored.table("runs")
        if runs is not None:
            counts = runs["verdict"].value_counts().sort_index().items()
            listed["runs"] = ", ".join(f"{count} {verdict}" for verdict, count in counts)
            of_oils = runs.loc[runs["verdict"] == "accepted", "oil"].value_counts().sort_index()
            listed["oils"] = ", ".join(f"{oil}: {count}" for oil, count in of_oils.items())
        listed["data"] = stored.manifest.made_from.data
        listed["logs"] = len(stored.manifest.made_from.raw)
        listed["report"] = _REPORT in stored.files
        listed["date"] = ((stored.config() or {}).get("release") or {}).get("date", "")
        if before is not None:
            listed["changes"] = f"{_CHANGES}/{before.name}..{folder.name}.html"
            _write_changes(folder.parent / listed["changes"], before, stored, drift)
    except OilfilmError as reason:  # of other code, or damaged: no reason to stop a new one
        listed["not_compared"] = str(reason).removeprefix(f"{folder}: ")
    return listed


def _write_changes(path: Path, before: Path, after: StoredRelease, drift: DriftSettings) -> None:
    if not path.is_file():
        comparison = compare(StoredRelease.open(before), after, drift)
        text = page(comparison, drift_table(comparison, drift))
        write_text(text.encode("utf-8", "backslashreplace").decode(), path)
