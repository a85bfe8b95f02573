"""Quality of each fit, its constants and the comparison of laws, as tables and sentences."""

import re
from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

from oilfilm import tables
from oilfilm.fits.conditions import sentences
from oilfilm.paper.extrapolation import errors_by_law
from oilfilm.report.constants import DETERMINED, by_certainty
from oilfilm.report.facts import noise_sentences
from oilfilm.report.fit_remarks import warnings_of_fit
from oilfilm.report.fit_verdicts import law_advice, law_head, noise_advice
from oilfilm.report.labels import in_words, law_name, law_names
from oilfilm.report.plain_text import bullet, percent, section, sentence, text_table
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.traction.law import QUANTITIES

# Columns of constants beside each other on a page of 100 letters.
_OILS_ABREAST = 3


def fit_lines(results: CampaignTables) -> list[str]:
    """Each fit: misfit, noise, and what its user must know; empty without a fit."""
    quality = results.configured.fit_quality
    if quality.empty:
        return []
    ranked = by_certainty(results.configured.coefficients, results.configured.correlations)
    fitted = quality[quality["rmse"].notna()]
    laws = law_names(", ".join(quality["law"].unique()))
    return section(
        "Fits",
        [f"Fitted law: {laws}. Errors and scatter are root mean squares (rms)."],
        _quality(fitted, ranked, results.lack_of_fit),
        [*_remarks(results.configured, ranked), *_noise(results.lack_of_fit)],
    )


def constant_lines(results: CampaignTables) -> list[str]:
    """The fitted constants, and the checks that certify them; empty without a fit."""
    fitted = results.configured.fit_quality[results.configured.fit_quality["rmse"].notna()]
    if fitted.empty:
        return []
    ranked = by_certainty(results.configured.coefficients, results.configured.correlations)
    return [*_constants(fitted, ranked), *_certificates(fitted)]


def law_lines(results: CampaignTables) -> list[str]:
    """The configured law beside the best of those compared, what to do, and simulated truth."""
    verdicts = results.law_verdicts
    findings: list[str] = []
    for row in tables.rows(verdicts):
        quality = results.fit_quality
        head = re.sub(r"[\w-]+", _law_in_words, law_head(row, quality))
        findings += bullet(f"{row['oil']}: {head}.", in_words(law_advice(row, quality)))
    blocks = findings, _judged(verdicts), _extrapolated(results.extrapolation)
    return section("Comparison of laws", *blocks) if any(blocks) else []


def _law_in_words(word: re.Match[str]) -> str:
    return law_name(word.group())


def _quality(fitted: pd.DataFrame, ranked: pd.DataFrame, misfits: pd.DataFrame) -> list[str]:
    """One row per fit: size, misfit, scatter, certificate, constants that are not determined."""
    unsure = ranked[~ranked["verdict"].isin((*DETERMINED, "no interval"))]
    scatter = misfits.set_index("oil")["plateau_relative_rms"]
    rows = []
    for fit in tables.rows(fitted):
        of_fit = unsure[(unsure["oil"] == fit["oil"]) & (unsure["law"] == fit["law"])]
        rows.append(
            [
                fit["oil"],
                str(fit["n_points"]),
                str(fit["n_curves"]),
                f"{fit['rmse']:.2e}",
                percent(fit["relative_rms"], 2),
                percent(scatter.get(fit["oil"], np.nan), 2),
                "yes" if fit["certified"] else "NO",
                ", ".join(of_fit["constant"]) or "none",
            ]
        )
    header = [
        "oil",
        "points",
        "curves",
        "error of mu",
        "error, % of mu",
        "plateau scatter, % of mu",
    ]
    return text_table([*header, "certified", "not determined"], rows)


def _remarks(fits: CampaignTables, ranked: pd.DataFrame) -> list[str]:
    """What whoever uses a fit must know: no fit, no certificate, curves that pull, no errors."""
    lines = []
    for fit in tables.rows(fits.fit_quality):
        oil = fit["oil"]
        if np.isnan(fit["rmse"]):
            lines += bullet(f"{oil}: {sentence(fit['certificate'])}")
            continue
        if not fit["certified"]:
            lines += bullet(f"{oil}: {sentence(fit['certificate'])}")
        lines += [f"- {text}." for text in warnings_of_fit(fit, fits.curve_residuals)]
        rows = ranked[ranked["oil"] == oil]
        if rows.loc[rows["identifiable"], "standard_error"].isna().all():
            lines += bullet(
                f"{oil}: the constants have no errors, because {fit['n_curves']} curves are too "
                "few for a bootstrap (fit.min_curves_to_resample of config.yaml)."
            )
        lost = rows.loc[~rows["identifiable"], "constant"]
        if len(lost):
            why = conditions_in_words(sentences(fit)).split("; ")
            reasons = " ".join(map(sentence, why))
            lines += bullet(f"{oil}: not identifiable: {', '.join(lost)}. {reasons}")
    return lines


def conditions_in_words(text: str) -> str:
    """A text with the columns of conditions in words."""
    for name, quantity in QUANTITIES.items():
        text = re.sub(rf"\b{name}\b", quantity.meaning.partition(",")[0], text)
    return text


def _noise(misfits: pd.DataFrame) -> list[str]:
    """What each fit misses beside the noise, and what to do."""
    advised = dict.fromkeys(filter(None, map(noise_advice, tables.rows(misfits))))
    lines = [f"- {each}" for each in noise_sentences(misfits)]
    alone = misfits[misfits["verdict"] == "no repeats"]
    if alone["plateau_relative_rms"].notna().any():
        lines += bullet("The scatter of readings within plateaus is a lower bound of the noise.")
    return [*lines, *(f"  What to do: {sentence(advice)}" for advice in advised)]


