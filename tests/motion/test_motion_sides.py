"""Motions off the ends of sides, of tables and blocks, against closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest
from sides import TABLE, make_ball, make_block, make_rack, make_sled, move_in_plane

import mecanique as mq
from mecanique.motion.motion import Motion

G = 9.81


def happened(motion: Motion) -> list[str]:
    """Return the names of what happened."""
    return [event.name for event in motion.events]


def test_a_sled_falls_when_its_end_passes_the_edge() -> None:
    """The table's edge takes over from the front corner, and gives nothing beyond the rear end."""
    motion = mq.simulate(make_sled(0.4), q={"x": -0.5}, v={"x": 2.0}, duration=0.8, rtol=1e-12)
    assert happened(motion) == ["front: open", "lip: closed", "lip: open"]
    times = [event.t for event in motion.events]
    np.testing.assert_allclose(times, [0.15, 0.15, 0.35], rtol=0, atol=1e-12)
    np.testing.assert_allclose(motion["z"][-1], -G / 2 * 0.45**2, rtol=0, atol=1e-12)
    assert motion.audit().ok


@pytest.mark.parametrize(("mu", "slip"), [(0.0, ""), (0.1, "slips -")])
def test_a_block_tips_over_an_edge(mu: float, slip: str) -> None:
    """Without friction where its center passes the edge, with it μ h/2 before."""
    width, height, v = 0.4, 0.2, 2.0
    motion = mq.simulate(
        make_block(width, height, mu),
        q={"x": -0.5, "z": height / 2},
        v={"x": v},
        duration=0.6,
        rtol=1e-12,
    )
    closed = slip or "closed"
    assert happened(motion) == ["front: open", f"lip: {closed}", "rear: open", "lip: open"]
    front, _, tips, leaves = motion.events
    np.testing.assert_allclose(front.q[0], -width / 2, rtol=0, atol=1e-12)
    np.testing.assert_allclose(tips.q, [-mu * height / 2, height / 2, 0.0], rtol=0, atol=1e-12)
    slowed = math.sqrt(v**2 - 2 * mu * G * (0.5 + tips.q[0]))
    np.testing.assert_allclose(tips.v, [slowed, 0.0, 0.0], rtol=0, atol=1e-12)
    # the corner of the block leaves that of the table
    x, z, th = leaves.q
    corner = np.array([x, z])
    corner -= width / 2 * np.array([math.cos(th), math.sin(th)])
    corner += height / 2 * np.array([math.sin(th), -math.cos(th)])
    np.testing.assert_allclose(corner, 0.0, rtol=0, atol=1e-11)
    assert motion.audit().ok


@pytest.mark.parametrize(
    ("mu", "cosine", "by_speed"), [(0.0, 2 / 3, 1 / 3), (1e6, 10 / 17, 7 / 17)]
)
def test_a_ball_leaves_an_edge(mu: float, cosine: float, by_speed: float) -> None:
    """It slides, or rolls, about the edge till nothing presses: cos θ = 2/3, or 10/17."""
    r, v = 0.1, 0.01
    spin = {"th": -v / r} if mu else {}
    motion = mq.simulate(
        make_ball(r, mu), q={"x": -0.005, "z": r}, v={"x": v} | spin, duration=2.0, rtol=1e-12
    )
    top, edge = motion.events[:2]
    assert (top.name, edge.name) == ("top: open", f"edge: {'sticks' if mu else 'closed'}")
    np.testing.assert_allclose([top.t, top.q[0]], [0.5, 0.0], rtol=0, atol=1e-10)
    leaves = next(event for event in motion.events if event.name == "edge: open")
    # energy: v² of the start counts beside g r (1 − cos θ)
    expected = cosine + by_speed * v**2 / (G * r)
    np.testing.assert_allclose(leaves.q[1] / r, expected, rtol=0, atol=1e-4 if mu else 1e-9)
    assert motion.audit().ok


def test_a_ball_that_turns_back_about_the_edge_rolls_on_the_table_as_it_came() -> None:
    r, v = 0.1, 0.1
    ball = mq.simulate(
        make_ball(r, 1.0).replace(gravity=(-4.0, 0, -G)),
        q={"x": -0.001, "z": r},
        v={"x": v, "th": -v / r},
        duration=1.0,
        rtol=1e-12,
    )
    assert [span.states for span in ball.modes] == [
        {"top": "sticks", "edge": "open"},
        {"top": "open", "edge": "sticks"},
        {"top": "sticks", "edge": "open"},
    ]
    back = ball.modes[-1].begin
    leaves = ball(ball.modes[0].end)
    # its gap, which falls from zero by the square of the way, is seen once it is not rounding
    np.testing.assert_allclose(ball(back).v[0], -leaves.v[0], rtol=0, atol=1e-6)
    # on the table 7/5 x'' = −4
    later = 1.0 - back
    expected = leaves.v[0] * -later - 4.0 * 5 / 7 * later**2 / 2
    np.testing.assert_allclose(ball["x"][-1], expected, rtol=0, atol=1e-6)


