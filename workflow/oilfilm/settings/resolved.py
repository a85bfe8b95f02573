"""Typed access to all settings of one campaign's run.

Decides: which settings a job can read: the keys that its rule lists with `part(...)`.
"""

from collections.abc import Iterable, Mapping
from typing import Any, Self, TypeVar

from oilfilm.base.errors import OilfilmError
from oilfilm.base.plain_key import plain_key
from oilfilm.bearing.geometry import Bearing
from oilfilm.physics.contact import Contact
from oilfilm.physics.oils import Oil
from oilfilm.settings.base import Group, key, present
from oilfilm.settings.campaign import Campaign, Dataset
from oilfilm.settings.config import ConfigKeys, SplitSettings
from oilfilm.settings.messages import check
from oilfilm.settings.rig import BearingFile, OilFile, Rig

_Part = TypeVar("_Part", bound=Group)
# Results have the same bytes however the work is spread over jobs, and in an image.
_WITHOUT_EFFECT_ON_RESULTS = {"split", "container"}


class Settings(ConfigKeys):
    """Settings of one campaign's run, or the parts of them that a rule lists.

    Attributes mirror the keys of config/config.yaml: `settings.gates.lambda_limit`. A key that a
    rule does not list is no attribute, even where it has a default. Otherwise a result could depend
    on a key whose change does not rerun the rule.
    """

    campaign: Campaign = key("The campaign file.")
    dataset: Dataset = key("The campaign file's description of the data.")
    rigs: dict[str, Rig] = key("Rigs by name.")
    oils: dict[str, OilFile | None] = key("Oils by id; None without known properties.")
    bearings: dict[str, BearingFile] = key("Bearings by name.")
    split: SplitSettings = key("How the work is spread over jobs.", default=SplitSettings())
    container: str = key("Image for the steps with --sdm apptainer.", default="none")

    @classmethod
    def of(cls, plain: Mapping[str, Any]) -> Self:
        """Settings from their plain values: all of them, or the part that a rule lists.

        Raises:
            OilfilmError: A value is not as its model declares it.
        """
        required = {name for name, field in cls.model_fields.items() if field.is_required()}
        if required <= plain.keys():
            settings: Self = check(plain, cls, lambda steps: "settings")
            return settings
        listed = dict(plain)
        if "campaign" in plain:
            listed["campaign"] = _listed(Campaign, plain["campaign"])
        return _listed(cls, listed)

    def plain(self) -> dict[str, Any]:
        """Plain values, as in JSON and in Snakemake's params."""
        return self.model_dump(mode="json", exclude_unset=True, exclude=_WITHOUT_EFFECT_ON_RESULTS)

    def part(self, *keys: str, campaign: Iterable[str] = ()) -> dict[str, Any]:
        """Plain values of the settings that a rule's results depend on.

        Args:
            keys: Keys of the settings.
            campaign: Keys of the campaign, beside its name and whether its data are simulated;
                keys that its file leaves out get their defaults.
        """
        campaign_keys = {"name", "data", *campaign}
        written = self.campaign.model_dump(mode="json", exclude_unset=True, include=campaign_keys)
        with_defaults = self.campaign.model_dump(mode="json", include=campaign_keys)
        # a listed key needs a value, or `of` gives it no attribute; in nested groups `of` adds the
        # defaults, so that these groups are kept as they are written
        campaign_values = with_defaults | written
        values = self.model_dump(mode="json", exclude_unset=True, include=set(keys))
        listed = {"campaign": {name: campaign_values[name] for name in sorted(campaign_keys)}}
        for name in sorted(keys):
            listed[name] = values[name]
        return listed

    def properties_of(self, oil: str) -> Oil | None:
        """An oil with its property formulas; None where its properties are not known."""
        file = self.oils[oil]
        return None if file is None else file.properties()

    def known_oil(self, oil: str) -> Oil:
        """An oil with its property formulas.

        Raises:
            OilfilmError: Its properties are not known.
        """
        properties = self.properties_of(oil)
        if properties is None:
            raise OilfilmError(
                f"config/oils/{oil}.yaml: the properties of {oil!r} are needed. Write this file."
            )
        return properties

    @property
    def oil_ids(self) -> dict[str, str]:
        """Oil ids by the names that a log may give to an oil, in the form of `plain_key`."""
        ids = {}
        for oil in self.oils:
            for name in self.names_of(oil):
                ids[plain_key(name)] = oil
        return ids

    def names_of(self, oil: str) -> tuple[str, ...]:
        """Names that a log may give to an oil: its id, and aliases in its file and the campaign."""
        file = self.oils[oil]
        file_aliases = () if file is None else file.aliases
        campaign_aliases = self.campaign.oil_aliases.get(oil, ())
        return (oil, *file_aliases, *campaign_aliases)

    def common_contact(self) -> Contact | None:
        """The contact of all the campaign's rigs; None where it is unknown or differs."""
        contacts = {rig.contact() for rig in self.rigs.values()}
        return contacts.pop() if len(contacts) == 1 else None

    def tested_bearing(self) -> Bearing:
        """The bearing of the campaign's torque logs."""
        name = present(self.campaign.torque, "torque", "the campaign").bearing
        return self.bearings[name].bearing(name)

    def of_study(self, name: str, model: type[_Part]) -> _Part:
        """The settings of a study of the campaign.

        Args:
            name: Name of its package.
            model: The package's model of them.
        """
        study_settings: _Part = check(
            self.studies[name], model, lambda steps: f"settings of {name}"
        )
        return study_settings

    def with_changes(self, changes: Mapping[str, Any]) -> Self:
        """The settings with some keys changed, for a trial: `{"fit": {"bootstrap": 20}}`."""
        return type(self).of(merge(self.plain(), changes))


def _listed(model: type[_Part], plain: Mapping[str, Any]) -> _Part:
    """A group with the listed keys only; other keys are no attributes, even with a default."""
    fields = model.model_fields
    values = {}
    for name, value in plain.items():
        values[name] = check(value, fields[name].annotation, lambda steps: "settings")
    group = model.model_construct(**values)
    # pydantic has set the defaults of the other keys
    for name in fields.keys() - plain.keys():
        vars(group).pop(name, None)
    return group


def merge(base: Mapping[str, Any], above: Mapping[str, Any]) -> dict[str, Any]:
    """`base` with the values of `above` in place of its own, group by group."""
    merged = dict(base)
    for name, value in above.items():
        base_value = merged.get(name)
        if isinstance(value, Mapping) and isinstance(base_value, Mapping):
            merged[name] = merge(base_value, value)
        else:
            merged[name] = value
    return merged
