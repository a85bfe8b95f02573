"""A fitted traction law in bearings: tables of torque, inversion, cage slip and size effect."""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from oilfilm import tables
from oilfilm.bearing.branches import other_equilibrium
from oilfilm.bearing.catalogue_torque import palmgren_torque_n_m, skf_torque_n_m
from oilfilm.bearing.ellipse import ScaledLaw
from oilfilm.bearing.geometry import Bearing
from oilfilm.bearing.quasistatic import OperatingPoints
from oilfilm.bearing.resistance import Lubrication
from oilfilm.bearing.torque import torque_terms
from oilfilm.fits.fitted import FittedLaw
from oilfilm.fits.law_comparison import laws_of
from oilfilm.physics.contact import Floats
from oilfilm.physics.oils import Oil
from oilfilm.randomness import generator
from oilfilm.settings.base import present
from oilfilm.settings.config import BearingSettings
from oilfilm.settings.resolved import Settings
from oilfilm.torque.load_variables import LOAD_VARIABLES, LawInBearing
from oilfilm.torque.torque_uncertainty import with_uncertainty
from oilfilm.traction import BEARING_LAW_NAMES
from oilfilm.units import MM_PER_M, RAD_S_PER_RPM, FloatArray

_POINT = ["axial_load_n", "inner_speed_rpm", "inlet_temperature_c"]
_TESTED = ("max_hertz_pressure_gpa", "entrainment_speed_m_s", "slide_roll_ratio")
# Of a ball's load; a larger residual is no number worth a table.
_LARGEST_RESIDUAL = 1e9
# Beyond this inner contact angle no groove is left to guide the ball.
_SHOULDER_DEG = 65.0
# Factors on all traction, among which the inversion looks for that of a measured torque.
_FACTORS = np.geomspace(1 / 8, 8, 25)
# Largest difference in standard uncertainties between values that agree.
_COMPATIBLE = 2


@dataclass(frozen=True)
class OilInBearing:
    """One oil in bearings: its properties and its fitted laws.

    Attributes:
        name: As in config/oils.
        oil: Its properties.
        laws: Law by load variable: the campaign's own with each of `LOAD_VARIABLES`, and laws on
            load by their names.
        tested: Lowest and highest tested level of pressure, speed and slip; NaN where unknown.
        settings: The settings' `bearing`.
    """

    name: str
    oil: Oil
    laws: Mapping[str, LawInBearing]
    tested: Mapping[str, tuple[float, float]]
    settings: BearingSettings

    def with_constants(self, constants: FloatArray) -> "OilInBearing":
        """The oil with other constants of the campaign's law, with each of `LOAD_VARIABLES`.

        Args:
            constants: In the law's order, shape (constants,); or one row for each operating point
                of the next `run`, shape (points, constants).
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
        """Friction at operating points, one row per point, with the columns of `torque_terms`.

        Args:
            bearing: The bearing.
            axial_load_n: Axial load.
            inner_speed_rpm: Speed of the inner ring.
            inlet_temperature_c: Temperature of the oil.
            load_variable: Key of `laws`.
            traction_factor: Factor on all traction.
        """
        load, speed, temperature, factor = np.broadcast_arrays(
            np.atleast_1d(axial_load_n), inner_speed_rpm, inlet_temperature_c, traction_factor
        )
        law = ScaledLaw(self.laws[load_variable], factor)
        points = OperatingPoints.axial(load, speed * RAD_S_PER_RPM)
        terms = torque_terms(bearing, points, self.lubrication(temperature), law, self.tested)
        return _without_failures(terms).assign(
            oil=self.name,
            bearing=bearing.name,
            load_variable=load_variable,
            axial_load_n=load,
            inner_speed_rpm=speed,
            inlet_temperature_c=temperature,
        )

    def lubrication(self, inlet_temperature_c: FloatArray) -> Lubrication:
        """The oil at the temperature of each point, in a bearing with the settings' drag."""
        return Lubrication.of(
            self.oil,
            inlet_temperature_c,
            self.settings.drag_coefficient,
            self.settings.oil_volume_fraction,
        )

    def with_uncertainty(
        self, bearing: Bearing, calculated: pd.DataFrame, seed: int
    ) -> pd.DataFrame:
        """What `run` calculated with one load variable, and its uncertainty.

        Args:
            bearing: The bearing.
            calculated: Of `run` without a factor on traction.
            seed: Of the configuration; each oil and load variable has random numbers of its own.

        Returns:
            See `torque_uncertainty.with_uncertainty`.
        """
        load_variable = calculated["load_variable"].iloc[0]
        return with_uncertainty(
            bearing,
            calculated,
            self.lubrication(calculated["inlet_temperature_c"].to_numpy()),
            self.laws[load_variable],
            self.settings.term_uncertainty,
            self.settings.uncertainty.draws,
            generator(seed, "torque uncertainty", self.name, load_variable),
        )

    def assessed(self, bearing: Bearing, calculated: pd.DataFrame, seed: int) -> pd.DataFrame:
        """What `run` calculated with one load variable, with uncertainty and the other equilibrium.

        Args:
            bearing: The bearing.
            calculated: As for `with_uncertainty`.
            seed: As for `with_uncertainty`.

        Returns:
            See `with_uncertainty`; besides `other_cage_slip`, `other_torque_n_m` and `bistable`,
            which is true where there is another equilibrium or the draws have two.
        """
        load, speed, temperature = calculated[_POINT].to_numpy().T
        other = other_equilibrium(
            bearing,
            OperatingPoints.axial(load, speed * RAD_S_PER_RPM),
            self.lubrication(temperature),
            self.laws[calculated["load_variable"].iloc[0]],
            calculated["cage_slip"].to_numpy(),
        )
        terms = self.with_uncertainty(bearing, calculated, seed)
        return terms.assign(
            bistable=~np.isnan(other.cage_slip) | terms["draws_split"],
            other_cage_slip=other.cage_slip,
            other_torque_n_m=other.torque_n_m,
        )


