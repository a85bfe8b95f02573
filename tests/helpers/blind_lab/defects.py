"""Faults that the laboratory makes, and the rules that name each of them rightly."""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from blind_lab.bench import Bench, Condition, Recording, lagging
from blind_lab.dialects import Dialect, columns_of, header_of, written
from blind_lab.truth import Array, Oil

Random = np.random.Generator
Columns = dict[str, tuple[str, Array]]
Change = Callable[[Recording, Random], Recording]


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
    of_run: Change | None = None
    of_draft: Callable[[Draft, Random], Draft] | None = None
    condition: Callable[[Condition, Oil, Bench], Condition] | None = None
    units: tuple[tuple[str, str], ...] = ()
    slips: Callable[[Array], Array] = lambda slips: slips


# ---------------------------------------------------------------- signals


def on(name: str, change: Callable[[Array, Recording, Random], Array]) -> Change:
    """A channel changed, by its readings, the run and random numbers."""
    return lambda run, random: run.changed(**{name: change(run.signals[name], run, random)})


def scaled(name: str, factor: float) -> Change:
    """A channel is in another unit than its label says."""
    return on(name, lambda values, *_: values * factor)


def shifted(name: str, by: float) -> Change:
    """A channel is off by a constant."""
    return on(name, lambda values, *_: values + by)


def drifting(name: str, by: float) -> Change:
    """A channel moves by so much over the run."""
    return on(name, lambda values, *_: values + np.linspace(0, by, len(values)))


def middle(run: Recording) -> Array:
    """Rows of the sweep's middle half."""
    first, last = int(run.steps[1]), int(run.steps[-2])
    quarter, rows = (last - first) // 4, np.arange(len(run))
    return (rows >= first + quarter) & (rows < last - quarter)


def late(run: Recording) -> Array:
    """Rows from the beginning of the sweep's middle half on."""
    return np.logical_or.accumulate(middle(run))


def second(run: Recording) -> Array:
    """Rows from the middle of the sweep on."""
    start, *_, last = np.flatnonzero(middle(run))
    return np.arange(len(run)) >= (start + last + 1) // 2


def frozen(name: str) -> Change:
    """One channel stops moving in the middle of the sweep, to its end."""
    return on(
        name, lambda values, run, _: np.where(late(run), values[np.argmax(late(run))], values)
    )


def constant(name: str) -> Change:
    """A channel copies one number into every row."""
    return on(name, lambda values, *_: np.full(len(values), np.round(values.mean(), 1)))


def clock_set(by: float) -> Change:
    """The clock jumps by so many seconds: it is set back, or the logger pauses."""
    return on("time", lambda values, run, _: values + by * late(run))


def only(rows: Callable[[Recording], Array]) -> Change:
    """Only some rows of the run, or some of them twice."""
    return lambda run, random: run.rows(rows(run))


def exchanged(rows: Callable[[Recording], Array]) -> Change:
    """The columns of ball and disc are exchanged in some rows."""

    def change(run: Recording, random: Random) -> Recording:
        ball, disc = (run.signals[name] for name in ("ball", "disc"))
        where = rows(run)
        return run.changed(ball=np.where(where, disc, ball), disc=np.where(where, ball, disc))

    return change


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


