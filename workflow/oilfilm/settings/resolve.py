"""Settings of one campaign's run, from the files of config/ and the command line.

Decides: the precedence of settings (the command line, then `settings` of the campaign file, then
`config.yaml` of the project, then the one of oilfilm); which folder a campaign, rig, oil or bearing
is read from; which oil a name means; the order of the oils in tables and figures (as the campaign
file lists them); which keys of a campaign contradict each other, and what a figure needs to be
drawn.
"""

import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from dataclasses import replace
from functools import partial
from itertools import chain
from pathlib import Path
from typing import Any

import yaml

from oilfilm.base import studies
from oilfilm.base.errors import OilfilmError, cut
from oilfilm.base.figure_catalogue import figures
from oilfilm.base.home import CONFIG
from oilfilm.base.plain_key import plain_key
from oilfilm.settings.base import Group
from oilfilm.settings.campaign import Campaign, CampaignFile, Dataset
from oilfilm.settings.config import Config, ConfigKeys
from oilfilm.settings.messages import Steps, check, check_file
from oilfilm.settings.resolved import Settings, merge
from oilfilm.settings.rig import BearingFile, OilFile, Rig
from oilfilm.settings.yaml_file import YamlFile, as_yaml, dotted, leaves, read_yaml

# In bytes. A file system takes 255; a release and the exports append to names.
_LONGEST_NAME = 100
_NAME = re.compile(r"[\w-][\w.-]*")
_MODELS: dict[str, Any] = {"rig": Rig, "oil": OilFile, "bearing": BearingFile}


def resolve_given(config: Mapping[str, Any], typed: Mapping[str, Any]) -> Settings:
    """The settings of a workflow, from the configuration that Snakemake passes to it.

    As a module of another workflow it may get a section of that workflow's configuration. This
    takes the place of `config.yaml`. Its key `folder` names the configuration folder.

    Args:
        config: Snakemake's `config`.
        typed: The keys of `config` that were typed on the command line.

    Raises:
        OilfilmError: A file is missing or has a mistake.
    """
    folder = Path(config.get("folder", "config"))
    section = {name: value for name, value in config.items() if name != "folder"}
    overrides = {name: value for name, value in typed.items() if name in section}
    if section == overrides:
        # not a module of another workflow: everything was typed, and config.yaml counts
        return resolve(folder, overrides)
    return resolve(folder, overrides, section)


def resolve(
    folder: Path, overrides: Mapping[str, Any], section: Mapping[str, Any] | None = None
) -> Settings:
    """All settings of one campaign's run in one tree; each value is validated once.

    Args:
        folder: The configuration folder (`config`). Its `config.yaml` needs only the keys that
            differ from oilfilm's own. Oils, rigs, bearings and campaigns that the folder lacks are
            taken from oilfilm as well.
        overrides: Keys given on the command line.
        section: Keys that take the place of `config.yaml`.

    Returns:
        The keys of `config.yaml`, with `campaign` (the campaign file and its `name`), `dataset`
        (that file's description of the data), `rigs`, `oils` and `bearings` by name.

    Raises:
        OilfilmError: A file is missing or has a mistake.
    """
    config_file = _config_file(folder, section)
    name = overrides.get("campaign", config_file.values["campaign"])
    named_at = str(folder / "config.yaml")
    if "campaign" in overrides:
        named_at = "campaign on the command line"
    campaign_file = _read_named_file(folder, "campaign", name, named_at)
    campaign: CampaignFile = check_file(campaign_file, CampaignFile)
    other_overrides = {key: value for key, value in overrides.items() if key != "campaign"}
    study_files = _study_files(campaign.studies)
    keys = _merged_keys(config_file, study_files, campaign_file, other_overrides)

    def files_by_name(kind: str, names: list[str], *steps: str) -> dict[str, Any]:
        listed_at = f"{campaign_file.location_of(steps)}, `{dotted(steps)}`"
        return {name: named_file(folder, kind, name, listed_at) for name in names}

    oils = files_by_name("oil", campaign.oils, "oils")
    oils.update(dict.fromkeys(campaign.oils_without_properties))
    bearing_names: list[str] = []
    if campaign.torque is not None:
        bearing_names.append(campaign.torque.bearing)
        # published figures show the others
        bearing_names += [
            name for name in _files_by_name(folder, "bearing") if name not in bearing_names
        ]
    config_keys = _written_keys(ConfigKeys, keys)
    # settings of a study that the campaign does not have change nothing
    config_keys["studies"] = {name: keys.studies[name] for name in study_files}
    settings = Settings.model_construct(
        **config_keys,
        split=keys.split,
        container=keys.container,
        campaign=Campaign.model_construct(name=str(name), **_written_keys(Campaign, campaign)),
        # apart from the campaign, so that a corrected title reruns no fit
        dataset=Dataset.model_construct(**_written_keys(Dataset, campaign)),
        rigs=files_by_name("rig", campaign.rigs, "rigs"),
        bearings=files_by_name("bearing", bearing_names, "torque", "bearing"),
        oils=oils,
    )
    for steps, sentence in chain(_names_shared_by_two_oils(settings), _contradictions(settings)):
        raise OilfilmError(f"{campaign_file.location_of(steps)}: {sentence}")
    _check_oils(folder, settings)
    return settings


