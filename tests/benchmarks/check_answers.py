"""Right and wrong answers on textbook systems, made by SymPy alone: nothing of the search is used.

A right answer is the system's equations of motion rewritten; a wrong one has one mistake of a known
kind put into a term or into the Lagrangian before it is rewritten.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field
from functools import cache
from typing import Any, final

import numpy as np
import sympy as sp

import mecanique as mq

SYSTEMS = (
    "acrobot",
    "atwood_machine",
    "bead_on_hoop",
    "base_excited_mass",
    "cart_pole",
    "compound_pendulum",
    "crane",
    "double_atwood_machine",
    "double_pendulum",
    "elastic_pendulum",
    "free_planar_body",
    "furuta_pendulum",
    "gyroscope",
    "heavy_top",
    "kapitza_pendulum",
    "kepler_orbit",
    "particle_on_circle_x",
    "rigid_bar_pendulum",
    "rotating_plate",
    "screw_press",
    "simple_pendulum",
    "spherical_pendulum",
    "swinging_atwood_machine",
    "two_blocks",
    "two_link_arm",
)
"""Systems whose equations are written in letters."""


@final
@dataclass(frozen=True)
class Answer:
    """A submitted text and what is known of it.

    Args:
        system: name of the textbook system.
        text: the equations.
        how: how they were rewritten.
        mistake: kind of the mistake put in; empty if there is none.
        let: definitions that come with it.
    """

    system: str
    text: str
    how: str
    mistake: str = ""
    let: tuple[str, ...] = field(default=())


@final
class Problem:
    """A system's equations of motion in SymPy.

    Args:
        name: of the textbook system.
    """

    def __init__(self, name: str) -> None:
        self.name = name
        self.mechanism = mq.textbook.load(name)
        derived = mq.derive(self.mechanism)
        names = self.mechanism.velocities
        self.q = [sp.Symbol(name) for name in self.mechanism.coordinates]
        self.v = [sp.Symbol(name) for name in names]
        self.a = [sp.Symbol(f"{name}'") for name in names]
        self.M, self.h, self.Q = derived.M, derived.h, derived.Q
        self.rows = [sp.expand(entry) for entry in self.M * sp.Matrix(self.a) + self.h - self.Q]
        self.units = {p.symbol: p.unit for p in self.mechanism.parameters}
        self.angles = [q for q in self.q if any(row.has(sp.sin(q), sp.cos(q)) for row in self.rows)]

    @property
    def letters(self) -> list[Any]:
        """Every symbol of the rows, sorted."""
        return sorted(set().union(*(row.free_symbols for row in self.rows)), key=str)

    def accelerations(self, rows: list[Any], seed: int = 0) -> Any:
        """Return accelerations that rows demand at some states with random parameters."""
        draw = np.random.default_rng(seed)
        symbols = [s for s in self.letters if s not in self.a]
        J = sp.Matrix(rows).jacobian(self.a)
        rest = sp.Matrix(rows).subs(dict.fromkeys(self.a, 0))
        missing = set(rest.free_symbols | J.free_symbols) - set(symbols)
        symbols += sorted(missing, key=str)
        both = sp.lambdify(symbols, [J, rest], "numpy", cse=True)
        found = []
        for _ in range(5):
            mass, force = both(*draw.uniform(0.4, 1.9, len(symbols)))
            try:
                found.append(np.linalg.solve(np.array(mass, float), -np.array(force, float)))
            except np.linalg.LinAlgError:
                return None
        return np.array(found)


@cache
def problem(name: str) -> Problem:
    """Return a system's equations, derived once."""
    return Problem(name)


def plain(rows: list[Any], draw: random.Random) -> str:
    """Write rows as SymPy prints them, with terms moved over the sign of equality."""
    lines = []
    for row in rows:
        terms = list(sp.Add.make_args(row))
        draw.shuffle(terms)
        cut = draw.randint(0, min(2, len(terms) - 1))
        left = sp.Add(*terms[cut:], evaluate=False) if terms[cut:] else sp.Integer(0)
        right = sp.Add(*[-term for term in terms[:cut]])
        lines.append(f"{left} = {right}")
    return "\n".join(lines)


