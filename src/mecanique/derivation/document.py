"""A derivation written out: symbols, steps and equations of motion as text, LaTeX or MathML."""

from __future__ import annotations

import textwrap
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from html import escape
from typing import TYPE_CHECKING, final

from mecanique.derivation.glossary import Meaning, meanings
from mecanique.derivation.printing.equations import Equation, expression
from mecanique.derivation.printing.writers import Latex, MathML, Text, Writer
from mecanique.derivation.symbolic.derivation import Left, Result

if TYPE_CHECKING:
    from mecanique.derivation.equations import Equations

__all__ = ["TITLES", "Section", "latex", "mathml", "sections", "text", "title"]

TITLES = {
    "newton_euler": "Newton and Euler's equations of every body cut free",
    "virtual_work": "d'Alembert's principle and virtual work",
    "lagrange": "Lagrange's equations of the second kind",
}
"""What each method is called."""

_MATH = '<math xmlns="http://www.w3.org/1998/Math/MathML" display="{}">{}</math>'


def text(equations: Equations, steps: bool) -> str:
    """Return a derivation as text.

    Args:
        equations: derived symbolically.
        steps: whether to show more than the equations of motion.
    """
    lines = [equation.text() for equation in equations.equations]
    if not steps:
        return "\n".join(lines)
    writer = Text()
    out = [_heading(equations), "", "Symbols"]
    listed = meanings(equations)
    width = max(len(m.name) for m in listed)
    out += [f"  {m.name:<{width}}  {_sentence(m, _symbol(m, writer))}" for m in listed]
    for number, stage in enumerate(equations.steps, 1):
        out += ["", f"{number}. {stage.title}", *_wrapped(stage.explanation)]
        out += [f"     {_line(result, writer)}" for result in stage.results]
    out += ["", f"{len(equations.steps) + 1}. Equations of motion", *_wrapped(_closing(equations))]
    out += [f"     {line}" for line in lines]
    if equations.linear is not None:
        out += [
            "",
            "   They are linear:",
            *(f"     {line}" for line in equations.linear.text().splitlines()),
        ]
    out += [
        line for sentence in _assumptions(equations, writer) for line in ("", *_wrapped(sentence))
    ]
    return "\n".join(out)


def latex(equations: Equations, steps: bool) -> str:
    """Return a derivation in LaTeX.

    Args:
        equations: derived symbolically.
        steps: whether to show more than the equations of motion; the result is then a fragment of a
            document.
    """
    rows = [_aligned(equation) for equation in equations.equations]
    whole = "\\begin{aligned}\n" + " \\\\\n".join(rows) + "\n\\end{aligned}"
    if not steps:
        return whole
    writer = Latex()
    out = [f"\\section*{{{_tex(_heading(equations))}}}", "\\begin{description}"]
    out += [f"\\item[${_symbol(m, writer)}$] {_tex(m.sentence)}" for m in meanings(equations)]
    out.append("\\end{description}")
    for stage in equations.steps:
        out += [f"\\subsection*{{{_tex(stage.title)}}}", _tex(stage.explanation)]
        out += [f"\\[ {_line(result, writer)} \\]" for result in stage.results]
    out += ["\\subsection*{Equations of motion}", _tex(_closing(equations)), f"\\[ {whole} \\]"]
    if equations.linear is not None:
        out += ["They are linear:", f"\\[ {equations.linear.latex()} \\]"]
    out += [_tex(sentence) for sentence in _assumptions(equations, Text())]
    return "\n".join(out)


def mathml(equations: Equations, steps: bool) -> str:
    """Return a derivation in MathML.

    Args:
        equations: derived, symbolically or not.
        steps: whether to show more than the equations of motion; the result is then a fragment of
            an HTML page.
    """
    if not equations.symbolic:
        return f"<p>{escape(equations.text())}</p>"
    if not steps:
        return "\n".join(equation.mathml() for equation in equations.equations)
    writer = MathML()
    out = [f"<h3>{escape(_heading(equations))}</h3>", "<dl>"]
    for m in meanings(equations):
        out.append(
            f"<dt>{_MATH.format('inline', _symbol(m, writer))}</dt><dd>{escape(m.sentence)}</dd>"
        )
    out.append("</dl>")
    for section in sections(equations):
        out += [
            f"<h4>{escape(section.title)}</h4>",
            f"<p>{escape(section.explanation)}</p>",
            *section.formulas,
        ]
    return "\n".join(out)


@final
@dataclass(frozen=True)
class Section:
    """A step of a derivation, written out.

    Args:
        title: its name.
        explanation: why it is taken, in plain text.
        formulas: what it gives, MathML elements.
    """

    title: str
    explanation: str
    formulas: tuple[str, ...]


