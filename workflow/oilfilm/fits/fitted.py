"""A fitted law, read back from its tables: traction at any condition, with its interval.

Decides: traction at a condition, wherever it is needed, and where it is refused.
"""

import importlib
import warnings
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from oilfilm import tables
from oilfilm.base.errors import OilfilmError
from oilfilm.base.ties import exceeds, reaches
from oilfilm.base.units import FloatArray
from oilfilm.fits.conditions import LEAST_SIZE, FixedCondition, away, from_text
from oilfilm.fits.interval import (
    UNKNOWN,
    Band,
    Unseen,
    between_two_levels,
    degrees_of_spread,
    normal_quantile,
    student_quantile,
)
from oilfilm.fits.soundness_words import what_is_wrong
from oilfilm.physics.oils import LIMITING_STRESS_RATIO
from oilfilm.tables import refuse_unpacking
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.traction import LAWS
from oilfilm.traction.law import CONDITIONS, QUANTITIES, Law, to_internal

SLIP = "slide_roll_ratio"
# Ends of the intervals of a prediction, as attributes and as columns of tables.
INTERVALS = ("obs_ci_lower", "obs_ci_upper", "mean_ci_lower", "mean_ci_upper")
_SHOWN = ("traction_coefficient", *INTERVALS, "outside")
# Points predicted at once: about what fits a processor's cache.
_CHUNK = 1 << 14


@dataclass(frozen=True)
class Coefficients:
    """Constants of a law in the form of its equation, and all that says how far to trust them.

    Attributes:
        constants: In the order of the law's, NaN where nothing could be fitted. An exponent that
            the data could not give is 0, and X0 then holds the coefficient at the tested level.
        known: Which of the law's groups the fit follows.
        spread: Constants of the bootstrap over curves, shape (refits, constants).
        shifted: Constants refitted with one sensor each off by its calibration's uncertainty.
        box: Smallest and largest tested value of each of the law's conditions and of the slip,
            shape (conditions + 1, 2); NaN where unknown.
        fixed: The conditions that the fit does not follow, with the level or line tested; empty
            where that is unknown.
        unseen: How far curves left out of the fit lie from their prediction.
        degrees: Degrees of freedom of the spread, as of `degrees_of_spread`.
        two_levels: The followed conditions that were tested at two levels only.
        limiting_stress_ratio: Limiting shear stress of the oil over the pressure.
        tested: Conditions of each curve, shape (curves, conditions); no rows where unknown.
    """

    constants: FloatArray
    known: npt.NDArray[np.bool_]
    spread: FloatArray
    shifted: FloatArray
    box: FloatArray
    fixed: tuple[FixedCondition, ...] = ()
    unseen: Unseen = UNKNOWN
    degrees: float = np.inf
    two_levels: tuple[str, ...] = ()
    limiting_stress_ratio: float = LIMITING_STRESS_RATIO
    tested: FloatArray = field(default_factory=lambda: np.empty((0, 0)))

    @classmethod
    def bare(cls, law: Law, constants: FloatArray) -> "Coefficients":
        """Constants alone, as printed in a paper: no interval and no tested box."""
        none = np.empty((0, len(constants)))
        box = np.full((len(law.conditions) + 1, 2), np.nan)
        known = np.ones(len(law.groups), dtype=bool)
        return cls(np.asarray(constants, dtype=float), known, none, none, box)

    def covariance(self, law: Law) -> FloatArray:
        """Covariance of the internal constants by the refits to other curves; NaN without refits.

        Calibration is not in it.
        """
        if len(self.spread) < 2 or np.isnan(self.constants).any():
            return np.full((len(self.constants),) * 2, np.nan)
        return np.asarray(np.cov(to_internal(law, self.spread), rowvar=False))

    def root(self, law: Law) -> FloatArray:
        """R with R R^T = covariance; constants held at zero give it directions without size.

        NaN where there are no refits.
        """
        covariance = self.covariance(law)
        if np.isnan(covariance).any():
            return covariance
        size, directions = np.linalg.eigh(covariance)
        return np.asarray(directions * np.sqrt(np.maximum(size, 0)))

    def bands(self, law: Law, level: float) -> tuple[Band, Band, float]:
        """Intervals of a further run and of the law's mean, and the level that the first one holds.

        Calibration is in both, once: it is an error that all runs of the rig share.

        Args:
            law: The law.
            level: Of confidence; the first interval has the highest one up to it that the number
                of curves allows, NaN where that is none.
        """
        root, unseen = self.root(law), self.unseen
        calibration = (to_internal(law, self.shifted) - to_internal(law, self.constants)).T
        held, quantile = unseen.at(level)
        of_run = (normal_quantile(held) if held > 0 else np.nan) * calibration
        run = Band(
            np.column_stack([quantile * root, of_run, quantile * unseen.slip * law.slip_scale]),
            quantile * unseen.absolute,
            quantile * unseen.relative,
        )
        own = student_quantile(level, self.degrees) if self.degrees > 0 else np.nan
        return run, Band(np.hstack([own * root, normal_quantile(level) * calibration])), held


