"""Fits on arrays, for a notebook or another program: no workflow, no files.

Decides: fits on arrays, without files.
"""

import warnings
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from html import escape
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
import pandas as pd

from oilfilm import tables
from oilfilm.errors import OilfilmError
from oilfilm.fits.conditions import levels_of
from oilfilm.fits.fit import fit_oil
from oilfilm.fits.fitted import INTERVALS, SLIP, FittedLaw, Prediction, in_unit, refuse_impossible
from oilfilm.fits.soundness import verdict_of_fit
from oilfilm.fits.soundness_words import what_is_wrong
from oilfilm.home import CONFIG
from oilfilm.settings.config import FitSettings
from oilfilm.settings.messages import check
from oilfilm.settings.resolve import read_config
from oilfilm.settings.rig import Calibration
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.traction import LAWS, PAPER_LAW
from oilfilm.traction.law import CONDITIONS, QUANTITIES

_MU = "traction_coefficient"
_OIL = "oil"
# Of a curve drawn between its points.
_DRAWN = 200
# Curves of a picture; more hide each other.
_CURVES = 5


@dataclass(frozen=True)
class ArrayFit:
    """A law fitted to arrays.

    Attributes:
        points: What was fitted, one row per point; `run_id` names its curve.
        tables: The tables of the fit, as the workflow writes them; the oil is called `oil` there.
        settings: Settings of the fit.
        notes: What its user must know of the points, in sentences.
        source: File of the table that was fitted, else empty.
        oil: Name of the oil.
    """

    points: pd.DataFrame
    tables: CampaignTables
    settings: FitSettings
    notes: tuple[str, ...]
    source: str = ""
    oil: str = _OIL

    @cached_property
    def law(self) -> FittedLaw:
        """The fitted law, with its intervals and tested box, and what is wrong with it."""
        fit = FittedLaw.of_configured(self.tables, _OIL)
        return replace(fit, wrong=tuple(what_is_wrong(self.soundness)))

    @property
    def table(self) -> pd.DataFrame:
        """The points as a table of points of a campaign."""
        return _table_of(self.points, self.oil)

    @property
    def constants(self) -> pd.DataFrame:
        """Constants by name with their standard errors and joint intervals; NaN where unknown."""
        columns = ["constant", "value", "standard_error", "lower", "upper"]
        return self.tables.coefficients[columns].set_index("constant")

    @cached_property
    def soundness(self) -> dict[str, Any]:
        """The verdict in three parts, as a row of the table `soundness`.

        Runs are taken to have been made in the order of their names.
        """
        (row,) = tables.rows(self.tables.fit_quality)
        fit = FittedLaw.of_configured(self.tables, _OIL)
        patterns = read_config(CONFIG).patterns
        return verdict_of_fit(row, fit, self.table, self.settings, patterns)

    @property
    def verdict(self) -> str:
        """Whether the fit is sound, and what its user must know."""
        # templates are loaded when words are asked for, here and below: a fit needs none
        from oilfilm.report.sections.build import curve_facts  # noqa: PLC0415

        quality, law = self.tables.fit_quality, self.law
        lines = [f"{law.law.name}: sound: optimum confirmed, law adequate, runs steady"]
        if not self.soundness["sound"]:
            lines = [f"{law.law.name}: NOT sound", *law.wrong]
            lines += [*quality.loc[~quality["certified"], "certificate"]]
        lines += [f"Not followed: {fixed.sentence()}." for fixed in law.coefficients.fixed]
        if np.isnan(law.coefficients.unseen.at(0.95)[0]):
            least = self.settings.min_curves_for_errors
            lines += [f"There is no interval: fewer than {least} curves (min_curves_for_errors)."]
        warnings = curve_facts(quality, self.tables.curve_residuals)
        return "\n".join([*lines, *(fact.text for fact in warnings), *self.notes])

    def summary(self) -> str:
        """Equation, counts, misfit, constants with intervals, and the verdict, as text."""
        (row,) = tables.rows(self.tables.fit_quality)
        counts = (
            f"{row['n_points']} points in {row['n_curves']} curves; misfit "
            f"{row['relative_rms']:.2%} of mu (rms), at curves left out "
            f"{row['left_out_rmse'] / row['rmse']:.2f} times that; BIC {row['bic']:.1f}"
        )
        lines = [self.law.law.formula, counts, self.constants.to_string(), self.verdict]
        return "\n".join(lines)

    def to_frame(self) -> pd.DataFrame:
        """The points with mu of the law, its intervals and the residual."""
        at = self.points[list(self.law.law.conditions)].to_numpy(float)
        predicted = self.law.predict(at, self.points[SLIP].to_numpy(float))
        columns = {name: getattr(predicted, name) for name in INTERVALS}
        made = self.points.assign(fitted=predicted.traction_coefficient, **columns)
        return made.assign(residual=made[_MU] - made["fitted"])

    def predict(self, *at: Any, **level: float) -> Prediction:
        """mu with its interval at P, U, T and S, in GPa, m/s and degC or as quantities of pint.

        Raises:
            OilfilmError: A quantity has a unit of something else.
        """
        return self.law.predict_at(*at, **level)

    def save(self, folder: Path | str) -> None:
        """Write tables, exports for bearing codes, a summary and a report into a new folder.

        `oilfilm.read_fit(folder)` and `oilfilm predict --results folder` read them.

        Raises:
            OilfilmError: The folder exists, or its name cannot be that of a campaign.
        """
        # only who saves waits for the report
        from oilfilm.saved_fit import FitAlone, save_fit  # noqa: PLC0415

        alone = FitAlone(self.oil, self.table, self.tables, self.settings, self.source)
        save_fit(alone, Path(folder))

    def export(self, file: Path | str) -> None:
        """Write the law for another program, in the form that the ending of the file names.

        `.py`, `.h` (C), `.f90`, `.m` (MATLAB), `.mo` (Modelica), `.xlsx`, `.json` or `.csv`.

        Raises:
            OilfilmError: There is no such form, or nothing could be fitted.
        """
        from oilfilm.saved_fit import FitAlone, export_fit  # noqa: PLC0415 - as above

        alone = FitAlone(self.oil, self.table, self.tables, self.settings, self.source)
        export_fit(alone, Path(file))

    def plot(self, axes: Any = None, at: npt.ArrayLike | None = None) -> Any:
        """Draw the law with the interval of the next run, and the measured points.

        Args:
            axes: Axes of matplotlib to draw into; new ones if not given.
            at: Conditions, one row each in the order of the law's: `[[1.2, 30, 70]]` for GPa, m/s
                and degC. If not given, up to five tested ones from low to high traction.

        Returns:
            The axes.
        """
        if axes is None:
            from matplotlib import pyplot  # noqa: PLC0415 - only who draws waits for it

            axes = pyplot.subplots(layout="constrained")[1]
        names = list(self.law.law.conditions)
        units = [QUANTITIES[name].unit for name in names]
        curves = self.points.groupby("run_id", sort=False)
        tested = curves[names].mean()
        slip = np.linspace(0, self.points[SLIP].abs().max(), _DRAWN)
        if at is None:
            order = curves[_MU].max().argsort().to_numpy()
            chosen = np.linspace(0, len(order) - 1, min(len(order), _CURVES)).round().astype(int)
            at = tested.to_numpy()[order[chosen]]
        axes.plot(self.points[SLIP], self.points[_MU], ".", color="0.85", zorder=0)
        for row in np.atleast_2d(np.asarray(at, float)):
            predicted = self.law.predict(np.tile(row, (_DRAWN, 1)), slip)
            label = ", ".join(f"{value:.3g} {unit}" for value, unit in zip(row, units, strict=True))
            (line,) = axes.plot(slip, predicted.traction_coefficient, label=label)
            band = (slip, predicted.obs_ci_lower, predicted.obs_ci_upper)
            axes.fill_between(*band, color=line.get_color(), alpha=0.2, linewidth=0)
            near = tested[np.isclose(tested, row, rtol=0.01).all(axis=1)].index
            own = self.points[self.points["run_id"].isin(near)]
            axes.plot(own[SLIP], own[_MU], "o", markersize=3, color=line.get_color())
        axes.set(xlabel="Slide-roll ratio", ylabel="Traction coefficient")
        axes.legend(fontsize="small", title="Line: law. Band: 95 % interval of the next run")
        return axes

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
    curve: npt.ArrayLike | None = None,
    calibration: Mapping[str, float] | None = None,
    **settings: Any,
) -> ArrayFit:
    """Fit a traction law to measured points.

    Plain numbers are in the units below; quantities of pint are converted to them. All arrays
    broadcast against each other; a column of a data frame is an array as well.

    Args:
        max_hertz_pressure: P of each point, in GPa.
        entrainment_speed: U, in m/s.
        inlet_temperature: T, in degC.
        slide_roll_ratio: Slide-roll ratio S.
        traction_coefficient: Traction coefficient mu.
        law: Name of the law: one of pressure, speed and temperature.
        curve: Name or number of the run of each point. Points of a run share its calibration
            error, so whole runs are resampled for the intervals. If not given, points whose
            conditions agree within the tolerances of `gates` in config/config.yaml are one run.
        calibration: Standard uncertainties of the rig's sensors, an error that all runs share:
            `load_relative`, `traction_force_relative`, `speed_relative`, `temperature_c`.
        settings: Keys of `fit` in config/config.yaml that differ, as `bootstrap=200`.

    Raises:
        OilfilmError: There is no such law or setting, or the arrays do not fit together.

    Returns:
        The fit. Data that cannot be fitted give a verdict that says why.

    Examples:
        Twelve curves on a known law give its constants back:

        >>> import oilfilm
        >>> constants = [-0.01567792, 1.6654, -0.5014, -0.1065]
        >>> constants += [0.63482685, 1.2727, -0.4139, -1.2181]
        >>> constants += [24.43483717, 0.3964, 0.1591, -0.7121]
        >>> levels = [1.0, 1.25, 1.5], [25, 40], [50, 120], [0.01, 0.03, 0.1, 0.3]
        >>> at = np.meshgrid(*levels)
        >>> mu = oilfilm.predict("deng2026", constants, *at).traction_coefficient
        >>> fitted = oilfilm.fit(*at, mu, searches=2, bootstrap=20)
        >>> fitted.constants["value"].round(3)[["A0", "A1"]].to_dict()
        {'A0': -0.016, 'A1': 1.665}
        >>> float(fitted.predict(1.2, 30, 70, 0.05).traction_coefficient)
        0.0107...
    """
    at = (max_hertz_pressure, entrainment_speed, inlet_temperature, slide_roll_ratio)
    arrays = [*map(in_unit, at, (*CONDITIONS, SLIP)), np.asarray(traction_coefficient, float)]
    try:
        columns = [array.ravel() for array in np.broadcast_arrays(*arrays)]
    except ValueError as error:
        shapes = ", ".join(str(array.shape) for array in arrays)
        raise OilfilmError(f"the arrays have shapes that do not match: {shapes}.") from error
    points = pd.DataFrame(dict(zip((*CONDITIONS, SLIP, _MU), columns, strict=True)))
    return fit_points(points, CONDITIONS, law, curve, calibration, **settings)


