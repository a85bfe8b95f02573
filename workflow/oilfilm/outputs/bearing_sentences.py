"""What torque logs and the bearing's model come to, in a few lines of text."""

import numpy as np
import pandas as pd

from oilfilm import tables
from oilfilm.outputs.facts import refused_files
from oilfilm.studies.selection import OUTSIDE
from oilfilm.studies.torque_control import bistable_points, without_bistable
from oilfilm.tables import failed_gates
from oilfilm.tables.campaign_tables import CampaignTables


def bearing_lines(results: CampaignTables) -> list[str]:
    """Logs and plateaus, errors, soundness, what traction decides, cage slip, heat."""
    calculated = results.torque[results.torque["converged"]]
    return [
        "Bearing torque (torque.parquet and the tables beside it):",
        *_logs(results),
        *_not_compared(results),
        *(_errors(calculated) if len(calculated) else []),
        *(f"  {line}" for line in control_sentences(results.torque_control)),
        *(_soundness(results.torque) if len(results.torque) else []),
        *(_beyond(calculated) if len(calculated) else []),
        *_inverted(results.torque_inversion),
        *_advice(results.slip_advice, results.advice_band),
        *_heat(results.heat_balance),
        "",
    ]


def _logs(results: CampaignTables) -> list[str]:
    runs, refused = results.torque_runs, results.torque_quarantine
    kept = {run_id.rpartition(":")[0] or run_id for run_id in runs["run_id"]}
    # of a refused run no plateau is kept
    read = kept | set(refused.loc[refused["stage"] == "curate", "file"])
    lines = [
        f"  torque logs {len(read)} read of {len(read | refused_files(refused))}, {len(kept)} with "
        f"runs that were not refused; their plateaus {runs['accepted'].sum()} accepted of "
        f"{len(runs)}"
    ]
    counts = refused["rule"].value_counts().sort_index()
    lines += refusals(refused, counts, "torque quarantine")
    gates = failed_gates.counts(runs)
    return [*lines, f"  plateaus refused by: {listed(gates)}"] if len(gates) else lines


def refusals(quarantine: pd.DataFrame, counts: "pd.Series[int]", label: str) -> list[str]:
    """How often each rule refused something: its first case, and what to do."""
    lines = []
    for rule, count in counts.items():
        case = quarantine[quarantine["rule"] == rule].iloc[0]
        lines += [
            f"  {label}, {rule} {count}: {case['run_id'] or case['file']}: {case['reason']}",
            f"    -> {case['advice']}",
        ]
    return lines


def _not_compared(results: CampaignTables) -> list[str]:
    """Oils whose plateaus no law could be asked for."""
    accepted = results.torque_runs.loc[results.torque_runs["accepted"], "oil"]
    counts = accepted[~accepted.isin(results.torque["oil"])].value_counts()
    return [
        f"  not compared: {count} plateaus of {oil}, which lacks properties, a fitted law that "
        "follows each condition, or a traction rig whose contact is known"
        for oil, count in counts.items()
    ]


def _errors(calculated: pd.DataFrame) -> list[str]:
    sure = without_bistable(calculated)
    size = sure["relative_error"].abs().groupby(sure["load_variable"], sort=False)
    errors = [
        f"{basis} {median:.1%}, {largest:.1%}"
        for basis, median, largest in size.agg(["median", "max"]).itertuples()
    ]
    what = "error of the calculated torque, median and largest, by load variable"
    lines = [f"  {what}: {'; '.join(errors)}"]
    points = bistable_points(calculated)
    if points:
        plateaus = calculated.groupby(["run_id", "first_row"])["bistable"].any()
        count = f"{plateaus.sum()} of {len(plateaus)} plateaus"
        lines.append(f"    left out, the cage may roll or skid, {count}: {points}")
    return [*lines, _compatible(sure)]


def _compatible(sure: pd.DataFrame) -> str:
    """At how many points calculated and measured torque agree within their uncertainty."""
    known = sure[sure["verdict"] != "not known"]
    if known.empty:
        why = "the law has no refits; measure more runs (fit.min_curves_to_resample)"
        return f"    the calculated torque has no uncertainty, because {why}"
    agrees = (known["verdict"] == "compatible").groupby(known["load_variable"], sort=False)
    counts = [
        f"{basis} {agree:.0f} of {count}"
        for basis, agree, count in agrees.agg(["sum", "count"]).itertuples()
    ]
    return f"    within twice the standard uncertainty of the difference: {'; '.join(counts)}"


