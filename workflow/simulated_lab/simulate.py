"""The rig twin: logs of a traction rig, simulated from a known traction with errors of a rig.

Truth is a traction law with known constants, or physics. On top come the sensors' noise, the
drift of the traction sensor's zero, the control errors of load, speed and temperature, errors that
a whole run shares, the overshoot of the slip control, wild readings and, in a few runs, planted
defects.
"""

import io
from collections.abc import Iterable, Iterator, Mapping
from hashlib import sha256
from itertools import accumulate
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pyarrow as arrow
import pyarrow.csv as arrow_csv

from oilfilm import tables
from oilfilm.base.atomic_write import write_text
from oilfilm.base.randomness import generator
from oilfilm.base.units import PA_PER_GPA, FloatArray, surface_speed_to_rpm
from oilfilm.logs.raw_files import listing_text
from oilfilm.physics.contact import Contact, max_hertz_pressure
from oilfilm.settings.base import required_value
from oilfilm.settings.campaign import Twin
from oilfilm.settings.resolved import Settings
from oilfilm.settings.rig import Rig
from simulated_lab.plan import GATE_OF_DEFECT, SimulatedRun, simulated_runs
from simulated_lab.truth import TrueTraction, contact_of_only_rig, true_tractions

_NEWTON_PER_KGF = 9.80665
# Decimals that a logger writes of each signal.
_DECIMALS = {
    "time_s": 2,
    "load_n": 3,
    "traction_force_n": 5,
    "ball_speed_rpm": 2,
    "disc_speed_rpm": 2,
    "inlet_temperature_c": 2,
    "axial_load_n": 1,
    "inner_speed_rpm": 1,
    "oil_temperature_c": 2,
    "outer_ring_temperature_c": 2,
    "torque_n_m": 4,
}


# The samples of each signal, by its name.
SamplesBySignal = dict[str, FloatArray]


class SimulatedLog(NamedTuple):
    """A log and the truth behind it.

    Attributes:
        run: The planned run.
        content: Bytes of the CSV log.
        truth_rows: Rows of the table of the truth.
    """

    run: SimulatedRun
    content: bytes
    truth_rows: list[dict[str, Any]]


def simulate_campaign(
    settings: Settings, constants_by_oil: Mapping[str, FloatArray]
) -> Iterator[SimulatedLog]:
    """The log of each planned run, with its one row of the table of truth.

    The random numbers of a run depend only on the seed and the run's name. So a run is the same
    whichever other runs are simulated with it.

    Args:
        settings: The settings.
        constants_by_oil: The printed constants of each oil. They are true unless the campaign's
            twin has another truth.
    """
    traction_by_oil = true_tractions(settings, constants_by_oil)
    contact = contact_of_only_rig(settings)
    ((rig_name, rig),) = settings.rigs.items()
    for geometry_key in ("full_scale", "ball_track_radius_m", "disc_track_radius_m"):
        required_value(getattr(rig, geometry_key), geometry_key, f"config/rigs/{rig_name}.yaml")
    twin = required_value(settings.campaign.twin, "twin", "the campaign")
    time_and_slip = slip_programme(twin)
    for run in simulated_runs(settings.campaign):
        random = generator(settings.seed, "rig twin", run.name)
        true_signals = _true_signals(
            run, traction_by_oil[run.oil], twin, contact, time_and_slip, random
        )
        truth_row = {
            "run_id": run.name,
            "oil": run.oil,
            "defect": run.defect,
            "gate": GATE_OF_DEFECT.get(run.defect, ""),
        }
        for set_point in run.set_points:
            truth_row[set_point] = true_signals[set_point].mean()
        sensor_signals = _sensor_signals(run, true_signals, twin, rig, random)
        yield SimulatedLog(run, log_content("rig", run, sensor_signals), [truth_row])


