"""Bound the time and the size of one judgement, whatever text it is given."""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import final

from mecanique.errors import FormulaError

# Pyodide has no clock of a thread; its only one is the process's
processor_time = getattr(time, "thread_time", time.process_time)

SECONDS = 4.0
"""Processor time to read and judge one text; deriving the right answer is not counted.

A step that has begun, and a verdict with the causes known by then, take some tenths of a second
more: all ends within the 5 s that SECURITY.md promises.
"""

MOST_PARTS = 100_000
"""Largest number of parts of all formulas of a text together, about 250 MB with their values."""

TOO_LONG = (
    f"the formulas have more than {MOST_PARTS:,} parts with their definitions and derivatives "
    "written out; write them shorter"
)

_LOOK = 64
"""The clock is read once in this many parts, as reading it takes as long as making a part."""


@final
class SpentError(FormulaError):
    """A judgement takes more than it may.

    Args:
        message: what to do about it.
        most: what it may take, in words.
    """

    def __init__(self, message: str, most: str) -> None:
        super().__init__(message)
        self.most = most


@final
class _Budget:
    """What is left for one judgement."""

    def __init__(self) -> None:
        self.left = MOST_PARTS
        self.end = processor_time() + SECONDS

    def spend(self, parts: int) -> None:
        """Take parts from what is left."""
        before, self.left = self.left, self.left - parts
        if self.left < 0:
            raise SpentError(TOO_LONG, f"{MOST_PARTS:,} parts")
        looks = before // _LOOK != self.left // _LOOK or not parts
        if looks and processor_time() > self.end:
            most = f"{SECONDS:g} s"
            raise SpentError(f"the formulas are not judged within {most}; write them shorter", most)


_CURRENT: ContextVar[_Budget | None] = ContextVar("budget", default=None)


@contextmanager
def bound_work() -> Iterator[None]:
    """Bound what is done in the context; within another bound, by that."""
    if _CURRENT.get() is not None:
        yield
        return
    token = _CURRENT.set(_Budget())
    try:
        yield
    finally:
        _CURRENT.reset(token)


@contextmanager
def stop_clock() -> Iterator[None]:
    """Stop the clock in the context: what is done does not depend on the text."""
    budget = _CURRENT.get()
    start = processor_time()
    token = _CURRENT.set(None)
    try:
        yield
    finally:
        _CURRENT.reset(token)
        if budget is not None:
            budget.end += processor_time() - start


def spend(parts: int = 0) -> None:
    """Count parts of formulas that are made or evaluated, and read the clock."""
    budget = _CURRENT.get()
    if budget is not None:
        budget.spend(parts)
