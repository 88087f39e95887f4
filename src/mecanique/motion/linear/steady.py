"""Small deviations from steady motions: of what rolls, of tops, of loops.

What rolls has fewer independent velocities w than independent positions q, so that its linear
equations are of first order, x' = A x with x = (δq, δw); those of δw are M δw' + C δw + K δq = 0
(Neimark & Fufaev, Dynamics of Nonholonomic Systems, 1972, ch. VI). A motion is steady if only
cyclic coordinates change, those that no acceleration and no rate depends on, e.g. the place of a
bicycle and the turns of its wheels, or the spin of a top (Routh, Advanced Rigid Dynamics, 1905, ch.
III).

Deviations by a quaternion's velocities turn with the body, so that a steady motion is none in them.
A body that turns steadily about an axis e of its own while that axis goes round a fixed axis p has
the angular velocity Ω p + σ e; described by hinges about p, about the normal to both and about e,
its angles change at the constant rates Ω, 0 and σ (E. J. Routh, Advanced Rigid Dynamics, 1905, ch.
III). In the body's axes that is ω' = −σ e × ω, by which e and σ are found.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, NamedTuple, final

import numpy as np

from mecanique.arrays import Array
from mecanique.errors import InputError, MechanismError
from mecanique.model.bodies import Body
from mecanique.model.bodies.tensor import tensor_of
from mecanique.model.constraint_base import PressingContact
from mecanique.model.joints import Floating, Joint, Prismatic, Revolute, Spherical
from mecanique.model.mechanism import Mechanism
from mecanique.model.placement import Placement, rpy_of
from mecanique.model.quaternions import to_matrices
from mecanique.model.values import Given
from mecanique.motion.linear.differences import slopes
from mecanique.motion.linear.free_motions import free_near
from mecanique.motion.record.loops import begin_on_loops
from mecanique.motion.tolerances import (
    ALIKE,
    CONSTANT,
    LEAST_SPIN,
    NO_ENTRY,
    SMALLEST_ANGLE,
    STABLE,
    STEADY,
)
from mecanique.threads import one_thread_for_loops

if TYPE_CHECKING:
    from mecanique.reference import Reference

_KINDS = ("precession", "nutation", "spin")
"""What a hinge's angle is called, by its place."""


@final
@dataclass(frozen=True)
class Hinged:
    """A mechanism without quaternions, in a state."""

    mechanism: Mechanism  # its joints that turned by quaternions are slides and hinges
    position: dict[str, float]  # of each coordinate, by name
    velocity: dict[str, float]  # of each velocity, by name


@final
@dataclass(frozen=True)
class _Turning:
    """How a body turns, next to a state."""

    outer: Array  # unit vector of the axis that stays where it is, in the joint's frame
    outer_rate: float  # about it [rad/s]
    inner: Array  # unit vector of the body's own axis, in the body's frame
    inner_rate: float  # about it [rad/s]


def put_hinges(mechanism: Mechanism, q: Array, v: Array, a: Array) -> Hinged:
    """Return a mechanism with hinges in place of its quaternions, in the same state."""
    bodies, joints = list(mechanism.bodies), list[Joint]()
    place = dict(zip(mechanism.coordinates, q.tolist(), strict=True))
    rate = dict(zip(mechanism.velocities, v.tolist(), strict=True))
    second = dict(zip(mechanism.velocities, a.tolist(), strict=True))
    for joint in mechanism.joints:
        if not isinstance(joint, Spherical | Floating):
            joints.append(joint)
            continue
        position, turns = joint.names[:-4], joint.velocities[-3:]
        attitude = to_matrices(np.array([place.pop(name) for name in joint.names[-4:]]))
        w = np.array([rate.pop(name) for name in turns])
        turning = _split(mechanism, joint, attitude, w, np.array([second[name] for name in turns]))
        chain = list(_chain(joint, attitude, turning))
        if position:
            moved = attitude @ [rate.pop(k) for k in joint.velocities[:3]]
            rate |= {f"{name}'": float(x) for name, x in zip(position, moved, strict=True)}
        speeds = (turning.outer_rate, 0.0, turning.inner_rate)
        for hinge, speed in zip(chain[-3:], speeds, strict=True):
            place[hinge.coordinate], rate[f"{hinge.coordinate}'"] = 0.0, speed
        joints += chain
        bodies += [Body(hinge.child) for hinge in chain[:-1]]
    quaternions = {name for j in mechanism.joints if j.quaternion for name in j.coordinates}
    coordinates = replace(
        mechanism.coordinates,
        names=tuple(name for name in mechanism.coordinates if name not in quaternions),
    )
    try:
        hinged = replace(
            mechanism, bodies=tuple(bodies), joints=tuple(joints), coordinates=coordinates
        )
    except MechanismError as error:
        name = mechanism.quaternions[0][0]
        raise InputError(
            f"joint {name!r} turns by a quaternion that cannot be replaced by hinges here: "
            f"{'; '.join(error.faults)}; describe it by three hinges"
        ) from error
    return Hinged(hinged, place, rate)


