"""Split the names of quantities into base letter, subscript and dots, with Greek letters."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import final

_SPELLED = (
    "alpha beta gamma delta epsilon zeta eta theta iota kappa lambda mu nu xi omicron pi rho sigma "
    "tau upsilon phi chi psi omega Gamma Delta Theta Lambda Xi Pi Sigma Upsilon Phi Psi Omega"
)
_SIGNS = "α β γ δ ε ζ η θ ι κ λ μ ν ξ ο π ρ σ τ υ φ χ ψ ω Γ Δ Θ Λ Ξ Π Σ Υ Φ Ψ Ω"
GREEK = dict(zip(_SPELLED.split(), _SIGNS.split(), strict=True))
"""Greek letters by name."""

_NAMES = {sign: name for name, sign in GREEK.items()}
_NICKNAMES = {"th": "theta", "lam": "lambda", "eps": "epsilon"}
_SUBSCRIPTS = str.maketrans("₀₁₂₃₄₅₆₇₈₉", "0123456789")
_SHAPE = re.compile(r"(?P<base>[^\W\d_]+|.)(?:_?(?P<subscript>\w+))?")
_JOINED = re.compile(r"[A-Za-z][a-z]|[a-z][A-Z][A-Za-z]*|[IJK][A-Z][a-z]+", re.ASCII)
"""A letter with its subscript joined on: mw, mR, IBxx."""


@final
@dataclass(frozen=True)
class SplitName:
    """The parts of a name: "theta1''" is theta with subscript 1 and two dots."""

    base: str  # the letter or word; a Greek letter by its name
    subscript: str  # its subscript, "" for none; a Greek letter by its name
    dots: int  # number of time derivatives

    @classmethod
    def of(cls, name: str) -> SplitName:
        """Split a name into its parts."""
        stem = name.rstrip("'")
        shape = _SHAPE.fullmatch(stem.translate(_SUBSCRIPTS))
        base, subscript = (shape["base"], shape["subscript"] or "") if shape else (stem, "")
        if not subscript and base not in (*GREEK, *_NICKNAMES) and _JOINED.fullmatch(base):
            base, subscript = base[0], base[1:]
        return cls(_spell(base), _spell(subscript), len(name) - len(stem))


_PLAIN = re.compile(r"[a-z]{2,}(_[a-z]{2,})*")
"""Names that are words of a sentence: crank, rear_wheel."""


def call(name: str) -> str:
    """Return a name as sentences have it: "the rear wheel"; A, rod1 and psi as they are."""
    words = _PLAIN.fullmatch(name) is not None and name not in GREEK
    return f"the {name.replace('_', ' ')}" if words else name


def is_varied(name: str) -> bool:
    """Return whether a name denotes a virtual displacement or virtual work, e.g. "δq"."""
    return name.startswith("δ") and name[1:2].isalpha()


def _spell(word: str) -> str:
    return _NAMES.get(word) or _NICKNAMES.get(word, word)
