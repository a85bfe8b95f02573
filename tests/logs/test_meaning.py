"""Names of columns in eight languages: what each means, and which of them are asked."""

import itertools
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml

import oilfilm
from nights import nightly
from oilfilm.api.mu_columns import (
    ColumnsError,
    converted_to_over_mean,
    stated_columns,
    stated_meaning_by_index,
)
from oilfilm.api.table_fit import (
    MU,
    PRESSURE,
    SLIP,
    SPEED,
    TEMPERATURE,
    StatedByUser,
    read_mu_table,
)
from oilfilm.logs.header import split_bracketed_unit
from oilfilm.logs.meaning import (
    DEFINITIONS_OF_QUANTITY,
    UNIT_BY_QUANTITY,
    is_unit_of,
    meaning_of,
    split_unit,
)
from oilfilm.logs.sniff import SniffedRun, measured_set_points, sniff

CORPUS = yaml.safe_load(Path(__file__).with_name("column_names.yaml").read_text(encoding="utf-8"))
# Meaning -> its names.
NAMES = {said: "; ".join(lines).split("; ") for said, lines in CORPUS.items()}
ENTRIES = [(said, name) for said, names in NAMES.items() for name in names]


def test_corpus_is_large_enough() -> None:
    assert len({name for _, name in ENTRIES}) >= 300
    assert len(ENTRIES) == len({name for _, name in ENTRIES})


# one test per meaning: as many tests as names would take longer than what they test
@pytest.mark.parametrize("said", NAMES)
def test_name_means_what_the_corpus_says(said: str) -> None:
    for name in NAMES[said]:
        check_meaning(said, name)


def check_meaning(said: str, name: str) -> None:
    meaning = meaning_of(name)
    if said == "nothing":
        assert meaning is None
        return
    assert meaning is not None
    assert bool(meaning.question) == (said == "ask")
    if said == "ask":
        return
    quantity, _, definition = said.partition(" ")
    assert meaning.quantity == quantity
    assert meaning.definition == definition
    assert not meaning.unit or is_unit_of(meaning.unit, quantity)


# ---------------------------------------------------------------- tables

# Conditions of the tables below.
TRUTH = pd.DataFrame(
    itertools.product([0.9, 1.2], [10.0, 25.0], [40.0, 80.0], [0.01, 0.04, 0.1, 0.25]),
    columns=[PRESSURE, SPEED, TEMPERATURE, SLIP],
)
TRUTH[MU] = 0.03 * np.tanh(TRUTH[SLIP] / 0.05) * TRUTH[PRESSURE]
COLUMN_OF = {
    "max_hertz_pressure": PRESSURE,
    "entrainment_speed": SPEED,
    "inlet_temperature": TEMPERATURE,
    "slide_roll_ratio": SLIP,
    "traction_coefficient": MU,
}
PLAIN = {
    PRESSURE: "p [GPa]",
    SPEED: "U [m/s]",
    TEMPERATURE: "T [degC]",
    SLIP: "SRR [-]",
    MU: "mu [-]",
}


def written(quantity: str, definition: str, unit: str) -> pd.Series:
    """The true column of a quantity as a laboratory would write it."""
    true = TRUTH[COLUMN_OF[quantity]]
    if definition == "mean" and quantity == "max_hertz_pressure":
        true = true / 1.5
    if definition == "sum":
        true = 2 * true
    if definition == "over_sum":
        true = true / 2
    if definition == "over_faster":
        # the disc is the faster body: u2 = U (1 + S/2)
        true = true / (1 + true / 2)
    if definition == "sliding_speed":
        true = true * TRUTH[SPEED]
    scale, offset = FACTORS.get(unit, (1.0, 0.0))
    return scale * true + offset


# Unit -> factor and offset from the unit of the project.
FACTORS = {
    **{"MPa": (1e3, 0), "МПа": (1e3, 0), "N/mm2": (1e3, 0), "psi": (145037.7377, 0)},
    **{"mm/s": (1e3, 0), "mm s-1": (1e3, 0), "%": (100, 0)},
    **{"K": (1, 273.15), "°F": (1.8, 32), "": (1, 0)},
}
MEANINGS_IN_TABLES = [
    said for said in NAMES if said.partition(" ")[0] in COLUMN_OF or said in {"ask", "nothing"}
]


