"""The ground on the turning earth: closed forms of free fall and of Foucault's pendulum."""

from __future__ import annotations

from typing import Literal

import numpy as np
import pytest

import mecanique as mq
from mecanique.motion.inertial import EARTH_RATE, on_turning_earth

LATITUDE = np.radians(48.0)
G = 9.81


def fallen(
    facing: Literal["south", "east", "north", "west"], rate: float = EARTH_RATE
) -> np.ndarray:
    stone = mq.textbook.load("free_particle")
    check = mq.inertial_check(
        stone, mq.simulate(stone, duration=5.0), LATITUDE, facing=facing, rate=rate, tolerance=1e-3
    )
    end: np.ndarray = check.turning.q[-1]
    return end


def exact_fall(t: float, rate: float) -> np.ndarray:
    """Free fall (south, east, up): r'' = g integrated in axes at rest; g turns with the ground."""
    axis = np.array([-np.cos(LATITUDE), 0.0, np.sin(LATITUDE)])
    along = axis * (axis @ [0, 0, -G])
    across, side = np.array([0, 0, -G]) - along, np.cross(axis, [0, 0, -G])
    w = rate * t
    # in axes at rest g is along + across cos Ωt + side sin Ωt; integrated twice from rest on the
    # axis
    r = along * t**2 / 2 + (across * (1 - np.cos(w)) + side * (w - np.sin(w))) / rate**2
    turned: np.ndarray = (
        axis * (axis @ r) + (r - axis * (axis @ r)) * np.cos(w) - np.cross(axis, r) * np.sin(w)
    )
    return turned


def test_a_stone_falls_to_the_east() -> None:
    south, east, _ = fallen("south")
    assert east == pytest.approx(EARTH_RATE * np.cos(LATITUDE) * G * 5.0**3 / 3, rel=1e-6)
    assert 0 < south < 1e-3 * east


def test_the_fall_is_exact_at_any_rate() -> None:
    for rate in (0.1, 0.5):
        np.testing.assert_allclose(fallen("south", rate), exact_fall(5.0, rate), rtol=1e-9, atol=0)


def test_the_axes_may_face_anywhere() -> None:
    south, east, up = fallen("south", 0.2)
    np.testing.assert_allclose(fallen("east", 0.2), [east, -south, up], rtol=1e-9, atol=0)
    np.testing.assert_allclose(fallen("north", 0.2), [-south, -east, up], rtol=1e-9, atol=0)
    np.testing.assert_allclose(fallen("west", 0.2), [-east, south, up], rtol=1e-9, atol=0)


def foucault(length: float) -> mq.Mechanism:
    return mq.Mechanism(
        "bob_on_a_wire",
        (mq.Body("ground"), mq.Body("bob", mq.particle(28.0, (0, 0, -length)))),
        (mq.Universal("hook", "ground", "bob", names=("alpha", "beta")),),
        gravity=(0, 0, -G),
    )


@pytest.mark.parametrize("latitude", [48.85, -30.0])
def test_the_plane_of_swing_turns_at_the_rate_of_foucault(latitude: float) -> None:
    mechanism = foucault(20.0)
    motion = mq.simulate(mechanism, q={"beta": -0.01}, duration=60.0, fps=20)
    check = mq.inertial_check(mechanism, motion, np.radians(latitude))
    alpha, beta = check.turning.q.T
    x, y = -np.sin(beta), np.sin(alpha) * np.cos(beta)
    # at the sixth return to the side of the start, clockwise from above in the north
    period = 2 * np.pi * np.sqrt(20.0 / G)
    at = 6 * period
    last = check.turning(at).q
    angle = np.arctan2(np.sin(last[0]) * np.cos(last[1]), -np.sin(last[1]))
    assert angle == pytest.approx(-EARTH_RATE * np.sin(np.radians(latitude)) * at, rel=1e-3)
    assert np.hypot(x, y).max() < 0.0101
    assert check["alpha"].size == 0.0
    assert check["alpha"].change == pytest.approx(0.01 * abs(angle), rel=0.3)
    assert check["period of beta"].relative < 1e-7


def test_the_table_tells_what_changes_and_what_g_contains() -> None:
    pendulum = mq.textbook.load("rigid_bar_pendulum")
    check = mq.inertial_check(pendulum, mq.simulate(pendulum, q=[1.0], duration=4.0), LATITUDE)
    assert check.inertial
    assert check.worst.relative > 0
    text = str(check)
    assert "latitude 48°, x south, z up, over 4 s" in text
    assert "The ground may be taken as inertial within 0.001" in text
    assert "g contains the centrifugal acceleration" in text
    # the pin's reaction against the Coriolis force, m l/2 Ω sin(latitude) … stays below that of the
    # largest speed
    speed = float(np.abs(check.still["q'"]).max())
    assert 0 < check["force in pin"].change < 2 * EARTH_RATE * speed * 0.5 * 1.0 + 1e-9
    with pytest.raises(mq.UnknownNameError, match="unknown row 'p'"):
        check["p"]
    fast = mq.inertial_check(pendulum, check.still, LATITUDE, rate=0.5)
    assert not fast.inertial
    assert "may not be taken as inertial" in str(fast)


