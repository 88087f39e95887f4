"""The random states: reproducible, in their ranges, and only where the equations mean anything."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from systems import FREE

from mecanique import textbook
from mecanique.arrays import Array
from mecanique.derivation import derive
from mecanique.errors import InputError
from mecanique.model import (
    Body,
    Coordinates,
    Damper,
    Floating,
    Force,
    Input,
    JointForce,
    Loop,
    Mechanism,
    Placement,
    Planar,
    Prismatic,
    Revolute,
    Rolling,
    Spherical,
    Spring,
    ball,
    box,
    coordinate,
    disk,
    particle,
    rod,
    time,
)
from mecanique.model.mechanism_units import characteristic_length
from mecanique.reference import Reference
from mecanique.reference.loops import assembly
from mecanique.textbook import facts
from mecanique.verification import states
from mecanique.verification.compare import verify
from mecanique.verification.facts import Bench, check_facts
from mecanique.verification.states import random_states


def slider(*forces: Any, **more: Any) -> Mechanism:
    joint = Prismatic(
        "slide", "ground", "block", axis=(1, 0, 0), coordinate="x", origin=Placement((0.5, 0, 0))
    )
    return Mechanism(
        "slider", (Body("ground"), Body("block", box(1, (1, 1, 1)))), (joint,), forces, **more
    )


@pytest.mark.parametrize("name", [*FREE, "four_bar_linkage", "rolling_coin"])
def test_one_seed_gives_one_set_of_states(name: str) -> None:
    mechanism = textbook.load(name)
    first, again, other = (random_states(mechanism, 3, seed) for seed in (1, 1, 2))
    assert len(first) == 3
    assert first.q.shape == (3, mechanism.nq)
    assert first.v.shape == (3, mechanism.nv)
    for part in ("q", "v", "t"):
        np.testing.assert_array_equal(getattr(first, part), getattr(again, part))
    assert not np.array_equal(first.q, other.q)


def test_angles_fill_the_circle_and_lengths_keep_to_the_size_of_the_mechanism() -> None:
    mechanism = textbook.load("cart_pole", l=0.01)
    states = random_states(mechanism, 500, 0)
    assert characteristic_length(mechanism) == pytest.approx(0.01, rel=1e-12)
    assert 0.0039 < abs(states.q[:, 0]).max() <= 0.004
    assert 3.1 < abs(states.q[:, 1]).max() <= np.pi
    assert abs(states.v[:, 0]).max() <= 0.03
    assert 2.9 < abs(states.v[:, 1]).max() <= 3


def test_a_textbook_angle_that_is_no_joint_coordinate_is_an_angle() -> None:
    states = random_states(textbook.load("double_pendulum"), 300, 0)
    assert (abs(states.q).max(axis=0) > 3).all()


def test_a_slide_that_follows_a_crank_has_an_angle_too() -> None:
    from sympy import cos

    mechanism = slider(coordinates=Coordinates(("phi",), {"x": 0.2 * cos(coordinate("phi"))}))
    assert abs(random_states(mechanism, 200, 0).q).max() > 3


def test_quaternions_have_unit_length() -> None:
    bodies = (
        Body("ground"),
        Body("a", ball(1, 0.1)),
        Body("b", ball(1, 0.1)),
        Body("c", ball(1, 0.1)),
    )
    joints = (
        Spherical("s", "ground", "a"),
        Floating("f", "ground", "b"),
        Planar("p", "ground", "c"),
    )
    mechanism = Mechanism("free", bodies, joints)
    states = random_states(mechanism, 50, 0)
    assert states.q.shape == (50, 14)
    assert states.v.shape == (50, 12)
    np.testing.assert_allclose(np.linalg.norm(states.q[:, :4], axis=1), 1, rtol=1e-14, atol=0)
    np.testing.assert_allclose(np.linalg.norm(states.q[:, 7:11], axis=1), 1, rtol=1e-14, atol=0)
    assert abs(states.q[:, 4:7]).max() <= 0.4
    assert abs(states.q[:, 13]).max() > 2.5


def test_time_varies_only_where_the_equations_depend_on_it() -> None:
    still = random_states(slider(JointForce("f", "slide", 2.0)), 5, 0)
    assert (still.t == 0).all()
    moving = [
        slider(JointForce("f", "slide", time())),
        slider(Force("f", "block", (0, 0, 0), (time(), 0, 0))),
        slider(JointForce("f", "slide", F := Input("F", lambda t: t)), inputs=(F,)),
        slider(coordinates=Coordinates((), {"x": 0.1 * time()})),
    ]
    for mechanism in moving:
        assert len(set(random_states(mechanism, 5, 0).t)) == 5


def test_a_spring_on_a_line_is_never_turned_inside_out() -> None:
    """Its length is 0.5 + x; coordinates of ±0.4 typical lengths would reach beyond zero."""
    far = Placement((5, 0, 0))
    joints = (
        Prismatic(
            "slide",
            "ground",
            "block",
            axis=(1, 0, 0),
            coordinate="x",
            origin=Placement((0.5, 0, 0)),
        ),
        Prismatic("other", "ground", "heavy", axis=(1, 0, 0), coordinate="y", origin=far),
        Prismatic("third", "ground", "last", axis=(1, 0, 0), coordinate="z", origin=far),
    )
    bodies = (Body("ground"), *(Body(name, particle(1)) for name in ("block", "heavy", "last")))
    spring = Spring("s", "ground", (0, 0, 0), "block", (0, 0, 0), 10.0, 0.5)
    mechanism = Mechanism("long", bodies, joints, (spring,))
    assert (random_states(mechanism, 200, 0).q[:, 0] < -0.5).any()
    states = random_states(mechanism, 200, 0, derive(mechanism).derivation.assumptions)
    assert abs(states.q[:, 1]).max() > 1
    assert (states.q[:, 0] > -0.5).all()


def test_a_spring_across_a_hinge_may_point_anywhere() -> None:
    joint = Revolute("pin", "ground", "rod", axis=(0, -1, 0), coordinate="q")
    spring = Spring("s", "ground", (0, 0, 0), "rod", (0, 0, -1), 10.0, 0.5)
    states = random_states(
        Mechanism("turn", (Body("ground"), Body("rod", rod(1, 1))), (joint,), (spring,)), 200, 0
    )
    assert abs(states.q).max() > 3


@pytest.mark.parametrize("kind", [Spring, Damper])
def test_a_span_that_is_always_zero_is_refused(kind: type) -> None:
    force = kind("s", "block", (1, 0, 0), "block", (1, 0, 0), 10.0)
    with pytest.raises(InputError, match=r"expected states of mechanism 'slider' .* found 0 of 3"):
        random_states(slider(force), 3, 0)


def test_states_outside_the_coordinate_map_are_not_drawn() -> None:
    from sympy import sqrt

    u = coordinate("u")
    mechanism = slider(coordinates=Coordinates(("u",), {"x": sqrt(u)}))
    states = random_states(mechanism, 40, 0)
    assert len(states) == 40
    assert (states.q >= 0).all()


@pytest.mark.parametrize(
    ("samples", "seed", "message"),
    [
        (0, 0, "expected a whole number of at least 1 for samples, got 0"),
        (10**9, 0, "expected at most 333,333 samples of a mechanism with 1 velocity, got"),
        (True, 0, "expected a whole number of at least 1 for samples, got True"),
        (2.5, 0, "expected a whole number of at least 1 for samples, got 2.5"),
        (3, -1, "expected a whole number of at least 0 for seed, got -1"),
        (3, "x", "expected a whole number of at least 0 for seed, got 'x'"),
    ],
)
def test_bad_numbers_are_refused(samples: Any, seed: Any, message: str) -> None:
    with pytest.raises(InputError, match=message):
        random_states(slider(), samples, seed)


def test_states_next_to_a_singular_point_of_the_coordinates_are_not_drawn() -> None:
    """Two of the top's axes are in line where its second angle is zero."""
    states = random_states(textbook.load("heavy_top"), 3000, 0)
    assert 0 < np.sin(abs(states.q[:, 1])).min() < 0.2
    assert np.sin(abs(states.q[:, 1])).min() > 5e-3


