"""The command `oilfilm export`: constants that a study has from print, for bearing codes."""

import argparse

import oilfilm
from oilfilm.base import studies
from oilfilm.base.atomic_write import write_bytes
from oilfilm.base.digests import file_digest
from oilfilm.base.errors import OilfilmError
from oilfilm.base.home import project_path
from oilfilm.exports.campaign import export_oils


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    published = []
    digest_by_file = {}
    for study in studies.load_studies(studies.available()):
        if study.describe_published is not None:
            published_of_study, constants_file = study.describe_published()
            published += published_of_study
            digest_by_file[project_path(constants_file.resolve())] = file_digest(constants_file)
    descriptions = [
        description for description in published if options.oil in (None, description.oil)
    ]
    if not descriptions:
        oil_names = ", ".join(description.oil for description in published) or "none"
        raise OilfilmError(
            f"--oil {options.oil!r}: no constants are printed of it; of {oil_names}."
        )
    provenance = {
        "code": f"oilfilm {oilfilm.__version__}",
        "settings": None,
        "inputs": digest_by_file,
    }
    if options.folder.exists():
        raise OilfilmError(f"{options.folder}: exists already. Name a new folder.")
    for file_name, content in export_oils(descriptions, provenance).items():
        write_bytes(content, options.folder / file_name)
        print(options.folder / file_name)
    return 0
