"""The closed forms of what rolls hold along the motions that the reference gives."""

from __future__ import annotations

import numpy as np
import pytest
from rolling_samples import coin, sleigh, turntable, wheel

from mecanique import Mechanism, Reference, derive, textbook
from mecanique.derivation.methods import agreement
from mecanique.derivation.scalars.cancel import tidy
from mecanique.derivation.scalars.elementary import cos, root_of_square, sin
from mecanique.derivation.scalars.evaluation import Evaluation
from mecanique.derivation.scalars.series import Ring, Series
from mecanique.derivation.symbolic.derivation import Tie
from mecanique.derivation.symbolic.multipliers import loop_stages
from mecanique.verification.states import random_states

METHODS = ("lagrange", "newton_euler", "virtual_work")
READ = [
    *((one, method) for one in (coin(), sleigh()) for method in METHODS),
    *((one, method) for one in (wheel(), turntable()) for method in METHODS[:2]),
    *((sleigh(by_element=False), method) for method in ("lagrange", "virtual_work")),
]


@pytest.mark.parametrize(("mechanism", "method"), READ, ids=lambda x: getattr(x, "name", x))
def test_what_is_printed_holds(mechanism: Mechanism, method: str) -> None:
    derivation = derive(mechanism, method).derivation
    states = random_states(mechanism, 6, 5, derivation.assumptions, lot=8)
    reference = Reference(mechanism)
    a = reference.acceleration(states.q, states.v, states.t)
    values = {**states.values}
    values |= dict(zip(derivation.algebra.accelerations, a.T, strict=True))
    for name, force in reference.multipliers(states.q, states.v, states.t).items():
        values[f"lambda_{name.replace(': ', '_')}"] = force
    value = Evaluation(derivation.algebra.ring, values)
    for row in derivation.rows:
        np.testing.assert_allclose(value(row) + 0 * states.t, 0, rtol=0, atol=1e-12)
    for tie in derivation.ties:
        np.testing.assert_allclose(value(tie.demand) + 0 * states.t, 0, rtol=0, atol=1e-13)
        np.testing.assert_allclose(value(tie.second) + 0 * states.t, 0, rtol=0, atol=1e-12)


def test_virtual_work_has_as_many_equations_as_free_velocities_and_no_multiplier() -> None:
    for mechanism, count in ((coin(), 3), (sleigh(), 2)):
        derivation = derive(mechanism, "virtual_work").derivation
        assert len(derivation.rows) == count
        assert "lambda" not in derive(mechanism, "virtual_work").text()
        text = derive(mechanism, "virtual_work").text(steps=True)
        # in the equilibrium of a single body the contact's force stands as the reactions do
        derived, _, _ = text.partition(". Result\n")  # which gives the forces in closed form
        assert "lambda" not in derived[derived.index("Sum of the virtual work") :]
        assert "Independent displacements" in text


def test_all_methods_agree_identically() -> None:
    for mechanism in (coin(), sleigh()):
        assert "All three methods give the same equations" in agreement(mechanism)


def test_rows_and_multipliers_have_names() -> None:
    text = derive(coin()).text(steps=True)
    for words in (
        "lambda_rim_normal  normal force of the ground on the disk at the rim [N]",
        "lambda_rim_x, lambda_rim_y friction along x and y of the plane of the ground on the disk",
        "Phi_rim_normal = z - r cos(lean)",
        "ψ = 0 must not be substituted into T.",
    ):
        assert words in " ".join(text.split()) or words in text
    text = derive(sleigh(), "newton_euler").text(steps=True)
    assert "29 theta''/150 = -0.3 lambda_edge_side" in text


def test_a_length_that_is_a_cosine_divides_exactly() -> None:
    ring = Ring()
    a, b = ring.coordinate("a"), ring.coordinate("b")
    square = 1 - sin(a) ** 2
    assert root_of_square(square) == cos(a)
    assert root_of_square(1 + square) is None
    for part in (sin(b) * 3, cos(a), sin(a - b)):
        assert tidy(tidy(part * cos(a)) / cos(a)) == part


def test_what_can_be_integrated_may_be_put_into_the_kinetic_energy() -> None:
    """x' = R turn' integrates; the coin and the sleigh are the examples of what does not."""
    for mechanism, integrable in (
        (textbook.load("rolling_disk"), True),
        (coin(), False),
        (sleigh(), False),
        (textbook.load("two_wheeled_cart"), False),
    ):
        said = " ".join(derive(mechanism).text(steps=True).split())
        assert ("here the constraints can be integrated" in said) == integrable
        assert ("ψ, linear in the velocities, cannot be integrated" in said) != integrable
        assert ("must not be substituted" in said) != integrable


RING = Ring()
x, y, z = (RING.coordinate(name) for name in "xyz")
push = RING.parameter("lambda_k")
dx, dy, dz = (RING[f"{name}'"] for name in "xyz")


@pytest.mark.parametrize(
    ("psi", "words"),
    [
        (y * z * dx + x * z * dy + x * y * dz, "can be integrated"),  # (x y z)'
        (sin(y) * dx + sin(y) * cos(z) * dz, "can be integrated"),  # after division by sin y
        (dz - y * dx, "cannot be integrated"),
        (dx + sin(y) * dz, "cannot be integrated"),
        (dx - dy + 1, "need not be integrable"),  # to one of positions and time
    ],
)
def test_integrability_is_that_of_frobenius(psi: Series, words: str) -> None:
    tie = Tie("k", psi, push, "push", of_velocities=True)
    (stage,) = loop_stages([tie])
    assert words in stage.explanation
    assert ("must not be substituted into T" in stage.explanation) == (words != "can be integrated")
    assert "Φ" not in stage.explanation


@pytest.mark.parametrize(
    ("curved", "words"),
    [
        (False, "cannot be integrated"),  # a loop that gives z leaves y free
        (True, "need not be integrable"),  # one that may hold y may hold it where y^2 is constant
    ],
)
def test_what_a_loop_may_hold_does_not_tell_whether_rolling_can_be_integrated(
    curved: bool, words: str
) -> None:
    """w' = y^2 x' has the bracket 2 y, which vanishes at y = 0 alone."""
    ring = Ring()
    _, y, z, _ = (ring.coordinate(name) for name in "xyzw")
    loop = Tie("c", (sin(z) if curved else z) - sin(y), ring.parameter("lambda_c"), "pull")
    psi = ring["w'"] - y * y * ring["x'"]
    rolls = Tie("k", psi, ring.parameter("lambda_k"), "push", of_velocities=True)
    assert words in loop_stages([loop, rolls])[-1].explanation
