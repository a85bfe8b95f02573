"""A film with a limiting stress by the circular law, softened by friction heat.

    mu = m/(1 + H S mu),   m = N S/sqrt(1 + (N S/L)^2)

m is the stress without heat. All stresses are relative to the mean pressure p. N = eta U/(h p) is
the slope at S = 0 in a film of thickness h. L = tau_L/p is the level without heat. H is the loss of
stress by friction heat (see `EYRING`). The film has no shear thinning beside the limit, so that the
law has one coefficient less than `EYRING`. The viscosity, and with it N, has an exponential of the
inlet temperature, as in Johnson and Tevaarwerk. The heat term and the exponentials of L and H are
OURS.

References: R.-T. Lee, B. J. Hamrock, A circular non-Newtonian fluid model: part I, J. Tribol. 112
(1990) 486 (its abstract names the circular model and its limiting shear strength; the equation was
not compared with the paper); K. L. Johnson, J. L. Tevaarwerk, Proc. R. Soc. Lond. A 356 (1977) 215.
"""

from oilfilm.traction.law import Coefficient, Law

CIRCULAR = Law(
    name="circular",
    title="Lee-Hamrock (circular)",
    source=(
        "Lee and Hamrock, J. Tribol. 112 (1990) 486, circular law of a limiting stress; the heat "
        "and the exponential of T are ours"
    ),
    equation="2*m/(1 + sqrt(1 + 4*H*S*m))",
    parts=(("m", "N*S/sqrt(1 + (N*S/L)**2)"),),
    coefficients=(
        Coefficient("N", +1, 1e-2, 1e4, multiplies_slip=True),
        # somewhat above the largest limiting stress over pressure of oils, 0.12: with a far larger
        # one the film has no limit, and a search may end in another local minimum
        Coefficient("L", +1, 1e-3, 0.15),
        Coefficient("H", +1, 1e-2, 1e4, multiplies_slip=True),
    ),
    exponential=("inlet_temperature_c",),
)
