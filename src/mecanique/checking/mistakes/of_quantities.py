"""Mistakes in energies, matrices, frequencies and conserved quantities, by what they lead to."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import partial
from itertools import chain, combinations, pairwise, product
from types import MappingProxyType
from typing import TypeAlias, final

import numpy as np

from mecanique.arrays import Array
from mecanique.checking.budget import spend, stop_clock
from mecanique.checking.grammar.letters import KnownLetters
from mecanique.checking.grammar.reader import Statement
from mecanique.checking.grammar.tape import FormulaTape, find_rounding
from mecanique.checking.grammar.tree import (
    Node,
    add,
    call,
    divide,
    letter,
    multiply,
    negate,
    number,
    raise_to,
    rate,
    rename,
)
from mecanique.checking.judgement.equilibria import equilibria_of, judge_positions
from mecanique.checking.judgement.motion import Residual
from mecanique.checking.judgement.quantities import (
    ENERGIES,
    AskedQuantity,
    find_frequencies,
    linear_matrices,
    measure,
    roll,
)
from mecanique.checking.judgement.truth import SeriesValues, Truth
from mecanique.checking.mistakes.hypotheses import (
    ALIKE,
    MOST_BODIES,
    MULTIPLES,
    NO_INERTIA,
    SIMPLE,
    EquationValues,
    Hypotheses,
    Reading,
    Share,
    WrongDerivation,
    group_by_velocities,
    list_pieces,
    list_relative,
    say_zero,
)
from mecanique.checking.mistakes.units import LetterUnits, UnitMisfitError
from mecanique.checking.verdict import Mistake
from mecanique.derivation.printing.equations import expression
from mecanique.derivation.scalars.series import Kind, Series
from mecanique.derivation.symbolic.derivation import Derivation
from mecanique.derivation.symbolic.lagrange import Lagrange
from mecanique.errors import FormulaError, InputError, MechanismError
from mecanique.model.mechanism.description import angles

_STEP = 1e-5
"""A displacement from equilibrium, in radians or meters, at which restoring forces are taken."""

_MOST_MODES = 3
"""Of more frequencies at once none is derived with mistakes."""

Claims: TypeAlias = "list[dict[str, Array]]"
"""The values of all letters in the states, and in others, as a formula says them."""

_SUMS = {"Lagrangian": (1, -1), "energy": (1, 1), "Hamiltonian": (1, 1)}
"""How much of T and V is in what is their sum or difference."""

_PARTS = {**ENERGIES, **_SUMS}
"""The same of all energies."""

_CONSERVED = 1e-8
"""A rate below this part of its terms is zero."""


@final
class QuantityMistakes:
    """Finds the mistakes that lead to a wrong quantity of one mechanism."""

    def __init__(self, truth: Truth, hypotheses: Hypotheses, units: LetterUnits) -> None:
        self._truth = truth
        self._letter_units = units
        self._units = {p.symbol: p.unit for p in truth.mechanism.parameters}
        self._hypotheses = hypotheses
        self._quantity: AskedQuantity | None = None
        self._known: list[tuple[Mistake, Claims]] = []
        self._rest: Iterator[tuple[Mistake, Claims]] = iter(())

    def explain(self, residual: Residual, quantity: AskedQuantity) -> Iterator[Mistake]:
        """Yield the mistakes after which a formula would be right."""
        if self._truth.derivation is None or residual.sample.count != self._truth.sample.count:
            return
        for mistake, claims in self._recall_claims(quantity):
            spend()
            if quantity.kind != "several":
                explains = _holds(residual, claims)
            else:
                repeated = is_repeated(residual.root, quantity)
                if repeated and mistake.kind == "simple system":
                    continue  # other roots of a polynomial may be right
                every = all if repeated else any
                explains = (not repeated and _holds_in_turn(residual, claims)) or every(
                    _holds(residual, [claim]) or _is_rounded(residual, claim) for claim in claims
                )
            if explains:
                yield mistake
        yield from self._fit_shares(residual, quantity)

    def _fit_shares(self, residual: Residual, quantity: AskedQuantity) -> Iterator[Mistake]:
        """Yield the properties of parts that a formula takes too large by one factor."""
        if not self._is_made_up(quantity) or quantity.name == "Hamiltonian":
            return  # in momenta, T is not in proportion to masses
        right, resting = self._hypotheses.right.terms, self._at_rest(quantity)
        for share in self._hypotheses.shares:
            spend()

            def claim(factor: float, share: Share = share) -> Claims:
                wrong = right.plus(share.terms, factor - 1)
                return self._claim_terms(quantity, wrong, resting)

            # energies are linear in it
            without, true = (_compare_claims(residual, claim(factor)) for factor in (0.0, 1.0))
            factors = without / (without - true)
            factors = factors[np.isfinite(factors)]
            if not len(factors) or np.ptp(factors) > ALIKE * np.abs(factors).max():
                continue
            mistake = share.say(float(factors.mean()))
            if mistake and _holds(residual, claim(float(factors.mean()))):
                yield mistake

    def mend(self, residual: Residual, quantity: AskedQuantity, written: str) -> Iterator[Mistake]:
        """Yield the single changes after which a formula would be right, wherever they stand."""
        if quantity.kind not in ("value", "up to a constant") or quantity.values is None:
            return
        claims = self._claim(quantity, quantity.values)
        if quantity.again is not None:
            claims += self._claim(quantity, *quantity.again)
        for mistake, changed in mutate(residual.root, written, self._units):
            spend()
            if _holds(replace(residual, root=changed), claims):
                yield mistake

    def _recall_claims(self, quantity: AskedQuantity) -> Iterator[tuple[Mistake, Claims]]:
        """Yield the claims of mistakes, which are derived once for all lines of an answer."""
        if self._quantity is not quantity:
            self._quantity, self._known, self._rest = quantity, [], self._list_claims(quantity)
        yield from self._known
        for claim in self._rest:
            self._known.append(claim)
            yield claim

    def _list_claims(self, quantity: AskedQuantity) -> Iterator[tuple[Mistake, Claims]]:
        """Yield mistakes, each with what a formula says that makes it."""
        if self._is_made_up(quantity):
            yield from self._claim_energies(quantity)
        if quantity.name == "Hamiltonian":
            yield from self._claim_without(quantity)
        if quantity.again is not None and quantity.name in _SUMS:
            yield from self._claim_shares(quantity, *_SUMS[quantity.name])
        if quantity.kind in ("value", "up to a constant"):
            yield from self._claim_readings(quantity)
            for kind, text, values in quantity.slips:
                yield Mistake(kind, text, "", 0.7), self._claim(quantity, values)
        if quantity.kind == "several":
            yield from self._claim_frequencies(quantity)
        if quantity.kind == "letters" and quantity.derivation is not None:
            yield from self._claim_reactions(quantity, quantity.derivation)

    def _claim_reactions(
        self, quantity: AskedQuantity, derivation: Derivation
    ) -> Iterator[tuple[Mistake, Claims]]:
        """Yield the hypotheses with the reactions in the motions that they lead to."""
        sample = self._truth.sample
        moving = (*self._truth.accelerations, *self._truth.multipliers)
        if {*quantity.letters} - {*quantity.series, *moving}:
            return  # where wheels part, forces follow from the size of others
        right = self._hypotheses.right.terms
        for hypothesis, motion in self._hypotheses.pairs:
            # a factor of T is no slip in a balance of forces, nor is a single term of the equations
            if hypothesis.row >= 0 or hypothesis.kind == "half":
                continue
            # the balances of free bodies contain the right weights
            if quantity.series and (hypothesis.terms.V != right.V).any():
                continue
            led = {**sample.values, **dict(zip(moving, motion.T, strict=True))}
            here = SeriesValues(derivation, led, sample.count)
            reactions = {letter: here(series) for letter, series in quantity.series.items()}
            yield hypothesis.mistake(0.05), [led | reactions]

    def _claim(
        self,
        quantity: AskedQuantity,
        values: Array,
        states: Mapping[str, Array] = MappingProxyType({}),
    ) -> Claims:
        """Return the values of all letters where a quantity has these."""
        claimed, right = dict.fromkeys(quantity.letters, values), quantity.values
        if right is not None:
            # a transform is as many times too large as the transfer function
            more = {name: x for name, x in quantity.more.items() if name in claimed}
            claimed |= {name: x * values / right for name, x in more.items()}
        return [{**self._truth.sample.values, **quantity.more, **states, **claimed}]

    def _claim_readings(self, quantity: AskedQuantity) -> Iterator[tuple[Mistake, Claims]]:
        """Yield relative for absolute coordinates, and angles from a line at right angles."""
        series = next(iter(quantity.series.values()), None)
        sample = self._truth.sample
        if series is None:
            return
        others = [] if quantity.again is None else [quantity.again[1]]
        for text, weight, read, _ in self._list_readings():
            claims: Claims = []
            for states in ({}, *others):
                values = {**sample.values, **states}
                taken = self._truth.at({**values, **read(values)})(series)
                claims += self._claim(quantity, taken, states)
            yield Mistake("angle", text, "", weight), claims

    def _list_readings(self) -> Iterator[tuple[str, float, Reading, Array]]:
        """Yield what coordinates may be taken for: words, weight, letters, their rates by ours."""
        truth = self._truth
        for text, read, rates, dots in list_relative(truth):
            yield text, 1.3 + 0.1 * (len(dots) == 1), read, rates
        names = {v.removesuffix("'") for v in truth.velocities if v.endswith("'")}
        turning = sorted(angles(truth.mechanism) & names)
        for some in [(name,) for name in turning] + [tuple(turning)] * (len(turning) > 1):
            said = "every angle" if some[1:] else some[0]
            text = (
                f"{said} is counted from a line at right angles to the one in question: sin and "
                "cos are exchanged"
            )
            for turned in (-np.pi / 2, np.pi / 2):
                yield text, 1.6, partial(_turn_letters, some, turned), np.eye(len(truth.velocities))

    def explain_matrix(self, given: Array) -> Iterator[Mistake]:
        """Yield the mistakes that lead to a mass matrix, shape (n, nv, nv)."""
        for text, weight, read, turn in self._list_readings():
            spend()
            M = turn.T @ self._truth.at(read(self._truth.sample.values)).M @ turn
            if (np.abs(given - M) <= ALIKE * (np.abs(given) + np.abs(M))).all():
                yield Mistake("angle", text, "", weight)
        for hypothesis in self._hypotheses.listed:
            M = hypothesis.terms.M
            alike = (np.abs(given - M) <= ALIKE * (np.abs(given) + np.abs(M))).all()
            if alike and hypothesis.row < 0:
                yield hypothesis.mistake()

    def _is_made_up(self, quantity: AskedQuantity) -> bool:
        """Whether a quantity is made up of T and V, or is a slope of T."""
        made_up = quantity.name in _SUMS or quantity.name in ENERGIES or quantity.velocity
        return bool(made_up) and quantity.values is not None

    def _claim_energies(self, quantity: AskedQuantity) -> Iterator[tuple[Mistake, Claims]]:
        """Yield the hypotheses, with what their T and V make up."""
        kinetic, potential = _PARTS.get(quantity.name, (0, 0))
        right, resting = self._hypotheses.right.terms, self._at_rest(quantity)
        for hypothesis in self._hypotheses.listed:
            dT, dV = hypothesis.terms.T - right.T, hypothesis.terms.V - right.V
            dM = hypothesis.terms.M - right.M
            if hypothesis.row >= 0 or not (dM.any() or dT.any() or dV.any()):
                continue
            # what is not asked for is less likely wrong
            aside = (kinetic == 0 and dT.any()) or (potential == 0 and dV.any())
            claims = self._claim_terms(quantity, hypothesis.terms, resting)
            yield hypothesis.mistake(0.2 * aside), claims

    def _claim_without(self, quantity: AskedQuantity) -> Iterator[tuple[Mistake, Claims]]:
        """Yield the Hamiltonian as it is in momenta where a parameter is taken as zero."""
        truth, series = self._truth, quantity.series[quantity.letters[0]]
        T = Lagrange(truth.mechanism, truth.closed_form.algebra).T
        momenta = list(map(T.diff, truth.velocities))
        still = dict.fromkeys(truth.velocities, 0.0)
        assert quantity.again is not None
        for parameter in truth.mechanism.parameters:
            zero = {parameter.symbol: np.zeros(truth.sample.count)}
            claims: Claims = []
            for states in ({}, quantity.again[1]):
                # the rates that these momenta have there
                p = truth.at(states).stack(momenta)
                there = truth.at({**states, **zero, **still})
                if not (np.abs(np.linalg.det(there.M)) > 0).all():
                    break
                v = np.linalg.solve(there.M, (p - there.stack(momenta))[..., None])[..., 0]
                rates = dict(zip(truth.velocities, v.T, strict=True))
                value = truth.at({**states, **zero, **rates})(series)
                claims += self._claim(quantity, value, states)
            if claims[1:]:
                yield Mistake("missing", say_zero(parameter), "", 1.3), claims

    def _claim_terms(
        self,
        quantity: AskedQuantity,
        terms: EquationValues,
        resting: Sequence[tuple[Array, Mapping[str, Array]]],
    ) -> Claims:
        """Return a quantity as T and V of these equations make it up."""
        truth, sample = self._truth, self._truth.sample
        kinetic, potential = _PARTS.get(quantity.name, (0, 0))
        v = np.stack([sample.values[n] for n in truth.velocities], axis=-1)
        right = self._hypotheses.right.terms
        dV = terms.V - right.V
        more = kinetic * (terms.T - right.T) + potential * dV[0]
        if quantity.velocity:
            k = truth.velocities.index(quantity.velocity)
            more = np.einsum("nj,nj->n", (terms.M - right.M)[:, k], v)
        if quantity.name == "Hamiltonian":
            # in momenta, T is p M⁻¹ p/2
            p = np.einsum("nij,nj->ni", sample.M, v)
            wrong_v = np.linalg.solve(terms.M, p[..., None])[..., 0]
            more = np.einsum("ni,ni->n", p, wrong_v - v) / 2 + dV[0]
        assert quantity.values is not None
        claims = self._claim(quantity, quantity.values + more)
        # with all at rest, the potential must be right, and its constant is open
        for (values, states), change in zip(resting, dV, strict=False):
            claims += self._claim(quantity, values + potential * change, states)
        return claims

    def _claim_shares(
        self, quantity: AskedQuantity, kinetic: int, potential: int
    ) -> Iterator[tuple[Mistake, Claims]]:
        """Yield T or V left out, with the wrong sign, twice or half, in their sum."""
        truth = self._truth
        assert quantity.values is not None
        assert quantity.again is not None
        lagrange = Lagrange(truth.mechanism, truth.closed_form.algebra)
        here, there = truth.at({}), truth.at(quantity.again[1])
        for name, share, part in (
            ("the kinetic energy", kinetic, lagrange.T),
            ("the potential energy", potential, lagrange.V),
        ):
            for factor, kind, words in MULTIPLES:
                change = share * (factor - 1)
                claims = self._claim(quantity, quantity.values + change * here(part))
                moved = quantity.again[0] + change * there(part)
                claims += self._claim(quantity, moved, quantity.again[1])
                yield Mistake(kind, words.format(name), "", 0.95 + 0.1 * (factor > 0)), claims

    def _at_rest(self, quantity: AskedQuantity) -> list[tuple[Array, Mapping[str, Array]]]:
        """Return the quantity where velocities vanish, in the states and in the moved ones."""
        if quantity.again is None:
            return []
        truth, sample = self._truth, self._truth.sample
        series = next(iter(quantity.series.values()))
        momenta = quantity.more.keys() - sample.lengths.keys()
        names = (*truth.velocities, *truth.accelerations, *momenta)
        still = dict.fromkeys(names, np.zeros(sample.count))
        states = [{**moving, **still} for moving in (sample.letters, quantity.again[1])]
        return [(truth.at(values)(series), values) for values in states]

    def _claim_frequencies(self, quantity: AskedQuantity) -> Iterator[tuple[Mistake, Claims]]:
        """Yield other measures of a frequency, and those that mistakes lead to."""
        assert quantity.values is not None
        letters = quantity.letters
        known = {**self._truth.sample.values, **quantity.more}
        for omega in quantity.values:
            for weight, text, values in _other_measures(omega, letters):
                yield Mistake("measure", text, "", weight), [{**known, **values}]
            for scale, said in ((0.5, "half of"), (2.0, "twice")):
                values = {name: v * scale for name, v in measure(omega, letters).items()}
                text = f"it is {said} what it should be"
                yield Mistake("factor", text, "", 1.45), [{**known, **values}]
        for kind, text, several in quantity.slips:
            for omega in several:
                yield Mistake(kind, text, "", 0.7), [{**known, **measure(omega, letters)}]
        for text, omega in self._list_simple():
            yield Mistake("simple system", text, "", 2.05), [{**known, **measure(omega, letters)}]
        if len(quantity.values) <= _MOST_MODES and not quantity.more:
            for mistake, wrong in self._frequencies(quantity.position):
                yield mistake, [{**known, **measure(omega, letters)} for omega in wrong]

    def _list_simple(self) -> Iterator[tuple[str, Array]]:
        """Yield the frequencies of a point mass on a rod or a spring alone, by their letters."""
        values = self._truth.sample.values
        of: dict[str, list[str]] = {"m/s²": [], "m": [], "N/m": [], "kg": []}
        for name, unit in self._units.items():
            of.setdefault(unit, []).append(name)
        for g, l in product(of["m/s²"], of["m"]):
            text = f"it is that of a simple pendulum, a point mass on a massless rod of length {l}"
            yield text, np.sqrt(values[g] / values[l])
        for k, m in product(of["N/m"], of["kg"]):
            text = f"it is that of a point mass {m} on a spring {k} alone"
            yield text, np.sqrt(values[k] / values[m])

    def _remove_masses(
        self, position: Mapping[str, Array]
    ) -> Iterator[tuple[Mistake, list[Array]]]:
        """Yield the frequencies of a mechanism with constraints that lacks the mass of a part."""
        truth, mechanism = self._truth, self._truth.mechanism
        at = {name: position[name] for name in mechanism.coordinates if name in position}
        pieces = list_pieces(mechanism) if len(mechanism.bodies) <= MOST_BODIES else []
        for piece, massless in product(pieces, (True, False)):
            lacking = replace(piece.shape, inertia=NO_INERTIA)
            lacking = replace(lacking, mass=0.0) if massless else lacking
            with stop_clock():
                other = truth.change(piece.put(mechanism, lacking))
                try:
                    if other.derivation is None:
                        continue
                    held = {**at, **equilibria_of(other).locate(at)}
                    M, C, K, _ = linear_matrices(other, held)
                except (InputError, MechanismError):
                    continue
            text = f"the mass of {piece.said} is missing"
            if not massless:
                text = f"the inertia of {piece.said} about its own center is missing"
            yield Mistake("missing", text, "", 1.2), [*find_frequencies(M, C, K).T]

    def _frequencies(self, position: Mapping[str, Array]) -> Iterator[tuple[Mistake, list[Array]]]:
        """Yield the frequencies that mistakes lead to, those that differ from the right ones."""
        truth = self._truth
        if truth.mechanism.constrained:
            yield from self._remove_masses(position)
            return
        sides: list[Hypotheses] = []
        for velocity in truth.velocities:
            name = velocity.removesuffix("'")
            middle = position.get(name, np.zeros(truth.sample.count))
            for step in (-_STEP, _STEP):
                still = truth.rest({**position, name: middle + step})
                if still is None or name == velocity:
                    return
                sides.append(Hypotheses(still))
        with stop_clock():
            right = _oscillate([side.right.terms for side in sides])
            tables = [dict(zip(map(_key, side.every), side.every, strict=True)) for side in sides]
        for hypothesis in sides[0].every:
            key = _key(hypothesis)
            terms = [table[key].terms for table in tables if key in table]
            several = len(sides) > 2 and hypothesis.row >= 0
            if len(terms) < len(sides) or several or hypothesis.kind in ("linearized", "angle"):
                continue
            pairs = zip(_oscillate(terms), right, strict=True)
            wrong = [
                omega
                for omega, true in pairs
                if not np.allclose(omega, true, rtol=ALIKE, atol=0.0, equal_nan=True)
            ]
            if wrong:
                yield hypothesis.mistake(), wrong

    def list_constants(self) -> Iterator[Series]:
        """Yield those of the momenta and Jacobi's integral that are constant in true motions."""
        truth = self._truth
        lagrange = Lagrange(truth.mechanism, truth.closed_form.algebra)
        value = truth.at({})
        momenta = list(map(lagrange.T.diff, truth.velocities))
        ring = lagrange.V.ring
        products = [p * ring[v] for p, v in zip(momenta, truth.velocities, strict=True)]
        fixed = {Kind.PARAMETER, Kind.CONSTANT}
        for whole in (*momenta, ring.sum([lagrange.V - lagrange.T, *products])):
            series = ring.sum([term for term in whole.split() if term.kinds - fixed])
            if (np.abs(value(series.ddt())) <= _CONSERVED * np.abs(value(series)).max()).all():
                yield series

    def explain_position(
        self, statements: Sequence[Statement], wrong: int, written: str
    ) -> Iterator[Mistake]:
        """Yield the changes of a line after which forces balance at the position it gives."""
        left, right = statements[wrong].sides[0], statements[wrong].sides[-1]
        yield from self._find_unbalanced(statements, wrong, written)
        symbols = [parameter.symbol for parameter in self._truth.mechanism.parameters]
        lacking = (
            (Mistake("missing", f"{said}{symbol} is missing", "", weight), join(right, factor))
            for weight, said, join in (
                (1.2, "", add),
                (1.3, "the factor ", multiply),
                (1.3, "the divisor ", divide),
            )
            for symbol, factor in zip(symbols, map(letter, symbols), strict=True)
        )
        mended_right = chain(mutate(right, written, self._units, is_term=True), lacking)
        sides = [(mistake, (left, changed)) for mistake, changed in mended_right]
        if left.kind != "letter":
            sides += [
                (mistake, (changed, right))
                for mistake, changed in mutate(left, written, self._units)
            ]
        for mistake, changed_sides in sides:
            spend()
            mended = replace(statements[wrong], sides=changed_sides)
            others = (*statements[:wrong], mended, *statements[wrong + 1 :])
            try:
                positions, _ = judge_positions(others, self._truth, written)
            except FormulaError:
                continue
            if not any(p.worst or p.fault for p in positions if mended in p.statements):
                yield mistake

    def _find_unbalanced(
        self, statements: Sequence[Statement], wrong: int, written: str
    ) -> Iterator[Mistake]:
        """Yield the force that is left at a position in numbers."""
        truth = self._truth
        positions, _ = judge_positions(statements, truth, written)
        there = [p for p in positions if p.worst and statements[wrong] in p.statements]
        if not there or truth.mechanism.constrained:
            return
        if any(line.sides[-1].letters - {"pi"} for line in there[0].statements):
            return  # what is wrong in a formula is looked for in it
        still = dict.fromkeys(truth.velocities, 0.0)
        for series in truth.rest_forces:
            forces = group_by_velocities(series, truth.velocities)
            if not (force := forces.get((0,) * len(truth.velocities))):
                continue
            values = truth.at({**there[0].values, **still})(force)
            if np.abs(values).max() > ALIKE * np.abs(truth.at({})(force)).max():
                text = f"the forces do not balance there: {expression(force).text()} is not zero"
                yield Mistake("balance", text, "", 1.05)
                return

    def explain_constant(self, root: Node, written: str) -> Iterator[Mistake]:
        """Yield mistakes in a conserved quantity: forces, and single changes that mend it."""
        truth = self._truth
        moving = KnownLetters.of(truth.mechanism).rate_nodes
        moved = roll(truth, truth.sample)
        derivation = truth.closed_form
        lagrange = Lagrange(truth.mechanism, derivation.algebra)
        tape = FormulaTape(root)
        if truth.sample.forces.any() and not truth.mechanism.constrained:
            sample = truth.sample
            free = sample.a - np.linalg.solve(sample.M, sample.forces[..., None])[..., 0]
            slope = rate(root, moving)
            letters = {**sample.letters, **dict(zip(truth.accelerations, free.T, strict=True))}
            values = FormulaTape(slope).evaluate(letters, sample.count)
            if (np.abs(values.whole) <= _CONSERVED * values.size).all() and values.size.any():
                acting = [force.name for force in truth.mechanism.forces]
                text = f"it is conserved only without the forces {', '.join(acting)}"
                yield Mistake("force", text, "", 0.6)
        first = tape.evaluate(truth.sample.values, truth.sample.count)
        later = tape.evaluate({**truth.sample.values, **moved}, truth.sample.count)
        for kind, whole, text in (
            (
                "Jacobi",
                lagrange.T + lagrange.V,
                "it is T + V, which a prescribed motion or a force changes; Jacobi's integral is "
                "T2 − T0 + V, with the terms of T by their degree in the velocities",
            ),
            (
                "sign",
                lagrange.T - lagrange.V,
                "it is T − V: the sign of the potential energy is wrong",
            ),
        ):
            here, there = (truth.at(values)(whole) for values in ({}, moved))
            change = (first.whole - later.whole) - (here - there)
            if (np.abs(change) <= ALIKE * (first.size + later.size)).all():
                yield Mistake(kind, text, "", 0.5)
        yield from self._find_momentum(first.whole, lagrange)
        yield from self._fit_numbers(root, written)
        for mistake, changed in mutate(root, written, self._units):
            spend()
            try:
                slope = rate(changed, moving)
            except FormulaError:
                continue
            values = FormulaTape(slope).evaluate(truth.sample.letters, truth.sample.count)
            constant = (np.abs(values.whole) <= _CONSERVED * values.size).all()
            # with loops lengths are the same in all states, and a power of one as good as a number
            if constant and values.size.any() and self._has_unit(changed):
                yield mistake

    def _fit_numbers(self, root: Node, written: str) -> Iterator[Mistake]:
        """Yield the numbers in place of which another makes a quantity constant."""
        truth = self._truth
        moving = KnownLetters.of(truth.mechanism).rate_nodes
        for node, put in _list_numbers(root):
            spend()
            try:
                slopes = [rate(put(number(value)), moving) for value in (0, 1)]
            except FormulaError:
                return
            off, one = (
                FormulaTape(slope).evaluate(truth.sample.letters, truth.sample.count).whole
                for slope in slopes
            )
            wanted = off / (off - one)
            if not np.isfinite(wanted).all():
                continue
            right = Fraction(float(wanted.mean())).limit_denominator(SIMPLE)
            alike = (np.abs(wanted - float(right)) <= ALIKE * np.abs(wanted)).all()
            part = node.quote(written)
            if right and alike and part:
                yield Mistake("factor", f"the number '{part}' should be {right}", part, 1.45)

    def _has_unit(self, formula: Node) -> bool:
        """Whether the units of all terms match."""
        try:
            self._letter_units.find(formula, "")
        except UnitMisfitError:
            return False
        return True

    def _find_momentum(self, given: Array, lagrange: Lagrange) -> Iterator[Mistake]:
        """Yield that a quantity is a momentum, or a multiple of it, if it is."""
        for velocity in self._truth.velocities:
            ratio = given / self._truth.at({})(lagrange.T.diff(velocity))
            if np.isfinite(ratio).all() and np.ptp(ratio) <= ALIKE * np.abs(ratio).max():
                name = velocity.removesuffix("'")
                text = (
                    f"it is the momentum of {name}: only momenta of coordinates that L does not "
                    "depend on are conserved"
                )
                yield Mistake("momentum", text, "", 1.2)


