"""Steady motions of bodies that turn by quaternions, and matrices as functions of the speed."""

from __future__ import annotations

import numpy as np
import pytest

from mecanique import (
    Body,
    InputError,
    Mechanism,
    Parameter,
    Spherical,
    disk,
    expand_in_speed,
    linearize_steady,
    sweep_speeds,
    textbook,
)

m, r, l, g = (
    Parameter("m", 1.3, "kg"),
    Parameter("r", 0.2, "m"),
    Parameter("l", 0.35, "m"),
    Parameter("g", 9.81, "m/s²"),
)
A = m.value * (r.value**2 / 4 + l.value**2)
C = m.value * r.value**2 / 2
WEIGHT = m.value * g.value * l.value


def top(*, skew: bool = False) -> Mechanism:
    """A disk that stands on a rod without mass; skew, the rod is not its axis."""
    shape = disk(m, r).at((0.1 * l if skew else 0, 0, l))
    return Mechanism(
        "top",
        (Body("ground"), Body("top", shape)),
        (Spherical("tip", "ground", "top"),),
        parameters=(m, r, l, g),
        gravity=(0, 0, -g),
    )


def test_a_sleeping_top_wakes_below_its_limit() -> None:
    """Stable if C² n² > 4 A m g l (Routh, Advanced Rigid Dynamics, 1905, art. 207)."""
    limit = np.sqrt(4 * A * WEIGHT) / C
    fast = linearize_steady(top(), None, {"tip_wz": 1.5 * limit})
    assert fast.stable
    assert fast.positions == ("tip_precession", "tip_nutation", "tip_spin")
    # about axes that do not turn: A λ² ∓ i C n λ − m g l = 0
    n = 1.5 * limit
    roots = [np.roots([A, -side * 1j * C * n, -WEIGHT]) for side in (1, -1)]
    expected = np.sort(np.concatenate(roots).imag)
    np.testing.assert_allclose(
        np.sort(fast.exponents.imag)[[0, 1, -2, -1]], expected, rtol=1e-9, atol=0
    )


@pytest.mark.parametrize("most", [8, 2])
def test_the_limit_of_a_sleeping_top_is_found(most: int, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("mecanique.motion.linear.speeds._MOST_KNOWN", most)
    limit = np.sqrt(4 * A * WEIGHT) / C
    found = sweep_speeds(top(), None, {"tip_wz": limit}, [0.5, 1.7])
    # there two exponents meet, so that half the digits are lost
    assert found.limits == pytest.approx((1,), rel=1e-6)


def test_a_top_that_precesses_nods_as_by_its_closed_form() -> None:
    """A s² of a small nod about a steady precession Ω, spin and lean (Routh, ibid., art. 206)."""
    lean, going = 0.7, 3.0
    # A Ω² cos θ − C n Ω + m g l = 0 of the whole angular velocity n along the axis
    n = (A * going**2 * np.cos(lean) + WEIGHT) / (C * going)
    spin = n - going * np.cos(lean)
    at = {"tip_qx": np.sin(lean / 2), "tip_qw": np.cos(lean / 2)}
    v = {"tip_wy": going * np.sin(lean), "tip_wz": n}
    found = linearize_steady(top(), at, v)
    assert set(found.cyclic) == {"tip_precession", "tip_spin"}
    rates = dict(zip(found.velocities, found.v, strict=True))
    assert rates["tip_precession'"] == pytest.approx(going, rel=1e-12)
    assert rates["tip_spin'"] == pytest.approx(spin, rel=1e-12)
    nod = np.sqrt(going**2 - 2 * WEIGHT * np.cos(lean) / A + (WEIGHT / (A * going)) ** 2)
    assert np.abs(found.exponents).max() == pytest.approx(nod, rel=1e-9)
    with pytest.raises(InputError, match="is not steady: tip_precession' = "):
        linearize_steady(top(), at, {**v, "tip_wz": 2 * n})
    with pytest.raises(InputError, match="is not steady"):
        linearize_steady(top(skew=True), at, v)


def test_a_pendulum_that_goes_round_swings_as_by_its_closed_form() -> None:
    """A conical pendulum by its angles: s² = Ω² (1 + 3 cos² θ) and cos θ = g/(l Ω²)."""
    pendulum = textbook.load("spherical_pendulum")
    values, lean = pendulum.values, 0.6
    going = np.sqrt(values["g"] / (values["l"] * np.cos(lean)))
    found = linearize_steady(pendulum, {"theta": lean}, {"phi": going})
    assert found.cyclic == ("phi",)
    expected = going * np.sqrt(1 + 3 * np.cos(lean) ** 2)
    assert np.abs(found.exponents).max() == pytest.approx(expected, rel=1e-9)


def test_what_is_no_polynomial_of_the_speed_is_refused() -> None:
    """About a sleeping top C grows with the spin, and K stays."""
    found = expand_in_speed(top(), None, {"tip_wz": 1.0}, ("tip_precession", "tip_nutation"))
    np.testing.assert_allclose(found.M, A * np.eye(2), rtol=0, atol=1e-12)
    np.testing.assert_allclose(np.abs(found.C[1]), C * np.eye(2)[::-1], rtol=0, atol=1e-12)
    np.testing.assert_allclose(found.K[0], -WEIGHT * np.eye(2), rtol=0, atol=1e-11)
    assert not found.C[0].any()
    assert not found.K[1:].any()
    assert "C = C0 + u C1: C0" in str(found)
