"""The arguments of every command, declared without importing what runs it.

A command is one function of `COMMANDS`. Its docstring is its help and ends with an example. The
module of its name, or `releases`, runs it: its `run` takes the parsed arguments and gives the exit
code.

Decides: commands, options and their help.
"""

import argparse
import difflib
import sys
from collections.abc import Sequence
from contextlib import suppress
from pathlib import Path

import oilfilm

# Options of `predict`, `compare` and `fit`: the condition of a law, its meaning, an example.
CONDITION_OPTIONS = {
    "--stress": ("max_hertz_pressure_gpa", "maximum Hertz pressure", "1.2GPa"),
    "--load": ("load_n", "normal load", "50N"),
    "--speed": ("entrainment_speed_m_s", "entrainment speed, mean of both surface speeds", "30m/s"),
    "--temperature": ("inlet_temperature_c", "oil temperature at the inlet", "70degC"),
}
DUTY_EXAMPLE = "10000N,12000rpm,100degC"


def init(command: argparse.ArgumentParser) -> None:
    """Make a project folder from your logs.

    The folder gets settings, run sheet and Snakefile. Logs are copied into it. The settings get
    what the logs seem to hold. Fill in the lines marked FILL IN.

    Example: oilfilm init june ~/rig/*.csv
    """
    command.add_argument("folder", type=Path, metavar="DIR", help="a new or empty folder")
    command.add_argument(
        "logs", nargs="*", type=Path, default=[], metavar="LOG", help="logs, folders of logs"
    )
    _add_campaign(command, "name of the campaign (default: that of DIR)")


def run(command: argparse.ArgumentParser) -> None:
    """Make everything in a project folder.

    Snakemake runs the workflow of a project folder or of a clone. The exit code is Snakemake's. It
    is given the arguments behind --.

    Example: oilfilm run june -- --dry-run
    """
    # everything, because argparse alone would take the first argument for snakemake for the folder
    command.add_argument(
        "words",
        nargs=argparse.REMAINDER,
        metavar="[DIR] [-- ARGUMENT...]",
        help="folder (default: this one), then what is for snakemake",
    )


def check(command: argparse.ArgumentParser) -> None:
    """Read logs and apply every gate.

    It shows how each log was understood. Exit code 0: all logs are accepted; 1: a log or a run is
    refused; 2: a mistake in the command or the configuration.

    Example: oilfilm check data/raw/june
    """
    command.add_argument(
        "logs", nargs="+", type=Path, metavar="FILE", help="log to check, or folder of logs"
    )
    _add_campaign(
        command,
        "campaign with the rig, oils and limits (default: that of the logs' folder, else that of "
        "config.yaml)",
    )
    _add_config(command)
    kind = command.add_mutually_exclusive_group()
    for rig in ("traction", "torque"):
        meaning = f"they are logs of a {rig} rig (default: by folder and columns)"
        kind.add_argument(f"--{rig}", dest="kind", action="store_const", const=rig, help=meaning)
    _add_json(command, "one JSON object per log")


def watch(command: argparse.ArgumentParser) -> None:
    """Give every finished log its verdict while a campaign is measured.

    The logs in data/raw/CAMPAIGN and data/raw/CAMPAIGN-torque are judged as `check` does, and every
    new log as soon as it is finished. Stop with Ctrl-C; nothing is lost.

    Example: oilfilm watch --campaign june
    """
    _add_campaign(command, "campaign (default: that of config.yaml)")
    _add_config(command)
    command.add_argument(
        "--settle",
        type=_seconds,
        default=3.0,
        metavar="SECONDS",
        help="a log is finished when it has not changed for so long (default: 3)",
    )


def fit(command: argparse.ArgumentParser) -> None:
    """Fit a traction law to a table of traction coefficients.

    The table (csv, tsv, xlsx, Parquet) has slide-roll ratio, mean speed, load or maximum Hertz
    pressure, temperature and mu. Its columns are found by name and unit.

    Example: oilfilm fit mu.csv --ball-radius 9.525mm --save mu-results
    """
    command.add_argument("table", type=Path, metavar="TABLE", help="one row per settled reading")
    command.add_argument("--ball-radius", metavar="9.525mm", help="load becomes pressure with it")
    command.add_argument(
        "--materials",
        default="steel,steel",
        metavar="BALL,DISC",
        help="steel, silicon-nitride, glass or 206GPa:0.3 each (default: steel,steel)",
    )
    command.add_argument("--law", help="name of the law (default: one of pressure, else of load)")
    command.add_argument("--oil", help="which oil of the table, or its name")
    for option, (_, meaning, example) in CONDITION_OPTIONS.items():
        about = f"{meaning}, where all rows have the same, as {example}"
        command.add_argument(option, metavar=example, help=about)
    command.add_argument("--plot", type=Path, metavar="FILE", help="draw points and law: png, svg")
    command.add_argument(
        "--save", type=Path, metavar="DIR", help="write tables, exports and report to a new folder"
    )


