"""Pictures that travel inside the page."""

import base64
import io
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from PIL import Image

_COLOURS = 256
_THREADS = 2


def size_of(path: Path) -> tuple[int, int]:
    """Width and height of a picture, in pixels."""
    with Image.open(path) as picture:
        return picture.size


def png_addresses(paths: Sequence[Path], width_px: int) -> list[str]:
    """PNGs as data addresses, at most so many pixels wide, each in a palette of its own.

    Drawings have few colours: a palette makes them two to four times smaller, and nobody sees it.
    """
    # the report is a run's last job: the other processor has nothing to do
    with ThreadPoolExecutor(_THREADS) as pool:
        return list(pool.map(lambda path: _png_address(path, width_px), paths))


def _png_address(path: Path, width_px: int) -> str:
    with Image.open(path) as image:
        picture = image.convert("RGB")
    if picture.width > width_px:
        height = round(picture.height * width_px / picture.width)
        picture = picture.resize((width_px, height), Image.Resampling.HAMMING)
    content = io.BytesIO()
    # the octree is ten times as fast as the median cut, and its files are smaller
    picture.quantize(_COLOURS, Image.Quantize.FASTOCTREE, dither=Image.Dither.NONE).save(
        content, "PNG"
    )
    return f"data:image/png;base64,{base64.b64encode(content.getvalue()).decode('ascii')}"
