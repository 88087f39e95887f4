"""Marks as files: SVG with colors for light and dark paper, LaTeX, PNG and PDF by matplotlib."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from html import escape
from io import BytesIO
from itertools import pairwise
from typing import Any

import numpy as np

from mecanique.derivation.printing import prose
from mecanique.errors import InputError
from mecanique.figure.paper.marks import STYLES, Circle, Mark, Point, Stroke, Style, Words, bounds
from mecanique.model.mechanism.letters import GREEK

MARGIN = 12
FONT = "'STIX Two Text','Libertinus Serif','Latin Modern Roman','Times New Roman',Times,serif"


def svg(marks: Sequence[Mark], title: str) -> str:
    """Return marks as an SVG document."""
    x, y, width, height = _frame(marks)
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


def _frame(marks: Sequence[Mark]) -> tuple[float, float, float, float]:
    """The paper of a figure: its left and upper edge, its width and height [pt]."""
    left, top, right, bottom = bounds(marks)
    width, height = right - left, bottom - top
    return left - MARGIN, top - MARGIN, width + 2 * MARGIN, height + 2 * MARGIN


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


TEX_WIDTH = 330.0
"""The largest width of a figure in LaTeX [pt]."""

_SENTENCE = re.compile(r"[^\W\d_]{2}.* ")
"""Words among letters, which are set as text."""

_CIRCLE = 0.5523
"""Handles of the four Bézier curves of a circle, in radii."""


def tex(marks: Sequence[Mark], largest: float = 1.0) -> str:
    """Return marks as a picture for pdfTeX, which needs no package; left out by other engines."""
    x, y, width, height = _frame(marks)
    scale = min(largest, TEX_WIDTH / width)

    def place(point: Sequence[float] | Point) -> Point:
        return np.array([point[0] - x, y + height - point[1]])

    drawn = [_draw(mark, place) for mark in marks if not isinstance(mark, Words)]
    words = [_typeset(mark, place) for mark in marks if isinstance(mark, Words)]
    return "\n".join(
        [
            "\\ifdefined\\pdfliteral",
            f"\\setlength{{\\unitlength}}{{{scale:.4f}bp}}%",
            f"\\begin{{picture}}({width:g},{height:g})",
            f"\\put(0,0){{\\pdfliteral{{q {scale:.4f} 0 0 {scale:.4f} 0 0 cm 1 j 1 J",
            *drawn,
            "Q}}",
            *words,
            "\\end{picture}",
            "\\fi",
        ]
    )


def _draw(mark: Stroke | Circle, place: Callable[[Any], Point]) -> str:
    """Return a mark in the operators of PDF."""
    style = STYLES[mark.style]
    ops = [f"{style.width:g} w [{style.dash}] 0 d"]
    if isinstance(mark, Circle):
        center, r = place(mark.center), mark.radius
        turns = [np.array(way) for way in ((1, 0), (0, 1), (-1, 0), (0, -1), (1, 0))]
        ops.append(f"{_pair(center + r * turns[0])} m")
        for a, b in pairwise(turns):
            handles = (a + _CIRCLE * b, b + _CIRCLE * a, b)
            ops.append(" ".join(_pair(center + r * way) for way in handles) + " c")
    else:
        first, *rest = map(place, mark.points)
        ops += [f"{_pair(first)} m", *(f"{_pair(point)} l" for point in rest)]
    if isinstance(mark, Circle) or mark.closed:
        ops.append("h")
    paints = {(True, True): "B", (True, False): "f", (False, True): "S", (False, False): "n"}
    colors = f"{_rgb(style.fill)} rg" if style.fill else ""
    colors += f" {_rgb(style.ink)} RG" if style.ink else ""
    return " ".join([colors, *ops, paints[bool(style.fill), bool(style.ink)]])


def _typeset(words: Words, place: Callable[[Any], Point]) -> str:
    """Return a letter or a few words, in the color of their style."""
    at, side = place(words.at), {"start": "[l]", "middle": "", "end": "[r]"}[words.anchor]
    color = f"\\pdfliteral{{{_rgb(STYLES[words.style].fill)} rg}}"
    written = ""
    for text, how in words.parts:
        plain = "".join(map(_tex_sign, text))
        shape = plain if how == "italic" else f"\\mathrm{{{plain}}}"
        if _SENTENCE.search(text):
            shape = f"\\textrm{{{prose.escape(text)}}}"
        written += f"_{{{shape}}}" if how == "below" else shape
    inner = f"{color}${written}$\\pdfliteral{{0 g}}"
    return f"\\put({_pair(at, ',')}){{\\makebox(0,0){side}{{{inner}}}}}"


def _math_sign(sign: str) -> str:
    """Return a character, taken literally, for mathematics in LaTeX and in matplotlib."""
    if sign in "\\$%#&_{}^~":
        return {"\\": "/", "^": "", "~": ""}.get(sign, f"\\{sign}")
    return {" ": "\\ ", "\u2009": "\\,"}.get(sign, sign)


def _tex_sign(sign: str) -> str:
    """Return a character for mathematics in LaTeX, which knows letters of ASCII alone."""
    known = {greek: f"\\{name} " for name, greek in reversed(GREEK.items())}
    known |= {"−": "-", "²": "^2", "³": "^3", "\u2009": "\\,"}
    return known.get(sign, _math_sign(sign) if sign.isascii() else "")


def _rgb(color: str) -> str:
    """Return a color #rrggbb in shares of one; with transparency, as it looks on white paper."""
    parts = [int(color[k : k + 2], 16) / 255 for k in range(1, len(color), 2)]
    opaque = parts[3] if len(parts) > 3 else 1.0
    return " ".join(f"{1 - opaque * (1 - part):.3f}" for part in parts[:3])


