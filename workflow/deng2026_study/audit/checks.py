"""One check for each claim of the paper: the function with the name of the claim.

A check takes the evidence over a box of operating conditions and returns the verdict in every case,
with numbers that explain it; reference/claims.yaml says in words what is checked and what the
numbers are. Arrays have the axes oil, P, U, T, S, of length 1 where a case spans an axis: maximum
Hertz pressure (GPa), entrainment speed (m/s), inlet temperature (degC) and slide-roll ratio. The
paper says stress for P.

Decides: when a claim of the paper holds.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd
import scipy

from deng2026_study.audit.evidence import Evidence, NotCheckableError, Outcome, outcome_of_cases
from oilfilm.base.ties import exceeds, reaches
from oilfilm.base.units import BoolArray, FloatArray, IndexArray
from oilfilm.bearing.kinematics import (
    cage_slip,
    entrainment_speed_m_s,
    inner_slide_roll_ratio,
    pitch_speed_mm_rpm,
    surface_speed_m_s,
)
from oilfilm.torque.best_oil import OPERATING_POINT_COLUMNS
from oilfilm.torque.torque_control import (
    drop_bistable_plateaus,
    is_bistable,
    undecided_plateau_count,
)
from oilfilm.traction.law import Law
from oilfilm.traction.laws.deng2026 import DENG2026

# Axes of the arrays.
_P, _U, _T, _S = 1, 2, 3, 4
# D cos(alpha)/dm of ball bearings.
_GAMMAS = (0.0, 0.1, 0.2, 0.3)
# Number of magnitudes of each coefficient. They represent all magnitudes that a law allows.
_MAGNITUDE_COUNT = 6
# Values of mu up to this share of the largest coefficient are rounding.
_ROUNDING_SHARE = 1e-15
# Deng et al. (2026), section 2.1: Ra of ball and disc, and their composite roughness as stated.
_RA_UM = (0.014, 0.010)
_COMPOSITE_RA_UM = 0.017
# Smallest cage slip that a load can suppress noticeably.
_SMALLEST_SLIP = 0.01
# Number of coefficients of Eq. 7: A, B and C.
_COEFFICIENT_COUNT = 3
# Lowest slip at which the slope of a curve is clear, over the largest slip.
_CLEAR_SLIP_SHARE = 0.01
# Shares of the slope at that slip from which the fit of a curve starts.
_SHARES_OF_SLOPE = (0.2, 0.5, 0.8, 0.95)
# Relative tolerance of that fit.
_FIT_TOLERANCE = 1e-12
# Largest relative standard error that is told apart: from it on, the curve does not determine the
# coefficient.
_UNDETERMINED_ERROR = 1e3


def zero_slip(evidence: Evidence) -> Outcome:
    """Without slip there is no traction."""
    without_slip = evidence.with_levels(slide_roll_ratio=[0.0])
    mu = np.abs(without_slip.mu())
    holds_for_any_constants = _is_true_of_every_law(
        evidence, lambda law: _mu_for_any_constants(law, np.zeros(1)) == 0
    )
    outcome_on_grid = without_slip.outcome_on_grid(mu <= evidence.study.audit.zero_traction_max, mu)
    return replace(outcome_on_grid, by_construction=holds_for_any_constants)


def non_negative(evidence: Evidence) -> Outcome:
    """Mu is never negative."""
    mu = evidence.mu(slide_roll_ratio=evidence.curve_slips[1:])
    lowest_mu = mu.min(axis=_S, keepdims=True)
    largest_size = np.abs(mu).max(axis=_S, keepdims=True)
    holds_for_any_constants = _is_true_of_every_law(
        evidence, lambda law: _mu_for_any_constants(law, evidence.curve_slips) >= 0
    )
    return replace(
        evidence.outcome_on_grid(reaches(lowest_mu, 0.0, largest_size), lowest_mu),
        by_construction=holds_for_any_constants,
    )


def linear_start(evidence: Evidence) -> Outcome:
    """Mu begins as a straight line."""
    linear_end = _end_of_linear_range(evidence)
    required_end = evidence.study.audit.linear_to_slip
    start_slips = np.linspace(0.0, required_end, evidence.study.audit.levels)
    is_straight, _ = _straight_line_fit(
        evidence, start_slips, evidence.mu(slide_roll_ratio=start_slips), _S
    )
    return evidence.outcome_on_grid(
        is_straight,
        linear_end,
        within=reaches(linear_end, required_end),
        longest=np.nanmax(linear_end),
    )


def peak_decline(evidence: Evidence) -> Outcome:
    """Mu peaks, then declines slightly."""
    mu = evidence.mu(slide_roll_ratio=evidence.curve_slips)
    peak = mu.max(axis=_S, keepdims=True)
    mu_at_largest_slip = mu[..., -1:]
    # a law that comes to a constant level reaches it within rounding, and has no peak
    has_peak = exceeds(peak, mu_at_largest_slip)
    decline = 1 - mu_at_largest_slip / peak
    is_slight = reaches(evidence.study.printed.signs.decline_max, decline, term_size=1.0)
    is_shown_oil = [oil == evidence.falling_viscosity[0] for oil in evidence.fit_by_oil]
    decline_coldest = decline[:, :, :, 0]
    return evidence.outcome_on_grid(
        has_peak & is_slight,
        decline,
        shown_oil=(has_peak & is_slight)[is_shown_oil],
        peaks=has_peak,
        slight=is_slight,
        coldest_least=evidence.summary_by_oil(np.nanmin, decline_coldest),
        coldest_most=evidence.summary_by_oil(np.nanmax, decline_coldest),
    )


def falls_with_temperature(evidence: Evidence) -> Outcome:
    """Mu falls with T, more steeply where it is cold."""
    audit = evidence.study.audit
    mu = evidence.mu()
    lowest_c, highest_c = _first_and_last(evidence.grid.inlet_temperature_c)
    cold_band, hot_band = np.clip([audit.cold_band_c, audit.hot_band_c], lowest_c, highest_c)
    cold_slope = -np.diff(evidence.mu(inlet_temperature_c=cold_band), axis=_T) / np.diff(cold_band)
    hot_slope = -np.diff(evidence.mu(inlet_temperature_c=hot_band), axis=_T) / np.diff(hot_band)
    # slopes have the rounding of the largest slope that mu could give
    largest_slope = np.abs(mu).max() / min(np.diff(cold_band)[0], np.diff(hot_band)[0])
    is_steeper = exceeds(cold_slope, hot_slope, term_size=largest_slope)
    always_falls = _falls_throughout(mu, _T)
    return evidence.outcome_on_grid(
        always_falls & is_steeper, _last_over_first(mu, _T), always=always_falls, steeper=is_steeper
    )


def falls_with_speed(evidence: Evidence) -> Outcome:
    """Mu falls with U and levels off."""
    mu = evidence.mu()
    ends_of_thirds = np.linspace(*_first_and_last(evidence.grid.entrainment_speed_m_s), 4)
    fall = -np.diff(evidence.mu(entrainment_speed_m_s=ends_of_thirds), axis=_U)
    levels_off = exceeds(fall[:, :, :1], np.abs(fall[:, :, 2:]), term_size=np.abs(mu).max())
    always_falls = _falls_throughout(mu, _U)
    return evidence.outcome_on_grid(
        always_falls & levels_off,
        _last_over_first(mu, _U),
        always=always_falls,
        levels_off=levels_off,
    )


def rises_with_stress(evidence: Evidence) -> Outcome:
    """Mu rises with P, about linearly."""
    pressures = evidence.grid.max_hertz_pressure_gpa
    even_pressures = np.linspace(*_first_and_last(pressures), len(pressures))
    mu = evidence.mu(max_hertz_pressure_gpa=even_pressures)
    always_rises = _falls_throughout(-mu, _P)
    is_straight, r2 = _straight_line_fit(evidence, even_pressures, mu, _P)
    median_r2 = evidence.summary_by_oil(np.nanmedian, r2)
    return evidence.outcome_on_grid(
        always_rises & is_straight,
        r2,
        always=always_rises,
        straight=is_straight,
        median_r2=median_r2,
    )


def rises_with_slip(evidence: Evidence) -> Outcome:
    """The level of mu rises with S."""
    tested_ends = evidence.study.printed.boxes.tested.max_hertz_pressure_gpa
    at_highest_pressure = evidence.with_levels(max_hertz_pressure_gpa=tested_ends[1:])
    mu = at_highest_pressure.mu()
    level_rises = _falls_throughout(-mu.mean(axis=(_U, _T), keepdims=True), _S)
    ends_rise = exceeds(mu[..., -1], mu[..., 0])
    return at_highest_pressure.outcome_on_grid(
        _falls_throughout(-mu, _S), _last_over_first(mu, _S), level=level_rises, ends=ends_rise
    )


def similar_limit(evidence: Evidence) -> Outcome:
    """Mu approaches a plateau, alike for all oils."""
    largest_slip = evidence.curve_slips[-1]
    mu = evidence.mu_by_viscosity(
        slide_roll_ratio=[evidence.grid.slide_roll_ratio[0], largest_slip * 2 / 3, largest_slip]
    )
    change = np.abs(mu[..., 2:] / mu[..., 1:2] - 1).max(axis=0, keepdims=True)
    relative_spread = np.ptp(mu, axis=0) / mu.mean(axis=0)
    return evidence.outcome_on_grid(
        reaches(evidence.study.audit.plateau_change_max, change, term_size=1.0),
        change,
        closer=exceeds(relative_spread[..., 0], relative_spread[..., 2], term_size=1.0),
        apart_at_start=relative_spread[..., 0].mean(),
        apart_at_end=relative_spread[..., 2].mean(),
    )


def earlier_plateau(evidence: Evidence) -> Outcome:
    """A higher P leaves the linear range earlier."""
    linear_end = _end_of_linear_range(evidence)
    ends_c = _first_and_last(evidence.grid.inlet_temperature_c)
    mu = evidence.mu(inlet_temperature_c=ends_c, slide_roll_ratio=evidence.curve_slips)
    on_plateau = reaches(mu, evidence.study.audit.plateau_share * mu.max(axis=_S, keepdims=True))
    plateau_begin = evidence.curve_slips[np.argmax(on_plateau, axis=_S)]
    return evidence.outcome_on_grid(
        _falls_throughout(linear_end, _P),
        _last_over_first(linear_end, _P),
        plateau_coldest=evidence.summary_by_oil(np.median, plateau_begin[..., 0]),
        plateau_hottest=evidence.summary_by_oil(np.median, plateau_begin[..., 1]),
    )


def viscosity_order(evidence: Evidence) -> Outcome:
    """Mu falls from each oil to the next less viscous one."""
    oils = evidence.falling_viscosity
    mu = evidence.mu_by_viscosity()
    ratios = mu[:-1] / mu[1:]
    smallest_ratio = ratios.min(axis=0, keepdims=True)
    ranks = _ranks(mu.reshape(len(oils), -1)).T
    orders, counts = np.unique(ranks, axis=0, return_counts=True)
    rank_of_oil = dict(zip(oils, orders[counts.argmax()], strict=True))
    oils_by_rank = sorted(oils, key=rank_of_oil.__getitem__)
    # one number for all conditions at one pressure: the geometric mean, because these are ratios
    thin_over_thick_lightest, thin_over_thick_heaviest = np.exp(
        np.log(mu[-1] / mu[0]).mean(axis=(1, 2, 3))
    )[[0, -1]]
    numbers: dict[str, Any] = {}
    share_above_next = exceeds(ratios[0], 1.0).mean(axis=(1, 2, 3))
    if share_above_next[0] < 0.5 < share_above_next[-1] and (np.diff(share_above_next) >= 0).all():
        numbers["turn_gpa"] = np.interp(0.5, share_above_next, evidence.grid.max_hertz_pressure_gpa)
    return evidence.outcome_on_grid(
        exceeds(smallest_ratio, 1.0),
        smallest_ratio,
        above_next={
            oil: exceeds(ratio_to_next, 1.0)
            for oil, ratio_to_next in zip(oils[:-1], ratios, strict=True)
        },
        commonest_share=counts.max() / len(ranks),
        commonest_rank={oil: rank_of_oil[oil] for oil in oils_by_rank},
        thin_over_thick_lightest=thin_over_thick_lightest,
        thin_over_thick_heaviest=thin_over_thick_heaviest,
        **numbers,
    )


def hot_convergence(evidence: Evidence) -> Outcome:
    """The oils come nearer to one another as they warm."""
    mu = evidence.mu_by_viscosity(
        inlet_temperature_c=_first_and_last(evidence.grid.inlet_temperature_c)
    )
    spread = np.ptp(mu, axis=0, keepdims=True)
    relative_spread = spread / mu.mean(axis=0, keepdims=True)
    spread_coldest, spread_hottest = relative_spread.mean(axis=(0, 1, 2, 4))
    return evidence.outcome_on_grid(
        _falls_throughout(spread, _T),
        _last_over_first(spread, _T),
        relative=_falls_throughout(relative_spread, _T),
        spread_coldest=spread_coldest,
        spread_hottest=spread_hottest,
    )


def speed_mutes_temperature(evidence: Evidence) -> Outcome:
    """T changes mu less at a high speed."""
    speeds = np.clip(
        evidence.study.audit.slow_and_fast_m_s,
        *_first_and_last(evidence.grid.entrainment_speed_m_s),
    )
    ends_c = _first_and_last(evidence.grid.inlet_temperature_c)
    mu = evidence.mu(entrainment_speed_m_s=speeds, inlet_temperature_c=ends_c)
    drop = -np.diff(mu, axis=_T)
    drop_ratio = _last_over_first(drop, _U)
    relative_drop_falls = _falls_throughout(drop / mu[:, :, :, :1], _U)
    return evidence.outcome_on_grid(
        exceeds(1.0, drop_ratio), drop_ratio, relative=relative_drop_falls
    )


def full_film(evidence: Evidence) -> Outcome:
    """Film and lambda are above what a full film needs."""
    oils = evidence.falling_viscosity
    film_min_um = evidence.study.audit.film_min_um
    limits = np.array([film_min_um, evidence.settings.gates.lambda_limit])
    figure_slips = evidence.study.printed.signs.slide_roll_ratio.figures
    at_curve_slips = evidence.with_levels(
        slide_roll_ratio=[0.0, *figure_slips, evidence.curve_slips[-1]]
    )
    points = evidence.campaign_tables.points.dropna(subset=["lambda_ratio"])
    if evidence.basis == "printed" or evidence.campaign_tables.points.empty:
        films = at_curve_slips.films(*oils)
        margins = films / limits.reshape(2, 1, 1, 1, 1, 1)
        smaller_margin = margins.min(axis=0)
        judged = at_curve_slips.cases_on_grid(oils, exceeds(smaller_margin, 1.0), smaller_margin)
    elif points.empty:
        raise NotCheckableError("no lambda")
    else:
        films = points[["film_thickness_um", "lambda_ratio"]].to_numpy().T
        margins = films / limits.reshape(2, 1)
        judged = points.assign(value=margins.min(axis=0))
        judged["holds"] = exceeds(judged["value"], 1.0)
    central_um, _ = at_curve_slips.films(film_kind="central")
    unknown_count = judged["value"].isna().sum()
    return outcome_of_cases(
        # where the formula gives no film the claim is neither true nor false
        judged.dropna(subset="value"),
        central=_above_one(central_um / film_min_um),
        full=_above_one(margins[1]),
        thick=_above_one(margins[0]),
        smallest_lambda=np.nanmin(films[1]),
        thinnest_um=np.nanmin(films[0]),
        unknown=unknown_count if unknown_count else np.nan,
    )


def _above_one(margin: FloatArray) -> BoolArray:
    """Whether each known margin exceeds 1; unknown ones are left out."""
    return exceeds(margin, 1.0)[~np.isnan(margin)]


def air_spindle(evidence: Evidence) -> Outcome:
    """The spindle's friction is negligible. No log tells it from a zero of the force sensor."""
    raise NotCheckableError("no spindle")


