"""Find at which speeds a steady motion becomes stable, or ceases to be.

Deviations e^(λ t) have a characteristic polynomial in λ, with coefficients a. On a border of
stability an exponent is zero, where the lowest coefficient vanishes, or two are imaginary, where
Hurwitz's determinant vanishes (A. Hurwitz, Math. Ann. 46 (1895) 273).
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

import numpy as np

from mecanique.derivation.printing.equations import expression
from mecanique.derivation.printing.writers import Root
from mecanique.derivation.scalars.evaluation import evaluate
from mecanique.derivation.scalars.series import Ring, Series
from mecanique.derivation.symbolic.derivation import NO_ENDING, Ending
from mecanique.derivation.symbolic.multipliers import Quotient, determinant, make_positive
from mecanique.derivation.tolerances import SAME_EXPONENT

_POLYNOMIAL = "Of deviations proportional to exp({0} t), the determinant is {1} = 0."
_BORDERS = {
    "c": "{0} {1}, where {2} = 0, a deviation grows without oscillation (of a bicycle, capsize).",
    "w": "{0} {1}, where {2} = 0, an oscillation grows (of a bicycle, weave).",
}
_MEANINGS = {
    "c": "speed at which a constant deviation stays",
    "w": "speed at which an oscillation neither grows nor decays",
}
_APART = 1e-3
"""Relative distance from a border at which stability is judged."""


def find_borders(
    rows: Sequence[Sequence[Series]],
    exponent: str,
    speed: str,
    values: Mapping[str, float],
    unit: str,
) -> Ending:
    """Return the speeds at which stability changes, in letters where they are short."""
    ring = rows[0][0].ring
    powers = determinant(ring, rows).coefficients([exponent])
    a = {n: coefficient for (n,), coefficient in powers.items() if coefficient}
    conditions = {"c": (f"a{min(a)}", a[min(a)]), **_find_oscillation(a)}
    borders = []
    for letter, (condition, series) in conditions.items():
        for border in _find_roots(series, speed, values):
            below = _growth(a, speed, values, border * (1 - _APART))
            above = _growth(a, speed, values, border * (1 + _APART))
            if (below > SAME_EXPONENT) != (above > SAME_EXPONENT):
                borders.append((border, letter, condition, "Above" if above > below else "Below"))
    if not borders:
        return NO_ENDING
    terms = " + ".join(f"a{n} {exponent}^{n}" for n in sorted(a, reverse=True) if n)
    terms = terms.replace(f"{exponent}^1", exponent)
    said = [_POLYNOMIAL.format(exponent, f"{terms} + a0" if 0 in a else terms)]
    lines = []
    unknowns = dict.fromkeys((f"a{n}" for n in sorted(a)), "coefficient of the determinant")
    for border, letter, condition, side in sorted(borders):
        name = f"{speed}_{letter}"
        square = _solve(a[min(a)], speed) if letter == "c" else None
        said.append(_BORDERS[letter].format(side, name, condition))
        lines.append(Root(name, square and square.expression(), f"{border:.5g}"))
        unknowns[name] = f"{_MEANINGS[letter]}{unit}"
    return Ending(" ".join(said), tuple(lines), unknowns)


def _find_oscillation(a: Mapping[int, Series]) -> dict[str, tuple[str, Series]]:
    """Return Hurwitz's determinant, as text in the coefficients and as a series."""
    lowest, order = min(a), max(a) - min(a)
    if order < 2 or not any((n - lowest) % 2 for n in a):
        return {}
    letters = Ring()
    named = {n: letters.parameter(f"a{n}") for n in a}

    def hurwitz(of: Mapping[int, Series], ring: Ring) -> Series:
        size, zero = range(order - 1), ring.number(0)

        def line_up(shift: int) -> list[Series]:
            return [of.get(max(a) - 1 - 2 * k + shift, zero) for k in size]

        return determinant(ring, [*map(line_up, size)])

    ring = a[lowest].ring
    return {"w": (expression(hurwitz(named, letters)).text(), hurwitz(a, ring))}


def _find_roots(series: Series, speed: str, values: Mapping[str, float]) -> Iterator[float]:
    """Yield the positive speeds at which a polynomial in the speed vanishes."""
    powers = {n: evaluate(part, values) for (n,), part in series.coefficients([speed]).items()}
    falling = [powers.get(n, 0.0) for n in range(max(powers), min(powers) - 1, -1)]
    for root in np.roots(falling):
        if abs(root.imag) <= SAME_EXPONENT * abs(root) and root.real > 0:
            yield float(root.real)


def _growth(a: Mapping[int, Series], speed: str, values: Mapping[str, float], at: float) -> float:
    """Return the largest real part of an exponent, relative to the largest exponent."""
    numbers = {**values, speed: at}
    falling = [evaluate(a[n], numbers) if n in a else 0.0 for n in range(max(a), min(a) - 1, -1)]
    exponents = np.roots(falling)
    return float(exponents.real.max() / np.abs(exponents).max())


def _solve(series: Series, speed: str) -> Quotient | None:
    """Return the square of the speed at which A u² + B, or that times a power of u, vanishes."""
    powers = {n: part for (n,), part in series.coefficients([speed]).items()}
    low, high = min(powers), max(powers)
    if high - low != 2 or len(powers) > 2:
        return None
    below, above = make_positive([powers[high], -powers[low]])
    return Quotient(above, below)
