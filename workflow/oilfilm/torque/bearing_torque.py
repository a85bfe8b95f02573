"""A fitted traction law in bearings: tables of torque, inversion, cage slip and size effect.

Inversion finds the traction coefficient that gives the measured torque of a bearing.
"""

from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
import pandas as pd
import scipy

from oilfilm import tables
from oilfilm.base.ties import first_smallest, reaches
from oilfilm.base.units import MM_PER_M, RAD_S_PER_RPM, BoolArray, FloatArray, IndexArray
from oilfilm.bearing.equilibria import NearbyEquilibria, equilibria, friction_equilibrium
from oilfilm.bearing.friction import FrictionEquilibrium, FrictionProblem
from oilfilm.bearing.geometry import Bearing
from oilfilm.bearing.inputs import InputValues
from oilfilm.bearing.quasistatic import OperatingPoints
from oilfilm.bearing.resistance import Lubrication, momentum_torque_n_m
from oilfilm.bearing.torque import palmgren_torque_n_m, skf_torque_n_m, torque_terms
from oilfilm.fits.fit import laws_of_oil
from oilfilm.fits.fitted import FittedLaw, read_surface
from oilfilm.fits.measured_surface import OilSurface
from oilfilm.physics.contact import Contact, Floats
from oilfilm.physics.oils import Oil
from oilfilm.settings.base import required_value
from oilfilm.settings.config import BearingSettings
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.torque.best_oil import best_shares
from oilfilm.torque.load_variables import LOAD_VARIABLES, LawInBearing, join_laws
from oilfilm.torque.torque_uncertainty import (
    RANDOM_FACTOR_TERMS,
    OilAndLaw,
    RandomDraws,
    add_uncertainty,
    has_enough_refits,
    random_factor,
)
from oilfilm.traction import BEARING_LAW_NAMES

_LOAD_SPEED_TEMPERATURE = ["axial_load_n", "inner_speed_rpm", "inlet_temperature_c"]
# Quantities whose tested range is compared with the conditions in a bearing.
_TESTED_QUANTITIES = (
    "max_hertz_pressure_gpa",
    "entrainment_speed_m_s",
    "inlet_temperature_c",
    "slide_roll_ratio",
)
# Largest residual in tables, relative to the load of a ball; null above.
_LARGEST_RESIDUAL = 1e9
# Factors on all traction, between which the inversion interpolates; the middle one is 1.
_TRACTION_FACTORS = np.geomspace(1 / 8, 8, 25)
# Half-width of the 95 % interval of a normal distribution, in standard uncertainties.
_STANDARD_UNCERTAINTIES_PER_SIDE = 1.96
# Number of slices of equal probability into which a distribution is divided.
_NORMAL_SLICES = 1000
# Powers of the bearing's size with which its uncertain inputs grow.
_SIZE_POWERS = {"shaft_interference_m": 1, "housing_interference_m": 1, "feed_flow_m3_s": 2}


@dataclass(frozen=True)
class OilInBearing:
    """One oil in bearings: its properties and its fitted laws.

    Attributes:
        name: Name in config/oils.
        properties: Its properties.
        laws: Laws by load variable. The keys `LOAD_VARIABLES` have the campaign's law, evaluated
            with maximum Hertz pressure (`stress`), load or dimensionless load. Further keys are
            names of laws on load.
        tested_ranges: Lowest and highest tested level of pressure, speed, temperature and slip, by
            the name of the quantity; NaN where unknown.
        bearing_settings: Section `bearing` of the settings.
    """

    name: str
    properties: Oil
    laws: Mapping[str, LawInBearing]
    tested_ranges: Mapping[str, tuple[float, float]]
    bearing_settings: BearingSettings

    def with_constants(self, constants: FloatArray) -> "OilInBearing":
        """The oil with other constants of the campaign's law, with each of `LOAD_VARIABLES`.

        Args:
            constants: Constants in the law's order, shape (constants,), or one row for each
                operating point of the next `calculate`, shape (points, constants).
        """
        laws = {name: self.laws[name].with_constants(constants) for name in LOAD_VARIABLES}
        return replace(self, laws=laws)

    def calculate(
        self,
        bearing: Bearing,
        axial_load_n: Floats,
        inner_speed_rpm: Floats,
        inlet_temperature_c: Floats,
        load_variable: str = "stress",
        traction_factor: Floats = 1.0,
    ) -> pd.DataFrame:
        """Friction at operating points, one row per point; see `FrictionCases.calculate`.

        Args:
            bearing: The bearing.
            axial_load_n: Axial load. It broadcasts against the three others.
            inner_speed_rpm: Speed of the inner ring.
            inlet_temperature_c: Temperature of the oil.
            load_variable: Key of `laws`; `stress` is maximum Hertz pressure.
            traction_factor: Factor on all traction. It broadcasts like the load.
        """
        load_n, speed_rpm, temperature_c, traction_factors = np.broadcast_arrays(
            np.atleast_1d(axial_load_n), inner_speed_rpm, inlet_temperature_c, traction_factor
        )
        points = pd.DataFrame(
            {
                "axial_load_n": load_n,
                "inner_speed_rpm": speed_rpm,
                "inlet_temperature_c": temperature_c,
                "traction_factor": traction_factors,
            }
        )
        return FrictionCases(bearing, [CaseGroup(self, load_variable, points)]).calculate()


