"""How Sphinx builds the manual: `make docs` writes it to docs/_build, and every warning is an error."""

from __future__ import annotations

import os
import re
import sys
from pathlib import Path
from typing import Any

from numpy.typing import ArrayLike
from sphinx.util.typing import stringify_annotation

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tools"))

from tautflex import __version__  # noqa: E402 - what runs may stand beside the checkout

project = "tautflex"
author = "tautflex contributors"
copyright = author
version = release = __version__

extensions = [
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.napoleon",
    "myst_nb",
    "sphinx_gallery.gen_gallery",
    "manual.api",
    "manual.commands",
    "manual.equations",
    "manual.links",
    "manual.variables",
]
exclude_patterns = [
    "_build",
    "generated/variables.md",
    "generated/gallery/*.ipynb",
    "generated/gallery/*.py",
    "generated/gallery/*.json",
]

# Pages: Markdown, with cells that run where a page asks for it.
myst_enable_extensions = ["dollarmath", "amsmath", "colon_fence"]
myst_heading_anchors = 4
nb_execution_mode = "cache"
nb_execution_in_temp = True
nb_execution_raise_on_error = True
nb_execution_timeout = 900  # the first cell may have to compile
nb_merge_streams = True
os.environ.setdefault("PYDEVD_DISABLE_FILE_VALIDATION", "1")  # the kernel's debugger would warn on the pages

# Public names, from their docstrings.
autodoc_typehints = "description"
autodoc_typehints_description_target = "documented"
autodoc_member_order = "bysource"
autosummary_generate = False  # `manual.api` writes the pages
napoleon_google_docstring = False
napoleon_use_rtype = False

# Examples: each is run, and shows its figures.
sphinx_gallery_conf = {
    "examples_dirs": [str(ROOT / "examples" / "gallery")],
    "gallery_dirs": ["generated/gallery"],
    "filename_pattern": r"\.py$",
    "image_scrapers": "manual.pictures.figures",
    "within_subsection_order": "FileNameSortKey",
    "reset_modules": (),  # figures carry their own style, and compiled code shall stay loaded
    "abort_on_example_error": True,
    "download_all_examples": False,
    "show_signature": False,
    "remove_config_comments": True,
    "plot_gallery": "True",
    "min_reported_time": 1e9,
    "write_computation_times": False,
    "copyfile_regex": r".*\.inp",
}

html_math_renderer = "mathml"
html_theme = "pydata_sphinx_theme"
html_title = f"tautflex {release}"
html_static_path = ["_static"]
html_sidebars = {name: [] for name in ("faq", "quickstart")}  # pages without others beside them
html_context = {"default_mode": "auto"}  # light or dark as the reader's system; without it the page complains
html_css_files = ["tautflex.css"]
html_show_sourcelink = False
html_copy_source = False
html_theme_options = {
    "show_prev_next": True,
    "navigation_with_keys": False,
    "header_links_before_dropdown": 6,
    "navbar_end": ["theme-switcher"],
    "footer_start": ["copyright"],
    "footer_end": [],
    "secondary_sidebar_items": ["page-toc"],
}


def _short(
    _app: object, _what: str, _name: str, _item: object, _options: object, signature: str, result: str
) -> object:
    """Signature with modules by their names, not their places."""
    return signature and re.sub(r"<module '(\w+)' from '[^']*'>", r"\1", signature), result


def _by_name(app: Any, *_described: object) -> None:
    """Annotations with the name of NumPy's union in place of its parts."""
    spelt_out = stringify_annotation(ArrayLike, "smart")
    for hints in app.env.current_document.autodoc_annotations.values():
        for name, hint in hints.items():
            hints[name] = hint.replace(spelt_out, "ArrayLike")


def setup(app: Any) -> None:
    """Connect what Sphinx calls."""
    app.connect("object-description-transform", _by_name, priority=400)  # before they are written at 500
    app.connect("autodoc-process-signature", _short)
