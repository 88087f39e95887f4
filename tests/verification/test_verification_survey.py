"""Whole collections: what agrees, what is refused and why."""

from __future__ import annotations

import json
from collections.abc import Iterator
from time import perf_counter

import pytest

import mecanique as mq
from mecanique.errors import InputError, UnknownNameError
from mecanique.verification import survey as module
from mecanique.verification.survey import Entry, Survey, survey_robots, survey_systems


def test_robots_agree_or_are_refused_with_the_reason() -> None:
    reported: list[float] = []
    start = perf_counter()
    found = survey_robots(
        5, only=("TwoDofs", "ur3", "allegro_left_hand", "solo"), progress=reported.append
    )
    assert [(e.name, e.root, e.velocities) for e in found.entries if not e.refused] == [
        ("TwoDofs", "fixed", 2),
        ("TwoDofs", "floating", 8),
        ("allegro_left_hand", "fixed", 16),
        ("allegro_left_hand", "floating", 22),
        ("solo", "fixed", 8),
        ("solo", "floating", 14),
    ]
    assert found.agrees
    assert sum(entry.seconds for entry in found.entries) < found.seconds < perf_counter() - start
    assert reported == [k / 8 for k in range(1, 9)]
    text = str(found)
    assert "line 6: the robot has no name (and 1 more)" in text
    assert "site-packages" not in text
    assert "6 of 6 agree at 5 random states (seed 0)" in text
    assert "1 refused" in text


def test_two_processes_find_the_same() -> None:
    one, two = (survey_robots(3, only=("TwoDofs", "finger_edu"), processes=k) for k in (1, 2))
    for a, b in zip(one.entries, two.entries, strict=True):
        assert (a.name, a.root, a.velocities, a.worst) == (b.name, b.root, b.velocities, b.worst)


def test_every_system_is_looked_at(monkeypatch: pytest.MonkeyPatch) -> None:
    def entries(one: object, tasks: list[tuple[str, str]], processes: int) -> Iterator[Entry]:
        yield from (Entry(name, root, 1, 1e-14, "bias", "", 0.1) for name, root in tasks)

    monkeypatch.setattr(module, "_entries", entries)
    assert [entry.name for entry in survey_systems().entries] == list(mq.textbook.names())


def test_a_disagreement_is_seen() -> None:
    good, bad = (
        Entry("a", "", 1, 1e-14, "bias", "", 0.1),
        Entry("b", "", 2, float("inf"), "forces", "", 0.1),
    )
    found = Survey((good, bad), 100, 0, 1e-9, 1.0)
    assert not found.agrees
    assert "1 of 2 agree" in found.summary
    assert "DISAGREE: b" in found.summary
    assert "DISAGREES: forces" in str(found).splitlines()[2]
    data = json.loads(found.to_json())
    assert data["agrees"] is False
    assert data["entries"][1]["worst"] is None


def test_a_fault_of_ours_is_reported_and_counts(monkeypatch: pytest.MonkeyPatch) -> None:
    from mecanique.verification import compare

    def broken(*words: object, **more: object) -> None:
        raise IndexError("index 0 is out of bounds")

    monkeypatch.setattr(compare, "compare", broken)
    found = survey_robots(2, only=("TwoDofs",))
    assert not found.agrees
    assert "DISAGREES: IndexError: index 0 is out of bounds" in str(found)


def test_bad_words_are_refused() -> None:
    with pytest.raises(UnknownNameError, match="unknown robot 'pandra'; did you mean 'panda'"):
        survey_robots(only=("pandra",))
    with pytest.raises(
        InputError, match="expected a whole number of at least 1 for processes, got 0"
    ):
        survey_robots(processes=0)


@pytest.mark.parametrize("name", ["iris_simple", "quadrotor_base"])
def test_a_single_link_held_fast_has_nothing_to_disagree_about(name: str) -> None:
    verdict = mq.verify(mq.read_urdf(mq.robot(name)), 3)
    assert verdict.agrees
    assert verdict.velocities == ()
