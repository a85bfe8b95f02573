"""Lines of settings files that `oilfilm init` writes: a key, its value and a comment.

Decides: how a line to fill in is marked.
"""

import re

import numpy as np
import yaml

from oilfilm.base.errors import printable

# Marks a value that only the laboratory knows. The run stops without it.
FILL_IN = "# FILL IN"
# Key and value are padded to this width, so that the comments of a file are below each other.
_WIDTH_BEFORE_COMMENT = 34


def settings_line(key: str, value: object, comment: str = "") -> str:
    """A line of YAML; None leaves the value empty, to be filled in."""
    line = f"{key}: {_yaml_on_one_line(value)}".rstrip()
    comment = printable(comment.removeprefix("# "))
    return f"{line.ljust(_WIDTH_BEFORE_COMMENT)}  # {comment}" if comment else line


def _yaml_on_one_line(value: object) -> str:
    """A value as YAML on one line."""
    if value is None:
        return ""
    text = yaml.safe_dump(
        value, default_flow_style=True, allow_unicode=True, sort_keys=False, width=np.inf
    )
    # a last key without a value is to be filled in
    return re.sub(r": null}$", ": }", text.removesuffix("\n").removesuffix("\n..."))
