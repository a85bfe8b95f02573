"""A fitted traction law in bearings: tables of torque, inversion, cage slip and size effect."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas as pd
import scipy

from oilfilm import tables
from oilfilm.bearing.equilibria import Neighbour, equilibria, friction_equilibrium
from oilfilm.bearing.friction import FrictionEquilibrium, FrictionProblem
from oilfilm.bearing.geometry import Bearing, Cage
from oilfilm.bearing.quasistatic import OperatingPoints
from oilfilm.bearing.resistance import TERMS, Lubrication
from oilfilm.bearing.torque import palmgren_torque_n_m, skf_torque_n_m, torque_terms
from oilfilm.fits.fit import laws_of
from oilfilm.fits.fitted import FittedLaw
from oilfilm.physics.contact import Floats
from oilfilm.physics.oils import Oil
from oilfilm.settings.base import present
from oilfilm.settings.config import BearingSettings
from oilfilm.settings.resolved import Settings
from oilfilm.ties import first_smallest, reaches
from oilfilm.torque.best_oil import best_shares
from oilfilm.torque.load_variables import LOAD_VARIABLES, LawInBearing, law_of_groups
from oilfilm.torque.torque_uncertainty import drawn, term_factors, with_uncertainty
from oilfilm.traction import BEARING_LAW_NAMES
from oilfilm.units import MM_PER_M, RAD_S_PER_RPM, BoolArray, FloatArray, IndexArray

_POINT = ["axial_load_n", "inner_speed_rpm", "inlet_temperature_c"]
_TESTED = ("max_hertz_pressure_gpa", "entrainment_speed_m_s", "slide_roll_ratio")
# Of a ball's load; a larger residual is no number worth a table.
_LARGEST_RESIDUAL = 1e9
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
        """Friction at operating points, one row per point; see `Cases.run`.

        Args:
            bearing: The bearing.
            axial_load_n: Axial load.
            inner_speed_rpm: Speed of the inner ring.
            inlet_temperature_c: Temperature of the oil.
            load_variable: Key of `laws`.
            traction_factor: Factor on all traction.
        """
        given = np.atleast_1d(axial_load_n), inner_speed_rpm, inlet_temperature_c, traction_factor
        names = (*_POINT, "traction_factor")
        points = pd.DataFrame(dict(zip(names, np.broadcast_arrays(*given), strict=True)))
        return Cases(bearing, [(self, load_variable, points)]).run()


class Cases:
    """Operating points of one bearing, each with an oil and a load variable, solved together.

    Attributes:
        oils: Oil of each group of points.
        laws: Its law.
        points: One row per point: `oil`, `bearing`, `load_variable`, what the groups have, and
            where they have it `traction_factor`, a factor on all traction.
        problem: The same points for the solver.
    """

    def __init__(
        self, bearing: Bearing, groups: Sequence[tuple[OilInBearing, str, pd.DataFrame]]
    ) -> None:
        """Cases by groups.

        Args:
            bearing: The bearing.
            groups: Oil, load variable and operating points: columns axial_load_n, inner_speed_rpm,
                inlet_temperature_c and any other.
        """
        self.oils = [oil for oil, _, _ in groups]
        self.laws = [oil.laws[variable] for oil, variable, _ in groups]
        named = [
            points.assign(oil=oil.name, bearing=bearing.name, load_variable=variable)
            for oil, variable, points in groups
        ]
        self.points = pd.concat(named, ignore_index=True)
        load, speed, _ = self.points[_POINT].to_numpy(dtype=float).T
        lubrication = Lubrication.joined(
            [
                Lubrication.of(
                    oil.oil,
                    points["inlet_temperature_c"].to_numpy(dtype=float),
                    oil.settings.drag_coefficient,
                    oil.settings.oil_volume_fraction,
                )
                for oil, _, points in groups
            ]
        )
        self._sizes = [len(points) for points in named]
        if "traction_factor" in self.points:
            lubrication = lubrication.with_traction(self.points["traction_factor"].to_numpy())
        law = law_of_groups(self.laws, self._sizes)
        turning = OperatingPoints.axial(load, speed * RAD_S_PER_RPM)
        self.problem = FrictionProblem(bearing, turning, lubrication, law)

    def run(self, neighbour: Neighbour | None = None) -> pd.DataFrame:
        """Friction at every point, with the columns of `torque_terms`; null without equilibrium.

        Args:
            neighbour: See `friction_equilibrium`.
        """
        return self._terms(friction_equilibrium(self.problem, neighbour))

    def _terms(self, found: FrictionEquilibrium) -> pd.DataFrame:
        ends = {
            name: np.repeat([oil.tested[name] for oil in self.oils], self._sizes, axis=0).T
            for name in _TESTED
        }
        ratio = np.repeat([oil.oil.limiting_stress_ratio for oil in self.oils], self._sizes)
        terms = _without_failures(torque_terms(found, ends, ratio))
        long_term, peak = self.oils[0].settings.pressure_limits_gpa
        pressure = terms.filter(regex="max_hertz_pressure_gpa").max(axis=1)
        terms["pressure_verdict"] = np.select(
            [np.isnan(pressure), pressure > peak, pressure > long_term],
            ["not known", "above peak", "above long-term"],
            "within",
        )
        return terms.join(self.points[self.points.columns.difference(terms.columns)])

    def assessed(self, seed: int) -> tuple[pd.DataFrame, FloatArray]:
        """What `run` calculates, with its uncertainty and the other equilibrium; and the draws.

        Args:
            seed: Of the configuration.

        Returns:
            See `with_uncertainty`; besides `equilibria`, `other_cage_slip`, `other_torque_n_m` and
            `bistable`. The draws are as of `torque_uncertainty.drawn`.
        """
        motions = equilibria(self.problem)
        found = motions.fastest
        calculated = self._terms(found)
        named = zip(self.oils, self.laws, strict=True)
        groups = [(oil.name, oil.oil, law) for oil, law in named]
        number = np.repeat(np.arange(len(groups)), self._sizes)
        draws = drawn(found, groups, number, calculated, self.oils[0].settings, seed)
        terms = with_uncertainty(calculated, draws, self.problem.points.ring_speed_rad_s[:, 0])
        several = motions.count > 1
        certain = (motions.count > 0) & (motions.complete | several)
        known = pd.Series(several, terms.index, dtype="boolean").where(certain)
        # one of the two is enough for true; false takes both
        terms["bistable"] = known | terms["draws_split"]
        terms["equilibria"] = motions.count
        terms["other_cage_slip"] = np.where(several, motions.slowest.cage_slip(), np.nan)
        terms["other_torque_n_m"] = np.where(several, motions.slowest.torque_n_m(), np.nan)
        return terms, draws


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
    # once, as the table is long
    spread = {} if refits is None else dict(iter(refits.groupby(["oil", "law"])))
    oils = []
    configured = {row["oil"]: row for row in tables.rows(quality[quality["configured"]])}
    for name in settings.oils:
        oil = settings.properties_of(name)
        if oil is None or name not in configured:
            continue
        row, known = configured[name], laws_of(name, settings)
        fitted = set(coefficients.loc[coefficients["oil"] == name, "law"])
        law_names = {variable: row["law"] for variable in LOAD_VARIABLES}
        law_names |= {law: law for law in BEARING_LAW_NAMES if law in fitted and law in known}
        fits = {
            law: FittedLaw.of(coefficients, name, spread.get((name, law)), quality, known[law])
            for law in set(law_names.values())
        }
        laws = {
            variable: LawInBearing.of(fits[law], variable, rig, floor)
            for variable, law in law_names.items()
            # the conditions of a bearing are not those of the tests
            if fits[law].coefficients.known.all()
            and not np.isnan(fits[law].coefficients.constants).any()
        }
        if "stress" in laws:
            tested = {
                level: (float(row[f"tested_min_{level}"]), float(row[f"tested_max_{level}"]))
                for level in _TESTED
            }
            oils.append(OilInBearing(name, oil, laws, tested, settings.bearing))
    return oils


def _without_failures(terms: Mapping[str, FloatArray]) -> pd.DataFrame:
    """Null where there is no equilibrium, with the reason."""
    converged, residual = terms["converged"].astype(bool), terms["residual"]
    cleared = {name: np.where(converged, values, np.nan) for name, values in terms.items()}
    widest = [
        f"the contacts would be {wide:.2g} times as wide as the balls; check the axial load "
        "and its unit"
        for wide in terms["widest_contact"]
    ]
    imbalance = [
        f"forces stay {left:.2g} of a ball's load out of balance; no steady motion was found"
        for left in residual
    ]
    why = np.select([converged, terms["widest_contact"] >= 1], ["", widest], imbalance)
    return pd.DataFrame(cleared).assign(
        converged=converged,
        **{name: _known_flag(terms[name], converged) for name in ("held_by_band", "outside_law")},
        film_in_range=converged & terms["film_in_range"].astype(bool),
        residual=np.where(residual < _LARGEST_RESIDUAL, residual, np.nan),
        why=np.array(why, dtype=object),
    )


def _known_flag(flag: FloatArray, known: BoolArray) -> "pd.Series[bool]":
    """A flag that is null where it is not known."""
    return pd.Series(flag.astype(bool), dtype="boolean").where(known)


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
    measured = runs.loc[runs["accepted"], ["run_id", "first_row", "oil", *_POINT[:2]]].assign(
        inlet_temperature_c=runs["oil_temperature_c"],
        measured_torque_n_m=runs["torque_n_m"],
        measured_torque_n_m_se=runs["torque_n_m_se"],
    )
    of_oils = [(oil, measured[measured["oil"] == oil.name]) for oil in oils]
    of_oils = [(oil, plateaus) for oil, plateaus in of_oils if len(plateaus)]
    if not of_oils:
        return tables.empty("torque"), tables.empty("torque_inversion")
    bearing = settings.tested_bearing()
    cases = Cases(
        bearing, [(oil, variable, rows) for oil, rows in of_oils for variable in oil.laws]
    )
    terms, _ = cases.assessed(settings.seed)
    terms = _compared(bearing, terms, {oil.name: oil for oil, _ in of_oils}, settings)
    inversion = _inversion(bearing, [oil for oil, _ in of_oils], terms, settings)
    return joined([terms], "torque"), joined([inversion], "torque_inversion")


def _compared(
    bearing: Bearing, terms: pd.DataFrame, oils: Mapping[str, OilInBearing], settings: Settings
) -> pd.DataFrame:
    """Calculated torque beside the measured one and beside the catalogues' estimates."""
    uncertainty = np.hypot(
        terms["measured_torque_n_m_se"].to_numpy(), _calibration_n_m(terms, settings)
    )
    difference = terms["torque_n_m"] - terms["measured_torque_n_m"]
    compatibility = difference / np.hypot(terms["torque_n_m_uncertainty"], uncertainty)
    verdict = np.select(
        [np.isnan(compatibility), np.abs(compatibility) <= _COMPATIBLE],
        ["not known", "compatible"],
        "not compatible",
    )
    load, speed, temperature = terms[_POINT].to_numpy().T
    viscosity = np.empty(len(terms))
    for name, oil in oils.items():
        of_oil = terms["oil"].to_numpy() == name
        viscosity[of_oil] = oil.oil.kinematic_viscosity_m2_s(temperature[of_oil])
    pitch, palmgren = bearing.pitch_diameter_m, settings.bearing.palmgren
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
    """Traction that gives the measured torque, all of it scaled alike; the other terms stay.

    The torque is calculated for each of `_FACTORS`. Traction coefficient is interpolated linearly
    between the two neighbouring factors whose torques enclose the measured one; of several such
    pairs the one nearest to the law's own factor 1 is taken, of two as near the weaker one.
    """
    by_law = terms[terms["load_variable"] == "stress"].reset_index(drop=True)
    every = by_law.loc[np.repeat(by_law.index, len(_FACTORS)), ["oil", *_POINT]]
    every = every.assign(traction_factor=np.tile(_FACTORS, len(by_law)))
    calculated = Cases(
        bearing, [(oil, "stress", every[every["oil"] == oil.name]) for oil in oils]
    ).run()
    torque, coefficient = (
        calculated[name].to_numpy().reshape(-1, len(_FACTORS)).T
        for name in ("torque_n_m", "mean_traction_coefficient")
    )
    above = torque - by_law["measured_torque_n_m"].to_numpy()
    encloses = above[:-1] * above[1:] <= 0
    lower = _nearest_pair(encloses), np.arange(len(by_law))
    rise, span = np.diff(torque, axis=0)[lower], np.diff(coefficient, axis=0)[lower]
    # of the traction's part in the torque: calibration and the other terms
    # the middles of many equal slices of the normal distribution
    normal = scipy.special.ndtri((np.arange(1000) + 0.5) / 1000)[:, np.newaxis]
    spread = term_factors(settings.bearing, np.repeat(normal, len(TERMS), axis=1)).std(axis=0)
    others = [
        relative * by_law[f"{term}_torque_n_m"].to_numpy()
        for term, relative in zip(TERMS, spread, strict=True)
    ]
    uncertain_n_m = np.linalg.norm([_calibration_n_m(by_law, settings), *others], axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        slope = np.where(rise != 0, span / rise, np.inf)
        value = np.where(encloses.any(axis=0), coefficient[lower], np.nan) - above[lower] * slope
        random = np.abs(slope) * by_law["measured_torque_n_m_se"].to_numpy()
        systematic = np.abs(slope) * uncertain_n_m
    found = np.stack([value, random, systematic])
    solved = np.isfinite(found).all(axis=0)
    names = ("traction_coefficient", "traction_coefficient_se", "traction_coefficient_systematic")
    verdict = np.select(
        [~solved, np.hypot(random, systematic) < value],
        ["no solution", "determined"],
        "undetermined",
    )
    return by_law.assign(
        **dict(zip(names, np.where(solved, found, np.nan), strict=True)),
        traction_share=by_law["traction_torque_n_m"] / by_law["torque_n_m"],
        law_traction_coefficient=by_law["mean_traction_coefficient"],
        verdict=verdict,
    )


def _nearest_pair(encloses: BoolArray) -> IndexArray:
    """Index of the pair of neighbouring `_FACTORS` nearest to 1 of those that enclose a torque.

    Pairs on both sides of 1 are equally near but for rounding: the lower one is taken.

    Args:
        encloses: Whether each pair does, shape (pairs, plateaus).
    """
    distance = np.abs(np.log(_FACTORS[:-1] * _FACTORS[1:]))[:, np.newaxis]
    return first_smallest(np.where(encloses, distance, np.inf), axis=0)


def _calibration_n_m(terms: pd.DataFrame, settings: Settings) -> FloatArray:
    """Standard uncertainty of the measured torque by the sensor's offset and its gain."""
    calibration = present(settings.campaign.torque, "torque", "the campaign").calibration
    gain = calibration.torque_relative * terms["measured_torque_n_m"].to_numpy()
    return np.hypot(calibration.torque_n_m, gain)


def cage_slip_table(oils: Sequence[OilInBearing], settings: Settings) -> pd.DataFrame:
    """Cage slip of each oil over speed and axial load, by `bearing.cage_slip`."""
    if not oils:
        return tables.empty("cage_slip")
    bearing, cage_slip = settings.tested_bearing(), settings.bearing.cage_slip
    grid = np.meshgrid(cage_slip.pitch_speed_mm_rpm, cage_slip.axial_load_n, indexing="ij")
    pitch_speed, load = (levels.ravel() for levels in grid)
    points = pd.DataFrame({"axial_load_n": load, "pitch_speed_mm_rpm": pitch_speed}).assign(
        inner_speed_rpm=pitch_speed / (bearing.pitch_diameter_m * MM_PER_M),
        inlet_temperature_c=cage_slip.inlet_temperature_c,
    )
    cases = Cases(bearing, [(oil, "stress", points) for oil in oils])
    terms, draws = cases.assessed(settings.seed)
    limits = settings.selection.limits.slip_limit, settings.gates.lambda_limit
    return joined([terms.assign(**best_shares(draws, len(oils), *limits))], "cage_slip")


def size_effect_table(oils: Sequence[OilInBearing], settings: Settings) -> pd.DataFrame:
    """Every load variable on balls of other sizes and closer grooves, by `bearing.size_effect`."""
    bearing, study = settings.tested_bearing(), settings.bearing.size_effect
    varied = [("ball size", _scaled(bearing, size), size) for size in study.ball_size_factors]
    varied += [
        ("conformity", replace(bearing, groove_curvature=(groove, groove)), 1.0)
        for groove in study.groove_curvatures
    ]
    parts = []
    for name, changed, factor in varied if oils else ():
        point = pd.DataFrame(
            {
                "axial_load_n": [study.axial_load_n * factor**2],
                "inner_speed_rpm": study.inner_speed_rpm / factor,
                "inlet_temperature_c": study.inlet_temperature_c,
            }
        )
        groups = [(oil, variable, point) for oil in oils for variable in oil.laws]
        terms = Cases(changed, groups).run()
        traction = terms.set_index(["oil", "load_variable"])["traction_torque_n_m"]
        by_stress = traction.xs("stress", level="load_variable")[terms["oil"]].to_numpy()
        parts.append(
            terms.assign(
                varied=name,
                ball_diameter_mm=changed.ball_diameter_m * MM_PER_M,
                groove_curvature=changed.groove_curvature[0],
                relative_to_stress=terms["traction_torque_n_m"] / by_stress - 1,
            )
        )
    table = joined(parts, "size_effect")
    places = {oil.name: place for place, oil in enumerate(oils)}
    return table.sort_values(
        "oil", key=lambda names: names.map(places), kind="stable", ignore_index=True
    )


def _scaled(bearing: Bearing, factor: float) -> Bearing:
    """A bearing with all lengths in proportion, but for the roughness."""

    def times(part: Bearing | Cage, *names: str) -> dict[str, Any]:
        return {name: factor * getattr(part, name) for name in names}

    lengths = times(bearing.cage, "land_diameter_m", "land_width_m", "land_clearance_m")
    sizes = times(bearing, "ball_diameter_m", "pitch_diameter_m")
    return replace(bearing, **sizes, cage=replace(bearing.cage, **lengths))


def joined(parts: Iterable[pd.DataFrame], table: str) -> pd.DataFrame:
    """Parts of a table below each other, with the columns of its declaration alone."""
    frames = list(parts)
    whole = pd.concat(frames, ignore_index=True) if frames else tables.empty(table)
    return tables.conform(whole[tables.columns(table)], table, f"table {table}")
