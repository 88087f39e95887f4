"""Linearize a mechanism about a state given, or about an equilibrium that is looked for."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from mecanique.errors import EngineError, InputError
from mecanique.model.expression import finite
from mecanique.model.mechanism import Mechanism
from mecanique.motion.linear.differences import find_idle, linearize_about, refuse_rolling
from mecanique.motion.linear.equilibria import (
    HOPELESS,
    EquilibriumSearch,
    draw_starts,
    equilibrium_near,
    find_family,
    say_family,
)
from mecanique.motion.linear.free_motions import drop_disturbances
from mecanique.motion.linear.linearization import Linearization
from mecanique.motion.record.curve import State
from mecanique.motion.simulation.problem import Values
from mecanique.threads import one_thread_for_loops

if TYPE_CHECKING:
    from mecanique.reference import Reference

STARTS = 20
"""Number of random starts of the search if no equilibrium is near the neutral position."""


@one_thread_for_loops
def linearize(
    mechanism: Mechanism,
    at: Values | State | None = None,
    *,
    near: Values | None = None,
    v: Values | None = None,
    t: float = 0.0,
    reference: Reference | None = None,
) -> Linearization:
    """Linearize the equations of motion about a state.

    M a + bias − forces is differentiated by central differences of eighth order; `error` says how
    well that worked. About a state in motion the accelerations are held at the state's own. A
    mechanism with loops is linearized in independent deviations, about the state on the loops next
    to the one given.

    Without `at` an equilibrium is looked for by Newton's method from `near`, or from the neutral
    position; inputs that change with time are then zero. Where neither is given and the neutral
    position leads nowhere, or its loops are singular, 20 random positions follow: of the
    equilibria found a stable one is chosen if there is any, and of these the one with the least
    potential energy. `chosen` says which it is; `equilibria` gives them all.

    Args:
        mechanism: what moves.
        at: positions, shape (nq,) or by name, or a `State` with time and velocities; by default an
            equilibrium.
        near: where to start the search for the equilibrium, shape (nq,) or by name.
        v: velocities, shape (nv,) or by name; zero by default.
        t: time [s].
        reference: the mechanism's `Reference`, if you have one already.

    Returns:
        M, C and K with modes and frequencies.

    Raises:
        InputError: if the state is not what is expected, no equilibrium is found, or the loops lock
            the mechanism in a singular position.
        EngineError: if a motion moves no mass in the state given.
        UnknownNameError: if a coordinate or velocity does not exist.
        ClosureError: if the loops cannot be closed.

    Example:
        >>> small = mq.linearize(mq.textbook.load('rigid_bar_pendulum'))
        >>> [round(float(w), 3) for w in small.frequencies]
        [3.836]
    """
    t = finite(t, "the time t")
    refuse_rolling(mechanism)
    mechanism.refuse_switching("small motions are those of one mode, as long as it holds")
    described = mechanism
    if at is not None and near is not None:
        raise InputError("expected either at or near, got both")
    if at is None:
        mechanism = drop_disturbances(mechanism)
        reference = reference if mechanism is described else None
    if reference is None:
        from mecanique.reference import Reference

        reference = Reference.of(mechanism)
    if isinstance(at, State):
        t, v, at = float(at.t), at.v, at.q
    if at is not None:
        return linearize_about(reference, at, v, t, described=described)
    singular = False
    if reference.closed is not None:
        from mecanique.reference.loops.freedom import refuse_locked

        singular = refuse_locked(reference.closed, t)
    # from a change point it is rounding that decides into which branch Newton's method goes
    lost = singular and near is None
    q = None if lost else equilibrium_near(reference, mechanism.position(near), t)
    place = "the neutral position" if near is None else "the start given"
    if q is None and near is not None:
        raise InputError(_no_equilibrium(mechanism, place))
    if q is not None:
        chosen = f"the equilibrium that Newton's method reaches from {place}"
        try:
            chosen += say_family(find_family(reference, q, t, find_idle(reference, q, t)))
            return linearize_about(reference, q, v, t, described=described, chosen=chosen)
        except (EngineError, InputError):
            # e.g. where the axes of a gimbal fall in line; there may be another
            if near is not None:
                raise
    best = _search(reference, t, described)
    if v is None:
        return best
    return linearize_about(reference, best.q, v, t, described=described, chosen=best.chosen)


def _search(reference: Reference, t: float, described: Mechanism) -> Linearization:
    """Linearize about the best of the equilibria found from random starts."""
    mechanism = reference.mechanism
    first, *starts = draw_starts(mechanism, STARTS, 0)
    search = EquilibriumSearch(reference, [first, *starts], t)
    for k, start in enumerate(starts):
        if k == HOPELESS and not (search.equilibria or search.refused):
            break
        search.add(start)
    if not search.equilibria:
        if search.refused:
            raise InputError(
                f"the equilibria found of {mechanism.name!r} cannot be linearized about: "
                f"{search.refused[-1]}; choose other coordinates, or give a state: "
                "linearize(mechanism, at={...})"
            )
        raise InputError(_no_equilibrium(mechanism, "the neutral position or random ones"))
    best = min(search.sorted, key=lambda equilibrium: not equilibrium.stable)
    count = len(search.equilibria)
    if count == 1:
        chosen = f"the only equilibrium that {STARTS} random starts lead to"
    else:
        kind = "the stable one" if best.stable else "of which none is stable, the one"
        chosen = f"of {count} equilibria that {STARTS} random starts lead to, {kind} with the least"
        chosen += " potential energy"
    chosen += say_family(best.family)
    return replace(best.linearization, mechanism=described, chosen=chosen)


def _no_equilibrium(mechanism: Mechanism, start: str) -> str:
    return (
        f"no equilibrium of {mechanism.name!r} was found from {start}; if it has one, say where: "
        "linearize(mechanism, near={...}), or --at on the command line; a motion or a fall that "
        "nothing balances has none, but can be linearized about any state: "
        "linearize(mechanism, at={...})"
    )
