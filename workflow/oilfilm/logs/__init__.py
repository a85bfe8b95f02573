"""Raw files to samples, each format in a module of its name.

No reader is imported here, so that the Snakefile loads `raw_files` alone.

`text_of_key` and `unit_by_quantity` are names of mappings: key -> text, quantity -> unit.
"""
