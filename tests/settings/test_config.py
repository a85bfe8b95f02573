"""Configuration: every mistake is told with file, line and key; the parts that a rule lists."""

import json
import os
import re
import shutil
from collections.abc import Iterator
from pathlib import Path
from typing import Any, get_args

import numpy as np
import pytest
import yaml

from campaigns import LABORATORY, needs_study, without
from oilfilm.base.errors import OilfilmError
from oilfilm.settings.base import Group
from oilfilm.settings.campaign import CampaignFile, Semantics
from oilfilm.settings.config import Config
from oilfilm.settings.messages import load
from oilfilm.settings.resolve import campaign_names, resolve, resolve_snakemake_config, safe_name
from oilfilm.settings.resolved import Settings, merge
from oilfilm.settings.rig import OilFile
from oilfilm.settings.yaml_file import read_yaml

ROOT = Path(__file__).parents[2]


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    shutil.copytree(ROOT / "config", tmp_path / "config")
    for name in ("laboratory", "simulated"):
        shutil.copy(LABORATORY / f"campaigns/{name}.yaml", tmp_path / "config/campaigns")
    return tmp_path / "config"


def test_campaign_settings_win_over_defaults_and_the_command_line_over_both(folder: Path) -> None:
    default_c = read_yaml(folder / "config.yaml").values["gates"]["temperature_tolerance_c"]
    of_campaign = resolve(folder, {"campaign": "etm-slim"})
    gates = {"temperature_tolerance_c": 9.0}
    with_typed = resolve(folder, {"campaign": "etm-slim", "gates": gates})
    assert default_c == 2.0
    assert of_campaign.gates.temperature_tolerance_c == 2.5
    assert with_typed.gates.temperature_tolerance_c == 9.0


@pytest.mark.parametrize("where", ["oils", "oil_aliases"])
def test_name_of_two_oils_is_refused_however_it_is_written(folder: Path, where: str) -> None:
    given = {"oils/4102": "aliases: [\u00d6l B-12]", "oils/4050": "aliases: [o\u0308l  b-12]"}
    if where == "oil_aliases":
        del given["oils/4050"]
        given["campaigns/laboratory"] = 'oil_aliases: {"4050": o\u0308l  b-12}'
    for name, line in given.items():
        path = folder / f"{name}.yaml"
        path.write_text(f"{line}\n{path.read_text('utf-8')}", "utf-8")
    with pytest.raises(OilfilmError, match=r"laboratory\.yaml, line \d+: .* one of '4102' too"):
        resolve(folder, {"campaign": "laboratory"})


def test_of_several_unknown_names_the_first_is_reported(folder: Path) -> None:
    path = folder / "campaigns/laboratory.yaml"
    names = [f"oil-{number}" for number in range(20)]
    lines = "".join(f"  {name}: [x]\n" for name in names)
    path.write_text(f"oil_aliases:\n{lines}{path.read_text('utf-8')}", "utf-8")
    with pytest.raises(OilfilmError, match=r"laboratory\.yaml, line 2: 'oil-0' is none"):
        resolve(folder, {"campaign": "laboratory"})


def test_a_law_that_needs_the_oil_is_refused_for_fits_with_the_reason(folder: Path) -> None:
    given = {"campaign": "laboratory", "fit": {"law": "rational-viscosity"}}
    with pytest.raises(OilfilmError, match="'rational-viscosity' needs properties"):
        resolve(folder, given)
    given["fit"] = {"law": "no-such-law"}
    with pytest.raises(OilfilmError, match="no-such-law"):
        resolve(folder, given)


