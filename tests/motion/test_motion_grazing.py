"""Contacts that are only grazed, and closed forms of what stops by friction of several kinds."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import quad

import mecanique as mq

G = 9.81


def slider(*switching: mq.Friction | mq.Stop, **options: object) -> mq.Mechanism:
    """Return a block of 1 kg on a slide along x."""
    return mq.Mechanism(
        "slider",
        (mq.Body("ground"), mq.Body("block", mq.box(1.0, (0.1, 0.1, 0.1)))),
        (mq.Prismatic("slide", "ground", "block", axis=(1, 0, 0), coordinate="x"),),
        switching=switching,
        **options,  # type: ignore[arg-type]
    )


def test_a_stop_that_is_just_reached_takes_nothing() -> None:
    """Thrown up with v² = 2 g h it has no speed at h."""
    ceiling = slider(mq.Stop("ceiling", "slide", at=1.0, restitution=0.5), gravity=(-G, 0, 0))
    motion = mq.simulate(ceiling, v={"x": math.sqrt(2 * G)}, duration=0.7)
    assert not motion.events
    expected = 0.7 * math.sqrt(2 * G) - 0.245 * G
    np.testing.assert_allclose(motion["x"][-1], expected, rtol=1e-12, atol=0)


@pytest.mark.parametrize("depth", [1e-3, 1e-4, 1e-6])
def test_a_contact_within_one_step_is_found(depth: float) -> None:
    """A ball barely below the top of a dome; without gravity its steps are long."""
    joint = mq.Planar("plane", "ground", "body", axis=(0, -1, 0), names=("x", "z", "th"))
    top = mq.Placement((0, 0, 1.0))
    dome = mq.Contact("dome", "body", radius=0.1, bowl=-1.0, plane=top, restitution=0.5)
    bodies = mq.Body("ground"), mq.Body("body", mq.ball(1.0, 0.1))
    free = mq.Mechanism("free", bodies, (joint,), gravity=(0, 0, 0), switching=(dome,))
    start = {"x": -0.23, "z": 1.1 - depth}
    (hit,) = mq.simulate(free, q=start, v={"x": 1.0}, duration=0.4).events
    assert hit.t == pytest.approx(0.23 - math.sqrt(1.1**2 - (1.1 - depth) ** 2), rel=1e-12)


@pytest.mark.parametrize("excess", [1e-3, 1e-5])
def test_a_throw_a_little_too_fast_strikes_the_ceiling(excess: float) -> None:
    """With v there is v² − 2 g h left at h, of which e² comes back."""
    ceiling = slider(mq.Stop("ceiling", "slide", at=1.0, restitution=0.5), gravity=(-G, 0, 0))
    v = math.sqrt(2 * G) * (1 + excess)
    motion = mq.simulate(ceiling, v={"x": v}, duration=0.7, rtol=1e-10)
    (strike,) = motion.events
    left = math.sqrt(v**2 - 2 * G)
    assert strike.t == pytest.approx((v - left) / G, rel=1e-12)
    assert strike.after[0] == pytest.approx(-0.5 * left, rel=1e-8)


def test_viscous_friction_beside_dry_stops_after_a_logarithm() -> None:
    """From m v' = −μ m g − c v: t = m/c ln(1 + c v/(μ m g))."""
    dry = slider(
        mq.Friction("dry", "slide", 0.1, G), forces=(mq.JointDamper("damper", "slide", 0.5),)
    )
    (stops,) = mq.simulate(dry, v={"x": 2.0}, duration=2.0, rtol=1e-12).events
    assert stops.t == pytest.approx(2 * math.log(1 + 1.0 / (0.1 * G)), rel=1e-12)


def test_stribecks_friction_stops_after_its_integral() -> None:
    """From v' = −μ(v) g with μ = μ_k + (μ_s − μ_k) exp(−v²/v_s²): t = ∫ dv/(μ g)."""

    def mu(u: float) -> float:
        return 0.1 + 0.15 * math.exp(-((u / 0.05) ** 2))

    falling = 0.1 + 0.15 * mq.exp(-((mq.velocity("x") / 0.05) ** 2))
    rubs = slider(mq.Friction("dry", "slide", falling, G, mu_static=0.25))
    (stops,) = mq.simulate(rubs, v={"x": 1.0}, duration=1.5, rtol=1e-12).events
    time, _ = quad(lambda u: 1 / (mu(u) * G), 0, 1, points=[0.05, 0.1], epsabs=1e-13, epsrel=1e-13)
    assert stops.t == pytest.approx(time, rel=1e-11)