class CaseGroup(NamedTuple):
    """Operating points that have the same oil and the same of its laws.

    Attributes:
        oil: The oil.
        load_variable: Key of its laws (`OilInBearing.laws`).
        points: Operating points with the columns axial_load_n, inner_speed_rpm,
            inlet_temperature_c and any other.
    """

    oil: OilInBearing
    load_variable: str
    points: pd.DataFrame


class FrictionCases:
    """Operating points of one bearing, each with an oil and a load variable, solved together.

    Attributes:
        oil_of_group: The oil of each group of points, in the order of the groups.
        law_of_group: The law of each group of points, in the same order.
        points: One row per point: `oil`, `bearing`, `load_variable`, and the columns of the groups.
            The column `traction_factor`, if any, is a factor on all traction.
        problem: The friction problem of these points.
    """

    def __init__(
        self, bearing: Bearing, groups: Sequence[CaseGroup], inputs: InputValues | None = None
    ) -> None:
        """Join the points of all groups.

        Args:
            bearing: The bearing.
            groups: Operating points, each group with its oil and law.
            inputs: Uncertain inputs of each point; by default the values of bearing and settings.
        """
        self.oil_of_group = [oil for oil, _, _ in groups]
        self.law_of_group = [oil.laws[load_variable] for oil, load_variable, _ in groups]
        self._point_counts = [len(points) for _, _, points in groups]
        tables_of_groups = []
        lubrications = []
        for oil, load_variable, points in groups:
            tables_of_groups.append(
                points.assign(oil=oil.name, bearing=bearing.name, load_variable=load_variable)
            )
            lubrications.append(
                Lubrication.flooded(
                    oil.properties,
                    points["inlet_temperature_c"].to_numpy(dtype=float),
                    oil.bearing_settings.drag_coefficient,
                    oil.bearing_settings.oil_volume_fraction,
                )
            )
        self.points = pd.concat(tables_of_groups, ignore_index=True)
        lubrication = Lubrication.joined(lubrications)
        if "traction_factor" in self.points:
            traction_factor = self.points["traction_factor"].to_numpy()
            lubrication = lubrication.with_traction_factor(traction_factor)
        law = join_laws(self.law_of_group, self._point_counts)
        load_n = self.points["axial_load_n"].to_numpy(dtype=float)
        speed_rpm = self.points["inner_speed_rpm"].to_numpy(dtype=float)
        operating_points = OperatingPoints.from_load_and_speed(load_n, speed_rpm * RAD_S_PER_RPM)
        if inputs is None:
            inputs = InputValues.joined(
                [
                    InputValues.nominal(
                        {**bearing.uncertain_inputs, **oil.bearing_settings.uncertain_inputs()},
                        len(points),
                    )
                    for oil, _, points in groups
                ]
            )
        problem = FrictionProblem(bearing, operating_points, lubrication, law)
        self.problem = problem.with_inputs(inputs)

    def calculate(self, nearby_equilibria: NearbyEquilibria | None = None) -> pd.DataFrame:
        """Friction at every point, with the columns of `torque_terms`; null without equilibrium.

        Args:
            nearby_equilibria: Equilibria with other constants; see `friction_equilibrium`.
        """
        return self._result_table(friction_equilibrium(self.problem, nearby_equilibria))

    def _result_table(self, equilibrium: FrictionEquilibrium) -> pd.DataFrame:
        """Columns of `torque_terms`, the verdict on pressure, and the columns of the points."""
        tested_ranges = {}
        for quantity in _TESTED_QUANTITIES:
            range_of_point = self._repeat_for_points(
                [oil.tested_ranges[quantity] for oil in self.oil_of_group]
            )
            # first row: lowest level of each point; second row: highest
            tested_ranges[quantity] = range_of_point.T
        stress_ratios = [oil.properties.limiting_stress_ratio for oil in self.oil_of_group]
        calculated = _null_without_equilibrium(
            torque_terms(equilibrium, tested_ranges, self._repeat_for_points(stress_ratios))
        )
        calculated["below_law_floor"] = _flag_or_null(
            self._is_below_law_floor(equilibrium), calculated["converged"].to_numpy(dtype=bool)
        )
        long_term_limit_gpa, peak_limit_gpa = self._settings.pressure_limits_gpa
        pressures = ["inner_max_hertz_pressure_gpa", "outer_max_hertz_pressure_gpa"]
        larger_pressure_gpa = calculated[pressures].max(axis=1)
        calculated["pressure_verdict"] = np.select(
            [
                np.isnan(larger_pressure_gpa),
                larger_pressure_gpa > peak_limit_gpa,
                larger_pressure_gpa > long_term_limit_gpa,
            ],
            ["not known", "above peak", "above long-term"],
            "within",
        )
        return calculated.join(self.points[self.points.columns.difference(calculated.columns)])

    def _is_below_law_floor(self, equilibrium: FrictionEquilibrium) -> BoolArray:
        """Points at which a law is evaluated at its smallest level of a condition, (points,)."""
        is_below = np.empty(len(self.points), dtype=bool)
        # without the axis for the nodes of a contact
        conditions = equilibrium.balance.conditions.select(..., 0)
        group_of_point = self._repeat_for_points(np.arange(len(self.law_of_group)))
        for group_index, law in enumerate(self.law_of_group):
            is_of_group = group_of_point == group_index
            is_below_in_contacts = law.is_below_smallest_level(conditions.select(is_of_group))
            is_below[is_of_group] = is_below_in_contacts.any(axis=1)
        return is_below

    @property
    def _settings(self) -> BearingSettings:
        """Section `bearing` of the settings, which is the same for all oils."""
        return self.oil_of_group[0].bearing_settings

    def _repeat_for_points(self, values_of_groups: npt.ArrayLike) -> npt.NDArray[Any]:
        """Repeat the value of each group for each of its points: shape (points, ...)."""
        return np.repeat(values_of_groups, self._point_counts, axis=0)

    def calculate_with_uncertainty(self, seed: int) -> tuple[pd.DataFrame, FloatArray, RandomDraws]:
        """Friction at every point with its uncertainty.

        Args:
            seed: Seed of the configuration.

        Returns:
            The table of `add_uncertainty`, with further columns: the number of `equilibria`,
            whether the point is `bistable`, and `other_cage_slip` and `other_torque_n_m` of the
            slowest cage where there are several equilibria.
            The draws of torque, cage slip and lambda (`RandomDraws.calculate_results`), shape
            (3, draws, points).
            The draws themselves, which give the shares of variance.
        """
        all_equilibria = equilibria(self.problem)
        calculated = self._result_table(all_equilibria.fastest)
        oils_and_laws = []
        for oil, law in zip(self.oil_of_group, self.law_of_group, strict=True):
            oils_and_laws.append(OilAndLaw(oil.name, oil.properties, law))
        group_of_point = self._repeat_for_points(np.arange(len(oils_and_laws)))
        settings = self._settings
        random_draws = RandomDraws(
            all_equilibria.fastest, oils_and_laws, group_of_point, calculated, settings, seed
        )
        draws = random_draws.calculate_results()
        inner_speed_rad_s = self.problem.points.ring_speed_rad_s[:, 0]
        has_refits = np.array([has_enough_refits(law.fitted) for law in self.law_of_group])
        was_drawn = has_refits[group_of_point] & calculated["converged"].to_numpy(dtype=bool)
        assessed = add_uncertainty(
            calculated, draws, was_drawn, inner_speed_rad_s, settings.uncertainty
        )
        # motions whose contacts would be wider than the balls are no equilibria
        motion_count = np.where(calculated["converged"], all_equilibria.count, 0)
        has_several = motion_count > 1
        # an incomplete search may find several equilibria, but not that there is only one
        several_is_known = (motion_count > 0) & (all_equilibria.is_complete | has_several)
        several_or_null = pd.Series(has_several, assessed.index, dtype="boolean").where(
            several_is_known
        )
        # true if either is true, false if both are false, else null
        assessed["bistable"] = several_or_null | assessed["draws_split"]
        assessed["equilibria"] = motion_count
        assessed["other_cage_slip"] = np.where(
            has_several, all_equilibria.slowest.cage_slip(), np.nan
        )
        assessed["other_torque_n_m"] = np.where(
            has_several, all_equilibria.slowest.torque_n_m(), np.nan
        )
        return assessed, draws, random_draws


