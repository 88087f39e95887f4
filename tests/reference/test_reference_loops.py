"""Loops inside Pinocchio: equations, forces, assembly, branches and degrees of freedom."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from reference_samples import four_bars
from scipy.spatial.transform import Rotation
from sympy import cos, sin

from mecanique import textbook
from mecanique.errors import ClosureError, EngineError
from mecanique.model import (
    Body,
    Coordinates,
    Fixed,
    Floating,
    JointForce,
    Loop,
    Mechanism,
    Parameter,
    Placement,
    Prismatic,
    Revolute,
    Shape,
    Spherical,
    Universal,
    bar,
    box,
    coordinate,
    particle,
    rod,
    time,
)
from mecanique.model.constraints.loops import CLOSED
from mecanique.reference import Reference, assemble, assembly_branches, degrees_of_freedom
from mecanique.reference.loops.assembly import (
    DIGITS,
    _damped_step,
    _distance,
    _Search,
    close_velocity,
    displace,
    newton,
    project,
    refuse_open,
)
from mecanique.reference.loops.closed import Closed
from mecanique.reference.loops.closures import ScaledClosure
from mecanique.reference.loops.freedom import _name_redundant, freedom_of
from mecanique.reference.loops.independent import Independent

A = Placement((0.1, 0.2, 0.3), (0.4, 0.5, 0.6))
B = Placement((0.3, -0.2, 0.3), (-0.4, 0.3, 0.2))
KINDS = ("ball", "hinge", "weld", "distance", "pin", "plate")


def hinge(name: str, parent: str, child: str, x: float = 0.0) -> Revolute:
    return Revolute(name, parent, child, axis=(0, -1, 0), origin=Placement((x, 0, 0)))


def spatial(kind: str, a: str = "ground", b: str = "c") -> Mechanism:
    """Three boxes on a hinge, free, and on a ball, tied by a loop; the hinge is driven by time."""
    loop = Loop("tie", kind, a, A, b, B, 0.4 if kind == "distance" else 0.0)  # type: ignore[arg-type]  # parametrized
    return Mechanism(
        "spatial",
        (
            Body("ground"),
            *(
                Body(name, box(mass, (0.1, 0.2, 0.3)))
                for name, mass in zip("abc", (1, 2, 3), strict=True)
            ),
        ),
        (
            Revolute("j", "ground", "a", axis=(0, 1, 0), origin=Placement((0.1, 0.2, 0.3))),
            Floating("f", "a", "b", origin=Placement((0.3, 0, 0), (0.1, 0.2, 0.3))),
            Spherical("s", "b", "c", origin=Placement((0.3, 0.1, 0), (0.1, 0.2, 0.3))),
        ),
        loops=(loop,),
        coordinates=Coordinates((), {"j": 0.3 * time() ** 2 + 0.2 * time()}),
    )


def closed_of(mechanism: Mechanism) -> Closed:
    closed = Reference(mechanism).closed
    assert closed is not None
    return closed


def four_bar(
    loop: str = "pin", masses: tuple[float, ...] = (1.0, 2.0, 1.5), **values: float
) -> Mechanism:
    """The catalogue's linkage with another loop, or other masses."""
    given = dict(zip(("m1", "m2", "m3"), masses, strict=True)) | values
    mechanism = textbook.load("four_bar_linkage", **given)
    ends = "coupler", (mechanism.values["b"], 0, 0), "rocker", (mechanism.values["c"], 0, 0)
    made = {
        "pin": Loop.pin("C", *ends),
        "ball": Loop.ball("C", *ends),
        "hinge": Loop.hinge("C", *ends, (0, 1, 0)),
    }
    return replace(mechanism, loops=(made[loop],))


START = {"phi": 1.1, "theta": -0.76, "psi": 1.25}


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("ends", [("ground", "c"), ("c", "b"), ("a", "c")])
def test_the_constraints_change_as_their_jacobian_and_gamma_say(
    kind: str, ends: tuple[str, str]
) -> None:
    """Along q(t) with constant a: J v + b is the rate of Φ on the loop, J a + γ that of J v + b."""
    mechanism = spatial(kind, *ends)
    closed = closed_of(mechanism)
    random = np.random.default_rng(3)
    q, v, a = (
        mechanism.position(random.normal(size=11)),
        random.normal(size=9),
        random.normal(size=9),
    )

    def path(end: float) -> tuple[np.ndarray, np.ndarray, float]:
        y, speed, steps = q.copy(), v.copy(), 40
        h = end / steps
        for _ in range(steps):
            k1 = closed.rates(y, speed)
            k2 = closed.rates(y + h / 2 * k1, speed + h / 2 * a)
            k3 = closed.rates(y + h / 2 * k2, speed + h / 2 * a)
            k4 = closed.rates(y + h * k3, speed + h * a)
            y, speed = y + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4), speed + h * a
        return y, speed, 0.5 + end

    def rate(end: float) -> np.ndarray:
        y, speed, t = path(end)
        here = closed.closures.at(y, speed, t)
        found: np.ndarray = here.jacobian @ speed + here.drift
        return found

    def slope(of: list[np.ndarray], h: float) -> np.ndarray:
        found: np.ndarray = (45 * (of[3] - of[2]) - 9 * (of[4] - of[1]) + (of[5] - of[0])) / (
            60 * h
        )
        return found

    h = 1e-3
    places = (-3 * h, -2 * h, -h, h, 2 * h, 3 * h)
    here = closed.closures.at(q, v, 0.5)
    np.testing.assert_allclose(
        slope([rate(s) for s in places], h), here.jacobian @ a + here.gamma, atol=1e-7, rtol=1e-8
    )
    turning = np.array(
        [name.split(": ")[1] in ("rx", "ry", "rz") for name in closed.closures.names]
    )
    straight = ~turning if kind in ("hinge", "weld") else np.ones(len(turning), dtype=bool)
    found = slope([closed.closures.residual(*path(s)[::2]) for s in places], h)
    np.testing.assert_allclose(
        found[straight], (here.jacobian @ v + here.drift)[straight], rtol=0, atol=1e-10
    )