def predict(command: argparse.ArgumentParser) -> None:
    """Traction coefficient of a fitted oil.

    Example: oilfilm predict --results results/june --oil NAME --stress 1.2GPa
    --speed 30m/s --temperature 70degC --slip 0.05
    """
    command.add_argument("--oil", required=True, help="name of the oil")
    command.add_argument(
        "--printed", action="store_true", help="take the constants that the paper prints"
    )
    for option, (_, meaning, example) in CONDITION_OPTIONS.items():
        command.add_argument(option, metavar=example, help=f"{meaning}, as {example}")
    command.add_argument(
        "--slip",
        required=True,
        help="slide-roll ratio, as 0.05 or 5%%; a negative one as --slip=-5%%",
    )
    _add_results(command)
    _add_json(command, "one JSON object")


def compare(command: argparse.ArgumentParser) -> None:
    """Set fitted oils or campaigns side by side.

    It shows mu of each at the same condition, the ratio to the first one with its interval, and
    the constants.

    Example: oilfilm compare results/june results/july --temperature 70degC
    """
    command.add_argument(
        "folders", nargs="+", type=Path, metavar="DIR", help="results of a campaign: results/june"
    )
    command.add_argument("--oil", action="append", help="only this oil; may be repeated")
    for option, (_, meaning, example) in CONDITION_OPTIONS.items():
        about = f"{meaning}, as {example} (default: the middle of what all tested)"
        command.add_argument(option, metavar=example, help=about)
    command.add_argument("--slip", action="append", help="slide-roll ratio; may be repeated")
    command.add_argument("--plot", type=Path, metavar="FILE", help="draw mu and ratios: png, svg")
    _add_json(command, "one JSON object")


def plan(command: argparse.ArgumentParser) -> None:
    """Rig conditions to test next.

    They are those whose measurement most reduces the uncertainty of a bearing's friction torque or
    cage slip, or of mu where there is no bearing.

    Example: oilfilm plan --results results/june --for traction --count 3
    """
    _add_results(command)
    _add_config(command)
    command.add_argument("--oil", help="oil to plan for (default: every oil of the campaign)")
    command.add_argument("--count", type=int, help="number of tests (default: plan.tests)")
    command.add_argument("--bearing", help="file of config/bearings (default: the campaign's)")
    command.add_argument(
        "--duty",
        action="append",
        metavar=DUTY_EXAMPLE,
        help="operating point of the bearing: axial load, speed, oil temperature; may be repeated "
        "(default: plan.duty_points, else those of the campaign)",
    )
    command.add_argument(
        "--for",
        dest="target",
        choices=("torque", "cage-slip", "traction"),
        help="what shall become more certain (default: torque, or traction without a bearing)",
    )
    _add_json(command, "one JSON object per oil")


def verify(command: argparse.ArgumentParser) -> None:
    """Check that no file of a release has changed.

    Example: oilfilm verify results/releases/june/latest
    """
    _add_release(command)
    command.add_argument(
        "--rebuild", action="store_true", help="run the workflow on the raw logs again and compare"
    )
    command.add_argument("--cores", default="all", help="cores for --rebuild (default: all)")
    _add_json(command, "one JSON object")


def fetch(command: argparse.ArgumentParser) -> None:
    """Copy a release from object storage and check it.

    The folder appears when every file of the release is there and as released. The key is read from
    AWS_ACCESS_KEY_ID and AWS_SECRET_ACCESS_KEY, the server's address from AWS_ENDPOINT_URL_S3.

    Example: oilfilm fetch s3://lab/june/v1-0 june-v1-0
    """
    command.add_argument("address", metavar="ADDRESS", help="its place, as s3://lab/june/v1-0")
    command.add_argument("folder", type=Path, metavar="FOLDER", help="a new folder")


def diff(command: argparse.ArgumentParser) -> None:
    """Show the differences between two releases.

    Example: oilfilm diff data/reference/pins/june results/releases/june/latest
    """
    _add_release(command, "before", "A")
    _add_release(command, "after", "B")
    command.add_argument(
        "--gate",
        action="store_true",
        help="show only changes beyond the limits of `drift` in config.yaml; exit with 1 if any",
    )
    _add_config(command)
    _add_json(command, "one JSON object")


def pin(command: argparse.ArgumentParser) -> None:
    """Keep a release as the reference for later ones.

    Example: oilfilm pin results/releases/june/latest
    """
    _add_release(command)


