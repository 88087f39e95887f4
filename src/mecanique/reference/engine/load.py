"""Load a mechanism into Pinocchio by its own URDF parser, and check that nothing was lost."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, final

import numpy as np

from mecanique.errors import EngineError
from mecanique.model import Body, Mechanism
from mecanique.model.bodies.tensor import tensor_of
from mecanique.model.joint_base import Single
from mecanique.reference.engine.package import engine_package
from mecanique.urdf.limits import MOST_DEPTH, MOST_VELOCITIES
from mecanique.urdf.write import SimpleJoint, chains, write_urdf

_WIDTHS = {
    "continuous": (2, 1),
    "revolute": (1, 1),
    "prismatic": (1, 1),
    "floating": (7, 6),
    "fixed": (0, 0),
}
"""Numbers of positions and velocities that Pinocchio assigns to each type of URDF joint."""


@final
@dataclass(frozen=True)
class JointIndices:
    """The indices of a simple joint and its coordinates in the engine."""

    kind: str  # its URDF type
    index: int  # index of the joint in the model, 0 for a fixed one
    at_q: int  # index of its first position
    at_v: int  # index of its first velocity


@final
@dataclass(frozen=True)
class Holder:
    """The moving joint that carries a body; bodies welded by fixed joints share one."""

    joint: int  # index of the moving joint in the model, 0 for the world
    placement: Any  # pose of the body in that joint's frame, a pinocchio.SE3
    inertia: Any  # inertia of the body alone, in that joint's frame, a pinocchio.Inertia
    frame: int  # index of the body's frame


@final
@dataclass(frozen=True)
class EngineModel:
    """A mechanism's tree in Pinocchio."""

    model: Any  # pinocchio.Model
    data: Any  # pinocchio.Data
    weightless: Any  # the same model without gravity
    # the seats of each joint's chain, by the joint's name
    seats: dict[str, tuple[JointIndices, ...]]
    holders: dict[str, Holder]  # the holder of each body, by its name

    @cached_property
    def by_angles(self) -> tuple[Any, Any]:
        """The same model with hinges placed by their angle, not its cosine and sine; its data."""
        pin = engine_package()

        model, data, angular = self.model, self.model.createData(), pin.Model()
        angular.gravity = model.gravity
        for index in range(1, model.njoints):
            joint = model.joints[index]
            if joint.nq == 2:
                axis = np.array(data.joints[index].S).reshape(-1)[3:]
                joint = pin.JointModelRevoluteUnaligned(axis)
            angular.addJoint(
                model.parents[index], joint, model.jointPlacements[index], model.names[index]
            )
            angular.inertias[index] = model.inertias[index]
        angular.armature = model.armature
        return angular, angular.createData()


def load(mechanism: Mechanism) -> EngineModel:
    """Write a mechanism as URDF and read it with Pinocchio."""
    # Spherical joints are written as floating ones, as the parser has no ball joint; callers must
    # keep their translation at zero
    links = chains(mechanism, "floating")
    _check_size(mechanism, links)
    pin = engine_package()

    try:
        model = pin.buildModelFromXML(write_urdf(mechanism, spherical="floating"))
    except (ValueError, RuntimeError) as error:
        raise EngineError(f"Pinocchio refused mechanism {mechanism.name!r}: {error}") from None
    model.gravity.linear = np.array(mechanism.evaluate_all(mechanism.gravity))
    model.gravity.angular = np.zeros(3)
    # by position, because names may repeat the engine's own, e.g. "universe"
    indices = {name: index for index, name in enumerate(model.names) if index}
    frames = {
        frame.name: index for index, frame in enumerate(model.frames) if frame.type == pin.BODY
    }
    missing = [
        step.name
        for chain in links.values()
        for step in chain
        if step.kind != "fixed" and step.name not in indices
    ]
    missing += [body.name for body in mechanism.bodies if body.name not in frames]
    if missing:
        raise EngineError(
            f"Pinocchio lost {', '.join(map(repr, missing))} of mechanism {mechanism.name!r}"
        )
    seats = {}
    for name, chain in links.items():
        seats[name] = tuple(_seat(model, indices, step) for step in chain)
    holders = {
        body.name: _holder(pin, mechanism, body, model.frames[frames[body.name]], frames)
        for body in mechanism.bodies
    }
    _check_inertias(pin, mechanism, model, holders)
    for joint in mechanism.joints:
        if isinstance(joint, Single):
            model.armature[seats[joint.name][-1].at_v] = mechanism.evaluate(joint.armature)
    weightless = model.copy()
    weightless.gravity.linear = np.zeros(3)
    return EngineModel(model, model.createData(), weightless, seats, holders)


