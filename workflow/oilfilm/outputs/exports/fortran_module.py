"""The law as a Fortran 2008 module."""

from oilfilm.outputs.exports.description import SLIP, Description
from oilfilm.outputs.exports.header import arguments, header

# One factor a line: four of them with all digits would pass Fortran's column 132.
_TIMES = " &\n        * "


def fortran_module(description: Description) -> str:
    """Two elemental functions, so that they take arrays too: mu, and whether it is extrapolated."""
    name, given = description.identifier, description.arguments
    results = [
        f"traction_coefficient_{name} is mu, of the sign of S"
        + "; NaN unless pressure, speed and temperature are above 0" * bool(given),
        f"outside_tested_box_{name} is true where mu is extrapolated",
    ]
    comment = header(description, arguments(description), results, "! ")
    names = description.argument_names
    parameters = ", &\n      ".join(names)
    declared = "\n".join(f"    real(dp), intent(in) :: {one}" for one in names)
    imported = (
        "  use, intrinsic :: ieee_arithmetic, only: ieee_quiet_nan, ieee_value\n" if given else ""
    )
    positive = " .and. &\n        ".join(f"{one.name} > 0.0_dp" for one in given)
    check = (
        f"""\
    if (.not. ({positive})) then
      mu = ieee_value(mu, ieee_quiet_nan)
      return
    end if
"""
        if given
        else ""
    )
    bars = "".join(
        f"    {one.symbol.lower()} = {one.name} / {one.reference!r}_dp\n" for one in given
    )
    products = "".join(
        f"    {letter} = {description.product(letter, '{}**({})'.format, _TIMES, '_dp')}\n"
        for letter in description.powers
    )
    local = ", ".join([*(one.symbol.lower() for one in given), *description.powers, "S"])
    inside = " .and. &\n      ".join(
        [
            *(
                f"{one.name} >= {one.lower!r}_dp .and. {one.name} <= {one.upper!r}_dp"
                for one in given
            ),
            f"abs({SLIP}) <= {description.slip_upper!r}_dp",
        ]
    )
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
      {parameters}) result(mu)
{declared}
    real(dp) :: mu
    real(dp) :: {local}

{check}{bars}{products}    S = abs({SLIP})
    mu = sign({description.formula}, {SLIP})
  end function

  elemental function outside_tested_box_{name}( &
      {parameters}) result(outside)
{declared}
    logical :: outside

    outside = .not. ( &
      {inside})
  end function

end module
"""