def wang_deng_zero(evidence: Evidence) -> Outcome:
    """The Wang-Deng law has traction without slip."""
    fits = _wang_deng_fits(evidence)
    mu_at_zero_slip = fits["zero_slip_traction"].abs()
    holds = mu_at_zero_slip > evidence.study.audit.zero_traction_max
    return outcome_of_cases(
        fits.assign(holds=holds, value=mu_at_zero_slip), largest=mu_at_zero_slip.max()
    )


def wang_deng_overfit(evidence: Evidence) -> Outcome:
    """The errors of the Wang-Deng law grow more on curves left out."""
    audit = evidence.study.audit
    fits = _wang_deng_fits(evidence)
    all_fits = evidence.campaign_tables.fit_quality
    by_paper_law = all_fits[all_fits["law"] == audit.stress_law].set_index("oil")
    if not set(fits["oil"]) <= set(by_paper_law.index):
        raise NotCheckableError("no fit by the paper's law")
    growth = fits["left_out_rmse"] / fits["rmse"]
    growth_of_paper_law = by_paper_law["left_out_rmse"] / by_paper_law["rmse"]
    relative_growth = growth / fits["oil"].map(growth_of_paper_law)
    return outcome_of_cases(
        fits.assign(holds=exceeds(relative_growth, audit.overfit_min), value=relative_growth)
    )


