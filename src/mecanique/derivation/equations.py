"""Equations of motion as a result, M a + bias = forces, to read, to compute with and to solve."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property
from html import escape
from typing import TYPE_CHECKING, final

import numpy as np

from mecanique.derivation.document import Document
from mecanique.derivation.glossary import unit_of
from mecanique.derivation.linear import Linear
from mecanique.derivation.numeric.constraints.multipliers import Constrained
from mecanique.derivation.numeric.dynamics import BatchDynamics
from mecanique.derivation.numeric.newton_euler import Balances, JointWrench
from mecanique.derivation.printing.equations import expression
from mecanique.derivation.printing.expressions import to_matrix
from mecanique.derivation.printing.prose import escape as escape_for_latex
from mecanique.derivation.printing.writers import Equation
from mecanique.derivation.symbolic.derivation import Derivation, Stages
from mecanique.derivation.symbolic.named_inertias import name_inertias
from mecanique.derivation.symbolic.solution import EliminatedSolution, solve
from mecanique.derivation.symbolic.symbols import MOST_TERMS, coordinate_of
from mecanique.errors import DerivationError
from mecanique.model.constraints.contacts import SPEAKING
from mecanique.model.dynamics import Dynamics, Quantity
from mecanique.model.mechanism import Mechanism
from mecanique.model.mechanism.letters import find_name
from mecanique.model.states import States, explain_defaults
from mecanique.model.values import Given

if TYPE_CHECKING:
    from sympy import Matrix


_CLOSING = "Solved for the accelerations and the forces of the constraints."


@final
@dataclass(frozen=True, repr=False)
class Solved:
    """Equations of motion solved for accelerations and forces of constraints.

    Constraints are eliminated by the displacements that they allow (G. A. Maggi, Principii della
    teoria matematica del movimento, 1896; Neimark & Fufaev, Dynamics of Nonholonomic Systems, 1972,
    ch. III), accelerations that depend on each other, three at most, by Cramer's rule.

    Args:
        derivation: what is solved.
        found: the solution in closed form.

    Example:
        >>> disk = mq.derive(mq.textbook.load("rolling_disk")).solved()
        >>> print(disk.accelerations["x''"])
        x'' = 2 g sin(alpha)/3
        >>> print(disk.forces["lambda_contact_x"])
        lambda_contact_x = -m g sin(alpha)/3
    """

    derivation: Derivation
    found: EliminatedSolution

    @property
    def independent(self) -> tuple[str, ...]:
        """The coordinates, or velocities that are no coordinate's rate, that remain independent.

        None if there are none, as with the knife edge of a sleigh: the speed along it is no rate.
        """
        return tuple(map(coordinate_of, self.found.kept))

    @property
    def equations(self) -> tuple[Equation, ...]:
        """The equations of motion in these alone, without multipliers; empty if none are."""
        return self.found.equations

    @cached_property
    def accelerations(self) -> dict[str, Equation]:
        """Each acceleration, e.g. x'' = 2 g/3, by name; empty if they would be long."""
        return {name: value.equate(name) for name, value in self.found.accelerations.items()}

    @cached_property
    def forces(self) -> dict[str, Equation]:
        """Each multiplier by name; in terms of the accelerations if those are not solved for.

        Those that redundant constraints leave undetermined are not listed.
        """
        return {name: value.equate(name) for name, value in self.found.forces.items()}

    def text(self, symbols: bool = False) -> str:
        """Return what is solved as text, one line each.

        Args:
            symbols: whether to say above it what it is of and what each letter means; the constant
                inertias of a top then have letters, too.
        """
        return self._write(symbols).text(False, symbols)

    def latex(self, symbols: bool = False) -> str:
        """Return what is solved in LaTeX for mathematics mode; with symbols, a fragment.

        Args:
            symbols: whether to say above it what it is of and what each letter means.
        """
        return self._write(symbols).latex(False, symbols)

    def mathml(self, symbols: bool = False) -> str:
        """Return what is solved in MathML, an element each; with symbols, part of an HTML page.

        Args:
            symbols: whether to say above it what it is of and what each letter means.
        """
        return self._write(symbols).mathml(False, symbols)

    def __str__(self) -> str:
        return self.text()

    def __repr__(self) -> str:
        name = self.derivation.algebra.mechanism.name
        independent = ", ".join(self.independent) or "no velocity"
        return f"<Solved equations of {name!r}, {independent} independent>"

    def _repr_html_(self) -> str:
        return self._write(True).html()

    def _write(self, symbols: bool) -> Document:
        """Return the lines as a document; where it explains symbols, with letters for inertias."""
        derivation, found, lines = self.derivation, self.found, list[Equation]()
        inertias = name_inertias(derivation.algebra, derivation.M)
        if symbols and inertias.definitions and found.accelerations:
            derivation = inertias.rewrite(derivation)
            found = solve(derivation, found.kept)
            ring = derivation.algebra.ring
            for line, letter in zip(inertias.definitions, inertias.unknowns, strict=True):
                left = expression(ring[letter])
                lines.append(Equation(left, line.expression(), ring.number(1)))
        solved = Solved(derivation, found)
        lines += [*(solved.accelerations.values() or solved.equations), *solved.forces.values()]
        lines += [*found.turned.values(), *found.sums]
        written = replace(derivation, written=tuple(lines), stages=(), closing=_CLOSING)
        return Document(written, "the equations of motion, solved")


def require_balances(numeric: BatchDynamics, method: str, what: str) -> Balances:
    """Return a numeric derivation if it is by the balances of bodies cut free."""
    if isinstance(numeric, Balances):
        return numeric
    raise DerivationError(f'the method {method!r} shows no {what}; use method="newton_euler"')


def require_reactions(mechanism: Mechanism, numeric: BatchDynamics, method: str) -> Balances:
    """Return a numeric derivation if it determines the reactions in the joints."""
    balances = require_balances(numeric, method, "reactions, which do no virtual work")
    if mechanism.loops:
        raise DerivationError(
            f"mechanism {mechanism.name!r} has loops, whose forces the balances of its "
            "tree leave out; use Reference"
        )
    if mechanism.velocity_constraints:
        raise DerivationError(
            f"mechanism {mechanism.name!r}: velocity constraint "
            f"{mechanism.velocity_constraints[0].name!r} does not say by which force it "
            f"acts, and where, so that the reactions are undetermined; {SPEAKING} does"
        )
    return balances


@final
@dataclass(frozen=True, repr=False)
class Equations(Dynamics):
    """Derived equations of motion M(q, t) a + bias(q, v, t) = forces(q, v, t).

    What is computed is there for any mechanism; of one with loops, M, bias and forces are those of
    its tree. What is read (`M`, `h`, `Q`, `equations`, `steps`, and the text, LaTeX and MathML of
    these) is derived when it is first asked for. Where `symbolic` is false, the former raise a
    DerivationError that says why; the texts say so in a sentence.

    Args:
        mechanism: what they describe.
        method: how they were derived, e.g. "lagrange".
        title: what that is called.
        numeric: computes them.
        derive_symbols: derives them symbolically; raises a DerivationError if they have no closed
            form of reasonable length.

    Example:
        >>> equations = mq.derive(mq.textbook.load("double_pendulum"))
        >>> equations.M[0, 1]
        l1*l2*m2*cos(q1 - q2)/2
        >>> equations.acceleration([0.1, 0.2], [0.0, 0.0]).round(3)
        array([-0.025, -2.886])
    """

    mechanism: Mechanism
    method: str
    title: str
    numeric: BatchDynamics
    derive_symbols: Callable[[], Derivation]

    def __getstate__(self) -> dict[str, object]:
        # what has been derived and written out is left behind, and derived again when asked for
        return {field.name: getattr(self, field.name) for field in fields(self)}

    @cached_property
    def _outcome(self) -> Derivation | DerivationError:
        try:
            return self.derive_symbols()
        except DerivationError as error:
            return error

    @property
    def symbolic(self) -> bool:
        """Whether they can be read, not only computed."""
        return not isinstance(self._outcome, DerivationError)

    @cached_property
    def terms(self) -> int:
        """Number of terms of M, h and Q together; 0 if they have no closed form."""
        if not self.symbolic:
            return 0
        derivation = self.derivation
        upper = [entry for k, row in enumerate(derivation.M) for entry in row[k:]]
        return sum(map(len, (*upper, *derivation.h, *derivation.Q)))

    @property
    def legible(self) -> bool:
        """Whether they can be read and are short enough for a page."""
        return self.symbolic and self.terms <= MOST_TERMS

    @property
    def why_not(self) -> str:
        """Why they cannot be read, in one sentence; empty if they can."""
        return str(self._outcome) if isinstance(self._outcome, DerivationError) else ""

    @property
    def derivation(self) -> Derivation:
        """The derivation as Poisson series."""
        if isinstance(self._outcome, DerivationError):
            raise self._outcome
        return self._outcome

    @cached_property
    def document(self) -> Document:
        """The derivation written out."""
        return Document(self.derivation, self.title)

    @property
    def equations(self) -> tuple[Equation, ...]:
        """The equations as a textbook prints them: of each velocity, then of the loops."""
        return self.document.equations

    @cached_property
    def units(self) -> tuple[str, ...]:
        """The unit that the terms of each equation have, as it is printed."""
        return tuple(unit_of(self.derivation, equation) for equation in self.equations)

    @cached_property
    def M(self) -> Matrix:
        """The mass matrix, a sympy Matrix of shape (nv, nv)."""
        return to_matrix(self.derivation.M)

    @cached_property
    def h(self) -> Matrix:
        """The bias: inertia terms without a, and gravity; a sympy Matrix of shape (nv, 1)."""
        return to_matrix([[entry] for entry in self.derivation.h])

    @cached_property
    def Q(self) -> Matrix:
        """Generalized forces of springs, dampers, drives and loads; a sympy Matrix, (nv, 1)."""
        return to_matrix([[entry] for entry in self.derivation.Q])

    @property
    def steps(self) -> Stages:
        """The steps of the derivation; a notebook shows them written out."""
        return Stages(self.derivation.stages)

    @property
    def linear(self) -> Linear | None:
        """M q'' + C q' + K q = f if linear with constant coefficients, else None."""
        return self.document.linear

    def solved(self, keep: str | Sequence[str] = ()) -> Solved:
        """Return the equations solved: accelerations and forces of constraints in closed form.

        Args:
            keep: the coordinates, or velocities, to which constraints reduce the equations; by
                default as many of the first as possible.

        Raises:
            UnknownNameError: if there is no such coordinate or velocity.
            DerivationError: if there is no symbolic form, if constraints cannot be solved without a
                divisor that may vanish, as those of loops, or do not leave these alone free.
        """
        velocities = self.mechanism.velocities
        rates = dict(zip(map(coordinate_of, velocities), velocities, strict=True))
        typed = [coordinate_of(name) for name in ((keep,) if isinstance(keep, str) else keep)]
        kept = [rates[find_name(self.mechanism, name, rates)] for name in typed]
        if not self.symbolic:
            raise DerivationError(
                f"{self.why_not}; they are solved in numbers, by acceleration(q, v, t), and as a "
                "list of named results, by mecanique.write_recursion"
            )
        return Solved(self.derivation, solve(self.derivation, tuple(dict.fromkeys(kept))))

    def matrix_form(self) -> str:
        """Return linear equations of motion as M q'' + C q' + K q = f with all matrices, as text.

        Raises:
            DerivationError: if they are not linear with constant coefficients.
        """
        if self.linear is None:
            raise DerivationError(
                f"the equations of {self.mechanism.name!r} are not linear with constant "
                "coefficients; linearize them about an equilibrium first"
            )
        return self.linear.text()

    def holds(self, q: Given, t: float = 0.0) -> bool:
        """Return whether the symbolic equations hold in a state: no spring is turned inside out.

        Args:
            q: shape (nq,), or values by coordinate name.
            t: [s].

        Raises:
            InputError: if a shape is wrong or a number is not finite.
            DerivationError: if there is no symbolic form.
        """
        states = States.of(self.mechanism, q, None, t)
        values = {name: float(np.ravel(value)[0]) for name, value in states.values.items()}
        return all(assumption.holds(values) for assumption in self.derivation.assumptions)

    def text(self, steps: bool = False, symbols: bool = False) -> str:
        """Return the equations of motion as text, one line each.

        Args:
            steps: whether to show how they came about.
            symbols: whether to say above them what they are of and what each letter means, as is
                said with the steps in any case.
        """
        return self.document.text(steps, symbols) if self.symbolic else self._explain_absence()

    def latex(self, steps: bool = False, symbols: bool = False) -> str:
        """Return the equations in LaTeX for mathematics mode; with steps or symbols, a fragment.

        What is for mathematics mode takes amsmath, a fragment is part of a document that loads it.

        Args:
            steps: whether to show how they came about.
            symbols: whether to say above them what they are of and what each letter means, as is
                said with the steps in any case.
        """
        if self.symbolic:
            return self.document.latex(steps, symbols)
        absence = escape_for_latex(self._explain_absence())
        return absence if steps or symbols else f"\\text{{{absence}}}"

    def mathml(self, steps: bool = False, symbols: bool = False) -> str:
        """Return the equations in MathML, an element each; with steps, part of an HTML page.

        Args:
            steps: whether to show how they came about.
            symbols: whether to say above them what they are of and what each letter means, as is
                said with the steps in any case.
        """
        return (
            self.document.mathml(steps, symbols)
            if self.symbolic
            else f"<p>{escape(self._explain_absence())}</p>"
        )

    def __str__(self) -> str:
        return self.text()

    def __repr__(self) -> str:
        v = ", ".join(self.mechanism.velocities)
        return f"<Equations of {self.mechanism.name!r} by {self.method}, v = ({v})>"

    def _repr_latex_(self) -> str:
        return f"$\\displaystyle {self.latex()}$"

    def _repr_html_(self) -> str:
        """The equations in a notebook, with what each letter means, and reactions if any."""
        return self.document.html() if self.symbolic else self.mathml()

    def _explain_absence(self) -> str:
        name = self.mechanism.name
        return (
            f"The equations of {name!r} are computed, not written out: {self.why_not}. "
            "write_recursion lists them as named results."
        )

    def _compute(self, quantity: Quantity, states: States) -> np.ndarray:
        with np.errstate(all="ignore"):
            answers = self._answer(quantity, states)
        finite = np.isfinite(answers).reshape(len(states), -1).all(axis=1)
        if not finite.all():
            k = int(np.argmin(finite))
            q, v, t = states.q[k].tolist(), states.v[k].tolist(), float(states.t[k])
            raise DerivationError(
                f"mechanism {self.mechanism.name!r} has no finite {quantity.replace('_', ' ')} at "
                f"q = {q}, v = {v}, t = {t:g}{explain_defaults(self.mechanism, states.asked)}"
            )
        return states.unbatch(answers)

    def _answer(self, quantity: Quantity, states: States) -> np.ndarray:
        itself = self.mechanism.rolls and self.numeric.rolls
        if quantity == "acceleration" and self.mechanism.constrained and not itself:
            return np.asarray(self._constrained.motion(states).acceleration)
        if quantity == "inverse_dynamics":
            needed = self.numeric.inverse_dynamics(states, states.a)
            return np.asarray(needed - self.numeric.forces(states))
        answer: np.ndarray = getattr(self.numeric, quantity)(states)
        return answer

    def multipliers(self, q: Given, v: Given, t: float | np.ndarray = 0.0) -> dict[str, np.ndarray]:
        """Return Lagrange's multipliers λ of the constraints, each shape () or (n,).

        They go by row, "loop: motion it closes", "contact: motion it prevents" or the name of a
        velocity constraint. With these M a + bias − forces = Jᵀ λ. Those of a contact are the
        components of its force on the body that rolls or has the blade [N]. Those of a loop along
        x, y, z and length are forces [N] of body a on body b, about x, y, z moments [N·m], in the
        axes of frame a. Redundant rows share their load with the least sum of squares.

        Args:
            q: shape (nq,) or (n, nq), or values by coordinate name; the loops closed.
            v: shape (nv,) or (n, nv), or values by velocity name.
            t: shape () or (n,) [s].

        Raises:
            InputError: if a shape is wrong or a number is not finite.
            DerivationError: if a motion meets no inertia.
        """
        states = States.of(self.mechanism, q, v, t)
        if not self.mechanism.constrained:
            return {}
        values = (
            self.numeric.multipliers(states)
            if self.mechanism.rolls and isinstance(self.numeric, Balances)
            else self._constrained.motion(states).multipliers
        )
        return {
            name: states.unbatch(row)
            for name, row in zip(self._constrained.names, values.T, strict=True)
        }

    @cached_property
    def _constrained(self) -> Constrained:
        return Constrained(self.mechanism, self.numeric)

    def reactions(
        self, q: Given, v: Given, t: float | np.ndarray = 0.0, tau: Given = None
    ) -> dict[str, JointWrench]:
        """Return force and moment of each joint's parent on its child, by joint, world axes.

        The moment is about the origin of the child's frame. Springs, dampers, drives and loads are
        no part of it. Components that depend on what guides joints on the coordinate map, where
        the mechanism does not say what does, are not numbers; `totals` are determined there, too.

        Args:
            q: shape (nq,) or (n, nq), or values by coordinate name.
            v: shape (nv,) or (n, nv), or values by velocity name.
            t: shape () or (n,) [s].
            tau: what drives besides the mechanism's own forces, as in `acceleration`, in joints
                with one coordinate [N·m or N]; like them no part of a reaction.

        Raises:
            InputError: if a shape is wrong, a number is not finite, or tau acts elsewhere than in
                a joint with one coordinate.
            UnknownNameError: if a name in tau is no joint, coordinate or velocity.
            DerivationError: if the method shows no reactions, if a motion meets no inertia, or if
                there are loops.
        """
        return self._transmit(Balances.reactions, q, v, t, tau)

    def totals(
        self, q: Given, v: Given, t: float | np.ndarray = 0.0, tau: Given = None
    ) -> dict[str, JointWrench]:
        """Return what crosses each joint in all, its reaction and what guides across it, by joint.

        It acts on the child with all that hangs on it; where nothing guides a joint, it is the
        joint's reaction.

        Args:
            q: shape (nq,) or (n, nq), or values by coordinate name.
            v: shape (nv,) or (n, nv), or values by velocity name.
            t: shape () or (n,) [s].
            tau: what drives besides the mechanism's own forces, as in `reactions`.

        Raises:
            InputError: if a shape is wrong, a number is not finite, or tau acts elsewhere than in
                a joint with one coordinate.
            UnknownNameError: if a name in tau is no joint, coordinate or velocity.
            DerivationError: if the method shows no reactions, if a motion meets no inertia, or if
                there are loops.
        """
        return self._transmit(Balances.totals, q, v, t, tau)

    def guide_forces(
        self, q: Given, v: Given = None, t: float | np.ndarray = 0.0
    ) -> dict[str, np.ndarray]:
        """Return the forces of the elements that guide, by name: tensions of cords [N].

        Args:
            q: shape (nq,) or (n, nq), or values by coordinate name.
            v: shape (nv,) or (n, nv), or values by velocity name.
            t: shape () or (n,) [s].

        Raises:
            InputError: if a shape is wrong or a number is not finite.
            DerivationError: if the method shows no reactions, or an element does not fit the map.
        """
        balances = require_balances(self.numeric, self.method, "forces of elements")
        states = States.of(self.mechanism, q, v, t)
        forces = balances.guide_forces(states)
        return {name: states.unbatch(force) for name, force in forces.items()}

    def _transmit(
        self,
        what: Callable[[Balances, States], dict[str, JointWrench]],
        q: Given,
        v: Given,
        t: float | np.ndarray,
        tau: Given,
    ) -> dict[str, JointWrench]:
        balances = require_reactions(self.mechanism, self.numeric, self.method)
        states = States.of(self.mechanism, q, v, t, tau=tau)
        if states.efforts is not None:
            states.efforts.refuse_without_seat()
        wrenches = what(balances, states)
        return {name: JointWrench(*map(states.unbatch, both)) for name, both in wrenches.items()}

    def momentum(
        self, q: Given, v: Given, t: float | np.ndarray = 0.0
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the momenta: linear, angular about the origin and about the center of mass.

        Args:
            q: shape (nq,) or (n, nq), or values by coordinate name.
            v: shape (nv,) or (n, nv), or values by velocity name.
            t: shape () or (n,) [s].

        Returns:
            World axes; each shape (3,) or (n, 3) [kg·m/s, then kg·m²/s].
        """
        states = States.of(self.mechanism, q, v, t)
        linear, angular, about_center = self.numeric.momentum(states)
        return states.unbatch(linear), states.unbatch(angular), states.unbatch(about_center)

    def energy(
        self, q: Given, v: Given, t: float | np.ndarray = 0.0
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the kinetic energy T, and V of gravity and springs, each shape () or (n,) [J].

        Args:
            q: shape (nq,) or (n, nq), or values by coordinate name.
            v: shape (nv,) or (n, nv), or values by velocity name.
            t: shape () or (n,) [s].
        """
        states = States.of(self.mechanism, q, v, t)
        T, V = self.numeric.energy(states)
        return states.unbatch(T), states.unbatch(V)
