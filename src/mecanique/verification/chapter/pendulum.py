"""Sections 1.3.1 and 1.3.2: the rod pendulum by Newton and Euler and by d'Alembert's principle."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import final

from mecanique.derivation.methods import derivations
from mecanique.derivation.scalars.cancel import tidy
from mecanique.derivation.scalars.elementary import cos, sin
from mecanique.derivation.scalars.series import Kind, Series
from mecanique.derivation.symbolic.newton_euler import NewtonEuler
from mecanique.derivation.symbolic.vectors import along
from mecanique.derivation.symbolic.virtual_work import VirtualWork, distribution_of
from mecanique.textbook import entry, load
from mecanique.verification.chapter.row import ChapterRow, agreement, decision, identity, misprint
from mecanique.verification.facts import Bench

_BY = "the derivation of the pendulum in the catalogue, term by term"


def rows() -> Iterator[ChapterRow]:
    """Yield the rows of the sections, in components along n (from the pin) and t (across)."""
    rod = _Rod()
    yield from _balances(rod)
    yield from _distributed_forces(rod)
    yield from _virtual_work(rod)


@final
class _Rod:
    """The rod, cut free, and its equation of motion as the catalogue derives it."""

    def __init__(self) -> None:
        work = VirtualWork(load("rigid_bar_pendulum"))
        self.ledger = {stage.title: stage.results for stage in work.derivation().stages}
        self.bodies = work.balances
        (self.cut,) = self.bodies.cuts.bodies
        self.ring = self.bodies.algebra.ring
        self.letters = tuple(self.ring[name] for name in ("m", "l", "g", "q", "q'", "q''"))
        m, l, g, q, _, a = self.letters
        self.row = NewtonEuler(work.algebra.mechanism, work.algebra).derivation().rows[0]
        self.equation = a + 3 * g * sin(q) / (2 * l)
        self.difference = self.equation - 3 * self.row / (m * l**2)
        """Zero, if the derived equation is that of the book."""
        spread = distribution_of(self.bodies.cuts, self.cut)
        assert spread is not None
        self.spread = spread


def _balances(rod: _Rod) -> Iterator[ChapterRow]:
    """Newton and Euler's equations, and the motion near rest."""
    bodies, cut, row = rod.bodies, rod.cut, rod.row
    m, l, g, q, v, a = rod.letters
    axes, turns = cut.axes.rows, cut.axes.turns
    Rn, Rt = rod.ring["R_pin_n"], rod.ring["R_pin_t"]
    a_C = bodies.cuts.kinematics.change(cut.twist.force, cut.carrier)
    r_n, r_t, *_ = along(axes, cut.center)
    v_n, v_t, *_ = along(axes, cut.twist.force)
    a_n, a_t, *_ = along(axes, a_C)
    yield identity(
        "1.14 a",
        "r_C = (l/2) n, v_C = (l/2) q' t, a_C = -(l/2) q'² n + (l/2) q'' t",
        _BY,
        *(r_n - l / 2, r_t),
        *(v_n, v_t - l / 2 * v),
        *(a_n + l / 2 * v**2, a_t - l / 2 * a),
    )
    p_n, p_t, *_ = along(axes, cut.push.force)
    F_n, F_t, *_ = along(axes, bodies.acting(cut).force)
    yield identity(
        "1.14",
        "m a_C = (m g cos q - R_n) n + (R_t - m g sin q) t",
        _BY,
        *(p_n + m * l / 2 * v**2, p_t - m * l / 2 * a),
        *(F_n - (m * g * cos(q) - Rn), F_t - (Rt - m * g * sin(q))),
    )
    H_rate = along(turns, cut.about_reference(cut.push).moment)[2]
    M_o = along(turns, bodies.acting(cut).moment)[2]
    yield _angular_momentum(H_rate - m * l**2 / 3 * a)
    yield identity("1.16", "dH_o/dt = (m l²/3) q''", _BY, H_rate - m * l**2 / 3 * a)
    yield identity(
        "1.17",
        "(m l²/3) q'' = -(l/2) m g sin q",
        _BY,
        M_o + l / 2 * m * g * sin(q),
        H_rate - M_o - row,
    )
    yield identity("1.18", "q'' + (3 g/(2 l)) sin q = 0", _BY, rod.difference)
    yield identity("1.19", "the same equation of motion", _BY, rod.difference)
    yield _linearize()


def _distributed_forces(rod: _Rod) -> Iterator[ChapterRow]:
    """D'Alembert's forces along the rod, in balance with weight and reaction."""
    bodies, row = rod.bodies, rod.row
    m, l, g, q, v, a = rod.letters
    spread, mu = rod.spread, m / l
    s = rod.ring[spread.coordinate]
    yield identity(
        "1.23 a",
        "a = -s q'² n + s q'' t along the rod",
        "d'Alembert's distributed forces found from the poses",
        mu * s * v**2 - spread.density[0],
        -mu * s * a - spread.density[1],
    )
    yield identity(
        "1.23",
        "R_t - (1/2)(mu l q'') l - m g sin q = 0",
        "the reaction eliminated from the balances",
        bodies.reactions["R_pin_t"] - mu * l * a * l / 2 - m * g * sin(q),
    )
    yield identity(
        "1.24",
        "R_n - (1/2)(mu l q'²) l - m g cos q = 0",
        "the reaction eliminated from the balances",
        bodies.reactions["R_pin_n"] - mu * l * v**2 * l / 2 - m * g * cos(q),
    )
    moments = -(l / 2) * m * g * sin(q) - 2 * l / 3 * mu * l * a * l / 2
    yield identity("1.25", "-(l/2) m g sin q - (2 l/3)(1/2)(mu l q'') l = 0", _BY, moments + row)
    # eq. 1.25 times −3/(m l²) is the right form, and the derived equation times 3/(m l²) as well
    yield misprint(
        "1.26",
        "printed: q'' - (3/2)(g/l) sin q = 0, said to be identical to 1.19",
        "the printed left side against the derived equation of motion",
        [tidy(a - 3 * g * sin(q) / (2 * l) - 3 * row / (m * l**2))],
        [rod.equation + 3 * moments / (m * l**2), rod.difference],
        right="q'' + (3/2)(g/l) sin(q) = 0",
        proof="eq. 1.25 divided by -m l²/3 gives the plus sign, as eqs. 1.18 and 1.19 have it",
    )


