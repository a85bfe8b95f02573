"""Friction torque of a bearing, term by term, from the balance of all that acts on its balls.

Decides: the terms of a bearing's friction torque.
"""

from collections.abc import Mapping

import numpy as np

from oilfilm.bearing.ellipse import sliding, traction
from oilfilm.bearing.friction import FrictionEquilibrium
from oilfilm.bearing.resistance import HEATS
from oilfilm.physics.contact import Conditions, Floats
from oilfilm.physics.film import film_thickness, within_thermal_reduction
from oilfilm.physics.oils import LIMITING_STRESS_RATIO
from oilfilm.units import MM_PER_M, BoolArray, FloatArray


def torque_terms(
    found: FrictionEquilibrium,
    tested: Mapping[str, FloatArray | tuple[float, float]],
    limiting_stress_ratio: FloatArray | float = LIMITING_STRESS_RATIO,
) -> dict[str, FloatArray]:
    """Torque on the inner ring with its terms, motion and residuals, an array a column.

    A term is its heat over the inner ring's speed: with the outer ring at rest they add up to the
    moment that turns the inner ring. On the outer ring balls and cage exert less, by what the oil
    between them takes; a sensor on a ring and its whole housing has that as well.

    Args:
        found: The equilibrium, the outer ring at rest.
        tested: Lowest and highest tested level of pressure, speed and slip, of all points or of
            each; NaN where unknown.
        limiting_stress_ratio: Of the oil of all points or of each.
    """
    problem = found.problem
    bearing, points = problem.bearing, problem.points
    balance, film, share = found.balance, found.balance.traction, problem.rule.share
    inner = points.ring_speed_rad_s[:, 0]
    speed = np.where(inner == 0, np.inf, inner)
    heats = dict(zip(HEATS, balance.heats_w, strict=True))
    heats |= _heat_by_sliding(found)
    balls, torque = bearing.ball_count, found.torque_n_m()
    rule = problem.rule.finer()
    slip = sliding(bearing, balance.contacts, balance.motion, points.ring_speed_rad_s, rule)
    factor = problem.lubrication.factor("traction")
    finer = traction(balance.contacts, slip, balance.at, problem.law, rule, factor)
    angle = np.degrees(balance.contacts.contact_angle_rad)
    pressure, rolling = (
        level[..., 0]
        for level in (balance.at.max_hertz_pressure_gpa, balance.at.entrainment_speed_m_s)
    )
    # of the heat of traction, outside the tested ranges
    local_heat = film.coefficient * film.slide_roll_ratio * share
    local_heat = local_heat * (balance.contacts.load_n * rolling)[..., np.newaxis]
    beyond_slip = _beyond(film.slide_roll_ratio, (0.0, tested["slide_roll_ratio"][1]))
    beyond_pressure = _beyond(pressure, tested["max_hertz_pressure_gpa"])
    beyond_speed = _beyond(rolling, tested["entrainment_speed_m_s"])
    # contacts whose mean shear stress, mu times their mean pressure, no film of the oil carries
    over_limit = film.coefficient @ share > np.reshape(limiting_stress_ratio, (-1, 1))
    lambda_ratio, film_in_range = film_ratio(found)
    return {
        **{f"{name}_torque_n_m": balls * heat / speed for name, heat in heats.items()},
        "torque_n_m": torque,
        "outer_ring_torque_n_m": balls * balance.ring_moment_n_m[:, 1],
        "energy_error": _relative(torque * inner, balls * np.sum(balance.heats_w, axis=0)),
        "quadrature_error": _relative(finer.heat_w.sum(axis=1), film.heat_w.sum(axis=1)),
        "residual": found.solution.residual,
        "converged": found.solution.converged,
        "widest_contact": found.widest_contact(),
        "held_by_band": found.held_by_band(),
        "outside_law": found.outside_law(),
        "cage_slip": found.cage_slip(),
        "inner_slide_roll_ratio": balance.sliding.middle_slide_roll_ratio[:, 0],
        "inner_contact_angle_deg": angle[:, 0],
        "outer_contact_angle_deg": angle[:, 1],
        "inner_max_hertz_pressure_gpa": pressure[:, 0],
        "outer_max_hertz_pressure_gpa": pressure[:, 1],
        "lambda_ratio": lambda_ratio,
        "film_in_range": film_in_range,
        "entrainment_speed_m_s": rolling.mean(axis=1),
        "largest_slide_roll_ratio": film.slide_roll_ratio.max(axis=(1, 2)),
        "mean_traction_coefficient": _mean(
            film.coefficient, share * balance.contacts.load_n[..., np.newaxis]
        ),
        "contacts_over_stress_limit": balls * over_limit.sum(axis=1),
        "share_beyond_slip": _mean(beyond_slip, local_heat),
        "share_beyond_pressure": _mean(beyond_pressure, film.heat_w),
        "share_beyond_speed": _mean(beyond_speed, film.heat_w),
    }


