"""Which runs a simulated campaign has. The Snakefile reads their names.

Decides: which runs a simulated campaign has.
"""

import itertools
from dataclasses import dataclass

from oilfilm.settings.base import present
from oilfilm.settings.campaign import Campaign

# Planted defect -> the gate or rule that must catch it.
GATES = {
    "truncated": "truncated",
    "swapped_sign": "swapped_sign",
    "stuck_sensor": "stuck_sensor",
    "wrong_units": "load_off_nominal",
    "thin_film": "thin_film",
    "duplicate": "duplicate_condition",
}


@dataclass(frozen=True)
class PlannedRun:
    """One run of the simulated campaign: oil, set points and the defect planted in it, if any."""

    oil: str
    max_hertz_pressure_gpa: float
    entrainment_speed_m_s: float
    inlet_temperature_c: float
    defect: str = ""

    @property
    def name(self) -> str:
        """File name of the run's log, which is also the run's name."""
        condition = (
            f"P{self.max_hertz_pressure_gpa:.2f}_U{_digits(self.entrainment_speed_m_s, 2)}"
            f"_T{_digits(self.inlet_temperature_c, 3)}"
        )
        again = "_again" if self.defect == "duplicate" else ""
        return f"{self.oil}_{condition}{again}.csv"


def _digits(level: float, width: int) -> str:
    """A level with leading zeros, so that names sort, and with decimals where it has any."""
    return f"{level:0{width}.0f}" if level == round(level) else f"{level:g}"


def planned_runs(campaign: Campaign) -> list[PlannedRun]:
    """Runs of a campaign file with `matrix` and `twin`, in the order of their names.

    A defect at a condition of the matrix replaces that run; a duplicate, and a defect at another
    condition, is one run more.
    """
    matrix = present(campaign.matrix, "matrix", "the campaign")
    twin = present(campaign.twin, "twin", "the campaign")
    conditions = itertools.product(
        campaign.oils,
        matrix.max_hertz_pressure_gpa,
        matrix.entrainment_speed_m_s,
        matrix.inlet_temperature_c,
    )
    runs = [PlannedRun(*condition) for condition in conditions]
    for defect in twin.defects:
        pressure, speed, temperature = defect.condition
        runs.append(PlannedRun(defect.oil, pressure, speed, temperature, defect.kind))
    # of two runs of one name the second counts
    by_name = {run.name: run for run in runs}
    return [by_name[name] for name in sorted(by_name)]


@dataclass(frozen=True)
class PlannedTorqueRun:
    """One simulated torque log: oil, set points and the defect planted in it, if any."""

    oil: str
    axial_load_n: float
    oil_temperature_c: float
    defect: str = ""

    @property
    def name(self) -> str:
        """File name of the log, which is also the run's name."""
        load, temperature = _digits(self.axial_load_n, 5), _digits(self.oil_temperature_c, 3)
        return f"{self.oil}_F{load}_T{temperature}.csv"


def planned_torque_runs(campaign: Campaign) -> list[PlannedTorqueRun]:
    """Torque logs of a campaign file with `torque` and its `twin`, in the order of their names."""
    torque = present(campaign.torque, "torque", "the campaign")
    matrix = present(torque.matrix, "matrix", "the campaign's `torque`")
    twin = present(torque.twin, "twin", "the campaign's `torque`")
    defects = {
        (defect.oil, defect.axial_load_n, defect.oil_temperature_c): defect.kind
        for defect in twin.defects
    }
    runs = [
        PlannedTorqueRun(*condition, defects.get(condition, ""))
        for condition in itertools.product(
            campaign.oils, matrix.axial_load_n, matrix.oil_temperature_c
        )
    ]
    return sorted(runs, key=lambda run: run.name)
