"""Hertz contact of two smooth, elastic bodies: load, pressure, size and approach.

All quantities are in SI units. Arguments are floats or arrays that broadcast against each other.
The theory holds while the contact is small against the radii, the bodies stay elastic and
friction is low.

Decides: pressure, size and approach of a Hertz contact.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
import scipy

from oilfilm.base.units import PA_PER_GPA, FloatArray

# A number or an array of numbers, in the unit of the argument.
Floats = FloatArray | float


@dataclass(frozen=True)
class Conditions:
    """Operating conditions of contacts, beside the slip; floats or arrays that broadcast.

    Attributes:
        load_n: Normal load W, in N.
        max_hertz_pressure_gpa: Maximum pressure p0, in GPa.
        entrainment_speed_m_s: Mean of the two surface speeds in the middle of the contact, in m/s.
        inlet_temperature_c: Temperature of the oil at the inlet, in degC.
        radius_x_m: Reduced radius along the rolling direction, in m.
        reduced_modulus_pa: E' = 2 E*, in Pa.
        ellipticity: Semi-axis across the rolling direction over that along it; 1 on a flat.
    """

    load_n: FloatArray
    max_hertz_pressure_gpa: FloatArray
    entrainment_speed_m_s: FloatArray
    inlet_temperature_c: FloatArray
    radius_x_m: FloatArray
    reduced_modulus_pa: float
    ellipticity: Floats = 1.0

    @property
    def relative_pressure(self) -> FloatArray:
        """p0/E'."""
        return np.asarray(self.max_hertz_pressure_gpa * PA_PER_GPA / self.reduced_modulus_pa)

    def select(self, *index: Any) -> "Conditions":
        """The conditions with the same index applied to each array; single numbers stay."""

        def selected(values: Floats) -> Any:
            """The values at the index; a single number stays."""
            return values[index] if isinstance(values, np.ndarray) and values.ndim else values

        return Conditions(
            load_n=selected(self.load_n),
            max_hertz_pressure_gpa=selected(self.max_hertz_pressure_gpa),
            entrainment_speed_m_s=selected(self.entrainment_speed_m_s),
            inlet_temperature_c=selected(self.inlet_temperature_c),
            radius_x_m=selected(self.radius_x_m),
            reduced_modulus_pa=self.reduced_modulus_pa,
            ellipticity=selected(self.ellipticity),
        )


@dataclass(frozen=True)
class EllipticalContact:
    """Result of `elliptical_contact`; x is along and y is across the rolling direction.

    Attributes:
        semi_axis_x_m: Semi-axis along x, in m.
        semi_axis_y_m: Semi-axis along y, in m.
        ellipticity: semi_axis_y_m / semi_axis_x_m.
        max_hertz_pressure_pa: Maximum pressure, in the centre, in Pa.
        approach_m: Approach of distant points of the two bodies, in m.
    """

    semi_axis_x_m: FloatArray
    semi_axis_y_m: FloatArray
    ellipticity: FloatArray
    max_hertz_pressure_pa: FloatArray
    approach_m: FloatArray


def reduced_modulus(e1_pa: Floats, nu1: Floats, e2_pa: Floats, nu2: Floats) -> FloatArray:
    """Reduced elastic modulus E' of two bodies, as lubrication theory writes it.

        1/E' = 1/2 [(1 - nu1^2)/E1 + (1 - nu2^2)/E2]

    E' is twice Johnson's contact modulus E*. This library uses E' everywhere.

    Args:
        e1_pa: Young's modulus of the first body, in Pa.
        nu1: Poisson's ratio of the first body.
        e2_pa: Young's modulus of the second body, in Pa.
        nu2: Poisson's ratio of the second body.

    Returns:
        E', in Pa.

    Reference: B. J. Hamrock and D. Dowson, J. Lubr. Technol. 99 (1977) 264, nomenclature.

    Examples:
        For two equal bodies E' = E/(1 - nu^2), here 203 GPa/0.9159 by hand:

        >>> print(f"{reduced_modulus(203e9, 0.29, 203e9, 0.29) / 1e9:.1f} GPa")
        221.6 GPa
    """
    return np.asarray(2 / ((1 - nu1**2) / e1_pa + (1 - nu2**2) / e2_pa))


