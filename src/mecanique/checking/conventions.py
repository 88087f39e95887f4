"""How answers to each question are usually written, and how they are read.

A text is rewritten, or letters are added, before the grammar reads it; what the grammar then does
not know may still be a letter that those who answer such a question leave unsaid.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import accumulate, chain, cycle
from typing import final

import numpy as np

from mecanique.checking.grammar.conditions import CONDITION, STABLE
from mecanique.checking.grammar.letters import Kind, KnownLetters, key_of
from mecanique.checking.grammar.reader import ReadText, define, eliminate, read_answer
from mecanique.checking.judgement.equilibria import NOWHERE
from mecanique.checking.judgement.quantities import ACROSS, ENERGIES, AskedQuantity
from mecanique.errors import FormulaError
from mecanique.model.mechanism import Mechanism
from mecanique.model.mechanism_units import units as units_of

_Written = tuple[str, KnownLetters]


@final
@dataclass(frozen=True)
class Prompt:
    """What is asked of a mechanism."""

    mechanism: Mechanism
    ask: str
    quantity: AskedQuantity
    # rates that change: constraints hold the others
    changing: Sequence[str]

    @property
    def topic(self) -> str:
        """What decides how an answer is usually written."""
        if self.ask == "state space" or self.ask.startswith("transfer function"):
            return self.ask.partition(" of ")[0]
        if self.quantity.velocity:
            return "momentum"
        if (
            self.quantity.kind in ("up to a constant", "conserved")
            or self.quantity.name in ENERGIES
        ):
            return "energy"
        return self.quantity.kind


@final
@dataclass(frozen=True)
class Interpretation:
    """An answer as it is read."""

    text: str
    reading: ReadText
    # names unknown letters that were eliminated, or may not be what they were taken for
    unread: FormulaError | None = None


def read_as_usual(text: str, letters: KnownLetters, prompt: Prompt) -> Interpretation:
    """Return what an answer says, as answers to its question are usually written."""
    topic = prompt.topic
    for rewrite in _REWRITINGS.get(topic, (_drop_arguments,)):
        text, letters = rewrite(text, letters, prompt)
    try:
        conditional = topic in _CONDITIONAL
        return Interpretation(text, read_answer(text, letters, conditional=conditional))
    except FormulaError as error:
        name = _NAMINGS.get(topic)
        written = name(text, letters, prompt, error.unknown) if name else None
        if written is not None:
            text, letters = written
            return Interpretation(text, read_answer(text, letters))
        if topic != "motion":
            raise
        letters, named = _name_accelerations(letters, prompt, error.unknown)
        # beside x'' the letter may as well be a length
        unread = error if _SECOND_RATE.search(text) else None
        try:
            reading = read_answer(text, letters)
        except FormulaError as remaining:
            reading, unread = eliminate(text, letters, remaining), error
        notes = (*reading.notes, *(f"read as the acceleration: {name}" for name in named))
        return Interpretation(text, replace(reading, notes=notes), unread)


_OF_STATE = re.compile(
    r"(?<![A-Za-z])(?P<name>[A-Za-z]+)(?P<brace>\}?)\s*(?:\\left\s*)?\([^()=+*/^-]*\)(?=\s*&?=)"
)
"""What M(q) = … or H(q, p) = … depends on."""


def _drop_arguments(text: str, letters: KnownLetters, prompt: Prompt) -> _Written:
    """Leave out what a quantity depends on."""
    asked = prompt.quantity.letters

    def drop(match: re.Match[str]) -> str:
        return match["name"] + match["brace"] if match["name"] in asked else match[0]

    return _OF_STATE.sub(drop, text), letters


def _write_matrix_out(text: str, letters: KnownLetters, prompt: Prompt) -> _Written:
    """Write entries that are given one by one as a matrix, and know that I is a unit matrix."""
    count = prompt.mechanism.nv
    for name in ("I", f"I{count}") if count > 1 else ():
        if letters.find(name) is None:
            letters = define(f"{name} = {np.eye(count, dtype=int).tolist()}", letters)[2]
    if letters.find(ACROSS) is None:
        kinds: dict[str, Kind] = {**letters.kinds, ACROSS: "other"}
        letters = replace(letters, kinds=kinds)
    return _list_entries(_SYMMETRIC.sub(ACROSS, text)), letters


_SYMMETRIC = re.compile(r"(?<![A-Za-z])sym(?:m(?:etric)?)?(?![A-Za-z(])\.?")
"""What stands below the diagonal of a matrix in print."""

_NUMBERED = re.compile(r"(?<![A-Za-z\\])\\?([^\W\d_]{1,20})_?\{?(\d)\}?(?![\w'])")
"""A letter with a number, as q_2."""

_ITEM = re.compile(r"(?<![^\s,;])\((?:i{1,3}|iv|[a-d1-9])\)(?=\s)")
"""What numbers positions in a row, as (i) … (ii) …."""


_EVERY = re.compile(
    r"\s*(?:every|each|all|jeder|alle)(?: of the| the)? (?:angles?|Winkel)(?: \S{1,8})?"
    r" (?:is|are|ist|sind)(?: either| equal to)? (?P<values>[^\n=;]+?)[\s.]*",
    re.IGNORECASE,
)
"""What is said of every coordinate."""

_NO_POSITION = re.compile(
    r"[\s$]*(?:(?:there (?:is|are) )?(?:none|no(?: such)?(?: equilibri(?:um|a))?(?: positions?)?)"
    r"|∅|\\(?:varnothing|emptyset)|\\?\{\s*\\?\})[\s.$]*",
    re.IGNORECASE,
)
"""What says that there is no equilibrium."""


def _write_positions_out(text: str, letters: KnownLetters, prompt: Prompt) -> _Written:
    """Write listed positions as equations; of a single coordinate q they may be q_1, q_2."""
    names = prompt.mechanism.coordinates.names

    def drop_number(match: re.Match[str]) -> str:
        known = key_of(match[1]) == key_of(names[0]) and letters.find(match[1] + match[2]) is None
        return names[0] if known else match[0]

    if _NO_POSITION.fullmatch(text):
        kinds: dict[str, Kind] = {**letters.kinds, NOWHERE: "other"}
        return NOWHERE, replace(letters, kinds=kinds)
    text = _ITEM.sub("\n", text)
    if len(names) == 1:
        text = _NUMBERED.sub(drop_number, text)
    if every := _EVERY.fullmatch(text):
        text = "\n".join(f"{name} = {every['values']}" for name in names)
    remarks = list[str]()

    def mark(remark: re.Match[str]) -> str:
        remarks.append(remark[0])
        return chr(_FIRST_MARK + len(remarks) - 1)

    text = CONDITION.sub(mark, re.sub(_MARK, "", text))
    text = _list_positions(_STABILITY.sub(mark, text), names)
    while re.search(_MARK, text):
        # what is said of the stability may hold a condition, which comes back after it
        text = re.sub(_MARK, lambda sign: f" {remarks[ord(sign[0]) - _FIRST_MARK]}", text)
    return text, letters


_SLOPE = re.compile(
    r"^[\s$]{0,3}(?:(?:∂|\\partial\s?)[LT]\s?/\s?(?:∂|\\partial)[^=\n]{1,24}"
    r"|\\[dt]?frac\s?\{\s?\\partial\s?[LT]\s?\}\s?\{\s?\\partial[^=\n]{1,24}\})\s{0,3}=",
    re.MULTILINE,
)
"""∂L/∂q' before what it is."""


