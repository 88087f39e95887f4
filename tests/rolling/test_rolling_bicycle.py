"""Whipple's bicycle against published digits."""

from __future__ import annotations

import json

import numpy as np
import pytest
from click.testing import CliRunner
from rolling_samples import bicycle

import mecanique as mq
from mecanique import (
    Reference,
    SteadyLinearization,
    degrees_of_freedom,
    derive,
    linearize_steady,
    sweep_speeds,
    verify,
)
from mecanique.cli import app
from mecanique.motion.record.loops import begin_on_loops

TABLE_1 = {
    "x''": 0.5041626315047,
    "y''": 0.3449706619454,
    "z''": -1.460452833298,
    "yaw''": 0.8353281706379,
    "roll''": 7.8555281128244,
    "pitch''": 0.1205543897884,
    "steer''": 4.6198904039403,
    "rear_spin''": 1.8472554144217,
    "front_spin''": 2.454807290455,
}
"""Basu-Mandal, Chatterjee & Papadopoulos, Proc. R. Soc. A 463 (2007) 1983, table 1, last column.

Their ψ, ψ_f, x and y count positive the other way.
"""


def state_of_table_1() -> tuple[np.ndarray, np.ndarray]:
    """The state of table 1; the position of the rear hub's height follows from the contacts."""
    q = {
        "z": 0.2440472102925,
        "roll": np.pi / 2 - 0.9501292851472,
        "pitch": 3.1257073014894 - np.pi,
        "steer": -0.2311385135743,
    }
    v = {
        "yaw": 0.7830033527065,
        "roll": -0.6068425835418,
        "pitch": -0.0119185528069,
        "steer": -0.4859824687093,
        "rear_spin": 8.912989661489,
        "front_spin": 8.0133620584155,
    }
    _, state, _ = begin_on_loops(Reference(bicycle()), q, v, 0.0)
    return state[:9], state[9:]


def test_the_nine_accelerations_of_table_1() -> None:
    mechanism = bicycle()
    q, v = state_of_table_1()
    # what the table gives besides
    published = {"x'": 2.8069345714545, "y'": 0.1480982396001, "z'": 0.1058778746261}
    for name, value in published.items():
        assert v[mechanism.velocities.index(name)] == pytest.approx(value, abs=1e-11)
    expected = np.array([TABLE_1[f"{name}''"] for name in mechanism.coordinates])
    # of values above one to 1e-11 of themselves: steer'' differs by 2.1e-11, of which rounding of
    # the printed state explains 3e-12; reference and derivations differ from each other by 5e-14
    unit = np.maximum(1.0, np.abs(expected))
    reference = Reference(mechanism).acceleration(q, v)
    np.testing.assert_allclose(reference / unit, expected / unit, rtol=0, atol=1e-11)
    for method in ("lagrange", "newton_euler", "virtual_work"):
        found = derive(mechanism, method).acceleration(q, v)
        np.testing.assert_allclose(found / unit, expected / unit, rtol=0, atol=1e-11)
        np.testing.assert_allclose(found, reference, rtol=0, atol=1e-12)


def test_it_has_seven_positions_and_three_velocities() -> None:
    found = degrees_of_freedom(bicycle())
    assert (found.N, found.positions, found.redundant) == (3, 7, ())


def test_the_verdict_agrees() -> None:
    verdict = verify(bicycle(), 10)
    assert verdict.agrees, str(verdict)


M = [[80.81722, 2.31941332208709], [2.31941332208709, 0.29784188199686]]
C1 = [[0.0, 33.86641391492494], [-0.85035641456978, 1.6854039739756]]
K0 = [[-80.95, -2.59951685249872], [-2.59951685249872, -0.80329488458618]]
K2 = [[0.0, 76.59734589573222], [0.0, 2.65431523794604]]
"""M q'' + v C1 q' + (g K0 + v² K2) q = 0 for roll and steer (Meijaard, Papadopoulos, Ruina &

Schwab, Proc. R. Soc. A 463 (2007) 1955, eq. 6.1 to 6.4)."""