@pytest.mark.parametrize("kind", KINDS)
def test_the_motion_stays_on_the_loop_and_all_bodies_keep_their_balance(kind: str) -> None:
    mechanism = spatial(kind)
    reference, t = Reference(mechanism), 0.5
    q = assemble(mechanism, mechanism.position(np.random.default_rng(1).normal(size=11)), t=t)
    v = close_velocity(closed_of(mechanism), q, np.random.default_rng(2).normal(size=9), t)
    a, found = reference.acceleration(q, v, t), reference.reactions(q, v, t)
    closure = closed_of(mechanism).closures.at(q, v, t)
    assert abs(closure.residual).max() < 1e-13
    assert abs(closure.jacobian @ v + closure.drift).max() < 1e-12
    assert abs(closure.jacobian @ a + closure.gamma).max() < 1e-9
    # Newton and Euler for c alone: the ball joint and the loop carry it
    poses = reference.poses(q, t)
    here = poses[3] @ np.array([*B.xyz, 1.0])
    tie, ball = found["tie"], found["s"]
    center = reference.point("c", (0, 0, 0), q, v, a, t)
    np.testing.assert_allclose(
        tie.force + ball.force + 3 * np.array([0, 0, -9.81]),
        3 * center.acceleration,
        rtol=0,
        atol=1e-11,
    )
    tips = [reference.point("c", tuple(axis), q, v, a, t) for axis in np.eye(3)]
    turn = np.stack([tip.position - center.position for tip in tips], axis=-1)
    change = np.stack([tip.acceleration - center.acceleration for tip in tips], axis=-1)
    inertia = np.array([0.04 + 0.09, 0.01 + 0.09, 0.01 + 0.04]) * 3 / 12
    moments = change @ (0.5 * inertia.sum() * np.eye(3) - np.diag(inertia)) @ turn.T
    rate = np.array(
        [
            moments[2, 1] - moments[1, 2],
            moments[0, 2] - moments[2, 0],
            moments[1, 0] - moments[0, 1],
        ]
    )
    arm = np.cross(here[:3] - center.position, tie.force)
    np.testing.assert_allclose(tie.moment + arm + ball.moment, rate, rtol=0, atol=1e-13)
    assert found["tie"].undetermined == ()


@pytest.mark.parametrize("masses", [(1.0, 2.0, 1.5), (1.0, 0.0, 1.5), (1.0, 0.0, 0.0)])
@pytest.mark.parametrize("loop", ["pin", "ball", "hinge"])
def test_a_four_bar_moves_as_its_one_equation_says_massless_bars_or_not(
    loop: str, masses: tuple[float, ...]
) -> None:
    """Numbers from an independent reduced Lagrangian, by Newton's method on Taylor jets."""
    expected = {2.0: -5.56672477868565, 0.0: -6.96628394424538 if masses[2] else -6.67466692677737}[
        masses[1]
    ]
    mechanism = four_bar(loop, masses)
    q = assemble(mechanism, START, keep=("phi",))
    v = close_velocity(
        closed_of(mechanism),
        q,
        mechanism.velocity({"phi": 1.7}),
        0.0,
        np.array([True, False, False]),
    )
    assert (q[0], v[0]) == (1.1, 1.7)
    assert Reference(mechanism).acceleration(q, v)[0] == pytest.approx(expected, rel=1e-13)


@pytest.mark.parametrize("size", [1e-4, 1e4])
def test_what_is_undetermined_does_not_depend_on_size(size: float) -> None:
    """Moments count by the length of the mechanism: the same components are loose at any size."""
    a, b, c, d = (size * four_bar().values[name] for name in "abcd")
    small = Reference(four_bar("ball", a=a, b=b, c=c, d=d))
    usual = Reference(four_bar("ball"))
    q = assemble(four_bar(), START)
    assert small.undetermined(q) == usual.undetermined(q)


def test_redundant_equations_leave_named_components_undetermined() -> None:
    q = assemble(four_bar(), START)
    assert Reference(four_bar("pin")).undetermined(q) == {}
    ball = Reference(four_bar("ball"))
    out_of_plane = ("force y", "moment x", "moment z")
    assert ball.undetermined(q) == {
        "A": out_of_plane,
        "B": out_of_plane,
        "D": out_of_plane,
        "C": ("force y",),
    }
    reactions = ball.reactions(q)
    assert reactions["C"].undetermined == ("force y",)
    assert reactions["C"].force[1] == pytest.approx(0, abs=1e-12)
    assert Reference(four_bar("pin")).reactions(q)["A"].undetermined == ()
    np.testing.assert_allclose(
        reactions["A"].force, Reference(four_bar("pin")).reactions(q)["A"].force, rtol=0, atol=1e-13
    )


def test_a_massless_link_pulls_along_itself() -> None:
    mechanism = textbook.load("slider_crank")
    q = assemble(mechanism, {"theta": 0.7, "beta": -0.97, "x": 1.5}, keep=("theta",))
    v = project(closed_of(mechanism), q, mechanism.velocity({"theta": 3.0}), 0.0)[1]
    found = Reference(mechanism).reactions(q, v)
    along = Reference(mechanism).poses(q)[2, :3, 0]
    assert np.linalg.norm(found["B"].force) > 0.1
    np.testing.assert_allclose(np.cross(found["B"].force, along), 0, rtol=0, atol=1e-13)
    np.testing.assert_allclose(found["A"].force, found["B"].force, rtol=0, atol=1e-13)


def two_free_bodies(kind: str) -> Mechanism:
    """Two bodies that fly, held together by one loop between frames askew."""
    a, b = Placement((0.3, 0.1, -0.2), (0.2, -0.3, 0.4)), Placement((0.1, 0.5, 0.2), (0.5, 0.1, 0))
    length = {"length": 0.7} if kind == "distance" else {}
    return Mechanism(
        "pair",
        (Body("ground"), *(Body(name, box(2.0, (0.3, 0.4, 0.5))) for name in ("one", "two"))),
        (Floating("left", "ground", "one"), Floating("right", "ground", "two")),
        loops=(Loop("tie", kind, "one", a, "two", b, **length),),  # type: ignore[arg-type]  # parametrized
    )


@pytest.mark.parametrize("kind", CLOSED)
def test_rows_are_the_rates_of_the_gaps_also_where_the_loop_is_open(kind: str) -> None:
    """Φ' = J v and (J v)' = γ along a motion with constant v."""
    closed = closed_of(two_free_bodies(kind))
    rng, h = np.random.default_rng(3), 1e-5
    turn = rng.normal(size=4)
    q = np.concatenate([rng.normal(size=3), [0, 0, 0, 1], rng.normal(size=3), turn])
    q[10:] /= np.linalg.norm(turn)
    v = rng.normal(size=12)
    here = closed.closures.at(q, v, 0.0)
    rates = closed.rates(q, v)
    after, before = (closed.closures.at(q + s * rates, v, 0.0) for s in (h, -h))
    change = (after.jacobian - before.jacobian) @ v / (2 * h)
    np.testing.assert_allclose(change, here.gamma, rtol=1e-6, atol=1e-6)
    if kind not in ("hinge", "weld"):  # whose Φ counts turns another way while they are open
        moved = (after.residual - before.residual) / (2 * h)
        np.testing.assert_allclose(here.jacobian @ v, moved, rtol=1e-6, atol=1e-6)


