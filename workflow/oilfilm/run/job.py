"""What every script of the workflow does around its one call of the library."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any, NoReturn, TextIO

from oilfilm.digests import input_digest, settings_digest
from oilfilm.errors import OilfilmError
from oilfilm.home import portable
from oilfilm.run.lock import job_lock
from oilfilm.run.start import machine_fault
from oilfilm.settings.resolved import Settings


@contextmanager
def job(snakemake: Any) -> Iterator[tuple[Settings, dict[str, Any]]]:
    """Give a script its settings and the provenance of its tables; end a mistake in a sentence.

    The settings are those that the rule lists as `config`. The provenance says which campaign,
    whether its data are simulated, and digests of code, settings and inputs: no clock, no host, no
    path outside the project. A script appends its remarks to its log.
    """
    log = Path(snakemake.log[0])
    try:
        with job_lock(Path(".snakemake")):
            log.write_text("", encoding="utf-8")
            settings = Settings.of(snakemake.params.config)
            yield settings, _provenance(snakemake, settings)
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
            "There is not enough memory for this step. Free some, raise the limit of the job, or "
            "raise `shards` in config.yaml, then run snakemake again.",
            log,
        )


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
    return {
        "campaign": settings.campaign.name,
        "data": settings.campaign.data,
        "rule": snakemake.rule,
        "code": snakemake.params.code,
        "settings": settings_digest(plain)[:16],
        **{key: plain[key] for key in ("film", "gates") if key in plain},
        **({"run_sheet": settings_digest(sheet)[:16]} if sheet else {}),
        "inputs": {portable(Path(path)): input_digest(Path(path))[:16] for path in snakemake.input},
    }
