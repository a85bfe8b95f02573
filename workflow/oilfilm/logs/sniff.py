"""What logs of an unknown laboratory hold: read by the readers themselves, under guessed names.

What a name of a column or a header line seems to mean is a guess, which becomes a line of a
settings file that a person reads. The words are in `words.yaml`: those of another language are
added there.

Decides: what `oilfilm init` finds in a folder of logs, and what it takes a column or a header line
for.
"""

import re
import unicodedata
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, field, replace
from functools import cache, cached_property
from pathlib import Path

import numpy as np
import yaml

from oilfilm.home import CONFIG
from oilfilm.logs import base
from oilfilm.logs.base import Names
from oilfilm.logs.header import UNITS, apart, meaning, number_and_unit, oil_key
from oilfilm.logs.ingest import READERS, read_log, recognised_format, unpack
from oilfilm.logs.log_kind import ContinuousLog, LogKind, Vocabulary
from oilfilm.logs.traction_log import TRACTION
from oilfilm.settings.base import plain_key
from oilfilm.settings.campaign import Column
from oilfilm.settings.resolve import resolve
from oilfilm.settings.resolved import Settings
from oilfilm.units import BoolArray, FloatArray

# Quantity -> words by how much they tell of it: see the file.
_WORDS: dict[str, dict[str, str]] = yaml.safe_load(
    Path(__file__).with_name("words.yaml").read_text(encoding="utf-8")
)
_WEIGHTS = {"most": 3, "some": 2, "least": 1}
# Words of the rig's bodies say whose speed it is only beside a unit or a word of speed.
_SPEED_WORDS = "speed drehzahl geschwind vitesse velocidad velocità скорость 速 rpm spind n v u"
_SHORT = 2
# A name with a word of the most telling ones may be the quantity, whatever other names say, but for
# those that need no guess.
_SURE, _KNOWN = 3, 100
_TOKENS = re.compile(r"[^\W\d_]+\d?|\d+")


def guessed(name: str, unit: str, vocabulary: Vocabulary) -> tuple[str, int]:
    """The quantity that a column's name seems to mean, and how likely it is; "" and 0: none.

    Args:
        name: Column name without its unit.
        unit: Unit as the log gives it; empty where it gives none.
        vocabulary: Units in which each quantity can be given.
    """
    # no single letter, because `n` may be a speed or newtons
    in_name = (unit_in_name(name, quantity, vocabulary) for quantity in vocabulary.quantities)
    unit = unit or next((each for each in in_name if len(each) > 1), "")
    scores = {"": 0}
    for quantity, words in _WORDS.items():
        if quantity not in vocabulary.quantities or (unit and not vocabulary.fits(quantity, unit)):
            continue
        of_a_body = quantity in ("ball_speed", "disc_speed") and not unit
        if has_word(name, words.get("others", "")) or (
            of_a_body and not has_word(name, _SPEED_WORDS)
        ):
            continue
        weighed = ((weight, words.get(key, "").split()) for key, weight in _WEIGHTS.items())
        scores[quantity] = sum(w * has_word(name, word) for w, of in weighed for word in of)
    best = max(scores, key=lambda quantity: scores[quantity])
    return best, scores[best]


def has_word(name: str, words: str) -> bool:
    """Whether a name has one of some words, given with blanks between, as a part of it."""
    plain = unicodedata.normalize("NFKC", name).casefold()
    tokens = set(_TOKENS.findall(plain))
    return any(
        word in tokens if len(word) <= _SHORT and word.isascii() else word in plain
        for word in words.split()
    )


def unit_in_name(name: str, quantity: str, vocabulary: Vocabulary) -> str:
    """The unit at an end of a name without brackets; empty where there is none."""
    ends = [name.split()[-1:], name.split()[-2:], name.split("/")[1:], name.split("_")[-1:]]
    # a letter before a name is a symbol
    ends += [words[:1] for words in [name.split()] if len(words) > 1 and len(words[0]) > 1]
    units = (" ".join(end).strip() for end in ends)
    fitting = (each for each in units if each not in ("", name))
    return next((each for each in fitting if vocabulary.fits(quantity, each)), "")


