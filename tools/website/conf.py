"""Sphinx's settings; ``build.py`` gathers the sources and starts it."""

import os
import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

import modelcast

project = "modelcast"
author = "the authors of modelcast"
project_copyright = "the authors of modelcast, Apache-2.0"
version = release = modelcast.__version__
language = "en"

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "public_references",
    "docstring_text",
    "accessible",
    "widths",
]
exclude_patterns = ["_build"]
suppress_warnings: list[str] = []
nitpicky = False

myst_heading_anchors = 6
myst_enable_extensions: list[str] = []

default_role = "py:obj"
autodoc_typehints = "signature"
autodoc_typehints_format = "short"
autodoc_member_order = "bysource"
autodoc_preserve_defaults = True
autodoc_default_options = {"members": True, "show-inheritance": True}
python_use_unqualified_type_names = True
python_maximum_signature_line_length = 88
add_module_names = False
napoleon_google_docstring = False
napoleon_use_rtype = False
napoleon_preprocess_types = False
napoleon_attr_annotations = False
maximum_signature_line_length = 88
toc_object_entries_show_parents = "hide"

html_theme = "pydata_sphinx_theme"
html_title = "modelcast"
_SHARED = ("enlarge.js", "enlarge.css", "scrollable.js", "scrollable.css")
html_static_path = ["static", *(f"../../src/modelcast/report/static/{name}" for name in _SHARED)]
templates_path = ["templates"]
html_css_files = ["enlarge.css", "scrollable.css", "site.css"]
html_js_files = ["copy.js", *((name, {"defer": "defer"}) for name in ("enlarge.js", "scrollable.js"))]
html_favicon = "../../src/modelcast/dashboard/static/icon.svg"
html_copy_source = False
html_show_sourcelink = False
html_use_index = False
html_context = {"default_mode": "auto", "site_base": os.environ.get("SITE_BASE", "/")}
html_additional_pages = {"404": "404.html"}
html_theme_options = {
    "show_toc_level": 2,
    "header_links_before_dropdown": 8,
    "navbar_align": "left",
    "footer_start": ["copyright"],
    "footer_end": [],
    "back_to_top_button": False,
    "show_prev_next": True,
    "pygments_light_style": "a11y-high-contrast-light",
    "pygments_dark_style": "a11y-high-contrast-dark",
}
