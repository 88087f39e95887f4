"""Mistakes in energies, matrices, frequencies and conserved quantities, by what they lead to."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import pairwise, permutations
from typing import TypeAlias, final

import numpy as np

from mecanique.arrays import Array
from mecanique.checking.budget import spend, stop_clock
from mecanique.checking.grammar.letters import KnownLetters
from mecanique.checking.grammar.tape import FormulaTape
from mecanique.checking.grammar.tree import Node, call, compound, negate, number, raise_to, rate
from mecanique.checking.judgement.motion import Residual
from mecanique.checking.judgement.quantities import AskedQuantity, ask_for, measure, roll
from mecanique.checking.judgement.truth import Truth, stack_mass
from mecanique.checking.mistakes.hypotheses import SLIPS, Hypotheses
from mecanique.checking.verdict import Mistake
from mecanique.derivation.scalars.evaluation import Evaluation
from mecanique.derivation.symbolic.lagrange import Lagrange
from mecanique.errors import FormulaError, MecaniqueError
from mecanique.model.mechanism import Mechanism
from mecanique.model.random_positions import angles

_Reading: TypeAlias = Callable[[Mapping[str, Array]], dict[str, Array]]
"""What letters are taken for, by the letters."""

_ALIKE = 1e-6
"""A wrong quantity is the one that was written if they differ by less than this part."""

_STEP = 1e-5
"""A displacement from equilibrium, in radians or meters, at which restoring forces are taken."""

_WEIGHTS = (1.2, 1.05, 1.45, 1.5)
"""Of the slips in a potential, the smaller, the likelier."""

_CONSERVED = 1e-8
"""A rate below this part of its terms is zero."""


@final
class QuantityMistakes:
    """Finds the mistakes that lead to a wrong quantity of one mechanism."""

    def __init__(self, truth: Truth) -> None:
        self._truth = truth
        self._energies: dict[str, list[tuple[Mistake, Array, Array]]] = {}
        self._about: dict[str, Hypotheses] = {}

    def explain(self, residual: Residual, quantity: AskedQuantity) -> Iterator[Mistake]:
        """Yield the mistakes after which a formula would be right."""
        if self._truth.derivation is None:
            return
        name = quantity.name.partition(" of ")[0]
        if name in ("kinetic energy", "momentum", "Lagrangian", "energy"):
            yield from self._explain_motion(residual, quantity, name)
        if name in ("potential energy", "Lagrangian", "energy"):
            yield from self._explain_potential(residual, quantity, name)
        if quantity.kind in ("value", "up to a constant"):
            yield from self._explain_reading(residual, quantity)
        if quantity.kind == "several":
            yield from self._explain_frequency(residual, quantity)

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
                value = Evaluation(series.ring, {**values, **read(values)})(series)
                claims.append((np.broadcast_to(np.asarray(value), (sample.count,)), values))
            if self._holds(residual, quantity, *claims):
                yield Mistake("angle", text, "", weight)

    def _list_readings(self) -> Iterator[tuple[str, float, _Reading, Array]]:
        """Yield what coordinates may be taken for: words, weight, letters, their rates by ours."""
        truth = self._truth
        names = [v.removesuffix("'") for v in truth.velocities if v.endswith("'")]
        for base, other in permutations(names, 2):
            for sign in (-1, 1):
                ways = ("relative to", "absolute") if sign > 0 else ("absolute", "relative to")
                places = [truth.velocities.index(f"{name}'") for name in (other, base)]
                turn = np.eye(len(truth.velocities))
                turn[places[0], places[1]] = sign
                for dots, said in ((("", "'"), ""), (("'",), "the rate of "), (("",), "")):
                    read = partial(_add_letters, other, base, sign, dots)
                    text = f"{said}{other} is taken {ways[0]} instead of {ways[1]}"
                    text = text.replace("relative to", f"relative to {base}")
                    rates = turn if "'" in dots else np.eye(len(turn))
                    yield text, 1.3 + 0.1 * (len(dots) == 1), read, rates
        for name in sorted(angles(truth.mechanism) & set(names)):
            for turned in (-np.pi / 2, np.pi / 2):
                text = f"{name} is counted from a line at right angles to the one in question"
                yield text, 1.6, partial(_turn_letter, name, turned), np.eye(len(truth.velocities))

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
        for hypothesis in self._list("motion").listed:
            scale = np.abs(given) + np.abs(hypothesis.M)
            if (np.abs(given - hypothesis.M) <= _ALIKE * scale).all() and hypothesis.row < 0:
                yield hypothesis.mistake()

    def _list(self, where: str) -> Hypotheses:
        if where not in self._about:
            with stop_clock():
                self._about[where] = Hypotheses(self._truth)
                assert self._about[where].listed is not None
        return self._about[where]

    def _explain_motion(
        self, residual: Residual, quantity: AskedQuantity, name: str
    ) -> Iterator[Mistake]:
        sample = self._truth.sample
        if residual.sample.count != sample.count or quantity.values is None:
            return
        v = np.stack([sample.values[n] for n in self._truth.velocities], axis=-1)
        listed = self._list("motion").listed
        # with all at rest, the potential must be right, and its constant is open
        resting = [] if quantity.again is None else list(self._at_rest(quantity))
        for hypothesis in listed:
            spend()
            change = hypothesis.M - sample.M
            if hypothesis.row >= 0 or not np.abs(change).any():
                continue
            more = np.einsum("ni,nij,nj->n", v, change, v) / 2
            if name == "momentum":
                k = self._truth.velocities.index(quantity.velocity)
                more = np.einsum("nj,nj->n", change[:, k], v)
            if self._holds(residual, quantity, (quantity.values + more, sample.values), *resting):
                yield hypothesis.mistake()

    def _at_rest(self, quantity: AskedQuantity) -> Iterator[tuple[Array, Mapping[str, Array]]]:
        """Yield the quantity where velocities vanish, in the states and in the moved ones."""
        assert quantity.again is not None
        truth, sample = self._truth, self._truth.sample
        series = next(iter(quantity.series.values()))
        still = dict.fromkeys((*truth.velocities, *truth.accelerations), np.zeros(sample.count))
        for moving in (sample.values, quantity.again[1]):
            states = {**moving, **still}
            value = Evaluation(series.ring, states)(series)
            yield np.broadcast_to(np.asarray(value, dtype=float), (sample.count,)), states

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

    def _explain_potential(
        self, residual: Residual, quantity: AskedQuantity, name: str
    ) -> Iterator[Mistake]:
        if quantity.values is None or quantity.again is None:
            return
        sign = -1.0 if name == "Lagrangian" else 1.0
        for mistake, change, there in self._potentials(quantity):
            spend()
            here = quantity.values + sign * change, self._truth.sample.values
            moved = quantity.again[0] + sign * there, quantity.again[1]
            if self._holds(residual, quantity, here, moved):
                yield mistake

    def _potentials(self, quantity: AskedQuantity) -> list[tuple[Mistake, Array, Array]]:
        """Return changes of V with their values in the states and in the moved ones."""
        if "V" not in self._energies:
            with stop_clock():
                self._energies["V"] = list(self._list_potentials())
        return self._energies["V"]

    def _list_potentials(self) -> Iterator[tuple[Mistake, Array, Array]]:
        mechanism, sample = self._truth.mechanism, self._truth.sample
        states = (sample.values, roll(self._truth, sample))
        whole = _potential(mechanism, states, sample.count)
        parts: list[tuple[str, Mechanism, bool]] = []
        none = replace(mechanism, gravity=(0.0, 0.0, 0.0))
        parts.append(("the potential of gravity", none, False))
        for body in mechanism.bodies[1:]:
            gone = body.replace(mass=0.0, inertia=(0.0,) * 6)
            bodies = tuple(
                gone if present.name == body.name else present for present in mechanism.bodies
            )
            light = replace(mechanism, bodies=bodies)
            parts.append((f"the weight of {body.name!r}", light, True))
        for force in mechanism.forces:
            forces = tuple(present for present in mechanism.forces if present is not force)
            less = replace(mechanism, forces=forces)
            parts.append((f"the energy of {force.name!r}", less, False))
        for said, less, weighs in parts:
            try:
                rest = _potential(less, states, sample.count)
            except MecaniqueError:
                continue
            here, there = (full - left for full, left in zip(whole, rest, strict=True))
            if not np.abs(here).any():
                continue
            for (factor, kind, words), weight in zip(SLIPS, _WEIGHTS, strict=True):
                kind = "potential sign" if kind == "sign" else kind
                text = words.format(said)
                if weighs and factor == 2.0:
                    text += ", or acts at the end instead of the center"
                mistake = Mistake(kind, text, "", weight)
                yield mistake, (factor - 1) * here, (factor - 1) * there

    def _explain_frequency(self, residual: Residual, quantity: AskedQuantity) -> Iterator[Mistake]:
        assert quantity.values is not None
        for omega in quantity.values:
            for weight, text, values in _other_measures(omega, quantity.letters):
                if self._fits(residual, values):
                    yield Mistake("measure", text, "", weight)
        if quantity.name == "damped frequency":
            undamped = ask_for(self._truth, "undamped frequency").values
            assert undamped is not None
            if any(self._fits(residual, measure(omega, quantity.letters)) for omega in undamped):
                text = "the damping is missing: it is the undamped frequency"
                yield Mistake("missing", text, "", 0.7)
        if len(quantity.values) > 1 or "'" not in self._truth.velocities[0]:
            return
        for mistake, omega in self._frequencies():
            spend()
            if self._fits(residual, measure(omega, quantity.letters)):
                yield mistake

    def _frequencies(self) -> list[tuple[Mistake, Array]]:
        """Return the frequencies about zero that mistakes lead to, of one degree of freedom."""
        truth = self._truth
        name = truth.mechanism.coordinates.names[0]
        still = truth.rest({name: np.full(truth.sample.count, _STEP)})
        if still is None:
            return []
        with stop_clock():
            listed = Hypotheses(still).listed
        frequencies = []
        for hypothesis in listed:
            if hypothesis.kind in ("linearized", "angle"):
                continue
            omega = np.sqrt(hypothesis.rest[:, 0] / (_STEP * hypothesis.M[:, 0, 0]))
            frequencies.append((hypothesis.mistake(), omega))
        return frequencies

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
            np.asarray(Evaluation(energy.ring, values)(energy), dtype=float)
            for values in (truth.sample.values, moved)
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
        for weight, kind, said, part, changed in _mutate(root, written):
            spend()
            try:
                slope = rate(changed, moving)
            except FormulaError:
                continue
            values = FormulaTape(slope).evaluate(truth.sample.letters, truth.sample.count)
            constant = (np.abs(values.whole) <= _CONSERVED * values.size).all()
            if constant and values.size.any():
                yield Mistake(kind, said, part, weight)


def _add_letters(
    name: str, base: str, sign: int, dots: Sequence[str], values: Mapping[str, Array]
) -> dict[str, Array]:
    """Return a coordinate and its rate, as dots say, with those of another added."""
    return {f"{name}{d}": values[f"{name}{d}"] + sign * values[f"{base}{d}"] for d in dots}


def _turn_letter(name: str, turned: float, values: Mapping[str, Array]) -> dict[str, Array]:
    return {name: values[name] + turned}


def _vanishes(relative: Array) -> bool:
    known = np.isfinite(relative)
    return bool(known.any() and (relative[known] <= _ALIKE).all())


def _potential(
    mechanism: Mechanism, states: Sequence[Mapping[str, Array]], count: int
) -> list[Array]:
    V = Lagrange(mechanism).V
    return [
        np.broadcast_to(np.asarray(Evaluation(V.ring, values)(V), dtype=float), (count,))
        for values in states
    ]


def _other_measures(
    omega: Array, letters: Sequence[str]
) -> Iterator[tuple[float, str, dict[str, Array]]]:
    right = measure(omega, letters)
    text = "a factor 2 pi is missing or surplus: omega = 2 pi f = 2 pi/T"
    for scale in (2 * np.pi, 1 / (2 * np.pi)):
        yield 0.7, text, {name: value * scale for name, value in right.items()}
    square = measure(omega**2, letters)
    yield 0.7, "the square root is missing: it is omega^2", square
    yield 0.8, "it is inverted", {name: 1 / value for name, value in right.items()}


def _mutate(root: Node, text: str) -> Iterator[tuple[float, str, str, str, Node]]:
    """Yield the formula with a single part changed: weight, kind, words, part, formula."""
    for path, node in _paths(root, ()):
        part = " ".join(text[node.start : node.end].split())
        parent = _at(root, path[:-1]) if path else None
        is_term = parent is not None and parent.kind in ("sum", "negative")
        changes: list[tuple[float, str, str, Node]] = []
        if node.kind == "call" and node.name in ("sin", "cos"):
            swapped = "cos" if node.name == "sin" else "sin"
            changes.append(
                (1.0, "sin for cos", f"'{part}' should be {swapped}", call(swapped, *node.parts))
            )
            changes.append(
                (1.1, "power", f"'{part}' should be squared: '{part}^2'", raise_to(node, number(2)))
            )
        if node.kind == "letter" and part:
            changes.append(
                (1.2, "power", f"'{part}' should be {part}^2", raise_to(node, number(2)))
            )
        if node.kind == "power":
            base = " ".join(text[node.parts[0].start : node.parts[0].end].split())
            changes.append((1.3, "power", f"'{part}' should be {base}", node.parts[0]))
        if is_term:
            changes.append((0.9, "sign", f"the sign of the term '{part}' is wrong", negate(node)))
            twice = compound("product", number(2), node)
            half = compound("quotient", node, number(2))
            changes.append(
                (1.4, "factor", f"the term '{part}' is half of what it should be", twice)
            )
            changes.append((1.4, "factor", f"the term '{part}' is twice what it should be", half))
        for weight, kind, said, changed in changes:
            yield weight, kind, said, part, _put(root, path, changed)


def _paths(node: Node, path: tuple[int, ...]) -> Iterator[tuple[tuple[int, ...], Node]]:
    yield path, node
    for k, part in enumerate(node.parts):
        yield from _paths(part, (*path, k))


def _at(root: Node, path: Sequence[int]) -> Node:
    for k in path:
        root = root.parts[k]
    return root


def _put(root: Node, path: Sequence[int], changed: Node) -> Node:
    if not path:
        return changed
    k = path[0]
    parts = (*root.parts[:k], _put(root.parts[k], path[1:], changed), *root.parts[k + 1 :])
    return replace(root, parts=parts)
