"""Identities of every mechanism: power, momentum, balance of bodies, kinematics by differences."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt
import pytest
from reference_samples import driven, flyer, states, tree

from mecanique import textbook
from mecanique.model import Fixed, Mechanism, Prismatic, Revolute
from mecanique.model.expression import evaluate
from mecanique.model.forces import (
    Damper,
    Force,
    JointDamper,
    JointForce,
    JointSpring,
    Spring,
    Torque,
)
from mecanique.reference import Reference

Array = npt.NDArray[np.float64]
SAMPLES = [tree, flyer, driven]
STEP = 1e-4


@pytest.fixture(params=SAMPLES, ids=lambda sample: sample.__name__, scope="module")
def reference(request: pytest.FixtureRequest) -> Reference:
    return Reference(request.param())


def moved(reference: Reference, q: Array, v: Array, a: Array, h: float) -> tuple[Array, Array]:
    """The state a time h later under a constant a, to fourth order in h (Runge–Kutta)."""
    v1, v2 = v + h / 2 * a, v + h * a
    k1 = reference.rates(q, v)
    k2 = reference.rates(q + h / 2 * k1, v1)
    k3 = reference.rates(q + h / 2 * k2, v1)
    k4 = reference.rates(q + h * k3, v2)
    return q + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4), v2


def difference(
    reference: Reference, q: Array, v: Array, a: Array, t: float, f: Callable[..., Array]
) -> Array:
    """The rate of a function of q, v and t along the motion, fourth order central difference."""
    values = {
        k: np.asarray(f(*moved(reference, q, v, a, k * STEP), t + k * STEP)) for k in (-2, -1, 1, 2)
    }
    rate: Array = (8 * (values[1] - values[-1]) - (values[2] - values[-2])) / (12 * STEP)
    return rate


def actions(
    mechanism: Mechanism, reference: Reference, q: Array, v: Array, t: float
) -> dict[str, Array]:
    """Force and moment about the world's origin on each body, from the forces' definitions."""
    pose = dict(zip((body.name for body in mechanism.bodies), reference.poses(q, t), strict=True))
    total = {body.name: np.zeros(6) for body in mechanism.bodies}
    symbols = {
        **mechanism.values,
        **dict(zip(mechanism.coordinates, q, strict=True)),
        **dict(zip(mechanism.velocities, v, strict=True)),
        "t": t,
    }
    symbols |= {signal.symbol: signal.function(mechanism.values)(t) for signal in mechanism.inputs}

    def add(body: str, point: Array, force: Array, torque: Array | None = None) -> None:
        total[body][:3] += force
        total[body][3:] += np.cross(point, force) + (0 if torque is None else torque)

    for force in mechanism.forces:
        match force:
            case Spring() | Damper():
                ends = [
                    reference.point(body, [mechanism.evaluate(c) for c in point], q, v, t=t)
                    for body, point in (
                        (force.body_a, force.point_a),
                        (force.body_b, force.point_b),
                    )
                ]
                line = ends[1].position - ends[0].position
                length = float(np.linalg.norm(line))
                if isinstance(force, Spring):
                    tension = mechanism.evaluate(force.stiffness) * (
                        length - mechanism.evaluate(force.free_length)
                    )
                else:
                    rate = float(line @ (ends[1].velocity - ends[0].velocity)) / length
                    tension = mechanism.evaluate(force.damping) * rate
                add(force.body_a, ends[0].position, tension * line / length)
                add(force.body_b, ends[1].position, -tension * line / length)
            case Force() | Torque():
                axes = np.eye(3) if force.axes == "world" else pose[force.axes][:3, :3]
                given = force.force if isinstance(force, Force) else force.torque
                vector = axes @ [float(evaluate(c, symbols)) for c in given]
                if isinstance(force, Force):
                    point = pose[force.body] @ [*(mechanism.evaluate(c) for c in force.point), 1]
                    add(force.body, point[:3], vector)
                else:
                    add(force.body, np.zeros(3), np.zeros(3), vector)
            case JointSpring() | JointDamper() | JointForce():
                joint = mechanism.joint(force.joint)
                assert isinstance(joint, (Revolute, Prismatic))
                at, rate_at = joint_value(mechanism, reference, joint.name, q, v, t)
                if isinstance(force, JointSpring):
                    size = -mechanism.evaluate(force.stiffness) * (
                        at - mechanism.evaluate(force.reference)
                    )
                elif isinstance(force, JointDamper):
                    size = -mechanism.evaluate(force.damping) * rate_at
                else:
                    assert isinstance(force, JointForce)
                    size = float(evaluate(force.force, symbols))
                axis = size * pose[joint.child][:3, :3] @ joint.axis
                origin = pose[joint.child][:3, 3]
                turning = isinstance(joint, Revolute)
                for body, sign in ((joint.child, 1), (joint.parent, -1)):
                    if turning:
                        add(body, origin, np.zeros(3), sign * axis)
                    else:
                        add(body, origin, sign * axis)
    return total


def joint_value(
    mechanism: Mechanism, reference: Reference, name: str, q: Array, v: Array, t: float
) -> tuple[float, float]:
    """A joint's coordinate and its rate."""
    joint = mechanism.joint(name)
    expression = mechanism.coordinates.driven.get(joint.coordinates[0])
    if expression is None:
        at = mechanism.coordinates.index(joint.coordinates[0])
        return float(q[at]), float(v[mechanism.velocities.index(f"{joint.coordinates[0]}'")])

    def value(h: float) -> float:
        later, _ = moved(reference, q, v, np.zeros_like(v), h)
        symbols = {
            **mechanism.values,
            **dict(zip(mechanism.coordinates, later, strict=True)),
            "t": t + h,
        }
        symbols |= {
            signal.symbol: signal.function(mechanism.values)(t + h) for signal in mechanism.inputs
        }
        return float(evaluate(expression, symbols))

    h = 1e-3
    return value(0), (8 * (value(h) - value(-h)) - (value(2 * h) - value(-2 * h))) / (12 * h)


