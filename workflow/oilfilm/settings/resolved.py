"""Typed access to everything that one campaign's run is told."""

from collections.abc import Iterable, Iterator, Mapping
from typing import TYPE_CHECKING, Any, Self

from pydantic import PrivateAttr

from oilfilm.bearing.geometry import Bearing
from oilfilm.errors import OilfilmError
from oilfilm.physics.oils import Oil
from oilfilm.physics.rigs import Contact
from oilfilm.settings.base import Group, key, present
from oilfilm.settings.bearing import BearingFile
from oilfilm.settings.campaign import Campaign, Dataset
from oilfilm.settings.config import ConfigKeys
from oilfilm.settings.messages import check
from oilfilm.settings.oil import OilFile
from oilfilm.settings.rig import Rig


class _PartOf(Group):
    """A group of which a rule may have listed only some keys.

    A key that the rule did not list is refused in words: a result that depends on it would not
    be made again when it changes.
    """

    @classmethod
    def of(cls, plain: Mapping[str, Any]) -> Self:
        """The group from its plain values, checked; keys may be missing."""
        unknown = sorted(set(plain) - set(cls.model_fields))
        if unknown:
            raise OilfilmError(f"settings: found the unknown key {unknown[0]!r}.")
        values = {name: cls._checked(name, value) for name, value in plain.items()}
        return cls.model_construct(set(values), **values)

    @classmethod
    def _checked(cls, name: str, value: Any) -> Any:
        annotation = cls.__annotations_of(name)
        return check(value, annotation, lambda steps: f"settings, {name}")

    @classmethod
    def __annotations_of(cls, name: str) -> Any:
        field = cls.model_fields[name]
        # constraints of the key itself, such as the least number of its items
        return field.annotation

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

    _plain: Mapping[str, Any] = PrivateAttr(default_factory=dict)

    @classmethod
    def of(cls, plain: "Mapping[str, Any] | Settings") -> Self:
        """Settings from their plain values, which may be a part that a rule lists.

        Raises:
            OilfilmError: A value is not as its model declares it.
        """
        if isinstance(plain, cls):
            return plain
        values = {**plain}
        settings = super().of(values)
        settings._plain = values
        return settings

    @classmethod
    def _checked(cls, name: str, value: Any) -> Any:
        return CampaignPart.of(value) if name == "campaign" else super()._checked(name, value)

    def plain(self) -> dict[str, Any]:
        """Plain values, as JSON and Snakemake's params hold them."""
        return dict(self._plain)

    def part(self, *keys: str, campaign: Iterable[str] = ()) -> dict[str, Any]:
        """Plain values of some parts: what a rule's results depend on.

        Args:
            keys: Keys of the settings.
            campaign: Keys of the campaign, beside its name and whether its data are simulated.
        """
        whole_campaign = self._plain["campaign"]
        listed = sorted({"name", "data", *campaign} & set(whole_campaign))
        return {
            "campaign": {name: whole_campaign[name] for name in listed},
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
                f"config/oils/{oil}.yaml: the properties of {oil!r} are needed here."
            )
        return known

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

    # Plain look-ups, for callers that are not converted yet.

    def __getitem__(self, name: str) -> Any:
        return self._plain[name]

    def __iter__(self) -> Iterator[str]:  # type: ignore[override]
        return iter(self._plain)

    def __contains__(self, name: object) -> bool:
        return name in self._plain

    def __len__(self) -> int:
        return len(self._plain)

    def keys(self) -> Any:
        """Keys of the plain values."""
        return self._plain.keys()

    def items(self) -> Any:
        """Keys and plain values."""
        return self._plain.items()

    def get(self, name: str, default: Any = None) -> Any:
        """A plain value, or the default."""
        return self._plain.get(name, default)

    def __or__(self, other: Mapping[str, Any]) -> dict[str, Any]:
        return {**self._plain, **other}


def merge(base: Mapping[str, Any], above: Mapping[str, Any]) -> dict[str, Any]:
    """`base` with the values of `above` laid over it, group by group."""
    merged = dict(base)
    for name, value in above.items():
        if isinstance(value, Mapping) and isinstance(merged.get(name), Mapping):
            merged[name] = merge(merged[name], value)
        else:
            merged[name] = value
    return merged
