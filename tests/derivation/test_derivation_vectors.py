"""Vectors, matrices and poses: on lists and on arrays of many states, both as numpy has them."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mecanique.derivation.mechanics import vectors
from mecanique.derivation.mechanics.recursion import _clean
from mecanique.derivation.scalars.functions import function
from mecanique.derivation.scalars.series import Ring
from mecanique.derivation.tree import poses
from mecanique.derivation.tree.links import Link, links, motions, moving, place_of
from mecanique.derivation.tree.poses import Arithmetic
from mecanique.model import Body, Shape
from mecanique.model.placement import Placement

N = 4
"""States of an array."""


def random(*shape: int, seed: int = 0) -> np.ndarray:
    return np.random.default_rng([seed, *shape]).normal(size=shape)


def same(found: Any, expected: Any) -> None:
    np.testing.assert_allclose(np.array(found, dtype=float), expected, rtol=1e-13, atol=1e-13)


def both(call: Any, expected: Any, *given: np.ndarray) -> None:
    """Compare a function with numpy's answer for each state: on arrays, and on lists of each."""
    answers = np.array([expected(*(x[..., k] for x in given)) for k in range(N)])
    same(np.moveaxis(np.asarray(call(*given)), -1, 0), answers)
    for k, answer in enumerate(answers):
        same(call(*(x[..., k].tolist() for x in given)), answer)


def skew(w: Any) -> np.ndarray:
    return np.asarray(np.cross(w, np.eye(3)).T)


a, b = random(3, N), random(3, N, seed=1)
A, B = random(3, 3, N), random(3, 3, N, seed=1)
E = A + A.swapaxes(0, 1)
POSE, OTHER = random(3, 4, N), random(3, 4, N, seed=1)


def test_products_of_vectors_and_matrices() -> None:
    both(vectors.dot, np.dot, a, b)
    both(vectors.cross, np.cross, a, b)
    both(vectors.add, lambda x, y, z: x + y + z, a, b, A[0])
    both(vectors.add_rows, np.add, A, B)
    both(vectors.transpose, np.transpose, POSE)
    both(vectors.apply, np.matmul, A, a)
    both(vectors.apply, lambda R, x: R[:, :3] @ x, POSE, a)
    both(vectors.apply_transpose, lambda R, x: R.T @ x, A, a)
    both(vectors.apply_transpose, lambda R, x: R[:, :3].T @ x, POSE, a)
    both(vectors.products, lambda x, y: x @ y.T, A, B)
    both(vectors.position, lambda pose: pose[:, 3], POSE)
    both(vectors.rotation, lambda pose: pose[:, :3], POSE)
    both(vectors.times_point, lambda pose, x: pose[:, :3] @ x + pose[:, 3], POSE, a)
    both(
        vectors.product,
        lambda x, y: np.column_stack([x[:, :3] @ y[:, :3], x[:, :3] @ y[:, 3] + x[:, 3]]),
        POSE,
        OTHER,
    )
    same(vectors.apply_to_columns(A, POSE), np.einsum("ijn,jkn->ikn", A, POSE))
    turned = vectors.turned_pose(A, POSE)
    for k in range(N):
        Q, X = A[..., k], POSE[..., k]
        same(turned[..., k], np.column_stack([Q @ X[:, :3] @ Q.T, Q @ X[:, 3]]))
    for factor in (-2.5, 1.0, -1.0, 1):
        both(lambda x, c=factor: vectors.scale(c, x), lambda x, c=factor: c * x, a)
    many = random(N)
    same(vectors.scale(many, a), many * a)


def test_symmetric_products_are_sums_of_both_kinds() -> None:
    """Σ A Bᵀ of matrices and of columns, of which lists compute one triangle."""

    def expected(x: Any, u: Any) -> np.ndarray:
        return np.asarray(x @ x.T + 2 * np.outer(u, u))

    both(
        lambda x, u: vectors.symmetric_products((x, x), (u, vectors.scale(2.0, u))), expected, A, a
    )
    triangle = vectors.symmetric_products((A[..., 0].tolist(), B[..., 0].tolist()))
    lower = np.tril(A[..., 0] @ B[..., 0].T)
    same(triangle, lower + np.tril(lower, -1).T)


