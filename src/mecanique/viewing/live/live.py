"""The live view: a motion streamed to browsers on this machine while it happens."""

from __future__ import annotations

import threading
import time
import webbrowser
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import suppress
from dataclasses import replace
from types import TracebackType
from typing import TypeAlias, final

import numpy as np

from mecanique.errors import InputError, MecaniqueError
from mecanique.viewing.live.server import Controls, Server
from mecanique.viewing.page.panels import late
from mecanique.viewing.page.window import RecorderWindow
from mecanique.viewing.scene.scene import Derivation, Scene, SceneFrame, VerdictTable

FRAME = 1 / 60
"""The time between two pictures [s]."""


@final
class PacedClock:
    """The time shown now: it follows the wall clock at the chosen speed, and stops while paused."""

    def __init__(self, controls: Controls, start: float) -> None:
        self._controls = controls
        self._shown = start
        self._wall = time.monotonic()
        self._rate = controls.rate
        self._due = self._wall

    def now(self) -> float:
        """Return the time to be shown now [s]."""
        rate = self._controls.rate
        if rate != self._rate:
            wall = time.monotonic()
            self._shown += (wall - self._wall) * self._rate
            self._wall, self._rate = wall, rate
        return self._shown + (time.monotonic() - self._wall) * self._rate

    def skip_delay(self, t: float, most: float = 0.1) -> None:
        """Set the clock back to a source that is more than `most` seconds of wall time behind."""
        if self.now() - t > most * max(self._rate, 1e-9):
            self._shown, self._wall = t, time.monotonic()

    def until(self, t: float) -> float:
        """Return how long until a time is shown [s of wall time]; a frame's time while paused."""
        return max(0.0, (t - self.now()) / self._rate) if self._rate > 0 else FRAME

    def rest(self, period: float) -> None:
        """Sleep until the next picture is due, on a grid that does not drift."""
        wall = time.monotonic()
        self._due = max(self._due + period, wall)
        self._controls.rest(self._due - wall)


Changes: TypeAlias = Mapping[tuple[str, str], float]
"""New values by ("parameter" or "initial", name), as set on the page so far."""

Frames: TypeAlias = "Iterable[SceneFrame] | Callable[[Changes], Iterable[SceneFrame]]"


