"""One check for each claim of the paper, by the claim's id.

A check takes the evidence, a box of operating conditions as a grid, and the settings (`audit` of
the configuration), and returns what it found in every case. Arrays have the axes oil, P, U, T, S,
of length 1 where a case spans an axis.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Self

import numpy as np
import pandas as pd

from oilfilm.settings.base import key
from oilfilm.settings.config import AuditSettings, SelectionLimits
from oilfilm.settings.resolved import Settings
from oilfilm.studies.audit.evidence import BoolArray, Evidence, Finding, NotCheckableError, cases
from oilfilm.studies.operating_grid import AXES, Grid
from oilfilm.units import FloatArray

_P, _U, _T, _S = 1, 2, 3, 4  # axes of the arrays
_MARGIN = "the smaller of lambda and film, each over its limit"


class CheckSettings(AuditSettings, SelectionLimits):
    """Thresholds of the checks: their own, and those that other studies use as well."""

    slide_roll_ratio: list[float] = key("Slide-roll ratios of the trends.")
    curve_to: float = key("Largest slide-roll ratio of a curve.")
    linear_r2_min: float = key("R2 of a straight line that counts as linear.")
    decline_max: float = key("Share of the peak that a slight decline may lose.")

    @classmethod
    def of(cls, settings: Settings) -> Self:
        """The thresholds of a campaign."""
        signs, tested = settings.printed.signs, settings.printed.boxes.tested
        return cls(
            **settings.audit.model_dump(),
            **settings.selection.limits.model_dump(),
            slide_roll_ratio=signs.slide_roll_ratio.figures,
            curve_to=tested.slide_roll_ratio[1],
            linear_r2_min=signs.linear_r2_min,
            decline_max=signs.decline_max,
        )


@dataclass(frozen=True)
class Check:
    """How a claim is checked.

    Attributes:
        judge: Finds the cases; None where the box has none for the claim.
        where: Box on which the verdict rests, `tested` or `extrapolated`, or `data` where the check
            looks at tables and no box.
        definition: What would make the claim hold, with names of settings in braces.
    """

    judge: Callable[[Evidence, Grid, CheckSettings], Finding | None]
    where: str
    definition: str


def zero_slip(evidence: Evidence, grid: Grid, settings: CheckSettings) -> Finding:
    """mu = 0 at S = 0."""
    still = grid.at(slide_roll_ratio=[0.0])
    mu = np.abs(evidence.traction(still))
    found = cases(still, evidence.oils, mu <= settings.zero_traction_max, mu, worst="largest")
    return Finding(found, "|mu| at no slip")


def non_negative(evidence: Evidence, grid: Grid, settings: CheckSettings) -> Finding:
    """mu >= 0."""
    curve = grid.at(slide_roll_ratio=_curve(settings)[1:])
    mu = evidence.traction(curve).min(axis=_S, keepdims=True)
    found = cases(curve, evidence.oils, mu >= 0, mu, worst="smallest")
    return Finding(found, "smallest mu of a curve beyond no slip", ".2g")


def linear_start(evidence: Evidence, grid: Grid, settings: CheckSettings) -> Finding:
    """The linear range reaches the first slip that the rig sets."""
    end = _linear_range(evidence, grid, settings)
    found = cases(grid, evidence.oils, end >= settings.linear_to_slip, end, worst="smallest")
    return Finding(found, "end of the linear range, S", remarks=[f"It ends at S {_range(end)}."])


def peak_decline(evidence: Evidence, grid: Grid, settings: CheckSettings) -> Finding:
    """mu peaks within the slips of the rig and has lost little at their end."""
    slip = _curve(settings)
    mu = evidence.traction(grid.at(slide_roll_ratio=slip))
    peak = mu.max(axis=_S, keepdims=True)
    peaks = np.argmax(mu, axis=_S, keepdims=True) < len(slip) - 1
    decline = 1 - mu[..., -1:] / peak
    slight = decline <= settings.decline_max
    return Finding(
        cases(grid, evidence.oils, peaks & slight, decline, worst="largest"),
        f"loss between the peak and S {slip[-1]:g}",
        ".0%",
        _parts({"a peak": peaks, "a slight decline or none": slight}),
        [
            f"At {grid.inlet_temperature_c[0]:g} degC the loss is "
            f"{_range(of_oil[:, :, 0], '.0%')} for {oil}."
            for oil, of_oil in zip(evidence.oils, decline, strict=True)
        ],
    )


def falls_with_temperature(evidence: Evidence, grid: Grid, settings: CheckSettings) -> Finding:
    """mu falls from each level of T to the next, by more a degree when cold than when hot."""
    mu = evidence.traction(grid)
    box = grid.inlet_temperature_c[0], grid.inlet_temperature_c[-1]
    cold, hot = (np.clip(band, *box) for band in (settings.cold_band_c, settings.hot_band_c))
    at_cold, at_hot = (
        -np.diff(evidence.traction(grid.at(inlet_temperature_c=band)), axis=_T) / np.diff(band)
        for band in (cold, hot)
    )
    steeper = at_cold > at_hot
    always = _falls(mu, _T)
    left = _last_over_first(mu, _T)
    return Finding(
        cases(grid, evidence.oils, always & steeper, left, worst="largest"),
        f"mu at {box[1]:g} degC over mu at {box[0]:g} degC",
        ".2f",
        _parts(
            {
                "mu falls at every step": always,
                f"steeper at {_ends(cold)} than at {_ends(hot)} degC": steeper,
            }
        ),
    )


def falls_with_speed(evidence: Evidence, grid: Grid, settings: CheckSettings) -> Finding:
    """mu falls from each level of U to the next, by more over the first third than the last."""
    mu = evidence.traction(grid)
    always = _falls(mu, _U)
    speed = grid.entrainment_speed_m_s
    thirds = evidence.traction(grid.at(entrainment_speed_m_s=np.linspace(speed[0], speed[-1], 4)))
    fall = -np.diff(thirds, axis=_U)
    levels_off = np.abs(fall[:, :, 2:]) < fall[:, :, :1]
    left = _last_over_first(mu, _U)
    return Finding(
        cases(grid, evidence.oils, always & levels_off, left, worst="largest"),
        f"mu at {speed[-1]:g} m/s over mu at {speed[0]:g} m/s",
        ".2f",
        _parts({"mu falls at every step": always, "it levels off": levels_off}),
    )


def rises_with_stress(evidence: Evidence, grid: Grid, settings: CheckSettings) -> Finding:
    """mu rises from each level of P to the next, along a straight line."""
    pressure = grid.max_hertz_pressure_gpa
    even = grid.at(max_hertz_pressure_gpa=np.linspace(pressure[0], pressure[-1], len(pressure)))
    mu = evidence.traction(even)
    always = _falls(-mu, _P)
    r2 = _r_squared(even.max_hertz_pressure_gpa, mu, _P)
    straight = r2 >= settings.linear_r2_min
    return Finding(
        cases(grid, evidence.oils, always & straight, r2, worst="smallest"),
        "R2 of the straight line mu(P)",
        ".2f",
        _parts({"mu rises at every step": always, "straight enough": straight}),
        [
            f"R2 is {np.nanmedian(of_oil):.2f} in the median for {oil}."
            for oil, of_oil in zip(evidence.oils, r2, strict=True)
        ],
    )


def earlier_plateau(evidence: Evidence, grid: Grid, settings: CheckSettings) -> Finding:
    """The linear range ends at smaller slip from each level of P to the next."""
    end = _linear_range(evidence, grid, settings)
    always = _falls(end, _P)
    pressure = grid.max_hertz_pressure_gpa
    slip = _curve(settings)
    temperatures = grid.inlet_temperature_c[[0, -1]]
    mu = evidence.traction(grid.at(inlet_temperature_c=temperatures, slide_roll_ratio=slip))
    reached = mu >= settings.plateau_share * mu.max(axis=_S, keepdims=True)
    begin = slip[np.argmax(reached, axis=_S)]
    return Finding(
        cases(grid, evidence.oils, always, _last_over_first(end, _P), worst="largest"),
        f"end of the linear range at {pressure[-1]:g} GPa over that at {pressure[0]:g} GPa",
        ".2f",
        remarks=[
            f"{settings.plateau_share:.0%} of the peak is reached at S "
            f"{np.median(of_oil[:, :, 0]):.2g} at {temperatures[0]:g} degC and at S "
            f"{np.median(of_oil[:, :, 1]):.2g} at {temperatures[1]:g} degC for {oil}."
            for oil, of_oil in zip(evidence.oils, begin, strict=True)
        ],
    )


def viscosity_order(evidence: Evidence, grid: Grid, settings: CheckSettings) -> Finding:
    """mu falls from each oil to the next less viscous one."""
    oils = evidence.falling_viscosity
    mu = evidence.traction_by_viscosity(grid)
    ratios = mu[:-1] / mu[1:]
    found = cases(
        grid,
        [""],
        np.asarray((ratios > 1).all(axis=0, keepdims=True)),
        ratios.min(axis=0, keepdims=True),
        worst="smallest",
    )
    parts = {
        f"{thick} > {thin}": pair > 1
        for thick, thin, pair in zip(oils[:-1], oils[1:], ratios, strict=True)
    }
    orders = np.argsort(-mu, axis=0).reshape(len(oils), -1).T
    kinds, counts = np.unique(orders, axis=0, return_counts=True)
    commonest = " > ".join(oils[place] for place in kinds[counts.argmax()])
    pressure = grid.max_hertz_pressure_gpa
    # the places of one pressure have one number: their geometric mean, as ratios need
    ends = np.exp(np.log(mu[-1] / mu[0]).mean(axis=(1, 2, 3)))[[0, -1]]
    remarks = [
        f"The commonest order is {commonest} ({counts.max() / len(orders):.0%}).",
        f"{oils[-1]}/{oils[0]} is {ends[0]:.2f} at {pressure[0]:g} GPa and {ends[1]:.2f} at "
        f"{pressure[-1]:g} GPa in the mean.",
    ]
    first = (ratios[0] > 1).mean(axis=(1, 2, 3))
    if first[0] < 0.5 < first[-1] and (np.diff(first) >= 0).all():
        turn = np.interp(0.5, first, pressure)
        remarks.append(f"{oils[1]} is above {oils[0]} at most places below {turn:.1f} GPa.")
    return Finding(
        found,
        "smallest ratio of an oil's mu to that of the next thinner oil",
        ".2f",
        _parts(parts),
        remarks,
    )


def hot_convergence(evidence: Evidence, grid: Grid, settings: CheckSettings) -> Finding:
    """The relative spread of the oils is smaller at the hottest level than at the coldest."""
    temperatures = grid.inlet_temperature_c[[0, -1]]
    mu = evidence.traction_by_viscosity(grid.at(inlet_temperature_c=temperatures))
    spread = mu.max(axis=0, keepdims=True) - mu.min(axis=0, keepdims=True)
    relative = spread / mu.mean(axis=0, keepdims=True)
    ratio = relative[:, :, :, 1:] / relative[:, :, :, :1]
    cold, hot = relative.mean(axis=(0, 1, 2, 4))
    nearer = (spread[:, :, :, 1:] < spread[:, :, :, :1]).mean()
    return Finding(
        cases(grid, [""], ratio <= settings.convergence_max, ratio, worst="largest"),
        "relative spread hot over cold",
        ".2f",
        {"any decrease at all": float((ratio < 1).mean())},
        [
            f"The spread over the mean is {cold:.2f} at {temperatures[0]:g} degC and {hot:.2f} at "
            f"{temperatures[1]:g} degC on average; the plain difference of mu shrinks at "
            f"{nearer:.0%} of the places, as mu itself does."
        ],
    )


def speed_mutes_temperature(evidence: Evidence, grid: Grid, settings: CheckSettings) -> Finding:
    """Over the range of T, mu falls by less at the high speed than at the low one."""
    speeds = np.clip(
        settings.slow_and_fast_m_s,
        grid.entrainment_speed_m_s[0],
        grid.entrainment_speed_m_s[-1],
    )
    temperatures = grid.inlet_temperature_c[[0, -1]]
    mu = evidence.traction(grid.at(entrainment_speed_m_s=speeds, inlet_temperature_c=temperatures))
    drop = mu[:, :, :, :1] - mu[:, :, :, 1:]
    ratio = drop[:, :, 1:] / drop[:, :, :1]
    relative = drop / mu[:, :, :, :1]
    milder = (relative[:, :, 1:] < relative[:, :, :1]).mean()
    return Finding(
        cases(grid, evidence.oils, ratio < 1, ratio, worst="largest"),
        f"fall of mu at {speeds[1]:g} m/s over that at {speeds[0]:g} m/s",
        ".2f",
        remarks=[f"Relative to mu itself the fall is milder at {milder:.0%} of the places."],
    )


def full_film(evidence: Evidence, grid: Grid, settings: CheckSettings) -> Finding:
    """lambda above its limit and the film above the thickness that the paper states."""
    if evidence.points is not None:
        return _measured_film(evidence, settings)
    curve = grid.at(slide_roll_ratio=[0.0, *settings.slide_roll_ratio, settings.curve_to])
    films = [evidence.film(oil, curve) for oil in evidence.falling_viscosity]
    thickness, ratio = (np.stack(part) for part in zip(*films, strict=True))
    full, thick = ratio > evidence.lambda_limit, thickness > settings.film_min_um
    margin = np.minimum(ratio / evidence.lambda_limit, thickness / settings.film_min_um)
    found = cases(curve, evidence.falling_viscosity, full & thick, margin, worst="smallest")
    parts = _parts({f"lambda > {evidence.lambda_limit:g}": full, _film_words(settings): thick})
    remark = f"Calculated for stand-in oils; the thinnest film is {np.nanmin(thickness):.3f} um."
    return Finding(found, _MARGIN, ".2f", parts, [remark])


def wang_deng_zero(evidence: Evidence, grid: Grid, settings: CheckSettings) -> Finding:
    """Every Wang-Deng fit leaves mu(0) different from zero."""
    fits = _wang_deng(evidence)
    found = fits.assign(value=fits["zero_slip_traction"].abs())
    found = found.assign(
        holds=found["value"] > settings.zero_traction_max, shortfall=-found["value"]
    )
    remarks = [
        f"Largest |mu(0)| of {row['oil']} by {row['law']}: {row['value']:.2g}."
        for row in found.to_dict("records")
    ]
    return Finding(_without_axes(found), "|mu| at no slip", remarks=remarks)


def wang_deng_overfit(evidence: Evidence, grid: Grid, settings: CheckSettings) -> Finding:
    """Curves left out are missed by more, against the fit's own error, than by the paper's law."""
    fits = _wang_deng(evidence)
    every = _compared(evidence)
    own = every[every["law"] == settings.stress_law].set_index("oil")
    if not set(fits["oil"]) <= set(own.index):
        raise NotCheckableError(f"the comparison has no fit by {settings.stress_law}")
    growth = fits["left_out_rmse"] / fits["rmse"]
    base = fits["oil"].map(own["left_out_rmse"] / own["rmse"])
    found = fits.assign(value=growth / base)
    found = found.assign(holds=found["value"] > settings.overfit_min, shortfall=-found["value"])
    remarks = [
        f"{row['oil']} by {row['law']}: error {row['rmse']:.2g} on its own curves, "
        f"{row['left_out_rmse']:.2g} on curves left out."
        for row in fits.to_dict("records")
    ]
    quantity = "growth of the error on curves left out, over that of the paper's law"
    return Finding(_without_axes(found), quantity, ".2f", remarks=remarks)


def torque_stress(evidence: Evidence, grid: Grid, settings: CheckSettings) -> Finding:
    """The stress-based torque is nowhere farther off than the paper says."""
    rows = _torque(evidence, "stress")
    found = rows.assign(value=rows["relative_error"].abs())
    limit = settings.torque_stress_error
    found = found.assign(holds=found["value"] <= limit, shortfall=found["value"])
    return Finding(
        _without_axes(found),
        "relative error of the torque",
        ".1%",
        remarks=[f"The largest error is {found['value'].max():.1%}; the paper has {limit:.2%}."],
    )


def torque_load(evidence: Evidence, grid: Grid, settings: CheckSettings) -> Finding:
    """The load-based torque is farther off than the stress-based one, and reaches 249 %."""
    point = ["run_id", "first_row", "oil"]
    by_load, by_stress = (
        _torque(evidence, basis).set_index(point)["relative_error"].abs()
        for basis in ("load", "stress")
    )
    both = pd.DataFrame({"load": by_load, "stress": by_stress}).dropna().reset_index()
    if both.empty:
        raise NotCheckableError("no operating point was calculated by both bases")
    excess = both["load"] - both["stress"]
    found = both.assign(value=excess, holds=excess > 0, shortfall=-excess)
    limit, largest = settings.torque_load_error, both["load"].max()
    return Finding(
        _without_axes(found),
        "relative error by the load less that by the stress",
        ".1%",
        remarks=[f"The largest load-based error is {largest:.1%}; the paper has {limit:.0%}."],
        complete=bool(largest >= limit),
    )


def light_load(evidence: Evidence, grid: Grid, settings: CheckSettings) -> Finding | None:
    """Under light load the most viscous oil has the most traction."""
    light = _within(grid, above=-np.inf, below=settings.light_below_gpa)
    if light is None:
        return None
    mu = evidence.traction_by_viscosity(light)
    ratio = mu[:1] / mu[1:].max(axis=0, keepdims=True)
    remarks = []
    hot = light.inlet_temperature_c >= settings.hot_from_c
    fast = light.entrainment_speed_m_s >= settings.fast_from_m_s
    slipping = light.slide_roll_ratio > settings.slip_limit
    corner = ratio[0][np.ix_(np.ones(len(ratio[0]), dtype=bool), fast, hot, slipping)]
    if corner.size:
        remarks.append(
            f"Fast, hot and slipping by more than {settings.slip_limit:.0%} (conclusion 4) it "
            f"has the most at {(corner > 1).mean():.0%} of the places."
        )
    oils = evidence.falling_viscosity
    return Finding(
        cases(light, [""], ratio > 1, ratio, worst="smallest"),
        f"mu of {oils[0]} over the largest of the others",
        ".2f",
        remarks=remarks,
    )


def slip_limit(evidence: Evidence, grid: Grid, settings: CheckSettings) -> Finding | None:
    """Below the limit of slip the thinnest oil heats least; above it viscosity gives traction."""
    mu = evidence.traction_by_viscosity(grid)
    oils = evidence.falling_viscosity
    adequate = evidence.film(oils[-1], grid)[1][np.newaxis] > evidence.lambda_limit
    slipping = grid.slide_roll_ratio > settings.slip_limit
    least = mu[-1:] / mu[:-1].min(axis=0, keepdims=True)
    ordered = mu[1:] / mu[:-1]
    value = np.where(slipping, ordered.max(axis=0, keepdims=True), least)
    asked = slipping | adequate
    if not asked.any():
        return None
    found = cases(grid, [""], value < 1, value, worst="largest")[asked.ravel()]
    below, above = value[..., ~slipping][adequate[..., ~slipping]], value[..., slipping]
    parts = {f"{oils[-1]} heats least up to {settings.slip_limit:.0%} slip": _share(below < 1)}
    parts |= {"traction rises with viscosity beyond": _share(above < 1)}
    return Finding(
        found, "mu over that of the oil that should have more", ".2f", parts,
        [f"The film of {oils[-1]} is thick enough at {adequate.mean():.0%} of the places."],
    )  # fmt: skip


def heavy_load(evidence: Evidence, grid: Grid, settings: CheckSettings) -> Finding | None:
    """Under heavy load, where its film is thick enough, the thinnest oil heats least."""
    heavy = _within(grid, above=settings.heavy_from_gpa, below=np.inf)
    if heavy is None:
        return None
    oils = evidence.falling_viscosity
    adequate = evidence.film(oils[-1], heavy)[1][np.newaxis] > evidence.lambda_limit
    mu = evidence.traction_by_viscosity(heavy)
    ratio = mu[-1:] / mu[:-1].min(axis=0, keepdims=True)
    found = cases(heavy, [""], ratio < 1, ratio, worst="largest")[adequate.ravel()]
    if found.empty:
        raise NotCheckableError(f"the film of {oils[-1]} is nowhere thick enough under heavy load")
    return Finding(
        found,
        f"mu of {oils[-1]} over the smallest of the others",
        ".2f",
        remarks=[f"Its film is thick enough at {adequate.mean():.0%} of the places."],
    )


CHECKS: dict[str, Check] = {
    "zero-slip": Check(
        zero_slip, "extrapolated", "|mu| is {zero_traction_max:g} at most wherever S is 0."
    ),
    "non-negative": Check(
        non_negative, "extrapolated", "mu is 0 or more for every S up to {curve_to:g}."
    ),
    "linear-start": Check(
        linear_start,
        "tested",
        "Up to S {linear_to_slip:g}, the first slip that the rig sets, mu/S stays within "
        "{linear_tolerance:.0%} of its value at no slip.",
    ),
    "peak-decline": Check(
        peak_decline,
        "tested",
        "mu has its largest value below S {curve_to:g}, and there it has lost {decline_max:.0%} of "
        "it at most.",
    ),
    "falls-with-temperature": Check(
        falls_with_temperature,
        "extrapolated",
        "mu falls from each level of T to the next, and by more a degree at {cold_band_c[0]:g}-"
        "{cold_band_c[1]:g} degC than at {hot_band_c[0]:g}-{hot_band_c[1]:g} degC.",
    ),
    "falls-with-speed": Check(
        falls_with_speed,
        "extrapolated",
        "mu falls from each level of U to the next, and over the last third of the speeds changes "
        "by less than it falls over the first.",
    ),
    "rises-with-stress": Check(
        rises_with_stress,
        "extrapolated",
        "mu rises from each level of P to the next, and a straight line through mu(P) has R2 of "
        "{linear_r2_min:g} or more.",
    ),
    "earlier-plateau": Check(
        earlier_plateau,
        "extrapolated",
        "The linear range (mu/S within {linear_tolerance:.0%} of its value at no slip) ends at "
        "smaller S from each level of P to the next.",
    ),
    "viscosity-order": Check(
        viscosity_order,
        "extrapolated",
        "At the same P, U, T and S mu falls from each oil to the next less viscous one.",
    ),
    "hot-convergence": Check(
        hot_convergence,
        "extrapolated",
        "The oils' spread of mu over their mean is at the hottest level {convergence_max:.0%} of "
        "that at the coldest, or less.",
    ),
    "speed-mutes-temperature": Check(
        speed_mutes_temperature,
        "extrapolated",
        "From the coldest to the hottest level mu falls by less at {slow_and_fast_m_s[1]:g} m/s "
        "than at {slow_and_fast_m_s[0]:g} m/s (or at the box's own ends).",
    ),
    "full-film": Check(
        full_film,
        "tested",
        "lambda lies above gates.lambda_limit and the film above {film_min_um:g} um; the refit "
        "asks the campaign's own points, the printed basis the whole tested box.",
    ),
    "wang-deng-zero": Check(
        wang_deng_zero, "data", "|mu(0)| of every fit by that form is above {zero_traction_max:g}."
    ),
    "wang-deng-overfit": Check(
        wang_deng_overfit,
        "data",
        "From fitted curves to curves left out the error grows more than {overfit_min:g} times as "
        "much as that of the paper's own law.",
    ),
    "torque-stress": Check(
        torque_stress,
        "data",
        "The calculated torque is off by {torque_stress_error:.2%} at most at every operating "
        "point.",
    ),
    "torque-load": Check(
        torque_load,
        "data",
        "At every operating point the load-based torque is farther off than the stress-based one; "
        "in part only, if its largest error stays below {torque_load_error:.0%}.",
    ),
    "light-load-4102": Check(
        light_load,
        "extrapolated",
        "Below {light_below_gpa:g} GPa the most viscous oil has the largest mu.",
    ),
    "slip-15": Check(
        slip_limit,
        "extrapolated",
        "Up to S {slip_limit:g} the least viscous oil, where its film is thick enough, has the "
        "smallest mu; beyond, mu rises with viscosity.",
    ),
    "heavy-load-4010": Check(
        heavy_load,
        "extrapolated",
        "From {heavy_from_gpa:g} GPa on the least viscous oil, where its film is thick enough, has "
        "the smallest mu.",
    ),
}


def _curve(settings: CheckSettings) -> FloatArray:
    """Slips of a whole curve."""
    return np.linspace(0.0, settings.curve_to, settings.curve_points)


def _linear_range(evidence: Evidence, grid: Grid, settings: CheckSettings) -> FloatArray:
    """Slip at which mu/S has left its value at no slip by the tolerance; the last slip if never."""
    # the slope at no slip is that over a slip a thousand times below the first step of the curve
    slip = np.concatenate([[_curve(settings)[1] * 1e-3], _curve(settings)[1:]])
    chord = evidence.traction(grid.at(slide_roll_ratio=slip)) / slip
    left = np.abs(chord / chord[..., :1] - 1)
    beyond = left > settings.linear_tolerance
    after = np.where(beyond.any(axis=_S), np.argmax(beyond, axis=_S), len(slip) - 1)
    # between the last slip inside and the first outside, in a straight line
    inside, outside = (
        np.take_along_axis(left, place[..., np.newaxis], axis=_S)[..., 0]
        for place in (after - 1, after)
    )
    way = np.divide(
        settings.linear_tolerance - inside,
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


def _parts(parts: Mapping[str, BoolArray]) -> dict[str, float]:
    return {name: _share(holds) for name, holds in parts.items()}


def _share(holds: BoolArray) -> float:
    return float(holds.mean()) if holds.size else np.nan


def _range(values: FloatArray, form: str = ".2g") -> str:
    return f"{np.nanmin(values):{form}} to {np.nanmax(values):{form}}"


def _ends(band: FloatArray) -> str:
    return f"{band[0]:g}-{band[1]:g}"


def _film_words(settings: CheckSettings) -> str:
    return f"film > {settings.film_min_um:g} um"


def _measured_film(evidence: Evidence, settings: CheckSettings) -> Finding:
    if evidence.points is None:
        raise NotCheckableError("the printed constants have no measured points")
    points = evidence.points.dropna(subset=["lambda_ratio"]).reset_index(drop=True)
    if points.empty:
        raise NotCheckableError("no point of the campaign has a lambda")
    full = points["lambda_ratio"] > evidence.lambda_limit
    thick = points["film_thickness_um"] > settings.film_min_um
    margin = np.minimum(
        points["lambda_ratio"] / evidence.lambda_limit,
        points["film_thickness_um"] / settings.film_min_um,
    )
    found = points.assign(holds=full & thick, value=margin, shortfall=-margin)
    parts = {
        f"lambda > {evidence.lambda_limit:g}": float(full.mean()),
        _film_words(settings): float(thick.mean()),
    }
    thinnest = points["film_thickness_um"].min()
    remark = f"Calculated for the points' own conditions; the thinnest film is {thinnest:.3f} um."
    return Finding(_without_axes(found, *AXES), _MARGIN, ".2f", parts, [remark])


def _without_axes(found: pd.DataFrame, *known: str) -> pd.DataFrame:
    """Cases from rows of a table: null on the axes that it does not have."""
    kept = found.reindex(columns=["oil", *AXES, "holds", "value", "shortfall"])
    kept[[name for name in AXES if name not in known]] = np.nan
    return kept.reset_index(drop=True)


def _compared(evidence: Evidence) -> pd.DataFrame:
    if evidence.comparison.empty:
        raise NotCheckableError(
            "the paper prints no constants of that form"
            if evidence.basis == "printed"
            else "the laws of this campaign have not been compared"
        )
    return evidence.comparison


def _wang_deng(evidence: Evidence) -> pd.DataFrame:
    every = _compared(evidence)
    fits = every[every["law"].str.startswith("wang")].dropna(subset="rmse").reset_index(drop=True)
    if fits.empty:
        raise NotCheckableError("no law of that form has been fitted")
    return fits


def _torque(evidence: Evidence, basis: str) -> pd.DataFrame:
    if evidence.torque.empty:
        raise NotCheckableError(
            "the paper's torque tests, its bearing (Table 3) and Fig. 6 are not available"
            if evidence.basis == "printed"
            else "the campaign has no torque tests"
        )
    rows = evidence.torque[evidence.torque["load_variable"] == basis].dropna(
        subset=["relative_error"]
    )
    if rows.empty:
        raise NotCheckableError(f"no torque was calculated from the {basis}-based law")
    return rows.reset_index(drop=True)
