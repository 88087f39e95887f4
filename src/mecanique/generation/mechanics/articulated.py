"""Solve for accelerations and multipliers of a closed chain with operations in proportion to links.

From the tips to the root each subtree is described by the force that moves it, F = I A + b − Kᵀ λ,
and by its equations of loops, K A + C λ + c = 0, where A is the acceleration of the link on which
it hangs (R. Featherstone, Rigid Body Dynamics Algorithms, 2008, ch. 7; E. P. Popov, A. F.
Vereshchagin & S. L. Zenkevich, Manipulyatsionnye roboty, 1978, in the form of A. S. Sathya & J.
Carpentier, IEEE Trans. Robotics 41 (2025) 430). Joints are eliminated on the way, and so are the
multipliers of a loop, as soon as it has passed more joints than it has equations.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Any, final

import numpy as np

from mecanique.derivation.mechanics.elements import ground_of
from mecanique.derivation.mechanics.letters import Letters
from mecanique.derivation.mechanics.loops import Loops, closure
from mecanique.derivation.mechanics.recursion import TreeRecursion, World
from mecanique.derivation.mechanics.vectors import (
    Rows,
    Triple,
    add,
    cross,
    dot,
    product,
    scale,
)
from mecanique.derivation.numeric.constraints.rows import Held
from mecanique.generation.mechanics.constrained import (
    ConstrainedSolution,
    independent,
    sample,
    weakness,
)
from mecanique.model.constraints.loops import CLOSED, Loop
from mecanique.model.placement import is_zero
from mecanique.model.states import States
from mecanique.program.solving import factorize
from mecanique.program.sweeps import push_forward, substitute
from mecanique.program.tape import Value
from mecanique.program.traced import trace, value_of, values_of

Six = list[Any]
"""A twist or a wrench: three angular components, then three linear ones, in world axes."""

_STILL: Six = [0.0] * 6


@final
@dataclass(frozen=True)
class _JointStep:
    """A joint velocity that was eliminated."""

    index: int
    link: int
    motion: Six
    carried: Six  # the wrench that its unit acceleration takes
    inertia: Any
    pushed: dict[int, Any]  # the rate of each equation of loops by its unit acceleration


@final
@dataclass(frozen=True)
class _RowStep:
    """An equation of a loop that was eliminated, with its multiplier."""

    row: int
    link: int  # −1 for the ground, which does not accelerate
    direction: Six
    compliance: Any
    coupled: dict[int, Any]  # its compliance to the multipliers that are left


@final
class Articulated:
    """A tree and its independent equations of loops, factorized from the tips to the root."""

    def __init__(
        self, letters: Letters, recursion: TreeRecursion, loops: Loops, states: States
    ) -> None:
        self._letters, self._tape, self._loops = letters, letters.tape, loops
        self._kept = independent(Held(letters.mechanism).at(states).jacobian)
        self._links = recursion.links
        order = [values_of(letters.v).index(place) for place in values_of(recursion.chart.u)]
        world = World(recursion)
        motions = [world.motion(place) for place in range(len(self._links))]
        self._columns: list[dict[int, tuple[Triple, Triple]]] = []
        for motion in motions:
            self._columns.append({order[k]: column for k, column in motion.columns.items()})
        self._arms = [motion.step for motion in motions]
        self._steps: list[_JointStep | _RowStep] = []
        self._weakness: Any = 0.0
        self._eliminate(recursion)

    @property
    def pivots(self) -> list[Any]:
        """What is divided by: positive unless something without mass can move, or loops lock."""
        return [
            step.inertia if isinstance(step, _JointStep) else step.compliance
            for step in self._steps
        ]

    def solve(self, drive: list[Any]) -> ConstrainedSolution:
        """Solve for accelerations and multipliers."""
        acceleration, multipliers = self._substitute(drive, self._loops.gamma)
        entries = [multipliers.get(row, 0.0) for row in range(len(self._loops.names))]
        return ConstrainedSolution(acceleration, entries)

    def close(self, gaps: list[Any]) -> list[Any]:
        """Return the displacements of least energy that close the gaps of all rows."""
        still = [0.0] * len(self._letters.v)
        return self._substitute(still, gaps)[0]

    def firmness(self) -> Any:
        """Return a measure of regularity of the loops, zero where one locks its joints.

        Of a single loop it is that of `Constrained`. Of many it is little less than their least: a
        sum of squares over hundreds of loops would report a singular position everywhere.
        """
        if not self._kept:
            return 1.0
        root = value_of(self._weakness)
        for _ in range(2):
            root = self._tape.call("sqrt", root)
        return trace(self._tape, self._tape.divide(1.0, root))

    def _eliminate(self, recursion: TreeRecursion) -> None:
        inertias: list[Rows] = []
        for body, pose in zip(recursion.inertias, recursion.poses, strict=True):
            turned = [[*row[:3], 0.0] for row in pose]
            inertias.append(_spread(body.seen_from(turned)))
        # directions of the equations of loops on each link, by row
        directions: list[dict[int, Six]] = [{} for _ in self._links]
        loop_of = self._add_loops(recursion, directions)
        rows_of: dict[int, list[int]] = {}
        for row, loop in loop_of.items():
            rows_of.setdefault(loop, []).append(row)
        # on how many branches of the tree an equation's direction is not yet at rest
        branches = dict.fromkeys(self._kept, 0)
        for on_link in directions:
            for row in on_link:
                branches[row] += 1
        passed = dict.fromkeys(rows_of, 0)
        compliance: dict[int, dict[int, Any]] = {row: {} for row in self._kept}
        for place in range(len(self._links) - 1, -1, -1):
            inertia, active = inertias[place], directions[place]
            for index in reversed(self._columns[place]):
                step = self._pass_joint(place, index, inertia, active)
                self._steps.append(step)
                inverse = 1.0 / step.inertia
                for row, push in step.pushed.items():
                    share = push * inverse
                    for column, slope in step.pushed.items():
                        compliance[row][column] = compliance[row].get(column, 0.0) + share * slope
                    active[row] = add(active[row], scale(-1.0 * share, step.carried))
                _add_square(inertia, step.carried, -1.0 * inverse)
                for loop in {loop_of[row] for row in step.pushed}:
                    passed[loop] += 1
            for loop, rows in rows_of.items():
                here = all(row in active and branches[row] == 1 for row in rows)
                if here and passed[loop] > len(rows):
                    self._judge(rows, compliance)
                    for row in rows:
                        self._drop(row, place, inertia, active, compliance)
            parent = self._links[place].parent
            if parent >= 0:
                arm, before = self._arms[place], directions[parent]
                moved = [_refer(column, arm) for column in inertia]
                moved = [_refer(list(row), arm) for row in zip(*moved, strict=True)]
                inertias[parent] = [
                    add(*pair) for pair in zip(inertias[parent], moved, strict=True)
                ]
                for row, direction in active.items():
                    if row in before:
                        branches[row] -= 1
                    before[row] = add(before.get(row, _STILL), _refer(direction, arm))
        left = [row for row in self._kept if row in compliance]
        for loop in dict.fromkeys(loop_of[row] for row in left):
            self._judge(rows_of[loop], compliance)
        for row in left:
            self._drop(row, -1, [], {}, compliance)

    def _pass_joint(
        self, place: int, index: int, inertia: Rows, active: dict[int, Six]
    ) -> _JointStep:
        slide, axis = self._columns[place][index]
        motion = [*axis, *slide]
        carried = [dot(row, motion) for row in inertia]
        total = dot(carried, motion) + self._links[place].armature
        pushed = {row: dot(direction, motion) for row, direction in active.items()}
        pushed = {row: push for row, push in pushed.items() if not is_zero(push)}
        return _JointStep(index, place, motion, carried, total, pushed)

    def _drop(
        self,
        row: int,
        place: int,
        inertia: Rows,
        active: dict[int, Six],
        compliance: dict[int, dict[int, Any]],
    ) -> None:
        """Eliminate an equation and its multiplier, as a joint is."""
        coupled = compliance.pop(row)
        pivot = coupled.pop(row)
        direction = active.pop(row, _STILL)
        coupled = {column: slope for column, slope in coupled.items() if column in compliance}
        self._steps.append(_RowStep(row, place, direction, pivot, coupled))
        inverse = 1.0 / pivot
        for column, slope in coupled.items():
            share = slope * inverse
            for last, push in coupled.items():
                compliance[column][last] = compliance[column].get(last, 0.0) - share * push
            if place >= 0:
                before = active.get(column, _STILL)
                active[column] = add(before, scale(-1.0 * share, direction))
        if place >= 0:
            _add_square(inertia, direction, inverse)

    def _judge(self, rows: list[int], compliance: dict[int, dict[int, Any]]) -> None:
        """Note how weakly the joints that a loop has passed close it."""
        block: Rows = []
        for row in rows:
            block.append([compliance[row].get(column, 0.0) for column in rows])
        blocks = [self._loops.blocks[row] for row in rows]
        total = weakness(block, factorize(self._tape, block), blocks)
        self._weakness = self._weakness + total * total

    def _add_loops(
        self, recursion: TreeRecursion, directions: list[dict[int, Six]]
    ) -> dict[int, int]:
        """Add the directions of the equations of all loops; return the loop of each row kept."""
        loop_of: dict[int, int] = {}
        first = 0
        for k, loop in enumerate(self._letters.mechanism.loops):
            slopes = _slopes_of(loop, self._letters, recursion)
            count = len(CLOSED[loop.kind])
            for row in range(first, first + count):
                if row in self._kept:
                    loop_of[row] = k
                    for place, columns in slopes.items():
                        directions[place][row] = columns[row - first]
            first += count
        return loop_of

    def _substitute(self, drive: list[Any], gaps: list[Any]) -> tuple[list[Any], dict[int, Any]]:
        """Return a and λ with M a = drive + Jᵀ λ and J a = −gaps."""
        left = {row: gaps[row] for row in self._kept}
        biases = [_STILL] * len(self._links)
        parts: list[Any] = []
        for number, step in enumerate(self._steps):
            if isinstance(step, _JointStep):
                bias = biases[step.link]
                part = (drive[step.index] - dot(bias, step.motion)) * (1.0 / step.inertia)
                for row, push in step.pushed.items():
                    left[row] = left[row] + push * part
                biases[step.link] = add(bias, scale(part, step.carried))
            else:
                part = left[step.row] * (1.0 / step.compliance)
                for column, slope in step.coupled.items():
                    left[column] = left[column] - slope * part
                if step.link >= 0:
                    biases[step.link] = add(biases[step.link], scale(part, step.direction))
            parts.append(part)
            last = number + 1 == len(self._steps) or self._steps[number + 1].link != step.link
            parent = self._links[step.link].parent if step.link >= 0 else -1
            if last and parent >= 0:
                carried = _refer(biases[step.link], self._arms[step.link])
                biases[parent] = add(biases[parent], carried)
        a: list[Any] = [0.0] * len(drive)
        multipliers: dict[int, Any] = {}
        moved: list[Six] = [_STILL for _ in self._links]
        at = -1
        for step, part in zip(reversed(self._steps), reversed(parts), strict=True):
            if step.link != at:
                at = step.link
                parent = self._links[at].parent
                before = moved[parent] if parent >= 0 else _STILL
                # the point of the parent that is at the link's origin
                moved[at] = [*before[:3], *add(before[3:], cross(before[:3], self._arms[at]))]
            here = moved[at] if at >= 0 else _STILL
            if isinstance(step, _RowStep):
                pull = dot(step.direction, here)
                for column, slope in step.coupled.items():
                    pull = pull + slope * multipliers[column]
                multipliers[step.row] = -1.0 * (part + pull * (1.0 / step.compliance))
            else:
                held = -1.0 * dot(step.carried, here)
                for row, push in step.pushed.items():
                    held = held + push * multipliers[row]
                a[step.index] = part + held * (1.0 / step.inertia)
                moved[at] = add(here, scale(a[step.index], step.motion))
        return a, multipliers


def articulate(
    letters: Letters, recursion: TreeRecursion, loops: Loops, states: States
) -> Articulated | None:
    """Return the factors of a long chain; None where a pivot vanishes at one of the states."""
    places = values_of(letters.v)
    if {*values_of(recursion.chart.u)} != {*places}:
        return None  # joint velocities that depend on one another, or on time
    try:
        factors = Articulated(letters, recursion, loops, states)
    except ZeroDivisionError:  # a joint moves no mass, wherever it is
        return None
    (pivots,) = sample(letters, [[factors.pivots]], states)
    return factors if np.isfinite(pivots).all() and (pivots > 0).all() else None


def _slopes_of(loop: Loop, letters: Letters, recursion: TreeRecursion) -> dict[int, list[Six]]:
    """Return the derivatives of a loop's equations by the twist of each link that it joins.

    They are those of its equations in poses that are inputs of the tape, into which the poses are
    substituted: entries of two poses may be one operation.
    """
    tape = letters.tape
    seats = {body: recursion.seats[body] for body in (loop.body_a, loop.body_b)}
    places = list(dict.fromkeys(seat.place for seat in seats.values() if seat.place >= 0))
    free: dict[int, Rows] = {}
    known: dict[int, Value] = {}
    for side, place in enumerate(places):
        free[place] = []
        for i, row in enumerate(recursion.poses[place]):
            inputs = [tape.input(f"pose {side} {i}{k}") for k in range(4)]
            known |= dict(zip(inputs, values_of(row), strict=True))
            free[place].append([trace(tape, entry) for entry in inputs])

    def pose(body: str) -> Rows:
        seat = seats[body]
        return product(free[seat.place], seat.pose) if seat.place >= 0 else seat.pose

    ground = ground_of(pose, recursion.chart.r, letters.arithmetic)
    gaps = values_of(closure(loop, ground, partial(letters.call, "atan2")))
    slopes: dict[int, list[Six]] = {}
    for place in places:
        columns = []
        for axis in range(6):
            rates = _pose_rates(free[place], axis)
            moved = push_forward(tape, gaps, rates)
            columns.append([trace(tape, value) for value in substitute(tape, moved, known)])
        slopes[place] = [list(row) for row in zip(*columns, strict=True)]
    return slopes


def _pose_rates(pose: Rows, axis: int) -> dict[int, Value]:
    """Return the rates of a pose's entries in a unit twist about its origin, by their places."""
    unit = [1.0 if axis % 3 == k else 0.0 for k in range(3)]
    rates: dict[int, Value] = {}
    for column in range(4):
        entries = [row[column] for row in pose]
        if column == 3:
            moved = unit if axis >= 3 else [0.0] * 3
        else:
            moved = cross(unit, entries) if axis < 3 else [0.0] * 3
        for entry, rate in zip(entries, moved, strict=True):
            rates[entry.place] = value_of(rate)
    return rates


def _spread(body: Any) -> Rows:
    """Return the wrench of unit accelerations of a body's origin, shape (6, 6)."""
    trace_of = body.E[0][0] + body.E[1][1] + body.E[2][2]
    units = np.eye(3).tolist()
    rows: Rows = []
    for i, unit in enumerate(units):
        turned = [trace_of * x - E for x, E in zip(unit, body.E[i], strict=True)]
        rows.append([*turned, *cross(unit, body.h)])
    for unit in units:
        rows.append([*cross(body.h, unit), *scale(body.m, unit)])
    return rows


def _refer(wrench: Six, arm: list[Any]) -> Six:
    """Refer a wrench at the end of an arm to its beginning."""
    return [*add(wrench[:3], cross(arm, wrench[3:])), *wrench[3:]]


def _add_square(matrix: Rows, vector: Six, factor: Any) -> None:
    """Add a multiple of a vector's products with itself to a symmetric matrix."""
    for i, x in enumerate(vector):
        for k in range(i + 1):
            total = matrix[i][k] + factor * x * vector[k]
            matrix[i][k] = matrix[k][i] = float(total) if isinstance(total, int) else total
