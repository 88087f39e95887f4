"""Floors, walls, stops and inclines of a figure, and what of a body in space is measured."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import mecanique as mq
from mecanique.figure.coordinates import missing
from mecanique.figure.draw import _set_up
from mecanique.figure.mechanism import figure
from mecanique.figure.paper.files import _text, _typeset
from mecanique.figure.paper.marks import Circle, Stroke, Words, bounds
from mecanique.figure.setting import Setting, posture


def seen(name: str, **q: float) -> Setting:
    """The setting of a system's figure, at a position."""
    return _set_up(mq.textbook.load(name), None, q)


def grounds(shown: Setting) -> list[Any]:
    """The lines of ground of a figure."""
    return [m.points for m in figure(shown) if isinstance(m, Stroke) and m.style == "ground"]


def letters(shown: Setting) -> set[str]:
    """What is written in a figure."""
    marks = (m for m in figure(shown) if isinstance(m, Words))
    return {"".join(text for text, _ in mark.parts) for mark in marks}


def test_a_ladder_stands_on_a_floor_that_ends_at_its_wall() -> None:
    lean = 0.4
    l = mq.textbook.load("ladder").values["l"]
    shown = seen("ladder", th=lean, z=l * math.cos(lean))
    camera = shown.camera
    lines = sorted(grounds(shown), key=lambda points: np.ptp(points[:, 0]))
    wall, floor = lines
    corner, foot = camera.at((0, 0, 0)), camera.at((l * math.sin(lean), 0, 0))
    np.testing.assert_allclose(wall[:, 0], corner[0], rtol=0, atol=1e-6)
    np.testing.assert_allclose(floor[:, 1], corner[1], rtol=0, atol=1e-6)
    assert floor[:, 0].min() == pytest.approx(corner[0], rel=0, abs=1e-6)
    assert floor[:, 0].max() > foot[0] + 10
    assert wall[:, 1].max() == pytest.approx(corner[1], rel=0, abs=1e-6)


def test_the_figure_reaches_down_to_the_floor_of_a_ball_in_the_air() -> None:
    (floor,) = grounds(seen("bouncing_ball", z=2.0))
    shown = seen("bouncing_ball", z=2.0)
    np.testing.assert_allclose(floor[:, 1], shown.camera.at((0, 0, 0))[1], rtol=0, atol=1e-6)


def test_the_hatching_lies_below_the_floor() -> None:
    shown = seen("rocking_block", z=1.0)
    (floor,) = grounds(shown)  # the corners touch one floor, drawn once
    hatches = [m.points for m in figure(shown) if isinstance(m, Stroke) and m.style == "hatch"]
    assert all(points[1, 1] > floor[0, 1] for points in hatches)


def test_an_incline_is_drawn_inclined() -> None:
    shown = seen("block_on_incline", x=0.0)
    alpha = shown.mechanism.values["alpha"]
    (line,) = grounds(shown)
    across, down = np.abs(line[1] - line[0])
    assert math.atan2(down, across) == pytest.approx(alpha, rel=1e-9)
    gravity = shown.camera.at(shown.mechanism.evaluate_all(shown.mechanism.gravity))
    assert gravity[0] == pytest.approx(0.0, abs=1e-9)
    assert gravity[1] > 0
    assert "α" in letters(shown)


@pytest.mark.parametrize(
    ("name", "letter", "style"),
    [("bead_leaves_sphere", "R", "clear"), ("slack_cord", "l", "dashed")],
)
def test_what_stops_a_turning_slide_is_a_circle(name: str, letter: str, style: str) -> None:
    shown = seen(name, r=0.8, th=0.4)
    radius = shown.mechanism.values[letter] * shown.camera.scale
    circles = [m for m in figure(shown) if isinstance(m, Circle) and m.style == style]
    assert any(circle.radius == pytest.approx(radius, rel=1e-9) for circle in circles)
    assert letter in letters(shown)


def test_a_pendulum_s_stop_stands_where_the_bar_strikes() -> None:
    """At q = 0 the bar hangs; it comes from the right, so the wall lies to the left."""
    shown = seen("pendulum_with_stop", q=0.9)
    lines = grounds(shown)
    pin = shown.camera.at((0, 0, 0))
    stops = [points for points in lines if np.ptp(points[:, 0]) < 1]
    assert len(stops) == 1
    assert -10 < float(stops[0][0, 0] - pin[0]) < 0


