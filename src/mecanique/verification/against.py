"""Compare a mechanism with another description, a user's functions or measured samples."""

from __future__ import annotations

import os
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any, NamedTuple, TypeAlias, final

import numpy as np

from mecanique.arrays import Array
from mecanique.derivation import derive
from mecanique.derivation.numeric.constraints.rows import Held
from mecanique.errors import DerivationError, InputError
from mecanique.formats.read import read
from mecanique.model.mechanism import Mechanism
from mecanique.model.mechanism.letters import find_name
from mecanique.model.states import States
from mecanique.verification.causes.search import causes_of
from mecanique.verification.diff import diff
from mecanique.verification.foreign import (
    LIBRARIES,
    TAKES,
    Functions,
    ask_fmu,
    ask_in_child,
    ask_library,
    quantity_of,
    read_samples,
)
from mecanique.verification.rounding import rounding
from mecanique.verification.rows import QUANTITIES, evaluate, rows_of
from mecanique.verification.states import random_states
from mecanique.verification.stencil import differences
from mecanique.verification.verdict import Difference, LikelyCause, Verdict, conclude
from mecanique.wording import say_count

_STEP = 1e-2
"""Of the differences along each independent velocity."""

_SAME = 1e-6
"""Relative difference up to which a bias is that of a Lagrangian with the constraint in it."""


class _Tree(NamedTuple):
    """M, h and forces of the tree with S and c, at n states."""

    M: Array
    h: Array
    Q: Array
    g: Array
    S: Array
    c: Array


@final
class ReducedEquations:
    """The equations of a mechanism in independent velocities w: v = S w, SᵀM(S w' + c).

    A derivation that puts constraints on velocities into T before Lagrange's operator, which is
    wrong, has the right mass matrix SᵀMS and another bias: that of the Lagrangian T(q, S w) − V
    (Neimark & Fufaev, Dynamics of Nonholonomic Systems, 1972, ch. III, sect. 1).
    """

    def __init__(self, mechanism: Mechanism, by: tuple[str, ...]) -> None:
        if not mechanism.rolls:
            raise InputError(
                f"mechanism {mechanism.name!r} has no contacts or velocity constraints; expected "
                "functions of all its velocities, without 'by'"
            )
        if mechanism.quaternions:
            raise InputError(
                f"joint {mechanism.quaternions[0][0]!r} turns by a quaternion; describe it by "
                "three hinges to compare equations in some of the velocities"
            )
        known = [name.removesuffix("'") for name in mechanism.velocities if name.endswith("'")]
        by = tuple(find_name(mechanism, typed, known) for typed in by)
        self._mechanism = mechanism
        self._equations, self._held = derive(mechanism), Held(mechanism)
        self._at = [mechanism.velocities.index(f"{name}'") for name in by]

    def values(self, states: States) -> dict[str, Array]:
        """Return mass matrix, bias and forces in the independent velocities, by quantity."""
        tree = self._tree(states)
        moved = np.einsum("nij,nj->ni", tree.M, tree.c) + tree.h
        return {
            "mass matrix": self._mass(tree),
            "bias": np.einsum("nij,ni->nj", tree.S, moved),
            "forces": np.einsum("nij,ni->nj", tree.S, tree.Q),
        }

    def substitute(self, states: States) -> Array:
        """Return the bias of Lagrange's operator on T(q, S w) − V, shape (n, N)."""
        tree = self._tree(states)
        w = states.v[:, self._at]
        forces: Array = np.einsum("nij,ni->nj", tree.S, tree.g)
        for k in range(len(states)):
            along = tree.S[k]

            def mass(steps: Array, k: int = k, along: Array = along) -> Array:
                state = states.at(np.full(len(steps), k))
                there = replace(state, q=state.q + steps @ along.T)
                flat: Array = self._mass(self._tree(there)).reshape(len(steps), -1)
                return flat

            n = len(self._at)
            slopes = differences(mass, n, _STEP).reshape(n, n, n)  # ∂M_ij/∂q_b
            forces[k] += np.einsum("ijb,b,j->i", slopes, w[k], w[k])
            forces[k] -= np.einsum("ijb,i,j->b", slopes, w[k], w[k]) / 2
        return forces

    def _mass(self, tree: _Tree) -> Array:
        mass: Array = np.einsum("nij,nik,nkl->njl", tree.S, tree.M, tree.S)
        return mass

    def _tree(self, states: States) -> _Tree:
        equations, held = self._equations, self._held.at(states)
        still = np.zeros_like(states.v)
        n, nv = states.v.shape
        S, c = np.zeros((n, nv, len(self._at))), np.zeros((n, nv))
        rest = [k for k in range(nv) if k not in self._at]
        for k, (J, gamma) in enumerate(zip(held.jacobian, held.gamma, strict=True)):
            given = np.column_stack([J[:, self._at], gamma])
            solution, _, rank, _ = np.linalg.lstsq(J[:, rest], -given, rcond=1e-9)
            if rank < len(rest):
                names = ", ".join(self._mechanism.velocities[i] for i in self._at)
                raise InputError(f"the velocities {names} do not determine the others")
            S[k, self._at], S[k, rest] = np.eye(len(self._at)), solution[:, :-1]
            c[k, rest] = solution[:, -1]
        q, v, t = states.q, states.v, states.t
        return _Tree(
            M=np.asarray(equations.mass_matrix(q, t)),
            h=np.asarray(equations.bias(q, v, t)),
            Q=np.asarray(equations.forces(q, v, t)),
            g=np.asarray(equations.bias(q, still, t)),
            S=S,
            c=c,
        )