def test_how_regular_a_mass_matrix_is_does_not_depend_on_units() -> None:
    """Of rows and columns scaled alike, the condition of [[1, c], [c, 1]] is (1 + c)/(1 − c)."""
    c, units = 0.9, np.diag([1e-3, 1e4])
    mass = np.array([[1.0, c], [c, 1.0]])
    for matrix in (mass, units @ mass @ units):
        assert states._condition(matrix) == pytest.approx((1 + c) / (1 - c), rel=1e-9)
    assert states._condition(np.diag([0.0, 1.0])) == 1.0


def test_states_keep_a_little_inside_the_limits_of_a_coordinate() -> None:
    mechanism = slider(coordinates=Coordinates((), limits={"x": (1.0, 3.0)}))
    q = random_states(mechanism, 500, 0).q[:, 0]
    assert 1.1 <= q.min() < 1.15
    assert 2.85 < q.max() <= 2.9


@pytest.mark.parametrize("limits", [(5.0, np.inf), (-np.inf, -5.0)])
def test_a_slide_that_starts_far_away_keeps_to_its_one_limit(limits: tuple[float, float]) -> None:
    """States lie between the limit and its mirror image in the neutral position."""
    mechanism = slider(coordinates=Coordinates((), limits={"x": limits}))
    assert abs(mechanism.neutral()[0]) == 6
    far = abs(random_states(mechanism, 200, 0).q)
    assert 5 <= far.min() < 5.1
    assert 6.9 < far.max() <= 7


