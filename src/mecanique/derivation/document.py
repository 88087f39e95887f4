"""A derivation written out: symbols, steps and equations of motion as text, LaTeX or MathML."""

from __future__ import annotations

import textwrap
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from html import escape
from typing import final

from mecanique.derivation.glossary import Meaning, meanings
from mecanique.derivation.matrix_form import Linear, linear
from mecanique.derivation.printing.equations import Equation, equations, expression
from mecanique.derivation.printing.writers import Latex, MathML, Text, Writer
from mecanique.derivation.scalars.cancel import without_common_divisor
from mecanique.derivation.symbolic.derivation import Derivation

__all__ = ["Document", "Section"]

_MATH = '<math xmlns="http://www.w3.org/1998/Math/MathML" display="{}">{}</math>'
_DIVIDED = "Each line is divided by the numbers and parameters {}all its terms share."
_LINEAR = " The last line is the same in matrices: the equations are linear."
_STILL = "Nothing can move: there is no coordinate, and so no equation of motion."
_WIDTH = 100


@final
@dataclass(frozen=True)
class Section:
    """A step of a derivation, written out.

    Args:
        title: its name.
        explanation: its purpose, in plain text.
        formulas: its results, MathML elements.
    """

    title: str
    explanation: str
    formulas: tuple[str, ...]


