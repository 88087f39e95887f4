"""Motions that the page of a live view computes by itself."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import final

from mecanique.derivation import derive
from mecanique.errors import MecaniqueError
from mecanique.model.mechanism import Mechanism
from mecanique.motion.record.motion import Motion
from mecanique.viewing.engine.attach import add_row, equip, judge_page
from mecanique.viewing.engine.bounds import is_cut_short
from mecanique.viewing.engine.make import refuse
from mecanique.viewing.live.checking import Checking, pending
from mecanique.viewing.live.live import LiveView
from mecanique.viewing.live.stretches import FIRST, compute_first, density
from mecanique.viewing.scene.document import VerdictTable
from mecanique.viewing.scene.from_motion import actions_of
from mecanique.viewing.scene.scene import Scene
from mecanique.viewing.scene.texts import document_of

SHOWN = 10.0
"""Length of a motion without end that the page computes at first [s], at the speed of nature."""


@final
class Computing:
    """A motion with the engine of its page; equations and verdict arrive while it moves.

    Args:
        motion: what the page begins with.
        end: when the motion ends [s]; infinity for never.
        rtol: relative tolerance of each step.
        speed: seconds shown per second at first.
        remark: why it ends there, for the page.

    Raises:
        MecaniqueError: if the page cannot compute it.
    """

    def __init__(
        self, motion: Motion, end: float, rtol: float, speed: float, remark: str = ""
    ) -> None:
        mechanism = motion.mechanism
        refuse(mechanism)
        actions = actions_of(motion)
        document = pending(mechanism, document_of(motion, (), None, actions))
        scene, self._maker = equip(motion, document, actions, derive(mechanism))
        assert scene.engine is not None
        endless = math.isinf(end)
        duration = SHOWN * min(speed, 1.0) if endless else end - float(motion.t[0])
        engine = replace(scene.engine, duration=duration, rtol=rtol, endless=endless)
        whole = end <= float(motion.t[-1])
        document = replace(scene.document, method=scene.document.method if whole else "")
        self.scene: Scene = replace(scene, engine=engine, document=document)
        self._mechanism = mechanism
        self._remark = remark
        self._checking: Checking | None = None

    def check(self, live: LiveView) -> None:
        """Derive and compare what moves, and then the page's program, in the background.

        Args:
            live: the view that shows what is found.
        """
        if self._remark:
            live.warn(self._remark)
        self._checking = Checking(self._mechanism, live.annotate, self._prove)

    def close(self) -> None:
        """Cancel the derivation in progress."""
        if self._checking:
            self._checking.finish(2.0)

    def _prove(self, table: VerdictTable) -> VerdictTable:
        try:
            return add_row(table, judge_page(self._maker))
        except MecaniqueError as error:
            return replace(table, agrees=False, headline=f"the program of this page: {error}")


def begin(
    shown: Motion | Mechanism,
    q: Mapping[str, float] | Sequence[float] | None,
    v: Mapping[str, float] | Sequence[float] | None,
    end: float,
    rtol: float,
    speed: float,
) -> Computing | None:
    """Return a motion that its page computes, or None where the page cannot.

    Args:
        shown: a recorded motion, or a mechanism.
        q: a mechanism's positions at the start.
        v: its velocities at the start.
        end: when a mechanism's motion ends [s]; infinity for never.
        rtol: relative tolerance of each step of a mechanism's motion.
        speed: seconds shown per second at first.

    Raises:
        MecaniqueError: if a mechanism's motion cannot start.
    """
    remark = ""
    if isinstance(shown, Motion):
        motion, end, rtol = shown, float(shown.t[-1]), shown.statistics.rtol
    else:
        try:
            refuse(shown)
        except MecaniqueError:
            return None
        length = min(FIRST * min(speed, 1.0), end)
        motion, remark = compute_first(
            mechanism=shown, q=q, v=v, duration=length, rtol=rtol, fps=density(speed)
        )
        if is_cut_short(motion):
            remark = ""  # the page finds that by itself
        elif remark:
            end = float(motion.t[-1])
    try:
        return Computing(motion, end, rtol, speed, remark)
    except MecaniqueError:
        return None
