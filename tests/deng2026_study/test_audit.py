"""The paper's claims: each has a check, planted laws get the verdict that is theirs by algebra."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import pandas as pd
import pytest
from claim_evidence import CLAIMS, OILS, claims_of, evidence_of, planted, with_study
from scipy.optimize import brentq, curve_fit

from campaigns import REFERENCE, Campaign, printed
from deng2026_study.audit import checks
from deng2026_study.audit.audit import (
    audit,
    audit_campaign,
    check,
    grid_of_box,
    refit_evidence,
    undoubted_evidence,
)
from deng2026_study.audit.audit import printed_evidence as of_printed
from deng2026_study.audit.evidence import Evidence, NotCheckableError, Outcome
from deng2026_study.reference import read_claims
from deng2026_study.settings import study_settings
from oilfilm import tables
from oilfilm.settings.messages import load
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.traction import LAWS
from planted_fits import fits_of
from reports import rows as rows_of
from simulated_lab.printed import PrintedCoefficients

Judge = Callable[..., Outcome]
InBearing = Callable[[Any], Evidence]
EVERY_CLAIM = read_claims(CLAIMS).claims


def same(**changes: float) -> dict[str, list[float]]:
    """The same planted constants for all oils."""
    return dict.fromkeys(OILS, planted(**changes))


@pytest.fixture(scope="module")
def judge(config: Settings) -> Judge:
    """The finding on one claim over a box, by constants of each oil or by evidence."""

    def judge(claim: str, basis: Any, where: str = "extrapolated") -> Outcome:
        evidence = basis if isinstance(basis, Evidence) else evidence_of(basis, config)
        return check(claim, replace(evidence, grid=grid_of_box(config, where)))

    return judge


@pytest.fixture(scope="module")
def in_bearing(config: Settings) -> InBearing:
    """Constants with three points of a bearing.

    4010 has the least torque at one of the two that are heavily loaded.
    """
    point = {"bearing": "b", "inlet_temperature_c": 100.0, "inner_speed_rpm": 1e4}
    point |= {"outer_max_hertz_pressure_gpa": 1.0, "lambda_ratio": 5.0, "pitch_speed_mm_rpm": 1e6}
    load_pressure = [(1e4, 1.6)] * 3 + [(2e4, 1.9)] * 3 + [(1e3, 1.2)] * 3
    slips = pd.DataFrame(
        load_pressure, columns=["axial_load_n", "inner_max_hertz_pressure_gpa"]
    ).assign(**point, oil=OILS * 3, torque_n_m=[3.0, 2.0, 1.0, 1.0, 2.0, 3.0, 3.0, 2.0, 1.0])
    return lambda constants: evidence_of(constants, config, cage_slip=slips)


def test_every_claim_has_its_check() -> None:
    claims = [claim.id for claim in EVERY_CLAIM]
    functions = [name for name in vars(checks) if name.replace("_", "-") in claims]
    assert [name.replace("_", "-") for name in functions] == claims


# ---------------------------------------------------------------- closed forms of Eq. 7


def test_linear_range_of_an_exponential_ends_by_algebra(judge: Judge, config: Settings) -> None:
    # B next to nothing: mu = |A| (1 - exp(-x)), x = C S; chord over slope is (1 - exp(-x))/x
    end = brentq(lambda x: (1 - np.exp(-x)) / x - 0.9, 0.01, 1.0) / 30.0
    finding = judge("linear-start", same(B0=1e-9), "tested")
    np.testing.assert_allclose(finding.cases["value"], end, rtol=2e-3)
    assert finding.numbers["within"] == (
        1.0 if end >= study_settings(config).audit.linear_to_slip else 0.0
    )
    # R2 of x and 1 - exp(-x) at 13 even steps to x = 0.3: 0.998
    assert finding.share == 1.0


@pytest.mark.parametrize(("slope", "rate"), [(0.5, 30.0), (0.05, 30.0), (0.4, 6.0), (2.0, 60.0)])
def test_peak_lies_by_algebra(judge: Judge, config: Settings, slope: float, rate: float) -> None:
    still = {f"{letter}{number}": 0.0 for letter in "ABC" for number in (1, 2, 3)}
    finding = judge("peak-decline", same(B0=slope, C0=rate, **still), "tested")
    peak = 1 / rate + 0.02 / slope
    end = study_settings(config).printed.boxes.tested.slide_roll_ratio[1]
    assert finding.numbers["peaks"] == float(peak < end)
    if peak < end:
        of_peak, of_end = (
            (slope * slip - 0.02) * np.exp(-rate * slip) + 0.02 for slip in (peak, end)
        )
        np.testing.assert_allclose(finding.cases["value"], 1 - of_end / of_peak, atol=1e-3)


def test_linear_rise_has_an_r2_of_one_and_a_cubic_one_not(judge: Judge, config: Settings) -> None:
    # with A and B alike in P and C free of it, mu is P to that power
    straight = judge("rises-with-stress", same())
    np.testing.assert_allclose(straight.cases["value"], 1.0, rtol=1e-12)
    assert straight.share == 1.0
    power = judge("rises-with-stress", same(A1=4.0, B1=4.0))
    pressure = np.linspace(0.8, 2.5, study_settings(config).audit.levels)
    r2 = np.corrcoef(pressure, pressure**4)[0, 1] ** 2
    np.testing.assert_allclose(power.cases["value"], r2, rtol=1e-12)
    assert power.share == 0.0
    assert power.numbers["always"] == 1.0


@pytest.mark.parametrize(
    ("claim", "kept", "broken"),
    [
        ("falls-with-temperature", {}, {"A3": 0.5, "B3": 0.5}),
        ("falls-with-speed", {}, {"A2": 0.5, "B2": 0.5}),
        ("rises-with-stress", {}, {"A1": -1.0, "B1": -1.0}),
        ("earlier-plateau", {"C1": 0.5}, {"C1": -0.5}),
        ("speed-mutes-temperature", {}, {"A2": 0.5, "B2": 0.5}),
    ],
)
def test_trend_holds_with_one_sign_of_its_exponent_and_fails_with_the_other(
    judge: Judge, claim: str, kept: dict[str, float], broken: dict[str, float]
) -> None:
    for where in ("tested", "extrapolated"):
        assert judge(claim, same(**kept), where).share == 1.0
        assert judge(claim, same(**broken), where).share == 0.0


def test_order_of_planted_oils_and_reverse_are_found(judge: Judge, in_bearing: InBearing) -> None:
    sizes = {"4102": 1.5, "4050": 1.2, "4010": 1.0}
    right = {oil: planted(size) for oil, size in sizes.items()}
    wrong = {oil: planted(1 / size) for oil, size in sizes.items()}
    for claim in ("viscosity-order", "light-load-4102", "slip-15", "heavy-load-4010"):
        assert judge(claim, in_bearing(right)).share == 1.0, claim
        assert judge(claim, in_bearing(wrong)).share == 0.0, claim
    # mu goes as the size, so that the nearest pair has 1.2
    np.testing.assert_allclose(judge("viscosity-order", right).worst_case("smallest")["value"], 1.2)
    ranks = judge("viscosity-order", right).numbers["commonest_rank"]
    assert ranks == {"4102": 1, "4050": 2, "4010": 3}
    # mu falls, and the difference of the oils with it: by (140/20)^-0.5
    both = judge("hot-convergence", right)
    np.testing.assert_allclose(both.cases["value"], 7**-0.5)
    assert both.share == 1.0


def test_claim_on_the_figures_has_its_share_in_the_tested_box(config: Settings) -> None:
    # mu goes as A0 and B0, and here as P to A1 = B1: 1.2 P^0.6 is above P below 1.2^2.5 = 1.58 GPa
    oils = {"4102": planted(1.2, A1=0.6, B1=0.6), "4050": planted(), "4010": planted(0.8)}
    made = audit(claims_of("viscosity-order"), [evidence_of(oils, config)])
    pressures = grid_of_box(config, "extrapolated").max_hertz_pressure_gpa
    assert made["claims"]["share"].item() == pytest.approx(np.mean(pressures < 1.2**2.5))
    numbers = made["claim_numbers"].set_index("number")["value"]
    assert numbers["share_tested"] == 1.0


@pytest.mark.parametrize(
    ("claim", "limits"),
    [
        ("heavy-load-4010", {"heavy_from_gpa": 3.0}),
        ("light-load-4102", {"light_below_gpa": 0.5}),
        ("slip-15", {"slip_limit": 0.9}),
    ],
)
def test_claim_about_no_place_is_open(
    config: Settings, claim: str, limits: dict[str, float]
) -> None:
    # with no film thick enough anywhere the thinnest oil is not asked for either
    thick = {"gates": {"lambda_limit": 100}}
    changed = with_study(config, {"selection": {"limits": limits}}).with_changes(thick)
    (row,) = tables.rows(audit(claims_of(claim), [of_printed(printed(), changed)])["claims"])
    assert (row["verdict"], row["reason_code"]) == ("cannot be checked", "no condition")


def test_oils_converge_by_the_ratio_of_their_exponents(judge: Judge) -> None:
    # one oil k times above two that are alike: the spread is k - 1 times their mu
    steep, plain = planted(2.0, A3=-0.7, B3=-0.7), planted()
    finding = judge("hot-convergence", {"4102": steep, "4050": plain, "4010": plain})
    ratio = (2.0 * 7**-0.2 - 1) / (2.0 - 1) * 7**-0.5
    np.testing.assert_allclose(finding.cases["value"], ratio, rtol=1e-9)
    assert (finding.share, finding.numbers["relative"]) == (1.0, 1.0)


def test_negative_traction_is_seen(judge: Judge, monkeypatch: pytest.MonkeyPatch) -> None:
    assert judge("non-negative", same()).share == judge("zero-slip", same()).share == 1.0
    mu = Evidence.mu
    monkeypatch.setattr(Evidence, "mu", lambda self, **levels: mu(self, **levels) - 1e-3)
    assert judge("non-negative", same()).share < 1.0
    assert judge("zero-slip", same()).share == 0.0


@pytest.mark.parametrize(
    # 0 at S = 0, and nowhere below 0: (A + B S) exp(-C S) - A, tanh, but not with a free D
    ("law", "given"),
    [("deng2026", True), ("tanh", True), ("wang-deng-load", False)],
)
def test_truth_by_equation_is_no_evidence(config: Settings, law: str, given: bool) -> None:
    evidence = evidence_of(printed(), config)
    laws = {oil: replace(fit, law=LAWS[law]) for oil, fit in evidence.fit_by_oil.items()}
    fitted, slips = replace(evidence, fit_by_oil=laws), np.linspace(0, 0.3, 31)
    no_slip = partial(checks._mu_for_any_constants, slip=np.zeros(1))
    assert checks._is_true_of_every_law(fitted, lambda law: no_slip(law) == 0) is given
    assert (
        checks._is_true_of_every_law(
            fitted, lambda law: checks._mu_for_any_constants(law, slips) >= 0
        )
        is given
    )


# ---------------------------------------------------------------- the printed constants


def test_order_of_the_oils_breaks_as_an_independent_count_says(judge: Judge) -> None:
    # docs/physics.md, traction law: 59 %, 55 %, at most 14 % together; 4010/4102 0.41 at 0.8 GPa
    # and 1.9
    # at 2.5 GPa; 4050 above 4102 below about 1.4 GPa. That count does not state its levels, and
    # the shares move with them (even steps of P and U give 71, 37 and 10 %): within 0.05.
    finding = judge("viscosity-order", printed())
    numbers: dict[str, Any] = finding.numbers
    assert numbers["above_next"]["4102"] == pytest.approx(0.59, abs=0.05)
    assert numbers["above_next"]["4050"] == pytest.approx(0.55, abs=0.06)
    assert finding.share <= 0.145
    assert numbers["thin_over_thick_lightest"] == pytest.approx(0.41, abs=0.07)
    assert numbers["thin_over_thick_heaviest"] == pytest.approx(1.9, abs=0.1)
    assert numbers["turn_gpa"] == pytest.approx(1.4, abs=0.15)


@pytest.mark.slow
def test_without_the_doubtful_oil_the_order_holds_in_part(config: Settings) -> None:
    doubtful = load(REFERENCE, PrintedCoefficients).doubtful
    views = [of_printed(printed(), config), undoubted_evidence(printed(), doubtful, config)]
    made = audit(EVERY_CLAIM, views)
    claims = made["claims"].pivot(index="claim", columns="basis", values=["verdict", "share"])
    order = claims.loc["viscosity-order"]
    assert order["verdict", "printed"] == "fails"
    assert order["verdict", "undoubted"] == "holds in part"
    # recomputed apart from this code: 61.5 % where 4010 were always the lowest
    assert order["share", "undoubted"] == pytest.approx(0.615, abs=0.001)
    # claims about this oil, about films and about speeds have no verdict without it
    unjudged = claims.index[claims["verdict", "undoubted"].isna()]
    assert {"heavy-load-4010", "slip-15", "full-film", "rolling-speed"} <= set(unjudged)


def test_only_the_doubtful_oil_has_more_traction_than_a_film_can_carry(config: Settings) -> None:
    doubtful = load(REFERENCE, PrintedCoefficients).doubtful
    evidence = of_printed(printed(), config).with_levels(
        max_hertz_pressure_gpa=[2.5], entrainment_speed_m_s=[20.0], inlet_temperature_c=[20.0]
    )
    largest = evidence.summary_by_oil(np.max, evidence.mu(slide_roll_ratio=evidence.curve_slips))
    limit = config.gates.traction_max
    assert {oil for oil, mu in largest.items() if mu > limit} == set(doubtful) == {"4010"}


def test_printed_constants_contradict_the_text_as_known(judge: Judge) -> None:
    # all figures: docs/physics.md, traction law
    spread: dict[str, Any] = judge("hot-convergence", printed()).numbers
    assert spread["spread_coldest"] == pytest.approx(0.71, abs=0.03)
    assert spread["spread_hottest"] == pytest.approx(0.63, abs=0.02)
    rise: dict[str, Any] = judge("rises-with-stress", printed()).numbers
    assert rise["median_r2"]["4010"] == pytest.approx(0.92, abs=0.015)
    plateau: dict[str, Any] = judge("earlier-plateau", printed(), "tested").numbers
    assert plateau["plateau_coldest"]["4102"] == pytest.approx(0.04, abs=0.005)
    assert plateau["plateau_hottest"]["4102"] == pytest.approx(0.16, abs=0.005)
    decline = judge("peak-decline", printed(), "tested")
    cold_4010 = decline.cases.query("oil == '4010' and inlet_temperature_c == 25")["value"]
    assert 0.49 <= cold_4010.max() <= 0.65


# recomputed apart from this code, by the printed constants: share read strictly, other readings
READ: dict[str, tuple[float, dict[str, float]]] = {
    "light-load-4102": (0.13, {"higher_viscosity": 0.98}),
    "hot-convergence": (0.86, {"relative": 0.41}),
    "speed-mutes-temperature": (1.0, {"relative": 0.67}),
    # the planted bearing: of two heavily loaded points 4010 has the least torque at one
    "heavy-load-4010": (0.0, {"bearing": 0.5, "bearing_points": 2.0}),
    # by algebra: 100 % of the ring's surface; the mean over both races is s/(1 + gamma (1 - s)),
    # within 10 % for gamma 0 and 0.1, not for 0.2 and 0.3
    "rolling-speed": (0.0, {"as_surface": 1.0}),
    "slip-is-cage-slip": (0.0, {"both_races": 0.5}),
    "composite-roughness": (0.0, {"rounded": 1.0}),  # 0.0172 um
}


@pytest.mark.parametrize(("claim", "expected"), READ.items(), ids=READ)
def test_each_fair_reading_has_its_share(
    judge: Judge, in_bearing: InBearing, claim: str, expected: tuple[float, dict[str, float]]
) -> None:
    finding = judge(claim, in_bearing(printed()))
    assert finding.share == pytest.approx(expected[0], abs=0.005)
    for name, share in expected[1].items():
        assert finding.numbers[name] == pytest.approx(share, abs=0.005)


def test_claim_fails_only_if_no_fair_reading_of_it_holds(config: Settings) -> None:
    claims = claims_of("viscosity-order", "light-load-4102", "speed-mutes-temperature")
    table = audit(claims, [of_printed(printed(), config)])["claims"]
    verdicts = table.set_index("claim")["verdict"]
    assert verdicts["viscosity-order"] == "fails"  # 14 %, and no other reading
    assert verdicts["light-load-4102"] == "holds in part"  # 13 %; oils of higher viscosity: 98 %
    assert verdicts["speed-mutes-temperature"] == "holds in part"  # 100 %; relative to mu: 67 %


def test_level_of_the_printed_law_rises_with_slip_as_recomputed(judge: Judge) -> None:
    # Fig. 8 at 1.5 GPa: from each of S 0.05, 0.1, 0.15, 0.2 to the next at 59, 74 and 38 %
    finding = judge("rises-with-slip", printed())
    shares = finding.cases.groupby("oil")["holds"].mean()
    assert shares["4102"] == pytest.approx(0.59, abs=0.01)
    assert shares["4050"] == pytest.approx(0.74, abs=0.01)
    assert shares["4010"] == pytest.approx(0.38, abs=0.01)


def test_thinnest_minimum_film_is_below_the_stated_one(judge: Judge, config: Settings) -> None:
    # minimum 0.079 um; central 0.132 um at the accepted points, whose conditions stray by 1 %
    basis = of_printed(printed(), config)
    finding = judge("full-film", basis, "tested")
    assert finding.numbers["thinnest_um"] == pytest.approx(0.079, abs=0.001)
    curve = basis.with_levels(
        slide_roll_ratio=[0.0, *basis.grid.slide_roll_ratio, basis.curve_slips[-1]]
    )
    assert curve.films(film_kind="central")[0].min() == pytest.approx(0.132, rel=0.02)
    assert finding.numbers["central"] == 1.0


def test_prediction_is_judged_at_left_out_ends_and_by_truth(config: Settings, judge: Judge) -> None:
    ends = {f"{end}_end_out_relative_rms": 0.04 for end in ("pressure", "temperature")}
    errors = {"rmse": 1e-4, "left_out_rmse": 3e-4, "relative_rms": 0.01} | ends
    fits = pd.DataFrame({"oil": ["4102"], "law": "deng2026", **errors}).assign(
        speed_end_out_relative_rms=0.2
    )
    regions: list[tuple[str, ...]] = [("temperature",)] * 3 + [()]
    truth = pd.DataFrame({"traction_coefficient": [0.0104, 0.02, 0.011, 0.5]}).assign(
        oil="4102", law="deng2026", true_traction_coefficient=0.01, beyond=regions
    )
    evidence = evidence_of(printed(), config, fit_quality=fits, extrapolation=truth)
    finding = judge("extrapolates", evidence)
    # 4, 20 and 4 %; curves left out 3 %; beyond the box 4, 100 and 10 %
    assert finding.share == pytest.approx(2 / 3)
    assert finding.numbers["accuracy"] == 1.0
    assert finding.numbers["left_out"] == pytest.approx(0.03)
    assert finding.numbers["truth"] == pytest.approx(1 / 3)


def test_constants_are_unique_where_certified_and_known_by_sign(
    config: Settings, judge: Judge
) -> None:
    fits = pd.DataFrame({"oil": ["4102", "4050"], "law": "deng2026", "certified": [True, False]})
    fits = fits.assign(constant_spread=[1e-6, 0.3])
    constants = pd.DataFrame({"verdict": ["known"] * 3 + ["open"]})
    constants = constants.assign(oil="4102", law="deng2026")
    slip = np.linspace(0.01, 0.3, 30)
    with_peak = (0.3 * slip - 0.02) * np.exp(-20 * slip) + 0.02
    # it rises to the end: any B near nothing fits as well, and its error has no end
    without_peak = 0.02 * slip**0.2
    mu = [*with_peak, *without_peak]
    points = pd.DataFrame({"slide_roll_ratio": [*slip, *slip], "traction_coefficient": mu})
    points = points.assign(oil="4102", run_id=["peak"] * 30 + ["none"] * 30)
    evidence = evidence_of(
        printed(), config, fit_quality=fits, coefficients=constants, points=points
    )
    finding = judge("uniquely-determined", evidence)
    numbers = finding.numbers
    assert (finding.share, numbers["constants"], numbers["known"]) == (0.5, 0.5, 0.75)
    assert numbers["spread"] == 0.3
    assert finding.cases["value"].max() == 1e3


@pytest.mark.slow
def test_errors_of_a_curve_are_the_scatter_of_refits_to_noisy_copies() -> None:
    slip = np.linspace(0.01, 0.3, 30)
    size, slope, rate, noise = 0.02, 0.3, 20.0, 1e-4
    mu = (slope * slip - size) * np.exp(-rate * slip) + size
    generator = np.random.default_rng(0)
    stated, fitted = [], []
    for _ in range(80):
        noisy = mu + generator.normal(0.0, noise, len(slip))
        stated.append(checks._coefficient_error_of_curve(slip, noisy))
        law, _ = curve_fit(
            lambda s, a, b, c: (b * s - a) * np.exp(-c * s) + a, slip, noisy, (size, slope, rate)
        )
        fitted.append(law)
    scatter = (np.std(fitted, axis=0) / (size, slope, rate)).max()
    # 80 copies give a standard deviation to 8 %
    assert np.median(stated) == pytest.approx(scatter, rel=0.15)


def test_a_point_at_almost_no_slip_does_not_decide_how_well_a_curve_is_known() -> None:
    # constants of a curve of 4010; at the first point mu is noise: its slope is 100 times too steep
    slip = np.linspace(0.0, 0.3, 31)
    slip[0] = 3.6e-6
    size, slope, rate = np.exp([-5.1889, -2.6295, 2.5859])
    mu = (slope * slip - size) * np.exp(-rate * slip) + size
    noisy = mu + np.random.default_rng(3).normal(0.0, 2e-5, len(slip))
    noisy[0] = 4.5e-5
    with_first = checks._coefficient_error_of_curve(slip, noisy)
    assert with_first == pytest.approx(
        checks._coefficient_error_of_curve(slip[1:], noisy[1:]), rel=0.3
    )


def test_a_curve_that_comes_to_its_level_without_a_peak_determines_no_b() -> None:
    slip = np.linspace(0.01, 0.3, 30)
    alternating = 1e-5 * (-1.0) ** np.arange(30)
    assert (
        checks._coefficient_error_of_curve(slip, 0.02 * (1 - np.exp(-30 * slip)) + alternating)
        > 1.0
    )


def test_load_suppresses_slip_where_the_slip_falls_from_load_to_load(
    config: Settings, judge: Judge
) -> None:
    slips = pd.DataFrame({"oil": "4102", "axial_load_n": [1e3, 2e3, 4e3, 8e3]}).assign(
        inlet_temperature_c=100.0,
        pitch_speed_mm_rpm=1e6,
        # from 0.4 it rises, then it falls; from 0.005 nothing is left to suppress
        cage_slip=[0.4, 0.5, 0.005, 0.006],
        inner_max_hertz_pressure_gpa=[0.8, 1.2, 1.6, 2.1],
        outer_max_hertz_pressure_gpa=0.5,
    )
    evidence = evidence_of(printed(), config, cage_slip=slips)
    finding = judge("load-suppresses-slip", evidence)
    assert (len(finding.cases), finding.share) == (2, 0.5)
    assert finding.worst_case("largest")["value"] == pytest.approx(0.1)
    grip = judge("heavy-load-grips", evidence)
    # one point of 2 GPa or more, which slips by 0.6 %; the point below 1 GPa slips by 40 %
    assert (len(grip.cases), grip.share, grip.numbers["light"]) == (1, 1.0, 0.0)
    with pytest.raises(NotCheckableError, match="no bearing"):
        judge("heavy-load-grips", evidence_of(printed(), config, cage_slip=slips[:3]))


def test_properties_are_needed_where_a_law_with_them_predicts_better(
    config: Settings, judge: Judge
) -> None:
    fits = pd.DataFrame({"oil": "4102", "law": ["deng2026", "wang-deng-groups", "tanh"]}).assign(
        temperature_end_out_relative_rms=[0.2, 0.1, 0.01], left_out_rmse=[2e-3, 1e-3, 1e-5]
    )
    # 4 % of mu at fitted curves, and twice as much at curves left out
    fits = fits.assign(rmse=1e-3, relative_rms=0.04)
    finding = judge("properties-not-needed", evidence_of(printed(), config, fit_quality=fits))
    # twice the error at curves left out, and at the end temperatures
    assert finding.worst_case("largest")["value"] == pytest.approx(2.0)
    assert (finding.share, finding.numbers["ends"], finding.numbers["enough"]) == (0.0, 0.0, 0.0)
    assert finding.numbers["least_error"] == {"4102": 0.1}
    # half the rms error at curves left out: 4 %, which is enough without properties
    better = fits.assign(left_out_rmse=1e-3)
    finding = judge("properties-not-needed", evidence_of(printed(), config, fit_quality=better))
    assert (finding.share, finding.numbers["enough"]) == (1.0, 1.0)


# ---------------------------------------------------------------- kinematics


def test_speeds_and_slips_of_the_text_are_those_of_equation_1(judge: Judge) -> None:
    # docs/physics.md, kinematics: about 105 m/s; 200 m/s is the surface speed of a ring. S over the
    # cage slip is 1.87, 1.92, 1.97, 1.98 in the equilibrium
    rolling, slip = (judge(claim, printed()) for claim in ("rolling-speed", "slip-is-cage-slip"))
    assert rolling.share == slip.share == 0.0
    assert rolling.cases["value"].max() == pytest.approx(105, rel=0.005)
    assert rolling.numbers["surface_speed"] == pytest.approx(209, abs=0.5)
    assert rolling.numbers["pitch_speed"] == pytest.approx(7.6e6, rel=0.01)
    assert slip.cases["value"].max() == pytest.approx(2.0)
    assert slip.cases["value"].min() > 1.5
    assert slip.numbers["at_limit"] == pytest.approx(0.29, abs=0.005)


# ---------------------------------------------------------------- tables of other rooms


COMPARISON = pd.DataFrame({"oil": "4102", "law": ["deng2026", "wang-deng-load"]}).assign(
    zero_slip_traction=[0.0, -0.002], rmse=[2e-4, 1e-4], left_out_rmse=[2.2e-4, 3e-4]
)


def test_wang_deng_claims_follow_the_comparison(judge: Judge, config: Settings) -> None:
    tame = COMPARISON.assign(zero_slip_traction=0.0, left_out_rmse=[2.2e-4, 1.1e-4])
    for claim in ("wang-deng-zero", "wang-deng-overfit"):
        for comparison, share in ((COMPARISON, 1.0), (tame, 0.0)):
            evidence = evidence_of(printed(), config, fit_quality=comparison)
            finding = judge(claim, evidence, "tested")
            assert finding.share == share
            # errors grow by 3.0 and by 1.1
            if (claim, share) == ("wang-deng-overfit", 1.0):
                assert finding.worst_case("smallest")["value"] == pytest.approx(3.0 / 1.1)
    # the paper's law made the points: with D = -A the other one is the same
    tie = evidence_of(printed(), config, fit_quality=COMPARISON, truth_is_law=True)
    with pytest.raises(NotCheckableError, match="tie"):
        judge(claim, tie, "tested")


@pytest.mark.parametrize(
    ("load", "stress", "stress_verdict", "load_verdict"),
    [
        (2.6, 0.03, "holds", "holds"),
        (0.9, -0.03, "holds", "holds in part"),
        (0.1, -0.2, "fails", "fails"),
    ],
)
def test_torque_claims_follow_the_torque_tests(
    config: Settings, load: float, stress: float, stress_verdict: str, load_verdict: str
) -> None:
    point = {"run_id": "r", "first_row": 1, "oil": "4102"}
    errors = {"load_variable": ["stress", "load"], "relative_error": [stress, load]}
    torque = pd.DataFrame(errors).assign(**point, bistable=False)
    evidence = evidence_of(printed(), config, torque=torque)
    made = audit(claims_of("torque-stress", "torque-load"), [evidence])["claims"]
    assert made["verdict"].tolist() == [stress_verdict, load_verdict]


# ---------------------------------------------------------------- the table


def results_of(campaign: Campaign, coefficients: pd.DataFrame) -> CampaignTables:
    of = campaign.curated
    return CampaignTables.from_frames(points=of.points, runs=of.runs, **fits_of(coefficients))


@pytest.fixture(scope="module")
def fits(demo: Campaign) -> dict[str, pd.DataFrame]:
    """Coefficients of each oil of the paper."""
    return {oil: demo.fit(oil, bootstrap=20, searches=2).coefficients for oil in OILS}


@pytest.fixture(scope="module")
def table(demo: Campaign, fits: dict[str, pd.DataFrame]) -> pd.DataFrame:
    refit = refit_evidence(results_of(demo, pd.concat(fits.values())), OILS, demo.config)
    return audit(EVERY_CLAIM, [refit, of_printed(printed(), demo.config)])["claims"]


@pytest.mark.slow
def test_table_has_every_claim_on_both_bases(table: pd.DataFrame) -> None:
    # claims on speeds alone need no fit
    once = {claim.id for claim in EVERY_CLAIM if claim.judged_on == "formula"}
    assert len(table) == 2 * len(EVERY_CLAIM) - len(once)
    assert (table.loc[table["claim"].isin(once), "basis"] == "printed").all()
    by_construction = table.loc[table["verdict"] == "by construction", "claim"]
    assert set(by_construction) == {"zero-slip", "non-negative"}
    unchecked = table["verdict"] == "cannot be checked"
    assert set(table.loc[unchecked, "claim"]) == {
        *("wang-deng-zero", "wang-deng-overfit", "torque-stress", "torque-load"),
        *("uniquely-determined", "genetic-optimum", "extrapolates", "heavy-load-4010"),
        *("air-spindle", "properties-not-needed", "load-suppresses-slip", "heavy-load-grips"),
    }
    assert (table["share"].isna() == unchecked).all()


@pytest.mark.slow
def test_refit_of_simulated_logs_gets_the_verdicts_of_its_truth(table: pd.DataFrame) -> None:
    # the twin's truth is the printed constants
    verdicts = table.pivot(index="claim", columns="basis", values="verdict").dropna()
    assert (verdicts["refit"] == verdicts["printed"]).all()
    shares = table.pivot(index="claim", columns="basis", values="share").dropna()
    np.testing.assert_allclose(shares["refit"], shares["printed"], atol=0.05)


def test_claim_about_what_was_not_fitted_or_calculated_cannot_be_checked(judge: Judge) -> None:
    known = {"4102": printed()["4102"]}
    with pytest.raises(NotCheckableError, match="no law"):
        judge("viscosity-order", known)
    with pytest.raises(NotCheckableError, match="no bearing"):
        judge("heavy-load-4010", printed())
    assert judge("zero-slip", known).share == 1.0


@pytest.mark.slow
def test_claims_are_judged_on_oils_of_the_paper(
    demo: Campaign, fits: dict[str, pd.DataFrame]
) -> None:
    fit = fits["4102"]
    own, points = fit.assign(oil="house oil"), demo.curated.points

    def evidence(fits: pd.DataFrame) -> Evidence:
        results = results_of(demo, fits).replace(
            points=points.assign(oil=points["oil"].replace("4050", "house oil")),
            torque=rows_of("torque", {"oil": "house oil", "relative_error": 9.9}),
        )
        return refit_evidence(results, OILS, demo.config)

    claims = claims_of("zero-slip", "viscosity-order", "extrapolates")
    unchecked = audit(claims, [evidence(own)])["claims"]
    assert (unchecked["verdict"] == "cannot be checked").all()
    # beside an oil of the paper: that one alone is judged
    both, alone = evidence(pd.concat([fit, own])), evidence(fit)
    assert list(both.fit_by_oil) == list(alone.fit_by_oil) == ["4102"]
    assert set(both.campaign_tables.points["oil"]) == {"4102", "4010"}
    assert both.campaign_tables.torque.empty
    assert set(both.campaign_tables.fit_quality["oil"]) == {"4102"}


@pytest.mark.slow
@pytest.mark.parametrize(("oils", "of_paper"), [(["own"], False), (["4102", "own"], True)])
def test_campaign_of_own_oils_has_no_claims_and_no_printed_rows(
    demo: Campaign, fits: dict[str, pd.DataFrame], oils: list[str], of_paper: bool
) -> None:
    own = pd.concat([fits["4102"].assign(oil=oil) for oil in oils])
    plain = demo.config.plain_values()
    config = Settings.from_plain_values(
        {**plain, "oils": dict.fromkeys(oils, plain["oils"]["4102"])}
    )
    made = audit_campaign(results_of(demo, own), REFERENCE, CLAIMS, config)
    assert set(made["claims"]["basis"]) == (
        {"refit", "printed", "undoubted"} if of_paper else set()
    )
