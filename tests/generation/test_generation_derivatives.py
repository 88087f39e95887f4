"""Derivatives by sweeps along the program, by closed forms, identities and differences."""

from __future__ import annotations

import numpy as np
import pytest
from systems import derive_system

import mecanique as mq
from mecanique.generation.build import build_program
from mecanique.program.evaluation import evaluate
from mecanique.program.sweeps import pull_back, push_forward
from mecanique.program.tape import Tape, Value

pytestmark = pytest.mark.usefixtures("in_process")


def test_both_sweeps_know_every_operation() -> None:
    tape = Tape()
    x, y = tape.input("x"), tape.input("y")
    small = tape.multiply(0.3, tape.call("sin", x))
    found: list[Value] = [
        tape.add(x, y),
        tape.subtract(x, y),
        tape.multiply(x, y),
        tape.divide(x, y),
        tape.divide(y, tape.multiply(x, x)),
        *(tape.call(name, x) for name in ("sin", "cos", "tan", "sqrt", "exp", "log", "atan")),
        *(tape.call(name, small) for name in ("asin", "acos", "tanh", "Abs", "sign")),
        tape.call("atan2", x, y),
        tape.call("pow", x, y),
    ]
    at, h = {"x": 0.7, "y": 1.9}, 1e-5
    forward = push_forward(tape, found, {x: 0.4, y: -1.1})
    shift = [{"x": 0.7 + s * 0.4 * h, "y": 1.9 - s * 1.1 * h} for s in (1, -1)]
    values = [evaluate(tape, found, point, 1)[0] for point in shift]
    np.testing.assert_allclose(
        evaluate(tape, forward, at, 1)[0], (values[0] - values[1]) / (2 * h), rtol=1e-8, atol=1e-9
    )
    weights = [float(k + 1) for k in range(len(found))]
    back = evaluate(tape, pull_back(tape, found, weights, [x, y]), at, 1)[0]
    assert back @ [0.4, -1.1] == pytest.approx(
        evaluate(tape, forward, at, 1)[0] @ weights, rel=1e-12
    )


def test_the_derivatives_of_the_pendulum_are_those_of_its_equation() -> None:
    mechanism = mq.textbook.load("simple_pendulum", l=2.0, m=3.0)
    what = ("acceleration_by_q", "acceleration_by_tau", "acceleration_by_p", "rhs_by_y")
    code = mq.generate(mq.derive(mechanism), "c", what)
    compiled, q = code.compile(), np.linspace(-2.0, 2.0, 9)[:, None]
    g, v = mechanism.values["g"], np.zeros_like(q)
    np.testing.assert_allclose(
        compiled.acceleration_by_q(0.0, q, v)[:, 0, 0], -g / 2 * np.cos(q[:, 0]), rtol=1e-14, atol=0
    )
    np.testing.assert_allclose(
        compiled.acceleration_by_tau(0.0, q, v), 1 / (3.0 * 2.0**2), rtol=1e-14, atol=0
    )
    by_length = compiled.acceleration_by_p(0.0, q, v)[:, 0, code.parameters.index("l")]
    np.testing.assert_allclose(by_length, g / 4 * np.sin(q[:, 0]), rtol=1e-14, atol=1e-15)
    np.testing.assert_allclose(
        compiled.rhs_by_y(0.0, [0.0, 0.0]), [[0.0, 1.0], [-g / 2, 0.0]], rtol=0, atol=1e-14
    )


@pytest.mark.parametrize("name", ["double_pendulum", "free_rigid_body", "crane", "two_blocks"])
def test_derivatives_agree_with_differences_of_what_pinocchio_gives(name: str) -> None:
    what = "rhs_by_y,rhs_by_tau,inverse_dynamics_by_q,inverse_dynamics_by_v,inverse_dynamics_by_a"
    mechanism = mq.textbook.load(name)
    verdict = mq.generate(mq.derive(mechanism), "python", what, samples=20).verdict
    assert verdict is not None
    assert max(verdict.worst.values()) < 1e-8


def test_derivatives_by_parameters_agree_with_differences() -> None:
    equations = derive_system("cart_pole")
    verdict = mq.generate(equations, "python", "rhs_by_p,energy_by_p", samples=5).verdict
    assert verdict is not None
    assert max(verdict.worst.values()) < 1e-8


def test_inverse_dynamics_by_accelerations_is_the_mass_matrix() -> None:
    mechanism = mq.read_urdf(mq.robot("ur5_robot"))
    code = mq.generate(mq.derive(mechanism), "c", "inverse_dynamics_by_a,mass_matrix", samples=10)
    compiled = code.compile()
    q, v, a = np.random.default_rng(1).normal(size=(3, 6))
    np.testing.assert_allclose(
        compiled.inverse_dynamics_by_a(0.0, q, v, a),
        compiled.mass_matrix(0.0, q),
        rtol=0,
        atol=1e-13,
    )


def test_derivatives_stay_short() -> None:
    program = build_program(derive_system("double_pendulum"), ("rhs_by_y", "rhs"))
    assert program.count("rhs_by_y").total <= 115
    assert program.count("rhs").total == 49


def test_derivatives_that_mean_nothing_are_refused() -> None:
    linkage = derive_system("four_bar_linkage")
    with pytest.raises(mq.InputError, match="expected no loops for 'rhs_by_q': the states next"):
        mq.generate(linkage, "c", "rhs_by_q")
    with pytest.raises(mq.InputError, match="expected no contacts for 'rhs_by_y': the states next"):
        mq.generate(derive_system("whipple_bicycle"), "c", "rhs_by_y")
    pendulum = derive_system("simple_pendulum")
    for name in ("mass_matrix_by_v", "energy_by_tau", "rhs_by_m", "weight_by_q"):
        with pytest.raises(mq.UnknownNameError, match=f"unknown quantity '{name}'"):
            mq.generate(pendulum, "c", name)