def _key(hypothesis: WrongDerivation) -> tuple[str, str, int, Series | None]:
    """Return by what a hypothesis is known in all positions."""
    return hypothesis.kind, hypothesis.text, hypothesis.row, hypothesis.term


def is_repeated(root: Node, quantity: AskedQuantity) -> bool:
    """Whether a formula is an equation for a quantity, which occurs in it more than once."""
    return sum(node.name in quantity.letters for node in root.walk()) > 1


def _oscillate(sides: Sequence[EquationValues]) -> Array:
    """Return the frequencies (nv, n) between positions below and above along each coordinate."""
    steps = zip(sides[::2], sides[1::2], strict=True)
    K = np.stack([(above.rest - below.rest) / (2 * _STEP) for below, above in steps], axis=-1)
    M = sides[0].M
    squares = np.full(K.shape[:2], np.nan)
    at = np.flatnonzero(np.isfinite(K).all((1, 2)) & (np.abs(np.linalg.det(M)) > 0))
    squares[at] = np.sort(np.linalg.eigvals(np.linalg.solve(M[at], K[at])).real, axis=1)
    return np.asarray(np.sqrt(squares).T)


def _turn_letters(
    names: Sequence[str], turned: float, values: Mapping[str, Array]
) -> dict[str, Array]:
    return {name: values[name] + turned for name in names}


