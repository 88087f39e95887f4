"""Loops in letters by all methods: reactions, multipliers, independent displacements."""

from __future__ import annotations

from functools import cache

import numpy as np
import pytest
from systems import derive_system

from mecanique import Reference, textbook
from mecanique.derivation import derive
from mecanique.derivation.equations import Equations
from mecanique.derivation.methods import agreement
from mecanique.derivation.scalars.cancel import tidy
from mecanique.derivation.scalars.elementary import cos, sin
from mecanique.derivation.scalars.evaluation import Evaluation
from mecanique.derivation.scalars.series import Ring, Series
from mecanique.derivation.symbolic.derivation import Left, Result, along_displacement
from mecanique.derivation.symbolic.multipliers import independent_displacements
from mecanique.model import (
    Body,
    Loop,
    Mechanism,
    Parameter,
    Placement,
    Prismatic,
    Revolute,
    Shape,
    particle,
    rod,
)
from mecanique.model.states import States
from mecanique.verification.states import random_states

READ = [
    "slider_crank",
    "four_bar_linkage",
    "bars_and_springs_loop",
    "governor",
    "chained_four_bars",
    "squeezer",
]
"""Closed mechanisms whose derivations can be read."""

SINGLE = [name for name in READ if name != "squeezer"]
"""Those with short independent displacements."""

METHODS = ("newton_euler", "virtual_work", "lagrange")


@cache
def _derived(name: str, method: str) -> Equations:
    return derive_system(name, method)


def _values(equations: Equations, states: States) -> dict[str, np.ndarray]:
    """Values of all letters at closed states in motion, multipliers and accelerations included."""
    a = equations.acceleration(states.q, states.v, states.t)
    found = dict(states.values)
    names = equations.derivation.algebra.accelerations
    found |= dict(zip(names, np.moveaxis(a, -1, 0), strict=True))
    # M a + h − Q = Jᵀ λ, in numbers from the recursion, J in letters
    needed = equations.inverse_dynamics(states.q, states.v, a, states.t)
    ring, ties = equations.derivation.algebra.ring, equations.derivation.ties
    evaluated = Evaluation(ring, found)
    J = [[np.broadcast_to(evaluated(x), (len(a),)) for x in tie.slopes(ring)] for tie in ties]
    columns = np.moveaxis(np.array(J), -1, 0)
    for k, (slopes, side) in enumerate(zip(columns, needed, strict=True)):
        sizes = np.linalg.lstsq(slopes.T, side, rcond=None)[0]
        for tie, size in zip(ties, sizes, strict=True):
            found.setdefault(f"lambda_{tie.name}", np.zeros(len(a)))[k] = size
    return found


def _lines(equations: Equations, title: str) -> dict[str, Series]:
    """The results of a step with a letter on their left."""
    stage = next(stage for stage in equations.steps if stage.title == title)
    return {r.left.quantity: r.right for r in stage.results if isinstance(r.left, Left)}


@pytest.mark.parametrize("name", READ)
def test_all_methods_lead_to_the_same_equations(name: str) -> None:
    said = agreement(textbook.load(name))
    assert said.startswith("All three methods give the same equations of motion")


@pytest.mark.parametrize("name", ["slider_crank", "four_bar_linkage", "chained_four_bars"])
def test_reactions_in_letters_are_those_of_the_engine(name: str) -> None:
    equations = _derived(name, "newton_euler")
    mechanism = equations.mechanism
    reference = Reference(mechanism)
    states = random_states(mechanism, 3, 5, lot=8)
    values = _values(equations, states)
    evaluated = Evaluation(equations.derivation.algebra.ring, values)
    reactions = equations.derivation.reactions
    forces = {n: s for n, s in reactions.items() if n.startswith("R_") and n[-2:] in ("_x", "_z")}
    assert len(forces) >= 3
    for k in range(len(states)):
        wrenches = reference.reactions(states.q[k], states.v[k])
        for letter, series in forces.items():
            joint, axis = letter.removeprefix("R_").rsplit("_", 1)
            size = np.broadcast_to(evaluated(series), (len(states),))[k]
            expected = wrenches[joint].force["xyz".index(axis)]
            assert size == pytest.approx(expected, rel=1e-8, abs=1e-8)


