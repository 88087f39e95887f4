"""Mechanism -> MJCF, with a list of what MJCF cannot express."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import final

from mecanique.model.constraints.loops import Loop
from mecanique.model.expression import plain, symbols_in
from mecanique.model.force_base import AnyForce
from mecanique.model.forces import Damper, JointDamper, JointSpring, Spring
from mecanique.model.joint_base import Single
from mecanique.model.joints import Joint
from mecanique.model.mechanism import Mechanism
from mecanique.model.placement import Placement
from mecanique.urdf.markup import Node, Tag, number, numbers, text
from mecanique.urdf.write import SimpleJoint, chains

_KINDS = {"continuous": "hinge", "revolute": "hinge", "prismatic": "slide", "ball": "ball"}


def write_mjcf(mechanism: Mechanism) -> tuple[str, tuple[str, ...]]:
    """Return a mechanism as MJCF text, and in a line each what the format cannot express.

    Frames are those of the mechanism; angles are in radians, rpy turns about fixed axes. What has
    symbols is written with their values.
    """
    writer = _Writer(mechanism)
    written = text(Tag("mujoco", *writer.sections(), model=mechanism.name))
    return written, tuple(writer.lost)


@final
class _Writer:
    def __init__(self, mechanism: Mechanism) -> None:
        self._mechanism = mechanism
        self._steps = chains(mechanism)
        self._carried: dict[str, list[Joint]] = {}
        for joint in mechanism.joints:
            self._carried.setdefault(joint.parent, []).append(joint)
        self._sites: dict[str, list[Tag]] = {}
        self.lost: list[str] = []

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
        for contact in mechanism.contacts:
            self.lost.append(f"contact {contact.name}: MJCF has no rolling without slip")
        for constraint in mechanism.velocity_constraints:
            self.lost.append(f"velocity constraint {constraint.name}: MJCF has none")
        for law in mechanism.switching:
            self.lost.append(f"{type(law).__name__.lower()} {law.name}: not written")
        for element in mechanism.elements:
            self.lost.append(f"{type(element).__name__.lower()} {element.name}: not written")

    def _contents(self, body: str) -> Iterator[Node]:
        """Yield the sites of a body and the bodies it carries."""
        yield from self._sites.get(body, ())
        for joint in self._carried.get(body, ()):
            yield self._body(joint)

    def _body(self, joint: Joint) -> Tag:
        where = f"joint {joint.name!r}"
        place = {"name": joint.child, **self._pose(joint.origin, where)}
        steps = [*self._joints(joint)]
        inertial = [*self._inertial(joint.child)]
        if steps and not inertial and not self._carried.get(joint.child):
            self.lost.append(f"body {joint.child}: MuJoCo refuses moving bodies without mass")
        if joint.followers:
            self.lost.append(f"{where}: MJCF has no screw")
        return Tag("body", *inertial, *steps, *self._contents(joint.child), **place)

    def _pose(self, place: Placement, where: str) -> dict[str, str]:
        xyz = self._mechanism.evaluate_all(place.xyz)
        rpy = self._mechanism.evaluate_all(place.rpy)
        pose = {"pos": numbers(xyz, where)}
        if any(rpy):
            pose["euler"] = numbers(rpy, where)
        return pose

    def _inertial(self, name: str) -> Iterator[Tag]:
        body = next(body for body in self._mechanism.bodies if body.name == name)
        where = f"body {name!r}"
        mass = self._mechanism.evaluate(body.mass)
        entries = self._mechanism.evaluate_all(body.inertia)
        if mass or any(entries):
            center = numbers(self._mechanism.evaluate_all(body.center), where)
            inertia = numbers(entries, where)
            yield Tag("inertial", pos=center, mass=number(mass, where), fullinertia=inertia)

    def _joints(self, joint: Joint) -> Iterator[Tag]:
        for step in self._steps[joint.name]:
            if step.kind == "floating":
                yield Tag("freejoint", name=step.name)
                if joint.parent != self._mechanism.ground or any(
                    self._mechanism.evaluate_all((*joint.origin.xyz, *joint.origin.rpy))
                ):
                    self.lost.append(f"joint {joint.name}: free joints start at the world's frame")
            elif step.kind != "fixed":
                yield Tag("joint", **self._moves(joint, step))

    def _moves(self, joint: Joint, step: SimpleJoint) -> dict[str, str]:
        where = f"joint {step.name!r}"
        attributes = {"name": step.name, "type": _KINDS[step.kind]}
        if step.axis is not None:
            attributes["axis"] = numbers(step.axis, where)
        if step.limits is not None and step.limits.bounded:
            reach = max(step.limits.lower, -1e9), min(step.limits.upper, 1e9)
            attributes["range"] = numbers(reach, where)
        if not isinstance(joint, Single) or step.name != joint.name:
            return attributes
        evaluate = self._mechanism.evaluate
        armature = evaluate(joint.armature)
        if armature:
            attributes["armature"] = number(armature, where)
        forces = [force for force in self._mechanism.forces if _holds(force, joint.name)]
        springs = [force for force in forces if isinstance(force, JointSpring)]
        stiffness = sum(evaluate(spring.stiffness) for spring in springs)
        damping = sum(evaluate(f.damping) for f in forces if isinstance(f, JointDamper))
        if stiffness:
            # several springs are one at the mean of their references
            pull = sum(evaluate(s.stiffness) * evaluate(s.reference) for s in springs)
            attributes["stiffness"] = number(stiffness, where)
            attributes["springref"] = number(pull / stiffness, where)
        if damping:
            attributes["damping"] = number(damping, where)
        return attributes

    def _site(self, name: str, body: str, pose: Mapping[str, str]) -> None:
        self._sites.setdefault(body, []).append(Tag("site", name=name, **pose))

    def _tendons(self) -> Iterator[Tag]:
        evaluate = self._mechanism.evaluate
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
            elif not isinstance(force, JointSpring | JointDamper):
                self.lost.append(f"{force.kind} {force.name}: MJCF states no such force")

    def _equalities(self) -> Iterator[Tag]:
        for loop in self._mechanism.loops:
            if loop.kind not in ("ball", "weld"):
                self.lost.append(f"loop {loop.name}: MJCF has none of the kind {loop.kind!r}")
                continue
            yield self._closure(loop)
        for name, law in self._mechanism.coordinates.driven.items():
            if any(name in joint.followers for joint in self._mechanism.joints):
                continue
            leaders = symbols_in(law) - self._mechanism.values.keys()
            singles = {
                joint.coordinate: joint.name
                for joint in self._mechanism.joints
                if isinstance(joint, Single)
            }
            if name not in singles or not leaders <= singles.keys() or len(leaders) > 1:
                self.lost.append(f"{name} = {law}: MJCF has no such map")
                continue
            factors = self._polynomial(plain(law), *leaders)
            if factors is None:
                self.lost.append(f"{name} = {law}: MJCF knows polynomials of degree four alone")
                continue
            tied = {"joint1": singles[name], "polycoef": numbers(factors, name)}
            for leader in leaders:
                tied["joint2"] = singles[leader]
            yield Tag("joint", **tied)

    def _polynomial(self, law: object, leader: str = "") -> list[float] | None:
        from sympy import Poly, PolynomialError, Symbol, sympify

        try:
            poly = Poly(sympify(law), Symbol(leader or "_"))
            factors = [self._mechanism.evaluate(c) for c in reversed(poly.all_coeffs())]
        except (PolynomialError, TypeError, ValueError):
            return None
        return [*factors, *([0.0] * (5 - len(factors)))] if len(factors) <= 5 else None

    def _closure(self, loop: Loop) -> Tag:
        sites = {}
        for k, (body, frame) in enumerate(
            ((loop.body_a, loop.frame_a), (loop.body_b, loop.frame_b)), 1
        ):
            sites[f"site{k}"] = f"{loop.name}_{k}"
            self._site(f"{loop.name}_{k}", body, self._pose(frame, f"loop {loop.name!r}"))
        tag = "connect" if loop.kind == "ball" else "weld"
        return Tag(tag, name=loop.name, **sites)


def _holds(force: AnyForce, joint: str) -> bool:
    return isinstance(force, JointSpring | JointDamper) and force.joint == joint