def _chain(
    joint: Spherical | Floating, attitude: Array, turning: _Turning
) -> Iterator[Prismatic | Revolute]:
    """The slides and hinges in a joint's place."""
    inner = attitude @ turning.inner
    normal = np.cross(turning.outer, inner)
    length = float(np.linalg.norm(normal))
    if length < SMALLEST_ANGLE:
        raise InputError(
            f"the body of joint {joint.name!r} spins about the very axis about which it precesses, "
            "so that the hinges are singular; describe it by hinges about other axes"
        )
    before, origin = joint.parent, joint.origin
    directions = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    for direction, name in zip(directions, joint.names[:-4], strict=False):
        child = f"{name}_led"
        yield Prismatic(
            f"{joint.name}_along_{name}",
            before,
            child,
            origin=origin,
            axis=direction,
            coordinate=name,
        )
        before, origin = child, Placement()
    axes = (turning.outer, normal / length, turning.inner)
    for kind, axis in zip(_KINDS, axes, strict=True):
        name, child = f"{joint.name}_{kind}", f"{joint.name}_{kind}_led"
        if kind == _KINDS[-1]:
            child, origin = joint.child, Placement(rpy=rpy_of(attitude))
        yield Revolute(name, before, child, origin=origin, axis=tuple(axis.tolist()))
        before, origin = child, Placement()


def _split(
    mechanism: Mechanism, joint: Spherical | Floating, attitude: Array, w: Array, rate: Array
) -> _Turning:
    """Take the angular velocity apart: about a fixed axis, and about one of the body's own."""
    speed = float(np.linalg.norm(w))
    axes, round_ = _symmetry(mechanism, joint.child)
    if speed < LEAST_SPIN or np.linalg.norm(rate) <= CONSTANT * speed**2:
        spin_axis = w / speed if speed >= LEAST_SPIN else np.array([0.0, 0.0, 1.0])
        aside = np.cross(spin_axis, np.eye(3)[np.abs(spin_axis).argmin()])
        aside /= np.linalg.norm(aside)
        if round_ or any(np.linalg.norm(np.cross(spin_axis, axis)) < CONSTANT for axis in axes):
            return _Turning(attitude @ aside, 0.0, spin_axis, speed)
        return _Turning(attitude @ spin_axis, speed, aside, 0.0)
    if round_:
        # every axis will do: that of what is left of a turn about the vertical
        fall = attitude.T @ mechanism.evaluate_all(mechanism.gravity)
        axes = [w - _factor(rate, np.cross(fall, w)) * fall]
        axes = [axis / max(float(np.linalg.norm(axis)), LEAST_SPIN) for axis in axes]
    for spin_axis in axes:
        spin = _factor(rate, -np.cross(spin_axis, w))
        outer = attitude @ (w - spin * spin_axis)
        going = float(np.linalg.norm(outer))
        left = np.abs(rate + spin * np.cross(spin_axis, w)).max()
        if left <= CONSTANT * speed**2 and going > LEAST_SPIN:
            return _Turning(outer / going, going, spin_axis, spin)
    change = ", ".join(
        f"{name}' = {x:.3g}" for name, x in zip(joint.velocities[-3:], rate, strict=True)
    )
    raise InputError(
        f"the motion of {mechanism.name!r} is not steady: {change}; expected a "
        f"spin of body {joint.child!r} about an axis of symmetry that precesses at a constant rate"
    )


