"""Lagrange's equations in Poisson series equal the numeric ones and print as in a textbook."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from derivation_reading import residual, value_of_text
from derivation_samples import sample
from sympy import diff
from systems import FREE, derive_system

from mecanique import textbook
from mecanique.derivation import derive
from mecanique.derivation.equations import Equations
from mecanique.derivation.printing.writers import Text
from mecanique.derivation.scalars.cancel import without_common_divisor
from mecanique.derivation.scalars.evaluation import Evaluation
from mecanique.derivation.symbolic.lagrange import Lagrange
from mecanique.derivation.symbolic.result import INTEGRALS
from mecanique.derivation.symbolic.symbols import Algebra
from mecanique.errors import DerivationError
from mecanique.model import (
    Body,
    Coordinates,
    Mechanism,
    Prismatic,
    Revolute,
    coordinate,
    particle,
    time,
)
from mecanique.model.expression import evaluate
from mecanique.model.states import States

READABLE = ("planar", "rheonomic", "three_dimensional", "functions", "free")
NAMES = (*FREE, *READABLE)


@cache
def equations_of(name: str) -> Equations:
    return derive(sample(name)) if name in READABLE else derive_system(name)


def around_start(name: str, mechanism: Mechanism, n: int = 4) -> States:
    """Return random states that are valid and in which the closed form's assumptions hold."""
    rng = np.random.default_rng(5)
    start = mechanism.position(None if name in READABLE else textbook.entry(name).start)
    q = start + 0.05 * rng.normal(size=(n, mechanism.nq))
    return States.of(mechanism, q, rng.normal(size=(n, mechanism.nv)), rng.normal(size=n))


def numbers(equations: Equations, some: States, a: np.ndarray) -> dict[str, Any]:
    """Return the value of every symbol in print, roots and derivatives of inputs included."""
    derivation = equations.derivation
    values = {**some.values, **dict(zip(derivation.algebra.accelerations, a.T, strict=True))}
    for signal in equations.mechanism.inputs:
        if f"{signal.symbol}''" in {g.name for g in derivation.algebra.ring.generators}:
            rate = diff(signal.signal, time())
            values[f"{signal.symbol}'"] = evaluate(rate, values)
            values[f"{signal.symbol}''"] = evaluate(diff(rate, time()), values)
    ring = derivation.algebra.ring
    evaluation = Evaluation(ring, values)
    for index, atom in ring.atoms.items():
        if atom.named:
            values[ring.generators[index].name] = evaluation(ring[ring.generators[index].name])
    return values


@pytest.mark.parametrize("name", NAMES)
def test_the_ring_gives_what_the_recursion_gives(name: str) -> None:
    equations = equations_of(name)
    mechanism = equations.mechanism
    assert equations.symbolic, equations.why_not
    derivation, some = equations.derivation, around_start(name, mechanism)
    assert all(equations.holds(q, float(t)) for q, t in zip(some.q, some.t, strict=True))
    value = Evaluation(derivation.algebra.ring, numbers(equations, some, np.zeros_like(some.v)))

    def array(series: Any) -> np.ndarray:
        return np.stack([np.broadcast_to(value(s), len(some)) for s in series], axis=-1)

    M = np.stack([array(row) for row in derivation.M], axis=-2)
    expected = equations.mass_matrix(some.q, some.t)
    scale = max(1.0, float(np.abs(expected).max()))
    np.testing.assert_allclose(M, expected, rtol=0, atol=1e-12 * scale)
    for got, wanted in (
        (array(derivation.h), equations.bias(some.q, some.v, some.t)),
        (array(derivation.Q), equations.forces(some.q, some.v, some.t)),
    ):
        np.testing.assert_allclose(
            got, wanted, rtol=0, atol=1e-12 * max(scale, float(np.abs(wanted).max()))
        )


@pytest.mark.parametrize("name", NAMES)
def test_printed_equations_read_back_are_the_derivation(name: str) -> None:
    equations = equations_of(name)
    mechanism = equations.mechanism
    some = around_start(name, mechanism)
    values = numbers(equations, some, np.random.default_rng(6).normal(size=some.v.shape))
    value = Evaluation(equations.derivation.algebra.ring, values)
    for row, equation in zip(equations.derivation.rows, equations.equations, strict=True):
        printed = residual(equation.text(), values) * value(equation.divisor)
        derived = value(without_common_divisor(row))
        size = sum(np.abs(values[a]).max() for a in equations.derivation.algebra.accelerations)
        np.testing.assert_allclose(printed, derived, rtol=1e-11, atol=1e-11 * max(1.0, float(size)))


