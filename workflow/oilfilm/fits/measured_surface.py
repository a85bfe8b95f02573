"""The surface of each oil: from the tables of points and fits to arrays, and back from its tables.

The tables `surfaces` and `surface_sizes` hold what a search has found. With the points and the
constants of the law they give the whole surface again.

Decides: which points a surface takes.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from oilfilm.base.units import BoolArray, FloatArray, IndexArray
from oilfilm.fits.problem import curve_data
from oilfilm.fits.run_assumptions import RunAssumptions
from oilfilm.surface.effects import ErrorPriors
from oilfilm.surface.interval import IntervalFactors, normal_half_width
from oilfilm.surface.law_mean import FreeLaw
from oilfilm.surface.limits import SurfaceLimits
from oilfilm.surface.measurements import Measurements
from oilfilm.surface.reduction import ANOTHER_RIG, box_of
from oilfilm.surface.reml import size_names
from oilfilm.surface.support import Support
from oilfilm.surface.surface import Surface, SurfaceSizes, surface_from_sizes
from oilfilm.traction.law import CONDITIONS, Law, to_internal

_PRESSURE, _SPEED, _TEMPERATURE = CONDITIONS
_LOAD = "load_n"
# Conditions of the laws on which a surface can stand.
_CONDITIONS_OF_SURFACES = (CONDITIONS, (_LOAD, _SPEED, _TEMPERATURE))
# Largest relative range of the load over the cube of the pressure in one contact.
_LARGEST_RANGE_IN_ONE_CONTACT = 0.02
# A point carries traction where the mu of the law is above this number of errors of the zero.
_LEAST_TRACTION_IN_ZERO_ERRORS = 10.0
# Columns of the table `surfaces` for the sizes of effects, by the name of the effect.
COLUMN_BY_EFFECT = {
    "gain": "gain_sd",
    "zero": "zero_sd",
    "slip_scale": "slip_scale_sd",
    "temperature_k": "temperature_sd_k",
}
# Attributes of `SurfaceLimits` that are columns of the table `surfaces` under the same names.
LIMIT_NAMES = (
    "level",
    "largest_spread",
    "fewest_slips",
    "reach_in_gaps",
    "reach_in_slip",
    "reach_in_ranges",
    "largest_spread_of_bound",
)
# Share of the readings of mu that may be below zero by chance.
_LARGEST_SHARE_BELOW_ZERO = 0.005
# Name of a rig that made none of the runs; `ANOTHER_RIG` is its number.
ANOTHER_RIG_NAME = "another"
# Searches of the sizes of a surface: attributes of `SurfaceSizes`, entries of the column `search`.
SIZE_SEARCHES = ("first", "misfit", "interval")


@dataclass(frozen=True)
class MeasuredContact:
    """The contact of an oil's tests: it turns the conditions of a law into P, U and T, and back.

    Attributes:
        load_at_1_gpa: Load in N at a maximum pressure of 1 GPa; the load goes with the cube of the
            pressure. 1 where no pressure is known: the cube root of the load then counts as P. NaN
            where the runs have several contacts, or no load.
    """

    load_at_1_gpa: float

    @classmethod
    def from_points(cls, points: pd.DataFrame) -> "MeasuredContact":
        """The contact of the accepted points of an oil."""
        pressure_gpa = points[_PRESSURE].to_numpy(dtype=float)
        load_n = points[_LOAD].to_numpy(dtype=float)
        if not np.isfinite(pressure_gpa).any():
            return cls(1.0)
        with np.errstate(invalid="ignore", divide="ignore"):
            load_at_1_gpa = load_n / pressure_gpa**3
        load_at_1_gpa = load_at_1_gpa[np.isfinite(load_at_1_gpa)]
        if not len(load_at_1_gpa):
            return cls(np.nan)
        median = float(np.median(load_at_1_gpa))
        is_one_contact = np.ptp(load_at_1_gpa) <= _LARGEST_RANGE_IN_ONE_CONTACT * median
        return cls(median if is_one_contact else np.nan)

    def surface_conditions(self, law: Law, conditions: FloatArray) -> FloatArray:
        """P in GPa, U in m/s and T in degC from rows of a law's conditions, shape (rows, 3).

        A condition that is not known is 1 throughout: no law follows it where `has_surface`.
        """
        pressures, speeds, temperatures = np.array(conditions, dtype=float).T
        if law.conditions[0] == _LOAD:
            pressures = np.cbrt(pressures / self.load_at_1_gpa)
        conditions_of_surface = np.column_stack([pressures, speeds, temperatures])
        return np.where(np.isnan(conditions_of_surface), 1.0, conditions_of_surface)

    def law_conditions(self, law: Law, conditions: FloatArray) -> FloatArray:
        """Rows of a law's conditions from P, U and T, shape (rows, 3)."""
        if law.conditions[0] != _LOAD:
            return conditions
        loads = self.load_at_1_gpa * conditions[:, 0] ** 3
        return np.column_stack([loads, conditions[:, 1:]])

    def has_surface(self, law: Law) -> bool:
        """Whether a surface can stand on a law."""
        if law.conditions not in _CONDITIONS_OF_SURFACES:
            return False
        return law.conditions[0] != _LOAD or bool(np.isfinite(self.load_at_1_gpa))


