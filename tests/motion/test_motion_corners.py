"""Motions with corners: dry friction, stops and contacts against closed forms."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import partial
from itertools import product
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import ellipkinc
from sides import CORNERS, TRIPOD, make_pair, make_slope, make_standing_box, make_tow

import mecanique as mq
from mecanique.derivation.mechanics.switching import ElementRows, ElementState, Terms, name_mode
from mecanique.motion.motion import Motion
from mecanique.motion.switching import law
from mecanique.motion.switching.corners import Corners, ModePrograms
from mecanique.motion.switching.rows import SwitchingRows

G = 9.81
AXES = {"x": (1, 0, 0), "y": (0, 1, 0), "z": (0, 0, 1)}
_FORCES = ("normal", "friction")


def slider(*switching: mq.Friction | mq.Stop, stiffness: float = 0.0) -> mq.Mechanism:
    """Return a block of 1 kg on a level slide, with a spring to its origin."""
    return mq.Mechanism(
        "slider",
        (mq.Body("ground"), mq.Body("block", mq.box(1.0, (0.1, 0.1, 0.1)))),
        (mq.Prismatic("slide", "ground", "block", axis=(1, 0, 0), coordinate="x"),),
        forces=(mq.JointSpring("spring", "slide", stiffness),) if stiffness else (),
        switching=switching,
    )


def flat(shape: object, *switching: mq.Contact) -> mq.Mechanism:
    """Return a body that moves in the plane x, z and turns by th about −y."""
    joint = mq.Planar("plane", "ground", "body", axis=(0, -1, 0), names=("x", "z", "th"))
    bodies = (mq.Body("ground"), mq.Body("body", shape))  # type: ignore[arg-type]
    return mq.Mechanism("flat", bodies, (joint,), switching=switching)


def particle(*switching: mq.Contact) -> mq.Mechanism:
    """Return a particle of 1 kg with the coordinates x and z."""
    bodies = mq.Body("ground"), mq.Body("carriage", mq.massless()), mq.Body("p", mq.particle(1.0))
    joints = (
        mq.Prismatic("x", "ground", "carriage", axis=(1, 0, 0)),
        mq.Prismatic("z", "carriage", "p", axis=(0, 0, 1)),
    )
    return mq.Mechanism("particle", bodies, joints, switching=switching)


def ball(restitution: float) -> mq.Mechanism:
    """Return a ball that falls on the floor."""
    fall = mq.Prismatic("fall", "ground", "ball", axis=(0, 0, 1), coordinate="z")
    floor = mq.Contact("floor", "ball", restitution=restitution)
    bodies = (mq.Body("ground"), mq.Body("ball", mq.ball(1.0, 0.1)))
    return mq.Mechanism("ball", bodies, (fall,), switching=(floor,))


def names(motion: Motion) -> list[str]:
    """Return the names of what happened."""
    return [event.name for event in motion.events]


def test_a_dry_oscillator_rests_after_five_half_cycles() -> None:
    """Each half period moves the center by 2 μ m g/k (facts of the textbook oscillator)."""
    block = slider(mq.Friction("dry", "slide", 0.1, G), stiffness=100.0)
    motion = mq.simulate(block, q={"x": 0.1}, duration=3.0, rtol=1e-13)
    assert names(motion) == [*["dry: slips +", "dry: slips -"] * 2, "dry: sticks"]
    np.testing.assert_allclose(
        [event.t for event in motion.events],
        np.arange(1, 6) * math.pi / 10,
        rtol=0,
        atol=1e-14,
    )
    np.testing.assert_allclose(motion["x"][-1], -0.0019, rtol=0, atol=1e-15)
    # stick is exact
    rest = motion.t > math.pi / 2
    assert not motion.v[rest].any()
    assert np.ptp(motion.q[rest]) == 0
    assert [span.states["dry"] for span in motion.modes][-1] == "sticks"
    assert motion.audit().ok
    # heat: the path 2 (0.1 + …) times μ m g
    path = sum(2 * (0.1 - (2 * k + 1) * 0.00981) for k in range(5))
    np.testing.assert_allclose(motion.energy().work[-1], -path * 0.1 * G, rtol=1e-12, atol=0)


@pytest.mark.parametrize(("angle", "sticks"), [(0.09, True), (0.11, False)])
def test_a_block_on_an_incline_slides_beyond_the_angle_of_repose(
    angle: float, sticks: bool
) -> None:
    alpha = math.atan(angle)
    block = replace(
        slider(mq.Friction("dry", "slide", 0.05, G * math.cos(alpha), mu_static=0.1)),
        gravity=(G * math.sin(alpha), 0, -G * math.cos(alpha)),
    )
    motion = mq.simulate(block, duration=1.0)
    expected = 0.0 if sticks else G * (math.sin(alpha) - 0.05 * math.cos(alpha)) / 2
    np.testing.assert_allclose(motion["x"][-1], expected, rtol=1e-13, atol=0)


def test_a_mass_on_a_belt_sticks_and_slips_in_closed_form() -> None:
    """It sticks until k x = μ₀ N, then swings about μ N/k until its speed is the belt's again."""
    k, v, mu, static = 100.0, 0.1, 0.2, 0.4
    friction = mq.Friction("belt", "slide", mu, G, mu_static=static, speed=v)
    motion = mq.simulate(slider(friction, stiffness=k), v={"x": v}, duration=20.0)
    w, held = math.sqrt(k), static * G / k
    above = held - mu * G / k
    slip = (2 * math.pi - 2 * math.atan2(above * w, v)) / w
    stick = 2 * above / v
    times = np.array([event.t for event in motion.events])
    np.testing.assert_allclose(times[0], held / v, rtol=1e-13, atol=0)
    np.testing.assert_allclose(np.diff(times)[::2], slip, rtol=0, atol=1e-9)
    np.testing.assert_allclose(np.diff(times)[1::2], stick, rtol=0, atol=1e-9)


def test_a_pendulum_meets_its_stop() -> None:
    hinge = mq.Revolute("pin", "ground", "rod", axis=(0, -1, 0), coordinate="q")
    rod = mq.Mechanism(
        "rod",
        (mq.Body("ground"), mq.Body("rod", mq.rod(1.0, 1.0))),
        (hinge,),
        switching=(mq.Stop("wall", "pin", at=0.0, side=-1, restitution=0.5),),
    )
    motion = mq.simulate(rod, q={"q": 1.0}, duration=2.0, rtol=1e-13)
    speed = math.sqrt(3 * G * (1 - math.cos(1.0)))
    quarter = ellipkinc(math.pi / 2, math.sin(0.5) ** 2) / math.sqrt(1.5 * G)
    impact = motion.events[0]
    np.testing.assert_allclose(impact.t, quarter, rtol=0, atol=1e-13)
    np.testing.assert_allclose(
        [impact.v[0], impact.after[0]], [-speed, speed / 2], rtol=1e-12, atol=0
    )
    # it swings out to where its energy is a quarter
    top = math.acos(1 - (1 - math.cos(1.0)) / 4)
    again = 2 * ellipkinc(math.pi / 2, math.sin(top / 2) ** 2) / math.sqrt(1.5 * G)
    np.testing.assert_allclose(motion.events[1].t - impact.t, again, rtol=0, atol=1e-12)
    assert motion["q"].min() > -1e-12
    assert motion.audit().ok


@pytest.mark.parametrize("place", [0.2, 0.3, 1.0])
@pytest.mark.parametrize("speed", [1.0, 2.0, 3.0])
def test_an_elastic_stop_gives_back_what_it_takes(place: float, speed: float) -> None:
    """Half a period of the spring, π √(m/k); its gap is rounded to either side as it opens."""
    block = slider(mq.Stop("buffer", "slide", at=place, stiffness=400.0))
    motion = mq.simulate(block, v={"x": speed}, duration=1.5, rtol=1e-12)
    (at, off) = (event.t for event in motion.events)
    np.testing.assert_allclose([at, off - at], [place / speed, math.pi / 20], rtol=0, atol=1e-12)
    np.testing.assert_allclose(motion.v[-1], -speed, rtol=1e-11, atol=0)


