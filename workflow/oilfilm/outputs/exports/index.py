"""The page that says which file is for whom."""

import html
from collections.abc import Sequence

from oilfilm.outputs.exports.description import Description
from oilfilm.outputs.exports.header import certificate, origin
from oilfilm.outputs.exports.names import plain

_FORMS = """\
| file | for | how |
| --- | --- | --- |
| `traction_*.h` | C99, C++11 | include it; needs libm (`-lm`) only |
| `traction_*.f90` | Fortran 2008 | compile it with your sources; elemental, so arrays too |
| `Traction_*.mo` | Modelica | load the package; Pa, m/s, K |
| `traction_coefficient_*.m` | MATLAB R2016b, GNU Octave | put it on the path; arrays too |
| `adore_*.csv` | ADORE and its like | A to D of (A + B u) exp(-C u) + D, if the law is so |
| `traction_*.json`, `.csv` | everything else | constants with errors and verdicts; tested box |"""


def index(fits: Sequence[Description]) -> str:
    """The page, in Markdown."""
    oils = "\n".join(_row(fit) for fit in fits)
    return f"""\
# Traction coefficients for bearing codes

{html.escape(origin(fits[0]), quote=False)}.

| oil | folder | mu depends on | certificate |
| --- | --- | --- | --- |
{oils}

{_FORMS}

The functions take the slide-roll ratio S with either sign, mu(-S) = -mu(S), and say whether a point
lies outside the tested box, where mu is extrapolated. Units stand in the names of the arguments;
the head of each file has the law, its source, the campaign, the tested box and the certificate.
"""


def _row(fit: Description) -> str:
    symbols = ", ".join([*(condition.symbol for condition in fit.arguments), "S"])
    where = fit.where_known and f"; {fit.where_known}"
    depends = "unknown" if fit.obstacle else symbols + where
    cells = (plain(fit.oil), f"`{fit.identifier}/`", depends, certificate(fit))
    return f"| {' | '.join(html.escape(cell, quote=False) for cell in cells)} |"
