"""Renews every generated file: `generate.py [FOLDER OF A FINISHED CAMPAIGN ...]`.

With folders, the examples of the page of tables are renewed first, from the tables in them.
"""

import sys
from pathlib import Path

from oilfilm.base.home import HOME
from reference_pages import GENERATED
from reference_pages.table_examples import write_examples

if __name__ == "__main__":
    if len(sys.argv) > 1:
        write_examples(*map(Path, sys.argv[1:]))
    for path, text in GENERATED.items():
        (HOME / path).write_text(text(), encoding="utf-8", newline="\n")
