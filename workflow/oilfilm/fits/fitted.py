"""A fitted law, read from its tables: traction at any operating point, with its interval.

Decides: traction at a condition, wherever it is needed, and where it is refused.
"""

import warnings
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, fields, replace
from functools import cached_property, partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import numpy.typing as npt
import pandas as pd
import scipy

from oilfilm import tables
from oilfilm.base.errors import OilfilmError
from oilfilm.base.labels import aligned_arguments
from oilfilm.base.ties import exceeds, reaches
from oilfilm.base.units import FloatArray
from oilfilm.fits.conditions import (
    LEAST_MAGNITUDES,
    FixedCondition,
    fixed_conditions_from_json,
    is_off_tested_level,
)
from oilfilm.fits.interval import CONFIDENCE, Band, spread_degrees_of_freedom, student_half_width
from oilfilm.fits.measured_surface import LawConstants, OilSurface, surface_from_tables
from oilfilm.fits.saved_fit_tables import explaining_contradictions, refuse_contradictions
from oilfilm.fits.soundness_sentences import soundness_warnings
from oilfilm.physics.oils import LIMITING_STRESS_RATIO
from oilfilm.surface.interval import normal_half_width
from oilfilm.surface.support import Support
from oilfilm.tables import refuse_oversized
from oilfilm.tables.campaign_tables import CURVE_COLUMNS, CampaignTables
from oilfilm.traction import LAWS
from oilfilm.traction.law import CONDITIONS, QUANTITIES, Law, to_internal

# Column of the slip, as `CONDITIONS` are the columns of the conditions.
SLIP = "slide_roll_ratio"
# Ends of the two intervals of a prediction: names of attributes, and of columns of tables.
INTERVAL_COLUMNS = ("obs_ci_lower", "obs_ci_upper", "mean_ci_lower", "mean_ci_upper")
# Columns of a prediction that are printed.
_PRINTED_COLUMNS = ["traction_coefficient", *INTERVAL_COLUMNS, "outside"]
# Tables from which a fit is read.
_TABLES_OF_A_FIT = (
    "coefficients",
    "refits",
    "fit_quality",
    "curve_residuals",
    "soundness",
    "points",
    "surfaces",
    "surface_sizes",
)
# Names of `Support` in lower case, by their codes.
_SUPPORT_NAMES = np.array([support.name.lower() for support in Support])
_SUPPORT_NAME_TYPE = _SUPPORT_NAMES.dtype
# Smallest slip at which the error of a law is looked up: a relative error of mu needs mu.
_SMALLEST_SLIP = 0.005
# Number of points at which a law is evaluated at once: about what fits the cache of a processor.
_POINTS_PER_CHUNK = 1 << 14
# Number of points of one of the predictions of `FittedLaw.predictions`.
_POINTS_PREDICTED_AT_ONCE = 100_000


@dataclass(frozen=True)
class Coefficients:
    """Constants of a law in the form of its equation, with their uncertainty and tested range.

    Attributes:
        constants: In the order of the law, NaN where nothing could be fitted. An exponent that
            the data could not give is 0, and X0 is then the coefficient at the tested level.
        group_has_exponent: Whether the fit follows each of the law's groups, shape (groups,).
        refits: Constants of each refit of the bootstrap over curves, shape (refits, constants).
        shifted_refits: Constants refitted with one sensor off by its calibration's uncertainty, one
            row per sensor, shape (sensors, constants).
        tested_box: Smallest and largest tested value of each of the law's conditions and of the
            slip, shape (conditions + 1, 2); NaN where unknown.
        fixed_conditions: The conditions that the fit does not follow, with the tested level or
            line; empty where that is unknown.
        run_sd: Standard deviation of ln mu in the next run, near the tested points; NaN where that
            is unknown.
        degrees_of_freedom: Of the spread of the refits, as `spread_degrees_of_freedom` gives them.
        limiting_stress_ratio: Limiting shear stress of the oil over the pressure.
        tested_conditions: Conditions of each curve, shape (curves, conditions); no rows where
            unknown.
    """

    constants: FloatArray
    group_has_exponent: npt.NDArray[np.bool_]
    refits: FloatArray
    shifted_refits: FloatArray
    tested_box: FloatArray
    fixed_conditions: tuple[FixedCondition, ...] = ()
    run_sd: float = float("nan")
    degrees_of_freedom: float = np.inf
    limiting_stress_ratio: float = LIMITING_STRESS_RATIO
    tested_conditions: FloatArray = field(default_factory=lambda: np.empty((0, 0)))

    @classmethod
    def from_constants(cls, law: Law, constants: FloatArray) -> "Coefficients":
        """Constants alone, as printed in a paper, without interval and tested box."""
        no_refits = np.empty((0, len(constants)))
        return cls(
            constants=np.asarray(constants, dtype=float),
            group_has_exponent=np.ones(len(law.groups), dtype=bool),
            refits=no_refits,
            shifted_refits=no_refits,
            tested_box=np.full((len(law.conditions) + 1, 2), np.nan),
        )

    def covariance(self, law: Law) -> FloatArray:
        """Covariance of the internal constants by the bootstrap, without calibration.

        Returns:
            Shape (constants, constants); NaN without refits.
        """
        constant_count = len(self.constants)
        if len(self.refits) < 2 or np.isnan(self.constants).any():
            return np.full((constant_count, constant_count), np.nan)
        return np.asarray(np.cov(to_internal(law, self.refits), rowvar=False))

    def covariance_root(self, law: Law) -> FloatArray:
        """R with R R^T = covariance, shape (constants, constants); NaN without refits."""
        covariance = self.covariance(law)
        if np.isnan(covariance).any():
            return covariance
        # constants that are the same in every refit have eigenvalues of zero, or rounding below it
        eigenvalues, directions = np.linalg.eigh(covariance)
        return np.asarray(directions * np.sqrt(np.maximum(eigenvalues, 0)))

    def mean_band(self, law: Law, level: float, misfit: float = 0.0) -> Band:
        """Interval of the mean curve of the oil.

        It contains the calibration, which is an error that all runs of the rig share.

        Args:
            law: The law.
            level: Confidence level.
            misfit: Misfit of the law, relative to mu (rms); 0 for a law that is true.
        """
        calibration = (to_internal(law, self.shifted_refits) - to_internal(law, self.constants)).T
        student_factor = np.nan
        if self.degrees_of_freedom > 0:
            student_factor = student_half_width(level, self.degrees_of_freedom)
        normal_factor = normal_half_width(level)
        error_columns = np.hstack(
            [student_factor * self.covariance_root(law), normal_factor * calibration]
        )
        return Band(error_columns, normal_factor * misfit)


