"""A laboratory that the library has never seen: its own law, film, rig, sensors and log formats.

Nothing here imports `oilfilm`. A fault that the library and its own rig twin share would pass
unseen in the twin's logs; it shows in these.
"""
