"""What a change makes due: `snakemake -n` on copies of a finished campaign, each with one change.

The changes that docs/how-to/extend.md describes are those of its lists.
"""

import os
import shutil
import sys
from collections.abc import Callable, Mapping
from fnmatch import fnmatch
from pathlib import Path
from typing import Any

import pandas as pd
import pytest

from campaigns import ROOT, lay_out, lay_out_small
from command_line import succeeded
from extensions import EXTENSIONS, SCHEMAS, Edit, apply, listed
from nights import quick_ones
from reference_pages import GENERATED
from reproduce import announced_jobs, changed_files, stamps, succeed

pytestmark = pytest.mark.workflow

LIBRARY, CAMPAIGN = "workflow/oilfilm", "config/campaigns/small.yaml"
# Jobs of the campaign by their rule: two shares of the logs, one oil, two laws, two figures.
SHOWN = {"report": 1, "enough": 1}
AFTER_FITS = {"exports": 1, "data_figures": 1, "law_figures": 1, **SHOWN}
FIT_ONE_LAW = {"fit": 1, "surface": 1, "fits": 1, **AFTER_FITS}
FITS = {**FIT_ONE_LAW, "fit": 2}
POINTS = {"points": 2, "collect": 1, "refused": 1, "run_plan": 1, **FITS}
EVERYTHING = {"twin": 1, **POINTS}
COMPARED = Edit(CAMPAIGN, "    - tanh\n", "    - tanh\n    - hyperbola\n")
OTHER_OIL = {"points": 4, "fit": 4, "surface": 2}  # twice as many logs and fits

CHANGES: dict[str, tuple[tuple[Edit, ...], Mapping[str, int]]] = {
    "law": ((*EXTENSIONS["A law"], COMPARED), FIT_ONE_LAW),
    "log format": (EXTENSIONS["A log format"], POINTS),
    "gate with a limit": (EXTENSIONS["A gate"], POINTS),
    "figure": (EXTENSIONS["A figure"], {"data_figures": 1, **SHOWN}),
    # the search of a surface compares the laws as the verdicts do
    "column": (EXTENSIONS["A column"], {"surface": 1, "fits": 1, **AFTER_FITS}),
    "command": (EXTENSIONS["A command"], {}),
    "oil": (EXTENSIONS["An oil"], {**EVERYTHING, **OTHER_OIL}),
    "default setting": (
        (Edit("config/config.yaml", "load_tolerance: 0.03", "load_tolerance: 0.04"),),
        POINTS,
    ),
    # what judges fits makes none
    "limit of a change": (
        (Edit("config/config.yaml", "alarm: 12.0 ", "alarm: 13.0 "),),
        {"fits": 1, **AFTER_FITS},
    ),
    "bootstrap": ((Edit(CAMPAIGN, "bootstrap: 20", "bootstrap: 21"),), FITS),
    # the plan of the twin's logs has their film
    "constant of the film formula": (
        (Edit(f"{LIBRARY}/physics/film.py", "(2.69, 0.67,", "(2.69, 0.68,"),),
        EVERYTHING,
    ),
    "formula of one law": (
        (Edit(f"{LIBRARY}/traction/laws/tanh.py", "A*tanh(B*S/A)", "A*tanh(B*S)"),),
        FIT_ONE_LAW,
    ),
    "sentence of the report": (
        (
            Edit(
                f"{LIBRARY}/report/sections/laws.jinja",
                "- {{ oils }}: not compared, because",
                "- {{ oils }}: there is no comparison, because",
            ),
        ),
        SHOWN,
    ),
    "meaning of a column": (
        (Edit(f"{LIBRARY}/tables/rig.yaml", "time on the log's clock", "time of the log"),),
        SHOWN,
    ),
}
# The other changes are for `make nightly`: each dry run takes three seconds.
QUICK_CHANGES = ["law"]
# Words of the library that compute nothing.
WORDS = (
    Edit(f"{LIBRARY}/base/units.py", '"""', '"""Other words. '),
    Edit(f"{LIBRARY}/physics/film.py", '    """', '    """Other words. '),
    Edit(f"{LIBRARY}/physics/film.py", "\n\n\n", "\n\n\n\n"),
    Edit(f"{LIBRARY}/fits/fitted.py", "raise OilfilmError(", "raise OilfilmError('!' + "),
    Edit(f"{LIBRARY}/settings/campaign.py", "What it is.", "The title."),
    Edit(f"{LIBRARY}/run/job.py", '"done\\n"', '"ended\\n"'),
    Edit(f"{LIBRARY}/api/log_check.py", "import", "import os\nimport"),
)


def sources(project: Path) -> list[Path]:
    """The files of a clone in a project, without what a run has made."""
    made = {"results", ".snakemake", "data/raw"}
    files = (path for path in project.rglob("*") if path.is_file())
    return [
        path
        for path in files
        if not any(path.is_relative_to(project / folder) for folder in made)
        if "__pycache__" not in path.parts
    ]


# Files in which a line that begins with # is a comment.
COMMENTED = {".py", ".smk", ".yaml", ".mplstyle"}


def comment_everywhere(project: Path) -> None:
    """A comment in front of every file of code, rules and settings, and other words in modules."""
    apply(WORDS, project)
    for folder in ("workflow", "config", "profiles"):
        for path in (project / folder).rglob("*"):
            if path.suffix in COMMENTED or path.name == "Snakefile":
                path.write_bytes(b"# a word\n" + path.read_bytes())


