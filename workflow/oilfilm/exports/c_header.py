"""The law as a C99 header, which is C++11 as well."""

from oilfilm.exports.code import assignments, box, result
from oilfilm.exports.description import SLIP, Description
from oilfilm.exports.header import arguments, header
from oilfilm.traction.expression import Form, Language

C = Language({"**": Form("pow({}, {})"), "abs": Form("fabs({})")})


def c_header(description: Description) -> str:
    """Two inline functions: mu, and whether it is extrapolated. They need libm only."""
    name = description.identifier
    guard = f"OILFILM_TRACTION_{name.upper()}_H"
    results = [
        f"traction_coefficient_{name}() returns {result(description, 'NAN')}",
        f"outside_tested_box_{name}() returns 1 where mu is extrapolated, else 0",
    ]
    comment = header(description, arguments(description), results, " * ")
    parameters = ",\n    ".join(f"double {argument}" for argument in description.argument_names)
    positive = " && ".join(f"{condition.name} > 0.0" for condition in description.arguments)
    check = f"    if (!({positive})) {{\n        return NAN;\n    }}\n" if positive else ""
    steps = assignments(description, C, "    const double {} = {};\n")
    inside = "\n        && ".join(box(description))
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
{check}{steps}    return {SLIP} < 0.0 ? -mu : mu;
}}

static inline int outside_tested_box_{name}(
    {parameters})
{{
    return !({inside});
}}

#endif
"""
