"""The documentation site; `make docs` builds it without a network."""

import os
import sys
import tomllib
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE / "_ext"))

project = "oilfilm"
author = "the oilfilm developers"
version = release = tomllib.loads((HERE.parent / "pyproject.toml").read_text("utf-8"))["project"][
    "version"
]
language = "en"

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx_copybutton",
    "sphinx_design",
    "docstrings",
    "read_aloud",
    "pictures",
    "report_page",
    "repository_pages",
]
exclude_patterns = ["_build"]

html_theme = "pydata_sphinx_theme"
html_title = "oilfilm"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_logo = html_favicon = "_static/logo.svg"
html_context = {"default_mode": "auto"}  # else the theme complains of none
html_copy_source = False
html_show_sphinx = False
html_math_renderer = "mathml"
html_theme_options = {
    "logo": {"text": "oilfilm"},
    "navbar_end": ["theme-switcher", "navbar-icon-links"],
    "footer_start": [],
    "footer_end": [],
    "show_prev_next": False,
    "navigation_with_keys": False,
    # readable by everyone: the theme's own choice of colours for code misses the contrast of axe
    "pygments_light_style": "a11y-high-contrast-light",
    "pygments_dark_style": "a11y-high-contrast-dark",
}

# the workflow that publishes the site sets it; a site built without it shows no repository
if "OILFILM_ADDRESS" in os.environ:
    html_theme_options["github_url"] = os.environ["OILFILM_ADDRESS"]

myst_enable_extensions = ["colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3
myst_update_mathjax = False
nb_execution_mode = "off"  # tests run the notebooks; what they store is shown

autodoc_typehints = "none"  # docstrings have units and shapes
# types of attributes
nitpick_ignore_regex = [("py:class", r"(numpy|pandas|oilfilm|collections)\..+")]
autodoc_member_order = "bysource"
napoleon_use_rtype = False
default_role = "literal"  # docstrings have single backticks

copybutton_exclude = ".linenos, .gp, .go"
copybutton_prompt_text = "$ "

linkcheck_timeout = 20
