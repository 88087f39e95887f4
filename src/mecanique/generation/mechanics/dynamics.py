"""Compute all quantities of a mechanism on one tape, each only once."""

from __future__ import annotations

from collections.abc import Callable
from functools import cached_property
from typing import Any, final

from mecanique.derivation.equations import Equations
from mecanique.derivation.mechanics.forces import Forces
from mecanique.derivation.mechanics.letters import Letters
from mecanique.derivation.mechanics.loops import Loops, loops_of
from mecanique.derivation.mechanics.recursion import World, recursion_on_tape
from mecanique.derivation.mechanics.vectors import Rows, apply
from mecanique.errors import DerivationError
from mecanique.generation.mechanics.closed_form import ClosedFormProgram
from mecanique.generation.mechanics.constrained import (
    ConstrainedSolution,
    FactorizedConstraints,
    landing_of,
)
from mecanique.generation.program import LoopProjection
from mecanique.program.solving import factorize
from mecanique.program.sweeps import push_forward
from mecanique.program.tape import Value, count
from mecanique.program.traced import values_of

_READABLE = 4
"""Closed forms with more velocities are not tried: they take long to derive, and gain little."""


@final
class Tree:
    """The equations of motion by recursion."""

    def __init__(self, letters: Letters) -> None:
        self.recursion = recursion_on_tape(letters)
        self.loads = Forces(letters, self.recursion)

    def mass_matrix(self) -> Rows:
        """Return M."""
        return self.recursion.mass_matrix()

    def bias(self) -> Any:
        """Return the bias."""
        return self.recursion.bias()

    def forces(self) -> list[Any]:
        """Return the generalized forces."""
        return self.loads.project()

    def energy(self) -> tuple[Any, Any]:
        """Return kinetic and potential energy."""
        T, V = self.recursion.energy()
        return T, V + self.loads.energy()


@final
class TapeDynamics:
    """The quantities of one mechanism on a tape: by some form, and poses by recursion."""

    def __init__(
        self, letters: Letters, form: ClosedFormProgram | Tree, tree: Tree, title: str
    ) -> None:
        self.letters = letters
        self.title = title
        self._form = form
        self.tree = tree

    def answer(self, quantity: str) -> list[Value]:
        """Return the values of a quantity, row by row."""
        answers: dict[str, Callable[[], list[Any]]] = {
            "rhs": lambda: [*self.letters.rates, *self.acceleration],
            "acceleration": lambda: self.acceleration,
            "mass_matrix": lambda: [entry for row in self.mass_matrix for entry in row],
            "bias": lambda: self.bias,
            "gravity": self.tree.recursion.gravity_forces,
            "forces": lambda: self.forces,
            "inverse_dynamics": self._inverse_dynamics,
            "energy": lambda: list(self._form.energy()),
            "poses": self._poses,
            "jacobians": self._jacobians,
            "multipliers": lambda: self.multipliers,
            "closure": lambda: [*self.loops.residual, *self.loops.rate],
        }
        return values_of(answers[quantity]())

    def differentiate(self, outputs: list[Value], by: str) -> list[Value]:
        """Return the derivatives of a quantity, row by row."""
        letters = self.letters
        tape, directions = letters.tape, self._directions(by)
        columns = [push_forward(tape, outputs, direction) for direction in directions]
        return [column[row] for row in range(len(outputs)) for column in columns]

    def _directions(self, by: str) -> list[dict[int, Value]]:
        """Return the rates of the inputs in each direction."""
        letters = self.letters
        if by == "y":
            return [*self._directions("q"), *self._directions("v")]
        if by == "q":
            rates, inputs = values_of(letters.rates), [v.place for v in letters.v]
            places = [q.place for q in letters.q]
            directions = []
            for place in inputs:
                slopes = push_forward(letters.tape, rates, {place: 1.0})
                moved = zip(places, slopes, strict=True)
                directions.append({q: x for q, x in moved if isinstance(x, int) or x})
            return directions
        scalars = {"v": letters.v, "a": letters.a, "tau": letters.tau}
        chosen = scalars.get(by) or [letters.values[symbol] for symbol in letters.open]
        return [{scalar.place: 1.0} for scalar in chosen]

    @cached_property
    def mass_matrix(self) -> Rows:
        """M."""
        return self._form.mass_matrix()

    @cached_property
    def bias(self) -> list[Any]:
        """Inertia terms without accelerations, and gravity."""
        return self._form.bias()

    @cached_property
    def forces(self) -> list[Any]:
        """Generalized forces."""
        return self._form.forces()

    @cached_property
    def loops(self) -> Loops:
        """The equations of the loops."""
        return loops_of(self.letters, self.tree.recursion)

    @cached_property
    def acceleration(self) -> list[Any]:
        """Generalized accelerations."""
        if self.letters.mechanism.constrained:
            return self._solution.acceleration
        return factorize(self.letters.tape, self.mass_matrix).solve(self.drive)

    @property
    def multipliers(self) -> list[Any]:
        """The multiplier of every row of the loops."""
        return self._solution.multipliers

    @property
    def drive(self) -> list[Any]:
        """Forces and torques minus bias."""
        parts = zip(self.forces, self.letters.tau, self.bias, strict=True)
        return [Q + tau - h for Q, tau, h in parts]

    @property
    def landing(self) -> LoopProjection:
        """The correction that keeps a closed mechanism on its loops."""
        return landing_of(self.letters, self.loops, self._constrained)

    @cached_property
    def _constrained(self) -> FactorizedConstraints:
        return FactorizedConstraints(self.letters, self.mass_matrix, self.loops)

    @cached_property
    def _solution(self) -> ConstrainedSolution:
        return self._constrained.solve(self.drive)

    def _inverse_dynamics(self) -> list[Any]:
        if isinstance(self._form, Tree):
            needed = self._form.recursion.inverse_dynamics(self.letters.a)
        else:
            pushed = apply(self.mass_matrix, self.letters.a)
            needed = [x + h for x, h in zip(pushed, self.bias, strict=True)]
        return [x - Q for x, Q in zip(needed, self.forces, strict=True)]

    def _jacobians(self) -> list[Any]:
        mechanism, world = self.letters.mechanism, World(self.tree.recursion)
        moved = [body.name for body in mechanism.bodies if body.name != mechanism.ground]
        return [entry for name in moved for row in world.jacobian(name) for entry in row]

    def _poses(self) -> list[Any]:
        mechanism = self.letters.mechanism
        return [
            entry
            for body in mechanism.bodies
            if body.name != mechanism.ground
            for row in self.tree.recursion.pose(body.name)
            for entry in row
        ]


def dynamics_of(equations: Equations, open: tuple[str, ...]) -> TapeDynamics:  # noqa: A002
    """Return a mechanism's quantities by the form of its equations with the fewest operations."""
    mechanism = equations.mechanism
    letters = Letters(mechanism, open)
    tree = Tree(letters)
    recursive = TapeDynamics(letters, tree, tree, "recursion along the tree")
    if mechanism.constrained or mechanism.nv > _READABLE:
        return recursive
    try:
        letters = Letters(mechanism, open)
        form = ClosedFormProgram(letters, equations)
        closed = TapeDynamics(letters, form, Tree(letters), f"closed form by {equations.title}")
        sizes = [count(d.letters.tape, d.answer("rhs")).total for d in (closed, recursive)]
    except DerivationError:
        return recursive
    return closed if sizes[0] <= sizes[1] else recursive
