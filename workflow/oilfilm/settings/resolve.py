"""Settings of one campaign's run, from the files of config/ and the command line."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path, PurePosixPath
from typing import Any

import yaml

from oilfilm.errors import OilfilmError
from oilfilm.home import CONFIG
from oilfilm.settings.base import plain_key
from oilfilm.settings.bearing import BearingFile
from oilfilm.settings.campaign import CampaignFile, Dataset
from oilfilm.settings.config import Config, SplitSettings, StorageSettings
from oilfilm.settings.contradictions import contradictions
from oilfilm.settings.messages import Steps, check, check_file
from oilfilm.settings.oil import OilFile
from oilfilm.settings.resolved import Settings, merge
from oilfilm.settings.rig import Rig
from oilfilm.settings.yaml_file import YamlFile, as_yaml, dotted, read_yaml, unusable_values

# A file system takes 255 bytes; a release and the exports append to names.
_LONGEST_NAME = 100
_FOLDERS: dict[str, Any] = {"rig": Rig, "oil": OilFile, "bearing": BearingFile}


@dataclass(frozen=True)
class _Folder:
    """A configuration folder; what it lacks comes from the one that is part of oilfilm.

    Attributes:
        own: The folder of the project.
    """

    own: Path

    def file(self, kind: str, name: str) -> Path:
        """The file of one campaign, rig, oil or bearing; it may not exist."""
        own, given = (folder / kind / f"{name}.yaml" for folder in (self.own, CONFIG))
        return given if given.is_file() and not own.is_file() else own

    def names(self, kind: str) -> list[str]:
        """Names of all files of a kind, but for the template."""
        paths = [path for folder in (self.own, CONFIG) for path in (folder / kind).glob("*.yaml")]
        return sorted({path.stem for path in paths} - {"template"})


def resolve(folder: Path, overrides: Mapping[str, Any]) -> Settings:
    """Everything that one campaign's run is told, in one tree.

    Args:
        folder: The configuration folder (`config`). Its `config.yaml` needs only the keys that
            differ from those that are part of oilfilm; oils, rigs, bearings and campaigns that it
            lacks are taken from there as well.
        overrides: Keys given on the command line; they win over `config.yaml`. A campaign's own
            `settings` win over `config.yaml` too, but not over the command line.

    Returns:
        The keys of `config.yaml`, with `campaign` (the campaign file and its `name`), `dataset`
        (what that file says of the data), `rigs`, `oils` and `bearings` by name.

    Raises:
        OilfilmError: A file is missing or has a mistake.
    """
    files = _Folder(folder)
    config = _config_file(folder)
    check_file(config, Config)
    if "campaign" in overrides:
        campaign = _campaign_file(files, overrides["campaign"], "campaign on the command line")
    else:
        campaign = _campaign_file(files, config.values["campaign"], folder / "config.yaml")
    check_file(campaign, CampaignFile)
    given = {name: value for name, value in overrides.items() if name != "campaign"}
    keys = _merged_keys(config, campaign, given)
    storage = StorageSettings(**keys.pop("storage", {}))
    split = SplitSettings(**keys.pop("split", {}))
    written = campaign.values
    about = {name: written[name] for name in Dataset.model_fields if name in written}
    others = {name: written[name] for name in written if name not in {"settings", *about}}
    settings = Settings.of(
        {
            **keys,
            # apart from the campaign, so that a corrected title redoes no fit
            "dataset": about,
            "campaign": {"name": campaign.path.stem, **others},
            "rigs": {
                name: file.values for name, file in _named_files(files, "rig", campaign).items()
            },
            "bearings": _bearings(files, campaign),
            "oils": _oils(files, campaign),
        },
        storage,
        split,
    )
    for steps, sentence in contradictions(settings):
        raise OilfilmError(f"{campaign.location_of(steps)}: {sentence}")
    return settings


def overrides_of(
    given: Mapping[str, Any], folder: Path, typed: Mapping[str, Any]
) -> dict[str, Any]:
    """The overrides for `resolve` in the configuration that Snakemake gives a workflow.

    A workflow that imports this one and has read `config/config.yaml` itself gives all of that
    file. It is no override then: a campaign's own settings win over it.

    Args:
        given: Snakemake's `config`.
        folder: The configuration folder.
        typed: What of it was typed on the command line.

    Raises:
        OilfilmError: `config.yaml` is missing or has a mistake.
    """
    own = read_yaml(folder / "config.yaml").values
    on_line = {name: value for name, value in typed.items() if name in given}
    return merge(_differing(given, own), on_line)


def _differing(given: Mapping[str, Any], own: Mapping[str, Any]) -> dict[str, Any]:
    """What is given otherwise than in a file of one's own, group by group."""
    differing: dict[str, Any] = {}
    for name, value in given.items():
        known = own.get(name)
        if isinstance(value, Mapping) and isinstance(known, Mapping):
            below = _differing(value, known)
            differing |= {name: below} if below else {}
        elif name not in own or value != known:
            differing[name] = value
    return differing


def read_config(folder: Path) -> Config:
    """The keys of a project's `config.yaml` over those that are part of oilfilm.

    Raises:
        OilfilmError: The file is missing or has a mistake.
    """
    config: Config = check_file(_config_file(folder), Config)
    return config


def _config_file(folder: Path) -> YamlFile:
    own, defaults = (read_yaml(each / "config.yaml") for each in (folder, CONFIG))
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


