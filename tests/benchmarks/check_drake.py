"""Load the written URDF files in Drake and compare accelerations; needs `pip install drake`.

    python tests/benchmarks/check_drake.py

Coordinate maps, loads and inputs are no part of URDF: systems that have some are compared where the
rest is the same, that is, on the tree and without loads. Prints a row per system."""

from __future__ import annotations

import sys
from dataclasses import replace
from typing import Any

import numpy as np

import mecanique as mq
from mecanique.model.forces import Force, JointForce, Torque


def tree_alone(mechanism: mq.Mechanism) -> mq.Mechanism:
    """The mechanism as its URDF states it: no map, no loads."""
    carried = tuple(f for f in mechanism.forces if not isinstance(f, (Force, Torque, JointForce)))
    return replace(mechanism, forces=carried, coordinates=mq.Coordinates(()), loops=())


def worst(name: str, samples: int = 20) -> float:
    """Largest relative difference of accelerations between Drake and the reference."""
    from pydrake.multibody.parsing import Parser
    from pydrake.multibody.plant import MultibodyPlant

    mechanism = tree_alone(mq.textbook.load(name))
    reference = mq.Reference(mechanism)
    plant = MultibodyPlant(0.0)
    Parser(plant).AddModelsFromString(mq.write_urdf(mechanism), "urdf")
    plant.mutable_gravity_field().set_gravity_vector(
        [mechanism.evaluate(g) for g in mechanism.gravity]
    )
    plant.Finalize()
    context = plant.CreateDefaultContext()
    names = [joint.name for joint in mechanism.joints if joint.coordinates]
    at = {joint: plant.GetJointByName(joint).velocity_start() for joint in names}
    place = [at[joint] for joint in names]
    rng = np.random.default_rng(0)
    found = 0.0
    for _ in range(samples):
        q, v = 0.4 * rng.normal(size=mechanism.nq), rng.normal(size=mechanism.nv)
        theirs_q: Any = np.zeros(plant.num_positions())
        theirs_v: Any = np.zeros(plant.num_velocities())
        theirs_q[place], theirs_v[place] = q, v
        plant.SetPositions(context, theirs_q)
        plant.SetVelocities(context, theirs_v)
        theirs = plant.EvalTimeDerivatives(context).get_generalized_velocity().CopyToVector()[place]
        ours = reference.acceleration(q, v)
        found = max(found, float(np.abs(theirs - ours).max() / max(1.0, np.abs(ours).max())))
    return found


def main() -> int:
    """Print the table; return 1 if a system that Drake loads disagrees."""
    disagreed = 0
    for name in mq.textbook.names():
        mechanism = mq.textbook.load(name)
        if any(
            len(joint.coordinates) > 1 for joint in mechanism.joints
        ):  # Drake orders theirs in its own way
            print(f"{name:28} not compared: a joint of several coordinates")
            continue
        try:
            difference = worst(name)
        except (mq.MecaniqueError, RuntimeError) as error:
            print(f"{name:28} not compared: {str(error).splitlines()[0][:110]}")
            continue
        disagreed += difference > 1e-9
        print(f"{name:28} {difference:.1e}{'' if difference <= 1e-9 else '  DISAGREES'}")
    return min(disagreed, 1)


if __name__ == "__main__":
    sys.exit(main())
