"""Exports as the programs of PCS rigs write them: measured curves (ETM) and planted films (EHD)."""

import gzip
from collections.abc import Iterable, Mapping, Sequence
from datetime import datetime
from decimal import ROUND_FLOOR, Decimal

import numpy as np

from campaigns import ETM

# Films planted in the EHD export: h = h0 U^n in nm and m/s, by temperature in degC.
FILM_EXPONENT = 0.67
FILM_NM = {40: 400.0, 60: 250.0, 80: 150.0}
WRONG_ORDERS = slice(20, 27)  # rows of the last step whose fringe order is one too high
# Film thickness of one fringe order of the interferometer.
ORDER_NM = 190.0

_ETM_NAMES = (
    "SRR (%)\tTraction Coeff (-)\t\t\t\t\t\t\tStep Time (s)\tPot RTD Temp (degC)\t"
    "Lube RTD Temp (degC)\tBall Load (N)\tWear (um)\t\tBall Speed 1\tBall Speed 2\tBall Speed 3\t"
    "Ball Speed 4\tDisc Speed 1\tDisc Speed 2\tDisc Speed 3\tDisc Speed 4\tRolling Speed (mm/s)\t"
    "Sliding Speed (mm/s)\tSRR (%)\t\tTF1 (N)\tTF2 (N)\tTF3 (N)\tTF4 (N)\tTraction Force (N)\t"
    "Traction Coeff (-)\tRolling Force (N)\tRolling Coeff (-)\tTraction Trace (-)"
)
_EHD_NAMES = (
    "Rolling Speed (mm/s)\tAverage Film (nm)\t\t\t\t\t\t\tStep Time (s)\tLube Temp (°C)\t"
    "Pot Temp (°C)\tBall Load (N)\t\tBall Speed 1\tBall Speed 2\tDisc Speed 1\tDisc Speed 2\t"
    "Rolling Speed (mm/s)\tSliding Speed (mm/s)\tSRR (%)\t\tTraction Force 1 (N)\t"
    "Traction Force 2 (N)\tTraction Force (N)\tTraction Coeff (-)\t\tSD Repeat Number (-)\t"
    "User Repeat Number (-)\tAverage Film (nm)\tStandard Deviation (nm)\tOrder\tLube Ref Index\t"
    "Average Wavelength (nm)\t\tImage file name\t"
)


def shipped_log(number: int) -> tuple[dict[str, str], list[dict[str, str]]]:
    """Header and rows of one step in data/raw/etm-slim, as text."""
    content = (ETM / f"step{number:03d}.csv.gz").read_bytes()
    lines = gzip.decompress(content).decode("ascii").splitlines()
    header = dict(line[2:].split(": ", 1) for line in lines if line.startswith("# "))
    names, *rows = [line.split(",") for line in lines[len(header) :]]
    return header, [dict(zip(names, row, strict=True)) for row in rows]


def shipped_steps() -> list[int]:
    """Numbers of the steps in data/raw/etm-slim."""
    return sorted(int(path.name[4:7]) for path in ETM.glob("step*.csv.gz"))


def shipped_numbers() -> np.ndarray:
    """Step, time, slide-roll ratio and F/W of every measured row, from the text alone."""
    rows = []
    for number in shipped_steps()[2:]:
        for row in shipped_log(number)[1]:
            ball, disc = (float(row[f"{body}_speed [mm/s]"]) for body in ("ball", "disc"))
            mu = float(row["traction_force_n"]) / float(row["load_n"])
            rows.append((number, float(row["time_s"]), 2 * (disc - ball) / (disc + ball), mu))
    return np.array(rows).T


def traction_export(steps: Iterable[int] | None = None) -> bytes:
    """The measured curves as an ETM exports them; all steps where none are named."""
    blocks = [_etm_step(number, *shipped_log(number)) for number in steps or shipped_steps()]
    return ("\n\n".join(blocks) + "\n\nAll steps completed\n").encode("ascii")


def _etm_step(number: int, header: Mapping[str, str], rows: Sequence[Mapping[str, str]]) -> str:
    started = datetime.fromisoformat(header["started"]).strftime("%d/%m/%Y %H:%M:%S")
    kind = "Traction" if header["log_kind"] == "steps" else "BodTimed" if rows else "Mapper"
    lines = [f"Step {number} started at {started}", f"Step type\t{kind}\tStep description\tx"]
    if rows:
        lines += ["Disc track radius used for this step (mm)\t20.979", _ETM_NAMES]
    return "\n".join([*lines, *map(_etm_row, rows)])


def _etm_row(row: Mapping[str, str]) -> str:
    ball, disc = (Decimal(row[f"{body}_speed [mm/s]"]) for body in ("ball", "disc"))
    load, force = Decimal(row["load_n"]), row["traction_force_n"]
    rolling, sliding = (ball + disc) / 2, disc - ball
    srr = f"{100 * sliding / rolling:.3f}"
    coefficient = f"{abs(Decimal(force)) / load:.4f}"
    speeds = [f"{ball:.2f}", "", f"{disc:.2f}", ""]
    if "traction_force_1_n" in row:
        # of either direction to 0.01 mm/s, so that their mean is what was logged
        ball_1, disc_1 = (each.quantize(Decimal("0.01"), ROUND_FLOOR) for each in (ball, disc))
        speeds = [f"{ball_1}", f"{2 * disc - disc_1:.2f}", f"{disc_1}", f"{2 * ball - ball_1:.2f}"]
    balls, discs = [*speeds[:2], "", ""], [*speeds[2:], "", ""]
    forces = [row.get("traction_force_1_n", ""), row.get("traction_force_2_n", ""), "", ""]
    repeated = [srr, coefficient, *6 * [""]]
    sensors = [row["time_s"], "", row["inlet_temperature_c"], row["load_n"], "", ""]
    derived = [f"{rolling:.2f}", f"{sliding:.2f}", srr, ""]
    cells = [*repeated, *sensors, *balls, *discs, *derived, *forces, force, coefficient, "", "", ""]
    return "\t".join(cells)


def film_export() -> bytes:
    """Planted films as an EHD rig exports them: a step at each temperature."""
    lines = ["EHD261 Test Data File", "Disc track radius:\t42.300"]
    for number, (temperature, film_at_1) in enumerate(FILM_NM.items(), start=1):
        speeds = np.geomspace(2000, 20, 31)
        films = film_at_1 * (speeds / 1000) ** FILM_EXPONENT
        if number == len(FILM_NM):
            films[WRONG_ORDERS] += ORDER_NM
        lines += [f'Step {number} "Film step" started at 27/11/2017 1{number}:00']
        lines += ["Step type\tFILM\tStep description\tFilm step", _EHD_NAMES]
        lines += [
            f"{u:.1f}\t{h:.1f}\t\t\t\t\t\t\t{20 * row}\t{temperature}.0\t{temperature}.1\t"
            f"20.050\t\t{u:.2f}\t\t{u:.2f}\t\t{u:.2f}\t0.00\t0.000\t\t\t\t\t\t\t1\t1\t{h:.1f}\t0.50\t3\t"
            "1.468\t600.000\t\t\t"
            for row, (u, h) in enumerate(zip(speeds, films, strict=True), start=1)
        ]
        lines += [""]
    return "\r\n".join([*lines, "All steps completed", ""]).encode("utf-8-sig")
