"""Releases: finished runs that never change, and their comparison.

A release is a folder with all results of a campaign's run, what they were made from, and a
manifest with the hash of every file. Its version is a hash of what it was made from.
"""
