"""A fitted traction law in bearings: tables of torque, inversion, cage slip and size effect."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd
import scipy

from oilfilm import tables
from oilfilm.base.ties import first_smallest, reaches
from oilfilm.base.units import MM_PER_M, RAD_S_PER_RPM, BoolArray, FloatArray, IndexArray
from oilfilm.bearing.equilibria import Neighbour, equilibria, friction_equilibrium
from oilfilm.bearing.friction import FrictionEquilibrium, FrictionProblem
from oilfilm.bearing.geometry import Bearing
from oilfilm.bearing.quasistatic import OperatingPoints
from oilfilm.bearing.resistance import TERMS, Lubrication
from oilfilm.bearing.torque import palmgren_torque_n_m, skf_torque_n_m, torque_terms
from oilfilm.fits.fit import laws_of
from oilfilm.fits.fitted import FittedLaw
from oilfilm.physics.contact import Contact, Floats
from oilfilm.physics.oils import Oil
from oilfilm.settings.base import present
from oilfilm.settings.config import BearingSettings
from oilfilm.settings.resolved import Settings
from oilfilm.torque.best_oil import best_shares
from oilfilm.torque.load_variables import LOAD_VARIABLES, LawInBearing, law_of_groups
from oilfilm.torque.torque_uncertainty import (
    draw_results,
    has_draws,
    term_factors,
    with_uncertainty,
)
from oilfilm.traction import BEARING_LAW_NAMES

_POINT = ["axial_load_n", "inner_speed_rpm", "inlet_temperature_c"]
_TESTED = ("max_hertz_pressure_gpa", "entrainment_speed_m_s", "slide_roll_ratio")
# Largest residual in tables, relative to the load of a ball; null above.
_LARGEST_RESIDUAL = 1e9
# Factors on all traction, between which the inversion interpolates.
_TRACTION_FACTORS = np.geomspace(1 / 8, 8, 25)
# A combination of oil, load variable and operating points.
CaseGroup = tuple["OilInBearing", str, pd.DataFrame]


@dataclass(frozen=True)
class OilInBearing:
    """One oil in bearings: its properties and its fitted laws.

    Attributes:
        name: Name in config/oils.
        oil: Its properties.
        laws: Law by load variable: the campaign's law with each of `LOAD_VARIABLES`, and the laws
            on load by their names.
        tested: Lowest and highest tested level of pressure, speed and slip; NaN where unknown.
        settings: Section `bearing` of the settings.
    """

    name: str
    oil: Oil
    laws: Mapping[str, LawInBearing]
    tested: Mapping[str, tuple[float, float]]
    settings: BearingSettings

    def with_constants(self, constants: FloatArray) -> "OilInBearing":
        """The oil with other constants of the campaign's law, with each of `LOAD_VARIABLES`.

        Args:
            constants: Constants in the law's order, shape (constants,), or one row for each
                operating point of the next `run`, shape (points, constants).
        """
        laws = {name: self.laws[name].with_constants(constants) for name in LOAD_VARIABLES}
        return replace(self, laws=laws)

    def run(
        self,
        bearing: Bearing,
        axial_load_n: Floats,
        inner_speed_rpm: Floats,
        inlet_temperature_c: Floats,
        load_variable: str = "stress",
        traction_factor: Floats = 1.0,
    ) -> pd.DataFrame:
        """Friction at operating points, one row per point; see `Cases.run`.

        Args:
            bearing: The bearing.
            axial_load_n: Axial load. It broadcasts against the three others.
            inner_speed_rpm: Speed of the inner ring.
            inlet_temperature_c: Temperature of the oil.
            load_variable: Key of `laws`.
            traction_factor: Factor on all traction.
        """
        load, speed, temperature, factor = np.broadcast_arrays(
            np.atleast_1d(axial_load_n), inner_speed_rpm, inlet_temperature_c, traction_factor
        )
        points = pd.DataFrame(
            {
                "axial_load_n": load,
                "inner_speed_rpm": speed,
                "inlet_temperature_c": temperature,
                "traction_factor": factor,
            }
        )
        return Cases(bearing, [(self, load_variable, points)]).run()


class Cases:
    """Operating points of one bearing, each with an oil and a load variable, solved together.

    Attributes:
        oils: Oil of each group of points.
        laws: Law of each group of points.
        points: One row per point: `oil`, `bearing`, `load_variable`, and the columns of the groups.
            The column `traction_factor`, if any, is a factor on all traction.
        problem: The friction problem of these points.
    """

    def __init__(self, bearing: Bearing, groups: Sequence[CaseGroup]) -> None:
        """Cases by groups.

        Args:
            bearing: The bearing.
            groups: Oil, load variable and operating points with the columns axial_load_n,
                inner_speed_rpm, inlet_temperature_c and any other.
        """
        self.oils = [oil for oil, _, _ in groups]
        self.laws = [oil.laws[variable] for oil, variable, _ in groups]
        tables_of_groups = []
        lubrications = []
        for oil, variable, points in groups:
            tables_of_groups.append(
                points.assign(oil=oil.name, bearing=bearing.name, load_variable=variable)
            )
            lubrications.append(
                Lubrication.of(
                    oil.oil,
                    points["inlet_temperature_c"].to_numpy(dtype=float),
                    oil.settings.drag_coefficient,
                    oil.settings.oil_volume_fraction,
                )
            )
        self.points = pd.concat(tables_of_groups, ignore_index=True)
        load = self.points["axial_load_n"].to_numpy(dtype=float)
        speed = self.points["inner_speed_rpm"].to_numpy(dtype=float)
        lubrication = Lubrication.joined(lubrications)
        self._sizes = [len(points) for _, _, points in groups]
        if "traction_factor" in self.points:
            traction_factor = self.points["traction_factor"].to_numpy()
            lubrication = lubrication.with_traction_factor(traction_factor)
        law = law_of_groups(self.laws, self._sizes)
        operating_points = OperatingPoints.axial(load, speed * RAD_S_PER_RPM)
        self.problem = FrictionProblem(bearing, operating_points, lubrication, law)

    def run(self, neighbour: Neighbour | None = None) -> pd.DataFrame:
        """Friction at every point, with the columns of `torque_terms`; null without equilibrium.

        Args:
            neighbour: Equilibria with other constants; see `friction_equilibrium`.
        """
        return self._terms(friction_equilibrium(self.problem, neighbour))

    def _terms(self, equilibrium: FrictionEquilibrium) -> pd.DataFrame:
        """Columns of `torque_terms`, the verdict on pressure, and the columns of the points."""
        tested = {
            name: np.repeat([oil.tested[name] for oil in self.oils], self._sizes, axis=0).T
            for name in _TESTED
        }
        ratio = np.repeat([oil.oil.limiting_stress_ratio for oil in self.oils], self._sizes)
        terms = _null_without_equilibrium(torque_terms(equilibrium, tested, ratio))
        long_term, peak = self.oils[0].settings.pressure_limits_gpa
        pressure = terms.filter(regex="max_hertz_pressure_gpa").max(axis=1)
        terms["pressure_verdict"] = np.select(
            [np.isnan(pressure), pressure > peak, pressure > long_term],
            ["not known", "above peak", "above long-term"],
            "within",
        )
        return terms.join(self.points[self.points.columns.difference(terms.columns)])

    def assessed(self, seed: int) -> tuple[pd.DataFrame, FloatArray]:
        """The results of `run` with their uncertainty and the other equilibrium; and the draws.

        Args:
            seed: Seed of the configuration.

        Returns:
            The table of `with_uncertainty`, with the further columns `equilibria`,
            `other_cage_slip`, `other_torque_n_m` and `bistable`. The draws of
            `torque_uncertainty.draw_results`.
        """
        motions = equilibria(self.problem)
        calculated = self._terms(motions.fastest)
        groups = [(oil.name, oil.oil, law) for oil, law in zip(self.oils, self.laws, strict=True)]
        group_of_point = np.repeat(np.arange(len(groups)), self._sizes)
        settings = self.oils[0].settings
        draws = draw_results(motions.fastest, groups, group_of_point, calculated, settings, seed)
        speed_rad_s = self.problem.points.ring_speed_rad_s[:, 0]
        has_refits = np.array([has_draws(law.fitted) for law in self.laws])
        was_drawn = has_refits[group_of_point] & calculated["converged"].to_numpy(dtype=bool)
        terms = with_uncertainty(calculated, draws, was_drawn, speed_rad_s, settings.uncertainty)
        several = motions.count > 1
        several_is_known = (motions.count > 0) & (motions.complete | several)
        several_or_null = pd.Series(several, terms.index, dtype="boolean").where(several_is_known)
        # true if either is true, false if both are false, else null
        terms["bistable"] = several_or_null | terms["draws_split"]
        terms["equilibria"] = motions.count
        terms["other_cage_slip"] = np.where(several, motions.slowest.cage_slip(), np.nan)
        terms["other_torque_n_m"] = np.where(several, motions.slowest.torque_n_m(), np.nan)
        return terms, draws


def oils_in_bearings(
    coefficients: pd.DataFrame,
    quality: pd.DataFrame,
    settings: Settings,
    refits: pd.DataFrame | None = None,
    surfaces: pd.DataFrame | None = None,
) -> list[OilInBearing]:
    """The oils of the campaign with known properties and a law that is known at any condition.

    The list is empty if the contact of the traction rigs is not known or not the same.

    Args:
        coefficients: Table of coefficients. Beside the configured law, laws on load are evaluated.
        quality: Table of fit quality.
        settings: The settings.
        refits: Table of refits. Without it the results have no uncertainty.
        surfaces: Table of surfaces, with the error of a run. Without it runs have none.
    """
    # a law on load holds for the ball of its rig: all rigs must have the same ball
    rig = settings.common_contact()
    if rig is None:
        return []
    # grouped once, because the table is long
    refits_of = {} if refits is None else dict(iter(refits.groupby(["oil", "law"])))
    configured = {row["oil"]: row for row in tables.rows(quality[quality["configured"]])}
    oils = []
    for name in settings.oils:
        oil = settings.properties_of(name)
        if oil is None or name not in configured:
            continue
        row = configured[name]
        available_laws = laws_of(name, settings)
        fitted_names = set(coefficients.loc[coefficients["oil"] == name, "law"])
        law_names = {variable: row["law"] for variable in LOAD_VARIABLES}
        for law_name in BEARING_LAW_NAMES:
            if law_name in fitted_names and law_name in available_laws:
                law_names[law_name] = law_name
        fits = {
            law_name: FittedLaw.from_tables(
                coefficients,
                name,
                refits_of.get((name, law_name)),
                quality,
                available_laws[law_name],
                surfaces=surfaces,
            )
            for law_name in set(law_names.values())
        }
        laws = _laws_in_bearing(fits, law_names, rig, settings.bearing)
        if "stress" in laws:
            tested = {
                level: (float(row[f"tested_min_{level}"]), float(row[f"tested_max_{level}"]))
                for level in _TESTED
            }
            oils.append(OilInBearing(name, oil, laws, tested, settings.bearing))
    return oils


def _laws_in_bearing(
    fits: Mapping[str, FittedLaw],
    law_names: Mapping[str, str],
    rig: Contact,
    settings: BearingSettings,
) -> dict[str, LawInBearing]:
    """Laws by load variable, without those that have no value at the conditions of a bearing.

    Args:
        fits: Fitted laws by their names.
        law_names: Name of the law for each load variable.
        rig: Contact of the traction rig.
        settings: Section `bearing` of the settings.
    """
    floor = settings.law_floor.model_dump()
    laws = {}
    for variable, law_name in law_names.items():
        coefficients = fits[law_name].coefficients
        if coefficients.followed.all() and not np.isnan(coefficients.constants).any():
            laws[variable] = LawInBearing.of(fits[law_name], variable, rig, floor)
    return laws


def _null_without_equilibrium(terms: Mapping[str, FloatArray]) -> pd.DataFrame:
    """A table of terms that are null without an equilibrium, with the reason."""
    converged, residual = terms["converged"].astype(bool), terms["residual"]
    columns = {name: np.where(converged, values, np.nan) for name, values in terms.items()}
    is_too_wide = terms["widest_contact"] >= 1
    reason = np.select(
        [converged, is_too_wide], ["", "contacts too wide"], default="out of balance"
    )
    return pd.DataFrame(columns).assign(
        converged=converged,
        held_by_band=_known_flag(terms["held_by_band"], converged),
        outside_law=_known_flag(terms["outside_law"], converged),
        film_in_range=_known_flag(terms["film_in_range"], converged),
        residual=np.where(residual < _LARGEST_RESIDUAL, residual, np.nan),
        no_equilibrium=reason.astype(object),
        widest_contact=terms["widest_contact"],
    )


def _known_flag(flag: FloatArray, known: BoolArray) -> "pd.Series[bool]":
    """A flag that is null where it is not known."""
    return pd.Series(flag.astype(bool), dtype="boolean").where(known)


def torque_table(
    runs: pd.DataFrame, oils: Sequence[OilInBearing], settings: Settings
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Measured and calculated torque with every load variable, and traction by inversion.

    Args:
        runs: Table of torque runs. Refused plateaus are left out.
        oils: Oils with their laws.
        settings: The settings.

    Returns:
        The tables `torque` and `torque_inversion`.
    """
    measured = runs.loc[runs["accepted"], ["run_id", "first_row", "oil", *_POINT[:2]]].assign(
        inlet_temperature_c=runs["oil_temperature_c"],
        measured_torque_n_m=runs["torque_n_m"],
        measured_torque_n_m_se=runs["torque_n_m_se"],
    )
    measured_names = set(measured["oil"])
    measured_oils = [oil for oil in oils if oil.name in measured_names]
    if not measured_oils:
        return tables.empty("torque"), tables.empty("torque_inversion")
    groups: list[CaseGroup] = []
    for oil in measured_oils:
        plateaus = measured[measured["oil"] == oil.name]
        groups += [(oil, variable, plateaus) for variable in oil.laws]
    bearing = settings.tested_bearing()
    calculated, _ = Cases(bearing, groups).assessed(settings.seed)
    terms = _compared(bearing, calculated, measured_oils, settings)
    inversion = _inversion(bearing, measured_oils, terms, settings)
    return joined([terms], "torque"), joined([inversion], "torque_inversion")


