"""The study of a genetic algorithm: what is stored follows from its constants.

`make bench NAME=genetic` stores it.
"""

from types import ModuleType

import numpy as np
import pytest
from scipy.optimize import least_squares

from campaigns import ROOT


@pytest.fixture(scope="module")
def study() -> ModuleType:
    with pytest.MonkeyPatch.context() as patched:
        patched.syspath_prepend(str(ROOT / "benchmarks"))
        import genetic  # noqa: PLC0415

        return genetic


@pytest.mark.parametrize("oil", ["4102", "4050", "4010"])
def test_genetic_algorithm_never_beats_the_certified_optimum(study: ModuleType, oil: str) -> None:
    rows = [row for row in study.read_table() if row["oil"] == oil]
    assert {row["search"] for row in rows} == {
        *(study.OURS, study.RAW, study.LOGS),
        *(study.RAW_POLISHED, study.LOGS_POLISHED, study.RANDOM_POLISHED),
    }
    _, data = study.task(oil)
    ours = np.array([rows[0][name] for name in study.NAMES])
    assert rows[0]["search"] == study.OURS
    # a descent by other code, on the raw constants with differences instead of slopes
    scale = np.abs(ours)
    least = (
        2
        * least_squares(
            lambda x: study.mu_of(x * scale, data) - data.mu, ours / scale, xtol=1e-12, ftol=1e-14
        ).cost
    )
    assert rows[0]["sse"] == pytest.approx(least, rel=1e-6)
    for row in rows:
        mu = study.mu_of(np.array([row[name] for name in study.NAMES]), data)
        sse = np.sum((mu - data.mu) ** 2)
        assert row["sse"] == pytest.approx(sse, rel=1e-4)
        assert sse >= least * (1 - 1e-6)
        off = np.abs(mu - study.mu_of(ours, data)).max()
        assert row["largest_difference_of_mu"] == pytest.approx(off, rel=1e-3, abs=1e-9)


def test_polished_genetic_algorithm_on_raw_constants_ends_at_the_optimum(study: ModuleType) -> None:
    """Polished again from its stored, unpolished ends."""
    rows = study.read_table()
    for oil in study.OILS:
        _, data = study.task(oil)
        (ours,) = study.rows_of_search(rows, oil, study.OURS)
        for row in study.rows_of_search(rows, oil, study.RAW)[:2]:
            start = np.array([row[name] for name in study.NAMES])
            mu = study.mu_of(study.polished_raw(start, data), data)
            assert np.sum((mu - data.mu) ** 2) == pytest.approx(ours["sse"], rel=1e-6)
