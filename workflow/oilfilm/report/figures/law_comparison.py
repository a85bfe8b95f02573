"""The Wang-Deng law as the paper shows it (Fig. 4), and the errors of all laws compared."""

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Patch
from matplotlib.ticker import FuncFormatter, LogLocator, MaxNLocator, NullFormatter

from oilfilm import tables
from oilfilm.fits.fitted import FittedLaw
from oilfilm.fits.law_comparison import laws_of
from oilfilm.fits.problem import curve_data
from oilfilm.report.captions import tie
from oilfilm.report.figures import style
from oilfilm.report.figures.registry import Drawing, drawn_table, register
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.tables.columns import use
from oilfilm.traction import PAPER_LAW
from oilfilm.traction.law import CONDITIONS

_MU = "\N{GREEK SMALL LETTER MU}"
_TIMES = "\N{MULTIPLICATION SIGN} 10$^{-3}$"
_WANG_DENG = "wang-deng"  # how the names of its readings begin
_OURS = "Wang-Deng laws: groups and readings are ours."
_OPEN = "Open symbols: fit not certified (table comparison says why)."
_DASHES: dict[str, Any] = {"fit": "-", "left out": (0, (4, 2)), "Eq. 7": ":"}

_WANG_DENG_CURVES = drawn_table(
    "wang_deng_curves",
    "Drawn in Fig. 4: one row per plateau or vertex of a line.",
    columns="""
        panel oil law run_id series certified active_bounds slide_roll_ratio traction_coefficient
        traction_coefficient_se""",
    uses=(
        use("law", "of the line; of points the Wang-Deng law beside them"),
        use(
            "series",
            "measured: points; fit: to all curves; zero slip: its mu at S = 0; left out: fit to "
            "all curves but this one",
            allowed=("measured", "fit", "zero slip", "left out"),
        ),
        use("certified", "of the law's fit"),
        use("active_bounds", "of the law's fit"),
        use("slide_roll_ratio", "abscissa", required=True, at_least=0),
        use("traction_coefficient", "ordinate", required=True),
        use(
            "traction_coefficient_se",
            "the bar drawn is 1.96 times as long to either side; none where null",
        ),
    ),
)


@register(
    name="fig04",
    paper="Fig. 4",
    title="The Wang-Deng law at zero slip and on a curve left out",
    caption="Measured traction coefficient against slide-roll ratio, and the Wang-Deng law "
    "fitted to the same oil. Each oil has one curve, chosen by a rule among all tested curves "
    "and all versions of the law. (a) Curve with the largest traction coefficient at zero slip; "
    "below: detail near zero slip. (b) Curve whose rms error grows most when the fit leaves it "
    "out; below: the errors. Full lines: fit to all curves. Dashed lines: fit without this "
    "curve. Dotted lines: law of the paper (Eq. 7), fitted without this curve. Symbols: plateau "
    "means with the 95 % interval of their random error.",
    family="law",
    tables=("points", "comparison", "law_coefficients", "law_points"),
    settings=("oils", "rigs"),
    compares_laws=True,
    draws=_WANG_DENG_CURVES,
)
def fig04(results: CampaignTables, settings: Settings) -> Drawing:
    """Left, the largest traction without slip; right, the largest growth of an error."""
    fits = results.comparison.dropna(subset="rmse")
    figure = Figure(figsize=(style.DOUBLE_COLUMN_IN, 5.2))
    ((whole, near), (unseen, errors)) = figure.subplots(2, 2, height_ratios=(1.15, 1)).T
    style.title_panel(whole, 0, f"Curve with the largest |{_MU}(0)|")
    near.set_title("    near S = 0")
    # numbers of many decimals: few of them fit
    near.xaxis.set_major_locator(MaxNLocator(4))
    style.title_panel(unseen, 1, "Curve with the largest growth of error")
    errors.set_title("    fitted minus measured")
    drawn: list[pd.DataFrame] = []
    for oil in settings.oils:
        of_oil = fits[fits["oil"] == oil].set_index("law", drop=False)
        drawn += _draw_zero_slip(whole, near, oil, of_oil, results, settings)
        drawn += _draw_left_out(unseen, errors, oil, of_oil, results, settings)
    for above, below in ((whole, near), (unseen, errors)):
        if below.get_legend_handles_labels()[0]:
            below.legend(loc="upper left", bbox_to_anchor=(-0.12, -0.25), fontsize=6)
        else:
            style.say_in_panel(above, "no Wang-Deng law could be fitted")
        below.set_xlabel(style.CONDITION_LABELS["slide_roll_ratio"])
    _zoom(near, drawn)
    whole.set_ylabel(style.TRACTION_LABEL)
    near.set_ylabel(f"{_MU} (10$^{{-3}}$)")
    errors.set_ylabel(f"\N{GREEK CAPITAL LETTER DELTA}{_MU} (10$^{{-3}}$)")
    figure.legend(handles=_key_of_lines(), loc="outside lower center", ncols=5, fontsize=6)
    style.say_key(figure, _sentences(_OURS, tie(settings.campaign)))
    return figure, drawn


