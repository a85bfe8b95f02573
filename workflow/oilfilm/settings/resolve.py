"""Settings of one campaign's run, from the files of config/ and the command line.

Decides: the precedence of settings (the command line, then `settings` of the campaign file, then
`config.yaml` of the project, then the one of oilfilm); which folder a campaign, rig, oil or bearing
is read from; which name of an oil is whose; which keys of a campaign contradict each other, and
what a figure needs to be drawn.
"""

import re
from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import yaml

from oilfilm import studies
from oilfilm.errors import OilfilmError, cut
from oilfilm.figure_catalogue import figures
from oilfilm.home import CONFIG
from oilfilm.settings.base import Group, plain_key
from oilfilm.settings.campaign import Campaign, CampaignFile, Dataset
from oilfilm.settings.config import Config, ConfigKeys
from oilfilm.settings.messages import Steps, check_file
from oilfilm.settings.resolved import Settings, merge
from oilfilm.settings.rig import BearingFile, OilFile, Rig
from oilfilm.settings.yaml_file import YamlFile, as_yaml, dotted, leaves, read_yaml

# A file system takes 255 bytes; a release and the exports append to names.
_LONGEST_NAME = 100
_NAME = re.compile(r"[\w-][\w.-]*")
_MODELS: dict[str, Any] = {"rig": Rig, "oil": OilFile, "bearing": BearingFile}


def resolve_given(given: Mapping[str, Any], typed: Mapping[str, Any]) -> Settings:
    """The settings of a workflow, from the configuration that Snakemake gives it.

    As a module of another workflow it may be given a section of that workflow's configuration. This
    takes the place of `config.yaml`; its key `folder` names the configuration folder.

    Args:
        given: Snakemake's `config`.
        typed: What of it was typed on the command line.

    Raises:
        OilfilmError: A file is missing or has a mistake.
    """
    folder = Path(given.get("folder", "config"))
    section = {name: value for name, value in given.items() if name != "folder"}
    on_line = {name: typed[name] for name in typed if name in section}
    # all that a clone is given was typed, and its own config.yaml counts
    return resolve(folder, on_line, section if section != on_line else None)


def resolve(
    folder: Path, overrides: Mapping[str, Any], section: Mapping[str, Any] | None = None
) -> Settings:
    """Everything that one campaign's run is told, in one tree; each value is validated once.

    Args:
        folder: The configuration folder (`config`). Its `config.yaml` needs only the keys that
            differ from those that are part of oilfilm; oils, rigs, bearings and campaigns that it
            lacks are taken from there as well.
        overrides: Keys given on the command line.
        section: What takes the place of `config.yaml`.

    Returns:
        The keys of `config.yaml`, with `campaign` (the campaign file and its `name`), `dataset`
        (what that file says of the data), `rigs`, `oils` and `bearings` by name.

    Raises:
        OilfilmError: A file is missing or has a mistake.
    """
    config, given = _config_file(folder, section), dict(overrides)
    named_at = "campaign on the command line" if "campaign" in given else folder / "config.yaml"
    name = given.pop("campaign", config.values["campaign"])
    file = _read(folder, "campaign", name, str(named_at))
    campaign: CampaignFile = check_file(file, CampaignFile)
    keys = _merged_keys(config, file, given)

    def named(kind: str, names: list[str], *steps: str) -> dict[str, Any]:
        named_at = f"{file.location_of(steps)}, `{dotted(steps)}`"
        return {name: named_file(folder, kind, name, named_at) for name in names}

    oils = named("oil", campaign.oils, "oils")
    bearings = []
    if campaign.torque is not None:
        # those of published figures too
        bearings = list(dict.fromkeys([campaign.torque.bearing, *_files(folder, "bearing")]))
    settings = Settings.model_construct(
        **_written(ConfigKeys, keys),
        split=keys.split,
        campaign=Campaign.model_construct(name=str(name), **_written(Campaign, campaign)),
        # apart from the campaign, so that a corrected title redoes no fit
        dataset=Dataset.model_construct(**_written(Dataset, campaign)),
        rigs=named("rig", campaign.rigs, "rigs"),
        bearings=named("bearing", bearings, "torque", "bearing"),
        oils={**oils, **dict.fromkeys(campaign.oils_without_properties)},
    )
    for steps, sentence in (*_names_of_two_oils(settings), *_contradictions(settings)):
        raise OilfilmError(f"{file.location_of(steps)}: {sentence}")
    return settings


def _written(model: type[Group], source: Group) -> dict[str, Any]:
    """The keys of a model that were written, from a group that has more."""
    names = source.model_fields_set & model.model_fields.keys()
    return {name: getattr(source, name) for name in names}


def read_config(folder: Path) -> Config:
    """The keys of a project's `config.yaml` over those that are part of oilfilm.

    Raises:
        OilfilmError: The file is missing or has a mistake.
    """
    config: Config = check_file(_config_file(folder), Config)
    return config


