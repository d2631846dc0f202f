"""Sphinx: how the site is built from the pages that tools/docs_site.py has gathered. Run it by ./run docs."""

from __future__ import annotations

import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "tools"))

import docs_api  # noqa: E402

docs_api.use_local_package()
import stark  # noqa: E402

project = "Stark"
author = "The Stark authors"
project_copyright = author
version = release = stark.__version__

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.viewcode"]
root_doc = "index"
html_theme = "furo"
html_title = f"Stark {version}"
html_static_path = [str(ROOT / "docs" / "site")]
html_css_files = ["site.css"]
html_copy_source = False
html_show_sphinx = False

myst_heading_anchors = 4
# Everything that is not a name of ours: `x` in a docstring is code, not a reference.
default_role = "code"
highlight_language = "text"
suppress_warnings = ["misc.highlighting_failure"]

autodoc_default_options = {"members": True, "undoc-members": True, "member-order": "bysource"}
autodoc_typehints_format = "short"
autodoc_preserve_defaults = True
python_use_unqualified_type_names = True
python_display_short_literal_types = True
python_maximum_signature_line_length = 100

nitpicky = True
nitpick_ignore_regex = docs_api.FOREIGN_TYPES


def setup(app: object) -> None:
    """Connects names of types in signatures with their pages."""
    docs_api.connect(app)
