"""Mechanisms with corners whose motion is known by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.optimize import brentq

import mecanique as mq

G = 9.81


def slide(name: str, parent: str, child: str, axis: str, coordinate: str) -> mq.Prismatic:
    """Return a slide along x or z."""
    along = {"x": (1, 0, 0), "z": (0, 0, 1), "down": (0, 0, -1)}[axis]
    return mq.Prismatic(name, parent, child, axis=along, coordinate=coordinate)


def planar(shape: mq.Shape, *switching: mq.Contact, **fields: object) -> mq.Mechanism:
    """Return a body that moves in the plane x, z and turns by th about −y."""
    joint = mq.Planar("plane", "ground", "body", axis=(0, -1, 0), names=("x", "z", "th"))
    bodies = (mq.Body("ground"), mq.Body("body", shape))
    return mq.Mechanism("planar", bodies, (joint,), switching=switching, **fields)  # type: ignore[arg-type]


def test_a_block_goes_to_and_fro_between_walls_until_friction_stops_it() -> None:
    width, speed, e, mu = 0.5, 3.0, 0.8, 0.1
    bodies = mq.Body("ground"), mq.Body("block", mq.box(1.0, (0.1, 0.1, 0.1)))
    walls = (
        mq.Stop("right", "s", at=width, restitution=e),
        mq.Stop("left", "s", side=-1, restitution=e),
        mq.Friction("dry", "s", mu, G),
    )
    joints = (slide("s", "ground", "block", "x", "x"),)
    block = mq.Mechanism("block", bodies, joints, switching=walls)
    motion = mq.simulate(block, v={"x": speed}, duration=4.0)
    t, place, way = 0.0, 0.0, 1
    while (square := speed**2 - 2 * mu * G * width) > 0:
        t += (speed - math.sqrt(square)) / (mu * G)
        place, way, speed = (width if way > 0 else 0.0), -way, e * math.sqrt(square)
    assert motion.modes[-1].states["dry"] == "sticks"
    np.testing.assert_allclose(motion.modes[-1].begin, t + speed / (mu * G), rtol=1e-13, atol=0)
    place += way * speed**2 / (2 * mu * G)
    np.testing.assert_allclose(motion["x"][-1], place, rtol=1e-11, atol=0)


def test_a_chain_of_three_blocks_begins_to_slide_one_by_one() -> None:
    """The second when the spring is stretched by mu m g/k: x = (c/k) (t − sin(ω t)/ω)."""
    m, k, rate, mu = 1.0, 50.0, 4.0, 0.2
    pull = mq.Input("F", lambda t: rate * t, "N")
    bodies = [mq.Body("ground"), *(mq.Body(f"b{i}", mq.box(m, (0.1,) * 3)) for i in (1, 2, 3))]
    joints = [slide(f"s{i}", "ground", f"b{i}", "x", f"x{i}") for i in (1, 2, 3)]
    x1, x2, x3 = (mq.coordinate(f"x{i}") for i in (1, 2, 3))
    springs = mq.Potential("V", ("s1", "s2", "s3"), k * ((x1 - x2) ** 2 + (x2 - x3) ** 2) / 2)
    chain = mq.Mechanism(
        "chain",
        tuple(bodies),
        tuple(joints),
        forces=(mq.JointForce("pull", "s1", pull), springs),
        switching=tuple(mq.Friction(f"f{i}", f"s{i}", mu, m * G) for i in (1, 2, 3)),
        inputs=(pull,),
    )
    motion = mq.simulate(chain, duration=1.2)
    first, omega = mu * m * G / rate, math.sqrt(k / m)

    def stretch(t: float) -> float:
        return rate / k * (t - math.sin(omega * t) / omega) - mu * m * G / k

    second = first + float(brentq(stretch, 0.01, 3.0, xtol=1e-14))
    times = {event.name: event.t for event in motion.events}
    np.testing.assert_allclose(times["f1: slips +"], first, rtol=0, atol=1e-12)
    np.testing.assert_allclose(times["f2: slips +"], second, rtol=0, atol=1e-10)


@pytest.mark.parametrize("mu", [1.2, 1.6])
@pytest.mark.parametrize("turning", [0.0, 6.0])
@pytest.mark.parametrize("way", [1.0, -1.0])
@pytest.mark.parametrize("side", [1, -1])
def test_solutions_of_painleves_rod_are_counted(
    mu: float, turning: float, way: float, side: int
) -> None:
    """The tip's acceleration is free + yields N, and N (free + yields N) = 0 with both positive."""
    rod = planar(mq.rod(1.0, 1.0), mq.Contact("tip", "body", mu=mu))
    th = side * (math.pi / 2 + math.atan(2.0))
    x, z = -0.5 * math.sin(th), 0.5 * math.cos(th)  # of the tip from the center
    yields = 1 + 12 * (x + way * mu * z) * x
    free = -G - turning**2 * z
    count = int(free >= 0) + int(-free / yields > 0)
    start = {"q": {"th": th}, "v": {"x": way, "th": turning}, "duration": 1e-3}
    if count == 1:
        first = mq.simulate(rod, **start).modes[0].states["tip"]  # type: ignore[arg-type]
        assert (first == "open") == (free >= 0)
        return
    with pytest.raises(mq.IntegrationError, match="no mode follows" if not count else "2 modes"):
        mq.simulate(rod, **start)  # type: ignore[arg-type]


