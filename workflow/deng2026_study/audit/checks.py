"""One check for each claim of the paper: the function with the name of the claim.

A check takes the evidence over a box of operating conditions and returns the verdict in every case,
with numbers that explain it; reference/claims.yaml says in words what is checked and what the
numbers are. Arrays have the axes oil, P, U, T, S, of length 1 where a case spans an axis.

Decides: when a claim of the paper holds.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pandas as pd

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
from oilfilm.torque.best_oil import OPERATING_POINT
from oilfilm.torque.torque_control import is_bistable, undecided_plateaus, without_bistable
from oilfilm.traction.law import Law

_P, _U, _T, _S = 1, 2, 3, 4  # axes of the arrays
_GAMMAS = (0.0, 0.1, 0.2, 0.3)  # D cos(alpha)/dm of ball bearings
# Sizes of each coefficient that stand for all that a law allows.
_SIZES = 6
_ROUNDING = 1e-15
# Deng et al. (2026), section 2.1: Ra of ball and disc, and what they are said to make together.
_RA_UM = (0.014, 0.010)
_COMPOSITE_UM = 0.017


def zero_slip(view: View) -> Outcome:
    """Without slip there is no traction."""
    still = view.at(slide_roll_ratio=[0.0])
    mu = np.abs(still.mu())
    always = of_equation(view, lambda law: _any_constants(law, np.zeros(1)) == 0)
    found = still.outcome(mu <= view.study.audit.zero_traction_max, mu)
    return replace(found, by_construction=always)


def non_negative(view: View) -> Outcome:
    """Mu is never negative."""
    curves = view.mu(slide_roll_ratio=view.curve[1:])
    mu, size = curves.min(axis=_S, keepdims=True), np.abs(curves).max(axis=_S, keepdims=True)
    always = of_equation(view, lambda law: _any_constants(law, view.curve) >= 0)
    return replace(view.outcome(reaches(mu, 0.0, size), mu), by_construction=always)


def linear_start(view: View) -> Outcome:
    """Mu begins as a straight line."""
    end, to_slip = _linear_range(view), view.study.audit.linear_to_slip
    start = np.linspace(0.0, to_slip, view.study.audit.levels)
    straight = _straight(view, start, view.mu(slide_roll_ratio=start), _S)[0]
    return view.outcome(straight, end, within=reaches(end, to_slip), longest=np.nanmax(end))


def peak_decline(view: View) -> Outcome:
    """Mu peaks, then declines slightly."""
    mu = view.mu(slide_roll_ratio=view.curve)
    peak = mu.max(axis=_S, keepdims=True)
    # a law that comes to a constant level reaches it within rounding, and has no peak
    peaks, decline = exceeds(peak, mu[..., -1:]), 1 - mu[..., -1:] / peak
    slight = reaches(view.study.printed.signs.decline_max, decline, size=1.0)
    shown = [oil == view.falling_viscosity[0] for oil in view.laws]
    coldest = decline[:, :, :, 0]
    return view.outcome(
        peaks & slight,
        decline,
        shown_oil=(peaks & slight)[shown],
        peaks=peaks,
        slight=slight,
        coldest_least=view.by_oil(np.nanmin, coldest),
        coldest_most=view.by_oil(np.nanmax, coldest),
    )


def falls_with_temperature(view: View) -> Outcome:
    """Mu falls with T, more steeply where it is cold."""
    audit, mu = view.study.audit, view.mu()
    bands = np.clip([audit.cold_band_c, audit.hot_band_c], *_ends(view.grid.inlet_temperature_c))
    cold, hot = (
        -np.diff(view.mu(inlet_temperature_c=band), axis=_T) / np.diff(band) for band in bands
    )
    rounding_of = np.abs(mu).max() / min(np.diff(band)[0] for band in bands)
    always, steeper = _falls(mu, _T), exceeds(cold, hot, size=rounding_of)
    return view.outcome(always & steeper, _ratio(mu, _T), always=always, steeper=steeper)


def falls_with_speed(view: View) -> Outcome:
    """Mu falls with U and levels off."""
    mu, thirds = view.mu(), np.linspace(*_ends(view.grid.entrainment_speed_m_s), 4)
    fall = -np.diff(view.mu(entrainment_speed_m_s=thirds), axis=_U)
    levels_off = exceeds(fall[:, :, :1], np.abs(fall[:, :, 2:]), size=np.abs(mu).max())
    always = _falls(mu, _U)
    return view.outcome(always & levels_off, _ratio(mu, _U), always=always, levels_off=levels_off)


def rises_with_stress(view: View) -> Outcome:
    """Mu rises with P, about linearly."""
    pressure = view.grid.max_hertz_pressure_gpa
    even = np.linspace(*_ends(pressure), len(pressure))
    mu = view.mu(max_hertz_pressure_gpa=even)
    always, (straight, r2) = _falls(-mu, _P), _straight(view, even, mu, _P)
    median = view.by_oil(np.nanmedian, r2)
    return view.outcome(always & straight, r2, always=always, straight=straight, median_r2=median)


def rises_with_slip(view: View) -> Outcome:
    """The level of mu rises with S."""
    tested = view.study.printed.boxes.tested.max_hertz_pressure_gpa
    shown = view.at(max_hertz_pressure_gpa=tested[1:])
    mu = shown.mu()
    level = _falls(-mu.mean(axis=(_U, _T), keepdims=True), _S)
    ends = exceeds(mu[..., -1], mu[..., 0])
    return shown.outcome(_falls(-mu, _S), _ratio(mu, _S), level=level, ends=ends)


def similar_limit(view: View) -> Outcome:
    """Mu approaches a plateau, alike for all oils."""
    end = view.curve[-1]
    mu = view.mu_by_viscosity(slide_roll_ratio=[view.grid.slide_roll_ratio[0], end * 2 / 3, end])
    change = np.abs(mu[..., 2:] / mu[..., 1:2] - 1).max(axis=0, keepdims=True)
    apart = np.ptp(mu, axis=0) / mu.mean(axis=0)
    return view.outcome(
        reaches(1 - view.study.audit.plateau_share, change, size=1.0),
        change,
        closer=exceeds(apart[..., 0], apart[..., 2], size=1.0),
        apart_at_start=apart[..., 0].mean(),
        apart_at_end=apart[..., 2].mean(),
    )


def earlier_plateau(view: View) -> Outcome:
    """A higher P leaves the linear range earlier."""
    end = _linear_range(view)
    ends_c = _ends(view.grid.inlet_temperature_c)
    mu = view.mu(inlet_temperature_c=ends_c, slide_roll_ratio=view.curve)
    reached = reaches(mu, view.study.audit.plateau_share * mu.max(axis=_S, keepdims=True))
    begin = view.curve[np.argmax(reached, axis=_S)]
    coldest, hottest = (view.by_oil(np.median, begin[..., at]) for at in (0, 1))
    plateaus = {"plateau_coldest": coldest, "plateau_hottest": hottest}
    return view.outcome(_falls(end, _P), _ratio(end, _P), **plateaus)


def viscosity_order(view: View) -> Outcome:
    """Mu falls from each oil to the next less viscous one."""
    oils, mu = view.falling_viscosity, view.mu_by_viscosity()
    ratios = mu[:-1] / mu[1:]
    smallest = ratios.min(axis=0, keepdims=True)
    ranks = _ranks(mu.reshape(len(oils), -1)).T
    kinds, counts = np.unique(ranks, axis=0, return_counts=True)
    commonest = zip(oils, kinds[counts.argmax()], strict=True)
    # all conditions at one pressure have one number: their geometric mean, as ratios need
    lightest, heaviest = np.exp(np.log(mu[-1] / mu[0]).mean(axis=(1, 2, 3)))[[0, -1]]
    numbers: dict[str, Any] = {}
    first = exceeds(ratios[0], 1.0).mean(axis=(1, 2, 3))
    if first[0] < 0.5 < first[-1] and (np.diff(first) >= 0).all():
        numbers["turn_gpa"] = np.interp(0.5, first, view.grid.max_hertz_pressure_gpa)
    return view.outcome(
        exceeds(smallest, 1.0),
        smallest,
        above_next={oil: exceeds(pair, 1.0) for oil, pair in zip(oils[:-1], ratios, strict=True)},
        commonest_share=counts.max() / len(ranks),
        commonest_rank=dict(sorted(commonest, key=lambda oil_and_rank: oil_and_rank[1])),
        thin_over_thick_lightest=lightest,
        thin_over_thick_heaviest=heaviest,
        **numbers,
    )


def hot_convergence(view: View) -> Outcome:
    """The oils come nearer to one another as they warm."""
    mu = view.mu_by_viscosity(inlet_temperature_c=_ends(view.grid.inlet_temperature_c))
    spread = np.ptp(mu, axis=0, keepdims=True)
    relative = spread / mu.mean(axis=0, keepdims=True)
    coldest, hottest = relative.mean(axis=(0, 1, 2, 4))
    return view.outcome(
        _falls(spread, _T),
        _ratio(spread, _T),
        relative=_falls(relative, _T),
        spread_coldest=coldest,
        spread_hottest=hottest,
    )


def speed_mutes_temperature(view: View) -> Outcome:
    """T changes mu less at a high speed."""
    speeds = np.clip(view.study.audit.slow_and_fast_m_s, *_ends(view.grid.entrainment_speed_m_s))
    ends_c = _ends(view.grid.inlet_temperature_c)
    mu = view.mu(entrainment_speed_m_s=speeds, inlet_temperature_c=ends_c)
    drop = -np.diff(mu, axis=_T)
    ratio = _ratio(drop, _U)
    holds, relative = exceeds(1.0, ratio), _falls(drop / mu[:, :, :, :1], _U)
    return view.outcome(holds, ratio, relative=relative)


def full_film(view: View) -> Outcome:
    """Film and lambda are above what a full film needs."""
    oils = view.falling_viscosity
    film_min_um = view.study.audit.film_min_um
    limits = np.array([film_min_um, view.settings.gates.lambda_limit])
    figures = view.study.printed.signs.slide_roll_ratio.figures
    curve = view.at(slide_roll_ratio=[0.0, *figures, view.curve[-1]])
    points = view.measured.points.dropna(subset=["lambda_ratio"])
    if view.basis == "printed" or view.measured.points.empty:
        films = curve.films(*oils)
        margins = films / limits.reshape(2, 1, 1, 1, 1, 1)
        smaller = margins.min(axis=0)
        judged = curve.cases(oils, exceeds(smaller, 1.0), smaller)
    elif points.empty:
        raise NotCheckableError("no lambda")
    else:
        films = points[["film_thickness_um", "lambda_ratio"]].to_numpy().T
        margins = films / limits.reshape(2, 1)
        judged = points.assign(value=margins.min(axis=0))
        judged["holds"] = exceeds(judged["value"], 1.0)
    thinnest, smallest = (np.nanmin(film) for film in films)
    central = curve.films(thickness="central")[0] / film_min_um
    thick, full, central = (exceeds(each, 1.0)[~np.isnan(each)] for each in (*margins, central))
    unknown = judged["value"].isna().sum()
    return outcome(
        # where the formula gives no film the claim is neither true nor false
        judged.dropna(subset="value"),
        central=central,
        full=full,
        thick=thick,
        smallest_lambda=smallest,
        thinnest_um=thinnest,
        unknown=unknown or np.nan,
    )


def wang_deng_zero(view: View) -> Outcome:
    """The Wang-Deng law has traction without slip."""
    fits = _wang_deng(view)
    mu = fits["zero_slip_traction"].abs()
    holds = mu > view.study.audit.zero_traction_max
    return outcome(fits.assign(holds=holds, value=mu), largest=mu.max())


def wang_deng_overfit(view: View) -> Outcome:
    """The errors of the Wang-Deng law grow more on curves left out."""
    audit, fits = view.study.audit, _wang_deng(view)
    every = view.measured.fit_quality
    own = every[every["law"] == audit.stress_law].set_index("oil")
    if not set(fits["oil"]) <= set(own.index):
        raise NotCheckableError("no fit by the paper's law")
    growth = fits["left_out_rmse"] / fits["rmse"]
    relative = growth / fits["oil"].map(own["left_out_rmse"] / own["rmse"])
    return outcome(fits.assign(holds=exceeds(relative, audit.overfit_min), value=relative))


def torque_stress(view: View) -> Outcome:
    """The law of pressure gives the torque of a bearing."""
    rows, further = _torque(view)
    rows = rows.dropna(subset="stress")
    holds = reaches(view.study.audit.torque_stress_error, rows["stress"])
    judged = rows.assign(holds=holds, value=rows["stress"])
    return outcome(judged, largest=rows["stress"].max(), **further)


def torque_load(view: View) -> Outcome:
    """The law of load does not."""
    rows, further = _torque(view)
    both = rows.dropna()
    if both.empty:
        raise NotCheckableError("no torque by the law")
    excess, largest = both["load"] - both["stress"], both["load"].max()
    farther = exceeds(both["load"], both["stress"], size=1.0)
    found = outcome(both.assign(holds=farther, value=excess), largest=largest, **further)
    return replace(found, complete=bool(reaches(largest, view.study.audit.torque_load_error)))


def uniquely_determined(view: View) -> Outcome:
    """The data determine the constants."""
    fits = _by_paper_law(view).dropna(subset="constant_spread")
    if fits.empty:
        raise NotCheckableError("no fit by the paper's law")
    constants = view.measured.coefficients
    of_law = constants["law"] == view.study.audit.stress_law
    known = constants[of_law & constants["oil"].isin(fits["oil"])]["verdict"].eq("known")
    # digits below a millionth of a standard error are rounding
    spread = fits["constant_spread"].round(6)
    judged = fits[["oil"]].assign(holds=fits["certified"], value=spread)
    return outcome(judged, known=known.to_numpy())


def genetic_optimum(view: View) -> Outcome:
    """The genetic algorithm finds the optimum: the paper does not state its constants' errors."""
    raise NotCheckableError("not stated")