@pytest.mark.parametrize("push", [3.0, 8.0])
def test_what_sticks_at_a_stop_is_pulled_off_by_more_than_its_friction(push: float) -> None:
    """Kinetic friction is the smaller: it jumps, and the stop, which would pull, holds nothing."""
    rate, mu, mu_0 = 2.0, 0.3, 0.4
    force = mq.Input("F", lambda t: push - rate * t, "N")
    dry = mq.Friction("dry", "slide", mu, G, mu_static=mu_0)
    block = replace(
        slider(mq.Stop("wall", "slide"), dry),
        forces=(mq.JointForce("pull", "slide", force),),
        inputs=(force,),
    )
    motion = mq.simulate(block, q={"x": -0.2}, v={"x": 0.5}, duration=8.0)
    assert motion.modes[-1].states == {"wall": "open", "dry": "slips -"}
    off = (push + mu_0 * G) / rate
    np.testing.assert_allclose(motion.modes[-1].begin, off, rtol=0, atol=1e-11)
    left = 8.0 - off
    x = -rate * left**3 / 6 - (mu_0 - mu) * G * left**2 / 2
    np.testing.assert_allclose(motion["x"][-1], x, rtol=1e-11, atol=0)


def test_a_bouncing_ball_comes_to_rest_at_its_time() -> None:
    """The bounces are a geometric sum, √(2h/g) (1 + e)/(1 − e)."""
    motion = mq.simulate(ball(0.8), q={"z": 1.0}, duration=5.0)
    rest = math.sqrt(2 / G) * (1 + 0.8) / (1 - 0.8)
    np.testing.assert_allclose(rest, 4.06371276887157814, rtol=1e-15, atol=0)
    last = motion.events[-1]
    assert last.name == "floor: rest"
    np.testing.assert_allclose(last.t, rest, rtol=0, atol=1e-12)
    assert not motion.v[-1].any()
    np.testing.assert_allclose(motion.q[-1], 0.0, rtol=0, atol=1e-15)
    np.testing.assert_allclose(motion.energy().work[-1], -G, rtol=1e-12, atol=0)


def test_bounces_that_slip_end_with_the_friction_of_all_of_them() -> None:
    """Down a slope of 30°: those left out press as gravity does, less the impulse that ends them.

    Friction takes μ (1 + e) u of each impact at a speed u, together μ (1 + e) u/(1 − e), until the
    bounces end after u/g (1 + e)/(1 − e) with the speed u of the first.
    """
    mu, e, h, end = 0.1, 0.6, 0.3, 2.0
    across, along = G * math.cos(math.pi / 6), G * math.sin(math.pi / 6)
    start = {"x": h * math.sin(math.pi / 6), "z": h * math.cos(math.pi / 6)}
    motion = mq.simulate(make_slope(mu), q=start, duration=end, rtol=1e-12)
    first = math.sqrt(2 * h * across)
    rest = first / across * (1 + e) / (1 - e)
    speed = along * end - mu * first * (1 + e) / (1 - e) - mu * across * (end - rest)
    assert motion.modes[-1].states == {"slope": "slips +"}
    np.testing.assert_allclose(motion.times("slope: rest")[0], rest, rtol=1e-11, atol=0)
    np.testing.assert_allclose(np.hypot(*motion.v[-1]), speed, rtol=1e-13, atol=0)


def test_bounces_off_a_place_that_decimals_round_end_in_time() -> None:
    """A ball's center at 0.1 m has its gap rounded, which took 2e-10 s from the lowest bounces."""
    m = mq.Mechanism(
        "ball",
        (mq.Body("ground"), mq.Body("ball", mq.ball(1.0, 0.1))),
        (mq.Prismatic("z", "ground", "ball", axis=(0, 0, 1)),),
        switching=(mq.Contact("floor", "ball", radius=0.1, restitution=0.8),),
    )
    motion = mq.simulate(m, q=[1.1], duration=5.0)
    rest = math.sqrt(2 / G) * (1 + 0.8) / (1 - 0.8)
    assert motion.events[-1].name == "floor: rest"
    np.testing.assert_allclose(motion.events[-1].t, rest, rtol=1e-12, atol=0)
    lost = motion.losses([5.0])["floor: impact"][0]
    np.testing.assert_allclose(lost, G, rtol=1e-12, atol=0)


def test_a_billiard_ball_rolls_at_five_sevenths_of_its_speed() -> None:
    mu, r, mass = 0.2, 0.03, 0.17
    table = flat(mq.ball(mass, r), mq.Contact("cloth", "body", radius=r, mu=mu))
    motion = mq.simulate(table, q={"z": r}, v={"x": 1.0}, duration=1.0)
    (rolls,) = motion.events
    assert rolls.name == "cloth: sticks"
    np.testing.assert_allclose(rolls.t, 2 / (7 * mu * G), rtol=1e-14, atol=0)
    np.testing.assert_allclose(motion["x'"][-1], 5 / 7, rtol=1e-14, atol=0)
    heat = mass / 2 - mass * 0.7 * 25 / 49
    np.testing.assert_allclose(motion.energy().work[-1], -heat, rtol=1e-12, atol=0)


def test_a_bead_leaves_a_sphere_at_two_thirds() -> None:
    dome = mq.Contact("sphere", "p", bowl=-1.0, plane=mq.Placement((0, 0, 1.0)))
    start = {"x": math.sin(0.1), "z": math.cos(0.1)}
    motion = mq.simulate(particle(dome), q=start, duration=2.0)
    assert names(motion) == ["sphere: open"]
    np.testing.assert_allclose(motion.events[0].q[1], 2 / 3 * math.cos(0.1), rtol=0, atol=1e-11)


def test_a_cord_goes_slack_and_is_taut_again() -> None:
    """From below with v₀² = 4 g l it is slack where cos θ = (v₀²/(g l) − 2)/3, above the pivot."""
    cord = mq.Contact("cord", "p", bowl=1.0, plane=mq.Placement((0, 0, -1.0)))
    start = {"x": 0.0, "z": -1.0}
    motion = mq.simulate(particle(cord), q=start, v={"x": math.sqrt(4 * G)}, duration=1.5)
    assert names(motion) == ["cord: open", "cord: impact", "cord: closed"]
    slack, taut, _ = motion.events
    np.testing.assert_allclose(slack.q[1], 2 / 3, rtol=0, atol=1e-11)
    np.testing.assert_allclose(np.hypot(*taut.q), 1.0, rtol=0, atol=1e-14)
    radial = taut.after @ taut.q
    np.testing.assert_allclose(radial, 0.0, rtol=0, atol=1e-13)


def test_a_rocking_block_loses_what_housner_says() -> None:
    """G. W. Housner, Bull. Seism. Soc. Am. 53 (1963) 403: the rate after is 1 − 3/2 sin²α of it."""
    b, h = 0.2, 0.8
    corners = [
        mq.Contact(name, "body", center=(side * b / 2, 0, -h / 2), mu=1.0)
        for name, side in (("left", -1), ("right", 1))
    ]
    alpha, R = math.atan2(b, h), math.hypot(b, h) / 2
    tilt = alpha / 2
    lever = b / 2 * math.cos(tilt) - h / 2 * math.sin(tilt)
    start = {
        "x": -lever,
        "z": b / 2 * math.sin(tilt) + h / 2 * math.cos(tilt),
        "th": -tilt,
    }
    motion = mq.simulate(flat(mq.box(1.0, (b, b, h)), *corners), q=start, duration=0.5)
    (impact,) = [event for event in motion.events if event.impact]
    rate = impact.after[2] / impact.v[2]
    np.testing.assert_allclose(rate, 1 - 1.5 * math.sin(alpha) ** 2, rtol=0, atol=1e-12)
    # an inverted pendulum from α/2 off its top: θ'² = 2 p² (cos θ₀ − cos θ), p² = 3 g/(4 R)
    p = math.sqrt(3 * G / (4 * R))
    speed = p * math.sqrt(2 * (math.cos(alpha / 2) - math.cos(alpha)))
    np.testing.assert_allclose(impact.v[2], speed, rtol=1e-11, atol=0)


def test_the_balls_of_newtons_cradle_pass_the_momentum_on() -> None:
    r = 0.05
    bodies = [mq.Body("ground"), *(mq.Body(f"b{i}", mq.ball(1.0, r)) for i in range(3))]
    joints = [mq.Prismatic(f"x{i}", "ground", f"b{i}", axis=(1, 0, 0)) for i in range(3)]
    between = [
        mq.Contact(
            f"c{i}",
            f"b{i + 1}",
            radius=r,
            on=f"b{i}",
            bowl=-r,
            plane=mq.Placement((r, 0, 0), (0, math.pi / 2, 0)),
            restitution=1.0,
            in_turn=True,
        )
        for i in range(2)
    ]
    cradle = mq.Mechanism("cradle", tuple(bodies), tuple(joints), switching=tuple(between))
    motion = mq.simulate(cradle, q=[-0.3, 0.0, 2 * r], v=[1.0, 0, 0], duration=1.0)
    np.testing.assert_allclose(motion.v[-1], [0, 0, 1], rtol=0, atol=1e-13)
    np.testing.assert_allclose(motion.events[0].t, 0.2, rtol=1e-13, atol=0)
    assert names(motion) == ["c0, c1: impact"]


