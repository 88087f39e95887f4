"""Read a file with MuJoCo's own parser."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from mecanique.errors import EngineError
from mecanique.reference.originals.original import ByJoint, Original, columns, form_of

_MESHES = re.compile(
    rb"<(visual|collision)\b[^>]*(?<!/)>(?:(?!</\1>).)*?<mesh\b.*?</\1>", re.DOTALL
)
"""Meshes are removed: their files may be missing, and inertias do not depend on them."""


def read(text: bytes, gravity: Sequence[float], q: ByJoint, v: ByJoint) -> Original:
    """Read a file with MuJoCo, without its meshes, and evaluate it in n states."""
    import mujoco

    if form_of(text) == "SDF":
        raise EngineError("it has no reader of SDF")
    text = text if form_of(text) == "MJCF" else _MESHES.sub(b"", text)
    try:
        model = mujoco.MjModel.from_xml_string(text.decode("utf-8", "replace"))
    except (ValueError, RuntimeError) as error:
        raise EngineError(" ".join(str(error).split())) from None
    model.opt.gravity = gravity
    data = mujoco.MjData(model)
    rest = np.zeros(model.nq)  # where all coordinates of hinges and slides are zero
    for k in range(model.njnt):
        start = int(model.jnt_qposadr[k])
        turns = {int(mujoco.mjtJoint.mjJNT_BALL): 0, int(mujoco.mjtJoint.mjJNT_FREE): 3}
        if int(model.jnt_type[k]) in turns:
            rest[start + turns[int(model.jnt_type[k])]] = 1.0
    kinds = {int(mujoco.mjtJoint.mjJNT_HINGE), int(mujoco.mjtJoint.mjJNT_SLIDE)}
    single = [model.joint(k) for k in range(model.njnt) if int(model.jnt_type[k]) in kinds]
    names = tuple(joint.name for joint in single)
    at = [int(joint.dofadr[0]) for joint in single]
    masses, biases, passive = [], [], []
    for angles, rates in zip(columns(q, names), columns(v, names), strict=True):
        data.qpos[:], data.qvel[:] = rest, 0.0
        data.qpos[[int(joint.qposadr[0]) for joint in single]] = angles
        data.qvel[at] = rates
        mujoco.mj_forward(model, data)
        mass = np.zeros((model.nv, model.nv))
        for column, unit in zip(mass, np.eye(model.nv), strict=True):
            mujoco.mj_mulM(model, data, column, unit)
        masses.append(mass[np.ix_(at, at)])
        biases.append(np.array(data.qfrc_bias[at]))
        passive.append(np.array(data.qfrc_passive[at]))
    return Original(names, np.array(masses), np.array(biases), (), np.array(passive))
