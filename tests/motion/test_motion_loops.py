"""Closed mechanisms in motion: loops, energy, singular positions, published results."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from mecanique import assemble, textbook, verify
from mecanique.errors import ClosureError, InputError, IntegrationError
from mecanique.model import (
    Body,
    Fixed,
    JointDamper,
    JointSpring,
    Loop,
    Mechanism,
    Placement,
    Prismatic,
    ball,
    box,
    coordinate,
    time,
)
from mecanique.motion import Motion, simulate
from mecanique.motion.analysis.forces import Actions
from mecanique.motion.compile.along import ASKED
from mecanique.motion.record.events import Event
from mecanique.reference import Reference
from mecanique.reference.engine.load import EngineModel, load
from mecanique.reference.loops import assembly

PUBLISHED = {
    "beta": 15.81077119629904,
    "theta": -15.75637105984298,
    "gamma": 0.04082224013073101,
    "phi": -0.5347301163226948,
    "delta": 0.5244099658805304,
    "omega": 0.5347301163226948,
    "epsilon": 1.048080741042263,
}
"""The squeezer after 0.03 s (test set for IVP solvers, problem andrews)."""


def drift(motion: Motion, t: np.ndarray | None = None) -> float:
    closed = motion.reference.closed
    assert closed is not None
    states = zip(motion.q, motion.v, motion.t, strict=True)
    if t is not None:
        state = motion(t)
        states = zip(state.q, state.v, t, strict=True)
    return float(max(max(closed.drift(q, v, float(s))) for q, v, s in states))


def energy_error(motion: Motion) -> float:
    energy = motion.energy()
    return float(abs(energy.balance).max() / energy.scale)


@pytest.fixture(scope="module")
def linkage() -> Motion:
    return simulate(
        textbook.load("four_bar_linkage"),
        q={"phi": 1.1, "theta": -0.8, "psi": 1.2},
        duration=3.0,
        fps=20,
    )


def test_the_start_is_closed_and_the_motion_says_so(linkage: Motion) -> None:
    assert "; loops closed at the start (positions changed by up to" in linkage.method
    assert drift(linkage) < 1e-13
    exact = simulate(
        textbook.load("four_bar_linkage"), q={"phi": 1.1}, v={"phi": 1.5}, duration=0.1
    )
    assert (exact.q[0, 0], exact.v[0, 0]) == (1.1, pytest.approx(1.5, abs=1e-12))
    assert exact.method.endswith("; loops closed at the start"), "what was given has not changed"


def test_what_rolls_says_what_of_its_start_changed() -> None:
    coin = textbook.load("rolling_coin")
    above = {"lean": 0.2, "z": 0.6}
    moved = simulate(coin, q=above, v={"spin": -5.0}, duration=0.1)
    assert re.search(r"; constraints met at the start \(positions changed by .*\);", moved.method)
    set_down = {**above, "z": 0.5 * math.cos(0.2)}
    kept = simulate(coin, q=set_down, v={"spin": -5.0}, duration=0.1)
    assert "; constraints met at the start; x = 0, y = 0, " in kept.method


def test_positions_velocities_and_energy_are_kept(linkage: Motion) -> None:
    assert drift(linkage) < 1e-13
    assert drift(linkage, np.linspace(0.01, 2.99, 50)) < 1e-13
    assert energy_error(linkage) < 1e-10


def test_the_balances_of_the_audit_hold_with_the_forces_of_the_loops(linkage: Motion) -> None:
    audit = linkage.audit()
    assert audit.ok, str(audit)
    assert audit["loops, in lengths or radians"].residual < 1e-13
    assert audit["rates of the loops"].residual < 1e-12


def test_the_audit_sees_loops_that_drift(linkage: Motion) -> None:
    open_loops = linkage.q + np.linspace(0, 1e-6, len(linkage))[:, None] * [1.0, 0.0, 0.0]
    drifted = replace(linkage, q=open_loops)
    audit = drifted.audit()
    assert not audit.ok
    row = audit["loops, in lengths or radians"]
    assert row.time > 1.5
    assert row.residual == pytest.approx(1e-6, rel=1.0)
    assert "loops, in lengths or radians" in str(audit)
    assert "BROKEN" in str(audit)


def test_loop_forces_are_there_along_the_motion(linkage: Motion) -> None:
    found = linkage.reactions("C")
    assert found.force.shape == (len(linkage), 3)
    named = {
        action.name
        for action in Actions(linkage.mechanism, linkage.reference).reactions(
            linkage.t, linkage.q, linkage.v
        )
    }
    assert named == {"A", "B", "C", "D"}
    later = linkage.reactions("C", t=[1.0, 2.0])
    assert later.force.shape == (2, 3)


@pytest.mark.parametrize("name", ["rolling_coin", "four_bar_linkage", "governor"])
def test_many_states_are_closed_together_as_each_is_alone(
    name: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    system = textbook.entry(name)
    motion = simulate(textbook.load(name), q=system.start, v=system.start_velocity, duration=2.0)
    t = np.linspace(0.0, 2.0, 501)
    alone = [motion(float(at)) for at in t[::50]]
    motion(t)  # writes the program
    projections = 0

    def count(*args: Any, **options: Any) -> tuple[np.ndarray, np.ndarray]:
        nonlocal projections
        projections += 1
        return project(*args, **options)

    project = assembly.project
    monkeypatch.setattr(assembly, "project", count)
    together = motion(t)
    assert projections <= ASKED
    np.testing.assert_allclose(together.q[::50], [state.q for state in alone], rtol=0, atol=1e-10)
    np.testing.assert_allclose(together.v[::50], [state.v for state in alone], rtol=0, atol=1e-9)
    assert drift(motion, t) < 1e-13


def test_the_squeezer_arrives_where_it_is_published_to() -> None:
    entry = textbook.entry("squeezer")
    motion = simulate(entry.mechanism(), q=dict(entry.start), duration=0.03, rtol=1e-11, samples=4)
    for name, value in PUBLISHED.items():
        assert motion[name][-1] == pytest.approx(value, rel=1e-7), name
    assert drift(motion) < 1e-12


@pytest.mark.parametrize("n", [1, 3])
def test_chained_four_bars_pass_their_singular_position_as_parallelograms(n: int) -> None:
    """From upright at 1 rad/s, the posts swing as one pendulum through the flat position."""
    mechanism = textbook.load("chained_four_bars", n=n)
    start = {f"theta{k}": np.pi / 2 for k in range(n + 1)} | {
        f"phi{k}": -np.pi / 2 for k in range(1, n + 1)
    }
    speeds = {f"theta{k}": -1.0 for k in range(n + 1)} | {f"phi{k}": 1.0 for k in range(1, n + 1)}
    motion = simulate(mechanism, q=start, v=speeds, duration=3.0, fps=20)
    posts = np.stack([motion[f"theta{k}"] for k in range(n + 1)])
    assert posts.min() < -np.pi  # it went through
    length = ((n + 1) / 3 + n) / ((n + 1) / 2 + n)
    rate = motion["theta0'"]
    np.testing.assert_allclose(
        rate**2, 1 + 2 * 9.81 / length * (1 - np.sin(motion["theta0"])), rtol=1e-9, atol=2e-8
    )
    np.testing.assert_allclose(posts, posts[:1].repeat(n + 1, axis=0), rtol=0, atol=1e-11)
    assert energy_error(motion) < 1e-9
    assert drift(motion) < 1e-10


def test_an_antiparallelogram_passes_its_flat_positions_along_a_curve() -> None:
    """Crossed parallelograms keep tan(phi/2) = −(d − a)/(d + a) tan(psi/2), twice flat a turn."""
    a, d = 0.5, 1.0
    mechanism = textbook.load("four_bar_linkage", a=a, b=d, c=a, d=d)
    psi = -2 * np.arctan((d + a) / (d - a) * np.tan(0.5))
    start = {"phi": 1.0, "psi": psi, "theta": psi}
    motion = simulate(mechanism, q=start, v={"phi": 6.0}, duration=2.0, fps=50)
    assert motion["phi"][-1] > 4 * np.pi  # two turns
    half = motion["phi"] / 2, motion["psi"] / 2
    np.testing.assert_allclose(
        np.sin(half[0]) * np.cos(half[1]),
        -(d - a) / (d + a) * np.sin(half[1]) * np.cos(half[0]),
        rtol=0,
        atol=1e-12,
    )
    assert energy_error(motion) < 1e-9
    assert drift(motion) < 1e-10


def test_arms_that_fall_together_pass_the_position_in_which_they_may_part() -> None:
    """Without spin the governor's arms swing through the stretched position, a crossing."""
    entry = textbook.entry("governor")
    motion = simulate(entry.mechanism(), q=dict(entry.start), duration=2.0, fps=20)
    assert motion["theta1"].min() < -1.0
    np.testing.assert_allclose(motion["theta1"], motion["theta2"], rtol=0, atol=1e-11)
    np.testing.assert_allclose(motion["s"], 2 * 0.5 * np.cos(motion["theta1"]), rtol=0, atol=1e-12)
    assert energy_error(motion) < 1e-9