@pytest.mark.parametrize("kind", CLOSED)
def test_gaps_and_relative_velocities_are_those_of_the_frames(kind: str) -> None:
    """Φ is where frame b stands in frame a, J v how it moves against a, in the axes of a."""
    mechanism, random = two_free_bodies(kind), np.random.default_rng(8)
    (loop,) = mechanism.loops
    poses = [(random.normal(size=3), Rotation.random(rng=random)) for _ in range(2)]
    q = np.concatenate([part for p, turn in poses for part in (p, turn.as_quat())])
    v = random.normal(size=12)
    here = closed_of(mechanism).closures.at(q, v, 0.0)
    places, turns, flows, spins = [], [], [], []
    for (p, turn), frame, (u, w) in zip(
        poses, (loop.frame_a, loop.frame_b), v.reshape(2, 2, 3), strict=True
    ):
        places.append(p + turn.apply(frame.xyz))
        turns.append(turn * Rotation.from_euler("xyz", frame.rpy))
        spins.append(turn.apply(w))
        flows.append(turn.apply(u) - np.cross(spins[-1], p))  # of what is at the world's origin
    span, axes = places[1] - places[0], turns[0].inv()
    relative = axes * turns[1]
    slip = flows[1] - flows[0] + np.cross(spins[1] - spins[0], places[1])
    x = relative.as_matrix()
    tilt = np.cross([0, 0, 1], x[:, 2])
    tilt *= np.arccos(x[2, 2]) / np.linalg.norm(tilt)
    turned = {
        "hinge": tilt,
        "weld": relative.as_rotvec(),
        "plate": [0, 0, np.arctan2(x[1, 0], x[0, 0])],
    }.get(kind, np.zeros(3))
    gaps = dict(zip(("x", "y", "z", "rx", "ry", "rz"), [*axes.apply(span), *turned], strict=True))
    rates = [*axes.apply(slip), *axes.apply(spins[1] - spins[0])]
    moved = dict(zip(gaps, rates, strict=True))
    size = float(np.linalg.norm(span))
    gaps["length"], moved["length"] = size - 0.7, float(span @ slip) / size
    # x of b within the plane turns by the motion across it as well
    a, b, c = x[:, 0]
    wx, wy, wz = rates[3:]
    moved["rz"] = wz - c * (a * wx + b * wy) / (a * a + b * b) if kind == "plate" else wz
    rows = CLOSED[loop.kind]
    np.testing.assert_allclose(here.residual, [gaps[row] for row in rows], rtol=1e-12, atol=0)
    np.testing.assert_allclose(here.jacobian @ v, [moved[row] for row in rows], rtol=1e-11, atol=0)


def test_only_velocities_that_are_rates_of_coordinates_have_their_size() -> None:
    """Those of a free body in its own axes are the rate of no coordinate; -0.8 rad turns an arm."""
    pair = two_free_bodies("ball")
    arm = hinge("swing", "two", "arm")
    mechanism = replace(
        pair,
        bodies=(*pair.bodies, Body("arm", box(0.5, (0.1, 0.2, 0.3)))),
        joints=(*pair.joints, arm),
    )
    q = np.concatenate([[3.0, 4.0, 5.0, 0, 0, 0, 1.0], [6.0, 7.0, 8.0, 0, 0, 0, 1.0], [-0.8]])
    expected = [0.8 if name == f"{arm.coordinate}'" else 0.0 for name in mechanism.velocities]
    assert sum(expected) == 0.8
    np.testing.assert_array_equal(closed_of(mechanism).sizes(q), expected)


def test_an_impulse_moves_a_closed_mechanism_its_own_way() -> None:
    """J v' = 0, and what is left of M v' − p is a force of the loop."""
    mechanism = four_bar("pin")
    q, p = assemble(mechanism, {"phi": 1.1}), np.array([0.3, -0.2, 0.5])
    change = Reference(mechanism).response(q, 0.0, p)
    J = closed_of(mechanism).closures.at(q, np.zeros(3), 0.0).jacobian
    np.testing.assert_allclose(J @ change, 0, rtol=0, atol=1e-14)
    left = Reference(mechanism).mass_matrix(q) @ change - p
    np.testing.assert_allclose(left - J.T @ np.linalg.lstsq(J.T, left)[0], 0, rtol=0, atol=1e-13)
    assert p @ change > 0


def test_a_projection_takes_off_what_the_loops_forbid_whatever_the_speed() -> None:
    mechanism = textbook.load("slider_crank")
    closed = closed_of(mechanism)
    q = assemble(mechanism, {"theta": 0.7, "beta": -0.97, "x": 1.5}, keep=("theta",))
    slow = np.array([0.3, -0.2, 0.5])
    for speed in (1.0, 1e4):
        for drifted in (False, True):
            off = 1e-6 * speed * slow if drifted else speed * slow
            allowed = project(closed, q, speed * slow, 0.0)[1]
            v = project(closed, q, allowed + off, 0.0, drifted=drifted)[1]
            assert np.abs(closed.closures.at(q, v, 0.0).jacobian @ v).max() < 1e-13 * speed
            # what is allowed stays, and what is taken off does no work
            again = project(closed, q, v, 0.0)[1]
            np.testing.assert_allclose(again, v, rtol=0, atol=1e-13 * speed)


def parallel(alpha: float) -> tuple[np.ndarray, float, float]:
    """Position of the bars of Example 1.2, α'' and the force of CF on DEF, by exact lengths."""
    k, length, a, c, s = 50.0, 0.5, 0.8, np.cos(alpha), np.sin(alpha)
    rise, run = a + 2 * length * s, 2 * length * (1 - c)
    upper = np.hypot(run, rise)
    fall, way = a - 4 * length * s, 4 * length * (1 - c)
    lower = np.hypot(way, fall)
    pull = -k * (upper - a) / upper * (run * 2 * length * s + rise * 2 * length * c)
    push = -2 * k * (lower - a) / lower * (way * 4 * length * s - fall * 4 * length * c)
    turn = (pull + push) / (17 * length**2)
    return np.array([alpha, alpha, -alpha]), turn, (9 * length**2 * turn - pull) / (4 * length * c)


@pytest.mark.parametrize("alpha", [1e-6, 0.1, 0.4, -0.9])
def test_bars_and_springs_in_large_motion(alpha: float) -> None:
    q, turn, pin = parallel(alpha)
    reference = Reference(textbook.load("bars_and_springs_loop"))
    np.testing.assert_allclose(reference.acceleration(q), [turn, turn, -turn], rtol=1e-10, atol=0)
    found = reference.reactions(q)
    np.testing.assert_allclose(found["F"].force, [0, 0, pin], rtol=0, atol=1e-9 * abs(pin))
    np.testing.assert_allclose(found["C"].force, [0, 0, pin], rtol=0, atol=1e-9 * abs(pin))


def test_bars_and_springs_in_the_small_have_the_reactions_of_the_chapter() -> None:
    """Fundamentals of Dynamics, eqs. Ex.1.2.e to h, with q = 4 l α: on the bars, y upwards."""
    m, k, length, q = 1.0, 50.0, 0.5, 1e-6
    reference = Reference(textbook.load("bars_and_springs_loop"))
    position = np.array([1.0, 1.0, -1.0]) * np.arcsin(q / (4 * length))
    second = reference.acceleration(position)[0] * 4 * length
    assert 17 / 4 * m * second + 9 * k * q == pytest.approx(0, abs=1e-4 * k * q)
    found = reference.reactions(position)
    for name in "ADCF":
        assert found[name].force[0] == pytest.approx(0, abs=1e-5 * k * q)
    assert found["A"].force[2] == pytest.approx(-3 * m / 16 * second - k / 4 * q, rel=1e-4)
    assert found["D"].force[2] == pytest.approx(-m / 2 * second, rel=1e-4)


