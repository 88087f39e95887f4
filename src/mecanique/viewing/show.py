"""Show a motion: one offline page, or live in a browser on this machine."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from html import escape
from pathlib import Path

from mecanique.derivation import derive, readable
from mecanique.derivation.equations import Equations
from mecanique.errors import InputError, MecaniqueError
from mecanique.files import write_whole
from mecanique.model.mechanism import Mechanism
from mecanique.motion.record.motion import Motion
from mecanique.verification import verify
from mecanique.verification.verdict import Verdict
from mecanique.viewing.engine.attach import computed_scene
from mecanique.viewing.live.computing import Computing, begin
from mecanique.viewing.live.live import LiveView
from mecanique.viewing.live.moving import Moving, Recorded
from mecanique.viewing.page.page import page
from mecanique.viewing.scene.from_motion import actions_of
from mecanique.viewing.scene.scene import Scene
from mecanique.viewing.scene.texts import document_of

__all__ = ["export", "frame", "scene", "view"]


def scene(
    motion: Motion,
    equations: Equations | Sequence[Equations] | None = None,
    verdict: Verdict | None = None,
) -> Scene:
    """Return a motion with all its texts, as pure data.

    Args:
        motion: what `simulate` returned.
        equations: one or several; by default those of every method that can be written out.
        verdict: by default the equations are compared at 100 states.
    """
    if not isinstance(motion, Motion):
        raise InputError(f"expected a Motion, as simulate returns it, got {type(motion).__name__}")
    if equations is None:
        equations = tuple(_derive_all(motion.mechanism))
    elif isinstance(equations, Equations):
        equations = (equations,)
    if verdict is None:
        with suppress(MecaniqueError):
            verdict = verify(motion.mechanism)
    actions = actions_of(motion)
    return computed_scene(
        motion, document_of(motion, equations, verdict, actions), actions, equations
    )


def _derive_all(mechanism: Mechanism) -> Iterator[Equations]:
    """Derive by each method, skipping those that do not apply: a page shows the rest.

    Where Lagrange's equations are too long to be read, the others are longer and take minutes.
    """
    shortest = derive(mechanism)
    if shortest.symbolic and not shortest.legible:
        yield shortest
        return
    for method in readable(mechanism):
        with suppress(MecaniqueError):
            yield shortest if method == shortest.method else derive(mechanism, method)


def export(
    motion: Motion,
    path: str | os.PathLike[str],
    *,
    equations: Equations | Sequence[Equations] | None = None,
    verdict: Verdict | None = None,
) -> Path:
    """Write a motion as one offline HTML page: 3-D motion, forces, equations, plots, verdict.

    Args:
        motion: what `simulate` returned.
        path: the file; it is replaced in one step, and its directory must exist.
        equations: what `derive` returned, one or several; by default every method derives them.
        verdict: what `verify` returned; by default the equations are compared at 100 states.

    Returns:
        The path written.

    Raises:
        InputError: if the directory does not exist, or it is no motion.
    """
    target = Path(path)
    if not target.parent.is_dir():
        raise InputError(f"expected a path in a directory that exists, got {os.fspath(path)!r}")
    text = page(scene(motion, equations, verdict))
    with write_whole(target) as file:
        file.write(text.encode())
    return target


def frame(motion: Motion) -> str:
    """Return a motion's page in a frame for a notebook, isolated from everything around it."""
    text = escape(page(scene(motion)), quote=True)
    return (
        f'<iframe sandbox="allow-scripts allow-downloads" title="{escape(repr(motion))}"'
        f' srcdoc="{text}" style="width: 100%; height: 600px; border: 0"></iframe>'
    )


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

    The page is the one `export` writes: it computes the motion by itself, and equations and verdict
    arrive while it moves. What a page cannot compute (more than 12 velocities, inputs that are
    functions of Python) is computed here and streamed; it starts when the first page shows it, and
    again when parameters or initial values change in the page. The server answers on 127.0.0.1
    only, under a random token.

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
    if not 0 < speed < float("inf"):
        raise InputError(f"expected a speed above 0, got {speed!r}")
    if isinstance(shown, Mechanism):
        if duration is not None and not 0 < duration < float("inf"):
            raise InputError(f"expected a duration above 0, or None for no end, got {duration!r}")
    elif not (q is None and v is None and duration is None):
        raise InputError("q, v and duration belong to a mechanism; a motion has its own")
    elif not isinstance(shown, Motion):
        raise InputError(
            f"expected a Motion, as simulate returns it, or a Mechanism, got {type(shown).__name__}"
        )
    end = float("inf") if duration is None else duration
    computing = begin(shown, q, v, end, rtol, speed)
    if computing:
        _serve(computing, port, open_browser, speed)
    elif isinstance(shown, Mechanism):
        _stream(Moving(shown, q, v, end, rtol, speed), port, open_browser, speed)
    else:
        _stream(Recorded(shown), port, open_browser, speed)


def _serve(computing: Computing, port: int, open_browser: bool, speed: float) -> None:
    """Serve a page that computes its motion by itself."""
    with LiveView(computing.scene, port=port, open_browser=open_browser, at_once=True) as live:
        try:
            print(f"{live.url}\nCtrl-C ends the view.", flush=True)
            live.await_page()
            computing.check(live)
            live.stream(lambda changes: (), speed=speed, hold=True)
        except KeyboardInterrupt:
            return
        finally:
            computing.close()


def _stream(source: Moving | Recorded, port: int, open_browser: bool, speed: float) -> None:
    """Stream a motion that is computed here."""
    with LiveView(
        source.presenter.first, port=port, open_browser=open_browser, at_once=True
    ) as live:
        try:
            print(f"{live.url}\nCtrl-C ends the view.", flush=True)
            live.await_page()
            source.presenter.check(live)
            # a page takes its time to load, but shows the motion from its start
            live.wait()
            live.stream(lambda changes: source.frames(live, changes), speed=speed, hold=True)
        except KeyboardInterrupt:
            return
        finally:
            source.presenter.close()
