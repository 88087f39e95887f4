"""Jets: numbers that carry their motion and their variations.

A jet is a Taylor polynomial in the parameter ε of a path, each coefficient with its first-order
partial derivatives (duals), for any array of states at once. Arithmetic with jets is exact up to
rounding and has no step size to choose. It follows A. Griewank, A. Walther, Evaluating Derivatives,
2nd ed., SIAM 2008, chapters 3 and 13.
"""

from __future__ import annotations

from collections.abc import Callable
from math import factorial
from operator import methodcaller
from typing import Any, final

import numpy as np

from mecanique.model.expression import numpy_function
from mecanique.program.sweeps import SLOPES


def _by_slope(name: str) -> Callable[[Jet], Jet]:
    """Return the function of jets whose Taylor coefficients follow from its derivative in turn."""

    def series(u: np.ndarray, orders: int) -> list[np.ndarray]:
        x = np.zeros((orders, 1, *u.shape))
        x[0, 0], x[1, 0] = u, 1.0
        y = [numpy_function(name)(u)]
        for k in range(1, orders):
            rate = SLOPES[name](Jet(np.stack(y)[:, None]), Jet(x[:k]), methodcaller)
            y.append(rate.c[k - 1, 0] / k)
        return y

    return lambda jet: jet.compose(series)


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

    def constant(self, value: Any) -> Jet:
        """Return a number, or an array, as a jet of as many orders and directions."""
        c = np.zeros((*self.c.shape[:2], *np.shape(value)))
        c[0, 0] = value
        return Jet(c)

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

    def sqrt(self) -> Jet:
        """Return the square root."""
        return self**0.5

    exp, log = _by_slope("exp"), _by_slope("log")
    tan, tanh = _by_slope("tan"), _by_slope("tanh")
    asin, acos, atan = _by_slope("asin"), _by_slope("acos"), _by_slope("atan")

    def atan2(self, x: Any) -> Jet:
        """Return the angle of the point (x, self)."""
        y0, x0 = self.value, x.value if isinstance(x, Jet) else np.asarray(x)
        # the angle from (x0, y0) is small and has no branch cut nearby
        tangent: Jet = (self * x0 - x * y0) / (x * x0 + self * y0)
        return tangent.atan().__add__(np.arctan2(y0, x0))

    def Abs(self) -> Jet:
        """Return the absolute value; its derivative is the sign, 0 at 0."""
        return self.__mul__(np.sign(self.value))

    def sign(self) -> Jet:
        """Return the sign; its derivative is 0."""
        return Jet(np.zeros_like(self.c)).__add__(np.sign(self.value))


def _pad(c: np.ndarray, trailing: int) -> np.ndarray:
    """Insert axes into coefficients so that they broadcast against a trailing shape."""
    missing = trailing - (c.ndim - 2)
    return c.reshape(*c.shape[:2], *[1] * missing, *c.shape[2:]) if missing > 0 else c


def _align(a: Jet, b: Any) -> tuple[np.ndarray, np.ndarray]:
    """Return the coefficients of both, cut to the lower order and shaped to broadcast."""
    if not isinstance(b, Jet):
        b = a.constant(b)
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
    return [cycle[k % 4] / factorial(k) for k in range(orders)]
