"""Sentences on the rod pendulum, sections 1.3.1 to 1.3.4."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from mecanique.derivation.methods import derivations
from mecanique.derivation.scalars.elementary import sin
from mecanique.derivation.scalars.series import Kind, Series
from mecanique.derivation.symbolic.newton_euler import NewtonEuler
from mecanique.derivation.symbolic.vectors import along
from mecanique.derivation.symbolic.virtual_work import VirtualWork
from mecanique.textbook import load
from mecanique.textbook.register.row import Row, decision, identity, misprint

_LEDGER = "the ledger of virtual work of the pendulum in the catalogue"


def rows() -> Iterator[Row]:
    """Yield the rows of the sections."""
    yield _unit_vectors()
    yield from _unknowns()
    yield _same_as_1_19()
    yield from _working()
    yield _absent()


def _unit_vectors() -> Row:
    from sympy import Function, Matrix, Symbol, cos, sin

    q = Function("q")(Symbol("t"))
    n, t = Matrix([sin(q), -cos(q), 0]), Matrix([cos(q), sin(q), 0])
    k = n.cross(t)
    spin = q.diff() * k
    return identity(
        "before 1.14",
        "k = n × t completes a right-handed basis, the rod turns with omega = q' k, and a unit "
        "vector u that turns with it has the rate omega × u",
        "n and t of the hanging rod, differentiated",
        *(k - Matrix([0, 0, 1])),
        *(n.diff() - spin.cross(n)),
        *(t.diff() - spin.cross(t)),
        *(n.diff() - q.diff() * t),
    )


def _unknowns() -> Iterator[Row]:
    bodies = NewtonEuler(load("rigid_bar_pendulum"))
    (cut,) = bodies.cuts.bodies
    found = along(cut.axes.rows, bodies.balances.resultant(cut))
    sides = (found[0], found[1])
    yield decision(
        "after 1.14",
        "the two equations 1.14 hold three unknowns, R_n, R_t and q",
        "letters of reactions in the forces on the rod, which turn with q",
        _names(sides, Kind.REACTION) == {"R_pin_n", "R_pin_t"},
        all(each.diff("q") for each in sides),
    )
    reactions = list(bodies.derivation().reactions.values())
    motions = _names(reactions, Kind.VELOCITY) | _names(reactions, Kind.ACCELERATION)
    yield decision(
        "after 1.20",
        "once q(t) is known the reactions follow from the balance of linear momentum",
        "the closed forms of R_n and R_t hold q, q' and q'' and no other unknown",
        len(reactions) == 2,
        not _names(reactions, Kind.REACTION),
        motions == {"q'", "q''"},
    )


def _same_as_1_19() -> Row:
    ring = NewtonEuler(load("rigid_bar_pendulum")).algebra.ring
    l, g, q, a = (ring[name] for name in ("l", "g", "q", "q''"))
    equation = a + 3 * g * sin(q) / (2 * l)
    return misprint(
        "after 1.26",
        "eq. 1.26 is said to be identical to eq. 1.19, and sect. 1.3.4 takes the motion from it",
        "the two left sides against each other",
        [a - 3 * g * sin(q) / (2 * l) - equation],
        [a + 3 * g * sin(q) / (2 * l) - equation],
        right="eq. 1.26 with a plus sign is; the motion follows from eq. 1.19",
        proof="with the printed sign q = 0 repels, with that of eq. 1.19 it is stable",
    )


def _working() -> Iterator[Row]:
    work = VirtualWork(load("rigid_bar_pendulum"))
    ring = work.balances.algebra.ring
    l, dq = ring["l"], ring["δq"]
    found: dict[str, Series] = {}
    for stage in work.derivation().stages:
        for result in stage.results:
            if not isinstance(result.left, Series):
                found[result.left.quantity] = result.right
    yield identity(
        "before 1.27 b",
        "the reactions do no work, nor do the parts of weight and inertia forces along the rod",
        _LEDGER,
        *(found[name] for name in ("δW_R_pin", "δr_weight_rod_n", "δr_inertia_rod_n")),
    )
    yield identity(
        "after 1.27 b",
        "the points of action move by l dq/2 and 2 l dq/3 along the tangents",
        _LEDGER,
        found["δr_weight_rod_t"] - l * dq / 2,
        found["δr_inertia_rod_t"] - 2 * l * dq / 3,
    )


def _absent() -> Row:
    """Return the row on reactions, which only some methods show."""
    absent, present = [], []
    for name in ("rigid_bar_pendulum", "two_blocks", "double_pendulum"):
        found = derivations(load(name))
        absent += [not _names(found[k].rows, Kind.REACTION) for k in ("virtual_work", "lagrange")]
        balances = next(s for s in found["newton_euler"].stages if s.title.endswith("forces"))
        sides = [result.right for result in balances.results]
        present.append(bool(_names(sides, Kind.REACTION)))
    return decision(
        "sect. 1.3.4",
        "constraint forces stand in the balances of Newton and Euler, and in no equation of "
        "virtual work or Lagrange",
        "letters in the derivations of three systems",
        *absent,
        *present,
    )


def _names(series: Iterable[Series], kind: Kind) -> set[str]:
    return {g.name for each in series for g in each.generators() if g.kind is kind}
