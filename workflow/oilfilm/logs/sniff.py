"""What the logs of an unknown laboratory hold: the readers read them with guessed names.

The meaning of a column name or a header line is a guess. It becomes a line of a settings file that
a person checks. The words are in `words.yaml`: those of another language are added there.

Decides: what `oilfilm init` finds in a folder of logs, and what it takes a column or a header line
for.
"""

import re
import unicodedata
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence, Set
from dataclasses import dataclass, field, replace
from functools import cache, cached_property

import numpy as np

from oilfilm.base.home import CONFIG
from oilfilm.base.plain_key import plain_key
from oilfilm.base.units import BoolArray, FloatArray
from oilfilm.logs import base
from oilfilm.logs.base import NamesAndUnits
from oilfilm.logs.header import (
    UNIT_BY_PLAIN_KEY,
    WORDS_FOR_OIL,
    number_and_unit,
    oil_synonym_key,
    project_key_and_text,
    split_bracketed_unit,
)
from oilfilm.logs.ingest import READERS, UNKNOWN_FORMAT, read_log, recognised_format, unpack
from oilfilm.logs.log_schema import (
    HeaderProblems,
    ListedColumns,
    LoggedColumn,
    LogSchema,
    UsableRows,
    Vocabulary,
)
from oilfilm.logs.meaning import (
    RANK_OF_WORDS,
    WordVocabulary,
    concepts_in,
    is_of_another_definition,
    meaning_of,
    quantity_in_logs,
    rank_of,
    split_unit,
)
from oilfilm.logs.traction_log import TRACTION
from oilfilm.settings.campaign import Campaign, Column
from oilfilm.settings.resolve import TEMPLATE_NAME, resolve
from oilfilm.settings.resolved import Settings


def columns_by_quantity(
    names_and_units: Iterable[tuple[str, str]], vocabulary: Vocabulary
) -> dict[str, NamesAndUnits]:
    """Quantity -> name and unit of its likely column; several columns where it is in doubt.

    A name that says the quantity comes before a symbol, and both before a name that leaves it open.
    Beside a total time another time may restart in each step: both are likely.

    Args:
        names_and_units: Name of each column and the unit beside it.
        vocabulary: Quantities, with the units in which each can be given.
    """
    ranks_by_quantity: dict[str, dict[tuple[str, str], int]] = {}
    distinct_columns = list(dict.fromkeys(names_and_units))
    has_total_time = any({"total", "time"} <= concepts_in(name) for name, _ in distinct_columns)
    for name, unit_beside_name in distinct_columns:
        unit = unit_beside_name or split_bracketed_unit(name)[1]
        quantity_and_unit = vocabulary.quantity_and_unit(name)
        if quantity_and_unit is not None:
            quantity, unit_of_name = quantity_and_unit
            is_sure = quantity != "time" or not has_total_time
            rank = 0 if is_sure else RANK_OF_WORDS
            ranks_by_quantity.setdefault(quantity, {})[name, unit or unit_of_name] = rank
            continue
        likely_meaning = meaning_of(name, unit)
        if likely_meaning is None or is_of_another_definition(likely_meaning):
            continue
        quantity = quantity_in_logs(likely_meaning.quantity)
        if quantity in vocabulary.units_of_quantity:
            ranks_by_quantity.setdefault(quantity, {})[name, unit] = rank_of(likely_meaning)
    columns_of_quantity: dict[str, NamesAndUnits] = {}
    for quantity, rank_of_column in ranks_by_quantity.items():
        best_rank = min(rank_of_column.values())
        columns_of_quantity[quantity] = [
            column for column, rank in rank_of_column.items() if rank == best_rank
        ]
    return columns_of_quantity


# ---------------------------------------------------------------- logs

