"""Motions for a live view: computed while it is shown, or recorded."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import final

import numpy as np

from mecanique.errors import InputError, MecaniqueError
from mecanique.model.mechanism import Mechanism
from mecanique.motion.motion import Motion
from mecanique.motion.simulation.arguments import Values
from mecanique.viewing.live.checking import Checking, pending
from mecanique.viewing.live.live import Changes, LiveView
from mecanique.viewing.live.stretches import (
    FIRST,
    FOR_PROGRAMS,
    STRETCH,
    Stretches,
    compute_first,
    density,
    fit,
    names_of,
)
from mecanique.viewing.scene.from_motion import actions_of, scene_of
from mecanique.viewing.scene.scene import Scene, SceneFrame
from mecanique.viewing.scene.texts import document_of


@final
class Presenter:
    """Keep open pages up to date across restarts; derive in the background."""

    def __init__(self, mechanism: Mechanism, complete: Scene) -> None:
        self._mechanism = mechanism
        self._names = names_of(complete)
        self._parameters = _values(mechanism)
        self._checking: Checking | None = None
        self.first = fit(complete, self._names)

    def check(self, live: LiveView) -> None:
        """Derive and compare what moves, unless this has already begun."""
        if self._checking is None:
            self._checking = Checking(self._mechanism, live.annotate)

    def begin(self, live: LiveView, mechanism: Mechanism, complete: Scene) -> Scene:
        """Return the start of a motion as the view shows it."""
        parameters = _values(mechanism)
        if parameters != self._parameters:
            self._mechanism, self._parameters, self._names = (
                mechanism,
                parameters,
                names_of(complete),
            )
            if self._checking:
                self._checking.cancel()
            self._checking = None
            shown = fit(complete, self._names)
            live.show(shown)
        else:
            shown = self.go_on(live, complete)
        self.check(live)
        return shown

    def go_on(self, live: LiveView, complete: Scene) -> Scene:
        """Return a later stretch as the view shows it."""
        names = self._names | names_of(complete)
        shown = fit(complete, names)
        if names != self._names:
            # a force that acts for the first time is not yet part of the scene
            self._names, before = names, live.scene
            document = replace(before.document, ledger=shown.document.ledger)
            planar = shown.planar and before.planar
            live.show(
                replace(shown, document=document, bounds=before.bounds, planar=planar), keep=True
            )
        return shown

    def close(self) -> None:
        """Cancel the derivation in progress."""
        if self._checking:
            self._checking.finish(2.0)


def _values(mechanism: Mechanism) -> dict[str, float]:
    return {parameter.symbol: parameter.value for parameter in mechanism.parameters}


MOST_AHEAD = 8
"""Above this number of velocities a live view starts with a short stretch, to start at once."""


@final
class LiveMotion:
    """A mechanism and its start; the motion is computed as it is shown."""

    def __init__(
        self,
        mechanism: Mechanism,
        q: Values | None,
        v: Values | None,
        end: float,
        rtol: float,
        speed: float = 1.0,
    ) -> None:
        self._end, self._rtol, self._speed = end, rtol, speed
        self._restart = self._start(mechanism, q, v)
        self._first = self._stage(self._restart)
        self.presenter = Presenter(mechanism, self._first)

    def frames(self, live: LiveView, changes: Changes) -> Iterator[SceneFrame]:
        """Yield the motion's instants; the page reports what cannot be computed."""
        live.warn("")
        try:
            motion, scene = self._restart, self._first
            if changes:
                self._speed = live.speed
                motion = self._start(*_restart(motion, changes))
                scene = self._stage(motion)
            shown = self.presenter.begin(live, motion.mechanism, scene)
            yield from (shown.frame(k) for k in range(len(shown.t)))
            for complete in Stretches(motion, self._end, lambda: live.speed):
                shown = self.presenter.go_on(live, complete)
                yield from (shown.frame(k) for k in range(1, len(shown.t)))
        except MecaniqueError as error:
            # a reset or the next change starts anew
            live.warn(f"The motion stops here: {str(error).removesuffix(FOR_PROGRAMS)}")

    def _start(self, mechanism: Mechanism, q: Values | None, v: Values | None) -> Motion:
        length = (FIRST if mechanism.nv <= MOST_AHEAD else STRETCH) * min(self._speed, 1.0)
        fps = density(self._speed)
        # what stops the motion is reported when the next stretch cannot start
        motion, _ = compute_first(
            mechanism=mechanism, q=q, v=v, duration=min(length, self._end), rtol=self._rtol, fps=fps
        )
        return motion

    def _stage(self, motion: Motion) -> Scene:
        length = "" if np.isinf(self._end) else f"{self._end:g} s, "
        return _stage(motion, f"{length}computed while it is shown")


@final
class Recorded:
    """A recorded motion, computed again over the same time when values change on the page."""

    def __init__(self, motion: Motion) -> None:
        if not isinstance(motion, Motion):
            raise InputError(
                "expected a Motion, as simulate returns it, or a Mechanism, "
                f"got {type(motion).__name__}"
            )
        self._motion = motion
        self._first = _stage(motion)
        self.presenter = Presenter(motion.mechanism, self._first)

    def frames(self, live: LiveView, changes: Changes) -> Iterator[SceneFrame]:
        """Yield the motion's instants; the page reports what cannot be computed."""
        from mecanique.motion import simulate

        live.warn("")
        try:
            motion, scene = self._motion, self._first
            if changes:
                mechanism, q, v = _restart(motion, changes)
                span, rtol = float(motion.t[-1] - motion.t[0]), motion.statistics.rtol
                motion = simulate(
                    mechanism, q=q, v=v, t0=float(motion.t[0]), duration=span, rtol=rtol
                )
                scene = _stage(motion)
            shown = self.presenter.begin(live, motion.mechanism, scene)
            yield from (shown.frame(k) for k in range(len(shown.t)))
        except MecaniqueError as error:
            live.warn(f"There is no motion: {error}")


def _restart(
    motion: Motion, changes: Changes
) -> tuple[Mechanism, dict[str, float], dict[str, float]]:
    """A motion's mechanism and start with the values set on the page."""
    parameters = {name: value for (kind, name), value in changes.items() if kind == "parameter"}
    mechanism = motion.mechanism.replace(**parameters) if parameters else motion.mechanism
    q = dict(zip(mechanism.coordinates, motion.q[0].tolist(), strict=True))
    v = dict(zip(mechanism.velocities, motion.v[0].tolist(), strict=True))
    for (kind, name), value in changes.items():
        if kind == "initial":
            (q if name in q else v)[name] = value
    return mechanism, q, v


def _stage(motion: Motion, subtitle: str = "") -> Scene:
    """A complete scene with its texts, except those that take long to compute."""
    actions = actions_of(motion)
    document = pending(motion.mechanism, document_of(motion, (), None, actions))
    return scene_of(
        motion, replace(document, subtitle=subtitle or document.subtitle), actions, complete=True
    )