def _virtual_work(rod: _Rod) -> Iterator[ChapterRow]:
    """The virtual work of the same forces."""
    row, spread, ledger = rod.row, rod.spread, rod.ledger
    m, l, g, q, _, a = rod.letters
    dq = rod.ring["δq"]
    dW = ledger["Sum of the virtual work"][0].right
    yield identity(
        "1.27",
        "virtual work: dW_int = dW_ext, here both zero along the motion",
        _BY,
        dW + row * dq,
        *(result.right for result in ledger["Virtual work of the reactions"]),
    )
    yield identity(
        "1.27 a",
        "the resultant of the triangular distribution is m l q''/2, at 2 l/3 from o",
        "the distribution integrated over the rod, and its moment about o",
        spread.resultant[1] + m * l * a / 2,
        spread.point[1] - 2 * l / 3,
    )
    yield identity(
        "1.27 b",
        "dW_ext = -(m g sin q)(l/2) dq - (m l q''/2)(2 l/3) dq "
        "= -(m g (l/2) sin q + m l² q''/3) dq",
        "the ledger of virtual work",
        -(m * g * sin(q)) * (l / 2 * dq) - (m * l * a / 2) * (2 * l / 3 * dq) - dW,
        dW + (m * g * l / 2 * sin(q) + m * l**2 / 3 * a) * dq,
    )
    yield identity(
        "1.27 c",
        "m l² q''/3 + m g (l/2) sin q = 0",
        _BY,
        m * l**2 / 3 * a + m * g * l / 2 * sin(q) - row,
    )


def _angular_momentum(rate: object) -> ChapterRow:
    from sympy import integrate, symbols

    s, mu, l, v, m = symbols("s mu l q' m", positive=True)
    whole = integrate(s**2 * v * mu, (s, 0, l))
    return identity(
        "1.15",
        "H_o = ∫ s² q' mu ds = mu l³ q'/3 = m l² q'/3",
        "the integral of s² q' mu over the rod, and the derivation's rate of it",
        whole - mu * l**3 / 3 * v,
        whole.subs(mu, m / l) - m * l**2 / 3 * v,
        rate,
    )


def _linearize() -> ChapterRow:
    bench = Bench(entry("rigid_bar_pendulum"), {"l": 1.7}, "derive", 1, 0)
    return agreement(
        "1.20",
        "linearized: q'' + (3 g/(2 l)) q = 0",
        "the natural frequency of the linearized pendulum against sqrt(3 g/(2 l))",
        (bench.squares({}) ** 0.5, [(3 * 9.81 / (2 * 1.7)) ** 0.5]),
    )


_LEDGER = "the ledger of virtual work of the pendulum in the catalogue"


def sentences() -> Iterator[ChapterRow]:
    """Yield the rows of the sections."""
    yield _unit_vectors()
    yield from _unknowns()
    yield _same_as_1_19()
    yield from _working()
    yield _absent()


def _unit_vectors() -> ChapterRow:
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


def _unknowns() -> Iterator[ChapterRow]:
    bodies = NewtonEuler(load("rigid_bar_pendulum"))
    (cut,) = bodies.cuts.bodies
    components = along(cut.axes.rows, bodies.balances.acting(cut).force)
    sides = (components[0], components[1])
    yield decision(
        "after 1.14",
        "the two equations 1.14 hold three unknowns, R_n, R_t and q",
        "letters of reactions in the forces on the rod, which turn with q",
        _names(sides, Kind.REACTION) == {"R_pin_n", "R_pin_t"},
        all(side.diff("q") for side in sides),
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


def _same_as_1_19() -> ChapterRow:
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


def _working() -> Iterator[ChapterRow]:
    work = VirtualWork(load("rigid_bar_pendulum"))
    ring = work.balances.algebra.ring
    l, dq = ring["l"], ring["δq"]
    quantities: dict[str, Series] = {}
    for stage in work.derivation().stages:
        for result in stage.results:
            if not isinstance(result.left, Series):
                quantities[result.left.quantity] = result.right
    yield identity(
        "before 1.27 b",
        "the reactions do no work, nor do the parts of weight and inertia forces along the rod",
        _LEDGER,
        *(quantities[name] for name in ("δW_R_pin", "δr_weight_rod_n", "δr_inertia_rod_n")),
    )
    yield identity(
        "after 1.27 b",
        "the points of action move by l dq/2 and 2 l dq/3 along the tangents",
        _LEDGER,
        quantities["δr_weight_rod_t"] - l * dq / 2,
        quantities["δr_inertia_rod_t"] - 2 * l * dq / 3,
    )


def _absent() -> ChapterRow:
    """Return the row on reactions, which only some methods show."""
    absent, present = [], []
    for name in ("rigid_bar_pendulum", "two_blocks", "double_pendulum"):
        by_method = derivations(load(name))
        absent += [
            not _names(by_method[k].rows, Kind.REACTION) for k in ("virtual_work", "lagrange")
        ]
        balances = next(s for s in by_method["newton_euler"].stages if s.title.endswith("forces"))
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
    return {g.name for row in series for g in row.generators() if g.kind is kind}
