"""A corpus of bad raw files, one failure each, made from one good run by the smallest change.

`BAD_LOGS` is the table: by rule, the name of each file, its bytes and a part of the sentence.
"""

import gzip
import io
import zipfile
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import pyarrow as arrow
from nptdms import RootObject

import formats
from campaigns import LABORATORY, ROOT, printed, rig_contact
from oilfilm.physics.contact import load_for_max_hertz_pressure
from oilfilm.settings.resolve import resolve
from oilfilm.traction.laws.deng2026 import traction_coefficient

Columns = dict[str, np.ndarray]

CONFIG = resolve(LABORATORY, {})
# An export of a PCS rig has no set points.
SET_POINTS = {"entrainment_speed_m_s": 0.025, "inlet_temperature_c": 40}
PCS_CONFIG = resolve(ROOT / "config", {"campaign": "etm-slim"}).with_changes(
    {"campaign": {"set_points": SET_POINTS}}
)
RATE_HZ = 20
# Slide-roll ratio of each phase of the good run.
PHASES = (0.0, 0.05, 0.10, 0.20, 0.0)
KEYS = {**formats.KEYS, "inlet_temperature_c": 70}
UNITS = dict(zip(formats.NAMES, "s N N rpm rpm degC".split(), strict=True))


def good(phases: tuple[float, ...] = PHASES, seconds: float = 4.0) -> Columns:
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
        "ball_speed": (30.0 * (1 - slip / 2) + noise(0.005)) / (per_rpm * rig.ball_track_radius_m),
        "disc_speed": (30.0 * (1 + slip / 2) + noise(0.005)) / (per_rpm * rig.disc_track_radius_m),
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


def logged_twice(speed: float = 30e3, per_slip: float = 100.0) -> Columns:
    """The good run with the set points of speed and slip beside the speeds of ball and disc.

    Args:
        speed: Entrainment speed in mm/s, which is 30e3 by ball and disc.
        per_slip: Logged slide-roll ratio over the true one; 100 for per cent.
    """
    slip = np.repeat(PHASES, round(4.0 * RATE_HZ))
    speeds = {"entrainment_speed": np.full_like(slip, speed)}
    return {**good(), **speeds, "slide_roll_ratio": per_slip * slip}


def both_ways_positive() -> bytes:
    """The force of either direction of the slip written without its sign."""
    force = good()["traction_force"]
    both = {"traction_force_1": force, "traction_force_2": force}
    return csv({**good(), **both}, {**UNITS, **dict.fromkeys(both, "N")})


GOOD = csv()
HEAD, ROWS = GOOD[: GOOD.index(b"time [s]")], GOOD[GOOD.index(b"time [s]") :]
NAMES = ROWS.splitlines()[0]


def row_changed(change: Callable[[bytes], bytes]) -> bytes:
    """The text with row 50 changed; row 1 is right below the names."""
    lines = ROWS.splitlines()
    lines[50] = change(lines[50])
    return HEAD + b"\n".join(lines) + b"\n"


def cell_changed(column: int, text: bytes) -> bytes:
    """The text with one cell of row 50 changed."""

    def change(line: bytes) -> bytes:
        cells = line.split(b",")
        cells[column] = text
        return b",".join(cells)

    return row_changed(change)


def half_german() -> bytes:
    """The first half of the rows with decimal commas."""
    lines = ROWS.replace(b",", b";").splitlines(keepends=True)
    half = len(lines) // 2
    rows = (line.replace(b".", b",") for line in lines[1:half])
    return b"".join([b"# oil: 4102\n", lines[0], *rows, *lines[half:]])


def zipped() -> bytes:
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        archive.writestr("log.csv", GOOD)
    return buffer.getvalue()


def damaged(content: bytes, start: int) -> bytes:
    """Sixteen bytes of zeros written over a file."""
    return content[:start] + bytes(16) + content[start + 16 :]


def tdms_of_text() -> bytes:
    values = {**good(), "load": np.array(["80.1"] * len(good()["load"]))}
    return formats.tdms(values, UNITS, KEYS)


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


def as_pressure() -> bytes:
    """The load logged as pressure; in two rows, of 1e6 GPa, it would be 4e19 N."""
    values = changed("load", lambda load: np.full_like(load, 1.25))
    values["load"][[50, 51]] = 1e6, -1e6
    return csv(values, {**UNITS, "load": "GPa"})


TDMS, LVM, PARQUET = (
    write(good(), UNITS, KEYS) for write in (formats.tdms, formats.lvm, formats.as_parquet)
)
HTML = b"<!DOCTYPE html>\n<html><body><h1>502 Bad Gateway</h1></body></html>\n"
ZST = arrow.compress(GOOD, "zstd", asbytes=True)
HALVED_SLIP, DOUBLED_SPEED = logged_twice(per_slip=50), logged_twice(speed=60e3)
PCS_LACKING = pcs(table=PCS_TABLE.replace("Ball Load (N)", "Ball Weight (N)"))
ENDLESS_STEP = pcs().replace(b"Step 1 ", b"Step " + 5000 * b"1" + b" ")

