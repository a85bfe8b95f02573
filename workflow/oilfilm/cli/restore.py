"""The command `oilfilm restore`: a release out of its archive."""

import argparse

from oilfilm.releases.archive import restore_archive


def run(options: argparse.Namespace) -> int:
    """Unpack the archive; every file is checked before the folder appears."""
    release = restore_archive(options.file, options.folder)
    print(f"{release}: all files are as archived and as released")
    return 0
