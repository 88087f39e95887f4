"""Cut a formula into tokens, whether it is plain text, LaTeX or SymPy's text."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from difflib import get_close_matches
from itertools import accumulate
from typing import Literal, TypeAlias, final

from mecanique.checking.budget import spend
from mecanique.checking.grammar import tree
from mecanique.checking.grammar.letters import SPELLINGS, KnownLetters
from mecanique.checking.grammar.tree import FUNCTIONS
from mecanique.errors import FormulaError

_SPELLED = {
    "-": "−–‑‐—－",
    "+": "＋",
    "*": "·×⋅∙∗•ꞏ",
    "/": "÷∕⁄",
    "=": "＝≡≔",
    "(": "（",
    ")": "）",
    "'": "′’‘ʹ´",
    "''": 'ʺ˝“„″”"',
    "'''": "‴",
    "\n": "⇒⟹⇔→∴\r\x0b\x0c\u2028\u2029\x85",
    " ": "⋯\u2061\u2062\u2063\u00a0\u2009\u200b\ufeff",
    " sqrt ": "√",
    "d": "𝑑ⅆ",
    "l": "ℓ",
    "n": "ñ",
    "mu": "µ",
    "theta": "ϑ",
    "phi": "ϕ",
    "epsilon": "ε",
    "°": "º",
    "(1/2)": "½",
    "(1/3)": "⅓",
    "(2/3)": "⅔",
    "(1/4)": "¼",
    "(3/4)": "¾",
}
"""What signs stand for, those of line ends and of spaces among them."""

_SIGNS = {sign: spelling for spelling, signs in _SPELLED.items() for sign in signs}
_RAISED = dict(zip("⁰¹²³⁴⁵⁶⁷⁸⁹⁻", "0123456789-", strict=True))
_LOWERED = dict(zip("₀₁₂₃₄₅₆₇₈₉", "0123456789", strict=True))
_DOTS = {"\u0307": "'", "\u0308": "''", "\u20db": "'''"}

_QUOTED = re.compile(r"^([^\S\n]*)[\"“„«](.*?)[\"”“»]([ \t\r.,;]*)$", re.MULTILINE)
"""A line in quotation marks; without a letter before it, the first of them is no prime."""

_NUMBERED = re.compile(r"^[^\S\n]*\(?(\d{1,2})\)[^\S\n]+(?=\S)", re.MULTILINE)
_FONTS = r"math(?:rm|it|bf|sf|bb|cal|ord)|text(?:rm|bf|it)?|operatorname\*?|boldsymbol|bm|vec"
_BOX = re.compile(rf"\\(?:boxed|fbox|ensuremath|{_FONTS})\s*\{{")
_BARE_FONT = re.compile(rf"\\(?:{_FONTS})\s+(?=[A-Za-z]\b)")
_FONT = re.compile(rf"\\(?:{_FONTS})\s*\{{\s*(?P<word>(?:[A-Za-z0-9]|\\?_)+)\s*\}}")


_REWRITES = (
    # Maple: diff(q(t), t$2)
    (re.compile(r"(?<=,)\s?(t)\$(?=\d\s?\))"), r"\1,"),
    # modules of Python
    (re.compile(r"(?<![\w.])(?:np|numpy|math|cmath|sp|sym|sympy|jnp)\.(?=[A-Za-z])"), ""),
    (re.compile(r"\b(?:array|asarray)(?=\()"), "Matrix"),
    # Maple: D(q)(t), (D@@2)(q)(t), D(D(q))(t)
    (re.compile(r"(?:\bD\(D\((\w+)\)\)|\(D@@2\)\((\w+)\))\(t\)"), r"\1\2''"),
    (re.compile(r"\bD\((\w+)\)\(t\)"), r"\1'"),
    # Mathematica: Derivative[2][q][t], D[q[t], {t, 2}]
    (re.compile(r"\bDiagonalMatrix\[\s?\{([^{}]*)\}\s?\]"), r"diag(\1)"),
    (re.compile(r"\bDerivative\[1\]\[(\w+)\](?:\[t\])?"), r"\1'"),
    (re.compile(r"\bDerivative\[2\]\[(\w+)\](?:\[t\])?"), r"\1''"),
    (re.compile(r"\bD\[\s*(\w+)\[t\]\s*,\s*t\s*\]"), r"\1'"),
    (re.compile(r"\bD\[\s*(\w+)\[t\]\s*,\s*\{\s*t\s*,\s*2\s*\}\s*\]"), r"\1''"),
    (re.compile(r"=>|->|\b(?:i\. ?e|d\. ?h)\."), "\n"),
    # the article of a French or Italian word is no rate of a length
    (
        re.compile(
            r"\b(?:[LlDd]|[Dd]ell|[Nn]ell|[Aa]ll)'(?=(?:apres|energi[ae]|equa(?:tion|zione)|"
            r"equilibr(?:e|io)|iner(?:tie|zia)|accelera(?:tion|zione)|integrale?|angolo|origin[ae])\b)"
        ),
        "",
    ),
    (re.compile(r"(?<=\d)\s*(?:\^\s*\{?\s*\\circ\s*\}?|deg(?:rees?)?\b)"), "°"),
    # of a function of time alone ∂/∂t is d/dt, and of a Lagrangian d/dq is partial anyway
    (re.compile(r"(?:\\partial(?![A-Za-z])|∂)"), "d "),
    (
        re.compile(
            r"(?<![.\w])(?:diff\(|D\[)\s*(\w+)\s*,\s*(?!t\b)([^\W\d]\w*'?)(?:\[t\]|\(t\))?\s*[)\]]"
        ),
        r"d\1/d\2",
    ),
    (re.compile(r"\b(?:diff\(|D\[)\s*(d\w+/d\w+'?)\s*,\s*t\s*[)\]]"), r"d/dt(\1)"),
    (re.compile(r"\\var(?=(?:theta|phi|epsilon|rho)(?![A-Za-z]))"), r"\\"),
    # LaTeX's decimal comma
    (re.compile(r"(?<=\d)\{,\}(?=\d)"), "."),
    # vectors are columns or rows as is needed, and \\det takes brackets
    (
        re.compile(
            r"(?<=[\]}])\s*\^\s*(?:T(?!\w)|\{\s*(?:T|\\top|\\intercal)\s*\}|\\(?:top|intercal)(?!\w))"
        ),
        "",
    ),
    (re.compile(r"\beye\(\s*(\d)(?:\s*,\s*\d)?\s*\)"), r"I_\1"),
    # integrals of Mathematica and SymPy
    (
        re.compile(r"\bIntegrate\[(.*),\s*\{(\w+),([^{},]+),([^{},]+)\}\s*\]"),
        r"integral(\1,\2,\3,\4)",
    ),
    (re.compile(r"\bIntegral\((.*),\s*\((\w+),([^,]+),([^,]+)\)\s*\)"), r"integral(\1,\2,\3,\4)"),
)
_BRACES = re.compile(r"(?<![_^\w}])\{\s*(?:\{[^{},]*,[^{}]*\}\s*(?:,\s*)?)+\}")
"""A matrix of Mathematica."""

_DIAGONAL = re.compile(r"\bdiag\s*\(\s*\[?(?P<entries>(?:[^()\[\]]|\([^()]*\))*)\]?\s*\)")
"""A diagonal matrix."""

_RATE_OF = re.compile(r"(?<=\w)('{1,3})(_(?:[^\W_]{1,20}|\{[^\W_]{1,20}\}))")
"""Dots before the subscript, as in ṗ_r."""

_BOUND = r"(\{(?:[^{}]|\{[^{}]*\})*\}|\\[A-Za-z]+|\w+)"
_INTEGRAL = re.compile(
    rf"(?:\\int(?:\\limits)?|∫)\s*_\s*{_BOUND}\s*\^\s*{_BOUND}(?P<body>[^\n;=]*)"
)
_OF_VARIABLE = re.compile(
    r"(?P<above>\\[dt]?frac\s*\{)?\s*(?:\\mathrm\s*\{\s*d\s*\}|d)\s*(?P<word>\\?[^\W\d_]+\w*)"
    r"\s*(?:(?P<brace>\})|(?P<over>/)|$|[.,]?\s*$)"
)
"""The dq of an integral: above a fraction, before a slash, or at the end."""


@final
class PlacedText:
    """A text whose signs know their positions in the one that was written."""

    def __init__(self, plain: str, places: list[int]) -> None:
        self.plain = plain
        self.places = places

    @classmethod
    def of(cls, text: str) -> PlacedText:
        """Return a text with unified signs and spaces, without line numbers, fonts and boxes."""
        placed = cls(*_unify(text))
        placed.drop_spaces()
        placed.splice((*m.span(), m[2] + m[1]) for m in _RATE_OF.finditer(placed.plain))
        placed.splice(_find_numbers(placed.plain))
        placed.splice(sorted(_find_fonts(placed.plain)))
        placed.splice(_find_boxes(placed.plain))
        placed.drop_spaces()
        return placed

    def splice(self, edits: Iterable[_Edit]) -> None:
        """Put other signs, which stand where the first one stood, for those in some spans."""
        kept, where, at = list[str](), list[int](), 0
        for start, end, spelling in edits:
            kept += [self.plain[at:start], spelling]
            where += self.places[at:start]
            where += [self.places[min(start, len(self.places) - 1)]] * len(spelling)
            at = end
        self.plain = "".join([*kept, self.plain[at:]])
        self.places = where + self.places[at:]

    def blank(self, start: int, end: int, spelling: str = "") -> None:
        """Put spaces, after what is spelled, in place of a span; all other signs stay in place."""
        blank = spelling.ljust(end - start)
        self.plain = self.plain[:start] + blank + self.plain[end:]

    def drop_spaces(self) -> None:
        """Keep one sign of each run of spaces, a line end if there is one."""
        # patterns with several optional spaces would try every way to share a run among them
        runs = re.finditer(r"\s\s+", self.plain)
        self.splice((*run.span(), "\n" if "\n" in run[0] else run[0][0]) for run in runs)

    def rewrite(self) -> None:
        """Put our spellings for those of other programs."""
        for table in _BRACES.finditer(self.plain):
            inner = table[0].replace("{", "[").replace("}", "]")
            self.blank(*table.span(), inner)
        if re.fullmatch(r"\s*\{.*==.*\}\s*", self.plain, re.DOTALL):
            for brace in (self.plain.index("{"), self.plain.rindex("}")):
                self.blank(brace, brace + 1)
        self.splice(
            [edit for match in _INTEGRAL.finditer(self.plain) for edit in _integrate(match)]
        )
        for pattern, spelling in _REWRITES:
            self.splice((*m.span(), m.expand(spelling)) for m in pattern.finditer(self.plain))
        self.splice((*m.span(), _write_diagonal(m)) for m in _DIAGONAL.finditer(self.plain))


_Edit: TypeAlias = tuple[int, int, str]
"""The first sign of a span, the one after it, and what is put in its place."""


def _unify(text: str) -> tuple[str, list[int]]:
    """Return a text with unified signs, and the original position of each sign."""
    signs: list[str] = []
    places: list[int] = []
    raised = dotted = False
    for place, original in enumerate(text):
        some = _SIGNS.get(original, "")
        if original in _RAISED:
            some = ("" if raised else "^") + _RAISED[original]
        elif original in _LOWERED or (dotted and original.isdecimal()):
            # the dots of a letter, three at most, come after its subscript
            dots = len(signs)
            while dots and len(signs) - dots < 3 and signs[dots - 1] == "'":
                dots -= 1
            signs.insert(dots, _LOWERED.get(original, original))
            places.insert(dots, place)
        elif original in ("è", "é") and text[max(0, place - 1) : place + 2].strip() == original:
            some = " "  # "is" in Italian and Portuguese
        elif not some:
            some = "".join(
                _DOTS.get(sign, sign)
                for sign in unicodedata.normalize(_form_of(original), original)
                if sign not in _ACCENTS
                and not (sign in _ACCENTS_OF_WORDS and _is_in_word(sign, text, place))
            )
        raised = original in _RAISED
        # in q̈1 as in q̈₁ the digit is a subscript
        ends = unicodedata.normalize("NFD", original)[-1]
        dotted = ends in _DOTS or (dotted and original.isdecimal())
        signs += some
        places += [place] * len(some)
    return "".join(signs), places


def _form_of(sign: str) -> Literal["NFD", "NFKD"]:
    """Return the form in which a sign is plain: mathematical alphabets stand for letters."""
    return "NFKD" if sign == "ℎ" or "\U0001d400" <= sign <= "\U0001d7ff" else "NFD"


_ACCENTS = "\u0300\u0301\u0327"
"""Accents of words such as période, which no letter of a formula has."""

_ACCENTS_OF_WORDS = "\u0302\u0303\u0308\u030a\u030c\u0328"
"""Accents of words such as rôle, equações, Lösung, för, rovnováž or pędu, where a letter such as q̈
may have some, too."""

_WORD_WITH_ACCENTS = re.compile(rf"(?:[^\W\d_][{_ACCENTS_OF_WORDS}]?){{3,}}")


def _is_in_word(sign: str, text: str, place: int) -> bool:
    """Whether an accent belongs to a word such as Lösung, not to a letter such as q̈."""
    for word in _WORD_WITH_ACCENTS.finditer(
        text, max(0, place - MOST_IN_WORD), place + MOST_IN_WORD
    ):
        # a word may be letters of a formula, of which the last has dots
        if word.start() <= place < word.end() - 1:
            base = unicodedata.normalize("NFC", word[0]).lower()
            long = len(base) > 3 and any(c in "äöü" for c in base)
            return sign != "\u0308" or long or base in ("für", "för", "när", "där")
    return False


def _find_numbers(plain: str) -> list[_Edit]:
    """Return the line numbers, if they count from 1 on."""
    numbers = list(_NUMBERED.finditer(plain))
    lines = sum(1 for line in plain.split("\n") if line.strip())
    if [int(number[1]) for number in numbers] != list(range(1, lines + 1)):
        return []
    return [(*number.span(), " ") for number in numbers]


def _find_fonts(plain: str) -> Iterator[_Edit]:
    """Yield what LaTeX's font commands write around words, and the backslashes in these."""
    for bare in _BARE_FONT.finditer(plain):
        yield *bare.span(), " "
    for font in _FONT.finditer(plain):
        # a space, as letters may touch the backslash of the command
        yield font.start(), font.start("word"), " "
        for at in range(*font.span("word")):
            if plain[at] == "\\":
                yield at, at + 1, ""
        yield font.end("word"), font.end(), ""


