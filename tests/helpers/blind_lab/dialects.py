"""How the laboratory's loggers write: languages, units, delimiters, decimal marks, encodings."""

import gzip
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import yaml

from blind_lab.bench import Recording
from blind_lab.truth import Machine

_LANGUAGES = yaml.safe_load(Path(__file__).with_name("languages.yaml").read_text("utf-8"))
# By language: names of the signals, encodings that can write them, and keys of the header.
NAMES = {language: texts["signals"] for language, texts in _LANGUAGES.items()}
ENCODINGS = {language: texts["encodings"] for language, texts in _LANGUAGES.items()}
HEADER = {language: texts["header"] for language, texts in _LANGUAGES.items()}

# By unit: the number in this unit of one SI unit; of spindles that of 1 m/s on a track of 1 m.
_SPEEDS = {"rpm": 30 / np.pi, "rad/s": 1.0, "m/s": 1.0, "mm/s": 1e3}
_PER_SI = {
    "time": {"s": 1.0, "ms": 1e3, "min": 1 / 60},
    "load": {"N": 1.0, "kgf": 1 / 9.80665, "lbf": 1 / 4.4482216152605, "kN": 1e-3},
    "force": {"N": 1.0, "mN": 1e3, "gf": 1e3 / 9.80665, "kgf": 1 / 9.80665},
}
# By unit: the number in this unit, from degrees Celsius.
_TEMPERATURES = {
    "°C": lambda celsius: celsius,
    "K": lambda celsius: celsius + 273.15,
    "°F": lambda celsius: 1.8 * celsius + 32,
}


@dataclass(frozen=True)
class Dialect:
    """How one logger writes.

    Attributes:
        language: One of `NAMES`.
        units: Unit of each signal.
        encoding: Encoding of the text.
        delimiter: Between cells.
        decimal: Decimal mark.
        line_end: End of each line.
        mark: Before each header line.
        separator: After each header key.
        units_in_row: Whether the units are in a row below the names, not beside them.
        packed: Whether the file is packed by gzip.
    """

    language: str
    units: dict[str, str]
    encoding: str
    delimiter: str
    decimal: str
    line_end: str
    mark: str
    separator: str
    units_in_row: bool
    packed: bool

    def with_units(self, **units: str) -> "Dialect":
        """The dialect with other units of some signals."""
        return replace(self, units={**self.units, **units})


def draw_dialect(random: np.random.Generator) -> Dialect:
    """A dialect whose text can be written in its encoding and read back by a person."""
    language = str(random.choice(list(NAMES)))
    delimiter = str(random.choice([",", ";", "\t", "|"]))
    decimal = "." if delimiter == "," else str(random.choice([".", ","]))
    speed = str(random.choice(list(_SPEEDS)))
    return Dialect(
        language,
        units={
            **{name: str(random.choice(list(units))) for name, units in _PER_SI.items()},
            "ball": speed,
            "disc": speed,
            "celsius": str(random.choice(list(_TEMPERATURES))),
        },
        encoding=str(random.choice(ENCODINGS[language])),
        delimiter=delimiter,
        decimal=decimal,
        line_end=str(random.choice(["\n", "\r\n"])),
        mark=str(random.choice(["# ", ""])),
        separator=str(random.choice([": ", " = "])),
        units_in_row=bool(random.random() < 0.4),
        packed=bool(random.random() < 0.15),
    )


def header_of(recording: Recording, dialect: Dialect) -> dict[str, str]:
    """Header lines of a run."""
    condition = recording.condition
    oil = next(name for name in recording.oil if _can_write(name, dialect))
    values = (oil, condition.pressure, condition.speed, condition.celsius)
    return dict(zip(HEADER[dialect.language], map(str, values), strict=True))


def _can_write(text: str, dialect: Dialect) -> bool:
    try:
        text.encode(dialect.encoding)
    except UnicodeEncodeError:
        return False
    return True


def columns_of(
    recording: Recording, dialect: Dialect, machine: Machine
) -> dict[str, tuple[str, np.ndarray]]:
    """Signal -> unit and numbers as the logger writes them."""
    columns = {}
    tracks = {"ball": machine.ball_track, "disc": machine.disc_track}
    for name, values in recording.signals.items():
        unit = dialect.units[name]
        if name == "celsius":
            columns[name] = unit, _TEMPERATURES[unit](values)
        elif name in tracks:
            track = tracks[name] if unit in ("rpm", "rad/s") else 1.0
            columns[name] = unit, values * (_SPEEDS[unit] / track)
        else:
            columns[name] = unit, values * _PER_SI[name][unit]
    return columns


def log_bytes(
    header: dict[str, str], columns: dict[str, tuple[str, np.ndarray]], dialect: Dialect
) -> bytes:
    """A log as the bytes of a file."""
    names = NAMES[dialect.language]
    titles = [
        names[name] if dialect.units_in_row else f"{names[name]} [{unit}]"
        for name, (unit, _) in columns.items()
    ]
    lines = [f"{dialect.mark}{key}{dialect.separator}{value}" for key, value in header.items()]
    lines.append(dialect.delimiter.join(titles))
    if dialect.units_in_row:
        lines.append(dialect.delimiter.join(f"[{unit}]" for unit, _ in columns.values()))
    numbers = np.column_stack([values for _, values in columns.values()])
    cells = np.char.mod("%.8g", numbers)
    if dialect.decimal == "," and cells.size:
        cells = np.char.replace(cells, ".", ",")
    lines += [dialect.delimiter.join(row) for row in cells]
    text = dialect.line_end.join([*lines, ""])
    content = text.encode(dialect.encoding)
    return gzip.compress(content, mtime=0) if dialect.packed else content


def suffix(dialect: Dialect) -> str:
    """Ending of the file's name."""
    return ".txt.gz" if dialect.packed else ".txt"
