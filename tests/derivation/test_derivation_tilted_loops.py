"""Loops of every kind close a linkage in any tilt, at any offset, of any size."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from derivation_samples import linkage

import mecanique as mq
from mecanique.derivation.mechanics.loops import label_rows, sense
from mecanique.derivation.numeric.constraints.rows import Constraints, Held
from mecanique.derivation.scalars.evaluation import evaluate
from mecanique.derivation.symbolic.symbols import Algebra
from mecanique.derivation.tree.poses import combination, origin
from mecanique.model.states import States

KINDS = ("hinge", "pin", "plate", "weld", "ball", "distance")


def closed_state(mechanism: mq.Mechanism) -> tuple[np.ndarray, np.ndarray]:
    """Return phi = 1 and phi' = 2 on the open branch, and the others' position and velocity."""
    guess = {"phi": 1.0, "theta": -0.5, "psi": 1.5, "chi": -1.0}
    known = {name: guess[name] for name in mechanism.coordinates}
    q = mq.assemble(mechanism, known, keep=["phi"])
    J = mq.Reference(mechanism).constraint_jacobian(q)
    scaled = J / np.maximum(np.linalg.norm(J, axis=1, keepdims=True), 1e-9 * np.abs(J).max())
    motion = np.linalg.svd(scaled)[2][-1]
    first = mechanism.velocities.index("phi'")
    return q, motion * 2.0 / motion[first]


def random_case(seed: int) -> mq.Mechanism:
    """Return a linkage with a kind of loop, a tilt, an offset and a size, drawn at random."""
    random = np.random.default_rng(seed)
    kind = KINDS[seed % len(KINDS)]
    tilt = random.uniform(-np.pi, np.pi, 3) if seed % 4 else random.uniform(-1e-9, 1e-9, 3)
    offset, scale = random.uniform(-3, 3, 3), 10.0 ** random.uniform(-3, 3)
    return linkage(kind, (tilt[0], tilt[1], tilt[2]), (offset[0], offset[1], offset[2]), scale)


def test_a_hinge_closes_a_tilted_linkage() -> None:
    """phi'' = -18.3715 at phi = 1, phi' = 2, as by hand, by `Reference` and by `Loop.pin`."""
    mechanism = linkage("hinge")
    q, v = closed_state(mechanism)
    first = mechanism.velocities.index("phi'")
    assert mq.Reference(mechanism).acceleration(q, v)[first] == pytest.approx(-18.3715, abs=1e-4)
    for method in ("lagrange", "newton_euler", "virtual_work"):
        found = mq.derive(mechanism, method=method).acceleration(q, v)[first]
        assert found == pytest.approx(-18.3715, abs=1e-4), method


@pytest.mark.parametrize("seed", range(36))
def test_loops_of_all_kinds_close_in_any_tilt_offset_and_size(seed: int) -> None:
    mechanism = random_case(seed)
    q, v = closed_state(mechanism)
    expected = mq.Reference(mechanism).acceleration(q, v)
    for method in ("lagrange", "newton_euler", "virtual_work"):
        found = mq.derive(mechanism, method=method).acceleration(q, v)
        np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-9 * np.abs(expected).max())


@pytest.mark.parametrize("kind", ["hinge", "plate", "weld"])
def test_each_axis_of_the_frames_of_a_loop_may_be_that_of_the_hinges(kind: str) -> None:
    assert mq.verify(linkage(kind, axis=(0.0, 0.0, 1.0)), samples=4).agrees


@pytest.mark.parametrize("kind", KINDS)
def test_closed_forms_and_programs_of_tilted_loops_agree_with_the_engine(kind: str) -> None:
    """Neither is handed out unless it agrees; a motion keeps the loop closed."""
    mechanism = linkage(kind, (0.3, 0.2, 0.1), (0.4, -0.7, 0.2))
    equations = mq.derive(mechanism)
    assert mq.verify(mechanism, samples=4).agrees
    mq.generate(equations, "python")
    q, v = closed_state(mechanism)
    for method in ("compiled", "dop853"):
        motion = mq.simulate(mechanism, q=q, v=v, duration=0.3, method=method)
        assert mq.Reference(mechanism).constraint_residual(motion.q[-1]) == pytest.approx(
            0, abs=1e-9
        )


def test_a_tilted_hinge_has_no_equations_made_of_rounding() -> None:
    """R Rᵀ of a tilt is off by 2e-16, which is no constraint: no moment about x or y is left."""
    names = [tie.name for tie in mq.derive(linkage("hinge")).derivation.ties]
    assert names == ["C_x", "C_y", "C_z"]


@pytest.mark.parametrize("seed", range(12))
def test_tilted_loops_are_reduced_to_one_equation(seed: int) -> None:
    """In a tilted plane three components of a gap are two equations."""
    mechanism = random_case(seed)
    assert mq.reduce_loops(mechanism, "phi").compare(samples=40) < 1e-9


