"""Units and the dimensions they stand for: read, said, and found for expressions.

A dimension is the tuple of its exponents of kg, m, s, A and K; a radian is a pure number, as in the
SI (The International System of Units, 9th edition, 2019, sect. 2.3.4).

A number is taken in the unit that its place asks for, and so is a product with a decimal number,
e.g. 9.81*m or 0.3*t, or one that names nothing with a declared unit, e.g. 2*x. In other products,
whole numbers and fractions are pure.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass
from fractions import Fraction
from functools import cache
from typing import TypeAlias, final

from mecanique.errors import InputError
from mecanique.model.expression import Scalar

Dimension: TypeAlias = "tuple[Fraction | int, ...]"
"""Exponents of kg, m, s, A and K."""

PURE: Dimension = (0, 0, 0, 0, 0)
"""Of a pure number or an angle."""

_BASE = ("kg", "m", "s", "A", "K")

_UNITS: dict[str, Dimension] = {
    "kg": (1, 0, 0, 0, 0),
    "m": (0, 1, 0, 0, 0),
    "s": (0, 0, 1, 0, 0),
    "A": (0, 0, 0, 1, 0),
    "K": (0, 0, 0, 0, 1),
    "1": PURE,
    "rad": PURE,
    "sr": PURE,
    "Hz": (0, 0, -1, 0, 0),
    "N": (1, 1, -2, 0, 0),
    "Pa": (1, -1, -2, 0, 0),
    "J": (1, 2, -2, 0, 0),
    "W": (1, 2, -3, 0, 0),
    "C": (0, 0, 1, 1, 0),
    "V": (1, 2, -3, -1, 0),
    "Ω": (1, 2, -3, -2, 0),
    "H": (1, 2, -2, -2, 0),
    "F": (-1, -2, 4, 2, 0),
    "Wb": (1, 2, -2, -1, 0),
    "T": (1, 0, -2, -1, 0),
}
"""The units of the SI without prefixes."""

_INSTEAD = {
    **dict.fromkeys(("mm", "cm", "dm", "km", "µm", "in", "inch", "ft", "foot", "furlong"), "m"),
    **dict.fromkeys(("g", "mg", "t", "lb"), "kg"),
    **dict.fromkeys(("ms", "µs", "min", "h"), "s"),
    **dict.fromkeys(("deg", "degree", "degrees", "°", "rev", "grad"), "rad"),
    **dict.fromkeys(("kN", "mN", "MN", "lbf", "kgf"), "N"),
    **dict.fromkeys(("rpm", "1/min"), "rad/s"),
    **dict.fromkeys(("kPa", "MPa", "GPa", "bar"), "Pa"),
    **dict.fromkeys(("kJ", "eV", "cal"), "J"),
}
"""What to state instead of units that are not of the SI, or have a prefix."""

_SAID = (
    *("1", "kg", "m", "s", "N", "N·m", "N/m", "N·s/m", "N·m·s", "kg·m", "kg·m²", "kg·m/s"),
    *("kg·m²/s", "m/s", "m/s²", "1/s", "1/s²", "m²", "m³", "Pa", "W", "A", "V", "Ω", "K"),
)
"""Units that are said by these names; the first of a dimension counts."""

_TOKEN = re.compile(r"\s*(\*\*|[*·⋅/()^]|[+-]?\d+|[⁺⁻⁰¹²³⁴-⁹]+|[A-Za-zΩµμ]+|[°%])\s*|(?P<wrong>.)")
_RAISED = str.maketrans("⁺⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "+-0123456789")


@final
class HomogeneityError(Exception):
    """What does not fit in an expression, in words."""


@final
@dataclass(frozen=True)
class Dimensions:
    """The dimensions of a mechanism's letters; those of expressions follow."""

    declared: Mapping[str, Dimension]  # of each parameter and input with a declared unit, by symbol
    # of coordinates, velocities and time, by name; what is not known is left out
    states: Mapping[str, Dimension]

    def of(self, scalar: Scalar) -> Dimension | None:
        """Return the dimension of an expression; None where numbers or letters leave it open."""
        if isinstance(scalar, float) or scalar.is_number:
            return PURE
        if scalar.is_Symbol:
            return self.declared.get(scalar.name, self.states.get(scalar.name))
        if scalar.is_Add:
            return self._of_sum(scalar)
        if scalar.is_Mul:
            return self._of_product(scalar)
        if scalar.is_Pow:
            return self._of_power(scalar)
        return self._of_function(scalar)

    def declares(self, scalar: Scalar) -> bool:
        """Whether an expression names anything with a declared unit."""
        if isinstance(scalar, float):
            return False
        return any(symbol.name in self.declared for symbol in scalar.free_symbols)

    def refuse(self, scalar: Scalar, unit: str) -> None:
        """Raise if an expression has another unit than its place asks for."""
        dimension = self.of(scalar)
        if dimension is None or dimension == read_unit(unit) or not self.declares(scalar):
            return
        raise HomogeneityError(
            f"{scalar} is in {say_unit(dimension)}, expected {unit}{_hint(scalar)}"
        )

    def _of_sum(self, scalar: Scalar) -> Dimension | None:
        stated = [(term, self.of(term)) for term in scalar.args]
        common, *others = {its for _, its in stated}
        if not others:
            return common
        known = [(term, its) for term, its in stated if its is not None and not term.is_number]
        named = [(term, its) for term, its in known if self.declares(term)]
        if not named:
            return None
        first, its = min(named, key=lambda pair: str(pair[0]))
        for term, different in known:
            if different != its:
                raise HomogeneityError(
                    f"{scalar} adds {first} [{say_unit(its)}] and {term} [{say_unit(different)}]"
                    f"{_hint(first) or _hint(term)}"
                )
        return its

    def _of_product(self, scalar: Scalar) -> Dimension | None:
        factors = [self.of(factor) for factor in scalar.args]
        coefficient = scalar.args[0]
        if coefficient.is_Float:
            return None
        if coefficient.is_number and abs(coefficient) != 1 and not self.declares(scalar):
            return None
        total = PURE
        for its in factors:
            if its is None:
                return None
            total = _multiply(total, its)
        return total

    def _of_power(self, scalar: Scalar) -> Dimension | None:
        base, exponent = self.of(scalar.base), scalar.exp
        if not exponent.is_number:
            self._refuse_unit(exponent, f"the exponent {exponent}")
            self._refuse_unit(scalar.base, f"{scalar.base}, whose exponent is no number,")
            return PURE
        if base is None or base == PURE:
            return base
        power = _power(exponent)
        return tuple(_whole(x * power) for x in base)

    def _of_function(self, scalar: Scalar) -> Dimension | None:
        name = type(scalar).__name__
        if name == "Abs":
            return self.of(scalar.args[0])
        if name == "sign":
            self.of(scalar.args[0])
            return PURE
        if name == "atan2":
            y, x = map(self.of, scalar.args)
            both = all(map(self.declares, scalar.args))
            if both and x is not None and y is not None and x != y:
                raise HomogeneityError(
                    f"{scalar} compares {scalar.args[0]} [{say_unit(y)}] with "
                    f"{scalar.args[1]} [{say_unit(x)}]"
                )
            return PURE
        for argument in scalar.args:
            self._refuse_unit(argument, f"{argument}, of which {name} is taken,")
        return PURE

    def _refuse_unit(self, scalar: Scalar, what: str) -> None:
        dimension = self.of(scalar)
        if dimension not in (None, PURE) and self.declares(scalar):
            raise HomogeneityError(
                f"{what} is in {say_unit(dimension)}, expected rad or a pure number"
            )


