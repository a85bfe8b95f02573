"""Mistakes in settings as sentences: file, line, key, what was found, what was expected.

Decides: the text of the message for a wrong setting.
"""

import difflib
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import dataclass
from datetime import date
from functools import cache
from itertools import islice
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter, ValidationError
from pydantic_core import ErrorDetails

from oilfilm.base.errors import OilfilmError, cut
from oilfilm.physics.oils import FORMULAS
from oilfilm.settings.quantities import NAME_PATTERN
from oilfilm.settings.yaml_file import YamlFile, dotted, leaves, read_yaml

# The keys and list indices that lead to a value, from the outermost group inwards.
Steps = tuple[Any, ...]

# What was expected, by pydantic's kind of error; the names in braces are in pydantic's error.
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
_TEXT_SCHEMA = {"type": "string"}
# The mistake to report is chosen among so many.
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
        location_of: Gives the place where the value at these steps was written, if not the file.

    Raises:
        OilfilmError: A key has no value, or a key or value is not as the model declares it.
    """
    location_of = location_of or file.location_of
    for steps, value in leaves(file.values):
        if value is None:
            advice = "write a value, or leave the key out."
            what_to_fill_in = file.marked_comment(steps)
            if what_to_fill_in:
                advice = f"fill in {what_to_fill_in}."
            raise OilfilmError(f"{location_of(steps)}, `{dotted(steps)}`: found nothing; {advice}")
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
        location_of: Gives the place where the value at these steps was written, as the beginning of
            the message.
        order: Key that sorts the mistakes; the first is reported.

    Raises:
        OilfilmError: A key or value is not as the model declares it.
    """
    try:
        return adapter(model).validate_python(values)
    except ValidationError as error:
        mistakes = islice(_mistakes(error, model), _MOST_MISTAKES)

    def rank(mistake: _Mistake) -> tuple[bool, Any]:
        # an unknown key is often a misspelled one: it is reported before the missing key
        return mistake.is_missing_key, order(mistake.steps)

    reported = min(mistakes, key=rank)
    raise OilfilmError(f"{location_of(reported.steps)}: {reported.sentence}") from None


def first_mistake(values: Any, model: Any) -> str:
    """The first mistake in values that do not come from a file of settings; empty if none."""
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


@dataclass(frozen=True)
class _Mistake:
    """A mistake: the steps to the wrong key or value, and a sentence."""

    steps: Steps
    sentence: str
    is_missing_key: bool = False


def _mistakes(error: ValidationError, model: Any) -> Iterator[_Mistake]:
    """The mistakes of a validation."""
    schema = schema_of(model)
    for details in error.errors(include_url=False):
        context = details.get("ctx", {})
        # pydantic adds the alternative that it chose, where an oil may be one of several models,
        # and a mark where the key itself is wrong
        steps = tuple(step for step in details["loc"] if step not in (*FORMULAS, "[key]"))
        if details["type"] == "contradiction":
            steps = (*steps, *context["at"])
            yield _Mistake(steps, f"`{dotted(steps)}`: {context['sentence']}")
            continue
        if details["type"].startswith("union_tag"):
            steps = (*steps, "model")
        yield _mistake(details, steps, schema)


def _mistake(details: ErrorDetails, steps: Steps, schema: Mapping[str, Any]) -> _Mistake:
    """One of pydantic's errors as a mistake with a sentence."""
    kind = details["type"]
    group = dotted(steps[:-1])
    under_group = f" under `{group}`" if group else ""
    value = details.get("ctx", {}).get("tag", details["input"])
    key_is_wrong = details["loc"][-1:] == ("[key]",)
    if key_is_wrong and kind == "string_type":
        sentence = f"the key {value!r}{under_group} is no text.{_hint(value, _TEXT_SCHEMA)}"
        return _Mistake(steps, sentence)
    if key_is_wrong or kind == "extra_forbidden":
        return _Mistake(steps, _unknown_key(steps[-1], node_at(schema, steps[:-1]), under_group))
    meaning = _meaning(schema, steps)
    if kind in ("missing", "union_tag_not_found"):
        sentence = f"the key {str(steps[-1])!r} is missing{under_group}. {meaning}".rstrip()
        return _Mistake(steps, sentence, is_missing_key=True)
    node = node_at(schema, steps)
    if kind == "string_type":  # an item of a list of names may be given alone
        node = {**node, **_TEXT_SCHEMA}
    expected = _expected(details, node)
    hint = _hint(value, node)
    sentence = f"`{dotted(steps)}`: found {cut(repr(value))}, expected {expected}.{hint} {meaning}"
    return _Mistake(steps, sentence.rstrip())


