"""Make the engine of a page from a motion, and compare it with what Pinocchio gave."""

from __future__ import annotations

import math
import shutil
from collections import defaultdict
from collections.abc import Iterator, Sequence
from dataclasses import replace
from math import floor, isfinite, log10
from typing import Any, final

import numpy as np

from mecanique.arrays import spread
from mecanique.derivation import derive
from mecanique.derivation.equations import Equations
from mecanique.derivation.mechanics.elements import Ground
from mecanique.derivation.mechanics.letters import Letters
from mecanique.derivation.mechanics.loops import sense
from mecanique.derivation.mechanics.switching import list_holding_margins
from mecanique.derivation.symbolic.forces import stored_in_loads
from mecanique.derivation.tree.poses import times_point
from mecanique.errors import DerivationError, MecaniqueError
from mecanique.generation.build import assemble
from mecanique.generation.mechanics.closed_form import Lowering
from mecanique.generation.mechanics.constrained import inputs_at
from mecanique.generation.mechanics.dynamics import TapeDynamics, dynamics_of
from mecanique.generation.mechanics.free_body_forces import FreeBodyForces
from mecanique.generation.program import QUANTITIES, Answer, Output, Program, ProgramInput
from mecanique.generation.targets.javascript import JavaScript
from mecanique.generation.targets.javascript import functions as write_functions
from mecanique.generation.targets.python import Python
from mecanique.generation.verdict import CodeVerdict, cases_of, judge
from mecanique.model import Mechanism, Mesh, Placement
from mecanique.model.bodies.visuals import measure
from mecanique.model.expression import Scalar, symbols_in
from mecanique.model.expression import evaluate as evaluate_scalar
from mecanique.model.force_base import End
from mecanique.model.mechanism.validation import MASS, MOMENT, TRIANGLE, rules_of
from mecanique.model.quaternions import to_matrices
from mecanique.model.states import States
from mecanique.model.teeth import visuals_of
from mecanique.motion.analysis.energies import is_rheonomic
from mecanique.motion.analysis.forces import Action
from mecanique.motion.motion import Motion
from mecanique.motion.record.events import break_names
from mecanique.motion.switching.corners import ElementForce
from mecanique.motion.switching.holding import Holding
from mecanique.motion.tolerances import AT_LIMIT
from mecanique.program.evaluation import evaluate
from mecanique.program.sweeps import push_forward
from mecanique.program.traced import trace, value_of, values_of
from mecanique.textbook import load
from mecanique.textbook.catalogue import is_known
from mecanique.verification.states import random_states
from mecanique.viewing.corners import PageCorners
from mecanique.viewing.scene.drawn import group_work, name_arrows, spans_of, tips_of
from mecanique.viewing.scene.from_motion import LOST, fit, losses_of, names_of, scene_of
from mecanique.viewing.scene.scene import (
    Bound,
    Condition,
    Floats,
    PageProgram,
    Resized,
    Scene,
    SceneText,
    VerdictTable,
)
from mecanique.viewing.scene.texts import quantities_of_inputs


def bounds_of(
    motion: Motion, letters: Letters, ground: Ground
) -> list[tuple[Bound, tuple[Any, Any]]]:
    """Return what ends a motion, with its distance and how near counts as reached, on the tape."""
    if motion.watched is None and any(event.impact for event in motion.events):
        raise DerivationError("what its impacts depend on is not known")
    turned = [
        (Bound("", -1, f"loop {loop.name!r} must not close half a turn apart"), (distance, 0.0))
        for loop in motion.mechanism.loops
        if (distance := sense(loop, ground)) is not None
    ]
    return [*_limits(motion, letters), *_stops(motion, letters), *turned]


def gradients_of(motion: Motion, letters: Letters) -> list[Any]:
    """Return the slopes of what passes zero at each impact: over t, then over each coordinate."""
    from sympy import Symbol, diff

    names = ("t", *motion.mechanism.coordinates)
    return [
        letters.arithmetic(diff(event.expression(motion.mechanism), Symbol(name)), letters.values)
        for event in motion.watched or ()
        if event.restitution is not None
        for name in names
    ]


