"""Show a motion live in a browser on this machine."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from mecanique.errors import InputError
from mecanique.model.mechanism import Mechanism
from mecanique.motion.record.motion import Motion
from mecanique.viewing.live.computing import Computing, begin
from mecanique.viewing.live.live import LiveView
from mecanique.viewing.live.moving import Moving, Recorded


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

    Example:
        >>> mq.view(mq.textbook.load("double_pendulum"), q={"q1": 2.0}, open_browser=False)
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
            live.announce()
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
            live.announce()
            source.presenter.check(live)
            # a page takes its time to load, but shows the motion from its start
            live.wait()
            live.stream(lambda changes: source.frames(live, changes), speed=speed, hold=True)
        except KeyboardInterrupt:
            return
        finally:
            source.presenter.close()
