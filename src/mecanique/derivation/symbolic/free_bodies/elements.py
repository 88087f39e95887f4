"""Solve for the forces of guiding elements (cords, gears …) in closed form."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from itertools import combinations
from typing import final

from mecanique.derivation.scalars.cancel import tidy
from mecanique.derivation.scalars.generators import Kind
from mecanique.derivation.scalars.series import Series
from mecanique.derivation.symbolic.free_bodies.bodies import Cut, Cuts
from mecanique.derivation.symbolic.free_bodies.elimination import JointRate, demands
from mecanique.derivation.symbolic.vectors import Wrench, cross, dot, lift, total, zero
from mecanique.derivation.tree.elements import Ground, UnitForce, unit_forces
from mecanique.model.constraints.cords import Belt, Cord
from mecanique.model.constraints.elements import preloads
from mecanique.model.constraints.gears import Gear, Rack
from mecanique.model.expression import Scalar
from mecanique.model.mechanism import Mechanism

_MOST = 3
"""Systems with more unknown forces than this are solved in numbers only."""


@final
class Guiding:
    """The unknown forces of a mechanism's elements, and their actions on its bodies.

    Args:
        cuts: the bodies.
    """

    def __init__(self, cuts: Cuts) -> None:
        self._cuts = cuts
        self._algebra = cuts.algebra
        mechanism, ring = self._algebra.mechanism, self._algebra.ring
        self.names = _list_names(mechanism)
        self.meanings = dict(zip(self.names, _list_meanings(mechanism), strict=True))
        """The meaning of each unknown, by its name."""
        self.symbols = [ring.unknown(name, Kind.REACTION) for name in self.names]
        self._units = unit_forces(mechanism, self._ground()) if mechanism.elements else []
        self.pressing: dict[int, Series] = {}
        """The separating force |F| sin α of meshing wheels, by index of F."""
        for index, name in enumerate(self.names):
            mine = [unit for unit in self._units if unit.pressed and unit.index == index]
            if any(any(unit.force) for unit in mine):
                stem = name.partition("_")[2]
                self.pressing[index] = ring.unknown(f"N_{stem}", Kind.REACTION)
                self.meanings[f"N_{stem}"] = f"separating force, |{name}| sin(pressure angle) [N]"

    def on(self, cut: Cut, sizes: Sequence[Series] | None = None) -> Wrench:
        """Return the elements' wrench on a body, about the origin of its frame.

        Args:
            cut: the body.
            sizes: magnitudes of the forces; by default their symbols.
        """
        pressing = self.pressing if sizes is None else {}
        sizes = self.symbols if sizes is None else sizes
        nothing = zero(self._algebra.ring)
        found = [Wrench(nothing, nothing)]
        for unit in self._units:
            size = pressing.get(unit.index) if unit.pressed else sizes[unit.index]
            if unit.body == cut.body and size:
                one = self._wrench(cut, unit)
                found.append(Wrench(one.force * size, one.moment * size))
        return Wrench(
            total([one.force for one in found]), total([one.moment for one in found])
        ).tidy()

    def _balance_on(self, cut: Cut, sizes: Sequence[Series]) -> Wrench:
        return -self.on(cut, sizes)

    def acting_on(self, cut: Cut) -> list[str]:
        """Return the names of the forces that act on a body."""
        found: dict[str, None] = {}
        for unit in self._units:
            if unit.body == cut.body and not unit.pressed:
                found[self.names[unit.index]] = None
            elif unit.body == cut.body and unit.index in self.pressing:
                found[str(self.pressing[unit.index])] = None
        return list(found)

    def balance_units(self) -> list[dict[str, Wrench]]:
        """Return the wrenches of the joints that balance each unit force, by name of the child."""
        ring = self._algebra.ring
        found = []
        for k in range(len(self.names)):
            unit = [ring.number(int(i == k)) for i in range(len(self.names))]
            found.append(demands(self._cuts, partial(self._balance_on, sizes=unit)))
        return found

    def balance_pressing(self) -> list[tuple[Series, dict[str, Wrench]]]:
        """Return each separating force with the joints' wrenches that balance one unit of it."""
        ring = self._algebra.ring

        def apart(cut: Cut, index: int) -> Wrench:
            nothing = zero(ring)
            parts = [
                self._wrench(cut, unit)
                for unit in self._units
                if unit.pressed and unit.index == index and unit.body == cut.body
            ]
            whole = Wrench(
                total([nothing, *(part.force for part in parts)]),
                total([nothing, *(part.moment for part in parts)]),
            )
            return -whole

        return [
            (size, demands(self._cuts, partial(apart, index=index)))
            for index, size in self.pressing.items()
        ]

    def solve(
        self,
        rates: Sequence[JointRate],
        totals: Mapping[str, Wrench],
        carried: Sequence[Mapping[str, Wrench]],
    ) -> list[Series] | None:
        """Solve for the forces in closed form; return None if there is no short one.

        Args:
            rates: the joint velocities along which joints transmit only the forces of rotors.
            totals: total wrenches across the joints.
            carried: wrenches of the joints under unit forces.
        """
        count = len(self.names)
        rows = []
        for rate in rates:
            row = [tidy(dot(rate.axis, each[rate.body].part(rate.kind))) for each in carried]
            known = tidy(dot(rate.axis, totals[rate.body].part(rate.kind)) + rate.rotor)
            if any(row):
                rows.append(([-c for c in row], known))
        algebra, ring = self._algebra, self._algebra.ring
        for one in preloads(algebra.mechanism.elements):
            together = [ring.number(int(k in one.forces)) for k in range(count)]
            rows.append((together, algebra.series(one.total)))
        if not 0 < count <= _MOST or len(rows) < count:
            return None
        # take the shortest equations that determine the forces
        rows.sort(key=lambda each: sum(map(len, (*each[0], each[1]))))
        for chosen in combinations(rows, count):
            determinant = tidy(_expand([row for row, _ in chosen]))
            if not determinant.vanishes():
                break
        else:
            return None
        forces = []
        for k in range(count):
            swapped = [[*row[:k], known, *row[k + 1 :]] for row, known in chosen]
            forces.append(tidy(tidy(_expand(swapped)) / determinant))
        return forces

    def _wrench(self, cut: Cut, unit: UnitForce) -> Wrench:
        """Refer a unit force to the origin of a body's frame, in the axes of its carrier."""
        kinematics, ring = self._cuts.kinematics, self._algebra.ring
        point, force, moment = (lift(ring, part) for part in (unit.point, unit.force, unit.moment))
        seat = kinematics.point(cut.body, (0.0, 0.0, 0.0))
        about = total([moment, cross(point - seat, force)])
        here = kinematics.carrier(cut.body)
        parts = (kinematics.between(part, -1, here) for part in (force, about))
        return Wrench(*parts).tidy()

    def _ground(self) -> Ground:
        kinematics, algebra = self._cuts.kinematics, self._algebra
        return Ground(
            point=lambda body, point: [*kinematics.point(body, point)],
            turn=kinematics.pose,
            scalar=algebra.series,
            root=algebra.root,
            wave=self._wave,
            ratio=_divide,
        )

    def _wave(self, angle: Scalar) -> tuple[Series, Series]:
        """Return cosine and sine of a pressure angle, with 1 for the sine that N contains."""
        algebra = self._algebra
        value = algebra.mechanism.evaluate(angle)
        if not value:
            return algebra.ring.number(1), algebra.ring.number(0)
        from sympy import cos, sympify

        return algebra.series(cos(sympify(angle))), algebra.ring.number(1)


