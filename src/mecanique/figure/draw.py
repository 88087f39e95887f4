"""Draw a mechanism, or one of its bodies cut free, into a file."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import final, overload

import numpy as np

from mecanique.errors import InputError, UnknownNameError
from mecanique.figure.mechanism import figure
from mecanique.figure.paper.files import svg, tex
from mecanique.figure.paper.marks import Mark
from mecanique.figure.setting import HEIGHT, WIDTH, Setting, posture, setting
from mecanique.files import require_directory, write_whole
from mecanique.model.mechanism import Mechanism
from mecanique.motion.motion import Motion
from mecanique.reference import Reference
from mecanique.wording import to_title

FORMS = (".svg", ".png", ".pdf")

SMALL = (165.0, 120.0)
"""The largest extent of a small figure's solids [pt]."""


@final
@dataclass(frozen=True, repr=False)
class Drawing:
    """A line figure; a notebook shows it.

    Args:
        title: what it shows.
        svg: the figure as SVG text.

    Example:
        >>> mq.picture(mq.textbook.load("cart_pole"), free_body="cart").title
        'Cart pole: forces on cart'
    """

    title: str
    svg: str

    def __repr__(self) -> str:
        return f"<Drawing: {self.title}>"

    def _repr_html_(self) -> str:
        return f'<div style="max-width: 100%; overflow: auto hidden">{self.svg}</div>'


@overload
def picture(
    shown: Motion | Mechanism,
    t: float | None = None,
    path: None = None,
    *,
    free_body: str | None = None,
    resultants: bool = False,
    numbers: bool = False,
    q: Mapping[str, float] | Sequence[float] | None = None,
) -> Drawing: ...


@overload
def picture(
    shown: Motion | Mechanism,
    t: float | None = None,
    path: str | os.PathLike[str] = ...,
    *,
    free_body: str | None = None,
    resultants: bool = False,
    numbers: bool = False,
    q: Mapping[str, float] | Sequence[float] | None = None,
) -> Path: ...


def picture(
    shown: Motion | Mechanism,
    t: float | None = None,
    path: str | os.PathLike[str] | None = None,
    *,
    free_body: str | None = None,
    resultants: bool = False,
    numbers: bool = False,
    q: Mapping[str, float] | Sequence[float] | None = None,
) -> Drawing | Path:
    """Draw a mechanism as a textbook line figure, or a body cut free with all forces on it.

    A planar mechanism is seen from the front (x to the right, z up) or from the top, any other in a
    parallel projection. On a body cut free, reactions are drawn by their components along the axes
    of its equations, in the sense that counts positive there; d'Alembert's inertia forces are
    dashed.

    Args:
        shown: a motion, or a mechanism, which is drawn a little away from its zero position.
        t: the instant [s]; the start by default.
        path: the file, ending in .svg, .png or .pdf (the latter two need matplotlib); it is
            replaced in one step. Without one no file is written.
        free_body: the body to cut free; the whole mechanism by default.
        resultants: whether each reaction on it is one arrow, not its components.
        numbers: whether the values of its forces stand beside their letters, to scale.
        q: the position of a mechanism, by coordinate name or shape (nq,).

    Returns:
        The path written; without a path the figure itself, which a notebook shows.

    Raises:
        InputError: if the directory does not exist, the ending is another, or t is not within the
            motion.
        UnknownNameError: if there is no such moving body.

    Example:
        >>> crank = mq.textbook.load("slider_crank")
        >>> mq.picture(crank)
        <Drawing: Slider crank>
        >>> mq.picture(crank, path="crank.svg").name
        'crank.svg'
        >>> mq.picture(crank, path="rod.svg", free_body="rod").name
        'rod.svg'
    """
    form = "" if path is None else _check(path)
    if isinstance(shown, Motion):
        seen = _set_up_motion(shown, t, q, whole=free_body is None)
    else:
        seen = _set_up(shown, t, q)
    marks = _marks(seen, free_body, resultants=resultants, numbers=numbers)
    title = _title(seen, free_body)
    if path is None:
        return Drawing(title, svg(marks, title))
    if form == ".svg":
        content = svg(marks, title).encode()
    else:
        from mecanique.figure.paper.files import raster

        content = raster(marks, form[1:])
    target = Path(path)
    with write_whole(target) as file:
        file.write(content)
    return target


