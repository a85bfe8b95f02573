"""Configuration: safe YAML, checked against a schema, every mistake told with file and line.

Only the standard library, PyYAML and jsonschema are imported here, because the Snakefile reads
the configuration each time it is parsed.
"""

import difflib
import json
from collections.abc import Hashable, Iterator, Mapping, Sequence
from functools import cache
from pathlib import Path, PurePosixPath
from typing import Any

import jsonschema
import yaml

from oilfilm.bearing.possible import impossible
from oilfilm.errors import OilfilmError

_TYPE_NAMES = {
    "object": "a group of keys",
    "array": "a list",
    "string": "text",
    "number": "a number",
    "integer": "a whole number",
    "boolean": "true or false",
    "null": "nothing",
}
# Keys of a campaign file that say nothing about the run, only about the data that come of it.
_ABOUT = ("title", "licence", "date", "creators", "sources")
# Keys that are looked for one level too high.
_GROUP_OF = dict.fromkeys(("traction_sign", "slower_body", "zero"), "semantics")
# Figures that need a bearing.
_BEARING_FIGURES = {"tab03", "fig06", "cage-slip", "size-effect", "power-loss"}
# No quantity of a rig or an oil is larger in its unit; arithmetic with such would overflow.
_LARGEST = 1e15
_SCHEMAS = Path(__file__).parents[2] / "schemas"


def load_yaml(path: Path) -> dict[str, Any]:
    """Read one YAML file as plain values.

    Raises:
        OilfilmError: The file is missing, is not valid YAML, repeats a key, uses an alias or a
            tag, or does not hold a group of keys.
    """
    node = _compose(path)
    if not isinstance(node, yaml.MappingNode):
        raise OilfilmError(f"{path}: found no keys; expected `key: value` lines.")
    _refuse_repeated_keys(node, path)
    try:
        # construct from the composed node with the safe constructors only
        loaded = yaml.constructor.SafeConstructor().construct_document(node)
    except yaml.YAMLError as error:
        raise _yaml_error(path, error) from error
    except ValueError as error:
        # as of the 45th of a month, or of a number of five thousand digits
        raise OilfilmError(f"{path}: a value cannot be read ({error}); correct it.") from error
    _refuse_endless(loaded, path)
    return dict(loaded)


def load_checked(path: Path, schema_name: str) -> dict[str, Any]:
    """Read one YAML file and check it against `workflow/schemas/<schema_name>.schema.json`.

    Raises:
        OilfilmError: As `load_yaml`, or a key or value is not as the schema says.
    """
    values = load_yaml(path)
    problem = _first_problem(values, schema_name)
    if problem is not None:
        where = f"{path}, line {_line_of(path, problem)}"
        raise OilfilmError(f"{where}: {_explain(problem)}")
    return values


def first_mistake(values: Any, schema_name: str) -> str:
    """What is wrong first with values against a schema, in a sentence; empty where nothing is."""
    problem = _first_problem(values, schema_name)
    return "" if problem is None else _explain(problem)


