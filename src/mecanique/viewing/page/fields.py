"""The panel of parameters as HTML: numbers, or fields and sliders to set them."""

from __future__ import annotations

from collections.abc import Iterable
from html import escape

from mecanique.viewing.page.sanitize import safe
from mecanique.viewing.scene.document import Quantity
from mecanique.viewing.scene.engine import Engine
from mecanique.viewing.scene.scene import Scene


def write_parameters(scene: Scene, live: bool) -> str:
    """Return the panel: fields where the page or a server computes, numbers elsewhere.

    Args:
        scene: what the page shows.
        live: whether a server computes the motion; then the scene has no engine.
    """
    document = scene.document
    parts = [_SETUP] if scene.engine else []
    if document.method:
        parts.append(f'<p class="note">Recorded: {escape(document.method)}.</p>')
    if document.recorded:
        parts.append(f'<p class="note">{escape(document.recorded)}</p>')
    for title, kind, quantities in (
        ("Parameters", "parameter", document.parameters),
        ("Initial values", "initial", document.initial),
    ):
        if quantities:
            parts.append(f"<h3>{title}</h3>{_quantities(scene, kind, quantities, live)}")
    if scene.engine:
        parts += [_integration(scene.engine), _BESIDE, _MODES]
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


_BESIDE = (
    '<section class="study"><h3>Second motion</h3>'
    '<p class="note">From a start next to this one; its bodies are drawn transparent.</p>'
    '<div class="bar"><select id="beside-name" aria-label="What starts otherwise"></select> by '
    '<input type="number" step="any" id="beside-by" value="0.01" aria-label="By how much">'
    '<button type="button" id="beside-on">Show beside</button>'
    '<button type="button" id="beside-off" disabled>Remove</button></div>'
    '<p id="beside-told" class="note" role="status"></p></section>'
)

_MODES = (
    '<section class="study"><h3>Small motions</h3>'
    '<div class="bar"><button type="button" id="modes-find">Find rest and modes</button></div>'
    '<p id="modes-told" class="note" role="status"></p>'
    '<div class="scroll"><table id="modes" hidden></table></div></section>'
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
    if scene.engine:
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
