"""Say in words what a coordinate measures: which body it moves, along what, or from where."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from typing import final

import numpy as np

from mecanique.derivation.tolerances import ALIGNED
from mecanique.derivation.tree.links import links
from mecanique.derivation.tree.poses import Arithmetic, joint_values, poses
from mecanique.model import Joint, Loop, Mechanism, Planar, Universal, coordinate
from mecanique.model.expression import Scalar, plain, symbols_in
from mecanique.model.joint_base import UNITS, BaseJoint, Single
from mecanique.model.mechanism.letters import call
from mecanique.model.mechanism_units import units
from mecanique.wording import enumerate_words

_PARTS = ("x component", "y component", "z component", "scalar part")

_STEP = 1e-4
"""A coordinate of the map is changed by so much to see which point it moves as much."""


@final
class CoordinateWords:
    """The meaning of each coordinate of a mechanism, as its joints and bodies tell it."""

    def __init__(self, mechanism: Mechanism) -> None:
        self._mechanism = mechanism
        self._bodies = {body.name: body for body in mechanism.bodies}
        self._leads = {joint.child: joint for joint in mechanism.tree}
        self._beyond: dict[str, list[Joint]] = defaultdict(list)
        for joint in mechanism.tree:
            self._beyond[joint.parent].append(joint)
        # where a loop joins it, a massless rod ends
        self._closed: dict[str, list[np.ndarray]] = defaultdict(list)
        loops = (*mechanism.loops, *(e for e in mechanism.elements if isinstance(e, Loop)))
        for loop in loops:
            self._closed[loop.body_a].append(self._read(loop.frame_a.xyz))
            self._closed[loop.body_b].append(self._read(loop.frame_b.xyz))
        self._falls = self._read(mechanism.gravity) @ (0.0, 0.0, 1.0) < 0.0
        self.of_joints = dict(pair for joint in mechanism.joints for pair in self._explain(joint))
        """That of each joint's coordinates, by name; those that the map gives among them."""

    def sentences(self) -> Iterator[tuple[str, str]]:
        """Yield the meanings of the generalized coordinates, and of velocities without one."""
        for name in self._mechanism.coordinates:
            stated = self.of_joints.get(name) or self._say_absolute(name)
            yield name, stated or self._say_of_map(name)
        for joint in self._mechanism.joints:
            for velocity in joint.velocities if joint.quaternion else ():
                linear = velocity in joint.linear_velocities
                what, unit = ("velocity", "m/s") if linear else ("angular velocity", "rad/s")
                of = f"the {what} of {self._name_child(joint)}, in its own axes [{unit}]"
                yield velocity, f"{velocity[-1]} component of {of}"

    def _explain(self, joint: Joint) -> Iterator[tuple[str, str]]:
        """Yield name and meaning of each coordinate of a joint."""
        names = [name for name in joint.coordinates if name not in joint.followers]
        child = call(joint.child)
        match joint:
            case Single() if joint.turns:
                sentences = [f"{self._say_angle(joint)} [rad]"]
            case Single():
                sentences = [f"{self._say_slide(joint)} [m]"]
            case Planar():
                ways = [self._say_direction(axis, joint) for axis in joint.directions]
                sentences = [f"displacement of {child} along {way} [m]" for way in ways]
                sentences.append(
                    f"rotation of {child} about {self._say_direction(joint.axis, joint)} [rad]"
                )
            case Universal():
                sentences = [
                    f"rotation of {child} about {axis} of the Cardan joint {joint.name} [rad]"
                    for axis in ("x", "the turned y")
                ]
            case _:
                linear = zip("xyz", joint.linear_coordinates, strict=False)
                moved = self._name_child(joint)
                sentences = [f"{axis} coordinate of {moved} [m]" for axis, _ in linear]
                parts = zip(_PARTS, joint.quaternion, strict=False)
                sentences += [f"{part} of the unit quaternion of {child}" for part, _ in parts]
        yield from zip(names, sentences, strict=True)
        kinds = dict(zip(joint.coordinates, joint.kinds, strict=True))
        for name in joint.followers:
            yield name, f"dependent coordinate of joint {joint.name} [{UNITS[kinds[name]]}]"

    def _say_angle(self, hinge: Single) -> str:
        """Say from which direction a hinge turns a body, or about what, relative to what."""
        about, led = self._say_direction(hinge.axis, hinge), self._follow(hinge.child)
        moved = call(led)
        every = [*self._ascend(hinge.parent)]
        straight = not any(map(self._is_turned, (hinge, *every)))
        turning = [joint for joint in every if isinstance(joint, Single) and joint.turns]
        moving = [joint for joint in every if joint.coordinates and not isinstance(joint, Single)]
        way = self._reach(hinge.child, np.array(hinge.axis))
        if straight and not moving and (start := self._name_way(way)):
            # a direction about which all above turns keeps its place in the world
            if not turning:
                return f"angle of {moved} from {start}, {self._say_sense(hinge, way, about)}"
            if all(np.abs(np.cross(joint.axis, way)).max() < ALIGNED for joint in turning):
                return f"angle of {moved} from {start}, about {about}"
        bare = about.replace(f" of {call(hinge.parent)}", "", 1)
        if not (turning or moving):
            frames = [np.array([*map(self._read, joint.origin.rotation)]) for joint in every]
            axis = np.array(hinge.axis)
            level = all(np.abs(frame @ axis - axis).max() < ALIGNED for frame in frames)
            return f"rotation of {moved} about {bare if level else about}"
        if not self._bodies[hinge.parent].shapes:
            own = led == hinge.child
            return f"rotation of {moved} about {f'its axis {bare}' if own else about}"
        seat = self._read(hinge.origin.xyz)
        arm = seat - (seat @ hinge.axis) * np.array(hinge.axis)
        line = arm.any() and np.abs(arm / np.linalg.norm(arm) - way).max() < ALIGNED
        what = "angle" if way.any() else "rotation"
        zero = ", zero in line" if line and straight else ""
        return f"{what} of {moved} relative to {call(hinge.parent)}, about {bare}{zero}"

    def _say_absolute(self, name: str) -> str:
        """Say which body an angle is that of, as the sum of those in parallel hinges, or ""."""
        turned = dict[str, tuple[Single, Scalar]]()
        driven = self._mechanism.coordinates.driven
        for joint in self._mechanism.tree:
            if not (isinstance(joint, Single) and joint.turns) or self._is_turned(joint):
                continue
            first, angle = turned.get(joint.parent, (joint, 0.0))
            grounded = joint.parent == self._mechanism.ground
            if first.axis == joint.axis and (first is not joint or grounded):
                (turn,) = joint.coordinates
                whole = plain(angle) + plain(driven.get(turn, coordinate(turn)))
                turned[joint.child] = first, whole
                if whole == coordinate(name):
                    about = self._say_direction(first.axis, first)
                    way = self._reach(joint.child, np.array(joint.axis))
                    if start := self._name_way(way):
                        sense = self._say_sense(first, way, about)
                        return f"angle of {call(joint.child)} from {start}, {sense} [rad]"
                    return f"absolute angle of {call(joint.child)}, about {about} [rad]"
        return ""

    def _say_of_map(self, name: str) -> str:
        """Say which point a coordinate of the map displaces by itself, or what it sets."""
        mechanism = self._mechanism
        driven, unit = mechanism.coordinates.driven.items(), units(mechanism)[name]
        needed = frozenset().union(*(symbols_in(law) for _, law in driven))
        known = unit == "m" and needed <= {*mechanism.coordinates, *mechanism.values, "t"}
        at, moved = (self._place_points(name, x) if known else {} for x in (0, 1))
        for point in at:
            step = (moved[point] - at[point]) / _STEP
            for k, axis in enumerate("xyz"):
                if abs(abs(step[k]) - 1) < _STEP:
                    way = f"{'-' if step[k] < 0 else ''}{axis}"
                    return f"displacement of {call(point)} along {way} [m]"
        follow = [joint for joint, law in driven if name in symbols_in(law)]
        sets = f" that sets {enumerate_words(follow)}" if follow else ""
        return f"generalized coordinate{sets}{'' if unit in ('', '1') else f' [{unit}]'}"

    def _place_points(self, name: str, steps: int) -> dict[str, np.ndarray]:
        """Return where the bodies' centers of mass and the joints are, a coordinate at a step."""
        mechanism, tree = self._mechanism, links(self._mechanism)
        start = dict(zip(mechanism.coordinates, mechanism.position({}).tolist(), strict=True))
        values = {**mechanism.values, **start, "t": 0.0, name: start[name] + steps * _STEP}
        with np.errstate(all="ignore"):  # at zero, roots and inverse functions may have no value
            placed = poses(tree, joint_values(mechanism, values, Arithmetic()), Arithmetic())
        frames = [(link, np.array(pose, float)) for link, pose in zip(tree, placed, strict=True)]
        points = {
            link.body: frame @ [*self._read(self._bodies[link.body].center), 1.0]
            for link, frame in frames
            if link.body is not None and self._weighs(link.body)
        }
        joints = {link.joint: frame[:, 3] for link, frame in frames}
        return points | {name: at for name, at in joints.items() if name not in points}

    def _say_slide(self, slide: Single) -> str:
        """Say where a slide places what it leads, or how far it moves it, and from what."""
        moved, hinge = self._follow(slide.child), self._leads.get(slide.parent)
        chain, center = [*self._ascend(moved)], self._read(self._bodies[moved].center)
        slides = [x for x in chain if isinstance(x, Single) and not x.turns]
        carriers = [x for x in self._ascend(slide.parent) if x in slides]
        apart = sum(abs(np.dot(slide.axis, other.axis)) for other in slides) < 1 + ALIGNED
        placed = len(chain) > 1 and chain[len(chain) - len(carriers) - 1] is slide and apart
        placed = placed and not any(self._read(joint.origin.xyz).any() for joint in chain)
        placed = placed and not any(map(self._is_turned, chain[:-1]))
        if placed and not any(self._weighs(joint.child) for joint in carriers):
            point = "origin" if center.any() else "center"
            along = self._say_direction(slide.axis, [slide, *carriers][-1])
            return f"position of the {point} of {call(moved)} along {along}"
        seated = self._read(slide.origin.xyz).any() or center.any()
        if isinstance(hinge, Single) and hinge.turns and not (seated or self._weighs(slide.parent)):
            # phi names an angle and no hinge
            where = f"axis of {hinge.name}"
            if hinge.name not in hinge.coordinates:  # once where kind and name are the same word
                where = hinge.noun if hinge.name == hinge.noun else f"{hinge.noun} {hinge.name}"
            return f"distance of {call(moved)} from the {where}"
        along = self._say_direction(slide.axis, slide).removesuffix(f" of {call(slide.parent)}")
        relative = (
            "" if slide.parent == self._mechanism.ground else f" relative to {call(slide.parent)}"
        )
        return f"displacement of {call(moved)}{relative} along {along}"

    def _reach(self, body: str, axis: np.ndarray) -> np.ndarray:
        """Return the direction across an axis in which a body lies from its origin, or zero."""
        arms = [self._read(self._bodies[body].center)] if self._weighs(body) else []
        beyond = self._beyond[body][:1] if len(self._beyond[body]) == 1 else []
        arms += self._closed.get(body, [])
        for joint in beyond:
            seat = joint.origin.xyz
            arms.append(
                self._read(joint.axis if isinstance(joint, Single) and not joint.turns else seat)
            )
        for arm in arms:
            across = arm - (arm @ axis) * axis
            if (size := float(np.linalg.norm(across))) > ALIGNED:
                return np.asarray(across / size)
        if beyond and not self._weighs(body) and not self._is_turned(beyond[0]):
            return self._reach(beyond[0].child, axis)
        return np.zeros(3)

    def _say_sense(self, hinge: Single, way: np.ndarray, about: str) -> str:
        """Say where a hinge turns a direction first."""
        ahead = np.cross(hinge.axis, way)
        vertical = {1: "positive upwards", -1: "positive downwards"}
        for k, axis in enumerate("xyz"):
            if abs(ahead[k]) > 1 - ALIGNED:
                sign = 1 if ahead[k] > 0 else -1
                level = f"positive towards {'+' if sign > 0 else '-'}{axis}"
                return vertical[sign] if axis == "z" and self._falls else level
        return f"about {about}"

    def _name_way(self, way: np.ndarray) -> str:
        """Name a direction of the world, "" if it is none of the axes."""
        for k, axis in enumerate("xyz"):
            if abs(way[k]) > 1 - ALIGNED:
                if axis == "z" and self._falls:
                    return f"the {'up' if way[k] > 0 else 'down'}ward vertical"
                return f"the {'-' if way[k] < 0 else ''}{axis} axis"
        return ""

    def _follow(self, body: str) -> str:
        """Name the body that carriers without a shape lead; the carrier if several or none."""
        led = body
        while not self._bodies[led].shapes:
            if len(self._beyond[led]) != 1:
                return body
            led = self._beyond[led][0].child
        return led

    def _ascend(self, body: str) -> Iterator[Joint]:
        """Yield the joints from a body to the ground."""
        while body in self._leads:
            yield self._leads[body]
            body = self._leads[body].parent

    def _weighs(self, body: str) -> bool:
        return bool(self._mechanism.evaluate(self._bodies[body].mass))

    def _is_turned(self, joint: BaseJoint) -> bool:
        return any(not isinstance(angle, float) or angle for angle in joint.origin.rpy)

    def _read(self, vector: tuple[Scalar, ...]) -> np.ndarray:
        return np.array(self._mechanism.evaluate_all(vector), dtype=float)

    def _name_child(self, joint: Joint) -> str:
        """Name what a joint moves, and relative to what if that is not the ground."""
        grounded = joint.parent == self._mechanism.ground
        child = call(joint.child)
        return child if grounded else f"{child} relative to {call(joint.parent)}"

    def _say_direction(self, axis: tuple[float, float, float], joint: BaseJoint) -> str:
        """Put an axis in words, of its parent if that is not the ground, or of a turned frame."""
        of = "" if joint.parent == self._mechanism.ground else f" of {call(joint.parent)}"
        if self._is_turned(joint):
            turns = [(way, plain(x)) for way, x in zip("xyz", joint.origin.rpy, strict=True)]
            tilts = [f", turned by {tilt} about {way}" for way, tilt in turns if symbols_in(tilt)]
            lettered = tilts and sum(tilt != 0 for _, tilt in turns) == 1
            of = f"{of}{tilts[0]}" if lettered else f" of the frame of joint {joint.name}"
        for name, component in zip("xyz", axis, strict=True):
            if abs(component) > 1 - ALIGNED:
                return f"{'-' if component < 0 else ''}{name}{of}"
        return f"({', '.join(f'{component:.6g}' for component in axis)}){of}"
