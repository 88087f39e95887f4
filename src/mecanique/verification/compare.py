"""Compare the in-house derivation of a mechanism with the engine, or with another source."""

from __future__ import annotations

import math
import os
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from mecanique.arrays import Array
from mecanique.errors import InputError
from mecanique.model.mechanism import Mechanism
from mecanique.model.states import States
from mecanique.reference import Reference
from mecanique.threads import one_thread_for_loops
from mecanique.verification import derivations
from mecanique.verification.answers import Answers, ask
from mecanique.verification.difference import QUANTITIES
from mecanique.verification.states.random import random_states, usual_samples
from mecanique.verification.verdict import TOLERANCE, Verdict, conclude

if TYPE_CHECKING:
    from mecanique.verification.against import Other


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
    against: Other | None = None,
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
    Where they disagree, the verdict ranks likely causes.

    Args:
        mechanism: what to verify.
        samples: number of random states, at least 1; 100 when left out, fewer of a mechanism with
            more than 60 velocities, whose states cost the square of their number.
        seed: of the random states; the same seed gives the same states and the same verdict.
        against: another source instead of Pinocchio: a mechanism; the path of a URDF file;
            functions by name, e.g. `{"M": …, "C": …, "g": …}`
            (`mecanique.verification.foreign.functions.Functions`; equations in the independent
            velocities of what rolls are taken too), also of JAX, CasADi, ctypes and cffi, or one
            that is called after what it gives; the path of a CSV file with states and
            forces, whose states are then used
            (`mecanique.verification.foreign.functions.read_samples`); the path of an FMU
            (extra `fmpy`), or of a shared library with functions as `generate` writes them. The
            last two are programs, and are run: give none that you do not trust.
        header: of the shared library, the C header that declares its functions.
        tolerance: largest relative difference that counts as agreement. When left out, each entry
            of the mass matrix, and of bias and gravity, may differ by what rounding may make of it
            (`mecanique.verification.rounding.contributions`), everything else, and another
            source, by 1e-9. Where rounding alone explains more, it may differ by so much; the
            verdict says so.
        engines: those that read the file itself as well as Pinocchio, if the mechanism was read
            from one, with their own parsers: "mujoco", "drake" (extra `engines`). Where the mass
            matrix or bias of one differs, the verdict says why, and does not agree.
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

        return compare_with(mechanism, against, samples, seed, tolerance or TOLERANCE, header)
    verdict = compare(mechanism, samples, seed, tolerance=tolerance, progress=progress)
    found = verdict if verdict.agrees else _explain(verdict, mechanism)
    if mechanism.origin is None and not engines:
        return found  # nothing was read from a file
    from mecanique.verification.originals.engines import read_by

    everyone = list(dict.fromkeys((*_USUAL, *engines)))
    return replace(found, readings=read_by(mechanism, everyone, seed))


def compare(
    mechanism: Mechanism,
    samples: int,
    seed: int,
    *,
    quick: bool = False,
    tolerance: float | None = None,
    progress: Callable[[str, float], None] | None = None,
) -> Verdict:
    """Compare every form of the in-house derivation with the engine, without looking for causes.

    Args:
        mechanism: what to verify.
        samples: number of random states.
        seed: of the random states.
        quick: whether only the jets and the recursion take part, and no reactions.
        tolerance: largest relative difference that counts as agreement wherever rounding explains
            less; None for the usual one, and none of single entries.
        progress: called with what is compared next and the fraction done.
    """
    engine = Reference.of(mechanism)  # first, as it declines at once what is too large for it
    ours = derivations.derive_quickly(mechanism) if quick else derivations.derive_all(mechanism)
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
    """Return the verdict on what all sources answer.

    Args:
        mechanism: whose answers they are.
        answers: of all sources.
        states: where they were asked.
        seed: of the states.
        tolerance: largest relative difference that counts as agreement wherever rounding explains
            less; None for the usual one, and none of single entries.
    """
    rows = answers.rows(mechanism, states, tolerance)
    ordered = sorted(rows, key=lambda row: QUANTITIES.index(row.quantity))
    return conclude(
        mechanism, ordered, len(states), seed, tolerance or TOLERANCE, notes=answers.notes
    )


def _explain(verdict: Verdict, mechanism: Mechanism) -> Verdict:
    """Add the likely causes of a disagreement with the engine."""
    states = random_states(mechanism, min(verdict.samples, _EXPLAINED), verdict.seed)
    from mecanique.verification.causes.search import causes_of

    return verdict.with_causes(causes_of(mechanism, states, _dynamics(mechanism, states)))


def _dynamics(mechanism: Mechanism, states: States) -> dict[str, Array]:
    engine = Reference.of(mechanism)
    return {
        "mass matrix": engine.mass_matrix(states.q, states.t),
        "bias": engine.bias(states.q, states.v, states.t),
        "gravity": engine.gravity(states.q, states.t),
        "forces": engine.forces(states.q, states.v, states.t),
    }
