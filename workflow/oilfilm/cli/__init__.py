"""The command `oilfilm`: reads the command line, runs the named command, reports mistakes.

The commands are declared in `parser`, each with the module here whose function `run` runs it.

Decides: exit codes, and what becomes of an error.
"""

import io
import os
import sys
from collections.abc import Sequence
from importlib import import_module

from oilfilm.base.errors import OilfilmError
from oilfilm.cli.parser import parser, refuse_unknown_command

# Packages of the extra `report`; all others beside the core are of the workflow.
_PACKAGES_OF_REPORT = ("matplotlib", "PIL")


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command.

    Returns:
        The exit code: 0 for success, 1 for a refused log or a difference, 2 for a mistake, 130 if
        interrupted. That of `oilfilm run` is Snakemake's where Snakemake starts.
    """
    if isinstance(sys.stdout, io.TextIOWrapper):
        # a character that the terminal cannot show is printed as its code
        sys.stdout.reconfigure(errors="backslashreplace")
    try:
        return _run(sys.argv[1:] if arguments is None else arguments)
    except OilfilmError as mistake:
        print(mistake, file=sys.stderr)
        return 2
    except ModuleNotFoundError as error:
        missing_package = (error.name or "oilfilm").partition(".")[0]
        if missing_package == "oilfilm":
            raise
        extra = "report" if missing_package in _PACKAGES_OF_REPORT else "workflow"
        print(
            f"The package {error.name} is not installed. This needs more than the core of "
            f"oilfilm. Install it with its {extra}: pip install '.[{extra}]' in the folder of its "
            f"code, or pip install 'WHEEL[{extra}]' with the path of its wheel.",
            file=sys.stderr,
        )
        return 2
    except BrokenPipeError:
        # the reader of the output, such as `head`, has ended. Python flushes the output once more
        # at its exit, which must not fail again
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 2
    except OSError as error:
        print(OilfilmError(f"{error.filename or 'the output'}: {error.strerror}."), file=sys.stderr)
        return 2
    except MemoryError:
        print(
            "The memory does not suffice. Give the program more memory, end other programs, or "
            "name fewer logs.",
            file=sys.stderr,
        )
        return 2
    except KeyboardInterrupt:
        return 130


def _run(arguments: Sequence[str]) -> int:
    """Run the command; its exit code."""
    try:
        refuse_unknown_command(arguments)
        options = parser().parse_args(arguments)
        # imported here, so that the help does not wait for the imports of the commands
        command = import_module(f"oilfilm.cli.{options.module}")
        return int(command.run(options))
    finally:
        # an error of writing is raised here, where `main` reports it, and not at the exit of Python
        sys.stdout.flush()