def is_cut_short(motion: Motion) -> bool:
    """Return whether a limit or an event ended a motion."""
    stopping = {f"end of chart {name}" for name in motion.mechanism.limits}
    stopping |= {event.name for event in motion.watched or () if event.stop}
    last = motion.events[-1] if motion.events else None
    return last is not None and last.name in stopping and last.t >= float(motion.t[-1])


def options_of(motion: Motion) -> Iterator[str]:
    """Yield the arguments of `simulate` that bounded a motion, as Python."""
    bounding = [
        event for event in motion.watched or () if event.stop or event.restitution is not None
    ]
    limits = _limited_joints(motion)
    for event in bounding:
        if event.name in limits:
            yield 'limits="stop"' if event.stop else f"limits={event.restitution}"
            break
    texts = []
    for event in bounding:
        if event.name not in limits:
            what = "stop=True" if event.stop else f"restitution={event.restitution}"
            when = _write_quantity(event.expression(motion.mechanism))
            texts.append(f"mq.Event({event.name!r}, {when}, {event.direction}, {what})")
    if texts:
        yield f"events=[{', '.join(texts)}]"


def _write_quantity(expression: Scalar) -> str:
    from sympy import Symbol, srepr

    if isinstance(expression, Symbol):
        return repr(expression.name)
    primed = any("'" in symbol.name for symbol in expression.free_symbols)
    return f"sympy.sympify({(srepr(expression) if primed else str(expression))!r})"


def _limited_joints(motion: Motion) -> dict[str, str]:
    """Name of each joint by the names of the events at its limits."""
    return {
        f"{which} limit of {joint.name}": joint.name
        for joint in motion.mechanism.joints
        for which in ("lower", "upper")
    }


def _limits(motion: Motion, letters: Letters) -> Iterator[tuple[Bound, tuple[Any, Any]]]:
    from sympy import sympify

    mechanism = motion.mechanism
    for name, interval in mechanism.coordinates.intervals.items():
        bounds = [sympify(bound) for bound in interval]
        texts = [f"{float(bound):g}" if bound.is_number else str(bound) for bound in bounds]
        known = zip(interval, texts, mechanism.limits[name], (1.0, -1.0), strict=True)
        ends = [
            (letters.arithmetic(bound, letters.values), side, text)
            for bound, text, value, side in known
            if isfinite(value)
        ]
        margin: Any = AT_LIMIT
        if len(ends) == 2:
            margin = (ends[1][0] - ends[0][0]) * AT_LIMIT
        reason = mechanism.explain_chart(name)
        must = f"{name} must stay within ({', '.join(texts)}): {reason}"
        for bound, side, text in ends:
            distance = (letters.values[name] - bound) * side
            words = f"where {name} comes to its limit {text}: {reason}"
            yield Bound(words, -1, must), (distance, margin)


def _stops(motion: Motion, letters: Letters) -> Iterator[tuple[Bound, tuple[Any, Any]]]:
    joints = _limited_joints(motion)
    for event in motion.watched or ():
        if not event.stop and event.restitution is None:
            continue
        expression = event.expression(motion.mechanism)
        if expression is None:
            raise DerivationError(f"event {event.name!r} is a function of Python")
        quantity = letters.arithmetic(expression, letters.values)
        joint = joints.get(event.name)
        where = f"at the {event.name}" if joint else f"at its event {event.name!r}"
        must = f"joint {joint!r} must start within its limits" if joint else ""
        yield Bound(where, event.direction, must, event.restitution), (quantity, 0.0)