def test_assembly_keeps_what_it_can() -> None:
    mechanism = four_bar()
    named = assemble(mechanism, {"phi": 1.1, "psi": 1.2})
    assert named[0] != 1.1
    q = assemble(mechanism, {"phi": 1.1})
    assert q[0] == 1.1
    assert abs(closed_of(mechanism).closures.residual(q, 0.0)).max() < 1e-14
    moved = assemble(mechanism, np.array([1.1, 0.0, 0.0]))
    assert moved[0] != 1.1
    assert assemble(textbook.load("cart_pole"), {"x": 0.5}).tolist() == [0.5, 0.0]


def test_a_step_of_an_assembly_goes_as_far_as_is_safe_and_no_farther() -> None:
    J = np.diag([1.0, 0.01])
    for gaps, far in ((np.array([0.1, 0.001]), 0.1), (np.array([8.0, 0.04]), 0.5)):
        newton = -gaps / np.diag(J)
        expected = newton / np.abs(newton).max() * far
        np.testing.assert_allclose(_damped_step(J, gaps, None), expected, rtol=1e-12, atol=0)


@pytest.mark.parametrize(("wide", "damping"), [(3.0, 0.2), (3.0, 2.0), (0.4, 0.7)])
def test_from_afar_bodies_are_carried_rather_than_turned(wide: float, damping: float) -> None:
    """Damped least squares, (JᵀJ + λ 1) y = −Jᵀ Φ, in slides by the largest gap if it is wide."""
    random = np.random.default_rng(4)
    J, gaps = random.normal(size=(5, 6)), random.uniform(-1, 1, 5)
    rows, at, turning = np.array([0, 2, 3]), np.array([1, 2, 4, 5]), np.array([1, 0, 0, 1], bool)
    gaps[2] = -wide
    search = _Search(rows, at, turning, damping)
    scales = np.where(turning, 1.0, max(wide, 1.0))
    A = J[rows][:, at] * scales
    least = damping * np.linalg.norm(A, 2) ** 2
    y = -np.linalg.solve(A.T @ A + least * np.eye(4), A.T @ gaps[rows])
    y *= min(1.0, 0.5 / np.abs(y).max())
    np.testing.assert_allclose(search.step(J, gaps, np.zeros(5)), scales * y, rtol=1e-11, atol=0)


def test_a_search_goes_on_with_less_damping_where_it_gains_and_with_more_where_it_does_not() -> (
    None
):
    rows = np.array([1, 2])
    search = _Search(rows, np.array([0]), np.zeros(1, bool))
    gaps, damping = np.array([7.0, 0.6, -0.8]), search.damping
    assert search.accept(gaps, np.array([9.0, 0.6, -0.7]))
    assert search.damping < damping
    damping = search.damping
    assert not search.accept(gaps, np.array([0.0, 0.6, 0.9]))
    assert search.damping > damping
    assert not search.over
    # close to the end nothing is gained any more
    near = gaps * np.array([1.0, 1e-5, 1e-5])
    assert not search.accept(near, near)
    assert search.over
    # or too little, too often
    search, steps = _Search(rows, np.array([0]), np.zeros(1, bool)), 0
    while not search.over:
        steps += search.accept(gaps, 0.9995 * gaps)
    assert steps == 12


def test_the_branches_of_an_assembly_are_the_open_and_the_crossed_one() -> None:
    found = assembly_branches(four_bar(), {"phi": 1.1, "theta": -0.76, "psi": 1.25}, keep=("phi",))
    assert len(found) == 2
    crank, rocker = np.array([np.cos(1.1), np.sin(1.1)]), np.array([2.0, 0.0])
    for q in found:
        assert q[0] == 1.1
        joint = crank + 2.2 * np.array([np.cos(q[0] + q[1]), np.sin(q[0] + q[1])])
        np.testing.assert_allclose(
            joint, rocker + 1.7 * np.array([np.cos(q[2]), np.sin(q[2])]), rtol=0, atol=1e-13
        )
    assert len(assembly_branches(textbook.load("cart_pole"))) == 1


@pytest.mark.parametrize("speed", [1.7, 1e7])
def test_a_velocity_that_may_be_kept_is_kept_at_any_speed(speed: float) -> None:
    mechanism = four_bar()
    closed, q = closed_of(mechanism), assemble(mechanism, START, keep=("phi",))
    held = np.array([True, False, False])
    v = close_velocity(closed, q, mechanism.velocity({"phi": speed}), 0.0, held)
    assert v[0] == speed
    J = closed.closures.at(q, v, 0.0).jacobian
    np.testing.assert_allclose(J @ v, 0, rtol=0, atol=1e-14 * speed)


@pytest.mark.parametrize(("gap", "words"), [(5e-8, DIGITS), (5e-3, "try another guess")])
def test_what_is_left_open_by_little_lacks_digits(gap: float, words: str) -> None:
    closed = closed_of(four_bar())
    with pytest.raises(ClosureError, match=words):
        refuse_open(closed, np.array([0.0, gap]))


def test_rates_of_gaps_of_a_landing_count_what_time_moves() -> None:
    mechanism, random = spatial("weld"), np.random.default_rng(6)
    closed, v = closed_of(mechanism), random.normal(size=mechanism.nv)
    q, t = mechanism.position(random.normal(size=mechanism.nq)), 0.5
    here = closed.closures.at(q, v, t)
    assert np.abs(here.drift).max() > 0.1
    metric = closed.measure(here.jacobian)

    def least(J: np.ndarray, gaps: np.ndarray) -> np.ndarray:
        return np.zeros(J.shape[1])

    landing = newton(closed, q, v, t, metric, least, stagnant=0.5, sweeps=1)
    expected = metric.rows * (here.jacobian @ v + here.drift)
    np.testing.assert_allclose(landing.rates, expected, rtol=1e-13, atol=0)


def test_each_of_two_linkages_has_two_branches() -> None:
    pair = four_bars((1.0, 1.0), (0.3, 1.0))
    found = assembly_branches(pair, {"A0": 1.1, "A1": 0.7}, keep=("A0", "A1"))
    assert len(found) == 4
    bent = {tuple(np.sign(np.sin(q[[0, 3]] + q[[1, 4]] - q[[2, 5]])).tolist()) for q in found}
    assert len(bent) == 4


def test_a_loop_that_cannot_be_closed_is_named_with_its_gap() -> None:
    with pytest.raises(
        ClosureError, match=r"loop 'C' cannot be closed from there.*open by 0\.5 m \(C: x\)"
    ):
        assemble(four_bar(a=1.0, b=0.2, c=0.3), {"phi": 1.1})
    with pytest.raises(ClosureError, match="loop 'C' cannot be closed"):
        assemble(four_bar(), {"phi": 1.1, "theta": 0.3}, keep=("phi", "theta"))
    turned = Loop.weld("C: at rest", "ground", Placement(rpy=(0.5, 0, 0)), "b", Placement())
    skew = Mechanism(
        "skew",
        (Body("ground"), Body("b", box(1.0, (0.1, 0.2, 0.3)))),
        (Revolute("a", "ground", "b", axis=(0, 1, 0)),),
        loops=(turned,),
    )
    with pytest.raises(ClosureError, match=r"open by 0\.5 rad \(C: at rest: rx\)"):
        assemble(skew, [0.3])


