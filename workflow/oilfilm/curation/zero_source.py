"""Which source of the zero of the force suits a log of a traction rig.

Decides: what `oilfilm init` takes for the source of the zero.
"""

from collections.abc import Mapping

import numpy as np

from oilfilm.curation.gate import Signals
from oilfilm.curation.measure import measure
from oilfilm.curation.rig_kind import nothing
from oilfilm.curation.traction_rig import TRACTION_RIG
from oilfilm.settings.resolved import Settings
from oilfilm.units import FloatArray

# Two phases show a drift, and the force at standstill may be held by static friction.
BEST_FIRST = ("rolling_phases", "opening_phase", "standstill")


def zero_source(
    time_s: FloatArray,
    ball_m_s: FloatArray,
    disc_m_s: FloatArray,
    load_n: FloatArray,
    force_n: FloatArray,
    settings_by_source: Mapping[str, Settings],
) -> str | None:
    """The first source from which a run gets a zero that its own curve does not contradict.

    Args:
        time_s: Time, shape (n,).
        ball_m_s: Surface speed of the ball, shape (n,).
        disc_m_s: That of the disc, shape (n,).
        load_n: Normal load, shape (n,); in any unit, because only ratios of mu matter.
        force_n: Traction force, shape (n,).
        settings_by_source: Settings with each source of `BEST_FIRST` as `semantics: zero`.

    Returns:
        A value of `semantics: zero`; None where none of them suits.
    """
    mean = (ball_m_s + disc_m_s) / 2
    slip = np.divide(disc_m_s - ball_m_s, mean, out=nothing(len(mean)), where=mean != 0)
    columns = {
        "load_n": load_n,
        "traction_force_n": force_n,
        "ball_speed_m_s": ball_m_s,
        "disc_speed_m_s": disc_m_s,
        "entrainment_speed_m_s": mean,
        "slide_roll_ratio": slip,
        "inlet_temperature_c": np.zeros(len(mean)),
    }
    signals = Signals(np.arange(len(mean)), time_s, columns)
    for source in BEST_FIRST:
        measured = measure(signals, TRACTION_RIG, "", settings_by_source[source])
        if measured.flaw is None or measured.flaw[0] != "zero_missing":
            return source
    return None
