"""The laboratory's rig: a controller of second order, sensors with lag, noise and steps."""

from dataclasses import dataclass, field, replace

import numpy as np
import scipy

from blind_lab.truth import Array, Machine, Oil


@dataclass(frozen=True)
class Condition:
    """Set points: maximum Hertz pressure in GPa, entrainment speed in m/s, inlet in degC."""

    pressure: float
    speed: float
    celsius: float


@dataclass(frozen=True)
class Recording:
    """What the logger holds of one run: time in s, load and force in N, speeds in m/s, degC."""

    oil: tuple[str, ...]  # names on the label
    condition: Condition
    signals: dict[str, Array]
    steps: Array = field(repr=False)  # row at which each level of slip begins, the end included

    def __len__(self) -> int:
        return len(self.signals["time"])

    def changed(self, **signals: Array) -> "Recording":
        """The run with some signals replaced."""
        return replace(self, signals={**self.signals, **signals})

    def rows(self, kept: Array) -> "Recording":
        """Only some rows."""
        return replace(self, signals={name: values[kept] for name, values in self.signals.items()})


@dataclass(frozen=True)
class Bench:
    """One laboratory's rig and habits: sampling rate in Hz, times in s, slide-roll ratios."""

    machine: Machine
    rate: float
    hold: float  # at each slip
    rolling: float  # before and after the sweep
    slips: Array

    def run(self, oil: Oil, condition: Condition, random: np.random.Generator) -> Recording:
        """One run, from rolling to rolling, as the logger sees it."""
        machine, rate = self.machine, self.rate
        hold_times = self.hold * random.uniform(0.97, 1.03, len(self.slips))
        phase_times = np.concatenate([[self.rolling], hold_times, [self.rolling]])
        counts = np.round(phase_times * rate).astype(int)
        set_points = np.repeat(np.concatenate([[0.0], self.slips, [0.0]]), counts)
        time = np.arange(len(set_points)) / rate
        slip = _controlled(set_points, rate, random.uniform(9, 14), random.uniform(0.6, 0.9))
        load = machine.load(condition.pressure * 1e9) * (1 + 0.003 * random.standard_normal())
        load = load * (1 + 0.0006 * _wander(len(time), rate, random))
        speed = condition.speed * (1 + 0.0005 * _wander(len(time), rate, random))
        celsius = condition.celsius + 0.15 * random.standard_normal()
        celsius = celsius + 0.1 * _wander(len(time), rate, random)
        mu = oil.traction(machine.pressure(load) / 1e9, speed, celsius, slip)
        zero = 0.05 * random.standard_normal() + 0.02 * random.standard_normal() * time / time[-1]
        force = lagging(mu * load, rate, 0.04) + zero
        ball, disc = speed * (1 - slip / 2), speed * (1 + slip / 2)

        def sensed(values: Array, noise: float, step: float) -> Array:
            noisy = values + noise * random.standard_normal(len(values))
            return np.round(noisy / step) * step

        signals = {
            "time": time,
            "load": sensed(load * (1 + 0.003 * random.standard_normal()), 0.1, 0.004),
            "force": sensed(force * (1 + 0.003 * random.standard_normal()), 0.008, 0.0002),
            "ball": sensed(ball, 0.004, 0.0005),
            "disc": sensed(disc, 0.004, 0.0005),
            "celsius": sensed(celsius + 0.2 * random.standard_normal(), 0.05, 0.002),
        }
        return Recording(oil.names, condition, signals, np.cumsum([0, *counts]))


def draw_bench(random: np.random.Generator, machine: Machine) -> Bench:
    """Habits of a laboratory: its sampling rate, its times, its list of slips."""
    largest_slip = random.uniform(0.18, 0.28)
    return Bench(
        machine,
        rate=float(random.choice([20, 25, 50])),
        hold=random.uniform(2.6, 3.4),
        rolling=random.uniform(4.0, 6.0),
        # steps that are wider than the smallest one that data/raw/README.md promises to find
        slips=np.round(
            np.maximum(largest_slip * np.linspace(0, 1, 14)[1:] ** 1.5, 0.007 * np.arange(1, 14)), 4
        ),
    )


def _controlled(set_points: Array, rate: float, frequency: float, damping: float) -> Array:
    """Response of a control of second order, natural frequency in rad/s, to set points."""
    # time steps of the calculation in one sample
    steps = 8
    gain = (frequency / (rate * steps)) ** 2
    kept_velocity = 1 - 2 * damping * frequency / (rate * steps)
    changes = np.repeat(set_points - set_points[0], steps)
    response = scipy.signal.lfilter([gain], [1, gain - 1 - kept_velocity, kept_velocity], changes)
    return set_points[0] + response[steps - 1 :: steps]


def lagging(values: Array, rate: float, constant: float) -> Array:
    """Output of a sensor with a time constant in s."""
    new_share = 1 - np.exp(-1 / (rate * constant))
    initial_state = [(1 - new_share) * values[0]]
    output, _ = scipy.signal.lfilter([new_share], [1, new_share - 1], values, zi=initial_state)
    return output


def _wander(count: int, rate: float, random: np.random.Generator) -> Array:
    """Slow random wandering of unit size over tens of seconds."""
    knot_count = max(4, int(count / rate / 12))
    knots = np.linspace(0, 1, knot_count)
    return np.interp(np.linspace(0, 1, count), knots, random.standard_normal(knot_count))
