"""The arguments of every command, declared without importing the module that runs it.

A command is one function of `COMMANDS`. Its docstring is its help and ends with an example. The
module of its name, or `releases`, runs it. Its function `run` takes the parsed arguments and
returns the exit code.

Decides: commands, options and their help.
"""

import argparse
import difflib
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, NamedTuple

import oilfilm
from oilfilm.base import studies
from oilfilm.base.errors import OilfilmError, cut


class ConditionOption(NamedTuple):
    """An option for a condition of a law: the column of the condition, its meaning, an example."""

    column: str
    meaning: str
    example: str


# Conditions by their option of `predict`, `compare` and `fit`.
CONDITION_OPTIONS = {
    "--stress": ConditionOption("max_hertz_pressure_gpa", "maximum Hertz pressure", "1.2GPa"),
    "--load": ConditionOption("load_n", "normal load", "50N"),
    "--speed": ConditionOption(
        "entrainment_speed_m_s", "entrainment speed, mean of both surface speeds", "30m/s"
    ),
    "--temperature": ConditionOption(
        "inlet_temperature_c", "oil temperature at the inlet", "70degC"
    ),
}
# Some options, and the command `export`, are for published constants, which only a study has.
_HAS_PUBLISHED_LAWS = bool(studies.study_files(studies.available()))
DUTY_EXAMPLE = "10000N,12000rpm,100degC"


class Command(argparse.ArgumentParser):
    """The parser of one command, with methods that add the arguments that commands share."""

    def add_text(self, name: str, meaning: str, **argparse_options: Any) -> None:
        """Add an argument whose value stays text, unless `argparse_options` say otherwise."""
        self.add_argument(name, help=meaning, **argparse_options)

    def add_path(
        self, name: str, metavar: str | None, meaning: str, **argparse_options: Any
    ) -> None:
        """Add the path of a file or folder."""
        self.add_argument(name, type=Path, metavar=metavar, help=meaning, **argparse_options)

    def add_flag(self, name: str, meaning: str, **argparse_options: Any) -> None:
        """Add an option without a value."""
        self.add_argument(name, action="store_true", help=meaning, **argparse_options)

    def add_conditions(self, help_text: str) -> None:
        """Add the conditions of a law.

        Args:
            help_text: Help of each, with the fields `{meaning}` and `{example}`.
        """
        for option, (_, meaning, example) in CONDITION_OPTIONS.items():
            self.add_text(
                option, help_text.format(meaning=meaning, example=example), metavar=example
            )

    def add_config(self) -> None:
        """Add `--config`."""
        default = "config; where there is none, what comes with oilfilm"
        self.add_path("--config", None, f"configuration folder (default: {default})")

    def add_results(self) -> None:
        """Add `--results`."""
        meaning = "folder of a campaign's results (default: that of config.yaml's campaign)"
        self.add_path("--results", "results/june", meaning)

    def add_release(self, name: str = "release", metavar: str = "RELEASE") -> None:
        """Add the folder of a release."""
        self.add_path(name, metavar, "folder of a release or a pin")


def init(command: Command) -> None:
    """Make a project folder from your logs.

    The folder gets settings, run sheet and Snakefile. Logs are copied into it. The settings get
    what the logs seem to hold. In a terminal you are asked for what only you can know, until the
    logs pass the check. Lines that stay open are marked FILL IN.

    Example: oilfilm init june ~/rig/*.csv
    """
    command.add_path("folder", "DIR", "a new or empty folder; its name is that of the campaign")
    command.add_path("logs", "LOG", "logs, folders of logs", nargs="+")
    command.add_flag("--no-questions", "ask nothing; what is not known is marked FILL IN")


def run(command: Command) -> None:
    """Make everything in a project folder.

    Snakemake runs the workflow of a project folder or of a clone. The exit code is Snakemake's.
    Arguments behind -- are passed to Snakemake.

    Example: oilfilm run june -- --dry-run
    """
    # the rest of the line, because argparse would take the first argument of snakemake for a folder
    meaning = "folder (default: this one), then the arguments of snakemake"
    command.add_text("words", meaning, nargs=argparse.REMAINDER, metavar="[DIR] [-- ARGUMENT...]")


def check(command: Command) -> None:
    """Read logs and apply every gate.

    It shows how each log was understood. Exit code 0: all logs are accepted; 1: a log or a run is
    refused; 2: a mistake in the command or the configuration.

    Example: oilfilm check data/raw/june
    """
    command.add_path("logs", "FILE", "log to check, or folder of logs", nargs="+")
    default = "that of the logs' folder, else that of config.yaml"
    command.add_text("--campaign", f"campaign with the rig, oils and limits (default: {default})")
    command.add_config()
    command.add_flag("--json", "print one JSON object per log")


def watch(command: Command) -> None:
    """Give every finished log its verdict while a campaign is measured.

    The logs in data/raw/CAMPAIGN and data/raw/CAMPAIGN-torque are judged as `check` does, and every
    new log as soon as it is finished. Stop with Ctrl-C; nothing is lost.

    Example: oilfilm watch --campaign june
    """
    command.add_text("--campaign", "campaign (default: that of config.yaml)")
    command.add_config()
    meaning = "a log is finished when it has not changed for so long (default: 3)"
    command.add_text("--settle", meaning, type=float, default=3.0, metavar="SECONDS")


