"""Generalized coordinates in a figure: arcs for angles, arrows for distances, each with its symbol.

What a coordinate measures is found by setting it to zero: the first body that then stands elsewhere
has turned by an angle, or moved by a distance.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from mecanique.figure.camera import Floats
from mecanique.figure.marks import Mark, Stroke
from mecanique.figure.setting import Setting
from mecanique.figure.signs import across, arc, arrow, label, unit
from mecanique.figure.solids import unit3
from mecanique.model.joints import Prismatic, Revolute

__all__ = ["coordinates"]

SMALL = 14.0
"""A distance shorter than this is drawn as a direction only [pt]."""

RADIUS = 46.0
"""Of the first arc about a point [pt]."""


def coordinates(setting: Setting) -> Iterator[Mark]:
    """Yield the marks of a mechanism's generalized coordinates.

    Args:
        setting: what is drawn.
    """
    mechanism = setting.mechanism
    inside = {name for j in mechanism.joints if j.quaternion for name in j.coordinates}
    arcs: dict[tuple[int, int], int] = {}
    distances: list[tuple[str, int, float, Floats, Floats]] = []
    for k, name in enumerate(mechanism.coordinates):
        if name in inside:
            continue
        q = setting.q.copy()
        q[k] = 0.0 if abs(q[k]) > 1e-9 else 1e-3
        before = np.asarray(setting.reference.poses(q, setting.t))
        own = [
            j.child for j in mechanism.joints if isinstance(j, Prismatic) and j.coordinate == name
        ]
        body = setting.index(own[0]) if own else _first_moved(setting, before)
        if body is None:
            continue
        value = float(setting.q[k] - q[k])
        turn = setting.poses[body, :3, :3] @ before[body, :3, :3].T
        size = math.acos(min(max((float(np.trace(turn)) - 1) / 2, -1.0), 1.0))
        if abs(math.cos(size) - math.cos(value)) < 1e-6 and size > 1e-9:
            if abs(setting.q[k]) > 1e-9:
                yield from _angle(setting, name, before, body, turn, arcs)
            continue
        moved = _moved(setting, before, body, value)
        if moved is not None:
            distances.append((name, body, value, *moved))
    small = [
        each for each in distances if float(np.linalg.norm(each[4])) * setting.camera.scale < SMALL
    ]
    if len(small) > 1 and _crossing([each[4] for each in small]):
        yield from _triad(
            setting, [(each[0], unit3(each[4]) * math.copysign(1.0, each[2])) for each in small]
        )
        distances = [each for each in distances if each not in small]
    for name, body, value, end, step in distances:
        yield from _distance(setting, name, body, value, end, step)


def _first_moved(setting: Setting, before: Floats) -> int | None:
    for joint in setting.mechanism.tree:
        k = setting.index(joint.child)
        if np.abs(setting.poses[k] - before[k]).max() > 1e-7:
            return k
    return None


def _angle(
    setting: Setting,
    name: str,
    before: Floats,
    body: int,
    turn: Floats,
    arcs: dict[tuple[int, int], int],
) -> Iterator[Mark]:
    from scipy.spatial.transform import Rotation

    camera, middle = setting.camera, setting.poses[body, :3, 3]
    vector = Rotation.from_matrix(turn).as_rotvec()
    angle = float(np.linalg.norm(vector))
    axis = vector / angle
    arm = _arm(setting, before, body, axis)
    key = tuple(int(x) for x in np.round(camera.at(middle) / 6))
    level = arcs.get((key[0], key[1]), 0)
    arcs[key[0], key[1]] = level + 1
    long = float(np.linalg.norm(arm)) * camera.scale
    radius = (min(RADIUS, max(0.55 * long, 24.0)) + 16.0 * level) / camera.scale
    start = unit3(arm) * radius
    steps = np.linspace(0.0, 1.0, 49)
    around = np.array([Rotation.from_rotvec(s * angle * axis).apply(start) for s in steps])
    points = camera.at(middle + around)
    yield Stroke(camera.at(np.array([middle, middle + 1.35 * start])), "axis")
    if not camera.flat:
        yield Stroke(camera.at(np.array([middle, middle + 1.2 * around[-1]])), "axis")
    yield from arc(points, "coordinate")
    center, half = camera.at(middle), points[len(points) // 2]
    away = half - center if math.hypot(*(half - center)) > 6 else np.array([0.0, -1.0])
    yield label(half, name, away, 5.0, "coordinate-letter")


def _arm(setting: Setting, before: Floats, body: int, axis: Floats) -> Floats:
    """From the turning point to the farthest point of what turns, across the axis, before the turn."""
    names = [each.name for each in setting.mechanism.bodies]
    family = {names[body]}
    best, own = np.zeros(3), before[body]
    for joint in (None, *setting.mechanism.tree):
        if joint is not None and joint.parent not in family:
            continue
        if joint is not None:
            family.add(joint.child)
        member = names[body] if joint is None else joint.child
        spans = [
            each.corners if each.kind != "rod" else each.ends
            for each in setting.solids
            if each.body == member
        ]
        world = np.concatenate([*spans, setting.poses[setting.index(member), :3, 3][None]])
        local = (world - setting.poses[body, :3, 3]) @ setting.poses[body, :3, :3]
        arms = local @ own[:3, :3].T
        arms = arms - (arms @ axis)[:, None] * axis
        # the middle of what is broad, its end where it is long
        far = arms[int(np.argmax(np.linalg.norm(arms, axis=1)))]
        mean = arms.mean(axis=0)
        pick = mean if np.linalg.norm(mean) > 0.3 * np.linalg.norm(far) else far
        if np.linalg.norm(pick) > 1e-6 and not np.linalg.norm(best) > 1e-6:
            best = pick
    if np.linalg.norm(best) > 1e-6:
        return best
    side = before[body, :3, 0] - (before[body, :3, 0] @ axis) * axis
    return (
        unit3(side if np.linalg.norm(side) > 0.1 else before[body, :3, 1])
        * 30.0
        / setting.camera.scale
    )


def _moved(
    setting: Setting, before: Floats, body: int, value: float
) -> tuple[Floats, Floats] | None:
    """Where a point is that has moved by the value, and its move: the body's origin, or a point moved along an axis."""
    step = setting.poses[body, :3, 3] - before[body, :3, 3]
    if abs(float(np.linalg.norm(step)) - abs(value)) < 1e-6 * abs(value):
        return setting.poses[body, :3, 3], step
    best: tuple[float, Floats, Floats] | None = None
    for solid in setting.solids:
        k = setting.index(solid.body)
        for spot in (*solid.ends, solid.ends.mean(axis=0)):
            local = setting.poses[k, :3, :3].T @ (spot - setting.poses[k, :3, 3])
            move = spot - (before[k, :3, 3] + before[k, :3, :3] @ local)
            for axis in np.eye(3):
                error = abs(abs(float(move @ axis)) - abs(value))
                if error < 0.02 * abs(value) and (best is None or error < best[0] - 1e-9):
                    best = (error, spot, float(move @ axis) * axis)
    return None if best is None else best[1:]


