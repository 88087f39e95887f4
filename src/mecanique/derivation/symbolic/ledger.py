"""Keep a ledger of virtual work: each force on a body, its virtual displacement and its work."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from typing import NamedTuple, final

from mecanique.derivation.scalars.cancel import tidy
from mecanique.derivation.scalars.generators import Kind
from mecanique.derivation.scalars.series import Series
from mecanique.derivation.symbolic.derivation import Left, Result
from mecanique.derivation.symbolic.free_bodies.balances import FreeBodies
from mecanique.derivation.symbolic.free_bodies.bodies import Cut
from mecanique.derivation.symbolic.free_bodies.distribution import distribution_of
from mecanique.derivation.symbolic.steps.operator import coordinate_of
from mecanique.derivation.symbolic.symbols import Algebra
from mecanique.derivation.symbolic.vectors import Vector, along, cross, total


class _Letters(NamedTuple):
    """The letters of a force or couple, of its virtual displacement and of its work."""

    act: str
    move: str
    work: str


_FORCE = _Letters("F", "δr", "δW")
_COUPLE = _Letters("C", "δφ", "δW_couple")


@final
class Displacements:
    """The virtual displacements δq of a mechanism, at fixed time.

    Args:
        algebra: the mechanism's symbols.
    """

    def __init__(self, algebra: Algebra) -> None:
        self.ring = algebra.ring
        self.names = tuple(f"δ{coordinate_of(v)}" for v in algebra.velocities)
        self.deltas = [self.ring.unknown(name, Kind.VARIATION) for name in self.names]
        self.meanings: dict[str, str] = {}
        """The meaning of each, by its name."""
        for name, v in zip(self.names, algebra.velocities, strict=True):
            q = coordinate_of(v)
            of = f"that belongs to the velocity {v}" if q == v else f"of {q}"
            meaning = f"virtual displacement {of}: small, arbitrary, at fixed time"
            self.meanings[name] = meaning

    def vary(self, velocity: Vector) -> Vector:
        """Return the virtual displacement that belongs to a velocity: Σ ∂v/∂q' δq."""
        partials = self.ring.partials
        return Vector(*(self.sum(partials(component)) for component in velocity)).tidy()

    def sum(self, slopes: Sequence[Series]) -> Series:
        """Return Σ ∂v/∂q' δq for the slopes ∂v/∂q' of a component."""
        pairs = zip(slopes, self.deltas, strict=True)
        return self.ring.sum([slope * delta for slope, delta in pairs if slope])

    def coefficients(self, works: Sequence[Series]) -> list[Series]:
        """Return the coefficient of each virtual displacement in a sum of works."""
        factors, _ = self.ring.sum(list(works)).linear(self.names)
        return [tidy(factor) for factor in factors]


