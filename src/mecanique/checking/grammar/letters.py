"""The letters of a mechanism, and their various spellings."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from types import MappingProxyType
from typing import Literal, TypeAlias, final

from mecanique.checking.grammar.tree import FUNCTIONS, Node, letter, number
from mecanique.model.mechanism import Mechanism
from mecanique.model.mechanism.description import angles
from mecanique.model.mechanism.letters import SplitName, letters_of_words

Kind: TypeAlias = Literal[
    "coordinate", "velocity", "acceleration", "parameter", "input", "time", "constant", "other"
]
"""The kind of quantity that a letter denotes."""

SPELLINGS = {
    **{other: name for name, known in FUNCTIONS.items() for other in known.spellings},
    **{name.title(): name for name in FUNCTIONS if name != "atan2"},
}
"""Other names of functions."""

_VARIANTS = {
    "vartheta": "theta",
    "varphi": "phi",
    "varepsilon": "epsilon",
    "varrho": "rho",
    "ell": "l",
    "lamda": "lambda",
    "Pi": "pi",
}
_DOTTED = re.compile(r"(?P<stem>.+?)_?(?P<dots>dotdot|ddot|dot|dd|d)")


def key_of(name: str) -> str:
    """Return a name's spelling for comparison: theta_1, θ₁ and theta1 are the same letter."""
    taken = SplitName.of(name)
    base = _VARIANTS.get(taken.base, taken.base)
    subscript = re.sub(r"[_{},\s]", "", taken.subscript)
    return f"{base}{subscript}" + "'" * taken.dots


@final
@dataclass(frozen=True)
class KnownLetters:
    """The letters that formulas may contain, with their meanings."""

    kinds: Mapping[str, Kind]  # kind of each letter, by its name in the mechanism's own equations
    rates: Mapping[str, str]  # name of the rate of each letter that has one
    angles: frozenset[str] = frozenset()
    # letters defined by formulas in others, with their rates
    defined: Mapping[str, Node] = field(default_factory=dict)
    # functions that are written with a letter of their own in a question
    functions: Mapping[str, str] = field(default_factory=dict)
    # the name of each coordinate that is printed by another letter, by that letter
    printed: Mapping[str, str] = field(default_factory=dict)

    @classmethod
    def of(
        cls,
        mechanism: Mechanism,
        others: Iterable[str] = (),
        functions: Mapping[str, str] = MappingProxyType({}),
    ) -> KnownLetters:
        """Return the letters of a mechanism."""
        kinds: dict[str, Kind] = {"t": "time", "pi": "constant"}
        kinds |= dict.fromkeys(others, "other")
        rates: dict[str, str] = {}
        for name in mechanism.coordinates:
            kinds[name] = "coordinate"
            if f"{name}'" in mechanism.velocities:
                rates[name] = f"{name}'"
        for name in mechanism.velocities:
            kinds[name] = "velocity"
            kinds[f"{name}'"] = "acceleration"
            rates[name] = f"{name}'"
        kinds |= {parameter.symbol: "parameter" for parameter in mechanism.parameters}
        kinds |= {signal.symbol: "input" for signal in mechanism.inputs}
        turning = angles(mechanism) & set(mechanism.coordinates)
        turning |= {p.symbol for p in mechanism.parameters if p.unit in ("rad", "deg", "°")}
        words = letters_of_words(mechanism).items()
        printed = {letter: name for name, letter in words if name in rates}
        return cls(kinds, rates, frozenset(turning), functions=functions, printed=printed)

    def define(self, name: str, formula: Node, rates: Mapping[str, Node]) -> KnownLetters:
        """Return these letters with one more that is defined by a formula."""
        moves = any(not rate.is_zero for rate in rates.values())
        kinds: dict[str, Kind] = {**self.kinds, name: "coordinate" if moves else "parameter"}
        chain = dict(self.rates)
        previous = name
        for rate in rates if moves else ():
            kinds[rate] = "velocity" if rate.count("'") == 1 else "acceleration"
            chain[previous] = rate
            previous = rate
        turning = self.angles | ({name} if formula.letters & self.angles else set())
        defined = {**self.defined, name: formula, **rates}
        return replace(self, kinds=kinds, rates=chain, angles=turning, defined=defined)

    @cached_property
    def by_key(self) -> dict[str, str]:
        """The name of each letter, by its spelling for comparison."""
        known = {key_of(name): name for name in self.kinds}
        for printed, name in self.printed.items():
            for dots in ("", "'", "''"):
                known.setdefault(key_of(printed + dots), name + dots)
        return known

    @cached_property
    def longest(self) -> int:
        """The length of the longest word that may occur among letters written without spaces."""
        words = [*self.by_key, *FUNCTIONS, *SPELLINGS]
        return max(map(len, words)) + len("dotdot")

    def find(self, word: str) -> str | None:
        """Return the name of the letter that a word denotes, None if there is no such letter."""
        key = key_of(word)
        if key in self.by_key:
            return self.by_key[key]
        dotted = _DOTTED.fullmatch(word)
        if dotted:
            stem = self.by_key.get(key_of(dotted["stem"]))
            if stem is not None and self.kinds[stem] in ("coordinate", "velocity"):
                primes = 2 if dotted["dots"] in ("dotdot", "ddot", "dd") else 1
                return self.by_key.get(key_of(stem + "'" * primes))
        if re.match("p[^\\x00-\\xff]", word) and self.kinds.get("p") != "parameter":
            # pφ is the momentum of φ, no product
            return self.by_key.get(key_of(f"p_{word[1:]}"))
        return None

    def node(self, name: str) -> Node:
        """Return a letter's definition in the mechanism's own letters."""
        if name == "pi":
            return letter("pi")
        return self.defined.get(name, letter(name))

    @property
    def rate_nodes(self) -> dict[str, Node | None]:
        """The rate of each of the mechanism's letters that vary; None if it is not known."""
        rates: dict[str, Node | None] = {
            name: None for name, kind in self.kinds.items() if kind in ("acceleration", "input")
        }
        return rates | {name: letter(rate) for name, rate in self.rates.items()} | {"t": number(1)}
