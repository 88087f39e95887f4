"""Solve for the forces of guiding elements on a tape: cords, belts, gears, racks and loops.

T_k is the total wrench across joint k, and S_kj balances the unit force j on all bodies beyond it.
The joint transmits nothing along its own directions n: n·T_k + Σ f_j n·S_kj = 0 for each direction
that the coordinate map drives. These are more equations than forces, but consistent; they are
solved by least squares.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from typing import Any, TypeAlias, final

from mecanique.derivation.mechanics.elements import UnitForce, unit_forces
from mecanique.derivation.mechanics.forces import AppliedWrench
from mecanique.derivation.mechanics.letters import Letters
from mecanique.derivation.mechanics.recursion import TreeRecursion
from mecanique.derivation.mechanics.vectors import add, apply, dot, products, scale
from mecanique.model.constraints.elements import force_names, preloads
from mecanique.model.expression import Scalar
from mecanique.program.solving import factorize

Transmit: TypeAlias = Callable[[Sequence[AppliedWrench]], Mapping[str, AppliedWrench]]
"""Returns the actions of joints on their children under forces on the bodies."""


@final
class Guides:
    """The elements of a mechanism."""

    def __init__(self, letters: Letters, recursion: TreeRecursion, transmit: Transmit) -> None:
        self._letters, self._recursion, self._transmit = letters, recursion, transmit
        self._names = force_names(letters.mechanism.elements)

    def sizes(self, acting: Sequence[AppliedWrench]) -> list[Any]:
        """Return the magnitude of each force."""
        if not self._names:
            return []
        totals = self._along(acting)
        rows = []
        for k in range(len(self._names)):
            unit = [self._act(each) for each, _ in self._pairs if each.index == k]
            rows.append(self._along(unit))
        for one in preloads(self._letters.mechanism.elements):
            totals = [*totals, -1.0 * self._number(one.total)]
            rows = [[*row, float(k in one.forces)] for k, row in enumerate(rows)]
        missing = [-dot(row, totals) for row in rows]
        return factorize(self._letters.tape, products(rows, rows)).solve(missing)

    def actions(self, sizes: Mapping[str, Any]) -> list[AppliedWrench]:
        """Return the actions of the elements on the bodies."""
        found: list[AppliedWrench] = []
        for unit, pressing in self._pairs:
            size = sizes[self._names[unit.index]]
            action = self._act(unit)
            force, moment = scale(size, action.force), scale(size, action.moment)
            if pressing is not None:
                strength = self._letters.call("Abs", size)
                force = add(force, scale(strength, pressing.force))
            found.append(replace(action, force=force, moment=moment))
        return found

    @cached_property
    def _pairs(self) -> list[tuple[UnitForce, UnitForce | None]]:
        """Pair each unit force with the separating force at the same point, if any."""
        units = unit_forces(self._letters.mechanism, self._recursion.ground)
        following = zip(units, [*units[1:], None], strict=True)
        return [
            (unit, after if after is not None and after.pressed else None)
            for unit, after in following
            if not unit.pressed
        ]

    def _act(self, unit: UnitForce) -> AppliedWrench:
        name = self._names[unit.index]
        return AppliedWrench(name, "reaction", unit.body, unit.point, unit.force, unit.moment)

    def _along(self, acting: Sequence[AppliedWrench]) -> list[Any]:
        """Return the joints' wrenches along the directions in which the map drives them."""
        recursion, found = self._recursion, list[Any]()
        crossing = self._transmit(acting)
        for joint in self._letters.mechanism.tree:
            if not joint.velocities:
                continue
            place = recursion.seats[joint.child].place
            link, turn = recursion.links[place], [row[:3] for row in recursion.poses[place]]
            for k in link.columns:
                if all(isinstance(entry, float) and not entry for entry in recursion.chart.G[k]):
                    continue
                parts = (link.linear.get(k), link.angular.get(k))
                vectors = (crossing[joint.name].force, crossing[joint.name].moment)
                pairs = zip(parts, vectors, strict=True)
                found.append(sum((dot(apply(turn, n), x) for n, x in pairs if n), 0.0))
        return found

    def _number(self, scalar: Scalar) -> Any:
        return self._letters.arithmetic(scalar, self._recursion.chart.r)
