"""The command `oilfilm check`: the verdict on every log, and what to do."""

import argparse
import sys
import textwrap

import oilfilm
from oilfilm.api.log_check import TEXT_WIDTH
from oilfilm.cli.arguments import json_line


def run(options: argparse.Namespace) -> int:
    """Run the command; exit code 1 where a log is refused."""
    checked = oilfilm.check(*options.logs, campaign=options.campaign, config=options.config)
    print("\n".join(map(json_line, checked.logs)) if options.json else checked.summary())
    for note in checked.notes:
        lines = textwrap.wrap(note, TEXT_WIDTH, break_long_words=False, break_on_hyphens=False)
        print("\n".join(lines), file=sys.stderr)
    return int(not checked.accepted)
