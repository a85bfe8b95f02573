"""The command `oilfilm pin`: keep a release as the reference for later ones."""

import argparse
from pathlib import Path

from oilfilm.releases.copies import pin


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    print(f"{pin(options.release, Path())}: pinned; commit it")
    return 0
