"""Find units that do not match: terms of a sum that are quantities of different kinds."""

from __future__ import annotations

from collections.abc import Mapping
from fractions import Fraction
from types import MappingProxyType
from typing import final

from mecanique.checking.grammar.tree import Node
from mecanique.model.mechanism import Mechanism
from mecanique.model.mechanism.homogeneity import dimensions_of
from mecanique.model.units import PURE, Dimension, divide, read_unit, say_unit


@final
class UnitMisfitError(Exception):
    """A part whose unit does not match."""

    def __init__(self, part: Node, text: str) -> None:
        super().__init__(text)
        self.part = part
        self.text = text


@final
class LetterUnits:
    """The dimensions of a mechanism's letters, and those of formulas in them."""

    def __init__(
        self,
        mechanism: Mechanism,
        asked: Mapping[str, Dimension] = MappingProxyType({}),
        *,
        with_numbers: bool = False,
    ) -> None:
        # where numbers hide units, so may the 1 that is not written in cos(t)
        self._simple = 0 if with_numbers else _SIMPLE
        known = dimensions_of(mechanism)
        moving = (*mechanism.coordinates, *mechanism.velocities, "t")
        states = {name: known.states[name] for name in moving if name in known.states}
        rates = {
            f"{v}'": divide(states[v], states["t"]) for v in mechanism.velocities if v in states
        }
        self.of: dict[str, Dimension] = {**asked, "pi": PURE, **known.declared, **states, **rates}

    def find(self, node: Node, text: str) -> Dimension | None:
        """Return the dimension of a formula; None where a decimal number leaves it open."""
        match node.kind:
            case "number":
                return PURE if node.value.denominator <= self._simple else None
            case "letter":
                if node.name.startswith("["):
                    return read_unit(node.name[1:-1])
                return self.of.get(node.name)
            case "negative":
                return self.find(node.parts[0], text)
            case "sum":
                return self._of_sum(node, text)
            case "product":
                return self._of_product(node, text)
            case "quotient":
                above, below = (self.find(part, text) for part in node.parts)
                return _combine(above, below, -1)
            case "power":
                return self._of_power(node, text)
        return self._of_call(node, text)

    def describe(self, name: str, formula: Node) -> str:
        """Return in words the unit of the formula that defines a letter."""
        its = self.find(formula, "")
        return f"{name} is defined in {say_unit(its)}" if its else f"see the definition of {name}"

    def list_odd(self, defined: Mapping[str, Node]) -> list[str]:
        """Return the letters that are defined by terms with different units."""
        odd = []
        for name, formula in defined.items():
            try:
                self.find(formula, "")
            except UnitMisfitError:
                odd.append(name)
        return odd

    def _of_sum(self, node: Node, text: str) -> Dimension | None:
        by_part = [(part, self.find(part, text)) for part in node.parts]
        known = [(part, its) for part, its in by_part if its is not None and part.letters]
        for part, its in known[1:]:
            first, expected = known[0]
            if its != expected:
                odd = [pair for pair in known if pair[1] == expected]
                # of several terms, the only different one is the likelier mistake
                alone = first if len(odd) == 1 and len(known) > 2 else part
                raise UnitMisfitError(
                    alone,
                    f"the units do not match: {_quote(first, text)} is in {say_unit(expected)}, "
                    f"{_quote(part, text)} in {say_unit(its)}",
                )
        return known[0][1] if known else None

    def _of_product(self, node: Node, text: str) -> Dimension | None:
        total: Dimension | None = PURE
        units = [part for part in node.parts if part.name.startswith("[")]
        for part in node.parts:
            # numbers with their unit behind them have no other
            if not units or (part.letters and part not in units):
                total = _combine(total, self.find(part, text), 1)
        stated: Dimension | None = PURE
        for unit in units:
            stated = _combine(stated, self.find(unit, text), 1)
        # what is in letters may say its unit, too: √(g/l) rad/s
        return total if total == stated else _combine(total, stated, 1)

    def _of_power(self, node: Node, text: str) -> Dimension | None:
        base, exponent = node.parts
        its = self.find(base, text)
        if its is None or exponent.kind not in ("number", "negative", "quotient"):
            return None
        value = _number(exponent)
        if value is None or max(abs(value.numerator), value.denominator) > _SIMPLE**2:
            return None
        return tuple(x * value for x in its)

    def _of_call(self, node: Node, text: str) -> Dimension | None:
        inner = [self.find(part, text) for part in node.parts]
        if node.name == "integral":
            return _combine(inner[0], inner[1], 1)
        if node.name in ("abs", "sign"):
            return inner[0] if node.name == "abs" else PURE
        if node.name == "sqrt":
            return None if inner[0] is None else tuple(Fraction(x) / 2 for x in inner[0])
        must_be_pure = self._simple and node.name != "atan2"
        if must_be_pure and inner[0] is not None and inner[0] != PURE:
            raise UnitMisfitError(
                node,
                f"the units do not match: the argument of {_quote(node, text)} is in "
                f"{say_unit(inner[0])}, expected an angle or a pure number",
            )
        return PURE


_SIMPLE = 10
"""A number with a larger denominator, such as 9.807, may stand for a quantity with a unit."""


def _number(node: Node) -> Fraction | None:
    if node.kind == "number":
        return node.value
    if node.kind == "negative":
        inner = _number(node.parts[0])
        return None if inner is None else -inner
    if node.kind == "quotient":
        above, below = map(_number, node.parts)
        return None if above is None or not below else above / below
    return None


def _combine(a: Dimension | None, b: Dimension | None, sign: int) -> Dimension | None:
    if a is None or b is None:
        return None
    return tuple(x + sign * y for x, y in zip(a, b, strict=True))


def _quote(node: Node, text: str) -> str:
    """Quote a part as it was written; a quantity in question may not be written at all."""
    written = node.quote(text)
    return f"'{written}'" if written else "the quantity in question"
