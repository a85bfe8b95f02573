"""Simulated logs of the torque rig: the campaign's truth in a bearing, with the rig's troubles."""

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from oilfilm.base.errors import OilfilmError
from oilfilm.base.randomness import generator
from oilfilm.base.units import RAD_S_PER_RPM, FloatArray
from oilfilm.bearing.ellipse import gauss_rule
from oilfilm.bearing.equilibria import friction_equilibrium
from oilfilm.bearing.friction import FrictionProblem
from oilfilm.bearing.quasistatic import OperatingPoints
from oilfilm.bearing.resistance import HEATS, Lubrication
from oilfilm.settings.base import present
from oilfilm.settings.campaign import TorqueTwin
from oilfilm.settings.resolved import Settings
from simulated_lab.plan import PlannedRun, planned_torque_runs
from simulated_lab.simulate import log_content
from simulated_lab.truth import Truth, misfit, true_tractions

# Finer than the grid of the model that the logs are compared with.
_QUADRATURE = (24, 6)


def simulate_torque(
    settings: Settings, constants: Mapping[str, FloatArray]
) -> Iterator[tuple[PlannedRun, bytes, list[dict[str, Any]]]]:
    """Each planned torque log: the plan, its bytes, and its rows of the table of the truth.

    The truth behind an oil is that of its traction logs. Drag and rolling resistance are those of
    `settings.bearing`: the comparison is about traction.

    Args:
        settings: The settings.
        constants: The printed constants of each oil.
    """
    torque = present(settings.campaign.torque, "torque", "the campaign")
    twin = present(torque.twin, "twin", "the campaign's `torque`")
    tractions = true_tractions(settings, constants)
    plans = planned_torque_runs(settings.campaign)
    for oil in dict.fromkeys(plan.oil for plan in plans):
        of_oil = [plan for plan in plans if plan.oil == oil]
        truths = _truth(of_oil, twin, tractions[oil], settings)
        for plan, truth in zip(of_oil, truths, strict=True):
            random = generator(settings.seed, "torque twin", plan.name)
            yield plan, _log(plan, truth, twin, random), truth


def _truth(
    plans: list[PlannedRun], twin: TorqueTwin, traction: Truth, settings: Settings
) -> list[list[dict[str, Any]]]:
    """Rows of the truth of each log of one oil, one row per speed."""
    bearing, oil = settings.tested_bearing(), settings.known_oil(plans[0].oil)
    torque_logs = present(settings.campaign.torque, "torque", "the campaign")
    speeds = present(torque_logs.matrix, "matrix", "the campaign's `torque`").inner_speed_rpm
    errors = np.array(
        [generator(settings.seed, "torque control", plan.name).standard_normal(2) for plan in plans]
    )
    load, temperature = np.array([list(plan.set_points.values()) for plan in plans]).T
    load = load * (1 + twin.control_load * errors[:, 0])
    temperature = temperature + twin.control_temperature_c * errors[:, 1]
    speed = np.tile(np.array(speeds, dtype=float), len(plans))
    loads, temperatures = np.repeat(load, len(speeds)), np.repeat(temperature, len(speeds))

    rule, settled = gauss_rule(*_QUADRATURE), settings.bearing
    points = OperatingPoints.axial(loads, speed * RAD_S_PER_RPM)
    lubrication = Lubrication.of(
        oil, temperatures, settled.drag_coefficient, settled.oil_volume_fraction
    )
    law = traction.at_points(rule, bearing.radius_y_m[:, np.newaxis])
    found = friction_equilibrium(FrictionProblem(bearing, points, lubrication, law, rule))
    if not found.solution.converged.all():
        raise OilfilmError(
            f"campaign {settings.campaign.name!r}, torque.matrix: at some of its points the "
            "simulated bearing comes to no steady motion. Ask for more load or less speed."
        )
    left = misfit(traction, settings)
    torque = found.torque_n_m()
    heat = bearing.ball_count * found.balance.heats_w[HEATS.index("traction")]
    rows = [
        {
            "run_id": plan.name,
            "oil": plan.oil,
            "defect": plan.defect,
            "inner_speed_rpm": speed[row],
            "axial_load_n": loads[row],
            "oil_temperature_c": temperatures[row],
            "torque_n_m": torque[row],
            "traction_torque_n_m": heat[row] / (speed[row] * RAD_S_PER_RPM),
            "law_misfit": left,
        }
        for row, plan in enumerate(plan for plan in plans for _ in speeds)
    ]
    return [rows[start : start + len(speeds)] for start in range(0, len(rows), len(speeds))]


def _log(
    plan: PlannedRun, truth: list[dict[str, Any]], twin: TorqueTwin, random: np.random.Generator
) -> bytes:
    """What the rig's logger writes of a run, its planted defect included."""
    rate = twin.sampling_rate_hz
    rest, step = round(twin.rest_s * rate), round(twin.step_s * rate)

    def programme(name: str) -> FloatArray:
        levels = np.repeat([row[name] for row in truth], step)
        return np.concatenate([np.zeros(rest), levels, np.zeros(rest)])

    target, torque = programme("inner_speed_rpm"), programme("torque_n_m")
    time_s = np.arange(len(target)) / rate
    share = time_s / time_s[-1]
    answer = np.exp(-np.arange(step) / rate / twin.response_s)
    speed, torque = (
        signal - np.convolve(np.diff(signal, prepend=0.0), answer)[: len(signal)]
        for signal in (target, torque)
    )
    resting = target == 0
    speed[resting] = np.where(np.abs(speed[resting]) < 1, 0.0, speed[resting])
    gain, zero, drift = random.standard_normal(3)
    drift_n_m = twin.tare_drift_n_m * drift
    if plan.defect == "tare_drift":
        drift_n_m = 0.2
    if plan.defect == "warming":
        # the torque still falls at the end of each speed, as it does in a bearing that warms up
        torque = torque * (
            1 + 0.3 * np.exp(-((np.arange(len(torque)) - rest) % step) / (0.5 * step))
        )
    torque = torque * (1 + twin.systematic_torque * gain)
    torque = torque + twin.tare_n_m * zero + drift_n_m * share

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