@final
class Ledger:
    """The virtual work of all forces on the bodies of a mechanism, body by body.

    Args:
        balances: the bodies cut free.
        displacements: the mechanism's virtual displacements.
    """

    def __init__(self, balances: FreeBodies, displacements: Displacements) -> None:
        self.cuts = balances.cuts
        self.displacements = displacements
        self._ring = balances.algebra.ring
        acting = {(cut.body, one.name) for cut in self.cuts.bodies for one in cut.applied}
        self._acting = Counter(name for _, name in acting)
        self.inertia: list[Series] = []
        """The work of the inertia forces of each body entered so far."""
        self.weights: list[Series] = []
        self.loads: list[Series] = []

    def enter(self, cut: Cut) -> list[Result]:
        """Enter a body: return the work of weight, inertia forces and loads, entry by entry."""
        lines: list[Result] = []
        zero, body = self._ring.number(0), cut.body
        rotation = self.displacements.vary(cut.spin)
        at_center = self.displacements.vary(cut.center_velocity)
        if cut.inert:
            if any(cut.weight):
                work = self._force(lines, f"weight_{body}", cut, cut.weight, at_center)
                self.weights.append(work)
            seat, couple = self._seat_of_inertia(cut)
            shift = at_center if seat is None else seat
            work = self._force(lines, f"inertia_{body}", cut, -cut.push, shift, known=True)
            work = work + self._turn(lines, f"inertia_{body}", cut, couple, rotation, known=True)
            self.inertia.append(work)
        for one in cut.applied:
            if one.ties:  # where bodies touch or are joined, both points move alike
                continue
            work = zero
            name = f"{one.name}_{body}" if self._acting[one.name] > 1 else one.name
            if any(one.force):
                shift = self.displacements.vary(one.velocity)
                work = work + self._force(lines, name, cut, one.force, shift)
            if any(one.moment):
                work = work + self._turn(lines, name, cut, one.moment, rotation)
            self.loads.append(work)
        return lines

    def locate(self, cut: Cut) -> str:
        """Return a sentence that says where weight and inertia forces act."""
        if not cut.inert:
            return ""
        if self._seat_of_inertia(cut)[0] is not None:
            weight = "The weight acts at the center of mass, t" if any(cut.weight) else "T"
            where = f"where their resultant acts, at the distance s_{cut.body}"
            return f" {weight}he inertia forces {where}."
        both = "Weight and inertia forces act" if any(cut.weight) else "The inertia forces act"
        return f" {both} at the center of mass."

    def _seat_of_inertia(self, cut: Cut) -> tuple[Vector | None, Vector]:
        """Return the virtual displacement of the point where a rod's inertia forces act.

        Also return their couple about that point; for other bodies None and the couple about the
        center of mass.
        """
        spread, couple = distribution_of(self.cuts, cut), couple_of_inertia(cut)
        if spread is None:
            return None, couple
        points = {point for point in spread.point if point is not None}
        if len(points) != 1:
            return None, couple
        (s,) = points
        arm = spread.direction * (s - spread.length / 2)
        left = (couple + cross(arm, cut.push)).tidy()
        if any(left):
            return None, couple
        return self.displacements.vary(total([cut.center_velocity, cross(cut.spin, arm)])), left

    def _force(
        self,
        lines: list[Result],
        name: str,
        cut: Cut,
        force: Vector,
        displacement: Vector,
        *,
        known: bool = False,
    ) -> Series:
        """Enter a force, unless it is listed already, with its displacement and work."""
        if not any(force):
            return self._ring.number(0)
        acts, moves = along(cut.axes.rows, force), along(cut.axes.rows, displacement)
        named = zip(cut.axes.labels, acts, moves, strict=True)
        return _enter(lines, _FORCE, name, named, known=known)

    def _turn(
        self,
        lines: list[Result],
        name: str,
        cut: Cut,
        couple: Vector,
        rotation: Vector,
        *,
        known: bool = False,
    ) -> Series:
        """Enter a couple, unless it is listed already, with its rotation and work."""
        if not any(couple):
            return self._ring.number(0)
        acts, moves = along(cut.axes.turns, couple), along(cut.axes.turns, rotation)
        named = zip(cut.axes.turn_labels, acts, moves, strict=True)
        return _enter(lines, _COUPLE, name, named, known=known)


def couple_of_inertia(cut: Cut) -> Vector:
    """Return the couple of the inertia forces about the center of mass."""
    return (cross(cut.center, cut.push) - cut.turning).tidy()


def _enter(
    lines: list[Result],
    letters: _Letters,
    name: str,
    components: Iterable[tuple[str, Series, Series]],
    *,
    known: bool,
) -> Series:
    """Write one entry of the ledger and return its work."""
    products = []
    for label, act, move in components:
        products.append(act * move)
        if act:
            if not known:
                lines.append(Result(Left(join_words(letters.act, name, label)), act))
            lines.append(Result(Left(join_words(letters.move, name, label)), move))
    work = tidy(products[0].ring.sum(products))
    lines.append(Result(Left(f"{letters.work}_{name}"), work))
    return work


def join_words(*words: str) -> str:
    """Join words with underscores into a name, leaving out empty ones."""
    return "_".join(filter(None, words))