def _zoom(axis: Axes, parts: Sequence[pd.DataFrame]) -> None:
    """Show what is near zero slip: a few times the largest mu(0), as far as the slowest rise."""
    axis.axhline(0, color="black", linewidth=0.6)
    if not parts:
        return
    drawn = pd.concat(parts)
    mu = drawn.loc[drawn["series"] == "zero slip", "traction_coefficient"]
    least, top = mu.min(), 4 * mu.abs().max()
    lines = drawn[(drawn["panel"] == "a") & (drawn["series"] == "fit")]
    below = lines[lines.groupby("oil")["traction_coefficient"].cummax() < top]
    axis.set_ylim(1e3 * (min(least, 0) - 0.1 * top), 1e3 * top)
    axis.set_xlim(-0.04 * below["slide_roll_ratio"].max(), below["slide_roll_ratio"].max())


def _draw_zero_slip(
    whole: Axes,
    near: Axes,
    oil: str,
    fits: pd.DataFrame,
    results: CampaignTables,
    settings: Settings,
) -> Iterator[pd.DataFrame]:
    """Of one oil: the curve at which a fit has the most traction without slip."""
    starts = [
        _starts(results, oil, law, settings).assign(law=law) for law in _wang_deng(fits["law"])
    ]
    if not sum(map(len, starts)):
        return
    among = pd.concat(starts, ignore_index=True)
    largest = tables.rows(among.loc[[among["y"].abs().idxmax()]])[0]
    law_name, run = largest["law"], largest["run_id"]
    fit, law = tables.rows(fits.loc[[law_name]])[0], laws_of(oil, settings)[law_name]
    curve = _curve(results, run)
    # close enough together for the zoom
    slip = np.linspace(0, 1, 301) ** 2 * float(curve["slide_roll_ratio"].max())
    fitted = FittedLaw.of(results.law_coefficients, oil, law=law)
    mu = fitted.traction(curve[list(law.conditions)].mean().to_numpy(dtype=float), slip)
    look = _look(oil, settings, fit)
    for axis, scale in ((whole, 1.0), (near, 1e3)):
        axis.plot(slip, scale * mu, color=look["color"], linewidth=0.9)
        _draw_measured(axis, curve, look, scale)
    label = f"{_about(fit, curve)}\n{_MU}(0) = {_thousandths(mu[0])} {_TIMES}"
    # an open symbol hides no other
    order = 4 if fit["certified"] else 5
    near.plot(0, 1e3 * mu[0], **look | {"markersize": 5}, label=label, zorder=order)
    about = {"panel": "a", "run_id": run}
    yield _rows(fit, "measured", curve, about)
    line = pd.DataFrame({"slide_roll_ratio": slip, "traction_coefficient": mu})
    yield _rows(fit, "fit", line, about)
    yield _rows(fit, "zero slip", line.head(1), about)


def _draw_left_out(
    whole: Axes,
    errors: Axes,
    oil: str,
    fits: pd.DataFrame,
    results: CampaignTables,
    settings: Settings,
) -> Iterator[pd.DataFrame]:
    """Of one oil: the curve whose error by a Wang-Deng law grows most when left out."""
    rms = _errors_by_curve(results, oil)
    among = rms[rms["law"].isin(_wang_deng(fits["law"]))].dropna()
    if among.empty:
        return
    worst = tables.rows(among.loc[[(among["unseen"] - among["seen"]).idxmax()]])[0]
    law_name, run = worst["law"], worst["run_id"]
    fit = tables.rows(fits.loc[[law_name]])[0]
    curve, look = _curve(results, run), _look(oil, settings, fit)
    beside = results.law_points[results.law_points["run_id"] == run]
    about = {"panel": "b", "run_id": run}
    _draw_measured(whole, curve, look)
    yield _rows(fit, "measured", curve, about)
    lines = [(law_name, "fit"), (law_name, "left out"), (PAPER_LAW.name, "left out")]
    for law, series in lines:
        column = "traction_coefficient" if series == "fit" else "left_out_traction_coefficient"
        of_law = beside[beside["law"] == law]
        line = _one_side(of_law.assign(traction_coefficient=of_law[column]))
        if law not in fits.index or line["traction_coefficient"].isna().any():
            continue
        dashes = _DASHES["Eq. 7" if law == PAPER_LAW.name else series]
        slip, mu = line["slide_roll_ratio"], line["traction_coefficient"]
        off = mu.to_numpy() - curve["traction_coefficient"].to_numpy()
        for axis, y in ((whole, mu), (errors, 1e3 * off)):
            axis.plot(slip, y, color=look["color"], linestyle=dashes, linewidth=0.9)
        yield _rows(tables.rows(fits.loc[[law]])[0], series, line, about)
    errors.axhline(0, color="black", linewidth=0.6)
    label = f"{_about(fit, curve)}\nrms error {_growth(worst)}"
    for papers in tables.rows(rms[(rms["law"] == PAPER_LAW.name) & (rms["run_id"] == run)]):
        label += f"; Eq. 7: {_growth(papers)}"
    errors.plot([], [], **look, label=label)


