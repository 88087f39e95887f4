"""Compute joint reactions, the wrench of each parent on its child.

Pinocchio's inverse dynamics stores in `data.f` the wrench of a joint on all bodies that it carries,
gravity included. Bodies that are welded by fixed joints are one body there. The reaction in a fixed
joint follows from the balance of the bodies it carries: their inertia forces, minus the loads on
them, plus the wrenches of the joints beyond (Newton–Euler). `computeSupportedForceByFrame` promises
the same, but needs data other than inverse dynamics leaves.
"""

from __future__ import annotations

from typing import Any, final

import numpy as np

from mecanique.arrays import Array
from mecanique.model.joints import Fixed
from mecanique.model.mechanism import Mechanism
from mecanique.reference.engine.forces.sites import Action
from mecanique.reference.engine.load import EngineModel
from mecanique.reference.engine.package import engine_package


@final
class Reactions:
    """Reads the reactions of every joint from the engine's data."""

    def __init__(self, mechanism: Mechanism, engine: EngineModel) -> None:
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

        The engine's data must contain positions (`forwardKinematics`) and inverse dynamics of the
        state in question.
        """
        data = self._engine.data
        wrenches = {}
        for name, holder, index in self._joints:
            pose = data.oMi[holder.joint]
            if index is not None:
                # the frame of the joint's last link is the child's
                wrench, turn = data.f[index], pose.rotation
            else:
                wrench = holder.placement.actInv(self._through_weld(name, holder.joint, actions))
                turn = pose.rotation @ holder.placement.rotation
            wrenches[name] = turn @ wrench.linear, turn @ wrench.angular
        return wrenches

    def _through_weld(self, name: str, joint: int, actions: list[Action]) -> Any:
        """Return the wrench of a fixed joint on all it carries, in the moving joint's frame."""
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
    """Return a body and all bodies that are welded to it by fixed joints."""
    bodies = {body}
    for joint in mechanism.tree:
        if isinstance(joint, Fixed) and joint.parent in bodies:
            bodies.add(joint.child)
    return frozenset(bodies)
