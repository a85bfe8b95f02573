"""Topics of the report: one module builds one section, from the finished tables.

The templates beside them have the sentences. What belongs to one study only is in its room.
"""
