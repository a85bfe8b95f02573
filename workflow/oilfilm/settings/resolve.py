"""Settings of one campaign's run, from the files of config/ and the command line.

Decides: the precedence of settings (the command line, then `settings` of the campaign file, then
`config.yaml` of the project, then the one of oilfilm); which folder a campaign, rig, oil or bearing
is read from; which name of an oil is whose.
"""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from pathlib import Path, PurePosixPath
from typing import Any

import yaml

from oilfilm.errors import OilfilmError
from oilfilm.home import CONFIG
from oilfilm.settings.base import Group, plain_key
from oilfilm.settings.bearing import BearingFile
from oilfilm.settings.campaign import Campaign, CampaignFile, Dataset
from oilfilm.settings.config import Config, ConfigKeys
from oilfilm.settings.contradictions import contradictions
from oilfilm.settings.messages import Steps, check_file
from oilfilm.settings.oil import OilFile
from oilfilm.settings.resolved import Settings, merge
from oilfilm.settings.rig import Rig
from oilfilm.settings.yaml_file import YamlFile, as_yaml, dotted, read_yaml, unusable_values

# A file system takes 255 bytes; a release and the exports append to names.
_LONGEST_NAME = 100
_MODELS: dict[str, Any] = {"rig": Rig, "oil": OilFile, "bearing": BearingFile}


def resolve(folder: Path, overrides: Mapping[str, Any]) -> Settings:
    """Everything that one campaign's run is told, in one tree; each value is validated once.

    Args:
        folder: The configuration folder (`config`). Its `config.yaml` needs only the keys that
            differ from those that are part of oilfilm; oils, rigs, bearings and campaigns that it
            lacks are taken from there as well.
        overrides: Keys given on the command line.

    Returns:
        The keys of `config.yaml`, with `campaign` (the campaign file and its `name`), `dataset`
        (what that file says of the data), `rigs`, `oils` and `bearings` by name.

    Raises:
        OilfilmError: A file is missing or has a mistake.
    """
    config, given = _config_file(folder), dict(overrides)
    named_at = "campaign on the command line" if "campaign" in given else folder / "config.yaml"
    name = safe_name(given.pop("campaign", config.values["campaign"]), named_at)
    file = _campaign_file(folder, name)
    campaign: CampaignFile = check_file(file, CampaignFile)
    keys = _merged_keys(config, file, given)

    def named(kind: str, names: list[str], *steps: str) -> dict[str, Any]:
        named_at = f"{file.location_of(steps)}, `{dotted(steps)}`"
        return {name: named_file(folder, kind, name, named_at) for name in names}

    oils = named("oil", campaign.oils, "oils")
    bearings = []
    if campaign.torque is not None:
        # those of published figures too
        others = [path.stem for path in _files(folder, "bearings")]
        bearings = list(dict.fromkeys([campaign.torque.bearing, *others]))
    settings = Settings.model_construct(
        **_written(ConfigKeys, keys),
        split=keys.split,
        campaign=Campaign.model_construct(name=name, **_written(Campaign, campaign)),
        # apart from the campaign, so that a corrected title redoes no fit
        dataset=Dataset.model_construct(**_written(Dataset, campaign)),
        rigs=named("rig", campaign.rigs, "rigs"),
        bearings=named("bearing", bearings, "torque", "bearing"),
        oils={**oils, **dict.fromkeys(campaign.oils_without_properties)},
    )
    _refuse_names_of_two_oils(settings, folder, file)
    for steps, sentence in contradictions(settings):
        raise OilfilmError(f"{file.location_of(steps)}: {sentence}")
    return settings


def _written(model: type[Group], source: Group) -> dict[str, Any]:
    """The keys of a model that were written, from a group that has more."""
    names = source.model_fields_set & model.model_fields.keys()
    return {name: getattr(source, name) for name in names}


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


def _file(folder: Path, kind: str, name: str) -> Path:
    """The file of one campaign, rig, oil or bearing; it may not exist."""
    own, given = (each / kind / f"{name}.yaml" for each in (folder, CONFIG))
    return given if given.is_file() and not own.is_file() else own


def _files(folder: Path, kind: str) -> list[Path]:
    """All files of a kind by name, but for the template."""
    found = {path.stem: path for each in (folder, CONFIG) for path in (each / kind).glob("*.yaml")}
    return [found[name] for name in sorted(found) if name != "template"]


def _known(folder: Path, kind: str) -> str:
    return ", ".join(path.stem for path in _files(folder, kind))


def _campaign_file(folder: Path, name: str) -> YamlFile:
    path = _file(folder, "campaigns", name)
    if not path.is_file():
        raise OilfilmError(
            f"{path}: there is no such campaign file. Campaigns here: "
            f"{_known(folder, 'campaigns')}. Copy {_file(folder, 'campaigns', 'template')} to "
            "that name and fill it in."
        )
    return read_yaml(path)


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
    path = _file(folder, f"{kind}s", safe_name(name, named_at))
    if not path.is_file():
        raise OilfilmError(
            f"{named_at}: names the {kind} {name!r}, but {path} does not exist. "
            f"Known: {_known(folder, f'{kind}s')}. Write that file, or correct the name."
        )
    file = read_yaml(path)
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
    return check_file(replace(config, values=merged), Config, location_of)


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


def _refuse_names_of_two_oils(settings: Settings, folder: Path, campaign: YamlFile) -> None:
    """No name that a log may give an oil may be that of two."""
    oil_of: dict[str, str] = {}
    for oil, name, path, steps in _names_of_oils(settings, folder, campaign.path):
        if oil not in settings.oils:
            raise OilfilmError(
                f"{campaign.location_of(steps)}: {oil!r} is none of the campaign's oils "
                f"({', '.join(settings.oils)})."
            )
        other = oil_of.setdefault(plain_key(name), oil)
        if other != oil:
            raise OilfilmError(
                f"{read_yaml(path).location_of(steps)}: {name!r} is given as a name of {oil!r}, "
                f"but is one of {other!r} too; a log with it could be of either. Leave it with one "
                "of the two."
            )


def _names_of_oils(
    settings: Settings, folder: Path, campaign: Path
) -> Iterator[tuple[str, str, Path, Steps]]:
    """Oil, a name of it, and where that name is given: file and key."""
    for oil in settings.oils:
        yield oil, oil, campaign, ("oils",)
    for oil, known in settings.oils.items():
        for number, alias in enumerate(known.aliases if known else ()):
            yield oil, alias, _file(folder, "oils", oil), ("aliases", number)
    for oil, aliases in settings.campaign.oil_aliases.items():
        for alias in aliases:
            yield oil, alias, campaign, ("oil_aliases", oil)


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
