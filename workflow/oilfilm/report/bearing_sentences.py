"""What torque logs and the bearing's model come to, as tables and sentences."""

import numpy as np
import pandas as pd

from oilfilm import tables
from oilfilm.paper.selection import OUTSIDE
from oilfilm.report.facts import (
    LACKING,
    accepted_torque_logs,
    oil_heat,
    plateaus_not_calculated,
)
from oilfilm.report.labels import OTHER_CHOICES, gate_name, load_variable
from oilfilm.report.plain_text import bullet, listed, percent, section, sentence, text_table
from oilfilm.report.refused_sentences import refused_lines
from oilfilm.tables import failed_gates
from oilfilm.tables.campaign_tables import CampaignTables
from oilfilm.torque.torque_control import bistable_points, without_bistable


def bearing_lines(results: CampaignTables) -> list[str]:
    """Logs and plateaus, errors, soundness, what traction decides, cage slip, heat."""
    calculated = results.torque[results.torque["converged"]]
    return section(
        "Bearing torque",
        [*_logs(results), *_not_compared(results)],
        _errors(calculated),
        [
            *(_remarks(calculated) if len(calculated) else []),
            *(f"- {sentence(each)}" for each in control_sentences(results.torque_control)),
            *(_soundness(results.torque) if len(results.torque) else []),
            *(_beyond(calculated) if len(calculated) else []),
            *_inverted(results.torque_inversion),
        ],
        _advice(results.slip_advice, results.advice_band),
        _heat(results.heat_balance),
    )


def _logs(results: CampaignTables) -> list[str]:
    runs, refused = results.torque_runs, results.torque_quarantine
    read, logs, kept = accepted_torque_logs(results)
    lines = [
        f"- Torque logs: {read} of {logs} were read. {kept} have runs that were not refused.",
        f"- Plateaus: {runs['accepted'].sum()} of {len(runs)} are accepted.",
        *refused_lines(refused, "torque_quarantine"),
    ]
    gates = failed_gates.counts(runs)
    if len(gates):
        lines += bullet(f"Plateaus refused, by gate: {listed(gates.rename(gate_name))}.")
    return lines


def _not_compared(results: CampaignTables) -> list[str]:
    """Oils whose plateaus no law could be evaluated for."""
    return [
        f"- Not compared: {count} plateaus of {oil}. The oil {LACKING}."
        for oil, count in plateaus_not_calculated(results).items()
    ]


def _errors(calculated: pd.DataFrame) -> list[str]:
    """Calculated beside measured torque, one row per law and load variable."""
    sure = without_bistable(calculated)
    rows = []
    for basis, of_basis in sure.groupby("load_variable", sort=False):
        size = of_basis["relative_error"].abs()
        known = of_basis[of_basis["verdict"] != "not known"]
        within = f"{(known['verdict'] == 'compatible').sum()} of {len(known)} plateaus"
        rows.append(
            [
                load_variable(str(basis)),
                percent(size.median(), 1),
                percent(size.max(), 1),
                within if len(known) else "not known",
            ]
        )
    header = ["calculated torque", "median error, %", "largest error, %"]
    table = text_table([*header, "agreement"], rows)
    note = "Agreement: the difference is within twice its standard uncertainty."
    return [*table, "", note] if table else []


def _remarks(calculated: pd.DataFrame) -> list[str]:
    """Plateaus that are left out of the errors, and why there is no uncertainty."""
    lines = []
    if points := bistable_points(calculated):
        plateaus = calculated.groupby(["run_id", "first_row"])["bistable"].any()
        lines += bullet(
            f"Left out, because the cage may roll or skid: {plateaus.sum()} of {len(plateaus)} "
            f"plateaus. Operating points: {points}."
        )
    if (without_bistable(calculated)["verdict"] == "not known").all():
        lines += bullet(
            "The calculated torque has no uncertainty, because the law has no refits.",
            "Measure more runs (fit.min_curves_to_resample)",
        )
    return lines


def control_sentences(control: pd.DataFrame) -> list[str]:
    """What the comparison with SIMULATED torque shows, a few sentences per verdict.

    Args:
        control: Table `torque_control`; empty where the torque was measured.
    """
    texts = []
    for verdict, rows in control.groupby("verdict", sort=False):
        apart = f"{rows['law_misfit'].max():.1%} of mu"
        text = {
            "positive control": "positive control: the fitted law itself made the SIMULATED logs "
            "of both rigs. This checks the code and says nothing of the paper's claim.",
            "one truth": "one simulated truth, which is no fitted law, made the logs of both rigs. "
            f"Their tractions are {apart} apart. This says nothing of real oils.",
            "two truths": "NOT COMPARABLE: the simulated truths behind the logs of the two rigs "
            f"are {apart} apart (audit.twin_misfit_max).",
        }[str(verdict)]
        known = rows.dropna(subset=["median_torque_error"])
        errors = [
            f"{row['oil']} {row['median_torque_error']:.1%}, {row['largest_torque_error']:.1%}"
            for row in tables.rows(known)
        ]
        if errors:
            text += f" Error of the pressure-based law, median and largest: {'; '.join(errors)}."
        texts.append(text)
    return texts


