"""Raw files to samples, each format in a module of its name.

No reader is imported here, so that the Snakefile loads `raw_files` alone.

`text_of_key` and `key_by_name` are names of mappings: key -> text, name -> key.
"""
