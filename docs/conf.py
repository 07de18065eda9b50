"""How Sphinx makes the site: `make docs`, into build/docs."""

from __future__ import annotations

from pathlib import Path

from sphinx.application import Sphinx
from typer.cli import get_docs_for_click
from typer.main import get_command

import ifs_cad
from ifs_cad import cli

HERE = Path(__file__).parent
COMMANDS = HERE / "reference" / "_commands.md"  # made at every build, git-ignored

project = "ifs_cad"
author = "The ifs_cad authors"
copyright = author
version = release = ifs_cad.__version__

extensions = ["myst_parser", "numpydoc", "sphinx.ext.autodoc", "sphinx_copybutton"]
exclude_patterns = ["_*", "reference/_*", "drawings"]

myst_enable_extensions = ["attrs_inline", "colon_fence", "deflist"]
myst_heading_anchors = 3

# Types are in the docstrings, with shapes and units; single backticks link what they name.
autodoc_typehints = "none"
autodoc_preserve_defaults = True
autodoc_member_order = "bysource"
numpydoc_show_class_members = False
default_role = "py:obj"
nitpicky = True
nitpick_ignore_regex = [("py:obj", ".*")]

html_theme = "furo"
html_title = f"ifs_cad {release}"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_show_sourcelink = False
html_copy_source = False
html_show_copyright = False
html_theme_options = {
    "light_css_variables": {"color-brand-primary": "#8a5a22", "color-brand-content": "#8a5a22"},
    "dark_css_variables": {"color-brand-primary": "#dba765", "color-brand-content": "#dba765"},
}
copybutton_exclude = ".linenos, .gp, .go"


def write_commands(_: Sphinx) -> None:
    """Write the page of the command line from the commands themselves."""
    command = get_command(cli.app)
    context = command.make_context("ifs-cad", ["--help"], resilient_parsing=True)
    text = get_docs_for_click(obj=command, ctx=context, name="ifs-cad")
    _, _, commands = text.partition("\n## ")  # what precedes them is the page's own
    COMMANDS.write_text("\n## " + commands, encoding="utf-8")


def setup(app: Sphinx) -> None:
    """Write the commands before each build."""
    app.connect("builder-inited", write_commands)
