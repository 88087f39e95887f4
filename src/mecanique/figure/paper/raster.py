"""Marks as PNG or PDF, by matplotlib."""

from __future__ import annotations

from collections.abc import Sequence
from io import BytesIO

from mecanique.errors import InputError
from mecanique.figure.paper.marks import STYLES, Circle, Mark, Stroke, Words, bounds

MARGIN = 12
DPI = 192


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
    left, top, right, bottom = bounds(marks)
    x, y, width, height = (
        left - MARGIN,
        top - MARGIN,
        right - left + 2 * MARGIN,
        bottom - top + 2 * MARGIN,
    )
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
    """Write text in matplotlib's mathtext, with every character taken literally."""
    written = ""
    for text, how in words.parts:
        plain = "".join(f"\\{sign}" if sign in "\\$%#&_{}^~" else sign for sign in text)
        plain = (
            plain.replace("\\\\", "/")
            .replace("\\^", "")
            .replace("\\~", "")
            .replace(" ", "\\ ")
            .replace("\u2009", "\\,")
        )
        if how == "below":
            written += f"_{{\\mathrm{{{plain}}}}}"
        else:
            written += plain if how == "italic" else f"\\mathrm{{{plain}}}"
    return f"${written}$"