def test_every_body_obeys_newton_and_euler(reference: Reference) -> None:
    """m a = forces and d(angular momentum)/dt = moments, reactions included."""
    mechanism = reference.mechanism
    gravity = np.array([mechanism.evaluate(g) for g in mechanism.gravity])
    for q, v, t in states(mechanism, 3):
        a = reference.acceleration(q, v, t)
        wrenches = reference.totals(q, v, t)
        poses = dict(
            zip((body.name for body in mechanism.bodies), reference.poses(q, t), strict=True)
        )
        loads = actions(mechanism, reference, q, v, t)
        for body in mechanism.bodies:
            if body.name == mechanism.ground:
                continue

            def momentum(q: Array, v: Array, t: float, name: str = body.name) -> Array:
                return body_momentum(mechanism, reference, name, q, v, t)

            rate = difference(reference, q, v, a, t, momentum)
            mass = mechanism.evaluate(body.mass)
            center = (poses[body.name] @ [*(mechanism.evaluate(c) for c in body.center), 1])[:3]
            total = loads[body.name].copy()
            total[:3] += mass * gravity
            total[3:] += np.cross(center, mass * gravity)
            for joint in mechanism.joints:
                sign = 1 if joint.child == body.name else -1 if joint.parent == body.name else 0
                wrench, origin = wrenches[joint.name], poses[joint.child][:3, 3]
                total[:3] += sign * wrench.force
                total[3:] += sign * (wrench.moment + np.cross(origin, wrench.force))
            assert rate == pytest.approx(total, abs=2e-8 * (1 + np.abs(total).max()))


def body_momentum(
    mechanism: Mechanism, reference: Reference, name: str, q: Array, v: Array, t: float
) -> Array:
    """Linear and angular momentum of one body about the origin, from the motion of its points."""
    body = mechanism.body(name)
    pose = reference.poses(q, t)[[b.name for b in mechanism.bodies].index(name)]
    turn = pose[:3, :3]
    center = [mechanism.evaluate(c) for c in body.center]
    origin, middle = (reference.point(name, xyz, q, v, t=t) for xyz in ((0, 0, 0), center))
    arms = [reference.point(name, xyz, q, v, t=t) for xyz in np.eye(3)]
    # ω from the velocities of three arms: ω = ½ Σ e × (de/dt)
    spin = 0.5 * sum(
        (np.cross(arm.position - origin.position, arm.velocity - origin.velocity) for arm in arms),
        np.zeros(3),
    )
    ixx, iyy, izz, ixy, ixz, iyz = (mechanism.evaluate(entry) for entry in body.inertia)
    inertia = turn @ np.array([[ixx, ixy, ixz], [ixy, iyy, iyz], [ixz, iyz, izz]]) @ turn.T
    linear = mechanism.evaluate(body.mass) * middle.velocity
    return np.concatenate([linear, np.cross(middle.position, linear) + inertia @ spin])


def test_reactions_have_nothing_along_free_axes(reference: Reference) -> None:
    mechanism = reference.mechanism
    rotors = {"elbow": 0.2, "rail": 0.3}
    for q, v, t in states(mechanism, 3):
        a = reference.acceleration(q, v, t)
        poses = dict(
            zip((body.name for body in mechanism.bodies), reference.poses(q, t), strict=True)
        )
        for joint in mechanism.joints:
            if (
                not isinstance(joint, (Revolute, Prismatic))
                or joint.coordinate in mechanism.coordinates.driven
            ):
                continue
            wrench = reference.reactions(q, v, t)[joint.name]
            axis = poses[joint.child][:3, :3] @ joint.axis
            along = wrench.moment if isinstance(joint, Revolute) else wrench.force
            rotor = (
                rotors.get(joint.name, 0) * a[mechanism.velocities.index(f"{joint.coordinate}'")]
            )
            assert along @ axis == pytest.approx(-rotor, abs=1e-10 * (1 + np.abs(along).max()))