def _find_boxes(plain: str) -> Iterator[_Edit]:
    """Yield LaTeX's boxes with their braces."""
    boxes = {box.end() - 1: box.start() for box in _BOX.finditer(plain)}
    opened: list[int] = []
    for at, sign in enumerate(plain):
        if sign == "{":
            opened.append(at)
            if at in boxes:
                yield boxes[at], at + 1, " "
        elif sign == "}" and opened and opened.pop() in boxes:
            yield at, at + 1, " "


def _write_diagonal(match: re.Match[str]) -> str:
    """Return diag(a, b) as a table."""
    entries = re.findall(r"(?:[^,()]|\([^()]*\))+", match["entries"])
    rows = []
    for k, entry in enumerate(entries):
        rows.append(", ".join(entry if k == column else "0" for column in range(len(entries))))
    return f"[{'; '.join(rows)}]" if len(entries) <= MOST_IN_DIAGONAL else match[0]


MOST_IN_DIAGONAL = 12
"""Largest number of entries of diag(…)."""


def _integrate(integral: re.Match[str]) -> list[_Edit]:
    """Return the edits that write ∫_a^b f dx as integral(f, x, a, b); none without dx."""
    start, end = integral.span("body")
    variable = _OF_VARIABLE.search(integral.string, start, end)
    if variable is None:
        return []
    first, last = variable.span()
    inner = "1" if variable["brace"] or variable["over"] else ""
    above = (variable["above"] or "") + inner + (variable["brace"] or variable["over"] or "")
    bounds = f"),{variable['word']},({integral[1]}),({integral[2]}))"
    return [(integral.start(), start, "integral(("), (first, last, above), (end, end, bounds)]


