"""Fits on arrays, for a notebook or another program: no workflow is needed.

Files are written by `ArrayFit.save` and `ArrayFit.export` alone.

Decides: fits on arrays.
"""

import math
import warnings
from collections.abc import Collection, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from html import escape
from itertools import combinations
from pathlib import Path
from typing import Any, Unpack

import numpy as np
import numpy.typing as npt
import pandas as pd

from oilfilm import tables
from oilfilm.api.axes import given_or_new_axes
from oilfilm.api.fit_keys import FitKeys
from oilfilm.base.errors import OilfilmError, cut
from oilfilm.base.home import CONFIG
from oilfilm.base.labels import aligned_arguments
from oilfilm.fits.certificate_sentences import certificate_sentence
from oilfilm.fits.conditions import condition_level_numbers
from oilfilm.fits.fit import fit_oil
from oilfilm.fits.fitted import (
    INTERVAL_COLUMNS,
    SLIP,
    FittedLaw,
    Prediction,
    in_column_unit,
    refuse_impossible_values,
)
from oilfilm.fits.interval import CONFIDENCE
from oilfilm.fits.soundness import soundness_row
from oilfilm.fits.soundness_sentences import soundness_warnings
from oilfilm.fits.surface_search import with_surface
from oilfilm.fits.surface_sentences import surface_sentences
from oilfilm.settings.config import FitSettings
from oilfilm.settings.messages import validated
from oilfilm.settings.resolve import read_config
from oilfilm.settings.rig import Calibration
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.traction import LAWS, PAPER_LAW, reason_for_comparison_only
from oilfilm.traction.law import CONDITIONS, QUANTITIES

_MU = "traction_coefficient"
_LOAD = "load_n"
# Name of the oil in the tables of every fit. Saving the fit replaces it there by the true name.
# It is also the name of an oil that the caller does not name.
_OIL_IN_TABLES = "oil"
# Number of points at which a curve of the law is evaluated for a plot.
_POINTS_PER_DRAWN_CURVE = 200
# More curves in one plot hide each other.
_MAX_DRAWN_CURVES = 5
# Correlations from this size on are named in the summary, the largest ones first.
_STRONG_CORRELATION = 0.9
_MAX_SHOWN_CORRELATIONS = 5
# Measured points are marked beside a curve if none of their conditions differs by more than this,
# relatively.
_SAME_CONDITION_TOLERANCE = 0.01


