"""A table of mu in many dialects: planted constants come back, or the true reason is told."""

import gzip
import shlex
from dataclasses import replace
from functools import partial
from pathlib import Path
from types import SimpleNamespace
from unittest.mock import Mock

import numpy as np
import pandas as pd
import polars
import pyarrow
import pyarrow.parquet
import pytest

import oilfilm
from known_laws import known_law
from nights import quick_ones
from oilfilm.api.arrays import ArrayFit
from oilfilm.api.table_fit import pressure_gpa_of_load, read_mu_table
from oilfilm.cli import main

QUICK = {"searches": 2, "bootstrap": 20}
PLANTED = known_law("4102")
SLIP, MU = "slide_roll_ratio", "traction_coefficient"
CONDITIONS = ["max_hertz_pressure_gpa", "entrainment_speed_m_s", "inlet_temperature_c"]
NAMES = [*CONDITIONS, SLIP]


@pytest.fixture(scope="module")
def points() -> pd.DataFrame:
    """Points on the printed law of 4102, whose constants the paper states."""
    levels = np.meshgrid([1.0, 1.5], [25, 40], [50, 120], np.linspace(0, 0.3, 8))
    frame = pd.DataFrame({name: level.ravel() for name, level in zip(NAMES, levels, strict=True)})
    law, arguments = PLANTED, [frame[name] for name in frame]
    mu = oilfilm.predict(law.law, law.coefficients, *arguments).traction_coefficient
    return frame.assign(**{MU: mu})


@pytest.fixture(scope="module")
def fitted(points: pd.DataFrame) -> ArrayFit:
    """A fit of these points that no test changes."""
    return oilfilm.fit_table(points, **QUICK)


# Names with their units, as laboratories of many lands write them: conditions, slip and mu.
DIALECTS = {
    "plain": "p [GPa]; U [m/s]; T [°C]; S; mu",
    "english": "Max Hertz pressure (MPa); Rolling Speed (mm/s); Pot Temp (°C); SRR (%); "
    "Traction Coeff",
    "german": "max. Hertzsche Pressung [GPa]; mittlere Geschwindigkeit [m/s]; Öltemperatur [K]; "
    "Gleit-Wälz-Verhältnis [%]; "
    "Reibungszahl",
    "spanish": "presión máxima de Hertz [MPa]; velocidad media [m/s]; aceite [°C]; "
    "relación deslizamiento-rodadura [-]; "
    "coeficiente de tracción",
    "chinese": "最大赫兹压力 [GPa]; 平均 [m/s]; 温度 [°C]; 滑滚比 [%]; 牵引系数",
}
# unit -> factor and offset from the unit of the table's columns; 0 degC is 273.15 K by definition
UNITS = {"MPa": (1e3, 0), "mm/s": (1e3, 0), "%": (100, 0), "K": (1, 273.15)}


def in_dialect(points: pd.DataFrame, dialect: str) -> pd.DataFrame:
    column_by_name = {}
    for column, name in zip(points, DIALECTS[dialect].split("; "), strict=True):
        factor, offset = UNITS.get(name.strip("])").replace("(", "[").partition("[")[2], (1, 0))
        column_by_name[name] = factor * points[column] + offset
    return pd.DataFrame(column_by_name)


@pytest.mark.parametrize("dialect", DIALECTS)
def test_columns_are_found_by_name_and_unit(points: pd.DataFrame, dialect: str) -> None:
    read_points = read_mu_table(in_dialect(points, dialect)).points
    for column in points:
        np.testing.assert_allclose(read_points[column], points[column], rtol=1e-9, atol=1e-12)


@pytest.mark.slow
def test_every_form_of_table_gives_planted_constants(points: pd.DataFrame, tmp_path: Path) -> None:
    german = in_dialect(points, "german")
    german.to_csv(tmp_path / "a.csv", sep=";", decimal=",", index=False, encoding="cp1252")
    german.to_csv(tmp_path / "a.tsv", sep="\t", index=False)
    german.to_excel(tmp_path / "a.xlsx", index=False)
    german.to_parquet(tmp_path / "a.parquet")
    for ending in ("csv", "tsv", "xlsx", "parquet"):
        read_points = read_mu_table(tmp_path / f"a.{ending}").points
        np.testing.assert_allclose(read_points[list(points)], points, rtol=1e-9, atol=1e-9)
    fit = oilfilm.fit_table(tmp_path / "a.csv", **QUICK)
    np.testing.assert_allclose(fit.constants["value"], PLANTED.coefficients.constants, rtol=1e-5)