def write_again(project: Path) -> None:
    """Every file of the clone with the same bytes and a new date, as by `git checkout`."""
    for path in sources(project):
        path.write_bytes(path.read_bytes())


def fresh_clone(project: Path) -> None:
    """The finished results beside a clone whose files are all newer than the results."""
    finished = project.with_name("finished")
    project.rename(finished)
    lay_out(project)
    shutil.copy(finished / CAMPAIGN, project / CAMPAIGN)
    write_again(project)
    for name in ("results", "data/raw", ".snakemake"):
        shutil.copytree(finished / name, project / name, symlinks=True)


QUICK_NOTHING_DUE = ["a comment in every file"]
NOTHING_DUE: dict[str, Callable[[Path], None]] = {
    "a comment in every file": comment_everywhere,
    "files with new dates": write_again,
    "a copy of results beside a fresh clone": fresh_clone,
}


@pytest.fixture
def project(released_project: Path, tmp_path: Path) -> Path:
    """A copy of a finished campaign."""
    return shutil.copytree(released_project, tmp_path / "project", symlinks=True)


def jobs_due(project: Path) -> dict[str, int]:
    """How many jobs of each rule are due, without the target `all`."""
    output = succeed(project, "-n", "--config", "campaign=small")
    due = announced_jobs(output)
    assert due or "Nothing to be done" in output, output
    due.pop("all", None)
    return due


@pytest.mark.slow
@pytest.mark.parametrize("name", quick_ones(CHANGES, QUICK_CHANGES))
def test_change_makes_due_what_it_affects_and_nothing_else(project: Path, name: str) -> None:
    edits, expected = CHANGES[name]
    apply(edits, project)
    assert jobs_due(project) == expected


@pytest.mark.slow
@pytest.mark.parametrize("name", quick_ones(NOTHING_DUE, QUICK_NOTHING_DUE))
def test_words_and_dates_make_nothing_due_and_a_dry_run_changes_no_file(
    project: Path, name: str
) -> None:
    NOTHING_DUE[name](project)
    before = stamps(project)
    assert jobs_due(project) == {}
    assert not changed_files(before, stamps(project))


@pytest.mark.parametrize("section", EXTENSIONS)
def test_guide_lists_the_places_that_an_extension_changes(section: str) -> None:
    places = [place.replace("NAME", "*") for place in listed(section) if place != SCHEMAS]
    changed = {edit.path for edit in EXTENSIONS[section]}
    assert {path for path in changed if not any(fnmatch(path, place) for place in places)} == set()
    assert [place for place in places if not any(fnmatch(path, place) for path in changed)] == []


@pytest.mark.nightly
def test_new_column_is_in_the_tables_of_the_next_run(
    released_project: Path, tmp_path: Path
) -> None:
    project = tmp_path / "project"
    shutil.copytree(released_project, project, symlinks=True)
    apply(EXTENSIONS["A column"], project)
    succeed(project, "--config", "campaign=small")
    tables = project / "results/small/tables"
    misfit, quality = (
        pd.read_parquet(tables / f"{name}.parquet").set_index(["oil", "law"])
        for name in ("lack_of_fit", "fit_quality")
    )
    # the residuals are those of the fitted points
    assert misfit["n_judged"].to_dict() == quality.loc[misfit.index, "n_points"].to_dict()


BIN = Path(sys.executable).parent
# Tests that fail where a place of the guide is forgotten.
TESTS_OF_EXTENSIONS = (
    *("tests/curation/test_damages.py", "tests/logs/test_readers_formats.py", "tests/settings"),
    *("tests/report/test_figure_catalogue.py", "tests/repository/test_docs.py", "tests/tables"),
    *("tests/test_command_line.py", "tests/traction"),
)


@pytest.mark.nightly
def test_who_follows_the_guide_has_green_checks_and_a_campaign_that_runs(tmp_path: Path) -> None:
    project = tmp_path / "clone"
    lay_out_small(project)
    tracked = succeeded(["git", "ls-files", "--cached", "--others", "--exclude-standard"], cwd=ROOT)
    for name in tracked.splitlines():
        if (ROOT / name).is_file():
            (project / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(ROOT / name, project / name)
    for section, edits in EXTENSIONS.items():
        before = generated(project)
        apply(edits, project)
        succeeded([sys.executable, "docs/_ext/generate.py"], **within(project))
        shown = generated(project) != before
        assert shown == (SCHEMAS in listed(section)), section
    COMPARED.apply(project)
    for check in ("ruff format .", "ruff check .", "mypy -n 0", "lint-imports --no-logo"):
        tool, *arguments = check.split()
        succeeded([BIN / tool, *arguments], **within(project))
    pytest_alone = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider"]
    succeeded([*pytest_alone, *TESTS_OF_EXTENSIONS], **within(project))
    Edit(CAMPAIGN, "- '4199'\n", "").apply(project)  # no constants are printed to simulate it
    succeed(project, "--config", "campaign=small")
    fitted = pd.read_parquet(project / "results/small/tables/coefficients.parquet")
    assert "hyperbola" in set(fitted["law"])
    assert (project / "results/small/figures/tested-slips.png").is_file()


def generated(project: Path) -> dict[str, bytes]:
    """The generated pages and schemas of a project."""
    return {path: (project / path).read_bytes() for path in GENERATED}


def within(project: Path) -> dict[str, Any]:
    """Where a program runs that uses a project and its library."""
    path = os.pathsep.join([str(project / "workflow"), str(project / "docs/_ext")])
    return {"cwd": project, "env": {**os.environ, "PYTHONPATH": path}}
