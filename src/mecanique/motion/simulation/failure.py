"""Refuse what cannot be integrated, and explain why an integration did not come to its end."""

from __future__ import annotations

import numpy as np

from mecanique.arrays import Array
from mecanique.errors import InputError, IntegrationError
from mecanique.model.mechanism import Mechanism
from mecanique.model.states import explain_defaults
from mecanique.model.values import Given
from mecanique.motion.record.trajectory import Trajectory
from mecanique.motion.simulation.integrators.methods import METHODS
from mecanique.motion.simulation.problem import Integration, Problem
from mecanique.reference import Reference
from mecanique.wording import say_count

MAX_LISTED = 8
"""At most this many values of a state are listed in a message."""


def failure(
    problem: Problem, integration: Integration, motion: Trajectory | None, asked: Given
) -> IntegrationError:
    """Return the error that explains why an integration is not complete."""
    outcome, t, y = integration.outcome, integration.t, integration.y
    fault = outcome.fault
    if fault is not None and not isinstance(fault, (Exception, KeyboardInterrupt)):
        raise fault  # e.g. SystemExit, kept back until the compiled integrator had returned
    where = "" if y is None else f" at t = {t:.6g} s, {_listing(problem.mechanism, y)}"
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
    elif outcome.kind == "undecided":
        message = str(fault)
    elif outcome.kind == "not finite":
        message = (
            f"the acceleration at the start is not finite{where}: expected a start where the mass "
            "matrix is regular and every force is finite"
            + ("" if problem.loops else explain_defaults(problem.mechanism, asked))
        )
    elif outcome.kind == "stiff":
        message = (
            f"the equations are too stiff for dop853{where}; use method='auto', 'lsoda' or 'radau'"
        )
    elif outcome.kind == "too many steps":
        message = (
            f"more than {say_count(problem.max_steps, 'step')}{where}; raise max_steps, "
            "shorten the duration or loosen rtol"
        )
    elif outcome.kind == "no headway":
        message = (
            f"no headway{where}: the last steps covered less than a millionth of the duration; "
            "a force chatters there, as dry friction does at rest, or the mechanism is next to a "
            "singular position; smooth the force, or loosen rtol"
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


def refuse_corners(mechanism: Mechanism, method: str, reference: Reference | None) -> None:
    """Raise if a motion with elements that switch is asked for as none can be had."""
    if method not in ("auto", *METHODS):
        raise InputError(
            f"method {method!r} passes no corners, which {mechanism.name!r} has by its elements "
            f"that switch; expected 'auto' or one of {', '.join(METHODS)}"
        )
    if reference is not None:
        raise InputError(
            "expected no reference for a mechanism with elements that switch: each motion has one "
            "of its own, with their forces"
        )


def _listing(mechanism: Mechanism, y: np.ndarray) -> str:
    names = (*mechanism.coordinates.names, *mechanism.velocities)
    values = list(zip(names, y, strict=True))[:MAX_LISTED]
    more = ", …" if len(names) > MAX_LISTED else ""
    return ", ".join(f"{name} = {value:.6g}" for name, value in values) + more


_ROUNDING = 1e-13
"""Eigenvalues of the scaled mass matrix above minus this are zero to rounding."""


def refuse_indefinite(reference: Reference, t: Array, q: Array) -> None:
    """Raise if the mass matrix has a negative eigenvalue at any of the n states."""
    bodies = [body.name for body in reference.mechanism.bodies if body.as_given]
    if not bodies:
        return
    mass = reference.mass_matrix(q, t)
    size = np.sqrt(np.abs(np.diagonal(mass, axis1=1, axis2=2)))
    size = np.where(size > 0, size, 1.0)
    least = np.linalg.eigvalsh(mass / (size[:, :, None] * size[:, None, :]))[:, 0]
    wrong = np.flatnonzero(least < -_ROUNDING)
    if len(wrong):
        first = wrong[0]
        raise IntegrationError(
            f"the mass matrix is not positive definite at t = {t[first]:.6g} s: there are motions "
            "with negative kinetic energy, so that no integration means anything; no real body "
            f"has the inertia of {', '.join(map(repr, bodies[:6]))}"
            f"{', …' if len(bodies) > 6 else ''}; mend it (mecanique lint --fix --balance)",
            time=float(t[first]),
            state=q[first],
        )
