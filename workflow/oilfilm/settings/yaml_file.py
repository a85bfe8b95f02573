"""Safe YAML with line numbers: plain values, and where in the file each of them is."""

from collections.abc import Hashable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from oilfilm.errors import OilfilmError

# No quantity of a rig or an oil is larger in its unit. Larger numbers would overflow.
LARGEST_NUMBER = 1e15
# No file of the project nests deeper than six groups.
_DEEPEST_GROUP = 50


@dataclass(frozen=True)
class YamlFile:
    """One YAML file.

    Attributes:
        path: The file.
        values: Its content as plain values.
        node: The same as PyYAML's nodes, which know their lines.
    """

    path: Path
    values: dict[str, Any]
    node: yaml.MappingNode

    def line_of(self, steps: Sequence[object]) -> int:
        """The line of a key or list item, or of the innermost group that exists on the way."""
        node: yaml.Node = self.node
        line = 1
        for step in steps:
            if isinstance(node, yaml.MappingNode):
                pairs = [pair for pair in node.value if str(pair[0].value) == str(step)]
                if not pairs:
                    return line
                key, node = pairs[0]
                line = _line(key.start_mark)
            elif isinstance(node, yaml.SequenceNode):
                node = node.value[int(str(step))]
                line = _line(node.start_mark)
        return line

    def location_of(self, steps: Sequence[object]) -> str:
        """The file and the line of a key, as messages begin."""
        return f"{self.path}, line {self.line_of(steps)}"


def read_yaml(path: Path) -> YamlFile:
    """Read one YAML file.

    Raises:
        OilfilmError: The file is missing, is not UTF-8 or not valid YAML, repeats a key, uses an
            alias or a tag, holds a number that is not finite, or has no keys.
    """
    node = _compose(path)
    if not isinstance(node, yaml.MappingNode):
        raise OilfilmError(f"{path}: found no keys; expected `key: value` lines.")
    _refuse_repeated_keys(node, path)
    file = YamlFile(path, _construct(node, path), node)
    for steps, complaint in unusable_values(file.values):
        raise OilfilmError(f"{file.location_of(steps)}, `{dotted(steps)}`: {complaint}")
    return file


def as_yaml(values: Mapping[str, Any]) -> str:
    """Plain values as YAML that `read_yaml` reads back, keys in their own order."""
    # no aliases, which are refused; no sorting: tables follow the order of levels and oils
    return yaml.dump({**values}, Dumper=_Plain, sort_keys=False, allow_unicode=True, width=100)


class _Plain(yaml.SafeDumper):
    def ignore_aliases(self, _: Any) -> bool:
        return True


def leaves(value: object, steps: tuple[object, ...] = ()) -> Iterator[tuple[Any, object]]:
    """The single values in groups and lists: the steps to each, and the value."""
    if isinstance(value, Mapping):
        parts: Iterable[tuple[object, object]] = value.items()
    elif isinstance(value, list):
        parts = enumerate(value)
    else:
        yield steps, value
        return
    for step, part in parts:
        yield from leaves(part, (*steps, step))


def unusable_values(values: object) -> Iterator[tuple[Any, str]]:
    """Values that no key accepts: the steps to each, and a complaint.

    Numbers that are not finite would switch gates off, because every comparison with them fails.
    """
    for steps, value in leaves(values):
        if isinstance(value, int | float) and not abs(value) < LARGEST_NUMBER:
            number = value if isinstance(value, float) else f"of {value.bit_length()} bits"
            yield (
                steps,
                f"found the number {number}; expected a finite one, below {LARGEST_NUMBER:g}.",
            )


def dotted(steps: Sequence[object]) -> str:
    """A key as messages name it: gates.lambda_limit."""
    return ".".join(str(step) for step in steps)


def _compose(path: Path) -> yaml.Node | None:
    text = _text_of(path)
    # libyaml is ten times as fast; what is wrong is better said by PyYAML itself
    with suppress(yaml.YAMLError):
        return _composed(text, path, getattr(yaml, "CSafeLoader", yaml.SafeLoader))
    try:
        return _composed(text, path, yaml.SafeLoader)
    except yaml.YAMLError as error:
        raise _yaml_error(path, error) from error


