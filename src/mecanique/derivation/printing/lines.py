"""Break LaTeX formulas into lines of a page, by their estimated width."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence

PAGE = 335.0
"""Text width that formulas are fitted to, in points at a font size of 10 points."""

INLINE = 120.0
"""The widest formula that is set within a line of text [pt]."""

_INDENT = 20.0  # indentation of a continued line, \qquad
_LEFT = 0.3  # largest share of the page for the part before the equals sign
_ROWS = 24  # largest number of rows in one display
_TOGETHER = 8  # rows of a formula that stay on one page
_END = " \\\\\n"
_CONTINUED = "& \\qquad "
_DISPLAY = re.compile(r"\\begin\{align\*\}\n(.*?)\n\\end\{align\*\}", re.DOTALL)
_BREAKS = {"+", "-", "=", "<", ">", "\\leq", "\\geq"}
_DEEPEST = 6  # brackets nested deeper are not broken

_TOKEN = re.compile(r"\\[a-zA-Z]+|\\.|\s+|.", re.DOTALL)
_ARGUMENTS = {
    "\\frac": 2,
    "\\sqrt": 1,
    "\\dot": 1,
    "\\ddot": 1,
    "\\dddot": 1,
    "\\text": 1,
    "\\mathbf": 1,
    "\\operatorname": 1,
}
_WIDE = {"m": 8.8, "w": 7.2, "M": 10.7, "W": 9.5, "i": 3.5, "l": 3.0, "j": 4.1, "t": 3.6}
_WIDE |= {"+": 12.3, "-": 12.3, "=": 13.4, "(": 3.9, ")": 3.9, "|": 2.8, ",": 4.5, "/": 5.0}
_WIDE |= {"\\,": 1.7, "\\times": 12.3, "\\partial": 6.0, "\\left": 2.5, "\\right": 2.5}
_WIDE |= {"\\qquad": 20.0, "\\delta": 4.6, "\\sum": 14.4}
_FUNCTIONS = ("sin", "cos", "tan", "exp", "log", "tanh", "arcsin", "arccos", "arctan")
_USUAL, _LETTER_OF_TEXT, _SMALL = 5.9, 5.3, 0.75


def align(formulas: Sequence[str], page: float = PAGE) -> str:
    """Return formulas as the rows of an aligned environment, broken where they are too long."""
    sides = [formula.split(" = ", 1) for formula in formulas]
    split = all(len(side) == 2 for side in sides)
    left = max((width(side[0]) for side in sides), default=0.0)
    rest = page - left - 13.4
    if not split or (left > _LEFT * page and any(width(side[1]) > rest for side in sides)):
        rows = [line for formula in formulas for line in _rows(formula, "& ", page)]
        return _END.join(rows)
    rows = []
    for before, after in sides:
        rows += _rows(after, f"{before} &= ", rest)
    return _END.join(rows)


def display(formulas: Sequence[str], page: float = PAGE) -> str:
    """Return formulas as displays short enough for KaTeX, between which a page may break."""
    rows = align(formulas, page).split(_END)
    parts = [_END.join(rows[k : k + _ROWS]) for k in range(0, len(rows), _ROWS)]
    return "\n".join(f"\\begin{{align*}}\n{part}\n\\end{{align*}}" for part in parts)


def number_rows(text: str) -> str:
    """Return LaTeX with each formula of its displays numbered, at its last row."""

    def number_display(display: re.Match[str]) -> str:
        written, *rows = display[1].split(_END)
        starts = [k for k, row in enumerate(rows) if not row.startswith(_CONTINUED)]
        for k, row in enumerate(rows):
            number = "" if k in starts else " \\nonumber"
            # no page ends after the first formula, before the last, or within a short one
            start = max((s for s in starts if s < k), default=-1)
            kept = k in (*starts[:1], *starts[-1:]) or (k not in starts and k - start < _TOGETHER)
            written += f"{number} \\\\{'*' if kept else ''}\n{row}"
        return f"\\begin{{align}}\n{written}\n\\end{{align}}"

    return _DISPLAY.sub(number_display, text)


def width(formula: str) -> float:
    """Estimate the width of a formula, in points."""
    total = 0.0
    for atom in _cut(formula):
        if atom.startswith("\\frac"):
            above, below = _read_arguments(atom)
            total += 2.4 + max(width(above), width(below))
        elif atom.startswith(("\\text", "\\operatorname")):
            total += _LETTER_OF_TEXT * len(_read_arguments(atom)[0])
        elif atom.startswith("\\sqrt"):
            total += 10.0 + width(_read_arguments(atom)[0])
        elif atom.startswith(("_", "^")):
            total += _SMALL * width(atom[1:])
        elif "{" in atom:
            total += sum(width(group) for group in _read_arguments(atom))
        elif atom[1:] in _FUNCTIONS:
            total += 4.9 * len(atom[1:]) + 3.4
        elif not atom.isspace():
            total += _WIDE.get(atom, _USUAL)
    return total


def _rows(formula: str, start: str, page: float) -> Iterator[str]:
    """Yield the lines of a formula, each with as many terms as fit."""
    line, taken = start, 0.0
    first = True
    pieces = _split(formula, page - _INDENT, 0)
    if len(pieces) > 1 and pieces[-1][-2:] == " 0":  # not alone on a line
        pieces[-2:] = [f"{pieces[-2]} {pieces[-1]}"]
    for piece in pieces:
        wide = width(piece)
        if taken and taken + wide > (page if first else page - _INDENT):
            yield line.rstrip()
            line, taken, first = _CONTINUED, 0.0, False
        line, taken = f"{line}{piece} ", taken + wide
    yield line.rstrip()


def _split(formula: str, page: float, depth: int) -> list[str]:
    """Split a formula before its signs and relations; open a term wider than the page."""
    pieces, piece, level = list[str](), "", 0
    for atom in _cut(formula):
        level += _opens(atom)
        if level == 0 and atom in _BREAKS and piece.strip():
            pieces.append(piece.strip())
            piece = ""
        piece += atom
    pieces.append(piece.strip())
    if depth > _DEEPEST:
        return pieces
    return [part for piece in pieces for part in _open(piece, page, depth)]


def _open(piece: str, page: float, depth: int) -> list[str]:
    """Split a term: a wide fraction into a factor and its numerator, brackets into terms."""
    if width(piece) <= page:
        return [piece]
    atoms, level = list(_cut(piece)), 0
    for k, atom in enumerate(atoms):
        level += _opens(atom)
        if not atom.startswith("\\frac"):
            continue
        above, below = _read_arguments(atom)
        if len(_split(above, page, _DEEPEST + 1)) > 1:
            above = f"({above})"
        if (
            width(below) > page and level == 0
        ):  # a fraction cannot be broken, but what follows a stroke can
            atoms[k] = "" if above == "1" and len(atoms) > k + 1 else above
            over, under = "".join(atoms), f"/ ({below})"
            return [*_open(over, page, depth + 1), *_open(under, page, depth + 1)]
        if above != "1" and width(atom) > page / 2:
            head, rest = _divide_factors(above)
            if not rest and width(head) <= page:
                continue
            if not (head and rest) or width(head) > max(page / 3, width(below)):
                head, rest = "1", above
            atoms[k] = f"\\frac{{{head}}}{{{below}}} {rest}"
            return _open("".join(atoms), page, depth + 1)
    spans = [span for span in _find_brackets(atoms) if not _is_called(atoms, *span, page)]
    for start, end in sorted(spans, key=lambda span: span[0] - span[1]):
        around = width("".join([*atoms[: start + 1], *atoms[end:]]))
        for room in (page, max(page - around, page / 3)):
            parts = _split("".join(atoms[start + 1 : end]), room, depth + 1)
            parts[0] = f"{''.join(atoms[:start])}\\Bigl{atoms[start][-1]}{parts[0]}"
            parts[-1] += f"\\Bigr{atoms[end][-1]}{''.join(atoms[end + 1 :])}"
            if len(parts) > 1 and (room < page or max(map(width, parts)) <= page):
                return parts
    return [piece]


def _divide_factors(product: str) -> tuple[str, str]:
    """Return the factors of a product before its first sum in brackets, and those after them."""
    atoms = list(_cut(product))
    starts = (a for a, b in _find_brackets(atoms) if not _is_called(atoms, a, b, float("inf")))
    start = next(starts, len(atoms))
    return "".join(atoms[:start]).strip(), "".join(atoms[start:])


def _is_called(atoms: Sequence[str], start: int, end: int, page: float) -> bool:
    """Whether brackets hold the argument of a function, unless that is wider than a page."""
    before = [atom for atom in atoms[:start] if not atom.isspace()]
    while before and before[-1].startswith("^"):
        before.pop()
    called = bool(before) and (
        before[-1][1:] in _FUNCTIONS or before[-1].startswith("\\operatorname")
    )
    return called and width("".join(atoms[start:end])) <= page


def _find_brackets(atoms: Sequence[str]) -> Iterator[tuple[int, int]]:
    """Yield the positions of the outermost brackets, which matrices are not."""
    level, start = 0, 0
    for k, atom in enumerate(atoms):
        if _opens(atom) > 0:
            start = k if level == 0 else start
            level += 1
        elif _opens(atom) < 0:
            level -= 1
            if level == 0 and not atoms[start].startswith("\\begin"):
                yield start, k


def _opens(atom: str) -> int:
    if atom.startswith(("\\left", "\\Bigl", "\\begin")) or atom == "(":
        return 1
    return -1 if atom.startswith(("\\right", "\\Bigr", "\\end")) or atom == ")" else 0


def _cut(formula: str) -> Iterator[str]:
    """Yield a formula's atoms: commands with their arguments, scripts, brackets and signs."""
    tokens = _TOKEN.findall(formula)
    place = 0

    def group() -> str:
        nonlocal place
        while place < len(tokens) and tokens[place].isspace():
            place += 1
        start, level = place, 0
        while place < len(tokens):
            level += (tokens[place] == "{") - (tokens[place] == "}")
            place += 1
            if level == 0:
                break
        return "".join(tokens[start:place])

    while place < len(tokens):
        token = tokens[place]
        if token == "{":
            yield group()
            continue
        place += 1
        if token in ("_", "^"):
            yield token + group()
        elif token in ("\\left", "\\right", "\\Bigl", "\\Bigr"):
            place += 1
            yield token + tokens[place - 1]
        else:
            yield token + "".join(group() for _ in range(_ARGUMENTS.get(token, 0)))


def _read_arguments(atom: str) -> list[str]:
    """Return the arguments of a command, without braces."""
    groups = _cut(atom[atom.index("{") :])
    return [group[1:-1] for group in groups if group.startswith("{")]
