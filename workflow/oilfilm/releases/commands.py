"""The commands on releases: verify, diff, pin."""

import argparse
from pathlib import Path
from typing import Any

from oilfilm.errors import printable
from oilfilm.releases.compare import compare
from oilfilm.releases.drift import drift_table
from oilfilm.releases.manifest import read_manifest
from oilfilm.releases.messages import comparison_text, section_text
from oilfilm.releases.page import page
from oilfilm.releases.pin import pin
from oilfilm.releases.rebuild import rebuild
from oilfilm.releases.stored_release import StoredRelease
from oilfilm.releases.verify import verify
from oilfilm.settings.config import DriftSettings
from oilfilm.settings.resolve import read_config, resolve


def add_commands(commands: Any) -> None:
    """Add the commands to those of a parser."""
    verify_parser = commands.add_parser(
        "verify", help="check that no file of a release has changed"
    )
    verify_parser.add_argument(
        "release", type=Path, metavar="RELEASE", help="folder of a release or a pin"
    )
    verify_parser.add_argument(
        "--rebuild", action="store_true", help="run the workflow on the raw logs again and compare"
    )
    verify_parser.add_argument("--cores", default="all", help="cores for --rebuild (default: all)")
    verify_parser.set_defaults(run=_verify)
    diff_parser = commands.add_parser("diff", help="show the differences between two releases")
    diff_parser.add_argument("before", type=Path, metavar="A", help="folder of a release or a pin")
    diff_parser.add_argument(
        "after", type=Path, metavar="B", help="folder of another release or pin"
    )
    diff_parser.add_argument(
        "--html", type=Path, metavar="PAGE", help="write the full comparison as an HTML page"
    )
    diff_parser.add_argument(
        "--gate",
        action="store_true",
        help="show only changes beyond the limits of `drift` in config.yaml; exit with 1 if any",
    )
    diff_parser.add_argument(
        "--config", type=Path, default=Path("config"), help="configuration folder"
    )
    diff_parser.set_defaults(run=_diff)
    pin_parser = commands.add_parser("pin", help="keep a release as the reference for later ones")
    pin_parser.add_argument("release", type=Path, metavar="RELEASE", help="folder of a release")
    pin_parser.set_defaults(run=_pin)


def _verify(options: argparse.Namespace) -> int:
    complaints = verify(options.release)
    if complaints:
        print(f"{options.release}: {len(complaints)} files are not as released:")
        print("\n".join(complaints))
        return 1
    manifest, pinned = read_manifest(options.release)
    checked = "the files in the pin" if pinned else f"all {len(manifest.files)} files"
    print(f"{printable(manifest.version)}: {checked} are as released")
    if not options.rebuild:
        return 0
    differences = rebuild(options.release, Path(), options.cores)
    if not differences:
        print("rebuilt from the raw logs: the same bytes")
        return 0
    print(f"rebuilt from the raw logs: {len(differences)} differences, the first:")
    print("\n".join(map(printable, differences)))
    return 1


def _diff(options: argparse.Namespace) -> int:
    before, after = StoredRelease.open(options.before), StoredRelease.open(options.after)
    campaign = after.manifest.made_from["campaign"]
    drift = _drift(options.config, campaign, options.gate)
    comparison = compare(before, after, drift)
    too_far = drift_table(comparison, drift)
    if options.html:
        # YAML can escape half of a surrogate pair, which UTF-8 cannot encode
        text = page(comparison, too_far)
        options.html.write_text(text, encoding="utf-8", errors="backslashreplace")
    if not options.gate:
        print(comparison_text(comparison))
        return 0
    if too_far.rows:
        # this table is never cut
        table = section_text(too_far, len(too_far.rows))
        print(f"A {before.name}\nB {after.name}\n{table}")
    return int(bool(too_far.rows))


def _drift(folder: Path, campaign: str, gate: bool) -> DriftSettings:
    """Settings `drift` of the campaign, or of config.yaml where the campaign is not configured.

    Raises:
        OilfilmError: The configuration has a mistake, or the gate needs a campaign that it lacks.
    """
    if gate or (folder / "campaigns" / f"{campaign}.yaml").is_file():
        return resolve(folder, {"campaign": campaign}).drift
    return read_config(folder).drift


def _pin(options: argparse.Namespace) -> int:
    print(f"{pin(options.release, Path())}: pinned; commit it")
    return 0
