"""Faults that the laboratory makes, and the rules that name each of them rightly."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from blind_lab.bench import Bench, Condition, Recording, lagging
from blind_lab.dialects import Dialect, columns_of, header_of, written
from blind_lab.truth import Array, Oil

Random = np.random.Generator
Columns = dict[str, tuple[str, Array]]


@dataclass(frozen=True)
class Draft:
    """A log on its way to the disk: each fault changes one of its stages.

    Attributes:
        recording: The signals in SI units.
        header: Header lines.
        columns: What the logger writes of each signal.
        dialect: How it writes.
        content: Its bytes; None before it is written.
    """

    recording: Recording
    header: dict[str, str]
    columns: Columns
    dialect: Dialect
    content: bytes | None = None

    def column(self, name: str, change: Callable[[Array], Array]) -> "Draft":
        """With one written column changed."""
        unit, values = self.columns[name]
        return replace(self, columns={**self.columns, name: (unit, change(values.copy()))})

    def bytes(self) -> bytes:
        """The file."""
        return self.content or written(self.header, self.columns, self.dialect)


def draft(recording: Recording, dialect: Dialect, bench: Bench) -> Draft:
    """A sound log."""
    columns = columns_of(recording, dialect, bench.machine)
    return Draft(recording, header_of(recording, dialect), columns, dialect)


@dataclass(frozen=True)
class Fault:
    """A fault and the rules of which one must name it.

    Attributes:
        rules: Rules, the best first; the others name the same cause in a wider sense.
        of_run: Changes the run before it is written (SI units).
        of_draft: Changes the log as it is written.
        condition: Changes what is asked of the rig.
        units: Units that the logger writes of some signals.
        slips: Changes the levels of slip that are asked of the rig.
    """

    rules: tuple[str, ...]
    of_run: Callable[[Recording, Random], Recording] | None = None
    of_draft: Callable[[Draft, Random], Draft] | None = None
    condition: Callable[[Condition, Oil, Bench], Condition] | None = None
    units: tuple[tuple[str, str], ...] = ()
    slips: Callable[[Array], Array] = lambda slips: slips


# ---------------------------------------------------------------- signals


def _middle(recording: Recording) -> tuple[int, int]:
    """Rows of the sweep's middle half."""
    first, last = int(recording.steps[1]), int(recording.steps[-2])
    quarter = (last - first) // 4
    return first + quarter, last - quarter


def frozen(name: str) -> Callable[[Recording, Random], Recording]:
    """One channel stops moving in the middle of the sweep, to its end."""

    def change(recording: Recording, random: Random) -> Recording:
        values = recording.signals[name].copy()
        start, _ = _middle(recording)
        values[start:] = values[start]
        return recording.changed(**{name: values})

    return change


def scaled(name: str, factor: float) -> Callable[[Recording, Random], Recording]:
    """A channel is in another unit than its label says."""
    return lambda recording, random: recording.changed(**{name: recording.signals[name] * factor})


def shifted(name: str, by: float) -> Callable[[Recording, Random], Recording]:
    """A channel is off by a constant."""
    return lambda recording, random: recording.changed(**{name: recording.signals[name] + by})


def drifting(name: str, by: float) -> Callable[[Recording, Random], Recording]:
    """A channel moves by so much over the run."""
    return lambda recording, random: recording.changed(
        **{name: recording.signals[name] + np.linspace(0, by, len(recording))}
    )


def swapped_speeds(recording: Recording, random: Random) -> Recording:
    """The columns of ball and disc are exchanged."""
    return recording.changed(ball=recording.signals["disc"], disc=recording.signals["ball"])


def hard_limit(recording: Recording, random: Random) -> Recording:
    """The force stops at 60 % of its largest reading."""
    force = recording.signals["force"]
    return recording.changed(force=np.minimum(force, 0.6 * force.max()))


def soft_limit(recording: Recording, random: Random) -> Recording:
    """The amplifier compresses: large forces come out too small, without a stop."""
    force = recording.signals["force"]
    limit = 0.75 * force.max()
    return recording.changed(force=limit * np.tanh(force / limit))


