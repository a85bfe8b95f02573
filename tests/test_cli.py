"""The commands `predict` and `plan`: numbers with interval and source, and mistakes told."""

import re
import sys
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pandas as pd
import pytest

import oilfilm
from bearings import RPM, in_operation, problem, shipped
from campaigns import LABORATORY, ROOT, Campaign, needs_study, printed
from command_line import succeeded
from oilfilm import tables
from oilfilm.base.errors import OilfilmError
from oilfilm.bearing.equilibria import friction_equilibrium
from oilfilm.bearing.quasistatic import OperatingPoints
from oilfilm.bearing.resistance import HEAT_TERMS
from oilfilm.cli import main
from oilfilm.cli.arguments import typed_quantity
from oilfilm.cli.predict import _lines_of_warnings
from oilfilm.fits.fitted import SLIP
from oilfilm.fits.soundness import finished_fit_tables
from oilfilm.fits.surface_search import with_surface
from oilfilm.physics.contact import max_hertz_pressure
from oilfilm.settings.resolve import resolve
from oilfilm.tables.table_needs import FIT_TABLES, SURFACE_TABLES
from oilfilm.torque.answers import CAUSE_BY_NAME
from oilfilm.torque.torque_uncertainty import NUMBER_NAMES_OF_CAUSE
from oilfilm.traction.laws.deng2026 import traction_coefficient
from page_blocks import blocks

# In the tests, so that they take less time: fewer draws, and fewer points that a plan is for.
FEWER_DRAWS = {"draws: 100 ": "draws: 40 "}
FEWER_POINTS = {
    "axial_load_n: [5000, 10000, 20000]": "axial_load_n: [5000, 20000]",
    "inner_speed_rpm: [3000, 6000, 9000, 12000]": "inner_speed_rpm: [3000, 12000]",
}


def write_with_changes(path: Path, original: Path, changes: dict[str, str]) -> None:
    """A copy of a file in which each text, which must be there once, is replaced."""
    text = original.read_text(encoding="utf-8")
    for old, new in changes.items():
        assert text.count(old) == 1, old
        text = text.replace(old, new)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")


def config_of(results: Path) -> str:
    """The folder of the settings beside a results folder."""
    return str(results.parent / "config")


