"""Typed access to everything that one campaign's run is told."""

from collections.abc import Iterable, Mapping
from typing import TYPE_CHECKING, Any, Self, TypeVar

from pydantic import PrivateAttr
from pydantic_core import to_jsonable_python

from oilfilm.bearing.geometry import Bearing
from oilfilm.errors import OilfilmError
from oilfilm.physics.oils import Oil
from oilfilm.physics.rigs import Contact
from oilfilm.settings.base import Group, key, plain_key, present
from oilfilm.settings.bearing import BearingFile
from oilfilm.settings.campaign import Campaign, Dataset
from oilfilm.settings.config import ConfigKeys, SplitSettings, StorageSettings
from oilfilm.settings.messages import check
from oilfilm.settings.oil import OilFile
from oilfilm.settings.rig import Rig

_Part = TypeVar("_Part", bound="_PartOf")


class _PartOf(Group):
    """A group of which a rule may list only some keys.

    A key that the rule does not list is refused in words, even where it has a default: a result
    that depends on it would not be made again when it changes.
    """

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            if name in type(self).model_fields:
                raise OilfilmError(
                    f"settings: the rule does not list {name!r}; add it to `part(...)` of the rule."
                )
            return super().__getattr__(name)


class CampaignPart(Campaign, _PartOf):
    """A campaign, or the keys of it that a rule lists."""


class Settings(ConfigKeys, _PartOf):
    """Settings of one campaign's run, or the parts of them that a rule lists.

    Attributes mirror the keys of config/config.yaml: `settings.gates.lambda_limit`.
    """

    campaign: CampaignPart = key("The campaign file.")
    dataset: Dataset = key("What the campaign file says of the data.")
    rigs: dict[str, Rig] = key("Rigs by name.")
    oils: dict[str, OilFile | None] = key("Oils by id; None without known properties.")
    bearings: dict[str, BearingFile] = key("Bearings by name.")

    _plain: dict[str, Any] = PrivateAttr(default_factory=dict)
    _storage: StorageSettings = PrivateAttr(default_factory=StorageSettings)
    _split: SplitSettings = PrivateAttr(default_factory=SplitSettings)

    @classmethod
    def of(
        cls,
        plain: Mapping[str, Any],
        storage: StorageSettings | None = None,
        split: SplitSettings | None = None,
    ) -> Self:
        """Settings from their plain values.

        Plain values that lack a key are the part that a rule lists. In a part, keys of the
        campaign that are not there are refused when they are read; in whole settings they have
        their defaults.

        Args:
            plain: The values.
            storage: Where logs and releases are kept. It is apart from the values, so that results
                are the same bytes wherever that is.
            split: How the work is spread over jobs; apart for the same reason.

        Raises:
            OilfilmError: A value is not as its model declares it.
        """
        if cls.model_fields.keys() <= plain.keys():
            settings: Self = check(plain, cls, lambda steps: "settings")
        else:
            settings = _part_of(cls, plain)
        settings._plain = dict(plain)
        settings._storage = storage or StorageSettings()
        settings._split = split or SplitSettings()
        return settings

    @property
    def storage(self) -> StorageSettings:
        """Where logs and releases are kept in object storage; known to whole settings alone."""
        return self._storage

    @property
    def split(self) -> SplitSettings:
        """How the work is spread over jobs; known to whole settings alone."""
        return self._split

    def plain(self) -> dict[str, Any]:
        """Plain values, as JSON and Snakemake's params hold them."""
        return dict(self._plain)

    def part(self, *keys: str, campaign: Iterable[str] = ()) -> dict[str, Any]:
        """Plain values of some parts: what a rule's results depend on.

        Args:
            keys: Keys of the settings.
            campaign: Keys of the campaign, beside its name and whether its data are simulated;
                those that its file leaves out get their defaults.
        """
        listed = sorted({"name", "data", *campaign})
        written = self._plain["campaign"]
        absent = {name: getattr(self.campaign, name) for name in listed if name not in written}
        values = {**written, **to_jsonable_python(absent)}
        return {
            "campaign": {name: values[name] for name in listed},
            **{name: self._plain[name] for name in sorted(keys)},
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
        return {
            plain_key(name): oil
            for oil, known in self.oils.items()
            for name in (
                oil,
                *(known.aliases if known is not None else ()),
                *self.campaign.oil_aliases.get(oil, ()),
            )
        }

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
        return type(self).of(merge(self._plain, changes))

    def __repr__(self) -> str:
        return f"Settings of the campaign {self.campaign.name}: {', '.join(self._plain)}"


def _part_of(model: type[_Part], plain: Mapping[str, Any]) -> _Part:
    """A group with the keys that are listed, checked, and without defaults for the others."""
    values = {name: _checked_key(model, name, value) for name, value in plain.items()}
    part = model.model_construct(set(values), **values)
    for name in vars(part).keys() - values.keys():
        del vars(part)[name]
    return part


def _checked_key(model: type[_PartOf], name: str, value: Any) -> Any:
    if name not in model.model_fields:
        raise OilfilmError(f"settings: found the unknown key {name!r}.")
    if name == "campaign":
        return _part_of(CampaignPart, value)
    return check(value, model.model_fields[name].annotation, lambda steps: f"settings, {name}")


def merge(base: Mapping[str, Any], above: Mapping[str, Any]) -> dict[str, Any]:
    """`base` with the values of `above` laid over it, group by group."""
    merged = dict(base)
    for name, value in above.items():
        if isinstance(value, Mapping) and isinstance(merged.get(name), Mapping):
            merged[name] = merge(merged[name], value)
        else:
            merged[name] = value
    return merged
