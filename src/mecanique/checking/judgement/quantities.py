"""The quantities besides equations of motion that can be checked, with their true values."""

from __future__ import annotations

from collections.abc import Callable, Container, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Literal, NamedTuple, TypeAlias, TypeVar, final

import numpy as np

from mecanique.arrays import Array, rank_of
from mecanique.checking.grammar.letters import KnownLetters
from mecanique.checking.grammar.reader import Statement, read
from mecanique.checking.grammar.tape import FormulaTape, Rows, find_sign_changes
from mecanique.checking.judgement.equilibria import INTEGERS, Equilibria, equilibria_of
from mecanique.checking.judgement.steady import INDEPENDENT, SteadyMotions
from mecanique.checking.judgement.truth import Sample, SeriesValues, Truth
from mecanique.derivation import derive
from mecanique.derivation.scalars.series import Series
from mecanique.derivation.symbolic.derivation import Derivation, Left
from mecanique.derivation.symbolic.forces import store_constant
from mecanique.derivation.symbolic.lagrange import Lagrange
from mecanique.errors import DerivationError, InputError, UnknownNameError
from mecanique.model.constraints.gears import Meshing
from mecanique.model.expression import evaluate
from mecanique.model.mechanism.description import angles
from mecanique.model.mechanism.letters import find_name
from mecanique.model.mechanism_units import characteristic_length, units
from mecanique.model.units import Dimension, divide, read_unit

Kind: TypeAlias = Literal[
    "motion",
    "value",
    "up to a constant",
    "matrix",
    "conserved",
    "several",
    "equilibrium",
    "letters",
    "free body",
    "rates of momenta",
    "steady",
]
"""The way to compare a formula."""


T = TypeVar("T")


@final
@dataclass(frozen=True, eq=False)
class AskedQuantity:
    """A quantity in question."""

    name: str  # name of the question
    kind: Kind  # the way to compare a formula
    # the letters that denote it in equations; the mechanism's own keep their meaning
    letters: tuple[str, ...] = ()
    # its values in the states, shape (n,); of a matrix (n, nv, nv); of several (k, n)
    values: Array | None = None
    # its values in other states with the same parameters, and the letters there
    again: tuple[Array, Mapping[str, Array]] | None = None
    # its value in the ring of the derivation, by letter; a matrix row by row
    series: Mapping[str, Series] = field(default_factory=dict)
    # the derivation with that ring, if not that of the equations of motion
    derivation: Derivation | None = None
    # dimensions of the letters, where known
    dimensions: Mapping[str, Dimension] = field(default_factory=dict)
    # values of further letters, or of those that a question fixes
    more: Mapping[str, Array] = field(default_factory=dict)
    notes: tuple[str, ...] = ()  # what an answer may leave out, or was taken for granted
    # values that mistakes lead to, each with the kind of mistake and its words
    slips: tuple[tuple[str, str, Array], ...] = ()
    velocity: str = ""  # whose momentum it is
    needed: tuple[str, ...] = ()  # the letters that an answer must determine
    # functions that are written with a letter of their own
    functions: Mapping[str, str] = field(default_factory=dict)
    # other usual names of letters
    aliases: Mapping[str, str] = field(default_factory=dict)
    # coordinates about which motions are small; those left out are zero there
    position: Mapping[str, Array] = field(default_factory=dict)
    # the same with the potentials of constant loads, for answers that name one of these letters
    with_loads: AskedQuantity | None = None
    of_loads: frozenset[str] = frozenset()

    @property
    def names(self) -> tuple[str, ...]:
        """The letters that an answer may contain besides the mechanism's own."""
        return tuple(dict.fromkeys((*self.letters, *self.more)))

    def meant_by(self, statements: Iterable[Statement]) -> AskedQuantity:
        """Return the quantity that an answer means, with or without potentials of loads."""
        sides = (side for statement in statements for side in statement.sides)
        if self.with_loads is None or not any(side.letters & self.of_loads for side in sides):
            return self
        return self.with_loads


_ZERO = np.zeros(())

_UNNAMED = "#quantity"
"""What is asked for where all its usual letters are taken."""

ENERGIES = {
    "kinetic energy": (1, 0),
    "potential energy": (0, 1),
    "Lagrangian": (1, -1),
    "energy": (1, 1),
}
"""How much of T and of V is in each."""

ACROSS = "sym"
"""The letter that stands for the entry across the diagonal of a matrix."""

STEADY = "steady motion"
"""The place of a question about small motions beside steady ones, and a question itself."""

_NUMBERED = ("omega", "w", "f", "nu", "T")
"""Letters of frequencies and periods that may be numbered, as omega1."""


_MOTION = ("equation of motion", "equations of motion", "state space")