@pytest.fixture(scope="module")
def benchmark_rides() -> dict[float, SteadyLinearization]:
    return {
        speed: linearize_steady(
            bicycle(), {"z": 0.3}, {"x": speed}, by=("roll", "steer", "rear_spin")
        )
        for speed in (0.0, 3.0, 5.0, 10.0)
    }


def test_the_matrices_of_the_benchmark(benchmark_rides: dict[float, SteadyLinearization]) -> None:
    mass, damping, still = benchmark_rides[0.0].second_order(("roll", "steer"))
    np.testing.assert_allclose(mass, M, rtol=0, atol=1e-12)
    np.testing.assert_allclose(damping, 0, rtol=0, atol=1e-12)
    np.testing.assert_allclose(still / 9.81, K0, rtol=0, atol=1e-11)
    for speed in (3.0, 5.0, 10.0):
        mass, damping, stiffness = benchmark_rides[speed].second_order(("roll", "steer"))
        np.testing.assert_allclose(mass, M, rtol=0, atol=1e-12)
        np.testing.assert_allclose(damping / speed, C1, rtol=0, atol=1e-10)
        np.testing.assert_allclose((stiffness - still) / speed**2, K2, rtol=0, atol=1e-10)


@pytest.mark.parametrize("speed", [0.0, 3.0, 5.0, 10.0])
def test_the_exponents_of_the_benchmark(
    benchmark_rides: dict[float, SteadyLinearization], speed: float
) -> None:
    found = benchmark_rides[speed]
    stiffness, damping = 9.81 * np.array(K0) + speed**2 * np.array(K2), speed * np.array(C1)
    lower = [-np.linalg.solve(M, stiffness), -np.linalg.solve(M, damping)]
    A = np.block([[np.zeros((2, 2)), np.eye(2)], lower])
    exponents = np.sort_complex(np.linalg.eigvals(A))
    np.testing.assert_allclose(np.sort_complex(found.exponents), exponents, rtol=0, atol=1e-10)
    assert set(found.cyclic) >= {"x", "y", "yaw"}
    assert found.stable == (4.3 < speed < 6)


@pytest.mark.slow
def test_weave_and_capsize_speed() -> None:
    """The bicycle is stable between 4.29238253634111 and 6.02426201538837 m/s (ibid., sect. 7)."""
    found = sweep_speeds(bicycle(), {"z": 0.3}, {"x": 1.0}, [4.0, 5.0, 6.5])
    assert found.limits == pytest.approx((4.29238253634111, 6.02426201538837), abs=1e-10)
    assert "stability changes at: 4.29238254, 6.02426202" in str(found)


def test_its_derivation_ends_with_the_matrices_of_the_benchmark() -> None:
    """Whatever the method; the exact equations, 216 results, are left to the code."""
    words = ["derive", "whipple_bicycle", "--method", "all", "--steps"]
    run = CliRunner().invoke(app, words)
    assert run.exit_code == 0, run.output
    lines = [line.strip().partition(" = ") for line in run.stdout.splitlines()]
    for name, matrix in {"M": M, "C1": C1, "K0": K0, "K2": K2}.items():
        *_, rows = (right for left, _, right in lines if left == name)
        np.testing.assert_allclose(json.loads(rows), matrix, rtol=5e-5, atol=0)
    said = " ".join(run.stdout.split())
    assert "M q'' + v C1 q' + (g K0 + v² K2) q = 0 for q = (roll, steer)." in said
    assert run.stdout.startswith("Whipple bicycle: ")
    assert "trail [m]" in run.stdout
    assert "'mecanique code' writes them as a program" in run.stderr
    words = ["derive", "whipple_bicycle", "--method", "newton_euler"]
    assert CliRunner().invoke(app, words).stdout == run.stdout
    # the wheel's moments ½ I (α + ω ω) and ½ I (α − ω ω) about its axle are added up
    exact = mq.write_recursion(mq.derive(mq.textbook.load("whipple_bicycle"))).text()
    assert "N_rear_wheel_y = IRyy alpha_rear_wheel_y\n" in exact
