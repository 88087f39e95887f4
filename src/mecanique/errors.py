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
    """Root of all errors mecanique raises on purpose.

    Example:
        >>> try:
        ...     mq.textbook.load("simple_pendulun")
        ... except mq.MecaniqueError as error:
        ...     print(error)
        unknown system 'simple_pendulun'; did you mean 'simple_pendulum' or 'coupled_pendulums'
        or 'spherical_pendulum'?
    """

    def __reduce__(self) -> tuple[Any, ...]:
        # by default an exception is copied by calling its class with the message, which loses its
        # data
        return _rebuild, (type(self), self.args, self.__dict__)


class InputError(MecaniqueError, ValueError):
    """An argument is wrong; the message says what was expected and what was given.

    Example:
        >>> mq.rod(1.0, 2.0, direction=(0, 0, 0))
        Traceback (most recent call last):
            ...
        mecanique.errors.InputError: expected a finite vector with a length for the direction of a
        rod, got (0, 0, 0)
    """


class UnknownNameError(InputError):
    """A name that does not exist.

    Args:
        kind: what the name should have named, e.g. "system" or "coordinate".
        name: the name given.
        known: the names that exist.

    Example:
        >>> mq.simulate(mq.textbook.load("cart_pole"), q={"theta": 0.1})
        Traceback (most recent call last):
            ...
        mecanique.errors.UnknownNameError: unknown coordinate 'theta'; known: x, q
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

    Example:
        >>> try:
        ...     mq.check(mq.textbook.load("simple_pendulum"), "q'' + g/L sin q = 0")
        ... except mq.FormulaError as error:
        ...     print(error.unknown, error.text[error.position])
        ('L',) L
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

    Example:
        >>> bodies = mq.Body("ground"), mq.Body("rod", mq.rod(1.0, 1.0))
        >>> try:
        ...     mq.Mechanism("broken", bodies, joints=())
        ... except mq.MechanismError as error:
        ...     print(error.faults[0])
        body 'rod' is not connected to the ground 'ground'
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

    Example:
        >>> mq.read_urdf('<robot name="arm"><link name="base"></robot>')
        Traceback (most recent call last):
            ...
        mecanique.errors.UrdfError: line 1: the text is not well-formed XML: mismatched tag.
        Mend the XML at this line.
    """

    def __init__(self, message: str, *, file: str | None = None, line: int | None = None) -> None:
        self.file = file
        self.line = line
        place = file or ""
        if line is not None:
            place += f":{line}" if place else f"line {line}"
        super().__init__(f"{place}: {message}" if place else message)


class DerivationError(MecaniqueError):
    """The in-house derivation cannot be carried out in the form asked for.

    Example:
        >>> mq.routh(mq.textbook.load("double_pendulum"))
        Traceback (most recent call last):
            ...
        mecanique.errors.DerivationError: mechanism 'double_pendulum' has no cyclic coordinate:
        T or V depends on each of q1, q2, or another force acts along it; no momentum ∂T/∂q' is
        conserved, and Routh's reduction does not apply
    """


class ClosureError(MecaniqueError):
    """A loop that cannot be closed, or whose closure leaves the motion undetermined.

    Example:
        >>> mq.assemble(mq.textbook.load("four_bar_linkage", c=9.0))
        Traceback (most recent call last):
            ...
        mecanique.errors.ClosureError: mechanism 'four_bar_linkage': loop 'C' cannot be closed
        from there; the nearest position found leaves it open by 7.8 m (C: x); try another
        guess, or check its lengths
    """


class EngineError(MecaniqueError):
    """Pinocchio refused the mechanism, or would answer it wrongly.

    Example:
        >>> bodies = (mq.Body("ground"), mq.Body("nothing"))
        >>> ghost = mq.Mechanism("ghost", bodies, (mq.Revolute("hinge", "ground", "nothing"),))
        >>> mq.Reference(ghost).acceleration([0.0])
        Traceback (most recent call last):
            ...
        mecanique.errors.EngineError: mechanism 'ghost': the motion hinge', joint 'hinge' (body
        'nothing') moves no mass, so nothing determines it; give the body mass or inertia
        (`mecanique inertia FILE --density 1000 -o NEW` takes them from shapes), or prescribe the
        joint by the coordinate map
    """


class IntegrationError(MecaniqueError):
    """The integration of a motion stopped before its end; the error carries the motion so far.

    Args:
        message: what happened, when, and what to do.
        time: when it stopped [s], if it started at all.
        state: positions, then velocities, where it stopped.
        motion: the `Motion` up to there, if there is one.

    Example:
        >>> pendulum = mq.textbook.load("double_pendulum")
        >>> try:
        ...     mq.simulate(pendulum, q={"q1": 2.0}, duration=10.0, max_steps=20)
        ... except mq.IntegrationError as error:
        ...     print(error.motion.t[-1] == error.time)
        True
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