def ask_for(truth: Truth, question: str) -> AskedQuantity:
    """Return the quantity that a question asks for."""
    if question in _MOTION:
        return AskedQuantity(_MOTION[0], "motion", truth.further_letters)
    asked, _, position = question.partition(" at ")
    name, _, what = asked.partition(" of ")
    known = _QUESTIONS.get(name)
    if known is None or (what and not known.of) or (position and not known.at):
        raise UnknownNameError("question", question, QUESTIONS)
    if truth.derivation is None:
        raise InputError(
            f"the equations of {truth.mechanism.name!r} have no closed form, with which a "
            f"{name} could be compared"
        )
    taken = truth.sample.values
    truths = _Asked(truth, known.letters, position)
    quantity = _keep_letters(known.find(truths, name, what), taken)
    if known.find not in (_Asked.energy, _Asked.hamiltonian) or not truths.of_loads:
        return quantity
    loaded = known.find(_Asked(truth, known.letters, position, loaded=True), name, what)
    return replace(quantity, with_loads=_keep_letters(loaded, taken), of_loads=truths.of_loads)


def _keep_letters(quantity: AskedQuantity, taken: Container[str]) -> AskedQuantity:
    """Return a quantity without those of its letters that mean something in the mechanism."""
    if quantity.kind not in ("value", "up to a constant", "several"):
        return quantity
    letters = tuple(name for name in quantity.letters if name not in taken) or (_UNNAMED,)
    dimensions = {name: unit for name, unit in quantity.dimensions.items() if name not in taken}
    series = {name: whole for whole in quantity.series.values() for name in letters}
    return replace(quantity, letters=letters, dimensions=dimensions, series=series)


