"""Draw a mechanism, or one of its bodies cut free, into a file."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from mecanique.errors import InputError, UnknownNameError
from mecanique.figure.marks import Mark
from mecanique.figure.mechanism import figure
from mecanique.figure.posture import posture
from mecanique.figure.setting import Setting, setting
from mecanique.figure.svg import svg
from mecanique.model.mechanism import Mechanism

__all__ = ["draw", "figure_text"]

FORMS = (".svg", ".png", ".pdf")


def draw(
    shown: Any, t: float | None, path: str | os.PathLike[str], free_body: str | None, q: Any
) -> Path:
    """Write a figure, see `mecanique.picture`."""
    target = Path(path)
    form = target.suffix.lower()
    if form not in FORMS:
        raise InputError(
            f"expected a path that ends in {', '.join(FORMS)}, got {os.fspath(path)!r}"
        )
    if not target.parent.is_dir():
        raise InputError(f"expected a path in a directory that exists, got {os.fspath(path)!r}")
    seen = _seen(shown, t, q)
    marks, title = _marks(seen, free_body), _title(seen, free_body)
    if form == ".svg":
        content = svg(marks, title).encode()
    else:
        from mecanique.figure.raster import raster

        content = raster(marks, form[1:])
    beside = target.with_name(f".{target.name}.{os.getpid()}.part")
    try:
        beside.write_bytes(content)
        os.replace(beside, target)
    finally:
        beside.unlink(missing_ok=True)
    return target


def figure_text(mechanism: Mechanism, start: Mapping[str, float] | None = None) -> str:
    """Return the figure of a mechanism as SVG text.

    Args:
        mechanism: what is drawn.
        start: coordinates at the start of its motion, see `posture`.
    """
    seen = _seen(mechanism, None, posture(mechanism, start))
    return svg(_marks(seen, None), _title(seen, None))


def _seen(shown: Any, t: float | None, q: Any) -> Setting:
    from mecanique.motion.record.motion import Motion

    if isinstance(shown, Motion):
        if q is not None:
            raise InputError(
                "expected no q together with a Motion, which has its own; ask for a time t instead"
            )
        state = shown(float(shown.t[0]) if t is None else t)
        return setting(
            shown.mechanism,
            shown.reference,
            np.asarray(state.q),
            np.asarray(state.v),
            float(state.t),
        )
    if isinstance(shown, Mechanism):
        from mecanique.reference import Reference

        position = posture(shown) if q is None else shown.position(q)
        return setting(
            shown, Reference(shown), position, np.zeros(shown.nv), 0.0 if t is None else float(t)
        )
    raise InputError(f"expected a Motion or a Mechanism, got {type(shown).__name__}")


def _marks(seen: Setting, free_body: str | None) -> tuple[Mark, ...]:
    if free_body is None:
        marks = figure(seen)
    else:
        from mecanique.figure.freebody import cut_free

        names = [body.name for body in seen.mechanism.bodies if body.name != seen.mechanism.ground]
        if free_body not in names:
            raise UnknownNameError("moving body", free_body, names)
        marks = cut_free(seen, free_body)
    if not marks:
        raise InputError(f"{seen.mechanism.name} has nothing that could be drawn")
    return marks


def _title(seen: Setting, free_body: str | None) -> str:
    name = seen.mechanism.name.replace("_", " ")
    return f"{name[:1].upper()}{name[1:]}" + (f": forces on {free_body}" if free_body else "")