CONFIG, OWN = "config.yaml", "campaigns/laboratory.yaml"
ETM, TWIN = "campaigns/etm-slim.yaml", "campaigns/simulated.yaml"
RIG, OIL = "rigs/ball-on-disc-20mm.yaml", "oils/4102.yaml"
RIGS, FIRST = "rigs: [pcs-etm]", "coefficients:\n  viscosity_intercept:"
# File, what stands there, what is written instead, parts of the message.
MISTAKES = [
    (ETM, "data: measured", "data: mesured", ["`data`", "'mesured'", "'measured'"]),
    (ETM, "oils: []", "oils: 4102", ["`oils`", "4102", "a list"]),
    (ETM, "oils_without_properties: [unrecorded-oil]\n", "", ["names no oil", "`oils`"]),
    (ETM, "figures:", "figurs:", ["unknown key 'figurs'", "Did you mean 'figures'?"]),
    (ETM, "description:", "# description:", ["the key 'description' is missing"]),
    (ETM, RIGS, "set_points: {load_n: 4e1}", ["'4e1'", "Write 40."]),
    (ETM, RIGS, "set_points: {load_n: .nan}", ["nan", "finite"]),
    pytest.param(
        *(ETM, "[curves", "[fig02, curves", ["line 10", "fig02", "study 'deng2026_study'"]),
        marks=needs_study,
    ),
    (ETM, "[curves", "[size-effect, curves", ["line 10", "`size-effect` needs `torque`"]),
    (ETM, "rigs:", "semantics_of_rig: {mtm: {zero: standstill}}\nrigs:", ["'mtm'", "pcs-etm"]),
    (ETM, "data: measured", "data: measured\ntwin: {}", ["`twin"]),
    (ETM, "data: measured", "data: measured\nsimulated_by: x", ["`data: simulated`", "drop this"]),
    (TWIN, "data: simulated", "simulated_by: x\ndata: simulated", ["`twin` simulates", "drop"]),
    (ETM, RIGS, "[a]: 1", ["a group as a key"]),
    (ETM, RIGS, "rigs: [../rigs]", ["`rigs.0`", "'../rigs'", "text of the form"]),
    (ETM, RIGS, "rigs: [NO]", ["`rigs.0`", "False", 'put the word in quotes, as "NO"']),
    (ETM, RIGS, "rigs: [0123]", ["found 0123", "reads as 83", "put the text in quotes"]),
    (ETM, RIGS, "on: 3\nrigs: [pcs-etm]", ["the key True is no text", "put the word in quotes"]),
    (ETM, RIGS, "rigs: [pcs-emt]", ["pcs-emt", "does not exist", "pcs-etm"]),
    (ETM, RIGS, "rigs: [pcs-etm]\nrigs: [other]", ["'rigs'", "first defined at line"]),
    (ETM, RIGS, "rigs: &a [pcs-etm]\noils: *a", ["alias"]),
    (ETM, RIGS, "rigs: [", ["not valid YAML", "line"]),
    (ETM, RIGS, "<<: {rigs: [pcs-etm]}", ["`<<` takes keys from elsewhere"]),
    (ETM, RIGS, "rigs: !!python/object:os.system x", ["not valid YAML"]),
    (ETM, RIGS, f"rigs: {'[' * 50}{']' * 50}", ["nested more than 50 deep"]),
    # PyYAML has a limit of its own from 6.0.4 on
    (ETM, RIGS, f"rigs: {'[' * 3000}{']' * 3000}", ["nest"]),
    (ETM, "traction_min: -0.03", f"traction_min: -1{'0' * 5000}", ["a value cannot be read"]),
    (OWN, "gpa: [1.0, 1.25", "gpa: [1000, 1250", ["found 1000", "or less, in GPa"]),
    (TWIN, "baseline_s: 3.0", "baseline_s: 0.01", ["`twin.baseline_s`", "0.01 s", "50 Hz"]),
    (TWIN, "step_s: 2.4", "step_s: 0.01", ["`twin.step_s`", "0.01 s", "50 Hz"]),
    # 2 x 150 rows of rolling, 31 x 120 of slip
    (TWIN, "spikes: 3", "spikes: 4021", ["`twin.spikes`", "4021", "4020"]),
    (TWIN, "rest_s: 6.0", "rest_s: 0.02", ["`torque.twin.rest_s`", "0.02 s", "20 Hz"]),
    (TWIN, "step_s: 8.0", "step_s: 0.02", ["`torque.twin.step_s`", "0.02 s", "20 Hz"]),
    (CONFIG, "lambda_limit: 3.0", "lambda_limit:", ["`gates.lambda_limit`: found nothing"]),
    (CONFIG, "settle_s: 0.8", "settle_s: 1.0e+14", ["plateaus.settle_s`", "86400 or less"]),
    (CONFIG, 'date: "2026-01-10"', 'date: "2026-02-30"', ["a day of the calendar"]),
    (CONFIG, 'date: "2026-01-10"', "date: 2026-01-10", ['Put it in quotes: "2026-01-10"']),
    (CONFIG, "s: [20, 200]", "s: [200, 20]", ["found [200, 20]", "rising"]),
    (RIG, "ball: {youngs_modulus_pa: 203.0e+9", "ball: {youngs_modulus_pa: 207", ["in Pa"]),
    (RIG, "ball_roughness_ra_um: 0.014", "ball_roughness_ra_um: 14", ["2 or less, in um"]),
    (RIG, "ball_radius_m: 0.010", "ball_radius_m: 10", ["`ball_radius_m`", "0.5 or less, in m"]),
    (OIL, 'id: "4102"', 'id: "4050"', ["'4102', the file's name"]),
    (OIL, "[298.15, 970.4]", "[298.15, 0.9704]", ["kg_m3.0.1`", "400 or more, in kg/m3"]),
    (OIL, "[[298.15, 970.4]", "[[25, 970.4]", ["`density_kg_m3.0.0`", "200 or more, in K"]),
    (OIL, "[[298.15, 970.4]", "[[373.15, 970.4]", ["each temperature once"]),
    (OIL, "[[298.15, 970.4]", "[[298.15]", ["kg_m3.0", "missing"]),
    (OIL, "[[300, 0.147]", "[[300, 147]", ["1 or less, in W/(m K)"]),
    (OIL, "[[300, 2000]", "[[300, 2]", ["in J/(kg K)"]),
    (OIL, f"{FIRST} 8.7181", f"{FIRST} 8.5", ["`coefficients`", "100c_cst is 7;", "within 25%"]),
    # the key has the name of a model, which pydantic puts into its locations
    (OIL, "id:", "vogel: 1\nid:", ["unknown key 'vogel'", "viscosity"]),
    (OIL, "density_kg_m3", "densty_kg_m3", ["unknown key", "Did you mean 'density_kg_m3'?"]),
    (
        OIL,
        "y_exponent:",
        "y_exponnt:",
        ["unknown key", "Did you mean 'pressure_viscosity_exponent'?"],
    ),
    (CONFIG, "bootstrap: 1000", "bootstrap: '1000'", ["Write 1000, with no quotes"]),
    (CONFIG, "bootstrap: 1000", "bootstrap: 01000", ["found 01000", "reads as 512"]),
    (CONFIG, "settle_s: 0.8", "settle_s: 1:30", ["found 1:30", "reads as 90"]),
    (CONFIG, "lambda_limit: 3.0", "lambda_limit: 'inf'", ["found 'inf', expected a number. "]),
    (CONFIG, "gates:", '"[key]": 1\ngates:', ["unknown key '[key]'"]),
    # as an editor with a Western code page writes it
    (RIG, "20 mm ball", "\udcb5m ball", ["line 3", "UTF-8", "0xb5", "save the file"]),
]