def resolve(folder: Path, overrides: Mapping[str, Any]) -> dict[str, Any]:
    """Everything that one campaign's run is told: settings, campaign, rigs and oils in one tree.

    Args:
        folder: The configuration folder (`config`).
        overrides: Keys given on the command line; they win over `config.yaml`. A campaign's own
            `settings` stand between the two.

    Returns:
        The settings of `config.yaml` with the keys `campaign` (the campaign file, with its name
        under `name`), `dataset` (what that file says of the data: title, licence, creators,
        sources), `rigs` and `oils` (by id; None where an oil has no known properties) added.

    Raises:
        OilfilmError: A file is missing or has a mistake.
    """
    settings = load_checked(folder / "config.yaml", "config")
    name = _safe_name(overrides.get("campaign", settings["campaign"]), folder / "config.yaml")
    path = folder / "campaigns" / f"{name}.yaml"
    if not path.is_file():
        known = ", ".join(_names_in(path.parent))
        raise OilfilmError(
            f"{path}: there is no such campaign file. Campaigns here: {known}. Copy "
            f"{folder / 'campaigns' / 'template.yaml'} to that name and fill it in."
        )
    campaign = load_checked(path, "campaign")
    merged = merge(settings, campaign.pop("settings", {}))
    given = {key: value for key, value in overrides.items() if key != "campaign"}
    given = _with_numbers(given)
    _refuse_endless(given, "the command line's --config")
    merged = merge(merged, given)
    problem = _first_problem({**merged, "campaign": name}, "config")
    if problem is not None:
        raise OilfilmError(f"{path} (settings) or the command line's --config: {_explain(problem)}")
    # apart from the campaign, so that a corrected title redoes no fit
    merged["dataset"] = {key: campaign.pop(key) for key in _ABOUT if key in campaign}
    merged["campaign"] = {"name": name, **campaign}
    for steps, complaint in _contradictions(campaign, merged):
        raise OilfilmError(f"{path}, line {_line_at(path, steps)}: {complaint}")
    for kind in ("rig", "oil"):
        line = f"{path}, line {_line_at(path, [f'{kind}s'])}"
        merged[f"{kind}s"] = {
            name: _load_named(folder / f"{kind}s", name, kind, line)
            for name in campaign[f"{kind}s"]
        }
    merged["bearings"] = _bearings(folder, campaign, path)
    merged["oils"] |= {oil: None for oil in campaign.get("oils_without_properties", [])}
    return merged


def as_yaml(values: Mapping[str, Any]) -> str:
    """Plain values as YAML that `load_yaml` reads back, keys in their own order."""
    # no aliases, which are refused; no sorting: tables follow the order of levels and oils
    return yaml.dump(values, Dumper=_Plain, sort_keys=False, allow_unicode=True, width=100)


class _Plain(yaml.SafeDumper):
    def ignore_aliases(self, _: Any) -> bool:
        return True


def unresolve(config: Mapping[str, Any]) -> dict[str, str]:
    """A configuration folder that `resolve` turns into this: paths below it and their text."""
    settings, campaign = dict(config), dict(config["campaign"])
    name = settings["campaign"] = campaign.pop("name")
    about = settings.pop("dataset")
    files = {f"campaigns/{_safe_name(name, 'campaign')}.yaml": {**campaign, **about}}
    for kind in ("rigs", "oils", "bearings"):
        for thing, values in settings.pop(kind).items():
            if values is not None:
                files[f"{kind}/{_safe_name(thing, kind)}.yaml"] = values
    return {path: as_yaml(values) for path, values in {"config.yaml": settings, **files}.items()}


def _bearings(folder: Path, campaign: Mapping[str, Any], path: Path) -> dict[str, Any]:
    """The bearings of a campaign with torque logs, by name, and those of published figures."""
    if "torque" not in campaign:
        return {}
    asked_by = f"{path}, line {_line_at(path, ['torque', 'bearing'])}"
    name = campaign["torque"]["bearing"]
    others = set(_names_in(folder / "bearings")) - {name}
    found = {
        name: _load_named(folder / "bearings", name, "bearing", asked_by)
        for name in [name, *sorted(others)]
    }
    file = folder / "bearings" / f"{name}.yaml"
    for key, complaint in impossible(found[name]):
        raise OilfilmError(f"{file}, line {_line_at(file, key.split('.'))}, `{key}`: {complaint}")
    return found