def _check_size(mechanism: Mechanism, links: dict[str, tuple[SimpleJoint, ...]]) -> None:
    velocities = sum(_WIDTHS[step.kind][1] for chain in links.values() for step in chain)
    depth = {mechanism.ground: 0}
    for joint in mechanism.tree:
        depth[joint.child] = depth[joint.parent] + len(links[joint.name])
    deepest = max(depth.values())
    way_out = "split it, or use the equations of mecanique.derive, which have no such limit"
    if velocities > MOST_VELOCITIES:
        raise EngineError(
            f"mechanism {mechanism.name!r} has {velocities} joint velocities; "
            f"Pinocchio is given at most {MOST_VELOCITIES}, because its memory grows with "
            f"their cube: {way_out}"
        )
    if deepest > MOST_DEPTH:
        raise EngineError(
            f"mechanism {mechanism.name!r} has {deepest} joints in a row; "
            f"Pinocchio is given at most {MOST_DEPTH}, because its parser crashes the process "
            f"somewhere above that: {way_out}"
        )


def _seat(model: Any, indices: dict[str, int], step: SimpleJoint) -> JointIndices:
    if step.kind == "fixed":
        return JointIndices(step.kind, 0, 0, 0)
    index = indices[step.name]
    joint = model.joints[index]
    if (joint.nq, joint.nv) != _WIDTHS[step.kind]:
        raise EngineError(
            f"Pinocchio read joint {step.name!r} of type {step.kind} as {joint.shortname()}"
        )
    return JointIndices(step.kind, index, joint.idx_q, joint.idx_v)


def _holder(
    pin: Any, mechanism: Mechanism, body: Body, frame: Any, frames: dict[str, int]
) -> Holder:
    tensor = tensor_of(mechanism.evaluate_all(body.inertia))
    center = np.array(mechanism.evaluate_all(body.center))
    # set part by part, as the constructor refuses principal moments made negative by rounding
    inertia = pin.Inertia.Zero()
    inertia.mass, inertia.lever, inertia.inertia = mechanism.evaluate(body.mass), center, tensor
    return Holder(
        frame.parentJoint, frame.placement.copy(), frame.placement.act(inertia), frames[body.name]
    )


def _check_inertias(pin: Any, mechanism: Mechanism, model: Any, holders: dict[str, Holder]) -> None:
    """Refuse bodies that the parser dropped or changed, which it reports only on standard error."""
    carried: dict[int, list[str]] = {}
    for name, holder in holders.items():
        carried.setdefault(holder.joint, []).append(name)
    for index in range(1, model.njoints):
        names = carried.get(index, [])
        read, wanted = (
            model.inertias[index],
            sum((holders[name].inertia for name in names), pin.Inertia.Zero()),
        )
        parts = [holders[name].inertia for name in names]
        # of the parts, because their first moments may cancel down to rounding
        first = sum(part.mass * float(np.linalg.norm(part.lever)) for part in parts)
        moments = np.sum([part.mass * part.lever for part in parts] or [np.zeros(3)], axis=0)
        scale = np.abs(wanted.inertia).max() + first * np.linalg.norm(wanted.lever)
        whole = (
            abs(read.mass - wanted.mass) <= 1e-9 * wanted.mass
            and np.abs(read.mass * read.lever - moments).max() <= 1e-9 * first
            and np.abs(read.inertia - wanted.inertia).max() <= 1e-9 * scale
        )
        if not whole:
            listed = ", ".join(map(repr, names))
            raise EngineError(
                f"Pinocchio read body {listed} with mass {read.mass:g} kg and "
                f"center {read.lever}, not {wanted.mass:g} kg and {wanted.lever}; masses below "
                "1e-15 kg are lost: measure in smaller units"
            )