@dataclass(frozen=True)
class Guesses(Vocabulary):
    """A vocabulary in which names that are not known mean what they seem to mean.

    `symbols` says whether names that are symbols mean what papers use them for.
    """

    symbols: bool = False

    def meaning(self, name: str) -> tuple[str, str | None] | None:
        """See `Vocabulary.meaning`."""
        quantity, unit, _ = self.likely(name, apart(name)[1])
        return (quantity, unit or None) if quantity else None

    def likely(self, name: str, unit: str) -> tuple[str, str, int]:
        """Quantity and unit of a column's name, and how likely it is that."""
        if known := super().meaning(name):
            return known[0], unit or known[1] or "", _KNOWN
        bare = apart(name)[0]
        for quantity, words in _WORDS.items() if self.symbols else ():
            symbol = plain_key(bare) in words.get("symbols", "").split()
            if symbol and (not unit or self.fits(quantity, unit)):
                return quantity, unit, _KNOWN
        quantity, score = guessed(bare, unit, self)
        return quantity, unit, score

    def columns_by_quantity(self, names: Iterable[tuple[str, str]]) -> dict[str, Names]:
        """Names and units of the columns of a log by what they mean; several where in doubt."""
        scores: dict[str, dict[tuple[str, str], int]] = {}
        for name, beside in dict.fromkeys(names):
            quantity, unit, score = self.likely(name, beside or apart(name)[1])
            if quantity:
                scores.setdefault(quantity, {})[name, unit] = score
        found = {}
        for quantity, of in scores.items():
            best = max(of.values())
            least = best if best == _KNOWN else min(_SURE, best)
            found[quantity] = [name for name, score in of.items() if score >= least]
        return found


# ---------------------------------------------------------------- logs

VOCABULARY = TRACTION.vocabulary
_GUESSES = Guesses("traction", "columns", VOCABULARY.own_names, ())
# A signal is held at a level where its readings are as near to each other as this.
_NEAR, _NEAR_C = 0.05, 3.0
_MU = "traction_coefficient"
# No rig samples a sweep more slowly: a time without unit is in something else than seconds then.
_LONGEST_STEP_S = 5.0
_SPEEDS = frozenset({"ball_speed", "disc_speed", "entrainment_speed"})
_LOADS = {"N": "load_n", "GPa": "max_hertz_pressure_gpa"}


# Gives the source of the zero of the force by time, ball and disc speed, load, force; None: none.
ZeroSource = Callable[[FloatArray, FloatArray, FloatArray, FloatArray, FloatArray], str | None]


@dataclass(frozen=True)
class Run:
    """One run of a log.

    Attributes:
        part: Its name in its file; empty where a file of the format is one run.
        oil_key: The header line that names the oil; empty where none does.
        oil: What that line says.
        rig: What the header says of the rig.
        lines: Header lines of set points by the project's key: the line's name, its value.
        measured: Levels of load, speed and temperature, by set point; NaN: none is held.
        settled: Whether each row is a settled reading, so that nothing follows from its time.
        zero: Source of the zero of the force, as `semantics` names it; empty where that cannot be
            told, None where none suits.
        units: The unit of each quantity.
        log_kind: What the header says of it.
        slow: Whether the steps of the time are too long to be seconds.
    """

    part: str = ""
    oil_key: str = ""
    oil: str = ""
    rig: str = ""
    lines: Mapping[str, tuple[str, float]] = field(default_factory=dict)
    measured: Mapping[str, float] = field(default_factory=dict)
    settled: bool = False
    zero: str | None = ""
    units: Mapping[str, str] = field(default_factory=dict)
    log_kind: str = ""
    slow: bool = False


