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


def warned(load_n: float, lowest_slip: float, data: str = "measured", rig: Rig = RIG) -> list:
    """Warnings about two runs of a plateau of mu, one of which begins at ten times the slip."""
    frames = []
    for run_id, first in (("low.csv", lowest_slip), ("high.csv", 10 * lowest_slip)):
        slip = first * np.arange(1, 6)
        columns = {"run_id": run_id, "slide_roll_ratio": slip, "load_n": load_n}
        frames.append(pd.DataFrame(columns | {"traction_coefficient": 0.03, "accepted": True}))
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