def conditions_of(letters: Letters) -> list[tuple[Condition, list[Any]]]:
    """Return the conditions that depend on what is set, with their numbers on the tape."""
    mechanism = letters.mechanism
    values, known = mechanism.values, {*mechanism.values, *letters.open}
    open_letters = {*letters.open}

    def is_judged(scalar: Scalar) -> bool:
        return symbols_in(scalar) <= known and (
            not symbols_in(scalar) <= values.keys()
            or math.isfinite(float(evaluate_scalar(scalar, values)))
        )

    judged = []
    for condition, scalars in (*_of_bodies(mechanism), *_of_rules(mechanism)):
        depends = any(symbols_in(scalar) & open_letters for scalar in scalars)
        if depends and all(map(is_judged, scalars)):
            numbers = [letters.arithmetic(scalar, letters.values) for scalar in scalars]
            judged.append((condition, numbers))
    return judged


def _of_bodies(mechanism: Mechanism) -> Iterator[tuple[Condition, tuple[Scalar, ...]]]:
    for body in mechanism.bodies:
        where = f"body {body.name!r}: "
        yield Condition("gap", where, (MASS,), 2), (body.mass, body.mass)
        if not body.as_given:
            words = MOMENT, TRIANGLE
            yield Condition("inertia", where, words, 7, follows=True), (body.mass, *body.inertia)


def _of_rules(mechanism: Mechanism) -> Iterator[tuple[Condition, tuple[Scalar, ...]]]:
    for rule in rules_of(mechanism):
        scalars = rule.scalars
        kind: Any = "finite" if rule.gap is None else "gap"
        words, strict, follows = (rule.words,), rule.strict, rule.follows
        yield Condition(kind, rule.where, words, len(scalars), strict, follows), scalars


WORK = "work done"
"""Name on the tape of the work that has been done, which comes after the state."""


PAGE_ALIKE = 1e-7
"""Largest difference, relative to the largest number of its kind, that counts as agreement."""


_OF_MOTION = {"body": "pose", "line": "points", "trace": "points", "coordinate": "series of motion"}
"""What the program must give as the motion does."""

_MEASURED_AS = {"body": "place", "line": "place", "trace": "place", "coordinate": "series"}
"""Kinds of columns whose numbers are compared by a common size."""


def find_unknown(
    scene: Scene, rows: Sequence[Sequence[Any]], numbers: Floats, chosen: np.ndarray
) -> tuple[int, ...]:
    """Return the columns of the scene's table that the program does not give.

    `rows` is what the program gives of each of its columns, None for what it does not know, and
    `numbers` the same in numbers at the chosen instants, side by side.
    """
    unknown: list[int] = []
    at, column = 0, 0
    for part, row, size in zip(scene.columns, rows, _sizes(scene), strict=True):
        ours, known, scale = numbers[:, at : at + len(row)], part.values[chosen], np.array(size)
        if part.kind == "body":
            turns = to_matrices(known[:, 3:]).reshape(-1, 9)
            known, scale = np.hstack([known[:, :3], turns]), np.repeat([size, 1.0], [3, 9])
        differences = np.abs(ours - known).max(axis=0, initial=0.0)
        missing = any(scalar is None for scalar in row)
        if missing or not np.all(differences <= PAGE_ALIKE * scale):
            if part.kind in _OF_MOTION and not missing:
                raise DerivationError(
                    f"the program gives another {_OF_MOTION[part.kind]} of {part.name} than the "
                    f"motion, by {float(np.max(differences)):.1e}"
                )
            unknown += range(column, column + part.values.shape[1])
        at += len(row)
        column += part.values.shape[1]
    return tuple(unknown)


def _sizes(scene: Scene) -> list[float]:
    """How large numbers like those of each of a scene's columns are."""
    largest = defaultdict[tuple[str, str], float](lambda: 1e-9)
    keys = [(_MEASURED_AS.get(part.kind, part.kind), part.unit) for part in scene.columns]
    for key, part in zip(keys, scene.columns, strict=True):
        # places of bodies without their quaternions, forces without the places where they act
        of_kind = {"body": part.values[:, :3], "arrow": part.values[:, 3:]}
        size = np.abs(of_kind.get(part.kind, part.values)).max(initial=0.0)
        largest[key] = max(largest[key], float(size))
    largest["arrow", ""] = max(largest["arrow", ""], largest["place", ""])
    return [largest[key] for key in keys]


