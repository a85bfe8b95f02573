"""The keys of config/config.yaml: what to run, and every threshold.

Decides: name, unit, range and meaning of the keys of `config/config.yaml`.
"""

from typing import Annotated, Any, Literal, Self

from pydantic import BeforeValidator, Field, model_validator

from oilfilm.bearing.inputs import UncertainInput
from oilfilm.settings import quantities as q
from oilfilm.settings.base import Group, OneOf, key, key_error_at
from oilfilm.settings.ranges import refuse_outside_ranges, uncertain_inputs_of_all_bearings
from oilfilm.traction import LAW_NAMES, LAWS, reason_for_comparison_only


def _refuse_compared_only(law_name: Any) -> Any:
    """Refuse a law that is compared only, with the reason."""
    reason = reason_for_comparison_only(str(law_name))
    if reason:
        raise key_error_at((), f"{reason}. Here one of {', '.join(LAWS)} is expected.")
    return law_name


LawOfConditions = Annotated[str, OneOf((*LAWS,)), BeforeValidator(_refuse_compared_only)]
AnyLaw = Annotated[str, OneOf(LAW_NAMES)]


class FilmSettings(Group):
    """The film thickness behind lambda."""

    thickness: Literal["minimum", "central"] = key("Film thickness that lambda uses.")


class ZeroReferenceSettings(Group):
    """The zero of the traction force: the sensor's output under pure rolling."""

    duration_s: q.DurationS = key("Time of pure rolling that is averaged for the zero.")
    min_duration_s: q.DurationS = key("Shortest part of a rolling phase that gives a zero.")
    max_drift_n: float = key("Largest change of the zero during a run.", unit="N", gt=0, le=1e6)
    max_slide_roll_ratio: q.SlipChange = key("A phase with |S| below this is pure rolling.")
    max_traction_share: q.Tolerance = key("Traction of a rolling phase, over the largest.")
    standstill_share: q.Tolerance = key("Standstill is below this share of the run's speed.")
    ramp_tolerance: q.Tolerance = key("Relative change of speed that is no ramp.")


class StepSettings(Group):
    """How steps are found, and what of the time between them is used."""

    window_s: q.DurationS = key("Time that is averaged before and after a step to find it.")
    noise_factor: q.Factor = key("Standard errors that a step must exceed.")
    settle_s: q.DurationOrZeroS = key("Time that is cut off after a step.")
    guard_s: q.DurationOrZeroS = key("Time that is cut off before the next step.")
    min_duration_s: q.DurationS = key("Shortest settled part that is used.")


class PlateauSettings(StepSettings):
    """Steady plateaus between the steps of slip."""

    min_step: q.SlipChange = key("Smallest step of S.")
    transient_share: q.Tolerance = key("Share of a settled part that counts as its beginning.")


class RampSettings(Group):
    """Logs whose slip is a continuous ramp, in place of steps."""

    force_lag_s_range: q.RisingPair[q.DurationOrZeroS] = key(
        "Time by which the traction force may be logged behind the slip; a rig file has its own."
    )
    largest_error: q.Tolerance = key(
        "Standard error of mu, relative, in the median; more and the run is refused."
    )


class SpikeSettings(Group):
    """Isolated wild readings."""

    threshold: q.Factor = key("Robust standard deviations from the plateau's median.")


class StuckSettings(Group):
    """A force signal that does not change."""

    duration_s: q.DurationS = key("Time without any change of the force signal.")
    samples: int = key("Samples without any change.", ge=2)
    chance: q.Tolerance = key("A noisy channel is stuck if chance holds it so long less often.")


class CurationSettings(Group):
    """From samples to steady points."""

    zero_reference: ZeroReferenceSettings = key("Zero of the traction force.")
    plateaus: PlateauSettings = key("Steady plateaus.")
    ramps: RampSettings = key("Continuous ramps of slip.")
    spikes: SpikeSettings = key("Isolated wild readings.")
    stuck: StuckSettings = key("A force signal that does not change.")


class LoggedTwiceSettings(Group):
    """Largest difference of two columns of one quantity."""

    entrainment_speed: q.Tolerance = key("Relative difference in the median row.")
    slide_roll_ratio: q.SlipChange = key("Difference of S in the median row.")
    traction_force: q.Tolerance = key("Difference from half of TF1 - TF2, relative.")


