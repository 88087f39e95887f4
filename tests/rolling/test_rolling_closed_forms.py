"""What rolls, against solutions in closed form."""

from __future__ import annotations

import numpy as np
import pytest
from rolling_samples import W, coin, g, m, r, sleigh, turntable, wheel

from mecanique import (
    InputError,
    Placement,
    Reference,
    derive,
    linearize,
    linearize_steady,
    simulate,
    sweep_speeds,
    textbook,
    verify,
)
from mecanique.verification.states import random_states


def test_a_disk_down_a_slope() -> None:
    """a = 2 g sin(α)/3, N = m g cos(α), friction −m g sin(α)/3."""
    slope = 0.3
    reference = Reference(wheel(plane=Placement(rpy=(0, slope, 0))))
    place = {
        "free_x": r.value * np.sin(slope),
        "free_z": r.value * np.cos(slope),
        "free_qy": np.sin(slope / 2),
        "free_qw": np.cos(slope / 2),
    }
    v = {"free_vx": 2.0, "free_wy": 2.0 / r.value}
    weight = m.value * g.value
    assert reference.acceleration(place, v)[0] == pytest.approx(
        2 * g.value * np.sin(slope) / 3, rel=1e-12
    )
    forces = reference.multipliers(place, v)
    assert forces["rim: normal"] == pytest.approx(weight * np.cos(slope), rel=1e-12)
    assert forces["rim: x"] == pytest.approx(-weight * np.sin(slope) / 3, rel=1e-12)
    assert forces["rim: y"] == pytest.approx(0, abs=1e-12)
    wrench = reference.reactions(place, v)["rim"]
    # about the hub the friction turns the disk
    assert wrench.moment[1] == pytest.approx(r.value * weight * np.sin(slope) / 3, rel=1e-12)


def test_a_coin_by_its_equations() -> None:
    """Euler's equations of a thin disk (J. I. Neimark & N. A. Fufaev, 1972, ch. II)."""
    mechanism = coin()
    states = random_states(mechanism, 40, 3)
    # leaning further it touches with the other half of its rim
    states = states.at(np.flatnonzero(np.abs(states.q[:, 4]) < np.pi / 2))
    found = Reference(mechanism).acceleration(states.q, states.v)[:, 3:]
    lean = states.q[:, 4]
    yaw_rate, lean_rate, spin_rate = states.v[:, 3:].T
    sine, cosine, tangent = np.sin(lean), np.cos(lean), np.tan(lean)
    expected = np.stack(
        [
            -2 * lean_rate * spin_rate / cosine,
            4 * g.value * sine / (5 * r.value)
            + sine * cosine * yaw_rate**2
            + 6 * cosine * yaw_rate * spin_rate / 5,
            -(5 * cosine * yaw_rate - 6 * tangent * spin_rate) * lean_rate / 3,
        ],
        axis=1,
    )
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-9)


@pytest.mark.slow
def test_a_coin_by_kanes_method_of_sympy() -> None:
    """SymPy's KanesMethod for the rolling disc, as in its documentation, gives the same motion."""
    from sympy import lambdify, symbols
    from sympy.physics.mechanics import (
        KanesMethod,
        Point,
        ReferenceFrame,
        RigidBody,
        dynamicsymbols,
        inertia,
    )

    q1, q2, q3, u1, u2, u3 = dynamicsymbols("q1 q2 q3 u1 u2 u3")
    radius, mass, fall = symbols("r m g")
    N = ReferenceFrame("N")
    Y = N.orientnew("Y", "Axis", [q1, N.z])
    L = Y.orientnew("L", "Axis", [q2, Y.x])
    R = L.orientnew("R", "Axis", [q3, L.y])
    R.set_ang_vel(N, u1 * L.x + u2 * L.y + u3 * L.z)
    touch = Point("C")
    touch.set_vel(N, 0)
    middle = touch.locatenew("D", radius * L.z)
    middle.v2pt_theory(touch, N, R)
    disk = RigidBody(
        "disk",
        middle,
        R,
        mass,
        (inertia(L, mass * radius**2 / 4, mass * radius**2 / 2, mass * radius**2 / 4), middle),
    )
    turning = q1.diff() * Y.z + q2.diff() * L.x + q3.diff() * L.y
    rates = [turning.dot(axis) - u for axis, u in zip(L, (u1, u2, u3), strict=True)]
    kane = KanesMethod(N, q_ind=[q1, q2, q3], u_ind=[u1, u2, u3], kd_eqs=rates)
    kane.kanes_equations([disk], [(middle, -mass * fall * Y.z)])
    letters = [q1, q2, q3, u1, u2, u3, radius, mass, fall]
    compute = lambdify(letters, [kane.mass_matrix, kane.forcing])
    states = random_states(coin(), 20, 4)
    states = states.at(np.flatnonzero(np.abs(states.q[:, 4]) < np.pi / 2))
    found = Reference(coin()).acceleration(states.q, states.v)[:, 3:]
    for place, v, a in zip(states.q[:, 3:], states.v[:, 3:], found, strict=True):
        sine, cosine = np.sin(place[1]), np.cos(place[1])
        speeds = [v[1], v[0] * sine + v[2], v[0] * cosine]
        M, f = compute(*place, *speeds, r.value, 1.3, g.value)
        rate = np.linalg.solve(M, f).ravel()
        yaw = (rate[2] + v[0] * v[1] * sine) / cosine
        spin = rate[1] - yaw * sine - v[0] * v[1] * cosine
        np.testing.assert_allclose(a, [yaw, rate[0], spin], rtol=1e-10, atol=1e-10)


