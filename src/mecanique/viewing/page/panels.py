"""The page's tabs as HTML: equations, plots, forces, virtual work, verdict, parameters, URDF."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from html import escape

from mecanique.viewing.page.sanitize import safe
from mecanique.viewing.scene.document import Block, Quantity
from mecanique.viewing.scene.engine import Engine
from mecanique.viewing.scene.scene import Scene

__all__ = ["badge", "late", "panels"]


def panels(scene: Scene, *, live: bool) -> tuple[str, str]:
    """Return the tabs and their panels, without those for which the scene has no content.

    Args:
        scene: what the page shows.
        live: whether parameters and initial values get sliders.
    """
    makers: list[tuple[str, str, Callable[[], str]]] = [
        ("equations", "Equations", lambda: _equations(scene)),
        ("plots", "Plots", lambda: _plots(scene)),
        ("parameters", "Parameters", lambda: _parameters(scene, live)),
        ("forces", "Forces", lambda: _forces(scene)),
        ("ledger", "Virtual work", lambda: _ledger(scene)),
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
        tabs.append(
            f'<button type="button" role="tab" id="tab-{key}" aria-controls="panel-{key}"'
            f' aria-selected="{"true" if first else "false"}">{title}</button>'
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
    return {"badge": badge(scene), "equations": _equations(scene), "verdict": _verdict(scene)}


def _equations(scene: Scene) -> str:
    parts = []
    for derivation in scene.document.derivations:
        parts.append(f"<h3>{escape(derivation.method)}</h3>")
        parts += [_block(block) for block in derivation.blocks]
    return "".join(parts)


def _block(block: Block) -> str:
    heading = f"<h4>{escape(block.heading)}</h4>" if block.heading else ""
    lead, note = (
        f'<p class="note">{escape(text)}</p>' if text else "" for text in (block.lead, block.note)
    )
    kind = "equation result" if block.final else "equation"
    body = f'<div class="{kind}">{safe(block.body, display=True)}</div>' if block.body else ""
    return f"{heading}{lead}{body}{note}"


def _plots(scene: Scene) -> str:
    del scene  # every scene has something to plot, or will have
    return (
        '<div class="bar"><details class="menu"><summary>Quantities</summary>'
        '<div id="picker" role="group" aria-label="Quantities to plot"></div></details>'
        '<div class="group" role="group" aria-label="Zoom">'
        '<button type="button" id="zoom-in" aria-label="Zoom in"'
        ' title="Zoom in around the cursor">+</button>'
        '<button type="button" id="zoom-out" aria-label="Zoom out" title="Zoom out">−</button>'
        '<button type="button" id="zoom-all" title="Whole motion">All</button></div>'
        '<button type="button" id="csv" title="Save the chosen quantities">CSV</button></div>'
        '<div id="charts"></div>'
        '<p class="note bar">'
        "Click or drag to move the clock; shift-drag or ctrl-scroll to zoom.</p>"
    )


def _forces(scene: Scene) -> str:
    hint = "" if scene.arrows else "This scene has no forces."
    head = "".join(
        f'<th scope="col" class="number">{each}</th>' for each in ("x", "y", "z", "size")
    )
    undetermined = scene.document.undetermined
    notes = "".join(f'<p class="note">{escape(note)}</p>' for note in undetermined)
    return (
        f'<p class="note bar">Choose a body above the picture to cut it free.</p>'
        f'<p id="no-forces" class="note">{hint or "No force acts on this body."}</p>'
        f'<div class="scroll"><table id="force-table"><thead><tr><th scope="col">Force</th>{head}'
        '<th scope="col">Unit</th></tr></thead><tbody></tbody></table></div>'
        f'<dl id="force-sum"></dl>{notes}'
    )


def _ledger(scene: Scene) -> str:
    ledger = scene.document.ledger
    if not ledger.rows:
        return ""
    heads = "".join(
        f'<th scope="col" class="number">δ{safe(symbol)}{f" [{escape(unit)}]" if unit else ""}</th>'
        for symbol, unit in zip(ledger.coordinates, ledger.units, strict=True)
    )
    count = len(ledger.coordinates)
    rows = "".join(
        f'<tr><th scope="row" class="words" dir="auto">{escape(row.name)}</th>'
        f"<td>{safe(row.displacement)}</td>" + '<td class="number"></td>' * count + "</tr>"
        for row in ledger.rows
    )
    return (
        "<p>Each force times its virtual displacement, "
        "per unit of each coordinate’s variation, now:</p>"
        '<div class="scroll"><table id="ledger"><thead><tr><th scope="col">Force</th>'
        f'<th scope="col">Virtual displacement</th>{heads}</tr></thead><tbody>{rows}</tbody>'
        f'<tfoot><tr><th scope="row" colspan="2">δW</th>{"<td class=number></td>" * count}'
        "</tr></tfoot></table></div>"
        '<p class="note">'
        "With d’Alembert’s forces among them, the virtual work is zero at every instant.</p>"
    )


def _verdict(scene: Scene) -> str:
    verdict = scene.document.verdict
    if not verdict.rows and not verdict.headline:
        return ""
    head = "".join(f'<th scope="col">{escape(column)}</th>' for column in verdict.columns)
    body = ""
    for row in verdict.rows:
        cells = "".join(f'<td class="words">{safe(cell)}</td>' for cell in row)
        body += f"<tr>{cells}</tr>"
    inner = f"<thead><tr>{head}</tr></thead><tbody>{body}</tbody>"
    table = f'<div class="scroll"><table>{inner}</table></div>'
    notes = "".join(f'<p class="note">{escape(note)}</p>' for note in verdict.notes)
    return (
        f"<p><strong>{escape(verdict.headline)}</strong></p>{table if verdict.rows else ''}{notes}"
    )


def _parameters(scene: Scene, live: bool) -> str:
    document = scene.document
    parts = [_SETUP] if scene.engine and not live else []
    if document.recorded:
        parts.append(f'<p class="note">{escape(document.recorded)}</p>')
    for title, kind, quantities in (
        ("Parameters", "parameter", document.parameters),
        ("Initial values", "initial", document.initial),
    ):
        if quantities:
            parts.append(f"<h3>{title}</h3>{_quantities(scene, kind, quantities, live)}")
    if scene.engine and not live:
        parts.append(_integration(scene.engine))
    if document.freedom:
        parts.append(
            "<h3>Degrees of freedom</h3>"
            + "".join(f"<p>{safe(each)}</p>" for each in document.freedom)
        )
    return "".join(parts)


_SETUP = (
    '<div class="bar"><button type="button" id="setup-reset">Reset</button>'
    '<button type="button" id="setup-undo" title="Undo (Ctrl+Z)" disabled>Undo</button>'
    '<button type="button" id="setup-link">Copy link</button>'
    '<button type="button" id="setup-python">Copy as Python</button>'
    '<label class="pick"><input type="checkbox" id="setup-stay"> go on from the state now</label>'
    '</div><p id="setup-status" class="note" role="status"></p>'
)


def _integration(engine: Engine) -> str:
    """The fields of the integration, and what is known of its accuracy."""
    rows = "".join(
        f'<tr><th scope="row">{title}</th><td class="number">{_field(kind, "", value, unit)}</td>'
        f'<td>{unit}</td><td class="words">{meaning}</td></tr>'
        for kind, title, value, unit, meaning in (
            ("duration", "Duration", engine.duration, "s", "of the motion"),
            ("rtol", "Tolerance", engine.rtol, "", "of each step, relative"),
        )
    )
    facts = "".join(
        f'<dt>{title}</dt><dd id="setup-{key}">–</dd>'
        for key, title in (
            ("balance", "Energy balance, missing"),
            ("error", "Largest error of a step"),
            ("steps", "Steps"),
        )
    )
    return f"<h3>Integration</h3><table><tbody>{rows}</tbody></table><dl>{facts}</dl>"


def _field(kind: str, name: str, value: float, unit: str) -> str:
    label = escape(name or {"rtol": "Tolerance"}.get(kind, kind.capitalize()))
    return (
        f'<input type="number" step="any" disabled data-kind="{kind}" data-name="{escape(name)}"'
        f' data-unit="{escape(unit)}" aria-label="{label}" value="{value:.6g}">'
    )


def _quantities(scene: Scene, kind: str, quantities: Iterable[Quantity], live: bool) -> str:
    rows = []
    known: tuple[str, ...] = ()
    if scene.engine and not live:
        known = (*scene.engine.parameters, *scene.engine.coordinates, *scene.engine.velocities)
    for each in quantities:
        own = each.name in known
        value = f"<output>{each.value:.6g}</output>"
        if own:
            value = _field(kind, each.name, each.value, each.unit)
        if (own or live) and each.low < each.high:
            value += (
                f' <input type="range" disabled data-kind="{kind}" data-name="{escape(each.name)}"'
                f' data-unit="{escape(each.unit)}" aria-label="{escape(each.name)}"'
                f' min="{each.low!r}" max="{each.high!r}" step="any"'
                f' value="{each.value!r}">'
            )
        cells = (
            f'<td class="number">{value}</td><td>{escape(each.unit)}</td>'
            f'<td class="words">{escape(each.meaning)}</td>'
        )
        rows.append(f'<tr><th scope="row">{safe(each.symbol)}</th>{cells}</tr>')
    head = (
        '<th scope="col">Symbol</th><th scope="col" class="number">Value</th>'
        '<th scope="col">Unit</th>'
    )
    return (
        f'<div class="scroll"><table><thead><tr>{head}<th scope="col">Meaning</th></tr></thead>'
        f"<tbody>{''.join(rows)}</tbody></table></div>"
    )


def _urdf(scene: Scene) -> str:
    if not scene.document.urdf:
        return ""
    return (
        '<div class="bar"><button type="button" id="save-urdf">Save the URDF</button></div>'
        f'<pre id="urdf-text" dir="ltr">{escape(scene.document.urdf)}</pre>'
    )
