"""Derive the program of a mechanism's motion, and admit it if it agrees with the reference.

It comes from the closed form. Those of mechanisms with loops come from the recursion along
the tree, with the multipliers of the loops solved for in the program; another part of it brings a
state back onto the loops.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from copy import copy
from math import inf
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from mecanique.derivation import derive
from mecanique.derivation.mechanics.letters import Letters
from mecanique.derivation.mechanics.loops import loops_of
from mecanique.derivation.mechanics.recursion import World
from mecanique.derivation.mechanics.vectors import add, cross, dot, scale
from mecanique.derivation.tree.poses import times_point
from mecanique.errors import DerivationError
from mecanique.generation.mechanics.articulated import Articulated, articulate
from mecanique.generation.mechanics.closed_form import ClosedFormProgram
from mecanique.generation.mechanics.constrained import FactorizedConstraints, landing_of
from mecanique.generation.mechanics.dynamics import TapeDynamics, Tree
from mecanique.generation.mechanics.free_body_forces import FreeBodyForces
from mecanique.generation.program import LoopProjection
from mecanique.model.mechanism import Mechanism
from mecanique.model.states import States
from mecanique.motion.compile.program import SAMPLES, RatesProgram, is_long_chain
from mecanique.motion.compile.python import overwriting, owning
from mecanique.motion.record.curve import RightHandSide
from mecanique.program.solving import factorize
from mecanique.program.sweeps import push_forward
from mecanique.program.tape import Value
from mecanique.program.traced import trace, value_of, values_of
from mecanique.verification.rounding import rounding
from mecanique.verification.rows import rows_of
from mecanique.verification.states import random_states
from mecanique.verification.verdict import SOLVED_ALIKE

if TYPE_CHECKING:
    from mecanique.reference import Reference

MOST = 100_000
"""Operations of a closed mechanism's program; a longer one is no faster than the reference."""


MOST_OF_CHAIN = 300_000
"""The same of a long chain: for each velocity some 1,000 are written, of which 400 are needed, and
the engine takes 250 velocities."""


def program_of(
    mechanism: Mechanism, swept: Collection[str] = (), states: States | None = None
) -> RatesProgram:
    """Derive a mechanism's equations as a program; only the swept parameters stay inputs."""
    kept = {p.symbol for p in mechanism.parameters if p.symbol in swept}
    most = inf
    if mechanism.constrained:
        most = MOST_OF_CHAIN if is_long_chain(mechanism) else MOST
    letters = Letters(mechanism, kept, most)
    landing = None
    if mechanism.constrained:
        rates, landing = _solve_loops(letters, states)
    else:
        equations = derive(mechanism)
        # a closed form that takes the sign of a length for granted would go wrong beyond it
        signed = bool(equations.derivation.assumptions)
        form = Tree(letters) if signed else ClosedFormProgram(letters, equations)
        rest = [Q - h for Q, h in zip(form.forces(), form.bias(), strict=True)]
        accelerations = factorize(letters.tape, form.mass_matrix()).solve(rest)
        rates = values_of([*letters.rates, *accelerations])
    open_ = tuple(symbol for symbol in letters.open if symbol in kept)
    signals = tuple(letters.signals)
    # a copy, so that who keeps the program for a mechanism does not keep that mechanism alive
    return RatesProgram(copy(mechanism), letters.tape, tuple(rates), open_, signals, landing)


def power_of(mechanism: Mechanism) -> RatesProgram:
    """Return the power of a mechanism's forces, all of them, as a program with one result."""
    letters = Letters(mechanism)
    power = 0.0 * letters.t
    for Q, v in zip(Tree(letters).forces(), letters.v, strict=True):
        power = power + Q * v
    return RatesProgram(mechanism, letters.tape, tuple(values_of([power])), (), ())


def energies_of(mechanism: Mechanism) -> RatesProgram:
    """Return kinetic energy, V of gravity and V of the springs as a program of three results."""
    letters = Letters(mechanism)
    tree = Tree(letters)
    parts = values_of([*tree.recursion.energy(), tree.loads.energy()])
    return RatesProgram(mechanism, letters.tape, tuple(parts), (), tuple(letters.signals))