@final
@dataclass(frozen=True)
class Document:
    """A symbolic derivation in print.

    Args:
        derivation: what to write out.
        method: name of its method.
    """

    derivation: Derivation
    method: str

    @property
    def title(self) -> str:
        """The name of the method for this mechanism."""
        first_kind = self.derivation.ties and self.method.startswith("Lagrange")
        return "Lagrange's equations with multipliers" if first_kind else self.method

    @cached_property
    def equations(self) -> tuple[Equation, ...]:
        """The equations of motion, one for each velocity, then those of the loops."""
        rows = [*self.derivation.rows, *(tie.demand for tie in self.derivation.ties)]
        return equations([without_common_divisor(row) for row in rows])

    @cached_property
    def linear(self) -> Linear | None:
        """The matrices of M q'' + C q' + K q = f if the equations are linear, else None."""
        return linear(self.derivation)

    def text(self, steps: bool) -> str:
        """Return it as text.

        Args:
            steps: whether to show more than the equations of motion.
        """
        lines = [equation.text() for equation in self.equations] or [_STILL]
        if not steps:
            return "\n".join(lines)
        writer = Text()
        out = [self._heading, "", "Symbols", *self._symbols_as_text(writer)]
        stages = self.derivation.stages
        for number, stage in enumerate(stages, 1):
            out += ["", f"{number}. {stage.title}", *_wrap(stage.explanation)]
            out += [f"     {result.write(writer)}" for result in stage.results]
        out += ["", f"{len(stages) + 1}. Equations of motion", *_wrap(self._closing)]
        out += [f"     {line}" for line in lines]
        if self.equations and self.linear is not None:
            out += ["", "   They are linear:"]
            out += [f"     {line}" for line in self.linear.text().splitlines()]
        for sentence in self._assumptions(writer):
            out += ["", *_wrap(sentence)]
        return "\n".join(out)

    def latex(self, steps: bool) -> str:
        """Return it in LaTeX; with steps, a fragment of a document.

        Args:
            steps: whether to show more than the equations of motion.
        """
        rows = [equation.latex().replace(" = ", " &= ", 1) for equation in self.equations]
        whole = "\\begin{aligned}\n" + " \\\\\n".join(rows) + "\n\\end{aligned}"
        if not rows:
            whole = f"\\text{{{_STILL}}}"
        if not steps:
            return whole
        writer = Latex()
        out = [f"\\section*{{{_tex(self._heading)}}}", "\\begin{description}"]
        for meaning in meanings(self.derivation):
            out.append(f"\\item[${_symbol(meaning, writer)}$] {_tex(meaning.sentence)}")
        out.append("\\end{description}")
        for stage in self.derivation.stages:
            out += [f"\\subsection*{{{_tex(stage.title)}}}", _tex(stage.explanation)]
            out += [f"\\[ {result.write(writer)} \\]" for result in stage.results]
        out += ["\\subsection*{Equations of motion}", _tex(self._closing), f"\\[ {whole} \\]"]
        if self.equations and self.linear is not None:
            out += ["They are linear:", f"\\[ {self.linear.latex()} \\]"]
        out += [_tex(sentence) for sentence in self._assumptions(Text())]
        return "\n".join(out)

    def mathml(self, steps: bool) -> str:
        """Return it in MathML; with steps, a fragment of an HTML page.

        Args:
            steps: whether to show more than the equations of motion.
        """
        if not steps:
            return "\n".join(equation.mathml() for equation in self.equations) or f"<p>{_STILL}</p>"
        writer = MathML()
        out = [f"<h3>{escape(self._heading)}</h3>", "<dl>"]
        for meaning in meanings(self.derivation):
            symbol = _MATH.format("inline", _symbol(meaning, writer))
            out.append(f"<dt>{symbol}</dt><dd>{escape(meaning.sentence)}</dd>")
        out.append("</dl>")
        for section in self.sections():
            out += [f"<h4>{escape(section.title)}</h4>", f"<p>{escape(section.explanation)}</p>"]
            out += section.formulas
        return "\n".join(out)

    def sections(self) -> tuple[Section, ...]:
        """Return the steps in MathML; the last holds the equations of motion."""
        writer = MathML()
        out = []
        for stage in self.derivation.stages:
            lines = [_MATH.format("block", result.write(writer)) for result in stage.results]
            out.append(Section(stage.title, stage.explanation, tuple(lines)))
        formulas = tuple(equation.mathml() for equation in self.equations)
        closing = " ".join([self._closing, *self._assumptions(Text())])
        if not formulas:
            closing = _STILL
        elif self.linear is not None:
            formulas += (self.linear.mathml(),)
            closing += _LINEAR
        return (*out, Section("Equations of motion", closing, formulas))

    @property
    def _heading(self) -> str:
        name = self.derivation.algebra.mechanism.name.replace("_", " ")
        return f"{name[:1].upper()}{name[1:]}: {self.title}"

    @property
    def _closing(self) -> str:
        if not self.equations:
            return ""
        if self.derivation.stages and self.derivation.closing:
            return f"{self.derivation.closing} {_DIVIDED.format('')}"
        return _DIVIDED.format("that ")

    def _symbols_as_text(self, writer: Writer) -> Iterator[str]:
        listed = meanings(self.derivation)
        width = max((len(meaning.name) for meaning in listed), default=0)
        for meaning in listed:
            root = "" if meaning.radicand is None else f", {_symbol(meaning, writer)}"
            yield f"  {meaning.name:<{width}}  {meaning.sentence}{root}"

    def _assumptions(self, writer: Writer) -> Iterator[str]:
        for assumption in self.derivation.assumptions:
            positive = expression(assumption.positive).write(writer)
            yield (
                f"Taken for granted: {assumption.subject} is {positive}, which must stay positive."
            )


def _wrap(sentence: str) -> list[str]:
    return textwrap.wrap(sentence, _WIDTH, initial_indent="   ", subsequent_indent="   ")


def _symbol(meaning: Meaning, writer: Writer) -> str:
    """A symbol, with the radicand if it is a root."""
    symbol = writer.letter(meaning.name, False, "")
    if meaning.radicand is None:
        return symbol
    root = writer.call("sqrt", expression(meaning.radicand).write(writer), "")
    return writer.equation(symbol, root)


def _tex(sentence: str) -> str:
    for sign in "&%$#_{}":
        sentence = sentence.replace(sign, f"\\{sign}")
    return sentence.replace("²", "\\textsuperscript{2}").replace("·", "\\textperiodcentered{}")
