# Decides: which settings, files and code rerun a rule (`part`, `finished`, `code`); paths of
# results.

import atexit
import json
import mimetypes
import os
import shutil
from contextlib import suppress
from functools import cache
from hashlib import sha256
from pathlib import Path

from snakemake.exceptions import WorkflowError
from snakemake.settings.types import SharedFSUsage
from snakemake.logging import logger
from snakemake.io import report as in_report  # at the start of a line `report` is a directive

from oilfilm.figure_catalogue import families
from oilfilm.settings.resolve import overrides_of, resolve
from oilfilm.errors import OilfilmError
from oilfilm.run.lock import lock_run, clear_leftovers
from oilfilm.run.start import ask_machine, machine_fault, start_python_by_name
from oilfilm.digest_cache import DigestCache
from oilfilm.digests import code_digest, file_digest
from oilfilm import home
from oilfilm.home import HOME, PACKAGE
from oilfilm.logs.first_seen import FirstSeen
from oilfilm.logs.raw_files import (
    find_sheet,
    keep_found,
    raw_files,
    refuse_altered,
    refuse_strangers,
    shares_of,
)
from oilfilm.releases.tree import code_tree_digest
from oilfilm.rig_twin.plan import planned_runs, planned_torque_runs
from oilfilm.traction import LAW_FILES

RECORDS = Path(".snakemake")
# Digests of raw logs from earlier runs: a dry run does not read the logs again.
KEPT_DIGESTS = DigestCache(RECORDS / "oilfilm-digests.json")
# Digests of the run sheets that this run reads, by their paths.
SHEETS = {}


# Where all results go with `--default-storage-provider`, and Snakemake's local copies of them.
DEFAULT_STORAGE = workflow.storage_registry.default_storage_provider
RESULTS_PLACE, COPIES = "", Path()
if DEFAULT_STORAGE is not None:
    RESULTS_PLACE = (workflow.storage_settings.default_storage_prefix or "").rstrip("/")
    if not RESULTS_PLACE:
        raise WorkflowError(
            "--default-storage-provider needs --default-storage-prefix, as s3://BUCKET/PLACE."
        )
    COPIES = DEFAULT_STORAGE.object(f"{RESULTS_PLACE}/results").local_path().parent
os.environ[home.COPIES] = str(COPIES if DEFAULT_STORAGE else HOME)  # for the jobs


def run_sheet(folder, files):
    """What the run sheet in a folder of logs says of them; None where there is none."""
    path = find_sheet(folder)
    if path is None:
        return None
    # imported where needed: pandas comes with them
    from oilfilm.logs.sheet_file import read_run_sheet
    from oilfilm.logs.torque_log import TORQUE
    from oilfilm.logs.traction_log import TRACTION

    kind = TRACTION if folder == RAW else TORQUE
    content = path.read_bytes()
    SHEETS[path.as_posix()] = sha256(content).hexdigest()
    return read_run_sheet(content, path, files, SETTINGS, kind)


start_python_by_name()
try:
    if workflow.is_main_process:
        ask_machine([RECORDS, Path("results")])
    typed = workflow.config_settings.overwrite_config
    SETTINGS = resolve(Path("config"), overrides_of(config, Path("config"), typed))
    CAMPAIGN = SETTINGS.campaign
    RAW = Path("data/raw", CAMPAIGN.name)
    SIMULATED = CAMPAIGN.twin is not None
    if SIMULATED:
        FILES = [run.name for run in planned_runs(CAMPAIGN)]
        refuse_strangers(RAW, FILES)
        listing = Path("results", CAMPAIGN.name, "twin/logs.sha256")
        refuse_altered(RAW, listing, KEPT_DIGESTS.digest)
    else:
        FILES = raw_files(RAW)
    SHEET = None if SIMULATED else run_sheet(RAW, FILES)
    TORQUE_RAW = Path("data/raw", f"{CAMPAIGN.name}-torque")
    TORQUE_SIMULATED = CAMPAIGN.torque is not None and CAMPAIGN.torque.twin is not None
    TORQUE_FILES = []
    TORQUE_SHEET = None
    if TORQUE_SIMULATED:
        TORQUE_FILES = [run.name for run in planned_torque_runs(CAMPAIGN)]
        refuse_strangers(TORQUE_RAW, TORQUE_FILES)
        listing = Path("results", CAMPAIGN.name, "twin/torque_logs.sha256")
        refuse_altered(TORQUE_RAW, listing, KEPT_DIGESTS.digest)
    elif CAMPAIGN.torque is not None:
        TORQUE_FILES = raw_files(TORQUE_RAW)
        TORQUE_SHEET = run_sheet(TORQUE_RAW, TORQUE_FILES)
