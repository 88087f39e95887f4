"""Mechanisms in which nothing can move go through everything, with a sentence."""

from __future__ import annotations

from collections.abc import Callable
from math import pi
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import mecanique as mq
from mecanique.cli import app

G = 9.81

Build = Callable[[], mq.Mechanism]


def welded() -> mq.Mechanism:
    """Return two boxes of 1 kg and 2 kg, welded to the ground and to each other 1 m apart."""
    return mq.Mechanism(
        name="welded",
        bodies=(
            mq.Body("ground"),
            mq.Body("a", mq.box(1.0, (1, 1, 1))),
            mq.Body("b", mq.box(2.0, (1, 1, 1))),
        ),
        joints=(
            mq.Fixed("wall", "ground", "a"),
            mq.Fixed("seam", "a", "b", origin=mq.Placement((1, 0, 0))),
        ),
        gravity=(0, 0, -G),
    )


def welded_loop() -> mq.Mechanism:
    """Return the same, pinned to the ground once more."""
    m = welded()
    return mq.Mechanism(
        name="welded_loop",
        bodies=m.bodies,
        joints=m.joints,
        loops=(mq.Loop.pin("pin", "b", (0, 0, 0), "ground", (1, 0, 0)),),
        gravity=m.gravity,
    )


def truss() -> mq.Mechanism:
    """Return two bars of 1 m and 1 kg, 2 kg, pinned to the ground 1 m apart and to each other."""
    return mq.Mechanism(
        name="truss",
        bodies=(
            mq.Body("ground"),
            mq.Body("a", mq.rod(1.0, 1.0, (1, 0, 0))),
            mq.Body("b", mq.rod(2.0, 1.0, (1, 0, 0))),
        ),
        joints=(
            mq.Revolute("A", "ground", "a", axis=(0, -1, 0), coordinate="p"),
            mq.Revolute(
                "B",
                "ground",
                "b",
                axis=(0, -1, 0),
                origin=mq.Placement((1, 0, 0)),
                coordinate="r",
            ),
        ),
        loops=(mq.Loop.pin("C", "a", (1, 0, 0), "b", (1, 0, 0)),),
        gravity=(0, 0, -G),
    )


def flat() -> mq.Mechanism:
    """Return a chain of bars of 1, 2 and 1 m, stretched between pins 4 m apart."""
    return mq.Mechanism(
        name="flat",
        bodies=(
            mq.Body("ground"),
            mq.Body("a", mq.rod(1.0, 1.0, (1, 0, 0))),
            mq.Body("b", mq.rod(1.0, 2.0, (1, 0, 0))),
            mq.Body("c", mq.rod(1.0, 1.0, (1, 0, 0))),
        ),
        joints=(
            mq.Revolute("A", "ground", "a", axis=(0, -1, 0), coordinate="p"),
            mq.Revolute(
                "B", "a", "b", axis=(0, -1, 0), origin=mq.Placement((1, 0, 0)), coordinate="r"
            ),
            mq.Revolute(
                "D", "ground", "c", axis=(0, -1, 0), origin=mq.Placement((4, 0, 0)), coordinate="s"
            ),
        ),
        loops=(mq.Loop.pin("C", "b", (2, 0, 0), "c", (-1, 0, 0)),),
        gravity=(0, 0, -G),
    )


@pytest.mark.parametrize("method", ["lagrange", "newton_euler", "virtual_work"])
def test_no_coordinate_is_derived_with_a_sentence(method: str) -> None:
    equations = mq.derive(welded(), method=method)
    for text in (equations.text(), equations.latex(), equations.mathml()):
        assert "Nothing can move" in text
    for text in (equations.text(True), equations.latex(True), equations.mathml(True)):
        assert text.count("Nothing can move") == 1


def test_reactions_of_what_is_welded_are_derived() -> None:
    text = mq.derive(welded(), method="newton_euler").text(steps=True)
    assert "R_wall_z = 29.43" in text
    wrench = mq.Reference(welded()).reactions([], [])["wall"]
    np.testing.assert_allclose(wrench.force, (0, 0, 3 * G), rtol=1e-14, atol=0)
    np.testing.assert_allclose(wrench.moment, (0, -2 * G, 0), rtol=1e-14, atol=0)


@pytest.mark.parametrize("build", [welded, welded_loop, truss])
def test_what_cannot_move_is_compared(build: Build) -> None:
    assert mq.verify(build(), samples=5).agrees


@pytest.mark.parametrize("build", [welded, welded_loop])
def test_no_coordinate_rests_in_one_equilibrium(build: Build) -> None:
    (rest,) = mq.equilibria(build(), 3)
    assert rest.stable
    assert "nothing can move there" in str(rest)
    linear = mq.linearize(build())
    assert linear.frequencies.shape == (0,)
    assert linear.modes.shape == (0, 0)


