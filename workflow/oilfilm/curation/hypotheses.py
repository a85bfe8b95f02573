"""What may be wrong with a refused run: simple mistakes, each tried, before the last resort.

A log in the wrong unit, or with two columns exchanged, fails gates that have nothing to do with its
cause. A hypothesis undoes one such mistake. Where the run then passes, the mistake is named.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from oilfilm.curation.gate import Columns
from oilfilm.settings.rig import Rig
from oilfilm.units import RAD_S_PER_RPM, conversion


@dataclass(frozen=True)
class Hypothesis:
    """A mistake that a log may hold, and how to undo it.

    Attributes:
        rule: Rule of a refusal for it.
        sentence: What was found, if the run passes once the mistake is undone.
        undo: The samples of the run without the mistake.
    """

    rule: str
    sentence: str
    undo: Callable[[Columns], Columns]


# Refusals that a mistake of another kind may cause.
DOUBTFUL = {
    "zero_missing",
    "no_plateau",
    "swapped_sign",
    "speed_off_nominal",
    "slip_out_of_range",
    "not_steady",
    "too_short",
    "no_point_left",
    "most_plateaus_fail",
    "traction_unphysical",
    "zero_drift",
}
ADVICE = {
    "force_scale": "Write the unit of the traction force into the log or the campaign file.",
    "time_unit": "Write the unit of the time column into the log or the campaign file.",
    "speed_unit": "Write the unit of the speed columns into the log or the campaign file.",
    "slip_unit": "Write the unit of the slide-roll ratio into the log (%) or the campaign file.",
    "swapped_channels": "Correct the names of the two columns, or the campaign file's `columns`.",
}


def scaled(factor: float, *names: str) -> Callable[[Columns], Columns]:
    """Undo by multiplying some signals."""
    return lambda samples: {**samples, **{name: factor * samples[name] for name in names}}


def traction_hypotheses(rig: Rig) -> Iterator[Hypothesis]:
    """Mistakes of the logs of a traction rig, the most frequent first."""
    for unit, factor in (("ms", 1e-3), ("min", 60.0), ("us", 1e-6), ("h", 3600.0)):
        yield Hypothesis(
            "time_unit",
            f"the run makes sense only if its time is in {unit}",
            scaled(factor, "time_s"),
        )
    for unit in ("mN", "gf"):
        yield Hypothesis(
            "force_scale",
            f"the run makes sense only if its traction force is in {unit}",
            scaled(conversion(unit, ("N",)).scale, "traction_force_n"),
        )
    ball, disc = "ball_speed_m_s", "disc_speed_m_s"
    yield Hypothesis(
        "swapped_channels",
        "the run makes sense only if the speeds of ball and disc are exchanged",
        lambda samples: {**samples, ball: samples[disc], disc: samples[ball]},
    )
    if rig.ball_track_radius_m is not None and rig.disc_track_radius_m is not None:
        ratio = rig.ball_track_radius_m / rig.disc_track_radius_m
        yield Hypothesis(
            "swapped_channels",
            "the run makes sense only if the spindle speeds of ball and disc are exchanged",
            lambda samples: {
                **samples,
                ball: samples[disc] * ratio,
                disc: samples[ball] / ratio,
            },
        )
    per_rpm = RAD_S_PER_RPM
    for names, words in (
        ((ball, disc), "both speeds are"),
        ((ball,), "the ball's speed is"),
        ((disc,), "the disc's speed is"),
    ):
        for unit, factor in (
            ("rad/s", 1 / per_rpm),
            ("1/min", per_rpm),
            ("1/s", 60.0),
            ("mm/s", 1e-3),
        ):
            yield Hypothesis(
                "speed_unit",
                f"the run makes sense only if {words} in {unit}",
                scaled(factor, *names),
            )
    yield Hypothesis(
        "slip_unit", "the run makes sense only if its slide-roll ratio is in percent", _from_percent
    )


def _from_percent(samples: Columns) -> Columns:
    """Speeds of a log whose entrainment speed and slip were logged, the slip in percent."""
    ball, disc = samples["ball_speed_m_s"], samples["disc_speed_m_s"]
    mean, sliding = (ball + disc) / 2, (disc - ball) / 100
    return {
        **samples,
        "ball_speed_m_s": np.asarray(mean - sliding / 2),
        "disc_speed_m_s": np.asarray(mean + sliding / 2),
    }
