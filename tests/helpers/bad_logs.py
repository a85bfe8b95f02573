"""A corpus of bad raw files, one failure each, made from one good run by the smallest change.

`BAD_LOGS` is the table: a name, the bytes, the rule that must act, words that its sentence must
hold, and whether points of the run are used all the same.
"""

import gzip
import io
import zipfile
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pyarrow as arrow
from nptdms import RootObject

import formats
from campaigns import ROOT, printed, rig_contact
from oilfilm.physics.contact import load_for_max_hertz_pressure
from oilfilm.settings.resolve import resolve
from oilfilm.settings.resolved import Settings
from oilfilm.traction.laws.deng2026 import traction_coefficient

Columns = dict[str, np.ndarray]

CONFIG = resolve(ROOT / "config", {"campaign": "demo"})
PCS_CONFIG = resolve(ROOT / "config", {"campaign": "etm-slim"})
RATE_HZ = 20
PHASES = (0.0, 0.05, 0.10, 0.20, 0.0)
KEYS = {
    "oil": "4102",
    "max_hertz_pressure_gpa": 1.25,
    "entrainment_speed_m_s": 30,
    "inlet_temperature_c": 70,
}
UNITS = {
    "time": "s",
    "load": "N",
    "traction_force": "N",
    "ball_speed": "rpm",
    "disc_speed": "rpm",
    "inlet_temperature": "degC",
}


def good(
    phases: tuple[float, ...] = PHASES, seconds: float = 4.0, speed_m_s: float = 30.0
) -> Columns:
    """A run that every gate accepts: slip in steps, with a little noise on every sensor."""
    random = np.random.default_rng(7)
    slip = np.repeat(phases, round(seconds * RATE_HZ))
    rig, contact = CONFIG.rigs["ball-on-disc-20mm"], rig_contact()
    load = load_for_max_hertz_pressure(1.25e9, contact.radius_m, contact.reduced_modulus_pa)
    mu = traction_coefficient(printed()["4102"], 1.25, 30.0, 70.0, slip)

    def noise(size: float) -> np.ndarray:
        return size * random.standard_normal(len(slip))

    per_rpm = 2 * np.pi / 60
    return {
        "time": np.arange(len(slip)) / RATE_HZ,
        "load": load + noise(0.1),
        "traction_force": mu * load + noise(0.02),
        "ball_speed": (speed_m_s * (1 - slip / 2) + noise(0.005))
        / (per_rpm * rig.ball_track_radius_m),
        "disc_speed": (speed_m_s * (1 + slip / 2) + noise(0.005))
        / (per_rpm * rig.disc_track_radius_m),
        "inlet_temperature": 70 + noise(0.05),
    }


def changed(name: str, change: Callable[[np.ndarray], np.ndarray]) -> Columns:
    """The good run with one column changed."""
    values = good()
    return {**values, name: change(values[name].copy())}


def csv(values: Columns | None = None, units: Mapping[str, str] = UNITS, **keys: Any) -> bytes:
    """The run as text; a header key of None is left out."""
    given = {name: value for name, value in {**KEYS, **keys}.items() if value is not None}
    rounded = {name: np.round(column, 4) for name, column in (values or good()).items()}
    return formats.csv(rounded, units, given)


UNITS_TWICE = {**UNITS, "entrainment_speed": "mm/s", "slide_roll_ratio": "%"}


def said_twice(speed: float = 30e3, per_slip: float = 100.0) -> Columns:
    """The good run with the set points of speed and slip beside the speeds of ball and disc."""
    slip = np.repeat(PHASES, round(4.0 * RATE_HZ))
    return {
        **good(),
        "entrainment_speed": np.full_like(slip, speed),
        "slide_roll_ratio": per_slip * slip,
    }


GOOD = csv()
HEAD, ROWS = GOOD[: GOOD.index(b"time [s]")], GOOD[GOOD.index(b"time [s]") :]
NAMES = ROWS.splitlines()[0]


def row_changed(place: int, change: Callable[[bytes], bytes]) -> bytes:
    """The text with one line of the table changed; row 1 stands right below the names."""
    lines = ROWS.splitlines()
    lines[place] = change(lines[place])
    return HEAD + b"\n".join(lines) + b"\n"


