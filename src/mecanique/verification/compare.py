"""Compare the in-house derivation of a mechanism with the engine, or with another source."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from typing import TYPE_CHECKING, Any, final

import numpy as np

from mecanique.arrays import Array
from mecanique.derivation import derive
from mecanique.derivation.equations import Equations
from mecanique.derivation.numeric.constraints.independent import Reduced
from mecanique.derivation.numeric.constraints.multipliers import solve_held
from mecanique.derivation.numeric.constraints.rows import Held, RowUnits
from mecanique.derivation.numeric.lagrange import LagrangeOnJets
from mecanique.derivation.scalars.evaluation import Evaluation
from mecanique.derivation.scalars.jets import Jet
from mecanique.derivation.scalars.series import Series
from mecanique.derivation.symbolic.derivation import Assumption, Derivation
from mecanique.derivation.tree.links import links, place_of
from mecanique.errors import DerivationError, EngineError, InputError
from mecanique.model.constraints.contacts import row_names
from mecanique.model.mechanism import Mechanism
from mecanique.model.mechanism.description import angles
from mecanique.model.mechanism_units import characteristic_length
from mecanique.model.states import States
from mecanique.model.values import Given
from mecanique.reference import Reference
from mecanique.reference.engine.package import engine_name
from mecanique.threads import one_thread_for_loops
from mecanique.verification.rounding import (
    entry_rounding,
    in_independent_coordinates,
    measure_noise,
    rounding,
)
from mecanique.verification.rows import QUANTITIES, DynamicsSource, evaluate, rows_of, scales
from mecanique.verification.states import random_states, usual_samples
from mecanique.verification.verdict import SOLVED_ALIKE, Row, Verdict, conclude
from mecanique.wording import OF_SHAPES, say_count

if TYPE_CHECKING:
    from mecanique.verification.against import Counterpart


WAY_OUT = f"give its bodies mass and inertia: {OF_SHAPES}"
"""What to do about a robot without mass."""

_NOTE = (
    f"kinematics alone: nothing that moves has mass, so it has no equations of motion; {WAY_OUT}"
)


def has_mass(mechanism: Mechanism) -> bool:
    """Whether anything that moves has mass, inertia or a rotor."""
    moving = (body for body in mechanism.bodies if body.name != mechanism.ground)
    if any(any(mechanism.evaluate_all((body.mass, *body.inertia))) for body in moving):
        return True
    rotors = (getattr(joint, "armature", 0.0) for joint in mechanism.joints)
    return any(map(mechanism.evaluate, rotors))


def compare_kinematics(
    mechanism: Mechanism, samples: int, seed: int, tolerance: float = SOLVED_ALIKE
) -> Verdict:
    """Compare poses and Jacobians of all bodies, and gaps and Jacobians of loops, with the engine.

    The in-house Jacobian is the derivative of the poses themselves, on jets.
    """
    states = random_states(mechanism, samples, seed)
    engine = Reference.of(mechanism)
    length = characteristic_length(mechanism)
    _, poses = LagrangeOnJets(mechanism).motion(states, np.zeros_like(states.v))
    place = place_of(links(mechanism), mechanism)
    index = {body.name: k for k, body in enumerate(mechanism.bodies)}
    del index[mechanism.ground]
    ours = [poses[place[name]] for name in index]
    theirs = np.asarray(engine.poses(states.q, states.t))[:, list(index.values())]
    given = [np.asarray(engine.jacobian(name, states.q, states.t)) for name in index]
    # lengths in poses, and the rows of velocities, have the characteristic length as their unit
    in_rows = np.repeat([length, 1.0], 3)[:, None]
    in_poses = np.ones((4, 4))
    in_poses[:3, 3] = length
    pairs = {
        "poses": (np.stack([pose.value for pose in ours], axis=1) / in_poses, theirs / in_poses),
        "Jacobians": (
            np.stack(list(map(_jacobian, ours)), axis=1) / in_rows,
            np.stack(given, axis=1) / in_rows,
        ),
    }
    if mechanism.loops and not mechanism.contacts:
        held = Held(mechanism)
        here = held.at(states)
        units = held.row_units.units
        residual = np.asarray(engine.constraint_residual(states.q, states.t))
        J = np.asarray(engine.constraint_jacobian(states.q, states.t)) / units[:, None]
        pairs["gaps of loops"] = (here.residual / units)[:, None], (residual / units)[:, None]
        pairs["Jacobians of loops"] = (here.jacobian / units[:, None])[:, None], J[:, None]
    rows = []
    for quantity, (a, b) in pairs.items():
        names = () if "loops" in quantity else tuple(index)
        rows.append(_row(quantity, a, b, states, tolerance, names))
    return conclude(mechanism, rows, len(states), seed, tolerance, notes=(_NOTE,))


def _row(
    quantity: str,
    ours: Array,
    theirs: Array,
    states: States,
    tolerance: float,
    names: tuple[str, ...],
) -> Row:
    """Compare arrays (n, parts, …); relative to 1 or the largest entry of a part."""
    n, parts = theirs.shape[:2]
    off, size = (
        np.abs(x).reshape(n, parts, -1).max(axis=2, initial=0.0) for x in (ours - theirs, theirs)
    )
    off = off / np.maximum(1.0, size)
    state, part = np.unravel_index(int(np.argmax(off)), off.shape)
    return Row(
        quantity,
        ("jets", engine_name()),
        float(off[state, part]),
        tuple(states.q[state].tolist()),
        tuple(states.v[state].tolist()),
        float(states.t[state]),
        entry=names[part : part + 1],
        tolerance=tolerance,
    )


def _jacobian(pose: Jet) -> Array:
    """The Jacobian of a pose, shape (n, 6, nv): velocity of its origin, then δR Rᵀ as a vector."""
    value, varied = pose.c[0, 0], pose.c[0, 1:]
    spin = varied[..., :3, :3] @ np.swapaxes(value[..., :3, :3], -1, -2)
    turns = [spin[..., 2, 1], spin[..., 0, 2], spin[..., 1, 0]]
    columns = np.stack([*np.moveaxis(varied[..., :3, 3], -1, 0), *turns])
    return np.moveaxis(columns, 2, 0)


@final
class ClosedForm:
    """The series of a symbolic derivation, evaluated at n states at once."""

    def __init__(self, mechanism: Mechanism, derivation: Derivation) -> None:
        self._mechanism = mechanism
        self._derivation = derivation

    def mass_matrix(self, q: Given, t: Any = 0.0) -> Array:
        """Return M, shape (n, nv, nv); q (n, nq), t () or (n,)."""
        size = self._mechanism.nv
        entries = self._evaluate([m for row in self._derivation.M for m in row], q, None, t)
        return entries.reshape(len(entries), size, size)

    def bias(self, q: Given, v: Given, t: Any = 0.0) -> Array:
        """Return h, shape (n, nv); q (n, nq), v (n, nv), t () or (n,)."""
        return self._evaluate(self._derivation.h, q, v, t)

    def forces(self, q: Given, v: Given, t: Any = 0.0) -> Array:
        """Return Q, shape (n, nv); q (n, nq), v (n, nv), t () or (n,)."""
        return self._evaluate(self._derivation.Q, q, v, t)

    def acceleration(self, q: Given, v: Given, t: Any = 0.0) -> Array:
        """Return the solution a of M a + h = Q + Σ λ ∂Φ/∂q and Φ'' = 0, shape (n, nv)."""
        # NaN where there is none
        mass = self.mass_matrix(q, t)
        rest = self.forces(q, v, t) - self.bias(q, v, t)
        if self._derivation.ties:
            return self._hold(mass, rest, q, v, t)
        try:
            return np.asarray(np.linalg.solve(mass, rest[..., None])[..., 0])
        except np.linalg.LinAlgError:
            return np.full(rest.shape, np.nan)

    def _hold(self, mass: Array, rest: Array, q: Given, v: Given, t: Any) -> Array:
        """Return the accelerations that the loops leave, by the least multipliers."""
        algebra, ties = self._derivation.algebra, self._derivation.ties
        # Φ'' = J a + γ
        second = [tie.second.linear(algebra.accelerations) for tie in ties]
        J = self._evaluate([entry for row, _ in second for entry in row], q, v, t)
        gamma = self._evaluate([gamma for _, gamma in second], q, v, t)
        J = J.reshape(*gamma.shape, mass.shape[-1])
        angular = angles(self._mechanism)
        length = characteristic_length(self._mechanism)
        units = np.array(
            [1.0 if name in angular else length for name in self._mechanism.velocities]
        )
        if self._derivation.quasi:
            return self._reduce(mass, rest, J, gamma, units, q, t)
        rows = RowUnits(np.ones(len(ties)), np.arange(len(ties)))
        held = np.full(rest.shape, np.nan)
        known = np.isfinite(J).all(axis=(1, 2)) & np.isfinite(gamma).all(axis=1)
        for k in np.flatnonzero(known):
            motion = solve_held(mass[k], rest[k], J[k], gamma[k], units, rows)
            held[k] = motion.acceleration
        return held

    def _reduce(
        self,
        mass: Array,
        rest: Array,
        J: Array,
        gamma: Array,
        units: Array,
        q: Given,
        t: Any,
    ) -> Array:
        """Return the accelerations by the equations along independent displacements."""
        quasi = self._derivation.quasi
        S = self._evaluate([entry for column in quasi for entry in column], q, None, t)
        S = S.reshape(len(S), len(quasi), mass.shape[-1])
        rows = np.concatenate([S @ mass, J], axis=1)
        sides = np.concatenate([(S @ rest[..., None])[..., 0], -gamma], axis=1)
        reduced = []
        for matrix, side in zip(rows, sides, strict=True):
            columns = matrix * units
            sizes = np.abs(columns).max(axis=1, keepdims=True)
            sizes[sizes == 0] = 1.0
            rows_alike, sides_alike = columns / sizes, side / sizes[:, 0]
            y = np.linalg.lstsq(rows_alike, sides_alike, rcond=None)[0]
            # once more, for what is left: terms of very different sizes lose digits
            y += np.linalg.lstsq(rows_alike, sides_alike - rows_alike @ y, rcond=None)[0]
            reduced.append(units * y)
        return np.array(reduced)

    def energy(self, q: Given, v: Given, t: Any = 0.0) -> tuple[Array, ...]:
        """Return T and V, each shape (n,) [J], none if not stated; q (n, nq), v (n, nv)."""
        return tuple(self._evaluate(self._derivation.energies, q, v, t).T)

    def _evaluate(self, series: Sequence[Series], q: Given, v: Given, t: Any) -> Array:
        states = States.of(self._mechanism, q, v, t)
        with np.errstate(all="ignore"):
            value = Evaluation(self._derivation.algebra.ring, states.values)
            columns = [np.broadcast_to(value(entry), (len(states),)) for entry in series]
        return np.stack(columns, axis=-1).astype(float) if columns else np.zeros((len(states), 0))


_BUDGET = 3_600
"""Number of states times nv² that the jets are asked for."""

_READABLE = 12
"""Mechanisms with more velocities than this are not derived in closed form: it would fill books."""


@final
@dataclass(frozen=True)
class InHouse:
    """The in-house derivation of one mechanism."""

    forms: dict[str, DynamicsSource]
    assumptions: tuple[Assumption, ...] = ()  # what the closed form takes for granted
    notes: tuple[str, ...] = ()  # what was left out, and why


def derive_all(mechanism: Mechanism) -> InHouse:
    """Derive the equations of a mechanism in every form that can treat it."""
    symbols = derive(mechanism)
    forms: dict[str, DynamicsSource] = {
        "jets": _jets(mechanism),
        "recursion": symbols,
        "Newton-Euler": derive(mechanism, "newton_euler"),
        "virtual work": derive(mechanism, "virtual_work"),
    }
    if mechanism.nv > _READABLE:
        note = f"left out: the closed form, made for at most {_READABLE} velocities"
        return InHouse(forms, notes=(note,))
    if not symbols.symbolic:
        return InHouse(forms, notes=(f"left out: the closed form ({symbols.why_not})",))
    forms["closed form"] = ClosedForm(mechanism, symbols.derivation)
    if mechanism.loops:
        for name in ("Newton-Euler", "virtual work"):
            form = forms[name]
            if isinstance(form, Equations) and form.symbolic:
                forms[f"{name}, closed form"] = ClosedForm(mechanism, form.derivation)
    return InHouse(forms, symbols.derivation.assumptions)


def derive_quickly(mechanism: Mechanism) -> InHouse:
    """Derive the equations by the definition, on jets, and by the fast recursion alone."""
    return InHouse({"jets": _jets(mechanism), "recursion": derive(mechanism)})


def joint_reactions(source: Equations | Reference, mechanism: Mechanism, states: States) -> Array:
    """Return the reactions of all joints as one vector, shape (n, 6 · joints)."""
    # the total of each joint, with what guides across it, then forces of elements; moments are
    # divided by the characteristic length
    wrenches = source.totals(states.q, states.v, states.t)
    length = characteristic_length(mechanism)
    parts: list[Array] = [np.zeros((len(states), 0))]
    for joint in mechanism.joints:
        wrench = wrenches.get(joint.name)
        if wrench is None:
            parts.append(np.full((len(states), 6), np.nan))
        else:
            parts += [np.asarray(wrench.force), np.asarray(wrench.moment) / length]
    if mechanism.elements:
        forces = source.guide_forces(states.q, states.v, states.t)
        parts += [np.nan_to_num(np.asarray(force))[:, None] for force in forces.values()]
    return np.concatenate(parts, axis=1)


def shared_reactions(engine: Reference, states: States) -> Array:
    """Return which components redundant contacts leave undetermined, shape (n, 6 · joints)."""
    closed, count = engine.closed, len(engine.mechanism.joints)
    assert closed is not None, "the mechanism has contacts"
    parts = [
        closed.undetermined(q, t)[:count].reshape(-1)
        for q, t in zip(states.q, states.t.tolist(), strict=True)
    ]
    return np.array(parts)


def contact_forces(source: DynamicsSource, engine: Reference, states: States) -> Array:
    """Return the forces of all contacts at n states, by row; those undetermined are zero."""
    assert isinstance(source, (Equations, Reference))
    mechanism, closed = engine.mechanism, engine.closed
    assert closed is not None, "the mechanism has contacts"
    multipliers = source.multipliers(states.q, states.v, states.t)
    of_contacts = np.array([name in row_names(mechanism.contacts) for name in multipliers])
    columns = np.stack(list(multipliers.values()), axis=-1)
    determined = [
        closed.solve(q, v, t).determined
        for q, v, t in zip(states.q, states.v, states.t.tolist(), strict=True)
    ]
    kept: Array = np.where(determined, columns, 0.0)[:, of_contacts]
    return kept


def independent_accelerations(
    mechanism: Mechanism, states: States
) -> tuple[dict[str, Array], tuple[str, ...]]:
    """Return the accelerations from equations in independent coordinates, and what was left out."""
    try:
        reduced = Reduced(mechanism)
    except DerivationError as error:
        return {}, (f"left out: the equations in independent coordinates ({error})",)
    return {"acceleration": reduced.acceleration(states)}, ()


def regularity(mechanism: Mechanism, states: States) -> Array:
    """Return how regular the choice of independent coordinates is in each state, shape (n,)."""
    return np.asarray(Reduced(mechanism).regularity(states))


def is_light(name: str, mechanism: Mechanism) -> bool:
    """Return whether a form's mass matrix would take too long and is left out."""
    return name == "jets" and mechanism.nv > _READABLE