@pytest.mark.slow
@pytest.mark.parametrize("said", MEANINGS_IN_TABLES)
@pytest.mark.parametrize("in_every_column", [False, nightly(True)])
def test_no_unstated_meaning_becomes_a_number(said: str, in_every_column: bool) -> None:
    """A name in place of the plain one gives the truth or a question, never another number.

    A name without meaning, or with an open one, gives the true numbers if they are read at all.
    By day each of these names takes the place of one column, in turn.
    """
    for number, name in enumerate(NAMES[said]):
        quantities = [said.partition(" ")[0]]
        if said in ("ask", "nothing"):
            quantities = list(COLUMN_OF)
            if not in_every_column:
                quantities = [quantities[number % len(quantities)]]
        check_numbers(said, name, quantities)


def check_numbers(said: str, name: str, quantities: list[str]) -> None:
    definition = "" if said in ("ask", "nothing") else said.partition(" ")[2]
    for quantity in quantities:
        column = COLUMN_OF[quantity]
        unit = split_unit(name)[1]
        table = TRUTH.rename(columns=PLAIN).drop(columns=PLAIN[column])
        table[name] = written(quantity, definition, unit if said != "nothing" else "")
        try:
            points = read_mu_table(table).points
        except oilfilm.OilfilmError:
            is_number = UNIT_BY_QUANTITY[quantity] == "1" and definition != "sliding_speed"
            has_unit = bool(unit) or is_number
            assert said in ("ask", "nothing") or not has_unit
            continue
        if column in points and (said not in ("ask", "nothing")):
            np.testing.assert_allclose(points[column], TRUTH[column], rtol=1e-5)
        else:
            assert column not in points


@pytest.mark.parametrize(
    ("quantity", "definition"),
    [(quantity, each) for quantity, all_of in DEFINITIONS_OF_QUANTITY.items() for each in all_of],
)
def test_stated_definition_gives_the_truth(quantity: str, definition: str) -> None:
    """The user states what an open name means."""
    unit = "m/s" if definition == "sliding_speed" else UNIT_BY_QUANTITY[quantity]
    in_brackets = "" if unit == "1" else f" [{unit}]"
    table = TRUTH.rename(columns=PLAIN).drop(columns=PLAIN[COLUMN_OF[quantity]])
    table["Spalte 7"] = written(quantity, definition, "")
    with pytest.raises(oilfilm.OilfilmError):
        oilfilm.fit_table(table)
    stated = {quantity: f"Spalte 7{in_brackets}, {definition}"}
    read = read_mu_table(table, StatedByUser(stated_columns(stated))).points
    np.testing.assert_allclose(read[COLUMN_OF[quantity]], TRUTH[COLUMN_OF[quantity]], rtol=1e-9)


@pytest.mark.parametrize("definition", ["over_mean", "over_sum", "over_faster"])
@pytest.mark.parametrize("unit", ["", " [%]"])
def test_speeds_of_both_bodies_answer_what_a_slip_is(definition: str, unit: str) -> None:
    table = TRUTH.rename(columns=PLAIN).drop(columns=[PLAIN[SLIP], PLAIN[SPEED]])
    table["ball speed [m/s]"] = TRUTH[SPEED] * (1 - TRUTH[SLIP] / 2)
    table["disc speed [m/s]"] = TRUTH[SPEED] * (1 + TRUTH[SLIP] / 2)
    table[f"slip{unit}"] = written("slide_roll_ratio", definition, "%")
    points = read_mu_table(table).points
    np.testing.assert_allclose(points[SLIP], TRUTH[SLIP], rtol=1e-9)
    np.testing.assert_allclose(points[SPEED], TRUTH[SPEED], rtol=1e-9)