def test_what_treats_no_elements_that_switch_names_them() -> None:
    block = slider(mq.Friction("dry", "slide", 0.1, G))
    for ask in (mq.derive, mq.Reference, mq.linearize):
        with pytest.raises(mq.MecaniqueError, match="elements that switch, 'dry': "):
            ask(block)
    with pytest.raises(mq.InputError, match=r"as mq\.derive_modes writes them; leave them out by"):
        mq.derive(block)
    with pytest.raises(mq.InputError, match="a formula is checked where the equations are those"):
        mq.check(block, "m x'' = 0")
    with pytest.raises(mq.InputError, match="what follows on the turning earth is not looked for"):
        mq.inertial_check(block, mq.simulate(block, v=[1.0], duration=0.1), 0.8)
    with pytest.raises(mq.InputError, match="method 'taylor' passes no corners"):
        mq.simulate(block, duration=1.0, method="taylor")


def test_faults_of_elements_that_switch_are_named() -> None:
    for element, fault in (
        (mq.Friction("f", "nothing", 0.1, 1.0), "'nothing' is no joint with one coordinate"),
        (mq.Friction("f", "slide", 0.3, 1.0, mu_static=0.2), "at least the kinetic 0.3, got 0.2"),
        (mq.Stop("s", "slide", restitution=1.2), "expected a restitution in 0…1, got 1.2"),
        (mq.Stop("s", "slide", stiffness=0.0), "expected a stiffness above 0, got 0"),
        (mq.Contact("c", "nobody"), "'nobody' is no body"),
    ):
        with pytest.raises(mq.MechanismError, match=fault):
            slider(element)  # type: ignore[arg-type]
    with pytest.raises(mq.InputError, match="expected side 1 or -1, got 2"):
        mq.Stop("s", "slide", side=2)
    with pytest.raises(mq.InputError, match="expected a law 'newton' or 'poisson'"):
        mq.Contact("c", "block", law="hertz")  # type: ignore[arg-type]


def test_a_start_within_a_wall_is_refused() -> None:
    with pytest.raises(mq.InputError, match=r"'floor' begins with a gap of -0.1"):
        mq.simulate(ball(0.5), q={"z": -0.1}, duration=1.0)


def test_a_ball_in_space_rolls_at_five_sevenths_of_its_speed() -> None:
    mu, r = 0.2, 0.03
    bodies = mq.Body("ground"), mq.Body("ball", mq.ball(0.17, r))
    cloth = mq.Contact("cloth", "ball", radius=r, mu=mu)
    table = mq.Mechanism(
        "table", bodies, (mq.Floating("free", "ground", "ball"),), switching=(cloth,)
    )
    start = [0, 0, r, 0, 0, 0, 1]
    motion = mq.simulate(table, q=start, v=[0.8, 0.6, 0, 0, 0, 0], duration=0.3)
    (rolls,) = motion.events
    assert rolls.name == "cloth: sticks"
    np.testing.assert_allclose(rolls.t, 2 / (7 * mu * G), rtol=0, atol=1e-11)
    velocity = motion.velocity("ball").linear[-1]
    np.testing.assert_allclose(velocity, [4 / 7, 3 / 7, 0], rtol=0, atol=1e-11)


@pytest.mark.parametrize(
    ("shape", "part"), [(mq.ring(1.0, 0.1), 1 / 2), (mq.disk(1.0, 0.1), 2 / 3)]
)
def test_a_hoop_and_a_disk_roll_at_their_parts_of_the_speed(shape: mq.Shape, part: float) -> None:
    turned = shape.at(rpy=(math.pi / 2, 0, 0))
    wheel = flat(turned, mq.Contact("floor", "body", radius=0.1, mu=0.3))
    motion = mq.simulate(wheel, q={"z": 0.1}, v={"x": 2.0}, duration=1.0)
    np.testing.assert_allclose(motion["x'"][-1], 2.0 * part, rtol=1e-12, atol=0)


def test_a_ladder_leaves_the_wall_at_two_thirds_of_its_height() -> None:
    length, lean = 2.0, 0.3
    rod = mq.rod(1.0, length)
    floor = mq.Contact("floor", "body", center=(0, 0, -length))
    wall = mq.Contact("wall", "body", plane=mq.Placement((0, 0, 0), (0, math.pi / 2, 0)))
    start = {"x": 0.0, "z": length * math.cos(lean), "th": lean}
    motion = mq.simulate(flat(rod, floor, wall), q=start, duration=1.1)
    leaves = motion.events[0]
    assert leaves.name == "wall: open"
    height = leaves.q[1] / start["z"]
    np.testing.assert_allclose(height, 2 / 3, rtol=0, atol=1e-10)


def test_what_sticks_together_breaks_away_at_the_sum_of_its_friction() -> None:
    """Two brakes on one slide share the load in no way that is known; together they hold 3 N."""
    brakes = mq.Friction("a", "slide", 1.0, 1.0), mq.Friction("b", "slide", 1.0, 2.0)
    block = slider(*brakes)
    ramp = mq.Input("F", lambda t: 2.0 * t, "N", "pull")
    block = replace(block, inputs=(ramp,), forces=(mq.JointForce("pull", "slide", ramp),))
    motion = mq.simulate(block, duration=2.5)
    assert motion.modes[0].states == {"a": "sticks", "b": "sticks"}
    assert motion.modes[0].end == pytest.approx(1.5, rel=1e-9, abs=0.0)
    assert motion.modes[-1].states == {"a": "slips +", "b": "slips +"}
    # x'' = 2 (t − 1.5) from there
    assert motion["x"][-1] == pytest.approx(1.0 / 3.0, rel=1e-9, abs=0.0)


def test_a_stop_bears_what_friction_beside_it_cannot() -> None:
    """Pushed by 3 sin t against a stop with a brake of 1 N, a block leaves at sin t = −1/3."""
    push = mq.Input("F", lambda t: 3.0 * math.sin(t), "N", "push")
    brake, wall = mq.Friction("brake", "slide", 1.0, 1.0), mq.Stop("wall", "slide", 0.0)
    block = replace(slider(brake, wall), inputs=(push,))
    block = replace(block, forces=(mq.JointForce("push", "slide", push),))
    motion = mq.simulate(block, duration=4.0)
    assert [mode.states for mode in motion.modes] == [
        {"brake": "sticks", "wall": "open"},
        {"brake": "sticks", "wall": "closed"},
        {"brake": "slips -", "wall": "open"},
    ]
    begin = math.pi + math.asin(1 / 3)
    assert motion.modes[-1].begin == pytest.approx(begin, rel=1e-9, abs=0.0)
    rate = 3.0 * (math.cos(begin) - math.cos(4.0)) + 4.0 - begin
    np.testing.assert_allclose(motion.v[-1], [rate], rtol=1e-9, atol=0)


def test_a_clutch_slips_and_locks() -> None:
    """Torque T between I₁ and I₂ at first ω and 0: locked after ω/(T (1/I₁ + 1/I₂))."""
    drive, load, torque, rate = 0.5, 0.2, 3.0, 40.0
    plate = [
        mq.Body(name, mq.disk(2 * inertia, 1.0)) for name, inertia in (("a", drive), ("b", load))
    ]
    joints = (
        mq.Revolute("shaft", "ground", "a", coordinate="p"),
        mq.Revolute("clutch", "a", "b", coordinate="s"),
    )
    plates = mq.Friction("plates", "clutch", 1.0, torque)
    machine = mq.Mechanism(
        "clutch", (mq.Body("ground"), *plate), joints, gravity=(0, 0, 0), switching=(plates,)
    )
    motion = mq.simulate(machine, v={"p'": rate, "s'": -rate}, duration=3.0)
    (locks,) = motion.events
    assert locks.name == "plates: sticks"
    expected = rate / (torque * (1 / drive + 1 / load))
    np.testing.assert_allclose(locks.t, expected, rtol=1e-12, atol=0)
    together = rate * drive / (drive + load)
    np.testing.assert_allclose(motion.v[-1], [together, 0], rtol=1e-12, atol=0)
    lost = rate**2 / 2 * drive * load / (drive + load)
    np.testing.assert_allclose(motion.energy().work[-1], -lost, rtol=1e-11, atol=0)