def test_a_particle_leaves_a_dome_that_slides_away() -> None:
    """Where cos³ m/(M + m) − 3 cos + 2 cos₀ = 0 of its angle to the vertical."""
    M, m, begun = 3.0, 1.0, 0.05
    bodies = (
        mq.Body("ground"),
        mq.Body("dome", mq.box(M, (0.1, 0.1, 0.1))),
        mq.Body("carriage", mq.massless()),
        mq.Body("p", mq.particle(m)),
    )
    joints = (
        slide("d", "ground", "dome", "x", "X"),
        slide("sx", "ground", "carriage", "x", "x"),
        slide("sz", "carriage", "p", "z", "z"),
    )
    top = mq.Contact("top", "p", on="dome", bowl=-1.0, plane=mq.Placement((0, 0, 1.0)))
    dome = mq.Mechanism("dome", bodies, joints, switching=(top,))
    motion = mq.simulate(dome, q={"x": math.sin(begun), "z": math.cos(begun)}, duration=2.0)
    c = float(motion(motion.times("top: open")[0]).q[2])
    np.testing.assert_allclose(m / (M + m) * c**3 + 2 * math.cos(begun), 3 * c, rtol=1e-11, atol=0)


@pytest.mark.parametrize("mu", [0.05, 1.0])
def test_a_spinning_disk_leaves_a_rough_wall(mu: float) -> None:
    """The slip takes an impulse of a third of m slip to end; friction has mu m (1 + e) v."""
    r, v, up, spin, e = 0.2, 2.0, 1.0, 4.0, 0.5
    wall = mq.Placement((0, 0, 0), (0, math.pi / 2, 0))
    contact = mq.Contact("wall", "body", radius=r, axis=(0, 1, 0), plane=wall, mu=mu, restitution=e)
    disk = planar(mq.disk(1.0, r).at(rpy=(math.pi / 2, 0, 0)), contact, gravity=(0, 0, 0))
    motion = mq.simulate(disk, q={"x": 1.0}, v={"x": -v, "z": up, "th": spin}, duration=1.0)
    slip = up - r * spin
    impulse = -min(slip / 3, mu * (1 + e) * v)
    after = [e * v, up + impulse, spin - 2 * impulse / r]
    np.testing.assert_allclose(motion.v[-1], after, rtol=1e-13, atol=0)


def test_a_cord_on_a_drum_slips_one_way_and_then_the_other() -> None:
    """T₁ to T₂ as 1 to e^(mu φ) while the heavy weight rises, the reverse as it falls."""
    m1, m2, mu, speed = 3.0, 1.0, 0.2, 2.0
    bodies = mq.Body("ground"), mq.Body("a", mq.particle(m1)), mq.Body("b", mq.particle(m2))
    joints = slide("s1", "ground", "a", "down", "l1"), slide("s2", "ground", "b", "down", "l2")
    drum = mq.Capstan("drum", "s1", "s2", length=2.0, wrap=math.pi, mu=mu)
    cord = mq.Mechanism("cord", bodies, joints, switching=(drum,))
    start = {"l1": -speed, "l2": speed}
    motion = mq.simulate(cord, q={"l1": 1.0, "l2": 1.0}, v=start, duration=1.0)
    ratio = math.exp(mu * math.pi)
    rising = G * (ratio * m1 - m2) / (ratio * m1 + m2)
    falling = G * (m1 - ratio * m2) / (m1 + ratio * m2)
    turns = speed / rising
    np.testing.assert_allclose(motion.modes[0].end, turns, rtol=1e-13, atol=0)
    np.testing.assert_allclose(motion.v[-1, 0], falling * (1 - turns), rtol=1e-12, atol=0)


def test_a_slack_cord_is_taut_again_after_four_v_cos_over_g() -> None:
    bodies = mq.Body("ground"), mq.Body("carriage", mq.massless()), mq.Body("p", mq.particle(1.0))
    joints = slide("sx", "ground", "carriage", "x", "x"), slide("sz", "carriage", "p", "z", "z")
    cord = mq.Contact("cord", "p", bowl=1.0, plane=mq.Placement((0, 0, -1.0)))
    particle = mq.Mechanism("particle", bodies, joints, switching=(cord,))
    motion = mq.simulate(particle, q={"z": -1.0}, v={"x": math.sqrt(3.5 * G)}, duration=1.5)
    slack, taut = motion.times("cord: open")[0], motion.times("cord: impact")[0]
    np.testing.assert_allclose(motion(slack).q[1], 0.5, rtol=1e-11, atol=0)
    flight = 4 * math.sqrt(0.5 * G) * math.cos(math.pi / 6) / G
    np.testing.assert_allclose(taut - slack, flight, rtol=1e-11, atol=0)


@pytest.mark.parametrize(("height", "slides"), [(0.9, False), (0.2, True)])
def test_a_pushed_box_tips_or_slides(height: float, slides: bool) -> None:
    """At F y = m g b/2, or at F = mu m g, whichever comes first."""
    b, h, m, mu, rate = 0.4, 1.0, 2.0, 0.6, 3.0
    push = mq.Input("F", lambda t: rate * t, "N")
    corners = [
        mq.Contact(name, "body", (x, 0, -h / 2), mu=mu) for name, x in (("l", -b / 2), ("r", b / 2))
    ]
    force = mq.Force("push", "body", (0, 0, height - h / 2), (push, 0, 0))
    box = planar(mq.box(m, (b, b, h)), *corners, forces=(force,), inputs=(push,))
    motion = mq.simulate(box, q={"z": h / 2}, duration=4.0 if slides else 1.6)
    most = mu * m * G if slides else m * G * b / 2 / height
    np.testing.assert_allclose(motion.modes[0].end, most / rate, rtol=1e-11, atol=0)
    tipped = {"l": "open", "r": "sticks"}
    assert motion.modes[1].states == ({"l": "slips +", "r": "slips +"} if slides else tipped)