def latex(rows: list[Any], draw: random.Random) -> str:
    """Write rows in LaTeX."""
    names = {}
    for symbol in set().union(*(row.free_symbols for row in rows)):
        stem = str(symbol).rstrip("'")
        dots = len(str(symbol)) - len(stem)
        written = sp.latex(sp.Symbol(stem))
        if dots:
            base, _, below = written.partition("_")
            written = f"\\{'d' * dots}ot{{{base}}}" + (f"_{below}" if below else "")
        names[symbol] = written
    lines = [f"{sp.latex(row, symbol_names=names)} &= 0" for row in rows]
    return "\\begin{aligned}\n" + " \\\\\n".join(lines) + "\n\\end{aligned}"


def sympy_text(rows: list[Any], draw: random.Random) -> str:
    """Write rows with functions of time and Derivative."""
    t = sp.Symbol("t")
    moved = {}
    for symbol in set().union(*(row.free_symbols for row in rows)):
        stem = str(symbol).rstrip("'")
        dots = len(str(symbol)) - len(stem)
        if dots:
            moved[symbol] = sp.Derivative(sp.Function(stem)(t), (t, dots))
    return "\n".join(f"Eq({row.subs(moved)}, 0)" for row in rows)


PRINTERS: tuple[Callable[[list[Any], random.Random], str], ...] = (plain, latex, sympy_text)


def rewritings(
    it: Problem, rows: list[Any], draw: random.Random
) -> Iterator[tuple[str, list[Any]]]:
    """Yield rows in many forms, by SymPy's own functions."""
    n = len(rows)
    yield "expanded", [sp.expand(row) for row in rows]
    yield "collected", [sp.collect(sp.expand(row), [*it.a, *it.v]) for row in rows]
    yield "factored", [sp.factor(row) for row in rows]
    yield "expanded angles", [sp.expand_trig(row) for row in rows]
    yield "sums of angles", [_sums(row) for row in rows]
    letters = [sp.Symbol(name) for name in it.units if sp.Symbol(name) in it.letters]
    for _ in range(4):
        factor = sp.Rational(draw.randint(1, 9), draw.randint(1, 9)) * draw.choice((-1, 1))
        for letter in draw.sample(letters, min(2, len(letters))):
            factor *= letter ** draw.choice((-2, -1, 1, 2))
        yield "scaled", [sp.expand(row * factor) for row in rows]
    if n > 1:
        order = draw.sample(range(n), n)
        yield "another order", [rows[k] for k in order]
        for _ in range(2):
            mixed = list(rows)
            i, k = draw.sample(range(n), 2)
            mixed[i] = mixed[i] + draw.choice((2, -3, sp.cos(it.q[0]), letters[0])) * mixed[k]
            yield "combined", mixed
    if n <= 2:
        J = sp.Matrix(rows).jacobian(it.a)
        rest = sp.Matrix(rows).subs(dict.fromkeys(it.a, 0))
        if J.det() != 0:
            solved = J.adjugate() * -rest / J.det()
            yield "solved", [a - entry for a, entry in zip(it.a, solved, strict=True)]
            yield (
                "solved and divided",
                [a - sp.together(sp.expand(entry)) for a, entry in zip(it.a, solved, strict=True)],
            )


def _sums(row: Any) -> Any:
    from sympy.simplify.fu import TR8

    return TR8(sp.expand(row))


def other_coordinates(it: Problem, rows: list[Any]) -> Iterator[tuple[str, list[Any], str]]:
    """Yield rows in coordinates of which one is a sum or a difference, with its definition."""
    if len(it.q) != len(it.v) or len(it.angles) < 2:
        return
    one, other = it.angles[:2]
    i, k = it.q.index(one), it.q.index(other)
    for sign, written in ((1, "+"), (-1, "-")):
        moved = {}
        for family, dots in ((it.q, ""), (it.v, "'"), (it.a, "''")):
            moved[family[k]] = sp.Symbol(f"psi0{dots}") - sign * family[i]
        rewritten = [row.subs(moved, simultaneous=True) for row in rows]
        yield "other coordinates", rewritten, f"psi0 = {other} {written} {one}"


