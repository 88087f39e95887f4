"""Make MathML and text safe for a page: known elements pass, everything else becomes text."""

from __future__ import annotations

import html
import re
from xml.etree.ElementTree import Element

from mecanique.safe_xml import XmlRefusedError, tree_of

_ELEMENT_NAMES = (
    "math mrow mi mn mo mtext mspace ms mfrac msqrt mroot mstyle mpadded mphantom mfenced "
    "menclose msub msup msubsup munder mover munderover mmultiscripts mprescripts none mtable "
    "mtr mtd mlabeledtr semantics"
)
_ATTRIBUTE_NAMES = (
    "display displaystyle mathvariant stretchy fence separator form lspace rspace minsize "
    "maxsize largeop movablelimits accent accentunder linethickness columnalign rowalign "
    "columnspacing rowspacing columnlines rowlines columnspan rowspan width height depth open "
    "close separators scriptlevel symmetric dir intent"
)
_ELEMENTS = frozenset(_ELEMENT_NAMES.split())
_ATTRIBUTES = frozenset(_ATTRIBUTE_NAMES.split())

_DEEPEST = 200
"""Deepest nesting allowed in an equation."""


def safe(text: str, *, display: bool = False) -> str:
    """Return HTML for a text that may be MathML.

    Args:
        text: MathML (it begins with `<math` or is a run of MathML elements) or plain text, which is
            escaped.
        display: whether an equation stands on a line of its own.
    """
    stripped = text.strip()
    if not stripped.startswith("<m"):
        return html.escape(text)
    try:
        tree = tree_of(f"<m>{stripped}</m>", most_depth=_DEEPEST)
    except (XmlRefusedError, UnicodeEncodeError):
        return html.escape(text)
    kept = "".join(_write(child) for child in tree)
    if len(tree) == 1 and tree[0].tag == "math":
        kept = "".join(_write(child) for child in tree[0])
    # what is kept is escaped already, and so are its words
    words = " ".join(re.sub(r"<[^>]*>", " ", kept).split())
    alternative = f' alttext="{words}"' if words else ""
    return f'<math display="{"block" if display else "inline"}"{alternative}>{kept}</math>'


def _write(element: Element) -> str:
    inner = html.escape(element.text or "") + "".join(
        _write(child) + html.escape((child.tail or "").strip()) for child in element
    )
    tag = element.tag
    if tag == "annotation":
        return ""
    if tag not in _ELEMENTS:
        return f"<mtext>{html.escape(''.join(element.itertext()))}</mtext>"
    kept = {name: value for name, value in element.attrib.items() if name in _ATTRIBUTES}
    attributes = "".join(f' {name}="{html.escape(value)}"' for name, value in kept.items())
    return f"<{tag}{attributes}>{inner}</{tag}>"