def test_a_ball_on_a_turntable_goes_round_at_two_sevenths() -> None:
    """Milne, Vectorial Mechanics, 1948: v' = (2/7) W z × v for a homogeneous ball."""
    mechanism = turntable()
    reference = Reference(mechanism)
    states = random_states(mechanism, 10, 4)
    moved = reference.point("ball", (0, 0, 0), states.q, states.v, None, states.t)
    a = reference.acceleration(states.q, states.v, states.t)
    found = reference.point("ball", (0, 0, 0), states.q, states.v, a, states.t).acceleration
    x, y, _ = moved.velocity.T
    rate = 2 * W.value / 7
    steady = linearize_steady(mechanism)  # at rest in the middle, while the table turns
    exponents = steady.exponents[np.argsort(steady.exponents.imag)]
    expected = np.array([-rate, 0, 0, rate]) * 1j
    np.testing.assert_allclose(exponents, expected, rtol=0, atol=1e-14)
    np.testing.assert_allclose(
        found, np.stack([-rate * y, rate * x, 0 * x], -1), rtol=0, atol=1e-13
    )


def test_the_sleigh_by_its_closed_form() -> None:
    """Chaplygin's sleigh: u = U tanh(a U t/b²), ω = U/(b cosh(a U t/b²)), b² = I/m + a²."""
    a, mass = 0.3, 2.0
    inertia = mass * (1 + 0.4**2) / 12
    b = np.sqrt(inertia / mass + a * a)
    start = 1.2  # of ω, with u = 0
    U = b * start
    motion = simulate(sleigh(a), v={"theta'": start}, duration=5.0, rtol=1e-10)
    phase = a * U * motion.t / b**2
    theta = motion["theta"]
    u = np.cos(theta) * motion["x'"] + np.sin(theta) * motion["y'"]
    np.testing.assert_allclose(u, U * np.tanh(phase), rtol=0, atol=1e-10)
    np.testing.assert_allclose(motion["theta'"], U / b / np.cosh(phase), rtol=0, atol=1e-10)
    # the blade alone turns the path: λ = m (a ω' + u ω)
    omega = U / b / np.cosh(phase)
    force = mass * (-a * a * (U * np.tanh(phase)) * omega / b**2 + U * np.tanh(phase) * omega)
    found = motion.reference.multipliers(motion.q, motion.v, motion.t)["edge: side"]
    np.testing.assert_allclose(found, force, rtol=0, atol=1e-10)


def test_a_coin_rolls_upright_above_its_limit() -> None:
    """A thin disk is stable if v² > g r/3 (Routh, Advanced Rigid Dynamics, 1905, art. 245)."""
    limit = np.sqrt(g.value / (3 * r.value))
    found = sweep_speeds(coin(), {"z": r.value}, {"spin": 1.0}, [0.5 * limit, 1.7 * limit])
    # there three exponents meet at zero, so that half the digits are lost
    assert found.limits == pytest.approx([limit], rel=1e-6)
    fast = linearize_steady(coin(), {"z": r.value}, {"spin": 2 * limit})
    assert fast.stable
    # λ² = 4 g/(5 r) − 12 n²/5
    n = 2 * limit
    expected = np.sqrt(12 * n * n / 5 - 4 * g.value / (5 * r.value))
    assert np.abs(fast.exponents).max() == pytest.approx(expected, rel=1e-9)