@pytest.mark.parametrize(("friction", "first"), [(0.3, "slips +"), (0.9, "sticks")])
def test_a_block_tips_before_it_slides_if_it_is_slender(friction: float, first: str) -> None:
    """On a slope of tan α = 0.6 with b/h = 1/2: it slides if μ < 1/2, and tips otherwise."""
    b, h, alpha = 0.2, 0.4, math.atan(0.6)
    corners = [
        mq.Contact(name, "body", center=(side * b / 2, 0, -h / 2), mu=friction)
        for name, side in (("upper", -1), ("lower", 1))
    ]
    block = replace(
        flat(mq.box(1.0, (b, b, h)), *corners),
        gravity=(G * math.sin(alpha), 0, -G * math.cos(alpha)),
    )
    motion = mq.simulate(block, q={"z": h / 2}, duration=0.1)
    tips = first == "sticks"
    states = {"upper": "open" if tips else first, "lower": first}
    assert motion.modes[0].states == states


def test_poissons_restitution_without_friction_is_newtons() -> None:
    floor = mq.Contact("floor", "ball", restitution=0.6, law="poisson")
    bouncing = replace(ball(0.6), switching=(floor,))
    motion = mq.simulate(bouncing, q={"z": 1.0}, duration=0.6)
    impact = motion.events[0]
    np.testing.assert_allclose(impact.after, -0.6 * impact.v, rtol=1e-13, atol=0)


@pytest.mark.parametrize(
    ("speed", "after"), [(3.0, 3.0 - 0.05 * 1.8 * math.sqrt(2 * G)), (0.1, 0.0)]
)
def test_poissons_restitution_with_friction_of_a_particle(speed: float, after: float) -> None:
    """Its impulse is (1 + e) m v_n: it slides by μ times this, or sticks where less is needed."""
    floor = mq.Contact("floor", "p", mu=0.05, restitution=0.8, law="poisson")
    motion = mq.simulate(particle(floor), q={"z": 1.0}, v={"x": speed}, duration=0.6)
    impact = motion.events[0]
    np.testing.assert_allclose(impact.after[0], after, rtol=1e-10, atol=1e-14)
    np.testing.assert_allclose(impact.after[1], 0.8 * math.sqrt(2 * G), rtol=1e-10, atol=0)


@pytest.mark.parametrize(("speed", "after"), [(3.0, 3.0 - 0.09 * math.sqrt(2 * G)), (0.1, 0.0)])
def test_poissons_restitution_with_friction_in_space(speed: float, after: float) -> None:
    """As in the plane, along the direction in which it comes."""
    joints = tuple(
        mq.Prismatic(name, f"carriage {k}", f"carriage {k + 1}", axis=axis)
        for k, (name, axis) in enumerate(AXES.items())
    )
    bodies = [mq.Body(f"carriage {k}", mq.massless()) for k in (1, 2)]
    floor = mq.Contact(
        "floor", "carriage 3", on="carriage 0", mu=0.05, restitution=0.8, law="poisson"
    )
    free = mq.Mechanism(
        "particle",
        (mq.Body("carriage 0"), *bodies, mq.Body("carriage 3", mq.particle(1.0))),
        joints,
        ground="carriage 0",
        switching=(floor,),
    )
    start = {"x": 0.6 * speed, "y": -0.8 * speed}
    impact = mq.simulate(free, q={"z": 1.0}, v=start, duration=0.6).events[0]
    expected = [0.6 * after, -0.8 * after, 0.8 * math.sqrt(2 * G)]
    np.testing.assert_allclose(impact.after, expected, rtol=1e-10, atol=1e-14)


def test_friction_in_a_linkage_is_asked_of_the_engine_however_often() -> None:
    """Loops are not on the tape of modes; by the power of friction the energy falls."""
    linkage = mq.textbook.load("four_bar_linkage")
    joint = linkage.joints[0].name
    dry = replace(linkage, switching=(mq.Friction("dry", joint, 0.1, 1.0),))
    motion = mq.simulate(dry, v={linkage.velocities[0]: 3.0}, duration=1.0)
    turned = np.abs(motion.q[-1, 0] - motion.q[0, 0])
    assert motion.losses([1.0])["dry: friction"][0] == pytest.approx(0.1 * turned, rel=1e-8)
    assert motion.audit().ok


def test_an_oblique_impact_with_friction_conserves_momentum_about_the_contact() -> None:
    """A ball with μ small slides through: Δv_x = −μ (1 + e) v_n, r Δω = 5/2 of it (Routh)."""
    r, mu, e = 0.1, 0.05, 0.8
    bouncing = flat(mq.ball(1.0, r), mq.Contact("floor", "body", radius=r, mu=mu, restitution=e))
    motion = mq.simulate(bouncing, q={"z": 1.1}, v={"x": 3.0}, duration=0.6)
    impact = motion.events[0]
    fall = math.sqrt(2 * G)
    change = impact.after - impact.v
    np.testing.assert_allclose(change[1], (1 + e) * fall, rtol=1e-10, atol=0)
    np.testing.assert_allclose(change[0], -mu * (1 + e) * fall, rtol=1e-10, atol=0)
    # angular momentum about the point of contact: I ω' + m r v_x for turns about −y
    about = 0.4 * r**2 * change[2] - r * change[0]
    np.testing.assert_allclose(about, 0.0, rtol=0, atol=1e-12)


def test_what_ends_rolling_in_space_has_no_power_between_steps() -> None:
    """The curve's errors between steps are no motion of the contact, and are not resolved."""
    disk = mq.disk(1.0, 0.1).at(rpy=(math.pi / 2, 0, 0))
    thrown = mq.Mechanism(
        "thrown",
        (mq.Body("ground"), mq.Body("disk", disk)),
        (mq.Floating("free", "ground", "disk"),),
        switching=(mq.Contact("floor", "disk", radius=0.1, mu=0.1, restitution=0.5),),
    )
    motion = mq.simulate(thrown, q=[0, 0, 0.2, 0, 0, 0, 1], v=[1.0, 0, 0, 0, 30.0, 0], duration=2.0)
    assert motion.modes[-1].states == {"floor": "sticks"}
    times = np.linspace(motion.modes[-1].begin, 2.0, 200)[1:]
    rolling = motion(times)
    assert motion.corners is not None
    powers = motion.corners.powers(times, rolling.q, rolling.v)
    np.testing.assert_array_equal(powers, np.zeros((199, 2)))
    # m r v + m r² ω/2 is kept about the point of contact, and is 3 m r v/2 at the end
    np.testing.assert_allclose(
        motion.velocity("disk").linear[-1], [5 / 3, 0, 0], rtol=1e-9, atol=1e-9
    )
    energy = motion.energy()
    lost = sum(motion.losses().values())
    np.testing.assert_allclose(energy.total[0] - energy.total, lost, rtol=0, atol=1e-9)


def test_friction_in_space_opposes_slip_however_far_it_turns() -> None:
    """A puck pulled around: v' = F(t)/m − μ g v/|v|, integrated by itself.

    Beyond a right angle from where slip began, friction had the direction it had there.
    """
    w, pull, mu = 2.0, 5.0, 0.1
    bodies = ("ground", "along", "across")
    puck = mq.Mechanism(
        "puck",
        (*map(mq.Body, bodies), mq.Body("puck", mq.particle(1.0))),
        (
            mq.Prismatic("x", "ground", "along", axis=(1, 0, 0)),
            mq.Prismatic("y", "along", "across", axis=(0, 1, 0)),
            mq.Prismatic("z", "across", "puck", axis=(0, 0, 1)),
        ),
        forces=(
            mq.Force(
                "pull",
                "puck",
                (0, 0, 0),
                (pull * mq.cos(w * mq.time()), pull * mq.sin(w * mq.time()), 0),
                axes="world",
            ),
        ),
        switching=(mq.Contact("floor", "puck", mu=mu),),
    )
    start = [0.0, -2.5, 0.0]
    motion = mq.simulate(puck, q=[0, 0, 0], v=start, duration=6.0, samples=25)

    def slope(t: float, v: np.ndarray) -> np.ndarray:
        force = pull * np.array([math.cos(w * t), math.sin(w * t)])
        return np.asarray(force - mu * 9.81 * v / np.hypot(*v))

    alone = solve_ivp(slope, (0, 6), start[:2], rtol=1e-11, atol=1e-12, t_eval=motion.t)
    np.testing.assert_allclose(motion.v[:, :2], alone.y.T, rtol=0, atol=1e-7)
    assert motion.audit().ok
    assert [span.states for span in motion.modes] == [{"floor": "slips"}]


