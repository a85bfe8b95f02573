"""The data package beside the tables: complete, true, valid, and the same twice."""

import json
import re
from importlib import import_module
from pathlib import Path
from typing import Any

import pandas
import pytest

from campaigns import ROOT
from oilfilm import tables
from oilfilm.base.digests import file_digest
from oilfilm.base.errors import OilfilmError
from oilfilm.report.metadata import data_package
from oilfilm.settings.resolved import Settings

SAMPLES = [f"samples/oil={oil}/part-{part}.parquet" for oil in ("4010", "4102") for part in (0, 1)]
DESCRIBED = ("samples", "runs", "points", "quarantine", "coverage", "torque", "heat_balance")
RESULTS_PAGE = (ROOT / "docs/reference/results.md").read_text(encoding="utf-8")
ONE_LINERS = re.findall(r"^(?:duckdb|pandas|polars)\..*$", RESULTS_PAGE, re.M)


def rows(table: str, count: int) -> pandas.DataFrame:
    """Rows that the table allows; the numbers mean nothing."""
    frame = {}
    for column in tables.TABLES[table].columns:
        text = (*column.allowed, "x")[0]
        of_type: dict[str, Any] = {"number": 1.0, "integer": 1, "flag": True, "text": text}
        of_type["texts"] = ()
        frame[column.name] = [of_type[column.type]] * count
    frame |= {key: range(1, count + 1) for key in ("first_row", "row") if key in frame}
    return tables.conform(pandas.DataFrame(frame), table, "made up")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("project") / "results/demo/tables"
    provenance = {"campaign": "laboratory", "data": "measured"}
    for number, path in enumerate(SAMPLES, start=1):
        tables.write(rows("samples", number), "samples", folder / path, provenance)
    for table in DESCRIBED[1:]:
        tables.write(rows(table, 1), table, folder / f"{table}.parquet", provenance)
    return folder


def package_of(folder: Path, settings: Settings) -> dict[str, Any]:
    """The package of every table in a folder; read by frictionless, which checks it."""
    files = [*folder.rglob("*.parquet")]
    package = json.loads(data_package(settings, folder, files))
    # imported where needed: it takes a third of a second
    described = import_module("frictionless").Package.from_descriptor(package)
    assert described.resource_names == [table for table in tables.TABLES if table in DESCRIBED]
    return package


@pytest.fixture(scope="module")
def package(folder: Path, config: Settings) -> dict[str, Any]:
    return package_of(folder, config)


def schema_of(package: dict[str, Any], table: str) -> dict[str, Any]:
    (resource,) = [each for each in package["resources"] if each["name"] == table]
    return resource["schema"]


def settings_with(about: dict[str, Any], data: str = "measured") -> Settings:
    """Settings of a campaign with this description of its data."""
    campaign = {"name": "demo", "data": data, "description": "A campaign."}
    return Settings.from_plain_values({"campaign": campaign, "dataset": about})


def test_columns_have_unit_meaning_caveat_and_bounds(package: dict[str, Any]) -> None:
    fields = {field["name"]: field for field in schema_of(package, "points")["fields"]}
    assert list(fields) == tables.columns("points")
    assert fields["load_n"]["unit"] == "N"
    assert fields["inlet_temperature_systematic_c"]["unit"] == "K"
    assert "calibration" in fields["traction_coefficient_se"]["caveat"]
    assert fields["film_judgement"]["constraints"]["enum"][0] == "full film"
    assert fields["lambda_ratio"]["constraints"] == {"minimum": 0}
    assert fields["run_id"]["constraints"] == {"required": True}
    assert "constraints" not in fields["traction_coefficient"]


def test_keys_are_the_tables_own(package: dict[str, Any], folder: Path, config: Settings) -> None:
    assert schema_of(package, "points")["primaryKey"] == ["run_id", "first_row"]
    assert schema_of(package, "points")["foreignKeys"] == [
        {"fields": ["run_id"], "reference": {"resource": "runs", "fields": ["run_id"]}}
    ]
    assert "primaryKey" not in schema_of(package, "quarantine")
    # nulls are allowed in it, which the standard forbids in a primary key
    assert "oil" in schema_of(package, "coverage")["uniqueKeys"][0]
    # a key to a table that is not there is left out
    alone = json.loads(data_package(config, folder, [folder / "points.parquet"]))
    assert "foreignKeys" not in alone["resources"][0]["schema"]


def test_hashes_sizes_and_rows_are_the_files_own(package: dict[str, Any], folder: Path) -> None:
    by_name = {each["name"]: each for each in package["resources"]}
    files = {file["path"]: file for each in by_name.values() for file in each["files"]}
    assert set(files) == {*SAMPLES, *(f"{table}.parquet" for table in DESCRIBED[1:])}
    for path, file in files.items():
        assert file["hash"] == f"sha256:{file_digest(folder / path)}"
        assert file["bytes"] == (folder / path).stat().st_size
    assert [files[path]["rows"] for path in SAMPLES] == [1, 2, 3, 4]
    assert by_name["samples"]["path"] == SAMPLES
    assert (by_name["samples"]["partitions"], by_name["samples"]["rows"]) == (["oil"], 10)
    assert by_name["points"]["hash"] == files["points.parquet"]["hash"]


def test_table_that_contradicts_its_campaign_is_refused(folder: Path) -> None:
    with pytest.raises(OilfilmError, match=r"data are measured.*that they are simulated"):
        package_of(folder, settings_with({}, data="simulated"))


def test_licence_creators_and_sources_are_stated(package: dict[str, Any], folder: Path) -> None:
    assert package["licenses"] == [{"name": "MIT"}]
    assert [each["title"] for each in package["contributors"]] == ["the oilfilm developers"]
    assert package["sources"][1]["path"] == "https://example.org/oils"
    assert not {"licenses", "contributors"} & set(package_of(folder, settings_with({})))


def test_same_tables_give_the_same_bytes(folder: Path, config: Settings) -> None:
    files = [*folder.rglob("*.parquet")]
    text = data_package(config, folder, files)
    assert text == data_package(config, folder, files[::-1])
    assert str(folder) not in text


@pytest.mark.parametrize("one_liner", ONE_LINERS, ids=["duckdb", "pandas", "polars"])
def test_one_liner_of_the_docs_opens_the_table(
    folder: Path, monkeypatch: pytest.MonkeyPatch, one_liner: str
) -> None:
    monkeypatch.chdir(folder.parents[2])
    library = one_liner.partition(".")[0]
    frame = eval(one_liner, {library: import_module(library)})
    assert list(frame.columns) == [*tables.columns("samples"), "oil"]
    assert len(frame) == 10
