from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import mecanique as mq
from mecanique.motion.record.curve import Curve
from mecanique.motion.record.quadrature import integral
from mecanique.motion.record.rates import Rates

PLAIN = Rates(((0,), (0,)), (), ())


def curve(t: np.ndarray, breaks: tuple[int, ...] = (0,), smooth: bool = True) -> Curve:
    """The curve q = sin 3t at given steps."""
    return Curve(
        t,
        np.sin(3 * t)[:, None],
        3 * np.cos(3 * t)[:, None],
        -9 * np.sin(3 * t)[:, None],
        np.array(breaks),
        PLAIN,
        smooth,
    )


@given(st.lists(st.floats(0.03, 0.2), min_size=5, max_size=40))
@settings(max_examples=50, deadline=None)
def test_a_curve_through_uneven_steps_is_the_function(gaps: list[float]) -> None:
    t = np.concatenate([[0.0], np.cumsum(gaps)])
    c = curve(t)
    x = np.linspace(0, t[-1], 500)
    state = c(x)
    # where short steps surround a long one its two ends alone may be usable: degree 5, (3 h)⁶ /
    # 46080 at h = 0.2
    np.testing.assert_allclose(state.q[:, 0], np.sin(3 * x), rtol=0, atol=2e-6)
    np.testing.assert_allclose(state.v[:, 0], 3 * np.cos(3 * x), rtol=0, atol=6e-5)


def test_a_curve_passes_through_its_steps_whatever_their_lengths() -> None:
    t = np.array([0.0, 1e-7, 1e-3, 0.1, 0.100001, 0.3, 0.30000001, 0.5])
    for smooth in (True, False):
        c = curve(t, smooth=smooth)
        np.testing.assert_allclose(c(t).q[:, 0], np.sin(3 * t), rtol=0, atol=1e-12)


def test_even_steps_are_interpolated_far_better_than_the_function_needs() -> None:
    c = curve(np.linspace(0, 2, 21))
    x = np.linspace(0, 2, 1001)
    assert np.abs(c(x).q[:, 0] - np.sin(3 * x)).max() < 1e-13
    assert max(e.max() for e in c.errors()) < 1e-11
    assert float(c(1.0).q[0]) == pytest.approx(np.sin(3.0), abs=1e-14)


def test_no_polynomial_reaches_across_a_break() -> None:
    t = np.array([0, 0.1, 0.2, 0.3, 0.3, 0.4, 0.5, 0.6])
    x = np.where(np.arange(8) < 4, t, 0.3 - 2 * (t - 0.3))
    v = np.where(np.arange(8) < 4, 1.0, -2.0)
    c = Curve(t, x[:, None], v[:, None], np.zeros((8, 1)), np.array([0, 4]), PLAIN)
    times = np.array([0.29, 0.3, 0.31])
    np.testing.assert_allclose(c(times).q[:, 0], [0.29, 0.3, 0.28], rtol=0, atol=1e-14)
    np.testing.assert_allclose(c(times).v[:, 0], [1.0, -2.0, -2.0], rtol=0, atol=1e-12)


def test_steps_can_be_added_inside() -> None:
    c = curve(np.linspace(0, 2, 6), breaks=(0, 3))
    t = np.array([0.2, 1.4])
    finer = c.with_steps(
        np.array([0, 3]),
        t,
        np.sin(3 * t)[:, None],
        3 * np.cos(3 * t)[:, None],
        -9 * np.sin(3 * t)[:, None],
    )
    assert finer.t.tolist() == sorted([*c.t.tolist(), 0.2, 1.4])
    assert finer.breaks.tolist() == [0, 4]


def test_integrals_are_those_of_the_function() -> None:
    c = curve(np.linspace(0, 2, 9))
    times = np.linspace(0, 2, 37)
    found = integral(c, lambda t, q, v: np.hstack([q * v, t[:, None] ** 3]), times)
    np.testing.assert_allclose(found[:, 0], np.sin(3 * times) ** 2 / 2, rtol=0, atol=1e-9)
    np.testing.assert_allclose(found[:, 1], times**4 / 4, rtol=0, atol=1e-13)


@pytest.fixture(scope="module")
def free() -> tuple[mq.Mechanism, Rates]:
    mechanism = mq.Mechanism(
        "free",
        (
            mq.Body("ground"),
            mq.Body("a", mq.box(1.0, (1, 2, 3))),
            mq.Body("b", mq.box(1.0, (1, 2, 3))),
            mq.Body("c", mq.rod(1.0, 1.0)),
        ),
        (
            mq.Revolute("hinge", "ground", "c", coordinate="h"),
            mq.Floating("fly", "ground", "a"),
            mq.Spherical("ball", "a", "b"),
        ),
    )
    return mechanism, Rates.of(mechanism)


def test_rates_and_velocities_are_inverse_and_agree_with_the_engine(
    free: tuple[mq.Mechanism, Rates],
) -> None:
    mechanism, rates = free
    rng = np.random.default_rng(1)
    q = rates.normalize(rng.normal(size=(5, mechanism.nq)))
    v = rng.normal(size=(5, mechanism.nv))
    first = rates.first(q, v)
    np.testing.assert_allclose(first, mq.Reference(mechanism).rates(q, v), rtol=0, atol=1e-14)
    np.testing.assert_allclose(rates.velocities(q, first), v, rtol=0, atol=1e-14)
    assert not rates.trivial


def test_second_rates_and_moves_are_derivatives(free: tuple[mq.Mechanism, Rates]) -> None:
    mechanism, rates = free
    rng = np.random.default_rng(2)
    q = rates.normalize(rng.normal(size=mechanism.nq))
    v, a = rng.normal(size=(2, mechanism.nv))
    h = 1e-4
    ahead, behind = rates.displace(q, h * v), rates.displace(q, -h * v)
    np.testing.assert_allclose((ahead - behind) / (2 * h), rates.first(q, v), rtol=0, atol=1e-8)
    assert rates.drift(ahead) < 1e-15
    # q̇ along q(t) with v(t) = v + a t
    step = 1e-5
    q1, q0 = (rates.displace(q, s * step * v + step**2 / 2 * a) for s in (1, -1))
    slope = (rates.first(q1, v + step * a) - rates.first(q0, v - step * a)) / (2 * step)
    np.testing.assert_allclose(slope, rates.second(q, v, a), rtol=0, atol=1e-8)
