"""A mechanism that is set in motion while it is shown."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import replace
from typing import Any, final

import numpy as np

from mecanique.errors import MecaniqueError
from mecanique.model.mechanism import Mechanism
from mecanique.view.live import Changes, LiveView
from mecanique.view.scene import Frame, Scene
from mecanique.view.staging import actions_of, scene_of
from mecanique.view.stretches import FIRST, STRETCH, Stretches, fitted, names_of
from mecanique.view.texts import document_of

__all__ = ["MOST_COMPARED", "Moving"]

MOST_COMPARED = 8
"""With more velocities than this a live view starts without equations and verdict, which take seconds."""


@final
class Moving:
    """A mechanism and how it starts; what follows is computed as it is shown.

    Args:
        mechanism: what moves.
        q: positions at the start: shape (nq,) or by coordinate name.
        v: velocities at the start: shape (nv,) or by name.
        end: when the motion ends [s]; infinity for never.
        rtol: relative tolerance of each step.

    Raises:
        MecaniqueError: if the motion cannot start.
    """

    def __init__(self, mechanism: Mechanism, q: Any, v: Any, end: float, rtol: float) -> None:
        self._end, self._rtol = end, rtol
        self._started = self._start(mechanism, q, v)
        self._first = self._staged(self._started, compared=True)
        self.first = fitted(self._first, names_of(self._first))

    def frames(self, live: LiveView, changes: Changes) -> Iterator[Frame]:
        """Yield the motion's instants; what cannot be computed is told in the page.

        Args:
            live: what shows them.
            changes: the values set in the page.
        """
        shown = self.first
        try:
            motion, scene = self._started, self._first
            if changes:
                motion = self._changed(changes)
                scene = self._staged(motion, compared=False)
            names = names_of(scene)
            if changes or live.scene is not self.first:
                shown = fitted(scene, names) if changes else self.first
                live.show(shown)
            yield from (shown.frame(k) for k in range(len(shown.t)))
            for complete in Stretches(motion, self._end):
                more = names | names_of(complete)
                if more != names:
                    # a force that acts for the first time has no place in the scene yet
                    names = more
                    shown = self._told(fitted(complete, names), shown)
                    live.show(shown)
                stretch = fitted(complete, names)
                yield from (stretch.frame(k) for k in range(1, len(stretch.t)))
        except MecaniqueError as error:
            # the page says why nothing moves any more; a reset or the next change starts anew
            stopped, shown = live.latest, live.scene
            live.show(replace(shown, document=replace(shown.document, subtitle=str(error))))
            yield stopped

    def _start(self, mechanism: Mechanism, q: Any, v: Any) -> Any:
        from mecanique.motion import simulate

        length = FIRST if mechanism.nv <= MOST_COMPARED else STRETCH
        return simulate(mechanism, q=q, v=v, duration=min(length, self._end), rtol=self._rtol)

    def _changed(self, changes: Changes) -> Any:
        parameters = {name: value for (kind, name), value in changes.items() if kind == "parameter"}
        mechanism = self._started.mechanism.replace(**parameters)
        q = dict(zip(mechanism.coordinates, self._started.q[0].tolist(), strict=True))
        v = dict(zip(mechanism.velocities, self._started.v[0].tolist(), strict=True))
        for (kind, name), value in changes.items():
            if kind == "initial":
                (q if name in q else v)[name] = value
        return self._start(mechanism, q, v)

    def _staged(self, motion: Any, compared: bool) -> Scene:
        """The first stretch with its texts; equations and verdict only where they are found at once."""
        equations: list[Any] = []
        verdict = None
        mechanism = motion.mechanism
        if mechanism.nv <= MOST_COMPARED:
            from mecanique.derive import METHODS, derive
            from mecanique.verify import verify

            for method in tuple(METHODS)[: None if compared else 1]:
                with suppress(MecaniqueError):
                    equations.append(derive(mechanism, method))
            if compared:
                with suppress(MecaniqueError):
                    verdict = verify(mechanism)
        actions = actions_of(motion)
        document = document_of(motion, equations, verdict, actions)
        length = "" if np.isinf(self._end) else f"{self._end:g} s, "
        document = replace(document, subtitle=f"{length}computed while it is shown")
        return scene_of(motion, document, actions, complete=True)

    @staticmethod
    def _told(scene: Scene, before: Scene) -> Scene:
        """A later stretch with the texts there were."""
        document = replace(before.document, ledger=scene.document.ledger)
        return replace(scene, document=document, bounds=before.bounds, planar=scene.planar and before.planar)