def cell(place: int, text: bytes) -> Callable[[bytes], bytes]:
    """A change of one cell of a line."""

    def change(line: bytes) -> bytes:
        cells = line.split(b",")
        cells[place] = text
        return b",".join(cells)

    return change


def binary(writer: Callable[..., bytes], values: Columns | None = None, **keys: Any) -> bytes:
    """The run in a format other than text."""
    return writer(values or good(), UNITS, {**KEYS, **keys})


def zipped() -> bytes:
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        archive.writestr("log.csv", GOOD)
    return buffer.getvalue()


def damaged(content: bytes, place: int) -> bytes:
    """Sixteen bytes of zeros written over a file."""
    return content[:place] + bytes(16) + content[place + 16 :]


def tdms_without_channels() -> bytes:
    return formats.tdms_file([RootObject(KEYS)])


def tdms_of_unequal_channels(colour: str) -> bytes:
    values, units, name = good(), dict(UNITS), f"load [{colour}N]"
    values[name], units[name] = values.pop("load")[:-30], "N"
    return formats.tdms_file([RootObject(KEYS), *formats.tdms_channels("run", values, units)])


def tdms_of_text() -> bytes:
    values = {**good(), "load": np.array(["80.1"] * len(good()["load"]))}
    return formats.tdms_file([RootObject(KEYS), *formats.tdms_channels("run", values, UNITS)])


PCS_TABLE = (
    "SRR (%)\tStep Time (s)\tLube RTD Temp (degC)\tBall Load (N)\tBall Speed 1\tBall Speed 2\t"
    "Disc Speed 1\tDisc Speed 2\tRolling Speed (mm/s)\tSliding Speed (mm/s)\tSRR (%)\tTF1 (N)\t"
    "TF2 (N)\tTraction Force (N)\tTraction Coeff (-)"
)
PCS_ROW = (
    "20.000\t6\t40.0\t1000.000\t22.50\t27.50\t27.50\t22.50\t25.00\t5.00\t20.000\t"
    "50.0000\t-50.0000\t50.0000\t0.0500"
)


def pcs(*rows: str, kind: str = "Traction", table: str = PCS_TABLE) -> bytes:
    head = f"Step 1 started at 06/05/2019 19:48:30\nStep type\t{kind}\n{table}\n"
    return (head + "\n".join(rows or [PCS_ROW] * 3) + "\n\nAll steps completed\n").encode()


@dataclass(frozen=True)
class Bad:
    """A bad file and the verdict it must get."""

    name: str
    content: bytes
    rule: str
    words: str
    used: bool = False
    config: Settings = CONFIG