def _composed(text: str, path: Path, loader: type[yaml.SafeLoader]) -> yaml.Node | None:
    depth = 0
    for event in yaml.parse(text, Loader=loader):
        # an alias can unfold one small file into gigabytes
        if isinstance(event, yaml.AliasEvent):
            line = _line(event.start_mark)
            raise OilfilmError(
                f"{path}, line {line}: found the alias *{event.anchor}; write the value out."
            )
        depth += isinstance(event, yaml.CollectionStartEvent)
        depth -= isinstance(event, yaml.CollectionEndEvent)
        if depth > _DEEPEST_GROUP:
            line = _line(event.start_mark)
            raise OilfilmError(
                f"{path}, line {line}: groups are nested more than {_DEEPEST_GROUP} deep."
            )
    return yaml.compose(text, Loader=loader)


def _text_of(path: Path) -> str:
    try:
        content = path.read_bytes()
    except FileNotFoundError as error:
        raise OilfilmError(
            f"{path}: there is no such file. Run from the top folder of the project."
        ) from error
    except OSError as error:
        raise OilfilmError(f"{path}: cannot be read ({error}).") from error
    try:
        return content.decode("utf-8")
    except UnicodeDecodeError as error:
        line = content[: error.start].count(b"\n") + 1
        raise OilfilmError(
            f"{path}, line {line}: cannot be read as UTF-8 text (byte "
            f"0x{content[error.start]:02x}); save the file as UTF-8."
        ) from error


def _construct(node: yaml.MappingNode, path: Path) -> dict[str, Any]:
    try:
        # construct from the composed node with the safe constructors only
        return dict(yaml.constructor.SafeConstructor().construct_document(node))
    except yaml.YAMLError as error:
        raise _yaml_error(path, error) from error
    except ValueError as error:
        # as of the 45th of a month, or of a number of five thousand digits
        raise OilfilmError(
            f"{path}, line {_unreadable_line(node)}: a value cannot be read ({error}); correct it."
        ) from error


def _unreadable_line(node: yaml.Node) -> int:
    """The line of the first value that Python cannot represent."""
    waiting = [node]
    while waiting:
        part = waiting.pop(0)
        if isinstance(part, yaml.MappingNode):
            waiting += [value for _, value in part.value]
        elif isinstance(part, yaml.SequenceNode):
            waiting += part.value
        else:
            try:
                yaml.constructor.SafeConstructor().construct_document(part)
            except ValueError:
                return _line(part.start_mark)
    return _line(node.start_mark)


def _refuse_repeated_keys(node: yaml.Node, path: Path) -> None:
    if isinstance(node, yaml.SequenceNode):
        for item in node.value:
            _refuse_repeated_keys(item, path)
    if not isinstance(node, yaml.MappingNode):
        return
    first_lines: dict[Hashable, int] = {}
    for key, value in node.value:
        line = _line(key.start_mark)
        if not isinstance(key, yaml.ScalarNode):
            raise OilfilmError(f"{path}, line {line}: found a group as a key; expected one word.")
        if key.value in first_lines:
            raise OilfilmError(
                f"{path}, line {line}: duplicate key {key.value!r} (first defined at line "
                f"{first_lines[key.value]}); keep one of them."
            )
        first_lines[key.value] = line
        _refuse_repeated_keys(value, path)


def _yaml_error(path: Path, error: yaml.YAMLError) -> OilfilmError:
    mark = getattr(error, "problem_mark", None)
    location = f"{path}, line {_line(mark)}" if mark is not None else str(path)
    reason = " ".join((getattr(error, "problem", None) or str(error)).split())
    if "\\t" in reason:
        reason += "; indent with spaces, not with tabs"
    if "mapping values" in reason:
        reason += "; put text that holds a colon in quotes"
    return OilfilmError(f"{location}: not valid YAML: {reason}.")


def _line(mark: Any) -> int:
    """Line of a mark of PyYAML, counted from 1."""
    return int(mark.line) + 1
