"""Why the measurements support no interval at a point, in sentences."""

from collections.abc import Callable

from oilfilm.surface.limits import SurfaceLimits

_REASON_BY_SUPPORT: dict[str, Callable[[SurfaceLimits], str]] = {
    "spread_too_large": lambda limits: (
        "the tested conditions are too far away: it is known there to no better than "
        f"{limits.largest_spread:.0%} (surface.largest_spread)"
    ),
    "far_from_tested_slips": lambda limits: (
        "the nearest tested slip is too far away (surface.reach_in_gaps, surface.reach_in_slip)"
    ),
    "far_from_tested_conditions": lambda limits: (
        f"a condition is farther beyond the tested ones than {limits.reach_in_ranges:g} of their "
        "range (surface.reach_in_ranges)"
    ),
    "law_not_positive": lambda limits: (
        "the law on which the surface stands has no traction above 0 there"
    ),
    "few_slips": lambda limits: (
        f"with fewer than {limits.fewest_slips} slips per run, mu between the tested slips is not "
        "known (surface.fewest_slips)"
    ),
    "constant_at_bound": lambda limits: (
        "a constant of the law ended at the bound of its search and changes mu there "
        "(surface.largest_spread_of_bound)"
    ),
    "condition_not_varied": lambda limits: (
        "a condition that was tested at one level has another value there"
    ),
}


def why_no_support(support: str, limits: SurfaceLimits) -> str:
    """The reason as a sentence without a full stop; empty where there is support.

    Args:
        support: A name of `oilfilm.surface.support.Support` in lower case.
        limits: Limits of the surface.
    """
    return _REASON_BY_SUPPORT[support](limits) if support in _REASON_BY_SUPPORT else ""
