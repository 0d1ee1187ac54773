"""Settings of the documents' site, built by `make docs`: Sphinx reads Markdown, formulas become MathML, no network."""

import sys
from pathlib import Path

import latex2mathml.converter
from docutils import nodes
from sphinx.application import Sphinx

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))

from generate import write_reference  # noqa: E402

project = "hexcite"
author = "the authors of hexcite"
extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
myst_enable_extensions = ["colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3
exclude_patterns = ["_build"]
nitpicky = False  # types of libraries have no pages here; links between pages are checked by MyST
default_role = "literal"
autodoc_typehints = "none"  # docstrings give shapes and units, which types do not
autodoc_member_order = "bysource"
napoleon_google_docstring = True
html_theme = "furo"
html_title = "hexcite"
html_math_renderer = "mathml"
html_copy_source = False


def formula(translator: object, node: nodes.math | nodes.math_block, display: str) -> None:
    """Writes a formula as MathML, which browsers draw themselves."""
    translator.body.append(latex2mathml.converter.convert(node.astext(), display=display))  # type: ignore[attr-defined]
    raise nodes.SkipNode


def setup(app: Sphinx) -> None:
    """Registers the formulas, and writes the pages that follow from the code."""
    app.add_html_math_renderer(
        "mathml",
        (lambda translator, node: formula(translator, node, "inline"), None),
        (lambda translator, node: formula(translator, node, "block"), None),
    )
    app.connect("builder-inited", lambda _: write_reference(HERE / "reference"))
