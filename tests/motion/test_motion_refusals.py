"""What a motion refuses: runs without headway, faults by their first cause, unknown names."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sympy

import mecanique as mq
from mecanique.motion.compile.stepper import has_compiler
from mecanique.motion.simulation.integrators.methods import (
    EquationsError,
    IntegrationTask,
    StalledError,
    advance,
    advance_within,
)


def slider(force: Any = 0.0) -> mq.Mechanism:
    """Return a particle of 1 kg that slides along x under a force."""
    return mq.Mechanism(
        name="slider",
        bodies=(mq.Body("ground"), mq.Body("block", mq.particle(1.0))),
        joints=(mq.Prismatic("slide", "ground", "block", axis=(1, 0, 0), coordinate="x"),),
        forces=(mq.JointForce("push", "slide", force),),
        gravity=(0, 0, 0),
    )


def test_a_force_that_chatters_ends_without_headway() -> None:
    dry = slider(-sympy.sign(mq.velocity("x")))
    with pytest.raises(mq.IntegrationError, match=r"no headway at t = .*chatters") as info:
        mq.simulate(dry, v=[1e-6], method="dop853", max_steps=10**9, samples=2)
    assert info.value.time == pytest.approx(0.0, abs=1e-4)
    # it has come to rest after v² / 2 on the way
    assert info.value.motion.q[-1] == pytest.approx([5e-13], rel=1e-3, abs=0)


@pytest.mark.skipif(not has_compiler(), reason="no C compiler")
@pytest.mark.parametrize(
    ("method", "most"), [pytest.param("dop853", 1000, marks=pytest.mark.slow), ("compiled", 5000)]
)
def test_loops_that_chatter_end_without_headway_soon(method: str, most: int) -> None:
    """An evaluation of loops is dear, so that they are watched more closely than trees."""
    rub = mq.JointForce("rub", "A", -100 * sympy.sign(mq.velocity("phi")))
    dry = replace(mq.textbook.load("four_bar_linkage"), forces=(rub,))
    start = {"phi": 1.1, "theta": -0.76, "psi": 1.25}
    with pytest.raises(mq.IntegrationError, match=r"no headway at t = ") as info:
        mq.simulate(dry, q=start, v={"phi": 1e-3}, duration=100.0, method=method)
    assert info.value.motion.t[-1] == info.value.time
    assert info.value.motion.t[-1] < 0.01
    assert info.value.motion.statistics.steps < most


def noise_on_return(end: float) -> Any:
    """Return an input that is zero until times have passed to the end and begin again."""
    latest, noisy, rng = -np.inf, False, np.random.default_rng(0)

    def push(t: float) -> float:
        nonlocal latest, noisy
        latest = max(latest, t)
        noisy = noisy or (latest >= end and t < end / 2)
        return float(1e9 * rng.normal()) if noisy and t > end / 4 else 0.0

    return push


def test_a_curve_that_cannot_be_refined_ends_where_that_begins() -> None:
    """The steps came to the end, but no way leads to a state between two of them."""
    signal = mq.Input("push", noise_on_return(3.0))
    swinging = mq.Mechanism(
        name="swing",
        bodies=(mq.Body("ground"), mq.Body("block", mq.particle(1.0))),
        joints=(mq.Prismatic("slide", "ground", "block", axis=(1, 0, 0), coordinate="x"),),
        forces=(
            mq.JointForce("spring", "slide", -100 * sympy.sin(3 * sympy.Symbol("x"))),
            mq.JointForce("push", "slide", signal),
        ),
        inputs=(signal,),
        gravity=(0, 0, 0),
    )
    run = partial(mq.simulate, q=[1.0], rtol=1e-8, duration=3.0, max_step=1.0, method="dop853")
    with pytest.raises(mq.IntegrationError, match=r"no headway at t = .*until then is in") as info:
        run(swinging)
    motion = info.value.motion
    assert motion.t[-1] == info.value.time
    assert 0.5 < motion.t[-1] < 3.0
    quiet = run(replace(swinging, inputs=(mq.Input("push", 0.0),)))
    np.testing.assert_allclose(motion["x"], quiet(motion.t).q[:, 0], rtol=0, atol=1e-8)


@pytest.mark.parametrize("implicit", [False, True])
def test_a_way_without_end_is_given_up(implicit: bool) -> None:
    def rhs(t: float, y: np.ndarray) -> np.ndarray:
        return np.array([np.cos(1e5 * t)])

    task = IntegrationTask(rhs, implicit=implicit, rtol=1e-10, atol=1e-10)
    with pytest.raises(StalledError):
        advance_within(task, 0.0, np.zeros(1), 1.0)


@pytest.mark.parametrize("implicit", [False, True])
def test_the_first_fault_is_reported(implicit: bool) -> None:
    calls: list[float] = []

    def rhs(t: float, y: np.ndarray) -> np.ndarray:
        if t > 0.3:
            calls.append(t)
            raise ValueError(f"fault {len(calls)}")
        return np.ones(1)

    task = IntegrationTask(rhs, implicit=implicit, rtol=1e-8, atol=1e-8)
    with pytest.raises(EquationsError) as info:
        advance(task, 0.0, np.zeros(1), 1.0)
    assert str(info.value.__cause__) == "fault 1"


def test_unknown_events_and_reactions_are_refused(tmp_path: Path) -> None:
    gate = mq.Event("gate", "x")
    motion = mq.simulate(slider(), v=[1.0], duration=1.0, events=[gate])
    assert not len(motion.times("gate"))
    with pytest.raises(mq.UnknownNameError, match="unknown event 'gates'; did you mean 'gate'"):
        motion.times("gates")
    path = tmp_path / "motion.npz"
    motion.save(path)
    loaded = mq.Motion.load(path, slider())
    assert not len(loaded.times("gate"))
    with pytest.raises(mq.UnknownNameError, match="unknown event 'gates'; did you mean 'gate'"):
        loaded.times("gates")
    loop = mq.textbook.load("four_bar_linkage")
    swing = mq.simulate(loop, q={"phi": 1.1, "theta": -0.76, "psi": 1.25}, duration=0.1)
    with pytest.raises(mq.UnknownNameError, match="or contact 'E'; known: A, B, D, C"):
        swing.reactions("E")
