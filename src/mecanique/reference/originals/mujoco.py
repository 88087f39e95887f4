"""Read a file with MuJoCo's own parser."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from mecanique.arrays import Array
from mecanique.errors import EngineError
from mecanique.reference.originals.original import (
    ByJoint,
    EngineJoint,
    Original,
    ball_w_first,
    evaluate,
    form_of,
    free_root_of,
    same,
    turning,
)

_MESHES = re.compile(
    rb"<(visual|collision)\b[^>]*(?<!/)>(?:(?!</\1>).)*?<mesh\b.*?</\1>", re.DOTALL
)
"""Meshes are removed: their files may be missing, and inertias do not depend on them."""

_PLANAR = ("_TX", "_TY", "_RZ")
"""Behind the name of a planar joint of URDF, those of the slides and the hinge that it becomes."""


def read(text: bytes, gravity: Sequence[float], q: ByJoint, v: ByJoint) -> Original:
    """Read a file with MuJoCo, without its meshes, and evaluate it in n states."""
    import mujoco

    form = form_of(text)
    if form == "SDF":
        raise EngineError("it has no reader of SDF")
    text = text if form == "MJCF" else _MESHES.sub(b"", text)
    try:
        if (root := free_root_of(text, v)) is None:
            model = mujoco.MjModel.from_xml_string(text.decode("utf-8", "replace"))
        else:
            spec = mujoco.MjSpec.from_string(text.decode("utf-8", "replace"))
            spec.compiler.fusestatic = False  # which would merge it with the world
            spec.worldbody.first_body().add_freejoint(name=root)
            model = spec.compile()
    except (ValueError, RuntimeError) as error:
        raise EngineError(" ".join(str(error).split())) from None
    model.opt.gravity = gravity
    # contacts are left out, whose pull MuJoCo counts among the passive forces
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONTACT)
    data = mujoco.MjData(model)
    joints = [*_joints(model)]
    rest = np.zeros(model.nq)  # where all coordinates of hinges and slides are zero
    for joint in joints:
        if joint.kind in ("ball", "free"):
            rest[joint.at.stop - 4] = 1.0

    def answer(place: Array, speed: Array) -> tuple[Array, ...]:
        data.qpos[:], data.qvel[:] = place, speed
        mujoco.mj_forward(model, data)
        mass = np.zeros((model.nv, model.nv))
        for column, unit in zip(mass, np.eye(model.nv), strict=True):
            mujoco.mj_mulM(model, data, column, unit)
        # what actuators carry of the weight counts as theirs there
        driven = model.jnt_actgravcomp[model.dof_jntid] * data.qfrc_gravcomp
        return mass, np.array(data.qfrc_bias), data.qfrc_passive + driven

    return evaluate(q, v, joints, rest, answer)


def _joints(model: Any) -> Iterator[EngineJoint]:
    joints = [model.joint(k) for k in range(model.njnt)]
    while joints:
        joint = joints.pop(0)
        place, rate, kind = int(joint.qposadr[0]), int(joint.dofadr[0]), int(joint.type[0])
        name = joint.name.removesuffix(_PLANAR[0])
        if [joint.name, *(part.name for part in joints[:2])] == [name + k for k in _PLANAR]:
            del joints[:2]
            yield EngineJoint(name, slice(place, place + 3), rate, "planar", same)
        elif kind == 0:
            yield EngineJoint(joint.name, slice(place, place + 7), rate, "free", _free)
        elif kind == 1:
            yield EngineJoint(joint.name, slice(place, place + 4), rate, "ball", ball_w_first)
        else:
            yield EngineJoint(joint.name, slice(place, place + 1), rate, "single", same)


def _free(q: Array, v: Array) -> tuple[Array, Array, Array]:
    """Velocities are the origin's in world axes, then the angular velocity in the body's."""
    _, linear, drift = turning(q, v)
    T = np.vstack([linear, np.eye(6)[3:]])
    # the quaternion with w first
    return q[[0, 1, 2, 6, 3, 4, 5]], T, np.append(drift, np.zeros(3))
