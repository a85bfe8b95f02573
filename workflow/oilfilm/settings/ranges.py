"""Keys with a range: `<key>_range` has the two ends between which the value of `<key>` may be.

Decides: how settings state the range of an uncertain value.
"""

from oilfilm.bearing.inputs import UncertainInput
from oilfilm.settings.base import Group, contradiction

_SUFFIX = "_range"


def with_range(group: Group, name: str, factor: float = 1.0) -> UncertainInput:
    """The value of a key and its range, times a factor that converts the unit."""
    low, high = getattr(group, name + _SUFFIX)
    return UncertainInput(getattr(group, name), low, high).scaled(factor)


def check_ranges(group: Group, *steps: str) -> None:
    """Refuse values outside their ranges.

    Args:
        group: Keys, some of which have a range.
        steps: Keys above the group.

    Raises:
        PydanticCustomError: A value is outside its range.
    """
    for range_name in type(group).model_fields:
        if not range_name.endswith(_SUFFIX):
            continue
        name = range_name.removesuffix(_SUFFIX)
        value, low, high = with_range(group, name)
        if not low <= value <= high:
            raise contradiction(
                (*steps, name),
                f"found {value:g}, outside `{range_name}` ({low:g} to {high:g}); change one of the "
                "two.",
            )
