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
from scipy.optimize import least_squares

from deng2026_study.audit.evidence import NotCheckableError, Outcome, View, outcome
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
from oilfilm.torque.torque_control import is_bistable, undecided_plateaus, without_bistable
from oilfilm.traction.law import Law
from oilfilm.traction.laws.deng2026 import DENG2026

# Axes of the arrays.
_P_AXIS, _U_AXIS, _T_AXIS, _S_AXIS = 1, 2, 3, 4
# D cos(alpha)/dm of ball bearings.
_GAMMAS = (0.0, 0.1, 0.2, 0.3)
# Sizes of each coefficient that represent all sizes that a law allows.
_SIZE_COUNT_OF_COEFFICIENT = 6
# Values of mu up to this share of the largest coefficient are rounding.
_ROUNDING_SHARE = 1e-15
# Deng et al. (2026), section 2.1: Ra of ball and disc, and their composite roughness as stated.
_RA_UM = (0.014, 0.010)
_COMPOSITE_UM = 0.017
# Cage slip from which on there is something to suppress.
_SLIPPING = 0.01
# A, B and C of Eq. 7.
_COEFFICIENT_COUNT_OF_CURVE = 3
# Lowest slip at which the slope of a curve is clear, over the largest slip.
_CLEAR_SLIP = 0.01
# Shares of the slope at that slip from which the fit of a curve starts.
_SHARES_OF_SLOPE = (0.2, 0.5, 0.8, 0.95)
# Tolerances of that fit, relative.
_FIT_TOLERANCE = 1e-12
# Relative standard errors from this on say the same: the curve does not determine the coefficient.
_LARGEST_RELATIVE_ERROR = 1e3


def zero_slip(view: View) -> Outcome:
    """Without slip there is no traction."""
    without_slip = view.with_levels(slide_roll_ratio=[0.0])
    mu = np.abs(without_slip.mu())
    holds_for_any_constants = _true_of_every_law(
        view, lambda law: _any_constants(law, np.zeros(1)) == 0
    )
    outcome_on_grid = without_slip.outcome(mu <= view.study.audit.zero_traction_max, mu)
    return replace(outcome_on_grid, by_construction=holds_for_any_constants)


def non_negative(view: View) -> Outcome:
    """Mu is never negative."""
    mu = view.mu(slide_roll_ratio=view.curve[1:])
    lowest_mu = mu.min(axis=_S_AXIS, keepdims=True)
    largest_size = np.abs(mu).max(axis=_S_AXIS, keepdims=True)
    holds_for_any_constants = _true_of_every_law(
        view, lambda law: _any_constants(law, view.curve) >= 0
    )
    return replace(
        view.outcome(reaches(lowest_mu, 0.0, largest_size), lowest_mu),
        by_construction=holds_for_any_constants,
    )


def linear_start(view: View) -> Outcome:
    """Mu begins as a straight line."""
    linear_end = _linear_range(view)
    required_end = view.study.audit.linear_to_slip
    start_slips = np.linspace(0.0, required_end, view.study.audit.levels)
    is_straight, _ = _straight(view, start_slips, view.mu(slide_roll_ratio=start_slips), _S_AXIS)
    return view.outcome(
        is_straight,
        linear_end,
        within=reaches(linear_end, required_end),
        longest=np.nanmax(linear_end),
    )


def peak_decline(view: View) -> Outcome:
    """Mu peaks, then declines slightly."""
    mu = view.mu(slide_roll_ratio=view.curve)
    peak_mu = mu.max(axis=_S_AXIS, keepdims=True)
    mu_at_largest_slip = mu[..., -1:]
    # a law that comes to a constant level reaches it within rounding, and has no peak
    has_peak = exceeds(peak_mu, mu_at_largest_slip)
    decline = 1 - mu_at_largest_slip / peak_mu
    is_slight = reaches(view.study.printed.signs.decline_max, decline, size=1.0)
    is_shown_oil = [oil == view.falling_viscosity[0] for oil in view.laws]
    decline_coldest = decline[:, :, :, 0]
    return view.outcome(
        has_peak & is_slight,
        decline,
        shown_oil=(has_peak & is_slight)[is_shown_oil],
        peaks=has_peak,
        slight=is_slight,
        coldest_least=view.by_oil(np.nanmin, decline_coldest),
        coldest_most=view.by_oil(np.nanmax, decline_coldest),
    )


def falls_with_temperature(view: View) -> Outcome:
    """Mu falls with T, more steeply where it is cold."""
    audit_settings = view.study.audit
    mu = view.mu()
    lowest_c, highest_c = _ends(view.grid.inlet_temperature_c)
    cold_band, hot_band = np.clip(
        [audit_settings.cold_band_c, audit_settings.hot_band_c], lowest_c, highest_c
    )
    cold_slope = -np.diff(view.mu(inlet_temperature_c=cold_band), axis=_T_AXIS) / np.diff(cold_band)
    hot_slope = -np.diff(view.mu(inlet_temperature_c=hot_band), axis=_T_AXIS) / np.diff(hot_band)
    # slopes have the rounding of the largest slope that mu could give
    largest_slope = np.abs(mu).max() / min(np.diff(cold_band)[0], np.diff(hot_band)[0])
    is_steeper_when_cold = exceeds(cold_slope, hot_slope, size=largest_slope)
    falls_everywhere = _falls(mu, _T_AXIS)
    return view.outcome(
        falls_everywhere & is_steeper_when_cold,
        _last_over_first(mu, _T_AXIS),
        always=falls_everywhere,
        steeper=is_steeper_when_cold,
    )


