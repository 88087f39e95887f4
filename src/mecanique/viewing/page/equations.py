"""The panel of equations as HTML: the result first, then figure, symbols and derivations."""

from __future__ import annotations

import base64
from dataclasses import replace
from html import escape

from mecanique.viewing.page.sanitize import safe
from mecanique.viewing.scene.document import Block, Derivation, Document


def write_equations(document: Document) -> str:
    """Return the panel: equations of motion, figure, symbols, then the derivations.

    Args:
        document: the texts of the page.
    """
    first = next((each for each in document.derivations if each.blocks), None)
    parts = [_result(first) if first else ""]
    if document.about:
        parts.append(f"<p>{escape(document.about)}</p>")
    parts += [_figure(document), _symbols(document)]
    parts += [_derivation(each) for each in document.derivations]
    if document.source and document.source not in document.about:
        parts.append(f'<p class="note">Source: {escape(document.source)}</p>')
    return "".join(parts)


def _result(derivation: Derivation) -> str:
    """The equations of motion, to read and to copy, above their derivation."""
    final = [replace(block, heading="", lead="") for block in derivation.blocks if block.final]
    if not final:
        return ""
    latex = escape(derivation.latex, quote=True)
    copies = f'<button type="button" data-copy="{latex}">Copy LaTeX</button>' if latex else ""
    if derivation.listed:
        shown = f'<p class="note">{_LISTED}</p>'
    else:
        shown = "".join(map(_block, final))
        copies += '<button type="button" data-copy-mathml>Copy MathML</button>'
    return (
        '<section class="equations"><h3>Equations of motion</h3>'
        f'{shown}<div class="bar">{copies}</div></section>'
    )


_LISTED = (
    "One closed form would be too long to read. Each method below writes them as a list of named "
    "results, from body to body, with the equations of motion at its end."
)


def _figure(document: Document) -> str:
    if not document.figure:
        return ""
    data = base64.b64encode(document.figure.encode()).decode()
    return (
        '<details class="part" open><summary>Figure</summary><img class="figure"'
        f' alt="Line figure: {escape(document.subtitle)}" src="data:image/svg+xml;base64,{data}">'
        "</details>"
    )


def _symbols(document: Document) -> str:
    if not document.symbols:
        return ""
    rows = "".join(
        f'<tr><th scope="row">{safe(symbol)}</th><td class="words">{escape(meaning)}</td></tr>'
        for symbol, meaning in document.symbols
    )
    return (
        '<details class="part" open><summary>Symbols</summary>'
        f"<table><tbody>{rows}</tbody></table></details>"
    )


def _derivation(derivation: Derivation) -> str:
    title = escape(derivation.method)
    if not derivation.blocks:
        return f"<h3>{title}</h3>"
    blocks = "".join(map(_block, derivation.blocks))
    steps = '<button type="button" data-steps>Step by step</button>'
    if len(derivation.blocks) < _FEW_STEPS:
        steps = ""
    return (
        f'<details class="part derivation"><summary>{title}</summary>'
        f'<div class="bar">{steps}</div>{blocks}</details>'
    )


_FEW_STEPS = 3
"""A derivation of fewer steps is shown at once."""


def _block(block: Block) -> str:
    heading = f"<h4>{escape(block.heading)}</h4>" if block.heading else ""
    lead, note = (
        f'<p class="note">{escape(text)}</p>' if text else "" for text in (block.lead, block.note)
    )
    kind = "equation result" if block.final else "equation"
    body = f'<div class="{kind}">{safe(block.body, display=True)}</div>' if block.body else ""
    return f'<div class="step">{heading}{lead}{body}{note}</div>'
