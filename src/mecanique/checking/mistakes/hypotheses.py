"""Wrong equations of motion that a known mistake would give, and where they lead.

Each hypothesis changes the true equations, and is told by the accelerations that follow from them:
an answer that made the mistake holds at these, however it is multiplied, combined or solved.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from functools import cached_property
from itertools import permutations
from typing import Any, final

import numpy as np

from mecanique.arrays import Array
from mecanique.checking.judgement.truth import Sample, Truth
from mecanique.derivation import derive
from mecanique.derivation.printing.equations import expression
from mecanique.derivation.scalars.evaluation import Evaluation
from mecanique.derivation.scalars.monomials import exponents
from mecanique.derivation.scalars.ring import Ring
from mecanique.derivation.scalars.series import Series
from mecanique.derivation.symbolic.derivation import Derivation
from mecanique.errors import MecaniqueError
from mecanique.model.bodies import Body
from mecanique.model.expression import plain
from mecanique.model.forces import AnyForce, JointSpring, Spring
from mecanique.model.joints import Single
from mecanique.model.mechanism import Mechanism

__all__ = ["Hypotheses", "Hypothesis"]

_MOST_TERMS = 12
"""A longer entry of the equations is taken as a whole, not term by term."""

_SINGULAR = 1e-12


@final
@dataclass(frozen=True, eq=False)
class Hypothesis:
    """A mistake in the whole derivation or in one term, with the equations it gives.

    Args:
        kind: of the mistake.
        text: what is wrong, in words; "{}" stands for the term.
        weight: the smaller, the likelier.
        M: mass matrix, shape (n, nv, nv).
        rest: bias minus forces, shape (n, nv).
        row: which equation is changed; −1 for all.
        term: the term that is changed, if it is one.
    """

    kind: str
    text: str
    weight: float
    M: Array
    rest: Array
    row: int = -1
    term: Series | None = None

    @property
    def sentence(self) -> str:
        """What is wrong, in words."""
        return self.text.format("" if self.term is None else expression(self.term).text())


@final
class Hypotheses:
    """All hypotheses about a mechanism, with the accelerations each leads to.

    Args:
        truth: the right equations.
        sample: the states.
    """

    def __init__(self, truth: Truth, sample: Sample) -> None:
        self._truth = truth
        self._sample = sample
        self._rest = sample.bias - sample.forces

    @cached_property
    def listed(self) -> tuple[Hypothesis, ...]:
        """Every hypothesis whose equations determine the motion and differ from the right ones."""
        if self._truth.derivation is None or self._truth.mechanism.constrained:
            return ()
        found = [
            *self._terms(),
            *self._letters_of_terms(),
            *self._operators(),
            *self._readings(),
            *self._parts(),
        ]
        found += self._linear()
        return tuple(one for one in found if self._differs(one))

    @cached_property
    def accelerations(self) -> Array:
        """The accelerations each hypothesis leads to, shape (hypotheses, n, nv)."""
        if not self.listed:
            return np.zeros((0, *self._sample.a.shape))
        M = np.stack([one.M for one in self.listed])
        rest = np.stack([one.rest for one in self.listed])
        return np.asarray(np.linalg.solve(M, -rest[..., None])[..., 0])

    def _differs(self, one: Hypothesis) -> bool:
        scale = np.abs(self._sample.M).max((1, 2)) ** self._sample.M.shape[-1]
        if not (np.isfinite(one.M).all() and np.isfinite(one.rest).all()):
            return False
        if (np.abs(np.linalg.det(one.M)) <= _SINGULAR * scale).any():
            return False
        a = np.linalg.solve(one.M, -one.rest[..., None])[..., 0]
        return bool((np.abs(a - self._sample.a) > 1e-7 * np.abs(self._sample.a)).any())

    @property
    def _derivation(self) -> Derivation:
        derivation = self._truth.derivation
        assert derivation is not None
        return derivation

    @cached_property
    def _evaluated(self) -> Evaluation:
        return Evaluation(self._derivation.algebra.ring, self._sample.values)

    def _value(self, series: Series) -> Array:
        return np.broadcast_to(self._evaluated(series), (self._sample.count,))

    def _change(
        self,
        kind: str,
        text: str,
        weight: float,
        row: int,
        term: Series,
        column: int,
        factor: float | Array,
    ) -> Hypothesis:
        """Return the equations with a term of one row multiplied by a factor."""
        M, rest = self._sample.M, self._rest
        change = (factor - 1) * self._value(term)
        if column >= 0:
            M = M.copy()
            M[:, row, column] += change
        else:
            rest = rest.copy()
            rest[:, row] += change
        shown = term
        if column >= 0:
            ring = self._derivation.algebra.ring
            shown = term * ring[self._truth.accelerations[column]]
        return Hypothesis(kind, text, weight, M, rest, row, shown)

    def _terms(self) -> Iterator[Hypothesis]:
        """Terms left out, of the other sign, doubled or halved."""
        for row, term, column, name, weight in self._list_terms():
            missing = f"{name} {{}} is missing" if name else "the term {} is missing"
            yield self._change("missing", missing, weight, row, term, column, 0.0)
            sign = "the sign of the term {} is wrong"
            yield self._change("sign", sign, weight, row, term, column, -1.0)
            twice = "the term {} is taken twice"
            yield self._change("factor", twice, weight + 0.5, row, term, column, 2.0)
            half = "the term {} is taken half"
            yield self._change("factor", half, weight + 0.5, row, term, column, 0.5)

    def _letters_of_terms(self) -> Iterator[Hypothesis]:
        """Single terms with one letter for another of the same unit."""
        parameters = self._truth.mechanism.parameters
        values = self._sample.values
        for row, whole, column, _, _ in self._list_terms():
            if len(whole) > 1:
                continue
            ((_, monomial, _),) = whole.terms()
            powers = {whole.ring.generators[i].name: e for i, e in exponents(monomial)}
            for one, other in permutations(parameters, 2):
                if one.unit == other.unit and one.symbol in powers:
                    ratio = (values[other.symbol] / values[one.symbol]) ** powers[one.symbol]
                    text = f"in the term {{}} stands {other.symbol} for {one.symbol}"
                    yield self._change("letter", text, 2.1, row, whole, column, ratio)

    def _list_terms(self) -> Iterator[tuple[int, Series, int, str, float]]:
        """Yield row, term, column of M or −1, its name and how likely it is forgotten."""
        derivation = self._derivation
        velocities = derivation.algebra.velocities
        for row, entries in enumerate(derivation.M):
            for column, entry in enumerate(entries):
                if not entry:
                    continue
                own = row == column
                name = "the inertia term" if own else "the coupling term"
                yield row, entry, column, name, 1.6 if own else 1.0
                for part in _split(entry):
                    yield row, part, column, "the inertia term", 2.0
        for row, (h, Q) in enumerate(zip(derivation.h, derivation.Q, strict=True)):
            groups = _groups(h, velocities)
            for powers, group in groups.items():
                name = _name_of(powers)
                yield row, group, -1, name, 1.0
                for part in _split(group):
                    yield row, part, -1, name, 2.0
            for group in _groups(Q, velocities).values():
                yield row, -group, -1, "the force", 1.2
                for part in _split(group):
                    yield row, -part, -1, "the force", 1.5

    def _operators(self) -> Iterator[Hypothesis]:
        """Parts of Lagrange's operator left out: d/dt of the inertia, or ∂T/∂q."""
        derivation = self._derivation
        ring = derivation.algebra.ring
        names = derivation.algebra.velocities
        if any(not name.endswith("'") for name in names):
            return
        v = [ring[name] for name in names]
        M, rest = self._sample.M, self._rest
        rows = []
        for k, entries in enumerate(derivation.M):
            terms = [entry.ddt() * rate for entry, rate in zip(entries, v, strict=True)]
            rows.append((k, ring.sum(terms)))
        changing = np.stack([self._value(series) for _, series in rows], axis=-1)
        squares = self._of_velocities(derivation.h, names)
        slopes = changing - squares
        text = "a rate is treated as constant: d/dt of the momentum lacks {}"
        for k, series in rows:
            if series:
                less = rest.copy()
                less[:, k] -= changing[:, k]
                yield Hypothesis("rate constant", text, 1.4, M, less, k, series)
                less = rest.copy()
                less[:, k] += slopes[:, k]
                what = f"the term −∂T/∂{names[k][:-1]} is missing (centripetal)"
                yield Hypothesis("missing", what, 1.3, M, less, k)
        what = "all terms with squares and products of velocities are missing"
        yield Hypothesis("missing", what, 1.2, M, rest - squares)
        what = "every rate is treated as constant in d/dt of the momenta"
        yield Hypothesis("rate constant", what, 1.3, M, rest - changing)
        what = "the terms −∂T/∂q are missing (centripetal)"
        yield Hypothesis("missing", what, 1.3, M, rest + slopes)

    def _of_velocities(self, h: Sequence[Series], names: Sequence[str]) -> Array:
        """The terms of second degree in the velocities, shape (n, nv)."""
        found = []
        for series in h:
            groups = _groups(series, names)
            squares = [part for powers, part in groups.items() if sum(powers) == 2]
            found.append(self._value(series.ring.sum(squares)))
        return np.stack(found, axis=-1)

    def _readings(self) -> Iterator[Hypothesis]:
        """Letters exchanged throughout: parameters of one unit, relative and absolute angles."""
        mechanism = self._truth.mechanism
        used = {g.name for row in self._derivation.rows for g in row.generators()}
        parameters = [p for p in mechanism.parameters if p.symbol in used]
        for one, other in permutations(parameters, 2):
            if one.unit != other.unit:
                continue
            moved = {one.symbol: self._sample.values[other.symbol]}
            what = f"{other.symbol} stands for {one.symbol} throughout"
            yield self._read("letter", what, 1.5, moved)
            if one.symbol < other.symbol:
                moved |= {other.symbol: self._sample.values[one.symbol]}
                what = f"{one.symbol} and {other.symbol} are exchanged throughout"
                yield self._read("letter", what, 1.5, moved)
        yield from self._other_angles()

    def _read(
        self,
        kind: str,
        what: str,
        weight: float,
        moved: Mapping[str, Any],
        turn: Array | None = None,
    ) -> Hypothesis:
        """Return the equations with other values of letters; `turn` takes our a to theirs."""
        derivation, n = self._derivation, self._sample.count
        evaluated = Evaluation(derivation.algebra.ring, {**self._sample.values, **moved})
        nv = len(derivation.M)
        M = np.empty((n, nv, nv))
        rest = np.empty((n, nv))
        with np.errstate(all="ignore"):
            for i, entries in enumerate(derivation.M):
                for j, entry in enumerate(entries):
                    M[:, i, j] = evaluated(entry)
                rest[:, i] = evaluated(derivation.h[i]) - evaluated(derivation.Q[i])
        if turn is not None:
            M = M @ turn
        return Hypothesis(kind, what, weight, M, rest)

    def _other_angles(self) -> Iterator[Hypothesis]:
        """Angles taken from the vertical instead of the link before, and the other way round."""
        mechanism, values = self._truth.mechanism, self._sample.values
        turning = [
            name for name in mechanism.coordinates if name in self._angles and f"{name}'" in values
        ]
        for one, other in permutations(turning, 2):
            for sign in (-1, 1):
                moved = {
                    name: values[name] + sign * values[name.replace(other, one, 1)]
                    for name in (other, f"{other}'")
                }
                turn = np.eye(mechanism.nv)
                places = mechanism.velocities
                turn[places.index(f"{other}'"), places.index(f"{one}'")] = sign
                what = (
                    f"{other} is taken relative to {one} instead of absolute"
                    if sign > 0
                    else f"{other} is taken absolute instead of relative to {one}"
                )
                yield self._read("angle", what, 1.4, moved, turn)

    @cached_property
    def _angles(self) -> set[str]:
        return {
            joint.coordinate
            for joint in self._truth.mechanism.joints
            if isinstance(joint, Single) and joint.turns
        } | set(self._truth.mechanism.coordinates.names)

    def _parts(self) -> Iterator[Hypothesis]:
        """Inertia, weights and springs of the single bodies and forces taken wrongly."""
        mechanism = self._truth.mechanism
        yield from self._gravity(mechanism)
        for body in mechanism.bodies:
            if plain(body.mass) == 0:
                continue
            yield from self._body(mechanism, body)
        for force in mechanism.forces:
            others = tuple(one for one in mechanism.forces if one is not force)
            less = self._rebuild(replace(mechanism, forces=others))
            if less is not None:
                own_M, own_rest = self._sample.M - less[0], self._rest - less[1]
                for kind, factor, what in (
                    ("missing", 0.0, f"the force {force.name!r} is missing"),
                    ("sign", -1.0, f"the sign of the force {force.name!r} is wrong"),
                    ("factor", 2.0, f"the force {force.name!r} is taken twice"),
                    ("factor", 0.5, f"the force {force.name!r} is taken half (½ too much)"),
                ):
                    M, rest = less[0] + factor * own_M, less[1] + factor * own_rest
                    yield Hypothesis(kind, what, 1.2 + 0.3 * (kind == "factor"), M, rest)
            yield from self._forget_free_length(mechanism, force)

    def _forget_free_length(self, mechanism: Mechanism, force: AnyForce) -> Iterator[Hypothesis]:
        changed: AnyForce
        if isinstance(force, Spring) and force.free_length:
            changed = replace(force, free_length=0.0)
        elif isinstance(force, JointSpring) and force.reference:
            changed = replace(force, reference=0.0)
        else:
            return
        forces = tuple(changed if one is force else one for one in mechanism.forces)
        found = self._rebuild(replace(mechanism, forces=forces))
        if found is not None:
            what = f"the free length of the spring {force.name!r} is forgotten"
            yield Hypothesis("free length", what, 0.8, *found)

    def _gravity(self, mechanism: Mechanism) -> Iterator[Hypothesis]:
        less = self._rebuild(replace(mechanism, gravity=(0.0, 0.0, 0.0)))
        if less is None:
            return
        M, rest = less
        weight = self._rest - rest
        what = "the sign of the potential of gravity is wrong"
        yield Hypothesis("potential sign", what, 0.9, M, rest - weight)
        yield Hypothesis("missing", "gravity is missing", 1.0, M, rest)
        what = "the kinetic energy lacks its factor ½, or the potential one has ½ too much"
        yield Hypothesis("half", what, 1.1, M, rest + weight / 2)
        what = "the kinetic energy has ½ too much, or the potential energy is taken twice"
        yield Hypothesis("half", what, 1.1, M, rest + 2 * weight)

    def _body(self, mechanism: Mechanism, body: Body) -> Iterator[Hypothesis]:
        """Its inertia about the center or the joint, Steiner's term, its weight."""
        bare = body.replace(inertia=(0.0,) * 6)
        particle = self._rebuild(_with_body(mechanism, bare))
        if particle is None:
            return
        turning = self._sample.M - particle[0], self._rest - particle[1]
        name = body.name
        # a body that only slides has no inertia to be mistaken
        turns = bool(np.abs(turning[0]).max() > _SINGULAR * np.abs(self._sample.M).max())
        if turns:
            what = f"the inertia of {name!r} about its own center is missing (taken as a particle)"
            yield Hypothesis("inertia", what, 1.0, *particle)
            what = f"the inertia of {name!r} about its own center is taken twice"
            twice = self._sample.M + turning[0], self._rest + turning[1]
            yield Hypothesis("inertia", what, 1.6, *twice)
        still = self._rebuild(replace(_with_body(mechanism, bare), gravity=(0.0, 0.0, 0.0)))
        gone = body.replace(mass=0.0, inertia=(0.0,) * 6)
        absent = self._rebuild(replace(_with_body(mechanism, gone), gravity=(0.0, 0.0, 0.0)))
        if still is None or absent is None:
            return
        moving = still[0] - absent[0], still[1] - absent[1]
        if turns:
            what = f"the inertia of {name!r} is taken about its center (Steiner's term is missing)"
            rest = self._rest - moving[1]
            yield Hypothesis("inertia", what, 0.8, self._sample.M - moving[0], rest)
            what = (
                f"Steiner's term of {name!r} counts twice: inertia about the joint and the "
                "motion of the center"
            )
            rest = self._rest + moving[1]
            yield Hypothesis("inertia", what, 0.9, self._sample.M + moving[0], rest)
        light = self._rebuild(_with_body(mechanism, gone))
        if light is not None:
            what = f"the mass of {name!r} is missing"
            yield Hypothesis("missing", what, 1.3, *light)
            weight = particle[1] - still[1]
            less = self._rebuild(replace(_with_body(mechanism, gone), gravity=(0.0, 0.0, 0.0)))
            if less is not None:
                own = weight - (light[1] - less[1])
                what = f"the weight of {name!r} is missing"
                yield Hypothesis("missing", what, 1.1, self._sample.M, self._rest - own)
                what = f"the sign of the weight of {name!r} is wrong"
                yield Hypothesis("sign", what, 1.1, self._sample.M, self._rest - 2 * own)

    def _rebuild(self, mechanism: Mechanism) -> tuple[Array, Array] | None:
        """Return M and bias − forces of a changed mechanism at the same states."""
        try:
            derivation = derive(mechanism).derivation
        except MecaniqueError:
            return None
        if derivation.algebra.velocities != self._truth.velocities:
            return None
        evaluated = Evaluation(derivation.algebra.ring, self._sample.values)
        n, nv = self._sample.count, mechanism.nv
        M, rest = np.empty((n, nv, nv)), np.empty((n, nv))
        with np.errstate(all="ignore"):
            for i, entries in enumerate(derivation.M):
                for j, entry in enumerate(entries):
                    M[:, i, j] = evaluated(entry)
                rest[:, i] = evaluated(derivation.h[i]) - evaluated(derivation.Q[i])
        return M, rest

    def _linear(self) -> Iterator[Hypothesis]:
        """Small motions about the position with all coordinates zero, if that is at rest."""
        derivation = self._derivation
        ring = derivation.algebra.ring
        if not isinstance(ring, Ring):
            return
        mechanism = self._truth.mechanism
        names = (*derivation.algebra.velocities, *mechanism.coordinates)
        still = {**self._sample.values, **dict.fromkeys(names, np.zeros(self._sample.count))}
        at_rest = Evaluation(ring, still)
        forces = [h - Q for h, Q in zip(derivation.h, derivation.Q, strict=True)]
        n, nv = self._sample.count, mechanism.nv
        with np.errstate(all="ignore"):
            M, rest = np.empty((n, nv, nv)), np.empty((n, nv))
            for i, entries in enumerate(derivation.M):
                for j, entry in enumerate(entries):
                    M[:, i, j] = at_rest(entry)
                rest[:, i] = at_rest(forces[i])
                for name in names:
                    if any(g.name == name for g in forces[i].generators()):
                        slope = at_rest(forces[i].diff(name))
                        rest[:, i] += slope * self._sample.values[name]
        yield Hypothesis(
            "linearized",
            "small angles are assumed throughout: it is the linearized equation",
            0.5,
            M,
            rest,
        )


