"""How a Reference answers: the mechanism inside Pinocchio, asked in one state or many."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import TypeVar

import numpy as np

from mecanique.arrays import Array
from mecanique.errors import EngineError, InputError, MecaniqueError
from mecanique.model.mechanism import Mechanism
from mecanique.model.states import States, explain_defaults
from mecanique.reference.engine.tree import Tree
from mecanique.reference.engine.whole import Whole
from mecanique.reference.loops.closed import Closed
from mecanique.reference.loops.freedom.freedom import generic_rank
from mecanique.reference.loops.loading import Loaded

__all__ = ["Answering"]

_Asked = TypeVar("_Asked", bound="Answering")


class Answering:
    """Base of a `Reference`: a tree inside Pinocchio, and the loops that hold it together.

    Args:
        mechanism: what to load.

    Raises:
        EngineError: if it is too large for Pinocchio, or is not read as it is written.
    """

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = mechanism
        self._tree = Tree(mechanism)
        self._closed = Closed(self._tree) if mechanism.constrained else None

    @classmethod
    def _over(cls: type[_Asked], loaded: Loaded) -> _Asked:
        """Return what answers over a mechanism that Pinocchio has loaded already."""
        answering = cls.__new__(cls)
        answering.mechanism = loaded.tree.mechanism
        answering._tree, answering._closed = loaded
        return answering

    @cached_property
    def _whole(self) -> Whole:
        return Whole(self._tree)

    _generic: int | None = None
    """The rank of the constraints in general, once it is known that they do not lock by chance."""

    def _look_for_locks(self, one: Callable[..., Array]) -> Callable[..., Array]:
        """Return a question about the motion on the loops that refuses what they lock by chance.

        One look is enough: what is locked can be in no other position.
        """
        closed = self._closed
        if closed is None or closed.most is not None or self._generic is not None:
            return one

        def answer(q: Array, v: Array, t: float) -> Array:
            if self._generic is None:
                closed.refuse_open(q, t)
                self._generic = generic_rank(closed, q, t)
            return one(q, v, t)

        return answer

    def _answer(
        self, states: States, one: Callable[..., Array], *, accelerations: bool = False
    ) -> Array:
        """Return what one(q, v, t), or one(q, v, t, a), answers in each state; all of it finite."""
        if self._tree.loads.waiting:
            raise InputError(
                f"a function of time in mechanism {self.mechanism.name!r} asks the Reference that "
                "waits for its value; let it ask one of its own: Reference(mechanism)"
            )
        rows: list[Array] = []
        each = zip(states.q, states.v, states.a, states.t.tolist(), strict=True)
        try:
            for k, (q, v, a, t) in enumerate(each):
                if states.efforts is not None:
                    self._tree.drive(states.efforts, k, q, v, t)
                rows.append(np.asarray(one(q, v, t, a) if accelerations else one(q, v, t)))
        except MecaniqueError:
            raise
        except (ArithmeticError, ValueError) as error:
            # a map or a force that is not defined here, e.g. the root of a negative number
            raise self._no_answer(states, len(rows), f" ({error})") from error
        finally:
            if states.efforts is not None:
                self._tree.loads.drive(0.0)
        answers = np.array(rows)
        finite = np.isfinite(answers).reshape(len(rows), -1).all(axis=1)
        if not finite.all():
            raise self._no_answer(states, int(np.argmin(finite)))
        return rows[0] if states.single else answers

    def _no_answer(self, states: States, k: int, reason: str = "") -> EngineError:
        q, v, t = states.q[k].tolist(), states.v[k].tolist(), float(states.t[k])
        return EngineError(
            f"mechanism {self.mechanism.name!r} has no finite answer at q = {q}, v = {v}, "
            f"t = {t:g}{reason}{explain_defaults(self.mechanism, states.asked)}"
        )
