"""The state of a joint that leaves its child free: where it is, how it is turned and moves.

The model's own convention is that of `Floating`: position of the child's origin in the axes of the
joint on its parent, unit quaternion (x, y, z, w), velocity of the child's origin and angular
velocity in the child's axes. Others write the quaternion's w first, use Euler angles, or refer
velocities to the world's axes.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, TypeAlias, final

import numpy as np

from mecanique.errors import InputError
from mecanique.model.joints import Floating, Joint, Spherical
from mecanique.model.mechanism import Mechanism
from mecanique.model.quaternions import conjugate, multiply, turn
from mecanique.model.values import Given, numbers_of

ORDERS = ("xyzw", "wxyz")
"""Orders in which quaternions are written."""

_SHORTEST = 1e-9
"""A quaternion shorter than this has no direction."""


def from_quaternion(given: np.ndarray, order: str | None) -> np.ndarray:
    """Return unit quaternions (x, y, z, w), shape (…, 4), of quaternions in a stated order.

    Shapes: given (…, 4).
    """
    length = np.linalg.norm(given, axis=-1, keepdims=True)
    if not (length > _SHORTEST).all():
        raise InputError(f"expected a unit quaternion, got {given.tolist()}")
    unit: np.ndarray = given / length
    return np.roll(unit, -1, axis=-1) if _check_order(order) == "wxyz" else unit


def from_euler(angles: np.ndarray, sequence: str | None) -> np.ndarray:
    """Return quaternions (x, y, z, w), shape (…, 4), of Euler angles in a stated sequence.

    Shapes: angles (…, 3).
    """
    from scipy.spatial.transform import Rotation

    turns: Any = Rotation.from_euler(_check_sequence(sequence), angles)
    return np.asarray(turns.as_quat())


def to_euler(orientation: np.ndarray, sequence: str | None) -> np.ndarray:
    """Return Euler angles, shape (…, 3) [rad], of quaternions (x, y, z, w); orientation (…, 4).

    At gimbal lock, where only the sum or difference of the first and third turn counts, the third
    angle is zero.
    """
    import warnings

    from scipy.spatial.transform import Rotation

    turns: Any = Rotation.from_quat(orientation)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", UserWarning)
        return np.asarray(turns.as_euler(_check_sequence(sequence)))


def _check_order(order: str | None) -> str:
    if order not in ORDERS:
        raise InputError(f'expected the order "xyzw" or "wxyz" of a quaternion, got {order!r}')
    return str(order)


def _check_sequence(sequence: str | None) -> str:
    text = sequence if isinstance(sequence, str) else ""
    sound = (
        len(text) == 3 and set(text.lower()) <= set("xyz") and (text.islower() or text.isupper())
    )
    if not sound or text[0] == text[1] or text[1] == text[2]:
        raise InputError(
            'expected a sequence of Euler angles, such as "xyz" (turns about fixed axes) or "ZYX" '
            f"(about axes that turn along), got {sequence!r}"
        )
    return text


Rows: TypeAlias = "Sequence[float] | Sequence[Sequence[float]] | np.ndarray"
"""Shape (k,) of one state, or (n, k) of many."""

ByName: TypeAlias = "dict[str, Any]"
"""Each a number, or of shape (n,) for n states."""

_UNTURNED = np.array([0.0, 0.0, 0.0, 1.0])


@final
@dataclass(frozen=True, eq=False)
class FloatingState:
    """Where a free body is, how it is turned and moves; `floating_state` reads it.

    Of many states all arrays have a first axis of n.

    Args:
        joint: name of the joint that leaves the body free.
        position: shape (3,), of the body's origin in the world [m].
        orientation: shape (4,), unit quaternion (x, y, z, w) that turns from the body's axes to the
            world's.
        linear: shape (3,), velocity of the body's origin, world axes [m/s].
        angular: shape (3,), angular velocity, world axes [rad/s].

    Example:
        >>> body = mq.textbook.load("free_rigid_body")
        >>> q, v = mq.floating(body, euler=(0.1, 0.2, 0.3), sequence="ZYX")
        >>> mq.floating_state(body, q, v).euler("ZYX").round(3)
        array([0.1, 0.2, 0.3])
    """

    joint: str
    position: np.ndarray
    orientation: np.ndarray
    linear: np.ndarray
    angular: np.ndarray

    def quaternion(self, order: str) -> np.ndarray:
        """Return the unit quaternion in an order, shape (4,); of the two, that with w ≥ 0.

        Args:
            order: "xyzw" or "wxyz".

        Raises:
            InputError: if there is no such order.
        """
        return np.roll(self.orientation, 1 if _check_order(order) == "wxyz" else 0, axis=-1)

    def euler(self, sequence: str) -> np.ndarray:
        """Return the Euler angles of a sequence, shape (3,) [rad].

        At gimbal lock, where only the sum or difference of the first and third turn counts, the
        third angle is zero.

        Args:
            sequence: such as "xyz" or "ZYX", as in `floating`.

        Raises:
            InputError: if there is no such sequence.
        """
        return to_euler(self.orientation, sequence)

    def velocity(self, axes: str) -> tuple[np.ndarray, np.ndarray]:
        """Return the velocity of the origin and the angular velocity, each of shape (3,).

        Args:
            axes: "world" or "body", what they refer to.

        Raises:
            InputError: if there are no such axes.
        """
        if _check_axes(axes) == "world":
            return self.linear, self.angular
        back = conjugate(self.orientation)
        return turn(back, self.linear), turn(back, self.angular)


def floating(
    mechanism: Mechanism,
    joint: str | None = None,
    *,
    position: Rows | None = None,
    quaternion: Rows | None = None,
    order: str | None = None,
    euler: Rows | None = None,
    sequence: str | None = None,
    linear: Rows | None = None,
    angular: Rows | None = None,
    axes: str | None = None,
) -> tuple[ByName, ByName]:
    """Return the positions and velocities by name that put a free body into a state.

    They go where states are given by name, e.g. with `q, v = floating(…)` into
    `simulate(mechanism, q={**q, "elbow": 0.3}, v=v)`. What is not given is zero; no
    convention is taken for granted. Each of shape (k,) may have the shape (n, k), for n states.

    Args:
        mechanism: one with a body that moves freely in the world, e.g. a robot that was read with
            `read_urdf(…, root="floating")`.
        joint: name of the `Floating` joint that leaves it free, or of a `Spherical` one, which can
            only turn; not needed where there is one.
        position: shape (3,), of the body's origin in the world [m].
        quaternion: shape (4,), of any length, that turns from the body's axes to the world's.
        order: of the quaternion: "xyzw" (as in URDF tools, SciPy, ROS, Pinocchio's q) or "wxyz" (as
            in MuJoCo, Drake, Eigen's constructor).
        euler: shape (3,), instead of a quaternion, angles in the order of the sequence [rad].
        sequence: of the turns: in small letters about the world's fixed axes, "xyz" are roll,
            pitch and yaw of URDF; in capitals about the body's axes that have turned along, "ZYX"
            are yaw, pitch and roll in aviation, "ZXZ" Euler's own in Goldstein.
        linear: shape (3,), velocity of the body's origin [m/s].
        angular: shape (3,), angular velocity [rad/s].
        axes: those that both velocities refer to: "world" or "body".

    Returns:
        The positions and the velocities, by name.

    Raises:
        InputError: if the mechanism has no such joint, a shape is wrong, a number is not finite, or
            a convention is not stated.
        UnknownNameError: if there is no joint of that name.

    Example:
        >>> body = mq.textbook.load("free_rigid_body")
        >>> q, v = mq.floating(body, position=(0, 0, 2), quaternion=(1, 0, 0, 0), order="wxyz")
        >>> q["z"], q["qw"]
        (2.0, 1.0)
        >>> float(mq.simulate(body, q=q, v=v, duration=0.1)["z"][0])
        2.0
    """
    free = _choose(mechanism, joint)
    for name, given in (("position", position), ("linear velocity", linear)):
        if given is not None and not free.linear_coordinates:
            raise InputError(f"joint {free.name!r} can only turn; expected no {name}, got {given}")
    if quaternion is not None and euler is not None:
        raise InputError("expected either a quaternion or Euler angles, got both")
    orientation = _UNTURNED
    if quaternion is not None:
        orientation = from_quaternion(_rows(quaternion, "xyzw", "quaternion"), order)
    elif euler is not None:
        orientation = from_euler(_rows(euler, "123", "Euler angle"), sequence)
    rates = {"linear velocity": linear, "angular velocity": angular}
    in_body = {name: _rows(given, "xyz", name) for name, given in rates.items()}
    moves = linear is not None or angular is not None
    if moves and _check_axes(axes) == "world":
        in_body = {name: turn(conjugate(orientation), rate) for name, rate in in_body.items()}
    stand, turned = _stand(mechanism, free)
    away = _rows(position, "xyz", "position") - stand
    q = _by_name(free.linear_coordinates, turn(conjugate(turned), away))
    q |= _by_name(free.quaternion, multiply(conjugate(turned), orientation))
    v = _by_name(free.linear_velocities, in_body["linear velocity"])
    v |= _by_name(free.angular_velocities, in_body["angular velocity"])
    return q, v


def floating_state(
    mechanism: Mechanism, q: Given, v: Given = None, joint: str | None = None
) -> FloatingState:
    """Return where a free body is, how it is turned and moves, to be read in any convention.

    Args:
        mechanism: one with a body that moves freely in the world.
        q: shape (nq,) or (n, nq), or values by name.
        v: shape (nv,) or (n, nv), or values by name.
        joint: name of the `Floating` or `Spherical` joint; not needed where there is one.

    Returns:
        The state, in world axes.

    Raises:
        InputError: if the mechanism has no such joint, or the state is not what is expected.
        UnknownNameError: if a name does not exist.

    Example:
        >>> body = mq.textbook.load("free_rigid_body")
        >>> state = mq.floating_state(body, {"z": 2.0, "qw": 1.0})
        >>> state.position, state.quaternion("wxyz")
        (array([0., 0., 2.]), array([1., 0., 0., 0.]))
    """
    free = _choose(mechanism, joint)
    positions, velocities = mechanism.position(q, many=True), mechanism.velocity(v, many=True)
    at = [mechanism.coordinates.index(name) for name in free.quaternion]
    stand, turned = _stand(mechanism, free)
    orientation = multiply(turned, positions[..., at])
    orientation = np.where(orientation[..., 3:] < 0, -orientation, orientation)
    place = np.zeros(3)
    if free.linear_coordinates:
        place = positions[..., [mechanism.coordinates.index(n) for n in free.linear_coordinates]]
    rates = []
    for names in (free.linear_velocities, free.angular_velocities):
        columns = [mechanism.velocities.index(name) for name in names]
        rates.append(turn(orientation, velocities[..., columns]) if columns else np.zeros(3))
    return FloatingState(free.name, stand + turn(turned, place), orientation, *rates)


def _choose(mechanism: Mechanism, name: str | None) -> Joint:
    """Return the joint that leaves a body free in the world."""
    if name is None:
        able = [hinge.name for hinge in mechanism.joints if isinstance(hinge, Floating)]
        if len(able) != 1:
            many = f"{len(able)} floating joints, {', '.join(able)}; name one"
            count = many if able else "no floating joint"
            raise InputError(f"mechanism {mechanism.name!r} has {count}")
        (name,) = able
    joint = mechanism.joint(name)
    if not isinstance(joint, (Floating, Spherical)):
        raise InputError(
            f"expected a floating or spherical joint, got {joint.name!r}, a {type(joint).__name__}"
        )
    if joint.parent != mechanism.ground:
        raise InputError(
            f"joint {joint.name!r} hangs on {joint.parent!r}, not on the ground; "
            "its coordinates are relative to that body"
        )
    return joint


def _stand(mechanism: Mechanism, joint: Joint) -> tuple[np.ndarray, np.ndarray]:
    """Return where the joint stands in the world, and how it is turned there."""
    xyz, rpy = map(mechanism.evaluate_all, (joint.origin.xyz, joint.origin.rpy))
    return np.array(xyz), from_euler(np.array(rpy), "xyz")


def _rows(given: Any, components: str, what: str) -> np.ndarray:
    """Return what was given as an array, shape (…, components); zero where nothing was."""
    return numbers_of(given, tuple(components), what, np.zeros(len(components)), many=True)


def _by_name(names: Sequence[str], values: np.ndarray) -> ByName:
    """Return the last axis of some values by name, as numbers or arrays; none for no names."""
    columns = np.moveaxis(values, -1, 0) if names else ()
    return dict(zip(names, (float(x) if x.ndim == 0 else x for x in columns), strict=True))


def _check_axes(axes: str | None) -> str:
    if axes not in ("world", "body"):
        raise InputError(f'expected the axes "world" or "body" of the velocities, got {axes!r}')
    return str(axes)
