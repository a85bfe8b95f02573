"""What a campaign's tables are, told to other programs.

Two descriptions of the same dataset lie beside the tables: a data package (Frictionless) and
linked data (DCAT and schema.org, as JSON-LD). Names, types, units and meanings of the columns come
from `tables`, the terms behind them from the vocabulary; neither is repeated here. The same tables
give the same bytes: no clock, and everything in a fixed order. Addresses are relative to the
folder of the tables, which can be moved as a whole.
"""

import json
import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pyarrow.parquet as parquet
from frictionless import Package, system
from rdflib import RDF, Graph, Literal, URIRef
from rdflib.namespace import DCAT, DCTERMS, FOAF, RDFS, SDO, SKOS, XSD, Namespace
from rdflib.term import Node

from oilfilm import tables
from oilfilm.digests import file_digest
from oilfilm.errors import OilfilmError

_SPDX = Namespace("http://spdx.org/rdf/terms#")
_MEDIA_TYPE = "application/vnd.apache.parquet"
_IANA = Namespace("https://www.iana.org/assignments/media-types/")
# Types of a column in memory -> those of a data package; any other is text.
_TYPES = {"float64": "number", "int64": "integer", "bool": "boolean"}
_ORIGIN = {
    "simulated": "SIMULATED data: written by a program, not measured on a rig.",
    "measured": "Measured data.",
}
_NOT_STATED = "not stated"
_RAW_LOGS = {"title": "raw logs of the campaign; runs.parquet has the name and sha256 of each"}


@dataclass(frozen=True)
class TableFile:
    """One Parquet file of the dataset; its path is relative to the folder of the tables."""

    table: str
    path: str
    data: str
    sha256: str
    bytes: int
    rows: int


@dataclass(frozen=True)
class Vocabulary:
    """The terms of the vocabulary file, by the end of the columns that mean them."""

    file: str
    terms: Mapping[str, str]

    def address(self, column: str) -> str | None:
        """The term that a column means, as an address; None for columns that mean none.

        Examples:
            >>> vocabulary = Vocabulary("vocabulary.ttl", {"load_n": "load"})
            >>> vocabulary.address("nominal_load_n")
            'vocabulary.ttl#load'
            >>> vocabulary.address("load_systematic_n") is None
            True
        """
        endings = [ending for ending in self.terms if column.endswith(ending)]
        return f"{self.file}#{self.terms[max(endings, key=len)]}" if endings else None


@dataclass(frozen=True)
class Dataset:
    """Everything that the two descriptions tell."""

    name: str
    title: str
    description: str
    data: str
    licence: str | None
    creators: tuple[str, ...]
    sources: tuple[Mapping[str, str], ...]
    files: tuple[TableFile, ...]
    vocabulary: Vocabulary

    def tables(self) -> dict[str, list[TableFile]]:
        """The files of each table, tables in the order of the contract."""
        return {
            table: found
            for table in tables.TABLES
            if (found := [file for file in self.files if file.table == table])
        }


def table_file(path: Path, folder: Path) -> TableFile:
    """What there is to tell about one written table.

    Raises:
        OilfilmError: The file is missing, damaged or was not written by oilfilm.
    """
    footer = tables.read_footer(path)
    tables.refuse_damaged(path)
    return TableFile(
        table=footer["table"],
        path=path.relative_to(folder).as_posix(),
        data=footer["data"],
        sha256=file_digest(path),
        bytes=path.stat().st_size,
        rows=parquet.read_metadata(path).num_rows,
    )


def read_vocabulary(path: Path) -> Vocabulary:
    """The vocabulary's terms, by the ends of columns (skos:notation) that mean them.

    Raises:
        OilfilmError: The file is missing or is no Turtle, or two terms claim the same columns.
    """
    try:
        graph = Graph().parse(data=path.read_bytes(), format="turtle", publicID="vocabulary:")
    except (OSError, SyntaxError) as error:
        raise OilfilmError(f"{path}: cannot be read as Turtle ({error}).") from error
    terms: dict[str, str] = {}
    for concept, ending in sorted(graph.subject_objects(SKOS.notation)):
        name = str(concept).rpartition("#")[2]
        if str(ending) in terms:
            raise OilfilmError(
                f"{path}: the notation {str(ending)!r} stands at {terms[str(ending)]!r} and at "
                f"{name!r}; keep one of them."
            )
        terms[str(ending)] = name
    return Vocabulary(path.name, terms)