def _key_of_lines() -> list[Any]:
    black: dict[str, Any] = {"color": "black", "linewidth": 0.9}
    return [
        style.symbol_handle("plateau, 95 % (random part)", ".", color="black", markersize=4),
        style.line_handle("fit to all curves", linestyle=_DASHES["fit"], **black),
        style.line_handle("fit to all others", linestyle=_DASHES["left out"], **black),
        style.line_handle("Eq. 7, fit to all others", linestyle=_DASHES["Eq. 7"], **black),
        style.symbol_handle("fit not certified", "o", color="black", markerfacecolor="white"),
    ]


def _errors_by_curve(results: CampaignTables, oil: str) -> pd.DataFrame:
    """Rms error of each law on each curve of an oil, `seen` by the fit and `unseen`."""
    key = ["run_id", "first_row"]
    beside = results.law_points[results.law_points["oil"] == oil]
    points = results.points[[*key, "traction_coefficient"]]
    both = beside.merge(points, on=key, suffixes=("", "_measured"))
    squares = both[["law", "run_id"]].assign(
        seen=(both["traction_coefficient"] - both["traction_coefficient_measured"]) ** 2,
        unseen=(both["left_out_traction_coefficient"] - both["traction_coefficient_measured"]) ** 2,
    )
    means = squares.groupby(["law", "run_id"], as_index=False).mean()
    return means.assign(seen=np.sqrt(means["seen"]), unseen=np.sqrt(means["unseen"]))


def _wang_deng(laws: "pd.Series[str]") -> list[str]:
    return [law for law in laws if law.startswith(_WANG_DENG)]


def _curve(results: CampaignTables, run: str) -> pd.DataFrame:
    """Accepted points of one run by slip, as if slipping in the positive direction."""
    points = results.points[results.points["accepted"] & (results.points["run_id"] == run)]
    return _one_side(points)


def _one_side(points: pd.DataFrame) -> pd.DataFrame:
    both = ["slide_roll_ratio", "traction_coefficient"]
    side = np.where(points["slide_roll_ratio"] < 0, -1.0, 1.0)
    return points.assign(**{name: side * points[name] for name in both}).sort_values(both[0])


def _look(oil: str, settings: Settings, fit: Mapping[str, Any]) -> dict[str, Any]:
    """Symbol of an oil, open where the fit is not certified."""
    oils = list(settings.oils)
    colour = style.oil_colour(oil, oils)
    face = colour if fit["certified"] else "white"
    marker = style.oil_marker(oil, oils)
    return {"color": colour, "marker": marker, "markerfacecolor": face, "linestyle": ""}


def _draw_measured(
    axis: Axes, curve: pd.DataFrame, look: Mapping[str, Any], scale: float = 1.0
) -> None:
    axis.errorbar(
        curve["slide_roll_ratio"],
        scale * curve["traction_coefficient"],
        yerr=scale * style.SE_DRAWN * curve["traction_coefficient_se"],
        fmt=".",
        color=look["color"],
        markersize=3,
        elinewidth=0.7,
    )


def _about(fit: Mapping[str, Any], curve: pd.DataFrame) -> str:
    """Oil, law and what keeps its fit from being certified; below, the conditions of a curve."""
    bounds = f", at bounds: {fit['active_bounds']}" if fit["active_bounds"] else ""
    fault = "" if fit["certified"] else f" (not certified{bounds})"
    levels = {name: float(f"{curve[name].mean():.3g}") for name in CONDITIONS}
    return f"{fit['oil']}, {fit['law']}{fault}\n{style.level_phrases(levels)}"


