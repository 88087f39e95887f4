"""Momenta, gravity and inverse dynamics: recursion against jets, both against closed forms."""

from __future__ import annotations

import numpy as np
import pytest
from derivation_samples import SAMPLES, sample, states
from systems import derive_system

import mecanique as mq
from mecanique.derivation.numeric.lagrange import LagrangeOnJets
from mecanique.derivation.numeric.recursion import Recursion
from mecanique.errors import InputError
from mecanique.model.states import States


def test_momenta_of_a_swinging_rod() -> None:
    m, length, rate = 2.0, 0.7, 1.3
    rod = mq.textbook.load("rigid_bar_pendulum", m=m, l=length)
    linear, angular, about_center = mq.derive(rod).momentum({"q": 0.0}, {"q'": rate})
    np.testing.assert_allclose(linear, [m * length / 2 * rate, 0, 0], rtol=0, atol=1e-15)
    # from −z towards +x is a turn about −y
    np.testing.assert_allclose(angular, [0, -m * length**2 / 3 * rate, 0], rtol=0, atol=1e-15)
    np.testing.assert_allclose(about_center, [0, -m * length**2 / 12 * rate, 0], rtol=0, atol=1e-15)


@pytest.mark.parametrize("name", SAMPLES)
def test_recursion_is_the_definition(name: str) -> None:
    mechanism = sample(name)
    some = states(mechanism, 4)
    a = np.random.default_rng(1).normal(size=some.v.shape)
    fast, exact = Recursion(mechanism), LagrangeOnJets(mechanism)
    pairs = [
        (fast.gravity(some), exact.gravity(some)),
        (fast.inverse_dynamics(some, a), exact.inverse_dynamics(some, a)),
        *zip(fast.momentum(some), exact.momentum(some), strict=True),
    ]
    for x, y in pairs:
        np.testing.assert_allclose(x, y, rtol=0, atol=1e-12 * max(1.0, float(np.abs(y).max())))


@pytest.mark.parametrize("name", SAMPLES)
def test_inverse_dynamics_is_what_the_mass_matrix_makes(name: str) -> None:
    mechanism = sample(name)
    some = states(mechanism, 4)
    a = np.random.default_rng(2).normal(size=some.v.shape)
    equations = mq.derive(mechanism)
    tau = equations.inverse_dynamics(some.q, some.v, a, some.t)
    M, h, Q = (getattr(equations.numeric, name)(some) for name in ("mass_matrix", "bias", "forces"))
    expected = np.einsum("nij,nj->ni", M, a) + h - Q
    np.testing.assert_allclose(
        tau, expected, rtol=0, atol=1e-12 * max(1.0, float(np.abs(expected).max()))
    )


def test_gravity_is_the_slope_of_the_potential() -> None:
    mechanism = mq.textbook.load("double_pendulum")
    numeric = Recursion(mechanism)
    q, step = np.array([[0.4, -1.1]]), 1e-5
    slope = []
    for k in range(2):
        moved = [q + side * step * np.eye(2)[k] for side in (1, -1)]
        V = [numeric.energy(States.of(mechanism, x, np.zeros((1, 2))))[1][0] for x in moved]
        slope.append((V[0] - V[1]) / (2 * step))
    np.testing.assert_allclose(mq.derive(mechanism).gravity(q)[0], slope, rtol=1e-8, atol=0)


def test_one_state_takes_many_accelerations_but_not_two_states_three() -> None:
    equations = derive_system("double_pendulum")
    assert equations.inverse_dynamics([0.1, 0.2], [0, 0], np.eye(2)).shape == (2, 2)
    with pytest.raises(
        InputError, match="expected one number of states in q, v, a and t, got q: 2, v: 2, a: 3"
    ):
        equations.inverse_dynamics(np.zeros((2, 2)), np.zeros((2, 2)), np.zeros((3, 2)))


@pytest.mark.parametrize("name", SAMPLES)
def test_equations_are_linear_in_the_mass_moments(name: str) -> None:
    mechanism = sample(name)
    some = states(mechanism, 3)
    a = np.random.default_rng(3).normal(size=some.v.shape)
    numeric = Recursion(mechanism)
    expected = numeric.inverse_dynamics(some, a)
    massless = numeric.vary(moments={k: np.zeros((4, 4)) for k in range(len(numeric.tree))})
    from_masses = np.einsum("nvkab,kab->nv", numeric.regressor(some, a), np.array(numeric.moments))
    rotors = massless.inverse_dynamics(some, a)
    np.testing.assert_allclose(
        from_masses + rotors, expected, rtol=0, atol=1e-13 * max(1.0, float(np.abs(expected).max()))
    )


