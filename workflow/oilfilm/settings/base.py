"""What every typed model is made of: strict groups of keys, for settings and for printed JSON."""

import unicodedata
from dataclasses import dataclass
from math import isfinite
from typing import Annotated, Any, TypeVar

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field
from pydantic_core import CoreSchema, PydanticCustomError
from pydantic_core.core_schema import literal_schema

from oilfilm.errors import OilfilmError

T = TypeVar("T")
# A number of printed JSON: null where it is not known.
Result = Annotated[
    float | None,
    BeforeValidator(lambda value: None if value is None or not isfinite(value) else float(value)),
]


class Group(BaseModel):
    """A group of keys: each is declared, none is added or changed, and nothing is converted."""

    model_config = ConfigDict(
        strict=True,
        extra="forbid",
        frozen=True,
        allow_inf_nan=False,
        protected_namespaces=(),
        defer_build=True,
    )


def plain_key(text: str) -> str:
    """A name as it is compared: in lower case, its words joined by underscores.

    Forms of one letter (composed, full-width, the two signs for micro) are one.

    Examples:
        >>> plain_key("Inlet  Temperature"), plain_key("\uff2c\uff4f\uff41\uff44")
        ('inlet_temperature', 'load')
    """
    return "_".join(unicodedata.normalize("NFKC", text).casefold().split())


class _Required:
    """Stands for: this key has no default."""


def key(meaning: str, *, unit: str | None = None, default: Any = _Required, **limits: Any) -> Any:
    """Declare a key: its meaning, its unit, its default where it may be left out, its range."""
    declared: dict[str, Any] = {"description": meaning, **limits}
    if unit is not None:
        declared["json_schema_extra"] = {"unit": unit}
    if default is not _Required:
        declared["default"] = default
    return Field(**declared)


def optional(meaning: str, **limits: Any) -> Any:
    """Declare a key that may be left out, and is None then."""
    return key(meaning, default=None, **limits)


def present(value: T | None, key: str, owner: str) -> T:
    """A value that may be left out, where it is needed.

    Raises:
        OilfilmError: It was left out.
    """
    if value is None:
        raise OilfilmError(f"{owner} lacks the key `{key}`, which is needed here. Add it.")
    return value


def unexpected(expected: str) -> PydanticCustomError:
    """The error of a value that is well formed but wrong: "found ..., expected {expected}"."""
    return PydanticCustomError("unexpected", "{expected}", {"expected": expected})


@dataclass(frozen=True)
class OneOf:
    """Validates a text that must be one of some names."""

    names: tuple[str, ...]

    def __get_pydantic_core_schema__(self, *_: object) -> CoreSchema:
        return literal_schema([*self.names])


def contradiction(steps: tuple[object, ...], sentence: str) -> PydanticCustomError:
    """The error of keys that contradict each other: the key to blame and a sentence."""
    return PydanticCustomError("contradiction", "{sentence}", {"sentence": sentence, "at": steps})
