"""The command `oilfilm`: check logs, predict traction, plan tests, verify and compare releases.

Everything else is a target of snakemake.

Decides: exit codes, and what becomes of an error.
"""

import io
import os
import sys
from collections.abc import Sequence
from importlib import import_module

from oilfilm.cli.parser import check_command, parser
from oilfilm.errors import OilfilmError


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command.

    Returns:
        The exit code: 0 for success, 1 for a refused log or a difference, 2 for a mistake, 130 if
        interrupted.
    """
    if isinstance(sys.stdout, io.TextIOWrapper):
        # a terminal that cannot show a letter of a log gets its number
        sys.stdout.reconfigure(errors="backslashreplace")
    try:
        try:
            words = sys.argv[1:] if arguments is None else arguments
            check_command(words)
            options = parser().parse_args(words)
            # each command imports what it needs when it runs: the help waits for nothing
            return int(import_module(f"oilfilm.cli.{options.module}").run(options))
        finally:
            sys.stdout.flush()
    except OilfilmError as mistake:
        print(mistake, file=sys.stderr)
        return 2
    except ModuleNotFoundError as lacking:
        if (lacking.name or "oilfilm").partition(".")[0] == "oilfilm":
            raise
        print(
            f"The package {lacking.name} is not installed. This needs more than the core of "
            "oilfilm: pip install 'oilfilm[workflow]'",
            file=sys.stderr,
        )
        return 2
    except BrokenPipeError:
        # whoever read the output has enough of it; nothing more must be written at the end
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 2
    except OSError as error:
        print(OilfilmError(f"{error.filename or 'the output'}: {error.strerror}."), file=sys.stderr)
        return 2
    except KeyboardInterrupt:
        return 130
