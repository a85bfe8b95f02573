"""What surrounds a job of the workflow: one run at a time, its log and its provenance."""

import gc

# Searching for cycles among what is imported takes a twentieth of a job's start and finds none:
# a script imports this room first.
gc.set_threshold(500_000)