def _check_oils(folder: Path, settings: Settings) -> None:
    """Check the oils over the temperatures of the campaign and of its bearing.

    Raises:
        OilfilmError: An oil has a property there that no oil has.
    """
    temperatures_c = list(_temperatures_of_use(settings))
    if not temperatures_c:
        return
    low_c, high_c = min(temperatures_c), max(temperatures_c)
    for name in settings.campaign.oils:
        oil = settings.oils[name]
        for steps, sentence in oil.faults(low_c, high_c) if oil else ():
            file = _read_named_file(folder, "oil", name, "oils")
            raise OilfilmError(
                f"{file.location_of(steps)}, `{dotted(steps)}`: {sentence} The campaign uses "
                f"the oil from {low_c:g} to {high_c:g} degC."
            )


def _temperatures_of_use(settings: Settings) -> Iterator[float]:
    """Temperatures of the campaign's conditions and of its bearing, in degC."""
    campaign = settings.campaign
    if campaign.set_points.inlet_temperature_c is not None:
        yield campaign.set_points.inlet_temperature_c
    if campaign.matrix is not None:
        yield from campaign.matrix.inlet_temperature_c
    if campaign.torque is None:
        return
    yield settings.bearing.cage_slip.inlet_temperature_c
    yield from (point.oil_temperature_c for point in settings.plan.duty_points)
    if campaign.torque.matrix is not None:
        yield from campaign.torque.matrix.oil_temperature_c


def _written_keys(model: type[Group], source: Group) -> dict[str, Any]:
    """The keys of a model that were written, from a group that may have others."""
    names = source.model_fields_set & model.model_fields.keys()
    return {name: getattr(source, name) for name in names}


def read_config(folder: Path) -> Config:
    """The keys of a project's `config.yaml`, with oilfilm's own for those that it lacks.

    Raises:
        OilfilmError: The file is missing or has a mistake.
    """
    config: Config = check_file(_config_file(folder), Config)
    return config


def _config_file(folder: Path, section: Mapping[str, Any] | None = None) -> YamlFile:
    defaults = read_yaml(CONFIG / "config.yaml")
    if section is None:
        project = read_yaml(folder / "config.yaml")
    else:
        project = YamlFile(Path("the module's config"), dict(section), yaml.MappingNode("", []))
    return replace(project, values=merge(defaults.values, project.values))


def unresolve(settings: Settings) -> dict[str, str]:
    """The files of a configuration folder with these settings; `resolve` is the inverse.

    Returns:
        The text of each file by its path below the folder.
    """
    config = settings.plain()
    campaign = dict(config["campaign"])
    name = campaign.pop("name")
    config["campaign"] = name
    campaign |= config.pop("dataset")
    contents = {f"campaigns/{safe_name(name, 'campaign')}.yaml": campaign}
    for folder in ("rigs", "oils", "bearings"):
        for file_name, values in config.pop(folder).items():
            if values is not None:
                contents[f"{folder}/{safe_name(file_name, folder)}.yaml"] = values
    contents["config.yaml"] = config
    return {path: as_yaml(values) for path, values in contents.items()}


