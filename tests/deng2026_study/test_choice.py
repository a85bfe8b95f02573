"""What the report says of the choice of oil: what has an answer, and how much has none."""

import numpy as np
import pandas as pd
import pytest

from deng2026_study import study
from deng2026_study.advice import NO_EQUILIBRIUM, OUTSIDE_FILM_FORMULA
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


def points_of_map() -> pd.DataFrame:
    """Two speeds at each of two loads."""
    return pd.DataFrame(
        {
            "bearing": "any",
            "inlet_temperature_c": 100.0,
            "inner_speed_rpm": [1e3, 2e3, 1e3, 2e3],
            "pitch_speed_mm_rpm": [1e6, 2e6, 1e6, 2e6],
            "axial_load_n": [1e3, 1e3, 1e4, 1e4],
        }
    )


def test_picture_shows_the_best_oil_and_where_it_stays_best(config: Settings) -> None:
    points = points_of_map()
    judged = {"judgement": ["agree", "heats more", "agree", "no film"]}
    advice = points.assign(**judged, advised_oil="4010", best_oil=["4010", "4050", "4010", ""])
    # 96, 90, 99 and 100 of 100 draws; the last point has no best oil in the map
    slips = points.assign(
        oil="4010", best_share=[0.96, 0.9, 0.99, 1.0], draws_answered=100, draws_unanswered=0
    )
    results = CampaignTables.from_frames(
        slip_advice=tables.filled_table(advice, "slip_advice"),
        cage_slip=tables.filled_table(slips, "cage_slip"),
    )
    figure, drawn = draw("slip-advice", results, config)
    assert nothing_is_cut_off(figure)
    sure = drawn[drawn["series"] == "stays best"]
    assert list(zip(sure["x"], sure["y"], strict=True)) == [(1.0, 1.0), (1.0, 10.0)]
    assert len(drawn[drawn["series"] == "advised oil"]) == len(points)
    legend = [text.get_text() for text in figure.legends[0].get_texts()]
    assert {"it heats more", "no film thick enough"} <= set(legend)


def test_dot_is_for_the_oil_of_the_cell_and_not_for_one_that_no_rule_names(
    config: Settings,
) -> None:
    points = points_of_map()
    judgements = ["agree", "agree", "agree", NO_EQUILIBRIUM]
    advice = points.assign(judgement=judgements, advised_oil="4010", best_oil="4010")
    draws = {"draws_answered": 100, "draws_unanswered": 0}
    # at the first point another oil is the best; at the last one the choice is not decided
    slips = pd.concat(
        [
            points.assign(oil="4010", best_share=[0.01, 0.97, 0.5, 0.99], **draws),
            points.assign(oil="own", best_share=[0.99, 0.03, 0.5, 0.01], **draws),
        ]
    )
    results = CampaignTables.from_frames(
        slip_advice=tables.filled_table(advice, "slip_advice"),
        cage_slip=tables.filled_table(slips, "cage_slip"),
    )
    figure, drawn = draw("slip-advice", results, config)
    sure = drawn[drawn["series"] == "stays best"]
    assert list(zip(sure["x"], sure["y"], strict=True)) == [(2.0, 1.0)]
    legend = [text.get_text() for text in figure.legends[0].get_texts()]
    assert "best in at least 95 % of the draws" in legend
    assert nothing_is_cut_off(figure)


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
