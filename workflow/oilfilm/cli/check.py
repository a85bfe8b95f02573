"""The command `oilfilm check`: read logs, apply every gate, say what was understood.

Decides: by which campaign a log is checked; whether a log is of a traction or a torque rig.
"""

import argparse
import os
import sys
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from oilfilm.cli.arguments import config_folder, json_text, project_folder
from oilfilm.cli.checked import Plain, checked_logs, report
from oilfilm.curation.curate import curate_ingested
from oilfilm.curation.rig_kind import RigKind
from oilfilm.curation.torque_rig import TORQUE_RIG
from oilfilm.curation.traction_rig import TRACTION_RIG
from oilfilm.errors import OilfilmError
from oilfilm.logs.base import Reading
from oilfilm.logs.first_seen import FirstSeen
from oilfilm.logs.ingest import ingest_logs, read_bytes, read_log
from oilfilm.logs.raw_files import named_logs, raw_files
from oilfilm.logs.run_sheet import RunSheet
from oilfilm.logs.sheet_file import is_run_sheet, sheet_of_paths
from oilfilm.settings.resolve import resolve
from oilfilm.settings.resolved import Settings

_KINDS: tuple[RigKind, ...] = (TRACTION_RIG, TORQUE_RIG)
Log = tuple[str, bytes]


def run(options: argparse.Namespace) -> int:
    """Run the command; exit code 1 where a log is refused."""
    kind = next((each for each in _KINDS if each.name == options.kind), None)
    config = config_folder(options.config)
    raw = project_folder(options.config) / "data" / "raw"
    given: list[Path] = []
    for path in options.logs:
        given += [path / name for name in raw_files(path)] if path.is_dir() else [path]
    campaign = options.campaign or _campaign_of(given, raw, config, options.config is not None)
    settings = resolve(config, {"campaign": campaign} if campaign else {})
    # a pattern such as data/raw/own/*.csv names the run sheet too
    paths = [path for path in dict.fromkeys(given) if not is_run_sheet(path, raw)]
    if not paths:
        raise OilfilmError(f"{_name(given[0])}: is a run sheet. Name logs.")
    for gone in _gone(settings.campaign.name, raw) if campaign else ():
        print(gone, file=sys.stderr)
    checked = check_files([(_name(path), read_bytes(path)) for path in paths], settings, kind, raw)
    print("\n".join(map(json_text, checked)) if options.json else report(checked))
    return int(any(log["verdict"] == "refused" for log in checked))


def _gone(campaign: str, raw: Path) -> Iterator[str]:
    """Which logs of a campaign's folders an earlier run has read and are no longer there."""
    for folder in (campaign, f"{campaign}-torque"):
        seen = FirstSeen(campaign, folder, raw.parent / "first_seen")
        there = named_logs(raw / folder) if (raw / folder).is_dir() else ()
        if gone := seen.gone(f"data/raw/{folder}/{name}" for name, _ in there):
            yield gone


def _campaign_of(paths: Iterable[Path], own: Path, config: Path, named: bool) -> str | None:
    """The campaign in whose folders the logs are; None where they are elsewhere.

    Args:
        paths: The logs.
        own: The folder of the campaigns' folders in the present project.
        config: The configuration folder.
        named: Whether it was named, and so meant for logs of other projects too.

    Raises:
        OilfilmError: They are of several campaigns, or of another project, whose settings are not
            the ones here.
    """
    own, known = own.resolve(), set()
    # not `resolve`, which fails on a link to itself
    for path in (Path(os.path.realpath(path)) for path in paths):
        for raw in (folder for folder in path.parents if folder.parts[-2:] == ("data", "raw")):
            campaign = path.relative_to(raw).parts[0].removesuffix("-torque")
            of_project = raw.parents[1] / "config"
            if ((config if raw == own else of_project) / f"campaigns/{campaign}.yaml").is_file():
                if raw == own:
                    known.add(campaign)
                elif not named:
                    raise OilfilmError(
                        f"{path}: is of the campaign {campaign} in the project folder "
                        f"{raw.parents[1]}, which has settings of its own. Run the command there, "
                        f"or name the settings that are meant: --config {of_project}, or "
                        "--campaign with a campaign of the present folder."
                    )
    if len(known) > 1:
        raise OilfilmError(
            f"{own}: the logs are of the campaigns {' and '.join(sorted(known))}. Check one "
            "campaign at a time, or name with --campaign the one whose limits are meant."
        )
    return next(iter(known), None)


def _name(path: Path) -> str:
    """A path as text, with escapes for bytes that are no text in the encoding of this system."""
    return str(path).encode("utf-8", "backslashreplace").decode("utf-8")


def check_files(
    logs: Sequence[Log],
    settings: Settings,
    kind: RigKind | None = None,
    raw: Path = Path("data/raw"),
) -> list[Plain]:
    """What was found in logs, in their order.

    Args:
        logs: The logs by path and content.
        settings: Settings of the campaign.
        kind: The kind of rig; found out for each log if not given.
        raw: The folder of the campaigns' folders, whose run sheets are used.

    Raises:
        OilfilmError: The kind of a log cannot be told, or as `ingest_logs`.
    """
    kinds = [kind or kind_of(*log, settings) for log in logs]
    found: dict[str, Plain] = {}
    for each in _KINDS:
        of_kind = [log for log, its_kind in zip(logs, kinds, strict=True) if its_kind is each]
        if of_kind:
            sheet = sheet_of_paths([Path(file) for file, _ in of_kind], raw, settings, each.logs)
            found |= {log["file"]: log for log in judged_logs(of_kind, settings, each, sheet)}
    return [found[file] for file, _ in logs]


def judged_logs(
    logs: Sequence[Log], settings: Settings, kind: RigKind, sheet: RunSheet
) -> list[Plain]:
    """What was found in logs of one kind, in their order.

    Raises:
        OilfilmError: As `ingest_logs`.
    """
    ingested = ingest_logs(logs, settings, kind.logs, sheet)
    curated = curate_ingested(ingested, settings, kind)
    return list(checked_logs(ingested, curated, settings, kind, sheet))


def kinds_of_folders(settings: Settings) -> dict[str, RigKind]:
    """The folders of a campaign below `data/raw`, with the kind of rig whose logs each has."""
    name, folders = settings.campaign.name, zip(("", "-torque"), _KINDS, strict=True)
    kinds = {f"{name}{ending}": kind for ending, kind in folders}
    return kinds if settings.campaign.torque is not None else {name: TRACTION_RIG}


def kind_of(file: str, content: bytes, settings: Settings) -> RigKind:
    """The kind of rig that a log is of: by the folder that it is in, else by its columns.

    Raises:
        OilfilmError: It may be of either kind.
    """
    of_folder = kinds_of_folders(settings)
    if len(of_folder) == 1:
        return TRACTION_RIG
    # the nearest folder decides: that of the project may have the name of the campaign, too
    for folder in Path(file).resolve().parents:
        if folder.name in of_folder:
            return of_folder[folder.name]
    readings = {kind: read_log(content, file, settings, kind.logs)[1] for kind in _KINDS}
    runs = [kind for kind, reading in readings.items() if reading.runs]
    if len(runs) > 1:
        raise OilfilmError(
            f"{file}: has the columns of a traction log and those of a torque log. Say which it "
            "is: --traction or --torque."
        )
    # a log that lacks columns of one kind only is of the other, whatever else is wrong with it
    return min(runs or _KINDS, key=lambda kind: "columns" in _rules(readings[kind]))


def _rules(reading: Reading) -> set[str]:
    return {refusal.rule for refusal in reading.refusals}