def falls_with_speed(view: View) -> Outcome:
    """Mu falls with U and levels off."""
    mu = view.mu()
    ends_of_thirds = np.linspace(*_ends(view.grid.entrainment_speed_m_s), 4)
    fall = -np.diff(view.mu(entrainment_speed_m_s=ends_of_thirds), axis=_U_AXIS)
    levels_off = exceeds(fall[:, :, :1], np.abs(fall[:, :, 2:]), size=np.abs(mu).max())
    falls_everywhere = _falls(mu, _U_AXIS)
    return view.outcome(
        falls_everywhere & levels_off,
        _last_over_first(mu, _U_AXIS),
        always=falls_everywhere,
        levels_off=levels_off,
    )


def rises_with_stress(view: View) -> Outcome:
    """Mu rises with P, about linearly."""
    pressures = view.grid.max_hertz_pressure_gpa
    even_pressures = np.linspace(*_ends(pressures), len(pressures))
    mu = view.mu(max_hertz_pressure_gpa=even_pressures)
    rises_everywhere = _falls(-mu, _P_AXIS)
    is_straight, r2 = _straight(view, even_pressures, mu, _P_AXIS)
    median_r2 = view.by_oil(np.nanmedian, r2)
    return view.outcome(
        rises_everywhere & is_straight,
        r2,
        always=rises_everywhere,
        straight=is_straight,
        median_r2=median_r2,
    )


def rises_with_slip(view: View) -> Outcome:
    """The level of mu rises with S."""
    tested_ends = view.study.printed.boxes.tested.max_hertz_pressure_gpa
    at_highest_pressure = view.with_levels(max_hertz_pressure_gpa=tested_ends[1:])
    mu = at_highest_pressure.mu()
    level_rises = _falls(-mu.mean(axis=(_U_AXIS, _T_AXIS), keepdims=True), _S_AXIS)
    ends_rise = exceeds(mu[..., -1], mu[..., 0])
    return at_highest_pressure.outcome(
        _falls(-mu, _S_AXIS), _last_over_first(mu, _S_AXIS), level=level_rises, ends=ends_rise
    )


def similar_limit(view: View) -> Outcome:
    """Mu approaches a plateau, alike for all oils."""
    largest_slip = view.curve[-1]
    mu = view.mu_by_viscosity(
        slide_roll_ratio=[view.grid.slide_roll_ratio[0], largest_slip * 2 / 3, largest_slip]
    )
    change = np.abs(mu[..., 2:] / mu[..., 1:2] - 1).max(axis=0, keepdims=True)
    relative_spread = np.ptp(mu, axis=0) / mu.mean(axis=0)
    return view.outcome(
        reaches(view.study.audit.plateau_change_max, change, size=1.0),
        change,
        closer=exceeds(relative_spread[..., 0], relative_spread[..., 2], size=1.0),
        apart_at_start=relative_spread[..., 0].mean(),
        apart_at_end=relative_spread[..., 2].mean(),
    )


def earlier_plateau(view: View) -> Outcome:
    """A higher P leaves the linear range earlier."""
    linear_end = _linear_range(view)
    ends_c = _ends(view.grid.inlet_temperature_c)
    mu = view.mu(inlet_temperature_c=ends_c, slide_roll_ratio=view.curve)
    is_on_plateau = reaches(
        mu, view.study.audit.plateau_share * mu.max(axis=_S_AXIS, keepdims=True)
    )
    plateau_begin = view.curve[np.argmax(is_on_plateau, axis=_S_AXIS)]
    return view.outcome(
        _falls(linear_end, _P_AXIS),
        _last_over_first(linear_end, _P_AXIS),
        plateau_coldest=view.by_oil(np.median, plateau_begin[..., 0]),
        plateau_hottest=view.by_oil(np.median, plateau_begin[..., 1]),
    )


