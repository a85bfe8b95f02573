"""Quantities that a plan of tests makes more certain: torque and cage slip of a bearing, or mu.

Each has a gradient by the constants of the law, and the conditions of the contacts that matter to
it.

Decides: at which operating points a quantity depends smoothly on the constants of a law.
"""

from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from oilfilm.base.errors import OilfilmError
from oilfilm.base.units import BoolArray, FloatArray, IndexArray
from oilfilm.bearing.geometry import Bearing
from oilfilm.fits.measured_curves import Information, form_coordinates
from oilfilm.fits.problem import Curves
from oilfilm.physics.contact import Contact
from oilfilm.settings.config import PointOfTraction
from oilfilm.torque.bearing_torque import OilInBearing
from oilfilm.torque.torque_uncertainty import law_error
from oilfilm.traction.law import CONDITIONS, to_constants

BEARING_TARGETS = ("torque", "cage_slip")
# Columns of the calculated results with the maximum pressure at both races.
_PRESSURE_COLUMNS = ["inner_max_hertz_pressure_gpa", "outer_max_hertz_pressure_gpa"]
# Columns of the calculated results with the entrainment speed at both races.
_SPEED_COLUMNS = ["inner_entrainment_speed_m_s", "outer_entrainment_speed_m_s"]
# Step of the internal constants in finite differences.
_INTERNAL_STEP = 1e-3
# Largest second difference over first difference of a smooth quantity. It is of the size of the
# step for a smooth quantity, and 1 for a jump.
_LARGEST_CURVATURE = 0.5


@dataclass(frozen=True)
class WantedQuantities:
    """Quantities whose uncertainty is to be reduced.

    Attributes:
        target: `torque`, `cage_slip` or `traction`.
        labels: Operating point of each quantity, as text.
        point_index: Index of each quantity's operating point among those that were asked for, shape
            (quantities,).
        gradients: Gradients by the free internal constants, shape (quantities, free). Those of
            torque and traction are relative to the value.
        traction_gradient: Change of each quantity per relative change of all traction, in the unit
            of `gradients`, shape (quantities,).
        form_error: Relative standard error of the law's form there, shape (quantities,).
        coordinates: ln W / 3, ln U and T of the contacts that matter, as `form_coordinates` gives
            them for the load W of the rig's contact, shape (quantities, contacts, 3).
        left_out_reasons: Operating points without such a gradient, with the reason.
    """

    target: str
    labels: list[str]
    point_index: IndexArray
    gradients: FloatArray
    traction_gradient: FloatArray
    form_error: FloatArray
    coordinates: FloatArray
    left_out_reasons: list[str]

    def keep_known_points(self, is_known: BoolArray, reason: str) -> "WantedQuantities":
        """The quantities without those of some operating points.

        Args:
            is_known: Whether an operating point that was asked for stays.
            reason: Why the others are left out.

        Raises:
            OilfilmError: None stays.
        """
        is_kept = is_known[self.point_index]
        dropped_labels = [
            label for label, kept in zip(self.labels, is_kept, strict=True) if not kept
        ]
        left_out_reasons = self.left_out_reasons + [
            f"{label}: {reason}" for label in dropped_labels
        ]
        if not is_kept.any():
            raise OilfilmError(
                f"no duty point has a known uncertainty ({left_out_reasons[0]}). "
                "Choose other duty points."
            )
        return replace(
            self,
            labels=[label for label, kept in zip(self.labels, is_kept, strict=True) if kept],
            point_index=self.point_index[is_kept],
            gradients=self.gradients[is_kept],
            traction_gradient=self.traction_gradient[is_kept],
            form_error=self.form_error[is_kept],
            coordinates=self.coordinates[is_kept],
            left_out_reasons=left_out_reasons,
        )

    @property
    def change_by_form_error(self) -> FloatArray:
        """Change of each quantity by one standard error of the law's form, shape (quantities,)."""
        return self.traction_gradient * self.form_error


