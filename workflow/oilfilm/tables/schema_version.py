"""The version of all tables. Raise it with any change of a column's type, unit or bounds.

It is in the footer of every table and in the digest of every rule's code: with another version all
tables are made again. Meanings and caveats of columns change no table.

Decides: when all tables are made again.
"""

SCHEMA_VERSION = 14
