"""A torque in place of the traction force becomes the force by the lever arm of the rig file."""

import numpy as np
import pytest

import formats
from bad_logs import CONFIG
from oilfilm.logs.base import ParsedLog
from oilfilm.logs.ingest import read_log
from oilfilm.settings.resolved import Settings

ARM_M = 0.025
VALUES = formats.columns(30)
# N m per unit
UNITS = {"N m": 1.0, "Nm": 1.0, "mN m": 1e-3, "mN.m": 1e-3, "mNm": 1e-3, "N·m": 1.0, "Ncm": 1e-2}


def with_arm(arm_m: float | None) -> Settings:
    (rig_name,) = CONFIG.rigs
    rig = CONFIG.rigs[rig_name].model_copy(update={"torque_arm_m": arm_m})
    named = CONFIG.with_changes({"campaign": {"columns": {"traction_force": {"name": "Torque"}}}})
    return named.model_copy(update={"rigs": {rig_name: rig}})


def torque_log(unit: str, format_name: str) -> bytes:
    torque = VALUES["traction_force"] * ARM_M / UNITS[unit]
    values = {**VALUES, "Torque": torque}
    del values["traction_force"]
    units = {**formats.UNITS, "Torque": unit}
    writer = {"csv": formats.csv, "tdms": formats.tdms, "lvm": formats.lvm}[format_name]
    content = writer(values, units)
    return content.encode() if isinstance(content, str) else content


def read(content: bytes, settings: Settings) -> ParsedLog:
    return read_log(content, "log", settings)[1]


@pytest.mark.parametrize("format_name", ["csv", "tdms", "lvm"])
@pytest.mark.parametrize("unit", UNITS)
def test_force_is_torque_over_arm(unit: str, format_name: str) -> None:
    (run,) = read(torque_log(unit, format_name), with_arm(ARM_M)).runs
    force = run.samples["traction_force_n"]
    np.testing.assert_allclose(force, VALUES["traction_force"], rtol=1e-9)


def test_torque_without_an_arm_is_refused_by_key_and_file() -> None:
    reading = read(torque_log("mN m", "csv"), with_arm(None))
    assert reading.runs == []
    (refusal,) = reading.refusals
    assert refusal.rule == "rig"
    assert "torque_arm_m" in refusal.reason
    assert "config/rigs/" in refusal.advice


def test_force_in_newtons_needs_no_arm() -> None:
    (run,) = read(formats.csv(VALUES), with_arm(None)).runs
    np.testing.assert_allclose(run.samples["traction_force_n"], VALUES["traction_force"])
