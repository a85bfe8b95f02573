"""Traction-rig logs to validated datasets, traction-law constants and figures."""
