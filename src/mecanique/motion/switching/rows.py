"""What decides a mode in one state: mass, load, and a row for each direction that may be held.

The rows of contacts are those of the mechanism in which every contact is closed and sticks, as the
engine gives them; the rows of joints are the gradients of their coordinates.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple, TypeAlias, final

import numpy as np
import numpy.typing as npt

from mecanique.arrays import Array
from mecanique.derivation.mechanics.letters import Letters
from mecanique.errors import InputError
from mecanique.model.constraint_base import JointRow
from mecanique.model.constraints.contacts import Rolling
from mecanique.model.constraints.friction import Contact, Switching
from mecanique.model.expression import Scalar, coordinate, symbols_in
from mecanique.model.joint_base import Single
from mecanique.model.mechanism import Mechanism
from mecanique.motion.compile.program import Program
from mecanique.motion.compile.python import list_values
from mecanique.motion.record.rates import Rates
from mecanique.motion.tolerances import IDLE
from mecanique.program.sweeps import push_forward
from mecanique.program.tape import Value
from mecanique.program.traced import trace, values_of

Flags: TypeAlias = npt.NDArray[np.bool_]


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


def as_scalars(scalars: Sequence[Any]) -> npt.NDArray[Any]:
    """Return scalars on a tape as an array of objects."""
    return np.array(scalars, dtype=object)


@final
@dataclass(frozen=True)
class ElementRows:
    """Which rows an element has."""

    element: Switching
    normal: int | None  # its row of the gap; None if it only rubs
    tangents: tuple[int, ...]  # its rows along which it rubs
    pressing: int | None = None  # the row whose force its friction goes by
    restitution: float = 0.0
    stiffness: float | None = None  # of an elastic stop
    holds: float = 0.0  # the pull that a latch keeps

    @property
    def name(self) -> str:
        """Name of the element."""
        return self.element.name


@final
class SwitchingRows:
    """The rows of a mechanism with elements that switch."""

    def __init__(self, mechanism: Mechanism) -> None:
        from mecanique.reference.loops.loading import load_once

        self.mechanism = mechanism
        self.base = replace(mechanism, switching=())
        closed = tuple(e.closed for e in mechanism.switching if isinstance(e, Contact))
        # kept alive, as what is loaded for it is
        self.whole = replace(self.base, contacts=(*self.base.contacts, *closed))
        self._tree, self._closed = load_once(self.whole)
        self.rates = Rates.of(self.base)
        self._bodies = [body.name for body in self.base.bodies]
        names = list(self._closed.closures.names) if self._closed is not None else []
        of_contacts = {f"{contact.name}: {row}" for contact in closed for row in contact.rows}
        self.permanent = [k for k, name in enumerate(names) if name not in of_contacts]
        """Rows that hold in every mode."""
        self._positional: Flags = np.zeros(len(names), dtype=bool)
        if self._closed is not None:
            self._positional = np.array(self._closed.closures.positional, dtype=bool)
        self._from_engine = len(names)
        self._in_joints = [row for e in mechanism.switching for row in e.joint_rows]
        self.letters = Letters(self.whole)
        self._measure = self._compile()
        self.names = names
        """Of the rows of the engine; those of the elements in joints come after them."""
        self.elements = self._assign(names)

    def _assign(self, names: list[str]) -> tuple[ElementRows, ...]:
        idle = self._find_idle()
        elements: list[ElementRows] = []
        first = self._from_engine
        for element in self.mechanism.switching:
            if isinstance(element, Contact):
                tangents = [names.index(f"{element.name}: {row}") for row in ("x", "y")]
                elements.append(
                    ElementRows(
                        element,
                        names.index(f"{element.name}: normal"),
                        tuple(k for k in tangents if element.rubs and not idle[k]),
                        restitution=self.mechanism.evaluate(element.restitution),
                    )
                )
                continue
            presses = [row.offset is not None for row in element.joint_rows]
            rows = range(first, first + len(presses))
            first = rows.stop
            normal = next((row for row, so in zip(rows, presses, strict=True) if so), None)
            tangents = [row for row, so in zip(rows, presses, strict=True) if not so]
            given = [getattr(element, name, None) for name in ("restitution", "stiffness", "holds")]
            restitution, stiffness, holds = (
                None if value is None else self.mechanism.evaluate(value) for value in given
            )
            elements.append(
                ElementRows(
                    element,
                    normal,
                    tuple(tangents),
                    restitution=restitution or 0.0,
                    stiffness=stiffness,
                    holds=holds or 0.0,
                )
            )
        normals = {element.name: element.normal for element in elements}
        return tuple(
            replace(rows, pressing=normals[rows.element.pressed_by])
            if rows.element.pressed_by is not None
            else rows
            for rows in elements
        )

    def _find_idle(self) -> Flags:
        """Return which of the engine's rows no motion changes in sampled states."""
        if self._closed is None:
            return np.zeros(0, dtype=bool)
        from mecanique.reference.engine.tree import random_states

        largest = np.zeros(self._from_engine)
        for q, v, t in random_states(self.whole):
            with np.errstate(all="ignore"):  # balls may be anywhere around each other
                jacobian = self._closed.closures.at(q, v, t).jacobian
            largest = np.fmax(largest, np.abs(jacobian).max(axis=1))
        return np.asarray(largest < IDLE)

    @property
    def positional(self) -> Flags:
        """Whether a row is the rate of a gap, shape (m,)."""
        stops = [row.offset is not None for row in self._in_joints]
        return np.concatenate([self._positional, np.array(stops, dtype=bool)])

    def on_tape(self) -> Terms:
        """Return the terms of the elements in joints as scalars on the tape of the letters.

        Mass and load are left out, and so are the rows of contacts.
        """
        letters, nv = self.letters, self.base.nv
        gaps, slopes, drifts, rates, gammas = [list[Any]() for _ in range(5)]
        for joint_row in self._in_joints:
            place = letters.number(self._place_of(joint_row), letters.values)
            speed = letters.number(joint_row.speed, letters.values)
            (rate,) = letters.along([place])
            (gamma,) = letters.along([rate - speed])
            by_letters = [{letters.t.place: 1.0}, *({q.place: 1.0} for q in letters.q)]
            by_t, *by_q = [self._slope(place, direction) for direction in by_letters]
            row = [0.0] * nv
            for name, slope in zip(self.base.coordinates, by_q, strict=True):
                if f"{name}'" in self.base.velocities:
                    row[self.base.velocities.index(f"{name}'")] = slope
            gaps.append(0.0 if joint_row.offset is None else place)
            slopes.append(row)
            drifts.append(by_t - speed)
            rates.append(rate - speed)
            gammas.append(gamma)
        kinetic, static = [list[Any]() for _ in range(2)]
        for switching in self.mechanism.switching:
            for numbers, scalar in zip((kinetic, static), switching.coefficients, strict=True):
                numbers.append(letters.number(scalar, letters.values))
        return Terms(
            mass=as_scalars([]),
            load=as_scalars([]),
            jacobian=as_scalars(slopes).reshape(-1, nv),
            gamma=as_scalars(gammas),
            gaps=as_scalars(gaps),
            rates=as_scalars(rates),
            drift=as_scalars(drifts),
            kinetic=as_scalars(kinetic),
            static=as_scalars(static),
        )

    def _slope(self, scalar: Any, direction: dict[int, Value]) -> Any:
        tape = self.letters.tape
        (slope,) = push_forward(tape, values_of([scalar]), direction)
        return trace(tape, slope)

    def _place_of(self, row: JointRow) -> Scalar:
        """Return the gap of a row of joints, or the way that it rubs, in the coordinates."""
        m = self.base
        whole: Any = row.offset or 0.0
        for name, weight in row.weights:
            joint = m.joint(name)
            assert isinstance(joint, Single), "validated"
            place: Any = m.coordinates.driven.get(joint.coordinate, coordinate(joint.coordinate))
            for symbol in symbols_in(place):
                if symbol in m.coordinates and f"{symbol}'" not in m.velocities:
                    raise InputError(
                        f"joint {name!r} follows {symbol!r}, part of a quaternion, which elements "
                        "that switch do not treat; put them into another joint"
                    )
            whole = whole + weight * place
        return whole

    def _compile(self) -> Callable[[float, Array], tuple[float, ...]]:
        """Return the function that gives gap, drift, γ and slopes of each joint's row, and μ."""
        terms = self.on_tape()
        parts = (terms.gaps, terms.drift, terms.gamma, terms.jacobian, terms.kinetic, terms.static)
        values = values_of(np.concatenate([part.ravel() for part in parts]))
        return list_values(self.program(()), values)

    def program(self, rates: Sequence[Value]) -> Program:
        """Return values on the tape as a program."""
        return Program(self.whole, self.letters.tape, tuple(rates), (), tuple(self.letters.signals))

    def at(self, q: Array, v: Array, t: float) -> Terms:
        """Return the terms in a state."""
        mass = np.array(self._tree.mass(q, v, t))
        load = self._tree.forces(q, v, t) - self._tree.bias(q, v, t)
        nv, joints = len(v), len(self._in_joints)
        values = np.array(self._measure(t, np.concatenate([q, v])))
        gaps, drift, gamma = values[: 3 * joints].reshape(3, joints)
        end = (3 + nv) * joints
        jacobian = values[3 * joints : end].reshape(joints, nv)
        kinetic, static = values[end:].reshape(2, -1)
        if self._closed is not None:
            closure = self._closed.closures.at(q, v, t)
            jacobian = np.concatenate([closure.jacobian, jacobian])
            gamma = np.concatenate([closure.gamma, gamma])
            gaps = np.concatenate([closure.residual, gaps])
            drift = np.concatenate([closure.drift, drift])
        return Terms(
            mass=mass,
            load=load,
            jacobian=jacobian,
            gamma=gamma,
            gaps=gaps,
            rates=jacobian @ v + drift,
            drift=drift,
            kinetic=kinetic,
            static=static,
        )

    def contact_wrenches(
        self, q: Array, t: float, forces: Array
    ) -> dict[tuple[str, str, str], Array]:
        """Return normal force and friction of each contact on its bodies, with their moments.

        By contact, body and "normal" or "friction", each of shape (6,), world axes; moments are
        about the contact's center in the first body and the origin of the other.
        """
        assert self._closed is not None, "there are contacts"
        v = np.zeros(self.base.nv)
        closures = self._closed.closures
        closures.at(q, v, t)
        poses = self._tree.poses(q, v, t)
        normal = np.zeros(self._from_engine, dtype=bool)
        for element in self.elements:
            if isinstance(element.element, Contact):
                normal[element.normal] = True
        wrenches: dict[tuple[str, str, str], Array] = {}
        parts = (*self.whole.loops, *self.whole.contacts)
        for kind, rows in (("normal", normal), ("friction", ~normal)):
            pull, moment, place = closures.wrenches(forces[: self._from_engine] * rows)
            for k, part in enumerate(parts):
                if not isinstance(part, Rolling):
                    continue
                center = self.base.evaluate_all(part.center)
                for body, at, sign in ((part.body, center, 1.0), (part.on, (0, 0, 0), -1.0)):
                    about = (poses[self._bodies.index(body)] @ [*at, 1.0])[:3]
                    turned = moment[k] + np.cross(place[k] - about, pull[k])
                    wrenches[part.name, body, kind] = sign * np.concatenate([pull[k], turned])
        return wrenches