def extrapolates(view: View) -> Outcome:
    """The law predicts beyond the tested conditions."""
    limit, fits = view.study.audit.prediction_error, _by_paper_law(view)
    if view.truth_is_law:
        raise NotCheckableError("own law")
    ends = fits.filter(regex="^oil$|_end_out_relative_rms$").melt("oil").dropna()
    if ends.empty:
        raise NotCheckableError("no fit by the paper's law")
    left_out = fits["left_out_rmse"] * fits["relative_rms"] / fits["rmse"]
    truth = view.measured.extrapolation
    own = (truth["law"] == view.study.audit.stress_law) & truth["oil"].isin(fits["oil"])
    truth = truth[own & (truth["beyond"].map(len) > 0)]
    error = (truth["traction_coefficient"] / truth["true_traction_coefficient"] - 1).abs()
    return outcome(
        ends.assign(holds=reaches(limit, ends["value"])),
        truth=reaches(limit, error),
        accuracy=reaches(limit, left_out),
        left_out=left_out.max(),
    )


def composite_roughness(view: View) -> Outcome:
    """The roughness of ball and disc make the stated one."""
    composite = float(np.hypot(*_RA_UM))
    judged = pd.DataFrame({"oil": [""], "holds": composite < _COMPOSITE_UM, "value": composite})
    return outcome(judged, rounded=round(composite, 3) <= _COMPOSITE_UM)


