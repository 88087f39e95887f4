"""Read a file with Drake's own parser, in a separate process, as Drake may crash it."""

from __future__ import annotations

import json
import logging
import re
import subprocess
import sys
from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any, final

import numpy as np

from mecanique.arrays import Array
from mecanique.errors import EngineError
from mecanique.model.joints import Planar
from mecanique.plugins import new_interpreter
from mecanique.reference.originals.original import (
    ByJoint,
    Chart,
    EngineJoint,
    Original,
    attributes_of,
    evaluate,
    form_of,
    free_root_of,
    same,
    turning,
)
from mecanique.reference.vectors import turn_of
from mecanique.urdf.reading.packages import MeshSearch

_SECONDS = 120.0
"""Time limit for a file [s]."""


def read(text: bytes, gravity: Sequence[float], q: ByJoint, v: ByJoint) -> Original:
    """Read a file with Drake and evaluate it in n states.

    The root of a URDF is welded to the world unless it is asked to move.

    Args:
        text: the file's text.
        gravity: shape (3,) [m/s²].
        q: positions of joints.
        v: velocities of joints.

    Raises:
        EngineError: if Drake refuses the text; the message gives Drake's reason.
    """
    form = {"URDF": "urdf", "MJCF": "xml", "SDF": "sdf"}[form_of(text)]
    asked = {"text": text.decode("utf-8", "replace"), "form": form, "gravity": list(gravity)}
    held = form == "urdf" and free_root_of(text, v) is None
    carried = attributes_of(text, "child", "link") if held else None
    given = json.dumps({**asked, "carried": carried, "q": dict(q), "v": dict(v)})
    words = new_interpreter(f"from {__name__} import answer_request; answer_request()")
    try:
        run = subprocess.run(
            words, input=given, capture_output=True, encoding="utf-8", timeout=_SECONDS, check=False
        )
    except subprocess.TimeoutExpired:
        raise EngineError(f"it took longer than {_SECONDS:.0f} s") from None
    if run.returncode:
        raise EngineError(run.stderr.strip().rpartition("\n")[2] or "it crashed the process")
    answer = json.loads(run.stdout)
    states, count = len(answer["mass"]), sum(np.size(v[name][0]) for name in answer["joints"])
    shapes = {"mass": (states, count, count), "bias": (states, count), "passive": (states, count)}
    for what, shape in shapes.items():
        answer[what] = np.array(answer[what], dtype=float).reshape(shape)
    for what in ("joints", "complaints", "others"):
        answer[what] = tuple(answer[what])
    return Original(**answer)


def _answer(asked: dict[str, Any]) -> dict[str, Any]:
    """Evaluate the request of `read`, within the process that Drake may crash."""
    from pydrake.multibody.parsing import Parser
    from pydrake.multibody.plant import MultibodyPlant
    from pydrake.multibody.tree import BodyIndex, JointIndex, MultibodyForces

    heard = _Heard()
    log = logging.getLogger("drake")
    log.addHandler(heard)
    log.propagate = False
    plant = MultibodyPlant(time_step=0.0)
    parser = Parser(plant)
    search = MeshSearch(Path.cwd() / "text")
    for name in set(re.findall(r"(?:model|package)://([^/<\"']+)", asked["text"])):
        if (folder := search.package(name)) is not None:
            if parser.package_map().Contains(name):
                parser.package_map().Remove(name)  # which Drake would fetch instead
            parser.package_map().Add(name, str(folder))
    parser.AddModelsFromString(asked["text"], asked["form"])
    plant.mutable_gravity_field().set_gravity_vector(asked["gravity"])
    for k in range(1, plant.num_bodies()) if asked["carried"] is not None else ():
        body = plant.get_body(BodyIndex(k))
        if body.name() not in asked["carried"]:
            plant.WeldFrames(plant.world_frame(), body.body_frame())
    plant.Finalize()
    context = plant.CreateDefaultContext()
    every = [plant.get_joint(JointIndex(k)) for k in range(plant.num_joints())]
    joints = [_joint(plant, joint) for joint in every if joint.num_velocities()]
    forces, still = MultibodyForces(plant), np.zeros(plant.num_velocities())

    def answer(place: Array, speed: Array) -> tuple[Array, ...]:
        plant.SetPositions(context, place)
        plant.SetVelocities(context, speed)
        bias = plant.CalcBiasTerm(context) - plant.CalcGravityGeneralizedForces(context)
        plant.CalcForceElementsContribution(context, forces)
        whole = plant.CalcInverseDynamics(context, still, forces)
        return plant.CalcMassMatrix(context), bias, bias - whole

    rest = np.array(plant.GetPositions(context))
    original = evaluate(asked["q"], asked["v"], joints, rest, answer, heard.said)
    arrays = {what: getattr(original, what).tolist() for what in ("mass", "bias", "passive")}
    return {**asdict(original), **arrays}


def _joint(plant: Any, joint: Any) -> EngineJoint:
    """Return a joint with the way Drake counts."""
    scope, name = plant.GetModelInstanceName(joint.model_instance()), joint.name()
    kind, chart = {
        "quaternion_floating": ("free", _free),
        "ball_rpy": ("ball", _ball),
        "planar": ("planar", _planar(joint.frame_on_child())),
        "universal": ("universal", same),
    }.get(joint.type_name(), ("single", same))
    if kind == "free" and name == joint.child_body().name():
        name = f"{name}_root_joint"
    start = joint.position_start()
    span = slice(start, start + joint.num_positions())
    return EngineJoint(f"{scope}::{name}", span, joint.velocity_start(), kind, chart)


def _free(q: Array, v: Array) -> tuple[Array, Array, Array]:
    """Velocities are the angular one, then the origin's, both in world axes."""
    R, linear, drift = turning(q, v)
    T = np.vstack([np.hstack([np.zeros((3, 3)), R]), linear])
    return np.concatenate([q[[6, 3, 4, 5]], q[:3]]), T, np.append(np.zeros(3), drift)


def _ball(q: Array, v: Array) -> tuple[Array, Array, Array]:
    """Roll, pitch and yaw, and the angular velocity in the parent's axes."""
    R = turn_of(q)
    roll, yaw = np.arctan2(R[2, 1], R[2, 2]), np.arctan2(R[1, 0], R[0, 0])
    return np.array([roll, -np.arcsin(R[2, 0]), yaw]), R, np.zeros(3)


def _planar(frame: Any) -> Chart:
    """Coordinates along the axes that Drake chooses in the plane."""
    axes = frame.GetFixedPoseInBodyFrame().rotation().matrix()
    x, y, z = axes[:, 2].tolist()
    plane = np.array(Planar("plane", "a", "b", axis=(x, y, z)).directions)
    T = np.eye(3)
    T[:2, :2] = axes[:, :2].T @ plane.T

    def chart(q: Array, v: Array) -> tuple[Array, Array, Array]:
        return T @ q, T, np.zeros(3)

    return chart


@final
class _Heard(logging.Handler):
    """Keeps the messages that Drake logs."""

    def __init__(self) -> None:
        super().__init__()
        self.said: list[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        self.said.append(" ".join(record.getMessage().split()))


def answer_request() -> None:
    """Answer the request on standard input, or say on standard error why not."""
    try:
        print(json.dumps(_answer(json.load(sys.stdin))))
    except (RuntimeError, ValueError) as error:
        print(" ".join(str(error).split()), file=sys.stderr)
        sys.exit(1)