def control_sentences(control: pd.DataFrame) -> list[str]:
    """What the comparison with SIMULATED torque shows, one sentence per verdict.

    Args:
        control: Table `torque_control`; empty where the torque was measured.
    """
    sentences = []
    for verdict, rows in control.groupby("verdict", sort=False):
        apart = f"{rows['law_misfit'].max():.1%} of mu"
        sentence = {
            "positive control": "positive control: the fitted law itself made the SIMULATED logs "
            "of both rigs, so that this checks the code and says nothing of the paper's claim",
            "one truth": "one simulated truth, which is no fitted law, is behind the logs of both "
            f"rigs (their tractions are {apart} apart): this says nothing of real oils",
            "two truths": "NOT COMPARABLE: the simulated truths behind the two rigs' logs are "
            f"{apart} apart (audit.twin_misfit_max)",
        }[str(verdict)]
        known = rows.dropna(subset=["median_torque_error"])
        errors = [
            f"{row['oil']} {row['median_torque_error']:.1%}, {row['largest_torque_error']:.1%}"
            for row in tables.rows(known)
        ]
        if errors:
            sentence += f"; error by stress, median and largest: {'; '.join(errors)}"
        sentences.append(sentence)
    return sentences


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
    names = ("pressure", "speed", "slip")
    means = [by_stress[f"share_beyond_{name}"].mean() for name in names]
    beyond = [
        f"{name} {'not known' if np.isnan(mean) else format(mean, '.0%')}"
        for name, mean in zip(names, means, strict=True)
    ]
    return [
        f"  traction makes {share.min():.0%} to {share.max():.0%} of the torque; mean share of its "
        f"heat beyond the tested box: {', '.join(beyond)}"
    ]


def _inverted(inversion: pd.DataFrame) -> list[str]:
    if inversion.empty:
        return []
    known = (inversion["verdict"] == "determined").sum()
    return [
        f"  traction coefficient from the measured torque: determined at {known} of "
        f"{len(inversion)} plateaus (torque_inversion.parquet)"
    ]


def _advice(advice: pd.DataFrame, band: pd.DataFrame) -> list[str]:
    with_film = advice[~advice["judgement"].isin(["no film", OUTSIDE])]
    if with_film.empty:
        return []
    others = with_film[with_film["judgement"] != "agree"]
    line = (
        "  choice of oil by cage slip: the paper's advice agrees with the best oil at "
        f"{len(with_film) - len(others)} of {len(with_film)} operating points ({_band(band)})"
    )
    if len(others):
        line += (
            f"; elsewhere it {listed(others['judgement'].value_counts(), '{} ({})')}; "
            f"best there: {listed(others['best_oil'].value_counts(), '{} at {}')}"
        )
    if band.empty:
        return [f"{line} (slip_advice.parquet)"]
    certain = (with_film["best_oil_share"] == 1).sum()
    return [
        line,
        f"    the best oil is certain at {certain} of them: as good as any in every scenario "
        "(slip_advice.parquet, advice_band.parquet)",
    ]


def _band(band: pd.DataFrame) -> str:
    """The numbers of agreeing points over the scenarios."""
    if band.empty:
        return "drag and law not varied"
    agreeing, fraction = band["agreeing_points"], band["oil_volume_fraction"]
    return (
        f"{agreeing.min()} to {agreeing.max()} over drag and law: oil volume fraction "
        f"{fraction.min():.2g} to {fraction.max():.2g}, {band['refit'].max()} refits"
    )


def _heat(balance: pd.DataFrame) -> list[str]:
    """What the oil's own heating changes on the map of cage slip."""
    on_map = balance[balance["run_id"] == ""]
    hot = on_map[on_map["balanced"]]
    if hot.empty:
        return []
    outlet = hot["outlet_temperature_c"]
    # without the minus sign of a rounded zero
    change = (hot["heated_torque_n_m"] / hot["torque_n_m"] - 1).round(2) + 0.0
    points = on_map.drop_duplicates(["inner_speed_rpm", "axial_load_n"])
    other = (points["best_oil"] != points["heated_best_oil"]).sum()
    lost = len(on_map) - len(hot)
    return [
        f"  heat: on the map of cage slip the oil leaves at {outlet.min():.0f} to "
        f"{outlet.max():.0f} degC (median {outlet.median():.0f}); with heated oil the torque "
        f"changes by {change.min():+.0%} to {change.max():+.0%} and the best oil at {other} of "
        f"{len(points)} operating points"
        + (f"; no steady temperature at {lost} of {len(on_map)}" if lost else "")
        + " (heat_balance.parquet)"
    ]


def listed(counts: "pd.Series[int]", form: str = "{} {}") -> str:
    """Each value with its count, as `thin_film 3, drift 1`."""
    return ", ".join(form.format(value, count) for value, count in counts.items())