VOCABULARY = TRACTION.vocabulary
_WORD_VOCABULARY = WordVocabulary("traction", "columns", VOCABULARY.quantity_and_unit_of_column, ())
# A signal is held at a level where its readings differ by less than this, relative or in K.
_LARGEST_LEVEL_SPREAD = 0.05
_LARGEST_LEVEL_SPREAD_C = 3.0
_TRACTION_COEFFICIENT = "traction_coefficient"
# Longest time between two rows of a sweep. A time without unit and with longer steps is not in s.
_LONGEST_INTERVAL_S = 5.0
_SPEED_QUANTITIES = frozenset({"ball_speed", "disc_speed", "entrainment_speed"})
# Unit of the load -> its set point.
_SET_POINT_BY_LOAD_UNIT = {"N": "load_n", "GPa": "max_hertz_pressure_gpa"}


# Function of time, speeds of ball and disc, load and force that gives the name of the source of the
# zero of the force; None where no source is suitable.
ZeroSourceFinder = Callable[
    [FloatArray, FloatArray, FloatArray, FloatArray, FloatArray], str | None
]


@dataclass(frozen=True)
class SniffedRun:
    """What columns and header lines of one run of a log show.

    Attributes:
        name_in_file: Its name in its file; empty where the file is one run.
        oil_key: Key of the header line that names the oil; empty without one.
        oil_name: Name of the oil in the header.
        rig_name: Name of the rig in the header.
        set_point_lines: Key of a set point -> name and value of its header line.
        measured_levels: Key of a set point -> measured level of load, speed or temperature; NaN
            where none is held.
        is_settled: Whether each row is a settled reading, so that its time has no meaning.
        zero_source: Source of the zero of the force, as `semantics: zero` of the campaign file
            names it; empty where the columns do not show it, None where no source is suitable.
        unit_of_quantity: Quantity -> its unit in the run.
        log_kind: Kind of log in the header.
        is_too_slow_for_seconds: Whether the steps of the time are too long to be seconds.
    """

    name_in_file: str = ""
    oil_key: str = ""
    oil_name: str = ""
    rig_name: str = ""
    set_point_lines: Mapping[str, tuple[str, float]] = field(default_factory=dict)
    measured_levels: Mapping[str, float] = field(default_factory=dict)
    is_settled: bool = False
    zero_source: str | None = ""
    unit_of_quantity: Mapping[str, str] = field(default_factory=dict)
    log_kind: str = ""
    is_too_slow_for_seconds: bool = False


@dataclass(frozen=True)
class SniffedLog:
    """What a log of a traction rig probably holds.

    Attributes:
        file: Its path below the campaign's folder.
        format_name: Its format; `none` where it is not known.
        dialect: How the text is written.
        candidates_of_quantity: Quantity -> its likely columns, each with the unit beside its name.
        unit_in_name_of_quantity: Quantity -> the unit in the name of its only candidate, where the
            log has no unit beside the name; empty where the name has none.
        missing_quantities: Quantities without a certain column.
        unit_of_column: Name of each column -> the unit beside or below it; empty where there is
            none.
        problem: Why the log cannot be read; empty where it can.
        runs: Its runs.
        may_be_log: Whether the file may be a log, be it a damaged one.
    """

    file: str
    format_name: str
    dialect: base.TextDialect
    candidates_of_quantity: Mapping[str, base.NamesAndUnits]
    unit_in_name_of_quantity: Mapping[str, str]
    missing_quantities: Sequence[str]
    unit_of_column: Mapping[str, str]
    problem: str
    runs: Sequence[SniffedRun]
    may_be_log: bool

    @property
    def names(self) -> list[str]:
        """Names of all columns."""
        return list(self.unit_of_column)


@cache
def _settings() -> Settings:
    """Settings of any campaign: the readers need some."""
    return resolve(CONFIG, {"campaign": "etm-slim"})


