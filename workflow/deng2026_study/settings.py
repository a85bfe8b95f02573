"""Settings of the study: its figures, and how printed constants, claims and advice are judged.

`config.yaml` beside this module has their values.
"""

from collections.abc import Iterator
from typing import Annotated, Literal, Self

from pydantic import Field, field_validator, model_validator

from oilfilm.base.studies import settings_file
from oilfilm.bearing.kinematics import entrainment_speed_m_s, inner_slide_roll_ratio
from oilfilm.settings import quantities as q
from oilfilm.settings.base import Group, key, key_error_at
from oilfilm.settings.config import Box, LawOfConditions, Matrix
from oilfilm.settings.messages import load
from oilfilm.settings.resolved import Settings

NAME = "deng2026_study"
ContactState = Literal["slipping", "gripping", "light", "heavy", "hot", "fast"]
_FewSlips = Annotated[q.OneOrMoreDistinct[q.SlideRollRatio], Field(min_length=2, max_length=10)]


class Boxes(Group):
    """Boxes of conditions."""

    tested: Box = key("Conditions that the paper tested.")
    extrapolated: Box = key("Conditions of the paper's figures, beyond the tested ones too.")


class SignSlips(Group):
    """Slide-roll ratios where a statement is judged."""

    curve: _FewSlips = key("For statements on whole curves.")
    figures: _FewSlips = key("For statements that hold at the slips of figures 8 and 9.")


class SignSettings(Group):
    """The study of the signs that are lost in our copy of the paper."""

    levels: int = key(
        "Levels of each condition, 4, 7, 10 or so on: thirds have whole steps.", ge=4, le=25
    )
    slide_roll_ratio: SignSlips = key("Slide-roll ratios where a statement is judged.")
    linear_r2_min: q.Share = key("R2 of a straight line that counts as linear.")
    decline_max: q.Share = key("Share of the peak that a slight decline may lose.")
    near_best: float = key(
        "Sign sets whose total is less than this below the best total are near the best set.", gt=0
    )
    no_effect_max: q.Share = key("Change of mu over its largest value that counts as none.")

    @field_validator("levels")
    @classmethod
    def _thirds_have_whole_steps(cls, levels: int) -> int:
        if levels % 3 != 1:
            raise key_error_at((), f"{levels} levels have no thirds of whole steps; take 4, 7, 10.")
        return levels


class PrintedSettings(Group):
    """How the printed constants are judged."""

    boxes: Boxes = key("Boxes of conditions.")
    levels: q.LevelCount = key("Levels of each condition and of slip where mu is compared.")
    signs: SignSettings = key("The study of the lost signs.")


class AuditSettings(Group):
    """The paper's claims, checked with refit and printed constants."""

    holds_share: q.Share = key("Share of the cases from which on a claim holds.")
    fails_share: q.Share = key("Share of the cases below which a claim fails.")
    levels: int = key("Levels of each condition.", ge=3, le=1000)
    curve_points: int = key("Slide-roll ratios of a curve.", ge=11, le=10000)
    zero_traction_max: float = key("|mu| up to this is no traction.", unit="1", ge=0, le=1)
    linear_tolerance: q.Tolerance = key("Change of mu/S at the end of the linear range.")
    linear_to_slip: q.SlideRollRatio = key("Slip that the linear range must reach.")
    plateau_share: q.Tolerance = key("Share of the peak where the plateau begins.")
    cold_band_c: q.RisingPair[q.TemperatureC] = key(
        "Temperatures where the paper sees the steeper fall."
    )
    hot_band_c: q.RisingPair[q.TemperatureC] = key(
        "Temperatures where the paper sees flatter curves."
    )
    prediction_error: q.RelativeError = key("Relative error of mu that is a good prediction.")
    slow_and_fast_m_s: q.RisingPair[q.SpeedMs] = key("Speeds whose temperature effect is compared.")
    film_min_um: float = key("Films are thicker, as the paper states.", unit="um", gt=0, le=100)
    stress_law: LawOfConditions = key("Law that others are compared with.")
    property_laws: q.OneOrMore[q.Name] = key(
        "Laws with properties of the oil among their variables."
    )
    curve_error_max: q.RelativeError = key("Standard error of A, B, C of one curve, relative.")
    overfit_min: q.Factor = key("Growth of the error on curves left out, over that of stress_law.")
    kinematic_tolerance: q.Tolerance = key("What 'nearly' allows in statements on speed and slip.")
    torque_stress_error: q.Factor = key("Largest relative torque error of the stress law (paper).")
    torque_load_error: q.Factor = key("Largest relative torque error of the load law (paper).")

    @property
    def plateau_change_max(self) -> float:
        """Largest relative change of mu on a plateau."""
        return 1 - self.plateau_share


class SelectionLimits(Group):
    """Limits between the states of a contact."""

    slip_limit: q.Tolerance = key("Cage slip from which on a bearing slips.")
    light_below_gpa: q.PressureGpa = key("Pressure below which the load is light.")
    heavy_from_gpa: q.PressureGpa = key("Pressure from which on the load is heavy.")
    hot_from_c: q.TemperatureC = key("Temperature from which on it is hot.")
    fast_from_mm_rpm: q.PitchSpeedMmRpm = key("Pitch diameter times speed from where it is fast.")


class StatedSpeed(Group):
    """A bearing's speed and the entrainment speed that the paper takes it for."""

    pitch_speed_mm_rpm: q.PitchSpeedMmRpm = key("Pitch diameter times speed.")
    entrainment_speed_m_s: q.SpeedMs = key("Entrainment speed.")