except OilfilmError as mistake:
    raise WorkflowError(str(mistake)) from None

# A release must not name packages that its results were not made with.
PACKAGES = file_digest(HOME / "requirements.lock")[:8]

twins = [*[RAW] * SIMULATED, *[TORQUE_RAW] * TORQUE_SIMULATED]
other_run = ""
if workflow.is_main_process:
    other_run = clear_leftovers(RECORDS, [Path("results", CAMPAIGN.name), *twins])
    if other_run:
        logger.warning(other_run)

# Taken now: what ran is what lay here when the run began.
TREE = code_tree_digest(HOME)

# In Snakemake's report a table is a file to save, not a text to show.
mimetypes.add_type("application/vnd.apache.parquet", ".parquet")

# The parts of the settings that a rule depends on.
part = SETTINGS.part

# Keys of the campaign that say where its data are from.
ORIGIN = ("credit", "simulated_by", "twin")

OILS = list(SETTINGS.oils)
# What the twin's truth is computed from, beside the campaign file.
TRUTH = ["rigs", "oils"] if SIMULATED and CAMPAIGN.twin.thermal_ehl else ["rigs"]
FILES_OF_SHARE = shares_of(FILES, SETTINGS.split.runs)
# The samples of one share. Patterns are texts of their own where several rules expand them: an
# output of a rule that is kept in object storage cannot be expanded.
SAMPLES = [f"<tables>/samples/oil={oil}/part-{{shard}}.parquet" for oil in OILS]
PARTS = f"results/{CAMPAIGN.name}/parts"


def file_of_found(name):
    return f"{PARTS}/logs/{name}.json"


def found_before(name):
    """What the run found of measured logs when it began, for a process of a cluster.

    It starts later: logs may have come, gone or changed since.
    """
    path = Path(file_of_found(name))
    if workflow.is_main_process or not path.is_file():
        return None
    return json.loads(path.read_text(encoding="utf-8"))


# Shares of the logs, and digests of the run sheets by their paths.
OF_RUN = {"shares": list(FILES_OF_SHARE), "sheets": SHEETS}
if not SIMULATED:
    OF_RUN = found_before("run") or OF_RUN
SHARDS = OF_RUN["shares"]


pathvars:
    raw=RAW.as_posix(),
    torque_raw=TORQUE_RAW.as_posix(),
    tables=f"results/{CAMPAIGN.name}/tables",
    parts=PARTS,
    figures=f"results/{CAMPAIGN.name}/figures",
    logs=f"results/{CAMPAIGN.name}/logs",
    results=f"results/{CAMPAIGN.name}",


wildcard_constraints:
    shard=r"\d+",
    oil="|".join(OILS),


# What one fit writes (oilfilm.tables.fits.OF_FIT, whose import takes half a second).
FIT_TABLES = (
    *("coefficients", "fit_quality", "refits", "correlations", "profiles", "curve_residuals"),
    "law_points",
)
# Tables that a campaign without torque logs lacks, and those that one without a twin lacks.
TORQUE_TABLES = (
    *("torque_runs", "torque_quarantine", "torque", "torque_control", "torque_inversion"),
    *("cage_slip", "heat_balance", "size_effect", "test_plan"),
)
# Of the study of the paper: in any campaign, with torque logs, with a twin.
PAPER_TABLES = ("printed_judged", "signs", "sign_verdicts", "claims", "selection")
ADVICE_TABLES = ("slip_advice", "advice_band", "published_tests")
EXTRAPOLATION_TABLES = ("extrapolation", "extrapolation_errors")


def reference_file(name):
    """A file of data/reference; it stays in the folder where results go to object storage."""
    return local(home.reference_file(name).as_posix())


def finished(*names):
    """Files of finished tables by name; no file of a table that this campaign does not have."""
    lacking = set()
    of_paper = "paper" in CAMPAIGN.studies
    if CAMPAIGN.torque is None:
        lacking |= set(TORQUE_TABLES)
    if not of_paper:
        lacking |= set(PAPER_TABLES)
    if not (of_paper and CAMPAIGN.torque is not None):
        lacking |= set(ADVICE_TABLES)
    if not (of_paper and SIMULATED):
        lacking |= set(EXTRAPOLATION_TABLES)
    return {name: [] if name in lacking else f"<tables>/{name}.parquet" for name in names}