@dataclass(frozen=True)
class Sniffed:
    """One log.

    Attributes:
        file: Its path below the campaign's folder.
        format: Its format; `none` where it is not known.
        form: How it is written.
        guesses: Columns by the quantity that they seem to mean, each with its unit.
        units: Unit in the name of each column that has none beside it; empty where there is none.
        missing: Quantities that no column seems to mean.
        names: All names of its columns.
        problem: Why it cannot be read, if so.
        runs: Its runs.
        is_log: Whether it can be a log at all, if a damaged one.
    """

    file: str
    format: str
    form: base.TextForm
    guesses: Mapping[str, base.Names]
    units: Mapping[str, str]
    missing: Sequence[str]
    names: Sequence[str]
    problem: str
    runs: Sequence[Run]
    is_log: bool


@cache
def _settings() -> Settings:
    """Settings of a campaign without rig and oil: the readers ask for some."""
    return resolve(CONFIG, {"campaign": "etm-slim"})


def sniff(file: str, content: bytes, zero: ZeroSource) -> Sniffed:
    """What a log of a traction rig seems to hold."""
    name, names = _names(content)
    meant = _GUESSES.columns_by_quantity(names)
    # names of the project need no line in the campaign file, where their unit is known
    known = {each for each, of in meant.items() if all(VOCABULARY.meaning(n) and u for n, u in of)}
    guesses = {each: columns for each, columns in meant.items() if each not in known}
    certain = {quantity: each[0] for quantity, each in guesses.items() if len(each) == 1}
    # units that are not beside the name: in it, or unknown
    in_names = ((each, own) for each, (own, beside) in certain.items() if not beside)
    units = {quantity: unit_in_name(own, quantity, VOCABULARY) for quantity, own in in_names}
    # of time a unit that is not stated is the second; `_run` finds steps that contradict it
    unitless = {quantity for quantity, unit in units.items() if not unit and quantity != "time"}
    read_as = {each: unit or VOCABULARY.quantities[each][0] for each, unit in units.items()}
    renamed = {
        each: Column(name=[own], unit=read_as.get(each)) for each, (own, _) in certain.items()
    }
    runs: list[Run] = []

    def run(log: ContinuousLog, settings: Settings) -> base.LoggedRun:
        runs.append(_run(log.run_id[len(file) + 1 :], log, unitless, zero))
        return log.run("", {"row": log.rows}, {}, None)

    # the time of LabVIEW's logs need be no column; exports of PCS programs have no names to guess
    optional = {"csv": set(), "pcs": {*VOCABULARY.quantities}}.get(name, {"time"})
    missing = [each for each in _missing(meant) if each not in optional]
    # what is missing is asked of the user; the rest of the log is read without it
    spared = {*_missing(meant), "time"}
    probe = LogKind(VOCABULARY, lambda _: renamed, lambda *_: iter(()), run, (), lambda *_: spared)
    name, reading = read_log(content, file, _settings(), probe)
    refused = next(((each.rule, each.reason) for each in reading.refusals), ("", ""))
    # text is a log if some line names columns
    no_log = refused[0] == "unknown_format" or (name == "csv" and not names)
    own, problem = list(dict.fromkeys(name for name, _ in names if name)), refused[1]
    found = guesses, units, missing, own, "" if runs else problem, runs
    return Sniffed(file, name, reading.form, *found, not no_log)


def _names(content: bytes) -> tuple[str, base.Names]:
    """The format of a file, and the columns of its best table."""
    name, tables = "none", []
    try:
        content = unpack(content)
        name = recognised_format(content) or name
        if name != "pcs":
            _, found = READERS[name].tables(content, _GUESSES)
            tables = [[*zip(table.names, table.units, strict=True)] for table in found]
    except Exception:  # noqa: S110 - whatever a library stumbles over; reading the log says it
        pass
    best = max(tables, key=lambda names: len(_GUESSES.columns_by_quantity(names)), default=[])
    return name, best


def _missing(meant: Mapping[str, base.Names]) -> list[str]:
    """The quantities that a log needs and that no column means for certain."""
    known = {quantity for quantity, columns in meant.items() if len(columns) == 1}
    if _MU in known:
        # a table of mu has no force, and no time: its rows are settled readings
        known |= {"traction_force", "time"}
    speeds = max(VOCABULARY.either, key=lambda pair: len(known & {*pair}))
    return [quantity for quantity in (*VOCABULARY.always, *speeds) if quantity not in known]