@cache
def read_unit(unit: str) -> Dimension:
    """Return the dimension of a unit, e.g. "kg·m²", "N*m/rad" or "m/s^2"."""
    tokens = [match[1] or match["wrong"] for match in _TOKEN.finditer(unit)]
    dimension, rest = _product(tokens, unit)
    if rest or not tokens:
        raise _unreadable(unit)
    return dimension


def divide(a: Dimension, b: Dimension) -> Dimension:
    """Return the dimension of a quotient."""
    return tuple(x - y for x, y in zip(a, b, strict=True))


@cache
def say_unit(its: Dimension) -> str:
    """Return a unit of a dimension, e.g. "N/m"."""
    for unit in _SAID:
        if read_unit(unit) == its:
            return unit
    above = [_raise_to(name, x) for name, x in zip(_BASE, its, strict=True) if x > 0]
    below = [_raise_to(name, -x) for name, x in zip(_BASE, its, strict=True) if x < 0]
    under = "·".join(below)
    if len(below) > 1:
        under = f"({under})"
    return "·".join(above or ["1"]) + (f"/{under}" if below else "")


def _multiply(a: Dimension, b: Dimension) -> Dimension:
    return tuple(x + y for x, y in zip(a, b, strict=True))


def _product(tokens: list[str], unit: str) -> tuple[Dimension, list[str]]:
    """Read factors up to the end or a closing parenthesis; units that touch are multiplied."""
    total, divides = PURE, False
    while tokens and tokens[0] != ")":
        if tokens[0] in ("*", "·", "⋅", "/"):
            divides = tokens[0] == "/"
            tokens = tokens[1:]
        factor, tokens = _factor(tokens, unit)
        total = divide(total, factor) if divides else _multiply(total, factor)
        divides = False
    return total, tokens


