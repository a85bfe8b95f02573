"""Functions that a Python program calls: fits of arrays and of tables, without the workflow."""