@dataclass(frozen=True)
class Prediction:
    """Traction coefficients with their intervals; all arrays of one shape.

    Of columns of pandas they are columns with the same index; of arrays of xarray, such arrays.

    Attributes:
        traction_coefficient: mu; odd in the slide-roll ratio.
        obs_ci_lower: Lower end of the interval of the next good run, from curves left out of the
            fit; NaN where the fit has none.
        obs_ci_upper: Upper end.
        mean_ci_lower: Lower end of the interval of the law's mean curve, which holds if the law is
            true; NaN where the fit has none.
        mean_ci_upper: Upper end.
        outside: True where a condition or the slip lies outside the tested box, or where the
            nearest tested conditions are more than their own spacing away.
        distance: How far outside, in tested ranges, for the condition farthest out; 0 inside, NaN
            where the box is unknown, infinite where `away`.
        away: True where a condition that the fit does not follow is asked for away from the level
            or line on which it was tested: nothing is known of mu there, so it is NaN.
        spacings: Distance to the nearest tested conditions, in units of the largest step between
            neighbouring levels of each condition; 0.5 at most within a full grid; NaN where the
            tested conditions are not known.
        over_limit: True where the mean shear stress, mu times the mean pressure, would be above the
            oil's limiting shear stress: no film carries it.
        wrong: What keeps the fit from being sound, in sentences, wherever mu is asked for; of
            printed constants what their open signs leave open.
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
    over_limit: npt.NDArray[np.bool_]
    wrong: tuple[str, ...] = ()

    def to_frame(self) -> pd.DataFrame:
        """One row per point, one column per attribute; dimensions of xarray become the index."""
        columns = {
            name: values.to_series() if getattr(values, "dims", ()) else np.ravel(values)
            for name, values in vars(self).items()
            if name != "wrong"
        }
        index = getattr(self.traction_coefficient, "index", None)
        return pd.DataFrame(columns, index=index)

    def __repr__(self) -> str:
        # an interval that the fit does not have is no column
        return self.to_frame()[list(_SHOWN)].dropna(axis=1, how="all").to_string(max_rows=20)


@dataclass(frozen=True)
class FittedLaw:
    """A law with fitted constants. Where nothing could be fitted the traction is NaN.

    Attributes:
        law: The law.
        coefficients: Its constants, and how far to trust them.
        wrong: What keeps the fit from being sound, in sentences; empty where it is, or where
            nobody has looked.
    """

    law: Law
    coefficients: Coefficients
    wrong: tuple[str, ...] = ()

    def __repr__(self) -> str:
        names = (constant.name for constant in self.law.constants)
        values = zip(names, self.coefficients.constants, strict=True)
        shown = ", ".join(f"{name} {value:.10g}" for name, value in values)
        return f"{self.law.name}: mu = {self.law.equation}; {shown}"

    @property
    def no_interval(self) -> str:
        """Why the law has no interval, where it has none."""
        return "too few curves were tested (fit.min_curves_for_errors)"

    def remarks(self, line: FloatArray, slide_roll_ratio: FloatArray) -> list[str]:
        """Sentences on the traction at one operating point; a law from print has some.

        Args:
            line: Conditions, as of `on_line`, shape (1, conditions).
            slide_roll_ratio: Shape (1,).
        """
        return []

    @classmethod
    def of(
        cls,
        coefficients: pd.DataFrame,
        oil: str,
        refits: pd.DataFrame | None = None,
        quality: pd.DataFrame | None = None,
        law: Law | None = None,
        curves: pd.DataFrame | None = None,
    ) -> "FittedLaw":
        """The fit of one law to one oil.

        Args:
            coefficients: Table of coefficients.
            oil: Oil in it.
            refits: Table of refits; without it there are no intervals.
            quality: Table of fit quality; without it no tested box is known.
            law: Of which the coefficients are wanted. Without it the table holds one law for the
                oil, and one that needs no properties of it.
            curves: Table of curve residuals, which has the tested conditions.
        """
        if law is None:
            (name,) = coefficients.loc[coefficients["oil"] == oil, "law"].unique()
            law = LAWS[name]

        def of_fit(table: pd.DataFrame) -> pd.DataFrame:
            return table[(table["oil"] == oil) & (table["law"] == law.name)]

        rows = of_fit(coefficients).set_index("constant")
        values = _in_order(law, rows["value"].to_frame().T)[0]
        given = set(rows.index[rows["value"].notna()])
        followed = {constant.condition for constant in law.constants if constant.name in given}
        known = np.array([name in followed for name in law.groups])
        spread = shifted = np.empty((0, len(values)))
        if refits is not None:
            index = ["cause", "refit"]
            wide = of_fit(refits).pivot(index=index, columns="constant", values="value")
            calibration = wide.index.get_level_values("cause").str.startswith("calibration")
            spread, shifted = (
                # constants at a bound stay there in every refit
                np.where(np.isnan(refitted := _in_order(law, rows)), values, refitted)
                for rows in (wide[~calibration], wide[calibration])
            )
        of_data: dict[str, Any] = {}
        if quality is not None:
            (row,) = tables.rows(of_fit(quality))
            names = (*law.conditions, SLIP)
            ends = [[row[f"tested_{end}_{name}"] for end in ("min", "max")] for name in names]
            # that there is no traction without slip needs no test
            ends[-1][0] = 0.0
            of_data = {
                "box": np.array(ends, float),
                "fixed": from_text(row["fixed_conditions"]),
                "unseen": Unseen.of(row),
                "degrees": degrees_of_spread(row["n_curves"], 1 + known.sum()),
                "two_levels": row["two_level_conditions"],
            }
            if np.isfinite(row["limiting_stress_ratio"]):
                of_data["limiting_stress_ratio"] = float(row["limiting_stress_ratio"])
        if curves is not None:
            means = [f"mean_{name}" for name in law.conditions]
            of_data["tested"] = of_fit(curves)[means].to_numpy(float)
        bare = Coefficients.bare(law, values)
        return cls(law, replace(bare, known=known, spread=spread, shifted=shifted, **of_data))

    @classmethod
    def of_configured(cls, results: CampaignTables, oil: str) -> "FittedLaw":
        """The fit of the configured law to an oil, with its intervals and tested box.

        Args:
            results: Tables `coefficients`, `refits`, `fit_quality` and `curve_residuals`.
            oil: The oil.
        """
        of = results.configured
        return cls.of(of.coefficients, oil, of.refits, of.fit_quality, curves=of.curve_residuals)

    def traction(self, conditions: FloatArray, slip: FloatArray) -> FloatArray:
        """mu against slip at one row of the law's conditions, shape of `slip`."""
        at = np.broadcast_to(conditions, (len(slip), len(self.law.conditions)))
        return self.predict(at, slip).traction_coefficient

    def predict(self, conditions: FloatArray, slip: FloatArray, level: float = 0.95) -> Prediction:
        """mu with its intervals at each point, as of `Coefficients.bands`.

        Args:
            conditions: Rows of the law's conditions, shape (points, conditions). NaN for a
                condition that the fit does not follow asks for its tested level; mu is NaN where a
                condition that it follows is.
            slip: Slide-roll ratio of each point, shape (points,).
            level: Of confidence; `Coefficients.bands` says which one the number of curves allows.
        """
        none = np.zeros(len(conditions), dtype=bool)
        off = np.any([none, *self.away_from(conditions).values()], axis=0)
        conditions = self.on_line(conditions)
        unknown = np.isnan(self.law.group_values(conditions)[:, self.coefficients.known])
        lost = off | unknown.any(axis=1)
        # of each point: mu; lower and upper end of both intervals
        mu, ends = np.full(len(slip), np.nan), np.full((2, 2, len(slip)), np.nan)
        if not np.isnan(self.coefficients.constants).any():
            # any value that the law can take; mu is not known there
            evaluable = np.where(lost[:, np.newaxis], 1.0, conditions)
            of_run, of_law, _ = self.coefficients.bands(self.law, level)
            for start in range(0, len(slip), _CHUNK):
                chunk = slice(start, start + _CHUNK)
                mu[chunk], gradient = self._with_gradient(evaluable[chunk], slip[chunk])
                bend = self._unseen_bend(evaluable[chunk], slip[chunk], mu[chunk])
                ends[0, :, chunk] = of_run.ends(mu[chunk], gradient, bend)
                ends[1, :, chunk] = of_law.ends(mu[chunk], gradient, bend[:, :0])
            mu[lost] = ends[:, :, lost] = np.nan
        sign = np.where(slip < 0, -1.0, 1.0)
        (lower, upper), (own_lower, own_upper) = np.sort(sign * ends, axis=1)
        distance = np.where(off, np.inf, self._distance(conditions, slip))
        spacings = self.spacings(conditions)
        where = (distance > 0) | exceeds(spacings, 1.0), distance, off, spacings
        over = mu > self.coefficients.limiting_stress_ratio
        intervals = lower, upper, own_lower, own_upper
        return Prediction(sign * mu, *intervals, *where, over, self.wrong)

    def predict_at(
        self,
        max_hertz_pressure: Any,
        entrainment_speed: Any,
        inlet_temperature: Any,
        slide_roll_ratio: Any,
        level: float = 0.95,
    ) -> Prediction:
        """As the function `predict`, with this law: GPa, m/s, degC, or quantities of pint."""
        if self.law.conditions != CONDITIONS:
            raise OilfilmError(
                f"the law {self.law.name} is one of {', '.join(self.law.conditions)}; use the "
                "method predict of the fitted law, which takes rows of them."
            )
        given, labelled = _aligned(
            max_hertz_pressure, entrainment_speed, inlet_temperature, slide_roll_ratio
        )
        arrays = np.broadcast_arrays(*map(in_unit, given, (*CONDITIONS, SLIP)))
        *conditions, slip = (np.asarray(array, dtype=float).ravel() for array in arrays)
        rows = np.column_stack(conditions)
        found = dict(vars(self.predict(rows, slip, level)))
        if lost := int(np.isnan(found["traction_coefficient"]).sum()):
            why = "; ".join(condition.sentence() for condition in self.away_from(rows))
            if np.isnan(self.coefficients.constants).any():
                why = "nothing could be fitted"
            if why:
                text = f"mu is NaN at {lost} of {len(slip)} points: {why}"
                warnings.warn(text, stacklevel=2)
        wrong, shape = found.pop("wrong"), arrays[0].shape
        parts = {name: labelled(each.reshape(shape), name) for name, each in found.items()}
        return Prediction(**parts, wrong=wrong)

    def on_line(self, conditions: FloatArray) -> FloatArray:
        """Conditions with those that the fit does not follow at their tested level or line.

        Args:
            conditions: Rows of the law's conditions.
        """
        levels = self._by_name(conditions)
        lines = {fixed.condition: fixed.on_line(levels) for fixed in self.coefficients.fixed}
        return np.column_stack(list((levels | lines).values()))

    @property
    def reach(self) -> FloatArray:
        """The tested box, wider by `within` for conditions that the fit does not follow.

        Shape (conditions + 1, 2), as `Coefficients.box`.
        """
        beyond = {fixed.condition: fixed.within for fixed in self.coefficients.fixed}
        names = (*self.law.conditions, "slide_roll_ratio")
        within = np.array([[beyond.get(name, 0.0)] for name in names])
        least = np.array([[LEAST_SIZE.get(name, 0.0)] for name in names])
        box = self.coefficients.box
        return box + within * np.maximum(np.abs(box), least) * [-1.0, 1.0]

    def away_from(self, conditions: FloatArray) -> dict[FixedCondition, npt.NDArray[np.bool_]]:
        """The conditions that rows ask for away from where they were tested, and which rows do.

        Args:
            conditions: Rows of the law's conditions.
        """
        levels, coefficients = self._by_name(conditions), self.coefficients
        fixed = () if np.isnan(coefficients.constants).any() else coefficients.fixed
        rows = {condition: away(condition, levels) for condition in fixed}
        return {condition: off for condition, off in rows.items() if off.any()}

    def _by_name(self, conditions: FloatArray) -> dict[str, FloatArray]:
        return dict(zip(self.law.conditions, conditions.T, strict=True))

    def _with_gradient(
        self, conditions: FloatArray, slip: FloatArray
    ) -> tuple[FloatArray, FloatArray]:
        law, coefficients = self.law, self.coefficients
        design = law.design(conditions, coefficients.known)
        sizes = law.sizes(to_internal(law, coefficients.constants), design)
        mu, slopes = law.value_and_slopes(sizes, np.abs(slip))
        return mu, np.hstack([slope[:, np.newaxis] * design for slope in slopes])

    def _unseen_bend(self, conditions: FloatArray, slip: FloatArray, mu: FloatArray) -> FloatArray:
        """Change of mu that two levels of a condition cannot tell: (points, such conditions)."""
        bends = np.empty((len(mu), len(self.coefficients.two_levels)))
        for column, name in enumerate(self.coefficients.two_levels):
            index = self.law.conditions.index(name)
            moved = conditions.copy()
            moved[:, index] = between_two_levels(moved[:, index], *self.coefficients.box[index])
            bends[:, column] = self._with_gradient(moved, slip)[0] - mu
        return bends

    @cached_property
    def lattice(self) -> tuple[FloatArray, FloatArray]:
        """Tested conditions, shape (curves, n), and their steps (n,), of the n followed ones.

        Pressure, speed and load by their logarithm, temperature in kelvins.
        """
        at = self._coordinates(self.coefficients.tested)
        steps = [np.diff(np.sort(values)).max(initial=0.0) for values in at.T]
        return at, np.where(np.array(steps) > 0, steps, np.inf)

    def _coordinates(self, conditions: FloatArray) -> FloatArray:
        fixed = {each.condition for each in self.coefficients.fixed}
        columns = [
            values if name in LEAST_SIZE else np.log(np.maximum(values, np.finfo(float).tiny))
            for name, values in self._by_name(conditions).items()
            if name not in fixed
        ]
        return np.stack(columns, axis=-1) if columns else np.empty((len(conditions), 0))

    def spacings(self, conditions: FloatArray) -> FloatArray:
        """Distance to the nearest tested conditions, as of `Prediction`.

        Args:
            conditions: Rows of the law's conditions.
        """
        if not len(self.coefficients.tested) or np.isnan(self.coefficients.constants).any():
            return np.full(len(conditions), np.nan)
        at, steps = self.lattice
        asked = self._coordinates(conditions)
        nearest = np.full(len(asked), np.inf)
        for curve in at:
            away = np.abs(asked - curve) / steps
            nearest = np.minimum(nearest, away.max(axis=1, initial=0.0))
        return nearest

    def _distance(self, conditions: FloatArray, slip: FloatArray) -> FloatArray:
        low, high = self.reach.T
        at = np.column_stack([conditions, np.abs(slip)])
        beyond = np.maximum(np.maximum(low - at, at - high), 0.0)
        beyond[reaches(at, low) & reaches(high, at)] = 0.0
        width = high - low
        with np.errstate(divide="ignore", invalid="ignore"):
            ranges = np.where(beyond == 0, 0.0, beyond / width)
        # beyond one range is outside, whatever is unknown of the others
        known = np.fmax.reduce(ranges, axis=1)
        return np.where(known > 0, known, ranges.max(axis=1))