def _files_by_name(folder: Path, kind: str) -> dict[str, Path]:
    """All files of a kind by name, without the template.

    A project's file replaces oilfilm's, which replaces the one of a study.
    """
    files = {}
    folders = [CONFIG / f"{kind}s", folder / f"{kind}s"]
    if kind == "campaign":
        folders = [*studies.campaign_folders(), *folders]
    for folder_of_kind in folders:
        for path in folder_of_kind.glob("*.yaml"):
            files[path.stem] = path
    files.pop("template", None)
    return dict(sorted(files.items()))


def campaign_names(folder: Path) -> list[str]:
    """Names of all campaigns that a project can run, those of studies included.

    Args:
        folder: The configuration folder.
    """
    return list(_files_by_name(folder, "campaign"))


def _read_named_file(folder: Path, kind: str, name: object, named_at: str) -> YamlFile:
    """The file of one campaign, rig, oil or bearing."""
    files = _files_by_name(folder, kind)
    stem = safe_name(name, named_at)
    template = CONFIG / f"{kind}s/template.yaml"
    if stem not in files and stem != template.stem:
        path = folder / f"{kind}s/{stem}.yaml"
        raise OilfilmError(
            f"{named_at}: names the {kind} {stem!r}, but {path} does not exist. Known: "
            f"{', '.join(files)}. Correct the name, or copy {template} there and fill it in."
        )
    return read_yaml(files.get(stem, template))


def named_file(folder: Path, kind: str, name: str, named_at: str) -> Any:
    """A rig, oil or bearing by its name, from its file.

    Args:
        folder: The configuration folder.
        kind: `rig`, `oil` or `bearing`.
        name: Its name.
        named_at: Where it was named; the beginning of the message.

    Raises:
        OilfilmError: There is no such file, or it has a mistake.
    """
    file = _read_named_file(folder, kind, name, named_at)
    content = check_file(file, _MODELS[kind])
    if kind == "oil" and content.id != name:
        raise OilfilmError(
            f"{file.location_of(('id',))}, `id`: found {content.id!r}, expected {name!r}, the "
            "file's name."
        )
    return content


def _study_files(names: Iterable[str]) -> dict[str, YamlFile]:
    """The files with the settings of studies; not every study has settings."""
    paths = {name: studies.settings_file(name) for name in names if name in studies.available()}
    return {name: read_yaml(path) for name, path in paths.items() if path.is_file()}


def _merged_keys(
    config: YamlFile,
    study_files: Mapping[str, YamlFile],
    campaign: YamlFile,
    overrides: Mapping[str, Any],
) -> Config:
    """The keys of config.yaml and of studies, replaced by those of the campaign and as typed."""
    study_defaults = {"studies": {study: file.values for study, file in study_files.items()}}
    defaults = merge(study_defaults, config.values)
    campaign_keys = campaign.values.get("settings", {})
    typed_keys = _with_typed_numbers(overrides, defaults)

    def location_of(steps: Steps) -> str:
        # the last key may be one of several that contradict each other: look for its group too
        for written_steps in (steps, steps[:-1]):
            if written_steps in _all_steps(typed_keys):
                return "the command line's --config"
            if written_steps in _all_steps(campaign_keys):
                return campaign.location_of(("settings", *steps))
        key, *steps_in_studies = steps
        if key == "studies" and steps not in _all_steps(config.values):
            study, *steps_in_study = steps_in_studies
            if study in study_files:
                return study_files[study].location_of(steps_in_study)
        return config.location_of(steps)

    if "campaign" in campaign_keys:
        raise OilfilmError(
            f"{campaign.location_of(('settings', 'campaign'))}: `settings` cannot name another "
            "campaign; leave the key out."
        )
    merged = merge(merge(defaults, campaign_keys), typed_keys)
    keys: Config = check_file(replace(config, values=merged), Config, location_of)
    _check_studies(keys, study_files, location_of)
    return keys


