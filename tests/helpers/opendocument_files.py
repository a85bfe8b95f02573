"""OpenDocument spreadsheets as files, from the XML of their rows."""

import io
import zipfile
from collections.abc import Sequence
from typing import Any
from xml.sax.saxutils import quoteattr

_NAMESPACES = " ".join(
    f'xmlns:{short}="urn:oasis:names:tc:opendocument:xmlns:{short}:1.0"'
    for short in ("office", "table", "text")
)


def spreadsheet(content: str) -> bytes:
    """An .ods file: the media type first and not compressed, as OpenDocument 1.3 demands."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w", zipfile.ZIP_DEFLATED) as archive:
        media_type = "application/vnd.oasis.opendocument.spreadsheet"
        archive.writestr("mimetype", media_type, compress_type=zipfile.ZIP_STORED)
        archive.writestr("content.xml", content)
    return buffer.getvalue()


def document(**sheets: str) -> str:
    """The XML of a spreadsheet, from the XML of the rows of each sheet by its title."""
    tables = "".join(
        f"<table:table table:name={quoteattr(title)}>{rows}</table:table>"
        for title, rows in sheets.items()
    )
    return (
        f'<?xml version="1.0" encoding="UTF-8"?><office:document-content {_NAMESPACES}>'
        f"<office:body><office:spreadsheet>{tables}</office:spreadsheet></office:body>"
        "</office:document-content>"
    )


def cell(value: object = None, times: int = 1, kind: str = "float", name: str = "value") -> str:
    """The XML of a cell.

    Args:
        value: Its content; empty without one.
        times: How often it is repeated.
        kind: Type of the value.
        name: Attribute that has the value, without its namespace.
    """
    repeated = f' table:number-columns-repeated="{times}"' if times > 1 else ""
    if value is None:
        return f"<table:table-cell{repeated}/>"
    text = f"<text:p>{value}</text:p>"
    if isinstance(value, str) and kind == "float":
        return f'<table:table-cell{repeated} office:value-type="string">{text}</table:table-cell>'
    typed = f'office:value-type="{kind}" office:{name}="{value}"'
    return f"<table:table-cell{repeated} {typed}>{text}</table:table-cell>"


def row(*cells: str, times: int = 1) -> str:
    """The XML of a row, which is repeated so many times."""
    repeated = f' table:number-rows-repeated="{times}"' if times > 1 else ""
    return f"<table:table-row{repeated}>{''.join(cells)}</table:table-row>"


def rows_of(values: Sequence[Sequence[Any]]) -> str:
    """The XML of rows, one per list of values."""
    return "".join(row(*map(cell, cells)) for cells in values)