def right_answers(
    per_system: int, seed: int = 0, systems: Sequence[str] = SYSTEMS
) -> Iterator[Answer]:
    """Yield right answers on every system."""
    draw = random.Random(seed)
    for name in systems:
        it = problem(name)
        made = 0
        forms: list[tuple[str, list[Any], tuple[str, ...]]]
        forms = [(how, rows, ()) for how, rows in rewritings(it, it.rows, draw)]
        forms += [(how, rows, (let,)) for how, rows, let in other_coordinates(it, it.rows)]
        while made < per_system:
            for how, rows, let in forms:
                if made == per_system:
                    break
                scaled = [row * draw.choice((1, 2, -1, sp.Rational(1, 3))) for row in rows]
                if draw.random() < 0.5:
                    draw.shuffle(scaled)
                text = PRINTERS[made % len(PRINTERS)](scaled, draw)
                made += 1
                yield Answer(name, text, how, "", tuple(let))


MISTAKES = (
    "sign",
    "missing",
    "doubled",
    "halved",
    "sin for cos",
    "small angle",
    "letter",
    "angle",
    "units",
    "potential sign",
    "half",
    "rate constant",
    "centripetal",
    "free length",
    "linearized",
)


def wrong_answers(
    per_system: int, seed: int = 1, systems: Sequence[str] = SYSTEMS
) -> Iterator[Answer]:
    """Yield answers with one mistake each, that give another motion than the right one."""
    draw = random.Random(seed)
    for name in systems:
        it = problem(name)
        right = it.accelerations(it.rows)
        made = tries = 0
        while made < per_system and tries < 12 * per_system:
            tries += 1
            kind = MISTAKES[tries % len(MISTAKES)]
            rows = inject(it, kind, draw)
            if rows is None:
                continue
            found = it.accelerations(rows)
            if found is None or np.abs(found - right).max() < 1e-6 * np.abs(right).max():
                continue
            if kind != "units":
                rows = [sp.expand(row) for row in rows]
                if draw.random() < 0.3:
                    rows = [sp.collect(row, it.a) for row in rows]
                rows = [row * draw.choice((1, 2, -1, sp.Rational(1, 3))) for row in rows]
            made += 1
            text = PRINTERS[made % len(PRINTERS)](rows, draw)
            yield Answer(name, text, "", kind)


def inject(it: Problem, kind: str, draw: random.Random) -> list[Any] | None:
    """Return rows with one mistake, or None if there is no place for it."""
    if kind in ("potential sign", "half", "rate constant", "centripetal", "free length"):
        return _in_lagrangian(it, kind)
    if kind == "linearized":
        return _linearize(it)
    rows = list(it.rows)
    k = draw.randrange(len(rows))
    terms = list(sp.Add.make_args(rows[k]))
    place = draw.randrange(len(terms))
    term = terms[place]
    if len(terms) < 2:
        return None
    changed = _change(it, kind, term, draw)
    if changed is None:
        return None
    terms[place] = changed
    rows[k] = sp.Add(*terms)
    return rows


