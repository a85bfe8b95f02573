"""The page that says which file is for whom."""

import html
from collections.abc import Sequence

from oilfilm.exports.description import Description
from oilfilm.exports.header import certificate, origin
from oilfilm.exports.names import plain

_FORMS = """\
| file | for | how |
| --- | --- | --- |
| `traction_*.py` | Python | import it; needs NumPy alone; arrays too |
| `traction_*.xlsx` | Excel, LibreOffice | type P, U, T and S; live formulas, tested range, curve |
| `traction_*.h` | C99, C++11 | include it; needs libm (`-lm`) only |
| `traction_*.f90` | Fortran 2008 | compile it with your sources; elemental, so arrays too |
| `Traction_*.mo` | Modelica | load the package; Pa, m/s, K |
| `traction_coefficient_*.m` | MATLAB R2016b, GNU Octave | put it on the path; arrays too |
| `adore_*.csv` | ADORE and its like | A to D of (A + B u) exp(-C u) + D, if the law is so |
| `traction_*.json`, `.csv` | everything else | constants with errors and verdicts; tested box |"""


def index(fits: Sequence[Description], below: str = "") -> str:
    """The page, in Markdown.

    Args:
        fits: What it lists.
        below: A line below the list.
    """
    oils = "\n".join(_row(fit) for fit in fits)
    origins = "\n".join(
        dict.fromkeys(f"- {html.escape(origin(fit), quote=False)}." for fit in fits)
    )
    return f"""\
# Traction coefficients for bearing codes

{origins}

| oil | folder | mu depends on | certificate |
| --- | --- | --- | --- |
{oils}
{below}
{_FORMS}

The functions take the slide-roll ratio S with either sign, mu(-S) = -mu(S), and say whether a point
lies outside the tested box, where mu is extrapolated. The names of the arguments carry the units.
The head of each file has the law, its source, where its constants come from, the tested box and the
certificate.
"""


def _row(fit: Description) -> str:
    symbols = ", ".join([*(condition.symbol for condition in fit.arguments), "S"])
    where = fit.where_known and f"; {fit.where_known}"
    depends = "unknown" if fit.obstacle else symbols + where
    cells = (plain(fit.oil), f"`{fit.identifier}/`", depends, certificate(fit))
    return f"| {' | '.join(html.escape(cell, quote=False) for cell in cells)} |"
