"""Faults that the laboratory makes, and the rules that name each of them rightly."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import NamedTuple

import numpy as np

from blind_lab.bench import Bench, Condition, Recording, lagging
from blind_lab.dialects import Dialect, columns_of, header_of, log_bytes
from blind_lab.truth import Array, Oil

Random = np.random.Generator


@dataclass(frozen=True)
class Draft:
    """A log on its way to the disk.

    Attributes:
        recording: The signals in SI units.
        dialect: How the logger writes.
        bench: The rig.
        header: Header lines.
        labels: Units that are written in place of the true ones; None: the column is left out.
        content: The bytes of the file, where they do not follow from the others.
    """

    recording: Recording
    dialect: Dialect
    bench: Bench
    header: Mapping[str, str]
    labels: Mapping[str, str | None] = field(default_factory=dict)
    content: bytes = b""

    def bytes(self) -> bytes:
        """The file."""
        columns = columns_of(self.recording, self.dialect, self.bench.machine)
        labelled_columns = {}
        for name, (unit, values) in columns.items():
            label = self.labels.get(name, unit)
            if label is not None:
                labelled_columns[name] = (str(label), values)
        return self.content or log_bytes(dict(self.header), labelled_columns, self.dialect)

    @classmethod
    def sound(cls, recording: Recording, dialect: Dialect, bench: Bench) -> "Draft":
        """A sound log."""
        return cls(recording, dialect, bench, header_of(recording, dialect))


Change = Callable[[Draft, Random], Draft]
PlanChange = Callable[[Bench, Condition], tuple[Bench, Condition]]


class Fault(NamedTuple):
    """A fault.

    Attributes:
        rules: Rules of which one must name it, the best first, with blanks between; the others name
            the same cause in a wider sense.
        change: What it makes of a sound log.
        change_plan: What it makes of the rig and its set points before the run.
    """

    rules: str
    change: Change = lambda sound, random: sound
    change_plan: PlanChange = lambda bench, condition: (bench, condition)


def faulty(
    fault: Fault, oil: Oil, condition: Condition, bench: Bench, dialect: Dialect, random: Random
) -> bytes:
    """The bytes of a log with a fault."""
    changed_bench, changed_condition = fault.change_plan(bench, condition)
    sound = Draft.sound(changed_bench.run(oil, changed_condition, random), dialect, bench)
    return fault.change(sound, random).bytes()


# ---------------------------------------------------------------- signals

SignalChange = Callable[[Array, Recording, Random], Array]
RowSelection = Callable[[Recording], Array]


def of_run(change: Callable[[Recording], Recording]) -> Change:
    """The run itself is another one."""
    return lambda sound, random: replace(sound, recording=change(sound.recording))


def on_channels(names: str, change: SignalChange) -> Change:
    """Channels changed, by their readings, the run and random numbers."""

    def changed(sound: Draft, random: Random) -> Draft:
        run = sound.recording
        signals = {name: change(run.signals[name], run, random) for name in names.split()}
        return replace(sound, recording=run.changed(**signals))

    return changed


def scaled(names: str, factor: float, by: float = 0) -> Change:
    """Channels are in another unit than their labels say, or off by a constant."""
    return on_channels(names, lambda values, *_: values * factor + by)


def drifting(name: str, by: float) -> Change:
    """A channel moves by so much over the run."""
    return on_channels(name, lambda values, *_: values + np.linspace(0, by, len(values)))


def unconnected(name: str, mean: float, size: float) -> Change:
    """A channel that is connected to nothing."""
    return on_channels(
        name, lambda values, _, random: np.round(random.normal(mean, size, len(values)), 4)
    )


def all_rows(run: Recording) -> Array:
    """All rows."""
    return np.ones(len(run), dtype=bool)


def middle_half(run: Recording) -> Array:
    """Rows of the sweep's middle half."""
    first, last = int(run.steps[1]), int(run.steps[-2])
    quarter, rows = (last - first) // 4, np.arange(len(run))
    return (rows >= first + quarter) & (rows < last - quarter)


def from_middle_half_on(run: Recording) -> Array:
    """Rows from the beginning of the sweep's middle half on."""
    return np.logical_or.accumulate(middle_half(run))


def from_middle_on(run: Recording) -> Array:
    """Rows from the middle of the sweep on."""
    start, *_, last = np.flatnonzero(middle_half(run))
    return np.arange(len(run)) >= (start + last + 1) // 2