@dataclass(frozen=True)
class SurfacePrediction:
    """mu at some points, with the interval of the next good run, for positive slip.

    Attributes:
        mu: Traction coefficient for positive slip, shape (points,); 0 at pure rolling, NaN
            where the law has no traction above 0.
        lower: Lower end, shape (points,); NaN where there is no support.
        upper: Upper end, shape (points,).
        support_codes: Code of `oilfilm.surface.support.Support`, shape (points,).
    """

    mu: FloatArray
    lower: FloatArray
    upper: FloatArray
    support_codes: IndexArray


@dataclass(frozen=True)
class OilSurface:
    """The surface of one oil, as its tables have it.

    Attributes:
        law_name: Name of the law on which it stands.
        law: This law with its constants.
        contact: What turns the conditions of a law into P, U and T.
        run_ids: Name of the run of each curve, in the order of `measurements`.
        measurements: The points, in the order of `curve_data`.
        sizes: Logarithms of the sizes that the searches found.
        interval_factors: Factors of the interval of the next run.
        limits: What an answer must fulfil.
        next_run_sd: Standard deviation of ln mu in the next run, median over the points.
        misfit: Misfit of the law at the measured points, relative to mu.
        run_scatter: Change of mu by the errors of runs, relative to mu.
        no_law_fits: Whether no law fits, so that the surface answers instead.
        assumptions: What was known of the runs before the search.
    """

    law_name: str
    law: FreeLaw
    contact: MeasuredContact
    run_ids: tuple[str, ...]
    measurements: Measurements
    sizes: SurfaceSizes
    interval_factors: IntervalFactors
    limits: SurfaceLimits
    next_run_sd: float
    misfit: float
    run_scatter: float
    no_law_fits: bool
    assumptions: RunAssumptions

    @cached_property
    def surface(self) -> Surface:
        """The surface itself."""
        return surface_from_sizes(
            self.measurements, self.law, self.assumptions.error_sizes, self.sizes, self.limits
        )

    def has_two_levels(self) -> bool:
        """Whether a condition was tested at two levels only, so that no law is checked between."""
        return bool(box_of(self.measurements).has_two_levels.any())

    def interval_level(self, wanted_level: float) -> float:
        """The level of an interval: the wanted one, or less where the conditions are few."""
        return min(wanted_level, self.interval_factors.level)

    @property
    def rig_names(self) -> tuple[str, ...]:
        """Names of the rigs that the surface tells apart; empty for one rig, or unknown ones."""
        names = self.assumptions.rig_names
        return names if self.measurements.rig_count > 1 else ()

    def rig_number(self, rig_name: str | None) -> int | None:
        """The number of the rig of the next run, as `Surface.predict` takes it.

        Args:
            rig_name: Name of the rig, as in `predict`.

        Raises:
            ValueError: There is no such rig.
        """
        if rig_name is None:
            return None
        if not self.rig_names:
            raise ValueError(
                "the runs are of one rig, or their rigs are not named: nothing is known of the rig "
                f"{rig_name!r} beside them. Leave the rig out"
            )
        if rig_name == ANOTHER_RIG_NAME:
            return ANOTHER_RIG
        if rig_name not in self.rig_names:
            raise ValueError(
                f"no run is of the rig {rig_name!r}. The rigs of the runs are "
                f"{', '.join(self.rig_names)}; {ANOTHER_RIG_NAME!r} stands for one that is not "
                "among them"
            )
        return self.assumptions.rig_names.index(rig_name)

    def predict(
        self,
        law: Law,
        conditions: FloatArray,
        slip: FloatArray,
        level: float,
        whole_curve: bool,
        rig_name: str | None = None,
    ) -> SurfacePrediction:
        """mu and its interval at rows of a law's conditions.

        Args:
            law: The law whose conditions these are.
            conditions: Rows of its conditions, shape (points, conditions).
            slip: Slide-roll ratio, not below 0, shape (points,); at 0 there is no interval.
            level: Wanted level.
            whole_curve: Whether the band should hold all points of a curve.
            rig_name: Name of the rig of the next run; `ANOTHER_RIG_NAME` for one that made none of
                the runs. If it is not given, the next run is on one of the rigs of the runs.

        Raises:
            ValueError: There is no such rig, or the runs show no difference of rigs.
        """
        rig_number = self.rig_number(rig_name)
        point_count = len(slip)
        mu, lower, upper = (
            np.zeros(point_count),
            np.full(point_count, np.nan),
            np.full(point_count, np.nan),
        )
        support_codes = np.full(point_count, int(Support.SUPPORTED))
        surface_conditions = self.contact.surface_conditions(law, conditions)
        is_answerable = slip > 0
        is_answerable[is_answerable] = self.surface.is_law_positive(
            surface_conditions[is_answerable], slip[is_answerable]
        )
        has_no_traction = (slip > 0) & ~is_answerable
        mu[has_no_traction] = np.nan
        support_codes[has_no_traction] = Support.LAW_NOT_POSITIVE
        if is_answerable.any():
            prediction = self.surface.predict(
                surface_conditions[is_answerable], slip[is_answerable], rig_number
            )
            interval_factor = (
                self.interval_factors.curve if whole_curve else self.interval_factors.point
            )
            level_factor = normal_half_width(self.interval_level(level)) / normal_half_width(
                self.interval_factors.level
            )
            mu[is_answerable] = prediction.mu
            lower[is_answerable], upper[is_answerable] = prediction.interval(
                interval_factor * level_factor
            )
            support_codes[is_answerable] = prediction.support_codes
        return SurfacePrediction(mu, lower, upper, support_codes)