@pytest.mark.parametrize("method", ["newton_euler", "lagrange"])
@pytest.mark.parametrize("name", ["slider_crank", "four_bar_linkage", "bars_and_springs_loop"])
def test_the_multipliers_are_solved_for(name: str, method: str) -> None:
    equations = _derived(name, method)
    states = random_states(equations.mechanism, 5, 8, lot=8)
    values = _values(equations, states)
    evaluated = Evaluation(equations.derivation.algebra.ring, values)
    (stage,) = (stage for stage in equations.steps if stage.title == "Multipliers")
    assert len(stage.results) == len(equations.derivation.ties)
    for result in stage.results:
        left = values[result.left.quantity] if isinstance(result.left, Left) else None
        if left is None:
            assert isinstance(result.left, Series)
            left = evaluated(result.left)
        np.testing.assert_allclose(left, evaluated(result.right), rtol=1e-8, atol=1e-8)


@pytest.mark.parametrize("name", READ)
def test_the_loops_in_motion_are_closed(name: str) -> None:
    equations = _derived(name, "newton_euler")
    states = random_states(equations.mechanism, 4, 11, lot=8)
    evaluated = Evaluation(equations.derivation.algebra.ring, _values(equations, states))
    ties = equations.derivation.ties
    lines = [r for s in equations.steps if s.title == "Loops in motion" for r in s.results]
    assert len(lines) == 2 * len(ties)
    for line in lines:
        assert isinstance(line.left, Left)
        assert line.left.primes in ("'", "''")
        np.testing.assert_allclose(evaluated(line.right), 0, rtol=0, atol=1e-10)


@pytest.mark.parametrize("name", SINGLE)
def test_independent_displacements_keep_the_loops_closed(name: str) -> None:
    derivation = _derived(name, "virtual_work").derivation
    ring = derivation.algebra.ring
    assert derivation.quasi
    for displacement in derivation.quasi:
        for tie in derivation.ties:
            assert along_displacement(displacement, tie.slopes(ring)).vanishes()


def test_displacements_satisfy_rows_whose_entries_are_not_of_size_one() -> None:
    """One row has a constant entry, the other two whose squares add up to 9."""
    ring = Ring()
    x, theta, zero = ring.coordinate("x"), ring.coordinate("theta"), ring.number(0)
    rows = [
        [ring.number(2), x, 5 * x, zero],
        [zero, 3 * cos(theta), x, 3 * sin(theta)],
    ]
    found = independent_displacements(ring, rows, 4)
    assert len(found) == 2
    for displacement in found:
        assert any(displacement)
        for row in rows:
            work = ring.sum(a * b for a, b in zip(row, displacement, strict=True))
            assert tidy(work).vanishes()


def test_virtual_displacements_are_arbitrary_without_constraints_alone() -> None:
    """Of what rolls that of x is left independent, as in the accelerations at the end."""
    disk = " ".join(_derived("rolling_disk", "virtual_work").text(steps=True).split())
    assert "virtual displacements of x, z and turn: small, at fixed time" in disk
    assert "one independent, δx; all others follow. δz = 0 δturn = δx/R" in disk
    assert "The constraints leave x free." in disk
    rods = _derived("double_pendulum", "virtual_work").text(steps=True)
    assert "displacements of q1 and q2: small, arbitrary, at fixed time" in rods
    assert "arbitrary, at fixed" not in _derived("four_bar_linkage", "virtual_work").text(
        steps=True
    )


def test_letters_of_displacements_are_not_mixed_up_with_coordinates() -> None:
    """Kepler's r has the displacement δr, so that of a point is δu; as phi has δφ, a turn is δα."""
    orbit = _derived("kepler_orbit", "virtual_work").text(steps=True)
    said = " ".join(orbit.split())
    assert "virtual displacement δu of its point: δW is the sum" in said
    assert "\n     δu_inertia_planet_x = δr\n" in orbit
    top = " ".join(_derived("heavy_top", "virtual_work").text(steps=True).split())
    assert "each couple C in the virtual rotation δα of the body: δW" in top
    assert "δα_inertia_top_y = sin(theta) δphi" in top
    rods = " ".join(_derived("double_pendulum", "virtual_work").text(steps=True).split())
    assert "of its point, each couple C in the virtual rotation δφ of the body: δW" in rods