def properties_not_needed(evidence: Evidence) -> Outcome:
    """Laws with properties of the oil predict no better than the paper's law."""
    limit = evidence.study.audit.prediction_error
    by_paper_law = _paper_law_fits(evidence).set_index("oil")
    if evidence.truth_is_law:
        raise NotCheckableError("own law")
    all_fits = evidence.campaign_tables.fit_quality
    fits = all_fits[all_fits["law"].isin(evidence.study.audit.property_laws)]
    end_column, left_out_column = "temperature_end_out_relative_rms", "left_out_rmse"
    fits = fits[fits["oil"].isin(by_paper_law.index)].dropna(subset=[end_column, left_out_column])
    if fits.empty:
        raise NotCheckableError("no comparison")
    paper_law_fits = by_paper_law.loc[fits["oil"]].set_axis(fits.index)
    error_ratio = paper_law_fits[left_out_column] / fits[left_out_column]
    return outcome_of_cases(
        fits.assign(holds=reaches(1.0, error_ratio), value=error_ratio),
        ends=reaches(fits[end_column].to_numpy(), paper_law_fits[end_column].to_numpy()),
        enough=reaches(limit, _relative_left_out_error(by_paper_law).to_numpy()),
        own_error=paper_law_fits.groupby(fits["oil"], sort=False)[end_column].first().to_dict(),
        least_error=fits.groupby("oil", sort=False)[end_column].min().to_dict(),
    )