class SameSetPointSettings(Group):
    """Largest difference of two notes of one set point."""

    relative: q.SameLevel = key("Relative difference; of loads where no pressure is known.")
    temperature_c: q.TemperatureErrorC = key("Difference of temperatures that are the same.")


class SignalGateSettings(Group):
    """Limits that the signals of every kind of log must keep."""

    load_change_max: q.PositiveShare = key("Change of load from first to second half of a plateau.")
    temperature_change_max_c: q.TemperatureToleranceC = key("The same for the oil's temperature.")
    spike_share_max: q.Share = key("Share of a plateau's rows that may be spikes.")
    faulty_share_max: q.Share = key(
        "Share of plateaus that may fail gates which blame the run; more of them refuse the run, "
        "if they are `faulty_plateaus_min` or more than half."
    )
    faulty_plateaus_min: int = key("Fewer plateaus may be mishaps of single ones.", ge=1)
    significant_errors: q.Factor = key("Standard errors beyond which a difference is no chance.")
    zero_moving_share: q.Tolerance = key(
        "Change of a zero within its last phase, over that during the run: it has not settled."
    )
    readings_min: int = key("Fewest readings of a plateau.", ge=2)
    noise_share_max: q.Tolerance = key("Noise over the largest plateau; more is a warning.")
    noise_left_min: q.Tolerance = key(
        "Noise at large readings over that at small ones; less is a warning."
    )
    clock_scatter_max: q.Tolerance = key("Scatter of a fixed interval between rows, over it.")
    clock_odd_factor: q.AboveOne = key("An odd step of the clock, over that scatter: a warning.")
    clock_jump_intervals: q.Positive = key("Longest gap, in sampling intervals.")
    saturated_share: q.Tolerance = key("Share of rows at a sensor's extreme value.")
    piled_up_factor: q.AboveOne = key("How often a saturated value occurs, over the next one.")


class CopySettings(Group):
    """Runs that differ by far less than the errors of their plateaus: copies of one log."""

    plateaus: int = key("Last plateaus that are compared; with fewer no copy is known.", ge=3)
    slip_errors: q.Tolerance = key("Rms difference of S, over its standard errors.")
    traction_errors: q.Tolerance = key("Rms difference of mu, over its standard errors.")
    condition: q.Tolerance = key("Difference of load, speed and temperature, over the largest.")


class GateSettings(SignalGateSettings):
    """Limits of the gates that points and runs must pass."""

    lambda_limit: q.LambdaRatio = key("Full film above this film thickness over roughness.")
    load_tolerance: q.Tolerance = key("Deviation from the nominal load, relative.")
    speed_tolerance: q.Tolerance = key("Deviation from the nominal speed, relative.")
    temperature_tolerance_c: q.TemperatureToleranceC = key("Deviation from the set temperature.")
    slide_roll_ratio_min: q.SignedSlideRollRatio = key("Smallest S of a point.")
    slide_roll_ratio_max: q.SignedSlideRollRatio = key("Largest S of a point.")
    traction_min: float = key("Smallest physical traction coefficient.", unit="1", ge=-2, le=2)
    traction_max: float = key("Largest physical traction coefficient.", unit="1", gt=0, le=2)
    slip_change_max: q.SlipChange = key("Change of S within a plateau.")
    traction_change_max: q.TractionChange = key("Change of mu within a plateau.")
    slip_transient_max: q.SlipChange = key("Change of S from its beginning to its rest.")
    traction_transient_max: q.TractionChange = key("Change of mu from its beginning to its rest.")
    slip_tolerance: q.SlipChange = key("Distance of S from the nearest planned value.")
    branch_difference_max: q.TractionChange = key("Median difference of mu of branches.")
    branch_ratio_max: q.Tolerance = key("Relative difference of branches that is a warning.")
    branch_points: int = key("Fewest points of a branch.", ge=2)
    film_trend_factor: q.AboveOne = key("Largest factor between a film and its power law in speed.")
    sign_slip_min: q.SlideRollRatioOrZero = key("The force's sign is judged above this |S|.")
    sliding_traction_min: q.RelativeError = key("Smallest median mu of an oil above that |S|.")
    sliding_traction_usual: q.RelativeError = key("A smaller median mu is a warning.")
    sign_share: q.PositiveShare = key("Share of points of the other sign that refuses a run.")
    temperature_drift_max_c: q.TemperatureToleranceC = key("Drift of temperature within a run.")
    repeat_difference_max: q.Tolerance = key("Median relative difference of mu between repeats.")
    repeat_odd_min: q.Tolerance = key("Difference that makes one of three repeats the odd one.")
    repeat_odd_factor: q.AboveOne = key("... and over the difference of the others.")
    copies: CopySettings = key("Runs that are copies of each other.")
    constant_channel_plateaus: int = key("Fewer plateaus may agree by chance.", ge=2)
    constant_channel_runs: int = key("So many runs of a rig tell what its channels do.", ge=2)
    asymmetry_max: q.PositiveShare = key("Largest |TF1 + TF2|/(|TF1| + |TF2|) where slip reverses.")
    asymmetry_slip_min: q.SlideRollRatioOrZero = key("The asymmetry is judged above this |S|.")


