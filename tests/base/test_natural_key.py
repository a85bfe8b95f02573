"""Names in the order of the numbers in them."""

from oilfilm.base.natural_key import natural_key


def test_superscript_in_a_name_is_text() -> None:
    assert natural_key("1²") == ((0, 0, ""), (1, 1, ""), (0, 0, "²"))


def test_names_with_superscripts_are_sorted_by_their_numbers() -> None:
    assert sorted(["run10", "run²2", "run9"], key=natural_key) == ["run9", "run10", "run²2"]