def describe(
    config: Mapping[str, Any], files: Iterable[TableFile], vocabulary: Vocabulary
) -> Dataset:
    """The dataset that a campaign's tables are.

    Args:
        config: At least `campaign` and `dataset`, as `config.resolve` gives them.
        files: The written tables, in any order.
        vocabulary: The terms behind the columns.

    Raises:
        OilfilmError: A table says otherwise than the campaign whether its data are simulated.
    """
    campaign, about = config["campaign"], config["dataset"]
    in_order = tuple(sorted(files, key=lambda file: file.path))
    for file in in_order:
        if file.data != campaign["data"]:
            raise OilfilmError(
                f"{file.path}: says that its data are {file.data}, campaign {campaign['name']!r} "
                f"that they are {campaign['data']}. Delete it and run snakemake again."
            )
    licence, creators = about.get("licence"), tuple(about.get("creators", ()))
    told = (
        campaign["description"],
        _ORIGIN[campaign["data"]],
        f"Licence: {licence or _NOT_STATED}.",
        f"Creators: {', '.join(creators) or _NOT_STATED}.",
    )
    return Dataset(
        name=campaign["name"],
        title=about.get("title", f"Traction campaign {campaign['name']}"),
        description="\n".join(told),
        data=campaign["data"],
        licence=licence,
        creators=creators,
        sources=(_RAW_LOGS, *about.get("sources", ())),
        files=in_order,
        vocabulary=vocabulary,
    )


def data_package(dataset: Dataset) -> str:
    """The dataset as `datapackage.json` (Data Package standard, version 1).

    A table in several files has a list of paths, which the standard gives no place for a hash of
    each; `files` has path, hash, bytes and rows of every one.

    Raises:
        FrictionlessException: The package breaks the standard.
    """
    descriptor: dict[str, Any] = {
        # The standard allows fewer letters in a name than a campaign may have.
        "name": re.sub(r"[^a-z0-9._-]", "-", dataset.name.lower()),
        "title": dataset.title,
        "description": dataset.description,
        "data": dataset.data,
        "sources": [_source(source) for source in dataset.sources],
        "resources": [
            _resource(table, files, dataset.vocabulary) for table, files in dataset.tables().items()
        ],
    }
    if dataset.licence:
        descriptor["licenses"] = [_licence(dataset.licence)]
    if dataset.creators:
        descriptor["contributors"] = [
            {"title": creator, "role": "author"} for creator in dataset.creators
        ]
    package = Package.from_descriptor(descriptor)
    # otherwise a list of paths is written as a key that only frictionless knows
    with system.use_context(standards="v1"):
        return _json(package.to_descriptor())


def _source(source: Mapping[str, str]) -> dict[str, str]:
    path = {"path": source["address"]} if "address" in source else {}
    return {"title": source["title"], **path}


def _licence(licence: str) -> dict[str, str]:
    return {"path" if "://" in licence else "name": licence}


def _resource(table: str, files: list[TableFile], vocabulary: Vocabulary) -> dict[str, Any]:
    paths = [file.path for file in files]
    return {
        "name": table,
        "type": "table",
        "description": _meaning(table),
        "path": paths if len(paths) > 1 else paths[0],
        "partitions": _partitions(paths[0]),
        "format": "parquet",
        "mediatype": _MEDIA_TYPE,
        "bytes": sum(file.bytes for file in files),
        **({"hash": f"sha256:{files[0].sha256}"} if len(files) == 1 else {}),
        "rows": sum(file.rows for file in files),
        "files": [
            {
                "path": file.path,
                "hash": f"sha256:{file.sha256}",
                "bytes": file.bytes,
                "rows": file.rows,
            }
            for file in files
        ],
        "schema": {
            "fields": [
                _field(name, column, vocabulary) for name, column in _columns(table).items()
            ],
            # an empty text is a value here
            "missingValues": [],
        },
    }


def _partitions(path: str) -> list[str]:
    """Columns that the names of the folders carry, and the files do not."""
    return [part.partition("=")[0] for part in path.split("/") if "=" in part]


def _field(name: str, column: Any, vocabulary: Vocabulary) -> dict[str, Any]:
    field = {
        "name": name,
        "type": _TYPES.get(str(column.dtype), "string"),
        "description": column.description,
    }
    unit, term = tables.unit_of(name), vocabulary.address(name)
    if unit:
        field["unit"] = unit
    if term:
        field["rdfType"] = term
    if not column.nullable:
        field["constraints"] = {"required": True}
    return field


def _columns(table: str) -> dict[str, Any]:
    return {column.name: column for column in tables.TABLES[table].columns}


def _meaning(table: str) -> str:
    model = tables.TABLES[table]
    return " ".join(filter(None, (model.description, model.caveats)))


def linked_data(dataset: Dataset) -> str:
    """The dataset as JSON-LD in the terms of DCAT and schema.org."""
    graph = Graph()
    this = URIRef("./")
    _tell(
        graph,
        this,
        (RDF.type, [DCAT.Dataset, SDO.Dataset]),
        (DCTERMS.identifier, [Literal(dataset.name)]),
        (DCTERMS.title, [Literal(dataset.title)]),
        (SDO.name, [Literal(dataset.title)]),
        (DCTERMS.description, [Literal(dataset.description)]),
        (SDO.description, [Literal(dataset.description)]),
        (DCTERMS.provenance, [URIRef("#origin")]),
        (SDO.keywords, [Literal(dataset.data)]),
    )
    _tell(
        graph,
        URIRef("#origin"),
        (RDF.type, [DCTERMS.ProvenanceStatement]),
        (RDFS.label, [Literal(_ORIGIN[dataset.data])]),
    )
    _tell_rights(graph, this, dataset.licence)
    _tell_named(graph, this, dataset)
    for file in dataset.files:
        _tell_file(graph, this, file)
    for table in dataset.tables():
        _tell_quantities(graph, this, table, dataset.vocabulary)
    return _sorted_json_ld(graph)


