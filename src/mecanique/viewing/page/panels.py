"""The page's tabs as HTML: equations, plots, forces, virtual work, verdict, parameters, URDF."""

from __future__ import annotations

import base64
import html
import re
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from dataclasses import replace
from functools import cache
from html import escape
from importlib.resources import files
from math import degrees
from xml.etree.ElementTree import Element

from mecanique.derivation.printing.prose import to_html
from mecanique.safe_xml import XmlRefusedError, tree_of
from mecanique.viewing.scene.from_motion import LOST, explain_loss
from mecanique.viewing.scene.inspection import Inspection, Note, Slider
from mecanique.viewing.scene.scene import (
    DerivationStep,
    Knob,
    Scene,
    SceneText,
    ShownDerivation,
    VerdictTable,
)
from mecanique.wording import say_count

_OF_MOTION = ("plots", "parameters", "forces")
"""Panels without a tab where nothing moves."""


@cache
def read_asset(name: str) -> str:
    """Return the text of a file of the page."""
    return (files("mecanique.viewing.page") / "assets" / name).read_text(encoding="utf-8")


def _fragment(name: str, **parts: str) -> str:
    """Part of a panel, with the parts that it names in double braces."""
    # a line break would be a space on the page
    html = read_asset(f"fragments/{name}.html").replace("\n", "")
    return fill(html, parts)


def _table(rows: str, head: str = "", kind: str = "") -> str:
    """A table that scrolls where it is too wide for the panel."""
    named = f' class="{kind}"' if kind else ""
    top = f"<thead><tr>{head}</tr></thead>" if head else ""
    return f'<div class="scroll"><table{named}>{top}<tbody>{rows}</tbody></table></div>'


def _notes(texts: Iterable[str]) -> str:
    """Sentences in small print."""
    return "".join(f'<p class="note">{escape(text)}</p>' for text in texts if text)


def _part(title: str, inner: str, kind: str = "", *, opened: bool = True) -> str:
    """Part of a panel that can be folded."""
    return (
        f'<details class="part{kind}"{" open" if opened else ""}><summary>{title}</summary>{inner}'
        "</details>"
    )


def fill(template: str, parts: Mapping[str, str]) -> str:
    """Return a text with the parts that it names in double braces."""
    # in one pass, so that nothing inside a part is taken for a placeholder
    return re.sub(r"\{\{(\w+)\}\}", lambda match: parts[match[1]], template)


def panels(scene: Scene, *, live: bool) -> tuple[str, str]:
    """Return the tabs and their panels, without those for which the scene has no content."""
    makers: list[tuple[str, str, Callable[[], str]]] = [
        ("findings", "Findings", lambda: write_findings(scene.inspection)),
        ("joints", "Joints", lambda: write_joints(scene.inspection)),
        ("equations", "Equations", lambda: write_equations(scene.document)),
        ("plots", "Plots", lambda: _fragment("plots")),
        ("parameters", "Parameters", lambda: write_parameters(scene, live)),
        ("forces", "Forces", lambda: _forces(scene)),
        ("ledger", "Virtual work", lambda: _ledger(scene) + _energy(scene)),
        ("verdict", "Verdict", lambda: _verdict(scene)),
        ("urdf", "URDF", lambda: _urdf(scene)),
    ]
    tabs: list[str] = []
    bodies: list[str] = []
    for key, title, make in makers:
        inner = make()
        if not inner:
            continue
        first = not tabs
        hidden = " hidden" if scene.inspection and key in _OF_MOTION else ""
        tabs.append(
            f'<button type="button" role="tab" id="tab-{key}" aria-controls="panel-{key}"'
            f' aria-selected="{"true" if first else "false"}"{hidden}>{title}</button>'
        )
        bodies.append(
            f'<div role="tabpanel" id="panel-{key}" aria-labelledby="tab-{key}" tabindex="0"'
            f"{'' if first else ' class=off'}><h2>{title}</h2>{inner}</div>"
        )
    return "".join(tabs), "\n".join(bodies)


