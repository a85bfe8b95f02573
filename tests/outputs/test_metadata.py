"""The descriptions beside the tables: complete, true, valid, and the same twice."""

import json
import re
from collections.abc import Callable
from pathlib import Path
from typing import Any

import duckdb
import pandas
import polars
import pytest
from frictionless import Package
from rdflib import RDF, Graph, Literal, URIRef
from rdflib.namespace import DCAT, DCTERMS, RDFS, SDO, SKOS

from campaigns import ROOT
from oilfilm import tables
from oilfilm.digests import file_digest
from oilfilm.errors import OilfilmError
from oilfilm.outputs.metadata import (
    Dataset,
    Vocabulary,
    data_package,
    describe,
    linked_data,
    read_vocabulary,
    table_file,
)
from oilfilm.settings.load import resolve

# rdflib's own reader of JSON-LD still uses a class that rdflib has deprecated.
pytestmark = pytest.mark.filterwarnings("ignore:ConjunctiveGraph is deprecated")

VOCABULARY = ROOT / "data/reference/vocabulary.ttl"
SAMPLES = [f"samples/oil={oil}/part-{part}.parquet" for oil in ("4010", "4102") for part in (0, 1)]
RIG = ("runs", "points", "quarantine", "coefficients", "fit_quality")
BEARING = ("torque_runs", "torque", "cage_slip", "slip_advice", "size_effect")
WHOLE = (*RIG, *BEARING)
DESCRIBED = ("samples", *WHOLE)
HOSTILE = 'two "quotes", </script><script>alert(1)</script> \\ and\na line; <b>µ</b>'
ONE_LINERS = re.findall(
    r"^(?:duckdb|pandas|polars)\..*$", (ROOT / "docs/results.md").read_text(encoding="utf-8"), re.M
)


def rows(table: str, count: int) -> pandas.DataFrame:
    """Rows that the table's model accepts; the numbers mean nothing."""
    frame = {}
    for column in tables.TABLES[table].columns:
        text = (*column.allowed, "" if column.name == "failed_gates" else "x")[0]
        of_type: dict[str, Any] = {"number": 1.0, "integer": 1, "flag": True, "text": text}
        frame[column.name] = [of_type[column.type]] * count
    frame |= {key: range(1, count + 1) for key in ("first_row", "row") if key in frame}
    return tables.conform(pandas.DataFrame(frame), table, "made up")


def written(folder: Path, data: str = "simulated") -> Path:
    provenance = {"campaign": "demo", "data": data}
    for number, path in enumerate(SAMPLES, start=1):
        tables.write(rows("samples", number), "samples", folder / path, provenance)
    for table in WHOLE:
        tables.write(rows(table, 1), table, folder / f"{table}.parquet", provenance)
    return folder


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return written(tmp_path_factory.mktemp("project") / "results/demo/tables")


@pytest.fixture(scope="module")
def vocabulary() -> Vocabulary:
    return read_vocabulary(VOCABULARY)


@pytest.fixture
def dataset(folder: Path, vocabulary: Vocabulary, config: dict[str, Any]) -> Dataset:
    return told(folder, vocabulary, config)


def told(folder: Path, vocabulary: Vocabulary, config: dict[str, Any]) -> Dataset:
    return describe(
        config, [table_file(path, folder) for path in folder.rglob("*.parquet")], vocabulary
    )


def with_campaign(config: dict[str, Any], about: dict[str, Any], **keys: Any) -> dict[str, Any]:
    return {"campaign": {**config["campaign"], **keys}, "dataset": about}


def parsed(text: str) -> Graph:
    return Graph().parse(data=text, format="json-ld", publicID="http://localhost/d/dataset.jsonld")


def local(path: str) -> URIRef:
    return URIRef(f"http://localhost/d/{path}")


def test_package_is_valid_by_the_library(dataset: Dataset) -> None:
    package = Package.from_descriptor(json.loads(data_package(dataset)))
    assert package.resource_names == list(DESCRIBED)
    broken = json.loads(data_package(dataset))
    broken["resources"][1]["bytes"] = "many"
    with pytest.raises(Exception, match="bytes"):
        Package.from_descriptor(broken)


@pytest.mark.parametrize("table", DESCRIBED)
def test_package_tells_every_column_as_the_contract_does(dataset: Dataset, table: str) -> None:
    package = json.loads(data_package(dataset))
    (resource,) = [each for each in package["resources"] if each["name"] == table]
    assert [
        (field["name"], field.get("unit", ""), field["description"], "constraints" not in field)
        for field in resource["schema"]["fields"]
    ] == [
        (column.name, column.unit, column.description, column.nullable)
        for column in tables.TABLES[table].columns
    ]