def _growth(errors: Mapping[str, Any]) -> str:
    seen, unseen = _thousandths(errors["seen"]), _thousandths(errors["unseen"])
    return f"{seen} \N{RIGHTWARDS ARROW} {unseen} {_TIMES}"


def _thousandths(number: float) -> str:
    return f"{1e3 * number:.2g}".replace("-", "\N{MINUS SIGN}")


def _rows(
    fit: Mapping[str, Any], series: str, line: pd.DataFrame, about: Mapping[str, str]
) -> pd.DataFrame:
    """Rows of the table of what is drawn."""
    drawn = {"traction_coefficient_se": np.nan} if series != "measured" else {}
    of_fit = {name: fit[name] for name in ("oil", "law", "certified", "active_bounds")}
    return line.assign(**drawn, **of_fit, **about, series=series)


def _sentences(*sentences: str) -> str:
    return " ".join(filter(None, sentences))


_ROW_IN = 0.34
_ENDS = ("pressure", "speed", "temperature")
# Kinds of error, from those on the fitted curves themselves to the farthest: how each is drawn.
_KINDS: dict[str, dict[str, Any]] = {
    "fitted curves": {"marker": "o", "markersize": 3.4},
    "curve left out": {"marker": "D", "markersize": 3.4},
    "end level left out": {"marker": "^", "markersize": 4},
}

_LAW_PANELS = drawn_table(
    "law_panels",
    "Drawn in the figure of the laws' errors.",
    columns="panel law oil kind certified active_bounds x y",
    uses=(
        use(
            "kind",
            "zero slip: mu at zero slip at a tested condition; the others: error of a law over mu",
            allowed=("zero slip", "fitted curves", "curve left out", "end level left out"),
        ),
        use("certified", "of the law's fit: an open symbol where false"),
        use("active_bounds", "of the law's fit"),
        use("y", "of errors: position of the row", required=True),
    ),
)


@register(
    name="law-errors",
    title="Laws at zero slip and on data left out",
    caption="(a) Traction coefficient at zero slip by each law, at every tested condition. "
    "(b) Relative error of each law on fitted curves, on curves left out, and on the lowest and "
    "highest levels left out. Open symbols: fit not certified; constants at a bound are named.",
    category="Fits",
    family="law",
    tables=("points", "comparison", "law_coefficients"),
    settings=("oils", "rigs"),
    compares_laws=True,
    draws=_LAW_PANELS,
)
def law_errors(results: CampaignTables, settings: Settings) -> Drawing:
    """Above, mu at no slip of the laws that allow it; below, each law's errors, seen and unseen."""
    compared, oils = results.comparison.dropna(subset="rmse"), list(settings.oils)
    laws = list(dict.fromkeys(compared["law"]))
    starting = list(compared.loc[compared["zero_slip_traction"] != 0, "law"].unique())
    heights = (1.6, _ROW_IN * max(len(laws), 1) + 0.5)
    figure = Figure(figsize=(style.DOUBLE_COLUMN_IN, sum(heights) + 0.9))
    above, below = figure.subplots(2, 1, height_ratios=heights)
    drawn = [
        *_draw_starts(above, results, settings, compared, starting),
        *_draw_errors(below, compared, oils),
    ]
    if not drawn:
        style.say_in_panel(above, "no law could be fitted")
    elif not starting:
        style.say_in_panel(above, "every law that was compared has no traction without slip")
    title = "Traction without slip at the tested conditions, cold to hot; other laws: 0"
    style.title_panel(above, 0, title)
    above.set_ylabel(f"{_MU} at S = 0 (10$^{{-3}}$)")
    title = (
        f"Rms error over rms of {_MU}; left out: a curve, or the lowest and highest level of P, U "
        "or T"
    )
    style.title_panel(below, 1, title)
    below.set_xlabel(f"Rms error over rms of measured {_MU}")
    handles: list[Any] = [
        Patch(color=style.oil_colour(oil, oils), label=oil)
        for oil in oils
        if oil in set(compared["oil"])
    ]
    handles += [
        style.symbol_handle(kind, color="black", markerfacecolor="white", **look)
        for kind, look in _KINDS.items()
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=6)
    ours = _OURS if any(law.startswith(_WANG_DENG) for law in laws) else ""
    style.say_key(figure, _sentences(_OPEN, ours, tie(settings.campaign)))
    return figure, drawn