def _compare_claims(residual: Residual, claims: Claims) -> Array:
    """Return by how much a formula is off where letters have these values, or its changes are."""
    whole = [residual.evaluate(claim).whole for claim in claims]
    return np.concatenate([a - b for a, b in pairwise(whole)] or whole)


def _holds(residual: Residual, claims: Claims) -> bool:
    """Whether a formula holds where letters have these values; of several, up to a constant."""
    tables = list(map(residual.evaluate, claims))
    relative = [
        np.abs(first.whole - second.whole) / np.maximum(first.size, second.size)
        for first, second in pairwise(tables)
    ]
    compared = [values[np.isfinite(values)] for values in relative or [tables[0].relative]]
    return len(compared[0]) > 0 and all((values <= ALIKE).all() for values in compared)


def _holds_in_turn(residual: Residual, claims: Claims) -> bool:
    """Whether a formula holds in each state for one of several values, sorted by size."""
    off = np.fmin.reduce([residual.evaluate(claim).relative for claim in claims])
    off = off[np.isfinite(off)]
    return len(off) > 0 and bool((off <= ALIKE).all())


def _is_rounded(residual: Residual, claim: Mapping[str, Array]) -> bool:
    """Whether a formula holds up to the digits of a number where letters have these values."""
    claimed = replace(residual, sample=replace(residual.sample, values=claim))
    return bool(find_rounding(claimed.tape, claimed.values, residual.statement.text))