def rolling_speed(view: View) -> Outcome:
    """The stated dmN has the stated entrainment speed."""
    stated, tolerance = view.study.selection.stated, view.study.audit.kinematic_tolerance
    pitch_speed, speed = stated.pitch_speed_mm_rpm, stated.entrainment_speed_m_s
    rolling = np.array([entrainment_speed_m_s(pitch_speed, gamma) for gamma in _GAMMAS])
    surface, near = surface_speed_m_s(pitch_speed), _near_one(rolling / speed, tolerance)
    return outcome(
        pd.DataFrame({"oil": "", "holds": near, "value": rolling}),
        as_surface=_near_one(surface / speed, tolerance),
        highest=rolling.max(),
        surface_speed=surface,
        pitch_speed=pitch_speed_mm_rpm(speed),
    )


def slip_is_cage_slip(view: View) -> Outcome:
    """The slide-roll ratio of a bearing is its cage slip."""
    choice, slip = view.study.selection, np.linspace(0.05, 0.4, 8)
    ratio = np.concatenate([inner_slide_roll_ratio(slip, gamma) / slip for gamma in _GAMMAS])
    tolerance, limit = view.study.audit.kinematic_tolerance, choice.limits.slip_limit
    near, of_both = (_near_one(each, tolerance) for each in (ratio, ratio / 2))
    return outcome(
        pd.DataFrame({"oil": "", "holds": near, "value": ratio}),
        both_races=of_both,
        smallest=ratio.min(),
        at_limit=inner_slide_roll_ratio(limit, choice.gamma),
        cage_slip=cage_slip(limit, choice.gamma),
    )