def test_a_displacement_turns_by_its_rates_and_keeps_quaternions_of_unit_length() -> None:
    """A first-order step of a quaternion by ω turns by 2 atan(|ω|/2) about ω."""
    closed = closed_of(spatial("ball"))
    mechanism = closed.mechanism
    q = mechanism.position(np.random.default_rng(5).normal(size=11))
    step = np.random.default_rng(6).normal(size=9)
    moved = displace(closed, q, step)
    for (_, at), turn in zip(mechanism.quaternions, (step[3:6], step[6:]), strict=True):
        assert np.linalg.norm(moved[at]) == pytest.approx(1, rel=1e-15)
        rotation = Rotation.from_quat(q[at]).inv() * Rotation.from_quat(moved[at])
        angle = np.linalg.norm(turn)
        expected = 2 * np.arctan(angle / 2) * turn / angle
        np.testing.assert_allclose(rotation.as_rotvec(), expected, rtol=1e-13, atol=0)


def test_the_linkage_of_the_catalogue_is_assembled_without_a_guess() -> None:
    mechanism = textbook.load("four_bar_linkage")
    with pytest.raises(ClosureError, match="loop 'C' cannot be closed from there"):
        assemble(mechanism, np.zeros(3))
    q = assemble(mechanism)
    assert abs(closed_of(mechanism).closures.residual(q, 0.0)).max() < 1e-12
    assert assemble(mechanism).tolist() == q.tolist()
    freedom = degrees_of_freedom(mechanism)
    assert (freedom.N, freedom.singular) == (1, False)
    assert freedom.q.tolist() == q.tolist()


def test_a_loop_that_can_be_closed_nowhere_is_named_as_found_from_zero() -> None:
    impossible = four_bar(a=1.0, b=0.2, c=0.3)
    with pytest.raises(ClosureError, match="loop 'C' cannot be closed from there") as from_zero:
        assemble(impossible, np.zeros(3))
    for ask in (assemble, degrees_of_freedom):
        with pytest.raises(ClosureError) as anywhere:
            ask(impossible)
        assert str(anywhere.value) == str(from_zero.value)


def test_open_loops_are_not_answered_for() -> None:
    reference = Reference(four_bar())
    for ask in (reference.acceleration, reference.reactions, reference.undetermined):
        with pytest.raises(
            EngineError, match=r"loops are open at q = .* close them first, by mecanique.assemble"
        ):
            ask([1.1, 0.0, 0.0])


def test_degrees_of_freedom_and_redundant_equations() -> None:
    plane, ball, hinge = (
        degrees_of_freedom(four_bar(loop), START) for loop in ("pin", "ball", "hinge")
    )
    assert [found.N for found in (plane, ball, hinge)] == [1, 1, 1]
    assert [found.redundant for found in (plane, ball, hinge)] == [
        (),
        ("C: y",),
        ("C: z", "C: rx", "C: ry"),
    ]
    assert not any(found.singular for found in (plane, ball, hinge))
    assert str(ball) == (
        "N = 3 velocities - 2 independent constraint equations (of 3) = 1; "
        "as 6 n - b of 3 rigid bodies: b = 17 "
        "restraints; redundant: C: y"
    )


def test_a_singular_position_is_told_from_a_redundant_equation() -> None:
    flat = degrees_of_freedom(
        four_bar(a=1.0, b=2.0, c=1.0, d=2.0), {"phi": 0.0, "theta": 0.0, "psi": 0.0}
    )
    assert (flat.N, flat.rank_here, flat.singular, flat.redundant) == (1, 1, True, ())
    assert "singular position: only 1 equation is independent there" in str(flat)
    bricard = degrees_of_freedom(textbook.load("bricard_linkage"))
    assert (bricard.N, bricard.constraints, bricard.rank, bricard.singular) == (1, 5, 4, False)
    assert len(bricard.redundant) == 1


def test_particles_count_three_each() -> None:
    """N = 3 n_p - b (Fundamentals of Dynamics, sect. 1.2), for two spherical pendulums."""
    rope = Mechanism(
        "rope",
        (
            Body("ground"),
            *(Body(name) for name in ("p1", "p2", "r1", "r2")),
            *(Body(name, particle(1.0)) for name in "pr"),
        ),
        tuple(
            Prismatic(f"{name}{axis}", parent, child, axis=unit)
            for name in "pr"
            for axis, parent, child, unit in (
                ("x", "ground", f"{name}1", (1, 0, 0)),
                ("y", f"{name}1", f"{name}2", (0, 1, 0)),
                ("z", f"{name}2", name, (0, 0, 1)),
            )
        ),
        loops=(
            Loop.distance("one", "ground", (0, 0, 0), "p", (0, 0, 0), 1.0),
            Loop.distance("two", "p", (0, 0, 0), "r", (0, 0, 0), 1.5),
        ),
    )
    found = degrees_of_freedom(rope, {"pz": -1.0, "rz": -2.5})
    assert found.N == 4
    assert "as 3 n_p - b of 2 particles: b = 2 restraints" in str(found)


def test_a_locked_mechanism_still_has_reactions() -> None:
    truss = Mechanism(
        "truss",
        (Body("ground"), Body("a", rod(1.0, 1.0, (1, 0, 0))), Body("b", rod(1.0, 1.0, (1, 0, 0)))),
        (
            hinge("A", "ground", "a"),
            hinge("B", "a", "b", 1),
        ),
        loops=(Loop.pin("C", "ground", (1.2, 0, 0), "b", (1, 0, 0)),),
    )
    q = assemble(truss, {"A": 1.0, "B": -2.0})
    found = degrees_of_freedom(truss, q)
    assert found.N == 0
    assert "locked: nothing can move" in str(found)
    reference = Reference(truss)
    np.testing.assert_allclose(reference.acceleration(q), 0, rtol=0, atol=1e-14)
    reactions = reference.reactions(q)
    total = reactions["A"].force + reactions["C"].force
    np.testing.assert_allclose(total, [0, 0, 2 * 9.81], rtol=0, atol=1e-13)


def test_a_position_that_only_trembles_is_locked_and_singular() -> None:
    flat = Mechanism(
        "flat",
        (Body("ground"), Body("a", rod(1.0, 1.0, (1, 0, 0))), Body("b", rod(1.0, 1.0, (1, 0, 0)))),
        (hinge("A", "ground", "a"), hinge("B", "a", "b", 1)),
        loops=(Loop.pin("C", "ground", (2, 0, 0), "b", (1, 0, 0)),),
    )
    found = degrees_of_freedom(flat)
    assert (found.N, found.singular, found.redundant) == (0, True, ())