def caption_file(*place):
    """Caption of a figure or table; its whole path, or Snakemake would look beside the rule."""
    return Path("results", CAMPAIGN.name, "captions", *place).resolve().as_posix() + ".rst"


def files_of_figures(figures):
    """Files of figures, each PNG with its caption in Snakemake's report."""
    return {
        "png": [
            in_report(
                f"<figures>/{figure.name}.png",
                caption=caption_file("figures", figure.name),
                category=figure.category,
                labels={"figure": figure.paper or figure.title},
            )
            for figure in figures
        ],
        "svg": [f"<figures>/{figure.name}.svg" for figure in figures],
        "drawn": [f"<figures>/{figure.name}.parquet" for figure in figures],
    }


def inputs_of_figures(figures):
    """Finished tables and reference files that figures are drawn from."""
    references = sorted({name for figure in figures for name in figure.references})
    names = {name for figure in figures for name in figure.tables}
    if any(figure.shows_data for figure in figures):
        names.add("points")  # which say whose film thickness was not judged
    if names & set(FIT_TABLES):
        names.add("fit_quality")  # which says what law is configured
    return {
        **finished(*sorted(names)),
        **{name: reference_file(name) for name in references},
    }


def settings_of_figures(figures):
    """Settings that figures depend on; each says where its data are from."""
    keys = {key for figure in figures for key in figure.settings}
    of_campaign = {key for key in keys if key.startswith("campaign.")}
    return part(
        *(keys - of_campaign),
        campaign=(*ORIGIN, *(key.removeprefix("campaign.") for key in of_campaign)),
    )


def code(script, *modules):
    """Digest of a script, of the modules that count for it and of the packages.

    A law that the script takes by its name is no import: its module is among `modules`.
    """
    return f"{code_digest(HOME / 'workflow/scripts' / script, *modules)}-{PACKAGES}"


# Modules of the campaign's studies: no import of what loads them leads there.
STUDIES = [PACKAGE / name / "study.py" for name in CAMPAIGN.studies]
# What columns and tables mean, for the rules that print it.
TABLE_WORDS = [
    *sorted((PACKAGE / "tables").glob("*.py")),
    *(PACKAGE / name / "tables.py" for name in CAMPAIGN.studies),
]

# Taken once per run: a release names the logs that its run has read, not what they became since.
digest_of_log = cache(KEPT_DIGESTS.digest)


def keep_digests():
    with suppress(OSError):  # they save time, nothing else
        KEPT_DIGESTS.save()


if workflow.is_main_process:
    atexit.register(keep_digests)


def state_of_log(path):
    """A log's sha256; empty if it cannot be read, which its job says."""
    try:
        return digest_of_log(path)
    except OSError:
        return ""


def states_of(folder, files):
    """The state of each log, whatever its time stamp says; empty if the twin has yet to write it."""
    return {file: "" if folder in twins else state_of_log(folder / file) for file in files}


def raw_with_digests(wildcards):
    """Every log and run sheet of the campaign by its path from the top folder, with its state."""
    return SHEETS | {
        (folder / file).as_posix(): state
        for folder, files in ((RAW, FILES), (TORQUE_RAW, TORQUE_FILES))
        for file, state in states_of(folder, files).items()
    }


def refuse_changed_logs():
    """Refuse measured logs that have changed since a run first read them."""
    folders = ((RAW, FILES, SIMULATED), (TORQUE_RAW, TORQUE_FILES, TORQUE_SIMULATED))
    logs = [folder / file for folder, files, twin in folders if not twin for file in files]
    acknowledged = SETTINGS.dataset.acknowledged_changes
    try:
        first_seen = FirstSeen(CAMPAIGN.name)
        first_seen.refuse_changed(logs, state_of_log, acknowledged)
    except OilfilmError as mistake:
        raise WorkflowError(str(mistake)) from None
    return first_seen


if workflow.is_main_process:
    FIRST_SEEN = refuse_changed_logs()


# Logs by the job that reads them: a share, or "torque".
LOGS_OF_JOB = {str(shard): files for shard, files in FILES_OF_SHARE.items()}
if CAMPAIGN.torque is not None:
    LOGS_OF_JOB["torque"] = TORQUE_FILES


def folder_of_job(name):
    return TORQUE_RAW if name == "torque" else RAW


@cache
def logs_as_found(name):
    """The state of each log of a job and the run sheet's rows on them, when the run began."""
    folder = folder_of_job(name)
    if name == "torque" and CAMPAIGN.torque is None:
        return {"states": {}, "sheet": {}}
    if folder not in twins and (found := found_before(name)):
        return found
    files = LOGS_OF_JOB.get(name, [])
    sheet = TORQUE_SHEET if name == "torque" else SHEET
    # remarks on the sheet as a whole belong to the first share
    remarks = name in {"torque", *list(LOGS_OF_JOB)[:1]}
    rows = sheet.plain(files, remarks=remarks) if sheet else {}
    return {"states": states_of(folder, files), "sheet": rows}