def _factor(tokens: list[str], unit: str) -> tuple[Dimension, list[str]]:
    if not tokens:
        raise _unreadable(unit)
    name, *rest = tokens
    if name == "(":
        its, rest = _product(rest, unit)
        if not rest:
            raise _unreadable(unit)
        rest = rest[1:]
    elif name in _UNITS:
        its = _UNITS[name]
    else:
        raise _unreadable(unit, name)
    if rest and rest[0] in ("^", "**"):
        rest = rest[1:]
        if not rest or not rest[0].lstrip("+-").isdecimal():
            raise _unreadable(unit)
    elif not (rest and rest[0][0] in "⁺⁻⁰¹²³⁴⁵⁶⁷⁸⁹"):
        return its, rest
    exponent = int(rest[0].translate(_RAISED))
    return tuple(x * exponent for x in its), rest[1:]


def _unreadable(unit: str, name: str = "") -> InputError:
    if name in _INSTEAD:
        return InputError(
            f"expected a unit of the SI without a prefix, got {unit!r}; state the value in "
            f"{_INSTEAD[name]}"
        )
    part = f" ({name!r} is unknown)" if name.isalpha() and name != unit else ""
    return InputError(
        f"expected an SI unit, e.g. 'kg·m²', 'N·m/rad' or '1' for a pure number, got {unit!r}{part}"
    )


def _raise_to(name: str, exponent: Fraction | int) -> str:
    if exponent == 1:
        return name
    sign = {"2": "²", "3": "³", "4": "⁴"}.get(str(exponent))
    return f"{name}{sign}" if sign else f"{name}^{exponent}"


def _whole(x: Fraction | int) -> Fraction | int:
    return x if isinstance(x, int) or x.denominator > 1 else int(x)


def _power(exponent: Scalar) -> Fraction | int:
    if exponent.is_Integer:
        return int(exponent)
    if exponent.is_Rational:
        return Fraction(int(exponent.p), int(exponent.q))
    return Fraction(float(exponent)).limit_denominator(1000)


def _hint(term: Scalar) -> str:
    """What may be meant where a whole number is a factor."""
    coefficient = term.as_coeff_Mul()[0]
    if coefficient.is_Integer and abs(coefficient) > 1:
        return f" ({coefficient} counts as a pure number; a Parameter can have a unit)"
    return ""
