"""The verdicts on laws and on noise in words, from codes and numbers of the tables.

Decides: what a verdict on a law says and advises; what a verdict on noise says and advises.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

from oilfilm import tables
from oilfilm.fits.best_law import FEWEST_CURVES
from oilfilm.traction import LAWS
from oilfilm.traction.law import QUANTITIES

Row = Mapping[str, Any]


def law_head(row: Row, quality: pd.DataFrame) -> str:
    """The verdict on the configured law of an oil, without numbers.

    Args:
        row: Row of the table `law_verdicts`.
        quality: Table of fit quality.
    """
    law = row["law"]
    fit = _laws_of(row, quality)[law]
    shared = ", ".join(name for name in _by_both(row) if name != law)
    return {
        "best": f"the configured law {law} is the best of those compared",
        "tie": f"the configured law {law} ties with {shared}: the data do not tell them apart",
        "criteria disagree": f"the two criteria disagree about the configured law {law}",
        "another law is better": f"{row['better_law']} describes the data better than the "
        f"configured law {law}",
        "no other law": "not compared: compare.laws of the settings names no other law; name some, "
        "or leave it out for all",
        "no fit": f"not compared: the configured law {law} has no fit ({fit['certificate']})",
        "no other fit": f"not compared: no law but {law} could be fitted",
        "constants left open": "not compared: the other curves leave a constant of the configured "
        "law open",
        "too few curves": f"not compared: {fit['n_curves']} curves are too few to tell differences "
        "between laws from errors of single curves; measure "
        f"{FEWEST_CURVES} at least",
    }[row["verdict"]]


def law_finding(row: Row, quality: pd.DataFrame) -> str:
    """The same with the numbers of both criteria."""
    head = law_head(row, quality)
    if np.isnan(row["left_out_difference"]):
        return head
    law, best = row["law"], row["left_out_law"]
    unseen = (
        f"At the {_laws_of(row, quality)[law]['n_curves']} curves, each left out of the fit, "
        f"the rms error of {law} is {row['left_out_relative_rms']:.2%} of mu"
    )
    if best == law:
        unseen += f", the least{_tied(row['left_out_ties'])}"
    else:
        apart = 100 * row["left_out_difference"], 100 * row["left_out_difference_error"]
        tie = ", a tie" if law in row["left_out_ties"].split(", ") else ""
        unseen += f". That of {best} is {row['best_left_out_relative_rms']:.2%}"
        unseen += f" (difference {apart[0]:.2g} +- {apart[1]:.2g} %{tie})"
    best = row["bic_law"]
    if best == law:
        return f"{head}. {unseen}. The BIC of {law} is the lowest{_tied(row['bic_ties'])}"
    tie = ", a tie" if law in row["bic_ties"].split(", ") else ""
    return (
        f"{head}. {unseen}. The BIC of {best} is lower than that of {law} by "
        f"{row['bic_difference']:.0f} +- {row['bic_difference_error']:.0f}{tie}"
    )


def law_advice(row: Row, quality: pd.DataFrame) -> str:
    """What to do about the law; empty where the configured law is as good as any."""
    law, laws = row["law"], _laws_of(row, quality)
    if row["verdict"] == "criteria disagree":
        return "Keep the configured law until more curves decide"
    if row["verdict"] == "tie":
        fewest = min(_by_both(row), key=lambda name: int(laws[name]["n_constants"]))
        key = f" (`fit: {{law: {fewest}}}`)" if fewest in LAWS else ""
        simpler = f"Keep it, or take the law with the fewest constants: {fewest}{key}"
        return "" if fewest == law else simpler
    if row["verdict"] != "another law is better":
        return ""
    better = row["better_law"]
    old, new = laws[law], laws[better]
    sentences = [
        f"To use it, write `fit: {{law: {better}}}` under `settings` of the campaign file"
        if better in LAWS
        else f"{better} is compared only: `fit.law` does not take it",
        f"It has {new['n_constants']} fitted constants in place of {old['n_constants']}",
        f"It misses the points by {new['relative_rms']:.2%} of mu in place of "
        f"{old['relative_rms']:.2%}",
    ]
    if not new["certified"]:
        sentences.append("Its fit is not certified: set `fit: {allow_uncertified: true}` as well")
    if row["ends_out_law"] not in ("", better):
        sentences.append(
            f"Beyond the tested levels {row['ends_out_law']} did best (end levels left out)"
        )
    if better in LAWS and LAWS[law].conditions != LAWS[better].conditions:
        of_old, of_new = (
            ", ".join(QUANTITIES[name].meaning.partition(",")[0] for name in LAWS[each].conditions)
            for each in (law, better)
        )
        sentences.append(
            f"It takes {of_new}. {law} takes {of_old}. What a law does not take, it cannot "
            "predict: predictions and exports then need the other conditions"
        )
    return ". ".join(sentences)


def noise_finding(row: Row) -> str:
    """What a fit misses beside the noise; `row` of the table `lack_of_fit`."""
    if row["verdict"] == "no fit":
        return "nothing was fitted, so that nothing is known of the noise"
    plateaus = ""
    if not np.isnan(row["plateau_relative_rms"]):
        plateaus = (
            f". Readings within plateaus alone scatter by {row['plateau_relative_rms']:.2%}, a "
            "lower bound of the noise"
        )
    residual = f"residuals are {row['relative_rms']:.2%} of mu (rms)"
    if row["verdict"] == "no repeats":
        return (
            f"{residual}. Noise and lack of fit cannot be told apart, because no runs repeat a "
            f"condition{plateaus}"
        )
    runs = "run repeats" if row["n_repeats"] == 1 else "runs repeat"
    chance = "is more than chance" if row["verdict"] == "shown" else "may be chance"
    return (
        f"{residual}. Repeats explain {row['repeat_relative_rms']:.2%} ({row['n_repeats']} {runs} "
        f"an earlier one). The lack of fit of the law is {row['lack_of_fit_relative_rms']:.2%}, "
        f"which {chance} (F = {row['lack_of_fit_ratio']:.3g}, 95 % limit "
        f"{row['lack_of_fit_limit']:.3g}){plateaus}"
    )


def noise_advice(row: Row) -> str:
    """What to do about noise and lack of fit; empty where there is nothing to do."""
    if row["verdict"] == "shown":
        return "Another form of law may miss less; more repeats do not help"
    if row["verdict"] != "no repeats":
        return ""
    many = ". ".join(
        f"{repeats} repeated runs show a lack of fit where residuals are over "
        f"{row[f'detectable_ratio_{repeats}_repeats']:.1f} times the noise"
        for repeats in (2, 5)
    )
    return (
        "Run some conditions again, best the extreme ones. Set `repeated_conditions: accept` in "
        f"the campaign file. {many}"
    )


def _laws_of(row: Row, quality: pd.DataFrame) -> dict[str, Row]:
    """The fits of a verdict's oil by the names of their laws."""
    return {fit["law"]: fit for fit in tables.rows(quality[quality["oil"] == row["oil"]])}


def _by_both(row: Row) -> list[str]:
    """The laws that are among the best by both criteria."""
    by_bic = row["bic_ties"].split(", ")
    return [name for name in row["left_out_ties"].split(", ") if name in by_bic]


def _tied(ties: str) -> str:
    _, *others = ties.split(", ")
    return f", a tie with {', '.join(others)}" if others else ""