def max_hertz_pressure(load_n: Floats, radius_m: Floats, reduced_modulus_pa: Floats) -> FloatArray:
    """Maximum pressure of a circular contact.

        p0 = (6 W E*^2 / (pi^3 R^2))^(1/3),   E* = E'/2

    Args:
        load_n: Normal load W, in N.
        radius_m: Reduced radius R, the same in both planes, in m.
        reduced_modulus_pa: E' = 2 E*, in Pa.

    Returns:
        p0, in Pa: 3/2 of the mean pressure.

    Reference: K. L. Johnson, Contact Mechanics, Cambridge (1985), Eq. 4.24.

    Examples:
        A 20 mm steel ball on a flat reaches 1.0 GPa under 42.1 N:

        >>> steel = reduced_modulus(203e9, 0.29, 203e9, 0.29)
        >>> print(f"{max_hertz_pressure(42.1, 0.010, steel) / 1e9:.3f} GPa")
        1.000 GPa
    """
    contact_modulus = reduced_modulus_pa / 2
    return np.cbrt(6 * load_n * contact_modulus**2 / (np.pi**3 * radius_m**2))


def load_for_max_hertz_pressure(
    max_hertz_pressure_pa: Floats, radius_m: Floats, reduced_modulus_pa: Floats
) -> FloatArray:
    """Load that gives a circular contact its maximum pressure; inverse of `max_hertz_pressure`.

        W = pi^3 R^2 p0^3 / (6 E*^2),   E* = E'/2

    Args:
        max_hertz_pressure_pa: Maximum pressure p0, in Pa.
        radius_m: Reduced radius R, the same in both planes, in m.
        reduced_modulus_pa: E' = 2 E*, in Pa.

    Returns:
        W, in N.

    Reference: K. L. Johnson, Contact Mechanics, Cambridge (1985), Eq. 4.24 solved for the load.

    Examples:
        A 20 mm steel ball on a flat at 1.5 GPa:

        >>> steel = reduced_modulus(203e9, 0.29, 203e9, 0.29)
        >>> print(f"{load_for_max_hertz_pressure(1.5e9, 0.010, steel):.0f} N")
        142 N
    """
    contact_modulus = reduced_modulus_pa / 2
    return np.asarray(np.pi**3 * radius_m**2 * max_hertz_pressure_pa**3 / (6 * contact_modulus**2))


def contact_radius(load_n: Floats, radius_m: Floats, reduced_modulus_pa: Floats) -> FloatArray:
    """Radius of a circular contact.

        a = (3 W R / (4 E*))^(1/3),   E* = E'/2

    Args:
        load_n: Normal load W, in N.
        radius_m: Reduced radius R, the same in both planes, in m.
        reduced_modulus_pa: E' = 2 E*, in Pa.

    Returns:
        a, in m.

    Reference: K. L. Johnson, Contact Mechanics, Cambridge (1985), Eq. 4.22.

    Examples:
        Load over area is the mean pressure, two thirds of the 1.5 GPa that 142 N give:

        >>> steel = reduced_modulus(203e9, 0.29, 203e9, 0.29)
        >>> area = np.pi * contact_radius(142, 0.010, steel) ** 2
        >>> print(f"{142 / area / 1e9:.3f} GPa")
        1.000 GPa
    """
    contact_modulus = reduced_modulus_pa / 2
    return np.cbrt(3 * load_n * radius_m / (4 * contact_modulus))


def ellipticity(radius_x_m: Floats, radius_y_m: Floats) -> FloatArray:
    """Ratio k = a_y/a_x of the semi-axes of an elliptical contact, exactly.

        Ry/Rx = R_D(0, k^2, 1) / R_D(0, 1, k^2)

    with Carlson's complete elliptic integral R_D. For k > 1 and e^2 = 1 - 1/k^2 this is the
    textbook equation Ry/Rx = [k^2 E(e) - K(e)] / [K(e) - E(e)]. Unlike that equation it holds for
    k < 1 too and loses no digits near k = 1.

    Args:
        radius_x_m: Reduced radius in the rolling direction, in m.
        radius_y_m: Reduced radius across it, in m.

    Returns:
        k, above 1 where the contact is wider than long. NaN where a radius is NaN or infinite.

    Raises:
        ValueError: A radius is zero or negative: the surfaces do not meet in one point.

    References: K. L. Johnson, Contact Mechanics, Cambridge (1985), Eq. 4.28; NIST Digital Library
        of Mathematical Functions, section 19.25(i), for K and E in terms of R_D.

    Examples:
        Near k = 1 k grows as (Ry/Rx)^(2/3) (Greenwood, J. Tribol. 107 (1985) 501, abstract):

        >>> print(f"{np.log(ellipticity(1.0, 1.001)) / np.log(1.001):.4f}")
        0.6667
    """
    if np.any(np.less_equal(radius_x_m, 0)) or np.any(np.less_equal(radius_y_m, 0)):
        raise ValueError("reduced radii of an elliptical contact must be positive")
    log_ratio = np.log(np.divide(radius_y_m, radius_x_m))
    # |ln k| is below |ln(Ry/Rx)|. With the 1, rounding cannot decide the signs where both are 0.
    log_k_bound = np.abs(log_ratio) + 1
    # imported here because the import takes half a second and a ball on a flat does not need it
    from scipy.optimize import elementwise  # noqa: PLC0415

    root = elementwise.find_root(_ellipticity_error, (-log_k_bound, log_k_bound), args=(log_ratio,))
    return np.exp(root.x)


