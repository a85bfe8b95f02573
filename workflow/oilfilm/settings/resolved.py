"""Typed access to all settings of one campaign's run.

Decides: which settings a job can read: the keys that its rule lists with `settings_part(...)`.
"""

from collections.abc import Iterable, Mapping
from typing import Any, Self, TypeVar

from oilfilm.base.errors import OilfilmError
from oilfilm.base.plain_key import plain_key
from oilfilm.bearing.geometry import Bearing
from oilfilm.physics.contact import Contact
from oilfilm.physics.oils import Oil
from oilfilm.settings.base import Group, key, required_value
from oilfilm.settings.campaign import Campaign, Dataset
from oilfilm.settings.config import ConfigKeys, SplitSettings
from oilfilm.settings.messages import validated
from oilfilm.settings.rig import BearingFile, OilFile, Rig

_GroupT = TypeVar("_GroupT", bound=Group)
# Keys that change no result: it has the same bytes however the work is spread over jobs, and in an
# image.
_KEYS_WITHOUT_EFFECT = {"split", "container"}


class Settings(ConfigKeys):
    """Settings of one campaign's run, or the keys of them that a rule lists.

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
    def from_plain_values(cls, plain_values: Mapping[str, Any]) -> Self:
        """Settings from their plain values: all of them, or the part that a rule lists.

        Raises:
            OilfilmError: A value is not as its model declares it.
        """
        required_keys = {name for name, field in cls.model_fields.items() if field.is_required()}
        if required_keys <= plain_values.keys():
            settings: Self = validated(plain_values, cls, lambda key_path: "settings")
            return settings
        listed_values = dict(plain_values)
        if "campaign" in plain_values:
            listed_values["campaign"] = _group_of_listed_keys(Campaign, plain_values["campaign"])
        return _group_of_listed_keys(cls, listed_values)

    def plain_values(self) -> dict[str, Any]:
        """Plain values, as in JSON and in Snakemake's params."""
        return self.model_dump(mode="json", exclude_unset=True, exclude=_KEYS_WITHOUT_EFFECT)

    def plain_part(self, *keys: str, campaign: Iterable[str] = ()) -> dict[str, Any]:
        """Plain values of the settings that a rule's results depend on.

        Args:
            keys: Keys of the settings.
            campaign: Keys of the campaign, beside its name and whether its data are simulated;
                keys that its file leaves out get their defaults.
        """
        campaign_keys = {"name", "data", *campaign}
        written_values = self.campaign.model_dump(
            mode="json", exclude_unset=True, include=campaign_keys
        )
        values_with_defaults = self.campaign.model_dump(mode="json", include=campaign_keys)
        # A listed key needs a value, or `from_plain_values` gives it no attribute. A nested group
        # is kept as it is written: `from_plain_values` adds its defaults.
        campaign_values = values_with_defaults | written_values
        setting_values = self.model_dump(mode="json", exclude_unset=True, include=set(keys))
        listed_values = {
            "campaign": {name: campaign_values[name] for name in sorted(campaign_keys)}
        }
        for key_name in sorted(keys):
            listed_values[key_name] = setting_values[key_name]
        return listed_values

    def properties_of(self, oil_id: str) -> Oil | None:
        """An oil with its property formulas; None where its properties are not known."""
        oil_file = self.oils[oil_id]
        return None if oil_file is None else oil_file.properties()

    def oil_with_properties(self, oil_id: str) -> Oil:
        """An oil with its property formulas, which must be known.

        Raises:
            OilfilmError: Its properties are not known.
        """
        properties = self.properties_of(oil_id)
        if properties is None:
            raise OilfilmError(
                f"config/oils/{oil_id}.yaml: the properties of {oil_id!r} are needed. Write this "
                "file."
            )
        return properties

    @property
    def oil_id_by_name(self) -> dict[str, str]:
        """Oil ids by the names that a log may give to an oil, in the form of `plain_key`."""
        oil_id_by_name = {}
        for oil_id in self.oils:
            for name in self.names_of(oil_id):
                oil_id_by_name[plain_key(name)] = oil_id
        return oil_id_by_name

    def names_of(self, oil_id: str) -> tuple[str, ...]:
        """Names that a log may give to an oil: its id, and aliases in its file and the campaign."""
        oil_file = self.oils[oil_id]
        file_aliases = () if oil_file is None else oil_file.aliases
        campaign_aliases = self.campaign.oil_aliases.get(oil_id, ())
        return (oil_id, *file_aliases, *campaign_aliases)

    def common_contact(self) -> Contact | None:
        """The contact of all the campaign's rigs; None where it is unknown or differs.

        Contacts are the same where radius and modulus are: no law of traction has the roughness.
        The roughness is that of the first rig.
        """
        contacts = [rig.contact() for rig in self.rigs.values()]
        # whole contacts would differ wherever a roughness is not known: NaN is not NaN
        radii_and_moduli = {
            contact and (contact.radius_m, contact.reduced_modulus_pa) for contact in contacts
        }
        return contacts[0] if len(radii_and_moduli) == 1 else None

    def tested_bearing(self) -> Bearing:
        """The bearing of the campaign's torque logs."""
        bearing_name = required_value(self.campaign.torque, "torque", "the campaign").bearing
        return self.bearings[bearing_name].bearing(bearing_name)

    def study_settings(self, study_name: str, model: type[_GroupT]) -> _GroupT:
        """The settings of a study of the campaign.

        Args:
            study_name: Name of its package.
            model: The package's model of them.
        """
        study_settings: _GroupT = validated(
            self.studies[study_name], model, lambda key_path: f"settings of {study_name}"
        )
        return study_settings

    def with_changes(self, changes: Mapping[str, Any]) -> Self:
        """The settings with some keys changed, for a trial: `{"fit": {"bootstrap": 20}}`."""
        return type(self).from_plain_values(merge(self.plain_values(), changes))


def _group_of_listed_keys(model: type[_GroupT], plain_values: Mapping[str, Any]) -> _GroupT:
    """A group with the listed keys only; other keys are no attributes, even with a default.

    Args:
        model: Model of the whole group.
        plain_values: Plain values of the listed keys.
    """
    fields = model.model_fields
    validated_values = {}
    for key_name, value in plain_values.items():
        model_of_key = fields[key_name].annotation
        validated_values[key_name] = validated(value, model_of_key, lambda key_path: "settings")
    group = model.model_construct(**validated_values)
    # pydantic has set the defaults of the other keys
    for key_name in fields.keys() - plain_values.keys():
        vars(group).pop(key_name, None)
    return group


def merge(lower: Mapping[str, Any], upper: Mapping[str, Any]) -> dict[str, Any]:
    """`lower` with the values of `upper` in place of its own, group by group."""
    merged = dict(lower)
    for name, value in upper.items():
        lower_value = merged.get(name)
        if isinstance(value, Mapping) and isinstance(lower_value, Mapping):
            merged[name] = merge(lower_value, value)
        else:
            merged[name] = value
    return merged
