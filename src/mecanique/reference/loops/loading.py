"""Load each mechanism into Pinocchio only once per thread, as long as it is alive."""

from __future__ import annotations

import threading
import weakref
from copy import copy
from typing import NamedTuple, final

from mecanique.model.mechanism import Mechanism
from mecanique.reference.engine.tree import EngineTree
from mecanique.reference.loops.closed import Closed

MOST = 32
"""Number of mechanisms that stay loaded in a thread, those used last."""


class Loaded(NamedTuple):
    """A mechanism inside Pinocchio."""

    tree: EngineTree  # its tree; all who load the mechanism in one thread share its data
    closed: Closed | None  # its loops, with constraints of unknown rank; None for a tree


class _Kept(NamedTuple):
    mechanism: weakref.ref[Mechanism]
    loaded: Loaded


@final
class _Shelf(threading.local):
    """The mechanisms that a thread keeps; threads must not share Pinocchio's data."""

    def __init__(self) -> None:
        self.kept: dict[int, _Kept] = {}


_shelf = _Shelf()


def load_once(mechanism: Mechanism) -> Loaded:
    """Load a mechanism into Pinocchio, at the first call only."""
    # Results do not depend on earlier calls
    kept, key = _shelf.kept, id(mechanism)
    entry = kept.pop(key, None)
    if entry is None or entry.mechanism() is not mechanism:
        # a copy is loaded, so that the cache does not keep the mechanism alive
        tree = EngineTree(copy(mechanism))
        loaded = Loaded(tree, Closed(tree) if mechanism.constrained else None)
        entry = _Kept(weakref.ref(mechanism, lambda _: kept.pop(key, None)), loaded)
    kept[key] = entry
    if len(kept) > MOST:
        del kept[next(iter(kept))]
    return entry.loaded


def load_loops(mechanism: Mechanism) -> Closed:
    """Load a mechanism with loops as `load_once` does, and return its loops."""
    closed = load_once(mechanism).closed
    assert closed is not None, "the mechanism has loops"
    return closed