def export(command: argparse.ArgumentParser) -> None:
    """Write the paper's constants for Python, spreadsheets and bearing codes.

    The formats are Python, workbook, C, Fortran, Modelica, MATLAB, ADORE constants, JSON and CSV.
    Fits of a campaign are in results/*/exports.

    Example: oilfilm export --printed --oil 4102
    """
    command.add_argument(
        "--printed", action="store_true", required=True, help="the constants of the paper"
    )
    command.add_argument("--oil", help="4102, 4050 or 4010 (default: all three)")
    command.add_argument(
        "folder",
        nargs="?",
        type=Path,
        default=Path("printed-constants"),
        metavar="FOLDER",
        help="where to write them (default: printed-constants)",
    )


COMMANDS = (init, run, check, fit, watch, predict, compare, plan, verify, fetch, diff, pin, export)
_OF_RELEASES = (verify, fetch, diff, pin)


def parser() -> argparse.ArgumentParser:
    """The parser of the command line; `command` of what it parsed names the module that runs it."""
    top = _Top(
        prog="oilfilm",
        description="Check traction-rig logs, predict traction from fitted laws, plan tests, and "
        "verify and compare releases. The workflow is run by `oilfilm run` or snakemake.",
        epilog="Exit codes: 0 success; 1 a log is refused, a file is not as released or a change "
        "is beyond the limits; 2 a mistake in the command, the configuration or a file; 130 "
        "interrupted.",
    )
    version = f"oilfilm {oilfilm.__version__}"
    top.add_argument("--version", action="version", version=version, help="print it and stop")
    commands = top.add_subparsers(
        dest="command", required=True, metavar="COMMAND", title="commands", parser_class=_AnyOrder
    )
    for declare in COMMANDS:
        text, _, example = " ".join((declare.__doc__ or "").split()).partition(" Example: ")
        purpose = text.partition(".")[0]
        help_of_list = purpose[:1].lower() + purpose[1:]
        epilog = f"Example: {example}"
        command = commands.add_parser(
            declare.__name__, help=help_of_list, description=text, epilog=epilog
        )
        declare(command)
        module = "releases" if declare in _OF_RELEASES else declare.__name__
        command.set_defaults(module=module)
    return top


class _Top(argparse.ArgumentParser):
    """Answers a first word that is no command with the command that was probably meant."""

    def parse_args(  # type: ignore[override]
        self, args: Sequence[str] | None = None, namespace: argparse.Namespace | None = None
    ) -> argparse.Namespace:
        words = sys.argv[1:] if args is None else list(args)
        names = [declare.__name__ for declare in COMMANDS]
        if words and words[0] not in names and not words[0].startswith("-"):
            self.error(_no_command(words[0], names))
        return super().parse_args(words, namespace)


def _no_command(word: str, names: Sequence[str]) -> str:
    # a path can have thousands of letters
    shown = word if len(word) <= 80 else f"{word[:77]}..."
    with suppress(OSError, ValueError):
        if Path(word).exists():
            return (
                f"{shown!r} is no command. Write `oilfilm check` before logs, `oilfilm fit` before "
                "a table of traction coefficients."
            )
    near = difflib.get_close_matches(word[:80], names, n=1)
    hint = f"Did you mean {near[0]!r}?" if near else f"Expected one of {', '.join(names)}."
    return f"{shown!r} is no command. {hint}"


class _AnyOrder(argparse.ArgumentParser):
    """Takes options before, between and after files: `init DIR --campaign june LOG`."""

    _ordering = False

    def parse_known_args(  # type: ignore[override]
        self, args: Sequence[str] | None = None, namespace: argparse.Namespace | None = None
    ) -> tuple[argparse.Namespace, list[str]]:
        # what finds the order calls this method for options and files in turn
        takes_the_rest = any(action.nargs == argparse.REMAINDER for action in self._actions)
        if self._ordering or takes_the_rest:
            return super().parse_known_args(args, namespace)
        self._ordering = True
        try:
            return self.parse_known_intermixed_args(args, namespace)
        finally:
            self._ordering = False


def _add_release(
    command: argparse.ArgumentParser, name: str = "release", metavar: str = "RELEASE"
) -> None:
    command.add_argument(name, type=Path, metavar=metavar, help="folder of a release or a pin")


def _add_config(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "--config",
        type=Path,
        help="configuration folder (default: config; where there is none, what comes with oilfilm)",
    )


def _add_json(command: argparse.ArgumentParser, what: str) -> None:
    command.add_argument("--json", action="store_true", help=f"print {what}")


def _add_campaign(command: argparse.ArgumentParser, meaning: str) -> None:
    command.add_argument("--campaign", help=meaning)


def _add_results(command: argparse.ArgumentParser) -> None:
    command.add_argument(
        "--results",
        type=Path,
        default=Path("results"),
        help="folder of a campaign's results, as results/demo, or folder of all campaigns "
        "(default: results)",
    )
    _add_campaign(command, "campaign in the folder of all (default: that of config.yaml)")


def _seconds(text: str) -> float:
    with suppress(ValueError):
        if 0 < float(text) < 1e5:
            return float(text)
    raise argparse.ArgumentTypeError(f"found {text!r}; expected seconds above 0, as 3")