def blame_substitution(
    reduced: ReducedEquations, states: States, ours: dict[str, Array], theirs: dict[str, Array]
) -> tuple[LikelyCause, ...]:
    """Return the cause that the constraint was put into T, if that explains a bias."""
    if "bias" not in theirs:
        return ()
    wrong = reduced.substitute(states)
    size = float(np.linalg.norm(theirs["bias"])) or 1.0
    before, after = (
        float(np.linalg.norm(theirs["bias"] - bias)) / size for bias in (ours["bias"], wrong)
    )
    if not (after <= _SAME < before):
        return ()
    text = (
        "the constraint on velocities was put into T before Lagrange's operator; it belongs beside "
        "it, with multipliers (Q + Jᵀ λ), or the equations are projected afterwards"
    )
    return (LikelyCause("constraint put into T", "", text, before, after),)


Counterpart: TypeAlias = (
    "Mechanism | Functions | Mapping[str, Callable[..., Any]] | Callable[..., Any] | str | "
    "os.PathLike[str]"
)
"""Another mechanism, functions, one function, or the path of a URDF file, of a CSV file with
samples, of an FMU or of a shared library."""

_BY_VELOCITY = ("mass matrix", "bias", "gravity", "forces", "inverse dynamics", "acceleration")
"""Quantities with one entry, or row, for each velocity."""


def compare_with(
    mechanism: Mechanism,
    against: Counterpart,
    samples: int,
    seed: int,
    tolerance: float,
    header: str | os.PathLike[str] | None = None,
) -> Verdict:
    """Compare a mechanism with another source and, where they differ, rank the likely causes."""
    ending = os.path.splitext(against)[1].lower() if isinstance(against, (str, os.PathLike)) else ""
    if header is not None and ending not in LIBRARIES:
        raise InputError("expected a shared library with a header")
    if isinstance(against, (str, os.PathLike)):
        source = _ask_file(mechanism, against, samples, seed, header)
    elif isinstance(against, Mechanism):
        source = _ask_mechanism(mechanism, against, random_states(mechanism, samples, seed))
    else:
        states, functions = random_states(mechanism, samples, seed), _functions(against)
        if functions.by:
            return _compare_some(mechanism, functions, states, (seed, tolerance))
        source = _Source("functions", states, functions.values(mechanism, states))
    return _judge(mechanism, source, seed, tolerance)


class _Source(NamedTuple):
    """Another source and what it gives."""

    name: str
    states: States  # where it was asked
    values: Mapping[str, Array]
    notes: tuple[str, ...] = ()  # how its coordinates were matched
    given: str = ""  # name of the file with its samples; empty if it was asked at random states
    difference: Difference | None = None  # of a description, what differs in it


def _ask_file(
    mechanism: Mechanism,
    path: str | os.PathLike[str],
    samples: int,
    seed: int,
    header: str | os.PathLike[str] | None,
) -> _Source:
    """Ask an FMU, a shared library, a URDF file, or take the samples of a CSV file."""
    name = os.path.basename(os.fspath(path))
    ending = os.path.splitext(path)[1].lower()
    if not ("<" in os.fspath(path) or ending in {".fmu", ".urdf", ".xml", *LIBRARIES}):
        states, tau = read_samples(path, mechanism)
        return _Source(name, states, {"inverse dynamics": tau}, given=name)
    states = random_states(mechanism, samples, seed)
    if ending == ".fmu":
        return _Source(name, states, ask_fmu(path, mechanism, states))
    if ending in LIBRARIES:
        given = (path, header, mechanism, states)
        return _Source(name, states, ask_in_child(name, ask_library, *given))
    return _ask_mechanism(mechanism, read(path), states)


def _ask_mechanism(mechanism: Mechanism, theirs: Mechanism, states: States) -> _Source:
    """Ask another mechanism, and say what differs in its description."""
    name = theirs.name if theirs.name != mechanism.name else f"other {theirs.name}"
    values, notes = _of_mechanism(mechanism, theirs, states)
    difference = diff(mechanism, theirs)
    return _Source(name, states, values, notes, difference=None if difference.same else difference)