def test_numbers_may_vary_from_state_to_state() -> None:
    mechanism = mq.textbook.load("double_pendulum")
    numeric, some = Recursion(mechanism), states(mechanism, 2)
    pull = np.array([[0.0, 0.0, -9.81], [0.0, 0.0, 0.0]])
    bias = numeric.vary(gravity=pull).bias(some)
    np.testing.assert_allclose(bias[0], numeric.bias(some)[0], rtol=1e-14, atol=0)
    np.testing.assert_allclose(
        bias[1], (numeric.bias(some) - numeric.gravity(some))[1], rtol=1e-12, atol=0
    )
    doubled = numeric.vary(moments={k: 2 * J for k, J in enumerate(numeric.moments)})
    np.testing.assert_allclose(
        doubled.mass_matrix(some), 2 * numeric.mass_matrix(some), rtol=1e-14, atol=0
    )
    still = numeric.vary(origins={0: np.tile(numeric.origins[0], (2, 1, 1))})
    np.testing.assert_allclose(still.bias(some), numeric.bias(some), rtol=1e-14, atol=0)


INTEGRALS = (
    "rigid_bar_pendulum",
    "double_pendulum",
    "bars_and_springs",
    "gyroscope",
    "bead_on_hoop",
    "foucault_pendulum",
)


@pytest.mark.parametrize("name", INTEGRALS)
def test_what_is_said_to_be_conserved_is(name: str) -> None:
    """Its rate is Σ q' (d/dt ∂L/∂q' − ∂L/∂q), which vanishes along a motion."""
    derivation = derive_system(name).derivation
    (stage,) = (stage for stage in derivation.stages if stage.title.endswith("ntegral"))
    (line,) = stage.results
    ring = derivation.algebra.ring
    power = ring.sum(
        ring[name] * row
        for name, row in zip(derivation.algebra.velocities, derivation.rows, strict=True)
    )
    assert power
    assert (line.right.ddt() - power).vanishes()


def test_a_driven_pendulum_conserves_jacobis_integral_not_its_energy() -> None:
    """Goldstein, Classical Mechanics, 3rd ed., sect. 2.7: the drive of the platform does work."""
    text = derive_system("bead_on_hoop").text(steps=True)
    assert "the total energy changes" in " ".join(text.split())
    assert (
        "\n     h = m R^2 theta'^2/2 - m R^2 W^2 sin(theta)^2/2 - m g R cos(theta)\n" in f"{text}\n"
    )
    assert "\n     E = " not in text


@pytest.mark.parametrize(
    "name", ["four_bar_linkage", "slider_crank", "rolling_disk", "chaplygin_sleigh"]
)
def test_constraints_that_do_no_work_conserve_the_energy(name: str) -> None:
    titles = [stage.title for stage in derive_system(name).derivation.stages]
    assert "Energy integral" in titles


@pytest.mark.parametrize(("rate", "conserved"), [(0.0, True), (0.5, False)])
def test_a_constraint_that_drives_does_work(rate: float, *, conserved: bool) -> None:
    """z' - y x' = b takes a force that moves the block upward even at x' = y' = 0 unless b is 0."""
    names = ("ground", "beam", "trolley", "block")
    slides = tuple(
        mq.Prismatic(f"along {q}", names[k], names[k + 1], axis=axis, coordinate=q)
        for k, (q, axis) in enumerate((("x", (1, 0, 0)), ("y", (0, 1, 0)), ("z", (0, 0, 1))))
    )
    drive = mq.VelocityConstraint("drive", {"z": 1.0, "x": -mq.coordinate("y")}, rate)
    block = mq.Body("block", mq.box(1.0, (0.1, 0.1, 0.1)))
    bodies = (*map(mq.Body, names[:3]), block)
    cart = mq.Mechanism("pulled", bodies, slides, velocity_constraints=(drive,))
    titles = [stage.title for stage in mq.derive(cart).derivation.stages]
    assert ("Energy integral" in titles) is conserved
