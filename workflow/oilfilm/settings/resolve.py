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
from oilfilm.settings.messages import KeyPath, validated, validated_file
from oilfilm.settings.resolved import Settings, merge
from oilfilm.settings.rig import BearingFile, OilFile, Rig
from oilfilm.settings.yaml_file import YamlFile, as_yaml, dotted_key, leaves, read_yaml

# Name of the files that are patterns for files of a user's own, and are not read.
TEMPLATE_NAME = "template"
# In bytes. A file system takes 255; a release and the exports append to names.
_MAX_NAME_BYTES = 100
_NAME_PATTERN = re.compile(r"[\w-][\w.-]*")
_MODEL_BY_KIND: dict[str, Any] = {"rig": Rig, "oil": OilFile, "bearing": BearingFile}


def resolve_snakemake_config(
    config: Mapping[str, Any], typed_values: Mapping[str, Any]
) -> Settings:
    """The settings of a workflow, from the configuration that Snakemake passes to it.

    As a module of another workflow it may get a section of that workflow's configuration. This
    takes the place of `config.yaml`. Its key `folder` names the configuration folder.

    Args:
        config: Snakemake's `config`.
        typed_values: The keys of `config` that were typed on the command line.

    Raises:
        OilfilmError: A file is missing or has a mistake.
    """
    folder = Path(config.get("folder", "config"))
    section = {name: value for name, value in config.items() if name != "folder"}
    overrides = {name: value for name, value in typed_values.items() if name in section}
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
    campaign_name = overrides.get("campaign", config_file.values["campaign"])
    named_at = str(folder / "config.yaml")
    if "campaign" in overrides:
        named_at = "campaign on the command line"
    campaign_file = _named_yaml_file(folder, "campaign", campaign_name, named_at)
    campaign: CampaignFile = validated_file(campaign_file, CampaignFile)
    overrides_of_config = {key: value for key, value in overrides.items() if key != "campaign"}
    settings_file_by_study = _settings_file_by_study(campaign.studies)
    merged_config = _merged_config(
        config_file, settings_file_by_study, campaign_file, overrides_of_config
    )

    def content_by_name(kind: str, names: list[str], *key_path: str) -> dict[str, Any]:
        listed_at = f"{campaign_file.location_of(key_path)}, `{dotted_key(key_path)}`"
        return {name: named_content(folder, kind, name, listed_at) for name in names}

    oils = content_by_name("oil", campaign.oils, "oils")
    oils.update(dict.fromkeys(campaign.oils_without_properties))
    bearing_names: list[str] = []
    if campaign.torque is not None:
        bearing_names.append(campaign.torque.bearing)
        # published figures show the others
        bearing_names += [
            name for name in _path_by_name(folder, "bearing") if name not in bearing_names
        ]
    config_keys = _written_keys(ConfigKeys, merged_config)
    # settings of a study that the campaign does not have change nothing
    config_keys["studies"] = {name: merged_config.studies[name] for name in settings_file_by_study}
    settings = Settings.model_construct(
        **config_keys,
        split=merged_config.split,
        container=merged_config.container,
        campaign=Campaign.model_construct(
            name=str(campaign_name), **_written_keys(Campaign, campaign)
        ),
        # apart from the campaign, so that a corrected title reruns no fit
        dataset=Dataset.model_construct(**_written_keys(Dataset, campaign)),
        rigs=content_by_name("rig", campaign.rigs, "rigs"),
        bearings=content_by_name("bearing", bearing_names, "torque", "bearing"),
        oils=oils,
    )
    for key_path, sentence in chain(_contradictory_oil_names(settings), _contradictions(settings)):
        raise OilfilmError(f"{campaign_file.location_of(key_path)}: {sentence}")
    _refuse_implausible_oils(folder, settings)
    return settings


