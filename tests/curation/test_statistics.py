"""Means, errors and spikes of stretches, beside a plain loop over the stretches."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from oilfilm.curation import statistics
from oilfilm.curation.statistics import Stretches, mean_with_error

SHARE, THRESHOLD = 0.2, 3.0


def standard_error(values: np.ndarray) -> float:
    """The definition, spelt out."""
    length = len(values)
    if length < 2:
        return np.nan
    about = values - values.mean()
    covariance = np.correlate(about, about, "full")[length - 1 :]
    last = next((lag for lag in range(1, length) if not covariance[lag] > 0), length)
    variance = covariance[0] + 2 * covariance[1:last].sum()
    return float(np.sqrt(variance / (length - 1) / length))


def spikes(values: np.ndarray) -> np.ndarray:
    deviation = np.abs(values - np.median(values))
    # the standard deviation of a normal distribution over its median absolute deviation
    spread = 1.482602218505602 * np.median(deviation)
    # of few readings, the spread is often far too small
    factor = {3: 26, 4: 8, 5: 3.2, 6: 1.9, 7: 1.7, 8: 1.3, 9: 1.3}.get(len(values), 1)
    return (deviation > factor * THRESHOLD * spread) & (spread > 0)


def mean(values: np.ndarray) -> float:
    return float(values.mean()) if len(values) else np.nan


def signal(kind: str, rows: int, random: np.random.Generator) -> np.ndarray:
    noise = random.standard_normal(rows)
    noise[random.random(rows) < 0.02] += 30
    # 0 where the sensor shows one value, a drift and a hum where lags count
    return {
        "noise": noise,
        "drift": np.arange(rows) / 7 + noise,
        "hum": np.sin(2 * np.pi * np.arange(rows) / 45) + noise / 20,
        "coarse": np.round(noise),
    }[kind]


# one stretch of up to 90 % of the log, and any number of others from one row on
lengths = st.builds(
    lambda others, long, place: [*others[:place], long, *others[place:]],
    st.lists(st.integers(1, 60), min_size=0, max_size=30),
    st.integers(1, 2000),
    st.integers(0, 30),
)


@given(lengths, st.integers(0, 5), st.sampled_from(["noise", "drift", "hum", "coarse"]))
def test_stretches_of_any_lengths_give_what_each_gives_alone(
    lengths: list[int], gap: int, kind: str
) -> None:
    starts = np.cumsum([0, *np.array(lengths[:-1]) + gap])
    stops = starts + lengths
    log = signal(kind, int(stops[-1]) + gap, np.random.default_rng(sum(lengths)))
    stretches = Stretches(starts, stops)
    values = stretches.cut(log)
    found = stretches.spikes(values, THRESHOLD)
    inside = ~found
    first = stretches.is_in_first_part(inside, SHARE)
    alone = [log[start:stop] for start, stop in zip(starts, stops, strict=True)]
    spikes_alone = [spikes(part) for part in alone]
    kept = [part[~spike] for part, spike in zip(alone, spikes_alone, strict=True)]
    begun = [part[: int(len(part) * SHARE + 1e-9)] for part in kept]
    assert found.tolist() == np.concatenate(spikes_alone).tolist()
    assert stretches.counts(inside).tolist() == [len(part) for part in kept]
    means = stretches.means(values, inside)
    np.testing.assert_allclose(means, [mean(part) for part in kept], rtol=1e-12, atol=1e-12)
    of_first = stretches.means(values, first)
    np.testing.assert_allclose(of_first, [mean(part) for part in begun], rtol=1e-12, atol=1e-12)
    everything = stretches.all_samples()
    errors = stretches.standard_errors(values, everything, stretches.means(values, everything))
    np.testing.assert_allclose(errors, [standard_error(part) for part in alone], rtol=1e-9)
    error_of_last = mean_with_error(alone[-1])[1]
    np.testing.assert_allclose(error_of_last, errors[-1], rtol=1e-12)


@pytest.mark.parametrize("turns", [0.2, 3.0])
def test_error_of_a_stretch_that_is_transformed_in_blocks_is_that_of_the_definition(
    monkeypatch: pytest.MonkeyPatch, turns: float
) -> None:
    # 0.2 turns are correlated over several blocks, 3 over less than one
    monkeypatch.setattr(statistics, "_MOST_SAMPLES_TRANSFORMED", 100)
    noise = np.random.default_rng(1).standard_normal(950)
    values = np.sin(turns * np.linspace(0, 2 * np.pi, 950)) + noise / 10
    _, error = mean_with_error(values)
    np.testing.assert_allclose(error, standard_error(values), rtol=1e-12)


def test_no_stretch_gives_no_number() -> None:
    nothing = np.array([], dtype=np.int64)
    stretches = Stretches(nothing, nothing)
    values = stretches.cut(np.ones(3))
    inside = ~stretches.spikes(values, THRESHOLD)
    means = stretches.means(values, inside)
    assert len(means) == 0
    assert len(stretches.standard_errors(values, inside, means)) == 0
    assert len(stretches.is_in_first_part(inside, SHARE)) == 0


@pytest.mark.parametrize("length", [3, 4, 5, 6, 7, 8, 9, 10])
def test_readings_of_noise_are_no_spikes_however_few_they_are(length: int) -> None:
    count = 20_000
    noise = np.random.default_rng(length).standard_normal((count, length))
    stops = length * np.arange(1, count + 1)
    stretches = Stretches(stops - length, stops)
    # 13 % of 3 readings where the threshold is the same for any number
    assert (stretches.counts(stretches.spikes(noise.ravel(), 8.0)) > 0).mean() < 0.01
    # a force of 5 N among noise of 0.02 N is one; two others can hardly tell their noise
    noise[:, 1] += 250
    found_share = (stretches.counts(stretches.spikes(noise.ravel(), 8.0)) > 0).mean()
    assert found_share > (0.4 if length == 3 else 0.6)
