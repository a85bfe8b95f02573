"""The traction rig: a ball on a disc.

A step is a step of slip, rest is pure rolling, and mu = F/W is derived, then pressure and film.

Decides: how a traction log is curated.
"""

from collections.abc import Iterator, Mapping

import numpy as np
import pandas as pd

from oilfilm.curation import statistics
from oilfilm.curation.calibration import with_calibration
from oilfilm.curation.film_state import LEAST_LOAD_N, with_film
from oilfilm.curation.gate import TRACTION as NAME
from oilfilm.curation.gate import Channel, Columns, Finding, TractionLimits
from oilfilm.curation.hypotheses import Hypothesis, traction_hypotheses
from oilfilm.curation.plateaus import find_steps, settled_parts
from oilfilm.curation.rig_kind import Averaging, Division, RigKind, nothing
from oilfilm.curation.rolling import initial_slope
from oilfilm.curation.signals import Signals
from oilfilm.curation.standstill import phases_at_standstill, turns_steadily
from oilfilm.curation.zero import ZeroReference
from oilfilm.logs.log_kind import LogKind
from oilfilm.logs.traction_log import TRACTION
from oilfilm.settings.resolved import Settings
from oilfilm.units import FloatArray

# No rig that means to roll slides so much, and no sweep begins with a negative slip.
_ABSURD_SLIP = 0.5
# So many standard errors are no chance.
_SURE = 5
# Phases of pure rolling that a zero procedure needs.
_PHASES = {
    "rolling_phases": ("opening", "closing"),
    "opening_phase": ("opening",),
    "standstill": (),
    "already_removed": (),
}
_LOGGED = (
    "load_n",
    "traction_force_1_n",
    "traction_force_2_n",
    "inlet_temperature_c",
    "measured_film_thickness_um",
)