def _contradictions(
    campaign: Mapping[str, Any], merged: Mapping[str, Any]
) -> Iterator[tuple[list[object], str]]:
    """What the keys of a campaign file say against each other: the key meant, and a sentence."""
    known, unknown = campaign["oils"], campaign.get("oils_without_properties", [])
    if not [*known, *unknown]:
        yield ["oils"], "the campaign names no oil; list at least one under `oils`."
    for oil in set(known) & set(unknown):
        yield (
            ["oils_without_properties"],
            f"the oil {oil!r} stands under `oils` too; keep it in one of the two.",
        )
    drawn = merged["figures"]["fig02"]["oil"]
    if "fig02" in campaign["figures"] and drawn not in [*known, *unknown]:
        yield (
            ["figures"],
            f"fig02 shows the oil {drawn!r} (figures.fig02.oil of config.yaml), which the campaign "
            "does not have; name one of its own under `settings: {figures: {fig02: {oil: ...}}}`.",
        )
    shown = merged["figures"]["extrapolation"]["oil"]
    if "extrapolation" in campaign["figures"] and "twin" not in campaign:
        yield (
            ["figures"],
            "the figure `extrapolation` needs the truth of a rig twin, and this campaign has none; "
            "take it off the list.",
        )
    elif "extrapolation" in campaign["figures"] and shown not in known:
        yield (
            ["figures"],
            f"extrapolation shows the oil {shown!r} (figures.extrapolation.oil of config.yaml), "
            "which the twin does not simulate; name one of its own under `settings: {figures: "
            "{extrapolation: {oil: ...}}}`.",
        )
    for rig in set(campaign.get("semantics_of_rig", {})) - set(campaign["rigs"]):
        yield (
            ["semantics_of_rig", rig],
            f"{rig!r} is none of the campaign's rigs ({', '.join(campaign['rigs'])}).",
        )
    if "twin" in campaign and campaign["data"] != "simulated":
        yield ["data"], "the rig twin makes these logs: say `data: simulated`, or drop `twin`."
    if "twin" in campaign and len(campaign["rigs"]) != 1:
        yield ["rigs"], "the rig twin makes logs of one rig; name one."
    if "twin" in campaign and "matrix" not in campaign:
        yield ["twin"], "the rig twin needs a `matrix` of conditions."
    torque = campaign.get("torque", {})
    if "torque" not in campaign and (drawn := set(campaign["figures"]) & _BEARING_FIGURES):
        yield (
            ["figures"],
            f"{sorted(drawn)[0]} shows a bearing, and the campaign has no `torque`; add it, or "
            "leave the figure out.",
        )
    if "twin" in torque and campaign["data"] != "simulated":
        yield ["data"], "the torque rig's twin makes logs: say `data: simulated`, or drop `twin`."
    if "twin" in torque and "twin" not in campaign:
        yield ["torque"], "the torque rig's twin needs the truth of the rig twin: add `twin`."
    for defect in torque.get("twin", {}).get("defects", []):
        if defect["oil"] not in known:
            yield (
                ["torque", "twin", "defects"],
                f"a planted defect names the oil {defect['oil']!r}, which the campaign does not "
                "have.",
            )
    for name, box in merged["printed"]["boxes"].items():
        for quantity, (low, high) in box.items():
            if low >= high:
                yield (
                    ["settings"],
                    f"printed.boxes.{name}.{quantity} goes from {low:g} to {high:g}; expected the "
                    "smaller first.",
                )
    gates = merged["gates"]
    for low, high in (
        ("slide_roll_ratio_min", "slide_roll_ratio_max"),
        ("traction_min", "traction_max"),
    ):
        if gates[low] >= gates[high]:
            yield (
                ["settings"],
                f"gates.{low} is {gates[low]:g}, {high} {gates[high]:g}; expected it below.",
            )


def merge(base: Mapping[str, Any], above: Mapping[str, Any]) -> dict[str, Any]:
    """`base` with the values of `above` laid over it, group by group."""
    merged = dict(base)
    for key, value in above.items():
        if isinstance(value, Mapping) and isinstance(merged.get(key), Mapping):
            merged[key] = merge(merged[key], value)
        else:
            merged[key] = value
    return merged


def _with_numbers(given: Any) -> Any:
    """Values of the command line, on which Snakemake leaves numbers inside groups as text."""
    if isinstance(given, Mapping):
        return {key: _with_numbers(value) for key, value in given.items()}
    if not isinstance(given, str):
        return given
    try:
        value = yaml.safe_load(given)
    except (yaml.YAMLError, ValueError, RecursionError):
        return given
    return value if isinstance(value, int | float) else given