def test_no_coordinate_is_no_motion() -> None:
    for simulate in (mq.simulate, mq.simulate_many):
        with pytest.raises(mq.InputError, match="nothing in it can be set in motion"):
            simulate(welded())


def test_a_truss_rests() -> None:
    given = {"p": 1.0, "r": 2.0}
    linear = mq.linearize(truss(), given)
    np.testing.assert_allclose(linear.q, (pi / 3, 2 * pi / 3), rtol=1e-12, atol=0)
    assert linear.modes.shape == (2, 0)
    assert len(mq.equilibria(truss(), 5)) == 2
    motion = mq.simulate(truss(), q=given, duration=1.0)
    np.testing.assert_allclose(motion.q[-1], motion.q[0], rtol=0, atol=1e-13)
    # each pin on the ground carries half of its bar, and the other bar's half by the top
    push = 3 / 4 * G / np.tan(pi / 3)
    np.testing.assert_allclose(
        motion.reactions("A").force[-1], (push, 0, 1.25 * G), rtol=0, atol=1e-12
    )


LOCKED = "'flat' is locked in a singular position"


def test_locked_in_a_singular_position_is_refused() -> None:
    assert mq.degrees_of_freedom(flat()).N == 0
    for use in (
        mq.simulate,
        mq.linearize,
        lambda m: mq.linearize(m, at=[0, 0, 0]),
        mq.equilibria,
        lambda m: mq.verify(m, 5),
        lambda m: mq.Reference(m).acceleration([0, 0, 0]),
        lambda m: mq.Reference(m).reactions([0, 0, 0]),
        lambda m: mq.Reference(m).multipliers([0, 0, 0]),
        lambda m: mq.derive(m).acceleration([0, 0, 0], [0, 0, 0]),
        lambda m: mq.derive(m, "newton_euler").acceleration([0, 0, 0], [0, 0, 0]),
        lambda m: mq.derive(m, "virtual_work").multipliers([0, 0, 0], [0, 0, 0]),
    ):
        with pytest.raises(mq.InputError, match=LOCKED):
            use(flat())


def test_what_can_be_closed_elsewhere_only_is_not_locked() -> None:
    """A truss closes far from its neutral position; its accelerations are zero there."""
    q = mq.assemble(truss())
    np.testing.assert_allclose(mq.Reference(truss()).acceleration(q), (0, 0), rtol=0, atol=1e-14)
    linear = mq.linearize(truss())
    assert "nothing can move there, so there is no mode" in str(linear)
    assert "of 2 equilibria that 20 random starts lead to, the stable one" in linear.chosen


SENTENCES = {
    # nothing is solved for: the equations hold, if only as a sentence
    ("derive", "welded"): (0, "Nothing can move: there is no coordinate"),
    ("derive", "welded_loop"): (0, "Nothing can move: there is no coordinate"),
    ("derive", "truss"): (0, "lambda_C_x"),
    ("derive", "flat"): (0, "lambda_C_x"),
    # what rests is an equilibrium, without any mode
    ("linearize", "welded"): (0, "nothing can move there, so there is no mode"),
    ("linearize", "welded_loop"): (0, "nothing can move there, so there is no mode"),
    ("linearize", "truss"): (0, "nothing can move there, so there is no mode"),
    ("linearize", "flat"): (2, LOCKED),
    # a truss has coordinates and stays where it is; without coordinates there is no motion
    ("simulate", "welded"): (2, "nothing in it can be set in motion"),
    ("simulate", "welded_loop"): (2, "nothing in it can be set in motion"),
    ("simulate", "truss"): (0, "truss"),
    ("simulate", "flat"): (2, LOCKED),
    ("export", "welded"): (2, "nothing in it can be set in motion"),
    ("export", "welded_loop"): (2, "nothing in it can be set in motion"),
    ("export", "truss"): (0, "Wrote"),
    ("export", "flat"): (2, LOCKED),
    ("verify", "welded"): (0, "agrees"),
    ("verify", "welded_loop"): (0, "agrees"),
    ("verify", "truss"): (0, "agrees"),
    ("verify", "flat"): (2, LOCKED),
}
"""Exit code and sentence of each verb; 2 means that there is nothing to answer with."""


@pytest.mark.parametrize("build", [welded, welded_loop, truss, flat])
@pytest.mark.parametrize("verb", ["derive", "linearize", "simulate", "export", "verify"])
def test_command_line_says_a_sentence(build: Build, verb: str, tmp_path: Path) -> None:
    path = tmp_path / "still.urdf"
    mq.write_urdf(build(), path)
    more = {
        "simulate": ["--duration", "0.1"],
        "export": ["--duration", "0.1", "--output", str(tmp_path / "page.html")],
        "verify": ["--samples", "5"],
    }
    code, sentence = SENTENCES[verb, build.__name__]
    result = CliRunner().invoke(app, [verb, str(path), *more.get(verb, [])])
    assert result.exit_code == code, result.output
    assert sentence in " ".join(result.output.split())
