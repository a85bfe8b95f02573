"""What a command prints as JSON, each object as its schema has it."""

import json
from typing import Any

import jsonschema
import pytest

from campaigns import ROOT
from oilfilm.cli import main

SCHEMAS = ROOT / "workflow/schemas"


def printed_objects(
    capsys: pytest.CaptureFixture[str], command: str, *arguments: object
) -> list[dict[str, Any]]:
    """Run `oilfilm COMMAND --json`; the objects that it prints, one per line."""
    main([command, "--json", *map(str, arguments)])
    found = [json.loads(line) for line in capsys.readouterr().out.splitlines()]
    schema = json.loads((SCHEMAS / f"{command}.schema.json").read_text(encoding="utf-8"))
    for each in found:
        jsonschema.validate(each, schema)
    return found
