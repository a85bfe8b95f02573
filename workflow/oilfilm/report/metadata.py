"""A campaign's tables described for other programs: a data package (Frictionless).

Names, types, units, meanings, caveats and keys come from the declaration of the tables. The same
tables give the same bytes: no clock, and everything in a fixed order. Paths are relative to the
folder of the tables, so that the folder can be moved.
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

_FRICTIONLESS_TYPE = {"text": "string", "texts": "array", "flag": "boolean"}
_SENTENCE_BY_DATA_KIND = {
    "simulated": "SIMULATED data: written by a program, not measured on a rig.",
    "measured": "Measured data.",
}
_NOT_STATED = "not stated"
_RAW_LOGS = Source(title="raw logs of the campaign; runs.parquet has the name and sha256 of each")


def data_package(settings: Settings, folder: Path, paths: Iterable[Path]) -> str:
    """The text of `datapackage.json` (Data Package standard, version 1).

    A table in several files has a list of paths. The standard has no key for the hash of each
    file, so the key `files` has path, hash, bytes and rows of every file.

    Args:
        settings: At least the campaign's name, data and description, and the dataset.
        folder: Folder of the tables.
        paths: The written tables in it, in any order.

    Raises:
        OilfilmError: A table is missing, damaged or was not written by oilfilm, or its footer and
            the campaign disagree on whether the data are simulated.
    """
    campaign = settings.campaign
    dataset = settings.dataset
    files_of_table = _files_of_tables(settings, folder, paths)
    licences = []
    if dataset.licence:
        key = "path" if "://" in dataset.licence else "name"
        licences.append({key: dataset.licence})
    sources = [_RAW_LOGS, *(dataset.sources or ())]
    descriptor = {
        # The standard allows fewer letters in a name than a campaign may have.
        "name": re.sub(r"[^a-z0-9._-]", "-", campaign.name.lower()),
        "title": dataset.title or f"Traction campaign {campaign.name}",
        "description": "\n".join(_description(settings)),
        "data": campaign.data,
        "licenses": licences,
        "contributors": [{"title": name, "role": "author"} for name in dataset.creators or ()],
        "sources": [
            _without_empty({"title": source.title, "path": source.address}) for source in sources
        ],
        "resources": [
            _resource(table, files, files_of_table) for table, files in files_of_table.items()
        ],
    }
    return json.dumps(_without_empty(descriptor), indent=2, ensure_ascii=False) + "\n"


def _files_of_tables(
    settings: Settings, folder: Path, paths: Iterable[Path]
) -> dict[str, list[dict[str, Any]]]:
    """Path, hash, bytes and rows of each file, by table in the order of their declarations.

    Raises:
        OilfilmError: As in `data_package`.
    """
    campaign = settings.campaign
    files_of_table: dict[str, list[dict[str, Any]]] = {
        table_name: [] for table_name in tables.TABLES
    }
    path_of_file = {path.relative_to(folder).as_posix(): path for path in paths}
    for path_below_folder, path in sorted(path_of_file.items()):
        footer = tables.read_footer(path)
        if footer["data"] != campaign.data:
            raise OilfilmError(
                f"{path_below_folder}: its footer says that the data are {footer['data']}, "
                f"campaign {campaign.name!r} that they are {campaign.data}. Delete it and run "
                "snakemake again."
            )
        file_record = {
            "path": path_below_folder,
            "hash": f"sha256:{file_digest(path)}",
            "bytes": path.stat().st_size,
            "rows": parquet.read_metadata(path).num_rows,
        }
        files_of_table[footer["table"]].append(file_record)
    return {table: files for table, files in files_of_table.items() if files}


def _description(settings: Settings) -> list[str]:
    """Sentences on the data, their licence and creators, and on logs that were changed."""
    campaign = settings.campaign
    dataset = settings.dataset
    creators = ", ".join(dataset.creators or ())
    sentences = [
        campaign.description,
        _SENTENCE_BY_DATA_KIND[campaign.data],
        f"Licence: {dataset.licence or _NOT_STATED}.",
        f"Creators: {creators or _NOT_STATED}.",
    ]
    for change in dataset.acknowledged_changes:
        log = f"{change.log} ({change.was}, now {change.now})"
        sentences.append(f"Changed after it was first read: {log}: {change.reason}")
    return sentences


def _without_empty(keys: dict[str, Any]) -> dict[str, Any]:
    """The keys that have a value: the standard allows no empty ones."""
    return {key: value for key, value in keys.items() if value not in ("", None, [], {})}


def _resource(
    table_name: str, files: Sequence[dict[str, Any]], table_names: Container[str]
) -> dict[str, Any]:
    """One table of the package.

    Args:
        table_name: Its name.
        files: Its files, as of `_files_of_tables`.
        table_names: Names of all tables in the package.
    """
    model = tables.TABLES[table_name]
    first_file = files[0]
    is_one_file = len(files) == 1
    resource = {
        "name": table_name,
        "type": "table",
        "description": model.full_description,
        "path": first_file["path"] if is_one_file else [file["path"] for file in files],
        "format": "parquet",
        "mediatype": "application/vnd.apache.parquet",
        "bytes": sum(file["bytes"] for file in files),
        "hash": first_file["hash"] if is_one_file else "",
        "rows": sum(file["rows"] for file in files),
        "files": files,
        "schema": _schema(model, table_names),
    }
    contents = _without_empty(resource)
    # columns that are in the names of the folders (`oil=4102`) and not in the files
    folders = first_file["path"].split("/")
    contents["partitions"] = [name.partition("=")[0] for name in folders if "=" in name]
    return contents


def _schema(model: tables.Table, table_names: Container[str]) -> dict[str, Any]:
    """Columns and keys; only keys to tables that are in the package."""
    # the standard forbids nulls in a primary key
    key_has_nulls = any(model[name].nullable for name in model.key)
    foreign_keys = [
        {"fields": list(columns), "reference": {"resource": table_name, "fields": list(columns)}}
        for table_name, columns in model.references.items()
        if table_name in table_names
    ]
    schema = {
        "fields": [_field(column) for column in model.columns],
        "uniqueKeys": [list(model.key)] if key_has_nulls else [],
        "primaryKey": [] if key_has_nulls else list(model.key),
        "foreignKeys": foreign_keys,
    }
    contents = _without_empty(schema)
    # an empty text is a value here
    contents["missingValues"] = []
    return contents


def _field(column: tables.Column) -> dict[str, Any]:
    """One column, with its unit and caveat beside what the standard has."""
    low = column.at_least
    high = column.at_most
    constraints = {
        "required": not column.nullable or None,
        "minimum": low if low is not None and low > -tables.LARGEST_NUMBER else None,
        "maximum": high if high is not None and high < tables.LARGEST_NUMBER else None,
        # the standard has no such key for the items of a list
        "enum": list(column.allowed) if column.type != "texts" else [],
    }
    field = {
        "name": column.name,
        "type": _FRICTIONLESS_TYPE.get(column.type, column.type),
        "description": column.meaning_here,
        "unit": "" if column.unit == tables.BY_ROW else column.unit,
        "caveat": column.caveat,
        "constraints": _without_empty(constraints),
    }
    return _without_empty(field)