def test_a_massless_motion_that_the_loops_leave_free_is_refused_by_name() -> None:
    mechanism = Mechanism(
        "loose",
        (
            Body("ground"),
            Body("a", bar(1.0, (1, 0, 0))),
            Body("b", bar(1.0, (1, 0, 0))),
            Body("c", rod(1.0, 1.0)),
        ),
        (
            hinge("A", "ground", "a"),
            hinge("B", "a", "b", 1),
            hinge("D", "ground", "c"),
        ),
        loops=(Loop.distance("tie", "ground", (3, 0, 0), "b", (1, 0, 0), 1.5),),
    )
    q = assemble(mechanism, {"A": 0.3, "B": -0.4})
    with pytest.raises(ClosureError, match=r"a free direction carries no mass \(.*at [AB]'"):
        Reference(mechanism).acceleration(q)


def test_loops_work_with_coordinate_maps_and_drives() -> None:
    """A four-bar with a crank of constant speed: the drive does what inverse dynamics asks for."""
    W = Parameter("W", 2.0, "rad/s")
    driven = four_bar()
    driven = replace(
        driven,
        coordinates=Coordinates((), {"phi": W * time() + 1.1}),
        parameters=(*driven.parameters, W),
    )
    reference = Reference(driven)
    free = four_bar()
    for t in (0.0, 0.4):
        q = assemble(driven, {"theta": -0.76, "psi": 1.25}, t=t)
        v = project(closed_of(driven), q, np.zeros(2), t)[1]
        a = reference.acceleration(q, v, t)
        whole, speed = np.array([1.1 + 2 * t, *q]), np.array([2.0, *v])
        push = JointForce(
            "drive", "A", float(reference.reactions(q, v, t)["A"].moment @ np.array([0, -1, 0]))
        )
        found = Reference(replace(free, forces=(push,))).acceleration(whole, speed)
        np.testing.assert_allclose(found, [0, *a], rtol=0, atol=1e-13)
    assert degrees_of_freedom(driven, {"theta": -0.76, "psi": 1.25}).N == 0


def test_a_loop_named_like_a_joint_is_kept_apart() -> None:
    mechanism = four_bar()
    same = replace(mechanism, loops=(replace(mechanism.loops[0], name="A"),))
    assert set(Reference(same).reactions(assemble(same, START))) == {"A", "B", "D", "loop A"}


def test_linear_maps_may_halve_a_loop() -> None:
    """A rhombus of four equal bars described by one angle: its loop is redundant."""
    x = coordinate("x")
    mechanism = replace(
        four_bar(a=1.0, b=1.0, c=1.0, d=1.0),
        coordinates=Coordinates(("x",), {"phi": x, "theta": -x, "psi": x}),
    )
    found = degrees_of_freedom(mechanism, {"x": 0.7})
    assert (found.N, found.rank, found.redundant) == (1, 0, ("C: x", "C: y"))
    free = Reference(replace(mechanism, loops=())).acceleration([0.7], [0.4])
    np.testing.assert_allclose(
        Reference(mechanism).acceleration([0.7], [0.4]), free, rtol=1e-12, atol=0
    )


def test_drift_is_the_largest_gap_and_its_rate() -> None:
    mechanism = textbook.load("four_bar_linkage")
    reference = Reference(mechanism)
    q = assemble(mechanism, {"phi": 1.1})
    assert reference.drift(q).max() < 1e-14
    off = reference.drift(np.stack([q, q + 1e-3]), np.ones((2, mechanism.nv)))
    assert off.shape == (2, 2)
    assert 1e-5 < off[1, 0] < 1e-2
    assert off[1, 1] > 0.01
    assert not Reference(textbook.load("double_pendulum")).drift([1.0, 2.0]).any()


def test_independent_velocities_determine_the_others() -> None:
    mechanism = textbook.load("squeezer")
    reference = Reference(mechanism)
    assert reference.closed is not None
    free = Independent(reference.closed, assemble(mechanism, textbook.entry("squeezer").start), 0.0)
    q = free.position(np.array([0.01]))
    v = free.velocity(q, np.array([3.0]))
    a = free.acceleration(q, v, np.array([5.0]))
    h = 1e-4
    ahead, behind = (
        free.velocity(free.position(np.array([0.01 + s * h * 3])), np.array([3.0 + s * h * 5]))
        for s in (1, -1)
    )
    assert reference.drift(q, v).max() < 1e-13
    np.testing.assert_allclose(free.tangents(q)[:, 0] * 3.0, v, rtol=1e-12, atol=0)
    np.testing.assert_allclose((ahead - behind) / (2 * h), a, rtol=1e-5, atol=0)


@pytest.mark.parametrize("kind", KINDS)
def test_slopes_at_a_position_are_those_of_the_whole_closure(kind: str) -> None:
    """A search for closed positions asks for J alone, without rates of the engine's Jacobians."""
    closed = Reference(spatial(kind)).closed
    assert closed is not None
    mechanism, closures = closed.mechanism, closed.closures
    q = mechanism.normalize(mechanism.neutral() + 0.1)
    whole = closures.scale(q, np.zeros(mechanism.nv), 0.3)
    J, rounding = closures.slopes(q, 0.3)
    np.testing.assert_allclose(J, whole.jacobian, rtol=1e-14, atol=1e-14)
    np.testing.assert_allclose(rounding, whole.rounding, rtol=1e-14, atol=0)


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
def test_positions_are_as_far_apart_in_millimeters_as_in_kilometers(size: float) -> None:
    """Two sliders of a crank: by the way of the slider in characteristic lengths, or by turns."""
    crank = textbook.load("slider_crank", r=0.5 * size, l=1.2 * size)
    closed = Reference(crank).closed
    assert closed is not None
    first, second = (
        assemble(crank, {"theta": theta, "beta": -theta / 2, "x": 1.6 * size}, keep=("theta",))
        for theta in (0.3, 0.31)
    )
    way = abs(second[2] - first[2]) / closed.closures.length
    turn = max(abs(np.sin(0.31) - np.sin(0.3)), abs(np.cos(0.31) - np.cos(0.3)))
    assert _distance(closed, first, second, 0.0) == pytest.approx(max(way, turn), rel=1e-6)
    # far along alone, in lengths of the mechanism
    aside = first + np.array([0, 0, 3 * closed.closures.length])
    assert _distance(closed, first, aside, 0.0) == pytest.approx(3, rel=1e-9)


@pytest.mark.parametrize("axis", [(0, 1, 0), (0, 0, 1)])
def test_a_rod_whose_ends_meet_where_an_assembly_begins_is_drawn_out(
    axis: tuple[int, int, int],
) -> None:
    """Two bars on one pin, half as far apart at their tips: 2 sin((b − a)/2) = ½."""
    arm = (0.0, 0.0, -1.0) if axis[1] else (0.0, -1.0, 0.0)
    bars = Body("one", rod(1.0, 1.0, arm)), Body("two", rod(1.0, 1.0, arm))
    joints = Revolute("a", "ground", "one", axis=axis), Revolute("b", "ground", "two", axis=axis)
    loop = Loop.distance("rod", "one", arm, "two", arm, 0.5)
    mechanism = Mechanism("scissors", (Body("ground"), *bars), joints, loops=(loop,))
    a, b = assemble(mechanism, [0.0, 0.0])
    assert 2 * abs(np.sin((b - a) / 2)) == pytest.approx(0.5, rel=1e-12)