@dataclass(frozen=True)
class ArrayFit:
    """A law fitted to arrays.

    Attributes:
        points: The fitted points, one row per point; `run_id` names the curve.
        tables: The tables of the fit, as the workflow writes them. Their column `oil` holds `oil`,
            whatever the name of the oil.
        settings: Settings of the fit.
        notes: Warnings and assumptions about the points, in sentences.
        source: File of the fitted table; empty for arrays.
        oil: Name of the oil.
        simulated: Whether a program wrote the points, and no rig measured them.
    """

    points: pd.DataFrame
    tables: CampaignTables
    settings: FitSettings
    notes: tuple[str, ...]
    source: str = ""
    oil: str = _OIL_IN_TABLES
    simulated: bool = False

    @cached_property
    def law(self) -> FittedLaw:
        """The fitted law, with its intervals, its tested box and the reasons if it is not sound."""
        fit = FittedLaw.from_results(self.tables, _OIL_IN_TABLES)
        return replace(fit, warnings=tuple(soundness_warnings(self.soundness)))

    @property
    def campaign_points(self) -> pd.DataFrame:
        """The points as the table `points` of a campaign."""
        return self.tables.points.assign(oil=self.oil)

    @property
    def constants(self) -> pd.DataFrame:
        """Constants by name, with standard errors and joint intervals; NaN where unknown.

        The intervals hold all constants at once, with the confidence `sign_confidence` of the
        settings (Bonferroni). Each is therefore wider than an interval of one constant alone.
        """
        columns = ["constant", "value", "standard_error", "lower", "upper"]
        return self.tables.coefficients[columns].set_index("constant")

    @property
    def correlations(self) -> pd.DataFrame:
        """Correlations of the constants over the refits of the bootstrap, a square table.

        NaN for a constant that is the same in all refits, and for all of them without refits.
        """
        constant_names = [constant.name for constant in self.law.law.constants]
        refits = pd.DataFrame(self.law.coefficients.refits, columns=constant_names)
        fitted_constant_names = [name for name in constant_names if name in self.constants.index]
        return refits[fitted_constant_names].corr()

    @property
    def r_squared(self) -> float:
        """Share of the variance of mu that the law explains; NaN where mu does not vary.

        It says little where mu varies much. Judge a fit by `verdict` and by the misfit.
        """
        conditions = self.points[list(self.law.law.conditions)].to_numpy(float)
        slip = self.points[SLIP].to_numpy(float)
        measured_mu = self.points[_MU].to_numpy(float)
        fitted_mu = self.law.without_interval().predict(conditions, slip).traction_coefficient
        variation = float(np.sum((measured_mu - measured_mu.mean()) ** 2))
        if variation == 0:
            return float("nan")
        return 1 - float(np.sum((measured_mu - fitted_mu) ** 2)) / variation

    @cached_property
    def soundness(self) -> dict[str, Any]:
        """The verdict on optimum, law and campaign, as a row of the table `soundness`.

        Arrays hold no times. A change over the campaign is therefore looked for in the order of the
        names of the runs: run 2 comes before run 10.
        """
        (quality,) = tables.rows(self.tables.fit_quality)
        fit = FittedLaw.from_results(self.tables, _OIL_IN_TABLES)
        config = read_config(CONFIG).model_copy(update={"fit": self.settings})
        return soundness_row(quality, fit, self.campaign_points, config)

    @property
    def verdict(self) -> str:
        """Whether the fit is sound, and what its user must know, as lines of text."""
        # imported late, here and below: templates of sentences load slowly, and a fit needs none
        from oilfilm.report.sections.build import curve_facts  # noqa: PLC0415

        fitted_law = self.law
        coefficients = fitted_law.coefficients
        law_name = fitted_law.law.name
        # the table of a fit of arrays has one row
        (quality,) = tables.rows(self.tables.fit_quality)
        if self.soundness["sound"]:
            lines = [f"{law_name}: sound: optimum confirmed, law adequate, runs steady"]
        else:
            lines = [f"{law_name}: NOT sound"]
            lines.extend(fitted_law.warnings)
            if not quality["certified"]:
                lines.append(certificate_sentence(quality))
        # conditions that give no exponent, because they did not vary, or not alone
        lines.extend(
            f"Not followed: {fixed.sentence()}." for fixed in coefficients.fixed_conditions
        )
        if fitted_law.surface is None:
            lines.append(f"There is no interval: {fitted_law.why_no_interval}.")
        lines.extend(surface_sentences(self.tables, _OIL_IN_TABLES, self.soundness))
        facts = curve_facts(self.tables.fit_quality, self.tables.curve_residuals)
        lines.extend(fact.text for fact in facts)
        lines.extend(self.notes)
        return "\n".join(lines)

    def summary(self) -> str:
        """Equation, counts, misfit, constants with intervals, and the verdict, as text."""
        (quality,) = tables.rows(self.tables.fit_quality)
        at_curves_left_out = ""
        # an exact fit has no misfit to compare with
        if quality["rmse"] > 0:
            ratio = quality["left_out_rmse"] / quality["rmse"]
            at_curves_left_out = f", at curves left out {ratio:.2f} times that"
        counts = (
            f"{quality['n_points']} points in {quality['n_curves']} curves; misfit "
            f"{quality['relative_rms']:.2%} of mu (rms){at_curves_left_out}; "
            f"R2 {self.r_squared:.5f}; BIC {quality['bic']:.1f}"
        )
        lines = ["SIMULATED data"] if self.simulated else []
        lines += [self.law.law.formula, counts, self.constants.to_string()]
        lines += self._lines_on_constants()
        lines.append(self.verdict)
        return "\n".join(lines)

    def _lines_on_constants(self) -> Iterator[str]:
        """What the intervals of the constants are, and which constants are correlated."""
        if self.constants["lower"].isna().all():
            return
        confidence = f"{self.settings.sign_confidence:.0%}"
        yield (
            f"lower, upper: joint {confidence} intervals, which hold all constants at once "
            f"({confidence} by Bonferroni)"
        )
        correlations = self.correlations
        constant_names = correlations.index
        matrix = correlations.to_numpy(dtype=float)
        correlation_by_pair = {
            f"{constant_names[row]} {constant_names[column]}": float(matrix[row, column])
            for row, column in combinations(range(len(constant_names)), 2)
        }
        strong_correlations = {
            pair: correlation
            for pair, correlation in correlation_by_pair.items()
            if abs(correlation) >= _STRONG_CORRELATION
        }
        if not strong_correlations:
            return
        strongest = sorted(strong_correlations, key=lambda pair: -abs(strong_correlations[pair]))
        shown_pairs = [
            f"{pair} {strong_correlations[pair]:.2f}"
            for pair in strongest[:_MAX_SHOWN_CORRELATIONS]
        ]
        yield (
            f"correlations of {_STRONG_CORRELATION:g} or more: {len(strong_correlations)} of "
            f"{len(correlation_by_pair)} pairs of constants: "
            f"{', '.join(shown_pairs)}; all: `correlations`"
        )

    def to_frame(self) -> pd.DataFrame:
        """The points with mu of the law, its intervals and the residual."""
        conditions = self.points[list(self.law.law.conditions)].to_numpy(float)
        slip = self.points[SLIP].to_numpy(float)
        predicted = self.law.predict(conditions, slip)
        fitted_mu = self.law.without_interval().predict(conditions, slip).traction_coefficient
        intervals = {name: getattr(predicted, name) for name in INTERVAL_COLUMNS}
        frame = self.points.assign(fitted=fitted_mu, **intervals)
        return frame.assign(residual=frame[_MU] - frame["fitted"])

    def predict(
        self,
        max_hertz_pressure: Any,
        entrainment_speed: Any,
        inlet_temperature: Any,
        slide_roll_ratio: Any,
        level: float = CONFIDENCE,
    ) -> Prediction:
        """mu with its interval, as `FittedLaw.predict_at`.

        Args:
            max_hertz_pressure: P in GPa: numbers, arrays or quantities of pint.
            entrainment_speed: U in m/s.
            inlet_temperature: T in degC.
            slide_roll_ratio: S.
            level: Confidence level.

        Raises:
            OilfilmError: A quantity has a unit of something else.
        """
        return self.law.predict_at(
            max_hertz_pressure, entrainment_speed, inlet_temperature, slide_roll_ratio, level
        )

    def save(self, folder: Path | str) -> None:
        """Write tables, exports for bearing codes, a summary and a report into a new folder.

        `oilfilm.read_fit(folder)` and `oilfilm predict --results folder` read them.

        Raises:
            OilfilmError: The folder exists, or its name cannot be that of a campaign.
        """
        # imported late: the report loads slowly, and only this method needs it
        from oilfilm.api.saved_fit import save_fit  # noqa: PLC0415

        save_fit(self, Path(folder))

    def export(self, file: Path | str) -> None:
        """Write the law for another program, in the form that the ending of the file names.

        `.py`, `.h` (C), `.f90`, `.m` (MATLAB), `.mo` (Modelica), `.xlsx`, `.json` or `.csv`.

        Raises:
            OilfilmError: There is no such form, or nothing could be fitted.
        """
        from oilfilm.api.saved_fit import export_fit  # noqa: PLC0415 - as in `save`

        export_fit(self, Path(file))

    def plot(self, axes: Any = None, at: npt.ArrayLike | None = None) -> Any:
        """Draw the law with the interval of the next run, and the measured points.

        Args:
            axes: Axes of matplotlib to draw into; new ones if not given.
            at: Operating points, one row each, in the order of the law's conditions:
                `[[1.2, 30, 70]]` for GPa, m/s and degC. If not given, up to five tested operating
                points from low to high traction.

        Returns:
            The axes. `plot().figure.savefig(FILE)` writes a file.

        Raises:
            OilfilmError: `axes` are no axes, `at` holds no operating points, or matplotlib is
                missing.
        """
        operating_points = self._tested_operating_points()
        if at is None:
            conditions_of_curves = self._spread_over_traction(operating_points)
        else:
            conditions_of_curves = self._typed_operating_points(at)
        axes = given_or_new_axes(axes)
        axes.plot(self.points[SLIP], self.points[_MU], ".", color="0.85", zorder=0)
        for conditions in conditions_of_curves:
            self._draw_curve(axes, conditions, operating_points)
        axes.set(xlabel="Slide-roll ratio", ylabel="Traction coefficient")
        axes.legend(fontsize="small", title="Line: law. Band: the next run, its whole curve")
        if self.simulated:
            axes.set_title("SIMULATED data", loc="right", fontsize="small")
        return axes

    def _tested_operating_points(self) -> pd.DataFrame:
        """Mean conditions of each curve, by `run_id`."""
        conditions = list(self.law.law.conditions)
        return self.points.groupby("run_id", sort=False)[conditions].mean()

    def _typed_operating_points(self, at: npt.ArrayLike) -> npt.NDArray[np.float64]:
        """The operating points that the caller gives, one row each.

        Raises:
            OilfilmError: They are no numbers, or a row lacks a condition.
        """
        conditions = self.law.law.conditions
        try:
            rows = np.atleast_2d(np.asarray(at, float))
        except (TypeError, ValueError):
            rows = np.empty((0, 0))
        if rows.ndim != 2 or rows.shape[1] != len(conditions):
            raise OilfilmError(
                f"at: found {cut(repr(at))}; expected rows of {len(conditions)} numbers each: "
                f"{', '.join(conditions)}."
            )
        return rows

    def _spread_over_traction(self, operating_points: pd.DataFrame) -> npt.NDArray[np.float64]:
        """Conditions of a few tested curves, evenly from low to high traction; a row per curve."""
        largest_mu = self.points.groupby("run_id", sort=False)[_MU].max()
        order_by_traction = largest_mu.argsort().to_numpy()
        curve_count = min(len(order_by_traction), _MAX_DRAWN_CURVES)
        ranks = np.linspace(0, len(order_by_traction) - 1, curve_count).round().astype(int)
        return operating_points.to_numpy()[order_by_traction[ranks]]

    def _draw_curve(
        self, axes: Any, conditions: npt.NDArray[np.float64], operating_points: pd.DataFrame
    ) -> None:
        """Draw the law at one operating point, its interval and the points measured there."""
        slip = np.linspace(0, self.points[SLIP].abs().max(), _POINTS_PER_DRAWN_CURVE)
        conditions_of_points = np.tile(conditions, (_POINTS_PER_DRAWN_CURVE, 1))
        predicted = self.law.predict(conditions_of_points, slip, whole_curve=True)
        units = [QUANTITIES[name].unit for name in self.law.law.conditions]
        label = ", ".join(
            f"{value:.3g} {unit}" for value, unit in zip(conditions, units, strict=True)
        )
        (line,) = axes.plot(slip, predicted.traction_coefficient, label=label)
        color = line.get_color()
        lower, upper = predicted.obs_ci_lower, predicted.obs_ci_upper
        axes.fill_between(slip, lower, upper, color=color, alpha=0.2, linewidth=0)
        is_same_level = np.isclose(
            operating_points.to_numpy(), conditions, rtol=_SAME_CONDITION_TOLERANCE
        )
        runs_of_curve = operating_points.index[is_same_level.all(axis=1)]
        measured_points = self.points[self.points["run_id"].isin(runs_of_curve)]
        axes.plot(measured_points[SLIP], measured_points[_MU], "o", markersize=3, color=color)

    def __repr__(self) -> str:
        return self.summary()

    def _repr_html_(self) -> str:
        text = self.summary().replace(self.constants.to_string() + "\n", "")
        return f"<pre>{escape(text)}</pre>{self.constants.to_html(escape=True)}"