@pytest.mark.parametrize("side", [1, -1])
def test_a_slide_s_stop_is_a_wall_beyond_the_body(side: int) -> None:
    mechanism = mq.textbook.load("two_blocks")
    joint = mechanism.joints[0]
    stop = mq.Stop("bumper", joint.name, at=0.4 * side, side=side)
    shown = _set_up(replace(mechanism, switching=(stop,)), None, None)
    bare = _set_up(mechanism, None, None)
    assert len(grounds(shown)) == len(grounds(bare)) + 1
    place = shown.camera.at(shown.seat(joint) + 0.4 * side * shown.axis(joint))
    walls = [points for points in grounds(shown) if np.ptp(points[:, 0]) < 1]
    assert any(side * (points[0, 0] - place[0]) > 5 for points in walls)


def test_a_cone_is_seen_from_aside_and_a_hoop_is_no_disk() -> None:
    top = seen("heavy_top", phi=0.55, theta=0.95)
    (cone,) = [s for s in top.solids if s.form == "solid cone" and s.kind == "cylinder"]
    assert abs(float(cone.pose[:3, 2] @ top.camera.toward)) < 0.5
    hoop = mq.textbook.load("bead_on_hoop").body("hoop")
    assert hoop.mass == 0
    assert hoop.shapes[0].form == "thin ring"


def test_rings_and_cones_show_their_round_side() -> None:
    """A gimbal seen edge on is a line, a cone from the side of its base a triangle."""
    for name in ("heavy_top", "gyroscope"):
        shown = _set_up(mq.textbook.load(name), None, None)
        round_ones = [s for s in shown.solids if s.form in ("solid cone", "thin ring", "thin disk")]
        assert round_ones
        for solid in round_ones:
            assert 0.2 < abs(float(solid.pose[:3, 2] @ shown.camera.toward)) < 0.95


def test_a_cones_spin_turns_about_its_axis_at_its_base() -> None:
    shown = seen("heavy_top", phi=0.55, theta=0.6, psi=0.75)
    words = (mark for mark in figure(shown) if isinstance(mark, Words))
    place = next(mark for mark in words if mark.parts[0][0] == "ψ")
    apex = shown.at("top")
    base = shown.at("top", (0, 0, shown.mechanism.values["h"]))
    assert math.hypot(*(place.at - base)) < 0.7 * math.hypot(*(place.at - apex))


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("four_bar_linkage", "ABCD"),
        ("slider_crank", "OAB"),
        ("bars_and_springs", "ABCDEF"),
        ("bars_and_springs_loop", "ABCDEF"),
    ],
)
def test_points_that_the_text_names_stand_in_the_figure(name: str, expected: str) -> None:
    mechanism = mq.textbook.load(name)
    shown = _set_up(mechanism, None, posture(mechanism))
    places = {
        "".join(text for text, _ in mark.parts): mark.at
        for mark in figure(shown)
        if isinstance(mark, Words)
    }
    assert {*expected} <= places.keys()
    for joint in shown.mechanism.joints:
        if joint.name in places:
            assert math.hypot(*(places[joint.name] - shown.at(joint.child))) < 30.0


def test_a_letter_of_a_parameter_is_no_point() -> None:
    """M is the mass of the cart, whatever its hinge is called."""
    machine = mq.textbook.load("cart_pole")
    joints = tuple(
        replace(j, name="M") if isinstance(j, mq.Revolute) else j for j in machine.joints
    )
    renamed = replace(machine, joints=joints)
    words = [mark for mark in figure(_set_up(renamed, None, None)) if isinstance(mark, Words)]
    assert ["".join(t for t, _ in mark.parts) for mark in words].count("M") == 1


def test_the_sun_needs_no_pin_and_its_attraction_has_a_line() -> None:
    shown = _set_up(mq.textbook.load("kepler_orbit"), None, None)
    marks = figure(shown)
    assert not any(isinstance(mark, Stroke) and mark.style in ("ground", "hatch") for mark in marks)
    sun, planet = shown.at("ground"), shown.at("planet")
    lines = [mark.points for mark in marks if isinstance(mark, Stroke) and mark.style == "axis"]
    assert any(np.allclose(line, [sun, planet], rtol=0, atol=1e-6) for line in lines)


def test_what_slides_along_a_sliding_base_stands_on_the_same_ground() -> None:
    shown = _set_up(mq.textbook.load("base_excited_mass"), None, None)
    (line,) = grounds(shown)
    assert line[:, 0].min() < shown.paper("base")[:, 0].min()
    assert line[:, 0].max() > shown.paper("block")[:, 0].max()


@pytest.mark.parametrize(
    ("name", "radii"),
    [
        ("heavy_top", {"r"}),
        ("rolling_coin", {"r"}),
        ("bead_on_hoop", {"R"}),
        ("whipple_bicycle", {"rR", "rF"}),
    ],
)
def test_radii_of_bodies_in_space_are_shown(name: str, radii: set[str]) -> None:
    shown = _set_up(mq.textbook.load(name), None, None)
    assert radii <= letters(shown)