def _drop_slope(text: str, letters: KnownLetters, _: Prompt) -> _Written:
    """Leave out the definition of a momentum."""
    return _SLOPE.sub("", text), letters


_PLUS_CONSTANT = re.compile(
    r"(?<=[^=(,;\s])[^\S\n]?[+=-]\s?(?:\\(?:text|mathrm)\{)?(C|[CcVE]_?\{?[0-9]\}?|const|constant)\b"
    r"\.?\}?\s{0,3}(?=$|[\n;,.$])"
)
"""The constant that is left open in an energy."""


def _drop_constant(text: str, letters: KnownLetters, _: Prompt) -> _Written:
    """Leave out the constant that an energy is open to."""

    def drop(match: re.Match[str]) -> str:
        return match[0] if letters.find(match[1]) else ""

    return _PLUS_CONSTANT.sub(drop, text), letters


_RATE_OF_AREA = re.compile(r"(?<![\w\\])d ?([A-Z]) ?/ ?d ?t ?=(?=[^\n]{0,200}[a-z])")
"""The rate of a letter that an integral may be named by, as Kepler's second law is."""


def _drop_rate_of_area(text: str, letters: KnownLetters, _: Prompt) -> _Written:
    """Leave out the name dA/dt of a conserved quantity."""
    return _RATE_OF_AREA.sub("", text), letters


