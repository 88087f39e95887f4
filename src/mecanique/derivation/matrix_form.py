"""Linear equations of motion as matrices: M q'' + C q' + K q = f."""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

from mecanique.derivation.printing.equations import expression
from mecanique.derivation.printing.writers import Latex, MathML, Text, Writer
from mecanique.derivation.scalars.series import Kind, Series
from mecanique.derivation.symbolic.derivation import Derivation, Matrix

__all__ = ["Linear", "linear"]


@final
@dataclass(frozen=True)
class Linear:
    """Matrices of linear equations of motion M q'' + C q' + K q = f.

    Args:
        names: of the coordinates.
        M: rows of the mass matrix.
        C: rows of the damping matrix.
        K: rows of the stiffness matrix.
        f: the forces that depend on time alone.
    """

    names: tuple[str, ...]
    M: Matrix
    C: Matrix
    K: Matrix
    f: tuple[Series, ...]

    def text(self) -> str:
        """Return it as text: the equation, then each matrix by rows."""
        return "\n".join(self._lines(Text()))

    def latex(self) -> str:
        """Return it in LaTeX, one equation of matrices, without dollar signs."""
        return self._lines(Latex())[0]

    def mathml(self) -> str:
        """Return it as one MathML element."""
        (line,) = self._lines(MathML())
        return f'<math xmlns="http://www.w3.org/1998/Math/MathML" display="block">{line}</math>'

    def _lines(self, writer: Writer) -> list[str]:
        terms = [("M", self.M, "''"), ("C", self.C, "'"), ("K", self.K, "")]
        used = [
            (letter, rows, dots) for letter, rows, dots in terms if any(any(row) for row in rows)
        ]
        force = [[entry] for entry in self.f]
        if isinstance(writer, Text):
            left = " + ".join(f"{letter} q{dots}" for letter, _, dots in used)
            right = "f" if any(self.f) else "0"
            lines = [f"{left} = {right}", f"q = [{', '.join(self.names)}]"]
            lines += [f"{letter} = {_bracket(rows)}" for letter, rows, _ in used]
            return [*lines, f"f = [{', '.join(map(_write, self.f))}]"] if any(self.f) else lines
        products = [
            _matrix([[expression(e).write(writer) for e in row] for row in rows], writer)
            + _matrix([[writer.letter(name + dots, False, "")] for name in self.names], writer)
            for _, rows, dots in used
        ]
        whole = writer.sum([(False, product) for product in products])
        return [
            writer.equation(
                whole,
                _matrix([[expression(e).write(writer) for e in row] for row in force], writer),
            )
        ]


def linear(derivation: Derivation) -> Linear | None:
    """Return the matrices of linear equations with constant coefficients, else None.

    Args:
        derivation: the equations.
    """
    algebra = derivation.algebra
    ring, n = algebra.ring, len(algebra.velocities)
    moving = (Kind.COORDINATE, Kind.VELOCITY, Kind.ACCELERATION)
    names = tuple(algebra.mechanism.coordinates)
    if len(names) != n or derivation.ties:
        return None
    letters = (*algebra.accelerations, *algebra.velocities, *names)
    columns: list[list[list[Series]]] = []
    forces = []
    for row in derivation.rows:
        found = [ring.number(0)] * (3 * n)
        force = ring.number(0)
        for powers, coefficient in row.coefficients(letters).items():
            kinds = {generator.kind for generator in coefficient.generators()}
            if sum(map(abs, powers)) > 1 or kinds & set(moving):
                return None
            if not any(powers):
                force = -coefficient
            elif 1 not in powers or kinds & {Kind.TIME, Kind.INPUT}:
                return None
            else:
                found[powers.index(1)] = coefficient
        columns.append([found[:n], found[n : 2 * n], found[2 * n :]])
        forces.append(force)
    M, C, K = (tuple(tuple(row[k]) for row in columns) for k in range(3))
    return Linear(names, M, C, K, tuple(forces))


def _write(series: Series) -> str:
    return expression(series).text()


def _bracket(rows: Matrix) -> str:
    return f"[{', '.join('[' + ', '.join(map(_write, row)) + ']' for row in rows)}]"


def _matrix(rows: list[list[str]], writer: Writer) -> str:
    if isinstance(writer, Latex):
        return (
            "\\begin{bmatrix} " + " \\\\ ".join(" & ".join(row) for row in rows) + " \\end{bmatrix}"
        )
    cells = "".join(
        "<mtr>" + "".join(f"<mtd>{cell}</mtd>" for cell in row) + "</mtr>" for row in rows
    )
    return f"<mrow><mo>[</mo><mtable>{cells}</mtable><mo>]</mo></mrow>"
