"""Safe YAML with line numbers: plain values, and the line of each value.

Decides: which YAML is read.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import yaml

from oilfilm.base.errors import OilfilmError

# About ten thousand lines. The longest file of the project has a few hundred.
_MAX_BYTES = 1 << 19
# No file of the project nests groups deeper than six levels.
_MAX_LEVELS = 50
# libyaml is ten times as fast. It would crash on groups nested without end.
_LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
# 010 is 8 in YAML, and 1:30 is 90.
_NUMBER_OF_ANOTHER_BASE = re.compile(r"[-+]?(0[0-7_]+$|[0-9_]+:)")


@dataclass(frozen=True)
class YamlFile:
    """One YAML file.

    Attributes:
        path: Path of the file.
        values: Its content as plain values, by its outermost keys.
        node: Its content as nodes of PyYAML, which have line numbers.
    """

    path: Path
    values: dict[str, Any]
    node: yaml.MappingNode

    def line_of(self, key_path: Sequence[object]) -> int:
        """The line of a key or list item; of the innermost existing group if there is none.

        Args:
            key_path: The keys and list indices that lead to it, from the outermost group inwards.
        """
        node: yaml.Node = self.node
        line_number = 1
        for step in key_path:
            if isinstance(node, yaml.MappingNode):
                entries = [entry for entry in node.value if str(entry[0].value) == str(step)]
                if not entries:
                    return line_number
                key_node, node = entries[0]
                line_number = _line_number(key_node)
            elif isinstance(node, yaml.SequenceNode):
                index = int(str(step))
                if index >= len(node.value):
                    return line_number
                node = node.value[index]
                line_number = _line_number(node)
        return line_number

    def marked_comment(self, key_path: Sequence[object]) -> str:
        """The comment behind `FILL IN:` in the line of a key; empty where there is none."""
        if not self.path.is_file():
            # a section of another workflow's configuration
            return ""
        line = _text_of_file(self.path).splitlines()[self.line_of(key_path) - 1]
        return line.partition("# FILL IN:")[2].strip()

    def location_of(self, key_path: Sequence[object]) -> str:
        """The file and the line of a key, as the beginning of a message."""
        return f"{self.path}, line {self.line_of(key_path)}"


def read_yaml(path: Path) -> YamlFile:
    """Read one YAML file.

    Raises:
        OilfilmError: The file is missing, is not UTF-8 or not valid YAML, repeats a key, uses an
            alias or a tag, or has no keys.
    """
    try:
        node = _checked_node(_text_of_file(path), path)
        if not isinstance(node, yaml.MappingNode):
            raise OilfilmError(f"{path}: found no keys; expected `key: value` lines.")
        return YamlFile(path, _plain_value(node, path), node)
    except yaml.YAMLError as error:
        mark = getattr(error, "problem_mark", None)
        problem = getattr(error, "problem", None)
        location = f"{path}, line {mark.line + 1}" if mark else path
        reason = " ".join(str(problem or error).split())
        raise OilfilmError(f"{location}: not valid YAML: {reason}.") from error


def as_yaml(values: Mapping[str, Any]) -> str:
    """Plain values as YAML that `read_yaml` can read; the order of keys is kept."""
    # no sorting: tables follow the order of levels and oils
    return yaml.dump(
        dict(values), Dumper=_DumperWithoutAliases, sort_keys=False, allow_unicode=True, width=100
    )


class _DumperWithoutAliases(yaml.SafeDumper):
    """Writes a value that occurs twice out twice."""

    def ignore_aliases(self, _: Any) -> bool:
        return True  # `read_yaml` refuses them


def leaves(value: object, key_path: tuple[object, ...] = ()) -> Iterator[tuple[Any, object]]:
    """The single values in groups and lists: the key path of each, and the value."""
    if isinstance(value, Mapping):
        for key, content in value.items():
            yield from leaves(content, (*key_path, key))
    elif isinstance(value, list):
        for index, item in enumerate(value):
            yield from leaves(item, (*key_path, index))
    else:
        yield key_path, value


def dotted_key(key_path: Sequence[object]) -> str:
    """A key in the form of messages: gates.lambda_limit."""
    return ".".join(map(str, key_path))


def _checked_node(text: str, path: Path) -> yaml.Node | None:
    """The top node of a text that can be read safely; any other text is refused."""
    level = 0
    for event in yaml.parse(text, Loader=_LOADER):
        # with aliases a small file can become gigabytes
        if isinstance(event, yaml.AliasEvent):
            raise _mistake(path, event, f"found the alias *{event.anchor}; write the value out.")
        if isinstance(event, yaml.CollectionStartEvent):
            level += 1
        elif isinstance(event, yaml.CollectionEndEvent):
            level -= 1
        if level > _MAX_LEVELS:
            raise _mistake(path, event, f"groups are nested more than {_MAX_LEVELS} deep.")
    return yaml.compose(text, Loader=_LOADER)


def _plain_value(node: yaml.Node, path: Path) -> Any:
    """A node as plain values, by the safe constructors only."""
    if isinstance(node, yaml.SequenceNode) and node.tag.endswith(":seq"):
        return [_plain_value(item, path) for item in node.value]
    if isinstance(node, yaml.MappingNode) and node.tag.endswith(":map"):
        return _plain_mapping(node, path)
    try:
        value = yaml.constructor.SafeConstructor().construct_document(node)
        if isinstance(value, int):
            float(value)
    except (ValueError, OverflowError) as error:
        # such as the 45th of a month, or a number of four hundred digits
        raise _mistake(path, node, f"a value cannot be read ({error}); correct it.") from error
    if isinstance(value, int | float) and _NUMBER_OF_ANOTHER_BASE.match(node.value):
        raise _mistake(
            path,
            node,
            f"found {node.value}, which YAML reads as {value:g}. Write a number without leading "
            "zeros and colons, or put the text in quotes.",
        )
    return value


def _plain_mapping(node: yaml.MappingNode, path: Path) -> dict[Any, Any]:
    """A group of keys as plain values; each key is one word and is there once."""
    line_by_key: dict[Any, int] = {}
    values = {}
    for key, value in node.value:
        if not isinstance(key, yaml.ScalarNode):
            raise _mistake(path, key, "found a group as a key; expected one word.")
        if key.tag.endswith(":merge"):
            raise _mistake(path, key, "`<<` takes keys from elsewhere; write them out.")
        if key.value in line_by_key:
            first_line = f"(first defined at line {line_by_key[key.value]})"
            raise _mistake(
                path, key, f"duplicate key {key.value!r} {first_line}; keep one of them."
            )
        line_by_key[key.value] = _line_number(key)
        values[_plain_value(key, path)] = _plain_value(value, path)
    return values


def _text_of_file(path: Path) -> str:
    """Text of a file of settings.

    Raises:
        OilfilmError: It does not exist, is too large or is no UTF-8 text.
    """
    if not path.exists():
        raise OilfilmError(f"{path}: there is no such file. Run from the top folder of a project.")
    # a pipe is no plain file and may never end
    if not path.is_file() or path.stat().st_size > _MAX_BYTES:
        expected = f"a plain file of at most {_MAX_BYTES} bytes"
        raise OilfilmError(f"{path}: cannot be read as settings; expected {expected}.")
    try:
        content = path.read_bytes()
        return content.decode("utf-8")
    except OSError as error:
        raise OilfilmError(f"{path}: cannot be read ({error}).") from error
    except UnicodeDecodeError as error:
        line = content[: error.start].count(b"\n") + 1
        problem = f"cannot be read as UTF-8 text (byte 0x{content[error.start]:02x})"
        raise OilfilmError(f"{path}, line {line}: {problem}; save the file as UTF-8.") from error


def _mistake(path: Path, marked: yaml.Node | yaml.Event, sentence: str) -> OilfilmError:
    """The error for a node or event of PyYAML, with its line."""
    return OilfilmError(f"{path}, line {_line_number(marked)}: {sentence}")


def _line_number(marked: Any) -> int:
    """Line of a node or event of PyYAML, counted from 1."""
    return int(marked.start_mark.line) + 1
