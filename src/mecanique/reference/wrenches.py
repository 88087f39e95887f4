"""Compute the forces between bodies: reactions of joints and loops, and applied forces."""

from __future__ import annotations

from dataclasses import replace
from functools import cached_property, partial
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from mecanique.arrays import Array
from mecanique.model.constraints.loops import Loop
from mecanique.model.states import States
from mecanique.model.values import Given
from mecanique.reference.answering import Answering
from mecanique.reference.engine.answers import AppliedForce, Places, Wrench
from mecanique.reference.engine.forces.elements import Guided
from mecanique.reference.loops.closed import COMPONENTS, Closed


class _HeldStates(NamedTuple):
    """The elements' forces in some states, the remaining reactions, and the actions on bodies."""

    forces: Array
    wrenches: dict[str, Wrench]
    actions: Array


class Wrenches(Answering):
    """The methods of a `Reference` about forces and moments between bodies."""

    def reactions(
        self, q: Given, v: Given = None, t: float | Array = 0.0, tau: Given = None
    ) -> dict[str, Wrench]:
        """Return the wrench of each parent on its child, by joint, at the child's origin.

        Components are in world axes.

        Springs, dampers, drives and loads count as external forces on the bodies. A reaction is the
        wrench of the joint itself, without a component along or about a free axis; at a joint with
        prescribed motion it includes the force that moves it. A joint with an armature also
        transmits −armature · r'' along or about its axis, which accelerates the rotor.

        Where the coordinate map couples several joints and no element says how, the components that
        depend on it are NaN; `undetermined` names them, and `reason` says why. `totals` are
        determined there, too.

        After the joints come the loops by name (as "loop …" if a joint has the same name), with the
        wrench of body a on body b, at the origin of the loop's frame on body b. Then come the
        contacts, with the wrench on the rolling body, at its hub (about the point of
        `contact_points` it has no moment), or at the point of a blade. Redundant constraints leave
        components undetermined; these have their least values and are named in `undetermined`.

        Args:
            q: shape (nq,).
            v: shape (nv,).
            t: time [s].
            tau: additional driving forces in joints with one coordinate [N·m or N], as in
                `acceleration`; like the mechanism's own forces not part of a reaction.

        Raises:
            EngineError: if a motion moves no mass in this state, or a loop is open.
            ClosureError: if a motion that the loops allow moves no mass.
            UnknownNameError: if a name in tau is not that of a joint, coordinate or velocity.
            InputError: if tau acts anywhere but in joints with one coordinate.
        """
        states = States.of(self.mechanism, q, v, t, tau=tau)
        wrenches = self._find_totals(states)
        if self.mechanism.elements:
            wrenches |= self._hold(states).wrenches
        if not self._guided.reasons:
            return wrenches
        poses = np.asarray(self._answer(states, self._tree.poses))
        count = len(self.mechanism.bodies)
        flags = self._guided.undetermined(poses.reshape(-1, count, 4, 4))
        return wrenches | {
            joint.name: _forget(wrenches[joint.name], loose, self._guided.reasons[joint.name])
            for joint, loose in zip(self.mechanism.joints, flags, strict=True)
            if loose.any()
        }

    def totals(
        self,
        q: Given,
        v: Given = None,
        t: float | Array = 0.0,
        tau: Given = None,
        *,
        elements: bool = True,
    ) -> dict[str, Wrench]:
        """Return the total wrench across each joint, of its reaction and its guides, by joint.

        It acts on the child and the bodies beyond, at the child's origin, world axes: the resultant
        of the joint's reaction and of the forces from outside that hold this part of the mechanism
        on the coordinate map. Without guides it is the joint's reaction. Loops follow as in
        `reactions`.

        Args:
            q: shape (nq,).
            v: shape (nv,).
            t: time [s].
            tau: additional driving forces, as in `reactions`.
            elements: whether to include the forces of the elements.

        Raises:
            EngineError: if a motion moves no mass in this state, or a loop is open.
            ClosureError: if a motion that the loops allow moves no mass.
            UnknownNameError: if a name in tau is not that of a joint, coordinate or velocity.
            InputError: if tau acts anywhere but in joints with one coordinate.
        """
        states = States.of(self.mechanism, q, v, t, tau=tau)
        totals = self._find_totals(states)
        known = elements or not self.mechanism.elements
        return totals if known else totals | self._hold(states).wrenches

    def guide_forces(
        self, q: Given, v: Given = None, t: float | Array = 0.0, tau: Given = None
    ) -> dict[str, Array]:
        """Return the forces of the guiding elements by name, e.g. tensions of cords [N].

        A force that redundant elements leave undetermined is NaN.

        Args:
            q: shape (nq,).
            v: shape (nv,).
            t: time [s].
            tau: additional driving forces, as in `reactions`.

        Returns:
            Each shape () or (n,) [N or N·m].

        Raises:
            EngineError: if a motion moves no mass in this state, or an element does not fit.
        """
        if not self.mechanism.elements:
            return {}
        held = self._hold(States.of(self.mechanism, q, v, t, tau=tau))
        names = self._tree.elements.names
        return {name: held.forces[..., k] for k, name in enumerate(names)}

    def guide_actions(
        self, q: Given, v: Given = None, t: float | Array = 0.0
    ) -> tuple[AppliedForce, ...]:
        """Return the actions of the guiding elements, force by force, each on both of its bodies.

        Args:
            q: shape (nq,).
            v: shape (nv,).
            t: time [s].
        """
        if not self.mechanism.elements:
            return ()
        states = States.of(self.mechanism, q, v, t)
        parts = self._hold(states).actions
        names, units = self._tree.elements.names, self._tree.elements.units()
        applied: list[AppliedForce] = []
        for k, unit in enumerate(units):
            point, force, moment = np.moveaxis(parts[..., k, :, :], -2, 0)
            if unit.pressed:  # acts at the same point as the force before it
                applied[-1] = replace(applied[-1], force=applied[-1].force + force)
            else:
                name = names[unit.force]
                applied.append(
                    AppliedForce(
                        name=name,
                        body=unit.body,
                        other=unit.other,
                        point=point,
                        force=force,
                        moment=moment,
                    )
                )
        return tuple(applied)

    def contact_points(self, q: Given, t: float | Array = 0.0) -> dict[str, Array]:
        """Return the points of contact of rolling bodies and blades, by contact, world axes [m].

        A contact exerts no moment about this point.

        Args:
            q: shape (nq,).
            t: time [s].

        Returns:
            Each shape (3,) or (n, 3), by the contacts' names in `reactions`.
        """
        if self._closed is None or not self.mechanism.contacts:
            return {}
        contacts = self._closed.closures.contacts

        def function(q: Array, v: Array, t: float) -> Array:
            self._tree.poses(q, v, t)
            return contacts.places()

        points = np.moveaxis(self._answer(States.of(self.mechanism, q, t=t), function), -2, 0)
        return dict(zip(self._carriers[-len(points) :], points, strict=True))

    def _hold(self, states: States) -> _HeldStates:
        """Solve for the elements' forces in each state, and the joints' remaining reactions."""
        joints, tree = len(self.mechanism.joints), self._tree
        count = len(tree.elements.names)
        loose, unknown = np.zeros((joints, 6), dtype=bool), np.zeros(count, dtype=bool)

        def function(q: Array, v: Array, t: float) -> Array:
            if self._closed is None:
                totals = tree.reactions(q, v, t)
            else:
                totals = self._closed.reactions(q, v, t).wrenches[:joints]
            held = tree.hold(q, v, t, totals)
            np.logical_or(loose, held.loose, out=loose)
            np.logical_or(unknown, held.unknown, out=unknown)
            return np.concatenate([part.ravel() for part in held[:2]] + [held.actions.ravel()])

        parts = self._answer(states, function)
        ahead = parts.shape[:-1]
        forces = np.where(unknown, np.nan, parts[..., :count])
        first = count + 6 * joints
        wrenches = parts[..., count:first].reshape(*ahead, joints, 2, 3)
        actions = parts[..., first:].reshape(*ahead, -1, 3, 3)
        return _HeldStates(forces, self._wrenches(states, wrenches, loose), actions)

    @property
    def guided(self) -> dict[str, str]:
        """Why the reaction is undetermined, for each joint with a guide without an element."""
        return dict(self._guided.reasons)

    def _find_totals(self, states: States) -> dict[str, Wrench]:
        if states.efforts is not None:
            states.efforts.refuse_without_seat()
        if not self._carriers:
            return {}
        if self._closed is not None:
            return self._transmit(states, self._closed)
        parts = self._answer(states, self._tree.reactions)
        return self._wrenches(states, parts)

    def undetermined(self, q: Given, t: float = 0.0) -> dict[str, tuple[str, ...]]:
        """Return the components of reactions that are undetermined, by name.

        The cause is redundant constraints, or guides without an element; joints and loops whose
        reactions are fully determined are left out.

        Args:
            q: shape (nq,), one position.
            t: time [s].

        Raises:
            EngineError: if a loop is open.
        """
        states = States.of(self.mechanism, q, t=t)
        flags = np.zeros((len(self._carriers), 6), dtype=bool)
        if self._closed is not None:
            self._closed.refuse_open(states.q[0], float(states.t[0]))
            flags |= self._closed.undetermined(states.q[0], float(states.t[0]))
        if self._guided.reasons:
            poses = self._tree.poses(states.q[0], states.v[0], float(states.t[0]))
            flags[: len(self.mechanism.joints)] |= self._guided.undetermined(poses[None])
        return {
            name: _names_of(row)
            for name, row in zip(self._carriers, flags, strict=True)
            if row.any()
        }

    def applied(
        self, q: Given, v: Given = None, t: float | Array = 0.0
    ) -> tuple[AppliedForce, ...]:
        """Return the actions of springs, dampers, drives and loads on the bodies, force by force.

        A force between two bodies is listed twice: on body a or the child, then on body b or the
        parent. A spring or damper whose ends coincide exerts no force.

        Args:
            q: shape (nq,).
            v: shape (nv,).
            t: time [s].
        """
        effects = self._tree.loads.effects
        parts = self._answer(States.of(self.mechanism, q, v, t=t), self._tree.applied)
        return tuple(
            AppliedForce(*effect, *np.moveaxis(parts[..., k, :, :], -2, 0))
            for k, effect in enumerate(effects)
        )

    @cached_property
    def _guided(self) -> Guided:
        return Guided(self.mechanism, self._tree.elements.open)

    @cached_property
    def _carriers(self) -> list[str]:
        names = [joint.name for joint in self.mechanism.joints]
        joints = set(names)
        for closed in (*self.mechanism.loops, *self.mechanism.contacts):
            kind = "loop" if isinstance(closed, Loop) else "contact"
            names.append(f"{kind} {closed.name}" if closed.name in joints else closed.name)
        return names

    @cached_property
    def _seats(self) -> list[tuple[str, str, tuple[float, float, float]]]:
        """For each joint and loop: the acting body, the other body, and the point on the latter."""
        m = self.mechanism
        seats = [(joint.parent, joint.child, (0.0, 0.0, 0.0)) for joint in m.joints]
        for loop in m.loops:
            x, y, z = m.evaluate_all(loop.frame_b.xyz)
            seats.append((loop.body_a, loop.body_b, (x, y, z)))
        for contact in m.contacts:
            x, y, z = (m.evaluate(c) for c in contact.seat)
            seats.append((contact.on, contact.body, (x, y, z)))
        return seats

    def _transmit(self, states: States, closed: Closed) -> dict[str, Wrench]:
        flags = np.zeros((len(self._carriers), 6), dtype=bool)

        def function(q: Array, v: Array, t: float) -> Array:
            found = closed.reactions(q, v, t)
            np.logical_or(flags, found.undetermined, out=flags)
            return found.wrenches

        parts = self._answer(states, self._look_for_locks(function))
        return self._wrenches(states, parts, flags)

    def _wrenches(
        self, states: States, parts: Array, flags: npt.NDArray[np.bool_] | None = None
    ) -> dict[str, Wrench]:
        """Name the wrenches of joints and loops, shape (…, n, 2, 3), with their points."""
        places = Places(partial(self._poses_by_name, states))
        wrenches = {}
        for k, (name, (parent, child, point)) in enumerate(
            list(zip(self._carriers, self._seats, strict=True))[: parts.shape[-3]]
        ):
            wrenches[name] = Wrench(
                parts[..., k, 0, :],
                parts[..., k, 1, :],
                () if flags is None else _names_of(flags[k]),
                parent=parent,
                child=child,
                point=point,
                body=child,
                places=places,
            )
        return wrenches

    def _poses_by_name(self, states: States) -> dict[str, Array]:
        poses = np.moveaxis(self._answer(states, self._tree.poses), -3, 0)
        names = (body.name for body in self.mechanism.bodies)
        return dict(zip(names, poses, strict=True))


def _names_of(flags: npt.NDArray[np.bool_]) -> tuple[str, ...]:
    return tuple(name for name, loose in zip(COMPONENTS, flags, strict=True) if loose)


def _forget(wrench: Wrench, loose: npt.NDArray[np.bool_], reason: str) -> Wrench:
    """Set the components that guides leave undetermined to NaN; the others become zero."""
    force, moment = (np.where(part, np.nan, 0.0) for part in (loose[:3], loose[3:]))
    return replace(
        wrench,
        force=np.broadcast_to(force, wrench.force.shape).copy(),
        moment=np.broadcast_to(moment, wrench.moment.shape).copy(),
        undetermined=_names_of(loose),
        reason=reason,
    )
