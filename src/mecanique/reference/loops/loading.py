"""Load each mechanism into Pinocchio once, as long as it lives and in each thread."""

from __future__ import annotations

import threading
import weakref
from copy import copy
from typing import NamedTuple, final

from mecanique.model.mechanism import Mechanism
from mecanique.reference.engine.tree import Tree
from mecanique.reference.loops.closed import Closed

__all__ = ["Loaded", "load_loops", "load_once"]

MOST = 32
"""At most so many mechanisms stay loaded in a thread: those that were asked for last."""


class Loaded(NamedTuple):
    """A mechanism inside Pinocchio.

    Args:
        tree: its tree, whose work space is shared by all who load the mechanism in one thread.
        closed: its loops, with constraints of unknown rank; None for a tree.
    """

    tree: Tree
    closed: Closed | None


class _Kept(NamedTuple):
    mechanism: weakref.ref[Mechanism]
    loaded: Loaded


@final
class _Shelf(threading.local):
    """What a thread keeps; Pinocchio's work space must not be shared between threads."""

    def __init__(self) -> None:
        self.kept: dict[int, _Kept] = {}


_shelf = _Shelf()


def load_once(mechanism: Mechanism) -> Loaded:
    """Return a mechanism inside Pinocchio, loaded at the first call only.

    Answers do not depend on what was asked before.

    Args:
        mechanism: what to load; it is not kept alive.

    Raises:
        EngineError: if it is too large for Pinocchio, or is not read as it is written.
    """
    kept, key = _shelf.kept, id(mechanism)
    found = kept.pop(key, None)
    if found is None or found.mechanism() is not mechanism:
        # a twin is loaded: what is kept must not keep the mechanism itself alive
        tree = Tree(copy(mechanism))
        loaded = Loaded(tree, Closed(tree) if mechanism.constrained else None)
        found = _Kept(weakref.ref(mechanism, lambda _: kept.pop(key, None)), loaded)
    kept[key] = found
    if len(kept) > MOST:
        del kept[next(iter(kept))]
    return found.loaded


def load_loops(mechanism: Mechanism) -> Closed:
    """Return the loops of a mechanism that has some, loaded as `load_once` does.

    Raises:
        EngineError: if it is too large for Pinocchio, or is not read as it is written.
    """
    closed = load_once(mechanism).closed
    assert closed is not None, "the mechanism has loops"
    return closed
