"""The family of errors: every error mecanique raises on purpose is a `MecaniqueError`."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from difflib import get_close_matches
from typing import Any

from mecanique.wording import say_count

__all__ = [
    "ClosureError",
    "DerivationError",
    "EngineError",
    "FormulaError",
    "InputError",
    "IntegrationError",
    "MecaniqueError",
    "MechanismError",
    "UnknownNameError",
    "UrdfError",
]


_AROUND = 40
"""Characters shown on either side of a fault in a formula."""


class MecaniqueError(Exception):
    """Root of all errors mecanique raises on purpose."""

    def __reduce__(self) -> tuple[Any, ...]:
        # by default an exception is copied by calling its class with the message, which loses its
        # data
        return _rebuild, (type(self), self.args, self.__dict__)


class InputError(MecaniqueError, ValueError):
    """An argument is wrong; the message says what was expected and what was given."""


class UnknownNameError(InputError):
    """A name that does not exist.

    Args:
        kind: what the name should have named, e.g. "system" or "coordinate".
        name: the name given.
        known: the names that exist.
    """

    def __init__(self, kind: str, name: object, known: Iterable[str]) -> None:
        self.kind = kind
        self.name = str(name)
        self.known = tuple(dict.fromkeys(known))
        self.near = tuple(get_close_matches(self.name, self.known, n=3, cutoff=0.5))
        hint = (
            f"did you mean {' or '.join(map(repr, self.near))}?"
            if self.near
            else f"known: {_list(self.known)}"
        )
        super().__init__(f"unknown {kind} {self.name!r}; {hint}")


class FormulaError(InputError):
    """A formula that cannot be read; the message shows the place and suggests a remedy.

    Args:
        message: what is wrong and what to do.
        text: the formula.
        position: where in the text it is, counted from 0.
        unknown: the letters that are not known, if that is the fault.
    """

    def __init__(
        self, message: str, text: str = "", position: int = 0, unknown: Iterable[str] = ()
    ) -> None:
        self.text = text
        self.position = position
        self.unknown = tuple(unknown)
        before = text[:position]
        self.line = before.count("\n") + 1
        self.column = position - (before.rfind("\n") + 1) + 1
        super().__init__(message + self._pointer() if text else message)

    def _pointer(self) -> str:
        """Return the part of the line around the place, with a caret below."""
        whole = self.text.splitlines()[self.line - 1] if self.position < len(self.text) else ""
        whole = whole or (self.text.splitlines() or [""])[-1]
        first = max(0, self.column - 1 - _AROUND)
        shown = whole[first : self.column - 1 + _AROUND].replace("\t", " ")
        return f"\n  {shown}\n  {' ' * (self.column - 1 - first)}^"


class MechanismError(MecaniqueError):
    """A mechanism that is not sound; the error carries every fault found, not only the first.

    Args:
        name: the mechanism's name.
        faults: one sentence per fault, each naming the body, joint or force at fault.
    """

    def __init__(self, name: str, faults: Sequence[str]) -> None:
        self.name = name
        self.faults = tuple(faults)
        count = say_count(len(self.faults), "fault")
        super().__init__("\n  ".join([f"mechanism {name!r} has {count}:", *self.faults]))


class UrdfError(MecaniqueError):
    """A URDF text that cannot be read, or a mechanism that cannot be written as one.

    Args:
        message: what is wrong and what to do.
        file: the file's name, if there is one.
        line: the line, counted from 1.
    """

    def __init__(self, message: str, *, file: str | None = None, line: int | None = None) -> None:
        self.file = file
        self.line = line
        place = file or ""
        if line is not None:
            place += f":{line}" if place else f"line {line}"
        super().__init__(f"{place}: {message}" if place else message)


class DerivationError(MecaniqueError):
    """The in-house derivation cannot be carried out in the form asked for."""


class ClosureError(MecaniqueError):
    """A loop that cannot be closed, or whose closure leaves the motion undetermined."""


class EngineError(MecaniqueError):
    """Pinocchio refused the mechanism, or would answer it wrongly."""


class IntegrationError(MecaniqueError):
    """The integration of a motion stopped before its end; the error carries the motion so far.

    Args:
        message: what happened, when, and what to do.
        time: when it stopped [s], if it started at all.
        state: positions, then velocities, where it stopped.
        motion: the `Motion` up to there, if there is one.
    """

    def __init__(
        self, message: str, *, time: float | None = None, state: Any = None, motion: Any = None
    ) -> None:
        self.time = time
        self.state = state
        self.motion = motion
        super().__init__(message)


def _rebuild(
    kind: type[MecaniqueError], args: tuple[Any, ...], data: dict[str, Any]
) -> MecaniqueError:
    error = kind.__new__(kind, *args)
    error.__dict__.update(data)
    return error


def _list(names: Sequence[str], most: int = 12) -> str:
    shown = ", ".join(names[:most]) or "none"
    return f"{shown}, … ({len(names)} in all)" if len(names) > most else shown
