"""Tables about the paper: verdicts on its constants and claims, and its advice on oils.

`tables.yaml` declares them.

Decides: columns and key of the tables of the paper.
"""

from pathlib import Path

from oilfilm.tables.dictionary import declare

declare(Path(__file__).with_name("tables.yaml"))