def test_beyond_an_end_nothing_is_touched() -> None:
    point = move_in_plane(mq.ball(1.0, 0.1), *make_ball(0.1, 0.0).switching[:1])
    motion = mq.simulate(point, q={"x": 0.01, "z": 0.5}, duration=1.0)
    assert motion.events == ()
    np.testing.assert_allclose(motion["z"][-1], 0.5 - G / 2, rtol=1e-12, atol=0)
    lands = mq.simulate(point, q={"x": -0.01, "z": 0.5}, duration=1.0)
    assert happened(lands) == ["top: impact", "top: closed"]


def test_what_comes_in_below_a_side_is_refused() -> None:
    point = move_in_plane(mq.ball(1.0, 0.1), *make_ball(0.1, 0.0).switching[:1])
    start = {"x": 0.1, "z": -0.5}
    with pytest.raises(mq.IntegrationError, match="'top' comes in from beyond an end of its side"):
        mq.simulate(point, q=start, v={"x": -1.0}, duration=0.3)


def test_a_block_tips_over_the_edge_of_a_block() -> None:
    """Both move; the upper one tips as its center passes the edge of the lower."""
    b, h, v = 0.4, 0.2, 2.0
    top, below = mq.Placement((0, 0, h / 2)), mq.Placement((0, 0, -h / 2), (math.pi, 0, 0))
    blocks = mq.Mechanism(
        "blocks",
        (
            mq.Body("ground"),
            mq.Body("lower", mq.box(2.0, (1.0, b, h))),
            mq.Body("upper", mq.box(1.0, (b, b, h))),
        ),
        (
            mq.Prismatic("slide", "ground", "lower", axis=(1, 0, 0), coordinate="s"),
            mq.Planar("plane", "ground", "upper", axis=(0, -1, 0), names=("x", "z", "th")),
        ),
        switching=(
            mq.Contact("rear", "upper", (-b / 2, 0, -h / 2), on="lower", plane=top, length=1.0),
            mq.Contact("front", "upper", (b / 2, 0, -h / 2), on="lower", plane=top, length=1.0),
            mq.Contact("edge", "lower", (0.5, 0, h / 2), on="upper", plane=below, length=b),
        ),
    )
    motion = mq.simulate(blocks, q={"z": h}, v={"x": v, "s": -0.5}, duration=0.4, rtol=1e-12)
    assert happened(motion)[:3] == ["front: open", "edge: closed", "rear: open"]
    front, _, tips = motion.events[:3]
    np.testing.assert_allclose([front.t, tips.t], [0.3 / 2.5, 0.5 / 2.5], rtol=0, atol=1e-12)
    np.testing.assert_allclose(tips.q[1] - tips.q[0], 0.5, rtol=0, atol=1e-12)
    momentum = 2.0 * motion["s'"] + 1.0 * motion["x'"]
    np.testing.assert_allclose(momentum, 2.0 * -0.5 + v, rtol=0, atol=1e-12)
    assert motion["s'"][-1] < -0.501  # the upper one pushes the edge away as it tips
    assert motion.audit().ok


def test_a_side_with_ends_is_one_of_a_plane() -> None:
    with pytest.raises(mq.InputError, match="expected a length of a plane's side, not of a bowl"):
        mq.Contact("in", "ball", radius=0.1, bowl=1.0, length=TABLE)
    with pytest.raises(mq.MechanismError, match="contact 'top': expected a length of at least 0"):
        move_in_plane(mq.ball(1.0, 0.1), mq.Contact("top", "body", radius=0.1, length=-1.0))


def test_a_motion_is_drawn_with_its_table_not_with_forces_that_may_be_none() -> None:
    block = make_block(0.4, 0.2, 0.3)
    motion = mq.simulate(block, q={"x": -0.5, "z": 0.1}, v={"x": 2.0}, duration=0.3)
    drawn, cut = mq.picture(motion, 0.2), mq.picture(motion, 0.1, free_body="body")
    still = mq.picture(block, q=motion(0.2).q.tolist())
    assert isinstance(drawn, mq.Drawing)
    assert isinstance(still, mq.Drawing)
    assert isinstance(cut, mq.Drawing)
    assert drawn.svg == still.svg
    assert "rear" in cut.svg


