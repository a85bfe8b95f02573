"""What the report says of the choice of oil: what has an answer, and how much has none."""

import numpy as np
import pandas as pd
import pytest
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from deng2026_study import study
from deng2026_study.advice import NO_EQUILIBRIUM, OUTSIDE_FILM_FORMULA, advise
from deng2026_study.settings import study_settings
from deng2026_study.study import sections
from oilfilm import tables
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.torque.best_oil import OPERATING_POINT_COLUMNS
from pictures import draw, nothing_is_cut_off

OILS = ("4102", "4050", "4010")


def told(judgements: list[str], answered: list[int], share: list[float], settings: Settings) -> str:
    """The sentences about operating points of 100 draws each.

    Args:
        judgements: One per point, as in `slip_advice`.
        answered: Draws with an answer.
        share: Share of these in which 4010 is the best oil.
        settings: Any.
    """
    points = pd.DataFrame(
        dict.fromkeys(OPERATING_POINT_COLUMNS, np.arange(len(judgements), dtype=float))
    )
    points = points.assign(bearing="any")
    advice = points.assign(judgement=judgements, advised_oil="4010", best_oil="4010")
    answered = np.array(answered)
    slips = pd.concat(
        [
            points.assign(
                oil=oil,
                best_share=np.where(answered > 0, part, np.nan),
                draws_answered=answered,
                draws_unanswered=100 - answered,
            )
            for oil, part in zip(OILS, (0.0, 1 - np.array(share), np.array(share)), strict=True)
        ]
    )
    results = CampaignTables.from_frames(
        slip_advice=tables.filled_table(advice, "slip_advice"),
        cage_slip=tables.filled_table(slips, "cage_slip"),
    )
    (section,) = [each for each in sections(results, settings) if each.anchor == "choice"]
    return "\n".join(fact.text for fact in section.facts)


@pytest.mark.parametrize("bits", [0.0, 1e-12, -1e-12])
def test_points_at_which_one_oil_stays_best_are_counted_whatever_the_last_digits(
    config: Settings, bits: float
) -> None:
    # just 95 of 100 draws, 94, all
    text = told(["agree"] * 3, [100] * 3, [0.95 + bits, 0.94, 1.0 - abs(bits)], config)
    assert "in at least 95 % of the draws" in text
    assert "at 2 of 3 operating points" in text
    assert "not known" not in text


def test_draws_without_an_answer_are_counted_beside_the_others(config: Settings) -> None:
    # of 99 draws with an answer 94, 97 and 93: the lost one could have made 95 of the first alone
    text = told(["agree"] * 3, [99] * 3, [94 / 99, 97 / 99, 93 / 99], config)
    assert "at 1 of 3 operating points" in text
    assert "not known in 3 of 300 draws" in text
    assert "At 1 further operating points these draws decide" in text


def test_a_law_without_refits_has_no_sentence_about_draws(config: Settings) -> None:
    assert "draws" not in told(["agree"], [0], [0.0], config)


# Speed in rpm and load in N of an operating point, and the oils there with their torque, lambda and
# share of best draws. No cage slips: the least torque with a film decides.
_OilNumbers = dict[str, tuple[float, float, float]]
_FURTHER_OIL = "9999"
_MAP: dict[tuple[float, float], _OilNumbers] = {
    # one of the rules' oils is best in 96 % of the draws
    (1e3, 1e3): {"4102": (3, 9, 0), "4050": (2, 8, 0.04), "4010": (1, 7, 0.96)},
    # it is best in 90 %
    (2e3, 1e3): {"4102": (3, 9, 0), "4050": (1, 8, 0.9), "4010": (2, 7, 0.1)},
    # 4010 is the best of the rules' oils, but an oil that they do not name is better
    (3e3, 1e3): {"4102": (3, 9, 0), "4050": (2, 8, 0), "4010": (1, 7, 0.01)},
    # the rules advise 4010 if it has a film; 4050 is the best oil with and without that film
    (1e3, 1e4): {"4102": (3, 9, 0), "4050": (1, 8, 0.99), "4010": (2, np.nan, 0)},
    # 4010 may be the best oil, but it has no equilibrium
    (2e3, 1e4): {"4102": (3, 9, 0), "4050": (1, 8, 1.0), "4010": (np.nan, np.nan, 0)},
    # no oil has a film, but one has it in all draws
    (3e3, 1e4): {"4102": (3, 2, 1.0), "4050": (2, 2, 0), "4010": (1, 2, 0)},
}


