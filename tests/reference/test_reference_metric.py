"""Constraints judged by kinetic energy: no matter how large a part is or which joints are loops."""

from __future__ import annotations

import numpy as np
import pytest
from reference_samples import four_bars, parallelograms
from scipy.integrate import solve_ivp

import mecanique as mq
from mecanique.model import Mechanism
from mecanique.reference.loops.closed import Closed

LINKAGES = [
    name for name in mq.textbook.names() if mq.textbook.load(name).loops and name != "squeezer"
]
GUESS = {"A": 1.0, "B": -0.3, "C": 1.8}
SIZES = [(1e-2, 1e-3), (1e-3, 1e-6), (1e-4, 1e-12)]


def closed_of(mechanism: Mechanism) -> Closed:
    closed = mq.Reference(mechanism).closed
    assert closed is not None
    return closed


def assembled(mechanism: Mechanism) -> np.ndarray:
    return mq.assemble(mechanism, {name: GUESS[name[0]] for name in mechanism.coordinates.names})


@pytest.mark.parametrize("name", LINKAGES)
def test_directions_of_the_metric_carry_unit_energy_each(name: str) -> None:
    mechanism = mq.textbook.load(name)
    reference, q = mq.Reference(mechanism), mq.assemble(mechanism)
    closed = closed_of(mechanism)
    jacobian = closed.closures.at(q, np.zeros(mechanism.nv), 0.0).jacobian
    metric = closed.measure(jacobian)
    C = metric.columns
    np.testing.assert_allclose(C.T @ reference.mass_matrix(q) @ C, np.diag(metric.mass), atol=1e-12)
    np.testing.assert_allclose(metric.inverse @ C, np.eye(mechanism.nv), atol=1e-10)
    root = closed._mass_root()
    np.testing.assert_allclose(root.T @ root, reference.mass_matrix(q), rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("count", [2, 10, 40])
@pytest.mark.parametrize("angle", [0.3, 1.2, 1.5238, 1.5698])
def test_what_is_singular_hardly_depends_on_the_tree(count: int, angle: float) -> None:
    """The same parallelograms, hung one on the next, or each on uprights of its own."""
    least = []
    for serial in (True, False):
        mechanism = parallelograms(count, serial=serial)
        closed = closed_of(mechanism)
        q = mechanism.position(
            {joint.name: angle if "up" in joint.child else -angle for joint in mechanism.joints}
        )
        jacobian = closed.closures.at(q, np.zeros(mechanism.nv), 0.0).jacobian
        values = np.linalg.svd(closed.measure(jacobian).scale(jacobian), compute_uv=False)
        assert 0.5 < values[0] < 1.5
        least.append(values[2 * count - 1])
        off = np.pi / 2 - angle
        assert 0.2 / count < least[-1] / np.sin(off) < 1.5
    assert 0.9 / count < least[1] / least[0] < 2


@pytest.mark.parametrize(("length", "mass"), SIZES)
def test_a_small_loop_beside_a_large_one_accelerates_as_if_alone(
    length: float, mass: float
) -> None:
    small, large = four_bars((length, mass)), four_bars((1.0, 10.0))
    both = four_bars((length, mass), (1.0, 10.0))
    positions = assembled(small), assembled(large)
    alone = [
        mq.Reference(mechanism).acceleration(q)
        for mechanism, q in zip((small, large), positions, strict=True)
    ]
    a = mq.Reference(both).acceleration(np.concatenate(positions))
    np.testing.assert_allclose(a, np.concatenate(alone), rtol=1e-12)


@pytest.mark.parametrize(("length", "mass"), SIZES)
def test_a_small_loop_beside_a_large_one_is_verified_linearized_and_moved(
    length: float, mass: float
) -> None:
    both = four_bars((length, mass), (1.0, 10.0))
    verdict = mq.verify(both, samples=20)
    assert verdict.agrees
    assert verdict.worst < 1e-12
    q = assembled(both)
    small = mq.simulate(four_bars((length, mass)), q=q[:3], duration=0.02)
    motion = mq.simulate(both, q=q, duration=0.02)
    np.testing.assert_allclose(motion.q[-1, :3], small.q[-1], rtol=1e-8)
    assert motion.statistics.steps <= 2 * small.statistics.steps


def hanging_frequencies(*parts: tuple[float, float]) -> np.ndarray:
    """Of small motions about the equilibrium in which each part hangs [rad/s]."""
    alone = four_bars((1.0, 1.0))
    near = mq.assemble(alone, {"A0": -1.0, "B0": 0.3, "C0": -1.8})
    mechanism = four_bars(*parts)
    rest = mq.equilibria(mechanism, [np.tile(near, len(parts))])[0]
    return np.sort(mq.linearize(mechanism, at=rest.q).frequencies)


def test_similar_linkages_have_similar_frequencies() -> None:
    """Lengths by a thousandth make them sqrt(1000) times as high."""
    (large,) = hanging_frequencies((1.0, 10.0))
    both = hanging_frequencies((1e-3, 1e-6), (1.0, 10.0))
    np.testing.assert_allclose(both, [large, large * np.sqrt(1000)], rtol=1e-8)


def fall_of_parallelograms(count: int, t: np.ndarray) -> np.ndarray:
    """The angle of the uprights over time: a pendulum, whose rods across only move along."""
    inertia, moment = (count + 1) / 3 + count, 9.81 * ((count + 1) / 2 + count)
    fall = solve_ivp(
        lambda t, y: [y[1], moment / inertia * np.sin(y[0])],
        (t[0], t[-1]),
        [0.0, -1.0],
        method="DOP853",
        t_eval=t,
        rtol=1e-13,
        atol=1e-13,
    )
    return np.asarray(fall.y[0])


@pytest.mark.parametrize("serial", [True, False])
@pytest.mark.parametrize("count", [2, 20])
def test_a_row_of_parallelograms_passes_flat_positions_in_any_tree(
    count: int, serial: bool
) -> None:
    """Where all lie flat, each could cross over into an antiparallelogram."""
    mechanism = parallelograms(count, serial=serial)
    rates = {
        joint.name: -1.0 if joint.child.startswith("up") else 1.0 for joint in mechanism.joints
    }
    motion = mq.simulate(mechanism, v=rates, duration=3.0, samples=11)
    assert motion["A0"][-1] < -2 * np.pi
    np.testing.assert_allclose(motion["A0"], fall_of_parallelograms(count, motion.t), atol=1e-8)