def test_load_becomes_pressure_with_ball_and_materials() -> None:
    # PCS Instruments state 1.25 GPa at 75 N for the 3/4 inch steel ball of their MTM
    pressure_gpa = pressure_gpa_of_load(np.array([75.0]), 9.525e-3, "steel,steel")
    assert pressure_gpa[0] == pytest.approx(1.25, rel=0.02)
    assert pressure_gpa_of_load(np.array([75.0]), 9.525e-3, "206GPa:0.3,steel") == pressure_gpa


@pytest.mark.parametrize(
    ("ball_radius_m", "materials", "key"),
    [
        (0.0, "steel,steel", "ball_radius_m"),
        (-9.525e-3, "steel,steel", "ball_radius_m"),
        (9.525e-3, "0GPa:0.3,0GPa:0.3", r"ball\.youngs_modulus_pa"),
        (9.525e-3, "steel,-206GPa:0.3", r"disc\.youngs_modulus_pa"),
        (9.525e-3, "206GPa:1,206GPa:1", r"ball\.poisson_ratio"),
        (9.525e-3, "steel,206GPa:7", r"disc\.poisson_ratio"),
    ],
)
def test_a_contact_that_no_rig_has_is_refused(
    points: pd.DataFrame, ball_radius_m: float, materials: str, key: str
) -> None:
    loaded = points.rename(columns={CONDITIONS[0]: "load_n"})
    with pytest.raises(oilfilm.OilfilmError, match=f"{key}.*: found"):
        oilfilm.fit_table(loaded, ball_radius_m=ball_radius_m, materials=materials)


@pytest.mark.parametrize("has_load_column", [True, False])
def test_a_pressure_that_contradicts_load_and_ball_is_refused(
    points: pd.DataFrame, has_load_column: bool
) -> None:
    """Whether each is a column or holds for all rows: 20 N give 0.818 GPa, 3 GPa is 3.67 times."""
    table, at = points.drop(columns=CONDITIONS[0]).assign(load_n=20.0), {CONDITIONS[0]: 3.0}
    if not has_load_column:
        table, at = points.assign(**{CONDITIONS[0]: 3.0}), {"load_n": 20.0}
    with pytest.raises(oilfilm.OilfilmError, match=r"3\.67 times that of the load"):
        oilfilm.fit_table(table, ball_radius_m=9.525e-3, at=at)


def test_negative_slip_and_its_traction_count_as_positive(points: pd.DataFrame) -> None:
    mirrored = points.assign(**{SLIP: -points[SLIP], MU: -points[MU]})
    read_points = read_mu_table(mirrored).points
    np.testing.assert_allclose(read_points[[SLIP, MU]], points[[SLIP, MU]], atol=1e-15)


@pytest.mark.slow
def test_without_ball_a_law_of_load_is_fitted_and_said(points: pd.DataFrame) -> None:
    frame = points.assign(load_n=80 * points[CONDITIONS[0]] ** 3).drop(columns=CONDITIONS[0])
    fit = oilfilm.fit_table(frame, **QUICK)
    assert fit.law.law.name == "wang-deng-load"
    assert "pressure" in fit.notes[-1]


def test_one_of_several_oils_and_curves_of_the_table_are_used(points: pd.DataFrame) -> None:
    curve_of_point = points.groupby(CONDITIONS, sort=False).ngroup()
    table_of_both = pd.concat(
        [points.assign(Oil="A", Run=curve_of_point), points.assign(Oil="B", Run=curve_of_point)]
    )
    with pytest.raises(oilfilm.OilfilmError, match=r"several oils\. Name one with --oil: A, B"):
        oilfilm.fit_table(table_of_both.reset_index(drop=True))
    fit = oilfilm.fit_table(table_of_both.reset_index(drop=True), oil="B", **QUICK)
    assert (fit.oil, len(fit.points), fit.points["run_id"].nunique()) == ("B", 64, 8)


