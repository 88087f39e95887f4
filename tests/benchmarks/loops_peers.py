"""A closed mechanism by hand: Pinocchio's M and bias, a KKT system, Baumgarte's terms, dop853."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
from scipy.integrate import ode

from mecanique.model import JointForce, Mechanism, Spring
from mecanique.urdf.write import write_urdf

__all__ = ["BareKkt"]


class BareKkt:
    """What someone writes who needs one planar linkage, its pins in the x-z plane.

    Args:
        mechanism: a tree with pins, springs and constant joint forces.
        damping: rate at which Baumgarte's terms close gaps [1/s].
    """

    def __init__(self, mechanism: Mechanism, damping: float) -> None:
        self.model = model = pin.buildModelFromXML(write_urdf(mechanism))
        model.gravity = pin.Motion(np.array([*mechanism.evaluate_all(mechanism.gravity), 0, 0, 0]))
        nv = model.nv
        names = [joint.name for joint in mechanism.joints if joint.coordinates]
        self.order = np.array([model.idx_vs[model.getJointId(name)] for name in names])
        self.frames, self.springs = [], []
        for loop in mechanism.loops:
            ends = ((loop.body_a, loop.frame_a.xyz), (loop.body_b, loop.frame_b.xyz))
            self.frames.append([self._add(mechanism, body, at) for body, at in ends])
        self.tau = np.zeros(nv)
        for force in mechanism.forces:
            if isinstance(force, JointForce):
                joint = model.getJointId(force.joint)
                self.tau[model.idx_vs[joint]] = mechanism.evaluate(force.force)
            elif isinstance(force, Spring):
                held = mechanism.evaluate_all(force.point_a)
                stiffness, rest = map(mechanism.evaluate, (force.stiffness, force.free_length))
                moving = self._add(mechanism, force.body_b, force.point_b)
                self.springs.append((np.array(held), moving, stiffness, rest))
        self.data, self.damping = model.createData(), damping
        rows = 2 * len(self.frames)
        self.matrix = np.zeros((nv + rows, nv + rows))

    def _add(self, mechanism: Mechanism, body: str, at: tuple[object, ...]) -> int:
        holder = self.model.frames[self.model.getFrameId(body)]
        place = holder.placement * pin.SE3(np.eye(3), np.array(mechanism.evaluate_all(at)))
        name = f"point {self.model.nframes}"
        return int(
            self.model.addFrame(
                pin.Frame(name, holder.parentJoint, 0, place, pin.FrameType.OP_FRAME)
            )
        )

    def rates(self, t: float, y: np.ndarray) -> np.ndarray:
        """Return y'."""
        model, data, nv, k = self.model, self.data, self.model.nv, self.damping
        angles, v = np.empty(nv), np.empty(nv)
        angles[self.order], v[self.order] = y[:nv], y[nv:]
        q = pin.integrate(model, pin.neutral(model), angles)
        pin.forwardKinematics(model, data, q, v, np.zeros(nv))
        pin.computeJointJacobians(model, data, q)
        pin.updateFramePlacements(model, data)
        axes, matrix, right = pin.LOCAL_WORLD_ALIGNED, self.matrix, np.zeros(len(self.matrix))
        for i, pair in enumerate(self.frames):
            a, b = (pin.getFrameJacobian(model, data, frame, axes)[0:3:2] for frame in pair)
            p, r = (data.oMf[frame].translation[0:3:2] for frame in pair)
            da, db = (
                pin.getFrameClassicalAcceleration(model, data, frame, axes).linear[0:3:2]
                for frame in pair
            )
            J, at = b - a, nv + 2 * i
            matrix[at : at + 2, :nv], matrix[:nv, at : at + 2] = J, J.T
            right[at : at + 2] = -(db - da) - 2 * k * (J @ v) - k * k * (r - p)
        matrix[:nv, :nv] = pin.crba(model, data, q)
        lower = np.tril_indices(nv, -1)
        matrix[:nv, :nv][lower] = matrix[:nv, :nv].T[lower]
        right[:nv] = self.tau - pin.nle(model, data, q, v)
        for held, frame, stiffness, rest in self.springs:
            apart = data.oMf[frame].translation - held
            length = np.linalg.norm(apart)
            pull = -stiffness * (length - rest) / length * apart
            right[:nv] += pin.getFrameJacobian(model, data, frame, axes)[:3].T @ pull
        return np.concatenate([y[nv:], np.linalg.solve(matrix, right)[self.order]])

    def integrate(self, start: np.ndarray, duration: float, rtol: float) -> np.ndarray:
        """Return the state after a while."""
        solver = ode(self.rates).set_integrator("dop853", rtol=rtol, atol=rtol, nsteps=1_000_000)
        return np.asarray(solver.set_initial_value(start, 0.0).integrate(duration))