def test_works_are_not_multiplied_out() -> None:
    """What a virtual displacement multiplies stands in brackets, in the order of its equation."""
    cart = _derived("cart_pole", "virtual_work").text(steps=True)
    assert "δW_x = -((M + m) x'' + m l cos(q) q'' - m l sin(q) q'^2 + c x' - F) δx\n" in cart
    inertia = "-(m x'' + m l cos(q) q'' - m l sin(q) q'^2) δx - (m l cos(q) x'' + m l^2 q'') δq"
    assert f"δW_inertia_pole = {inertia}\n" in cart
    bars = _derived("bars_and_springs", "virtual_work").text(steps=True)
    one_term = "k (2 l q + a sqrt(16 l^2 - q^2)) (a - rho) δq/(2 rho sqrt(16 l^2 - q^2))"
    assert f"δW_spring_B = {one_term}\n" in bars


def test_the_slider_crank_has_one_equation_without_multipliers() -> None:
    """cos(β + θ) (m1 r² θ''/3 + m1 g r cos(θ)/2) + r sin(β) m2 x'' = 0."""
    derivation = _derived("slider_crank", "virtual_work").derivation
    ring = derivation.algebra.ring
    (row,) = derivation.rows
    states = random_states(textbook.load("slider_crank"), 4, 2, lot=8)
    rng = np.random.default_rng(0)
    a = rng.normal(size=(3, len(states)))
    names = derivation.algebra.accelerations
    values = {**states.values, **dict(zip(names, a, strict=True))}
    s = values
    turn, m1, m2, r, g = s["beta"] + s["theta"], 2.0, 1.0, 0.5, 9.81
    whole = m1 * r**2 * a[0] / 3 + m1 * g * r * np.cos(s["theta"]) / 2
    expected = np.cos(turn) * whole + r * np.sin(s["beta"]) * m2 * a[2]
    np.testing.assert_allclose(Evaluation(ring, values)(row), 1.2 * expected, rtol=1e-12, atol=0)


def test_what_is_long_keeps_its_multipliers() -> None:
    equations = _derived("squeezer", "virtual_work")
    assert not equations.derivation.quasi
    assert "lambda_" in equations.text()