def film_ratio(found: FrictionEquilibrium) -> tuple[FloatArray, BoolArray]:
    """Minimum film over combined Rq in the worst contact, and whether the formula holds in all.

    The film is reduced by inlet heating at the contact's slide-roll ratio, averaged over the
    ellipse with the load as weight. The ratio in the contact's middle would leave out spin, which
    is sliding everywhere else. Beyond the range of the reduction there is no value.
    """
    bearing, at, oil = (
        found.problem.bearing,
        found.balance.at,
        found.problem.lubrication.of_contacts,
    )
    of_contacts = {
        name: value[..., 0] if np.ndim(value) else value for name, value in vars(at).items()
    }
    load = np.maximum(of_contacts["load_n"], np.finfo(float).tiny)
    at = Conditions(**of_contacts | {"load_n": load})
    film = film_thickness(
        oil, at, found.balance.traction.slide_roll_ratio @ found.problem.rule.share, "minimum"
    )
    loading = oil.thermal_loading(at.entrainment_speed_m_s)
    within = within_thermal_reduction(at.relative_pressure, loading)
    in_range = np.asarray(within.all(axis=1))
    return np.where(in_range, film.min(axis=1) / bearing.roughness_rq_m, np.nan), in_range


def _heat_by_sliding(found: FrictionEquilibrium) -> dict[str, FloatArray]:
    """Heat of traction split by the kind of sliding, (points,) each; they add up to it."""
    film, slip = found.balance.traction, found.balance.sliding
    orbit = slip.race_rad_s * found.balance.contacts.orbit_radius_m[:, np.newaxis]
    middle = slip.roll_rad_s * slip.middle_m * film.along_n
    heats = {
        "gross": film.along_n * orbit + middle,
        "spin": -slip.spin_rad_s * film.about_normal_n_m,
        "differential": -slip.roll_rad_s * film.about_across_n_m - middle,
        "gyroscopic": -found.balance.motion.spin_rad_s[:, 2:] * film.about_tangent_n_m,
    }
    return {name: heat.sum(axis=1) for name, heat in heats.items()}


def _beyond(values: FloatArray, tested: FloatArray | tuple[float, float]) -> FloatArray:
    # a thousandth of leeway, for levels that a rig holds only so well
    low, high = (np.reshape(end, (-1, *(1,) * (values.ndim - 1))) for end in tested)
    beyond = ((values < low * 0.999) | (values > high * 1.001)).astype(float)
    return np.where(np.isfinite(low + high), beyond, np.nan)


def _mean(values: FloatArray, weights: FloatArray) -> FloatArray:
    """Weighted mean of each point; 0 where nothing weighs."""
    over = tuple(range(1, values.ndim))
    total = np.broadcast_to(weights, values.shape).sum(axis=over)
    mean = np.divide(
        (values * weights).sum(axis=over), total, out=np.zeros(len(values)), where=total > 0
    )
    # rounding must not move a mean outside its values
    return np.clip(mean, values.min(axis=over), values.max(axis=over))


def _relative(first: FloatArray, second: FloatArray) -> FloatArray:
    """(first - second)/first; 0 where `first` is 0."""
    return np.divide(first - second, first, out=np.zeros_like(first), where=first != 0)


_CST = 1e6
_N_MM = 1e-3