@final
class _Asked:
    """Computes true values."""

    def __init__(
        self, truth: Truth, letters: tuple[str, ...], position: str, *, loaded: bool = False
    ) -> None:
        self._truth = truth
        self._loaded = loaded  # whether constant loads have a potential
        self._sample = truth.sample
        self._letters = letters
        self._steady = position == STEADY
        self._position = locate(truth, position) if position and not self._steady else {}
        if self._position and truth.mechanism.constrained:
            self._position |= equilibria_of(truth).locate(self._position)

    @cached_property
    def _lagrange(self) -> Lagrange:
        return Lagrange(self._truth.mechanism, self._truth.closed_form.algebra)

    @cached_property
    def _stored_in_loads(self) -> Series:
        """The potentials of loads that are the same everywhere."""
        algebra = self._truth.closed_form.algebra
        stored = (store_constant(algebra, work) for work in self._lagrange.works)
        return algebra.ring.sum([V for V in stored if V is not None])

    @property
    def of_loads(self) -> frozenset[str]:
        """The letters of loads that are the same everywhere."""
        coordinates = {*self._truth.mechanism.coordinates}
        return frozenset(g.name for g in self._stored_in_loads.generators()) - coordinates

    @cached_property
    def _potential(self) -> Series:
        V = self._lagrange.V
        return V + self._stored_in_loads if self._loaded else V

    def energy(self, name: str, _: str) -> AskedQuantity:
        kinetic, potential = ENERGIES[name]
        series = kinetic * self._lagrange.T + potential * self._potential
        values = self._value(series, self._sample.values)
        exact = AskedQuantity(
            name,
            "value",
            self._letters,
            values,
            series=dict.fromkeys(self._letters, series),
            dimensions=dict.fromkeys(self._letters, read_unit("N·m")),
            more=self._sample.lengths,
        )
        if name == "kinetic energy":
            return exact
        if name == "energy":
            jacobi = self._value(self._jacobi, self._sample.values)
            text = "it is Jacobi's integral T2 − T0 + V, not the energy T + V"
            exact = replace(exact, slips=(("Jacobi", text, jacobi),))
        moved = roll(self._truth, self._sample)
        with np.errstate(all="ignore"):
            known = np.isfinite(self._value(self._lagrange.T + self._potential, moved))
        # what other parameters put out of reach stays where it is
        moved = {n: np.where(known, x, self._sample.values[n]) for n, x in moved.items()}
        ring = self._lagrange.V.ring
        moved |= {name: self._value(ring[name], moved) for name in self._sample.lengths}
        return replace(exact, kind="up to a constant", again=(self._value(series, moved), moved))

    def _value(self, series: Series, values: Mapping[str, Array]) -> Array:
        return self._truth.at(values)(series)

    def mass(self, name: str, _: str) -> AskedQuantity:
        derivation = self._truth.closed_form
        entries = [entry for row in derivation.M for entry in row]
        series = {str(k): entry for k, entry in enumerate(entries)}
        return AskedQuantity(name, "matrix", self._letters, self._sample.M, series=series)

    def momentum(self, name: str, what: str) -> AskedQuantity:
        coordinates = [v.removesuffix("'") for v in self._truth.velocities]
        if not what and len(coordinates) > 1:
            raise InputError(
                f'expected the coordinate of the momentum, e.g. "momentum of {coordinates[0]}"'
            )
        chosen = find_name(self._truth.mechanism, what or coordinates[0], coordinates)
        velocity = self._truth.velocities[coordinates.index(chosen)]
        series = self._lagrange.T.diff(velocity)
        values = self._value(series, self._sample.values)
        letters = ("p", f"p{chosen}", f"p{coordinates.index(chosen) + 1}")
        unit = units(self._truth.mechanism).get(velocity)
        dimension = None if unit is None else divide(read_unit("N·m"), read_unit(unit))
        return AskedQuantity(
            name,
            "value",
            letters,
            values,
            series=dict.fromkeys(letters, series),
            dimensions={} if dimension is None else dict.fromkeys(letters, dimension),
            velocity=velocity,
        )

    def reactions(self, name: str, what: str) -> AskedQuantity:
        derivation = balances(self._truth)
        parting = self._part_wheels(derivation)
        known = {**self._sample.values, **parting}
        here = SeriesValues(derivation, known, self._sample.count)
        reactions = derivation.reactions
        components = [*parting.values(), *map(here, reactions.values())]
        multipliers = [letter for letter in self._truth.multipliers if letter not in reactions]
        components += [self._sample.values[letter] for letter in multipliers]
        values = np.stack(components) if components else np.zeros((0, self._sample.count))
        letters = (*parting, *reactions, *multipliers)
        if not letters:
            raise InputError(
                f"no joint or constraint of {self._truth.mechanism.name!r} transmits a force that "
                "the equations determine; ask for its equation of motion"
            )
        needed = tuple(filter(None, what.split(", ")))
        normal = [letter for letter in letters if letter.endswith(("_n", "_normal"))]
        # beside a tangential force, T may be that one
        along = [k for k, letter in enumerate(letters) if letter.endswith(("_t", "_x", "_y"))]
        usual = "N" if along else "NTS"
        aliases = dict.fromkeys(usual, normal[0]) if len(normal) == 1 else {}
        if aliases and len(along) == 1:
            # friction counts in the direction in which it acts, where that is always the same
            force, friction = letters[along[0]], values[along[0]]
            if (friction >= 0).all() or (friction <= 0).all():
                sign = "-" if friction.min(initial=0.0) < 0 else ""
                aliases |= dict.fromkeys(_FRICTION, f"{sign}{force}")
        if unknown := sorted({*needed} - {*letters}):
            raise UnknownNameError("reaction", unknown[0], letters)
        return AskedQuantity(
            name,
            "letters",
            letters,
            values,
            series=reactions,
            derivation=derivation,
            needed=needed,
            aliases=aliases,
        )

    def _part_wheels(self, derivation: Derivation) -> dict[str, Array]:
        """Return the separating force |F| sin α of each pair of meshing wheels, by its letter."""
        parting = {}
        for element in self._truth.mechanism.elements:
            force = derivation.reactions.get(f"F_{element.name}")
            if isinstance(element, Meshing) and force is not None:
                angle = evaluate(element.pressure_angle, self._sample.values)
                here = SeriesValues(derivation, self._sample.values, self._sample.count)
                push = np.abs(here(force))
                parting[f"N_{element.name}"] = push * np.sin(angle)
        return parting

    def equilibrium(self, name: str, what: str) -> AskedQuantity:
        """Return the mechanism's equilibrium, or the balance of forces on one free body."""
        if not what:
            taken = KnownLetters.of(self._truth.mechanism).by_key
            whole = [letter for letter in INTEGERS if letter not in taken]
            inputs = [signal.symbol for signal in self._truth.mechanism.inputs]
            notes = (f"with {' = '.join(inputs)} = 0",) if inputs else ()
            integers = dict.fromkeys(whole, _ZERO)
            equilibria_of(self._truth)  # before the clock of the judgement starts
            return AskedQuantity(name, "equilibrium", more=integers, notes=notes)
        bodies = [body.name for body in self._truth.mechanism.bodies[1:]]
        if what not in bodies:
            raise UnknownNameError("body", what, bodies)
        derivation = balances(self._truth)
        series = dict(derivation.reactions)
        for stage in derivation.stages:
            for result in stage.results:
                if isinstance(result.left, Left) and stage.title.startswith(f"Free body {what}:"):
                    series[result.left.symbol] = result.right
        still = {**self._sample.values, **dict.fromkeys(self._truth.velocities, _ZERO)}
        still |= dict.fromkeys(self._truth.accelerations, _ZERO)
        values, at_rest = (
            SeriesValues(derivation, letters, self._sample.count).stack([*series.values()]).T
            for letters in (self._sample.values, still)
        )
        again = (at_rest, still)
        return AskedQuantity(
            f"{name} of {what}", "free body", tuple(series), values, again, series, derivation
        )

    def constant(self, name: str, _: str) -> AskedQuantity:
        momenta = [f"p{velocity.removesuffix(chr(39))}" for velocity in self._truth.velocities]
        return AskedQuantity(name, "conserved", (*self._letters, *momenta))

    def frequency(self, name: str, _: str) -> AskedQuantity:
        position, notes = self._position, list[str]()
        turning = SteadyMotions(self._truth).choose() if self._steady else {}
        if not position and not turning:
            equilibria = equilibria_of(self._truth)
            # what is prescribed by the time does not act on free vibrations
            zero = {**equilibria.at_zero, "t": np.zeros(self._sample.count)}
            if equilibria.loads or equilibria.measure(zero):
                position = self._find_stable(equilibria)
                notes += ["about the equilibrium nearest to zero"] if position else []
                if position and equilibria.loads:
                    first = np.array([position[name][0] for name in equilibria.felt])
                    notes = [f"about the equilibrium {equilibria.name(first, 0)}"]
        M, C, K = linear_matrices(self._truth, position, turning)[:3]
        gyroscopic, slips = (C - C.transpose(0, 2, 1)) / 2, []
        if name in ("frequency", "period") and np.abs(C - gyroscopic).max(initial=0.0) > 1e-12:
            raise InputError(
                "the mechanism is damped; ask for the 'undamped frequency' or the 'damped "
                "frequency'"
            )
        if name == "damped frequency":
            undamped = find_frequencies(M, gyroscopic, K).T
            slips.append(("missing", f"{_UNDAMPED}: it is the undamped frequency", undamped))
        frequencies = find_frequencies(M, gyroscopic if name == "undamped frequency" else C, K)
        if np.isfinite(frequencies).all(1).sum() < _FEWEST:
            where = _name_place(self._position)
            raise InputError(f"{where} is not stable, or nothing oscillates there")
        numbered = [
            f"{letter}{k + 1}" for letter in _NUMBERED for k in range(len(self._truth.velocities))
        ]
        letters = (*self._letters, *numbered)
        rate, time = read_unit("1/s"), read_unit("s")
        unit = {letter: time if letter.startswith(_PERIODS) else rate for letter in letters}
        return AskedQuantity(
            name,
            "several",
            letters,
            frequencies.T,
            dimensions=unit,
            notes=tuple(notes),
            more=turning,
            position=position,
            slips=tuple(slips),
        )

    def _find_stable(self, equilibria: Equilibria) -> dict[str, Array]:
        """Return the equilibrium next to zero; of several with constraints a stable one."""
        listed = equilibria.nearest
        for position in listed:
            M, C, K = linear_matrices(self._truth, position)[:3]
            if np.isfinite(find_frequencies(M, C, K)).all(1).sum() >= _FEWEST:
                return position
        return listed[0] if listed else {}

    def period_from_rest(self, name: str, _: str) -> AskedQuantity:
        """Ask for the period of the motion that begins at rest at any position, q = q0."""
        coordinate = self._truth.mechanism.coordinates.names[0]
        start, values = release(self._truth, coordinate)
        taken = {*self._sample.values, f"{coordinate}0", "K"}
        bound = {letter: _ZERO for letter in _BOUND_LETTERS if letter not in taken}
        slips = []
        try:
            small = self.frequency("frequency", "")
        except InputError:
            small = None
        if small is not None and small.values is not None:
            slips.append(
                ("linearized", "it is that of small oscillations", 2 * np.pi / small.values[0])
            )
        notes = (f"{coordinate}0 is the position from which it is released at rest",)
        return AskedQuantity(
            name=name,
            kind="value",
            letters=self._letters,
            values=values,
            dimensions=dict.fromkeys(self._letters, read_unit("s")),
            more={f"{coordinate}0": start, **bound},
            functions={"K": "ellipk_of_modulus"} if "K" not in self._sample.values else {},
            notes=notes,
            slips=tuple(slips),
        )

    @cached_property
    def _momenta(self) -> list[Series]:
        return [self._lagrange.T.diff(velocity) for velocity in self._truth.velocities]

    @property
    def _jacobi(self) -> Series:
        """Σ p q' − L."""
        ring = self._lagrange.V.ring
        products = [p * ring[v] for p, v in zip(self._momenta, self._truth.velocities, strict=True)]
        return ring.sum([self._potential - self._lagrange.T, *products])

    def hamiltonian(self, name: str, _: str) -> AskedQuantity:
        """Return Σ p q' − L, as a function of positions and momenta."""
        moved = roll(self._truth, self._sample)
        here, there = (self._truth.at(values) for values in ({}, moved))
        momenta, again = (
            by_momentum(self._truth, map(values, self._momenta)) for values in (here, there)
        )
        joules = dict.fromkeys(self._letters, read_unit("N·m"))
        dimensions = {**joules, **self._units_of_momenta()}
        return AskedQuantity(
            name=name,
            kind="up to a constant",
            letters=self._letters,
            series=dict.fromkeys(self._letters, self._jacobi),
            values=here(self._jacobi),
            again=(there(self._jacobi), {**moved, **again}),
            dimensions=dimensions,
            more=momenta,
        )

    def _units_of_momenta(self, power: str = "N·m", dots: str = "") -> dict[str, Dimension]:
        """Return the dimensions of momenta, those of an energy or a power by velocities."""
        known = map(units(self._truth.mechanism).get, self._truth.velocities)
        ratios = (None if v is None else divide(read_unit(power), read_unit(v)) for v in known)
        listed = by_momentum(self._truth, ratios, dots).items()
        return {letter: dimension for letter, dimension in listed if dimension is not None}

    def canonical(self, name: str, _: str) -> AskedQuantity:
        """Return the momenta and their rates in true motions."""
        if any(not velocity.endswith("'") for velocity in self._truth.velocities):
            raise InputError("the velocities are not the rates of coordinates")
        here, derivation = self._truth.at({}), self._truth.closed_form
        momenta = here.stack(self._momenta).T
        rates = here.stack([momentum.ddt() for momentum in self._momenta]).T
        # of a momentum that is constant only rounding is left
        size = np.abs(momenta).max(axis=1, initial=0.0, keepdims=True)
        rates = np.where(np.abs(rates) <= _ROUNDING * size, 0.0, rates)
        slopes = []
        for momentum, h, Q in zip(self._momenta, derivation.h, derivation.Q, strict=True):
            # of d/dt of a momentum M v, what has no acceleration
            slopes.append(Q - h + momentum.ddt().linear(self._truth.accelerations)[1])
        return AskedQuantity(
            name=name,
            kind="rates of momenta",
            series=by_momentum(self._truth, slopes, "'"),
            more=by_momentum(self._truth, momenta) | by_momentum(self._truth, rates, "'"),
            dimensions=self._units_of_momenta() | self._units_of_momenta("N·m/s", "'"),
        )

    def holding(self, name: str, _: str) -> AskedQuantity:
        """Return the inputs that hold the mechanism at rest in any position."""
        inputs = [signal.symbol for signal in self._truth.mechanism.inputs]
        moving = (*self._truth.velocities, *self._truth.accelerations)
        still = dict.fromkeys((*moving, *self._truth.multipliers), np.zeros(self._sample.count))
        at_rest = self._truth.at({**still, **dict.fromkeys(inputs, 0.0)})
        right = at_rest.stack(self._truth.balance)
        by = at_rest.slopes(self._truth.balance, (*inputs, *self._truth.multipliers))
        held = -(np.linalg.pinv(by) @ right[..., None])[..., 0]
        left = right + np.einsum("nij,nj->ni", by, held)
        held = held[:, : len(inputs)]
        if not inputs or np.abs(left).max() > 1e-9 * np.abs(right).max(initial=1e-300):
            raise InputError(
                f"no force of {self._truth.mechanism.name!r} holds it at rest in every position"
            )
        known_units = units(self._truth.mechanism)
        dimensions = {s: read_unit(known_units[s]) for s in inputs if known_units.get(s)}
        series = {}
        for symbol, force in zip(inputs, held.T, strict=True):
            # a force that acts along one coordinate is the slope of the potential
            for velocity in self._truth.velocities:
                slope = self._lagrange.V.diff(velocity.removesuffix("'"))
                if np.allclose(self._value(slope, {}), force, rtol=1e-9, atol=0.0):
                    series[symbol] = slope
        return AskedQuantity(
            name=name,
            kind="letters",
            letters=tuple(inputs),
            values=held.T,
            series=series,
            dimensions=dimensions,
            more=still,
            needed=tuple(inputs),
        )

    def transfer(self, name: str, what: str) -> AskedQuantity:
        """Return the transfer function from a force to a coordinate, at real s."""
        coordinates = [v.removesuffix("'") for v in self._truth.velocities]
        inputs = [signal.symbol for signal in self._truth.mechanism.inputs]
        output, _, symbol = what.partition(" from ")
        symbol = symbol or (inputs[0] if len(inputs) == 1 else "")
        if output not in coordinates or symbol not in inputs:
            raise InputError(
                "expected e.g. 'transfer function of "
                f"{coordinates[0]} from {(*inputs, 'F')[0]}', got {what!r}"
            )
        sample = self._sample
        M, C, K, free = linear_matrices(self._truth, self._position)
        names = (*self._truth.velocities, *self._truth.mechanism.coordinates, *inputs)
        at_rest = self._truth.at({**dict.fromkeys(names, 0.0), **self._position})
        force = at_rest.slopes(self._truth.closed_form.Q, [symbol])
        s = np.random.default_rng(self._truth.seed).uniform(0.5, 5.0, sample.count)
        answers = list[Array]()
        for damping in (C, (C - C.transpose(0, 2, 1)) / 2):
            whole = M * np.square(s)[:, None, None] + damping * s[:, None, None] + K
            moved = free @ np.linalg.solve(whole, free.transpose(0, 2, 1) @ force)
            answers.append(np.asarray(moved[:, :, 0], dtype=float))
        k = coordinates.index(output)
        answer, undamped = (by_coordinate[:, k] for by_coordinate in answers)
        others = zip(coordinates, answers[0].T, strict=True)
        slips = [("exchanged", f"it is that of {q}", other) for q, other in others if q != output]
        whole = M * np.square(s)[:, None, None] + C * s[:, None, None] + K
        for q in coordinates if free.shape[1] == free.shape[2] else ():
            rest = [i for i, name in enumerate(coordinates) if name != q]
            if q != output:
                held = np.linalg.pinv(whole[:, rest][:, :, rest]) @ force[:, rest]
                slip = held[:, rest.index(k), 0]
                slips.append(("simple system", f"it is that with {q} held at rest", slip))
        taken = {*sample.values, *self._letters, "s"}
        transform = [name for name in (output.capitalize(),) if name not in taken]
        transformed = dict.fromkeys(transform, answer * sample.values[symbol])
        return AskedQuantity(
            name=name,
            kind="value",
            letters=(*self._letters, *transform),
            values=answer,
            dimensions={"s": read_unit("1/s")},
            more={"s": s, **transformed},
            slips=(("missing", _UNDAMPED, undamped), *slips),
        )

    def steady(self, name: str, _: str) -> AskedQuantity:
        """Ask for the rates at which coordinates that nothing depends on turn uniformly."""
        inputs = [signal.symbol for signal in self._truth.mechanism.inputs]
        notes = (f"with {' = '.join(inputs)} = 0",) if inputs else ()
        return AskedQuantity(name, "steady", SteadyMotions(self._truth).rates, notes=notes)


