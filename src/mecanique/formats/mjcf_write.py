"""Mechanism -> MJCF."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import pairwise
from typing import final

import numpy as np

from mecanique.arrays import Array
from mecanique.formats.scope import (
    LENGTH,
    SCOPES,
    THICKENED,
    is_light,
    is_thin,
    joint_damping,
    joint_spring,
    lifted_share,
    list_lengths,
    passes_on,
    tendon_factors,
)
from mecanique.formats.sources import placement_at
from mecanique.model.bodies.visuals import Visual, measure
from mecanique.model.constraints.loops import Loop
from mecanique.model.forces import Damper, Spring
from mecanique.model.joint_base import Single
from mecanique.model.joints import Joint
from mecanique.model.mechanism import Mechanism
from mecanique.model.placement import Placement
from mecanique.urdf.dialect import UNBOUNDED
from mecanique.urdf.markup import Node, Tag, number, numbers, text
from mecanique.urdf.write import SimpleJoint, axial_steps, chains, law_of_follower

_KINDS = {"continuous": "hinge", "revolute": "hinge", "prismatic": "slide", "ball": "ball"}


def write_mjcf(mechanism: Mechanism) -> str:
    """Return a mechanism as MJCF text, without what `mecanique.formats.scope` lists as lost.

    Frames are those of the mechanism; angles are in radians, rpy turns about fixed axes. What has
    symbols is written with their values.
    """
    return text(Tag("mujoco", *_Writer(mechanism).sections(), model=mechanism.name))


@final
class _Writer:
    def __init__(self, mechanism: Mechanism) -> None:
        self._mechanism = mechanism
        self._steps = chains(mechanism)
        self._bodies = {body.name: body for body in mechanism.bodies}
        self._carried: dict[str, list[Joint]] = {}
        self._lengths = list_lengths(mechanism)
        for joint in mechanism.joints:
            if joint.name in self._lengths:
                continue
            self._carried.setdefault(joint.parent, []).append(joint)
        self._sites: dict[str, list[Tag]] = {}
        shares = ((force, lifted_share(mechanism, force)) for force in mechanism.forces)
        self._lifts = {f.bodies[0]: share for f, share in shares if share is not None}

    def sections(self) -> Iterator[Node]:
        mechanism = self._mechanism
        yield Tag(
            "compiler",
            angle="radian",
            eulerseq="XYZ",
            inertiafromgeom="false",
            autolimits="true",
        )
        gravity = numbers(mechanism.evaluate_all(mechanism.gravity), "gravity")
        yield Tag("option", gravity=gravity)
        tendons = [*self._tendons()]
        equalities = [*self._equalities()]
        yield Tag("worldbody", *self._contents(mechanism.ground))
        if tendons:
            yield Tag("tendon", *tendons)
        if equalities:
            yield Tag("equality", *equalities)

    def _contents(self, body: str) -> Iterator[Node]:
        """Yield the sites of a body, what shows it, and the bodies it carries."""
        yield from self._sites.get(body, ())
        for visual in self._bodies[body].visuals:
            yield from self._geom(visual)
        for joint in self._carried.get(body, ()):
            yield self._body(joint)

    def _body(self, joint: Joint) -> Tag:
        """Return the body of a joint, with those behind it that only empty bodies separate."""
        chain = [joint]
        while (behind := passes_on(self._mechanism, chain[-1])) is not None:
            chain.append(behind)
        joint = chain[-1]
        where = f"joint {joint.name!r}"
        place, joints = chain[0].origin, [*self._joints(joint)]
        if len(chain) > 1:
            # the frame of each joint in that of the body, and of the body in its parent
            pose = np.eye(4)
            for before, after in pairwise(reversed(chain)):
                pose = np.linalg.inv(self._mechanism.matrix(before.origin) @ np.linalg.inv(pose))
                joints = [*self._joints(after, pose), *joints]
            place = placement_at(self._mechanism.matrix(chain[0].origin) @ np.linalg.inv(pose))
        attributes = {"name": joint.child, **self._pose(place, where)}
        if joint.child in self._lifts:
            attributes["gravcomp"] = number(self._lifts[joint.child], where)
        contents = self._contents(joint.child)
        return Tag("body", *self._inertial(joint), *joints, *contents, **attributes)

    def _pose(self, place: Placement, where: str) -> dict[str, str]:
        xyz = self._mechanism.evaluate_all(place.xyz)
        rpy = self._mechanism.evaluate_all(place.rpy)
        pose = {"pos": numbers(xyz, where)}
        if any(rpy):
            pose["euler"] = numbers(rpy, where)
        return pose

    def _inertial(self, joint: Joint) -> Iterator[Tag]:
        """Yield mass and inertia of the body that a joint moves."""
        body = self._bodies[joint.child]
        where = f"body {body.name!r}"
        mass = self._mechanism.evaluate(body.mass)
        entries = self._mechanism.evaluate_all(body.inertia)
        light = is_light(self._mechanism, joint, "MJCF")
        mass = THICKENED if light else mass
        if light or is_thin(self._mechanism, joint):
            entries = [*(moment + THICKENED for moment in entries[:3]), *entries[3:]]
        if mass or any(entries):
            center = numbers(self._mechanism.evaluate_all(body.center), where)
            # a fixed body may have no inertia, but MuJoCo takes zeros on a diagonal alone
            form, count = ("fullinertia", 6) if any(entries[3:]) else ("diaginertia", 3)
            inertia = {form: numbers(entries[:count], where)}
            yield Tag("inertial", pos=center, mass=number(mass, where), **inertia)

    def _geom(self, visual: Visual) -> Iterator[Tag]:
        """Yield a geom that touches nothing and has no mass."""
        form, given = measure(visual.geometry)
        if form == "mesh":
            return
        sizes = self._mechanism.evaluate_all(given)
        if form != "sphere":  # half the edges, and half the length behind the radius
            at = 0 if form == "box" else 1
            sizes[at:] = [size / 2 for size in sizes[at:]]
        if not min(sizes) > 0:
            return
        looks = {} if visual.rgba is None else {"rgba": numbers(visual.rgba, "a color")}
        looks |= self._pose(visual.placement, "a visual")
        free = {"contype": "0", "conaffinity": "0", "group": "2", "mass": "0"}
        yield Tag("geom", type=form, size=numbers(sizes, "a visual"), **free, **looks)

    def _joints(self, joint: Joint, pose: Array | None = None) -> Iterator[Tag]:
        """Yield a joint, whose frame has a pose in that of its body."""
        for step in self._steps[joint.name]:
            if step.kind == "floating":
                yield Tag("freejoint", name=step.name)
            elif step.kind != "fixed":
                yield Tag("joint", **self._moves(joint, step, pose))

    def _moves(self, joint: Joint, step: SimpleJoint, pose: Array | None) -> dict[str, str]:
        where = f"joint {step.name!r}"
        attributes = {"name": step.name, "type": _KINDS[step.kind]}
        if pose is not None:
            attributes["pos"] = numbers(pose[:3, 3].tolist(), where)
        if step.axis is not None:
            axis = step.axis if pose is None else (pose[:3, :3] @ step.axis).tolist()
            attributes["axis"] = numbers(axis, where)
        if step.limits is not None and step.limits.bounded:
            reach = max(step.limits.lower, -1e9), min(step.limits.upper, 1e9)
            attributes["range"] = numbers(reach, where)
        if step.limits is not None and 0 < step.limits.effort < UNBOUNDED:
            effort = step.limits.effort
            attributes["actuatorfrcrange"] = numbers((-effort, effort), where)
        if isinstance(joint, Single) and step.name == joint.name:
            attributes |= self._resistance(joint)
        return attributes

    def _resistance(self, joint: Single, rest: str = "springref") -> dict[str, str]:
        """Return rotor, spring and damper of a joint or tendon."""
        where, attributes = f"joint {joint.name!r}", {}
        armature = self._mechanism.evaluate(joint.armature)
        if armature:
            attributes["armature"] = number(armature, where)
        stiffness, reference = joint_spring(self._mechanism, joint.name)
        if stiffness:
            attributes["stiffness"] = number(stiffness, where)
            attributes[rest] = number(reference, where)
        damping = joint_damping(self._mechanism, joint.name)
        if damping:
            attributes["damping"] = number(damping, where)
        return attributes

    def _site(self, name: str, body: str, pose: Mapping[str, str]) -> None:
        self._sites.setdefault(body, []).append(Tag("site", name=name, **pose))

    def _tendons(self) -> Iterator[Tag]:
        evaluate = self._mechanism.evaluate
        for name, joint in self._lengths.items():
            factors = tendon_factors(self._mechanism, name) or {}
            ways = [Tag("joint", joint=k, coef=number(c, name)) for k, c in factors.items()]
            given = self._resistance(joint, "springlength")
            yield Tag("fixed", *ways, name=name.removesuffix(LENGTH), **given)
        for force in self._mechanism.forces:
            if isinstance(force, Spring | Damper):
                ends = [f"{force.name}_{letter}" for letter in "ab"]
                for site, end in zip(ends, force.ends, strict=True):
                    point = numbers(self._mechanism.evaluate_all(end.point), site)
                    self._site(site, end.body, {"pos": point})
                if isinstance(force, Spring):
                    given = {
                        "stiffness": number(evaluate(force.stiffness), force.name),
                        "springlength": number(evaluate(force.free_length), force.name),
                    }
                else:
                    given = {"damping": number(evaluate(force.damping), force.name)}
                sites = [Tag("site", site=site) for site in ends]
                yield Tag("spatial", *sites, name=force.name, **given)

    def _equalities(self) -> Iterator[Tag]:
        mechanism, scope = self._mechanism, SCOPES["MJCF"]
        for loop in mechanism.loops:
            if scope.loops is not None and loop.kind in scope.loops:
                yield self._closure(loop)
        steps = axial_steps(mechanism)
        for name in (k for k in mechanism.coordinates.driven if k not in self._lengths):
            law = law_of_follower(mechanism, steps, name, scope.degree)
            if law is None:
                continue
            leader, factors = law
            tied = {"joint1": steps[name], "polycoef": numbers(factors, name)}
            yield Tag("joint", **tied, **({"joint2": leader} if leader else {}))

    def _closure(self, loop: Loop) -> Tag:
        sites = {}
        for k, (body, frame) in enumerate(
            ((loop.body_a, loop.frame_a), (loop.body_b, loop.frame_b)), 1
        ):
            sites[f"site{k}"] = f"{loop.name}_{k}"
            self._site(f"{loop.name}_{k}", body, self._pose(frame, f"loop {loop.name!r}"))
        tag = "connect" if loop.kind == "ball" else "weld"
        return Tag(tag, name=loop.name, **sites)