def _jets(mechanism: Mechanism) -> Equations:
    title = "Lagrange's operator on jets"
    return Equations(mechanism, "definition", title, LagrangeOnJets(mechanism), _no_symbols)


def _no_symbols() -> Derivation:
    raise DerivationError("Lagrange's operator on jets gives numbers only")


_INDEPENDENT = "independent coordinates"

_IDLE = 1e-13
"""Eigenvalues of the scaled mass matrix below this belong to motions without mass."""

_PART = 1e-6
"""Components of a motion below this part of its largest are rounding errors."""


@final
@dataclass(frozen=True)
class Answers:
    """What the forms of the in-house derivation and the engine answer at n states."""

    engine: dict[str, Array]  # the engine's values
    # values of each form, by name; of an expensive one at the first states only
    forms: dict[str, dict[str, Array]]
    notes: tuple[str, ...] = ()  # what was left out, and why
    # how far the loops are open, in characteristic lengths, shape (n,)
    opening: Array = field(default_factory=lambda: np.zeros(0))
    # asks a form, or the engine, by name at other states
    again: Callable[[str, States], dict[str, Array]] | None = None

    def rows(
        self, mechanism: Mechanism, states: States, tolerance: float | None = None
    ) -> tuple[Row, ...]:
        """Compare every form with the engine, quantity by quantity."""
        usual = rounding(mechanism, states, self.engine)
        entries = entry_rounding(mechanism, states)
        rows: list[Row] = []
        for name, ours in self.forms.items():
            most = usual
            if name == _INDEPENDENT:
                most = in_independent_coordinates(usual, regularity(mechanism, states))
            count = min(map(len, ours.values()), default=0)
            some = states.at(np.arange(count))
            judged = partial(
                rows_of,
                (name, engine_name()),
                ours,
                {quantity: values[:count] for quantity, values in self.engine.items()},
                some,
                mechanism,
                entries=entries,
                tolerance=tolerance,
            )
            compared = judged(rounding=most)
            if any(not (row.agrees or row.by_entry) for row in compared):
                noise = self._measure_noise(name, some)
                louder = {
                    quantity: np.maximum(bound[:count], noise.get(quantity, 0.0))
                    for quantity, bound in most.items()
                }
                compared = judged(rounding=louder)
            rows += compared
        return tuple(rows)

    def _measure_noise(self, name: str, states: States) -> dict[str, Array]:
        """Return the noise of a form and of the engine together, by quantity, shape (n,) each."""
        if self.again is None:
            return {}
        together: dict[str, Array] = {}
        for source in (name, engine_name()):
            mass, opening = (x[: len(states)] for x in (self.engine["mass matrix"], self.opening))
            noise = measure_noise(partial(self.again, source), mass, states, opening)
            for quantity, bound in noise.items():
                together[quantity] = together.get(quantity, 0.0) + bound
        return together