class _Question(NamedTuple):
    """How a question is answered, and the usual letters of the answer."""

    find: Callable[[_Asked, str, str], AskedQuantity]
    letters: tuple[str, ...] = ()
    of: bool = False  # whether it may name a coordinate or a body
    at: bool = False  # whether it may name a position


_PERIODS = ("T", "tau")
"""How letters of periods begin."""

_FREQUENCY = ("omega", "Omega", "omega0", "omegan", "w", "f", "nu", "T", "T0", "tau")
_FRICTION = ("F", "f", "Ff", "FR", "Fs", "fs")
"""Usual letters of a force of friction."""

_BOUND_LETTERS = ("u", "x", "xi", "phi", "s")
"""Letters over which an integral may be taken besides the coordinate."""

_CONSTANTS = (*"EHhCcpALJKk", "C1", "C2", "c1", "c2", "Lz", "const")
_QUESTIONS = {
    "kinetic energy": _Question(_Asked.energy, ("T", "Ek", "Ekin", "Ec", "KE", "K")),
    "potential energy": _Question(_Asked.energy, ("V", "U", "Ep", "Epot", "PE")),
    "Lagrangian": _Question(_Asked.energy, ("L", "Lagrangian")),
    "energy": _Question(_Asked.energy, ("E", "H", "h")),
    "mass matrix": _Question(_Asked.mass, ("M",)),
    "momentum": _Question(_Asked.momentum, ("p",), of=True),
    "conserved quantity": _Question(_Asked.constant, _CONSTANTS),
    "frequency": _Question(_Asked.frequency, _FREQUENCY, at=True),
    "period from rest": _Question(_Asked.period_from_rest, ("T", "T0", "tau")),
    "period": _Question(_Asked.frequency, ("T", "T0", *_FREQUENCY), at=True),
    "undamped frequency": _Question(_Asked.frequency, _FREQUENCY, at=True),
    "damped frequency": _Question(_Asked.frequency, (*_FREQUENCY, "omegad", "wd"), at=True),
    STEADY: _Question(_Asked.steady),
    "Hamiltonian": _Question(_Asked.hamiltonian, ("H", "E")),
    "Hamilton's equations": _Question(_Asked.canonical),
    "equilibrium force": _Question(_Asked.holding),
    "transfer function": _Question(_Asked.transfer, ("G", "H"), of=True, at=True),
    "equilibrium": _Question(_Asked.equilibrium, of=True),
    "reaction": _Question(_Asked.reactions, of=True),
}