def test_what_turning_bodies_do() -> None:
    """Moments E = ∫ r rᵀ dm of a body that turns at ω and α (skew matrices ω̂, α̂)."""
    both(vectors.acceleration_field, lambda w, x: skew(x) + skew(w) @ skew(w), a, b)
    both(vectors.acceleration_field, lambda w, x: skew(x) + skew(w) @ skew(w), a, 0 * b)

    def moment(U: Any, S: Any) -> np.ndarray:
        sizes, axes = np.linalg.eigh(S)
        parts = [size * np.cross(r, U @ r) for size, r in zip(sizes, axes.T, strict=True)]
        return np.asarray(np.sum(parts, axis=0))

    both(vectors.axial, moment, A, E)
    both(vectors.turning_momentum, lambda w, S: np.trace(S) * w - S @ w, a, E)
    both(
        lambda w, S: vectors.turning_energy(w, S, 0.7),
        lambda w, S: np.trace(S) * w @ w - w @ S @ w + 1.4,
        a,
        E,
    )


def test_vectors_that_are_zero_in_every_state_cost_nothing() -> None:
    still, x, R = vectors.STILL, a, A
    assert vectors.cross(still, x) is vectors.cross(x, still) is still
    assert vectors.apply(R, still) is vectors.apply_transpose(R, still) is still
    assert vectors.scale(2.0, still) is vectors.scale(0.0, x) is still
    assert vectors.add(still, still) is still
    assert vectors.add(still, x) is vectors.add(x, still) is x
    assert vectors.turning_momentum(still, E) is still
    assert vectors.turning_energy(still, E, 1.0) == 0.0
    unturned = vectors.acceleration_field(still, still)
    assert vectors.apply(unturned, x) is vectors.axial(unturned, E) is still
    at = a[:, 0].tolist()
    assert vectors.add(still, at, still) is at
    for w, alpha in ((a, still), (still, b)):
        zero = np.zeros_like(a)
        w_, alpha_ = (zero if v is still else v for v in (w, alpha))
        same(vectors.acceleration_field(w, alpha), vectors.acceleration_field(w_, alpha_))
    # ω of all states with α of each, and the reverse
    for w, alpha in ((a[:, :1], b), (a, b[:, :1])):
        wide = [np.broadcast_to(v, (3, N)).copy() for v in (w, alpha)]
        same(
            np.broadcast_to(vectors.acceleration_field(w, alpha), (3, 3, N)),
            vectors.acceleration_field(*wide),
        )


def test_scalars_become_rows_of_as_many_states_as_one_has() -> None:
    rows = vectors.as_rows([1.0, random(1), random(N), random(N, seed=2)])
    assert rows.shape == (4, N)
    same(rows[0], np.ones(N))
    same(rows[1], np.broadcast_to(random(1), N))
    same(rows[2:], [random(N), random(N, seed=2)])
    assert vectors.as_rows([1.0, 2.0]).shape == (2, 1)
    assert vectors.as_rows([random(1), 2.0]).shape == (2, 1)
    assert vectors.as_rows([a, a[:, :1]]).shape == (2, 3, N)
    array = vectors.as_array([[1, 0, a[0], 2.0], [b[1], 0, 0, 0], [0, 0, 1, a[2]]], N)
    assert array.shape == (3, 4, N)
    same(array[0, 2:], [a[0], 2 * np.ones(N)])
    same(array[1, 0], b[1])
    same(array[2, 3], a[2])


def test_rows_are_taken_by_their_places() -> None:
    same(vectors.take(A, [2, 0]), A[[2, 0]])
    assert vectors.take(["x", "y", "z"], [2, 0]) == ["z", "x"]
    assert vectors.take(["x", "y", "z"], slice(None)) == ["x", "y", "z"]