@pytest.mark.parametrize("name", NAMES)
def test_every_step_reads_back(name: str) -> None:
    equations = equations_of(name)
    mechanism = equations.mechanism
    some = around_start(name, mechanism)
    values = numbers(equations, some, np.random.default_rng(7).normal(size=some.v.shape))
    value = Evaluation(equations.derivation.algebra.ring, values)
    lines = [
        line.strip() for line in equations.text(steps=True).splitlines() if line.startswith("     ")
    ]
    # the constant energy may stand with the result
    constants = [step for step in equations.steps if step.title in INTEGRALS]
    results = [line for step in equations.steps if step not in constants for line in step.results]
    last = []
    for result in (line for step in constants for line in step.results):
        letter = result.write(Text()).partition(" = ")[0]
        last.append((result, next(line for line in lines if line.startswith(f"{letter} = "))))
        lines.remove(last[-1][1])
    assert len(lines) >= len(results) + len(equations.equations)
    for result, line in (*zip(results, lines, strict=False), *last):
        left, right = line.split(" = ", 1)
        printed = value_of_text(right, values)
        derived = value(result.right)
        values.setdefault(left, derived)  # a later line may be in it, as gamma = -alpha
        np.testing.assert_allclose(
            printed, derived, rtol=1e-11, atol=1e-11 * max(1.0, float(np.abs(derived).max()))
        )


@pytest.mark.parametrize(("most", "refused"), [(3, True), (4, False)])
def test_terms_of_kinetic_energies_are_counted_together(most: int, *, refused: bool) -> None:
    """Four sleds side by side, whose energies have one term each."""
    names = [f"sled{k}" for k in range(4)]
    bodies = (Body("ground"), *(Body(name, particle(1.0)) for name in names))
    rails = tuple(Prismatic(f"{name}_x", "ground", name, axis=(1, 0, 0)) for name in names)
    algebra = Algebra(Mechanism("sleds", bodies, rails))
    algebra.ring.most_terms = most
    if refused:
        with pytest.raises(DerivationError, match="the kinetic energy has more than 3 terms, too"):
            Lagrange(algebra.mechanism, algebra)
    else:
        assert len(Lagrange(algebra.mechanism, algebra).T) == 4


@pytest.mark.parametrize("name", ["rigid_bar_pendulum", "spherical_pendulum"])
def test_half_moments_times_squares_of_a_body_about_a_fixed_point_are_its_energy(name: str) -> None:
    lagrange = Lagrange(textbook.load(name))
    ((body, T),) = lagrange.kinetic
    squares = lagrange.squares[body]
    assert squares
    assert (2 * T - lagrange.algebra.ring.sum([I * w * w for I, w in squares])).vanishes()


@pytest.mark.parametrize("ratios", [(0.3, 0.25), (0.25, 0.3), (0.5, 0.75)])
def test_joints_turn_by_any_ratios_of_one_angle(ratios: tuple[float, float]) -> None:
    """Of sines and cosines of q/20 for 0.3 q and q/4, in either order."""
    bobs = [Body(name, particle(1.3).at((0, 0, -0.7))) for name in "ab"]
    pins = [Revolute(f"pin_{n}", "ground", n, axis=(0, -1, 0), coordinate=n) for n in "ab"]
    turned = {name: ratio * coordinate("q") for name, ratio in zip("ab", ratios, strict=True)}
    mechanism = Mechanism(
        "pair", (Body("ground"), *bobs), (*pins,), coordinates=Coordinates(("q",), turned)
    )
    lagrange, at = Lagrange(mechanism), {"q": 0.9, "q'": -1.7}
    value = Evaluation(lagrange.algebra.ring, at)
    falls = -1.3 * 9.81 * 0.7 * sum(np.cos(ratio * 0.9) for ratio in ratios)
    assert value(lagrange.V) == pytest.approx(falls, rel=1e-13)
    turns = 1.3 * 0.49 / 2 * sum((ratio * 1.7) ** 2 for ratio in ratios)
    assert value(lagrange.T) == pytest.approx(turns, rel=1e-13)