def _compared(
    bearing: Bearing, terms: pd.DataFrame, oils: Sequence[OilInBearing], settings: Settings
) -> pd.DataFrame:
    """Calculated torque compared with the measured torque, and the estimates of catalogues."""
    uncertainty = np.hypot(
        terms["measured_torque_n_m_se"].to_numpy(), _calibration_n_m(terms, settings)
    )
    difference = terms["torque_n_m"] - terms["measured_torque_n_m"]
    compatibility = difference / np.hypot(terms["torque_n_m_uncertainty"], uncertainty)
    compatible = np.abs(compatibility) <= settings.bearing.compatible_uncertainties
    verdict = np.select(
        [np.isnan(compatibility), compatible], ["not known", "compatible"], "not compatible"
    )
    load, speed, temperature = terms[_POINT].to_numpy().T
    viscosity = np.empty(len(terms))
    for oil in oils:
        is_oil = terms["oil"].to_numpy() == oil.name
        viscosity[is_oil] = oil.oil.kinematic_viscosity_m2_s(temperature[is_oil])
    pitch = bearing.pitch_diameter_m
    palmgren = settings.bearing.palmgren
    return terms.assign(
        measured_torque_n_m_uncertainty=uncertainty,
        relative_error=terms["torque_n_m"] / terms["measured_torque_n_m"] - 1,
        compatibility=compatibility,
        verdict=verdict,
        palmgren_torque_n_m=palmgren_torque_n_m(
            load, speed, viscosity, pitch, bearing.contact_angle_rad, palmgren.f0, palmgren.f1
        ),
        skf_torque_n_m=skf_torque_n_m(load, speed, viscosity, pitch),
        skf_valid=reaches(settings.bearing.skf_pitch_speed_max, speed * pitch * MM_PER_M),
    )


