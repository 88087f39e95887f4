"""Read a file with Pinocchio's own parser, and capture its messages on standard error."""

from __future__ import annotations

import os
import re
import sys
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any

import numpy as np

from mecanique.arrays import Array
from mecanique.errors import EngineError
from mecanique.reference.originals.original import (
    ByJoint,
    EngineJoint,
    Original,
    evaluate,
    form_of,
    free_root_of,
    same,
)

_COMPLAINT = re.compile(r"^(?:Error|Warning):\s+(.*?)\s*$", re.MULTILINE)


def read(text: bytes, gravity: Sequence[float], q: ByJoint, v: ByJoint) -> Original:
    """Read a file with Pinocchio and evaluate it in n states."""
    import pinocchio as pin

    model, refused = None, ""
    with _standard_error() as heard:
        try:
            if form_of(text) == "SDF":
                raise EngineError("its packages have no reader of SDF")
            if form_of(text) == "MJCF":
                with tempfile.NamedTemporaryFile(suffix=".xml") as file:
                    file.write(text)
                    file.flush()
                    model = pin.buildModelFromMJCF(file.name)
            else:
                free = free_root_of(text, v) is not None
                root = (pin.JointModelFreeFlyer(),) if free else ()
                model = pin.buildModelFromXML(text.decode("utf-8", "replace"), *root)
        except (ValueError, RuntimeError) as error:
            refused = str(error)
    said = tuple(dict.fromkeys(_COMPLAINT.findall(heard[0])))
    if model is None:
        reasons = [reason for reason in said if "not initialized correctly" not in reason]
        raise EngineError("; ".join(reasons) or refused)
    model.gravity.linear = np.array(gravity)
    data = model.createData()
    every = range(1, model.njoints)
    joints = [_joint(model.names[k], model.joints[k], model.jointPlacements[k]) for k in every]

    def answer(place: Array, speed: Array) -> tuple[Array, ...]:
        mass = np.array(pin.crba(model, data, place))
        return mass, np.array(pin.nonLinearEffects(model, data, place, speed))

    return evaluate(q, v, joints, pin.neutral(model), answer, said)


def _joint(name: str, joint: Any, placement: Any) -> EngineJoint:
    """Return a joint with the way Pinocchio counts: continuous angles are cosine and sine."""

    def endless(q: Array, v: Array) -> tuple[Array, Array, Array]:
        return np.array([np.cos(q[0]), np.sin(q[0])]), np.eye(1), np.zeros(1)

    def planar(q: Array, v: Array) -> tuple[Array, Array, Array]:
        c, s = np.cos(q[2]), np.sin(q[2])
        back = np.array([[c, s, 0.0], [-s, c, 0.0], [0.0, 0.0, 1.0]])
        rate = np.array([[-s, c, 0.0], [-c, -s, 0.0], [0.0, 0.0, 0.0]])
        return np.array([q[0], q[1], c, s]), back, v[2] * rate @ v

    def free(q: Array, v: Array) -> tuple[Array, Array, Array]:
        import pinocchio as pin

        pose = placement.actInv(pin.XYZQUATToSE3(q))
        return np.array(pin.SE3ToXYZQUAT(pose)), np.eye(6), np.zeros(6)

    kinds = {(2, 1): ("single", endless), (4, 3): ("ball", same), (7, 6): ("free", free)}
    kind, chart = kinds.get((joint.nq, joint.nv), ("single", same))
    if joint.shortname().endswith("Planar"):
        kind, chart = "planar", planar
    span = slice(joint.idx_q, joint.idx_q + joint.nq)
    return EngineJoint(name, span, joint.idx_v, kind, chart)


@contextmanager
def _standard_error() -> Iterator[list[str]]:
    """Capture what C++ writes to standard error, which bypasses Python's sys.stderr."""
    heard = [""]
    sys.stderr.flush()
    kept = os.dup(2)
    with tempfile.TemporaryFile() as file:
        os.dup2(file.fileno(), 2)
        try:
            yield heard
        finally:
            os.dup2(kept, 2)
            os.close(kept)
            file.seek(0)
            heard[0] = file.read().decode("utf-8", "replace")