class FitSettings(Group):
    """The fit of a law, its certificate and its errors."""

    law: LawOfConditions = key("Traction law that is fitted.")
    searches: int = key("Independent global searches, each from its own seed.", ge=2)
    population: int = key("Members of the population of a search (differential evolution).", ge=8)
    generations: int = key("Generations of a search.", ge=1)
    polished: int = key("Members of the population from which descents to an optimum start.", ge=1)
    agreement_sse: q.Tolerance = key("Relative difference of SSE between searches that agree.")
    agreement_constants: q.Positive = key("The same of constants, in naive standard errors.")
    gradient_cosine_max: q.Tolerance = key("Largest gradient cosine at an optimum.")
    min_relative_range: q.Tolerance = key("Less (max - min)/max gives no exponent.")
    smallest_singular_value: q.Tolerance = key(
        "A direction of the conditions is varied from this singular value, over the largest, on."
    )
    level_tolerance: q.Share = key("Reach beyond a condition without exponent, relative.")
    min_curves_for_errors: int = key("With fewer curves no errors are given.", ge=2)
    min_curves_to_resample: int = key("With fewer curves errors are cluster-robust (CR2).", ge=2)
    level_gap: q.PositiveShare = key("Levels differ by more than this share of the range.")
    left_out_groups: int = key("Most groups of curves that are left out one at a time.", ge=2)
    pulling_weight: q.Share = key("A curve of less mean weight pulls the fit.")
    odd_gain: q.Tolerance = key("A curve further from the robust fit is named, as |ln gain|.")
    odd_scatter: q.Tolerance = key("A curve of another shape than the robust fit is named, by rms.")
    odd_factor: q.AboveOne = key("Both only if over the median of all curves by this factor.")
    odd_gain_deviations: q.Factor = key(
        "A gain so many robust standard deviations from the others is odd."
    )
    odd_gain_min: q.Tolerance = key("... if it is off by this at least, as |ln gain|.")
    sign_confidence: q.Tolerance = key("Confidence that no sign of a constant is wrong.")
    bootstrap: int = key("Bootstrap refits (whole curves are resampled).", ge=20)


class SameConditionSettings(Group):
    """Measured means that are one level of a condition, from the lowest to the highest of them.

    Runs have the same condition, and points without a named curve are one curve, where all their
    levels are the same.
    """

    max_hertz_pressure: q.Tolerance = key("Range of pressures, relative.")
    load: q.Tolerance = key("Range of loads, relative.")
    entrainment_speed: q.Tolerance = key("Range of entrainment speeds, relative.")
    inlet_temperature_c: q.TemperatureToleranceC = key("Range of inlet temperatures.")
    slide_roll_ratio: q.SlipChange = key("Range of S at which repeated runs are compared.")


class ChangeSizeSettings(Group):
    """One size of a change for each cause."""

    traction_force: q.Factor = key("Of the traction force, relative.")
    zero_of_the_force: q.Tolerance = key("Of the zero of the force, in mu.")
    slip: q.Factor = key("Of the slide-roll ratio, relative; 1 is a slip read twice as large.")
    inlet_temperature_k: float = key("Of the temperature.", unit="K", gt=0, le=200)


