"""Marks as SVG text: words escaped, numbers short, colors by class for light and dark paper."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

from mecanique.figure.paper.marks import STYLES, Circle, Mark, Stroke, Style, Words, bounds

MARGIN = 12
FONT = "'STIX Two Text','Libertinus Serif','Latin Modern Roman','Times New Roman',Times,serif"


def svg(marks: Sequence[Mark], title: str) -> str:
    """Return marks as an SVG document."""
    left, top, right, bottom = bounds(marks)
    x, y, width, height = (
        left - MARGIN,
        top - MARGIN,
        right - left + 2 * MARGIN,
        bottom - top + 2 * MARGIN,
    )
    used = {mark.style for mark in marks}
    lines = [
        '<svg xmlns="http://www.w3.org/2000/svg"'
        f' viewBox="{x:g} {y:g} {width:g} {height:g}" width="{width:g}"'
        f' height="{height:g}" role="img" aria-label="{_clean(title)}">',
        f"<title>{_clean(title)}</title>",
        f"<style>{_styles(used)}</style>",
        *map(_write, marks),
        "</svg>",
    ]
    return "\n".join(lines) + "\n"


def _styles(used: set[str]) -> str:
    rules = [
        f"text{{font-family:{FONT};white-space:pre}}",
        "path,circle{stroke-linejoin:round;stroke-linecap:round}",
    ]
    light = [f".{name}{{{_rule(style, False)}}}" for name, style in STYLES.items() if name in used]
    dark = [f".{name}{{{_rule(style, True)}}}" for name, style in STYLES.items() if name in used]
    return "".join([*rules, *light, "@media(prefers-color-scheme:dark){", *dark, "}"])


def _rule(style: Style, dark: bool) -> str:
    fill = style.night_fill if dark else style.fill
    ink = style.night if dark else style.ink
    rule = f"fill:{fill or 'none'};stroke:{ink or 'none'}"
    if not dark and ink:
        rule += f";stroke-width:{style.width:g}"
        rule += f";stroke-dasharray:{style.dash}" if style.dash else ""
    return rule


def _write(mark: Mark) -> str:
    match mark:
        case Stroke(points, style, closed):
            path = " ".join(f"{_short(x)},{_short(y)}" for x, y in points)
            return f'<path class="{style}" d="M{path}{"z" if closed else ""}"/>'
        case Circle(center, radius, style):
            cx, cy, r = map(_short, (*center, radius))
            return f'<circle class="{style}" cx="{cx}" cy="{cy}" r="{r}"/>'
        case Words(at, parts, style, anchor, size):
            inner, sunk = "", False
            for text, how in parts:
                look = ' font-style="italic"' if how == "italic" else ""
                look += f' font-size="{_short(0.72 * size)}"' if how == "below" else ""
                shift, drop = "", 0.22 * size
                if (how == "below") != sunk:
                    sunk = not sunk
                    shift = f' dy="{_short(drop if sunk else -drop)}"'
                inner += f"<tspan{look}{shift}>{_clean(text)}</tspan>"
            # a third of the size below the point puts the middle of small letters on it
            place = f'x="{_short(at[0])}" y="{_short(at[1] + 0.33 * size)}"'
            look = f'font-size="{size:g}" text-anchor="{anchor}"'
            return f'<text class="{style}" {place} {look}>{inner}</text>'


def _short(x: float) -> str:
    return f"{round(float(x), 1) + 0.0:g}"


def _clean(text: str) -> str:
    """Escape text for XML, without the characters that XML does not allow."""
    kept = "".join(
        c for c in text if c >= " " and not 0xD800 <= ord(c) <= 0xDFFF and c not in "\ufffe\uffff"
    )
    return escape(kept)