def _in_order(law: Law, rows: pd.DataFrame) -> FloatArray:
    """Constants in the law's order; X0 where its exponents are not known is the coefficient X."""
    names = [constant.name for constant in law.constants]
    values = rows.reindex(columns=names).to_numpy(dtype=float, copy=True)
    local = rows.reindex(columns=list(law.local_constants)).to_numpy(dtype=float)
    heads = np.array([constant.condition is None for constant in law.constants])
    at_level = np.isnan(values[:, heads]) & ~np.isnan(local)
    values[:, heads] = np.where(at_level, local, values[:, heads])
    # exponents that the law gives; those of conditions that never varied have no effect to carry
    fitted = ~np.isnan(values[:, heads]).any(axis=1, keepdims=True)
    return np.where(~heads & fitted & np.isnan(values), law.known, values)


def read_fit(folder: Path | str, oil: str | None = None) -> FittedLaw:
    """The fit of one oil from a campaign's results, as `results/demo`, or of a saved fit.

    Args:
        folder: With the folder `tables` in it.
        oil: Not needed where there is one oil only.

    Raises:
        OilfilmError: There are no such results, or no such oil in them.

    Examples:
        A fit that was saved as `june`. Of a campaign: `oilfilm.read_fit("results/demo", "4102")`.

        >>> import tempfile
        >>> import oilfilm
        >>> constants = [-0.01567792, 1.6654, -0.5014, -0.1065]
        >>> constants += [0.63482685, 1.2727, -0.4139, -1.2181]
        >>> constants += [24.43483717, 0.3964, 0.1591, -0.7121]
        >>> at = np.meshgrid([1.0, 1.25, 1.5], [25, 40], [50, 120], [0.01, 0.03, 0.1, 0.3])
        >>> mu = oilfilm.predict("deng2026", constants, *at).traction_coefficient
        >>> with tempfile.TemporaryDirectory() as folder:
        ...     oilfilm.fit(*at, mu, searches=2, bootstrap=20).save(f"{folder}/june")
        ...     law = oilfilm.read_fit(f"{folder}/june")
        >>> float(law.predict_at(1.2, 30, 70, 0.05).traction_coefficient)
        0.0107...
    """
    for name in ("coefficients", "refits", "fit_quality", "curve_residuals", "soundness"):
        refuse_unpacking(Path(folder, "tables", f"{name}.parquet"))
    results = CampaignTables.in_folder(Path(folder))
    oils = sorted(results.configured.fit_quality["oil"])
    oil = oils[0] if oil is None and len(oils) == 1 else oil
    if oil is None or oil not in oils:
        raise OilfilmError(
            f"{folder}: no fit of oil {oil!r}; there are fits of {', '.join(oils) or 'none'}."
        )
    fit = FittedLaw.of_configured(results, oil)
    verdicts = results.soundness
    (verdict,) = tables.rows(verdicts[verdicts["oil"] == oil])
    return replace(fit, wrong=tuple(what_is_wrong(verdict)))


