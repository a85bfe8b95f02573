"""Conversions at the edges."""

import numpy as np
import pytest

from oilfilm.base.units import conversion, surface_speed_to_rpm


def test_paper_speeds_of_ball_and_disc_spindles() -> None:
    # n = 30 U/(pi R), Deng et al. 2026, section 2.2: 40 m/s at R = 10 mm is 38 197 rpm
    assert round(float(surface_speed_to_rpm(np.array(40.0), 0.010))) == 38197


@pytest.mark.parametrize(
    ("unit", "rpm"),
    [
        *dict.fromkeys(
            ["Hz", "1/s", "s-1", "s\u207b\u00b9", "s**-1", "rps", "rev/s", "1/sec"], 60.0
        ).items(),
        *dict.fromkeys(["min\u207b\u00b9", "1/minute", "1 / min", "min^-1", "RPM"], 1.0).items(),
        ("kHz", 60e3),
        ("rad/s", 30 / np.pi),
        ("deg/s", 1 / 6),
    ],
)
def test_frequency_of_a_spindle_is_revolutions_not_radians(unit: str, rpm: float) -> None:
    assert conversion(unit, ("rpm", "m/s")).convert(np.array([1.0])) == pytest.approx([rpm])


@pytest.mark.parametrize(
    ("unit", "target"), [("kN", "N"), ("kPa", "Pa"), ("%", "1"), ("%", "dimensionless")]
)
def test_usual_scale_is_that_of_the_registry(unit: str, target: str) -> None:
    # a space before the unit takes the way through the registry
    assert conversion(unit, ("m", target)) == conversion(f" {unit}", ("m", target))


@pytest.mark.parametrize(
    ("unit", "target"),
    [("counts/s", "rpm"), ("cps", "rpm"), ("count", "dimensionless"), ("dB", "dimensionless")],
)
def test_pulses_and_decibels_convert_to_nothing(unit: str, target: str) -> None:
    with pytest.raises(ValueError, match=f"is none of {target}"):
        conversion(unit, (target,))


@pytest.mark.parametrize("unit", ["\u00baC", "\u02da C", "\u00b0 C", "Celsius"])
def test_signs_that_keyboards_give_for_a_degree_are_read(unit: str) -> None:
    assert conversion(unit, ("degC",)).convert(np.array([70.0])) == pytest.approx([70.0])


def test_kilopond_is_a_kilogram_force() -> None:
    assert conversion("kp", ("N",)).convert(np.array([1.0])) == pytest.approx([9.80665])


@pytest.mark.parametrize(("unit", "newton"), [("\u043c\u041d", 1e-3), ("\u043a\u041d", 1e3)])
def test_cyrillic_newtons_keep_their_prefix(unit: str, newton: float) -> None:
    assert conversion(unit, ("N",)).convert(np.array([1.0])) == pytest.approx([newton])


def test_cyrillic_meganewton_is_not_read_as_millinewton() -> None:
    with pytest.raises(ValueError, match="is none of N"):
        conversion("\u041c\u041d", ("N",))


@pytest.mark.parametrize("unit", ["10**10**10", "9^9^9^9", "N*1e9", "N" * 41, "(N)", "N; N"])
def test_unit_that_is_no_product_of_words_is_refused_uncomputed(unit: str) -> None:
    with pytest.raises(ValueError, match="is none of N"):
        conversion(unit, ("N",))
