"""Convert sentences to LaTeX or HTML, with the letters and formulas in them set as mathematics."""

from __future__ import annotations

import html
import re
from collections.abc import Collection, Mapping
from typing import NamedTuple, final

from mecanique.derivation.printing.writers import NO_LETTERS, Latex, MathML
from mecanique.model.mechanism.letters import GREEK

_NAMES = {sign: name for name, sign in GREEK.items()}
_TOKEN = re.compile(
    r"(?P<text>\[[^\]]*\]|(?:[a-z]\.){2,}|[^\W\d_]+(?:'(?![²³])[^\W\d_]+)+)"
    r"|(?P<code>`[^`]*`)"
    r"|(?P<slope>∂[^\W\d]\w*/∂[^\W\d]\w*'?|d²?[^\W\d]\w*/d[^\W\d]\w*²?|d/dt|dm\b)"
    r"|(?P<number>\d+(?:\.\d+)?|½)"
    r"|(?P<word>[^\W\d]\w*'*(?:[²³]|\^\d)?)"
    r"|(?P<sign>\S)"
)
_NUMBERED = re.compile(r"[a-gi-zA-GI-Z]\d'*")
"""A letter with a number; H1 to H9 are rows of the table of homogeneous bodies."""
_GREEK_WORD = re.compile(rf"\b({'|'.join(GREEK)})(\d*)\b")
_PARTIAL = re.compile(r"∂(\w+)/∂(\w+'?)")
_SLOPE = re.compile(r"d(²?)(\w+)/d(\w+?)(²?)")
_DIFFERENTIAL = re.compile(r"(\bd²?|∂)([^\W\d_²/][^\W²/]*'*)")
_CALLED = frozenset({"acos", "asin", "atan", "cos", "exp", "sin", "sqrt", "tan"})
_RELATIONS = {"=": "=", "<": "<", ">": ">", "≤": "\\leq", "≥": "\\geq"}
_JOINTS = {"+": "+", "-": "-", "−": "-", "/": "/", "×": "\\times", "·": "\\cdot", "*": ""}
_SIGNS = {"+": "+", "-": "-", "−": "-", "±": "\\pm "}
_POWERS = {"²": "^{2}", "³": "^{3}"}

_AFTER = {"ahead", "along", "and", "are", "from", "in", "is", "of", "on", "or", "to"}
"""Words that may follow the letter a, never the article."""

_CALLING = {"angle", "angles", "coordinate", "coordinates", "for", "leave"}
"""Words that the name of a coordinate may follow."""

_BEFORE = {"acceleration", "amplitude", "distance", "edges", "length", "radius", "side", "sides"}
"""Words that the letter a may follow."""

_ESCAPED = {sign: f"\\{sign}" for sign in "&%$#_{}"}
_ESCAPED |= {"²": "\\textsuperscript{2}", "³": "\\textsuperscript{3}", "°": "$^\\circ$"}
_ESCAPED |= {"·": "$\\cdot$", "−": "$-$", "√": "$\\surd$", "½": "$\\frac{1}{2}$"}
_ESCAPED |= {"≥": "$\\geq$", "≤": "$\\leq$", "×": "$\\times$", "…": "\\ldots{}", "∂": "$\\partial$"}
_ESCAPED |= {"^": "\\textasciicircum{}", "~": "\\textasciitilde{}", "\\": "\\textbackslash{}"}
_ESCAPED |= {"|": "$|$", "<": "$<$", ">": "$>$", "₀": "$_0$", "₁": "$_1$", "₂": "$_2$"}
_ESCAPED |= {"±": "$\\pm$"}
_ESCAPED |= {sign: f"$\\{name}$" for sign, name in _NAMES.items() if name != "omicron"}


def escape(sentence: str) -> str:
    """Escape a sentence without formulas, e.g. a source, for LaTeX's text mode."""
    return "".join(_ESCAPED.get(sign, sign) for sign in sentence)


def find_points(sentence: str) -> frozenset[str]:
    """Return the capital letters that stand alone in a text, as names of points do."""
    return frozenset(_Sentence(sentence, ()).points)


def to_latex(
    sentence: str,
    names: Collection[str],
    points: Collection[str] = (),
    letters: Mapping[str, str] = NO_LETTERS,
) -> str:
    """Convert a sentence to LaTeX's text mode, with its formulas set as mathematics."""
    if _is_source(sentence):
        return escape(sentence)
    return _Sentence(sentence, names, points, letters).latex()


