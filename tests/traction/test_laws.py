"""Every traction law: gradients, planted truth, bases that are one law written twice."""

from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt
import pytest

from fit_points import problem_of
from law_points import (
    EVERY_LAW,
    MATRIX,
    OIL,
    PLAUSIBLE_CONSTANTS,
    SLIP,
    internal_of,
    observe,
    points_of,
)
from nights import nightly
from oilfilm.base.randomness import generator
from oilfilm.fits import global_search
from oilfilm.fits.fit import fit_oil
from oilfilm.fits.fitted import FittedLaw
from oilfilm.fits.problem import build_problem, curve_data
from oilfilm.physics.contact import Contact, load_for_max_hertz_pressure
from oilfilm.physics.thermal_traction import eyring_shear_stress, limited_stress
from oilfilm.settings.resolved import Settings
from oilfilm.traction import LAWS, expression
from oilfilm.traction.law import CONDITIONS, Law, NoValueError
from oilfilm.traction.laws.wang_deng import WANG_DENG_GROUPS

ComplexArray = npt.NDArray[np.complex128]


def by_hand(law: Law, internal: ComplexArray) -> ComplexArray:
    """mu by the law's own text, evaluated by Python with complex numbers: nothing of oilfilm."""
    names: dict[str, Any] = {
        **{name: getattr(np, name) for name in ("exp", "expm1", "log", "log1p", "sqrt", "tanh")},
        "asinh": np.arcsinh,
        "abs": lambda value: np.where(value.real < 0, -value, value),
        "S": np.tile(SLIP, len(MATRIX)).astype(complex),
    }
    design = law.design(MATRIX[list(law.conditions)].to_numpy())
    constants = internal.reshape(len(law.coefficients), -1)
    for coefficient, constants_of_coefficient in zip(law.coefficients, constants, strict=True):
        size = np.exp(design @ constants_of_coefficient)
        names[coefficient.name] = coefficient.sign * np.repeat(size, len(SLIP))
    for name, text in law.parts:
        names[name] = eval(text, names)
    return np.asarray(eval(law.equation, names))


@pytest.mark.parametrize("law", EVERY_LAW.values(), ids=EVERY_LAW)
def test_values_and_jacobian_are_those_of_the_text(law: Law) -> None:
    """By the complex step d mu/dx = Im mu(x + i h)/h, without any difference taken."""
    observations, internal = observe(law), internal_of(law)
    mu = by_hand(law, internal.astype(complex)).real
    np.testing.assert_allclose(law.traction(internal, observations), mu, rtol=0, atol=1e-16)
    for index, column in enumerate(law.jacobian(internal, observations).T):
        step = np.where(np.arange(len(internal)) == index, 1e-30j, 0)
        expected = by_hand(law, internal + step).imag / 1e-30
        np.testing.assert_allclose(column, expected, rtol=0, atol=2e-16)


@pytest.mark.parametrize("law", EVERY_LAW.values(), ids=EVERY_LAW)
def test_scaling_the_slip_is_a_direction_of_the_constants(law: Law) -> None:
    internal, observations = internal_of(law), observe(law)
    step = 1e-5
    ends = [
        law.traction(internal, replace(observations, slip=observations.slip * np.exp(move)))
        for move in (step, -step)
    ]
    expected = (ends[0] - ends[1]) / (2 * step)
    slope = law.jacobian(internal, observations) @ law.slip_direction
    np.testing.assert_allclose(slope, expected, rtol=1e-6, atol=1e-9)


@pytest.mark.parametrize("law", EVERY_LAW.values(), ids=EVERY_LAW)
def test_curvatures_are_the_slopes_of_the_slopes(law: Law) -> None:
    """By central differences, of some of the coefficients and in their order."""
    observations, step = observe(law), 1e-5
    magnitudes = law.magnitudes(internal_of(law), observations.design)[
        :, observations.curve_of_point
    ]
    by = tuple(range(len(law.coefficients)))[-3:]
    mu, slopes, curvatures = law.mu_slopes_and_curvatures(magnitudes, observations.slip, by)
    mu_alone, all_slopes = law.mu_and_slopes(magnitudes, observations.slip)
    np.testing.assert_array_equal(mu, mu_alone)
    np.testing.assert_array_equal(slopes, [all_slopes[index] for index in by])
    pairs = [(first, second) for first in by for second in by if second <= first]
    for curvature, (first, second) in zip(curvatures, pairs, strict=True):
        moved = np.exp(step * (np.arange(len(magnitudes)) == second))[:, np.newaxis]
        up = law.mu_and_slopes(magnitudes * moved, observations.slip)[1][first]
        down = law.mu_and_slopes(magnitudes / moved, observations.slip)[1][first]
        np.testing.assert_allclose(curvature + 0 * up, (up - down) / (2 * step), atol=1e-9)