def fit(command: Command) -> None:
    """Fit a traction law to a table of traction coefficients.

    The table (csv, tsv, xlsx, ods, Parquet) has slide-roll ratio, mean speed, load or maximum Hertz
    pressure, temperature and mu. Its columns are found by name and unit.

    Example: oilfilm fit mu.csv --ball-radius 9.525mm --save mu-results
    """
    command.add_path("table", "TABLE", "one row per settled reading")
    command.add_text("--ball-radius", "load becomes pressure with it", metavar="9.525mm")
    materials = "steel, silicon-nitride, glass or 206GPa:0.3 each (default: steel,steel)"
    command.add_text("--materials", materials, default="steel,steel", metavar="BALL,DISC")
    meaning = "what columns mean where their names leave it open; several with semicolons between"
    example = "slide_roll_ratio=Schlupf [%%], over_sum"
    command.add_text("--columns", f'{meaning}, as "{example}"', default="")
    command.add_text("--law", "name of the law (default: one of pressure, else of load)")
    command.add_text("--oil", "which oil of the table, or its name")
    command.add_conditions("{meaning}, where all rows have the same, as {example}")
    command.add_flag("--simulated", "a program wrote the table; what is saved says so")
    command.add_path("--plot", "FILE", "draw points and law: png, svg")
    command.add_path("--save", "DIR", "write tables, exports and report to a new folder")


def predict(command: Command) -> None:
    """Traction coefficient of a fitted oil.

    Example: oilfilm predict --results results/june --oil NAME --stress 1.2GPa
    --speed 30m/s --temperature 70degC --slip 0.05
    """
    command.add_text("--oil", "name of the oil", required=True)
    if _HAS_PUBLISHED_LAWS:
        command.add_flag("--printed", "take the published constants that a study has")
    command.set_defaults(printed=False)
    command.add_conditions("{meaning}, as {example}")
    meaning = "slide-roll ratio, as 0.05 or 5%%; a negative one as --slip=-5%%"
    command.add_text("--slip", meaning, required=True)
    command.add_text("--rig", "rig of the next run, where runs are of several; or: another")
    command.add_flag("--json", "print one JSON object")
    command.add_results()


def compare(command: Command) -> None:
    """Set fitted oils or campaigns side by side.

    It shows mu of each at the same condition, the ratio to the first one with its interval and
    whether it is certain, and the constants.

    Example: oilfilm compare results/june results/july --temperature 70degC
    """
    command.add_path("folders", "DIR", "results of a campaign: results/june", nargs="+")
    command.add_text("--oil", "only this oil; may be repeated", action="append")
    command.add_conditions("{meaning}, as {example} (default: the middle of what all tested)")
    command.add_text("--slip", "slide-roll ratio; may be repeated", action="append")
    command.add_path("--plot", "FILE", "draw mu and ratios: png, svg")


def plan(command: Command) -> None:
    """Runs that a campaign lacks, and rig conditions to test next.

    Runs that are lacking: levels of a condition, corners of the box, repeats, with reference runs
    between them, in random order. A campaign without results gets a first plan. Then come the tests
    that most reduce the uncertainty of a bearing's friction torque or cage slip, or of mu where
    there is no bearing.

    Example: oilfilm plan --results results/june --for traction --count 3
    """
    command.add_results()
    command.add_config()
    command.add_text("--campaign", "campaign of config/campaigns that need not have results")
    command.add_text("--oil", "oil to plan for (default: every oil of the campaign)")
    command.add_text(
        "--count", "number of tests for the bearing or mu (default: plan.tests)", type=int
    )
    command.add_text("--bearing", "file of config/bearings (default: the campaign's)")
    meaning = "operating point of the bearing: axial load, speed, oil temperature; may be repeated "
    meaning += "(default: plan.duty_points, else those of the campaign)"
    command.add_text("--duty", meaning, action="append", metavar=DUTY_EXAMPLE)
    meaning = "what is planned for; campaign: the runs that it lacks (default: these, and torque, "
    meaning += "or traction without a bearing)"
    targets = ("campaign", "torque", "cage-slip", "traction")
    command.add_text("--for", meaning, dest="target", choices=targets)


def bearing(command: Command) -> None:
    """Friction torque, power loss, cage slip and best oil of a bearing, each with its interval.

    The traction is that of a campaign's fitted laws. The shares of variance show which unknown
    makes the answer uncertain, and what to measure next.

    Example: oilfilm bearing --bearing mainshaft-167 --oil 4102 --load 10kN --speed 12000rpm
    --temperature 70degC
    """
    command.add_text("--bearing", "file of config/bearings", required=True)
    command.add_text("--oil", "oil of the campaign (default: all of them)")
    several = "; several are combined with each other"
    command.add_text("--load", f"axial load{several}", required=True, nargs="+", metavar="10kN")
    speed = f"speed of the inner ring{several}"
    command.add_text("--speed", speed, required=True, nargs="+", metavar="12000rpm")
    temperature = f"oil temperature at the inlet{several}"
    command.add_text("--temperature", temperature, required=True, nargs="+", metavar="70degC")
    command.add_flag("--json", "print one JSON object per oil and operating point")
    command.add_results()
    command.add_config()