def badge(scene: Scene) -> str:
    """Return the badge that says whether the derivation agrees with the reference."""
    agrees, headline = scene.document.verdict.agrees, scene.document.verdict.headline
    if agrees is None:
        return f'<span class="badge">{escape(headline)}</span>' if headline else ""
    kind, text = ("good", "✓ agrees") if agrees else ("bad", "✗ disagrees")
    return f'<span class="badge {kind}">{text}</span>'


def late(scene: Scene) -> dict[str, str]:
    """Return what a live view learns after its start: the badge and the insides of two panels."""
    return {
        "badge": badge(scene),
        "equations": write_equations(scene.document),
        "verdict": _verdict(scene),
    }


def _forces(scene: Scene) -> str:
    hint = "No force acts on this body." if scene.arrows else "This scene has no forces."
    return _fragment("forces", hint=hint, notes=_notes(scene.document.undetermined))


def _energy(scene: Scene) -> str:
    lost = [curve.name for curve in scene.series if curve.name.startswith(LOST)]
    if not lost:
        return ""
    rows = ""
    for name in ("energy kinetic", "energy potential", *lost):
        kind = name.removeprefix("energy ")
        if name in lost:
            kind = explain_loss(name.removeprefix(LOST))
        cell = f'<td class="number" data-series="{escape(name)}"></td>'
        rows += f'<tr><th scope="row" class="words">{escape(kind)}</th>{cell}</tr>'
    return _fragment("energy", rows=rows)


def _ledger(scene: Scene) -> str:
    ledger = scene.document.ledger
    if not ledger.rows:
        return ""
    heads = ""
    for symbol, unit in zip(ledger.coordinates, ledger.units, strict=True):
        named = f"δ{safe(symbol)}" + (f" [{escape(unit)}]" if unit else "")
        heads += f'<th scope="col" class="number">{named}</th>'
    cells = '<td class="number"></td>' * len(ledger.coordinates)
    rows = ""
    for row in ledger.rows:
        name = f'<th scope="row" class="words" dir="auto">{escape(row.name)}</th>'
        rows += f"<tr>{name}<td>{safe(row.displacement)}</td>{cells}</tr>"
    return _fragment("ledger", heads=heads, rows=rows, sums=cells)


def _verdict(scene: Scene) -> str:
    verdict = scene.document.verdict
    if not verdict.rows and not verdict.headline:
        return ""
    head = "".join(f'<th scope="col">{escape(column)}</th>' for column in verdict.columns)
    body = ""
    for row in verdict.rows:
        cells = "".join(f'<td class="words">{safe(cell)}</td>' for cell in row)
        body += f"<tr>{cells}</tr>"
    table = _table(body, head) if verdict.rows else ""
    return (
        f"<p><strong>{escape(verdict.headline)}</strong></p>{table}{_notes(verdict.notes)}"
        f"{_proof(verdict)}"
    )


def _proof(verdict: VerdictTable) -> str:
    """By how much the page's own program differs."""
    if not verdict.own:
        return ""
    rows = ""
    for name, worst in verdict.own:
        rows += (
            f'<tr><th scope="row" class="words">{escape(name)}</th><td>{escape(worst)}</td></tr>'
        )
    return _fragment("proof", rows=rows, note=escape(verdict.own_note))


def _urdf(scene: Scene) -> str:
    if not scene.document.urdf:
        return ""
    return (
        '<div class="bar"><button type="button" id="save-urdf">Save the URDF</button></div>'
        f'<pre id="urdf-text" dir="ltr">{escape(scene.document.urdf)}</pre>'
    )


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
    """Return HTML for a text that may be MathML."""
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


def write_equations(document: SceneText) -> str:
    """Return the panel: equations of motion, figure, symbols, then the derivations."""
    first = next((derivation for derivation in document.derivations if derivation.blocks), None)
    parts = [_result(first) if first else ""]
    if document.about:
        # initials of authors are no letters of formulas
        words, source, cited = document.about.partition("Source: ")
        names = {knob.name for knob in (*document.parameters, *document.initial)}
        parts.append(f"<p>{to_html(words, names)} {escape(source + cited)}</p>")
    parts += [_figure(document), _symbols(document)]
    parts += [_derivation(derivation) for derivation in document.derivations]
    if document.source and document.source not in document.about:
        parts.append(_notes([f"Source: {document.source}"]))
    return _SIGNED.sub(r'<span class="kept">\g<0></span>', "".join(parts))


