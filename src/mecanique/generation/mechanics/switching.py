"""The equations of a mechanism with elements that switch, on a tape: every mode and impact."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, final

import numpy as np

from mecanique.derivation.mechanics.contacts import velocity_rows
from mecanique.derivation.mechanics.letters import Letters
from mecanique.derivation.mechanics.switching import (
    Mode,
    ModeProblem,
    Scalars,
    Terms,
    as_scalars,
    bounce,
    find_inside,
    hold,
    joint_terms,
    list_elements,
    name_mode,
    point_slip,
    solve_held,
)
from mecanique.generation.mechanics.dynamics import Tree
from mecanique.model.mechanism import Mechanism
from mecanique.program.solving import eliminate, factorize


@final
class SwitchingEquations:
    """The terms of all modes on the tape of the letters, and what solves them.

    Args:
        mechanism: a tree with elements that switch.
        letters: those of its tree with every contact closed.
        idle: names of the rows of contacts along which nothing slips.
    """

    def __init__(self, mechanism: Mechanism, letters: Letters, idle: Callable[[str], bool]) -> None:
        self.letters = letters
        self.tree = tree = Tree(letters)
        self.contacts = contacts = velocity_rows(letters, tree.recursion)
        names = [row.name for row in contacts]
        mass = tree.mass_matrix()
        self._factors = factorize(letters.tape, mass)
        bias, forces = tree.bias(), tree.forces()
        joints = joint_terms(mechanism, letters)

        def join(of_contacts: list[Any], of_joints: Scalars) -> Scalars:
            return np.concatenate([as_scalars(of_contacts), of_joints])

        slopes = as_scalars([row.slopes for row in contacts]).reshape(-1, letters.mechanism.nv)
        self.elements = list_elements(
            mechanism,
            names,
            lambda scalar: letters.number(scalar, letters.values),
            [k for k, name in enumerate(names) if idle(name)],
        )
        feet = {row.name.rpartition(": ")[0]: row.foot for row in contacts}
        gaps = join([row.gap for row in contacts], joints.gaps)
        self.terms = Terms(
            mass=as_scalars([list(row) for row in mass]),
            load=as_scalars([Q - h for Q, h in zip(forces, bias, strict=True)]),
            jacobian=np.concatenate([slopes, joints.jacobian]),
            gamma=join([row.rate for row in contacts], joints.gamma),
            gaps=gaps,
            rates=join([row.slip for row in contacts], joints.rates),
            drift=joints.drift,  # of joints alone
            kinetic=joints.kinetic,
            static=joints.static,
            inside=as_scalars(find_inside(self.elements, feet, gaps, self.length)),
        )

    @property
    def driven(self) -> Terms:
        """The terms with what is added by tau to the load."""
        return self.terms._replace(load=self.terms.load + as_scalars(self.letters.tau))

    def list_terms(self) -> list[Any]:
        """Return rates of q and the terms of a state, then the numbers of each kind of element."""
        terms, elements = self.driven, self.elements
        of_rows = (terms.gamma, terms.gaps, terms.rates, terms.inside, terms.kinetic, terms.static)
        numbers = [
            [element.restitution, element.stiffness or 0.0, element.holds] for element in elements
        ]
        return [
            *self.letters.rates,
            *terms.mass.ravel(),
            *terms.load,
            *terms.jacobian.ravel(),
            *np.concatenate(of_rows),
            *as_scalars(numbers).T.ravel(),
        ]

    def length(self, *parts: Any) -> Any:
        """Return the root of the sum of squares."""
        if len(parts) == 1:
            return self.letters.call("Abs", parts[0])
        return self.letters.call("sqrt", sum(part * part for part in parts))

    def by_mass(self, column: Sequence[Any]) -> list[Any]:
        """Return M⁻¹ of a column."""
        return self._factors.solve(list(column))

    def bounce(self, element: str, states: str = "") -> tuple[Scalars, Scalars]:
        """Return the changes of velocities and the impulses of an element's impact by itself."""

        def solve(terms: Terms, state: str, drive: ModeProblem) -> tuple[Scalars, Scalars]:
            return self.solve(name_mode(self.elements, {element: state}), drive)

        functions = self.length, partial(self.letters.call, "sign")
        return bounce(self.terms, self.elements, (element, states), solve, functions)

    def solve(self, mode: Mode, drive: ModeProblem) -> tuple[Scalars, Scalars]:
        """Return the accelerations or changes of velocities, and the force along each row."""
        mode = point_slip(self.elements, mode, self.terms.rates, self.length)
        held = hold(self.terms, self.elements, mode, drive)
        symmetric = (held.friction == np.eye(len(self.terms.gaps))[held.rows]).all()

        def by_mass(columns: Scalars) -> Scalars:
            solved: Scalars = as_scalars(self.by_mass(column) for column in columns.T).T
            return solved

        def by_rows(J: Scalars, yielding: Scalars, free: Scalars, wanted: Scalars) -> Scalars:
            system, right = list(J @ yielding), list(wanted - free)
            if symmetric:
                return as_scalars(factorize(self.letters.tape, system).solve(right))
            return as_scalars(eliminate(system, right))

        solved = solve_held(self.terms, held, drive, by_mass, by_rows)
        assert solved is not None, "forces on a tape are always solved for"
        return solved