class TractionRig(RigKind):
    """See `RigKind`."""

    name = NAME
    logs: LogKind = TRACTION
    table = "points"
    sensor = Channel("traction_force_n", "traction force", "N")
    load = Channel("load_n", "load", "N")
    channels = (
        load,
        Channel("ball_speed_m_s", "ball speed", "m/s"),
        Channel("disc_speed_m_s", "disc speed", "m/s"),
        Channel("inlet_temperature_c", "inlet temperature", "degC"),
    )
    averaging = Averaging(
        means=(
            "slide_roll_ratio",
            "traction_force_n",
            "load_n",
            "entrainment_speed_m_s",
            "inlet_temperature_c",
        ),
        errors=("slide_roll_ratio", "traction_force_n", "load_n"),
        changes=("slide_roll_ratio", "traction_force_n", "load_n", "inlet_temperature_c"),
        transients=("slide_roll_ratio", "traction_force_n"),
    )
    words: Mapping[str, str] = {"sensor": sensor.name, "level": "slip", "rest": "pure rolling"}
    advice: Mapping[str, str] = {
        "truncated": "Repeat the run; the disk may have been full or the program killed.",
        "columns_disagree": "Look at the columns' units, the track radii of the rig file and the "
        "campaign file's semantics (slide_roll_ratio, slower_body); logged_twice of config.yaml "
        "says how far they may differ.",
        "zero_missing": "Begin and end every run with a few seconds of pure rolling. Where it "
        "did roll, check columns, units and signs of the speeds and the track radii of the rig. "
        "Readings at standstill give the zero where the campaign file says so (semantics: zero).",
        "zero_left": "Set semantics: zero of the campaign file to what gives the zero, as "
        "standstill or rolling_phases, or find out what holds a force there.",
    }
    carried: tuple[str, ...] = (
        "oil",
        "rig",
        "nominal_load_n",
        "nominal_entrainment_speed_m_s",
        "nominal_inlet_temperature_c",
    )
    keeps_refused_runs = True
    shown_signals: Mapping[str, str] = {
        "traction_force_n": "Traction\nforce (N)",
        "load_n": "Load (N)",
        "slide_roll_ratio": "Slide-roll\nratio S (1)",
        "inlet_temperature_c": "Inlet temp.\n(\N{DEGREE SIGN}C)",
    }

    def signals(self, samples: Columns, rig: str, settings: Settings) -> Signals:
        """Force and slip positive with the slower body slowed; S is NaN where nothing turns."""
        log = settings.campaign.semantics_for(rig)
        ball, disc = samples["ball_speed_m_s"], samples["disc_speed_m_s"]
        speed = (ball + disc) / 2
        sliding = log.direction * (disc - ball)
        slip = np.divide(sliding, speed, out=nothing(len(speed)), where=speed != 0)
        columns = {
            **{name: samples[name] for name in _LOGGED},
            "traction_force_n": log.traction_sign * log.direction * samples["traction_force_n"],
            "entrainment_speed_m_s": speed,
            "slide_roll_ratio": slip,
            "ball_speed_m_s": ball,
            "disc_speed_m_s": disc,
        }
        return Signals(samples["row"], samples["time_s"], columns)

    def usable(self, signals: Signals, settings: Settings) -> Signals:
        """The samples at which the rig turns, without ramps; at the others S has no value."""
        turning = turns_steadily(signals, settings.curation)
        return signals.where(np.isfinite(signals["slide_roll_ratio"]) & turning)

    def standstill(self, signals: Signals, settings: Settings) -> Mapping[str, slice]:
        """See `RigKind.standstill`."""
        return phases_at_standstill(signals, settings.curation)

    def zero_at_standstill(self, rig: str, settings: Settings) -> bool:
        """As the campaign file says."""
        return settings.campaign.semantics_for(rig).zero == "standstill"

    def divide(self, signals: Signals, rig: str, settings: Settings) -> Division:
        """Levels of slip; the first and the last of them are pure rolling."""
        levels = settings.curation.plateaus
        interval_s = signals.interval_s
        steps = find_steps(signals["slide_roll_ratio"], interval_s, levels.min_step, levels)
        starts, stops = settled_parts(len(signals), steps, interval_s, levels)
        # the opening phase gives the zero first; what is left of it is a plateau at no slip
        zero_rows = round(settings.curation.zero_reference.duration_s / interval_s)
        rest = {"opening": slice(0, 0), "closing": slice(0, 0)}
        if len(steps):
            rest["opening"] = slice(0, min(zero_rows, int(stops[0])))
            rest["closing"] = slice(int(starts[-1]), int(stops[-1]))
        needed = _PHASES[settings.campaign.semantics_for(rig).zero]
        phases = {name: rest[name] for name in needed}
        return Division(phases, starts, stops, slice(None))

    def phase_problem(
        self, signals: Signals, part: slice, name: str, settings: Settings
    ) -> Finding | None:
        """A phase that slides."""
        slip = float(np.mean(signals["slide_roll_ratio"][part]))
        limit = settings.curation.zero_reference.max_slide_roll_ratio
        if abs(slip) <= limit:
            return None
        wrong = slip < -limit or slip > _ABSURD_SLIP
        hint = "; such a slip may come from swapped speed columns or wrong track radii"
        return Finding(
            f"the {name} phase runs at a slide-roll ratio of {slip:.4f}; expected pure rolling, "
            f"within {limit}{hint if wrong else ''}"
        )

    def zero_fault(
        self, rest: Mapping[str, Signals], plateaus: Columns, rig: str, settings: Settings
    ) -> tuple[str, Finding] | None:
        """A phase taken for pure rolling that is part of the curve, or a force without slip."""
        limits = settings.curation.zero_reference
        if settings.campaign.semantics_for(rig).zero == "already_removed":
            return _left_without_slip(plateaus, limits.max_drift_n)
        slips, mu = plateaus["slide_roll_ratio"], plateaus["traction_coefficient"]
        largest = float(np.nanmax(np.abs(mu), initial=0.0))
        for name, phase in rest.items():
            values = phase["slide_roll_ratio"][np.newaxis]
            inside = np.ones(values.shape, dtype=bool)
            mean = statistics.means(values, inside)
            slip = float(mean[0])
            if abs(slip) <= _SURE * float(statistics.standard_errors(values, inside, mean)[0]):
                continue
            slope = initial_slope(slips, mu, slip)
            swallowed = abs(slope * slip)
            if swallowed > limits.max_traction_share * largest:
                return "zero_missing", Finding(
                    f"the {name} phase is not pure rolling: its slide-roll ratio is {slip:.4f}. "
                    f"By the initial slope of the run ({slope:.3g}) its traction coefficient is "
                    f"{swallowed:.2g}, {swallowed / largest:.0%} of the largest one; allowed "
                    f"{limits.max_traction_share:.0%}"
                )
        return None

    def standstill_fault(
        self, still: Mapping[str, ZeroReference], rig: str, settings: Settings
    ) -> tuple[str, Finding] | None:
        """A force at standstill although the rig is said to have removed its zero."""
        if settings.campaign.semantics_for(rig).zero != "already_removed":
            return None
        allowed_n = settings.curation.zero_reference.max_drift_n
        for name, zero in still.items():
            force_n, error_n = float(zero.output[0]), float(zero.output_se[0])
            if abs(force_n) > allowed_n + _SURE * error_n:
                return _left(force_n, f"in the {name} phase of standstill", allowed_n)
        return None

    def standstill_hint(
        self, still: Mapping[str, ZeroReference], rig: str, settings: Settings
    ) -> str:
        """See `RigKind.standstill_hint`."""
        if "opening" not in still:
            return ""
        when = {"opening": "before", "closing": "after"}
        forces = " and ".join(
            f"{zero.output[0]:.3g} N {when[name]} the run" for name, zero in still.items()
        )
        setting = "semantics: {zero: standstill}"
        if rig in settings.campaign.semantics_of_rig:
            setting = f"semantics_of_rig: {{{rig}: {{zero: standstill}}}}"
        return (
            f". The rig stands still, with a force of {forces}. Where no load is held sideways "
            f"there, that is the zero: write `{setting}` into the campaign's file in "
            "config/campaigns"
        )

    def derive(self, averages: Columns, zero: FloatArray, zero_se: FloatArray) -> Columns:
        """Traction force above the zero, mu = F/W and its standard error."""
        unknown = nothing(len(zero))
        force_n = averages["traction_force_n"] - zero
        load = np.where(averages["load_n"] > LEAST_LOAD_N, averages["load_n"], np.nan)
        mu = force_n / load
        force_se_n = np.hypot(averages["traction_force_n_se"], zero_se)
        kept = ("first_row", "last_row", "n_samples", "n_spikes", "time_s", "duration_s")
        return {
            **{name: averages[name] for name in (*kept, *self.averaging.means)},
            "force_asymmetry": _asymmetry(averages),
            "measured_film_thickness_um": averages.get("measured_film_thickness_um", unknown),
            "slide_roll_ratio_se": averages["slide_roll_ratio_se"],
            "slip_change": averages["slide_roll_ratio_change"],
            "slip_transient": averages["slide_roll_ratio_transient"],
            "traction_force_n": force_n,
            "traction_coefficient": mu,
            "traction_coefficient_se": np.hypot(force_se_n, mu * averages["load_n_se"]) / load,
            "traction_change": averages["traction_force_n_change"] / load,
            "traction_transient": averages["traction_force_n_transient"] / load,
            "load_change": averages["load_n_change"] / load,
            "temperature_change_c": averages["inlet_temperature_c_change"],
        }

    def complete(self, points: pd.DataFrame, settings: Settings) -> pd.DataFrame:
        """With contact pressure, film, lambda and the calibration of the rig's sensors."""
        return with_calibration(with_film(points, settings), settings.rigs)

    def hypotheses(self, rig: str, settings: Settings) -> Iterator[Hypothesis]:
        """See `RigKind.hypotheses`."""
        return traction_hypotheses(settings.rigs[rig])

    def limits(self, settings: Settings) -> TractionLimits:
        """See `RigKind.limits`."""
        curation, campaign = settings.curation, settings.campaign
        unjudged = campaign.film_unjudged
        return TractionLimits(
            signals=settings.gates,
            stuck=curation.stuck,
            min_duration_s=curation.plateaus.min_duration_s,
            zero_min_duration_s=curation.zero_reference.min_duration_s,
            zero_drift_max=curation.zero_reference.max_drift_n,
            faulty_share_max=settings.gates.faulty_share_max,
            gates=settings.gates,
            transient_share=curation.plateaus.transient_share,
            rolling_slip_max=curation.zero_reference.max_slide_roll_ratio,
            planned_slips=campaign.set_points.slide_roll_ratio or (),
            accept_unjudged_film=unjudged is not None and unjudged.accept,
        )

    def repeats(self, settings: Settings) -> tuple[str, ...]:
        """Copies, names given twice, and conditions, unless the campaign declares repeats."""
        copies = ("duplicate_log", "conflicting_labels", "repeated_label")
        accepted = settings.campaign.repeated_conditions == "accept"
        return copies if accepted else (*copies, "conflicting_condition", "duplicate_condition")