def test_a_ball_leaves_a_ball_at_ten_seventeenths() -> None:
    """Rolling all the way, 17 cos θ = 10 cos θ₀; friction without bound is nearly that."""
    R, r, lean = 1.0, 0.25, 0.2
    dome = mq.Contact("dome", "body", radius=r, bowl=-R, plane=mq.Placement((0, 0, R)), mu=1e7)
    start = {"x": (R + r) * math.sin(lean), "z": (R + r) * math.cos(lean)}
    motion = mq.simulate(flat(mq.ball(1.0, r), dome), q=start, duration=1.5)
    leaves = next(event for event in motion.events if event.name == "dome: open")
    cosine = leaves.q[1] / (R + r)
    np.testing.assert_allclose(cosine, 10 / 17 * math.cos(lean), rtol=0, atol=1e-5)


def wheel(lever: float, mu: float) -> mq.Mechanism:
    """Return a disk of 1 kg and 0.1 m on a level floor, with resistance to rolling."""
    disk = mq.disk(1.0, 0.1).at(rpy=(math.pi / 2, 0, 0))
    bodies = (
        mq.Body("ground"),
        *(mq.Body(name, mq.massless()) for name in ("carriage", "lift")),
        mq.Body("disk", disk),
    )
    joints = (
        mq.Prismatic("along", "ground", "carriage", axis=(1, 0, 0), coordinate="x"),
        mq.Prismatic("up", "carriage", "lift", axis=(0, 0, 1), coordinate="z"),
        mq.Revolute("spin", "lift", "disk", axis=(0, -1, 0), coordinate="th"),
    )
    elements = (
        mq.Contact("floor", "disk", radius=0.1, mu=mu),
        mq.Friction("rolls", "spin", lever, load="floor"),
    )
    return mq.Mechanism("wheel", bodies, joints, switching=elements)


def test_resistance_to_rolling_stops_a_disk() -> None:
    """The couple δ m g slows it by 2 δ g/(3 r²) as it rolls, and heat is what it had."""
    lever, v = 0.002, 0.5
    slows = 2 * lever * G / (3 * 0.1)
    start = {"x": v, "th": -v / 0.1}
    motion = mq.simulate(wheel(lever, 0.5), q={"z": 0.1}, v=start, duration=v / slows + 0.5)
    rests = motion.events[0]
    assert rests.name == "rolls: sticks"
    np.testing.assert_allclose(rests.t, v / slows, rtol=1e-12, atol=0)
    np.testing.assert_allclose(motion["x"][-1], v**2 / (2 * slows), rtol=1e-12, atol=0)
    lost = motion.losses()
    np.testing.assert_allclose(lost["rolls: friction"][-1], 0.75 * v**2, rtol=1e-11, atol=0)
    assert np.abs(motion.v[-1]).max() < 1e-30


def test_a_couple_goes_by_the_force_that_presses_now() -> None:
    """In the air there is none: the disk keeps its spin until it lands."""
    motion = mq.simulate(wheel(0.002, 0.5), q={"z": 1.1}, v={"th": 3.0}, duration=0.4)
    np.testing.assert_allclose(motion["th'"], 3.0, rtol=1e-14, atol=0)


def test_a_latch_keeps_what_comes_to_it_up_to_its_pull() -> None:
    """A spring k that pulls back with k x tears it off only where its pull is above."""
    for holds, kept in ((110.0, True), (90.0, False)):
        block = slider(mq.Stop("latch", "slide", at=1.0, holds=holds), stiffness=100.0)
        motion = mq.simulate(block, v={"x": 11.0}, duration=1.0)
        assert motion.modes[-1].states["latch"] == ("closed" if kept else "open")
        assert (motion["x"][-1] == pytest.approx(1.0, abs=1e-13)) == kept
    with pytest.raises(mq.InputError, match="expected a stiffness or what it holds, got both"):
        mq.Stop("latch", "slide", stiffness=1.0, holds=1.0)


def test_a_latch_opens_where_the_pull_passes_what_it_holds() -> None:
    ramp = mq.Input("F", lambda t: -2.0 * t, "N", "pull")
    latch = mq.Stop("latch", "slide", at=0.0, holds=1.0)
    block = slider(latch)
    block = replace(block, inputs=(ramp,), forces=(mq.JointForce("pull", "slide", ramp),))
    motion = mq.simulate(block, duration=1.5)
    (opens,) = motion.events
    assert opens.name == "latch: open"
    assert opens.t == pytest.approx(0.5, rel=1e-11)
    # x'' = −2 t from there
    T = 1.5
    assert motion["x'"][-1] == pytest.approx(-(T**2 - 0.25), rel=1e-10)


def test_a_cord_over_a_drum_is_held_by_less_than_euler_says() -> None:
    """m₁/m₂ = 3 is held where e^(μ φ) > 3, and slips where it is less."""
    for turns, kept in ((1.0, True), (0.8, False)):
        capstan = mq.textbook.load("capstan", phi=2 * math.pi * turns)
        motion = mq.simulate(capstan, q={"x": 1.0, "y": 2.0}, duration=0.1)
        assert motion.modes[0].states["drum"] == ("sticks" if kept else "slips +")
    hinge = mq.Revolute("pin", "ground", "block", axis=(0, 1, 0), coordinate="x")
    cord = mq.Capstan("cord", "pin", "pin", length=1.0, wrap=1.0)
    with pytest.raises(mq.MechanismError, match="expected the name of a slide, got 'pin'"):
        replace(slider(), joints=(hinge,), switching=(cord,))
    with pytest.raises(mq.MechanismError, match="capstan 'cord': expected a wrap above 0, got 0"):
        replace(slider(), switching=(mq.Capstan("cord", "slide", "slide", length=1.0),))


def test_a_drum_that_turns_drags_the_cord() -> None:
    """It runs towards the lighter weight, so friction is to that side, at whatever speed."""
    drum = mq.textbook.load("capstan")
    (cord,) = drum.switching
    assert isinstance(cord, mq.Capstan)
    driven = replace(drum, switching=(replace(cord, speed=-5.0),))
    motion = mq.simulate(driven, q={"x": 1.0, "y": 2.0}, duration=0.1)
    m_1, m_2, grown = 3.0, 1.0, math.exp(0.2 * math.pi)
    assert motion.modes[0].states["drum"] == "slips +"
    expected = G * (m_1 - m_2 * grown) / (m_1 + m_2 * grown)
    assert motion["x'"][-1] == pytest.approx(expected * 0.1, rel=1e-12)


def test_a_load_that_is_no_contact_is_named() -> None:
    with pytest.raises(mq.MechanismError, match="'wall', its load, is no contact or stop"):
        slider(mq.Friction("f", "slide", 0.1, load="wall"))


def test_a_contact_s_normal_force_and_friction_are_loads_by_themselves() -> None:
    """A ball that slides to the right: m g up, μ m g to the left, and the couple of its lever."""
    mass, r, mu = 0.17, 0.03, 0.2
    table = flat(mq.ball(mass, r), mq.Contact("cloth", "body", radius=r, mu=mu))
    motion = mq.simulate(table, q={"z": r}, v={"x": 1.0}, duration=0.1)
    names = [force.name for force in motion.mechanism.forces]
    assert names == ["cloth, normal", "cloth, friction", "cloth, friction, moment"]
    values = [signal.signal(0.05) for signal in motion.mechanism.inputs]
    expected = [0, 0, mass * G, -mu * mass * G, 0, 0, 0, mu * mass * G * r, 0]
    np.testing.assert_allclose(values, expected, rtol=1e-12, atol=1e-15)


def test_the_forces_of_a_corner_act_at_the_corner() -> None:
    block = mq.textbook.load("rocking_block")
    start = dict(mq.textbook.entry("rocking_block").start)
    motion = mq.simulate(block, q=start, duration=0.1)
    forces = [force for force in motion.mechanism.forces if isinstance(force, mq.Force)]
    places = {force.name: force.point for force in forces}
    assert list(places) == [f"{side}, {kind}" for side in ("left", "right") for kind in _FORCES]
    assert block.evaluate_all(places["right, friction"]) == pytest.approx(
        [0.1, 0.0, -0.4], rel=1e-15, abs=0
    )
    svg = mq.picture(motion, 0.05, free_body="block").svg
    assert "friction" in svg
    assert "moment" not in svg