@pytest.mark.parametrize("law", EVERY_LAW.values(), ids=EVERY_LAW)
def test_coefficients_in_which_mu_is_linear_are_those_of_equal_differences(law: Law) -> None:
    start = law.magnitudes(internal_of(law), observe(law).design)
    slip = np.full(start.shape[1], 0.04)
    terms = len(law.constants) // len(law.coefficients)
    for index in range(len(start)):
        mu = []
        for factor in (0.9, 1.0, 1.1):
            magnitudes = start.copy()
            magnitudes[index] *= factor
            mu.append(law.mu_of_magnitudes(magnitudes, slip))
        linear = np.allclose(np.diff(mu, n=2, axis=0), 0, atol=1e-12)
        assert law.is_linear_x0[index * terms] == linear


def test_equation_with_an_unknown_name_is_told() -> None:
    with pytest.raises(ValueError, match="found 'cos\\(S\\)'; expected numbers, S"):
        expression.parse("1 - cos(S)", {"S": expression.name_node("S")})


@pytest.mark.slow
@pytest.mark.parametrize("law", EVERY_LAW.values(), ids=EVERY_LAW)
def test_global_search_finds_the_planted_law(law: Law, config: Settings) -> None:
    task = problem_of(points_of(law), law)
    (optimum,) = global_search.search(task, config.fit, [generator(3, "planted", law.name)])
    truth = np.array(PLAUSIBLE_CONSTANTS[law.name])[task.is_free]
    np.testing.assert_allclose(
        task.in_equation_form(optimum.constants), truth, rtol=1e-4, atol=1e-6
    )
    assert optimum.sse < 1e-14 * float(np.sum(task.mu**2))


# Not the law with a critical load, of which 33 of 40 do: it has a valley between two of the loads.
ONE_VALLEY = [law for name, law in EVERY_LAW.items() if name != "wang-deng-critical-load"]


@pytest.mark.parametrize("noise", [nightly(0.0), nightly(2e-4)])
@pytest.mark.parametrize("law", ONE_VALLEY, ids=lambda law: law.name)
def test_each_of_forty_searches_finds_the_planted_law(
    law: Law, noise: float, config: Settings
) -> None:
    task = problem_of(points_of(law, noise), law)
    randoms = [generator(3, "forty", law.name, number) for number in range(40)]
    ends = np.array([optimum.sse for optimum in global_search.search(task, config.fit, randoms)])
    from_truth = global_search.converge(task, internal_of(law)[task.is_free])
    rounding = 1e-14 * float(np.sum(task.mu**2))
    assert (ends <= (1 + 1e-8) * from_truth.sse + rounding).all()


@pytest.mark.slow
@pytest.mark.parametrize(
    "name", ["deng2026", "deng-exponential", "wang-deng-groups", "eyring", "rational-viscosity"]
)
def test_fit_read_back_from_its_tables_is_the_planted_traction(name: str, config: Settings) -> None:
    law = EVERY_LAW[name]
    settings = config.fit.model_copy(update={"bootstrap": 20, "searches": 1})
    points = points_of(law, noise=1e-5)
    fit = fit_oil(points, "4050", settings, config.seed, law=law)
    fitted = FittedLaw.from_tables(fit.coefficients, "4050", fit.refits, fit.fit_quality, law)
    levels = MATRIX[list(law.conditions)].to_numpy()
    conditions = np.repeat(levels, len(SLIP), axis=0)
    true = law.traction(internal_of(law), observe(law))
    predicted = fitted.predict(conditions, np.tile(SLIP, len(MATRIX)))
    np.testing.assert_allclose(predicted.traction_coefficient, true, atol=3e-5)
    assert np.isfinite(predicted.mean_ci_upper).all()
    assert not predicted.outside.any()


def test_dimensionless_load_depends_on_pressure_over_modulus_alone() -> None:
    """W/(E' R^2) = (2 pi^3/3) (p_max/E')^3: no ball size can be read from it."""
    pressure = 1.2e9
    groups = []
    for radius_m, modulus_pa in ((0.010, 221.6e9), (0.003, 221.6e9), (0.010, 443.2e9)):
        contact = Contact(radius_m, modulus_pa, 1e-8)
        load_n = float(load_for_max_hertz_pressure(pressure, radius_m, modulus_pa))
        law = WANG_DENG_GROUPS.for_oil(OIL, contact)
        group = law.group_values(np.array([[load_n, 30.0, 70.0]]))[0, 0]
        assert group == pytest.approx(2 * np.pi**3 / 3 * (pressure / modulus_pa) ** 3, rel=1e-12)
        groups.append(group)
    assert groups[0] == pytest.approx(groups[1], rel=1e-12)
    assert groups[0] == pytest.approx(8 * groups[2], rel=1e-12)


