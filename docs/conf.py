# SPDX-License-Identifier: MIT OR Apache-2.0
"""Sphinx' settings: ``sphinx-build -W docs out/docs`` builds the pages, without a network."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))

import mtb_rs

project = "mtb_rs"
copyright = "the mtb_rs authors"
version = release = mtb_rs.__version__

extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "directives"]
exclude_patterns = ["_build"]

myst_enable_extensions = ["dollarmath", "amsmath", "colon_fence", "deflist"]
myst_heading_anchors = 3
nb_execution_mode = "off"  # notebooks.py runs them, and the tests
html_math_renderer = "mathml"

autodoc_member_order = "bysource"
toc_object_entries_show_parents = "hide"
autodoc_typehints = "none"  # the docstrings say types, shapes and units
autodoc_preserve_defaults = True
napoleon_google_docstring = False
napoleon_use_rtype = False
napoleon_use_ivar = True
# an attribute of one class (StepState.pressure) may be a documented property of two others
suppress_warnings = ["ref.python"]

html_theme = "furo"
html_title = f"mtb_rs {release}"
html_static_path = ["static"]
html_css_files = ["style.css"]
html_copy_source = False
html_show_sphinx = False