def _change(it: Problem, kind: str, term: Any, draw: random.Random) -> Any | None:
    simple = {"sign": -term, "missing": sp.Integer(0), "doubled": 2 * term, "halved": term / 2}
    if kind in simple:
        return simple[kind]
    circular = sorted(term.atoms(sp.sin, sp.cos), key=str)
    if kind == "sin for cos" and circular:
        one = draw.choice(circular)
        other = sp.cos if isinstance(one, sp.sin) else sp.sin
        return term.subs(one, other(one.args[0]))
    if kind == "small angle":
        sines = [one for one in circular if isinstance(one, sp.sin) and one.args[0] in it.angles]
        return term.subs(sines[0], sines[0].args[0]) if sines else None
    if kind == "letter":
        held = [s for s in sorted(term.free_symbols, key=str) if str(s) in it.units]
        pairs = []
        for symbol in held:
            unit = it.units[str(symbol)]
            others = [sp.Symbol(n) for n, u in it.units.items() if u == unit and n != str(symbol)]
            pairs += [(symbol, other) for other in others if other in it.letters]
        return term.subs(*draw.choice(pairs)) if pairs else None
    if kind == "angle" and len(it.angles) > 1:
        angular = [one for one in circular if one.args[0].free_symbols <= set(it.angles)]
        if not angular:
            return None
        one, (first, second) = draw.choice(angular), it.angles[:2]
        choices = [first, second, first + second, first - second]
        other = draw.choice([c for c in choices if sp.expand(c**2 - one.args[0] ** 2) != 0])
        return term.subs(one, one.func(other))
    if kind == "units":
        held = [s for s in sorted(term.free_symbols, key=str) if str(s) in it.units]
        held = [s for s in held if it.units[str(s)] not in ("1", "rad")]
        if not held:
            return None
        return term * draw.choice(held) ** draw.choice((1, -1))
    return None


def _in_lagrangian(it: Problem, kind: str) -> list[Any] | None:
    """Lagrange's operator on SymPy's T and V, with a mistake in them or in the operator."""
    if any(len(family) != len(it.q) for family in (it.v, it.a)):
        return None
    T = sp.expand((sp.Matrix(it.v).T * it.M * sp.Matrix(it.v))[0] / 2)
    if kind == "free length":
        if it.name != "elastic_pendulum":
            return None
        return [row.subs(sp.Symbol("l0"), 0) for row in it.rows]
    if any(row.has(sp.Symbol("t")) for row in it.M):
        return None
    rows = []
    velocity_free = [row.subs(dict.fromkeys([*it.v, *it.a], 0)) for row in it.rows]
    others = []
    for i in range(len(it.q)):
        momentum = sp.diff(T, it.v[i])
        rate = sum(
            (
                sp.diff(momentum, q) * v + sp.diff(momentum, v) * a
                for q, v, a in zip(it.q, it.v, it.a, strict=True)
            ),
            sp.Integer(0),
        )
        others.append(sp.expand(it.rows[i] - velocity_free[i] - rate + sp.diff(T, it.q[i])))
        if kind == "rate constant":
            rate = sum(
                (sp.diff(momentum, v) * a for v, a in zip(it.v, it.a, strict=True)), sp.Integer(0)
            )
        slope = sp.Integer(0) if kind == "centripetal" else sp.diff(T, it.q[i])
        rows.append(rate - slope)
    factor = {"potential sign": -1, "half": 2}.get(kind, 1)
    if factor != 1 and "g" not in map(str, it.letters):
        return None
    out = []
    for i, row in enumerate(rows):
        gravity = velocity_free[i].coeff(sp.Symbol("g"), 1) * sp.Symbol("g")
        out.append(row + others[i] + velocity_free[i] + (factor - 1) * gravity)
    return out


def _linearize(it: Problem) -> list[Any] | None:
    still = dict.fromkeys([*it.q, *it.v, *it.a], 0)
    moving = [*it.q, *it.v, *it.a]
    rows = []
    for row in it.rows:
        at = row.subs(still)
        if at in (sp.nan, sp.zoo) or at.has(sp.zoo, sp.nan):
            return None
        slopes = [sp.diff(row, s).subs(still) for s in moving]
        if any(slope.has(sp.zoo, sp.nan) for slope in slopes):
            return None
        rows.append(at + sum(s * slope for s, slope in zip(moving, slopes, strict=True)))
    return rows


EXPECTED = {
    "sign": {"sign"},
    "missing": {"missing"},
    "doubled": {"factor", "half"},
    "halved": {"factor", "half"},
    "sin for cos": {"sin for cos"},
    "small angle": {"small angle"},
    "letter": {"letter"},
    "angle": {"angle"},
    "units": {"units"},
    "potential sign": {"potential sign"},
    "half": {"half", "factor"},
    "rate constant": {"rate constant"},
    "centripetal": {"missing"},
    "free length": {"free length"},
    "linearized": {"linearized"},
}
"""Kinds of causes that name a mistake rightly."""