def _name_constants(
    text: str, letters: KnownLetters, prompt: Prompt, unknown: Sequence[str]
) -> _Written | None:
    """Know the letters that stand alone on a side as names of a conserved quantity."""
    plain = re.sub(r"[\\{}$. ]|\(?const\w*\)?", "", text)
    alone = [
        name
        for name in unknown
        if re.search(rf"(?:^|[=;,\n]){re.escape(name)}(?:$|[=;,\n])", plain)
    ]
    if prompt.quantity.kind != "conserved" or not alone:
        return None
    kinds: dict[str, Kind] = {**letters.kinds, **dict.fromkeys(alone, "other")}
    return text, replace(letters, kinds=kinds)


def _write_program_out(text: str, letters: KnownLetters, prompt: Prompt) -> _Written:
    """Write a program as equations; else know that x1' = x2 is the usual form."""
    rates = prompt.mechanism.velocities
    if program := write_states_out(text, rates, letters.kinds):
        return program, letters
    if len(rates) == 1 and not letters.find("x1"):
        letters = define(f"x1 = {prompt.mechanism.coordinates.names[0]}", letters)[2]
    return text, letters


_RATE = re.compile(r"(?:v|w|u|omega)(\d?)")
"""Usual letters of rates in a state-space form."""

_STATE = re.compile(r"([^\W\d_]+)\d'?")
"""A numbered state."""

_VECTOR = re.compile(r"(?<![\w'])([^\W\d_]{1,20}) ?= ?[\[(]([^][()=\n]{1,200})[\])]")
"""A state as the vector of its entries, as z = [q, q']."""


def _name_states(
    text: str, letters: KnownLetters, prompt: Prompt, unknown: Sequence[str]
) -> _Written:
    """Define the letters that are usual for states, as x1 and w2, where no line does."""
    rates, coordinates = prompt.mechanism.velocities, prompt.mechanism.coordinates.names
    stems = {match[1] for match in map(_STATE.fullmatch, map(key_of, unknown)) if match}
    for vector in _VECTOR.finditer(text):
        entries = re.split("[,;]", vector[2])
        if vector[1] in stems and len(entries) == 2 * len(rates):
            for k, entry in enumerate(entries, 1):
                letters = define(f"{vector[1]}{k} = {entry}", letters)[2]
            return text, letters
    if len(stems) == 1 and len(rates) == len(coordinates) and not stems & {*"vwu", "omega"}:
        (stem,) = stems
        # x1' = x2 where each coordinate is followed by its rate
        plain = re.sub(r"[\\{}_\s$&]|dot", "", text)
        by_turns = re.search(rf"{re.escape(stem)}1'?={re.escape(stem)}2(?!\d)", plain)
        for k, coordinate in enumerate(coordinates):
            state = f"{stem}{2 * k + 1 if by_turns else k + 1}"
            if letters.find(state) is None:
                letters = define(f"{state} = {coordinate}", letters)[2]
    for name in dict.fromkeys(name.rstrip("'") for name in unknown):
        match = _RATE.fullmatch(key_of(name))
        place = int(match[1] or len(rates) == 1) if match else 0
        if 0 < place <= len(rates):
            letters = define(f"{name} = {rates[place - 1]}", letters)[2]
    return text, letters


def _name_transform(
    text: str, letters: KnownLetters, prompt: Prompt, unknown: Sequence[str]
) -> _Written | None:
    """Write the letter of a transform for another one, as Q2 for X_2 in X_2/F."""
    if len(unknown) != 1:
        return None
    transform = prompt.quantity.letters[-1]
    stem = unknown[0].rstrip("0123456789").rstrip("_")
    digits = re.sub(r"\D", "", unknown[0])
    usual = rf"(?<![A-Za-z\\])\\?{re.escape(stem)}_?\{{?{digits}\}}?(?![A-Za-z0-9])"
    above = re.search(rf"{usual}\s?(?:\(s\))?\s?(?:/|\}}\s?\{{)", text)
    named = digits in ("", re.sub(r"\D", "", transform)) and transform not in ("G", "H")
    if above and named and stem[:1].isupper():
        text = re.sub(usual, transform, text)
    return text, letters


def _name_vector(
    text: str, letters: KnownLetters, prompt: Prompt, unknown: Sequence[str]
) -> _Written | None:
    """Define q in M q'' + K q = f, with its rates, as the vector of the coordinates."""
    stems, listed = {name.rstrip("'") for name in unknown}, prompt.mechanism.coordinates.names
    moves = any(name.endswith("''") for name in unknown) and len(listed) > 1
    if not moves or len(stems) > 1 or not ("[" in text or "matrix" in text):
        return None
    return f"{text}\n{stems.pop()} = [{'; '.join(listed)}]", letters


_ACCELERATIONS = {"a": "m/s", "alpha": "rad/s"}
"""Usual letters of accelerations, with the unit of the rate."""

