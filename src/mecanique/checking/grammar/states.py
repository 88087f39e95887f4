"""State-space forms as programs write them: def f(t, y), lambda t, y, f = @(t, y), y(2)."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from itertools import accumulate

_HEAD = re.compile(
    r"(?<!\w)(?:(?:def\s+\w{1,40}|function\b[^(\n]{0,40})\s*\((?P<names>[^()\n]{0,80})\)[^\S\n]*:?"
    r"|(?:\w{1,40}\s*=\s*)?(?:@\s*\((?P<matlab>[^()\n]{0,80})\)|lambda\s+(?P<short>[\w, ]{1,80}):))"
)
_INDEXED = re.compile(r"(?<![\w.])([A-Za-z]\w{0,20})(?:\[(\d)\]|\((\d)\))")
_ARRAY = re.compile(r"(?:np|numpy|jnp)\.(?:array|asarray|hstack)\s*(?=\()")
_CHATTER = re.compile(
    r"(?:(?:[#%]|import\b|from\b|end\b|\"\"\"|''')[^\n]*|return\s+\w+|\w+\s*=\s*(?:np\.)?(?:zeros|empty)\w*\(.*)"
)


def write_states_out(text: str, rates: Sequence[str], letters: Mapping[str, str]) -> str | None:
    """Return a program for the rates of a state as equations of motion.

    Args:
        text: the program.
        rates: q1', q2' …, the mechanism's velocities.
        letters: the letters of the mechanism, with their kinds.

    Returns:
        The equations with the definitions of the program's names; None if it is no such program.
    """
    head = _HEAD.search(text)
    arguments = re.findall(r"[^\W\d]\w*", next(filter(None, head.groups()), "")) if head else []
    state = next((name for name in arguments if name not in ("t", "self")), "")
    if not state:
        indexed = {name for name, *_ in _INDEXED.findall(text) if name not in letters}
        if len(indexed) != 1:
            return None
        (state,) = indexed
    count, coordinates = 2 * len(rates), [rate.removesuffix("'") for rate in rates]
    if any(not rate.endswith("'") for rate in rates):
        return None
    body = _ARRAY.sub("", text[head.end() :] if head else text)
    first = 0 if re.search(rf"\b{state}\[\d\]", body) else 1
    names = [f"{state}{k + first}" for k in range(count)]
    body = re.sub(rf"\b{state}(?:\[(\d)\]|\((\d)\))", rf"{state}\1\2", body)
    lines, whole, same = list[str](), "", dict[str, str]()
    assigned = dict[int, str]()
    for line in _split(body, ";\n"):
        entry = re.fullmatch(r"\w+[\[(](\d)[\])]\s*=\s*(.+)", line)
        unpacked = re.fullmatch(rf"[\[(]?([\w, ]+?)[\])]?\s*=\s*{state}(?:\.T)?", line)
        left, _, right = line.rpartition("return ") if "return " in line else line.rpartition("=")
        vector = _peel(right.strip())
        if unpacked:
            names = [name.strip() for name in unpacked[1].split(",") if name.strip()]
        elif entry:
            assigned[int(entry[1])] = entry[2]
        elif re.fullmatch(r"[\w ]*", left) and len(_split(vector, ",;\n")) == count:
            whole = vector
        elif not _CHATTER.fullmatch(line):
            lines.append(line)
            same |= {left.strip(): vector} if vector in names else {}
    written_out = _split(whole, ",;\n") or [assigned[k] for k in sorted(assigned)]
    entries = [same.get(entry, entry) for entry in written_out]
    if len(entries) != count or len(set(names)) != count:
        return None
    # a state whose rate is another one is a coordinate
    pairs = {k: names.index(entry) for k, entry in enumerate(entries) if entry in names}
    if len(pairs) != len(rates) or {*pairs} & {*pairs.values()}:
        pairs = {k: k + len(rates) for k in range(len(rates))}
    taken = {names[k]: k for k in pairs if names[k] in coordinates}
    free = iter(name for name in coordinates if name not in taken)
    meant = dict[str, str]()
    equations = list[str]()
    for place, velocity in pairs.items():
        name = names[place] if names[place] in taken else next(free)
        meant |= {names[place]: name, names[velocity]: f"{name}'"}
        if entries[place] != names[velocity]:
            equations.append(f"{name}' = {entries[place]}")
        equations.append(f"{name}'' = {entries[velocity]}")
    if any(written in letters and written != name for written, name in meant.items()):
        return None
    rated = {*same} & {*written_out}
    lines = [line for line in lines if line.partition("=")[0].strip() not in rated]
    defined = [f"{written} = {name}" for written, name in meant.items() if written != name]
    return "\n".join([*defined, *lines, *equations])


def _peel(vector: str) -> str:
    """Return what stands within the brackets around a whole vector."""
    for _ in range(_MOST_PEELED):
        if vector[:1] not in ("[", "(") or vector[-1:] not in ("]", ")"):
            break
        depths = list(accumulate((sign in "([{") - (sign in ")]}") for sign in vector))
        if 0 in depths[:-1] or depths[-1]:
            break
        vector = vector[1:-1].strip()
    return vector


def _split(text: str, ends: str) -> list[str]:
    """Return what some signs separate outside brackets."""
    parts, depth, start = list[str](), 0, 0
    for place, sign in enumerate(f"{text}{ends[0]}"):
        depth += (sign in "([{") - (sign in ")]}")
        if sign in ends and (depth <= 0 or place == len(text)):
            parts.append(text[start:place])
            start = place + 1
    return [" ".join(part.split()) for part in parts if part.strip()]


_MOST_PEELED = 3
"""Most brackets around a vector."""