def wanted_in_bearing(
    oil: OilInBearing,
    bearing: Bearing,
    duty: FloatArray,
    information: Information,
    contact: Contact,
) -> dict[str, WantedQuantities]:
    """Torque and cage slip at operating points, with their gradients by the free constants.

    The gradients include the friction equilibrium, which is solved again with each moved constant.

    Args:
        oil: The oil with its law.
        bearing: The bearing.
        duty: Rows of axial load in N, inner speed in rpm, oil temperature in degC.
        information: Information of the measured curves: the law and its constants.
        contact: Contact of the traction rig.

    Raises:
        OilfilmError: No operating point has a gradient.
    """
    moves = _moves_of_constants(information)
    calculated = _calculate_with_moves(oil, bearing, duty, information, moves)
    # one axis for the moves, one for the operating points
    moves_and_points = (len(moves), len(duty))
    values_by_target = {
        "torque": calculated["torque_n_m"].to_numpy(dtype=float).reshape(moves_and_points),
        "cage_slip": calculated["cage_slip"].to_numpy(dtype=float).reshape(moves_and_points),
    }
    converged = calculated["converged"].to_numpy(dtype=bool).reshape(moves_and_points)
    is_solved: BoolArray = np.asarray(converged.all(axis=0))
    is_smooth: BoolArray = is_solved.copy()
    for values_of_target in values_by_target.values():
        is_smooth &= _is_smooth(values_of_target)
    labels, left_out_reasons = _labels_and_left_out_reasons(duty, is_solved, is_smooth)
    if not labels:
        raise OilfilmError(
            f"{oil.name} in {bearing.name}: no duty point has a steady motion that follows the "
            f"law's constants ({left_out_reasons[0]}). Choose other duty points."
        )
    calculated_without_moves = calculated.iloc[: len(duty)]
    coordinates = _coordinates_of_contacts(calculated_without_moves, duty, contact)[is_smooth]
    form_error = law_error(
        oil.laws["stress"],
        calculated_without_moves[is_smooth],
        oil.bearing_settings.law_error_beyond,
    )
    wanted_by_target = {}
    for target in BEARING_TARGETS:
        smooth_values = values_by_target[target][:, is_smooth]
        forward, backward = np.split(smooth_values[1:], 2)
        gradient = (forward - backward).T / (2 * _INTERNAL_STEP)
        if target == "torque":
            gradient = gradient / smooth_values[0][:, np.newaxis]
        wanted_by_target[target] = WantedQuantities(
            target=target,
            labels=labels,
            point_index=np.flatnonzero(is_smooth),
            gradients=gradient[:, :-1],
            traction_gradient=gradient[:, -1],
            form_error=form_error,
            coordinates=coordinates,
            left_out_reasons=left_out_reasons,
        )
    return wanted_by_target


def _moves_of_constants(information: Information) -> FloatArray:
    """Moves of the internal constants and of the logarithm of all traction.

    Returns:
        Rows of shape (constants + 1,). The first row moves nothing. Then each row moves one free
        constant, or the traction, forward. The same rows follow with backward moves.
    """
    constant_count = len(information.internal_constants)
    moved_columns = np.append(np.flatnonzero(information.is_free), constant_count)
    forward = _INTERNAL_STEP * np.eye(constant_count + 1)[moved_columns]
    return np.concatenate([np.zeros((1, constant_count + 1)), forward, -forward])


def _calculate_with_moves(
    oil: OilInBearing,
    bearing: Bearing,
    duty: FloatArray,
    information: Information,
    moves: FloatArray,
) -> pd.DataFrame:
    """The calculated motion of the bearing, one row per move and operating point.

    Args:
        oil: The oil with its law.
        bearing: The bearing.
        duty: As in `wanted_in_bearing`.
        information: Information of the measured curves: the law and its constants.
        moves: As `_moves_of_constants` returns them.
    """
    constants = to_constants(information.law, information.internal_constants + moves[:, :-1])
    load_n, speed_rpm, temperature_c = np.tile(duty.T, len(moves))
    moved_oil = oil.with_constants(np.repeat(constants, len(duty), axis=0))
    traction_factor = np.exp(np.repeat(moves[:, -1], len(duty)))
    return moved_oil.calculate(
        bearing, load_n, speed_rpm, temperature_c, traction_factor=traction_factor
    )


