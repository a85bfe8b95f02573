"""A campaign's tables described for other programs: a data package (Frictionless).

Names, types, units, meanings, caveats and keys come from the declaration of the tables. The same
tables give the same bytes: no clock, and everything in a fixed order. Paths are relative to the
folder of the tables, which can be moved as a whole.
"""

import json
import re
from collections.abc import Container, Iterable, Sequence
from pathlib import Path
from typing import Any

import pyarrow.parquet as parquet

from oilfilm import tables
from oilfilm.base.digests import file_digest
from oilfilm.base.errors import OilfilmError
from oilfilm.settings.campaign import Source
from oilfilm.settings.resolved import Settings

_TYPES = {"text": "string", "texts": "array", "flag": "boolean"}
_ORIGIN = {
    "simulated": "SIMULATED data: written by a program, not measured on a rig.",
    "measured": "Measured data.",
}
_NOT_STATED = "not stated"
_RAW_LOGS = Source(title="raw logs of the campaign; runs.parquet has the name and sha256 of each")


def data_package(settings: Settings, folder: Path, paths: Iterable[Path]) -> str:
    """The text of `datapackage.json` (Data Package standard, version 1).

    A table in several files has a list of paths. The standard has no key for the hash of each, so
    `files` has path, hash, bytes and rows of every one.

    Args:
        settings: At least the campaign's name, data and description, and the dataset.
        folder: Of the tables.
        paths: The written tables in it, in any order.

    Raises:
        OilfilmError: A table is missing, damaged or was not written by oilfilm, or its footer and
            the campaign disagree on whether the data are simulated.
    """
    campaign, about = settings.campaign, settings.dataset
    of_table: dict[str, list[dict[str, Any]]] = {name: [] for name in tables.TABLES}
    files = {path.relative_to(folder).as_posix(): path for path in paths}
    for name, path in sorted(files.items()):
        footer = tables.read_footer(path)
        if footer["data"] != campaign.data:
            raise OilfilmError(
                f"{name}: its footer says that the data are {footer['data']}, campaign "
                f"{campaign.name!r} that they are {campaign.data}. Delete it and run snakemake "
                "again."
            )
        file: dict[str, Any] = {"path": name, "hash": f"sha256:{file_digest(path)}"}
        file |= {"bytes": path.stat().st_size, "rows": parquet.read_metadata(path).num_rows}
        of_table[footer["table"]].append(file)
    present = {table: of_this for table, of_this in of_table.items() if of_this}
    description = [
        campaign.description,
        _ORIGIN[campaign.data],
        f"Licence: {about.licence or _NOT_STATED}.",
        f"Creators: {', '.join(about.creators or ()) or _NOT_STATED}.",
    ]
    for change in about.acknowledged_changes:
        log = f"{change.log} ({change.was}, now {change.now})"
        description.append(f"Changed after it was first read: {log}: {change.reason}")
    licence = about.licence or ""
    descriptor = {
        # The standard allows fewer letters in a name than a campaign may have.
        "name": re.sub(r"[^a-z0-9._-]", "-", campaign.name.lower()),
        "title": about.title or f"Traction campaign {campaign.name}",
        "description": "\n".join(description),
        "data": campaign.data,
        "licenses": [{"path" if "://" in licence else "name": licence}] if licence else [],
        "contributors": [{"title": name, "role": "author"} for name in about.creators or ()],
        "sources": [
            _given({"title": source.title, "path": source.address})
            for source in (_RAW_LOGS, *(about.sources or ()))
        ],
        "resources": [_resource(table, of_this, present) for table, of_this in present.items()],
    }
    return json.dumps(_given(descriptor), indent=2, ensure_ascii=False) + "\n"


def _given(keys: dict[str, Any]) -> dict[str, Any]:
    """The keys that have a value: the standard allows no empty ones."""
    return {key: value for key, value in keys.items() if value not in ("", None, [], {})}


def _resource(
    table: str, files: Sequence[dict[str, Any]], present: Container[str]
) -> dict[str, Any]:
    model, first = tables.TABLES[table], files[0]
    resource = {
        "name": table,
        "type": "table",
        "description": model.about,
        "path": first["path"] if len(files) == 1 else [file["path"] for file in files],
        "format": "parquet",
        "mediatype": "application/vnd.apache.parquet",
        "bytes": sum(file["bytes"] for file in files),
        "hash": first["hash"] if len(files) == 1 else "",
        "rows": sum(file["rows"] for file in files),
        "files": files,
        "schema": _schema(model, present),
    }
    # columns that are in the names of the folders and not in the files
    partitions = [part.partition("=")[0] for part in first["path"].split("/") if "=" in part]
    return _given(resource) | {"partitions": partitions}


def _schema(model: tables.Table, present: Container[str]) -> dict[str, Any]:
    """Columns and keys; only keys to tables that are in the package."""
    # the standard forbids nulls in a primary key
    with_nulls = any(model[name].nullable for name in model.key)
    foreign = [
        {"fields": list(columns), "reference": {"resource": table, "fields": list(columns)}}
        for table, columns in model.references.items()
        if table in present
    ]
    schema = {
        "fields": [_field(column) for column in model.columns],
        "uniqueKeys": [list(model.key)] if with_nulls else [],
        "primaryKey": [] if with_nulls else list(model.key),
        "foreignKeys": foreign,
    }
    # an empty text is a value here
    return _given(schema) | {"missingValues": []}


def _field(column: tables.Column) -> dict[str, Any]:
    low, high = column.at_least, column.at_most
    constraints = {
        "required": not column.nullable or None,
        "minimum": low if low is not None and low > -tables.LARGEST else None,
        "maximum": high if high is not None and high < tables.LARGEST else None,
        # the standard has no such key for the items of a list
        "enum": list(column.allowed) if column.type != "texts" else [],
    }
    field = {
        "name": column.name,
        "type": _TYPES.get(column.type, column.type),
        "description": column.meaning_here,
        "unit": "" if column.unit == tables.BY_ROW else column.unit,
        "caveat": column.caveat,
        "constraints": _given(constraints),
    }
    return _given(field)
