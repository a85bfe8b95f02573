"""What every script of the workflow does around its one call of the library."""

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from oilfilm.errors import OilfilmError
from oilfilm.provenance import input_digest, settings_digest


@contextmanager
def job(snakemake: Any) -> Iterator[dict[str, Any]]:
    """Give a script the provenance of its tables, and end a user's mistake in a sentence.

    The provenance says which campaign, whether its data are simulated, and digests of code,
    settings and inputs: no clock, no host, no path outside the project. What a script has to say it
    appends to its log.
    """
    log = Path(snakemake.log[0])
    log.write_text("", encoding="utf-8")
    params = snakemake.params
    try:
        yield {
            "campaign": params.config["campaign"]["name"],
            "data": params.config["campaign"]["data"],
            "rule": snakemake.rule,
            "code": params.code,
            "settings": settings_digest(params.config)[:16],
            **{key: params.config[key] for key in ("film", "gates") if key in params.config},
            "inputs": {str(path): input_digest(Path(path))[:16] for path in snakemake.input},
        }
    except OilfilmError as mistake:
        log.write_text(f"{mistake}\n", encoding="utf-8")
        print(mistake, file=sys.stderr)
        sys.exit(1)
    with log.open("a", encoding="utf-8") as remarks:
        remarks.write("done\n")
