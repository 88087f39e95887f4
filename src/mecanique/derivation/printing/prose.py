"""Sentences in LaTeX: the letters and formulas in them are set as mathematics."""

from __future__ import annotations

import re
from collections.abc import Collection

from mecanique.derivation.printing.letters import GREEK
from mecanique.derivation.printing.writers import Latex

__all__ = ["escape", "to_latex"]

_NAMES = {sign: name for name, sign in GREEK.items()}
_SIGNS = {"+", "-", "=", "×", "−"}
_WORDS = re.compile(r"(?:[\w']+\([^()\s][^()]*\)\S*|\S+)")
_CALL = re.compile(r"([\w']+)\(([^()]*)\)")
_POINT = re.compile(r"[A-Z]'+")
_NUMBER = re.compile(r"\d+")
_PARTIAL = re.compile(r"∂([^\W\d]\w*)/∂([^\W\d]\w*'?)")
_SLOPE = re.compile(r"d(²?)([^\W\d]\w*)/d([^\W\d]\w*?)(²?)")
_WORD = re.compile(
    r"(?P<before>[(\[]*)(?P<sign>-?)(?P<core>[\w']+\([^()]*\)|.*?)(?P<after>[,.;:)\]]*)", re.DOTALL
)
_ESCAPED = {sign: f"\\{sign}" for sign in "&%$#_{}"}
_ESCAPED |= {"²": "\\textsuperscript{2}", "³": "\\textsuperscript{3}", "°": "$^\\circ$"}
_ESCAPED |= {"·": "$\\cdot$", "−": "$-$", "√": "$\\surd$", "½": "$\\frac{1}{2}$"}
_ESCAPED |= {"≥": "$\\geq$", "≤": "$\\leq$", "×": "$\\times$", "…": "\\ldots{}", "∂": "$\\partial$"}
_ESCAPED |= {"^": "\\textasciicircum{}", "~": "\\textasciitilde{}", "\\": "\\textbackslash{}"}
_ESCAPED |= {"|": "$|$", "<": "$<$", ">": "$>$", "₀": "$_0$", "₁": "$_1$", "₂": "$_2$"}
_ESCAPED |= {sign: f"$\\{name}$" for sign, name in _NAMES.items() if name != "omicron"}


def escape(sentence: str) -> str:
    """Return a sentence without letters of formulas, e.g. a source, for LaTeX's text mode.

    Args:
        sentence: plain text.
    """
    return "".join(_ESCAPED.get(sign, sign) for sign in sentence)


def to_latex(sentence: str, names: Collection[str]) -> str:
    """Return a sentence for LaTeX's text mode.

    Args:
        sentence: plain text with letters such as R_pin_n, δq and ∂T/∂q' in it.
        names: every symbol of the formulas around it.
    """
    words = _WORDS.findall(sentence)
    out, formula = list[str](), list[str]()
    for place, word in enumerate(words):
        found = _WORD.fullmatch(word)
        assert found is not None
        core, sign = found["core"], found["sign"]
        near = {*words[max(place - 1, 0) : place], *words[place + 1 : place + 2]}
        if not core and sign and _joins(words, place, names):
            formula.append("-")
        elif word.startswith("["):  # a unit
            out += [_close(formula)] if formula else []
            out.append(escape(word))
        elif core and _is_formula(core, sign, near, names) and not found["before"]:
            formula.append(sign + _formula(core, names))
            if found["after"]:
                out.append(_close(formula) + found["after"])
        elif core and _is_formula(core, sign, near, names):
            out += [_close(formula)] if formula else []
            out.append(f"{found['before']}${sign}{_formula(core, names)}${found['after']}")
        else:
            out += [_close(formula)] if formula else []
            out.append(escape(word))
    out += [_close(formula)] if formula else []
    return " ".join(out)


def _close(formula: list[str]) -> str:
    written = f"${' '.join(formula)}$"
    formula.clear()
    return written


def _joins(words: list[str], place: int, names: Collection[str]) -> bool:
    """Whether a lonely minus stands between letters."""
    before = words[place - 1] if place else ""
    return bool(before) and _is_formula(before, "", set(), names)


def _is_formula(core: str, sign: str, near: set[str], names: Collection[str]) -> bool:
    """Whether a word is a letter or part of a formula."""
    if core in _SIGNS or core == "d/dt" or _PARTIAL.search(core) or core == "Σ":
        return True
    if any(letter in _NAMES or letter in "δ∂" for letter in core):
        return True
    if core in ("a", "I", "A"):
        return bool(sign or near & {"=", "+", "-", "acceleration", "length", "-m"})
    called = _CALL.fullmatch(core)
    if called is not None:
        return called[1] in names or called[1] in ("sin", "cos")
    if core in names and (core in GREEK or not (core.isalpha() and len(core) > 2)):
        return True
    slope = _SLOPE.fullmatch(core)
    if slope is not None:
        return slope[3] in names
    bare = core.rstrip("²").rstrip("'")
    if bare != core and bare in names:
        return True
    if core == "dm" or (len(core) == 1 and core.isalpha() and core.isascii()):
        return True
    if re.fullmatch(r"[a-zA-Z]'+|[A-Z]_\w+|[A-Za-z]·[A-Za-z]", core):
        return True
    return bool(_NUMBER.fullmatch(core)) and "=" in near


def _formula(core: str, names: Collection[str]) -> str:
    """A part of a formula in LaTeX."""
    writer = Latex()
    if _POINT.fullmatch(core) and core.rstrip("'") not in names:
        return core
    called = _CALL.fullmatch(core)
    if called is not None:
        inner = " ".join(_formula(part, names) for part in called[2].split())
        head = f"\\{called[1]}" if called[1] in ("sin", "cos") else _formula(called[1], names)
        return f"{head}({inner})"
    if core in _SIGNS:
        return {"×": "\\times", "−": "-"}.get(core, core)
    if core == "Σ":
        return "\\sum"
    if core == "d/dt":
        return "\\frac{d}{dt}"
    partial = _PARTIAL.fullmatch(core)
    if partial is not None:
        above, below = (writer.letter(name, False, "") for name in partial.groups())
        return f"\\frac{{\\partial {above}}}{{\\partial {below}}}"
    slope = _SLOPE.fullmatch(core)
    if slope is not None:
        above, below = (writer.letter(slope[k], False, "") for k in (2, 3))
        power = "^{2}" if slope[1] else ""
        return f"\\frac{{d{power} {above}}}{{d {below}{power}}}"
    if "·" in core:
        return core.replace("·", " \\cdot ")
    power = "2" if core.endswith("²") else ""
    return writer.letter(core.rstrip("²"), False, power)
