"""Systems with friction, stops and contacts: each is verified, written as URDF, and moves."""

from __future__ import annotations

import math
import re
from importlib import import_module

import pytest
from click.testing import CliRunner

import mecanique as mq
from mecanique.cli import app
from mecanique.motion.motion import Motion

NAMES = mq.textbook.names(corners=True)


def move(name: str) -> Motion:
    """Return the default motion of a system."""
    system = mq.textbook.entry(name)
    start, velocity = dict(system.start), dict(system.start_velocity)
    return mq.simulate(mq.textbook.load(name), q=start, v=velocity, duration=system.duration)


def when(motion: Motion, name: str) -> float:
    """Return when something happened last [s]."""
    return next(event.t for event in reversed(motion.events) if event.name == name)


@pytest.mark.parametrize("name", NAMES)
def test_each_system_is_stated_verified_and_read_back(name: str) -> None:
    system, mechanism = mq.textbook.entry(name), mq.textbook.load(name)
    statement = import_module(f"mecanique.textbook.corners.{name}").__doc__ or ""
    known = set(re.findall(r"\w+", statement))
    assert {parameter.symbol for parameter in system.parameters} <= known
    assert set(mechanism.coordinates) <= known
    assert mechanism.switching
    assert mq.verify(mechanism, samples=10).agrees
    read = mq.read_urdf(mq.write_urdf(mechanism))
    assert [element.states for element in read.switching] == [
        element.states for element in mechanism.switching
    ]
    motion = move(name)
    assert motion.events
    assert motion.audit().ok


def test_smooth_systems_and_those_with_corners_are_listed_apart() -> None:
    assert not set(NAMES) & set(mq.textbook.names())
    done = CliRunner().invoke(app, ["list", "--tag", "corners"])
    assert [line.split()[0] for line in done.output.splitlines()] == list(NAMES)


def test_an_unknown_name_offers_those_with_corners() -> None:
    with pytest.raises(mq.UnknownNameError, match="bouncing_ball"):
        mq.textbook.load("bouncing_bal")


def test_each_ends_when_its_book_says() -> None:
    g = 9.81
    expected = {
        ("block_on_incline", "dry: slips +"): 1 / (g * (math.sin(0.4) + 0.2 * math.cos(0.4))),
        ("dry_oscillator", "dry: sticks"): math.pi / 2,
        ("bouncing_ball", "floor: rest"): math.sqrt(2 / g) * 1.8 / 0.2,
        ("billiard_ball", "cloth: sticks"): 2 / (7 * 0.2 * g),
        ("clutch", "plates: sticks"): 40 / (3 * (1 / 0.5 + 1 / 0.2)),
    }
    for (name, event), time in expected.items():
        assert when(move(name), event) == pytest.approx(time, rel=1e-11, abs=0.0), name
    ladder = move("ladder")
    leaves = next(event for event in ladder.events if event.name == "wall: open")
    assert leaves.q[1] == pytest.approx(4 / 3 * math.cos(0.3), rel=1e-9, abs=0.0)


def test_run_writes_the_page_of_a_system_with_corners(tmp_path: object) -> None:
    done = CliRunner().invoke(app, ["run", "dry_oscillator", "-o", f"{tmp_path}/page.html"])
    assert done.exit_code == 0, done.output
    assert "dry_oscillator: agrees at 100 random states" in done.output
    assert "event dry: sticks: t = 1.5707" in done.output
