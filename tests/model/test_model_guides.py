"""What guides joints on a coordinate map without being described, and what it leaves unknown."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import mecanique as mq
from mecanique.model.guides import guides_of
from mecanique.motion.analysis.forces import TOGETHER, Actions
from mecanique.viewing.scene.from_motion import scene_of

UP, ACROSS = (0.0, 0.0, 1.0), (0.0, -1.0, 0.0)


def load(name: str) -> mq.Mechanism:
    """A textbook system without the elements that hold it on its map."""
    return replace(mq.textbook.load(name), elements=())


def gripper(*names: str, **laws: object) -> mq.Mechanism:
    """An arm of two hinges with a hand, from which two fingers slide, and a tip on one of them."""
    q = mq.coordinate
    return mq.Mechanism(
        "gripper",
        (
            mq.Body("ground"),
            mq.Body("hand"),
            *(mq.Body(name, mq.rod(1.0, 0.4)) for name in ("upper", "lower", "one", "two", "tip")),
        ),
        (
            mq.Revolute("shoulder", "ground", "upper", axis=ACROSS),
            mq.Revolute("elbow", "upper", "lower", axis=ACROSS, origin=mq.Placement((0, 0, -0.4))),
            mq.Fixed("wrist", "lower", "hand", origin=mq.Placement((0, 0, -0.4))),
            mq.Prismatic("left", "hand", "one", axis=(1, 0, 0)),
            mq.Prismatic("right", "hand", "two", axis=(-1, 0, 0)),
            mq.Revolute("end", "one", "tip", axis=ACROSS),
        ),
        coordinates=mq.Coordinates(names, {"right": q("left"), **laws}),
    )


def test_no_map_no_guide() -> None:
    assert guides_of(mq.textbook.load("double_pendulum")) == ()
    assert mq.Reference(mq.textbook.load("four_bar_linkage")).guided == {}


def test_a_chart_guides_nothing() -> None:
    """As many coordinates as joints, only other ones: nothing holds the joints together."""
    a, b = mq.coordinate("a"), mq.coordinate("b")
    arm = gripper("a", "b", shoulder=a, elbow=b - a)
    assert [guide.joints for guide in guides_of(arm)] == [("left", "right")]
    assert guides_of(mq.textbook.load("particle_on_circle_x")) == ()


def test_a_guide_ties_what_the_slopes_of_the_map_tie() -> None:
    """sin² u and 3 sin² u of one u = a − 2 b hold each other, whatever b − a does."""
    a, b = mq.coordinate("a"), mq.coordinate("b")
    square = mq.sin(a - 2 * b) ** 2
    laws = {"x": square, "y": b - a, "z": 3 * square}
    sleds = mq.Mechanism(
        "sleds",
        (mq.Body("ground"), *(mq.Body(f"sled {name}", mq.ball(1.0, 0.1)) for name in laws)),
        tuple(
            mq.Prismatic(name, "ground", f"sled {name}", axis=(1, 0, 0), coordinate=name)
            for name in laws
        ),
        coordinates=mq.Coordinates(("a", "b"), laws),
    )
    assert [guide.joints for guide in guides_of(sleds)] == [("x", "z")]


def test_where_a_map_has_no_slope_near_the_neutral_position_its_letters_tie() -> None:
    """x = √(q - 5) begins at q = 5; y follows nothing."""
    names = ("q", "x", "y")
    mechanism = mq.Mechanism(
        "far",
        (mq.Body("ground"), *(mq.Body(f"sled {name}", mq.ball(1.0, 0.1)) for name in names)),
        tuple(
            mq.Prismatic(name, "ground", f"sled {name}", axis=(1, 0, 0), coordinate=name)
            for name in names
        ),
        coordinates=mq.Coordinates(("q", "y"), {"x": mq.sqrt(mq.coordinate("q") - 5)}),
    )
    (guide,) = guides_of(mechanism)
    assert guide.coordinates == ("q", "x")


def test_a_guide_reaches_the_bodies_between_its_joints_and_no_others() -> None:
    (guide,) = guides_of(gripper())
    assert guide.crossed == ("left", "right")
    tied = gripper(end=mq.coordinate("elbow"))
    guides = {guide.joints: guide.crossed for guide in guides_of(tied)}
    assert guides == {
        ("left", "right"): ("left", "right"),
        ("elbow", "end"): ("elbow", "wrist", "left", "end"),
    }


def test_what_prescribes_one_joint_is_part_of_its_reaction() -> None:
    driven = gripper(shoulder=mq.time())
    assert [guide.crossed for guide in guides_of(driven) if guide.joints == ("shoulder",)] == [()]
    assert "shoulder" not in mq.Reference(driven).guided


def test_screws_know_their_element() -> None:
    press = mq.textbook.load("screw_press")
    (guide,) = guides_of(press)
    assert guide.joints == ("thread", "bearing")
    nut = mq.Mechanism(
        "nut",
        (mq.Body("ground"), mq.Body("nut", mq.disk(1.0, 0.1))),
        (mq.Helical("thread", "ground", "nut", axis=UP, pitch=0.1),),
    )
    wrench = mq.Reference(nut).reactions([0.0])["thread"]
    assert wrench.undetermined == ()
    assert np.isfinite(wrench.force).all()


def test_a_grip_leaves_the_arm_its_reactions() -> None:
    hand = gripper()
    reference, ours = mq.Reference(hand), mq.derive(hand, method="newton_euler")
    q, v = np.full(hand.nq, 0.2), np.full(hand.nv, 0.3)
    reactions, totals = reference.reactions(q, v), reference.totals(q, v)
    for name, wrench in reactions.items():
        assert bool(wrench.reason) == (name in ("left", "right")), name
        if not wrench.reason:
            np.testing.assert_array_equal(wrench.force, totals[name].force)
    derived = ours.reactions(q, v)
    for name, (force, moment) in ours.totals(q, v).items():
        np.testing.assert_allclose(force, totals[name].force, rtol=0, atol=1e-11)
        np.testing.assert_allclose(moment, totals[name].moment, rtol=0, atol=1e-12)
        np.testing.assert_array_equal(
            np.isnan(derived[name].force), np.isnan(reactions[name].force)
        )
        np.testing.assert_array_equal(
            np.isnan(derived[name].moment), np.isnan(reactions[name].moment)
        )


def test_undetermined_components_have_names_and_a_reason() -> None:
    reference = mq.Reference(load("atwood_machine"))
    axle = reference.reactions({"x": 0.1})["axle"]
    assert axle.undetermined == ("force x", "force y", "force z", "moment x", "moment z")
    assert np.isnan(axle.force).all()
    assert axle.moment[1] == 0
    assert axle.reason == (
        "the coordinate map guides rail1, rail2 and axle together (x2 = -x, turn = x/R) and does "
        "not say by what: cords, gears or contacts may act across rail1, rail2 and axle"
    )
    assert reference.undetermined({"x": 0.1})["axle"] == axle.undetermined
    # about an axis of their own the unknown components stay apart from the known one
    assert axle.in_axes("child").undetermined == axle.undetermined
    assert axle.in_axes("child").moment[1] == 0


def test_a_universal_joint_transmits_no_moment_about_its_axes() -> None:
    """The first stands still in the parent, however the second turns the child."""
    cross = mq.Mechanism(
        "cross",
        (mq.Body("ground"), *(mq.Body(name, mq.ball(1.0, 0.1)) for name in ("arm", "slider"))),
        (
            mq.Universal("joint", "ground", "arm", names=("a", "b")),
            mq.Prismatic("rail", "ground", "slider", coordinate="x"),
        ),
        coordinates=mq.Coordinates(("a", "b"), {"x": mq.coordinate("a")}),
    )
    q = {"a": 0.4, "b": 0.3}
    ours = mq.derive(cross, method="newton_euler").reactions(q, None)["joint"]
    theirs = mq.Reference(cross).reactions(q)["joint"]
    assert theirs.undetermined == ("force x", "force y", "force z", "moment y", "moment z")
    for moment in (ours.moment, theirs.moment):
        np.testing.assert_array_equal(np.isnan(moment), [False, True, True])


@pytest.mark.parametrize("name", ["atwood_machine", "bars_and_springs", "double_atwood_machine"])
def test_the_sum_on_each_body_is_determined(name: str) -> None:
    mechanism = load(name)
    motion = mq.simulate(mechanism, duration=0.2)
    acting = Actions(mechanism, motion.reference)
    actions = list(acting.reactions(motion.t, motion.q, motion.v))
    assert {action.name for action in actions} == {TOGETHER}
    assert all(np.isfinite(action.force).all() for action in actions)
    assert motion.audit()


def test_the_derivation_names_totals_and_says_why() -> None:
    equations = mq.derive(load("bars_and_springs_small"), method="newton_euler")
    text = " ".join(equations.text(steps=True).split())
    assert "R_C" not in text
    assert "M_A" not in text
    assert "the coordinate map guides A, D and C together".lower() in text.lower()
    assert "moment of reaction and guides together across A on ABC" in text


def test_a_page_and_a_free_body_show_no_false_force(tmp_path: Path) -> None:
    motion = mq.simulate(load("atwood_machine"), duration=0.1)
    scene = scene_of(motion)
    assert not [arrow.name for arrow in scene.arrows if arrow.name.startswith("axle")]
    assert f"{TOGETHER} on pulley" in [arrow.name for arrow in scene.arrows]
    assert not [series for series in scene.series if series.group == "Reactions"]
    mq.export(motion, tmp_path / "page.html")
    assert "Undetermined reactions: the coordinate map" in (tmp_path / "page.html").read_text(
        encoding="utf-8"
    )
    mq.picture(motion, 0.0, tmp_path / "pulley.svg", free_body="pulley")
    assert "each by itself is undetermined" in (tmp_path / "pulley.svg").read_text(encoding="utf-8")