def test_slip_over_the_faster_body_is_that_of_the_speeds() -> None:
    ball, disc = np.array([1.0, 2.0]), np.array([2.0, 1.0])
    over_faster = (disc - ball) / np.maximum(ball, disc)
    np.testing.assert_allclose(
        converted_to_over_mean(over_faster, "over_faster"), (disc - ball) / 1.5
    )


@pytest.mark.slow
def test_decoy_beside_the_right_columns_changes_nothing() -> None:
    for decoy in NAMES["nothing"]:
        table = TRUTH.rename(columns=PLAIN)
        table.insert(0, decoy, np.linspace(1.0, 9.0, len(table)))
        points = read_mu_table(table).points
        for column in TRUTH:
            np.testing.assert_allclose(points[column], TRUTH[column], err_msg=decoy)


def test_two_columns_that_contradict_each_other_are_both_named() -> None:
    table = TRUTH.rename(columns=PLAIN)
    table["ball speed [m/s]"] = TRUTH[SPEED]
    table["disc speed [m/s]"] = 1.3 * TRUTH[SPEED]
    with pytest.raises(oilfilm.OilfilmError, match="SRR") as contradiction:
        read_mu_table(table)
    assert "ball" in str(contradiction.value)


def test_swapped_pressure_and_speed_are_named() -> None:
    table = TRUTH.rename(columns={**PLAIN, PRESSURE: "U [m/s]", SPEED: "p [GPa]"})
    with pytest.raises(oilfilm.OilfilmError, match="swapped") as swapped:
        read_mu_table(table)
    assert "'p [GPa]'" in str(swapped.value)


def test_one_wrong_sign_is_named_and_left_out() -> None:
    """Every second row is measured backwards, |mu| is given, and one row has a sign."""
    table = TRUTH.copy()
    table.loc[::2, SLIP] *= -1
    table.loc[4, MU] *= -1
    read = read_mu_table(table.rename(columns=PLAIN))
    assert len(read.points) == len(TRUTH) - 1
    assert (read.points[MU] > 0).all()
    assert any(f"{table.loc[4, MU]:g}" in note for note in read.notes)


def test_mu_of_both_signs_is_refused() -> None:
    table = TRUTH.copy()
    table.loc[::2, SLIP] *= -1
    table.loc[::4, MU] *= -1
    with pytest.raises(oilfilm.OilfilmError, match="negative mu"):
        read_mu_table(table.rename(columns=PLAIN))


def test_what_the_user_leaves_out_is_what_the_name_says() -> None:
    """The definition of the name counts, not that of the project."""
    table = TRUTH.rename(columns=PLAIN).drop(columns=PLAIN[PRESSURE])
    table["mean pressure"] = TRUTH[PRESSURE] / 1.5
    stated = StatedByUser(stated_columns("max_hertz_pressure=mean pressure [GPa]"))
    points = read_mu_table(table, stated).points
    np.testing.assert_allclose(points[PRESSURE], TRUTH[PRESSURE])


def with_stated(table: pd.DataFrame, stated: str) -> pd.DataFrame:
    """The points of a table with what the user says."""
    return read_mu_table(table, StatedByUser(stated_columns(stated))).points


@pytest.mark.parametrize("order", [["Load [N]", "Load [kN]"], ["Load [kN]", "Load [N]"]])
@pytest.mark.parametrize("stated", ["Load [kN]", "Load[kN]"])
def test_unit_tells_columns_of_one_name_apart(order: list[str], stated: str) -> None:
    """The load of the drive in N is another column than that of the contact in kN."""
    table = TRUTH.rename(columns=PLAIN).drop(columns=PLAIN[PRESSURE])
    loads = {"Load [N]": 20.0, "Load [kN]": 0.05}
    table = table.assign(**{name: loads[name] for name in order})
    points = with_stated(table, f"load={stated}; nothing=Load [N]")
    np.testing.assert_allclose(points["load_n"], 50.0)
    with pytest.raises(oilfilm.OilfilmError, match=r"'Load \[k?N\]' and 'Load") as asked:
        with_stated(table, "load=Load")
    assert "with its unit" in str(asked.value)