_LINE = re.compile(
    r"(?:(?!\\\\|\\(?:Long)?(?:L|l)?(?:R|r)(?:eftr)?ightarrow|\\implies|\\iff|:\s)[^\n;])+"
)
_OF_LAGRANGIAN = re.compile(
    r"(?:\\partial(?![A-Za-z])|∂)\s*\{?\s*(?:\\mathcal\s*\{?\s*|\\mathscr\s*\{?\s*)?[LT](?![A-Za-z])"
)
"""Lagrange's equation as such, with ∂L or ∂T."""

_PARTIAL = r"(?:\\partial(?![A-Za-z])|∂|d)\s*"
_BETWEEN = re.compile(
    rf"(?<==)\s*(?:-?\s*(?:\\[dt]?frac\s*\{{\s*)?{_PARTIAL}(?:\\mathcal\s*)?(?P<slope>[LTH])\s*(?:/|\}}\s*\{{)"
    rf"\s*{_PARTIAL}(?:\\dot\s*)?[^=\n;,/+-]{{1,24}}|(?P<sum>[TK])\s*[-+]\s*[VU]\s*)="
)
"""∂L/∂q' or T − V between two equals signs, and the second of these."""

_ENERGY = re.compile(r"\s*\$?\s*(?:\\mathcal\s*)?\{?[LTVU]\}?\s*&?=")

_SUM_OF_FORCES = re.compile(
    r"(?:[∑Σ]|\\(?:sum|Sigma)(?![A-Za-z]))[^\n;:,=$]{0,60}(?::|="
    r"(?P<sum>(?:(?!\b(?:so|with|where|gives)\b)[^\n;:,$\\]|\\(?!\\|[RrLl]\w*arrow|implies|q?quad|[,;]))*))"
)
"""ΣM = J q'': of it counts what follows, if there is another equals sign."""

_INTEGER = re.compile(
    r"[,;]?\s*\(?\s*[A-Za-z]\s*(?:\\in(?![A-Za-z])|∈|ϵ)\s*\{?\s*(?:\\?Z|ℤ|\\mathbb\s*\{?\s*Z\s*\}?)\s*\}?\)?"
    r"(?![A-Za-z])"
    r"|[,;]?[^\S\n]?\(?(?:where |with |for |and )?(?:[A-Za-z] (?:is )?(?:an |any )?integer"
    r"|(?:any |all |every )?integers? [A-Za-z])(?![A-Za-z])\)?"
    r"|[,;]?[^\S\n]?\(?(?:where |with |for |and )?[A-Za-z] ?= ?(?:[-+±]?\d, ?){1,9}[-+±]?"
    r"(?:…|\.\.\.|\\l?dots(?![A-Za-z]))\)?"
)
_DIGITS = re.compile(
    r"\(?(?<![A-Za-z])(?:(?:rounded |gerundet )?(?:to|auf) )?\d{1,2} "
    r"(?:significant |decimal |signif\.? |sig\.? )?"
    r"(?:figures?|digits?|decimals?|places?|figs?\.?|Stellen|Dezimalen|s\.?f\.?|d\.?p\.?)(?![A-Za-z])\)?"
)
"""How many digits a number is given to."""

_IN_OTHER_UNITS = re.compile(
    r"(?:(?<=Hz)|(?<=rad/s)|(?<=rpm)) ?\([^()=\n]{1,20}(?:[=≈]|\\approx)[^()\n]{1,30}\)"
)
"""A frequency once more behind the first, as in 1.13 Hz (ω = 7.1 rad/s)."""

_ALMOST_EQUAL = re.compile(r"≈|≃|≅|\\approx(?![A-Za-z])|\\simeq(?![A-Za-z])|\\cong(?![A-Za-z])")
_APPROXIMATELY = re.compile(rf"(?:{_ALMOST_EQUAL.pattern})(?:(?!\\\\|,\s)[^\n;])*")

LETTER = r"\\?[^\W\d_]+(?:_?\{?[^\W_]*\}?)?"
"""A letter with its subscript, in text or LaTeX, as a regular expression."""

MOST_BRACKETS = 40
"""Deepest nesting of brackets."""

MOST_IN_WORD = 200
"""Longest word, also of letters written without spaces."""

_BINARY = tuple("+-*/^=")
_ELIDED = r"(?:(?:[cdjlmnstCDJLMNST]|[Qq]u)'(?=[^\W\d_]{4}))?"
"""What a word may begin with in French or Italian, as l'effort."""

_PLAIN_WORD = re.compile(rf"(?<![\\\w']){_ELIDED}[^\W\d_]+(?![\w_])[:,.]?")
_WORDS = re.compile(
    rf"(?<![\\\w']){_ELIDED}[^\W\d_]+(?![\w_])[:,.]?(?:[ :,.'-]+(?:[^\W\d_]+(?![\w_])[:,.]?))*"
)
_NUMBER_OF_BODY = re.compile(r" ?\d{1,2} ?(?=:)")
"""What numbers a word before a colon, as in block 2:."""

_LABEL = re.compile(
    r"[ \t]{0,9}(?:[*•·▪](?=\s)|(?:Eq|eq|Gl|Ec)\.? ?\(?\d{1,2}\)? ?:=?"
    r"|(?:\\?[^\W\d_]{1,8}_?\d?|[ijkn] ?= ?\d{1,2}) ?:(?=[\s\\][^\n]*=))"
)
"""What a line begins with where it is named, as q1: …, i = 2: … or Eq. 2: …."""

_NUMBER_BEFORE = re.compile(r"^\s*\(?(\d{1,2}|[a-z]|i{1,3})(?:\)|\.\)?)(?=\s)")
_NUMBER_AFTER = re.compile(r"\((\d{1,2}|[a-z]|i{1,3})\)(?=[\s.,;]{0,9}$)")


def _is_counted(numbers: list[str]) -> bool:
    """Return whether labels count from the first on, as 1, 2, a, b or i, ii."""
    counted = zip(*((str(k), chr(96 + k), "i" * k) for k in range(1, 27)), strict=True)
    return any((*numbers,) == labels[: len(numbers)] for labels in counted)


_SHORTEST_WORD = 3
_STOPS = re.compile(
    r"is|of|the|to|we|by|so|it|in|as|at|are|with|for|where|and|get|hence|thus|"
    r"damit|somit|daher|alors|und|ist|die|der|das|mit|aus|von|wir|also|la|el|lo|le|los|las|de|"
    r"del|en|es|por|que|con|donc|on|soit|ou|est|et|au|du|un|une|pour|ik|as"
)
"""Short words of sentences."""

_THAT = r",? (?:that|dass|que|che|dat)"
_DENIED = re.compile(
    rf"\b(?:not|nicht|pas|niet|never|no es|não é|non è)(?:(?: \w{{1,9}})?{_THAT})?$"
    rf"|\b(?:false|wrong|falsch|faux|falso|onwaar){_THAT}$"
)
"""How a sentence ends that denies the formula behind it."""

_NO_PROSE = re.compile(
    r"and|Eq|Matrix|Rational|Derivative|diff|dot|"
    r"alpha|beta|gamma|delta|epsilon|zeta|eta|theta|iota|kappa|lambda|"
    r"lamda|mu|nu|xi|omicron|pi|rho|sigma|tau|upsilon|phi|chi|psi|omega|"
    r"Alpha|Beta|Gamma|Delta|Theta|Lambda|Xi|Pi|Sigma|Phi|Psi|Omega"
)
UNITS = {
    "rad/s": ("1/s", "1"),
    "1/s": ("1/s", "1"),
    "s^-1": ("1/s", "1"),
    "Hz": ("1/s", "1"),
    "rad/s^2": ("1/s²", "1"),
    "rpm": ("1/s", "0.10471975511965977"),
    "s": ("s", "1"),
    "sec": ("s", "1"),
    "ms": ("s", "0.001"),
    "rad": ("rad", "1"),
    "°": ("rad", "0.017453292519943295"),
    "m": ("m", "1"),
    "cm": ("m", "0.01"),
    "mm": ("m", "0.001"),
    "km": ("m", "1000"),
    "m/s": ("m/s", "1"),
    "m/s^2": ("m/s²", "1"),
    "kg": ("kg", "1"),
    "N": ("N", "1"),
    "kN": ("N", "1000"),
    "N/m": ("N/m", "1"),
    "Nm": ("N·m", "1"),
    "J": ("N·m", "1"),
    "W": ("N·m/s", "1"),
}
"""The unit in SI of each unit that may follow a number, and the factor to it."""

