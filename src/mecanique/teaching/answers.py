"""The answers of exercises: what may be asked of a system, and the steps that lead there."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import cached_property, partial
from typing import NamedTuple, final

import numpy as np

from mecanique.checking.judgement.quantities import ENERGIES
from mecanique.derivation import derive
from mecanique.derivation.equations import Equations
from mecanique.derivation.linear import Linearized
from mecanique.derivation.methods import METHODS
from mecanique.derivation.printing.equations import expression
from mecanique.derivation.reduction import routh
from mecanique.derivation.scalars.series import Kind, Series
from mecanique.derivation.symbolic.derivation import along_displacement
from mecanique.derivation.symbolic.lagrange import Lagrange, energy_integral
from mecanique.derivation.symbolic.multipliers import name_of
from mecanique.errors import ClosureError, DerivationError, InputError
from mecanique.model.mechanism import Mechanism
from mecanique.motion import equilibria
from mecanique.motion.linear.linearization import Linearization
from mecanique.motion.linear.linearize import linearize

_PART = 1e-9
"""A position this near to a part of half a turn is that part."""

_DIGITS = ", for the numbers given, to four digits"

_FROM_T = """
   The entry of the mass matrix for two coordinates is the second derivative of T by their rates:
   M_ij = ∂²T/∂q_i' ∂q_j', for T is half of the sum of M_ij q_i' q_j'."""


class WorkedAnswer(NamedTuple):
    """An answer, with what leads to it and what its question says besides."""

    text: str  # the result, as `mecanique.check` reads it
    steps: str
    what: str = ""  # a coordinate, a place or an input that the question names
    note: str = ""  # what the question adds


@final
class Solver:
    """Answers questions about one mechanism."""

    def __init__(self, mechanism: Mechanism) -> None:
        self._mechanism = mechanism
        self._equations = derive(mechanism)
        try:
            self._derivation = self._equations.derivation
        except DerivationError as error:
            raise InputError(f"no exercise about {mechanism.name!r}: {error}") from None

    @cached_property
    def _whole(self) -> str:
        """The derivation as far as its result."""
        return _write_steps(self._equations)

    def ask(self, name: str) -> WorkedAnswer:
        """Return the answer to a kind of question, with what its letters of lengths mean."""
        kind = KINDS[name]
        answer, ring = kind.answer(self), self._derivation.algebra.ring
        written = set(re.findall(r"\w+", answer.text))
        if (kind.ask or name) == _MOTION:  # where these letters are known
            written = set()
        roots = {ring.generators[k].name: a.argument for k, a in ring.atoms.items() if a.named}
        lines = [f"{rho} = sqrt({_say(roots[rho])})" for rho in roots if rho in written]
        return answer._replace(text="\n".join([*lines, answer.text]))

    def rate_difficulty(self, name: str) -> int:
        """Return from 1 to 5 how hard a question is, by its steps and what couples the motion."""
        mechanism, M = self._mechanism, self._derivation.M
        entries = [entry for row in M for entry in row]
        felt = {generator.name for entry in entries for generator in entry.generators()}
        hurdles = (
            len(M) > 1,
            len(M) > 2,
            any(entry for k, row in enumerate(M) for entry in row[:k]),  # rates are coupled
            not felt.isdisjoint((*mechanism.coordinates, "t")),  # the inertia changes
            mechanism.constrained,
        )
        return 1 + (KINDS[name].effort + sum(hurdles)) // 2

    def motion(self) -> WorkedAnswer:
        """Return the equations of motion."""
        return WorkedAnswer(self._equations.text(), self._whole)

    def motion_by(self, method: str) -> WorkedAnswer:
        """Return the equations of motion, with the steps of another method."""
        equations = derive(self._mechanism, method)
        return WorkedAnswer(equations.text(), _write_steps(equations))

    def accelerations(self) -> WorkedAnswer:
        """Return the equations of motion solved for the accelerations."""
        solved = self._equations.solved().text()
        self._refuse(not solved, "its accelerations are too long")
        return WorkedAnswer(solved, self._whole)

    def reactions(self) -> WorkedAnswer:
        """Return the reactions in joints in terms of the accelerations, or in contacts."""
        by_methods = (derive(self._mechanism, method) for method in METHODS)
        equations = next((e for e in by_methods if e.derivation.reactions), self._equations)
        derivation, lines = equations.derivation, dict[str, str]()
        determined = {name_of(tie.multiplier) for tie in derivation.ties}
        for name, series in derivation.reactions.items():
            forces = {g.name for g in series.generators() if g.kind is Kind.REACTION}
            if forces <= determined:
                lines[name] = f"{name} = {_say(series)}"
        if not lines and derivation.ties:  # of what rolls, the forces of its contacts
            solved = self._equations.solved()
            lines = {name: str(force) for name, force in solved.forces.items()}
        self._refuse(not lines, "no reaction is determined")
        return WorkedAnswer("\n".join(lines.values()), _write_steps(equations), ", ".join(lines))

    def driving_force(self) -> WorkedAnswer:
        """Return the only input that a motion needs, and the equations that do without it."""
        (symbol,) = self._inputs
        derivation = self._derivation
        ring, lines = derivation.algebra.ring, list[str]()
        accelerations = [ring[name] for name in derivation.algebra.accelerations]
        for row, h, Q in zip(derivation.M, derivation.h, derivation.Q, strict=True):
            whole = along_displacement(row, accelerations) + h - Q
            lever = -whole.diff(symbol)
            rest = _say(whole + lever * ring[symbol])
            lines.append(f"{symbol} = {_over(rest, _say(lever))}" if lever else f"{rest} = 0")
        return WorkedAnswer("\n".join(lines), self._whole, symbol)

    def energy(self, name: str, letter: str) -> WorkedAnswer:
        """Return T, V, T − V or T + V, by its name where formulas are checked."""
        kinetic, potential = ENERGIES[name]
        series = kinetic * self._lagrange.T + potential * self._lagrange.V
        moving = {*self._mechanism.coordinates, *self._rates}
        self._refuse(
            moving.isdisjoint(g.name for g in series.generators()), f"its {name} is constant"
        )
        last = "Potential energy" if potential else "Kinetic energy"
        return WorkedAnswer(f"{letter} = {_say(series)}", self._until(last))

    def mass_matrix(self) -> WorkedAnswer:
        """Return M."""
        rows = [f"[{', '.join(map(_say, row))}]" for row in self._derivation.M]
        return WorkedAnswer(f"[{', '.join(rows)}]", self._until("Kinetic energy") + _FROM_T)

    def momentum(self) -> WorkedAnswer:
        """Return the momentum of the last coordinate."""
        name = self._rates[-1].removesuffix("'")
        momentum = self._lagrange.T.diff(self._rates[-1])
        return WorkedAnswer(f"p = {_say(momentum)}", self._until("Kinetic energy"), name)

    def conserved_momentum(self) -> WorkedAnswer:
        """Return the momentum of the first cyclic coordinate."""
        try:
            name = routh(self._mechanism).cyclic[0]
        except DerivationError as error:
            raise self._without(str(error)) from None
        momentum = self._lagrange.T.diff(f"{name}'")
        return WorkedAnswer(f"p = {_say(momentum)}", self._until("Kinetic energy"))

    def jacobi(self) -> WorkedAnswer:
        """Return Jacobi's integral, where the energy is not conserved."""
        stages = energy_integral(self._lagrange, by_squares=False)
        integrals = [s.results[0].right for s in stages if s.title == "Jacobi's integral"]
        self._refuse(not integrals, "it has no Jacobi integral but its energy")
        return WorkedAnswer(f"h = {_say(integrals[0])}", self._whole)

    def hamiltonian(self) -> WorkedAnswer:
        """Return H = p q' − L in momenta."""
        rates, momenta = self._rates_by_momenta, self._momenta
        terms = [f"{p} {_bracket(rate)}/2" for p, rate in zip(momenta, rates, strict=True)]
        text = f"H = {' + '.join([*terms, _bracket(_say(self._lagrange.V))])}"
        return WorkedAnswer(text, self._until("Potential energy"), ", ".join(momenta))

    def canonical(self) -> WorkedAnswer:
        """Return Hamilton's equations."""
        rates, momenta = self._rates_by_momenta, self._momenta
        lines = [f"{v} = {rate}" for v, rate in zip(self._rates, rates, strict=True)]
        L = self._lagrange.T - self._lagrange.V
        known = {g.name for g in L.generators()}
        for velocity, p in zip(self._rates, momenta, strict=True):
            name = velocity.removesuffix("'")
            slope = _say(L.diff(name)) if name in known else "0"
            lines.append(f"{p}' = {self._replace(slope, rates)}")
        return WorkedAnswer("\n".join(lines), self._until("Potential energy"), ", ".join(momenta))

    def state_space(self) -> WorkedAnswer:
        """Return the equations of first order, with a letter for each rate."""
        solved = self._equations.solved().text().splitlines()
        letters = self._number("w")
        lines = [f"{v} = {w}" for v, w in zip(self._rates, letters, strict=True)]
        for line, w in zip(solved, letters, strict=False):
            lines.append(f"{w}' = {self._replace(line.partition(' = ')[2], letters)}")
        return WorkedAnswer("\n".join(lines), self._whole, ", ".join(letters))

    def holding_force(self) -> WorkedAnswer:
        """Return the inputs that balance the slope of the potential."""
        inputs = [signal.symbol for signal in self._mechanism.inputs]
        lines = []
        for velocity, Q in zip(self._rates, self._derivation.Q, strict=True):
            acting = [g.name for g in Q.generators() if g.name in inputs]
            if acting:
                slope = _say(self._lagrange.V.diff(velocity.removesuffix("'")))
                lever = _say(Q.diff(acting[0]))
                lines.append(f"{acting[0]} = {_over(slope, lever)}")
        self._refuse(not lines, "no force holds it")
        return WorkedAnswer("\n".join(lines), self._until("Potential energy"), ", ".join(inputs))

    def transfer(self) -> WorkedAnswer:
        """Return the transfer function of the first coordinate from the only input."""
        (symbol,) = self._inputs
        letters = self._linearize(dict.fromkeys(self._mechanism.coordinates, 0.0)).symbolic
        M, C, K = letters.matrices.M, letters.matrices.C, letters.matrices.K
        rows = [list(map(_polynomial, *row)) for row in zip(M, C, K, strict=True)]
        by = []
        for Q in self._derivation.Q:
            acts = symbol in {g.name for g in Q.generators()}
            by.append(_say(Q.diff(symbol)) if acts else "0")
        coordinate = self._rates[0].removesuffix("'")
        text = f"G = {self._solve(rows, by)[0]}"
        return WorkedAnswer(
            text, f"{self._whole}\n\n{letters.text()}", f"{coordinate} from {symbol}"
        )

    def equilibrium(self) -> WorkedAnswer:
        """Return the positions at rest, where these are parts of half a turn."""
        lines = []
        for position in equilibria(self._mechanism):
            for name, part in zip(self._mechanism.coordinates, position.q / np.pi, strict=True):
                half = Fraction(part).limit_denominator(12)
                self._refuse(abs(part - half) > _PART, "its equilibria depend on its numbers")
                whole = {0: "0", 1: "pi", -1: "-pi"}.get(half.numerator, f"{half.numerator} pi")
                over = f"/{half.denominator}" if half.denominator > 1 else ""
                lines.append(f"{name} = {whole}{over}")
        self._refuse(not lines, "it has no equilibrium")
        return WorkedAnswer("\n".join(lines), self._until("Potential energy"))

    def frequency(self) -> WorkedAnswer:
        """Return the frequencies, in letters of a single one at zero, else in numbers."""
        small = self._vibrate()
        named = _number_lines("omega", "rad/s", small.frequencies.tolist())
        letters = small.symbolic
        text, note = "\n".join(named), _DIGITS
        if letters.square is not None and not small.q.any():
            text, note = f"omega = sqrt({_say(letters.square)})", ""
        said = f"With the numbers given: {', '.join(named)}"
        return WorkedAnswer(text, self._linear_steps(letters, said), self._say_place(small), note)

    def numbers(self, letter: str, unit: str, convert: Callable[[float], float]) -> WorkedAnswer:
        """Return what follows from each frequency in numbers, to four digits."""
        small = self._vibrate()
        self._refuse(not small.frequencies.all(), "it can drift away")
        named = _number_lines(letter, unit, map(convert, small.frequencies.tolist()))
        steps, place = self._linear_steps(small.symbolic), self._say_place(small)
        return WorkedAnswer("\n".join(named), steps, place, _DIGITS)

    def _vibrate(self) -> Linearization:
        """Return undamped vibrations about a stable equilibrium."""
        small = self._linearize()
        self._refuse(
            not small.stable or bool(small.C.any()) or not small.frequencies.any(),
            "expected an undamped mechanism that swings about a stable equilibrium",
        )
        return small

    def _say_place(self, small: Linearization) -> str:
        pairs = zip(self._mechanism.coordinates, small.q, strict=True)
        return ", ".join(f"{name} = {value:.4g}" for name, value in pairs)

    def period(self) -> WorkedAnswer:
        """Return the period of small oscillations about zero."""
        letters, square, _ = self._swing()
        return WorkedAnswer(f"T = 2 pi/sqrt({_say(square)})", self._linear_steps(letters))

    def undamped_frequency(self) -> WorkedAnswer:
        """Return the undamped frequency of a damped mechanism."""
        letters, square, damping = self._swing()
        self._refuse(not damping, "it is not damped")
        return WorkedAnswer(f"omega = sqrt({_say(square)})", self._linear_steps(letters))

    def undamped_period(self) -> WorkedAnswer:
        """Return the period of a damped mechanism without its damping."""
        answer = self.undamped_frequency()
        return answer._replace(text=_invert(answer.text))

    def damped_frequency(self) -> WorkedAnswer:
        """Return the frequency of a damped mechanism, √(K/M − (C/2M)²)."""
        letters, square, damping = self._swing()
        self._refuse(not damping, "it is not damped")
        text = f"omega = sqrt({_say(square)} - ({damping})^2/4)"
        return WorkedAnswer(text, self._linear_steps(letters))

    def damped_period(self) -> WorkedAnswer:
        """Return the time between two passages of a damped mechanism in one sense."""
        answer = self.damped_frequency()
        return answer._replace(text=_invert(answer.text))

    def period_from_rest(self) -> WorkedAnswer:
        """Return the period at any amplitude, by an integral between −q0 and q0."""
        self._refuse(len(self._rates) != 1, "it has several coordinates")
        name, V = self._mechanism.coordinates.names[0], _say(self._lagrange.V)
        there = re.sub(rf"\b{name}\b", f"{name}0", V)
        inertia = _say(self._derivation.M[0][0])
        text = f"T = integral(sqrt(2 ({inertia})/({there} - ({V}))), {name}, -{name}0, {name}0)"
        return WorkedAnswer(text, self._until("Potential energy"), f"{name} = {name}0")

    def _swing(self) -> tuple[Linearized, Series, str]:
        """Return small motions about zero, the square K/M, and C/M or nothing."""
        small = self._linearize(dict.fromkeys(self._mechanism.coordinates, 0.0))
        letters = small.symbolic
        if letters.square is None or len(self._rates) != 1:
            raise self._without("no single coordinate swings about zero")
        matrices = letters.matrices
        (C,), (M,) = matrices.C[0], matrices.M[0]
        return letters, letters.square, f"{_bracket(_say(C))}/{_bracket(_say(M))}" if C else ""

    def _linearize(self, at: Mapping[str, float] | None = None) -> Linearization:
        try:
            small = linearize(self._mechanism, at)
            assert small.symbolic
        except (ClosureError, DerivationError, InputError) as error:
            raise self._without(str(error)) from None
        return small

    def _linear_steps(self, letters: Linearized, *more: str) -> str:
        lines = ("Equations of motion:", self._equations.text(), "", letters.text())
        return "\n".join([*lines, *(f"\n{said}" for said in more)])

    @property
    def _inputs(self) -> list[str]:
        """The letter of the only input."""
        inputs = [signal.symbol for signal in self._mechanism.inputs]
        self._refuse(len(inputs) != 1, "it has no single input")
        return inputs

    @property
    def _rates(self) -> tuple[str, ...]:
        return self._mechanism.velocities

    @cached_property
    def _lagrange(self) -> Lagrange:
        return Lagrange(self._mechanism, self._derivation.algebra)

    @property
    def _momenta(self) -> list[str]:
        return self._number("p")

    @property
    def _rates_by_momenta(self) -> list[str]:
        M = [list(map(_say, row)) for row in self._derivation.M]
        return self._solve(M, self._momenta)

    def _number(self, letter: str) -> list[str]:
        """Return a letter for each velocity, numbered if there are several."""
        count = len(self._rates)
        taken = letter in self._mechanism.values or any("'" not in rate for rate in self._rates)
        self._refuse(taken, f"it has a letter {letter} already, or velocities that are no rates")
        return [letter] if count == 1 else [f"{letter}{k + 1}" for k in range(count)]

    def _replace(self, formula: str, terms: Sequence[str]) -> str:
        """Return a formula with others in place of the velocities."""
        for rate, term in zip(self._rates, terms, strict=True):
            formula = re.sub(rf"(?<!\w){rate}(?!')", _bracket(term), formula)
        return formula

    def _solve(self, rows: Sequence[Sequence[str]], right: Sequence[str]) -> list[str]:
        """Return the solution of one or two linear equations, by Cramer's rule."""
        self._refuse(len(rows) > 2, "it has more than two coordinates")
        first, *others = map(_bracket, right)
        (a, *b), *below = (map(_bracket, row) for row in rows)
        if not others:
            return [f"{first}/{a}"]
        (second,), ((c, d),) = others, below
        if b == ["0"] == [c]:
            return [f"{first}/{a}", f"{second}/{d}"]
        determinant = _subtract((a, d), (b[0], c))
        solution = _subtract((d, first), (b[0], second)), _subtract((a, second), (c, first))
        return [f"({above})/({determinant})" for above in solution]

    def _refuse(self, condition: bool, why: str) -> None:
        if condition:
            raise self._without(why)

    def _without(self, why: str) -> InputError:
        return InputError(f"no such exercise about {self._mechanism.name!r}: {why}")

    def _until(self, last: str) -> str:
        """Return the steps of the derivation up to the one with a title."""
        document = self._equations.document
        stages = document.derivation.stages
        titles = [stage.title for stage in stages]
        kept = stages[: titles.index(last) + 1] if last in titles else stages
        derivation = replace(document.derivation, stages=kept, assumptions=())
        text = replace(document, derivation=derivation, special=False).text(steps=True)
        return text.partition(f"\n\n{len(kept) + 1}. Equations of motion")[0]


