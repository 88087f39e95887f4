"""Derive the program of a mechanism's motion, and admit it if it agrees with the reference.

It comes from the closed form. Those of mechanisms with loops come from the recursion along
the tree, with the multipliers of the loops solved for in the program; another part of it brings a
state back onto the loops.
"""

from __future__ import annotations

from collections.abc import Callable, Collection
from copy import copy
from math import inf
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from mecanique.derivation import derive
from mecanique.derivation.mechanics.letters import Letters
from mecanique.derivation.mechanics.loops import loops_of
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
from mecanique.program.tape import Value
from mecanique.program.traced import values_of
from mecanique.verification.rounding import rounding
from mecanique.verification.rows import rows_of
from mecanique.verification.states import random_states
from mecanique.verification.verdict import TOLERANCE

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


def poses_of(mechanism: Mechanism) -> RatesProgram:
    """Return the upper three rows of the poses of all bodies as a program."""
    letters = Letters(mechanism)
    recursion = Tree(letters).recursion
    still = np.eye(4).tolist()
    poses = (
        still if body.name == mechanism.ground else recursion.pose(body.name)
        for body in mechanism.bodies
    )
    entries = values_of([entry for pose in poses for row in pose[:3] for entry in row])
    return RatesProgram(mechanism, letters.tape, tuple(entries), (), tuple(letters.signals))


def motion_of(mechanism: Mechanism, *, reactions: bool = False) -> RatesProgram:
    """Return the rates of a state by recursion as a program, then force and moment of reactions.

    Raises:
        DerivationError: if it is too long, or elements and contacts share the reactions.
    """
    letters = Letters(mechanism, most=MOST)
    tree = Tree(letters)
    dynamics = TapeDynamics(letters, tree, tree, "recursion along the tree")
    answers = [*letters.rates, *dynamics.acceleration]
    if reactions:
        for wrench in FreeBodyForces(dynamics).joint_reactions():
            answers += [*wrench.force, *wrench.moment]
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
    if not row.worst <= max(TOLERANCE, row.rounding):
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
