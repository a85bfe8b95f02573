"""The runs of a simulated campaign, and the defects planted in some of them.

The Snakefile reads the names of the runs.

Decides: which runs a simulated campaign has.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product

from oilfilm.settings.base import required_value
from oilfilm.settings.campaign import Campaign

# Planted defect -> the gate or rule that must catch it.
GATE_OF_DEFECT = {
    "truncated": "truncated",
    "swapped_sign": "swapped_sign",
    "stuck_sensor": "stuck_sensor",
    "wrong_units": "load_off_nominal",
    "thin_film": "thin_film",
    "duplicate": "duplicate_condition",
}
# Letter of a set point in file names, and its digits before the decimal point. The pressure has 0:
# it has two decimals or more instead.
_NAME_FORMATS = {
    "max_hertz_pressure_gpa": ("P", 0),
    "entrainment_speed_m_s": ("U", 2),
    "inlet_temperature_c": ("T", 3),
    "axial_load_n": ("F", 5),
    "oil_temperature_c": ("T", 3),
}


@dataclass(frozen=True)
class SimulatedRun:
    """One run to be simulated.

    Attributes:
        oil: Name of the oil.
        set_points: Level of each set point, by its name.
        defect: Planted defect, by the key `kind` of the campaign file; empty for a sound run.
    """

    oil: str
    set_points: Mapping[str, float]
    defect: str = ""

    @property
    def name(self) -> str:
        """File name of the run's log, which is also the run's name."""
        suffix = "_again" if self.defect == "duplicate" else ""
        level_texts = [_level_in_name(name, level) for name, level in self.set_points.items()]
        return "_".join([self.oil, *level_texts]) + f"{suffix}.csv"


def _level_in_name(set_point: str, level: float) -> str:
    """A level with leading zeros, so that names sort, and with decimals where it has any."""
    letter, digits = _NAME_FORMATS[set_point]
    if digits == 0 and level == round(level, 2):
        return f"{letter}{level:.2f}"
    if digits > 0 and level == round(level):
        return f"{letter}{level:0{digits}.0f}"
    # all digits, so that no two levels have one name
    return f"{letter}{level}"


def simulated_runs(campaign: Campaign) -> list[SimulatedRun]:
    """Runs of a campaign file with `matrix` and `twin`, in the order of their names."""
    levels_of_matrix = required_value(campaign.matrix, "matrix", "the campaign").model_dump()
    twin = required_value(campaign.twin, "twin", "the campaign")
    # the levels of `condition` are in the order of the matrix: pressure, speed, temperature
    defective_runs = [
        SimulatedRun(
            defect.oil, dict(zip(levels_of_matrix, defect.condition, strict=True)), defect.kind
        )
        for defect in twin.defects
    ]
    return _runs_of_matrix(campaign.oils, levels_of_matrix, defective_runs)


def simulated_torque_runs(campaign: Campaign) -> list[SimulatedRun]:
    """Torque logs of a campaign file with `torque` and its `twin`, in the order of their names."""
    torque = required_value(campaign.torque, "torque", "the campaign")
    matrix = required_value(torque.matrix, "matrix", "the campaign's `torque`")
    twin = required_value(torque.twin, "twin", "the campaign's `torque`")
    set_point_names = ("axial_load_n", "oil_temperature_c")
    defective_runs = [
        SimulatedRun(
            defect.oil, {name: getattr(defect, name) for name in set_point_names}, defect.kind
        )
        for defect in twin.defects
    ]
    return _runs_of_matrix(
        campaign.oils, {name: getattr(matrix, name) for name in set_point_names}, defective_runs
    )


def _runs_of_matrix(
    oils: Sequence[str],
    levels_of_matrix: Mapping[str, Sequence[float]],
    defective_runs: Iterable[SimulatedRun],
) -> list[SimulatedRun]:
    """Runs of every oil at every condition of a matrix.

    A defect at a condition of the matrix replaces that run. A duplicate, or a defect at another
    condition, adds a run.
    """
    runs = [
        SimulatedRun(oil, dict(zip(levels_of_matrix, condition, strict=True)))
        for oil in oils
        for condition in product(*levels_of_matrix.values())
    ]
    # different conditions have different names, so that a defect replaces the run of its condition
    run_by_name = {run.name: run for run in runs}
    for run in defective_runs:
        # an oil may be left out of the campaign
        if run.oil in oils:
            run_by_name[run.name] = run
    return [run_by_name[name] for name in sorted(run_by_name)]