def to_html(
    sentence: str, names: Collection[str] = (), letters: Mapping[str, str] = NO_LETTERS
) -> str:
    """Convert a sentence to HTML, with the letters in it set as in formulas."""
    if _is_source(sentence):
        return html.escape(sentence)
    return _Sentence(sentence, names, letters=letters).html()


def _is_source(sentence: str) -> bool:
    """Whether a sentence cites authors, whose initials are no letters of formulas."""
    return sentence.startswith("Source:")


def spell_greek(
    sentence: str, names: Collection[str], letters: Mapping[str, str] = NO_LETTERS
) -> str:
    """Return a sentence with Greek signs for names of quantities, φ for phi, outside LaTeX."""
    # Words that are no names stay
    said = _Sentence(sentence, names, letters=letters).spell() if letters else sentence
    return _GREEK_WORD.sub(
        lambda match: f"{GREEK[match[1]]}{match[2]}" if match[0] in names else match[0], said
    )


@final
class _Token(NamedTuple):
    """A word, number or sign."""

    kind: str  # the group of `_TOKEN` that it belongs to
    text: str
    apart: bool  # whether a space precedes it


@final
class _Part(NamedTuple):
    """A part of a formula."""

    latex: str
    end: int  # index of the token after it
    lettered: bool  # whether it contains more than numbers
    related: bool = False  # whether it contains a relation such as =
    joined: bool = False  # whether it is more than one letter, number or function