def oils_in_bearings(
    coefficients: pd.DataFrame,
    quality: pd.DataFrame,
    settings: Settings,
    refits: pd.DataFrame | None = None,
) -> list[OilInBearing]:
    """The campaign's oils whose law at any condition, properties and traction rig are known.

    Args:
        coefficients: Table of coefficients; beside the configured law, laws on load are evaluated.
        quality: Table of fit quality.
        settings: The settings.
        refits: Table of refits; without it results have no uncertainty.
    """
    # a law on load refers to the ball of its rig: several rigs must have the same one
    if (rig := settings.common_contact()) is None:
        return []
    floor = settings.bearing.law_floor.model_dump()
    oils = []
    configured = {row["oil"]: row for row in tables.rows(quality[quality["configured"]])}
    for name in [oil for oil in settings.oils if oil in configured]:
        row, known = configured[name], laws_of(name, settings)
        fitted = set(coefficients.loc[coefficients["oil"] == name, "law"])
        law_names = {variable: row["law"] for variable in LOAD_VARIABLES}
        law_names |= {law: law for law in BEARING_LAW_NAMES if law in fitted and law in known}
        fits = {
            law: FittedLaw.of(coefficients, name, refits, quality, known[law])
            for law in set(law_names.values())
        }
        laws = {
            variable: LawInBearing.of(fits[law], variable, rig, floor)
            for variable, law in law_names.items()
            if _holds_anywhere(fits[law])
        }
        oil = settings.properties_of(name)
        if oil is None or "stress" not in laws:
            continue
        tested = {
            level: (float(row[f"tested_min_{level}"]), float(row[f"tested_max_{level}"]))
            for level in _TESTED
        }
        oils.append(OilInBearing(name, oil, laws, tested, settings.bearing))
    return oils


def _holds_anywhere(law: FittedLaw) -> bool:
    """Whether a law follows every condition: those of a bearing are not those of the tests."""
    coefficients = law.coefficients
    return bool(coefficients.known.all() and not np.isnan(coefficients.constants).any())


def _without_failures(terms: Mapping[str, FloatArray]) -> pd.DataFrame:
    """Null where there is no equilibrium, with the reason."""
    converged, residual = terms["converged"].astype(bool), terms["residual"]
    cleared = {name: np.where(converged, values, np.nan) for name, values in terms.items()}
    states = zip(residual, terms["inner_contact_angle_deg"], terms["widest_contact"], strict=True)
    why = ["" if good else _why(*state) for good, state in zip(converged, states, strict=True)]
    return pd.DataFrame(cleared).assign(
        converged=converged,
        film_in_range=converged & terms["film_in_range"].astype(bool),
        residual=np.where(residual < _LARGEST_RESIDUAL, residual, np.nan),
        why=np.array(why, dtype=object),
    )


def _why(residual: float, inner_angle_deg: float, widest_contact: float) -> str:
    if widest_contact >= 1:
        return (
            f"the contacts would be {widest_contact:.2g} times as wide as the balls; check the "
            "axial load and its unit"
        )
    imbalance = f"forces stay {residual:.2g} of a ball's load out of balance"
    if inner_angle_deg > _SHOULDER_DEG:
        return f"{imbalance}; the ball climbs the inner shoulder ({inner_angle_deg:.0f} degrees)"
    return f"{imbalance}; no steady motion was found, which need not mean that there is none"