def _bad_logs() -> Iterator[Bad]:
    # --- no log at all
    yield Bad("empty", b"", "unknown_format", "the file is empty")
    yield Bad("binary_junk", bytes(range(255, 0, -1)) * 20, "unknown_format", "begins '\\\\xff")
    yield Bad("zip", zipped(), "unknown_format", "begins 'PK")
    yield Bad(
        "html_error_page",
        b"<!DOCTYPE html>\n<html><body><h1>502 Bad Gateway</h1></body></html>\n",
        "unknown_format",
        "DOCTYPE html",
    )
    yield Bad("pdf", b"%PDF-1.7\n%\xe2\xe3\xcf\xd3\n1 0 obj\n", "unknown_format", "%PDF-1.7")
    yield Bad("only_comments", HEAD, "columns", "no line names columns")
    yield Bad("other_table", b"name,age,town,zip\nann,31,ulm,1\n", "columns", "'name,age,town,zip'")
    # --- compression
    yield Bad("gz_cut", gzip.compress(GOOD)[:-400], "damaged_archive", "cannot be unpacked")
    zst = arrow.compress(GOOD, "zstd", asbytes=True)
    yield Bad("zst_damaged", damaged(zst, 2000), "damaged_archive", "cannot be unpacked")
    yield Bad("gz_in_gz", gzip.compress(gzip.compress(GOOD)), "unknown_format", "\\x1f")
    yield Bad("gz_of_zeros", gzip.compress(bytes(1 << 24), 9), "unknown_format", "\\x00")
    # --- header
    yield Bad("no_oil", csv(oil=None), "header", "no line `# oil")
    yield Bad("unknown_rig", csv(rig="mars"), "unknown_rig", "rig 'mars'")
    yield Bad("nan_set_point", csv(max_hertz_pressure_gpa="nan"), "header", "gpa: 'nan'")
    yield Bad("negative_set_point", csv(entrainment_speed_m_s=-30), "header", "m_s: '-30'")
    yield Bad("python_number", csv(max_hertz_pressure_gpa="1_25"), "header", "gpa: '1_25'")
    yield Bad("infinite_set_point", csv(load_n="inf"), "header", "load_n: 'inf'")
    yield Bad("set_point_of_zero", csv(load_n=0), "header", "load_n: '0'")
    yield Bad("two_oils", csv(oil="4050\n# oil: 4102"), "unknown_oil", "oil '4050 / 4102'")
    yield Bad("pressure_in_pa", csv(max_hertz_pressure_gpa=1.25e9), "header", "below 1000")
    yield Bad("set_point_in_words", csv(inlet_temperature_c="warm"), "header", "c: 'warm'")
    yield Bad("impossible_cold", csv(inlet_temperature_c=-300), "header", "above -273.15")
    # --- columns and units
    without = {name: column for name, column in good().items() if name != "inlet_temperature"}
    yield Bad("missing_column", csv(without), "columns", "lacks the columns inlet_temperature")
    yield Bad(
        "doubled_column",
        GOOD.replace(b"disc_speed [rpm]", b"ball_speed [rpm]"),
        "columns",
        "repeats the column 'ball_speed'",
    )
    yield Bad("unknown_unit", csv(units={**UNITS, "load": "stone2"}), "columns", "'stone2' is none")
    yield Bad("unit_of_mass", csv(units={**UNITS, "load": "kg"}), "columns", "'kg' is none of N")
    endless = GOOD.replace(b"load [N]", b"load [10**10**10]")
    yield Bad("unit_to_compute_for_ever", endless, "columns", "'10**10**10' is none of N")
    yield Bad("endless_brackets", HEAD + b"(" * 60_000 + b"\n", "columns", "no line names columns")
    yield Bad("no_unit", GOOD.replace(b"load [N]", b"load"), "columns", "'load' has no unit")
    yield Bad("no_names", GOOD.replace(NAMES + b"\n", b""), "columns", "no line names columns")
    # --- rows
    yield Bad("cut_in_last_cell", GOOD[:-3], "unterminated_row", "no line end", used=True)
    rows = {
        "word_for_number": (cell(1, b"oops"), "oops"),
        "empty_cell": (cell(1, b""), "cells are missing"),
        "nan_reading": (cell(1, b"nan"), "nan"),
        "infinite_reading": (cell(2, b"-inf"), "-inf"),
        "huge_reading": (cell(3, b"1e300"), "1e300"),
        "huge_field": (cell(1, b"9" * 3_000_000), "99999"),
        "nul_bytes": (cell(1, b"\0\0\0"), "rows 50 to 50"),
        "quotes": (cell(1, b'8"0"'), "rows 50 to 50"),
        "mixed_delimiters": (lambda line: line.replace(b",", b";"), "rows 50 to 50"),
        "decimal_comma": (lambda line: line.replace(b".", b","), "too many"),
        "invalid_utf8": (cell(1, b"80\xff\xfe\xff"), "rows 50 to 50"),
        "superfluous_cell": (lambda line: line + b",1", "too many"),
        "formula": (cell(1, b"=SUM(A1:A9)"), "=SUM"),
        "header_repeated": (lambda _: NAMES, "time [s]"),
    }
    for name, (change, words) in rows.items():
        yield Bad(name, row_changed(50, change), "unreadable_row", words, used=True)
    yield Bad("no_readable_row", HEAD + NAMES + b"\na,b,c,d,e,f\n", "no_rows", "no readable row")
    # --- what the sensors and the rig did
    yield Bad("time_of_ages", row_changed(50, cell(0, b"5e12")), "unreadable_row", "time_s", True)
    as_pressure = changed("load", lambda load: np.full_like(load, 1.25))
    as_pressure["load"][[50, 51]] = 1e6, -1e6  # GPa: the load would be 4e19 N
    yield Bad(
        "absurd_pressure",
        csv(as_pressure, units={**UNITS, "load": "GPa"}),
        "unreadable_row",
        "rows 51 to 52: load_n comes out as 1e+12 or more",
        used=True,
    )
    yield Bad("time_in_wrong_unit", csv(units={**UNITS, "time": "ms"}), "zero_missing", "")
    yield Bad(
        "load_in_kgf",
        csv(changed("load", lambda load: load / 9.80665)),
        "load_off_nominal",
        "may be in kgf",
    )
    yield Bad(
        "slip_by_another_definition",
        csv(said_twice(per_slip=50), UNITS_TWICE),
        "columns_disagree",
        "slide_roll_ratio is 0.1 in row",
    )
    yield Bad(
        "speed_as_a_sum",
        csv(said_twice(speed=60e3), UNITS_TWICE),
        "columns_disagree",
        "entrainment_speed is 60 in row",
    )
    yield Bad("speed_zero", csv(good(speed_m_s=0.0)), "zero_missing", "slide-roll ratio of")
    yield Bad("wrong_speed", csv(good(speed_m_s=25.0)), "speed_off_nominal", "speed")
    yield Bad("cold", csv(inlet_temperature_c=100), "temperature_off_nominal", "temperature")
    yield Bad(
        "short_plateaus",
        csv(good((0.0, 0.0, 0.0, 0.05, 0.1, 0.2, 0.0, 0.0, 0.0), 1.0)),
        "not_steady",
        "within the plateaus",
    )
    # --- other formats
    tdms = binary(formats.tdms)
    yield Bad(
        "tdms_damaged", damaged(tdms, tdms.rindex(b"TDSm")), "damaged_file", "begins like tdms"
    )
    yield Bad("tdms_without_channels", tdms_without_channels(), "no_rows", "holds no row")
    yield Bad("tdms_of_text", tdms_of_text(), "columns", "'load' does not hold numbers")
    yield Bad("tdms_index", b"TDSh" + tdms[4:400], "unknown_format", "begins 'TDSh")
    lvm = binary(formats.lvm)
    coloured = tdms_of_unequal_channels("\x1b[31m")
    yield Bad("tdms_steers_a_terminal", coloured, "unequal_channels", "[?[31mN] 370", True)
    yield Bad("lvm_without_end_of_header", lvm[: lvm.index(b"Channels")], "columns", "does not end")
    yield Bad(
        "lvm_without_names",
        lvm.replace(b"X_Value", b"Values"),
        "columns",
        "no line `X_Value`",
    )
    yield Bad(
        "lvm_of_distance",
        lvm.replace(b"Time\tTime\tTime\tTime\tTime", b"Length"),
        "columns",
        "lacks the columns time",
    )
    parquet = binary(formats.as_parquet)
    yield Bad("parquet_damaged", damaged(parquet, 300), "damaged_file", "begins like parquet")
    yield Bad("parquet_encrypted", b"PARE" + parquet[4:], "damaged_file", "encrypted")
    yield from _bad_pcs()


