# Decides: which settings, files and code rerun a rule (`part`, `finished`, `code`); paths of
# results; which folders of `data/raw` have the traction logs and the torque logs of a campaign.

import mimetypes
import sys
from functools import cache
from pathlib import Path

from snakemake.io import report as in_report  # at the start of a line `report` is a directive
from snakemake.settings.types import DeploymentMethod

from oilfilm.base import home, studies
from oilfilm.base.digests import code_digest, file_digest
from oilfilm.base.errors import OilfilmError
from oilfilm.base.home import HOME, PACKAGE
from oilfilm.releases.tree import code_tree_digest
from oilfilm.run.start import (
    bring_dates_back,
    check_image,
    check_machine,
    lock_run,
    start_python_by_name,
)
from oilfilm.settings.resolve import resolve_given
from oilfilm.tables.contract import contract_digest
from oilfilm.tables.table_needs import NOT_IN_EVERY_CAMPAIGN, FIT_TABLES, SURFACE_TABLES, lacking
from oilfilm.traction import LAW_FILES

RECORDS = Path(".snakemake")


def stop(mistake):
    """End the run with a sentence alone. An error of Snakemake would add files and lines of rules."""
    sys.exit(str(mistake))


# In Snakemake's report a table is a file to save, not a text to show.
mimetypes.add_type("application/vnd.apache.parquet", ".parquet")
start_python_by_name()
OBJECT_STORAGE = workflow.storage_registry.default_storage_provider
if OBJECT_STORAGE is not None:
    if not workflow.storage_settings.default_storage_prefix:
        stop("--default-storage-provider needs --default-storage-prefix, as s3://BUCKET/PLACE.")


def prefixed(*parts):
    """A path with the prefix that another workflow gives this one; while the Snakefile is parsed."""
    return Path(workflow.modifier.path_modifier.replace_prefix(Path(*parts).as_posix()))


try:
    check_machine([RECORDS, prefixed("results")])
    typed = workflow.config_settings.overwrite_config
    SETTINGS = resolve_given(config, typed)
    if DeploymentMethod.APPTAINER in workflow.deployment_settings.deployment_method:
        check_image(SETTINGS.container)
except OilfilmError as mistake:
    stop(mistake)

CAMPAIGN = SETTINGS.campaign
OILS = list(SETTINGS.oils)
# The parts of the settings that a rule depends on.
part = SETTINGS.part
# Keys of the campaign with the origin of its data.
ORIGIN = ("credit", "simulated_by", "twin")

RAW = Path("data/raw", CAMPAIGN.name)
TORQUE_RAW = Path("data/raw", f"{CAMPAIGN.name}-torque")
SIMULATED = CAMPAIGN.twin is not None
TORQUE_SIMULATED = CAMPAIGN.torque is not None and CAMPAIGN.torque.twin is not None
# Folders of simulated logs.
TWINS = []
if SIMULATED:
    TWINS.append(RAW)
if TORQUE_SIMULATED:
    TWINS.append(TORQUE_RAW)
RESULTS = prefixed("results", CAMPAIGN.name)
# Folder of the digests that measured logs had when a run first read them.
FIRST_SEEN = prefixed("data/first_seen").as_posix()
# Folders that a run writes to.
WRITTEN = [RESULTS] + [prefixed(folder) for folder in TWINS]


# With `--sdm apptainer` each step runs in this image, else Snakemake ignores it.
container: None if SETTINGS.container == "none" else SETTINGS.container


pathvars:
    tables=f"results/{CAMPAIGN.name}/tables",
    parts=f"results/{CAMPAIGN.name}/parts",
    figures=f"results/{CAMPAIGN.name}/figures",
    logs=f"results/{CAMPAIGN.name}/logs",
    results=f"results/{CAMPAIGN.name}",


wildcard_constraints:
    shard=r"\d+",
    oil="|".join(OILS),


# ---------------------------------------------------------------- tables and code


def finished(*names):
    """Files of finished tables by name; an empty list for a table that this campaign lacks."""
    missing = lacking(CAMPAIGN)
    return {name: [] if name in missing else f"<tables>/{name}.parquet" for name in names}


# Tables that the rules of this campaign write, for the report and its data package.
TABLES = []


def written(*names):
    """Files of tables that a rule writes, by name; as in `finished`."""
    files = finished(*names)
    TABLES.extend(files)
    return files


# The fits of every law, from which the tables of bearings are computed.
FITTED = ("coefficients", "fit_quality", "refits", "surfaces")
# Files in which each step lists its outputs, for `release`.
MADE = []


def made(name, **wildcards):
    """File in which a step lists the sha256 of its outputs when it ends."""
    path = f"<results>/made/{name}.sha256"
    MADE.extend(expand(path, **wildcards) if wildcards else [path])
    return path


def reference_file(name):
    """A file of reference data; it stays in the folder where results go to object storage."""
    return local(home.reference_file(name).as_posix())


def references_of_studies(purpose):
    """Reference files that the campaign's studies need for the report or the exports."""
    return list(map(reference_file, studies.reference_names(CAMPAIGN.studies, purpose)))


# A release must not name packages that its results were not made with.
PACKAGES = file_digest(HOME / home.RUN_LOCK)[:8]
# Modules of the campaign's studies, which no module imports by name.
STUDIES = studies.study_files(CAMPAIGN.studies)
# Declarations of columns and tables, for the rules that print their meaning.
TABLE_WORDS = sorted((PACKAGE / "tables").glob("*.*"))
for study_name in CAMPAIGN.studies:
    TABLE_WORDS += sorted(studies.folder(study_name).glob("tables.*"))
studies.declare_tables(CAMPAIGN.studies)


@cache
def digest_of_code(script, modules, tables):
    computes = code_digest(HOME / "workflow/scripts" / script, *modules)
    return f"{computes}-{contract_digest(tables)}-{PACKAGES}"


def code(script, *modules, tables=()):
    """Digest of a script and the modules behind it, of declared tables, and of the packages.

    A law that the script takes by its name is not imported. So its module is among `modules`.
    `tables` are names of outputs; names that are no tables do not count.
    """
    return digest_of_code(script, modules, tuple(tables))
