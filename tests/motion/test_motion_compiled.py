"""Motions in compiled C: closed mechanisms, and the reference where it has to help."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from mecanique import simulate, textbook
from mecanique.errors import DerivationError, InputError, IntegrationError
from mecanique.model import (
    Body,
    Input,
    JointForce,
    JointSpring,
    Mechanism,
    Prismatic,
    box,
    coordinate,
)
from mecanique.motion import Event, Motion
from mecanique.motion.compile import costs, derive
from mecanique.motion.compile.cache import compile_once
from mecanique.motion.compile.stepper import has_compiler
from mecanique.motion.simulation.choice import STEPS
from mecanique.reference import Reference

pytestmark = pytest.mark.skipif(not has_compiler(), reason="no C compiler")

START = {"phi": 1.1, "theta": -0.8, "psi": 1.2}


@pytest.fixture(scope="module")
def linkage() -> Mechanism:
    return textbook.load("four_bar_linkage")


def drift(motion: Motion, t: np.ndarray) -> float:
    closed, states = motion.reference.closed, motion(t)
    assert closed is not None
    rows = zip(states.q, states.v, t.tolist(), strict=True)
    return float(max(closed.drift(q, v, s).max() for q, v, s in rows))


def test_a_linkage_moves_as_by_the_reference(linkage: Mechanism) -> None:
    fast = simulate(linkage, q=START, duration=1.0, rtol=1e-11, fps=20, method="compiled")
    slow = simulate(linkage, q=START, duration=1.0, rtol=1e-11, fps=20, method="dop853")
    assert fast.method.startswith("compiled (dop853 on the equations derived in-house, both")
    np.testing.assert_allclose(fast.q, slow.q, rtol=0, atol=1e-11)
    np.testing.assert_allclose(fast.v, slow.v, rtol=0, atol=1e-10)
    assert fast.audit().ok
    between = np.linspace(0.01, 0.99, 13)
    np.testing.assert_allclose(fast(between).v, slow(between).v, rtol=0, atol=1e-10)
    assert drift(fast, between) < 1e-13


def test_tight_steps_end_as_near_as_their_tolerance() -> None:
    bars = textbook.load("bars_and_springs_loop")
    start = dict(textbook.entry("bars_and_springs_loop").start)
    ends = [
        simulate(bars, q=start, duration=10.0, rtol=rtol, samples=2, method="compiled").q[-1]
        for rtol in (1e-12, 1e-14)
    ]
    assert np.abs(ends[0] - ends[1]).max() < 2e-11


def test_the_same_equations_in_python_do_as_well(linkage: Mechanism) -> None:
    options: dict[str, Any] = {"duration": 1.0, "rtol": 1e-10, "samples": 3}
    fast = simulate(linkage, q=START, method="compiled", **options)
    plain = simulate(linkage, q=START, method="closed_form", **options)
    assert plain.method.startswith(
        "dop853 (explicit Runge-Kutta of order 8(5,3), Dormand & Prince)"
    )
    assert "on the equations derived in-house" in plain.method
    np.testing.assert_allclose(fast.q[-1], plain.q[-1], rtol=0, atol=1e-9)


def test_samples_at_any_times_are_as_accurate_as_the_steps(linkage: Mechanism) -> None:
    times = [0.0, 0.3, 0.30001, 0.77, 1.0]
    found = simulate(linkage, q=START, duration=1.0, samples=times, method="compiled")
    assert found.t.tolist() == times
    for t, q in zip(times[1:], found.q[1:], strict=True):
        alone = simulate(linkage, q=START, duration=t, samples=2, method="compiled")
        np.testing.assert_allclose(q, alone.q[-1], rtol=0, atol=1e-11)


def test_the_reference_takes_over_where_a_pivot_vanishes() -> None:
    """Posts that swing as one pendulum pass a flat position, where they may part."""
    mechanism = textbook.load("chained_four_bars", n=1)
    start = {"theta0": 0.5, "theta1": 0.5, "phi1": -0.5}
    speeds = {"theta0": -4.0, "theta1": -4.0, "phi1": 4.0}
    motion = simulate(
        mechanism, q=start, v=speeds, duration=0.3, rtol=1e-8, fps=50, method="compiled"
    )
    assert motion["theta0"][-1] < -0.5
    np.testing.assert_allclose(motion["theta0"], motion["theta1"], rtol=0, atol=1e-11)
    length = (2 / 3 + 1) / (2 / 2 + 1)
    fall = 2 * 9.81 / length * (np.sin(0.5) - np.sin(motion["theta0"]))
    np.testing.assert_allclose(motion["theta0'"] ** 2, 16 + fall, rtol=1e-7, atol=0)
    assert drift(motion, np.linspace(0.01, 0.29, 15)) < 1e-11


def test_trees_are_compiled_too() -> None:
    pendulum = textbook.load("double_pendulum")
    options: dict[str, Any] = {"q": {"q1": 0.9, "q2": 0.4}, "duration": 3.0, "samples": 7}
    fast = simulate(pendulum, method="compiled", **options)
    slow = simulate(pendulum, method="dop853", **options)
    np.testing.assert_allclose(fast.q, slow.q, rtol=0, atol=1e-8)


def test_a_ball_joint_keeps_its_quaternion() -> None:
    body = textbook.load("free_rigid_body")
    start, speeds = textbook.entry("free_rigid_body").start, {"wx": 0.1, "wy": 5.0, "wz": 0.2}
    names = dict(zip(body.velocities[-3:], speeds.values(), strict=True))
    options: dict[str, Any] = {"q": dict(start), "v": names, "duration": 2.0, "samples": 5}
    fast = simulate(body, method="compiled", **options)
    slow = simulate(body, method="dop853", **options)
    np.testing.assert_allclose(fast.q, slow.q, rtol=0, atol=1e-8)


def test_long_motions_of_loops_are_compiled_by_themselves(linkage: Mechanism) -> None:
    motion = simulate(linkage, q=START, duration=200.0, rtol=1e-8, samples=2)
    assert motion.method.startswith("compiled")
    assert "chosen for a motion long enough to pay for compiling" in motion.method
    again = simulate(textbook.load("four_bar_linkage"), q=START, duration=200.0, rtol=1e-8)
    np.testing.assert_array_equal(motion.q[-1], again.q[-1])


def test_what_takes_too_many_operations_stays_on_the_reference(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr(derive, "MOST", 200)
    linkage = textbook.load("four_bar_linkage")
    motion = simulate(linkage, q=START, duration=5.0, rtol=1e-8, samples=2)
    assert motion.method.startswith("dop853")
    assert "derived" not in motion.method
    with pytest.raises(DerivationError, match="the program takes more than 200 operations"):
        simulate(linkage, q=START, method="compiled")


def test_equations_that_take_too_long_to_compile_are_integrated_in_python(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setitem(costs._COMPILING_OPERATIONS, "optimized", 1e10)
    linkage = textbook.load("four_bar_linkage")
    motion = simulate(linkage, q=START, duration=20.0, rtol=1e-8, samples=2)
    assert "on the equations derived in-house" in motion.method
    assert motion.method.startswith("dop853")


def test_an_input_known_only_while_it_moves_is_no_fault() -> None:
    """Enough steps to derive the equations, which are compared at times after the motion's end."""

    def push(t: float) -> float:
        if t > 1.001:
            raise ValueError("nothing was recorded after 1 s")
        return 1.0

    force = Input("F", push, "N")
    mass = Mechanism(
        "mass",
        (Body("ground"), Body("mass", box(1.0, (0.1, 0.1, 0.1)))),
        (Prismatic("slide", "ground", "mass", axis=(1, 0, 0), coordinate="x"),),
        forces=(JointSpring("spring", "slide", 2e6), JointForce("push", "slide", force)),
        inputs=(force,),
    )
    motion = simulate(mass, q=[0.01], duration=1.0, samples=2)
    assert motion.statistics.steps > STEPS
    w = np.sqrt(2e6)
    assert motion["x"][-1] == pytest.approx(0.01 * np.cos(w) + (1 - np.cos(w)) / 2e6, abs=1e-8)
    with pytest.raises(DerivationError, match="an input fails at a random time"):
        simulate(mass, q=[0.01], duration=1.0, method="closed_form")


