# Decides: which settings, files and code rerun a rule (`part`, `finished`, `code`); paths of
# results; which folders of `data/raw` have the traction logs and the torque logs of a campaign.

import json
import mimetypes
from functools import cache
from hashlib import sha256
from pathlib import Path

from snakemake.exceptions import WorkflowError
from snakemake.io import report as in_report  # at the start of a line `report` is a directive

from oilfilm import home, studies
from oilfilm.atomic_write import write_text
from oilfilm.digests import code_digest, file_digest
from oilfilm.errors import OilfilmError
from oilfilm.home import HOME, PACKAGE
from oilfilm.logs.raw_files import find_sheet, raw_files, shares_of
from oilfilm.releases.tree import code_tree_digest
from oilfilm.rig_twin.plan import planned_runs, planned_torque_runs
from oilfilm.run.start import bring_dates_back, check_machine, lock_run, start_python_by_name
from oilfilm.settings.resolve import resolve_given
from oilfilm.table_needs import NOT_IN_EVERY_CAMPAIGN, OF_FIT, lacking
from oilfilm.tables.contract import contract_digest
from oilfilm.traction import LAW_FILES

RECORDS = Path(".snakemake")
# What a run found when it began, for its jobs on a cluster: they start later.
FOUND = RECORDS / "oilfilm-logs.json"

# In Snakemake's report a table is a file to save, not a text to show.
mimetypes.add_type("application/vnd.apache.parquet", ".parquet")
start_python_by_name()
if workflow.storage_registry.default_storage_provider is not None:
    if not workflow.storage_settings.default_storage_prefix:
        raise WorkflowError(
            "--default-storage-provider needs --default-storage-prefix, as s3://BUCKET/PLACE."
        )


def prefixed(*place):
    """A path with the prefix that another workflow gives this one; while the Snakefile is parsed."""
    return Path(workflow.modifier.path_modifier.replace_prefix(Path(*place).as_posix()))


try:
    check_machine([RECORDS, prefixed("results")])
    typed = workflow.config_settings.overwrite_config
    SETTINGS = resolve_given(config, typed)
except OilfilmError as mistake:
    raise WorkflowError(str(mistake)) from None

CAMPAIGN = SETTINGS.campaign
OILS = list(SETTINGS.oils)
# The parts of the settings that a rule depends on.
part = SETTINGS.part
# Keys of the campaign that say where its data are from.
ORIGIN = ("credit", "simulated_by", "twin")

RAW = Path("data/raw", CAMPAIGN.name)
TORQUE_RAW = Path("data/raw", f"{CAMPAIGN.name}-torque")
SIMULATED = CAMPAIGN.twin is not None
TORQUE_SIMULATED = CAMPAIGN.torque is not None and CAMPAIGN.torque.twin is not None
TWINS = [*[RAW] * SIMULATED, *[TORQUE_RAW] * TORQUE_SIMULATED]
RESULTS = prefixed("results", CAMPAIGN.name)
# Folders of what a run writes.
WRITTEN = [RESULTS, *map(prefixed, TWINS)]


pathvars:
    tables=f"results/{CAMPAIGN.name}/tables",
    parts=f"results/{CAMPAIGN.name}/parts",
    figures=f"results/{CAMPAIGN.name}/figures",
    logs=f"results/{CAMPAIGN.name}/logs",
    results=f"results/{CAMPAIGN.name}",


wildcard_constraints:
    shard=r"\d+",
    oil="|".join(OILS),


# ---------------------------------------------------------------- raw logs


def logs_found():
    """Names of all logs of the campaign, by their folder."""
    if not workflow.is_main_process and FOUND.is_file():
        return json.loads(FOUND.read_text(encoding="utf-8"))
    logs = {RAW.as_posix(): [run.name for run in planned_runs(CAMPAIGN)] if SIMULATED else None}
    if CAMPAIGN.torque is not None:
        planned = [run.name for run in planned_torque_runs(CAMPAIGN)] if TORQUE_SIMULATED else None
        logs[TORQUE_RAW.as_posix()] = planned
    return {name: raw_files(Path(name)) if of is None else of for name, of in logs.items()}


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
    raise WorkflowError(str(mistake)) from None

FILES_OF_SHARE = shares_of(FILES, SETTINGS.split.runs)
SHARDS = list(FILES_OF_SHARE)
# The samples of one share. Patterns are texts of their own where several rules expand them: an
# output of a rule that is kept in object storage cannot be expanded.
SAMPLES = [f"<tables>/samples/oil={oil}/part-{{shard}}.parquet" for oil in OILS]


def raw_logs(folder, files):
    """Raw logs as inputs; what the rig twin writes is a result like others."""
    paths = [f"{folder.as_posix()}/{file}" for file in files]
    return paths if folder in TWINS else list(map(local, paths))


def sheet_rows(folder, files, remarks=True):
    """The rows of the run sheet on some logs; remarks on it as a whole belong to one of the jobs."""
    sheet = SHEETS.get(folder)
    return sheet.plain(files, remarks=remarks) if sheet else {}


def digests_of_sheets():
    """Digest of each run sheet by its path."""
    paths = [find_sheet(folder) for folder, sheet in SHEETS.items() if sheet is not None]
    return {path.as_posix(): sha256(path.read_bytes()).hexdigest() for path in paths}


# Changes of measured logs that are meant; another run refuses them.
ACKNOWLEDGED = [change.model_dump() for change in SETTINGS.dataset.acknowledged_changes]

# ---------------------------------------------------------------- tables and code


def finished(*names):
    """Files of finished tables by name; no file of a table that this campaign does not have."""
    missing = lacking(CAMPAIGN)
    return {name: [] if name in missing else f"<tables>/{name}.parquet" for name in names}


# Tables that the rules of this campaign write, for the report and its data package.
TABLES = []


def written(*names):
    """Files of tables that a rule writes, by name; as `finished`."""
    files = finished(*names)
    TABLES.extend(files)
    return files


# The fits of every law, from which the tables of bearings are computed.
FITTED = ("coefficients", "fit_quality", "refits")
# Lists of what every step has written, for `release`.
MADE = []


def made(name, **wildcards):
    """File in which a step lists the sha256 of its outputs when it ends."""
    path = f"<results>/made/{name}.sha256"
    MADE.extend(expand(path, **wildcards) if wildcards else [path])
    return path


def reference_file(name):
    """A file of data/reference; it stays in the folder where results go to object storage."""
    return local(home.reference_file(name).as_posix())


# A release must not name packages that its results were not made with.
PACKAGES = file_digest(HOME / home.RUN_LOCK)[:8]
# Modules of the campaign's studies: no import of what loads them leads there.
STUDIES = [PACKAGE / name / "study.py" for name in CAMPAIGN.studies]
# What columns and tables mean, for the rules that print it.
TABLE_WORDS = [
    *sorted((PACKAGE / "tables").glob("*.*")),
    *(path for name in CAMPAIGN.studies for path in sorted((PACKAGE / name).glob("tables.*"))),
]
studies.declare_tables(CAMPAIGN.studies)


@cache
def digest_of_code(script, modules, tables):
    computes = code_digest(HOME / "workflow/scripts" / script, *modules)
    return f"{computes}-{contract_digest(tables)}-{PACKAGES}"


def code(script, *modules, tables=()):
    """Digest of a script and the modules behind it, of tables as declared, and of the packages.

    A law that the script takes by its name is no import: its module is among `modules`. `tables`
    are the outputs of the rule by name: those that it writes, whose names are known afterwards.
    """
    return digest_of_code(script, modules, tuple(tables))
