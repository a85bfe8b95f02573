"""The law as a Fortran 2008 module."""

from oilfilm.exports.code import assignments, box, helpers, result, variables
from oilfilm.exports.description import SLIP, Description
from oilfilm.exports.header import arguments, header
from oilfilm.traction.expression import Form, Language


def _identifier(name: str) -> str:
    """Fortran takes n and N for the same name."""
    return f"{name}_" if len(name) == 1 and name.islower() else name


FORTRAN = Language(
    {"sign": Form("sign(1.0_dp, {})")}, numeral="{!r}_dp".format, identifier=_identifier
)
# Fortran has neither; both without cancellation at small x.
_HELPERS = {
    "expm1": """
  elemental function expm1(x) result(y)
    real(dp), intent(in) :: x
    real(dp) :: y, t

    t = tanh(x / 2.0_dp)
    y = 2.0_dp * t / (1.0_dp - t)
    if (x > 0.5_dp) y = exp(x) - 1.0_dp
  end function
""",
    "log1p": """
  elemental function log1p(x) result(y)
    real(dp), intent(in) :: x
    real(dp) :: y

    y = 2.0_dp * atanh(x / (2.0_dp + x))
  end function
""",
}


def fortran_module(description: Description) -> str:
    """Two elemental functions, so that they take arrays too: mu, and whether it is extrapolated."""
    name, names = description.identifier, description.argument_names
    results = [
        f"traction_coefficient_{name} is {result(description, 'NaN')}",
        f"outside_tested_box_{name} is true where mu is extrapolated",
    ]
    comment = header(description, arguments(description), results, "! ")
    parameters = ", &\n      ".join(names)
    declared = "\n".join(f"    real(dp), intent(in) :: {argument}" for argument in names)
    steps = assignments(description, FORTRAN, "    {} = {}\n", " &\n        ")
    *local, mu = variables(description, FORTRAN)
    inside = " .and. &\n      ".join(box(description, "{!r}_dp", ".and.", "abs"))
    imported, check = _check(description)
    return f"""\
{comment}
module traction_{name}
{imported}  use, intrinsic :: iso_fortran_env, only: dp => real64
  implicit none
  private
  public :: traction_coefficient_{name}
  public :: outside_tested_box_{name}
contains

  elemental function traction_coefficient_{name}( &
      {parameters}) result({mu})
{declared}
    real(dp) :: {mu}
    real(dp) :: {", ".join(local)}

{check}{steps}    if ({SLIP} < 0.0_dp) {mu} = -{mu}
  end function

  elemental function outside_tested_box_{name}( &
      {parameters}) result(outside)
{declared}
    logical :: outside

    outside = .not. ( &
      {inside})
  end function
{helpers(description, _HELPERS)}
end module
"""


def _check(description: Description) -> tuple[str, str]:
    """What gives NaN where the law has no value: the line that imports it, and the lines."""
    if not description.arguments:
        return "", ""
    positive = " .and. &\n        ".join(
        f"{condition.name} > 0.0_dp" for condition in description.arguments
    )
    return (
        "  use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value\n",
        f"""\
    if (.not. ({positive})) then
      mu = ieee_value(mu, ieee_quiet_nan)
      return
    end if
""",
    )