def test_short_motions_of_loops_are_not_worth_it(linkage: Mechanism) -> None:
    assert "derived" not in simulate(linkage, q=START, duration=0.05).method


@contextmanager
def without_compiler(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    with monkeypatch.context() as patch:
        patch.setenv("PATH", "")
        patch.delenv("CC", raising=False)
        has_compiler.cache_clear()
        yield
    has_compiler.cache_clear()


def test_without_a_compiler_there_is_a_clear_message(monkeypatch: pytest.MonkeyPatch) -> None:
    mechanism = textbook.load("four_bar_linkage")
    with without_compiler(monkeypatch):
        with pytest.raises(InputError, match="expected a C compiler, found none: install gcc"):
            simulate(mechanism, q=START, method="compiled")
        motion = simulate(mechanism, q=START, duration=20.0, rtol=1e-8, samples=2)
    assert "on the equations derived in-house" in motion.method
    assert not motion.method.startswith("compiled")


def test_compiled_steps_end_where_a_chart_ends() -> None:
    """A point on a circle by its abscissa: the same place and time as by the reference."""
    point = textbook.load("particle_on_circle_x")
    ends = []
    for method in ("compiled", "dop853"):
        with pytest.raises(IntegrationError, match=r"chart x of 'particle_on_circle_x' ends") as no:
            simulate(point, v={"x": 2.0}, duration=5.0, rtol=1e-10, method=method)
        ends.append(no.value.motion)
    fast, slow = ends
    assert [event.name for event in fast.events] == ["end of chart x"]
    assert fast.t[-1] == pytest.approx(slow.t[-1], abs=1e-10)
    np.testing.assert_allclose(fast["x"], slow["x"], rtol=0, atol=1e-10)
    assert fast["x"][-1] == pytest.approx(0.998, rel=1e-12)
    # within its chart it comes to its end
    whole = simulate(point, v={"x": 0.5}, duration=2.0, rtol=1e-10, method="compiled")
    assert whole.t[-1] == 2.0
    assert not whole.events


@pytest.mark.slow
def test_what_rolls_is_compiled_though_its_lean_is_limited() -> None:
    coin = textbook.load("rolling_coin")
    high = coin.values["r"] * np.cos(0.3)
    start: dict[str, Any] = {"q": {"z": high, "lean": 0.3}, "duration": 3.0, "rtol": 1e-9}
    with pytest.raises(IntegrationError, match=r"chart lean of 'rolling_coin' ends") as no:
        simulate(coin, v={"lean": 2.0}, method="compiled", **start)
    flat = no.value.motion
    assert [event.name for event in flat.events] == ["rim would pull", "end of chart lean"]
    assert drift(flat, np.linspace(0.0, float(flat.t[-1]), 9)) < 1e-9
    upright = simulate(coin, v={"spin": 20.0, "lean": 0.0}, method="compiled", **start)
    slow = simulate(coin, v={"spin": 20.0, "lean": 0.0}, method="dop853", **start)
    np.testing.assert_allclose(upright.q, slow.q, rtol=0, atol=1e-8)


def test_what_compiled_steps_do_not_know_is_refused(linkage: Mechanism) -> None:
    event = Event("up", coordinate("phi") - 1.2)
    with pytest.raises(InputError, match="method 'compiled' watches for no events, got 'up'"):
        simulate(linkage, q=START, events=[event], method="compiled")
    with pytest.raises(DerivationError, match="has constraints, which Taylor series do not keep"):
        simulate(linkage, q=START, method="taylor")
    push = Input("F", lambda t: t, "N")
    block = textbook.load("cart_pole")
    slide = next(joint.name for joint in block.joints if isinstance(joint, Prismatic))
    pushed = replace(block, forces=(JointForce("push", slide, push),), inputs=(push,))
    with pytest.raises(DerivationError, match="as formulas, but the input F is a function"):
        simulate(pushed, method="compiled")


def test_what_rolls_is_compiled_too() -> None:
    sleigh = textbook.load("chaplygin_sleigh")
    start = {"q": dict(textbook.entry("chaplygin_sleigh").start)}
    options: dict[str, Any] = {**start, "duration": 1.0, "rtol": 1e-10, "samples": 3}
    fast = simulate(sleigh, v={sleigh.velocities[-1]: 2.0}, method="compiled", **options)
    slow = simulate(sleigh, v={sleigh.velocities[-1]: 2.0}, method="dop853", **options)
    assert np.abs(fast.v[-1] - fast.v[0]).max() > 1e-3
    np.testing.assert_allclose(fast.q, slow.q, rtol=0, atol=1e-11)


def test_too_many_steps_and_progress_end_a_compiled_motion(linkage: Mechanism) -> None:
    with pytest.raises(IntegrationError, match="more than 5 steps") as caught:
        simulate(linkage, q=START, duration=2.0, max_steps=5, method="compiled")
    assert caught.value.motion is not None
    assert caught.value.motion.statistics.steps == 5
    assert caught.value.motion.t[-1] == caught.value.time

    def refuse(done: float) -> None:
        raise RuntimeError("enough")

    with pytest.raises(IntegrationError, match=r"progress raised RuntimeError\('enough'\)"):
        simulate(linkage, q=START, duration=0.1, method="compiled", progress=refuse)


def test_it_is_known_how_far_a_singular_position_is() -> None:
    mechanism = textbook.load("chained_four_bars", n=1)
    reference = Reference.of(mechanism)
    stepper = compile_once(mechanism).stepper(reference)
    for angle in (0.02, 0.05, 0.1, 0.2):
        q = np.array([angle, angle, -angle])
        y = np.concatenate([q, [-1.0, -1.0, 1.0]])
        # the flat position is that far away, to first order
        assert stepper.distance(0.0, y) == pytest.approx(angle, rel=0.15)
