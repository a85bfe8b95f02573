"""Mistakes in settings as sentences: file, line, key, what was found, what was expected.

Decides: what the message for a wrong setting says.
"""

import difflib
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import suppress
from datetime import date
from functools import cache
from itertools import islice
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter, ValidationError
from pydantic_core import ErrorDetails

from oilfilm.errors import OilfilmError, cut
from oilfilm.physics.oils import FORMULAS
from oilfilm.settings.quantities import NAME_PATTERN
from oilfilm.settings.yaml_file import YamlFile, dotted, leaves, read_yaml

Steps = tuple[Any, ...]

# What was expected, by pydantic's kind of error, with what it tells of it.
_EXPECTED = {
    "unexpected": "{expected}",
    "greater_than": "more than {gt:g}{in_unit}",
    "greater_than_equal": "{ge:g} or more{in_unit}",
    "less_than": "less than {lt:g}{in_unit}",
    "less_than_equal": "{le:g} or less{in_unit}",
    "finite_number": "a finite number",
    "too_short": "{min_length} or more items",
    "too_long": "{max_length} or fewer items",
    "string_too_short": "text that is not empty",
    "string_type": "text",
    "float_type": "a number",
    "int_type": "a whole number",
    "bool_type": "true or false",
    "list_type": "a list",
    "tuple_type": "a list",
    "dict_type": "a group of keys",
    "model_type": "a group of keys",
    "union_tag_invalid": "one of {expected_tags}",
}
_FORM_OF_NAME = (
    "text of the form ABC-1_2.3: ASCII letters, digits, '_', '.' and '-' alone. Other names of an "
    "oil go under `aliases`"
)
_TEXT = {"type": "string"}
# Mistakes of a file from which the first line is chosen.
_MOST_MISTAKES = 100


def load(path: Path, model: Any) -> Any:
    """Read one YAML file as a model (a class, or a union of classes).

    Raises:
        OilfilmError: As `read_yaml`, or a key or value is not as the model declares it.
    """
    return check_file(read_yaml(path), model)


def check_file(
    file: YamlFile, model: Any, location_of: Callable[[Steps], str] | None = None
) -> Any:
    """The content of a YAML file as a model.

    Args:
        file: The file.
        model: The model: a class, or a union of classes.
        location_of: Where the value at these steps was written, if not in the file.

    Raises:
        OilfilmError: A key has no value, or a key or value is not as the model declares it.
    """
    location_of = location_of or file.location_of
    for steps, value in leaves(file.values):
        if value is None:
            wanted = "found nothing; write a value, or leave the key out."
            raise OilfilmError(f"{location_of(steps)}, `{dotted(steps)}`: {wanted}")
    return check(file.values, model, location_of, file.line_of)


def check(
    values: Any,
    model: Any,
    location_of: Callable[[Steps], str],
    order: Callable[[Steps], Any] = lambda steps: 0,
) -> Any:
    """Values as a model.

    Args:
        values: Plain values.
        model: The model: a class, or a union of classes.
        location_of: Where the value at these steps was written, as the message begins.
        order: Sorts mistakes; the first is reported.

    Raises:
        OilfilmError: A key or value is not as the model declares it.
    """
    try:
        return adapter(model).validate_python(values)
    except ValidationError as error:
        mistakes = islice(_mistakes(error, model), _MOST_MISTAKES)
    # an unknown key is often a missing one, misspelled: say that first
    steps, sentence = min(mistakes, key=lambda each: ("is missing" in each[1], order(each[0])))
    raise OilfilmError(f"{location_of(steps)}: {sentence}") from None


def first_mistake(values: Any, model: Any) -> str:
    """The first mistake in values that came from no file of settings; empty where there is none."""
    try:
        check(values, model, lambda steps: "")
    except OilfilmError as mistake:
        return str(mistake).removeprefix(": ")
    return ""


@cache
def adapter(model: Any) -> TypeAdapter[Any]:
    """The validator of a model, built once."""
    return TypeAdapter(model)


@cache
def schema_of(model: Any) -> dict[str, Any]:
    """The JSON schema of a model."""
    return adapter(model).json_schema()


def _mistakes(error: ValidationError, model: Any) -> Iterator[tuple[Steps, str]]:
    """The steps to each mistake, and its sentence."""
    schema = schema_of(model)
    for details in error.errors(include_url=False):
        context = details.get("ctx", {})
        # pydantic adds the alternative that it chose, where an oil may be one of several models,
        # and a mark where the key itself is wrong
        steps = tuple(step for step in details["loc"] if step not in (*FORMULAS, "[key]"))
        if details["type"] == "contradiction":
            steps = (*steps, *context["at"])
            yield steps, f"`{dotted(steps)}`: {context['sentence']}"
            continue
        if details["type"].startswith("union_tag"):
            steps = (*steps, "model")
        yield steps, _sentence(details, steps, schema)


