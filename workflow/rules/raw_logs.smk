# Which raw logs the campaign has, in which shares jobs read them, and what the run sheet says of them.

import json
from hashlib import sha256

from oilfilm.base.atomic_write import write_text
from oilfilm.logs.log_digests import LogDigests
from oilfilm.logs.raw_files import find_sheet, raw_files, shares_of

# Names of the logs when a run began, for its jobs on a cluster: they start later.
FOUND = RECORDS / "oilfilm-logs.json"


def logs_found():
    """Names of all logs of the campaign, by their folder."""
    if not workflow.is_main_process and FOUND.is_file():
        return json.loads(FOUND.read_text(encoding="utf-8"))
    folders = [RAW] if CAMPAIGN.torque is None else [RAW, TORQUE_RAW]
    return {
        folder.as_posix(): simulated_names(folder) if folder in TWINS else raw_files(folder)
        for folder in folders
    }


def simulated_names(folder):
    """Names of the logs of one rig that are simulated."""
    plan = studies.plan_of_simulator()
    runs = plan.planned_runs(CAMPAIGN) if folder == RAW else plan.planned_torque_runs(CAMPAIGN)
    return [run.name for run in runs]


def run_sheet(folder, files):
    """What the run sheet in a folder of measured logs says of them; None where there is none."""
    path = None if folder in TWINS or not files else find_sheet(folder)
    if path is None:
        return None
    # imported where needed: pandas comes with them
    from oilfilm.logs.sheet_file import read_run_sheet
    from oilfilm.logs.torque_log import TORQUE
    from oilfilm.logs.traction_log import TRACTION

    kind = TRACTION if folder == RAW else TORQUE
    return read_run_sheet(path.read_bytes(), path, files, SETTINGS, kind)


try:
    LOGS = logs_found()
    FILES, TORQUE_FILES = LOGS[RAW.as_posix()], LOGS.get(TORQUE_RAW.as_posix(), [])
    SHEETS = {folder: run_sheet(folder, LOGS[folder.as_posix()]) for folder in map(Path, LOGS)}
except OilfilmError as mistake:
    stop(mistake)

FILES_OF_SHARE = shares_of(FILES, SETTINGS.split.runs)
SHARDS = list(FILES_OF_SHARE)
# The samples of one share. Patterns are texts of their own where several rules expand them: an
# output of a rule that is kept in object storage cannot be expanded.
SAMPLES = [f"<tables>/samples/oil={oil}/part-{{shard}}.parquet" for oil in OILS]

DIGESTS = LogDigests(RECORDS / f"oilfilm-digests-{CAMPAIGN.name}.json")


def raw_logs(folder, files):
    """Raw logs as inputs; what the rig twin writes is a result like others."""
    paths = [f"{folder.as_posix()}/{file}" for file in files]
    return paths if folder in TWINS else list(map(local, paths))


def digests_of_logs(folder, files):
    """sha256 of measured logs by name; the listing of the rig twin has those of simulated ones.

    As params they rerun what reads a log with other bytes; Snakemake itself goes by its date.
    """
    return dict.fromkeys(files) if folder in TWINS else DIGESTS.digest_of_name(folder, files)


def keep_logs_found():
    """Write down names for jobs on a cluster, and states of measured logs for the next run."""
    write_text(json.dumps(LOGS), FOUND)
    for folder, files in LOGS.items():
        digests_of_logs(Path(folder), files)
    DIGESTS.keep()


def sheet_rows(folder, files, remarks=True):
    """The rows of the run sheet on some logs; remarks on it as a whole belong to one of the jobs."""
    sheet = SHEETS.get(folder)
    return sheet.plain(files, with_remarks=remarks) if sheet else {}


def digests_of_sheets():
    """Digest of each run sheet by its path."""
    paths = [find_sheet(folder) for folder, sheet in SHEETS.items() if sheet is not None]
    return {path.as_posix(): sha256(path.read_bytes()).hexdigest() for path in paths}


# Changes of measured logs that are meant; another run refuses them.
ACKNOWLEDGED = [change.model_dump() for change in SETTINGS.dataset.acknowledged_changes]
