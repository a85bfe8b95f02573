"""What a command prints as JSON."""

import json
from typing import Any

import pytest

from oilfilm.cli import main


def printed_objects(
    capsys: pytest.CaptureFixture[str], command: str, *arguments: object
) -> list[dict[str, Any]]:
    """Run `oilfilm COMMAND --json`; the objects that it prints, one per line."""
    main([command, "--json", *map(str, arguments)])
    return [json.loads(line) for line in capsys.readouterr().out.splitlines()]