QUESTIONS = (_MOTION[0], *_QUESTIONS)
"""The possible questions."""

_ROUNDING = 1e-12
"""Rates of momenta below this part of the momenta, per second, are rounding."""

_UNDAMPED = "the damping is missing"
_FEWEST = 3
"""Least number of states in which a position is an equilibrium, and stable."""


def locate(truth: Truth, position: str) -> dict[str, Array]:
    """Return the coordinates at a position such as "q = pi" in the states; NaN where none is."""
    letters = KnownLetters.of(truth.mechanism)
    sample = truth.sample
    values = {**sample.values, **dict.fromkeys(truth.mechanism.coordinates, np.zeros(sample.count))}
    positions = {}
    for statement in read(position, letters):
        left, right = statement.sides[0], statement.sides[-1]
        if left.name not in truth.mechanism.coordinates or not statement.is_equation:
            raise InputError(f"expected a position such as 'q = pi', got {statement.text!r}")
        positions[left.name] = FormulaTape(right).evaluate(values, sample.count).whole
        values = {**values, left.name: positions[left.name]}
    return positions


def find_frequencies(M: Array, C: Array, K: Array) -> Array:
    """Return the angular frequencies of M x'' + C x' + K x = 0, at most nv, shape (n, k).

    They are NaN in states in which something does not oscillate.
    """
    n, nv, _ = M.shape
    known = np.isfinite(M).all((1, 2)) & np.isfinite(C).all((1, 2)) & np.isfinite(K).all((1, 2))
    if not np.abs(C[known]).max(initial=0.0) > 1e-12:
        frequencies = np.full((n, nv), np.nan)
        squares = np.linalg.eigvals(np.linalg.solve(M[known], K[known]))
        least = -1e-9 * np.abs(squares).max(axis=1, initial=0.0)[:, None]
        stable = squares.real >= least
        with np.errstate(all="ignore"):
            roots = np.where(stable, np.sqrt(np.maximum(squares.real, 0.0)), np.nan)
        frequencies[known] = np.where(stable.all(1)[:, None], np.sort(roots, axis=1), np.nan)
        return frequencies
    # a coordinate that nothing depends on has no oscillation of its own, only its rate
    felt = np.abs(K[known]).max(axis=(0, 1)) > 1e-12 * np.abs(K[known]).max()
    count = int(felt.sum())
    state = np.zeros((n, count + nv, count + nv))
    state[:, :count, count:] = np.eye(nv)[felt]
    state[known, count:, :count] = -np.linalg.solve(M[known], K[known][:, :, felt])
    state[known, count:, count:] = -np.linalg.solve(M[known], C[known])
    state[~known] = 0.0
    turning = np.sort(np.linalg.eigvals(state).imag, axis=1)[:, nv:]
    with np.errstate(all="ignore"):
        oscillates = (turning > 1e-9 * np.abs(state).max((1, 2))[:, None]).all(1) & known
    return np.where(oscillates[:, None] & (count > 0), turning, np.nan)