def _load_named(folder: Path, name: str, schema_name: str, asked_by: str) -> dict[str, Any]:
    path = folder / f"{_safe_name(name, asked_by)}.yaml"
    if not path.is_file():
        known = ", ".join(_names_in(folder))
        raise OilfilmError(
            f"{asked_by}: `{schema_name}s` names {name!r}, but {path} does not exist. "
            f"Known: {known}. Write that file, or correct the name."
        )
    return load_checked(path, schema_name)


def _names_in(folder: Path) -> list[str]:
    return sorted(found.stem for found in folder.glob("*.yaml") if found.stem != "template")


def _safe_name(name: object, asked_by: object) -> str:
    """A name that becomes part of a path: one plain word, so that no path can leave its folder."""
    text = str(name)
    plain = all(letter.isalnum() or letter in "-_." for letter in text)
    if not text or not plain or PurePosixPath(text).name != text or text.startswith("."):
        raise OilfilmError(
            f"{asked_by}: {text!r} cannot be a name: use letters, digits, '-', '_' and '.', "
            "not starting with '.'."
        )
    return text


def _compose(path: Path) -> yaml.Node | None:
    try:
        text = path.read_text(encoding="utf-8")
    except FileNotFoundError as error:
        raise OilfilmError(
            f"{path}: there is no such file. Run from the top folder of the project."
        ) from error
    except (OSError, UnicodeDecodeError) as error:
        raise OilfilmError(f"{path}: cannot be read as UTF-8 text ({error}).") from error
    try:
        for event in yaml.parse(text, Loader=yaml.SafeLoader):
            # an alias can unfold one small file into gigabytes
            if isinstance(event, yaml.AliasEvent):
                line = _line(event.start_mark)
                raise OilfilmError(
                    f"{path}, line {line}: found the alias *{event.anchor}; write the value out."
                )
        return yaml.compose(text, Loader=yaml.SafeLoader)
    except yaml.YAMLError as error:
        raise _yaml_error(path, error) from error
    except RecursionError:
        raise OilfilmError(f"{path}: groups stand in groups without end; write fewer.") from None


def _line(mark: Any) -> int:
    """Line of a mark of PyYAML, counted from 1."""
    return int(mark.line) + 1


def _yaml_error(path: Path, error: yaml.YAMLError) -> OilfilmError:
    mark = getattr(error, "problem_mark", None)
    where = f"{path}, line {_line(mark)}" if mark is not None else str(path)
    reason = getattr(error, "problem", None) or str(error)
    if "\\t" in reason:
        reason += "; indent with spaces, not with tabs"
    if "mapping values" in reason:
        reason += "; put text that holds a colon in quotes"
    return OilfilmError(f"{where}: not valid YAML: {reason}.")


def _refuse_endless(value: Any, path: object) -> None:
    """Numbers that compare with nothing would switch gates off."""
    if isinstance(value, int | float) and not abs(value) < _LARGEST:
        found = value if isinstance(value, float) else f"of {value.bit_length()} bits"
        raise OilfilmError(
            f"{path}: found the number {found}; expected a finite one, below {_LARGEST:g}."
        )
    parts = value.values() if isinstance(value, dict) else value if isinstance(value, list) else ()
    for part in parts:
        _refuse_endless(part, path)


def _refuse_repeated_keys(node: yaml.Node, path: Path) -> None:
    if isinstance(node, yaml.SequenceNode):
        for item in node.value:
            _refuse_repeated_keys(item, path)
    if not isinstance(node, yaml.MappingNode):
        return
    seen: dict[Hashable, int] = {}
    for key, value in node.value:
        line = _line(key.start_mark)
        if not isinstance(key, yaml.ScalarNode):
            raise OilfilmError(f"{path}, line {line}: found a group as a key; expected one word.")
        if key.value in seen:
            raise OilfilmError(
                f"{path}, line {line}: the key {key.value!r} stands already at line "
                f"{seen[key.value]}; keep one of them."
            )
        seen[key.value] = line
        _refuse_repeated_keys(value, path)


