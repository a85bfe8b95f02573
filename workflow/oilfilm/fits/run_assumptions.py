"""What is known of the runs of an oil before their surface is searched.

The tables `surfaces` and `surface_sizes` hold it too, so that a surface that is read from them
rests on the same assumptions.

Decides: which sizes of errors are expected where rigs state some of them.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields, replace
from typing import Any

import numpy as np
import pandas as pd

from oilfilm.settings.config import SameConditionSettings
from oilfilm.settings.rig import Rig
from oilfilm.surface.effects import ErrorPriors
from oilfilm.surface.measurements import LevelWidths

# Entry of the column `search` in the rows of sizes that were expected before the data.
_EXPECTED = "expected"
# Keys of a rig's `errors_between_runs`, by the attribute of `ErrorPriors` that they state.
_KEY_OF_SIZE = {
    "gain": "traction_force_relative",
    "zero": "zero_as_traction_coefficient",
    "slip_scale": "slip_relative",
    "temperature_k": "inlet_temperature_k",
    "noise": "noise_of_points_relative",
}
# Attribute of `ErrorPriors` for the difference of rigs, which their calibration states.
_RIG_GAIN = "rig_gain"


@dataclass(frozen=True)
class RunAssumptions:
    """What is known of the runs of an oil before their surface is searched.

    Attributes:
        level_widths: Largest range of the measured values of one level.
        error_sizes: Expected sizes of the errors of runs and points.
        usual_error_names: Names of the sizes that at least one rig does not state. The usual size
            replaces each missing one.
        rig_name_of_run: Name of the rig of each accepted run, in the order of the names of the
            runs. A tuple of one name where all runs are of one rig; None where the data name no
            rigs.
    """

    level_widths: LevelWidths = field(default_factory=LevelWidths)
    error_sizes: ErrorPriors = field(default_factory=ErrorPriors)
    usual_error_names: tuple[str, ...] = tuple(_KEY_OF_SIZE)
    rig_name_of_run: tuple[str, ...] | None = None

    @classmethod
    def from_settings(
        cls,
        same_condition: SameConditionSettings,
        rigs: Mapping[str, Rig],
        rig_name_of_run: Sequence[str] | None = None,
    ) -> "RunAssumptions":
        """The assumptions of a campaign.

        Args:
            same_condition: Config's `same_condition`.
            rigs: Its rigs by name. Those of the runs count; of several, the root mean square of
                an error.
            rig_name_of_run: As the attribute.
        """
        usual_errors = ErrorPriors()
        rigs_of_runs = [
            rig for name, rig in rigs.items() if rig_name_of_run is None or name in rig_name_of_run
        ]
        stated_sizes_by_name = {
            size_name: [getattr(rig.errors_between_runs, key, None) for rig in rigs_of_runs]
            for size_name, key in _KEY_OF_SIZE.items()
        }
        if len(set(rig_name_of_run or ())) > 1:
            stated_sizes_by_name[_RIG_GAIN] = [_gain_by_calibration(rig) for rig in rigs_of_runs]
        expected_sizes, names_not_stated = {}, []
        for size_name, stated_sizes in stated_sizes_by_name.items():
            if not stated_sizes or None in stated_sizes:
                names_not_stated.append(size_name)
            usual_size = getattr(usual_errors, size_name).median
            sizes_of_rigs = [usual_size if value is None else value for value in stated_sizes]
            if sizes_of_rigs:
                expected_sizes[size_name] = float(np.sqrt(np.mean(np.square(sizes_of_rigs))))
        return cls(
            level_widths_of(same_condition),
            _errors_with_medians(expected_sizes),
            tuple(names_not_stated),
            None if rig_name_of_run is None else tuple(rig_name_of_run),
        )

    @classmethod
    def from_tables(
        cls, surface_row: Mapping[str, Any], size_rows: pd.DataFrame
    ) -> "RunAssumptions":
        """The assumptions of a surface.

        Args:
            surface_row: The oil's row of the table `surfaces`.
            size_rows: Its rows of the table `surface_sizes`.
        """
        expected_logarithms = size_rows[size_rows["search"] == _EXPECTED].set_index("size")[
            "logarithm"
        ]
        widths = LevelWidths(
            surface_row["level_width_pressure"],
            surface_row["level_width_speed"],
            surface_row["level_width_temperature_k"],
        )
        rig_names = surface_row["rig_of_runs"]
        return cls(
            widths,
            _errors_with_medians(np.exp(expected_logarithms).to_dict()),
            tuple(surface_row["usual_errors"]),
            None if rig_names is None else tuple(rig_names),
        )

    def joined(self, other: "RunAssumptions") -> "RunAssumptions":
        """What is known of the runs of two oils together.

        The narrower range of a level counts, and the root mean square of an error, as for several
        rigs. The rigs of the runs are left out: the other oil has other runs.

        Args:
            other: The assumptions of the other oil.
        """
        widths = {
            width_field.name: min(
                getattr(self.level_widths, width_field.name),
                getattr(other.level_widths, width_field.name),
            )
            for width_field in fields(LevelWidths)
        }
        medians = {}
        for size_field in fields(ErrorPriors):
            joined_sizes = [
                getattr(assumptions.error_sizes, size_field.name).median
                for assumptions in (self, other)
            ]
            medians[size_field.name] = float(np.sqrt(np.mean(np.square(joined_sizes))))
        # equal errors keep their last digit
        are_equal = self.error_sizes == other.error_sizes
        return RunAssumptions(
            LevelWidths(**widths),
            self.error_sizes if are_equal else _errors_with_medians(medians),
            tuple(dict.fromkeys([*self.usual_error_names, *other.usual_error_names])),
        )

    @property
    def rig_names(self) -> tuple[str, ...]:
        """Names of the rigs, sorted by name; the index is the rig's number.

        Empty where the data name no rigs.
        """
        return tuple(sorted(set(self.rig_name_of_run or ())))

    def surface_columns(self) -> dict[str, Any]:
        """The assumptions as columns of the table `surfaces`."""
        return {
            "level_width_pressure": self.level_widths.pressure,
            "level_width_speed": self.level_widths.speed,
            "level_width_temperature_k": self.level_widths.temperature_k,
            "usual_errors": list(self.usual_error_names),
            "rig_of_runs": None if self.rig_name_of_run is None else list(self.rig_name_of_run),
        }

    def size_rows(self, oil: str) -> list[dict[str, Any]]:
        """The expected sizes as rows of the table `surface_sizes`."""
        rows = []
        rig_size_names = [_RIG_GAIN] if len(self.rig_names) > 1 else []
        for size_name in [*_KEY_OF_SIZE, *rig_size_names]:
            logarithm = float(np.log(getattr(self.error_sizes, size_name).median))
            rows.append(
                {"oil": oil, "search": _EXPECTED, "size": size_name, "logarithm": logarithm}
            )
        return rows


def level_widths_of(same_condition: SameConditionSettings) -> LevelWidths:
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


def _errors_with_medians(medians: Mapping[str, float]) -> ErrorPriors:
    """Usual sizes of errors, with other medians by their names.

    A calibration may be better or worse than every difference of rigs that is searched, and a size
    at a limit is rounded in its table. The median is then the nearest limit.
    """
    usual_errors = ErrorPriors()
    changed_errors = {}
    for size_name, median in medians.items():
        usual_error = getattr(usual_errors, size_name)
        nearest_median = float(np.clip(median, usual_error.smallest, usual_error.largest))
        changed_errors[size_name] = replace(usual_error, median=nearest_median)
    return replace(usual_errors, **changed_errors)