def ask(
    ours: InHouse,
    engine: Reference,
    mechanism: Mechanism,
    states: States,
    *,
    reactions: bool = True,
    budget: bool = True,
    progress: Callable[[str, float], None] | None = None,
) -> Answers:
    """Evaluate every form and the engine at the same states."""
    idle = None if mechanism.constrained else engine.massless
    notes, moves = ours.notes, idle is None
    if idle is not None:
        idle_ones = _idle(engine, states)
        remark = "left out: accelerations and reactions, which nothing determines"
        verb = "moves" if len(idle_ones) == 1 else "move"
        notes = (*notes, f"{remark}: {', '.join(idle_ones)} {verb} no mass")
    tell = progress or (lambda _name, _done: None)
    tell(engine_name(), 0.0)
    theirs = evaluate(engine, states, accelerations=moves)
    answers: dict[str, dict[str, Array]] = {}
    count = len(states)
    for k, (name, form) in enumerate(ours.forms.items(), 1):
        tell(name, k / (len(ours.forms) + 2))
        most = max(3, _BUDGET // max(mechanism.nv, 1) ** 2) if budget and name == "jets" else count
        some = states.at(np.arange(min(most, count)))
        light = is_light(name, mechanism)
        if len(some) < count:
            without = ", without the mass matrix" if light else ""
            notes = (
                *notes,
                f"{name}: at the first {say_count(len(some), 'state')} only{without}, "
                "their cost grows with the cube of the size",
            )
        answers[name] = evaluate(form, some, light=light, accelerations=moves)
    if mechanism.loops and not mechanism.rolls:
        answers[_INDEPENDENT], remarks = independent_accelerations(mechanism, states)
        notes = (*notes, *remarks)
    tell("reactions and rounding", 1 - 1 / (len(ours.forms) + 2))
    if reactions and mechanism.contacts:
        theirs["contact forces"] = contact_forces(engine, engine, states)
        for name in ("recursion", "Newton-Euler"):
            touching = contact_forces(ours.forms[name], engine, states)
            answers[name]["contact forces"] = touching
    if reactions and moves and not (mechanism.loops or mechanism.velocity_constraints):
        balances = ours.forms["Newton-Euler"]
        assert isinstance(balances, Equations)
        shared = shared_reactions(engine, states) if mechanism.contacts else None
        for source, values in ((balances, answers["Newton-Euler"]), (engine, theirs)):
            parts = [joint_reactions(source, mechanism, states)]
            if shared is not None:
                parts[0][:, : shared.shape[1]][shared] = 0.0
            # reactions are judged against the contact forces that they balance
            parts += [values["contact forces"]] if mechanism.contacts else []
            values["reactions"] = np.concatenate(parts, axis=1)

    def ask_again(name: str, others: States) -> dict[str, Array]:
        if name == _INDEPENDENT:
            return independent_accelerations(mechanism, others)[0]
        source = engine if name == engine_name() else ours.forms[name]
        light = is_light(name, mechanism)
        return evaluate(source, others, light=light, accelerations=moves)

    opening = np.zeros(len(states))
    if mechanism.constrained:
        gaps = np.abs(engine.constraint_residual(states.q, states.t))
        opening = gaps.max(axis=1, initial=0.0) / characteristic_length(mechanism)
    return Answers(theirs, answers, notes, opening, ask_again)


def _idle(engine: Reference, states: States) -> list[str]:
    """Return the velocities that take part in motions without mass; refuse if all motions are."""
    mass = np.mean(engine.mass_matrix(states.q, states.t), axis=0)
    mechanism, velocities = engine.mechanism, engine.mechanism.velocities
    if not mass.any():
        moving = (body for body in mechanism.bodies if body.name != mechanism.ground)
        if any(mechanism.evaluate(body.mass) for body in moving):
            raise EngineError(
                f"mechanism {mechanism.name!r}: its bodies have mass, but none resists a change of "
                f"{', '.join(velocities)}: centers of mass lie on the axes, about which the "
                "moments of inertia are zero; give them inertia"
            )
        raise EngineError(
            f"mechanism {mechanism.name!r}: nothing that moves has mass, so it has geometry but no "
            f"equations of motion; {WAY_OUT}"
        )
    size = scales(mass[None])[0]
    values, vectors = np.linalg.eigh(mass / np.outer(size, size))
    parts = np.abs(vectors[:, np.abs(values) < _IDLE]).max(axis=1, initial=0.0)
    return [name for name, part in zip(velocities, parts, strict=True) if part > _PART]


_USUAL = ("pinocchio",)
"""Engines that read a mechanism's file themselves in any case."""

_EXPLAINED = 12
"""The most states at which a disagreement is explained."""


@one_thread_for_loops
def verify(
    mechanism: Mechanism,
    samples: int | None = None,
    seed: int = 0,
    *,
    against: Counterpart | None = None,
    header: str | os.PathLike[str] | None = None,
    tolerance: float | None = None,
    engines: Sequence[str] = (),
    progress: Callable[[str, float], None] | None = None,
) -> Verdict:
    """Compare the equations of motion derived in-house with another source at random states.

    Compared are the mass matrix, the bias, gravity, the generalized forces, inverse dynamics, the
    acceleration, the energies and the momenta: each form of the in-house derivation (Lagrange's
    equations by jets, by a recursion and in closed form, Newton and Euler's balances, virtual work)
    against Pinocchio, which gets the mechanism as URDF text only; the reactions in all joints, and
    the forces of all contacts. Of what rolls, Lagrange's equations have multipliers, Newton and
    Euler's balances unknown forces, and virtual work independent quasi-velocities.
    Where they disagree, the verdict ranks likely causes. Of elements that switch every mode is
    compared, its accelerations and its forces; of what has no mass the kinematics alone: poses,
    Jacobians and loops.

    Args:
        mechanism: what to verify.
        samples: number of random states, at least 1; 100 when left out, fewer of a mechanism with
            more than 60 velocities, whose states cost the square of their number.
        seed: of the random states; the same seed gives the same states and the same verdict.
        against: another source instead of Pinocchio: a mechanism; the path of a URDF file;
            functions by name, e.g. `{"M": …, "C": …, "g": …}`
            (`mecanique.verification.foreign.Functions`; equations in the independent
            velocities of what rolls are taken too), also of JAX, CasADi, ctypes and cffi, or one
            that is called after what it gives; the path of a CSV file with states and
            forces, whose states are then used
            (`mecanique.verification.foreign.read_samples`); the path of an FMU
            (extra `fmpy`), or of a shared library with functions as `generate` writes them. The
            last two are programs, and are run: give none that you do not trust.
        header: of the shared library, the C header that declares its functions.
        tolerance: largest relative difference that counts as agreement. When left out, each entry
            of the mass matrix, and of bias and gravity, may differ by what rounding may make of it
            (`mecanique.verification.rounding`), everything else, and another
            source, by 1e-9. Where rounding alone explains more, it may differ by so much; the
            verdict says so.
        engines: those that read the file itself as well as Pinocchio, if the mechanism was read
            from one, with their own parsers: "mujoco", "drake", "exudyn" (extra `engines`). Where
            the mass matrix or bias of one differs, the verdict says why, and does not agree; of
            three sources or more it names those that read otherwise than most.
        progress: called with what is compared next and the fraction done.

    Returns:
        What agrees and what does not.

    Raises:
        InputError: if `samples` or `seed` is not a whole number in its range, the tolerance is not
            a positive number, or the other source is of no known kind.
        MecaniqueError: if a source cannot treat the mechanism at all.

    Example:
        >>> mq.verify(mq.textbook.load('rigid_bar_pendulum'), samples=5).agrees
        True
    """
    if tolerance is not None and not 0 < tolerance < math.inf:
        raise InputError(f"expected a positive, finite tolerance, got {tolerance!r}")
    if samples is None:
        samples = usual_samples(mechanism)
    if against is not None:
        from mecanique.verification.against import compare_with

        mechanism.refuse_switching(
            "its modes are compared with Pinocchio alone, not with another source"
        )
        return compare_with(mechanism, against, samples, seed, tolerance or SOLVED_ALIKE, header)
    if mechanism.switching:
        from mecanique.verification.modes import compare_modes

        return compare_modes(mechanism, samples, seed, tolerance)
    if has_mass(mechanism) or not mechanism.nv:  # what is held fast has no kinematics to compare
        verdict = compare(mechanism, samples, seed, tolerance=tolerance, progress=progress)
        explained = verdict if verdict.agrees else _explain(verdict, mechanism)
    else:
        explained = compare_kinematics(mechanism, samples, seed, tolerance or SOLVED_ALIKE)
    if mechanism.origin is None and not engines:
        return explained  # nothing was read from a file
    from mecanique.verification.engines import read_by

    usual = _USUAL if mechanism.origin is None or mechanism.origin.form == "URDF" else ()
    everyone = list(dict.fromkeys((*usual, *engines)))
    return replace(explained, readings=read_by(mechanism, everyone, seed))


def compare(
    mechanism: Mechanism,
    samples: int,
    seed: int,
    *,
    quick: bool = False,
    tolerance: float | None = None,
    progress: Callable[[str, float], None] | None = None,
) -> Verdict:
    """Compare every form of the in-house derivation with the engine, without looking for causes."""
    engine = Reference.of(mechanism)  # first, as it declines at once what is too large for it
    ours = derive_quickly(mechanism) if quick else derive_all(mechanism)
    states = random_states(mechanism, samples, seed, ours.assumptions)
    answers = ask(ours, engine, mechanism, states, reactions=not quick, progress=progress)
    return judge(mechanism, answers, states, seed, tolerance)


def judge(
    mechanism: Mechanism,
    answers: Answers,
    states: States,
    seed: int,
    tolerance: float | None = None,
) -> Verdict:
    """Return the verdict on what all sources answer."""
    rows = answers.rows(mechanism, states, tolerance)
    ordered = sorted(rows, key=lambda row: QUANTITIES.index(row.quantity))
    return conclude(
        mechanism, ordered, len(states), seed, tolerance or SOLVED_ALIKE, notes=answers.notes
    )


def _explain(verdict: Verdict, mechanism: Mechanism) -> Verdict:
    """Add the likely causes of a disagreement with the engine."""
    states = random_states(mechanism, min(verdict.samples, _EXPLAINED), verdict.seed)
    from mecanique.verification.causes.search import causes_of

    theirs = evaluate(Reference.of(mechanism), states, accelerations=False)
    return verdict.with_causes(causes_of(mechanism, states, theirs))
