"""How the documentation is built: `sphinx-build -W docs site`, without a network.

Pages are Markdown; their code cells run while they are built. What the code already says (rules of
the linter, tags, public names, working pages) is written by `docs/generate.py` before each build.
"""

from __future__ import annotations

import logging
import os
import re
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from docutils import nodes
from docutils.utils.math.latex2mathml import tex2mathml
from sphinx import addnodes

if TYPE_CHECKING:
    from sphinx.application import Sphinx
    from sphinx.writers.html5 import HTML5Translator

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))

project = "mecanique"
author = "The mecanique developers"
copyright = "2026, The mecanique developers"  # noqa: A001 the name Sphinx asks for
extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
exclude_patterns = ["_generated/api_names.md", "_generated/pages", "paper", "try"]
html_theme = "furo"
html_title = "mecanique"
html_extra_path = ["_generated/pages"]
html_static_path = ["_static"]
html_css_files = ["book.css"]
html_math_renderer = "mathml"
html_show_sphinx = False
smartquotes = False  # q'' has primes, not quotation marks

myst_enable_extensions = ["colon_fence", "fieldlist"]
myst_heading_anchors = 3
nb_execution_mode = "force"
nb_execution_raise_on_error = True
nb_execution_timeout = 300
nb_execution_in_temp = True
# formulas are MathML, which browsers draw without a script
nb_mime_priority_overrides = [("html", "text/latex", None)]

autodoc_typehints = "signature"
python_maximum_signature_line_length = 75  # longer ones have a line for each argument
autodoc_member_order = "bysource"
autodoc_default_options = {"members": True, "inherited-members": "object,BaseException,tuple"}
napoleon_google_docstring = True
napoleon_numpy_docstring = False
napoleon_use_rtype = False
default_role = "literal"


def write_math(writer: HTML5Translator, node: nodes.math) -> None:
    """Write a formula in a line of text as MathML."""
    writer.body.append(tex2mathml(node.astext()))
    raise nodes.SkipNode


def keep_signs(app: Sphinx, tree: nodes.document, name: str) -> None:
    """Keep the sign that follows a formula on its line."""
    for formula in list(tree.findall(nodes.math)):
        after = formula.next_node(descend=False, siblings=True)
        sign = re.match(r"[.,;:?)]+", after.astext()) if isinstance(after, nodes.Text) else None
        if sign is None:
            continue
        after.parent.replace(after, nodes.Text(after.astext()[sign.end() :]))
        kept = nodes.inline("", "", classes=["kept"])
        formula.replace_self(kept)
        kept += [formula, nodes.Text(sign[0])]


def write_math_block(writer: HTML5Translator, node: nodes.math_block) -> None:
    """Write a displayed formula as MathML, in a box that can be scrolled."""
    formula = tex2mathml(node.astext(), as_block=True)
    writer.body.append(f'<div class="formula">{formula}</div>')
    raise nodes.SkipNode


def link_names(app: Sphinx, page: nodes.document) -> None:
    """Link each public name in a sentence, `mq.name(…)`, to where the reference explains it."""
    import mecanique as mq

    for literal in list(page.findall(nodes.literal)):
        named = re.match(r"mq\.(\w+)", literal.astext())
        linked = isinstance(literal.parent, nodes.reference | addnodes.pending_xref)
        if named is None or named[1] not in mq.__all__ or linked:
            continue
        link = addnodes.pending_xref(
            refdomain="py", reftype="obj", reftarget=f"mecanique.{named[1]}", refwarn=True
        )
        literal.replace_self(link)
        link += literal


def write_dashes(app: Sphinx, page: nodes.document) -> None:
    """Set an argument and its meaning apart by a dash, which Sphinx writes as two hyphens."""
    for text in list(page.findall(nodes.Text)):
        if text.astext() == " -- ":
            text.parent.replace(text, nodes.Text(" – "))


def setup(app: Sphinx) -> None:
    """Write what the code already says before anything is read."""
    import generate

    # kernels read no settings of whoever builds, and do not warn of how they are connected
    settings = HERE / "_generated" / "ipython"
    profile = settings / "profile_default"
    profile.mkdir(parents=True, exist_ok=True)
    quiet = '{"IPKernelApp": {"log_level": "ERROR"}}'
    (profile / "ipython_kernel_config.json").write_text(quiet, encoding="utf-8")
    os.environ["IPYTHONDIR"] = str(settings)
    logging.getLogger("traitlets").setLevel(logging.WARNING)

    app.connect("doctree-read", link_names)
    app.connect("doctree-read", write_dashes)
    app.connect("doctree-resolved", keep_signs)
    app.add_html_math_renderer("mathml", (write_math, None), (write_math_block, None))
    generate.write_all(HERE / "_generated")
