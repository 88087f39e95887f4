"""Write a derivation out: symbols, steps and equations of motion as text, LaTeX or MathML."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import chain
from typing import final

from mecanique.derivation.glossary import Meaning, clashes, meanings
from mecanique.derivation.linear import Linear, linear
from mecanique.derivation.printing.equations import equations, expression
from mecanique.derivation.printing.lines import INLINE, PAGE, align, display, number_rows, width
from mecanique.derivation.printing.prose import escape as tex
from mecanique.derivation.printing.prose import find_points, spell_greek, to_html, to_latex
from mecanique.derivation.printing.writers import (
    Equation,
    Latex,
    MathML,
    Printed,
    Text,
    Writer,
    to_lines,
    to_math,
)
from mecanique.derivation.scalars.cancel import without_common_divisor
from mecanique.derivation.special_motions import special_motions_of
from mecanique.derivation.symbolic.derivation import (
    DISPLACEMENTS,
    LOOPS_IN_MOTION,
    NO_ENDING,
    REACTIONS,
    Assumption,
    Derivation,
    Ending,
    Left,
    Result,
)
from mecanique.derivation.symbolic.reduced import COEFFICIENTS
from mecanique.derivation.symbolic.result import INTEGRALS, result_of
from mecanique.wording import to_title

_COLUMNS = '<dl style="display: grid; grid-template-columns: fit-content(40%) 1fr; gap: 0.3em 1em">'
_CELL = ' style="width: auto"'
"""Jupyter gives terms and their meanings a fifth and four fifths of the width they are in."""
_DIVIDED = (
    "Each line is divided by the numbers and parameters {}all its terms share, or that stand "
    "before its acceleration."
)
_LINEAR = "The last line is the same in matrices: the equations are linear."
_EQUATIONS = "Equations of motion"
_RESULT = NO_ENDING.title
_REPLACED = (LOOPS_IN_MOTION, DISPLACEMENTS)
"""Steps that kinematic coefficients make needless."""
_STANDING = "Those that stand alone in a balance above are not repeated."
_STILL = "Nothing can move: there is no coordinate, and so no equation of motion."
_NONE_LEFT = "No equation of motion is left to solve."
_TAKEN = "Taken for granted: {} is"
_POSITIVE = "which must stay positive."
_HANGING = 25.0  # [pt], indentation of the meanings of symbols
_WIDTH = 100
_FRAGMENT = "% part of a document with \\usepackage{amsmath}"
_PREAMBLE = r"""\documentclass[a4paper]{article}
\usepackage[utf8]{inputenc}
\usepackage{amsmath}
\allowdisplaybreaks
\emergencystretch=3em
\setlength{\parindent}{0pt}
\addtolength{\topmargin}{-40pt}
\addtolength{\textheight}{80pt}
\clubpenalty=10000 \widowpenalty=10000 \displaywidowpenalty=10000
\makeatletter % headings are not hyphenated, and no page ends between a sentence and its table
\@beginparpenalty=10000
% near the end of a page, a heading begins the next one: \near{share of the page}{penalty}
\newcommand\near[2]{\par\vskip\z@\@plus#1\textheight\penalty-#2\vskip\z@\@plus-#1\textheight}
\renewcommand\section{\near{.15}{900}%
  \@startsection{section}{1}{\z@}{-3.5ex}{2.3ex}{\Large\bfseries\raggedright}}
\renewcommand\subsection{\near{.08}{100}%
  \@startsection{subsection}{2}{\z@}{-3.25ex}{1.5ex}{\large\bfseries\raggedright}}
\makeatother
\begin{document}"""


@final
@dataclass(frozen=True)
class Section:
    """A step of a derivation, written out."""

    title: str
    explanation: str  # its purpose, in plain text
    formulas: tuple[str, ...]  # its results, as MathML elements


@final
@dataclass(frozen=True)
class _Part:
    """A step, the equations of motion or their result, in any format."""

    title: str
    sentence: str
    lines: Sequence[Printed]
    matrices: Linear | None = None
    assumptions: Sequence[Assumption] = ()

    @property
    def keys(self) -> set[str]:
        """Its title with each of its lines."""
        return {f"{self.title}\n{line.write(Text())}" for line in self.lines} or {self.title}


@final
@dataclass(frozen=True, repr=False)
class Document:
    """A symbolic derivation, ready to be printed."""

    derivation: Derivation  # the derivation to write out
    method: str  # name of its method
    # symbols that derivations of the mechanism before it explain, and so its description
    explained: frozenset[str] = frozenset()
    ending: Ending = NO_ENDING  # what it comes to, by default what the equations are solved for
    special: bool = True  # whether special motions follow, where no ending is given
    repeated: frozenset[str] = frozenset()  # what stands elsewhere in the text it is part of
    closed: tuple[Ending, ...] = ()  # its last sections where they are known

    def __repr__(self) -> str:
        return f"<Document: {self.title}>"

    @property
    def title(self) -> str:
        """The name of the method for this mechanism."""
        first_kind = self.derivation.ties and self.method.startswith("Lagrange")
        return "Lagrange's equations with multipliers" if first_kind else self.method

    @cached_property
    def equations(self) -> tuple[Equation, ...]:
        """The equations of motion, one for each velocity, then the constraints of the loops."""
        if self.derivation.written is not None:
            return self.derivation.written
        rows = [*self.derivation.rows, *(tie.demand for tie in self.derivation.ties)]
        own = () if self.derivation.quasi else self.derivation.algebra.accelerations
        return equations([without_common_divisor(row) for row in rows], own=own)

    @cached_property
    def result(self) -> Ending:
        """What the last section says, and its lines: accelerations, forces and integrals."""
        return self.endings[0]

    @cached_property
    def endings(self) -> tuple[Ending, ...]:
        """The last sections: the result, and what it comes to in special motions."""
        if self.closed or self.ending.lines:
            return self.closed or (self.ending,)
        special = special_motions_of(self.derivation) if self.special else ()
        return (result_of(self.derivation), *special)

    @property
    def _eliminated(self) -> Ending:
        """The last section where equations alone would stop at forces of constraints."""
        ending = self.result if self.derivation.ties else NO_ENDING
        # of loops it has integrals alone, which the equations do without
        return ending if any(isinstance(line, Equation) for line in ending.lines) else NO_ENDING

    @cached_property
    def linear(self) -> Linear | None:
        """The matrices of M q'' + C q' + K q = f if the equations are linear, else None."""
        return None if self.derivation.written is not None else linear(self.derivation)

    @property
    def _matrices(self) -> Linear | None:
        """The matrices of linear equations; those of a single one are its coefficients."""
        return self.linear if len(self.equations) > 1 else None

    def text(self, steps: bool, symbols: bool = False) -> str:
        """Return the derivation as text."""
        writer = Text()
        if not steps:
            lines = [equation.text() for equation in self.equations] or [self._nothing]
            if not symbols:
                return "\n".join(lines)
            ending = self._eliminated
            lines += ["", *textwrap.wrap(ending.sentence, _WIDTH), ""] if ending.lines else []
            lines += [line.write(writer) for line in ending.lines]
            return "\n".join([*self._introduce(writer, steps=False), "", *lines])
        out = [self._heading, "", *self._introduce(writer, steps=True)]
        for number, part in enumerate(self._outline(steps=True), 1):
            out += ["", f"{number}. {part.title}", *_wrap(part.sentence)]
            out += [f"     {line.write(writer)}" for line in part.lines]
            if part.matrices is not None:
                out += ["", "   They are linear:"]
                out += [f"     {line}" for line in part.matrices.text().splitlines()]
            for assumption in part.assumptions:
                out += ["", *_wrap(_assume(assumption, writer))]
        return "\n".join(out)

    def latex(self, steps: bool, symbols: bool = False) -> str:
        """Return the derivation in LaTeX; with steps or symbols, as a fragment of a document."""
        if not (steps or symbols):
            if not self.equations:
                return f"\\text{{{self._nothing}}}"
            rows = [equation.write(Latex(self._letters)) for equation in self.equations]
            return f"\\begin{{aligned}}\n{align(rows)}\n\\end{{aligned}}"
        writer = Latex(self._letters)
        out = [_FRAGMENT, f"\\section*{{{self._convert(self._heading)}}}"]
        for paragraph in self._about:
            out.append(self._convert(paragraph) + "\n")
        listed = [meaning for meaning in self.meanings(steps) if not meaning.told]
        opening = "\\begin{description}\\setlength{\\itemsep}{0pt}\\setlength{\\parskip}{0pt}"
        out += [opening] if listed else []
        for letters, sentence, equality in _write_meanings(listed, writer):
            symbol = ", ".join(f"${letter}$" for letter in letters)
            said = self._convert(sentence)
            if equality and width(equality) < INLINE:
                said, equality = f"{said}, ${equality}$", ""
            out.append(f"\\item[{{\\normalfont {symbol}}}] {said}")
            if equality:
                out.append(display([equality], PAGE - _HANGING))
        out += ["\\end{description}"] if listed else []
        out += [self._convert(sentence) + "\n" for sentence in self._warn(steps)]
        for part in self._outline(steps):
            out += [f"\\subsection*{{{self._convert(part.title)}}}", self._convert(part.sentence)]
            out += [display([line.write(writer) for line in part.lines])] if part.lines else []
            if part.matrices is not None:
                out += ["They are linear:", display(part.matrices.lines())]
            for assumption in part.assumptions:
                positive = expression(assumption.positive).write(writer)
                said = self._convert(_TAKEN.format(assumption.subject))
                out.append(f"{said} ${positive}$, {_POSITIVE}\n")
        return "\n".join(out)

    def mathml(self, steps: bool, symbols: bool = False) -> str:
        """Return the derivation in MathML; with steps or symbols, as a fragment of an HTML page."""
        if not (steps or symbols):
            lines = [self._in_math(equation) for equation in self.equations]
            return "\n".join(lines or [f"<p>{self._nothing}</p>"])
        opening = self._open_html(self.meanings(steps), steps)
        return "\n".join([*opening, *self._write_html(steps, self._in_math)])

    def html(self, steps: bool = False) -> str:
        """Return the derivation for a notebook: its formulas wrap without a script."""
        # Reactions stand below the equations that were found from them
        reactions = [stage for stage in self.derivation.stages if stage.title == REACTIONS]
        letters = {name for name in self.derivation.reactions if reactions}
        listed = [*self._list_meanings(steps=True)]
        if not steps:
            named = (meaning for meaning in listed if letters.intersection(meaning.names))
            listed = [*self._list_meanings(steps=False), *named]
        below = () if steps else tuple(stage._repr_html_() for stage in reactions)
        writer = MathML(self._letters)
        lines = self._write_html(steps, lambda x: to_lines(x.write(writer), x.text()), below)
        return "\n".join([*self._open_html(listed, steps, _COLUMNS), *lines])

    def _outline(self, steps: bool) -> Iterator[_Part]:
        """Yield the steps, if asked for, the equations of motion, and what they come to."""
        if not steps:
            yield self._list_equations(steps=False)
            if self._eliminated.lines:
                yield _Part(_RESULT, self._eliminated.sentence, self._eliminated.lines)
            return
        said, printed = set[str](), set[str]()
        for part in self._list_parts():
            # what holds for all bodies is said once; what points back at one stays with it
            sentences = re.split(r"(?<=\.) ", part.sentence)
            new = [s for s in sentences if s not in said or s.startswith(("It ", "About it "))]
            said.update(sentences)
            lines = part.lines
            if part.title != _EQUATIONS:
                lines = [line for line in lines if line.write(Text()) not in printed]
            if part.title == REACTIONS and len(lines) < len(part.lines):
                new.append(_STANDING)
            for line in lines:
                printed.update((line.write(Text()), _mirror(line)))
            taken = [x for x in part.assumptions if _assume(x, Text()) not in self.repeated]
            part = replace(part, sentence=" ".join(new), lines=lines, assumptions=taken)
            if part.title == _RESULT:  # of which others may have more lines
                told = self.repeated.issuperset(line.write(Text()) for line in lines)
            else:
                told = part.keys <= self.repeated
            if (lines or new != [""]) and not (told and self.repeated):
                yield part

    @cached_property
    def _parts(self) -> tuple[_Part, ...]:
        return tuple(self._outline(steps=True))

    def set_beside(self, earlier: Sequence[Document], later: Sequence[Document]) -> Document:
        """Return it without what others state as well: the result stands once, at the end."""
        stated = set[str]()
        for part in chain.from_iterable(document._parts for document in earlier):
            stated |= part.keys if part.title not in (_EQUATIONS, _RESULT) else set()
            stated.update(_assume(taken, Text()) for taken in part.assumptions)
        for part in chain.from_iterable(document._parts for document in later):
            stated.update(line.write(Text()) for line in part.lines)
        return replace(self, repeated=frozenset(stated), closed=self.endings)

    def _list_parts(self) -> Iterator[_Part]:
        """Yield the steps, the equations of motion and the sections after them, as they are."""
        closing = self.result.sections or (self.result,)
        sections = [_Part(x.title, x.sentence, x.lines) for x in closing]
        reduced = any(part.title == COEFFICIENTS for part in sections)
        for stage in self.derivation.stages:
            told = stage.title in INTEGRALS and stage.explanation in closing[-1].sentence
            if not (told or (reduced and stage.title in _REPLACED)):
                yield _Part(stage.title, stage.explanation, stage.results)
        if not (reduced and self.derivation.quasi):  # whose displacements lead to one at once
            yield self._list_equations(steps=True)
        yield from sections
        for ending in self.endings[1:]:
            yield _Part(ending.title, ending.sentence, ending.lines)

    def _list_equations(self, *, steps: bool) -> _Part:
        """Return the section of the equations of motion."""
        solved = self.derivation.written is not None
        closing = self._closing if steps or solved else _DIVIDED.format("that ")
        matrices, taken = (self._matrices, self.derivation.assumptions) if steps else (None, ())
        sentence = closing if self.equations else self._nothing
        return _Part(_EQUATIONS, sentence, self.equations, matrices, taken)

    def _write_html(
        self, steps: bool, write: Callable[[Printed], str], below: Sequence[str] = ()
    ) -> Iterator[str]:
        """Yield a derivation as lines of HTML, with what comes below the equations of motion."""
        for part in self._outline(steps):
            if steps or part.title != _EQUATIONS:
                yield f"<h4>{self._set(part.title)}</h4>"
            if steps or part.title != _EQUATIONS or not part.lines:
                yield f"<p>{self._set(part.sentence)}</p>"
            yield from map(write, part.lines)
            if part.matrices is not None:
                yield from ("<p>They are linear:</p>", part.matrices.mathml())
            for assumption in part.assumptions:
                yield f"<p>{self._set(_assume(assumption, Text()))}</p>"
            if part.title == _EQUATIONS:
                yield from below

    def _open_html(
        self, listed: Sequence[Meaning], steps: bool, symbols: str = "<dl>"
    ) -> Iterator[str]:
        """Yield title, description, symbols and warnings as lines of HTML."""
        yield f"<h3>{self._set(self._heading)}</h3>"
        for sentence in self._about:
            yield f"<p>{self._set(sentence)}</p>"
        yield symbols
        shown = [meaning for meaning in listed if not meaning.told]
        for letters, sentence, equality in _write_meanings(shown, MathML(self._letters)):
            symbol = ", ".join(to_math(letter, "inline") for letter in letters)
            said = self._set(sentence)
            if equality:
                said += f", {to_math(equality, 'inline')}"
            yield f"<dt{_CELL}>{symbol}</dt><dd{_CELL}>{said}</dd>"
        yield "</dl>"
        yield from (f"<p>{self._set(sentence)}</p>" for sentence in self._warn(steps))

    @property
    def introduction(self) -> str:
        """The mechanism's description and warnings about ambiguous letters, in plain text."""
        return self._spell(" ".join([*self._about, *self._warn(steps=True)]))

    def symbols(self) -> tuple[tuple[str, str], ...]:
        """Return each symbol that the steps do not explain in MathML, with its meaning in words."""
        listed = [meaning for meaning in self._list_meanings(steps=True) if not meaning.told]
        return tuple(
            (to_math("<mo>,</mo>".join(letters), "inline"), self._spell(sentence))
            for letters, sentence, _ in _write_meanings(listed, MathML(self._letters))
        )

    def sections(self) -> tuple[Section, ...]:
        """Return the steps, the equations of motion and what they come to, in MathML."""
        out = []
        for part in self._outline(steps=True):
            lines = [self._in_math(line) for line in part.lines]
            sentences = [part.sentence, *(_assume(taken, Text()) for taken in part.assumptions)]
            if part.matrices is not None:
                lines.append(part.matrices.mathml())
                sentences.append(_LINEAR)
            said = " ".join(sentences)
            out.append(Section(self._spell(part.title), self._spell(said), tuple(lines)))
        return tuple(out)

    @property
    def _about(self) -> list[str]:
        """The mechanism's description and its source, by paragraphs."""
        return [] if self.explained else self.derivation.algebra.mechanism.about.splitlines()

    def meanings(self, steps: bool) -> tuple[Meaning, ...]:
        """Return the meanings of its symbols that have not been explained before."""
        every = self._list_meanings(steps)
        return tuple(meaning for meaning in every if not self.explained.issuperset(meaning.names))

    def _list_meanings(self, steps: bool) -> tuple[Meaning, ...]:
        endings = self.endings if steps else (self._eliminated,)
        return meanings(self.derivation, endings, steps=steps)

    def _warn(self, steps: bool) -> Iterator[str]:
        """Yield warnings about letters with two meanings."""
        matrices = steps and self._matrices is not None
        yield from clashes(self.derivation, steps=steps, matrices=matrices)

    def _introduce(self, writer: Text, *, steps: bool) -> Iterator[str]:
        """Yield the mechanism's description and its symbols, as lines of text."""
        for paragraph in self._about:
            yield from (*textwrap.wrap(paragraph, _WIDTH), "")
        yield "Symbols"
        listed = [meaning for meaning in self.meanings(steps) if not meaning.told]
        wide = max((len(meaning.names[0]) for meaning in listed), default=0)
        for letters, sentence, equality in _write_meanings(listed, writer):
            said = f"{sentence}, {equality}" if equality else sentence
            if len(letters) > 1:
                yield from _wrap(", ".join(letters), 2)
                yield from _wrap(said, 4)
            else:
                yield f"  {letters[0]:<{wide}}  {said}"
        for sentence in self._warn(steps):
            yield from ("", *textwrap.wrap(sentence, _WIDTH))

    def _in_math(self, line: Printed) -> str:
        """Return a line as an element of MathML; an equation of motion has its text, too."""
        said = line.text() if isinstance(line, Equation) else ""
        return to_math(line.write(MathML(self._letters)), alt=said)

    @property
    def _letters(self) -> Mapping[str, str]:
        """The letters of names that are words."""
        return self.derivation.algebra.ring.letters

    def _spell(self, sentence: str) -> str:
        return spell_greek(sentence, self._names, self._letters)

    def _set(self, sentence: str) -> str:
        return to_html(sentence, self._names, self._letters)

    def _convert(self, sentence: str) -> str:
        return to_latex(sentence, self._names, self._points, self._letters)

    @cached_property
    def _points(self) -> frozenset[str]:
        """The letters of points in the mechanism's description."""
        about = self.derivation.algebra.mechanism.about.splitlines()
        return frozenset().union(*map(find_points, about))

    @cached_property
    def _names(self) -> frozenset[str]:
        """Every symbol that is printed, and longer parameters that are only spoken of."""
        listed = self._list_meanings(steps=True)
        parameters = self.derivation.algebra.mechanism.parameters
        spoken = frozenset(p.symbol for p in parameters if len(p.symbol) > 1)
        return spoken.union(*(meaning.names for meaning in listed))

    @property
    def _heading(self) -> str:
        return f"{to_title(self.derivation.algebra.mechanism.name)}: {self.title}"

    @property
    def _nothing(self) -> str:
        """The sentence printed in place of equations when there are none."""
        written = self.derivation.written
        return _STILL if written is None else f"{self.derivation.closing} {_NONE_LEFT}"

    @property
    def _closing(self) -> str:
        if self.derivation.written is not None:
            return self.derivation.closing
        if not self.equations:
            return ""
        if self.derivation.stages and self.derivation.closing:
            return f"{self.derivation.closing} {_DIVIDED.format('')}"
        return _DIVIDED.format("that ")


def _assume(assumption: Assumption, writer: Writer) -> str:
    positive = expression(assumption.positive).write(writer)
    return f"{_TAKEN.format(assumption.subject)} {positive}, {_POSITIVE}"


def _mirror(line: Printed) -> str:
    """Return a line with a letter alone on its right, e.g. m x'' = R, the other way round."""
    if not isinstance(line, Result) or isinstance(line.left, Left):
        return ""
    return replace(line, left=line.right, right=line.left, shown=None).write(Text())


def to_page(parts: Sequence[str], name: str = "") -> str:
    """Assemble fragments of LaTeX into a complete document about something, equations numbered."""
    title = [f"\\begin{{center}}\\LARGE {tex(to_title(name))}\\end{{center}}"] if name else []
    return "\n".join([_PREAMBLE, *title, *map(number_rows, parts), "\\end{document}", ""])


def _wrap(sentence: str, indent: int = 3) -> list[str]:
    blank = " " * indent
    return textwrap.wrap(sentence, _WIDTH, initial_indent=blank, subsequent_indent=blank)


def _write_meanings(
    listed: Sequence[Meaning], writer: Writer
) -> Iterator[tuple[list[str], str, str]]:
    """Yield the letters of each meaning, its sentence, and its definition as an equality or ""."""
    for meaning in listed:
        letters = [writer.letter(name, False, "") for name in meaning.names]
        (first, *more), sentence = meaning.names, meaning.sentence
        if first in writer.letters and not more and "_" not in writer.letters[first].rstrip("'"):
            sentence = f"{first}, {sentence}"
        value = meaning.definition
        equality = "" if value is None else writer.equation(letters[0], value.write(writer))
        yield letters, sentence, equality