def _with_body(mechanism: Mechanism, body: Body) -> Mechanism:
    bodies = tuple(body if one.name == body.name else one for one in mechanism.bodies)
    return replace(mechanism, bodies=bodies)


def _groups(series: Series, velocities: Sequence[str]) -> dict[tuple[int, ...], Series]:
    """The parts of a series by powers of the velocities."""
    ring = series.ring
    found = {}
    for powers, part in series.coefficients(velocities).items():
        whole = part
        for name, power in zip(velocities, powers, strict=True):
            whole = whole * ring[name] ** power if power else whole
        found[powers] = whole
    return found


def _split(series: Series) -> list[Series]:
    """Return parts of a series: its terms, and those that share letters, or sine and cosine."""
    terms = list(series.terms())
    if not 1 < len(terms) <= _MOST_TERMS:
        return []
    ring = series.ring
    groups: dict[frozenset[int], Series] = {}
    for first, last in ((1, 2), (0, 1), (0, 2)):
        # what shares the monomial, the sine or cosine, or both
        together: dict[Any, list[int]] = {}
        for place, term in enumerate(terms):
            together.setdefault(term[first:last], []).append(place)
        for places in together.values():
            if len(places) < len(terms):
                parts = [_term(series, *terms[place]) for place in places]
                groups[frozenset(places)] = ring.sum(parts)
    return list(groups.values())


def _term(series: Series, trig: int, monomial: int, c: Fraction) -> Series:
    return Series(series.ring, {trig: {monomial: c.numerator}}, c.denominator, series.reach)


def _name_of(powers: Sequence[int]) -> str:
    """What a textbook calls the terms with these powers of the velocities."""
    if sum(powers) == 2:
        return "the centripetal term" if 2 in powers else "the Coriolis term"
    return "the damping term" if sum(powers) == 1 else "the term"