def torque_stress(evidence: Evidence) -> Outcome:
    """The law of pressure gives the torque of a bearing."""
    errors, counts = _torque_errors(evidence)
    errors = errors.dropna(subset="stress")
    holds = reaches(evidence.study.audit.torque_stress_error, errors["stress"])
    judged = errors.assign(holds=holds, value=errors["stress"])
    return outcome_of_cases(judged, largest=errors["stress"].max(), **counts)


def torque_load(evidence: Evidence) -> Outcome:
    """The law of load does not."""
    errors, counts = _torque_errors(evidence)
    errors_of_both = errors.dropna()
    if errors_of_both.empty:
        raise NotCheckableError("no torque by the law")
    excess = errors_of_both["load"] - errors_of_both["stress"]
    largest = errors_of_both["load"].max()
    load_is_worse = exceeds(errors_of_both["load"], errors_of_both["stress"], term_size=1.0)
    load_is_worse_on_median = exceeds(
        errors_of_both["load"].median(), errors_of_both["stress"].median(), term_size=1.0
    )
    torque_outcome = outcome_of_cases(
        errors_of_both.assign(holds=load_is_worse, value=excess),
        systematic=load_is_worse_on_median,
        largest=largest,
        **counts,
    )
    return replace(
        torque_outcome, is_complete=bool(reaches(largest, evidence.study.audit.torque_load_error))
    )


def uniquely_determined(evidence: Evidence) -> Outcome:
    """The curves determine A, B and C; all curves of an oil determine its constants."""
    fits = _paper_law_fits(evidence).dropna(subset="constant_spread")
    errors = _coefficient_errors_of_curves(evidence.campaign_tables.points)
    if fits.empty or errors.empty:
        raise NotCheckableError("no fit by the paper's law")
    coefficients = evidence.campaign_tables.coefficients
    is_of_paper_law = coefficients["law"] == evidence.study.audit.stress_law
    is_known = coefficients[is_of_paper_law & coefficients["oil"].isin(fits["oil"])]["verdict"].eq(
        "known"
    )
    # digits below a millionth of a standard error are rounding
    spread = fits["constant_spread"].round(6)
    judged = errors.rename("value").reset_index()
    return outcome_of_cases(
        judged.assign(holds=reaches(evidence.study.audit.curve_error_max, judged["value"])),
        constants=fits["certified"].to_numpy(),
        known=is_known.to_numpy(),
        spread=spread.max(),
        curve_error=errors.groupby(level="oil", sort=False).median().to_dict(),
    )


def genetic_optimum(evidence: Evidence) -> Outcome:
    """The genetic algorithm finds the optimum. The paper does not state errors of its constants."""
    raise NotCheckableError("not stated")


def extrapolates(evidence: Evidence) -> Outcome:
    """The law predicts beyond the tested conditions."""
    limit = evidence.study.audit.prediction_error
    fits = _paper_law_fits(evidence)
    if evidence.truth_is_law:
        raise NotCheckableError("own law")
    errors_at_ends = fits.filter(regex="^oil$|_end_out_relative_rms$").melt("oil").dropna()
    if errors_at_ends.empty:
        raise NotCheckableError("no fit by the paper's law")
    left_out_error = _relative_left_out_error(fits)
    rows_beyond = evidence.campaign_tables.extrapolation
    is_of_paper_law = rows_beyond["law"] == evidence.study.audit.stress_law
    has_fitted_oil = rows_beyond["oil"].isin(fits["oil"])
    rows_beyond = rows_beyond[
        is_of_paper_law & has_fitted_oil & (rows_beyond["beyond"].map(len) > 0)
    ]
    error = (
        rows_beyond["traction_coefficient"] / rows_beyond["true_traction_coefficient"] - 1
    ).abs()
    return outcome_of_cases(
        errors_at_ends.assign(holds=reaches(limit, errors_at_ends["value"])),
        truth=reaches(limit, error),
        accuracy=reaches(limit, left_out_error),
        left_out=left_out_error.max(),
    )


