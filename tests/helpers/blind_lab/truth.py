"""What is true in the blind laboratory: oils, contacts and traction, by formulas of its own."""

import math
from dataclasses import dataclass

import numpy as np

Array = np.ndarray


@dataclass(frozen=True)
class Machine:
    """A ball on a disc of the same steel; lengths in m, modulus in Pa."""

    ball_radius: float
    ball_track: float
    disc_track: float
    youngs_modulus: float
    poisson: float
    roughness: float  # Ra of either body, in m

    @property
    def plane_strain_modulus(self) -> float:
        """Contact modulus E*, 1/E* = 2 (1 - nu^2)/E."""
        return self.youngs_modulus / (2 * (1 - self.poisson**2))

    def load(self, pressure: float) -> float:
        """Load in N of a maximum Hertz pressure in Pa: F = (pi p)^3 R^2 / (6 E*^2)."""
        return (math.pi * pressure) ** 3 * self.ball_radius**2 / (6 * self.plane_strain_modulus**2)

    def pressure(self, load: Array) -> Array:
        """Maximum Hertz pressure in Pa of a load in N."""
        return np.cbrt(6 * load * self.plane_strain_modulus**2 / self.ball_radius**2) / math.pi


@dataclass(frozen=True)
class Oil:
    """An oil: ASTM D341 viscosity, and traction mu = (B S - a) exp(-C S) + a.

    a (`plateau`), B (`slope`) and C (`decay`) are each k P^p U^u T^t with P in GPa, U over 20 m/s
    and T over 20 degC. Their four numbers are k, p, u and t.
    """

    names: tuple[str, ...]
    cst_40: float
    cst_100: float
    density: float  # kg/m3
    plateau: tuple[float, float, float, float]
    slope: tuple[float, float, float, float]
    decay: tuple[float, float, float, float]

    @property
    def astm_d341(self) -> tuple[float, float]:
        """Intercept and slope of log10 log10(nu + 0.7) over log10 T, T in K."""
        at_40 = math.log10(math.log10(self.cst_40 + 0.7))
        at_100 = math.log10(math.log10(self.cst_100 + 0.7))
        slope = (at_40 - at_100) / (math.log10(373.15) - math.log10(313.15))
        return at_100 + slope * math.log10(373.15), slope

    def traction(self, pressure_gpa: Array, speed: Array, celsius: Array, slip: Array) -> Array:
        """Traction coefficient; odd in the slip."""
        plateau, slope, decay = (
            k * pressure_gpa**p * (speed / 20) ** u * (celsius / 20) ** t
            for k, p, u, t in (self.plateau, self.slope, self.decay)
        )
        size = np.abs(slip)
        return np.sign(slip) * ((slope * size - plateau) * np.exp(-decay * size) + plateau)

    @property
    def constants(self) -> list[float]:
        """The twelve constants of Eqs 7-9, signs included: A is the negative plateau."""
        k, *exponents = self.plateau
        return [-k, *exponents, *self.slope, *self.decay]


def draw_machine(random: np.random.Generator) -> Machine:
    """A machine as laboratories have them."""
    return Machine(
        ball_radius=random.choice([0.009525, 0.010, 0.0127]),
        ball_track=random.uniform(0.008, 0.012),
        disc_track=random.uniform(0.035, 0.045),
        youngs_modulus=random.uniform(203e9, 210e9),
        poisson=random.uniform(0.28, 0.30),
        roughness=random.uniform(12e-9, 18e-9),
    )


def draw_oil(random: np.random.Generator, names: tuple[str, ...]) -> Oil:
    """An oil within what the literature reports of turbine oils."""
    cst_100 = random.uniform(4.0, 6.0)

    def around(k: float, p: float, u: float, t: float) -> tuple[float, float, float, float]:
        spread = random.uniform(-0.15, 0.15, 3)
        return k * random.uniform(0.8, 1.25), p + spread[0], u + spread[1], t + spread[2]

    return Oil(
        names=names,
        cst_40=cst_100 * random.uniform(4.8, 5.4),
        cst_100=cst_100,
        density=random.uniform(930, 990),
        plateau=around(0.030, 0.8, -0.4, -0.3),
        slope=around(0.9, 0.5, -0.3, -0.4),
        decay=around(28.0, 0.3, 0.2, 0.1),
    )
