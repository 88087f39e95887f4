"""Read a file with Pinocchio's own parser, and capture its messages on standard error."""

from __future__ import annotations

import os
import re
import sys
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager

import numpy as np

from mecanique.errors import EngineError
from mecanique.reference.originals.original import ByJoint, Original, columns, form_of

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
                model = pin.buildModelFromXML(text.decode("utf-8", "replace"))
        except (ValueError, RuntimeError) as error:
            refused = str(error)
    said = tuple(dict.fromkeys(_COMPLAINT.findall(heard[0])))
    if model is None:
        reasons = [reason for reason in said if "not initialized correctly" not in reason]
        raise EngineError("; ".join(reasons) or refused)
    model.gravity.linear = np.array(gravity)
    data = model.createData()
    single = [k for k in range(1, model.njoints) if model.joints[k].nv == 1]
    names = tuple(model.names[k] for k in single)
    at = [model.joints[k].idx_v for k in single]
    masses, biases = [], []
    for angles, rates in zip(columns(q, names), columns(v, names), strict=True):
        place, speed = pin.neutral(model), np.zeros(model.nv)
        speed[at] = rates
        for index, angle in zip(single, angles.tolist(), strict=True):
            joint = model.joints[index]
            endless = joint.nq == 2
            place[joint.idx_q : joint.idx_q + joint.nq] = (
                (np.cos(angle), np.sin(angle)) if endless else angle
            )
        masses.append(pin.crba(model, data, place)[np.ix_(at, at)])
        biases.append(pin.nonLinearEffects(model, data, place, speed)[at])
    return Original(names, np.array(masses), np.array(biases), said)


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
