"""A project folder made from logs: what they seem to hold, and the settings that say so."""
