"""What each format can express, stated once for readers of verdicts and for all writers."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Literal, TypeAlias, final

import numpy as np

from mecanique.arrays import Array
from mecanique.errors import InputError
from mecanique.formats.sources import placement_at, unit_vector
from mecanique.model.bodies import Body
from mecanique.model.bodies.tensor import tensor_of
from mecanique.model.bodies.visuals import Mesh
from mecanique.model.constraints.loops import Loop
from mecanique.model.expression import coordinate, evaluate, plain, symbols_in
from mecanique.model.force_base import AnyForce
from mecanique.model.forces import Damper, Force, JointDamper, JointSpring, Spring, Torque
from mecanique.model.joint_base import Single
from mecanique.model.joints import Fixed, Floating, Joint, Planar, Prismatic, Revolute, Spherical
from mecanique.model.mechanism import Mechanism
from mecanique.model.placement import Placement, pose_along
from mecanique.urdf.dialect import UNBOUNDED
from mecanique.urdf.write import axial_steps, law_of_follower
from mecanique.wording import say_count

Form: TypeAlias = Literal["URDF", "MJCF", "SDF"]

LENGTH = "_length"
"""Behind the name of a tendon, that of a joint which is as far as the tendon is long."""

THICKENED = 2e-15
"""Moment of inertia that a thin rod or a particle gets in MJCF, about every axis [kg·m²].