def light_load_4102(view: View) -> Outcome:
    """Under light load 4102 has the most traction."""
    choice = view.study.selection
    light = _within(_to_the_end(view), above=-np.inf, below=choice.limits.light_below_gpa)
    mu, grid = light.mu_by_viscosity(), light.grid
    ratio = mu[:1] / mu[1:].max(axis=0, keepdims=True)
    hot = reaches(grid.inlet_temperature_c, choice.limits.hot_from_c)
    fast = reaches(grid.entrainment_speed_m_s, choice.fast_from_m_s)
    slipping = exceeds(grid.slide_roll_ratio, choice.slide_roll_ratio_limit)
    corner = ratio[:, :, fast][:, :, :, hot][..., slipping]
    higher = exceeds(mu[:-1].min(axis=0), mu[-1])
    most, there = exceeds(ratio, 1.0), exceeds(corner, 1.0)
    return light.outcome(most, ratio, higher_viscosity=higher, hot_and_fast=there)


def slip_15(view: View) -> Outcome:
    """Up to 15 % cage slip the thinnest oil has the least traction, beyond it the thickest most."""
    view, choice = _to_the_end(view), view.study.selection
    mu, adequate = view.mu_by_viscosity(), _thinnest_is_adequate(view)
    slipping = exceeds(view.grid.slide_roll_ratio, choice.slide_roll_ratio_limit)
    # S taken for the cage slip, as section 4.3 does
    as_slip = exceeds(view.grid.slide_roll_ratio, choice.limits.slip_limit)
    least, ordered = mu[-1:] / mu[:-1].min(axis=0, keepdims=True), mu[1:] / mu[:-1]
    value, by_slip = (
        np.where(beyond, ordered.max(axis=0, keepdims=True), least)
        for beyond in (slipping, as_slip)
    )
    found = view.outcome(
        exceeds(1.0, value),
        value,
        as_cage_slip=exceeds(1.0, by_slip[as_slip | adequate]),
        more_than_thinnest=exceeds(1.0, ordered[1][..., slipping]),
        below=exceeds(1.0, value[..., ~slipping][adequate[..., ~slipping]]),
        beyond=exceeds(1.0, value[..., slipping]),
        adequate=adequate,
    )
    return _where(found, slipping | adequate, "no condition")