def _divide(a: Series, b: Series) -> Series:
    """Return a quotient, exact where it is 0 or ±1."""
    a, b = tidy(a), tidy(b)
    if not a or a in (b, -b):
        size = 1 if a else 0
        return a.ring.number(size if a == b else -size)
    return tidy(a / b)


def _expand(rows: Sequence[Sequence[Series]]) -> Series:
    if len(rows) == 1:
        return rows[0][0]
    first, *rest = rows
    terms = []
    for k, entry in enumerate(first):
        if entry:
            minor = _expand([[*row[:k], *row[k + 1 :]] for row in rest])
            terms.append(entry * minor * (-1 if k % 2 else 1))
    return first[0].ring.sum(terms) if terms else first[0].ring.number(0)


def _list_names(mechanism: Mechanism) -> list[str]:
    """Name the unknown forces."""
    found = []
    for element in mechanism.elements:
        for name in element.forces:
            row = name.rpartition(": ")[2]
            if isinstance(element, (Cord, Belt)):
                found.append(f"T_{name}")
            elif isinstance(element, (Gear, Rack)):
                found.append(f"F_{name}")
            else:
                found.append(f"{'M' if row.startswith('r') else 'R'}_{element.name}_{row}")
    return found


def _list_meanings(mechanism: Mechanism) -> list[str]:
    """Return the meanings of the unknown forces, with units."""
    found = []
    for element in mechanism.elements:
        if isinstance(element, (Cord, Belt)):
            stops = element.stops
            for part in dict.fromkeys(element.parts):
                places = [k for k, other in enumerate(element.parts) if other == part]
                start, end = stops[places[0]].body, stops[places[-1] + 1].body
                found.append(f"tension of {element.name} from {start} to {end} [N]")
            continue
        if isinstance(element, (Gear, Rack)):
            a, b = (mechanism.joint(name).child for name in element.joints)
            found.append(f"force of {a} on {b} in {element.name} along the line of action [N]")
            continue
        for name in element.forces:
            row = name.rpartition(": ")[2]
            what = "moment" if row.startswith("r") else "force"
            axis = "along its length" if row == "length" else f"along {row[-1]} of its frame"
            unit = "N·m" if what == "moment" else "N"
            found.append(
                f"{what} that {element.body_a} exerts on {element.body_b} in {element.name}, "
                f"{axis} [{unit}]"
            )
    return found