def rheonomic_of(mechanism: Mechanism) -> RatesProgram:
    """Return −∂L/∂t at constant signals and T₁ + 2 T₀ as a program, then −∂L/∂s of each signal s.

    Signals that are functions are parts of the state. T₁ and T₀ are the parts of T of first and
    zeroth degree in v: v·∂T/∂v = 2 T₂ + T₁, so that T₁ + 2 T₀ = 2 T − v·∂T/∂v.
    """
    letters = Letters(mechanism)
    tree = Tree(letters)
    T, V = tree.recursion.energy()
    V = V + tree.loads.energy()
    along = {v.place: value_of(v) for v in letters.v}
    (raised,) = push_forward(letters.tape, values_of([T]), along)
    moving = [letters.t, *(letters.values[symbol] for symbol in letters.signals)]
    slopes = [-1.0 * letters.differentiate(T - V, scalar) for scalar in moving]
    carried = 2.0 * T - trace(letters.tape, raised)
    values, more = values_of([slopes[0], carried, *slopes[1:]]), tuple(letters.signals)
    return RatesProgram(mechanism, letters.tape, tuple(values), (), (), more=more)


def poses_of(mechanism: Mechanism) -> RatesProgram:
    """Return the poses of all bodies as a program."""
    letters = Letters(mechanism)
    recursion = Tree(letters).recursion
    still = np.eye(4).tolist()
    poses = (
        still if body.name == mechanism.ground else [*recursion.pose(body.name), still[3]]
        for body in mechanism.bodies
    )
    entries = values_of([entry for pose in poses for row in pose for entry in row])
    return RatesProgram(mechanism, letters.tape, tuple(entries), (), tuple(letters.signals))


def point_of(mechanism: Mechanism, body: str, xyz: Sequence[float]) -> RatesProgram:
    """Return position, velocity and acceleration of a body's point as a program."""
    letters = Letters(mechanism)
    recursion = Tree(letters).recursion
    place = times_point(recursion.pose(body), xyz)
    velocity = letters.along(place)
    rates = zip(letters.v, values_of(letters.a), strict=True)
    acceleration = letters.along(velocity, {v.place: a for v, a in rates})
    values = tuple(values_of([*place, *velocity, *acceleration]))
    more = tuple(f"a {name}" for name in mechanism.velocities)
    return RatesProgram(mechanism, letters.tape, values, (), tuple(letters.signals), more=more)


def twist_of(mechanism: Mechanism, body: str) -> RatesProgram:
    """Return the velocity of a body's origin and its angular velocity as a program."""
    letters = Letters(mechanism)
    recursion = Tree(letters).recursion
    spin = World(recursion).motion(recursion.seats[body].place).w
    values = tuple(values_of([*recursion.velocity(body, [0.0, 0.0, 0.0]), *spin]))
    return RatesProgram(mechanism, letters.tape, values, (), tuple(letters.signals))


def speeds_of(mechanism: Mechanism) -> RatesProgram:
    """Return the speeds of all bodies' centers of mass as a program."""
    letters = Letters(mechanism)
    recursion = Tree(letters).recursion
    speeds = []
    for body in mechanism.bodies:
        center = [letters.number(x, recursion.chart.r) for x in body.center]
        velocity = recursion.velocity(body.name, center)
        speeds.append(letters.call("sqrt", dot(velocity, velocity)))
    return RatesProgram(
        mechanism, letters.tape, tuple(values_of(speeds)), (), tuple(letters.signals)
    )