def _inversion(
    bearing: Bearing, oils: Sequence[OilInBearing], terms: pd.DataFrame, settings: Settings
) -> pd.DataFrame:
    """Traction that gives the measured torque, with one factor on all traction.

    The torque is calculated with each of `_TRACTION_FACTORS`; the other terms do not change. The
    traction coefficient is interpolated linearly between two neighbouring factors whose torques
    enclose the measured torque. Of several such pairs the nearest to factor 1 is taken; of two that
    are as near, the one of weaker traction.
    """
    plateaus = terms[terms["load_variable"] == "stress"].reset_index(drop=True)
    count = len(plateaus)
    scaled = plateaus.loc[
        np.repeat(plateaus.index, len(_TRACTION_FACTORS)), ["oil", *_POINT]
    ].assign(traction_factor=np.tile(_TRACTION_FACTORS, count))
    groups = [(oil, "stress", scaled[scaled["oil"] == oil.name]) for oil in oils]
    calculated = Cases(bearing, groups).run()
    # rows are factors, columns are plateaus
    shape = (count, len(_TRACTION_FACTORS))
    torque = calculated["torque_n_m"].to_numpy().reshape(shape).T
    coefficient = calculated["mean_traction_coefficient"].to_numpy().reshape(shape).T
    excess = torque - plateaus["measured_torque_n_m"].to_numpy()
    encloses = excess[:-1] * excess[1:] <= 0
    lower = (_nearest_pair(encloses), np.arange(count))
    torque_step = np.diff(torque, axis=0)[lower]
    coefficient_step = np.diff(coefficient, axis=0)[lower]
    start = np.where(encloses.any(axis=0), coefficient[lower], np.nan)
    with np.errstate(divide="ignore", invalid="ignore"):
        slope = np.where(torque_step != 0, coefficient_step / torque_step, np.inf)
        value = start - excess[lower] * slope
        random = np.abs(slope) * plateaus["measured_torque_n_m_se"].to_numpy()
        systematic = np.abs(slope) * _traction_torque_uncertainty_n_m(plateaus, settings)
    solved = np.isfinite(value) & np.isfinite(random) & np.isfinite(systematic)
    # without the torque of both neighbouring factors nothing is known
    unknown = np.isnan(torque).any(axis=0) & ~encloses.any(axis=0)
    verdict = np.select(
        [unknown, ~solved, np.hypot(random, systematic) < value],
        ["not known", "no solution", "determined"],
        "undetermined",
    )
    return plateaus.assign(
        traction_coefficient=np.where(solved, value, np.nan),
        traction_coefficient_se=np.where(solved, random, np.nan),
        traction_coefficient_systematic=np.where(solved, systematic, np.nan),
        traction_share=plateaus["traction_torque_n_m"] / plateaus["torque_n_m"],
        law_traction_coefficient=plateaus["mean_traction_coefficient"],
        verdict=verdict,
    )


