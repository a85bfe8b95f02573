"""What is known of the runs of an oil before their surface is searched.

The tables `surfaces` and `surface_sizes` hold it, because a surface from them must rest on it too.

Decides: which sizes of errors are expected where rigs state some of them.
"""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import pandas as pd

from oilfilm.settings.config import SameConditionSettings
from oilfilm.settings.rig import Rig
from oilfilm.surface.effects import RunErrorSizes
from oilfilm.surface.measurements import LevelWidths

# Entry of the column `search` in the rows of sizes that were expected before the data.
_EXPECTED = "expected"
# Keys of a rig's `errors_between_runs`, by the attribute of `RunErrorSizes` that they state.
_KEY_OF_SIZE = {
    "gain": "traction_force_relative",
    "zero": "zero_as_traction_coefficient",
    "slip_scale": "slip_relative",
    "temperature_k": "inlet_temperature_k",
    "noise": "noise_of_points_relative",
}
# Attribute of `RunErrorSizes` for the difference of rigs, which their calibration states.
_RIG_GAIN = "rig_gain"


@dataclass(frozen=True)
class RunAssumptions:
    """What is known of the runs of an oil before their surface is searched.

    Attributes:
        level_widths: Largest range of the measured values of one level.
        errors: Expected sizes of the errors of runs and points.
        usual_errors: Names of the sizes that no rig states, so that they are those of usual rigs.
        rig_of_runs: Rig of each accepted run, in the order of the names of the runs. One name where
            all are of one rig; None where the data name no rigs.
    """

    level_widths: LevelWidths = field(default_factory=LevelWidths)
    errors: RunErrorSizes = field(default_factory=RunErrorSizes)
    usual_errors: tuple[str, ...] = tuple(_KEY_OF_SIZE)
    rig_of_runs: tuple[str, ...] | None = None

    @classmethod
    def from_settings(
        cls,
        same_condition: SameConditionSettings,
        rigs: Collection[Rig],
        rig_of_runs: Sequence[str] | None = None,
    ) -> "RunAssumptions":
        """The assumptions of a campaign.

        Args:
            same_condition: Config's `same_condition`.
            rigs: Its rigs. Of several ones the mean square of an error counts.
            rig_of_runs: As the attribute.
        """
        usual = RunErrorSizes()
        expected, not_stated = {}, []
        for size, key in _KEY_OF_SIZE.items():
            stated = [getattr(rig.errors_between_runs, key, None) for rig in rigs]
            if not stated or None in stated:
                not_stated.append(size)
            usual_size = getattr(usual, size).median
            sizes_of_rigs = [usual_size if value is None else value for value in stated]
            if sizes_of_rigs:
                expected[size] = float(np.sqrt(np.mean(np.square(sizes_of_rigs))))
        if rig_of_runs is None:
            return cls(
                _widths_of(same_condition), _errors_with_medians(expected), tuple(not_stated)
            )
        if len(set(rig_of_runs)) > 1:
            gains = [_gain_by_calibration(rig) for rig in rigs]
            known_gains = [gain for gain in gains if gain is not None]
            if rigs and len(known_gains) == len(rigs):
                expected[_RIG_GAIN] = float(np.sqrt(np.mean(np.square(known_gains))))
            else:
                not_stated.append(_RIG_GAIN)
        errors = _errors_with_medians(expected)
        return cls(_widths_of(same_condition), errors, tuple(not_stated), tuple(rig_of_runs))

    @classmethod
    def from_tables(cls, row: Mapping[str, Any], sizes: pd.DataFrame) -> "RunAssumptions":
        """The assumptions of a surface.

        Args:
            row: The oil's row of the table `surfaces`.
            sizes: Its rows of the table `surface_sizes`.
        """
        expected_logarithms = sizes[sizes["search"] == _EXPECTED].set_index("size")["logarithm"]
        widths = LevelWidths(
            row["level_width_pressure"], row["level_width_speed"], row["level_width_temperature_k"]
        )
        rig_names = row["rig_of_runs"]
        return cls(
            widths,
            _errors_with_medians(np.exp(expected_logarithms).to_dict()),
            tuple(row["usual_errors"]),
            None if rig_names is None else tuple(rig_names),
        )

    @property
    def rigs(self) -> tuple[str, ...]:
        """Names of the rigs, in the order of their numbers; empty where the data name none."""
        return tuple(sorted(set(self.rig_of_runs or ())))

    def columns(self) -> dict[str, Any]:
        """Columns of the table `surfaces`."""
        return {
            "level_width_pressure": self.level_widths.pressure,
            "level_width_speed": self.level_widths.speed,
            "level_width_temperature_k": self.level_widths.temperature_k,
            "usual_errors": list(self.usual_errors),
            "rig_of_runs": None if self.rig_of_runs is None else list(self.rig_of_runs),
        }

    def size_rows(self, oil: str) -> list[dict[str, Any]]:
        """Rows of the table `surface_sizes`."""
        rows = []
        rig_size_names = [_RIG_GAIN] if len(self.rigs) > 1 else []
        for size in [*_KEY_OF_SIZE, *rig_size_names]:
            logarithm = float(np.log(getattr(self.errors, size).median))
            rows.append({"oil": oil, "search": _EXPECTED, "size": size, "logarithm": logarithm})
        return rows


def _widths_of(same_condition: SameConditionSettings) -> LevelWidths:
    """Largest range of the values of one level, from the configuration."""
    return LevelWidths(
        pressure=same_condition.max_hertz_pressure,
        speed=same_condition.entrainment_speed,
        temperature_k=same_condition.inlet_temperature_c,
    )


def _gain_by_calibration(rig: Rig) -> float | None:
    """Standard uncertainty of mu by the calibration of a rig, relative; None if it is not known.

    It is that of the traction force and of the load, of which mu is the ratio.
    """
    if rig.calibration is None:
        return None
    return float(np.hypot(rig.calibration.traction_force_relative, rig.calibration.load_relative))


def _errors_with_medians(medians: Mapping[str, float]) -> RunErrorSizes:
    """Usual sizes of errors, with other medians by their names."""
    usual = RunErrorSizes()
    return replace(
        usual,
        **{size: replace(getattr(usual, size), median=value) for size, value in medians.items()},
    )