@pytest.mark.parametrize(("file", "old", "new", "expected"), MISTAKES)
def test_mistake_is_told(folder: Path, file: str, old: str, new: str, expected: list[str]) -> None:
    path = folder / file
    before, old_text, after = path.read_text("utf-8").partition(old)
    assert old_text
    path.write_text(f"{before}{new}{after}", "utf-8", "surrogateescape")
    with pytest.raises(OilfilmError) as mistake:
        resolve(folder, {"campaign": path.stem if file in (ETM, TWIN) else "laboratory"})
    line = "" if file == ETM else before.count("\n") + 1
    assert str(mistake.value).startswith(f"{path}, line {line}")
    for phrase in expected:
        assert phrase in str(mistake.value)


def test_numbers_inside_groups_of_the_command_line_are_numbers(folder: Path) -> None:
    # snakemake --config "gates={'load_tolerance': 0.05}" hands over the text '0.05'
    typed = {"gates": {"load_tolerance": "0.05"}, "release": {"tag": "4050"}}
    resolved = resolve(folder, typed | {"campaign": "laboratory"})
    assert resolved.gates.load_tolerance == 0.05
    assert resolved.release.tag == "4050"
    with pytest.raises(OilfilmError, match="found 'much', expected a number"):
        resolve(folder, {"gates": {"load_tolerance": "much"}})