# Beyond these no traction test is; what such a number is most likely.
_POSSIBLE = {
    "max_hertz_pressure_gpa": (0.0, 10.0, "in MPa? Divide by 1000"),
    "entrainment_speed_m_s": (0.0, 500.0, "in mm/s? Divide by 1000"),
    "inlet_temperature_c": (-100.0, 350.0, "in kelvins? Subtract 273.15"),
    "load_n": (0.0, 1e5, "in mN? Divide by 1000"),
    SLIP: (-2.0, 2.0, "in percent? Divide by 100"),
    "traction_coefficient": (-1.0, 1.0, "in percent? Divide by 100"),
}


def refuse_impossible(values: FloatArray, name: str) -> None:
    """Refuse values that no traction test has, most often because of their unit; NaN passes.

    Args:
        values: In the unit of the column.
        name: Name of the column.

    Raises:
        OilfilmError: A value is out of the possible range.
    """
    low, high, hint = _POSSIBLE.get(name, (-np.inf, np.inf, ""))
    # a load, pressure or speed of 0 makes no contact
    possible = (values >= low) & (values <= high) & ((values > 0) | (low < 0))
    wrong = np.flatnonzero(~np.isnan(values.ravel()) & ~possible.ravel())
    if len(wrong):
        found = values.ravel()[wrong[0]]
        if found < low:
            celsius = name == "inlet_temperature_c"
            hint = "converted from kelvins twice? Add 273.15" if celsius else "of the wrong sign"
        unit = "" if tables.COLUMNS[name].unit == "1" else f" {tables.COLUMNS[name].unit}"
        raise OilfilmError(
            f"{name}: found {found:g}{unit} at {len(wrong)} of {values.size} points, the first is "
            f"number {wrong[0] + 1}; expected {'' if low else 'above '}{low:g} to {high:g}{unit}."
            + (f" Perhaps {hint}." if found else "")
        )


