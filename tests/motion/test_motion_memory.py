"""What a finished motion leaves behind: nothing but itself."""

from __future__ import annotations

import gc

import pytest

import mecanique as mq
from mecanique.motion.simulation.methods import Task


def tasks() -> int:
    gc.collect()
    return sum(isinstance(each, Task) for each in gc.get_objects())


@pytest.mark.parametrize("method", ["dop853", "auto", "radau"])
def test_motion_after_motion_keeps_no_integrator_alive(method: str) -> None:
    mechanism = mq.textbook.load("double_pendulum")
    before = tasks()
    for _ in range(5):
        mq.simulate(
            mechanism, q=dict.fromkeys(mechanism.coordinates, 1.0), duration=0.2, method=method
        )
    assert tasks() <= before
