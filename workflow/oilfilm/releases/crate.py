"""Where a release came from, for other programs: a Workflow Run RO-Crate (profile 0.5).

One action, the run, made the release's files from the raw logs and the configuration by the
workflow under `code`. Who ran it and when is not said: a release must not depend on either.
"""

from collections.abc import Sequence
from mimetypes import MimeTypes
from typing import Any

from rocrate.model import ComputationalWorkflow, ContextEntity, File
from rocrate.model.entity import Entity
from rocrate.rocrate import ROCrate

from oilfilm.releases.manifest import (
    CODE,
    CONFIG,
    ENVIRONMENT,
    LOCK,
    FileRecord,
    MadeFrom,
    canonical,
)
from oilfilm.settings.resolved import Settings

CRATE = "ro-crate-metadata.json"
_WORKFLOW = f"{CODE}/Snakefile"
# The version of RO-Crate that the profiles below are written for.
_RO_CRATE = "1.1"
_PROFILES = {
    "https://w3id.org/ro/wfrun/process/0.5": "Process Run Crate",
    "https://w3id.org/ro/wfrun/workflow/0.5": "Workflow Run Crate",
    "https://w3id.org/workflowhub/workflow-ro-crate/1.0": "Workflow RO-Crate",
}
# Where `sha256` of a file is defined.
_CONTEXT = "https://w3id.org/ro/terms/workflow-run/context"
_BIOSCHEMAS = "https://bioschemas.org/profiles/ComputationalWorkflow/1.0-RELEASE"
# The types that Python knows itself, whatever the system adds; other files are text.
_MEDIA_TYPES = MimeTypes()
_MEDIA_TYPES.add_type("application/vnd.apache.parquet", ".parquet")
_MEDIA_TYPES.add_type("application/yaml", ".yaml")


def run_crate(settings: Settings, made_from: MadeFrom, files: Sequence[FileRecord]) -> str:
    """The text of `ro-crate-metadata.json`.

    Args:
        settings: All settings of the run.
        made_from: What the manifest says the release was made from.
        files: The files of the release, without the crate itself.
    """
    crate = ROCrate(version=_RO_CRATE)
    crate.metadata.extra_contexts.append(_CONTEXT)
    dataset, campaign = settings.dataset, settings.campaign
    crate.name = dataset.title or f"Traction campaign {campaign.name}"
    crate.description = f"{campaign.description} ({campaign.data} data)"
    crate.license = dataset.licence or "not stated"
    # from the configuration; the library would write down the time of day
    crate.datePublished = settings.release.date
    crate.root_dataset["version"] = made_from.version
    crate.root_dataset["conformsTo"] = [_profile(crate, *each) for each in _PROFILES.items()]
    crate.metadata["conformsTo"] = [
        {"@id": f"https://w3id.org/ro/crate/{_RO_CRATE}"},
        {"@id": "https://w3id.org/workflowhub/workflow-ro-crate/1.0"},
    ]
    made = {record.path: _file(crate, record) for record in files}
    logs = _raw(crate, made_from.raw)
    results = [file for path, file in made.items() if _is_result(path)]
    workflow = made[_WORKFLOW]
    _describe_workflow(crate, workflow, made_from)
    crate.mainEntity = workflow
    action = _add(
        crate,
        "#run",
        "CreateAction",
        name=f"Run of the campaign {campaign.name}",
        description="From raw logs to tables, fits, figures and exports, by snakemake.",
        instrument=workflow,
        object=[made[CONFIG], *logs],
        result=results,
        actionStatus="http://schema.org/CompletedActionStatus",
    )
    crate.root_dataset["mentions"] = action
    content = crate.metadata.generate()
    content["@graph"].sort(key=lambda entity: entity["@id"])
    return canonical(content)


def _is_result(path: str) -> bool:
    """Whether the run made a file; code, lock and environment are what it was made with."""
    return not path.startswith(f"{CODE}/") and path not in {CONFIG, ENVIRONMENT, LOCK}


def _add(crate: ROCrate, address: str, kind: str | list[str], **properties: Any) -> Entity:
    entity = crate.add(ContextEntity(crate, address, properties={"@type": kind}))
    for name, value in properties.items():
        entity[name] = value
    return entity


def _profile(crate: ROCrate, address: str, name: str) -> Entity:
    version = address.rpartition("/")[2]
    return _add(crate, address, "CreativeWork", name=name, version=version)


def _described(record: FileRecord) -> dict[str, Any]:
    return {
        "name": record.path,
        "contentSize": str(record.size),
        "sha256": record.sha256,
        "encodingFormat": _MEDIA_TYPES.guess_type(record.path)[0] or "text/plain",
    }


def _file(crate: ROCrate, record: FileRecord) -> Entity:
    kind = ComputationalWorkflow if record.path == _WORKFLOW else File
    return crate.add(kind(crate, dest_path=record.path, properties=_described(record)))


def _raw(crate: ROCrate, records: Sequence[FileRecord]) -> list[Entity]:
    """The raw logs, which are not in the release: named by their hashes (RFC 6920)."""
    # copies of one log are one thing with several names
    named: dict[str, list[FileRecord]] = {}
    for record in records:
        named.setdefault(record.sha256, []).append(record)
    logs = []
    for sha256, copies in named.items():
        log = crate.add(
            File(crate, source=f"nih:sha-256;{sha256}", properties=_described(copies[0]))
        )
        log["name"] = ", ".join(copy.path for copy in copies)
        logs.append(log)
    return logs


def _describe_workflow(crate: ROCrate, workflow: Entity, made_from: MadeFrom) -> None:
    workflow["version"] = made_from.code[:12]
    workflow["conformsTo"] = {"@id": _BIOSCHEMAS}
    workflow["programmingLanguage"] = _add(
        crate,
        "https://w3id.org/workflowhub/workflow-ro-crate#snakemake",
        "ComputerLanguage",
        name="Snakemake",
        identifier={"@id": "https://doi.org/10.1093/bioinformatics/bts480"},
        url={"@id": "https://snakemake.readthedocs.io"},
        version=made_from.environment.packages.get("snakemake", ""),
    )
