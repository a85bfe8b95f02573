"""One check for each claim of the paper, by the claim's id.

A check takes the evidence, a box of operating conditions as a grid, and all settings, and returns
the verdict in every case, with numbers that explain it; data/reference/claims.yaml says in words
what is checked and what the numbers are. Arrays have the axes oil, P, U, T, S, of length 1 where a
case spans an axis.

Decides: when a claim of the paper holds.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

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
    cases,
    share,
)
from oilfilm.settings.resolved import Settings
from oilfilm.torque.operating_grid import Grid
from oilfilm.torque.torque_control import without_bistable
from oilfilm.traction.law import Law
from oilfilm.units import BoolArray, FloatArray

_P, _U, _T, _S = 1, 2, 3, 4  # axes of the arrays
_GAMMAS = (0.0, 0.1, 0.2, 0.3)  # D cos(alpha)/dm of ball bearings
# Sizes of each coefficient that stand for all that a law allows.
_SIZES = 6
_ROUNDING = 1e-15
Judge = Callable[[Evidence, Grid, Settings], Outcome]


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
    worst: Literal["largest", "smallest"]
    where: str


CHECKS: dict[str, Check] = {}


def _check(
    claim: str, *, worst: Literal["largest", "smallest"], where: str = "extrapolated"
) -> Callable[[Judge], Judge]:
    """Registers the check of a claim (see `Check`)."""

    def register(judge: Judge) -> Judge:
        CHECKS[claim] = Check(judge, worst, where)
        return judge

    return register


@_check("zero-slip", worst="largest")
def _zero_slip(evidence: Evidence, grid: Grid, settings: Settings) -> Outcome:
    still = grid.at(slide_roll_ratio=[0.0])
    mu = np.abs(evidence.traction(still))
    return Outcome(
        cases(still, evidence.oils, mu <= settings.audit.zero_traction_max, mu),
        by_construction=_of_equation(evidence, lambda law: _any_constants(law, np.zeros(1)) == 0),
    )


@_check("non-negative", worst="smallest")
def _non_negative(evidence: Evidence, grid: Grid, settings: Settings) -> Outcome:
    slip = _curve(settings)
    curve = grid.at(slide_roll_ratio=slip[1:])
    mu = evidence.traction(curve).min(axis=_S, keepdims=True)
    return Outcome(
        cases(curve, evidence.oils, mu >= 0, mu),
        by_construction=_of_equation(evidence, lambda law: _any_constants(law, slip) >= 0),
    )


@_check("linear-start", worst="smallest", where="tested")
def _linear_start(evidence: Evidence, grid: Grid, settings: Settings) -> Outcome:
    end = _linear_range(evidence, grid, settings)
    judged = cases(grid, evidence.oils, end >= settings.audit.linear_to_slip, end)
    return Outcome(judged, {"longest": np.nanmax(end)})


@_check("peak-decline", worst="largest", where="tested")
def _peak_decline(evidence: Evidence, grid: Grid, settings: Settings) -> Outcome:
    slip = _curve(settings)
    mu = evidence.traction(grid.at(slide_roll_ratio=slip))
    peaks = np.argmax(mu, axis=_S, keepdims=True) < len(slip) - 1
    decline = 1 - mu[..., -1:] / mu.max(axis=_S, keepdims=True)
    slight = decline <= settings.printed.signs.decline_max
    coldest = decline[:, :, :, 0]
    return Outcome(
        cases(grid, evidence.oils, peaks & slight, decline),
        {
            "peaks": share(peaks),
            "slight": share(slight),
            "coldest_least": evidence.by_oil(np.nanmin, coldest),
            "coldest_most": evidence.by_oil(np.nanmax, coldest),
        },
    )


@_check("falls-with-temperature", worst="largest")
def _falls_with_temperature(evidence: Evidence, grid: Grid, settings: Settings) -> Outcome:
    mu = evidence.traction(grid)
    low, high = grid.inlet_temperature_c[[0, -1]]
    bands = np.clip([settings.audit.cold_band_c, settings.audit.hot_band_c], low, high)
    at_cold, at_hot = (
        -np.diff(evidence.traction(grid.at(inlet_temperature_c=band)), axis=_T) / np.diff(band)
        for band in bands
    )
    always, steeper = _falls(mu, _T), at_cold > at_hot
    return Outcome(
        cases(grid, evidence.oils, always & steeper, _last_over_first(mu, _T)),
        {"always": share(always), "steeper": share(steeper)},
    )


@_check("falls-with-speed", worst="largest")
def _falls_with_speed(evidence: Evidence, grid: Grid, settings: Settings) -> Outcome:
    mu = evidence.traction(grid)
    low, high = grid.entrainment_speed_m_s[[0, -1]]
    thirds = np.linspace(low, high, 4)
    fall = -np.diff(evidence.traction(grid.at(entrainment_speed_m_s=thirds)), axis=_U)
    always, levels_off = _falls(mu, _U), np.abs(fall[:, :, 2:]) < fall[:, :, :1]
    return Outcome(
        cases(grid, evidence.oils, always & levels_off, _last_over_first(mu, _U)),
        {"always": share(always), "levels_off": share(levels_off)},
    )


@_check("rises-with-stress", worst="smallest")
def _rises_with_stress(evidence: Evidence, grid: Grid, settings: Settings) -> Outcome:
    pressure = grid.max_hertz_pressure_gpa
    even = np.linspace(pressure[0], pressure[-1], len(pressure))
    grid = grid.at(max_hertz_pressure_gpa=even)
    mu = evidence.traction(grid)
    r2 = _r_squared(even, mu, _P)
    always, straight = _falls(-mu, _P), r2 >= settings.printed.signs.linear_r2_min
    return Outcome(
        cases(grid, evidence.oils, always & straight, r2),
        {
            "always": share(always),
            "straight": share(straight),
            "median_r2": evidence.by_oil(np.nanmedian, r2),
        },
    )


@_check("earlier-plateau", worst="largest")
def _earlier_plateau(evidence: Evidence, grid: Grid, settings: Settings) -> Outcome:
    end = _linear_range(evidence, grid, settings)
    slip, coldest_and_hottest = _curve(settings), grid.inlet_temperature_c[[0, -1]]
    mu = evidence.traction(grid.at(inlet_temperature_c=coldest_and_hottest, slide_roll_ratio=slip))
    reached = mu >= settings.audit.plateau_share * mu.max(axis=_S, keepdims=True)
    begin = slip[np.argmax(reached, axis=_S)]
    return Outcome(
        cases(grid, evidence.oils, _falls(end, _P), _last_over_first(end, _P)),
        {
            "plateau_coldest": evidence.by_oil(np.median, begin[..., 0]),
            "plateau_hottest": evidence.by_oil(np.median, begin[..., 1]),
        },
    )


@_check("viscosity-order", worst="smallest")
def _viscosity_order(evidence: Evidence, grid: Grid, settings: Settings) -> Outcome:
    oils, pressure = evidence.falling_viscosity, grid.max_hertz_pressure_gpa
    mu = evidence.traction_by_viscosity(grid)
    ratios = mu[:-1] / mu[1:]
    smallest = ratios.min(axis=0, keepdims=True)
    orders = np.argsort(-mu, axis=0).reshape(len(oils), -1).T
    kinds, counts = np.unique(orders, axis=0, return_counts=True)
    commonest = [oils[index] for index in kinds[counts.argmax()]]
    # all conditions at one pressure have one number: their geometric mean, as ratios need
    ends = np.exp(np.log(mu[-1] / mu[0]).mean(axis=(1, 2, 3)))[[0, -1]]
    numbers: Numbers = {
        "above_next": {
            thick: share(pair > 1) for thick, pair in zip(oils[:-1], ratios, strict=True)
        },
        "commonest_share": counts.max() / len(orders),
        "commonest_rank": {oil: float(rank) for rank, oil in enumerate(commonest, start=1)},
        "thin_over_thick_lightest": ends[0],
        "thin_over_thick_heaviest": ends[1],
    }
    first = (ratios[0] > 1).mean(axis=(1, 2, 3))
    if first[0] < 0.5 < first[-1] and (np.diff(first) >= 0).all():
        numbers["turn_gpa"] = float(np.interp(0.5, first, pressure))
    return Outcome(cases(grid, [""], smallest > 1, smallest), numbers)


@_check("hot-convergence", worst="largest")
def _hot_convergence(evidence: Evidence, grid: Grid, settings: Settings) -> Outcome:
    ends = grid.inlet_temperature_c[[0, -1]]
    mu = evidence.traction_by_viscosity(grid.at(inlet_temperature_c=ends))
    spread = np.ptp(mu, axis=0, keepdims=True)
    relative = spread / mu.mean(axis=0, keepdims=True)
    ratio = _last_over_first(relative, _T)
    coldest, hottest = relative.mean(axis=(0, 1, 2, 4))
    return Outcome(
        cases(grid, [""], ratio <= settings.audit.convergence_max, ratio),
        {
            "decreases": share(ratio < 1),
            "spread_coldest": coldest,
            "spread_hottest": hottest,
            "difference_decreases": share(_falls(spread, _T)),
        },
    )


@_check("speed-mutes-temperature", worst="largest")
def _speed_mutes_temperature(evidence: Evidence, grid: Grid, settings: Settings) -> Outcome:
    speeds = np.clip(settings.audit.slow_and_fast_m_s, *grid.entrainment_speed_m_s[[0, -1]])
    ends = grid.inlet_temperature_c[[0, -1]]
    mu = evidence.traction(grid.at(entrainment_speed_m_s=speeds, inlet_temperature_c=ends))
    drop = -np.diff(mu, axis=_T)
    ratio = _last_over_first(drop, _U)
    return Outcome(
        cases(grid, evidence.oils, ratio < 1, ratio),
        {"relatively_milder": share(_falls(drop / mu[:, :, :, :1], _U))},
    )


@_check("full-film", worst="smallest", where="tested")
def _full_film(evidence: Evidence, grid: Grid, settings: Settings) -> Outcome:
    if evidence.points is not None:
        points = evidence.points.dropna(subset=["lambda_ratio"])
        if points.empty:
            raise NotCheckableError("no lambda")
        thickness, ratio = points[["film_thickness_um", "lambda_ratio"]].to_numpy().T
    else:
        slips = [0.0, *settings.printed.signs.slide_roll_ratio.figures, _curve(settings)[-1]]
        curve = grid.at(slide_roll_ratio=slips)
        films = [evidence.film(oil, curve) for oil in evidence.falling_viscosity]
        thickness, ratio = (np.stack(part) for part in zip(*films, strict=True))
    full = ratio > evidence.lambda_limit
    thick = thickness > settings.audit.film_min_um
    margin = np.minimum(ratio / evidence.lambda_limit, thickness / settings.audit.film_min_um)
    if evidence.points is None:
        judged = cases(curve, evidence.falling_viscosity, full & thick, margin)
    else:
        judged = points.assign(holds=full & thick, value=margin)
    return Outcome(
        judged,
        {
            "full": share(full),
            "thick": share(thick),
            "smallest_lambda": np.nanmin(ratio),
            "thinnest_um": np.nanmin(thickness),
        },
    )


@_check("wang-deng-zero", worst="smallest", where="data")
def _wang_deng_zero(evidence: Evidence, grid: Grid, settings: Settings) -> Outcome:
    fits = _wang_deng(evidence)
    mu = fits["zero_slip_traction"].abs()
    return Outcome(_of_rows(fits, mu > settings.audit.zero_traction_max, mu), {"largest": mu.max()})


@_check("wang-deng-overfit", worst="smallest", where="data")
def _wang_deng_overfit(evidence: Evidence, grid: Grid, settings: Settings) -> Outcome:
    fits, stress_law = _wang_deng(evidence), settings.audit.stress_law
    own = evidence.comparison[evidence.comparison["law"] == stress_law].set_index("oil")
    if not set(fits["oil"]) <= set(own.index):
        raise NotCheckableError("no fit by the paper's law")
    growth = fits["left_out_rmse"] / fits["rmse"]
    relative = growth / fits["oil"].map(own["left_out_rmse"] / own["rmse"])
    return Outcome(_of_rows(fits, relative > settings.audit.overfit_min, relative))


@_check("torque-stress", worst="largest", where="data")
def _torque_stress(evidence: Evidence, grid: Grid, settings: Settings) -> Outcome:
    rows = _torque(evidence, "stress")
    error = rows["relative_error"].abs()
    return Outcome(
        _of_rows(rows, error <= settings.audit.torque_stress_error, error),
        {"largest": error.max(), **_left_out(evidence)},
    )


@_check("torque-load", worst="smallest", where="data")
def _torque_load(evidence: Evidence, grid: Grid, settings: Settings) -> Outcome:
    by_load, by_stress = (
        _torque(evidence, basis).set_index(["run_id", "first_row", "oil"])["relative_error"].abs()
        for basis in ("load", "stress")
    )
    both = pd.DataFrame({"load": by_load, "stress": by_stress}).dropna().reset_index()
    if both.empty:
        raise NotCheckableError("no torque by the law")
    excess, largest = both["load"] - both["stress"], both["load"].max()
    return Outcome(
        _of_rows(both, excess > 0, excess),
        {"largest": largest, **_left_out(evidence)},
        complete=bool(largest >= settings.audit.torque_load_error),
    )


@_check("rolling-speed", worst="smallest", where="formula")
def _rolling_speed(evidence: Evidence, grid: Grid, settings: Settings) -> Outcome:
    stated = settings.selection.stated
    pitch_speed, speed = stated.pitch_speed_mm_rpm, stated.entrainment_speed_m_s
    rolling = np.array([entrainment_speed_m_s(pitch_speed, gamma) for gamma in _GAMMAS])
    near = np.abs(rolling / speed - 1) <= settings.audit.kinematic_tolerance
    return Outcome(
        pd.DataFrame({"oil": "", "holds": near, "value": rolling}),
        {
            "highest": rolling.max(),
            "surface_speed": surface_speed_m_s(pitch_speed),
            "pitch_speed": pitch_speed_mm_rpm(speed),
        },
    )


@_check("slip-is-cage-slip", worst="largest", where="formula")
def _slip_is_cage_slip(evidence: Evidence, grid: Grid, settings: Settings) -> Outcome:
    choice, slip = settings.selection, np.linspace(0.05, 0.4, 8)
    ratio = np.concatenate([inner_slide_roll_ratio(slip, gamma) / slip for gamma in _GAMMAS])
    near = np.abs(ratio - 1) <= settings.audit.kinematic_tolerance
    limit = choice.limits.slip_limit
    return Outcome(
        pd.DataFrame({"oil": "", "holds": near, "value": ratio}),
        {
            "smallest": ratio.min(),
            "at_limit": float(inner_slide_roll_ratio(limit, choice.gamma)),
            "cage_slip": float(cage_slip(limit, choice.gamma)),
        },
    )


@_check("light-load-4102", worst="smallest")
def _light_load(evidence: Evidence, grid: Grid, settings: Settings) -> Outcome:
    limits, slip_limit = settings.selection.limits, settings.selection.slide_roll_ratio_limit
    light = _within(_to_the_end(grid, settings), above=-np.inf, below=limits.light_below_gpa)
    mu = evidence.traction_by_viscosity(light)
    ratio = mu[:1] / mu[1:].max(axis=0, keepdims=True)
    hot = light.inlet_temperature_c >= limits.hot_from_c
    fast = light.entrainment_speed_m_s >= settings.selection.fast_from_m_s
    corner = ratio[:, :, fast][:, :, :, hot][..., light.slide_roll_ratio > slip_limit]
    return Outcome(cases(light, [""], ratio > 1, ratio), {"hot_and_fast": share(corner > 1)})


@_check("slip-15", worst="largest")
def _slip_limit(evidence: Evidence, grid: Grid, settings: Settings) -> Outcome:
    grid = _to_the_end(grid, settings)
    mu, slip_limit = evidence.traction_by_viscosity(grid), settings.selection.slide_roll_ratio_limit
    adequate = _thinnest_is_adequate(evidence, grid)
    slipping = grid.slide_roll_ratio > slip_limit
    least = mu[-1:] / mu[:-1].min(axis=0, keepdims=True)
    ordered = mu[1:] / mu[:-1]
    value = np.where(slipping, ordered.max(axis=0, keepdims=True), least)
    checked = slipping | adequate
    if not checked.any():
        raise NotCheckableError("no condition")
    return Outcome(
        cases(grid, [""], value < 1, value)[checked.ravel()],
        {
            "below": share(value[..., ~slipping][adequate[..., ~slipping]] < 1),
            "beyond": share(value[..., slipping] < 1),
            "adequate": share(adequate),
        },
    )


@_check("heavy-load-4010", worst="largest")
def _heavy_load(evidence: Evidence, grid: Grid, settings: Settings) -> Outcome:
    heavy = _within(grid, above=settings.selection.limits.heavy_from_gpa, below=np.inf)
    adequate = _thinnest_is_adequate(evidence, heavy)
    if not adequate.any():
        raise NotCheckableError("no film")
    mu = evidence.traction_by_viscosity(heavy)
    ratio = mu[-1:] / mu[:-1].min(axis=0, keepdims=True)
    judged = cases(heavy, [""], ratio < 1, ratio)[adequate.ravel()]
    return Outcome(judged, {"adequate": share(adequate)})


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


def _curve(settings: Settings) -> FloatArray:
    """Slips of a whole curve."""
    end = settings.printed.boxes.tested.slide_roll_ratio[1]
    return np.linspace(0.0, end, settings.audit.curve_points)


def _to_the_end(grid: Grid, settings: Settings) -> Grid:
    """The grid with the largest tested slip as well, where the limit of cage slip lies."""
    end = settings.printed.boxes.tested.slide_roll_ratio[1]
    return grid.at(slide_roll_ratio=np.union1d(grid.slide_roll_ratio, end))


def _linear_range(evidence: Evidence, grid: Grid, settings: Settings) -> FloatArray:
    """Slip at which mu/S has left its value at no slip by the tolerance; the last slip if never."""
    # the slope at no slip is that over a slip a thousand times below the first step of the curve
    curve, tolerance = _curve(settings), settings.audit.linear_tolerance
    slip = np.concatenate([[curve[1] * 1e-3], curve[1:]])
    chord = evidence.traction(grid.at(slide_roll_ratio=slip)) / slip
    left = np.abs(chord / chord[..., :1] - 1)
    beyond = left > tolerance
    after = np.where(beyond.any(axis=_S), np.argmax(beyond, axis=_S), len(slip) - 1)
    # between the last slip inside and the first outside, in a straight line
    inside, outside = (
        np.take_along_axis(left, index[..., np.newaxis], axis=_S)[..., 0]
        for index in (after - 1, after)
    )
    way = np.divide(
        tolerance - inside,
        outside - inside,
        out=np.ones_like(inside),
        where=outside > inside,
    )
    end = slip[after - 1] + way * (slip[after] - slip[after - 1])
    return np.where(beyond.any(axis=_S), end, slip[-1])[..., np.newaxis]


def _falls(values: FloatArray, axis: int) -> BoolArray:
    """Whether values fall at every step along an axis, which is kept with length 1."""
    return np.asarray((np.diff(values, axis=axis) < 0).all(axis=axis, keepdims=True))


def _last_over_first(values: FloatArray, axis: int) -> FloatArray:
    return np.take(values, [-1], axis=axis) / np.take(values, [0], axis=axis)


def _r_squared(abscissa: FloatArray, values: FloatArray, axis: int) -> FloatArray:
    """R2 of the straight line through values along one axis."""
    shape = [1] * values.ndim
    shape[axis] = -1
    x = (abscissa - abscissa.mean()).reshape(shape)
    y = values - values.mean(axis=axis, keepdims=True)
    joint = (x * y).sum(axis=axis, keepdims=True)
    return joint**2 / ((x**2).sum() * (y**2).sum(axis=axis, keepdims=True))


def _within(grid: Grid, *, above: float, below: float) -> Grid:
    """The grid with as many levels of pressure in [above, below) only.

    Raises:
        NotCheckableError: There are none.
    """
    pressure = grid.max_hertz_pressure_gpa
    low, high = max(above, pressure[0]), min(below, pressure[-1])
    if low >= high:
        raise NotCheckableError("no condition")
    inside = np.geomspace(low, high, len(pressure))
    return grid.at(max_hertz_pressure_gpa=inside[inside < below])


def _thinnest_is_adequate(evidence: Evidence, grid: Grid) -> BoolArray:
    """Where the film of the least viscous oil is thick enough."""
    film = evidence.film(evidence.falling_viscosity[-1], grid)
    return np.asarray(film[1][np.newaxis] > evidence.lambda_limit)


def _of_rows(rows: pd.DataFrame, holds: pd.Series, value: pd.Series) -> pd.DataFrame:
    """Cases from rows of a table, without conditions."""
    return pd.DataFrame({"oil": rows["oil"], "holds": holds, "value": value})


def _wang_deng(evidence: Evidence) -> pd.DataFrame:
    if evidence.comparison.empty:
        raise NotCheckableError("not printed" if evidence.basis == "printed" else "no comparison")
    if evidence.truth_is_law:
        raise NotCheckableError("tie")
    is_wang_deng = evidence.comparison["law"].str.startswith("wang")
    fits = evidence.comparison[is_wang_deng].dropna(subset="rmse")
    if fits.empty:
        raise NotCheckableError("no comparison")
    return fits


def _torque(evidence: Evidence, basis: str) -> pd.DataFrame:
    if evidence.torque.empty:
        raise NotCheckableError("not printed" if evidence.basis == "printed" else "no torque")
    for verdict in ("two truths", "positive control"):
        if (evidence.torque_control["verdict"] == verdict).any():
            raise NotCheckableError(verdict)
    sure = without_bistable(evidence.torque)
    rows = sure[sure["load_variable"] == basis].dropna(subset=["relative_error"])
    if rows.empty:
        raise NotCheckableError("no torque by the law")
    return rows


def _left_out(evidence: Evidence) -> Numbers:
    """How many operating points are left out, because the cage may roll or skid there."""
    torque = evidence.torque[evidence.torque["bistable"]]
    count = len(torque.drop_duplicates(["run_id", "first_row"]))
    return {"bistable": float(count)} if count else {}
