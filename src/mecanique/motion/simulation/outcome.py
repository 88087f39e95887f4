"""How an integration ended, and the error that explains it where that was not as asked."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias, final

import numpy as np

from mecanique.errors import IntegrationError
from mecanique.model.mechanism import Mechanism
from mecanique.motion.record.motion import Motion

__all__ = ["Kind", "Outcome", "failure"]

Kind: TypeAlias = Literal[
    "end",
    "event",
    "contact",
    "halt",
    "reconsider",
    "interrupted",
    "stiff",
    "too many steps",
    "step too small",
    "not finite",
    "progress",
    "fault",
]

MAX_LISTED = 8
"""At most this many values of a state are listed in a message."""


@final
@dataclass(frozen=True)
class Outcome:
    """How an integration ended, or a stretch of it.

    Args:
        kind: "end" if it came to its end, "event" if an event ended it, "contact" if impacts
            followed each other without end; "halt" if a stretch ended because its last step needs
            a correction; "reconsider" if another method may pay; "interrupted" by Ctrl-C; "stiff",
            "too many steps" or "step too small" if the method gave up; "not finite" if the
            acceleration at the start is not; "progress" or "fault" if `progress`, or the
            equations, raised an exception.
        fault: what was raised.
    """

    kind: Kind
    fault: BaseException | None = None

    @property
    def complete(self) -> bool:
        """Whether the motion ends where it should."""
        return self.kind in ("end", "event")

    @property
    def accurate(self) -> bool:
        """Whether the equations are defined up to the last step, so that it can be refined."""
        return self.kind in ("end", "event", "contact")


def failure(
    outcome: Outcome,
    mechanism: Mechanism,
    t: float,
    y: np.ndarray | None,
    max_steps: int,
    motion: Motion | None,
) -> IntegrationError:
    """Return the error that explains why an integration is not complete.

    Args:
        outcome: how it ended.
        mechanism: what moves.
        t: the time it reached [s].
        y: shape (nq + nv,), the state there; None if there is none.
        max_steps: how many steps were allowed.
        motion: the motion until then, if there is one.
    """
    fault = outcome.fault
    if fault is not None and not isinstance(fault, (Exception, KeyboardInterrupt)):
        raise fault  # e.g. SystemExit, kept back until the compiled integrator had returned
    where = "" if y is None else f" at t = {t:.6g} s, {_listing(mechanism, y)}"
    cause = fault
    if outcome.kind == "interrupted" or isinstance(fault, KeyboardInterrupt):
        message, cause = f"interrupted{where}", KeyboardInterrupt()
    elif outcome.kind == "contact":
        name = motion.events[-1].name if motion is not None else ""
        message = (
            f"event {name!r} comes to rest{where}: a lasting contact is not modelled; "
            "let the event stop"
        )
    elif outcome.kind == "progress":
        message = f"progress raised {fault!r}{where}"
    elif outcome.kind == "fault":
        message = f"the equations failed{where}: {fault}"
    elif outcome.kind == "not finite":
        message = (
            f"the acceleration at the start is not finite{where}: expected a start where the mass "
            "matrix is regular and every force is finite"
        )
    elif outcome.kind == "stiff":
        message = (
            f"the equations are too stiff for dop853{where}; use method='auto', 'lsoda' or 'radau'"
        )
    elif outcome.kind == "too many steps":
        message = (
            f"more than {max_steps} steps{where}; raise max_steps, shorten the duration or "
            "loosen rtol"
        )
    else:
        message = (
            f"the step size collapsed{where}: a force or the mass matrix becomes singular there, "
            "or an input jumps; check the forces near this state, or loosen rtol"
        )
    kept = "; the motion until then is in the error's .motion" if motion is not None else ""
    error = IntegrationError(message + kept, time=t, state=y, motion=motion)
    error.__cause__ = cause
    return error


def _listing(mechanism: Mechanism, y: np.ndarray) -> str:
    names = (*mechanism.coordinates.names, *mechanism.velocities)
    values = list(zip(names, y, strict=True))[:MAX_LISTED]
    more = ", …" if len(names) > MAX_LISTED else ""
    return ", ".join(f"{name} = {value:.6g}" for name, value in values) + more