def _ellipticity_error(log_k: FloatArray, log_ratio: FloatArray) -> FloatArray:
    """ln of the radius ratio that belongs to k, minus ln(Ry/Rx)."""
    k_squared = np.exp(2 * log_k)
    numerator = scipy.special.elliprd(0, k_squared, 1)
    denominator = scipy.special.elliprd(0, 1, k_squared)
    return np.log(numerator / denominator) - log_ratio


def elliptical_contact(
    load_n: Floats, radius_x_m: Floats, radius_y_m: Floats, reduced_modulus_pa: Floats
) -> EllipticalContact:
    """Semi-axes, maximum pressure and approach of an elliptical contact, exactly.

        a_x^3 = 2 W Rx R_D(0, k^2, 1) / (pi E'),   a_y = k a_x
        p0    = 3 W / (2 pi a_x a_y)
        delta = 3 W R_F(0, 1, k^2) / (pi E' a_x)

    with k from `ellipticity` and Carlson's complete elliptic integrals R_D and R_F. For k > 1,
    R_D(0, k^2, 1) = 3 [k^2 E(e) - K(e)]/(k^3 e^2) and R_F(0, 1, k^2) = K(e)/k.

    Args:
        load_n: Normal load W, in N.
        radius_x_m: Reduced radius Rx in the rolling direction, in m.
        radius_y_m: Reduced radius Ry across it, in m.
        reduced_modulus_pa: E' = 2 E*, in Pa.

    Returns:
        The contact, each attribute of the arguments' broadcast shape.

    Raises:
        ValueError: A radius is zero or negative: the surfaces do not meet in one point.

    Reference: K. L. Johnson, Contact Mechanics, Cambridge (1985), Eqs 4.26 to 4.28.

    Examples:
        Inner ring of a 218 angular-contact bearing, 1679 N at 41.50 degrees:

        >>> ball, cosine = 22.23e-3 / 2, np.cos(np.radians(41.50))
        >>> steel = reduced_modulus(207.5e9, 0.3, 207.5e9, 0.3)
        >>> along = 1 / (1 / ball + 1 / (125.26e-3 / (2 * cosine) - ball))
        >>> across = 1 / (1 / ball - 1 / 11.63e-3)
        >>> contact = elliptical_contact(1679, along, across, steel)
        >>> print(f"{contact.max_hertz_pressure_pa / 1e9:.3f} GPa")
        1.526 GPa
    """
    k = ellipticity(radius_x_m, radius_y_m)
    r_d = scipy.special.elliprd(0, k**2, 1)
    r_f = scipy.special.elliprf(0, 1, k**2)
    a_x = np.cbrt(2 * load_n * radius_x_m * r_d / (np.pi * reduced_modulus_pa))
    a_y = k * a_x
    return EllipticalContact(
        semi_axis_x_m=a_x,
        semi_axis_y_m=a_y,
        ellipticity=k + np.zeros_like(a_x),
        max_hertz_pressure_pa=3 * load_n / (2 * np.pi * a_x * a_y),
        approach_m=3 * load_n * r_f / (np.pi * reduced_modulus_pa * a_x),
    )


# a_x/a_y of Kalker's table: 0.1, 0.2, ... 1, then 1/0.9, 1/0.8, ... 10.
_AXIS_RATIOS = np.concatenate([np.arange(0.1, 1.0, 0.1), 1 / np.arange(1.0, 0.0, -0.1)])
# Kalker's C11 at these ratios, for Poisson's ratios of 0.25 and 0.5.
_C11 = np.array(
    """
    3.31 3.37 3.44 3.53 3.62 3.72 3.81 3.91 4.01 4.12 4.22 4.36 4.54 4.78 5.10 5.57 6.34 7.78 11.7
    4.85 4.81 4.80 4.82 4.83 4.91 4.97 5.05 5.12 5.20 5.30 5.42 5.58 5.80 6.11 6.57 7.34 8.82 12.9
    """.split(),
    dtype=float,
).reshape(2, -1)
# Poisson's ratio of the bodies, assumed.
_POISSON_RATIO = 0.3