def load_step(load: Array, run: Recording, _: Random) -> Array:
    """The load rises by half in the middle of every second step."""
    changed = load.copy()
    for start, stop in zip(run.steps[1:-2:2], run.steps[2:-1:2], strict=False):
        changed[(start + stop) // 2 : stop] *= 1.5
    return changed


def hurried(recording: Recording, random: Random) -> Recording:
    """Each slip is held for 0.9 s only."""
    kept = np.zeros(len(recording), dtype=bool)
    kept[: recording.steps[1]] = kept[recording.steps[-2] :] = True
    interval = recording.signals["time"][1] - recording.signals["time"][0]
    for start in recording.steps[1:-2]:
        kept[start : start + int(0.9 / interval)] = True
    shorter = recording.rows(kept)
    return shorter.changed(time=recording.signals["time"][: len(shorter)])


def range_switch(force: Array, run: Recording, _: Random) -> Array:
    """Above a slip of 0.1 the amplifier has another range, half as much again."""
    ball, disc = run.signals["ball"], run.signals["disc"]
    return np.where(2 * (disc - ball) / (disc + ball) > 0.1, 1.5 * force, force)


def way_back(force: Array, run: Recording, _: Random) -> Array:
    """The force is a tenth larger on the way back."""
    rows = np.arange(len(run))
    back = (rows >= run.steps[len(run.steps) // 2]) & (rows < run.steps[-2])
    return np.where(back, 1.1 * force, force)


def still_settling(force: Array, run: Recording, _: Random) -> Array:
    """The force creeps back to its zero while the rig rolls again."""
    since = run.signals["time"] - run.signals["time"][run.steps[-2]]
    return force + np.where(since > 0, 1.5 * np.exp(-np.maximum(since, 0) / 2.5), 0.0)


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
    "ball and disc exchanged": Fault(
        ("swapped_channels",), exchanged(lambda run: np.ones(len(run), bool))
    ),
    "load in kgf, labelled N": Fault(("load_off_nominal",), scaled("load", 1 / _KGF)),
    "load in kN, labelled N": Fault(("load_off_nominal",), scaled("load", 1e-3)),
    "load off by 12 %": Fault(("load_off_nominal",), scaled("load", 1.12)),
    "load rises within steps": Fault(
        ("load_changes", "load_off_nominal", "many_plateaus_fail"), on("load", load_step)
    ),
    "load cell unplugged": Fault(
        ("load_off_nominal", "traction_missing"),
        on("load", lambda load, _, random: np.round(0.1 * random.standard_normal(len(load)), 3)),
    ),
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
    "open thermocouple": Fault(
        ("temperature_off_nominal", "stuck_channel"),
        on("celsius", lambda values, *_: np.full(len(values), 850.0)),
    ),
    "force saturated": Fault(
        ("saturated",), on("force", lambda force, *_: np.minimum(force, 0.6 * force.max()))
    ),
    "force softly saturated": Fault(("curve_off", "soft_saturation"), on("force", soft_limit)),
    "15 % wild readings": Fault(("spiky", "not_steady", "no_point_left"), on("force", wild)),
    "zero drifts by 1 N": Fault(("zero_drift",), drifting("force", 1.0)),
    "force cable off": Fault(
        ("no_traction", "curve_off"),
        on(
            "force",
            lambda force, _, random: np.round(0.3 + 0.008 * random.standard_normal(len(force)), 4),
        ),
    ),
    "clock set back": Fault(("time_disorder",), clock_set(-60.0)),
    "logger paused": Fault(("clock_jump",), clock_set(60.0)),
    "rows written twice": Fault(
        ("time_disorder",), only(lambda run: np.repeat(np.arange(len(run)), 2))
    ),
    "block of NaN": Fault(
        ("missing_readings",),
        on("force", lambda force, run, _: np.where(middle(run), np.nan, force)),
    ),
    "time in ms, labelled s": Fault(("time_unit",), scaled("time", 1e3)),
    "time in min, labelled s": Fault(("time_unit",), scaled("time", 1 / 60)),
    "no opening phase": Fault(
        ("zero_missing",), only(lambda run: np.arange(run.steps[1] + 10, len(run)))
    ),
    "no closing phase": Fault(("zero_missing",), only(lambda run: np.arange(run.steps[-2]))),
    "steps too short": Fault(("too_short", "no_plateau", "not_steady"), hurried),
    "filter of 1.5 s": Fault(
        ("transient_not_ended", "not_steady", "zero_not_settled"),
        on("force", lambda force, run, _: lagging(force, 1 / run.signals["time"][1], 1.5)),
    ),
    "noise times 30": Fault(
        ("zero_noisy", "noisy_sensor"),
        on("force", lambda force, _, random: force + 0.24 * random.standard_normal(len(force))),
    ),
    "one column for both speeds": Fault(
        ("same_channel",),
        on("ball", lambda _, run, random: run.signals["disc"]),
    ),
    "force in the opposite order": Fault(
        ("order_of_time",), on("force", lambda force, *_: force[::-1])
    ),
    "range switch": Fault(("gain_jump",), on("force", range_switch)),
    "gain changes within the run": Fault(
        ("gain_jump",), on("force", lambda force, run, _: np.where(second(run), 1.3 * force, force))
    ),
    "zero jumps and returns": Fault(
        ("gain_jump",), on("force", lambda force, run, _: force + 0.4 * middle(run))
    ),
    "way back is 10 % higher": Fault(
        ("branches_apart", "branches_differ"), on("force", way_back), slips=up_and_down
    ),
    "load is one number": Fault(("constant_channel",), constant("load")),
    "temperature is one number": Fault(("constant_channel",), constant("celsius")),
    "speeds exchanged from the middle on": Fault(("sign_changes",), exchanged(second)),
    "slips in steps of 0.0018": Fault(
        ("small_steps",), slips=lambda slips: 0.0018 * np.arange(1, len(slips) + 1)
    ),
    "every fifth row from the middle on": Fault(
        ("sampling_rate",), only(lambda run: ~late(run) | (np.arange(len(run)) % 5 == 0))
    ),
    "log of a rig with other radii": Fault(("track_radii",), scaled("disc", 1.25)),
    "creep after the sweep": Fault(("zero_not_settled",), on("force", still_settling)),
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
