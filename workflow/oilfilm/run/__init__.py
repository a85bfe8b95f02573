"""What surrounds a job of the workflow: one run at a time, its log and its provenance."""