def heavy_load_4010(view: View) -> Outcome:
    """Under heavy load with enough film 4010 has the least traction."""
    heavy = _within(view, above=view.study.selection.limits.heavy_from_gpa, below=np.inf)
    mu, adequate = heavy.mu_by_viscosity(), _thinnest_is_adequate(heavy)
    ratio = mu[-1:] / mu[:-1].min(axis=0, keepdims=True)
    least = heavy.outcome(exceeds(1.0, ratio), ratio, adequate=adequate)
    found = _where(least, adequate, "no film")
    in_bearing = _least_torque_of_thinnest(view)
    bearing = {"bearing": in_bearing.mean(), "bearing_points": float(len(in_bearing))}
    return replace(found, numbers=found.numbers | bearing)


def of_equation(view: View, holds: Callable[[Law], BoolArray]) -> bool:
    """Whether something is true of every law, whatever its constants."""
    laws = {fitted.law.name: fitted.law for fitted in view.laws.values()}
    return all(holds(law).all() for law in laws.values())


def _any_constants(law: Law, slip: FloatArray) -> FloatArray:
    """mu at slips by coefficients over all their bounds, each size with each; rounding is 0."""
    levels = [np.geomspace(each.smallest, each.largest, _SIZES) for each in law.coefficients]
    sizes = np.stack([size.ravel() for size in np.meshgrid(*levels)])[..., np.newaxis]
    with np.errstate(over="ignore", invalid="ignore"):
        mu = law.value(sizes, slip)
    return np.where(np.abs(mu) <= _ROUNDING * sizes.max(axis=0), 0.0, mu)