@pytest.mark.parametrize("value", ["a: b", "[[[", "*a", "2026-13-45", ".nan", float("nan")])
def test_no_value_of_the_command_line_ends_in_a_traceback(folder: Path, value: object) -> None:
    with pytest.raises(OilfilmError, match=r"--config.*expected a (finite )?number"):
        resolve(folder, {"gates": {"load_tolerance": value}})


def test_unknown_campaign_names_the_known_ones(folder: Path) -> None:
    with pytest.raises(OilfilmError, match=r"names the campaign 'june'.*laboratory.*template"):
        resolve(folder, {"campaign": "june"})


def test_campaign_may_override_every_key_of_the_settings(folder: Path) -> None:
    settings = read_yaml(folder / "config.yaml").values
    del settings["campaign"]
    path = folder / "campaigns" / "etm-slim.yaml"
    campaign = {**read_yaml(path).values, "settings": settings}
    path.write_text(yaml.safe_dump(campaign), encoding="utf-8")
    resolved = resolve(folder, {"campaign": "etm-slim"})
    # how the work is spread and in which image it runs are no part of the settings of a result
    del settings["split"], settings["container"]
    assert {key: resolved.plain_values()[key] for key in settings} == settings


def test_template_of_an_oil_is_a_good_oil_file() -> None:
    oil = load(ROOT / "config/oils/template.yaml", OilFile).properties()
    # the template says 5 cSt and 920 kg/m3 at 100 degC
    assert oil.dynamic_viscosity_pa_s(np.array([100.0])) == pytest.approx(5e-6 * 920, rel=0.02)


def test_project_needs_only_what_differs(tmp_path: Path) -> None:
    (tmp_path / "config.yaml").write_text("campaign: etm-slim\nseed: 7\n", encoding="utf-8")
    all_settings = resolve(ROOT / "config", {"campaign": "etm-slim"}).plain_values()
    assert resolve(tmp_path, {}).plain_values() == {**all_settings, "seed": 7}
    (tmp_path / "config.yaml").write_text("gatse: {lambda_limit: 3}\n", encoding="utf-8")
    with pytest.raises(OilfilmError, match=r"line 1.*unknown key 'gatse'.*'gates'"):
        resolve(tmp_path, {})


def test_oil_of_a_project_wins_over_the_one_that_comes_with_oilfilm(folder: Path) -> None:
    for name in ("4050", "4010"):
        (folder / f"oils/{name}.yaml").unlink()
    path = folder / "oils/4102.yaml"
    path.write_text(path.read_text("utf-8").replace("name:", "name: own, ", 1), "utf-8")
    own_oils, shipped_oils = (
        resolve(config_folder, {"campaign": "laboratory"}).plain_values()["oils"]
        for config_folder in (folder, LABORATORY)
    )
    assert own_oils["4050"] == shipped_oils["4050"]
    assert own_oils["4102"]["name"].startswith("own, ")


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        (1000.0, "as a number"),
        ("a" * 300, "at most 100"),
        ("", "a name"),
        (None, "found nothing, expected a name"),
    ],
)
def test_name_that_cannot_be_a_file_is_refused(folder: Path, name: object, expected: str) -> None:
    with pytest.raises(OilfilmError, match=expected):
        resolve(folder, {"campaign": name})


