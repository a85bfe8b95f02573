"""Typed access to everything that one campaign's run is told.

Decides: what a job sees of the settings: the keys that its rule lists with `part(...)`.
"""

from collections.abc import Iterable, Mapping
from typing import Any, Self, TypeVar

from oilfilm.bearing.geometry import Bearing
from oilfilm.errors import OilfilmError
from oilfilm.physics.contact import Contact
from oilfilm.physics.oils import Oil
from oilfilm.settings.base import Group, key, plain_key, present
from oilfilm.settings.campaign import Campaign, Dataset
from oilfilm.settings.config import ConfigKeys, SplitSettings
from oilfilm.settings.messages import check
from oilfilm.settings.rig import BearingFile, OilFile, Rig

_Part = TypeVar("_Part", bound=Group)
# Results are the same bytes however the work is spread over jobs.
_NO_PART_OF_RESULTS = {"split"}


class Settings(ConfigKeys):
    """Settings of one campaign's run, or the parts of them that a rule lists.

    Attributes mirror the keys of config/config.yaml: `settings.gates.lambda_limit`. A key that a
    rule does not list is no attribute, even where it has a default: a result that depends on it
    would not be made again when it changes.
    """

    campaign: Campaign = key("The campaign file.")
    dataset: Dataset = key("What the campaign file says of the data.")
    rigs: dict[str, Rig] = key("Rigs by name.")
    oils: dict[str, OilFile | None] = key("Oils by id; None without known properties.")
    bearings: dict[str, BearingFile] = key("Bearings by name.")
    split: SplitSettings = key("How the work is spread over jobs.", default=SplitSettings())

    @classmethod
    def of(cls, plain: Mapping[str, Any]) -> Self:
        """Settings from their plain values: all of them, or the part that a rule lists.

        Raises:
            OilfilmError: A value is not as its model declares it.
        """
        if all(name in plain for name, field in cls.model_fields.items() if field.is_required()):
            settings: Self = check(plain, cls, lambda steps: "settings")
            return settings
        listed = {**plain}
        if "campaign" in plain:
            listed["campaign"] = _listed(Campaign, plain["campaign"])
        return _listed(cls, listed)

    def plain(self) -> dict[str, Any]:
        """Plain values, as JSON and Snakemake's params hold them."""
        return self.model_dump(mode="json", exclude_unset=True, exclude=_NO_PART_OF_RESULTS)

    def part(self, *keys: str, campaign: Iterable[str] = ()) -> dict[str, Any]:
        """Plain values of some parts: what a rule's results depend on.

        Args:
            keys: Keys of the settings.
            campaign: Keys of the campaign, beside its name and whether its data are simulated;
                those that its file leaves out get their defaults.
        """
        of_campaign = {"name", "data", *campaign}
        written = self.campaign.model_dump(mode="json", exclude_unset=True, include=of_campaign)
        listed = self.campaign.model_dump(mode="json", include=of_campaign) | written
        values = self.model_dump(mode="json", exclude_unset=True, include=set(keys))
        return {
            "campaign": {name: listed[name] for name in sorted(of_campaign)},
            **{name: values[name] for name in sorted(keys)},
        }

    def properties_of(self, oil: str) -> Oil | None:
        """An oil with its property formulas; None where its properties are not known."""
        known = self.oils[oil]
        return None if known is None else known.properties()

    def known_oil(self, oil: str) -> Oil:
        """An oil with its property formulas.

        Raises:
            OilfilmError: Its properties are not known.
        """
        known = self.properties_of(oil)
        if known is None:
            raise OilfilmError(
                f"config/oils/{oil}.yaml: the properties of {oil!r} are needed. Write this file."
            )
        return known

    @property
    def oil_ids(self) -> dict[str, str]:
        """Oil id by each name that a log may give it, as `plain_key` makes them."""
        return {plain_key(name): oil for oil in self.oils for name in self.names_of(oil)}

    def names_of(self, oil: str) -> tuple[str, ...]:
        """Names that a log may give to an oil: its id, those of its file, those of the campaign."""
        known = self.oils[oil]
        of_file = () if known is None else known.aliases
        return (oil, *of_file, *self.campaign.oil_aliases.get(oil, ()))

    def common_contact(self) -> Contact | None:
        """The contact of all the campaign's rigs; None where unknown or not the same for all."""
        contacts = {rig.contact() for rig in self.rigs.values()}
        return contacts.pop() if len(contacts) == 1 else None

    def tested_bearing(self) -> Bearing:
        """The bearing of the campaign's torque logs."""
        name = present(self.campaign.torque, "torque", "the campaign").bearing
        return self.bearings[name].bearing(name)

    def with_changes(self, changes: Mapping[str, Any]) -> Self:
        """The settings with some keys changed, for a trial: `{"fit": {"bootstrap": 20}}`."""
        return type(self).of(merge(self.plain(), changes))


def _listed(model: type[_Part], plain: Mapping[str, Any]) -> _Part:
    """A group with the listed keys; another one has no value there, not even its default."""
    part = model.model_construct(
        **{
            name: check(value, model.model_fields[name].annotation, lambda steps: "settings")
            for name, value in plain.items()
        }
    )
    for name in model.model_fields.keys() - plain.keys():
        vars(part).pop(name, None)
    return part


def merge(base: Mapping[str, Any], above: Mapping[str, Any]) -> dict[str, Any]:
    """`base` with the values of `above` laid over it, group by group."""
    merged = dict(base)
    for name, value in above.items():
        below = merged.get(name)
        if isinstance(value, Mapping) and isinstance(below, Mapping):
            merged[name] = merge(below, value)
        else:
            merged[name] = value
    return merged
