"""Order of names by the numbers in them."""

import re


def natural_key(name: str) -> tuple[tuple[int, int, str], ...]:
    """Sort key by which numbers in names are compared as numbers.

    Examples:
        >>> sorted(["run10", "run9", "run1"], key=natural_key)
        ['run1', 'run9', 'run10']
    """
    parts = re.split(r"(\d+)", name)
    # each part is (is it a number, the number, the text), so that numbers and texts never compare
    # "²" is a digit to `isdigit`, but no number to `int` and no `\d`
    return tuple((1, int(part), "") if part.isdecimal() else (0, 0, part) for part in parts)
