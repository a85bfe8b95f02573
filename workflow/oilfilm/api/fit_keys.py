"""The settings of a fit as typed keywords, so that editors complete and type checkers check them.

What each one means is in `oilfilm.settings.config.FitSettings`; a test compares the two.
"""

from typing import TypedDict


class FitKeys(TypedDict, total=False):
    """Keys of `fit` in config/config.yaml that differ for one fit."""

    searches: int
    population: int
    generations: int
    polished: int
    agreement_sse: float
    agreement_constants: float
    gradient_cosine_max: float
    min_relative_range: float
    smallest_singular_value: float
    level_tolerance: float
    min_curves_for_errors: int
    min_curves_to_resample: int
    level_gap: float
    left_out_groups: int
    pulling_weight: float
    odd_gain: float
    odd_scatter: float
    odd_factor: float
    odd_gain_deviations: float
    odd_gain_min: float
    sign_confidence: float
    bootstrap: int
