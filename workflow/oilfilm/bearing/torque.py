"""Friction torque of a bearing, term by term, from the balance of all that acts on its balls.

Decides: the terms of a bearing's friction torque.
"""

from collections.abc import Mapping

import numpy as np

from oilfilm.bearing.ellipse import TractionLaw, grid, sliding, traction
from oilfilm.bearing.friction import (
    HEATS,
    QUADRATURE,
    Balance,
    friction_equilibrium,
    widest_contact,
)
from oilfilm.bearing.geometry import Bearing
from oilfilm.bearing.quasistatic import Contacts, Motion, OperatingPoints
from oilfilm.bearing.resistance import Lubrication
from oilfilm.physics.contact import ellipticity
from oilfilm.physics.film import film_thickness, within_thermal_reduction
from oilfilm.units import BoolArray, FloatArray


def torque_terms(
    bearing: Bearing,
    points: OperatingPoints,
    lubrication: Lubrication,
    law: TractionLaw,
    tested: Mapping[str, tuple[float, float]],
    quadrature: tuple[int, int] = QUADRATURE,
) -> dict[str, FloatArray]:
    """Torque on the inner ring with its terms, motion and residuals, an array a column.

    A term is its heat over the inner ring's speed: with the outer ring at rest they add up to the
    moment that turns the inner ring. On the outer ring balls and cage exert less, by what the oil
    between them takes; a sensor on a ring and its whole housing has that as well.

    Args:
        bearing: The bearing.
        points: Loads and speeds; the outer ring at rest.
        lubrication: The oil at each point.
        law: The traction law.
        tested: Lowest and highest tested level of pressure, speed and slip; NaN where unknown.
        quadrature: Nodes of the ellipse, across and along the rolling direction.
    """
    equilibrium = friction_equilibrium(bearing, points, lubrication, law, quadrature)
    balance, balls = equilibrium.balance, equilibrium.balls_per_row
    speed = np.where(points.inner_speed_rad_s == 0, np.inf, points.inner_speed_rad_s)
    heats = {name: balance.heat_w[..., part] for part, name in enumerate(HEATS)}
    heats |= _heat_by_sliding(balance, _ring_speeds(points))
    terms = {f"{name}_torque_n_m": balls * heat.sum(axis=1) / speed for name, heat in heats.items()}
    torque = inner_ring_torque_n_m(balance, balls)
    solution = equilibrium.solution
    rule = grid(2 * quadrature[0], 2 * quadrature[1])
    finer_slip = sliding(bearing, balance.contacts, balance.motion, _ring_speeds(points), rule)
    finer = traction(balance.contacts, finer_slip, balance.at, law, rule).heat_w.sum(axis=(1, 2))
    angle = np.degrees(balance.contacts.contact_angle_rad)
    slip = cage_slip(bearing, points, balance.contacts, balance.motion)
    pressure = balance.at.max_hertz_pressure_gpa
    lambda_ratio, film_in_range = _film(bearing, balance, lubrication, grid(*quadrature).share)
    return {
        **terms,
        "torque_n_m": torque,
        "outer_ring_torque_n_m": balls * balance.ring_moment_n_m[..., 1].sum(axis=1),
        "energy_error": _relative(
            torque * points.inner_speed_rad_s, balls * balance.heat_w.sum(axis=(1, 2))
        ),
        "quadrature_error": _relative(finer, balance.traction.heat_w.sum(axis=(1, 2))),
        "residual": solution.residual,
        "converged": solution.converged,
        "widest_contact": widest_contact(bearing, balance.contacts),
        "cage_slip": slip.mean(axis=1),
        "inner_slide_roll_ratio": balance.sliding.middle_slide_roll_ratio[..., 0].mean(axis=1),
        "inner_contact_angle_deg": angle[..., 0].mean(axis=1),
        "outer_contact_angle_deg": angle[..., 1].mean(axis=1),
        "inner_max_hertz_pressure_gpa": pressure[..., 0, 0].max(axis=1),
        "outer_max_hertz_pressure_gpa": pressure[..., 1, 0].max(axis=1),
        "lambda_ratio": lambda_ratio,
        "film_in_range": film_in_range,
        **_traction_summary(balance, tested, grid(*quadrature).share),
    }


def inner_ring_torque_n_m(balance: Balance, balls_per_row: float) -> FloatArray:
    """Moment that turns the inner ring, shape (points,); see `FrictionEquilibrium` for the rows."""
    return np.asarray(-balls_per_row * balance.ring_moment_n_m[..., 0].sum(axis=1))


def _traction_summary(
    balance: Balance, tested: Mapping[str, tuple[float, float]], share: FloatArray
) -> dict[str, FloatArray]:
    """Speed, slip and mu of each point, and the shares of the heat outside the tested ranges."""
    at, film, load = balance.at, balance.traction, balance.contacts.load_n
    speed = at.entrainment_speed_m_s[..., 0]
    local_heat = film.coefficient * film.slide_roll_ratio * share
    beyond_slip = _beyond(film.slide_roll_ratio, (0.0, tested["slide_roll_ratio"][1]))
    pressure = at.max_hertz_pressure_gpa[..., 0]
    beyond_pressure = _beyond(pressure, tested["max_hertz_pressure_gpa"])
    beyond_speed = _beyond(speed, tested["entrainment_speed_m_s"])
    return {
        "entrainment_speed_m_s": at.entrainment_speed_m_s.mean(axis=(1, 2, 3)),
        "largest_slide_roll_ratio": film.slide_roll_ratio.max(axis=(1, 2, 3)),
        "mean_traction_coefficient": _mean(film.coefficient, share * load[..., np.newaxis]),
        "share_beyond_slip": _mean(beyond_slip, local_heat * (load * speed)[..., np.newaxis]),
        "share_beyond_pressure": _mean(beyond_pressure, film.heat_w),
        "share_beyond_speed": _mean(beyond_speed, film.heat_w),
    }


