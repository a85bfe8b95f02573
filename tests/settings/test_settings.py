"""Settings as objects: the parts that a rule lists."""

import json
import os
from pathlib import Path

import pytest

from campaigns import without
from oilfilm.errors import OilfilmError
from oilfilm.settings.campaign import CampaignFile, Semantics
from oilfilm.settings.messages import load
from oilfilm.settings.resolved import Settings


def test_part_that_a_rule_lists_is_the_same_after_the_job_has_read_it(config: Settings) -> None:
    part = config.part("gates", "oils", campaign=("twin", "torque", "header"))
    assert set(part) == {"campaign", "gates", "oils"}
    assert set(part["campaign"]) == {"name", "data", "twin", "torque", "header"}
    handed_over = json.loads(json.dumps(part))
    settings = Settings.of(handed_over)
    assert settings.plain() == part
    assert settings.gates == config.gates
    assert settings.campaign.twin == config.campaign.twin
    assert settings.oils["4102"] == config.oils["4102"]


def test_key_left_out_has_its_default_only_where_the_rule_lists_it(config: Settings) -> None:
    measured = without(config, "twin", "torque", "semantics")
    assert measured.campaign.twin is None
    listed = Settings.of(measured.part(campaign=("oils", "twin", "semantics"))).campaign
    assert (listed.twin, listed.semantics) == (None, Semantics())
    with pytest.raises(AttributeError, match="torque"):
        _ = listed.torque


def test_changed_settings_are_checked_and_leave_the_others_alone(config: Settings) -> None:
    changed = config.with_changes({"fit": {"bootstrap": 20}})
    assert (changed.fit.bootstrap, changed.fit.searches) == (20, config.fit.searches)
    assert config.fit.bootstrap == 1000
    with pytest.raises(OilfilmError, match=r"`fit.bootstrap`: found 1, expected 20 or more"):
        config.with_changes({"fit": {"bootstrap": 1}})


def test_file_of_settings_that_is_large_or_a_pipe_is_refused_at_once(tmp_path: Path) -> None:
    (tmp_path / "large.yaml").write_text("key: {}\n" * 100_000)
    os.mkfifo(tmp_path / "pipe.yaml")
    for path in tmp_path.iterdir():
        with pytest.raises(OilfilmError, match="a plain file of at most 524288 bytes"):
            load(path, CampaignFile)
