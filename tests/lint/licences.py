"""The licence of every locked package: docs/licences.csv made (`make licences`) or checked.

A licence is what the package itself states, as an SPDX expression. A package that states one which
is not known here, or none, ends in a sentence: someone must read it before the project uses it.
"""

import csv
import io
import re
import sys
from importlib import metadata
from pathlib import Path

ROOT = Path(__file__).parents[2]
TABLE = ROOT / "docs/licences.csv"

# Permissive, or weak enough to bind nobody who only imports the package.
ALLOWED = {
    *("0BSD", "Apache-2.0", "BSD-2-Clause", "BSD-3-Clause", "CC0-1.0", "ISC", "MIT", "MIT-0"),
    *("MIT-CMU", "PSF-2.0", "Zlib", "Artistic-1.0-Perl"),
    *("LGPL-3.0-only", "MPL-2.0"),
}

# How packages without an SPDX expression say it: a classifier, or the first line of `License`.
STATED = {
    "MIT License": "MIT",
    "Apache Software License": "Apache-2.0",
    "Apache License, Version 2.0": "Apache-2.0",
    "BSD License": "BSD-3-Clause",
    "ISC License (ISCL)": "ISC",
    "Mozilla Public License 2.0 (MPL 2.0)": "MPL-2.0",
    "Python Software Foundation License": "PSF-2.0",
}

# What the metadata do not say, or say of several parts at once; from the packages' own files.
READ = {
    "axe-playwright-python": "MIT",
    "conda-inject": "MIT",
    "docutils": "BSD-2-Clause",  # most of it is in the public domain; its GPL part is for Emacs
    "packaging": "Apache-2.0 OR BSD-2-Clause",
    "python-dateutil": "BSD-3-Clause",  # it covers all of the code, Apache-2.0 the newer part too
    "snakemake-interface-common": "MIT",
    "snakemake-interface-logger-plugins": "MIT",
    "snakemake-interface-report-plugins": "MIT",
    "snakemake-interface-scheduler-plugins": "MIT",
    "snakemake-interface-storage-plugins": "MIT",
    "snakemake-logger-plugin-rich": "MIT",
    "text-unidecode": "Artistic-1.0-Perl",  # or the GPL, at the user's choice
}


def stated(name: str, kept: dict[str, str]) -> str:
    """The licence of a package as SPDX where that can be told, else in its words.

    Of packages for another platform or Python nothing but the table is known.
    """
    if name in READ:
        return READ[name]
    try:
        about = metadata.metadata(name)
    except metadata.PackageNotFoundError:
        return kept.get(name, "nothing: it is not installed here; read it into the table")
    classified = [each for each in about.get_all("Classifier", []) if "License :: " in each]
    words = (about.get("License") or "").partition("\n")[0].strip()
    if len(classified) == 1:
        words = classified[0].rpartition(" :: ")[2]
    return about.get("License-Expression") or STATED.get(words, words)


def table() -> str:
    """The licences as csv; ends the program where one is not known or not allowed."""
    lock = (ROOT / "requirements/dev.lock").read_text(encoding="utf-8")
    names = re.findall(r"(?m)^([A-Za-z0-9][A-Za-z0-9._-]*)(?:\[[^]]*\])?==", lock)
    kept = dict(csv.reader(io.StringIO(TABLE.read_text(encoding="utf-8"))))
    found = {
        name: stated(name, kept)
        for name in sorted({re.sub(r"[-_.]+", "-", each).lower() for each in names})
    }
    mistakes = [
        f"{name}: states {licence!r}; tests/lint/licences.py says which licences are allowed"
        for name, licence in found.items()
        if not licence or set(re.split(r" AND | OR |[()]", licence)) - ALLOWED - {""}
    ]
    if mistakes:
        sys.exit("\n".join(mistakes))
    return "".join(
        f"{name},{licence}\n" for name, licence in {"package": "licence", **found}.items()
    )


if __name__ == "__main__":
    if "--write" in sys.argv:
        TABLE.write_text(table(), encoding="utf-8")
    elif TABLE.read_text(encoding="utf-8") != table():
        sys.exit(f"{TABLE.relative_to(ROOT)} is not what the locked packages state: make licences")