def test_package_has_the_types_that_the_files_have(dataset: Dataset, folder: Path) -> None:
    types = {"number": "float64", "integer": "int64", "boolean": "bool", "string": "str"}
    (points,) = [
        each for each in json.loads(data_package(dataset))["resources"] if each["name"] == "points"
    ]
    found = pandas.read_parquet(folder / "points.parquet").dtypes
    assert {field["name"]: types[field["type"]] for field in points["schema"]["fields"]} == {
        name: str(dtype) for name, dtype in found.items()
    }


def test_hashes_sizes_and_rows_are_those_of_the_files(dataset: Dataset, folder: Path) -> None:
    resources = json.loads(data_package(dataset))["resources"]
    files = {file["path"]: file for each in resources for file in each["files"]}
    assert set(files) == {*SAMPLES, *(f"{table}.parquet" for table in WHOLE)}
    for path, file in files.items():
        assert file["hash"] == f"sha256:{file_digest(folder / path)}"
        assert file["bytes"] == (folder / path).stat().st_size
    assert [files[path]["rows"] for path in SAMPLES] == [1, 2, 3, 4]
    by_name = {each["name"]: each for each in resources}
    assert by_name["samples"]["path"] == SAMPLES
    assert (by_name["samples"]["partitions"], by_name["samples"]["rows"]) == (["oil"], 10)
    assert by_name["points"]["hash"] == files["points.parquet"]["hash"]


def test_both_descriptions_say_that_data_are_simulated(dataset: Dataset) -> None:
    package = json.loads(data_package(dataset))
    assert package["data"] == "simulated"
    assert "SIMULATED" in package["description"]
    graph = parsed(linked_data(dataset))
    assert "SIMULATED" in str(graph.value(local(""), DCTERMS.description))
    origin = graph.value(local(""), DCTERMS.provenance)
    assert str(graph.value(origin, RDFS.label)).startswith("SIMULATED")


def test_measured_data_are_called_measured(
    tmp_path: Path, vocabulary: Vocabulary, config: dict[str, Any]
) -> None:
    measured = with_campaign(config, {}, data="measured")
    dataset = told(written(tmp_path, "measured"), vocabulary, measured)
    for text in (data_package(dataset), linked_data(dataset)):
        assert "Measured data." in text
        assert "simulated" not in text.replace(config["campaign"]["description"], "").lower()


def test_table_that_contradicts_its_campaign_is_refused(
    folder: Path, vocabulary: Vocabulary, config: dict[str, Any]
) -> None:
    measured = with_campaign(config, {}, data="measured")
    with pytest.raises(OilfilmError, match=r"data are simulated.*that they are measured"):
        told(folder, vocabulary, measured)


def test_licence_creators_and_sources_are_the_campaign_files(dataset: Dataset) -> None:
    package = json.loads(data_package(dataset))
    assert package["licenses"] == [{"name": "MIT"}]
    assert [each["title"] for each in package["contributors"]] == ["the oilfilm developers"]
    assert package["sources"][1]["path"] == "https://doi.org/10.3390/lubricants14010033"
    graph = parsed(linked_data(dataset))
    this = local("")
    assert graph.value(graph.value(this, DCTERMS.license), SDO.name) == Literal("MIT")
    assert graph.value(graph.value(this, SDO.creator), SDO.name) == Literal(
        "the oilfilm developers"
    )
    assert (this, DCTERMS.source, URIRef(package["sources"][1]["path"])) in graph


def test_what_the_campaign_file_leaves_out_is_not_stated(
    folder: Path, vocabulary: Vocabulary, config: dict[str, Any]
) -> None:
    dataset = told(folder, vocabulary, with_campaign(config, {}))
    package = json.loads(data_package(dataset))
    assert not {"licenses", "contributors"} & set(package)
    assert "Licence: not stated.\nCreators: not stated." in package["description"]
    graph = parsed(linked_data(dataset))
    assert "not stated" in str(graph.value(local(""), DCTERMS.description))
    assert not list(graph.objects(None, DCTERMS.license))


def test_licence_may_be_an_address(
    folder: Path, vocabulary: Vocabulary, config: dict[str, Any]
) -> None:
    address = "https://example.org/terms"
    dataset = told(folder, vocabulary, with_campaign(config, {"licence": address}))
    assert json.loads(data_package(dataset))["licenses"] == [{"path": address}]
    assert (local(""), DCTERMS.license, URIRef(address)) in parsed(linked_data(dataset))