def _soundness(torque: pd.DataFrame) -> list[str]:
    lost = (~torque["converged"]).sum()
    sound = torque[torque["converged"]]
    lines = [f"- Friction equilibria: {len(torque) - lost} of {len(torque)} were found."]
    lines += [f"  - Not found: {why}" for why in torque.loc[~torque["converged"], "why"].unique()]
    if len(sound):
        lines.append(
            f"- Largest numerical errors: residual {sound['residual'].max():.0e} of a ball's load, "
            f"energy {sound['energy_error'].abs().max():.0e}, quadrature "
            f"{sound['quadrature_error'].abs().max():.0e}."
        )
    return lines


def _beyond(calculated: pd.DataFrame) -> list[str]:
    by_stress = calculated[calculated["load_variable"] == "stress"]
    share = by_stress["traction_torque_n_m"] / by_stress["torque_n_m"]
    names = ("pressure", "speed", "slip")
    means = [by_stress[f"share_beyond_{name}"].mean() for name in names]
    beyond = [
        f"{name} {'not known' if np.isnan(mean) else format(mean, '.0%')}"
        for name, mean in zip(names, means, strict=True)
    ]
    return [
        f"- Traction makes {share.min():.0%} to {share.max():.0%} of the torque. "
        f"Mean share of its heat beyond the tested box: {', '.join(beyond)}."
    ]


def _inverted(inversion: pd.DataFrame) -> list[str]:
    if inversion.empty:
        return []
    known = (inversion["verdict"] == "determined").sum()
    return [
        f"- Traction coefficient from the measured torque: determined at {known} of "
        f"{len(inversion)} plateaus (torque_inversion.parquet)."
    ]


def _advice(advice: pd.DataFrame, band: pd.DataFrame) -> list[str]:
    """The paper's choice of oil beside the best oil by cage slip and torque."""
    with_film = advice[~advice["judgement"].isin(["no film", OUTSIDE])]
    if with_film.empty:
        return []
    total, others = len(with_film), with_film[with_film["judgement"] != "agree"]
    lines = [
        "Choice of oil by cage slip (slip_advice.parquet):",
        "",
        f"- The paper's advice agrees with the best oil at {total - len(others)} of {total} "
        f"operating points. {_band(band)}",
    ]
    if len(others):
        lines += [
            f"- {OTHER_CHOICES.get(str(judgement), str(judgement))}: at {count} operating points."
            for judgement, count in others["judgement"].value_counts().items()
        ]
        best = listed(others["best_oil"].value_counts(), "{} at {}")
        lines += bullet(f"Best oil where the advice does not agree: {best}.")
    if len(band):
        certain = (with_film["best_oil_share"] == 1).sum()
        lines += bullet(
            f"The best oil is certain at {certain} operating points: it is as good as any in every "
            "scenario (advice_band.parquet)."
        )
    return lines


def _band(band: pd.DataFrame) -> str:
    """The numbers of agreeing points over the scenarios."""
    if band.empty:
        return "Drag and law were not varied."
    agreeing, fraction = band["agreeing_points"], band["oil_volume_fraction"]
    return (
        f"With other drag and other refits of the law it is {agreeing.min()} to {agreeing.max()} "
        f"(oil volume fraction {fraction.min():.2g} to {fraction.max():.2g}, {band['refit'].max()} "
        "refits)."
    )


def _heat(balance: pd.DataFrame) -> list[str]:
    """What the oil's own heating changes on the map of cage slip."""
    heat = oil_heat(balance)
    if heat is None:
        return []
    outlet, change = heat.outlet_temperature_c, heat.torque_change
    lines = [
        "Friction heat on the map of cage slip (heat_balance.parquet):",
        "",
        f"- The oil leaves at {outlet.min():.0f} to {outlet.max():.0f} degC (median "
        f"{outlet.median():.0f} degC).",
        f"- The heated oil changes the torque by {change.min():+.0%} to {change.max():+.0%}.",
        f"- It changes the best oil at {heat.other_best_oil} of {heat.points} operating points.",
    ]
    if heat.unbalanced:
        lost = f"{heat.unbalanced} of {heat.cases} cases"
        lines += bullet(f"No steady temperature was found in {lost}.")
    return lines
