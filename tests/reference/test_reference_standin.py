"""Where Pinocchio has no package its stand-in answers the same."""

from __future__ import annotations

import subprocess
import sys
from textwrap import dedent
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import mecanique as mq
from mecanique.reference import standin
from mecanique.urdf.write import write_urdf

NAMES = ["cart_pole", "bead_on_hoop", "free_rigid_body", "gyroscope", "n_link_pendulum"]
FIELDS = ("v", "a_gf", "f")


@pytest.fixture(params=[*NAMES, "panda", "solo"])
def both(request: pytest.FixtureRequest) -> tuple[Any, Any, np.ndarray, np.ndarray, np.ndarray]:
    """A model in Pinocchio and in its stand-in, with a state in which each moves alike."""
    import pinocchio

    name = request.param
    mechanism = (
        mq.textbook.load(name)
        if name in NAMES
        else mq.read_urdf(mq.robot(name), root="floating" if name == "solo" else "fixed")
    )
    text = write_urdf(mechanism, spherical="floating")
    a, b = pinocchio.buildModelFromXML(text), standin.buildModelFromXML(text)
    random = np.random.default_rng(0)
    q = pinocchio.integrate(a, pinocchio.neutral(a), random.normal(size=a.nv))
    armature = random.uniform(0.0, 0.1, a.nv)
    a.armature = armature
    b.armature = np.array([armature[i] for i in order(a, b)])
    return a, b, q, random.normal(size=a.nv), random.normal(size=a.nv)


def order(a: Any, b: Any) -> list[int]:
    """Where each velocity of the stand-in stands in Pinocchio's."""
    places: list[int] = []
    for index in range(1, b.njoints):
        joint = a.joints[a.getJointId(b.names[index])]
        places += range(joint.idx_v, joint.idx_v + joint.nv)
    return places


def positions(a: Any, b: Any, q: np.ndarray) -> np.ndarray:
    parts = []
    for index in range(1, b.njoints):
        joint = a.joints[a.getJointId(b.names[index])]
        parts.append(q[joint.idx_q : joint.idx_q + joint.nq])
    return np.concatenate(parts)


@pytest.mark.engine
def test_recursions_are_those_of_pinocchio(both: Any) -> None:
    import pinocchio

    a, b, q, v, acc = both
    own = order(a, b)
    there, here = a.createData(), b.createData()
    p = positions(a, b, q)
    wrenches = np.random.default_rng(1).normal(size=(a.njoints, 6))
    of_a, of_b = pinocchio.StdVec_Force(), [standin.Force.Zero() for _ in range(b.njoints)]
    for index in range(a.njoints):
        of_a.append(pinocchio.Force(wrenches[index]))
    for index in range(1, b.njoints):
        of_b[index].vector[:] = wrenches[a.getJointId(b.names[index])]

    def same(expected: Any, found: Any) -> None:
        np.testing.assert_allclose(found, expected, rtol=1e-11, atol=1e-11)

    same(
        pinocchio.rnea(a, there, q, v, acc, of_a)[own],
        standin.rnea(b, here, p, v[own], acc[own], of_b),
    )
    same(there.a_gf[0].vector, here.a_gf[0].vector)
    for index in range(1, b.njoints):
        twin = a.getJointId(b.names[index])
        for field in FIELDS:
            same(getattr(there, field)[twin].vector, getattr(here, field)[index].vector)
    same(
        pinocchio.nonLinearEffects(a, there, q, v)[own],
        standin.nonLinearEffects(b, here, p, v[own]),
    )
    same(
        pinocchio.computeGeneralizedGravity(a, there, q)[own],
        standin.computeGeneralizedGravity(b, here, p),
    )
    same(pinocchio.crba(a, there, q)[np.ix_(own, own)], standin.crba(b, here, p))
    for index in range(1, b.njoints):
        twin = there.Ycrb[a.getJointId(b.names[index])]
        same([twin.mass, *twin.lever], [here.Ycrb[index].mass, *here.Ycrb[index].lever])
    same(
        pinocchio.aba(a, there, q, v, acc, of_a)[own],
        standin.aba(b, here, p, v[own], acc[own], of_b),
    )
    pinocchio.forwardKinematics(a, there, q, v, acc)
    standin.forwardKinematics(b, here, p, v[own], acc[own])
    pinocchio.computeJointJacobiansTimeVariation(a, there, q, v)
    standin.computeJointJacobiansTimeVariation(b, here, p, v[own])
    same(there.J.reshape(6, -1)[:, own], here.J)
    same(there.dJ.reshape(6, -1)[:, own], here.dJ)
    same(pinocchio.computePotentialEnergy(a, there, q), standin.computePotentialEnergy(b, here, p))
    for index, frame in enumerate(b.frames):
        if not frame.parentJoint:
            continue
        twin = a.getFrameId(frame.name, pinocchio.BODY)
        world = pinocchio.ReferenceFrame.LOCAL_WORLD_ALIGNED
        expected = pinocchio.computeFrameJacobian(a, there, q, twin, world).reshape(6, -1)[:, own]
        same(expected, standin.computeFrameJacobian(b, here, p, index, "world"))
    pinocchio.framesForwardKinematics(a, there, q)
    standin.framesForwardKinematics(b, here, p)
    for index, frame in enumerate(b.frames):
        twin = a.getFrameId(frame.name, pinocchio.BODY)
        same(there.oMf[twin].homogeneous, here.oMf[index].homogeneous)


