"""What the surface of an oil says beside the verdict on its fit, in sentences.

Decides: what is said of the surface behind a verdict.
"""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from oilfilm import tables
from oilfilm.fits.measured_surface import ANOTHER_RIG_NAME, OilSurface
from oilfilm.fits.soundness_sentences import smallest_visible_changes_sentence
from oilfilm.tables.campaign_tables import CampaignTables

# Beginning of the warning that a rig spins.
_RIG_SPIN = "rig_spin:"
# Meaning of each name in the column `usual_errors`.
_WORDS_BY_ERROR_NAME = {
    "gain": "traction force",
    "zero": "zero of the force",
    "slip_scale": "slip",
    "temperature_k": "inlet temperature",
    "noise": "noise of points",
    "rig_gain": "difference of rigs",
}


def surface_sentences(
    results: CampaignTables, oil: str, soundness_row: Mapping[str, Any]
) -> list[str]:
    """Misfit, steadiness, search, errors of constants and what was assumed, in sentences.

    Args:
        results: Tables `surfaces`, `surface_constants` and `coefficients`.
        oil: The oil; without a surface there is nothing to say.
        soundness_row: Its row of the table `soundness`.
    """
    surfaces = tables.rows(results.surfaces[results.surfaces["oil"] == oil])
    if not surfaces:
        return []
    (surface_row,) = surfaces
    sentences = [
        misfit_sentence(soundness_row["misfit"], soundness_row["run_scatter"]),
        smallest_visible_changes_sentence(soundness_row),
        search_end_sentence(surface_row["search_converged"]),
        _constant_errors_sentence(results, oil),
        _assumed_errors_sentence(surface_row["usual_errors"]),
        rigs_sentence(surface_row["rig_of_runs"], surface_row["rig_gain_sd"]),
    ]
    return [sentence for sentence in sentences if sentence]


def rigs_sentence(rig_name_of_run: Sequence[str] | None, rig_gain_sd: float) -> str:
    """What an interval knows of rigs; empty where all accepted runs are of one rig.

    Args:
        rig_name_of_run: Name of the rig of each accepted run; None where the data name no rigs.
        rig_gain_sd: Standard deviation of the gain of a rig, relative; NaN where rigs are not told
            apart.
    """
    if rig_name_of_run is None:
        return (
            "The data name no rigs: all runs count as those of one rig, on which the next one is."
        )
    rig_count = len(set(rig_name_of_run))
    if rig_count < 2 or np.isnan(rig_gain_sd):
        return ""
    return (
        f"The runs are of {rig_count} rigs, whose forces differ by {rig_gain_sd:.1%} (standard "
        "deviation; where each rig ran other conditions, this is in part what rigs usually differ "
        "by). The interval is that of a run on one of these rigs. For another rig it is wider: "
        "oilfilm predict --rig another."
    )


def spin_sentence(runs: pd.DataFrame, oil: str) -> str:
    """Why an interval does not contain the spin of a rig; empty where the spin is small.

    The spin of a rig is a warning of one of its runs where mu lacks more than 1 % by it.

    Args:
        runs: Table of runs, of all oils.
        oil: Name of the oil.
    """
    has_spin_warning = runs["warning"].map(
        lambda warnings: any(warning.startswith(_RIG_SPIN) for warning in warnings)
    )
    runs_of_oil = runs[(runs["oil"] == oil) & (runs["verdict"] == "accepted")]
    rig_names = sorted(
        set(runs.loc[has_spin_warning.astype(bool), "rig"]) & set(runs_of_oil["rig"])
    )
    if not rig_names:
        return ""
    return (
        f"The interval does not contain the spin of {', '.join(rig_names)}, which lowers mu by "
        "more than 1 % at the lowest slips (warning rig_spin). The spin is no scatter: the next "
        "run on the rig has the same. A contact without spin, as in a bearing, has more traction "
        "there."
    )


def next_rig_sentences(oil_surface: OilSurface, rig_name: str | None) -> list[str]:
    """On which rig the next run is, where the runs are of several rigs: a sentence or none.

    Args:
        oil_surface: The surface of an oil.
        rig_name: Name of the rig of the next run; None for one of the rigs of the runs.
    """
    # empty for one rig, or unknown ones
    rig_names = oil_surface.rig_names
    if not rig_names:
        return []
    if rig_name is None:
        return [
            f"the next run is on one of the rigs {', '.join(rig_names)} (--rig for one of them)"
        ]
    if rig_name == ANOTHER_RIG_NAME:
        return [
            f"the next run is on another rig: what rigs differ by is known from {len(rig_names)} "
            "rigs and from what was expected before the data"
        ]
    return [f"the next run is on the rig {rig_name}"]


def misfit_sentence(misfit: float, run_scatter: float) -> str:
    """The misfit of the law beside what runs scatter; empty where one is not known.

    Args:
        misfit: Misfit of the law, relative to mu.
        run_scatter: Change of mu by the errors of runs, relative to mu.
    """
    if np.isnan(misfit) or np.isnan(run_scatter):
        return ""
    return (
        f"The law departs from the measurements by {misfit:.1%} of mu (rms), and runs scatter by "
        f"{run_scatter:.1%}."
    )


def search_end_sentence(has_converged: bool) -> str:
    """That the search of a surface found no maximum, as a sentence; empty where it did."""
    if has_converged:
        return ""
    return (
        "The search of the surface ended before its maximum: the interval rests on its last step."
    )


def _constant_errors_sentence(results: CampaignTables, oil: str) -> str:
    """The errors of constants by the surface, beside those of the fit."""
    constants_of_surface = results.surface_constants
    constants_of_surface = constants_of_surface[constants_of_surface["oil"] == oil].set_index(
        "constant"
    )
    law = constants_of_surface["law"].iloc[0]
    if constants_of_surface["standard_error"].isna().all():
        return (
            f"The surface gives no errors of the constants of {law}: the law departs too far from "
            "the measurements."
        )
    coefficients = results.coefficients
    constants_of_fit = coefficients[
        (coefficients["oil"] == oil) & (coefficients["law"] == law)
    ].set_index("constant")
    ratio = (constants_of_surface["standard_error"] / constants_of_fit["standard_error"]).dropna()
    if ratio.empty:
        return ""
    return (
        f"With the errors of runs in the model, the constants of {law} have standard errors of "
        f"{ratio.min():.2g} to {ratio.max():.2g} times those of the fit (table surface_constants)."
    )


def _assumed_errors_sentence(usual_error_names: list[str]) -> str:
    """Which errors between runs the files of rigs do not state."""
    if not usual_error_names:
        return ""
    names = ", ".join(_WORDS_BY_ERROR_NAME[error_name] for error_name in usual_error_names)
    keys = "errors_between_runs"
    if "rig_gain" in usual_error_names:
        keys += "; calibration for the difference of rigs"
    return (
        f"Errors between runs that the rig's file does not state are assumed as on usual rigs: "
        f"{names} ({keys})."
    )
