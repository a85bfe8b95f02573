"""What the library makes of a blind laboratory's logs, in numbers."""

from collections.abc import Iterator
from dataclasses import dataclass, field
from itertools import product
from pathlib import Path

import numpy as np
import pandas as pd

from blind_lab.laboratory import CAMPAIGN, Laboratory
from oilfilm.curation.curate import CuratedTables, curate_logs
from oilfilm.curation.run_gates import WARNINGS
from oilfilm.fits.fit import fit_oil
from oilfilm.fits.fitted import FittedLaw
from oilfilm.settings.resolve import resolve
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables

# Names of warnings that follow from the other runs of the campaign.
CAMPAIGN_WARNINGS = ("constant_channel", "unusual_shape", "odd_alone")


@dataclass(frozen=True)
class Outcome:
    """What became of one laboratory's logs.

    Attributes:
        false_alarms: Sound logs that were refused or named.
        refused_points: Share of the points of sound logs that were refused.
        silent: Faults that no rule or warning named.
        misnamed: Faults that were stopped by a rule that sends people the wrong way.
        right: How many faults were stopped or named by a right rule.
        faults: How many there were.
        named: Faults of curves that the fit named.
        inside: For each constant of each oil, whether its 95 % interval holds the truth.
        rms: Per oil, relative rms error of mu over the tested box, the sound logs fitted.
    """

    false_alarms: list[str]
    refused_points: float
    silent: list[str]
    misnamed: list[str]
    right: int
    faults: int
    named: list[str] = field(default_factory=list)
    inside: list[bool] = field(default_factory=list)
    rms: dict[str, float] = field(default_factory=dict)


def settings_of(project: Path) -> Settings:
    """Settings of the laboratory's campaign."""
    return resolve(project / "config", {"campaign": CAMPAIGN})


def curated(project: Path, settings: Settings) -> CuratedTables:
    """The verdicts on every log in the folder."""
    raw = project / "data" / "raw" / CAMPAIGN
    return curate_logs([(path.name, path.read_bytes()) for path in sorted(raw.iterdir())], settings)


def outcome(laboratory: Laboratory, verdicts: CuratedTables) -> Outcome:
    """Detection and false alarms of curation."""
    runs, quarantine = verdicts.runs.set_index("file"), verdicts.quarantine
    # a run of which most plateaus fail names their gates in its sentence
    refusals = quarantine["rule"] + ": " + quarantine["reason"]
    refusal_of_file = refusals.groupby(quarantine["file"]).agg(" ".join)
    files = runs.index.union(refusal_of_file.index)
    warning_of_file = runs["warning"].map("; ".join).reindex(files, fill_value="")
    names_of_warnings = [*(warning.name for warning in WARNINGS), *CAMPAIGN_WARNINGS]
    complaint_of_file = {}
    for file, warning in warning_of_file.items():
        if file in refusal_of_file or any(name in warning for name in names_of_warnings):
            complaint_of_file[file] = f"{refusal_of_file.get(file, '')} {warning}".strip()
    sound = {log.file for log in laboratory.sound}
    accepted = set(runs.index[runs["verdict"] == "accepted"])
    false_alarms = [
        f"{file}: {complaint_of_file.get(file)}"
        for file in sorted(sound)
        if file in complaint_of_file or file not in accepted
    ]
    right_count = 0
    silent, misnamed = [], []
    for log in laboratory.faulty:
        complaint = complaint_of_file.get(log.file)
        if complaint is None:
            silent.append(log.fault)
        elif any(rule in complaint for rule in log.rules):
            right_count += 1
        else:
            misnamed.append(f"{log.fault}: {complaint}")
    refused_share = float((~_points_of_files(verdicts, sound)["accepted"]).mean())
    fault_count = len(laboratory.faulty)
    return Outcome(false_alarms, refused_share, silent, misnamed, right_count, fault_count)


def with_fits(
    outcome: Outcome, laboratory: Laboratory, verdicts: CuratedTables, settings: Settings
) -> None:
    """Add coverage of the intervals and errors of mu."""
    sound = {log.file for log in laboratory.sound}
    for oil in laboratory.oils:
        fit = fit_oil(verdicts.points, oil, settings.fit, settings.seed)
        residuals = fit.curve_residuals
        odd = set(residuals.loc[residuals["odd"], "run_id"])
        for log in laboratory.logs:
            if log.file in odd and log.fault in outcome.silent and "odd_shape" in log.rules:
                outcome.silent.remove(log.fault)
                outcome.named.append(log.fault)
            elif log.file in odd and not log.fault:
                outcome.false_alarms.append(log.file)
        fit_of_sound = fit_oil(_points_of_files(verdicts, sound), oil, settings.fit, settings.seed)
        outcome.inside.extend(_constants_inside(fit_of_sound, laboratory.oils[oil].constants))
        outcome.rms[oil] = _rms(fit_of_sound, laboratory, oil)


def _points_of_files(verdicts: CuratedTables, files: set[str]) -> pd.DataFrame:
    runs = verdicts.runs
    points = verdicts.points
    return points[points["run_id"].isin(runs.loc[runs["file"].isin(files), "run_id"])]


def _constants_inside(fit: CampaignTables, truth: list[float]) -> Iterator[bool]:
    """For each constant, whether its interval holds the truth."""
    rows = fit.coefficients.set_index("constant")
    names = [name for name in rows.index if name[-1:].isdigit()]
    for name, value in zip(names, truth, strict=True):
        lower, upper = rows.loc[name, ["lower", "upper"]]
        yield bool(lower <= value <= upper)


def _rms(fit: CampaignTables, laboratory: Laboratory, oil: str) -> float:
    """Relative rms error of mu against the truth over the box of the sound logs."""
    fitted = FittedLaw.from_tables(fit.coefficients, oil)
    conditions = np.array(list(product((1.0, 1.2, 1.4), (16.0, 24.0, 34.0), (42.0, 65.0, 88.0))))
    slip = np.array([0.01, 0.03, 0.08, 0.15])
    conditions_of_points = np.repeat(conditions, len(slip), axis=0)
    slip_of_points = np.tile(slip, len(conditions))
    true_mu = laboratory.oils[oil].traction(*conditions_of_points.T, slip_of_points)
    mu = fitted.predict(conditions_of_points, slip_of_points).traction_coefficient
    return float(np.sqrt(np.mean((mu / true_mu - 1) ** 2)))
