"""Keys with a range: `<key>_range` has the two ends between which the value of `<key>` may be.

Decides: how settings state the range of an uncertain value.
"""

from oilfilm.bearing.inputs import UncertainInput
from oilfilm.settings.base import Group, key_error_at

_RANGE_SUFFIX = "_range"


def uncertain_input(group: Group, key_name: str, factor: float = 1.0) -> UncertainInput:
    """The value of a key and its range, as an uncertain input.

    Args:
        group: Group of keys that has the key and its range.
        key_name: The key of the value.
        factor: Factor that converts the unit of both.
    """
    low, high = getattr(group, key_name + _RANGE_SUFFIX)
    return UncertainInput(getattr(group, key_name), low, high).scaled(factor)


def uncertain_inputs_of_all_bearings(bearing_settings: Group) -> dict[str, UncertainInput]:
    """Value and range of the uncertain inputs that are settings of all bearings.

    Args:
        bearing_settings: The group `bearing` of the settings. A change of the module of its keys
            reruns no rule, so that its inputs are made here.
    """
    key_names = ("oil_volume_fraction", "replenishment_constant", "ellipse_factor")
    return {key_name: uncertain_input(bearing_settings, key_name) for key_name in key_names}


def refuse_outside_ranges(group: Group, *key_path: str) -> None:
    """Refuse values outside their ranges.

    Args:
        group: Keys, some of which have a range.
        key_path: Keys that lead to the group, from the outermost inwards.

    Raises:
        PydanticCustomError: A value is outside its range.
    """
    for range_name in type(group).model_fields:
        if not range_name.endswith(_RANGE_SUFFIX):
            continue
        key_name = range_name.removesuffix(_RANGE_SUFFIX)
        value, low, high = uncertain_input(group, key_name)
        if not low <= value <= high:
            raise key_error_at(
                (*key_path, key_name),
                f"found {value:g}, outside `{range_name}` ({low:g} to {high:g}); change one of the "
                "two.",
            )
