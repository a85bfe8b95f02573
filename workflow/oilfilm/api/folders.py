"""Where a call or a command looks for settings, where none are named.

Decides: which configuration folder counts.
"""

from pathlib import Path

from oilfilm.base.home import CONFIG


def config_folder(named_folder: Path | None) -> Path:
    """The configuration folder: the named one, else `config` here, else that of oilfilm."""
    if named_folder:
        return named_folder
    current_config = Path("config")
    return current_config if current_config.is_dir() else CONFIG


def project_folder(config: Path | None) -> Path:
    """The folder of logs and results: that above a named configuration folder, else this one."""
    return config.parent if config else Path()