@pytest.mark.parametrize(
    ("names", "units"),
    [
        (["Load", "Load"], ["N", "kN"]),
        (["Load [N]", "Load"], ["", "kN"]),
        # the user gives the second column its unit
        (["Load [N]", "Load"], ["", ""]),
    ],
)
def test_unit_beside_a_name_tells_columns_apart(names: list[str], units: list[str]) -> None:
    ((index, meaning),) = stated_meaning_by_index(
        names, units, stated_columns("load=Load [kN]")
    ).items()
    assert (index, meaning.unit) == (1, "kN")


@pytest.mark.parametrize(
    ("names", "units", "stated", "expected_index"),
    [
        (["Temp [K]", "Temp [°C]"], ["", ""], "inlet_temperature=Temp [degC]", 1),
        (["Temp", "Temp"], ["K", "°C"], "inlet_temperature=Temp [degC]", 1),
        (["Pressure [MPa]", "Pressure [GPa]"], ["", ""], "nothing=Pressure [N/mm2]", 0),
        # of two spellings of one unit that of the user counts
        (["Temp", "Temp"], ["degC", "°C"], "inlet_temperature=Temp [°C]", 1),
    ],
)
def test_units_of_columns_are_compared_by_meaning(
    names: list[str], units: list[str], stated: str, expected_index: int
) -> None:
    assert list(stated_meaning_by_index(names, units, stated_columns(stated))) == [expected_index]


@pytest.mark.parametrize(
    ("name", "unit_beside", "stated"),
    [
        ("Load [N]", "", "load=Load [kN]"),
        ("Load", "N", "load=Load [kN]"),
        ("load_n", "", "load=load_n [kN]"),
        ("Temp [°C]", "", "inlet_temperature=Temp [K]"),
        ("ball speed [rpm]", "", "ball_speed=ball speed [m/s]"),
        ("Load [GPa]", "", "load=Load [N]"),
        ("Load [N]", "", "nothing=Load [kN]"),
    ],
)
def test_unit_of_the_user_that_contradicts_the_table_is_refused(
    name: str, unit_beside: str, stated: str
) -> None:
    """20 N would silently become 20 000 N."""
    unit_of_table = unit_beside or split_unit(name)[1]
    unit_of_user = split_bracketed_unit(stated)[1]
    with pytest.raises(ColumnsError, match="has the unit") as asked:
        stated_meaning_by_index([name], [unit_beside], stated_columns(stated))
    assert repr(unit_of_table) in asked.value.sentence
    assert repr(unit_of_user) in asked.value.sentence


@pytest.mark.parametrize(
    ("name", "unit_beside", "stated"),
    [
        ("Temp [°C]", "", "inlet_temperature=Temp [degC]"),
        ("Temp", "°C", "inlet_temperature=Temp [degC]"),
        ("Load", "", "load=Load [kN]"),
        # a symbol
        ("F_n", "", "load=F_n [kN]"),
        # no units, but words
        ("Speed (drive)", "", "entrainment_speed=Speed (drive) [m/s]"),
        ("Speed (min)", "", "entrainment_speed=Speed (min) [m/s]"),
        ("rev speed", "", "ball_speed=rev speed [m/s]"),
        # not known: only the user can say it
        ("Load [kp?]", "", "load=Load [kgf]"),
    ],
)
def test_unit_of_the_user_counts_where_the_table_has_no_other(
    name: str, unit_beside: str, stated: str
) -> None:
    (meaning,) = stated_meaning_by_index([name], [unit_beside], stated_columns(stated)).values()
    assert meaning.unit == split_bracketed_unit(stated)[1]


@pytest.mark.parametrize("second", ["v", "v [m/s]"])
def test_column_that_is_stated_twice_is_refused(second: str) -> None:
    table = TRUTH.rename(columns={**PLAIN, SPEED: "v [m/s]"})
    with pytest.raises(oilfilm.OilfilmError, match="ball_speed and disc_speed"):
        with_stated(table, f"ball_speed=v; disc_speed={second}")