def test_load_and_stress_are_one_law_for_one_ball(config: Settings) -> None:
    """W ~ p^3: the same least SSE, and exponents of pressure three times those of load."""
    of_load = LAWS["wang-deng-load"]
    of_stress = replace(
        of_load, conditions=CONDITIONS, groups=CONDITIONS, reference=(1.0, 20.0, 20.0)
    )
    points = points_of(of_load, noise=2e-4)
    on_load, on_stress = (
        global_search.search(problem_of(points, law), config.fit, [generator(1, "bases", seed)])[0]
        for law, seed in ((of_load, "load"), (of_stress, "stress"))
    )
    assert on_stress.sse == pytest.approx(on_load.sse, rel=1e-9)
    np.testing.assert_allclose(on_stress.constants[1::4], 3 * on_load.constants[1::4], rtol=1e-5)
    np.testing.assert_allclose(
        on_stress.constants[2::4], on_load.constants[2::4], rtol=1e-5, atol=1e-7
    )


def test_critical_load_far_above_is_the_law_without_it() -> None:
    """|Wc/W - 1| -> Wc/W: the factor is a constant and one exponent of load."""
    plain, critical = LAWS["wang-deng-load"], LAWS["wang-deng-critical-load"]
    far = np.array([*internal_of(plain), np.log(1e3), -1, 0, 0])
    far[0] -= np.log(1e3)
    far[1] += 1
    expected = plain.traction(internal_of(plain), observe(plain))
    # |K - 1| is off from K by W/Wc, 0.14 % at most here, and so is A, of size 0.03
    mu = critical.traction(far, observe(critical))
    np.testing.assert_allclose(mu, expected, atol=1e-4)


def test_three_levels_of_load_leave_two_critical_loads() -> None:
    """A0, A1 and Wc make A at three loads: one Wc above them all, and one among them."""
    law = LAWS["wang-deng-critical-load"]
    points = points_of(law)
    three = points[points["max_hertz_pressure_gpa"] != 1.15]
    task, start, ends = problem_of(three, law), internal_of(law), []
    for critical in (3.0, 0.5):  # over 100 N; the loads are 42, 93 and 142 N
        start[16] = np.log(critical)
        ends.append(global_search.converge(task, start[task.is_free]))
    assert max(end.sse for end in ends) < 1e-14 * float(np.sum(three["traction_coefficient"] ** 2))
    first, second = np.exp([end.constants[-1] for end in ends])
    assert first == pytest.approx(3.0, rel=1e-4)
    assert 0.42 < second < 1.42


def test_eyring_law_solves_its_own_equation() -> None:
    law = LAWS["eyring"]
    slope, eyring, limit, heat = magnitudes = np.array([5.0, 0.01, 0.05, 200.0])
    mu = law.mu_of_magnitudes(magnitudes, SLIP)
    cold = limited_stress(eyring_shear_stress(slope, SLIP, eyring), limit)
    np.testing.assert_allclose(mu * (1 + heat * SLIP * mu), cold, rtol=1e-12)
    # heat makes a peak; without it the film only saturates
    assert 0 < np.argmax(mu) < len(SLIP) - 1
    magnitudes[3] = 1e-9
    np.testing.assert_allclose(law.mu_of_magnitudes(magnitudes, SLIP), cold, rtol=1e-8)


def test_circular_law_solves_its_own_equation() -> None:
    """eta gamma = tau/sqrt(1 - (tau/tau_L)^2) of the film, and mu (1 + H S mu) of the heat."""
    slope, limit, heat = magnitudes = np.array([5.0, 0.05, 200.0])
    mu = LAWS["circular"].mu_of_magnitudes(magnitudes, SLIP)
    cold = mu * (1 + heat * SLIP * mu)
    np.testing.assert_allclose(cold / np.sqrt(1 - (cold / limit) ** 2), slope * SLIP, rtol=1e-9)
    assert 0 < np.argmax(mu) < len(SLIP) - 1


def test_rational_law_falls_as_the_root_of_the_slip() -> None:
    law = EVERY_LAW["rational-viscosity"]
    slope, bend, fall = magnitudes = np.array([5.0, 60.0, 2.0])
    assert law.mu_of_magnitudes(magnitudes, np.array(1e-7)) == pytest.approx(1e-7 * slope, rel=1e-4)
    far = np.array([1e6, 4e6])
    expected = slope / (bend * np.sqrt(fall * far))
    np.testing.assert_allclose(law.mu_of_magnitudes(magnitudes, far), expected, rtol=1e-5)