def composite_roughness(evidence: Evidence) -> Outcome:
    """The roughness of ball and disc make the stated one."""
    composite = float(np.hypot(*_RA_UM))
    judged = pd.DataFrame({"oil": [""], "holds": composite < _COMPOSITE_RA_UM, "value": composite})
    return outcome_of_cases(judged, rounded=round(composite, 3) <= _COMPOSITE_RA_UM)


def rolling_speed(evidence: Evidence) -> Outcome:
    """The stated dmN has the stated entrainment speed."""
    stated = evidence.study.selection.stated
    tolerance = evidence.study.audit.kinematic_tolerance
    pitch_speed = stated.pitch_speed_mm_rpm
    stated_m_s = stated.entrainment_speed_m_s
    rolling_speed_m_s = np.array([entrainment_speed_m_s(pitch_speed, gamma) for gamma in _GAMMAS])
    surface_m_s = surface_speed_m_s(pitch_speed)
    is_near = _near_one(rolling_speed_m_s / stated_m_s, tolerance)
    return outcome_of_cases(
        pd.DataFrame({"oil": "", "holds": is_near, "value": rolling_speed_m_s}),
        as_surface=_near_one(surface_m_s / stated_m_s, tolerance),
        highest=rolling_speed_m_s.max(),
        surface_speed=surface_m_s,
        pitch_speed=pitch_speed_mm_rpm(stated_m_s),
    )


def slip_is_cage_slip(evidence: Evidence) -> Outcome:
    """The slide-roll ratio of a bearing is its cage slip."""
    selection = evidence.study.selection
    cage_slips = np.linspace(0.05, 0.4, 8)
    ratio = np.concatenate(
        [inner_slide_roll_ratio(cage_slips, gamma) / cage_slips for gamma in _GAMMAS]
    )
    tolerance = evidence.study.audit.kinematic_tolerance
    slip_limit = selection.limits.slip_limit
    is_near = _near_one(ratio, tolerance)
    return outcome_of_cases(
        pd.DataFrame({"oil": "", "holds": is_near, "value": ratio}),
        both_races=_near_one(ratio / 2, tolerance),
        smallest=ratio.min(),
        at_limit=inner_slide_roll_ratio(slip_limit, selection.gamma),
        cage_slip=cage_slip(slip_limit, selection.gamma),
    )


def load_suppresses_slip(evidence: Evidence) -> Outcome:
    """The cage slips less under a higher load."""
    slip_rows = _cage_slip_rows(evidence)
    slip_by_load = slip_rows.pivot(
        index="axial_load_n", columns=["oil", "inlet_temperature_c", "pitch_speed_mm_rpm"]
    )["cage_slip"]
    lighter = slip_by_load.shift()
    steps = pd.DataFrame(
        {"lighter": lighter.stack([0, 1, 2]), "heavier": slip_by_load.stack([0, 1, 2])}
    )
    steps = steps[exceeds(steps["lighter"], _SMALLEST_SLIP)].dropna()
    if steps.empty:
        raise NotCheckableError("no bearing")
    change = steps["heavier"] - steps["lighter"]
    slip_falls = exceeds(0.0, change, term_size=1.0)
    is_slipping = exceeds(steps["lighter"], evidence.study.selection.limits.slip_limit)
    judged = steps.reset_index().assign(holds=slip_falls, value=change.to_numpy())
    return outcome_of_cases(judged, where_it_slips=slip_falls[is_slipping])


def heavy_load_grips(evidence: Evidence) -> Outcome:
    """Where the contact pressure is high the cage hardly slips."""
    limits = evidence.study.selection.limits
    slip_rows = _cage_slip_rows(evidence)
    larger_pressure_gpa = slip_rows[
        ["inner_max_hertz_pressure_gpa", "outer_max_hertz_pressure_gpa"]
    ].max(axis=1)
    slip_rows = slip_rows.assign(
        holds=reaches(limits.slip_limit, slip_rows["cage_slip"]), value=slip_rows["cage_slip"]
    )
    is_heavy = reaches(larger_pressure_gpa, limits.heavy_from_gpa)
    is_light = exceeds(limits.light_below_gpa, larger_pressure_gpa)
    if not is_heavy.any():
        raise NotCheckableError("no bearing")
    return outcome_of_cases(slip_rows[is_heavy], light=slip_rows.loc[is_light, "holds"].to_numpy())


def light_load_4102(evidence: Evidence) -> Outcome:
    """Under light load 4102 has the most traction."""
    selection = evidence.study.selection
    light_evidence = _limit_pressures(
        _add_largest_slip(evidence), above=-np.inf, below=selection.limits.light_below_gpa
    )
    mu = light_evidence.mu_by_viscosity()
    grid = light_evidence.grid
    ratio = mu[:1] / mu[1:].max(axis=0, keepdims=True)
    is_hot = reaches(grid.inlet_temperature_c, selection.limits.hot_from_c)
    is_fast = reaches(grid.entrainment_speed_m_s, selection.fast_from_m_s)
    is_slipping = exceeds(grid.slide_roll_ratio, selection.slide_roll_ratio_limit)
    hot_and_fast_ratio = ratio[:, :, is_fast][:, :, :, is_hot][..., is_slipping]
    return light_evidence.outcome_on_grid(
        exceeds(ratio, 1.0),
        ratio,
        higher_viscosity=exceeds(mu[:-1].min(axis=0), mu[-1]),
        hot_and_fast=exceeds(hot_and_fast_ratio, 1.0),
    )


