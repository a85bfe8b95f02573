"""The finished tables of a campaign are read when they are used, and only those that are listed."""

from pathlib import Path

import pandas as pd
import pytest

from oilfilm import tables
from oilfilm.errors import OilfilmError
from oilfilm.tables.campaign_tables import CampaignTables

PROVENANCE = {"campaign": "june", "data": "measured"}
RUNS = pd.DataFrame({"run_id": ["a.csv"]})


class Inputs(dict[str, str | list[str]]):
    """Named inputs as Snakemake gives them."""


def test_table_is_read_when_it_is_used_and_a_table_without_files_is_empty(tmp_path: Path) -> None:
    path = tmp_path / "torque.parquet"
    results = CampaignTables.of_job(Inputs(torque=[], points=str(path), claims="claims.yaml"))
    pd.testing.assert_frame_equal(results.torque, tables.empty("torque"))
    with pytest.raises(OilfilmError, match="there is no such table"):
        results.points  # noqa: B018
    tables.write(tables.empty("points"), "points", path, PROVENANCE)
    assert results.points.empty


def test_table_that_the_rule_does_not_list_is_refused_by_its_name() -> None:
    results = CampaignTables.of_job(Inputs(torque=[], runs=[]))
    with pytest.raises(OilfilmError, match=r"'points' is not among the inputs.*runs, torque"):
        results.points  # noqa: B018


def test_campaign_without_torque_logs_has_empty_tables_of_torque(tmp_path: Path) -> None:
    results = CampaignTables.in_folder(tmp_path)
    assert results.torque_quarantine.empty
    with pytest.raises(OilfilmError, match=r"coefficients\.parquet: there is no such table"):
        results.coefficients  # noqa: B018
