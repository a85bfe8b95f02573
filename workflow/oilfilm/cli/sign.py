"""The command `oilfilm sign`: vouch for a release with an SSH key."""

import argparse

from oilfilm.releases.signature import sign


def run(options: argparse.Namespace) -> int:
    """Sign a release and say where the signature is."""
    print(f"{sign(options.release, options.key)}: signed with {options.key}")
    return 0
