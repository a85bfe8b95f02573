"""What torque logs and the bearing's model come to, in a few lines of text."""

import numpy as np
import pandas as pd

from oilfilm.tables import failed_gates
from oilfilm.tables.campaign_tables import CampaignTables


def bearing_words(results: CampaignTables) -> list[str]:
    """Logs and plateaus, errors of each basis, soundness, what traction decides, cage slip."""
    lines = ["Bearing torque (torque.parquet and the tables beside it):", *_logs(results)]
    calculated = results.torque[results.torque["converged"]]
    lines += _not_compared(results)
    if len(calculated):
        lines += _errors(calculated)
    if len(results.torque):
        lines += _soundness(results.torque)
    if len(calculated):
        lines += _beyond(calculated)
    lines += [*_inverted(results.torque_inversion), *_advice(results.slip_advice)]
    return [*lines, ""]


def _logs(results: CampaignTables) -> list[str]:
    runs, refused = results.torque_runs, results.torque_quarantine
    files = {run_id.rpartition(":")[0] or run_id for run_id in runs["run_id"]}
    lines = [
        f"  torque logs {len(files)} read of {len(files | set(refused['file']))}; plateaus "
        f"{runs['accepted'].sum()} accepted of {len(runs)}"
    ]
    for rule, cases in refused.groupby("rule"):
        case = cases.iloc[0]
        lines += [
            f"  torque quarantine, {rule} {len(cases)}: {case['run_id'] or case['file']}: "
            f"{case['reason']}",
            f"    -> {case['advice']}",
        ]
    gates = failed_gates.counts(runs)
    if len(gates):
        told = ", ".join(f"{gate} {count}" for gate, count in gates.items())
        lines.append(f"  plateaus refused by: {told}")
    return lines


def _not_compared(results: CampaignTables) -> list[str]:
    """Oils whose plateaus no law could be asked for."""
    accepted = results.torque_runs.loc[results.torque_runs["accepted"], "oil"]
    counts = accepted[~accepted.isin(results.torque["oil"])].value_counts()
    return [
        f"  not compared: {count} plateaus of {oil}, which lacks a fitted law, properties, or a "
        "traction rig whose contact is known"
        for oil, count in counts.items()
    ]


def _errors(calculated: pd.DataFrame) -> list[str]:
    size = calculated["relative_error"].abs().groupby(calculated["load_variable"], sort=False)
    told = [
        f"{basis} {median:.1%}, {largest:.1%}"
        for basis, median, largest in zip(size.groups, size.median(), size.max(), strict=True)
    ]
    return [f"  error of the calculated torque, median and largest, by basis: {'; '.join(told)}"]


def _soundness(torque: pd.DataFrame) -> list[str]:
    lost = (~torque["converged"]).sum()
    sound = torque[torque["converged"]]
    line = f"  of {len(torque)} equilibria {lost or 'none'} not found"
    if len(sound):
        line += (
            f"; largest residual {sound['residual'].max():.0e} of a ball's load, energy error "
            f"{sound['energy_error'].abs().max():.0e}, quadrature error "
            f"{sound['quadrature_error'].abs().max():.0e}"
        )
    return [line, *(f"    {why}" for why in torque.loc[~torque["converged"], "why"].unique())]


def _beyond(calculated: pd.DataFrame) -> list[str]:
    by_stress = calculated[calculated["load_variable"] == "stress"]
    share = by_stress["traction_torque_n_m"] / by_stress["torque_n_m"]
    mean = {
        name: by_stress[f"share_beyond_{name}"].mean() for name in ("pressure", "speed", "slip")
    }
    told = [
        f"{what} {'not known' if np.isnan(value) else format(value, '.0%')}"
        for what, value in mean.items()
    ]
    return [
        f"  traction makes {share.min():.0%} to {share.max():.0%} of the torque; mean share of its "
        f"heat beyond the tested box: {', '.join(told)}"
    ]


def _inverted(inversion: pd.DataFrame) -> list[str]:
    if inversion.empty:
        return []
    known = (inversion["verdict"] == "determined").sum()
    return [
        f"  traction coefficient from the measured torque: determined at {known} of "
        f"{len(inversion)} plateaus (torque_inversion.parquet)"
    ]


def _advice(advice: pd.DataFrame) -> list[str]:
    asked = advice[advice["judgement"] != "no film"]
    if asked.empty:
        return []
    agreed = asked["judgement"] == "agree"
    line = (
        "  cage slip: the oil that the paper's rules advise holds the cage with the least torque, "
        f"or slips least, at {agreed.sum()} of {len(asked)} operating points with enough film"
    )
    if not agreed.all():
        counts = asked.loc[~agreed, "judgement"].value_counts()
        apart = [f"{judgement} ({count})" for judgement, count in counts.items()]
        better = asked.loc[~agreed, "best_oil"].value_counts()
        told = ", ".join(f"{oil} at {count}" for oil, count in better.items())
        line += f"; elsewhere it {', '.join(apart)}; best by slip: {told}"
    return [f"{line} (slip_advice.parquet)"]