@pytest.mark.parametrize("eps", [1e-4, 1e-6, 1e-8])
def test_a_linkage_near_its_change_point_turns_sharply_in_little_time(eps: float) -> None:
    """The follower then swings; where branches cross it would go round as well."""
    linkage = textbook.load("four_bar_linkage", a=1, b=2, c=1 + eps, d=2)
    motion, finer = (
        simulate(linkage, q={"phi": 1}, v={"phi'": 3}, duration=6, rtol=rtol)
        for rtol in (1e-10, 1e-12)
    )
    assert motion["phi"][-1] > 25, "the crank goes round"
    assert motion["psi"].max() < math.pi + 0.1, "the follower does not"
    assert motion.energy().balance == pytest.approx(0, abs=1e-9 * motion.energy().scale)
    rounding = 3e-16 / eps  # enlarged by 1/σ² at the turn
    assert motion.q[-1] == pytest.approx(finer.q[-1], abs=1e-9 + rounding)
    assert motion.statistics.evaluations < 80_000


@pytest.mark.parametrize(
    ("eps", "gap"), [(1e-10, "7e-11"), (1e-11, "7e-12"), (1e-12, "7e-13"), (1e-13, "7e-14")]
)
def test_where_rounding_decides_the_branch_a_motion_stops(eps: float, gap: str) -> None:
    linkage = textbook.load("four_bar_linkage", a=1, b=2, c=1 + eps, d=2)
    with pytest.raises(IntegrationError, match=f"come within {gap} of crossing, so that rounding"):
        simulate(linkage, q={"phi": 1}, v={"phi'": 3}, duration=6)


