"""Turn names of a mechanism into identifiers of any language, reversibly and without keywords.

Letters and digits remain; every other character is written as `_xHEX_`. Each kind of input has its
own prefix, and the rate θ' of a coordinate is `theta_dot`, e.g. `q_theta` and `v_theta_dot`.
"""

from __future__ import annotations

import re
from collections.abc import Iterable

from mecanique.errors import DerivationError, InputError

_ESCAPE = re.compile(r"_x([0-9a-f]+)_|_dot$")


def mangle(name: str) -> str:
    """Write a name in ASCII letters, digits and underscores."""
    body, dot = (name[:-1], "_dot") if name.endswith("'") else (name, "")
    plain = "".join(c if _is_plain(c) or c == "_" else _escape(c) for c in body) + dot
    if unmangle(plain) == name:
        return plain
    return "".join(c if _is_plain(c) else _escape(c) for c in body) + dot


def unmangle(identifier: str) -> str:
    """Return the name from which `mangle` made an identifier."""
    return _ESCAPE.sub(lambda letters: chr(int(letters[1], 16)) if letters[1] else "'", identifier)


def identifiers(prefix: str, names: Iterable[str]) -> tuple[str, ...]:
    """Return an identifier for each name."""
    names = tuple(names)
    written = tuple(f"{prefix}_{mangle(name)}" for name in names)
    if len(set(written)) < len(names):
        twice = next(name for name in written if written.count(name) > 1)
        raise DerivationError(f"two names would both be written as {twice!r}; rename one")
    return written


def file_stem(name: str, given: str | None = None) -> str:
    """Return the stem of the names of a mechanism's functions and files."""
    if given is not None:
        if not re.fullmatch(r"[A-Za-z][A-Za-z0-9_]*", given):
            raise InputError(
                f"expected a name of ASCII letters, digits and underscores that begins with a "
                f"letter, got {given!r}"
            )
        return given
    stem = mangle(name)
    return stem if stem[:1].isalpha() else f"m{stem}"


def _is_plain(character: str) -> bool:
    return character.isascii() and character.isalnum()


def _escape(character: str) -> str:
    return f"_x{ord(character):x}_"