def measure(omega: Array, letters: Sequence[str]) -> dict[str, Array]:
    """Return the values of letters for an angular frequency: itself, 1/s or the period."""
    with np.errstate(all="ignore"):
        period = 2 * np.pi / omega
    known = dict.fromkeys(letters, omega)
    for name in letters:
        if name.startswith(("f", "nu")):
            known[name] = omega / (2 * np.pi)
        elif name.startswith(_PERIODS):
            known[name] = period
    return known


def by_momentum(truth: Truth, things: Iterable[T], dots: str = "") -> dict[str, T]:
    """Return what belongs to each momentum by all of its letters that mean nothing else."""
    names, by_letter = [v.removesuffix("'") for v in truth.velocities], dict[str, T]()
    for k, (name, thing) in enumerate(zip(names, things, strict=True), 1):
        letters = [f"p{name}", f"p{k}", *(["p"] if len(names) == 1 else [])]
        free = [letter for letter in letters if letter not in truth.sample.values] or letters[:1]
        by_letter |= {f"{letter}{dots}": thing for letter in free}
    return by_letter


def roll(truth: Truth, sample: Sample) -> dict[str, Array]:
    """Return the letters with the coordinates and rates of other states, parameters unchanged."""
    moving = {*truth.mechanism.coordinates, *truth.velocities, *truth.accelerations}
    return {
        name: np.roll(value, 1) if name in moving else value
        for name, value in sample.values.items()
    }


