"""The tests that a rig can run: within its limits and its sensors, with a full film.

Decides: for which rig tests are planned; which tests the rig can run.
"""

from dataclasses import dataclass

import numpy as np

from oilfilm.base.errors import OilfilmError
from oilfilm.base.ties import exceeds, reaches
from oilfilm.base.units import BoolArray, FloatArray, IndexArray
from oilfilm.physics.contact import Contact
from oilfilm.physics.film import contact_film
from oilfilm.settings.resolved import Settings
from oilfilm.settings.rig import Calibration, FullScale, Rig, RigLimits
from oilfilm.torque.operating_grid import OilFilm

# Smallest number of slips of a test, as many as a curve has coefficients.
_FEWEST_SLIPS = 3


@dataclass(frozen=True)
class PlannedRig:
    """The rig on which the next tests are run.

    Attributes:
        name: Name of its file in `config/rigs`.
        limits: Its limits.
        full_scale: Full scale of its sensors, if it is stated.
        calibration: Calibration of its sensors, if it is stated.
        contact: Its contact.
    """

    name: str
    limits: RigLimits
    full_scale: FullScale | None
    calibration: Calibration | None
    contact: Contact

    @classmethod
    def from_settings(cls, settings: Settings) -> "PlannedRig":
        """The only rig of a campaign, or its only rig with limits.

        Raises:
            OilfilmError: There are several such rigs, or the contact or the limits are not known.
        """
        name, rig = _only_rig(settings)
        contact = rig.contact()
        if contact is None or np.isnan(contact.roughness_rq_m):
            raise OilfilmError(
                f"config/rigs/{name}.yaml: lacks the contact (`ball_radius_m`, `ball`, `disc`, "
                "roughness), without which neither load nor film of a test is known. Add it."
            )
        if rig.limits is None:
            raise OilfilmError(
                f"config/rigs/{name}.yaml: lacks the key `limits`, which a plan needs. Write the "
                "highest max_hertz_pressure_gpa, entrainment_speed_m_s, inlet_temperature_c and "
                "slide_roll_ratio at which the rig can run."
            )
        return cls(name, rig.limits, rig.full_scale, rig.calibration, contact)


def _only_rig(settings: Settings) -> tuple[str, Rig]:
    """Name and file of the rig of the next tests."""
    rigs = settings.rigs
    rigs_with_limits = [name for name, rig in rigs.items() if rig.limits is not None]
    if len(rigs_with_limits) == 1:
        name = rigs_with_limits[0]
    elif len(rigs) == 1:
        name = next(iter(rigs))
    else:
        raise OilfilmError(
            f"the campaign has the rigs {', '.join(rigs)}; {len(rigs_with_limits)} of them have "
            "`limits`. A plan is for one rig: write `limits` in the file of that rig alone "
            "(config/rigs)."
        )
    return name, rigs[name]


@dataclass(frozen=True)
class JudgedTests:
    """Tests, and what the rig does not reach of them.

    Attributes:
        load_n: Load of each test, shape (tests,).
        slip: Slips of a test in ascending order, shape (slips,).
        is_reached: Which slips the rig reaches at the speed of the test, shape (tests, slips).
        lambda_ratio: lambda at these slips, shape (tests, slips); NaN where it is not known.
        is_beyond_by_limit: Which tests are beyond a limit, by the limit in words, each of shape
            (tests,).
    """

    load_n: FloatArray
    slip: FloatArray
    is_reached: BoolArray
    lambda_ratio: FloatArray
    is_beyond_by_limit: dict[str, BoolArray]

    @property
    def is_feasible(self) -> BoolArray:
        """Which tests the rig can run, shape (tests,)."""
        return ~np.any(list(self.is_beyond_by_limit.values()), axis=0)

    @property
    def left_out_count_by_limit(self) -> dict[str, int]:
        """Number of tests that cannot be run, by the first limit that a test is beyond."""
        count_by_limit = {}
        not_counted = np.ones(len(self.load_n), dtype=bool)
        for limit, is_beyond in self.is_beyond_by_limit.items():
            count_by_limit[limit] = int((not_counted & is_beyond).sum())
            not_counted &= ~is_beyond
        return count_by_limit

    @property
    def _index_of_last_reached(self) -> tuple[IndexArray, IndexArray]:
        """Row and column of the largest slip that each test reaches, as an index of arrays."""
        slips_from_end = np.argmax(self.is_reached[:, ::-1], axis=1)
        slip_index = len(self.slip) - 1 - slips_from_end
        return np.arange(len(slip_index)), slip_index

    @property
    def largest_slip(self) -> FloatArray:
        """Largest slip of each test that can be run, shape (tests,)."""
        _, slip_index = self._index_of_last_reached
        return self.slip[slip_index]

    @property
    def smallest_lambda(self) -> FloatArray:
        """lambda of each test at its largest slip, where the film is thinnest, shape (tests,)."""
        return self.lambda_ratio[self._index_of_last_reached]


