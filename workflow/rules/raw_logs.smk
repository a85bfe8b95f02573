# Which raw logs the campaign has, in which shares jobs read them, and what the run sheet says of them.

import json
from hashlib import sha256

from oilfilm.base.atomic_write import write_text
from oilfilm.logs.log_digests import LogDigests
from oilfilm.logs.raw_files import find_run_sheet, logs_by_share, raw_log_names

# File with the names of the logs when a run began. Its jobs on a cluster start later and read it.
FOUND_LOGS_FILE = SNAKEMAKE_FOLDER / "oilfilm-logs.json"


def log_names_by_folder():
    """Names of all logs of the campaign, by folder; a job takes those that its run has found."""
    if not workflow.is_main_process and FOUND_LOGS_FILE.is_file():
        return json.loads(FOUND_LOGS_FILE.read_text(encoding="utf-8"))
    folders = [RAW_FOLDER] if CAMPAIGN.torque is None else [RAW_FOLDER, TORQUE_RAW_FOLDER]
    return {
        folder.as_posix(): (
            simulated_names(folder) if folder in SIMULATED_FOLDERS else raw_log_names(folder)
        )
        for folder in folders
    }


def simulated_names(folder):
    """Names of the logs of one rig that are simulated."""
    plan = studies.plan_of_simulator()
    runs = (
        plan.simulated_runs(CAMPAIGN)
        if folder == RAW_FOLDER
        else plan.simulated_torque_runs(CAMPAIGN)
    )
    return [run.name for run in runs]


def run_sheet(folder, log_names):
    """What the run sheet in a folder of measured logs says of them; None where there is none."""
    path = None if folder in SIMULATED_FOLDERS or not log_names else find_run_sheet(folder)
    if path is None:
        return None
    # imported where needed: pandas comes with them
    from oilfilm.logs.sheet_file import read_run_sheet
    from oilfilm.logs.torque_log import TORQUE
    from oilfilm.logs.traction_log import TRACTION

    kind = TRACTION if folder == RAW_FOLDER else TORQUE
    return read_run_sheet(path.read_bytes(), path, log_names, SETTINGS, kind)


try:
    LOG_NAMES_BY_FOLDER = log_names_by_folder()
    LOG_NAMES = LOG_NAMES_BY_FOLDER[RAW_FOLDER.as_posix()]
    TORQUE_LOG_NAMES = LOG_NAMES_BY_FOLDER.get(TORQUE_RAW_FOLDER.as_posix(), [])
    RUN_SHEETS = {
        Path(folder): run_sheet(Path(folder), log_names)
        for folder, log_names in LOG_NAMES_BY_FOLDER.items()
    }
except OilfilmError as mistake:
    stop(mistake)

LOG_NAMES_OF_SHARE = logs_by_share(LOG_NAMES, SETTINGS.split.runs)
SHARES = list(LOG_NAMES_OF_SHARE)
# Patterns of the files of samples, one per oil. They are texts of their own, because several rules
# expand them: an output of a rule that is kept in object storage cannot be expanded.
SAMPLE_FILES = [f"<tables>/samples/oil={oil}/part-{{share}}.parquet" for oil in OILS]

LOG_DIGESTS = LogDigests(SNAKEMAKE_FOLDER / f"oilfilm-digests-{CAMPAIGN.name}.json")


def raw_logs(folder, log_names):
    """Raw logs as inputs; what the rig twin writes is a result like others."""
    paths = [f"{folder.as_posix()}/{name}" for name in log_names]
    return paths if folder in SIMULATED_FOLDERS else list(map(local, paths))


def digests_of_logs(folder, log_names):
    """sha256 of measured logs by name; the listing of the rig twin has those of simulated ones.

    As params they make Snakemake rerun a job if the bytes of a log have changed. Snakemake itself
    compares only the dates of files.
    """
    return (
        dict.fromkeys(log_names)
        if folder in SIMULATED_FOLDERS
        else LOG_DIGESTS.digest_of_name(folder, log_names)
    )


def save_found_logs():
    """Save the names of logs for jobs on a cluster, and digests of measured logs for the next run."""
    write_text(json.dumps(LOG_NAMES_BY_FOLDER), FOUND_LOGS_FILE)
    for folder, log_names in LOG_NAMES_BY_FOLDER.items():
        digests_of_logs(Path(folder), log_names)
    LOG_DIGESTS.save()


def sheet_rows(folder, log_names, remarks=True):
    """The rows of the run sheet on some logs, as params.

    Remarks concern the whole sheet, so that only one of the jobs gets them.
    """
    sheet = RUN_SHEETS.get(folder)
    return sheet.to_params(log_names, with_remarks=remarks) if sheet else {}


def digests_of_sheets():
    """Digest of each run sheet by its path."""
    paths = [find_run_sheet(folder) for folder, sheet in RUN_SHEETS.items() if sheet is not None]
    return {path.as_posix(): sha256(path.read_bytes()).hexdigest() for path in paths}


# Changes of measured logs that are meant; another run refuses them.
ACKNOWLEDGED_CHANGES = [change.model_dump() for change in SETTINGS.dataset.acknowledged_changes]