class SteadinessSettings(Group):
    """When a change of the rig over the runs of a campaign is named.

    The score of a change is twice the logarithm of its likelihood ratio, less twice that of the
    number of changes of its kind.
    """

    alarm: q.Factor = key("Score of a trend, a step, a season, a block of runs or a label.")
    alarm_of_groups: q.Factor = key("Score of two groups of runs that only mu tells apart.")
    alarm_of_a_run: q.Factor = key("Score of a single run.")
    fewest_runs: int = key("Runs on either side of a step.", ge=2)
    longest_block: int = key("Runs of the longest block.", ge=2)
    curves_min: int = key("With fewer curves nothing is said of law and campaign.", ge=4)
    seen_at: q.Factor = key("Standard deviations of the smallest change that would be seen.")
    confounded: q.Tolerance = key(
        "A change that resembles an effect of the conditions has a smaller share of the "
        "information than this; its score must be larger by the same factor."
    )
    usual: ChangeSizeSettings = key("Standard deviation of a change, before the data.")
    largest: ChangeSizeSettings = key("Sizes that no rig has, so that they are no cause.")


class SurfaceSettings(Group):
    """The surface of measured mu, from which intervals and judgements come."""

    level: q.Tolerance = key("Share of points of new runs that an interval should hold.")
    fewest_curves: int = key("With fewer curves there is no interval.", ge=2)
    largest_misfit: q.Tolerance = key(
        "A law that misses more of mu than this, and more than runs differ, does not fit."
    )
    largest_spread: q.Tolerance = key(
        "No support beyond this standard deviation of the surface, relative to mu."
    )
    fewest_slips: int = key("A curve of fewer slips does not show the shape between them.", ge=1)
    reach_in_gaps: q.Factor = key(
        "No support farther from a tested slip than this share of the widest gap of a curve."
    )
    reach_in_slip: float = key(
        "No support farther from a tested slip than this factor (far above a slip of 0.02).",
        gt=1,
        le=1000,
    )
    reach_in_ranges: q.Factor = key(
        "No support farther beyond the tested conditions than this share of a tested range."
    )
    largest_spread_of_bound: q.Tolerance = key(
        "No support where a constant at its bound moves mu by more, relative to mu."
    )


class TareSettings(Group):
    """The torque sensor's output at rest."""

    max_speed_rpm: q.SpeedRpm = key("Slower counts as rest.")
    min_duration_s: q.DurationS = key("Time of rest at either end.")
    max_drift_n_m: float = key("Largest change of the tare during a run.", unit="N m", gt=0)


class TorquePlateauSettings(StepSettings):
    """Steady speeds of a torque log."""

    min_step_rpm: q.SpeedRpm = key("Smallest step of speed.")


class TorqueGateSettings(SignalGateSettings):
    """Limits of torque plateaus."""

    torque_change_max: q.PositiveShare = key("The same for the torque.")


class TorqueLogSettings(Group):
    """Logs of a bearing's friction torque."""

    tare: TareSettings = key("The torque sensor's output at rest.")
    plateaus: TorquePlateauSettings = key("Steady speeds.")
    gates: TorqueGateSettings = key("Limits of plateaus.")
    twin_misfit_max: q.Tolerance = key("Misfit up to which two simulated rigs have one truth.")


class CompareSettings(Group):
    """Laws compared on the same points by the same fit."""

    laws: q.OneOrMoreDistinct[AnyLaw] = key(
        "Laws, in the order of tables and figures.", default=[*LAW_NAMES]
    )
    bic_difference_min: q.Positive = key("Laws tie where their BIC differ by less.")


class OperatingPoint(Group):
    """An operating point of a law."""

    max_hertz_pressure_gpa: q.PressureGpa = key("Maximum Hertz pressure.")
    entrainment_speed_m_s: q.SpeedMs = key("Entrainment speed.")
    inlet_temperature_c: q.TemperatureC = key("Inlet temperature.")


class PointOfTraction(OperatingPoint):
    """An operating point of a law with its slip."""

    slide_roll_ratio: q.SlideRollRatio = key("Slide-roll ratio.")


class LawFloorSettings(OperatingPoint):
    """Smallest levels at which a law is evaluated."""

    load_n: q.LoadN = key("Load.")


class TermUncertaintySettings(Group):
    """Relative standard uncertainty of the torque's terms beside traction and drag."""

    rolling: q.RelativeError = key("Rolling resistance.")
    hysteresis: q.RelativeError = key("Elastic hysteresis.")
    pocket: q.RelativeError = key("Cage pockets.")
    land: q.RelativeError = key("Cage lands.")


