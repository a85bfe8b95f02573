"""The command `oilfilm fetch`: a release from object storage."""

import argparse

from oilfilm.releases.copies import fetch_release


def run(options: argparse.Namespace) -> int:
    """Copy the release; every file is checked before its folder appears."""
    fetch_release(options.address, options.folder)
    print(f"{options.folder}: all files are as released")
    return 0
