"""What decides a mode in one state: mass, load, and a row for each direction that may be held.

The rows of contacts are those of the mechanism in which every contact is closed and sticks, as the
engine gives them; the rows of joints are the gradients of their coordinates.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import final

import numpy as np

from mecanique.arrays import Array, Flags
from mecanique.derivation.mechanics.letters import Letters
from mecanique.derivation.mechanics.switching import (
    Terms,
    close_contacts,
    find_inside,
    joint_terms,
    list_elements,
)
from mecanique.model.constraints.contacts import Rolling
from mecanique.model.constraints.friction import Contact
from mecanique.model.mechanism import Mechanism
from mecanique.motion.compile.program import RatesProgram
from mecanique.motion.compile.python import list_values
from mecanique.motion.record.rates import Rates
from mecanique.motion.tolerances import IDLE
from mecanique.program.tape import Value
from mecanique.program.traced import values_of


@final
class SwitchingRows:
    """The rows of a mechanism with elements that switch."""

    def __init__(self, mechanism: Mechanism) -> None:
        from mecanique.reference.engine.tree import refuse_massless
        from mecanique.reference.loops.closed import load_once

        self.mechanism = mechanism
        self.base = replace(mechanism, switching=())
        self.whole = close_contacts(mechanism)  # kept alive, as what is loaded for it is
        self._tree, self._closed = load_once(self.whole)
        if self._tree.massless is not None:
            refuse_massless(mechanism, self._tree.massless)
        self.rates = Rates.of(self.base)
        self._bodies = [body.name for body in self.base.bodies]
        names = list(self._closed.closures.names) if self._closed is not None else []
        known = self.base.contacts
        closed = [contact for contact in self.whole.contacts if contact not in known]
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
        idle = np.flatnonzero(self._find_idle()).tolist()
        self.idle = {names[k] for k in idle}
        """Names of the rows that no motion changes."""
        self.elements = list_elements(mechanism, names, mechanism.evaluate, idle)

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

    def _compile(self) -> Callable[[float, Array], tuple[float, ...]]:
        """Return the function that gives gap, drift, γ and slopes of each joint's row, and μ."""
        terms = joint_terms(self.mechanism, self.letters)
        parts = (terms.gaps, terms.drift, terms.gamma, terms.jacobian, terms.kinetic, terms.static)
        values = values_of(np.concatenate([part.ravel() for part in parts]))
        return list_values(self.program(()), values)

    def program(self, rates: Sequence[Value]) -> RatesProgram:
        """Return values on the tape as a program."""
        return RatesProgram(
            self.whole, self.letters.tape, tuple(rates), (), tuple(self.letters.signals)
        )

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
        feet: dict[str, float] = {}
        if self._closed is not None:
            closure = self._closed.closures.at(q, v, t)
            jacobian = np.concatenate([closure.jacobian, jacobian])
            gamma = np.concatenate([closure.gamma, gamma])
            gaps = np.concatenate([closure.residual, gaps])
            drift = np.concatenate([closure.drift, drift])
            names = (contact.name for contact in self.whole.contacts)
            feet = dict(zip(names, self._closed.closures.contacts.feet.tolist(), strict=True))
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
            inside=np.array(find_inside(self.elements, feet, gaps)),
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
