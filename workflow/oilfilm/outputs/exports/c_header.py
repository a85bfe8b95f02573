"""The law as a C99 header, which is C++11 as well."""

from oilfilm.outputs.exports.description import SLIP, Description
from oilfilm.outputs.exports.header import arguments, header

# A factor a line.
_TIMES = "\n        * "


def c_header(description: Description) -> str:
    """Two inline functions: mu, and whether it is extrapolated. They need libm only."""
    name, given = description.identifier, description.arguments
    guard = f"OILFILM_TRACTION_{name.upper()}_H"
    results = [
        f"traction_coefficient_{name}() returns mu, of the sign of S"
        + "; NAN unless pressure, speed and temperature are above 0" * bool(given),
        f"outside_tested_box_{name}() returns 1 where mu is extrapolated, else 0",
    ]
    comment = header(description, arguments(description), results, " * ")
    parameters = ",\n    ".join(f"double {one}" for one in description.argument_names)
    positive = " && ".join(f"{one.name} > 0.0" for one in given)
    check = f"    if (!({positive})) {{\n        return NAN;\n    }}\n" if given else ""
    bars = "".join(
        f"    const double {one.symbol.lower()} = {one.name} / {one.reference!r};\n"
        for one in given
    )
    power = "pow({}, {})".format
    products = "".join(
        f"    const double {letter} = {description.product(letter, power, _TIMES)};\n"
        for letter in description.powers
    )
    inside = "\n        && ".join(
        [
            *(f"{one.name} >= {one.lower!r} && {one.name} <= {one.upper!r}" for one in given),
            f"fabs({SLIP}) <= {description.slip_upper!r}",
        ]
    )
    return f"""\
/*
{comment}
 */
#ifndef {guard}
#define {guard}

#include <math.h>

static inline double traction_coefficient_{name}(
    {parameters})
{{
{check}{bars}{products}    const double S = fabs({SLIP});
    return copysign({description.formula}, {SLIP});
}}

static inline int outside_tested_box_{name}(
    {parameters})
{{
    return !({inside});
}}

#endif
"""
