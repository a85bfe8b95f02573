"""The answer to the first question: how large is mu, how sure, and can the fit be trusted."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from oilfilm import tables
from oilfilm.report.document import Section
from oilfilm.report.explorer import LEVEL, explored_fits, load_at_1_gpa, sliders
from oilfilm.report.shown_table import Column, ShownTable, number
from oilfilm.report.words import CONDITIONS, law_name
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables

_MU = number("#.3g")
_BESIDE = {"best": "best of those compared", "tie": "ties with others"}


def answer(results: CampaignTables, settings: Settings) -> Section:
    """A row per oil: mu at one operating point with its interval, the law, runs, soundness."""
    load_n = load_at_1_gpa(settings)
    fits = explored_fits(results, load_n)
    axes = sliders(fits, results.points, settings)
    pressure, speed, temperature, slip = [np.nan if axis.idle else axis.start for axis in axes]
    compared = {row["oil"]: row for row in tables.rows(results.law_verdicts)}
    sound = {row["oil"]: row for row in tables.rows(results.soundness)}
    runs = results.runs.assign(accepted=results.runs["verdict"] == "accepted")
    counts = runs.groupby("oil")["accepted"].agg(["sum", "size"])
    rows = []
    for fit in tables.rows(results.configured.fit_quality):
        oil, mu, interval = str(fit["oil"]), np.nan, "not known"
        if oil in fits:
            first = pressure
            if load_n is not None and "load_n" in fits[oil].law.conditions:
                first = load_n * pressure**3
            at = fits[oil].predict(np.array([[first, speed, temperature]]), np.array([slip]))
            mu, ends = at.traction_coefficient[0], [at.obs_ci_lower[0], at.obs_ci_upper[0]]
            level = fits[oil].coefficients.bands(fits[oil].law, LEVEL)[2]
            if not np.isnan(ends).any():
                interval = f"{_MU(ends[0])} to {_MU(ends[1])} ({100 * level:.2g} %)"
            if at.outside[0]:
                interval += ", not tested there"
            if at.over_limit[0]:
                interval += ", above the limiting shear stress"
        rows.append(
            [
                oil,
                _MU(mu),
                interval,
                law_name(fit["law"]),
                _beside_others(compared[oil]) if oil in compared else "not compared",
                _soundness(sound[oil]) if oil in sound else "not sound",
                "{sum} of {size}".format(**counts.loc[oil]) if oil in counts.index else "none",
            ]
        )
    columns = [
        Column("oil", "Oil"),
        Column("mu", "mu"),
        Column("interval", "Next good run"),
        Column("law", "Law"),
        Column("beside", "Beside other laws", is_verdict=True),
        Column("fit", "Fit", is_verdict=True),
        Column("runs", "Runs accepted"),
    ]
    point = ", ".join(
        f"{symbol} {axis.start:.{axis.digits}f} {unit}".rstrip()
        for axis, (symbol, _, unit) in zip(axes, CONDITIONS.values(), strict=True)
        if not axis.idle
    )
    table = ShownTable("answers", f"At {point}", columns, rows, in_text=True)
    return Section("answer", "Answer", tables=[table])


def _soundness(row: Mapping[str, Any]) -> str:
    """Whether a fit is sound, and otherwise which parts are not; sentences are among trouble."""
    parts = [] if row["optimum_confirmed"] else ["optimum not confirmed"]
    parts += [f"law: {row['law_verdict']}"] if row["law_verdict"] != "adequate" else []
    parts += [f"campaign: {row['campaign_verdict']}"] if row["campaign_verdict"] != "steady" else []
    return "sound" if row["sound"] else f"not sound ({'; '.join(parts)})"


def _beside_others(row: Mapping[str, Any]) -> str:
    """How the configured law compares with the others."""
    if row["verdict"] == "another law is better":
        return f"worse than {law_name(row['better_law'])}"
    return _BESIDE.get(row["verdict"], f"not decided: {row['verdict']}")