def fit(
    max_hertz_pressure: Any,
    entrainment_speed: Any,
    inlet_temperature: Any,
    slide_roll_ratio: Any,
    traction_coefficient: Any,
    *,
    law: str = PAPER_LAW.name,
    curve: Any = None,
    calibration: Mapping[str, float] | None = None,
    simulated: bool = False,
    **settings: Unpack[FitKeys],
) -> ArrayFit:
    """Fit a traction law to points.

    Plain numbers are in the units below; quantities of pint are converted to them. All arrays
    broadcast against each other, arrays of xarray by the names of their dimensions. Columns of
    pandas must have one index; columns of polars and arrays of NumPy belong together by position.

    Args:
        max_hertz_pressure: P of each point, in GPa.
        entrainment_speed: U, in m/s.
        inlet_temperature: T, in degC.
        slide_roll_ratio: Slide-roll ratio S.
        traction_coefficient: Traction coefficient mu.
        law: Name of a law whose conditions are pressure, speed and temperature.
        curve: Name or number of the run of each point. Points of a run share its calibration
            error, so the intervals come from a bootstrap over runs. If not given, points whose
            conditions agree within `same_condition` in config/config.yaml are one run.
        calibration: Standard uncertainties of the rig's sensors. All runs share these errors. Keys:
            `load_relative`, `traction_force_relative`, `speed_relative`, `temperature_c`.
        simulated: Whether a program wrote the points. What is saved of the fit then says so.
        settings: Keys of `fit` in config/config.yaml that differ, as `bootstrap=200`.

    Raises:
        OilfilmError: There is no such law or setting, or the shapes or the labels of the arrays do
            not match.

    Returns:
        The fit. Its verdict gives the reason where the data cannot be fitted.

    Examples:
        27 curves on a known law give its constants back:

        >>> import oilfilm
        >>> constants = [-0.01567792, 1.6654, -0.5014, -0.1065]
        >>> constants += [0.63482685, 1.2727, -0.4139, -1.2181]
        >>> constants += [24.43483717, 0.3964, 0.1591, -0.7121]
        >>> levels = [1.0, 1.25, 1.5], [25, 32, 40], [50, 80, 120], [0.01, 0.03, 0.1, 0.3]
        >>> grids = np.meshgrid(*levels)
        >>> mu = oilfilm.predict("deng2026", constants, *grids).traction_coefficient
        >>> fitted = oilfilm.fit(*grids, mu, searches=2, bootstrap=20)
        >>> fitted.constants["value"].round(3)[["A0", "A1"]].to_dict()
        {'A0': -0.016, 'A1': 1.665}
        >>> bool(fitted.soundness["sound"])
        True
        >>> float(fitted.predict(1.2, 30, 70, 0.05).traction_coefficient)
        0.0107...
    """
    values = (
        max_hertz_pressure,
        entrainment_speed,
        inlet_temperature,
        slide_roll_ratio,
        traction_coefficient,
    )
    column_names = (*CONDITIONS, SLIP, _MU)
    arguments = dict(zip(column_names, values, strict=True))
    if curve is not None:
        arguments["curve"] = curve
    arguments, _ = aligned_arguments(arguments)
    curve = arguments.pop("curve", None)
    arrays = [in_column_unit(value, name) for name, value in arguments.items()]
    try:
        broadcast_arrays = np.broadcast_arrays(*arrays)
    except ValueError as error:
        shapes = ", ".join(str(array.shape) for array in arrays)
        raise OilfilmError(f"the arrays have shapes that do not match: {shapes}.") from error
    shape = broadcast_arrays[0].shape
    # a list of all points is in the order of the flattened arrays
    if curve is not None and np.shape(curve) not in (shape, (math.prod(shape),)):
        raise OilfilmError(f"`curve` has the shape {np.shape(curve)}; expected {shape}.")
    points = pd.DataFrame(
        {
            column: array.ravel()
            for column, array in zip(column_names, broadcast_arrays, strict=True)
        }
    )
    fitted = fit_points(points, CONDITIONS, law, curve, calibration, **settings)
    return replace(fitted, simulated=simulated)