def _sentence(details: ErrorDetails, steps: Steps, schema: Mapping[str, Any]) -> str:
    group, node = dotted(steps[:-1]), node_at(schema, steps)
    value = details.get("ctx", {}).get("tag", details["input"])
    under = f" under `{group}`" if group else ""
    if details["loc"][-1:] == ("[key]",) and details["type"] == "string_type":
        return f"the key {value!r}{under} is no text.{_hint(value, _TEXT)}"
    if details["type"] == "extra_forbidden" or details["loc"][-1:] == ("[key]",):
        return _unknown_key(steps[-1], node_at(schema, steps[:-1]), under)
    meaning = _meaning(schema, steps)
    if details["type"] in ("missing", "union_tag_not_found"):
        return f"the key {str(steps[-1])!r} is missing{under}. {meaning}".rstrip()
    if details["type"] == "string_type":  # an item of a list of names may be given alone
        node = {**node, **_TEXT}
    found, expected, hint = cut(repr(value)), _expected(details, node), _hint(value, node)
    return f"`{dotted(steps)}`: found {found}, expected {expected}.{hint} {meaning}".rstrip()


def _unknown_key(unknown: Any, group: Mapping[str, Any], under: str) -> str:
    known = sorted(group.get("properties", group.get("propertyNames", {}).get("enum", ())))
    hint = near(str(unknown), known)
    return f"found the unknown key {unknown!r}{under}; expected one of {', '.join(known)}.{hint}"


def near(text: str, known: Iterable[str]) -> str:
    """The question whether the nearest of the known words was meant; empty where none is near."""
    found = difflib.get_close_matches(text, list(known), n=1)
    return f" Did you mean {found[0]!r}?" if found else ""


def _expected(details: ErrorDetails, node: Mapping[str, Any]) -> str:
    kind, context = details["type"], details.get("ctx", {})
    if kind == "literal_error":
        allowed = node.get("enum", [node.get("const")])
        return ("one of " if len(allowed) > 1 else "") + ", ".join(map(repr, allowed))
    if context.get("pattern") == NAME_PATTERN:
        return _FORM_OF_NAME
    if kind not in _EXPECTED:
        return str(details["msg"])
    unit = node.get("unit", "1")
    in_unit = "" if unit == "1" else f", in {unit}"
    return _EXPECTED[kind].format(in_unit=in_unit, **context)


def _hint(value: Any, node: Mapping[str, Any]) -> str:
    """What to write where YAML read something else."""
    if isinstance(value, str) and "enum" in node:
        return near(value, map(str, node["enum"]))
    if isinstance(value, str) and node.get("type") in ("number", "integer"):
        with suppress(ValueError):
            return f" Write {float(value):#}, with a point and no quotes."
    if isinstance(value, bool) and node.get("type") == "string":
        return ' YAML reads NO, OFF, YES and ON so: put the word in quotes, as "NO".'
    if isinstance(value, date | int | float) and node.get("type") == "string":
        return f' Put it in quotes: "{value}".'
    return ""


# ---------------------------------------------------------------- walking a JSON schema


def node_at(schema: Mapping[str, Any], steps: Steps) -> Mapping[str, Any]:
    """What a JSON schema says of the value at these steps; empty where it says nothing."""
    node = plain_node(schema, schema)
    for step in steps:
        node = plain_node(_child(node, step), schema)
    return node


def _child(node: Mapping[str, Any], step: Any) -> Mapping[str, Any]:
    for branch in (node, *node.get("oneOf", ())):
        if step in branch.get("properties", {}):
            return branch["properties"][step]
    if isinstance(step, int):
        items = node.get("prefixItems", [])
        return items[step] if step < len(items) else node.get("items", {})
    others = node.get("additionalProperties", {})
    return others if isinstance(others, Mapping) else {}


def plain_node(node: Mapping[str, Any], schema: Mapping[str, Any]) -> Mapping[str, Any]:
    """A node of a JSON schema with its references resolved, and without null."""
    if "$ref" in node:
        target = schema["$defs"][node["$ref"].rpartition("/")[2]]
        return {**plain_node(target, schema), **{k: v for k, v in node.items() if k != "$ref"}}
    if "anyOf" in node:
        value = next(branch for branch in node["anyOf"] if branch.get("type") != "null")
        rest = {k: v for k, v in node.items() if k != "anyOf"}
        return {**plain_node(value, schema), **rest}
    if "oneOf" in node:
        return {**node, "oneOf": [plain_node(branch, schema) for branch in node["oneOf"]]}
    return node


def _meaning(schema: Mapping[str, Any], steps: Steps) -> str:
    """The meaning of a key; of a list's item, the list's."""
    while steps and isinstance(steps[-1], int):
        steps = steps[:-1]
    return str(node_at(schema, steps).get("description", ""))