def test_column_that_is_stated_twice_as_the_same_is_named_once() -> None:
    table = table_with({"Load [N]": 20.0}, PRESSURE)
    with pytest.raises(oilfilm.OilfilmError, match=r"states 'Load \[N\]' twice"):
        with_stated(table, "load=Load [N];load=Load [N]")


@pytest.mark.parametrize(
    ("names", "units"),
    [
        (["Load", "Load"], ["", ""]),
        (["Load [N]", "Load [N]"], ["", ""]),
        (["Load", "Load"], ["N", "N"]),
        # none of the first two is taken for lack of a third
        (["Load [N]", "Load [N]", "Load"], ["", "", ""]),
    ],
)
def test_columns_that_no_name_tells_apart_must_be_renamed(
    names: list[str], units: list[str]
) -> None:
    with pytest.raises(ColumnsError, match="Rename one of") as asked:
        stated_meaning_by_index(names, units, stated_columns("load=Load [N]"))
    assert "Write the name" not in str(asked.value)


def test_message_has_the_units_of_a_row_of_units() -> None:
    with pytest.raises(ColumnsError, match=r"'Load \[N\]' and 'Load \[kN\]'. Write the name"):
        stated_meaning_by_index(["Load", "Load"], ["N", "kN"], stated_columns("load=Load"))


def test_question_on_columns_of_one_name_advises_to_rename() -> None:
    table = table_with({"Load": 20.0, "Load 2": 20.0}, PRESSURE)
    table.columns = ["Load" if name == "Load 2" else name for name in table.columns]
    with pytest.raises(oilfilm.OilfilmError, match=r"could both be the load. Rename one of"):
        read_mu_table(table)


@pytest.mark.parametrize(
    ("name", "stated"),
    [
        ("Speed, mean [m/s]", "Speed, mean"),
        ("Speed, mean [m/s]", "Speed, mean [m/s]"),
        ("Speed, mean", "Speed, mean [m/s]"),
        ("Speed, mean", "Speed, mean [m/s], mean"),
        ("Speed (drive) [m/s]", "Speed (drive)"),
        ("Speed (drive) [m/s]", "Speed (drive), mean"),
    ],
)
def test_name_with_a_comma_or_brackets_is_stated_as_the_table_has_it(
    name: str, stated: str
) -> None:
    table = TRUTH.rename(columns={**PLAIN, SPEED: name})
    points = with_stated(table, f"entrainment_speed={stated}")
    np.testing.assert_allclose(points[SPEED], TRUTH[SPEED])


def test_name_with_a_comma_may_lack_its_unit() -> None:
    table = TRUTH.rename(columns={**PLAIN, SPEED: "Speed, mean"})
    with pytest.raises(oilfilm.OilfilmError, match="has no unit"):
        with_stated(table, "entrainment_speed=Speed, mean")


def test_name_is_stated_as_the_table_has_it() -> None:
    """`mu_k` has no unit: nothing of the name is cut off."""
    table = TRUTH.rename(columns={**PLAIN, MU: "mu_k"})
    stated = StatedByUser(stated_columns("traction_coefficient=mu_k"))
    np.testing.assert_allclose(read_mu_table(table, stated).points[MU], TRUTH[MU])


def test_all_candidates_of_an_open_meaning_are_named() -> None:
    table = TRUTH.rename(columns=PLAIN).drop(columns=PLAIN[SPEED])
    table["Speed 1 [m/s]"] = TRUTH[SPEED]
    table["Speed 2 [m/s]"] = TRUTH[SPEED]
    with pytest.raises(oilfilm.OilfilmError, match="Speed 1") as asked:
        read_mu_table(table)
    assert "Speed 2" in str(asked.value)


def test_open_column_that_is_not_needed_is_not_asked_about() -> None:
    """A force may be load or traction; beside pressure and mu it is neither."""
    table = TRUTH.rename(columns=PLAIN).assign(**{"Force [N]": 3.0})
    read = read_mu_table(table)
    assert "load_n" not in read.points
    assert any("'Force [N]'" in note for note in read.notes)


