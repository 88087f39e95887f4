"""Mistakes about bodies, forces and gravity: wrong inertia, weights, free lengths."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from mecanique.checking.mistakes.slips.hypothesis import Hypothesis, RightEquations
from mecanique.model.bodies import Body
from mecanique.model.expression import plain
from mecanique.model.force_base import AnyForce
from mecanique.model.forces import JointSpring, Spring
from mecanique.model.mechanism import Mechanism

_SINGULAR = 1e-12
_MOST_BODIES = 7
"""With more bodies in loops, deriving each change again would take seconds."""


def mistake_parts(right: RightEquations) -> Iterator[Hypothesis]:
    """Yield equations with wrong inertia, weight or spring of a single part."""
    mechanism = right.truth.mechanism
    if mechanism.constrained and len(mechanism.bodies) > _MOST_BODIES:
        return
    yield from _gravity(right, mechanism)
    for body in mechanism.bodies:
        if plain(body.mass) == 0:
            continue
        yield from _body(right, mechanism, body)
    for force in mechanism.forces:
        others = tuple(one for one in mechanism.forces if one is not force)
        less = right.rebuild(replace(mechanism, forces=others))
        if less is not None:
            own_M, own_rest = right.sample.M - less[0], right.rest - less[1]
            for kind, factor, what in (
                ("missing", 0.0, f"the force {force.name!r} is missing"),
                ("sign", -1.0, f"the sign of the force {force.name!r} is wrong"),
                ("factor", 2.0, f"the force {force.name!r} is counted twice"),
                ("factor", 0.5, f"the force {force.name!r} is halved (an extra factor ½)"),
            ):
                M, rest = less[0] + factor * own_M, less[1] + factor * own_rest
                yield Hypothesis(kind, what, 1.2 + 0.3 * (kind == "factor"), M, rest)
        yield from _forget_free_length(right, mechanism, force)


def _forget_free_length(
    right: RightEquations, mechanism: Mechanism, force: AnyForce
) -> Iterator[Hypothesis]:
    changed: AnyForce
    if isinstance(force, Spring) and force.free_length:
        changed = replace(force, free_length=0.0)
    elif isinstance(force, JointSpring) and force.reference:
        changed = replace(force, reference=0.0)
    else:
        return
    forces = tuple(changed if one is force else one for one in mechanism.forces)
    found = right.rebuild(replace(mechanism, forces=forces))
    if found is not None:
        what = f"the free length of the spring {force.name!r} is forgotten"
        yield Hypothesis("free length", what, 0.8, *found)


def _gravity(right: RightEquations, mechanism: Mechanism) -> Iterator[Hypothesis]:
    less = right.rebuild(replace(mechanism, gravity=(0.0, 0.0, 0.0)))
    if less is None:
        return
    M, rest = less
    weight = right.rest - rest
    what = "the sign of the potential of gravity is wrong"
    yield Hypothesis("potential sign", what, 0.9, M, rest - weight)
    yield Hypothesis("missing", "gravity is missing", 1.0, M, rest)
    what = "the kinetic energy lacks its factor ½, or the potential energy has an extra ½"
    yield Hypothesis("half", what, 1.1, M, rest + weight / 2)
    what = "the kinetic energy has an extra factor ½, or the potential energy is counted twice"
    yield Hypothesis("half", what, 1.1, M, rest + 2 * weight)


def _body(right: RightEquations, mechanism: Mechanism, body: Body) -> Iterator[Hypothesis]:
    """Yield mistakes about a body: inertia about center or joint, Steiner's term, weight."""
    bare = body.replace(inertia=(0.0,) * 6)
    particle = right.rebuild(_with_body(mechanism, bare))
    if particle is None:
        return
    turning = right.sample.M - particle[0], right.rest - particle[1]
    name = body.name
    # the moments of inertia of a body that only slides do not matter
    turns = bool(np.abs(turning[0]).max() > _SINGULAR * np.abs(right.sample.M).max())
    if turns:
        what = f"the inertia of {name!r} about its own center is missing (as for a particle)"
        yield Hypothesis("inertia", what, 1.0, *particle)
        what = f"the inertia of {name!r} about its own center is counted twice"
        twice = right.sample.M + turning[0], right.rest + turning[1]
        yield Hypothesis("inertia", what, 1.6, *twice)
    still = right.rebuild(replace(_with_body(mechanism, bare), gravity=(0.0, 0.0, 0.0)))
    gone = body.replace(mass=0.0, inertia=(0.0,) * 6)
    absent = right.rebuild(replace(_with_body(mechanism, gone), gravity=(0.0, 0.0, 0.0)))
    if still is None or absent is None:
        return
    moving = still[0] - absent[0], still[1] - absent[1]
    if turns:
        what = f"the inertia of {name!r} is taken about its center (Steiner's term is missing)"
        rest = right.rest - moving[1]
        yield Hypothesis("parallel axis", what, 0.8, right.sample.M - moving[0], rest)
        what = (
            f"Steiner's term of {name!r} is counted twice: inertia about the joint and the "
            "motion of the center"
        )
        rest = right.rest + moving[1]
        yield Hypothesis("parallel axis", what, 0.9, right.sample.M + moving[0], rest)
    light = right.rebuild(_with_body(mechanism, gone))
    if light is not None:
        what = f"the mass of {name!r} is missing"
        yield Hypothesis("missing", what, 1.3, *light)
        weight = (particle[1] - still[1]) - (light[1] - absent[1])
        what = f"the weight of {name!r} is missing"
        yield Hypothesis("missing", what, 1.1, right.sample.M, right.rest - weight)
        what = f"the sign of the weight of {name!r} is wrong"
        yield Hypothesis("sign", what, 1.1, right.sample.M, right.rest - 2 * weight)


def _with_body(mechanism: Mechanism, body: Body) -> Mechanism:
    bodies = tuple(body if one.name == body.name else one for one in mechanism.bodies)
    return replace(mechanism, bodies=bodies)