@pytest.mark.parametrize(
    ("changed", "sentence"),
    [
        ({"p [GPa]": "p"}, "the column 'p', the max hertz pressure, has no unit"),
        ({"mu": "y"}, "no column is the traction coefficient"),
        ({"p [GPa]": "load [m]"}, r"no column is the maximum Hertz pressure; .*'load \[m\]'"),
        ({"T [°C]": "y"}, r"no column is the inlet temperature.*--temperature 40degC"),
        ({"U [m/s]": "mean speed [m/s]", "T [°C]": "mean u [m/s]"}, "could both be"),
    ],
)
def test_mistake_is_named(points: pd.DataFrame, changed: dict[str, str], sentence: str) -> None:
    with pytest.raises(oilfilm.OilfilmError, match=sentence):
        oilfilm.fit_table(in_dialect(points, "plain").rename(columns=changed))


def test_slip_that_no_rig_has_is_percent_where_the_unit_is_silent(points: pd.DataFrame) -> None:
    percent = points.assign(**{SLIP: 100 * points[SLIP]})
    with pytest.raises(oilfilm.OilfilmError, match=r"found 4\.28571 .* in percent"):
        oilfilm.fit_table(percent.rename(columns={SLIP: "SRR [-]"}))
    mu_table = read_mu_table(percent.rename(columns={SLIP: "SRR"}))
    np.testing.assert_allclose(mu_table.points[SLIP], points[SLIP])
    assert any("in %: as a ratio" in note for note in mu_table.notes)


def test_columns_that_no_fit_needs_ask_nothing(points: pd.DataFrame) -> None:
    table = points.assign(**{"time start [s]": 0.0, "time end [s]": 1.0})
    np.testing.assert_allclose(read_mu_table(table).points[list(points)], points)


@pytest.mark.parametrize("ending", ["frame", "parquet"])
def test_an_index_with_a_name_is_a_column(
    points: pd.DataFrame, tmp_path: Path, ending: str
) -> None:
    indexed = points.assign(oil=["A", "B"] * 32).set_index("oil")
    indexed.to_parquet(tmp_path / "mu.parquet")
    table = indexed if ending == "frame" else tmp_path / "mu.parquet"
    with pytest.raises(oilfilm.OilfilmError, match=r"has several oils.*: A, B"):
        oilfilm.fit_table(table)


@pytest.mark.parametrize(
    "oil", ['a"b', '"a" b', '"a', "Oil 1\nbatch 2", "a\tb", "a\rb", "#1", "\u00d6l"]
)
def test_labels_of_a_data_frame_are_those_of_its_cells(points: pd.DataFrame, oil: str) -> None:
    oils = [oil, "another"] * 32
    read = read_mu_table(points.assign(oil=oils, remark=oils)).points
    assert read["oil"].tolist() == oils


def test_half_of_a_letter_in_a_label_harms_no_row(points: pd.DataFrame) -> None:
    oils = pd.Series(["a\ud800", "a\ud801"] * 32, dtype=object)
    assert read_mu_table(points.assign(oil=oils)).points["oil"].nunique() == 2


def test_a_name_of_two_lines_is_one_name(points: pd.DataFrame) -> None:
    table = points.rename(columns={CONDITIONS[0]: "max Hertz pressure\n[GPa]"})
    np.testing.assert_allclose(read_mu_table(table).points[list(points)], points)


def test_data_frames_of_polars_and_arrow_are_read(points: pd.DataFrame) -> None:
    expected = read_mu_table(points).points
    for table in (polars.from_pandas(points), pyarrow.Table.from_pandas(points)):
        pd.testing.assert_frame_equal(read_mu_table(table).points, expected)
    with pytest.raises(oilfilm.OilfilmError, match=r"found a dict; expected the path"):
        oilfilm.fit_table(points.to_dict())