def verify(command: Command) -> None:
    """Check that no file of a release has changed.

    Example: oilfilm verify results/releases/june/latest
    """
    command.add_release()
    command.add_flag("--rebuild", "run the workflow on the raw logs again and compare")
    command.add_text("--cores", "cores for --rebuild (default: all)", default="all")


def fetch(command: Command) -> None:
    """Copy a release from object storage and check it.

    The folder appears when every file of the release is there and as released. The key is read from
    AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY, the server's address from AWS_ENDPOINT_URL_S3.

    Example: oilfilm fetch s3://lab/june/v1-0 june-v1-0
    """
    command.add_text("address", "its place, as s3://lab/june/v1-0", metavar="ADDRESS")
    command.add_path("folder", "FOLDER", "a new folder")


def diff(command: Command) -> None:
    """Show the differences between two releases.

    Example: oilfilm diff data/reference/pins/june results/releases/june/latest
    """
    command.add_release("before", "A")
    command.add_release("after", "B")
    limits = "the limits of `drift` in config.yaml"
    command.add_flag("--gate", f"show only changes beyond {limits}; exit with 1 if any")
    command.add_config()


def pin(command: Command) -> None:
    """Keep a release as the reference for later ones.

    Example: oilfilm pin results/releases/june/latest
    """
    command.add_release()


def export(command: Command) -> None:
    """Write the published constants that a study has for Python, spreadsheets and bearing codes.

    The formats are Python, workbook, C, Fortran, Modelica, MATLAB, ADORE constants, JSON and CSV.
    Fits of a campaign are in results/*/exports.

    Example: oilfilm export --printed --oil 4102
    """
    command.add_flag("--printed", "the published constants that a study has", required=True)
    command.add_text("--oil", "one oil (default: all)")
    default = Path("printed-constants")
    meaning = f"where to write them (default: {default})"
    command.add_path("folder", "FOLDER", meaning, nargs="?", default=default)


_COMMANDS_OF_STUDIES = (export,) if _HAS_PUBLISHED_LAWS else ()
COMMANDS = (
    init,
    run,
    check,
    fit,
    watch,
    predict,
    compare,
    plan,
    bearing,
    verify,
    fetch,
    diff,
    pin,
    *_COMMANDS_OF_STUDIES,
)
_COMMANDS_OF_RELEASES = (verify, fetch, diff, pin)


def parser() -> argparse.ArgumentParser:
    """The parser of the command line; `module` of the parsed options names the running module."""
    top_parser = argparse.ArgumentParser(
        prog="oilfilm",
        description="Check traction-rig logs, predict traction from fitted laws, plan tests, and "
        "verify and compare releases. The workflow is run by `oilfilm run` or snakemake.",
        epilog="Exit codes: 0 success; 1 a log is refused, a file is not as released or a change "
        "is beyond the limits; 2 a mistake in the command, the configuration or a file; 130 "
        "interrupted.",
    )
    version = f"oilfilm {oilfilm.__version__}"
    top_parser.add_argument(
        "--version", action="version", version=version, help="print it and stop"
    )
    commands = top_parser.add_subparsers(
        dest="command", required=True, metavar="COMMAND", title="commands", parser_class=Command
    )
    for declare_command in COMMANDS:
        docstring = " ".join((declare_command.__doc__ or "").split())
        description, _, example = docstring.partition(" Example: ")
        purpose, _, _ = description.partition(".")
        command_name = declare_command.__name__
        command: Command = commands.add_parser(
            command_name,
            help=purpose[:1].lower() + purpose[1:],
            description=description,
            epilog=f"Example: {example}",
        )
        declare_command(command)
        is_about_releases = declare_command in _COMMANDS_OF_RELEASES
        command.set_defaults(module="releases" if is_about_releases else command_name)
    return top_parser


def refuse_unknown_command(words: Sequence[str]) -> None:
    """Refuse a first word that is no command.

    Raises:
        OilfilmError: It is none; the message names the command that was probably meant.
    """
    command_names = [declare_command.__name__ for declare_command in COMMANDS]
    word = words[0] if words else "--help"
    if word in command_names or word.startswith("-"):
        return
    similar_names = difflib.get_close_matches(word[:80], command_names, n=1)
    hint = (
        f"Did you mean {similar_names[0]!r}?"
        if similar_names
        else f"Expected one of {', '.join(command_names)}."
    )
    with suppress(OSError):  # the word is too long for a path
        if Path(word).exists():
            hint = "Write `oilfilm check` before logs, `oilfilm fit` before a table of mu."
    raise OilfilmError(f"{cut(word)!r} is no command. {hint}")
