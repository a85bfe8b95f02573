"""Simulated logs of the torque rig: the campaign's truth in a bearing, with the rig's troubles."""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from oilfilm.base.errors import OilfilmError
from oilfilm.base.randomness import generator
from oilfilm.base.units import RAD_S_PER_RPM, FloatArray
from oilfilm.bearing.equilibria import friction_equilibrium
from oilfilm.bearing.resistance import HEAT_TERMS
from oilfilm.settings.base import required_value
from oilfilm.settings.campaign import TorqueTwin
from oilfilm.settings.resolved import Settings
from simulated_lab.plan import SimulatedRun, simulated_torque_runs
from simulated_lab.simulate import SimulatedLog, log_content
from simulated_lab.true_bearing import true_problem
from simulated_lab.truth import TrueTraction, true_tractions, truth_misfit

# Quadrature nodes across and along the ellipse: more than in the model with which the logs are
# compared.
_NODE_COUNTS = (24, 6)
# Planted defects: a tare that drifts by more than any limit, and a torque that is higher by this
# share when a speed begins.
_PLANTED_DRIFT_N_M = 0.2
_PLANTED_TORQUE_RISE = 0.3


def simulate_torque(
    settings: Settings, constants_by_oil: Mapping[str, FloatArray]
) -> Iterator[SimulatedLog]:
    """Each planned torque log, with its rows of the table of the truth.

    The truth behind an oil is that of its traction logs. Growth of rings and balls, feed oil, drag
    and rolling resistance are those of bearing and settings. Only the traction differs from the
    model.

    Args:
        settings: The settings.
        constants_by_oil: The printed constants of each oil.
    """
    torque_test = required_value(settings.campaign.torque, "torque", "the campaign")
    twin = required_value(torque_test.twin, "twin", "the campaign's `torque`")
    traction_by_oil = true_tractions(settings, constants_by_oil)
    runs = simulated_torque_runs(settings.campaign)
    for oil in dict.fromkeys(run.oil for run in runs):
        runs_of_oil = [run for run in runs if run.oil == oil]
        truth_rows_by_log = _truth_rows(runs_of_oil, twin, traction_by_oil[oil], settings)
        for run, truth_rows in zip(runs_of_oil, truth_rows_by_log, strict=True):
            random = generator(settings.seed, "torque twin", run.name)
            yield SimulatedLog(run, _log_bytes(run, truth_rows, twin, random), truth_rows)


def _truth_rows(
    runs: list[SimulatedRun], twin: TorqueTwin, true_traction: TrueTraction, settings: Settings
) -> list[list[dict[str, Any]]]:
    """Rows of the truth of each log of one oil, one row per speed."""
    bearing = settings.tested_bearing()
    torque_test = required_value(settings.campaign.torque, "torque", "the campaign")
    speeds = required_value(torque_test.matrix, "matrix", "the campaign's `torque`").inner_speed_rpm
    load_of_run_n, temperature_of_run_c = _loads_and_temperatures(runs, twin, settings.seed)
    # operating points: the speeds of the first run, then those of the second, and so on
    speed_rpm = np.tile(np.array(speeds, dtype=float), len(runs))
    load_n = np.repeat(load_of_run_n, len(speeds))
    temperature_c = np.repeat(temperature_of_run_c, len(speeds))

    operating_points = (load_n, speed_rpm, temperature_c)
    problem = true_problem(settings, runs[0].oil, true_traction, operating_points, _NODE_COUNTS)
    equilibrium = friction_equilibrium(problem)
    if not equilibrium.solution.converged.all():
        raise OilfilmError(
            f"campaign {settings.campaign.name!r}, torque.matrix: at some of its points the "
            "simulated bearing has no steady motion. Set more load or less speed there."
        )
    law_misfit = truth_misfit(true_traction, settings)
    torque_n_m = equilibrium.torque_n_m()
    traction_heat_w = bearing.ball_count * equilibrium.balance.heats_w[HEAT_TERMS.index("traction")]
    rows_by_log = []
    for run_index, run in enumerate(runs):
        first_index = run_index * len(speeds)
        rows_by_log.append(
            [
                {
                    "run_id": run.name,
                    "oil": run.oil,
                    "defect": run.defect,
                    "inner_speed_rpm": speed_rpm[point_index],
                    "axial_load_n": load_n[point_index],
                    "oil_temperature_c": temperature_c[point_index],
                    "torque_n_m": torque_n_m[point_index],
                    # the power that becomes heat is torque times speed
                    "traction_torque_n_m": traction_heat_w[point_index]
                    / (speed_rpm[point_index] * RAD_S_PER_RPM),
                    "law_misfit": law_misfit,
                }
                for point_index in range(first_index, first_index + len(speeds))
            ]
        )
    return rows_by_log