def _run(part: str, log: ContinuousLog, unitless: Set[str], zero: ZeroSource) -> Run:
    """What the columns and header lines of a run show; nothing follows from `unitless` ones."""
    # the oil and the rig of the settings for the readers are not those of the log
    unsaid = {"oil", "rig"} - log.understood.sources.keys()
    keys = {key: text for key, text in log.keys.items() if key not in unsaid}
    count, values, units = len(log.rows), log.values, log.units
    nothing = np.full(count, np.nan)
    names = "time", "load", "traction_force", "inlet_temperature"
    time, load, force, temperature = (values.get(name, nothing) for name in names)
    ball, disc = _surface_speeds(values, units, nothing)
    mean = (ball + disc) / 2
    turning = _turning(mean)
    levels = {} if "load" in unitless else {_LOADS[units.get("load", "N")]: load}
    if units.get("ball_speed") != "rpm" and not _SPEEDS & unitless:
        levels["entrainment_speed_m_s"] = mean
    if "inlet_temperature" not in unitless:
        levels["inlet_temperature_c"] = temperature
    # what is logged at standstill is no level of the run
    used = turning if turning.any() else np.ones(count, dtype=bool)
    measured = {key: _level(key, each[used]) for key, each in levels.items()}
    log_kind = keys.get("log_kind", "")
    settled = log_kind == "steps" or (_MU in values and "time" not in values)
    signals = (time, ball, disc, load, force)
    continuous = count > 1 and np.isfinite(signals).all() and not settled
    named = oil_key(keys) or "oil"
    step = float(np.median(np.diff(time))) if count > 1 else 0.0
    timed = continuous and "time" not in unitless and step > 0
    slow = not settled and step > _LONGEST_STEP_S
    said = part, named, keys.get(named, ""), keys.get("rig", ""), _lines(keys)
    found = measured, settled, zero(*signals) if timed else "", units
    return Run(*said, *found, log_kind, slow)


def _level(key: str, values: FloatArray) -> float:
    """The median as a set point is written, where the signal is held at a level; else NaN."""
    known = np.abs(values[np.isfinite(values)])
    if not len(known):
        return np.nan
    low, median, high = np.quantile(known, (0.1, 0.5, 0.9))
    if key == "inlet_temperature_c":
        return round(float(median), 1) if high - low <= _NEAR_C else np.nan
    return float(f"{median:.3g}") if high - low <= _NEAR * median else np.nan


