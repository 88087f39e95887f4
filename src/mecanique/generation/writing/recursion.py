"""Write equations of any size as a recursion from body to body, with every result named.

Mechanisms with loops or rolling have the additional rows A v = b and, depending on the method,
constraint forces: multipliers in Lagrange's equations, forces on the bodies in Newton and Euler's,
none in the virtual work of the displacements that A allows.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, final

from mecanique.derivation.equations import Equations
from mecanique.derivation.mechanics.contacts import velocity_rows
from mecanique.derivation.mechanics.letters import Letters
from mecanique.derivation.mechanics.loops import Loops
from mecanique.derivation.mechanics.recursion import Recursion, Wrench
from mecanique.derivation.mechanics.vectors import add, apply_transpose, cross, scale
from mecanique.derivation.printing.formulas import Letter, Product, names_in
from mecanique.generation.mechanics.dynamics import Dynamics, Tree
from mecanique.generation.writing.formulas import Line, tidy
from mecanique.generation.writing.names import (
    explain_force,
    explain_letters,
    explain_results,
    name_functions,
    name_results,
    spell,
)
from mecanique.generation.writing.written import Part, Written
from mecanique.model.expression import symbols_in
from mecanique.program.listing import Notation, list_program
from mecanique.program.traced import trace, values_of

_CALLS = ("sin", "cos", "tan", "sqrt", "exp", "log", "asin", "acos", "atan", "tanh", "sign")
_NOTATION = Notation(
    {name: f"{name}({{}})" for name in _CALLS} | {"Abs": "abs({})"}, "{} = {}", lambda x: f"{x!r}"
)
_ABOUT = (
    "The equations are written as a recursion from body to body, not in closed form: outward the "
    "motion of each body, inward the forces that cause it. All components are in the axes of the "
    "body. Inertia that a joint does not displace, such as mass on the axis of a hinge, is "
    "counted with the parent."
)
_RECURSION = "The results, each from those above it."
_HELD = {
    "lagrange": (
        "Lagrange's equations with multipliers: one for each velocity, M a + h - Q minus the sum "
        "of the multipliers times the coefficients of that velocity in the conditions below."
    ),
    "newton_euler": (
        "Newton and Euler's equations along each velocity; the forces of the contacts are included "
        "in the forces on the bodies."
    ),
    "virtual_work": (
        "The virtual work of all forces, including inertia forces, vanishes in every displacement "
        "that satisfies the conditions on the displacements; the forces of contacts do none."
    ),
}


@final
@dataclass(frozen=True)
class _Row:
    """A sum of products, factor × name, plus a rest.

    Args:
        terms: index of the factor in the outputs, by name.
        rest: index of the rest in the outputs; None for none.
        sign: sign of the terms.
    """

    terms: dict[str, int]
    rest: int | None = None
    sign: str = "+"


def write_recursion(equations: Equations) -> Written:
    """Write equations of motion of any size as a recursion, which can be parsed again.

    It is Newton and Euler's recursion (J. Y. S. Luh, M. W. Walker & R. P. C. Paul, 1980), with
    parameters as letters.

    Args:
        equations: the equations of motion.

    Returns:
        The named results, as text, LaTeX or MathML.

    Raises:
        DerivationError: if the coordinate map has no derivatives, or a function in the equations
            cannot be printed.

    Example:
        >>> written = mq.write_recursion(mq.derive(mq.textbook.load("simple_pendulum")))
        >>> written.text().splitlines()[-1]
        '  -N_bob_y = 0'
    """
    mechanism = equations.mechanism
    letters = Letters(mechanism, tuple(mechanism.values))
    tree = Tree(letters)
    dynamics = Dynamics(letters, tree, tree, "recursion")
    holds = _Holds(dynamics, equations.method) if mechanism.constrained else None
    tau = tree.recursion.inverse_dynamics(letters.a, holds.wrenches if holds else ())
    outputs = [x - Q for x, Q in zip(tau, dynamics.forces, strict=True)]
    rows = [_Row({}, place) for place in range(len(outputs))]
    parts = {"Equations of motion": rows}
    if holds is not None:
        parts = holds.gather(outputs)
    names = name_results(tree.recursion)
    names |= name_functions(letters.tape, names)
    inputs = {name: name for name in (*mechanism.coordinates, *mechanism.velocities)}
    inputs |= {f"a {name}": f"{name}'" for name in mechanism.velocities}
    inputs |= {name: name for name in ("t", *mechanism.values, *letters.signals)}
    inputs |= {name: name for name in (holds.multipliers if holds else ())}
    fresh = "e" if any(re.fullmatch(r"x\d+", name) for name in inputs) else "x"
    listing = list_program(letters.tape, values_of(outputs), inputs, _NOTATION, names, fresh)
    rows = [row for each in parts.values() for row in each]
    known = {
        name: Product(1, ((Letter(name, (0, place)), 1),))
        for place, name in enumerate(mechanism.values)
    }
    lines, ends = tidy(listing.lines, [_write(row, listing.outputs) for row in rows], known, fresh)
    rights = [line.right for line in lines]
    used = frozenset[str]().union(*map(names_in, (*ends, *rights)))
    defined = {line.name for line in lines}
    meanings = [*explain_letters(mechanism, used)]
    meanings += explain_results(tree.recursion, defined)
    if holds is not None:
        meanings += holds.explain()
    if any(re.fullmatch(rf"{fresh}\d+", name) for name in defined):
        meanings.append(((f"{fresh}1", f"{fresh}2", "…"), "results that are used repeatedly"))
    left, results = iter(ends), list[Part]()
    for heading, each in parts.items():
        said = _HELD[equations.method] if holds is not None and not results else ""
        results.append(Part(heading, said, tuple(Line("0", next(left)) for _ in each)))
    title = f"{mechanism.name.replace('_', ' ').capitalize()}: {equations.title}"
    about = (*mechanism.about.splitlines(), _ABOUT)
    recursion = Part("Recursion", _RECURSION, tuple(lines), numbered=True)
    return Written(title, about, tuple(meanings), recursion, tuple(results))


def _write(row: _Row, outputs: Sequence[str]) -> str:
    found = "" if row.rest is None else outputs[row.rest]
    for name, place in row.terms.items():
        if outputs[place] not in ("0.0", "0"):
            found += f" {row.sign} {name} * ({outputs[place]})"
    return found.removeprefix(f" {row.sign} ") if row.sign == "+" else found or "0"


@final
class _Holds:
    """The constraints of a mechanism with loops or rolling, by the method of derivation.

    Args:
        dynamics: the mechanism on a tape.
        method: the method of derivation.
    """

    def __init__(self, dynamics: Dynamics, method: str) -> None:
        self._letters = dynamics.letters
        self._loops: Loops = dynamics.loops
        self._method = method
        recursion = dynamics.tree.recursion
        self._velocity_rows = (
            velocity_rows(self._letters, recursion) if method == "newton_euler" else []
        )
        self.multipliers: list[str] = []
        """The names of the multipliers, one for each row; none with virtual work."""
        if method != "virtual_work":
            self.multipliers = [f"lambda_{spell(_join(row))}" for row in self._loops.names]
        self.wrenches = [*self._act(recursion)]
        """The forces of contacts on links, for Newton and Euler's equations."""

    def gather(self, outputs: list[Any]) -> dict[str, list[_Row]]:
        """Return the rows under each heading, and append their factors to the outputs.

        Args:
            outputs: the left side of each velocity's equation.
        """
        mechanism, loops = self._letters.mechanism, self._loops
        count = len(outputs)
        A: list[list[int]] = []
        for slopes in loops.jacobian:
            A.append([len(outputs) + k for k in range(count)])
            outputs += slopes
        if self._method == "virtual_work":
            moved = [f"δ{name.rstrip(chr(39))}" for name in mechanism.velocities]
            motion = [_Row(dict(zip(moved, range(count), strict=True)))]
            allowed = [_Row(dict(zip(moved, row, strict=True))) for row in A]
        else:
            acting = {demand.name for demand in self._velocity_rows if demand.place is not None}
            every = zip(self.multipliers, loops.names, A, strict=True)
            pairs = [(own, row) for own, name, row in every if name not in acting]
            motion = []
            for k in range(count):
                motion.append(_Row({own: row[k] for own, row in pairs}, k, "-"))
            allowed = []
        conditions = [*self._conditions(outputs, A)]
        parts = {"Equations of motion": motion, "Conditions on the displacements": allowed}
        parts["Conditions"] = conditions
        return {heading: rows for heading, rows in parts.items() if rows}

    def explain(self) -> Iterator[tuple[tuple[str, ...], str]]:
        """Yield the meanings of multipliers and displacements."""
        mechanism = self._letters.mechanism
        for name, row in zip(self.multipliers, self._loops.names, strict=False):
            yield (name,), explain_force(mechanism, row)
        if self._method == "virtual_work":
            for name in mechanism.velocities:
                yield (f"δ{name.rstrip(chr(39))}",), f"virtual displacement along {name}"

    def _conditions(self, outputs: list[Any], A: list[list[int]]) -> Iterator[_Row]:
        """Yield Φ = 0 of rows that restrict positions, then ψ = 0 of the others."""
        mechanism, loops = self._letters.mechanism, self._loops
        steady = not any("t" in symbols_in(law) for law in mechanism.coordinates.driven.values())
        for k, (gap, rate) in enumerate(zip(loops.residual, loops.rate, strict=True)):
            if not (isinstance(gap, float) and gap == 0.0):
                outputs.append(gap)
                yield _Row({}, len(outputs) - 1)
            elif steady and k < len(loops.names) - len(mechanism.velocity_constraints):
                yield _Row(dict(zip(mechanism.velocities, A[k], strict=True)))
            else:
                outputs.append(rate)
                yield _Row({}, len(outputs) - 1)

    def _act(self, recursion: Recursion) -> Iterator[Wrench]:
        mechanism, tape = self._letters.mechanism, self._letters.tape
        own = {contact.name: contact for contact in mechanism.contacts}
        names = dict(zip(self._loops.names, self.multipliers, strict=False))
        for demand in self._velocity_rows:
            if demand.place is None or demand.direction is None:
                continue
            size = trace(tape, tape.input(names[demand.name]))
            contact = own[demand.name.partition(": ")[0]]
            for body, sign in ((contact.body, 1.0), (contact.on, -1.0)):
                place = recursion.seats[body].place
                if place < 0:
                    continue
                pose = recursion.poses[place]
                arm = add(demand.place, scale(-1.0, [row[3] for row in pose]))
                turn = [row[:3] for row in pose]
                force = apply_transpose(turn, scale(sign, demand.direction))
                reach = apply_transpose(turn, arm)
                yield Wrench(place, scale(size, force), scale(size, cross(reach, force)))


def _join(row: str) -> str:
    """Join a row's name into one word."""
    return row.replace(": ", "_")
