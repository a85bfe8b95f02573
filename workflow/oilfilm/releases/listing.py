"""The page that lists the releases of a campaign, with what changed from each to the next.

Decides: the page that lists releases.
"""

from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined
from pydantic import BaseModel, ConfigDict, ValidationError

from oilfilm.atomic_write import write_text
from oilfilm.errors import OilfilmError
from oilfilm.releases.compare import compare
from oilfilm.releases.drift import drift_table
from oilfilm.releases.manifest import MANIFEST, canonical
from oilfilm.releases.page import page
from oilfilm.releases.stored_release import StoredRelease
from oilfilm.settings.config import DriftSettings

INDEX, _LIST, _CHANGES = "index.html", "releases.json", "changes"
_REPORT = "report.html"


class ListedRelease(BaseModel):
    """One release, and how it differs from the one before it in the list.

    Attributes:
        version: Its version, which is the name of its folder.
        before: Version of the release before it; empty for the first.
        date: Day of publication, as its configuration states it; no clock is read.
        data: Whether its data are measured or simulated.
        logs: Number of raw logs.
        runs: Runs by verdict, as "212 accepted, 6 refused".
        oils: Accepted runs of each oil.
        report: Whether it has a report.
        moved: Changes since then beyond the limits of `drift`; None where they were not compared.
        not_compared: Why it was not compared, or could not be read.
    """

    model_config = ConfigDict(extra="forbid")

    version: str
    before: str
    date: str = ""
    data: str = ""
    logs: int = 0
    runs: str = ""
    oils: dict[str, int] = {}
    report: bool = False
    moved: int | None = None
    not_compared: str = ""


class _List(BaseModel):
    releases: list[ListedRelease]


def list_releases(releases: Path, drift: DriftSettings) -> Path:
    """Write the page that lists the releases in a folder, and a page of changes for each new one.

    The order in which releases were made is kept in `releases.json`, because nothing in a release
    depends on a clock. What was read of a release before is not read again.

    Args:
        releases: Folder of the campaign's releases.
        drift: `drift` of the configuration.

    Returns:
        The page.
    """
    listed: list[ListedRelease] = []
    for version, known in _in_order(releases).items():
        before = listed[-1].version if listed else ""
        if known is not None and known.before == before:
            listed.append(known)
        else:
            listed.append(_read(releases, version, before, drift))
    kept = _List(releases=listed)
    write_text(canonical(kept.model_dump()), releases / _LIST)
    templates = FileSystemLoader(Path(__file__).parent)
    environment = Environment(
        loader=templates, autoescape=True, undefined=StrictUndefined, trim_blocks=True
    )
    link = releases / "latest"
    text = environment.get_template("listing.html.jinja").render(
        campaign=releases.name,
        newest_first=listed[::-1],
        latest=link.readlink().name if link.is_symlink() else "",
        changes=_CHANGES,
        report=_REPORT,
    )
    write_text(text, releases / INDEX)
    return releases / INDEX


def _in_order(releases: Path) -> dict[str, ListedRelease | None]:
    """The versions that are there, oldest first, with what is known of them."""
    folders = [path for path in releases.iterdir() if not path.is_symlink()]
    present = {path.name: path for path in folders if (path / MANIFEST).is_file()}
    try:
        text = (releases / _LIST).read_text(encoding="utf-8")
        known = _List.model_validate_json(text).releases
    except (FileNotFoundError, ValidationError, UnicodeDecodeError):
        known = []  # it is made again
    order: dict[str, ListedRelease | None] = {
        each.version: each for each in known if each.version in present
    }
    others = present.keys() - order.keys()
    # how old releases came before there was a list
    by_age = sorted(others, key=lambda name: (present[name].stat().st_mtime_ns, name))
    return order | dict.fromkeys(by_age)


def _read(releases: Path, version: str, before: str, drift: DriftSettings) -> ListedRelease:
    """What the list says of a release; its changes are written to a page of their own."""
    listed = ListedRelease(version=version, before=before)
    folder = releases / version
    try:
        stored = StoredRelease.open(folder)
        listed.data = stored.manifest.made_from["data"]
        listed.logs = len(stored.manifest.raw)
        listed.report = _REPORT in stored.files
        listed.date = str(((stored.config() or {}).get("release") or {}).get("date", ""))
        _count_runs(listed, stored)
        if before:
            comparison = compare(StoredRelease.open(releases / before), stored, drift)
            too_far = drift_table(comparison, drift)
            changes = page(comparison, too_far).encode("utf-8", "backslashreplace").decode()
            write_text(changes, releases / _CHANGES / f"{version}.html")
            listed.moved = len(too_far.rows)
    except OilfilmError as reason:  # of other code, or damaged: no reason to stop a new one
        listed.not_compared = str(reason).removeprefix(f"{folder}: ")
    return listed


def _count_runs(listed: ListedRelease, stored: StoredRelease) -> None:
    runs = stored.table("runs")
    if runs is not None:
        verdicts = runs["verdict"].value_counts().sort_index()
        listed.runs = ", ".join(f"{count} {verdict}" for verdict, count in verdicts.items())
        accepted = runs.loc[runs["verdict"] == "accepted", "oil"].value_counts().sort_index()
        listed.oils = {str(oil): int(count) for oil, count in accepted.items()}
