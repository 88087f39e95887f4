"""Show a motion: one offline page, or live in a browser on this machine."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from html import escape
from pathlib import Path
from typing import Any

from mecanique.errors import InputError, MecaniqueError
from mecanique.view.document import VerdictTable
from mecanique.view.live import Changes, LiveView
from mecanique.view.moving import MOST_COMPARED, Moving
from mecanique.view.page import page, write_page
from mecanique.view.scene import Frame, Scene
from mecanique.view.staging import actions_of, scene_of
from mecanique.view.texts import document_of

__all__ = ["export", "frame", "scene", "view"]


def scene(motion: Any, equations: Sequence[Any] | Any | None = None, verdict: Any = None) -> Scene:
    """Return a motion with all that is said about it, as pure data.

    Args:
        motion: the `Motion`.
        equations: derived `Equations`, one or several; by default every method derives them.
        verdict: the `Verdict`; by default the equations are compared at 100 states.
    """
    from mecanique.derive import METHODS, derive
    from mecanique.motion.motion import Motion
    from mecanique.verify import verify

    if not isinstance(motion, Motion):
        raise InputError(f"expected a Motion, as simulate returns it, got {type(motion).__name__}")
    mechanism = motion.mechanism
    derived = _told(lambda method: derive(mechanism, method), METHODS) if equations is None else equations
    several = derived if isinstance(derived, Sequence) else (derived,)
    compared = next(iter(_told(lambda _: verify(mechanism), [""])), None) if verdict is None else verdict
    actions = actions_of(motion)
    return scene_of(motion, document_of(motion, several, compared, actions), actions)


def _told(make: Callable[[str], Any], names: Iterable[str]) -> list[Any]:
    """What is made of each name, leaving out what the package cannot treat: a page shows the rest."""
    made = []
    for name in names:
        with suppress(MecaniqueError):
            made.append(make(name))
    return made


def export(
    motion: Any,
    path: str | os.PathLike[str],
    *,
    equations: Sequence[Any] | Any | None = None,
    verdict: Any = None,
) -> Path:
    """Write a motion as one offline page, see `mecanique.export`."""
    target = Path(path)
    if not target.parent.is_dir():
        raise InputError(f"expected a path in a directory that exists, got {os.fspath(path)!r}")
    return write_page(scene(motion, equations, verdict), target)


def frame(motion: Any) -> str:
    """Return a motion's page in a frame of its own, for a notebook: its scripts run, but see nothing around them.

    Args:
        motion: the `Motion`.
    """
    text = escape(page(scene(motion)), quote=True)
    return (
        f'<iframe sandbox="allow-scripts allow-downloads" title="{escape(repr(motion))}" srcdoc="{text}"'
        ' style="width: 100%; height: 600px; border: 0"></iframe>'
    )


def view(
    shown: Any, *, q: Any, v: Any, duration: float | None, rtol: float, speed: float, port: int, open_browser: bool
) -> None:
    """Show a motion, or a mechanism that moves while it is shown, see `mecanique.view`."""
    from mecanique.model.mechanism import Mechanism

    if not 0 < speed < float("inf"):
        raise InputError(f"expected a speed above 0, got {speed!r}")
    frames: Callable[[LiveView, Changes], Iterator[Frame]]
    if isinstance(shown, Mechanism):
        if duration is not None and not 0 < duration < float("inf"):
            raise InputError(f"expected a duration above 0, or None for no end, got {duration!r}")
        moving = Moving(shown, q, v, float("inf") if duration is None else duration, rtol)
        first, frames = moving.first, moving.frames
    else:
        if not (q is None and v is None and duration is None):
            raise InputError("q, v and duration belong to a mechanism; a motion has its own")
        first = _first(shown)
        frames = _recorded(shown, first)
    with LiveView(first, port=port, open_browser=open_browser) as live:
        print(f"{live.url}\nCtrl-C ends the view.", flush=True)
        try:
            live.stream(lambda changes: frames(live, changes), speed=speed, hold=True)
        except KeyboardInterrupt:
            return


def _recorded(motion: Any, first: Scene) -> Callable[[LiveView, Changes], Iterator[Frame]]:
    def frames(live: LiveView, changes: Changes) -> Iterator[Frame]:
        shown = first
        if changes:
            try:
                shown = _changed(motion, changes, first)
            except MecaniqueError as error:
                # the page says why nothing moves, and the next change starts anew
                shown = replace(first, document=replace(first.document, subtitle=str(error)))
            live.show(shown)
        yield from (shown.frame(k) for k in range(len(shown.t)))

    return frames


def _first(motion: Any) -> Scene:
    """What a live view begins with; a large mechanism is shown at once and not compared first."""
    mechanism = getattr(motion, "mechanism", None)
    if mechanism is None or mechanism.nv <= MOST_COMPARED:
        return scene(motion)
    actions = actions_of(motion)
    return scene_of(motion, document_of(motion, (), None, actions), actions)


def _changed(motion: Any, changes: Changes, first: Scene) -> Scene:
    """The motion again, with the values that were set in the page."""
    from mecanique.derive import derive
    from mecanique.motion import simulate

    parameters = {name: value for (kind, name), value in changes.items() if kind == "parameter"}
    mechanism = motion.mechanism.replace(**parameters)
    q = dict(zip(mechanism.coordinates, motion.q[0].tolist(), strict=True))
    v = dict(zip(mechanism.velocities, motion.v[0].tolist(), strict=True))
    for (kind, name), value in changes.items():
        if kind == "initial":
            (q if name in q else v)[name] = value
    again = simulate(mechanism, q=q, v=v, duration=float(motion.t[-1] - motion.t[0]), rtol=motion.statistics.rtol)
    actions = actions_of(again)
    document = document_of(again, [derive(mechanism)], None, actions)
    table = replace(first.document.verdict, notes=(*first.document.verdict.notes, "Found at the first values."))
    return scene_of(
        again, replace(document, verdict=table if first.document.verdict.columns else VerdictTable()), actions
    )
