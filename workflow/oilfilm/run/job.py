"""The frame of every script of the workflow around its one call of the library.

A share is a part of the logs of a campaign, which one job reads. Its files are below `parts/`. The
rows of a table that are in memory at one time are a block.

Decides: the provenance in the footer of every table.
"""

import gc
import sys
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, NoReturn, TextIO

import pandas as pd

from oilfilm import tables
from oilfilm.base.atomic_write import write_text
from oilfilm.base.digests import file_digest, files_of, mapping_digest, path_digest
from oilfilm.base.errors import OilfilmError
from oilfilm.base.home import project_path
from oilfilm.logs.raw_files import RawLogs, listing_text, read_listings
from oilfilm.releases.step_outputs import StepOutputs
from oilfilm.run.start import job_lock, machine_fault
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables, declaration_name


@dataclass(frozen=True)
class Job:
    """Settings, tables and provenance of a script.

    Attributes:
        snakemake: The object that Snakemake passes to a script.
        settings: The settings that the rule lists as `config`.
        provenance: Provenance of the tables that the script writes: the campaign, whether its data
            are simulated, digests of code, settings and inputs. It has no clock, no host and no
            path outside the project.
    """

    snakemake: Any
    settings: Settings
    provenance: dict[str, Any]

    @cached_property
    def input_tables(self) -> CampaignTables:
        """The tables among the inputs; each is read when it is first used."""
        return CampaignTables.from_job(self.snakemake.input)

    def write(self, frame_by_table: Mapping[str, pd.DataFrame]) -> None:
        """Write each table to the output that the rule names after it.

        Raises:
            OilfilmError: As in `tables.write`.
        """
        for table_name, frame in frame_by_table.items():
            path = Path(self.snakemake.output[table_name])
            tables.write(frame, declaration_name(table_name), path, self.provenance)

    def write_stacked(self, table_names: Iterable[str]) -> None:
        """Write tables whose inputs are the tables of all shares, one below the other.

        One block of rows is in memory at a time.

        Raises:
            OilfilmError: As in `tables.write`.
        """
        for table_name in table_names:
            path = Path(self.snakemake.output[table_name])
            blocks = self.input_tables.blocks(table_name)
            tables.write_blocks(blocks, declaration_name(table_name), path, self.provenance)

    def raw_logs(self, folder_name: str) -> RawLogs:
        """The raw logs: the inputs `logs`, in the order of the params `files`.

        `files` has the name and the digest of each log. Reading a measured log adds its digest to
        the provenance.

        Args:
            folder_name: Name of their folder below data/raw.
        """
        inputs = self.snakemake.input
        # the digest of a simulated log is None: the listing of the rig twin has it
        digest_of_log = self.snakemake.params.files
        paths = [Path(path) for path in inputs.get("logs", [])]
        is_simulated = bool(inputs.get("listing"))
        return RawLogs(
            Path("data/raw", folder_name),
            dict(zip(digest_of_log, paths, strict=True)),
            read_listings(Path(inputs.listing)) if is_simulated else digest_of_log,
            is_simulated,
            self.provenance["inputs"],
        )


@contextmanager
def job(snakemake: Any) -> Iterator[Job]:
    """The frame of a script: settings, tables and provenance; a mistake ends in a sentence.

    A script appends its remarks to its log.
    """
    # a job makes few reference cycles and ends soon
    gc.freeze()
    gc.set_threshold(50_000)
    log_path = Path(snakemake.log[0])
    try:
        with job_lock(Path(".snakemake")):
            log_path.write_text("", encoding="utf-8")
            _refuse_altered_inputs(snakemake)
            settings = Settings.from_plain_values(snakemake.params.config)
            yield Job(snakemake, settings, _provenance(snakemake, settings))
            _write_output_digests(snakemake.output)
            with log_path.open("a", encoding="utf-8") as remarks:
                remarks.write("done\n")
    except OilfilmError as mistake:
        _end_script(str(mistake), log_path)
    except OSError as error:
        fault = machine_fault(error)
        if not fault:
            raise
        _end_script(f"{fault} ({error}). Finished steps are kept: run snakemake again.", log_path)
    except MemoryError:
        _end_script(
            "There is not enough memory for this step. Free some or raise the limit of the job, "
            "then run snakemake again. A smaller `split.runs` in config.yaml makes the shares of "
            "the logs smaller.",
            log_path,
        )


