"""What a change of the code makes again: the rules whose digest changes, and no others.

The digests are computed as the Snakefile does, with one module changed in memory. What follows from
them is Snakemake's own work: two dry runs in tests/workflow/test_workflow.py show it.
"""

import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from campaigns import ROOT
from oilfilm import digests

LIBRARY = ROOT / "workflow/oilfilm"
# Prints, of each rule of the demonstration, what its digest covers: the script, then modules.
DECLARED = """
import json, sys
from types import SimpleNamespace
from pathlib import Path
from snakemake.api import ConfigSettings, OutputSettings, ResourceSettings, SnakemakeApi
from oilfilm import digests
digests.code_digest = lambda *paths: json.dumps([str(Path(path).resolve()) for path in paths])
from oilfilm.traction import LAW_FILES
with SnakemakeApi(OutputSettings(quiet={"all"})) as api:
    workflow = api.workflow(
        resource_settings=ResourceSettings(cores=1),
        config_settings=ConfigSettings(config={"campaign": "demo"}),
        snakefile=Path("Snakefile"),
    )._workflow
    declared = {}
    for rule in workflow.rules:
        code = getattr(rule.params, "code", None)
        of_laws = "law_file" in rule.wildcard_names
        for law in dict.fromkeys(path.stem for path in LAW_FILES.values()) if of_laws else [""]:
            wildcards = SimpleNamespace(oil="4102", law_file=law, shard="0")
            given = code(wildcards) if callable(code) else code
            if given:
                declared[f"{rule.name} {law}".strip()] = json.loads(given.rpartition("-")[0])
    (release,) = (rule for rule in workflow.rules if rule.name == "release")
    released = list(map(str, release.input))
print("PARSED" + json.dumps({"digests": declared, "released": released}))
"""


@pytest.fixture(scope="module")
def parsed() -> dict[str, Any]:
    """What the Snakefile declares for the demonstration."""
    done = subprocess.run(
        [sys.executable, "-c", DECLARED], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    return dict(json.loads(done.stdout.partition("PARSED")[2]))


@pytest.fixture(scope="module")
def declared(parsed: dict[str, Any]) -> dict[str, list[Path]]:
    """What the digest of each rule covers; that of fits has an entry per file of laws."""
    return {rule: [Path(path) for path in paths] for rule, paths in parsed["digests"].items()}


@pytest.fixture
def due(
    declared: dict[str, list[Path]], monkeypatch: pytest.MonkeyPatch
) -> Callable[[Path, str, str], set[str]]:
    """Gives the rules whose digest changes when one text of a module is replaced."""

    def rules_due(module: Path, old: str, new: str) -> set[str]:
        before = {rule: digests.code_digest(*paths) for rule, paths in declared.items()}
        text = module.read_text(encoding="utf-8")
        assert old in text, f"{module} has no {old!r} any more"
        changed = text.replace(old, new, 1).encode()
        read, computed = Path.read_bytes, digests._code
        with monkeypatch.context() as patch:
            patch.setattr(
                Path, "read_bytes", lambda path: changed if path == module else read(path)
            )
            anew = computed.__wrapped__(module)
            patch.setattr(digests, "_code", lambda path: anew if path == module else computed(path))
            return {
                rule
                for rule, paths in declared.items()
                if digests.code_digest(*paths) != before[rule]
            }

    return rules_due


@pytest.mark.parametrize(
    ("module", "old", "new"),
    [
        pytest.param("units.py", "\nfrom ", "\n# a remark\nfrom ", id="comment"),
        pytest.param("units.py", '"""', '"""Other words. ', id="docstring"),
        pytest.param("physics/film.py", '    """', '    """Other words. ', id="inner docstring"),
        pytest.param("physics/film.py", "\n\n\n", "\n\n\n\n", id="layout"),
        pytest.param(
            "fits/fitted.py", "raise OilfilmError(", "raise OilfilmError('!' + ", id="error"
        ),
        pytest.param("settings/campaign.py", "What it is.", "The title.", id="settings"),
        pytest.param("run/job.py", '"done\\n"', '"ended\\n"', id="the run around a job"),
        pytest.param("cli/check.py", "import", "import os\nimport", id="a command"),
        pytest.param(
            "traction/laws/__init__.py",
            "import TANH as TANH",
            "import TANH as TANH\nfrom oilfilm.traction.laws.tanh import TANH as OTHER",
            id="a law that no campaign has",
        ),
    ],
)
def test_change_of_words_makes_nothing_again(
    due: Callable[[Path, str, str], set[str]], module: str, old: str, new: str
) -> None:
    assert due(LIBRARY / module, old, new) == set()


def test_release_takes_results_and_simulated_logs_alone(parsed: dict[str, Any]) -> None:
    folders = {Path(path).parts[:2] for path in parsed["released"]}
    assert folders == {("results", "demo"), ("data", "raw")}


def test_law_refits_itself_and_is_shown_in_the_report(
    due: Callable[[Path, str, str], set[str]],
) -> None:
    assert due(LIBRARY / "traction/laws/tanh.py", "A*tanh(B*S/A)", "A*tanh(B*S)") == {
        *("fit tanh", "report")
    }


def test_figure_is_drawn_again_with_its_family(due: Callable[[Path, str, str], set[str]]) -> None:
    changed = due(
        LIBRARY / "report/figures/bearing.py", "_SLIP_LEVELS = (-1.0,", "_SLIP_LEVELS = (-0.9,"
    )
    assert changed == {"bearing_figures"}


def test_meaning_of_a_column_is_described_again(due: Callable[[Path, str, str], set[str]]) -> None:
    changed = due(LIBRARY / "tables/rig.yaml", "time on the log's clock", "time of the log")
    assert changed == {"report"}


def test_version_of_the_tables_makes_everything_again(
    due: Callable[[Path, str, str], set[str]], declared: dict[str, list[Path]]
) -> None:
    module = LIBRARY / "tables/schema_version.py"
    assert due(module, "SCHEMA_VERSION = ", "SCHEMA_VERSION = 1") == declared.keys()


@pytest.mark.parametrize(
    ("module", "old", "new", "among", "not_among"),
    [
        pytest.param(
            "curation/plateau_gates.py",
            "return",
            "return 0 +",
            {"points", "torque_runs"},
            {"twin", "fit tanh", "torque"},
            id="a gate",
        ),
        pytest.param(
            "logs/pcs.py",
            "return",
            "return 0 +",
            {"points"},
            {"fit tanh", "twin", "torque_twin"},
            id="a format",
        ),
        pytest.param(
            "bearing/solver.py",
            "return",
            "return 0 +",
            {"torque", "bearing_maps"},
            {"points", "fit tanh", "fits"},
            id="the solver of bearings",
        ),
        pytest.param(
            "traction/laws/deng2026.py",
            "return",
            "return 0 +",
            {"twin", "paper", "exports"},
            {"points", "fits", "fit tanh"},
            id="the paper's law",
        ),
    ],
)
def test_changed_computation_makes_again_what_it_computes(
    due: Callable[[Path, str, str], set[str]],
    module: str,
    old: str,
    new: str,
    among: set[str],
    not_among: set[str],
) -> None:
    changed = due(LIBRARY / module, old, new)
    assert among <= changed
    assert not not_among & changed