_FACTORS_OF_UNITS = {
    "it is in degrees, not in radians": 180 / np.pi,
    "the unit is not that of the number: a factor 1000": 1000.0,
    "the unit is not that of the number: a factor 60": 60.0,
}
"""What a number may be wrong by that belongs to another unit."""


def _other_measures(
    omega: Array, letters: Sequence[str]
) -> Iterator[tuple[float, str, dict[str, Array]]]:
    right = measure(omega, letters)
    text = "a factor 2 pi is missing or surplus: omega = 2 pi f = 2 pi/T"
    for scale in (2 * np.pi, 1 / (2 * np.pi)):
        yield 0.7, text, {name: value * scale for name, value in right.items()}
    for what, factor in _FACTORS_OF_UNITS.items():
        for scale in (factor, 1 / factor):
            yield 1.2, what, {name: value * scale for name, value in right.items()}
    square = measure(omega**2, letters)
    yield 0.7, "the square root is missing: it is omega^2", square
    turned = {name: 2 * np.pi / value for name, value in right.items()}
    yield 0.7, "a period is taken for a frequency, or the reverse: T = 2 pi/omega", turned
    for inverse in (
        {name: 1 / value for name, value in right.items()},
        measure(1 / omega, letters),
    ):
        yield 0.8, "it is inverted", inverse