def test_welds_of_loops_transmit_what_fixed_joints_do() -> None:
    """Two bodies on a turning arm: of a tree, or flying freely and tied to it by loops."""
    brick = Shape(1.7, (0.1, -0.2, 0.3), (0.5, 0.6, 0.4, 0.05, -0.03, 0.02))
    places = {
        "b": Placement((0.4, 0.1, 0.2), (0.5, -0.3, 0.8)),
        "c": Placement((-0.3, 0.2, 0.1), (0.2, 0.9, -0.4)),
    }
    bodies = (Body("ground"), Body("arm", brick), *(Body(name, brick) for name in places))
    pin = Revolute("pin", "ground", "arm", axis=(0.6, 0.0, 0.8))
    fixed = [Fixed(f"weld_{name}", "arm", name, origin=at) for name, at in places.items()]
    flying = [Floating(f"root_{name}", "ground", name) for name in places]
    welds = [Loop.weld(f"weld_{name}", "arm", at, name, Placement()) for name, at in places.items()]
    tree = Reference(Mechanism("tree", bodies, (pin, *fixed)))
    tied = Reference(Mechanism("tied", bodies, (pin, *flying), loops=tuple(welds)))
    assert tied.closed is not None
    blocks = tied.closed.closures.units.blocks.tolist()
    rows = [name.split(": ") for name in tied.constraint_names]
    parts = [(loop, row.startswith("r")) for loop, row in rows]
    # the lengths of each loop are scaled together, and so are its angles
    assert len({*zip(parts, blocks, strict=True)}) == len({*parts}) == len({*blocks}) == 4
    q, v = [0.7], [1.3]
    poses = [tree.pose(name, q) for name in places]
    turns = [Rotation.from_matrix(pose[:3, :3]) for pose in poses]
    axis = v[0] * np.array([0.6, 0.0, 0.8])
    state, joined = list(q), list(v)
    for pose, turn in zip(poses, turns, strict=True):
        state += [*pose[:3, 3], *turn.as_quat()]
        # velocities of the origin and of rotation, in the body's own axes
        joined += [*turn.inv().apply(np.cross(axis, pose[:3, 3])), *turn.inv().apply(axis)]
    assert np.abs(tied.constraint_residual(state)).max() < 1e-13
    assert np.abs(tied.constraint_jacobian(state) @ joined).max() < 1e-13
    one, other = tree.reactions(q, v), tied.reactions(state, joined)
    for name in ("pin", "weld_b", "weld_c"):
        np.testing.assert_allclose(one[name].force, other[name].force, rtol=0, atol=1e-10)
        np.testing.assert_allclose(one[name].moment, other[name].moment, rtol=0, atol=1e-10)


def test_forces_of_a_loop_that_guides_are_along_the_axes_of_its_frame() -> None:
    """A particle on two slides of a tilted mount, led by a turning arm: m a in turned axes."""
    phi, r, m = coordinate("phi"), 0.8, 1.5
    end, turned = (r, 0.0, 0.0), 0.8
    mount = Fixed("mount", "ground", "board", origin=Placement((0.2, 0.1, 0.4), (0.5, -0.3, 0.8)))
    tie = Loop("tie", "pin", "arm", Placement(end, (0, 0, turned)), "particle", Placement())
    mechanism = Mechanism(
        "led",
        (
            *(Body("ground"), Body("board"), Body("arm", rod(2.0, r, end)), Body("sled")),
            Body("particle", particle(m)),
        ),
        (
            *(mount, Revolute("phi", "board", "arm", axis=(0, 0, 1))),
            Prismatic("x", "board", "sled", axis=(1, 0, 0)),
            Prismatic("y", "sled", "particle", axis=(0, 1, 0)),
        ),
        forces=(JointForce("drive", "phi", 3.0),),
        coordinates=Coordinates(("phi",), {"x": r * cos(phi), "y": r * sin(phi)}),
        elements=(tie,),
        gravity=(0, 0, 0),
    )
    reference = Reference(mechanism)
    rate, change = 1.3, 3.0 / (2.0 * r**2 / 3 + m * r**2)
    assert reference.acceleration([0.7], [rate])[0] == pytest.approx(change, rel=1e-13)
    inward, ahead = -m * r * rate**2, m * r * change
    c, s = np.cos(turned), np.sin(turned)
    found = reference.guide_forces([0.7], [rate])
    np.testing.assert_allclose(
        [*found.values()], [c * inward + s * ahead, c * ahead - s * inward], rtol=1e-12, atol=0
    )


@pytest.mark.parametrize("seed", range(4))
def test_rows_that_hardly_differ_are_told_from_those_that_follow_from_them(seed: int) -> None:
    """Parts of 2e-6 of a row are found to ten digits; projected once, they share four of these."""
    rows = np.zeros((7, 6))
    rows[range(4), range(4)] = 1.0, 2e-6, 2e-6, 2e-6
    rows[1:4, 0] = 1.0
    rows[4:, :4] = np.eye(4)[1:]
    turn = np.linalg.qr(np.random.default_rng(seed).normal(size=(6, 6)))[0]
    names = tuple("abcdefg")
    closure = ScaledClosure(np.zeros(7), rows @ turn, np.zeros(7), np.full(7, 1e-14))
    assert _name_redundant(closure, names) == ("e", "f", "g")


def press(size: float) -> Mechanism:
    """A hanging bar, and a slider on a level rail below, with a rod from its tip to the slider."""
    arm, rail = (0.0, 0.0, -size), Placement((0.0, 0.0, -1.5 * size))
    return Mechanism(
        "press",
        (Body("ground"), Body("bar", rod(1.0, size, arm)), Body("slider", particle(1.0))),
        (
            Revolute("pin", "ground", "bar", axis=(0, -1, 0)),
            Prismatic("rail", "ground", "slider", axis=(1, 0, 0), origin=rail),
        ),
        loops=(Loop.distance("rod", "bar", arm, "slider", (0.0, 0.0, 0.0), 0.8 * size),),
    )


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
def test_an_assembly_that_begins_where_nothing_closes_is_sought_as_far_as_its_size(
    size: float,
) -> None:
    """A rod straight below a hanging bar is as short as it can be, to first order."""
    angle, x = assemble(press(size))
    apart = np.array([x - size * np.sin(angle), size * (np.cos(angle) - 1.5)])
    assert np.linalg.norm(apart) == pytest.approx(0.8 * size, rel=1e-9)
    assert abs(x) < 10 * size


