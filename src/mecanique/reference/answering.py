"""Evaluate a mechanism inside Pinocchio in one state or many."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import TypeVar

import numpy as np

from mecanique.arrays import Array
from mecanique.errors import EngineError, InputError, MecaniqueError
from mecanique.model.mechanism import Mechanism
from mecanique.model.states import States, expect_mechanism, explain_defaults
from mecanique.reference.engine.many import Whole
from mecanique.reference.engine.tree import Tree
from mecanique.reference.loops.closed import Closed
from mecanique.reference.loops.freedom import generic_rank
from mecanique.reference.loops.loading import Loaded

_Asked = TypeVar("_Asked", bound="Answering")


class Answering:
    """The base class of `Reference`: a tree inside Pinocchio, and the loops that close it."""

    def __init__(self, mechanism: Mechanism) -> None:
        self.mechanism = expect_mechanism(mechanism)
        self._tree = Tree(mechanism)
        self._closed = Closed(self._tree) if mechanism.constrained else None

    @classmethod
    def _over(cls: type[_Asked], loaded: Loaded) -> _Asked:
        """Make an instance for a mechanism that Pinocchio has loaded already."""
        answering = cls.__new__(cls)
        answering.mechanism = loaded.tree.mechanism
        answering._tree, answering._closed = loaded
        return answering

    def __reduce__(self) -> tuple[Callable[..., Answering], tuple[object, ...]]:
        """Pickle the mechanism, which another process loads into its own Pinocchio."""
        rank = None if self._closed is None else self._closed.most
        return _load, (type(self), self.mechanism, rank)

    @cached_property
    def _whole(self) -> Whole:
        return Whole(self._tree)

    _generic: int | None = None
    """The generic rank of the constraints, once they are known not to lock the mechanism."""

    def _look_for_locks(self, function: Callable[..., Array]) -> Callable[..., Array]:
        """Wrap a function of the state to refuse a mechanism locked in a singular position."""
        # One check suffices: a locked mechanism cannot reach any other position
        closed = self._closed
        if closed is None or closed.most is not None or self._generic is not None:
            return function

        def answer(q: Array, v: Array, t: float) -> Array:
            if self._generic is None:
                closed.refuse_open(q, t)
                self._generic = generic_rank(closed, q, t)
            return function(q, v, t)

        return answer

    def _answer(
        self, states: States, function: Callable[..., Array], *, accelerations: bool = False
    ) -> Array:
        """Evaluate function(q, v, t), or (q, v, t, a), in each state; values must be finite."""
        if self._tree.loads.waiting:
            raise InputError(
                f"a function of time in mechanism {self.mechanism.name!r} calls the Reference that "
                "is waiting for its value; let it use one of its own: Reference(mechanism)"
            )
        rows: list[Array] = []
        rows_in = zip(states.q, states.v, states.a, states.t.tolist(), strict=True)
        try:
            with np.errstate(all="ignore"):  # what is not finite is refused below
                for k, (q, v, a, t) in enumerate(rows_in):
                    if states.efforts is not None:
                        self._tree.drive(states.efforts, k, q, v, t)
                    rows.append(
                        np.asarray(function(q, v, t, a) if accelerations else function(q, v, t))
                    )
        except MecaniqueError:
            raise
        except (ArithmeticError, ValueError) as error:
            # a map or a force that is not defined here, e.g. the root of a negative number
            raise self._no_answer(states, len(rows), f" ({error})") from error
        finally:
            if states.efforts is not None:
                self._tree.loads.drive(0.0)
        answers = self._refuse_infinite(states, np.array(rows))
        return rows[0] if states.single else answers

    def _refuse_infinite(self, states: States, answers: Array) -> Array:
        """Return answers, shape (n, …), all of which must be finite."""
        finite = np.isfinite(answers).reshape(len(answers), -1).all(axis=1)
        if not finite.all():
            raise self._no_answer(states, int(np.argmin(finite)))
        return answers

    def _no_answer(self, states: States, k: int, reason: str = "") -> EngineError:
        q, v, t = states.q[k].tolist(), states.v[k].tolist(), float(states.t[k])
        return EngineError(
            f"mechanism {self.mechanism.name!r} has no finite answer at q = {q}, v = {v}, "
            f"t = {t:g}{reason}{explain_defaults(self.mechanism, states.asked)}"
        )


def _load(kind: type[_Asked], mechanism: Mechanism, rank: int | None) -> _Asked:
    """Load a mechanism anew; rank is that of its constraints, if it was known."""
    loaded = kind(mechanism)
    if loaded._closed is None or rank is None:
        return loaded
    return kind._over(Loaded(loaded._tree, loaded._closed.with_rank(rank)))