def test_a_coin_goes_round_steadily_and_others_are_refused() -> None:
    lean, turn = 0.3, 1.2
    spin = (
        -5
        / (6 * np.cos(lean) * turn)
        * (4 * g.value * np.sin(lean) / (5 * r.value) + np.sin(lean) * np.cos(lean) * turn**2)
    )
    at, v = {"lean": lean, "z": r.value * np.cos(lean)}, {"yaw": turn, "spin": spin, "lean": 0.0}
    found = linearize_steady(coin(), at, v)
    assert {"x", "y", "yaw", "spin"} >= set(found.cyclic)
    motion = simulate(coin(), q=at, v=v, duration=2.0)
    np.testing.assert_allclose(motion["lean"], lean, rtol=0, atol=1e-12)
    np.testing.assert_allclose(motion["yaw"], turn * motion.t, rtol=0, atol=1e-12)
    with pytest.raises(InputError, match=r"is not steady: .*lean'' = "):
        linearize_steady(coin(), at, {**v, "spin": 2 * spin})
    # the same disk by a quaternion
    by_quaternion = {"free_z": at["z"], "free_qx": np.sin(lean / 2), "free_qw": np.cos(lean / 2)}
    turning = {"free_wy": turn * np.sin(lean) + spin, "free_wz": turn * np.cos(lean)}
    free = linearize_steady(wheel(), by_quaternion, turning)
    for exponents in (free.exponents, found.exponents):
        np.testing.assert_allclose(exponents.real, 0, rtol=0, atol=1e-12)
    by_hinges, by_turns = np.sort(found.exponents.imag), np.sort(free.exponents.imag)
    np.testing.assert_allclose(by_turns, by_hinges, rtol=0, atol=1e-11)
    assert {"free_x", "free_y", "free_precession", "free_spin"} >= set(free.cyclic)
    with pytest.raises(InputError, match="use linearize_steady"):
        linearize(coin(), at)


def test_a_rattleback_prefers_a_sense() -> None:
    """Spun one way its fast rattling grows, the other way it decays (Bondi, Proc. R. Soc. A 405

    (1986) 265); exponents of opposite spins are opposite, as time may run backwards.
    """
    stone = textbook.load("rattleback")
    wrong, right = (
        linearize_steady(stone, {"z": 0.02}, {"yaw": spin}).exponents for spin in (-5.0, 5.0)
    )
    np.testing.assert_allclose(np.sort_complex(wrong), np.sort_complex(-right), rtol=0, atol=1e-11)
    fast = wrong[np.abs(wrong).argmax()]
    assert fast.real > 20
    assert abs(fast.imag) > 100


def test_a_disk_down_an_incline_has_its_normal_force_and_friction() -> None:
    """N = m g cos(α) and friction m g sin(α)/3, by hand, in the derivation and the reference."""
    disk = textbook.load("rolling_disk")
    weight, slope = 9.81, 0.3
    for source in (Reference(disk), derive(disk, "newton_euler")):
        forces = source.multipliers({"z": 0.3}, {"x": 1.0, "turn": 1 / 0.3})
        assert forces["contact: normal"] == pytest.approx(weight * np.cos(slope), rel=1e-13)
        assert forces["contact: x"] == pytest.approx(-weight * np.sin(slope) / 3, rel=1e-13)


@pytest.mark.parametrize(
    ("rpy", "crown"), [((0.3, 0.0, 0.0), 0.0), ((0.3, 0.0, 0.0), 0.1), ((0.3, -0.7, 1.1), 0.0)]
)
def test_the_closed_form_on_a_tilted_plane(rpy: tuple[float, float, float], crown: float) -> None:
    """Terms beside the root of a large integer are no measure of those without it."""
    verdict = verify(wheel(crown, Placement((0.1, 0.2, 0.3), rpy)), 4, 1)
    assert verdict.agrees, str(verdict)
    assert "closed form" in {row.sources[0] for row in verdict.rows}
