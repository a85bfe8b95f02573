"""Simulated logs of the torque rig: the campaign's truth in a bearing, with the rig's troubles."""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from oilfilm.base.errors import OilfilmError
from oilfilm.base.randomness import generator
from oilfilm.base.units import RAD_S_PER_RPM, FloatArray
from oilfilm.bearing.equilibria import friction_equilibrium
from oilfilm.bearing.resistance import HEATS
from oilfilm.settings.base import present
from oilfilm.settings.campaign import TorqueTwin
from oilfilm.settings.resolved import Settings
from simulated_lab.plan import PlannedRun, planned_torque_runs
from simulated_lab.simulate import log_content
from simulated_lab.true_bearing import true_problem
from simulated_lab.truth import Truth, misfit, true_tractions

# Finer than the grid of the model that the logs are compared with.
_QUADRATURE = (24, 6)


def simulate_torque(
    settings: Settings, constants: Mapping[str, FloatArray]
) -> Iterator[tuple[PlannedRun, bytes, list[dict[str, Any]]]]:
    """Each planned torque log: the plan, its bytes, and its rows of the table of the truth.

    The truth behind an oil is that of its traction logs. Growth, feed oil, drag and rolling
    resistance are those of bearing and settings: the comparison is about traction.

    Args:
        settings: The settings.
        constants: The printed constants of each oil.
    """
    torque = present(settings.campaign.torque, "torque", "the campaign")
    twin = present(torque.twin, "twin", "the campaign's `torque`")
    tractions = true_tractions(settings, constants)
    plans = planned_torque_runs(settings.campaign)
    for oil in dict.fromkeys(plan.oil for plan in plans):
        plans_of_oil = [plan for plan in plans if plan.oil == oil]
        truths = _truth(plans_of_oil, twin, tractions[oil], settings)
        for plan, truth in zip(plans_of_oil, truths, strict=True):
            random = generator(settings.seed, "torque twin", plan.name)
            yield plan, _log(plan, truth, twin, random), truth


def _truth(
    plans: list[PlannedRun], twin: TorqueTwin, traction: Truth, settings: Settings
) -> list[list[dict[str, Any]]]:
    """Rows of the truth of each log of one oil, one row per speed."""
    bearing = settings.tested_bearing()
    torque_logs = present(settings.campaign.torque, "torque", "the campaign")
    speeds = present(torque_logs.matrix, "matrix", "the campaign's `torque`").inner_speed_rpm
    load_of_run, temperature_of_run = _controlled(plans, twin, settings.seed)
    # operating points: the speeds of the first run, then those of the second, and so on
    speed = np.tile(np.array(speeds, dtype=float), len(plans))
    load = np.repeat(load_of_run, len(speeds))
    temperature = np.repeat(temperature_of_run, len(speeds))

    points = (load, speed, temperature)
    problem = true_problem(settings, plans[0].oil, traction, points, _QUADRATURE)
    equilibrium = friction_equilibrium(problem)
    if not equilibrium.solution.converged.all():
        raise OilfilmError(
            f"campaign {settings.campaign.name!r}, torque.matrix: at some of its points the "
            "simulated bearing has no steady motion. Set more load or less speed there."
        )
    law_misfit = misfit(traction, settings)
    torque = equilibrium.torque_n_m()
    heat = bearing.ball_count * equilibrium.balance.heats_w[HEATS.index("traction")]
    truths = []
    for number, plan in enumerate(plans):
        first = number * len(speeds)
        truths.append(
            [
                {
                    "run_id": plan.name,
                    "oil": plan.oil,
                    "defect": plan.defect,
                    "inner_speed_rpm": speed[point],
                    "axial_load_n": load[point],
                    "oil_temperature_c": temperature[point],
                    "torque_n_m": torque[point],
                    "traction_torque_n_m": heat[point] / (speed[point] * RAD_S_PER_RPM),
                    "law_misfit": law_misfit,
                }
                for point in range(first, first + len(speeds))
            ]
        )
    return truths


def _controlled(
    plans: list[PlannedRun], twin: TorqueTwin, seed: int
) -> tuple[FloatArray, FloatArray]:
    """Load in N and temperature in degC of each run, with the errors of their control."""
    errors = np.array(
        [generator(seed, "torque control", plan.name).standard_normal(2) for plan in plans]
    )
    load, temperature = np.array([list(plan.set_points.values()) for plan in plans]).T
    load = load * (1 + twin.control_load * errors[:, 0])
    temperature = temperature + twin.control_temperature_c * errors[:, 1]
    return load, temperature


def _log(
    plan: PlannedRun, truth: list[dict[str, Any]], twin: TorqueTwin, random: np.random.Generator
) -> bytes:
    """The log of a run as the rig's logger writes it, with the planted defect.

    Args:
        plan: The run.
        truth: Its rows of the truth, one per speed.
        twin: Noise, errors and timing of the rig.
        random: The generator of the run.
    """
    rate = twin.sampling_rate_hz
    # samples of a rest and of a speed
    rest = round(twin.rest_s * rate)
    step = round(twin.step_s * rate)

    def programme(name: str) -> FloatArray:
        levels = np.repeat([row[name] for row in truth], step)
        return np.concatenate([np.zeros(rest), levels, np.zeros(rest)])

    # first-order answer to each change of the set point
    decay = np.exp(-np.arange(step) / rate / twin.response_s)

    def answer(signal: FloatArray) -> FloatArray:
        still_to_go = np.convolve(np.diff(signal, prepend=0.0), decay)
        return signal - still_to_go[: len(signal)]

    target = programme("inner_speed_rpm")
    time_s = np.arange(len(target)) / rate
    speed = answer(target)
    torque = answer(programme("torque_n_m"))
    resting = target == 0
    speed[resting] = np.where(np.abs(speed[resting]) < 1, 0.0, speed[resting])
    gain, zero, drift = random.standard_normal(3)
    drift_n_m = twin.tare_drift_n_m * drift
    if plan.defect == "tare_drift":
        drift_n_m = 0.2
    if plan.defect == "warming":
        # the torque still falls at the end of each speed, as it does in a bearing that warms up
        sample_in_step = (np.arange(len(torque)) - rest) % step
        torque = torque * (1 + 0.3 * np.exp(-sample_in_step / (0.5 * step)))
    torque = torque * (1 + twin.systematic_torque * gain)
    torque = torque + twin.tare_n_m * zero + drift_n_m * (time_s / time_s[-1])

    def noise(spread: float) -> FloatArray:
        return spread * random.standard_normal(len(time_s))

    load, temperature = truth[0]["axial_load_n"], truth[0]["oil_temperature_c"]
    turning = ~resting
    columns = {
        "time_s": time_s,
        "axial_load_n": load + noise(twin.load_noise_n),
        "inner_speed_rpm": speed + np.where(turning, noise(twin.speed_noise_rpm), 0.0),
        "oil_temperature_c": temperature + noise(twin.temperature_noise_c),
        # recorded only: no model here uses it
        "outer_ring_temperature_c": temperature + 2 * torque + noise(twin.temperature_noise_c),
        "torque_n_m": torque + noise(twin.torque_noise_n_m),
    }
    return log_content("torque-rig", plan, columns)
