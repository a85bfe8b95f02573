"""`make audit`: what the search for known weaknesses says of its findings, and of being offline."""

import json
import sys
from pathlib import Path

import pytest
from lint import advisories

from campaigns import ROOT

VULNERABLE = {
    "dependencies": [
        {"name": "safe", "version": "1.0", "vulns": []},
        {
            "name": "weak",
            "version": "2.0",
            "vulns": [{"id": "PYSEC-2026-1", "fix_versions": ["2.1"]}],
        },
    ]
}
UNKNOWN = {"dependencies": [{"name": "safe", "skip_reason": "Dependency not found"}]}


def answers(folder: Path, text: str) -> str:
    """A program that prints a text whatever it is asked."""
    program = folder / "pip-audit"
    program.write_text(f"#!/bin/sh\ncat <<'END'\n{text}\nEND\nexit 1\n", encoding="utf-8")
    program.chmod(0o755)
    return str(program)


@pytest.mark.skipif(sys.platform == "win32", reason="the stand-in is a shell script")
@pytest.mark.parametrize(
    ("text", "printed", "here", "on_github"),
    [
        (json.dumps(VULNERABLE), "weak 2.0: PYSEC-2026-1, mended in 2.1", 1, 1),
        ("", "NOT CHECKED: they cannot be reached", 0, 1),
        (json.dumps(UNKNOWN), "NOT CHECKED: they cannot be reached", 0, 1),
    ],
    ids=["advisory", "offline", "nothing known"],
)
def test_advisory_fails_and_what_cannot_be_asked_is_said(
    text: str,
    printed: str,
    here: int,
    on_github: int,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    program = answers(tmp_path, text)
    monkeypatch.setattr(advisories, "LOCKS", [ROOT / "requirements.lock"])
    monkeypatch.delenv("CI", raising=False)
    assert advisories.main(program) == here
    assert f"requirements.lock: {printed}" in capsys.readouterr().out.replace("advisories ", "")
    monkeypatch.setenv("CI", "true")
    assert advisories.main(program) == on_github


def test_advisory_with_a_reason_is_printed_with_it(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(advisories, "LOCKS", [ROOT / "requirements.lock"])
    monkeypatch.setattr(advisories, "HARMLESS", {"PYSEC-2026-1": "not used"})
    assert advisories.main(answers(tmp_path, json.dumps(VULNERABLE))) == 0
    assert "(harmless: not used)" in capsys.readouterr().out
