"""What is said of a surface beside the verdict: each number that a reader needs is in it."""

import numpy as np

from oilfilm import tables
from oilfilm.fits.run_assumptions import RunAssumptions
from oilfilm.fits.soundness_sentences import smallest_visible_changes_sentence
from oilfilm.fits.surface_sentences import rigs_sentence, spin_sentence, surface_sentences
from oilfilm.tables.campaign_tables import CampaignTables
from reports import rows

VERDICT = {
    "oil": "4050",
    "law": "deng2026",
    "law_verdict": "adequate",
    "campaign_verdict": "steady",
    "misfit": 0.0123,
    "run_scatter": 0.0456,
    "seen_trend_gain": 0.029,
    "seen_step_gain": 0.017,
}

STEADY = {"campaign_verdict": "steady", "order_resembles": ""}


def said(constant_error: float = 0.002, **surface: object) -> str:
    """Everything that is said of one surface."""
    known = {"search_converged": True, "usual_errors": (), **surface}
    constant = {"oil": "4050", "law": "deng2026", "constant": "A0"}
    results = CampaignTables.from_frames(
        surfaces=rows("surfaces", {"oil": "4050", "law": "deng2026", **known}),
        surface_constants=rows("surface_constants", {**constant, "standard_error": constant_error}),
        coefficients=rows("coefficients", {**constant, "standard_error": 0.004}),
    )
    (verdict,) = tables.rows(rows("soundness", VERDICT))
    return " ".join(surface_sentences(results, "4050", verdict))


def test_the_misfit_of_an_adequate_law_and_what_could_be_seen_are_said() -> None:
    text = said()
    for number in ("1.2%", "4.6%", "2.9%", "1.7%"):
        assert number in text


def test_a_change_that_only_the_zero_or_the_slip_would_show_is_said() -> None:
    seen = {"seen_trend_zero": 0.00123, "seen_step_slip_scale": 0.045}
    sentence = smallest_visible_changes_sentence(
        {**dict.fromkeys(tables.columns("soundness"), np.nan), **STEADY, **seen}
    )
    assert "drift over the runs of 0.0012 in mu" in sentence
    assert "step at any run of 4.5% of the slip" in sentence
    assert "none of the traction force" in sentence
    assert "No " not in sentence


def test_errors_of_constants_are_told_over_those_of_the_fit() -> None:
    # 0.002 over 0.004
    assert "0.5 to 0.5 times" in said()
    assert "0.5 to" not in said(constant_error=np.nan)


def test_a_search_without_a_maximum_is_said() -> None:
    assert len(said(search_converged=False)) > len(said())


def test_several_rigs_are_counted_with_what_they_differ_by() -> None:
    text = rigs_sentence(["a", "b", "b"], 0.0123)
    assert "2 rigs" in text and "1.2%" in text
    assert rigs_sentence(["b", "b"], np.nan) == ""


def test_data_that_name_no_rigs_say_so() -> None:
    assert "no rigs" in rigs_sentence(None, np.nan)
    assert "no rigs" in said(rig_of_runs=None)
    assert "no rigs" not in said(rig_of_runs=["b"])


def test_errors_that_no_rig_states_are_named() -> None:
    usual = RunAssumptions().usual_error_names
    assert "errors_between_runs" in said(usual_errors=usual)
    assert "errors_between_runs" not in said()


def test_the_spin_of_a_rig_is_named_beside_the_verdicts_of_all_its_oils() -> None:
    # one run of each rig has the warning, and all oils of the rig have the spin
    runs = rows(
        "runs",
        {"run_id": "1", "oil": "A", "rig": "fast", "warning": ("rig_spin: the disc spins",)},
        {"run_id": "2", "oil": "B", "rig": "fast", "warning": ("noisy_sensor: force",)},
        {"run_id": "3", "oil": "C", "rig": "slow", "warning": ("odd_step: time",)},
    ).assign(verdict="accepted")
    for oil in "AB":
        assert "spin of fast" in spin_sentence(runs, oil)
    assert spin_sentence(runs, "C") == ""
    refused = runs.assign(verdict="refused")
    assert spin_sentence(refused, "A") == ""
