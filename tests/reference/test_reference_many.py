"""A tree in many states at once: energies, momenta, speeds and what acts from outside."""

from __future__ import annotations

import numpy as np
import pytest
from reference_samples import driven, flyer, tree

import mecanique as mq
from mecanique.model.states import States
from mecanique.reference import Reference

SAMPLES = {sample.__name__: sample for sample in (tree, flyer, driven)}
SYSTEMS = ("kapitza_pendulum", "rolling_coin", "bars_and_springs", "gyroscope", "governor")


@pytest.fixture(params=[*SAMPLES, *SYSTEMS], scope="module")
def reference(request: pytest.FixtureRequest) -> Reference:
    if request.param in SAMPLES:
        return Reference(SAMPLES[request.param]())
    return Reference.of(mq.textbook.load(request.param))


@pytest.fixture(scope="module")
def states(reference: Reference) -> States:
    """Four random states and accelerations."""
    mechanism, random = reference.mechanism, np.random.default_rng(3)
    away = random.uniform(-1.0, 1.0, (4, mechanism.nq))
    q = np.array([mechanism.normalize(mechanism.neutral() + each) for each in away])
    v, a = random.uniform(-1.0, 1.0, (2, 4, mechanism.nv))
    return States(mechanism, q, v, random.uniform(0.0, 1.0, 4), a)


def test_energies_and_momenta_are_what_the_engine_answers_one_by_one(
    reference: Reference, states: States
) -> None:
    q, v, t = states.q, states.v, states.t
    quick, energy = reference.quick_energies(q, v, t), reference.energy(q, v, t)
    np.testing.assert_allclose(quick, energy, rtol=1e-12, atol=1e-12)
    sums, momentum = reference.quick_momenta(q, v, t), reference.momentum(q, v, t)
    np.testing.assert_allclose(sums, momentum, rtol=1e-12, atol=1e-12)


def test_speeds_are_those_of_the_bodies_centers(reference: Reference, states: States) -> None:
    mechanism, q, v, t = reference.mechanism, states.q, states.v, states.t
    speeds = reference.center_speeds(q, v, t)
    for k, body in enumerate(mechanism.bodies):
        center = mechanism.evaluate_all(body.center)
        moves = reference.point(body.name, center, q, v, t=t).velocity
        np.testing.assert_allclose(
            speeds[:, k], np.linalg.norm(moves, axis=1), rtol=1e-12, atol=1e-13
        )


def test_the_resultant_sums_what_moves_the_bodies(reference: Reference, states: States) -> None:
    """Newton and Euler, body by body; what stands still takes no part."""
    mechanism, q, v, t, a = reference.mechanism, states.q, states.v, states.t, states.a
    moving = reference.motions(q, v, a, t)
    force, moment, first = np.zeros((3, 4, 3))
    mass = 0.0
    for k, body in enumerate(mechanism.bodies):
        turn = moving.poses[:, k, :3, :3]
        if not np.ptp(moving.poses[:, k], axis=0).any():
            continue
        m, center = mechanism.evaluate(body.mass), mechanism.evaluate_all(body.center)
        point = reference.point(body.name, center, q, v, a, t)
        xx, yy, zz, xy, xz, yz = mechanism.evaluate_all(body.inertia)
        tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        world = turn @ tensor @ turn.transpose(0, 2, 1)
        omega, alpha = moving.angular_velocities[:, k], moving.angular_accelerations[:, k]
        spin = np.einsum("nij,nj->ni", world, omega)
        push = m * point.acceleration
        force, first, mass = force + push, first + m * point.position, mass + m
        moment = moment + np.cross(point.position, push) + np.cross(omega, spin)
        moment = moment + np.einsum("nij,nj->ni", world, alpha)
    found = reference.resultant(q, v, t, a)
    np.testing.assert_allclose(found.force, force, rtol=1e-11, atol=1e-11)
    np.testing.assert_allclose(found.moment, moment, rtol=1e-11, atol=1e-11)
    np.testing.assert_allclose(found.center, first / mass, rtol=1e-11, atol=1e-12)