BAD_LOGS = {
    "unknown_format": {
        "empty": (b"", "the file is empty"),
        "binary_junk": (bytes(range(255, 0, -1)) * 20, "first bytes are ff fe fd"),
        "zip": (zipped(), "a zip archive"),
        "gz_in_gz": (gzip.compress(gzip.compress(GOOD)), "packed twice"),
        "gz_of_zeros": (gzip.compress(bytes(1 << 24), 9), "first bytes are 00 00"),
        "tdms_index": (b"TDSh" + TDMS[4:400], "index of a tdms log"),
    },
    "damaged_archive": {
        "gz_cut": (gzip.compress(GOOD)[:-400], "cannot be unpacked"),
        "zst_damaged": (damaged(ZST, 2000), "cannot be unpacked"),
    },
    "damaged_file": {
        "tdms_damaged": (damaged(TDMS, TDMS.rindex(b"TDSm")), "begins like tdms"),
        "parquet_damaged": (damaged(PARQUET, 300), "begins like parquet"),
        "parquet_encrypted": (b"PARE" + PARQUET[4:-4] + b"PARE", "encrypted"),
    },
    "header": {
        "nan_set_point": (csv(max_hertz_pressure_gpa="nan"), "gpa: 'nan'"),
        "python_number": (csv(max_hertz_pressure_gpa="1_25"), "gpa: '1_25'"),
        "pressure_in_pa": (csv(max_hertz_pressure_gpa=1.25e9), "below 10 (in GPa"),
        "set_point_in_words": (csv(inlet_temperature_c="warm"), "c: 'warm'"),
        "several_oils_in_pcs": (pcs(), "no line `# oil: ...`"),
    },
    "unknown_rig": {"unknown_rig": (csv(rig="mars"), "rig 'mars'")},
    "unknown_oil": {"two_oils": (csv(oil="4050\n# oil: 4102"), "oil '4050 / 4102'")},
    "columns": {
        "only_comments": (HEAD, "no line names columns"),
        "html_error_page": (HTML, "its first line is '<!DOCTYPE html>'"),
        "unit_to_compute_for_ever": (GOOD.replace(b"[N]", b"[10**10**10]"), "'10**10**10' is none"),
        "endless_brackets": (HEAD + b"(" * 60_000 + b"\n", "no line names columns"),
        "no_names": (GOOD.replace(NAMES + b"\n", b""), "no line names columns"),
        "tdms_of_text": (tdms_of_text(), "'load' does not hold numbers"),
        "lvm_without_end_of_header": (LVM[: LVM.index(b"Channels")], "does not end"),
        "lvm_without_names": (LVM.replace(b"X_Value", b"Values"), "no line `X_Value`"),
        "lvm_of_distance": (LVM.replace(5 * b"\tTime", b"\tLength"), "lacks the columns time"),
        "pcs_missing_column": (PCS_LACKING, "the columns Ball Load"),
    },
    "no_rows": {
        "no_readable_row": (HEAD + NAMES + b"\na,b,c,d,e,f\n", "no readable row"),
        "tdms_without_channels": (formats.tdms_file([RootObject(KEYS)]), "holds no row"),
        "pcs_title_alone": (b"PCS Test Data File\n", "holds no row of data"),
    },
    "truncated": {"tail_of_zeros": (GOOD + bytes(4096), "4096 zero bytes")},
    "decimal_marks": {"half_german": (half_german(), "most other rows have a decimal comma")},
    "unterminated_row": {"cut_in_last_cell": (GOOD[:-3], "no line end")},
    "unreadable_row": {
        "word_for_number": (cell_changed(1, b"oops"), "oops"),
        "huge_field": (cell_changed(1, b"9" * 3_000_000), "99999"),
        "nul_bytes": (cell_changed(1, b"\0\0\0"), "rows 50 to 50"),
        "quotes": (cell_changed(1, b'8"0"'), "rows 50 to 50"),
        "mixed_delimiters": (row_changed(lambda line: line.replace(b",", b";")), "rows 50 to 50"),
        "decimal_comma": (row_changed(lambda line: line.replace(b".", b",")), "too many"),
        "invalid_utf8": (cell_changed(1, b"80\xff\xfe\xff"), "rows 50 to 50"),
        "superfluous_cell": (row_changed(lambda line: line + b",1"), "too many"),
        "time_of_ages": (cell_changed(0, b"5e12"), "time_s"),
        "absurd_pressure": (as_pressure(), "row 51 reads '2.5,1000000.0,"),
        "pcs_python_number": (pcs(PCS_ROW, PCS_ROW.replace("40.0", "4_0.0")), "rows 2 to 2"),
        "pcs_dashes": (pcs(PCS_ROW, PCS_ROW.replace("1000.000", "----")), "rows 2 to 2"),
    },
    "columns_disagree": {
        "slip_by_another_definition": (csv(HALVED_SLIP, UNITS_TWICE), "slide_roll_ratio is 0.1 in"),
        "speed_as_a_sum": (csv(DOUBLED_SPEED, UNITS_TWICE), "entrainment_speed is 60 in row"),
        "forces_without_sign": (
            both_ways_positive(),
            "forces of both directions of the slip give 0",
        ),
    },
    "not_a_sweep": {
        "warm_up": (csv(log_kind="warm-up"), "log_kind: 'warm-up'; expected cont"),
        "pcs_no_sweep": (pcs(kind="BodTimed"), "'BodTimed'"),
        "pcs_endless_number": (b"PCS Test Data File\n" + ENDLESS_STEP, "is of type 'unknown'"),
    },
}