def _check_studies(
    keys: Config, study_files: Mapping[str, YamlFile], location_of: Callable[[Steps], str]
) -> None:
    """Check the settings of studies by the models of their packages.

    Raises:
        OilfilmError: There is no such study, or its settings have a mistake.
    """
    for name, values in keys.studies.items():
        if name not in studies.available():
            expected = ", ".join(studies.available())
            raise OilfilmError(
                f"{location_of(('studies', name))}: found settings of the study {name!r}; expected "
                f"one of {expected}."
            )
        if name in study_files:
            model = studies.settings_module(name).StudySettings
            check(values, model, partial(_location_in_study, name, location_of))


def _location_in_study(name: str, location_of: Callable[[Steps], str], steps: Steps) -> str:
    return location_of(("studies", name, *steps))


def _all_steps(values: Any) -> set[Steps]:
    """The steps to every value and every group above it."""
    all_steps: set[Steps] = set()
    for steps, _ in leaves(values):
        all_steps.update(steps[:length] for length in range(1, len(steps) + 1))
    return all_steps


def _with_typed_numbers(typed: Any, defaults: Any) -> Any:
    """Values of the command line with numbers where Snakemake leaves text, inside groups.

    A value that is text by default, such as the oil "4102", stays text.
    """
    if isinstance(typed, Mapping):
        group = defaults if isinstance(defaults, Mapping) else {}
        return {name: _with_typed_numbers(value, group.get(name)) for name, value in typed.items()}
    if not isinstance(typed, str) or isinstance(defaults, str):
        return typed
    try:
        value = yaml.safe_load(typed)
        is_number = isinstance(value, int | float) and float(value) == value
    except (yaml.YAMLError, ValueError, OverflowError, RecursionError):
        return typed
    return value if is_number else typed


def _names_shared_by_two_oils(settings: Settings) -> Iterator[tuple[Steps, str]]:
    """Names that a log may give to two oils, with the key of the campaign file to blame."""
    oil_by_name: dict[str, str] = {}
    aliases = settings.campaign.oil_aliases
    for oil in aliases.keys() - settings.oils.keys():
        oils = ", ".join(settings.oils)
        yield ("oil_aliases", oil), f"{oil!r} is none of the campaign's oils ({oils})."
    for oil in settings.oils:
        for name in settings.names_of(oil):
            first_oil = oil_by_name.setdefault(plain_key(name), oil)
            if first_oil != oil:
                steps = ("oil_aliases", oil) if name in aliases.get(oil, ()) else ("oils",)
                sentence = (
                    f"{name!r} is a name of {oil!r} (`aliases` of its file, `oil_aliases`), but is "
                    f"one of {first_oil!r} too; a log with it could be of either. Leave it with "
                    "one."
                )
                yield steps, sentence


def _contradictions(settings: Settings) -> Iterator[tuple[Steps, str]]:
    """Every contradiction: the key of the campaign file to blame, and a sentence."""
    campaign = settings.campaign
    if not campaign.oils and not campaign.oils_without_properties:
        yield ("oils",), "the campaign names no oil; list at least one under `oils`."
    for oil in set(campaign.oils) & set(campaign.oils_without_properties):
        sentence = f"the oil {oil!r} is listed under `oils` too; keep it in one of the two."
        yield ("oils_without_properties",), sentence
    for rig in campaign.semantics_of_rig.keys() - set(campaign.rigs):
        rigs = ", ".join(campaign.rigs)
        yield ("semantics_of_rig", rig), f"{rig!r} is none of the campaign's rigs ({rigs})."
    yield from _names_listed_for_two_keys(campaign)
    yield from _simulation_contradictions(campaign)
    yield from _figure_contradictions(settings)
    for name in settings.studies:
        yield from studies.settings_module(name).contradictions(settings)


