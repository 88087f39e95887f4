"""The panels of a description at rest as HTML: findings, and a slider for each joint."""

from __future__ import annotations

from collections import Counter
from html import escape
from math import degrees

from mecanique.viewing.scene.inspection import Inspection, Note, Slider
from mecanique.wording import say_count

_NOTHING = "<p>Nothing was found to be wrong with it.</p>"
_OPEN = '<p class="note">Sliders move the tree of joints; what closes loops is opened by them.</p>'


def write_findings(inspection: Inspection | None) -> str:
    """Return the panel of findings on a description; empty without an inspection.

    Args:
        inspection: the description.
    """
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
    found = note.finding
    bodies = " ".join(map(str, note.bodies))
    button = f"{found.severity} {found.code}, line {found.line}"
    attributes = f' data-bodies="{bodies}" aria-pressed="false"' if bodies else " disabled"
    return (
        f'<li class="finding {found.severity}"><button type="button"{attributes}>{button}</button>'
        f' {escape(found.sentence)}<p class="note">{escape(found.remedy)}</p></li>'
    )


def write_joints(inspection: Inspection | None) -> str:
    """Return the panel of sliders; empty without any.

    Args:
        inspection: the description.
    """
    if inspection is None or not inspection.sliders:
        return ""
    rows = "".join(_slider(k, each) for k, each in enumerate(inspection.sliders))
    return (
        '<div class="bar"><button type="button" id="joints-back">Back to the start</button></div>'
        f"{_OPEN if inspection.closed else ''}"
        '<div class="scroll"><table id="joints"><thead><tr><th scope="col">Joint coordinate</th>'
        '<th scope="col">Position</th><th scope="col" class="number">Value</th>'
        f'<th scope="col">Limits</th></tr></thead><tbody>{rows}</tbody></table></div>'
    )


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
