"""Logs of a laboratory that shares no code with the library; `make bench NAME=blind` takes ten."""

from pathlib import Path

import pytest

from blind_check import Outcome, curated, outcome, settings_of, with_fits
from blind_lab.laboratory import Laboratory, build
from campaigns import ROOT
from oilfilm.curation.curate import CuratedTables


@pytest.fixture(scope="module")
def laboratory(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Laboratory]:
    project = tmp_path_factory.mktemp("laboratory")
    return project, build(project, ROOT / "config", seed=1, levels=2)


@pytest.fixture(scope="module")
def verdicts(laboratory: tuple[Path, Laboratory]) -> CuratedTables:
    return curated(laboratory[0], settings_of(laboratory[0]))


@pytest.fixture(scope="module")
def result(laboratory: tuple[Path, Laboratory], verdicts: CuratedTables) -> Outcome:
    return outcome(laboratory[1], verdicts)


@pytest.mark.slow
def test_no_sound_log_is_refused_and_every_row_of_it_is_used(
    laboratory: tuple[Path, Laboratory], verdicts: CuratedTables, result: Outcome
) -> None:
    assert result.false_alarms == []
    assert result.refused_points <= 0.0005
    rows = verdicts.runs.set_index("file")[["samples", "refused_rows"]]
    for log in laboratory[1].sound:
        assert rows.loc[log.file].tolist() == [log.rows, 0]


@pytest.mark.slow
def test_faults_are_stopped_or_named_with_a_right_reason(result: Outcome) -> None:
    assert result.faults >= 60
    assert result.misnamed == []
    # a whole curve that is too low may be the oil, and steps with a slow filter are uncertain
    assert set(result.silent) <= {"force in lbf, labelled N", "filter of 1.5 s"}


@pytest.mark.nightly
def test_constants_and_traction_of_the_sound_logs_are_the_true_ones(tmp_path: Path) -> None:
    lab = build(tmp_path, ROOT / "config", seed=1)
    settings = settings_of(tmp_path)
    verdicts = curated(tmp_path, settings)
    result = outcome(lab, verdicts)
    changed = settings.with_changes({"fit": {"bootstrap": 200, "searches": 2}})
    with_fits(result, lab, verdicts, changed)
    # 36 intervals of 95 %: fewer than 30 inside happen once in 30 000 laboratories
    assert sum(result.inside) >= 30
    assert max(result.rms.values()) < 0.01


@pytest.mark.nightly
@pytest.mark.parametrize("seed", range(2, 6))
def test_none_of_the_sound_logs_of_other_laboratories_is_refused(tmp_path: Path, seed: int) -> None:
    """Four laboratories with 81 sound logs each."""
    lab = build(tmp_path, ROOT / "config", seed, faults=False)
    result = outcome(lab, curated(tmp_path, settings_of(tmp_path)))
    assert len(lab.sound) == 81
    assert (result.false_alarms, result.misnamed) == ([], [])
    assert result.refused_points <= 0.0005