# ---------------------------------------------------------------- back from the tables


class LawConstants(NamedTuple):
    """A law with its fitted constants.

    Attributes:
        law: The law.
        constants: Its constants, shape (constants,).
        group_has_exponent: Whether the fit follows each of its groups, shape (groups,).
    """

    law: Law
    constants: FloatArray
    group_has_exponent: BoolArray


def surface_from_tables(
    surface_row: Mapping[str, Any],
    size_rows: pd.DataFrame,
    points: pd.DataFrame,
    fitted_law: LawConstants,
) -> OilSurface:
    """The surface of one oil.

    Args:
        surface_row: The oil's row of the table `surfaces`.
        size_rows: Its rows of the table `surface_sizes`.
        points: Its rows of the table of points.
        fitted_law: The law of the surface.
    """
    contact = MeasuredContact.from_points(points[points["accepted"]])
    law = free_law(*fitted_law, contact)
    assumptions = RunAssumptions.from_tables(surface_row, size_rows)
    run_ids, measurements = usable_measurements(points, law, contact, assumptions)
    logarithms = {}
    for search, rows_of_search in size_rows.groupby("search"):
        logarithm_by_size = rows_of_search.set_index("size")["logarithm"]
        ordered_names = size_names(tells_rigs_apart="rig_gain" in logarithm_by_size.index)
        logarithms[search] = logarithm_by_size.reindex(list(ordered_names)).to_numpy(dtype=float)
    searched_sizes = SurfaceSizes(
        **{search: logarithms[search] for search in SIZE_SEARCHES},
        converged=surface_row["search_converged"],
    )
    interval_factors = IntervalFactors(
        surface_row["interval_level"], surface_row["point_factor"], surface_row["curve_factor"]
    )
    return OilSurface(
        law_name=surface_row["law"],
        law=law,
        contact=contact,
        run_ids=run_ids,
        measurements=measurements,
        sizes=searched_sizes,
        interval_factors=interval_factors,
        limits=SurfaceLimits(**{name: surface_row[name] for name in LIMIT_NAMES}),
        next_run_sd=surface_row["next_run_sd"],
        misfit=surface_row["misfit"],
        run_scatter=surface_row["run_scatter"],
        no_law_fits=surface_row["no_law_fits"],
        assumptions=assumptions,
    )


# ---------------------------------------------------------------- arrays


def free_law(
    law: Law, constants: FloatArray, group_has_exponent: BoolArray, contact: MeasuredContact
) -> FreeLaw:
    """The law of a fit, whose fitted constants are free.

    Args:
        law: The law.
        constants: Its constants, shape (constants,).
        group_has_exponent: Whether the fit follows each of its groups, shape (groups,).
        contact: What turns its conditions into P, U and T.
    """
    has_exponent_by_group = dict(zip(law.groups, group_has_exponent, strict=True))
    is_free = []
    for constant in law.constants:
        # X0 belongs to no group
        has_effect = constant.group is None or bool(has_exponent_by_group[constant.group])
        is_free.append(has_effect and constant.prescribed is None)
    return FreeLaw(
        law=law,
        constants=to_internal(law, constants),
        is_free=np.array(is_free),
        conditions_of_law=partial(contact.law_conditions, law),
    )


