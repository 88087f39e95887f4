"""Record the latest state for meshcat's viewer; a window for `meshcat.Visualizer` too."""

from __future__ import annotations

import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any, ClassVar, Protocol, TypeAlias, final

import numpy as np

from mecanique.errors import EngineError, InputError


class Command(Protocol):
    """What meshcat sends: an object that turns itself into plain data."""

    def lower(self) -> dict[str, Any]:
        """Return the command as a dictionary."""


Key: TypeAlias = tuple[str, str, str]
"""Path, type of command, property."""


@final
class Latest:
    """Packed commands; only the last one for each path, type and property is kept."""

    _ORDER: ClassVar = {"delete": 0, "set_object": 1, "set_property": 2, "set_transform": 3}

    def __init__(self, blobs: dict[Key, bytes] | None = None) -> None:
        self._blobs = blobs or {}

    def put(self, key: Key, blob: bytes, *, keep_deletions: bool) -> None:
        """Add a command; a deletion removes everything below its path.

        Args:
            key: what the command sets.
            blob: the packed command.
            keep_deletions: whether a deletion is itself remembered, for viewers that have already
                received what it deletes.
        """
        if key[1] == "delete":
            self._blobs = {
                k: b
                for k, b in self._blobs.items()
                if k[0] != key[0] and not k[0].startswith(f"{key[0]}/")
            }
            if not keep_deletions:
                return
        self._blobs[key] = blob

    def merge(self, later: Latest) -> None:
        """Add later commands."""
        for key, blob in sorted(later._blobs.items(), key=self._rank):
            self.put(key, blob, keep_deletions=True)

    def commands(self) -> list[bytes]:
        """Return the commands: deletions, objects, properties, transforms."""
        return [blob for _, blob in sorted(self._blobs.items(), key=self._rank)]

    def _rank(self, item: tuple[Key, bytes]) -> int:
        return self._ORDER[item[0][1]]


@final
class RecorderWindow:
    """Keep what a viewer needs to show the present scene: the last writer of each property wins.

    Args:
        on_change: called after each command, in the sender's thread.
    """

    web_url = "about:blank"

    def __init__(self, on_change: Callable[[], None] | None = None) -> None:
        self._on_change = on_change
        self._lock = threading.Lock()
        self._state = Latest()
        self._changed = Latest()

    def send(self, command: Command) -> None:
        """Take a command from meshcat's visualizer, as `put` does."""
        self.put(command.lower())

    def put(self, command: dict[str, Any]) -> None:
        """Take a command to meshcat's viewer as plain data.

        Raises:
            InputError: if the command holds a number that is not finite, or is of another type.
        """
        import umsgpack

        data = _plain(command)
        kind, path = data["type"], data["path"].rstrip("/")
        if kind not in ("set_object", "set_transform", "set_property", "delete"):
            raise InputError(
                "a recorder window takes objects, transforms, properties and deletions, "
                f"not {kind!r}"
            )
        key, blob = (path, kind, str(data.get("property", ""))), umsgpack.packb(data)
        with self._lock:
            self._state.put(key, blob, keep_deletions=False)
            self._changed.put(key, blob, keep_deletions=True)
        if self._on_change:
            self._on_change()

    def commands(self) -> list[bytes]:
        """Return the packed commands that build the scene: objects first, transforms last."""
        with self._lock:
            return self._state.commands()

    def changes(self) -> Latest:
        """Return the changes since the last call, only the latest state of each path."""
        with self._lock:
            changed, self._changed = self._changed, Latest()
        return changed


def _plain(value: Any) -> Any:
    """Make numpy's numbers Python's own, as the packer needs them, and refuse NaN."""
    if isinstance(value, dict):
        return {key: _plain(each) for key, each in value.items()}
    if isinstance(value, (list, tuple)):
        return [_plain(each) for each in value]
    if isinstance(value, np.ndarray):
        return [_plain(each) for each in value.tolist()]
    if isinstance(value, np.generic):
        value = value.item()
    if isinstance(value, float) and not np.isfinite(value):
        raise InputError(f"a command for the viewer: expected finite numbers, got {value}")
    return value


def viewer_directory() -> Path:
    """Return the directory of meshcat's built viewer.

    Raises:
        EngineError: if meshcat is not installed, or is installed without its viewer.
    """
    from importlib.util import find_spec

    spec = find_spec("meshcat")
    for place in (spec.submodule_search_locations or []) if spec else []:
        found = Path(place) / "viewer" / "dist"
        if (found / "main.min.js").is_file():
            return found
    raise EngineError(
        "meshcat's viewer (viewer/dist/main.min.js) is not installed; try: pip install meshcat"
    )