def limits_with_counts(left_out_count_by_limit: dict[str, int]) -> str:
    """Limits with the number of tests beyond each, as in `the rig's largest speed (12)`."""
    return ", ".join(
        f"{limit} ({count})" for limit, count in left_out_count_by_limit.items() if count
    )


def judge_tests(
    rig: PlannedRig,
    film: OilFilm | None,
    lambda_limit: float,
    conditions: FloatArray,
    slip: FloatArray,
    mu: FloatArray,
) -> JudgedTests:
    """Judge tests by the limits and sensors of the rig, and by the film.

    A test has those slips that the rig and its speed sensor reach.

    Args:
        rig: The rig.
        film: Film of the oil in its contact; None where the properties of the oil are not known.
            Then no film is judged.
        lambda_limit: A film is full above this ratio.
        conditions: P in GPa, U in m/s and T in degC of each test, shape (tests, 3).
        slip: Slips of a test in ascending order, shape (slips,).
        mu: Expected traction coefficient, of a shape that broadcasts with (tests, slips).
    """
    pressure_gpa, speed_m_s, temperature_c = conditions.T
    load_n = rig.contact.load_n(pressure_gpa)
    shape_of_tests_and_slips = (len(conditions), len(slip))
    is_reached = np.broadcast_to(
        reaches(rig.limits.slide_roll_ratio, slip), shape_of_tests_and_slips
    ).copy()
    lambda_ratio = np.full(shape_of_tests_and_slips, np.nan)
    if film is not None:
        _, lambda_ratio = contact_film(
            film.oil,
            film.contact,
            film.film_kind,
            load_n=load_n[:, np.newaxis],
            entrainment_speed_m_s=speed_m_s[:, np.newaxis],
            inlet_temperature_c=temperature_c[:, np.newaxis],
            slide_roll_ratio=slip,
        )
    # in the order of the message
    is_beyond_by_limit: dict[str, BoolArray] = {
        "the rig's largest pressure": exceeds(pressure_gpa, rig.limits.max_hertz_pressure_gpa),
        "the rig's largest speed": exceeds(speed_m_s, rig.limits.entrainment_speed_m_s),
        "the rig's highest temperature": exceeds(temperature_c, rig.limits.inlet_temperature_c),
    }
    full_scale = rig.full_scale
    if full_scale is not None:
        faster_surface_m_s = speed_m_s[:, np.newaxis] * (1 + slip / 2)
        if "surface_speed_m_s" not in full_scale.assumed:
            is_reached &= reaches(full_scale.surface_speed_m_s, faster_surface_m_s)
        force_n = load_n[:, np.newaxis] * mu
        largest_force_n = np.where(is_reached, force_n, 0.0).max(axis=1)
        is_beyond_by_full_scale_key = {
            "load_n": ("load", exceeds(load_n, full_scale.load_n)),
            "traction_force_n": ("force", exceeds(largest_force_n, full_scale.traction_force_n)),
            "temperature_c": ("temperature", exceeds(temperature_c, full_scale.temperature_c)),
        }
        for key, (sensor, is_beyond_full_scale) in is_beyond_by_full_scale_key.items():
            # an assumed full scale must not contradict limits that are stated
            if key not in full_scale.assumed:
                is_beyond_by_limit[f"the {sensor} sensor's full scale"] = is_beyond_full_scale
    reached_slip_count = is_reached.sum(axis=1)
    smallest_load_n = rig.limits.smallest_load_n or 0.0
    is_beyond_by_limit |= {
        "the rig's smallest load": exceeds(smallest_load_n, load_n),
        "slips that the rig reaches at this speed": np.asarray(reached_slip_count < _FEWEST_SLIPS),
    }
    if film is not None:
        # a film that the formula does not give need not be thin
        is_unknown = is_reached & np.isnan(lambda_ratio)
        is_thin = is_reached & ~exceeds(lambda_ratio, lambda_limit) & ~is_unknown
        is_beyond_by_limit[f"a full film (lambda > {lambda_limit:g})"] = np.asarray(
            is_thin.any(axis=1)
        )
        is_beyond_by_limit["a film within the range of the formula"] = np.asarray(
            is_unknown.any(axis=1)
        )
    return JudgedTests(load_n, slip, is_reached, lambda_ratio, is_beyond_by_limit)
