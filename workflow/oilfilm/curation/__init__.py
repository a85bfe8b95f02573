"""Samples to points: zero reference, plateaus, derived quantities, gates.

`curate.py` tells the story; the other modules hold one chapter each.
"""