def test_configuration_of_a_host_takes_the_place_of_the_file(folder: Path) -> None:
    """A workflow that imports this one may give it all of config.yaml; a campaign still wins."""
    whole_config = {**read_yaml(folder / "config.yaml").values, "folder": str(folder)}
    whole_config = merge(whole_config, {"campaign": "etm-slim", "seed": 3})
    settings = resolve_snakemake_config(whole_config, {})
    assert (settings.campaign.name, settings.seed) == ("etm-slim", 3)
    assert settings.gates.temperature_tolerance_c == 2.5
    # what is typed wins, even where it says the same as the file
    typed = {"gates": {"temperature_tolerance_c": 2.0}}
    assert resolve_snakemake_config(whole_config, typed).gates.temperature_tolerance_c == 2.0
    campaign_alone = {"campaign": "etm-slim"}
    assert (
        resolve_snakemake_config({**campaign_alone, "folder": str(folder)}, campaign_alone).seed
        != 3
    )


@pytest.mark.parametrize("campaign", campaign_names(ROOT / "config"))
def test_shipped_campaigns_can_be_read(campaign: str) -> None:
    assert resolve(ROOT / "config", {"campaign": campaign}).campaign.name == campaign


def test_part_that_a_rule_lists_is_the_same_after_the_job_has_read_it(config: Settings) -> None:
    part = config.plain_part("gates", "oils", campaign=("twin", "torque", "header"))
    assert set(part) == {"campaign", "gates", "oils"}
    assert set(part["campaign"]) == {"name", "data", "twin", "torque", "header"}
    handed_over = json.loads(json.dumps(part))
    settings = Settings.from_plain_values(handed_over)
    assert settings.plain_values() == part
    assert settings.gates == config.gates
    assert settings.campaign.twin == config.campaign.twin
    assert settings.oils["4102"] == config.oils["4102"]


def test_key_left_out_has_its_default_only_where_the_rule_lists_it(config: Settings) -> None:
    measured = without(config, "twin", "torque", "semantics")
    assert measured.campaign.twin is None
    listed = Settings.from_plain_values(
        measured.plain_part(campaign=("oils", "twin", "semantics"))
    ).campaign
    assert (listed.twin, listed.semantics) == (None, Semantics())
    with pytest.raises(AttributeError, match="torque"):
        _ = listed.torque


def test_changed_settings_are_checked_and_leave_the_others_alone(config: Settings) -> None:
    changed = config.with_changes({"fit": {"bootstrap": 20}})
    assert (changed.fit.bootstrap, changed.fit.searches) == (20, config.fit.searches)
    assert config.fit.bootstrap == 1000
    with pytest.raises(OilfilmError, match=r"`fit.bootstrap`: found 1, expected 20 or more"):
        config.with_changes({"fit": {"bootstrap": 1}})


@pytest.mark.parametrize(
    ("changes", "is_common"),
    [
        ({}, True),
        ({"disc_roughness_ra_um": 0.02}, True),
        ({"disc_roughness_ra_um": None}, True),
        ({"ball_radius_m": 0.012}, False),
        ({"ball_radius_m": None}, False),
    ],
)
@pytest.mark.parametrize("roughness_um", [0.01, None])
def test_rigs_with_one_ball_and_one_steel_have_a_common_contact(
    config: Settings, changes: dict[str, Any], is_common: bool, roughness_um: float | None
) -> None:
    (rig,) = config.rigs.values()
    first = rig.model_copy(update={"disc_roughness_ra_um": roughness_um})
    second = first.model_copy(update=changes)
    contact = config.model_copy(update={"rigs": {"a": first, "b": second}}).common_contact()
    assert (contact is not None) == is_common