_SECOND_RATE = re.compile(r"''|[″¨\u0308]|\\ddot|d ?(?:\^ ?\{?2|²)")


def _name_accelerations(
    letters: KnownLetters, prompt: Prompt, unknown: Sequence[str]
) -> tuple[KnownLetters, list[str]]:
    """Define a, or alpha, as the only acceleration along a line, or about an axis; list these."""
    units, named = units_of(prompt.mechanism), list[str]()
    for name in unknown:
        unit = _ACCELERATIONS.get(key_of(name))
        rates = [rate for rate in prompt.changing if units.get(rate) == unit]
        if unit and len(rates) == 1:
            letters = define(f"{name} = {rates[0]}'", letters)[2]
            named.append(f"{name} = {rates[0]}'")
    return letters, named


_ENTRY = re.compile(r"\$?[Mm]_?\{?(?P<row>\d),?(?P<column>\d)\}?\s*&?=\s*")
"""An entry of a mass matrix that is given by itself, as in M12 = …"""


def _list_entries(text: str) -> str:
    """Return M11 = …, M12 = M21 = … as a matrix; an entry below the diagonal may be left out."""
    names = list(_ENTRY.finditer(text))
    ends = [*(name.start() for name in names), len(text)][1:]
    entries, chained = dict[tuple[int, int], str](), list[tuple[int, int]]()
    for name, end in zip(names, ends, strict=True):
        chained.append((int(name["row"]), int(name["column"])))
        if formula := text[name.end() : end].strip("\n\\ ,;$"):
            entries |= dict.fromkeys(chained, formula)
            chained = []
    entries = {place[::-1]: formula for place, formula in entries.items()} | entries
    size = max((max(place) for place in entries), default=0)
    if len(entries) < max(size**2, 1):
        return text
    columns = range(1, size + 1)
    rows = list[str]()
    for row in columns:
        rows.append(", ".join(entries[row, column] for column in columns))
    return f"[{'; '.join(rows)}]"


_BETWEEN = re.compile(r"(?:[\s,;={}$∈]|and|or|und|oder|\\in(?![a-z])|\\[{}\\,;]|\\q?quad)*")
_TUPLE = re.compile(r"\(((?:[^()]|\([^()]*\))*)\)([\ue000-\uf8ff]*)")
_LIST = re.compile(r"(?<![\w}])\{([^{},]*,[^{}]*)\}")
_VALUES = re.compile(
    r"(?:[\s\d.,;+−±°π*/()^\ue000-\uf8ff-]|\\?pi(?![a-z])|deg(?:rees?)?|\\circ|and|or|und|oder|\\pm)+"
)
_OR = re.compile(r"\b(?:and|or|und|oder)\b")
_LISTED = re.compile(r"(?<![^=;()\n])([^=;()\n]+)=([^=;()\n]+)")
_REMARK = re.compile(
    r"(?<![ ,;])[ ,;]*(?:(?:\band )?\b\w+ (?:is |(?:may|can) (?:be|have|take) )?"
    r"(?:arbitrary|any|free|beliebig)\b(?: values?\b)?"
    r"|\bany \w+\b(?![ ]*[=(])"
    r"|(?:∀ ?|\\forall ?)?\b\w+ ?(?:∈|\\in\b) ?(?:ℝ|R\b|\\mathbb ?\{? ?R ?\}?|\\R\b)"
    r"|∀ ?\w+\b)"
)
"""What is free in an equilibrium."""

_FIRST_MARK, _MARK = 0xE000, r"[\ue000-\uf8ff]"
"""Signs that have no meaning of their own, and stand for conditions."""

_STABILITY = re.compile(
    rf"(?<![ ,:])[ ,:]*(?:\((?:is |are )?|\b(?:is |are )?)(?:{STABLE}){_MARK}*\)?"
)
"""What is said of the stability of a position."""

_AT_REST = re.compile(r"(?<![A-Za-z\\])(\\?[^\W\d_]{1,20}\d?)_\{?(?:eq|e)\}?(?![A-Za-z0-9_])")
"""A coordinate in equilibrium, as q_e."""

_SET = re.compile(r"\s*\$?(\S+?)\s*(?:=|∈|\\?in\b)\s*\\?\{([^{}]*?)\\?\}\s*\$?\s*")