def sections(equations: Equations) -> tuple[Section, ...]:
    """Return the steps of a derivation in MathML; the last holds the equations of motion.

    Args:
        equations: derived symbolically.
    """
    writer = MathML()
    out = [
        Section(
            stage.title,
            stage.explanation,
            tuple(_MATH.format("block", _line(result, writer)) for result in stage.results),
        )
        for stage in equations.steps
    ]
    formulas = tuple(equation.mathml() for equation in equations.equations)
    closing = " ".join([_closing(equations), *_assumptions(equations, Text())])
    if equations.linear is not None:
        formulas += (equations.linear.mathml(),)
        closing += " The last line is the same in matrices: the equations are linear."
    return (*out, Section("Equations of motion", closing, formulas))


def _closing(equations: Equations) -> str:
    if equations.steps and equations.derivation.closing:
        return f"{equations.derivation.closing} Each line is divided by the numbers and parameters all its terms share."
    return "Each line is divided by the numbers and parameters that all its terms share."


def title(equations: Equations) -> str:
    """Return what the method of a derivation is called.

    Args:
        equations: derived, symbolically or not.
    """
    if equations.symbolic and equations.derivation.ties:
        return "Lagrange's equations with multipliers"
    name = equations.method.replace("_", " ")
    return TITLES.get(equations.method, f"{name[:1].upper()}{name[1:]}")


def _heading(equations: Equations) -> str:
    name = equations.mechanism.name.replace("_", " ")
    return f"{name[:1].upper()}{name[1:]}: {title(equations)}"


def _wrapped(sentence: str) -> Iterator[str]:
    yield from textwrap.wrap(sentence, 100, initial_indent="   ", subsequent_indent="   ")


def _symbol(meaning: Meaning, writer: Writer) -> str:
    symbol = writer.letter(meaning.name, False, "")
    if meaning.radicand is None:
        return symbol
    return writer.equation(
        symbol, writer.call("sqrt", expression(meaning.radicand).write(writer), "")
    )


def _sentence(meaning: Meaning, symbol: str) -> str:
    """The meaning in text, and the definition of a root after it."""
    return meaning.sentence if meaning.radicand is None else f"{meaning.sentence}, {symbol}"


def _line(result: Result, writer: Writer) -> str:
    left = result.left
    written = _left(left, writer) if isinstance(left, Left) else expression(left).write(writer)
    return writer.equation(written, expression(result.right).write(writer))


def _left(left: Left, writer: Writer) -> str:
    quantity = writer.letter(left.quantity, False, "")
    if not left.by:
        return quantity
    by = writer.letter(left.by, False, "")
    if left.component:
        return writer.letter(f"{left.quantity}_{left.by}", False, "")
    match writer:
        case Latex():
            slope = f"\\frac{{\\partial {quantity}}}{{\\partial {by}}}"
            before, after = "\\frac{d}{dt} ", ""
            turned = f"\\left(\\omega \\times \\frac{{\\partial {quantity}}}{{\\partial v}}\\right)_{{{by}}}"
        case MathML():
            d = "<mo>∂</mo>"
            slope = f"<mfrac><mrow>{d}{quantity}</mrow><mrow>{d}{by}</mrow></mfrac>"
            before, after = (
                "<mrow><mfrac><mi>d</mi><mrow><mi>d</mi><mi>t</mi></mrow></mfrac>",
                "</mrow>",
            )
            gradient = f"<mfrac><mrow>{d}{quantity}</mrow><mrow>{d}<mi>v</mi></mrow></mfrac>"
            turned = (
                f"<msub><mrow><mo>(</mo><mi>ω</mi><mo>×</mo>{gradient}<mo>)</mo></mrow>{by}</msub>"
            )
        case _:
            slope, before, after, turned = (
                f"∂{quantity}/∂{by}",
                "d/dt ",
                "",
                f"(ω × ∂{quantity}/∂v)_{by}",
            )
    if left.turning:
        return turned
    return f"{before}{slope}{after}" if left.total else slope


def _aligned(equation: Equation) -> str:
    return equation.latex().replace(" = ", " &= ", 1)


def _assumptions(equations: Equations, writer: Writer) -> Iterable[str]:
    for assumption in equations.derivation.assumptions:
        yield (
            f"Taken for granted: {assumption.subject} is {expression(assumption.positive).write(writer)}, "
            "which must stay positive."
        )


def _tex(sentence: str) -> str:
    for sign in "&%$#_{}":
        sentence = sentence.replace(sign, f"\\{sign}")
    return sentence.replace("²", "\\textsuperscript{2}").replace("·", "\\textperiodcentered{}")
