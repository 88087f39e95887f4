"""Cords with a stretch that turns: the map is given, and the tension is right all the same."""

from __future__ import annotations

import numpy as np
import pytest

import mecanique as mq
from mecanique.errors import EngineError
from mecanique.model import Coordinates, Cord, Placement, Prismatic, Pulley, box, coordinate, sqrt

HERE = (0.0, 0.0, 0.0)
m, M, h, g = 1.0, 1.5, 1.0, 9.81


def collar(*, map_given: bool = True, gravity: float = g) -> mq.Mechanism:
    """A collar on a level rail, pulled by a weight over a small pulley at the height h above it."""
    x = coordinate("x")
    law = Coordinates(("x",), {"up": sqrt(x**2 + h**2) - h}) if map_given else Coordinates(())
    return mq.Mechanism(
        name="collar_and_weight",
        bodies=(
            mq.Body("ground"),
            mq.Body("collar", box(m, (0.1, 0.1, 0.1))),
            mq.Body("weight", box(M, (0.1, 0.1, 0.1))),
        ),
        joints=(
            Prismatic(
                "rail",
                "ground",
                "collar",
                axis=(1, 0, 0),
                origin=Placement((0, 0, -h)),
                coordinate="x",
            ),
            Prismatic(
                "lift",
                "ground",
                "weight",
                axis=(0, 0, 1),
                origin=Placement((-1, 0, -2)),
                coordinate="up",
            ),
        ),
        coordinates=law,
        elements=(
            Cord(
                "rope",
                ("weight", HERE),
                (Pulley("ground", center=(-1, 0, 0), grips=False), Pulley("ground", grips=False)),
                ("collar", HERE),
            ),
        ),
        gravity=(0, 0, -gravity),
    )


def expected(x: float, v: float) -> tuple[float, float]:
    """Acceleration and tension: m x'' = −T s, M up'' = T − M g, with s = x/√(x² + h²)."""
    length = np.hypot(x, h)
    s, turning = x / length, (1 - (x / length) ** 2) * v**2 / length
    a = -M * (g + turning) * s / (m + M * s * s)
    return a, M * (g + s * a + turning)


@pytest.mark.parametrize(("x", "v"), [(0.6, 0.9), (-0.4, 1.3), (1.7, 0.0)])
def test_motion_tension_and_reaction_follow_the_turning_stretch(x: float, v: float) -> None:
    machine = collar()
    a, tension = expected(x, v)
    reference = mq.Reference(machine)
    assert reference.guided == {}
    assert reference.guide_forces([x], [v])["rope"] == pytest.approx(tension, rel=1e-12)
    up = tension * h / np.hypot(x, h)  # the rope lifts the collar, the rail bears the rest
    rail = reference.reactions([x], [v])["rail"].force
    np.testing.assert_allclose(rail, [0, 0, m * g - up], rtol=0, atol=1e-12)
    for method in ("lagrange", "newton_euler", "virtual_work"):
        equations = mq.derive(machine, method=method)
        assert equations.acceleration([x], [v]) == pytest.approx(a, rel=1e-12)
    by_bodies = mq.derive(machine, method="newton_euler")
    assert by_bodies.guide_forces([x], [v])["rope"] == pytest.approx(tension, rel=1e-12)
    np.testing.assert_allclose(by_bodies.reactions([x], [v])["rail"][0], rail, rtol=0, atol=1e-13)
    assert mq.verify(machine, samples=3).agrees


def test_the_tension_stands_in_the_steps() -> None:
    text = mq.derive(collar(), method="newton_euler").text(steps=True)
    assert "T_rope" in text
    assert "undetermined" not in text


def test_without_the_map_it_is_refused_with_the_remedy() -> None:
    with pytest.raises(
        EngineError,
        match=r"cord 'rope' does not fit the coordinate map.*a stretch that turns adds no law.*"
        r"Coordinates\(…, \{'up': …\}\)",
    ):
        mq.Reference(collar(map_given=False)).acceleration([0.3, 0.0], [0.0, 0.0])


def test_a_cord_that_is_slack_at_the_start_is_an_event_there() -> None:
    """Where weights rise the rope would have to push, from the beginning."""
    motion = mq.simulate(collar(gravity=-g), q={"x": 0.6}, duration=0.1)
    assert [(event.name, event.t) for event in motion.events] == [("rope would push", 0.0)]
    assert "event rope would push: t = 0 s" in motion.summary()
    assert mq.simulate(collar(), q={"x": 0.6}, duration=0.1).events == ()


@pytest.mark.parametrize("sense", [1, -1])
def test_a_thread_comes_down_at_the_side_of_its_sense(sense: int) -> None:
    """A drum M, R lets a weight m down at its right, for sense 1, by m g/(m + M/2)."""
    R, mass = 0.3, 4.0
    drum = mq.disk(mass, R).at(rpy=(np.pi / 2, 0, 0))
    bodies = mq.Body("ground"), mq.Body("drum", drum), mq.Body("load", mq.particle(m))
    at = Placement((sense * R, 0, -1.0))
    winch = mq.Mechanism(
        "winch",
        bodies,
        (
            mq.Revolute("axle", "ground", "drum", axis=(0, -1, 0), coordinate="q"),
            Prismatic("slide", "ground", "load", axis=(0, 0, 1), origin=at, coordinate="z"),
        ),
        elements=(Cord("thread", ("load", HERE), (Pulley("drum", R, sense=sense),)),),
    )
    motion = mq.simulate(winch, duration=0.5)
    fall = m * g / (m + mass / 2)
    np.testing.assert_allclose(motion.v[-1], [-fall * 0.5], rtol=1e-9, atol=0)