def fit_points(
    points: pd.DataFrame,
    conditions: tuple[str, ...],
    law: str,
    curve: npt.ArrayLike | None = None,
    calibration: Mapping[str, float] | None = None,
    **settings: Any,
) -> ArrayFit:
    """Fit a law to points; `fit` and `fit_table` come here.

    Args:
        points: Conditions, slide-roll ratio and mu by their columns' names.
        conditions: What the law must be one of.
        law: Its name.
        curve: As of `fit`.
        calibration: As of `fit`.
        settings: As of `fit`.

    Raises:
        OilfilmError: As by `fit`.

    Warns:
        UserWarning: There are nearly as many curves as points.
    """
    if law not in LAWS or LAWS[law].conditions != conditions:
        known = ", ".join(name for name, each in LAWS.items() if each.conditions == conditions)
        raise OilfilmError(f"there is no law {law!r} of these conditions; the laws are {known}.")
    for name in (*conditions, SLIP, _MU):
        values = points[name].to_numpy(dtype=float)
        if len(lost := np.flatnonzero(~np.isfinite(values))):
            raise OilfilmError(
                f"{name}: {len(lost)} of {len(values)} points have no number, the first is number "
                f"{lost[0] + 1} ({values[lost[0]]}). Leave these points out."
            )
        refuse_impossible(values, name)
    config = read_config(CONFIG)
    same = config.same_condition
    at = [levels_of(name, points[name].to_numpy(float), same) for name in conditions]
    runs = points.groupby(at, sort=False).ngroup() if curve is None else curve
    if np.size(runs) != len(points):
        raise OilfilmError(f"`curve` has {np.size(runs)} values; expected {len(points)}.")
    points = points.assign(run_id=np.asarray(runs).astype(str).ravel())
    notes: tuple[str, ...] = ()
    count = points["run_id"].nunique()
    if len(points) > 1 and count > len(points) / 2:
        notes = (
            f"{len(points)} points are taken for {count} curves. Points of one run share its "
            "errors: intervals are far too narrow if they are taken apart. Give curve=.",
        )
        warnings.warn(notes[0], stacklevel=3)
    given_settings = {**config.fit.model_dump(), **settings, "law": law}
    chosen = check(given_settings, FitSettings, lambda steps: "oilfilm.fit")
    table = _table_of(points)
    if calibration is not None:
        stated = check(dict(calibration), Calibration, lambda steps: "calibration")
        table = _calibrated(table, stated)
    return ArrayFit(points, fit_oil(table, _OIL, chosen, config.seed), chosen, notes)


def _calibrated(points: pd.DataFrame, calibration: Calibration) -> pd.DataFrame:
    """A table of points with the errors that all its runs share; forces are over the load."""
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


def _table_of(points: pd.DataFrame, oil: str = _OIL) -> pd.DataFrame:
    """Points as a table of points of a campaign."""
    whole = points.assign(oil=oil, accepted=True, n_samples=1, first_row=points.index + 1)
    return tables.filled(whole, "points", "the table")