def test_a_pawl_lets_a_rack_pass_one_way_and_holds_it_the_other() -> None:
    """It climbs a tooth, drops behind it, and holds its face as the load pulls the rack back."""
    load, slope, g = 2.0, 0.2, 9.81
    rack = make_rack(load, slope)
    q, v = {"x": -0.02, "z": 0.02 * slope}, {"x": -0.7, "z": 0.7 * slope}
    motion = mq.simulate(rack, q=q, v=v, duration=1.0, rtol=1e-11)
    back = (load + 0.1 * g * slope) / (1.0 + 0.1 * slope**2)
    slower = math.sqrt(0.49 - 2 * back * 0.08)
    (leaves,) = (event.t for event in motion.events if event.name == "rise 0: open")
    assert leaves == pytest.approx((0.7 - slower) / back, rel=1e-9)
    assert motion.modes[-1].states == {
        "rise 0": "open",
        "face 0": "closed",
        "rise 1": "closed",
        "face 1": "open",
    }
    np.testing.assert_allclose(motion.q[-1], [-0.1, 0.0], rtol=0, atol=1e-13)
    np.testing.assert_allclose(motion.v[-1], 0.0, rtol=0, atol=1e-15)
    held = motion.reactions("face 0").force[-1]
    np.testing.assert_allclose(np.abs(held), [load + 0.1 * g * slope, 0, 0], rtol=1e-12, atol=1e-12)


def make_ratchet() -> mq.Mechanism:
    """Return a wheel of 8 teeth, of which three are there, and a pawl that lies on them."""
    sides = []
    for k in (-1, 0, 1):
        root, apex = (_on_wheel(r, 2 * math.pi * n / 8) for r, n in ((0.8, k), (1.0, k + 1)))
        foot = _on_wheel(0.65, 2 * math.pi * (k + 1) / 8)
        for name, (a, b) in ((f"back{k}", (root, apex)), (f"face{k}", (apex, foot))):
            tilt, middle = (
                math.atan2(a[1] - b[1], b[0] - a[0]),
                ((a[0] + b[0]) / 2, (a[1] + b[1]) / 2),
            )
            plane = mq.Placement((middle[0], 0, middle[1]), (0, tilt, 0))
            length = math.dist(a, b)
            sides.append(
                mq.Contact(name, "pawl", (0, 0, -0.57), on="wheel", plane=plane, length=length)
            )
    wheel = mq.Body("wheel", mq.disk(20.0, 1.0).at(rpy=(math.pi / 2, 0, 0)))
    pin = mq.Placement((0.6, 0, 1.0))
    joints = (
        mq.Revolute("axle", "ground", "wheel", axis=(0, 1, 0), coordinate="w"),
        mq.Revolute("pin", "ground", "pawl", origin=pin, axis=(0, -1, 0), coordinate="p"),
    )
    bodies = (mq.Body("ground"), wheel, mq.Body("pawl", mq.rod(0.5, 0.57)))
    return mq.Mechanism("ratchet", bodies, joints, switching=tuple(sides))


def _on_wheel(radius: float, angle: float) -> tuple[float, float]:
    return radius * math.sin(angle), radius * math.cos(angle)


@pytest.mark.parametrize("speed", [-0.5, -1.0])
def test_a_pawl_drops_over_the_apex_of_a_tooth(speed: float) -> None:
    """There it leaves the back, at the radius of the apex and at its place on the wheel."""
    motion = mq.simulate(make_ratchet(), q={"p": -1.2}, v={"w": speed}, duration=2.0)
    w, p = motion(motion.times("back0: open")[0]).q
    x, z = 0.6 + 0.57 * math.sin(p), 1.0 - 0.57 * math.cos(p)
    np.testing.assert_allclose(math.hypot(x, z), 1.0, rtol=1e-10, atol=0)
    np.testing.assert_allclose(math.atan2(x, z) - w, math.pi / 4, rtol=1e-10, atol=0)


def test_a_pawl_stops_a_wheel_at_the_face_of_a_tooth() -> None:
    motion = mq.simulate(make_ratchet(), q={"p": -1.2}, v={"w": 0.5}, duration=0.5)
    (struck,) = [
        event for event in motion.events if "face-1" in event.name and "impact" in event.name
    ]
    assert struck.v[0] > 0.4
    assert abs(struck.after[0]) < 1e-12
    assert motion["w"].max() < struck.q[0] + 1e-9
