"""The coordinate map that gears, racks, belts and cords make, where it is not given.

Where two wheels, or a pinion and its rack, touch, both move alike: seen from the body K that holds
both their axes, r₁ ω₁ (n₁ × u₁) = r₂ ω₂ (n₂ × u₂). No part of a cord between two pulleys that turn
with it changes its length, Σ e·(v_end − v_start) = 0 over its stretches. Rows that are linear in
joint coordinates with constant factors are solved for one of them; others have to be given.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import Any, TypeAlias, final

import numpy as np

from mecanique.model.constraint_base import CordStop
from mecanique.model.constraints.cords import Belt, Cord
from mecanique.model.constraints.elements import Element
from mecanique.model.constraints.gears import Gear, Rack
from mecanique.model.expression import Scalar, coordinate, plain, symbols_in
from mecanique.model.joint_base import Single
from mecanique.model.joints import Joint, Prismatic, Revolute
from mecanique.model.mechanism.description import Description

_NEAR = 1e-9

Row: TypeAlias = "dict[str, Any]"
"""Joint coordinate -> its factor in a sum that stays as it is, the one to be solved for last."""


@final
@dataclass(frozen=True)
class Bevel:
    """How the axes of two bevel wheels stand, n₁ · n₂ = c and |n₁ × n₂| = s.

    With w₁ = (n₂ − c n₁)/s and w₂ = (n₁ − c n₂)/s the pitch circles touch at C₁ + σ₁ r₁ w₁, which
    is C₂ + σ₂ r₂ w₂. From the apex, where the axes meet, the centers C₁ and C₂ are at a₁ n₁ and a₂
    n₂ with s a₁ = σ₂ r₂ + c σ₁ r₁ and s a₂ = σ₁ r₁ + c σ₂ r₂.
    """

    cosine: float
    sine: float
    sides: tuple[int, int]  # σ₁ and σ₂
    ahead: int  # 1 if the second wheel lies along σ₂ n₂ from the apex, else −1


def bevel_of(m: Description, gear: Gear) -> Bevel | None:
    """Return how the axes of wheels in mesh stand; None if they are parallel."""
    here = _Still(m)
    a, b = (here.joints[name] for name in gear.joints)
    assert isinstance(a, Revolute)
    assert isinstance(b, Revolute)
    n, line = here.axis(a), here.axis(b)
    c, s = float(n @ line), float(np.linalg.norm(np.cross(n, line)))
    if s < _NEAR:
        return None
    apart = here.place(b.child) - here.place(a.child)
    r, R = m.evaluate(gear.radius), m.evaluate(gear.other_radius)
    w, W = (line - c * n) / s, (n - c * line) / s
    pairs = [(i, k) for i in (1, -1) for k in (1, -1)]
    sides = min(
        pairs, key=lambda pair: float(np.linalg.norm(pair[0] * r * w - pair[1] * R * W - apart))
    )
    far = sides[0] * r + c * sides[1] * R
    return Bevel(_whole(c), _whole(s), sides, 1 if sides[1] * far > 0 else -1)


def laws_of_elements(m: Description, driven: Mapping[str, Scalar]) -> dict[str, Scalar]:
    """Return the laws that the elements of a mechanism add to its coordinate map."""
    laws, taken = dict(driven), {*driven, *m.coordinates.names}
    free = [name for joint in m.joints for name in joint.coordinates if name not in taken]
    for element in m.elements:
        for row in _rows(m, element):
            _solve(row, laws, free)
    return {name: law for name, law in laws.items() if name not in driven}


def _solve(row: Row, solved: dict[str, Scalar], free: list[str]) -> None:
    """Add the law that keeps a row as it is, if the laws so far do not."""
    laws = {coordinate(name): law for name, law in solved.items()}
    total = plain(sum(factor * coordinate(name) for name, factor in row.items()))
    total = total.subs(laws).expand()
    followed = set[str]().union(*(symbols_in(solved[name]) for name in row if name in solved))
    candidates = [name for name in reversed(row) if name not in followed]
    # where the row follows several others already, one of these follows the rest
    if len(symbols_in(total) & {*free}) > 1:
        candidates += reversed(free)
    for name in candidates:
        slope = total.diff(coordinate(name))
        if name not in free or slope == 0:
            continue
        law = plain((-total.subs({coordinate(name): 0}) / slope).expand())
        if name in symbols_in(law):
            continue
        solved[name] = law
        # what was solved for before may follow this one
        for partner, before in solved.items():
            if partner != name and name in symbols_in(before):
                solved[partner] = plain(before.subs({coordinate(name): law}).expand())
        return


def _rows(m: Description, element: Element) -> Iterator[Row]:
    here = _Still(m)
    match element:
        case Gear() | Rack():
            yield from _of_teeth(here, element)
        case Cord() | Belt():
            yield from _of_cord(here, element)


def _of_teeth(here: _Still, mesh: Gear | Rack) -> Iterator[Row]:
    a, b = (here.joints.get(name) for name in mesh.joints)
    slides = isinstance(mesh, Rack)
    if not isinstance(a, Revolute) or not isinstance(b, Prismatic if slides else Revolute):
        return
    holder = here.find_holder(a, b)
    if holder is None:
        return
    n, line = here.axis(a), here.axis(b)
    if isinstance(mesh, Rack):
        d = here.place(b.child, mesh.point) - here.place(a.child)
        vector = d - (d @ line) * line - (d @ n) * n
        length = float(np.linalg.norm(vector))
        u = vector / length if length > _NEAR else vector
        along, size = float(np.cross(n, u) @ line), 1
    else:
        bevel = bevel_of(here.m, mesh)
        along, size = (1 if mesh.internal else -1) * float(n @ line), mesh.other_radius
        along = along if bevel is None else -float(bevel.sides[0] * bevel.sides[1])
    if abs(abs(along) - 1) > _NEAR:
        return
    turns = here.turns(a, holder)
    moved = here.turns(b, holder) if not slides else here.slides(b, holder)
    if turns is None or moved is None:
        return
    row = {name: mesh.radius * sign for name, sign in turns.items()}
    for name, sign in moved.items():
        row[name] = row.get(name, 0) - round(along) * size * sign
    last = row.pop(b.coordinate)
    yield {**row, b.coordinate: last}


def _of_cord(here: _Still, cord: Cord | Belt) -> Iterator[Row]:
    stops = cord.stops
    axes = here.m.ground if cord.axes == "world" else cord.axes
    known = here.carried.keys() >= {axes, *(stop.body for stop in stops)}
    if not known or any(joint.coordinates for joint in here.carried[axes]):
        return  # its plane may turn
    rows: list[Row] = [{} for _ in cord.forces]
    n = here.m.home_poses[axes][:3, :3] @ np.array(cord.normal)
    for k, part in enumerate(cord.parts):
        e = here.find_direction(stops[k], stops[k + 1], n)
        if e is None:
            return
        start, end = (here.move(stop, e, n) for stop in stops[k : k + 2])
        if start is None or end is None:
            return
        for name in start | end:
            factor = plain(end.get(name, 0) - start.get(name, 0))
            slides = name in here.sliding
            moves_both = name in start and name in end
            if slides and abs(abs(float(factor)) - (not moves_both)) > _NEAR:
                return  # the stretch turns as the slide moves
            step = round(float(factor)) if slides else factor
            rows[part][name] = rows[part].get(name, 0) + step
    for row in rows:
        yield {name: factor for name, factor in row.items() if factor != 0}


def _whole(number: float) -> float:
    """A number that is whole except for rounding, as a whole one."""
    return float(round(number)) if abs(number - round(number)) < 1e-15 else number


@final
class _Still:
    """Where the bodies of a mechanism are with all joint coordinates at zero."""

    def __init__(self, m: Description) -> None:
        self.m = m
        self.joints = {joint.name: joint for joint in m.joints}
        self.carried: dict[str, tuple[Joint, ...]] = {m.ground: ()}
        """The joints from the ground to each body."""
        self.sliding = {j.coordinate for j in m.joints if isinstance(j, Prismatic)}
        for joint in m.tree:
            self.carried[joint.child] = (*self.carried[joint.parent], joint)

    def axis(self, joint: Single) -> np.ndarray:
        """Return the axis of a joint."""
        direction: np.ndarray = self.m.home_poses[joint.child][:3, :3] @ np.array(joint.axis)
        return direction

    def place(self, body: str, point: Any = (0.0, 0.0, 0.0)) -> np.ndarray:
        """Return a point of a body."""
        pose = self.m.home_poses[body]
        position: np.ndarray = pose[:3, 3] + pose[:3, :3] @ np.array(self.m.evaluate_all(point))
        return position

    def find_holder(self, a: Single, b: Single) -> str | None:
        """Return the body in which the axes of two joints rest, if one carries the other."""
        for inner, outer in ((a, b), (b, a)):
            path = [self.m.ground, *(joint.child for joint in self.carried[outer.parent])]
            if inner.parent in path:
                return outer.parent
        return None

    def turns(self, joint: Single, holder: str) -> dict[str, int] | None:
        """Return how hinges turn what a joint carries against a body, about the joint's axis."""
        shares = dict[str, int]()
        for hinge, sign in self._between(joint.child, holder):
            along = float(self.axis(hinge) @ self.axis(joint)) if isinstance(hinge, Single) else 0
            if not isinstance(hinge, Revolute) or abs(abs(along) - 1) > _NEAR:
                return None
            shares[hinge.coordinate] = sign if along > 0 else -sign
        return shares

    def slides(self, joint: Single, holder: str) -> dict[str, int] | None:
        """Return the same of a slide on that body."""
        path = [passed for passed, _ in self._between(joint.child, holder)]
        return {joint.coordinate: 1} if path == [joint] else None

    def find_direction(
        self, start: CordStop, end: CordStop, normal: np.ndarray
    ) -> np.ndarray | None:
        """Return the direction of a stretch of cord; None if there is no room for it."""
        d = self.place(end.body, end.center) - self.place(start.body, start.center)
        reach = [self.m.evaluate(stop.radius) * stop.sense for stop in (start, end)]
        h, square = reach[1] - reach[0], float(d @ d)
        if not square > h * h or abs(d @ normal) > _NEAR * np.sqrt(square):
            return None
        e: np.ndarray = (np.sqrt(square - h * h) * d + h * np.cross(d, normal)) / square
        return e

    def move(self, stop: CordStop, e: np.ndarray, normal: np.ndarray) -> dict[str, Scalar] | None:
        """Return how joints move the end of a stretch along it; None if one also turns it."""
        shares = dict[str, Scalar]()
        for joint in self.carried[stop.body]:
            if isinstance(joint, Prismatic):
                shares[joint.coordinate] = float(e @ self.axis(joint))
            elif isinstance(joint, Revolute):
                along = float(self.axis(joint) @ normal)
                off = self.place(stop.body, stop.center) - self.m.home_poses[joint.child][:3, 3]
                if abs(abs(along) - 1) > _NEAR or abs(np.cross(off, normal)).max() > _NEAR:
                    return None
                shares[joint.coordinate] = stop.radius * stop.sense * round(along)
            elif joint.coordinates:
                return None
        return shares

    def _between(self, body: str, holder: str) -> list[tuple[Joint, int]]:
        """The joints that move a body against another, with the sign of each."""
        inner, outer = self.carried[body], self.carried[holder]
        mine = [(joint, 1) for joint in inner if joint not in outer and joint.coordinates]
        return mine + [(joint, -1) for joint in outer if joint not in inner and joint.coordinates]
