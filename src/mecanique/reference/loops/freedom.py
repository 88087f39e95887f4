"""Count degrees of freedom, and find redundant constraints and singular positions.

N is the number of velocities minus the generic rank of the constraint Jacobian. At a singular
position the rank is lower: a flat parallelogram lacks one independent row, yet has one degree of
freedom. The rank is therefore computed at a position and at assembled positions around it, by
singular values in scaled units.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import final

import numpy as np

from mecanique.arrays import Array
from mecanique.errors import ClosureError, InputError
from mecanique.model.constraints.loops import explain_lock
from mecanique.model.expression import finite
from mecanique.model.mechanism import Mechanism
from mecanique.model.mechanism.description import bodies_with_mass
from mecanique.model.states import expect_mechanism
from mecanique.model.values import Given, whole
from mecanique.reference.loops.assembly import close_position, displace, position_near
from mecanique.reference.loops.closed import Closed, load_loops
from mecanique.reference.loops.closures import ScaledClosure
from mecanique.reference.loops.nullspace import Split, split
from mecanique.reference.tolerances import INDEPENDENT_ROW, RANK_ASSEMBLED
from mecanique.wording import Legible, say_count, write_table

_AROUND = 8
"""Number of nearby positions that are examined."""

_AWAY = 0.1
"""Their distance, in characteristic lengths or radians."""


@final
@dataclass(frozen=True, repr=False)
class Freedom(Legible):
    """The degrees of freedom of a mechanism; its text states how they are counted.

    Args:
        coordinates: number of velocities of the tree.
        constraints: number of scalar constraint equations of the loops.
        rank: number of independent equations in generic positions.
        redundant: names of the dependent ones, "loop: row"; without them nothing moves more freely.
        singular: whether the given position is singular: fewer equations are independent there
            than around it, or it is the only possible position although their rank there would
            allow small motions.
        rank_here: number of independent equations at the given position.
        q: shape (nq,), that position.
        bodies: number of bodies with mass that are not fixed, and whether all are particles.
        velocity_rows: number of independent equations that restrict velocities but no positions:
            of rolling along a plane, of blades and of velocity constraints.

    Example:
        >>> freedom = mq.degrees_of_freedom(mq.textbook.load("four_bar_linkage"))
        >>> freedom.N, freedom.rank
        (1, 2)
        >>> print(freedom)
        N = 3 velocities - 2 independent constraint equations (of 2) = 1; as 6 n - b of 3 rigid
        bodies: b = 17 restraints
    """

    coordinates: int
    constraints: int
    rank: int
    redundant: tuple[str, ...]
    singular: bool
    rank_here: int
    q: Array
    bodies: tuple[int, bool]
    velocity_rows: int = 0

    @property
    def positions(self) -> int:
        """The number n of independent coordinates; greater than N with nonholonomic constraints."""
        return self.N + self.velocity_rows

    @property
    def N(self) -> int:
        """The number of degrees of freedom, i.e. of independent velocities."""
        return self.coordinates - self.rank

    def __str__(self) -> str:
        text = f"N = {say_count(self.coordinates, 'velocity', 'velocities')}"
        if self.constraints:
            independent = say_count(self.rank, "independent constraint equation")
            text += f" - {independent} (of {self.constraints})"
        text += f" = {self.N}"
        if self.velocity_rows:
            text += (
                f"; {(k := self.rank - self.velocity_rows)} of the equations "
                f"restrict{'s' if k == 1 else ''} positions, {self.velocity_rows} velocities "
                f"alone: {say_count(self.positions, 'independent position')}"
            )
        count, particles = self.bodies
        if count:
            b, per_body = (3 if particles else 6) * count - self.N, "3 n_p" if particles else "6 n"
            things = ("particle",) if particles else ("rigid body", "rigid bodies")
            text += f"; as {per_body} - b of {say_count(count, *things)}: "
            text += f"b = {say_count(b, 'restraint')}"
        if self.redundant:
            text += f"; redundant: {', '.join(self.redundant)}"
        if self.singular:
            here = say_count(self.rank_here, "equation is", "equations are")
            text += f"; singular position: only {here} independent there"
        if not self.N:
            text += "; locked: nothing can move"
        return text

    def _repr_html_(self) -> str:
        rows = [
            ("velocities of the tree", str(self.coordinates)),
            ("constraint equations", str(self.constraints)),
            ("of them independent", str(self.rank)),
            ("degrees of freedom N", str(self.N)),
        ]
        if self.redundant:
            rows.append(("redundant", ", ".join(self.redundant)))
        return write_table(str(self), [("", "number"), *rows])


def degrees_of_freedom(
    mechanism: Mechanism, q: Given = None, *, t: float = 0.0, seed: int = 0
) -> Freedom:
    """Count the degrees of freedom; find redundant constraints and whether a position is singular.

    Args:
        mechanism: any mechanism.
        q: shape (nq,), or by coordinate name, the position, which is assembled first.
        t: time [s], for prescribed motions.
        seed: of the random positions around it.

    Returns:
        Their number N, and how it is counted.

    Raises:
        ClosureError: if the loops cannot be closed.
        InputError: if the position is invalid.
        UnknownNameError: if a name is not that of a coordinate.

    Example:
        >>> mq.degrees_of_freedom(mq.textbook.load('slider_crank')).N
        1
    """
    given, t = expect_mechanism(mechanism).position(q), finite(t, "time t")
    seed = whole(seed, "seed", 0)
    if not mechanism.constrained:
        return Freedom(
            coordinates=mechanism.nv,
            constraints=0,
            rank=0,
            redundant=(),
            singular=False,
            rank_here=0,
            q=given,
            bodies=_count_heavy(mechanism),
        )
    closed = load_loops(mechanism)
    none_held = np.zeros(mechanism.nv, dtype=bool)
    return freedom_of(closed, position_near(closed, q, given, t, none_held), t, seed=seed)


def freedom_of(closed: Closed, q: Array, t: float, *, seed: int = 0) -> Freedom:
    """Return the degrees of freedom of a mechanism with loops at an assembled position."""
    mechanism = closed.mechanism
    here = _scale(closed, q, t)
    rank_here = _split(here).rank
    around = [_scale(closed, near, t) for near in _sample_around(closed, q, here, t, seed)]
    # the highest rank at any position decides; without others nearby, q is the only position
    best = max([here, *around], key=lambda closure: _split(closure).rank)
    rank = _split(best).rank
    singular = rank_here < rank
    redundant = _name_redundant(best, closed.closures.names)
    if not around and rank_here < mechanism.nv:
        # small motions seem possible, but no finite one is
        rank, singular, redundant = mechanism.nv, True, ()
    of_positions = _split(best, closed.closures.positional).rank
    return Freedom(
        coordinates=mechanism.nv,
        constraints=len(here.gaps),
        rank=rank,
        redundant=redundant,
        singular=singular,
        rank_here=rank_here,
        q=q,
        bodies=_count_heavy(mechanism),
        velocity_rows=max(rank - of_positions, 0),
    )


def generic_rank(closed: Closed, q: Array, t: float) -> int:
    """Return the rank of the constraints at generic positions near one."""
    here = _scale(closed, q, t)
    rank = _split(here).rank
    if rank == min(here.jacobian.shape):
        return rank
    freedom = freedom_of(closed, q, t)
    if freedom.singular and not freedom.N:
        raise InputError(explain_lock(closed.mechanism.name))
    return freedom.rank


def refuse_locked(closed: Closed, t: float) -> bool:
    """Refuse a mechanism whose loops lock it or cannot be closed; say if it begins singular.

    It begins where its loops are closed next to the neutral position.
    """
    neutral, none_held = closed.mechanism.neutral(), np.zeros(closed.mechanism.nv, dtype=bool)
    q = position_near(closed, None, neutral, t, none_held)
    return _split(_scale(closed, q, t)).rank < generic_rank(closed, q, t)


def _count_heavy(mechanism: Mechanism) -> tuple[int, bool]:
    """Return the number of bodies with mass that are not fixed, and whether all are particles."""
    heavy = bodies_with_mass(mechanism)
    particles = bool(heavy) and not any(
        mechanism.evaluate(entry) for body in heavy for entry in body.inertia
    )
    return len(heavy), particles


def _scale(closed: Closed, q: Array, t: float) -> ScaledClosure:
    return closed.closures.scale(q, np.zeros(closed.mechanism.nv), t)


def _split(closure: ScaledClosure, rows: Array | slice = slice(None)) -> Split:
    """Split the directions of motion at a position that was assembled."""
    return split(
        closure.jacobian[rows],
        RANK_ASSEMBLED,
        RANK_ASSEMBLED,
        rounding=lambda: closure.rounding[rows],
    )


def _sample_around(
    closed: Closed, q: Array, here: ScaledClosure, t: float, seed: int
) -> list[Array]:
    """Return assembled positions near q, displaced along its free directions."""
    random = np.random.default_rng(seed)
    free = _split(here).null
    around = []
    for k in range(_AROUND if free.shape[1] else 0):
        direction = free @ random.normal(size=free.shape[1])
        direction *= _AWAY * 0.8**k / float(np.abs(direction).max())
        start = displace(closed, q, closed.closures.columns * direction)
        try:
            near = close_position(closed, start, t)
        except ClosureError:
            continue
        gap = float(np.abs(near - q).max())
        if gap > 0.2 * float(np.abs(start - q).max()):
            around.append(near)
    return around


def _name_redundant(closure: ScaledClosure, names: tuple[str, ...]) -> tuple[str, ...]:
    """Return the names of rows that depend on those before them."""
    J = closure.jacobian
    redundant, basis = [], np.zeros((0, J.shape[1]))
    size = max(float(np.abs(J).max(initial=0.0)), RANK_ASSEMBLED)
    for row, rounding, name in zip(J, closure.rounding, names, strict=True):
        rest = row - basis.T @ (basis @ row)
        rest -= basis.T @ (basis @ rest)
        length = float(np.linalg.norm(rest))
        if length > max(INDEPENDENT_ROW * size, rounding):
            basis = np.vstack([basis, rest / length])
        else:
            redundant.append(name)
    return tuple(redundant)
