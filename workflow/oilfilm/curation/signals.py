"""The signals of one run, as arrays over its samples."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import pandas as pd

from oilfilm.semantics import Semantics

FloatArray = npt.NDArray[np.float64]
IndexArray = npt.NDArray[np.int64]


@dataclass(frozen=True)
class Signals:
    """One run's samples: every array has one value a sample, SI units."""

    row: IndexArray
    time_s: FloatArray
    load_n: FloatArray
    traction_force_n: FloatArray
    traction_force_1_n: FloatArray
    traction_force_2_n: FloatArray
    ball_speed_m_s: FloatArray
    disc_speed_m_s: FloatArray
    inlet_temperature_c: FloatArray
    film_thickness_um: FloatArray
    direction: int = 1

    @classmethod
    def of(cls, samples: pd.DataFrame, log: Semantics) -> "Signals":
        """Signals of the samples of one run, force and slip positive with the slower body slowed.

        Args:
            samples: Rows of the table of samples.
            log: How the rig's logs are meant.
        """
        names = [name for name in cls.__dataclass_fields__ if name != "direction"]
        arrays = {name: samples[name].to_numpy() for name in names}
        arrays["traction_force_n"] = log.traction_sign * log.direction * arrays["traction_force_n"]
        return cls(**arrays, direction=log.direction)

    @property
    def entrainment_speed_m_s(self) -> FloatArray:
        """U = (U_ball + U_disc)/2."""
        return (self.ball_speed_m_s + self.disc_speed_m_s) / 2

    @property
    def slide_roll_ratio(self) -> FloatArray:
        """S = (faster - slower speed)/U, the slower body being the one that the rig slows.

        NaN where nothing turns.
        """
        speed = self.entrainment_speed_m_s
        sliding = self.direction * (self.disc_speed_m_s - self.ball_speed_m_s)
        return np.divide(sliding, speed, out=np.full_like(speed, np.nan), where=speed != 0)

    def __len__(self) -> int:
        return len(self.row)
