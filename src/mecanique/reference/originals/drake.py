"""Read a file with Drake's own parser, in a separate process, as Drake may crash it."""

from __future__ import annotations

import json
import logging
import subprocess
import sys
from collections.abc import Iterable, Sequence
from typing import Any, final

import numpy as np

from mecanique.errors import EngineError
from mecanique.reference.originals.original import ByJoint, Original, columns, form_of

_SECONDS = 120.0
"""Time limit for a file [s]."""


def read(text: bytes, gravity: Sequence[float], q: ByJoint, v: ByJoint) -> Original:
    """Read a file with Drake and evaluate it in n states, its root welded to the world.

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
    request = json.dumps({**asked, "q": dict(q), "v": dict(v)})
    command = [sys.executable, "-m", __name__]
    try:
        run = subprocess.run(
            command, input=request, capture_output=True, text=True, timeout=_SECONDS, check=False
        )
    except subprocess.TimeoutExpired:
        raise EngineError(f"it took longer than {_SECONDS:.0f} s") from None
    if run.returncode:
        raise EngineError(run.stderr.strip().rpartition("\n")[2] or "it crashed the process")
    answer = json.loads(run.stdout)
    names = tuple(answer["joints"])
    states, count = len(answer["mass"]), len(names)
    return Original(
        names,
        np.array(answer["mass"], dtype=float).reshape(states, count, count),
        np.array(answer["bias"], dtype=float).reshape(states, count),
        tuple(answer["complaints"]),
        np.array(answer["passive"], dtype=float).reshape(states, count),
    )


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
    Parser(plant).AddModelsFromString(asked["text"], asked["form"])
    plant.mutable_gravity_field().set_gravity_vector(asked["gravity"])
    every = [plant.get_joint(JointIndex(k)) for k in range(plant.num_joints())]
    carried = {int(joint.child_body().index()) for joint in every}
    for k in range(1, plant.num_bodies()):
        if k not in carried:
            root = plant.get_body(BodyIndex(k))
            plant.WeldFrames(plant.world_frame(), root.body_frame())
    plant.Finalize()
    context = plant.CreateDefaultContext()
    single = [joint for joint in every if joint.num_velocities() == 1]
    scopes = [plant.GetModelInstanceName(joint.model_instance()) for joint in single]
    pairs = zip(scopes, single, strict=True)
    names = [_pick_name(f"{scope}::{joint.name()}", asked["q"]) for scope, joint in pairs]
    at = [joint.velocity_start() for joint in single]
    rest = np.array(plant.GetPositions(context))
    masses, biases, passive = [], [], []
    forces, still = MultibodyForces(plant), np.zeros(plant.num_velocities())
    for angles, rates in zip(columns(asked["q"], names), columns(asked["v"], names), strict=True):
        place, speed = rest.copy(), np.zeros(plant.num_velocities())
        place[[joint.position_start() for joint in single]] = angles
        speed[at] = rates
        plant.SetPositions(context, place)
        plant.SetVelocities(context, speed)
        bias = plant.CalcBiasTerm(context) - plant.CalcGravityGeneralizedForces(context)
        masses.append(plant.CalcMassMatrix(context)[np.ix_(at, at)].tolist())
        biases.append(bias[at].tolist())
        plant.CalcForceElementsContribution(context, forces)
        whole = plant.CalcInverseDynamics(context, still, forces)
        passive.append((bias - whole)[at].tolist())
    answers = {"mass": masses, "bias": biases, "passive": passive}
    return {"joints": names, **answers, "complaints": heard.said}


def _pick_name(scoped: str, asked: Iterable[str]) -> str:
    """Return what is asked for by the longest end of a scoped name, or else its last part."""
    ends = (name for name in asked if f"::{scoped}".endswith(f"::{name}"))
    return max(ends, key=len, default=scoped.rpartition("::")[2])


@final
class _Heard(logging.Handler):
    """Keeps the messages that Drake logs."""

    def __init__(self) -> None:
        super().__init__()
        self.said: list[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        self.said.append(" ".join(record.getMessage().split()))


if __name__ == "__main__":
    try:
        print(json.dumps(_answer(json.load(sys.stdin))))
    except (RuntimeError, ValueError) as error:
        print(" ".join(str(error).split()), file=sys.stderr)
        sys.exit(1)
