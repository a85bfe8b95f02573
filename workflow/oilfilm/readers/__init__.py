"""Raw files to samples.

No reader is imported here, so that the Snakefile loads `raw_files` alone.
"""
