"""Compute a motion while it is shown, in a thread one stretch ahead."""

from __future__ import annotations

import queue
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any, final

import numpy as np

from mecanique.errors import IntegrationError
from mecanique.motion.motion import Motion
from mecanique.viewing.scene.from_motion import actions_of, scene_of
from mecanique.viewing.scene.scene import Scene, SceneText
from mecanique.viewing.scene.texts import ledger_of

STRETCH = 0.5
"""Length of a stretch at the speed at which it is shown [s of wall time]."""

FIRST = 2.0
"""Length of the first stretch of a small mechanism, which sets the frame of the picture."""

PATIENCE = 1.0
"""A stretch that takes longer to compute is cut short, so that something moves [s]."""

FOR_PROGRAMS = "; the motion until then is in the error's .motion"
"""The end of an error's message, meant for code that catches it; a page shows that motion."""

FAINT = 1e-6
"""A force below this fraction of the largest of its kind does not enter a scene being shown."""


def names_of(scene: Scene) -> frozenset[str]:
    """Return the arrows and reactions of a scene that are not always zero."""
    sizes: dict[str, tuple[str, float]] = {
        f"arrow {a.name}": (a.unit, float(np.abs(a.vector).max(initial=0.0))) for a in scene.arrows
    }
    sizes |= {
        f"series {s.name}": (s.unit, float(np.abs(s.values).max(initial=0.0)))
        for s in scene.series
        if s.group == "Reactions"
    }
    largest: dict[str, float] = {}
    for unit, size in sizes.values():
        largest[unit] = max(largest.get(unit, 0.0), size)
    return frozenset(
        name for name, (unit, size) in sizes.items() if size > max(1e-9, FAINT * largest[unit])
    )


def fit(scene: Scene, names: frozenset[str]) -> Scene:
    """Return a complete scene with only these arrows and reactions."""
    return replace(
        scene,
        arrows=tuple(a for a in scene.arrows if f"arrow {a.name}" in names),
        series=tuple(
            s for s in scene.series if s.group != "Reactions" or f"series {s.name}" in names
        ),
    )


def density(speed: float) -> float:
    """Return the samples per second of motion that smooth pictures need at a speed."""
    return 60 / min(speed, 4.0)


def compute(check: Callable[[], None] | None = None, **arguments: Any) -> Motion:
    """Return a stretch of a motion, short enough to be computed without a noticeable wait."""
    from mecanique.motion import simulate

    latest = time.monotonic() + PATIENCE

    def progress(_: float) -> None:
        if check is not None:
            check()
        if time.monotonic() > latest:
            raise _EnoughError

    try:
        return simulate(progress=progress, **arguments)
    except IntegrationError as error:
        done: Motion | None = error.motion
        if isinstance(error.__cause__, _EnoughError) and done is not None and len(done.t) > 1:
            return done
        raise


def compute_first(**arguments: Any) -> tuple[Motion, str]:
    """Return the first stretch of a motion, and why it stops before its end; "" if it does not."""
    try:
        return compute(**arguments), ""
    except IntegrationError as error:
        if error.motion is None or len(error.motion.t) < 2:
            raise
        return error.motion, f"The motion stops here: {str(error).removesuffix(FOR_PROGRAMS)}"


@final
class Stretches:
    """The complete scenes that follow a first stretch of a motion, one after the other."""

    def __init__(self, first: Motion, end: float, speed: Callable[[], float] = lambda: 1.0) -> None:
        self._motion = first
        self._end = end
        self._speed = speed
        self._work = float(first.energy().work[-1])
        self._done: queue.Queue[Scene | Exception | None] = queue.Queue(maxsize=1)
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="mecanique integration", daemon=True)

    def __iter__(self) -> Iterator[Scene]:
        """Yield the scenes."""
        self._thread.start()
        try:
            while True:
                # short waits, so that Ctrl-C works on every system
                try:
                    made = self._done.get(timeout=0.2)
                except queue.Empty:
                    continue
                if made is None:
                    return
                if isinstance(made, Exception):
                    raise made
                yield made
        finally:
            self._stop.set()
            self._thread.join(timeout=5)

    def _run(self) -> None:
        try:
            while self._end - self._motion.t[-1] > 1e-9:
                last = self._motion
                t0 = float(last.t[-1])
                speed = self._speed()
                self._motion = compute(
                    self._check,
                    mechanism=last.described,
                    q=last.q[-1],
                    v=last.v[-1],
                    t0=t0,
                    duration=min(STRETCH * speed, self._end - t0),
                    rtol=last.statistics.rtol,
                    fps=density(speed),
                )
                self._give(self._stage(self._motion))
            self._give(None)
        except _StoppedError:
            return
        except Exception as error:  # raised again where the motion is shown
            self._finish(error)

    def _finish(self, error: Exception) -> None:
        """Hand over what was computed before the error, then the error."""
        try:
            done = getattr(error, "motion", None)
            if done is not None and len(done.t) > 1:
                self._give(self._stage(done))
            self._give(error)
        except _StoppedError:
            return

    def _stage(self, motion: Motion) -> Scene:
        actions = actions_of(motion)
        scene = scene_of(
            motion, SceneText(ledger=ledger_of(motion, actions)), actions, complete=True
        )
        work, self._work = self._work, self._work + float(motion.energy().work[-1])
        series = (
            replace(s, values=s.values + work) if s.name == "energy work" else s
            for s in scene.series
        )
        return replace(scene, series=tuple(series))

    def _check(self) -> None:
        if self._stop.is_set():
            raise _StoppedError

    def _give(self, made: Scene | Exception | None) -> None:
        while True:
            self._check()
            try:
                self._done.put(made, timeout=0.1)
            except queue.Full:
                continue
            return


class _StoppedError(Exception):
    """Nobody is watching any more."""


class _EnoughError(Exception):
    """The motion computed so far is to be shown first."""
