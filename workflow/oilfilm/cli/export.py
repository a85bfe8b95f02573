"""The command `oilfilm export`: constants that a study has from print, for bearing codes."""

import argparse

import oilfilm
from oilfilm.base import studies
from oilfilm.base.atomic_write import write_bytes
from oilfilm.base.digests import file_digest
from oilfilm.base.errors import OilfilmError
from oilfilm.base.home import portable
from oilfilm.exports.campaign import export_oils


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    (study,) = studies.load(studies.available())
    published_fits, path = study.describe_published()
    fits = [fit for fit in published_fits if options.oil in (None, fit.oil)]
    if not fits:
        names = ", ".join(fit.oil for fit in published_fits)
        raise OilfilmError(f"--oil {options.oil!r}: no constants are printed of it; of {names}.")
    provenance = {
        "code": f"oilfilm {oilfilm.__version__}",
        "settings": None,
        "inputs": {portable(path.resolve()): file_digest(path)},
    }
    if options.folder.exists():
        raise OilfilmError(f"{options.folder}: exists already. Name a new folder.")
    for name, content in export_oils(fits, provenance).items():
        write_bytes(content, options.folder / name)
        print(options.folder / name)
    return 0
