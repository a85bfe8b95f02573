"""Mistakes in settings as sentences: file, line, key, what was found, what was expected.

Decides: the text of the message for a wrong setting.
"""

import difflib
import math
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
from oilfilm.settings.quantities import NAME_PATTERN
from oilfilm.settings.yaml_file import YamlFile, dotted_key, leaves, read_yaml

# Where a value is: the keys and list indices that lead to it, from the outermost group inwards.
KeyPath = tuple[Any, ...]

# What was expected, by pydantic's type of error. The names in braces are in pydantic's error.
_EXPECTED_BY_ERROR_TYPE = {
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
# The mistake to report is chosen among at most this many.
_MAX_MISTAKES = 100


def load(path: Path, model: Any) -> Any:
    """The content of one YAML file as an instance of a model (a class, or a union of classes).

    Raises:
        OilfilmError: As `read_yaml`, or a key or value is not as the model declares it.
    """
    return validated_file(read_yaml(path), model)


def validated_file(
    file: YamlFile, model: Any, location_of: Callable[[KeyPath], str] | None = None
) -> Any:
    """The content of a YAML file as an instance of a model.

    Args:
        file: The file.
        model: The model: a class, or a union of classes.
        location_of: Function of a key path; it says where the value was written. Without it the
            values were written in the file.

    Raises:
        OilfilmError: A key has no value, or a key or value is not as the model declares it.
    """
    location_of = location_of or file.location_of
    for key_path, value in leaves(file.values):
        if value is None:
            advice = "write a value, or leave the key out."
            what_to_fill_in = file.marked_comment(key_path)
            if what_to_fill_in:
                advice = f"fill in {what_to_fill_in}."
            raise OilfilmError(
                f"{location_of(key_path)}, `{dotted_key(key_path)}`: found nothing; {advice}"
            )
    return validated(file.values, model, location_of, file.line_of)


def validated(
    values: Any,
    model: Any,
    location_of: Callable[[KeyPath], str],
    order_key: Callable[[KeyPath], Any] = lambda key_path: 0,
) -> Any:
    """Plain values as an instance of a model.

    Args:
        values: Plain values.
        model: The model: a class, or a union of classes.
        location_of: Function of a key path; it says where the value was written, as the beginning
            of the message.
        order_key: Function of a key path by which the mistakes are sorted; the first is reported.

    Raises:
        OilfilmError: A key or value is not as the model declares it.
    """
    try:
        return adapter(model).validate_python(values)
    except ValidationError as error:
        mistakes = islice(_mistakes(error, model), _MAX_MISTAKES)

    def rank(mistake: _Mistake) -> tuple[bool, Any]:
        # an unknown key is often a misspelled one: it is reported before the missing key
        return mistake.is_missing_key, order_key(mistake.key_path)

    reported = min(mistakes, key=rank)
    raise OilfilmError(f"{location_of(reported.key_path)}: {reported.sentence}") from None


def first_mistake(values: Any, model: Any) -> str:
    """The first mistake in values that do not come from a file of settings; empty if none."""
    try:
        validated(values, model, lambda key_path: "")
    except OilfilmError as mistake:
        return str(mistake).removeprefix(": ")
    return ""


@cache
def adapter(model: Any) -> TypeAdapter[Any]:
    """The pydantic validator (`TypeAdapter`) of a model, built once."""
    return TypeAdapter(model)


@cache
def schema_of(model: Any) -> dict[str, Any]:
    """The JSON schema of a model."""
    return adapter(model).json_schema()


@dataclass(frozen=True)
class _Mistake:
    """A mistake: the path of the wrong key or value, and a sentence."""

    key_path: KeyPath
    sentence: str
    is_missing_key: bool = False


def _mistakes(error: ValidationError, model: Any) -> Iterator[_Mistake]:
    """The mistakes of a validation."""
    schema = schema_of(model)
    for details in error.errors(include_url=False):
        context = details.get("ctx", {})
        if details["type"] == "contradiction":
            key_path = _without_tags((*details["loc"], *context["at"]), schema)
            yield _Mistake(key_path, f"`{dotted_key(key_path)}`: {context['sentence']}")
            continue
        yield _mistake(details, schema)


def _mistake(details: ErrorDetails, schema: Mapping[str, Any]) -> _Mistake:
    """One of pydantic's errors as a mistake with a sentence."""
    error_type = details["type"]
    location = details["loc"]
    # pydantic marks a wrong key of a mapping; an unknown key may have the name of the mark
    is_key_wrong = location[-1:] == ("[key]",) and error_type != "extra_forbidden"
    if is_key_wrong:
        location = location[:-1]
    if error_type.startswith("union_tag"):
        location = (*location, "model")
    key_path = _without_tags(location, schema)
    group_key = dotted_key(key_path[:-1])
    under_group = f" under `{group_key}`" if group_key else ""
    input_value = details.get("ctx", {}).get("tag", details["input"])
    if error_type == "invalid_key" or (is_key_wrong and error_type == "string_type"):
        hint = _hint(input_value, _TEXT_SCHEMA)
        sentence = f"the key {input_value!r}{under_group} is no text.{hint}"
        return _Mistake(key_path, sentence)
    if is_key_wrong or error_type == "extra_forbidden":
        group_node = node_at(schema, location[:-1])
        return _Mistake(key_path, _unknown_key_sentence(key_path[-1], group_node, under_group))
    meaning = _meaning_of_key(schema, location)
    if error_type in ("missing", "union_tag_not_found"):
        sentence = f"the key {str(key_path[-1])!r} is missing{under_group}. {meaning}".rstrip()
        return _Mistake(key_path, sentence, is_missing_key=True)
    node = node_at(schema, location)
    if error_type == "string_type":  # an item of a list of names may be given alone
        node = {**node, **_TEXT_SCHEMA}
    expected_text = _expected_text(details, node)
    hint = _hint(input_value, node)
    found_text = f"found {cut(repr(input_value))}, expected {expected_text}."
    sentence = f"`{dotted_key(key_path)}`: {found_text}{hint} {meaning}"
    return _Mistake(key_path, sentence.rstrip())


def _unknown_key_sentence(key: Any, group_node: Mapping[str, Any], under_group: str) -> str:
    """What is wrong with a key that its group does not have.

    Args:
        key: The key.
        group_node: The node of the group in the JSON schema.
        under_group: Words that say which group, such as " under `gates`".
    """
    names_of_mapping = group_node.get("propertyNames", {}).get("enum", ())
    key_names = sorted(group_node.get("properties", names_of_mapping))
    hint = _did_you_mean(str(key), key_names)
    choices = ", ".join(key_names)
    return f"found the unknown key {key!r}{under_group}; expected one of {choices}.{hint}"


def _did_you_mean(text: str, names: Iterable[str]) -> str:
    """The question whether the most similar name was meant; empty where none is similar."""
    similar = difflib.get_close_matches(text, list(names), n=1)
    return f" Did you mean {similar[0]!r}?" if similar else ""


def _expected_text(details: ErrorDetails, node: Mapping[str, Any]) -> str:
    """What was expected in place of a wrong value, with its unit."""
    error_type = details["type"]
    context = details.get("ctx", {})
    if error_type == "literal_error":
        allowed_values = node.get("enum", [node.get("const")])
        choices = ", ".join(map(repr, allowed_values))
        return f"one of {choices}" if len(allowed_values) > 1 else choices
    if context.get("pattern") == NAME_PATTERN:
        return _FORM_OF_NAME
    if error_type not in _EXPECTED_BY_ERROR_TYPE:
        return str(details["msg"])
    unit = node.get("unit", "1")
    in_unit = "" if unit == "1" else f", in {unit}"
    return _EXPECTED_BY_ERROR_TYPE[error_type].format(in_unit=in_unit, **context)


def _hint(value: Any, node: Mapping[str, Any]) -> str:
    """Advice on how to write a value that YAML reads as another type."""
    value_type = node.get("type")
    if isinstance(value, str) and "enum" in node:
        return _did_you_mean(value, map(str, node["enum"]))
    if isinstance(value, str) and value_type in ("number", "integer"):
        return _hint_at_number(value, value_type)
    if isinstance(value, bool) and value_type == "string":
        return ' YAML reads NO, OFF, YES and ON as true or false: put the word in quotes, as "NO".'
    if isinstance(value, date | int | float) and value_type == "string":
        return f' Put it in quotes: "{value}".'
    return ""


def _hint_at_number(text: str, number_type: str) -> str:
    """Advice on how to write a number that YAML reads as text; empty if it is no finite number."""
    with suppress(ValueError):
        if number_type == "integer":
            return f" Write {int(text)}, with no quotes."
        if math.isfinite(float(text)):
            return f" Write {float(text):#}, with a point and no quotes."
    return ""


# ---------------------------------------------------------------- walking a JSON schema


def node_at(schema: Mapping[str, Any], location: KeyPath) -> Mapping[str, Any]:
    """The node of a JSON schema for a value; empty where there is none.

    Args:
        schema: The JSON schema.
        location: Where the value is, as pydantic says it: a key path with tags. A tag is the name
            of the alternative that pydantic chose, as `vogel` of the models of an oil.
    """
    node = plain_node(schema, schema)
    for step in location:
        node = plain_node(_child(node, step), schema)
    return node


def _without_tags(location: KeyPath, schema: Mapping[str, Any]) -> KeyPath:
    """The keys and indices that the user wrote, of a location as `node_at` takes it.

    A key may have the name of a tag. Only the schema tells the two apart.
    """
    node = plain_node(schema, schema)
    key_path = []
    for step in location:
        if step not in _node_by_tag(node):
            key_path.append(step)
        node = plain_node(_child(node, step), schema)
    return tuple(key_path)


def _node_by_tag(node: Mapping[str, Any]) -> Mapping[str, Mapping[str, Any]]:
    """The alternatives of a node by their tags; empty where there is only one."""
    reference_by_tag = node.get("discriminator", {}).get("mapping", {})
    return {tag: {"$ref": reference} for tag, reference in reference_by_tag.items()}


def _child(node: Mapping[str, Any], step: Any) -> Mapping[str, Any]:
    """The node of a key, tag or list item below a node; empty where there is none."""
    node_by_tag = _node_by_tag(node)
    if step in node_by_tag:
        return node_by_tag[step]
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
    plain = dict(node)
    if "$ref" in node:
        _, _, definition_name = plain.pop("$ref").rpartition("/")
        return {**plain_node(schema["$defs"][definition_name], schema), **plain}
    if "anyOf" in node:
        branches = plain.pop("anyOf")
        branch_with_value = next(branch for branch in branches if branch.get("type") != "null")
        return {**plain_node(branch_with_value, schema), **plain}
    if "oneOf" in node:
        plain["oneOf"] = [plain_node(branch, schema) for branch in node["oneOf"]]
    return plain


def _meaning_of_key(schema: Mapping[str, Any], location: KeyPath) -> str:
    """The meaning of a key; for an item of a list, the meaning of the list."""
    while location and isinstance(location[-1], int):
        location = location[:-1]
    return str(node_at(schema, location).get("description", ""))