@pytest.mark.parametrize("angle", [0.0, 1e-9, 0.5, 3.0, np.pi - 1e-9, np.pi])
def test_the_rotation_vector_of_a_turn(angle: float) -> None:
    vector = angle * np.array([0.6, 0.0, 0.8])
    found = standin.log3(Rotation.from_rotvec(vector).as_matrix())
    np.testing.assert_allclose(found, vector, rtol=0, atol=1e-8 * angle)


def test_a_pose_is_its_matrix() -> None:
    matrix = np.eye(4)
    matrix[:3, :3] = Rotation.from_rotvec([0.3, -0.5, 0.2]).as_matrix()
    matrix[:3, 3] = 1.0, 2.0, 3.0
    np.testing.assert_array_equal(standin.SE3(matrix).homogeneous, matrix)


@pytest.mark.slow
def test_without_pinocchio_everything_goes_on_and_the_verdict_says_so() -> None:
    script = """
        import sys
        sys.modules["pinocchio"] = None  # as if it were not installed
        import mecanique as mq
        cart, slider = mq.textbook.load("cart_pole"), mq.textbook.load("slider_crank")
        verdict = mq.verify(cart, samples=5)
        assert verdict.agrees and verdict.worst < 1e-13
        first, second, *_ = str(verdict).splitlines()
        assert first.startswith("The engine Pinocchio is not installed: a stand-in of mecanique's")
        assert "from conda-forge" in first and second.startswith("cart_pole: agrees")
        assert first in verdict._repr_html_().replace("&#x27;", "'")
        assert verdict.versions["pin"] == "not installed"
        assert "difference from stand-in" in str(verdict)
        assert mq.verify(slider, samples=3).agrees
        motion = mq.simulate(slider, q=dict(mq.textbook.entry("slider_crank").start), duration=0.2)
        assert motion.audit().ok
        assert abs(mq.linearize(cart).frequencies[-1] - 3.83594114) < 1e-8
        code = mq.generate(mq.derive(cart), "python", samples=5)
        assert "compared with a stand-in for Pinocchio" in str(code.verdict)
        panda = mq.verify(mq.read_urdf(mq.robot("panda")), samples=2)
        assert panda.agrees and not panda.readings
    """
    subprocess.run([sys.executable, "-c", dedent(script)], check=True)


def test_wrenches_are_transformed_there_and_back() -> None:
    place = standin.SE3(Rotation.from_rotvec([0.3, -0.5, 0.8]).as_matrix(), np.array([1.0, 2, -3]))
    wrench = standin.Force(np.array([1.0, -2.0, 0.5]), np.array([0.3, 0.7, -0.2]))
    for there, back in ((place.act, place.actInv), (place.actInv, place.act)):
        same = back(there(wrench))
        np.testing.assert_allclose(same.linear, wrench.linear, rtol=0, atol=1e-14)
        np.testing.assert_allclose(same.angular, wrench.angular, rtol=0, atol=1e-14)


def test_force_and_moment_are_set_where_they_are_read() -> None:
    wrench = standin.Force(np.arange(6.0))
    wrench.linear, wrench.angular = np.array([7.0, 8, 9]), np.array([4.0, 6, 5])
    np.testing.assert_array_equal(wrench.vector, [7, 8, 9, 4, 6, 5])
    np.testing.assert_array_equal(wrench.angular, [4, 6, 5])
    wrench.angular += 1.0
    wrench.linear -= 1.0
    np.testing.assert_array_equal(wrench.vector, [6, 7, 8, 5, 7, 6])


