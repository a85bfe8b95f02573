"""Where a call or a command looks for settings, where none are named.

Decides: which configuration folder counts.
"""

import os
from pathlib import Path

from oilfilm.base.home import CONFIG


def config_folder(config_option: Path | None) -> Path:
    """The configuration folder: the named one, else `config` here, else that of oilfilm."""
    if config_option:
        return config_option
    current_config = Path("config")
    return current_config if current_config.is_dir() else CONFIG


def project_folder(config_option: Path | None) -> Path:
    """The folder of logs and results: that above a named configuration folder, else the current.

    A configuration folder that is a symbolic link belongs to the folder that has the link.
    """
    if not config_option:
        return Path()
    # the path `.` has no name, and `..` is no name: both have the parent `.`
    if config_option.name in ("", ".."):
        # `resolve` would follow a link
        return Path(os.path.abspath(config_option)).parent  # noqa: PTH100
    return config_option.parent
