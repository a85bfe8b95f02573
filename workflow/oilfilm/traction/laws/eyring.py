"""A film that thins by Eyring's rule up to a limiting stress, softened by its own heat.

    mu = m/(1 + H S mu),   m = L [1 - exp(-e/L)],   e = E asinh(N S/E)

All stresses are over the mean pressure: N the slope at rest eta U/(h p), E = tau_E/p, L = tau_L/p.
The heat that arises goes with mu S; H is how much of its stress the film loses to it, a power law
like the others. That the stress falls as 1/(1 + temperature rise) is OURS, and keeps the law
explicit: below it is solved for mu, in a form without cancellation. Without heat (H = 0) it is the
isothermal law. tau_E is taken for a property of the oil, the same at every condition, hence
E = E0 P^-1.

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
        Coefficient("N", +1, 1e-2, 1e4, per_slip=True),
        Coefficient("E", +1, 1e-4, 1.0, exponents=(-1.0, 0.0, 0.0)),
        Coefficient("L", +1, 1e-3, 1.0),
        Coefficient("H", +1, 1e-2, 1e5, per_slip=True),
    ),
)