MOST_LETTERS = 800_000
"""Longest program that a page takes along [characters]; compressed it is a fifth of that."""

MOST_VELOCITIES = 12
"""Programs of larger mechanisms would take long to write, and longer than this to read."""

RTOL, LOOPS_RTOL = 1e-9, 1e-8
"""Relative tolerances of a step that a page begins with; with loops a step uses a tenth of it."""

_STATES = 12
"""Number of random states at which a force that never acts is recognized."""

_FAINT = 1e-9

_TAKES = ("t", "y", "tau")


@final
class Maker:
    """Makes the engine of a motion's page."""

    def __init__(self, motion: Motion, equations: Equations) -> None:
        self._motion = motion
        self._mechanism = mechanism = motion.mechanism
        refuse(mechanism)
        symbols = (*mechanism.values, *(signal.symbol for signal in mechanism.inputs))
        self._dynamics: TapeDynamics = dynamics_of(equations, symbols)
        self._letters = self._dynamics.letters
        tape = self._letters.tape
        self._work = tape.input(WORK)
        lost = losses_of(motion) if motion.corners is not None else ()
        self._lost = {f"{LOST}{name}": tape.input(f"{LOST}{name}") for name in lost}
        self._corners = PageCorners(motion, symbols) if motion.corners is not None else None
        self._actions = FreeBodyForces(self._dynamics)
        self._shown = [a for a in self._actions.all() if a.body != mechanism.ground]

    def thin(self, scene: Scene) -> Scene:
        """Return a complete scene without the forces and moments that never act."""
        names = names_of(scene)
        for name, acts in self._acting().items():
            both = {f"arrow {name}", f"series {name}"}
            names = names | both if acts else names - both
        return fit(scene, names)

    def make(self, scene: Scene, python: str = "") -> PageProgram:
        """Return the engine of a scene."""
        motion, mechanism = self._motion, self._mechanism
        rows = self._row(scene)
        known = [0.0 if column is None else column for row in rows for column in row]
        chosen = spread(len(motion.t), 40)
        unknown = find_unknown(scene, rows, self._evaluate(known, chosen), chosen)
        resized = list(self._find_resized())
        bounds = bounds_of(motion, self._letters, self._dynamics.tree.recursion.ground)
        conditions = conditions_of(self._letters)
        margins = self._margins(chosen)
        functions = {
            "rates": self._rates(),
            "row": known,
            "shapes": [entry for _, entries in resized for entry in entries],
        }
        not_always = {
            "closure": self._closure(),
            "tree": self._tree(),
            "bounds": [x for _, pair in bounds for x in pair],
            "rules": [x for _, group in conditions for x in group],
            "gradients": gradients_of(motion, self._letters),
            "margins": list(margins.values()),
        }
        functions |= {name: scalars for name, scalars in not_always.items() if scalars}
        answers = [self._answer(name, scalars) for name, scalars in functions.items()]
        listing = write_functions(self._program(answers))
        switching = None
        if self._corners is not None:
            functions, switching = self._corners.functions()
            switching = replace(switching, losses=tuple(losses_of(motion)))
            answers_of_modes = [self._answer(name, scalars) for name, scalars in functions.items()]
            listing += write_functions(self._corners.program(answers_of_modes))
            answers += answers_of_modes
        text = "\n".join(listing)
        if len(text) > MOST_LETTERS:
            raise DerivationError(f"the program would take {len(text) // 1000} kB")
        names = ", ".join(answer.quantity.name for answer in answers)
        closing = self._dynamics.loops.residual if mechanism.constrained else []
        return PageProgram(
            script=f'"use strict";\n{text}\nglobalThis.mecaniqueProgram = {{ {names} }};\n',
            coordinates=tuple(mechanism.coordinates),
            velocities=tuple(mechanism.velocities),
            parameters=tuple(self._letters.open),
            values=tuple(value_at(mechanism, name) for name in self._letters.open),
            start=tuple(map(float, (*motion.q[0], *motion.v[0]))),
            first=float(motion.t[0]),
            duration=_duration(motion),
            rtol=LOOPS_RTOL if mechanism.constrained else RTOL,
            quaternions=tuple(at[0] for _, at in mechanism.quaternions),
            loops=len(closing),
            restrained=tuple(k for k, gap in enumerate(closing) if gap == 0.0),
            unknown=unknown,
            resized=tuple(shape for shape, _ in resized),
            bounds=tuple(bound for bound, _ in bounds),
            conditions=tuple(condition for condition, _ in conditions),
            holding=tuple(margins),
            python=python,
            switching=switching,
            options=tuple(options_of(motion)),
        )

    def proof(self) -> Program:
        """Return the part of the program that Pinocchio knows the answers of."""
        mechanism = self._mechanism
        names = ["rhs", "energy", "poses", *(["closure"] if mechanism.constrained else [])]
        answers = []
        for name in names:
            values = tuple(self._dynamics.answer(name))
            answers.append(Answer(QUANTITIES[name], values, (len(values),)))
        return assemble(self._dynamics, "page", answers)

    def _rates(self) -> list[Any]:
        """Rates of the state and of the work of everything that has no potential."""
        # that work changes the energy along the motion: ∂E/∂q q' + ∂E/∂v a + ∂E/∂t
        letters, dynamics = self._letters, self._dynamics
        return [*letters.rates, *dynamics.acceleration, self._power(), *(0.0 for _ in self._lost)]

    def _row(self, scene: Scene) -> list[list[Any]]:
        """The numbers of each of a scene's columns; a rotation for each quaternion."""
        arrows = {name: (action, unit) for name, action, unit in name_arrows(self._shown)}
        spans = {span.name: span.ends for span in spans_of(self._motion.described)}
        tips = {f"path of {tip.body}": tip for tip in tips_of(self._mechanism)}
        works = dict(group_work(self._mechanism, self._shown))
        curves = self._curves()
        tensions = {name for element in self._mechanism.elements for name in element.tensions}
        touches = iter(action.origin for action in self._actions.guiding if action.name in tensions)
        rows: list[list[Any]] = []
        for part in scene.columns:
            name = part.name
            match part.kind:
                case "body":
                    pose = self._dynamics.tree.recursion.pose(name)
                    rows.append([*(r[3] for r in pose), *(x for r in pose for x in r[:3])])
                case "arrow" if name in arrows:
                    action, unit = arrows[name]
                    vector = action.force if unit == "N" else action.moment
                    rows.append([*action.origin, *vector])
                case "line" if name in spans:
                    rows.append([x for end in spans[name] for x in self._locate(end)])
                case "line" if name.startswith("stretch "):
                    rows.append([*next(touches), *next(touches)])
                case "trace":
                    rows.append(self._locate(tips[name]))
                case "coordinate" | "series":
                    rows.append([curves.get(name)])
                case "work" if name in works:
                    parts = [self._actions.work(action) for action in works[name]]
                    rows.append([sum(column, 0.0) for column in zip(*parts, strict=True)])
                case _:
                    rows.append([None] * part.values.shape[1])
        return rows

    def _reactions(self) -> dict[str, Any]:
        """The components of the joints' reactions, by the name of their series."""
        children = {joint.name: joint.child for joint in self._mechanism.joints}
        components: dict[str, Any] = {}
        for action in self._shown:
            if action.kind == "reaction" and children.get(action.name) == action.body:
                for sign, vector in (("R", action.force), ("M", action.moment)):
                    for axis, component in zip("xyz", vector, strict=True):
                        components[f"{action.name} {sign}{axis}"] = component
        return components

    def _closure(self) -> list[Any]:
        """Residual, its rate and Jacobian of the loops as one list; empty for a tree."""
        if not self._mechanism.constrained:
            return []
        loops = self._dynamics.loops
        return [*loops.residual, *loops.rate, *(entry for row in loops.jacobian for entry in row)]

    def _tree(self) -> list[Any]:
        """M and the load of the tree, for places where loops lose rank; empty for a tree."""
        if not self._mechanism.constrained:
            return []
        return [*(x for row in self._dynamics.mass_matrix for x in row), *self._dynamics.drive]

    def _margins(self, chosen: np.ndarray) -> dict[str, Any]:
        """What contacts and cords have left, where the program gives it as the reference does."""
        motion, mechanism, letters = self._motion, self._mechanism, self._letters
        names = break_names(mechanism)
        if not names:
            return {}
        forces = dict(self._actions.guide_sizes)
        if mechanism.contacts:
            loops = self._dynamics.loops
            forces |= zip(loops.names, self._dynamics.multipliers, strict=True)
        margins = list_holding_margins(
            mechanism,
            forces,
            lambda scalar: letters.arithmetic(scalar, letters.values),
            lambda x, y: letters.call("sqrt", x * x + y * y),
        )
        holding = Holding(motion.mechanism, motion.reference)
        known = holding.margins(motion.t[chosen], motion.q[chosen], motion.v[chosen])
        gaps = np.abs(self._evaluate(margins, chosen) - known).max(axis=0)
        near = gaps <= PAGE_ALIKE * np.abs(known).max(axis=0)  # not where they are undetermined
        listed = zip(names, margins, near, strict=True)
        return {name: margin for name, margin, same in listed if same}

    def _answer(self, name: str, scalars: Sequence[Any]) -> Answer:
        values = tuple(values_of(scalars))
        return Answer(Output(name, name, _TAKES, ""), values, (len(values),))

    def _program(self, answers: Sequence[Answer]) -> Program:
        program = assemble(self._dynamics, "page", answers)
        letters = dict(program.letters)
        for k, name in enumerate((WORK, *self._lost)):
            letters["v"] = (*letters["v"], ProgramInput(f"work{k}", name, "J"))
            # torques are named after velocities; none drives the work
            letters["tau"] = (*letters["tau"], ProgramInput(f"work{k}", f"tau {name}"))
        return replace(program, letters=letters)

    def _evaluate(self, scalars: Sequence[Any], chosen: np.ndarray) -> np.ndarray:
        """Numbers along the motion, shape (chosen, scalars)."""
        motion, letters = self._motion, self._letters
        t, q, v = motion.t[chosen], motion.q[chosen], motion.v[chosen]
        states = States(self._mechanism, q, v, t, motion.a[chosen])
        inputs = inputs_at(letters, states) | {WORK: motion.energy().work[chosen]}
        if self._lost:
            losses = losses_of(motion).items()
            inputs |= {f"{LOST}{name}": lost[chosen] for name, lost in losses}
        return evaluate(letters.tape, values_of(scalars), inputs, len(chosen))

    def _acting(self) -> dict[str, bool]:
        """Whether each arrow and each component of a reaction is ever nonzero, by name."""
        vectors: dict[str, Sequence[Any]] = {}
        for name, action, unit in name_arrows(self._shown):
            vectors[name] = action.force if unit == "N" else action.moment
        vectors |= {name: (x, 0.0, 0.0) for name, x in self._reactions().items()}
        letters = self._letters
        # forces of elements are known along the motion alone
        at_rest = [
            replace(signal, signal=0.0) if isinstance(signal.signal, ElementForce) else signal
            for signal in self._mechanism.inputs
        ]
        states = random_states(replace(self._mechanism, inputs=tuple(at_rest)), _STATES, 0)
        if self._corners is not None:
            times = self._motion.t[np.linspace(0, len(self._motion.t) - 1, _STATES).astype(int)]
            states = States(self._mechanism, states.q, states.v, times, states.a)
        scalars = [component for vector in vectors.values() for component in vector]
        numbers = evaluate(
            letters.tape, values_of(scalars), inputs_at(letters, states), len(states)
        )
        sizes = np.abs(numbers).reshape(len(states), -1, 3).max(axis=(0, 2))
        least = _FAINT * sizes.max(initial=0.0)
        return dict(zip(vectors, (sizes > least).tolist(), strict=True))

    def _find_resized(self) -> Iterator[tuple[Resized, list[Any]]]:
        """Shapes that depend on a parameter, with size and place on the tape."""
        drawn = visuals_of(self._mechanism)
        for k, body in enumerate(self._mechanism.bodies):
            solids = [v for v in drawn[body.name] if not isinstance(v.geometry, Mesh)]
            for j, visual in enumerate(solids):
                number = self._number
                place: Placement = visual.placement
                rows = zip(place.rotation, place.xyz, strict=True)
                pose = [number(entry) for row, offset in rows for entry in (*row, offset)]
                entries = [*map(number, measure(visual.geometry)[1]), *pose]
                if any(isinstance(value_of(entry), int) for entry in entries):
                    sizes = self._mechanism.evaluate_all(measure(visual.geometry)[1])
                    size = tuple(map(float, sizes))
                    yield Resized(k, j, size), entries

    def _power(self) -> Any:
        mechanism, letters, tape = self._mechanism, self._letters, self._letters.tape
        stored = stored_in_loads(mechanism)
        free = all(force.conservative or force.name in stored for force in mechanism.forces)
        if free and not is_rheonomic(mechanism):
            return 0.0
        energy = sum(self._energy(), 0.0)
        along = {q.place: value_of(r) for q, r in zip(letters.q, letters.rates, strict=True)}
        a = self._dynamics.acceleration
        along |= {v.place: value_of(x) for v, x in zip(letters.v, a, strict=True)}
        along[letters.t.place] = 1.0
        return trace(tape, push_forward(tape, [value_of(energy)], along)[0])

    def _energy(self) -> tuple[Any, Any]:
        letters = self._letters
        T, V = (trace(letters.tape, x) for x in self._dynamics.answer("energy"))
        known = {name: value_of(scalar) for name, scalar in letters.values.items()}
        for series in stored_in_loads(self._mechanism).values():
            V = V + trace(letters.tape, Lowering(series.ring, letters.tape, known)(series))
        return T, V

    def _curves(self) -> dict[str, Any]:
        """What the curves show, by their names."""
        letters, mechanism = self._letters, self._mechanism
        T, V = self._energy()
        rates = (f"{velocity}'" for velocity in mechanism.velocities)
        return {
            "energy kinetic": T,
            "energy potential": V,
            "energy total": T + V,
            "energy work": trace(letters.tape, self._work),
            **{name: trace(letters.tape, place) for name, place in self._lost.items()},
            **dict(zip(rates, self._dynamics.acceleration, strict=True)),
            **dict(zip(mechanism.velocities, letters.v, strict=True)),
            **dict(zip(mechanism.coordinates, letters.q, strict=True)),
            **self._reactions(),
            **self._actions.guide_sizes,
        }

    def _locate(self, spot: End) -> list[Any]:
        pose = self._dynamics.tree.recursion.pose(spot.body)
        return times_point(pose, [self._number(c) for c in spot.point])

    def _number(self, scalar: Any) -> Any:
        return self._letters.arithmetic(scalar, self._dynamics.tree.recursion.chart.r)