def test_world_forces_springs_and_loops_keep_their_place_on_the_ground() -> None:
    pushed = mq.Mechanism(
        "pushed",
        (mq.Body("world"), mq.Body("block", mq.particle(2.0))),
        (mq.Prismatic("slide", "world", "block", axis=(1, 0, 0), coordinate="x"),),
        forces=(
            mq.Force("push", "block", (0, 0, 0), (3.0, 0, 0)),
            mq.JointSpring("s", "slide", 8.0),
        ),
        ground="world",
    )
    turned = on_turning_earth(pushed, 0.4, rate=0.3)
    # a slide along x (south) at the centrifugal rate: m x'' = 3 − 8 x + m Ω² sin²(latitude) x
    found = mq.Reference(turned).acceleration({"x": 0.7}, t=2.0)
    assert found[0] == pytest.approx((3 - 8 * 0.7) / 2 + (0.3 * np.sin(0.4)) ** 2 * 0.7, rel=1e-12)
    assert mq.verify(turned, samples=10).agrees


def test_what_is_no_latitude_is_refused() -> None:
    stone = mq.textbook.load("free_particle")
    motion = mq.simulate(stone, duration=1.0)
    with pytest.raises(
        mq.InputError, match=r"expected a latitude within ±π/2 rad, got 48; of degrees"
    ):
        mq.inertial_check(stone, motion, 48.0)
    with pytest.raises(
        mq.InputError, match="expected facing among south, east, north, west, got 'up'"
    ):
        on_turning_earth(stone, 0.1, facing="up")  # type: ignore[arg-type]  # what is refused
    with pytest.raises(mq.InputError, match="expected a positive tolerance, got 0"):
        mq.inertial_check(stone, motion, 0.1, tolerance=0.0)
    with pytest.raises(mq.InputError, match="expected a motion of 'two_blocks'"):
        mq.inertial_check(mq.textbook.load("two_blocks"), motion, 0.1)
    with pytest.raises(mq.InputError, match="expected a motion of 'free_particle'"):
        mq.inertial_check(stone.replace(m=7.0), motion, 0.1)


@pytest.mark.parametrize("latitude", [0.0, 0.7, -1.2])
def test_the_deflection_is_that_of_coriolis_at_any_latitude(latitude: float) -> None:
    """g Ω cos(φ) t³/3 to first order in Ω (Coriolis 1835; Goldstein, sect. 4-10)."""
    stone = mq.textbook.load("free_particle")
    check = mq.inertial_check(
        stone, mq.simulate(stone, q={"z": 20.0}, duration=2.0), latitude, facing="east"
    )
    east = check.turning["x"][-1]
    assert east == pytest.approx(G * EARTH_RATE * np.cos(latitude) * 8 / 3, rel=1e-6)
    assert check["x"].change == pytest.approx(east, rel=1e-12)
    assert check["x"].relative == np.inf
    assert " inf " not in str(check), "the table compares with what has the same unit"


def test_without_rotation_nothing_changes() -> None:
    mechanism = mq.textbook.load("double_pendulum")
    still = on_turning_earth(mechanism, 0.5, rate=0.0)
    q, v = [0.3, -0.8], [1.0, -2.0]
    expected = mq.Reference(mechanism).acceleration(q, v)
    np.testing.assert_allclose(
        mq.Reference(still).acceleration(q, v, 3.0), expected, rtol=1e-12, atol=0
    )


def test_the_period_without_rotation_is_the_elliptic_integral() -> None:
    from scipy.special import ellipk

    pendulum = mq.textbook.load("rigid_bar_pendulum")
    check = mq.inertial_check(pendulum, mq.simulate(pendulum, q=[1.0], duration=6.0), 0.7)
    period = check["period of q"]
    assert period.size == pytest.approx(
        4 * np.sqrt(2 / (3 * G)) * ellipk(np.sin(0.5) ** 2), rel=1e-9
    )
    assert period.relative < 1e-9
    # across the plane the pin bears the Coriolis force
    assert 1e-5 < check["force in pin"].change < 1e-3


def test_a_force_from_nothing_counts_relative_to_those_that_act() -> None:
    orbit = mq.textbook.load("kepler_orbit")
    motion = mq.simulate(orbit, q={"r": 1.0}, v={"phi'": 3.0}, duration=5.0)
    check = mq.inertial_check(orbit, motion, LATITUDE)
    # attraction alone moves the planet: its hinges carry nothing on ground at rest
    assert check["force in phi"].size < 1e-12
    mu, m = (orbit.values[name] for name in ("mu", "m"))
    assert check.force == pytest.approx(m * mu / motion["r"].min() ** 2, rel=1e-6)
    assert check.worst.name in ("r", "phi")
    row = next(line for line in str(check).splitlines() if line.startswith("force in phi"))
    assert row.split()[3:5] == ["0", "N"]
    assert float(row.split()[7]) < 1e-4


@pytest.mark.parametrize("joint", [mq.Floating, mq.Planar])
def test_a_body_that_does_not_turn_is_compared_with_a_radian(
    joint: type[mq.Floating | mq.Planar],
) -> None:
    """It turns with the ground from the start, so relative to the ground it only rounds."""
    pair = mq.Body("ground"), mq.Body("ball", mq.ball(1.0, 0.1))
    upright = mq.Placement(rpy=(np.pi / 2, 0, 0))
    mechanism = mq.Mechanism("drop", pair, (joint("free", "ground", "ball", origin=upright),))
    check = mq.inertial_check(mechanism, mq.simulate(mechanism, duration=2.0), LATITUDE)
    turns = [row for row in check.rows if row.unit in ("rad", "1")]
    assert turns
    assert all(row.size < 1e-12 and row.change < 1e-12 for row in turns)
    assert check.inertial
    assert check.worst not in turns
    assert "inf" not in [word for line in str(check).splitlines() for word in line.split()]
