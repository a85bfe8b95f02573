# Decides: which settings, files and code rerun a rule (`settings_part`, `finished`,
# `script_digest`); paths of results; which folders of `data/raw` have the traction logs and the
# torque logs of a campaign.

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
from oilfilm.releases.code_tree import code_tree_digest
from oilfilm.run.start import (
    reset_future_dates,
    check_image,
    check_machine,
    lock_run,
    make_python_findable_by_name,
)
from oilfilm.settings.resolve import resolve_snakemake_config
from oilfilm.tables.contract import contract_digest
from oilfilm.tables.table_needs import (
    OPTIONAL_TABLES,
    FIT_TABLES,
    SURFACE_TABLES,
    lacking_table_names,
)
from oilfilm.traction import LAW_FILES

SNAKEMAKE_FOLDER = Path(".snakemake")


def stop(mistake):
    """End the run with a sentence alone. An error of Snakemake would add files and lines of rules."""
    sys.exit(str(mistake))


# In Snakemake's report a table is a file to save, not a text to show.
mimetypes.add_type("application/vnd.apache.parquet", ".parquet")
make_python_findable_by_name()
OBJECT_STORAGE = workflow.storage_registry.default_storage_provider
if OBJECT_STORAGE is not None:
    if not workflow.storage_settings.default_storage_prefix:
        stop("--default-storage-provider needs --default-storage-prefix, as s3://BUCKET/PLACE.")


def prefixed(*path_parts):
    """A path with the prefix that another workflow gives this one; while the Snakefile is parsed."""
    return Path(workflow.modifier.path_modifier.replace_prefix(Path(*path_parts).as_posix()))


try:
    check_machine([SNAKEMAKE_FOLDER, prefixed("results")])
    typed_values = workflow.config_settings.overwrite_config  # by --config
    SETTINGS = resolve_snakemake_config(config, typed_values)
    if DeploymentMethod.APPTAINER in workflow.deployment_settings.deployment_method:
        check_image(SETTINGS.container)
except OilfilmError as mistake:
    stop(mistake)

CAMPAIGN = SETTINGS.campaign
OILS = list(SETTINGS.oils)
# Function of keys: the settings that a rule depends on, as its params `config`.
settings_part = SETTINGS.plain_part
# Keys of the campaign with the origin of its data.
ORIGIN_KEYS = ("credit", "simulated_by", "twin")

RAW_FOLDER = Path("data/raw", CAMPAIGN.name)
TORQUE_RAW_FOLDER = Path("data/raw", f"{CAMPAIGN.name}-torque")
SIMULATED = CAMPAIGN.twin is not None
TORQUE_SIMULATED = CAMPAIGN.torque is not None and CAMPAIGN.torque.twin is not None
# Folders of simulated logs.
SIMULATED_FOLDERS = []
if SIMULATED:
    SIMULATED_FOLDERS.append(RAW_FOLDER)
if TORQUE_SIMULATED:
    SIMULATED_FOLDERS.append(TORQUE_RAW_FOLDER)
RESULTS_FOLDER = prefixed("results", CAMPAIGN.name)
# Folder of the digests that measured logs had when a run first read them.
FIRST_SEEN_FOLDER = prefixed("data/first_seen").as_posix()
# Folders that a run writes to.
WRITTEN_FOLDERS = [RESULTS_FOLDER] + [prefixed(folder) for folder in SIMULATED_FOLDERS]


# With `--sdm apptainer` each step runs in this image, else Snakemake ignores it.
container: None if SETTINGS.container == "none" else SETTINGS.container


pathvars:
    tables=f"results/{CAMPAIGN.name}/tables",
    parts=f"results/{CAMPAIGN.name}/parts",
    figures=f"results/{CAMPAIGN.name}/figures",
    logs=f"results/{CAMPAIGN.name}/logs",
    results=f"results/{CAMPAIGN.name}",


wildcard_constraints:
    share=r"\d+",
    oil="|".join(OILS),


# ---------------------------------------------------------------- tables and code


def finished(*names):
    """Files of finished tables by name; an empty list for a table that this campaign lacks."""
    lacking_names = lacking_table_names(CAMPAIGN)
    return {name: [] if name in lacking_names else f"<tables>/{name}.parquet" for name in names}


# Names of the tables that the rules of this campaign write, for the report and its data package.
WRITTEN_TABLE_NAMES = []


def written(*names):
    """Files of tables that a rule writes, by name, as in `finished`."""
    files = finished(*names)
    WRITTEN_TABLE_NAMES.extend(files)
    return files


# Names of the tables of fits, from which the tables of bearings are computed.
FIT_TABLE_NAMES = ("coefficients", "fit_quality", "refits", "surfaces")
# The files in which steps list their outputs, for `release`.
STEP_LISTINGS = []


def step_listing(name, **wildcards):
    """The output `made` of a rule: the file in which its step lists the sha256 of its outputs."""
    path = f"<results>/made/{name}.sha256"
    STEP_LISTINGS.extend(expand(path, **wildcards) if wildcards else [path])
    return path


def reference_file(name):
    """A file of reference data; it stays in the folder where results go to object storage."""
    return local(home.reference_file(name).as_posix())


def references_of_studies(purpose):
    """Reference files that the campaign's studies need for the report or the exports."""
    return list(map(reference_file, studies.reference_names(CAMPAIGN.studies, purpose)))


# Digest of the locked packages: a release must not name packages that did not make its results.
PACKAGES_DIGEST = file_digest(HOME / home.REQUIREMENTS_LOCK_FILE)[:8]
# Modules of the campaign's studies, which no module imports by name.
STUDY_MODULES = studies.study_files(CAMPAIGN.studies)
# Declarations of columns and tables, for the rules that print their meaning.
TABLE_DECLARATIONS = sorted((PACKAGE / "tables").glob("*.*"))
for study_name in CAMPAIGN.studies:
    TABLE_DECLARATIONS += sorted(studies.folder(study_name).glob("tables.*"))
studies.declare_tables(CAMPAIGN.studies)


@cache
def cached_script_digest(script, modules, output_names):
    modules_digest = code_digest(HOME / "workflow/scripts" / script, *modules)
    return f"{modules_digest}-{contract_digest(output_names)}-{PACKAGES_DIGEST}"


def script_digest(script, *modules, tables=()):
    """Digest of a script and the modules behind it, of declared tables, and of the packages.

    A law that the script takes by its name is not imported. So its module is among `modules`.
    `tables` are names of outputs; names that are no tables do not count.
    """
    return cached_script_digest(script, modules, tuple(tables))
