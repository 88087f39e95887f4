"""A description at rest: its links, the joints that move them, and its findings."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, final

import numpy as np

from mecanique.arrays import Array
from mecanique.model.bodies.tensor import tensor_of
from mecanique.model.expression import evaluate
from mecanique.model.joint_base import Elementary
from mecanique.model.mechanism import Mechanism
from mecanique.model.mechanism.origin import Finding
from mecanique.model.placement import pose_at
from mecanique.model.quaternions import turn as turn_vectors

REACH = {"rad": math.pi, "m": 1.0}
"""How far a joint without limits is moved each way."""


@final
@dataclass(frozen=True)
class InspectedLink:
    """Where a body's mass is."""

    mass: float
    center: tuple[float, ...]  # its center of mass in the body's frame, shape (3,) [m]
    radii: tuple[float, ...]
    axes: tuple[tuple[float, ...], ...]


@final
@dataclass(frozen=True)
class Move:
    """A turn about or a slide along an axis, by a linear function of sliders."""

    kind: Literal["turn", "slide"]
    axis: tuple[float, float, float]  # unit axis in the frame before it, shape (3,)
    constant: float  # its value where all sliders are zero [rad or m]
    factors: tuple[tuple[int, float], ...]


@final
@dataclass(frozen=True)
class Path:
    """How a body stands in another."""

    parent: int
    child: int
    place: tuple[tuple[float, ...], ...]
    moves: tuple[Move, ...]


@final
@dataclass(frozen=True)
class Slider:
    """A coordinate that can be set."""

    name: str
    unit: str
    low: float
    high: float
    value: float
    limited: bool


@final
@dataclass(frozen=True)
class Note:
    """A finding beside the picture."""

    finding: Finding
    bodies: tuple[int, ...]

    @property
    def suspicious(self) -> bool:
        """Whether the numbers of a link or joint are likely wrong, not only left out or unknown."""
        wrong = ("M1", "M2")
        kind = self.finding.severity
        return kind == "error" or (kind == "warning" and self.finding.code.startswith(wrong))


@final
@dataclass(frozen=True)
class Inspection:
    """A description at rest, as the page shows it."""

    links: tuple[InspectedLink, ...]
    paths: tuple[Path, ...]
    sliders: tuple[Slider, ...] = ()
    notes: tuple[Note, ...] = ()
    closed: bool = False

    def poses(self, values: Sequence[float] | None = None) -> Array:
        """Return the bodies' poses, shape (nb, 4, 4)."""
        at = [slider.value for slider in self.sliders] if values is None else values
        poses = np.tile(np.eye(4), (len(self.links), 1, 1))
        for path in self.paths:
            pose = poses[path.parent] @ np.array(path.place)
            for move in path.moves:
                value = move.constant + sum(factor * at[k] for k, factor in move.factors)
                pose = pose @ _motion(move.kind, move.axis, value)
            poses[path.child] = pose
        return poses


def inspection_of(
    mechanism: Mechanism, findings: Sequence[Finding], q: Array | None = None
) -> Inspection:
    """Return the inspection of a mechanism."""
    start = mechanism.neutral() if q is None else q
    sliders = tuple(_sliders(mechanism, start))
    return Inspection(
        links=tuple(_link(mechanism, k) for k in range(len(mechanism.bodies))),
        paths=tuple(_paths(mechanism, start, [slider.name for slider in sliders])),
        sliders=sliders,
        notes=tuple(Note(finding, tuple(_bodies(mechanism, finding))) for finding in findings),
        closed=bool(mechanism.constrained),
    )


def _link(mechanism: Mechanism, k: int) -> InspectedLink:
    body = mechanism.bodies[k]
    mass = mechanism.evaluate(body.mass)
    center = tuple(mechanism.evaluate_all(body.center))
    moments, axes = np.linalg.eigh(tensor_of(mechanism.evaluate_all(body.inertia)))
    if np.linalg.det(axes) < 0:
        axes[:, 0] *= -1
    radii = (0.0, 0.0, 0.0)
    if mass > 0:
        # I₁ = m (b² + c²)/5 of an ellipsoid, and so on
        squares = 2.5 * (moments.sum() - 2 * moments) / mass
        radii = tuple(np.sqrt(np.maximum(squares, 0.0)).tolist())
    return InspectedLink(mass, center, radii, tuple(map(tuple, axes.tolist())))