def led(law: Any) -> mq.Mechanism:
    """A particle that the coordinate map leads along z = law(x)."""
    return mq.Mechanism(
        "led",
        (mq.Body("ground"), mq.Body("carriage"), mq.Body("bead", mq.particle(1.0))),
        (
            mq.Prismatic("along", "ground", "carriage", axis=(1, 0, 0), coordinate="x"),
            mq.Prismatic("up", "carriage", "bead", axis=(0, 0, 1), coordinate="z"),
        ),
        coordinates=mq.Coordinates(("x",), {"z": law}),
        gravity=(0, 0, -9.81),
    )


def test_a_particle_that_the_map_leads_is_drawn_on_its_curve() -> None:
    shown = _set_up(led(mq.coordinate("x") ** 2 / 2), None, {"x": 0.8})
    (curve,) = [line for line in grounds(shown) if len(line) > 2]
    x, z = curve.T / shown.camera.scale
    np.testing.assert_allclose(-z, x**2 / 2, rtol=0, atol=1e-12)
    assert x.min() < -0.8
    assert x.max() > 0.8
    cables = [m for m in figure(shown) if isinstance(m, Stroke) and m.style == "cable"]
    assert not cables  # the carriage is no rod


def test_a_map_in_time_leads_along_no_curve() -> None:
    shown = _set_up(led(0.1 * mq.sin(mq.time())), None, {"x": 0.8})
    assert not [line for line in grounds(shown) if len(line) > 2]


def test_a_contact_s_force_is_drawn_along_its_plane() -> None:
    """Cut free, a rolling disk bears λ along and across the incline, as its equations have them."""
    disk = mq.textbook.load("rolling_disk")
    motion = mq.simulate(disk, q={"x": 0.0, "z": disk.values["R"]}, duration=0.2)
    drawn = mq.picture(motion, 0.1, free_body="disk", numbers=True).svg
    words = re.sub(r"<[^>]+>", "", drawn)
    m, g, alpha = (disk.values[letter] for letter in ("m", "g", "alpha"))
    assert f"normal = {m * g * math.cos(alpha):.3g} N" in words
    assert f"contact,x = −{m * g * math.sin(alpha) / 3:.3g} N" in words


def test_the_cord_of_a_capstan_hangs_from_its_drum() -> None:
    shown = seen("capstan", x=1.0, y=2.0)
    marks = figure(shown)
    cords = [m.points for m in marks if isinstance(m, Stroke) and m.style == "cable"]
    assert len(cords) == 2
    for (top, end), x, z in zip(cords, (0.0, 0.2), (-1.0, -2.0), strict=True):
        np.testing.assert_allclose(top, shown.camera.at((x, 0, 0)), rtol=0, atol=1e-9)
        np.testing.assert_allclose(end, shown.camera.at((x, 0, z)), rtol=0, atol=1e-9)
    (drum,) = (m for m in marks if isinstance(m, Circle) and m.style == "body")
    assert drum.radius == pytest.approx(0.1 * shown.camera.scale, rel=1e-12)


def test_what_stands_in_space_has_a_floor_under_it() -> None:
    shown = seen("tippe_top", top_z=0.02)
    floor, *_ = (m.points for m in figure(shown) if isinstance(m, Stroke) and m.style == "clear")
    foot = shown.camera.at((0, 0, 0))
    np.testing.assert_allclose(floor.mean(axis=0), foot, rtol=0, atol=1e-6)
    assert "r" in letters(shown)
    turntable = seen("ball_on_a_turntable")
    assert not [
        m
        for m in figure(turntable)
        if isinstance(m, Stroke) and len(m.points) == 4 and m.style == "clear"
    ]


def test_lengths_that_stand_nowhere_in_a_figure_are_explained_below_it() -> None:
    shown = _set_up(mq.textbook.load("woodpecker"), None, None)
    marks = figure(shown)
    lines = [mark for mark in marks if isinstance(mark, Words) and mark.anchor == "start"]
    texts = ["".join(text for text, _ in line.parts) for line in lines]
    assert "r0: radius of the pole" in texts
    assert "lS: distance of the beak from the center" in texts
    rest = [mark for mark in marks if mark not in lines]
    _, _, _, bottom = bounds(rest)
    heights = [line.at[1] for line in lines]
    assert min(heights) - 0.6 * 12.0 > bottom
    assert (np.diff(heights) > 12.0).all()
    # what is drawn is not explained again, and a small figure explains nothing
    assert not [text for text in texts if text.startswith(("a:", "y:", "mS:"))]
    assert not [
        m for m in figure(shown, legend=False) if isinstance(m, Words) and m.anchor == "start"
    ]