def above_slip_of_0_1(run: Recording) -> Array:
    """Rows of the large slips."""
    ball, disc = run.signals["ball"], run.signals["disc"]
    return 2 * (disc - ball) / (disc + ball) > 0.1


def way_back(run: Recording) -> Array:
    """Rows of the sweep's second half."""
    rows = np.arange(len(run))
    return (rows >= run.steps[len(run.steps) // 2]) & (rows < run.steps[-2])


def in_rows(name: str, rows: RowSelection, factor: float, by: float = 0) -> Change:
    """A channel scaled or moved in some rows."""
    return on_channels(
        name, lambda values, run, _: np.where(rows(run), factor * values + by, values)
    )


def frozen_channel(name: str) -> Change:
    """One channel stops moving in the middle of the sweep, to its end."""

    def freeze(values: Array, run: Recording, _: Random) -> Array:
        is_frozen = from_middle_half_on(run)
        return np.where(is_frozen, values[np.argmax(is_frozen)], values)

    return on_channels(name, freeze)


def constant(name: str) -> Change:
    """A channel copies one number into every row."""
    return on_channels(name, lambda values, *_: np.full(len(values), np.round(values.mean(), 1)))


def only_rows(rows: RowSelection) -> Change:
    """Only some rows of the run, or some of them twice."""
    return of_run(lambda run: run.rows(rows(run)))


def exchanged(rows: RowSelection) -> Change:
    """The columns of ball and disc are exchanged in some rows."""

    def change(run: Recording) -> Recording:
        ball, disc, where = run.signals["ball"], run.signals["disc"], rows(run)
        return run.changed(ball=np.where(where, disc, ball), disc=np.where(where, ball, disc))

    return of_run(change)


def saturated(force: Array, *_: object) -> Array:
    """The force stops at 60 % of its largest value."""
    return np.minimum(force, 0.6 * force.max())


def soft_limit(force: Array, *_: object) -> Array:
    """The amplifier compresses: large forces come out too small, without a stop."""
    limit = 0.75 * force.max()
    return limit * np.tanh(force / limit)


def wild(force: Array, _: Recording, random: Random) -> Array:
    """15 % of the force readings are wrong by several times their value."""
    hit = random.random(len(force)) < 0.15
    factors = np.ones(len(force))
    factors[hit] = random.uniform(3, 8, hit.sum())
    return force * factors


def noisy(force: Array, _: Recording, random: Random) -> Array:
    """Noise times 30."""
    return force + 0.24 * random.standard_normal(len(force))


def slow_filter(force: Array, run: Recording, _: Random) -> Array:
    """A filter with a time constant of 1.5 s."""
    return lagging(force, 1 / run.signals["time"][1], 1.5)


def load_step(load: Array, run: Recording, _: Random) -> Array:
    """The load rises by half in the middle of every second step."""
    changed = load.copy()
    for start, stop in zip(run.steps[1:-2:2], run.steps[2:-1:2], strict=False):
        changed[(start + stop) // 2 : stop] *= 1.5
    return changed


def hurried(run: Recording) -> Recording:
    """Each slip is held for 0.9 s only."""
    time, rows = run.signals["time"], np.arange(len(run))
    since = rows - run.steps[np.searchsorted(run.steps, rows, "right") - 1]
    at_rest = (rows < run.steps[1]) | (rows >= run.steps[-2])
    shorter = run.rows(at_rest | (since < int(0.9 / (time[1] - time[0]))))
    return shorter.changed(time=time[: len(shorter)])


def still_settling(force: Array, run: Recording, _: Random) -> Array:
    """The force creeps back to its zero while the rig rolls again."""
    since = run.signals["time"] - run.signals["time"][run.steps[-2]]
    return force + np.where(since > 0, 1.5 * np.exp(-np.maximum(since, 0) / 2.5), 0.0)


# ---------------------------------------------------------------- set points of the run


def there_and_back(levels: Array) -> Array:
    """The levels of slip up and down again."""
    return np.concatenate([levels, levels[-2::-1]])


def small_steps(levels: Array) -> Array:
    """Levels in steps of 0.0018."""
    return 0.0018 * np.arange(1, len(levels) + 1)


def slips(change: Callable[[Array], Array]) -> PlanChange:
    """Other levels of slip."""
    return lambda bench, condition: (replace(bench, slips=change(bench.slips)), condition)


def slow(bench: Bench, condition: Condition) -> tuple[Bench, Condition]:
    """So slow that no film parts the bodies, which goes with about the 0.7th power of the speed."""
    return bench, replace(condition, speed=round(condition.speed / 30, 3))


# ---------------------------------------------------------------- headers and files


def labelled(**labels: str | None) -> Change:
    """The numbers of some columns stay, their units are written wrongly; None: no column."""
    return lambda sound, random: replace(sound, labels=labels)


def header_line(place: int, key: str = "", text: str = "") -> Change:
    """A header line with another key or another text; one behind the last is added."""

    def change(sound: Draft, random: Random) -> Draft:
        lines = [*sound.header.items(), ("", "")]
        lines[place] = key or lines[place][0], text or lines[place][1]
        return replace(sound, header=dict(line for line in lines if line[0]))

    return change


def rewritten(change: Callable[[Draft, list[str]], list[str]]) -> Change:
    """The lines of the written text are others."""

    def changed(sound: Draft, random: Random) -> Draft:
        lines = sound.bytes().decode(sound.dialect.encoding).splitlines(keepends=True)
        content = "".join(change(sound, lines)).encode(sound.dialect.encoding)
        return replace(sound, content=content)

    return changed


def cut_off(sound: Draft, lines: list[str]) -> list[str]:
    """The file ends in the middle of a row."""
    last = int(0.7 * len(lines)) - 1
    return [*lines[:last], lines[last][: len(lines[last]) // 2]]


def torn_rows(sound: Draft, lines: list[str]) -> list[str]:
    """A fifth of the rows lacks a cell."""
    first = len(lines) - len(sound.recording)
    return [
        line.partition(sound.dialect.delimiter)[2] if index >= first and index % 5 == 0 else line
        for index, line in enumerate(lines)
    ]


def without_unit(sound: Draft, random: Random) -> Draft:
    """The load has no unit."""
    return replace(sound, dialect=replace(sound.dialect, units_in_row=False), labels={"load": ""})


def spindles_in_rad_s(sound: Draft, random: Random) -> Draft:
    """The speed of the ball is in rad/s and labelled as that of the disc."""
    dialect = sound.dialect.with_units(ball="rad/s", disc="rpm")
    return replace(sound, dialect=dialect, labels={"ball": "rpm"})


def no_text(sound: Draft, random: Random) -> Draft:
    """The file is anything but a log."""
    return replace(sound, content=random.bytes(4000))


# ---------------------------------------------------------------- the list

_KGF, _LBF = 9.80665, 4.4482216152605
_HOT, _LOAD = "temperature_off_nominal", "load_off_nominal"
_UNIT = "little_traction no_traction odd_shape unusual_shape"
_LARGE = "traction_unphysical impossible_traction"

FAULTS = {
    "force sensor frozen": Fault("stuck_sensor stuck_channel", frozen_channel("force")),
    "ball speed frozen": Fault("stuck_channel", frozen_channel("ball")),
    "disc speed frozen": Fault("stuck_channel", frozen_channel("disc")),
    "load frozen": Fault("stuck_channel", frozen_channel("load")),
    "temperature frozen": Fault("stuck_channel", frozen_channel("celsius")),
    "force in kgf, labelled N": Fault(_UNIT, scaled("force", 1 / _KGF)),
    "force in lbf, labelled N": Fault(
        "little_traction odd_shape unusual_shape", scaled("force", 1 / _LBF)
    ),
    "force in mN, labelled N": Fault("force_scale", scaled("force", 1e3)),
    "force in kN, labelled N": Fault("no_traction", scaled("force", 1e-3)),
    "force seven times too large": Fault(f"{_LARGE} odd_shape unusual_shape", scaled("force", 7.0)),
    "force polarity": Fault("swapped_sign", scaled("force", -1.0)),
    "ball and disc exchanged": Fault("swapped_channels", exchanged(all_rows)),
    "load in kgf, labelled N": Fault(_LOAD, scaled("load", 1 / _KGF)),
    "load in kN, labelled N": Fault(_LOAD, scaled("load", 1e-3)),
    "load off by 12 %": Fault(_LOAD, scaled("load", 1.12)),
    "load rises within steps": Fault(
        f"load_changes {_LOAD} many_plateaus_fail", on_channels("load", load_step)
    ),
    "load cell unplugged": Fault(f"{_LOAD} traction_missing", unconnected("load", 0, 0.1)),
    "speed off by 10 %": Fault("speed_off_nominal", scaled("ball disc", 1.1)),
    "speeds in rad/s, labelled 1/min": Fault("speed_unit speed_off_nominal", spindles_in_rad_s),
    "temperature in K, labelled degC": Fault(_HOT, scaled("celsius", 1, 273.15)),
    "temperature off by 10 K": Fault(_HOT, scaled("celsius", 1, 10.0)),
    "temperature drifts by 6 K": Fault(f"temperature_drift {_HOT}", drifting("celsius", 6.0)),
    "open thermocouple": Fault(f"{_HOT} stuck_channel", scaled("celsius", 0, 850.0)),
    "force saturated": Fault("saturated", on_channels("force", saturated)),
    "force softly saturated": Fault(
        "odd_shape unusual_shape soft_saturation", on_channels("force", soft_limit)
    ),
    "15 % wild readings": Fault("spiky not_steady no_point_left", on_channels("force", wild)),
    "zero drifts by 1 N": Fault("zero_drift", drifting("force", 1.0)),
    "force cable off": Fault(
        "no_traction odd_shape unusual_shape", unconnected("force", 0.3, 0.008)
    ),
    "clock set back": Fault("time_disorder", in_rows("time", from_middle_half_on, 1, -60.0)),
    "logger paused": Fault("clock_jump", in_rows("time", from_middle_half_on, 1, 60.0)),
    "rows written twice": Fault(
        "time_disorder", only_rows(lambda run: np.arange(2 * len(run)) // 2)
    ),
    "block of NaN": Fault("missing_readings", in_rows("force", middle_half, np.nan)),
    "time in ms, labelled s": Fault("time_unit", scaled("time", 1e3)),
    "time in min, labelled s": Fault("time_unit", scaled("time", 1 / 60)),
    "no opening phase": Fault(
        "zero_missing", only_rows(lambda run: np.arange(run.steps[1] + 10, len(run)))
    ),
    "no closing phase": Fault("zero_missing", only_rows(lambda run: np.arange(run.steps[-2]))),
    "steps too short": Fault("too_short no_plateau not_steady", of_run(hurried)),
    "filter of 1.5 s": Fault(
        "transient_not_ended not_steady zero_not_settled", on_channels("force", slow_filter)
    ),
    "noise times 30": Fault("zero_noisy noisy_sensor", on_channels("force", noisy)),
    "one column for both speeds": Fault(
        "same_channel", on_channels("ball", lambda _, run, random: run.signals["disc"])
    ),
    "force in the opposite order": Fault(
        "odd_shape unusual_shape", on_channels("force", lambda force, *_: force[::-1])
    ),
    "range switch": Fault("odd_shape unusual_shape", in_rows("force", above_slip_of_0_1, 1.5)),
    "gain changes within the run": Fault(
        "odd_shape unusual_shape", in_rows("force", from_middle_on, 1.3)
    ),
    "zero jumps and returns": Fault(
        "odd_shape unusual_shape", in_rows("force", middle_half, 1, 0.4)
    ),
    "way back is 10 % higher": Fault(
        "branches_apart branches_differ odd_shape unusual_shape",
        in_rows("force", way_back, 1.1),
        slips(there_and_back),
    ),
    "load is one number": Fault("constant_channel", constant("load")),
    "temperature is one number": Fault("constant_channel", constant("celsius")),
    "speeds exchanged from the middle on": Fault("sign_changes", exchanged(from_middle_on)),
    "slips in steps of 0.0018": Fault("small_steps", change_plan=slips(small_steps)),
    "every fifth row from the middle on": Fault(
        "sampling_rate",
        only_rows(lambda run: ~from_middle_half_on(run) | (np.arange(len(run)) % 5 == 0)),
    ),
    "log of a rig with other radii": Fault("track_radii", scaled("disc", 1.25)),
    "creep after the sweep": Fault("zero_not_settled", on_channels("force", still_settling)),
    "film too thin": Fault("thin_film", change_plan=slow),
    "unknown oil": Fault("unknown_oil", header_line(0, text="mystery fluid")),
    "set point no number": Fault("header", header_line(1, text="high")),
    "misspelt header key": Fault("unknown_header_key", header_line(2, "entrainement_speed_m_s")),
    "header says a set point twice": Fault("header", header_line(-1, "inlet_temperature_c", "33")),
    "no temperature column": Fault("columns", labelled(celsius=None)),
    "no unit of the load": Fault("columns", without_unit),
    "force labelled in degrees": Fault("columns", labelled(force="°C")),
    "file cut off": Fault("truncated", rewritten(cut_off)),
    "no text": Fault("unknown_format", no_text),
    "names without rows": Fault("no_rows", only_rows(lambda run: np.arange(0))),
    "torn rows": Fault("unreadable_row clock_jump", rewritten(torn_rows)),
}
