"""Every planted damage is refused on either rig by the rule meant for it."""

import itertools
from typing import Any

import pytest

from blind_lab.defects import FAULTS
from damages import AT_A_LIMIT, DAMAGES, SOUND, Damage
from nights import nightly
from oilfilm.curation.curate import CuratedTables, curate_logs
from oilfilm.curation.plateau_gates import PLATEAU_GATES
from oilfilm.curation.run_gates import RUN_GATES
from oilfilm.tables import failed_gates

# test_curation.py plants wrong fringe orders, test_directions_and_readings.py the other faults.
PLANTED_ELSEWHERE = {"film_off_trend", "directions_differ", "two_conditions"}


def judged(name: str, damage: Damage, rig: str) -> CuratedTables:
    sound = SOUND[rig]
    logs = damage.logs(sound)
    logs = logs if isinstance(logs, list) else [logs]
    data = "measured" if name == "simulated_as_measured" else "simulated"
    config = sound.config.with_changes({"campaign": {"data": data}})
    return curate_logs([(f"log{n}", log) for n, log in enumerate(logs)], config, sound.kind)


@pytest.mark.parametrize("rig", SOUND)
def test_log_that_all_damages_are_planted_in_is_sound(rig: str) -> None:
    sound = SOUND[rig]
    curated = curate_logs([("log", sound.text())], sound.config, sound.kind)
    assert curated.quarantine.empty
    assert curated.points["accepted"].all()


# by day on the torque rig: damages that another rule refuses there
CASES = [
    (name, rig) if rig == "traction" or damage.of_torque else nightly(name, rig)
    for (name, damage), rig in itertools.product(DAMAGES.items(), SOUND)
]


@pytest.mark.slow
@pytest.mark.parametrize(("name", "rig"), CASES)
def test_damage_is_refused_by_its_rule_and_spares_what_is_sound(name: str, rig: str) -> None:
    damage = DAMAGES[name]
    curated = judged(name, damage, rig)
    rule, points = damage.rule_of(rig), curated.points
    reasons = curated.quarantine.loc[curated.quarantine["rule"] == rule, "reason"]
    gates = failed_gates.one_row_per_gate(points)["rule"]
    assert len(reasons) or rule in set(gates), (list(curated.quarantine["rule"]), set(gates))
    assert (curated.quarantine["advice"].str.len() > 20).all()
    accepted = points[points["accepted"]]
    assert (len(accepted) > 0) == damage.spares
    if damage.spares and name != "copied":
        start = SOUND[rig].held.start
        damaged = accepted["first_row"].lt(start + 30) & accepted["last_row"].gt(start + 10)
        assert not damaged.any()


@pytest.mark.parametrize("rig", SOUND)
def test_few_spikes_are_left_out_and_move_no_mean(rig: str) -> None:
    sound = SOUND[rig]
    middle = (sound.held.start + sound.held.stop) // 2
    clean = curate_logs([("log", sound.text())], sound.config, sound.kind).points

    def spike(column: Any) -> Any:
        column[middle] *= 30
        return column

    log = sound.column(sound.sensor, spike)
    points = curate_logs([("log", log)], sound.config, sound.kind).points
    assert points["accepted"].all()
    assert points["n_spikes"].sum() == clean["n_spikes"].sum() + 1
    name = sound.kind.sensor.column
    # one reading in about 60 is missing: far less than a standard error
    torque = rig == "torque"
    error = clean["torque_n_m_se" if torque else "traction_coefficient_se"]
    assert ((points[name] - clean[name]).abs() < error * (1 if torque else clean["load_n"])).all()


def test_every_gate_has_a_planted_fault() -> None:
    planted = {damage.rule_of(rig) for damage in DAMAGES.values() for rig in SOUND}
    planted |= {gate for _, gate in AT_A_LIMIT if gate}
    planted |= {rule for fault in FAULTS.values() for rule in fault.rules.split()}
    gates = {gate.name for gate in (*PLATEAU_GATES, *RUN_GATES)}
    assert gates - planted == PLANTED_ELSEWHERE, "plant one in tests/helpers/damages.py"
