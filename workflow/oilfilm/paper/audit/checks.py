"""One check for each claim of the paper, by the claim's id.

A check takes the evidence over a box of operating conditions and returns the verdict in every case,
with numbers that explain it; data/reference/claims.yaml says in words what is checked and what the
numbers are. Arrays have the axes oil, P, U, T, S, of length 1 where a case spans an axis.

Decides: when a claim of the paper holds.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from oilfilm.bearing.kinematics import (
    cage_slip,
    entrainment_speed_m_s,
    inner_slide_roll_ratio,
    pitch_speed_mm_rpm,
    surface_speed_m_s,
)
from oilfilm.paper.audit.evidence import (
    Evidence,
    NotCheckableError,
    Numbers,
    Outcome,
    View,
    Worst,
    cases,
    shares,
)
from oilfilm.torque.best_oil import OPERATING_POINT
from oilfilm.torque.torque_control import without_bistable
from oilfilm.traction.law import Law
from oilfilm.units import BoolArray, FloatArray

_P, _U, _T, _S = 1, 2, 3, 4  # axes of the arrays
_GAMMAS = (0.0, 0.1, 0.2, 0.3)  # D cos(alpha)/dm of ball bearings
# Sizes of each coefficient that stand for all that a law allows.
_SIZES = 6
_ROUNDING = 1e-15
# Deng et al. (2026), section 2.1: Ra of ball and disc, and what they are said to make together.
_RA_UM = (0.014, 0.010)
_COMPOSITE_UM = 0.017
Judge = Callable[[View], Outcome]


@dataclass(frozen=True)
class Check:
    """How a claim is checked.

    Attributes:
        judge: Finds the cases.
        worst: Which value is the worst.
        where: Box on which the verdict rests, `tested` or `extrapolated`; `data` where the check
            looks at tables, `formula` where it looks at the paper's Eq. 1, and at no box.
    """

    judge: Judge
    worst: Worst
    where: str


CHECKS: dict[str, Check] = {}


def _check(claim: str, *, worst: Worst, where: str = "extrapolated") -> Callable[[Judge], Judge]:
    """Registers the check of a claim (see `Check`)."""

    def register(judge: Judge) -> Judge:
        CHECKS[claim] = Check(judge, worst, where)
        return judge

    return register


@_check("zero-slip", worst="largest")
def _zero_slip(view: View) -> Outcome:
    still = view.at(slide_roll_ratio=[0.0])
    mu = np.abs(still.mu())
    outcome = still.outcome(mu <= view.settings.audit.zero_traction_max, mu)
    always = _of_equation(view.evidence, lambda law: _any_constants(law, np.zeros(1)) == 0)
    return replace(outcome, by_construction=always)


@_check("non-negative", worst="smallest")
def _non_negative(view: View) -> Outcome:
    mu = view.mu(slide_roll_ratio=view.curve[1:]).min(axis=_S, keepdims=True)
    always = _of_equation(view.evidence, lambda law: _any_constants(law, view.curve) >= 0)
    return replace(view.outcome(mu >= 0, mu), by_construction=always)


@_check("linear-start", worst="smallest", where="tested")
def _linear_start(view: View) -> Outcome:
    end, to_slip = _linear_range(view), view.settings.audit.linear_to_slip
    start = np.linspace(0.0, to_slip, view.settings.audit.levels)
    r2 = _r_squared(start, view.mu(slide_roll_ratio=start), _S)
    straight = r2 >= view.settings.printed.signs.linear_r2_min
    return view.outcome(straight, end, within=end >= to_slip, longest=np.nanmax(end))


@_check("peak-decline", worst="largest", where="tested")
def _peak_decline(view: View) -> Outcome:
    mu = view.mu(slide_roll_ratio=view.curve)
    peaks = np.argmax(mu, axis=_S, keepdims=True) < len(view.curve) - 1
    decline = 1 - mu[..., -1:] / mu.max(axis=_S, keepdims=True)
    slight = decline <= view.settings.printed.signs.decline_max
    return view.outcome(
        peaks & slight,
        decline,
        shown_oil=view.of_most_viscous(peaks & slight),
        peaks=peaks,
        slight=slight,
        coldest_least=view.by_oil(np.nanmin, decline[:, :, :, 0]),
        coldest_most=view.by_oil(np.nanmax, decline[:, :, :, 0]),
    )


@_check("falls-with-temperature", worst="largest")
def _falls_with_temperature(view: View) -> Outcome:
    audit, mu = view.settings.audit, view.mu()
    low, high = view.grid.inlet_temperature_c[[0, -1]]
    bands = np.clip([audit.cold_band_c, audit.hot_band_c], low, high)
    at_cold, at_hot = (
        -np.diff(view.mu(inlet_temperature_c=band), axis=_T) / np.diff(band) for band in bands
    )
    always, steeper = _falls(mu, _T), at_cold > at_hot
    value = _last_over_first(mu, _T)
    return view.outcome(always & steeper, value, always=always, steeper=steeper)


@_check("falls-with-speed", worst="largest")
def _falls_with_speed(view: View) -> Outcome:
    mu = view.mu()
    low, high = view.grid.entrainment_speed_m_s[[0, -1]]
    fall = -np.diff(view.mu(entrainment_speed_m_s=np.linspace(low, high, 4)), axis=_U)
    always, levels_off = _falls(mu, _U), np.abs(fall[:, :, 2:]) < fall[:, :, :1]
    value = _last_over_first(mu, _U)
    return view.outcome(always & levels_off, value, always=always, levels_off=levels_off)


@_check("rises-with-stress", worst="smallest")
def _rises_with_stress(view: View) -> Outcome:
    pressure = view.grid.max_hertz_pressure_gpa
    even = np.linspace(pressure[0], pressure[-1], len(pressure))
    mu = view.mu(max_hertz_pressure_gpa=even)
    r2 = _r_squared(even, mu, _P)
    always, straight = _falls(-mu, _P), r2 >= view.settings.printed.signs.linear_r2_min
    median = view.by_oil(np.nanmedian, r2)
    return view.outcome(always & straight, r2, always=always, straight=straight, median_r2=median)


@_check("rises-with-slip", worst="smallest")
def _rises_with_slip(view: View) -> Outcome:
    tested = view.settings.printed.boxes.tested.max_hertz_pressure_gpa
    shown = view.at(max_hertz_pressure_gpa=tested[1:])
    mu = shown.mu()
    level = mu.mean(axis=(_U, _T), keepdims=True)
    return shown.outcome(
        _falls(-mu, _S),
        _last_over_first(mu, _S),
        level=_falls(-level, _S),
        ends=mu[..., -1] > mu[..., 0],
    )


@_check("similar-limit", worst="largest")
def _similar_limit(view: View) -> Outcome:
    end = view.curve[-1]
    mu = view.mu_by_viscosity(slide_roll_ratio=[view.grid.slide_roll_ratio[0], end * 2 / 3, end])
    change = np.abs(mu[..., 2:] / mu[..., 1:2] - 1).max(axis=0, keepdims=True)
    relative = np.ptp(mu, axis=0) / mu.mean(axis=0)
    return view.outcome(
        change <= 1 - view.settings.audit.plateau_share,
        change,
        closer=relative[..., 2] < relative[..., 0],
        apart_at_start=relative[..., 0].mean(),
        apart_at_end=relative[..., 2].mean(),
    )


@_check("earlier-plateau", worst="largest")
def _earlier_plateau(view: View) -> Outcome:
    end, ends_c = _linear_range(view), view.grid.inlet_temperature_c[[0, -1]]
    mu = view.mu(inlet_temperature_c=ends_c, slide_roll_ratio=view.curve)
    reached = mu >= view.settings.audit.plateau_share * mu.max(axis=_S, keepdims=True)
    begin = view.curve[np.argmax(reached, axis=_S)]
    return view.outcome(
        _falls(end, _P),
        _last_over_first(end, _P),
        plateau_coldest=view.by_oil(np.median, begin[..., 0]),
        plateau_hottest=view.by_oil(np.median, begin[..., 1]),
    )


@_check("viscosity-order", worst="smallest")
def _viscosity_order(view: View) -> Outcome:
    oils, mu = view.evidence.falling_viscosity, view.mu_by_viscosity()
    ratios = mu[:-1] / mu[1:]
    smallest = ratios.min(axis=0, keepdims=True)
    orders = np.argsort(-mu, axis=0).reshape(len(oils), -1).T
    kinds, counts = np.unique(orders, axis=0, return_counts=True)
    commonest = [oils[index] for index in kinds[counts.argmax()]]
    # all conditions at one pressure have one number: their geometric mean, as ratios need
    ends = np.exp(np.log(mu[-1] / mu[0]).mean(axis=(1, 2, 3)))[[0, -1]]
    outcome = view.outcome(
        smallest > 1,
        smallest,
        above_next=shares({oil: pair > 1 for oil, pair in zip(oils[:-1], ratios, strict=True)}),
        commonest_share=counts.max() / len(orders),
        commonest_rank={oil: float(rank) for rank, oil in enumerate(commonest, start=1)},
        thin_over_thick_lightest=ends[0],
        thin_over_thick_heaviest=ends[1],
    )
    first = (ratios[0] > 1).mean(axis=(1, 2, 3))
    if first[0] < 0.5 < first[-1] and (np.diff(first) >= 0).all():
        turn = np.interp(0.5, first, view.grid.max_hertz_pressure_gpa)
        outcome.numbers["turn_gpa"] = float(turn)
    return outcome


@_check("hot-convergence", worst="largest")
def _hot_convergence(view: View) -> Outcome:
    mu = view.mu_by_viscosity(inlet_temperature_c=view.grid.inlet_temperature_c[[0, -1]])
    spread = np.ptp(mu, axis=0, keepdims=True)
    relative = spread / mu.mean(axis=0, keepdims=True)
    coldest, hottest = relative.mean(axis=(0, 1, 2, 4))
    return view.outcome(
        _falls(spread, _T),
        _last_over_first(spread, _T),
        relative=_falls(relative, _T),
        spread_coldest=coldest,
        spread_hottest=hottest,
    )


@_check("speed-mutes-temperature", worst="largest")
def _speed_mutes_temperature(view: View) -> Outcome:
    slowest_and_fastest = view.grid.entrainment_speed_m_s[[0, -1]]
    mu = view.mu(
        entrainment_speed_m_s=np.clip(view.settings.audit.slow_and_fast_m_s, *slowest_and_fastest),
        inlet_temperature_c=view.grid.inlet_temperature_c[[0, -1]],
    )
    drop = -np.diff(mu, axis=_T)
    ratio = _last_over_first(drop, _U)
    return view.outcome(ratio < 1, ratio, relative=_falls(drop / mu[:, :, :, :1], _U))


@_check("full-film", worst="smallest", where="tested")
def _full_film(view: View) -> Outcome:
    evidence, settings = view.evidence, view.settings
    limits = settings.audit.film_min_um, evidence.lambda_limit
    if evidence.basis == "printed" or evidence.measured.points.empty:
        slips = [0.0, *settings.printed.signs.slide_roll_ratio.figures, view.curve[-1]]
        curve, oils = view.at(slide_roll_ratio=slips), evidence.falling_viscosity
        films = np.stack([curve.film(oil) for oil in oils], axis=1)
        margins = films / np.reshape(limits, (2, 1, 1, 1, 1, 1))
        judged = cases(curve.grid, oils, (margins > 1).all(axis=0), margins.min(axis=0))
    else:
        points = evidence.measured.points.dropna(subset=["lambda_ratio"])
        if points.empty:
            raise NotCheckableError("no lambda")
        films = points[["film_thickness_um", "lambda_ratio"]].to_numpy().T
        margins = films / np.reshape(limits, (2, 1))
        judged = points.assign(holds=(margins > 1).all(axis=0), value=margins.min(axis=0))
    thick, full = margins > 1
    thinnest, smallest = (np.nanmin(film) for film in films)
    central = view.central_film() / settings.audit.film_min_um > 1
    numbers = {"full": full, "thick": thick, "smallest_lambda": smallest, "thinnest_um": thinnest}
    return Outcome(judged, shares({"central": central} | numbers))


@_check("wang-deng-zero", worst="smallest", where="data")
def _wang_deng_zero(view: View) -> Outcome:
    fits = _wang_deng(view.evidence)
    mu = fits["zero_slip_traction"].abs()
    holds = mu > view.settings.audit.zero_traction_max
    return Outcome(fits.assign(holds=holds, value=mu), {"largest": mu.max()})


@_check("wang-deng-overfit", worst="smallest", where="data")
def _wang_deng_overfit(view: View) -> Outcome:
    audit, fits = view.settings.audit, _wang_deng(view.evidence)
    every = view.evidence.measured.fit_quality
    own = every[every["law"] == audit.stress_law].set_index("oil")
    if not set(fits["oil"]) <= set(own.index):
        raise NotCheckableError("no fit by the paper's law")
    growth = fits["left_out_rmse"] / fits["rmse"]
    relative = growth / fits["oil"].map(own["left_out_rmse"] / own["rmse"])
    return Outcome(fits.assign(holds=relative > audit.overfit_min, value=relative))


@_check("torque-stress", worst="largest", where="data")
def _torque_stress(view: View) -> Outcome:
    rows, further = _torque(view.evidence)
    error = rows["stress"].dropna()
    holds = error <= view.settings.audit.torque_stress_error
    judged = rows.loc[error.index, ["oil"]].assign(holds=holds, value=error)
    return Outcome(judged, {"largest": error.max(), **further})


@_check("torque-load", worst="smallest", where="data")
def _torque_load(view: View) -> Outcome:
    rows, further = _torque(view.evidence)
    both = rows.dropna()
    if both.empty:
        raise NotCheckableError("no torque by the law")
    excess, largest = both["load"] - both["stress"], both["load"].max()
    return Outcome(
        both.assign(holds=excess > 0, value=excess),
        {"largest": largest, **further},
        complete=bool(largest >= view.settings.audit.torque_load_error),
    )


@_check("uniquely-determined", worst="largest", where="data")
def _uniquely_determined(view: View) -> Outcome:
    law, measured = view.settings.audit.stress_law, view.evidence.measured
    fits = view.evidence.rows("fit_quality", reason="no fit by the paper's law")
    fits = fits[fits["law"] == law].dropna(subset="constant_spread")
    if fits.empty:
        raise NotCheckableError("no fit by the paper's law")
    constants = measured.coefficients[measured.coefficients["law"] == law]
    known = constants[constants["oil"].isin(fits["oil"])]["verdict"].eq("known").to_numpy()
    judged = fits[["oil"]].assign(holds=fits["certified"], value=fits["constant_spread"])
    return Outcome(judged, shares({"known": known}))


@_check("genetic-optimum", worst="largest", where="formula")
def _genetic_optimum(view: View) -> Outcome:
    raise NotCheckableError("not stated")


@_check("extrapolates", worst="largest", where="data")
def _extrapolates(view: View) -> Outcome:
    audit, measured = view.settings.audit, view.evidence.measured
    fits = view.evidence.rows("fit_quality", reason="no fit by the paper's law")
    if view.evidence.truth_is_law:
        raise NotCheckableError("own law")
    fits = fits[fits["law"] == audit.stress_law]
    ends = fits.filter(regex="^oil$|_end_out_relative_rms$").melt("oil").dropna()
    if ends.empty:
        raise NotCheckableError("no fit by the paper's law")
    left_out = fits["left_out_rmse"] * fits["relative_rms"] / fits["rmse"]
    truth = measured.extrapolation
    truth = truth[(truth["law"] == audit.stress_law) & truth["oil"].isin(fits["oil"])]
    error = (truth["traction_coefficient"] / truth["true_traction_coefficient"] - 1).abs()
    at_truth = (error[truth["beyond"] != ""] <= audit.prediction_error).to_numpy()
    return Outcome(
        ends.assign(holds=ends["value"] <= audit.prediction_error),
        shares(
            {
                "truth": at_truth,
                "accuracy": (left_out <= audit.prediction_error).to_numpy(),
                "left_out": left_out.max(),
            }
        ),
    )


@_check("composite-roughness", worst="largest", where="formula")
def _composite_roughness(view: View) -> Outcome:
    composite = float(np.hypot(*_RA_UM))
    judged = pd.DataFrame({"oil": [""], "holds": composite < _COMPOSITE_UM, "value": composite})
    return Outcome(judged, {"rounded": float(round(composite, 3) <= _COMPOSITE_UM)})


@_check("rolling-speed", worst="smallest", where="formula")
def _rolling_speed(view: View) -> Outcome:
    stated = view.settings.selection.stated
    pitch_speed, speed = stated.pitch_speed_mm_rpm, stated.entrainment_speed_m_s
    rolling = np.array([entrainment_speed_m_s(pitch_speed, gamma) for gamma in _GAMMAS])
    tolerance, surface = view.settings.audit.kinematic_tolerance, surface_speed_m_s(pitch_speed)
    near = np.abs(rolling / speed - 1) <= tolerance
    return Outcome(
        pd.DataFrame({"oil": "", "holds": near, "value": rolling}),
        {
            "as_surface": float(abs(surface / speed - 1) <= tolerance),
            "highest": rolling.max(),
            "surface_speed": surface,
            "pitch_speed": pitch_speed_mm_rpm(speed),
        },
    )


@_check("slip-is-cage-slip", worst="largest", where="formula")
def _slip_is_cage_slip(view: View) -> Outcome:
    choice, slip = view.settings.selection, np.linspace(0.05, 0.4, 8)
    ratio = np.concatenate([inner_slide_roll_ratio(slip, gamma) / slip for gamma in _GAMMAS])
    tolerance, limit = view.settings.audit.kinematic_tolerance, choice.limits.slip_limit
    near, of_both = (np.abs(each - 1) <= tolerance for each in (ratio, ratio / 2))
    return Outcome(
        pd.DataFrame({"oil": "", "holds": near, "value": ratio}),
        {
            "both_races": float(of_both.mean()),
            "smallest": ratio.min(),
            "at_limit": float(inner_slide_roll_ratio(limit, choice.gamma)),
            "cage_slip": float(cage_slip(limit, choice.gamma)),
        },
    )


@_check("light-load-4102", worst="smallest")
def _light_load(view: View) -> Outcome:
    choice = view.settings.selection
    light = _within(_to_the_end(view), above=-np.inf, below=choice.limits.light_below_gpa)
    mu, grid = light.mu_by_viscosity(), light.grid
    ratio = mu[:1] / mu[1:].max(axis=0, keepdims=True)
    hot = grid.inlet_temperature_c >= choice.limits.hot_from_c
    fast = grid.entrainment_speed_m_s >= choice.fast_from_m_s
    slipping = grid.slide_roll_ratio > choice.slide_roll_ratio_limit
    corner = ratio[:, :, fast][:, :, :, hot][..., slipping]
    higher = mu[:-1].min(axis=0) > mu[-1]
    return light.outcome(ratio > 1, ratio, higher_viscosity=higher, hot_and_fast=corner > 1)


@_check("slip-15", worst="largest")
def _slip_limit(view: View) -> Outcome:
    view = _to_the_end(view)
    mu, adequate, choice = (
        view.mu_by_viscosity(),
        _thinnest_is_adequate(view),
        view.settings.selection,
    )
    slipping = view.grid.slide_roll_ratio > choice.slide_roll_ratio_limit
    # S taken for the cage slip, as section 4.3 does
    as_slip = view.grid.slide_roll_ratio > choice.limits.slip_limit
    least = mu[-1:] / mu[:-1].min(axis=0, keepdims=True)
    ordered = mu[1:] / mu[:-1]
    value = np.where(slipping, ordered.max(axis=0, keepdims=True), least)
    by_slip = np.where(as_slip, ordered.max(axis=0, keepdims=True), least)
    below = value[..., ~slipping][adequate[..., ~slipping]] < 1
    outcome = view.outcome(
        value < 1,
        value,
        as_cage_slip=by_slip[as_slip | adequate] < 1,
        more_than_thinnest=ordered[1][..., slipping] < 1,
        below=below,
        beyond=value[..., slipping] < 1,
        adequate=adequate,
    )
    return _where(outcome, slipping | adequate, "no condition")


@_check("heavy-load-4010", worst="largest")
def _heavy_load(view: View) -> Outcome:
    heavy = _within(view, above=view.settings.selection.limits.heavy_from_gpa, below=np.inf)
    mu, adequate = heavy.mu_by_viscosity(), _thinnest_is_adequate(heavy)
    ratio = mu[-1:] / mu[:-1].min(axis=0, keepdims=True)
    outcome = _where(heavy.outcome(ratio < 1, ratio, adequate=adequate), adequate, "no film")
    in_bearing = _least_torque_of_thinnest(view)
    outcome.numbers.update(bearing=in_bearing.mean(), bearing_points=float(len(in_bearing)))
    return outcome


def _of_equation(evidence: Evidence, holds: Callable[[Law], BoolArray]) -> bool:
    """Whether something is true of every law, whatever its constants."""
    laws = {fitted.law.name: fitted.law for fitted in evidence.laws.values()}
    return all(holds(law).all() for law in laws.values())


def _any_constants(law: Law, slip: FloatArray) -> FloatArray:
    """mu at slips by coefficients over all their bounds, each size with each; rounding is 0."""
    levels = [
        np.geomspace(coefficient.smallest, coefficient.largest, _SIZES)
        for coefficient in law.coefficients
    ]
    sizes = np.stack([size.ravel() for size in np.meshgrid(*levels)])[..., np.newaxis]
    with np.errstate(over="ignore", invalid="ignore"):
        mu = law.value(sizes, slip)
    return np.where(np.abs(mu) <= _ROUNDING * sizes.max(axis=0), 0.0, mu)


def _linear_range(view: View) -> FloatArray:
    """Slip at which mu/S has left its value at no slip by the tolerance; the last slip if never."""
    # the slope at no slip is that over a slip a thousand times below the first step of the curve
    curve, tolerance = view.curve, view.settings.audit.linear_tolerance
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


def _falls(values: FloatArray, axis: int) -> BoolArray:
    """Whether values fall at every step along an axis, which is kept with length 1."""
    return np.asarray((np.diff(values, axis=axis) < 0).all(axis=axis, keepdims=True))


def _last_over_first(values: FloatArray, axis: int) -> FloatArray:
    return np.take(values, [-1], axis=axis) / np.take(values, [0], axis=axis)


def _r_squared(abscissa: FloatArray, values: FloatArray, axis: int) -> FloatArray:
    """R2 of the straight line through values along one axis."""
    x = np.expand_dims(abscissa - abscissa.mean(), [at for at in range(values.ndim) if at != axis])
    y = values - values.mean(axis=axis, keepdims=True)
    joint = (x * y).sum(axis=axis, keepdims=True)
    return joint**2 / ((x**2).sum() * (y**2).sum(axis=axis, keepdims=True))


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
    return view.at(max_hertz_pressure_gpa=inside[inside < below])


def _thinnest_is_adequate(view: View) -> BoolArray:
    """Where the film of the least viscous oil is thick enough."""
    film = view.film(view.evidence.falling_viscosity[-1])
    return np.asarray(film[1][np.newaxis] > view.evidence.lambda_limit)


def _least_torque_of_thinnest(view: View) -> BoolArray:
    """Whether the least viscous oil has the least torque, at each heavily loaded operating point.

    Heavily loaded: from the highest pressure of the paper's tests on, with enough film.

    Raises:
        NotCheckableError: There is no such point.
    """
    slips, oils = view.evidence.measured.cage_slip, view.evidence.falling_viscosity
    slips = slips[slips["oil"].isin(oils) & (slips["lambda_ratio"] > view.evidence.lambda_limit)]
    pressure = slips[["inner_max_hertz_pressure_gpa", "outer_max_hertz_pressure_gpa"]].max(axis=1)
    slips = slips[pressure >= view.settings.printed.boxes.tested.max_hertz_pressure_gpa[1]]
    torque = slips.pivot(index=OPERATING_POINT, columns="oil", values="torque_n_m")
    torque = torque.reindex(columns=list(oils)).dropna(subset=[oils[-1]])
    if torque.empty:
        raise NotCheckableError("no bearing")
    return np.asarray(torque.min(axis=1) == torque[oils[-1]], dtype=bool)


def _where(outcome: Outcome, asked: BoolArray, reason: str) -> Outcome:
    """The cases that a claim is about.

    Raises:
        NotCheckableError: There are none.
    """
    if not asked.any():
        raise NotCheckableError(reason)
    return replace(outcome, cases=outcome.cases[asked.ravel()])


def _wang_deng(evidence: Evidence) -> pd.DataFrame:
    fits = evidence.rows("fit_quality", reason="no comparison")
    if evidence.truth_is_law:
        raise NotCheckableError("tie")
    fits = fits[fits["law"].str.startswith("wang")].dropna(subset="rmse")
    if fits.empty:
        raise NotCheckableError("no comparison")
    return fits[["oil", "rmse", "left_out_rmse", "zero_slip_traction"]]


def _torque(evidence: Evidence) -> tuple[pd.DataFrame, Numbers]:
    """Relative errors by load variable, and how many points are left out as bistable.

    The cage may roll or skid there.
    """
    rows = evidence.rows("torque", reason="no torque")
    for verdict in ("two truths", "positive control"):
        if (evidence.measured.torque_control["verdict"] == verdict).any():
            raise NotCheckableError(verdict)
    point = ["run_id", "first_row", "oil"]
    sure = without_bistable(rows).set_index([*point, "load_variable"])["relative_error"].abs()
    errors = sure.unstack(sort=False).reindex(columns=["stress", "load"]).reset_index()
    if errors["stress"].isna().all():
        raise NotCheckableError("no torque by the law")
    left_out = len(rows[rows["bistable"]].drop_duplicates(point[:2]))
    return errors, {"bistable": float(left_out)} if left_out else {}
