"""Constraints judged by kinetic energy: no matter how large a part is or which joints are loops."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from reference_samples import four_bars, parallelograms
from scipy.integrate import solve_ivp

import mecanique as mq
from mecanique.model import Mechanism, Revolute
from mecanique.reference.loops.assembly import Tangent, newton, settle
from mecanique.reference.loops.closed import Closed
from mecanique.reference.loops.nullspace import NaturalUnits, _weigh, measure, split
from mecanique.reference.tolerances import EPSILON

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


def with_rotors(name: str) -> Mechanism:
    """A linkage with a rotor at every hinge but the first."""
    mechanism = mq.textbook.load(name)
    hinges = enumerate(mechanism.joints)
    joints = (replace(j, armature=0.3 * k) if isinstance(j, Revolute) else j for k, j in hinges)
    return replace(mechanism, joints=tuple(joints))


@pytest.mark.parametrize(
    "mechanism",
    [*map(mq.textbook.load, LINKAGES), with_rotors("four_bar_linkage")],
    ids=[*LINKAGES, "rotors"],
)
def test_directions_of_the_metric_carry_unit_energy_each(mechanism: Mechanism) -> None:
    reference, q = mq.Reference(mechanism), mq.assemble(mechanism)
    closed = closed_of(mechanism)
    jacobian = closed.closures.at(q, np.zeros(mechanism.nv), 0.0).jacobian
    metric = closed.measure(jacobian)
    C = metric.columns
    np.testing.assert_allclose(
        C.T @ reference.mass_matrix(q) @ C, np.diag(metric.mass), rtol=0, atol=1e-13
    )
    np.testing.assert_allclose(metric.inverse @ C, np.eye(mechanism.nv), rtol=0, atol=1e-14)
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
def test_a_small_loop_beside_a_large_one_is_closed_as_if_alone(length: float, mass: float) -> None:
    small, large = four_bars((length, mass)), four_bars((1.0, 10.0))
    both = four_bars((length, mass), (1.0, 10.0))
    guesses = {"A": 1.0, "B": -0.3, "C": 1.8}
    for given in ({}, {"A0": 0.8}, {name: guesses[name[0]] for name in both.coordinates}):
        alone = [
            mq.assemble(part, {name: given[other] for name, other in names if other in given})
            for part, names in (
                (small, [(name, name) for name in small.coordinates]),
                (large, [(name, f"{name[0]}1") for name in large.coordinates]),
            )
        ]
        q = mq.assemble(both, given)
        np.testing.assert_allclose(q, np.concatenate(alone), rtol=0, atol=1e-12)
    open_by = np.zeros(len(q))
    open_by[0] = 1e-5
    with pytest.raises(mq.EngineError, match="the loops are open"):
        mq.Reference(both).acceleration(q + open_by)


def slider_cranks(*parts: tuple[float, float]) -> Mechanism:
    """Independent slider-cranks, each with its crank's length and its rail's height in lengths."""
    bodies, joints, loops = [mq.Body("ground")], list[mq.Joint](), list[mq.Loop]()
    for k, (length, height) in enumerate(parts):
        crank, rod = mq.rod(1.0, length), mq.rod(2.0, 2.3 * length)
        bodies += [mq.Body(f"a{k}", crank), mq.Body(f"b{k}", rod), mq.Body(f"c{k}", crank)]
        tip, rail = mq.Placement((length, 0, 0)), mq.Placement((0, 0, height * length))
        joints += [
            Revolute(f"A{k}", "ground", f"a{k}", axis=(0, -1, 0)),
            Revolute(f"B{k}", f"a{k}", f"b{k}", axis=(0, -1, 0), origin=tip),
            mq.Prismatic(f"C{k}", "ground", f"c{k}", axis=(1, 0, 0), origin=rail),
        ]
        loops.append(mq.Loop.pin(f"D{k}", f"b{k}", (2.3 * length, 0, 0), f"c{k}", (0, 0, 0)))
    return Mechanism("cranks", tuple(bodies), tuple(joints), loops=tuple(loops))


@pytest.mark.parametrize("seed", range(6))
def test_the_search_for_one_loop_takes_the_steps_it_takes_alone(seed: int) -> None:
    """From anywhere; one of them is out of reach, and steps back while the others go on."""
    parts = (0.04, 0.5), (1.0, 3.4), (30.0, -1.2)
    random = np.random.default_rng(seed)
    starts = [random.uniform(-3, 3, 3) * (1, 1, length) for length, _ in parts]
    alone = [
        settle(closed_of(slider_cranks(part)), start, 0.0)
        for part, start in zip(parts, starts, strict=True)
    ]
    together = settle(closed_of(slider_cranks(*parts)), np.concatenate(starts), 0.0)
    for ours, theirs in zip(together, zip(*alone, strict=True), strict=True):
        np.testing.assert_allclose(ours, np.concatenate(theirs), rtol=1e-9, atol=1e-12)


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
    np.testing.assert_allclose(a, np.concatenate(alone), rtol=1e-12, atol=0)


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
    np.testing.assert_allclose(motion.q[-1, :3], small.q[-1], rtol=1e-8, atol=0)
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
    np.testing.assert_allclose(both, [large, large * np.sqrt(1000)], rtol=1e-8, atol=0)


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
@pytest.mark.parametrize(("count", "duration"), [(2, 3.0), (20, 1.0)])
def test_a_row_of_parallelograms_passes_flat_positions_in_any_tree(
    count: int, duration: float, serial: bool
) -> None:
    """Where all lie flat, each could cross over into an antiparallelogram."""
    mechanism = parallelograms(count, serial=serial)
    rates = {
        joint.name: -1.0 if joint.child.startswith("up") else 1.0 for joint in mechanism.joints
    }
    motion = mq.simulate(mechanism, v=rates, duration=duration, samples=11)
    assert motion["A0"][-1] < -3 * np.pi / 4
    np.testing.assert_allclose(
        motion["A0"], fall_of_parallelograms(count, motion.t), rtol=0, atol=1e-9
    )


def test_a_row_that_turned_four_times_accelerates_as_one() -> None:
    """The rounding of large angles moves all that follows, and is not to be taken for a gap."""
    count, flat, random = 10, -7.5 * np.pi, np.random.default_rng(0)
    mechanism = parallelograms(count, serial=True)
    turn = np.array([1.0 if joint.child.startswith("up") else -1.0 for joint in mechanism.joints])
    rhs = mq.Reference(mechanism).with_rank_at(0.5 * turn).rhs()
    inertia, moment = (count + 1) / 3 + count, 9.81 * ((count + 1) / 2 + count)
    for angle in flat + 1e-4 * random.standard_normal(5):
        acceleration = rhs(0.0, np.concatenate([angle * turn, -5.0 * turn]))[len(turn) :]
        expected = moment / inertia * np.sin(angle) * turn
        np.testing.assert_allclose(acceleration, expected, rtol=0, atol=1e-6)


def spread(seed: int, off: float) -> np.ndarray:
    """A mass matrix; the smaller `off`, the more its entries cancel."""
    A = np.random.default_rng(seed).normal(size=(4, 4))
    A[:, 3] = A[:, 2] + off * A[:, 3]
    D = np.array([1.0, 1e-3, 1e3, 2.0])
    return np.asarray((A * D).T @ (A * D))


@pytest.mark.parametrize("off", [1.0, 1e-3])
@pytest.mark.parametrize("seed", range(3))
def test_directions_are_orthogonal_in_any_mass_matrix(seed: int, off: float) -> None:
    M, J = spread(seed, off), np.random.default_rng(seed).normal(size=(3, 4))
    units = NaturalUnits(np.array([2.0, 2.0, 5.0]), np.ones(4), np.array([0, 0, 1]))
    for root in (None, lambda: np.linalg.cholesky(M).T):
        metric = measure(M, J, units, root)
        np.testing.assert_allclose(metric.mass, 1.0, rtol=1e-14, atol=0)
        np.testing.assert_allclose(
            metric.columns.T @ M @ metric.columns, np.eye(4), rtol=0, atol=1e-8
        )
        np.testing.assert_allclose(metric.inverse @ metric.columns, np.eye(4), rtol=0, atol=1e-10)
        # each block closes one unit: Σ over its rows of |J C|² = 1, the rows alike
        scaled = metric.scale(J)
        np.testing.assert_allclose(np.sum(scaled[:2] ** 2), 1.0, rtol=1e-10, atol=0)
        np.testing.assert_allclose(np.sum(scaled[2] ** 2), 1.0, rtol=1e-10, atol=0)
        assert metric.rows[0] == metric.rows[1]


def test_a_direction_without_mass_is_told_from_one_with_mass() -> None:
    """Two velocities that move one mass: their sum carries it, their difference none."""
    M, units = np.ones((2, 2)), NaturalUnits(np.ones(1), np.ones(2), np.zeros(1, dtype=int))
    for root in (None, lambda: np.array([[1.0, 1.0]])):
        metric = measure(M, np.array([[1.0, -1.0]]), units, root)
        assert sorted(metric.mass) == [0.0, 1.0]
        carried = metric.columns.T @ M @ metric.columns
        np.testing.assert_allclose(carried, np.diag(metric.mass), rtol=0, atol=1e-13)
        np.testing.assert_allclose(metric.inverse @ metric.columns, np.eye(2), rtol=0, atol=1e-13)


def test_rows_of_rounding_are_not_scaled_up() -> None:
    J = np.array([[1.0, 0.0], [0.0, 1e-14]])
    units = NaturalUnits(np.ones(2), np.ones(2), np.array([0, 1]))
    np.testing.assert_array_equal(measure(np.eye(2), J, units).rows, [1.0, 0.0])
    # in plain units the row is large enough to count
    fine = NaturalUnits(np.array([1.0, 1e3]), np.ones(2), np.array([0, 1]))
    np.testing.assert_allclose(measure(np.eye(2), J, fine).rows, [1.0, 1e14], rtol=1e-14, atol=0)
    coarse = NaturalUnits(np.ones(2), np.array([1.0, 1e3]), np.array([0, 1]))
    np.testing.assert_allclose(measure(np.eye(2), J, coarse).rows, [1.0, 1e14], rtol=1e-14, atol=0)


def test_a_massless_velocity_is_measured_by_the_lightest_one_it_meets_in_a_loop() -> None:
    diagonal = np.array([0.0, 9.0, 4.0, 1.0, 0.0])
    J = np.array([[1.0, 1.0, 0.0, 0.0, 0.0], [-1.0, 0.0, 1.0, 0.0, 0.0]])
    # in plain units 2.25, 36 and 1.44
    plain = np.array([6.0, 0.5, 3.0, 1.2, 5.0])
    np.testing.assert_allclose(
        _weigh(diagonal, J, plain), [1.5 / 6, 3.0, 2.0, 1.0, 1.2 / 5], rtol=1e-14, atol=0
    )
    np.testing.assert_allclose(
        _weigh(np.array([4.0]), J[:, :1], np.array([7.0])), [2.0], rtol=1e-14, atol=0
    )
    np.testing.assert_allclose(
        _weigh(np.zeros(1), J[:, :1], np.array([4.0])), [1 / 4], rtol=1e-14, atol=0
    )


def test_newton_within_a_tangent_space_lands_on_the_loops_and_says_where() -> None:
    mechanism = four_bars((1.0, 1.0))
    closed, q = closed_of(mechanism), assembled(mechanism)
    v = np.array([0.3, -0.2, 0.5])
    closure = closed.closures.at(q, v, 0.0)
    metric = closed.measure(closure.jacobian)
    parts = split(metric.scale(closure.jacobian))
    along = 0.1 * parts.null[:, 0]
    tangent = Tangent(along, parts.range_right, np.zeros(parts.rank))
    landing = newton(
        closed, q, v, 0.0, metric, least_squares, tangent=tangent, stagnant=0.5, sweeps=8
    )
    C = metric.columns
    moved = q + C @ (along + parts.range_right @ landing.bend)
    np.testing.assert_allclose(landing.q, moved, rtol=1e-14, atol=0)
    assert 1e-3 < np.abs(landing.bend).max() < 0.1
    there = closed.closures.at(landing.q, v, 0.0)
    assert np.abs(there.residual).max() < 1e-14
    assert landing.gap < 1e-14
    J = metric.rows[:, None] * there.jacobian @ C @ parts.range_right
    np.testing.assert_allclose(landing.jacobian, J, rtol=0, atol=1e-14)
    np.testing.assert_allclose(
        landing.rates, metric.rows * (there.jacobian @ v), rtol=1e-12, atol=0
    )
    free = newton(closed, moved + 0.01, v, 0.0, metric, least_squares, stagnant=0.5, sweeps=8)
    assert np.abs(closed.closures.at(free.q, v, 0.0).residual).max() < 1e-14
    assert free.bend.shape == (0,)


def test_newton_ends_where_steps_leave_more_of_a_small_gap_than_they_may() -> None:
    """Steps that are two fifths of Newton's leave three fifths of a gap."""
    mechanism = four_bars((1.0, 1.0))
    closed, q, v = closed_of(mechanism), assembled(mechanism) + 1e-3, np.zeros(3)
    metric = closed.measure(closed.closures.at(q, v, 0.0).jacobian)
    gaps: list[float] = []

    def short(J: np.ndarray, gap: np.ndarray) -> np.ndarray:
        gaps.append(float(np.abs(gap).max()))
        return 0.4 * least_squares(J, gap)

    start = float(np.abs(metric.units.rows * closed.closures.at(q, v, 0.0).residual).max())
    small = 0.6**4.5 * start
    for near, stagnant, sweeps, steps in (
        (np.inf, 0.5, 20, 1),
        (small, 0.5, 20, 5),
        (small, 0.7, 20, 20),
        (np.inf, 0.7, 8, 8),
    ):
        gaps.clear()
        newton(closed, q, v, 0.0, metric, short, near=near, stagnant=stagnant, sweeps=sweeps)
        assert len(gaps) == steps
        np.testing.assert_allclose(gaps[1:], 0.6 * np.array(gaps[:-1]), rtol=0.02, atol=0)


def test_gaps_that_rounding_leaves_grow_with_the_turns_of_the_angles() -> None:
    mechanism = four_bars((1.0, 1.0))
    closed, q, v = closed_of(mechanism), assembled(mechanism), np.zeros(3)
    metric = closed.measure(closed.closures.at(q, v, 0.0).jacobian)
    turned = 2 * np.pi * np.array([1e6, -3e6, 2e6])
    near, far = (
        newton(closed, start, v, 0.0, metric, least_squares, stagnant=0.5, sweeps=8)
        for start in (q, q + turned)
    )
    closure = closed.closures.at(q, v, 0.0)
    gaps = metric.units.rows * (np.abs(closure.jacobian) @ np.abs(turned))
    assert far.rounding - near.rounding == pytest.approx(EPSILON * gaps.max(), rel=1e-3)
    assert 1e-11 < far.rounding < 1e-8
    assert far.gap < far.rounding


def least_squares(J: np.ndarray, gaps: np.ndarray) -> np.ndarray:
    return np.asarray(np.linalg.lstsq(J, gaps, rcond=None)[0])