def _list_numbers(node: Node) -> Iterator[tuple[Node, Callable[[Node], Node]]]:
    """Yield the numbers that multiply in a formula, each with what puts another in its place."""
    if node.kind == "number" or (node.kind == "quotient" and not node.letters):
        yield node, lambda other: other
        return
    for k, child in enumerate(node.parts):
        if node.kind in ("sum", "negative", "product") or (node.kind == "quotient" and not k):
            for inner, put in _list_numbers(child):
                yield inner, partial(_put_part, node, k, put)


def _put_part(node: Node, k: int, put: Callable[[Node], Node], other: Node) -> Node:
    return replace(node, parts=(*node.parts[:k], put(other), *node.parts[k + 1 :]))


def mutate(
    root: Node, text: str, units: Mapping[str, str], *, is_term: bool = False
) -> Iterator[tuple[Mistake, Node]]:
    """Yield each single change within a formula, and each at all its places, with the result."""
    if {"sin", "cos"} <= {node.name for node in root.walk()}:
        said = "sin and cos are exchanged"
        yield Mistake("sin for cos", said, root.quote(text), 1.2), _exchange_waves(root)
    times = Counter[Mistake]()
    for mistake, changed in _mutate(root, text, units, is_term=is_term):
        times[mistake] += 1
        yield mistake, changed
    for mistake, count in times.items():
        if count > 1:
            said = f"{mistake.text}, {count} times"
            changed = _change_throughout(root, text, units, mistake)
            yield replace(mistake, text=said, weight=mistake.weight + 0.2), changed


