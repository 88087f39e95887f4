"""Jets: numbers that carry their motion and their variations.

A jet is a Taylor polynomial in the parameter ε of a path, each coefficient with its first-order
partial derivatives (duals), for any array of states at once. Arithmetic with jets is exact up to
rounding and has no step size to choose. It follows A. Griewank, A. Walther, Evaluating Derivatives,
2nd ed., SIAM 2008, chapters 3 and 13.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, final

import numpy as np


@final
class Jet:
    """A Taylor polynomial in ε with partial derivatives, for an array of states or matrices."""

    # Shapes: c (order + 1, 1 + directions, …)

    __slots__ = ("c",)
    __array_ufunc__ = None  # makes numpy leave array + jet to Jet.__radd__

    def __init__(self, c: np.ndarray) -> None:
        self.c = c

    @property
    def value(self) -> np.ndarray:
        """The value at ε = 0 without variations, shape (…)."""
        return np.asarray(self.c[0, 0])

    @property
    def T(self) -> Jet:
        """The transposed matrix."""
        return Jet(np.swapaxes(self.c, -1, -2))

    def __repr__(self) -> str:
        orders, duals, *shape = self.c.shape
        size = f"order={orders - 1}, directions={duals - 1}, shape={tuple(shape)}"
        return f"Jet({size}, value={self.value})"

    def __getitem__(self, index: Any) -> Jet:
        trailing = index if isinstance(index, tuple) else (index,)
        both = (slice(None), slice(None), *trailing)
        return Jet(self.c[both])

    def __add__(self, other: Any) -> Jet:
        a, b = _align(self, other)
        return Jet(a + b)

    __radd__ = __add__

    def __neg__(self) -> Jet:
        return Jet(-self.c)

    def __pos__(self) -> Jet:
        return self

    def __sub__(self, other: Any) -> Jet:
        return self.__add__(-other)

    def __rsub__(self, other: Any) -> Jet:
        return (-self).__add__(other)

    def __mul__(self, other: Any) -> Jet:
        if isinstance(other, Jet):
            return _multiply(self, other, np.multiply)
        return Jet(_pad(self.c, np.ndim(other)) * other)

    __rmul__ = __mul__

    def __matmul__(self, other: Any) -> Jet:
        return _multiply(self, other, np.matmul) if isinstance(other, Jet) else Jet(self.c @ other)

    def __rmatmul__(self, other: Any) -> Jet:
        return Jet(other @ self.c)

    def __truediv__(self, other: Any) -> Jet:
        return self * (other**-1 if isinstance(other, Jet) else 1 / np.asarray(other))

    def __rtruediv__(self, other: Any) -> Jet:
        return (self**-1).__mul__(other)

    def __pow__(self, exponent: float) -> Jet:
        p = int(exponent) if float(exponent).is_integer() else float(exponent)
        if isinstance(p, int) and p >= 0:
            result: Jet = Jet(np.zeros_like(self.c)) + 1.0
            for _ in range(p):
                result = result * self
            return result

        def series(u: np.ndarray, orders: int) -> list[np.ndarray]:
            y = [u**p]
            for k in range(1, orders):
                y.append(y[-1] * (p - k + 1) / (k * u))
            return y

        return self.compose(
            series if isinstance(p, float) else lambda u, n: series(np.asarray(u, dtype=float), n)
        )

    def compose(self, series: Callable[[np.ndarray, int], list[np.ndarray]]) -> Jet:
        """Return f(self) for a function f given by its Taylor coefficients."""
        orders = len(self.c)
        f = series(self.value, orders + 1)
        # less its value a jet is nilpotent: ε^orders and products of two variations vanish
        small = Jet(self.c.copy())
        small.c[0, 0] = 0.0
        result = small * f[1]
        power = small
        for coefficient in f[2:]:
            power = power * small
            result = result + power * coefficient
        return result + f[0]

    def ddt(self) -> Jet:
        """Return the derivative along the path, a jet of one order less."""
        k = np.arange(1, len(self.c)).reshape(-1, *[1] * (self.c.ndim - 1))
        return Jet(k * self.c[1:])

    def trace_with(self, other: Jet) -> Jet:
        """Return Σᵢⱼ Aᵢⱼ Bᵢⱼ = tr(A Bᵀ) over the last two axes."""
        return Jet((self * other).c.sum(axis=(-2, -1)))

    def sin(self) -> Jet:
        """Return the sine."""
        return self.compose(lambda u, n: _expand_circular(np.sin(u), np.cos(u), n))

    def cos(self) -> Jet:
        """Return the cosine."""
        return self.compose(lambda u, n: _expand_circular(np.cos(u), -np.sin(u), n))

    def tan(self) -> Jet:
        """Return the tangent, from y' = 1 + y²."""
        return self.compose(lambda u, n: _expand_riccati(np.tan(u), 1.0, n))

    def tanh(self) -> Jet:
        """Return the hyperbolic tangent, from y' = 1 − y²."""
        return self.compose(lambda u, n: _expand_riccati(np.tanh(u), -1.0, n))

    def sqrt(self) -> Jet:
        """Return the square root."""
        return self**0.5

    def exp(self) -> Jet:
        """Return the exponential."""
        return self.compose(lambda u, n: [np.exp(u) / _factorial(k) for k in range(n)])

    def log(self) -> Jet:
        """Return the natural logarithm."""
        return self.compose(lambda u, n: [np.log(u), *(-((-1 / u) ** k) / k for k in range(1, n))])

    def asin(self) -> Jet:
        """Return the arc sine."""
        return self._integrate(np.arcsin(self.value), lambda u: Jet.__pow__(1.0 - u * u, -0.5))

    def acos(self) -> Jet:
        """Return the arc cosine."""
        return self._integrate(np.arccos(self.value), lambda u: -Jet.__pow__(1.0 - u * u, -0.5))

    def atan(self) -> Jet:
        """Return the arc tangent."""
        return self._integrate(np.arctan(self.value), lambda u: Jet.__pow__(1.0 + u * u, -1))

    def atan2(self, x: Any) -> Jet:
        """Return the angle of the point (x, self)."""
        x0 = x.value if isinstance(x, Jet) else np.asarray(x)
        return _find_angle(self, x, self.value, x0).__add__(np.arctan2(self.value, x0))

    def Abs(self) -> Jet:
        """Return the absolute value; its derivative is the sign, 0 at 0."""
        return self.__mul__(np.sign(self.value))

    def sign(self) -> Jet:
        """Return the sign; its derivative is 0."""
        return Jet(np.zeros_like(self.c)).__add__(np.sign(self.value))

    def _integrate(self, value: np.ndarray, slope: Callable[[Jet], Jet]) -> Jet:
        """Return f(self), given f(u) and f': the coefficients of f' are those of f, shifted."""

        def series(u: np.ndarray, orders: int) -> list[np.ndarray]:
            line = np.zeros((orders, 1, *u.shape))
            line[0, 0], line[1, 0] = u, 1.0
            rate = slope(Jet(line)).c[:, 0]
            return [value, *(rate[k] / (k + 1) for k in range(orders - 1))]

        return self.compose(series)