def _crossing(steps: list[Floats]) -> bool:
    return all(
        abs(float(unit3(a) @ unit3(b))) < 0.9 for k, a in enumerate(steps) for b in steps[:k]
    )


def _triad(setting: Setting, directions: list[tuple[str, Floats]]) -> Iterator[Mark]:
    """Directions of several coordinates that are zero, from one point left of the figure."""
    paper = np.concatenate([setting.paper(body.name) for body in setting.mechanism.bodies])
    origin = np.array([float(paper[:, 0].min()) - 44.0, float(paper[:, 1].max()) - 4.0])
    for name, direction in directions:
        tip = origin + 44.0 * setting.camera.at(direction) / setting.camera.scale
        if math.hypot(*(tip - origin)) < 8:
            continue
        yield from arrow(origin, tip, "coordinate")
        yield label(tip, name, tip - origin, 3.0, "coordinate-letter")


def _distance(
    setting: Setting, name: str, body: int, value: float, end: Floats, step: Floats
) -> Iterator[Mark]:
    """An arrow from where a point is at zero to where it is, beside the body."""
    camera, b = setting.camera, setting.camera.at(end)
    a = camera.at(end - step)
    small = float(np.linalg.norm(step)) * camera.scale < SMALL
    forward = unit3(step) * math.copysign(1.0, value)
    if abs(float(forward @ camera.toward)) > 1 - 1e-6:
        return
    along = unit(camera.at(forward))
    owner = setting.mechanism.bodies[body].name
    hinged = any(isinstance(j, Revolute) and j.parent == owner for j in setting.mechanism.joints)
    side = -across(along)
    downwards = side[1] > 1e-6 or (abs(side[1]) <= 1e-6 and side[0] > 0)
    # what hangs on a body leaves room above it
    if downwards == (hinged and abs(along[0]) > 0.7):
        side = -side
    plate = float(np.ptp(setting.paper(owner) @ side)) < 12 and len(setting.paper(owner)) > 1
    shift = max(setting.reach(owner, side) - float(a @ side), 0.0) + (
        18.0 if side[1] < -0.7 else 30.0
    )
    foot, tip = a + shift * side, b + shift * side
    if small and plate:
        foot = (
            b
            + (setting.reach(owner, along) - float(b @ along) - 62.0) * along
            - 11.0 * np.array([0.0, 1.0])
        )
        tip = foot + 26 * along
    elif small:
        foot, tip = b + shift * side, b + shift * side + 34 * along
    yield Stroke(np.array([foot - 6 * side, foot + 6 * side]), "coordinate")
    if not small:
        yield Stroke(np.array([b + (shift - 12) * side, tip + 5 * side]), "thin")
    yield from arrow(foot, tip, "coordinate")
    if small and plate:
        yield label(foot, name, -along, 5.0, "coordinate-letter")
    else:
        yield label((foot + tip) / 2, name, side, 7.0, "coordinate-letter")