def in_unit(value: Any, name: str) -> npt.NDArray[np.float64]:
    """Values of a condition or of the slide-roll ratio; quantities of pint are converted.

    Args:
        value: Numbers in the unit of the column `name`, or a quantity of pint.
        name: Name of the column.

    Raises:
        OilfilmError: The quantity has a unit of something else, or a value is impossible.
    """
    unit = "dimensionless" if name == SLIP else QUANTITIES[name].unit
    if hasattr(value, "magnitude") and hasattr(value, "to"):
        try:
            value = value.to(unit).magnitude
        except Exception as error:
            raise OilfilmError(f"{name}: {error}; expected a unit such as {unit}.") from error
    values = np.asarray(value, dtype=float)
    refuse_impossible(values, name)
    return values


def predict(
    law: str | Law,
    coefficients: Coefficients | FloatArray,
    max_hertz_pressure: Any,
    entrainment_speed: Any,
    inlet_temperature: Any,
    slide_roll_ratio: Any,
    level: float = 0.95,
) -> Prediction:
    """Traction coefficient with its intervals, and whether the point was ever tested.

    Args:
        law: A law of pressure, speed and temperature, or its name.
        coefficients: Of a fit (`read_fit(...).coefficients`), or bare constants in the law's
            order: these give mu without interval or box.
        max_hertz_pressure: P in GPa, or a quantity of pint, as the others.
        entrainment_speed: U in m/s.
        inlet_temperature: T in degC. NaN for a condition that the fit does not follow asks for
            its tested level.
        slide_roll_ratio: Slide-roll ratio S. The four broadcast against each other, arrays of
            xarray by the names of their dimensions.
        level: Of confidence.

    Returns:
        Arrays of the broadcast shape, columns or arrays of xarray as the arguments were.

    Warns:
        UserWarning: mu is NaN at some points because it is not known there; it says why.

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
        coefficients = Coefficients.bare(law, coefficients)
    at = (max_hertz_pressure, entrainment_speed, inlet_temperature, slide_roll_ratio)
    return FittedLaw(law, coefficients).predict_at(*at, level=level)


def _aligned(*given: Any) -> tuple[tuple[Any, ...], Callable[[npt.NDArray[Any], str], Any]]:
    """The arguments as they broadcast, and what labels an array as they are labelled.

    Raises:
        OilfilmError: Two columns of pandas have different indices.
    """
    if any(hasattr(value, "dims") for value in given):
        xarray = importlib.import_module("xarray")
        wrapped = (value if hasattr(value, "dims") else xarray.DataArray(value) for value in given)
        given = xarray.broadcast(*wrapped)
        return given, lambda array, name: given[0].copy(data=array).rename(name)
    indices = [value.index for value in given if isinstance(value, pd.Series)]
    if not indices:
        return given, lambda array, name: array
    if not all(index.equals(indices[0]) for index in indices):
        raise OilfilmError("the columns have different indices; take them from one data frame.")
    return given, lambda array, name: pd.Series(array, indices[0], name=name)