def _find_angle(y: Any, x: Any, y0: np.ndarray, x0: np.ndarray) -> Jet:
    """Return the angle from (x0, y0) to (x, y), which is small and has no branch cut nearby."""
    ratio: Jet = (y * x0 - x * y0) / (x * x0 + y * y0)
    return ratio.atan()


def _pad(c: np.ndarray, trailing: int) -> np.ndarray:
    """Insert axes into coefficients so that they broadcast against a trailing shape."""
    missing = trailing - (c.ndim - 2)
    return c.reshape(*c.shape[:2], *[1] * missing, *c.shape[2:]) if missing > 0 else c


def _align(a: Jet, b: Any) -> tuple[np.ndarray, np.ndarray]:
    """Return the coefficients of both, cut to the lower order and shaped to broadcast."""
    if not isinstance(b, Jet):
        c = np.zeros((*a.c.shape[:2], *np.shape(b)))
        c[0, 0] = b
        b = Jet(c)
    orders, trailing = min(len(a.c), len(b.c)), max(a.c.ndim, b.c.ndim) - 2
    return _pad(a.c[:orders], trailing), _pad(b.c[:orders], trailing)


def _multiply(
    first: Jet, second: Jet, times: Callable[[np.ndarray, np.ndarray], np.ndarray]
) -> Jet:
    """Multiply by the Cauchy product in ε and the Leibniz rule in the partial derivatives."""
    orders = min(len(first.c), len(second.c))
    if times is np.multiply:
        a, b = _align(first, second)
    else:
        a, b = first.c[:orders], second.c[:orders]
    total = _leibniz(a[0], b, times)
    for i in range(1, orders):
        total[i:] += _leibniz(a[i], b[: orders - i], times)
    return Jet(total)


def _leibniz(
    a: np.ndarray, b: np.ndarray, times: Callable[[np.ndarray, np.ndarray], np.ndarray]
) -> np.ndarray:
    """Multiply one coefficient by many, with their partial derivatives."""
    product = times(a, b[:, :1])
    product[:, 1:] += times(a[:1], b[:, 1:])
    return product


def _expand_circular(f: np.ndarray, slope: np.ndarray, orders: int) -> list[np.ndarray]:
    """Return the Taylor coefficients of a function with f'' = −f."""
    cycle = (f, slope, -f, -slope)
    return [cycle[k % 4] / _factorial(k) for k in range(orders)]


def _expand_riccati(y0: np.ndarray, sign: float, orders: int) -> list[np.ndarray]:
    """Return the Taylor coefficients of the solution of y' = 1 ± y²."""
    y = [y0]
    for k in range(orders - 1):
        square = sum(y[i] * y[k - i] for i in range(k + 1))
        y.append(((k == 0) + sign * square) / (k + 1))
    return y


def _factorial(k: int) -> float:
    return float(np.prod(np.arange(1, k + 1)))