def _film(
    bearing: Bearing, balance: Balance, lubrication: Lubrication, share: FloatArray
) -> tuple[FloatArray, BoolArray]:
    """Minimum film over combined Rq in the worst contact, and whether the formula holds in all.

    The film is reduced by inlet heating at the contact's slide-roll ratio, averaged over the
    ellipse with the load as weight. The ratio in the contact's middle would leave out spin, which
    is sliding everywhere else. Beyond the range of the reduction there is no value.
    """
    contacts, radius_x = balance.contacts, balance.at.radius_x_m[..., 0]
    speed = balance.at.entrainment_speed_m_s[..., 0]
    film = film_thickness(
        lubrication.of_contacts,
        thickness="minimum",
        load_n=np.maximum(contacts.load_n, np.finfo(float).tiny),
        max_hertz_pressure_pa=contacts.max_hertz_pressure_pa,
        entrainment_speed_m_s=speed,
        slide_roll_ratio=balance.traction.slide_roll_ratio @ share,
        radius_x_m=radius_x,
        reduced_modulus_pa=bearing.reduced_modulus_pa,
        ellipticity=ellipticity(radius_x, bearing.radius_y_m),
    )
    within = within_thermal_reduction(
        max_hertz_pressure_pa=contacts.max_hertz_pressure_pa,
        reduced_modulus_pa=bearing.reduced_modulus_pa,
        thermal_loading=lubrication.of_contacts.thermal_loading(speed),
    )
    in_range = np.asarray(within.all(axis=(1, 2)))
    return np.where(in_range, film.min(axis=(1, 2)) / bearing.roughness_rq_m, np.nan), in_range


def cage_slip(
    bearing: Bearing, points: OperatingPoints, contacts: Contacts, motion: Motion
) -> FloatArray:
    """By how much the cage lags behind balls that roll on both races, relative: (points, balls).

    The balls' axis is taken as it is; rolling is no sliding in the middle of either contact.
    """
    n_x, n_r = contacts.normal[..., 0, :], contacts.normal[..., 1, :]
    axis = np.abs(
        motion.spin_rad_s[..., 1, np.newaxis] * n_x - motion.spin_rad_s[..., 0, np.newaxis] * n_r
    )
    race = contacts.orbit_radius_m[..., np.newaxis] + n_r * bearing.ball_diameter_m / 2
    reach = race / np.maximum(axis / np.maximum(axis.max(axis=-1, keepdims=True), 1e-300), 1e-3)
    inner = points.inner_speed_rad_s[:, np.newaxis]
    outer = points.outer_speed_rad_s[:, np.newaxis]
    rolling = (inner * reach[..., 0] + outer * reach[..., 1]) / reach.sum(axis=-1)
    return _relative(rolling, motion.orbit_speed_rad_s)


def _ring_speeds(points: OperatingPoints) -> FloatArray:
    """Speed of inner and outer ring, shape (points, 1, 2)."""
    speeds = np.stack([points.inner_speed_rad_s, points.outer_speed_rad_s], axis=-1)
    return speeds[:, np.newaxis]


def _heat_by_sliding(balance: Balance, ring_speed_rad_s: FloatArray) -> dict[str, FloatArray]:
    """Heat of traction split by the kind of sliding, (points, balls) each; they add up to it."""
    contacts, motion, slip = balance.contacts, balance.motion, balance.sliding
    relative = ring_speed_rad_s - motion.orbit_speed_rad_s[..., np.newaxis]
    n_x, n_r = contacts.normal[..., 0, :], contacts.normal[..., 1, :]
    w_x, w_r, w_t = (motion.spin_rad_s[..., part, np.newaxis] for part in range(3))
    spin = (w_x * n_x + w_r * n_r - relative * n_x)[..., np.newaxis]
    f_across, f_along = balance.traction.node_force_n
    middle = slip.middle_m[..., np.newaxis]
    turning = (relative * n_r + w_r * n_x - w_x * n_r)[..., np.newaxis]
    orbit = (relative * contacts.orbit_radius_m[..., np.newaxis])[..., np.newaxis]
    heats = {
        "gross": f_along * (orbit + turning * middle),
        "spin": f_across * spin * slip.along_m - f_along * spin * slip.across_m,
        "differential": f_along * turning * (slip.height_m - middle),
        "gyroscopic": -f_across * w_t[..., np.newaxis] * slip.height_m,
    }
    return {name: heat.sum(axis=(-1, -2)) for name, heat in heats.items()}


def _beyond(values: FloatArray, tested: tuple[float, float]) -> FloatArray:
    # a thousandth of leeway, for levels that a rig holds only so well
    low, high = tested
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
