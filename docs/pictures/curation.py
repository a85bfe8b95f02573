"""From a log to points: zero, plateaus, and what gates find."""

import numpy as np
from matplotlib.figure import Figure

from examples import log, settings, slip_of
from oilfilm.curation.measure import find_steps, settled_parts
from style import BLUE, GREY, ORANGE, RED, axes, row


def signals() -> Figure:
    """A whole simulated log."""
    figure, two = row(2, 8.8)
    rows = log()
    two[0].plot(rows["time_s"], slip_of(rows), lw=0.8)
    two[1].plot(rows["time_s"], rows["traction_force_n"], lw=0.8)
    two[0].set(xlabel="Time (s)", ylabel="Slide-roll ratio S (1)")
    two[1].set(xlabel="Time (s)", ylabel="Traction force (N)")
    return figure


def zero() -> Figure:
    """The zero of the force from the rolling phases."""
    figure, one = axes(xlabel="Time (s)", ylabel="Traction force (N)")
    rows = log()
    time_s, force = rows["time_s"].to_numpy(), rows["traction_force_n"].to_numpy()
    one.plot(time_s, force, color=GREY, lw=0.5, label="as logged")
    ends = [time_s < 2.8, time_s > time_s[-1] - 2.0]
    at = [(time_s[end].mean(), force[end].mean()) for end in ends]
    for end in ends:
        one.axvspan(time_s[end][0], time_s[end][-1], color=ORANGE, alpha=0.3)
    one.plot(*np.transpose(at), "o-", color=RED, label="zero, interpolated")
    one.set(ylim=(at[0][1] - 0.2, at[0][1] + 0.5))
    one.legend()
    return figure


def plateaus() -> Figure:
    """The settled parts that are averaged."""
    figure, one = axes(xlabel="Time (s)", ylabel="Slide-roll ratio S (1)")
    rows = log()
    time_s, slip = rows["time_s"].to_numpy(), slip_of(rows).to_numpy()
    rules = settings().curation.plateaus
    interval = float(np.median(np.diff(time_s)))
    steps = find_steps(slip, interval, rules.min_step, rules)
    starts, stops = settled_parts(len(slip), steps, interval, rules)
    shown = time_s < 24
    one.plot(time_s[shown], slip[shown], color=GREY, lw=0.5, label="as logged")
    for number, (start, stop) in enumerate(zip(starts, stops, strict=True)):
        if stop > start and time_s[start] < 23:
            part = slice(start, stop)
            mean = np.full(stop - start, slip[part].mean())
            label = "averaged" if number == 0 else None
            one.plot(time_s[part], mean, color=BLUE, lw=3, label=label)
    one.legend()
    return figure


def stuck() -> Figure:
    """A sensor that stops moving."""
    figure, one = axes(xlabel="Time (s)", ylabel="Traction force (N)")
    rows = log("stuck_sensor")
    force = rows["traction_force_n"].to_numpy()
    same = np.flatnonzero(np.diff(force) != 0).max() + 1
    one.plot(rows["time_s"], force, lw=0.8)
    one.axvspan(rows["time_s"][same], rows["time_s"].iloc[-1], color=RED, alpha=0.2)
    one.text(rows["time_s"][same] + 1, force.min(), "refused: stuck_sensor")
    return figure