def slip_programme(twin: Twin) -> tuple[FloatArray, FloatArray]:
    """Time (s) and slide-roll ratio of a run: rolling, the steps with their overshoot, rolling."""
    rate_hz = twin.sampling_rate_hz
    rolling = np.zeros(round(twin.baseline_s * rate_hz))
    step_slips = np.linspace(0, twin.slip_max, twin.slip_steps)
    target_slip = np.concatenate(
        [rolling, np.repeat(step_slips, round(twin.step_s * rate_hz)), rolling]
    )
    time_s = np.arange(len(target_slip)) / rate_hz
    # a damped second-order answer to each change of the set point
    decay = np.exp(-time_s / twin.response_s)
    response = decay * np.cos(time_s / twin.response_s)
    changes = np.diff(target_slip, prepend=0.0)
    remaining_change = np.convolve(changes, response)[: len(target_slip)]
    return time_s, target_slip - remaining_change


def _true_signals(
    run: SimulatedRun,
    traction: TrueTraction,
    twin: Twin,
    contact: Contact,
    time_and_slip: tuple[FloatArray, FloatArray],
    random: np.random.Generator,
) -> SamplesBySignal:
    """The true signals of a run at each instant, before any sensor."""
    time_s, slip = time_and_slip
    nominal_gpa, nominal_m_s, nominal_c = run.set_points.values()
    load_draw, speed_draw, temperature_draw = random.standard_normal(3)
    load_wander = _relative_wander(time_s, twin, random)
    load_n = contact.load_n(nominal_gpa) * (1 + twin.control_load * load_draw + load_wander)
    speed_wander = _relative_wander(time_s, twin, random)
    speed_m_s = nominal_m_s * (1 + twin.control_speed * speed_draw + speed_wander)
    temperature_c = np.full_like(time_s, nominal_c + twin.control_temperature_c * temperature_draw)
    pressure_pa = max_hertz_pressure(load_n, contact.radius_m, contact.reduced_modulus_pa)
    pressure_gpa = pressure_pa / PA_PER_GPA
    mu = traction(pressure_gpa, speed_m_s, temperature_c, np.abs(slip))
    return {
        "time_s": time_s,
        "slide_roll_ratio": slip,
        "load_n": load_n,
        "max_hertz_pressure_gpa": pressure_gpa,
        "entrainment_speed_m_s": speed_m_s,
        "inlet_temperature_c": temperature_c,
        "traction_force_n": np.sign(slip) * mu * load_n,
    }


def _sensor_signals(
    run: SimulatedRun,
    true_signals: SamplesBySignal,
    twin: Twin,
    rig: Rig,
    random: np.random.Generator,
) -> SamplesBySignal:
    """The signals as the sensors give them, with the planted defect."""
    full_scale = required_value(rig.full_scale, "full_scale", "the rig")
    load_gain_draw, temperature_draw, zero_draw, drift_draw = random.standard_normal(4)
    time_s = true_signals["time_s"]

    def noise(sensor: str) -> FloatArray:
        """Random error of a sensor at each time, in the sensor's unit."""
        standard_deviation = twin.noise_of_full_scale * float(getattr(full_scale, sensor))
        return standard_deviation * random.standard_normal(len(time_s))

    def logged_rpm(speed_m_s: FloatArray, radius_key: str) -> FloatArray:
        """Logged speed (rpm) of a ball or disc whose surface has this speed."""
        logged_m_s = speed_m_s + noise("surface_speed_m_s")
        radius_m = required_value(getattr(rig, radius_key), radius_key, "the rig")
        return surface_speed_to_rpm(logged_m_s, radius_m)

    force_n = true_signals["traction_force_n"] + twin.zero_offset_n * zero_draw
    force_n = force_n + twin.zero_drift_n * drift_draw * (time_s / time_s[-1])
    force_n = force_n + noise("traction_force_n")
    spike_indices = random.choice(len(force_n), twin.spikes, replace=False)
    force_n[spike_indices] += twin.spike_n * random.choice([-1.0, 1.0], twin.spikes)
    load_n = true_signals["load_n"] * (1 + twin.systematic_load * load_gain_draw) + noise("load_n")
    speed_m_s = true_signals["entrainment_speed_m_s"]
    half_slip = true_signals["slide_roll_ratio"] / 2
    ball_rpm = logged_rpm(speed_m_s * (1 - half_slip), "ball_track_radius_m")
    disc_rpm = logged_rpm(speed_m_s * (1 + half_slip), "disc_track_radius_m")
    temperature_c = true_signals["inlet_temperature_c"] + noise("temperature_c")
    temperature_c = temperature_c + twin.systematic_temperature_c * temperature_draw
    if run.defect == "swapped_sign":
        force_n = -force_n
    if run.defect == "wrong_units":
        load_n = load_n / _NEWTON_PER_KGF
    if run.defect == "stuck_sensor":
        stuck_index = int(0.4 * len(force_n))
        force_n[stuck_index:] = force_n[stuck_index]
    return {
        "time_s": time_s,
        "load_n": load_n,
        "traction_force_n": force_n,
        "ball_speed_rpm": ball_rpm,
        "disc_speed_rpm": disc_rpm,
        "inlet_temperature_c": temperature_c,
    }


