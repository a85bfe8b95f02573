"""A message on a log without known names shows its line of names, not its title or its units."""

import pytest

from oilfilm.logs.likely_names import likely_line_of_names

ROWS = ["0\t1.5\t20", "1\t1.6\t21", "2\t1.7\t22"]


@pytest.mark.parametrize(
    "lines_above",
    [
        # a sheet fills the line of its title with tabs
        ["Report of our lab\t\t", "Alpha\tBeta\tGamma"],
        ["Report of our lab\t\t", "Alpha\tBeta\tGamma", "s\tN\t"],
        ["Report\tof\tour lab", "Alpha\tBeta\tGamma"],
        ["Report\tof\tour lab", "Alpha\tBeta\tGamma", "[s]\t[m/s]\t[%]"],
        ["Report of our lab\t\t", "Alpha\tBeta\tGamma", "begin of data\t\t"],
        ["0\t1.5\t20", "Alpha\tBeta\tGamma", "s\tN\t\N{DEGREE SIGN}C"],
    ],
)
def test_names_are_below_the_title_and_above_the_units(lines_above: list[str]) -> None:
    line_number = lines_above.index("Alpha\tBeta\tGamma") + 1
    assert likely_line_of_names([*lines_above, *ROWS]) == (line_number, "Alpha\tBeta\tGamma")


@pytest.mark.parametrize("lines_above", [["Report of our lab\t\t"], ["Report"], []])
def test_title_alone_is_no_line_of_names(lines_above: list[str]) -> None:
    assert likely_line_of_names([*lines_above, *ROWS]) is None


def test_symbols_are_names_and_no_units() -> None:
    lines = ["of\tour\tlab\tdata", "F\tU\tT\tSRR", *(f"{row}\t0.1" for row in ROWS)]
    assert likely_line_of_names(lines) == (2, "F\tU\tT\tSRR")