def fit_points(
    points: pd.DataFrame,
    condition_names: tuple[str, ...],
    law_name: str,
    curve_of_point: npt.ArrayLike | None = None,
    calibration: Mapping[str, float] | None = None,
    **settings: Unpack[FitKeys],
) -> ArrayFit:
    """Fit a law to points; the common part of `fit` and `fit_table`.

    Args:
        points: Columns of the conditions, the slide-roll ratio and mu, one row per point.
        condition_names: Columns of the conditions that the law must depend on.
        law_name: Name of the law.
        curve_of_point: Name or number of the run of each point, as `curve` of `fit`.
        calibration: As in `fit`.
        settings: As in `fit`.

    Raises:
        OilfilmError: As in `fit`, or a number is missing or impossible.

    Warns:
        UserWarning: There are fewer than two points per curve, or curves have points at several
            conditions.
    """
    law_names = [name for name, law in LAWS.items() if law.conditions == condition_names]
    refuse_unknown_law(law_name, law_names)
    for column in (*condition_names, SLIP, _MU):
        _refuse_missing_or_impossible(points[column].to_numpy(dtype=float), column)
    config = read_config(CONFIG)
    levels_of_points = [
        condition_level_numbers(name, points[name].to_numpy(float), config.same_condition)
        for name in condition_names
    ]
    condition_of_point = points.groupby(levels_of_points, sort=False).ngroup()
    run_of_point = condition_of_point if curve_of_point is None else curve_of_point
    points = points.assign(run_id=_run_names(run_of_point))
    notes = _doubts_about_runs(points["run_id"], condition_of_point)
    for note in notes:
        warnings.warn(note, stacklevel=3)
    fit_keys = {**config.fit.model_dump(), **settings, "law": law_name}
    # a message begins with the name of the function, where it usually names a file
    fit_settings = validated(fit_keys, FitSettings, location_of=lambda _: "oilfilm.fit")
    campaign_points = _campaign_points(points)
    fitted_points = campaign_points
    if calibration is not None:
        uncertainties = validated(dict(calibration), Calibration, lambda _: "calibration")
        fitted_points = _with_systematic_errors(campaign_points, uncertainties)
    fit_tables = fit_oil(fitted_points, _OIL_IN_TABLES, fit_settings, config.seed)
    fit_tables = fit_tables.replace(points=campaign_points)
    if _LOAD not in condition_names:
        # `_with_systematic_errors` takes an unknown load as 1 N, which is no tested load
        quality = fit_tables.fit_quality.assign(tested_min_load_n=np.nan, tested_max_load_n=np.nan)
        fit_tables = fit_tables.replace(fit_quality=quality)
    fit_tables = with_surface(fit_tables, _OIL_IN_TABLES, config)
    return ArrayFit(points, fit_tables, fit_settings, notes)