def slip_15(evidence: Evidence) -> Outcome:
    """Up to 15 % cage slip the thinnest oil has the least traction, beyond it the thickest most."""
    selection = evidence.study.selection
    evidence = _add_largest_slip(evidence)
    mu = evidence.mu_by_viscosity()
    is_film_adequate = _is_film_of_thinnest_oil_full(evidence)
    is_slipping = exceeds(evidence.grid.slide_roll_ratio, selection.slide_roll_ratio_limit)
    # S taken for the cage slip, as section 4.3 does
    is_slipping_by_ratio = exceeds(evidence.grid.slide_roll_ratio, selection.limits.slip_limit)
    ratio_of_thinnest = mu[-1:] / mu[:-1].min(axis=0, keepdims=True)
    ratios_to_thicker = mu[1:] / mu[:-1]
    largest_ratio_to_thicker = ratios_to_thicker.max(axis=0, keepdims=True)
    value = np.where(is_slipping, largest_ratio_to_thicker, ratio_of_thinnest)
    value_by_ratio = np.where(is_slipping_by_ratio, largest_ratio_to_thicker, ratio_of_thinnest)
    outcome_on_grid = evidence.outcome_on_grid(
        exceeds(1.0, value),
        value,
        as_cage_slip=exceeds(1.0, value_by_ratio[is_slipping_by_ratio | is_film_adequate]),
        more_than_thinnest=exceeds(1.0, ratios_to_thicker[1][..., is_slipping]),
        below=exceeds(1.0, value[..., ~is_slipping][is_film_adequate[..., ~is_slipping]]),
        beyond=exceeds(1.0, value[..., is_slipping]),
        adequate=is_film_adequate,
    )
    return _select_cases(outcome_on_grid, is_slipping | is_film_adequate, "no condition")


def heavy_load_4010(evidence: Evidence) -> Outcome:
    """Under heavy load with enough film 4010 has the least traction."""
    heavy_evidence = _limit_pressures(
        evidence, above=evidence.study.selection.limits.heavy_from_gpa, below=np.inf
    )
    mu = heavy_evidence.mu_by_viscosity()
    is_film_adequate = _is_film_of_thinnest_oil_full(heavy_evidence)
    ratio = mu[-1:] / mu[:-1].min(axis=0, keepdims=True)
    all_cases = heavy_evidence.outcome_on_grid(
        exceeds(1.0, ratio), ratio, adequate=is_film_adequate
    )
    outcome_with_film = _select_cases(all_cases, is_film_adequate, "no film")
    thinnest_has_least_torque = _has_thinnest_oil_least_torque(evidence)
    bearing_numbers = {
        "bearing": thinnest_has_least_torque.mean(),
        "bearing_points": float(len(thinnest_has_least_torque)),
    }
    return replace(outcome_with_film, numbers=outcome_with_film.numbers | bearing_numbers)


def _is_true_of_every_law(evidence: Evidence, is_true_of: Callable[[Law], BoolArray]) -> bool:
    """Whether something is true of every law, whatever its constants."""
    laws = {fitted.law.name: fitted.law for fitted in evidence.fit_by_oil.values()}
    return all(is_true_of(law).all() for law in laws.values())


def _mu_for_any_constants(law: Law, slip: FloatArray) -> FloatArray:
    """mu at slips for all combinations of coefficients within their bounds; rounding becomes 0."""
    levels = [
        np.geomspace(coefficient.smallest, coefficient.largest, _MAGNITUDE_COUNT)
        for coefficient in law.coefficients
    ]
    magnitudes = np.stack([mesh.ravel() for mesh in np.meshgrid(*levels)])[..., np.newaxis]
    with np.errstate(over="ignore", invalid="ignore"):
        mu = law.mu_of_magnitudes(magnitudes, slip)
    return np.where(np.abs(mu) <= _ROUNDING_SHARE * magnitudes.max(axis=0), 0.0, mu)


def _end_of_linear_range(evidence: Evidence) -> FloatArray:
    """Slip from which on mu/S differs from its value at no slip by more than the tolerance.

    The last slip where it never differs so much.
    """
    curve = evidence.curve_slips
    tolerance = evidence.study.audit.linear_tolerance
    # the slope at no slip is that over a slip a thousand times below the first step of the curve
    slip = np.concatenate([[curve[1] * 1e-3], curve[1:]])
    chord = evidence.mu(slide_roll_ratio=slip) / slip
    deviation = np.abs(chord / chord[..., :1] - 1)
    is_outside = deviation > tolerance
    leaves_range = is_outside.any(axis=_S, keepdims=True)
    first_outside = np.argmax(is_outside, axis=_S)[..., np.newaxis]
    index_after = np.where(leaves_range, first_outside, len(slip) - 1)
    index_before = index_after - 1
    # linear interpolation between the last slip inside and the first one outside
    deviation_before = np.take_along_axis(deviation, index_before, axis=_S)
    deviation_after = np.take_along_axis(deviation, index_after, axis=_S)
    is_rising = deviation_after > deviation_before
    rise = np.where(is_rising, deviation_after - deviation_before, 1.0)
    fraction = np.where(is_rising, (tolerance - deviation_before) / rise, 1.0)
    return np.where(
        leaves_range,
        slip[index_before] + fraction * (slip[index_after] - slip[index_before]),
        slip[-1],
    )