def _list_positions(text: str, names: Sequence[str]) -> str:
    """Return an answer such as (0, 0), (0, π), or 0, π of a single coordinate, as equations."""
    keys = [*map(key_of, names)]

    def drop_rest(match: re.Match[str]) -> str:
        return match[1] if key_of(match[1].strip("\\")) in keys else match[0]

    text = _REMARK.sub("", _AT_REST.sub(drop_rest, text))
    if len(names) == 1:
        listed = _SET.fullmatch(text)
        if listed and key_of(listed[1].strip("\\")) == key_of(names[0]):
            return f"{names[0]} = {listed[2]}"
        return f"{names[0]} = {text}" if _VALUES.fullmatch(text) else text

    def names_all(listed: str) -> bool:
        return [*map(key_of, re.sub(r"[\\{}\s]", "", listed).split(","))] == keys

    def write_out(positions: Sequence[Sequence[str]]) -> str:
        pairs = zip(cycle(names), chain(*positions), strict=False)
        return "\n".join(f"{name} = {value.strip()}" for name, value in pairs)

    def write_line_out(match: re.Match[str]) -> str:
        # q1, q2 = 0, π without brackets
        positions = [values.split(",") for values in _OR.split(match[2])]
        if names_all(match[1]) and all(len(values) == len(names) for values in positions):
            return f"\n{write_out(positions)}\n"
        return match[0]

    text = _LISTED.sub(write_line_out, text)
    plain = re.sub(r"\\(?:left|right)(?![A-Za-z])", "", text)
    plain = _LIST.sub(r"(\1)", plain)
    # (q1, q2) = … names the coordinates
    positions = [
        f"{inner}{mark}".split(",") for inner, mark in _TUPLE.findall(plain) if not names_all(inner)
    ]
    whole = all(len(values) == len(names) for values in positions)
    if not (whole and _BETWEEN.fullmatch(_TUPLE.sub("", plain))):
        return text
    return write_out(positions) or text


_COUNTED = re.compile(
    r"[,;\s]{0,3}\(?(?:for |für )?(?<![A-Za-z\\_])(?P<name>[A-Za-z]) ?(?:=|∈|\\in\b) ?\\?\{?"
    r"(?P<list>\d(?:[\d ,.…–-]|\\[lc]?dots\b|\bto\b|\bbis\b){1,60})\\?\}?\)?[\s.$]*$"
)
"""Numbers that a letter stands for, as in j = 1, …, 5."""


_BOTH = re.compile(r"_(?:\{ ?1 ?[,/] ?2 ?\}|1[,/]2(?!\d))")
"""The subscript of two values that are given together."""


def _count_out(text: str, letters: KnownLetters, _: Prompt) -> _Written:
    """Write omega_j = …, j = 1, …, 5 as an equation for each number, and omega_{1,2} as omega."""
    text = _BOTH.sub("", text)
    counted = _COUNTED.search(text)
    if counted is None or letters.find(counted["name"]) is not None:
        return text, letters
    numbers = [*map(int, re.findall(r"\d{1,3}", counted["list"]))]
    if re.search(r"\.\.|…|dots|[–-]|to|bis", counted["list"]):
        numbers = [*range(numbers[0], numbers[-1] + 1)]
    formula, name = text[: counted.start()], counted["name"]
    subscript = re.compile(rf"_(?:\{{{name}\}}|{name}(?![A-Za-z0-9]))")
    factor = re.compile(rf"(?<![A-Za-z\\_]){name}(?![A-Za-z])")
    lines = (factor.sub(f"({k})", subscript.sub(str(k), formula)) for k in numbers[:_MOST_COUNTED])
    return "\n".join(lines), letters


_MOST_COUNTED = 20
"""As many numbers are inserted for a letter."""

_Rewriting = Callable[[str, KnownLetters, Prompt], _Written]
_Naming = Callable[[str, KnownLetters, Prompt, Sequence[str]], _Written | None]

_CONDITIONAL = ("equilibrium", "several", "steady")
"""Topics of which an answer may hold under conditions."""

_REWRITINGS: Mapping[str, tuple[_Rewriting, ...]] = {
    "motion": (),
    "state space": (_write_program_out,),
    "matrix": (_drop_arguments, _write_matrix_out),
    "equilibrium": (_drop_arguments, _write_positions_out),
    "several": (_drop_arguments, _count_out),
    "energy": (_drop_arguments, _drop_rate_of_area, _drop_constant),
    "momentum": (_drop_arguments, _drop_slope),
}
_NAMINGS: Mapping[str, _Naming] = {
    "motion": _name_vector,
    "state space": _name_states,
    "transfer function": _name_transform,
    "energy": _name_constants,
}
"""What defines the letters that an answer leaves unsaid."""


# State-space forms as programs write them: def f(t, y), lambda t, y, f = @(t, y), y(2).

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
    """Return a program for the rates of a state as equations of motion; None if it is none."""
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