def _labels_and_left_out_reasons(
    duty: FloatArray, is_solved: BoolArray, is_smooth: BoolArray
) -> tuple[list[str], list[str]]:
    """Operating points with a gradient, and those without one with the reason."""
    labels = []
    left_out_reasons = []
    for point_index, (load_n, speed_rpm, temperature_c) in enumerate(duty):
        label = f"{load_n:g} N, {speed_rpm:g} rpm, {temperature_c:g} degC"
        if is_smooth[point_index]:
            labels.append(label)
        elif is_solved[point_index]:
            left_out_reasons.append(f"{label}: it jumps with the constants")
        else:
            left_out_reasons.append(f"{label}: no equilibrium")
    return labels, left_out_reasons


def _coordinates_of_contacts(
    calculated: pd.DataFrame, duty: FloatArray, contact: Contact
) -> FloatArray:
    """Conditions of both contacts at each operating point, shape (operating points, 2, 3)."""
    # the load at which the contact of the rig has the pressure of the bearing's
    rig_load_n = contact.load_n(calculated[_PRESSURE_COLUMNS].to_numpy())
    temperature_c = duty[:, [2]]
    return form_coordinates(
        rig_load_n,
        calculated[_SPEED_COLUMNS].to_numpy(),
        np.broadcast_to(temperature_c, rig_load_n.shape),
    )


def _is_smooth(values: FloatArray) -> BoolArray:
    """Whether forward and backward differences agree, over all constants together.

    Args:
        values: A quantity by moves (`_moves_of_constants`) and operating points.
    """
    forward, backward = np.split(values[1:], 2)
    first_difference = np.linalg.norm(forward - backward, axis=0) / 2
    second_difference = np.linalg.norm(forward + backward - 2 * values[0], axis=0)
    # rounding of the equilibrium, for a quantity that does not depend on the law
    rounding = 1e-9 * np.maximum(np.abs(values[0]), 1e-3)
    return np.asarray(second_difference <= _LARGEST_CURVATURE * first_difference + rounding)


def wanted_traction(
    points: list[PointOfTraction], information: Information, contact: Contact
) -> WantedQuantities:
    """mu at some conditions, with its relative gradients by the free constants.

    Args:
        points: The conditions and slips.
        information: Information of the measured curves: the law and its constants.
        contact: Contact of the traction rig.

    Raises:
        OilfilmError: The law depends on a condition that the points do not have.
    """
    points_table = pd.DataFrame([point.model_dump() for point in points])
    law = information.law
    missing = sorted(set(law.conditions) - set(points_table))
    if missing:
        raise OilfilmError(
            f"plan.traction_at: the law {law.name} needs {', '.join(missing)}; plan for torque or "
            "cage slip."
        )
    slip = points_table["slide_roll_ratio"].to_numpy(dtype=float)
    conditions = points_table[list(law.conditions)].to_numpy(dtype=float)
    # the law takes no load here, so that any load will do
    curves = Curves(conditions, np.ones(len(slip)), np.arange(len(slip)), slip)
    observations = curves.observations(law)
    mu = law.traction(information.internal_constants, observations)
    mu_slopes = law.jacobian(information.internal_constants, observations)[:, information.is_free]
    labels = [
        f"{point.max_hertz_pressure_gpa:g} GPa, {point.entrainment_speed_m_s:g} m/s, "
        f"{point.inlet_temperature_c:g} degC, S {point.slide_roll_ratio:g}"
        for point in points
    ]
    pressure_gpa, speed_m_s, temperature_c = points_table[list(CONDITIONS)].to_numpy(dtype=float).T
    coordinates = form_coordinates(contact.load_n(pressure_gpa), speed_m_s, temperature_c)
    return WantedQuantities(
        target="traction",
        labels=labels,
        point_index=np.arange(len(mu)),
        gradients=mu_slopes / mu[:, np.newaxis],
        traction_gradient=np.ones(len(mu)),
        form_error=information.form_error_at(conditions, slip),
        coordinates=coordinates[:, np.newaxis],
        left_out_reasons=[],
    )