def _write_steps(equations: Equations) -> str:
    """Write a derivation as far as its result."""
    return replace(equations.document, special=False).text(steps=True)


def _number_lines(letter: str, unit: str, values: Iterable[float]) -> list[str]:
    """Return a line for each value to four digits, numbered if there are several."""
    listed = list(values)
    numbers = range(1, len(listed) + 1) if len(listed) > 1 else [""]
    return [f"{letter}{k} = {x:.4g} {unit}" for k, x in zip(numbers, listed, strict=True)]


def _invert(frequency: str) -> str:
    """Return the line of the period, T = 2π/ω, by that of a frequency."""
    return f"T = 2 pi/{frequency.partition(' = ')[2]}"


def _bracket(formula: str) -> str:
    """Return a formula as a factor: in brackets, unless it is a letter."""
    return formula if re.fullmatch(r"\w+'*", formula) else f"({formula})"


def _over(above: str, below: str) -> str:
    return above if below == "1" else f"{_bracket(above)}/{_bracket(below)}"


def _subtract(product: tuple[str, str], other: tuple[str, str]) -> str:
    """Return the difference of two products, without those that are zero."""
    terms = []
    for factors in (product, other):
        written = " ".join(factor for factor in factors if factor != "1")
        terms.append("" if "0" in factors else written or "1")
    return " - ".join(terms) if all(terms) else terms[0] or f"-{terms[1]}"


