"""What a motion refuses: runs without headway, faults by their first cause, unknown names."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import sympy

import mecanique as mq
from mecanique.motion.simulation.methods import EquationsError, Task, advance


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
    assert info.value.motion.q[-1] == pytest.approx([5e-13], rel=0.1)


@pytest.mark.parametrize("implicit", [False, True])
def test_the_first_fault_is_reported(implicit: bool) -> None:
    calls: list[float] = []

    def rhs(t: float, y: np.ndarray) -> np.ndarray:
        if t > 0.3:
            calls.append(t)
            raise ValueError(f"fault {len(calls)}")
        return np.ones(1)

    task = Task(rhs, implicit=implicit, rtol=1e-8, atol=1e-8)
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
    # a file does not say what was watched for
    np.testing.assert_array_equal(mq.Motion.load(path, slider()).times("gate"), [])
    loop = mq.textbook.load("four_bar_linkage")
    swing = mq.simulate(loop, q={"phi": 1.1, "theta": -0.76, "psi": 1.25}, duration=0.1)
    with pytest.raises(mq.UnknownNameError, match="unknown joint or loop 'E'; known: A, B, D, C"):
        swing.reactions("E")
