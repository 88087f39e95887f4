"""Straight-line programs of what rolls: few operations, and the motion that the engine gives."""

from __future__ import annotations

from time import process_time

import numpy as np
import pytest
from rolling_samples import bowl, sleigh, stone, turning_bowl, turntable, wheel

from mecanique import (
    Mechanism,
    Placement,
    derive,
    generate,
    linearize_steady,
    simulate,
    textbook,
)
from mecanique.motion.compile.derive import program_of
from mecanique.program.tape import count

SAMPLES = {
    "crowned_wheel_on_a_slope": wheel(0.1, Placement((0, 0, 0.1), (0.2, 0.3, 0.1))),
    "turntable": turntable(),
    "sleigh": sleigh(),
    "velocity_constraint": sleigh(by_element=False),
    "dome": bowl(-2.0),
    "turning_bowl": turning_bowl(),
    "ellipsoid_on_a_board": stone(),
}


@pytest.mark.usefixtures("in_process")
@pytest.mark.parametrize("name", SAMPLES)
def test_code_gives_what_pinocchio_gives(name: str) -> None:
    """`generate` runs the code and compares it; it refuses to hand out what does not agree."""
    equations = derive(SAMPLES[name])
    code = generate(equations, target="python", what=("rhs", "multipliers", "closure"), samples=10)
    assert "10 random states" in str(code.verdict)


def test_the_bicycle_takes_few_operations_and_little_time() -> None:
    """Symbrim's equations of the bicycle take 1,909 operations, SymPy's minutes to derive."""
    bicycle = textbook.load("whipple_bicycle")
    begin = process_time()
    program = program_of(bicycle)
    linearize_steady(bicycle, {"z": 0.3}, {"x": 5.0}, by=("roll", "steer", "rear_spin"))
    assert process_time() - begin < 5
    assert count(program.tape, program.rates).total <= 1900


@pytest.mark.parametrize("name", ["whipple_bicycle", "ball_on_a_turntable", "snakeboard"])
def test_a_motion_by_the_program_is_that_of_the_reference(name: str) -> None:
    system: Mechanism = textbook.load(name)
    entry = textbook.entry(name)
    start = {"q": entry.start, "v": entry.start_velocity, "duration": 1.0, "samples": 5}
    quick = simulate(system, **start, rtol=1e-10, method="closed_form")  # type: ignore[arg-type]
    slow = simulate(system, **start, rtol=1e-10, method="dop853")  # type: ignore[arg-type]
    assert "derived in-house" in quick.method
    np.testing.assert_allclose(quick.q, slow.q, rtol=0, atol=1e-10)
    np.testing.assert_allclose(quick.v, slow.v, rtol=0, atol=1e-9)
