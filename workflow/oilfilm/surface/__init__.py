"""What measured traction says without a law: surface, support, interval, effects of runs."""