def test_resistance_to_spinning_stops_a_ball() -> None:
    """The couple δ m g stops I ω after I ω/(δ m g)."""
    bodies = mq.Body("ground"), mq.Body("lift", mq.massless()), mq.Body("ball", mq.ball(1.0, 0.1))
    joints = (
        mq.Prismatic("up", "ground", "lift", axis=(0, 0, 1), coordinate="z"),
        mq.Revolute("spin", "lift", "ball", axis=(0, 0, 1), coordinate="psi"),
    )
    elements = (
        mq.Contact("floor", "ball", radius=0.1),
        mq.Friction("pivots", "spin", 0.001, load="floor"),
    )
    spun = mq.Mechanism("spun", bodies, joints, switching=elements)
    (stops,) = mq.simulate(spun, q={"z": 0.1}, v={"psi": 5.0}, duration=2.5).events
    assert stops.t == pytest.approx(0.4 * 0.01 * 5.0 / (0.001 * G), rel=1e-12)


def test_a_block_between_two_walls_strikes_at_a_geometric_sum() -> None:
    """From the middle of 2 m at 1 m/s: 1 s, then 2 s/e, 2 s/e², 2 s/e³."""
    e = 0.5
    walls = (
        mq.Stop("right", "slide", at=1.0, restitution=e),
        mq.Stop("left", "slide", at=-1.0, side=-1, restitution=e),
    )
    motion = mq.simulate(slider(*walls), v={"x": 1.0}, duration=30.0)
    times = [event.t for event in motion.events if event.impact]
    assert times == pytest.approx(np.cumsum([1.0, 2 / e, 2 / e**2, 2 / e**3]), rel=1e-13)


def test_equal_balls_that_impact_together_share_by_newton() -> None:
    """One complementarity problem: both gaps' rates are reversed, so −1/3, 2/3, 2/3."""
    bodies = mq.Body("ground"), *(mq.Body(f"b{k}", mq.ball(1.0, 0.05)) for k in range(3))
    joints = [mq.Prismatic(f"x{k}", "ground", f"b{k}", axis=(1, 0, 0)) for k in range(3)]
    face = mq.Placement((0.05, 0, 0), (0, math.pi / 2, 0))
    between = [
        mq.Contact(
            f"c{k}", f"b{k + 1}", radius=0.05, on=f"b{k}", bowl=-0.05, plane=face, restitution=1.0
        )
        for k in range(2)
    ]
    row = mq.Mechanism("row", bodies, tuple(joints), switching=tuple(between))
    motion = mq.simulate(row, q=[-0.3, 0.0, 0.1], v=[1.0, 0, 0], duration=0.5)
    np.testing.assert_allclose(motion.v[-1], [-1 / 3, 2 / 3, 2 / 3], rtol=1e-12, atol=0)


@pytest.mark.parametrize("depth", [1e-3, 1e-5])
@pytest.mark.parametrize("direction", [-1, 0, 1])
def test_an_event_that_is_passed_and_passed_back_within_a_step_is_noted(
    depth: float, direction: int
) -> None:
    """x = cos t is below −1 + d for acos(1 − d) around π; where it just comes, it does not pass."""
    oscillator = slider(gravity=(0, 0, 0), forces=(mq.JointSpring("spring", "slide", 1.0),))

    def pass_below(x: float) -> list[float]:
        below = mq.Event("below", lambda t, q, v: q[0] - x, direction)
        return [
            event.t for event in mq.simulate(oscillator, q=[1.0], duration=5, events=[below]).events
        ]

    half = math.acos(1 - depth)
    expected = {-1: [-half], 0: [-half, half], 1: [half]}[direction]
    passed = np.array(pass_below(depth - 1)) - math.pi
    assert passed == pytest.approx(expected, abs=1e-7)
    assert not pass_below(-1.0)