def test_what_differs_from_a_change_point_by_rounding_alone_crosses_it() -> None:
    motions = [
        simulate(
            textbook.load("four_bar_linkage", a=1, b=2, c=1 + eps, d=2),
            q={"phi": 1},
            v={"phi'": 3},
            duration=6,
        )
        for eps in (0, 1e-15)
    ]
    np.testing.assert_allclose(motions[1].q[-1], motions[0].q[-1], rtol=0, atol=1e-8)


def test_a_bar_next_to_a_singular_position_accelerates_as_anywhere_else() -> None:
    """A chain of parallelograms is one pendulum, even from a state slightly off the loops."""
    n, rate, random = 2, -3.5, np.random.default_rng(0)
    mechanism = textbook.load("chained_four_bars", n=n)
    reference = Reference(mechanism)
    flat = mechanism.position({})
    reference = reference.with_rank_at(
        {"theta0": 1.0, "theta1": 1.0, "theta2": 1.0, "phi1": -1.0, "phi2": -1.0}
    )
    turn = np.array([1.0] * (n + 1) + [-1.0] * n)
    length = ((n + 1) / 3 + n) / ((n + 1) / 2 + n)
    rhs = reference.rhs()
    for angle in (0.0, 1e-6, 1e-3, 0.02, 0.2):
        for off, tolerance in ((0.0, 1e-8), (1e-9, 1e-7)):
            y = np.concatenate([flat + angle * turn, rate * turn]) + off * random.standard_normal(
                2 * len(turn)
            )
            np.testing.assert_allclose(
                rhs(0.0, y)[len(turn) :],
                -9.81 / length * np.cos(angle) * turn,
                rtol=0,
                atol=tolerance,
            )