def _map_of_cage_slip() -> pd.DataFrame:
    """Table of cage slip of `_MAP`, with an oil that the rules do not name."""
    rows = []
    for (speed_rpm, load_n), oils in _MAP.items():
        point = {"bearing": "any", "inlet_temperature_c": 100.0, "axial_load_n": load_n}
        point |= {"inner_speed_rpm": speed_rpm, "pitch_speed_mm_rpm": 1e3 * speed_rpm}
        further_oil = {_FURTHER_OIL: (9.0, 9.0, 0.0)}
        if (speed_rpm, load_n) == (3e3, 1e3):
            further_oil = {_FURTHER_OIL: (0.5, 9.0, 0.99)}
        for oil, (torque_n_m, lambda_ratio, best_share) in (oils | further_oil).items():
            numbers = {"torque_n_m": torque_n_m, "lambda_ratio": lambda_ratio}
            # no equilibrium has neither a torque nor a slip
            cage_slip = np.nan if np.isnan(torque_n_m) else 0.01
            numbers |= {"cage_slip": cage_slip, "best_share": best_share}
            rows.append(point | {"oil": oil} | numbers)
    pressures = {"inner_max_hertz_pressure_gpa": 1.5, "outer_max_hertz_pressure_gpa": 1.5}
    map_of_slip = pd.DataFrame(rows).assign(draws_answered=100, draws_unanswered=0, **pressures)
    return tables.filled_table(map_of_slip, "cage_slip")


@pytest.fixture(scope="module")
def picture(config: Settings) -> tuple[Figure, pd.DataFrame]:
    """The figure of `_MAP`, and what it draws."""
    cage_slip = _map_of_cage_slip()
    advice = advise(cage_slip, study_settings(config).selection, config.gates.lambda_limit)
    assert advice["judgement"].tolist()[3:] == [OUTSIDE_FILM_FORMULA, NO_EQUILIBRIUM, "no film"]
    results = CampaignTables.from_frames(slip_advice=advice, cage_slip=cage_slip)
    return draw("slip-advice", results, config)


def test_picture_dots_the_best_oil_only_where_that_oil_itself_stays_best(
    picture: tuple[Figure, pd.DataFrame],
) -> None:
    figure, drawn = picture
    sure = drawn[drawn["series"] == "stays best"]
    assert set(zip(sure["x"], sure["y"], sure["oil"], strict=True)) == {
        (1.0, 1.0, "4010"),
        (1.0, 10.0, "4050"),
    }
    assert len(drawn[drawn["series"] == "advised oil"]) == len(_MAP)
    legend = [text.get_text() for text in figure.legends[0].get_texts()]
    assert {"best in at least 95 % of the draws", "no film thick enough"} <= set(legend)
    assert nothing_is_cut_off(figure)


def test_picture_shows_each_known_best_oil_and_no_other(
    config: Settings, picture: tuple[Figure, pd.DataFrame]
) -> None:
    figure, _ = picture
    best_axes, advised_axes = figure.axes[:2]
    # by rows of load; "" is white
    best_oils = [["4010", "4050", "4010"], ["4050", "", ""]]
    oil_of_number = ["", *config.oils]
    numbers_of_cells = np.asarray(best_axes.collections[0].get_array(), dtype=int)
    assert np.array(oil_of_number)[numbers_of_cells].tolist() == best_oils
    # symbols of cells without a choice: in (a) where the best oil is not known, in (b) all three
    assert _symbols(best_axes) == {"x", "1"}
    assert _symbols(advised_axes) == {"x", "+", "1"}


def _symbols(axes: Axes) -> set[str]:
    """Symbols of `axes` that tell why there is no choice."""
    return {str(line.get_marker()) for line in axes.lines} & {"x", "+", "1"}


def test_operating_points_without_a_choice_are_told_by_reason(config: Settings) -> None:
    judgements = ["agree", "slips", "no film", "no film", OUTSIDE_FILM_FORMULA, NO_EQUILIBRIUM]
    text = told(judgements, [100] * 6, [1.0] * 6, config)
    assert "at 1 of 2 operating points" in text
    assert "No choice at 2 operating points: no oil has enough film." in text
    assert "No choice at 1 operating point: an oil has no equilibrium." in text
    assert "No choice at 1 operating point: the choice depends on a film" in text


@pytest.mark.parametrize(
    ("cage_slip", "shown", "not_shown"),
    [
        (0.1, "truly slips by more than 2 %, the law is off by", "nowhere"),
        (0.01, "truly slips by more than 2 % nowhere", "not known"),
    ],
)
def test_report_tells_the_slip_above_which_relative_errors_count(
    config: Settings, monkeypatch: pytest.MonkeyPatch, cage_slip: float, shown: str, not_shown: str
) -> None:
    monkeypatch.setattr(study, "_SMALLEST_SLIP_FOR_RELATIVE_ERROR", 0.02)
    points = pd.DataFrame(dict.fromkeys(OPERATING_POINT_COLUMNS, np.arange(1.0)))
    advice = points.assign(bearing="any", judgement="agree", true_judgement="agree")
    law_columns = {"law_cage_slip": 0.1, "law_torque_n_m": 1.0, "torque_n_m": 1.0}
    truth = points.assign(bearing="any", cage_slip=cage_slip, **law_columns)
    results = CampaignTables.from_frames(
        slip_advice=tables.filled_table(advice, "slip_advice"),
        cage_slip=tables.filled_table(truth, "cage_slip"),
        true_cage_slip=tables.filled_table(truth, "true_cage_slip"),
    )
    (section,) = [each for each in sections(results, config) if each.anchor == "choice"]
    (text_of_truth,) = [fact.text for fact in section.facts if "truly slips" in fact.text]
    assert shown in text_of_truth
    assert not_shown not in text_of_truth
    # without intervals none is counted
    assert "0 of 0" not in text_of_truth
