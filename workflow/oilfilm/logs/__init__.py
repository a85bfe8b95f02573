"""Raw files to samples, each format in a module of its name.

No reader is imported here, so that the Snakefile loads `raw_files` alone.
"""