def refuse(mechanism: Mechanism) -> None:
    """Refuse a mechanism for which a page cannot have a program."""
    if mechanism.nv > MOST_VELOCITIES:
        raise DerivationError(f"a program for {mechanism.nv} velocities would be too long")
    for signal in mechanism.inputs:
        if callable(signal.signal) and not isinstance(signal.signal, ElementForce):
            raise DerivationError(f"input {signal.symbol!r} is a function of Python")


def value_at(mechanism: Mechanism, symbol: str) -> float:
    """Return the number that a parameter or a constant input has."""
    constants = {s.symbol: s.signal for s in mechanism.inputs if isinstance(s.signal, float)}
    return float(mechanism.values.get(symbol, constants.get(symbol, 0.0)))


def _duration(motion: Motion) -> float:
    """Length of a motion [s]; longer where a limit ended it, so that its page ends it too."""
    length = float(motion.t[-1] - motion.t[0])
    if not is_cut_short(motion) or length <= 0:
        return length
    # the next number of two digits
    digit = 10.0 ** (floor(log10(length)) - 1)
    return float(f"{digit * (floor(length / digit) + 1):.2g}")


SAMPLES = 100
"""Number of states at which a page's program is compared with Pinocchio."""

_SEED = 0


def computed_scene(
    motion: Motion, document: SceneText, actions: Sequence[Action], equations: Sequence[Equations]
) -> Scene:
    """Return the scene of a motion with its engine; without one, the page says why."""
    try:
        refuse(motion.mechanism)
        first = equations[0] if equations else derive(motion.mechanism)
        scene, maker = equip(motion, document, actions, first)
        verdict = add_row(document.verdict, judge_page(maker))
    except MecaniqueError as error:
        reason = f"This page shows a recorded motion and computes no other: {error}."
        scene = scene_of(motion, replace(document, recorded=reason), actions)
        return fit(scene, names_of(scene))
    return replace(scene, document=replace(scene.document, verdict=verdict))