def test_rates_and_accelerations_take_both_signs() -> None:
    states = random_states(textbook.load("double_pendulum"), 100, 0)
    for part in (states.v, states.a):
        assert (part.min(axis=0) < -2).all()
        assert (part.max(axis=0) > 2).all()


@pytest.mark.parametrize("seed", [1, 7])
def test_states_of_a_governor_are_none_where_its_links_fall_together(seed: int) -> None:
    """With the sleeve at the pins the arms hold nothing; most positions near zero lead there."""
    mechanism = textbook.load("governor")
    states = random_states(mechanism, 60, seed)
    assert np.abs(states.q[:, mechanism.coordinates.index("s")]).min() > 1e-3
    closed = Reference(mechanism)
    for q in states.q:
        assert np.linalg.matrix_rank(closed.constraint_jacobian(q), tol=1e-6) == 2


def test_states_of_a_long_chain_of_loops_are_met_on_a_walk_along_them() -> None:
    # no random position of its 33 hinges leads to one at which its 16 loops are closed
    chain = four_bars_in_series(16)
    states = random_states(chain, 4, 0, lot=4)
    assert Reference(chain).drift(states.q, states.v)[:, 0].max() < 1e-12
    assert np.ptp(states.q[:, 0]) > 0.5


def test_a_walk_takes_over_where_random_positions_seldom_close_the_loops(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    # of 32 random positions of six squares one closes all loops; the search took 22,737 steps
    steps = []
    step = assembly._Search.step

    def count(search: Any, *given: Array) -> Array:
        steps.append(search)
        return step(search, *given)

    monkeypatch.setattr(assembly._Search, "step", count)
    chain = four_bars_in_series(6)
    met = random_states(chain, 20, 0)
    assert len(steps) < 2500
    assert Reference(chain).drift(met.q, met.v)[:, 0].max() < 1e-12
    assert len(np.unique(met.q.round(6), axis=0)) == 20


@pytest.mark.parametrize("tilt", [1e-9, 1e-8, 1e-7])
def test_axes_parallel_to_some_digits_alone_are_refused_with_that_cause(tilt: float) -> None:
    """A ball joint in a linkage of a plane, whose row across it holds what its axes differ by."""
    bars = tuple(Body(name, rod(1.0, 1.0, direction=(1, 0, 0))) for name in ("a", "b", "c"))
    joints = (
        Revolute("A", "ground", "a", axis=(0, 1, 0)),
        Revolute("B", "a", "b", axis=(0, 1, 0), origin=Placement((1, 0, 0))),
        Revolute("C", "ground", "c", axis=(tilt, 1, 0), origin=Placement((1.5, 0, 0))),
    )
    loop = Loop.ball("D", "b", (1, 0, 0), "c", (1, 0, 0))
    linkage = Mechanism("linkage", (Body("ground"), *bars), joints, loops=(loop,))
    with pytest.raises(InputError, match=r"\(D: y.* parallel, .* with all digits"):
        verify(linkage, 5)
    assert verify(replace(linkage, joints=(*joints[:2], replace(joints[2], axis=(0, 1, 0)))), 5)


def four_bars_in_series(count: int) -> Mechanism:
    """Squares side by side: each upright hangs from the rod across that comes before it."""
    up, down, across = (rod(1.0, 1.0, direction=d) for d in ((0, 1, 0), (0, -1, 0), (1, 0, 0)))
    bodies = [Body("ground"), Body("down0", up)]
    joints, loops = [Revolute("A0", "ground", "down0")], list[Loop]()
    place: tuple[float, float, float] = (0, 1, 0)
    for k in range(1, count + 1):
        bodies += [Body(f"across{k}", across), Body(f"down{k}", down)]
        joints += [
            Revolute(f"C{k}", f"down{k - 1}", f"across{k}", origin=Placement(place)),
            Revolute(f"B{k}", f"across{k}", f"down{k}", origin=Placement((1, 0, 0))),
        ]
        place = (0, 0, 0)
        loops.append(
            Loop.pin(f"A{k}", "ground", (k, 0, 0), f"down{k}", (0, -1, 0), normal=(0, 0, 1))
        )
    return Mechanism("series", tuple(bodies), tuple(joints), loops=tuple(loops))


@pytest.mark.parametrize("crown", [0.0, 0.05])
@pytest.mark.parametrize("seed", [1, 4])
def test_a_wheel_is_not_compared_where_it_lies_almost_flat(crown: float, seed: int) -> None:
    """Its place of contact is not determined there; its height is r times the sine of the lean."""
    mass, radius = 1.4, 0.17
    wheel = Mechanism(
        "wheel",
        (Body("ground"), Body("disk", disk(mass, radius).at(rpy=(np.pi / 2, 0, 0)))),
        (Floating("free", "ground", "disk"),),
        contacts=(Rolling("rim", "disk", radius, crown=crown),),
    )
    height = random_states(wheel, 100, seed).q[:, 2]
    assert (height > crown + 0.00999 * (radius - crown)).all()
    assert height.min() < crown + 0.1 * (radius - crown)
    assert verify(wheel, 100, seed).agrees


@pytest.mark.parametrize("source", ["reference", "derive"])
@pytest.mark.parametrize("name", ["double_pendulum", "kepler_orbit"])
def test_facts_are_asked_of_the_better_half_of_twice_as_many_states(name: str, source: str) -> None:
    bench = Bench(textbook.entry(name), {}, source, samples=5, seed=3)
    drawn = random_states(bench.mechanism, 10, 3, derive(bench.mechanism).derivation.assumptions)
    worth = np.linalg.cond(Reference(bench.mechanism).mass_matrix(drawn.q))
    better = drawn.q[np.argsort(worth)[:5]]
    np.testing.assert_array_equal([q for q, _, _ in bench.states], better)


@pytest.mark.parametrize(("part", "holds"), [(1.0, True), (0.5, False)])
@pytest.mark.parametrize("source", ["reference", "derive"])
def test_what_is_conserved_may_contain_time(part: float, holds: bool, source: str) -> None:
    """Of what falls with a: x' − a t, and x − x' t + a t² / 2."""

    def at_the_start(s: facts.Values) -> list[facts.Number]:
        a = part * s.g * (s.m1 - s.m2) / (s.m1 + s.m2 + s.M / 2)
        return [s["x'"] - a * s.t, s.x - s["x'"] * s.t + a * s.t**2 / 2]

    system = textbook.entry("atwood_machine")
    stated = replace(system, facts=(facts.Conserved("its state at the start", at_the_start),))
    (row,) = check_facts(stated, source=source)
    assert row.holds == holds


def test_a_walk_stays_on_the_branch_it_begins_on() -> None:
    """The crank turns around; coupler and rocker are never in line, so that branches are apart."""
    linkage = textbook.load("four_bar_linkage")
    bent = []
    for walk in (True, False):
        states = random_states(linkage, 30, 2, walk=walk)
        phi, theta, psi = states.q.T
        bent.append(set(np.sign(np.sin(phi + theta - psi)).tolist()))
        assert np.ptp(phi) > 3.0
    assert len(bent[0]) == 1
    assert bent[1] == {1.0, -1.0}


def test_where_a_third_of_random_positions_close_no_walk_is_begun(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("mecanique.verification.states.wander", None)
    assert len(random_states(textbook.load("governor"), 20, 0)) == 20