_LONG = re.compile(rf"(?<!\d)[^\W\d]\w{{{MOST_IN_WORD}}}")
_PRIMES = re.compile(r"\s?'+|\^\{?(?:\s*\\prime)+\s*\}?")
_OF_TIME = re.compile(
    r"\s*(?P<brace>\{)?\s*(?:(?:\\left)?\s*\(\s*t\s*(?:\\right)?\s*\)|\[\s*t\s*\])(?(brace)\s*\})"
)
_OF_S = re.compile(r"\s*(?:\\left)?\(\s*s\s*(?:\\right)?\)")

OPEN, CLOSE = {"LPAR", "LSQB", "LBRACE"}, {"RPAR", "RSQB", "RBRACE"}
"""Kinds of brackets."""

_FIXED = {
    "+": ("PLUS", "+"),
    "-": ("MINUS", "-"),
    **dict.fromkeys(("*", r"\cdot", r"\times", r"\ast"), ("TIMES", "*")),
    **dict.fromkeys(("/", r"\div"), ("OVER", "/")),
    **dict.fromkeys(("^", "**"), ("POWER", "^")),
    **dict.fromkeys(("=", "==", ":="), ("EQUALS", "=")),
    **dict.fromkeys(("±", r"\pm"), ("PLUSMINUS", "+")),
    **dict.fromkeys(("∓", r"\mp"), ("PLUSMINUS", "-")),
    **dict.fromkeys(("(", r"\{"), ("LPAR", "(")),
    **dict.fromkeys((")", r"\}"), ("RPAR", ")")),
    "[": ("LSQB", "["),
    "]": ("RSQB", "]"),
    "{": ("LBRACE", "{"),
    "}": ("RBRACE", "}"),
    ",": ("COMMA", ","),
    ";": ("SEMICOLON", ";"),
    "\n": ("NEWLINE", "\n"),
    **dict.fromkeys(
        (
            *(r"\Rightarrow", r"\Leftrightarrow", r"\Longrightarrow", r"\rightarrow", r"\to"),
            *(r"\longrightarrow", r"\implies", r"\iff", r"\therefore", r"\qed", r"\square"),
        ),
        ("NEWLINE", "\n"),
    ),
}
"""The kind and the value of each token that is always spelled in one of these ways."""

BOTH_SIGNS = tuple(written for written, (kind, _) in _FIXED.items() if kind == "PLUSMINUS")
"""How two signs at once are written."""

_SIGN = re.compile(
    "|".join(re.escape(sign) for sign in sorted(_FIXED, key=len, reverse=True) if sign[0] != "\\")
)
_NO_EQUATION, _MAGNITUDE = "write an equation with =", "write abs(…) for a magnitude"
_REMEDIES = {
    **dict.fromkeys("<>:", _NO_EQUATION),
    **dict.fromkeys(
        (r"\neq", r"\ne", r"\le", r"\leq", r"\ge", r"\geq", r"\lt", r"\gt"), _NO_EQUATION
    ),
    **dict.fromkeys(("|", r"\lvert", r"\rvert", r"\vert", r"\mid"), _MAGNITUDE),
    r"\over": r"write \frac{…}{…} for \over",
    "!": "factorials have no place in a formula of mechanics",
    "%": "write a number",
    "°": "write it behind a number, as in q = 30°",
    "∫": "write integral(f, x, a, b) for an integral over x from a to b",
}
"""What to write instead of signs that formulas do not have."""

OPERATORS = {"PLUS", "MINUS", "TIMES", "OVER", "POWER", "EQUALS", "PLUSMINUS"}
"""Kinds of tokens that a line cannot end with."""


@final
@dataclass(frozen=True)
class Token:
    """A piece of a formula."""

    kind: str  # e.g. "NAME", "NUMBER", "PLUS"
    value: str  # the letter's name, the number or the sign
    start: int  # its first position in the text
    end: int  # the position after it


_COMMAND = re.compile(r"\\(?:[A-Za-z]+|.)", re.DOTALL)
_D = r"(?:\\mathrm\s*\{\s*d\s*\}|\\text\s*\{\s*d\s*\}|d)"
_FRACTION = re.compile(
    rf"\\[dt]?frac\s*\{{\s*{_D}\s*(?:\^\s*\{{?\s*(?P<order>[23])\s*\}}?)?\s*(?P<word>{LETTER})?\s*"
    rf"(?:\(\s*t\s*\)\s*)?\}}\s*\{{\s*{_D}\s*\\?,?\s*t\s*(?:\^\s*\{{?\s*[23]\s*\}}?)?\s*\}}"
)
_BY = re.compile(
    rf"(?:\\[dt]?frac\s*\{{\s*)?{_D}\s*(?:\^?\s*\{{?\s*(?P<order>[23])\s*\}}?)?\s*(?P<word>{LETTER})\s*"
    rf"(?:/|\}}\s*\{{)\s*{_D}\s*(?P<by>(?:\\dot\s*\{{?\s*)?{LETTER}(?:_\{{?[^\W_]+\}}?)?'?|)\s*"
    r"(?:\^\s*\{?\s*(?P<again>[23])\s*\}?)?\s*\}?"
)
_DOT = re.compile(
    r"\\(?P<dots>d{1,3})ot\s*"
    r"(?:\{\s*(?P<inner>[^{}]{0,80}(?:\{[^{}]{0,80}\}[^{}]{0,80})?)\}|(?P<word>\\[A-Za-z]+|[A-Za-z]))"
    r"(?P<subscript>\s*_\s*(?:\{[^{}]{1,20}\}|\w|\\[a-z]{1,20}))?"
)
_SUBSCRIPT = re.compile(
    r"\s*_\s*(?:\{(?P<long>(?:[^{}]|\{[^{}]{0,20}\}){1,40})\}|(?P<short>\\?[A-Za-z]+|\d))"
)
_ENVIRONMENT = re.compile(r"\\(?P<which>begin|end)\s*\{\s*(?P<name>[a-z]+)\*?\s*\}(?:\{[lcr|]*\})?")
_TABLES = {"matrix", "pmatrix", "bmatrix", "vmatrix", "smallmatrix", "Bmatrix"}
_IGNORED = re.compile(
    r"\\(?:left|right|[bB]igg?[lrm]?|displaystyle|textstyle|nonumber|notag|limits|quad|qquad"
    r"|,|;|:|!| |>|\(|\)|\[|\]|(?:hspace|label|tag\*?)\{[^{}]{0,80}\})(?![A-Za-z])\s*\.?"
)
_CASES = re.compile(r"\\left\s*\\\{(?=\s*\\begin)")
_SPACING = re.compile(r"\\(?:,|;|:|!| |>|\(|\)|\[|\])")


MOST_CHARACTERS = 20_000
"""Largest number of characters in a text."""

MOST_TOKENS = 4_000
"""Largest number of tokens in a text."""

_NUMBER = re.compile(r"(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?")
_WORD = re.compile(r"[^\W\d_](?:[^\W_]|_(?=[^\W_])|_\{[^{}]{1,20}\})*")
_INNER = rf"(?P<word>{LETTER})(?:\(\s*t\s*\))?"
_DERIVATIVE = re.compile(
    rf"(?:Derivative|diff)\(\s*{_INNER}\s*,\s*"
    r"(?P<by>\(\s*t\s*,\s*[123]\s*\)|t\s*,\s*[123]|t(?:\s*,\s*t)*)\s*\)"
)
_METHOD = re.compile(r"\.diff\(\s*(?P<by>t\s*,\s*[123]|t(?:\s*,\s*t)*)\s*\)")
_LEIBNIZ = re.compile(
    rf"d\s*(?:\^?\s*(?P<order>[23])\s*)?{_INNER}\s*/\s*"
    r"d\s*t(?:\s*(?:\^|\*\*)?\s*(?P<again>[23]))?(?!\w)"
)
_D_BY_DT = re.compile(
    r"d\s*(?:/\s*d\s*t|(?P<order>\^\s*2)\s*/\s*d\s*t\s*(?:\^|\*\*)\s*2)(?!\w)(?!\s*\^)"
)
_DOT_OF = re.compile(rf"(?P<dots>d{{1,2}})ot\(\s*{_INNER}\s*\)")
_END_OF_SENTENCE = re.compile(r"[.…]+(?=\s*(?:$|\n|\$|\\(?:end|\]|\)|\\|q?quad|label|tag)))")
_UNIT = re.compile(
    r"[^\S\n]*(?:\\[,;: ][^\S\n]*)?(?P<unit>°|(?:rad\s*/\s*s(?:\s*\^\s*\{?2\}?)?|1/s"
    r"|s\s*\^\s*\{?-1\}?|Hz|rpm|sec|s|ms|rad|cm|mm|km|m/s\s*\^\s*\{?2\}?"
    r"|m/s|m|kg|kN|N\s*/\s*m|N\s*m|Nm|N|J|W)(?=\s*(?:$|[\n,;.)=$])))"
)
_DECIMAL_COMMA = re.compile(r"(?<![\d.,])(?P<whole>\d+),(?P<part>\d+)(?![\d,]|\.\d)")


