"""What a finished motion leaves behind: nothing but itself."""

from __future__ import annotations

import gc
import tracemalloc

import pytest

import mecanique as mq
from mecanique.motion.simulation.integrators.methods import IntegrationTask


@pytest.fixture(autouse=True, scope="module")
def _older() -> None:
    """Leave out what other tests have left, which takes a second to look through each time."""
    gc.collect()
    gc.freeze()


def tasks() -> int:
    gc.collect()
    return sum(isinstance(each, IntegrationTask) for each in gc.get_objects())


@pytest.mark.parametrize("method", ["dop853", "auto", "radau"])
def test_motion_after_motion_keeps_no_integrator_alive(method: str) -> None:
    mechanism = mq.textbook.load("double_pendulum")
    before = tasks()
    for _ in range(3):
        mq.simulate(
            mechanism, q=dict.fromkeys(mechanism.coordinates, 1.0), duration=0.2, method=method
        )
    assert tasks() <= before


@pytest.mark.slow
def test_a_restart_leaves_next_to_nothing_behind() -> None:
    """SciPy 1.17 never frees an integrator that it has run: one a motion, not one a restart."""
    mechanism = mq.textbook.load("four_bar_linkage")

    def run(duration: float) -> tuple[int, int]:
        gc.collect()
        before = tracemalloc.get_traced_memory()[0]
        motion = mq.simulate(mechanism, duration=duration, rtol=1e-8, method="dop853", samples=2)
        steps = motion.statistics.steps
        del motion
        gc.collect()
        return steps, tracemalloc.get_traced_memory()[0] - before

    run(0.1)
    tracemalloc.start()
    try:
        run(0.1)
        short, long = run(0.1), run(1.0)
    finally:
        tracemalloc.stop()
    assert long[0] > short[0] + 20
    assert long[1] - short[1] < 1000 * (long[0] - short[0])


def test_motions_that_are_kept_share_the_engine() -> None:
    """The dense output of a motion evaluates its equations, so that it keeps them alive."""
    reference = mq.Reference(mq.textbook.load("double_pendulum"))

    def run() -> mq.Motion:
        q = dict.fromkeys(reference.mechanism.coordinates, 1.0)
        return mq.simulate(
            reference.mechanism, q=q, duration=0.1, method="dop853", samples=2, reference=reference
        )

    run()
    tracemalloc.start()
    try:
        run()
        gc.collect()
        before = tracemalloc.get_traced_memory()[0]
        kept = [run() for _ in range(10)]
        gc.collect()
        each = (tracemalloc.get_traced_memory()[0] - before) / len(kept)
    finally:
        tracemalloc.stop()
    assert each < 12e3