def motion_of(mechanism: Mechanism, forces: str = "") -> RatesProgram:
    """Return the rates of a state by recursion as a program, then forces.

    These are force and moment of "reactions", "multipliers", or "guides", the guiding elements'.
    """
    letters = Letters(mechanism, most=MOST)
    tree = Tree(letters)
    dynamics = TapeDynamics(letters, tree, tree, "recursion along the tree")
    answers = [*letters.rates, *dynamics.acceleration]
    if forces == "reactions":
        reactions = FreeBodyForces(dynamics).joint_reactions(shared=True)
        first = len(reactions) - len(mechanism.contacts)
        hubs = {first + k: contact.seat for k, contact in enumerate(mechanism.contacts)}
        for k, wrench in enumerate(reactions):
            moment = wrench.moment
            if k in hubs:  # the reference's are about the hub, not the point of contact
                center = [letters.number(x, tree.recursion.chart.r) for x in hubs[k]]
                hub = times_point(tree.recursion.pose(wrench.body), center)
                arm = add(wrench.origin, scale(-1.0, hub))
                moment = cross(arm, wrench.force)
            answers += [*wrench.force, *moment]
    elif forces == "multipliers":
        answers += dynamics.multipliers
    elif forces == "guides":
        answers += FreeBodyForces(dynamics).guide_sizes.values()
    values, signals = tuple(values_of(answers)), tuple(letters.signals)
    landing = dynamics.landing if mechanism.constrained else None
    return RatesProgram(copy(mechanism), letters.tape, values, (), signals, landing)


def _solve_loops(letters: Letters, states: States | None) -> tuple[list[Value], LoopProjection]:
    """The rates of a closed mechanism's state, and what keeps it on its loops."""
    tree = Tree(letters)
    loops = loops_of(letters, tree.recursion)
    constrained: FactorizedConstraints | Articulated | None = None
    if states is not None and is_long_chain(letters.mechanism):
        constrained = articulate(letters, tree.recursion, loops, states)
    if constrained is None:
        constrained = FactorizedConstraints(letters, tree.mass_matrix(), loops, states)
    drive = [Q - h for Q, h in zip(tree.forces(), tree.bias(), strict=True)]
    rates = [*letters.rates, *constrained.solve(drive).acceleration]
    return values_of(rates), landing_of(letters, loops, constrained)


_FEW = 4
"""Loops of mechanisms with more velocities are closed from random positions one by one for longer
than all their equations take to derive."""


class Admitted(NamedTuple):
    """A program that may be used."""

    program: RatesProgram
    # makes functions of it, each of which overwrites its last answer
    make: Callable[[], RightHandSide]


def require_agreement(
    mechanism: Mechanism,
    reference: Reference,
    accelerations: Callable[[States], np.ndarray],
    source: str,
    states: States | None = None,
) -> None:
    """Compare accelerations with the reference's at random states, as strictly as `verify` does."""
    if states is None:
        states = random_states(mechanism, SAMPLES, 0)
    theirs = {
        "mass matrix": np.asarray(reference.mass_matrix(states.q, states.t)),
        "bias": np.asarray(reference.bias(states.q, states.v, states.t)),
        "forces": np.asarray(reference.forces(states.q, states.v, states.t)),
        "acceleration": np.asarray(reference.acceleration(states.q, states.v, states.t)),
    }
    most = rounding(mechanism, states, theirs)
    ours = {"acceleration": accelerations(states)}
    (row,) = rows_of((source, "reference"), ours, theirs, states, mechanism, rounding=most)
    if not row.worst <= max(SOLVED_ALIKE, row.rounding):
        raise DerivationError(
            f"the {source} of {mechanism.name!r} and the reference disagree: accelerations "
            f"differ by {row.worst:.1e} at q = {list(row.q)}; "
            "verify(mechanism) shows what else does"
        )


def admit(mechanism: Mechanism, reference: Reference) -> Admitted:
    """Derive a mechanism's equations as a program, and return it if the reference agrees."""
    many = SAMPLES if mechanism.constrained else 0
    far = mechanism.nv > _FEW
    states = random_states(mechanism, many, 0, lot=many, walk=far) if many else None
    program = program_of(mechanism, states=states)
    make = overwriting(program)
    rhs = owning(make())

    def accelerations(states: States) -> np.ndarray:
        rows = zip(states.q, states.v, states.t.tolist(), strict=True)
        try:
            return np.array([rhs(t, np.concatenate([q, v]))[mechanism.nq :] for q, v, t in rows])
        except (ArithmeticError, ValueError) as error:
            raise DerivationError(
                f"the closed form of {mechanism.name!r} is not defined everywhere: {error}"
            ) from error

    source = "closed form" if program.landing is None else "program"
    require_agreement(mechanism, reference, accelerations, source, states)
    return Admitted(program, make)