@final
class Scanner:
    """Cuts one text into tokens."""

    def __init__(self, text: str, letters: KnownLetters) -> None:
        if len(text) > MOST_CHARACTERS:
            raise FormulaError(
                f"expected at most {MOST_CHARACTERS:,} characters in a formula, got {len(text):,}"
            )
        self.letters = letters  # with those that the text itself defines on the way
        self.notes: list[str] = []  # what was set aside or read in one of several ways
        self.unknown: dict[str, int] = {}  # the words that are no letters, with their positions
        self._listed: list[Token] = []
        self._tables = 0
        self._depth = 0
        self._arrays: list[bool] = []
        self._text = text
        self._placed = PlacedText.of(_QUOTED.sub(r"\1 \2 \3", text))
        self._set_labels_aside()
        self._set_remarks_aside()
        self._placed.rewrite()
        if long := _LONG.search(self._plain):
            raise self._explain(
                f"a word of more than {MOST_IN_WORD} signs; write spaces between the letters",
                long.start(),
            )
        self._set_prose_aside()
        # remarks and prose became spaces
        self._placed.drop_spaces()

    @property
    def _plain(self) -> str:
        return self._placed.plain

    def scan(self) -> list[list[Token]]:
        """Cut the text into lines of tokens, with brackets around every argument."""
        at = 0
        while at < len(self._plain):
            at = self._next(at)
            if len(self._listed) > MOST_TOKENS:
                raise self._explain(f"the formula has more than {MOST_TOKENS:,} signs", at)
        lines: list[list[Token]] = []
        for line in join_lines(self._listed):
            closed = list(close_arguments(line, self.letters, self._text))
            lines += _write_signs_out(closed)
        return lines

    def _next(self, at: int) -> int:
        """Read the next piece at a position; return the position after it."""
        text = self._plain
        sign = text[at]
        if (sign.isspace() and sign != "\n") or sign in "$~":
            return at + 1
        if sign == "\\":
            return self._command(at)
        if sign == ":" and text[at + 1 : at + 2] in ("", " ", "\n", "\\"):
            return self._put("NEWLINE", "\n", at, at + 1)
        if text.startswith("&&", at) and not self._tables:
            return self._put("NEWLINE", "\n", at, at + 2)
        if sign == "&":
            return self._put("COMMA", ",", at, at + 1) if self._tables else at + 1
        if (match := _DECIMAL_COMMA.match(text, at)) and not self._is_in_list:
            return self._decimal_comma(match)
        if match := _NUMBER.match(text, at):
            return self._number(match[0], at, match.end())
        if sign.isalpha():
            return self._word(at)
        if sign == "." and text[at + 1 : at + 2] in ("*", "/", "^"):
            # the dot of Matlab's elementwise products and powers
            return at + 1
        if sign == "'" and self._listed and self._listed[-1].kind == "RPAR":
            return self._put("PRIME", "'", at, at + 1)
        if match := _METHOD.match(text, at):
            return self._method(match)
        if match := _SIGN.match(text, at):
            end = self._put(*_FIXED[match[0]], at, match.end())
            return self._measure(end, behind_bracket=True) if sign in ")}" else end
        if match := _END_OF_SENTENCE.match(text, at):
            return match.end()
        remedy = _REMEDIES.get(sign, "expected letters, numbers and + - * / ^ ( ) =")
        raise self._explain(f"{sign!r} has no meaning here; {remedy}", at)

    @property
    def _is_in_list(self) -> bool:
        """Whether commas separate arguments or entries here."""
        closed = 0
        for k in range(len(self._listed) - 1, -1, -1):
            kind = self._listed[k].kind
            closed += (kind in CLOSE) - (kind in OPEN)
            if closed < 0:
                called = self._listed[k - 1] if k > 0 else None
                several = called is not None and (
                    called.kind == "SYMPY"
                    or (called.kind == "FUNCTION" and FUNCTIONS[called.value].arguments > 1)
                )
                return kind == "LSQB" or several
        return False

    def _decimal_comma(self, match: re.Match[str]) -> int:
        """Read 1,5 as a decimal number, and say so; ask where it may be two numbers."""
        text, written = self._plain, match[0]
        follows = text[match.end() :].lstrip(" ")[:1]
        if match["part"] == "000" or follows == "=" or re.search(r"\d\.\d", text):
            raise self._explain(
                f"{written!r} may be one number or two; write {match['whole']}.{match['part']}, "
                "or a space after the comma",
                match.start(),
            )
        number = f"{match['whole']}.{match['part']}"
        self.notes.append(f"{written} is read as {number}")
        return self._number(number, match.start(), match.end())

    def _number(self, written: str, start: int, end: int) -> int:
        """Read a number and the unit behind it, if there is one."""
        self._put("NUMBER", written, start, end)
        return self._measure(end)

    def _measure(self, end: int, *, behind_bracket: bool = False) -> int:
        """Read the unit behind a number or a bracket, if any; return the position after it."""
        unit_match = _UNIT.match(self._plain, end)
        if unit_match is None:
            return end
        unit = re.sub(r"[\s{}]", "", unit_match["unit"])
        letters = re.findall(r"[A-Za-z]+", unit)
        if behind_bracket and unit in "NJWm":
            return end  # a letter that the text may define
        if behind_bracket:
            letters = [*"".join(letters)]  # km may be the product of two
        if letters and all(self.letters.find(word) is not None for word in letters):
            return end
        symbol, factor = UNITS[unit]
        self._put("TIMES", "*", *unit_match.span())
        if factor != "1":
            self._put("NUMBER", factor, *unit_match.span())
            self._put("TIMES", "*", *unit_match.span())
        return self._put("NAME", f"[{symbol}]", *unit_match.span())

    def _word(self, at: int) -> int:
        text = self._plain
        if match := _DERIVATIVE.match(text, at):
            return self._put_derivative(match["word"], _order(match["by"]), match)
        if match := _D_BY_DT.match(text, at):
            for _ in range(1 + bool(match["order"])):
                self._put("RATE", "d/dt", at, match.end())
            return match.end()
        if (match := _LEIBNIZ.match(text, at)) and self._is_moving(match["word"]):
            return self._put_derivative(match["word"], int(match["order"] or 1), match)
        if (match := _BY.match(text, at)) and (end := self._put_derivative_by(match)):
            return end
        if (match := _DOT_OF.match(text, at)) and self._is_moving(match["word"]):
            return self._put_derivative(match["word"], len(match["dots"]), match)
        match = _WORD.match(text, at)
        assert match is not None
        subscript, end = self._subscript(match.end())
        word = re.sub(r"[{}\\\s]", "", match[0]) + ("_" + subscript if subscript else "")
        if word in ("and", "or"):
            return self._put("NEWLINE", word, at, end)
        return self._put_word(word, at, end)

    def _method(self, match: re.Match[str]) -> int:
        """Read the derivative in q(t).diff(t)."""
        before = self._listed[-1] if self._listed else None
        if before is None or before.kind != "NAME":
            raise self._explain("expected a coordinate before .diff, e.g. q.diff(t)", match.start())
        rate = before.value + "'" * _order(match["by"])
        name = rate if before.value in self.unknown else self.letters.by_key.get(rate)
        if name is None:
            raise self._explain(f"{before.value!r} has no derivative by t", match.start())
        self._listed[-1] = Token("NAME", name, before.start, self._place_after(match.end()))
        return match.end()

    def _command(self, at: int) -> int:
        """Read the command at a position; return the position after it."""
        text = self._plain
        if text.startswith("\\\\", at):
            skip = re.compile(r"\\\\\s*(?:\[[^\]\n]{0,10}\])?").match(text, at)
            assert skip is not None
            kind = "SEMICOLON" if self._tables else "NEWLINE"
            return self._put(kind, ";", at, skip.end())
        if match := _FRACTION.match(text, at):
            return self._fraction_of_time(match)
        if (match := _BY.match(text, at)) and (end := self._put_derivative_by(match)):
            return end
        if match := _DOT.match(text, at):
            return self._read_dots(match)
        if match := _ENVIRONMENT.match(text, at):
            return self._environment(match)
        if match := _CASES.match(text, at):
            return match.end()
        if match := _IGNORED.match(text, at):
            # the dot of "\left." is no sign; elsewhere a dot after a space ends a sentence
            before = self._listed[-1:]
            if before and before[0].kind == "NEWLINE" and "quad" in match[0]:
                self._put("INDENT", " ", at, match.end())
            return match.end()
        if match := _SPACING.match(text, at):
            return match.end()
        match = _COMMAND.match(text, at)
        if match is None:
            raise self._explain("a backslash at the end has no meaning", at)
        return self._plain_command(match)

    def _plain_command(self, match: re.Match[str]) -> int:
        name, at, end = match[0][1:], match.start(), match.end()
        if match[0] in _FIXED:
            return self._put(*_FIXED[match[0]], at, end)
        if match[0] in _REMEDIES:
            raise self._explain(_REMEDIES[match[0]], at)
        if name in ("frac", "dfrac", "tfrac"):
            self._put("FRACTION", "frac", at, end)
            return self._brace(self._brace(end))
        function = SPELLINGS.get(name, name)
        if function == "sqrt" and self._plain.startswith("[", end):
            raise self._explain("write other roots than the square root as powers", at)
        if function in FUNCTIONS:
            self._put("FUNCTION", function, at, end)
            return end
        if not name.isalpha():
            raise self._explain(f"the command \\{name} has no meaning in a formula", at)
        subscript, end = self._subscript(end)
        return self._put_word(name + subscript, at, end)

    def _subscript(self, at: int) -> tuple[str, int]:
        """Return the subscript at a position, and the position after it."""
        subscript = _SUBSCRIPT.match(self._plain, at)
        if not subscript:
            return "", at
        return re.sub(r"[\\\s,{}]", "", subscript["long"] or subscript["short"]), subscript.end()

    def _brace(self, at: int) -> int:
        """Read an argument of a fraction, and put braces where it has none, as in frac12."""
        text = self._plain
        while at < len(text) and text[at].isspace():
            at += 1
        sign = text[at : at + 1]
        if not sign:
            raise self._explain("expected two arguments in braces after \\frac", at - 1)
        if sign == "{":
            return self._read_braces(at)
        if not (sign.isalpha() or sign.isdigit() or sign == "\\"):
            raise self._explain("expected an argument in braces after \\frac", at)
        self._put("LBRACE", "{", at, at + 1)
        if sign.isdigit():
            end = self._put("NUMBER", sign, at, at + 1)
        else:
            end = self._command(at) if sign == "\\" else self._put_word(sign, at, at + 1)
        return self._put("RBRACE", "}", end - 1, end)

    def _read_braces(self, at: int) -> int:
        """Read an argument in braces to its end."""
        depth = self._depth
        at = self._next(at)
        while at < len(self._plain) and self._depth > depth:
            at = self._next(at)
        if self._depth > depth:
            raise self._explain("a brace is not closed", len(self._plain) - 1)
        return at

    def _fraction_of_time(self, match: re.Match[str]) -> int:
        order = int(match["order"] or 1)
        if match["word"]:
            if not self._is_moving(match["word"]):
                command = _COMMAND.match(self._plain, match.start())
                assert command is not None
                return self._plain_command(command)
            return self._put_derivative(match["word"], order, match)
        for _ in range(order):
            self._put("RATE", "d/dt", match.start(), match.end())
        return match.end()

    def _read_dots(self, match: re.Match[str]) -> int:
        inner = (match["inner"] or match["word"] or "").strip()
        word = re.sub(r"[\\\s_{},]|\(t\)", "", inner + (match["subscript"] or ""))
        if not word.isalnum():
            raise self._explain(
                "expected a single letter below the dots, e.g. \\ddot{\\theta}_1; write d/dt "
                "before brackets",
                match.start(),
            )
        return self._put_word(word + "'" * len(match["dots"]), match.start(), match.end())

    def _environment(self, match: re.Match[str]) -> int:
        opens = match["which"] == "begin"
        table = match["name"] in _TABLES
        if match["name"] == "array":
            # a matrix within brackets, lines elsewhere
            before = self._listed[-1:]
            if opens:
                self._arrays.append(bool(before) and before[0].kind in ("LSQB", "LPAR"))
            table = self._arrays[-1] if self._arrays else False
            if not opens and self._arrays:
                self._arrays.pop()
        if table:
            self._tables += 1 if opens else -1
            kind = "LSQB" if opens else "RSQB"
            if match["name"] == "vmatrix" and opens:
                self._put("FUNCTION", "det", *match.span())
            return self._put(kind, "[" if opens else "]", match.start(), match.end())
        return match.end()

    def _set_labels_aside(self) -> None:
        """Replace by spaces what names or numbers lines: q1: …, Eq. 2: …, 1. …, … (2)."""
        lines = [line for line in re.finditer(r"[^\n]+", self._plain) if not line[0].isspace()]
        named = (_LABEL.match(self._plain, line.start()) for line in lines)
        labels = [label.span() for label in named if label]
        for number in (_NUMBER_BEFORE, _NUMBER_AFTER):
            numbers = [match for line in lines if (match := number.search(line[0]))]
            # a single number may as well be a factor
            if len(numbers) == len(lines) > 1 and _is_counted([match[1] for match in numbers]):
                labels += [
                    (line.start() + match.start(), line.start() + match.end())
                    for line, match in zip(lines, numbers, strict=True)
                ]
        self._set_aside(labels)

    def _set_remarks_aside(self) -> None:
        """Replace by spaces what a formula is about: Lagrange's equation, integers, decimals."""
        lines = [line for line in _LINE.finditer(self._plain) if line[0].strip()]
        remarks = [line.span() for line in lines if _OF_LAGRANGIAN.search(line[0])]
        if all(_OF_LAGRANGIAN.search(line[0]) or _ENERGY.match(line[0]) for line in lines):
            remarks = []  # it is the equation itself, with a Lagrangian that is given
        for match in _BETWEEN.finditer(self._plain):
            if self.letters.find(match["slope"] or match["sum"]) is None:
                remarks.append(match.span())
        for remark in (_INTEGER, _DIGITS, _IN_OTHER_UNITS):
            remarks += [match.span() for match in remark.finditer(self._plain)]
        if self.letters.find("Sigma") is None:
            for match in _SUM_OF_FORCES.finditer(self._plain):
                chained = "=" in (match["sum"] or "")
                remarks.append((match.start(), match.start("sum") if chained else match.end()))
        for line in lines:
            for match in _APPROXIMATELY.finditer(self._plain, *line.span()):
                if "=" in self._plain[line.start() : match.start()]:
                    remarks.append(match.span())
        self._set_aside(remarks)
        for match in _ALMOST_EQUAL.finditer(self._plain):
            self._placed.blank(*match.span(), "=")

    def _set_aside(self, spans: list[tuple[int, int]]) -> None:
        """Replace parts of the text by spaces, and tell them."""
        for first, last in sorted(spans):
            said = " ".join(self._quote(first, last).strip(" ,;").split())
            self.notes.append(f"set aside: '{said}'")
            self._placed.blank(first, last)

    def _set_prose_aside(self) -> None:
        """Replace words around formulas by spaces, or by a line end between two of them."""
        steps = ((sign == "{") - (sign == "}") for sign in self._plain)
        depths = list(accumulate(steps))
        for run in reversed(list(_WORDS.finditer(self._plain))):
            words = list(_PLAIN_WORD.finditer(self._plain, *run.span()))
            prose = [word for word in words if not depths[word.start()] and self._is_prose(word)]
            if not prose:
                continue
            first, last = prose[0].start(), prose[-1].end()
            before = self._plain[:first].rstrip(" ")
            after = self._plain[last:].lstrip(" :,.")
            if before.endswith("(") and after.startswith(")"):
                first, last = len(before) - 1, self._plain.index(")", last) + 1
                self._placed.blank(first, last)
                continue
            joined = before[-1:] not in ("", "\n", *",;.:)}$") and before[-1:] in _BINARY
            joined |= after[:1] in (*_BINARY, "(", "[", "_", "^", "'") and after[:1] not in (
                "-",
                "",
            )
            ends = prose[-1][0].endswith(":") or bool(_STOPS.fullmatch(prose[-1][0].lower()))
            # several words before a bracket are no name of a function
            ends |= len(prose) > 1 and before[-1:] not in _BINARY
            if joined and not ends:
                continue
            if numbered := _NUMBER_OF_BODY.match(self._plain, last):
                last = numbered.end()
            while last < len(self._plain) and self._plain[last] in " :,.":
                last += 1
            said = " ".join(self._quote(first, last).strip(" :,").split())
            if after[:1] not in ("", "\n") and _DENIED.search(said.lower()):
                raise self._explain("the sentence denies this formula; write what holds", first)
            self.notes.insert(0, f"set aside: '{said}'")
            between = before and before[-1] != "\n" and after
            self._placed.blank(first, last, "\n" if between else "")

    def _is_prose(self, word: re.Match[str]) -> bool:
        """Return whether a word belongs to a sentence, not to a formula."""
        said = word[0].rstrip(":,.").rpartition("'")[2]
        if _STOPS.fullmatch(said.lower()):
            return self.letters.find(said) is None and self._split(said, 0) is None
        if len(said) == 1 and said.isupper() and word[0].endswith(":"):
            return self.letters.find(said) is None  # a point or a body, as in "about O:"
        if said == "I" and self.letters.find(said) is None:
            verb = _PLAIN_WORD.match(self._plain, word.end() + 1)
            return verb is not None and self._is_prose(verb)
        if len(said) < _SHORTEST_WORD or _NO_PROSE.fullmatch(said):
            return False
        follows = self._plain[word.end() : word.end() + 3]
        if follows[:1] in ("(", "[", "{", "_", "^", "'") and follows != "'s ":
            return False
        if self.letters.find(said) is not None:
            return False
        if SPELLINGS.get(said.lower(), said.lower()) in FUNCTIONS and not word[0].endswith(":"):
            return False
        return self._split(said, 0) is None and self._find_rate(said) is None

    def _quote(self, start: int, end: int) -> str:
        """Return what was written at some positions."""
        return self._text[self._placed.places[start] : self._place_after(end)]

    def _put(self, kind: str, value: str, start: int, end: int) -> int:
        """Add a token; return the position after it."""
        self._depth += (kind in OPEN) - (kind in CLOSE)
        if self._depth > MOST_BRACKETS:
            raise self._explain(f"brackets are nested more than {MOST_BRACKETS} deep", start)
        self._listed.append(Token(kind, value, self._placed.places[start], self._place_after(end)))
        return end

    def _put_word(self, word: str, at: int, end: int) -> int:
        """Read a word, with the primes after it, as a letter, a function or several of them."""
        text = self._plain
        primes = _PRIMES.match(text, end)
        dots = _count_primes(primes) if primes else 0
        if primes and dots:
            end = primes.end()
        name = self.letters.find(word + "'" * dots)
        if name is not None:
            self._put("NAME", name, at, end)
            kind = self.letters.kinds[name]
            if kind in ("other", "input") and self.letters.kinds.get("s") == "other":
                of_s = _OF_S.match(text, end)
                return of_s.end() if of_s else end
            of_time = _OF_TIME.match(text, end)
            if of_time and kind in ("coordinate", "velocity", "acceleration", "input"):
                end = of_time.end()
                if (after := _PRIMES.match(text, end)) and _count_primes(after):
                    self._listed.pop()
                    return self._put_word(word + "'" * _count_primes(after), at, after.end())
            return end
        if not dots and word in ("Eq", "Matrix", "Rational", "Derivative"):
            return self._put("SYMPY", word, at, end)
        function = self.letters.functions.get(word) or SPELLINGS.get(word, word)
        if not dots and function in FUNCTIONS:
            return self._put("FUNCTION", function, at, end)
        if "_" in word and not dots and (name := self._find_numbered(word.partition("_")[0])):
            return self._put("NAME", name, at, end)
        # q_tt is no product with the time
        pieces = None if word.endswith(("_t", "_tt")) else self._split(word, dots)
        if pieces is None and not dots and (rate := self._find_rate(word)):
            return self._put("NAME", rate, at, end)
        if pieces is None:
            self.unknown.setdefault(word + "'" * dots, at)
            of_time = _OF_TIME.match(text, end)
            return self._put("NAME", word + "'" * dots, at, of_time.end() if of_time else end)
        for k, (piece, start, stop) in enumerate(pieces):
            last = k == len(pieces) - 1
            place = (at + start, end if last else at + stop)
            if piece.isdigit():
                self._put("NUMBER", piece, *place)
            elif piece in FUNCTIONS:
                self._put("FUNCTION", piece, *place)
            else:
                self._put("NAME", piece, *place)
        return end

    def _find_numbered(self, word: str) -> str | None:
        """Return a letter that is asked for in several values, as omega1 and omega2."""
        names = [self.letters.find(word), self.letters.find(f"{word}1")]
        asked = [name for name in names if name and self.letters.kinds[name] == "other"]
        return asked[0] if len(asked) == 2 else None

    def _find_rate(self, word: str) -> str | None:
        """Return the rate that a word such as dq, ddq or q_tt denotes, if any."""
        letter, _, times = word.partition("_")
        if times in ("t", "tt"):
            word = f"{'d' * len(times)}{letter}"
        for prefix, primes in (("dd", "''"), ("d", "'")):
            stem = self.letters.find(word.removeprefix(prefix)) if word.startswith(prefix) else None
            if stem is not None and stem in self.letters.rates:
                return self.letters.find(stem + primes)
        return None

    def _split(self, word: str, dots: int) -> list[tuple[str, int, int]] | None:
        """Split letters written without spaces, as in mgl; return None if a part is unknown."""
        spots = [k for k, sign in enumerate(word) if sign != "_"]
        whole = word.replace("_", "")
        best: list[list[tuple[str, int, int]] | None] = [None] * len(whole) + [[]]
        for first in range(len(whole) - 1, -1, -1):
            spend()
            for last in range(min(len(whole), first + self.letters.longest), first, -1):
                rest = best[last]
                if rest is None:
                    continue
                piece = whole[first:last]
                dot_marks = "'" * dots if last == len(whole) else ""
                name = self._meaning(piece, dot_marks, whole[last : last + 1])
                if name is not None:
                    place = (name, spots[first], spots[last - 1] + 1)
                    best[first] = [place, *rest]
                    break
        return best[0]

    def _meaning(self, piece: str, dots: str, following: str) -> str | None:
        name = self.letters.by_key.get(piece + dots) or self.letters.find(piece + dots)
        if name is not None:
            return name
        function = SPELLINGS.get(piece, piece)
        if function in FUNCTIONS and not dots and len(piece) > 2 and following:
            return function
        return None

    def _is_moving(self, word: str) -> bool:
        """Return whether a word is a letter with a rate."""
        return self.letters.find(clean(word) + "'") is not None

    def _put_derivative(self, word: str, order: int, match: re.Match[str]) -> int:
        """Add a letter's time derivative; return the position after it."""
        return self._put_word(clean(word) + "'" * order, match.start(), match.end())

    def _put_derivative_by(self, match: re.Match[str]) -> int:
        """Add d²u/dφ² or ∂L/∂q', not by the time; return the position after it, or 0."""
        primes = "'" * (match["by"].count("'") + match["by"].count("\\dot"))
        by = self.letters.find(clean(re.sub(r"\\dot|'", "", match["by"])) + primes)
        word, order = self.letters.find(clean(match["word"])), int(match["order"] or 1)
        if by is None or by not in self.letters.rates or order != int(match["again"] or 1):
            return 0
        if word is None and self.letters.find("d") is None:
            self.unknown.setdefault(clean(match["word"]), match.start())
            return self._put("NAME", clean(match["word"]), *match.span())
        if word is None:
            return 0
        slope, along = self.letters.node(word), self.letters.node(by)
        velocities = {name for name, kind in self.letters.kinds.items() if kind == "velocity"}
        if slope.letters & {along.name, *velocities}:
            for _ in range(order):
                slope = tree.rate(slope, {along.name: tree.number(1)})
        elif word in self.letters.rates:
            # by the chain rule du/dφ = u'/φ', and once more for the second derivative
            turning = self.letters.node(self.letters.rates[by])
            for _ in range(order):
                slope = tree.divide(tree.rate(slope, self.letters.rate_nodes), turning)
        else:
            slope = tree.number(0)
        name = f"d{order}_{word}_{by}"
        self.letters = self.letters.define(
            name, slope.put_at(self._placed.places[match.start()]), {}
        )
        return self._put("NAME", name, *match.span())

    def explain_unknown(self) -> FormulaError:
        """Return an error that names the unknown letters."""
        names = list(self.unknown)
        known = [name for name in self.letters.kinds if "'" not in name]
        hints = []
        for name in names[:6]:
            near = get_close_matches(name.rstrip("'"), known, n=1, cutoff=0.6) or [
                letter for letter in known if letter.lower() == name.rstrip("'").lower()
            ]
            hints.append(f"{name!r}" + (f" (did you mean {near[0]!r}?)" if near else ""))
        listed = ", ".join(sorted(known))
        several = len(names) > 1
        message = (
            f"unknown letter{'s' if several else ''} {', '.join(hints)}; the letters of this "
            f"system are {listed}. Say what {'others mean' if several else 'it means'}, e.g. "
            f'--let "{names[0].rstrip(chr(39))} = …"'
        )
        return self._explain(message, self.unknown[names[0]], names)

    def _place_after(self, at: int) -> int:
        """Return the position in the text after the sign before a position."""
        return self._placed.places[at - 1] + 1

    def _explain(self, message: str, at: int, unknown: list[str] | None = None) -> FormulaError:
        """Return an error at a position."""
        place = (
            self._placed.places[min(at, len(self._placed.places) - 1)] if self._placed.places else 0
        )
        return FormulaError(message, self._text, place, unknown or ())