def test_accelerations_satisfy_the_equations(reference: Reference) -> None:
    for q, v, t in states(reference.mechanism, 5):
        a = reference.acceleration(q, v, t)
        left = reference.mass_matrix(q, t) @ a + reference.bias(q, v, t)
        right = reference.forces(q, v, t)
        scale = np.abs(reference.mass_matrix(q, t)).max() * np.abs(a).max() + np.abs(right).max()
        assert left == pytest.approx(right, abs=1e-12 * scale)
        assert reference.inverse_dynamics(q, v, a, t) == pytest.approx(
            np.zeros_like(a), abs=1e-12 * scale
        )


@pytest.mark.parametrize("sample", [tree, flyer])
def test_power_is_the_rate_of_energy(sample: Callable[[], Mechanism]) -> None:
    """dT/dt + dV_g/dt = forces · v where nothing is prescribed."""
    mechanism = sample()
    reference = Reference(mechanism)
    for q, v, t in states(mechanism, 3):
        a = reference.acceleration(q, v, t)

        def energy(q: Array, v: Array, t: float) -> Array:
            parts = reference.energy(q, v, t)
            return np.array([parts.kinetic + parts.gravity, parts.gravity])

        mechanical, height = difference(reference, q, v, a, t, energy)
        assert mechanical == pytest.approx(reference.forces(q, v, t) @ v, rel=1e-7)
        assert height == pytest.approx(reference.gravity(q, t) @ v, rel=1e-7)


def test_a_prescribed_motion_obeys_lagrange() -> None:
    """d(∂L/∂v)/dt − ∂L/∂q = Q with L from the energies; G, c and γ all have their part in it."""
    mechanism = driven()
    reference = Reference(mechanism)
    for q, v, t in states(mechanism, 3):
        M, h = reference.mass_matrix(q, t), 1e-3
        # T is quadratic in v: its second difference is M, its first is ∂T/∂v exactly
        kinetic = [reference.energy(q, x, t).kinetic for x in (v, -v, 0 * v)]
        assert kinetic[0] + kinetic[1] - 2 * kinetic[2] == pytest.approx(v @ M @ v, rel=1e-10)
        a = reference.acceleration(q, v, t)

        def momentum(q: Array, v: Array, t: float) -> Array:
            unit = np.eye(len(v))
            return (
                np.array(
                    [
                        reference.energy(q, v + e, t).kinetic
                        - reference.energy(q, v - e, t).kinetic
                        for e in unit
                    ]
                )
                / 2
            )

        rate = difference(reference, q, v, a, t, momentum)
        slope = []
        for e in np.eye(len(q)) * h:
            parts = [reference.energy(q + k * e, v, t) for k in (-2, -1, 1, 2)]
            L = [part.kinetic - part.gravity for part in parts]
            slope.append((8 * (L[2] - L[1]) - (L[3] - L[0])) / (12 * h))
        assert rate - np.array(slope) == pytest.approx(
            reference.forces(q, v, t), abs=1e-7 * (1 + np.abs(slope).max())
        )


def test_momenta_are_those_of_the_bodies(reference: Reference) -> None:
    mechanism = reference.mechanism
    for q, v, t in states(mechanism, 2):
        total = sum(
            (body_momentum(mechanism, reference, b.name, q, v, t) for b in mechanism.bodies),
            np.zeros(6),
        )
        momentum = reference.momentum(q, v, t)
        assert momentum.linear == pytest.approx(total[:3], abs=1e-12)
        assert momentum.angular == pytest.approx(total[3:], abs=1e-12)
        center = reference.center_of_mass(q, t=t).position
        shifted = total[3:] - np.cross(center, total[:3])
        assert momentum.angular_about_center == pytest.approx(shifted, abs=1e-12)


def test_points_move_as_their_positions_do(reference: Reference) -> None:
    mechanism = reference.mechanism
    xyz = (0.3, -0.2, 0.5)
    for q, v, t in states(mechanism, 2):
        a = np.linspace(-1, 1, mechanism.nv)
        for body in mechanism.bodies:
            point = reference.point(body.name, xyz, q, v, a, t)

            def position(q: Array, v: Array, t: float, name: str = body.name) -> Array:
                return reference.point(name, xyz, q, v, t=t).position

            def speed(q: Array, v: Array, t: float, name: str = body.name) -> Array:
                return reference.point(name, xyz, q, v, t=t).velocity

            assert difference(reference, q, v, a, t, position) == pytest.approx(
                point.velocity, abs=1e-8
            )
            assert difference(reference, q, v, a, t, speed) == pytest.approx(
                point.acceleration, abs=1e-7
            )