def test_two_bodies_that_touch_have_opposite_forces() -> None:
    """Of a block on a sliding plate: on each what the other exerts."""
    bodies = (
        mq.Body("ground"),
        mq.Body("plate", mq.box(2.0, (1.0, 1.0, 0.1))),
        mq.Body("lift", mq.massless()),
        mq.Body("block", mq.particle(1.0)),
    )
    joints = (
        mq.Prismatic("x", "ground", "plate", axis=(1, 0, 0)),
        mq.Prismatic("y", "ground", "lift", axis=(1, 0, 0)),
        mq.Prismatic("z", "lift", "block", axis=(0, 0, 1)),
    )
    rubs = mq.Contact("rubs", "block", on="plate", mu=0.3)
    pair = mq.Mechanism("pair", bodies, joints, switching=(rubs,))
    motion = mq.simulate(pair, v={"y": 1.0}, duration=0.1)
    names = [force.name for force in motion.mechanism.forces]
    assert names[:2] == ["rubs on block, normal", "rubs on block, friction"]
    assert "rubs on plate, friction" in names
    assert motion.audit().ok
    # 0.3 g on the block, and 0.3 g/2 on the plate
    np.testing.assert_allclose(motion.v[-1, :2], [0.015 * G, 1 - 0.03 * G], rtol=1e-12, atol=0)


def test_many_motions_with_corners() -> None:
    """Each dry oscillator rests after its own number of half cycles."""
    block = mq.textbook.load("dry_oscillator")
    starts = [0.1, 0.05, 0.004]
    runs = mq.simulate_many(block, q={"x": starts}, duration=3.0, rtol=1e-12)
    assert "watches where dry switches" in runs.method
    swing = 0.1 * G / 100.0

    def rest(x: float) -> float:
        while abs(x) > swing:
            x = -x + 2 * math.copysign(swing, x)
        return x

    np.testing.assert_allclose(runs["x"][:, -1], [rest(x) for x in starts], rtol=0, atol=1e-12)
    with pytest.raises(mq.InputError, match="'batch' does not watch where dry switches; expected"):
        mq.simulate_many(block, q={"x": starts}, duration=3.0, method="batch")


SYSTEMS = {
    "stick and slip": slider(
        mq.Friction("belt", "slide", 0.2, G, mu_static=0.4, speed=0.2),
        mq.Stop("stop", "slide", 1.0),
        stiffness=100.0,
    ),
    "elastic stop": slider(mq.Stop("stop", "slide", 0.2, stiffness=50.0)),
    "ball": flat(mq.ball(1.0, 0.1), mq.Contact("floor", "body", radius=0.1, mu=0.3)),
    "particle": particle(mq.Contact("floor", "p", mu=0.4)),
}


def list_states(element: ElementRows) -> list[ElementState]:
    """Return the states an element of a planar mechanism may be in."""
    return [name_mode([element], {element.name: state})[0] for state in element.states]


@pytest.mark.parametrize("system", SYSTEMS)
def test_programs_of_modes_give_what_the_engine_s_quantities_do(system: str) -> None:
    corners = Corners(SYSTEMS[system])
    programs = ModePrograms(corners.rows)
    base, random = corners.rows.base, np.random.default_rng(7)
    choices = [list_states(element) for element in corners.elements]
    written = 0
    for mode in product(*choices):
        program = programs.write(mode)
        if program is None:
            continue
        written += 1
        for _ in range(5):
            q, v = random.normal(size=(2, base.nv))
            t, y = random.normal(), np.concatenate([q, v])
            terms = corners.rows.at(q, v, t)
            solution = corners.laws.solve(terms, mode)
            assert solution is not None
            rates, left = program.rates(t, y, mode, 0.0), program.margins(t, y, mode, 0.0)
            assert rates is not None
            assert left is not None
            np.testing.assert_allclose(rates, [*v, *solution.a], rtol=1e-10, atol=1e-10)
            margins, load = left
            expected = corners.laws.margins(terms, mode, corners.laws.solve(terms, mode))
            np.testing.assert_allclose(margins, expected, rtol=1e-10, atol=1e-10)
            assert load == pytest.approx(np.abs(terms.load).max(), rel=1e-12)
    assert written > 1


def test_a_program_of_slip_in_space_takes_its_direction_from_the_state() -> None:
    corners = Corners(make_tow())
    program = ModePrograms(corners.rows).write((ElementState("slips"),))
    assert program is not None
    q, v = np.random.default_rng(3).normal(size=(2, 5))
    y, terms = np.concatenate([q, v]), corners.rows.at(q, v, 0.0)
    slip = terms.rates[corners.rubbing["floor1"]]
    along, back = (
        (ElementState("slips", tuple(sign * slip / np.linalg.norm(slip))),) for sign in (1, -1)
    )
    solution = corners.laws.solve(terms, along)
    rates, left = program.rates(0.0, y, along, 1e-9), program.margins(0.0, y, along, 1e-9)
    assert solution is not None
    assert rates is not None
    assert left is not None
    np.testing.assert_allclose(rates, [*v, *solution.a], rtol=1e-12, atol=1e-12)
    expected = corners.laws.margins(terms, along, corners.laws.solve(terms, along))
    np.testing.assert_allclose(left[0], expected, rtol=1e-12, atol=1e-12)
    # past its end, and as rounding, it has none
    assert program.rates(0.0, y, back, 1e-9) is None
    assert program.margins(0.0, y, along, 10.0) is None


def test_a_mode_asked_for_often_is_computed_by_its_program(monkeypatch: pytest.MonkeyPatch) -> None:
    mechanism = slider(mq.Friction("dry", "slide", 0.1, G), stiffness=100.0)
    by_program = mq.simulate(mechanism, q={"x": 0.1}, duration=2.0)
    states: list[float] = []
    engine = Corners._rates

    def count(corners: Corners, t: float, y: np.ndarray) -> np.ndarray:
        states.append(t)
        return engine(corners, t, y)

    monkeypatch.setattr(Corners, "_rates", count)
    mq.simulate(mechanism, q={"x": 0.1}, duration=2.0)
    some = len(states)
    # a program that disagrees is not used
    monkeypatch.setattr(Corners, "_agrees", lambda *_: False)
    by_engine = mq.simulate(mechanism, q={"x": 0.1}, duration=2.0)
    assert len(states) - some > 3 * some
    np.testing.assert_allclose(by_program["x"], by_engine["x"], rtol=0, atol=1e-10)
    assert by_program["x"][-1] == pytest.approx(-0.0019, abs=1e-12)