_SIGNED = re.compile(r"<math\b(?:(?!<math\b).)*?</math>[.,;:)]+", re.DOTALL)
"""A formula with the signs after it, which would begin a line alone."""


def _result(derivation: ShownDerivation) -> str:
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


def _figure(document: SceneText) -> str:
    if not document.figure:
        return ""
    about = f"Line figure: {escape(document.subtitle)}"
    return _part("Figure", f'<img class="figure" alt="{about}" src="{encode(document.figure)}">')


def encode(figure: str) -> str:
    """Return a figure in SVG as the address of an image."""
    return f"data:image/svg+xml;base64,{base64.b64encode(figure.encode()).decode()}"


def _symbols(document: SceneText) -> str:
    if not document.symbols:
        return ""
    rows = ""
    for symbol, meaning in document.symbols:
        # components in formulas of their own, between which lines break
        letters = re.sub(r"</?math[^>]*>", "", symbol).split("<mo>,</mo>")
        parts = ", ".join(map(safe, letters))
        rows += f'<tr><th scope="row">{parts}</th><td class="words">{escape(meaning)}</td></tr>'
    return _part("Symbols", _table(rows, kind="symbols"))


def _derivation(derivation: ShownDerivation) -> str:
    title = escape(derivation.method)
    if not derivation.blocks:
        return f"<h3>{title}</h3>"
    blocks = "".join(map(_block, derivation.blocks))
    steps = '<button type="button" data-steps>Step by step</button>'
    if len(derivation.blocks) < _FEW_STEPS:
        steps = ""
    opened = not any(block.final for block in derivation.blocks)
    return _part(title, f'<div class="bar">{steps}</div>{blocks}', " derivation", opened=opened)


_FEW_STEPS = 3
"""A derivation of fewer steps is shown at once."""


def _block(block: DerivationStep) -> str:
    heading = f"<h4>{escape(block.heading)}</h4>" if block.heading else ""
    held = "; ".join(f"{to_html(words)} {safe(x)}".strip() for words, x in block.held)
    lead, note, held = (
        f'<p class="note">{text}</p>' if text else ""
        for text in (to_html(block.lead), to_html(block.note), held)
    )
    kind = "equation result" if block.final else "equation"
    body = f'<div class="{kind}">{safe(block.body, display=True)}</div>' if block.body else ""
    return f'<div class="step">{heading}{lead}{body}{note}{held}</div>'


def write_parameters(scene: Scene, live: bool) -> str:
    """Return the panel: fields where the page or a server computes, numbers elsewhere."""
    document = scene.document
    parts = [_fragment("setup")] if scene.engine else []
    parts.append(_notes([document.method and f"Recorded: {document.method}.", document.recorded]))
    for title, kind, quantities in (
        ("Parameters", "parameter", document.parameters),
        ("Initial values", "initial", document.initial),
    ):
        if quantities:
            parts.append(f"<h3>{title}</h3>{_quantities(scene, kind, quantities, live)}")
    if engine := scene.engine:
        duration = _field("duration", "", engine.duration, "s")
        rtol = _field("rtol", "", engine.rtol)
        parts.append(_fragment("integration", duration=duration, rtol=rtol))
        parts += [_fragment("beside"), _fragment("modes")]
    if document.freedom:
        parts.append(
            "<h3>Degrees of freedom</h3>"
            + "".join(f"<p>{safe(freedom)}</p>" for freedom in document.freedom)
        )
    return "".join(parts)


