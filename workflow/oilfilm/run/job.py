"""What every script of the workflow does around its one call of the library.

Decides: the provenance in the footer of every table.
"""

import gc
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, NoReturn, TextIO

import pandas as pd

from oilfilm import tables
from oilfilm.atomic_write import write_text
from oilfilm.digests import file_digest, files_of, input_digest, settings_digest
from oilfilm.errors import OilfilmError
from oilfilm.home import portable
from oilfilm.logs.raw_files import RawLogs, listing, read_listings
from oilfilm.run.start import job_lock, machine_fault
from oilfilm.settings.resolved import Settings
from oilfilm.tables.campaign_tables import CampaignTables, model_of


@dataclass(frozen=True)
class Job:
    """What a script gets.

    Attributes:
        snakemake: The object that Snakemake gives to a script.
        settings: Those that the rule lists as `config`.
        provenance: Of the tables that it writes: which campaign, whether its data are simulated,
            digests of code, settings and inputs; no clock, no host, no path outside the project.
    """

    snakemake: Any
    settings: Settings
    provenance: dict[str, Any]

    @cached_property
    def tables(self) -> CampaignTables:
        """The tables among the inputs, read when they are first used."""
        return CampaignTables.of_job(self.snakemake.input)

    def write(self, frames: Mapping[str, pd.DataFrame]) -> None:
        """Write each table to the output that the rule names after it.

        Raises:
            OilfilmError: As `tables.write`.
        """
        for name, frame in frames.items():
            path = Path(self.snakemake.output[name])
            tables.write(frame, model_of(name), path, self.provenance)

    def raw_logs(self, folder: str) -> RawLogs:
        """The raw logs: the inputs `logs`, whose names and digests are the params `files`.

        Args:
            folder: Name of their folder below data/raw. Measured logs become inputs in the
                provenance when they are read.
        """
        inputs, files = self.snakemake.input, self.snakemake.params.files
        paths = dict(zip(files, map(Path, inputs.get("logs", [])), strict=True))
        simulated = bool(inputs.get("listing"))
        expected = read_listings(Path(inputs.listing)) if simulated else files
        made_of = self.provenance["inputs"]
        return RawLogs(Path("data/raw", folder), paths, expected, simulated, made_of)


@contextmanager
def job(snakemake: Any) -> Iterator[Job]:
    """Give a script its settings, tables and provenance; end a mistake in a sentence.

    A script appends its remarks to its log.
    """
    # a job makes few cycles and ends soon
    gc.freeze()
    gc.set_threshold(50_000)
    log = Path(snakemake.log[0])
    try:
        with job_lock(Path(".snakemake")):
            log.write_text("", encoding="utf-8")
            settings = Settings.of(snakemake.params.config)
            yield Job(snakemake, settings, _provenance(snakemake, settings))
            _write_digests(snakemake.output)
            with log.open("a", encoding="utf-8") as remarks:
                remarks.write("done\n")
    except OilfilmError as mistake:
        _end(str(mistake), log)
    except OSError as error:
        if not (fault := machine_fault(error)):
            raise
        _end(f"{fault} ({error}). Finished steps are kept: run snakemake again.", log)
    except MemoryError:
        _end(
            "There is not enough memory for this step. Free some or raise the limit of the job, "
            "then run snakemake again. Shares of the logs are as large as `split.runs` of "
            "config.yaml allows.",
            log,
        )


def _write_digests(outputs: Any) -> None:
    """Write the sha256 of every output to the output `made`; a release compares them."""
    if made := outputs.get("made"):
        files = [file for path in outputs if path != made for file in files_of(Path(path))]
        write_text(listing({portable(file): file_digest(file) for file in files}), Path(made))


def say(text: str, stream: TextIO = sys.stdout) -> None:
    """Print a text; at a terminal it takes the place of the line of progress."""
    print(f"\x1b[K{text}" if stream.isatty() else text, file=stream, flush=True)


def _end(sentence: str, log: Path) -> NoReturn:
    with suppress(OSError):  # the disk may be full
        log.write_text(f"{sentence}\n", encoding="utf-8")
    say(sentence, sys.stderr)
    sys.exit(1)


def _provenance(snakemake: Any, settings: Settings) -> dict[str, Any]:
    plain = settings.plain()
    sheet = getattr(snakemake.params, "sheet", None)
    # a share of the logs: another split makes other parts
    part = bool(set(snakemake.wildcards.keys()) - {"oil", "law_file"})
    raw = set(snakemake.input.get("logs", []))  # they are added when they are read
    inputs = _input_digests([Path(path) for path in snakemake.input if path not in raw])
    return {
        "campaign": settings.campaign.name,
        "data": settings.campaign.data,
        "rule": snakemake.rule,
        "code": snakemake.params.code,
        "settings": settings_digest(plain)[:16],
        **{key: plain[key] for key in ("film", "gates") if key in plain},
        **({"run_sheet": settings_digest(sheet)[:16]} if sheet else {}),
        **({"part": True} if part else {}),
        "inputs": inputs if part else by_folder(inputs),
    }


def _input_digests(paths: list[Path]) -> dict[str, str]:
    """Digest of each input; of a part of a step, what it was made from: no split must show."""
    inputs: dict[str, str] = {}
    for path in paths:
        name = portable(path)
        if path.suffix == ".sha256" and "/parts/" in name:
            continue  # the digests of logs that the tables of the part name
        of_part = path.suffix == ".parquet" and ("/parts/" in name or "/tables/samples/" in name)
        footer = tables.read_footer(path) if of_part else {}
        if footer.get("part"):
            inputs |= footer["inputs"]
            inputs[f"rule {footer['rule']}"] = f"code {footer['code']}, {footer['settings']}"
        else:
            inputs[name] = input_digest(path)[:16]
    return inputs


def by_folder(inputs: Mapping[str, str]) -> dict[str, str]:
    """The digests with one for all raw logs of a campaign: a footer must not grow with them.

    Args:
        inputs: Digest of each input; folders that stand for their logs already are kept.
    """
    others = dict(inputs)
    logs: dict[str, dict[str, str]] = {}
    for path in inputs:
        *folders, _ = path.split("/")
        if folders[:2] == ["data", "raw"] and len(folders) > 2:
            logs.setdefault("/".join(folders[:3]), {})[path] = others.pop(path)
    return others | {folder: settings_digest(of_it)[:16] for folder, of_it in logs.items()}
