"""Modules that every room may use: errors, units, files, digests, ties, declarations."""
