"""Bodies without mass that only lead others transmit nothing, and are not cut free."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from systems import derive_system

import mecanique as mq

NEWTON_EULER, VIRTUAL_WORK = "newton_euler", "virtual_work"


@pytest.mark.parametrize(
    ("name", "idle", "bodies"),
    [
        ("rolling_coin", "", ["coin"]),
        ("free_particle", "", ["particle"]),
        (
            "ball_on_a_turntable",
            "slide_x, slide_y, lift and roll transmit nothing.",
            ["table", "ball"],
        ),
    ],
)
def test_a_body_that_moves_at_will_is_cut_free_alone(
    name: str, idle: str, bodies: list[str]
) -> None:
    text = " ".join(derive_system(name, NEWTON_EULER).text(steps=True).split())
    assert idle in text
    assert idle or "transmit" not in text  # a step that lists no reaction says nothing
    cut = [
        stage.title.removeprefix("Free body ").removesuffix(": forces")
        for stage in derive_system(name, NEWTON_EULER).steps
        if stage.title.endswith(": forces")
    ]
    assert cut == bodies
    titles = [stage.title for stage in derive_system(name, VIRTUAL_WORK).steps]
    held = [title for title in titles if title.startswith("Equilibrium")]
    assert held == [f"Equilibrium of {body}" for body in bodies]


def test_a_disk_in_the_plane_has_the_balances_of_its_book() -> None:
    """Goldstein, Classical Mechanics, sect. 2.4: weight, normal force and friction alone act."""
    lines = derive_system("rolling_disk", NEWTON_EULER).text(steps=True).splitlines()
    assert "     m R^2 turn''/2 = -R lambda_contact_x" in lines
    assert not any("R_roll_x" in line for line in lines if " = " in line)


def test_the_engine_finds_no_reaction_in_the_joints_that_lead() -> None:
    coin = mq.textbook.load("rolling_coin")
    reference, r = mq.Reference(coin), coin.values["r"]
    for seed in range(3):
        yaw, lean, turning, falling, spin = np.random.default_rng(seed).uniform(-1, 1, 5)
        s, c = np.sin(yaw), np.cos(yaw)
        ahead = r * (np.sin(lean) * turning + spin)
        aside = r * np.cos(lean) * falling
        q = {"z": r * np.cos(lean), "yaw": yaw, "lean": lean}
        v = {
            "x": c * ahead + s * aside,
            "y": s * ahead - c * aside,
            "z": -r * np.sin(lean) * falling,
        }
        v |= {"yaw": turning, "lean": falling, "spin": spin}
        reactions = reference.reactions(q, v)
        for joint in ("slide_x", "lift", "tilt", "axle"):
            wrench = reactions[joint]
            assert np.abs([*wrench.force, *wrench.moment]).max() < 1e-9


def test_what_is_pushed_on_its_way_is_cut_free() -> None:
    """A spring in the first slide acts on the body that leads, whose joint then transmits it."""
    particle = mq.textbook.load("free_particle")
    coil = mq.JointSpring("coil", "x", 3.0)
    held = replace(particle, forces=(coil,))
    lines = mq.derive(held, NEWTON_EULER).text(steps=True)
    assert "0 = -3 x - R_z_x" in lines
    assert (
        "The body along_y has no mass, and nothing else acts on it: the joints y and z together "
        in lines
    )
    assert mq.verify(held, samples=5).agrees


def followers(b: float, c: float) -> mq.Mechanism:
    """Three bars in a chain, of which the others follow the first by ratios b and c."""
    q, seat = mq.coordinate("a"), mq.Placement((0.0, 0.0, 0.2))
    chain = ("ground", "first", "second", "third")
    return mq.Mechanism(
        "followers",
        (mq.Body("ground"), *(mq.Body(name, mq.rod(2.0, 0.3)) for name in chain[1:])),
        tuple(
            mq.Revolute(
                f"j{k}", *chain[k : k + 2], axis=(0, 1, 0), coordinate="abc"[k], origin=seat
            )
            for k in range(3)
        ),
        coordinates=mq.Coordinates((), {"b": b * q, "c": c * q}),
    )


@pytest.mark.parametrize(("b", "c"), [(0.3, 0.25), (1.5, -2 / 3), (2.37, 1.0)])
def test_joints_that_follow_by_fractions_have_a_closed_form(b: float, c: float) -> None:
    """0.3 a and a/4 are multiples of a/20; whichever came first, the other was refused."""
    mechanism = followers(b, c)
    verdict = mq.verify(mechanism, samples=5)
    assert verdict.agrees
    assert "closed form" in verdict.table[0]
    assert mq.check(mechanism, mq.derive(mechanism).text()).right


def test_ratios_with_many_digits_are_refused_in_few() -> None:
    equations = mq.derive(followers(0.123456789, 1.0))
    assert not equations.symbolic
    assert "0.123457 × a, of which 1 × occurs: " in equations.why_not
    assert "round the ratios of the angles" in equations.why_not
