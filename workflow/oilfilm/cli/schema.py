"""The JSON schema of what `oilfilm check --json` prints; `make schemas` renews it."""

import json
from pathlib import Path

from oilfilm.cli.checked import CheckedLog

SCHEMA = Path(__file__).parents[3] / "workflow/schemas/check.schema.json"


def schema_text() -> str:
    """The JSON schema of one log."""
    schema = {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        **CheckedLog.model_json_schema(mode="serialization"),
    }
    return json.dumps(schema, indent=2) + "\n"


if __name__ == "__main__":
    SCHEMA.write_text(schema_text(), encoding="utf-8")
