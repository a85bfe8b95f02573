"""Simulated rig logs for the demonstration campaigns: everything here says that it is simulated."""