def viscosity_order(view: View) -> Outcome:
    """Mu falls from each oil to the next less viscous one."""
    oils = view.falling_viscosity
    mu = view.mu_by_viscosity()
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
        numbers["turn_gpa"] = np.interp(0.5, share_above_next, view.grid.max_hertz_pressure_gpa)
    return view.outcome(
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


def hot_convergence(view: View) -> Outcome:
    """The oils come nearer to one another as they warm."""
    mu = view.mu_by_viscosity(inlet_temperature_c=_ends(view.grid.inlet_temperature_c))
    spread = np.ptp(mu, axis=0, keepdims=True)
    relative_spread = spread / mu.mean(axis=0, keepdims=True)
    spread_coldest, spread_hottest = relative_spread.mean(axis=(0, 1, 2, 4))
    return view.outcome(
        _falls(spread, _T_AXIS),
        _last_over_first(spread, _T_AXIS),
        relative=_falls(relative_spread, _T_AXIS),
        spread_coldest=spread_coldest,
        spread_hottest=spread_hottest,
    )


def speed_mutes_temperature(view: View) -> Outcome:
    """T changes mu less at a high speed."""
    speeds = np.clip(view.study.audit.slow_and_fast_m_s, *_ends(view.grid.entrainment_speed_m_s))
    ends_c = _ends(view.grid.inlet_temperature_c)
    mu = view.mu(entrainment_speed_m_s=speeds, inlet_temperature_c=ends_c)
    drop = -np.diff(mu, axis=_T_AXIS)
    drop_ratio = _last_over_first(drop, _U_AXIS)
    relative_drop_falls = _falls(drop / mu[:, :, :, :1], _U_AXIS)
    return view.outcome(exceeds(1.0, drop_ratio), drop_ratio, relative=relative_drop_falls)


def full_film(view: View) -> Outcome:
    """Film and lambda are above what a full film needs."""
    oils = view.falling_viscosity
    film_min_um = view.study.audit.film_min_um
    limit_of_film_and_lambda = np.array([film_min_um, view.settings.gates.lambda_limit])
    figure_slips = view.study.printed.signs.slide_roll_ratio.figures
    at_curve_slips = view.with_levels(slide_roll_ratio=[0.0, *figure_slips, view.curve[-1]])
    points = view.measured.points.dropna(subset=["lambda_ratio"])
    if view.basis == "printed" or view.measured.points.empty:
        film_and_lambda = at_curve_slips.films(*oils)
        margin_of_film_and_lambda = film_and_lambda / limit_of_film_and_lambda.reshape(
            2, 1, 1, 1, 1, 1
        )
        smaller_margin = margin_of_film_and_lambda.min(axis=0)
        cases = at_curve_slips.cases(oils, exceeds(smaller_margin, 1.0), smaller_margin)
    elif points.empty:
        raise NotCheckableError("no lambda")
    else:
        film_and_lambda = points[["film_thickness_um", "lambda_ratio"]].to_numpy().T
        margin_of_film_and_lambda = film_and_lambda / limit_of_film_and_lambda.reshape(2, 1)
        cases = points.assign(value=margin_of_film_and_lambda.min(axis=0))
        cases["holds"] = exceeds(cases["value"], 1.0)
    central_um, _ = at_curve_slips.films(film_kind="central")
    unknown_count = cases["value"].isna().sum()
    return outcome(
        # where the formula gives no film the claim is neither true nor false
        cases.dropna(subset="value"),
        central=_above_one(central_um / film_min_um),
        full=_above_one(margin_of_film_and_lambda[1]),
        thick=_above_one(margin_of_film_and_lambda[0]),
        smallest_lambda=np.nanmin(film_and_lambda[1]),
        thinnest_um=np.nanmin(film_and_lambda[0]),
        unknown=unknown_count if unknown_count else np.nan,
    )


def _above_one(margin: FloatArray) -> BoolArray:
    """Whether each known margin exceeds 1; unknown ones are left out."""
    return exceeds(margin, 1.0)[~np.isnan(margin)]


def air_spindle(view: View) -> Outcome:
    """The spindle's friction is negligible. No log tells it from a zero of the force sensor."""
    raise NotCheckableError("no spindle")


def wang_deng_zero(view: View) -> Outcome:
    """The Wang-Deng law has traction without slip."""
    fits = _wang_deng(view)
    mu_at_zero_slip = fits["zero_slip_traction"].abs()
    holds = mu_at_zero_slip > view.study.audit.zero_traction_max
    return outcome(fits.assign(holds=holds, value=mu_at_zero_slip), largest=mu_at_zero_slip.max())


def wang_deng_overfit(view: View) -> Outcome:
    """The errors of the Wang-Deng law grow more on curves left out."""
    audit_settings = view.study.audit
    fits = _wang_deng(view)
    all_fits = view.measured.fit_quality
    by_paper_law = all_fits[all_fits["law"] == audit_settings.stress_law].set_index("oil")
    if not set(fits["oil"]) <= set(by_paper_law.index):
        raise NotCheckableError("no fit by the paper's law")
    growth = fits["left_out_rmse"] / fits["rmse"]
    growth_of_paper_law = by_paper_law["left_out_rmse"] / by_paper_law["rmse"]
    relative_growth = growth / fits["oil"].map(growth_of_paper_law)
    return outcome(
        fits.assign(
            holds=exceeds(relative_growth, audit_settings.overfit_min), value=relative_growth
        )
    )


def properties_not_needed(view: View) -> Outcome:
    """Laws with properties of the oil predict no better than the paper's law."""
    largest_good_error = view.study.audit.prediction_error
    by_paper_law = _by_paper_law(view).set_index("oil")
    if view.truth_is_law:
        raise NotCheckableError("own law")
    all_fits = view.measured.fit_quality
    fits = all_fits[all_fits["law"].isin(view.study.audit.property_laws)]
    end_column, left_out_column = "temperature_end_out_relative_rms", "left_out_rmse"
    fits = fits[fits["oil"].isin(by_paper_law.index)].dropna(subset=[end_column, left_out_column])
    if fits.empty:
        raise NotCheckableError("no comparison")
    paper_law_fits = by_paper_law.loc[fits["oil"]].set_axis(fits.index)
    error_ratio = paper_law_fits[left_out_column] / fits[left_out_column]
    return outcome(
        fits.assign(holds=reaches(1.0, error_ratio), value=error_ratio),
        ends=reaches(fits[end_column].to_numpy(), paper_law_fits[end_column].to_numpy()),
        enough=reaches(largest_good_error, _relative_left_out(by_paper_law).to_numpy()),
        own_error=paper_law_fits.groupby(fits["oil"], sort=False)[end_column].first().to_dict(),
        least_error=fits.groupby("oil", sort=False)[end_column].min().to_dict(),
    )


def torque_stress(view: View) -> Outcome:
    """The law of pressure gives the torque of a bearing."""
    errors, count_by_number_name = _torque_errors(view)
    errors = errors.dropna(subset="stress")
    holds = reaches(view.study.audit.torque_stress_error, errors["stress"])
    cases = errors.assign(holds=holds, value=errors["stress"])
    return outcome(cases, largest=errors["stress"].max(), **count_by_number_name)


def torque_load(view: View) -> Outcome:
    """The law of load does not."""
    errors, count_by_number_name = _torque_errors(view)
    errors_of_both = errors.dropna()
    if errors_of_both.empty:
        raise NotCheckableError("no torque by the law")
    excess = errors_of_both["load"] - errors_of_both["stress"]
    largest_error = errors_of_both["load"].max()
    load_is_worse = exceeds(errors_of_both["load"], errors_of_both["stress"], size=1.0)
    load_is_worse_on_median = exceeds(
        errors_of_both["load"].median(), errors_of_both["stress"].median(), size=1.0
    )
    torque_outcome = outcome(
        errors_of_both.assign(holds=load_is_worse, value=excess),
        systematic=load_is_worse_on_median,
        largest=largest_error,
        **count_by_number_name,
    )
    return replace(
        torque_outcome, can_hold=bool(reaches(largest_error, view.study.audit.torque_load_error))
    )


def uniquely_determined(view: View) -> Outcome:
    """The curves determine A, B and C; all curves of an oil determine its constants."""
    fits = _by_paper_law(view).dropna(subset="constant_spread")
    error_of_curve = _errors_of_curves(view.measured.points)
    if fits.empty or error_of_curve.empty:
        raise NotCheckableError("no fit by the paper's law")
    coefficients = view.measured.coefficients
    of_paper_law = coefficients["law"] == view.study.audit.stress_law
    is_known = coefficients[of_paper_law & coefficients["oil"].isin(fits["oil"])]["verdict"].eq(
        "known"
    )
    # digits below a millionth of a standard error are rounding
    spread = fits["constant_spread"].round(6)
    cases = error_of_curve.rename("value").reset_index()
    return outcome(
        cases.assign(holds=reaches(view.study.audit.curve_error_max, cases["value"])),
        constants=fits["certified"].to_numpy(),
        known=is_known.to_numpy(),
        spread=spread.max(),
        curve_error=error_of_curve.groupby(level="oil", sort=False).median().to_dict(),
    )


def genetic_optimum(view: View) -> Outcome:
    """The genetic algorithm finds the optimum. The paper does not state errors of its constants."""
    raise NotCheckableError("not stated")


def extrapolates(view: View) -> Outcome:
    """The law predicts beyond the tested conditions."""
    largest_good_error = view.study.audit.prediction_error
    fits = _by_paper_law(view)
    if view.truth_is_law:
        raise NotCheckableError("own law")
    errors_at_ends = fits.filter(regex="^oil$|_end_out_relative_rms$").melt("oil").dropna()
    if errors_at_ends.empty:
        raise NotCheckableError("no fit by the paper's law")
    left_out_error = _relative_left_out(fits)
    rows_beyond_tests = view.measured.extrapolation
    of_paper_law = rows_beyond_tests["law"] == view.study.audit.stress_law
    has_fitted_oil = rows_beyond_tests["oil"].isin(fits["oil"])
    rows_beyond_tests = rows_beyond_tests[
        of_paper_law & has_fitted_oil & (rows_beyond_tests["beyond"].map(len) > 0)
    ]
    error = (
        rows_beyond_tests["traction_coefficient"] / rows_beyond_tests["true_traction_coefficient"]
        - 1
    ).abs()
    return outcome(
        errors_at_ends.assign(holds=reaches(largest_good_error, errors_at_ends["value"])),
        truth=reaches(largest_good_error, error),
        accuracy=reaches(largest_good_error, left_out_error),
        left_out=left_out_error.max(),
    )


def composite_roughness(view: View) -> Outcome:
    """The roughness of ball and disc make the stated one."""
    composite_um = float(np.hypot(*_RA_UM))
    cases = pd.DataFrame(
        {"oil": [""], "holds": composite_um < _COMPOSITE_UM, "value": composite_um}
    )
    return outcome(cases, rounded=round(composite_um, 3) <= _COMPOSITE_UM)


def rolling_speed(view: View) -> Outcome:
    """The stated dmN has the stated entrainment speed."""
    stated = view.study.selection.stated
    tolerance = view.study.audit.kinematic_tolerance
    pitch_speed = stated.pitch_speed_mm_rpm
    stated_m_s = stated.entrainment_speed_m_s
    rolling_speed_m_s = np.array([entrainment_speed_m_s(pitch_speed, gamma) for gamma in _GAMMAS])
    surface_m_s = surface_speed_m_s(pitch_speed)
    is_near = _near_one(rolling_speed_m_s / stated_m_s, tolerance)
    return outcome(
        pd.DataFrame({"oil": "", "holds": is_near, "value": rolling_speed_m_s}),
        as_surface=_near_one(surface_m_s / stated_m_s, tolerance),
        highest=rolling_speed_m_s.max(),
        surface_speed=surface_m_s,
        pitch_speed=pitch_speed_mm_rpm(stated_m_s),
    )


def slip_is_cage_slip(view: View) -> Outcome:
    """The slide-roll ratio of a bearing is its cage slip."""
    selection = view.study.selection
    cage_slips = np.linspace(0.05, 0.4, 8)
    ratio = np.concatenate(
        [inner_slide_roll_ratio(cage_slips, gamma) / cage_slips for gamma in _GAMMAS]
    )
    tolerance = view.study.audit.kinematic_tolerance
    slip_limit = selection.limits.slip_limit
    is_near = _near_one(ratio, tolerance)
    return outcome(
        pd.DataFrame({"oil": "", "holds": is_near, "value": ratio}),
        both_races=_near_one(ratio / 2, tolerance),
        smallest=ratio.min(),
        at_limit=inner_slide_roll_ratio(slip_limit, selection.gamma),
        cage_slip=cage_slip(slip_limit, selection.gamma),
    )


def load_suppresses_slip(view: View) -> Outcome:
    """The cage slips less under a higher load."""
    slip_rows = _cage_slips(view)
    slip_by_load = slip_rows.pivot(
        index="axial_load_n", columns=["oil", "inlet_temperature_c", "pitch_speed_mm_rpm"]
    )["cage_slip"]
    slip_at_lighter_load = slip_by_load.shift()
    load_steps = pd.DataFrame(
        {"lighter": slip_at_lighter_load.stack([0, 1, 2]), "heavier": slip_by_load.stack([0, 1, 2])}
    )
    load_steps = load_steps[exceeds(load_steps["lighter"], _SLIPPING)].dropna()
    if load_steps.empty:
        raise NotCheckableError("no bearing")
    change = load_steps["heavier"] - load_steps["lighter"]
    slip_falls = exceeds(0.0, change, size=1.0)
    is_slipping = exceeds(load_steps["lighter"], view.study.selection.limits.slip_limit)
    cases = load_steps.reset_index().assign(holds=slip_falls, value=change.to_numpy())
    return outcome(cases, where_it_slips=slip_falls[is_slipping])


def heavy_load_grips(view: View) -> Outcome:
    """Where the contact pressure is high the cage hardly slips."""
    limits = view.study.selection.limits
    slip_rows = _cage_slips(view)
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
    return outcome(slip_rows[is_heavy], light=slip_rows.loc[is_light, "holds"].to_numpy())


def light_load_4102(view: View) -> Outcome:
    """Under light load 4102 has the most traction."""
    selection = view.study.selection
    light_view = _at_pressures_within(
        _with_largest_slip(view), above=-np.inf, below=selection.limits.light_below_gpa
    )
    mu = light_view.mu_by_viscosity()
    grid = light_view.grid
    ratio = mu[:1] / mu[1:].max(axis=0, keepdims=True)
    is_hot = reaches(grid.inlet_temperature_c, selection.limits.hot_from_c)
    is_fast = reaches(grid.entrainment_speed_m_s, selection.fast_from_m_s)
    is_slipping = exceeds(grid.slide_roll_ratio, selection.slide_roll_ratio_limit)
    hot_and_fast_ratio = ratio[:, :, is_fast][:, :, :, is_hot][..., is_slipping]
    return light_view.outcome(
        exceeds(ratio, 1.0),
        ratio,
        higher_viscosity=exceeds(mu[:-1].min(axis=0), mu[-1]),
        hot_and_fast=exceeds(hot_and_fast_ratio, 1.0),
    )


def slip_15(view: View) -> Outcome:
    """Up to 15 % cage slip the thinnest oil has the least traction, beyond it the thickest most."""
    selection = view.study.selection
    view = _with_largest_slip(view)
    mu = view.mu_by_viscosity()
    is_film_adequate = _thinnest_is_adequate(view)
    is_slipping = exceeds(view.grid.slide_roll_ratio, selection.slide_roll_ratio_limit)
    # S taken for the cage slip, as section 4.3 does
    is_slipping_by_ratio = exceeds(view.grid.slide_roll_ratio, selection.limits.slip_limit)
    ratio_of_thinnest = mu[-1:] / mu[:-1].min(axis=0, keepdims=True)
    ratios_to_thicker = mu[1:] / mu[:-1]
    largest_ratio_to_thicker = ratios_to_thicker.max(axis=0, keepdims=True)
    value = np.where(is_slipping, largest_ratio_to_thicker, ratio_of_thinnest)
    value_by_ratio = np.where(is_slipping_by_ratio, largest_ratio_to_thicker, ratio_of_thinnest)
    outcome_on_grid = view.outcome(
        exceeds(1.0, value),
        value,
        as_cage_slip=exceeds(1.0, value_by_ratio[is_slipping_by_ratio | is_film_adequate]),
        more_than_thinnest=exceeds(1.0, ratios_to_thicker[1][..., is_slipping]),
        below=exceeds(1.0, value[..., ~is_slipping][is_film_adequate[..., ~is_slipping]]),
        beyond=exceeds(1.0, value[..., is_slipping]),
        adequate=is_film_adequate,
    )
    return _only_cases(outcome_on_grid, is_slipping | is_film_adequate, "no condition")


def heavy_load_4010(view: View) -> Outcome:
    """Under heavy load with enough film 4010 has the least traction."""
    heavy_view = _at_pressures_within(
        view, above=view.study.selection.limits.heavy_from_gpa, below=np.inf
    )
    mu = heavy_view.mu_by_viscosity()
    is_film_adequate = _thinnest_is_adequate(heavy_view)
    ratio = mu[-1:] / mu[:-1].min(axis=0, keepdims=True)
    all_cases = heavy_view.outcome(exceeds(1.0, ratio), ratio, adequate=is_film_adequate)
    outcome_with_film = _only_cases(all_cases, is_film_adequate, "no film")
    thinnest_has_least_torque = _least_torque_of_thinnest(view)
    bearing_numbers = {
        "bearing": thinnest_has_least_torque.mean(),
        "bearing_points": float(len(thinnest_has_least_torque)),
    }
    return replace(outcome_with_film, numbers=outcome_with_film.numbers | bearing_numbers)


def _true_of_every_law(view: View, holds_for: Callable[[Law], BoolArray]) -> bool:
    """Whether something is true of every law, whatever its constants."""
    law_by_name = {fitted.law.name: fitted.law for fitted in view.laws.values()}
    return all(holds_for(law).all() for law in law_by_name.values())


def _any_constants(law: Law, slip: FloatArray) -> FloatArray:
    """mu at slips for all combinations of coefficients within their bounds; rounding becomes 0."""
    sizes_of_coefficients = [
        np.geomspace(coefficient.smallest, coefficient.largest, _SIZE_COUNT_OF_COEFFICIENT)
        for coefficient in law.coefficients
    ]
    sizes = np.stack([size.ravel() for size in np.meshgrid(*sizes_of_coefficients)])[
        ..., np.newaxis
    ]
    with np.errstate(over="ignore", invalid="ignore"):
        mu = law.mu_of_sizes(sizes, slip)
    return np.where(np.abs(mu) <= _ROUNDING_SHARE * sizes.max(axis=0), 0.0, mu)


def _linear_range(view: View) -> FloatArray:
    """Slip from which mu/S differs from its value at no slip by the tolerance.

    The last slip where it never does.
    """
    curve = view.curve
    tolerance = view.study.audit.linear_tolerance
    # the slope at no slip is that over a slip a thousand times below the first step of the curve
    slip = np.concatenate([[curve[1] * 1e-3], curve[1:]])
    chord = view.mu(slide_roll_ratio=slip) / slip
    deviation = np.abs(chord / chord[..., :1] - 1)
    is_outside = deviation > tolerance
    leaves_tolerance = is_outside.any(axis=_S_AXIS, keepdims=True)
    first_index_outside = np.argmax(is_outside, axis=_S_AXIS)[..., np.newaxis]
    index_of_outside = np.where(leaves_tolerance, first_index_outside, len(slip) - 1)
    index_of_inside = index_of_outside - 1
    # linear interpolation between the last slip inside and the first one outside
    deviation_before = np.take_along_axis(deviation, index_of_inside, axis=_S_AXIS)
    deviation_after = np.take_along_axis(deviation, index_of_outside, axis=_S_AXIS)
    rises = deviation_after > deviation_before
    deviation_step = np.where(rises, deviation_after - deviation_before, 1.0)
    fraction_of_step = np.where(rises, (tolerance - deviation_before) / deviation_step, 1.0)
    return np.where(
        leaves_tolerance,
        slip[index_of_inside] + fraction_of_step * (slip[index_of_outside] - slip[index_of_inside]),
        slip[-1],
    )


def _ends(levels: FloatArray) -> tuple[float, float]:
    """The first and the last level."""
    return float(levels[0]), float(levels[-1])


def _falls(values: FloatArray, axis: int) -> BoolArray:
    """Whether values fall at every step along an axis, which is kept with length 1."""
    values_of_level = np.moveaxis(values, axis, 0)
    falls: BoolArray = np.asarray(
        exceeds(values_of_level[:-1], values_of_level[1:]).all(axis=0, keepdims=True)
    )
    return np.moveaxis(falls, 0, axis)


def _ranks(values: FloatArray) -> IndexArray:
    """Rank of each row among the rows, 1 for the largest, shape (rows, n); of equals by the row."""
    is_larger = exceeds(values[:, np.newaxis], values)
    is_earlier_row = np.triu(np.ones((len(values), len(values)), dtype=bool), k=1)[..., np.newaxis]
    is_ahead = is_larger | (is_earlier_row & ~is_larger.swapaxes(0, 1))
    return np.asarray(1 + is_ahead.sum(axis=0))


def _near_one(ratio: FloatArray | float, tolerance: float) -> BoolArray:
    """Whether a ratio differs from 1 by the tolerance at most."""
    return reaches(tolerance, np.abs(np.asarray(ratio) - 1), size=1.0)


def _last_over_first(values: FloatArray, axis: int) -> FloatArray:
    """The last value along an axis over the first one."""
    return np.take(values, [-1], axis=axis) / np.take(values, [0], axis=axis)


def _straight(
    view: View, abscissa: FloatArray, values: FloatArray, axis: int
) -> tuple[BoolArray, FloatArray]:
    """Whether values along one axis are on a straight line, and the line's R2."""
    other_axes = [axis_index for axis_index in range(values.ndim) if axis_index != axis]
    x_deviation = np.expand_dims(abscissa - abscissa.mean(), other_axes)
    deviation = values - values.mean(axis=axis, keepdims=True)
    covariance = (x_deviation * deviation).sum(axis=axis, keepdims=True)
    r2 = covariance**2 / ((x_deviation**2).sum() * (deviation**2).sum(axis=axis, keepdims=True))
    return r2 >= view.study.printed.signs.linear_r2_min, r2


def _with_largest_slip(view: View) -> View:
    """The grid with the largest tested slip added, because the limit of cage slip is near it."""
    return view.with_levels(slide_roll_ratio=np.union1d(view.grid.slide_roll_ratio, view.curve[-1]))


def _at_pressures_within(view: View, *, above: float, below: float) -> View:
    """The grid with as many levels of pressure in [above, below) only.

    Raises:
        NotCheckableError: There are none.
    """
    pressures = view.grid.max_hertz_pressure_gpa
    lowest, highest = max(above, pressures[0]), min(below, pressures[-1])
    if lowest >= highest:
        raise NotCheckableError("no condition")
    inside = np.geomspace(lowest, highest, len(pressures))
    return view.with_levels(max_hertz_pressure_gpa=inside[exceeds(below, inside)])


def _thinnest_is_adequate(view: View) -> BoolArray:
    """Where the film of the least viscous oil is thick enough."""
    lambda_ratio = view.films(view.falling_viscosity[-1])[1]
    return exceeds(lambda_ratio, view.settings.gates.lambda_limit)


def _least_torque_of_thinnest(view: View) -> BoolArray:
    """Whether the least viscous oil has the least torque, at each heavily loaded operating point.

    Heavily loaded: from the highest pressure of the paper's tests on, with enough film. Points at
    which an oil has no equilibrium or no known film have no answer.

    Raises:
        NotCheckableError: There is no such point.
    """
    oil_names = list(view.falling_viscosity)
    slip_rows = view.measured.cage_slip
    slip_rows = slip_rows[slip_rows["oil"].isin(oil_names)]
    is_film_known = slip_rows["lambda_ratio"].notna()
    is_film_known_by_point = is_film_known.groupby(
        [slip_rows[name] for name in OPERATING_POINT_COLUMNS]
    )
    slip_rows = slip_rows[is_film_known_by_point.transform("all")]
    larger_pressure_gpa = slip_rows[
        ["inner_max_hertz_pressure_gpa", "outer_max_hertz_pressure_gpa"]
    ].max(axis=1)
    is_heavy = reaches(
        larger_pressure_gpa, view.study.printed.boxes.tested.max_hertz_pressure_gpa[1]
    )
    has_full_film = exceeds(slip_rows["lambda_ratio"], view.settings.gates.lambda_limit)
    slip_rows = slip_rows[has_full_film & is_heavy]
    torque = slip_rows.pivot(index=OPERATING_POINT_COLUMNS, columns="oil", values="torque_n_m")
    torque = torque.reindex(columns=oil_names).dropna(subset=[oil_names[-1]])
    if torque.empty:
        raise NotCheckableError("no bearing")
    return reaches(torque.min(axis=1), torque[oil_names[-1]])


def _cage_slips(view: View) -> pd.DataFrame:
    """The rows of the map of cage slip with an oil of the paper and an equilibrium.

    Raises:
        NotCheckableError: There are none.
    """
    slip_rows = view.measured.cage_slip
    slip_rows = slip_rows[slip_rows["oil"].isin(view.falling_viscosity)].dropna(subset="cage_slip")
    if slip_rows.empty:
        raise NotCheckableError("no bearing")
    return slip_rows


def _errors_of_curves(points: pd.DataFrame) -> "pd.Series[float]":
    """The largest relative standard error of A, B and C of each curve, fitted to it alone.

    Args:
        points: Table of points.

    Returns:
        Errors by oil and run, `_LARGEST_RELATIVE_ERROR` at most. A curve with fewer than four
        points has none.
    """
    rows_of_curves = []
    for (oil_name, run_id), curve in points.groupby(["oil", "run_id"], sort=False):
        if len(curve) > _COEFFICIENT_COUNT_OF_CURVE:
            slip, mu = curve[["slide_roll_ratio", "traction_coefficient"]].abs().to_numpy().T
            rows_of_curves.append((oil_name, run_id, _error_of_curve(slip, mu)))
    errors = pd.DataFrame(rows_of_curves, columns=["oil", "run_id", "error"])
    error_by_curve = errors.set_index(["oil", "run_id"])["error"].astype(float)
    return error_by_curve.clip(upper=_LARGEST_RELATIVE_ERROR)


def _error_of_curve(slip: FloatArray, mu: FloatArray) -> float:
    """The largest relative standard error of |A|, B and C of Eq. 7, fitted to one curve.

    The fit is in logarithms of the three, so that they keep their signs. It starts from the largest
    traction and from several shares of the slope at the first clear slip. From some starts it ends
    where a constant has no effect, far above the optimum.
    """
    largest_mu = mu.max()
    # at almost no slip mu is its own error, and the slope would be any number
    is_clear = slip >= _CLEAR_SLIP * slip.max()
    slope = (mu[is_clear] / slip[is_clear]).max()

    def residual(logarithms: FloatArray) -> FloatArray:
        with np.errstate(over="ignore", invalid="ignore"):
            return DENG2026.mu_of_sizes(np.exp(logarithms)[:, np.newaxis], slip) - mu

    starts = [
        np.log([largest_mu, share * slope, (1 - share) * slope / largest_mu])
        for share in _SHARES_OF_SLOPE
    ]
    fits = [
        least_squares(
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
    variance = 2 * fit.cost / (len(slip) - _COEFFICIENT_COUNT_OF_CURVE)
    with np.errstate(divide="ignore", invalid="ignore"):
        inverse_diagonal = ((directions / singular_values[:, np.newaxis]) ** 2).sum(axis=0)
    return float(np.sqrt(variance * np.nan_to_num(inverse_diagonal, nan=np.inf).max()))


def _only_cases(outcome_on_grid: Outcome, is_selected: BoolArray, reason: str) -> Outcome:
    """An outcome with the cases that a claim is about.

    Args:
        outcome_on_grid: The outcome over the grid.
        is_selected: Whether the claim is about a case.
        reason: Code of the reason where it is about none.

    Raises:
        NotCheckableError: There are none.
    """
    if not is_selected.any():
        raise NotCheckableError(reason)
    return replace(outcome_on_grid, cases=outcome_on_grid.cases[is_selected.ravel()])


def _by_paper_law(view: View) -> pd.DataFrame:
    """Fits of the paper's law.

    Raises:
        NotCheckableError: There is no fit at all.
    """
    fits = view.rows("fit_quality", reason="no fit by the paper's law")
    return fits[fits["law"] == view.study.audit.stress_law]


def _relative_left_out(fits: pd.DataFrame) -> "pd.Series[float]":
    """The rms error at curves left out, relative to mu."""
    return fits["left_out_rmse"] * fits["relative_rms"] / fits["rmse"]


def _wang_deng(view: View) -> pd.DataFrame:
    """Fits of all versions of the Wang-Deng law.

    Raises:
        NotCheckableError: There are none, or the data were simulated with the paper's law.
    """
    fits = view.rows("fit_quality", reason="no comparison")
    if view.truth_is_law:
        raise NotCheckableError("tie")
    fits = fits[fits["law"].str.startswith("wang")].dropna(subset="rmse")
    if fits.empty:
        raise NotCheckableError("no comparison")
    return fits


def _torque_errors(view: View) -> tuple[pd.DataFrame, dict[str, float]]:
    """Relative errors by load variable, and how many points are left out as bistable.

    The cage may roll or skid there. Points at which that is not known are counted, too.
    """
    torque_rows = view.rows("torque", reason="no torque")
    for control_verdict in ("two truths", "positive control"):
        if (view.measured.torque_control["verdict"] == control_verdict).any():
            raise NotCheckableError(control_verdict)
    plateau_and_oil = ["run_id", "first_row", "oil"]
    certain_rows = without_bistable(torque_rows).set_index([*plateau_and_oil, "load_variable"])
    errors = certain_rows["relative_error"].abs().unstack(sort=False)
    errors = errors.reindex(columns=["stress", "load"]).reset_index()
    if errors["stress"].isna().all():
        raise NotCheckableError("no torque by the law")
    bistable_count = len(torque_rows[is_bistable(torque_rows)].drop_duplicates(plateau_and_oil[:2]))
    count_by_number_name = {
        "bistable": bistable_count,
        "undecided": undecided_plateaus(torque_rows),
    }
    return errors, {name: float(count) for name, count in count_by_number_name.items() if count}