def _loads_and_temperatures(
    runs: list[SimulatedRun], twin: TorqueTwin, seed: int
) -> tuple[FloatArray, FloatArray]:
    """Load in N and temperature in degC of each run, with the errors of their control."""
    control_draws = np.array(
        [generator(seed, "torque control", run.name).standard_normal(2) for run in runs]
    )
    load_n, temperature_c = np.array([list(run.set_points.values()) for run in runs]).T
    load_n = load_n * (1 + twin.control_load * control_draws[:, 0])
    temperature_c = temperature_c + twin.control_temperature_c * control_draws[:, 1]
    return load_n, temperature_c


def _log_bytes(
    run: SimulatedRun,
    truth_rows: list[dict[str, Any]],
    twin: TorqueTwin,
    random: np.random.Generator,
) -> bytes:
    """The log of a run as the rig's logger writes it, with the planted defect.

    Args:
        run: The run.
        truth_rows: Its rows of the truth, one per speed.
        twin: Noise, errors and timing of the rig.
        random: The generator of the run.
    """
    rate_hz = twin.sampling_rate_hz
    # samples of a rest and of a speed
    rest_sample_count = round(twin.rest_s * rate_hz)
    step_sample_count = round(twin.step_s * rate_hz)

    def steps_over_time(name: str) -> FloatArray:
        """A quantity of the truth at each instant: 0 at rest, its value at each speed, 0."""
        values = np.repeat([row[name] for row in truth_rows], step_sample_count)
        return np.concatenate([np.zeros(rest_sample_count), values, np.zeros(rest_sample_count)])

    # first-order response of the spindle to each step
    unfinished_share = np.exp(-np.arange(step_sample_count) / rate_hz / twin.response_s)

    def follow_steps(values_in_steps: FloatArray) -> FloatArray:
        """The quantity at each instant as it follows its steps."""
        unfinished_change = np.convolve(np.diff(values_in_steps, prepend=0.0), unfinished_share)
        return values_in_steps - unfinished_change[: len(values_in_steps)]

    speed_set_point_rpm = steps_over_time("inner_speed_rpm")
    time_s = np.arange(len(speed_set_point_rpm)) / rate_hz
    speed_rpm = follow_steps(speed_set_point_rpm)
    torque_n_m = follow_steps(steps_over_time("torque_n_m"))
    is_resting = speed_set_point_rpm == 0
    # below 1 rpm the spindle stands still
    speed_rpm[is_resting] = np.where(np.abs(speed_rpm[is_resting]) < 1, 0.0, speed_rpm[is_resting])
    gain_draw, tare_draw, drift_draw = random.standard_normal(3)
    drift_n_m = twin.tare_drift_n_m * drift_draw
    if run.defect == "tare_drift":
        drift_n_m = _PLANTED_DRIFT_N_M
    if run.defect == "warming":
        # the torque still falls at the end of each speed, as it does in a bearing that warms up
        sample_in_step = (np.arange(len(torque_n_m)) - rest_sample_count) % step_sample_count
        torque_n_m = torque_n_m * (
            1 + _PLANTED_TORQUE_RISE * np.exp(-sample_in_step / (0.5 * step_sample_count))
        )
    torque_n_m = torque_n_m * (1 + twin.systematic_torque * gain_draw)
    torque_n_m = torque_n_m + twin.tare_n_m * tare_draw + drift_n_m * (time_s / time_s[-1])

    def noise(standard_deviation: float) -> FloatArray:
        """Noise of a sensor with this standard deviation."""
        return standard_deviation * random.standard_normal(len(time_s))

    load_n, temperature_c = truth_rows[0]["axial_load_n"], truth_rows[0]["oil_temperature_c"]
    is_turning = ~is_resting
    signals = {
        "time_s": time_s,
        "axial_load_n": load_n + noise(twin.load_noise_n),
        "inner_speed_rpm": speed_rpm + np.where(is_turning, noise(twin.speed_noise_rpm), 0.0),
        "oil_temperature_c": temperature_c + noise(twin.temperature_noise_c),
        # recorded only: no model here uses it
        "outer_ring_temperature_c": temperature_c
        + 2 * torque_n_m
        + noise(twin.temperature_noise_c),
        "torque_n_m": torque_n_m + noise(twin.torque_noise_n_m),
    }
    return log_content("torque-rig", run, signals)