def _name_place(position: Mapping[str, Array]) -> str:
    return "the position in question" if position else "the position with all coordinates zero"


def linear_matrices(
    truth: Truth, position: Mapping[str, Array], turning: Mapping[str, Array] | None = None
) -> tuple[Array, Array, Array, Array]:
    """Return M, C and K of small motions about a position; other coordinates are zero there.

    With the letters of a steady motion, they are those about it. With them come the directions in
    which constraints leave it free, shape (n, nv, free).
    """
    signals = [signal.symbol for signal in truth.mechanism.inputs]
    names = (*truth.velocities, *truth.mechanism.coordinates, *signals)
    # what is prescribed by the time does not act on free vibrations
    zero = dict.fromkeys((*names, "t"), 0.0)
    here = truth.at(turning or {**zero, **position})
    coordinates = [name.removesuffix("'") for name in truth.velocities]
    where = _name_place(position)
    n, nv = truth.sample.count, len(truth.velocities)
    with np.errstate(all="ignore"):
        M = here.M
        C, K = (here.slopes(truth.balance, some) for some in (truth.velocities, coordinates))
        if (np.abs(here.stack(truth.balance)) > 1e-9 * (1.0 + np.abs(K).sum(2))).any():
            raise InputError(f"{where} is not an equilibrium")
    known = np.logical_and.reduce([np.isfinite(matrix).all((1, 2)) for matrix in (M, C, K)])
    free = np.broadcast_to(np.eye(nv), (n, nv, nv))
    if truth.multipliers:
        columns, sizes, _ = np.linalg.svd(here.slopes(truth.balance, truth.multipliers))
        held = np.array([rank_of(values, INDEPENDENT) for values in sizes])
        free = columns[:, :, held.max() :]
        M, C, K = (free.transpose(0, 2, 1) @ matrix @ free for matrix in (M, C, K))
        known &= held == held.max()
    least = _FEWEST if position or turning else n
    if known.sum() < least or (np.linalg.matrix_rank(M[known]) < M.shape[1]).any():
        raise InputError(f"the equations have no meaning at {where}")
    return M, C, K, free