def _exchange_waves(node: Node) -> Node:
    name = {"sin": "cos", "cos": "sin"}.get(node.name, node.name)
    return replace(node, name=name, parts=tuple(map(_exchange_waves, node.parts)))


def _change_throughout(
    node: Node, text: str, units: Mapping[str, str], mistake: Mistake, *, is_term: bool = False
) -> Node:
    """Return a formula with a change made wherever it can be."""
    part = node.quote(text)
    if part == mistake.part:
        for _, kind, said, changed in _change(node, part, text, units, is_term=is_term):
            if (kind, said) == (mistake.kind, mistake.text):
                return changed
    within = node.kind in ("sum", "negative")
    parts = (
        _change_throughout(child, text, units, mistake, is_term=within) for child in node.parts
    )
    return replace(node, parts=tuple(parts))


def _mutate(
    node: Node, text: str, units: Mapping[str, str], *, is_term: bool
) -> Iterator[tuple[Mistake, Node]]:
    part = node.quote(text)
    for weight, kind, said, changed in _change(node, part, text, units, is_term=is_term):
        yield Mistake(kind, said, part, weight), changed
    within = node.kind in ("sum", "negative")
    for k, child in enumerate(node.parts):
        for mistake, changed in _mutate(child, text, units, is_term=within):
            parts = (*node.parts[:k], changed, *node.parts[k + 1 :])
            yield mistake, replace(node, parts=parts)


