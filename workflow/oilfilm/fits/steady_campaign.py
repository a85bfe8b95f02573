"""Whether the runs of a campaign are steady, as columns of the table `soundness`.

Decides: the order in which runs were made; what runs have in common; what a change of the rig is
called.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd

from oilfilm.base.natural_key import natural_key
from oilfilm.base.ties import first_largest
from oilfilm.base.units import BoolArray, FloatArray, IndexArray
from oilfilm.fits.measured_surface import OilSurface
from oilfilm.settings.config import ChangeSizeSettings, SteadinessSettings
from oilfilm.surface.effects import EFFECT_NAMES, ErrorPriors, effect_design
from oilfilm.surface.label_swap import LabelSwap, likeliest_swap
from oilfilm.surface.misreading import Misreading, likeliest_misreading
from oilfilm.surface.steadiness import (
    Change,
    ChangeSizes,
    SteadinessLimits,
    largest_change,
    smallest_visible_changes,
)
from oilfilm.surface.surface import Surface
from oilfilm.tables.set_points import NOMINAL_COLUMNS
from oilfilm.traction.law import CONDITIONS

# Codes of the causes in the table, by the name of the effect of runs.
_CAUSE_BY_EFFECT = {
    "gain": "traction force",
    "zero": "zero of the force",
    "slip_scale": "slip",
    "temperature_k": "inlet temperature",
}
_SWAPPED_LABELS = "temperature labels"
_CAUSE_BY_MISREAD_QUANTITY = {"speed": "speed factor", "slip": "slip factor"}
# Effects whose size is the true value less the logged one. A change is stated as the logged value
# less the true one: a log that reads too low has a negative size.
_EFFECTS_OF_OPPOSITE_SIGN = ("slip_scale", "temperature_k")
# Effects whose size is the logarithm of a factor.
_LOGARITHMIC_EFFECTS = ("gain", "slip_scale")
# Rank correlation above which the order of the runs is that of a condition.
_SAME_ORDER_CORRELATION = 0.7
# Columns of the table of runs whose values runs may have in common.
_GROUP_COLUMNS = ("rig", "log_kind", "reader", "encoding", "delimiter", "decimal_mark")
_SET_POINT = re.compile(r"nominal_(.+)_(?:gpa|n|m_s|c)$")
# Columns of the table of runs that tell what runs have in common.
LABEL_COLUMNS = ("run_id", *_GROUP_COLUMNS, "columns", "stated", *NOMINAL_COLUMNS)


@dataclass(frozen=True)
class MeasuredCampaign:
    """The surface of an oil, with the names of the runs behind its curves.

    Attributes:
        surface: The surface.
        run_ids: Name of the run of each curve of its measurements.
        error_sizes: Expected sizes of the errors of the rig.
    """

    surface: Surface
    run_ids: tuple[str, ...]
    error_sizes: ErrorPriors

    @classmethod
    def from_surface(cls, oil_surface: OilSurface) -> "MeasuredCampaign":
        """The campaign behind the surface of an oil."""
        curve_order, _ = oil_surface.measurements.canonical_order()
        run_ids = tuple(oil_surface.run_ids[curve_index] for curve_index in curve_order.tolist())
        return cls(oil_surface.surface, run_ids, oil_surface.assumptions.error_sizes)

    @property
    def position_in_time(self) -> IndexArray:
        """Position in time of each curve, shape (curves,).

        No log states when it was made, so the runs are taken in the order of the numbers in their
        names. That is an assumption.
        """
        curves_by_name = sorted(
            range(len(self.run_ids)), key=lambda curve_index: natural_key(self.run_ids[curve_index])
        )
        position = np.empty(len(self.run_ids), dtype=np.int64)
        position[curves_by_name] = np.arange(len(self.run_ids))
        return position

    def condition_like_run_order(self) -> str:
        """Column of the condition in whose order the runs were made; empty if there is none."""
        correlation_by_condition = {}
        measurements = self.surface.measurements
        for condition_name, column, level_of_curve in zip(
            CONDITIONS, measurements.conditions.T, measurements.level_numbers().T, strict=True
        ):
            # a condition of one level only scatters
            if np.ptp(level_of_curve) > 0:
                # Spearman's correlation is that of ranks; the position is a rank
                ranks = pd.Series(column).rank()
                correlation_by_condition[condition_name] = abs(
                    float(np.corrcoef(self.position_in_time, ranks)[0, 1])
                )
        if not correlation_by_condition:
            return ""
        condition_name = max(
            correlation_by_condition,
            key=lambda condition_name: correlation_by_condition[condition_name],
        )
        return (
            condition_name
            if correlation_by_condition[condition_name] > _SAME_ORDER_CORRELATION
            else ""
        )

    def relative_rms(self, log_mu_change: FloatArray) -> float:
        """Root-mean-square change of mu over that of mu.

        Args:
            log_mu_change: Change of ln mu at each point.
        """
        mu = self.surface.measurements.mu
        return float(np.sqrt(np.mean((mu * log_mu_change) ** 2) / np.mean(mu**2)))

    def effect_slopes(self) -> FloatArray:
        """Derivative of ln mu with respect to each effect, shape (points, effects)."""
        measured = self.surface.measurements
        return effect_design(self.surface.log_mu, measured.point_conditions, measured.slip)


def steadiness_limits(settings: SteadinessSettings) -> SteadinessLimits:
    """The limits of a change from the configuration."""
    return SteadinessLimits(
        alarm=settings.alarm,
        alarm_of_groups=settings.alarm_of_groups,
        alarm_of_a_run=settings.alarm_of_a_run,
        fewest_runs=settings.fewest_runs,
        longest_block=settings.longest_block,
        seen_at=settings.seen_at,
        confounded=settings.confounded,
        usual=_change_sizes(settings.usual),
        largest=_change_sizes(settings.largest),
    )


def _change_sizes(sizes: ChangeSizeSettings) -> ChangeSizes:
    """Sizes of changes as the effects of runs have them."""
    return ChangeSizes(
        gain=float(np.log1p(sizes.traction_force)),
        zero=sizes.zero_of_the_force,
        slip_scale=float(np.log1p(sizes.slip)),
        temperature_k=sizes.inlet_temperature_k,
    )


def change_columns(
    campaign: MeasuredCampaign,
    is_member_by_label: Mapping[str, BoolArray],
    settings: SteadinessSettings,
) -> dict[str, Any]:
    """The columns of the table `soundness` that tell whether the campaign is steady.

    Args:
        campaign: The surface and its runs.
        is_member_by_label: As `members_by_common_label` gives them.
        settings: When a change is named.
    """
    limits = steadiness_limits(settings)
    covariance, position_in_time = campaign.surface.misfit_covariance, campaign.position_in_time
    change = largest_change(covariance, position_in_time, is_member_by_label, limits)
    swap = likeliest_swap(campaign.surface, campaign.error_sizes, limits)
    misreading = likeliest_misreading(
        campaign.surface, is_member_by_label, campaign.error_sizes, limits
    )
    alarms: list[tuple[float, dict[str, Any]]] = []
    if change is not None and change.is_alarm:
        alarms.append((change.score, _change_columns(campaign, change)))
    if swap is not None and swap.is_alarm:
        alarms.append((swap.score, _swap_columns(campaign, swap)))
    if misreading is not None and misreading.is_alarm:
        alarms.append((misreading.score, _misreading_columns(campaign, misreading)))
    columns = dict(NO_CHANGE)
    if alarms:
        largest_alarm = int(first_largest([score for score, _ in alarms]))
        _, alarm_columns = alarms[largest_alarm]
        columns.update(alarm_columns)
    else:
        smallest_visible = smallest_visible_changes(covariance, position_in_time, limits)
        for course, size_by_effect in (
            ("trend", smallest_visible.trend),
            ("step", smallest_visible.step),
        ):
            for effect_name, size in size_by_effect.items():
                # a change that no rig has is no cause
                if size <= limits.largest.size_of(effect_name):
                    is_relative = effect_name in _LOGARITHMIC_EFFECTS
                    seen_size = float(np.expm1(size)) if is_relative else size
                    columns[f"seen_{course}_{effect_name}"] = seen_size
        columns["order_resembles"] = campaign.condition_like_run_order()
    return columns


# The same columns where no change was found, or none could be looked for.
NO_CHANGE: dict[str, Any] = {
    "campaign_verdict": "steady",
    "change": "",
    "change_course": "",
    "change_group": "",
    "changed_runs": (),
    "change_size": np.nan,
    "change_relative_rms": np.nan,
    "order_resembles": "",
    **{
        f"seen_{course}_{effect}": np.nan for course in ("trend", "step") for effect in EFFECT_NAMES
    },
}


def _change_columns(campaign: MeasuredCampaign, change: Change) -> dict[str, Any]:
    """The columns of a change of the rig."""
    size = -change.size if change.effect_name in _EFFECTS_OF_OPPOSITE_SIGN else change.size
    if change.effect_name in _LOGARITHMIC_EFFECTS:
        size = float(np.expm1(size))
    is_suspect = change.pattern > 0.5
    in_all_runs = change.kind in ("trend", "season")
    effect_index = EFFECT_NAMES.index(change.effect_name)
    measurements = campaign.surface.measurements
    log_mu_change = (
        campaign.effect_slopes()[:, effect_index]
        * change.size
        * change.pattern[measurements.curve_of_point]
    )
    return {
        "campaign_verdict": "changed",
        "change": _CAUSE_BY_EFFECT[change.effect_name],
        "change_course": _course(change.kind, is_suspect, campaign.position_in_time),
        "change_group": change.label,
        "changed_runs": () if in_all_runs else _run_ids_in_time_order(campaign, is_suspect),
        "change_size": size,
        "change_relative_rms": campaign.relative_rms(log_mu_change),
    }


def _course(kind: str, is_suspect: BoolArray, position_in_time: IndexArray) -> str:
    """Code of the course of a change over the runs."""
    if kind in ("trend", "season"):
        return kind
    if kind == "label":
        return "group"
    if kind == "step":
        return "from" if is_suspect[np.argmax(position_in_time)] else "until"
    return "some runs"


def _swap_columns(campaign: MeasuredCampaign, swap: LabelSwap) -> dict[str, Any]:
    """The columns of exchanged temperatures; their size is the largest difference."""
    surface = campaign.surface
    measurements = surface.measurements
    conditions = measurements.conditions.copy()
    conditions[swap.curve_indices, 2] = swap.temperatures_c
    differences = conditions[:, 2] - measurements.conditions[:, 2]
    as_labelled = surface.log_mu(measurements.point_conditions, measurements.slip)
    as_exchanged = surface.log_mu(conditions[measurements.curve_of_point], measurements.slip)
    is_suspect = np.isin(np.arange(len(conditions)), swap.curve_indices)
    return {
        "campaign_verdict": "changed",
        "change": _SWAPPED_LABELS,
        "change_course": "some runs",
        "changed_runs": _run_ids_in_time_order(campaign, is_suspect),
        "change_size": float(np.max(np.abs(differences))),
        "change_relative_rms": campaign.relative_rms(as_exchanged - as_labelled),
    }


def _misreading_columns(campaign: MeasuredCampaign, misreading: Misreading) -> dict[str, Any]:
    """The columns of a quantity that is read too large by a factor."""
    surface = campaign.surface
    measurements, corrected = surface.measurements, misreading.corrected(surface.measurements)
    as_read = surface.log_mu(measurements.point_conditions, measurements.slip)
    as_corrected = surface.log_mu(corrected.point_conditions, corrected.slip)
    return {
        "campaign_verdict": "changed",
        "change": _CAUSE_BY_MISREAD_QUANTITY[misreading.quantity],
        "change_course": "group" if misreading.label else "some runs",
        "change_group": misreading.label,
        "changed_runs": _run_ids_in_time_order(campaign, misreading.is_misread),
        "change_size": misreading.factor,
        "change_relative_rms": campaign.relative_rms(as_corrected - as_read),
    }


def _run_ids_in_time_order(campaign: MeasuredCampaign, is_suspect: BoolArray) -> tuple[str, ...]:
    """Names of some runs in their order in time."""
    curves_by_time = np.argsort(campaign.position_in_time)
    return tuple(
        campaign.run_ids[curve_index] for curve_index in curves_by_time if is_suspect[curve_index]
    )


def members_by_common_label(
    run_ids: Sequence[str], runs: pd.DataFrame, points: pd.DataFrame
) -> dict[str, BoolArray]:
    """Which runs have something in common, shape (runs,) each, by what it is.

    Runs may share the rig, the kind and format of the log, a column, an entry of the header or of
    the run sheet, a stated set point, or the sign of the slip.

    Args:
        run_ids: The runs of the result.
        runs: `LABEL_COLUMNS` of the table of runs.
        points: Accepted points of an oil.
    """
    names = pd.Index(run_ids)
    labelled_runs = _labelled_runs(runs[runs["run_id"].isin(names)], points)
    return {label: names.isin(ids) for label, ids in labelled_runs}


def _labelled_runs(
    runs: pd.DataFrame, points: pd.DataFrame
) -> Iterator[tuple[str, "pd.Series[str] | pd.Index[str]"]]:
    """What some runs have in common, and their names; see `members_by_common_label`."""
    for column in _GROUP_COLUMNS:
        for value, runs_with_value in runs.groupby(column):
            yield f"{column} {value}", runs_with_value["run_id"]
    for column, label in (("columns", "the column "), ("stated", "")):
        entries = runs.set_index("run_id")[column].explode().dropna()
        for entry, runs_with_entry in entries.groupby(entries):
            if entry and len(runs_with_entry) < len(runs):
                yield f"{label}{entry}", runs_with_entry.index
    for column in NOMINAL_COLUMNS:
        quantity = _SET_POINT.sub(r"\1", column).replace("_", " ")
        yield f"set point of {quantity} stated", runs.loc[runs[column].notna(), "run_id"]
    largest_slip = points.groupby("run_id")["slide_roll_ratio"].max()
    yield "slip below zero", largest_slip.index[largest_slip <= 0]