def _nearest_pair(encloses: BoolArray) -> IndexArray:
    """Index of the pair of neighbouring factors nearest to 1 of those that enclose a torque.

    Pairs on both sides of 1 are equally near except for rounding: the lower one is taken.

    Args:
        encloses: Whether each pair of `_TRACTION_FACTORS` does, shape (pairs, plateaus).
    """
    distance_from_1 = np.abs(np.log(_TRACTION_FACTORS[:-1] * _TRACTION_FACTORS[1:]))
    distance = np.where(encloses, distance_from_1[:, np.newaxis], np.inf)
    return first_smallest(distance, axis=0)


def _traction_torque_uncertainty_n_m(terms: pd.DataFrame, settings: Settings) -> FloatArray:
    """Standard uncertainty of the traction torque, by calibration and by the other terms."""
    # quantiles in the middle of 1000 equal slices of the normal distribution
    normal = scipy.special.ndtri((np.arange(1000) + 0.5) / 1000)[:, np.newaxis]
    factors = term_factors(settings.bearing, np.repeat(normal, len(TERMS), axis=1))
    parts = [_calibration_n_m(terms, settings)]
    for term, relative in zip(TERMS, factors.std(axis=0), strict=True):
        parts.append(relative * terms[f"{term}_torque_n_m"].to_numpy())
    return np.asarray(np.linalg.norm(parts, axis=0))