@pytest.mark.parametrize("kind", ["ball", "hinge", "weld", "plate", "pin", "distance"])
def test_every_kind_of_loop_is_cut_open(kind: str) -> None:
    """Off the closed position, too, as λ ∂Φ/∂q is defined there."""
    m, l = Parameter("m", 1.0, "kg"), Parameter("l", 1.0, "m")
    end = Placement((l, 0, 0), (0.0, np.pi / 2, 0.0) if kind == "hinge" else (0.0, 0.0, 0.0))
    ahead = Placement((l, 0, 0))
    mechanism = Mechanism(
        "tied",
        (Body("ground"), Body("a", rod(m, l)), Body("b", rod(m, l)), Body("c", rod(m, l))),
        (
            Revolute("A", "ground", "a", axis=(0, 0, 1)),
            Revolute("B", "a", "b", axis=(1, 0, 0), origin=Placement((0, 0, -l))),
            Revolute("C", "a", "c", axis=(0, 1, 0), origin=Placement((0, l, 0))),
        ),
        loops=(Loop("tie", kind, "b", ahead, "c", end, l if kind == "distance" else 0.0),),  # type: ignore[arg-type]  # parametrized
        parameters=(m, l),
    )
    newton = derive(mechanism, "newton_euler").derivation
    lagrange = derive(mechanism, "lagrange").derivation
    assert len(newton.ties) == len(lagrange.ties) > 0
    states = States.of(mechanism, np.random.default_rng(3).normal(size=(3, 3)), np.ones((3, 3)))
    letters = {f"lambda_{tie.name}": 0.3 + k for k, tie in enumerate(lagrange.ties)}
    letters |= {name: 0.7 * k for k, name in enumerate(lagrange.algebra.accelerations)}
    sides = []
    for derivation in (newton, lagrange):
        evaluated = Evaluation(derivation.algebra.ring, {**states.values, **letters})
        rows = derivation.rows
        balances = [result for stage in derivation.stages for result in stage.results]
        assert all(isinstance(result, Result) for result in balances)
        sides.append([np.broadcast_to(evaluated(row), (3,)) for row in rows])
    np.testing.assert_allclose(sides[0], sides[1], rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("method", METHODS)
def test_a_bead_on_a_wire_that_turns(method: str) -> None:
    """r'' = r α'² − g cos α, (J + m r²) α'' = m g r sin α − 2 m r r' α'; the wire bears the rest.

    A pin between a wire's frame and the bead leaves what is along the wire free.
    """
    m, J, g = Parameter("m", 1.3), Parameter("J", 0.7), Parameter("g", 9.81)
    stations = ("ground", "first", "second", "bead")
    axes = ((1, 0, 0), (0, 1, 0), (0, 0, 1))
    mechanism = Mechanism(
        "wire",
        (
            *(Body(name) for name in stations[:3]),
            Body("bead", particle(m)),
            Body("wire", Shape(1.0, inertia=(J, J, J, 0, 0, 0))),
        ),
        (
            *(
                Prismatic(letter, stations[k], stations[k + 1], axis=axes[k])
                for k, letter in enumerate("xyz")
            ),
            Revolute("axle", "ground", "wire", axis=(1, 0, 0), coordinate="alpha"),
        ),
        loops=(Loop("slot", "pin", "wire", Placement(), "bead", Placement()),),
        parameters=(m, J, g),
        gravity=(0, 0, -g),
    )
    r, alpha, r_rate, turn = 0.8, 0.6, -0.5, 1.7
    c, s, mass, weight = np.cos(alpha), np.sin(alpha), m.value, m.value * g.value
    along = r * turn**2 - g.value * c
    torque = weight * r * s - 2 * mass * r * r_rate * turn
    rate = torque / (J.value + mass * r * r)
    ahead, across = np.array([0, -s, c]), np.array([0, -c, -s])
    radial = (along - r * turn**2, r * rate + 2 * r_rate * turn)
    acceleration = radial[0] * ahead + radial[1] * across
    q, v = np.array([*(r * ahead), alpha]), np.array([*(r_rate * ahead + r * turn * across), turn])
    derivation = derive(mechanism, method).derivation
    values = dict(States.of(mechanism, q, v).values)
    values |= dict(zip(derivation.algebra.accelerations, [*acceleration, rate], strict=True))
    forces = [f"lambda_{tie.name}" for tie in derivation.ties]

    def rows(sizes: dict[str, float]) -> np.ndarray:
        value = Evaluation(derivation.algebra.ring, {**values, **sizes})
        return np.array([float(np.ravel(value(row))[0]) for row in derivation.rows])

    none = dict.fromkeys(forces, 0.0)
    rest = rows(none)
    columns = np.array([rows({**none, name: 1.0}) - rest for name in forces]).T
    sizes = np.linalg.lstsq(columns, -rest, rcond=None)[0] if forces else np.zeros(0)
    np.testing.assert_allclose(rest + columns @ sizes if forces else rest, 0, rtol=0, atol=1e-13)


@pytest.mark.parametrize(
    ("name", "free", "count", "line"),
    [
        ("governor", 2, "2", "δs = 2 l s sin(theta1) sin(theta2) δπ2"),
        ("snakeboard", 1, "one", "δtheta = 2 sin(phi) δπ1"),
        ("two_wheeled_cart", 3, "3", "δleft = 4 b cos(roll) δπ2"),
    ],
)
def test_rows_without_a_constant_entry_are_met_by_cramers_rule(
    name: str, free: int, count: str, line: str
) -> None:
    """Redundant ones follow; what all parts of a displacement share is divided out."""
    equations = derive_system(name, "virtual_work")
    derivation = equations.derivation
    assert len(derivation.quasi) == free
    for displacement in derivation.quasi:
        for tie in derivation.ties:
            slopes = tie.slopes(derivation.algebra.ring)
            assert along_displacement(displacement, slopes).vanishes()
    text = equations.text(steps=True)
    assert line in map(str.strip, text.splitlines())
    assert f"That leaves {count} independent, " in " ".join(text.split())
    assert "give the same equations of motion" in agreement(textbook.load(name))
