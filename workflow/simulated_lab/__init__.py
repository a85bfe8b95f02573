"""Simulated rig logs for the demonstration campaigns: everything here says that it is simulated."""

import simulated_lab.tables  # noqa: F401 - makes its tables known