class StandInUncertaintySettings(Group):
    """Relative standard uncertainty of properties that are those of a similar oil."""

    viscosity: q.RelativeError = key("Viscosity.")
    pressure_viscosity_coefficient: q.RelativeError = key("Pressure-viscosity coefficient.")


class TorqueDrawSettings(Group):
    """Uncertainty of calculated torque, cage slip and power, by random draws."""

    draws: int = key("Draws, each with an equilibrium of its own.", ge=40, le=10000)
    lost_share_max: q.Share = key("Share of draws that may have no equilibrium.")
    split_gap: q.Tolerance = key(
        "Gap of cage slip between draws that parts rolling cages from skidding ones ..."
    )
    split_gap_share: q.Tolerance = key("... if it is this share of the 95 % interval.")


class PalmgrenSettings(Group):
    """Constants of Palmgren's torque."""

    f0: float = key("Of lubrication and bearing type.", unit="1", gt=0, le=100)
    f1: q.PositiveShare = key("Of load and bearing type.")


class CageSlipSettings(Group):
    """The map of cage slip."""

    pitch_speed_mm_rpm: q.TwoOrMoreDistinct[q.PitchSpeedMmRpm] = key("Pitch diameter times speed.")
    axial_load_n: q.TwoOrMoreDistinct[q.LoadN] = key("Axial loads.")
    inlet_temperature_c: q.TemperatureC = key("Oil temperature.")
    further_temperature_c: q.AnyNumberDistinct[q.TemperatureC] = key(
        "Further oil temperatures, at every second speed and load, for the report's explorer."
    )
    slip_limit: q.Tolerance = key("Cage slip from which on a bearing slips.")


class SizeEffectSettings(Group):
    """Bearings like the campaign's, of other sizes and grooves."""

    ball_size_factors: q.OneOrMoreDistinct[q.Factor] = key("Factors on all lengths.")
    groove_curvatures: q.OneOrMoreDistinct[q.GrooveCurvature] = key(
        "Groove radii over ball diameter."
    )
    axial_load_n: q.LoadN = key("Axial load of the bearing itself; others have its pressure.")
    inner_speed_rpm: q.SpeedRpm = key("Speed of the bearing itself; others have its surface speed.")
    inlet_temperature_c: q.TemperatureC = key("Oil temperature.")


class BearingSettings(Group):
    """Settings of the calculation of a bearing's torque, beside the traction law."""

    drag_coefficient: float = key("Of a ball in its row, by frontal area.", unit="1", ge=0, le=10)
    oil_volume_fraction: q.PositiveShare = key("Oil in the space of the balls; drag follows it.")
    oil_volume_fraction_range: q.RisingPair[q.Share] = key(
        "Its outer bounds, by single published tests."
    )
    replenishment_constant: q.ReplenishmentConstant = key("K_rs of SKF's starvation factor.")
    replenishment_constant_range: q.RisingPair[q.ReplenishmentConstant] = key("Its range.")
    ellipse_factor: q.EllipseFactor = key(
        "Traction in the bearing's ellipse over that in a rig's circle, at equal conditions."
    )
    ellipse_factor_range: q.RisingPair[q.EllipseFactor] = key("Its range.")
    law_floor: LawFloorSettings = key("Smallest levels at which a law is evaluated.")
    pressure_limits_gpa: q.RisingPair[q.PressureGpa] = key(
        "Highest pressure in the long term, at peaks."
    )
    term_uncertainty: TermUncertaintySettings = key("Relative uncertainty of the other terms.")
    stand_in_uncertainty: StandInUncertaintySettings = key("Uncertainty of stand-in oils.")
    law_error_beyond: q.RelativeError = key(
        "Relative standard error of mu by the law where no surface of measured mu has an interval."
    )
    skf_pitch_speed_max: q.PitchSpeedMmRpm = key("Largest dm n of the SKF formula.")
    uncertainty: TorqueDrawSettings = key("Uncertainty of what is calculated.")
    compatible_uncertainties: q.Factor = key(
        "Calculated and measured torque agree within so many standard uncertainties."
    )
    palmgren: PalmgrenSettings = key("Constants of Palmgren's torque.")
    cage_slip: CageSlipSettings = key("The map of cage slip.")
    size_effect: SizeEffectSettings = key("Bearings of other sizes and grooves.")

    @model_validator(mode="after")
    def _values_are_in_their_ranges(self) -> Self:
        refuse_outside_ranges(self)
        return self

    def uncertain_inputs(self) -> dict[str, UncertainInput]:
        """Value and range of the uncertain inputs that are settings of all bearings."""
        return uncertain_inputs_of_all_bearings(self)