def balances(truth: Truth) -> Derivation:
    """Derive the balances of all free bodies, by Newton and Euler's method."""
    try:
        return derive(truth.mechanism, "newton_euler").derivation
    except DerivationError as error:
        raise InputError(f"the reactions have no closed form: {error}") from None


# The period of a motion with one coordinate that begins at rest, by an integral of its energy.

_AMPLITUDES = {True: (0.3, 2.5), False: (0.2, 1.5)}
"""Positions at rest, in radians where it turns, else in characteristic lengths."""

_REACH = {True: 2 * np.pi, False: 12.0}
_GRID = 400
_HALVINGS = 60
_FEWEST_RETURNS = 6
"""Least number of states in which the motion returns."""

_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(200)


def release(truth: Truth, name: str) -> tuple[Array, Array]:
    """Return positions at rest of the only coordinate, and the period from each, shape (n,).

    The period is 2 ∫ dq √(M/(2 (V(q₀) − V(q)))) between the two positions at rest, where V is the
    potential without the part of T that does not depend on the velocity (Landau & Lifshitz,
    Mechanics, § 11); NaN where the motion does not return.
    """
    potential, inertia = _find_energy(truth, name)
    turns = name in angles(truth.mechanism)
    size = 1.0 if turns else characteristic_length(truth.mechanism)
    count = truth.sample.count
    start = size * np.random.default_rng(truth.seed).uniform(*_AMPLITUDES[turns], count)

    def evaluate(series: Series, states: Rows, q: Array) -> Array:
        return truth.at({**truth.sample.at(states), name: q}, len(states))(series)

    states = np.arange(count)
    height = evaluate(potential, states, start)
    downhill = -np.sign(evaluate(potential.diff(name), states, start))

    def rise(states: Rows, way: Array) -> Array:
        return evaluate(potential, states, start[states] + downhill[states] * way) - height[states]

    grid = np.linspace(0.0, _REACH[turns] * size, _GRID)[1:]
    rows, ways, _ = find_sign_changes(rise, count, grid, _HALVINGS)
    way = np.full(count, np.nan)
    rows, first = np.unique(rows, return_index=True)
    way[rows] = ways[first]
    if len(rows) < _FEWEST_RETURNS:
        raise InputError("released at rest it does not return, so it has no period")
    # over sin φ the inverse root, infinite at both ends, stays finite
    angle, period = np.pi / 2 * _NODES, np.zeros(count)
    for sine, cosine, weight in zip(np.sin(angle), np.cos(angle), _WEIGHTS, strict=True):
        q = start + downhill * way * (1 + sine) / 2
        fall = height - evaluate(potential, states, q)
        speed = np.sqrt(2 * fall / evaluate(inertia, states, q))
        period += np.pi / 2 * weight * way * cosine / speed
    return start, period


def _find_energy(truth: Truth, name: str) -> tuple[Series, Series]:
    """Return the potential and the inertia of the only coordinate."""
    lagrange = Lagrange(truth.mechanism, truth.closed_form.algebra)
    parts = lagrange.T.coefficients(truth.velocities)
    potential = lagrange.V - parts.get((0,), lagrange.V.ring.number(0))
    inertia = truth.closed_form.M[0][0]
    moving = {g.name for series in (potential, inertia) for g in series.generators()}
    alone = truth.velocities == (f"{name}'",) and not truth.mechanism.constrained
    if not alone or "t" in moving or not _is_kept(truth, potential, inertia, name):
        raise InputError(
            f"the period of {truth.mechanism.name!r} from rest is no integral: expected one "
            "coordinate, and neither damping nor forces that depend on the time"
        )
    return potential, inertia


def _is_kept(truth: Truth, potential: Series, inertia: Series, name: str) -> bool:
    """Whether the forces keep the energy: they are V' + M' v²/2, with the slopes by q."""
    sample = truth.sample
    pull, change = (truth.at({})(series.diff(name)) for series in (potential, inertia))
    if not pull.any():
        return False
    force = pull + change * sample.values[f"{name}'"] ** 2 / 2
    rest = (sample.bias - sample.forces)[:, 0]
    return bool((np.abs(rest - force) <= 1e-9 * (np.abs(rest) + np.abs(force))).all())
