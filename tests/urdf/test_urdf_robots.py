"""Finding the robots of example-robot-data, and reading what is written of them."""

from __future__ import annotations

import pytest

import mecanique as mq
from mecanique.urdf.read import read_urdf
from mecanique.urdf.robots import robot, robots
from mecanique.urdf.write import write_urdf


def test_all_robots_have_a_name_of_their_own() -> None:
    assert len(robots()) == len({robot(name) for name in robots()}) == 69
    assert all(robot(name).is_file() for name in robots())


def test_names() -> None:
    assert robot("panda").name == "panda.urdf"
    assert robot("panda/panda") == robot("panda")
    assert robot("anymal_b_simple/anymal").parts[-3] == "anymal_b_simple_description"


def test_refusals() -> None:
    with pytest.raises(mq.UnknownNameError, match="unknown robot 'pandaa'; did you mean 'panda'"):
        robot("pandaa")
    with pytest.raises(mq.UnknownNameError, match="unknown robot 'nowhere/panda'"):
        robot("nowhere/panda")
    with pytest.raises(
        mq.InputError,
        match="several robots are called 'anymal'; expected one of 'anymal_b_simple/an",
    ):
        robot("anymal")


def test_data_not_installed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("mecanique.urdf.robots._data", lambda: iter(()))
    for cached in (robots.__globals__["_folders"], robots.__globals__["_files"]):
        cached.cache_clear()
    try:
        with pytest.raises(mq.InputError, match="pip install example-robot-data"):
            robot("panda")
    finally:
        monkeypatch.undo()
        assert robot("panda").is_file()


@pytest.mark.slow
def test_what_is_written_of_a_robot_is_read_again() -> None:
    """The first writing adds a world link; from then on reading and writing change nothing."""
    for name in robots():
        if name in ("alex_psyonic_hands", "ur3"):  # refused
            continue
        first = read_urdf(robot(name))
        text = write_urdf(first)
        second = read_urdf(text)
        assert write_urdf(second) == write_urdf(read_urdf(write_urdf(second))), name
        again = {body.name: body for body in second.bodies}
        for body in first.bodies:
            there = again[body.name]
            assert (there.mass, there.center, there.inertia) == (
                body.mass,
                body.center,
                body.inertia,
            ), name
        joints = {joint.name: joint for joint in second.joints}
        for joint in first.joints:
            assert joints[joint.name] == joint, name
        assert first.coordinates == second.coordinates, name
        assert first.forces == second.forces, name


@pytest.mark.parametrize("name", mq.textbook.names())
def test_what_is_written_of_a_textbook_system_is_read_again(name: str) -> None:
    """Springs, dampers and loops come back as they were; URDF has no words for loads and maps."""
    first = mq.textbook.load(name)
    second = read_urdf(write_urdf(first))
    assert write_urdf(second) == write_urdf(read_urdf(write_urdf(second)))
    loads = (mq.Force, mq.Torque, mq.JointForce)
    kept = [type(force) for force in first.forces if not isinstance(force, loads)]
    assert sorted(map(str, kept)) == sorted(str(type(force)) for force in second.forces)
    masses = {body.name: body.mass for body in second.bodies}
    for body in first.bodies:
        assert masses[body.name] == pytest.approx(first.evaluate(body.mass), rel=1e-15)