def _factor(a: Array, b: Array) -> float:
    """The multiple of b nearest to a, by least squares."""
    return float(a @ b) / max(float(b @ b), LEAST_SPIN**2)


def _symmetry(mechanism: Mechanism, name: str) -> tuple[list[Array], bool]:
    """The axes about which a body may be turned without any change, and whether all are."""
    body = mechanism.body(name)
    rolling = [
        contact
        for contact in mechanism.contacts
        if isinstance(contact, PressingContact) and contact.body == name
    ]
    axes = [np.array(wheel.axis) for wheel in rolling if wheel.axis]
    moments, principal = np.linalg.eigh(tensor_of(mechanism.evaluate_all(body.inertia)))
    low, high = np.diff(moments) <= ALIKE * moments[-1]
    center = np.array(mechanism.evaluate_all(body.center))
    if low and high:
        plain = not axes and not any(contact.stretched for contact in rolling)
        return axes, plain and not center.any()
    axes += [principal[:, k] for k, alike in ((2, low), (0, high)) if alike]
    aside = (np.linalg.norm(np.cross(axis, center)) for axis in axes)
    size = max(float(np.linalg.norm(center)), LEAST_SPIN)
    return [axis for axis, off in zip(axes, aside, strict=True) if off <= ALIKE * size], False


