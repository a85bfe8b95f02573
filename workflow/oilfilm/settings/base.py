"""Base of every typed model: strict groups of keys, for settings and other files with keys."""

from dataclasses import dataclass
from typing import Any, TypeVar

from pydantic import BaseModel, ConfigDict, Field
from pydantic_core import CoreSchema, PydanticCustomError
from pydantic_core.core_schema import literal_schema

from oilfilm.base.errors import OilfilmError

T = TypeVar("T")


class Group(BaseModel):
    """A group of declared keys: an unknown key is refused.

    Values are not changed, except that a whole number becomes a float where one is declared.
    """

    model_config = ConfigDict(
        strict=True,
        extra="forbid",
        frozen=True,
        allow_inf_nan=False,
        protected_namespaces=(),
        defer_build=True,
    )


class _Required:
    """Marks a key without a default."""


def key(meaning: str, *, unit: str | None = None, default: Any = _Required, **limits: Any) -> Any:
    """Declare a key.

    Args:
        meaning: What the value means.
        unit: Unit of the value.
        default: Value of a key that is left out; without a default the key is required.
        limits: Range of the value, as pydantic's `Field` takes it (`gt`, `ge`, `lt`, `le`).
    """
    arguments: dict[str, Any] = {"description": meaning, **limits}
    if unit is not None:
        arguments["json_schema_extra"] = {"unit": unit}
    if default is not _Required:
        arguments["default"] = default
    return Field(**arguments)


def optional(meaning: str, **limits: Any) -> Any:
    """Declare a key that may be left out; its value is None then."""
    return key(meaning, default=None, **limits)


def required_value(value: T | None, key_name: str, owner: str) -> T:
    """The value of an optional key, where it is needed.

    Args:
        value: The value; None where the key was left out.
        key_name: The key.
        owner: What has the key, for the message: "the campaign".

    Raises:
        OilfilmError: The key was left out.
    """
    if value is None:
        raise OilfilmError(f"{owner} lacks the key `{key_name}`, which is needed here. Add it.")
    return value


def unexpected_value_error(expected: str) -> PydanticCustomError:
    """The error for a value of the right type that is wrong: "found ..., expected {expected}"."""
    return PydanticCustomError("unexpected", "{expected}", {"expected": expected})


@dataclass(frozen=True)
class OneOf:
    """Validator of a text that must be one of the allowed names."""

    names: tuple[str, ...]

    def __get_pydantic_core_schema__(self, *_: object) -> CoreSchema:
        return literal_schema(list(self.names))


def key_error_at(key_path: tuple[object, ...], sentence: str) -> PydanticCustomError:
    """The error for a key that contradicts others.

    Args:
        key_path: Path of the wrong key, relative to the validated group.
        sentence: What is wrong, and what to do.
    """
    return PydanticCustomError(
        "contradiction", "{sentence}", {"sentence": sentence, "at": key_path}
    )
