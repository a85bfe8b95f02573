"""The command `oilfilm export`: the constants that the paper prints, for bearing codes."""

import argparse

import oilfilm
from oilfilm.atomic_write import write_bytes
from oilfilm.digests import file_digest
from oilfilm.errors import OilfilmError
from oilfilm.exports.campaign import in_folders
from oilfilm.home import CONFIG, portable, reference_file
from oilfilm.paper.study import describe_printed
from oilfilm.settings.resolve import read_config


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    path = reference_file("printed_coefficients")
    config = read_config(CONFIG)
    fits = describe_printed(path, config.printed.boxes.tested, config.exports)
    if options.oil is not None:
        fits = [fit for fit in fits if fit.oil == options.oil]
    provenance = {
        "code": f"oilfilm {oilfilm.__version__}",
        "settings": None,
        "inputs": {portable(path.resolve()): file_digest(path)},
    }
    if options.folder.exists():
        raise OilfilmError(f"{options.folder}: exists already. Name a new folder.")
    for name, content in in_folders(fits, provenance).items():
        write_bytes(content, options.folder / name)
        print(options.folder / name)
    return 0