@pytest.fixture(scope="module")
def results(demo: Campaign, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A results folder with the fit of one oil, beside the settings for it."""
    folder = tmp_path_factory.mktemp("cli") / "results"
    config_folder = folder.with_name("config")
    write_with_changes(config_folder / "config.yaml", ROOT / "config/config.yaml", FEWER_DRAWS)
    write_with_changes(
        config_folder / "campaigns/demo.yaml",
        ROOT / "workflow/deng2026_study/campaigns/demo.yaml",
        FEWER_POINTS,
    )
    footer = {"campaign": "demo", "data": "simulated", "rule": "fits"}
    curated_tables = {"points": demo.curated.points, "runs": demo.curated.runs}
    fit_tables = demo.fit("4102", searches=2, bootstrap=50)
    config = demo.config
    fit_tables = with_surface(fit_tables.replace(**curated_tables), "4102", config)
    table_by_name = {name: fit_tables.table(name) for name in (*FIT_TABLES, *SURFACE_TABLES)}
    table_by_name |= finished_fit_tables(fit_tables, config)
    for name, table in {**curated_tables, **table_by_name}.items():
        tables.write(table, name, folder / "tables" / f"{name}.parquet", footer)
    return folder


AT = {"--stress": "1.2GPa", "--speed": "30m/s", "--temperature": "70degC", "--slip": "0.05"}


def ask(results: Path, oil: str = "4102", **changed: str) -> int:
    options = AT | {f"--{name}": value for name, value in changed.items()}
    arguments = [word for option in options.items() for word in option]
    return main(["predict", "--oil", oil, "--results", str(results), *arguments])


@pytest.mark.slow
def test_prediction_has_its_interval(results: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert ask(results) == 0
    output = capsys.readouterr().out
    mu = float(output.partition("mu = ")[2].partition(",")[0])
    true = float(traction_coefficient(printed()["4102"], 1.2, 30.0, 70.0, 0.05))
    assert mu == pytest.approx(true, rel=0.01)
    assert "95% interval of the next good run 0.010" in output
    assert "simulated data" in output
    assert "OUTSIDE" not in output


@pytest.mark.parametrize(
    ("temperature_c", "slip", "outside"),
    [(-20.0, 0.05, {"inlet_temperature_c"}), (20.0, -0.05, set()), (20.0, -0.5, {SLIP})],
)
def test_only_the_slip_counts_by_its_size_for_the_tested_box(
    temperature_c: float, slip: float, outside: set[str]
) -> None:
    law = SimpleNamespace(conditions=("inlet_temperature_c",))
    box = np.array([[10.0, 40.0], [0.01, 0.1]])
    fitted_law: Any = SimpleNamespace(law=law, widened_box=box)
    row = {"over_limit": False, "spacings": 0.0, "distance": 0.0}
    lines = list(_lines_of_warnings(fitted_law, [temperature_c, slip], row))
    assert {line.split(": ")[1].split()[0] for line in lines} == outside


@pytest.mark.slow
@needs_study
def test_prediction_by_printed_constants_waits_for_no_import_that_it_does_not_use() -> None:
    command = "predict --printed --oil 4102 --stress 1.2GPa --speed 30m/s --temperature 70degC"
    code = f"import sys; from oilfilm.cli import main; main({[*command.split(), '--slip', '5%']})"
    output = succeeded([sys.executable, "-c", f"{code}; print(*sys.modules)"], cwd=ROOT)
    imported = set(output.splitlines()[-1].split())
    assert "deng2026_study" in imported
    assert imported.isdisjoint({"openpyxl", "PIL", "jinja2", "pint", "scipy.optimize"})


def test_prediction_mistakes_are_told(results: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for changed, message in (
        ({"temperature": "-70"}, "inlet_temperature_c above zero"),
        ({"oil": "oil"}, "no fit of oil 'oil'; there are fits of 4102"),
    ):
        assert ask(results, **changed) == 2
        assert message in capsys.readouterr().err


@pytest.mark.slow
def test_a_load_is_a_pressure_in_the_contact_of_the_rig(
    results: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    campaign = resolve(ROOT / "config", {"campaign": "demo"})
    (rig,) = campaign.rigs.values()
    contact = rig.contact()
    assert contact is not None
    # by Hertz with the rig's file; the command takes it from the runs
    load_n = np.array(45.0)
    pressure_pa = max_hertz_pressure(load_n, contact.radius_m, contact.reduced_modulus_pa)
    pressure_gpa = float(pressure_pa) / 1e9
    with_load = {name: value for name, value in AT.items() if name != "--stress"}
    words = [word for option in (with_load | {"--load": "45N"}).items() for word in option]
    assert main(["predict", "--oil", "4102", "--results", str(results), *words]) == 0
    text = capsys.readouterr().out
    assert f"45 N is a maximum pressure of {pressure_gpa:.4g} GPa" in text
    assert ask(results, stress=f"{pressure_gpa}GPa") == 0
    assert capsys.readouterr().out.splitlines()[0] == text.splitlines()[0]
    assert ask(results, load="45N") == 2
    assert "does not take --load. It takes --stress, --speed" in capsys.readouterr().err


def test_bare_number_is_in_the_unit_asked_for() -> None:
    assert typed_quantity("1.5", "GPa", "--stress") == 1.5
    assert typed_quantity("1.2e9Pa", "GPa", "--stress") == pytest.approx(1.2)
    # 1 revolution is 2 pi rad; 0 degC is 273.15 K
    assert typed_quantity("1256.637rad/s", "rpm", "--duty") == pytest.approx(12000)
    assert typed_quantity("373.15K", "degC", "--duty") == pytest.approx(100)
    assert typed_quantity("-4e1 degF", "degC", "--temperature") == pytest.approx(-40)
    with pytest.raises(OilfilmError, match="--speed"):
        typed_quantity("1.2.3", "m/s", "--speed")


def bearing(results: Path, *options: str) -> int:
    arguments = {"--load": "10kN", "--speed": "12000rpm", "--temperature": "70degC"}
    arguments |= dict(zip(options[::2], options[1::2], strict=True))
    words = [word for option in arguments.items() for word in option]
    words = ["--bearing", "mainshaft-167", *words] if "--bearing" not in words else words
    return main(["bearing", "--results", str(results), "--config", config_of(results), *words])


@pytest.mark.slow
def test_a_bearing_has_torque_and_loss_with_intervals_and_shares(
    results: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert bearing(results, "--oil", "4102") == 0
    text = capsys.readouterr().out
    number = r"([0-9.]+)"
    torque, lower, upper = map(
        float, re.findall(rf"torque +{number} N m, 95 % interval {number} to {number} N m", text)[0]
    )
    (power,) = re.findall(rf"power loss +{number} W", text)
    # 12 000 rpm are 1 256.6 rad/s
    assert float(power) == pytest.approx(1256.6 * torque, rel=0.01)
    assert lower < torque < upper
    assert "SIMULATED" in text
    assert "4 to 16 L/min" in text
    # the torque by the printed law, which made the data of the fit
    points = OperatingPoints.from_load_and_speed(np.array([1e4]), 12000 * RPM)
    truth = in_operation(problem(shipped("mainshaft-167"), points, "4102", 70.0))
    assert torque == pytest.approx(friction_equilibrium(truth).torque_n_m()[0], rel=0.01)
    answer = oilfilm.bearing_torque(
        "mainshaft-167", 1e4, [[6000], [12000]], 70, "4102", results, config_of(results)
    )
    assert answer.to_frame()["torque_n_m"].iloc[1] == pytest.approx(torque, rel=5e-3)
    assert (
        set(answer.shares()["variance_cause"]) == set(NUMBER_NAMES_OF_CAUSE) == set(CAUSE_BY_NAME)
    )
    # the terms add up to the moment that turns the inner ring
    parts = answer.parts().set_index("inner_speed_rpm").loc[12000, list(HEAT_TERMS)]
    assert parts.sum() == pytest.approx(torque, rel=5e-3)
    assert len(answer.plot().lines) == 1


@pytest.mark.slow
def test_a_fit_alone_gives_the_torque_of_its_law() -> None:
    fit = oilfilm.fit_table(oilfilm.example("simulated_mu.csv"), bootstrap=20, searches=2)
    operating_point = ("mainshaft-167", 1e4, 12000, 70)
    fit_and_rig = {"results": fit, "rig": "ball-on-disc-20mm"}
    frame = oilfilm.bearing_torque(*operating_point, oil="4102", **fit_and_rig).to_frame()
    # the torque by the printed law, which made the data of the table
    points = OperatingPoints.from_load_and_speed(np.array([1e4]), 12000 * RPM)
    truth = in_operation(problem(shipped("mainshaft-167"), points, "4102", 70.0))
    assert frame["torque_n_m"].tolist() == pytest.approx(
        friction_equilibrium(truth).torque_n_m(), rel=0.01
    )
    for arguments, sentence in (
        ({"results": fit, "oil": "4102"}, "rig: found nothing"),
        (fit_and_rig, "oil: found nothing"),
        ({**fit_and_rig, "oil": "4102", "results": "results/demo"}, "rig: is for a fit"),
    ):
        with pytest.raises(oilfilm.OilfilmError, match=sentence):
            oilfilm.bearing_torque(*operating_point, **arguments)


def test_saved_fit_with_the_name_of_a_campaign_is_no_campaign(
    results: Path, tmp_path: Path
) -> None:
    coefficients = tables.read("coefficients", results / "tables/coefficients.parquet")
    saved = tmp_path / "demo"
    footer = {"campaign": "demo", "data": "measured", "settings": None}
    tables.write(coefficients, "coefficients", saved / "tables/coefficients.parquet", footer)
    with pytest.raises(oilfilm.OilfilmError, match="saved fit names no oil and no rig"):
        oilfilm.bearing_torque("mainshaft-167", 1e4, 6000, 70, "4102", saved, config_of(results))


@pytest.mark.slow
def test_what_is_not_known_of_a_bearing_is_said(results: Path) -> None:
    answer = oilfilm.bearing_torque(
        "mainshaft-167", 1e4, 6000, 70, "4102", results, config_of(results)
    )
    text = answer.summary()
    assert re.search(r"best oil +4102, in \d+% of the draws", text)
    assert "not known" not in text
    points = answer.answers.points.assign(
        best_share=np.nan, bistable=pd.array([None], dtype="boolean")
    )
    shares = answer.answers.shares.copy()
    shares.loc[shares["variance_cause"] == "runs", ["torque_share", "slip_share"]] = np.nan
    unknown = replace(answer, answers=answer.answers._replace(points=points, shares=shares))
    assert re.search(r"scatter of traction runs +not known", unknown.summary())
    assert re.search(r"best oil +4102, share of the draws not known", unknown.summary())
    assert "it is not known whether the cage may skid here" in unknown.summary()


@pytest.mark.slow
def test_frost_at_one_point_leaves_the_answers_of_the_others(results: Path) -> None:
    in_frost, alone = (
        oilfilm.bearing_torque(
            "mainshaft-167", 8e3, 7000, temperatures, "4102", results, config_of(results)
        )
        for temperatures in ([100.0, -5.0], [100.0])
    )
    columns = ["torque_n_m", "torque_n_m_lower", "torque_n_m_upper"]
    answers_in_frost = in_frost.to_frame().set_index("inlet_temperature_c")[columns]
    np.testing.assert_allclose(answers_in_frost.loc[100.0], alone.to_frame()[columns].iloc[0])
    assert answers_in_frost.loc[-5.0].notna().all()
    # the law has an error there, too
    shares = in_frost.shares()
    is_law_in_frost = (shares["variance_cause"] == "law") & (shares["inlet_temperature_c"] == -5.0)
    assert (shares.loc[is_law_in_frost, "standard_uncertainty"] > 0).tolist() == [True]


@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (("--load", "0N"), "axial_load: found 0 N; expected more than 0"),
        (("--speed", "12kg"), "--speed: found '12kg': the unit 'kg' is none"),
        (("--temperature", "900degC"), "temperature: found 900 degC"),
        (("--oil", "water"), "no oil 'water' that can be used in a bearing; there are 4102"),
        (("--bearing", "wheel"), "wheel"),
    ],
)
def test_a_mistake_in_a_bearing_ends_in_a_sentence(
    results: Path, capsys: pytest.CaptureFixture[str], options: tuple[str, str], sentence: str
) -> None:
    assert bearing(results, *options) == 2
    assert sentence in capsys.readouterr().err


@pytest.mark.slow
def test_python_of_the_page_on_bearings_does_what_it_says(
    results: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    (code,) = (
        block.content for block in blocks() if block.names >= {"docs/how-to/bearing.md python"}
    )
    (tmp_path / "results").mkdir()
    (tmp_path / "results/demo").symlink_to(results)
    (tmp_path / "config").symlink_to(config_of(results))
    monkeypatch.chdir(tmp_path)
    variables: dict[str, Any] = {}
    exec(compile(code, "docs/how-to/bearing.md", "exec"), variables)
    text = capsys.readouterr().out
    for speed in (6000, 9000, 12000):
        assert f"oil 4102: 10000 N, {speed} rpm, oil at 70 degC" in text
    answer = variables["answer"]
    # one row per oil and operating point, and one per cause
    assert len(answer.to_frame()) == 3
    assert len(answer.shares()) == 3 * len(NUMBER_NAMES_OF_CAUSE)
    assert answer.plot().get_xlabel() == "Speed of the inner ring (rpm)"


def plan(results: Path, *options: str) -> int:
    return main(
        [
            "plan",
            "--results",
            str(results),
            "--oil",
            "4102",
            "--config",
            config_of(results),
            *options,
        ]
    )


@pytest.mark.slow
def test_plan_names_conditions_in_order(results: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert plan(results, "--for", "cage-slip", "--count", "3") == 0
    text = capsys.readouterr().out
    # of torque.matrix
    law_uncertainty = re.search(
        r"mainshaft-167: .* cage slip .* 8 operating points: ([0-9.]+[0-9]);", text
    )
    with_exact_sensors = re.search(r"With exact sensors it would be ([0-9.]+[0-9])", text)
    whole_uncertainty = re.search(r"cage slip from everything .* uncertain: ([0-9.]+[0-9])\.", text)
    planned_tests = re.findall(r"(?m)^ *([123]) .* ([0-9.]+) +([0-9.]+)$", text)
    assert law_uncertainty and with_exact_sensors and whole_uncertainty
    assert [order for order, _, _ in planned_tests] == ["1", "2", "3"]
    uncertainties = [
        float(law_uncertainty[1]),
        *(float(uncertainty_after) for _, uncertainty_after, _ in planned_tests),
    ]
    assert uncertainties == sorted(uncertainties, reverse=True)
    # they are a small part of it: the printed digits may be equal
    assert float(with_exact_sensors[1]) <= float(law_uncertainty[1])
    # drag and ring temperatures leave the most, whatever is tested
    for _, _, uncertainty_after in planned_tests:
        assert float(uncertainty_after) == pytest.approx(float(whole_uncertainty[1]), rel=0.1)


@pytest.mark.nightly
def test_no_traction_is_planned_for_a_torque_that_hangs_on_something_else(
    results: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    # the uncertainty is that of the whole torque, of which the law's part is 1 %
    assert plan(results, "--for", "torque") == 0
    text = capsys.readouterr().out
    whole_uncertainty = re.search(r"friction torque from everything .* uncertain: (\S+) %", text)
    assert whole_uncertainty
    assert float(whole_uncertainty[1]) > 10
    assert "drag" in text
    assert "max_hertz_pressure_gpa" not in text


@pytest.mark.nightly
def test_plan_for_other_bearing_and_duty(results: Path, capsys: pytest.CaptureFixture[str]) -> None:
    duty = ["--bearing", "harris-218", "--duty", "20kN,5000rpm,100degC"]
    assert plan(results, *duty, "--for", "cage-slip", "--count", "1") == 0
    text = capsys.readouterr().out
    assert "4102 in harris-218: standard uncertainty of the cage slip" in text
    assert "at 20000 N, 5000 rpm, 100 degC" in text
    assert "from campaign demo, simulated data" in text


def test_plan_lists_the_runs_that_a_campaign_lacks(
    results: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert plan(results, "--for", "campaign") == 0
    text = capsys.readouterr().out
    # two logs of this oil have a planted defect: 30 m/s at 70 degC, 25 m/s at 50 degC
    assert re.search(r"(?m)^ *\d+ +1.25 +30 +70 .* planned$", text)
    assert re.search(r"(?m)^ *\d+ +1 +25 +50 .* planned$", text)
    assert re.search(r"(?m)^ *1 .* reference$", text)
    # the names of the demonstration are in the order of pressure
    assert "order of pressure" in text
    assert "friction torque" not in text
    assert plan(results, "--for", "campaign", "--count", "3") == 2
    assert "--count: " in capsys.readouterr().err


def test_oil_without_a_fit_has_a_plan_of_runs_and_a_reason_for_no_plan_of_tests(
    results: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert plan(results, "--oil", "4050") == 0
    text = capsys.readouterr().out
    assert "4050: " in text
    assert "runs to make next" in text
    assert re.search(r"(?m)^not planned: .*no fit of oil '4050'", text)


def test_campaign_without_results_gets_a_first_plan(capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ["plan", "--campaign", "laboratory", "--config", str(LABORATORY), "--oil", "4102"]
    assert main(arguments) == 0
    text = capsys.readouterr().out
    # a matrix of 72 conditions, and a reference run before every fifth of them
    assert "4102: 87 runs to make next on ball-on-disc-20mm" in text
    bearing_options = (["--bearing", "harris-218"], ["--duty", "20kN,5000rpm,100degC"])
    for options in (["--for", "torque"], ["--count", "3"], *bearing_options):
        assert main([*arguments, *options]) == 2
        refusal = capsys.readouterr().err
        assert options[0] in refusal
        assert "no results" in refusal


@pytest.mark.slow
@pytest.mark.parametrize(
    ("options", "sentence"),
    [
        (["--bearing", "nothing"], "--bearing: names the bearing 'nothing'"),
        (["--duty", "20kN,5000rpm"], "expected axial load, speed and oil temperature"),
        (["--duty", "20kN,5000rpm,100bar"], "--duty: found '100bar'"),
        (["--duty=-20kN,5000rpm,100degC"], "three numbers above 0"),
        (["--count", "0"], "--count: found 0; expected 1 to 50"),
        (["--oil", "water"], "no oil 'water'; there are 4102"),
        (["--oil", "4050", "--for", "torque"], "no fit of oil '4050'; there are fits of 4102"),
        (["--campaign", "demo"], "--campaign: found beside --results"),
    ],
)
def test_mistakes_in_a_plan_are_told(
    results: Path, capsys: pytest.CaptureFixture[str], options: list[str], sentence: str
) -> None:
    assert plan(results, *options) == 2
    assert sentence in capsys.readouterr().err
