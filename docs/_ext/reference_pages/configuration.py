"""The reference pages of the keys of the configuration, one per kind of file, from the models."""

import json
from collections.abc import Iterator, Mapping
from typing import Any

from oilfilm.base import studies
from oilfilm.base.home import HOME
from oilfilm.settings.campaign import CampaignFile
from oilfilm.settings.config import Config
from oilfilm.settings.messages import KeyPath, plain_node, schema_of
from oilfilm.settings.rig import (
    AstmD341Coefficients,
    BearingFile,
    MeasuredViscosity,
    MilL7808Coefficients,
    MilL23699Coefficients,
    OilKeys,
    Rig,
)
from oilfilm.settings.yaml_file import dotted_key, read_yaml

_OIL_NOTE = "The keys below `coefficients` depend on `model`."
# Page -> file, what it is for, and its models by their headings.
PAGES: dict[str, tuple[str, str, dict[str, Any]]] = {
    "config": (
        "config/config.yaml",
        "Every threshold and choice of the workflow. The file that comes with the project has good "
        "values for all of them; a campaign overrides single ones under `settings`.",
        {"": Config},
    ),
    "campaigns": (
        "config/campaigns/<name>.yaml",
        "One campaign: its logs, rigs, oils and figures, and settings of its own.",
        {"": CampaignFile},
    ),
    "rigs": (
        "config/rigs/<name>.yaml",
        "Geometry, materials and roughness of a rig, and the full scale of its sensors.",
        {"": Rig},
    ),
    "oils": (
        "config/oils/<id>.yaml",
        "Properties of an oil, which the film thickness needs. " + _OIL_NOTE,
        {
            "": OilKeys,
            "coefficients, model adore-mil-l-7808": MilL7808Coefficients,
            "coefficients, model adore-mil-l-23699": MilL23699Coefficients,
            "coefficients, model astm-d341": AstmD341Coefficients,
            "coefficients, models walther, vogel, roelands": MeasuredViscosity,
        },
    ),
    "bearings": ("config/bearings/<name>.yaml", "Geometry of a bearing.", {"": BearingFile}),
}
# Study -> the same for its settings.
OF_STUDIES = {
    study: (
        f"workflow/{study}/config.yaml",
        f"Settings of the study `{study}`. A project's `config.yaml`, or `settings` of a campaign, "
        f"changes single ones under `studies: {{{study}: ...}}`.",
        {"": studies.settings_module(study).StudySettings},
    )
    for study in studies.available()
    if studies.settings_file(study).is_file()
}


def index() -> str:
    """The page that says which file has which keys."""
    rows = [
        f"| [`{file}`](configuration/{page}.md) | {about} |"
        for page, (file, about, _) in PAGES.items()
    ]
    lines = [
        "# Settings\n",
        "For users who set up a campaign. Look up each key: meaning, unit, default and range.\n",
        "Each YAML file of `config` describes one thing. Most projects write a campaign and a rig,",
        "and leave the rest as it comes. `oilfilm init` writes both files from your logs.\n",
        "| file | what it holds |\n| --- | --- |",
        *rows,
        "\nA value outside its range, as of another unit, is refused with file, line and key.",
        "A key that does not exist is refused with the nearest one that does.",
    ]
    return "\n".join(lines) + "\n"


def page(name: str) -> str:
    """All keys of one kind of file: meaning, default, unit and range."""
    file, about, models = (PAGES | OF_STUDIES)[name]
    # these files have a value for each of their keys
    has_every_key = (HOME / file).name == "config.yaml"
    shipped = read_yaml(HOME / file).values if has_every_key else {}
    parts = [f"# `{file}`\n", f"For users who write this file. Look up its keys.\n\n{about}\n"]
    for title, model in models.items():
        parts += [f"## `{title}`\n"] if title else []
        parts += _groups(schema_of(model), shipped, "###" if title else "##")
    package = file.split("/")[1] if name in OF_STUDIES else "oilfilm"
    note = f"This page is made from the models in `workflow/{package}` by `make schemas`."
    return "\n".join([*parts, f"{note}\n"])


def _groups(schema: Mapping[str, Any], shipped: Mapping[str, Any], level: str) -> Iterator[str]:
    """A list of the keys outside groups, then one with a heading per group."""
    lists: dict[str, list[str]] = {"": []}
    for key_path, node in _leaves(schema, schema, ()):
        group = str(key_path[0]) if len(key_path) > 1 else ""
        lists.setdefault(group, []).append(_item(key_path, node, shipped))
    for group, items in lists.items():
        if group:
            declared = schema["properties"][group.removesuffix("[]")]
            meaning = plain_node(declared, schema).get("description", "")
            yield f"{level} `{group}`\n\n{meaning}\n"
        if items:
            yield "\n".join(items) + "\n"


def _leaves(
    node: Mapping[str, Any], schema: Mapping[str, Any], key_path: KeyPath
) -> Iterator[tuple[KeyPath, Mapping[str, Any]]]:
    """The keys below a group that are no groups themselves."""
    for name, part in node.get("properties", {}).items():
        child = plain_node(part, schema)
        below = (*key_path, name)
        if child.get("type") == "array" and "properties" in plain_node(child["items"], schema):
            child, below = plain_node(child["items"], schema), (*key_path, f"{name}[]")
        elif isinstance(child.get("additionalProperties"), Mapping):
            child = plain_node(child["additionalProperties"], schema)
            below = (*below, "<name>")
        if "properties" in child:
            yield from _leaves(child, schema, below)
        else:
            yield below, child


def _item(key_path: KeyPath, node: Mapping[str, Any], shipped: Mapping[str, Any]) -> str:
    """One key: its meaning, then default, unit and range."""
    default: Any = shipped
    for step in key_path:
        default = default.get(step) if isinstance(default, Mapping) else None
    if default is None:
        default = node.get("default")
    unit, allowed = _innermost(node).get("unit", ""), range_text(node)
    facts = []
    if default not in (None, [], {}):
        facts.append(f"default `{json.dumps(default, ensure_ascii=False)}`")
    if unit not in ("", "1"):
        facts.append(f"unit {unit}")
    if allowed:
        facts.append(allowed)
    key = dotted_key(key_path)
    return f"- `{key}`: {node.get('description', '')} *{'; '.join(facts)}*".removesuffix(" **")


def _innermost(node: Mapping[str, Any]) -> Mapping[str, Any]:
    """The schema of the items of a list, or of a list of lists; of anything else itself."""
    while node.get("type") == "array" and isinstance(node.get("items"), Mapping):
        node = node["items"]
    return node


def range_text(node: Mapping[str, Any]) -> str:
    """The values that a key accepts, as the reference page shows them."""
    if node.get("type") == "array":
        if "prefixItems" in node:
            return "[" + ", ".join(range_text(item) for item in node["prefixItems"]) + "]"
        low, high = node.get("minItems", 0), node.get("maxItems")
        count = f"{low} or more" if high is None else str(low) if low == high else f"{low}-{high}"
        return f"list of {count}: {range_text(node.get('items', {}))}"
    if "enum" in node:
        return ", ".join(f"`{value}`" for value in node["enum"])
    if "const" in node:
        return f"`{node['const']}`"
    bounds = {"exclusiveMinimum": ">", "minimum": ">=", "exclusiveMaximum": "<", "maximum": "<="}
    limits = [f"{sign} {node[name]:g}" for name, sign in bounds.items() if name in node]
    kind = {"integer": "whole number", "boolean": "true or false", "string": "text"}
    return " ".join(
        part for part in (kind.get(node.get("type", ""), ""), ", ".join(limits)) if part
    )