def clean(word: str) -> str:
    """Return a letter's name without LaTeX's markup and without (t)."""
    return re.sub(r"[\\{}\s]|\(t\)", "", word)


def _count_primes(primes: re.Match[str]) -> int:
    """Return the number of derivatives that primes denote."""
    return primes[0].count("'") + primes[0].count("\\prime")


_ENDS = ("NEWLINE", "SEMICOLON", "COMMA")
"""Kinds of tokens that end a line outside brackets."""


def join_lines(tokens: list[Token]) -> list[list[Token]]:
    """Return the lines; a line end within an equation, and no ; or , at depth 0, is dropped."""
    lines: list[list[Token]] = [[]]
    depth = 0
    for token in tokens:
        depth = max(0, depth + (token.kind in OPEN) - (token.kind in CLOSE))
        if depth == 0 and token.kind in _ENDS:
            lines.append([token])
        elif token.kind != "NEWLINE":
            lines[-1].append(token)
    joined: list[list[Token]] = []
    for line in filter(None, lines):
        # in q = π/2, −π/2 the sign begins another value
        listed = line[0].kind == "COMMA"
        line = line[line[0].kind in _ENDS :]
        indented = bool(line) and line[0].kind == "INDENT"
        line = [token for token in line if token.kind != "INDENT"]
        if not line:
            continue
        if joined and not listed and _continues(joined[-1], line, indented):
            joined[-1] += line
        else:
            joined.append(list(line))
    return joined


