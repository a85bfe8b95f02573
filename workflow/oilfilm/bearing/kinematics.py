"""Speeds and slips of a ball bearing from geometry alone, for balls that roll on the outer race.

The outer ring is at rest, the inner ring turns with omega, and both contact angles are equal:
gamma = D cos(alpha)/dm. Balls that roll on both races travel with Omega_0 = omega (1 - gamma)/2.

Decides: which slide-roll ratio a cage slip is, and which entrainment speed a bearing speed is.
"""

from typing import TypeVar

from oilfilm.base.units import MM_PER_M, RAD_S_PER_RPM, FloatArray

AnyFloats = TypeVar("AnyFloats", float, FloatArray)


def surface_speed_m_s(pitch_speed_mm_rpm: AnyFloats, gamma: float = 0.0) -> AnyFloats:
    """Surface speed of the inner race: omega dm (1 - gamma)/2.

    Args:
        pitch_speed_mm_rpm: dmN, pitch diameter times speed of the inner ring.
        gamma: D cos(alpha)/dm; 0 gives the speed at the pitch circle.

    Examples:
        >>> print(f"{surface_speed_m_s(4e6):.1f}")
        209.4
    """
    return pitch_speed_mm_rpm * (1 - gamma) / 2 * RAD_S_PER_RPM / MM_PER_M


def entrainment_speed_m_s(pitch_speed_mm_rpm: AnyFloats, gamma: float = 0.0) -> AnyFloats:
    """Entrainment speed of balls that roll on both races: U = omega dm (1 - gamma^2)/4.

    In the frame of the cage, ball and races move past the contact with the same speed
    Omega_0 dm (1 + gamma)/2. The mean of both surface speeds is the same.

    Args:
        pitch_speed_mm_rpm: dmN, pitch diameter times speed of the inner ring.
        gamma: D cos(alpha)/dm; 0 for balls that are small against the pitch circle.

    Examples:
        >>> print(f"{entrainment_speed_m_s(4e6):.1f} {entrainment_speed_m_s(4e6, 0.12):.1f}")
        104.7 103.2
    """
    return surface_speed_m_s(pitch_speed_mm_rpm, gamma) * (1 + gamma) / 2


def pitch_speed_mm_rpm(entrainment_speed_m_s: AnyFloats, gamma: float = 0.0) -> AnyFloats:
    """dmN at which rolling balls have an entrainment speed; inverse of `entrainment_speed_m_s`.

    Examples:
        >>> print(f"{pitch_speed_mm_rpm(200.0):.3g}")
        7.64e+06
    """
    return 4 * entrainment_speed_m_s / (1 - gamma**2) * MM_PER_M / RAD_S_PER_RPM


def inner_slide_roll_ratio(cage_slip: AnyFloats, gamma: float = 0.0) -> AnyFloats:
    """Slide-roll ratio at the inner race of balls that roll on the outer race.

        S = 2 s/(1 + gamma (1 - s)),   s = 1 - Omega/Omega_0

    In the frame of the cage the inner race has the speed dm/2 (1 - gamma)(omega - Omega). The
    ball's surface has that of the outer race, dm/2 (1 + gamma) Omega. With omega (1 - gamma) =
    2 Omega_0 the two differ by dm Omega_0 s, and their mean is dm/2 Omega_0 (1 + gamma (1 - s)).

    In an equilibrium the two contact angles differ, and the balls creep on the outer race too.
    docs/physics.md shows how much S changes.

    Args:
        cage_slip: Slip s of the cage relative to rolling balls, 0 to 1.
        gamma: D cos(alpha)/dm; 0 for balls that are small against the pitch circle.

    Examples:
        >>> print(f"{inner_slide_roll_ratio(0.15):.2f} {inner_slide_roll_ratio(0.15, 0.118):.3f}")
        0.30 0.273
    """
    return 2 * cage_slip / (1 + gamma * (1 - cage_slip))


def cage_slip(slide_roll_ratio: AnyFloats, gamma: float = 0.0) -> AnyFloats:
    """Cage slip at which balls have this slide-roll ratio at the inner race.

        s = S (1 + gamma)/(2 + gamma S), the inverse of `inner_slide_roll_ratio`

    Examples:
        >>> print(f"{cage_slip(0.3):.3f} {cage_slip(0.3, 0.118):.3f}")
        0.150 0.165
    """
    return slide_roll_ratio * (1 + gamma) / (2 + gamma * slide_roll_ratio)
