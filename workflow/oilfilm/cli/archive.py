"""The command `oilfilm archive`: a release in one file."""

import argparse
from pathlib import Path

from oilfilm.releases.archive import make_archive


def run(options: argparse.Namespace) -> int:
    """Write the archive and say how much is in it."""
    count = make_archive(options.release, Path(), options.file, packages=not options.no_packages)
    size = options.file.stat().st_size / 1e6
    print(f"{options.file}: {count} files, {size:.1f} MB")
    return 0
