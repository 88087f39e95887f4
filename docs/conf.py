"""How the documentation is built: `sphinx-build -W docs site`, without a network.

Pages are Markdown; their code cells run while they are built. What the code already says (rules of
the linter, tags, public names, working pages) is written by `docs/generate.py` before each build.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from sphinx.application import Sphinx

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))

project = "mecanique"
author = "The mecanique developers"
copyright = "2026, The mecanique developers"  # noqa: A001 the name Sphinx asks for
extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
exclude_patterns = ["_generated/pages", "paper"]
html_theme = "furo"
html_title = "mecanique"
html_extra_path = ["_generated/pages"]
html_show_sphinx = False
smartquotes = False  # q'' has primes, not quotation marks

myst_enable_extensions = ["colon_fence", "fieldlist"]
myst_heading_anchors = 3
nb_execution_mode = "force"
nb_execution_raise_on_error = True
nb_execution_timeout = 300
nb_execution_in_temp = True
# equations are shown as text: pages need no script for mathematics
nb_mime_priority_overrides = [("html", "text/plain", 0), ("html", "text/latex", None)]

autodoc_typehints = "signature"
autodoc_member_order = "bysource"
autodoc_default_options = {"members": True, "inherited-members": "object,BaseException,tuple"}
napoleon_google_docstring = True
napoleon_numpy_docstring = False
napoleon_use_rtype = False
default_role = "literal"


def setup(_: Sphinx) -> None:
    """Write what the code already says before anything is read."""
    import generate

    generate.write_all(HERE / "_generated")
