"""Releases: what a refit is worth next year.

A release is a folder that never changes: everything a campaign's run made, what it was made from,
and a manifest with the hash of every file. Its version is a hash of what it was made from.
"""
