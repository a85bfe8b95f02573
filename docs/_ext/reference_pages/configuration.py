"""The reference page of all keys of the configuration, generated from the models."""

import json
from collections.abc import Iterator, Mapping
from typing import Any

from oilfilm.home import HOME
from oilfilm.settings.bearing import BearingFile
from oilfilm.settings.campaign import CampaignFile
from oilfilm.settings.config import Config
from oilfilm.settings.messages import Steps, plain_node, schema_of
from oilfilm.settings.oil import (
    AstmD341Coefficients,
    MilL7808Coefficients,
    MilL23699Coefficients,
    OilKeys,
)
from oilfilm.settings.rig import Rig
from oilfilm.settings.yaml_file import dotted, read_yaml

_SECTIONS: dict[str, Any] = {
    "`config/config.yaml`": Config,
    "`config/campaigns/<name>.yaml`": CampaignFile,
    "`config/rigs/<name>.yaml`": Rig,
    "`config/oils/<id>.yaml`": OilKeys,
    "`coefficients` of an oil with `model: adore-mil-l-7808`": MilL7808Coefficients,
    "`coefficients` of an oil with `model: adore-mil-l-23699`": MilL23699Coefficients,
    "`coefficients` of an oil with `model: astm-d341`": AstmD341Coefficients,
    "`config/bearings/<name>.yaml`": BearingFile,
}
_PAGE_BEGINS = """# All keys of the configuration

Generated from the models in `workflow/oilfilm/settings` by `make schemas`; do not edit.
A value outside its range, as of another unit, is refused with file, line and key.
The default of a key of `config/config.yaml` is its value in the file that comes with the project.
"""
_TABLE_BEGINS = "| key | default | unit | range | meaning |\n| --- | --- | --- | --- | --- |"


def page() -> str:
    """All keys with default, unit, range and meaning, as Markdown."""
    shipped = read_yaml(HOME / "config/config.yaml").values
    parts = [_PAGE_BEGINS]
    for title, model in _SECTIONS.items():
        parts.append(f"## {title}\n")
        parts += _tables(schema_of(model), shipped if model is Config else {})
    return "\n".join(parts)


def _tables(schema: Mapping[str, Any], shipped: Mapping[str, Any]) -> Iterator[str]:
    """A table of the keys outside groups, then one with a heading per group."""
    tables: dict[str, list[str]] = {"": []}
    for steps, node in _leaves(schema, schema, ()):
        group = str(steps[0]) if len(steps) > 1 else ""
        tables.setdefault(group, []).append(_row(steps, node, shipped))
    for group, rows in tables.items():
        if group:
            declared = schema["properties"][group.removesuffix("[]")]
            meaning = plain_node(declared, schema).get("description", "")
            yield f"### `{group}`\n\n{meaning}\n"
        if rows:
            yield "\n".join([_TABLE_BEGINS, *rows]) + "\n"


def _leaves(
    node: Mapping[str, Any], schema: Mapping[str, Any], steps: Steps
) -> Iterator[tuple[Steps, Mapping[str, Any]]]:
    """The keys below a group that are no groups themselves."""
    for name, part in node.get("properties", {}).items():
        child = plain_node(part, schema)
        below = (*steps, name)
        if child.get("type") == "array" and "properties" in plain_node(child["items"], schema):
            child, below = plain_node(child["items"], schema), (*steps, f"{name}[]")
        elif isinstance(child.get("additionalProperties"), Mapping):
            child = plain_node(child["additionalProperties"], schema)
            below = (*below, "<name>")
        if "properties" in child:
            yield from _leaves(child, schema, below)
        else:
            yield below, child


def _row(steps: Steps, node: Mapping[str, Any], shipped: Mapping[str, Any]) -> str:
    default: Any = shipped
    for step in steps:
        default = default.get(step) if isinstance(default, Mapping) else None
    if default is None:
        default = node.get("default")
    shown = "" if default in (None, [], {}) else f"`{json.dumps(default, ensure_ascii=False)}`"
    item = _innermost(node)
    unit = item.get("unit", "")
    cells = (f"`{dotted(steps)}`", shown, unit, range_text(node), node.get("description", ""))
    return "| " + " | ".join(str(cell).replace("|", "\\|") for cell in cells) + " |"


def _innermost(node: Mapping[str, Any]) -> Mapping[str, Any]:
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
