"""What a program prints, and what a command of oilfilm prints as JSON."""

import json
import subprocess
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest

from oilfilm.cli import main


def outcome(command: Sequence[str | Path], **where: Any) -> tuple[int, str]:
    """Run a program: its exit code, and all that it prints."""
    done = subprocess.run(command, capture_output=True, text=True, check=False, **where)
    return done.returncode, done.stdout + done.stderr


def succeeded(command: Sequence[str | Path], **where: Any) -> str:
    """Run a program, which must succeed; what it prints."""
    code, text = outcome(command, **where)
    assert (code, "Traceback" in text) == (0, False), f"{command}\n{text[-4000:]}"
    return text


def printed_objects(
    capsys: pytest.CaptureFixture[str], command: str, *arguments: object
) -> list[dict[str, Any]]:
    """Run `oilfilm COMMAND --json`; the objects that it prints, one per line."""
    main([command, "--json", *map(str, arguments)])
    return [json.loads(line) for line in capsys.readouterr().out.splitlines()]
