"""Show a motion: one offline page, or live in a browser on this machine."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from html import escape
from pathlib import Path
from typing import Any

from mecanique.errors import InputError, MecaniqueError
from mecanique.viewing.live.live import LiveView
from mecanique.viewing.live.moving import Moving, Recorded
from mecanique.viewing.page.page import page, write_page
from mecanique.viewing.scene.from_motion import actions_of, scene_of
from mecanique.viewing.scene.scene import Scene
from mecanique.viewing.scene.texts import document_of

__all__ = ["export", "frame", "scene", "view"]


def scene(motion: Any, equations: Sequence[Any] | Any | None = None, verdict: Any = None) -> Scene:
    """Return a motion with all that is said about it, as pure data.

    Args:
        motion: the `Motion`.
        equations: derived `Equations`, one or several; by default every method does that can be
            written out.
        verdict: the `Verdict`; by default the equations are compared at 100 states.
    """
    from mecanique.derivation import derive, readable
    from mecanique.motion.record.motion import Motion
    from mecanique.verification import verify

    if not isinstance(motion, Motion):
        raise InputError(f"expected a Motion, as simulate returns it, got {type(motion).__name__}")
    mechanism = motion.mechanism
    derived = (
        _told(lambda method: derive(mechanism, method), readable(mechanism))
        if equations is None
        else equations
    )
    several = derived if isinstance(derived, Sequence) else (derived,)
    compared = (
        next(iter(_told(lambda _: verify(mechanism), [""])), None) if verdict is None else verdict
    )
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
    shown: Any,
    *,
    q: Any,
    v: Any,
    duration: float | None,
    rtol: float,
    speed: float,
    port: int,
    open_browser: bool,
) -> None:
    """Show a motion, or a mechanism that moves while it is shown, see `mecanique.viewing`."""
    from mecanique.model.mechanism import Mechanism

    if not 0 < speed < float("inf"):
        raise InputError(f"expected a speed above 0, got {speed!r}")
    source: Moving | Recorded
    if isinstance(shown, Mechanism):
        if duration is not None and not 0 < duration < float("inf"):
            raise InputError(f"expected a duration above 0, or None for no end, got {duration!r}")
        source = Moving(shown, q, v, float("inf") if duration is None else duration, rtol, speed)
    else:
        if not (q is None and v is None and duration is None):
            raise InputError("q, v and duration belong to a mechanism; a motion has its own")
        source = Recorded(shown)
    with LiveView(
        source.presenter.first, port=port, open_browser=open_browser, at_once=True
    ) as live:
        try:
            print(f"{live.url}\nCtrl-C ends the view.", flush=True)
            live.made()
            source.presenter.check(live)
            # a page takes its time to load; nothing of the motion is missed
            live.wait()
            live.stream(lambda changes: source.frames(live, changes), speed=speed, hold=True)
        except KeyboardInterrupt:
            return
        finally:
            source.presenter.close()