def _check(path: str | os.PathLike[str]) -> str:
    """Return the ending of a path that a figure can be written to, or refuse it."""
    form = Path(path).suffix.lower()
    if form not in FORMS:
        raise InputError(
            f"expected a path that ends in {', '.join(FORMS)}, got {os.fspath(path)!r}"
        )
    require_directory(path)
    return form


SMALLER = 0.7
"""The largest scale of bodies cut free in a document, where two stand beside each other."""


def figure_text(
    mechanism: Mechanism, start: Mapping[str, float] | None = None, *, small: bool = False
) -> str:
    """Return the figure of a mechanism as SVG text."""
    position = posture(mechanism, start)
    seen = _set_up(mechanism, None, position, extent=SMALL if small else (WIDTH, HEIGHT))
    return svg(_marks(seen, None, legend=not small), _title(seen, None))


def figure_tex(
    mechanism: Mechanism, start: Mapping[str, float] | None = None, free_body: str | None = None
) -> str:
    """Return the figure of a mechanism, or of a body cut free, for a LaTeX document."""
    marks = _marks(_set_up(mechanism, None, posture(mechanism, start)), free_body)
    return tex(marks, SMALLER if free_body else 1.0)


def _set_up_motion(shown: Motion, t: float | None, q: object, *, whole: bool) -> Setting:
    if q is not None:
        raise InputError(
            "expected no q together with a Motion, which has its own; ask for a time t instead"
        )
    state = shown(float(shown.t[0]) if t is None else t)
    # what touches is drawn as itself; on a body cut free as its forces
    mechanism, reference = shown.mechanism, shown.reference
    switching = shown.described.switching if whole else ()
    if switching:
        mechanism = replace(shown.described, switching=())
        reference = Reference.of(mechanism)
    return setting(
        mechanism,
        reference,
        np.asarray(state.q),
        np.asarray(state.v),
        float(state.t),
        switching=switching,
    )


def _set_up(
    shown: Mechanism,
    t: float | None,
    q: Mapping[str, float] | Sequence[float] | np.ndarray | None,
    extent: tuple[float, float] = (WIDTH, HEIGHT),
) -> Setting:
    if isinstance(shown, Mechanism):
        position = posture(shown) if q is None else shown.position(q)
        instant = 0.0 if t is None else float(t)
        switching = shown.switching
        if switching:  # the reference is asked for places alone, whatever the mode
            shown = replace(shown, switching=())
        reference, rest = Reference.of(shown), np.zeros(shown.nv)
        return setting(shown, reference, position, rest, instant, extent, switching)
    raise InputError(f"expected a Motion or a Mechanism, got {type(shown).__name__}")


def _marks(
    seen: Setting,
    free_body: str | None,
    *,
    resultants: bool = False,
    numbers: bool = False,
    legend: bool = True,
) -> tuple[Mark, ...]:
    if free_body is None:
        marks = figure(seen, legend=legend)
    else:
        from mecanique.figure.freebody import cut_free

        names = [body.name for body in seen.mechanism.bodies if body.name != seen.mechanism.ground]
        if free_body not in names:
            raise UnknownNameError("moving body", free_body, names)
        marks = cut_free(seen, free_body, resultants=resultants, numbers=numbers)
    if not marks:
        raise InputError(f"{seen.mechanism.name} has nothing that could be drawn")
    return marks


def _title(seen: Setting, free_body: str | None) -> str:
    return to_title(seen.mechanism.name) + (f": forces on {free_body}" if free_body else "")