def _config_file(folder: Path, section: Mapping[str, Any] | None = None) -> YamlFile:
    defaults = read_yaml(CONFIG / "config.yaml")
    if section is None:
        own = read_yaml(folder / "config.yaml")
    else:
        own = YamlFile(Path("the module's config"), dict(section), yaml.MappingNode("", []))
    return replace(own, values=merge(defaults.values, own.values))


def unresolve(settings: Settings) -> dict[str, str]:
    """A configuration folder that `resolve` turns into this: paths below it and their text."""
    config = settings.plain()
    campaign = dict(config["campaign"])
    name = config["campaign"] = campaign.pop("name")
    about = config.pop("dataset")
    files = {f"campaigns/{safe_name(name, 'campaign')}.yaml": {**campaign, **about}}
    for kind in ("rigs", "oils", "bearings"):
        for thing, values in config.pop(kind).items():
            if values is not None:
                files[f"{kind}/{safe_name(thing, kind)}.yaml"] = values
    return {path: as_yaml(values) for path, values in {"config.yaml": config, **files}.items()}


def _files(folder: Path, kind: str) -> dict[str, Path]:
    """All files of a kind by name, but for the template; a project's own before oilfilm's."""
    both = (path for each in (CONFIG, folder) for path in (each / f"{kind}s").glob("*.yaml"))
    found = {path.stem: path for path in both}
    return {name: found[name] for name in sorted(found) if name != "template"}


def _read(folder: Path, kind: str, name: object, named_at: str) -> YamlFile:
    """The file of one campaign, rig, oil or bearing."""
    known, safe = _files(folder, kind), safe_name(name, named_at)
    template = CONFIG / f"{kind}s/template.yaml"
    if safe not in known and safe != template.stem:
        path = folder / f"{kind}s/{safe}.yaml"
        raise OilfilmError(
            f"{named_at}: names the {kind} {safe!r}, but {path} does not exist. Known: "
            f"{', '.join(known)}. Correct the name, or copy {template} there and fill it in."
        )
    return read_yaml(known.get(safe, template))


def named_file(folder: Path, kind: str, name: str, named_at: str) -> Any:
    """A rig, oil or bearing by its name, from its file.

    Args:
        folder: The configuration folder.
        kind: `rig`, `oil` or `bearing`.
        name: Its name.
        named_at: Where it was named, as the message begins.

    Raises:
        OilfilmError: There is no such file, or it has a mistake.
    """
    file = _read(folder, kind, name, named_at)
    found = check_file(file, _MODELS[kind])
    if kind == "oil" and found.id != name:
        raise OilfilmError(
            f"{file.location_of(('id',))}, `id`: found {found.id!r}, expected {name!r}, the file's "
            "name."
        )
    return found


def _merged_keys(config: YamlFile, campaign: YamlFile, given: Mapping[str, Any]) -> Config:
    """The keys of config.yaml, with those of the campaign and of the command line over them."""
    own, given = campaign.values.get("settings", {}), _with_numbers(given, config.values)

    def location_of(steps: Steps) -> str:
        # the last key may be one of several that contradict each other: look for its group too
        for known in (steps, steps[:-1]):
            if known in _all_steps(given):
                return "the command line's --config"
            if known in _all_steps(own):
                return campaign.location_of(("settings", *steps))
        return config.location_of(steps)

    if "campaign" in own:
        raise OilfilmError(
            f"{campaign.location_of(('settings', 'campaign'))}: `settings` cannot name another "
            "campaign; leave the key out."
        )
    merged = merge(merge(config.values, own), given)
    return check_file(replace(config, values=merged), Config, location_of)


def _all_steps(values: Any) -> set[Steps]:
    """The steps to every value and every group above it."""
    return {steps[: n + 1] for steps, _ in leaves(values) for n in range(len(steps))}


def _with_numbers(given: Any, defaults: Any) -> Any:
    """Values of the command line, on which Snakemake leaves numbers inside groups as text.

    What is text by default, as the oil "4102", stays text.
    """
    if isinstance(given, Mapping):
        below = defaults if isinstance(defaults, Mapping) else {}
        return {name: _with_numbers(value, below.get(name)) for name, value in given.items()}
    if not isinstance(given, str) or isinstance(defaults, str):
        return given
    try:
        value = yaml.safe_load(given)
        return value if isinstance(value, int | float) and float(value) == value else given
    except (yaml.YAMLError, ValueError, OverflowError, RecursionError):
        return given