@final
class _Sentence:
    """A sentence as tokens, read from left to right; each formula is as long as possible."""

    def __init__(
        self,
        sentence: str,
        names: Collection[str],
        points: Collection[str] = (),
        letters: Mapping[str, str] = NO_LETTERS,
    ) -> None:
        self.names = names
        self.letters = letters
        self.writer = Latex(letters)
        self.tokens = []
        for match in _TOKEN.finditer(sentence):
            before = sentence[match.start() - 1 : match.start()]
            self.tokens.append(_Token(str(match.lastgroup), match[0], before.isspace()))
        words = [token.text.rstrip("'") for token in self.tokens if token.kind == "word"]
        self.points = {word for word in words if len(word) == 1 and word.isupper()} | {*points}

    def latex(self) -> str:
        """Return the sentence for text mode."""
        out, at = "", 0
        while at < len(self.tokens):
            token = self.tokens[at]
            # in the compound x-z the hyphen is not a minus sign of z
            within = token.text in _SIGNS and at > 0 and not token.apart
            part = None if within and self._text(at - 1) != "(" else self._read_formula(at)
            out += " " if token.apart else ""
            if part is not None and part.lettered:
                out += f"${part.latex}$"
                at = part.end
            else:
                code = token.kind == "code"
                plain = escape(token.text.strip("`"))
                out += f"\\texttt{{{plain}}}" if code else escape(token.text)
                at += 1
        return out

    def spell(self) -> str:
        """Return the sentence as text, with Greek signs for words that are names."""
        out = ""
        for at, token in enumerate(self.tokens):
            stem, said = token.text.rstrip("'"), token.text
            if stem in self.letters and self._is_letter(stem, at, within=False):
                base, *rest = self.letters[stem].partition("_")
                said = "".join([GREEK.get(base, base), *rest, token.text[len(stem) :]])
            out += " " * token.apart + said
        return out

    def html(self) -> str:
        """Return the sentence for a page; signs between letters stay text."""
        writer, out = MathML(self.letters), []
        for at, token in enumerate(self.tokens):
            core, power = self._split_power(token.text)
            is_letter = token.kind == "word" and self._is_letter(core, at, within=False)
            is_letter |= _NUMBERED.fullmatch(core) is not None
            said = html.escape(token.text)
            if is_letter and core.endswith("'") and self._is_point(core):
                said = f"<math><msup><mi>{core[:-1]}</mi><mo>′</mo></msup></math>"
            elif is_letter:
                said = f"<math>{writer.letter(core, False, power)}</math>"
            elif token.kind == "slope":
                said = _DIFFERENTIAL.sub(self._set_differential, token.text)
            out += [" " if token.apart else "", said]
        return re.sub(r"\)\^(\d)", r")<sup>\1</sup>", "".join(out))

    def _set_differential(self, differential: re.Match[str]) -> str:
        """Return dφ or ∂φ with its letter in MathML; other words that begin with d as they are."""
        sign, name = differential.groups()
        bare = name.rstrip("'")
        if len(bare) > 1 and bare not in self.names and bare not in GREEK:
            return differential[0]
        return f"{sign}<math>{MathML(self.letters).letter(name, False, '')}</math>"

    def _text(self, at: int) -> str:
        return self.tokens[at].text if 0 <= at < len(self.tokens) else ""

    def _apart(self, at: int) -> bool:
        return at < len(self.tokens) and self.tokens[at].apart

    def _read_formula(self, at: int) -> _Part | None:
        """Read the longest formula that starts at a token; None without one."""
        part = self._read_sign(at)
        while part is not None:
            longer = self._join_next(part) or self._multiply_next(part)
            if longer is None:
                return part
            part = longer
        return None

    def _read_sign(self, at: int) -> _Part | None:
        """Read a factor with or without a sign."""
        sign = _SIGNS.get(self._text(at))
        if sign is None:
            return self._factor(at)
        part = None if self._apart(at + 1) else self._factor(at + 1)
        return None if part is None else part._replace(latex=f"{sign}{part.latex}")

    def _join_next(self, part: _Part) -> _Part | None:
        """Extend a formula by an operator or relation and the operand after it."""
        text, end = self._text(part.end), part.end
        related = text in _RELATIONS
        sign = _RELATIONS.get(text, _JOINTS.get(text))
        # "x-z" is not a difference, and in "x -y" the sign belongs to y
        tight = text in ("/", "·", "*") and not self._apart(end)
        if sign is None or not (tight or self._apart(end)) or self._apart(end + 1) == tight:
            return None
        after = self._read_sign(end + 1)
        if after is None:
            return None
        between = sign if tight and sign == "/" else f" {sign} ".replace("  ", " ")
        return _Part(
            f"{part.latex}{between}{after.latex}",
            after.end,
            part.lettered or after.lettered,
            part.related or related,
            joined=True,
        )

    def _multiply_next(self, part: _Part) -> _Part | None:
        """Extend a formula by one more factor."""
        if not self._apart(part.end) or self.tokens[part.end].kind == "number":
            return None
        after = self._factor(part.end, within=True)
        if after is None:
            return None
        thin = "\\, " if after.latex.startswith("\\text") else ""
        return part._replace(
            latex=f"{part.latex} {thin}{after.latex}", end=after.end, lettered=True, joined=True
        )

    def _factor(self, at: int, within: bool = False) -> _Part | None:
        """Read a number, letter, function, derivative, or sum in brackets."""
        if at >= len(self.tokens):
            return None
        kind, text, _ = self.tokens[at]
        if kind == "number":
            return _Part("\\frac{1}{2}" if text == "½" else text, at + 1, lettered=False)
        if kind == "slope" and (slope := self._write_slope(text)):
            return _Part(slope, at + 1, lettered=True)
        if text == "Σ":
            return _Part("\\sum", at + 1, lettered=True)
        if text == "|":
            return self._read_brackets(at, "|", sums=False)
        if text == "(":
            return self._read_brackets(at, ")", sums=True)
        if kind != "word":
            return None
        return self._read_call(at) or self._letter(at, within)

    def _read_brackets(self, at: int, close: str, *, sums: bool) -> _Part | None:
        """Read a formula in brackets; relations and single letters are left to the sentence."""
        inner = None if self._apart(at + 1) else self._read_formula(at + 1)
        if inner is None or self._text(inner.end) != close:
            return None
        if sums and (inner.related or not inner.joined or not inner.lettered):
            return None
        whole = f"{self._text(at)}{inner.latex}{close}"
        power, end = self._read_power(inner.end + 1)
        return _Part(whole + power, end, inner.lettered, joined=True)

    def _read_power(self, at: int) -> tuple[str, int]:
        """Return an exponent after brackets, ² or ^2, and the index of the token after it."""
        sign, digits = self._text(at), self._text(at + 1)
        if not self._apart(at) and sign in _POWERS:
            return _POWERS[sign], at + 1
        if not (self._apart(at) or self._apart(at + 1)) and sign == "^" and digits.isdigit():
            return f"^{{{digits}}}", at + 2
        return "", at

    def _read_call(self, at: int) -> _Part | None:
        """Read a function with its argument."""
        name = self._text(at)
        known = name in _CALLED or name in self.names
        if not known or self._text(at + 1) != "(" or self._apart(at + 1):
            return None
        inner = self._read_formula(at + 2)
        if inner is None or self._text(inner.end) != ")":
            return None
        writer, argument = self.writer, inner.latex
        letter = f"{writer.letter(name, False, '')}({argument})"
        written = writer.call(name, argument, "") if name in _CALLED else letter
        power, end = self._read_power(inner.end + 1)
        return _Part(written + power, end, lettered=True)

    def _letter(self, at: int, within: bool) -> _Part | None:
        """Read a letter: a symbol, a point or an axis."""
        core, power = self._split_power(self._text(at))
        if not self._is_letter(core, at, within):
            return None
        written = core if self._is_point(core) else self.writer.letter(core, False, power)
        return _Part(written, at + 1, lettered=True)

    def _is_point(self, core: str) -> bool:
        """Whether a letter is no quantity but the name of a point, of which B' is another."""
        bare = core.rstrip("'")
        return bare not in self.names and bare.isascii() and bare.isupper()

    def _split_power(self, text: str) -> tuple[str, str]:
        """Return a letter without its exponent, and the exponent."""
        core, _, power = text.partition("^")
        if core[-1:] in _POWERS:
            return core[:-1], _POWERS[core[-1]].strip("^{}")
        return core, power

    def _is_letter(self, core: str, at: int, within: bool) -> bool:
        bare = core.rstrip("'")
        if core == "a":
            return self._is_no_article(at, within)
        if core == "I" and core not in self.names:
            return self._text(at + 1) in _AFTER
        if core == "A":
            return at > 0 and self._text(at - 1) not in (".", ":", "?", "(")
        if bare in GREEK or any(sign in _NAMES or sign in "δ∂" for sign in core):
            return True
        if core in self.names or bare in self.names:
            # a word that is also a symbol, e.g. arm, is a symbol only within a formula
            word = core.isalpha() and len(core) > 2 and core[1:].islower() and core not in GREEK
            return not word or self._is_called(at) or self._is_joined(at)
        if len(bare) == 1 and bare.isascii():
            return True
        if 1 < len(core) < 6 and core.isupper() and core.isalpha():
            return set(core) <= self.points
        return re.fullmatch(r"[A-Za-z]_\w+", core) is not None

    def _is_called(self, at: int) -> bool:
        """Whether a word is the name of what has a letter, as in "the angles yaw and roll"."""
        listed = self._text(at) in self.letters
        while listed and at > 0:
            at -= 1
            signed = self._text(at) in _SIGNS and self._apart(at) and not self._apart(at + 1)
            if self._text(at) in _CALLING or signed or self._text(at - 1) + self._text(at) == "=(":
                return True
            while self._text(at) in (",", "and"):
                at -= 1
            listed = self._text(at) in self.names
        return False

    def _is_joined(self, at: int) -> bool:
        """Whether a word is an operand, as in sun - arm, or the argument of a function."""
        if self._text(at - 1) == "(" and self._text(at + 1) == ")" and not self._apart(at - 1):
            return True
        for sign, apart in ((at - 1, self._apart(at)), (at + 1, self._apart(at + 1))):
            text = self._text(sign)
            if text in _RELATIONS or (text in _JOINTS and (apart or text == "/")):
                return True
        return False

    def _is_no_article(self, at: int, within: bool) -> bool:
        """Whether an "a" is a letter: beside a sign, before a comma, or after e.g. "length"."""
        before, after = self._text(at - 1), self._text(at + 1)
        if self._is_joined(at) or (before == "-" and not self._apart(at)):
            return True
        if before in _BEFORE and (at + 1 == len(self.tokens) or not self._apart(at + 1)):
            return True
        known = within or before in _BEFORE or "a" in self.names
        follows = not after or after in _AFTER or after in {",", ".", ";", ":", ")"}
        return known and (follows or before in _BEFORE)

    def _write_slope(self, text: str) -> str:
        """Return a derivative in LaTeX, "" if the text is not one."""
        writer = self.writer
        if text == "d/dt":
            return "\\frac{d}{dt}"
        if text == "dm":
            return text
        if partial := _PARTIAL.fullmatch(text):
            above, below = (writer.letter(name, False, "") for name in partial.groups())
            return writer.partial(above, below, False)
        slope = _SLOPE.fullmatch(text)
        if slope is None or slope[3] not in self.names:
            return ""
        above, below = (writer.letter(slope[k], False, "") for k in (2, 3))
        power = "^{2}" if slope[1] else ""
        return f"\\frac{{d{power} {above}}}{{d {below}{power}}}"