def test_a_program_that_differs_from_the_engine_is_not_used(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    corners = Corners(slider(mq.Friction("dry", "slide", 0.1, G), stiffness=100.0))
    corners.begin(0.0, np.array([0.1, 0.0]))
    y = np.array([0.05, -0.3])
    program = ModePrograms(corners.rows).write(corners.mode(0.0))
    assert program is not None
    assert corners._agrees(program, 0.0, y)
    right = program._rates
    program._rates = lambda t, y: np.asarray(right(t, y)) * (1 + 1e-6)
    assert not corners._agrees(program, 0.0, y)


@pytest.mark.parametrize("system", SYSTEMS)
def test_terms_of_a_program_are_those_of_the_engine(system: str) -> None:
    corners, random = Corners(SYSTEMS[system]), np.random.default_rng(7)
    measure = ModePrograms(corners.rows).write_terms()
    assert measure is not None
    for _ in range(5):
        q, v = random.normal(size=(2, corners.rows.base.nv))
        t = random.normal()
        expected = corners.rows.at(q, v, t)
        for ours, theirs in zip(measure(t, np.concatenate([q, v])), expected, strict=True):
            np.testing.assert_allclose(ours, theirs, rtol=1e-12, atol=1e-12)


def test_rests_are_searched_for_by_a_program(monkeypatch: pytest.MonkeyPatch) -> None:
    """The engine is asked only whether a mode follows."""
    states, engine = list[float](), SwitchingRows.at

    def count(rows: SwitchingRows, q: np.ndarray, v: np.ndarray, t: float) -> Terms:
        states.append(t)
        return engine(rows, q, v, t)

    monkeypatch.setattr(SwitchingRows, "at", count)
    by_program = mq.equilibria(mq.textbook.load("dry_oscillator"), 10)
    some = len(states)
    monkeypatch.setattr(ModePrograms, "write_terms", lambda _: None)
    by_engine = mq.equilibria(mq.textbook.load("dry_oscillator"), 10)
    assert len(states) - some > 2 * some
    # nor is a program that fails in the first state
    monkeypatch.setattr(ModePrograms, "write_terms", lambda _: lambda t, y: 1 / 0)
    assert mq.equilibria(mq.textbook.load("dry_oscillator"), 1)[0].ranges == by_engine[0].ranges
    (ours,), (theirs,) = by_program, by_engine
    assert ours.states == theirs.states
    assert ours.ranges["x"] == pytest.approx(theirs.ranges["x"], rel=0, abs=1e-12)


@pytest.mark.parametrize("order", ["AB", "BA"])
def test_of_two_corners_in_a_step_the_first_is_passed_first(order: str) -> None:
    """The second was resolved with the first that was named, at its time."""
    places = {"A": 1.0, "B": 0.9999}
    bodies = [mq.Body(name, mq.box(1.0, (0.1, 0.1, 0.1))) for name in "AB"]
    slides = [mq.Prismatic(n, "ground", n, axis=(1, 0, 0), coordinate=f"x{n}") for n in "AB"]
    stops = [mq.Stop(f"stop {n}", n, at=places[n], restitution=0.5) for n in order]
    mechanism = mq.Mechanism(
        "two", (mq.Body("ground"), *bodies), tuple(slides), switching=tuple(stops)
    )
    motion = mq.simulate(mechanism, v={"xA": 1.0, "xB": 1.0}, duration=3.0)
    assert [event.name for event in motion.events] == ["stop B: impact", "stop A: impact"]
    assert [event.t for event in motion.events] == pytest.approx([0.9999, 1.0], rel=1e-13, abs=0)
    np.testing.assert_allclose(motion.q[-1], [0.0, -0.00015], rtol=0, atol=1e-13)


def test_a_motion_gives_the_forces_of_contacts_and_of_elements_in_joints() -> None:
    """A car brakes with its wheels locked: its front wheels bear m g (b + mu h)/(a + b)."""
    m, a, b, h, mu = 1000.0, 1.2, 1.3, 0.5, 0.8
    car = mq.Shape(m, inertia=(1500.0, 1500.0, 1500.0, 0, 0, 0))
    wheels = [
        mq.Contact(name, "body", center=(x, 0, -h), mu=mu)
        for name, x in (("front", a), ("rear", -b))
    ]
    motion = mq.simulate(flat(car, *wheels), q={"z": h}, v={"x": 20.0}, duration=1.0)
    front = motion.reactions("front")
    pressed = m * G * (b + mu * h) / (a + b)
    np.testing.assert_allclose(front.force[0], [-mu * pressed, 0, pressed], rtol=1e-12, atol=1e-9)
    np.testing.assert_allclose(front.moment, 0, rtol=0, atol=1e-9)
    moment = motion.reactions("rear", 0.0).about((0, 0, h), "world").moment
    bears = m * G - pressed
    np.testing.assert_allclose(moment, [0, (b + mu * h) * bears, 0], rtol=1e-12, atol=1e-9)
    with pytest.raises(mq.UnknownNameError, match="unknown joint, loop or contact 'wheel'"):
        motion.reactions("wheel")
    buffer = mq.Stop("buffer", "slide", at=1.0, stiffness=400.0)
    dry = mq.Friction("dry", "slide", 0.1, G)
    pushed = mq.simulate(slider(dry, buffer), v=[2.0], duration=0.8).guide_forces([0.1, 0.65])
    assert pushed["R_dry"].tolist() == [-0.1 * G, -0.1 * G]
    assert pushed["N_buffer"][0] == 0
    assert pushed["N_buffer"][1] > 1


def test_a_motion_that_moves_no_mass_is_refused_where_something_touches() -> None:
    bead = flat(mq.particle(1.0), mq.Contact("floor", "body"))
    for ask in (mq.simulate, mq.verify):
        with pytest.raises(mq.EngineError, match=r"the motion th', .* moves no mass"):
            ask(bead)


def test_what_stands_on_four_corners_presses_with_all_and_how_is_undetermined() -> None:
    """Two opposite corners were said to bear it, the others to be open."""
    motion = mq.simulate(make_standing_box(0.0), q={"free_z": 0.1}, duration=0.1)
    assert set(motion.modes[-1].states.values()) == {"closed"}
    corners = [motion.reactions(f"c{k}") for k in range(4)]
    assert {corner.undetermined for corner in corners} == {("force z",)}
    np.testing.assert_allclose(sum(c.force[-1] for c in corners), [0, 0, G], rtol=0, atol=1e-12)


@pytest.mark.parametrize("pull", [0.0, 0.25])
def test_two_rough_corners_share_friction_in_any_way(pull: float) -> None:
    b, h = 0.4, 0.2
    feet = (mq.Contact(n, "body", (x, 0, -h / 2), mu=0.3) for n, x in (("l", -b / 2), ("r", b / 2)))
    block = replace(flat(mq.box(1.0, (b, b, h)), *feet), gravity=(pull, 0, -G))
    motion = mq.simulate(block, q={"z": h / 2}, duration=0.1)
    left, right = motion.reactions("l"), motion.reactions("r")
    assert left.undetermined == right.undetermined == ("force x",)
    np.testing.assert_allclose(left.force[:, 2], G / 2 - pull * h / 2 / b, rtol=1e-12, atol=0)
    # rounding of what rests is none of its energy
    assert "balance within 1.0e+00" not in motion.summary()
    assert next(row for row in motion.audit().rows if row.name == "energy").relative < 1e-14


def test_brakes_that_hold_together_have_no_forces_of_their_own() -> None:
    brakes = (mq.Friction(name, "slide", 1.0, 1.0) for name in ("a", "b"))
    forces = mq.simulate(slider(*brakes), duration=0.1).guide_forces()
    assert np.isnan(forces["R_a"]).all()
    assert np.isnan(forces["R_b"]).all()


@pytest.mark.slow
def test_a_box_in_space_sticks_below_its_friction_and_slides_as_a_block() -> None:
    """All corners slip one way, and lose mu g whatever their shares are."""
    still = mq.simulate(make_standing_box(0.3, pull=2.9), q={"free_z": 0.1}, duration=0.1)
    assert set(still.modes[-1].states.values()) == {"sticks"}
    start = {"q": {"free_z": 0.1}, "v": {"free_vx": 0.6, "free_vy": 0.8}}
    motion = mq.simulate(make_standing_box(0.3), **start, duration=0.3)  # type: ignore[arg-type]
    assert {*motion.modes[0].states.values()} == {"slips"}
    way = 0.3 - 0.3 * G * 0.3**2 / 2
    np.testing.assert_allclose(motion.q[-1, :2], [0.6 * way, 0.8 * way], rtol=1e-10, atol=0)


@pytest.mark.slow
def test_a_box_that_turns_as_it_slides_is_refused() -> None:
    """How its corners share its weight decides how much their friction turns it."""
    start = {"q": {"free_z": 0.1}, "v": {"free_vx": 1.0, "free_wz": 2.0}}
    with pytest.raises(mq.IntegrationError, match=r"modes? follow"):
        mq.simulate(make_standing_box(0.3), **start, duration=0.1)  # type: ignore[arg-type]


def begin_tow(t: float, y: np.ndarray) -> np.ndarray:
    """Return the rates of ball and coin, (r, s, r', s'); slow slip goes along the pull."""
    (r, s), (u, w) = y[:4].reshape(2, 2), y[4:].reshape(2, 2)
    pull = 50.0 * (r - s)
    way = w if t > 1e-4 else pull
    return np.concatenate([u, w, -pull, pull - 0.4 * G * way / np.linalg.norm(way)])


def test_a_coin_begins_to_slip_in_space_without_end_of_steps() -> None:
    """Slow slip turns towards the pull at a rate of one over its square time: as stiff as any."""
    speed, aside, pull, rate = 1.0, 0.05, 0.4 * G / 50, math.sqrt(50)
    motion = mq.simulate(make_tow(), q={"y": aside}, v={"x": speed}, duration=0.2, rtol=1e-12)
    sine = math.sqrt((pull**2 - aside**2) / ((speed / rate) ** 2 - aside**2))
    begun = math.asin(sine) / rate
    assert [span.states["floor1"] for span in motion.modes] == ["sticks", "slips"]
    assert motion.modes[1].begin == pytest.approx(begun, rel=1e-11)
    at = [speed / rate * sine, aside * math.cos(rate * begun), 0, 0]
    moves = [speed * math.cos(rate * begun), -aside * rate * sine, 0, 0]
    options: Any = {"method": "Radau", "rtol": 1e-11, "atol": 1e-13}
    first = solve_ivp(begin_tow, (0, 1e-4), [*at, *moves], **options).y[:, -1]
    last = solve_ivp(begin_tow, (1.0001e-4, 0.2 - begun), first, **options).y[:, -1]
    np.testing.assert_allclose(motion.q[-1, [0, 1, 2, 3]], last[:4], rtol=0, atol=1e-8)


def test_alike_blocks_begin_to_slip_and_stop_at_once() -> None:
    """One and the other stuck in turn, with no headway; both springs hold the ball: it swings."""
    motion = mq.simulate(make_pair(), v={"x": 1.0}, duration=0.5, rtol=1e-11)
    assert "x1' = 0, x2' = 0 were not given" in motion.summary()
    np.testing.assert_allclose(motion.q[:, 1], motion.q[:, 2], rtol=0, atol=1e-13)
    begun = next(span.begin for span in motion.modes if set(span.states.values()) == {"slips +"})
    assert begun == pytest.approx(math.asin(10 * 3 / 50) / 10, rel=1e-11)
    lasting = [span for span in motion.modes if span.end - span.begin > 1e-9]
    assert [len(set(span.states.values())) for span in lasting] == [1] * 4
    # as one block of 2 kg on a spring of 100 N/m would, with 6 N of friction
    ball, block, _ = make_pair().bodies[1:]
    pull = 50.0 * (mq.coordinate("x") - mq.coordinate("x1")) ** 2
    one = replace(
        make_pair(),
        bodies=(mq.Body("ground"), ball, mq.Body(block.name, mq.particle(2.0))),
        joints=make_pair().joints[:2],
        coordinates=mq.Coordinates(("x", "x1")),
        forces=(mq.Potential("spring", ("x", "x1"), pull),),
        switching=(mq.Friction("brake", "x1", 1.0, 6.0),),
    )
    alone = mq.simulate(one, v={"x": 1.0}, duration=0.5, rtol=1e-11)
    np.testing.assert_allclose(motion.q[-1, :2], alone.q[-1], rtol=0, atol=1e-10)


@pytest.mark.parametrize("later", [0.0, 1e-9])
def test_coins_begin_to_slip_in_space_at_once_or_one_while_the_other_begins(later: float) -> None:
    aside, pull = 0.05, 0.4 * G / 50
    q = {"y1": aside, "y2": -aside * (1 - later)}
    motion = mq.simulate(make_tow(2), q=q, v={"x": 1.0}, duration=0.08, rtol=1e-11)
    assert motion.modes[-1].states == {"floor1": "slips", "floor2": "slips"}
    # both springs hold the ball: it swings as sin(10 t)/10
    begun = math.asin(10 * math.sqrt(pull**2 - aside**2)) / 10
    assert motion.modes[-1].begin == pytest.approx(begun, rel=1e-11 + later)
    last = motion.q[-1]
    mirrored = last[[0, 1, 2, 3, 4]] * [1, -1, 1, -1, 1]
    np.testing.assert_allclose(mirrored, last[[0, 1, 5, 6, 7]], rtol=0, atol=1e-11 + later)


@pytest.mark.slow
def test_a_box_begins_to_slide_from_rest() -> None:
    """All corners slip one way from the start, and lose mu g whatever their shares are."""
    motion = mq.simulate(make_standing_box(0.3, pull=3.0), q={"free_z": 0.1}, duration=0.3)
    assert {*motion.modes[0].states.values()} == {"slips"}
    way = (3.0 - 0.3 * G) * 0.3**2 / 2
    np.testing.assert_allclose(motion.q[-1, :3], [way, 0, 0.1], rtol=0, atol=1e-11)


def slide_on_tripod(t: float, y: np.ndarray, pull: float = 3.2) -> np.ndarray:
    """Return the rates of a box on three feet, pulled beside its center: (x, y, psi, x', y', psi').

    Each foot's friction is against its slip; balances of weight and moments give what they bear.
    """
    turn = np.array([[math.cos(y[2]), -math.sin(y[2])], [math.sin(y[2]), math.cos(y[2])]])
    at = np.array(TRIPOD) @ turn.T
    slip = y[3:5] + y[5] * np.column_stack([-at[:, 1], at[:, 0]])
    rub = -0.3 * slip / np.linalg.norm(slip, axis=1)[:, None]
    moments = (at + 0.1 * rub).T
    forces = np.linalg.solve([np.ones(3), *moments], [G, 0, 0])
    moment = at[:, 0] * rub[:, 1] - at[:, 1] * rub[:, 0]
    lever = turn @ [0, 0.1]
    spin = (forces @ moment - lever[1] * pull) / (2 * 0.4**2 / 12)
    return np.array([*y[3:], *(forces @ rub + [pull, 0]), spin])


@pytest.mark.slow
def test_a_tripod_begins_to_turn_as_it_slides() -> None:
    box = make_standing_box(0.3, 3.2, TRIPOD, aside=0.1)
    motion = mq.simulate(box, q={"free_z": 0.1}, duration=0.1, rtol=1e-11)
    times = [1e-6, 1e-3, 0.1]
    q, v = motion(times).q, motion(times).v
    angle = 2 * np.arctan2(q[:, 5], q[:, 6])
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    speeds = np.einsum("ijn,nj->ni", turn, v[:, :2])
    first, begun, last = np.column_stack([q[:, :2], angle, speeds, v[:, 5]])
    # each foot begins to slip as its slip grows
    growth = slide_on_tripod(0.0, first)[3:]
    np.testing.assert_allclose(first[3:], 1e-6 * growth, rtol=1e-8, atol=0)
    assert abs(growth[2]) > 1
    options: Any = {"method": "Radau", "rtol": 1e-11, "atol": 1e-13}
    known = solve_ivp(slide_on_tripod, (1e-3, 0.1), begun, **options).y[:, -1]
    np.testing.assert_allclose(last, known, rtol=0, atol=1e-9)


def test_directions_that_are_not_found_are_said_to_be_sought(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(law, "DIRECTION_STEPS", 0)
    with pytest.raises(mq.InputError, match=r"'c1', 'c2' may begin to slip in space at once, in d"):
        mq.simulate(make_standing_box(0.3, 3.2, TRIPOD), q={"free_z": 0.1}, duration=0.1)


@pytest.mark.slow
@pytest.mark.parametrize("feet", [CORNERS, TRIPOD], ids=["corners", "tripod"])
def test_a_box_slides_straight_until_it_stops(feet: tuple[tuple[float, float], ...]) -> None:
    """Next to its end errors of steps were a rate of 10⁻³ rad/s, and four feet did not stop."""
    start = {"q": {"free_z": 0.1}, "v": {"free_vx": 0.6, "free_vy": 0.8}}
    motion = mq.simulate(make_standing_box(0.3, feet=feet), **start, duration=0.4)  # type: ignore[arg-type]
    assert [{*span.states.values()} for span in motion.modes] == [{"slips"}, {"sticks"}]
    end = 1.0 / (0.3 * G)
    assert motion.modes[1].begin == pytest.approx(end, rel=1e-10)
    times = np.concatenate([np.linspace(0.2, end, 20), [0.4]])
    speeds = np.maximum(1.0 - 0.3 * G * times, 0.0)
    known = np.zeros((len(times), 6))
    known[:, :2] = speeds[:, None] * [0.6, 0.8]
    np.testing.assert_allclose(motion(times).v, known, rtol=0, atol=1e-6)
    way = 1.0 / (2 * 0.3 * G)
    np.testing.assert_allclose(motion.q[-1, :2], [0.6 * way, 0.8 * way], rtol=1e-9, atol=0)


@pytest.mark.slow
def test_a_tripod_spins_as_it_slides_to_a_stop() -> None:
    start = {"q": {"free_z": 0.1}, "v": {"free_vx": 0.6, "free_wz": 2.0}}
    box = make_standing_box(0.3, feet=TRIPOD)
    motion = mq.simulate(box, **start, duration=0.5, rtol=1e-10)  # type: ignore[arg-type]
    end = motion.modes[1].begin
    # up to 1e-4 of its speed
    times = end * (1 - np.geomspace(1, 1e-4, 30))
    options: Any = {"method": "Radau", "rtol": 1e-11, "atol": 1e-13, "t_eval": times[1:]}
    free = partial(slide_on_tripod, pull=0.0)
    known = solve_ivp(free, (0, times[-1]), [0, 0, 0, 0.6, 0, 2.0], **options).y
    q, v = motion(times[1:]).q, motion(times[1:]).v
    angle = 2 * np.arctan2(q[:, 5], q[:, 6])
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    speeds = np.einsum("ijn,nj->ni", turn, v[:, :2])
    states = np.column_stack([q[:, :2], angle, speeds, v[:, 5]])
    np.testing.assert_allclose(states, known.T, rtol=0, atol=1e-7)


@pytest.mark.slow
def test_corners_that_turn_as_they_begin_to_slip_are_refused() -> None:
    box = make_standing_box(0.3, pull=3.2, aside=0.1)
    with pytest.raises(mq.IntegrationError, match=r"2 modes follow at t = 0 s: c0 open, c1 slips"):
        mq.simulate(box, q={"free_z": 0.1}, duration=0.1)
