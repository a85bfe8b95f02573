"""The command `oilfilm fetch`: a release from object storage."""

import argparse

from oilfilm.releases.transfer import download_release


def run(options: argparse.Namespace) -> int:
    """Copy the release; every file is checked before its folder appears."""
    download_release(options.address, options.folder)
    print(f"{options.folder}: all files are as released")
    return 0
