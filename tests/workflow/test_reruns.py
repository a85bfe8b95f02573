"""What a change of the code makes again: the rules whose digest changes, and no others.

The digests are computed as the Snakefile does, with one module changed in memory. What follows from
them is Snakemake's own work: two dry runs in tests/workflow/test_workflow.py show it.
"""

import json
import sys
from pathlib import Path

import pytest

from campaigns import ROOT
from command_line import succeeded
from oilfilm import digests

LIBRARY = ROOT / "workflow/oilfilm"
# Prints, of each rule of the demonstration, what its digest covers: the script, then modules.
DECLARED = """
import json
from types import SimpleNamespace
from pathlib import Path
from snakemake.api import ConfigSettings, OutputSettings, ResourceSettings, SnakemakeApi
from oilfilm import digests
digests.code_digest = lambda *paths: json.dumps([str(Path(path).resolve()) for path in paths])
from oilfilm.traction import LAW_NAMES
with SnakemakeApi(OutputSettings(quiet={"all"})) as api:
    workflow = api.workflow(
        resource_settings=ResourceSettings(cores=1),
        config_settings=ConfigSettings(config={"campaign": "demo"}),
        snakefile=Path("Snakefile"),
    )._workflow
    declared = {}
    for rule in workflow.rules:
        code = getattr(rule.params, "code", None)
        of_law = "law" in rule.wildcard_names
        for law in LAW_NAMES if of_law else [""]:
            wildcards = SimpleNamespace(oil="4102", law=law, shard="0", part="0", of="fit")
            given = code(wildcards) if callable(code) else code
            if given:
                declared[f"{rule.name} {law}".strip()] = json.loads(given.rpartition("-")[0])
print("DECLARED" + json.dumps(declared))
"""


@pytest.fixture(scope="module")
def declared() -> dict[str, list[Path]]:
    """What the digest of each rule covers; a rule with a law has an entry per law."""
    text = succeeded([sys.executable, "-c", DECLARED], cwd=ROOT).partition("DECLARED")[2]
    rules, _ = json.JSONDecoder().raw_decode(text)
    return {rule: [Path(path) for path in paths] for rule, paths in rules.items()}


TANH = "import TANH as TANH"
OTHER_LAW = f"{TANH}\nfrom oilfilm.traction.laws.tanh import TANH as OTHER"
# A module, a text of it and what takes its place; what is made again, all of it.
EXACTLY = [
    # words, layout, errors, settings, the run around a job, a command, a law of no campaign
    ("units.py", "\nfrom ", "\n# a remark\nfrom ", set()),
    ("units.py", '"""', '"""Other words. ', set()),
    ("physics/film.py", '    """', '    """Other words. ', set()),
    ("physics/film.py", "\n\n\n", "\n\n\n\n", set()),
    ("fits/fitted.py", "raise OilfilmError(", "raise OilfilmError('!' + ", set()),
    ("settings/campaign.py", "What it is.", "The title.", set()),
    ("run/job.py", '"done\\n"', '"ended\\n"', set()),
    ("cli/check.py", "import", "import os\nimport", set()),
    ("traction/laws/__init__.py", TANH, OTHER_LAW, set()),
    # one law, one family of figures, the meaning of a column
    ("traction/laws/tanh.py", "A*tanh(B*S/A)", "A*tanh(B*S)", {"fit tanh", "report"}),
    ("report/figures/bearing.py", "0.75, 1.0)", "0.8, 1.0)", {"bearing_figures"}),
    ("tables/rig.yaml", "time on the log's clock", "time of the log", {"metadata", "report"}),
]
# The same; some of what is made again, some of what is not.
AMONG = [
    ("curation/plateau_gates.py", {"points", "torque_runs"}, {"twin", "fit tanh", "torque"}),
    ("logs/pcs.py", {"points"}, {"fit tanh", "twin", "torque_twin"}),
    (
        "bearing/solver.py",
        {"torque", "bearing_maps", "heat_balance"},
        {"points", "fit tanh", "fits", "metadata"},
    ),
    ("traction/laws/deng2026.py", {"twin", "paper", "exports"}, {"points", "fits", "fit tanh"}),
]


def due(
    declared: dict[str, list[Path]], monkeypatch: pytest.MonkeyPatch, name: str, old: str, new: str
) -> set[str]:
    """The rules whose digest changes when one text of a module is replaced."""
    module = LIBRARY / name
    before = {rule: digests.code_digest(*paths) for rule, paths in declared.items()}
    text = module.read_text(encoding="utf-8")
    assert old in text, f"{module} has no {old!r} any more"
    changed = text.replace(old, new, 1).encode()
    read, computed = Path.read_bytes, digests._code
    monkeypatch.setattr(Path, "read_bytes", lambda path: changed if path == module else read(path))
    anew = computed.__wrapped__(module)
    monkeypatch.setattr(digests, "_code", lambda path: anew if path == module else computed(path))
    return {rule for rule, paths in declared.items() if digests.code_digest(*paths) != before[rule]}


@pytest.mark.parametrize(("module", "old", "new", "expected"), EXACTLY)
def test_change_makes_again_what_depends_on_it_and_nothing_else(
    declared: dict[str, list[Path]],
    monkeypatch: pytest.MonkeyPatch,
    module: str,
    old: str,
    new: str,
    expected: set[str],
) -> None:
    assert due(declared, monkeypatch, module, old, new) == expected


@pytest.mark.parametrize(("module", "among", "not_among"), AMONG)
def test_changed_computation_makes_again_what_it_computes(
    declared: dict[str, list[Path]],
    monkeypatch: pytest.MonkeyPatch,
    module: str,
    among: set[str],
    not_among: set[str],
) -> None:
    changed = due(declared, monkeypatch, module, "return", "return 0 +")
    assert among <= changed
    assert not not_among & changed


def test_version_of_the_tables_makes_everything_again(
    declared: dict[str, list[Path]], monkeypatch: pytest.MonkeyPatch
) -> None:
    new = ("tables/schema_version.py", "SCHEMA_VERSION = ", "SCHEMA_VERSION = 1")
    assert due(declared, monkeypatch, *new) == declared.keys()