def _tell(graph: Graph, subject: Node, *statements: tuple[Node, list[Any]]) -> None:
    for predicate, objects in statements:
        for thing in objects:
            graph.add((subject, predicate, thing))


def _tell_rights(graph: Graph, this: URIRef, licence: str | None) -> None:
    if licence is None:
        statement = Literal(f"Licence: {_NOT_STATED}.")
        graph.add((this, DCTERMS.rights, URIRef("#rights")))
        _tell(
            graph,
            URIRef("#rights"),
            (RDF.type, [DCTERMS.RightsStatement]),
            (RDFS.label, [statement]),
        )
        return
    node = URIRef(licence if "://" in licence else "#licence")
    _tell(graph, this, (DCTERMS.license, [node]), (SDO.license, [node]))
    _tell(
        graph,
        node,
        (RDF.type, [DCTERMS.LicenseDocument, SDO.CreativeWork]),
        (SDO.name, [Literal(licence)]),
    )


def _tell_named(graph: Graph, this: URIRef, dataset: Dataset) -> None:
    """Creators and sources: things of which little more than a name is known."""
    for number, creator in enumerate(dataset.creators, start=1):
        node = URIRef(f"#creator-{number}")
        _tell(graph, this, (DCTERMS.creator, [node]), (SDO.creator, [node]))
        name = Literal(creator)
        _tell(graph, node, (RDF.type, [FOAF.Agent]), (FOAF.name, [name]), (SDO.name, [name]))
    for number, source in enumerate(dataset.sources, start=1):
        node = URIRef(source.get("address", f"#source-{number}"))
        _tell(graph, this, (DCTERMS.source, [node]), (SDO.isBasedOn, [node]))
        graph.add((node, RDFS.label, Literal(source["title"])))


def _tell_file(graph: Graph, this: URIRef, file: TableFile) -> None:
    node, checksum = URIRef(f"#file/{file.path}"), URIRef(f"#sha256/{file.path}")
    _tell(graph, this, (DCAT.distribution, [node]), (SDO.distribution, [node]))
    _tell(
        graph,
        node,
        (RDF.type, [DCAT.Distribution, SDO.DataDownload]),
        (DCTERMS.title, [Literal(file.table)]),
        (DCTERMS.description, [Literal(_meaning(file.table))]),
        (DCAT.downloadURL, [URIRef(file.path)]),
        (SDO.contentUrl, [URIRef(file.path)]),
        (DCAT.mediaType, [_IANA[_MEDIA_TYPE]]),
        (SDO.encodingFormat, [Literal(_MEDIA_TYPE)]),
        (DCAT.byteSize, [Literal(str(file.bytes), datatype=XSD.nonNegativeInteger)]),
        (SDO.contentSize, [Literal(f"{file.bytes} B")]),
        (_SPDX.checksum, [checksum]),
        (SDO.sha256, [Literal(file.sha256)]),
    )
    _tell(
        graph,
        checksum,
        (RDF.type, [_SPDX.Checksum]),
        (_SPDX.algorithm, [_SPDX.checksumAlgorithm_sha256]),
        (_SPDX.checksumValue, [Literal(file.sha256, datatype=XSD.hexBinary)]),
    )


def _tell_quantities(graph: Graph, this: URIRef, table: str, vocabulary: Vocabulary) -> None:
    """The columns that mean a term of the vocabulary."""
    for name, column in _columns(table).items():
        term = vocabulary.address(name)
        if term is None:
            continue
        node = URIRef(f"#column/{table}/{name}")
        graph.add((this, SDO.variableMeasured, node))
        _tell(
            graph,
            node,
            (RDF.type, [SDO.PropertyValue]),
            (SDO.name, [Literal(name)]),
            (SDO.description, [Literal(column.description)]),
            (SDO.unitText, [Literal(tables.unit_of(name))]),
            (SDO.propertyID, [URIRef(term)]),
        )


def _sorted_json_ld(graph: Graph) -> str:
    prefixes = {
        "dcat": DCAT,
        "dcterms": DCTERMS,
        "foaf": FOAF,
        "rdfs": RDFS,
        "schema": SDO,
        "spdx": _SPDX,
        "xsd": XSD,
    }
    context = {prefix: str(address) for prefix, address in prefixes.items()}
    document = json.loads(graph.serialize(format="json-ld", context=context))
    # Such a description is often pasted into a web page, where "</script>" would end it.
    return _json(_in_order(document)).replace("</", "<\\/")


def _in_order(value: Any) -> Any:
    """The same JSON with keys and lists sorted; no list of the document has an order of its own."""
    if isinstance(value, dict):
        return {key: _in_order(value[key]) for key in sorted(value)}
    if isinstance(value, list):
        return sorted(map(_in_order, value), key=lambda item: json.dumps(item, sort_keys=True))
    return value


def _json(value: Any) -> str:
    return json.dumps(value, indent=2, ensure_ascii=False) + "\n"