def _polynomial(square: Series, linear: Series, constant: Series) -> str:
    """Return a polynomial in s."""
    terms = [(_say(square), " s^2"), (_say(linear), " s"), (_say(constant), "")]
    written = [(x, power) for x, power in terms if x != "0"]
    if written == terms[2:]:
        return written[0][0]
    return " + ".join(f"{_bracket(x)}{power}" for x, power in written) or "0"


def _say(series: Series) -> str:
    return expression(series).text()


_MOTION = "equation of motion"


class ExerciseKind(NamedTuple):
    """A kind of question: its words, and what answers it."""

    task: str
    answer: Callable[[Solver], WorkedAnswer]
    of: str = ""  # what follows its name where `mecanique.check` is asked
    ask: str = ""  # what that is asked, if not its name
    effort: int = 2  # from 0 to 3, how many steps lead from velocities and heights to the answer


_TOTAL = partial(Solver.energy, name="energy", letter="E")

KINDS = {
    _MOTION: ExerciseKind("Derive the {equations} of motion in the {q}.", Solver.motion),
    **{
        f"{_MOTION} by {name}": ExerciseKind(
            f"Derive the {{equations}} of motion in the {{q}} from {method.title}.",
            partial(Solver.motion_by, method=name),
            ask=_MOTION,
        )
        for name, method in METHODS.items()
    },
    "acceleration": ExerciseKind(
        "Give the {accelerations} in the {q} and {rates}.",
        Solver.accelerations,
        ask=_MOTION,
        effort=3,
    ),
    "reaction": ExerciseKind(
        "Find the reactions {what}.",
        Solver.reactions,
        " of {what}",
        effort=3,
    ),
    "driving force": ExerciseKind(
        "Find {what} by the motion in the {q}, and what the motion obeys besides.",
        Solver.driving_force,
        ask=_MOTION,
    ),
    "kinetic energy": ExerciseKind(
        "Write the kinetic energy T in the {q} and {rates}.",
        partial(Solver.energy, name="kinetic energy", letter="T"),
        effort=0,
    ),
    "potential energy": ExerciseKind(
        "Write the potential energy V in the {q}.",
        partial(Solver.energy, name="potential energy", letter="V"),
        effort=0,
    ),
    "Lagrangian": ExerciseKind(
        "Write Lagrange's function L = T − V in the {q} and {rates}.",
        partial(Solver.energy, name="Lagrangian", letter="L"),
        effort=1,
    ),
    "energy": ExerciseKind(
        "Write the energy E = T + V in the {q} and {rates}.",
        _TOTAL,
        effort=1,
    ),
    "conserved quantity": ExerciseKind(
        "Find a quantity that is constant in every motion, in the {q} and {rates}.",
        _TOTAL,
    ),
    "conserved momentum": ExerciseKind(
        "Which coordinate is cyclic? Write the momentum p that is conserved.",
        Solver.conserved_momentum,
        ask="conserved quantity",
    ),
    "Jacobi's integral": ExerciseKind(
        "The energy is not conserved. Find the integral h of the motion in the {q} and {rates}.",
        Solver.jacobi,
        ask="conserved quantity",
        effort=3,
    ),
    "mass matrix": ExerciseKind(
        "Write the mass matrix M for the {q}{order}.",
        Solver.mass_matrix,
        effort=1,
    ),
    "momentum": ExerciseKind(
        "Write the canonical momentum p of {what}.",
        Solver.momentum,
        " of {what}",
        effort=1,
    ),
    "Hamiltonian": ExerciseKind(
        "Write Hamilton's function H in the {q} and the canonical {momenta} {what}.",
        Solver.hamiltonian,
        effort=3,
    ),
    "Hamilton's equations": ExerciseKind(
        "Write Hamilton's equations in the {q} and the canonical {momenta} {what}.",
        Solver.canonical,
        effort=3,
    ),
    "state space": ExerciseKind(
        "Write the equations of motion as equations of first order, with {what} for {rates}.",
        Solver.state_space,
        effort=3,
    ),
    "equilibrium": ExerciseKind(
        "Find all positions at rest.",
        Solver.equilibrium,
        effort=1,
    ),
    "equilibrium force": ExerciseKind(
        "Find {what} such that the mechanism rests at any position.",
        Solver.holding_force,
        effort=1,
    ),
    "frequency": ExerciseKind(
        "Find the natural angular {frequencies} of small motions about {what}{note}.",
        Solver.frequency,
    ),
    "frequency in hertz": ExerciseKind(
        "Find the natural {frequencies} f of small motions about {what} in Hz{note}.",
        partial(Solver.numbers, letter="f", unit="Hz", convert=lambda omega: omega / (2 * np.pi)),
        ask="frequency",
    ),
    "period in seconds": ExerciseKind(
        "Find the {periods} T of small motions about {what} in s{note}.",
        partial(Solver.numbers, letter="T", unit="s", convert=lambda omega: 2 * np.pi / omega),
        ask="frequency",
    ),
    "period": ExerciseKind("Find the period T of small oscillations about zero.", Solver.period),
    "period from rest": ExerciseKind(
        "Find the period T of the motion that begins at rest at {what}.",
        Solver.period_from_rest,
        effort=3,
    ),
    "undamped frequency": ExerciseKind(
        "Find the angular frequency omega of small oscillations about zero without the damping.",
        Solver.undamped_frequency,
    ),
    "undamped period": ExerciseKind(
        "Find the period T of small oscillations about zero without the damping.",
        Solver.undamped_period,
        ask="undamped frequency",
    ),
    "damped frequency": ExerciseKind(
        "Find the angular frequency omega of the damped small oscillations about zero.",
        Solver.damped_frequency,
        effort=3,
    ),
    "damped period": ExerciseKind(
        "Find the period T of the damped small oscillations about zero.",
        Solver.damped_period,
        ask="damped frequency",
        effort=3,
    ),
    "transfer function": ExerciseKind(
        "Find the transfer function G(s) of {what}, for small motions about zero.",
        Solver.transfer,
        " of {what}",
        effort=3,
    ),
}
"""What an exercise may ask for."""
