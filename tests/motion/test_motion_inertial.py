"""The turning earth: closed forms of falling bodies and of Foucault's pendulum, and refusals."""

from __future__ import annotations

import math

import numpy as np
import pytest

import mecanique as mq
from mecanique.motion.inertial import EARTH_RATE, on_the_turning_earth


@pytest.mark.parametrize("latitude", [0.0, 0.7, -1.2])
def test_a_falling_particle_is_deflected_to_the_east(latitude: float) -> None:
    """g Ω cos(φ) t³/3 to the first order in Ω (G. G. Coriolis 1835; Goldstein, Classical Mechanics, sect. 4-10)."""
    mechanism = mq.textbook.load("free_particle")
    motion = mq.simulate(mechanism, q={"z": 20.0}, duration=2.0)
    check = mq.inertial_check(mechanism, motion, latitude)
    east = check.motion["x"][-1]
    assert east == pytest.approx(9.81 * EARTH_RATE * math.cos(latitude) * 8 / 3, rel=1e-6)
    assert check.coordinates["x"].largest == pytest.approx(east)
    assert check.coordinates["x"].relative == math.inf
    assert check.worst < 1e-7


def test_the_plane_of_foucaults_pendulum_turns_with_the_sine_of_the_latitude() -> None:
    """Released at rest, w = A e^(-i Omega_z t) (cos wt + i (Omega_z/w) sin wt): it turns by -Omega sin(phi) t."""
    length = mq.Parameter("l", 1.0, "m")
    pendulum = mq.Mechanism(
        "foucault",
        (mq.Body("ground"), mq.Body("bob", mq.particle(1.0, (0, 0, -length)))),
        (mq.Universal("pivot", "ground", "bob"),),
        parameters=(length,),
    )
    latitude, frequency = 0.85, math.sqrt(9.81)
    duration = 4 * math.pi / frequency
    motion = mq.simulate(pendulum, q={"pivot_ry": -0.01}, duration=duration, rtol=1e-12)
    check = mq.inertial_check(pendulum, motion, latitude)
    assert check.coordinates["pivot_rx"].relative == math.inf
    rx, ry = check.motion["pivot_rx"][-1], check.motion["pivot_ry"][-1]
    # small angles: x = -l ry, y = l rx
    assert rx / -ry == pytest.approx(-EARTH_RATE * math.sin(latitude) * duration, rel=1e-3)


def test_a_planar_pendulum_hardly_feels_it_and_its_pin_does() -> None:
    """Across the plane the pin bears the Coriolis force 2 m v Ω sin φ at most; the plane itself is east-west."""
    mechanism = mq.textbook.load("rigid_bar_pendulum")
    motion = mq.simulate(mechanism, q={"q": 1.0}, duration=6.0)
    check = mq.inertial_check(mechanism, motion, 0.7)
    assert check.worst < 1e-8
    without, including = check.periods["q"]
    assert without == pytest.approx(4 * math.sqrt(2 / (3 * 9.81)) * _K(math.sin(0.5)), rel=1e-9)
    assert abs(including / without - 1) < 1e-9
    assert 1e-5 < check.reactions["pin"].largest < 1e-3
    text = str(check)
    assert "latitude 40.11 degrees" in text
    assert "period of" in text


def _K(k: float) -> float:
    from scipy.special import ellipk

    return float(ellipk(k * k))


def test_without_rotation_nothing_changes() -> None:
    mechanism = mq.textbook.load("double_pendulum")
    still = on_the_turning_earth(mechanism, 0.5).replace(Omega_earth=0.0)
    q, v = [0.3, -0.8], [1.0, -2.0]
    expected = mq.Reference(mechanism).acceleration(q, v)
    np.testing.assert_allclose(mq.Reference(still).acceleration(q, v, 3.0), expected, rtol=1e-12)


def test_loads_in_world_axes_turn_with_the_ground() -> None:
    carried = on_the_turning_earth(mq.textbook.load("cart_pole"), 0.5)
    loads = [force for force in carried.forces if isinstance(force, mq.Force)]
    assert loads
    assert {force.axes for force in loads} == {"ground"}


def test_a_latitude_in_degrees_or_another_motion_is_refused() -> None:
    mechanism = mq.textbook.load("rigid_bar_pendulum")
    motion = mq.simulate(mechanism, q={"q": 0.1}, duration=0.1)
    with pytest.raises(mq.InputError, match=r"expected a latitude within -pi/2…pi/2 rad, north positive, got 45\.0"):
        mq.inertial_check(mechanism, motion, 45.0)
    with pytest.raises(mq.InputError, match="expected a motion of 'rigid_bar_pendulum'"):
        mq.inertial_check(mechanism.replace(l=2.0), motion, 0.5)