class DutyPoint(Group):
    """An operating point of a bearing."""

    axial_load_n: q.LoadN = key("Axial load.")
    inner_speed_rpm: q.SpeedRpm = key("Speed of the inner ring.")
    oil_temperature_c: q.TemperatureC = key("Oil temperature.")


class PlanLevels(Group):
    """Levels of the candidate tests, in all combinations."""

    max_hertz_pressure_gpa: q.OneOrMoreRising[q.PressureGpa] = key(
        "Maximum Hertz pressures, rising."
    )
    entrainment_speed_m_s: q.OneOrMoreRising[q.SpeedMs] = key("Entrainment speeds, rising.")
    inlet_temperature_c: q.OneOrMoreRising[q.TemperatureC] = key("Inlet temperatures, rising.")


class PlanSettings(Group):
    """Which tests to run next."""

    tests: int = key("Tests of a plan, chosen one after the other.", ge=1, le=50)
    levels: PlanLevels = key("Levels of the tests to choose from.")
    largest_traction: float = key(
        "Largest traction coefficient to expect where nothing was measured.", unit="1", gt=0, le=1
    )
    form_error_length: q.PositiveShare = key(
        "Distance over which the error of a law's form changes, over the span of the tests."
    )
    smallest_gain: q.Share = key("Relative fall of the uncertainty that is worth a test.")
    duty_points: list[DutyPoint] = key(
        "Points of the bearing; else those of `torque.matrix` or `bearing.cage_slip`.", default=[]
    )
    traction_at: q.OneOrMoreDistinct[PointOfTraction] = key(
        "Points to plan for where there is no bearing."
    )


class ExportSettings(Group):
    """Laws for other programs."""

    adore_points: q.OneOrMoreDistinct[OperatingPoint] = key(
        "Operating points of the exported ADORE form."
    )


class Box(Group):
    """Lowest and highest level of each condition."""

    max_hertz_pressure_gpa: q.RisingPair[q.PressureGpa] = key("Maximum Hertz pressure.")
    entrainment_speed_m_s: q.RisingPair[q.SpeedMs] = key("Entrainment speed.")
    inlet_temperature_c: q.RisingPair[q.TemperatureC] = key("Inlet temperature.")
    slide_roll_ratio: q.RisingPair[q.SlideRollRatioOrZero] = key("Slide-roll ratio.")


class TorqueFigureSettings(Group):
    """Conditions of figures of measured torque."""

    same_within: q.RelativeError = key("Conditions this near are one set point, relative.")


class FrictionMapSettings(Group):
    """Conditions of the friction map."""

    max_hertz_pressure_gpa: q.UpToFiveDistinct[q.PressureGpa] = key(
        "Pressures, one row of panels each."
    )
    inlet_temperature_c: q.TemperatureC = key("Temperature.")
    entrainment_speed_m_s: q.RisingPair[q.SpeedMs] = key("Lowest and highest speed.")
    slide_roll_ratio: q.RisingPair[q.SlideRollRatio] = key("Smallest and largest slip.")


class StribeckSettings(Group):
    """Content of the figure `stribeck`."""

    slide_roll_ratio: q.SlideRollRatio = key("Slip of the points; the nearest of each run.")


class IsothermalSettings(Group):
    """Curves of the figure `isothermal`, and the bodies that carry their heat away."""

    inlet_temperature_c: q.TemperatureC = key("Temperature.")
    same_temperature_c: q.TemperatureToleranceC = key("Temperatures this near are the same.")
    entrainment_speed_m_s: q.SpeedMs = key("Speed.")
    same_within: q.RelativeError = key("Speeds this near are the same, relative.")
    solid_conductivity_w_mk: q.SolidConductivityWMK = key("Of ball and disc.")
    solid_volumetric_heat_j_m3k: q.SolidHeatJM3K = key("Density times specific heat of both.")


class FigureSettings(Group):
    """Conditions that the figures show."""

    torque: TorqueFigureSettings = key("Figures of measured torque.")
    friction_map: FrictionMapSettings = key("Figure `friction-map`.")
    stribeck: StribeckSettings = key("Figure `stribeck`.")
    isothermal: IsothermalSettings = key("Figure `isothermal`.")
    refused_pages_max: int = key("Refused runs that get a page of their own.", ge=0)