def _bad_pcs() -> Iterator[Bad]:
    def bad(name: str, content: bytes, rule: str, words: str, used: bool = False) -> Bad:
        return Bad(name, content, rule, words, used, PCS_CONFIG)

    lacking = PCS_TABLE.replace("Ball Load (N)", "Ball Weight (N)")
    yield bad("pcs_missing_column", pcs(table=lacking), "columns", "lacks the columns Ball Load")
    yield bad("pcs_no_sweep", pcs(kind="BodTimed"), "not_a_sweep", "'BodTimed'")
    endless = pcs().replace(b"Step 1 ", b"Step " + 5000 * b"1" + b" ")
    yield bad("pcs_endless_number", b"PCS Test Data File\n" + endless, "no_rows", "holds no row")
    python = PCS_ROW.replace("40.0", "4_0.0")
    yield bad("pcs_python_number", pcs(PCS_ROW, python), "unreadable_row", "rows 2 to 2", True)
    unreadable = PCS_ROW.replace("1000.000", "----")
    yield bad("pcs_dashes", pcs(PCS_ROW, unreadable), "unreadable_row", "rows 2 to 2", True)
    yield bad("pcs_title_alone", b"PCS Test Data File\n", "no_rows", "holds no row of data")
    yield Bad("pcs_of_several_oils", pcs(), "unknown_oil", "does not name its oil")


BAD_LOGS = tuple(_bad_logs())