@pytest.mark.slow
@pytest.mark.parametrize("ending", quick_ones(["png", "svg"], ["svg"]))
def test_the_same_plot_has_the_same_bytes(
    fitted: ArrayFit, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, ending: str
) -> None:
    monkeypatch.setattr(oilfilm, "fit_table", lambda *_, **__: fitted)
    pictures = [tmp_path / f"{number}.{ending}" for number in range(2)]
    for picture in pictures:
        assert main(["fit", "a.csv", "--plot", str(picture)]) == 0
    first, second = (picture.read_bytes() for picture in pictures)
    assert first == second


def test_a_plot_is_refused_before_anything_is_fitted(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["fit", "missing.csv", "--plot", str(tmp_path / "a.pdf")]) == 2
    assert "expected a file that ends in .png or .svg" in capsys.readouterr().err
    monkeypatch.setattr("oilfilm.api.axes.find_spec", lambda name: None)
    assert main(["fit", "missing.csv", "--plot", str(tmp_path / "a.png")]) == 2
    assert "needs matplotlib" in capsys.readouterr().err


@pytest.mark.slow
def test_command_prints_plots_and_saves_what_predict_reads(
    points: pd.DataFrame,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(oilfilm, "fit_table", partial(oilfilm.fit_table, **QUICK))
    noisy = points[MU] * (1 + 0.01 * np.random.default_rng(1).standard_normal(len(points)))
    table, saved, picture = (tmp_path / name for name in ("a.csv", "saved", "a.png"))
    in_dialect(points.assign(**{MU: noisy}), "english").to_csv(table, index=False)
    assert main(["fit", str(table), "--save", str(saved), "--plot", str(picture)]) == 0
    printed = capsys.readouterr().out
    assert "64 points in 8 curves" in printed
    assert picture.read_bytes().startswith(b"\x89PNG")
    # the command that is shown as the next one can be pasted
    example = printed.partition("Then, as an example: oilfilm ")[2]
    assert main(shlex.split(example)) == 0
    assert "mu = " in capsys.readouterr().out
    assert {"report.html", "summary.txt", "exports", "tables"} == {p.name for p in saved.iterdir()}
    assert (saved / "exports/oil/traction_oil.py").is_file()
    at = ["--stress", "1.25GPa", "--speed", "30m/s", "--temperature", "80degC", "--slip", "5%"]
    assert main(["predict", "--results", str(saved), "--oil", "oil", *at]) == 0
    mu = float(capsys.readouterr().out.partition("mu = ")[2].partition(",")[0])
    true = PLANTED.predict_at(1.25, 30, 80, 0.05).traction_coefficient
    assert mu == pytest.approx(float(true), rel=0.01)
    assert main(["fit", str(table), "--save", str(saved)]) == 2
    assert "exists already" in capsys.readouterr().err


@pytest.mark.parametrize(("value", "code"), [(np.nan, 1), (0.01, 0)])
def test_no_prediction_is_offered_of_what_could_not_be_fitted(
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    value: float,
    code: int,
) -> None:
    fit = SimpleNamespace(
        constants=pd.DataFrame({"value": [value]}),
        points=pd.DataFrame({"run_id": ["a"]}),
        source="a.csv",
        notes=[],
        summary=str,
        save=lambda folder: None,
    )
    monkeypatch.setattr(oilfilm, "fit_table", lambda *_, **__: fit)
    monkeypatch.setattr("oilfilm.cli.fit._predict_command", lambda *_: "oilfilm predict")
    assert main(["fit", "a.csv", "--save", str(tmp_path / "saved")]) == code
    assert ("oilfilm predict" in capsys.readouterr().out) == (code == 0)


@pytest.fixture(scope="module")
def labelled(points: pd.DataFrame) -> pd.DataFrame:
    """The points with an oil and with the name of each run."""
    run_number = points.groupby(CONDITIONS, sort=False).ngroup()
    return points.assign(oil="PAO 4, batch 2", curve="run " + run_number.astype(str))


@pytest.mark.parametrize("remark_column", [0, 5])
def test_labels_are_those_of_their_columns_beside_cells_with_a_comma(
    labelled: pd.DataFrame, tmp_path: Path, remark_column: int
) -> None:
    table = labelled.copy()
    remarks = np.where(np.arange(len(table)) % 2, "warm, humid", "dry")
    table.insert(remark_column, "remark", remarks)
    file = tmp_path / "mu.csv"
    table.to_csv(file, index=False)
    read = read_mu_table(file).points
    sliding = labelled[labelled[SLIP] >= 0]
    assert read["oil"].tolist() == sliding["oil"].tolist()
    assert read["curve"].tolist() == sliding["curve"].tolist()


@pytest.mark.parametrize("label", ["oil", "curve"])
def test_a_row_without_its_label_is_refused(labelled: pd.DataFrame, label: str) -> None:
    # as below the first row of merged cells
    table = labelled.copy()
    table.loc[1, label] = None
    with pytest.raises(oilfilm.OilfilmError, match=f"1 of 64 rows name no {label}"):
        read_mu_table(table)


def test_sheets_of_which_one_names_no_curves_are_refused(
    labelled: pd.DataFrame, tmp_path: Path
) -> None:
    file = tmp_path / "mu.xlsx"
    with pd.ExcelWriter(file) as writer:
        labelled.to_excel(writer, sheet_name="june", index=False)
        labelled.drop(columns="curve").to_excel(writer, sheet_name="july", index=False)
    with pytest.raises(oilfilm.OilfilmError, match="its sheets have different columns"):
        read_mu_table(file)


def test_each_sheet_tells_how_many_rows_it_lacks(points: pd.DataFrame, tmp_path: Path) -> None:
    file = tmp_path / "mu.xlsx"
    with pd.ExcelWriter(file) as writer:
        for sheet_name, gap in (("june", MU), ("july", SLIP)):
            table = points.iloc[:3].astype(float)
            table.loc[1, gap] = np.nan
            table.to_excel(writer, sheet_name=sheet_name, index=False)
    read = read_mu_table(file)
    assert len(read.points) == 4
    for sheet_name in ("june", "july"):
        assert any(f"'{sheet_name}': 1 of 3 rows" in note for note in read.notes)


@pytest.mark.parametrize(("law", "fitted_count"), [(None, 64), ("wang-deng-load", 32)])
def test_a_gap_where_the_law_needs_no_number_leaves_no_row_out(
    points: pd.DataFrame, monkeypatch: pytest.MonkeyPatch, law: str | None, fitted_count: int
) -> None:
    """Of load and pressure a law has one."""
    fit_points = Mock(side_effect=oilfilm.OilfilmError("not fitted here"))
    monkeypatch.setattr("oilfilm.api.table_fit.fit_points", fit_points)
    load_n = 80 * points[CONDITIONS[0]] ** 3
    table = points.assign(load_n=load_n.where(points.index % 2 == 0))
    with pytest.raises(oilfilm.OilfilmError, match="not fitted here"):
        oilfilm.fit_table(table, law=law)
    assert len(fit_points.call_args.args[0]) == fitted_count
    with pytest.raises(oilfilm.OilfilmError, match="no row has all its numbers"):
        oilfilm.fit_table(points.assign(load_n=np.nan), law="wang-deng-load")


def test_a_misspelt_law_is_named_before_columns_that_it_would_need(points: pd.DataFrame) -> None:
    loaded = points.rename(columns={CONDITIONS[0]: "load_n"})
    with pytest.raises(oilfilm.OilfilmError, match=r"no law 'wang-deng-lod'.* wang-deng-load"):
        oilfilm.fit_table(loaded, law="wang-deng-lod")


def test_a_condition_of_all_rows_is_none_that_the_table_has(points: pd.DataFrame) -> None:
    with pytest.raises(oilfilm.OilfilmError, match="it has the inlet temperature, and another"):
        oilfilm.fit_table(points, at={"inlet_temperature_c": 300.0}, **QUICK)
    with pytest.raises(oilfilm.OilfilmError, match="found the key 'inlet_temp'"):
        oilfilm.fit_table(points, at={"inlet_temp": 300.0}, **QUICK)


@pytest.mark.parametrize("value", ["40degC", [40.0, 50.0], None, np.nan])
def test_a_condition_of_all_rows_is_one_number(points: pd.DataFrame, value: object) -> None:
    without_temperature = points.drop(columns="inlet_temperature_c")
    with pytest.raises(oilfilm.OilfilmError, match=r"inlet_temperature_c: .*expected.* number"):
        oilfilm.fit_table(without_temperature, at={"inlet_temperature_c": value}, **QUICK)


@pytest.mark.parametrize("mu_has_sign", [True, False])
def test_a_reversed_force_is_told(points: pd.DataFrame, mu_has_sign: bool) -> None:
    backwards = points.assign(**{SLIP: -points[SLIP]})
    if mu_has_sign:
        backwards[MU] *= -1
    reversed_force = pd.concat([points, backwards]).assign(**{MU: lambda table: -table[MU]})
    with pytest.raises(oilfilm.OilfilmError, match="at positive slip 56 have a negative mu"):
        read_mu_table(reversed_force)


@pytest.mark.parametrize("backwards", [False, True])
def test_mu_of_the_wrong_sign_is_noise_where_it_is_small(
    points: pd.DataFrame, backwards: bool
) -> None:
    """Without the noise below zero the mean mu at small slip is too large: such points stay.

    0.001 is noise and 0.04 is none: the median of mu is 0.013.
    """
    sign = -1 if backwards else 1
    mirrored = points.assign(**{SLIP: sign * points[SLIP], MU: sign * points[MU]})
    table = pd.concat([points, mirrored], ignore_index=True)
    row = int(np.flatnonzero(table[SLIP])[-1])
    table.loc[row, MU] = -sign * 1e-3
    read = read_mu_table(table)
    assert read.points[MU][row] == pytest.approx(-1e-3)
    assert any("1 of 128 rows are used" in note for note in read.notes)
    table.loc[row, MU] = -sign * 0.04
    read = read_mu_table(table)
    assert len(read.points) == 127
    assert any("1 of 128 rows are left out" in note for note in read.notes)


def test_mu_that_is_often_negative_at_positive_slip_is_refused(points: pd.DataFrame) -> None:
    table = points[points[SLIP] > 0].reset_index(drop=True)
    table.loc[::4, MU] *= -1
    with pytest.raises(oilfilm.OilfilmError, match="of 56 rows at positive slip 14 have a neg"):
        read_mu_table(table)


def test_an_oil_whose_name_cannot_be_saved_is_told(fitted: ArrayFit, tmp_path: Path) -> None:
    fit = replace(fitted, oil="SAE 10W-40")
    for write in (lambda: fit.save(tmp_path / "june"), lambda: fit.export(tmp_path / "law.py")):
        with pytest.raises(oilfilm.OilfilmError, match="found the name 'SAE 10W-40'"):
            write()
    assert not list(tmp_path.iterdir())


@pytest.mark.slow
def test_what_is_saved_of_simulated_points_says_so(
    points: pd.DataFrame, fitted: ArrayFit, tmp_path: Path
) -> None:
    text = tmp_path / "mu.csv"
    text.write_text("# simulated: yes\n" + points.to_csv(index=False), encoding="utf-8")
    oilfilm.fit_table(text, **QUICK).save(tmp_path / "june")
    for simulated, fit in (
        (True, oilfilm.fit_table(points, simulated=True, **QUICK)),
        (False, fitted),
    ):
        assert fit.simulated == simulated
        assert fit.summary().startswith("SIMULATED") == simulated
        assert (fit.plot().get_title("right") == "SIMULATED data") == simulated
    for file in ("report.html", "summary.txt", "exports/oil/traction_oil.py"):
        assert "SIMULATED" in (tmp_path / "june" / file).read_text(encoding="utf-8")
    # the table of points that was saved is a table of mu that says so, too: packed, or in memory
    saved = tmp_path / "june/tables/points.parquet"
    packed = tmp_path / "points.parquet.gz"
    packed.write_bytes(gzip.compress(saved.read_bytes()))
    for saved_table in (saved, packed, pyarrow.parquet.read_table(saved)):
        read = read_mu_table(saved_table)
        assert read.says_simulated
        np.testing.assert_allclose(read.points[list(points)], points)
    some_rejected = pd.read_parquet(saved).assign(accepted=lambda table: table.index > 3)
    read = read_mu_table(some_rejected)
    assert len(read.points) == len(points) - 4
    assert any("4 of 64 rows" in note for note in read.notes)
