"""The command `oilfilm nightly`: a scheduled run, its summary and who is told."""

import argparse
import os
import sys

from oilfilm.cli.arguments import config_folder
from oilfilm.errors import OilfilmError
from oilfilm.releases.hook import send
from oilfilm.releases.nightly import EXIT_CODES, Night, as_markdown, write_summary
from oilfilm.settings.resolve import resolve


def run(options: argparse.Namespace) -> int:
    """Run the command; exit code 0 where all is well, 1 for drift, 2 for a failure."""
    chosen = {"campaign": options.campaign} if options.campaign else {}
    settings = resolve(config_folder(None), chosen)
    night = Night(
        campaign=settings.campaign.name,
        drift=settings.drift,
        cores=options.cores,
        rebuild=options.rebuild,
        # what the command prints itself may be JSON
        show=lambda line: print(line, file=sys.stderr, flush=True),
    )
    summary = night.run()
    kept = write_summary(summary)
    payload, text = summary.model_dump_json(), as_markdown(summary)
    print(payload if options.json else text, flush=True)
    print(f"{summary.text}; see {kept.with_suffix('.md')}", file=sys.stderr)
    code = summary.exit_code
    for hook in options.hook or filter(None, [os.environ.get("OILFILM_HOOK")]):
        try:
            send(hook, payload, text)
        except OilfilmError as mistake:
            print(mistake, file=sys.stderr)
            code = EXIT_CODES["failure"]
    return code