class Matrix(Group):
    """Operating conditions: all combinations of levels."""

    max_hertz_pressure_gpa: q.OneOrMoreDistinct[q.PressureGpa] = key("Maximum Hertz pressures.")
    entrainment_speed_m_s: q.OneOrMoreDistinct[q.SpeedMs] = key("Entrainment speeds.")
    inlet_temperature_c: q.OneOrMoreDistinct[q.TemperatureC] = key("Inlet temperatures.")


class NearbySettings(Group):
    """Measured points are shown beside a curve whose other conditions are this near."""

    max_hertz_pressure_gpa_relative: q.Tolerance = key("Maximum Hertz pressure, relative.")
    entrainment_speed_m_s_relative: q.Tolerance = key("Entrainment speed, relative.")
    inlet_temperature_c: q.TemperatureToleranceC = key("Inlet temperature.")
    slide_roll_ratio: q.SlipChange = key("Slide-roll ratio.")


class ReportSettings(Group):
    """The report."""

    size_max_mb: float = key("Size of the page; further pictures are left out.", unit="MB", gt=0)
    rows_max: int = key("Rows of a list of refusals or of runs; the rest is counted.", ge=1)
    points_max: int = key("Measured points in the explorer.", ge=1)
    sliders: Box = key("Ranges of the explorer's sliders, where tests are near.")
    nearby: NearbySettings = key("Points shown beside a curve.")


class ReleaseSettings(Group):
    """A release of a campaign."""

    tag: Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9._-]{0,31}$")] = key(
        "Readable part of a release's version, in quotes where it is a number."
    )
    date: q.Day = key("Day of publication, in quotes.")


class DriftSettings(Group):
    """Largest changes that `oilfilm diff --gate` accepts between two releases."""

    standard_errors: q.Factor = key("Largest change of a constant, in its standard errors.")
    traction: q.Factor = key("Largest change of mu over the tested box, relative.")
    errors: q.Factor = key("Largest change of an error or of an interval's width, relative.")
    levels: int = key("Levels of each condition.", ge=2, le=50)
    slide_roll_ratio: q.Slips = key("Slide-roll ratios, rising.")


class SplitSettings(Group):
    """How the work is spread over jobs. It has no effect on results."""

    runs: int = key(
        "Most raw logs in a share of the work, on average; the number of shares is a power of two.",
        ge=1,
        default=250,
    )


class ConfigKeys(Group):
    """The keys of config/config.yaml that a campaign may override."""

    seed: int = key("Seed of every random number.", ge=0)
    film: FilmSettings = key("The film thickness behind lambda.")
    curation: CurationSettings = key("From samples to steady points.")
    logged_twice: LoggedTwiceSettings = key("Largest difference of two columns of one quantity.")
    same_set_point: SameSetPointSettings = key("Largest difference of two notes of one set point.")
    same_condition: SameConditionSettings = key("Measured means that are one level.")
    gates: GateSettings = key("Limits of the gates.")
    fit: FitSettings = key("The fit of a law.")
    torque_logs: TorqueLogSettings = key("Logs of a bearing's friction torque.")
    steadiness: SteadinessSettings = key("When a change of the rig over the runs is named.")
    surface: SurfaceSettings = key("The surface of measured mu.")
    compare: CompareSettings = key("Laws compared on the same points.")
    bearing: BearingSettings = key("Calculation of a bearing's torque, beside the law.")
    plan: PlanSettings = key("Which tests to run next.")
    exports: ExportSettings = key("Laws for other programs.")
    figures: FigureSettings = key("Conditions that the figures show.")
    report: ReportSettings = key("The report.")
    release: ReleaseSettings = key("A release of a campaign.")
    drift: DriftSettings = key("What may change between two releases.")
    studies: dict[str, dict[str, Any]] = key(
        "By study: those of its own settings that are changed.", default={}
    )


class Config(ConfigKeys):
    """The keys of config/config.yaml."""

    campaign: q.Name = key("Campaign to run: a file of config/campaigns, without .yaml.")
    split: SplitSettings = key("How the work is spread over jobs.", default=SplitSettings())
    container: str = key(
        "Image for the steps with --sdm apptainer: a file or an address. `none`: no image.",
        default="none",
    )
