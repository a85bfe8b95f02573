"""What surrounds a job of the workflow: one run at a time, its log and its provenance."""

import gc

# A process of a run makes few cycles and ends soon. Searching for them takes a tenth of its time,
# mostly while packages are imported: a script imports this room first.
gc.set_threshold(50_000)