@dataclass(frozen=True)
class Prediction:
    """Traction coefficients with their intervals; all arrays of one shape.

    For columns of pandas these are columns with the same index, for arrays of xarray such arrays.

    Attributes:
        traction_coefficient: mu; odd in the slide-roll ratio. It is that of the law, or that of
            the surface of measured mu where no law fits (`from_surface`).
        obs_ci_lower: Lower end of the interval of the next good run, from the surface of measured
            mu; NaN where there is no support, or no surface.
        obs_ci_upper: Upper end.
        mean_ci_lower: Lower end of the interval of the oil's mean curve. It contains calibration
            and the misfit of the law; without a surface the misfit is not known, and the law is
            taken to be true. NaN where the fit has none.
        mean_ci_upper: Upper end.
        outside: True where a condition or the slip is outside the tested box or not known (NaN),
            or where the nearest tested conditions are more than their spacing away.
        distance: Distance from the tested box in tested ranges, for the condition farthest out; 0
            inside, NaN where the box is unknown, infinite where `away`.
        away: True where a condition that the fit does not follow is not on its tested level or
            line. mu is not known there, so it is NaN.
        spacings: Distance to the nearest tested conditions, in spacings: a spacing is the largest
            step between neighbouring levels of a condition. At most 0.5 within a full grid; NaN
            where the tested conditions are not known.
        support: Whether the measurements support an interval: a name of
            `oilfilm.surface.support.Support` in lower case; empty where there is no surface.
        from_surface: True where mu is that of the surface.
        over_limit: True where the mean shear stress, mu times the mean pressure, would be above the
            oil's limiting shear stress: no film carries it.
        warnings: Reasons why the fit is not sound, in sentences. For printed constants they name
            what their open signs leave open.
    """

    traction_coefficient: FloatArray
    obs_ci_lower: FloatArray
    obs_ci_upper: FloatArray
    mean_ci_lower: FloatArray
    mean_ci_upper: FloatArray
    outside: npt.NDArray[np.bool_]
    distance: FloatArray
    away: npt.NDArray[np.bool_]
    spacings: FloatArray
    support: npt.NDArray[Any]
    from_surface: npt.NDArray[np.bool_]
    over_limit: npt.NDArray[np.bool_]
    warnings: tuple[str, ...] = ()

    def to_frame(self) -> pd.DataFrame:
        """One row per point, one column per attribute; dimensions of xarray become the index."""
        columns: dict[str, Any] = {}
        for attribute in fields(self):
            if attribute.name == "warnings":
                continue
            values = getattr(self, attribute.name)
            has_dimensions = bool(getattr(values, "dims", ()))
            columns[attribute.name] = values.to_series() if has_dimensions else np.ravel(values)
        index = getattr(self.traction_coefficient, "index", None)
        return pd.DataFrame(columns, index=index)

    def __repr__(self) -> str:
        printed_columns = self.to_frame()[_PRINTED_COLUMNS]
        # an interval that the fit does not have is not printed
        return printed_columns.dropna(axis=1, how="all").to_string(max_rows=20)


class MeasuredCoordinates(NamedTuple):
    """Values of the followed conditions in the tests, and their largest steps.

    Pressure, speed and load are logarithms; the temperature is in degC.

    Attributes:
        curve_coordinates: Values in each curve, shape (curves, followed).
        largest_steps: Largest step between neighbouring values of each condition, shape
            (followed,); infinite where there is one value.
    """

    curve_coordinates: FloatArray
    largest_steps: FloatArray


def given_surface(surface: OilSurface | None) -> OilSurface | None:
    """Its argument; `partial(given_surface, surface)` serves as `FittedLaw.read_surface`."""
    return surface


