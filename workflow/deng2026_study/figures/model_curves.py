"""Laws beside data and far beyond them: Figs 4 and 7-10 of the paper."""

import itertools
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.patches import Patch
from matplotlib.ticker import MaxNLocator

from deng2026_study.extrapolation import is_beyond
from deng2026_study.printed_law import add_printed_values
from deng2026_study.settings import MatrixWithSlip, study_settings
from oilfilm import tables
from oilfilm.base.ties import first_largest, reaches
from oilfilm.base.units import BoolArray, FloatArray
from oilfilm.bearing.kinematics import pitch_speed_mm_rpm
from oilfilm.fits.fit import laws_of_oil
from oilfilm.fits.fitted import Coefficients, FittedLaw, read_surface
from oilfilm.report.figures import style
from oilfilm.report.figures.fits import mu_at_zero_slip, oil_symbol
from oilfilm.report.figures.sheet import Panel, Sheet, declare_figure, oil_grid
from oilfilm.report.names import CONDITION_TEXTS, law_title
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.traction.law import CONDITIONS
from oilfilm.traction.laws.deng2026 import DENG2026
from simulated_lab.printed import PrintedCoefficients

# Number of points of a curve along the abscissa.
_POINTS_PER_CURVE = 121
# Number of symbols along a curve.
_SYMBOLS_PER_CURVE = 4
# Upper end of a panel's scale, relative to the largest mu of its lines.
_HEADROOM = 1.3
# By whether the abscissa is the slip. Then the band holds the whole curve of the next run; over
# another condition it holds its points.
_BAND_LABELS = {True: "95 %, whole next run", False: "95 %, next run"}
_SPEED, _TEMPERATURE, _SLIP = "entrainment_speed_m_s", "inlet_temperature_c", "slide_roll_ratio"
# For each figure: the condition along the abscissa, and the condition that differs between the
# curves of one panel. The other conditions differ between panels.
CUTS = {
    "fig07": (_SLIP, _TEMPERATURE),
    "fig08": (_SPEED, _TEMPERATURE),
    "fig09": ("max_hertz_pressure_gpa", _TEMPERATURE),
    "fig10": (_TEMPERATURE, _SLIP),
}
_BEYOND_TESTS_PATCH = Patch(facecolor=style.EXTRAPOLATED_COLOUR, label="beyond the tests")
# What the dashed lines are, by the name of their series.
_LABEL_OF_DASHED_SERIES = {"truth": "truth of the simulation", "printed": "printed constants"}


@declare_figure(
    counterpart="Fig. 7",
    # one job draws the figures of a family
    family="law",
    tables=("coefficients", "points", "surfaces", "surface_sizes", "fit_quality", "extrapolation"),
    settings=("oils", "same_set_point", "studies"),
    references=("printed_coefficients",),
)
def fig07(results: CampaignTables, settings: Settings, **references: Any) -> Sheet:
    """Traction against slide-roll ratio.

    Traction coefficient against slide-roll ratio, one column of panels per oil and one row per
    maximum Hertz pressure and entrainment speed. The curves are for several inlet temperatures.

    The paper does not state the levels of the curves. Full lines: fitted law. Band: 95 % interval
    of the next good run at the middle level, which may leave the panel. Over the slip it holds the
    whole curve of the run, over other conditions its points. Without a band the measurements
    support none. Dashed lines: the truth of a simulated campaign; else the constants that the paper
    prints of the oil, signs restored. Shaded: beyond the tested conditions. Each row has its own
    scale. dmN: pitch diameter times speed (mm rpm) of a bearing with this entrainment speed. Oils
    without a fit of pressure, speed and temperature are not shown.
    """
    return _draw_cuts("fig07", results, settings, **references)


@declare_figure(like="fig07", counterpart="Fig. 8")
def fig08(results: CampaignTables, settings: Settings, **references: Any) -> Sheet:
    """Traction against entrainment speed.

    Traction coefficient against entrainment speed (m/s), one column of panels per oil and one row
    per maximum Hertz pressure and slide-roll ratio. The curves are for several inlet temperatures.
    """
    return _draw_cuts("fig08", results, settings, **references)