def _sliders(mechanism: Mechanism, start: Array) -> Iterator[Slider]:
    """A slider for each coordinate that turns or slides something."""
    limits = {}
    simple: dict[str, str] = {}
    for joint in mechanism.joints:
        for motion in joint.chain:
            if motion.kind in ("turn", "slide") and motion.follows is None:
                simple[motion.coordinates[0]] = "rad" if motion.kind == "turn" else "m"
        stated = getattr(joint, "limits", None)
        if stated is not None and len(joint.coordinates) == 1:
            limits[joint.coordinates[0]] = stated
    for name, value in zip(mechanism.coordinates, start.tolist(), strict=True):
        if name not in simple:
            continue
        reach, bounds = REACH[simple[name]], limits.get(name)
        low, high = value - reach, value + reach
        limited = bounds is not None and bounds.lower < bounds.upper
        if bounds is not None and limited:
            low = bounds.lower if math.isfinite(bounds.lower) else low
            high = bounds.upper if math.isfinite(bounds.upper) else high
        yield Slider(
            name=name,
            unit=simple[name],
            low=min(low, value),
            high=max(high, value),
            value=value,
            limited=limited,
        )


def _paths(mechanism: Mechanism, start: Array, sliders: Sequence[str]) -> Iterator[Path]:
    """The joints, parents first."""
    number = {body.name: k for k, body in enumerate(mechanism.bodies)}
    given = dict(zip(mechanism.coordinates, start.tolist(), strict=True))
    rest = _joint_values(mechanism, given)
    changed = []
    for name in sliders:
        changed.append(_joint_values(mechanism, given | {name: given[name] + 1.0}))
    waiting = list(mechanism.joints)
    known = {mechanism.ground}
    while waiting:
        joint = next((candidate for candidate in waiting if candidate.parent in known), waiting[0])
        waiting.remove(joint)
        known.add(joint.child)
        place = mechanism.matrix(joint.origin)
        moves = list[Move]()
        for motion in joint.chain:
            if motion.kind in ("turn", "slide"):
                moves.append(_move(motion, rest, changed, [given[name] for name in sliders]))
            elif motion.coordinates:
                # the place of a free body, if it has one, and its quaternion
                values = [rest[name] for name in motion.coordinates]
                turn = turn_vectors(np.array(values[-4:]), np.eye(3)).T
                place = place @ pose_at(values[:-4] or 0.0, turn)
        rows = tuple(map(tuple, place.tolist()))
        yield Path(number[joint.parent], number[joint.child], rows, tuple(moves))


def _joint_values(mechanism: Mechanism, given: Mapping[str, float]) -> dict[str, float]:
    """The values of all joint coordinates, those that follow others among them."""
    values = {**mechanism.values, **given, "t": 0.0}
    driven = mechanism.coordinates.driven.items()
    return {**given, **{name: float(evaluate(scalar, values)) for name, scalar in driven}}


def _move(
    motion: Elementary,
    rest: Mapping[str, float],
    changed: Sequence[Mapping[str, float]],
    at: Sequence[float],
) -> Move:
    (name,) = motion.coordinates
    factors = []
    for k, values in enumerate(changed):
        factor = float(values[name] - rest[name])
        if factor:
            factors.append((k, factor))
    constant = float(rest[name]) - sum(factor * at[k] for k, factor in factors)
    kind: Literal["turn", "slide"] = "turn" if motion.kind == "turn" else "slide"
    return Move(kind, motion.axis, constant, tuple(factors))


def _motion(kind: str, axis: Sequence[float], value: float) -> Array:
    along = np.array(axis)
    if kind == "slide":
        return pose_at(value * along)
    quaternion = np.append(along * math.sin(value / 2), math.cos(value / 2))
    return pose_at(turn=turn_vectors(quaternion, np.eye(3)).T)


def _bodies(mechanism: Mechanism, finding: Finding) -> Iterator[int]:
    """The bodies that a finding names, and those that the joints it names move."""
    number = {body.name: k for k, body in enumerate(mechanism.bodies)}
    child = {joint.name: number[joint.child] for joint in mechanism.joints}
    places = dict[int, None]()
    for kind, name in re.findall(r"(link|joint)s? '([^']+)'", finding.sentence):
        place = number.get(name) if kind == "link" else child.get(name)
        if place is not None:
            places[place] = None
    yield from places
