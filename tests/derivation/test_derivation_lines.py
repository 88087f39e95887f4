"""Lines that are printed in a form of their own say what was computed."""

from __future__ import annotations

import numpy as np
import pytest
from derivation_reading import value_of_text
from systems import derive_system

import mecanique as mq
from mecanique.derivation.printing.equations import expression
from mecanique.derivation.scalars.evaluation import evaluate

NAMES = ("heavy_top", "gyroscope", "dumbbell", "governor")


@pytest.mark.parametrize("name", NAMES)
def test_what_is_printed_in_a_form_of_its_own_has_the_value_of_its_series(name: str) -> None:
    """Squares of sums, momenta by angular velocities, sums over parts, energies of springs."""
    derivation = derive_system(name).derivation
    mechanism = derivation.algebra.mechanism
    random = np.random.default_rng(5)
    letters = (*mechanism.coordinates, *mechanism.velocities, *derivation.algebra.accelerations)
    values = {letter: random.uniform(0.3, 0.9) for letter in (*letters, "t")}
    values |= {parameter.symbol: random.uniform(0.8, 1.2) for parameter in mechanism.parameters}
    compared = 0
    for stage in derivation.stages:
        for result in stage.results:
            if result.shown is not None and not result.right.vanishes():
                text = result.expression().text()
                compared += text != expression(result.right).text()
                found = value_of_text(text, values)
                assert found == pytest.approx(evaluate(result.right, values), rel=1e-11), text
    assert compared


def test_momenta_are_written_by_angular_velocities() -> None:
    """The spin, and the turn about the vertical, by the rate about the top's own axis."""
    lines = [line.strip() for line in derive_system("heavy_top").text(steps=True).splitlines()]
    spin = "3 m r^2 (psi' + cos(theta) phi')"
    across = "3 m (r^2 + 4 h^2) sin(theta)^2 phi'/20"
    assert f"p_psi = {spin}/10" in lines
    assert f"p_phi = {across} + {spin} cos(theta)/10" in lines
    turning = "3 m (r^2 + 4 h^2) (theta'^2 + sin(theta)^2 phi'^2)/40 + 3 m r^2"
    assert f"T = {turning} (psi' + cos(theta) phi')^2/20" in lines
    # other lines are multiplied out
    assert "d/dt ∂T/∂theta' = 3 m (r^2 + 4 h^2) theta''/20" in lines


def test_a_potential_of_three_loads_together_counts_once() -> None:
    """Of y/2 twice along x and x along y it is -x y."""
    x, y = mq.coordinate("x"), mq.coordinate("y")
    plane = mq.Mechanism(
        "plane",
        (mq.Body("ground"), mq.Body("led"), mq.Body("bead", mq.particle(2.0))),
        (
            mq.Prismatic("along", "ground", "led", axis=(1, 0, 0), coordinate="x"),
            mq.Prismatic("across", "led", "bead", axis=(0, 1, 0), coordinate="y"),
        ),
        forces=(
            mq.JointForce("one", "along", y / 2),
            mq.JointForce("two", "along", y / 2),
            mq.JointForce("three", "across", x),
        ),
        gravity=(0, 0, 0),
    )
    lines = [line.strip() for line in mq.derive(plane).text(steps=True).splitlines()]
    assert "E = x'^2 + y'^2 - x y" in lines