def _refuse_implausible_oils(folder: Path, settings: Settings) -> None:
    """Refuse oils that are impossible at a temperature of the campaign or of its bearing.

    Raises:
        OilfilmError: An oil has a property there that no oil has.
    """
    temperatures_c = list(_temperatures_of_use(settings))
    if not temperatures_c:
        return
    low_c, high_c = min(temperatures_c), max(temperatures_c)
    for oil_id in settings.campaign.oils:
        oil = settings.oils[oil_id]
        for key_path, sentence in oil.faults(low_c, high_c) if oil else ():
            oil_file = _named_yaml_file(folder, "oil", oil_id, "oils")
            raise OilfilmError(
                f"{oil_file.location_of(key_path)}, `{dotted_key(key_path)}`: {sentence} "
                f"The campaign uses the oil from {low_c:g} to {high_c:g} degC."
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
    yield from settings.bearing.cage_slip.further_temperature_c
    yield settings.bearing.size_effect.inlet_temperature_c
    yield from (point.oil_temperature_c for point in settings.plan.duty_points)
    if campaign.torque.matrix is not None:
        yield from campaign.torque.matrix.oil_temperature_c


def _written_keys(model: type[Group], group: Group) -> dict[str, Any]:
    """The keys of a model that were written, from a group that may have others."""
    key_names = group.model_fields_set & model.model_fields.keys()
    return {key_name: getattr(group, key_name) for key_name in key_names}


def read_config(folder: Path) -> Config:
    """The keys of a project's `config.yaml`, with oilfilm's own for those that it lacks.

    Raises:
        OilfilmError: The file is missing or has a mistake.
    """
    config: Config = validated_file(_config_file(folder), Config)
    return config


def _config_file(folder: Path, section: Mapping[str, Any] | None = None) -> YamlFile:
    """`config.yaml` of a project, or the section in its place, merged with oilfilm's own."""
    shipped_file = read_yaml(CONFIG / "config.yaml")
    if section is None:
        project_file = read_yaml(folder / "config.yaml")
    else:
        project_file = YamlFile(
            Path("the module's config"), dict(section), yaml.MappingNode("", [])
        )
    return replace(project_file, values=merge(shipped_file.values, project_file.values))


def config_files_of(settings: Settings) -> dict[str, str]:
    """The files of a configuration folder with these settings; `resolve` reads them back.

    Returns:
        The text of each file by its path below the folder.
    """
    config_values = settings.plain_values()
    campaign_values = dict(config_values["campaign"])
    campaign_name = campaign_values.pop("name")
    config_values["campaign"] = campaign_name
    campaign_values |= config_values.pop("dataset")
    values_by_path = {f"campaigns/{safe_name(campaign_name, 'campaign')}.yaml": campaign_values}
    for folder_name in ("rigs", "oils", "bearings"):
        for file_name, values in config_values.pop(folder_name).items():
            if values is not None:
                values_by_path[f"{folder_name}/{safe_name(file_name, folder_name)}.yaml"] = values
    values_by_path["config.yaml"] = config_values
    return {path: as_yaml(values) for path, values in values_by_path.items()}


def _path_by_name(folder: Path, kind: str) -> dict[str, Path]:
    """Paths of all files of a kind (`campaign`, `rig` ...) by name, without the template.

    A project's file replaces oilfilm's, which replaces the one of a study.
    """
    path_by_name = {}
    folders = [CONFIG / f"{kind}s", folder / f"{kind}s"]
    if kind == "campaign":
        folders = [*studies.campaign_folders(), *folders]
    for folder_of_kind in folders:
        for path in folder_of_kind.glob("*.yaml"):
            path_by_name[path.stem] = path
    path_by_name.pop(TEMPLATE_NAME, None)
    return dict(sorted(path_by_name.items()))


def campaign_names(folder: Path) -> list[str]:
    """Names of all campaigns that a project can run, those of studies included.

    Args:
        folder: The configuration folder.
    """
    return list(_path_by_name(folder, "campaign"))


def _named_yaml_file(folder: Path, kind: str, name: object, named_at: str) -> YamlFile:
    """The YAML file of one campaign, rig, oil or bearing; arguments as of `named_content`."""
    path_by_name = _path_by_name(folder, kind)
    file_stem = safe_name(name, named_at)
    template = CONFIG / f"{kind}s/template.yaml"
    if file_stem not in path_by_name and file_stem != template.stem:
        path = folder / f"{kind}s/{file_stem}.yaml"
        raise OilfilmError(
            f"{named_at}: names the {kind} {file_stem!r}, but {path} does not exist. Known: "
            f"{', '.join(path_by_name)}. Correct the name, or copy {template} there and fill it in."
        )
    return read_yaml(path_by_name.get(file_stem, template))


def named_content(folder: Path, kind: str, name: str, named_at: str) -> Any:
    """A rig, oil or bearing by its name: the content of its file, validated.

    Args:
        folder: The configuration folder.
        kind: `rig`, `oil` or `bearing`.
        name: Its name.
        named_at: Where it was named; the beginning of the message.

    Raises:
        OilfilmError: There is no such file, or it has a mistake.
    """
    file = _named_yaml_file(folder, kind, name, named_at)
    content = validated_file(file, _MODEL_BY_KIND[kind])
    if kind == "oil" and content.id != name:
        raise OilfilmError(
            f"{file.location_of(('id',))}, `id`: found {content.id!r}, expected {name!r}, the "
            "file's name."
        )
    return content


def _settings_file_by_study(study_names: Iterable[str]) -> dict[str, YamlFile]:
    """The files with the settings of those studies that have settings."""
    path_by_study = {
        name: studies.settings_file(name) for name in study_names if name in studies.available()
    }
    return {name: read_yaml(path) for name, path in path_by_study.items() if path.is_file()}


def _merged_config(
    config_file: YamlFile,
    settings_file_by_study: Mapping[str, YamlFile],
    campaign_file: YamlFile,
    overrides: Mapping[str, Any],
) -> Config:
    """The keys of config.yaml and of studies, replaced by those of the campaign and as typed.

    Args:
        config_file: `config.yaml` of the project.
        settings_file_by_study: Settings of the campaign's studies.
        campaign_file: The campaign file, whose key `settings` has keys of `config.yaml`.
        overrides: Keys typed on the command line.
    """
    study_defaults = {
        "studies": {study_name: file.values for study_name, file in settings_file_by_study.items()}
    }
    defaults = merge(study_defaults, config_file.values)
    campaign_values = campaign_file.values.get("settings", {})
    parsed_overrides = _with_parsed_numbers(overrides, defaults)

    def location_of(key_path: KeyPath) -> str:
        # the last key may be one of several that contradict each other: look for its group too
        for written_key_path in (key_path, key_path[:-1]):
            if written_key_path in _all_key_paths(parsed_overrides):
                return "the command line's --config"
            if written_key_path in _all_key_paths(campaign_values):
                return campaign_file.location_of(("settings", *key_path))
        top_key, *path_in_studies = key_path
        if top_key == "studies" and key_path not in _all_key_paths(config_file.values):
            study_name, *path_in_study = path_in_studies
            if study_name in settings_file_by_study:
                return settings_file_by_study[study_name].location_of(path_in_study)
        return config_file.location_of(key_path)

    if "campaign" in campaign_values:
        raise OilfilmError(
            f"{campaign_file.location_of(('settings', 'campaign'))}: `settings` cannot name "
            "another campaign; leave the key out."
        )
    merged_values = merge(merge(defaults, campaign_values), parsed_overrides)
    merged_config: Config = validated_file(
        replace(config_file, values=merged_values), Config, location_of
    )
    _refuse_wrong_study_settings(merged_config, settings_file_by_study, location_of)
    return merged_config


def _refuse_wrong_study_settings(
    merged_config: Config,
    settings_file_by_study: Mapping[str, YamlFile],
    location_of: Callable[[KeyPath], str],
) -> None:
    """Refuse settings of studies that the models of their packages do not allow.

    Raises:
        OilfilmError: There is no such study, or its settings have a mistake.
    """
    for study_name, study_values in merged_config.studies.items():
        if study_name not in studies.available():
            expected = ", ".join(studies.available())
            raise OilfilmError(
                f"{location_of(('studies', study_name))}: found settings of the study "
                f"{study_name!r}; expected one of {expected}."
            )
        if study_name in settings_file_by_study:
            model = studies.settings_module(study_name).StudySettings
            validated(study_values, model, partial(_location_in_study, study_name, location_of))


def _location_in_study(
    study_name: str, location_of: Callable[[KeyPath], str], key_path: KeyPath
) -> str:
    """Where a key of a study's settings was written."""
    return location_of(("studies", study_name, *key_path))


def _all_key_paths(values: Any) -> set[KeyPath]:
    """The key paths of every value and of every group above it."""
    key_paths: set[KeyPath] = set()
    for key_path, _ in leaves(values):
        key_paths.update(key_path[:length] for length in range(1, len(key_path) + 1))
    return key_paths


def _with_parsed_numbers(override: Any, default: Any) -> Any:
    """Values of the command line with numbers and truth values where Snakemake leaves text.

    This is done inside groups, too. A value that is text by default, such as the oil "4102", stays
    text.
    """
    if isinstance(override, Mapping):
        group = default if isinstance(default, Mapping) else {}
        return {
            name: _with_parsed_numbers(value, group.get(name)) for name, value in override.items()
        }
    if not isinstance(override, str) or isinstance(default, str):
        return override
    try:
        value = yaml.safe_load(override)
        is_number_or_truth_value = isinstance(value, int | float) and float(value) == value
    except (yaml.YAMLError, ValueError, OverflowError, RecursionError):
        return override
    return value if is_number_or_truth_value else override


def _contradictory_oil_names(settings: Settings) -> Iterator[tuple[KeyPath, str]]:
    """Names of no oil, and names that a log may give to two oils.

    Yields:
        The key of the campaign file to blame, and a sentence.
    """
    oil_id_by_name: dict[str, str] = {}
    aliases_by_oil = settings.campaign.oil_aliases
    for oil_id in aliases_by_oil:
        if oil_id not in settings.oils:
            oil_ids = ", ".join(settings.oils)
            yield ("oil_aliases", oil_id), f"{oil_id!r} is none of the campaign's oils ({oil_ids})."
    for oil_id in settings.oils:
        for name in settings.names_of(oil_id):
            first_oil_id = oil_id_by_name.setdefault(plain_key(name), oil_id)
            if first_oil_id != oil_id:
                is_alias = name in aliases_by_oil.get(oil_id, ())
                blamed_key = ("oil_aliases", oil_id) if is_alias else ("oils",)
                sentence = (
                    f"{name!r} is a name of {oil_id!r} (`aliases` of its file, `oil_aliases`), "
                    f"but is one of {first_oil_id!r} too; a log with it could be of either. Leave "
                    "it with one."
                )
                yield blamed_key, sentence


def _contradictions(settings: Settings) -> Iterator[tuple[KeyPath, str]]:
    """Every contradiction: the key of the campaign file to blame, and a sentence."""
    campaign = settings.campaign
    if not campaign.oils and not campaign.oils_without_properties:
        yield ("oils",), "the campaign names no oil; list at least one under `oils`."
    for oil_id in campaign.oils_without_properties:
        if oil_id in campaign.oils:
            sentence = f"the oil {oil_id!r} is listed under `oils` too; keep it in one of the two."
            yield ("oils_without_properties",), sentence
    for rig_name in campaign.semantics_of_rig:
        if rig_name not in campaign.rigs:
            rig_names = ", ".join(campaign.rigs)
            sentence = f"{rig_name!r} is none of the campaign's rigs ({rig_names})."
            yield ("semantics_of_rig", rig_name), sentence
    yield from _names_listed_for_two_keys(campaign)
    yield from _simulation_contradictions(campaign)
    yield from _figure_contradictions(settings)
    for study_name in settings.studies:
        yield from studies.settings_module(study_name).contradictions(settings)


def _names_listed_for_two_keys(campaign: Campaign) -> Iterator[tuple[KeyPath, str]]:
    """Names of a log's columns or header keys that are listed for two keys of the project."""
    names_of_columns = {
        ("columns", key_name): column.name for key_name, column in campaign.columns.items()
    }
    names_of_torque_columns = {}
    if campaign.torque is not None:
        for key_name, column in campaign.torque.columns.items():
            names_of_torque_columns[("torque", "columns", key_name)] = column.name
    names_of_header_keys = {
        ("header", key_name): names for key_name, names in campaign.header.items()
    }
    for names_by_key_path in (names_of_columns, names_of_torque_columns, names_of_header_keys):
        first_path_by_name: dict[str, tuple[str, ...]] = {}
        for key_path, names in names_by_key_path.items():
            for name in names:
                other_key_path = first_path_by_name.setdefault(name, key_path)
                if other_key_path != key_path:
                    other_key = other_key_path[-1]
                    sentence = f"{name!r} is listed for {other_key!r} too; leave it with one."
                    yield key_path, f"`{'.'.join(key_path)}`: {sentence}"


def _simulation_contradictions(campaign: Campaign) -> Iterator[tuple[KeyPath, str]]:
    """Contradictions about how the logs are simulated."""
    has_torque_twin = campaign.torque is not None and campaign.torque.twin is not None
    has_twin = campaign.twin is not None or has_torque_twin
    if campaign.data != "simulated":
        advice = "simulates these logs: say `data: simulated`, or drop this key."
        if has_twin:
            yield ("data",), f"`twin` {advice}"
        elif campaign.simulated_by:
            yield ("simulated_by",), f"`simulated_by` {advice}"
    if campaign.twin is not None and campaign.simulated_by:
        yield ("simulated_by",), "`twin` simulates these logs: drop this key."
    if has_twin and not studies.simulator():
        yield ("twin",), "no package beside oilfilm simulates logs; use logs of a rig."
    if campaign.twin is not None and len(campaign.rigs) != 1:
        yield ("rigs",), "the rig twin simulates logs of one rig; name one."


def _figure_contradictions(settings: Settings) -> Iterator[tuple[KeyPath, str]]:
    """Figures and studies that do not exist, and figures that lack what they show."""
    campaign = settings.campaign
    yield from _unknown_names("figures", campaign.figures, list(figures()))
    yield from _unknown_names("studies", campaign.studies, list(studies.available()))
    for figure_name in campaign.figures:
        if figure_name not in figures():
            continue
        figure = figures()[figure_name]
        what_to_do = ""
        if figure.requires and getattr(campaign, figure.requires) is None:
            what_to_do = f"needs `{figure.requires}`; add it"
        elif figure.study and figure.study not in campaign.studies:
            what_to_do = f"belongs to the study {figure.study!r}; add `studies: [{figure.study}]`"
        if what_to_do:
            yield ("figures",), f"the figure `{figure.name}` {what_to_do}, or leave the figure out."


def _unknown_names(
    key_name: str, names: Iterable[str], allowed_names: Collection[str]
) -> Iterator[tuple[KeyPath, str]]:
    """Names in a list of the campaign file that are not among the allowed ones."""
    for index, name in enumerate(names):
        if name not in allowed_names:
            choices = ", ".join(map(repr, allowed_names))
            sentence = f"`{key_name}.{index}`: found {name!r}, expected one of {choices}."
            yield (key_name, index), sentence


def safe_name(name: object, named_at: object) -> str:
    """A name that can be part of a path: one plain word, so that no path can leave its folder.

    Raises:
        OilfilmError: It cannot; the sentence begins with `named_at`.
    """
    if name is None:
        raise OilfilmError(f"{named_at}: found nothing, expected a name.")
    text = str(name)
    if not _NAME_PATTERN.fullmatch(text) or len(text.encode()) > _MAX_NAME_BYTES:
        raise OilfilmError(
            f"{named_at}: {cut(name, 20)!r} cannot be a name: use letters, digits, '-', '_' and "
            f"'.', at most {_MAX_NAME_BYTES} bytes, not starting with '.'."
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
        except ValueError:
            # a date that does not exist
            return False
    return number.is_integer() and str(int(number)) == name