def _continues(before: list[Token], line: list[Token], indented: bool) -> bool:
    """Return whether a line continues the equation before it."""
    first = line[0].kind
    if before[-1].kind in OPERATORS or first in ("EQUALS", "TIMES", "OVER", "POWER"):
        return True
    if first not in ("PLUS", "MINUS"):
        return False
    if not _is_equation(before):
        return True
    # no line continues "= 0"; any other right side is continued by a line without =
    ends = before[-2].kind == "EQUALS" and before[-1].value == "0"
    return not ends and (indented or not _is_equation(line))


def _is_equation(line: list[Token]) -> bool:
    return any(token.kind == "EQUALS" for token in line)


def close_arguments(tokens: list[Token], letters: KnownLetters, text: str) -> Iterator[Token]:
    """Put brackets around arguments that have none: sin 2 q, cos q1, sqrt 3."""
    at = 0
    while at < len(tokens):
        token = tokens[at]
        yield token
        at += 1
        if token.kind != "FUNCTION":
            continue
        if at < len(tokens) and tokens[at].kind == "POWER":
            end = _find_end_of_exponent(tokens, at)
            yield from tokens[at:end]
            at = end
        is_matrix = at < len(tokens) and token.value == "det" and tokens[at].kind == "LSQB"
        if (
            not is_matrix
            and at < len(tokens)
            and tokens[at].kind in ("LPAR", "LBRACE", "FRACTION", "LSQB")
        ):
            continue
        find = _find_end_of_bracket if is_matrix else _find_end_of_argument
        end = find(tokens, at, letters)
        if end == at:
            place = tokens[at].start if at < len(tokens) else len(text) - 1
            raise FormulaError(
                f"expected an argument of {token.value}, e.g. {token.value}(q)", text, place
            )
        if end < len(tokens) and tokens[end].kind == "POWER":
            name = token.value
            raise FormulaError(
                f"{name} of a letter with a power is ambiguous; write {name}(q)^2 or {name}(q^2)",
                text,
                tokens[end].start,
            )
        yield Token("LPAR", "(", tokens[at].start, tokens[at].start)
        yield from tokens[at:end]
        yield Token("RPAR", ")", tokens[end - 1].end, tokens[end - 1].end)
        at = end