def usable_measurements(
    points: pd.DataFrame,
    surface_law: FreeLaw,
    contact: MeasuredContact,
    assumptions: RunAssumptions,
) -> tuple[tuple[str, ...], Measurements]:
    """The run of each curve, and the points of an oil that carry traction.

    Runs with an unknown condition, where others know it, are left out, and so are points near pure
    rolling: their mu is that of the zero.

    Args:
        points: The oil's rows of the table of points.
        surface_law: The law, which says where a point carries traction.
        contact: What turns the conditions of the law into P, U and T.
        assumptions: What is known of the runs.
    """
    data = curve_data(points, surface_law.law.conditions)
    is_unknown = np.isnan(data.conditions)
    is_known_of_some = ~is_unknown.all(axis=0)
    rig_of_curve = _rig_numbers(data.run_ids, assumptions)
    is_complete: BoolArray = ~np.any(is_unknown & is_known_of_some, axis=1)
    conditions = contact.surface_conditions(surface_law.law, data.conditions)
    is_sliding = is_complete[data.curve_of_point] & (data.slip > 0)
    point_conditions = conditions[data.curve_of_point[is_sliding]]
    mu_of_law = np.exp(surface_law.log_mu(point_conditions, data.slip[is_sliding]))
    carries_traction = mu_of_law > _smallest_traction(data.mu[is_sliding], assumptions.error_sizes)
    point_indices = np.flatnonzero(is_sliding)[carries_traction]
    curve_indices, new_curve_of_point = np.unique(
        data.curve_of_point[point_indices], return_inverse=True
    )
    slip = data.slip[point_indices]
    measurements = Measurements(
        conditions=conditions[curve_indices],
        curve_of_point=new_curve_of_point,
        slip=slip,
        mu=data.mu[point_indices],
        noise_ratio=_noise_ratio(
            data.mu_se[point_indices] / mu_of_law[carries_traction],
            data.slip_se[point_indices] / slip,
        ),
        level_widths=assumptions.level_widths,
        rig_of_curve=None if rig_of_curve is None else rig_of_curve[curve_indices],
    )
    return tuple(data.run_ids[curve_index] for curve_index in curve_indices.tolist()), measurements


def _rig_numbers(run_ids: Sequence[str], assumptions: RunAssumptions) -> IndexArray | None:
    """Number of the rig of each run, shape (runs,); None where the data name fewer than two rigs.

    Raises:
        ValueError: The runs are not those whose rigs are known.
    """
    rig_name_of_run = assumptions.rig_name_of_run
    if rig_name_of_run is None or len(assumptions.rig_names) < 2:
        return None
    if len(rig_name_of_run) != len(run_ids):
        raise ValueError(
            f"{len(run_ids)} runs are accepted; the rigs of {len(rig_name_of_run)} are known"
        )
    return np.array(
        [assumptions.rig_names.index(rig_name) for rig_name in rig_name_of_run], dtype=np.int64
    )


def _smallest_traction(mu: FloatArray, error_sizes: ErrorPriors) -> float:
    """mu of the law above which a point carries traction, and not only the error of the zero.

    Readings below zero show the size of that error, where it is larger than expected.
    """
    expected_limit = _LEAST_TRACTION_IN_ZERO_ERRORS * error_sizes.zero.median
    largest_reading_below_zero = (
        -float(np.quantile(mu, _LARGEST_SHARE_BELOW_ZERO)) if len(mu) else 0.0
    )
    return max(expected_limit, largest_reading_below_zero)


def _noise_ratio(mu_se: FloatArray, slip_se: FloatArray) -> FloatArray | None:
    """Noise of each point over that of a typical one; None where the readings do not show it.

    A relative error of the slip counts as the same relative error of mu: mu is at most in
    proportion to the slip. The ratio is the root of the mean of the variance of the point and that
    of a typical one, because no point is much better than its rig.

    Args:
        mu_se: Standard error of mu, over mu, shape (points,).
        slip_se: Standard error of the slip, over the slip, shape (points,).
    """
    variance = mu_se**2 + slip_se**2
    is_known = np.isfinite(variance)
    if not is_known.any():
        return None
    typical_variance = float(np.median(variance[is_known]))
    if typical_variance == 0:
        return None
    variance = np.where(is_known, variance, typical_variance)
    return np.sqrt((variance + typical_variance) / (2 * typical_variance))