def _draw_starts(
    axis: Axes,
    results: CampaignTables,
    settings: Settings,
    compared: pd.DataFrame,
    laws: Sequence[str],
) -> Iterator[pd.DataFrame]:
    """A cloud per law and oil: mu at zero slip at each condition, spread along the abscissa."""
    oils = list(settings.oils)
    axis.axhline(0, color="black", linewidth=0.8)
    for fit in tables.rows(compared[compared["law"].isin(laws)]):
        y = _starts(results, fit["oil"], fit["law"], settings)["y"].to_numpy()
        apart = min(0.26, 0.8 / len(oils))
        middle = laws.index(fit["law"]) + apart * (oils.index(fit["oil"]) - (len(oils) - 1) / 2)
        x = middle + np.linspace(-0.35, 0.35, len(y)) * apart
        axis.plot(x, 1e3 * y, **_look(fit["oil"], settings, fit), markeredgewidth=0.5)
        yield _error_rows(fit, "a", "zero slip", x, y)
    axis.set_xticks(range(len(laws)), laws)
    axis.set_xlim(-0.5, max(len(laws), 1) - 0.5)
    axis.grid(visible=False, axis="x")


def _starts(results: CampaignTables, oil: str, law_name: str, settings: Settings) -> pd.DataFrame:
    """mu at no slip of each curve (`run_id`, `y`), in the order of rising temperature."""
    fits = results.law_coefficients
    of_fit = (fits["oil"] == oil) & (fits["law"] == law_name)
    if fits.loc[of_fit, "value"].isna().all():
        return pd.DataFrame({"run_id": [], "y": []})
    law = laws_of(oil, settings)[law_name]
    data = curve_data(results.points[results.points["oil"] == oil], law.conditions)
    fitted = FittedLaw.of(fits, oil, law=law)
    y = fitted.predict(data.conditions, np.zeros(len(data.runs))).traction_coefficient
    order = np.argsort(data.conditions[:, -1])
    return pd.DataFrame({"run_id": data.runs, "y": y}).iloc[order]


def _draw_errors(axis: Axes, compared: pd.DataFrame, oils: Sequence[str]) -> Iterator[pd.DataFrame]:
    """One row per law, one line per oil from the smallest of its errors to the largest."""
    laws = list(dict.fromkeys(compared["law"]))
    for fit in tables.rows(compared):
        apart = min(0.24, 0.8 / len(oils))  # rows of many oils stay within those of their law
        height = laws.index(fit["law"]) + apart * (oils.index(fit["oil"]) - (len(oils) - 1) / 2)
        colour = style.oil_colour(fit["oil"], oils)
        face = colour if fit["certified"] else "white"
        left_out = fit["left_out_rmse"] * fit["relative_rms"] / fit["rmse"]
        ends = [fit[f"{end}_end_out_relative_rms"] for end in _ENDS]
        errors = dict(zip(_KINDS, ([fit["relative_rms"]], [left_out], ends), strict=True))
        every = np.concatenate(list(errors.values()))
        axis.plot([np.nanmin(every), np.nanmax(every)], [height] * 2, color=colour, linewidth=0.6)
        for kind, values in errors.items():
            look: dict[str, Any] = {"color": colour, "markerfacecolor": face, "linestyle": ""}
            axis.plot(values, [height] * len(values), **look, **_KINDS[kind])
            yield _error_rows(fit, "b", kind, values, height).dropna(subset="x")
    axis.set_yticks(range(len(laws)), [_with_bounds(compared, law) for law in laws])
    axis.set_ylim(len(laws) - 0.45, -0.55)
    axis.set_xscale("log")
    axis.xaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
    # decimals as each level needs them: 0.2 %, 100 %
    axis.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{100 * value:.3g}%"))
    axis.xaxis.set_minor_formatter(NullFormatter())
    axis.grid(visible=False, axis="y")


def _with_bounds(compared: pd.DataFrame, law: str) -> str:
    """Name of a law, with the constants that ended at a bound for any oil below it."""
    bounds = compared.loc[compared["law"] == law, "active_bounds"]
    names = dict.fromkeys(name for joined in bounds if joined for name in joined.split(", "))
    return f"{law}\n(at bounds: {', '.join(names)})" if names else law


def _error_rows(fit: Mapping[str, Any], panel: str, kind: str, x: Any, y: Any) -> pd.DataFrame:
    of_fit = {name: fit[name] for name in ("oil", "law", "certified", "active_bounds")}
    return pd.DataFrame({"x": x, "y": y}).assign(**of_fit, panel=panel, kind=kind)
