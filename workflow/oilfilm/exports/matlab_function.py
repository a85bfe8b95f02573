"""The law as a function of MATLAB and GNU Octave."""

from oilfilm.exports.code import assignments, box, result
from oilfilm.exports.description import SLIP, Description
from oilfilm.exports.header import arguments, header
from oilfilm.traction.expression import Form, Language

MATLAB = Language(
    {
        "*": Form("{} .* {}", 2, (2, 3)),
        "/": Form("{} ./ {}", 2, (2, 3)),
        "**": Form("{} .^ {}", 4, (5, 5)),
    }
)


def matlab_function(description: Description) -> str:
    """One function of arrays that gives mu and whether it is extrapolated."""
    function, names = f"traction_coefficient_{description.identifier}", description.argument_names
    results = [
        f"mu is {result(description, 'NaN')}",
        "outside is true where mu is extrapolated",
        "Arguments are scalars or arrays that expand against each other (R2016b, Octave)",
    ]
    comment = header(description, arguments(description), results, "%   ")
    checks = "".join(
        f"{condition.name}(~({condition.name} > 0)) = NaN;\n" for condition in description.arguments
    )
    tested = "".join(
        f"outside = outside | ~({inside});\n" for inside in box(description, both="&", size="abs")
    )
    steps = assignments(description, MATLAB, "{} = {};\n", " ...\n    ")
    return f"""\
function [mu, outside] = {function}( ...
    {", ".join(names)})
%{function.upper()}  Traction coefficient by slide-roll ratio.
{comment}

outside = false;
{tested}{checks}{steps}mu = (1 - 2 * ({SLIP} < 0)) .* mu;
end
"""
