"""What decides a mode in one state: mass, load, and a row for each direction that may be held.

The rows of contacts are those of the mechanism in which every contact is closed and sticks, as the
engine gives them; the rows of joints are the gradients of their coordinates.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import NamedTuple, TypeAlias, final

import numpy as np
import numpy.typing as npt

from mecanique.arrays import Array
from mecanique.errors import InputError
from mecanique.model.constraints.contacts import Rolling
from mecanique.model.constraints.friction import Contact, Friction, Stop, Switching
from mecanique.model.expression import Scalar, compile_scalars, coordinate
from mecanique.model.joint_base import Single
from mecanique.model.mechanism import Mechanism
from mecanique.motion.record.rates import Rates

Flags: TypeAlias = npt.NDArray[np.bool_]

IDLE = 1e-12
"""Rows of contacts below this in every sampled state are those of a direction nothing moves in."""


class Terms(NamedTuple):
    """M a = load + Jᵀ λ with J a + γ = 0 in one state, and what the elements have there."""

    mass: Array  # shape (nv, nv)
    load: Array  # shape (nv,), forces − bias
    jacobian: Array  # shape (m, nv)
    gamma: Array  # shape (m,)
    gaps: Array  # shape (m,), zero in rows of velocities alone
    rates: Array  # shape (m,), J v + drift
    drift: Array  # shape (m,)
    kinetic: Array  # shape (elements,), μ, or the kinetic force where the load is stated
    static: Array  # shape (elements,), the same of static friction


@final
@dataclass(frozen=True)
class ElementRows:
    """Which rows an element has."""

    element: Switching
    normal: int | None  # its row of the gap; None if it only rubs
    tangents: tuple[int, ...]  # its rows along which it rubs
    restitution: float = 0.0
    stiffness: float | None = None  # of an elastic stop

    @property
    def name(self) -> str:
        """Name of the element."""
        return self.element.name


@final
class Rows:
    """The rows of a mechanism with elements that switch."""

    def __init__(self, mechanism: Mechanism) -> None:
        from mecanique.reference.loops.loading import load_once

        self.mechanism = mechanism
        self.base = replace(mechanism, switching=())
        closed = tuple(e.closed for e in mechanism.switching if isinstance(e, Contact))
        # kept alive, as what is loaded for it is
        self._whole = replace(self.base, contacts=(*self.base.contacts, *closed))
        self._tree, self._closed = load_once(self._whole)
        self.rates = Rates.of(self.base)
        self._bodies = [body.name for body in self.base.bodies]
        names = list(self._closed.closures.names) if self._closed is not None else []
        own = {f"{contact.name}: {row}" for contact in closed for row in contact.rows}
        self.permanent = [k for k, name in enumerate(names) if name not in own]
        """Rows that hold in every mode."""
        self._positional: Flags = np.zeros(len(names), dtype=bool)
        if self._closed is not None:
            self._positional = np.array(self._closed.closures.positional, dtype=bool)
        self._from_engine = len(names)
        self._in_joints = [e for e in mechanism.switching if not isinstance(e, Contact)]
        self._measure_joints = self._compile_joints()
        self._measure_friction = self._compile_friction()
        self.elements = self._assign(names)

    def _assign(self, names: list[str]) -> tuple[ElementRows, ...]:
        idle = self._find_idle()
        elements: list[ElementRows] = []
        for element in self.mechanism.switching:
            if isinstance(element, Contact):
                tangents = [names.index(f"{element.name}: {row}") for row in ("x", "y")]
                elements.append(
                    ElementRows(
                        element,
                        names.index(f"{element.name}: normal"),
                        tuple(k for k in tangents if element.rubs and not idle[k]),
                        self.mechanism.evaluate(element.restitution),
                    )
                )
                continue
            row = self._from_engine + self._in_joints.index(element)
            if isinstance(element, Friction):
                elements.append(ElementRows(element, None, (row,)))
                continue
            stiffness = element.stiffness
            elements.append(
                ElementRows(
                    element,
                    row,
                    (),
                    self.mechanism.evaluate(element.restitution),
                    None if stiffness is None else self.mechanism.evaluate(stiffness),
                )
            )
        return tuple(elements)

    def _find_idle(self) -> Flags:
        """Return which of the engine's rows no motion changes in sampled states."""
        if self._closed is None:
            return np.zeros(0, dtype=bool)
        from mecanique.reference.engine.tree import random_states

        largest = np.zeros(self._from_engine)
        for q, v, t in random_states(self._whole):
            with np.errstate(all="ignore"):  # balls may be anywhere around each other
                jacobian = self._closed.closures.at(q, v, t).jacobian
            largest = np.fmax(largest, np.abs(jacobian).max(axis=1))
        return np.asarray(largest < IDLE)

    @property
    def positional(self) -> Flags:
        """Whether a row is the rate of a gap, shape (m,)."""
        stops = [isinstance(element, Stop) for element in self._in_joints]
        return np.concatenate([self._positional, np.array(stops, dtype=bool)])

    def _names(self) -> list[str]:
        m = self.base
        signals = [signal.symbol for signal in m.inputs]
        return [*m.coordinates, *m.velocities, "t", *m.values, *signals]

    def _call(self, scalars: list[Scalar]) -> Callable[[Array, Array, float], Array]:
        """Return scalars as a function of q, v and t."""
        values = self.base.values
        constants = list(values.values())
        signals = [signal.function(values) for signal in self.base.inputs]
        function = compile_scalars(scalars, self._names())

        def call(q: Array, v: Array, t: float) -> Array:
            inputs = [signal(t) for signal in signals]
            return np.array(function(*q.tolist(), *v.tolist(), t, *constants, *inputs))

        return call

    def _compile_joints(self) -> Callable[[Array, Array, float], Array]:
        """Return the function that gives gap, ∂/∂q, ∂/∂t and γ of each joint's row."""
        from sympy import Symbol, diff, sympify

        m = self.base
        moving = {f"{name}'" for name in m.coordinates} & {*m.velocities}
        scalars: list[Scalar] = []
        for element in self._in_joints:
            joint = m.joint(element.joint)
            assert isinstance(joint, Single), "validated"
            place = sympify(
                m.coordinates.driven.get(joint.coordinate, coordinate(joint.coordinate))
            )
            if isinstance(element, Stop):
                place = element.side * (element.at - place)
                speed: Scalar = 0
            else:
                speed = element.speed
            names = [name for name in m.coordinates if Symbol(name) in place.free_symbols]
            for name in names:
                if f"{name}'" not in moving:
                    raise InputError(
                        f"{element.name!r}: its joint follows {name!r}, part of a quaternion, "
                        "which elements that switch do not treat; put it into another joint"
                    )
            slopes = [diff(place, Symbol(name)) for name in m.coordinates]
            by_t = diff(place, Symbol("t"))
            rate = by_t - speed
            for name, slope in zip(m.coordinates, slopes, strict=True):
                if slope != 0:
                    rate += slope * Symbol(f"{name}'")
            gamma = diff(rate, Symbol("t"))
            for name in names:
                gamma += diff(rate, Symbol(name)) * Symbol(f"{name}'")
            gap = place if isinstance(element, Stop) else 0
            scalars += [gap, *slopes, by_t - speed, gamma]
        return self._call([sympify(scalar) for scalar in scalars])

    def _compile_friction(self) -> Callable[[Array, Array, float], Array]:
        scalars: list[Scalar] = []
        for element in self.mechanism.switching:
            if isinstance(element, Friction):
                scalars += [element.mu * element.load, element.holding * element.load]
            elif isinstance(element, Contact):
                scalars += [element.mu, element.holding]
            else:
                scalars += [0.0, 0.0]
        return self._call(scalars)

    def at(self, q: Array, v: Array, t: float) -> Terms:
        """Return the terms in a state."""
        mass = np.array(self._tree.mass(q, v, t))
        load = self._tree.forces(q, v, t) - self._tree.bias(q, v, t)
        nq, nv = len(q), len(v)
        values = self._measure_joints(q, v, t).reshape(-1, nq + 3)
        slopes = values[:, 1 : 1 + nq]
        jacobian = slopes
        if not self.rates.trivial:
            jacobian = slopes @ self.rates.first(np.repeat(q[None], nv, axis=0), np.eye(nv)).T
        drift, gamma, gaps = values[:, -2], values[:, -1], values[:, 0]
        if self._closed is not None:
            closure = self._closed.closures.at(q, v, t)
            jacobian = np.concatenate([closure.jacobian, jacobian])
            gamma = np.concatenate([closure.gamma, gamma])
            gaps = np.concatenate([closure.residual, gaps])
            drift = np.concatenate([closure.drift, drift])
        friction = self._measure_friction(q, v, t).reshape(-1, 2)
        return Terms(
            mass=mass,
            load=load,
            jacobian=jacobian,
            gamma=gamma,
            gaps=gaps,
            rates=jacobian @ v + drift,
            drift=drift,
            kinetic=friction[:, 0],
            static=friction[:, 1],
        )

    def contact_wrenches(self, q: Array, t: float, forces: Array) -> dict[tuple[str, str], Array]:
        """Return the force of each contact on a body and its moment about the body's origin.

        By contact and body, each of shape (6,), world axes.
        """
        assert self._closed is not None, "there are contacts"
        v = np.zeros(self.base.nv)
        self._closed.closures.at(q, v, t)
        pull, moment, place = self._closed.closures.wrenches(forces[: self._from_engine])
        poses = self._tree.poses(q, v, t)
        wrenches: dict[tuple[str, str], Array] = {}
        parts = (*self._whole.loops, *self._whole.contacts)
        for k, part in enumerate(parts):
            if not isinstance(part, Rolling):
                continue
            for body, sign in ((part.body, 1.0), (part.on, -1.0)):
                origin = poses[self._bodies.index(body), :3, 3]
                turned = moment[k] + np.cross(place[k] - origin, pull[k])
                wrenches[part.name, body] = sign * np.concatenate([pull[k], turned])
        return wrenches
