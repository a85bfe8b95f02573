"""The search, its certificate, intervals and comparison of laws."""

import numpy as np
from matplotlib.figure import Figure

from examples import settings, simulated_fit, simulated_points
from oilfilm.fits.fit import errors_at_curves_left_out
from oilfilm.fits.global_search import Optimum, converge, population_sse, search
from oilfilm.fits.problem import Problem, build_problem, curve_data
from oilfilm.fits.uncertainty import naive_covariance, profiles
from oilfilm.traction.law import to_internal
from style import BLUE, GREY, ORANGE, RED, axes, row


def searches() -> Figure:
    """A random population, and where searches from it end."""
    figure, one = axes(xlabel="ln |A0| (1)", ylabel="ln B0 (1)")
    problem, best = fitted_problem()
    random = np.random.default_rng(3)
    low, high = problem.free_bounds.T
    population = random.uniform(low, high, (4000, len(low)))
    sse = population_sse(problem, population)
    names = list(problem.free_names)
    x, y = names.index("A0"), names.index("B0")
    order = np.argsort(-sse)
    shown = one.scatter(
        population[order, x], population[order, y], c=np.log10(sse[order] / best.sse), s=6,
        cmap="cividis",
    )  # fmt: skip
    randoms = [np.random.default_rng(seed) for seed in range(5)]
    ends = [end.constants for end in search(problem, settings().fit, randoms)]
    one.plot(*np.transpose(ends)[[x, y]], "*", color=RED, ms=14, label="ends of five searches")
    figure.colorbar(shown, label="log10 of SSE over the best SSE (1)")
    one.legend(loc="upper left", frameon=True)
    return figure


def profile() -> Figure:
    """Profile of two constants."""
    figure, two = row(2)
    problem, best = fitted_problem()
    naive = naive_covariance(problem, best)
    errors = np.sqrt(np.diag(naive))
    values, z = profiles(problem, best, naive)
    for one, name in zip(two, ("A1", "B3"), strict=True):
        at = list(problem.free_names).index(name)
        one.plot(values[at], z[at], "o-", ms=3, label="profile")
        one.plot(values[at], (values[at] - best.constants[at]) / errors[at], ":", color=GREY,
                 label="linear law")  # fmt: skip
        one.axhspan(-1.96, 1.96, color=ORANGE, alpha=0.2)
        one.set(xlabel=f"{name} (1)", ylabel="Signed root of the rise z (1)")
        one.legend()
    return figure


def bootstrap() -> Figure:
    """Constants of refits to resampled curves, beside the naive error."""
    figure, one = axes(xlabel="Exponent of temperature C3 (1)", ylabel="Refits (1)")
    fit = simulated_fit()
    refits = fit.tables.refits
    values = (
        refits.loc[refits["constant"] == "C3", "value"] if "constant" in refits else refits["C3"]
    )
    one.hist(values, 25, color=BLUE, alpha=0.7)
    low, high = fit.constants.loc["C3", ["lower", "upper"]]
    one.axvspan(low, high, color=ORANGE, alpha=0.25, label="95 % interval")
    one.axvline(fit.constants.loc["C3", "value"], color=RED, label="fit")
    one.legend()
    return figure


def residuals() -> Figure:
    """Residuals by curve: points of one curve share errors."""
    figure, one = axes(xlabel="Slide-roll ratio S (1)", ylabel="Residual of mu (%)")
    points = simulated_points()
    predicted = simulated_fit().predict(*(points[name] for name in ("P", "U", "T", "S")))
    error = 100 * (points["mu"] / predicted.traction_coefficient - 1)
    for number, (_, curve) in enumerate(points.groupby("curve")):
        chosen = number % 6 == 0
        style = {"color": f"C{number // 6}", "lw": 2} if chosen else {"color": "0.8", "lw": 0.8}
        one.plot(curve["S"], error[curve.index], zorder=2 if chosen else 1, **style)
    one.axhline(0, color="black", lw=0.8)
    return figure


def band() -> Figure:
    """A prediction with its interval, inside and outside the tests."""
    figure, one = axes(xlabel="Inlet temperature T (°C)", ylabel="Traction coefficient mu (1)")
    temperature = np.linspace(10, 180, 120)
    prediction = simulated_fit().predict(1.25, 40.0, temperature, 0.05)
    one.plot(temperature, prediction.traction_coefficient, label="fit")
    one.fill_between(
        temperature,
        prediction.obs_ci_lower,
        prediction.obs_ci_upper,
        alpha=0.3,
        label="95 % interval",
    )
    one.axvspan(25, 120, color=ORANGE, alpha=0.12, label="tested")
    one.legend()
    return figure


def left_out() -> Figure:
    """Error at each curve that was left out."""
    figure, one = axes(xlabel="Curve left out", ylabel="rms error of mu (%)")
    problem, best = fitted_problem()
    errors = errors_at_curves_left_out(problem, best, settings().fit, np.random.default_rng(0))
    curve = problem.observations.curve_of_point
    unseen = [rms(errors[curve == each] / problem.mu[curve == each]) for each in np.unique(curve)]
    fitted = problem.residual(best.constants)
    seen = [rms(fitted[curve == each] / problem.mu[curve == each]) for each in np.unique(curve)]
    place = np.arange(1, len(seen) + 1)
    one.set_xticks(place)
    one.bar(place - 0.2, seen, 0.4, color=GREY, label="in the fit")
    one.bar(place + 0.2, unseen, 0.4, color=BLUE, label="left out")
    one.legend()
    return figure


def fitted_problem() -> tuple[Problem, Optimum]:
    """What the simulated fit minimised, and where it ended."""
    fit = simulated_fit()
    law, coefficients = fit.law.law, fit.law.coefficients
    data = curve_data(fit.campaign_points, law.conditions)
    problem = build_problem(law, data, coefficients.group_has_exponent)
    start = to_internal(law, coefficients.constants)[problem.is_free]
    return problem, converge(problem, start)


def rms(values: np.ndarray) -> float:
    """Root mean square in percent."""
    return 100 * float(np.sqrt(np.mean(values**2)))
