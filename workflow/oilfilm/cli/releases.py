"""The commands about releases: `oilfilm verify`, `fetch`, `diff` and `pin`."""

import argparse
from pathlib import Path

from oilfilm.api.folders import config_folder
from oilfilm.base.errors import printable
from oilfilm.releases.compare import compare
from oilfilm.releases.release import rebuild
from oilfilm.releases.stored_release import StoredRelease, fetch_release, pin
from oilfilm.settings.resolve import campaign_names, read_config, resolve


def run(options: argparse.Namespace) -> int:
    """Run one of these commands.

    Returns:
        The exit code: 1 where a file of a release has changed, where a rebuild differs in files or
        packages, or, with `--gate`, where two releases differ by more than a limit; else 0.
    """
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
    """Compare the files of a release with its checksums; with `--rebuild` make its results again.

    Returns:
        1 where a file, a result or a package of the rebuild differs, else 0.
    """
    stored_release = StoredRelease.open(options.release)
    changes = stored_release.find_changes()
    if changes:
        files_are = "1 file is" if len(changes) == 1 else f"{len(changes)} files are"
        print(f"{options.release}: {files_are} not as released:", *changes, sep="\n")
        return 1
    checked_files = f"all {len(stored_release.record_by_path)} files"
    if stored_release.is_pin:
        checked_files = "the files in the pin"
    version = printable(stored_release.manifest.version)
    # without buffering: a rebuild takes minutes
    print(f"{version}: {checked_files} are as released", flush=True)
    if not options.rebuild:
        return 0
    comparison = rebuild(options.release, Path(), options.cores)
    if not comparison.sections:
        print("rebuilt from the raw logs: the same bytes")
        return 0
    differences = comparison.text(comparison.sections)
    print(f"rebuilt from the raw logs, with differences:\n{differences}")
    return 1


def _diff(options: argparse.Namespace) -> int:
    """Print the differences of two releases; 1 where `--gate` finds a change beyond its limit."""
    before, after = StoredRelease.open(options.before), StoredRelease.open(options.after)
    campaign_name = after.manifest.made_from.campaign
    settings_folder = config_folder(options.config)
    if options.gate or campaign_name in campaign_names(settings_folder):
        drift = resolve(settings_folder, {"campaign": campaign_name}).drift
    else:
        drift = read_config(settings_folder).drift
    comparison = compare(before, after, drift)
    sections_beyond_limits = comparison.beyond_limits
    if not options.gate:
        print(comparison.text(comparison.sections))
    elif sections_beyond_limits:
        print(comparison.text(sections_beyond_limits))
    return int(options.gate and bool(sections_beyond_limits))