def test_square_matrices_of_zeros_and_mirrors() -> None:
    assert vectors.zeros([1.5, 2.0]) == [[0.0, 0.0], [0.0, 0.0]]
    assert vectors.zeros(a[:2]).shape == (2, 2, N)
    M = A[..., 0].tolist()
    vectors.mirror(M)
    upper = np.triu(A[..., 0])
    same(M, upper + np.triu(upper, 1).T)


def test_a_bundle_has_the_columns_of_its_parts() -> None:
    """Indices and vectors one after the other, of one velocity or several."""
    single, pair = (2, a, vectors.STILL), (np.array([0, 1]), random(3, 2, N), random(3, 2, 1))
    ((places, first, second),) = vectors.bundle([single, pair])
    assert places.tolist() == [2, 0, 1]
    same(first, np.concatenate([a[:, None], pair[1]], axis=1))
    same(second, np.concatenate([0 * a[:, None], 0 * pair[1] + pair[2]], axis=1))
    assert vectors.bundle([single]) == [single]
    lists: list[Any] = [(0, [1.0, 0, 0], vectors.STILL), (1, vectors.STILL, [0, 1.0, 0])]
    assert vectors.bundle(lists) is lists


ZERO_AND_ONES = (0, 1, -1, 0.0, 1.0, -1.0, np.float64(0.0), 2, 0.5, True)


@pytest.mark.parametrize("x", ZERO_AND_ONES)
def test_zeros_and_ones_cost_nothing(x: Any) -> None:
    ring = Ring()
    q = ring.coordinate("q")
    for y in (*ZERO_AND_ONES, q, a):
        expected = float(x) * y, float(x) + y
        for found in ((poses.times(x, y), poses.plus(x, y)), (poses.times(y, x), poses.plus(y, x))):
            for left, right in zip(found, expected, strict=True):
                assert np.all(left == right)
    if x == 0:
        assert poses.plus(x, q) is poses.plus(q, x) is q
        assert poses.times(x, q) == poses.times(q, x) == 0
        assert not isinstance(poses.times(q, x), type(q))
    if x == 1:
        assert poses.times(x, q) is poses.times(q, x) is q
    assert poses.combination([2, q, 0], [3, 1, q]) == 6 + q


@pytest.mark.parametrize(
    "axis", [(1.0, 0, 0), (0, -1.0, 0), (0, 0, 1.0), (0.6, 0.0, -0.8), (2, 1, -2)]
)
def test_a_turn_is_that_of_scipy(axis: tuple[float, float, float]) -> None:
    n = np.array(axis) / np.linalg.norm(axis)
    unit = (float(n[0]), float(n[1]), float(n[2]))
    for angle in (0.7, -2.0, math.pi):
        turn = poses.turn_by(unit, math.sin(angle), math.cos(angle), Arithmetic())
        same(turn, np.column_stack([Rotation.from_rotvec(angle * n).as_matrix(), np.zeros(3)]))
    along = np.eye(3)[np.argmax(np.abs(n))]
    if np.abs(n) @ along == 1:  # what a turn about an axis of the frame leaves alone is exact
        ring = Ring()
        q = ring.coordinate("q")
        arithmetic = Arithmetic(function, ring.number)
        exact = poses.turn_by(unit, function("sin")(q), function("cos")(q), arithmetic)
        numbers = [entry for row in exact for entry in row[:3] if isinstance(entry, int)]
        assert sorted(numbers) == [0, 0, 0, 0, 1]


def test_quaternions_multiply_and_turn_as_those_of_scipy() -> None:
    p, r = (Rotation.random(random_state=k) for k in (1, 2))
    four, other = p.as_quat().tolist(), r.as_quat().tolist()
    same(poses.quaternion_product(four, other), (p * r).as_quat())
    w = [0.3, -1.2, 0.7]
    same(poses.quaternion_product(four, w), poses.quaternion_product(four, [*w, 0.0]))
    same(poses.quaternion_rotation(*four), p.as_matrix())


TILTS = [(0.3, -1.1, 2.2), (math.pi / 2, 0.0, 0.0), (math.pi / 3, math.pi / 4, -math.pi), (0, 0, 0)]


