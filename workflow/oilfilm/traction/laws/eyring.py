"""A shear-thinning film by Eyring with a limiting stress, softened by friction heat.

    mu = m/(1 + H S mu),   m = L [1 - exp(-e/L)],   e = E asinh(N S/E)

e is the stress without limit and heat, m the stress without heat. All stresses are relative to the
mean pressure: N = eta U/(h p) is the slope at S = 0, E = tau_E/p, L = tau_L/p. The friction heat is
proportional to mu S, and H is the loss of stress by this heat, a power law like the others. The
decrease of the stress as 1/(1 + temperature rise) is OURS. It keeps the law explicit: the equation
below is solved for mu, in a form without cancellation. Without heat (H = 0) it is the isothermal
law. tau_E is a property of the oil and equal at all conditions, hence E = E0 P^-1.

References: K. L. Johnson, J. L. Tevaarwerk, Proc. R. Soc. Lond. A 356 (1977) 215; S. Bair,
W. O. Winer, J. Lubr. Technol. 101 (1979) 258; the stresses as in
`oilfilm.physics.thermal_traction`.
"""

from oilfilm.traction.law import Coefficient, Law

EYRING = Law(
    name="eyring",
    title="Johnson-Tevaarwerk (Eyring)",
    source=(
        "Johnson and Tevaarwerk, Proc. R. Soc. Lond. A 356 (1977) 215, with the limit of Bair and "
        "Winer (1979); the heat is ours"
    ),
    equation="2*m/(1 + sqrt(1 + 4*H*S*m))",
    parts=(("e", "E*asinh(N*S/E)"), ("m", "-L*expm1(-e/L)")),
    coefficients=(
        Coefficient("N", +1, 1e-2, 1e4, multiplies_slip=True),
        Coefficient("E", +1, 1e-4, 1.0, exponents=(-1.0, 0.0, 0.0)),
        Coefficient("L", +1, 1e-3, 1.0),
        Coefficient("H", +1, 1e-2, 1e5, multiplies_slip=True),
    ),
)
