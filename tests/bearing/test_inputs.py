"""Uncertain inputs of a bearing: drawn from their ranges, with their values in the middle."""

import numpy as np

from bearings import SETTINGS, shipped
from oilfilm.bearing.inputs import INPUT_NAMES, Inputs

UNCERTAIN = {**shipped("mainshaft-167").uncertain, **SETTINGS.uncertain_inputs()}


def test_bearing_and_settings_have_every_input_within_its_range():
    assert set(UNCERTAIN) == set(INPUT_NAMES)
    for uncertain in UNCERTAIN.values():
        assert uncertain.low <= uncertain.value <= uncertain.high


def test_draws_fill_the_range_and_half_of_them_are_on_either_side_of_the_value():
    probability = (np.arange(1000) + 0.5) / 1000
    drawn = Inputs.drawn(UNCERTAIN, dict.fromkeys(INPUT_NAMES, probability))
    for name in INPUT_NAMES:
        values, uncertain = getattr(drawn, name), UNCERTAIN[name]
        assert uncertain.low <= values.min() < values.max() <= uncertain.high
        np.testing.assert_allclose(np.ptp(values), uncertain.high - uncertain.low, rtol=3e-3)
        # the value of an end of the range is no median
        if uncertain.low < uncertain.value < uncertain.high:
            assert (values < uncertain.value).mean() == 0.5
        else:
            middle = (uncertain.low + uncertain.high) / 2
            np.testing.assert_allclose(np.median(values), middle)


def test_a_bearing_of_unknown_flow_has_an_unknown_feed():
    unknown = shipped("harris-218").uncertain["feed_flow_m3_s"]
    assert np.isnan(unknown).all()
    assert np.isnan(unknown.quantiles(np.array([0.1, 0.9]))).all()