def _certificates(fitted: pd.DataFrame) -> list[str]:
    """The checks of the optimum, one row per fit with a search."""
    rows = [
        [
            row["oil"],
            f"{row['searches_agreeing']} of {row['searches']}",
            f"{row['sse_spread']:.1e}",
            f"{row['constant_spread']:.1e}",
            f"{row['gradient_cosine']:.1e}",
            f"{row['min_traction']:.1e}",
            f"{row['hessian_smallest']:.1e}",
            row["active_bounds"] or "none",
        ]
        for row in tables.rows(fitted)
    ]
    header = ["oil", "searches agree", "SSE differ by", "constants differ by", "gradient cosine"]
    header += ["smallest mu", "smallest eigenvalue", "bounds reached"]
    note = (
        "These numbers certify a fit. The constants of the searches differ by so many standard "
        "errors. The smallest mu is that in the tested box. Positive eigenvalues mean that the "
        "misfit is curved in every direction."
    )
    return section("Checks of the optimum", text_table(header, rows), [note])


def _constants(fitted: pd.DataFrame, ranked: pd.DataFrame) -> list[str]:
    """Values with half their 95 % intervals, and why some are not determined."""
    oils = [str(oil) for oil in fitted["oil"]]
    given = ranked[ranked["value"].notna()]
    cells = {(row["oil"], row["constant"]): _value(row) for row in tables.rows(given)}
    names = sorted({str(name) for oil, name in cells if oil in oils})
    blocks = []
    for first in range(0, len(oils), _OILS_ABREAST):
        abreast = oils[first : first + _OILS_ABREAST]
        body = [[name, *(cells.get((oil, name), "-") for oil in abreast)] for name in names]
        blocks.append(text_table(["constant", *abreast], body))
    unsure = ranked[
        ~ranked["verdict"].isin((*DETERMINED, "no interval"))
        & ranked["identifiable"]
        & ranked["oil"].isin(oils)
    ]
    reasons = [
        f"- Not determined (?): {row['oil']} {row['constant']}. "
        f"{sentence(row['determined'].removeprefix('no, '))}"
        for row in tables.rows(unsure)
    ]
    note = (
        "+- is half the width of the joint interval, which holds for all constants of a fit "
        "together, calibration included. It need not be centred on the value: see lower and upper "
        "of coefficients.parquet."
    )
    return section("Fitted constants", [note], *blocks, reasons)


def _value(row: Mapping[str, Any]) -> str:
    """A constant with its error, a question mark where the data do not determine it."""
    if row["verdict"] in DETERMINED:
        return f"{row['value']:.4g} +- {(row['upper'] - row['lower']) / 2:.2g}"
    return f"{row['value']:.4g}" + (" ?" if row["verdict"] != "no interval" else "")


def _judged(verdicts: pd.DataFrame) -> list[str]:
    """Both criteria of the comparison, one row each per oil."""
    rows = []
    for row in tables.rows(verdicts.dropna(subset=["left_out_difference", "bic_difference"])):
        apart = 100 * row["left_out_difference"], 100 * row["left_out_difference_error"]
        by_error = f"{apart[0]:.2g} +- {apart[1]:.2g} % of mu"
        by_bic = f"{row['bic_difference']:.0f} +- {row['bic_difference_error']:.0f}"
        rows += [
            [
                row["oil"],
                f"curves left out: error {row['left_out_relative_rms']:.2%} of mu",
                f"{law_name(row['left_out_law'])} ({row['best_left_out_relative_rms']:.2%})",
                "-" if row["left_out_law"] == row["law"] else by_error,
                _ties(row["left_out_ties"]),
            ],
            [
                row["oil"],
                "BIC",
                law_name(row["bic_law"]),
                "-" if row["bic_law"] == row["law"] else by_bic,
                _ties(row["bic_ties"]),
            ],
        ]
    header = ["oil", "criterion", "best law", "configured law is worse by", "tie with the best law"]
    return text_table(header, rows)


def _ties(laws: str) -> str:
    """The other laws of those that tie with the best one."""
    _, *others = laws.split(", ")
    return ", ".join(map(law_name, others)) or "none"


def _extrapolated(compared: pd.DataFrame) -> list[str]:
    """How wrong each law is where the truth was simulated."""
    rows = [
        [
            law_name(row["law"]),
            _known(row["inside_relative_rms"], ".3g"),
            _known(row["beyond_relative_rms"], ".3g"),
            _known(row["beyond_interval_ratio"], ".0f"),
            f"{row['worst_traction_coefficient']:.4g}",
            f"{row['worst_true_traction_coefficient']:.4g}",
            f"{row['worst_max_hertz_pressure_gpa']:g} GPa, "
            f"{row['worst_entrainment_speed_m_s']:g} m/s, "
            f"{row['worst_inlet_temperature_c']:g} degC, S {row['worst_slide_roll_ratio']:g}",
        ]
        for row in errors_by_law(compared)
    ]
    header = ["law", "error in tested box", "beyond it", "truth in interval", "worst mu", "true mu"]
    if not rows:
        return []
    note = (
        "Against the SIMULATED truth at the conditions of Figs 7-10, which decides nothing about "
        "the real oils. Errors are rms, in % of mu. The truth is in the 95 % interval of the fit "
        "at this % of the conditions beyond the tested box."
    )
    return [note, "", *text_table([*header, "worst condition"], rows)]


def _known(share: float, form: str) -> str:
    return "-" if np.isnan(share) else format(100 * share, form)
