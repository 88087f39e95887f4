"""Wheels, balls and blades in a description: what is sound, and what is refused."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from mecanique.errors import InputError, MechanismError
from mecanique.model import (
    Blade,
    Body,
    Floating,
    Mechanism,
    Parameter,
    Rolling,
    ball,
    disk,
)

r = Parameter("r", 0.3, "m", "radius")


def wheel(**given: Any) -> Mechanism:
    """A disk that rolls."""
    options: dict[str, Any] = {"name": "rim", "body": "disk", "radius": r, **given}
    return Mechanism(
        "wheel",
        (Body("ground"), Body("disk", disk(1.0, r).at(rpy=(1.5707963267948966, 0, 0)))),
        (Floating("free", "ground", "disk"),),
        parameters=(r,),
        contacts=(Rolling(**options),),
    )


def test_a_contact_restricts_and_is_named() -> None:
    mechanism = wheel()
    assert mechanism.constrained
    assert mechanism.rolls
    assert mechanism.contacts[0].rows == ("normal", "x", "y")
    assert not Mechanism("m", (Body("ground"),), ()).constrained


def test_a_ball_has_its_radius_for_crown() -> None:
    assert Rolling("b", "ball", 0.2, axis=None).crown == 0.2


def test_axes_get_unit_length() -> None:
    assert Rolling("b", "disk", 0.2, axis=(0, 3, 4)).axis == (0.0, 0.6, 0.8)
    assert Blade("b", "sleigh", along=(2, 0, 0), normal=(0, 0, 5)).side == (0.0, 1.0, 0.0)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"body": "wheel"}, "contact 'rim': 'wheel' is no body"),
        ({"on": "table"}, "contact 'rim': 'table' is no body"),
        ({"on": "disk"}, "contact 'rim': body 'disk' touches itself"),
        ({"radius": -0.1}, "contact 'rim': expected a radius above 0, got -0.1"),
        ({"radius": 0.3, "crown": 0.4}, "a sharp edge, to the radius 0.3, a ball, got 0.4"),
        ({"radius": Parameter("R", 1.0)}, "contact 'rim' depends on 'R', which is not declared"),
        (
            {"axis": None, "bowl": 0.2},
            "a bowl's radius above the ball's 0.3, or minus that of a dome",
        ),
        ({"axis": None, "stretch": (1, 0, 1)}, "contact 'rim': expected a stretch above 0, got 0"),
    ],
)
def test_wrong_data_is_refused_with_its_place(given: dict[str, Any], message: str) -> None:
    with pytest.raises(MechanismError, match=message):
        wheel(**given)


def test_directions_without_length_are_refused() -> None:
    with pytest.raises(InputError, match="with a length for the axis of rolling 'rim'"):
        wheel(axis=(0, 0, 0))
    with pytest.raises(InputError, match="with a length for normal × along of blade 'edge'"):
        Blade("edge", "sleigh", along=(0, 0, 1))


def test_surfaces_that_do_not_go_together_are_refused() -> None:
    with pytest.raises(InputError, match="expected a ball in a bowl, got a wheel"):
        wheel(bowl=2.0)
    with pytest.raises(InputError, match="expected a stretch of a ball on a plane only"):
        wheel(axis=None, bowl=2.0, stretch=(1, 2, 1))


def test_names_are_there_once() -> None:
    with pytest.raises(MechanismError, match="loop or contact 'rim' is there 2 times"):
        Mechanism(
            "two",
            (Body("ground"), Body("ball", ball(1.0, r))),
            (Floating("free", "ground", "ball"),),
            parameters=(r,),
            contacts=(Rolling("rim", "ball", r, axis=None), Blade("rim", "ball")),
        )


@pytest.mark.parametrize(
    ("normal", "along"),
    [((2, -1, 3), (1, 4, -2)), ((0.5, 2, 0.25), (-3, 1, 1)), ((0, 0, 2), (3, 1, 0))],
)
def test_the_side_of_a_blade_is_across_its_normal_and_the_way_along(
    normal: tuple[float, float, float], along: tuple[float, float, float]
) -> None:
    across = np.cross(normal, along)
    side = Blade("blade", "sleigh", normal=normal, along=along).side
    np.testing.assert_allclose(side, across / np.linalg.norm(across), rtol=0, atol=1e-15)