def wild(recording: Recording, random: Random) -> Recording:
    """15 % of the force readings are wrong by several times their value."""
    force = recording.signals["force"].copy()
    hit = random.random(len(force)) < 0.15
    force[hit] *= random.uniform(3, 8, hit.sum())
    return recording.changed(force=force)


def load_step(recording: Recording, random: Random) -> Recording:
    """The load rises by half in the middle of every second step."""
    load = recording.signals["load"].copy()
    for start, stop in zip(recording.steps[1:-2:2], recording.steps[2:-1:2], strict=False):
        load[(start + stop) // 2 : stop] *= 1.5
    return recording.changed(load=load)


def clock_set(by: float) -> Callable[[Recording, Random], Recording]:
    """The clock jumps by so many seconds: it is set back, or the logger pauses."""

    def change(recording: Recording, random: Random) -> Recording:
        time = recording.signals["time"].copy()
        time[_middle(recording)[0] :] += by
        return recording.changed(time=time)

    return change


def doubled_rows(recording: Recording, random: Random) -> Recording:
    """Every row is written twice."""
    return recording.rows(np.repeat(np.arange(len(recording)), 2))


def missing_block(recording: Recording, random: Random) -> Recording:
    """The force has no number for a third of the sweep."""
    force = recording.signals["force"].copy()
    start, stop = _middle(recording)
    force[start:stop] = np.nan
    return recording.changed(force=force)


def without_opening(recording: Recording, random: Random) -> Recording:
    """The log begins when the sweep has begun."""
    return recording.rows(np.arange(recording.steps[1] + 10, len(recording)))


def without_closing(recording: Recording, random: Random) -> Recording:
    """The log ends before the closing phase of rolling."""
    return recording.rows(np.arange(recording.steps[-2]))


def hurried(recording: Recording, random: Random) -> Recording:
    """Each slip is held for 0.9 s only."""
    kept = np.zeros(len(recording), dtype=bool)
    kept[: recording.steps[1]] = kept[recording.steps[-2] :] = True
    interval = recording.signals["time"][1] - recording.signals["time"][0]
    for start in recording.steps[1:-2]:
        kept[start : start + int(0.9 / interval)] = True
    shorter = recording.rows(kept)
    return shorter.changed(time=recording.signals["time"][: len(shorter)])


def dead_force(recording: Recording, random: Random) -> Recording:
    """The cable of the force sensor is off: noise about a constant."""
    noise = 0.008 * random.standard_normal(len(recording))
    return recording.changed(force=np.round(0.3 + noise, 4))


def dead_load(recording: Recording, random: Random) -> Recording:
    """The load cell is unplugged: noise about zero."""
    return recording.changed(load=np.round(0.1 * random.standard_normal(len(recording)), 3))


def open_thermocouple(recording: Recording, random: Random) -> Recording:
    """The thermocouple is open: the amplifier's end of range."""
    return recording.changed(celsius=np.full(len(recording), 850.0))


def sluggish(recording: Recording, random: Random) -> Recording:
    """The force comes through a filter of 1.5 s."""
    force, interval = recording.signals["force"], recording.signals["time"][1]
    return recording.changed(force=lagging(force, 1 / interval, 1.5))


def noisy(recording: Recording, random: Random) -> Recording:
    """The force has thirty times its noise."""
    noise = 0.24 * random.standard_normal(len(recording))
    return recording.changed(force=recording.signals["force"] + noise)


def in_middle(name: str, change: Callable[[Array], Array]) -> Callable[..., Recording]:
    """A channel changed in the sweep's middle half."""

    def changed(recording: Recording, random: Random) -> Recording:
        values = recording.signals[name].copy()
        rows = slice(*_middle(recording))
        values[rows] = change(values[rows])
        return recording.changed(**{name: values})

    return changed


def from_middle(name: str, factor: float) -> Callable[[Recording, Random], Recording]:
    """The gain of a channel changes in the middle of the sweep, for good."""

    def changed(recording: Recording, random: Random) -> Recording:
        values = recording.signals[name].copy()
        values[sum(_middle(recording)) // 2 :] *= factor
        return recording.changed(**{name: values})

    return changed


def range_switch(recording: Recording, random: Random) -> Recording:
    """Above a slip of 0.1 the amplifier has another range, half as much again."""
    ball, disc, force = (recording.signals[name] for name in ("ball", "disc", "force"))
    slip = 2 * (disc - ball) / (disc + ball)
    return recording.changed(force=np.where(slip > 0.1, 1.5 * force, force))


def way_back(recording: Recording, random: Random) -> Recording:
    """The force is a tenth larger on the way back."""
    force = recording.signals["force"].copy()
    force[recording.steps[len(recording.steps) // 2] : recording.steps[-2]] *= 1.1
    return recording.changed(force=force)


def backwards(name: str) -> Callable[[Recording, Random], Recording]:
    """A channel is written in the opposite order of time."""
    return lambda recording, random: recording.changed(**{name: recording.signals[name][::-1]})


def constant(name: str) -> Callable[[Recording, Random], Recording]:
    """A channel copies one number into every row."""

    def change(recording: Recording, random: Random) -> Recording:
        values = recording.signals[name]
        return recording.changed(**{name: np.full(len(values), np.round(values.mean(), 1))})

    return change


def flipped(recording: Recording, random: Random) -> Recording:
    """From the middle of the sweep the columns of ball and disc are exchanged."""
    ball, disc = (recording.signals[name].copy() for name in ("ball", "disc"))
    rows = slice(sum(_middle(recording)) // 2, None)
    ball[rows], disc[rows] = disc[rows].copy(), ball[rows].copy()
    return recording.changed(ball=ball, disc=disc)


def thinned(recording: Recording, random: Random) -> Recording:
    """From the middle of the sweep the logger writes every fifth row only."""
    row = np.arange(len(recording))
    return recording.rows((row < _middle(recording)[0]) | (row % 5 == 0))


def still_settling(recording: Recording, random: Random) -> Recording:
    """The force creeps back to its zero while the rig rolls again."""
    time = recording.signals["time"]
    since = time - time[recording.steps[-2]]
    creep = np.where(since > 0, 1.5 * np.exp(-np.maximum(since, 0) / 2.5), 0.0)
    return recording.changed(force=recording.signals["force"] + creep)


def up_and_down(slips: Array) -> Array:
    """The same levels on the way back."""
    return np.concatenate([slips, slips[-2::-1]])


def slow(condition: Condition, oil: Oil, bench: Bench) -> Condition:
    """So slow that the film is twice the combined roughness, by Rq = 1.25 Ra."""
    machine = bench.machine
    film = machine.film(oil, condition.pressure * 1e9, condition.speed, condition.celsius)
    wanted = 2.0 * 1.25 * np.sqrt(2) * machine.roughness
    return replace(condition, speed=round(condition.speed * (wanted / film) ** (1 / 0.68), 3))


# ---------------------------------------------------------------- headers and files


def relabelled(name: str, unit: str) -> Callable[[Draft, Random], Draft]:
    """A column's numbers stay, its unit is written wrongly; for a column in its usual unit."""

    def change(sound: Draft, random: Random) -> Draft:
        _, values = sound.columns[name]
        return replace(sound, columns={**sound.columns, name: (unit, values)})

    return change


def header_line(index: int, text: str) -> Callable[[Draft, Random], Draft]:
    """One of the header's values is another."""

    def change(sound: Draft, random: Random) -> Draft:
        key = list(sound.header)[index]
        return replace(sound, header={**sound.header, key: text})

    return change


def misspelt_key(sound: Draft, random: Random) -> Draft:
    """The key of the entrainment speed is written in the project's way, with a slip of the pen."""
    keys = list(sound.header)
    keys[2] = "entrainement_speed_m_s"
    return replace(sound, header=dict(zip(keys, sound.header.values(), strict=True)))


def contradicting_header(sound: Draft, random: Random) -> Draft:
    """The header says the temperature twice, differently."""
    return replace(sound, header={**sound.header, "inlet_temperature_c": "33"})


def without_column(name: str) -> Callable[[Draft, Random], Draft]:
    """The logger does not write one of the signals."""
    return lambda sound, random: replace(
        sound, columns={key: value for key, value in sound.columns.items() if key != name}
    )


def without_unit(sound: Draft, random: Random) -> Draft:
    """The load has no unit."""
    return relabelled("load", "")(
        replace(sound, dialect=replace(sound.dialect, units_in_row=False)), random
    )


def rewritten(change: Callable[[Draft, list[str]], list[str]]) -> Callable[[Draft, Random], Draft]:
    """The lines of the written text are others."""

    def changed(sound: Draft, random: Random) -> Draft:
        plain, encoding = replace(sound.dialect, packed=False), sound.dialect.encoding
        lines = replace(sound, dialect=plain).bytes().decode(encoding).splitlines(keepends=True)
        content = "".join(change(sound, lines)).encode(encoding)
        return replace(sound, dialect=plain, content=content)

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


def junk(sound: Draft, random: Random) -> Draft:
    """The file holds anything but text."""
    return replace(sound, content=random.bytes(4000))


def names_alone(sound: Draft, random: Random) -> Draft:
    """The logger wrote its header and no row."""
    empty = {name: (unit, values[:0]) for name, (unit, values) in sound.columns.items()}
    return replace(sound, columns=empty)


# ---------------------------------------------------------------- the list

_KGF, _LBF = 9.80665, 4.4482216152605

FAULTS: dict[str, Fault] = {
    "force sensor frozen": Fault(("stuck_sensor", "stuck_channel"), frozen("force")),
    "ball speed frozen": Fault(("stuck_channel",), frozen("ball")),
    "disc speed frozen": Fault(("stuck_channel",), frozen("disc")),
    "load frozen": Fault(("stuck_channel",), frozen("load")),
    "temperature frozen": Fault(("stuck_channel",), frozen("celsius")),
    "force in kgf, labelled N": Fault(
        ("little_traction", "no_traction", "curve_off"), scaled("force", 1 / _KGF)
    ),
    "force in lbf, labelled N": Fault(("little_traction", "curve_off"), scaled("force", 1 / _LBF)),
    "force in mN, labelled N": Fault(("force_scale",), scaled("force", 1e3)),
    "force in kN, labelled N": Fault(("no_traction",), scaled("force", 1e-3)),
    "force seven times too large": Fault(
        ("traction_unphysical", "impossible_traction", "curve_off"), scaled("force", 7.0)
    ),
    "force polarity": Fault(("swapped_sign",), scaled("force", -1.0)),
    "ball and disc exchanged": Fault(("swapped_channels",), swapped_speeds),
    "load in kgf, labelled N": Fault(("load_off_nominal",), scaled("load", 1 / _KGF)),
    "load in kN, labelled N": Fault(("load_off_nominal",), scaled("load", 1e-3)),
    "load off by 12 %": Fault(("load_off_nominal",), scaled("load", 1.12)),
    "load rises within steps": Fault(
        ("load_changes", "load_off_nominal", "many_plateaus_fail"), load_step
    ),
    "load cell unplugged": Fault(("load_off_nominal", "traction_missing"), dead_load),
    "speed off by 10 %": Fault(
        ("speed_off_nominal",),
        lambda recording, random: recording.changed(
            ball=1.1 * recording.signals["ball"], disc=1.1 * recording.signals["disc"]
        ),
    ),
    "speeds in rad/s, labelled 1/min": Fault(
        ("speed_unit", "speed_off_nominal"),
        of_draft=relabelled("ball", "rpm"),
        units=(("ball", "rad/s"), ("disc", "rpm")),
    ),
    "temperature in K, labelled degC": Fault(
        ("temperature_off_nominal",), shifted("celsius", 273.15)
    ),
    "temperature off by 10 K": Fault(("temperature_off_nominal",), shifted("celsius", 10.0)),
    "temperature drifts by 6 K": Fault(
        ("temperature_drift", "temperature_off_nominal"), drifting("celsius", 6.0)
    ),
    "open thermocouple": Fault(("temperature_off_nominal", "stuck_channel"), open_thermocouple),
    "force saturated": Fault(("saturated",), hard_limit),
    "force softly saturated": Fault(("curve_off", "soft_saturation"), soft_limit),
    "15 % wild readings": Fault(("spiky", "not_steady", "no_point_left"), wild),
    "zero drifts by 1 N": Fault(("zero_drift",), drifting("force", 1.0)),
    "force cable off": Fault(("no_traction", "curve_off"), dead_force),
    "clock set back": Fault(("time_disorder",), clock_set(-60.0)),
    "logger paused": Fault(("clock_jump",), clock_set(60.0)),
    "rows written twice": Fault(("time_disorder",), doubled_rows),
    "block of NaN": Fault(("missing_readings",), missing_block),
    "time in ms, labelled s": Fault(("time_unit",), scaled("time", 1e3)),
    "time in min, labelled s": Fault(("time_unit",), scaled("time", 1 / 60)),
    "no opening phase": Fault(("zero_missing",), without_opening),
    "no closing phase": Fault(("zero_missing",), without_closing),
    "steps too short": Fault(("too_short", "no_plateau", "not_steady"), hurried),
    "filter of 1.5 s": Fault(("transient_not_ended", "not_steady", "zero_not_settled"), sluggish),
    "noise times 30": Fault(("zero_noisy", "noisy_sensor"), noisy),
    "one column for both speeds": Fault(
        ("same_channel",),
        lambda recording, random: recording.changed(ball=recording.signals["disc"]),
    ),
    "force in the opposite order": Fault(("order_of_time",), backwards("force")),
    "range switch": Fault(("gain_jump",), range_switch),
    "gain changes within the run": Fault(("gain_jump",), from_middle("force", 1.3)),
    "zero jumps and returns": Fault(("gain_jump",), in_middle("force", lambda force: force + 0.4)),
    "way back is 10 % higher": Fault(
        ("branches_apart", "branches_differ"), way_back, slips=up_and_down
    ),
    "load is one number": Fault(("constant_channel",), constant("load")),
    "temperature is one number": Fault(("constant_channel",), constant("celsius")),
    "speeds exchanged from the middle on": Fault(("sign_changes",), flipped),
    "slips in steps of 0.0018": Fault(
        ("small_steps",), slips=lambda slips: 0.0018 * np.arange(1, len(slips) + 1)
    ),
    "every fifth row from the middle on": Fault(("sampling_rate",), thinned),
    "log of a rig with other radii": Fault(("track_radii",), scaled("disc", 1.25)),
    "creep after the sweep": Fault(("zero_not_settled",), still_settling),
    "film too thin": Fault(("thin_film",), condition=slow),
    "unknown oil": Fault(("unknown_oil",), of_draft=header_line(0, "mystery fluid")),
    "set point no number": Fault(("header",), of_draft=header_line(1, "high")),
    "misspelt header key": Fault(("unknown_header_key",), of_draft=misspelt_key),
    "header says a set point twice": Fault(("header",), of_draft=contradicting_header),
    "no temperature column": Fault(("columns",), of_draft=without_column("celsius")),
    "no unit of the load": Fault(("columns",), of_draft=without_unit),
    "force labelled in degrees": Fault(("columns",), of_draft=relabelled("force", "°C")),
    "file cut off": Fault(("truncated",), of_draft=rewritten(cut_off)),
    "no text": Fault(("unknown_format",), of_draft=junk),
    "names without rows": Fault(("no_rows",), of_draft=names_alone),
    "torn rows": Fault(("unreadable_row", "clock_jump"), of_draft=rewritten(torn_rows)),
}


def faulty(
    fault: Fault, oil: Oil, condition: Condition, bench: Bench, dialect: Dialect, random: Random
) -> bytes:
    """The bytes of a log with a fault."""
    asked = fault.condition(condition, oil, bench) if fault.condition else condition
    recording = replace(bench, slips=fault.slips(bench.slips)).run(oil, asked, random)
    if fault.of_run:
        recording = fault.of_run(recording, random)
    sound = draft(recording, dialect.with_units(**dict(fault.units)), bench)
    return (fault.of_draft(sound, random) if fault.of_draft else sound).bytes()