@final
@dataclass(frozen=True, repr=False)
class SteadyLinearization:
    """The linear equations x' = A x of deviations x = (δq, δw) from a steady motion.

    Args:
        mechanism: what moves.
        q: shape (nq,), its position.
        v: shape (nv,), its velocities.
        positions: names of the independent coordinates q.
        velocities: names of the independent velocities w.
        A: shape (n, n), n of both together.
        M: shape (nw, nw), the mass matrix that the independent velocities see.
        idle: which deviations nothing depends on, of cyclic coordinates and of kept speeds.
        error: estimate of the error of A, relative to its largest entry.

    Example:
        >>> coin = mq.textbook.load("rolling_coin")
        >>> rolling = {"z": coin.values["r"]}
        >>> slow, fast = (mq.linearize_steady(coin, rolling, {"spin": w}) for w in (1.0, 30.0))
        >>> slow.stable, fast.stable
        (False, True)
    """

    mechanism: Mechanism
    q: np.ndarray
    v: np.ndarray
    positions: tuple[str, ...]
    velocities: tuple[str, ...]
    A: np.ndarray
    M: np.ndarray
    idle: tuple[int, ...]
    error: float

    @property
    def cyclic(self) -> tuple[str, ...]:
        """Names of the coordinates that nothing depends on."""
        return tuple(self.positions[k] for k in self.idle if k < len(self.positions))

    @property
    def C(self) -> np.ndarray:
        """Of M δw' + C δw + K δq = 0, shape (nw, nw)."""
        n = len(self.positions)
        damping: np.ndarray = -self.M @ self.A[n:, n:]
        return damping

    @property
    def K(self) -> np.ndarray:
        """Of the same, shape (nw, nq independent)."""
        n = len(self.positions)
        stiffness: np.ndarray = -self.M @ self.A[n:, :n]
        return stiffness

    def second_order(self, names: Sequence[str]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return M, C and K of some coordinates whose velocities are independent, each (k, k).

        Args:
            names: of the coordinates, e.g. ("roll", "steer") of a bicycle; no other may move with
                them.

        Raises:
            InputError: if one is not independent, or others move with them.
        """
        wanted = [f"{name}'" for name in names]
        if not set(names) <= set(self.positions) or not set(wanted) <= set(self.velocities):
            known = ", ".join(name for name in self.positions if name not in self.cyclic)
            raise InputError(f"expected names among {known}, got {', '.join(names)}")
        place = [self.positions.index(name) for name in names]
        rate = [self.velocities.index(name) for name in wanted]
        others = [k for k in range(len(self.velocities)) if k not in rate]
        free = [k for k, n in enumerate(self.positions) if n not in (*names, *self.cyclic)]
        M, C, K = self.M, self.C, self.K
        size = np.abs(M).max()
        left = [M[np.ix_(rate, others)], C[np.ix_(rate, others)], K[np.ix_(rate, free)]]
        if max(np.abs(part).max(initial=0.0) for part in left) > NO_ENTRY * size:
            raise InputError(f"other coordinates move with {', '.join(names)}")
        pick = np.ix_(rate, rate)
        return M[pick], C[pick], K[np.ix_(rate, place)]

    @cached_property
    def eigenvalues(self) -> np.ndarray:
        """All exponents λ of small deviations e^(λ t), by real part [1/s]."""
        still = np.zeros(len(self.A) - len(self.exponents))
        return by_real_part(np.concatenate([self.exponents, still]))

    @cached_property
    def exponents(self) -> np.ndarray:
        """The exponents without a zero for each deviation that nothing depends on [1/s]."""
        kept = [k for k in range(len(self.A)) if k not in self.idle]
        return by_real_part(np.linalg.eigvals(self.A[np.ix_(kept, kept)]))

    @property
    def stable(self) -> bool:
        """Whether no small deviation grows exponentially."""
        size = np.abs(self.exponents).max(initial=0.0)
        return bool((self.exponents.real <= STABLE * size).all())

    def __repr__(self) -> str:
        kind = "stable" if self.stable else "unstable"
        listed = ", ".join(map(write_exponent, drop_noise(self.exponents)))
        return f"<{kind} steady motion of {self.mechanism.name!r}: λ = {listed or 0}>"


class _Free(NamedTuple):
    """What may deviate from a steady motion, and how fast it then changes."""

    positions: np.ndarray  # which velocities' coordinates are independent, indices
    velocities: np.ndarray  # which velocities are independent, indices
    # (q', w') by deviations (δq, δw), shape (n, count) both
    rates: Callable[[np.ndarray], np.ndarray]
    tangent: np.ndarray  # v by w at the motion itself, shape (nv, nw)


@one_thread_for_loops
def linearize_steady(
    mechanism: Mechanism, at: Given = None, v: Given = None, *, by: Sequence[str] = ()
) -> SteadyLinearization:
    """Linearize the equations of a mechanism about a steady motion.

    Rates and accelerations of the reference are differentiated by central differences of eighth
    order; `error` says how well that worked. A joint that turns by a quaternion is described by
    hinges first, `<joint>_precession`, `_nutation` and `_spin`: about an axis that stays, about the
    normal to both and about an axis of the body.

    Args:
        mechanism: a mechanism that rolls, a tree or one with loops.
        at: positions, shape (nq,) or by name; wheels are put on the ground next to them.
        v: velocities, shape (nv,) or by name; those left out follow.
        by: names of coordinates that are to be independent, and their velocities; by default
            those of hinges.

    Returns:
        The linear equations, with their exponents.

    Raises:
        InputError: if the motion is not steady; the message says what changes.
        ClosureError: if a wheel cannot be put on the ground.
        UnknownNameError: if a coordinate or velocity does not exist.

    Example:
        >>> disk = mq.textbook.load('rolling_coin')
        >>> mq.linearize_steady(disk, {'z': disk.values['r']}, {'spin': 30.0}).stable
        True
    """
    from mecanique.reference.loops.assembly import held_columns

    reference, q, velocity = _begin(mechanism, at, v)
    if mechanism.quaternions:
        hinged = put_hinges(mechanism, q, velocity, reference.acceleration(q, velocity))
        mechanism = hinged.mechanism
        reference, q, velocity = _begin(mechanism, hinged.position, hinged.velocity)
    # turns of hinges stay steady where a body rolls in a circle, slides do not
    turning = [n for j in mechanism.joints for n in j.coordinates if n not in j.linear_coordinates]
    prefer = held_columns(mechanism, by or [n for n in turning if n in mechanism.coordinates])
    free = _release(reference, q, velocity, prefer)
    A, error = slopes(free.rates, len(free.positions) + len(free.velocities))
    positions = tuple(mechanism.velocities[k].removesuffix("'") for k in free.positions)
    velocities = tuple(mechanism.velocities[k] for k in free.velocities)
    idle = _idle(A)
    rates = free.rates(np.zeros((1, len(A))))[0]
    _refuse_changing(mechanism, rates, positions, velocities, idle)
    M = free.tangent.T @ reference.mass_matrix(q) @ free.tangent
    return SteadyLinearization(
        mechanism=mechanism,
        q=q,
        v=velocity,
        positions=positions,
        velocities=velocities,
        A=A,
        M=M,
        idle=idle,
        error=error,
    )


def _begin(mechanism: Mechanism, at: Given, v: Given) -> tuple[Reference, np.ndarray, np.ndarray]:
    """The state, on the constraints."""
    from mecanique.reference import Reference

    reference, state, _ = begin_on_loops(Reference.of(mechanism), at, v, 0.0)
    return reference, state[: mechanism.nq], state[mechanism.nq :]


def _release(reference: Reference, q: np.ndarray, v: np.ndarray, prefer: np.ndarray) -> _Free:
    """The deviations that the constraints leave free, preferred ones first."""
    closed = reference.closed
    place = free_near(reference, q, 0.0, positional=True, prefer=prefer)
    free = free_near(reference, q, 0.0, prefer=prefer)
    n, w = len(place.chosen), v[free.chosen]
    home = place.position(np.zeros(n))

    def rates(step: np.ndarray) -> np.ndarray:
        rows = []
        for x in step:
            there = place.position(x[:n]) if x[:n].any() else home
            moving = free.velocity(there, w + x[n:])
            if closed is None:
                a = reference.acceleration(there, moving)
            else:
                a = closed.solve(there, moving, 0.0).acceleration
            rows.append(np.concatenate([moving[place.chosen], a[free.chosen]]))
        return np.array(rows)

    return _Free(place.chosen, free.chosen, rates, free.tangent)


def _idle(A: np.ndarray) -> tuple[int, ...]:
    """The deviations on which only deviations of the same kind depend."""
    least = NO_ENTRY * float(np.abs(A).max(initial=0.0))
    idle: list[int] = []
    while True:
        rest = [k for k in range(len(A)) if k not in idle]
        more = [k for k in rest if np.abs(A[rest, k]).max(initial=0.0) <= least]
        if not more:
            return tuple(sorted(idle))
        idle += more


def _refuse_changing(
    mechanism: Mechanism,
    rates: np.ndarray,
    positions: tuple[str, ...],
    velocities: tuple[str, ...],
    idle: tuple[int, ...],
) -> None:
    named = [*(f"{name}'" for name in positions), *(f"{name}'" for name in velocities)]
    changing = [
        f"{name} = {rate:.3g}"
        for k, (name, rate) in enumerate(zip(named, rates, strict=True))
        if abs(rate) > STEADY and (k >= len(positions) or k not in idle)
    ]
    if changing:
        raise InputError(
            f"the motion of {mechanism.name!r} is not steady: {', '.join(changing)}; give a state "
            "in which only cyclic coordinates change"
        )


def by_real_part(exponents: np.ndarray) -> np.ndarray:
    """Return exponents in the order of their real parts."""
    ordered: np.ndarray = exponents[np.lexsort((exponents.imag, exponents.real))]
    return ordered


def drop_noise(exponents: np.ndarray) -> np.ndarray:
    """Return the exponents, to be printed, with parts that are noise beside the largest as zero."""
    noise = NO_ENTRY * np.abs(exponents).max(initial=0.0)
    re, im = (np.where(np.abs(x) > noise, x, 0.0) for x in (exponents.real, exponents.imag))
    return re + 1j * im


def write_exponent(exponent: complex) -> str:
    """Return an exponent as text, a real one as such."""
    return f"{exponent:.6g}" if exponent.imag else f"{exponent.real:.6g}"