def creep_slope(relative_pressure: Floats, ellipticity: Floats = 1.0) -> FloatArray:
    """Traction over slip by elastic creep, for two bodies that roll on each other without a film.

        mu/S = G a_x a_y C11/W = 3 (1 - nu) C11/(4 pi) E'/p0

    Bodies that pull on each other stretch in the contact. They have a slip S even if no point of
    the surfaces slides. A film can only add slip: no oil gives more traction at small slip.

    Args:
        relative_pressure: p0/E'.
        ellipticity: a_y/a_x, semi-axis across the rolling direction over that along it. C11 is
            constant below 0.1 and above 10.

    Returns:
        mu/S in the limit of small slip.

    Validity: bodies of one material. Poisson's ratio is 0.3: from 0.25 to 0.35, (1 - nu) C11
        changes by 2 % only.

    Reference: J. J. Kalker, On the rolling contact of two elastic bodies in the presence of dry
        friction, thesis, Delft (1967), linear theory; his table in Three-Dimensional Elastic Bodies
        in Rolling Contact, Kluwer (1990), appendix E (second-hand, two transcriptions that agree).

    Examples:
        Steel at 1.5 GPa, E' 221.6 GPa, C11 4.34 from the table. By hand
        3 * 0.7 * 4.34/(4 pi) * 147.7:

        >>> print(f"{creep_slope(1.5 / 221.6):.0f}")
        107
    """
    # between the rows for Poisson's ratios of 0.25 and 0.5
    weight_of_second = (_POISSON_RATIO - 0.25) / 0.25
    c11_of_table = (1 - weight_of_second) * _C11[0] + weight_of_second * _C11[1]
    c11 = np.interp(-np.log(ellipticity), np.log(_AXIS_RATIOS), c11_of_table)
    return np.asarray(3 * (1 - _POISSON_RATIO) * c11 / (4 * np.pi * np.asarray(relative_pressure)))


# ---------------------------------------------------------------- traction rigs


@dataclass(frozen=True)
class Contact:
    """Contact of a ball on a flat disc: geometry, materials and roughness.

    Attributes:
        radius_m: Reduced radius, equal to the radius of the ball, in m.
        reduced_modulus_pa: E' = 2 E*, in Pa.
        roughness_rq_m: Root-sum-square of both surfaces' Rq, in m.
    """

    radius_m: float
    reduced_modulus_pa: float
    roughness_rq_m: float

    def load_n(self, max_hertz_pressure_gpa: FloatArray | float) -> FloatArray:
        """Load in N at which the contact has a maximum Hertz pressure, given in GPa."""
        return load_for_max_hertz_pressure(
            max_hertz_pressure_gpa * PA_PER_GPA, self.radius_m, self.reduced_modulus_pa
        )


def rq_from_ra(ra_m: Floats) -> FloatArray:
    """Root-mean-square roughness where only the mean roughness is known.

        Rq = 1.25 Ra

    This is a convention and not a law. The factor of a Gaussian profile is sqrt(pi/2) = 1.2533,
    that of a sine wave 1.11, that of a plateau-honed surface larger.

    Args:
        ra_m: Arithmetic mean roughness Ra, in m.

    Returns:
        Rq, in m.

    Examples:
        The rig's root-sum-square Ra of 0.0172 um (docs/physics.md):

        >>> print(f"{rq_from_ra(0.0172e-6) * 1e6:.4f} um")
        0.0215 um
    """
    return np.asarray(1.25 * ra_m)


def combined_roughness(rq_1_m: Floats, rq_2_m: Floats) -> FloatArray:
    """Combined roughness of two surfaces with independent profiles.

        sigma = sqrt(Rq1^2 + Rq2^2)

    Args:
        rq_1_m: Root-mean-square roughness of the first surface, in m.
        rq_2_m: Root-mean-square roughness of the second surface, in m.

    Returns:
        sigma, in m. With Ra values as arguments it is the combined Ra.

    Examples:
        Ball and disc of the rig, Ra 0.014 and 0.010 um, have 0.0172 um together (docs/physics.md):

        >>> print(f"{combined_roughness(0.014e-6, 0.010e-6) * 1e6:.4f} um")
        0.0172 um
    """
    return np.hypot(rq_1_m, rq_2_m)