def torque_table(
    runs: pd.DataFrame, oils: Sequence[OilInBearing], settings: Settings
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Measured plateaus against every load variable, and the traction of each by inversion.

    Args:
        runs: Table of torque runs; refused plateaus are left out.
        oils: Oils with their laws.
        settings: The settings.

    Returns:
        The tables `torque` and `torque_inversion`.
    """
    bearing = settings.tested_bearing()
    accepted = runs[runs["accepted"]]
    torque: list[pd.DataFrame] = []
    inversion: list[pd.DataFrame] = []
    for oil in oils:
        plateaus = accepted[accepted["oil"] == oil.name].reset_index(drop=True)
        if len(plateaus):
            by_law = {
                variable: _torque(bearing, plateaus, oil, variable, settings)
                for variable in oil.laws
            }
            torque += by_law.values()
            inversion.append(_inversion(bearing, plateaus, oil, by_law["stress"], settings))
    return joined(torque, "torque"), joined(inversion, "torque_inversion")


def _run(
    bearing: Bearing,
    plateaus: pd.DataFrame,
    oil: OilInBearing,
    load_variable: str,
    traction_factor: Floats = 1.0,
) -> pd.DataFrame:
    """Calculated friction of each plateau."""
    load, speed, temperature = plateaus[[*_POINT[:2], "oil_temperature_c"]].to_numpy().T
    return oil.run(bearing, load, speed, temperature, load_variable, traction_factor)


def _torque(
    bearing: Bearing,
    plateaus: pd.DataFrame,
    oil: OilInBearing,
    load_variable: str,
    settings: Settings,
) -> pd.DataFrame:
    calculated = _run(bearing, plateaus, oil, load_variable)
    terms = oil.assessed(bearing, calculated, settings.seed)
    measured, random = plateaus["torque_n_m"].to_numpy(), plateaus["torque_n_m_se"].to_numpy()
    uncertainty = np.linalg.norm([random, *_calibration_n_m(plateaus, settings)], axis=0)
    difference = terms["torque_n_m"].to_numpy() - measured
    compatibility = difference / np.hypot(terms["torque_n_m_uncertainty"].to_numpy(), uncertainty)
    verdict = np.select(
        [np.isnan(compatibility), np.abs(compatibility) <= _COMPATIBLE],
        ["not known", "compatible"],
        "not compatible",
    )
    load, speed = plateaus["axial_load_n"].to_numpy(), plateaus["inner_speed_rpm"].to_numpy()
    viscosity = oil.oil.kinematic_viscosity_m2_s(plateaus["oil_temperature_c"].to_numpy())
    return terms.assign(
        run_id=plateaus["run_id"],
        first_row=plateaus["first_row"],
        measured_torque_n_m=measured,
        measured_torque_n_m_se=plateaus["torque_n_m_se"],
        measured_torque_n_m_uncertainty=uncertainty,
        relative_error=terms["torque_n_m"] / measured - 1,
        compatibility=compatibility,
        verdict=verdict,
        palmgren_torque_n_m=palmgren_torque_n_m(
            load,
            speed,
            viscosity,
            bearing.pitch_diameter_m,
            bearing.contact_angle_rad,
            oil.settings.palmgren.f0,
            oil.settings.palmgren.f1,
        ),
        skf_torque_n_m=skf_torque_n_m(load, speed, viscosity, bearing.pitch_diameter_m),
        skf_valid=speed * bearing.pitch_diameter_m * MM_PER_M <= oil.settings.skf_pitch_speed_max,
    )


def _inversion(
    bearing: Bearing,
    plateaus: pd.DataFrame,
    oil: OilInBearing,
    by_law: pd.DataFrame,
    settings: Settings,
) -> pd.DataFrame:
    """Traction that gives the measured torque, all of it scaled alike; the other terms stay.

    The torque is calculated for each of `_FACTORS`. Traction coefficient is interpolated linearly
    between the two neighbouring factors whose torques enclose the measured one; of several such
    pairs the one nearest to the law's own factor 1 is taken.
    """
    every = plateaus.loc[np.tile(plateaus.index, len(_FACTORS))]
    calculated = _run(bearing, every, oil, "stress", np.repeat(_FACTORS, len(plateaus)))
    torque, coefficient = (
        calculated[name].to_numpy().reshape(len(_FACTORS), -1)
        for name in ("torque_n_m", "mean_traction_coefficient")
    )
    above = torque - plateaus["torque_n_m"].to_numpy()
    encloses = above[:-1] * above[1:] <= 0
    distance = np.abs(np.log(_FACTORS[:-1] * _FACTORS[1:]))[:, np.newaxis]
    lower = np.where(encloses, distance, np.inf).argmin(axis=0), np.arange(len(plateaus))
    rise, span = np.diff(torque, axis=0)[lower], np.diff(coefficient, axis=0)[lower]
    # of the traction's part in the torque: calibration and the other terms
    terms = [
        relative * by_law[f"{term}_torque_n_m"].to_numpy()
        for term, relative in settings.bearing.term_uncertainty
    ]
    uncertain_n_m = np.linalg.norm([*_calibration_n_m(plateaus, settings), *terms], axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        slope = np.where(rise != 0, span / rise, np.inf)
        value = np.where(encloses.any(axis=0), coefficient[lower], np.nan) - above[lower] * slope
        random = np.abs(slope) * plateaus["torque_n_m_se"].to_numpy()
        systematic = np.abs(slope) * uncertain_n_m
    solved = np.isfinite(value) & np.isfinite(random) & np.isfinite(systematic)
    uncertainty = np.where(solved, np.hypot(random, systematic), np.nan)
    verdict = np.select(
        [~solved, uncertainty < value], ["no solution", "determined"], "undetermined"
    )
    return by_law.assign(
        traction_share=by_law["traction_torque_n_m"] / by_law["torque_n_m"],
        law_traction_coefficient=by_law["mean_traction_coefficient"],
        traction_coefficient=np.where(solved, value, np.nan),
        traction_coefficient_se=np.where(solved, random, np.nan),
        traction_coefficient_systematic=np.where(solved, systematic, np.nan),
        verdict=verdict,
    )


def _calibration_n_m(plateaus: pd.DataFrame, settings: Settings) -> list[FloatArray]:
    """Standard uncertainties of the measured torque by the sensor's offset and its gain."""
    calibration = present(settings.campaign.torque, "torque", "the campaign").calibration
    torque = plateaus["torque_n_m"].to_numpy()
    return [np.full(len(torque), calibration.torque_n_m), calibration.torque_relative * torque]


def cage_slip_table(oils: Sequence[OilInBearing], settings: Settings) -> pd.DataFrame:
    """Cage slip of each oil over speed and axial load, by `bearing.cage_slip`."""
    bearing, cage_slip = settings.tested_bearing(), settings.bearing.cage_slip
    grid = np.meshgrid(cage_slip.pitch_speed_mm_rpm, cage_slip.axial_load_n, indexing="ij")
    pitch_speed, load = (levels.ravel() for levels in grid)
    speed = pitch_speed / (bearing.pitch_diameter_m * MM_PER_M)
    maps = (oil.run(bearing, load, speed, cage_slip.inlet_temperature_c) for oil in oils)
    return joined(
        (
            oil.assessed(bearing, calculated, settings.seed).assign(pitch_speed_mm_rpm=pitch_speed)
            for oil, calculated in zip(oils, maps, strict=True)
        ),
        "cage_slip",
    )


def size_effect_table(oils: Sequence[OilInBearing], settings: Settings) -> pd.DataFrame:
    """Every load variable on balls of other sizes and closer grooves, by `bearing.size_effect`."""
    return joined((part for oil in oils for part in _size_effect(oil, settings)), "size_effect")


def _size_effect(oil: OilInBearing, settings: Settings) -> Iterator[pd.DataFrame]:
    bearing, study = settings.tested_bearing(), settings.bearing.size_effect
    sizes = [("ball size", _scaled(bearing, size), size) for size in study.ball_size_factors]
    grooves = [
        ("conformity", replace(bearing, groove_curvature=(groove, groove)), 1.0)
        for groove in study.groove_curvatures
    ]
    for varied, changed, factor in sizes + grooves:
        point = (
            study.axial_load_n * factor**2,
            study.inner_speed_rpm / factor,
            study.inlet_temperature_c,
        )
        by_law = {variable: oil.run(changed, *point, variable) for variable in oil.laws}
        by_stress = by_law["stress"]["traction_torque_n_m"]
        for terms in by_law.values():
            yield terms.assign(
                varied=varied,
                ball_diameter_mm=changed.ball_diameter_m * MM_PER_M,
                groove_curvature=changed.groove_curvature[0],
                relative_to_stress=terms["traction_torque_n_m"] / by_stress - 1,
            )


def _scaled(bearing: Bearing, factor: float) -> Bearing:
    """A bearing with all lengths in proportion, but for the roughness."""
    cage = bearing.cage
    return replace(
        bearing,
        ball_diameter_m=factor * bearing.ball_diameter_m,
        pitch_diameter_m=factor * bearing.pitch_diameter_m,
        cage=replace(
            cage,
            land_diameter_m=factor * cage.land_diameter_m,
            land_width_m=factor * cage.land_width_m,
            land_clearance_m=factor * cage.land_clearance_m,
        ),
    )


def joined(parts: Iterable[pd.DataFrame], table: str) -> pd.DataFrame:
    """Parts of a table below each other, with the columns of its declaration alone."""
    frames = list(parts)
    whole = pd.concat(frames, ignore_index=True) if frames else tables.empty(table)
    return tables.conform(whole[tables.columns(table)], table, f"table {table}")