def oils_in_bearings(
    coefficients: pd.DataFrame,
    quality: pd.DataFrame,
    settings: Settings,
    refits: pd.DataFrame | None = None,
    surfaces: pd.DataFrame | None = None,
    surface_reader: Callable[[str], OilSurface | None] | None = None,
) -> list[OilInBearing]:
    """The oils of the campaign that can be calculated in a bearing, each with its laws.

    An oil needs known properties and a law that follows all conditions. The list is empty if the
    contact of the traction rigs is not known or not the same.

    Args:
        coefficients: Table of coefficients. Beside the configured law, laws on load are evaluated.
        quality: Table of fit quality.
        settings: The settings.
        refits: Table of refits. Without it the results have no uncertainty.
        surfaces: Table of surfaces, with the error of a run. Without it runs have none.
        surface_reader: Reads the surface of an oil's measured mu. Without it the law has the error
            that is stated for conditions beyond the tests (`bearing.law_error_beyond`).
    """
    # a law on load holds for the ball of its rig: all rigs must have the same ball
    rig_contact = settings.common_contact()
    if rig_contact is None:
        return []
    refits_by_oil_and_law: dict[Any, pd.DataFrame] = {}
    if refits is not None:
        # grouped once, because the table is long
        refits_by_oil_and_law = dict(list(refits.groupby(["oil", "law"])))
    quality_row_of_oil = {row["oil"]: row for row in tables.rows(quality[quality["configured"]])}
    oils = []
    for oil_name in settings.oils:
        oil_properties = settings.properties_of(oil_name)
        if oil_properties is None or oil_name not in quality_row_of_oil:
            continue
        quality_row = quality_row_of_oil[oil_name]
        available_laws = laws_of_oil(oil_name, settings)
        fitted_law_names = set(coefficients.loc[coefficients["oil"] == oil_name, "law"])
        law_name_by_variable = _law_name_by_variable(
            quality_row["law"], fitted_law_names & set(available_laws)
        )
        fitted_by_law_name = {}
        for law_name in set(law_name_by_variable.values()):
            fitted = FittedLaw.from_tables(
                coefficients,
                oil_name,
                refits_by_oil_and_law.get((oil_name, law_name)),
                quality,
                available_laws[law_name],
                surfaces=surfaces,
            )
            if surface_reader is not None:
                fitted = replace(fitted, read_surface=partial(surface_reader, oil_name))
            fitted_by_law_name[law_name] = fitted
        laws = _laws_in_bearing(
            fitted_by_law_name, law_name_by_variable, rig_contact, settings.bearing
        )
        # the campaign's law follows all conditions
        if "stress" in laws:
            tested_ranges = {}
            for quantity in _TESTED_QUANTITIES:
                lowest = float(quality_row[f"tested_min_{quantity}"])
                highest = float(quality_row[f"tested_max_{quantity}"])
                tested_ranges[quantity] = (lowest, highest)
            oils.append(
                OilInBearing(oil_name, oil_properties, laws, tested_ranges, settings.bearing)
            )
    return oils