def test_an_assembly_is_sought_from_all_angles(monkeypatch: pytest.MonkeyPatch) -> None:
    """And from slides of as many lengths as these have radians."""
    starts: list[np.ndarray] = []

    def settle(closed: Closed, q: np.ndarray, *_: object) -> tuple[np.ndarray, np.ndarray]:
        starts.append(q / closed.closures.columns)
        return q, np.ones(1)

    monkeypatch.setattr("mecanique.reference.loops.assembly.settle", settle)
    with pytest.raises(ClosureError, match="rod"):
        assemble(press(0.02))
    first, *others = np.array(starts)
    assert not first.any()
    assert len(others) > 20
    reach = np.abs(others).max(axis=0)
    assert (reach > 0.9 * np.pi).all()
    assert (reach < np.pi).all()


def test_what_stays_open_is_told_in_meters() -> None:
    """The tip comes as near as half a bar to the rail, the rod is three tenths of one long."""
    mechanism = press(0.02)
    short = replace(mechanism, loops=(replace(mechanism.loops[0], length=0.3 * 0.02),))
    with pytest.raises(ClosureError, match=r"leaves it open by 0\.004 m \(rod: length\)"):
        assemble(short)


def test_each_loop_is_measured_by_its_own_length_and_what_is_in_none_by_that_of_all() -> None:
    small, large = 0.02, 2.0
    bodies, joints, loops = [Body("ground")], list[Revolute | Prismatic](), list[Loop]()
    for size in (small, large):
        arm, rail = (0.0, 0.0, -size), Placement((0.0, 0.0, -1.5 * size))
        bar, slider = f"bar{len(loops)}", f"slider{len(loops)}"
        bodies += [Body(bar, rod(1.0, size, arm)), Body(slider, particle(1.0))]
        joints.append(Revolute(f"{bar}_pin", "ground", bar, axis=(0, -1, 0)))
        joints.append(Prismatic(f"{slider}_rail", "ground", slider, origin=rail))
        loops.append(
            Loop.distance(f"rod{len(loops)}", bar, arm, slider, (0.0, 0.0, 0.0), 0.8 * size)
        )
    bodies.append(Body("free", particle(1.0)))
    joints.append(Prismatic("free", "ground", "free"))
    mechanism = Mechanism("two", tuple(bodies), tuple(joints), loops=tuple(loops))
    closures = closed_of(mechanism).closures
    # medians of what each press states, 0.8, 1 and 1.5 sizes, and of both
    whole = (1.5 * small + 0.8 * large) / 2
    assert closures.length == pytest.approx(whole, rel=1e-15)
    np.testing.assert_allclose(closures.rows, [1 / small, 1 / large], rtol=1e-14, atol=0)
    np.testing.assert_allclose(closures.columns, [1, small, 1, large, whole], rtol=1e-14, atol=0)


def test_a_flywheel_given_by_its_moment_of_inertia_drives_a_slider_by_a_rod_without_mass() -> None:
    """(J + m x'²) θ'' = τ at rest, with x = r cos θ + √(l² − r² sin² θ) and x' = dx/dθ."""
    J, m, r, length, torque, about = 0.3, 2.0, 0.5, 1.2, 3.0, (0, -1, 0)
    flywheel = Shape(0.0, (0, 0, 0), (0.2, J, 0.2, 0, 0, 0))
    bodies = (Body("ground"), Body("crank", flywheel), Body("rod"), Body("slider", particle(m)))
    mechanism = Mechanism(
        "engine",
        (*bodies, Body("wheel", flywheel)),
        (
            Revolute("theta", "ground", "crank", axis=about),
            Revolute("beta", "crank", "rod", axis=about, origin=Placement((r, 0, 0))),
            Prismatic("x", "ground", "slider", axis=(1, 0, 0)),
            Revolute("phi", "ground", "wheel", axis=about),
        ),
        forces=(JointForce("drive", "theta", torque), JointForce("other", "phi", torque)),
        loops=(Loop.pin("pin", "rod", (length, 0, 0), "slider", (0, 0, 0)),),
    )
    angle = 0.7
    c, s = np.cos(angle), np.sin(angle)
    along = np.sqrt(length**2 - (r * s) ** 2)
    q = [angle, -np.arcsin(r * s / length) - angle, r * c + along, 0.0]
    slope = -r * s * (1 + r * c / along)
    found = Reference(mechanism).acceleration(q)
    expected = torque / (J + m * slope**2)
    np.testing.assert_allclose(found[[0, 3]], [expected, torque / J], rtol=1e-12, atol=0)
    assert found[2] == pytest.approx(slope * expected, rel=1e-12)


@pytest.mark.parametrize(("share", "locked"), [(0.22, False), (0.18, True)])
def test_a_mechanism_that_falls_back_from_four_fifths_of_every_way_is_locked(
    share: float, monkeypatch: pytest.MonkeyPatch, *, locked: bool
) -> None:
    linkage = four_bar()
    q = assemble(linkage, START)

    def fall_back(closed: Closed, start: np.ndarray, *_: object) -> np.ndarray:
        return q + share * (start - q)

    monkeypatch.setattr("mecanique.reference.loops.freedom.close_position", fall_back)
    assert (freedom_of(closed_of(linkage), q, 0.0).N == 0) == locked


def test_multipliers_of_many_states_stand_by_the_names_of_their_rows() -> None:
    mechanism = four_bar()
    reference, q = Reference(mechanism), assemble(four_bar(), START)
    v = project(closed_of(mechanism), q, mechanism.velocity({"phi": 1.7}), 0.0)[1]
    states = np.array([np.zeros(3), v, 2 * v])
    together = reference.multipliers(np.tile(q, (3, 1)), states)
    for k, speed in enumerate(states):
        single = reference.multipliers(q, speed)
        assert {name: values[k] for name, values in together.items()} == pytest.approx(
            single, rel=1e-12
        )
        # the first two rows are along x and z of the plane, as the loop's force on b is
        np.testing.assert_allclose(
            np.linalg.norm([*single.values()]),
            np.linalg.norm(reference.reactions(q, speed)["C"].force),
            rtol=1e-12,
            atol=0,
        )
    assert Reference(textbook.load("double_pendulum")).multipliers([0.1, 0.2], [0.3, 0.4]) == {}


def test_what_a_map_guides_is_undetermined_across_its_own_motions() -> None:
    """A universal joint's moment is known to be zero about x and about y as that has turned."""
    cross = Mechanism(
        "cross",
        (Body("ground"), *(Body(name, box(1.0, (0.1, 0.1, 0.1))) for name in ("arm", "slider"))),
        (
            Universal("joint", "ground", "arm", names=("a", "b")),
            Prismatic("rail", "ground", "slider", coordinate="x"),
        ),
        coordinates=Coordinates(("a", "b"), {"x": coordinate("a")}),
    )
    for a, unknown in ((0.4, "yz"), (0.0, "z"), (np.pi / 2, "y")):
        found = Reference(cross).undetermined([a, 0.3])["joint"]
        assert found == ("force x", "force y", "force z", *(f"moment {x}" for x in unknown))
        moment = Reference(cross).reactions([a, 0.3])["joint"].moment
        np.testing.assert_array_equal(np.isnan(moment), [x in unknown for x in "xyz"])