def _change(
    node: Node, part: str, text: str, units: Mapping[str, str], *, is_term: bool
) -> Iterator[tuple[float, str, str, Node]]:
    """Yield the changes of a part itself: weight, kind, words and the changed part."""
    squared = raise_to(node, number(2))
    if node.kind == "call" and node.name in ("sin", "cos"):
        swapped = "cos" if node.name == "sin" else "sin"
        yield 1.0, "sin for cos", f"'{part}' should be {swapped}", call(swapped, *node.parts)
        yield 1.1, "power", f"'{part}' should be squared: '{part}^2'", squared
        yield 1.5, "factor surplus", f"the factor '{part}' does not belong there", number(1)
    if node.kind == "call" and node.name in ("acos", "asin", "atan"):
        inverse = divide(number(1), node.parts[0])
        yield 0.8, "measure", f"the argument of '{part}' is inverted", call(node.name, inverse)
    if node.kind == "letter" and part:
        yield 1.2, "power", f"'{part}' should be {part}^2", squared
        said = f"'{part}' belongs on the other side of the fraction bar"
        yield 1.35, "inverted", said, divide(number(1), node)
    if node.kind == "quotient":
        yield 1.0, "inverted", f"'{part}' is inverted", divide(*reversed(node.parts))
    if node.kind == "power":
        base = node.parts[0]
        yield 1.3, "power", f"'{part}' should be {base.quote(text)}", base
    named = [letter for letter in units if letter in node.letters]
    for first, second in combinations(named, 2) if node.kind == "sum" else ():
        if units[first] == units[second]:
            said = f"{first} and {second} are exchanged in '{part}'"
            yield 1.3, "letter", said, rename(node, {first: second, second: first})
    for other in units if node.name in units else ():
        if units[other] == units[node.name] and other != node.name:
            yield 1.3, "letter", f"{part} should be {other}", replace(node, name=other)
    if is_term:
        yield 1.5, "extra", f"the term '{part}' does not belong there", multiply(number(0), node)
        yield 0.9, "sign", f"the sign of the term '{part}' is wrong", negate(node)
        twice, half = multiply(number(2), node), divide(node, number(2))
        yield 1.4, "factor", f"the term '{part}' is half of what it should be", twice
        yield 1.4, "factor", f"the term '{part}' is twice what it should be", half
