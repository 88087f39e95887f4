"""Gears, racks and cords along slides add to the coordinate map what it leaves open."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from itertools import permutations, product
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import mecanique as mq
from mecanique import textbook
from mecanique.model import Coordinates
from mecanique.model.expression import evaluate, plain
from mecanique.model.mechanism import element_laws
from mecanique.model.placement import pose_of, rpy_of

HERE = (0.0, 0.0, 0.0)
UP = (0.0, 0.0, 1.0)


@pytest.mark.parametrize("name", ["planetary_gear", "atwood_machine", "double_atwood_machine"])
def test_textbook_maps_follow_from_their_elements(name: str) -> None:
    mechanism = textbook.load(name)
    free = replace(mechanism, coordinates=Coordinates(mechanism.coordinates.names))
    assert free.coordinates.names == mechanism.coordinates.names
    assert free.coordinates.driven.keys() == mechanism.coordinates.driven.keys()
    for joint, law in mechanism.coordinates.driven.items():
        assert plain(law - free.coordinates.driven[joint]).simplify() == 0, joint
    assert mq.verify(free, samples=5).agrees


def train(**more: object) -> mq.Mechanism:
    """Three wheels on parallel axles, the middle one double."""
    r, s = mq.Parameter("r", 0.1, "m"), mq.Parameter("s", 0.3, "m")
    wheel = mq.Shape(1.0, HERE, (0.01, 0.01, 0.02, 0, 0, 0))
    places = {"first": 0.0, "second": r + s, "third": r + s + r + s}
    return mq.Mechanism(
        "train",
        (mq.Body("ground"), *(mq.Body(name, wheel) for name in places)),
        tuple(
            mq.Revolute(name, "ground", name, axis=UP, origin=mq.Placement((x, 0, 0)))
            for name, x in places.items()
        ),
        elements=(
            mq.Gear("a", "first", "second", r, other_radius=s),
            mq.Gear("b", "second", "third", r, other_radius=s),
        ),
        parameters=(r, s),
        **more,  # type: ignore[arg-type]
    )


def test_wheels_in_series_leave_one_coordinate() -> None:
    mechanism = train()
    assert tuple(mechanism.coordinates) == ("first",)
    r, s = (mq.Parameter(name, 1.0, "m") for name in "rs")
    first = mq.coordinate("first")
    assert plain(mechanism.coordinates.driven["third"] - first * r**2 / s**2) == 0
    # reflected inertia: J (1 + (r/s)² + (r/s)⁴)
    (found,) = np.ravel(mq.Reference(mechanism).mass_matrix([0.3]))
    assert found == pytest.approx(0.02 * (1 + 1 / 9 + 1 / 81), rel=1e-14)


@pytest.mark.parametrize("meshes", list(permutations(("ab", "bc", "cd"))))
@pytest.mark.parametrize("swapped", list(product((False, True), repeat=3)))
def test_the_order_in_which_meshes_are_told_does_not_matter(
    meshes: tuple[str, ...], swapped: tuple[bool, ...]
) -> None:
    """Wheels in a row turn by r₁/r alternately, whichever wheel of a mesh is named first."""
    radii = {"a": 0.1, "b": 0.2, "c": 0.4, "d": 0.8}
    wheel = mq.Shape(1.0, HERE, (0.01, 0.01, 0.02, 0, 0, 0))
    places = np.cumsum([0.0, 0.3, 0.6, 1.2])
    gears = []
    for mesh, swap in zip(meshes, swapped, strict=True):
        first, second = list(mesh[::-1] if swap else mesh)
        gears.append(mq.Gear(mesh, first, second, radii[first], other_radius=radii[second]))
    mechanism = mq.Mechanism(
        "row",
        (mq.Body("ground"), *(mq.Body(name, wheel) for name in radii)),
        tuple(
            mq.Revolute(name, "ground", name, axis=UP, origin=mq.Placement((float(x), 0, 0)))
            for name, x in zip(radii, places, strict=True)
        ),
        elements=tuple(gears),
    )
    (leader,) = mechanism.coordinates
    for k, name in enumerate(radii):
        turned = mechanism.coordinates.driven.get(name, mq.coordinate(name))
        share = (-1) ** (k - "abcd".index(leader)) * radii[leader] / radii[name]
        assert plain(turned).subs({mq.coordinate(leader): 1.0}) == pytest.approx(share, rel=1e-14)


def test_wheels_that_follow_others_by_no_proportion_leave_these_to_be_given() -> None:
    """Of sin p = −sin q neither p nor q is a multiple of the other."""
    p, q = mq.coordinate("p"), mq.coordinate("q")
    wheel = mq.Shape(1.0, HERE, (0.01, 0.01, 0.02, 0, 0, 0))
    places = {"p": 0.0, "q": 1.0, "a": 2.0, "b": 2.2}
    mechanism = mq.Mechanism(
        "waves",
        (mq.Body("ground"), *(mq.Body(name, wheel) for name in places)),
        tuple(
            mq.Revolute(name, "ground", name, axis=UP, origin=mq.Placement((x, 0, 0)))
            for name, x in places.items()
        ),
        coordinates=Coordinates((), {"a": mq.sin(p), "b": mq.sin(q)}),
        elements=(mq.Gear("mesh", "a", "b", 0.1, other_radius=0.1),),
    )
    assert tuple(mechanism.coordinates) == ("p", "q")
    assert mechanism.coordinates.driven.keys() == {"a", "b"}


def test_a_map_that_is_given_stays() -> None:
    third = mq.coordinate("third")
    mechanism = train(coordinates=Coordinates(("third",), {"second": -3 * third}))
    assert tuple(mechanism.coordinates) == ("third",)
    assert plain(mechanism.coordinates.driven["first"] - 9 * third).subs({"r": 1, "s": 3}) == 0


def test_a_changed_radius_changes_the_ratio() -> None:
    mechanism = train().replace(s=0.2)
    (found,) = np.ravel(mq.Reference(mechanism).mass_matrix([0.3]))
    assert found == pytest.approx(0.02 * (1 + 1 / 4 + 1 / 16), rel=1e-14)


def test_a_wrong_map_is_still_refused() -> None:
    second = mq.coordinate("first")
    wrong = train(coordinates=Coordinates(("first",), {"second": second, "third": second}))
    with pytest.raises(mq.EngineError, match="gear 'a' does not fit the coordinate map"):
        mq.Reference(wrong).reactions([0.1], [0.0])


def test_a_rack_adds_the_map() -> None:
    mechanism = textbook.load("rack_and_pinion")
    free = replace(mechanism, coordinates=Coordinates(("x",)))
    assert plain(free.coordinates.driven["turn"] - mechanism.coordinates.driven["turn"]) == 0


@pytest.mark.parametrize("height", [0.0, 3.0, -3.0])
@pytest.mark.parametrize(("way", "aside", "up"), [(0.4, 0.15, 0.1), (-0.7, -0.3, -0.5)])
def test_a_rack_moves_by_its_pitch_line_wherever_its_frame_is(
    way: float, aside: float, up: float, height: float
) -> None:
    """Below a pinion that turns about −y it moves along x; its frame is above the line or below."""
    r = 0.2
    machine = mq.Mechanism(
        "rack",
        (mq.Body("ground"), *(mq.Body(name, mq.ball(1.0, 0.1)) for name in ("pinion", "rack"))),
        (
            mq.Revolute(
                *("P", "ground", "pinion"),
                axis=UP,
                origin=mq.Placement((0, 0, height), (np.pi / 2, 0, 0)),
            ),
            mq.Prismatic(
                *("S", "ground", "rack"),
                axis=(1, 0, 0),
                origin=mq.Placement((way, aside, height + up)),
            ),
        ),
        elements=(mq.Rack("mesh", "P", "S", r, point=(0.3, 0.1, -r - up)),),
    )
    assert machine.coordinates.driven == {"S": r * mq.coordinate("P")}


@pytest.mark.parametrize("joint", ["sun", "arm", "planet", "ring"])
def test_a_joint_about_the_other_way_turns_with_the_other_sign(joint: str) -> None:
    gear = textbook.load("planetary_gear")
    free = replace(gear, coordinates=Coordinates(gear.coordinates.names))
    (hinge,) = (j for j in gear.joints if joint in j.coordinates)
    assert isinstance(hinge, mq.Revolute)
    x, y, z = hinge.axis
    turned = replace(hinge, axis=(-x, -y, -z))
    other = replace(
        gear,
        joints=tuple(turned if j is hinge else j for j in gear.joints),
        coordinates=Coordinates(gear.coordinates.names),
    )
    values = gear.values | {"sun": 0.3, "arm": -0.7}
    back = values | ({joint: -values[joint]} if joint in values else {})
    assert other.coordinates.driven.keys() == free.coordinates.driven.keys()
    for name, law in other.coordinates.driven.items():
        expected = evaluate(free.coordinates.driven[name], back) * (-1 if name == joint else 1)
        assert evaluate(law, values) == pytest.approx(expected, rel=1e-13)


def test_a_cosine_is_whole_but_for_rounding() -> None:
    given = (1 - 2**-53, -1 + 2**-53, 1e-16, 0.3, 1 - 1e-14)
    assert [element_laws._whole(x) for x in given] == [1.0, -1.0, 0.0, 0.3, 1 - 1e-14]


def test_the_map_is_written_and_read_back() -> None:
    text = mq.write_urdf(train())
    again = mq.read_urdf(text)
    assert tuple(again.coordinates) == ("first",)
    bare = "\n".join(line for line in text.splitlines() if "<mimic" not in line)
    assert tuple(mq.read_urdf(bare).coordinates) == ("first",)


def test_a_cord_whose_stretch_turns_leaves_the_map_open() -> None:
    mechanism = textbook.load("swinging_atwood_machine")
    free = replace(mechanism, coordinates=Coordinates(()))
    assert not free.coordinates.driven


def bevel_drive() -> mq.Mechanism:
    """Two bevel wheels at 70° on a cage that turns as well."""
    c, s, r, R = np.cos(1.2), np.sin(1.2), 0.1, 0.25
    a, b = (R + c * r) / s, (r + c * R) / s
    hollow = mq.Shape(0.5, (0, 0, 0), (0.01, 0.01, 0.01, 0, 0, 0))
    return mq.Mechanism(
        "bevel",
        (mq.Body("ground"), *(mq.Body(name, hollow) for name in ("cage", "first", "second"))),
        (
            mq.Revolute("turn", "ground", "cage", axis=UP),
            mq.Revolute("p", "ground", "first", axis=UP, origin=mq.Placement((0, 0, a))),
            mq.Revolute(
                "q", "cage", "second", axis=(s, 0, c), origin=mq.Placement((b * s, 0, b * c))
            ),
        ),
        elements=(mq.Gear("mesh", "p", "q", r, other_radius=R),),
    )


def belt_drive() -> mq.Mechanism:
    """A crossed belt over two wheels, whose frames are turned about their axes."""
    wheel = mq.Shape(0.5, (0, 0, 0), (0.01, 0.01, 0.01, 0, 0, 0))
    return mq.Mechanism(
        "belt",
        (mq.Body("ground"), mq.Body("a", wheel), mq.Body("b", wheel)),
        (
            mq.Revolute("p", "ground", "a", axis=UP, origin=mq.Placement((1, 2, 3), (0, 0, 0.4))),
            mq.Revolute("q", "ground", "b", axis=(0, 0, -1), origin=mq.Placement((2, 2.5, 3))),
        ),
        elements=(
            mq.Belt("belt", (mq.Pulley("a", 0.1), mq.Pulley("b", 0.3, -1)), normal=(0, 0, 1)),
        ),
    )


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
@pytest.mark.parametrize(("lean", "counts"), [(0.9e-9, True), (1.1e-9, False)])
def test_a_stretch_that_leaves_its_plane_by_a_billionth_ties_nothing(
    size: float, lean: float, counts: bool
) -> None:
    drive = belt_drive()
    first, second = drive.joints
    x, y, z = (size * np.array([1.0, 0.5, lean * np.hypot(1.0, 0.5)])).tolist()
    belt = mq.Belt(
        *("belt", (mq.Pulley("a", 0.1 * size), mq.Pulley("b", 0.3 * size, -1))), normal=UP
    )
    leaning = replace(
        drive,
        joints=(
            replace(first, origin=mq.Placement()),
            replace(second, origin=mq.Placement((x, y, z))),
        ),
        coordinates=Coordinates(()),
        elements=(belt,),
    )
    assert (len(leaning.coordinates) == 1) == counts


def hoist() -> mq.Mechanism:
    """A load on a loose pulley, beside its frame, that a weight lifts by twice its way."""
    shape = mq.particle(1.0)
    return mq.Mechanism(
        "hoist",
        (mq.Body("ground"), mq.Body("load", shape), mq.Body("weight", shape)),
        (
            mq.Prismatic("l", "ground", "load", axis=UP, origin=mq.Placement((0.3, 0.1, -1.0))),
            mq.Prismatic("w", "ground", "weight", axis=UP, origin=mq.Placement((1.3, -0.2, -1.7))),
        ),
        elements=(
            mq.Cord(
                "rope",
                ("ground", (0.2, 0.6, 0.0)),
                (
                    mq.Pulley("load", 0.2, center=(0.1, 0.5, 0.4), grips=False),
                    mq.Pulley("ground", 0.1, -1, (0.7, 0.6, 0.1), grips=False),
                ),
                ("weight", (-0.5, 0.8, 0.3)),
            ),
        ),
    )


def turned(
    mechanism: mq.Mechanism, place: mq.Placement, turns: Mapping[str, np.ndarray]
) -> mq.Mechanism:
    """The whole of it elsewhere in the world, its bodies in turned frames, without its map."""
    back = {body: np.eye(4) for body in turns}
    for body, turn in turns.items():
        back[body][:3, :3] = turn
    back[mechanism.ground] = pose_of(place)

    def carried(body: str, point: Any) -> Any:
        there = back[body][:3, :3] @ mechanism.evaluate_all(point) + back[body][:3, 3]
        return tuple(there.tolist())

    joints: list[Any] = []
    for joint in list[Any](mechanism.joints):
        own = back[joint.child]
        stands = back[joint.parent] @ mechanism.matrix(joint.origin) @ own.T
        x, y, z = stands[:3, 3].tolist()
        joint = replace(joint, origin=mq.Placement((x, y, z), rpy_of(stands[:3, :3])))
        joints.append(replace(joint, axis=carried(joint.child, joint.axis)))
    elements: list[Any] = []
    for element in mechanism.elements:
        if isinstance(element, mq.Cord | mq.Belt):
            x, y, z = (back[mechanism.ground][:3, :3] @ element.normal).tolist()
            over = tuple(replace(w, center=carried(w.body, w.center)) for w in element.over)
            element = replace(element, normal=(x, y, z), over=over)
        if isinstance(element, mq.Cord):
            start, end = element.start, element.end
            start = start[0], carried(*start)
            element = replace(element, start=start, end=end and (end[0], carried(*end)))
        if isinstance(element, mq.Rack):
            slide = mechanism.joint(element.other)
            element = replace(element, point=carried(slide.child, element.point))
        elements.append(element)
    return replace(
        mechanism,
        joints=tuple(joints),
        elements=tuple(elements),
        coordinates=Coordinates(mechanism.coordinates.names),
    )


@pytest.mark.parametrize(
    "mechanism",
    [
        *map(textbook.load, ("planetary_gear", "rack_and_pinion", "atwood_machine")),
        *(textbook.load("double_atwood_machine"), train(), bevel_drive(), belt_drive(), hoist()),
    ],
    ids=lambda mechanism: mechanism.name,
)
@pytest.mark.parametrize(
    "place",
    [
        mq.Placement((0.3, -0.7, 1.1), (0.5, -1.2, 2.1)),
        mq.Placement((-30.0, 70.0, -110.0), (2.5, 0.7, -1.3)),
        mq.Placement((50.0, -40.0, 30.0), (-2.9, 1.1, 0.4)),
    ],
)
def test_maps_do_not_depend_on_where_a_mechanism_stands_and_on_the_frames_of_its_bodies(
    mechanism: mq.Mechanism, place: mq.Placement
) -> None:
    names = Coordinates(mechanism.coordinates.names)
    here = replace(mechanism, coordinates=names)
    bodies = [body.name for body in mechanism.bodies[1:]]
    turns = dict(zip(bodies, Rotation.random(len(bodies), rng=3).as_matrix(), strict=True))
    there = turned(here, place, turns)
    laws = here.coordinates.driven
    assert laws
    assert there.coordinates.driven.keys() == laws.keys()
    values = here.values | {name: 0.3 + 0.2 * k for k, name in enumerate(here.coordinates)}
    for name, law in there.coordinates.driven.items():
        assert evaluate(law, values) == pytest.approx(evaluate(laws[name], values), rel=1e-13)
