from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import mecanique as mq
from mecanique.model.states import States
from mecanique.motion.compile.derive import program_of, require_agreement
from mecanique.motion.compile.python import overwriting, owning, scalar, vectorize
from mecanique.program.tape import Tape
from mecanique.reference import Reference
from mecanique.verification.states import random_states


@pytest.mark.parametrize("name", mq.textbook.names())
def test_the_program_of_every_system_gives_the_rates_of_the_reference(name: str) -> None:
    mechanism = mq.textbook.load(name)
    program = program_of(mechanism, {p.symbol for p in mechanism.parameters})
    by_one = scalar(program_of(mechanism))
    by_many = vectorize(program, [np.array(mechanism.values[symbol]) for symbol in program.open])
    reference = Reference(mechanism)
    rhs, states = reference.rhs(), random_states(mechanism, 6, 3, lot=8)
    out = np.empty(mechanism.nq + mechanism.nv)
    for q, v, t in zip(states.q, states.v, states.t.tolist(), strict=True):
        y = np.concatenate([q, v])
        expected = rhs(t, y)
        by_many(t, y, out)
        size = 1 + np.abs(expected).max()
        np.testing.assert_allclose(by_one(t, y) / size, expected / size, rtol=0, atol=1e-11)
        np.testing.assert_allclose(out / size, expected / size, rtol=0, atol=1e-11)


def test_what_has_no_closed_form_for_every_state_is_refused() -> None:
    with pytest.raises(
        mq.DerivationError, match="expected at most 8 velocities for a closed form, got 9"
    ):
        program_of(mq.textbook.load("n_link_pendulum", n=9))


def test_equations_that_disagree_with_the_reference_are_refused() -> None:
    mechanism = mq.textbook.load("rigid_bar_pendulum")

    def wrong(states: States) -> np.ndarray:
        found: np.ndarray = Reference(mechanism).acceleration(states.q, states.v) * (1 + 1e-6)
        return found

    with pytest.raises(
        mq.DerivationError,
        match=r"the closed form of .* and the reference disagree.* differ by 1.0e-06",
    ):
        require_agreement(mechanism, Reference(mechanism), wrong, "closed form")


def test_a_tape_shares_what_is_equal_and_folds_what_is_known() -> None:
    tape = Tape()
    x, y = tape.input("x"), tape.input("y")
    assert tape.add(x, y) == tape.add(y, x)
    assert tape.add(x, tape.multiply(-1.0, y)) == tape.subtract(x, y)
    assert tape.subtract(x, x) == 0.0
    assert tape.multiply(2.0, tape.multiply(3.0, x)) == tape.multiply(6.0, x)
    assert tape.call("sin", tape.multiply(-1.0, x)) == tape.multiply(-1.0, tape.call("sin", x))
    assert tape.call("cos", 0.0) == 1.0
    assert tape.power(x, -2) == tape.divide(1.0, tape.multiply(x, x))
    # y is the place 1, which is not the number 1
    assert tape.multiply(1.0, x) == x
    assert tape.add(1.0, x) != tape.add(y, x)
    assert len(tape.find_needed([tape.add(tape.multiply(x, y), tape.multiply(y, x))])) == 4


def test_functions_that_overwrite_their_answers_do_not_share_them() -> None:
    make = overwriting(program_of(mq.textbook.load("rigid_bar_pendulum")))
    one, other = make(), make()
    y, z = np.array([0.3, 0.1]), np.array([1.3, -0.4])
    first = one(0.0, y)
    kept = first.copy()
    second = other(0.0, z)
    assert first.tolist() == kept.tolist() != second.tolist()
    assert one(0.0, z) is first
    assert first.tolist() == second.tolist()
    rhs = owning(make())
    assert rhs(0.0, y) is not rhs(0.0, y)


def test_an_input_may_hold_any_power_and_the_angle_of_a_vector() -> None:
    from sympy import Rational, atan2, exp

    t = mq.time()
    cart = mq.textbook.load("cart_pole")
    for signal in ((1 + t * t) ** Rational(1, 3), atan2(t, 1 + t), mq.time() * exp(-t) ** 2.5):
        (driven,) = [mq.Input(i.symbol, signal, i.unit) for i in cart.inputs]
        mechanism = replace(cart, inputs=(driven,))
        y = np.array([0.1, 0.4, -0.3, 0.2])
        expected = Reference(mechanism).rhs()(0.7, y)
        np.testing.assert_allclose(
            scalar(program_of(mechanism))(0.7, y), expected, rtol=1e-12, atol=0
        )
        out = np.empty(4)
        vectorize(program_of(mechanism))(0.7, y, out)
        np.testing.assert_allclose(out, expected, rtol=1e-12, atol=0)
