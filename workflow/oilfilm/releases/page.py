"""A comparison as one self-contained page, with the figures side by side."""

import base64
import struct
from dataclasses import dataclass
from pathlib import Path

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from oilfilm.releases.compare import Comparison, Section
from oilfilm.releases.stored_release import StoredRelease

_PNG = b"\x89PNG\r\n\x1a\n"
# Width and height behind the mark, and the length and name of the first chunk.
_HEAD = struct.Struct(">16x2I")
# A small PNG may unfold to more pixels than a browser has memory for.
_LARGEST_PNG, _MOST_PIXELS = 1 << 24, 1 << 26
# Bytes of all pictures of a page.
_LARGEST_PAGE = 1 << 28


@dataclass(frozen=True)
class Picture:
    """A figure of one release as an address that holds it; or why there is none, in words."""

    address: str = ""
    lacking: str = ""


_NO_ROOM = Picture(lacking="left out: the page would be too large")


def page(comparison: Comparison, moved: Section) -> str:
    """The page. Everything of a release is text in it; nothing in it runs or is fetched."""
    before, after = comparison.before, comparison.after
    names = sorted(_figures(before) | _figures(after))
    differ = [name for name in names if before.files.get(name) != after.files.get(name)]
    room, figures = _LARGEST_PAGE, {}
    for name in differ:
        pair = _picture(before, name), _picture(after, name)
        room -= sum(len(picture.address) for picture in pair)
        figures[name] = pair if room >= 0 else (_NO_ROOM, _NO_ROOM)
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
        figures=figures,
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
    if not content.startswith(_PNG) or len(content) < _HEAD.size:
        return Picture(lacking="no PNG")
    width, height = _HEAD.unpack_from(content)
    if width * height > _MOST_PIXELS:
        return Picture(lacking=f"{width} x {height} pixels, more than {_MOST_PIXELS}")
    return Picture("data:image/png;base64," + base64.b64encode(content).decode("ascii"))