def spans(shown: Setting, symbol: str) -> list[float]:
    """The lengths of the double arrows that a letter has [m]."""
    marks = missing(shown, symbol)
    heads = [m.points[0] for m in marks if isinstance(m, Stroke) and m.style == "tip"]
    return [
        float(np.hypot(*(b - a))) / shown.camera.scale
        for a, b in zip(heads[::2], heads[1::2], strict=True)
    ]


@pytest.mark.parametrize(
    ("name", "symbol", "length"),
    [
        ("rocking_block", "b", 0.2),  # an edge
        ("rocking_block", "h", 0.8),
        ("clearance_slider_crank", "a", 0.025),  # up to a corner that touches
        ("coupled_pendulums", "d", 0.5),  # between two pins
        ("coupled_pendulums", "a", 0.5),  # up to the end of a spring
        ("snakeboard", "l", 0.2),
        ("shear_building", "h", 3.0),  # the height of a slide, across it
        ("chaplygin_sleigh", "a", 0.3),  # up to a center of mass
    ],
)
def test_a_length_that_a_description_states_is_drawn(name: str, symbol: str, length: float) -> None:
    shown = _set_up(mq.textbook.load(name), None, None)
    assert spans(shown, symbol) == pytest.approx([length], rel=1e-9)


def test_lengths_that_are_no_measure_of_what_is_drawn_are_explained() -> None:
    # where a slide has its zero nothing need be, and a board without a form is only drawn
    for name, symbol in (("swinging_atwood_machine", "h"), ("two_blocks", "a")):
        assert missing(_set_up(mq.textbook.load(name), None, None), symbol) == ()
    sleigh = _set_up(mq.textbook.load("chaplygin_sleigh"), None, None)
    assert "3\u2009a" not in letters(sleigh)


def test_a_center_of_mass_has_its_sign_where_it_lies() -> None:
    shown = _set_up(mq.textbook.load("chaplygin_sleigh"), None, None)
    disks = [m for m in missing(shown, "a") if isinstance(m, Circle)]
    place = shown.camera.at(shown.point("sleigh", (0.3, 0, 0)))
    np.testing.assert_allclose([disk.center for disk in disks], [place], rtol=0, atol=1e-9)


def test_the_tilt_of_a_joint_is_drawn_between_its_axis_and_the_parents() -> None:
    shown = _set_up(mq.textbook.load("whipple_bicycle"), None, None)
    (arc,) = (m for m in missing(shown, "tilt") if isinstance(m, Stroke) and m.style == "thin")
    headset = shown.mechanism.joint("headset")
    frame = shown.poses[shown.index("frame"), :3, :3]
    ways = shown.camera.at(np.array([frame[:, 2], -shown.axis(headset)]))
    for spot, way in zip(arc.points[[0, -1]], ways, strict=True):
        out = spot - shown.camera.at(shown.seat(headset))
        assert out @ way == pytest.approx(np.hypot(*out) * np.hypot(*way), rel=1e-9)


def test_a_stone_is_the_ellipsoid_that_it_rolls_on() -> None:
    shown = _set_up(mq.textbook.load("rattleback"), None, None)
    (stone,) = (solid for solid in shown.solids if solid.body == "stone")
    local = (stone.corners - shown.point("stone")) @ stone.pose[:3, :3]
    radii = ((local / [0.2, 0.03, 0.02]) ** 2).sum(axis=1)
    np.testing.assert_allclose(radii, 1.0, rtol=1e-12, atol=0)
    # half of it: its flat top is where the solids that are drawn of it end
    assert local[:, 2].max() == pytest.approx(0.05 * 0.02, rel=1e-9)
    assert {"a", "b", "c"} <= letters(shown)


def test_a_letter_with_an_index_is_not_the_letter_alone() -> None:
    shown = _set_up(mq.textbook.load("elastic_pendulum"), None, None)
    texts = {"".join(text for text, _ in m.parts) for m in figure(shown) if isinstance(m, Words)}
    assert "l0: free length of the spring" in texts


@pytest.mark.parametrize(
    ("write", "expected"),
    [
        (_text, "$l_{\\mathrm{S}}$: the beak's place"),
        (
            lambda words: _typeset(words, lambda at: at),
            "l_{\\mathrm{S}}\\textrm{: the beak's place}",
        ),
    ],
)
def test_sentences_are_set_as_text(write: Any, expected: str) -> None:
    parts = (("l", "italic"), ("S", "below"), (": the beak's place", "upright"))
    written = write(Words(np.zeros(2), parts))
    assert expected in written
