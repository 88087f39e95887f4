"""Where contacts and cords cease to hold, by hand."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from rolling_samples import bowl, g, r, wheel
from scipy.spatial.transform import Rotation

import mecanique as mq
from mecanique import Mechanism, Placement, Rolling, contact_events, simulate, textbook
from mecanique.motion.analysis.audit import FrictionNeed
from mecanique.motion.switching.holding import Holding
from mecanique.textbook.catalogue import entry

TOP = {"free_z": r.value}
RADIUS, SPEED = 2.0, 0.3
OFF = {"free_vx": SPEED}
PART = 7 * SPEED**2 / (g.value * (RADIUS + r.value))


def dome(friction: float | None = None) -> Mechanism:
    """A ball that rolls down from the top of a dome."""
    mechanism = bowl(-RADIUS)
    (contact,) = mechanism.contacts
    assert isinstance(contact, Rolling)
    return replace(mechanism, contacts=(replace(contact, friction=friction),))


def slope_of(q: np.ndarray) -> float:
    """The angle of the normal with the vertical on the dome."""
    return float(np.arccos((q[2] + RADIUS) / (RADIUS + r.value)))


def test_a_ball_leaves_a_dome_where_theory_says() -> None:
    """A ball that rolls off at v leaves where 17 cos = 10 + 7 v²/(g (R + r)) (Lamb, 1914)."""
    motion = simulate(dome(), q=TOP, v=OFF, duration=2.3, rtol=1e-8)
    (event,) = motion.events
    assert event.name == "inside would pull"
    assert np.cos(slope_of(event.q)) == pytest.approx((10 + PART) / 17, abs=1e-6)
    assert motion.times("inside would pull").tolist() == [event.t]
    assert "event inside would pull: t = " in motion.summary()
    assert not motion.audit()["pull of inside, off"].ok
    stopped = simulate(
        dome(),
        q=TOP,
        v=OFF,
        duration=2.3,
        rtol=1e-8,
        events=contact_events(dome(), stop=True),
    )
    assert stopped.t[-1] == pytest.approx(event.t, abs=1e-7)
    assert [each.name for each in stopped.events] == ["inside would pull"]


def test_a_ball_slips_before_it_leaves() -> None:
    """Friction is 2 m g sin/7, the normal force m g (17 cos − 10)/7 less m v²/(R + r)."""
    motion = simulate(dome(0.4), q=TOP, v=OFF, duration=2.3, rtol=1e-8)
    assert [each.name for each in motion.events] == ["inside would slip", "inside would pull"]
    angle = slope_of(motion.events[0].q)
    assert 2 * np.sin(angle) / (17 * np.cos(angle) - 10 - PART) == pytest.approx(0.4, abs=1e-6)


def test_the_friction_that_is_needed() -> None:
    """tan(slope)/3 for a disk."""
    slope = 0.3
    disk = wheel(plane=Placement(rpy=(0, slope, 0)))
    start = {
        "free_x": r.value * np.sin(slope),
        "free_z": r.value * np.cos(slope),
        "free_qy": np.sin(slope / 2),
        "free_qw": np.cos(slope / 2),
    }
    audit = simulate(disk, q=start, duration=0.3, rtol=1e-8).audit()
    (need,) = audit.friction
    assert need.coefficient == pytest.approx(np.tan(slope) / 3, rel=1e-6)
    assert "friction at rim: needs a coefficient of 0.1031" in str(audit)
    assert audit["pull of rim, off"].ok


def test_friction_that_contacts_share_is_undetermined() -> None:
    cart = textbook.load("two_wheeled_cart")
    q = mq.assemble(cart, {"z": 0.3, "pitch": 0.3})
    points = mq.Reference(cart).contact_points(q)
    # both wheels stand on the ground, to the left and to the right of the axle's middle
    assert [points[name][2] for name in points] == pytest.approx([0, 0], abs=1e-12)
    apart = points["left_contact"] - points["right_contact"]
    assert np.linalg.norm(apart) == pytest.approx(2 * cart.values["b"], rel=1e-12)
    forces = Holding(cart).forces(np.zeros(1), q[None], np.zeros((1, cart.nv)))
    left, right = (forces[f"{side}_contact: normal"] for side in ("left", "right"))
    assert left == pytest.approx(right, rel=1e-12)
    for side in ("left", "right"):
        friction = np.hypot(forces[f"{side}_contact: x"], forces[f"{side}_contact: y"])
        assert np.isnan(friction).all()
    need = FrictionNeed("left_contact", float("nan"), float("nan"))
    assert str(need) == "friction at left_contact: undetermined, other contacts share it"


def test_a_cord_that_would_push_is_an_event() -> None:
    """The weight follows its cord while the push is less than its weight less m2 a."""
    machine = textbook.load("atwood_machine")
    rising = mq.Force("push", "weight2", (0, 0, 0), (0, 0, 50.0 * mq.time()))
    pushed = replace(machine, forces=(rising,))
    motion = simulate(pushed, q={"x": -0.5}, duration=0.5, rtol=1e-9)
    named = {each.name: each for each in motion.events}
    s = machine.values
    inertia = s["m1"] + s["m2"] + s["M"] / 2
    # T2 = m2 (g + a) − P = 0 with a = ((m1 − m2) g + P)/inertia
    a = (s["m1"] - s["m2"]) * s["g"] / inertia
    expected = s["m2"] * (s["g"] + a) / (1 - s["m2"] / inertia) / 50.0
    assert named["cord_2 would push"].t == pytest.approx(expected, rel=1e-6)


def test_what_is_amiss_at_the_start_is_told() -> None:
    mechanism = bowl(RADIUS)
    lifted = replace(mechanism, gravity=(0.0, 0.0, float(g.value)))
    motion = simulate(lifted, q=TOP, duration=0.1)
    assert [(each.name, each.t) for each in motion.events] == [("inside would pull", 0.0)]


def test_a_coefficient_below_zero_is_refused() -> None:
    with pytest.raises(mq.MechanismError, match=r"friction of at least 0, got -0\.1"):
        dome(-0.1)


def test_a_disk_that_slides_hold_upright_slips_at_once_where_friction_is_too_low() -> None:
    """It needs tan(alpha) / 3 (Goldstein, sect. 2.4); what is lateral the slides hold."""
    disk = textbook.load("rolling_disk")
    needed = math.tan(disk.values["alpha"]) / 3
    (contact,) = disk.contacts
    assert isinstance(contact, Rolling)
    slippery = replace(disk, contacts=(replace(contact, friction=needed / 2),))
    motion = simulate(slippery, duration=1.0)
    assert [(event.name, event.t) for event in motion.events] == [("contact would slip", 0.0)]
    (need,) = motion.audit().friction
    assert need.coefficient == pytest.approx(needed, rel=1e-9)
    stopped = simulate(slippery, duration=1.0, events=contact_events(slippery, stop=True))
    assert stopped.t.tolist() == [0.0]
    assert stopped.times("contact would slip").tolist() == [0.0]
    rough = replace(disk, contacts=(replace(contact, friction=2 * needed),))
    assert not simulate(rough, duration=1.0).events


def test_a_brake_in_the_axle_adds_to_the_friction_that_a_disk_needs() -> None:
    """Of a couple c against the spin: tan(alpha)/3 + 2 c/(3 r m g cos(alpha))."""
    disk = textbook.load("rolling_disk")
    s, couple = disk.values, 0.5
    weight = s["m"] * s["g"] * math.cos(s["alpha"])
    needed = math.tan(s["alpha"]) / 3 + 2 * couple / (3 * s["R"] * weight)
    axle = next(joint.name for joint in disk.joints if isinstance(joint, mq.Revolute))
    brake = mq.Friction("brake", axle, 1.0, couple)
    (contact,) = disk.contacts
    assert isinstance(contact, Rolling)
    for part, events in ((0.999, ["contact would slip"]), (1.001, [])):
        rough = replace(contact, friction=part * needed)
        braked = replace(disk, contacts=(rough,), switching=(brake,))
        motion = simulate(braked, v={"turn": 2.0 / s["R"]}, duration=0.02)
        assert [event.name for event in motion.events] == events
        assert motion.audit().friction[0].coefficient == pytest.approx(needed, rel=1e-9)


@pytest.mark.parametrize("samples", [3, 10, 100])
def test_the_friction_needed_is_that_of_the_motion_not_of_its_samples(samples: int) -> None:
    coin, system = textbook.load("rolling_coin"), entry("rolling_coin")
    motion, dense = (
        simulate(coin, q=system.start, v=system.start_velocity, duration=3, samples=n)
        for n in (samples, 10_001)
    )
    (need,) = motion.audit().friction
    normal, *friction = Holding(coin).forces(dense.t, dense.q, dense.v).values()
    ratio = np.linalg.norm(friction, axis=0) / normal
    assert need.coefficient == pytest.approx(ratio.max(), rel=1e-7)


def test_a_wheel_far_from_its_plane_is_carried_to_it_and_not_laid_flat() -> None:
    """Turned as easily as carried, this wheel came to lie flat, where no Newton's step closes."""
    plane = Placement((-0.82215, 0.70329, 0.89254), (1.02656, 2.65253, -2.17706))
    contact = Rolling("c", "body", 0.0556848, plane=plane)
    thin = mq.disk(1.0, 0.0556848).at(rpy=(math.pi / 2, 0.0, 0.0))
    free = Mechanism(
        "wheel",
        (mq.Body("ground"), mq.Body("body", thin)),
        (mq.Floating("free", "ground", "body"),),
        contacts=(contact,),
    )
    q = mq.assemble(free)
    normal = Rotation.from_euler("xyz", plane.rpy).apply([0.0, 0.0, 1.0])
    axle = Rotation.from_quat(q[3:]).apply([0.0, 1.0, 0.0])
    lean = np.linalg.norm(np.cross(normal, axle))
    assert lean > 0.3
    height = normal @ (q[:3] - np.array(plane.xyz))
    assert height == pytest.approx(contact.radius * lean, rel=1e-9, abs=0)
