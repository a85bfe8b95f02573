"""A comparison as one self-contained page, with the figures side by side."""

import base64
from dataclasses import dataclass
from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from oilfilm.releases.compare import Comparison, Section
from oilfilm.releases.stored_release import StoredRelease

_PNG = b"\x89PNG\r\n\x1a\n"
_LARGEST_PNG = 1 << 24


@dataclass(frozen=True)
class Picture:
    """A figure of one release as an address that holds it; or why there is none, in words."""

    address: str = ""
    lacking: str = ""


def page(comparison: Comparison, moved: Section) -> str:
    """The page. Everything of a release is text in it; nothing in it runs or is fetched."""
    before, after = comparison.before, comparison.after
    names = sorted(_figures(before) | _figures(after))
    differ = [name for name in names if before.files.get(name) != after.files.get(name)]
    templates = FileSystemLoader(Path(__file__).parent)
    # escaping does not depend on the name of the template
    environment = Environment(
        loader=templates, autoescape=True, undefined=StrictUndefined, trim_blocks=True
    )
    return environment.get_template("compare.html.jinja").render(
        before=before.name,
        after=after.name,
        simulated="simulated" in {stored.manifest.made_from["data"] for stored in (before, after)},
        moved=moved,
        sections=comparison.sections,
        same=[name for name in names if name not in differ],
        figures={name: (_picture(before, name), _picture(after, name)) for name in differ},
    )


def _figures(stored: StoredRelease) -> set[str]:
    return {path for path in stored.files if path.startswith("figures/") and path.endswith(".png")}


def _picture(stored: StoredRelease, path: str) -> Picture:
    if path not in stored.files:
        return Picture(lacking="no such figure")
    if not stored.holds(path):
        return Picture(lacking="not kept in the pin")
    if stored.files[path].size > _LARGEST_PNG:
        return Picture(lacking=f"larger than {_LARGEST_PNG} bytes")
    content = stored.file(path).read_bytes()
    # a browser would guess what other bytes are
    if not content.startswith(_PNG):
        return Picture(lacking="no PNG")
    return Picture("data:image/png;base64," + base64.b64encode(content).decode("ascii"))