def test_exponential_law_is_the_power_law_next_to_the_reference_temperature() -> None:
    """exp(x (T/20 - 1)) and (T/20)^x have the same slope at 20 degC, and one is known in frost."""
    power, exponential = LAWS["deng2026"], LAWS["deng-exponential"]
    near, cold = np.array([1.2, 30.0, 20.02]), np.array([1.2, 30.0, -40.0])
    internal = internal_of(power)
    magnitudes = power.magnitudes(internal, power.design(near))
    np.testing.assert_allclose(
        exponential.magnitudes(internal, exponential.design(near)), magnitudes, rtol=2e-6
    )
    np.testing.assert_allclose(exponential.design(cold)[0, 3], -3.0)
    with pytest.raises(NoValueError, match="needs inlet_temperature_c above zero"):
        power.design(cold)
    with pytest.raises(NoValueError, match="needs entrainment_speed_m_s above zero"):
        exponential.design(np.array([1.2, 0.0, -40.0]))


def test_group_of_the_rational_law_is_the_viscosity_of_the_oil() -> None:
    """Oil 4050 is a MIL-L-23699 oil: 46.4 and 5.01 mPa s at 25 and 100 degC (docs/physics.md)."""
    law = EVERY_LAW["rational-viscosity"]
    groups = law.group_values(np.array([[1.2, 30.0, 25.0], [1.2, 30.0, 100.0]]))
    np.testing.assert_allclose(groups[:, :2], [[1.2, 30.0]] * 2)
    np.testing.assert_allclose(groups[:, 2], [46.40e-3, 5.01e-3], rtol=1e-3)


@pytest.mark.parametrize(
    ("name", "varied", "why"),
    [
        ("wang-deng-groups", [True, True, False], "speed and temperature to vary"),
        ("wang-deng-groups", [True, False, True], "speed and temperature to vary"),
        ("wang-deng-critical-load", [False, True, True], "needs load_n to vary"),
    ],
)
def test_law_is_refused_where_too_little_varies(name: str, varied: list[bool], why: str) -> None:
    law = EVERY_LAW[name]
    data = curve_data(points_of(law), law.conditions)
    with pytest.raises(ValueError, match=why):
        build_problem(law, data, np.array(varied))


@pytest.mark.parametrize(
    ("name", "magnitudes", "slope", "level"),
    [
        # by each law's own equation: slope at rest, level at endless slip
        ("deng2026", [0.03, 0.9, 27.0], 0.9 + 0.03 * 27.0, 0.03),
        ("carreau", [5.0, 0.02, 0.6, 0.05], 5.0, 0.05),
        ("tanh", [0.05, 5.0], 5.0, 0.05),
        # without heat
        ("circular", [5.0, 0.05, 1e-12], 5.0, 0.05),
        ("eyring", [5.0, 0.01, 0.05, 200.0], 5.0, None),
    ],
)
def test_law_starts_with_its_slope_and_ends_at_its_level(
    name: str, magnitudes: list[float], slope: float, level: float | None
) -> None:
    law = LAWS[name]
    assert law.mu_of_magnitudes(np.array(magnitudes), np.array(1e-7)) / 1e-7 == pytest.approx(
        slope, rel=1e-4
    )
    if level is not None:
        assert law.mu_of_magnitudes(np.array(magnitudes), np.array(1e6)) == pytest.approx(
            level, rel=1e-6
        )


def test_constant_beyond_its_bound_is_held_there_and_the_others_fitted() -> None:
    """tanh below its slope's bound: every end is on the bound, none beyond it."""
    law = LAWS["tanh"]
    points = points_of(law)
    points["traction_coefficient"] = 0.005 * points["slide_roll_ratio"]  # B0 >= 0.01
    task = problem_of(points, law)
    end = global_search.converge(task, internal_of(law))
    assert (task.distance_beyond_bounds(end.constants) == 0).all()
    held = task.holding(end.constants, global_search.is_at_bound(task, end.constants))
    assert "B0" in held.values_at_bounds
    assert held.values_at_bounds["B0"] == pytest.approx(0.01)
    assert "B0" not in held.free_names


def test_a_coefficient_may_have_the_name_of_a_step() -> None:
    nodes = {name: expression.name_node(name) for name in ("S", "x0")}
    mu = expression.parse("tanh(S) * x0 + tanh(S)", nodes)
    steps, (result,) = expression.straight_line_form([mu])
    values = {"S": 1.0, "x0": 5.0}
    for name, step in steps:
        assert name not in values
        values[name] = eval_node(step, values)
    assert eval_node(result, values) == pytest.approx(6 * np.tanh(1.0), rel=1e-12)


def eval_node(node: expression.Node, values: dict[str, float]) -> float:
    """A node of products, sums and tanh, evaluated here."""
    if node.operation == "name":
        return values[str(node.leaf)]
    if node.operation == "tanh":
        return float(np.tanh(eval_node(node.operands[0], values)))
    left, right = (eval_node(operand, values) for operand in node.operands)
    return left * right if node.operation == "*" else left + right