def test_column_that_is_nothing_is_left_out() -> None:
    table = TRUTH.rename(columns=PLAIN).drop(columns=PLAIN[PRESSURE])
    table["Load [N]"] = 50.0
    table["Pressure [MPa]"] = 0.3
    with pytest.raises(oilfilm.OilfilmError, match="nothing=Pressure"):
        read_mu_table(table)
    points = read_mu_table(table, StatedByUser(stated_columns("nothing=Pressure [MPa]"))).points
    assert PRESSURE not in points


@pytest.mark.parametrize(
    ("name", "factor"),
    [("SRR", 1), ("SRR [-]", 1), ("SRR [%]", 100), ("sliding speed [m/s]", TRUTH[SPEED])],
)
def test_ratio_that_the_speeds_contradict_is_refused(
    name: str, factor: "float | pd.Series[float]"
) -> None:
    table = TRUTH.rename(columns=PLAIN).drop(columns=[PLAIN[SLIP], PLAIN[SPEED]])
    table["ball speed [m/s]"] = TRUTH[SPEED] * (1 - TRUTH[SLIP] / 2)
    table["disc speed [m/s]"] = TRUTH[SPEED] * (1 + TRUTH[SLIP] / 2)
    table[name] = TRUTH[SLIP] / 2 * factor
    with pytest.raises(oilfilm.OilfilmError, match="contradicts the speeds"):
        read_mu_table(table)


def test_a_ratio_that_was_divided_by_zero_makes_no_percent_of_the_others() -> None:
    table = TRUTH.rename(columns={**PLAIN, SLIP: "SRR"})
    table["SRR"] = table["SRR"].where(table.index > 0, np.inf)
    slip = read_mu_table(table).points[SLIP]
    np.testing.assert_allclose(slip[np.isfinite(slip)], TRUTH[SLIP][1:])


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("blank", [["ball"], ["ball", "disc"]])
def test_blank_speeds_contradict_nothing(blank: list[str]) -> None:
    """Columns of ball and disc that the rig did not log."""
    table = TRUTH.rename(columns=PLAIN)
    for body in ("ball", "disc"):
        table[f"{body} speed [m/s]"] = np.nan if body in blank else TRUTH[SPEED]
    read = read_mu_table(table)
    np.testing.assert_allclose(read.points[SLIP], TRUTH[SLIP])
    np.testing.assert_allclose(read.points[SPEED], TRUTH[SPEED])
    assert "not read: 'ball speed [m/s]': it holds no numbers" in read.notes


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("blank", [[SPEED], [SLIP], [SPEED, SLIP]])
def test_blank_mean_speed_and_slip_follow_from_both_speeds(blank: list[str]) -> None:
    table = TRUTH.rename(columns=PLAIN)
    table["ball speed [m/s]"] = TRUTH[SPEED] * (1 - TRUTH[SLIP] / 2)
    table["disc speed [m/s]"] = TRUTH[SPEED] * (1 + TRUTH[SLIP] / 2)
    table[[PLAIN[column] for column in blank]] = np.nan
    read = read_mu_table(table)
    np.testing.assert_allclose(read.points[SLIP], TRUTH[SLIP])
    np.testing.assert_allclose(read.points[SPEED], TRUTH[SPEED])
    for column in blank:
        assert f"not read: {PLAIN[column]!r}: it holds no numbers" in read.notes


@pytest.mark.filterwarnings("error")
def test_blank_mean_speed_stays_where_a_speed_is_blank() -> None:
    table = TRUTH.rename(columns=PLAIN).assign(**{PLAIN[SPEED]: np.nan, "ball speed [m/s]": np.nan})
    table["disc speed [m/s]"] = TRUTH[SPEED]
    with pytest.raises(oilfilm.OilfilmError, match="no row has all its numbers"):
        read_mu_table(table)


@pytest.mark.filterwarnings("error")
def test_columns_without_a_common_row_do_not_contradict_each_other() -> None:
    """The speeds are known in the first half of the rows, the ratio in the second."""
    table = TRUTH.rename(columns=PLAIN)
    table["ball speed [m/s]"] = 3 * TRUTH[SPEED]
    table["disc speed [m/s]"] = 4 * TRUTH[SPEED]
    table.loc[15:, ["ball speed [m/s]", "disc speed [m/s]"]] = np.nan
    table.loc[:15, [PLAIN[SLIP], PLAIN[SPEED]]] = np.nan
    np.testing.assert_allclose(read_mu_table(table).points[SLIP], TRUTH[SLIP][16:])


