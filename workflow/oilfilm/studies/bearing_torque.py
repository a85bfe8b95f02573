"""A fitted traction law in bearings: tables of torque, inversion, cage slip and size effect."""

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from oilfilm import tables
from oilfilm.bearing.catalogue_torque import palmgren_torque_n_m, skf_torque_n_m
from oilfilm.bearing.ellipse import Conditions, TractionBasis
from oilfilm.bearing.geometry import Bearing
from oilfilm.bearing.quasistatic import OperatingPoints
from oilfilm.bearing.resistance import Lubrication
from oilfilm.bearing.torque import torque_terms
from oilfilm.fitting.fitted import FittedLaw
from oilfilm.physics.oils import Oil
from oilfilm.physics.rigs import Contact
from oilfilm.settings.base import present
from oilfilm.settings.config import BearingSettings
from oilfilm.settings.reference import PublishedPowerLoss
from oilfilm.settings.resolved import Settings
from oilfilm.studies.law_comparison import laws_of
from oilfilm.studies.load_variables import BASES, LOAD_LAWS, FittedBasis
from oilfilm.units import MM_PER_M, RAD_S_PER_RPM, FloatArray

_TESTED = ("max_hertz_pressure_gpa", "entrainment_speed_m_s", "slide_roll_ratio")


# Coefficients and fit quality of further laws, as the comparison of laws makes them.
OtherFits = tuple[pd.DataFrame, pd.DataFrame] | None


@dataclass(frozen=True)
class OilInBearing:
    """One oil as bearings know it: its properties, its fitted laws and the rig behind them.

    Attributes:
        name: As in config/oils.
        oil: Its properties.
        laws: Fitted law by basis; each of `BASES` has the campaign's own.
        rig: Contact of the traction rig.
        tested: Lowest and highest tested level of pressure, speed and slip; NaN where unknown.
        settings: The settings' `bearing`.
    """

    name: str
    oil: Oil
    laws: Mapping[str, FittedLaw]
    rig: Contact
    tested: Mapping[str, tuple[float, float]]
    settings: BearingSettings

    @classmethod
    def of(
        cls,
        name: str,
        coefficients: pd.DataFrame,
        quality: pd.DataFrame,
        settings: Settings,
        others: OtherFits = None,
    ) -> "OilInBearing | None":
        """The oil; None where its law, its properties or its rig are not known."""
        # by load a law means the ball of its rig: of several, one and the same
        rig, oil = settings.common_contact(), settings.properties_of(name)
        fitted = FittedLaw.of(coefficients, name, quality=quality)
        if rig is None or oil is None or np.isnan(fitted.coefficients.constants).any():
            return None
        laws = dict.fromkeys(BASES, fitted)
        if others is not None:
            laws |= _load_laws(name, *others, settings)
        row = quality[(quality["oil"] == name) & (quality["law"] == fitted.law.name)].iloc[0]
        tested = {
            of: (float(row[f"tested_min_{of}"]), float(row[f"tested_max_{of}"])) for of in _TESTED
        }
        return cls(name, oil, laws, rig, tested, settings.bearing)

    def basis(self, basis: str) -> FittedBasis:
        """The fitted law on a basis."""
        return FittedBasis(self.laws[basis], basis, self.rig, self.settings.law_floor.model_dump())

    def run(
        self,
        bearing: Bearing,
        axial_load_n: FloatArray,
        speed_rpm: FloatArray,
        inlet_temperature_c: FloatArray,
        law: TractionBasis,
    ) -> pd.DataFrame:
        """Friction at operating points, columns as of the tables of bearing friction."""
        points = OperatingPoints.axial(axial_load_n, speed_rpm * RAD_S_PER_RPM)
        lubrication = Lubrication.of(
            self.oil,
            inlet_temperature_c,
            self.settings.drag_coefficient,
            self.settings.oil_volume_fraction,
        )
        return _without_failures(torque_terms(bearing, points, lubrication, law, self.tested))


def _load_laws(
    oil: str, coefficients: pd.DataFrame, quality: pd.DataFrame, settings: Settings
) -> dict[str, FittedLaw]:
    """The laws on load that were fitted to an oil's points as well, by name."""
    known = laws_of(oil, settings)
    fitted = set(coefficients.loc[coefficients["oil"] == oil, "law"]) & set(known)
    laws = {
        name: FittedLaw.of(coefficients, oil, quality=quality, law=known[name])
        for name in LOAD_LAWS
        if name in fitted
    }
    return {
        name: law for name, law in laws.items() if not np.isnan(law.coefficients.constants).any()
    }


