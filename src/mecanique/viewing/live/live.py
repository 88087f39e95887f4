"""The live view: a motion streamed to browsers on this machine while it happens."""

from __future__ import annotations

import asyncio
import json
import math
import re
import secrets
import socket
import struct
import threading
import time
import webbrowser
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping
from concurrent.futures import Future
from contextlib import suppress
from dataclasses import replace
from functools import partial
from types import TracebackType
from typing import Any, TypeAlias, final

import numpy as np
import tornado.httpserver
import tornado.web
import tornado.websocket

from mecanique.errors import InputError, MecaniqueError
from mecanique.viewing.page.page import Stream, page
from mecanique.viewing.page.panels import late
from mecanique.viewing.scene.scene import Scene, SceneFrame, ShownDerivation, VerdictTable

LONGEST = 512
"""Longest message taken from a page [characters]."""

_KEYS = {
    "ack": {"do", "value"},
    "pause": {"do"},
    "resume": {"do"},
    "reset": {"do"},
    "speed": {"do", "value"},
    "parameter": {"do", "name", "value"},
    "initial": {"do", "name", "value"},
}


def read(text: str | bytes) -> dict[str, Any] | None:
    """Return a page's message if it is well-formed, else None."""
    if not isinstance(text, str) or len(text) > LONGEST:
        return None
    try:
        message = json.loads(text)
    except (ValueError, RecursionError):
        return None
    if not isinstance(message, dict) or not isinstance(message.get("do"), str):
        return None
    if set(message) != _KEYS.get(message["do"]):
        return None
    value = message.get("value", 0.0)
    # to Python a bool is an int, and its JSON reader accepts NaN
    if isinstance(value, bool) or not isinstance(value, (int, float)) or not _finite(value):
        return None
    if not isinstance(message.get("name", ""), str):
        return None
    if message["do"] == "speed" and not 1e-3 <= value <= 1e3:
        return None
    return message


def _finite(value: float) -> bool:
    try:
        return math.isfinite(value)
    except OverflowError:
        return False