def _linear_range(view: View) -> FloatArray:
    """Slip at which mu/S has left its value at no slip by the tolerance; the last slip if never."""
    # the slope at no slip is that over a slip a thousand times below the first step of the curve
    curve, tolerance = view.curve, view.study.audit.linear_tolerance
    slip = np.concatenate([[curve[1] * 1e-3], curve[1:]])
    chord = view.mu(slide_roll_ratio=slip) / slip
    left = np.abs(chord / chord[..., :1] - 1)
    beyond = (left > tolerance).any(axis=_S, keepdims=True)
    after = np.where(beyond, np.argmax(left > tolerance, axis=_S)[..., np.newaxis], len(slip) - 1)
    # between the last slip inside and the first outside, in a straight line
    inside, outside = (np.take_along_axis(left, at, axis=_S) for at in (after - 1, after))
    rises = np.where(outside > inside, outside - inside, 1.0)
    way = np.where(outside > inside, (tolerance - inside) / rises, 1.0)
    return np.where(beyond, slip[after - 1] + way * (slip[after] - slip[after - 1]), slip[-1])


def _ends(levels: FloatArray) -> tuple[float, float]:
    return float(levels[0]), float(levels[-1])


def _falls(values: FloatArray, axis: int) -> BoolArray:
    """Whether values fall at every step along an axis, which is kept with length 1."""
    levels = np.moveaxis(values, axis, 0)
    falls: BoolArray = np.asarray(exceeds(levels[:-1], levels[1:]).all(axis=0, keepdims=True))
    return np.moveaxis(falls, 0, axis)


def _ranks(values: FloatArray) -> IndexArray:
    """Rank of each row among the rows, 1 for the largest, shape (rows, n); of equals by the row."""
    above = exceeds(values[:, np.newaxis], values)
    before = np.triu(np.ones((len(values), len(values)), dtype=bool), k=1)[..., np.newaxis]
    ahead = above | (before & ~above.swapaxes(0, 1))
    return np.asarray(1 + ahead.sum(axis=0))


def _near_one(ratio: FloatArray | float, tolerance: float) -> BoolArray:
    return reaches(tolerance, np.abs(np.asarray(ratio) - 1), size=1.0)


def _ratio(values: FloatArray, axis: int) -> FloatArray:
    """The last value along an axis over the first one."""
    return np.take(values, [-1], axis=axis) / np.take(values, [0], axis=axis)


