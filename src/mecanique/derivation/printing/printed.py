"""Printed expressions and equations: ordered terms that can be written in three formats."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass
from html import escape
from typing import final

from mecanique.derivation.printing.formulas import Product, names_in
from mecanique.derivation.printing.layout import write
from mecanique.derivation.printing.writers import Latex, MathML, Text, Writer
from mecanique.derivation.scalars.series import Series


class _Printed(ABC):
    """An object that can be written as text, LaTeX and MathML, and displayed in a notebook."""

    @abstractmethod
    def write(self, writer: Writer) -> str:
        """Write it in the format of a writer."""

    def text(self) -> str:
        """Return it as one line of text, e.g. q'' + 3 g sin(q)/(2 l) = 0."""
        return self.write(Text())

    def latex(self) -> str:
        """Return it in LaTeX, without dollar signs."""
        return self.write(Latex())

    def mathml(self) -> str:
        """Return it as one MathML element."""
        alt = escape(self.text(), quote=True)
        xmlns = "http://www.w3.org/1998/Math/MathML"
        row = self.write(MathML())
        return f'<math xmlns="{xmlns}" display="block" alttext="{alt}">{row}</math>'

    def __str__(self) -> str:
        return self.text()

    def _repr_latex_(self) -> str:
        return f"$\\displaystyle {self.latex()}$"

    def _repr_html_(self) -> str:
        """Show it in a notebook, even where no script renders LaTeX."""
        return self.mathml()


@final
@dataclass(frozen=True)
class Expression(_Printed):
    """A sum of terms in textbook order.

    Args:
        terms: the terms.
        decimals: whether fractions of numbers are written as decimals.
    """

    terms: tuple[Product, ...]
    decimals: bool = False

    @property
    def letters(self) -> frozenset[str]:
        """The names of its letters."""
        return frozenset().union(*(names_in(term) for term in self.terms))

    def write(self, writer: Writer) -> str:
        """Write it in the format of a writer."""
        return write(self.terms, writer, decimals=self.decimals)


@final
@dataclass(frozen=True)
class Equation(_Printed):
    """An equation of motion left = right, with inputs and other functions of time on the right.

    Args:
        left: the terms with accelerations, velocities and coordinates.
        right: the terms that depend on time alone.
        divisor: the monomial of parameters by which the derived equation was divided: derived =
            (left − right) × divisor.
    """

    left: Expression
    right: Expression
    divisor: Series

    def write(self, writer: Writer) -> str:
        """Write it in the format of a writer."""
        return writer.equation(self.left.write(writer), self.right.write(writer))
