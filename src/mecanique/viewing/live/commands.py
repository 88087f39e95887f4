"""The few commands a page may send to a live view, checked before they are obeyed."""

from __future__ import annotations

import json
import math
import threading
from typing import Any, final

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
        self._speed = 1.0
        self._paused = False
        self._closed = False
        self._restart = False
        self._values: dict[tuple[str, str], float] = {}

    def begin(self, speed: float) -> None:
        """Start a stream: running, at a speed, with nothing asked for."""
        with self._lock:
            self._speed, self._paused, self._restart = float(speed), False, False

    def obey(self, message: dict[str, Any]) -> None:
        """Note what a page asks for."""
        do, value = message["do"], float(message.get("value", 0.0))
        with self._lock:
            if do in ("pause", "resume"):
                self._paused = do == "pause"
            elif do == "speed":
                self._speed = value
            elif do == "reset":
                self._restart = True
            elif do in ("parameter", "initial"):
                self._values[do, message["name"]] = value
                self._restart = True
        self._wake.set()

    @property
    def rate(self) -> float:
        """Seconds shown per second, 0 while paused."""
        with self._lock:
            return 0.0 if self._paused else self._speed

    @property
    def speed(self) -> float:
        """Seconds shown per second when not paused."""
        return self._speed

    @property
    def paused(self) -> bool:
        """Whether a page asked for a pause."""
        return self._paused

    @property
    def closed(self) -> bool:
        """Whether the view has been closed."""
        return self._closed

    @property
    def restart_wanted(self) -> bool:
        """Whether a page asked to start again."""
        return self._restart

    def take_restart(self) -> bool:
        """Return whether a page asked to start again, and forget it."""
        with self._lock:
            wanted, self._restart = self._restart, False
        return wanted

    def changes(self) -> dict[tuple[str, str], float]:
        """Return the values set so far, by kind and name."""
        with self._lock:
            return dict(self._values)

    def rest(self, seconds: float) -> None:
        """Sleep, but wake when a page asks for something.

        Args:
            seconds: at most so long.
        """
        if seconds > 0 and self._wake.wait(seconds):
            self._wake.clear()

    def close(self) -> None:
        """Signal the stream to stop."""
        self._closed = True
        self._wake.set()