@pytest.mark.parametrize("name", ["slide_roll_ratio", "SRR"])
def test_blank_column_is_not_taken_in_place_of_one_with_numbers(name: str) -> None:
    table = TRUTH.rename(columns={**PLAIN, SLIP: "slide-roll ratio [-]"}).assign(**{name: np.nan})
    np.testing.assert_allclose(read_mu_table(table).points[SLIP], TRUTH[SLIP])


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("condition", [TEMPERATURE, SPEED])
def test_blank_condition_is_not_dropped_silently(condition: str) -> None:
    """It may be blank because its numbers were not understood."""
    table = TRUTH.rename(columns=PLAIN).assign(**{PLAIN[condition]: np.nan})
    with pytest.raises(oilfilm.OilfilmError, match="no row has all its numbers"):
        read_mu_table(table)


@pytest.mark.filterwarnings("error")
@pytest.mark.parametrize("has_ratio", [True, False])
def test_row_at_standstill_is_left_out_without_a_warning(has_ratio: bool) -> None:
    table = TRUTH.rename(columns=PLAIN).drop(columns=[PLAIN[SPEED], PLAIN[SLIP]])
    table["ball speed [m/s]"] = TRUTH[SPEED] * (1 - TRUTH[SLIP] / 2)
    table["disc speed [m/s]"] = TRUTH[SPEED] * (1 + TRUTH[SLIP] / 2)
    table.loc[0, ["ball speed [m/s]", "disc speed [m/s]"]] = 0.0
    if has_ratio:
        table["SRR [-]"] = TRUTH[SLIP].where(TRUTH.index > 0)
    points = read_mu_table(table).points
    np.testing.assert_allclose(points[SLIP], TRUTH[SLIP][1:])


def test_digits_of_speeds_contradict_no_ratio() -> None:
    """Speeds of three digits in a sweep to 2 %: their difference is hardly a digit."""
    slip = TRUTH[SLIP] * 0.08
    table = TRUTH.assign(**{SLIP: slip}).rename(columns=PLAIN).drop(columns=PLAIN[SPEED])
    table["ball speed [m/s]"] = (TRUTH[SPEED] * (1 - slip / 2)).round(1)
    table["disc speed [m/s]"] = (TRUTH[SPEED] * (1 + slip / 2)).round(1)
    np.testing.assert_allclose(read_mu_table(table).points[SLIP], slip)


@pytest.mark.parametrize(
    "name", ["Sliding velocity", "Schlupf [%]", "Hertz pressure [GPa]", "Temp"]
)
def test_line_to_paste_answers_the_question(name: str) -> None:
    """A table with this column in place of the plain one is read with the line of its message."""
    quantity = {"S": SLIP, "H": PRESSURE, "T": TEMPERATURE}[name[0]]
    table = TRUTH.rename(columns=PLAIN).drop(columns=PLAIN[quantity])
    table[name] = TRUTH[quantity] * {"[%]": 100}.get(name[-3:], 1)
    if name == "Sliding velocity":
        table[name] *= TRUTH[SPEED]
    with pytest.raises(oilfilm.OilfilmError) as asked:
        read_mu_table(table)
    line = str(asked.value).partition('--columns "')[2].partition('"')[0]
    points = read_mu_table(table, StatedByUser(stated_columns(line))).points
    np.testing.assert_allclose(points[quantity], TRUTH[quantity])


def table_with(columns: dict[str, float], quantity: str) -> pd.DataFrame:
    """The true table with other columns in place of that of a quantity."""
    return TRUTH.rename(columns=PLAIN).drop(columns=PLAIN[quantity]).assign(**columns)


