"""Packages beside oilfilm: studies of one question, and the simulator of logs.

oilfilm names none of them and works without them. A campaign asks for one by its name
(`studies: [NAME]`). Such a package has a file `oilfilm_study.yaml`. It lists the tables of the
package, and the reference files that its part of the report and of the exports needs: the Snakefile
must know these before it imports anything. A package may also have:

- a module `study` with `STUDY`, an instance of `Study`: sections of the report, exports;
- a function `printed` of the name of an oil: its law with published constants, for
  `predict --printed`, which must not wait for the imports of the module `study`;
- a file `config.yaml` with settings of its own, and a module `settings` with their model
  `StudySettings` and with a function `contradictions` between them and a campaign;
- a folder `campaigns` with files of campaigns;
- a file `shown_tables.yaml`: the tables that its part of the report shows;
- a module `tables`, which declares the package's tables when it is imported;
- a module `plan`: names of the logs that it simulates, beside the rules in `rules/logs.smk`;
- rules in `rules/study.smk`, and folders `scripts`, `figures` and `reference`.

A package that has a module `study` is called a study here.

Decides: what a package beside oilfilm may add to a campaign.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any, Literal

from oilfilm.base.errors import OilfilmError

# The folder of oilfilm and of the packages beside it.
PACKAGES = Path(__file__).parents[2]
_DECLARATION_FILE = "oilfilm_study.yaml"
_LOG_RULES = "rules/logs.smk"


@dataclass(frozen=True)
class Study:
    """What a study adds to a campaign beside its tables, figures and rules.

    Attributes:
        sections: Function of the finished tables and the settings. It gives sections of the report
            (`oilfilm.report.document.Section`), which come after those of every campaign.
        exports: Function of the oils by their identifiers, the settings and the provenance. It
            gives the content of more files for bearing codes by their names;
            `oilfilm.exports.campaign.export_campaign` calls it.
        exports_sentence: Sentence about these files for the index of the exports.
        read_reference: Function that reads one of its reference files, for its figures.
        describe_published: Function that gives, for the command `export`, its laws with published
            constants as `oilfilm.exports.description.Description`, and the file that has the
            constants. None where it has none.
    """

    sections: Callable[..., list[Any]]
    exports: Callable[..., dict[str, bytes]]
    exports_sentence: str
    read_reference: Callable[[Path], Any]
    describe_published: Callable[[], tuple[list[Any], Path]] | None = None


@cache
def available() -> tuple[str, ...]:
    """Names of all packages beside oilfilm that a campaign may ask for."""
    return tuple(sorted(path.parent.name for path in PACKAGES.glob(f"*/{_DECLARATION_FILE}")))


def folder(package_name: str) -> Path:
    """The folder of a package beside oilfilm."""
    return PACKAGES / package_name


@cache
def _package_declaration(package_name: str) -> dict[str, Any]:
    """Content of the file `oilfilm_study.yaml` of a package."""
    # imported late, so that `oilfilm --help` is fast
    import yaml  # noqa: PLC0415

    text = (folder(package_name) / _DECLARATION_FILE).read_text(encoding="utf-8")
    declared: dict[str, Any] = yaml.safe_load(text)
    return declared


def table_names_by_need(package_name: str) -> Mapping[tuple[str, ...], tuple[str, ...]]:
    """Names of the tables of a package, by the keys that a campaign must have for them.

    Such keys are `torque` and `twin`.
    """
    names_by_need: dict[tuple[str, ...], tuple[str, ...]] = {}
    for entry in _package_declaration(package_name)["tables"]:
        need = tuple(entry["needs"])
        names_by_need[need] = (*names_by_need.get(need, ()), *entry["names"])
    return names_by_need


def declare_tables(package_names: Iterable[str]) -> None:
    """Make the tables of some packages known to `oilfilm.tables`.

    An empty name (no simulator) is skipped.
    """
    for package_name in package_names:
        if (folder(package_name) / "tables.py").is_file():
            import_module(f"{package_name}.tables")


def study_files(package_names: Iterable[str]) -> list[Path]:
    """Files `study.py` of those packages that have one.

    Digests of code need them, because no import leads to them.
    """
    files = (folder(package_name) / "study.py" for package_name in package_names)
    return [file for file in files if file.is_file()]


def rule_files(package_names: Iterable[str]) -> list[Path]:
    """Files with the rules of those packages that have some."""
    files = (folder(package_name) / "rules/study.smk" for package_name in package_names)
    return [file for file in files if file.is_file()]


def settings_file(package_name: str) -> Path:
    """The file with the settings of a package; it need not exist."""
    return folder(package_name) / "config.yaml"


def publication(package_name: str) -> str:
    """The publication whose figures the figures of a package are made after; empty without one."""
    return str(_package_declaration(package_name).get("publication", ""))


def settings_module(package_name: str) -> ModuleType:
    """The module `settings` of a package that has settings."""
    return import_module(f"{package_name}.settings")


def shown_table_files(package_names: Iterable[str]) -> list[Path]:
    """Files in which some packages declare the tables that the report shows."""
    files = (folder(package_name) / "shown_tables.yaml" for package_name in package_names)
    return [file for file in files if file.is_file()]


def campaign_folders() -> list[Path]:
    """Folders of the campaign files of all packages."""
    return [folder(package_name) / "campaigns" for package_name in available()]


def reference_names(
    package_names: Iterable[str], purpose: Literal["reported", "exported"]
) -> list[str]:
    """Names of the reference files that some packages need for the report or for the exports."""
    names: list[str] = []
    for package_name in package_names:
        names += _package_declaration(package_name).get(purpose, [])
    return names


def published_law(oil_name: str) -> Any:
    """The law of an oil with published constants, as the first study that has some gives it.

    Raises:
        OilfilmError: The study has no constants of the oil, or no study has any.
    """
    for file in study_files(available()):
        package = import_module(file.parent.name)
        if hasattr(package, "printed"):
            return package.printed(oil_name)
    raise OilfilmError("--printed: no study has published constants. Leave out --printed.")


def load_studies(package_names: Iterable[str]) -> list[Study]:
    """The studies among some packages."""
    return [import_module(f"{file.parent.name}.study").STUDY for file in study_files(package_names)]


def read_references(files: Iterable[Path]) -> dict[str, Any]:
    """Content of the reference files of figures, by their names, as the studies read them.

    A study is imported only where there is such a file. A second study with reference files of its
    own needs a way to tell whose a file is, which is not written: files that several studies share
    lie in no folder of a study.
    """
    content_by_name: dict[str, Any] = {}
    for file in files:
        for study in load_studies(available()):
            content_by_name[file.stem] = study.read_reference(file)
    return content_by_name


def simulator() -> str:
    """Name of the package that simulates logs; empty where there is none."""
    for package_name in available():
        if (folder(package_name) / _LOG_RULES).is_file():
            return package_name
    return ""


def plan_of_simulator() -> ModuleType:
    """The module of the simulator that knows the names of the logs of a campaign."""
    return import_module(f"{simulator()}.plan")


def reference_file(reference_name: str) -> Path | None:
    """The file of reference data with a name, given without its ending, in any of the packages.

    None where no package has it.
    """
    files = (
        folder(package_name) / f"reference/{reference_name}.yaml" for package_name in available()
    )
    return next((file for file in files if file.is_file()), None)
