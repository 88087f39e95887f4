"""Pictures of a motion: the scene as pure data, one offline page, a live view, line figures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from os import PathLike
from typing import TYPE_CHECKING, Any

from mecanique.motion.output.notebook import shown_by

if TYPE_CHECKING:
    from pathlib import Path

    from mecanique.derivation.equations import Equations
    from mecanique.model.mechanism import Mechanism
    from mecanique.motion.record.motion import Motion
    from mecanique.verification.verdict import Verdict
    from mecanique.viewing.live.live import LiveView

__all__ = ["LiveView", "export", "picture", "view"]

_HOMES = {"LiveView": "mecanique.viewing.live.live"}


def export(
    motion: Motion,
    path: str | PathLike[str],
    *,
    equations: Equations | Sequence[Equations] | None = None,
    verdict: Verdict | None = None,
) -> Path:
    """Write a motion as one HTML page that needs no network: 3-D motion, forces, equations, plots, verdict.

    Args:
        motion: what `simulate` returned.
        path: the file; it is replaced in one step, and its directory must exist.
        equations: what `derive` returned, one or several; by default every method derives them.
        verdict: what `verify` returned; by default the equations are compared at 100 states.

    Returns:
        The path written.

    Raises:
        InputError: if the directory does not exist, or the motion is none.
    """
    from mecanique.viewing.show import export as write

    return write(motion, path, equations=equations, verdict=verdict)


def view(
    shown: Motion | Mechanism,
    *,
    q: Mapping[str, float] | Sequence[float] | None = None,
    v: Mapping[str, float] | Sequence[float] | None = None,
    duration: float | None = None,
    rtol: float = 1e-10,
    speed: float = 1.0,
    port: int = 0,
    open_browser: bool = True,
) -> None:
    """Show a motion live in a browser on this machine, until Ctrl-C or the end of the process.

    A mechanism is set in motion and shown while the motion is computed. The server answers on
    127.0.0.1 only, under a random token. The motion starts when the first page shows it; equations
    and verdict arrive while it moves. Parameters and initial values can be changed in the page; the
    motion then starts again with them.

    Args:
        shown: a mechanism, or what `simulate` returned.
        q: a mechanism's position at the start: by coordinate name or shape (nq,).
        v: its velocity at the start: by name or shape (nv,).
        duration: how long it moves [s]; without end by default.
        rtol: relative tolerance of each step of a mechanism's integration.
        speed: seconds shown per second.
        port: 0 takes any free port.
        open_browser: whether to open the page; its address is printed in any case.

    Raises:
        InputError: if the port is taken, speed or duration is not above 0, or it is neither motion
            nor mechanism.
        MecaniqueError: if the mechanism's motion cannot start.
    """
    from mecanique.viewing.show import view as show

    show(
        shown,
        q=q,
        v=v,
        duration=duration,
        rtol=rtol,
        speed=speed,
        port=port,
        open_browser=open_browser,
    )


def picture(
    shown: Motion | Mechanism,
    t: float | None = None,
    path: str | PathLike[str] = "figure.svg",
    *,
    free_body: str | None = None,
    q: Mapping[str, float] | Sequence[float] | None = None,
) -> Path:
    """Draw a mechanism as a textbook line figure, or one of its bodies cut free with all forces on it.

    A planar mechanism is seen from the front (x to the right, z up) or from the top, any other in a
    parallel projection. d'Alembert's inertia forces are dashed; forces are labelled with their
    values at that instant.

    Args:
        shown: a motion, or a mechanism, which is then drawn a little off its zero position.
        t: the instant [s]; the start by default.
        path: the file, ending in .svg, .png or .pdf (the latter two need matplotlib); it is
            replaced in one step.
        free_body: the body to cut free; the whole mechanism by default.
        q: the position of a mechanism, by coordinate name or shape (nq,).

    Returns:
        The path written.

    Raises:
        InputError: if the directory does not exist, the ending is another, or t is not within the
            motion.
        UnknownNameError: if there is no such moving body.
    """
    from mecanique.figure.draw import draw

    return draw(shown, t, path, free_body, q)


def __getattr__(name: str) -> Any:
    from importlib import import_module

    if name not in _HOMES:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return getattr(import_module(_HOMES[name]), name)


def _frame(motion: Motion) -> str:
    from mecanique.viewing.show import frame

    return frame(motion)


shown_by(_frame)