def measured_logs_of(name):
    """A job's input that stands for its measured logs: it shows a change without records of params.

    Snakemake would look at every log at every step. A file of this machine keeps its job here where
    the others have no access to the folder. There the params alone show a change.
    """
    measured = name in LOGS_OF_JOB and folder_of_job(name) not in twins
    shared = SharedFSUsage.INPUT_OUTPUT in workflow.storage_settings.shared_fs_usage
    return local(file_of_found(name)) if measured and shared else []


def keep_all_found():
    """Write what was found of measured logs, except what a job of another run goes by."""
    measured = [name for name in LOGS_OF_JOB if folder_of_job(name) not in twins]
    found = {name: logs_as_found(name) for name in measured}
    if not SIMULATED:
        found["run"] = OF_RUN
    for name, content in found.items():
        path = Path(file_of_found(name))
        if not (other_run and path.is_file()):
            try:
                keep_found(content, path)
            except OSError as error:
                raise WorkflowError(f"{path}: {machine_fault(error) or error.strerror}") from None


if workflow.is_main_process:
    keep_all_found()


def keep_first_seen():
    """Add the logs that jobs have read, whether in this run or before, to the campaign's listing."""
    states = {}
    for job in filter(workflow.dag.noneedrun_finished, workflow.dag.jobs):
        folder = {"ingest": RAW, "torque_runs": TORQUE_RAW}.get(job.rule.name)
        if folder is not None:
            files = job.params.files
            states |= {(folder / file).as_posix(): state for file, state in files.items()}
    try:
        FIRST_SEEN.add(states)
    except OSError as error:
        logger.warning(
            f"{error.filename}: cannot be written ({error.strerror}). Logs that change after this "
            "run will not be noticed."
        )


def run_sheet_of(folder):
    """The run sheet in a folder of logs with its digest, as inputs of a table; empty without one."""
    sheets = OF_RUN["sheets"].items()
    return {path: digest[:16] for path, digest in sheets if Path(path).parent == folder}


def begin():
    if workflow.local_exec:
        # Each wake-up of Snakemake's limit on job starts begins another one, and each looks at all
        # ready jobs: with 10 000 logs in 40 shares that took 14 s of CPU. Local starts need no limit.
        workflow.scheduler.job_rate_limiter = None
    try:
        lock_run(RECORDS, CAMPAIGN.name)
    except OilfilmError as mistake:
        raise WorkflowError(str(mistake)) from None


def folder_of_results(wildcards):
    """The results of the campaign, or their local copies if they are in object storage."""
    return (COPIES / "results" / CAMPAIGN.name).as_posix()


def keep_log(logs):
    """Keep Snakemake's own log, which has every detail, beside those of the jobs; its path."""
    kept = Path("results", CAMPAIGN.name, "logs/snakemake.log")
    with suppress(OSError):  # the disk may be full
        kept.parent.mkdir(parents=True, exist_ok=True)  # other results may be in object storage
        for log in logs:
            shutil.copyfile(log, kept)
    return kept


def end_well(logs):
    """Print the summary and where everything is."""
    keep_first_seen()
    # a dry run need not wait for it
    from oilfilm.report.summary import at_the_end_of_a_run

    summary = Path("results", CAMPAIGN.name, "summary.txt")
    lines = []
    if DEFAULT_STORAGE is not None:
        lines.append(f"Results: {RESULTS_PLACE}/results/{CAMPAIGN.name}")
    elif summary.is_file():  # a run of one table makes no summary
        lines.append(at_the_end_of_a_run(summary.read_text(encoding="utf-8"), str(summary)))
    if any(job.rule.name == "release" for job in workflow.dag.jobs):
        release = Path("results/releases", CAMPAIGN.name, "latest")
        lines.append(f"Release: {release.parent / release.readlink()}")
        lines.append(f"         {release.parent}/index.html (all releases)")
    logger.info("\n".join([*lines, f"Log:     {keep_log(logs)}"]))


def end_badly(logs):
    keep_first_seen()
    # a log that changed without a trace in its times must not stop the next run as well
    with suppress(OSError):
        KEPT_DIGESTS.forget()
    logger.error(f"The run failed. The reason is printed above and in {keep_log(logs).parent}.")
