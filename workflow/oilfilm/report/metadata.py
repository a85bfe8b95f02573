"""A campaign's tables described for other programs: a data package (Frictionless).

Names, types, units, meanings, caveats and keys come from the declaration of the tables. The same
tables give the same bytes: no clock, and everything in a fixed order. Paths are relative to the
folder of the tables, which can be moved as a whole.
"""

import json
import re
from collections.abc import Container, Iterable, Sequence
from typing import Any

from oilfilm import tables
from oilfilm.errors import OilfilmError
from oilfilm.settings.campaign import Source
from oilfilm.settings.resolved import Settings
from oilfilm.tables.table_file import TableFile

_TYPES = {"text": "string", "flag": "boolean"}
_ORIGIN = {
    "simulated": "SIMULATED data: written by a program, not measured on a rig.",
    "measured": "Measured data.",
}
_NOT_STATED = "not stated"
_RAW_LOGS = Source(title="raw logs of the campaign; runs.parquet has the name and sha256 of each")


def data_package(settings: Settings, files: Iterable[TableFile]) -> str:
    """The text of `datapackage.json` (Data Package standard, version 1).

    A table in several files has a list of paths. The standard has no key for the hash of each, so
    `files` has path, hash, bytes and rows of every one.

    Args:
        settings: At least the campaign's name, data and description, and the dataset.
        files: The written tables, in any order.

    Raises:
        OilfilmError: A table's footer and the campaign disagree on whether the data are simulated.
    """
    campaign, about = settings.campaign, settings.dataset
    in_order = sorted(files, key=lambda file: file.path)
    for file in in_order:
        if file.data != campaign.data:
            raise OilfilmError(
                f"{file.path}: its footer says that the data are {file.data}, campaign "
                f"{campaign.name!r} that they are {campaign.data}. Delete it and run snakemake "
                "again."
            )
    of_table: dict[str, list[TableFile]] = {}
    for file in sorted(in_order, key=lambda file: [*tables.TABLES].index(file.table)):
        of_table.setdefault(file.table, []).append(file)
    creators = about.creators or ()
    description = [
        campaign.description,
        _ORIGIN[campaign.data],
        f"Licence: {about.licence or _NOT_STATED}.",
        f"Creators: {', '.join(creators) or _NOT_STATED}.",
    ]
    for change in about.acknowledged_changes:
        log = f"{change.log} ({change.was}, now {change.now})"
        description.append(f"Changed after it was first read: {log}: {change.reason}")
    descriptor: dict[str, Any] = {
        # The standard allows fewer letters in a name than a campaign may have.
        "name": re.sub(r"[^a-z0-9._-]", "-", campaign.name.lower()),
        "title": about.title or f"Traction campaign {campaign.name}",
        "description": "\n".join(description),
        "data": campaign.data,
        "sources": [
            {"title": source.title, **({"path": source.address} if source.address else {})}
            for source in (_RAW_LOGS, *(about.sources or ()))
        ],
        "resources": [_resource(table, of_this, of_table) for table, of_this in of_table.items()],
    }
    if about.licence:
        descriptor["licenses"] = [{"path" if "://" in about.licence else "name": about.licence}]
    if creators:
        descriptor["contributors"] = [{"title": name, "role": "author"} for name in creators]
    return json.dumps(descriptor, indent=2, ensure_ascii=False) + "\n"


def _resource(table: str, files: Sequence[TableFile], present: Container[str]) -> dict[str, Any]:
    model = tables.TABLES[table]
    about_files = [
        {"path": file.path, "hash": f"sha256:{file.sha256}", "bytes": file.bytes, "rows": file.rows}
        for file in files
    ]
    paths = [file.path for file in files]
    return {
        "name": table,
        "type": "table",
        "description": model.about,
        "path": paths if len(paths) > 1 else paths[0],
        # columns that are in the names of the folders and not in the files
        "partitions": [part.partition("=")[0] for part in paths[0].split("/") if "=" in part],
        "format": "parquet",
        "mediatype": "application/vnd.apache.parquet",
        "bytes": sum(file.bytes for file in files),
        **({"hash": about_files[0]["hash"]} if len(files) == 1 else {}),
        "rows": sum(file.rows for file in files),
        "files": about_files,
        "schema": _schema(model, present),
    }


def _schema(model: tables.Table, present: Container[str]) -> dict[str, Any]:
    """Columns and keys; only keys to tables that are in the package."""
    schema: dict[str, Any] = {
        "fields": [_field(column) for column in model.columns],
        # an empty text is a value here
        "missingValues": [],
    }
    if any(model[name].nullable for name in model.key):
        # the standard forbids nulls in a primary key
        schema["uniqueKeys"] = [list(model.key)]
    elif model.key:
        schema["primaryKey"] = list(model.key)
    foreign = [
        {"fields": list(columns), "reference": {"resource": table, "fields": list(columns)}}
        for table, columns in model.references.items()
        if table in present
    ]
    return {**schema, "foreignKeys": foreign} if foreign else schema


def _field(column: tables.Column) -> dict[str, Any]:
    constraints: dict[str, Any] = {} if column.nullable else {"required": True}
    if column.at_least is not None and column.at_least > -tables.LARGEST:
        constraints["minimum"] = column.at_least
    if column.at_most is not None and column.at_most < tables.LARGEST:
        constraints["maximum"] = column.at_most
    if column.allowed:
        constraints["enum"] = list(column.allowed)
    field = {
        "name": column.name,
        "type": _TYPES.get(column.type, column.type),
        "description": column.meaning_here,
        "unit": "" if column.unit == tables.BY_ROW else column.unit,
        "caveat": column.caveat,
        "constraints": constraints,
    }
    return {key: value for key, value in field.items() if value}
