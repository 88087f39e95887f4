"""Words that depend on numbers."""

from __future__ import annotations

__all__ = ["say_count"]


def say_count(count: int, noun: str, plural: str = "") -> str:
    """Return a count with its noun: "1 state", "2 states", "3 bodies".

    Args:
        count: how many.
        noun: what is counted, one of it.
        plural: several of it; with an s by default.
    """
    return f"{count} {noun if count == 1 else plural or f'{noun}s'}"
