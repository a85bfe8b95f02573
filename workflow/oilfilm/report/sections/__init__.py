"""Sections of the report, from the finished tables; the templates have the sentences.

Sections of a study are in the package of the study.
"""