def _judge(mechanism: Mechanism, source: _Source, seed: int, tolerance: float) -> Verdict:
    """Return the verdict on a source, with the likely causes where it differs."""
    states, theirs = source.states, source.values
    ours, undetermined = _evaluate(mechanism, states, light="acceleration" not in theirs)
    shared = {
        quantity: ours[quantity]
        for quantity in QUANTITIES
        if quantity in theirs and quantity in ours
    }
    scale = theirs if "mass matrix" in theirs else {**theirs, "mass matrix": ours["mass matrix"]}
    rows = rows_of(
        ("recursion", source.name),
        shared,
        scale,
        states,
        mechanism,
        rounding=rounding(mechanism, states, ours),
        tolerance=tolerance,
    )
    notes = tuple(dict.fromkeys((*source.notes, *undetermined)))
    verdict = replace(
        conclude(mechanism, rows, len(states), seed, tolerance, notes=notes),
        given=source.given,
        difference=source.difference,
    )
    return verdict if verdict.agrees else verdict.with_causes(causes_of(mechanism, states, theirs))


def _functions(
    given: Functions | Mapping[str, Callable[..., Any]] | Callable[..., Any],
) -> Functions:
    """Functions by quantity; the quantity of a single one is its name."""
    if isinstance(given, Functions):
        return given
    if isinstance(given, Mapping):
        return Functions.of(given)
    if not callable(given):
        raise InputError(
            f"expected a mechanism, functions or a path to compare with, got {type(given).__name__}"
        )
    name = getattr(given, "__name__", "")
    if callable(getattr(given, "name_in", None)):
        name = getattr(given, "name", str)()  # CasADi's
    quantity = quantity_of(name)
    if not quantity:
        raise InputError(
            f"expected a function called after what it gives ({', '.join(TAKES)}), got {name!r}; "
            f"say what it gives: against={{'acceleration': function}}"
        )
    return Functions.of({quantity: given})


def _compare_some(
    mechanism: Mechanism, functions: Functions, states: States, how: tuple[int, float]
) -> Verdict:
    """Compare equations that have some velocities of what rolls left."""
    seed, tolerance = how
    reduced = ReducedEquations(mechanism, tuple(functions.by))
    ours, theirs = reduced.values(states), functions.values(mechanism, states)
    shared = {name: ours[name] for name in QUANTITIES if name in ours and name in theirs}
    names = ("projected", "functions")
    rows = rows_of(names, shared, {**ours, **theirs}, states, mechanism, tolerance=tolerance)
    verdict = conclude(mechanism, rows, len(states), seed, tolerance)
    if verdict.agrees:
        return verdict
    return verdict.with_causes(blame_substitution(reduced, states, ours, theirs))


def _of_mechanism(
    mechanism: Mechanism, second: Mechanism, states: States
) -> tuple[dict[str, Array], tuple[str, ...]]:
    """Values of another mechanism in our order of coordinates, and how they were matched."""
    notes: tuple[str, ...] = ()
    ours, theirs = ((tuple(side.coordinates), side.velocities) for side in (mechanism, second))
    if (len(ours[0]), len(ours[1])) != (len(theirs[0]), len(theirs[1])):
        alone = [
            f"{', '.join(sorted(set(a[0]) - set(b[0])))}" or "none"
            for a, b in ((ours, theirs), (theirs, ours))
        ]
        raise InputError(
            f"expected {say_count(len(ours[0]), 'coordinate')} as in {mechanism.name!r}, "
            f"got {len(theirs[0])} in {second.name!r}; only the first has {alone[0]}; "
            f"only the second has {alone[1]}; a joint that one side lets follow another "
            "(mimic) or holds fixed is free on the other"
        )
    at_q, at_v = np.arange(len(ours[0])), np.arange(len(ours[1]))
    if set(ours[0]) == set(theirs[0]) and set(ours[1]) == set(theirs[1]):
        at_q, at_v = (
            np.array(list(map(a.index, names)), dtype=int)
            for a, names in zip(ours, theirs, strict=True)
        )
    elif ours != theirs:
        notes = ("the coordinates have different names and are matched in their order",)
    moved = States.of(second, states.q[:, at_q], states.v[:, at_v], states.t, states.a[:, at_v])
    values, undetermined = _evaluate(second, moved, light=bool(mechanism.loops or second.loops))
    back = np.argsort(at_v)
    for quantity in values.keys() & set(_BY_VELOCITY):
        values[quantity] = values[quantity][:, back]
    values["mass matrix"] = values["mass matrix"][:, :, back]
    return values, (*notes, *undetermined)


def _evaluate(
    mechanism: Mechanism, states: States, *, light: bool
) -> tuple[dict[str, Array], tuple[str, ...]]:
    """Return the values of the equations, without accelerations that nothing determines; a note."""
    equations, notes = derive(mechanism), list[str]()
    try:
        values = evaluate(equations, states, light=light)
    except DerivationError:
        values = evaluate(equations, states, accelerations=False)
        notes.append(f"left out: accelerations, as a mass matrix of {mechanism.name!r} is singular")
    if "mass matrix" not in values:
        values["mass matrix"] = equations.mass_matrix(states.q, states.t)
    return values, tuple(notes)