def oils_with_uncertainty(results: CampaignTables, settings: Settings) -> list[OilInBearing]:
    """The oils of a finished campaign with everything that their uncertainty is made of.

    Args:
        results: Tables coefficients, fit_quality, refits, surfaces, surface_sizes and points.
        settings: The settings.
    """
    return oils_in_bearings(
        results.coefficients,
        results.fit_quality,
        settings,
        results.refits,
        results.surfaces,
        # several laws of an oil have one surface
        cache(partial(read_surface, results)),
    )


def _law_name_by_variable(
    configured_law_name: str, fitted_law_names: Collection[str]
) -> dict[str, str]:
    """Name of the law for each key of `OilInBearing.laws`.

    Args:
        configured_law_name: The campaign's law.
        fitted_law_names: Names of the laws that have a fit and are available.
    """
    law_name_by_variable = dict.fromkeys(LOAD_VARIABLES, configured_law_name)
    for law_name in BEARING_LAW_NAMES:
        if law_name in fitted_law_names:
            law_name_by_variable[law_name] = law_name
    return law_name_by_variable


def _laws_in_bearing(
    fitted_by_law_name: Mapping[str, FittedLaw],
    law_name_by_variable: Mapping[str, str],
    rig_contact: Contact,
    settings: BearingSettings,
) -> dict[str, LawInBearing]:
    """Laws by load variable, without those that do not follow all conditions of a bearing.

    Args:
        fitted_by_law_name: Fitted laws by their names.
        law_name_by_variable: Name of the law for each load variable.
        rig_contact: Contact of the traction rig.
        settings: Section `bearing` of the settings.
    """
    # no law is evaluated below these levels
    smallest_level_of_condition = settings.law_floor.model_dump()
    law_by_variable = {}
    for load_variable, law_name in law_name_by_variable.items():
        coefficients = fitted_by_law_name[law_name].coefficients
        if coefficients.group_has_exponent.all() and not np.isnan(coefficients.constants).any():
            law_by_variable[load_variable] = LawInBearing.from_fit(
                fitted_by_law_name[law_name],
                load_variable,
                rig_contact,
                smallest_level_of_condition,
            )
    return law_by_variable


def _null_without_equilibrium(terms: Mapping[str, FloatArray]) -> pd.DataFrame:
    """A table of terms that are null without an equilibrium, with the reason."""
    converged = terms["converged"].astype(bool)
    residual = terms["residual"]
    columns = {name: np.where(converged, values, np.nan) for name, values in terms.items()}
    # the contact is as wide as the ball
    is_too_wide = terms["widest_contact"] >= 1
    reason = np.select(
        [converged, is_too_wide], ["", "contacts too wide"], default="out of balance"
    )
    return pd.DataFrame(columns).assign(
        converged=converged,
        held_by_band=_flag_or_null(terms["held_by_band"], converged),
        outside_law=_flag_or_null(terms["outside_law"], converged),
        film_in_range=_flag_or_null(terms["film_in_range"], converged),
        residual=np.where(residual < _LARGEST_RESIDUAL, residual, np.nan),
        no_equilibrium=reason.astype(object),
        widest_contact=terms["widest_contact"],
    )


def _flag_or_null(flag: FloatArray | BoolArray, is_known: BoolArray) -> "pd.Series[bool]":
    """A flag that is null where it is not known."""
    return pd.Series(flag.astype(bool), dtype="boolean").where(is_known)


