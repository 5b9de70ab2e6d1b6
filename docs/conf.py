"""Sphinx configuration."""

import os
import re
import sys
from importlib.metadata import version as installed_version
from pathlib import Path

from pydantic import BaseModel

project = "viscorod"
author = "viscorod developers"
copyright = "viscorod developers"
version = release = installed_version("viscorod")

sys.path.insert(0, str(Path(__file__).parent))
extensions = [
    "myst_nb",
    "sphinx_copybutton",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx-mathjax-offline",  # formulas are shown without a network
    "case_keys",
    "data_variables",
]
source_suffix = {".md": "myst-nb"}
exclude_patterns = ["_build"]
default_role = "code"
myst_enable_extensions = ["dollarmath", "amsmath", "colon_fence", "deflist"]
myst_heading_anchors = 3

# Notebooks are executed by `make docs`; the tests execute their code too, without the pages.
nb_execution_mode = os.environ.get("VISCOROD_NOTEBOOKS", "off")
nb_execution_in_temp = True
nb_execution_raise_on_error = True
nb_execution_timeout = 600
nb_merge_streams = True

autodoc_member_order = "bysource"
autodoc_typehints = "none"  # docstrings say what a value means and in which unit
napoleon_google_docstring = True
napoleon_numpy_docstring = False
napoleon_use_ivar = True

copybutton_prompt_text = "$ "  # what a shell prints is not copied

html_theme = "furo"
html_title = "viscorod"
html_static_path = ["_static"]
html_css_files = ["pages.css"]


def described_arguments(app, what, name, obj, options, signature, returns):
    """Show the arguments of a described object as they are given: by position first, without the tag."""
    if what != "class" or not issubclass(obj, BaseModel):
        return None
    positional, keyword = [], []
    for field, info in obj.model_fields.items():
        if field == getattr(obj, "tag", None):
            continue
        # NaN marks one of two alternatives.
        default = "..." if info.default != info.default else repr(info.default)
        text = field if info.is_required() else f"{field}={default}"
        (keyword if info.kw_only else positional).append(text)
    return (
        f"({', '.join([*positional, *(['*', *keyword] if keyword else [])])})",
        returns,
    )


def skip_plumbing(app, what, name, obj, skip, options):
    """Leave out what only the reading of fields needs."""
    return True if name in ("model_config", "renamed", "tag", "unused") else None


def places_are_no_addresses(app, what, name, obj, options, lines):
    """Keep docutils from taking a place such as beam@0.15 for an address of e-mail."""
    for number, line in enumerate(lines):
        parts = re.split(r"(`+.*?`+)", line)  # text and code by turns
        parts[::2] = [re.sub(r"(\w)@(\d)", r"\1\\@\2", part) for part in parts[::2]]
        lines[number] = "".join(parts)


def setup(app):
    app.connect("autodoc-process-signature", described_arguments)
    app.connect("autodoc-process-docstring", places_are_no_addresses)
    app.connect("autodoc-skip-member", skip_plumbing)
