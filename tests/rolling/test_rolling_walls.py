"""Derivation and reference agree about everything that rolls."""

from __future__ import annotations

import numpy as np
import pytest
from rolling_samples import ALL, coin, sleigh, wheel

import mecanique as mq
from mecanique import (
    Mechanism,
    Reference,
    degrees_of_freedom,
    derive,
    verify,
)
from mecanique.derivation.numeric.constraints.rows import Held
from mecanique.errors import DerivationError, EngineError
from mecanique.verification.compare import ClosedForm, derive_all
from mecanique.verification.states import random_states


@pytest.mark.parametrize(
    "mechanism",
    [
        pytest.param(each, id=name, marks=[pytest.mark.slow] * (name == "crowned_wheel_on_a_slope"))
        for name, each in ALL.items()
    ],
)
def test_the_verdict_agrees(mechanism: Mechanism) -> None:
    verdict = verify(mechanism, 30)
    assert verdict.agrees, str(verdict)
    quantities = {row.quantity for row in verdict.rows}
    assert ("contact forces" in quantities) == bool(mechanism.contacts)


@pytest.mark.parametrize("mechanism", ALL.values(), ids=ALL)
def test_rows_and_their_rates_agree(mechanism: Mechanism) -> None:
    states = random_states(mechanism, 5, 1)
    closed = Reference(mechanism).closed
    assert closed is not None
    held = Held(mechanism).at(states)
    for k, (q, v) in enumerate(zip(states.q, states.v, strict=True)):
        t = float(states.t[k])
        here = closed.closures.at(q, v, t)
        np.testing.assert_allclose(held.jacobian[k], here.jacobian, rtol=0, atol=1e-13)
        np.testing.assert_allclose(held.gamma[k], here.gamma, rtol=1e-11, atol=1e-12)
        np.testing.assert_allclose(
            closed.closures.residual(q, t), here.residual, rtol=0, atol=1e-14
        )


@pytest.mark.parametrize("mechanism", ALL.values(), ids=ALL)
def test_every_method_has_its_own_way_to_the_same_motion(mechanism: Mechanism) -> None:
    states = random_states(mechanism, 5, 2)
    expected = Reference(mechanism).acceleration(states.q, states.v, states.t)
    for method in ("lagrange", "newton_euler", "virtual_work"):
        found = derive(mechanism, method).acceleration(states.q, states.v, states.t)
        np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-9)


def test_positions_and_velocities_are_counted() -> None:
    found = degrees_of_freedom(coin())
    assert (found.N, found.positions, found.velocity_rows, found.redundant) == (3, 5, 2, ())
    assert "1 of the equations restricts positions, 2 velocities alone" in str(found)
    found = degrees_of_freedom(sleigh())
    assert (found.N, found.positions) == (2, 3)


def test_a_velocity_constraint_has_a_multiplier_but_no_place_for_its_force() -> None:
    mechanism = sleigh(by_element=False)
    q, v = {"theta": 0.4}, {"theta'": 1.0, "x'": np.cos(0.4), "y'": np.sin(0.4)}
    by_element = Reference(sleigh()).multipliers(q, v)["edge: side"]
    assert Reference(mechanism).multipliers(q, v)["edge"] == pytest.approx(by_element, rel=1e-12)
    with pytest.raises(EngineError, match="does not say by which force it acts"):
        Reference(mechanism).reactions(q, v)
    with pytest.raises(DerivationError, match="does not say by which force it acts"):
        derive(mechanism, "newton_euler").reactions(q, v)


def test_a_crowned_wheel_that_lies_flat_has_no_acceleration() -> None:
    """With a load on its hub it ended in "SVD did not converge"."""
    wheel_free = mq.Mechanism(
        "flat",
        (mq.Body("ground"), mq.Body("wheel", mq.disk(1.4, 0.17))),
        (mq.Floating("free", "ground", "wheel"),),
        forces=(mq.Force("load", "wheel", (0, 0, 0), (1.0, -2.0, 0.5)),),
        contacts=(mq.Rolling("c", "wheel", 0.17, axis=(0, 0, 1), crown=0.05),),
    )
    flat = [0.1, 0.2, 0.05, 0, 0, 0, 1]
    for equations in (
        derive(wheel_free),
        derive(wheel_free, "newton_euler"),
        derive_all(wheel_free).forms["jets"],
    ):
        with pytest.raises(mq.DerivationError, match="has no finite acceleration at"):
            equations.acceleration(flat, [0.1, 0.2, 0, 0.3, 0.1, 0.5])
    for seed in (5, 7, 8):
        assert verify(wheel_free, samples=4, seed=seed).agrees


def test_a_closed_form_that_holds_nowhere_at_a_state_is_no_number_there() -> None:
    """A crowned wheel that lies flat, z = crown, touches along a circle: J and γ divide by zero."""
    mechanism = wheel(crown=0.1)
    form = ClosedForm(mechanism, derive(mechanism).derivation)
    flat, leaning = (
        [0.1, 0.2, 0.1, 0.5**0.5, 0, 0, 0.5**0.5],
        [0.1, 0.2, 0.45, 0.3, 0, 0, 0.91**0.5],
    )
    found = form.acceleration(np.array([flat, leaning]), np.full((2, 6), 0.1))
    assert np.isnan(found[0]).all()
    assert np.isfinite(found[1]).all()
