"""BLAS keeps to one thread where matrices are small, and gets its threads back."""

from __future__ import annotations

import pytest
import scipy.linalg  # noqa: F401  # so that its BLAS is there from the start
from threadpoolctl import threadpool_info

import mecanique as mq
from mecanique.threads import limit_threads


def threads() -> set[int]:
    """The numbers of threads that BLAS libraries may use."""
    return {
        library["num_threads"] for library in threadpool_info() if library["user_api"] == "blas"
    }


def test_a_motion_of_loops_uses_one_thread_and_gives_the_others_back() -> None:
    found: list[set[int]] = []
    before = threads()
    mq.simulate(
        mq.textbook.load("four_bar_linkage"),
        q=mq.textbook.entry("four_bar_linkage").start,
        duration=0.1,
        progress=lambda _: found.append(threads()),
    )
    assert found[0] == {1}
    assert threads() == before


def test_threads_come_back_after_an_error() -> None:
    def stop(_: float) -> None:
        raise RuntimeError("enough")

    before = threads()
    with pytest.raises(mq.IntegrationError, match="enough"):
        mq.simulate(
            mq.textbook.load("four_bar_linkage"),
            q=mq.textbook.entry("four_bar_linkage").start,
            duration=0.1,
            progress=stop,
        )
    assert threads() == before


def test_the_last_of_several_users_gives_the_threads_back() -> None:
    before = threads()
    with limit_threads():
        with limit_threads():
            assert threads() == {1}
        assert threads() == {1}
    assert threads() == before
