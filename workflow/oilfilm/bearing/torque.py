"""Friction torque of a bearing, term by term, from the balance of all that acts on its balls.

Decides: the terms of a bearing's friction torque; what catalogues estimate (Palmgren, SKF).
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from oilfilm.base.units import MM_PER_M, BoolArray, FloatArray
from oilfilm.bearing.ellipse import sliding_in_ellipses, traction_in_ellipses
from oilfilm.bearing.friction import FrictionEquilibrium
from oilfilm.bearing.resistance import HEAT_TERMS
from oilfilm.physics.contact import Conditions, Floats
from oilfilm.physics.film import film_thickness, is_in_thermal_reduction_range
from oilfilm.physics.oils import LIMITING_STRESS_RATIO

# Relative accuracy with which a rig holds a level.
_LEVEL_ACCURACY = 1e-3


def torque_terms(
    equilibrium: FrictionEquilibrium,
    tested_ranges: Mapping[str, FloatArray | tuple[float, float]],
    limiting_stress_ratio: FloatArray | float = LIMITING_STRESS_RATIO,
) -> dict[str, FloatArray]:
    """Torque on the inner ring with its terms, motion and residuals, one array per column.

    A term is its heat over the speed of the inner ring. With the outer ring at rest the terms of
    `HEAT_TERMS` add up to the moment that turns the inner ring. Where the flow of oil is not known,
    the term momentum is NaN and the torque does not include it. The terms gross, spin, differential
    and gyroscopic divide the term traction by the kind of sliding.

    Balls and cage exert less on the outer ring, because the oil between the rings takes the drag. A
    torque sensor on the housing measures the drag too.

    Args:
        equilibrium: The equilibrium; the outer ring is at rest.
        tested_ranges: Lowest and highest tested level of pressure, speed, temperature and slip, by
            the name of the quantity; for all points or for each point; NaN where unknown.
        limiting_stress_ratio: Limiting stress ratio of the oil, for all points or for each point.

    Returns:
        Arrays of shape (points,), by the names of the columns.
    """
    balance = equilibrium.balance
    ball_count = equilibrium.problem.bearing.ball_count
    inner_speed_rad_s = equilibrium.problem.points.ring_speed_rad_s[:, 0]
    # infinite at rest, so that there is no torque where nothing turns
    divisor_rad_s = np.where(inner_speed_rad_s == 0, np.inf, inner_speed_rad_s)
    heat_w_of_term = dict(zip(HEAT_TERMS, balance.heats_w, strict=True))
    heat_w_of_term.update(_traction_heat_by_sliding(equilibrium))
    torque_n_m = equilibrium.torque_n_m()
    heat_w = ball_count * np.sum(balance.heats_w, axis=0)
    contact_angle_deg = np.degrees(balance.contacts.contact_angle_rad)
    conditions = _conditions_of_contacts(equilibrium)
    pressure_gpa = conditions.max_hertz_pressure_gpa
    speed_m_s = conditions.entrainment_speed_m_s
    mean_slide_roll_ratio = _mean_slide_roll_ratio(equilibrium)
    lambda_ratio, film_in_range = worst_lambda_ratio(equilibrium)
    torque_of_term = {
        f"{name}_torque_n_m": ball_count * heat_w_of_ball / divisor_rad_s
        for name, heat_w_of_ball in heat_w_of_term.items()
    }
    carried_flow_kg_s = equilibrium.problem.lubrication.carried_flow_kg_s
    torque_of_term["momentum_torque_n_m"] = np.where(
        np.isnan(carried_flow_kg_s), np.nan, torque_of_term["momentum_torque_n_m"]
    )
    equilibrium_columns = {
        "torque_n_m": torque_n_m,
        "outer_ring_torque_n_m": ball_count * balance.ring_moment_n_m[:, 1],
        "energy_error": _relative_difference(torque_n_m * inner_speed_rad_s, heat_w),
        "quadrature_error": _quadrature_error(equilibrium),
        "residual": equilibrium.solution.residual,
        "converged": equilibrium.solution.converged,
        "widest_contact": equilibrium.widest_contact(),
        "held_by_band": equilibrium.held_by_band(),
        "outside_law": equilibrium.outside_law(),
        "cage_slip": equilibrium.cage_slip(),
        "inner_slide_roll_ratio": balance.sliding.middle_slide_roll_ratio[:, 0],
        "inner_mean_slide_roll_ratio": mean_slide_roll_ratio[:, 0],
        "outer_mean_slide_roll_ratio": mean_slide_roll_ratio[:, 1],
        "inner_entrainment_speed_m_s": speed_m_s[:, 0],
        "outer_entrainment_speed_m_s": speed_m_s[:, 1],
        "inner_contact_angle_deg": contact_angle_deg[:, 0],
        "outer_contact_angle_deg": contact_angle_deg[:, 1],
        "inner_max_hertz_pressure_gpa": pressure_gpa[:, 0],
        "outer_max_hertz_pressure_gpa": pressure_gpa[:, 1],
        "lambda_ratio": lambda_ratio,
        "film_in_range": film_in_range,
    }
    film_columns = _film_columns(equilibrium, tested_ranges, limiting_stress_ratio)
    return torque_of_term | equilibrium_columns | film_columns


def _film_columns(
    equilibrium: FrictionEquilibrium,
    tested_ranges: Mapping[str, FloatArray | tuple[float, float]],
    limiting_stress_ratio: FloatArray | float,
) -> dict[str, FloatArray]:
    """Columns of `torque_terms` that describe the films, and how far they are beyond the tests."""
    balance = equilibrium.balance
    film_traction = balance.traction
    load_share = equilibrium.problem.rule.load_share
    load_n = balance.contacts.load_n
    conditions = _conditions_of_contacts(equilibrium)
    pressure_gpa = conditions.max_hertz_pressure_gpa
    speed_m_s = conditions.entrainment_speed_m_s
    node_heat_w = film_traction.coefficient * film_traction.slide_roll_ratio * load_share
    node_heat_w = node_heat_w * (load_n * speed_m_s)[..., np.newaxis]
    # every law is 0 at S = 0, so that slips below the lowest tested one are interpolated
    tested_slip = (0.0, tested_ranges["slide_roll_ratio"][1])
    beyond_slip = _beyond_range_indicator(film_traction.slide_roll_ratio, tested_slip)
    beyond_pressure = _beyond_range_indicator(pressure_gpa, tested_ranges["max_hertz_pressure_gpa"])
    beyond_speed = _beyond_range_indicator(speed_m_s, tested_ranges["entrainment_speed_m_s"])
    beyond_temperature = _beyond_range_indicator(
        conditions.inlet_temperature_c, tested_ranges["inlet_temperature_c"]
    )
    # mu is the mean shear stress of a contact over its mean pressure
    is_over_limit = film_traction.coefficient @ load_share > np.reshape(
        limiting_stress_ratio, (-1, 1)
    )
    node_load_n = load_share * load_n[..., np.newaxis]
    return {
        "entrainment_speed_m_s": speed_m_s.mean(axis=1),
        "largest_slide_roll_ratio": film_traction.slide_roll_ratio.max(axis=(1, 2)),
        "mean_traction_coefficient": _weighted_mean(film_traction.coefficient, node_load_n),
        "contacts_over_stress_limit": (
            equilibrium.problem.bearing.ball_count * is_over_limit.sum(axis=1)
        ),
        "share_beyond_slip": _weighted_mean(beyond_slip, node_heat_w),
        "share_beyond_pressure": _weighted_mean(beyond_pressure, film_traction.heat_w),
        "share_beyond_speed": _weighted_mean(beyond_speed, film_traction.heat_w),
        "share_beyond_temperature": _weighted_mean(beyond_temperature, film_traction.heat_w),
    }


def _conditions_of_contacts(equilibrium: FrictionEquilibrium) -> Conditions:
    """Conditions of both contacts of each point, shape (points, 2), without the axis for nodes."""
    return equilibrium.balance.conditions.select(..., 0)


def _mean_slide_roll_ratio(equilibrium: FrictionEquilibrium) -> FloatArray:
    """Local slide-roll ratio of each contact, averaged over the ellipse by load: (points, 2).

    That in the middle of the contact would leave out spin.
    """
    load_share = equilibrium.problem.rule.load_share
    return np.asarray(equilibrium.balance.traction.slide_roll_ratio @ load_share)


def _quadrature_error(equilibrium: FrictionEquilibrium) -> FloatArray:
    """Relative error of the heat of traction by quadrature, from a finer rule: (points,)."""
    problem, balance = equilibrium.problem, equilibrium.balance
    ring_speed_rad_s = problem.points.ring_speed_rad_s
    finer_rule = problem.rule.finer()
    sliding_state = sliding_in_ellipses(
        problem.bearing,
        balance.contacts,
        balance.motion,
        ring_speed_rad_s,
        finer_rule,
        problem.bands[..., 2:],
    )
    traction_factor = problem.lubrication.traction_factor
    finer_traction = traction_in_ellipses(
        balance.contacts,
        sliding_state,
        balance.conditions,
        problem.law,
        finer_rule,
        traction_factor,
    )
    return _relative_difference(
        finer_traction.heat_w.sum(axis=1), balance.traction.heat_w.sum(axis=1)
    )


def worst_lambda_ratio(equilibrium: FrictionEquilibrium) -> tuple[FloatArray, BoolArray]:
    """Smaller lambda of the two contacts, and whether the formula of the film holds.

    Lambda is the minimum film over the combined Rq.

    Starvation reduces the film, and so does inlet heating (thermal reduction). The latter is
    calculated with the slide-roll ratio averaged over the ellipse by load.

    Returns:
        Lambda, NaN outside the range of the thermal reduction; True where both
        contacts are within that range. Both have the shape (points,).
    """
    problem = equilibrium.problem
    oil = problem.lubrication.oil_in_contacts
    conditions = _conditions_of_contacts(equilibrium)
    # the formula needs a load above 0
    load_n = np.maximum(conditions.load_n, np.finfo(float).tiny)
    conditions = replace(conditions, load_n=load_n)
    film_m = film_thickness(oil, conditions, _mean_slide_roll_ratio(equilibrium), "minimum")
    thermal_loading = oil.thermal_loading(conditions.entrainment_speed_m_s)
    is_contact_in_range = is_in_thermal_reduction_range(
        conditions.relative_pressure, thermal_loading
    )
    film_in_range = np.asarray(is_contact_in_range.all(axis=1))
    thinnest_film_m = film_m.min(axis=1) * problem.replenishment_factor()
    lambda_ratio = thinnest_film_m / problem.bearing.roughness_rq_m
    return np.where(film_in_range, lambda_ratio, np.nan), film_in_range


def _traction_heat_by_sliding(equilibrium: FrictionEquilibrium) -> dict[str, FloatArray]:
    """Heat of traction by the kind of sliding, shape (points,) each. They add up to all of it.

    t is the rolling direction, as in `ellipse`.

    - Gross: force along t times the sliding speed in the middle of the contact.
    - Differential: the rest of the heat by the force along t. The sliding speed is not that in the
      middle everywhere, because the distance from the ball's centre changes across the groove.
    - Spin: moment about the normal times the rotation about it, relative to the race.
    - Gyroscopic: moment about t times the rotation of the ball about t.
    """
    balance = equilibrium.balance
    forces, sliding_state = balance.traction, balance.sliding
    race_speed_at_orbit_m_s = (
        sliding_state.relative_race_speed_rad_s * balance.contacts.orbit_radius_m[:, np.newaxis]
    )
    middle_roll_heat_w = (
        sliding_state.relative_roll_rad_s * sliding_state.middle_height_m * forces.force_along_n
    )
    # rotation of the ball about t; the slice keeps the axis of the contacts
    gyroscopic_rotation_rad_s = balance.motion.rotation_rad_s[:, 2:]
    heats_w = {
        "gross": forces.force_along_n * race_speed_at_orbit_m_s + middle_roll_heat_w,
        "spin": -sliding_state.relative_spin_rad_s * forces.moment_about_normal_n_m,
        "differential": -sliding_state.relative_roll_rad_s * forces.moment_about_across_n_m
        - middle_roll_heat_w,
        "gyroscopic": -gyroscopic_rotation_rad_s * forces.moment_about_tangent_n_m,
    }
    return {name: heat_w.sum(axis=1) for name, heat_w in heats_w.items()}


def _beyond_range_indicator(
    values: FloatArray, tested_range: FloatArray | tuple[float, float]
) -> FloatArray:
    """1.0 where a value is outside the tested range, 0.0 inside, NaN where the range is unknown.

    The range is widened by the accuracy with which a rig holds a level.
    """
    one_per_point = (-1,) + (1,) * (values.ndim - 1)
    lowest = np.reshape(tested_range[0], one_per_point)
    highest = np.reshape(tested_range[1], one_per_point)
    # temperatures may be below 0
    is_below = values < lowest - _LEVEL_ACCURACY * np.abs(lowest)
    is_above = values > highest + _LEVEL_ACCURACY * np.abs(highest)
    indicator = (is_below | is_above).astype(float)
    return np.where(np.isfinite(lowest + highest), indicator, np.nan)


def _weighted_mean(values: FloatArray, weights: FloatArray) -> FloatArray:
    """Weighted mean of each point, shape (points,).

    Where all weights are 0 it is 0, or the value that is nearest to 0.
    """
    axes = tuple(range(1, values.ndim))
    sum_of_weights = np.broadcast_to(weights, values.shape).sum(axis=axes)
    weighted_sum = (values * weights).sum(axis=axes)
    mean = np.divide(
        weighted_sum, sum_of_weights, out=np.zeros(len(values)), where=sum_of_weights > 0
    )
    # rounding must not move a mean outside its values
    return np.clip(mean, values.min(axis=axes), values.max(axis=axes))


def _relative_difference(reference: FloatArray, other: FloatArray) -> FloatArray:
    """(reference - other)/reference; 0 where `reference` is 0."""
    return np.divide(
        reference - other, reference, out=np.zeros_like(reference), where=reference != 0
    )


_CST_PER_M2_S = 1e6
_N_M_PER_N_MM = 1e-3


def palmgren_torque_n_m(
    axial_load_n: Floats,
    speed_rpm: Floats,
    kinematic_viscosity_m2_s: Floats,
    pitch_diameter_m: float,
    contact_angle_rad: float,
    f0: float,
    f1: float,
) -> FloatArray:
    """Palmgren's torque, the sum of a speed-dependent and a load-dependent term.

        M0 = 1e-7 f0 (nu n)^(2/3) dm^3 N mm, at least that of nu n = 2000
        M1 = f1 P1 dm,   P1 = 0.9 Fa cot(alpha)

    with nu in cSt, n in 1/min, dm in mm.

    Args:
        axial_load_n: Axial load Fa.
        speed_rpm: Speed n.
        kinematic_viscosity_m2_s: Kinematic viscosity nu.
        pitch_diameter_m: Pitch diameter dm.
        contact_angle_rad: Contact angle alpha, unloaded.
        f0: Factor for lubrication and bearing type.
        f1: Factor for load and bearing type.

    Returns:
        M0 + M1, in N m; NaN without contact angle.

    Reference: A. Palmgren, Ball and Roller Bearing Engineering, 3rd ed., 1959.

    Examples:
        dm 100 mm, nu n = 8000, f0 1, no load: 1e-7 * 400 * 1e6 N mm.

        >>> print(f"{palmgren_torque_n_m(0.0, 1000.0, 8e-6, 0.1, 0.5, 1.0, 1e-3):.3f} N m")
        0.040 N m
    """
    pitch_diameter_mm = pitch_diameter_m * MM_PER_M
    viscosity_times_speed = kinematic_viscosity_m2_s * _CST_PER_M2_S * speed_rpm
    viscosity_times_speed = np.maximum(viscosity_times_speed, 2000.0)
    speed_term_n_mm = 1e-7 * f0 * viscosity_times_speed ** (2 / 3) * pitch_diameter_mm**3
    # Palmgren has another formula for bearings without contact angle
    load_factor = 0.9 / np.tan(contact_angle_rad) if contact_angle_rad > 0 else np.nan
    load_term_n_mm = f1 * load_factor * axial_load_n * pitch_diameter_mm
    return np.asarray(_N_M_PER_N_MM * (speed_term_n_mm + load_term_n_mm))


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
        axial_load_n: Axial load Fa.
        speed_rpm: Speed n.
        kinematic_viscosity_m2_s: Kinematic viscosity nu.
        pitch_diameter_m: Pitch diameter dm.

    Returns:
        Mrr + Msl, in N m.

    Validity: synthetic oil, as mineral oil has 0.05 in place of 0.04; loads above the catalogue's
    minimum, and speeds up to the limiting speed of a bearing, about 0.7 million mm rpm for
    single-row angular-contact bearings. The sliding torque increases with n^(8/3): at 2 million mm
    rpm it alone is several times any measured torque.

    Reference: SKF, Rolling bearings, general catalogue, 2018: the SKF model for calculating the
        frictional moment, angular contact ball bearings.

    Examples:
        At rest there is no film: 0.12 S1 dm^0.26 S2 Fa^(4/3) = 0.035 N m at 100 mm, 1 kN, by hand:

        >>> print(f"{skf_torque_n_m(1000.0, 0.0, 5e-6, 0.1):.3f} N m")
        0.035 N m
    """
    pitch_diameter_mm = pitch_diameter_m * MM_PER_M
    viscosity_cst = kinematic_viscosity_m2_s * _CST_PER_M2_S
    viscosity_times_speed = viscosity_cst * np.asarray(speed_rpm, dtype=float)
    inlet_heating_factor = 1 / (
        1 + 1.84e-9 * (speed_rpm * pitch_diameter_mm) ** 1.28 * viscosity_cst**0.64
    )
    rolling_centrifugal_n = 1.90e-12 * pitch_diameter_mm**4 * np.square(speed_rpm)
    rolling_load_n = rolling_centrifugal_n + 1.97 * axial_load_n
    rolling_torque_n_mm = (
        5.03e-7 * pitch_diameter_mm**1.97 * rolling_load_n**0.54 * viscosity_times_speed**0.6
    )
    sliding_centrifugal_n = 1.91e-12 * pitch_diameter_mm**4 * np.square(speed_rpm)
    sliding_load_factor = sliding_centrifugal_n ** (4 / 3) + 0.68 * np.power(axial_load_n, 4 / 3)
    boundary_weight = np.exp(-2.6e-8 * viscosity_times_speed**1.4 * pitch_diameter_mm)
    friction_coefficient = boundary_weight * 0.12 + (1 - boundary_weight) * 0.04
    sliding_torque_n_mm = (
        friction_coefficient * 1.30e-2 * pitch_diameter_mm**0.26 * sliding_load_factor
    )
    return np.asarray(
        _N_M_PER_N_MM * (inlet_heating_factor * rolling_torque_n_mm + sliding_torque_n_mm)
    )