MuJoCo refuses moving bodies with a mass or a principal moment of 1e-15 or less, and engines that
read SDF take 1 kg instead of none; so in both a body without mass gets it as its mass [kg], too.
"""

_CLOSED = 1e-9
"""How far the frames of a loop may be apart that SDF shows closed, relative to 1 m and to 1."""

_WHOLE = 1e-12
"""How far a force may be from a share of the weight that it is taken for."""


@final
@dataclass(frozen=True)
class Scope:
    """What a format can express."""

    form: Form
    suffixes: tuple[str, ...]  # of its files
    engines: tuple[str, ...]  # that read it by their own parsers
    forces: tuple[type[AnyForce], ...]
    passive: tuple[type[AnyForce], ...] | None  # that its engines compute; None for all it states
    loops: frozenset[str] | None  # kinds; None for all
    degree: int  # of the polynomials by which a joint may follow another
    joints: tuple[type[Joint], ...]  # that move and are not among its own or chains of them
    lifts: Literal["none", "whole", "any"]  # the share of its weight that may be taken off a body
    closed: bool = False  # whether loops are stated by the poses where all coordinates are zero
    dialect: bool = False  # whether tags of this package state what rolls, guides and switches


SCOPES: Mapping[Form, Scope] = {
    scope.form: scope
    for scope in (
        Scope(
            "URDF",
            (".urdf",),
            ("pinocchio", "mujoco"),
            (Spring, Damper, JointSpring, JointDamper),
            (JointDamper,),
            loops=None,
            degree=1,
            joints=(),
            lifts="none",
            dialect=True,
        ),
        Scope(
            "MJCF",
            (".xml", ".mjcf"),
            ("mujoco",),
            (Spring, Damper, JointSpring, JointDamper),
            None,
            loops=frozenset({"ball", "weld"}),
            degree=4,
            joints=(),
            lifts="any",
        ),
        Scope(
            "SDF",
            (".sdf",),
            ("drake",),
            (JointSpring, JointDamper),
            (JointSpring, JointDamper, Torque),
            loops=frozenset({"ball", "weld", "hinge"}),
            degree=1,
            joints=(Planar,),
            lifts="whole",
            closed=True,
        ),
    )
}


def list_losses(mechanism: Mechanism, form: Form) -> tuple[str, ...]:
    """Say in a line each what a format cannot express of a mechanism."""
    return tuple(_losses(mechanism, SCOPES[form]))


def _losses(mechanism: Mechanism, scope: Scope) -> Iterator[str]:
    form = scope.form
    lengths, stated = list_lengths(mechanism), leave_out(mechanism, form)
    for force in stated.forces:
        if not isinstance(force, scope.forces):
            share = lifted_share(mechanism, force)
            if share is None or scope.lifts == "none" or (scope.lifts == "whole" and share != 1):
                yield f"{force.kind} {force.name}: no such force is written to {form}"
        elif form == "URDF" and isinstance(force, Spring):
            if mechanism.evaluate(force.free_length) > 0:
                continue
            yield f"spring {force.name}: its free length is zero, and Drake's tag wants more"
    for name in list_screw_springs(mechanism, form):
        yield f"spring {name}: engines of SDF read none in a screw"
    poses = mechanism.home_poses
    for loop in mechanism.loops:
        if scope.loops is not None and loop.kind not in scope.loops:
            yield f"loop {loop.name}: {form} has none of the kind {loop.kind!r}"
        elif scope.closed and not is_closed(mechanism, loop, poses):
            yield f"loop {loop.name}: it is open where {form} states it, at coordinates of zero"
    steps = axial_steps(mechanism)
    kept = list_lengths(stated)
    for name in (name for name in lengths if name not in kept):
        what = "tendon" if name.endswith(LENGTH) else "spring or rotor of a ball"
        yield f"{what} {name.removesuffix(LENGTH)}: {form} states none of its kind"
    for name, law in mechanism.coordinates.driven.items():
        if name in lengths:
            continue
        if law_of_follower(mechanism, steps, name, scope.degree) is None:
            most = "linear laws of one joint" if scope.degree == 1 else "polynomials of degree four"
            yield f"{name} = {law}: {form} knows {most} alone"
    for joint in mechanism.joints:
        if joint.name in lengths:
            continue
        if isinstance(joint, scope.joints):
            yield f"joint {joint.name}: {form} has none of the kind {type(joint).__name__!r}"
        if isinstance(joint, Floating) and form != "URDF" and joint.parent != mechanism.ground:
            yield f"joint {joint.name}: free joints start at the world's frame"
        if form == "SDF" and _idles(mechanism, joint):
            yield f"joint {joint.name}: without effort it has no rotor in SDF"
        body = mechanism.body(joint.child)
        if body.as_given and form != "URDF":
            yield f"body {body.name}: no real body has its inertia, and engines of {form} refuse it"
    if scope.dialect:
        return
    for contact in mechanism.contacts:
        yield f"contact {contact.name}: {form} has no rolling without slip"
    for constraint in mechanism.velocity_constraints:
        yield f"velocity constraint {constraint.name}: {form} has none"
    for element in (*mechanism.switching, *mechanism.elements):
        yield f"{type(element).__name__.lower()} {element.name}: {form} has none"


def list_omissions(mechanism: Mechanism, form: Form) -> tuple[str, ...]:
    """Say in a line each what differs that has no part in the equations of motion."""
    if form == "URDF":
        by_drake = "a ball, in a tag that Drake reads and other engines do not"
        return tuple(f"joint {name}: {by_drake}" for name in list_balls(mechanism))
    lengths = list_lengths(mechanism)
    moved = [joint for joint in mechanism.joints if joint.name not in lengths]
    light = sum(is_light(mechanism, joint, form) for joint in moved)
    massless = f"{say_count(light, 'body', 'bodies')} without mass: {form} has none"
    lines = {f"{massless}, each has {THICKENED:g} kg and kg·m² more": light}
    if form == "MJCF":
        bounds = [joint.limits for joint in mechanism.joints if isinstance(joint, Single)]
        fast = sum(limits is not None and limits.velocity < UNBOUNDED for limits in bounds)
        looks = [visual.geometry for body in mechanism.bodies for visual in body.visuals]
        meshes = sum(isinstance(geometry, Mesh) for geometry in looks)
        thin = sum(is_thin(mechanism, joint) for joint in mechanism.joints)
        lines |= {
            f"{say_count(thin, 'body', 'bodies')} without inertia about an axis: MuJoCo refuses "
            f"them, each has {THICKENED:g} kg·m² more": thin,
            f"limits of velocity of {say_count(fast, 'joint')}: MJCF has none": fast,
            f"{say_count(meshes, 'mesh', 'meshes')} that show bodies: left out": meshes,
        }
    return tuple(line for line, count in lines.items() if count)


def list_balls(mechanism: Mechanism) -> list[str]:
    """Return the names of the ball joints."""
    return [joint.name for joint in mechanism.joints if isinstance(joint, Spherical)]


def _idles(mechanism: Mechanism, joint: Joint) -> bool:
    """Whether a joint has a rotor and no effort."""
    if not isinstance(joint, Single) or joint.limits is None or joint.limits.effort:
        return False
    return bool(mechanism.evaluate(joint.armature))


def is_empty(mechanism: Mechanism, body: Body) -> bool:
    """Whether a body has neither mass nor inertia."""
    return not any(mechanism.evaluate_all((body.mass, *body.inertia)))


def is_light(mechanism: Mechanism, joint: Joint, form: Form) -> bool:
    """Whether a joint moves a body without mass that stays one body in a format."""
    body = mechanism.body(joint.child)
    if isinstance(joint, Fixed) or mechanism.evaluate(body.mass) > 0:
        return False
    return form != "MJCF" or passes_on(mechanism, joint) is None


def is_thin(mechanism: Mechanism, joint: Joint) -> bool:
    """Whether a joint moves a body with mass, but without inertia about some axis."""
    body = mechanism.body(joint.child)
    if isinstance(joint, Fixed) or body.as_given or is_empty(mechanism, body):
        return False
    moments = np.linalg.eigvalsh(tensor_of(mechanism.evaluate_all(body.inertia)))
    return bool(moments[0] < THICKENED)


def list_lengths(mechanism: Mechanism) -> dict[str, Prismatic]:
    """Return the joints that move nothing and follow others as the lengths of tendons do."""
    parents = {joint.parent for joint in mechanism.joints}
    return {
        joint.name: joint
        for joint in mechanism.joints
        if isinstance(joint, Prismatic)
        and joint.name in mechanism.coordinates.driven
        and joint.parent == mechanism.ground
        and joint.child not in parents
        and _is_idle(mechanism, joint.child)
    }


def leave_out(mechanism: Mechanism, form: Form) -> Mechanism:
    """Return a mechanism without the tendons, and springs of screws, that a format lacks."""
    lengths, m = list_lengths(mechanism), mechanism
    left = [n for n in lengths if form != "MJCF" or tendon_factors(mechanism, n) is None]
    children, coils = {lengths[n].child for n in left}, list_screw_springs(m, form)
    laws = tuple((name, law) for name, law in m.coordinates.driven.items() if name not in left)
    return replace(
        m,
        bodies=tuple(body for body in m.bodies if body.name not in children),
        joints=tuple(joint for joint in m.joints if joint.name not in left),
        forces=tuple(
            f for f in m.forces if getattr(f, "joint", "") not in left and f.name not in coils
        ),
        coordinates=replace(m.coordinates, map=laws),
    )


def list_screw_springs(mechanism: Mechanism, form: Form) -> list[str]:
    """Return the names of springs in screws, of which Drake reads none in SDF."""
    screws = {j.name for j in mechanism.joints if hasattr(j, "pitch") and form == "SDF"}
    springs = (f for f in mechanism.forces if isinstance(f, JointSpring))
    return [spring.name for spring in springs if spring.joint in screws]


def weld_constants(mechanism: Mechanism, form: Form) -> Mechanism:
    """Return a mechanism whose joints with constant coordinates are welds, as URDF and SDF state.

    Followers have leaders there, and what is constant has none.
    """
    driven, held = mechanism.coordinates.driven, dict[str, Array]()
    for joint in mechanism.joints if form != "MJCF" and not mechanism.elements else ():
        if not isinstance(joint, Revolute | Prismatic) or joint.coordinate not in driven:
            continue
        law = driven[joint.coordinate]
        if symbols_in(plain(law)) - mechanism.values.keys():
            continue
        axis, at = unit_vector(mechanism.evaluate_all(joint.axis)), mechanism.evaluate(law)
        held[joint.name] = mechanism.matrix(joint.origin) @ pose_along(axis, at, joint.turns)
    if not held:
        return mechanism
    joints = [
        Fixed(j.name, j.parent, j.child, origin=placement_at(held[j.name])) if j.name in held else j
        for j in mechanism.joints
    ]
    gone = {c for j in mechanism.joints if j.name in held for c in j.coordinates}
    laws = tuple((name, law) for name, law in driven.items() if name not in gone)
    return replace(
        mechanism,
        joints=tuple(joints),
        forces=tuple(f for f in mechanism.forces if getattr(f, "joint", "") not in held),
        coordinates=replace(mechanism.coordinates, map=laws),
    )


def start_at_ground(mechanism: Mechanism, form: Form) -> tuple[Mechanism, list[str]]:
    """Return a mechanism whose free joints start at the ground, and those that count otherwise.

    MJCF and SDF count from the world's frame. On a body that moves, a joint stays whose coordinates
    stand in forces and laws. Loops of SDF start at the ground, too: no joint ends there.
    """
    held, joints, counting = {mechanism.ground}, list[Joint](), list[str]()
    for joint in mechanism.tree:
        if isinstance(joint, Fixed) and joint.parent in held:
            held.add(joint.child)
    laws = map(symbols_in, mechanism.coordinates.driven.values())
    stated = frozenset().union(*(force.symbols for force in mechanism.forces), *laws)
    for joint in mechanism.joints:
        if isinstance(joint, Floating) and form != "URDF":
            rides = joint.parent not in held
            bound = rides and stated & {*joint.coordinates, *joint.velocities}
            if joint.parent != mechanism.ground and not bound:
                place = placement_at(mechanism.home_poses[joint.child])
                joint = replace(joint, parent=mechanism.ground, origin=place)
            counting += [joint.name] if rides or joint.origin != Placement() else []
        joints.append(joint)
    loops = (
        replace(k, body_a=k.body_b, frame_a=k.frame_b, body_b=k.body_a, frame_b=k.frame_a)
        if form == "SDF" and k.body_b == mechanism.ground
        else k
        for k in mechanism.loops
    )
    return replace(mechanism, joints=tuple(joints), loops=tuple(loops)), counting


def tendon_factors(mechanism: Mechanism, name: str) -> dict[str, float] | None:
    """Return the factors of the simple joints that a tendon runs along; None if it does not."""
    steps, values = axial_steps(mechanism), dict.fromkeys(mechanism.coordinates.names, 0.0)
    law = plain(mechanism.coordinates.driven[name])
    leaders = sorted(symbols_in(law) - mechanism.values.keys())
    try:
        rates = {steps[k]: mechanism.evaluate(law.diff(coordinate(k))) for k in leaders}
    except (KeyError, InputError):
        return None
    return None if evaluate(law, {**mechanism.values, **values}) else rates


def _is_idle(mechanism: Mechanism, name: str) -> bool:
    """Whether a body has no mass, shows nothing, and nothing but joints acts on it."""
    body = mechanism.body(name)
    ends = {end for loop in mechanism.loops for end in loop.bodies}
    ends |= {end for force in mechanism.forces for end in getattr(force, "bodies", ())}
    return is_empty(mechanism, body) and not body.visuals and name not in ends


def passes_on(mechanism: Mechanism, joint: Joint) -> Joint | None:
    """Return the joint behind a hinge or slide that carries nothing else: MJCF puts both in a body.

    MuJoCo refuses bodies between joints that have no mass.
    """
    behind = [further for further in mechanism.joints if further.parent == joint.child]
    idle = isinstance(joint, Single) and _is_idle(mechanism, joint.child)
    if not idle or len(behind) != 1:
        return None
    return None if isinstance(behind[0], Fixed | Floating) else behind[0]


def lifted_share(mechanism: Mechanism, force: AnyForce) -> float | None:
    """Return the share of its body's weight that a force takes off it, if it does nothing else."""
    if not isinstance(force, Force) or force.axes != "world":
        return None
    try:
        given = np.array(mechanism.evaluate_all((*force.force, *force.point)))
    except (TypeError, ValueError):
        return None  # it is not constant
    body = mechanism.body(force.body)
    weight = mechanism.evaluate(body.mass) * np.array(mechanism.evaluate_all(mechanism.gravity))
    if not weight.any():
        return None
    share = float(-(given[:3] @ weight) / (weight @ weight))
    share = 1.0 if abs(share - 1) <= _WHOLE else share
    off = [*(given[:3] + share * weight), *(given[3:] - mechanism.evaluate_all(body.center))]
    return share if np.abs(off).max() <= _WHOLE * (1 + np.abs(weight).max()) else None


