"""One body in every kind of force, with its acceleration and potential energy by hand."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

import mecanique as mq

__all__ = ["SAMPLES", "Sample"]

Vector: TypeAlias = np.ndarray

MASS, LONG, GRAVITY = 2.0, 0.9, np.array([0.4, -0.3, -9.81])
ANCHOR, SPOT = np.array([0.3, -0.2, 1.1]), np.array([0.1, 0.2, -0.6])
K, REST, C, B = 7.0, 0.3, 1.3, 5.0
X, Y, Z = mq.position()
TIME = mq.time()


@dataclass(frozen=True)
class Sample:
    """A mechanism in a state, and what it does there."""

    mechanism: mq.Mechanism
    q: Vector
    v: Vector
    t: float
    acceleration: Vector
    potential: float


@dataclass(frozen=True)
class _Push:
    """A force at a point of the body, and its law: from p, p', t and the body's turn R."""

    force: mq.AnyForce
    law: Callable[[Vector, Vector, float, Vector], Vector]
    stored: Callable[[Vector, float], float] = lambda p, t: 0.0


def _along(p: Vector) -> tuple[float, Vector]:
    d = p - ANCHOR
    return float(np.linalg.norm(d)), d / np.linalg.norm(d)


def _central(slope: Callable[[float], float]) -> Callable[..., Vector]:
    def pull(p: Vector, rate: Vector, t: float, R: Vector) -> Vector:
        length, e = _along(p)
        return -slope(length) * e

    return pull


def _pushes(point: Vector) -> Iterator[_Push]:
    ends = "ground", tuple(ANCHOR), "body", tuple(point)
    yield _Push(
        mq.Spring("spring", *ends, stiffness=K, free_length=REST),
        _central(lambda d: K * (d - REST)),
        lambda p, t: K / 2 * (_along(p)[0] - REST) ** 2,
    )
    yield _Push(
        mq.Spring("long spring", *ends, stiffness=K, free_length=0.0),
        _central(lambda d: K * d),
        lambda p, t: K / 2 * _along(p)[0] ** 2,
    )
    yield _Push(
        mq.Damper("damper", *ends, damping=C),
        lambda p, rate, t, R: -C * (rate @ _along(p)[1]) * _along(p)[1],
    )
    yield _Push(
        mq.CentralForce("attraction", *ends, -B / mq.distance()),
        _central(lambda d: B / d**2),
        lambda p, t: -B / _along(p)[0],
    )
    yield _Push(
        mq.CentralForce("quartic", *ends, B * mq.distance() ** 4 + K * mq.distance() ** 2),
        _central(lambda d: 4 * B * d**3 + 2 * K * d),
        lambda p, t: B * _along(p)[0] ** 4 + K * _along(p)[0] ** 2,
    )
    yield _Push(
        mq.PotentialField("field", "body", tuple(point), K * X**2 * Y + B * Z * TIME),
        lambda p, rate, t, R: -np.array([2 * K * p[0] * p[1], K * p[0] ** 2, B * t]),
        lambda p, t: K * p[0] ** 2 * p[1] + B * p[2] * t,
    )
    yield _Push(
        mq.Force("push", "body", tuple(point), (3.0, -2 * TIME, 1.5)),
        lambda p, rate, t, R: np.array([3.0, -2 * t, 1.5]),
    )
    yield _Push(
        mq.Force("thrust", "body", tuple(point), (3.0, -2 * TIME, 1.5), axes="body"),
        lambda p, rate, t, R: R @ np.array([3.0, -2 * t, 1.5]),
    )


def _on_slides(push: _Push) -> Sample:
    """A particle on three slides."""
    bodies = mq.Body("ground"), mq.Body("first"), mq.Body("second")
    axes = ((1, 0, 0), (0, 1, 0), (0, 0, 1))
    stations = ("ground", "first", "second", "body")
    mechanism = mq.Mechanism(
        f"particle, {push.force.name}",
        (*bodies, mq.Body("body", mq.particle(MASS))),
        tuple(
            mq.Prismatic(letter, stations[k], stations[k + 1], axis=axes[k])
            for k, letter in enumerate("xyz")
        ),
        forces=(push.force,),
        gravity=tuple(GRAVITY),
    )
    q, v, t = np.array([0.7, 0.4, -0.2]), np.array([0.5, -0.8, 0.3]), 0.6
    force = push.law(q, v, t, np.eye(3))
    potential = push.stored(q, t) - MASS * GRAVITY @ q
    return Sample(mechanism, q, v, t, force / MASS + GRAVITY, potential)


def _on_a_pin(push: _Push) -> Sample:
    """A rod on a pin about −y, and a point beside it."""
    mechanism = mq.Mechanism(
        f"rod, {push.force.name}",
        (mq.Body("ground"), mq.Body("body", mq.rod(MASS, LONG))),
        (mq.Revolute("pin", "ground", "body", axis=(0, -1, 0), coordinate="q"),),
        forces=(push.force,),
        gravity=tuple(GRAVITY),
    )
    q, v, t, axis = 0.7, 1.3, 0.6, np.array([0.0, -1.0, 0.0])
    c, s = np.cos(q), np.sin(q)
    R = np.array([[c, 0, -s], [0, 1, 0], [s, 0, c]])
    p, center = R @ SPOT, R @ np.array([0, 0, -LONG / 2])
    force = push.law(p, v * np.cross(axis, p), t, R)
    moment = np.cross(p, force) @ axis + MASS * np.cross(center, GRAVITY) @ axis
    potential = push.stored(p, t) - MASS * GRAVITY @ center
    rate = moment / (MASS * LONG**2 / 3)
    return Sample(mechanism, np.array([q]), np.array([v]), t, np.array([rate]), potential)


def _in_the_joint() -> Iterator[Sample]:
    """A disk about its axis, by what acts in its joint or as a couple."""
    q, v, t, inertia = 0.7, 1.3, 0.6, MASS * LONG**2 / 2
    angle = mq.coordinate("q")
    couple = np.array([0.3, 0.5 * v, -2.0])
    kinds: list[tuple[mq.AnyForce, float, float]] = [
        (mq.JointSpring("coil", "pin", K, REST), -K * (q - REST), K / 2 * (q - REST) ** 2),
        (mq.JointDamper("oil", "pin", C), -C * v, 0.0),
        (mq.JointForce("drive", "pin", B * TIME - angle), B * t - q, 0.0),
        (
            mq.Potential("well", "pin", B * angle**4 + K * angle),
            -4 * B * q**3 - K,
            B * q**4 + K * q,
        ),
        (mq.Torque("couple", "body", (0.3, 0.5 * mq.velocity("q"), -2.0)), -couple[1], 0.0),
        (
            mq.Torque("carried couple", "body", (0.3, 0.5 * mq.velocity("q"), -2.0), axes="body"),
            -couple[1],
            0.0,
        ),
    ]
    for force, moment, stored in kinds:
        mechanism = mq.Mechanism(
            f"disk, {force.name}",
            (mq.Body("ground"), mq.Body("body", mq.disk(MASS, LONG).at(rpy=(np.pi / 2, 0, 0)))),
            (mq.Revolute("pin", "ground", "body", axis=(0, -1, 0), coordinate="q"),),
            forces=(force,),
            gravity=tuple(GRAVITY),
        )
        rate = np.array([moment / inertia])
        yield Sample(mechanism, np.array([q]), np.array([v]), t, rate, stored)


SAMPLES = (
    *map(_on_slides, _pushes(np.zeros(3))),
    *map(_on_a_pin, _pushes(SPOT)),
    *_in_the_joint(),
)