@pytest.mark.parametrize(
    ("line", "complaint"),
    [
        ("licence: free for all", "`licence`: found 'free for all'.*SPDX"),
        ("creators: []", "`creators`"),
        ("sources: [{adress: 'https://example.org'}]", "Did you mean 'address'"),
    ],
)
def test_mistake_in_what_is_said_of_the_data_is_told(
    tmp_path: Path, line: str, complaint: str
) -> None:
    campaigns = tmp_path / "campaigns"
    campaigns.mkdir()
    (tmp_path / "config.yaml").write_bytes((ROOT / "config/config.yaml").read_bytes())
    template = (ROOT / "config/campaigns/template.yaml").read_text(encoding="utf-8")
    (campaigns / "june.yaml").write_text(f"{template}\n{line}\n", encoding="utf-8")
    with pytest.raises(OilfilmError, match=complaint):
        resolve(tmp_path, {"campaign": "june"})


def test_what_is_said_of_the_data_is_no_part_of_the_campaign(config: dict[str, Any]) -> None:
    # Else a corrected title would run every rule again.
    assert set(config["dataset"]) == {"title", "licence", "creators", "sources"}
    assert not set(config["dataset"]) & set(config["campaign"])


def test_hostile_text_stays_text(
    folder: Path, vocabulary: Vocabulary, config: dict[str, Any]
) -> None:
    about = {"title": HOSTILE, "creators": [HOSTILE], "sources": [{"title": HOSTILE}]}
    dataset = told(folder, vocabulary, with_campaign(config, about, description=HOSTILE))
    package = json.loads(data_package(dataset))
    assert package["title"] == HOSTILE
    assert package["description"].startswith(HOSTILE)
    Package.from_descriptor(package)
    text = linked_data(dataset)
    assert "</" not in text
    graph = parsed(text)
    assert graph.value(local(""), SDO.name) == Literal(HOSTILE)
    assert len(list(graph.subjects(RDF.type, DCAT.Dataset))) == 1


def test_name_that_a_package_may_not_have_is_written_otherwise(
    folder: Path, vocabulary: Vocabulary, config: dict[str, Any]
) -> None:
    dataset = told(folder, vocabulary, with_campaign(config, {}, name="Prüfung.1"))
    package = json.loads(data_package(dataset))
    assert (package["name"], package["title"]) == ("pr-fung.1", "Traction campaign Prüfung.1")
    Package.from_descriptor(package)


def test_linked_data_hold_every_file(dataset: Dataset, folder: Path) -> None:
    graph = parsed(linked_data(dataset))
    this = local("")
    assert {(this, RDF.type, kind) in graph for kind in (DCAT.Dataset, SDO.Dataset)} == {True}
    for path in (*SAMPLES, *(f"{table}.parquet" for table in WHOLE)):
        node = graph.value(predicate=DCAT.downloadURL, object=local(path))
        assert (this, DCAT.distribution, node) in graph
        assert (this, SDO.distribution, node) in graph
        assert str(graph.value(node, SDO.sha256)) == file_digest(folder / path)
        assert int(str(graph.value(node, DCAT.byteSize))) == (folder / path).stat().st_size


def test_linked_data_say_what_slip_speed_and_traction_are(dataset: Dataset) -> None:
    graph = parsed(linked_data(dataset))
    for column, unit in (
        ("slide_roll_ratio", "1"),
        ("entrainment_speed_m_s", "m/s"),
        ("traction_coefficient", "1"),
    ):
        node = local(f"dataset.jsonld#column/points/{column}")
        term = local(f"vocabulary.ttl#{column.removesuffix('_m_s')}")
        assert (local(""), SDO.variableMeasured, node) in graph
        assert (node, SDO.propertyID, term) in graph
        assert (node, SDO.unitText, Literal(unit)) in graph


def concepts() -> Graph:
    return Graph().parse(VOCABULARY, format="turtle", publicID=str(local("vocabulary.ttl")))


def test_every_term_is_defined_with_symbol_unit_and_columns() -> None:
    graph = concepts()
    found = set(graph.subjects(RDF.type, SKOS.Concept))
    assert len(found) > 8
    symbol = URIRef("http://qudt.org/schema/qudt/symbol")
    for concept in found:
        for about in (SKOS.prefLabel, SKOS.definition, SKOS.notation, SDO.unitText, symbol):
            assert graph.value(concept, about, any=True), f"{concept} lacks {about}"


