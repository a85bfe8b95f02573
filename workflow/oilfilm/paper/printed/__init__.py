"""The printed constants, judged: against a campaign's data and against the paper's own text."""
