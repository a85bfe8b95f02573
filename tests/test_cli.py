"""`oilfilm check`: a verdict, a reason and an advice, in sentences."""

from pathlib import Path

import pytest

from campaigns import ROOT, Campaign
from oilfilm.cli import main

CONFIG = ["--config", str(ROOT / "config")]


def test_good_log_is_accepted(demo: Campaign, capsys: pytest.CaptureFixture[str]) -> None:
    log = demo.folder / "4102_P1.25_U25_T070.csv"
    assert main(["check", str(log), *CONFIG]) == 0
    assert "ACCEPTED, 31 of 31 plateaus" in capsys.readouterr().out


@pytest.mark.parametrize("gate", ["truncated", "stuck_sensor", "load_off_nominal", "thin_film"])
def test_bad_log_is_refused_with_reason_and_advice(
    demo: Campaign, capsys: pytest.CaptureFixture[str], gate: str
) -> None:
    name = demo.truth.set_index("gate").loc[gate, "run_id"]
    assert main(["check", str(demo.folder / str(name)), *CONFIG]) == 1
    said = capsys.readouterr().out
    assert "REFUSED" in said
    assert f"{gate}: " in said
    assert "  -> " in said


def test_file_that_is_no_log_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "photo.jpg"
    path.write_bytes(b"\xff\xd8\xff\xe0")
    assert main(["check", str(path), *CONFIG]) == 1
    assert "unknown_format: no reader knows this content" in capsys.readouterr().out


def test_mistakes_are_sentences(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["check", str(tmp_path / "nothing.csv"), *CONFIG]) == 2
    assert "nothing.csv: cannot be read" in capsys.readouterr().err
    assert main(["check", "x", "--campaign", "no-such-campaign", *CONFIG]) == 2
    assert "no such campaign file" in capsys.readouterr().err
