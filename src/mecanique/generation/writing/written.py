"""Print equations of motion as a list of named results."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from html import escape
from typing import final

from mecanique.derivation.printing.lines import display, width
from mecanique.derivation.printing.prose import to_latex
from mecanique.derivation.printing.writers import Latex, MathML, Text, Writer, write
from mecanique.generation.writing.formulas import Line

_WIDTH = 100
_LABEL = 120.0  # [pt], the widest symbols with their meaning beside them, not below
_FRAGMENT = "% part of a document with \\usepackage{amsmath}"
_MATH = '<math xmlns="http://www.w3.org/1998/Math/MathML" display="{}">{}</math>'


@final
@dataclass(frozen=True)
class Part:
    """Formulas under a heading.

    Args:
        heading: the heading.
        said: a sentence about them; may be empty.
        lines: each name = right, or 0 = right.
        numbered: whether they are numbered.
    """

    heading: str
    said: str
    lines: tuple[Line, ...]
    numbered: bool = False

    def write(self, writer: Writer) -> tuple[str, ...]:
        """Write its lines in the format of a writer."""
        return tuple(_write(line, writer) for line in self.lines)


@final
@dataclass(frozen=True)
class Written:
    """Equations of motion as a list of named results.

    Args:
        title: the title.
        about: the mechanism's description, and how to read the list, by paragraphs.
        meanings: symbols with their meanings.
        recursion: the results in order.
        results: the equations of motion, then the constraints.
    """

    title: str
    about: tuple[str, ...]
    meanings: tuple[tuple[tuple[str, ...], str], ...]
    recursion: Part
    results: tuple[Part, ...]

    @cached_property
    def lines(self) -> tuple[str, ...]:
        """The results in order, as text, name = formula."""
        return self.recursion.write(Text())

    @cached_property
    def equations(self) -> tuple[str, ...]:
        """The equations of motion and the constraints, as text, formula = 0."""
        return tuple(line for part in self.results for line in part.write(Text()))

    def text(self) -> str:
        """Return the list as text."""
        out = list[str]()
        for paragraph in self.about:
            out += [*textwrap.wrap(paragraph, _WIDTH), ""]
        out.append("Symbols")
        listed = [(", ".join(names), sentence) for names, sentence in self.meanings]
        wide = max(len(names) for names, _ in listed)
        out += [f"  {names:<{wide}}  {sentence}" for names, sentence in listed]
        for part in self._parts:
            out += ["", part.heading, *textwrap.wrap(part.said, _WIDTH)]
            digits = len(str(len(part.lines)))
            for count, line in enumerate(part.write(Text()), 1):
                label = f"{f'({count})':>{digits + 2}}  " if part.numbered else ""
                out.append(f"  {label}{line}")
        return "\n".join(out)

    def latex(self) -> str:
        """Return the list in LaTeX, as a fragment of a document."""
        names = frozenset(name for names, _ in self.meanings for name in names)
        out = [_FRAGMENT, f"\\section*{{{to_latex(self.title, ())}}}"]
        out += [f"{to_latex(paragraph, names)}\n" for paragraph in self.about]
        out.append("\\begin{description}\\setlength{\\itemsep}{0pt}\\setlength{\\parskip}{0pt}")
        for symbols, sentence in self.meanings:
            said = ", ".join(self._latex_letter(name) for name in symbols)
            below = " \\hfill \\\\" if width(said) > _LABEL else ""
            out.append(f"\\item[{{{said}}}]{below} {to_latex(sentence, names)}")
        out.append("\\end{description}")
        for part in self._parts:
            out += [f"\\subsection*{{{part.heading}}}", to_latex(part.said, names)]
            rows = part.write(Latex())
            if part.numbered:
                rows = tuple(f"{row} \\tag{{{count}}}" for count, row in enumerate(rows, 1))
            out.append(display(rows))
        return "\n".join(out)

    def mathml(self) -> str:
        """Return the list in MathML, as a fragment of an HTML page."""
        out = [f"<h3>{escape(self.title)}</h3>"]
        out += [*(f"<p>{escape(paragraph)}</p>" for paragraph in self.about), "<dl>"]
        out += [f"<dt>{said}</dt><dd>{escape(each)}</dd>" for said, each in self.symbols()]
        out.append("</dl>")
        for heading, said, formulas in self.sections():
            out += [f"<h4>{escape(heading)}</h4>", *([f"<p>{escape(said)}</p>"] if said else [])]
            out += formulas
        return "\n".join(out)

    def symbols(self) -> tuple[tuple[str, str], ...]:
        """Return each symbol in MathML, with its meaning in words."""
        found = []
        for names, sentence in self.meanings:
            symbol = "<mo>,</mo>".join(MathML().letter(name, False, "") for name in names)
            found.append((_MATH.format("inline", symbol), sentence))
        return tuple(found)

    def sections(self) -> Iterator[tuple[str, str, tuple[str, ...]]]:
        """Yield heading, explanation and formulas in MathML of each part."""
        for part in self._parts:
            rows = part.write(MathML())
            yield part.heading, part.said, tuple(_MATH.format("block", row) for row in rows)

    def __str__(self) -> str:
        return self.text()

    @property
    def _parts(self) -> tuple[Part, ...]:
        return (self.recursion, *self.results)

    def _latex_letter(self, name: str) -> str:
        return name if name == "…" else f"${Latex().letter(name, False, '')}$"


def _write(line: Line, writer: Writer) -> str:
    right = write(line.right.terms, writer, decimals=True)
    if line.name == "0":
        return writer.equation(right, writer.number("0"))
    return writer.equation(writer.letter(line.name, False, ""), right)