def test_the_governor_turns_steadily_where_porter_says() -> None:
    system = textbook.entry("governor")
    # psi'² = ((m + M) g - k (2 l cos theta - a)) / (m l cos theta)
    drop = 2 * 0.5 * np.cos(0.9)
    speed = np.sqrt((3 * 9.81 - 60 * (drop - 0.4)) / (0.5 * np.cos(0.9)))
    q = {"theta1": 0.9, "theta2": 0.9, "s": drop}
    motion = simulate(system.mechanism(), q=q, v={"psi": speed}, duration=2.0, fps=20)
    np.testing.assert_allclose(motion["theta1"], 0.9, rtol=0, atol=1e-12)
    np.testing.assert_allclose(motion["psi'"], speed, rtol=1e-9, atol=0)


def test_bricard_moves_on_its_curve() -> None:
    motion = simulate(textbook.load("bricard_linkage"), duration=2.0, fps=20)
    first, second = np.sin(motion["q1"]), np.sin(motion["q2"])
    assert np.ptp(motion["q1"]) > 0.1
    np.testing.assert_allclose(first * second, first + second, rtol=0, atol=1e-12)
    assert energy_error(motion) < 1e-9
    assert "force x" in motion.reactions("hinge6").undetermined


def test_a_run_loads_the_engine_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Redundant constraints need the degrees of freedom at the start: no reason to load again."""
    loaded = []

    def counting(mechanism: Mechanism) -> EngineModel:
        loaded.append(mechanism.name)
        return load(mechanism)

    monkeypatch.setattr("mecanique.reference.engine.tree.load", counting)
    motion = simulate(textbook.load("bricard_linkage"), duration=0.1)
    motion.reactions("hinge6")
    assert loaded == ["bricard_linkage"]


def test_an_implicit_method_stays_on_the_loops_too() -> None:
    motion = simulate(
        textbook.load("slider_crank"),
        q={"theta": 0.7},
        duration=0.3,
        rtol=1e-6,
        method="radau",
        fps=20,
    )
    assert drift(motion) < 1e-13
    assert motion.method.startswith("radau")
    assert energy_error(motion) < 1e-4


def test_what_cannot_be_closed_does_not_start() -> None:
    mechanism = textbook.load("four_bar_linkage", a=1.0, b=0.2, c=0.3)
    with pytest.raises(ClosureError, match="loop 'C' cannot be closed"):
        simulate(mechanism, q={"phi": 1.1})


def test_a_closed_mechanism_with_one_freedom_bounces_as_a_whole() -> None:
    mechanism = textbook.load("slider_crank")
    wall = Event("wall", coordinate("x") - 1.3, direction=-1, restitution=0.5)
    motion = simulate(mechanism, q={"theta": 0.7}, duration=1.0, fps=50, events=[wall])
    hit = motion.events[0]
    assert hit.q[mechanism.coordinates.index("x")] == pytest.approx(1.3, abs=1e-12)
    np.testing.assert_allclose(hit.after, -0.5 * hit.v, rtol=1e-9, atol=0)
    assert drift(motion) < 1e-12


def test_an_impulse_leaves_loops_closed_and_is_felt_by_what_it_pushes() -> None:
    mechanism = textbook.load("chained_four_bars", n=2)
    reference = Reference(mechanism)
    q = assemble(mechanism, {"theta0": 1.0, "theta1": 1.0, "phi1": -1.0})
    push = np.array([1.0, 0.0, 0.0, 0.0, 0.0])
    change = reference.response(q, 0.0, push)
    assert reference.closed is not None
    np.testing.assert_allclose(
        reference.closed.closures.at(q, change, 0.0).jacobian @ change, 0.0, rtol=0, atol=1e-14
    )
    # one pendulum: the work of the impulse is the kinetic energy it leaves
    assert push @ change == pytest.approx(change @ reference.mass_matrix(q) @ change, rel=1e-12)


def test_an_impact_that_no_motion_feels_is_said() -> None:
    mechanism = textbook.load("bars_and_springs_loop")
    held = Event("nothing", time() - 0.01, restitution=0.5)
    with pytest.raises(InputError, match="event 'nothing': no impulse changes its quantity"):
        simulate(mechanism, duration=0.1, events=[held])


def stiff_slider_crank() -> Mechanism:
    """The slider-crank of the catalogue carrying a load on a very stiff, overdamped spring."""
    loop = textbook.load("slider_crank")
    return replace(
        loop,
        bodies=(*loop.bodies, Body("load", box(1.0, (0.1, 0.1, 0.1)))),
        joints=(*loop.joints, Prismatic("seat", "slider", "load", axis=(1, 0, 0), coordinate="u")),
        forces=(JointSpring("spring", "seat", 1e6), JointDamper("damper", "seat", 3e4)),
    )


@pytest.mark.slow
def test_stiff_loops_are_left_to_an_implicit_method() -> None:
    mechanism, start = stiff_slider_crank(), dict(textbook.entry("slider_crank").start)
    auto = simulate(mechanism, q=start, v={"theta": 3.0}, duration=0.05, rtol=1e-8)
    assert auto.method.startswith("radau")
    assert "chosen for stiff equations, found by dop853 at" in auto.method
    asked = simulate(mechanism, q=start, v={"theta": 3.0}, duration=0.05, rtol=1e-8, method="radau")
    tight = simulate(
        mechanism, q=start, v={"theta": 3.0}, duration=0.05, rtol=1e-11, method="dop853"
    )
    assert tight.method.startswith("dop853")
    for motion in (auto, asked):
        assert motion.statistics.steps < tight.statistics.steps / 3
        assert drift(motion) < 1e-10
        assert drift(motion, np.linspace(0.001, 0.049, 40)) < 1e-10
        np.testing.assert_allclose(motion.q[-1], tight.q[-1], rtol=0, atol=1e-7)
        np.testing.assert_allclose(motion.v[-1], tight.v[-1], rtol=0, atol=1e-6)


@pytest.mark.slow
def test_a_loop_that_is_not_stiff_is_left_to_the_explicit_method() -> None:
    motion = simulate(
        textbook.load("slider_crank"), q=dict(textbook.entry("slider_crank").start), duration=5.0
    )
    assert motion.statistics.steps > 150
    assert motion.method.startswith("dop853")


def test_a_loop_between_bodies_that_stand_still_changes_nothing() -> None:
    """As a weld to a mocap body that does not move: a chain beside it is solved as a long one."""
    chain = textbook.load("n_link_pendulum", n=8)
    foot = Placement((1.0, 0.0, 0.0))
    braced = replace(
        chain,
        bodies=(*chain.bodies, Body("post", ball(1.0, 0.1))),
        joints=(*chain.joints, Fixed("foot", "ground", "post", origin=foot)),
        loops=(Loop.weld("brace", "ground", foot, "post", Placement()),),
    )
    assert verify(braced, samples=3).agrees
    start = {"q1": 0.4}
    motion = simulate(braced, q=start, duration=0.5, method="compiled")
    free = simulate(chain, q=start, duration=0.5)
    assert motion.q[-1] == pytest.approx(free.q[-1], abs=1e-8)
