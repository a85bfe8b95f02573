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


def locked(lock: str) -> list[str]:
    """Names of the packages of a lock, normalised, in order."""
    names = re.findall(r"(?m)^([A-Za-z0-9][A-Za-z0-9._-]*)==", lock)
    return sorted({re.sub(r"[-_.]+", "-", name).lower() for name in names})


def stated(about: metadata.PackageMetadata) -> str:
    """What a package says of its licence: as SPDX where that can be told, else in its words."""
    said: str | None = about.get("License-Expression")
    if said:
        return said
    classifiers = [
        each.rpartition(" :: ")[2]
        for each in about.get_all("Classifier", [])
        if each.startswith("License :: ")
    ]
    short = (about.get("License") or "").partition("\n")[0].strip()
    words = classifiers[0] if len(classifiers) == 1 else " / ".join(classifiers) or short
    return STATED.get(words, words)


def kept() -> dict[str, str]:
    """The table as it is: of packages for another platform or Python nothing else is known."""
    if not TABLE.is_file():
        return {}
    return dict(csv.reader(io.StringIO(TABLE.read_text(encoding="utf-8"))))


def licence(name: str) -> str:
    """The licence of a package, as an SPDX expression.

    Raises:
        ValueError: It is not known, or not allowed.
    """
    if name in READ:
        found = READ[name]
    else:
        try:
            found = stated(metadata.metadata(name))
        except metadata.PackageNotFoundError:
            found = kept().get(name, "nothing: it is not installed here; read it into the table")
    unknown = set(re.split(r" AND | OR |[()]", found)) - ALLOWED - {""}
    if unknown or not found:
        raise ValueError(
            f"{name}: states {found!r}; tests/lint/licences.py says which licences are allowed"
        )
    return found


def table() -> str:
    """The licences as csv."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(["package", "licence"])
    lock = (ROOT / "requirements/dev.lock").read_text(encoding="utf-8")
    mistakes = []
    for name in locked(lock):
        try:
            writer.writerow([name, licence(name)])
        except ValueError as mistake:
            mistakes.append(str(mistake))
    if mistakes:
        sys.exit("\n".join(mistakes))
    return text.getvalue()


if __name__ == "__main__":
    if "--write" in sys.argv:
        TABLE.write_text(table(), encoding="utf-8")
    elif TABLE.read_text(encoding="utf-8") != table():
        sys.exit(f"{TABLE.relative_to(ROOT)} is not what the locked packages state: make licences")
