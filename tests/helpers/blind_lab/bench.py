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
    """One laboratory's rig and habits: Hz, s, and standard deviations of its imperfections."""

    machine: Machine
    rate: float
    hold: float  # at each slip
    rolling: float  # before and after the sweep
    slips: Array

    def run(self, oil: Oil, condition: Condition, random: np.random.Generator) -> Recording:
        """One run, from rolling to rolling, as the logger sees it."""
        machine, rate = self.machine, self.rate
        held = [self.rolling, *(self.hold * random.uniform(0.97, 1.03, len(self.slips)))]
        counts = np.round(np.array([*held, self.rolling]) * rate).astype(int)
        wanted = np.repeat([0.0, *self.slips, 0.0], counts)
        time = np.arange(len(wanted)) / rate
        slip = _controlled(wanted, rate, random.uniform(9, 14), random.uniform(0.6, 0.9))
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
    """Habits of a laboratory: its rate, its patience, its list of slips."""
    most, steps = random.uniform(0.18, 0.28), np.arange(1, 14)
    return Bench(
        machine,
        rate=float(random.choice([20, 25, 50])),
        hold=random.uniform(2.6, 3.4),
        rolling=random.uniform(4.0, 6.0),
        # steps that are wider than the smallest one that data/raw/README.md promises to find
        slips=np.round(np.maximum(most * np.linspace(0, 1, 14)[1:] ** 1.5, 0.007 * steps), 4),
    )


def _controlled(wanted: Array, rate: float, frequency: float, damping: float) -> Array:
    """Answer of a control of second order, natural frequency in rad/s, to set points."""
    fine = 8
    gain, kept = (frequency / (rate * fine)) ** 2, 1 - 2 * damping * frequency / (rate * fine)
    moved = np.repeat(wanted - wanted[0], fine)
    answer = scipy.signal.lfilter([gain], [1, gain - 1 - kept, kept], moved)
    return wanted[0] + answer[fine - 1 :: fine]


def lagging(values: Array, rate: float, constant: float) -> Array:
    """Output of a sensor with a time constant in s."""
    share = 1 - np.exp(-1 / (rate * constant))
    output, _ = scipy.signal.lfilter([share], [1, share - 1], values, zi=[(1 - share) * values[0]])
    return output


def _wander(count: int, rate: float, random: np.random.Generator) -> Array:
    """Slow random wandering of unit size over tens of seconds."""
    knots = max(4, int(count / rate / 12))
    rows, at = np.linspace(0, 1, count), np.linspace(0, 1, knots)
    return np.interp(rows, at, random.standard_normal(knots))
