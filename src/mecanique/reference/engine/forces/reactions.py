"""Joint reactions: the action of each parent on its child.

Pinocchio's inverse dynamics leaves in `data.f` the force of a joint on everything it carries,
gravity included. Bodies that fixed joints weld together are one body there, so the reaction in a
fixed joint is found from the balance of what it carries: inertia forces of its bodies, less the
loads on them, plus what the joints behind it demand (Newton–Euler). `computeSupportedForceByFrame`,
which promises the same, needs another work-space state than inverse dynamics leaves.
"""

from __future__ import annotations

from typing import Any, final

import numpy as np

from mecanique.arrays import Array
from mecanique.model.joints import Fixed
from mecanique.model.mechanism import Mechanism
from mecanique.reference.engine.forces.sites import Action
from mecanique.reference.engine.load import Engine
from mecanique.reference.engine.package import engine_package

__all__ = ["Reactions"]


@final
class Reactions:
    """Read the reactions of every joint from the engine's work space."""

    def __init__(self, mechanism: Mechanism, engine: Engine) -> None:
        self._engine = engine
        self._joints = [
            (
                joint.name,
                engine.holders[joint.child],
                None if isinstance(joint, Fixed) else engine.seats[joint.name][-1].index,
            )
            for joint in mechanism.joints
        ]
        self._carried = {
            joint.name: _weld(mechanism, joint.child)
            for joint in mechanism.joints
            if isinstance(joint, Fixed)
        }
        self._behind: dict[str, list[int]] = {}
        for name, bodies in self._carried.items():
            self._behind[name] = [
                engine.seats[joint.name][0].index
                for joint in mechanism.joints
                if joint.parent in bodies and not isinstance(joint, Fixed)
            ]

    def read(self, actions: list[Action]) -> dict[str, tuple[Array, Array]]:
        """Return force and moment of parent on child at the child's origin, world axes, by joint.

        The work space must hold positions (`forwardKinematics`) and inverse dynamics at the state
        in question.

        Args:
            actions: what acts on the bodies, for the balance at fixed joints.
        """
        data = self._engine.data
        found = {}
        for name, holder, index in self._joints:
            pose = data.oMi[holder.joint]
            if index is not None:
                # the frame of the joint's last link is the child's
                wrench, turn = data.f[index], pose.rotation
            else:
                wrench = holder.placement.actInv(self._through_weld(name, holder.joint, actions))
                turn = pose.rotation @ holder.placement.rotation
            found[name] = turn @ wrench.linear, turn @ wrench.angular
        return found

    def _through_weld(self, name: str, joint: int, actions: list[Action]) -> Any:
        """Return the force of a fixed joint on what it carries, in the moving joint's frame."""
        pin = engine_package()

        engine, data = self._engine, self._engine.data
        velocity, acceleration = data.v[joint], data.a_gf[joint]
        total = pin.Force.Zero()
        for body in self._carried[name]:
            inertia = engine.holders[body].inertia
            total += inertia * acceleration + velocity.cross(inertia * velocity)
        for index in self._behind[name]:
            total += data.liMi[index].act(data.f[index])
        pose = data.oMi[joint]
        for action in actions:
            if action.site.body in self._carried[name]:
                force, moment = (
                    np.array(action.force),
                    np.array(action.moment(*pose.translation.tolist())),
                )
                total -= pin.Force(pose.rotation.T @ force, pose.rotation.T @ moment)
        return total


def _weld(mechanism: Mechanism, body: str) -> frozenset[str]:
    """The body and all bodies fixed to it by joints."""
    bodies = {body}
    for joint in mechanism.tree:
        if isinstance(joint, Fixed) and joint.parent in bodies:
            bodies.add(joint.child)
    return frozenset(bodies)