def sniff(file: str, content: bytes, find_zero_source: ZeroSourceFinder) -> SniffedLog:
    """What a log of a traction rig probably holds."""
    format_name, names_and_units = _format_and_names(content)
    candidates_by_quantity = columns_by_quantity(names_and_units, VOCABULARY)
    # names of the project need no line in the campaign file where their unit is known
    guessed_candidates = {
        quantity: candidates
        for quantity, candidates in candidates_by_quantity.items()
        if not all(VOCABULARY.quantity_and_unit(name) and unit for name, unit in candidates)
    }
    only_candidate_of_quantity = {
        quantity: candidates[0]
        for quantity, candidates in guessed_candidates.items()
        if len(candidates) == 1
    }
    unit_in_name_of_quantity = {
        quantity: split_unit(name)[1]
        for quantity, (name, unit_beside_name) in only_candidate_of_quantity.items()
        if not unit_beside_name
    }
    # a time without unit is in seconds; `_sniffed_run` finds steps that contradict it
    quantities_without_unit = {
        quantity
        for quantity, unit in unit_in_name_of_quantity.items()
        if not unit and quantity != "time"
    }
    listed_column_of_quantity: dict[str, Column] = {}
    for quantity, candidates in guessed_candidates.items():
        # any one of several clocks shows what the log holds
        if quantity not in only_candidate_of_quantity and quantity != "time":
            continue
        name, unit_beside_name = candidates[0]
        usual_unit = VOCABULARY.units_of_quantity[quantity][0]
        unit = None if unit_beside_name else split_unit(name)[1] or usual_unit
        listed_column_of_quantity[quantity] = Column(name=[name], unit=unit)
    missing_quantities = _missing_quantities(candidates_by_quantity)
    runs: list[SniffedRun] = []

    def collect_run(rows: UsableRows, settings: Settings) -> base.LoggedRun:
        runs.append(
            _sniffed_run(
                rows.run_id[len(file) + 1 :], rows, quantities_without_unit, find_zero_source
            )
        )
        return rows.logged_run("", {"row": rows.row_numbers}, {}, None)

    format_name, parsed_log = read_log(
        content,
        file,
        _settings(),
        _schema_without_demands(
            listed_column_of_quantity, {*missing_quantities, "time"}, collect_run
        ),
    )
    first_refusal = parsed_log.refusals[0] if parsed_log.refusals else base.Refusal("", "")
    # text is a log if a line names columns
    is_no_log = first_refusal.rule == "unknown_format" or (
        format_name == "csv" and not names_and_units
    )
    return SniffedLog(
        file,
        format_name,
        parsed_log.dialect,
        guessed_candidates,
        unit_in_name_of_quantity,
        missing_quantities=_quantities_to_ask_for(missing_quantities, format_name),
        unit_of_column=_unit_of_column(names_and_units),
        problem="" if runs else first_refusal.reason,
        runs=runs,
        may_be_log=not is_no_log,
    )


def _schema_without_demands(
    listed_columns: ListedColumns,
    unneeded_quantities: Set[str],
    collect_run: Callable[[UsableRows, Settings], base.LoggedRun],
) -> LogSchema:
    """A schema that reads what is there, without demands on header and columns."""

    def columns_of_campaign(campaign: Campaign) -> ListedColumns:
        return listed_columns

    def no_problems(
        text_of_key: Mapping[str, str], columns: Sequence[LoggedColumn], settings: Settings
    ) -> HeaderProblems:
        return iter(())

    def quantities_without_column(text_of_key: Mapping[str, str], settings: Settings) -> Set[str]:
        return unneeded_quantities

    return LogSchema(
        VOCABULARY,
        columns_of_campaign,
        no_problems,
        collect_run,
        run_sheet_keys=(),
        find_unneeded_quantities=quantities_without_column,
    )


def _quantities_to_ask_for(missing_quantities: Sequence[str], format_name: str) -> list[str]:
    """The missing quantities that the user must name."""
    if format_name == "pcs":
        # the names in these exports are fixed
        return []
    if format_name in ("csv", "xlsx", "ods", "mat"):
        return list(missing_quantities)
    # the time of LabVIEW's logs need not be a column
    return [quantity for quantity in missing_quantities if quantity != "time"]


