"""Mechanism -> SDF."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import final

from mecanique.formats.scope import (
    SCOPES,
    THICKENED,
    is_closed,
    is_empty,
    joint_damping,
    joint_spring,
    lifted_share,
)
from mecanique.model.bodies import Body
from mecanique.model.bodies.visuals import Mesh, Visual
from mecanique.model.joint_base import Limits, Single
from mecanique.model.joints import Fixed, Floating, Helical, Joint, Universal
from mecanique.model.mechanism import Mechanism
from mecanique.model.placement import Placement
from mecanique.urdf.dialect import DRAKE_NAMESPACE, UNBOUNDED, WORLD
from mecanique.urdf.markup import Node, Tag, number, numbers, text
from mecanique.urdf.names import Names
from mecanique.urdf.write import SimpleJoint, axial_steps, chains, law_of_follower, measure_in_words

_VERSION = "1.11"
"""The first that states mimics."""


def write_sdf(mechanism: Mechanism) -> str:
    """Return a mechanism as SDF text, without what `mecanique.formats.scope` lists as lost.

    Frames are those of the mechanism; a body without mass that is fixed to another is a frame of
    it. Loops are plain joints, rotors tags of Drake's. What has symbols is written with their
    values.
    """
    model = Tag("model", *_Writer(mechanism).parts(), name=mechanism.name)
    gravity = numbers(mechanism.evaluate_all(mechanism.gravity), "gravity")
    world = Tag("world", Tag("gravity", content=gravity), model, name=mechanism.name)
    whole = Tag("sdf", world, version=_VERSION, **{"xmlns:drake": DRAKE_NAMESPACE})
    return name_in_sdf(text(whole))


def name_in_sdf(name: str) -> str:
    """Return a name, or a text of names, without what SDF keeps for names in other models."""
    return name.replace("::", "__")


@final
class _Writer:
    def __init__(self, mechanism: Mechanism) -> None:
        self._mechanism = mechanism
        self._steps = chains(mechanism)
        self._axial = axial_steps(mechanism)
        self._bodies = {body.name: body for body in mechanism.bodies}
        # links and joints share their names' room in SDF; joints keep theirs
        names = Names(step.name for chain in self._steps.values() for step in chain)
        for loop in mechanism.loops:
            names.free(loop.name)
        carried = (step.child for chain in self._steps.values() for step in chain)
        self._names = {body: names.free(body) for body in dict.fromkeys((*self._bodies, *carried))}
        ground = self._bodies[mechanism.ground]
        self._stands = ground.name != WORLD and not is_empty(mechanism, ground)
        self._lifted = {
            force.bodies[0] for force in mechanism.forces if lifted_share(mechanism, force) == 1
        }

    def parts(self) -> Iterator[Node]:
        """Yield links, frames and joints of the model."""
        mechanism = self._mechanism
        if self._stands:
            ground = mechanism.ground
            yield self._link(self._bodies[ground], {})
            ends = WORLD, self._name(ground)
            yield _joint(f"{ground}_weld", "fixed", ends, _pose((0, 0, 0), (0, 0, 0)))
        for joint in mechanism.joints:
            yield from self._carry(joint)
        poses = mechanism.home_poses
        kinds = {"weld": "fixed", "ball": "ball", "hinge": "revolute"}
        for loop in mechanism.loops:
            if loop.kind in kinds and is_closed(mechanism, loop, poses):
                axis = [_axis((0.0, 0.0, 1.0))] if loop.kind == "hinge" else []
                ends = self._name(loop.body_a), self._name(loop.body_b)
                place = self._pose(loop.frame_a)
                yield _joint(loop.name, kinds[loop.kind], ends, place, axis)

    def _name(self, body: str) -> str:
        grounded = body == self._mechanism.ground and not self._stands
        return WORLD if grounded else self._names[body]

    def _pose(self, place: Placement) -> str:
        return _pose(*map(self._mechanism.evaluate_all, (place.xyz, place.rpy)))

    def _carry(self, joint: Joint) -> Iterator[Node]:
        """Yield a joint, and the link it carries, whose frame is the joint's."""
        mechanism, body = self._mechanism, self._bodies[joint.child]
        parent, place = self._name(joint.parent), self._pose(joint.origin)
        if isinstance(joint, Floating):
            yield self._link(body, {}, place)
            return
        if isinstance(joint, Fixed) and is_empty(mechanism, body) and parent != WORLD:
            name = self._name(body.name)
            yield Tag("frame", Tag("pose", content=place), name=name, attached_to=parent)
            return
        name, ends = joint.name, (parent, self._name(joint.child))
        if isinstance(joint, Universal):
            axes = [_axis((1.0, 0.0, 0.0)), _axis((0.0, 1.0, 0.0), tag="axis2")]
            yield _joint(name, "universal", ends, place, axes)
        elif isinstance(joint, Helical):
            travel = number(2 * math.pi * mechanism.evaluate(joint.pitch), name)
            inside = [Tag("screw_thread_pitch", content=travel)]
            inside += self._moves(joint, self._steps[name][-1])
            yield _joint(name, "screw", ends, place, inside)
        else:
            for step in self._steps[name]:
                ends = self._name(step.parent), self._name(step.child)
                inside = [*self._moves(joint, step)]
                yield _joint(step.name, step.kind, ends, _pose(step.xyz, step.rpy), inside)
                if step.child != joint.child:
                    yield self._link(Body(step.child), {"relative_to": step.name})
        yield self._link(body, {"relative_to": name})

    def _link(self, body: Body, stated: dict[str, str], place: str = "") -> Tag:
        inside: list[Node] = []
        if place or stated:
            inside.append(Tag("pose", content=place or _pose((0, 0, 0), (0, 0, 0)), **stated))
        if body.name in self._lifted:
            inside.append(Tag("gravity", content="0"))
        evaluate = self._mechanism.evaluate_all
        where, names = f"body {body.name!r}", ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
        mass, entries = self._mechanism.evaluate(body.mass), evaluate(body.inertia)
        if not mass > 0:  # SDF would take 1 kg
            mass, entries = THICKENED, [*(e + THICKENED for e in entries[:3]), *entries[3:]]
        pairs = zip(names, entries, strict=True)
        moments = (Tag(name, content=number(entry, where)) for name, entry in pairs)
        center = _pose(evaluate(body.center), (0, 0, 0))
        parts = (Tag("pose", content=center), Tag("mass", content=number(mass, where)))
        inside.append(Tag("inertial", *parts, Tag("inertia", *moments)))
        inside += [self._visual(visual, k) for k, visual in enumerate(body.visuals)]
        return Tag("link", *inside, name=self._names[body.name])

    def _visual(self, visual: Visual, index: int) -> Tag:
        kind, measures = measure_in_words(self._mechanism, visual.geometry, "a visual")
        inside = [Tag(name, content=words) for name, words in measures.items()]
        if isinstance(visual.geometry, Mesh):
            inside.insert(0, Tag("uri", content=visual.geometry.uri))
        shape = Tag(kind, *inside)
        parts = [Tag("pose", content=self._pose(visual.placement)), Tag("geometry", shape)]
        if visual.rgba is not None:
            color = Tag("diffuse", content=numbers(visual.rgba, "a color"))
            parts.append(Tag("material", color))
        return Tag("visual", *parts, name=f"visual_{index}")

    def _moves(self, joint: Joint, step: SimpleJoint) -> Iterator[Tag]:
        """Yield the axis of a joint with its limits, spring, damper, law and rotor."""
        if step.axis is None:
            return
        mechanism, where = self._mechanism, f"joint {step.name!r}"
        inside: list[Node] = [*_limits(step.limits, where)]
        single = isinstance(joint, Single) and step.name == joint.name
        if single:
            stiffness, reference = joint_spring(mechanism, joint.name)
            named = {
                "damping": joint_damping(mechanism, joint.name),
                "spring_stiffness": stiffness,
                "spring_reference": reference,
            }
            given = {name: value for name, value in named.items() if value}
            states = [Tag(name, content=number(value, where)) for name, value in given.items()]
            inside += [Tag("dynamics", *states)] if states else []
        if step.coordinate in mechanism.coordinates.driven:
            law = law_of_follower(mechanism, self._axial, step.coordinate, SCOPES["SDF"].degree)
            if law is not None and law[0]:
                leader, (offset, factor) = law
                given = {"multiplier": factor, "offset": offset, "reference": 0.0}
                states = [Tag(name, content=number(value, where)) for name, value in given.items()]
                inside.append(Tag("mimic", *states, joint=leader))
        yield _axis(step.axis, inside)
        if isinstance(joint, Single) and single and (rotor := mechanism.evaluate(joint.armature)):
            yield Tag("drake:rotor_inertia", content=number(rotor, where))
            yield Tag("drake:gear_ratio", content="1")


def _pose(xyz: Sequence[float], rpy: Sequence[float]) -> str:
    return f"{numbers(xyz, 'a pose')} {numbers(rpy, 'a pose')}"


def _joint(
    name: str, kind: str, ends: tuple[str, str], place: str, inside: Sequence[Node] = ()
) -> Tag:
    base = "__model__" if ends[0] == WORLD else ends[0]
    pose = Tag("pose", content=place, relative_to=base)
    parent, child = Tag("parent", content=ends[0]), Tag("child", content=ends[1])
    return Tag("joint", pose, parent, child, *inside, name=name, type=kind)


def _axis(axis: Sequence[float], inside: Sequence[Node] = (), tag: str = "axis") -> Tag:
    return Tag(tag, Tag("xyz", content=numbers(axis, "an axis")), *inside)


def _limits(limits: Limits | None, where: str) -> Iterator[Tag]:
    if limits is None:
        return
    bounds = {
        name: value
        for name in ("lower", "upper", "effort", "velocity")
        if abs(value := getattr(limits, name)) < UNBOUNDED
    }
    if bounds:
        stated = (Tag(name, content=number(value, where)) for name, value in bounds.items())
        yield Tag("limit", *stated)