@pytest.mark.parametrize(
    "key_path", [("cage_slip", "further_temperature_c"), ("size_effect", "inlet_temperature_c")]
)
def test_oil_is_judged_at_every_temperature_of_the_bearing(
    folder: Path, key_path: tuple[str, str]
) -> None:
    # beyond its last row the density falls by 1.6 kg/m3 per K: a thermal expansion of 0.0019 1/K at
    # 140 degC, and of 0.0023 1/K, more than any oil has, at 245 degC
    path = folder / "oils/4102.yaml"
    text = re.sub(
        r"(?m)^density_kg_m3:.*\n(?:  .*\n)*",
        "density_kg_m3: [[233, 1016], [353, 950], [393, 886]]\n",
        path.read_text("utf-8"),
    )
    path.write_text(text, "utf-8")
    resolve(folder, {"campaign": "laboratory"})
    group, key = key_path
    level = [245.0] if key.startswith("further") else 245.0
    with pytest.raises(OilfilmError, match="from 25 to 245 degC"):
        resolve(folder, {"campaign": "laboratory", "bearing": {group: {key: level}}})


def test_file_of_settings_that_is_large_or_a_pipe_is_refused_at_once(tmp_path: Path) -> None:
    (tmp_path / "large.yaml").write_text("key: {}\n" * 100_000)
    os.mkfifo(tmp_path / "pipe.yaml")
    for path in tmp_path.iterdir():
        with pytest.raises(OilfilmError, match="524288 bytes"):
            load(path, CampaignFile)


def models_in(annotation: Any) -> Iterator[type[Group]]:
    if isinstance(annotation, type) and issubclass(annotation, Group):
        yield annotation
    for part in get_args(annotation):
        yield from models_in(part)


def key_path_by_property(model: type[Group], group: str = "") -> Iterator[str]:
    """The keys of a model that hold values, with the groups that they are in."""
    for name, field in model.model_fields.items():
        inner_models = [*models_in(field.annotation)]
        if not inner_models:
            yield f"{group}{name}"
        for inner_model in inner_models:
            yield from key_path_by_property(inner_model, f"{group}{name}.")


# Read by names that are made: of columns, or of a key with a range.
BY_NAME = {
    "bearing.ellipse_factor_range",
    "bearing.replenishment_constant_range",
    "report.nearby.max_hertz_pressure_gpa_relative",
    "report.nearby.entrainment_speed_m_s_relative",
}


def test_every_key_of_the_configuration_is_read_somewhere() -> None:
    files = (path for path in (ROOT / "workflow").rglob("*") if "settings" not in path.parts)
    all_source = "\n".join(
        path.read_text("utf-8")
        for path in files
        if path.suffix in {".py", ".smk", ".jinja", ".yaml"}
    )
    read_names = {
        attribute or text for attribute, text in re.findall(r"\.(\w+)|[\"'](\w+)[\"']", all_source)
    }
    unread_keys = {
        key for key in key_path_by_property(Config) if key.rpartition(".")[2] not in read_names
    }
    assert unread_keys == BY_NAME


@pytest.mark.parametrize("name", ["2026.03", "1e5", "no", "0123", "1_000", "nan", "2026-31-12"])
def test_a_name_that_the_command_line_would_change_is_refused_everywhere(name: str) -> None:
    with pytest.raises(OilfilmError, match=f"'{name}' cannot be a name, because"):
        safe_name(name, "campaign")
    with pytest.raises(OilfilmError, match=f"'{name}' cannot be a name, because"):
        resolve(ROOT / "config", {"campaign": name})


@pytest.mark.parametrize("name", ["4102", "june", "2026-03", "2026-03-01", "v1.2", "no1", "-a"])
def test_a_name_that_stays_as_it_is_typed_is_allowed(name: str) -> None:
    assert safe_name(name, "campaign") == name