def _field(kind: str, name: str, value: float, unit: str = "") -> str:
    label = escape(name or {"rtol": "Tolerance"}.get(kind, kind.capitalize()))
    return (
        f'<input type="number" step="any" disabled data-kind="{kind}" data-name="{escape(name)}"'
        f' data-unit="{escape(unit)}" aria-label="{label}" value="{value:.6g}">'
    )


def _quantities(scene: Scene, kind: str, quantities: Iterable[Knob], live: bool) -> str:
    rows = []
    known: set[str] = set()
    if engine := scene.engine:
        known = {*engine.parameters, *engine.coordinates, *engine.velocities}
    for quantity in quantities:
        settable, name = quantity.name in known, escape(quantity.name)
        value = f"<output>{quantity.value:.6g}</output>"
        if settable:
            value = _field(kind, quantity.name, quantity.value, quantity.unit)
        if (settable or live) and quantity.low < quantity.high:
            value += (
                f' <input type="range" disabled data-kind="{kind}" data-name="{name}"'
                f' data-unit="{escape(quantity.unit)}" aria-label="{name}"'
                f' min="{quantity.low!r}" max="{quantity.high!r}" step="any"'
                f' value="{quantity.value!r}">'
            )
        cells = (
            f'<td class="number">{value}</td><td>{escape(quantity.unit)}</td>'
            f'<td class="words">{escape(quantity.meaning)}</td>'
        )
        rows.append(f'<tr><th scope="row">{safe(quantity.symbol)}</th>{cells}</tr>')
    head = (
        '<th scope="col">Symbol</th><th scope="col" class="number">Value</th>'
        '<th scope="col">Unit</th><th scope="col">Meaning</th>'
    )
    return _table("".join(rows), head)


_NOTHING = "<p>Nothing was found to be wrong with it.</p>"
_OPEN = '<p class="note">Sliders move the tree of joints; what closes loops is opened by them.</p>'


def write_findings(inspection: Inspection | None) -> str:
    """Return the panel of findings on a description; empty without an inspection."""
    if inspection is None:
        return ""
    if not inspection.notes:
        return _NOTHING
    counts = Counter(note.finding.severity for note in inspection.notes)
    sums = [say_count(counts[kind], kind) for kind in ("error", "warning") if counts[kind]]
    sums += [say_count(counts["info"], "remark")] if counts["info"] else []
    order = ("error", "warning", "info")
    notes = sorted(inspection.notes, key=lambda note: order.index(note.finding.severity))
    return (
        f"<p>{', '.join(sums)}. A finding with a link shows it in the picture.</p>"
        f'<ul id="findings">{"".join(map(_finding, notes))}</ul>'
    )


def _finding(note: Note) -> str:
    finding = note.finding
    bodies = " ".join(map(str, note.bodies))
    severity = finding.severity
    button = f"{severity} {finding.code}, line {finding.line}"
    attributes = f' data-bodies="{bodies}" aria-pressed="false"' if bodies else " disabled"
    return (
        f'<li class="finding {severity}"><button type="button"{attributes}>{button}</button>'
        f' {escape(finding.sentence)}<p class="note">{escape(finding.remedy)}</p></li>'
    )


def write_joints(inspection: Inspection | None) -> str:
    """Return the panel of sliders; empty without any."""
    if inspection is None or not inspection.sliders:
        return ""
    rows = "".join(_slider(k, slider) for k, slider in enumerate(inspection.sliders))
    return _fragment("joints", note=_OPEN if inspection.closed else "", rows=rows)


def _slider(k: int, slider: Slider) -> str:
    limits = "none"
    if slider.limited:
        if slider.unit == "rad":
            limits = f"{degrees(slider.low):.4g} … {degrees(slider.high):.4g}°"
        else:
            limits = f"{slider.low:.4g} … {slider.high:.4g} m"
    return (
        f'<tr><th scope="row" class="words">{escape(slider.name)}</th>'
        f'<td><input type="range" data-joint="{k}" aria-label="{escape(slider.name)}"'
        f' min="{slider.low!r}" max="{slider.high!r}" step="any" value="{slider.value!r}"></td>'
        f'<td class="number"><output></output></td><td>{limits}</td></tr>'
    )
