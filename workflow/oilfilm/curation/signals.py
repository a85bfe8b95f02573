"""The signals of one run, as arrays over its samples."""

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
import pandas as pd

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

    @classmethod
    def of(cls, samples: pd.DataFrame) -> "Signals":
        """Signals of the samples of one run."""
        return cls(**{name: samples[name].to_numpy() for name in cls.__dataclass_fields__})

    @property
    def entrainment_speed_m_s(self) -> FloatArray:
        """U = (U_ball + U_disc)/2."""
        return (self.ball_speed_m_s + self.disc_speed_m_s) / 2

    @property
    def slide_roll_ratio(self) -> FloatArray:
        """S = (U_disc - U_ball)/U: positive with the ball slowed. NaN where nothing turns."""
        speed = self.entrainment_speed_m_s
        sliding = self.disc_speed_m_s - self.ball_speed_m_s
        return np.divide(sliding, speed, out=np.full_like(speed, np.nan), where=speed != 0)

    def __len__(self) -> int:
        return len(self.row)
