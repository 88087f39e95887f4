"""Choose the axes in which a free body's equations are written, and label its reactions."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, final

import numpy as np

from mecanique.derivation.symbolic.kinematics import Kinematics
from mecanique.derivation.tree.poses import Arithmetic, local, placement_matrix, stack, transpose
from mecanique.model.joints import Revolute
from mecanique.model.mechanism import Mechanism

_UNITS = ((1, 0, 0), (0, 1, 0), (0, 0, 1))


@final
@dataclass(frozen=True)
class Direction:
    """A direction along which a joint may transmit a force, or about which a moment.

    Args:
        kind: "force" or "moment".
        place: index among the three directions of its kind.
        row: shape (3,), in the axes of the body's carrier.
        label: its name, e.g. "x"; "" for the normal of a plane.
        sign: 1, or −1 if the reaction is positive in the opposite direction.
    """

    kind: str
    place: int
    row: Sequence[Any]
    label: str
    sign: int


@final
@dataclass(frozen=True)
class Axes:
    """The directions along which the equations of a body are written.

    Args:
        rows: shape (3, 3), directions of forces, in the axes of the body's carrier.
        labels: name of each; the reaction along "x" is R_joint_x.
        signs: 1, or −1 if the reaction is positive in the opposite direction.
        turns: shape (3, 3), directions of moments.
        turn_labels: name of each; "" for the normal of a plane.
        sentence: a sentence that introduces them to the reader.
        whose: name of the body whose axes x, y and z are, or "the world".
    """

    rows: Sequence[Sequence[Any]]
    labels: tuple[str, str, str]
    signs: tuple[int, int, int]
    turns: Sequence[Sequence[Any]]
    turn_labels: tuple[str, str, str]
    sentence: str
    whose: str = "the world"

    @property
    def directions(self) -> Iterator[Direction]:
        """Yield the directions of forces, then those of moments."""
        for k, row in enumerate(self.rows):
            yield Direction("force", k, row, self.labels[k], self.signs[k])
        for k, row in enumerate(self.turns):
            yield Direction("moment", k, row, self.turn_labels[k], 1)


def axes_of(kinematics: Kinematics, body: str, normal: np.ndarray | None) -> Axes:
    """Choose the axes for the equations of a body.

    The single body of a pendulum gets n from the pin to the center of mass and t perpendicular, in
    the sense of its angle, as in Fundamentals of Dynamics, Figure 1.4; bodies in plane motion get
    the world's axes, all others their own.

    Args:
        kinematics: the kinematics of the mechanism.
        body: name of the body.
        normal: normal of the plane of motion, if there is one, see `normal_of`.
    """
    mechanism = kinematics.algebra.mechanism
    if normal is None:
        carrier = kinematics.carrier(body)
        rows = transpose(kinematics.turn(kinematics.place[body]))
        own = carrier >= 0 or rows != [list(unit) for unit in _UNITS]
        whose = body if own else "the world"
        sentence = f"x, y and z are the axes of {whose}; moments are taken about them."
        return Axes(rows, ("x", "y", "z"), (1, 1, 1), rows, ("x", "y", "z"), sentence, whose)
    if (swing := find_swing(mechanism, body)) is not None:
        joint, n, t = swing
        rotation = kinematics.turn(kinematics.place[body])
        rows = []
        for unit in (n, t, joint.axis):
            rows.append([_dot(row, unit) for row in rotation])
        pin = joint.name
        sentence = (
            f"The unit vectors n, t and k turn with the body: n points from {pin} to the center of "
            f"mass, t is perpendicular to it, in the sense of the angle, and k is along the axis. "
            f"R_{pin}_n is positive toward {pin}, opposite to n, and R_{pin}_t along t. Moments "
            "are positive in the sense of the angle."
        )
        return Axes(rows, ("n", "t", "k"), (-1, 1, 1), rows, ("n", "t", ""), sentence)
    at = int(np.abs(normal).argmax())
    sign = 1 if normal[at] > 0 else -1
    turns = [list(unit) for unit in _UNITS]
    turns[at][at] = sign
    labels = ("x", "y", "z")
    plane = " and ".join(label for k, label in enumerate(labels) if k != at)
    moments: tuple[str, ...] = tuple("" if k == at else label for k, label in enumerate(labels))
    if not any(link.kind == "turn" for link in kinematics.tree):
        return Axes(
            _UNITS, labels, (1, 1, 1), _UNITS, labels, "x, y and z are the axes of the world."
        )
    sentence = (
        f"{plane} are the axes of the world; forces are positive along them, moments about "
        f"{'-' if sign < 0 else ''}{labels[at]}."
    )
    return Axes(_UNITS, labels, (1, 1, 1), turns, (moments[0], moments[1], moments[2]), sentence)


def normal_of(kinematics: Kinematics) -> np.ndarray | None:
    """Return the world's axis normal to the plane of a mechanism's motion, shape (3,), or None.

    If nothing turns, any axis is a normal, and z is returned.
    """
    mechanism = kinematics.algebra.mechanism
    if any(link.kind in ("ball", "free") for link in kinematics.tree):
        return None
    values = {name: 0.0 for joint in mechanism.joints for name in joint.coordinates}
    turns: list[np.ndarray] = []
    slides: list[np.ndarray] = []
    frames: list[np.ndarray] = []
    for link in kinematics.tree:
        parent = frames[link.parent] if link.parent >= 0 else np.eye(4)
        place = placement_matrix(link.origin, mechanism.values)
        frames.append(parent @ place @ stack(local(link, values, Arithmetic()), 1)[0])
        if link.kind in ("turn", "slide"):
            (turns if link.kind == "turn" else slides).append(
                frames[-1][:3, :3] @ np.array(link.axis)
            )
    if not turns:
        return np.array([0.0, 0.0, 1.0])
    normal = turns[0]
    parallel = all(np.linalg.norm(np.cross(normal, axis)) < 1e-12 for axis in turns)
    across = all(abs(normal @ axis) < 1e-12 for axis in slides)
    return normal if parallel and across and np.abs(normal).max() > 1 - 1e-12 else None


def find_swing(
    mechanism: Mechanism, body: str
) -> tuple[Revolute, tuple[float, ...], tuple[float, ...]] | None:
    """Return joint, n and t of a pendulum's only body, in its own axes; None for other bodies."""
    (joint, *others) = mechanism.joints
    if others or not isinstance(joint, Revolute) or joint.child != body:
        return None
    center = np.array(mechanism.evaluate_all(mechanism.body(body).center))
    axis = np.array(joint.axis)
    across = center - (center @ axis) * axis
    size = float(np.linalg.norm(across))
    if not size or np.abs(across).max() < size * (1 - 1e-12) or np.abs(axis).max() < 1 - 1e-12:
        return None
    n = np.round(across / size)
    t = np.cross(axis, n)
    return joint, tuple(n.tolist()), tuple(t.tolist())


def _dot(row: Sequence[Any], unit: Sequence[float]) -> Any:
    """Multiply a row of a rotation by a direction; ±1 and 0 only pick a component or its sign."""
    for entry, component in zip(row, unit, strict=True):
        if component:
            return entry if component > 0 else -entry
    return 0
