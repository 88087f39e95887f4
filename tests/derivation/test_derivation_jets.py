"""Jets: exact Taylor arithmetic with duals, and Lagrange's operator against closed forms."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
import sympy
from derivation_law import atan2, cos, euler, exp, sin, sqrt
from hypothesis import given, settings
from hypothesis import strategies as st

from mecanique.derivation.scalars.functions import function
from mecanique.derivation.scalars.jets import Jet
from mecanique.errors import DerivationError

PROPERTY = settings(deadline=None, max_examples=40, derandomize=True)


def variable(u: np.ndarray, orders: int = 4) -> Jet:
    """u + ε, varied along one direction."""
    c = np.zeros((orders, 2, *u.shape))
    c[0, 0], c[1, 0], c[0, 1] = u, 1.0, 1.0
    return Jet(c)


def any_jet(seed: int, shape: tuple[int, ...] = (3,), orders: int = 3, directions: int = 2) -> Jet:
    return Jet(np.random.default_rng(seed).normal(size=(orders, 1 + directions, *shape)))


@pytest.mark.parametrize(
    "name", ["sin", "cos", "tan", "tanh", "sqrt", "exp", "log", "asin", "acos", "atan"]
)
def test_functions_have_their_taylor_coefficients(name: str) -> None:
    u, x = np.array([0.3, 0.7]), sympy.Symbol("x")
    f = function(name)(variable(u))
    derivatives = [getattr(sympy, name)(x).diff(x, k) / math.factorial(k) for k in range(5)]
    taylor = np.array([[float(d.subs(x, value)) for value in u] for d in derivatives])
    np.testing.assert_allclose(f.c[:, 0], taylor[:4], rtol=1e-12, atol=0)
    np.testing.assert_allclose(f.c[:, 1], taylor[1:] * np.arange(1, 5)[:, None], rtol=1e-12, atol=0)


@pytest.mark.parametrize("power", [-2, -1, 0, 1, 3, 0.5, -1.5, 2.0])
def test_powers(power: float) -> None:
    u = np.array([0.5, 2.0])
    p = variable(u) ** power
    expected = [u**power, power * u ** (power - 1.0), power * (power - 1) / 2 * u ** (power - 2.0)]
    np.testing.assert_allclose(p.c[:3, 0], expected, rtol=1e-13, atol=1e-15)


def same(x: Jet, y: Jet) -> None:
    np.testing.assert_allclose(x.c, y.c, rtol=1e-11, atol=1e-11)


@PROPERTY
@given(st.integers(0, 10**6))
def test_jets_form_a_commutative_algebra(seed: int) -> None:
    a, b, c = any_jet(seed), any_jet(seed + 1), any_jet(seed + 2)
    same(a * b, b * a)
    same((a * b) * c, a * (b * c))
    same(a * (b + c), a * b + a * c)
    same(2 - a, -(a - 2))
    same(sin(a) ** 2 + cos(a) ** 2, a * 0 + 1)
    same(exp(a + b), exp(a) * exp(b))
    same(sqrt(a * a + 1) ** 2, a * a + 1)
    same((a / (b * b + 1)) * (b * b + 1), a)
    same(1 / exp(a), exp(-a))
    same((a * b).ddt(), a.ddt() * b + a * b.ddt())
    same(a * np.ones((2, 3)), Jet(np.broadcast_to(a.c[:, :, None], (3, 3, 2, 3))))


def test_matrices_multiply_transpose_and_slice() -> None:
    a, b = any_jet(1, (5, 4, 4)), any_jet(2, (5, 4, 4))
    X = np.random.default_rng(3).normal(size=(4, 4))
    np.testing.assert_allclose((a @ b).T.c, (b.T @ a.T).c, rtol=1e-12, atol=1e-13)
    np.testing.assert_array_equal((X @ a).c, X @ a.c)
    np.testing.assert_array_equal((a @ X).c, a.c @ X)
    trace = a.trace_with(b)
    np.testing.assert_allclose(
        trace.c, (a @ b.T).c.trace(axis1=-2, axis2=-1), rtol=1e-12, atol=1e-12
    )
    entry = sum((a[..., 0, k] * b[..., k, 1] for k in range(1, 4)), a[..., 0, 0] * b[..., 0, 1])
    np.testing.assert_allclose((a @ b)[..., 0, 1].c, entry.c, rtol=1e-12, atol=1e-13)
    assert a[0].value.shape == (4, 4)


def test_scalars_broadcast_against_matrices_and_lower_orders() -> None:
    a, s = any_jet(1, (4, 4)), any_jet(2, ())
    np.testing.assert_allclose((s * a)[2, 3].c, (s * a[2, 3]).c, rtol=1e-14, atol=0)
    assert (a + s).c.shape == a.c.shape
    assert (a.ddt() * a).c.shape[0] == 2


def test_angle_of_a_point_crosses_the_cut_smoothly() -> None:
    for angle in (0.3, 2.0, math.pi, -3.0):
        phi = variable(np.array(angle))
        turned = atan2(2 * sin(phi), 2 * cos(phi))
        np.testing.assert_allclose(turned.c[1:], phi.c[1:], rtol=0, atol=1e-14)
        assert math.cos(turned.value - angle) == pytest.approx(1.0, rel=1e-12)
    assert atan2(1.0, variable(np.array(1.0))).c[0, 1] == pytest.approx(-0.5, rel=1e-12)


def test_absolute_value_and_sign() -> None:
    u = variable(np.array([-2.0, 3.0]))
    np.testing.assert_allclose(
        function("Abs")(u).c[:2, 0], [[2.0, 3.0], [-1.0, 1.0]], rtol=1e-14, atol=0
    )
    np.testing.assert_allclose(
        function("sign")(u).c[:2, 0], [[-1.0, 1.0], [0.0, 0.0]], rtol=1e-14, atol=0
    )


def test_numbers_arrays_and_expressions_enter_the_same_functions() -> None:
    x = sympy.Symbol("x")
    assert sin(x) == sympy.sin(x)
    assert sqrt(4.0) == 2.0
    np.testing.assert_allclose(cos(np.zeros(2)), 1.0, rtol=1e-14, atol=0)
    with pytest.raises(
        DerivationError,
        match="expected a number, an array, a jet, a series or an expression in sin",
    ):
        sin("x")


def test_euler_on_the_rod_pendulum() -> None:
    m, l, g = 1.3, 0.7, 9.81

    def L(q: Any, v: Any, t: Any) -> Any:
        return m * l**2 / 6 * v[0] ** 2 + m * g * l / 2 * cos(q[0])

    q, v, a = np.random.default_rng(0).normal(size=(3, 1, 20))
    expected = m * l**2 / 3 * a + m * g * l / 2 * np.sin(q)
    np.testing.assert_allclose(euler(L, q, v, a), expected, rtol=1e-13, atol=0)
    np.testing.assert_allclose(
        euler(L, q[:, 0], v[:, 0], a[:, 0]), expected[:, 0], rtol=1e-13, atol=0
    )


def test_euler_on_a_charge_in_a_moving_frame() -> None:
    # L = ½ m v² + m W t x v − ½ k x⁴: explicit time and a term linear in v
    m, k, W = 1.1, 2.0, 0.6

    def L(q: Any, v: Any, t: Any) -> Any:
        return m * v[0] ** 2 / 2 + m * W * t * q[0] * v[0] - k * q[0] ** 4 / 2

    x, v, a = 0.4, 1.3, -0.8
    E = euler(L, [x], [v], [a], t=2.5)
    np.testing.assert_allclose(E, [m * a + m * W * x + 2 * k * x**3], rtol=1e-13, atol=0)


def test_euler_of_a_total_time_derivative_is_zero() -> None:
    def L(q: Any, v: Any, t: Any) -> Any:
        return cos(q[0]) * v[0] * q[1] + sin(q[0]) * v[1] + 2 * t * q[1] + t**2 * v[1]

    q, v, a = np.random.default_rng(1).normal(size=(3, 2, 8))
    np.testing.assert_allclose(euler(L, q, v, a, 0.7), 0.0, rtol=0, atol=1e-14)


def test_euler_of_a_constant_is_zero() -> None:
    np.testing.assert_array_equal(
        euler(lambda q, v, t: 3.0, [1.0, 2.0], [0.0, 0.0], [0.0, 0.0]), 0.0
    )


def test_printed_form_of_a_jet_shows_its_shape() -> None:
    assert repr(Jet(np.zeros((3, 3, 2)))) == "Jet(order=2, directions=2, shape=(2,), value=[0. 0.])"