def joint_spring(mechanism: Mechanism, joint: str) -> tuple[float, float]:
    """Return stiffness and reference of all springs in a joint as one."""
    springs = [f for f in mechanism.forces if isinstance(f, JointSpring) and f.joint == joint]
    stiffness = sum(mechanism.evaluate(spring.stiffness) for spring in springs)
    pull = sum(mechanism.evaluate(s.stiffness) * mechanism.evaluate(s.reference) for s in springs)
    return stiffness, pull / stiffness if stiffness else 0.0


def joint_damping(mechanism: Mechanism, joint: str) -> float:
    """Return the damping of all dampers in a joint."""
    dampers = (f for f in mechanism.forces if isinstance(f, JointDamper) and f.joint == joint)
    return float(sum(mechanism.evaluate(damper.damping) for damper in dampers))


def is_closed(mechanism: Mechanism, loop: Loop, poses: Mapping[str, Array]) -> bool:
    """Whether a ball, hinge or weld is closed in these poses of the bodies."""
    a, b = (
        poses[body] @ mechanism.matrix(frame)
        for body, frame in ((loop.body_a, loop.frame_a), (loop.body_b, loop.frame_b))
    )
    first = {"ball": 3, "hinge": 2, "weld": 0}[loop.kind]
    return bool(np.abs(a[:3, first:] - b[:3, first:]).max() <= _CLOSED)