class SelectionRule(Group):
    """A rule of the paper's advice on oils."""

    name: q.Text = key("Name of the rule.")
    section: q.Text = key("Section of the paper, in quotes where it is a number.")
    when: q.AnyNumberDistinct[ContactState] = key("States of the contact that must all be true.")
    prefer: q.OneOrMore[q.Name] = key("Oils, the first choice first.")


class AdviceBandSettings(Group):
    """Scenarios in which the advice on oils is worked out again."""

    limit_factors: q.AnyNumberDistinct[q.Factor] = key(
        "Factors on each of `limits`, one after the other."
    )
    inlet_temperature_c: q.AnyNumberDistinct[q.TemperatureC] = key(
        "Supply temperatures beside the map's."
    )
    rule_orders: dict[str, list[q.Text]] = key("Other orders of the rules: their names, by order.")


class SelectionSettings(Group):
    """The paper's advice on which oil to choose."""

    gamma: q.Gamma = key("Effective D cos(alpha)/dm in S = 2 s/(1 + gamma (1 - s)).")
    stated: StatedSpeed = key("Speeds that the paper takes for one another.")
    limits: SelectionLimits = key("Limits between the states of a contact.")
    rules: q.OneOrMore[SelectionRule] = key("Rules; the first that applies decides.")
    indifference: q.RelativeError = key("Oils that differ by less are equally good, relative.")
    band: AdviceBandSettings = key("Scenarios for the advice by cage slip.")

    @model_validator(mode="after")
    def _orders_have_every_rule_once(self) -> Self:
        names = sorted(rule.name for rule in self.rules)
        for order, listed in self.band.rule_orders.items():
            if sorted(listed) != names:
                raise key_error_at(
                    ("band", "rule_orders", order),
                    f"an order has every rule once: {', '.join(names)}; found {', '.join(listed)}.",
                )
        return self

    @property
    def slide_roll_ratio_limit(self) -> float:
        """Slide-roll ratio at the inner race at the limit of cage slip."""
        return inner_slide_roll_ratio(self.limits.slip_limit, self.gamma)

    @property
    def fast_from_m_s(self) -> float:
        """Entrainment speed from which on a contact is fast."""
        return entrainment_speed_m_s(self.limits.fast_from_mm_rpm)


class Fig02Settings(Group):
    """Condition of figure 2."""

    oil: q.Name = key("Oil shown, in quotes.")
    inlet_temperature_c: q.UpToFiveDistinct[q.TemperatureC] = key(
        "Temperatures, one row of panels each."
    )
    entrainment_speed_m_s: q.SpeedMs = key("Speed of the panels by pressure.")
    max_hertz_pressure_gpa: q.PressureGpa = key("Pressure of the panels by speed.")


class Fig03Settings(Group):
    """Condition of figure 3."""

    inlet_temperature_c: q.TemperatureC = key("Temperature.")
    entrainment_speed_m_s: q.SpeedMs = key("Speed.")


class MatrixWithSlip(Matrix):
    """Conditions of a figure: all combinations of levels."""

    slide_roll_ratio: q.OneOrMoreDistinct[q.SlideRollRatioOrZero] = key("Slide-roll ratios.")


class FigureSettings(Group):
    """Conditions that the paper's figures of data show."""

    fig02: Fig02Settings = key("Figure 2.")
    fig03: Fig03Settings = key("Figure 3.")


class StudySettings(Group):
    """Settings of the study."""

    printed: PrintedSettings = key("How the printed constants are judged.")
    audit: AuditSettings = key("How the paper's claims are judged.")
    selection: SelectionSettings = key("The paper's advice on which oil to choose.")
    figures: FigureSettings = key("Conditions that the paper's figures of data show.")
    extrapolation: Annotated[dict[str, MatrixWithSlip], Field(min_length=1)] = key(
        "By figure: conditions at which fitted laws are compared with a simulated truth."
    )


def default_settings() -> StudySettings:
    """The settings of the study without any change."""
    defaults: StudySettings = load(settings_file(NAME), StudySettings)
    return defaults


def study_settings(settings: Settings) -> StudySettings:
    """The settings of the study in a campaign with `studies: [deng2026_study]`."""
    return settings.study_settings(NAME, StudySettings)


def contradictions(settings: Settings) -> Iterator[tuple[tuple[str, ...], str]]:
    """Contradictions with the campaign: the key of its file to blame, and a sentence."""
    study = study_settings(settings)
    limit_of_study = study.selection.limits.slip_limit
    limit_of_bearing = settings.bearing.cage_slip.slip_limit
    if settings.campaign.torque is not None and limit_of_study != limit_of_bearing:
        yield (
            ("settings",),
            "the advice and the map of cage slip must judge by one limit: found "
            f"{limit_of_study:g} for selection.limits.slip_limit of the study and "
            f"{limit_of_bearing:g} for bearing.cage_slip.slip_limit; set both to one value.",
        )
    shown_oil = study.figures.fig02.oil
    if "fig02" in settings.campaign.figures and shown_oil not in settings.oils:
        yield (
            ("figures",),
            f"fig02 shows the oil {shown_oil!r}, which the campaign lacks; name one of its own "
            f"under `settings`, as studies: {{{NAME}: {{figures: {{fig02: {{oil: ...}}}}}}}}.",
        )