@declare_figure(like="fig07", counterpart="Fig. 9")
def fig09(results: CampaignTables, settings: Settings, **references: Any) -> Sheet:
    """Traction against pressure.

    Traction coefficient against maximum Hertz pressure (GPa), one column of panels per oil and one
    row per entrainment speed and slide-roll ratio. The curves are for several inlet temperatures.
    """
    return _draw_cuts("fig09", results, settings, **references)


@declare_figure(like="fig07", counterpart="Fig. 10")
def fig10(results: CampaignTables, settings: Settings, **references: Any) -> Sheet:
    """Traction against temperature.

    Traction coefficient against inlet temperature (\N{DEGREE SIGN}C), one column of panels per oil
    and one row per maximum Hertz pressure and entrainment speed. The curves are for several
    slide-roll ratios.
    """
    return _draw_cuts("fig10", results, settings, **references)


def _draw_cuts(
    figure_name: str,
    results: CampaignTables,
    settings: Settings,
    printed_coefficients: PrintedCoefficients,
) -> Sheet:
    """Draw each oil along the cuts of one figure; the settings `extrapolation` have the levels."""
    abscissa, line_condition = CUTS[figure_name]
    levels = study_settings(settings).extrapolation[figure_name]
    fixed_names = [name for name in style.LEVEL_PHRASES if name not in (abscissa, line_condition)]
    fixed_levels_of_rows = [
        dict(zip(fixed_names, fixed_levels, strict=True))
        for fixed_levels in itertools.product(*(getattr(levels, name) for name in fixed_names))
    ]
    coefficients = add_printed_values(results.configured_fits.coefficients, printed_coefficients)
    laws_by_oil = {}
    for oil in settings.oils:
        law_by_series = _laws_of_series(results, coefficients, oil)
        if law_by_series:
            laws_by_oil[oil] = law_by_series
    truth = results.extrapolation[results.extrapolation["figure"] == figure_name]
    sheet, panels = oil_grid(
        list(laws_by_oil),
        "no oil has a fitted law\nof pressure, speed and temperature",
        fixed_levels_of_rows,
        lambda fixed_levels, _: style.level_phrases(fixed_levels),
        height=1.15,
        across=0.25,
        sharey="row",
        width=style.DOUBLE_COLUMN_IN,
    )
    largest_mu_of_rows = dict.fromkeys(range(len(fixed_levels_of_rows)), 0.0)
    for panel, fixed_levels, oil in panels:
        row_index = fixed_levels_of_rows.index(fixed_levels)
        largest_mu = _draw_refit(
            panel, oil, laws_by_oil[oil], levels, fixed_levels, (abscissa, line_condition), settings
        )
        largest_mu = max(
            largest_mu,
            _draw_truth(
                panel, truth[truth["oil"] == oil], fixed_levels, (abscissa, line_condition)
            ),
        )
        largest_mu_of_rows[row_index] = max(largest_mu_of_rows[row_index], largest_mu)
        # a very wide interval leaves the panel; otherwise the lines would be flat
        panel.axes.set_ylim(0, _HEADROOM * largest_mu_of_rows[row_index])
        colour = style.oil_colour(oil, list(settings.oils))
        corner_look: style.Look = {"ha": "right", "va": "top", "transform": panel.axes.transAxes}
        panel.axes.text(0.98, 0.96, oil, color=colour, fontweight="bold", **corner_look)
    sheet.label_axes(style.CONDITION_LABELS[abscissa], style.TRACTION_LABEL, fontsize=7)
    sheet.legend(
        _legend_entries(sheet.drawn(), getattr(levels, line_condition), (abscissa, line_condition)),
        _speeds_of_bearings(fixed_levels_of_rows),
    )
    return sheet