def _straight(
    view: View, abscissa: FloatArray, values: FloatArray, axis: int
) -> tuple[BoolArray, FloatArray]:
    """Whether values along one axis are on a straight line, and the line's R2."""
    x = np.expand_dims(abscissa - abscissa.mean(), [at for at in range(values.ndim) if at != axis])
    y = values - values.mean(axis=axis, keepdims=True)
    joint = (x * y).sum(axis=axis, keepdims=True)
    r2 = joint**2 / ((x**2).sum() * (y**2).sum(axis=axis, keepdims=True))
    return r2 >= view.study.printed.signs.linear_r2_min, r2


def _to_the_end(view: View) -> View:
    """The grid with the largest tested slip as well, where the limit of cage slip lies."""
    return view.at(slide_roll_ratio=np.union1d(view.grid.slide_roll_ratio, view.curve[-1]))


def _within(view: View, *, above: float, below: float) -> View:
    """The grid with as many levels of pressure in [above, below) only.

    Raises:
        NotCheckableError: There are none.
    """
    pressure = view.grid.max_hertz_pressure_gpa
    low, high = max(above, pressure[0]), min(below, pressure[-1])
    if low >= high:
        raise NotCheckableError("no condition")
    inside = np.geomspace(low, high, len(pressure))
    return view.at(max_hertz_pressure_gpa=inside[exceeds(below, inside)])


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
    slips, oils = view.measured.cage_slip, list(view.falling_viscosity)
    slips = slips[slips["oil"].isin(oils)]
    known = slips["lambda_ratio"].notna().groupby([slips[name] for name in OPERATING_POINT])
    slips = slips[known.transform("all")]
    pressure = slips[["inner_max_hertz_pressure_gpa", "outer_max_hertz_pressure_gpa"]].max(axis=1)
    heavy = reaches(pressure, view.study.printed.boxes.tested.max_hertz_pressure_gpa[1])
    full = exceeds(slips["lambda_ratio"], view.settings.gates.lambda_limit)
    slips = slips[full & heavy]
    torque = slips.pivot(index=OPERATING_POINT, columns="oil", values="torque_n_m")
    torque = torque.reindex(columns=oils).dropna(subset=[oils[-1]])
    if torque.empty:
        raise NotCheckableError("no bearing")
    return reaches(torque.min(axis=1), torque[oils[-1]])


def _where(found: Outcome, asked: BoolArray, reason: str) -> Outcome:
    """The cases that a claim is about.

    Raises:
        NotCheckableError: There are none.
    """
    if not asked.any():
        raise NotCheckableError(reason)
    return replace(found, cases=found.cases[asked.ravel()])


def _by_paper_law(view: View) -> pd.DataFrame:
    fits = view.rows("fit_quality", reason="no fit by the paper's law")
    return fits[fits["law"] == view.study.audit.stress_law]


def _wang_deng(view: View) -> pd.DataFrame:
    fits = view.rows("fit_quality", reason="no comparison")
    if view.truth_is_law:
        raise NotCheckableError("tie")
    fits = fits[fits["law"].str.startswith("wang")].dropna(subset="rmse")
    if fits.empty:
        raise NotCheckableError("no comparison")
    return fits


def _torque(view: View) -> tuple[pd.DataFrame, dict[str, float]]:
    """Relative errors by load variable, and how many points are left out as bistable.

    The cage may roll or skid there. Points at which that is not known are counted, too.
    """
    rows = view.rows("torque", reason="no torque")
    for verdict in ("two truths", "positive control"):
        if (view.measured.torque_control["verdict"] == verdict).any():
            raise NotCheckableError(verdict)
    point = ["run_id", "first_row", "oil"]
    sure = without_bistable(rows).set_index([*point, "load_variable"])["relative_error"].abs()
    errors = sure.unstack(sort=False).reindex(columns=["stress", "load"]).reset_index()
    if errors["stress"].isna().all():
        raise NotCheckableError("no torque by the law")
    left_out = len(rows[is_bistable(rows)].drop_duplicates(point[:2]))
    counts = {"bistable": left_out, "undecided": undecided_plateaus(rows)}
    return errors, {name: float(count) for name, count in counts.items() if count}
