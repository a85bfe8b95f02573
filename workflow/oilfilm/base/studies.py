"""Packages beside oilfilm: studies of one question, and what simulates logs.

oilfilm names none of them and works without them. A campaign asks for one by its name
(`studies: [NAME]`). Such a package has a file `oilfilm_study.yaml`. It lists the tables of the
package, and the reference files that its part of the report and of the exports needs: the Snakefile
must know these before it imports anything. A package may also have:

- `study` with `STUDY`: sections of the report, exports;
- `printed`, function of an oil: its law with published constants, for `predict --printed`,
  which must not wait for the imports of `study`;
- `config.yaml` with settings of its own, and `settings` with their model `StudySettings` and with
  `contradictions` between them and a campaign;
- `campaigns`, files of campaigns;
- `shown_tables.yaml`, the tables that its part of the report shows;
- `tables`: declares the package's tables when it is imported;
- `plan`: names of the logs that it simulates, beside the rules in `rules/logs.smk`;
- `rules/study.smk`, and folders `scripts`, `figures` and `reference`.

Decides: what a package beside oilfilm may add to a campaign.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any, Literal

# The folder of oilfilm and of the packages beside it.
PACKAGES = Path(__file__).parents[2]
_DECLARATION = "oilfilm_study.yaml"
_RULES_OF_LOGS = "rules/logs.smk"


@dataclass(frozen=True)
class Study:
    """What a study adds to a campaign beside its tables, figures and rules.

    Attributes:
        sections: Function of the finished tables and the settings. It gives sections of the report
            (`oilfilm.report.document.Section`), which come after those of every campaign.
        exports: Function of the oils by their identifiers, settings and provenance. It gives more
            files for bearing codes; `oilfilm.exports.campaign.export_campaign` calls it.
        exported: Sentence about such files for the index of the exports.
        read_reference: Function that reads one of its reference files, for its figures.
        describe_published: Function that gives such laws as
            `oilfilm.exports.description.Description`, for the command `export`, and the file that
            has their constants.
    """

    sections: Callable[..., list[Any]]
    exports: Callable[..., dict[str, bytes]]
    exported: str
    read_reference: Callable[[Path], Any]
    describe_published: Callable[[], tuple[list[Any], Path]]


@cache
def available() -> tuple[str, ...]:
    """Names of all packages beside oilfilm that a campaign may ask for."""
    return tuple(sorted(path.parent.name for path in PACKAGES.glob(f"*/{_DECLARATION}")))


def folder(name: str) -> Path:
    """The folder of a package."""
    return PACKAGES / name


@cache
def _declaration(name: str) -> dict[str, Any]:
    # imported late, so that `oilfilm --help` is fast
    import yaml  # noqa: PLC0415

    text = (folder(name) / _DECLARATION).read_text(encoding="utf-8")
    declared: dict[str, Any] = yaml.safe_load(text)
    return declared


def table_names_by_need(name: str) -> Mapping[tuple[str, ...], tuple[str, ...]]:
    """Tables of a package, by the keys that a campaign must have for them, as `torque`, `twin`."""
    entries = _declaration(name)["tables"]
    return {tuple(entry["needs"]): tuple(entry["names"]) for entry in entries}


def declare_tables(names: Iterable[str]) -> None:
    """Make the tables of some packages known to `oilfilm.tables`; an empty name is no package."""
    for name in names:
        if (folder(name) / "tables.py").is_file():
            import_module(f"{name}.tables")


def modules(names: Iterable[str]) -> list[Path]:
    """Files `study.py` of some packages; digests of code need them, as no import leads there."""
    files = (folder(name) / "study.py" for name in names)
    return [file for file in files if file.is_file()]


def rule_files(names: Iterable[str]) -> list[Path]:
    """Files of the rules of some studies."""
    files = (folder(name) / "rules/study.smk" for name in names)
    return [file for file in files if file.is_file()]


def settings_file(name: str) -> Path:
    """The file with the settings of a package; not every package has one."""
    return folder(name) / "config.yaml"


def publication(name: str) -> str:
    """The publication whose figures the figures of a package are made after; empty without one."""
    return str(_declaration(name).get("publication", ""))


def settings_module(name: str) -> ModuleType:
    """The module `settings` of a package that has settings."""
    return import_module(f"{name}.settings")


def shown_tables(names: Iterable[str]) -> list[Path]:
    """Files in which packages declare the tables that the report shows."""
    files = (folder(name) / "shown_tables.yaml" for name in names)
    return [file for file in files if file.is_file()]


def campaign_folders() -> list[Path]:
    """Folders of the campaign files of all packages."""
    return [folder(name) / "campaigns" for name in available()]


def references(names: Iterable[str], purpose: Literal["reported", "exported"]) -> list[str]:
    """Reference files that some studies need for the report or for the exports."""
    return [file for name in names for file in _declaration(name).get(purpose, [])]


def published_law(oil: str) -> Any:
    """The law of an oil with published constants, of the one study that has some."""
    (file,) = modules(available())
    return import_module(file.parent.name).printed(oil)


def load(names: Iterable[str]) -> list[Study]:
    """The studies among some packages."""
    return [import_module(f"{file.parent.name}.study").STUDY for file in modules(names)]


def simulator() -> str:
    """Name of the package that simulates logs; empty where there is none."""
    simulators = [name for name in available() if (folder(name) / _RULES_OF_LOGS).is_file()]
    return simulators[0] if simulators else ""


def plan_of_simulator() -> ModuleType:
    """The module of the simulator that knows the names of the logs of a campaign."""
    return import_module(f"{simulator()}.plan")


def reference_file(name: str) -> Path | None:
    """A file of reference data of a package, given without its ending; None where none has it."""
    files = (folder(study) / f"reference/{name}.yaml" for study in available())
    return next((file for file in files if file.is_file()), None)
