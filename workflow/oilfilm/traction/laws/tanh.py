"""The smooth step of many vehicle and bearing codes: traction rises to a constant level.

    mu = A tanh(B S/A)

with A the level and B the slope at S = 0. It always rises with slip and has no peak.

Reference: in general use as a regularised Coulomb law; no single source.
"""

from oilfilm.traction.law import Coefficient, Law

TANH = Law(
    name="tanh",
    title="hyperbolic tangent",
    source="in general use; no single source",
    equation="A*tanh(B*S/A)",
    coefficients=(
        Coefficient("A", +1, 1e-4, 1.0),
        Coefficient("B", +1, 1e-2, 1e4, multiplies_slip=True),
    ),
)
