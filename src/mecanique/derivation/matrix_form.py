"""Linear equations of motion as matrices: M q'' + C q' + K q = f."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import final

from mecanique.derivation.printing.equations import expression
from mecanique.derivation.printing.writers import Latex, MathML, Text, Writer
from mecanique.derivation.scalars.series import Kind, Series
from mecanique.derivation.symbolic.derivation import Derivation, Matrix

_LARGE = 4
"""Matrices with at least this many rows are printed on lines of their own."""


@final
@dataclass(frozen=True)
class Linear:
    """Matrices of linear equations of motion M q'' + C q' + K q = f."""

    names: tuple[str, ...]  # of the coordinates
    M: Matrix  # rows of the mass matrix
    C: Matrix  # rows of the damping matrix
    K: Matrix  # rows of the stiffness matrix
    f: tuple[Series, ...]  # the forces, functions of time alone

    def text(self) -> str:
        """Return the matrix equation as text, then each matrix by rows."""
        return "\n".join(self._write_lines(Text()))

    def latex(self) -> str:
        """Return one equation between matrices in LaTeX, without dollar signs."""
        return self._write_lines(Latex())[0]

    def lines(self) -> list[str]:
        """Return the equation in LaTeX; large matrices follow on lines of their own."""
        if len(self.names) < _LARGE:
            return [self.latex()]
        writer = Latex()
        terms = [("M", self.M, "''"), ("C", self.C, "'"), ("K", self.K, "")]
        used = [term for term in terms if any(map(any, term[1]))]
        shown = {dots: writer.letter(f"q{dots}", False, "") for _, _, dots in used}
        left = " + ".join(f"{letter} {shown[dots]}" for letter, _, dots in used)
        lines = [f"{left} = {'f' if any(self.f) else '0'}"]
        for letter, rows, _ in used:
            written = []
            for row in rows:
                written.append([expression(entry).latex() for entry in row])
            lines.append(f"{letter} = {_write_matrix(written, writer)}")
        lines.append(
            f"q = {_write_column([writer.letter(name, False, '') for name in self.names])}"
        )
        if any(self.f):
            lines.append(f"f = {_write_column([expression(entry).latex() for entry in self.f])}")
        return lines

    def mathml(self) -> str:
        """Return the equation as one MathML element."""
        (line,) = self._write_lines(MathML())
        return f'<math xmlns="http://www.w3.org/1998/Math/MathML" display="block">{line}</math>'

    def _write_lines(self, writer: Writer) -> list[str]:
        terms = [("M", self.M, "''"), ("C", self.C, "'"), ("K", self.K, "")]
        used = [term for term in terms if any(map(any, term[1]))]
        if isinstance(writer, Text):
            left = " + ".join(f"{letter} q{dots}" for letter, _, dots in used)
            right = "f" if any(self.f) else "0"
            lines = [f"{left} = {right}", f"q = [{', '.join(self.names)}]"]
            lines += [f"{letter} = {_write_rows(rows)}" for letter, rows, _ in used]
            return [*lines, f"f = [{', '.join(map(_write, self.f))}]"] if any(self.f) else lines

        def write(entry: Series) -> str:
            return expression(entry).write(writer)

        products = []
        for _, rows, dots in used:
            matrix = _write_matrix([list(map(write, row)) for row in rows], writer)
            column = [[writer.letter(name + dots, False, "")] for name in self.names]
            products.append((False, matrix + _write_matrix(column, writer)))
        force = _write_matrix([[write(entry)] for entry in self.f], writer)
        return [writer.equation(writer.sum(products), force)]


def linear(derivation: Derivation) -> Linear | None:
    """Return the matrices of equations that are linear with constant coefficients, else None."""
    algebra = derivation.algebra
    ring, n = algebra.ring, len(algebra.velocities)
    moving = (Kind.COORDINATE, Kind.VELOCITY, Kind.ACCELERATION)
    names = tuple(algebra.mechanism.coordinates)
    if not n or len(names) != n or derivation.ties:
        return None
    letters = (*algebra.accelerations, *algebra.velocities, *names)
    columns: list[tuple[tuple[Series, ...], ...]] = []
    forces = []
    for row in derivation.rows:
        entries = [ring.number(0)] * (3 * n)
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
                entries[powers.index(1)] = coefficient
        columns.append((tuple(entries[:n]), tuple(entries[n : 2 * n]), tuple(entries[2 * n :])))
        forces.append(force)
    M, C, K = zip(*columns, strict=True)
    return Linear(names, M, C, K, tuple(forces))


def _write(series: Series) -> str:
    return expression(series).text()


def _write_rows(rows: Matrix) -> str:
    lines = [f"[{', '.join(map(_write, row))}]" for row in rows]
    return f"[{', '.join(lines)}]"


def _write_column(entries: Sequence[str]) -> str:
    return _write_matrix([[entry] for entry in entries], Latex())


def _write_matrix(rows: list[list[str]], writer: Writer) -> str:
    if isinstance(writer, Latex):
        lines = " \\\\ ".join(map(" & ".join, rows))
        return f"\\begin{{bmatrix}} {lines} \\end{{bmatrix}}"
    table = ""
    for row in rows:
        cells = "".join(f"<mtd>{cell}</mtd>" for cell in row)
        table += f"<mtr>{cells}</mtr>"
    return f"<mrow><mo>[</mo><mtable>{table}</mtable><mo>]</mo></mrow>"
