"""Compute how the frames of a tree move, on batched floats, by vector kinematics.

v = v_P + ω_P × r and a = a_P + α_P × r + ω_P × (ω_P × r), plus the joint's own motion (Beer &
Johnston, Vector Mechanics for Engineers: Dynamics, ch. 15). All vectors are in world axes.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np

from mecanique.derivation.numeric.chart import Motions
from mecanique.derivation.tree.links import Link
from mecanique.derivation.tree.poses import Arithmetic, local, stack


@final
@dataclass(frozen=True, eq=False)
class Frame:
    """The frame of a link over n states."""

    turn: np.ndarray  # shape (n, 3, 3), its axes in the world
    seat: np.ndarray  # shape (n, 3), its origin [m]
    step: np.ndarray  # shape (n, 3), vector from the parent link's origin to its own [m]
    velocity: np.ndarray  # shape (n, 3), of the origin [m/s]
    spin: np.ndarray  # shape (n, 3), angular velocity [rad/s]
    # shape (n, 3), acceleration of the origin at constant generalized velocities [m/s²]
    gamma: np.ndarray
    # shape (n, 3), angular acceleration at constant generalized velocities [rad/s²]
    gamma_spin: np.ndarray
    J: np.ndarray  # shape (n, 3, nu), Jacobian of the origin's velocity in the joint velocities
    J_spin: np.ndarray  # shape (n, 3, nu), Jacobian of the angular velocity in the joint velocities
    # shape (n, 6, k), linear and angular direction of each of the link's joint velocities
    axes: np.ndarray

    @property
    def pose(self) -> np.ndarray:
        """The frame as homogeneous matrices, shape (n, 4, 4)."""
        return _homogeneous(self.turn, self.seat, 1.0)

    @property
    def pose_rate(self) -> np.ndarray:
        """The rate of the pose, shape (n, 4, 4) [1/s]."""
        turning = cross(self.spin[:, :, None], self.turn)
        return _homogeneous(turning, self.velocity, 0.0)


def cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return a × b, as `np.cross` on axis 1 does in twice the time, shape (n, 3) or (n, 3, k)."""
    ax, ay, az = a[:, 0], a[:, 1], a[:, 2]
    bx, by, bz = b[:, 0], b[:, 1], b[:, 2]
    x = ay * bz - az * by
    turned = np.empty((len(x), 3, *x.shape[1:]))
    turned[:, 0] = x
    turned[:, 1] = az * bx - ax * bz
    turned[:, 2] = ax * by - ay * bx
    return turned


def frames(tree: tuple[Link, ...], places: list[np.ndarray], move: Motions) -> list[Frame]:
    """Return the frame of every link; places (4, 4)."""
    n, nu = move.u.shape
    ground = Frame(
        turn=np.broadcast_to(np.eye(3), (n, 3, 3)),
        seat=np.zeros((n, 3)),
        step=np.zeros((n, 3)),
        velocity=np.zeros((n, 3)),
        spin=np.zeros((n, 3)),
        gamma=np.zeros((n, 3)),
        gamma_spin=np.zeros((n, 3)),
        J=np.zeros((n, 3, nu)),
        J_spin=np.zeros((n, 3, nu)),
        axes=np.zeros((n, 6, 0)),
    )
    carried: list[Frame] = []
    first = 0
    for link, place in zip(tree, places, strict=True):
        parent = carried[link.parent] if link.parent >= 0 else ground
        count = len(link.velocities)
        carried.append(_carry(parent, link, place, move, slice(first, first + count)))
        first += count
    return carried


def _carry(parent: Frame, link: Link, place: np.ndarray, move: Motions, columns: slice) -> Frame:
    n = len(move.u)
    here = place @ stack(local(link, move.r, Arithmetic()), n)
    turn = parent.turn @ here[:, :3, :3]
    r = np.einsum("nij,nj->ni", parent.turn, here[:, :3, 3])
    axes = _axes(link, turn)
    slide, roll = axes[:, :3], axes[:, 3:]
    u, rates = move.u[:, columns, None], move.gamma[:, columns, None]
    sliding, rolling = (slide @ u)[..., 0], (roll @ u)[..., 0]
    spin = parent.spin + rolling
    # a free joint's directions turn with the child, those of a slide with the parent
    bent = cross(spin if link.kind == "free" else parent.spin, sliding)
    J = parent.J + cross(parent.J_spin, r[:, :, None])
    J_spin = parent.J_spin.copy()
    J[:, :, columns] += slide
    J_spin[:, :, columns] += roll
    return Frame(
        turn=turn,
        seat=parent.seat + r,
        step=r,
        velocity=parent.velocity + cross(parent.spin, r) + sliding,
        spin=spin,
        gamma=parent.gamma
        + cross(parent.gamma_spin, r)
        + cross(parent.spin, cross(parent.spin, r) + sliding)
        + bent
        + (slide @ rates)[..., 0],
        gamma_spin=parent.gamma_spin + cross(parent.spin, rolling) + (roll @ rates)[..., 0],
        J=J,
        J_spin=J_spin,
        axes=axes,
    )


def _axes(link: Link, turn: np.ndarray) -> np.ndarray:
    """Directions of a link's joint velocities in the world, shape (n, 6, k)."""
    axes = np.zeros((len(turn), 6, len(link.velocities)))
    along = (turn @ np.array(link.axis))[:, :, None]
    if link.kind == "turn":
        axes[:, 3:] = along
    elif link.kind == "slide":
        axes[:, :3] = along
    elif link.kind == "ball":
        axes[:, 3:] = turn
    elif link.kind == "free":
        axes[:, :3, :3] = axes[:, 3:, 3:] = turn
    return axes


def _homogeneous(block: np.ndarray, column: np.ndarray, corner: float) -> np.ndarray:
    out = np.zeros((len(block), 4, 4))
    out[:, :3, :3], out[:, :3, 3], out[:, 3, 3] = block, column, corner
    return out
