"""Roots that cancel, and sines of arcs."""

from __future__ import annotations

import math
import time
from fractions import Fraction

import numpy as np
import pytest

from mecanique.derivation.scalars.cancel import (
    by_velocity,
    divide_exactly,
    integrate,
    tidy,
    without_common_divisor,
    without_rounding,
)
from mecanique.derivation.scalars.evaluation import evaluate
from mecanique.derivation.scalars.functions import function, function_without_arcs
from mecanique.derivation.scalars.series import Ring, Series
from mecanique.derivation.tolerances import ROUNDING


def test_terms_over_a_root_come_together() -> None:
    ring = Ring()
    q, length = ring.coordinate("q"), ring.parameter("l")
    root = function("sqrt")(length**2 - q**2)
    assert tidy(q**2 / root**2 + 1) == length**2 / root**2


def test_sums_cancel() -> None:
    ring = Ring()
    a, b = ring.parameter("a"), ring.parameter("b")
    assert tidy((a**2 + a * b) * (1 / (a + b)) ** 2) == a / (a + b)
    assert tidy((a**2 + 2 * a * b + b**2) / (a + b)) == a + b


def test_a_division_keeps_its_coefficients_as_small_as_they_are() -> None:
    """Fractions of tilts have hundreds of digits; each step multiplied all of them again."""
    ring = Ring()
    a, b = ring.parameter("a"), ring.parameter("b")
    divisor = a * Fraction(3**600, 2**900) + b * Fraction(7**300, 2**900)
    quotient = ring.sum((a - k * b**2) * a**k * b ** (k % 7) for k in range(1, 300))
    started = time.process_time()
    assert divide_exactly(quotient * divisor, divisor) == quotient
    assert divide_exactly(quotient * divisor + a, divisor) is None
    share = Fraction(6, 35)  # which all coefficients of the divisor have
    assert divide_exactly(quotient * divisor, share * divisor) == quotient / share
    assert time.process_time() - started < 2.0  # 0.01 s; by pseudo-division over 100 s


def test_what_does_not_cancel_stays() -> None:
    ring = Ring()
    a, b = ring.parameter("a"), ring.parameter("b")
    series = a / (a + b)
    assert tidy(series) == series


def test_what_all_terms_are_divided_by_is_left_out() -> None:
    ring = Ring()
    a, b, q = ring.parameter("a"), ring.parameter("b"), ring.coordinate("q")
    assert without_common_divisor(a * q / (a + b) + q**2 / (a + b)) == a * q + q**2
    assert without_common_divisor(q / (a + q)) == q
    kept = q / (a + q) + b
    assert without_common_divisor(kept) == kept


def test_a_divisor_of_all_terms_is_left_out_as_often_as_all_contain_it() -> None:
    """x''/(R² − x²) + x x'²/(R² − x²)² = 0 is x'' + x x'²/(R² − x²) = 0."""
    ring = Ring()
    x, R, t = ring.coordinate("x"), ring.parameter("R"), ring.time
    v, a, s = ring["x'"], ring["x''"], R**2 - x**2
    by = 1 / s
    assert without_common_divisor(a * by + x * v**2 * by**2) == a + x * v**2 * by
    assert without_common_divisor(a * by**3 + x * v**2 * by**2) == a * by + x * v**2
    by = 1 / function("sqrt")(s)
    assert without_common_divisor(a * by + v**2 * by**3) == a + v**2 * by**2
    for changing in (1 + t, 1 + v):  # these may pass zero
        assert without_common_divisor(a / changing) == a / changing


@pytest.mark.parametrize(
    ("share", "kept"), [(1.1, True), (-1.1, True), (0.9, False), (-0.9, False)]
)
def test_rounding_is_told_by_the_largest_coefficient_without_a_root(
    share: float, kept: bool
) -> None:
    ring = Ring()
    a, b, q = ring.parameter("a"), ring.parameter("b"), ring.coordinate("q")
    root = function("sqrt")(a**2 + q**2)
    small = 700 * Fraction(ROUNDING) * Fraction(share)
    rest = small * b * q
    summed = [700 * a / 3 * 3, rest, 10**20 * root]
    assert without_rounding(ring.sum([a, rest]), summed) == (a + rest if kept else a)
    assert without_rounding(ring.sum([a, rest / 3]), [x / 3 for x in summed]) == (
        a + rest / 3 if kept else a
    )
    waves = function("cos")(q) * rest
    assert without_rounding(waves, summed) == (waves if kept else 0)
    assert without_rounding(small * root, summed) == small * root


