"""Traction of oils that no law of the library describes, and one that a law describes.

Each truth gives mu from P in GPa, U in m/s, T in degC and S. Viscosity falls from 0.14 Pa s at
25 degC to 5 mPa s at 120 degC; mu is between 0.0005 and 0.11 at slips of 0.0015 to 0.3.

Only the truths of `INDEPENDENT_TRUTHS` are independent evidence. They were written after the method
of the surface was fixed, and nothing of it was changed since. The results on all others were seen
while the method changed.

The docstrings explain the short names `own`, `ect`, `jt`, `pw`, `sol`, `rat`, `mix` and `wav`. The
names stay because stored results and random numbers depend on them.
"""

from collections.abc import Callable

import numpy as np

from oilfilm.base.units import FloatArray

# mu from P in GPa, U in m/s, T in degC and S.
LawlessTruth = Callable[[FloatArray, FloatArray, FloatArray, FloatArray], FloatArray]

# Constants of Deng's law in its internal form, near those of oil 4102.
DENG_CONSTANTS = np.array(
    [
        *(np.log(0.0157), 1.6654, -0.5014, -0.1065),
        *(np.log(0.635), 1.2727, -0.4139, -1.2181),
        *(np.log(24.4), 0.3964, 0.1591, -0.7121),
    ]
)


def viscosity_pa_s(temperature_c: FloatArray) -> FloatArray:
    """Viscosity at ambient pressure."""
    return np.exp(-9.5 + 900 / (temperature_c + 95))


def _viscosity_in_contact(pressure_gpa: FloatArray, temperature_c: FloatArray) -> FloatArray:
    """Viscosity in the contact, Pa s."""
    rise = (15 - 0.06 * temperature_c) * 0.6 * pressure_gpa
    return viscosity_pa_s(temperature_c) * np.exp(np.minimum(rise, 11.0))


def _film_m(speed_m_s: FloatArray, temperature_c: FloatArray) -> FloatArray:
    """Film thickness, m."""
    return 3e-7 * (viscosity_pa_s(temperature_c) / 0.02 * speed_m_s / 30) ** 0.67


def _eyring_mpa(pressure: FloatArray, speed: FloatArray, temperature: FloatArray, slip: FloatArray):
    """Shear stress of an Eyring fluid with a stress of 5 MPa, MPa."""
    rate = speed * slip / _film_m(speed, temperature)
    newtonian = _viscosity_in_contact(pressure, temperature) * rate * 1e-6
    return 5.0 * np.arcsinh(newtonian / 5.0)


def own(pressure, speed, temperature, slip):
    """Deng's law itself."""
    columns = (np.ones_like(pressure), np.log(pressure), np.log(speed / 20))
    design = np.stack([*columns, np.log(temperature / 20)])
    a, b, c = np.exp(np.tensordot(DENG_CONSTANTS.reshape(3, 4), design, axes=1))
    return (-a + b * slip) * np.exp(-c * slip) + a


def ect(pressure, speed, temperature, slip):
    """Carreau thinning under an Eyring cap, at the temperature of the film."""
    film_temperature = temperature
    for _ in range(20):
        rate = speed * slip / _film_m(speed, temperature)
        viscosity = _viscosity_in_contact(pressure, film_temperature)
        thinned = viscosity * rate * 1e-6 * (1 + (viscosity * rate / 3e6) ** 2) ** -0.36
        stress = 9.0 * np.arcsinh(thinned / 9.0)
        heated = temperature + 0.05 * stress * speed * slip
        film_temperature = (film_temperature + heated) / 2
    return stress / (667 * pressure)


def jt(pressure, speed, temperature, slip):
    """Elastic creep with a limiting stress of its own, and a fall by heat."""
    limit = 0.075 * pressure**0.35 * np.exp(-0.0035 * (temperature - 60))
    strain = 9 * slip * pressure**-0.5 * np.exp(-0.012 * (temperature - 60)) / limit
    strain = strain * (speed / 30) ** -0.4
    creep = (np.arctan(strain) + strain / (1 + strain**2)) * 2 / np.pi
    return limit * creep * np.exp(-0.012 * speed * slip)


def pw(pressure, speed, temperature, slip):
    """Power laws of slip with kinks between them."""
    linear = 6 * slip * pressure**1.2 * np.exp(-0.013 * (temperature - 60)) * (30 / speed) ** 0.3
    turned = 0.05 * pressure**0.6 * (slip / 0.02) ** 0.25 * np.exp(-0.004 * (temperature - 60))
    falling = 0.07 * pressure**0.3 * (slip / 0.1) ** -0.15 * (30 / speed) ** 0.2
    return np.minimum(np.minimum(linear, turned), falling)


def sol(pressure, speed, temperature, slip):
    """A film that turns to glass, with a fall at high slip."""
    limit = 0.085 * np.tanh(pressure) * np.exp(-0.002 * (temperature - 60))
    start = 0.012 * np.exp(0.022 * (temperature - 60) - 1.5 * (pressure - 1.25))
    rising = 1 / (1 + (start / slip) ** 1.1)
    return limit * rising / (1 + (slip * speed / 14) ** 1.5)


def rat(pressure, speed, temperature, slip):
    """A rational law with viscosity."""
    thickness = viscosity_pa_s(temperature) / 0.02
    slope = 5 * pressure**1.5 * thickness**0.6 * (speed / 30) ** -0.2
    bend = 70 * thickness**0.5 * pressure**0.7
    return slope * slip / (1 + bend * slip) / np.sqrt(1 + 1.5 * slip * speed / 30)


def mix(pressure, speed, temperature, slip):
    """An Eyring film, with asperities that carry more as the film gets thinner."""
    ratio = _film_m(speed, temperature) / 0.12e-6
    carried = np.exp(-1.3 * ratio)
    film = _eyring_mpa(pressure, speed, temperature, slip) / (667 * pressure)
    return (1 - carried) * film + carried * 0.11 * np.tanh(slip / 0.012)