@cache
def _validator(schema_name: str) -> jsonschema.Draft202012Validator:
    schemas = {
        file.name: json.loads(file.read_text(encoding="utf-8"))
        for file in sorted(_SCHEMAS.glob("*.schema.json"))
    }
    schema = schemas[f"{schema_name}.schema.json"]
    if schema_name == "campaign":
        settings = _all_optional(schemas["config.schema.json"])
        del settings["properties"]["campaign"]
        schema["properties"]["settings"] |= settings
    return jsonschema.Draft202012Validator(schema)


def _all_optional(schema: Any) -> Any:
    """A schema that asks for no key, at any depth."""
    if isinstance(schema, list):
        return [_all_optional(part) for part in schema]
    if not isinstance(schema, dict):
        return schema
    return {key: _all_optional(part) for key, part in schema.items() if key != "required"}


def _first_problem(values: Mapping[str, Any], schema_name: str) -> Any:
    """The first jsonschema.ValidationError in the order of keys, None where there is none.

    Typed loosely, here and below: upstream types its fields as "perhaps not set".
    """
    problems = _validator(schema_name).iter_errors(values)
    return min(problems, key=lambda found: [str(part) for part in found.path], default=None)


def _explain(problem: Any) -> str:
    """The schema's complaint as: key, what was found, what was expected."""
    key = ".".join(str(part) for part in problem.absolute_path)
    under = f" under `{key}`" if key else ""
    if problem.validator == "additionalProperties":
        known = list(problem.schema.get("properties", {}))
        unknown = next(name for name in problem.instance if name not in known)
        near = difflib.get_close_matches(str(unknown), known, n=1)
        hint = f" Did you mean {near[0]!r}?" if near else ""
        if unknown in _GROUP_OF:
            hint = f" It stands under `{_GROUP_OF[unknown]}`."
        return (
            f"found the unknown key {unknown!r}{under}; expected one of "
            f"{', '.join(sorted(known))}.{hint}"
        )
    if problem.validator == "required":
        missing = next(name for name in problem.validator_value if name not in problem.instance)
        meaning = problem.schema.get("properties", {}).get(missing, {}).get("description", "")
        return f"the key {missing!r} is missing{under}. {meaning}".rstrip()
    meaning = problem.schema.get("description", "")
    expected = _expected(problem)
    hint = _hint(problem)
    return f"`{key}`: found {problem.instance!r}, expected {expected}.{hint} {meaning}".rstrip()


def _hint(problem: Any) -> str:
    """What to write where YAML took a number for text."""
    if problem.validator == "type" and isinstance(problem.instance, str):
        try:
            return f" Write {float(problem.instance):#}, with a point and no quotes."
        except ValueError:
            pass
    return ""


def _expected(problem: Any) -> str:
    wanted = problem.validator_value
    match problem.validator:
        case "type":
            names = wanted if isinstance(wanted, list) else [wanted]
            return " or ".join(_TYPE_NAMES[name] for name in names)
        case "enum":
            return "one of " + ", ".join(repr(value) for value in wanted)
        case "const":
            return repr(wanted)
        case "minimum":
            return f"{wanted} or more"
        case "exclusiveMinimum":
            return f"more than {wanted}"
        case "maximum":
            return f"{wanted} or less"
        case "exclusiveMaximum":
            return f"less than {wanted}"
        case "pattern":
            return f"text of the form {wanted}"
        case _:
            return str(problem.message)


def _line_of(path: Path, problem: Any) -> int:
    """The line of the key that the problem is about (of its group where the key is missing)."""
    steps: list[object] = list(problem.absolute_path)
    if problem.validator == "additionalProperties":
        known = problem.schema.get("properties", {})
        steps.append(next(name for name in problem.instance if name not in known))
    return _line_at(path, steps)


def _line_at(path: Path, steps: Sequence[object]) -> int:
    """The line of a key or item of a YAML file, or of the last group on the way to it."""
    node, line = _compose(path), 1
    for step in steps:
        if isinstance(node, yaml.MappingNode):
            found = [pair for pair in node.value if str(pair[0].value) == str(step)]
            if not found:
                return line
            key, node = found[0]
            line = _line(key.start_mark)
        elif isinstance(node, yaml.SequenceNode):
            node = node.value[int(str(step))]
            line = _line(node.start_mark)
    return line
