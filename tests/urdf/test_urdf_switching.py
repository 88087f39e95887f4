"""Friction, stops and contacts that open, in URDF: round trips and faults."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import mecanique as mq

BLOCK = mq.Mechanism(
    "block",
    (mq.Body("ground"), mq.Body("block", mq.box(1.0, (0.1, 0.1, 0.1)))),
    (mq.Prismatic("slide", "ground", "block", axis=(1, 0, 0), coordinate="slide"),),
    switching=(
        mq.Friction("dry", "slide", 0.2, 9.81, mu_static=0.25, speed=0.1),
        mq.Stop("wall", "slide", at=1.0, restitution=0.5),
        mq.Stop("buffer", "slide", at=-1.0, side=-1, stiffness=500.0),
        mq.Stop("latch", "slide", at=2.0, holds=3.0),
        mq.Friction("brake", "slide", 0.2, load="wall"),
    ),
)
BALL = mq.Mechanism(
    "ball",
    (mq.Body("ground"), mq.Body("carriage", mq.massless()), mq.Body("ball", mq.ball(1.0, 0.1))),
    (
        mq.Prismatic("x", "ground", "carriage", axis=(1, 0, 0), coordinate="x"),
        mq.Prismatic("z", "carriage", "ball", axis=(0, 0, 1), coordinate="z"),
    ),
    switching=(
        mq.Contact("floor", "ball", radius=0.1, mu=0.3, restitution=0.8, law="poisson"),
        mq.Contact("bowl", "ball", (0, 0, 0.1), bowl=2.0, in_turn=True),
        mq.Contact("rim", "ball", radius=0.05, axis=(0, 1, 0), plane=mq.Placement((0, 0, -1))),
        mq.Contact("side", "ball", radius=0.1, length=3.0),
    ),
)


@pytest.mark.parametrize("mechanism", [BLOCK, BALL], ids=["block", "ball"])
def test_elements_that_switch_come_back_from_urdf(mechanism: mq.Mechanism) -> None:
    read = mq.read_urdf(mq.write_urdf(mechanism))
    for given, back in zip(mechanism.switching, read.switching, strict=True):
        assert back == given
    assert mq.write_urdf(read).count("<mecanique:") == len(mechanism.switching)


def test_a_block_that_was_read_moves_and_is_verified_as_the_given_one() -> None:
    read = mq.read_urdf(mq.write_urdf(BLOCK))
    assert mq.verify(read, samples=5).agrees
    ours = mq.simulate(BLOCK, v={"slide": 3.0}, duration=2.0)
    theirs = mq.simulate(read, v={"slide": 3.0}, duration=2.0)
    assert [event.name for event in theirs.events] == [event.name for event in ours.events]
    np.testing.assert_allclose(theirs.q, ours.q, rtol=0, atol=1e-14)


def test_a_contact_with_a_link_that_is_welded_to_the_world_is_verified() -> None:
    thrown = replace(BALL, switching=BALL.switching[:1])
    read = mq.read_urdf(mq.write_urdf(thrown))
    assert read.ground != "ground"
    assert mq.verify(read, samples=5).agrees


def test_a_load_that_varies_is_refused() -> None:
    pressed = replace(BLOCK, switching=(mq.Friction("dry", "slide", 0.2, 5.0 * mq.time() ** 2),))
    with pytest.raises(mq.UrdfError, match="friction 'dry': its load depends on t, and URDF holds"):
        mq.write_urdf(pressed)


@pytest.mark.parametrize(
    ("tag", "message"),
    [
        ('friction name="f" joint="arm" mu="0.2"', "'arm' is no joint"),
        ('friction name="f" joint="slide" mu="-0.2"', "expected a coefficient of friction of at"),
        ('friction name="f" joint="slide" mu="much"', "expected a finite number for mu"),
        ('stop name="f" joint="slide" side="2"', "expected side 1 or -1, got '2'"),
        ('stop name="f" at="1"', "has no joint="),
        ('contact name="f" link="block" on="sky"', "'sky' is no link"),
        ('contact name="f" link="block" on="world" law="x"', "expected law newton or poisson, got"),
        ('contact name="f" link="block" on="world" center="0 0"', "expected 3 numbers for center"),
        ('contact name="f" link="block" on="world" radius="-1"', "expected a radius"),
        (
            'contact name="f" link="block" on="world" radius="1" axis="0 1 0" bowl="3"',
            "expected a ball in a bowl, got a wheel",
        ),
        ('contact name="f" link="block" on="block"', "both of its ends are on link 'block'"),
    ],
)
def test_faults_of_tags_are_named_with_their_line(tag: str, message: str, tmp_path: Path) -> None:
    written = mq.write_urdf(replace(BLOCK, switching=()))
    head = 'xmlns:mecanique="urn:mecanique" name="block"'
    text = written.replace('name="block"', head, 1).replace(
        "</robot>", f"<mecanique:{tag}/></robot>"
    )
    file = tmp_path / "block.urdf"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(mq.MecaniqueError, match=message):
        mq.read_urdf(file)


def test_lint_knows_every_attribute_that_is_read() -> None:
    rolls = (
        '<mecanique:rolling name="r" link="ball" on="world" radius="0.1" bowl="2" friction="1"/>'
    )
    ball = mq.write_urdf(BALL).replace("</robot>", f"{rolls}</robot>")
    for text in (mq.write_urdf(BLOCK), ball):
        said = [str(finding) for finding in mq.lint(text)]
        assert not [line for line in said if "mecanique:" in line and "not read" in line], said
    misspelled = mq.write_urdf(BLOCK).replace("mu_static", "mu_statc")
    assert any("mu_static" in str(finding) for finding in mq.lint(misspelled))