def palmgren_torque_n_m(
    axial_load_n: Floats,
    speed_rpm: Floats,
    kinematic_viscosity_m2_s: Floats,
    pitch_diameter_m: float,
    contact_angle_rad: float,
    f0: float,
    f1: float,
) -> FloatArray:
    """Palmgren's torque: a part of speed and one of load.

        M0 = 1e-7 f0 (nu n)^(2/3) dm^3 N mm, at least that of nu n = 2000
        M1 = f1 P1 dm,   P1 = 0.9 Fa cot(alpha)

    with nu in cSt, n in 1/min, dm in mm.

    Args:
        axial_load_n: Fa.
        speed_rpm: n.
        kinematic_viscosity_m2_s: nu.
        pitch_diameter_m: dm.
        contact_angle_rad: alpha, unloaded.
        f0: Of lubrication and bearing type.
        f1: Of load and bearing type.

    Returns:
        M0 + M1, in N m; NaN without contact angle.

    Reference: A. Palmgren, Ball and Roller Bearing Engineering, 3rd ed., 1959.

    Examples:
        dm 100 mm, nu n = 8000, f0 1, no load: 1e-7 * 400 * 1e6 N mm.

        >>> print(f"{palmgren_torque_n_m(0.0, 1000.0, 8e-6, 0.1, 0.5, 1.0, 1e-3):.3f} N m")
        0.040 N m
    """
    pitch = pitch_diameter_m * MM_PER_M
    turning = np.maximum(kinematic_viscosity_m2_s * _CST * speed_rpm, 2000.0)
    of_speed = 1e-7 * f0 * turning ** (2 / 3) * pitch**3
    # of a bearing without contact angle he has another formula
    per_load = 0.9 / np.tan(contact_angle_rad) if contact_angle_rad > 0 else np.nan
    of_load = f1 * per_load * axial_load_n * pitch
    return np.asarray(_N_MM * (of_speed + of_load))


def skf_torque_n_m(
    axial_load_n: Floats,
    speed_rpm: Floats,
    kinematic_viscosity_m2_s: Floats,
    pitch_diameter_m: float,
) -> FloatArray:
    """SKF's rolling and sliding torque, without drag, seals and starvation.

        Mrr = phi_ish Grr (nu n)^0.6,   Grr = R1 dm^1.97 (Fg + R2 Fa)^0.54,   Fg = R3 dm^4 n^2
        Msl = Gsl mu_sl,   Gsl = S1 dm^0.26 (Fs^(4/3) + S2 Fa^(4/3)),   Fs = S3 dm^4 n^2
        phi_ish = 1/(1 + 1.84e-9 (n dm)^1.28 nu^0.64)
        mu_sl = phi_bl 0.12 + (1 - phi_bl) 0.04,   phi_bl = exp(-2.6e-8 (n nu)^1.4 dm)

    with R1, R2, R3 = 5.03e-7, 1.97, 1.90e-12 and S1, S2, S3 = 1.30e-2, 0.68, 1.91e-12, nu in cSt,
    n in 1/min, dm in mm, torque in N mm.

    Args:
        axial_load_n: Fa.
        speed_rpm: n.
        kinematic_viscosity_m2_s: nu.
        pitch_diameter_m: dm.

    Returns:
        Mrr + Msl, in N m.

    Validity: loads above the catalogue's minimum and speeds up to a bearing's limiting speed, about
    0.7 million mm rpm for single-row angular-contact bearings. Sliding goes with n^(8/3): at 2
    million mm rpm it alone is several times any measured torque.

    Reference: SKF, Rolling bearings, general catalogue, 2018: the SKF model for calculating the
        frictional moment, angular contact ball bearings.

    Examples:
        At rest the film is gone: 0.12 S1 dm^0.26 S2 Fa^(4/3) = 0.035 N m at 100 mm, 1 kN, by hand:

        >>> print(f"{skf_torque_n_m(1000.0, 0.0, 5e-6, 0.1):.3f} N m")
        0.035 N m
    """
    pitch, nu = pitch_diameter_m * MM_PER_M, kinematic_viscosity_m2_s * _CST
    turning = nu * np.asarray(speed_rpm, dtype=float)
    heating = 1 / (1 + 1.84e-9 * (speed_rpm * pitch) ** 1.28 * nu**0.64)
    of_balls = 1.90e-12 * pitch**4 * np.square(speed_rpm)
    rolling = 5.03e-7 * pitch**1.97 * (of_balls + 1.97 * axial_load_n) ** 0.54 * turning**0.6
    slid_by_balls = 1.91e-12 * pitch**4 * np.square(speed_rpm)
    sliding = slid_by_balls ** (4 / 3) + 0.68 * np.power(axial_load_n, 4 / 3)
    touching = np.exp(-2.6e-8 * turning**1.4 * pitch)
    friction = touching * 0.12 + (1 - touching) * 0.04
    return np.asarray(_N_MM * (heating * rolling + friction * 1.30e-2 * pitch**0.26 * sliding))