def _first_and_last(levels: FloatArray) -> tuple[float, float]:
    """The first and the last level."""
    return float(levels[0]), float(levels[-1])


def _falls_throughout(values: FloatArray, axis: int) -> BoolArray:
    """Whether values fall at every step along an axis, which is kept with length 1."""
    levels = np.moveaxis(values, axis, 0)
    falls: BoolArray = np.asarray(exceeds(levels[:-1], levels[1:]).all(axis=0, keepdims=True))
    return np.moveaxis(falls, 0, axis)


def _ranks(values: FloatArray) -> IndexArray:
    """Rank of each row in each column, 1 for the largest, shape (rows, n).

    Of equal values the earlier row ranks first.
    """
    is_larger = exceeds(values[:, np.newaxis], values)
    is_earlier_row = np.triu(np.ones((len(values), len(values)), dtype=bool), k=1)[..., np.newaxis]
    ranks_ahead = is_larger | (is_earlier_row & ~is_larger.swapaxes(0, 1))
    return np.asarray(1 + ranks_ahead.sum(axis=0))


def _near_one(ratio: FloatArray | float, tolerance: float) -> BoolArray:
    """Whether a ratio differs from 1 by the tolerance at most."""
    return reaches(tolerance, np.abs(np.asarray(ratio) - 1), term_size=1.0)


def _last_over_first(values: FloatArray, axis: int) -> FloatArray:
    """The last value along an axis over the first one."""
    return np.take(values, [-1], axis=axis) / np.take(values, [0], axis=axis)


def _straight_line_fit(
    evidence: Evidence, abscissa: FloatArray, values: FloatArray, axis: int
) -> tuple[BoolArray, FloatArray]:
    """Whether values along one axis are on a straight line, and the line's R2."""
    other_axes = [axis_index for axis_index in range(values.ndim) if axis_index != axis]
    x_deviation = np.expand_dims(abscissa - abscissa.mean(), other_axes)
    deviation = values - values.mean(axis=axis, keepdims=True)
    covariance = (x_deviation * deviation).sum(axis=axis, keepdims=True)
    r2 = covariance**2 / ((x_deviation**2).sum() * (deviation**2).sum(axis=axis, keepdims=True))
    return r2 >= evidence.study.printed.signs.linear_r2_min, r2


def _add_largest_slip(evidence: Evidence) -> Evidence:
    """The evidence with the largest tested slip added: the limit of cage slip is near it."""
    return evidence.with_levels(
        slide_roll_ratio=np.union1d(evidence.grid.slide_roll_ratio, evidence.curve_slips[-1])
    )


def _limit_pressures(evidence: Evidence, *, above: float, below: float) -> Evidence:
    """The evidence with as many levels of pressure, all of them in [above, below).

    Raises:
        NotCheckableError: There are none.
    """
    pressures = evidence.grid.max_hertz_pressure_gpa
    lowest, highest = max(above, pressures[0]), min(below, pressures[-1])
    if lowest >= highest:
        raise NotCheckableError("no condition")
    levels_inside = np.geomspace(lowest, highest, len(pressures))
    return evidence.with_levels(max_hertz_pressure_gpa=levels_inside[exceeds(below, levels_inside)])


def _is_film_of_thinnest_oil_full(evidence: Evidence) -> BoolArray:
    """Whether the film of the least viscous oil is thick enough, over the grid."""
    lambda_ratio = evidence.films(evidence.falling_viscosity[-1])[1]
    return exceeds(lambda_ratio, evidence.settings.gates.lambda_limit)


def _has_thinnest_oil_least_torque(evidence: Evidence) -> BoolArray:
    """Whether the least viscous oil has the least torque, at each heavily loaded operating point.

    Heavily loaded: from the highest pressure of the paper's tests on, with enough film. Points at
    which an oil has no equilibrium or no known film have no answer.

    Raises:
        NotCheckableError: There is no such point.
    """
    oils = list(evidence.falling_viscosity)
    slip_rows = evidence.campaign_tables.cage_slip
    slip_rows = slip_rows[slip_rows["oil"].isin(oils)]
    is_film_known = slip_rows["lambda_ratio"].notna()
    film_known_by_point = is_film_known.groupby(
        [slip_rows[name] for name in OPERATING_POINT_COLUMNS]
    )
    slip_rows = slip_rows[film_known_by_point.transform("all")]
    larger_pressure_gpa = slip_rows[
        ["inner_max_hertz_pressure_gpa", "outer_max_hertz_pressure_gpa"]
    ].max(axis=1)
    is_heavy = reaches(
        larger_pressure_gpa, evidence.study.printed.boxes.tested.max_hertz_pressure_gpa[1]
    )
    has_full_film = exceeds(slip_rows["lambda_ratio"], evidence.settings.gates.lambda_limit)
    slip_rows = slip_rows[has_full_film & is_heavy]
    torque_n_m = slip_rows.pivot(index=OPERATING_POINT_COLUMNS, columns="oil", values="torque_n_m")
    torque_n_m = torque_n_m.reindex(columns=oils).dropna(subset=[oils[-1]])
    if torque_n_m.empty:
        raise NotCheckableError("no bearing")
    return reaches(torque_n_m.min(axis=1), torque_n_m[oils[-1]])


def _cage_slip_rows(evidence: Evidence) -> pd.DataFrame:
    """The rows of the map of cage slip with an oil of the paper and an equilibrium.

    Raises:
        NotCheckableError: There are none.
    """
    slip_rows = evidence.campaign_tables.cage_slip
    slip_rows = slip_rows[slip_rows["oil"].isin(evidence.falling_viscosity)].dropna(
        subset="cage_slip"
    )
    if slip_rows.empty:
        raise NotCheckableError("no bearing")
    return slip_rows


