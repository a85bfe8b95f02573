"""One check for each claim of the paper, by the claim's id.

A check takes the evidence, a box of operating conditions as a grid, and all settings, and returns
what it found in every case. Arrays have the axes oil, P, U, T, S, of length 1 where a case spans
an axis.

Decides: when a claim of the paper holds.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import pandas as pd

from oilfilm.bearing.kinematics import (
    cage_slip,
    entrainment_speed_m_s,
    inner_slide_roll_ratio,
    pitch_speed_mm_rpm,
    surface_speed_m_s,
)
from oilfilm.fits.law_comparison import TIE
from oilfilm.paper.audit.evidence import (
    Evidence,
    NotCheckableError,
    Outcome,
    cases,
    share,
)
from oilfilm.settings.resolved import Settings
from oilfilm.torque.operating_grid import Grid
from oilfilm.torque.torque_control import bistable_points, without_bistable
from oilfilm.traction.law import Law
from oilfilm.units import BoolArray, FloatArray

_P, _U, _T, _S = 1, 2, 3, 4  # axes of the arrays
_GAMMAS = (0.0, 0.1, 0.2, 0.3)  # D cos(alpha)/dm of ball bearings
# Sizes of each coefficient that stand for all that a law allows.
_SIZES = 6
_ROUNDING = 1e-15
Judge = Callable[[Evidence, Grid, Settings], Outcome | None]


@dataclass(frozen=True)
class Check:
    """How a claim is checked.

    Attributes:
        judge: Finds the cases; None where the box has none for the claim.
        definition: What would make the claim hold, with keys of the configuration in braces.
        where: Box on which the verdict rests, `tested` or `extrapolated`; `data` where the check
            looks at tables, `formula` where it looks at the paper's Eq. 1, and at no box.
    """

    judge: Judge
    definition: str
    where: str


CHECKS: dict[str, Check] = {}


def _check(claim: str, definition: str, where: str = "extrapolated") -> Callable[[Judge], Judge]:
    """Registers the check of a claim (see `Check`)."""

    def register(judge: Judge) -> Judge:
        CHECKS[claim] = Check(judge, definition, where)
        return judge

    return register


@_check("zero-slip", "|mu| is {audit.zero_traction_max:g} at most wherever S is 0.")
def _zero_slip(evidence: Evidence, grid: Grid, settings: Settings) -> Outcome:
    still = grid.at(slide_roll_ratio=[0.0])
    mu = np.abs(evidence.traction(still))
    judged = cases(still, evidence.oils, mu <= settings.audit.zero_traction_max, mu)
    return Outcome(
        judged,
        "|mu| at S = 0",
        ".3g",
        worst="largest",
        by_construction=_of_equation(evidence, lambda law: _any_constants(law, np.zeros(1)) == 0),
    )


@_check(
    "non-negative",
    "mu is 0 or more for every S up to {printed.boxes.tested.slide_roll_ratio[1]:g}.",
)
def _non_negative(evidence: Evidence, grid: Grid, settings: Settings) -> Outcome:
    curve = grid.at(slide_roll_ratio=_curve(settings)[1:])
    mu = evidence.traction(curve).min(axis=_S, keepdims=True)
    judged = cases(curve, evidence.oils, mu >= 0, mu)
    slip = _curve(settings)
    return Outcome(
        judged,
        "smallest mu of a curve beyond S = 0",
        ".2g",
        worst="smallest",
        by_construction=_of_equation(evidence, lambda law: _any_constants(law, slip) >= 0),
    )


@_check(
    "linear-start",
    "Up to S {audit.linear_to_slip:g}, the first slip that the rig sets, mu/S stays within "
    "{audit.linear_tolerance:.0%} of its value at no slip.",
    where="tested",
)
def _linear_start(evidence: Evidence, grid: Grid, settings: Settings) -> Outcome:
    end = _linear_range(evidence, grid, settings)
    judged = cases(grid, evidence.oils, end >= settings.audit.linear_to_slip, end)
    remark = f"The linear range ends at S {_range(end)}."
    quantity = "S at the end of the linear range"
    return Outcome(judged, quantity, ".3g", worst="smallest", remarks=[remark])


@_check(
    "peak-decline",
    "mu has its largest value below S {printed.boxes.tested.slide_roll_ratio[1]:g}, and there it "
    "has lost {printed.signs.decline_max:.0%} of it at most.",
    where="tested",
)
def _peak_decline(evidence: Evidence, grid: Grid, settings: Settings) -> Outcome:
    slip = _curve(settings)
    mu = evidence.traction(grid.at(slide_roll_ratio=slip))
    peaks = np.argmax(mu, axis=_S, keepdims=True) < len(slip) - 1
    decline = 1 - mu[..., -1:] / mu.max(axis=_S, keepdims=True)
    slight = decline <= settings.printed.signs.decline_max
    return Outcome(
        cases(grid, evidence.oils, peaks & slight, decline),
        f"loss of mu between the peak and S {slip[-1]:g}",
        ".0%",
        worst="largest",
        parts={"mu has a peak": peaks, "it loses little or nothing behind it": slight},
        remarks=[
            f"At {grid.inlet_temperature_c[0]:g} degC {oil} loses {_range(of_oil[:, :, 0], '.0%')}."
            for oil, of_oil in zip(evidence.oils, decline, strict=True)
        ],
    )


@_check(
    "falls-with-temperature",
    "mu falls from each level of T to the next, and by more per degree at "
    "{audit.cold_band_c[0]:g}-{audit.cold_band_c[1]:g} degC than at {audit.hot_band_c[0]:g}-"
    "{audit.hot_band_c[1]:g} degC.",
)
def _falls_with_temperature(evidence: Evidence, grid: Grid, settings: Settings) -> Outcome:
    mu = evidence.traction(grid)
    low, high = grid.inlet_temperature_c[[0, -1]]
    bands = np.clip([settings.audit.cold_band_c, settings.audit.hot_band_c], low, high)
    at_cold, at_hot = (
        -np.diff(evidence.traction(grid.at(inlet_temperature_c=band)), axis=_T) / np.diff(band)
        for band in bands
    )
    always, steeper = _falls(mu, _T), at_cold > at_hot
    cold, hot = (f"{band[0]:g}-{band[1]:g}" for band in bands)
    return Outcome(
        cases(grid, evidence.oils, always & steeper, _last_over_first(mu, _T)),
        f"ratio of mu at {high:g} degC to mu at {low:g} degC",
        worst="largest",
        parts={
            "mu falls at every step": always,
            f"it falls more steeply at {cold} than at {hot} degC": steeper,
        },
    )


@_check(
    "falls-with-speed",
    "mu falls from each level of U to the next, and changes less over the last third of the speeds "
    "than it falls over the first third.",
)
def _falls_with_speed(evidence: Evidence, grid: Grid, settings: Settings) -> Outcome:
    mu = evidence.traction(grid)
    low, high = grid.entrainment_speed_m_s[[0, -1]]
    thirds = evidence.traction(grid.at(entrainment_speed_m_s=np.linspace(low, high, 4)))
    fall = -np.diff(thirds, axis=_U)
    always, levels_off = _falls(mu, _U), np.abs(fall[:, :, 2:]) < fall[:, :, :1]
    return Outcome(
        cases(grid, evidence.oils, always & levels_off, _last_over_first(mu, _U)),
        f"ratio of mu at {high:g} m/s to mu at {low:g} m/s",
        worst="largest",
        parts={"mu falls at every step": always, "it levels off": levels_off},
    )


@_check(
    "rises-with-stress",
    "mu rises from each level of P to the next, and a straight line through mu(P) has R2 of "
    "{printed.signs.linear_r2_min:g} or more.",
)
def _rises_with_stress(evidence: Evidence, grid: Grid, settings: Settings) -> Outcome:
    pressure = grid.max_hertz_pressure_gpa
    even = np.linspace(pressure[0], pressure[-1], len(pressure))
    grid = grid.at(max_hertz_pressure_gpa=even)
    mu = evidence.traction(grid)
    r2 = _r_squared(even, mu, _P)
    always, straight = _falls(-mu, _P), r2 >= settings.printed.signs.linear_r2_min
    return Outcome(
        cases(grid, evidence.oils, always & straight, r2),
        "R2 of the straight line mu(P)",
        worst="smallest",
        parts={"mu rises at every step": always, "the line is straight enough": straight},
        remarks=[
            f"The median R2 of {oil} is {np.nanmedian(of_oil):.2f}."
            for oil, of_oil in zip(evidence.oils, r2, strict=True)
        ],
    )


@_check(
    "earlier-plateau",
    "The linear range (mu/S within {audit.linear_tolerance:.0%} of its value at no slip) ends at "
    "smaller S from each level of P to the next.",
)
def _earlier_plateau(evidence: Evidence, grid: Grid, settings: Settings) -> Outcome:
    end = _linear_range(evidence, grid, settings)
    low, high = grid.max_hertz_pressure_gpa[[0, -1]]
    cold, hot = ends = grid.inlet_temperature_c[[0, -1]]
    slip, plateau_share = _curve(settings), settings.audit.plateau_share
    mu = evidence.traction(grid.at(inlet_temperature_c=ends, slide_roll_ratio=slip))
    reached = mu >= plateau_share * mu.max(axis=_S, keepdims=True)
    begin = slip[np.argmax(reached, axis=_S)]
    return Outcome(
        cases(grid, evidence.oils, _falls(end, _P), _last_over_first(end, _P)),
        f"ratio of the linear range's end at {high:g} GPa to that at {low:g} GPa",
        worst="largest",
        remarks=[
            f"{oil} reaches {plateau_share:.0%} of its peak at S {np.median(of_oil[:, :, 0]):.2g} "
            f"at {cold:g} degC and at S {np.median(of_oil[:, :, 1]):.2g} at {hot:g} degC."
            for oil, of_oil in zip(evidence.oils, begin, strict=True)
        ],
    )


@_check(
    "viscosity-order",
    "At the same P, U, T and S mu falls from each oil to the next less viscous one.",
)
def _viscosity_order(evidence: Evidence, grid: Grid, settings: Settings) -> Outcome:
    oils, pressure = evidence.falling_viscosity, grid.max_hertz_pressure_gpa
    mu = evidence.traction_by_viscosity(grid)
    ratios = mu[:-1] / mu[1:]
    smallest = ratios.min(axis=0, keepdims=True)
    orders = np.argsort(-mu, axis=0).reshape(len(oils), -1).T
    kinds, counts = np.unique(orders, axis=0, return_counts=True)
    commonest = " > ".join(oils[index] for index in kinds[counts.argmax()])
    # all conditions at one pressure have one number: their geometric mean, as ratios need
    ends = np.exp(np.log(mu[-1] / mu[0]).mean(axis=(1, 2, 3)))[[0, -1]]
    remarks = [
        f"The commonest order is {commonest} ({counts.max() / len(orders):.0%}).",
        f"The mean ratio of mu of {oils[-1]} to mu of {oils[0]} is {ends[0]:.2f} at "
        f"{pressure[0]:g} GPa and {ends[1]:.2f} at {pressure[-1]:g} GPa.",
    ]
    first = (ratios[0] > 1).mean(axis=(1, 2, 3))
    if first[0] < 0.5 < first[-1] and (np.diff(first) >= 0).all():
        turn = np.interp(0.5, first, pressure)
        remarks.append(
            f"Below {turn:.1f} GPa {oils[1]} has more traction than {oils[0]} at most operating "
            "points."
        )
    return Outcome(
        cases(grid, [""], smallest > 1, smallest),
        "smallest ratio of an oil's mu to that of the next less viscous oil",
        worst="smallest",
        parts={
            f"{thick} > {thin}": pair > 1
            for thick, thin, pair in zip(oils[:-1], oils[1:], ratios, strict=True)
        },
        remarks=remarks,
    )


@_check(
    "hot-convergence",
    "The oils' relative spread of mu (largest less smallest, over the mean) at the hottest level "
    "is at most {audit.convergence_max:.0%} of that at the coldest level.",
)
def _hot_convergence(evidence: Evidence, grid: Grid, settings: Settings) -> Outcome:
    ends = grid.inlet_temperature_c[[0, -1]]
    mu = evidence.traction_by_viscosity(grid.at(inlet_temperature_c=ends))
    spread = np.ptp(mu, axis=0, keepdims=True)
    relative = spread / mu.mean(axis=0, keepdims=True)
    ratio = _last_over_first(relative, _T)
    cold, hot = relative.mean(axis=(0, 1, 2, 4))
    return Outcome(
        cases(grid, [""], ratio <= settings.audit.convergence_max, ratio),
        f"relative spread at {ends[1]:g} degC over that at {ends[0]:g} degC",
        worst="largest",
        parts={"the relative spread decreases at all": ratio < 1},
        remarks=[
            f"The average relative spread is {cold:.2f} at {ends[0]:g} degC and {hot:.2f} at "
            f"{ends[1]:g} degC. The difference of mu itself decreases at "
            f"{_falls(spread, _T).mean():.0%} of the operating points, because mu decreases."
        ],
    )


@_check(
    "speed-mutes-temperature",
    "From the coldest to the hottest level mu falls by less at {audit.slow_and_fast_m_s[1]:g} m/s "
    "than at {audit.slow_and_fast_m_s[0]:g} m/s (or at the box's own ends).",
)
def _speed_mutes_temperature(evidence: Evidence, grid: Grid, settings: Settings) -> Outcome:
    speeds = np.clip(settings.audit.slow_and_fast_m_s, *grid.entrainment_speed_m_s[[0, -1]])
    ends = grid.inlet_temperature_c[[0, -1]]
    mu = evidence.traction(grid.at(entrainment_speed_m_s=speeds, inlet_temperature_c=ends))
    drop = -np.diff(mu, axis=_T)
    ratio = _last_over_first(drop, _U)
    milder = _falls(drop / mu[:, :, :, :1], _U).mean()
    return Outcome(
        cases(grid, evidence.oils, ratio < 1, ratio),
        f"ratio of the fall of mu at {speeds[1]:g} m/s to that at {speeds[0]:g} m/s",
        worst="largest",
        remarks=[
            f"Relative to mu itself the fall is smaller at {milder:.0%} of the operating points."
        ],
    )


@_check(
    "full-film",
    "lambda is above gates.lambda_limit and the film is thicker than {audit.film_min_um:g} um; the "
    "refit is judged at the campaign's own points, the printed basis in the box tested by the "
    "paper.",
    where="tested",
)
def _full_film(evidence: Evidence, grid: Grid, settings: Settings) -> Outcome:
    limit, film_min = evidence.lambda_limit, settings.audit.film_min_um
    if evidence.points is not None:
        points = evidence.points.dropna(subset=["lambda_ratio"])
        if points.empty:
            raise NotCheckableError("no point of an oil of the paper has a lambda")
        thickness, ratio = points[["film_thickness_um", "lambda_ratio"]].to_numpy().T
        origin = "the points' own conditions"
    else:
        slips = [0.0, *settings.printed.signs.slide_roll_ratio.figures, _curve(settings)[-1]]
        curve = grid.at(slide_roll_ratio=slips)
        films = [evidence.film(oil, curve) for oil in evidence.falling_viscosity]
        thickness, ratio = (np.stack(part) for part in zip(*films, strict=True))
        origin = "stand-in oils"
    full, thick = ratio > limit, thickness > film_min
    margin = np.minimum(ratio / limit, thickness / film_min)
    holds = full & thick
    if evidence.points is None:
        judged = cases(curve, evidence.falling_viscosity, holds, margin)
    else:
        judged = points.assign(holds=holds, value=margin)
    judged = judged.assign(
        detail=np.where(
            (ratio / limit < thickness / film_min).ravel(),
            [f"lambda {value:.2g}, limit {limit:g}" for value in ratio.ravel()],
            [f"film {value:.2g} um, limit {film_min:g} um" for value in thickness.ravel()],
        )
    )
    return Outcome(
        judged,
        "smallest ratio to its limit",
        worst="smallest",
        parts={f"lambda > {limit:g}": full, f"film > {film_min:g} um": thick},
        remarks=[f"Calculated for {origin}; the thinnest film is {np.nanmin(thickness):.3f} um."],
    )


@_check(
    "wang-deng-zero",
    "|mu(0)| of every fit by that form is above {audit.zero_traction_max:g}.",
    where="data",
)
def _wang_deng_zero(evidence: Evidence, grid: Grid, settings: Settings) -> Outcome:
    fits = _wang_deng(evidence)
    mu = fits["zero_slip_traction"].abs()
    return Outcome(
        _of_rows(fits, mu > settings.audit.zero_traction_max, mu),
        "|mu| at S = 0",
        ".3g",
        worst="smallest",
        remarks=[
            f"Largest |mu(0)| of {row['oil']} by {row['law']}: {row['value']:.2g}."
            for row in fits.assign(value=mu).to_dict("records")
        ],
    )


@_check(
    "wang-deng-overfit",
    "From fitted curves to curves left out the error grows more than {audit.overfit_min:g} times "
    "as much as that of the paper's own law.",
    where="data",
)
def _wang_deng_overfit(evidence: Evidence, grid: Grid, settings: Settings) -> Outcome:
    fits, stress_law = _wang_deng(evidence), settings.audit.stress_law
    own = evidence.comparison[evidence.comparison["law"] == stress_law].set_index("oil")
    if not set(fits["oil"]) <= set(own.index):
        raise NotCheckableError(f"the comparison has no fit by {stress_law}")
    growth = fits["left_out_rmse"] / fits["rmse"]
    relative = growth / fits["oil"].map(own["left_out_rmse"] / own["rmse"])
    return Outcome(
        _of_rows(fits, relative > settings.audit.overfit_min, relative),
        "growth of the error on curves left out, relative to the paper's law",
        worst="smallest",
        remarks=[
            f"{row['oil']} by {row['law']}: error {row['rmse']:.2g} on fitted curves, "
            f"{row['left_out_rmse']:.2g} on curves left out."
            for row in fits.to_dict("records")
        ],
    )


@_check(
    "torque-stress",
    "The calculated torque is off by {audit.torque_stress_error:.2%} at most at every operating "
    "point.",
    where="data",
)
def _torque_stress(evidence: Evidence, grid: Grid, settings: Settings) -> Outcome:
    rows, limit = _torque(evidence, "stress"), settings.audit.torque_stress_error
    error = rows["relative_error"].abs()
    return Outcome(
        _of_rows(rows, error <= limit, error),
        "relative error of the torque",
        ".1%",
        worst="largest",
        remarks=[
            f"The largest error is {error.max():.1%}; the paper has {limit:.2%}.",
            *_bistable(evidence),
        ],
    )


@_check(
    "torque-load",
    "At every operating point the load-based torque is farther off than the stress-based one; in "
    "part only, if its largest error stays below {audit.torque_load_error:.0%}.",
    where="data",
)
def _torque_load(evidence: Evidence, grid: Grid, settings: Settings) -> Outcome:
    by_load, by_stress = (
        _torque(evidence, basis).set_index(["run_id", "first_row", "oil"])["relative_error"].abs()
        for basis in ("load", "stress")
    )
    both = pd.DataFrame({"load": by_load, "stress": by_stress}).dropna().reset_index()
    if both.empty:
        raise NotCheckableError("no operating point was calculated by both bases")
    excess = both["load"] - both["stress"]
    limit, largest = settings.audit.torque_load_error, both["load"].max()
    return Outcome(
        _of_rows(both, excess > 0, excess),
        "relative error by the load less that by the stress",
        ".1%",
        worst="smallest",
        remarks=[
            f"The largest load-based error is {largest:.1%}; the paper has {limit:.0%}.",
            *_bistable(evidence),
        ],
        complete=bool(largest >= limit),
    )


@_check(
    "rolling-speed",
    "U = (U1 + U2)/2 (Eq. 1) of balls that roll on both races at dmN "
    "{selection.stated.pitch_speed_mm_rpm:.1e} mm rpm is "
    "{selection.stated.entrainment_speed_m_s:g} m/s within {audit.kinematic_tolerance:.0%}, for "
    "D cos(alpha)/dm from 0 to 0.3.",
    where="formula",
)
def _rolling_speed(evidence: Evidence, grid: Grid, settings: Settings) -> Outcome:
    stated = settings.selection.stated
    pitch_speed, speed = stated.pitch_speed_mm_rpm, stated.entrainment_speed_m_s
    rolling = np.array([entrainment_speed_m_s(pitch_speed, gamma) for gamma in _GAMMAS])
    near = np.abs(rolling / speed - 1) <= settings.audit.kinematic_tolerance
    return Outcome(
        pd.DataFrame({"oil": "", "holds": near, "value": rolling, "detail": f"stated: {speed:g}"}),
        "entrainment speed (m/s)",
        ".0f",
        worst="smallest",
        remarks=[
            f"U is {_range(rolling, '.0f')} m/s at dmN {pitch_speed:.1e} mm rpm; "
            f"{surface_speed_m_s(pitch_speed):.0f} m/s is the surface speed of the ring at the "
            f"pitch diameter. U = {speed:g} m/s is dmN {pitch_speed_mm_rpm(speed):.1e} mm rpm."
        ],
    )


@_check(
    "slip-is-cage-slip",
    "S = dU/U (Eq. 1) at the inner race of balls that roll on the outer one is the cage slip "
    "within {audit.kinematic_tolerance:.0%}, for a cage slip of 5 to 40 % and D cos(alpha)/dm from "
    "0 to 0.3.",
    where="formula",
)
def _slip_is_cage_slip(evidence: Evidence, grid: Grid, settings: Settings) -> Outcome:
    choice, slip = settings.selection, np.linspace(0.05, 0.4, 8)
    ratio = np.concatenate([inner_slide_roll_ratio(slip, gamma) / slip for gamma in _GAMMAS])
    limit = choice.limits.slip_limit
    at_limit = inner_slide_roll_ratio(limit, choice.gamma)
    return Outcome(
        pd.DataFrame(
            {
                "oil": "",
                "holds": np.abs(ratio - 1) <= settings.audit.kinematic_tolerance,
                "value": ratio,
                "detail": "stated: 1",
            }
        ),
        "ratio of S to the cage slip",
        worst="largest",
        remarks=[
            f"The ratio is {_range(ratio)}: S = 2 s/(1 + gamma (1 - s)). A cage slip of "
            f"{limit:.0%} is S = {at_limit:.2g} (gamma {choice.gamma:g}), and S = {limit:g} is a "
            f"cage slip of {cage_slip(limit, choice.gamma):.1%}."
        ],
    )


@_check(
    "light-load-4102",
    "Below {selection.limits.light_below_gpa:g} GPa the most viscous oil has the largest mu.",
)
def _light_load(evidence: Evidence, grid: Grid, settings: Settings) -> Outcome | None:
    limits, slip_limit = settings.selection.limits, settings.selection.slide_roll_ratio_limit
    light = _within(_to_the_end(grid, settings), above=-np.inf, below=limits.light_below_gpa)
    if light is None:
        return None
    mu = evidence.traction_by_viscosity(light)
    ratio = mu[:1] / mu[1:].max(axis=0, keepdims=True)
    hot = light.inlet_temperature_c >= limits.hot_from_c
    fast = light.entrainment_speed_m_s >= settings.selection.fast_from_m_s
    slipping = light.slide_roll_ratio > slip_limit
    corner = ratio[:, :, fast][:, :, :, hot][..., slipping]
    remark = (
        f"Fast, hot and with a cage slip above {limits.slip_limit:.0%} (S above {slip_limit:.2g}; "
        f"conclusion 4) it has the most at {share(corner > 1):.0%} of the operating points."
    )
    return Outcome(
        cases(light, [""], ratio > 1, ratio),
        f"ratio of mu of {evidence.falling_viscosity[0]} to the largest of the others",
        worst="smallest",
        remarks=[remark] if corner.size else [],
    )


@_check(
    "slip-15",
    "Up to S {selection.slide_roll_ratio_limit:.2g}, which is a cage slip of "
    "{selection.limits.slip_limit:.0%} (selection.reading: {selection.reading}), the least viscous "
    "oil, where its film is thick enough, has the smallest mu; beyond, mu rises with viscosity.",
)
def _slip_limit(evidence: Evidence, grid: Grid, settings: Settings) -> Outcome | None:
    grid = _to_the_end(grid, settings)
    mu, slip_limit = evidence.traction_by_viscosity(grid), settings.selection.slide_roll_ratio_limit
    oil, adequate = _thinnest(evidence, grid)
    slipping = grid.slide_roll_ratio > slip_limit
    least = mu[-1:] / mu[:-1].min(axis=0, keepdims=True)
    ordered = mu[1:] / mu[:-1]
    value = np.where(slipping, ordered.max(axis=0, keepdims=True), least)
    checked = slipping | adequate
    if not checked.any():
        return None
    below, above = value[..., ~slipping][adequate[..., ~slipping]], value[..., slipping]
    return Outcome(
        cases(grid, [""], value < 1, value)[checked.ravel()],
        "ratio of an oil's mu to that of the oil that should have more",
        worst="largest",
        parts={
            f"{oil} heats least up to S {slip_limit:.2g}": below < 1,
            "beyond, traction rises with viscosity": above < 1,
        },
        remarks=[
            f"The film of {oil} is thick enough at {adequate.mean():.0%} of the operating points."
        ],
    )


@_check(
    "heavy-load-4010",
    "From {selection.limits.heavy_from_gpa:g} GPa on the least viscous oil, where its film is "
    "thick enough, has the smallest mu.",
)
def _heavy_load(evidence: Evidence, grid: Grid, settings: Settings) -> Outcome | None:
    heavy = _within(grid, above=settings.selection.limits.heavy_from_gpa, below=np.inf)
    if heavy is None:
        return None
    oil, adequate = _thinnest(evidence, heavy)
    if not adequate.any():
        raise NotCheckableError(f"the film of {oil} is nowhere thick enough under heavy load")
    mu = evidence.traction_by_viscosity(heavy)
    ratio = mu[-1:] / mu[:-1].min(axis=0, keepdims=True)
    return Outcome(
        cases(heavy, [""], ratio < 1, ratio)[adequate.ravel()],
        f"ratio of mu of {oil} to the smallest of the others",
        worst="largest",
        remarks=[f"Its film is thick enough at {adequate.mean():.0%} of the operating points."],
    )


def _of_equation(evidence: Evidence, holds: Callable[[Law], BoolArray]) -> str:
    """Why something is true of every law, whatever its constants; empty where it need not be."""
    laws = {name.law.name: name.law for name in evidence.laws.values()}
    if not all(holds(law).all() for law in laws.values()):
        return ""
    return f"the equation of {', '.join(laws)} makes it so for any constants that it allows"


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


def _within(grid: Grid, *, above: float, below: float) -> Grid | None:
    """The grid with as many levels of pressure in [above, below) only; None if there are none."""
    pressure = grid.max_hertz_pressure_gpa
    low, high = max(above, pressure[0]), min(below, pressure[-1])
    if low >= high:
        return None
    inside = np.geomspace(low, high, len(pressure))
    return grid.at(max_hertz_pressure_gpa=inside[inside < below])


def _thinnest(evidence: Evidence, grid: Grid) -> tuple[str, BoolArray]:
    """The least viscous oil, and where its film is thick enough."""
    oil = evidence.falling_viscosity[-1]
    return oil, evidence.film(oil, grid)[1][np.newaxis] > evidence.lambda_limit


def _range(values: FloatArray, form: str = ".2g") -> str:
    return f"{np.nanmin(values):{form}} to {np.nanmax(values):{form}}"


def _of_rows(rows: pd.DataFrame, holds: pd.Series, value: pd.Series) -> pd.DataFrame:
    """Cases from rows of a table, without conditions."""
    return pd.DataFrame({"oil": rows["oil"], "holds": holds, "value": value})


def _wang_deng(evidence: Evidence) -> pd.DataFrame:
    if evidence.comparison.empty:
        raise NotCheckableError(
            "the paper prints no constants of that form"
            if evidence.basis == "printed"
            else "no laws have been compared for an oil of the paper"
        )
    if evidence.truth_is_law:
        raise NotCheckableError(TIE)
    is_wang_deng = evidence.comparison["law"].str.startswith("wang")
    fits = evidence.comparison[is_wang_deng].dropna(subset="rmse")
    if fits.empty:
        raise NotCheckableError("no law of that form has been fitted")
    return fits


def _torque(evidence: Evidence, basis: str) -> pd.DataFrame:
    if evidence.torque.empty:
        raise NotCheckableError(
            "the paper's torque tests, its bearing (Table 3) and Fig. 6 are not available"
            if evidence.basis == "printed"
            else "there are no torque tests of an oil of the paper"
        )
    control = evidence.torque_control
    misfit, verdicts = control["law_misfit"].max(), set(control["verdict"])
    if "two truths" in verdicts:
        raise NotCheckableError(
            f"the SIMULATED rigs have two truths, {misfit:.0%} of mu apart (audit.twin_misfit_max)"
        )
    if "positive control" in verdicts:
        raise NotCheckableError(
            "the fitted law itself made the SIMULATED logs of both rigs: a positive control of the "
            f"code (error {control['largest_torque_error'].max():.1%} at most)"
        )
    sure = without_bistable(evidence.torque)
    rows = sure[sure["load_variable"] == basis].dropna(subset=["relative_error"])
    if rows.empty:
        raise NotCheckableError(f"no torque was calculated from the {basis}-based law")
    return rows


def _bistable(evidence: Evidence) -> list[str]:
    """The points that are left out, because the cage may roll or skid there."""
    points = bistable_points(evidence.torque)
    return [f"Left out, because the cage may roll or skid: {points}."] if points else []
