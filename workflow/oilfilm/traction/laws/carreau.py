"""A film that thins by a power law up to a limiting stress, at one temperature.

    mu = L [1 - exp(-c/L)],   c = N S [1 + (N S/G)^2]^((n - 1)/2)

All stresses are over the mean pressure: N the slope at rest eta U/(h p), G the stress at which
thinning begins, L = tau_L/p. n and the stress G p are taken for properties of the oil, the same at
every condition, hence G = G0 P^-1. n stays below 0.9: nearer to 1 nothing thins and G could be
anything. The law rises with slip for ever: nothing heats it.

References: P. J. Carreau, Trans. Soc. Rheol. 16 (1972) 99, in the form with a stress of S. Bair,
High Pressure Rheology for Quantitative Elastohydrodynamics, Elsevier (2007); S. Bair, W. O. Winer,
J. Lubr. Technol. 101 (1979) 258.
"""

from oilfilm.traction.law import Coefficient, Law

CARREAU = Law(
    name="carreau",
    title="Carreau",
    source="Bair, High Pressure Rheology (2007), with the limit of Bair and Winer (1979)",
    equation="-L*expm1(-c/L)",
    parts=(("c", "N*S*(1 + (N*S/G)**2)**((n - 1)/2)"),),
    coefficients=(
        Coefficient("N", +1, 1e-2, 1e4, per_slip=True),
        Coefficient("G", +1, 1e-4, 1.0, exponents=(-1.0, 0.0, 0.0)),
        Coefficient("n", +1, 1e-2, 0.9, exponents=(0.0, 0.0, 0.0)),
        Coefficient("L", +1, 1e-3, 1.0),
    ),
)
