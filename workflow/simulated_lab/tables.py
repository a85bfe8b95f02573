"""Tables of what was planted in simulated logs; `tables.yaml` declares them.

Decides: columns and key of the tables of the truth behind simulated logs.
"""

from pathlib import Path

from oilfilm.tables.dictionary import declare

declare(Path(__file__).with_name("tables.yaml"))