def _coefficient_errors_of_curves(points: pd.DataFrame) -> "pd.Series[float]":
    """The largest relative standard error of A, B and C of each curve, fitted to it alone.

    Args:
        points: Table of points.

    Returns:
        By oil and run, `_UNDETERMINED_ERROR` at most. A curve with fewer than four points has none.
    """
    rows = []
    for (oil, run_id), curve in points.groupby(["oil", "run_id"], sort=False):
        if len(curve) > _COEFFICIENT_COUNT:
            slip, mu = curve[["slide_roll_ratio", "traction_coefficient"]].abs().to_numpy().T
            rows.append((oil, run_id, _coefficient_error_of_curve(slip, mu)))
    errors = pd.DataFrame(rows, columns=["oil", "run_id", "error"])
    error_by_curve = errors.set_index(["oil", "run_id"])["error"].astype(float)
    return error_by_curve.clip(upper=_UNDETERMINED_ERROR)


def _coefficient_error_of_curve(slip: FloatArray, mu: FloatArray) -> float:
    """The largest relative standard error of |A|, B and C of Eq. 7, fitted to one curve.

    The fit is in logarithms of the three, so that they keep their signs. It starts from the largest
    traction and from several shares of the slope at the first clear slip. From some starts it ends
    where a constant has no effect, far above the optimum.
    """
    largest_mu = mu.max()
    # at almost no slip mu is its own error, and the slope would be any number
    is_clear = slip >= _CLEAR_SLIP_SHARE * slip.max()
    slope = (mu[is_clear] / slip[is_clear]).max()

    def residual(logarithms: FloatArray) -> FloatArray:
        with np.errstate(over="ignore", invalid="ignore"):
            return DENG2026.mu_of_magnitudes(np.exp(logarithms)[:, np.newaxis], slip) - mu

    starts = [
        np.log([largest_mu, share * slope, (1 - share) * slope / largest_mu])
        for share in _SHARES_OF_SLOPE
    ]
    fits = [
        scipy.optimize.least_squares(
            residual,
            start,
            method="lm",
            ftol=_FIT_TOLERANCE,
            xtol=_FIT_TOLERANCE,
            gtol=_FIT_TOLERANCE,
        )
        for start in starts
    ]
    fit = min(fits, key=lambda candidate: float(candidate.cost))
    # the inverse of J'J by singular values; a direction without effect has an infinite error
    _, singular_values, directions = np.linalg.svd(np.asarray(fit.jac), full_matrices=False)
    variance = 2 * fit.cost / (len(slip) - _COEFFICIENT_COUNT)
    with np.errstate(divide="ignore", invalid="ignore"):
        inverse_diagonal = ((directions / singular_values[:, np.newaxis]) ** 2).sum(axis=0)
    return float(np.sqrt(variance * np.nan_to_num(inverse_diagonal, nan=np.inf).max()))


def _select_cases(judged: Outcome, is_selected: BoolArray, reason: str) -> Outcome:
    """An outcome with the cases that a claim is about.

    Args:
        judged: The outcome over the grid.
        is_selected: Whether the claim is about a case.
        reason: Code of the reason where it is about none.

    Raises:
        NotCheckableError: There are none.
    """
    if not is_selected.any():
        raise NotCheckableError(reason)
    return replace(judged, cases=judged.cases[is_selected.ravel()])


def _paper_law_fits(evidence: Evidence) -> pd.DataFrame:
    """Fits of the paper's law.

    Raises:
        NotCheckableError: There is no fit at all.
    """
    fits = evidence.rows_of_table("fit_quality", reason="no fit by the paper's law")
    return fits[fits["law"] == evidence.study.audit.stress_law]


def _relative_left_out_error(fits: pd.DataFrame) -> "pd.Series[float]":
    """The rms error at curves left out, relative to mu."""
    return fits["left_out_rmse"] * fits["relative_rms"] / fits["rmse"]


def _wang_deng_fits(evidence: Evidence) -> pd.DataFrame:
    """Fits of all versions of the Wang-Deng law.

    Raises:
        NotCheckableError: There are none, or the data were simulated with the paper's law.
    """
    fits = evidence.rows_of_table("fit_quality", reason="no comparison")
    if evidence.truth_is_law:
        raise NotCheckableError("tie")
    fits = fits[fits["law"].str.startswith("wang")].dropna(subset="rmse")
    if fits.empty:
        raise NotCheckableError("no comparison")
    return fits


def _torque_errors(evidence: Evidence) -> tuple[pd.DataFrame, dict[str, float]]:
    """Relative errors of the torque by load variable, and counts of points that are not judged.

    These are points where the cage may roll or skid, and points where that is not known.
    """
    torque_rows = evidence.rows_of_table("torque", reason="no torque")
    for control_verdict in ("two truths", "positive control"):
        if (evidence.campaign_tables.torque_control["verdict"] == control_verdict).any():
            raise NotCheckableError(control_verdict)
    plateau_and_oil = ["run_id", "first_row", "oil"]
    certain_rows = drop_bistable_plateaus(torque_rows).set_index(
        [*plateau_and_oil, "load_variable"]
    )
    errors = certain_rows["relative_error"].abs().unstack(sort=False)
    errors = errors.reindex(columns=["stress", "load"]).reset_index()
    if errors["stress"].isna().all():
        raise NotCheckableError("no torque by the law")
    bistable_count = len(torque_rows[is_bistable(torque_rows)].drop_duplicates(plateau_and_oil[:2]))
    counts = {"bistable": bistable_count, "undecided": undecided_plateau_count(torque_rows)}
    return errors, {name: float(count) for name, count in counts.items() if count}
