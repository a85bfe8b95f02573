"""Fits of any traction law: global search, polish, certificate, uncertainty, identifiability."""