@final
class LiveView:
    """A scene in a server of its own on 127.0.0.1, for any number of browsers."""

    def __init__(
        self,
        scene: Scene,
        *,
        port: int = 0,
        token: str | None = None,
        open_browser: bool = False,
        at_once: bool = False,
    ) -> None:
        self._controls = Controls()
        self._scene = scene
        self._texts = threading.Lock()
        self._server = Server(self._controls, port=port, token=token)
        self._page = self._server.show(scene)
        self._alarm()
        self.send(scene.frame(0))
        if not at_once:
            self.await_page()
        if open_browser:
            webbrowser.open(self.url)

    @property
    def url(self) -> str:
        """The address to open, with its token."""
        return self._server.url

    @property
    def window(self) -> RecorderWindow:
        """A window for `meshcat.Visualizer(window=…)`, to draw your own things into the scene."""
        return self._server.window

    @property
    def viewers(self) -> int:
        """How many pages are open."""
        return self._server.viewers

    @property
    def speed(self) -> float:
        """Seconds shown per second, as last set."""
        return self._controls.speed

    @property
    def scene(self) -> Scene:
        """What is shown."""
        return self._scene

    @property
    def latest(self) -> SceneFrame:
        """The instant that is shown."""
        return self._latest

    def show(self, scene: Scene, *, keep: bool = False) -> None:
        """Replace the scene; open pages load the new one."""
        with self._texts:
            if keep:
                now = self._scene.document
                document = replace(scene.document, derivations=now.derivations, verdict=now.verdict)
                scene = replace(scene, document=document)
            self._scene = scene
            self._page = self._server.show(scene)
            self._alarm()
        self._page.result()
        self.send(scene.frame(0))

    def annotate(self, derivations: tuple[Derivation, ...], verdict: VerdictTable) -> None:
        """Put equations and a verdict beside the scene; open pages show them without reloading."""
        with self._texts:
            document = replace(self._scene.document, derivations=derivations, verdict=verdict)
            self._scene = replace(self._scene, document=document)
            self._server.note({**late(self._scene), "alarm": ""})
            self._alarm()

    def _alarm(self) -> None:
        verdict = self._scene.document.verdict
        if verdict.agrees is False:
            self._server.note({"alarm": f"Derivation and reference disagree: {verdict.headline}"})

    def warn(self, text: str) -> None:
        """Warn in every page that something went wrong."""
        self._server.note({"warning": text})

    def send(self, frame: SceneFrame) -> None:
        """Show an instant at once, without waiting for any clock."""
        points = np.asarray(frame.traces).astype("<f4").tobytes()
        self._server.publish(frame.t, row(frame, self._scene), points)
        self._latest = frame

    def await_page(self) -> None:
        """Wait until the page is made; a view without one is closed."""
        try:
            self._page.result()
        except MecaniqueError:
            self.close()
            raise

    def announce(self) -> None:
        """Print the page's address, and wait until the page is made."""
        print(f"{self.url}\nCtrl-C ends the view.", flush=True)
        self.await_page()

    def wait(self, period: float = 0.2) -> bool:
        """Wait until a page has shown something or the view is closed; return whether one has."""
        while not (self._controls.closed or self._server.seen.wait(period)):
            pass
        return self._server.seen.is_set()

    def stream(self, frames: Frames, *, speed: float = 1.0, hold: bool = False) -> None:
        """Show each frame at its time; return when there are no more."""
        self._controls.begin(speed)
        self._server.announce()
        while True:
            source = frames(self._controls.changes()) if callable(frames) else frames
            self._run(iter(source))
            while hold and not self._controls.closed and not self._controls.restart_wanted:
                self._controls.rest(0.2)
            if self._controls.closed or not callable(frames) or not self._controls.take_restart():
                return
            self._server.announce(restart=True)

    def _run(self, frames: Iterator[SceneFrame]) -> None:
        """Stream until the end, or until the page asks to start again."""
        clock: PacedClock | None = None
        for frame in frames:
            clock = clock or PacedClock(self._controls, frame.t)
            while (
                not (self._controls.closed or self._controls.restart_wanted)
                and clock.now() < frame.t
            ):
                self._controls.rest(min(FRAME, clock.until(frame.t)))
            if self._controls.closed or self._controls.restart_wanted:
                return
            # after a delay the picture does not catch up at double speed
            clock.skip_delay(frame.t)
            self.send(frame)

    def close(self) -> None:
        """Stop the server; open pages report that the connection is lost."""
        self._controls.close()
        self._server.close()

    def __enter__(self) -> LiveView:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    def __del__(self) -> None:
        with suppress(Exception):
            self.close()


def row(frame: SceneFrame, scene: Scene) -> bytes:
    """Pack a frame for the page: the numbers of one instant in single precision."""
    ledger = scene.document.ledger
    expected = {
        "positions": (len(scene.bodies), 3),
        "quaternions": (len(scene.bodies), 4),
        "arrows": (len(scene.arrows), 2, 3),
        "lines": (len(scene.lines), 2, 3),
        "traces": (len(scene.traces), 3),
        "series": (len(scene.series) + len(ledger.rows) * len(ledger.coordinates),),
    }
    for name, shape in expected.items():
        got = np.shape(getattr(frame, name))
        if got != shape:
            raise InputError(f"{name} of a frame: expected shape {shape}, got {got}")
    poses = np.concatenate([frame.positions, frame.quaternions], axis=1)
    rest = (frame.arrows, frame.lines, frame.traces, frame.series)
    numbers = np.concatenate([poses.ravel(), *(np.ravel(part) for part in rest)]).astype("<f4")
    if not (np.isfinite(frame.t) and np.all(np.isfinite(numbers))):
        raise InputError(f"frame at t = {frame.t}: expected finite numbers")
    return numbers.tobytes()