def _campaign_file(files: _Folder, given_name: object, named_at: object) -> YamlFile:
    name = safe_name(given_name, named_at)
    path = files.file("campaigns", name)
    if not path.is_file():
        raise OilfilmError(
            f"{path}: there is no such campaign file. Campaigns here: "
            f"{', '.join(files.names('campaigns'))}. Copy {files.file('campaigns', 'template')} to "
            "that name and fill it in."
        )
    return read_yaml(path)


def _merged_keys(config: YamlFile, campaign: YamlFile, given: Mapping[str, Any]) -> dict[str, Any]:
    """The keys of config.yaml, with those of the campaign and of the command line over them."""
    own, given = campaign.values.get("settings", {}), _with_numbers(given, config.values)
    for steps, complaint in unusable_values(given):
        raise OilfilmError(f"the command line's --config, `{dotted(steps)}`: {complaint}")

    def location_of(steps: Steps) -> str:
        # the last key may be one of several that contradict each other: look for its group too
        for known in (steps, steps[:-1]):
            if _has(given, known):
                return "the command line's --config"
            if _has(own, known):
                return campaign.location_of(("settings", *steps))
        return config.location_of(steps)

    if "campaign" in own:
        raise OilfilmError(
            f"{campaign.location_of(('settings', 'campaign'))}: `settings` cannot name another "
            "campaign; leave the key out."
        )
    merged = merge(merge(config.values, own), given)
    check(merged, Config, location_of)
    return merged


def _has(values: Any, steps: Steps) -> bool:
    for step in steps:
        if isinstance(values, Mapping) and step in values:
            values = values[step]
        elif isinstance(values, list) and isinstance(step, int) and step < len(values):
            values = values[step]
        else:
            return False
    return bool(steps)


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
    except (yaml.YAMLError, ValueError, RecursionError):
        return given
    return value if isinstance(value, int | float) else given


def _named_files(files: _Folder, kind: str, campaign: YamlFile) -> dict[str, YamlFile]:
    """The files that a campaign names under `rigs` or `oils`."""
    return {
        name: _named_file(files, name, kind, campaign.location_of((f"{kind}s", index)))
        for index, name in enumerate(campaign.values[f"{kind}s"])
    }


def _oils(folder: _Folder, campaign: YamlFile) -> dict[str, Any]:
    """The oils of a campaign by id; no name may be that of two."""
    files = _named_files(folder, "oil", campaign)
    ids = [*files, *campaign.values.get("oils_without_properties", [])]
    names = [(oil, oil, campaign.location_of(("oils",))) for oil in ids]
    for oil, file in files.items():
        aliases = file.values.get("aliases", [])
        names += [(oil, each, file.location_of(("aliases", i))) for i, each in enumerate(aliases)]
    for oil, aliases in campaign.values.get("oil_aliases", {}).items():
        location = campaign.location_of(("oil_aliases", oil))
        if oil not in ids:
            known = ", ".join(ids)
            raise OilfilmError(f"{location}: {oil!r} is none of the campaign's oils ({known}).")
        listed = [aliases] if isinstance(aliases, str) else aliases
        names += [(oil, each, location) for each in listed]
    oil_of: dict[str, str] = {}
    for oil, name, location in names:
        other = oil_of.setdefault(plain_key(name), oil)
        if other != oil:
            raise OilfilmError(
                f"{location}: {name!r} is given as a name of {oil!r}, but is one of {other!r} "
                "too; a log with it could be of either. Leave it with one of the two."
            )
    return {oil: files[oil].values if oil in files else None for oil in ids}


def _bearings(files: _Folder, campaign: YamlFile) -> dict[str, Any]:
    """The bearing of a campaign with torque logs, and those of published figures."""
    if "torque" not in campaign.values:
        return {}
    named_at = campaign.location_of(("torque", "bearing"))
    own = campaign.values["torque"]["bearing"]
    others = [name for name in files.names("bearings") if name != own]
    return {name: _named_file(files, name, "bearing", named_at).values for name in [own, *others]}


def _named_file(files: _Folder, name: str, kind: str, named_at: str) -> YamlFile:
    path = files.file(f"{kind}s", safe_name(name, named_at))
    if not path.is_file():
        known = ", ".join(files.names(f"{kind}s"))
        raise OilfilmError(
            f"{named_at}: `{kind}s` names {name!r}, but {path} does not exist. "
            f"Known: {known}. Write that file, or correct the name."
        )
    file = read_yaml(path)
    check_file(file, _FOLDERS[kind])
    if kind == "oil" and file.values["id"] != name:
        raise OilfilmError(
            f"{file.location_of(('id',))}, `id`: found {file.values['id']!r}, expected {name!r}, "
            "the file's name."
        )
    return file


def safe_name(name: object, named_at: object) -> str:
    """A name that becomes part of a path: one plain word, so that no path can leave its folder.

    Raises:
        OilfilmError: It is none; the sentence begins with `named_at`.
    """
    text = str(name)
    plain = all(letter.isalnum() or letter in "-_." for letter in text)
    if not text or not plain or PurePosixPath(text).name != text or text.startswith("."):
        raise OilfilmError(
            f"{named_at}: {text!r} cannot be a name: use letters, digits, '-', '_' and '.', "
            "not starting with '.'."
        )
    if isinstance(name, float):
        raise OilfilmError(
            f"{named_at}: the name was read as the number {text}. Give it a name that is no "
            "decimal number."
        )
    if len(text.encode()) > _LONGEST_NAME:
        raise OilfilmError(
            f"{named_at}: {text[:20]!r}... has {len(text.encode())} bytes; expected at most "
            f"{_LONGEST_NAME}, so that names of files made with it stay below 255. Shorten it."
        )
    return text