def _calibration_n_m(terms: pd.DataFrame, settings: Settings) -> FloatArray:
    """Standard uncertainty of the measured torque by offset and gain of the sensor."""
    calibration = present(settings.campaign.torque, "torque", "the campaign").calibration
    gain = calibration.torque_relative * terms["measured_torque_n_m"].to_numpy()
    return np.hypot(calibration.torque_n_m, gain)


def cage_slip_table(oils: Sequence[OilInBearing], settings: Settings) -> pd.DataFrame:
    """Cage slip of each oil over the speeds and axial loads of `bearing.cage_slip`."""
    if not oils:
        return tables.empty("cage_slip")
    bearing = settings.tested_bearing()
    levels = settings.bearing.cage_slip
    pitch_speed, load = np.meshgrid(levels.pitch_speed_mm_rpm, levels.axial_load_n, indexing="ij")
    points = pd.DataFrame(
        {
            "axial_load_n": load.ravel(),
            "pitch_speed_mm_rpm": pitch_speed.ravel(),
            "inner_speed_rpm": pitch_speed.ravel() / (bearing.pitch_diameter_m * MM_PER_M),
            "inlet_temperature_c": levels.inlet_temperature_c,
        }
    )
    cases = Cases(bearing, [(oil, "stress", points) for oil in oils])
    terms, draws = cases.assessed(settings.seed)
    slip_limit = settings.bearing.cage_slip.slip_limit
    shares = best_shares(draws, len(oils), slip_limit, settings.gates.lambda_limit)
    return joined([terms.assign(**shares)], "cage_slip")


