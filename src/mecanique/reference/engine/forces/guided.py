"""Find the reaction components that guides without an element leave undetermined."""

from __future__ import annotations

from collections.abc import Sequence
from typing import final

import numpy as np
import numpy.typing as npt

from mecanique.arrays import Array
from mecanique.model.guides.guide import Guide, explain_joint, idle_coordinates
from mecanique.model.joints import Joint
from mecanique.model.mechanism import Mechanism

_WHOLE = 1 - 1e-9
"""A unit vector whose projection on the idle directions is longer than this lies within them."""


@final
class Guided:
    """The joints of a mechanism whose reactions depend on guides without an element.

    Args:
        mechanism: any mechanism.
        guides: the guides that its elements do not describe.
    """

    def __init__(self, mechanism: Mechanism, guides: Sequence[Guide]) -> None:
        self._mechanism = mechanism
        self._guides = guides
        self._place = {body.name: k for k, body in enumerate(mechanism.bodies)}
        reasons = {
            joint.name: explain_joint(self._guides, joint.name) for joint in mechanism.joints
        }
        self.reasons = {name: reason for name, reason in reasons.items() if reason}
        """The reason why a reaction is undetermined, by name of the joint."""

    def undetermined(self, poses: Array) -> npt.NDArray[np.bool_]:
        """Return which components of each joint's reaction are undetermined, shape (joints, 6).

        Args:
            poses: poses of all bodies in n states, shape (n, bodies, 4, 4).
        """
        joints = self._mechanism.joints
        flags = np.zeros((len(joints), 6), dtype=bool)
        for k, joint in enumerate(joints):
            if joint.name in self.reasons:
                idle = self._idle(joint, poses)
                # a component along e is determined if e lies within the idle directions, |P e| = 1
                onto = np.linalg.pinv(idle) if idle.size else np.zeros((len(poses), 0, 6))
                flags[k] = (np.linalg.norm(idle @ onto, axis=1) < _WHOLE).any(axis=0)
        return flags

    def _idle(self, joint: Joint, poses: Array) -> Array:
        """Return the directions in which a joint transmits nothing, world axes, shape (n, 6, k)."""
        names = idle_coordinates(self._guides, joint)
        turns = poses[:, self._place[joint.child], :3, :3]
        origin = self._mechanism.matrix(joint.origin)[:3, :3]
        before = poses[:, self._place[joint.parent], :3, :3] @ origin
        found, chain = [np.zeros((len(poses), 6, 0))], joint.chain
        for motion in chain:
            if not names.issuperset(motion.coordinates):
                continue
            # the axes of a chain's earlier motions do not turn with the child
            frame = turns if motion is chain[-1] else before
            axes = np.eye(3) if motion.kind in ("ball", "free") else np.array([motion.axis]).T
            along, nothing = frame @ axes, np.zeros((len(poses), 3, axes.shape[1]))
            if motion.kind in ("slide", "free"):
                found.append(np.concatenate([along, nothing], axis=1))
            if motion.kind in ("turn", "ball", "free"):
                found.append(np.concatenate([nothing, along], axis=1))
        return np.concatenate(found, axis=2)
