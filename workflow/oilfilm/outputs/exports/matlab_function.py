"""The law as a function of MATLAB and GNU Octave."""

from oilfilm.outputs.exports.description import SLIP, Description
from oilfilm.outputs.exports.header import arguments, header

# A factor a line.
_TIMES = " ...\n    .* "


def matlab_function(description: Description) -> str:
    """One function of arrays that gives mu and whether it is extrapolated."""
    function, given = f"traction_coefficient_{description.identifier}", description.arguments
    names = description.argument_names
    call = f"[mu, outside] = {function}( ...\n    {', '.join(names)})"
    results = [
        "mu has the sign of S"
        + "; it is NaN unless pressure, speed and temperature are above 0" * bool(given),
        "outside is true where mu is extrapolated",
        "Arguments are scalars or arrays that expand against each other (R2016b, Octave)",
    ]
    comment = header(description, arguments(description), results, "%   ")
    bars = "".join(
        f"{(bar := one.symbol.lower())} = {one.name} / {one.reference!r};\n"
        f"{bar}(~({bar} > 0)) = NaN;\n"
        for one in given
    )
    products = "".join(
        f"{letter} = {description.product(letter, '{} .^ ({})'.format, _TIMES)};\n"
        for letter in description.powers
    )
    inside = " ...\n    & ".join(
        [
            *(f"{one.name} >= {one.lower!r} & {one.name} <= {one.upper!r}" for one in given),
            f"abs({SLIP}) <= {description.slip_upper!r}",
        ]
    )
    return f"""\
function {call}
%{function.upper()}  Traction coefficient by slide-roll ratio.
{comment}

{bars}{products}S = abs({SLIP});
mu = sign({SLIP}) .* ({description.formula.replace("*", ".*")});
outside = ~({inside});
end
"""