def size_effect_table(oils: Sequence[OilInBearing], settings: Settings) -> pd.DataFrame:
    """Traction torque with every load variable, over ball sizes and groove curvatures.

    `bearing.size_effect` of the settings lists both. Loads and speeds give the same pressure and
    surface speed at every ball size.
    """
    if not oils:
        return tables.empty("size_effect")
    bearing = settings.tested_bearing()
    study = settings.bearing.size_effect
    variants = [("ball size", _scaled(bearing, size), size) for size in study.ball_size_factors]
    variants += [
        ("conformity", replace(bearing, groove_curvature=(groove, groove)), 1.0)
        for groove in study.groove_curvatures
    ]
    parts = []
    for name, variant, factor in variants:
        point = pd.DataFrame(
            {
                "axial_load_n": [study.axial_load_n * factor**2],
                "inner_speed_rpm": study.inner_speed_rpm / factor,
                "inlet_temperature_c": study.inlet_temperature_c,
            }
        )
        groups = [(oil, variable, point) for oil in oils for variable in oil.laws]
        terms = Cases(variant, groups).run()
        traction = terms.set_index(["oil", "load_variable"])["traction_torque_n_m"]
        by_stress = traction.xs("stress", level="load_variable")[terms["oil"]].to_numpy()
        parts.append(
            terms.assign(
                varied=name,
                ball_diameter_mm=variant.ball_diameter_m * MM_PER_M,
                groove_curvature=variant.groove_curvature[0],
                relative_to_stress=terms["traction_torque_n_m"] / by_stress - 1,
            )
        )
    table = joined(parts, "size_effect")
    order = {oil.name: number for number, oil in enumerate(oils)}
    return table.sort_values(
        "oil", key=lambda names: names.map(order), kind="stable", ignore_index=True
    )


def _scaled(bearing: Bearing, factor: float) -> Bearing:
    """A bearing with all lengths scaled, except the roughness."""
    cage = replace(
        bearing.cage,
        land_diameter_m=factor * bearing.cage.land_diameter_m,
        land_width_m=factor * bearing.cage.land_width_m,
        land_clearance_m=factor * bearing.cage.land_clearance_m,
    )
    return replace(
        bearing,
        ball_diameter_m=factor * bearing.ball_diameter_m,
        pitch_diameter_m=factor * bearing.pitch_diameter_m,
        cage=cage,
    )


def joined(parts: Iterable[pd.DataFrame], table: str) -> pd.DataFrame:
    """A table from its parts, one below the other, with the declared columns only."""
    frames = list(parts)
    frame = pd.concat(frames, ignore_index=True) if frames else tables.empty(table)
    return tables.conform(frame[tables.columns(table)], table, f"table {table}")