def test_bodies_move_as_their_points_do(reference: Reference) -> None:
    mechanism, xyz = reference.mechanism, (0.1, -0.2, 0.3)
    q, v, t = map(np.array, zip(*states(mechanism, 3), strict=True))
    a = np.tile(np.linspace(-1, 1, mechanism.nv), (3, 1))
    moving = reference.motions(q, v, a, t)
    assert (moving.poses[..., 3, :] == (0, 0, 0, 1)).all()
    for k, body in enumerate(mechanism.bodies):
        point = reference.point(body.name, xyz, q, v, a, t)
        arm = moving.poses[:, k, :3, :3] @ xyz
        omega, alpha = moving.angular_velocities[:, k], moving.angular_accelerations[:, k]
        assert moving.poses[:, k, :3, 3] + arm == pytest.approx(point.position, abs=1e-12)
        velocity = moving.velocities[:, k] + np.cross(omega, arm)
        assert velocity == pytest.approx(point.velocity, abs=1e-12)
        turning = np.cross(alpha, arm) + np.cross(omega, np.cross(omega, arm))
        acceleration = moving.accelerations[:, k] + turning
        assert acceleration == pytest.approx(point.acceleration, abs=1e-11)


def test_the_right_hand_side_is_the_acceleration(reference: Reference) -> None:
    f = reference.rhs()
    mechanism = reference.mechanism
    kept = []
    for q, v, t in states(mechanism, 4):
        y = f(t, np.concatenate([q, v]))
        kept.append((y, y.copy()))
        assert y[: mechanism.nq] == pytest.approx(reference.rates(q, v), abs=1e-14)
        a = reference.acceleration(q, v, t)
        assert y[mechanism.nq :] == pytest.approx(a, abs=1e-10 * (1 + np.abs(a).max()))
    assert all((y == copy).all() for y, copy in kept), "each answer is an array of its own"


def test_many_states_give_what_each_gives(reference: Reference) -> None:
    mechanism = reference.mechanism
    lot = states(mechanism, 3)
    q, v, t = (np.array(parts) for parts in zip(*lot, strict=True))
    answers = {
        "mass": (reference.mass_matrix(q, t), [reference.mass_matrix(a, c) for a, b, c in lot]),
        "bias": (reference.bias(q, v, t), [reference.bias(*one) for one in lot]),
        "forces": (reference.forces(q, v, t), [reference.forces(*one) for one in lot]),
        "acceleration": (
            reference.acceleration(q, v, t),
            [reference.acceleration(*one) for one in lot],
        ),
        "energy": (
            np.stack(reference.energy(q, v, t), axis=1),
            [reference.energy(*one) for one in lot],
        ),
        "poses": (reference.poses(q, t), [reference.poses(a, c) for a, b, c in lot]),
        "momentum": (
            np.stack(reference.momentum(q, v, t), axis=1),
            [reference.momentum(*one) for one in lot],
        ),
        "rates": (reference.rates(q, v), [reference.rates(a, b) for a, b, c in lot]),
    }
    for name, (many, each) in answers.items():
        each_alone = np.array(each)
        assert many.shape == each_alone.shape, name
        assert many == pytest.approx(each_alone, rel=1e-12, abs=1e-12), name
    wrenches = reference.totals(q, v, t)
    for k, one in enumerate(lot):
        for name, wrench in reference.totals(*one).items():
            assert wrenches[name].force[k] == pytest.approx(wrench.force, rel=1e-12, abs=1e-12)
            assert wrenches[name].moment[k] == pytest.approx(wrench.moment, rel=1e-12, abs=1e-12)


def test_the_samples_hold_every_joint_and_every_force() -> None:
    kinds = {type(joint) for sample in SAMPLES for joint in sample().joints}
    assert len(kinds) == 7
    assert Fixed in kinds
    forces = {type(force) for sample in SAMPLES for force in sample().forces}
    assert forces == {Spring, Damper, JointSpring, JointDamper, JointForce, Force, Torque}


@pytest.mark.parametrize("name", ["rigid_bar_pendulum", "double_pendulum", "n_link_pendulum"])
def test_answers_are_arrays_of_their_own_unless_they_may_be_overwritten(name: str) -> None:
    reference = Reference(textbook.load(name))
    first, second = np.full((2, 2 * reference.mechanism.nv), 0.3) * [[1.0], [2.0]]
    own, fast = reference.rhs(), reference.rhs(overwriting=True)
    kept = own(0.0, first)
    assert own(0.0, second) is not kept
    np.testing.assert_array_equal(kept, own(0.0, first))
    again = fast(0.0, first)
    np.testing.assert_array_equal(again, kept)
    assert fast(0.0, second) is again