def _format_and_names(content: bytes) -> tuple[str, base.NamesAndUnits]:
    """The format of a file, and the columns of its table with most quantities."""
    format_name = UNKNOWN_FORMAT
    columns_of_tables: list[base.NamesAndUnits] = []
    try:
        unpacked = unpack(content)
        format_name = recognised_format(unpacked) or format_name
        if format_name != "pcs":
            _, logged_tables = READERS[format_name].tables(unpacked, _WORD_VOCABULARY)
            columns_of_tables = [
                list(zip(table.names, table.units, strict=True)) for table in logged_tables
            ]
    except Exception:  # noqa: S110 - libraries raise many kinds; `read_log` gives the reason
        pass
    columns_of_best_table = max(
        columns_of_tables, key=lambda names: len(columns_by_quantity(names, VOCABULARY)), default=[]
    )
    return format_name, columns_of_best_table


def _unit_of_column(names_and_units: base.NamesAndUnits) -> dict[str, str]:
    """Name of each column -> its unit; of columns of one name the first counts."""
    unit_of_column: dict[str, str] = {}
    for name, unit in names_and_units:
        if name:
            unit_of_column.setdefault(name, unit)
    return unit_of_column


def _missing_quantities(candidates_by_quantity: Mapping[str, base.NamesAndUnits]) -> list[str]:
    """The required quantities without a certain column."""
    certain_quantities = {
        quantity for quantity, candidates in candidates_by_quantity.items() if len(candidates) == 1
    }
    if _TRACTION_COEFFICIENT in certain_quantities:
        # a table of mu has no force, and no time: its rows are settled readings
        certain_quantities |= {"traction_force", "time"}
    speed_pair = max(
        VOCABULARY.alternative_quantities, key=lambda pair: len(certain_quantities & set(pair))
    )
    required_quantities = (*VOCABULARY.required_quantities, *speed_pair)
    return [quantity for quantity in required_quantities if quantity not in certain_quantities]


def _sniffed_run(
    name_in_file: str,
    rows: UsableRows,
    quantities_without_unit: Set[str],
    find_zero_source: ZeroSourceFinder,
) -> SniffedRun:
    """What columns and header lines of a run show.

    Args:
        name_in_file: Name of the run in its file.
        rows: The rows of the run.
        quantities_without_unit: Quantities whose unit is not known: nothing follows from them.
        find_zero_source: Gives the source of the zero.
    """
    # the readers have added the oil and the rig of their settings
    keys_of_settings = {"oil", "rig"} - rows.interpretation.source_of_key.keys()
    text_of_key = {
        key: text for key, text in rows.text_of_key.items() if key not in keys_of_settings
    }
    log_kind = text_of_key.get("log_kind", "")
    is_settled = log_kind == base.SETTLED_LOG_KIND or (
        _TRACTION_COEFFICIENT in rows.values_of_quantity and "time" not in rows.values_of_quantity
    )
    no_values = np.full(len(rows.row_numbers), np.nan)
    time_s = rows.values_of_quantity.get("time", no_values)
    load = rows.values_of_quantity.get("load", no_values)
    force = rows.values_of_quantity.get("traction_force", no_values)
    ball_speed, disc_speed = _surface_speeds(
        rows.values_of_quantity, rows.unit_of_quantity, no_values
    )
    signals = (time_s, ball_speed, disc_speed, load, force)
    interval_s = float(np.median(np.diff(time_s))) if len(time_s) > 1 else 0.0
    has_clock = interval_s > 0 and "time" not in quantities_without_unit and not is_settled
    key_of_oil = oil_synonym_key(text_of_key) or "oil"
    return SniffedRun(
        name_in_file,
        key_of_oil,
        text_of_key.get(key_of_oil, ""),
        text_of_key.get("rig", ""),
        set_point_lines=_set_point_lines(text_of_key),
        measured_levels=_measured_levels(
            rows, (ball_speed + disc_speed) / 2, quantities_without_unit
        ),
        is_settled=is_settled,
        zero_source=find_zero_source(*signals) if has_clock and np.isfinite(signals).all() else "",
        unit_of_quantity=rows.unit_of_quantity,
        log_kind=log_kind,
        is_too_slow_for_seconds=not is_settled and interval_s > _LONGEST_INTERVAL_S,
    )