def refuse_unknown_law(law_name: str, law_names: Collection[str]) -> None:
    """Refuse a law that cannot be fitted to points.

    Args:
        law_name: Name of the law.
        law_names: Names of the laws that can be fitted.

    Raises:
        OilfilmError: It is none of them.
    """
    if law_name in law_names:
        return
    names = ", ".join(law_names)
    reason = reason_for_comparison_only(law_name)
    if reason:
        raise OilfilmError(f"{reason}. The laws of arrays are {names}.")
    raise OilfilmError(f"there is no law {law_name!r} for these points; the laws are {names}.")


def _run_names(run_of_point: npt.ArrayLike) -> npt.NDArray[np.str_]:
    """Name of the run of each point, shape (points,).

    Raises:
        OilfilmError: A name is missing.
    """
    names = pd.Series(np.asarray(run_of_point).ravel())
    is_missing = (names.isna() | (names.astype(str).str.strip() == "")).to_numpy()
    if is_missing.any():
        raise OilfilmError(
            f"`curve` names no run for {int(is_missing.sum())} of {len(names)} points, the first "
            f"is number {int(np.argmax(is_missing)) + 1}. Name the run of each point, or give no "
            "curve."
        )
    return names.to_numpy().astype(str)


def _doubts_about_runs(
    run_name_of_point: "pd.Series[str]", condition_of_point: "pd.Series[int]"
) -> tuple[str, ...]:
    """Sentences on runs that can hardly be runs.

    Args:
        run_name_of_point: Name of the run of each point.
        condition_of_point: Number of the condition of each point.
    """
    notes: list[str] = []
    point_count = len(run_name_of_point)
    condition_count_of_run = condition_of_point.groupby(
        run_name_of_point.to_numpy(), sort=False
    ).nunique()
    run_count = len(condition_count_of_run)
    if point_count > 1 and run_count > point_count / 2:
        notes.append(
            f"{point_count} points are taken for {run_count} curves. Points of one run share its "
            "errors: intervals are far too narrow if each point is a curve. Give all points of a "
            "run the same `curve`."
        )
    runs_of_several = condition_count_of_run.index[condition_count_of_run > 1]
    if len(runs_of_several):
        first_run = runs_of_several[0]
        notes.append(
            f"{len(runs_of_several)} of {run_count} curves have points at several conditions, as "
            f"{first_run!r} at {condition_count_of_run[first_run]}. A curve is taken for one run "
            "at the mean of its conditions: the fit is wrong where these names do not mean runs."
        )
    return tuple(notes)