def with_row_of_units(folder: Path, table: pd.DataFrame) -> Path:
    """A file of a table whose units are in a row of their own below the names."""
    names_and_units = [split_bracketed_unit(str(name)) for name in table.columns]
    lines = [";".join(name for name, _ in names_and_units)]
    lines.append(";".join(unit for _, unit in names_and_units))
    path = folder / "table.csv"
    path.write_text("\n".join(lines) + "\n" + table.to_csv(sep=";", index=False, header=False))
    return path


def lines_to_paste(message: str) -> list[str]:
    """The texts of `--columns` that a message offers."""
    return [part.partition('"')[0] for part in message.split('--columns "')[1:]]


@pytest.mark.parametrize("has_row_of_units", [False, True])
@pytest.mark.parametrize(
    ("columns", "quantity"),
    [
        ({"Load [N]": 20.0, "Load [kN]": 0.05}, PRESSURE),
        ({"Temp [°C]": 40.0, "Temp [K]": 313.15}, TEMPERATURE),
        ({"Mean speed [m/s]": 2.0, "Mean speed [mm/s]": 2000.0}, SPEED),
    ],
)
def test_each_advice_answers_the_message(
    tmp_path: Path, columns: dict[str, float], quantity: str, has_row_of_units: bool
) -> None:
    table: pd.DataFrame | Path = table_with(columns, quantity)
    if has_row_of_units:
        table = with_row_of_units(tmp_path, table)
    with pytest.raises(oilfilm.OilfilmError, match="could both be") as asked:
        read_mu_table(table)
    lines = lines_to_paste(str(asked.value))
    assert len(lines) == 2
    for line in lines:
        read_mu_table(table, StatedByUser(stated_columns(line)))


def test_advice_on_a_symbol_has_the_whole_symbol() -> None:
    """`F_n` is a symbol without a unit, not F in newtons."""
    table = table_with({"F_n": 20.0}, PRESSURE)
    with pytest.raises(oilfilm.OilfilmError, match="has no unit") as asked:
        read_mu_table(table)
    assert lines_to_paste(str(asked.value)) == ["load=F_n [N]", "nothing=F_n"]


@pytest.mark.parametrize(
    "name",
    [
        *("p [bar]", "max pressure [bar]", "Max COF", "static friction coefficient"),
        *("Peak friction force [N]", "Max load [N]", "Zero load [N]", "load offset [N]"),
        *(
            "load drift [N]",
            "\u0394 load [N]",
            "Contact time [s]",
            "Cycle time [s]",
            "delay time [s]",
        ),
        *("Step time [s]", "Schrittzeit", "Lap time (s)", "time per stage [s]", "步骤时间 [s]"),
    ],
)
def test_name_of_what_may_be_no_reading_is_asked(name: str) -> None:
    meaning = meaning_of(name)
    assert meaning is None or meaning.question


def sniffed_run(load_n: float, temperatures_c: tuple[float, float]) -> SniffedRun:
    log = (
        "time [s];load [N];traction force [N];ball speed [m/s];disc speed [m/s];oil inlet [degC]\n"
    )
    log += "".join(
        f"{row * 0.02:.2f};{load_n};1.0;10.0;10.1;{temperatures_c[row % 2]}\n" for row in range(101)
    )
    (run,) = sniff("a.csv", log.encode(), lambda *_: "").runs
    return run


@pytest.mark.parametrize(
    ("temperatures_c", "level_c"), [((-20.0, -20.1), -20.0), ((-5.0, 5.0), np.nan)]
)
def test_level_of_a_cold_inlet_keeps_its_sign(
    temperatures_c: tuple[float, float], level_c: float
) -> None:
    level = sniffed_run(80.1, temperatures_c).measured_levels["inlet_temperature_c"]
    np.testing.assert_allclose(level, level_c, atol=0.051)


@pytest.mark.parametrize(("load_n", "is_set_point"), [(80.1, True), (0.0, False)])
def test_load_that_no_run_sheet_may_have_is_no_set_point(load_n: float, is_set_point: bool) -> None:
    run = sniffed_run(load_n, (70.0, 70.1))
    assert ("load_n" in measured_set_points(run)) == is_set_point
