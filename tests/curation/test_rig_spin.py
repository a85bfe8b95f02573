"""Spin of a ball-on-disc rig: warned about where it lowers mu by more than 1 %."""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from campaigns import ROOT
from oilfilm.curation.rig_spin import spin_warnings
from oilfilm.settings.messages import load
from oilfilm.settings.rig import Rig

RIG = load(ROOT / "config/rigs/ball-on-disc-20mm.yaml", Rig)


def warned(
    load_n: float,
    lowest_slip: float,
    data: str = "measured",
    rig: Rig = RIG,
    step: float = 1.0,
    noise: float = 0.0,
) -> list:
    """Warnings about two runs with a flat mu, one of which begins at ten times the slip.

    Args:
        load_n: Load of both runs.
        lowest_slip: Lowest slip of the first run.
        data: Whether the data are measured or simulated.
        rig: The rig of both runs.
        step: Distance of the slips of a run, over the lowest one.
        noise: Noise of mu, relative; its sign changes from slip to slip.
    """
    frames = []
    for run_id, first in (("low.csv", lowest_slip), ("high.csv", 10 * lowest_slip)):
        slip = first * (1 + step * np.arange(5))
        columns = {"run_id": run_id, "slide_roll_ratio": slip, "load_n": load_n}
        mu = 0.03 * (1 + noise * np.array([1, -1, 1, -1, 1]))
        frames.append(pd.DataFrame(columns | {"traction_coefficient": mu, "accepted": True}))
    settings = SimpleNamespace(rigs={"rig": rig}, campaign=SimpleNamespace(data=data))
    rigs = pd.Series({"low.csv": "rig", "high.csv": "rig"})
    return list(spin_warnings(frames, rigs, settings))


# 1.5 GPa is 142 N and a contact of 213 um, on a disc track of 40 mm: e = 0.0053 (docs/physics.md)
@pytest.mark.parametrize(
    ("lowest_slip", "lacks"),
    [
        (0.005, "11.3%"),  # below 2 e: e^2/(10 S^2)
        (0.012, "2.0%"),
        (0.016, "1.1%"),
    ],
)
def test_a_plateau_at_low_slip_is_warned_about_once_with_its_size(lowest_slip, lacks):
    ((run_id, sentence),) = warned(142.0, lowest_slip)
    assert run_id == "low.csv"
    assert lacks in sentence
    assert "in 1 of 2 runs" in sentence


def test_high_slip_light_load_and_unknown_rigs_are_not():
    assert warned(142.0, 0.02) == []
    # 1 GPa: e = 0.0035, which is below 1 % from S = 0.011 on
    assert warned(42.1, 0.012) == []
    assert warned(142.0, 0.005, rig=RIG.model_copy(update={"disc_track_radius_m": None})) == []
    assert warned(142.0, 0.005, data="simulated") == []


@pytest.mark.parametrize("step", [6.0, 1e-3, 0.0])
def test_a_run_with_few_slips_near_its_lowest_is_judged_by_a_flat_mu(step):
    # one level alone is near the lowest slip: e^2/(10 S^2) at S = 0.012
    ((run_id, sentence),) = warned(142.0, 0.012, step=step, noise=0.002)
    assert run_id == "low.csv"
    assert "2.0%" in sentence