def _without_failures(terms: Mapping[str, FloatArray]) -> pd.DataFrame:
    """Null where there is no equilibrium, with the reason."""
    found, residual = terms["converged"].astype(bool), terms["residual"]
    known = zip(residual, terms["inner_contact_angle_deg"], terms["widest_contact"], strict=True)
    why = ["" if fine else _why(*told) for fine, told in zip(found, known, strict=True)]
    about = {
        "converged": found,
        "residual": np.where(residual < _LARGEST_RESIDUAL, residual, np.nan),
        "why": np.array(why, dtype=object),
    }
    cleared = {name: np.where(found, values, np.nan) for name, values in terms.items()}
    return pd.DataFrame(cleared | about)


# Of a ball's load; a trial beyond it is no number worth a table.
_LARGEST_RESIDUAL = 1e9
# Beyond this inner contact angle no groove is left for the ball to lie in.
_SHOULDER_DEG = 65.0


def _why(residual: float, inner_angle_deg: float, widest_contact: float) -> str:
    if widest_contact >= 1:
        return (
            f"the contacts would be {widest_contact:.2g} times as wide as the balls; check the "
            "axial load and its unit"
        )
    found = f"forces stay {residual:.2g} of a ball's load out of balance"
    if inner_angle_deg > _SHOULDER_DEG:
        return f"{found}; the ball climbs the inner shoulder ({inner_angle_deg:.0f} degrees)"
    return f"{found}; no steady motion was found, which need not mean that there is none"