def _refuse_altered_inputs(snakemake: Any) -> None:
    """Refuse an input below `results/` if its bytes are not those that its step wrote.

    A file that no step has listed passes.

    Raises:
        OilfilmError: An input was changed by hand.
    """
    result_paths = [
        path for path in map(Path, snakemake.input) if project_path(path).startswith("results/")
    ]
    listing_path = snakemake.output.get("made")
    if not result_paths or not listing_path:
        return
    listed_outputs = StepOutputs.from_listings(Path(listing_path).parent.glob("*.sha256"))
    for path in result_paths:
        for file in files_of(path):
            if project_path(file) in listed_outputs.digest_by_path:
                listed_outputs.refuse_altered(project_path(file), file)


def _write_output_digests(outputs: Any) -> None:
    """Write the sha256 of every output to the output `made`.

    A later step compares the file with it.
    """
    listing_path = outputs.get("made")
    if not listing_path:
        return
    digest_by_path = {}
    for path in outputs:
        if path != listing_path:
            for file in files_of(Path(path)):
                digest_by_path[project_path(file)] = file_digest(file)
    write_text(listing_text(digest_by_path), Path(listing_path))


def print_line(text: str, stream: TextIO = sys.stdout) -> None:
    """Print a text; on a terminal it replaces the line of progress."""
    print(f"\x1b[K{text}" if stream.isatty() else text, file=stream, flush=True)


def _end_script(sentence: str, log_path: Path) -> NoReturn:
    """End the script with a sentence in its log and on the terminal."""
    with suppress(OSError):  # the disk may be full
        log_path.write_text(f"{sentence}\n", encoding="utf-8")
    print_line(sentence, sys.stderr)
    sys.exit(1)


def _provenance(snakemake: Any, settings: Settings) -> dict[str, Any]:
    """Provenance of the tables of a job, as in `Job`. The key `part` marks tables of one share."""
    plain_settings = settings.plain_values()
    provenance = {
        "campaign": settings.campaign.name,
        "data": settings.campaign.data,
        "rule": snakemake.rule,
        "code": snakemake.params.code,
        "settings": mapping_digest(plain_settings)[:16],
    }
    for name in ("film", "gates"):
        if name in plain_settings:
            provenance[name] = plain_settings[name]
    sheet = getattr(snakemake.params, "sheet", None)
    if sheet:
        provenance["run_sheet"] = mapping_digest(sheet)[:16]
    raw_logs = set(snakemake.input.get("logs", []))  # they are added when they are read
    inputs = _input_digests([Path(path) for path in snakemake.input if path not in raw_logs])
    # a job with other wildcards has one share of the logs, which depends on `split.runs`
    is_of_share = bool(set(snakemake.wildcards.keys()) - {"oil", "law_file"})
    if is_of_share:
        provenance["part"] = True
        provenance["inputs"] = inputs
    else:
        provenance["inputs"] = digests_by_folder(inputs)
    return provenance


def _input_digests(paths: list[Path]) -> dict[str, str]:
    """Digest of each input. A table of a share is replaced by the inputs of that share.

    So the digests do not depend on how the logs were divided.
    """
    digest_by_name: dict[str, str] = {}
    for path in paths:
        name = project_path(path)
        is_of_share = "/parts/" in name
        if is_of_share and path.suffix == ".sha256":
            continue  # the tables of the share name these logs
        may_be_of_share = path.suffix == ".parquet" and (is_of_share or "/tables/samples/" in name)
        footer = tables.read_footer(path) if may_be_of_share else {}
        if footer.get("part"):
            digest_by_name |= footer["inputs"]
            digest_by_name[f"rule {footer['rule']}"] = (
                f"code {footer['code']}, {footer['settings']}"
            )
        else:
            digest_by_name[name] = path_digest(path)[:16]
    return digest_by_name


def digests_by_folder(digest_by_path: Mapping[str, str]) -> dict[str, str]:
    """The digests of inputs, with one digest for each folder of raw logs: a footer stays short.

    Args:
        digest_by_path: Digest of each input. A key that is already a folder of logs stays as it is.
    """
    digest_of_input = {}
    digests_of_logs_by_folder: dict[str, dict[str, str]] = {}
    for path, digest in digest_by_path.items():
        *folders, _ = path.split("/")
        if folders[:2] == ["data", "raw"] and len(folders) > 2:
            folder = "/".join(folders[:3])
            digests_of_logs_by_folder.setdefault(folder, {})[path] = digest
        else:
            digest_of_input[path] = digest
    for folder, digest_by_log in digests_of_logs_by_folder.items():
        digest_of_input[folder] = mapping_digest(digest_by_log)[:16]
    return digest_of_input
