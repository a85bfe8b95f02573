"""The law as a Python module that needs NumPy alone."""

from oilfilm.exports.code import assignments, result
from oilfilm.exports.description import SLIP, Description
from oilfilm.exports.header import arguments, header
from oilfilm.traction.expression import Form, Language

_FUNCTIONS = ("exp", "expm1", "log", "log1p", "sqrt", "tanh", "abs", "sign")
PYTHON = Language(
    {name: Form(f"np.{name}({{}})") for name in _FUNCTIONS} | {"asinh": Form("np.arcsinh({})")}
)
_HELPER = """\
def _above_zero(value):
    return np.where(np.greater(value, 0), value, np.nan)


"""


def python_module(description: Description) -> str:
    """Two functions of arrays: mu, and whether it is extrapolated."""
    names = description.argument_names
    results = [
        f"traction_coefficient() returns {result(description, 'NaN')}",
        "outside_tested_box() is True where mu is extrapolated",
        "Arguments are numbers or arrays that broadcast against each other",
    ]
    text = header(description, arguments(description), results, mark="")
    parameters = ",\n    ".join(names)
    checks = "".join(f"    {name} = _above_zero({name})\n" for name in names[:-1])
    steps = assignments(description, PYTHON, "    {} = {}\n", " \\\n        ")
    helper = _HELPER if description.arguments else ""
    tested = "".join(
        f"        ({condition.name}, {condition.tested[0]!r}, {condition.tested[1]!r}),\n"
        for condition in description.arguments
    )
    return f'''\
"""{text}
"""

import numpy as np


def traction_coefficient(
    {parameters},
):
    """mu, of the sign of {SLIP}; units and tested box are above."""
{checks}{steps}    return np.where(np.less({SLIP}, 0), -mu, mu)[()]


{helper}def outside_tested_box(
    {parameters},
):
    """True where an argument lies outside the tested box: mu is extrapolated there."""
    tested = (
{tested}        (np.abs({SLIP}), 0.0, {description.slip.tested[1]!r}),
    )
    inside = [np.greater_equal(x, low) & np.less_equal(x, high) for x, low, high in tested]
    return ~np.all(np.broadcast_arrays(*inside), axis=0)[()]
'''