def test_loops_that_leave_more_free_are_refused() -> None:
    far = mq.Revolute("F", "crank", "flap", axis=(0, -1, 0), coordinate="flap")
    tilted = linkage("hinge")
    flap = mq.Body("flap", mq.rod(1.0, 0.3))
    mechanism = mq.Mechanism(
        "linkage", (*tilted.bodies, flap), (*tilted.joints, far), loops=tilted.loops
    )
    with pytest.raises(mq.DerivationError, match="one of its 4 velocities free, got 2 equations"):
        mq.reduce_loops(mechanism, "phi")


def test_tilts_in_closed_form_are_exactly_orthogonal() -> None:
    """R Rᵀ = 1 without a rest, so that identities cancel; angles with known roots keep these."""
    algebra = Algebra(linkage("pin"))
    tilts = ((0.3, 0.2, 0.1), (np.pi / 2, 0.0, 0.4), (-2.0, 3.0, -np.pi), (1e-9, 0.0, 0.0))
    for rpy in (*tilts, (np.pi / 4, 1.0, 0.0)):
        placement = mq.Placement((0.0, 0.0, 0.0), rpy)
        rows = [row[:3] for row in origin(placement, {}, algebra.arithmetic)]
        for i, row in enumerate(rows):
            for k, other in enumerate(rows):
                product = algebra.lift(combination(row, other))
                assert not product - algebra.ring.number(int(i == k))
        numbers = [[evaluate(algebra.lift(entry), {}) for entry in row] for row in rows]
        expected = np.array(placement.rotation, dtype=float)
        np.testing.assert_allclose(numbers, expected, rtol=0, atol=4e-16)
    known = origin(mq.Placement((0.0, 0.0, 0.0), (np.pi / 6, 0.0, 0.0)), {}, algebra.arithmetic)
    assert not known[1][1] ** 2 - algebra.ring.number(Fraction(3, 4))


def test_a_wheel_on_a_tilted_plane_has_a_closed_form_without_noise() -> None:
    """Its accelerations were off by up to 2.6e-7: terms of rounding did not cancel."""
    plane = mq.Placement((0.4, -0.2, 0.3), (0.3, 0.2, 0.1))
    mechanism = mq.Mechanism(
        "wheel",
        (mq.Body("ground"), mq.Body("wheel", mq.cylinder(1.4, 0.17, 0.02))),
        (mq.Floating("free", "ground", "wheel"),),
        contacts=(mq.Rolling("rim", "wheel", 0.17, plane=plane),),
    )
    verdict = mq.verify(mechanism, samples=100)
    rows = [row for row in verdict.rows if "closed form" in row.sources]
    assert verdict.agrees
    assert max(row.worst for row in rows if row.quantity == "acceleration") < 1e-9


@pytest.mark.slow
@pytest.mark.parametrize("kind", KINDS)
def test_forty_tilts_offsets_and_sizes_of_each_loop(kind: str) -> None:
    """From 1 mm to 1 km: all methods agree with the engine; one in ten is also verified."""
    for seed in range(KINDS.index(kind) + 600, 600 + 40 * len(KINDS), len(KINDS)):
        mechanism = random_case(seed)
        q, v = closed_state(mechanism)
        expected = mq.Reference(mechanism).acceleration(q, v)
        size = np.abs(expected).max()
        for method in ("lagrange", "newton_euler", "virtual_work"):
            found = mq.derive(mechanism, method=method).acceleration(q, v)
            np.testing.assert_allclose(
                found, expected, rtol=1e-9, atol=1e-9 * size, err_msg=f"seed {seed}, {method}"
            )
        if seed // len(KINDS) % 10 == 0:  # these take ten times as long
            assert mq.verify(mechanism, samples=3, seed=seed).agrees, seed
            assert mq.reduce_loops(mechanism, "phi").compare(samples=20) < 1e-9, seed


@pytest.mark.parametrize("kind", ["hinge", "distance"])
def test_code_of_loops_is_judged_by_what_their_distance_from_the_origin_leaves(kind: str) -> None:
    """Positions 3,000 lengths away are known to 3,000 ε, and so are the accelerations."""
    excused = {}
    for offset in (0.0, 3e3):
        mechanism = linkage(kind, offset=(offset, -offset, offset / 2))
        verdict = mq.generate(mq.derive(mechanism), "python", samples=30).verdict
        assert verdict is not None
        excused[offset] = verdict.rounded["acceleration"]
        assert verdict.worst["acceleration"] <= excused[offset]
    assert excused[0.0] < 1e-11
    assert 1e-11 < excused[3e3] < 1e-8


