"""A page without a browser: it reads and acknowledges a live view's frames, and asks for more."""

from __future__ import annotations

import asyncio
import json
import struct
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from types import TracebackType
from typing import Any, NamedTuple
from urllib.parse import urlsplit

import numpy as np
from numpy.typing import NDArray
from tornado.httpclient import HTTPRequest
from tornado.websocket import WebSocketClientConnection, WebSocketClosedError, websocket_connect


class Frame(NamedTuple):
    """A frame that was shown."""

    t: float  # [s]
    wall: float  # when it came [s]
    row: NDArray[np.float32]
    passed: NDArray[np.float32]


class Watcher:
    """Watches a live view from a thread of its own, as long as the `with` block lasts.

    Args:
        url: the view's address.
        pause: how long it takes to show a frame [s].
    """

    def __init__(self, url: str, pause: float = 0.0) -> None:
        # one list, because it is written by one thread and read by another
        self.frames: list[Frame] = []
        self.states: list[dict[str, Any]] = []
        self.notes: dict[str, str] = {}
        self._url, self._pause = url, pause
        self._loop = asyncio.new_event_loop()
        self._link: WebSocketClientConnection | None = None
        self._ready = threading.Event()
        self._thread = threading.Thread(target=self._run, daemon=True)

    def __enter__(self) -> Watcher:
        self._thread.start()
        assert self._ready.wait(60)
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        if self._link is not None:
            self._loop.call_soon_threadsafe(self._link.close)
        self._thread.join(60)
        self._loop.close()

    @property
    def scene(self) -> str:
        """Which scene is served."""
        return str(self.states[-1]["scene"])

    def ask(self, **message: Any) -> None:
        """Send what a page sends."""
        assert self._link is not None
        self._loop.call_soon_threadsafe(self._link.write_message, json.dumps(message))

    def until(self, condition: Callable[[Watcher], bool], seconds: float = 60.0) -> None:
        """Wait for something to be seen."""
        end = time.monotonic() + seconds
        while not condition(self):
            assert time.monotonic() < end, (
                f"it did not happen: {self.times[-3:]} {self.states[-1:]} {self.notes}"
            )
            time.sleep(0.01)

    @property
    def times(self) -> list[float]:
        """When each frame is [s]."""
        return [frame.t for frame in self.frames]

    @property
    def walls(self) -> list[float]:
        """When each frame came [s]."""
        return [frame.wall for frame in self.frames]

    @property
    def rows(self) -> list[NDArray[np.float32]]:
        """Each frame's numbers."""
        return [frame.row for frame in self.frames]

    @property
    def passed(self) -> list[NDArray[np.float32]]:
        """What each frame passed."""
        return [frame.passed for frame in self.frames]

    def reach(self, t: float, seconds: float = 60.0) -> Frame:
        """Wait for a time to be shown; return the frame."""
        self.until(lambda watcher: bool(watcher.frames) and watcher.frames[-1].t >= t, seconds)
        return self.frames[-1]

    def begin_again(self, t: float) -> None:
        """Wait until a time below this one was shown, since the record began."""
        self.until(lambda watcher: any(shown < t for shown in watcher.times))

    def forget(self) -> None:
        """Start the record again."""
        self.frames = []

    def _run(self) -> None:
        self._loop.run_until_complete(self._watch())

    async def _watch(self) -> None:
        parts = urlsplit(self._url)
        request = HTTPRequest(
            f"ws://{parts.netloc}{parts.path}ws", headers={"Origin": f"http://{parts.netloc}"}
        )
        self._link = link = await websocket_connect(request)
        self._ready.set()
        while (message := await link.read_message()) is not None:
            if isinstance(message, str):
                told = json.loads(message)
                if "notes" in told:
                    self.notes |= told["notes"]
                else:
                    self.states.append(told)
                continue
            number, count, t = struct.unpack_from("<IId", message)
            numbers = np.frombuffer(message, "<f4", offset=16)
            row, passed = np.split(numbers, [len(numbers) - count])
            self.frames.append(Frame(t, time.monotonic(), row, passed))
            if self._pause:
                await asyncio.sleep(self._pause)
            with suppress(WebSocketClosedError):  # it left while this frame was shown
                await link.write_message(json.dumps({"do": "ack", "value": number}))