TRACTION_RIG = TractionRig()


def _left_without_slip(plateaus: Columns, allowed_n: float) -> tuple[str, Finding] | None:
    """A force on plateaus whose slip is none within its error; see `_left`."""
    rolling = np.abs(plateaus["slide_roll_ratio"]) <= _SURE * plateaus["slide_roll_ratio_se"]
    force_n = plateaus["traction_force_n"]
    error_n = plateaus["traction_coefficient_se"] * plateaus["load_n"]
    off = force_n[rolling & (np.abs(force_n) > allowed_n + _SURE * error_n)]
    return _left(float(off[0]), "without slip", allowed_n) if len(off) else None


def _left(force_n: float, where: str, allowed_n: float) -> tuple[str, Finding]:
    """The refusal of a run whose zero its rig is said to have removed, and has not."""
    return "zero_left", Finding(
        f"the traction force is {force_n:.3g} N {where}, but semantics: zero is already_removed; "
        f"allowed {allowed_n:g} N"
    )


def _asymmetry(averages: Columns) -> FloatArray:
    """|TF1 + TF2| over |TF1| + |TF2| of a rig that logs the force of either direction of slip."""
    unknown = nothing(len(averages["time_s"]))
    if "traction_force_1_n" not in averages:
        return unknown
    first, second = averages["traction_force_1_n"], averages["traction_force_2_n"]
    both = np.abs(first) + np.abs(second)
    return np.divide(np.abs(first + second), both, out=unknown, where=both > 0)