@pytest.mark.parametrize("far", [0.0, 1e5])
@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("joint", [mq.Floating, mq.Universal, mq.Spherical])
def test_what_carries_a_whole_loop_is_in_none_of_its_rows(
    kind: str, joint: type[mq.Floating | mq.Universal | mq.Spherical], far: float
) -> None:
    """Not even by the rounding of what cancels there, which would count as a constraint.

    It grows with the distance from the origin, whatever the size of the loop.
    """
    fixed = linkage(kind, offset=(far, -far, 0.6 * far))
    tilt, *others = fixed.joints
    carrier = joint("carrier", "ground", "frame", origin=tilt.origin)
    carried = replace(fixed, joints=(carrier, *others))
    random = np.random.default_rng(1)
    q, v = random.normal(size=(20, carried.nq)), random.normal(size=(20, carried.nv))
    jacobian = Held(carried).at(States.of(carried, q, v)).jacobian
    columns = [carried.velocities.index(name) for name in carrier.velocities]
    assert not jacobian[:, :, columns].any()
    assert np.delete(jacobian, columns, axis=2).any(axis=(0, 2)).any()


@pytest.mark.parametrize("scale", [1e-3, 1.0, 1e3])
@pytest.mark.parametrize(("kind", "count"), [("hinge", 2), ("weld", 3)])
def test_what_a_planar_linkage_keeps_by_itself_is_in_no_row(
    kind: str, count: int, scale: float
) -> None:
    """In any tilt and at any offset, across its plane nothing moves: no rounding stands there."""
    random = np.random.default_rng(6)
    for _ in range(10):
        rpy, offset = random.uniform(-3, 3, (2, 3)).tolist()
        tilted = linkage(kind, tuple(rpy), tuple(offset), scale)
        held = Held(tilted)
        q, v = random.uniform(-3, 3, (5, tilted.nq)), random.normal(size=(5, tilted.nv))
        jacobian = held.at(States.of(tilted, q, v)).jacobian
        acting = [held.names[k] for k in np.flatnonzero(np.abs(jacobian).max(axis=(0, 2)))]
        assert len(acting) == count
        if kind == "hinge":  # its axes begin with two across its own
            assert acting == ["C: x", "C: y"]


def test_lengths_and_angles_of_each_loop_are_blocks_of_their_own() -> None:
    """As are each contact and each constraint on velocities."""
    loops = [
        SimpleNamespace(name=name, kind=kind)
        for name, kind in zip("ABC", ["hinge"] * 3, strict=True)
    ]
    contact = SimpleNamespace(name="wheel", rows=("normal", "along"))
    laws = [SimpleNamespace(name="law"), SimpleNamespace(name="other")]
    mechanism: Any = SimpleNamespace(loops=loops, contacts=[contact], velocity_constraints=laws)
    blocks: dict[int, list[str]] = {}
    for label in label_rows(mechanism):
        blocks.setdefault(label.block, []).append(label.name)
    of_loops = [[f"{x}: {row}" for row in rows] for x in "ABC" for rows in ("xyz", ("rx", "ry"))]
    assert [*blocks.values()] == [*of_loops, ["wheel: normal", "wheel: along"], ["law"], ["other"]]
    assert sorted(blocks) == [*blocks]


@pytest.mark.parametrize("angle", [0.0, 0.4, 2.0, np.pi])
def test_a_loop_that_is_closed_half_a_turn_off_is_told_by_its_sense(angle: float) -> None:
    """A hinge has the cosine between its axes, a weld the trace of its turn less 1."""
    c, s = np.cos(angle), np.sin(angle)
    turns = {"a": np.eye(3), "b": np.array([[1, 0, 0], [0, c, s], [0, -s, c]])}
    ground: Any = SimpleNamespace(frame=lambda body, placement: (turns[body], np.zeros(3)))
    hinge = mq.Loop.hinge("h", "a", (0, 0, 0), "b", (0, 0, 0), (0, 0, 1))
    weld = mq.Loop.weld("w", "a", mq.Placement(), "b", mq.Placement())
    assert sense(hinge, ground) == pytest.approx(c, abs=1e-15)
    assert sense(weld, ground) == pytest.approx(2 * c, abs=1e-15)
    assert sense(mq.Loop.ball("p", "a", (0, 0, 0), "b", (0, 0, 0)), ground) is None


@pytest.mark.parametrize("kind", ["pin", "plate", "ball", "distance"])
def test_rates_of_rows_count_what_time_moves(kind: str) -> None:
    """Φ' = J v + ∂Φ/∂t at any state, closed or open, where time leads the rocker."""
    free = linkage(kind, offset=(0.3, -0.2, 0.5))
    names = tuple(name for name in free.coordinates if name != "psi")
    led = {"psi": 1.5 + 0.4 * mq.sin(3 * mq.time())}
    mechanism = replace(free, coordinates=mq.Coordinates(names, led))
    random, held = np.random.default_rng(4), Held(mechanism)
    q, v = random.uniform(-1, 1, (2, len(names)))

    def at(step: float) -> Constraints:
        return held.at(States.of(mechanism, q + step * v, v, 0.7 + step))

    here, h = at(0.0), 1e-5
    moved = (at(h).residual - at(-h).residual) / (2 * h)
    np.testing.assert_allclose(here.rates, moved, rtol=0, atol=1e-9)
    assert np.abs(here.rates - (here.jacobian @ v)).max() > 0.1
