"""The page's tabs as HTML: equations, plots, forces, virtual work, verdict, parameters, URDF."""

from __future__ import annotations

from collections.abc import Callable
from html import escape

from mecanique.viewing.page.equations import write_equations
from mecanique.viewing.page.fields import write_parameters
from mecanique.viewing.page.inspecting import write_findings, write_joints
from mecanique.viewing.page.sanitize import safe
from mecanique.viewing.scene.document import VerdictTable
from mecanique.viewing.scene.scene import Scene

_OF_MOTION = ("plots", "parameters", "forces")
"""Panels without a tab where nothing moves."""


def panels(scene: Scene, *, live: bool) -> tuple[str, str]:
    """Return the tabs and their panels, without those for which the scene has no content.

    Args:
        scene: what the page shows.
        live: whether parameters and initial values get sliders.
    """
    makers: list[tuple[str, str, Callable[[], str]]] = [
        ("findings", "Findings", lambda: write_findings(scene.inspection)),
        ("joints", "Joints", lambda: write_joints(scene.inspection)),
        ("equations", "Equations", lambda: write_equations(scene.document)),
        ("plots", "Plots", lambda: _plots(scene)),
        ("parameters", "Parameters", lambda: write_parameters(scene, live)),
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
        '<label class="pick">over <select id="plot-x">'
        '<option value="">time</option></select></label>'
        '<label class="pick" hidden>where <select id="plot-at">'
        '<option value="">always</option></select></label>'
        '<button type="button" id="csv" title="Save the chosen quantities">CSV</button>'
        '<button type="button" id="svg" title="Save the plots as a picture">SVG</button></div>'
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
        f"{_proof(verdict)}"
    )


def _proof(verdict: VerdictTable) -> str:
    """By how much the page's own program differs."""
    if not verdict.own:
        return ""
    rows = "".join(
        f'<tr><th scope="row" class="words">{escape(name)}</th><td>{escape(worst)}</td></tr>'
        for name, worst in verdict.own
    )
    return (
        f"<h3>The program of this page</h3>"
        '<table><thead><tr><th scope="col">difference from the reference</th>'
        f'<th scope="col">worst, relative</th></tr></thead><tbody>{rows}</tbody></table>'
        f'<p class="note">{escape(verdict.own_note)}</p>'
    )


def _urdf(scene: Scene) -> str:
    if not scene.document.urdf:
        return ""
    return (
        '<div class="bar"><button type="button" id="save-urdf">Save the URDF</button></div>'
        f'<pre id="urdf-text" dir="ltr">{escape(scene.document.urdf)}</pre>'
    )