@pytest.mark.parametrize("rpy", TILTS)
def test_a_placement_turns_by_roll_pitch_and_yaw(rpy: tuple[float, float, float]) -> None:
    placement = Placement((1.0, -2.0, 3.0), rpy)
    expected = np.eye(4)
    expected[:3, :3] = Rotation.from_euler("xyz", rpy).as_matrix()
    expected[:3, 3] = (1, -2, 3)
    same(poses.placement_matrix(placement, {}), expected)
    exact = poses.exact_rotation(placement)
    squares = [12 * math.cos(angle) ** 2 for angle in rpy]
    assert (exact is None) == all(abs(x - round(x)) < 1e-12 for x in squares)
    ring = Ring()
    series = poses.origin(placement, {}, Arithmetic(function, ring.number))
    for row, numbers in zip(series, expected[:3], strict=True):
        same([float(x if isinstance(x, (int, Fraction)) else _value(x)) for x in row], numbers)
    if exact is not None:
        for i in range(3):
            for k in range(3):
                assert sum(x * y for x, y in zip(exact[i], exact[k], strict=True)) == (i == k)
        same(exact, expected[:3, :3])


def _value(series: Any) -> float:
    ((_, _, c),) = series.terms() if len(series) else ((0, 0, Fraction(0)),)
    return float(c)


def test_mass_moments_are_integrals_over_the_shapes() -> None:
    """∫ (p, 1)(p, 1)ᵀ dm of particles at p, stated as shapes with moments about their centers."""
    points, masses = random(6, 3), [0.5, 1.0, 2.0, 0.3, 0.7, 1.5]
    expected = np.zeros((4, 4))
    shapes = []
    for lot in (slice(0, 4), slice(4, 6)):
        m, p = np.array(masses[lot]), points[lot]
        full = np.column_stack([p, np.ones(len(p))])
        expected += (full.T * m) @ full
        center = m @ p / m.sum()
        r = p - center
        second = (r.T * m) @ r
        I = np.trace(second) * np.eye(3) - second
        entries: Any = I[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]].tolist()
        at: Any = tuple(center.tolist())
        shapes.append(Shape(float(m.sum()), at, tuple(entries)))
    same(poses.moments(Body("body", *shapes), {}, Arithmetic()), expected)


@pytest.mark.parametrize("kind", ["fixed", "turn", "slide", "ball", "free"])
def test_a_pose_changes_by_its_unit_motions(kind: Any) -> None:
    """A' = A S along each velocity, of turns by a quaternion with p' = ½ p ⊗ ω."""
    axis = (0.6, 0.0, -0.8)
    position = ("x", "y", "z") if kind == "free" else ()
    quaternion = ("a", "b", "c", "d") if kind in ("ball", "free") else ()
    names = (*position, *quaternion) or (("q",) if kind != "fixed" else ())
    rates = ("vx", "vy", "vz", "wx", "wy", "wz")[0 if kind == "free" else 3 :]
    velocities = rates if quaternion else (("q'",) if kind != "fixed" else ())
    link = Link("joint", -1, "body", kind, Placement(), axis, names, velocities)
    p = Rotation.random(random_state=3).as_quat()
    at = {"q": 0.4, "x": 1.0, "y": -2.0, "z": 0.5, **dict(zip("abcd", p, strict=True))}

    def pose(values: dict[str, float]) -> np.ndarray:
        return np.asarray(poses.stack(poses.local(link, values, Arithmetic()), 1)[0])

    here = pose(at)
    turn = {"turn": Rotation.from_rotvec(0.4 * np.array(axis)), "fixed": Rotation.identity()}
    turn |= {"slide": Rotation.identity(), "ball": Rotation.from_quat(p)}
    same(here[:3, :3], turn.get(kind, Rotation.from_quat(p)).as_matrix())
    moved = {"slide": 0.4 * np.array(axis), "free": [1.0, -2.0, 0.5]}
    same(here[:3, 3], moved.get(kind, np.zeros(3)))
    same(here[3], [0, 0, 0, 1])
    S, h = motions(link), 1e-6
    assert len(S) == len(velocities)
    for name, step in zip(velocities, S, strict=True):
        ahead, behind = (dict(at) for _ in range(2))
        for moved_to, sign in ((ahead, h), (behind, -h)):
            if name == "q'":
                moved_to["q"] += sign
            elif name.startswith("v"):
                along = here[:3, "xyz".index(name[1])]
                for q, part in zip("xyz", along, strict=True):
                    moved_to[q] += sign * part
            else:
                w = np.eye(3)["xyz".index(name[1])]
                for q, part in zip(
                    "abcd", poses.quaternion_product(p.tolist(), w.tolist()), strict=True
                ):
                    moved_to[q] += sign * part / 2
        slope = (pose(ahead) - pose(behind)) / (2 * h)
        np.testing.assert_allclose(slope, here @ step, rtol=0, atol=1e-9)