def _names_listed_for_two_keys(campaign: Campaign) -> Iterator[tuple[Steps, str]]:
    """Names of a log's columns or header keys that are listed for two keys of the project."""
    columns = {("columns", key): column.name for key, column in campaign.columns.items()}
    torque_columns = {}
    if campaign.torque is not None:
        for key, column in campaign.torque.columns.items():
            torque_columns[("torque", "columns", key)] = column.name
    header_keys = {("header", key): names for key, names in campaign.header.items()}
    for names_by_steps in (columns, torque_columns, header_keys):
        first_steps: dict[str, tuple[str, ...]] = {}
        for steps, names in names_by_steps.items():
            for name in names:
                other_steps = first_steps.setdefault(name, steps)
                if other_steps != steps:
                    other_key = other_steps[-1]
                    sentence = f"{name!r} is listed for {other_key!r} too; leave it with one."
                    yield steps, f"`{'.'.join(steps)}`: {sentence}"


def _simulation_contradictions(campaign: Campaign) -> Iterator[tuple[Steps, str]]:
    """Contradictions about how the logs are simulated."""
    has_torque_twin = campaign.torque is not None and campaign.torque.twin is not None
    has_twin = campaign.twin is not None or has_torque_twin
    if campaign.data != "simulated":
        advice = "simulates these logs: say `data: simulated`, or drop this key."
        if has_twin:
            yield ("data",), f"`twin` {advice}"
        elif campaign.simulated_by:
            yield ("simulated_by",), f"`simulated_by` {advice}"
    if has_twin and not studies.simulator():
        yield ("twin",), "no package beside oilfilm simulates logs; use logs of a rig."
    if campaign.twin is not None and len(campaign.rigs) != 1:
        yield ("rigs",), "the rig twin simulates logs of one rig; name one."


def _figure_contradictions(settings: Settings) -> Iterator[tuple[Steps, str]]:
    """Figures and studies that do not exist, and figures that lack what they show."""
    campaign = settings.campaign
    yield from _unknown_names("figures", campaign.figures, list(figures()))
    yield from _unknown_names("studies", campaign.studies, list(studies.available()))
    for name in campaign.figures:
        if name not in figures():
            continue
        figure = figures()[name]
        what_to_do = ""
        if figure.requires and getattr(campaign, figure.requires) is None:
            what_to_do = f"needs `{figure.requires}`; add it"
        elif figure.study and figure.study not in campaign.studies:
            what_to_do = f"belongs to the study {figure.study!r}; add `studies: [{figure.study}]`"
        if what_to_do:
            yield ("figures",), f"the figure `{figure.name}` {what_to_do}, or leave the figure out."


def _unknown_names(
    key: str, names: Iterable[str], allowed: Collection[str]
) -> Iterator[tuple[Steps, str]]:
    """Names in a list of the campaign file that are not among the allowed ones."""
    for index, name in enumerate(names):
        if name not in allowed:
            choices = ", ".join(map(repr, allowed))
            yield (key, index), f"`{key}.{index}`: found {name!r}, expected one of {choices}."


def safe_name(name: object, named_at: object) -> str:
    """A name that can be part of a path: one plain word, so that no path can leave its folder.

    Raises:
        OilfilmError: It cannot; the sentence begins with `named_at`.
    """
    text = str(name)
    if not _NAME.fullmatch(text) or len(text.encode()) > _LONGEST_NAME:
        raise OilfilmError(
            f"{named_at}: {cut(name, 20)!r} cannot be a name: use letters, digits, '-', '_' and "
            f"'.', at most {_LONGEST_NAME} bytes, not starting with '.'."
        )
    if isinstance(name, float) or not _is_read_as_it_is_written(text):
        raise OilfilmError(
            f"{named_at}: {text!r} cannot be a name, because the command line and YAML read it as "
            "a number or another value. Put a letter before it."
        )
    return text


def _is_read_as_it_is_written(name: str) -> bool:
    """Whether the command line of Snakemake and YAML give a name back: not 2026.03, 1e5 or no."""
    try:
        number = float(name)
    except ValueError:
        try:
            return str(yaml.safe_load(name)) == name
        except yaml.YAMLError:
            return True
    return number.is_integer() and str(int(number)) == name
