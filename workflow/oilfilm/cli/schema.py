"""The JSON schemas of what `oilfilm COMMAND --json` prints; `make schemas` renews them."""

import json

from pydantic import BaseModel

from oilfilm.cli.checked import CheckedLog
from oilfilm.cli.diff import ComparedReleases
from oilfilm.cli.plan import PlannedTests
from oilfilm.cli.predict import PredictedTraction
from oilfilm.cli.verify import Verified
from oilfilm.home import HOME
from oilfilm.releases.nightly import NightlySummary

PRINTED: dict[str, type[BaseModel]] = {
    "check": CheckedLog,
    "predict": PredictedTraction,
    "plan": PlannedTests,
    "verify": Verified,
    "diff": ComparedReleases,
    "nightly": NightlySummary,
}
FOLDER = HOME / "workflow/schemas"


def schema_text(command: str) -> str:
    """The JSON schema of one object that a command prints."""
    schema = {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        **PRINTED[command].model_json_schema(mode="serialization"),
    }
    return json.dumps(schema, indent=2) + "\n"


if __name__ == "__main__":
    for name in PRINTED:
        (FOLDER / f"{name}.schema.json").write_text(schema_text(name), encoding="utf-8")