def _find_end_of_exponent(tokens: list[Token], at: int) -> int:
    """Return the end of an exponent between a function and its argument."""
    at += 1
    if at < len(tokens) and tokens[at].kind == "MINUS":
        at += 1
    if at < len(tokens) and tokens[at].kind in OPEN:
        return _find_end_of_bracket(tokens, at)
    return min(at + 1, len(tokens))


def _find_end_of_bracket(tokens: list[Token], at: int, _: KnownLetters | None = None) -> int:
    """Return the position after the bracket that is opened at a position."""
    depth = 0
    while at < len(tokens):
        depth += (tokens[at].kind in OPEN) - (tokens[at].kind in CLOSE)
        at += 1
        if not depth:
            break
    return at


def _find_end_of_argument(tokens: list[Token], at: int, letters: KnownLetters) -> int:
    """Return the end of an argument without brackets: numbers, then an angle or W t."""
    end = at
    while end < len(tokens) and tokens[end].kind == "NUMBER":
        end += 1
    while end < len(tokens) and tokens[end].kind == "NAME":
        name = tokens[end].value
        end += 1
        following = tokens[end] if end < len(tokens) else None
        to_time = following is not None and following.kind == "NAME" and following.value == "t"
        moving = letters.kinds.get(name) in ("coordinate", "time", "velocity")
        if moving or (name in letters.angles and not to_time) or not to_time:
            break
    return end


def _write_signs_out(line: list[Token]) -> list[list[Token]]:
    """Return a line with ± as two lines, one with each sign."""
    if all(token.kind != "PLUSMINUS" for token in line):
        return [line]
    lines = []
    for upper in ("+", "-"):
        signs = []
        for token in line:
            if token.kind == "PLUSMINUS":
                kind = "PLUS" if token.value == upper else "MINUS"
                token = replace(token, kind=kind, value="+" if kind == "PLUS" else "-")
            signs.append(token)
        lines.append(signs)
    return lines


def _order(by: str) -> int:
    digits = re.findall(r"[123]", by)
    return int(digits[0]) if digits else by.count("t")
