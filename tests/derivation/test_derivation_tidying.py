"""Roots that cancel, and sines of arcs."""

from __future__ import annotations

import math
import time
from fractions import Fraction

import numpy as np
import pytest

from mecanique.derivation.scalars.cancel import divide_exactly, tidy, without_common_divisor
from mecanique.derivation.scalars.evaluation import evaluate
from mecanique.derivation.scalars.functions import function, function_without_arcs
from mecanique.derivation.scalars.series import Ring


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