def wav(pressure, speed, temperature, slip):
    """Two relaxations in slip, and a bump of 10 % over 14 K of temperature."""
    first = 0.022 * np.tanh(slip / 0.004 * np.exp(-0.02 * (temperature - 60)))
    second = 0.035 * pressure * np.tanh(slip / 0.06 * (30 / speed) ** 0.3)
    bump = 1 + 0.10 * np.exp(-(((temperature - 62) / 14) ** 2))
    return (first + second) * bump * pressure**0.3 * np.exp(-0.003 * (temperature - 60))


def heated_tanh(pressure, speed, temperature, slip):
    """tanh of slip, with a limit that falls as the film gets hot."""
    heat = 0.9 * pressure * speed * slip
    limit = 0.08 * pressure**0.25 * np.exp(-0.004 * (temperature + heat - 60))
    return limit * np.tanh(110 * slip * pressure * np.exp(-0.016 * (temperature - 60)))


def limited_eyring(pressure, speed, temperature, slip):
    """An Eyring film that meets a limiting stress smoothly."""
    film = 1.6 * _eyring_mpa(pressure, speed, temperature, slip) / (667 * pressure)
    limit = 0.07 * np.exp(-0.003 * (temperature - 60)) * pressure**0.2
    return (film**-4 + limit**-4) ** -0.25


def glass_step(pressure, speed, temperature, slip):
    """A step of traction where pressure turns the film to glass."""
    glassy = 1 / (1 + np.exp(-(pressure - 1.2 - 0.004 * (temperature - 60)) / 0.12))
    limit = 0.045 + 0.03 * glassy
    strain = slip * np.exp(-0.012 * (temperature - 60)) * 60 * (1 + 0.8 * glassy)
    return limit * strain / (1 + strain**1.4) ** (1 / 1.4) * (30 / speed) ** (0.4 * slip)


def bair_winer(pressure, speed, temperature, slip):
    """A limiting shear stress that is met exponentially, with an exponential viscosity, and heat.

    Reference: S. Bair, W. O. Winer, J. Lubr. Technol. 101 (1979) 251.
    """
    film_temperature = temperature
    for _ in range(30):
        limit_mpa = 0.085 * 667 * pressure * (1 - 0.002 * (film_temperature - 60))
        viscosity = 0.02 * np.exp(7 * pressure - 0.032 * (film_temperature - 60))
        rate = speed * slip / _film_m(speed, temperature)
        stress = limit_mpa * -np.expm1(-viscosity * rate * 1e-6 / limit_mpa)
        heated = temperature + 0.04 * stress * speed * slip
        film_temperature = (film_temperature + heated) / 2
    return stress / (667 * pressure)


def two_relaxations(pressure, speed, temperature, slip):
    """Thinning by Cross with a slow and a fast relaxation, and Arrhenius' viscosity.

    Reference: M. M. Cross, J. Colloid Sci. 20 (1965) 417.
    """
    arrhenius = 2900 * (1 / (temperature + 273) - 1 / 333)
    viscosity = 0.03 * np.exp(arrhenius + 8 * pressure**0.7)
    newtonian = viscosity * speed * slip / _film_m(speed, temperature) * 1e-6
    slow, fast = 0.85 * newtonian, 0.15 * newtonian
    fast_limit = 25 * pressure**0.9 * np.exp(-0.002 * (temperature - 60))
    stress = slow / (1 + (slow / 3) ** 0.8) + fast / (1 + (fast / fast_limit) ** 0.93)
    return stress / (667 * pressure)


def free_volume(pressure, speed, temperature, slip):
    """Viscosity by Doolittle's free volume, which heat opens and pressure closes.

    Reference: A. K. Doolittle, J. Appl. Phys. 22 (1951) 1471.
    """
    film_temperature = temperature
    limit_mpa = 0.09 * 667 * pressure * (1 - 0.0015 * (temperature - 60))
    for _ in range(30):
        volume = 0.1 + 0.0006 * (film_temperature - 60) - 0.018 * np.log1p(4 * pressure)
        viscosity = 0.0136 * np.exp(0.6 / volume)
        newtonian = viscosity * speed * slip / _film_m(speed, temperature) * 1e-6
        stress = newtonian / (1 + (newtonian / limit_mpa) ** 0.7) ** (1 / 0.7)
        heated = temperature + 0.03 * stress * speed * slip
        film_temperature = (film_temperature + heated) / 2
    return stress / (667 * pressure)


def rounded(pressure, speed, temperature, slip):
    """A rise with a rounded corner, and a fall by heat whose maximum is narrow in ln S.

    Two slips beside the maximum do not show it: three slips hide it.
    """
    limit = 0.061 * (pressure / 1.2) ** 0.45 * np.exp(-(temperature - 60) / 210)
    limit = limit * (speed / 10) ** -0.06
    strain = 120 * slip * (pressure / 1.2) ** 0.9 * np.exp(-(temperature - 60) / 48)
    strain = strain * (speed / 10) ** -0.5
    return limit * strain / (1 + strain**1.7) ** (1 / 1.7) / (1 + 0.55 * (slip * speed / 2) ** 0.9)


TRUTHS: dict[str, LawlessTruth] = {
    truth.__name__: truth
    for truth in (
        *(ect, jt, pw, sol, own, rat, mix, wav),
        *(heated_tanh, limited_eyring, glass_step),
        *(bair_winer, two_relaxations, free_volume),
    )
}
# Truths that were written after the method was fixed.
INDEPENDENT_TRUTHS = ("bair_winer", "two_relaxations", "free_volume")