def _names_of_two_oils(settings: Settings) -> Iterator[tuple[Steps, str]]:
    """Names that a log may give to two oils, with the key of the campaign file to blame."""
    oil_of: dict[str, str] = {}
    campaign = settings.campaign.oil_aliases
    for oil in campaign.keys() - settings.oils.keys():
        known = ", ".join(settings.oils)
        yield ("oil_aliases", oil), f"{oil!r} is none of the campaign's oils ({known})."
    for oil in settings.oils:
        for name in settings.names_of(oil):
            other = oil_of.setdefault(plain_key(name), oil)
            if other != oil:
                steps = ("oil_aliases", oil) if name in campaign.get(oil, ()) else ("oils",)
                sentence = (
                    f"{name!r} is a name of {oil!r} (`aliases` of its file, `oil_aliases`), but is "
                    f"one of {other!r} too; a log with it could be of either. Leave it with one."
                )
                yield steps, sentence


def _contradictions(settings: Settings) -> Iterator[tuple[Steps, str]]:
    """Every contradiction: the key of the campaign file to blame, and a sentence."""
    campaign = settings.campaign
    if not [*campaign.oils, *campaign.oils_without_properties]:
        yield ("oils",), "the campaign names no oil; list at least one under `oils`."
    for oil in set(campaign.oils) & set(campaign.oils_without_properties):
        sentence = f"the oil {oil!r} is listed under `oils` too; keep it in one of the two."
        yield ("oils_without_properties",), sentence
    for rig in campaign.semantics_of_rig.keys() - set(campaign.rigs):
        known = ", ".join(campaign.rigs)
        yield ("semantics_of_rig", rig), f"{rig!r} is none of the campaign's rigs ({known})."
    yield from _named_twice(campaign)
    yield from _simulation(campaign)
    yield from _figures(settings)


def _named_twice(campaign: Campaign) -> Iterator[tuple[Steps, str]]:
    """One name of a log for two of the project's."""
    torque = campaign.torque.columns if campaign.torque else {}
    of_columns = {("columns", key): column.name for key, column in campaign.columns.items()}
    of_torque = {("torque", "columns", key): column.name for key, column in torque.items()}
    of_header = {("header", key): names for key, names in campaign.header.items()}
    for named in (of_columns, of_torque, of_header):
        first: dict[str, tuple[str, ...]] = {}
        for steps, names in named.items():
            for name in names:
                other = first.setdefault(name, steps)
                if other != steps:
                    sentence = f"{name!r} is listed for {other[-1]!r} too; leave it with one."
                    yield steps, f"`{'.'.join(steps)}`: {sentence}"


def _simulation(campaign: Campaign) -> Iterator[tuple[Steps, str]]:
    """What simulates the logs, and what it needs."""
    twin, torque_twin = campaign.twin, campaign.torque.twin if campaign.torque else None
    simulates = "twin" if twin or torque_twin else "simulated_by" if campaign.simulated_by else ""
    if simulates and campaign.data != "simulated":
        at = "data" if simulates == "twin" else simulates
        yield (at,), f"`{simulates}` simulates these logs: say `data: simulated`, or drop this key."
    if simulates == "twin" and not studies.simulator():
        yield ("twin",), "no package beside oilfilm simulates logs; use logs of a rig."
    if twin is not None and len(campaign.rigs) != 1:
        yield ("rigs",), "the rig twin simulates logs of one rig; name one."


def _figures(settings: Settings) -> Iterator[tuple[Steps, str]]:
    """Figures that do not exist, or that lack what they show."""
    campaign = settings.campaign
    for key, names, known in (
        ("figures", campaign.figures, [*figures()]),
        ("studies", campaign.studies, [*studies.available()]),
    ):
        for number, name in enumerate(names):
            if name not in known:
                allowed = ", ".join(map(repr, known))
                sentence = f"`{key}.{number}`: found {name!r}, expected one of {allowed}."
                yield (key, number), sentence
    for figure in (figures()[name] for name in campaign.figures if name in figures()):
        lacks = ""
        if figure.requires and getattr(campaign, figure.requires) is None:
            lacks = f"needs `{figure.requires}`; add it"
        elif figure.study and figure.study not in campaign.studies:
            lacks = f"belongs to the study {figure.study!r}; add `studies: [{figure.study}]`"
        if lacks:
            yield ("figures",), f"the figure `{figure.name}` {lacks}, or leave the figure out."
    shown = settings.figures.fig02.oil
    if "fig02" in campaign.figures and shown not in settings.oils:
        own = "name one of its own under `settings: {figures: {fig02: {oil: ...}}}`"
        yield ("figures",), f"fig02 shows the oil {shown!r}, which the campaign lacks; {own}."


def safe_name(name: object, named_at: object) -> str:
    """A name that becomes part of a path: one plain word, so that no path can leave its folder.

    Raises:
        OilfilmError: It is none; the sentence begins with `named_at`.
    """
    text = str(name)
    allowed = not isinstance(name, float) and _NAME.fullmatch(text)
    if not allowed or len(text.encode()) > _LONGEST_NAME:
        raise OilfilmError(
            f"{named_at}: {cut(name, 20)!r} cannot be a name: use letters, digits, '-', '_' and "
            f"'.', at most {_LONGEST_NAME} bytes, not starting with '.', and no decimal number."
        )
    return text
