"""Mistakes in energies, matrices, frequencies and conserved quantities, by what they lead to."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import pairwise
from typing import final

import numpy as np

from mecanique.arrays import Array
from mecanique.checking.budget import spend
from mecanique.checking.grammar.letters import KnownLetters
from mecanique.checking.grammar.tape import FormulaTape
from mecanique.checking.grammar.tree import (
    Node,
    call,
    divide,
    multiply,
    negate,
    number,
    raise_to,
    rate,
)
from mecanique.checking.judgement.motion import Residual
from mecanique.checking.judgement.quantities import AskedQuantity, measure, roll
from mecanique.checking.judgement.truth import Truth, stack_mass, value_of
from mecanique.checking.mistakes.hypotheses import Hypotheses, Reading, Terms, list_relative
from mecanique.checking.verdict import Mistake
from mecanique.derivation.scalars.evaluation import Evaluation
from mecanique.derivation.symbolic.lagrange import Lagrange
from mecanique.errors import FormulaError
from mecanique.model.random_positions import angles

_ALIKE = 1e-6
"""A wrong quantity is the one that was written if they differ by less than this part."""

_STEP = 1e-5
"""A displacement from equilibrium, in radians or meters, at which restoring forces are taken."""

_OF_ENERGIES = {
    "kinetic energy": (1.0, 0.0),
    "potential energy": (0.0, 1.0),
    "momentum": (0.0, 0.0),
    "Lagrangian": (1.0, -1.0),
    "energy": (1.0, 1.0),
}
"""How much of T and of V is in a quantity that hypotheses about the motion explain."""

_CONSERVED = 1e-8
"""A rate below this part of its terms is zero."""


@final
class QuantityMistakes:
    """Finds the mistakes that lead to a wrong quantity of one mechanism."""

    def __init__(self, truth: Truth, hypotheses: Hypotheses) -> None:
        self._truth = truth
        self._hypotheses = hypotheses

    def explain(self, residual: Residual, quantity: AskedQuantity) -> Iterator[Mistake]:
        """Yield the mistakes after which a formula would be right."""
        if self._truth.derivation is None:
            return
        name = quantity.name.partition(" of ")[0]
        if name in _OF_ENERGIES:
            yield from self._explain_energy(residual, quantity, *_OF_ENERGIES[name])
        if quantity.kind in ("value", "up to a constant"):
            yield from self._explain_reading(residual, quantity)
            for kind, text, values in quantity.slips:
                if self._holds(residual, quantity, (values, self._truth.sample.values)):
                    yield Mistake(kind, text, "", 0.7)
        if quantity.kind == "several":
            yield from self._explain_frequency(residual, quantity)

    def mutate(
        self, residual: Residual, quantity: AskedQuantity, written: str
    ) -> Iterator[Mistake]:
        """Yield the single changes after which a formula would be right, wherever they stand."""
        if quantity.kind not in ("value", "up to a constant") or quantity.values is None:
            return
        claims = [(quantity.values, self._truth.sample.values)]
        if quantity.again is not None:
            claims.append((quantity.again[0], {**claims[0][1], **quantity.again[1]}))
        for mistake, changed in _mutate(residual.root, written):
            spend()
            if self._holds(replace(residual, tape=FormulaTape(changed)), quantity, *claims):
                yield mistake

    def _explain_reading(self, residual: Residual, quantity: AskedQuantity) -> Iterator[Mistake]:
        """Yield relative for absolute coordinates, and angles from a line at right angles."""
        series, sample = next(iter(quantity.series.values()), None), self._truth.sample
        if series is None or residual.sample.count != sample.count:
            return
        states = [sample.values]
        if quantity.again is not None:
            states.append({**sample.values, **quantity.again[1]})
        for text, weight, read, _ in self._list_readings():
            spend()
            claims = []
            for values in states:
                taken = value_of(series, {**values, **read(values)}, sample.count)
                claims.append((taken, values))
            if self._holds(residual, quantity, *claims):
                yield Mistake("angle", text, "", weight)

    def _list_readings(self) -> Iterator[tuple[str, float, Reading, Array]]:
        """Yield what coordinates may be taken for: words, weight, letters, their rates by ours."""
        truth = self._truth
        for text, read, rates, dots in list_relative(truth):
            yield text, 1.3 + 0.1 * (len(dots) == 1), read, rates
        names = {v.removesuffix("'") for v in truth.velocities if v.endswith("'")}
        turning = sorted(angles(truth.mechanism) & names)
        for some in [(name,) for name in turning] + [tuple(turning)] * (len(turning) > 1):
            said = "every angle" if some[1:] else some[0]
            text = f"{said} is counted from a line at right angles to the one in question"
            for turned in (-np.pi / 2, np.pi / 2):
                yield text, 1.6, partial(_turn_letters, some, turned), np.eye(len(truth.velocities))

    def explain_matrix(self, given: Array) -> Iterator[Mistake]:
        """Yield the mistakes that lead to a mass matrix, shape (n, nv, nv)."""
        sample, derivation = self._truth.sample, self._truth.closed_form
        for text, weight, read, turn in self._list_readings():
            spend()
            values = {**sample.values, **read(sample.values)}
            evaluated = Evaluation(derivation.algebra.ring, values)
            M = turn.T @ stack_mass(derivation, evaluated, sample.count) @ turn
            if (np.abs(given - M) <= _ALIKE * (np.abs(given) + np.abs(M))).all():
                yield Mistake("angle", text, "", weight)
        for hypothesis in self._hypotheses.listed:
            M = hypothesis.terms.M
            alike = (np.abs(given - M) <= _ALIKE * (np.abs(given) + np.abs(M))).all()
            if alike and hypothesis.row < 0:
                yield hypothesis.mistake()

    def _explain_energy(
        self, residual: Residual, quantity: AskedQuantity, kinetic: float, potential: float
    ) -> Iterator[Mistake]:
        """Yield the hypotheses whose T and V, by these factors, make up what was written."""
        truth, sample = self._truth, self._truth.sample
        if residual.sample.count != sample.count or quantity.values is None:
            return
        v = np.stack([sample.values[n] for n in truth.velocities], axis=-1)
        # with all at rest, the potential must be right, and its constant is open
        resting = [] if quantity.again is None else list(self._at_rest(quantity))
        for hypothesis in self._hypotheses.listed:
            spend()
            dM, dV = (
                hypothesis.terms.M - sample.M,
                hypothesis.terms.V - self._hypotheses.right.terms.V,
            )
            if hypothesis.row >= 0 or not (np.abs(dM).any() or np.abs(dV).any()):
                continue
            more = kinetic * np.einsum("ni,nij,nj->n", v, dM, v) / 2 + potential * dV[0]
            if quantity.velocity:
                k = truth.velocities.index(quantity.velocity)
                more = np.einsum("nj,nj->n", dM[:, k], v)
            claims = [(quantity.values + more, sample.values)]
            for (values, states), change in zip(resting, dV, strict=False):
                claims.append((values + potential * change, states))
            if self._holds(residual, quantity, *claims):
                yield hypothesis.mistake()

    def _at_rest(self, quantity: AskedQuantity) -> Iterator[tuple[Array, Mapping[str, Array]]]:
        """Yield the quantity where velocities vanish, in the states and in the moved ones."""
        assert quantity.again is not None
        truth, sample = self._truth, self._truth.sample
        series = next(iter(quantity.series.values()))
        still = dict.fromkeys((*truth.velocities, *truth.accelerations), np.zeros(sample.count))
        for moving in (sample.values, quantity.again[1]):
            states = {**moving, **still}
            yield value_of(series, states, sample.count), states

    def _holds(
        self,
        residual: Residual,
        quantity: AskedQuantity,
        *claims: tuple[Array, Mapping[str, Array]],
    ) -> bool:
        """Whether a formula gives these values in these states; of several, up to a constant."""
        tables = []
        for values, states in claims:
            # the letters of the mechanism keep their meaning
            letters = {
                **residual.sample.values,
                **dict.fromkeys(quantity.letters, values),
                **states,
            }
            if not residual.statement.is_equation:
                letters[quantity.letters[0]] = values
            tables.append(residual.tape.evaluate(letters, residual.sample.count))
        relative = [
            np.abs(first.whole - second.whole) / np.maximum(first.size, second.size)
            for first, second in pairwise(tables)
        ]
        first, *others = relative or [tables[0].relative]
        return _vanishes(first) and all(
            (second[np.isfinite(second)] <= _ALIKE).all() for second in others
        )

    def _explain_frequency(self, residual: Residual, quantity: AskedQuantity) -> Iterator[Mistake]:
        assert quantity.values is not None
        for omega in quantity.values:
            for weight, text, values in _other_measures(omega, quantity.letters):
                if self._fits(residual, values):
                    yield Mistake("measure", text, "", weight)
        for kind, text, several in quantity.slips:
            if any(self._fits(residual, measure(omega, quantity.letters)) for omega in several):
                yield Mistake(kind, text, "", 0.7)
        if len(quantity.values) > 1 or "'" not in self._truth.velocities[0]:
            return
        for mistake, omega in self._frequencies(quantity.position):
            spend()
            if self._fits(residual, measure(omega, quantity.letters)):
                yield mistake

    def _frequencies(self, position: Mapping[str, Array]) -> Iterator[tuple[Mistake, Array]]:
        """Yield the frequencies that mistakes lead to, of one degree of freedom."""
        truth = self._truth
        name = truth.mechanism.coordinates.names[0]
        middle = position.get(name, np.zeros(truth.sample.count))
        sides = [truth.rest({name: middle + step}) for step in (-_STEP, _STEP)]
        if sides[0] is None or sides[1] is None:
            return
        below, above = (Hypotheses(still) for still in sides if still is not None)
        right = _oscillate(below.right.terms, above.right.terms)
        others = {(hypothesis.kind, hypothesis.text): hypothesis for hypothesis in below.listed}
        for hypothesis in above.listed:
            other = others.get((hypothesis.kind, hypothesis.text))
            if other is None or hypothesis.kind in ("linearized", "angle"):
                continue
            omega = _oscillate(other.terms, hypothesis.terms)
            if not np.allclose(omega, right, rtol=_ALIKE, atol=0.0):
                yield hypothesis.mistake(), omega

    def _fits(self, residual: Residual, values: Mapping[str, Array]) -> bool:
        if any(value.shape != (residual.sample.count,) for value in values.values()):
            return False
        letters = {**residual.sample.values, **values}
        whole = residual.tape.evaluate(letters, residual.sample.count)
        return _vanishes(whole.relative)

    def explain_constant(self, root: Node, written: str) -> Iterator[Mistake]:
        """Yield mistakes in a conserved quantity: forces, and single changes that mend it."""
        truth = self._truth
        moving = KnownLetters.of(truth.mechanism).rate_nodes
        moved = roll(truth, truth.sample)
        derivation = truth.closed_form
        lagrange = Lagrange(truth.mechanism, derivation.algebra)
        energy = lagrange.T + lagrange.V
        here, there = (
            value_of(energy, values, truth.sample.count) for values in (truth.sample.values, moved)
        )
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
        change = (first.whole - later.whole) - (here - there)
        if (np.abs(change) <= _ALIKE * (first.size + later.size)).all():
            text = (
                "it is T + V, which a prescribed motion or a force changes; Jacobi's integral is "
                "T2 − T0 + V, with the terms of T by their degree in the velocities"
            )
            yield Mistake("Jacobi", text, "", 0.5)
        for mistake, changed in _mutate(root, written):
            spend()
            try:
                slope = rate(changed, moving)
            except FormulaError:
                continue
            values = FormulaTape(slope).evaluate(truth.sample.letters, truth.sample.count)
            constant = (np.abs(values.whole) <= _CONSERVED * values.size).all()
            if constant and values.size.any():
                yield mistake


def _oscillate(below: Terms, above: Terms) -> Array:
    """Return the frequency about the middle of two positions near each other."""
    rise = above.rest[:, 0] - below.rest[:, 0]
    return np.sqrt(rise / (2 * _STEP * above.M[:, 0, 0]))


def _turn_letters(
    names: Sequence[str], turned: float, values: Mapping[str, Array]
) -> dict[str, Array]:
    return {name: values[name] + turned for name in names}


def _vanishes(relative: Array) -> bool:
    known = np.isfinite(relative)
    return bool(known.any() and (relative[known] <= _ALIKE).all())


def _other_measures(
    omega: Array, letters: Sequence[str]
) -> Iterator[tuple[float, str, dict[str, Array]]]:
    right = measure(omega, letters)
    text = "a factor 2 pi is missing or surplus: omega = 2 pi f = 2 pi/T"
    for scale in (2 * np.pi, 1 / (2 * np.pi)):
        yield 0.7, text, {name: value * scale for name, value in right.items()}
    square = measure(omega**2, letters)
    yield 0.7, "the square root is missing: it is omega^2", square
    for inverse in (
        {name: 1 / value for name, value in right.items()},
        measure(1 / omega, letters),
    ):
        yield 0.8, "it is inverted", inverse


def _mutate(node: Node, text: str, *, is_term: bool = False) -> Iterator[tuple[Mistake, Node]]:
    """Yield each single change within a formula, with the changed formula."""
    part = " ".join(text[node.start : node.end].split())
    for weight, kind, said, changed in _change(node, part, text, is_term=is_term):
        yield Mistake(kind, said, part, weight), changed
    within = node.kind in ("sum", "negative")
    for k, child in enumerate(node.parts):
        for mistake, changed in _mutate(child, text, is_term=within):
            parts = (*node.parts[:k], changed, *node.parts[k + 1 :])
            yield mistake, replace(node, parts=parts)


def _change(
    node: Node, part: str, text: str, *, is_term: bool
) -> Iterator[tuple[float, str, str, Node]]:
    """Yield the changes of a part itself: weight, kind, words and the changed part."""
    squared = raise_to(node, number(2))
    if node.kind == "call" and node.name in ("sin", "cos"):
        swapped = "cos" if node.name == "sin" else "sin"
        yield 1.0, "sin for cos", f"'{part}' should be {swapped}", call(swapped, *node.parts)
        yield 1.1, "power", f"'{part}' should be squared: '{part}^2'", squared
    if node.kind == "letter" and part:
        yield 1.2, "power", f"'{part}' should be {part}^2", squared
    if node.kind == "power":
        base = " ".join(text[node.parts[0].start : node.parts[0].end].split())
        yield 1.3, "power", f"'{part}' should be {base}", node.parts[0]
    if is_term:
        yield 0.9, "sign", f"the sign of the term '{part}' is wrong", negate(node)
        twice, half = multiply(number(2), node), divide(node, number(2))
        yield 1.4, "factor", f"the term '{part}' is half of what it should be", twice
        yield 1.4, "factor", f"the term '{part}' is twice what it should be", half