def test_coefficients_of_velocities_are_tidied_one_by_one() -> None:
    ring = Ring()
    x, y, l = ring.coordinate("x"), ring.coordinate("y"), ring.parameter("l")
    v, w = ring["x'"], ring["y'"]
    root = function("sqrt")(l**2 - x**2)
    whole = l**2 / root**2
    series = (x**2 / root**2 + 1) * v**2 * w + y * w / root + x
    assert by_velocity(series, ("x'", "y'")) == whole * v**2 * w + y * w / root + x


def integrals(ring: Ring) -> list[Series]:
    q, l = ring.coordinate("q"), ring.parameter("l")
    alpha, t = ring.parameter("alpha"), ring.time
    sin, cos = function("sin"), function("cos")
    return [
        *(q**n for n in (-3, -2, 0, 1, 4)),
        3 * l * q**2 / 7 - t,
        sin(q),
        5 * cos(2 * q + alpha) * l - sin(3 * q - t),
        cos(l * q) * t**2,
        q * cos(alpha),
    ]


def test_an_integral_has_its_series_as_derivative() -> None:
    ring = Ring()
    for series in integrals(ring):
        integral = integrate(series, "q")
        assert integral is not None
        assert integral.diff("q") == series
    q, sin = ring["q"], function("sin")
    for beyond in (1 / q, q * sin(q), sin(q**2), q + q**2 * sin(q)):
        assert integrate(beyond, "q") is None


@pytest.mark.parametrize("arc", ["asin", "acos", "atan"])
@pytest.mark.parametrize("count", [-2, -1, 1, 3])
def test_sines_and_cosines_of_arcs_are_roots(arc: str, count: int) -> None:
    ring = Ring()
    u, q = ring.coordinate("u"), ring.coordinate("q")
    angle = count * function(arc)(u) + 2 * q
    values = {"u": np.array([-0.7, 0.1, 0.6]), "q": np.array([0.3, -1.0, 2.0])}
    for name, exact in (("sin", np.sin), ("cos", np.cos)):
        series = function_without_arcs(name)(angle)
        expected = exact(evaluate(angle, values))
        np.testing.assert_allclose(evaluate(series, values), expected, rtol=0, atol=1e-14)
        assert not any(
            ring.atoms[g.index].function == arc
            for g in series.generators()
            if g.index in ring.atoms
        )


@pytest.mark.parametrize("named", [True, False])
@pytest.mark.parametrize("name", ["sin", "cos"])
def test_sines_of_twelfths_of_pi_are_roots(name: str, named: bool) -> None:
    """With π as a constant of its own, or as the float next to it, alone and beside an angle."""
    ring = Ring()
    q = ring.coordinate("q")
    for n in range(-24, 25):
        part = ring.constant("pi") * n / 12 if named else ring.number(math.pi * n / 12)
        alone, beside = function(name)(part), function(name)(q + part)
        exact = getattr(math, name)
        assert evaluate(alone, {}) == pytest.approx(exact(math.pi * n / 12), abs=1e-14)
        expected = exact(0.7 + math.pi * n / 12)
        assert evaluate(beside, {"q": 0.7}) == pytest.approx(expected, abs=1e-14)
        assert not any(word in str(alone) for word in ("pi", "sin", "cos"))


@pytest.mark.parametrize("n", [1, 3, 4, 10])
def test_a_number_close_to_a_twelfth_of_pi_is_another_number(n: int) -> None:
    ring = Ring()
    exact, close = (function("cos")(ring.number(math.pi * n / 12 + off)) for off in (0.0, 1e-12))
    assert exact - close
    assert "cos" in str(close)
    assert evaluate(close, {}) == pytest.approx(math.cos(math.pi * n / 12), abs=1e-11)