def _speeds_of_bearings(fixed_levels_of_rows: Sequence[Mapping[str, float]]) -> str:
    """The dmN (mm rpm) of a bearing with the speed of each row; empty where speed is no level."""
    texts = []
    for speed in dict.fromkeys(
        fixed_levels[_SPEED] for fixed_levels in fixed_levels_of_rows if _SPEED in fixed_levels
    ):
        mantissa, exponent = f"{pitch_speed_mm_rpm(speed):.1e}".split("e")
        texts.append(f"{style.level_phrases({_SPEED: speed})}: dmN {mantissa}e{int(exponent)}")
    return "; ".join(texts)


def _laws_of_series(
    results: CampaignTables, coefficients: pd.DataFrame, oil: str
) -> dict[str, FittedLaw]:
    """The refit and, where the paper has them, the printed constants, by the name of the series.

    Empty for an oil whose law does not depend on all three conditions, or has unknown constants.
    """
    coefficients_of_oil = coefficients[coefficients["oil"] == oil]
    if coefficients_of_oil.empty:
        return {}
    configured = results.configured_fits
    refit = FittedLaw.from_tables(coefficients_of_oil, oil, quality=configured.fit_quality)
    refit = replace(refit, read_surface=partial(read_surface, results, oil))
    law = refit.law
    # values of constants, not the declarations of `law.constants`
    refit_coefficients = refit.coefficients
    if (
        law.conditions != CONDITIONS
        # the fit follows every group of the law
        or not refit_coefficients.group_has_exponent.all()
        or np.isnan(refit_coefficients.constants).any()
    ):
        return {}
    constant_names = [constant.name for constant in law.constants]
    value_by_constant_name = coefficients_of_oil.set_index("constant")["printed_value"]
    printed_values = value_by_constant_name.reindex(constant_names).to_numpy(dtype=float)
    if results.extrapolation.empty and not np.isnan(printed_values).any():
        return {
            "refit": refit,
            # without interval and tested box
            "printed": FittedLaw(law, Coefficients.from_constants(law, printed_values)),
        }
    return {"refit": refit}


def _draw_refit(
    panel: Panel,
    oil: str,
    law_by_series: Mapping[str, FittedLaw],
    levels: MatrixWithSlip,
    fixed_levels: Mapping[str, float],
    cut: tuple[str, str],
    settings: Settings,
) -> float:
    """Draw the refit: a line and a symbol per level, and the interval at the middle level.

    Returns:
        The largest mu of a line.
    """
    abscissa, line_condition = cut
    curve_levels = getattr(levels, line_condition)
    abscissa_levels = getattr(levels, abscissa)
    x = np.linspace(min(abscissa_levels), max(abscissa_levels), _POINTS_PER_CURVE)
    if abscissa == _SLIP:
        # a curve begins without slip, where nothing can be measured, and bends most near it
        x = max(abscissa_levels) * np.linspace(0, 1, _POINTS_PER_CURVE) ** 2
    symbol_positions = x[0] + np.ptp(x) * (np.arange(_SYMBOLS_PER_CURVE) + 0.5) / _SYMBOLS_PER_CURVE
    symbol_indices = reaches(x, symbol_positions[:, np.newaxis]).argmax(axis=1).tolist()
    largest_mu = 0.0
    is_beyond_tests = np.zeros(_POINTS_PER_CURVE, dtype=bool)
    refit = law_by_series["refit"]
    for curve_index, level in enumerate(curve_levels):
        along_curve = pd.DataFrame({**fixed_levels, line_condition: level, abscissa: x})
        points = along_curve[[*CONDITIONS, _SLIP]].to_numpy()
        conditions = np.ascontiguousarray(points[:, :-1])
        slip = points[:, -1]
        # a level counts as tested only where every curve is tested
        box = refit.coefficients.tested_box
        is_beyond_tests |= is_beyond(points, box, settings.same_set_point.relative).any(axis=1)
        refit_mu = refit.without_interval().predict(conditions, slip).traction_coefficient
        # a run measures one curve over the slip, but not one over another condition
        prediction = refit.predict(conditions, slip, whole_curve=abscissa == _SLIP)
        interval_of_next_run = {"lower": prediction.obs_ci_lower, "upper": prediction.obs_ci_upper}
        look: style.Look = {
            "color": style.oil_colour(oil, list(settings.oils)),
            "markerfacecolor": "white",
            "markeredgewidth": 0.7,
            "markersize": 3,
            "linewidth": 0.9,
            "marker": style.MARKERS[curve_index % len(style.MARKERS)],
            "linestyle": style.LINE_STYLES["fit"],
            "markevery": symbol_indices,
        }
        oil_and_label: style.Look = {
            "oil": oil,
            "label": style.level_phrases({line_condition: level}),
        }
        is_middle = curve_index == len(curve_levels) // 2
        panel.line(
            "refit",
            x,
            refit_mu,
            look,
            **oil_and_label,
            **(interval_of_next_run if is_middle else {}),
        )
        largest_mu = max(largest_mu, refit_mu.max())
        if "printed" in law_by_series:
            printed_mu = law_by_series["printed"].predict(conditions, slip).traction_coefficient
            panel.line("printed", x, printed_mu, _comparison_look(), **oil_and_label)
            largest_mu = max(largest_mu, printed_mu.max())
    for start, end in _intervals_where(x, is_beyond_tests):
        panel.axes.axvspan(start, end, color=style.EXTRAPOLATED_COLOUR, linewidth=0, zorder=0)
    panel.axes.set_xlim(x.min(), x.max())
    # numbers of neighbouring panels must not meet
    panel.axes.xaxis.set_major_locator(MaxNLocator(4, steps=[1, 2, 5, 10]))
    return float(largest_mu)