def _unknown_key(key: Any, group: Mapping[str, Any], under_group: str) -> str:
    names_of_a_mapping = group.get("propertyNames", {}).get("enum", ())
    names = sorted(group.get("properties", names_of_a_mapping))
    hint = _did_you_mean(str(key), names)
    return f"found the unknown key {key!r}{under_group}; expected one of {', '.join(names)}.{hint}"


def _did_you_mean(text: str, names: Iterable[str]) -> str:
    """The question whether the most similar name was meant; empty where none is similar."""
    similar = difflib.get_close_matches(text, list(names), n=1)
    return f" Did you mean {similar[0]!r}?" if similar else ""


def _expected(details: ErrorDetails, node: Mapping[str, Any]) -> str:
    kind = details["type"]
    context = details.get("ctx", {})
    if kind == "literal_error":
        allowed = node.get("enum", [node.get("const")])
        choices = ", ".join(map(repr, allowed))
        return f"one of {choices}" if len(allowed) > 1 else choices
    if context.get("pattern") == NAME_PATTERN:
        return _FORM_OF_NAME
    if kind not in _EXPECTED:
        return str(details["msg"])
    unit = node.get("unit", "1")
    in_unit = "" if unit == "1" else f", in {unit}"
    return _EXPECTED[kind].format(in_unit=in_unit, **context)


def _hint(value: Any, node: Mapping[str, Any]) -> str:
    """Advice on how to write a value that YAML reads as another type."""
    kind = node.get("type")
    if isinstance(value, str) and "enum" in node:
        return _did_you_mean(value, map(str, node["enum"]))
    if isinstance(value, str) and kind in ("number", "integer"):
        with suppress(ValueError):
            return f" Write {float(value):#}, with a point and no quotes."
    if isinstance(value, bool) and kind == "string":
        return ' YAML reads NO, OFF, YES and ON so: put the word in quotes, as "NO".'
    if isinstance(value, date | int | float) and kind == "string":
        return f' Put it in quotes: "{value}".'
    return ""


# ---------------------------------------------------------------- walking a JSON schema


def node_at(schema: Mapping[str, Any], steps: Steps) -> Mapping[str, Any]:
    """The node of a JSON schema for the value at these steps; empty where there is none."""
    node = plain_node(schema, schema)
    for step in steps:
        node = plain_node(_child(node, step), schema)
    return node


def _child(node: Mapping[str, Any], step: Any) -> Mapping[str, Any]:
    """The node of a key or list item below a node; empty where there is none."""
    for branch in (node, *node.get("oneOf", ())):
        if step in branch.get("properties", {}):
            return branch["properties"][step]
    if isinstance(step, int):
        items = node.get("prefixItems", [])
        return items[step] if step < len(items) else node.get("items", {})
    node_of_other_keys = node.get("additionalProperties", {})
    return node_of_other_keys if isinstance(node_of_other_keys, Mapping) else {}


def plain_node(node: Mapping[str, Any], schema: Mapping[str, Any]) -> Mapping[str, Any]:
    """A node of a JSON schema with its references resolved, and without null."""
    resolved = dict(node)
    if "$ref" in node:
        _, _, name = resolved.pop("$ref").rpartition("/")
        return {**plain_node(schema["$defs"][name], schema), **resolved}
    if "anyOf" in node:
        branches = resolved.pop("anyOf")
        branch_with_value = next(branch for branch in branches if branch.get("type") != "null")
        return {**plain_node(branch_with_value, schema), **resolved}
    if "oneOf" in node:
        resolved["oneOf"] = [plain_node(branch, schema) for branch in node["oneOf"]]
    return resolved


def _meaning(schema: Mapping[str, Any], steps: Steps) -> str:
    """The meaning of a key; for an item of a list, the meaning of the list."""
    while steps and isinstance(steps[-1], int):
        steps = steps[:-1]
    return str(node_at(schema, steps).get("description", ""))