def _relative_wander(time_s: FloatArray, twin: Twin, random: np.random.Generator) -> FloatArray:
    """Slow relative wandering of a controlled quantity.

    It is first-order autoregressive noise with a time constant of 1 s. It starts near 0. Its
    standard deviation is 0.31 of `wander` at the first sample of a log of 20 Hz, and `wander` after
    about 3 s.
    """
    autocorrelation = float(np.exp(-(time_s[1] - time_s[0]) / 1.0))
    random_pushes = random.standard_normal(len(time_s)) * np.sqrt(1 - autocorrelation**2)

    def next_value(value: float, push: float) -> float:
        return autocorrelation * value + push

    # a filter of SciPy gives the same, and takes longer to import
    values = list(accumulate(random_pushes.tolist(), next_value))
    return twin.wander * np.array(values)


def log_content(twin_name: str, run: SimulatedRun, signals: SamplesBySignal) -> bytes:
    """A log as a data logger writes it: header with the set points, column names and rows.

    The defect `truncated` cuts it off in the middle of a row, as a full disk does.

    Args:
        twin_name: Name of the rig twin that simulated it.
        run: The run.
        signals: The samples; a logger writes a fixed number of decimals of each.
    """
    header = [
        f"# simulated: yes - written by the oilfilm {twin_name} twin, not a measurement",
        f"# oil: {run.oil}",
        *(f"# {name}: {value:g}" for name, value in run.set_points.items()),
    ]
    rounded = {name: np.round(values, _DECIMALS[name]) for name, values in signals.items()}
    buffer = io.BytesIO()
    arrow_csv.write_csv(arrow.table(rounded), buffer, arrow_csv.WriteOptions(quoting_style="none"))
    # column names are quoted whatever the style
    column_line, line_end, rows = buffer.getvalue().partition(b"\n")
    header_lines = "".join(f"{line}\n" for line in header).encode()
    content = header_lines + column_line.replace(b'"', b"") + line_end + rows
    if run.defect == "truncated":
        row_start = content.index(b"\n", int(0.6 * len(content))) + 1
        first_comma = content.index(b",", row_start)
        second_comma = content.index(b",", first_comma + 1)
        return content[: second_comma + 3]
    return content


def write_logs(
    logs: Iterable[SimulatedLog], table_name: str, outputs: Any, provenance: Mapping[str, Any]
) -> None:
    """Write simulated logs, the list of their digests, and the table of their truth.

    Args:
        logs: The logs.
        table_name: Name of that table.
        outputs: Named outputs of a Snakemake job: `logs`, `listing`, and the table.
        provenance: As `tables.write`.
    """
    path_by_name = {Path(path).name: Path(path) for path in outputs.logs}
    truth_rows: list[dict[str, Any]] = []
    digest_by_name = {}
    for run, content, truth_rows_of_log in logs:
        path_by_name[run.name].write_bytes(content)
        digest_by_name[run.name] = sha256(content).hexdigest()
        truth_rows += truth_rows_of_log
    write_text(listing_text(dict(sorted(digest_by_name.items()))), Path(outputs.listing))
    tables.write(
        tables.from_rows(truth_rows, table_name), table_name, Path(outputs[table_name]), provenance
    )