def _pair(point: Point, between: str = " ") -> str:
    return f"{point[0]:.2f}{between}{point[1]:.2f}"


DPI = 192  # of a PNG


def raster(marks: Sequence[Mark], form: str) -> bytes:
    """Return marks as a PNG or PDF file."""
    try:
        from matplotlib.figure import Figure
        from matplotlib.patches import Circle as Disk
        from matplotlib.patches import Polygon
    except ImportError:
        raise InputError(
            f"a figure as {form.upper()} needs matplotlib: pip install 'mecanique[plot]'; "
            "or write an SVG"
        ) from None
    x, y, width, height = _frame(marks)
    figure = Figure(figsize=(width / 72, height / 72))
    axes = figure.add_axes(
        (0.0, 0.0, 1.0, 1.0), xlim=(x, x + width), ylim=(y + height, y), aspect="equal"
    )
    axes.set_axis_off()
    for depth, mark in enumerate(marks):
        style = STYLES[mark.style]
        look = {
            "facecolor": style.fill or "none",
            "edgecolor": style.ink or "none",
            "linewidth": style.width,
            "zorder": depth,
        }
        if style.dash:
            look["linestyle"] = (
                0,
                tuple(float(length) / style.width for length in style.dash.split()),
            )
        match mark:
            case Stroke(points, _, closed):
                axes.add_patch(
                    Polygon(points, closed=closed, fill=bool(style.fill), joinstyle="round", **look)
                )
            case Circle(center, radius):
                axes.add_patch(Disk((float(center[0]), float(center[1])), radius, **look))
            case Words(at, _, _, anchor, size):
                aligned = {"start": "left", "middle": "center", "end": "right"}[anchor]
                words = axes.text(
                    float(at[0]),
                    float(at[1]),
                    _text(mark),
                    fontsize=size,
                    fontfamily="STIXGeneral",
                    color=style.fill,
                    zorder=depth,
                )
                words.set(ha=aligned, va="center_baseline", math_fontfamily="stix")
    stream = BytesIO()
    # the same figure gives the same file
    undated = {"CreationDate": None} if form == "pdf" else {"Software": None}
    figure.savefig(stream, format=form, dpi=DPI, metadata=undated)
    return stream.getvalue()


def _text(words: Words) -> str:
    """Write text with matplotlib's mathtext."""
    written, formula = "", ""
    for text, how in words.parts:
        if _SENTENCE.search(text):
            sentence = text.replace("\\", "/").replace("$", "\\$")
            written, formula = f"{written}${formula}${sentence}" if formula else sentence, ""
            continue
        plain = "".join(map(_math_sign, text))
        if how == "below":
            formula += f"_{{\\mathrm{{{plain}}}}}"
        else:
            formula += plain if how == "italic" else f"\\mathrm{{{plain}}}"
    return f"{written}${formula}$" if formula else written
