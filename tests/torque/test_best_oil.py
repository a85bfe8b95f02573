"""The best oil of a bearing: of equals the first, unknown where an unknown oil may be better."""

import numpy as np
import pandas as pd
import pytest

from oilfilm.torque.best_oil import (
    NOT_KNOWN,
    OPERATING_POINT_COLUMNS,
    best_oil_table,
    best_shares,
    certainty_of_best_oil,
)

LIMITS = {"slip_limit": 0.15, "lambda_limit": 3.0}
NAN = np.nan
OILS = ("thick", "middle", "thin")


def table(**columns: list[float]) -> pd.DataFrame:
    """The map of cage slip of three oils at one operating point."""
    rows = pd.DataFrame({"oil": OILS, **columns})
    return rows.assign(**dict.fromkeys(OPERATING_POINT_COLUMNS, 1.0))


@pytest.mark.slow
@pytest.mark.parametrize("bits", [0.0, 1e-12, -1e-12])
@pytest.mark.parametrize(
    ("torque", "slip", "lambda_ratio", "best_oil"),
    [
        ([3.0, 2.0, 1.0], [0.01, 0.01, 0.15], [9.0, 8.0, 7.0], "thin"),  # just held
        ([3.0, 2.0, 1.0], [0.01, 0.01, 0.01], [9.0, 8.0, 3.0], "middle"),  # just no full film
        ([2.0, 1.0, 1.0], [0.01, 0.01, 0.01], [9.0, 8.0, 7.0], "middle"),  # two of one torque
        ([2.0, 1.0, 1.0], [0.3, 0.2, 0.2], [9.0, 8.0, 7.0], "middle"),  # two of one slip
        ([2.0, 1.0, NAN], [0.3, 0.2, NAN], [9.0, 8.0, NAN], NOT_KNOWN),  # no equilibrium
        ([2.0, 1.0, NAN], [0.3, 0.2, NAN], [9.0, 8.0, 2.0], "middle"),  # no film either
        ([3.0, 2.0, 1.0], [0.1, 0.1, 0.1], [9.0, 8.0, NAN], NOT_KNOWN),  # best with enough film
        ([3.0, 2.0, 1.0], [0.1, 0.1, 0.1], [NAN, 8.0, 7.0], "thin"),  # whatever its film
        ([3.0, 2.0, 1.0], [0.1, 0.1, 0.1], [2.0, 2.0, 2.0], ""),
    ],
)
def test_the_best_oil_does_not_depend_on_the_last_digits(
    torque: list[float], slip: list[float], lambda_ratio: list[float], best_oil: str, bits: float
) -> None:
    for oil_index in range(len(OILS)):
        rounding_factor = np.ones(len(OILS))
        rounding_factor[oil_index] += bits
        columns = {"torque_n_m": torque, "cage_slip": slip, "lambda_ratio": lambda_ratio}
        rows = table(
            **{name: np.array(values) * rounding_factor for name, values in columns.items()}
        )
        assert best_oil_table(rows, **LIMITS)["best_oil"].tolist() == [best_oil]


def draws(best_oil_of_draw: list[int]) -> np.ndarray:
    """Draws of one point with a full film and a held cage, in which these oils have least torque.

    Returns:
        Torque, slip and lambda, shape (3, draws, oils).
    """
    torque = np.full((len(best_oil_of_draw), len(OILS)), 2.0)
    torque[np.arange(len(torque)), best_oil_of_draw] = 1.0
    return np.stack([torque, np.full_like(torque, 0.1), np.full_like(torque, 9.0)])


def shares(values: np.ndarray) -> pd.DataFrame:
    columns = best_shares(values, len(OILS), **LIMITS)
    return pd.DataFrame({"oil": OILS, **columns}).assign(
        **dict.fromkeys(OPERATING_POINT_COLUMNS, 1.0)
    )


@pytest.mark.parametrize("best_count", [94, 95, 96])
def test_one_draw_without_an_equilibrium_moves_a_share_by_one_count_and_turns_no_verdict(
    best_count: int,
) -> None:
    complete_draws = draws([2] * best_count + [1] * (100 - best_count))
    shares_before = shares(complete_draws)
    stability_before = certainty_of_best_oil(shares_before, 0.95).iloc[0]
    assert stability_before["surely"] == (best_count >= 95)
    assert not stability_before["perhaps"]
    # the first and the last draw of each oil; draws of one oil are equal
    for lost_draw_index in (0, best_count - 1, best_count, 99):
        draws_with_a_loss = complete_draws.copy()
        draws_with_a_loss[:, lost_draw_index, 0] = NAN
        shares_after = shares(draws_with_a_loss)
        assert shares_after["draws_answered"].tolist() == [99] * 3
        assert shares_after["draws_unanswered"].tolist() == [1] * 3
        assert (
            (shares_after["best_share"] - shares_before["best_share"]).abs() <= 0.01 + 1e-12
        ).all()
        # it may become open, but never the contrary
        stability_after = certainty_of_best_oil(shares_after, 0.95).iloc[0]
        assert (
            stability_after["surely"]
            <= stability_before["surely"]
            <= stability_after["surely"] | stability_after["perhaps"]
        )


def test_a_draw_whose_best_oil_depends_on_an_unknown_film_counts_for_no_oil() -> None:
    complete_draws = draws([2] * 60 + [1] * 40)
    complete_draws[2, :10, 2] = NAN  # it would be the best one
    complete_draws[2, -10:, 0] = NAN  # it would not
    table = shares(complete_draws)
    assert table["draws_unanswered"].tolist() == [10] * 3
    np.testing.assert_allclose(table["best_share"], [0, 40 / 90, 50 / 90])


def test_without_any_draw_there_is_no_share() -> None:
    table = shares(np.full((3, 100, len(OILS)), NAN))
    assert table["best_share"].isna().all()
    assert table["draws_answered"].tolist() == [0] * 3
    assert not certainty_of_best_oil(table, 0.95)["surely"].any()
