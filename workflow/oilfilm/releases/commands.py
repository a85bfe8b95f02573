"""The commands on releases: verify, diff, pin."""

import argparse
from pathlib import Path
from typing import Any

from oilfilm.releases.compare import compare
from oilfilm.releases.drift import moved
from oilfilm.releases.manifest import read_manifest, shown
from oilfilm.releases.opened import Opened
from oilfilm.releases.page import page
from oilfilm.releases.pin import pin
from oilfilm.releases.rebuild import rebuild
from oilfilm.releases.said import said, section_text
from oilfilm.releases.verify import verify
from oilfilm.settings.load import load_checked, resolve


def add_commands(commands: Any) -> None:
    """Add the commands to those of a parser."""
    check = commands.add_parser("verify", help="is a release still what it was")
    check.add_argument("release", type=Path, metavar="RELEASE", help="folder of a release or a pin")
    check.add_argument(
        "--rebuild", action="store_true", help="make it anew from the raw logs and compare"
    )
    check.add_argument("--cores", default="all", help="of a rebuild (default: all)")
    check.set_defaults(run=_verify)
    diff = commands.add_parser("diff", help="what differs between two releases")
    diff.add_argument("before", type=Path, metavar="A", help="folder of a release or a pin")
    diff.add_argument("after", type=Path, metavar="B", help="the same")
    diff.add_argument("--html", type=Path, metavar="PAGE", help="write it all as a page")
    diff.add_argument(
        "--gate",
        action="store_true",
        help="say only what moved by more than `drift` in config.yaml lets pass; then fail",
    )
    diff.add_argument("--config", type=Path, default=Path("config"), help="configuration folder")
    diff.set_defaults(run=_diff)
    keep = commands.add_parser("pin", help="keep a release for later ones to be held against")
    keep.add_argument("release", type=Path, metavar="RELEASE", help="folder of a release")
    keep.set_defaults(run=_pin)


def _verify(given: argparse.Namespace) -> int:
    complaints = verify(given.release)
    if complaints:
        print(f"{given.release}: {len(complaints)} files are not as released:")
        print("\n".join(complaints))
        return 1
    manifest, pinned = read_manifest(given.release)
    whole = "the files that the pin keeps are" if pinned else f"all {len(manifest.files)} files are"
    print(f"{shown(manifest.version)}: {whole} as released")
    if not given.rebuild:
        return 0
    differences = rebuild(given.release, Path(), given.cores)
    if not differences:
        print("rebuilt from the raw logs: the same bytes")
        return 0
    print(f"rebuilt from the raw logs: {len(differences)} differences, the first:")
    print("\n".join(map(shown, differences)))
    return 1


def _diff(given: argparse.Namespace) -> int:
    before, after = Opened.at(given.before), Opened.at(given.after)
    campaign = after.manifest.made_from["campaign"]
    drift = _drift(given.config, campaign, given.gate)
    comparison = compare(before, after, drift)
    too_far = moved(comparison, drift)
    if given.html:
        # half a letter, as a stranger's YAML may spell it, has no UTF-8
        text = page(comparison, too_far)
        given.html.write_text(text, encoding="utf-8", errors="backslashreplace")
    if not given.gate:
        print(said(comparison))
        return 0
    if too_far.rows:
        # whole: a table of what moved is never cut
        table = section_text(too_far, len(too_far.rows))
        print(f"A {before.name}\nB {after.name}\n{table}")
    return int(bool(too_far.rows))


def _drift(folder: Path, campaign: str, gate: bool) -> dict[str, Any]:
    """Where and how mu is compared; of a campaign that is not configured here as of any other.

    Raises:
        OilfilmError: The configuration has a mistake, or lacks the campaign that is to be stopped.
    """
    known = (folder / "campaigns" / f"{campaign}.yaml").is_file()
    settings = (
        resolve(folder, {"campaign": campaign})
        if known or gate
        else load_checked(folder / "config.yaml", "config")
    )
    return dict(settings["drift"])


def _pin(given: argparse.Namespace) -> int:
    print(f"{pin(given.release, Path())}: pinned; commit it")
    return 0
