"""The equations of a mode as a program, for the many states between two corners.

It is written where the mode determines its forces: the rows that it holds are independent. It takes
its laws from the tape, not from the engine, and is compared with the engine before it is used.
"""

from __future__ import annotations

from typing import Any, final

import numpy as np

from mecanique.arrays import Array
from mecanique.derivation.mechanics.contacts import velocity_rows
from mecanique.errors import DerivationError
from mecanique.generation.mechanics.dynamics import Tree
from mecanique.motion.compile.python import list_values, scalar
from mecanique.motion.switching.law import SLIPS, Mode, hold, list_margins
from mecanique.motion.switching.rows import Rows, Terms, as_scalars
from mecanique.program.solving import factorize
from mecanique.program.traced import values_of

MOST_OPERATIONS = 20_000
"""Operations of a mode's program; a longer one is no faster than the engine."""


@final
class ModeProgram:
    """The rates and margins of one mode, as functions of time and state."""

    def __init__(self, equations: SwitchingEquations, mode: Mode) -> None:
        rows, letters = equations.rows, equations.rows.letters
        acceleration, forces = equations.solve(mode)
        margins = list_margins(equations.terms, rows.elements, mode, forces, equations.length)
        self._elements = len(margins)
        rates = values_of([*letters.rates, *acceleration])
        load = equations.terms.load
        watched = values_of([*np.ravel(margins), *load])
        program = rows.program(rates)
        self.length = len(letters.tape.find_needed([*rates, *watched]))
        self.rates = scalar(program)
        self._watch = list_values(program, watched)

    def margins(self, t: float, y: Array) -> tuple[Array, float]:
        """Return what each element has left, shape (elements, 2), and the largest load."""
        values = np.array(self._watch(t, y))
        end = 2 * self._elements
        return values[:end].reshape(-1, 2), float(np.abs(values[end:]).max(initial=0.0))


@final
class SwitchingEquations:
    """The equations of a mechanism with elements that switch, on a tape."""

    def __init__(self, rows: Rows) -> None:
        self.rows = rows
        tree = Tree(rows.letters)
        mass = tree.mass_matrix()
        self._factors = factorize(rows.letters.tape, mass)
        bias, forces = tree.bias(), tree.forces()
        contacts = {row.name: row for row in velocity_rows(rows.letters, tree.recursion)}
        touching = [contacts[name] for name in rows.names]
        joints = rows.on_tape()
        slopes = as_scalars([row.slopes for row in touching]).reshape(-1, rows.base.nv)

        def join(of_contacts: list[Any], of_joints: Array) -> Array:
            return np.concatenate([as_scalars(of_contacts), of_joints])

        self.terms = Terms(
            mass=as_scalars([list(row) for row in mass]),
            load=as_scalars([Q - h for Q, h in zip(forces, bias, strict=True)]),
            jacobian=np.concatenate([slopes, joints.jacobian]),
            gamma=join([row.rate for row in touching], joints.gamma),
            gaps=join([row.gap for row in touching], joints.gaps),
            rates=join([row.slip for row in touching], joints.rates),
            drift=joints.drift,  # of joints alone
            kinetic=joints.kinetic,
            static=joints.static,
        )

    def write(self, mode: Mode) -> ModeProgram | None:
        """Return a mode as a program; None if it is not to be written as one."""
        slips_in_space = any(state.name == SLIPS for state in mode)
        if self.rows.permanent or slips_in_space:
            return None
        try:
            program = ModeProgram(self, mode)
        except (ArithmeticError, DerivationError):
            return None
        return program if program.length <= MOST_OPERATIONS else None

    def solve(self, mode: Mode) -> tuple[list[Any], Array]:
        """Return the accelerations in a mode, and the force along each row."""
        terms, factors = self.terms, self._factors
        held = hold(terms, self.rows.elements, mode, ())
        if len(held.rows) > 1 and (held.friction != np.eye(len(terms.gaps))[held.rows]).any():
            raise DerivationError("friction of what is pressed makes the system unsymmetric")
        J = terms.jacobian[held.rows]
        free = as_scalars(factors.solve(terms.load + terms.jacobian.T @ held.known))
        if not held.rows:
            return list(free), held.known
        columns = [factors.solve(list(column)) for column in held.forces.T]
        yielding = as_scalars(columns).T
        right = -1.0 * terms.gamma[held.rows] - J @ free
        system = J @ yielding
        if len(held.rows) == 1:
            forces = as_scalars([right[0] / system[0, 0]])
        else:
            forces = as_scalars(factorize(self.rows.letters.tape, system).solve(list(right)))
        a = list(free + yielding @ forces)
        for i, row in enumerate(J):
            # a coordinate that sticks does not creep, not even by rounding
            entries = [k for k, slope in enumerate(row) if slope != 0]
            if len(entries) == 1:
                a[entries[0]] = -1.0 * terms.gamma[held.rows[i]] / row[entries[0]]
        return a, held.known + held.friction.T @ forces

    def length(self, *parts: Any) -> Any:
        """Return the length of a vector, by its parts."""
        letters = self.rows.letters
        if len(parts) == 1:
            return letters.call("Abs", parts[0])
        return letters.call("sqrt", sum(part * part for part in parts))