def test_term_without_a_match_says_so() -> None:
    graph = concepts()
    matches = (SKOS.exactMatch, SKOS.closeMatch, SKOS.broadMatch)
    for concept in graph.subjects(RDF.type, SKOS.Concept):
        matched = [str(term) for match in matches for term in graph.objects(concept, match)]
        for ontology in ("tribAIn", "TriboDataFAIR"):
            named = ontology in str(graph.value(concept, SKOS.note))
            assert named or any(ontology in term for term in matched), f"{concept}: {ontology}"


def test_every_column_of_a_term_exists_and_has_its_unit(vocabulary: Vocabulary) -> None:
    graph = concepts()
    names = {name for table in DESCRIBED for name in tables.columns(table)}
    for ending, term in vocabulary.terms.items():
        concept = local(f"vocabulary.ttl#{term}")
        assert (concept, RDF.type, SKOS.Concept) in graph
        meant = [name for name in names if vocabulary.address(name) == f"vocabulary.ttl#{term}"]
        assert any(name.endswith(ending) for name in meant), f"no column ends in {ending}"
        assert {tables.unit_of(name) for name in meant} == {str(graph.value(concept, SDO.unitText))}


@pytest.mark.parametrize(
    ("column", "term"),
    [
        ("slide_roll_ratio", "slide_roll_ratio"),
        ("nominal_entrainment_speed_m_s", "entrainment_speed"),
        ("measured_film_thickness_um", "film_thickness"),
        ("axial_load_n", "axial_load"),  # of a bearing, not of a contact
        ("inner_max_hertz_pressure_gpa", "max_hertz_pressure"),
        ("measured_torque_n_m", "friction_torque"),
        ("measured_torque_n_m_se", None),
        ("traction_coefficient_se", None),  # the error of a coefficient is no coefficient
        ("load_systematic_n", None),
        ("run_id", None),
    ],
)
def test_column_means_the_term_that_its_name_ends_in(
    vocabulary: Vocabulary, column: str, term: str | None
) -> None:
    assert vocabulary.address(column) == (term and f"vocabulary.ttl#{term}")


def test_damaged_vocabulary_is_told(tmp_path: Path) -> None:
    path = tmp_path / "vocabulary.ttl"
    with pytest.raises(OilfilmError, match=r"vocabulary\.ttl: cannot be read"):
        read_vocabulary(path)
    path.write_text("this is no Turtle", encoding="utf-8")
    with pytest.raises(OilfilmError, match="cannot be read as Turtle"):
        read_vocabulary(path)
    prefix = "@prefix skos: <http://www.w3.org/2004/02/skos/core#> .\n"
    path.write_text(prefix + '<#a> skos:notation "s" . <#b> skos:notation "s" .', encoding="utf-8")
    with pytest.raises(OilfilmError, match="'s' stands at 'a' and at 'b'"):
        read_vocabulary(path)


@pytest.mark.parametrize("write", [data_package, linked_data])
def test_same_tables_give_the_same_bytes(
    folder: Path,
    vocabulary: Vocabulary,
    config: dict[str, Any],
    write: Callable[[Dataset], str],
) -> None:
    files = [table_file(path, folder) for path in sorted(folder.rglob("*.parquet"))]
    first = write(describe(config, files, vocabulary))
    assert first == write(describe(config, files[::-1], vocabulary))
    assert str(folder) not in first


@pytest.mark.parametrize("one_liner", ONE_LINERS)
@pytest.mark.parametrize("table", ["samples", "points"])
def test_one_liner_of_the_readme_opens_the_table(
    folder: Path, monkeypatch: pytest.MonkeyPatch, one_liner: str, table: str
) -> None:
    monkeypatch.chdir(folder.parents[2])
    if table == "points":
        one_liner = re.sub(r"samples(/\*)*(\.parquet)?", "points.parquet", one_liner)
    opened = eval(one_liner, {"duckdb": duckdb, "pandas": pandas, "polars": polars})
    partition = ["oil"] if table == "samples" else []
    assert list(opened.columns) == [*tables.columns(table), *partition]
    assert len(opened) == (10 if table == "samples" else 1)


def test_readme_shows_a_one_liner_for_each_program() -> None:
    assert [line.partition(".")[0] for line in ONE_LINERS] == ["duckdb", "pandas", "polars"]
    assert "arrow::open_dataset(" in (ROOT / "docs/results.md").read_text(encoding="utf-8")
