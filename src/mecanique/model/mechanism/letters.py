"""Letters for the names of quantities: Greek ones, words as letters, subscripts and dots."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import final

from mecanique.errors import InputError, UnknownNameError
from mecanique.model.mechanism.description import Description, angles

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


_USUAL = {
    **dict.fromkeys(("yaw", "heading"), "psi"),
    **dict.fromkeys(("roll", "spin", "turn", "turned", "precession", "rotation"), "phi"),
    **dict.fromkeys(("pitch", "lean", "tilt", "nutation", "swing"), "theta"),
    **dict.fromkeys(("steer", "steering"), "delta"),
}
"""The letter that books have for an angle that is called by a word."""

_SPARE = ("phi", "theta", "psi", "alpha", "beta", "gamma", "chi")
_OF_COORDINATES = ("", "δ", "p_", "P_", "pi_", "Q_", "W_", "δW_", "sin_", "cos_")
"""Beginnings of the names of a coordinate and of what has it as the subscript."""

_WORD = re.compile(r"(?:(?P<whose>[a-z]{2,})_)?(?P<word>[a-z]{3,})")


@lru_cache(maxsize=64)
def letters_of_words(mechanism: Description) -> Mapping[str, str]:
    """Return a letter for each angle, of the coordinates or given, that is called by a word.

    It is the usual one or another that is free; where the word is a body's, or anything's that has
    no usual one, it is the subscript: yaw is psi, rear_spin phi_rear, crank phi_crank. So are those
    of momenta and generalized forces, p_psi for p_yaw.
    """
    lengths, turning = set(mechanism.coordinates) - angles(mechanism), list[str]()
    for joint in mechanism.joints:
        turning += () if joint.quaternion else joint.angular_coordinates
    turning += [p.symbol for p in mechanism.parameters if p.unit in ("rad", "deg", "°")]
    ordered = dict.fromkeys([*mechanism.coordinates, *turning])
    words = {name: _WORD.fullmatch(name) for name in ordered if name not in lengths}
    known = {*GREEK, *_NICKNAMES}
    wordy = {name: m for name, m in words.items() if m and known.isdisjoint((*m.groups(), name))}
    inputs = (signal.symbol for signal in mechanism.inputs)
    given = {*ordered, *mechanism.values, *inputs} - wordy.keys()
    taken = {SplitName.of(name) for name in given}
    if mechanism.rolls:
        taken.add(SplitName("psi", "", 0))  # of conditions on velocities
    letters: dict[str, str] = {}
    # a usual letter goes to whoever has it, before the spare ones are given away
    for spare in ((), _SPARE):
        for name, match in wordy.items():
            usual = _USUAL.get(match["word"])
            whose = match["whose"] if usual else name
            if name in letters or (match["whose"] and not usual):
                continue
            for base in (usual or "phi", *spare):
                letter = f"{base}_{whose}" if whose else base
                if SplitName.of(letter) not in taken:
                    letters[name] = letter
                    taken.add(SplitName.of(letter))
                    break
    pairs = ((of + name, of + letter) for name, letter in letters.items() for of in _OF_COORDINATES)
    return {name: letter for name, letter in pairs if name not in given}


def to_letter(name: str, letters: Mapping[str, str]) -> str:
    """Return a name, with primes or without, by its letter if it has one."""
    stem = name.rstrip("'")
    return letters.get(stem, stem) + name[len(stem) :]


@lru_cache(maxsize=64)
def _list_names(mechanism: Description) -> Mapping[SplitName, str]:
    """Return the name of each coordinate by how it is printed."""
    m, letters = mechanism, letters_of_words(mechanism)
    names = [*m.coordinates, *m.coordinates.driven, *(v.rstrip("'") for v in m.velocities)]
    named = {SplitName.of(letters[name]): name for name in names if name in letters}
    return named | {SplitName.of(name): name for name in names}


def to_name(mechanism: Description, typed: str) -> str:
    """Return the name of a coordinate, or of its rate, that is typed as it is printed.

    ψ or psi is yaw where that is its letter, θ₁ is theta1; what is no such letter is returned.
    """
    if not isinstance(typed, str):
        raise InputError(f"expected values by name, got {typed!r} for a name")
    stem = typed.rstrip("'")
    known = stem in mechanism.coordinates or typed in mechanism.velocities
    named = {} if known else _list_names(mechanism)
    return named.get(SplitName.of(stem), stem) + typed[len(stem) :]


def find_name(
    mechanism: Description, typed: str, names: Iterable[str], kind: str = "coordinate"
) -> str:
    """Return which of some names is typed, as it is or as it is printed, or raise."""
    name = typed if typed in names else to_name(mechanism, typed)
    if name not in names:
        raise UnknownNameError(kind, typed, names)
    return name


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
