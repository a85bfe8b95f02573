"""The commands about releases: `oilfilm verify`, `fetch`, `diff` and `pin`."""

import argparse
from pathlib import Path

from oilfilm.cli.arguments import config_folder
from oilfilm.errors import printable
from oilfilm.releases.compare import compare
from oilfilm.releases.release import rebuild
from oilfilm.releases.stored_release import StoredRelease, fetch_release, pin
from oilfilm.settings.resolve import read_config, resolve


def run(options: argparse.Namespace) -> int:
    """Run the command of this name; exit code 1 where a release is not as it should be."""
    match options.command:
        case "verify":
            return _verify(options)
        case "diff":
            return _diff(options)
        case "fetch":
            fetch_release(options.address, options.folder)
            print(f"{options.folder}: all files are as released")
        case _:
            print(f"{pin(options.release, Path())}: pinned; commit it")
    return 0


def _verify(options: argparse.Namespace) -> int:
    """Whether a release is as it was made, and whether it can be made again."""
    stored = StoredRelease.open(options.release)
    if wrong := stored.changes():
        print(f"{options.release}: {len(wrong)} files are not as released:", *wrong, sep="\n")
        return 1
    checked = "the files in the pin" if stored.pinned else f"all {len(stored.files)} files"
    # now: a rebuild takes minutes
    print(f"{printable(stored.manifest.version)}: {checked} are as released", flush=True)
    if not options.rebuild:
        return 0
    rebuilt = rebuild(options.release, Path(), options.cores)
    found = f", with differences:\n{rebuilt.text(rebuilt.sections)}" if rebuilt.sections else ""
    print(f"rebuilt from the raw logs{found or ': the same bytes'}")
    return int(bool(rebuilt.sections))


def _diff(options: argparse.Namespace) -> int:
    """What differs between two releases; 1 where `--gate` finds a change beyond its limit."""
    before, after = StoredRelease.open(options.before), StoredRelease.open(options.after)
    campaign = after.manifest.made_from.campaign
    folder = config_folder(options.config)
    if options.gate or (folder / "campaigns" / f"{campaign}.yaml").is_file():
        drift = resolve(folder, {"campaign": campaign}).drift
    else:
        drift = read_config(folder).drift
    comparison = compare(before, after, drift)
    too_far = comparison.beyond_limits
    if not options.gate:
        print(comparison.text(comparison.sections))
    elif too_far.rows:
        print(comparison.text([too_far]))
    return int(options.gate and bool(too_far.rows))