def _measured_levels(
    rows: UsableRows, entrainment_speed: FloatArray, quantities_without_unit: Set[str]
) -> dict[str, float]:
    """Key of a set point -> its measured level; NaN where the signal is not held.

    Args:
        rows: The rows of a run.
        entrainment_speed: Entrainment speed, shape (rows,); NaN where it is not known.
        quantities_without_unit: Quantities whose unit is not known.
    """
    no_values = np.full(len(rows.row_numbers), np.nan)
    signal_by_set_point: dict[str, FloatArray] = {}
    if "load" not in quantities_without_unit:
        signal_by_set_point[_SET_POINT_BY_LOAD_UNIT[rows.unit_of_quantity.get("load", "N")]] = (
            rows.values_of_quantity.get("load", no_values)
        )
    if (
        rows.unit_of_quantity.get("ball_speed") != "rpm"
        and not _SPEED_QUANTITIES & quantities_without_unit
    ):
        signal_by_set_point["entrainment_speed_m_s"] = entrainment_speed
    if "inlet_temperature" not in quantities_without_unit:
        signal_by_set_point["inlet_temperature_c"] = rows.values_of_quantity.get(
            "inlet_temperature", no_values
        )
    is_turning = _is_turning(entrainment_speed)
    # readings at standstill are no level of the run
    is_counted = is_turning if is_turning.any() else np.ones(len(rows.row_numbers), dtype=bool)
    return {
        set_point_key: _held_level(set_point_key, signal[is_counted])
        for set_point_key, signal in signal_by_set_point.items()
    }


def _held_level(set_point_key: str, values: FloatArray) -> float:
    """The median, rounded like a set point, where the signal is held at a level; else NaN."""
    readings = values[np.isfinite(values)]
    if set_point_key != "inlet_temperature_c":
        # load and speed have the sign of the rig's direction
        readings = np.abs(readings)
    if len(readings) == 0:
        return np.nan
    low, median, high = np.quantile(readings, (0.1, 0.5, 0.9))
    if set_point_key == "inlet_temperature_c":
        return round(float(median), 1) if high - low <= _LARGEST_LEVEL_SPREAD_C else np.nan
    # a contact without load or speed is at no set point
    is_held = base.is_in_set_point_range(set_point_key, median) and (
        high - low <= _LARGEST_LEVEL_SPREAD * median
    )
    return float(f"{median:.3g}") if is_held else np.nan


