"""A shear-thinning film with a power law and a limiting stress, at one temperature.

    mu = L [1 - exp(-c/L)],   c = N S [1 + (N S/G)^2]^((n - 1)/2)

c is the stress without limit. All stresses are relative to the mean pressure: N = eta U/(h p) is
the slope at S = 0, G the stress at which shear thinning begins, L = tau_L/p. n and the stress G p
are properties of the oil and equal at all conditions, hence G = G0 P^-1. n is limited to 0.9: near
1 there is no shear thinning, and G has no effect. The law always rises with slip, because it has no
heating.

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
        Coefficient("N", +1, 1e-2, 1e4, multiplies_slip=True),
        Coefficient("G", +1, 1e-4, 1.0, exponents=(-1.0, 0.0, 0.0)),
        Coefficient("n", +1, 1e-2, 0.9, exponents=(0.0, 0.0, 0.0)),
        Coefficient("L", +1, 1e-3, 1.0),
    ),
)