def _refuse_missing_or_impossible(values: npt.NDArray[np.float64], column_name: str) -> None:
    """Refuse a column with a gap or with a number that the quantity cannot have.

    Raises:
        OilfilmError: A number is missing or impossible.
    """
    gap_indices = np.flatnonzero(~np.isfinite(values))
    if len(gap_indices):
        raise OilfilmError(
            f"{column_name}: {len(gap_indices)} of {len(values)} points have no number, the first "
            f"is number {gap_indices[0] + 1} ({values[gap_indices[0]]}). Leave these points out."
        )
    refuse_impossible_values(values, column_name)


def _with_systematic_errors(points: pd.DataFrame, calibration: Calibration) -> pd.DataFrame:
    """A table of points with the errors that all runs share.

    Where the load is unknown it is taken as 1 N, so that the force is mu.
    """
    load = points["load_n"].fillna(1.0)
    force = load * points[_MU]
    return points.assign(
        load_n=load,
        traction_force_n=force,
        load_systematic_n=calibration.load_relative * load,
        traction_force_systematic_n=calibration.traction_force_relative * force.abs(),
        entrainment_speed_systematic_m_s=calibration.speed_relative
        * points["entrainment_speed_m_s"],
        inlet_temperature_systematic_c=calibration.temperature_c,
    )


def _campaign_points(points: pd.DataFrame) -> pd.DataFrame:
    """Points as the table `points` of a campaign; columns that are not known are null."""
    # the key of the table is run and first row in the log: here the number of the point
    point_number = points.index + 1
    accepted_points = points.assign(
        oil=_OIL_IN_TABLES, accepted=True, n_samples=1, first_row=point_number
    )
    return tables.filled_table(accepted_points, "points", "the table")