def _surface_speeds(
    values_of_quantity: Mapping[str, FloatArray],
    unit_of_quantity: Mapping[str, str],
    no_values: FloatArray,
) -> tuple[FloatArray, FloatArray]:
    """Speeds of ball and disc, shape (rows,); NaN where the log does not give them.

    The radii of spindles are not known. Their speeds are scaled as if the beginning of the run were
    pure rolling.
    """
    if {"ball_speed", "disc_speed"} <= values_of_quantity.keys():
        ball_speed, disc_speed = values_of_quantity["ball_speed"], values_of_quantity["disc_speed"]
        if unit_of_quantity["ball_speed"] == "rpm":
            turning_indices = np.flatnonzero(_is_turning(ball_speed) & _is_turning(disc_speed))
            first_turning_indices = turning_indices[: max(1, len(ball_speed) // 50)]
            if len(first_turning_indices):
                disc_speed = disc_speed * (
                    np.median(ball_speed[first_turning_indices])
                    / np.median(disc_speed[first_turning_indices])
                )
        return ball_speed, disc_speed
    entrainment_speed = values_of_quantity.get("entrainment_speed", no_values)
    half_slip = values_of_quantity.get("slide_roll_ratio", no_values) / 2
    return entrainment_speed * (1 - half_slip), entrainment_speed * (1 + half_slip)


def _is_turning(speed: FloatArray) -> BoolArray:
    """The rows at more than half of the speed of the fastest ones, shape (rows,)."""
    if len(speed) == 0 or not np.isfinite(speed).all():
        return np.zeros(len(speed), dtype=bool)
    return np.abs(speed) > np.quantile(np.abs(speed), 0.9) / 2


# ---------------------------------------------------------------- header lines


def _set_point_lines(text_of_key: Mapping[str, str]) -> dict[str, tuple[str, float]]:
    """Key of a set point -> name and value of the header line that gives it with its unit.

    Of two lines for one set point the first counts.
    """
    line_of_set_point: dict[str, tuple[str, float]] = {}
    for key, text in text_of_key.items():
        bare_key, unit_in_brackets = split_bracketed_unit(key)
        name = bare_key.replace("_", " ")
        last_word = plain_key(name.split(" ")[-1])
        _, unit_of_text = number_and_unit(text)
        for set_point_key, (quantity, unit) in base.QUANTITY_AND_UNIT_OF_SET_POINT.items():
            likely_meaning = meaning_of(name, unit, may_be_set_point=True)
            if key != set_point_key and (
                likely_meaning is None or likely_meaning.quantity != quantity
            ):
                continue
            key_meant, number_text = project_key_and_text(
                key, text, {plain_key(name): set_point_key}
            )
            if key_meant != set_point_key:
                continue
            value = base.parse_set_point(set_point_key, number_text)
            has_unit = (
                key == set_point_key
                or unit_in_brackets
                or unit_of_text
                or UNIT_BY_PLAIN_KEY.get(last_word) == unit
            )
            if value is not None and has_unit:
                line_of_set_point.setdefault(set_point_key, (name, value))
                break
    return line_of_set_point


def measured_set_points(run: SniffedRun) -> dict[str, float]:
    """Key of a set point -> its measured level, without set points that the header gives."""
    keys_in_header = set(run.set_point_lines)
    # the load has one set point, as force or as pressure
    if keys_in_header & base.LOAD_KEYS:
        keys_in_header |= base.LOAD_KEYS
    return {
        set_point_key: level
        for set_point_key, level in run.measured_levels.items()
        if np.isfinite(level) and set_point_key not in keys_in_header
    }


def runs_for_run_sheet(log: SniffedLog) -> Sequence[SniffedRun]:
    """The runs of a log that need a row of the run sheet; one for all where they are alike."""
    if not log.runs:
        return [SniffedRun()]
    first_run = log.runs[0]
    if all(measured_set_points(run) == measured_set_points(first_run) for run in log.runs):
        return [replace(first_run, name_in_file="")]
    return log.runs


# ---------------------------------------------------------------- all logs

_UMLAUTS = str.maketrans({"ä": "ae", "ö": "oe", "ü": "ue", "ß": "ss"})
_FEWEST_RECOGNISED_COLUMNS = 3


def shipped_names(config_folder: str) -> dict[str, str]:
    """Plain name -> name of the rigs or oils that are part of oilfilm.

    Args:
        config_folder: `rigs` or `oils`.
    """
    paths = (CONFIG / config_folder).glob("*.yaml")
    return {plain_key(path.stem): path.stem for path in paths if path.stem != TEMPLATE_NAME}


@dataclass(frozen=True)
class Findings:
    """What was found in all logs together."""

    logs: Sequence[SniffedLog]

    @property
    def runs(self) -> Iterator[SniffedRun]:
        """The runs of all logs."""
        return (run for log in self.logs for run in log.runs)

    @property
    def logs_with_columns(self) -> list[SniffedLog]:
        """The logs whose columns were recognised, at least in part."""
        return [
            log
            for log in self.logs
            if log.runs or len(log.candidates_of_quantity) >= _FEWEST_RECOGNISED_COLUMNS
        ]

    @cached_property
    def column_names_of_quantity(self) -> dict[str, list[str]]:
        """Quantity -> the names that its only candidate has in the logs."""
        names: list[tuple[str, str]] = []
        for log in self.logs_with_columns:
            for quantity, candidates in log.candidates_of_quantity.items():
                if len(candidates) > 1:
                    continue
                name, unit = candidates[0]
                # a unit in brackets is read; without one the name stays as the log writes it
                names.append((quantity, split_bracketed_unit(name)[0] if unit else name))
        return _texts_by_key(names)

    @property
    def names_to_choose_from(self) -> dict[str, list[str]]:
        """Quantities without a column or with several candidates -> the names to choose from."""
        choices_of_quantity: dict[str, dict[str, None]] = {}
        for log in self.logs_with_columns:
            candidates_by_quantity = {
                quantity: [name for name, _ in candidates]
                for quantity, candidates in log.candidates_of_quantity.items()
                if len(candidates) > 1
            }
            unused = [name for name in log.names if _is_unused(name, log)]
            for quantity in {*log.missing_quantities, *candidates_by_quantity}:
                names = candidates_by_quantity.get(quantity, unused)
                choices_of_quantity.setdefault(quantity, {}).update(dict.fromkeys(names))
        return {
            quantity: list(choices_of_quantity[quantity])
            for quantity in sorted(choices_of_quantity)
        }

    def unit_for_campaign_file(self, quantity: str) -> tuple[str, bool]:
        """The unit for the campaign file, and whether it is unknown.

        The unit is empty where the logs give it, or where it is unknown.
        """
        units = {
            log.unit_in_name_of_quantity[quantity]
            for log in self.logs_with_columns
            if quantity in log.unit_in_name_of_quantity
        }
        if not units:
            return "", False
        if len(units) > 1:
            return "", True
        unit = units.pop()
        if (
            not unit
            and quantity == "time"
            and not any(run.is_too_slow_for_seconds for run in self.runs)
        ):
            unit = "s"
        return unit, unit == ""

    @property
    def header_names_of_key(self) -> dict[str, list[str]]:
        """Key of the project -> other names that its header line has in the logs."""
        names = [("oil", run.oil_key.replace("_", " ")) for run in self.runs if run.oil_key]
        for run in self.runs:
            names += [(key, name) for key, (name, _) in run.set_point_lines.items()]
        return _texts_by_key((key, name) for key, name in names if plain_key(name) != key)

    @cached_property
    def labels_of_oil(self) -> dict[str, list[str]]:
        """Id of each oil -> its names in the logs; one id where no log names an oil."""
        labels = dict.fromkeys(run.oil_name for run in self.runs if run.oil_name)
        if not labels:
            return {"my-oil": []}
        labels_by_name = _texts_by_key((_name_of_oil(label), label) for label in labels)
        name_count_of_id = Counter(
            _new_oil_id(labels_of_name[0]) for labels_of_name in labels_by_name.values()
        )
        labels_by_id: dict[str, list[str]] = {}
        for number, (name, labels_of_name) in enumerate(labels_by_name.items(), start=1):
            oil_id = _new_oil_id(labels_of_name[0])
            if name_count_of_id[oil_id] > 1 and name != oil_id:
                # as 4102 fresh and 4102 aged: nobody has said that these are one oil
                oil_id = _slug(labels_of_name[0])
            if not oil_id or oil_id in labels_by_id:
                oil_id = f"{oil_id or 'oil'}-{number}"
            labels_by_id[oil_id] = labels_of_name
        return labels_by_id

    @property
    def lacks_oil_in_some_logs(self) -> bool:
        """Whether only some logs name an oil, so that the others need it in the run sheet."""
        return len(self.labels_of_oil) > 1 and any(not run.oil_name for run in self.runs)

    @cached_property
    def rig_names(self) -> list[str]:
        """Names of the rigs: of the logs, else of a PCS rig for its exports, else `my-rig`."""
        names_of_shipped = shipped_names("rigs")
        names = [
            names_of_shipped.get(plain_key(run.rig_name), _slug(run.rig_name))
            for run in self.runs
            if run.rig_name
        ]
        pcs_logs = [log for log in self.logs if log.format_name == "pcs"]
        if pcs_logs and not names:
            all_etm = all("etm" in log.file.lower() for log in pcs_logs)
            return ["pcs-etm" if all_etm else "pcs-rig"]
        return list(dict.fromkeys(name for name in names if name)) or ["my-rig"]

    @property
    def needs_radii(self) -> bool:
        """Whether speeds are those of spindles, so that the radii of the tracks are needed."""
        return any(run.unit_of_quantity.get("ball_speed") == "rpm" for run in self.runs)

    @property
    def needs_contact(self) -> bool:
        """Whether geometry and materials are needed: for loads, or for pressures of several loads.

        A pressure that every header states needs none.
        """
        if any(run.unit_of_quantity.get("load") == "GPa" for run in self.runs):
            return True
        loads = [run.measured_levels.get("load_n", 0.0) for run in self.runs]
        loads = [load for load in loads if load > 0]
        has_several_loads = bool(loads) and max(loads) > (1 + _LARGEST_LEVEL_SPREAD) * min(loads)
        is_stated_everywhere = all(
            "max_hertz_pressure_gpa" in run.set_point_lines for run in self.runs
        )
        return has_several_loads and not is_stated_everywhere

    @cached_property
    def run_count_of_zero_source(self) -> Counter[str | None]:
        """Source of the zero -> number of runs for which it is suitable; None: no source is."""
        return Counter(run.zero_source for run in self.runs if run.zero_source != "")

    @property
    def needs_slip_definition(self) -> bool:
        """Whether the slip of a run comes, or may come, from a column of the slide-roll ratio."""
        if "slide_roll_ratio" in self.names_to_choose_from:
            return True
        return any(
            "slide_roll_ratio" in run.unit_of_quantity and "ball_speed" not in run.unit_of_quantity
            for run in self.runs
        )

    @property
    def has_repeats(self) -> bool:
        """Whether two runs of one oil have the same set points."""
        conditions = []
        for run in self.runs:
            levels = measured_set_points(run)
            levels |= {set_point: value for set_point, (_, value) in run.set_point_lines.items()}
            has_all_levels = (
                levels.keys() >= {"entrainment_speed_m_s", "inlet_temperature_c"}
                and levels.keys() & base.LOAD_KEYS
            )
            # runs with an incomplete condition cannot be compared
            if has_all_levels:
                conditions.append((run.oil_name, *sorted(levels.items())))
        return len(set(conditions)) < len(conditions)

    @property
    def uses_decimal_comma(self) -> bool:
        """Whether the laboratory writes numbers with a comma."""
        return any(log.dialect.decimal_mark == "comma" for log in self.logs)


def _texts_by_key(pairs: Iterable[tuple[str, str]]) -> dict[str, list[str]]:
    """Key -> its different texts, in the order in which they come."""
    texts_of_key: dict[str, list[str]] = {}
    for key, text in dict.fromkeys(pairs):
        texts_of_key.setdefault(key, []).append(text)
    return texts_of_key


def _is_unused(name: str, log: SniffedLog) -> bool:
    """Whether a column of a log has no likely meaning."""
    candidate_names = {
        candidate
        for candidates in log.candidates_of_quantity.values()
        for candidate, _ in candidates
    }
    return name not in candidate_names and VOCABULARY.quantity_and_unit(name) is None


def _name_of_oil(label: str) -> str:
    """A label without words for an oil: `Oil 4102` and `4102` are one name."""
    words = plain_key(label).split("_")
    return " ".join(word for word in words if word not in WORDS_FOR_OIL) or " ".join(words)


def _new_oil_id(label: str) -> str:
    """The shipped oil that is a word of a label, else the label as an id."""
    words = re.findall(r"\w+", plain_key(label).replace("_", " "))
    id_of_shipped_name = shipped_names("oils")
    for word in words:
        if word in id_of_shipped_name:
            return id_of_shipped_name[word]
    return _slug(label)


def _slug(label: str) -> str:
    """A name as an id: ASCII letters, digits and '-'; empty where it has others."""
    decomposed = unicodedata.normalize("NFKD", label.casefold().translate(_UMLAUTS))
    base_letters = "".join(letter for letter in decomposed if not unicodedata.combining(letter))
    if not base_letters.isascii():
        return ""
    return re.sub(r"[^a-z0-9]+", "-", base_letters).strip("-")[:60]