def torque_table(
    runs: pd.DataFrame,
    coefficients: pd.DataFrame,
    quality: pd.DataFrame,
    settings: Settings,
    others: OtherFits = None,
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Measured plateaus against every basis, and the traction that each plateau has by inversion.

    Args:
        runs: Table of torque runs; refused plateaus are left out.
        coefficients: Table of coefficients.
        quality: Table of fit quality.
        settings: The settings.
        others: Fits of further laws; those on load are compared as well.

    Returns:
        The tables `torque` and `torque_inversion`.
    """
    bearing = settings.tested_bearing()
    accepted = runs[runs["accepted"]]
    torque: list[pd.DataFrame] = []
    inversion: list[pd.DataFrame] = []
    for known in _known_oils(coefficients, quality, settings, others):
        rows = accepted[accepted["oil"] == known.name].reset_index(drop=True)
        if len(rows):
            of_basis = {basis: _torque(bearing, rows, known, basis) for basis in known.laws}
            torque += of_basis.values()
            inversion.append(_inversion(bearing, rows, known, of_basis["stress"], settings))
    return _table(torque, "torque"), _table(inversion, "torque_inversion")


def _conditions(rows: pd.DataFrame) -> tuple[FloatArray, FloatArray, FloatArray]:
    return (
        rows["axial_load_n"].to_numpy(),
        rows["inner_speed_rpm"].to_numpy(),
        rows["oil_temperature_c"].to_numpy(),
    )


def _torque(bearing: Bearing, rows: pd.DataFrame, known: OilInBearing, basis: str) -> pd.DataFrame:
    load, speed, temperature = _conditions(rows)
    terms = known.run(bearing, load, speed, temperature, known.basis(basis))
    viscosity = known.oil.kinematic_viscosity_m2_s(temperature)
    palmgren = known.settings.palmgren
    return terms.assign(
        run_id=rows["run_id"],
        first_row=rows["first_row"],
        oil=known.name,
        bearing=bearing.name,
        load_variable=basis,
        inner_speed_rpm=speed,
        axial_load_n=load,
        inlet_temperature_c=temperature,
        measured_torque_n_m=rows["torque_n_m"],
        measured_torque_n_m_se=rows["torque_n_m_se"],
        relative_error=terms["torque_n_m"] / rows["torque_n_m"] - 1,
        palmgren_torque_n_m=palmgren_torque_n_m(
            load,
            speed,
            viscosity,
            bearing.pitch_diameter_m,
            bearing.contact_angle_rad,
            palmgren.f0,
            palmgren.f1,
        ),
        skf_torque_n_m=skf_torque_n_m(load, speed, viscosity, bearing.pitch_diameter_m),
    )


@dataclass(frozen=True)
class _Scaled:
    """A law with all traction times one factor."""

    law: TractionBasis
    factor: float

    def __call__(self, at: Conditions, slide_roll_ratio: FloatArray) -> FloatArray:
        return self.factor * self.law(at, slide_roll_ratio)


# Factors on all traction among which that of a measured torque is looked for.
_FACTORS = np.geomspace(1 / 8, 8, 25)


def _inversion(
    bearing: Bearing,
    rows: pd.DataFrame,
    known: OilInBearing,
    by_law: pd.DataFrame,
    settings: Settings,
) -> pd.DataFrame:
    """Traction that gives the measured torque, all of it scaled alike; the other terms stay.

    The torque is calculated for a row of factors. Between the two next to each other, nearest to
    the law's own 1, that have the measured torque between them, factor and traction coefficient
    are interpolated.
    """
    load, speed, temperature = _conditions(rows)
    law = known.basis("stress")
    tried = [
        known.run(bearing, load, speed, temperature, _Scaled(law, factor)) for factor in _FACTORS
    ]
    torque = np.stack([one["torque_n_m"].to_numpy() for one in tried])
    coefficient = np.stack([one["mean_traction_coefficient"].to_numpy() for one in tried])
    above = torque - rows["torque_n_m"].to_numpy()
    crossing = above[:-1] * above[1:] <= 0
    away = np.abs(np.log(_FACTORS[:-1] * _FACTORS[1:]))[:, np.newaxis]
    place = np.where(crossing, away, np.inf).argmin(axis=0)
    each = np.arange(len(rows))
    rise, span = np.diff(torque, axis=0)[place, each], np.diff(coefficient, axis=0)[place, each]
    found = np.where(crossing.any(axis=0), coefficient[place, each], np.nan)
    with np.errstate(divide="ignore", invalid="ignore"):
        slope = np.where(rise != 0, span / rise, np.inf)
        value = found - above[place, each] * slope
        random = np.abs(slope) * rows["torque_n_m_se"].to_numpy()
        systematic = np.abs(slope) * _systematic_n_m(rows, by_law, settings)
    whole = np.isfinite(value) & np.isfinite(random) & np.isfinite(systematic)
    doubt = np.where(whole, np.hypot(random, systematic), np.nan)
    verdict = np.where(whole, np.where(doubt < value, "determined", "undetermined"), "no solution")
    return pd.DataFrame(
        {
            "run_id": rows["run_id"],
            "first_row": rows["first_row"],
            "oil": known.name,
            "inner_speed_rpm": speed,
            "axial_load_n": load,
            "inlet_temperature_c": temperature,
            "traction_share": by_law["traction_torque_n_m"] / by_law["torque_n_m"],
            "law_traction_coefficient": by_law["mean_traction_coefficient"],
            "traction_coefficient": np.where(whole, value, np.nan),
            "traction_coefficient_se": np.where(whole, random, np.nan),
            "traction_coefficient_systematic": np.where(whole, systematic, np.nan),
            "verdict": verdict,
        }
    )


def _systematic_n_m(rows: pd.DataFrame, by_law: pd.DataFrame, settings: Settings) -> FloatArray:
    """Standard uncertainty of the traction's part in the torque, calibration and other terms."""
    calibration = present(settings.campaign.torque, "torque", "the campaign").calibration
    parts = [
        calibration.torque_n_m + 0 * rows["torque_n_m"],
        calibration.torque_relative * rows["torque_n_m"],
        *(
            relative * by_law[f"{term}_torque_n_m"]
            for term, relative in settings.bearing.term_uncertainty
        ),
    ]
    return np.sqrt(np.sum(np.square(np.array(parts, dtype=float)), axis=0))


def cage_slip_table(
    coefficients: pd.DataFrame, quality: pd.DataFrame, settings: Settings
) -> pd.DataFrame:
    """Cage slip of each oil over speed and axial load, by `bearing.cage_slip`."""
    return _table(
        (_cage_slip(known, settings) for known in _known_oils(coefficients, quality, settings)),
        "cage_slip",
    )


def _known_oils(
    coefficients: pd.DataFrame,
    quality: pd.DataFrame,
    settings: Settings,
    others: OtherFits = None,
) -> Iterator[OilInBearing]:
    for oil in settings.oils:
        known = OilInBearing.of(oil, coefficients, quality, settings, others)
        if known is not None:
            yield known


def _cage_slip(known: OilInBearing, settings: Settings) -> pd.DataFrame:
    bearing, cage_slip = settings.tested_bearing(), settings.bearing.cage_slip
    pitch_speed, load = (
        grid.ravel()
        for grid in np.meshgrid(cage_slip.pitch_speed_mm_rpm, cage_slip.axial_load_n, indexing="ij")
    )
    speed = pitch_speed / (bearing.pitch_diameter_m * MM_PER_M)
    temperature = np.full(len(speed), cage_slip.inlet_temperature_c)
    terms = known.run(bearing, load, speed, temperature, known.basis("stress"))
    return terms.assign(
        oil=known.name,
        bearing=bearing.name,
        pitch_speed_mm_rpm=pitch_speed,
        inner_speed_rpm=speed,
        axial_load_n=load,
        inlet_temperature_c=temperature,
    )


def size_effect_table(
    coefficients: pd.DataFrame,
    quality: pd.DataFrame,
    settings: Settings,
    others: OtherFits = None,
) -> pd.DataFrame:
    """Every basis on balls of other sizes and closer grooves, by `bearing.size_effect`."""
    return _table(
        (
            part
            for known in _known_oils(coefficients, quality, settings, others)
            for part in _size_effect(known, settings)
        ),
        "size_effect",
    )


def _size_effect(known: OilInBearing, settings: Settings) -> Iterator[pd.DataFrame]:
    bearing, asked = settings.tested_bearing(), settings.bearing.size_effect
    varied = [
        ("ball size", _scaled(bearing, factor), factor) for factor in asked.ball_size_factors
    ] + [
        ("conformity", replace(bearing, groove_curvature=(groove, groove)), 1.0)
        for groove in asked.groove_curvatures
    ]
    for what, changed, factor in varied:
        load = np.array([asked.axial_load_n * factor**2])
        speed = np.array([asked.inner_speed_rpm / factor])
        temperature = np.array([asked.inlet_temperature_c])
        of_basis = {
            basis: known.run(changed, load, speed, temperature, known.basis(basis))
            for basis in known.laws
        }
        by_stress = of_basis["stress"]["traction_torque_n_m"]
        for basis, terms in of_basis.items():
            yield terms.assign(
                oil=known.name,
                bearing=bearing.name,
                varied=what,
                ball_diameter_mm=changed.ball_diameter_m * MM_PER_M,
                groove_curvature=changed.groove_curvature[0],
                load_variable=basis,
                axial_load_n=load,
                inner_speed_rpm=speed,
                inlet_temperature_c=temperature,
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


def power_loss_table(
    published: PublishedPowerLoss,
    coefficients: pd.DataFrame,
    quality: pd.DataFrame,
    settings: Settings,
) -> pd.DataFrame:
    """Published power loss of a bearing beside the calculated one.

    Args:
        published: Content of data/reference/power_loss.yaml.
        coefficients: Table of coefficients.
        quality: Table of fit quality.
        settings: The settings.
    """
    of_name = {one.name: one for one in _known_oils(coefficients, quality, settings)}
    name = published.bearing
    if published.oil not in of_name or name not in settings.bearings:
        return tables.empty("power_loss")
    known = of_name[published.oil]
    bearing = settings.bearings[name].bearing(name)
    speed, power = np.array(published.rows).T
    load = np.full(len(speed), published.axial_load_n)
    temperature = np.full(len(speed), published.inlet_temperature_c)
    terms = known.run(bearing, load, speed, temperature, known.basis("stress"))
    about = terms.assign(
        bearing=name,
        oil=known.name,
        inner_speed_rpm=speed,
        axial_load_n=load,
        inlet_temperature_c=temperature,
        published_power_w=power,
        power_w=terms["torque_n_m"] * speed * RAD_S_PER_RPM,
    )
    return _table([about], "power_loss")


def _table(parts: Iterable[pd.DataFrame], table: str) -> pd.DataFrame:
    frames = list(parts)
    whole = pd.concat(frames, ignore_index=True) if frames else tables.empty(table)
    return tables.conform(whole[tables.columns(table)], table, f"table {table}")