@dataclass(frozen=True)
class FittedLaw:
    """A law with fitted constants. Where nothing could be fitted the traction is NaN.

    Attributes:
        law: The law.
        coefficients: Its constants, their uncertainty and the tested range.
        warnings: Reasons why the fit is not sound, in sentences; empty where it is sound or where
            that was not examined.
        read_surface: Reads the surface of the oil's measured mu; None for constants alone.
    """

    law: Law
    coefficients: Coefficients
    warnings: tuple[str, ...] = ()
    read_surface: Callable[[], OilSurface | None] | None = None

    def __repr__(self) -> str:
        constant_texts = []
        for constant, value in zip(self.law.constants, self.coefficients.constants, strict=True):
            constant_texts.append(f"{constant.name} {value:.10g}")
        return f"{self.law.name}: mu = {self.law.equation}; {', '.join(constant_texts)}"

    @property
    def why_no_interval(self) -> str:
        """Why the law has no interval anywhere, where it has none."""
        return (
            "there is no surface of measured mu: too few curves were tested "
            "(surface.fewest_curves), none of the fitted laws can carry one, or the contacts of "
            "the runs differ under a law of the load"
        )

    @cached_property
    def surface(self) -> OilSurface | None:
        """The surface of the oil's measured mu.

        None where the oil has none, and for a law of the load where the contacts of the runs differ
        or are not known: the load then gives no pressure.
        """
        surface = None if self.read_surface is None else self.read_surface()
        if surface is None or not surface.contact.has_surface(self.law):
            return None
        return surface

    @property
    def misfit_of_surface_law(self) -> float:
        """Misfit of the law on which the surface stands, relative to mu; NaN without a surface.

        That law may be another one than this law, whose misfit is `misfit_beside_surface`.
        """
        return self.surface.misfit if self.surface is not None else float("nan")

    @cached_property
    def misfit_beside_surface(self) -> float:
        """Relative misfit of this law, the rms difference of mu from the surface over the rms mu.

        The points are those of the surface; NaN without a surface.
        """
        if self.surface is None:
            return float("nan")
        measurements = self.surface.measurements
        surface_mu = np.exp(
            self.surface.surface.log_mu(measurements.point_conditions, measurements.slip)
        )
        conditions = self.surface.contact.law_conditions(self.law, measurements.point_conditions)
        predictions = self.without_interval().predictions(conditions, measurements.slip)
        law_mu = np.concatenate([prediction.traction_coefficient for prediction in predictions])
        return float(np.linalg.norm(law_mu - surface_mu) / np.linalg.norm(surface_mu))

    def interval_level(self, level: float = CONFIDENCE) -> float:
        """The level of the interval of the next run: the wanted one, or what the data allow.

        NaN where there is no interval.
        """
        return self.surface.interval_level(level) if self.surface is not None else float("nan")

    def form_error(
        self, conditions: FloatArray, slip: FloatArray, error_without_interval: float
    ) -> FloatArray:
        """Relative standard error of the law's form at each point, shape (points,).

        Where the surface of measured mu has an interval, it is the error of the surface without
        that of a run, joined with the distance of the law from the surface.

        Args:
            conditions: Rows of the law's conditions, shape (points, conditions).
            slip: Slide-roll ratio of each point, shape (points,).
            error_without_interval: The error where there is no such interval.
        """
        if self.surface is None:
            return np.full(len(slip), error_without_interval)
        # where the scatter of runs is not known, all counts as the error of the form
        run_sd = np.nan_to_num(self.coefficients.run_sd)
        sliding_slip = np.maximum(np.abs(slip), _SMALLEST_SLIP)
        prediction = self.predict(conditions, sliding_slip)
        # where no law fits, a prediction has the mu of the surface
        law_mu = self.without_interval().predict(conditions, sliding_slip).traction_coefficient
        with np.errstate(invalid="ignore", divide="ignore"):
            log_lower = np.log(prediction.obs_ci_lower)
            log_upper = np.log(prediction.obs_ci_upper)
            distance_from_surface = (log_lower + log_upper) / 2 - np.log(law_mu)
        half_width = (log_upper - log_lower) / 2
        run_and_form_sd = half_width / normal_half_width(self.interval_level())
        form_sd = np.sqrt(np.maximum(run_and_form_sd**2 - run_sd**2, 0.0))
        error = np.hypot(form_sd, distance_from_surface)
        return np.where(np.isfinite(error), error, error_without_interval)

    def remarks(self, conditions: FloatArray, slip: FloatArray) -> list[str]:
        """Remarks on the traction at one operating point, in sentences; printed laws have some.

        Args:
            conditions: Conditions, as `at_tested_levels` returns them, shape (1, conditions).
            slip: Shape (1,).
        """
        return []

    @classmethod
    def from_tables(
        cls,
        coefficients: pd.DataFrame,
        oil: str,
        refits: pd.DataFrame | None = None,
        quality: pd.DataFrame | None = None,
        law: Law | None = None,
        curves: pd.DataFrame | None = None,
        surfaces: pd.DataFrame | None = None,
    ) -> "FittedLaw":
        """The fit of one law to one oil.

        Args:
            coefficients: Table of coefficients.
            oil: Oil in it.
            refits: Table of refits; without it there are no intervals.
            quality: Table of fit quality; without it no tested box is known.
            law: The law of the coefficients. It may be left out where the table has one law for
                the oil, and one that needs no properties of the oil.
            curves: Table of curve residuals, which has the tested conditions.
            surfaces: Table of surfaces; without it the error of the next run is not known.
        """
        if law is None:
            (law_name,) = coefficients.loc[coefficients["oil"] == oil, "law"].unique()
            law = LAWS[law_name]
        fit_of_oil = cls._from_coefficients(law, _rows_of_fit(coefficients, oil, law))
        coefficients_of_fit = fit_of_oil.coefficients
        if refits is not None:
            coefficients_of_fit = _with_refits(
                coefficients_of_fit, law, _rows_of_fit(refits, oil, law)
            )
        if quality is not None:
            (quality_row,) = tables.rows(_rows_of_fit(quality, oil, law))
            coefficients_of_fit = _with_quality_row(coefficients_of_fit, law, quality_row)
        if curves is not None:
            mean_columns = [f"mean_{condition_name}" for condition_name in law.conditions]
            tested_conditions = _rows_of_fit(curves, oil, law)[mean_columns].to_numpy(float)
            coefficients_of_fit = replace(coefficients_of_fit, tested_conditions=tested_conditions)
        if surfaces is not None:
            coefficients_of_fit = replace(
                coefficients_of_fit, run_sd=_error_of_next_run(surfaces, oil)
            )
        return replace(fit_of_oil, coefficients=coefficients_of_fit)

    @classmethod
    def _from_coefficients(cls, law: Law, rows: pd.DataFrame) -> "FittedLaw":
        """The fit without uncertainty and tested range, from its rows of `coefficients`."""
        value_by_name = rows.set_index("constant")["value"]
        constants = _in_order_of_law(law, value_by_name.to_frame().T)[0]
        fitted_names = set(value_by_name.index[value_by_name.notna()])
        fitted_groups = {
            constant.group for constant in law.constants if constant.name in fitted_names
        }
        group_has_exponent = np.array([group in fitted_groups for group in law.groups])
        return cls(
            law,
            replace(
                Coefficients.from_constants(law, constants), group_has_exponent=group_has_exponent
            ),
        )

    @classmethod
    def from_results(cls, results: CampaignTables, oil: str) -> "FittedLaw":
        """The fit of the configured law to an oil, with its intervals and tested box.

        Args:
            results: Tables `coefficients`, `refits`, `fit_quality` and `curve_residuals`; for the
                interval of the next run `surfaces`, `surface_sizes` and `points` as well.
            oil: The oil.
        """
        fits = results.configured_fits
        fit = cls.from_tables(
            fits.coefficients,
            oil,
            refits=fits.refits,
            quality=fits.fit_quality,
            curves=fits.curve_residuals,
            surfaces=results.surfaces,
        )
        return replace(fit, read_surface=partial(read_surface, results, oil))

    def without_interval(self) -> "FittedLaw":
        """The law alone: its mu is that of the law everywhere, without the interval of a run."""
        return replace(self, read_surface=None)

    def traction(self, conditions: FloatArray, slip: FloatArray) -> FloatArray:
        """mu of the law against slip at one row of its conditions, shape of `slip`."""
        rows = np.broadcast_to(conditions, (len(slip), len(self.law.conditions)))
        return self.without_interval().predict(rows, slip).traction_coefficient

    def predictions(self, conditions: FloatArray, slip: FloatArray) -> Iterator[Prediction]:
        """As `predict`, for some points at a time: a prediction takes much memory per point.

        Args:
            conditions: As in `predict`.
            slip: As in `predict`.
        """
        for first_point in range(0, max(len(slip), 1), _POINTS_PREDICTED_AT_ONCE):
            block = slice(first_point, first_point + _POINTS_PREDICTED_AT_ONCE)
            yield self.predict(conditions[block], slip[block])

    def predict(
        self,
        conditions: FloatArray,
        slip: FloatArray,
        level: float = CONFIDENCE,
        whole_curve: bool = False,
        rig: str | None = None,
    ) -> Prediction:
        """mu with its intervals at each point.

        Args:
            conditions: Rows of the law's conditions, shape (points, conditions). NaN for a
                condition that the fit does not follow means its tested level. mu is NaN where a
                condition that the fit follows is NaN.
            slip: Slide-roll ratio of each point, shape (points,).
            level: Confidence level. That of the next run is at most `surface.level` of the
                configuration, and less where the tested conditions are few (`interval_level`).
            whole_curve: Whether the interval of the next run should hold all points of its curve,
                as a band needs that is drawn over a curve.
            rig: Name of the rig of the next run, where the runs are of several rigs; "another" for
                one that made none of them. If not given, the next run is on one of these rigs.

        Raises:
            OilfilmError: The level is not between 0 and 1, or a row has other conditions than those
                of the law.
            ValueError: Nothing is known of this rig.
        """
        if not 0 < level < 1:
            raise OilfilmError(
                f"level: found {level:g}; expected a share between 0 and 1, as 0.95 for 95 %."
            )
        # a list has no rows, and whole numbers cannot hold a tested level
        conditions = np.asarray(conditions, dtype=float)
        slip = np.asarray(slip, dtype=float)
        expected_shape = (slip.size, len(self.law.conditions))
        if conditions.shape != expected_shape:
            raise OilfilmError(
                f"conditions: found the shape {conditions.shape}; expected {expected_shape}: one "
                f"row per slide-roll ratio, of {', '.join(self.law.conditions)}."
            )
        is_away = np.zeros(len(conditions), dtype=bool)
        for away_from_condition in self.off_tested_levels(conditions).values():
            is_away |= away_from_condition
        conditions = self.at_tested_levels(conditions)
        is_unknown = np.isnan(
            self.law.group_values(conditions)[:, self.coefficients.group_has_exponent]
        )
        has_no_mu = is_away | is_unknown.any(axis=1)
        mu, mean_interval = self._law_mu_and_interval(conditions, slip, has_no_mu, level)
        next_run_interval = np.full((2, len(slip)), np.nan)
        support_names = np.full(len(slip), "", dtype=_SUPPORT_NAME_TYPE)
        from_surface = np.zeros(len(slip), dtype=bool)
        answerable_indices = np.flatnonzero(np.isfinite(mu) & np.isfinite(slip))
        if self.surface is not None and len(answerable_indices):
            surface_prediction = self.surface.predict(
                self.law,
                conditions[answerable_indices],
                np.abs(slip[answerable_indices]),
                level,
                whole_curve,
                rig,
            )
            next_run_interval[:, answerable_indices] = (
                surface_prediction.lower,
                surface_prediction.upper,
            )
            support_names[answerable_indices] = _SUPPORT_NAMES[surface_prediction.support_codes]
            if self.surface.no_law_fits:
                from_surface[answerable_indices] = (
                    surface_prediction.support_codes == Support.SUPPORTED
                )
                mu[answerable_indices] = np.where(
                    from_surface[answerable_indices], surface_prediction.mu, mu[answerable_indices]
                )
        sign = np.where(slip < 0, -1.0, 1.0)
        run_lower, run_upper = np.sort(sign * next_run_interval, axis=0)
        law_lower, law_upper = np.sort(sign * mean_interval, axis=0)
        distance = np.where(is_away, np.inf, self._distance_from_box(conditions, slip))
        spacings = self.spacings(conditions)
        is_not_given = is_unknown.any(axis=1) | np.isnan(slip)
        return Prediction(
            traction_coefficient=sign * mu,
            obs_ci_lower=run_lower,
            obs_ci_upper=run_upper,
            mean_ci_lower=law_lower,
            mean_ci_upper=law_upper,
            outside=is_not_given | (distance > 0) | exceeds(spacings, 1.0),
            distance=distance,
            away=is_away,
            spacings=spacings,
            support=support_names,
            from_surface=from_surface,
            over_limit=mu > self.coefficients.limiting_stress_ratio,
            warnings=self.warnings,
        )

    def _law_mu_and_interval(
        self,
        conditions: FloatArray,
        slip: FloatArray,
        has_no_mu: npt.NDArray[np.bool_],
        level: float,
    ) -> tuple[FloatArray, FloatArray]:
        """mu of the law for positive slip, and the ends of the interval of the oil's mean curve.

        Args:
            conditions: Rows of the law's conditions, shape (points, conditions).
            slip: Slide-roll ratio of each point, shape (points,).
            has_no_mu: True where mu is not known.
            level: Confidence level.

        Returns:
            Shapes (points,) and (2, points); NaN where mu is not known.
        """
        point_count = len(slip)
        mu = np.full(point_count, np.nan)
        mean_interval = np.full((2, point_count), np.nan)
        if np.isnan(self.coefficients.constants).any():
            return mu, mean_interval
        # a value at which the law can be evaluated; the result is not used
        evaluable_conditions = np.where(has_no_mu[:, np.newaxis], 1.0, conditions)
        misfit = np.nan_to_num(self.misfit_beside_surface)
        mean_band = self.coefficients.mean_band(self.law, level, misfit)
        for first_point in range(0, point_count, _POINTS_PER_CHUNK):
            chunk = slice(first_point, first_point + _POINTS_PER_CHUNK)
            mu[chunk], gradient = self._mu_and_gradient(evaluable_conditions[chunk], slip[chunk])
            mean_interval[:, chunk] = mean_band.ends(mu[chunk], gradient)
        mu[has_no_mu] = np.nan
        mean_interval[:, has_no_mu] = np.nan
        return mu, mean_interval

    def predict_at(
        self,
        max_hertz_pressure: Any,
        entrainment_speed: Any,
        inlet_temperature: Any,
        slide_roll_ratio: Any,
        level: float = CONFIDENCE,
    ) -> Prediction:
        """As the function `predict`, with this law: GPa, m/s, degC, or quantities of pint.

        Args:
            max_hertz_pressure: As in `predict`.
            entrainment_speed: As in `predict`.
            inlet_temperature: As in `predict`.
            slide_roll_ratio: As in `predict`.
            level: Confidence level.

        Raises:
            OilfilmError: The law is one of other conditions, or a quantity has a unit of something
                else.

        Warns:
            UserWarning: mu is NaN at some points, with the reason; or a level above the usual one
                is asked for, which the interval of the next run does not have.
        """
        if self.law.conditions != CONDITIONS:
            raise OilfilmError(
                f"the law {self.law.name} is one of {', '.join(self.law.conditions)}; use the "
                "method predict of the fitted law, which takes rows of them."
            )
        values = (max_hertz_pressure, entrainment_speed, inlet_temperature, slide_roll_ratio)
        arguments, label_result = aligned_arguments(
            dict(zip((*CONDITIONS, SLIP), values, strict=True))
        )
        arrays = [in_column_unit(value, name) for name, value in arguments.items()]
        broadcast_arrays = np.broadcast_arrays(*arrays)
        shape = broadcast_arrays[0].shape
        flat_arrays = [np.asarray(array, dtype=float).ravel() for array in broadcast_arrays]
        conditions = np.column_stack(flat_arrays[:-1])
        slip = flat_arrays[-1]
        prediction = self.predict(conditions, slip, level)
        unknown_mu_count = int(np.isnan(prediction.traction_coefficient).sum())
        reason = self._why_no_mu(conditions) if unknown_mu_count else ""
        if reason:
            text = f"mu is NaN at {unknown_mu_count} of {len(slip)} points: {reason}"
            warnings.warn(text, stacklevel=2)
        level_of_next_run = self.interval_level(level)
        if CONFIDENCE < level and level_of_next_run < level:
            text = (
                f"the interval of the next run has the level {level_of_next_run:.3g}, which is the "
                f"largest one that the surface has, and not {level:.3g}"
            )
            warnings.warn(text, stacklevel=2)
        labelled_arrays = {
            attribute.name: label_result(
                getattr(prediction, attribute.name).reshape(shape), attribute.name
            )
            for attribute in fields(prediction)
            if attribute.name != "warnings"
        }
        return Prediction(**labelled_arrays, warnings=prediction.warnings)

    def _why_no_mu(self, conditions: FloatArray) -> str:
        """Why mu is not known at some rows of conditions; empty where it is known at all of them.

        A followed condition that is NaN is no reason: the caller put it there.
        """
        if np.isnan(self.coefficients.constants).any():
            return "nothing could be fitted"
        return "; ".join(fixed.sentence() for fixed in self.off_tested_levels(conditions))

    def at_tested_levels(self, conditions: FloatArray) -> FloatArray:
        """The conditions, with those that the fit does not follow at their tested level or line.

        Args:
            conditions: Rows of the law's conditions, shape (points, conditions).

        Returns:
            Shape (points, conditions).
        """
        values_by_condition = self._values_by_condition(conditions)
        tested_values = dict(values_by_condition)
        for fixed in self.coefficients.fixed_conditions:
            tested_values[fixed.condition] = fixed.tested_value(values_by_condition)
        return np.column_stack(list(tested_values.values()))

    @property
    def widened_box(self) -> FloatArray:
        """The tested box, wider by `within` for conditions that the fit does not follow.

        Shape (conditions + 1, 2), as `Coefficients.tested_box`.
        """
        within_by_name = {
            fixed.condition: fixed.within for fixed in self.coefficients.fixed_conditions
        }
        names = (*self.law.conditions, SLIP)
        within = np.array([[within_by_name.get(name, 0.0)] for name in names])
        least_magnitude = np.array([[LEAST_MAGNITUDES.get(name, 0.0)] for name in names])
        tested_box = self.coefficients.tested_box
        margin = within * np.maximum(np.abs(tested_box), least_magnitude)
        return tested_box + margin * [-1.0, 1.0]

    def off_tested_levels(
        self, conditions: FloatArray
    ) -> dict[FixedCondition, npt.NDArray[np.bool_]]:
        """Whether each row is away from the tested level or line of each fixed condition.

        Args:
            conditions: Rows of the law's conditions, shape (points, conditions).

        Returns:
            Whether each row is away, shape (points,), by fixed condition; only the conditions from
            which a row is away.
        """
        if np.isnan(self.coefficients.constants).any():
            return {}
        values_by_condition = self._values_by_condition(conditions)
        rows_off_level = {}
        for fixed in self.coefficients.fixed_conditions:
            is_away = is_off_tested_level(fixed, values_by_condition)
            if is_away.any():
                rows_off_level[fixed] = is_away
        return rows_off_level

    def _values_by_condition(self, conditions: FloatArray) -> dict[str, FloatArray]:
        """Values of each condition by its column, from rows of conditions."""
        return dict(zip(self.law.conditions, conditions.T, strict=True))

    def _mu_and_gradient(
        self, conditions: FloatArray, slip: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        """mu for positive slip, shape (points,), and its derivatives by the internal constants."""
        law = self.law
        coefficients = self.coefficients
        design = law.design(conditions, coefficients.group_has_exponent)
        magnitudes = law.magnitudes(to_internal(law, coefficients.constants), design)
        mu, slopes = law.mu_and_slopes(magnitudes, np.abs(slip))
        return mu, np.hstack([slope[:, np.newaxis] * design for slope in slopes])

    @cached_property
    def measured_coordinates(self) -> MeasuredCoordinates:
        """The tested values of the followed conditions, and the largest steps between them."""
        curve_coordinates = self._coordinates(self.coefficients.tested_conditions)
        largest_steps = np.array(
            [np.diff(np.sort(values)).max(initial=0.0) for values in curve_coordinates.T]
        )
        return MeasuredCoordinates(
            curve_coordinates, np.where(largest_steps > 0, largest_steps, np.inf)
        )

    def _coordinates(self, conditions: FloatArray) -> FloatArray:
        """The followed conditions as in `MeasuredCoordinates`, shape (points, followed)."""
        fixed_names = {fixed.condition for fixed in self.coefficients.fixed_conditions}
        columns = []
        for name, values in self._values_by_condition(conditions).items():
            if name in fixed_names:
                continue
            if name in LEAST_MAGNITUDES:
                columns.append(values)
            else:
                columns.append(np.log(np.maximum(values, np.finfo(float).tiny)))
        if not columns:
            return np.empty((len(conditions), 0))
        return np.stack(columns, axis=-1)

    def spacings(self, conditions: FloatArray) -> FloatArray:
        """Distance to the nearest tested conditions, as in `Prediction`.

        Args:
            conditions: Rows of the law's conditions, shape (points, conditions).

        Returns:
            Shape (points,).
        """
        if (
            not len(self.coefficients.tested_conditions)
            or np.isnan(self.coefficients.constants).any()
        ):
            return np.full(len(conditions), np.nan)
        curve_coordinates, largest_steps = self.measured_coordinates
        coordinates = self._coordinates(conditions)
        distance_to_nearest = np.full(len(coordinates), np.nan)
        is_known = np.isfinite(coordinates).all(axis=1)
        if not is_known.any() or not np.isfinite(curve_coordinates).all():
            return distance_to_nearest
        if coordinates.shape[1] == 0:
            return np.zeros(len(coordinates))
        # a tree of all curves: points times curves would be quadratic in the size of a campaign
        tree = scipy.spatial.KDTree(curve_coordinates / largest_steps)
        _, nearest_curves = tree.query(coordinates[is_known] / largest_steps, p=np.inf)
        # as a difference in the units of the conditions, which is zero at a tested condition
        differences = np.abs(coordinates[is_known] - curve_coordinates[nearest_curves])
        distance_to_nearest[is_known] = (differences / largest_steps).max(axis=1)
        return distance_to_nearest

    def _distance_from_box(self, conditions: FloatArray, slip: FloatArray) -> FloatArray:
        """Distance from the tested box in tested ranges, as in `Prediction`, shape (points,)."""
        lowest, highest = self.widened_box.T
        points = np.column_stack([conditions, np.abs(slip)])
        distance_beyond = np.maximum(np.maximum(lowest - points, points - highest), 0.0)
        distance_beyond[reaches(points, lowest) & reaches(highest, points)] = 0.0
        with np.errstate(divide="ignore", invalid="ignore"):
            distance_in_ranges = np.where(
                distance_beyond == 0, 0.0, distance_beyond / (highest - lowest)
            )
        # a point beyond one range is outside, even where another range is unknown
        farthest_known = np.fmax.reduce(distance_in_ranges, axis=1)
        return np.where(farthest_known > 0, farthest_known, distance_in_ranges.max(axis=1))


def _rows_of_fit(table: pd.DataFrame, oil: str, law: Law) -> pd.DataFrame:
    """The rows of a table that belong to the fit of one law to one oil."""
    return table[(table["oil"] == oil) & (table["law"] == law.name)]


def read_surface(results: CampaignTables, oil: str) -> OilSurface | None:
    """The surface of an oil's measured mu; None where it has none.

    Args:
        results: Tables `surfaces`, `surface_sizes`, `points` and `coefficients`.
        oil: The oil.
    """
    surface_rows = list(tables.rows(results.surfaces[results.surfaces["oil"] == oil]))
    if not surface_rows:
        return None
    (surface_row,) = surface_rows
    fit = FittedLaw.from_tables(results.coefficients, oil, law=LAWS[surface_row["law"]])
    sizes = results.surface_sizes
    surface = surface_from_tables(
        surface_row,
        sizes[sizes["oil"] == oil],
        results.table("points", CURVE_COLUMNS, oil=oil),
        LawConstants(fit.law, fit.coefficients.constants, fit.coefficients.group_has_exponent),
    )
    tables.release_memory()
    return surface


def _error_of_next_run(surfaces: pd.DataFrame, oil: str) -> float:
    """Standard deviation of ln mu in the next run, which its interval has; NaN if unknown."""
    surface_rows = list(tables.rows(surfaces[surfaces["oil"] == oil]))
    if not surface_rows:
        return float("nan")
    (surface_row,) = surface_rows
    return float(
        surface_row["next_run_sd"]
        * surface_row["point_factor"]
        / normal_half_width(surface_row["interval_level"])
    )


def _with_refits(coefficients: Coefficients, law: Law, refits: pd.DataFrame) -> Coefficients:
    """Coefficients with the constants of refits.

    Args:
        coefficients: The coefficients.
        law: Their law.
        refits: The fit's rows of the table of refits.
    """
    constants_of_refits = refits.pivot(index=["cause", "refit"], columns="constant", values="value")
    is_calibration = constants_of_refits.index.get_level_values("cause").str.startswith(
        "calibration"
    )
    resampled_refits = _in_order_of_law(law, constants_of_refits[~is_calibration])
    shifted_refits = _in_order_of_law(law, constants_of_refits[is_calibration])
    # constants at a bound have the same value in every refit, and are not in the table
    return replace(
        coefficients,
        refits=np.where(np.isnan(resampled_refits), coefficients.constants, resampled_refits),
        shifted_refits=np.where(np.isnan(shifted_refits), coefficients.constants, shifted_refits),
    )


def _with_quality_row(
    coefficients: Coefficients, law: Law, quality_row: Mapping[str, Any]
) -> Coefficients:
    """Coefficients with their tested range and the errors at curves left out.

    Args:
        coefficients: The coefficients.
        law: Their law.
        quality_row: The fit's row of the table `fit_quality`.
    """
    names = (*law.conditions, SLIP)
    tested_box = np.array(
        [[quality_row[f"tested_min_{name}"], quality_row[f"tested_max_{name}"]] for name in names],
        float,
    )
    # traction is zero without slip: this needs no test
    tested_box[-1, 0] = 0.0
    limiting_stress_ratio = quality_row["limiting_stress_ratio"]
    if not np.isfinite(limiting_stress_ratio):
        limiting_stress_ratio = coefficients.limiting_stress_ratio
    return replace(
        coefficients,
        tested_box=tested_box,
        fixed_conditions=fixed_conditions_from_json(quality_row["fixed_conditions"]),
        degrees_of_freedom=spread_degrees_of_freedom(
            quality_row["n_curves"], 1 + coefficients.group_has_exponent.sum()
        ),
        limiting_stress_ratio=float(limiting_stress_ratio),
    )


def _in_order_of_law(law: Law, rows: pd.DataFrame) -> FloatArray:
    """Constants in the order of the law, one row per fit or refit.

    Where a condition did not vary, the tables have the coefficient X at the tested level in place
    of X0; it is then taken as X0.

    Args:
        law: The law.
        rows: One column per constant.

    Returns:
        Shape (rows, constants); NaN where nothing could be fitted.
    """
    constant_names = [constant.name for constant in law.constants]
    constants = rows.reindex(columns=constant_names).to_numpy(dtype=float, copy=True)
    at_tested_level = rows.reindex(columns=list(law.coefficient_names)).to_numpy(dtype=float)
    is_x0 = np.array([constant.group is None for constant in law.constants])
    has_no_x0 = np.isnan(constants[:, is_x0]) & ~np.isnan(at_tested_level)
    constants[:, is_x0] = np.where(has_no_x0, at_tested_level, constants[:, is_x0])
    is_fitted = ~np.isnan(constants[:, is_x0]).any(axis=1, keepdims=True)
    # exponents that the law prescribes; those of conditions that did not vary are zero
    is_not_fitted_exponent = ~is_x0 & is_fitted & np.isnan(constants)
    return np.where(is_not_fitted_exponent, law.prescribed, constants)


def read_fit(folder: Path | str, oil: str | int | None = None) -> FittedLaw:
    """The fit of one oil from a campaign's results, as `results/demo`, or of a saved fit.

    Args:
        folder: Folder of the results, which contains the folder `tables`.
        oil: Name of the oil; not needed where there is one oil only.

    Raises:
        OilfilmError: There are no such results, or no such oil in them, or their tables do not
            belong together.

    Examples:
        A fit that was saved as `june`. Of a campaign: `oilfilm.read_fit("results/demo", "4102")`.

        >>> import tempfile
        >>> import oilfilm
        >>> constants = [-0.01567792, 1.6654, -0.5014, -0.1065]
        >>> constants += [0.63482685, 1.2727, -0.4139, -1.2181]
        >>> constants += [24.43483717, 0.3964, 0.1591, -0.7121]
        >>> test_points = np.meshgrid([1.0, 1.25, 1.5], [25, 40], [50, 120], [0.01, 0.03, 0.1, 0.3])
        >>> mu = oilfilm.predict("deng2026", constants, *test_points).traction_coefficient
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     oilfilm.fit(*test_points, mu, searches=2, bootstrap=20).save(f"{folder}/june")
        ...     law = oilfilm.read_fit(f"{folder}/june")
        >>> float(law.predict_at(1.2, 30, 70, 0.05).traction_coefficient)
        0.0107...
    """
    for name in _TABLES_OF_A_FIT:
        refuse_oversized(Path(folder, "tables", f"{name}.parquet"))
    results = CampaignTables.from_folder(Path(folder))
    oils = sorted(results.configured_fits.fit_quality["oil"])
    if oil is None and len(oils) == 1:
        oil = oils[0]
    oils_in_words = ", ".join(oils) or "none"
    if oil is None:
        raise OilfilmError(f"{folder}: there are fits of {oils_in_words}. Name the oil.")
    # many oils are named by a number
    oil = str(oil)
    if oil not in oils:
        raise OilfilmError(f"{folder}: no fit of oil {oil!r}; there are fits of {oils_in_words}.")
    refuse_contradictions(results, str(folder), oil)
    with explaining_contradictions(str(folder), oil):
        (verdict,) = tables.rows(results.soundness[results.soundness["oil"] == oil])
        fit = FittedLaw.from_results(results, oil)
        # the folder may be gone when the first interval is asked for
        surface = partial(given_surface, fit.surface)
        fit = replace(fit, warnings=tuple(soundness_warnings(verdict)), read_surface=surface)
        _check_at_tested_conditions(fit)
    return fit


def _check_at_tested_conditions(fit: FittedLaw) -> None:
    """Compute mu with its interval at two tested conditions, so that wrong tables fail at once."""
    if not len(fit.coefficients.tested_conditions):
        return
    first_and_last = fit.coefficients.tested_conditions[[0, -1]]
    fit.predict(
        first_and_last, np.full(len(first_and_last), fit.coefficients.tested_box[-1].mean())
    )


# Smallest and largest value of any traction test, and the most likely cause of a larger one, by
# column.
_POSSIBLE_RANGES = {
    "max_hertz_pressure_gpa": (0.0, 10.0, "in MPa? Divide by 1000"),
    "entrainment_speed_m_s": (0.0, 500.0, "in mm/s? Divide by 1000"),
    "inlet_temperature_c": (-100.0, 350.0, "in kelvins? Subtract 273.15"),
    "load_n": (0.0, 1e5, "in mN? Divide by 1000"),
    SLIP: (-2.0, 2.0, "in percent? Divide by 100"),
    "traction_coefficient": (-1.0, 1.0, "in percent? Divide by 100"),
}


def refuse_impossible_values(values: FloatArray, column_name: str) -> None:
    """Refuse values that no traction test has, most often because of their unit; NaN passes.

    Args:
        values: Values in the unit of the column.
        column_name: Name of the column.

    Raises:
        OilfilmError: A value is out of the possible range.
    """
    smallest, largest, hint = _POSSIBLE_RANGES.get(column_name, (-np.inf, np.inf, ""))
    values = values.ravel()
    # a load, pressure or speed of 0 makes no contact
    has_allowed_sign = (values > 0) | (smallest < 0)
    is_possible = (values >= smallest) & (values <= largest) & has_allowed_sign
    impossible = np.flatnonzero(~np.isnan(values) & ~is_possible)
    if not len(impossible):
        return
    first_value = values[impossible[0]]
    if first_value < smallest:
        hint = "of the wrong sign"
        if column_name == "inlet_temperature_c":
            hint = "converted from kelvins twice? Add 273.15"
    column_unit = tables.COLUMNS[column_name].unit
    unit = "" if column_unit == "1" else f" {column_unit}"
    lower_bound_word = "" if smallest else "above "
    # a zero has no wrong unit
    hint_sentence = f" Perhaps {hint}." if first_value else ""
    raise OilfilmError(
        f"{column_name}: found {first_value:g}{unit} at {len(impossible)} of {values.size} points, "
        f"the first is number {impossible[0] + 1}; expected {lower_bound_word}{smallest:g} to "
        f"{largest:g}{unit}.{hint_sentence}"
    )


def in_column_unit(value: Any, column_name: str) -> npt.NDArray[np.float64]:
    """Values of a condition, the slide-roll ratio or mu; quantities of pint are converted.

    Args:
        value: Numbers in the unit of the column `column_name`, or a quantity of pint.
        column_name: Name of the column.

    Raises:
        OilfilmError: The quantity has a unit of something else, or a value is no number or
            impossible.
    """
    unit = QUANTITIES[column_name].unit if column_name in QUANTITIES else "dimensionless"
    if hasattr(value, "magnitude") and hasattr(value, "to"):
        try:
            value = value.to(unit).magnitude
        except Exception as error:
            raise OilfilmError(
                f"{column_name}: {error}; expected a unit such as {unit}."
            ) from error
    try:
        values = np.asarray(value, dtype=float)
    except (TypeError, ValueError) as error:
        raise OilfilmError(f"{column_name}: expected numbers in {unit}, but {error}.") from None
    refuse_impossible_values(values, column_name)
    return values


def predict(
    law: str | Law,
    coefficients: Coefficients | FloatArray,
    max_hertz_pressure: Any,
    entrainment_speed: Any,
    inlet_temperature: Any,
    slide_roll_ratio: Any,
    level: float = CONFIDENCE,
) -> Prediction:
    """Traction coefficient with its intervals, and whether the operating point was tested.

    Args:
        law: A law of pressure, speed and temperature, or its name.
        coefficients: Of a fit (`read_fit(...).coefficients`), or bare constants in the law's
            order: these give mu without interval or box.
        max_hertz_pressure: P in GPa, or a quantity of pint, as the others.
        entrainment_speed: U in m/s.
        inlet_temperature: T in degC. NaN for a condition that the fit does not follow means its
            tested level.
        slide_roll_ratio: Slide-roll ratio S. The four broadcast against each other, arrays of
            xarray by the names of their dimensions.
        level: Confidence level.

    Returns:
        Arrays of the broadcast shape, columns or arrays of xarray as the arguments were.

    Warns:
        UserWarning: mu is NaN at some points because it is not known there, with the reason.

    Raises:
        OilfilmError: There is no such law, or it is one of load, which `FittedLaw.predict` takes;
            or a quantity has a unit of something else.
        ValueError: A condition is not above zero, where power laws have no value.

    Examples:
        4102 as printed, at the reference condition:

        >>> constants = [-0.01567792, 0, 0, 0, 0.63482685, 0, 0, 0, 24.43483717, 0, 0, 0]
        >>> float(predict("deng2026", constants, 1.0, 20.0, 20.0, 0.05).traction_coefficient)
        0.020412...
    """
    if isinstance(law, str):
        if law not in LAWS:
            raise OilfilmError(f"there is no law {law!r}; the laws are {', '.join(LAWS)}.")
        law = LAWS[law]
    if not isinstance(coefficients, Coefficients):
        coefficients = Coefficients.from_constants(law, coefficients)
    return FittedLaw(law, coefficients).predict_at(
        max_hertz_pressure, entrainment_speed, inlet_temperature, slide_roll_ratio, level
    )