@final
class Controls:
    """Requests of the pages, shared by the server's thread and the streaming thread."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._wake = threading.Event()
        self.speed = 1.0  # seconds shown per second when not paused
        self.paused = False
        self.closed = False
        self.restart_wanted = False
        self._values: dict[tuple[str, str], float] = {}

    def begin(self, speed: float) -> None:
        """Start a stream: running, at a speed, with nothing asked for."""
        with self._lock:
            self.speed, self.paused, self.restart_wanted = float(speed), False, False

    def obey(self, message: dict[str, Any]) -> None:
        """Note what a page asks for."""
        do, value = message["do"], float(message.get("value", 0.0))
        with self._lock:
            if do in ("pause", "resume"):
                self.paused = do == "pause"
            elif do == "speed":
                self.speed = value
            elif do == "reset":
                self.restart_wanted = True
            elif do in ("parameter", "initial"):
                self._values[do, message["name"]] = value
                self.restart_wanted = True
        self._wake.set()

    @property
    def rate(self) -> float:
        """Seconds shown per second, 0 while paused."""
        with self._lock:
            return 0.0 if self.paused else self.speed

    def take_restart(self) -> bool:
        """Return whether a page asked to start again, and forget it."""
        with self._lock:
            wanted, self.restart_wanted = self.restart_wanted, False
        return wanted

    def changes(self) -> dict[tuple[str, str], float]:
        """Return the values set so far, by kind and name."""
        with self._lock:
            return dict(self._values)

    def rest(self, seconds: float) -> None:
        """Sleep, but wake when a page asks for something."""
        if seconds > 0 and self._wake.wait(seconds):
            self._wake.clear()

    def close(self) -> None:
        """Signal the stream to stop."""
        self.closed = True
        self._wake.set()


ADDRESS = "127.0.0.1"
IN_FLIGHT = 2
"""Frames sent to a page before it has shown one; a slow page skips those in between."""

_MOST_PASSED = 240
"""Frames of which a page still gets the traces if it was slow."""


@final
class Server:
    """Serves one scene and its latest frame."""

    def __init__(self, controls: Controls, *, port: int, token: str | None) -> None:
        if token is not None and not re.fullmatch(r"[\w-]{8,}", token, re.ASCII):
            raise InputError("token of a live view: expected 8 or more letters, digits, - or _")
        if not 0 <= port <= 65535:
            raise InputError(f"port of a live view: expected 0 to 65535, got {port}")
        self.controls = controls
        self.page: Future[str] = Future()
        self.clients: set[_Socket] = set()
        self.seen = threading.Event()
        self._token = token or secrets.token_urlsafe(18)
        self._identity = ""
        self._notes: dict[str, str] = {}
        self._frame: tuple[float, bytes] = (0.0, b"")
        self._passed: deque[tuple[int, bytes]] = deque(maxlen=_MOST_PASSED)
        self._number = 0
        self._lock = threading.Lock()
        self._loop = asyncio.new_event_loop()
        self._closed = False
        self._maker: threading.Thread | None = None
        try:
            made = socket.socket(socket.AF_INET, socket.SOCK_STREAM)
            try:
                made.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
                made.setblocking(False)
                made.bind((ADDRESS, port))
                made.listen(64)
            except OSError:
                made.close()
                raise
            self._socket = made
        except OSError as error:
            self._loop.close()
            raise InputError(
                f"port {port} of {ADDRESS}: {error.strerror}; expected a free one, or 0"
            ) from error
        self.port: int = self._socket.getsockname()[1]
        self.hosts = f"{ADDRESS}:{self.port}", f"localhost:{self.port}"
        self.url = f"http://{self.hosts[0]}/{self._token}/"
        self._thread = threading.Thread(target=self._serve, name="mecanique live view", daemon=True)
        self._thread.start()

    def show(self, scene: Scene) -> Future[str]:
        """Serve a new scene; pages that show another one load it."""
        identity = secrets.token_urlsafe(9)
        stream = Stream(identity, tuple(f"ws://{host}" for host in self.hosts))
        made: Future[str] = Future()
        with self._lock:
            self.page, self._identity = made, identity
            self._frame, self._notes = (0.0, b""), {}
            self._passed.clear()
        making = partial(_make, made, scene, stream)
        self._maker = threading.Thread(target=making, name="mecanique page", daemon=True)
        self._maker.start()
        self.announce()
        return made

    def publish(self, t: float, row: bytes, points: bytes = b"") -> None:
        """Make a frame the present one; a page gets it when ready unless a later one comes."""
        with self._lock:
            if t < self._frame[0]:
                self._passed.clear()
            self._frame, self._number = (t, row), self._number + 1
            self._passed.append((self._number, points))
        self._call(self._flush)

    def note(self, notes: dict[str, str]) -> None:
        """Send notes on the scene to every page, including those opened later."""
        with self._lock:
            self._notes |= notes
        self._call(self._spread, json.dumps({"notes": notes}))

    def announce(self, *, restart: bool = False) -> None:
        """Send all pages the state of the view."""
        self._call(self._spread, self.state(restart=restart))

    def close(self) -> None:
        """Stop answering, release the port and end the thread."""
        if self._closed:
            return
        self._closed = True
        self._loop.call_soon_threadsafe(self._loop.stop)
        for thread in (self._thread, self._maker):
            if thread not in (None, threading.current_thread()):
                thread.join(timeout=5)

    def state(self, *, restart: bool = False) -> str:
        """Return the state of the view as JSON."""
        with self._lock:
            state = {"scene": self._identity, "restart": restart}
        values = [[kind, name, value] for (kind, name), value in self.controls.changes().items()]
        return json.dumps(
            state | {"paused": self.controls.paused, "speed": self.controls.speed, "values": values}
        )

    def notes(self) -> dict[str, str]:
        """Return what has been noted about the scene since it was served."""
        with self._lock:
            return dict(self._notes)

    def latest(self, since: int = 0) -> tuple[int, bytes | None]:
        """Return the present frame's number, and the frame as a page reads it."""
        with self._lock:
            (t, row), number = self._frame, self._number
            passed = b"".join(points for k, points in self._passed if 0 < since < k < number)
        head = struct.pack("<IId", number & 0xFFFFFFFF, len(passed) // 4, t)
        return number, head + row + passed if row else None

    def _call(self, function: Callable[..., None], *arguments: Any) -> None:
        if not self._closed:
            self._loop.call_soon_threadsafe(function, *arguments)

    def _spread(self, text: str) -> None:
        for client in list(self.clients):
            client.transmit(text)

    def _flush(self) -> None:
        for client in list(self.clients):
            client.catch_up()

    def _serve(self) -> None:
        asyncio.set_event_loop(self._loop)
        self._loop.run_until_complete(self._listen())
        self._loop.run_forever()
        self._loop.run_until_complete(self._end())
        self._loop.close()

    async def _listen(self) -> None:
        settings = {"server": self}
        path = f"/{re.escape(self._token)}/"
        application = tornado.web.Application(
            [(path, _Page, settings), (f"{path}ws", _Socket, settings)],
            default_handler_class=_Nothing,
            default_handler_args=settings,
            log_function=lambda handler: None,
            websocket_max_message_size=4 * LONGEST,
        )
        self._http = tornado.httpserver.HTTPServer(
            application, max_body_size=1024, max_header_size=16_384
        )
        self._http.add_socket(self._socket)

    async def _end(self) -> None:
        self._http.stop()
        for client in list(self.clients):
            client.close(1001, "closed")
        await self._http.close_all_connections()
        rest = [task for task in asyncio.all_tasks() if task is not asyncio.current_task()]
        for task in rest:
            task.cancel()
        await asyncio.gather(*rest, return_exceptions=True)


def _make(made: Future[str], scene: Scene, stream: Stream) -> None:
    try:
        made.set_result(page(scene, stream))
    except BaseException as error:  # raised where the page is waited for
        made.set_exception(error)


class _Guarded(tornado.web.RequestHandler):
    """Answer only under the loopback's names, so that no foreign name can point here."""

    def initialize(self, server: Server) -> None:
        self.server = server

    def prepare(self) -> None:
        if self.request.host not in self.server.hosts:
            raise tornado.web.HTTPError(403)

    def set_default_headers(self) -> None:
        self.clear_header("Server")
        self.set_header("X-Content-Type-Options", "nosniff")
        self.set_header("Cross-Origin-Resource-Policy", "same-origin")
        self.set_header("Referrer-Policy", "no-referrer")
        self.set_header("Cache-Control", "no-store")

    def write_error(self, status_code: int, **kwargs: Any) -> None:
        self.finish(f"{status_code}\n")


@final
class _Nothing(_Guarded):
    def prepare(self) -> None:
        super().prepare()
        raise tornado.web.HTTPError(404)


@final
class _Page(_Guarded):
    async def get(self) -> None:
        self.set_header("Content-Security-Policy", "frame-ancestors 'none'")
        try:
            text = await asyncio.shield(asyncio.wrap_future(self.server.page))
        except MecaniqueError as error:
            self.set_status(500)
            text = f"{error}\n"
        self.finish(text)


@final
class _Socket(tornado.websocket.WebSocketHandler):
    """One open page: messages still to be sent, and frames it has not shown yet."""

    def initialize(self, server: Server) -> None:
        self.server = server
        self.sent: list[int] = []
        self.last = 0

    def prepare(self) -> None:
        # a browser always names the origin of a websocket; tornado itself would let pass requests
        # without one, and those whose headers say that they are same-origin
        if self.request.host not in self.server.hosts or not self.check_origin(
            self.request.headers.get("Origin", "")
        ):
            raise tornado.web.HTTPError(403)

    def check_origin(self, origin: str) -> bool:
        return origin in {f"http://{host}" for host in self.server.hosts}

    def open(self, *args: str, **kwargs: str) -> None:
        self.set_nodelay(True)
        self.transmit(self.server.state())
        if notes := self.server.notes():
            self.transmit(json.dumps({"notes": notes}))
        self.server.clients.add(self)
        self.catch_up()

    def on_message(self, message: str | bytes) -> None:
        asked = read(message)
        if asked is None:
            self.close(1008, "not understood")
            return
        if asked["do"] == "ack":
            self.sent = [number for number in self.sent if number > asked["value"]]
            self.server.seen.set()
            self.catch_up()
            return
        self.server.controls.obey(asked)
        self.server.announce()

    def on_close(self) -> None:
        self.server.clients.discard(self)

    def catch_up(self) -> None:
        """Send the present frame, unless the page has it or is still busy with earlier ones."""
        if len(self.sent) >= IN_FLIGHT:
            return
        number, frame = self.server.latest(self.last)
        if frame is None or number == self.last:
            return
        self.sent.append(number)
        self.last = number
        self.transmit(frame)

    def transmit(self, message: str | bytes) -> None:
        try:
            writing = self.write_message(message, binary=isinstance(message, bytes))
        except tornado.websocket.WebSocketClosedError:
            self.server.clients.discard(self)
        else:
            writing.add_done_callback(self._check_writing)

    def _check_writing(self, writing: asyncio.Future[None]) -> None:
        """Note a page that went away during a write; raise any other failure."""
        if not writing.cancelled():
            with suppress(tornado.websocket.WebSocketClosedError):
                writing.result()


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
    ) -> None:
        self._controls = Controls()
        self.scene = scene  # what is shown
        self._texts = threading.Lock()
        self._server = Server(self._controls, port=port, token=token)
        self.url = self._server.url  # the address to open, with its token
        self._page = self._server.show(scene)
        self._alarm()
        self.send(scene.frame(0))
        if open_browser:
            webbrowser.open(self.url)

    @property
    def viewers(self) -> int:
        """How many pages are open."""
        return len(self._server.clients)

    @property
    def speed(self) -> float:
        """Seconds shown per second, as last set."""
        return self._controls.speed

    def show(self, scene: Scene, *, keep: bool = False) -> None:
        """Replace the scene; open pages load the new one."""
        with self._texts:
            if keep:
                now = self.scene.document
                document = replace(scene.document, derivations=now.derivations, verdict=now.verdict)
                scene = replace(scene, document=document)
            self.scene = scene
            self._page = self._server.show(scene)
            self._alarm()
        self._page.result()
        self.send(scene.frame(0))

    def annotate(self, derivations: tuple[ShownDerivation, ...], verdict: VerdictTable) -> None:
        """Put equations and a verdict beside the scene; open pages show them without reloading."""
        with self._texts:
            document = replace(self.scene.document, derivations=derivations, verdict=verdict)
            self.scene = replace(self.scene, document=document)
            self._server.note({**late(self.scene), "alarm": ""})
            self._alarm()

    def _alarm(self) -> None:
        verdict = self.scene.document.verdict
        if verdict.agrees is False:
            self._server.note({"alarm": f"Derivation and reference disagree: {verdict.headline}"})

    def warn(self, text: str) -> None:
        """Warn in every page that something went wrong."""
        self._server.note({"warning": text})

    def send(self, frame: SceneFrame) -> None:
        """Show an instant at once, without waiting for any clock."""
        row = np.asarray(frame.row).astype("<f4")
        traced = self.scene.traced
        if row.shape != traced.shape:
            raise InputError(f"row of a frame: expected shape {traced.shape}, got {row.shape}")
        if not (np.isfinite(frame.t) and np.all(np.isfinite(row))):
            raise InputError(f"frame at t = {frame.t}: expected finite numbers")
        self._server.publish(frame.t, row.tobytes(), row[traced].tobytes())
        self.latest = frame

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
