"""Constraints on velocities are written into URDF and read back."""

from __future__ import annotations

import numpy as np
import pytest

import mecanique as mq

q = mq.Parameter("q", 0.25, "m", "an arm")


def sleigh(*, planar: bool = False) -> mq.Mechanism:
    """A sleigh whose edge stands off its center, driven along by a conveyor in time."""
    turn, y = mq.coordinate("turn"), mq.coordinate("y")
    edge = mq.VelocityConstraint(
        "edge",
        {"x": mq.sin(turn), "y'": -mq.cos(turn), "turn": q * mq.sqrt(1 + y**2 / 3)},
        rate=0.1 * mq.sin(2 * mq.time()),
    )
    board = mq.Body("board", mq.box(2.0, (1.0, 0.4, 0.1)))
    joints: tuple[mq.Joint, ...] = (
        mq.Prismatic("slide_x", "ground", "along", axis=(1, 0, 0), coordinate="x"),
        mq.Prismatic("slide_y", "along", "across", axis=(0, 1, 0), coordinate="y"),
        mq.Revolute("heading", "across", "board", axis=(0, 0, 1), coordinate="turn"),
    )
    bodies: tuple[mq.Body, ...] = (
        mq.Body("ground"),
        mq.Body("along"),
        mq.Body("across"),
        board,
    )
    if planar:
        joints = (mq.Planar("plane", "ground", "board", names=("x", "y", "turn")),)
        bodies = (mq.Body("ground"), board)
    return mq.Mechanism("sleigh", bodies, joints, velocity_constraints=(edge,), parameters=(q,))


def test_it_is_read_back_with_the_same_equations() -> None:
    machine = sleigh()
    text = mq.write_urdf(machine)
    assert 'xmlns:mecanique="urn:mecanique"' in text
    assert '<mecanique:term joint="slide_x" coefficient="sin(heading)"/>' in text
    again = mq.read_urdf(text)
    assert tuple(again.coordinates) == ("slide_x", "slide_y", "heading")
    place, v, t = [0.3, -0.4, 0.7], [0.5, 0.2, -0.6], 0.9
    found, wanted = (mq.derive(each).acceleration(place, v, t) for each in (again, machine))
    np.testing.assert_allclose(found, wanted, rtol=1e-14, atol=0)
    assert mq.verify(again, samples=5).agrees
    tag = text[text.index("<mecanique:velocity_constraint") :]
    assert mq.write_urdf(again).endswith(tag)


def test_lint_says_who_reads_it() -> None:
    found = {finding.code for finding in mq.lint(mq.write_urdf(sleigh()))}
    assert "M610" in found
    assert not {code for code in found if code in ("M105", "M601", "M604")}


def test_one_of_a_planar_joint_stays_a_comment() -> None:
    text = mq.write_urdf(sleigh(planar=True))
    assert "velocity constraint edge: URDF has no tag for it, as it is one of coord" in text
    assert not mq.read_urdf(text).velocity_constraints


@pytest.mark.parametrize(
    ("before", "after", "message"),
    [
        ('joint="slide_x"', 'joint="nothing"', "'nothing' is no joint"),
        ('"sin(heading)"', '"sin(heading"', "expected an expression in names of joints and t"),
        ('"sin(heading)"', '"open(heading)"', "(open(heading) is none)"),
        ('"sin(heading)"', '"heading**heading"', "powers are to be numbers up to 100"),
        ('"sin(heading)"', '"9**9**9**9"', "powers are to be numbers up to 100"),
        ('"sin(heading)"', '"((9**99)**99)**99"', "powers are to be numbers up to 100 in all"),
        ('"sin(heading)"', '"().__class__"', "is none)"),
        ('"sin(heading)"', '"sin(nobody)"', "'nobody', no coordinate or parameter"),
    ],
)
def test_what_cannot_be_read_is_reported(before: str, after: str, message: str) -> None:
    text = mq.write_urdf(sleigh())
    assert before in text
    found = mq.lint(text.replace(before, after, 1))
    assert any(message in finding.message for finding in found), [str(each) for each in found]