def torque_table(
    plateaus: pd.DataFrame, oils: Sequence[OilInBearing], settings: Settings
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Measured and calculated torque with every load variable, and traction by inversion.

    Args:
        plateaus: Table `torque_runs`, one row per plateau. Refused ones are left out.
        oils: Oils with their laws.
        settings: The settings.

    Returns:
        The tables `torque` and `torque_inversion`.
    """
    columns = ["run_id", "first_row", "oil", "axial_load_n", "inner_speed_rpm"]
    measured_plateaus = plateaus.loc[plateaus["accepted"], columns].assign(
        inlet_temperature_c=plateaus["oil_temperature_c"],
        measured_torque_n_m=plateaus["torque_n_m"],
        measured_torque_n_m_se=plateaus["torque_n_m_se"],
    )
    measured_oil_names = set(measured_plateaus["oil"])
    measured_oils = [oil for oil in oils if oil.name in measured_oil_names]
    if not measured_oils:
        return tables.empty_table("torque"), tables.empty_table("torque_inversion")
    groups: list[CaseGroup] = []
    for oil in measured_oils:
        plateaus_with_oil = measured_plateaus[measured_plateaus["oil"] == oil.name]
        groups += [CaseGroup(oil, load_variable, plateaus_with_oil) for load_variable in oil.laws]
    bearing = settings.tested_bearing()
    calculated, _, _ = FrictionCases(bearing, groups).calculate_with_uncertainty(settings.seed)
    compared = _compare_with_measured(bearing, calculated, measured_oils, settings)
    inversion = _inversion_table(bearing, measured_oils, compared, settings)
    return stack_tables([compared], "torque"), stack_tables([inversion], "torque_inversion")


def _compare_with_measured(
    bearing: Bearing, calculated: pd.DataFrame, oils: Sequence[OilInBearing], settings: Settings
) -> pd.DataFrame:
    """Calculated torque compared with the measured torque, and the estimates of catalogues.

    The calculated torque has the uncertainty of the side of its interval on which the measured one
    is, because the two sides are not alike. `compatibility` is the difference over its
    standard uncertainty. It is null where the flow of the feed oil is not known, because the
    calculated torque is then one without the momentum of that oil.
    """
    measured_uncertainty_n_m = np.hypot(
        calculated["measured_torque_n_m_se"].to_numpy(),
        _calibration_uncertainty_n_m(calculated, settings),
    )
    torque_n_m = calculated["torque_n_m"]
    difference_n_m = torque_n_m - calculated["measured_torque_n_m"]
    below_n_m = torque_n_m - calculated["torque_n_m_lower"]
    above_n_m = calculated["torque_n_m_upper"] - torque_n_m
    # a torque beyond an end of its own interval has nothing on that side
    interval_side_n_m = below_n_m.where(difference_n_m > 0, above_n_m).clip(lower=0)
    compatibility = difference_n_m / np.hypot(
        interval_side_n_m / _STANDARD_UNCERTAINTIES_PER_SIDE, measured_uncertainty_n_m
    )
    compatibility = compatibility.where(calculated["momentum_torque_n_m"].notna())
    is_compatible = np.abs(compatibility) <= settings.bearing.compatible_uncertainties
    verdict = np.select(
        [np.isnan(compatibility), is_compatible], ["not known", "compatible"], "not compatible"
    )
    load_n, speed_rpm, temperature_c = calculated[_LOAD_SPEED_TEMPERATURE].to_numpy().T
    kinematic_viscosity_m2_s = np.empty(len(calculated))
    for oil in oils:
        is_of_oil = calculated["oil"].to_numpy() == oil.name
        kinematic_viscosity_m2_s[is_of_oil] = oil.properties.kinematic_viscosity_m2_s(
            temperature_c[is_of_oil]
        )
    pitch_diameter_m = bearing.pitch_diameter_m
    palmgren = settings.bearing.palmgren
    return calculated.assign(
        measured_torque_n_m_uncertainty=measured_uncertainty_n_m,
        relative_error=calculated["torque_n_m"] / calculated["measured_torque_n_m"] - 1,
        compatibility=compatibility,
        verdict=verdict,
        palmgren_torque_n_m=palmgren_torque_n_m(
            load_n,
            speed_rpm,
            kinematic_viscosity_m2_s,
            pitch_diameter_m,
            bearing.contact_angle_rad,
            palmgren.f0,
            palmgren.f1,
        ),
        skf_torque_n_m=skf_torque_n_m(
            load_n, speed_rpm, kinematic_viscosity_m2_s, pitch_diameter_m
        ),
        skf_valid=reaches(
            settings.bearing.skf_pitch_speed_max, speed_rpm * pitch_diameter_m * MM_PER_M
        ),
    )


def _inversion_table(
    bearing: Bearing, oils: Sequence[OilInBearing], compared: pd.DataFrame, settings: Settings
) -> pd.DataFrame:
    """Traction that gives the measured torque, with one factor on all traction.

    The torque is calculated with each of `_TRACTION_FACTORS`; the other terms do not change. The
    traction coefficient is interpolated linearly between two neighbouring factors whose torques
    enclose the measured torque. Of several such pairs the nearest to factor 1 is taken; of two that
    are as near, the one of weaker traction.
    """
    # one oil after the other, in the order of `oils`
    plateaus = compared[compared["load_variable"] == "stress"].reset_index(drop=True)
    plateau_count = len(plateaus)
    # each plateau with every factor; the order of the plateaus stays the same
    repeated_index = np.repeat(plateaus.index, len(_TRACTION_FACTORS))
    plateaus_and_factors = plateaus.loc[repeated_index, ["oil", *_LOAD_SPEED_TEMPERATURE]].assign(
        traction_factor=np.tile(_TRACTION_FACTORS, plateau_count)
    )
    groups = [
        CaseGroup(oil, "stress", plateaus_and_factors[plateaus_and_factors["oil"] == oil.name])
        for oil in oils
    ]
    calculated = FrictionCases(bearing, groups).calculate()

    def column_by_factor_and_plateau(column: str) -> FloatArray:
        """A calculated column, shape (factors, plateaus)."""
        values = calculated[column].to_numpy()
        return np.asarray(values.reshape(plateau_count, len(_TRACTION_FACTORS)).T)

    torque_n_m = column_by_factor_and_plateau("torque_n_m")
    mean_mu = column_by_factor_and_plateau("mean_traction_coefficient")
    excess_torque_n_m = torque_n_m - plateaus["measured_torque_n_m"].to_numpy()
    # shape (pairs of neighbouring factors, plateaus)
    encloses_measured = excess_torque_n_m[:-1] * excess_torque_n_m[1:] <= 0
    is_enclosed = encloses_measured.any(axis=0)
    lower_factor_index = (_nearest_pair_index(encloses_measured), np.arange(plateau_count))
    torque_step_n_m = np.diff(torque_n_m, axis=0)[lower_factor_index]
    mu_step = np.diff(mean_mu, axis=0)[lower_factor_index]
    mu_at_lower_factor = np.where(is_enclosed, mean_mu[lower_factor_index], np.nan)
    torque_uncertainty_n_m = _traction_torque_uncertainty_n_m(bearing, oils, plateaus, settings)
    with np.errstate(divide="ignore", invalid="ignore"):
        mu_per_n_m = np.where(torque_step_n_m != 0, mu_step / torque_step_n_m, np.inf)
        mu = mu_at_lower_factor - excess_torque_n_m[lower_factor_index] * mu_per_n_m
        random_uncertainty = np.abs(mu_per_n_m) * plateaus["measured_torque_n_m_se"].to_numpy()
        systematic_uncertainty = np.abs(mu_per_n_m) * torque_uncertainty_n_m
    is_solved = (
        np.isfinite(mu) & np.isfinite(random_uncertainty) & np.isfinite(systematic_uncertainty)
    )
    # without the torque of both neighbouring factors, or without a term, nothing is known
    is_unknown = (np.isnan(torque_n_m).any(axis=0) & ~is_enclosed) | np.isnan(
        torque_uncertainty_n_m
    )
    verdict = np.select(
        [is_unknown, ~is_solved, np.hypot(random_uncertainty, systematic_uncertainty) < mu],
        ["not known", "no solution", "determined"],
        "undetermined",
    )
    return plateaus.assign(
        traction_coefficient=np.where(is_solved, mu, np.nan),
        traction_coefficient_se=np.where(is_solved, random_uncertainty, np.nan),
        traction_coefficient_systematic=np.where(is_solved, systematic_uncertainty, np.nan),
        traction_share=plateaus["traction_torque_n_m"] / plateaus["torque_n_m"],
        law_traction_coefficient=plateaus["mean_traction_coefficient"],
        verdict=verdict,
    )


def _nearest_pair_index(encloses_measured: BoolArray) -> IndexArray:
    """The pair of neighbouring factors nearest to 1, of those that enclose the measured torque.

    Pairs on both sides of 1 are equally near except for rounding: the lower one is taken.

    Args:
        encloses_measured: Whether each pair of `_TRACTION_FACTORS` encloses it, shape
            (pairs, plateaus).

    Returns:
        Index of the pair, which is that of its lower factor; shape (plateaus,).
    """
    # the geometric mean of both factors is at 1 where their product is
    distance_from_1 = np.abs(np.log(_TRACTION_FACTORS[:-1] * _TRACTION_FACTORS[1:]))
    distance = np.where(encloses_measured, distance_from_1[:, np.newaxis], np.inf)
    return first_smallest(distance, axis=0)


def _traction_torque_uncertainty_n_m(
    bearing: Bearing, oils: Sequence[OilInBearing], plateaus: pd.DataFrame, settings: Settings
) -> FloatArray:
    """Standard uncertainty of the traction torque: measured torque less the other terms.

    It has a part by the calibration of the torque sensor, one by each other term, and one by the
    momentum of the feed oil. It is NaN where a term is not known, as the momentum is without the
    flow of the oil.
    """
    # the middles of the slices stand for the distribution
    probabilities = (np.arange(_NORMAL_SLICES) + 0.5) / _NORMAL_SLICES
    normal_numbers = scipy.special.ndtri(probabilities)
    bearing_settings = settings.bearing
    relative_uncertainty_by_term = {
        term: random_factor(bearing_settings, term, normal_numbers).std()
        for term in RANDOM_FACTOR_TERMS
    }
    # drag is proportional to the oil's share of the volume, which is above 0
    oil_volume_fraction = bearing_settings.uncertain_inputs()["oil_volume_fraction"]
    relative_uncertainty_by_term["drag"] = (
        oil_volume_fraction.quantiles(probabilities).std() / oil_volume_fraction.value
    )
    # the momentum has an uncertainty also where its value is 0
    carried_flow_sd_m3_s = _sd_of_product(
        bearing.uncertain_inputs["feed_flow_m3_s"].quantiles(probabilities),
        bearing.uncertain_inputs["momentum_share"].quantiles(probabilities),
    )
    uncertainties_n_m = [
        _calibration_uncertainty_n_m(plateaus, settings),
        momentum_torque_n_m(
            carried_flow_sd_m3_s * _density_kg_m3(oils, plateaus),
            plateaus["inner_speed_rpm"].to_numpy() * RAD_S_PER_RPM,
            bearing.groove_bottom_radius_m[0],
        ),
    ]
    for term, relative_uncertainty in relative_uncertainty_by_term.items():
        uncertainties_n_m.append(relative_uncertainty * plateaus[f"{term}_torque_n_m"].to_numpy())
    return np.asarray(np.linalg.norm(uncertainties_n_m, axis=0))


def _sd_of_product(first_values: FloatArray, second_values: FloatArray) -> float:
    """Standard deviation of the product of two independent quantities.

    Args:
        first_values: Equally probable values of the one.
        second_values: Those of the other.

    Examples:
        Both are -1 or 1, and so is their product:

        >>> print(_sd_of_product(np.array([-1.0, 1.0]), np.array([-1.0, 1.0])))
        1.0
    """
    mean_of_square = np.mean(first_values**2) * np.mean(second_values**2)
    square_of_mean = (np.mean(first_values) * np.mean(second_values)) ** 2
    # rounding must not make it negative; NaN stays
    return float(np.sqrt(np.maximum(mean_of_square - square_of_mean, 0.0)))


def _density_kg_m3(oils: Sequence[OilInBearing], points: pd.DataFrame) -> FloatArray:
    """Density of the oil of each point at the inlet, shape (points,)."""
    temperature_c = points["inlet_temperature_c"].to_numpy(dtype=float)
    density_kg_m3 = np.empty(len(points))
    for oil in oils:
        is_of_oil = points["oil"].to_numpy() == oil.name
        density_kg_m3[is_of_oil] = oil.properties.density_kg_m3(temperature_c[is_of_oil])
    return density_kg_m3


def _calibration_uncertainty_n_m(plateaus: pd.DataFrame, settings: Settings) -> FloatArray:
    """Standard uncertainty of the measured torque by offset and gain of the sensor."""
    calibration = required_value(settings.campaign.torque, "torque", "the campaign").calibration
    gain_n_m = calibration.torque_relative * plateaus["measured_torque_n_m"].to_numpy()
    return np.hypot(calibration.torque_n_m, gain_n_m)


def cage_slip_table(oils: Sequence[OilInBearing], settings: Settings) -> pd.DataFrame:
    """Cage slip of each oil over the speeds and axial loads of `bearing.cage_slip`."""
    map_levels = settings.bearing.cage_slip
    return _cage_slip_map(
        "cage_slip",
        oils,
        settings,
        map_levels.pitch_speed_mm_rpm,
        map_levels.axial_load_n,
        [map_levels.inlet_temperature_c],
    )


def cage_slip_by_temperature_table(
    oils: Sequence[OilInBearing], settings: Settings
) -> pd.DataFrame:
    """Cage slip of each oil at further temperatures, at every second speed and axial load."""
    map_levels = settings.bearing.cage_slip
    temperatures = [
        temperature
        for temperature in map_levels.further_temperature_c
        if temperature != map_levels.inlet_temperature_c
    ]
    return _cage_slip_map(
        "cage_slip_by_temperature",
        oils,
        settings,
        every_second_level(map_levels.pitch_speed_mm_rpm),
        every_second_level(map_levels.axial_load_n),
        temperatures,
    )


def every_second_level(levels: Sequence[float]) -> list[float]:
    """Every second level in rising order, both ends among them.

    Examples:
        >>> every_second_level([1.0, 2.0, 3.0, 4.0])
        [1.0, 3.0, 4.0]
    """
    rising = sorted(levels)
    chosen = rising[::2]
    return chosen if chosen[-1] == rising[-1] else [*chosen, rising[-1]]


def _cage_slip_map(
    table_name: str,
    oils: Sequence[OilInBearing],
    settings: Settings,
    pitch_speeds_mm_rpm: Sequence[float],
    loads_n: Sequence[float],
    temperatures_c: Sequence[float],
) -> pd.DataFrame:
    """Cage slip of each oil, with its uncertainty, at all combinations of levels.

    Args:
        table_name: Name of the table.
        oils: Oils with their laws.
        settings: The settings.
        pitch_speeds_mm_rpm: Pitch diameter times speed.
        loads_n: Axial loads.
        temperatures_c: Oil temperatures.
    """
    if not oils or not temperatures_c:
        return tables.empty_table(table_name)
    bearing = settings.tested_bearing()
    temperature_c, pitch_speed_mm_rpm, load_n = np.meshgrid(
        temperatures_c, pitch_speeds_mm_rpm, loads_n, indexing="ij"
    )
    points = pd.DataFrame(
        {
            "axial_load_n": load_n.ravel(),
            "pitch_speed_mm_rpm": pitch_speed_mm_rpm.ravel(),
            "inner_speed_rpm": pitch_speed_mm_rpm.ravel() / (bearing.pitch_diameter_m * MM_PER_M),
            "inlet_temperature_c": temperature_c.ravel(),
        }
    )
    cases = FrictionCases(bearing, [CaseGroup(oil, "stress", points) for oil in oils])
    calculated, draws, _ = cases.calculate_with_uncertainty(settings.seed)
    slip_limit = settings.bearing.cage_slip.slip_limit
    # in how many draws the oil is the best one
    best_oil_columns = best_shares(draws, len(oils), slip_limit, settings.gates.lambda_limit)
    return stack_tables([calculated.assign(**best_oil_columns)], table_name)


def size_effect_table(oils: Sequence[OilInBearing], settings: Settings) -> pd.DataFrame:
    """Traction torque with every load variable, over ball sizes and groove curvatures.

    `bearing.size_effect` of the settings lists both. Loads and speeds give the same pressure and
    surface speed at every ball size.
    """
    if not oils:
        return tables.empty_table("size_effect")
    bearing = settings.tested_bearing()
    size_settings = settings.bearing.size_effect
    # what is varied, the bearing, and the factor on its size
    variants: list[tuple[str, Bearing, float]] = []
    for size_factor in size_settings.ball_size_factors:
        variants.append(("ball size", _scaled_bearing(bearing, size_factor), size_factor))
    for groove_curvature in size_settings.groove_curvatures:
        variant = replace(bearing, groove_curvature=(groove_curvature, groove_curvature))
        variants.append(("conformity", variant, 1.0))
    terms_of_variants = []
    for varied, variant, size_factor in variants:
        # areas of contact grow with the square of the size, surface speeds with the size
        point = pd.DataFrame(
            {
                "axial_load_n": [size_settings.axial_load_n * size_factor**2],
                "inner_speed_rpm": size_settings.inner_speed_rpm / size_factor,
                "inlet_temperature_c": size_settings.inlet_temperature_c,
            }
        )
        groups = [
            CaseGroup(oil, load_variable, point) for oil in oils for load_variable in oil.laws
        ]
        calculated = FrictionCases(variant, groups).calculate()
        torque_by_oil_and_variable = calculated.set_index(["oil", "load_variable"])[
            "traction_torque_n_m"
        ]
        # of the oil of each row
        stress_torque_n_m = torque_by_oil_and_variable.xs("stress", level="load_variable")[
            calculated["oil"]
        ].to_numpy()
        terms_of_variants.append(
            calculated.assign(
                varied=varied,
                ball_diameter_mm=variant.ball_diameter_m * MM_PER_M,
                groove_curvature=variant.groove_curvature[0],
                relative_to_stress=calculated["traction_torque_n_m"] / stress_torque_n_m - 1,
            )
        )
    stacked_table = stack_tables(terms_of_variants, "size_effect")
    rank_of_oil = {oil.name: rank for rank, oil in enumerate(oils)}
    return stacked_table.sort_values(
        "oil", key=lambda names: names.map(rank_of_oil), kind="stable", ignore_index=True
    )


def _scaled_bearing(bearing: Bearing, size_factor: float) -> Bearing:
    """A bearing with all lengths scaled, except the roughness.

    The flow of oil is scaled with the area of its section.
    """
    cage = replace(
        bearing.cage,
        land_diameter_m=size_factor * bearing.cage.land_diameter_m,
        land_width_m=size_factor * bearing.cage.land_width_m,
        land_clearance_m=size_factor * bearing.cage.land_clearance_m,
    )
    scaled_inputs = {
        name: bearing.uncertain_inputs[name].scaled(size_factor**power)
        for name, power in _SIZE_POWERS.items()
    }
    return replace(
        bearing,
        ball_diameter_m=size_factor * bearing.ball_diameter_m,
        pitch_diameter_m=size_factor * bearing.pitch_diameter_m,
        cage=cage,
        uncertain_inputs={**bearing.uncertain_inputs, **scaled_inputs},
    )


def stack_tables(tables_to_stack: Iterable[pd.DataFrame], table_name: str) -> pd.DataFrame:
    """A table from its parts, one below the other, with the declared columns only."""
    frames = list(tables_to_stack)
    stacked_table = (
        pd.concat(frames, ignore_index=True) if frames else tables.empty_table(table_name)
    )
    return tables.conform(
        stacked_table[tables.columns(table_name)], table_name, f"table {table_name}"
    )