def test_wrenches_add_up() -> None:
    a, b = standin.Force(np.arange(6.0)), standin.Force(np.array([1.0, -1, 2, 0, 3, -2]))
    np.testing.assert_array_equal((a + b).vector, [1, 0, 4, 3, 7, 3])
    np.testing.assert_array_equal((a - b).vector, [-1, 2, 0, 3, 1, 7])


def test_momenta_and_their_rates_follow_from_a_twist() -> None:
    """P = m (v + w × c), L = I w + c × P; carried along they change by w × P and w × L + v × P."""
    rng = np.random.default_rng(5)
    v, w, c, P, L = rng.normal(size=(5, 3))
    root = rng.normal(size=(3, 3))
    inertia, twist = standin.Inertia(1.7, c, root @ root.T), standin.Motion(np.hstack([v, w]))
    momentum = inertia * twist
    push = 1.7 * (v + np.cross(w, c))
    np.testing.assert_allclose(momentum.linear, push, rtol=0, atol=1e-14)
    spin = root @ root.T @ w + np.cross(c, push)
    np.testing.assert_allclose(momentum.angular, spin, rtol=0, atol=1e-13)
    rate = twist.cross(standin.Force(P, L))
    np.testing.assert_allclose(rate.linear, np.cross(w, P), rtol=0, atol=1e-14)
    expected = np.cross(w, L) + np.cross(v, P)
    np.testing.assert_allclose(rate.angular, expected, rtol=0, atol=1e-14)


def test_origins_turn_by_roll_then_pitch_then_yaw_about_fixed_axes() -> None:
    text = """<robot name="arm"><link name="base"/><link name="arm"><inertial>
        <origin xyz="0.1 0.2 0.3" rpy="-0.4 0.2 0.9"/><mass value="2"/>
        <inertia ixx="0.5" ixy="0.05" ixz="-0.03" iyy="0.6" iyz="0.02" izz="0.4"/>
        </inertial></link><joint name="pin" type="revolute"><parent link="base"/>
        <child link="arm"/><origin xyz="1 2 3" rpy="0.3 -0.5 0.8"/><axis xyz="0 3 4"/></joint>
        </robot>"""
    model = standin.buildModelFromXML(text)
    placement, inertia = model.jointPlacements[1], model.inertias[1]
    turn = Rotation.from_euler("xyz", [0.3, -0.5, 0.8]).as_matrix()
    np.testing.assert_allclose(placement.rotation, turn, rtol=0, atol=1e-15)
    np.testing.assert_array_equal(placement.translation, [1, 2, 3])
    np.testing.assert_allclose(model.joints[1].axis, [0, 0.6, 0.8], rtol=1e-15, atol=0)
    own = np.array([[0.5, 0.05, -0.03], [0.05, 0.6, 0.02], [-0.03, 0.02, 0.4]])
    axes = Rotation.from_euler("xyz", [-0.4, 0.2, 0.9]).as_matrix()
    np.testing.assert_allclose(inertia.inertia, axes @ own @ axes.T, rtol=0, atol=1e-15)
    np.testing.assert_allclose(inertia.lever, [0.1, 0.2, 0.3], rtol=1e-15, atol=0)
    assert inertia.mass == 2.0


def test_inertias_add_up_about_their_common_center() -> None:
    """Two particles of 1 and 3 kg, 4 m apart: the center at 3 m, and 3/4 · 16 kg·m² about it."""
    nothing = np.zeros((3, 3))
    one = standin.Inertia(1.0, np.array([0.0, 0.0, 1.0]), nothing)
    other = standin.Inertia(3.0, np.array([4.0, 0.0, 1.0]), nothing)
    both = one + other
    assert both.mass == 4.0
    np.testing.assert_allclose(both.lever, [3, 0, 1], rtol=0, atol=1e-15)
    np.testing.assert_allclose(both.inertia, np.diag([0, 12.0, 12.0]), rtol=0, atol=1e-14)
    # about the origin they are sums
    np.testing.assert_allclose(both.matrix(), one.matrix() + other.matrix(), rtol=0, atol=1e-13)
    light = standin.Inertia(0.0, np.zeros(3), np.eye(3))
    np.testing.assert_array_equal((light + light).inertia, 2 * np.eye(3))
    assert (light + light).mass == 0.0
