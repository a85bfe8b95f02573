"""JSON schemas of the files in `config`, for editors."""

import json
from typing import Any

from oilfilm.base import studies
from oilfilm.base.figure_catalogue import figures
from oilfilm.settings.campaign import CampaignFile
from oilfilm.settings.config import Config
from oilfilm.settings.messages import schema_of
from oilfilm.settings.rig import BearingFile, OilFile, Rig

FILES: dict[str, Any] = {
    "config": Config,
    "campaign": CampaignFile,
    "rig": Rig,
    "oil": OilFile,
    "bearing": BearingFile,
}
# Models of the settings of studies by the file that has the schema.
OF_STUDIES = {
    f"workflow/{study}/config.schema.json": studies.settings_module(study).StudySettings
    for study in studies.available()
    if studies.settings_file(study).is_file()
}
_DIALECT = {"$schema": "https://json-schema.org/draft/2020-12/schema"}


def of_study(path: str) -> str:
    """The JSON schema of the settings of a study, on one line."""
    schema = _for_editors(schema_of(OF_STUDIES[path])) | _DIALECT
    return json.dumps(schema, ensure_ascii=False) + "\n"


def of_file(name: str) -> str:
    """The JSON schema of a file of settings, on one line."""
    schema = _for_editors(schema_of(FILES[name])) | _DIALECT
    if name == "config":
        # a project's file has only what differs from the one that comes with oilfilm
        for group in (schema, *schema["$defs"].values()):
            group.pop("required", None)
    if name == "campaign":
        schema["properties"]["figures"]["items"]["enum"] = list(figures())
        schema["properties"]["studies"]["items"]["enum"] = list(studies.available())
    return json.dumps(schema, ensure_ascii=False) + "\n"


def _for_editors(node: Any) -> Any:
    """A schema without pydantic's titles and without null, which YAML files must not hold."""
    if isinstance(node, list):
        return [_for_editors(part) for part in node]
    if not isinstance(node, dict):
        return node
    if "anyOf" in node:
        branches = [branch for branch in node["anyOf"] if branch != {"type": "null"}]
        others = {name: part for name, part in node.items() if name != "anyOf"}
        node = {**branches[0], **others} if len(branches) == 1 else {**others, "anyOf": branches}
    return {
        name: _for_editors(part)
        for name, part in node.items()
        if not (name == "title" and isinstance(part, str)) and not (name == "default" and not part)
    }
