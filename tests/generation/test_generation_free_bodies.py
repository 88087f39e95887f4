"""All forces on all bodies as programs: each body is in balance, and each kind does its work."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pytest

import mecanique as mq
from mecanique.derivation.mechanics.forces import AppliedWrench
from mecanique.derivation.mechanics.letters import Letters
from mecanique.generation.mechanics.constrained import inputs_at
from mecanique.generation.mechanics.dynamics import TapeDynamics, Tree
from mecanique.generation.mechanics.free_body_forces import FreeBodyForces
from mecanique.program.evaluation import evaluate
from mecanique.program.traced import values_of
from mecanique.verification.states import random_states

SKEW = mq.Shape(2.0, (0.1, -0.2, 0.3), (0.5, 0.6, 0.7, 0.05, -0.04, 0.03))
TUMBLING = mq.Mechanism(
    "tumbling",
    (mq.Body("ground"), mq.Body("hull", SKEW), mq.Body("arm", SKEW.at((0.2, 0, 0), (1, 2, 3)))),
    (
        mq.Floating("free", "ground", "hull"),
        mq.Revolute("pin", "hull", "arm", axis=(1, 2, 2), origin=mq.Placement((0, 0.4, 0))),
    ),
    forces=(mq.Damper("oil", "ground", (0, 0, 1), "arm", (0.1, 0, 0), 3.0),),
)
DRIVE = mq.Mechanism(
    "drive",
    (mq.Body("ground"), mq.Body("motor", mq.disk(1.0, 0.1)), mq.Body("drum", mq.disk(4.0, 0.3))),
    (
        mq.Revolute("shaft", "ground", "motor"),
        mq.Revolute("axle", "ground", "drum", origin=mq.Placement((1, 0, 0))),
    ),
    forces=(mq.JointForce("torque", "shaft", 2.0),),
    elements=(
        mq.Belt("belt", (mq.Pulley("motor", 0.1), mq.Pulley("drum", 0.3)), 40.0, (0.0, 0.0, 1.0)),
    ),
)
BARRED = mq.Mechanism(
    "barred",
    (mq.Body("ground"), *(mq.Body(name, mq.rod(1.0, 0.5)) for name in ("left", "right"))),
    (
        mq.Revolute("a", "ground", "left", axis=(0, -1, 0)),
        mq.Revolute("b", "ground", "right", axis=(0, -1, 0), origin=mq.Placement((0.8, 0, 0))),
    ),
    loops=(mq.Loop.distance("bar", "left", (0, 0, -0.5), "right", (0, 0, -0.4), 0.8),),
)
NAMES = (
    *("atwood_machine", "crane", "double_pendulum", "foucault_pendulum", "four_bar_linkage"),
    *("chained_four_bars", "free_rigid_body", "planetary_gear", "rack_and_pinion", "rolling_coin"),
)


MECHANISMS = (TUMBLING, DRIVE, BARRED, *map(mq.textbook.load, NAMES))


@pytest.mark.parametrize("mechanism", MECHANISMS, ids=lambda mechanism: mechanism.name)
def test_bodies_are_in_balance_and_each_kind_of_force_does_its_work(
    mechanism: mq.Mechanism,
) -> None:
    states = random_states(mechanism, 3, 2)
    letters = Letters(mechanism)
    tree = Tree(letters)
    dynamics = TapeDynamics(letters, tree, tree, "recursion")
    bodies = FreeBodyForces(dynamics)
    tau = np.random.default_rng(4).normal(size=(len(states), mechanism.nv))
    inputs = inputs_at(letters, states)
    inputs |= dict(zip((f"tau {name}" for name in mechanism.velocities), tau.T, strict=True))

    def at_states(scalars: Iterable[object]) -> np.ndarray:
        values = values_of(list(scalars))
        return np.asarray(evaluate(letters.tape, values, inputs, len(states)))

    def work_of(actions: Iterable[AppliedWrench]) -> np.ndarray:
        entries = [x for action in actions for x in bodies.work(action)]
        return np.asarray(np.sum(at_states(entries).reshape(len(states), -1, mechanism.nv), axis=1))

    acting = [*bodies.all(), *bodies.drives]
    for body in mechanism.bodies[1:]:
        on_it = [action for action in acting if action.body == body.name]
        parts = [x for a in on_it for x in (*a.origin, *a.force, *a.moment)]
        table = at_states(parts).reshape(len(states), len(on_it), 9)
        origins, forces, moments = np.split(table, 3, axis=2)
        size = max(1.0, float(np.abs(table).max()))
        np.testing.assert_allclose(forces.sum(axis=1), 0, rtol=0, atol=1e-12 * size)
        moments = moments + np.cross(origins, forces)
        np.testing.assert_allclose(moments.sum(axis=1), 0, rtol=0, atol=1e-12 * size)
    gravity = at_states(dynamics.tree.recursion.gravity_forces())
    mass = at_states(entry for row in dynamics.mass_matrix for entry in row)
    mass = mass.reshape(len(states), mechanism.nv, mechanism.nv)
    a = at_states(dynamics.acceleration)
    inertial = np.einsum("nij,nj->ni", mass, a) + at_states(dynamics.bias) - gravity
    size = max(1.0, float(np.abs(inertial).max()), float(np.abs(gravity).max()))
    joints = list(bodies.reactions())[: 2 * len(mechanism.joints)]
    wanted = {
        "joints": (joints, np.zeros_like(tau)),
        "weights": (bodies.weights(), -gravity),
        "loads": (bodies.loads, at_states(dynamics.forces)),
        "drives": (bodies.drives, tau),
        "inertia": (bodies.inertia, -inertial),
        "everything": (acting, np.zeros_like(tau)),
    }
    for kind, (actions, work) in wanted.items():
        np.testing.assert_allclose(work_of(actions), work, rtol=0, atol=1e-11 * size, err_msg=kind)


def free_bodies(mechanism: mq.Mechanism) -> FreeBodyForces:
    letters = Letters(mechanism)
    tree = Tree(letters)
    return FreeBodyForces(TapeDynamics(letters, tree, tree, "recursion"))


@pytest.mark.parametrize("name", ["four_bar_linkage", "rolling_coin", "crane"])
def test_reactions_are_those_on_the_children_of_joints_and_on_the_bodies_of_closures(
    name: str,
) -> None:
    mechanism = mq.textbook.load(name)
    reactions = free_bodies(mechanism).joint_reactions(shared=True)
    expected = [(joint.name, joint.child) for joint in mechanism.joints]
    expected += [(loop.name, loop.body_b) for loop in mechanism.loops]
    expected += [(contact.name, contact.body) for contact in mechanism.contacts]
    assert [(action.name, action.body) for action in reactions] == expected


@pytest.mark.parametrize("name", ["rolling_coin", "planetary_gear"])
def test_reactions_that_others_share_have_no_program(name: str) -> None:
    with pytest.raises(mq.DerivationError, match="have no program: its elements, contacts or"):
        free_bodies(mq.textbook.load(name)).joint_reactions()


def test_a_belt_has_its_preload_and_drives_the_drum() -> None:
    """By hand: the tensions differ by J a/r of the drum, and have the preload for their mean."""
    letters = Letters(DRIVE)
    tree = Tree(letters)
    bodies = FreeBodyForces(TapeDynamics(letters, tree, tree, "recursion"))
    states = random_states(DRIVE, 1, 0)
    values = values_of(list(bodies.guide_sizes.values()))
    ((first, second),) = evaluate(letters.tape, values, inputs_at(letters, states), 1)
    drum = 4.0 * 0.3**2 / 2
    turned = (2.0 / (1.0 * 0.1**2 / 2 + drum / 9)) / 3
    assert (first + second) / 2 == pytest.approx(40.0, rel=1e-12)
    assert abs(first - second) == pytest.approx(drum * turned / 0.3, rel=1e-12)


def test_a_slide_that_a_ball_leads_is_in_all_derivations_and_programs() -> None:
    ball = mq.Spherical("ball", "ground", "hull")
    a, *_, d = map(mq.coordinate, ball.coordinates)
    led = mq.Mechanism(
        "led",
        (mq.Body("ground"), mq.Body("hull", SKEW), mq.Body("rotor")),
        (ball, mq.Prismatic("turn", "ground", "rotor", armature=0.3)),
        forces=(mq.JointSpring("coil", "turn", 3.0), mq.JointDamper("oil", "turn", 2.0)),
        coordinates=mq.Coordinates((), {"turn": a * d}),
    )
    assert mq.verify(led, samples=2).agrees
    program = mq.generate(mq.derive(led), "python", ("acceleration",), samples=2)
    assert program.verdict is not None
    assert max(program.verdict.worst.values()) < 1e-12