def _draw_truth(
    panel: Panel, truth: pd.DataFrame, fixed_levels: Mapping[str, float], cut: tuple[str, str]
) -> float:
    """Draw the true traction at the levels of the cut, one line per level.

    Args:
        panel: The panel.
        truth: Rows of the table `extrapolation` of one oil and figure.
        fixed_levels: Levels of the panel.
        cut: Condition along the abscissa, and condition that differs between the lines.

    Returns:
        The largest mu; 0 without a truth.
    """
    abscissa, line_condition = cut
    # levels of each row of the table
    truth_levels = truth[list(fixed_levels)].to_numpy(dtype=float)
    has_levels: BoolArray = np.asarray(
        np.isclose(truth_levels, list(fixed_levels.values())).all(axis=1)
    )
    truth_of_panel = truth.loc[has_levels]
    # every law has the same truth
    truth_of_panel = truth_of_panel.drop_duplicates([abscissa, line_condition]).sort_values(
        [line_condition, abscissa]
    )
    for level in truth_of_panel[line_condition].unique().tolist():
        line = truth_of_panel[truth_of_panel[line_condition] == level]
        oil_and_label: style.Look = {
            "oil": line["oil"],
            "label": style.level_phrases({line_condition: level}),
        }
        panel.line(
            "truth",
            line[abscissa],
            line["true_traction_coefficient"],
            _comparison_look(),
            **oil_and_label,
        )
    return float(truth_of_panel["true_traction_coefficient"].max()) if len(truth_of_panel) else 0.0


def _comparison_look() -> style.Look:
    """Look of what the refit is compared with."""
    return {"color": "black", "linestyle": style.LINE_STYLES["printed"], "linewidth": 0.7}


def _intervals_where(x: FloatArray, is_true: Any) -> Iterator[tuple[float, float]]:
    """Intervals of an axis where flags are true; each begins and ends half way between points."""
    borders: FloatArray = np.concatenate([x[:1], (x[1:] + x[:-1]) / 2, x[-1:]])
    changes = np.flatnonzero(np.diff(np.concatenate([[False], is_true, [False]])))
    for start, end in changes.reshape(-1, 2):
        yield borders[start], borders[end]


