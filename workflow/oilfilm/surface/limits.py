"""What a surface must fulfil before it gives an answer.

Decides: the level of an interval; when there is no support.
"""

from dataclasses import dataclass, fields


@dataclass(frozen=True)
class SurfaceLimits:
    """Limits that a laboratory may choose, by the settings `surface`.

    Attributes:
        level: Share of points of new runs that an interval should hold, where there are enough
            conditions.
        largest_spread: Largest standard deviation of ln mu of the surface where there is support.
        fewest_slips: Fewest slips of a curve that show its shape between them.
        reach_in_gaps: Largest distance (in scaled slip) from a tested slip, over the typical widest
            gap of a curve. Half of it applies beyond the first and last slip.
        reach_in_slip: Largest factor between a slip and a tested one where there is support, for
            slips far above 0.02. A curve may turn and fall in a wider gap, whatever the law says.
        reach_in_ranges: Largest distance from the tested conditions where there is support, over
            the tested range of a condition.
        largest_spread_of_bound: Largest standard deviation of ln mu that a constant at its bound
            may contribute.
    """

    level: float = 0.95
    largest_spread: float = 0.15
    fewest_slips: int = 3
    reach_in_gaps: float = 0.5
    reach_in_slip: float = 1.8
    reach_in_ranges: float = 0.5
    largest_spread_of_bound: float = 0.05

    def __post_init__(self) -> None:
        if not 0 < self.level < 1:
            raise ValueError(f"level is {self.level:g}; expected a share between 0 and 1")
        for field in fields(self):
            limit = getattr(self, field.name)
            smallest = 1 if field.name == "reach_in_slip" else 0
            if not limit > smallest:
                raise ValueError(f"{field.name} is {limit:g}; expected a number above {smallest}")

    def stricter(self, other: "SurfaceLimits") -> "SurfaceLimits":
        """The stricter one of each limit: an answer within them is within those of both."""
        limits = {}
        for field in fields(self):
            choose = max if field.name in ("level", "fewest_slips") else min
            limits[field.name] = choose(getattr(self, field.name), getattr(other, field.name))
        return SurfaceLimits(**limits)