def _surface_speeds(
    values: Mapping[str, FloatArray], units: Mapping[str, str], nothing: FloatArray
) -> tuple[FloatArray, FloatArray]:
    """Speeds of ball and disc; NaN where the log does not give them.

    Of spindle speeds the beginning is taken for pure rolling, because the radii are not known.
    """
    if {"ball_speed", "disc_speed"} <= values.keys():
        ball, disc = values["ball_speed"], values["disc_speed"]
        if units["ball_speed"] == "rpm":
            first = np.flatnonzero(_turning(ball) & _turning(disc))[: max(1, len(ball) // 50)]
            if len(first):
                disc = disc * (np.median(ball[first]) / np.median(disc[first]))
        return ball, disc
    mean = values.get("entrainment_speed", nothing)
    half = values.get("slide_roll_ratio", nothing) / 2
    return mean * (1 - half), mean * (1 + half)


def _turning(speed: FloatArray) -> BoolArray:
    """The rows at more than half of the speed of the fastest ones."""
    known = len(speed) > 0 and np.isfinite(speed).all()
    return np.abs(speed) > (np.quantile(np.abs(speed), 0.9) / 2 if known else np.inf)


# ---------------------------------------------------------------- header lines


def _lines(keys: Mapping[str, str]) -> dict[str, tuple[str, float]]:
    """The header lines that give set points with their unit; of two for one, the first."""
    lines: dict[str, tuple[str, float]] = {}
    for name, text in keys.items():
        bare, beside = apart(name)
        words = bare.replace("_", " ")
        last, behind = plain_key(f" {words}".split(" ")[-1]), number_and_unit(text)[1]
        for key, (quantity, unit) in base.SET_POINT_UNITS.items():
            meant = guessed(words, unit, VOCABULARY)[0]
            if name != key and meant != quantity.replace("max_hertz_pressure", "load"):
                continue
            found, number = meaning(name, text, {plain_key(words): key})
            value = base.set_point(key, number) if found == key else None
            given = name == key or beside or behind or UNITS.get(last) == unit
            if value is not None and given:
                lines.setdefault(key, (words, value))
                break
    return lines


def set_points(run: Run) -> dict[str, float]:
    """Levels of a run whose set points its header does not give."""
    # the load has one set point, as force or as pressure
    given = run.lines.keys() | (base.LOADS if run.lines.keys() & base.LOADS else frozenset())
    levels = run.measured.items()
    return {key: level for key, level in levels if np.isfinite(level) and key not in given}


def rows_of_sheet(log: Sniffed) -> Sequence[Run]:
    """The runs of a log that need a row of the run sheet; one for all where they are alike."""
    first = log.runs[0] if log.runs else Run()
    same = all(set_points(run) == set_points(first) for run in log.runs)
    return [replace(first, part="")] if same or not log.runs else log.runs


# ---------------------------------------------------------------- all logs

_UMLAUTS = str.maketrans({"ä": "ae", "ö": "oe", "ü": "ue", "ß": "ss"})
_FEWEST_GUESSES = 3


def shipped(kind: str) -> dict[str, str]:
    """Names of the rigs or oils that are part of oilfilm, by their plain form."""
    paths = (CONFIG / kind).glob("*.yaml")
    return {plain_key(path.stem): path.stem for path in paths if path.stem != "template"}


@dataclass(frozen=True)
class Findings:
    """What was found in all logs together."""

    logs: Sequence[Sniffed]

    @property
    def runs(self) -> Iterator[Run]:
        """The runs of all logs."""
        return (run for log in self.logs for run in log.runs)

    @property
    def named(self) -> list[Sniffed]:
        """The logs whose columns were recognised, at least in part."""
        return [log for log in self.logs if log.runs or len(log.guesses) >= _FEWEST_GUESSES]

    @cached_property
    def columns(self) -> dict[str, list[str]]:
        """Names of columns by the quantity that they seem to mean."""
        # a unit in brackets is read; without one the name is as the log writes it
        return _grouped(
            (quantity, apart(name)[0] if unit else name)
            for log in self.named
            for quantity, columns in log.guesses.items()
            for name, unit in (columns if len(columns) == 1 else ())
        )

    @property
    def doubtful(self) -> dict[str, list[str]]:
        """Quantities that no column seems to mean, or several: the names to choose from."""
        found: dict[str, dict[str, None]] = {}
        for log in self.named:
            several = {q: [n for n, _ in each] for q, each in log.guesses.items() if len(each) > 1}
            for quantity in {*log.missing, *several}:
                names = several.get(quantity, [name for name in log.names if _is_left(name, log)])
                found.setdefault(quantity, {}).update(dict.fromkeys(names))
        return {quantity: [*found[quantity]] for quantity in sorted(found)}

    def unit(self, quantity: str) -> tuple[str, bool]:
        """The unit for the campaign file, empty where the logs give it; whether it is unknown."""
        units = {log.units[quantity] for log in self.named if quantity in log.units}
        seconds = quantity == "time" and not any(run.slow for run in self.runs)
        known = next(iter(units)) if len(units) == 1 else ""
        known = "s" if units == {""} and seconds else known
        return known, bool(units) and not known

    @property
    def header(self) -> dict[str, list[str]]:
        """Names of header lines by the project's key, without those that are the key itself."""
        of_oils = [("oil", run.oil_key.replace("_", " ")) for run in self.runs if run.oil_key]
        lines = [(key, name) for run in self.runs for key, (name, _) in run.lines.items()]
        return _grouped((k, name) for k, name in [*of_oils, *lines] if plain_key(name) != k)

    @cached_property
    def oils(self) -> dict[str, list[str]]:
        """What the logs call each oil, by the id that it gets; one id where no log says it."""
        labels = dict.fromkeys(run.oil for run in self.runs if run.oil)
        numbered = enumerate(labels, start=1)
        return _grouped((_oil_id(each) or f"oil-{n}", each) for n, each in numbered) or {
            "my-oil": []
        }

    @property
    def unnamed_oil(self) -> bool:
        """Whether some logs name an oil and others do not, so that these need it of the sheet."""
        return len(self.oils) > 1 and any(not run.oil for run in self.runs)

    @cached_property
    def rigs(self) -> list[str]:
        """Rigs by the names that the logs give them; one of its own where none does."""
        known = shipped("rigs")
        named = [known.get(plain_key(run.rig), _slug(run.rig)) for run in self.runs if run.rig]
        pcs = [log for log in self.logs if log.format == "pcs"]
        if pcs and not named:
            return ["pcs-etm" if all("etm" in log.file.lower() for log in pcs) else "pcs-rig"]
        return list(dict.fromkeys(name for name in named if name)) or ["my-rig"]

    @property
    def needs_radii(self) -> bool:
        """Whether speeds are those of spindles, so that the radii of the tracks are needed."""
        return any(run.units.get("ball_speed") == "rpm" for run in self.runs)

    @property
    def needs_contact(self) -> bool:
        """Whether geometry and materials are needed: to know loads, or pressures of several loads.

        A pressure that every header states needs none.
        """
        loads = [each for run in self.runs if (each := run.measured.get("load_n", 0.0)) > 0]
        stated = all("max_hertz_pressure_gpa" in run.lines for run in self.runs)
        several = bool(loads) and max(loads) > (1 + _NEAR) * min(loads)
        return any(run.units.get("load") == "GPa" for run in self.runs) or (several and not stated)

    @cached_property
    def zeros(self) -> Counter[str | None]:
        """How many runs each source of the zero suits; None: none does."""
        return Counter(run.zero for run in self.runs if run.zero != "")

    @property
    def slip_is_logged(self) -> bool:
        """Whether the slip comes from a logged slide-roll ratio, whose definition is not known."""
        return any(run.units and "ball_speed" not in run.units for run in self.runs)

    @property
    def repeats(self) -> bool:
        """Whether two runs of one oil have the same set points."""
        conditions = []
        for run in self.runs:
            levels = set_points(run) | {key: value for key, (_, value) in run.lines.items()}
            # of runs whose condition is not known whole nobody can say that they repeat
            if (
                levels.keys() >= {"entrainment_speed_m_s", "inlet_temperature_c"}
                and levels.keys() & base.LOADS
            ):
                conditions.append((run.oil, *sorted(levels.items())))
        return len(set(conditions)) < len(conditions)

    @property
    def decimal_comma(self) -> bool:
        """Whether the laboratory writes numbers with a comma."""
        return any(log.form.decimal_mark == "comma" for log in self.logs)


def _grouped(pairs: Iterable[tuple[str, str]]) -> dict[str, list[str]]:
    """The different texts of each key, in the order in which they come."""
    grouped: dict[str, list[str]] = {}
    for key, text in dict.fromkeys(pairs):
        grouped.setdefault(key, []).append(text)
    return grouped


def _is_left(name: str, log: Sniffed) -> bool:
    """Whether nothing is known of a column of a log."""
    taken = {other for columns in log.guesses.values() for other, _ in columns}
    return name not in taken and VOCABULARY.meaning(name) is None


def _oil_id(label: str) -> str:
    """The shipped oil that a label names as a word of its own, else the label as an id."""
    words = re.findall(r"\w+", plain_key(label).replace("_", " "))
    known = shipped("oils")
    return next((known[word] for word in words if word in known), _slug(label))


def _slug(label: str) -> str:
    """A name as an id: ASCII letters, digits and '-'; empty where it has others."""
    plain = unicodedata.normalize("NFKD", label.casefold().translate(_UMLAUTS))
    plain = "".join(letter for letter in plain if not unicodedata.combining(letter))
    if not plain.isascii():
        return ""
    return re.sub(r"[^a-z0-9]+", "-", plain).strip("-")[:60]