def _legend_entries(
    drawn: pd.DataFrame, levels: Sequence[float], cut: tuple[str, str]
) -> list[Any]:
    """Entries of the legend for symbols, lines and bands.

    Args:
        drawn: Table `drawn` of the sheet, with a column `series`.
        levels: Levels of the curves.
        cut: Condition along the abscissa, and condition that differs between the lines.
    """
    abscissa, line_condition = cut
    grey: style.Look = {"color": style.GREY, "linewidth": 0.9, "markerfacecolor": "white"}
    handles: list[Any] = [
        style.line_handle(
            f"fitted law, {style.level_phrases({line_condition: level})}", marker=marker, **grey
        )
        for level, marker in zip(levels, itertools.cycle(style.MARKERS), strict=False)
    ]
    handles += [
        style.line_handle(label, **_comparison_look())
        for series, label in _LABEL_OF_DASHED_SERIES.items()
        if (drawn["series"] == series).any()
    ]
    if drawn["y_lower"].notna().any():
        middle = style.level_phrases({line_condition: levels[len(levels) // 2]})
        label = f"{_BAND_LABELS[abscissa == _SLIP]}, {middle}"
        handles.append(Patch(color=style.GREY, alpha=0.25, linewidth=0, label=label))
    return [*handles, _BEYOND_TESTS_PATCH]


# A row of the table `fit_quality`.
FitRow = Mapping[str, Any]
_MU_COLUMN, _LEFT_OUT_MU_COLUMN = "traction_coefficient", "left_out_traction_coefficient"
_UNIT_OF_TEXTS = f"\N{MULTIPLICATION SIGN} {style.THOUSANDTHS}"
_WANG_DENG = "wang-deng"
_NO_WANG_DENG = "no Wang-Deng law could be fitted"
# Line style by the entry of the legend; Eq. 7 has one of its own.
_LINESTYLE_OF_SERIES = {"fit": "-", "left out": style.LINE_STYLES["left out"], "Eq. 7": ":"}


@declare_figure(
    counterpart="Fig. 4",
    family="law",
    tables=("points", "fit_quality", "coefficients", "law_points"),
    settings=("oils", "rigs"),
)
def fig04(results: CampaignTables, settings: Settings) -> Sheet:
    """The Wang-Deng law at zero slip and on a curve left out.

    Measured traction coefficient against slide-roll ratio, and the Wang-Deng law fitted to the
    same oil. Each oil has one curve, chosen by a rule among all tested curves and all versions
    of the law. (a) Curve with the largest traction coefficient at zero slip; below: detail near
    zero slip. (b) Curve whose rms error grows most when the fit leaves it out; below: the
    errors. Full lines: fit to all curves. Dashed lines: fit without this curve. Dotted lines:
    law of the paper (Eq. 7), fitted without this curve. Symbols: plateau means with the 95 %
    interval of their random error. Open symbols at zero slip: fit not certified. The rms errors are
    those of the fit with the curve and without it. The dimensionless groups of the Wang-Deng laws,
    and how their equations are read, are of this software.
    """
    fits = results.fit_quality.dropna(subset="rmse")
    sheet = Sheet(panel_count=4, column_count=2, height=(1.7, 1.5), across=0.55, down=0.45)
    zero_slip_panel = sheet.panel(0, f"Curve with the largest |{style.MU}(0)|")
    left_out_panel = sheet.panel(1, "Curve with the largest growth of error")
    near_zero_axes, error_axes = sheet.axes_of_panels[2:]
    near_zero_axes.set_title("    near S = 0")
    # numbers of many decimals: few of them fit
    near_zero_axes.xaxis.set_major_locator(MaxNLocator(4))
    error_axes.set_title("    fitted minus measured")
    oil_handles: list[Any] = []
    for oil in settings.oils:
        fit_by_law = {fit["law"]: fit for fit in tables.rows(fits[fits["oil"] == oil])}
        text_at_zero = _draw_zero_slip(
            zero_slip_panel, near_zero_axes, fit_by_law, results, settings
        )
        text_left_out = _draw_left_out(left_out_panel, error_axes, fit_by_law, results, settings)
        label_lines = [oil]
        label_lines += [f"(a) {text_at_zero}"] if text_at_zero else []
        label_lines += [f"(b) {text_left_out}"] if text_left_out else []
        if text_at_zero or text_left_out:
            look = style.oil_look(oil, list(settings.oils)) | {"linewidth": 0.9}
            oil_handles.append(style.line_handle("\n".join(label_lines), **look))
    for panel in (zero_slip_panel, left_out_panel):
        if not panel.axes.lines:
            panel.write_message(_NO_WANG_DENG)
    for axes in (near_zero_axes, error_axes):
        axes.axhline(0, color="black", linewidth=0.6)
        axes.set_xlabel(style.CONDITION_LABELS["slide_roll_ratio"])
    _zoom_to_zero_slip(near_zero_axes, sheet.drawn())
    zero_slip_panel.axes.set_ylabel(style.TRACTION_LABEL)
    near_zero_axes.set_ylabel(f"{style.MU} ({style.THOUSANDTHS})")
    error_axes.set_ylabel(f"\N{GREEK CAPITAL LETTER DELTA}{style.MU} ({style.THOUSANDTHS})")
    black: style.Look = {"color": "black", "linewidth": 0.9}
    plateau = style.symbol_handle("plateau, 95 % (random part)", ".", color="black", markersize=4)
    labels = {
        "fit": "fit to all curves",
        "left out": "fit to all other curves",
        "Eq. 7": f"{law_title(DENG2026.name)}, fit to all other curves",
    }
    line_handles = [
        style.line_handle(label, linestyle=_LINESTYLE_OF_SERIES[series], **black)
        for series, label in labels.items()
    ]
    sheet.legend([*oil_handles, plateau, *line_handles], column_count=1)
    return sheet


def _zoom_to_zero_slip(axes: Axes, drawn: pd.DataFrame) -> None:
    """Show what is near zero slip: a few times the largest mu(0), as far as the slowest rise.

    Args:
        axes: The axes.
        drawn: Table `drawn` of the sheet, with columns `panel`, `series`, `oil`, `x` and `y`.
    """
    panel_a = drawn[drawn["panel"] == "a"]
    mu_at_zero = panel_a.loc[panel_a["series"] == "zero slip", "y"]
    if len(mu_at_zero):
        top = 4 * mu_at_zero.abs().max()
        fit_lines = panel_a[panel_a["series"] == "fit"]
        farthest = fit_lines.loc[fit_lines.groupby("oil")["y"].cummax() < top, "x"].max()
        axes.set_ylim(1e3 * (min(mu_at_zero.min(), 0) - 0.1 * top), 1e3 * top)
        axes.set_xlim(-0.04 * farthest, farthest)


def _draw_zero_slip(
    panel: Panel,
    near_zero_axes: Axes,
    fit_by_law: Mapping[str, FitRow],
    results: CampaignTables,
    settings: Settings,
) -> str:
    """Draw the curve of one oil at which a fit has the most traction without slip.

    Returns:
        The law, the conditions and mu without slip; empty if nothing was drawn.
    """
    # columns `run_id`, `y` (mu at zero slip of the law) and `law`
    mu_at_zero_of_laws = [
        mu_at_zero_slip(results, fit["oil"], law_name, settings).assign(law=law_name)
        for law_name, fit in fit_by_law.items()
        if law_name.startswith(_WANG_DENG)
    ]
    if not any(len(mu_at_zero) for mu_at_zero in mu_at_zero_of_laws):
        return ""
    candidates = pd.concat(mu_at_zero_of_laws, ignore_index=True)
    chosen_law_name, run_id = candidates[["law", "run_id"]].to_numpy()[
        first_largest(candidates["y"].abs())
    ]
    curve, symbol_look, line_look, oil_and_label, label = _draw_measured(
        panel, fit_by_law[chosen_law_name], run_id, results, settings
    )
    slip, mu = _fitted_curve(fit_by_law[chosen_law_name], curve, results, settings)
    near_zero_axes.plot(
        curve["slide_roll_ratio"], 1e3 * curve["traction_coefficient"], ".", **line_look
    )
    panel.line("fit", slip, mu, line_look, **oil_and_label)
    near_zero_axes.plot(slip, 1e3 * mu, **line_look)
    # an open symbol is above the others, because it hides none
    is_open = not fit_by_law[chosen_law_name]["certified"]
    near_zero_axes.plot(
        0, 1e3 * mu[0], **symbol_look | {"markersize": 5}, zorder=5 if is_open else 4
    )
    # `near_zero_axes` shows it; this adds it to the table `drawn`
    panel.record("zero slip", 0.0, mu[0], **oil_and_label)
    return f"{label}; {style.MU}(0) = {_in_thousandths(mu[0])} {_UNIT_OF_TEXTS}"


def _draw_left_out(
    panel: Panel,
    error_axes: Axes,
    fit_by_law: Mapping[str, FitRow],
    results: CampaignTables,
    settings: Settings,
) -> str:
    """Draw the curve of one oil whose error by a Wang-Deng law grows most when it is left out.

    Returns:
        The law, the conditions and the errors; empty if nothing was drawn.
    """
    # all fits are of one oil; there may be none
    oils = {fit["oil"] for fit in fit_by_law.values()}
    # with mu of the laws, not as measured
    law_points = results.law_points[results.law_points["oil"].isin(oils)]
    rms_by_curve = _rms_errors(law_points, results.points)
    growth_by_curve = {
        curve_key: left_out_rms - fit_rms
        for curve_key, (fit_rms, left_out_rms) in rms_by_curve.items()
        if curve_key[0].startswith(_WANG_DENG) and not np.isnan(left_out_rms)
    }
    if not growth_by_curve:
        return ""
    # where a law and its special case have the same fit, both errors grow alike: the first is taken
    chosen_law_name, run_id = list(growth_by_curve)[first_largest(list(growth_by_curve.values()))]
    curve, _, line_look, _, label = _draw_measured(
        panel, fit_by_law[chosen_law_name], run_id, results, settings
    )
    for law_name, series in (
        (chosen_law_name, "fit"),
        (chosen_law_name, "left out"),
        (DENG2026.name, "left out"),
    ):
        column = _LEFT_OUT_MU_COLUMN if series == "left out" else _MU_COLUMN
        plateaus = _with_positive_slip(
            law_points[(law_points["law"] == law_name) & (law_points["run_id"] == run_id)]
        )
        if law_name not in fit_by_law or plateaus[column].isna().any():
            continue
        slip_of_plateaus = plateaus["slide_roll_ratio"].to_numpy()
        law_mu_of_plateaus = plateaus[column].to_numpy()
        # a fit without the curve is known at its plateaus alone
        drawn_slip, drawn_mu = slip_of_plateaus, law_mu_of_plateaus
        if series == "fit":
            drawn_slip, drawn_mu = _fitted_curve(fit_by_law[law_name], curve, results, settings)
        dashes = {
            "linestyle": _LINESTYLE_OF_SERIES["Eq. 7" if law_name == DENG2026.name else series]
        }
        oil_and_label: style.Look = {
            "oil": fit_by_law[law_name]["oil"],
            "label": f"{law_name}, run {run_id}",
        }
        panel.line(series, drawn_slip, drawn_mu, line_look | dashes, **oil_and_label)
        dot_look: style.Look = {"marker": ".", "markersize": 2, "linewidth": 0.5}
        difference = law_mu_of_plateaus - curve[_MU_COLUMN].to_numpy()
        error_axes.plot(slip_of_plateaus, 1e3 * difference, **line_look | dashes | dot_look)
    label += f"; rms error {_growth_text(*rms_by_curve[chosen_law_name, run_id])}"
    if (DENG2026.name, run_id) in rms_by_curve:
        label += f"; Eq. 7: {_growth_text(*rms_by_curve[DENG2026.name, run_id])}"
    return label


def _rms_errors(
    law_points: pd.DataFrame, points: pd.DataFrame
) -> dict[tuple[str, str], tuple[float, float]]:
    """Rms error of each law on each curve: by the fit of all curves, and by that without it.

    Args:
        law_points: Rows of the table `law_points` of one oil.
        points: Table of points.

    Returns:
        Both errors by law and run.
    """
    point_key = ["run_id", "first_row"]
    measured = points.set_index(point_key)[_MU_COLUMN].rename("measured")
    compared = law_points.join(measured, on=point_key)
    errors = compared[[_MU_COLUMN, _LEFT_OUT_MU_COLUMN]].sub(compared["measured"], axis=0)
    squares_by_curve = errors.pow(2).groupby([compared["law"], compared["run_id"]], sort=False)
    rms_rows = (squares_by_curve.mean() ** 0.5).reset_index().to_numpy().tolist()
    return {
        (str(law_name), str(run_id)): (fit_rms, left_out_rms)
        for law_name, run_id, fit_rms, left_out_rms in rms_rows
    }


class _DrawnCurve(NamedTuple):
    """A measured curve that has been drawn, and how to draw its fits.

    Attributes:
        points: Its points, by slip.
        symbol_look: Symbol of the oil.
        line_look: Look of the lines of fits.
        oil_and_label: Oil and label of the kept rows.
        label: The law and the conditions, in words.
    """

    points: pd.DataFrame
    symbol_look: style.Look
    line_look: style.Look
    oil_and_label: style.Look
    label: str


def _draw_measured(
    panel: Panel, fit: FitRow, run_id: str, results: CampaignTables, settings: Settings
) -> _DrawnCurve:
    """Draw a curve as measured."""
    curve = _with_positive_slip(results.points.query("accepted and run_id == @run_id"))
    symbol_look = oil_symbol(fit, list(settings.oils))
    x, y = curve["slide_roll_ratio"], curve["traction_coefficient"]
    half_interval = style.BAR_HALF_LENGTH_SE * curve["traction_coefficient_se"]
    dot_look: style.Look = {
        "color": symbol_look["color"],
        "marker": ".",
        "markersize": 3,
        "elinewidth": 0.7,
    }
    oil_and_label: style.Look = {"oil": fit["oil"], "label": f"{fit['law']}, run {run_id}"}
    panel.dots(
        "measured",
        x,
        y,
        dot_look,
        lower=y - half_interval,
        upper=y + half_interval,
        **oil_and_label,
    )
    level_texts = [f"{curve[name].mean():.3g} {CONDITION_TEXTS[name].unit}" for name in CONDITIONS]
    label = f"{law_title(fit['law'])}; {', '.join(level_texts)}"
    if not fit["certified"]:
        label += ", not certified"
    return _DrawnCurve(
        curve, symbol_look, {"color": symbol_look["color"], "linewidth": 0.9}, oil_and_label, label
    )


def _fitted_curve(
    fit: FitRow, curve: pd.DataFrame, results: CampaignTables, settings: Settings
) -> tuple[FloatArray, FloatArray]:
    """Slip and mu of a fit at the mean conditions of a curve, between its plateaus as well."""
    law = laws_of_oil(fit["oil"], settings)[fit["law"]]
    fitted = FittedLaw.from_tables(results.coefficients, fit["oil"], law=law)
    # close enough together for the detail
    slip = np.linspace(0, 1, 301) ** 2 * float(curve["slide_roll_ratio"].max())
    return slip, fitted.traction(curve[list(law.conditions)].mean().to_numpy(dtype=float), slip)


def _with_positive_slip(points: pd.DataFrame) -> pd.DataFrame:
    """Points in the order of slip; mu and slip of negative slips have their signs turned."""
    sign = np.where(points["slide_roll_ratio"] < 0, -1.0, 1.0)
    turned = points.filter(regex="slide_roll_ratio$|traction_coefficient$").mul(sign, axis="index")
    return points.assign(**turned).sort_values("slide_roll_ratio", kind="stable")


def _growth_text(fit_rms: float, left_out_rms: float) -> str:
    arrow = "\N{RIGHTWARDS ARROW}"
    return f"{_in_thousandths(fit_rms)} {arrow} {_in_thousandths(left_out_rms)} {_UNIT_OF_TEXTS}"


def _in_thousandths(number: float) -> str:
    return f"{1e3 * number:.2g}".replace("-", "\N{MINUS SIGN}")