def equip(
    motion: Motion, document: SceneText, actions: Sequence[Action], equations: Equations
) -> tuple[Scene, Maker]:
    """Return the scene of a motion with its engine, and what made it."""
    mechanism = motion.mechanism
    maker = Maker(motion, equations)
    scene = maker.thin(scene_of(motion, document, actions))
    constants = quantities_of_inputs(mechanism)
    document = replace(document, parameters=(*document.parameters, *constants))
    engine = maker.make(scene, write_python(mechanism))
    return replace(scene, engine=engine, document=document), maker


def judge_page(maker: Maker) -> CodeVerdict:
    """Run a page's program under node, or else as text in Python, and compare it with Pinocchio."""
    program = maker.proof()
    target = JavaScript() if shutil.which("node") else Python()
    return judge(program, target, cases_of(program, SAMPLES, _SEED), _SEED)


def add_row(table: VerdictTable, code: CodeVerdict) -> VerdictTable:
    """Return the verdict with a row on the page's program."""
    title = {
        "rhs": "rates of the state",
        "energy": "energies",
        "poses": "poses of bodies",
        "closure": "closure of loops",
    }
    worst_of = tuple((title[name], f"{worst:.1e}") for name, worst in code.worst.items())
    run = code.versions.get("run by", "")
    note = (
        f"The program that this page computes with was run by {run} at {code.samples} random "
        f"states (seed {code.seed}), {code.varied} of them with other parameters."
    )
    return replace(table, own=worst_of, own_note=note)


def write_python(mechanism: Mechanism) -> str:
    """Return the Python that makes a mechanism, from the catalogue or the page's URDF."""
    if is_known(mechanism.name):
        known = load(mechanism.name)
        if tuple(known.coordinates) == tuple(mechanism.coordinates):
            values = {
                symbol: value
                for symbol, value in mechanism.values.items()
                if not np.isclose(value, known.values.get(symbol, np.nan), rtol=1e-15, atol=0)
            }
            changed = "".join(f", {symbol}={value!r}" for symbol, value in values.items())
            return f'mq.textbook.load("{mechanism.name}"{changed})'
    return f'mq.read_urdf("{mechanism.name}.urdf")'