def test_links_of_a_chain_follow_their_parents() -> None:
    import mecanique as mq

    bodies = tuple(map(mq.Body, ("ground", "frame", "fork", "wheel")))
    joints = (
        mq.Fixed("weld", "ground", "frame", origin=Placement((1, 0, 0))),
        mq.Universal("cardan", "frame", "fork", origin=Placement((0, 2, 0))),
        mq.Revolute("axle", "fork", "wheel", origin=Placement((0, 0, 3)), armature=0.5),
    )
    mechanism = mq.Mechanism("chain", bodies, joints)
    tree = links(mechanism)
    assert [(link.joint, link.parent, link.body) for link in tree] == [
        ("weld", -1, "frame"),
        ("cardan", 0, None),
        ("cardan", 1, "fork"),
        ("axle", 2, "wheel"),
    ]
    assert [tuple(link.origin.xyz) for link in tree] == [(1, 0, 0), (0, 2, 0), (0, 0, 0), (0, 0, 3)]
    assert [link.armature for link in tree] == [0.0, 0.0, 0.0, 0.5]
    assert place_of(tree, mechanism) == {"ground": -1, "frame": 0, "fork": 2, "wheel": 3}
    assert moving(tree) == (False, True, True, True)


@pytest.mark.parametrize("angle", [0.3, -0.3, 2.0, -2.0])
def test_a_tilt_by_any_angle_is_exactly_orthogonal(angle: float) -> None:
    """R Rᵀ = 1 without rounding, whichever way it turns; right angles are exact as they are."""
    rotation = poses.exact_rotation(Placement(rpy=(angle, 0.0, 0.0)))
    assert rotation is not None
    R = np.array(rotation, dtype=object)
    assert np.array_equal(R @ R.T, np.eye(3))
    assert float(R[2, 1]) == pytest.approx(math.sin(angle), abs=1e-15)
    assert poses.exact_rotation(Placement(rpy=(math.pi / 2, 0.0, 0.0))) is None


@pytest.mark.parametrize("axis", [(0.36, 0.48, 0.8), (1, 2, 3), (-1, 2, -0.5), (0.1, -3, 0.2)])
def test_directions_in_fractions_have_a_length_of_exactly_one(axis: tuple[float, ...]) -> None:
    unit = tuple(np.array(axis, dtype=float) / np.linalg.norm(axis))
    exact = poses.exact_direction(unit)
    assert sum(Fraction(c) ** 2 for c in exact) == 1 or exact == unit
    np.testing.assert_allclose([float(c) for c in exact], unit, rtol=0, atol=1e-15)


def test_turns_by_right_angles_are_rid_of_rounding_and_others_kept() -> None:
    for k, angles in enumerate(np.pi / 2 * np.array([[2, 0, 1], [1, 2, 0], [0, 1, 3]])):
        turn = Rotation.from_euler("xyz", angles).as_matrix()
        pose = [[*row, 0.3 + k] for row in turn.tolist()]
        cleaned = np.array(_clean(pose))
        assert np.array_equal(cleaned[:, :3], np.round(turn))
        assert np.array_equal(cleaned[:, 3], np.full(3, 0.3 + k))
    askew = [
        [*row, 0.5] for row in Rotation.from_euler("xyz", [0.3, 0.2, 0.1]).as_matrix().tolist()
    ]
    assert np.array_equal(_clean(askew), askew)
