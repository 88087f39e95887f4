"""Line figures: what they show stands where it is, whatever it is called, for every system."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import numpy as np
import pytest

import mecanique as mq
from mecanique.errors import UnknownNameError
from mecanique.figure.coordinates import _spans, coordinates, lengths
from mecanique.figure.draw import figure_tex, figure_text
from mecanique.figure.freebody import cut_free, fit_body
from mecanique.figure.mechanism import (
    NUT,
    THREADS,
    connections,
    figure,
    given_motions,
    loads,
    nuts,
    supports,
)
from mecanique.figure.paper.files import svg, tex
from mecanique.figure.paper.marks import (
    STYLES,
    Circle,
    Stroke,
    Words,
    bounds,
    dashpot,
    hatch,
    label,
    rich,
    spring,
)
from mecanique.figure.setting import Setting, posture, setting
from mecanique.figure.solids import FRONT, ISOMETRIC, TOP, hull, side_of
from mecanique.model import Spring
from mecanique.motion.analysis.forces import Actions

SVG = "{http://www.w3.org/2000/svg}"


def seen(name: str, q: Any = None, **parameters: float) -> Setting:
    mechanism = mq.textbook.load(name, **parameters)
    position = (
        posture(mechanism, mq.textbook.entry(name).start) if q is None else mechanism.position(q)
    )
    return setting(mechanism, mq.Reference(mechanism), position, np.zeros(mechanism.nv), 0.0)


def words(marks: Any) -> set[str]:
    return {"".join(text for text, _ in mark.parts) for mark in marks if isinstance(mark, Words)}


@pytest.mark.parametrize("name", mq.textbook.names())
def test_every_system_has_a_figure(name: str) -> None:
    entry = mq.textbook.entry(name)
    text = figure_text(mq.textbook.load(name), entry.start)
    root = ElementTree.fromstring(text)
    assert root.tag == f"{SVG}svg"
    assert len(root) > 5
    assert len(text) < 40_000
    assert root.attrib["aria-label"]
    numbers = [
        float(x)
        for each in root.iter(f"{SVG}path")
        for x in re.findall(r"-?\d+\.?\d*", each.attrib["d"])
    ]
    left, top, width, height = map(float, root.attrib["viewBox"].split())
    assert min(numbers[0::2]) >= left
    assert max(numbers[0::2]) <= left + width
    assert min(numbers[1::2]) >= top
    assert max(numbers[1::2]) <= top + height
    assert 60 < width < 800
    assert 60 < height < 700
    assert text == figure_text(mq.textbook.load(name), entry.start)
    assert not re.search(r"nan|inf|<script|http(?!://www\.w3\.org/2000/svg)", text)


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("double_pendulum", {"q1", "q2", "l1", "l2", "m1", "m2", "g"}),
        ("cart_pole", {"x", "q", "F", "M", "m", "l", "c", "g"}),
        ("two_blocks", {"q1", "q2", "k1", "k2", "F", "m1", "m2", "g"}),
        ("heavy_top", {"φ", "θ", "ψ", "g"}),
        ("particle_on_circle_x", {"x", "R", "m"}),
    ],
)
def test_a_figure_tells_the_symbols(name: str, expected: set[str]) -> None:
    assert expected <= words(figure(seen(name)))


def test_planar_mechanisms_are_seen_from_their_side() -> None:
    for name, axes in (
        ("double_pendulum", FRONT),
        ("particle_on_circle", TOP),
        ("heavy_top", ISOMETRIC),
    ):
        given = seen(name)
        assert side_of(given.mechanism, given.poses) is axes
    for axes in (FRONT, TOP, ISOMETRIC):
        assert axes @ axes.T == pytest.approx(np.eye(3), abs=1e-15)
        assert np.linalg.det(axes) == pytest.approx(1.0, rel=1e-12)


def test_the_bar_is_drawn_from_the_pin_to_its_end() -> None:
    given = seen("rigid_bar_pendulum", {"q": 0.7})
    bars = [mark for mark in figure(given) if isinstance(mark, Stroke) and mark.style == "bar"]
    assert len(bars) == 1
    tip = given.camera.at([math.sin(0.7), 0.0, -math.cos(0.7)])
    away = np.hypot(*(bars[0].points - tip).T).min()
    assert away < 5
    pins = [mark for mark in figure(given) if isinstance(mark, Circle) and mark.style == "pin"]
    assert any(np.abs(mark.center).max() < 1e-9 for mark in pins)


def test_the_arc_of_an_angle_spans_that_angle() -> None:
    given = seen("double_pendulum", {"q1": 0.5, "q2": 1.1})
    arcs = [
        m.points for m in coordinates(given) if isinstance(m, Stroke) and m.style == "coordinate"
    ]
    pins = [given.camera.at(given.point(body)) for body in ("rod1", "rod2")]
    assert len(arcs) == 2
    for points, pin, angle in zip(arcs, pins, (0.5, 1.1), strict=True):
        begin, end = (math.atan2(*(points[k] - pin)) for k in (0, -1))
        # from straight down, less the head of the arrow
        assert begin == pytest.approx(0.0, abs=1e-9)
        assert angle - 0.25 < end < angle


def test_the_arrow_of_a_distance_is_as_long_as_it_and_shows_the_positive_sense() -> None:
    given = seen("two_blocks", {"q1": 0.4, "q2": -0.3})
    marks = [
        m for m in coordinates(given) if isinstance(m, Stroke) and m.style.startswith("coordinate")
    ]
    tips = [m.points[0] for m in marks if m.style == "coordinate-tip"]
    feet = [
        m.points.mean(axis=0)
        for m in marks
        if m.style == "coordinate" and abs(np.ptp(m.points[:, 0])) < 1e-9
    ]
    long, short = (tip[0] - foot[0] for tip, foot in zip(tips, feet, strict=True))
    assert long == pytest.approx(0.4 * given.camera.scale, rel=1e-12)
    assert 0 < short < 0.3 * given.camera.scale


@pytest.mark.parametrize("q", [0.6, -0.6, 0.0])
def test_the_arrow_of_an_angle_shows_the_positive_sense(q: float) -> None:
    given = seen("simple_pendulum", {"q": q})
    (head,) = (
        m.points
        for m in coordinates(given)
        if isinstance(m, Stroke) and m.style == "coordinate-tip"
    )
    # on paper x points to the right, and the pendulum hangs below its pin: q turns it to the right
    assert head[0][0] > head[1:].mean(axis=0)[0]


@pytest.mark.parametrize("name", ["woodpecker", "clearance_slider_crank", "rocking_block"])
def test_no_point_is_drawn_beyond_the_plane_that_it_touches(name: str) -> None:
    mechanism = mq.textbook.load(name)
    closed = tuple(e.closed for e in mechanism.switching if isinstance(e, mq.Contact))
    rolling = replace(mechanism, switching=(), contacts=closed)
    reference = mq.Reference(rolling)
    normal = [row.endswith("normal") for row in reference.constraint_names]
    q = posture(mechanism, mq.textbook.entry(name).start)
    assert reference.constraint_residual(q)[normal].min() > -1e-8


def test_a_mechanism_of_the_catalogue_is_drawn_where_its_motion_starts() -> None:
    drawn = mq.textbook.load("kepler_orbit")
    assert posture(drawn)[drawn.coordinates.names.index("r")] == 1.0
    words = [m for m in figure(seen("kepler_orbit")) if isinstance(m, Words)]
    assert {"r", "φ"} <= {word.parts[0][0] for word in words}


def test_an_incline_shows_its_angle_and_ends_near_what_stands_on_it() -> None:
    given = seen("rolling_disk")
    words = {m.parts[0][0] for m in figure(given) if isinstance(m, Words)}
    assert {"α", "R", "m", "x"} <= words
    (slope,) = (solid for solid in given.solids if solid.body == "ground")
    long = float(np.linalg.norm(slope.ends[1] - slope.ends[0]))
    assert 2.0 < long < 4.0  # 6 m in the description, 1.8 m between the disk and x = 0


def test_signs_reach_from_end_to_end() -> None:
    a, b = np.array([3.0, 4.0]), np.array([63.0, -36.0])
    for sign in (spring, dashpot):
        strokes = [mark.points for mark in sign(a, b) if isinstance(mark, Stroke)]
        assert strokes[0][0] == pytest.approx(a, rel=1e-12)
        assert strokes[-1][-1] == pytest.approx(b, rel=1e-12)
    zigzag = next(iter(spring(a, b)))
    assert isinstance(zigzag, Stroke)
    across = (zigzag.points - a) @ np.array([40.0, 60.0]) / math.hypot(40, 60)
    assert across.max() == pytest.approx(6.5, rel=1e-12)
    assert across.min() == pytest.approx(-6.5, rel=1e-12)


def test_hatching_lies_on_the_right_as_one_goes() -> None:
    marks = list(hatch(np.array([0.0, 0.0]), np.array([70.0, 0.0])))
    assert all(mark.points[:, 1].max() > 0 for mark in marks[1:] if isinstance(mark, Stroke))


def test_a_label_stands_clear_of_its_point() -> None:
    for way in ([1.0, 0.0], [0.0, -1.0], [-0.6, 0.8]):
        left, top, right, bottom = bounds([label(np.zeros(2), "theta1", np.array(way), 8.0)])
        assert not (left < 0 < right and top < 0 < bottom)


def test_the_hull_is_convex_and_holds_all() -> None:
    points = np.random.default_rng(0).normal(size=(60, 2))
    corners = hull(points)
    edges = np.roll(corners, -1, axis=0) - corners
    for corner, edge in zip(corners, edges, strict=True):
        assert (edge[0] * (points - corner)[:, 1] - edge[1] * (points - corner)[:, 0] > -1e-5).all()


@pytest.mark.parametrize(
    ("name", "pieces"),
    [
        ("theta1", [("θ", "italic"), ("1", "below")]),
        ("m*g", [("m", "italic"), ("\u2009", "upright"), ("g", "italic")]),
        (
            "-4*k*l**2",
            [
                ("−4\u2009", "upright"),
                ("k", "italic"),
                ("\u2009", "upright"),
                ("l", "italic"),
                ("²", "upright"),
            ],
        ),
    ],
)
def test_names_are_written_as_in_equations(name: str, pieces: list[tuple[str, str]]) -> None:
    joined = [(text, how) for text, how in rich(name)]
    assert "".join(t for t, _ in joined) == "".join(t for t, _ in pieces)
    assert [p for p in joined if p[1] != "upright"] == [p for p in pieces if p[1] != "upright"]


@pytest.mark.parametrize(
    "name",
    ["</text><script>alert(1)</script>", "a&b<c>\"'", "\x00\x1b[0m", "x" * 3000, "שלום\u202e"],
)
def test_hostile_names_are_only_names(name: str) -> None:
    text = svg([Words(np.zeros(2), ((name, "upright"),)), Circle(np.zeros(2), 3.0, "pin")], name)
    root = ElementTree.fromstring(text)
    assert {each.tag for each in root.iter()} == {
        f"{SVG}{tag}" for tag in ("svg", "title", "style", "text", "tspan", "circle")
    }
    kept = "".join(c for c in name if c >= " ")
    assert root.findtext(f"{SVG}title") == kept
    assert next(root.iter(f"{SVG}tspan")).text == kept


def test_every_style_has_ink_or_fill_by_day_and_by_night() -> None:
    for style in STYLES.values():
        assert bool(style.ink) == bool(style.night)
        assert bool(style.fill) == bool(style.night_fill)
        assert style.ink or style.fill


def test_a_body_cut_free_shows_its_forces_in_their_directions() -> None:
    """Arrows from each point of application follow the forces there; their values stand beside."""
    motion = mq.simulate(
        mq.textbook.load("double_pendulum"), q={"q1": 1.0, "q2": 0.3}, duration=0.5
    )
    state = motion(0.3)
    given = setting(
        motion.mechanism, motion.reference, np.asarray(state.q), np.asarray(state.v), 0.3
    )
    marks = cut_free(given, "rod1", resultants=True, numbers=True)
    given = fit_body(given, "rod1")
    tips = [
        (m.style, m.points[0])
        for m in marks
        if isinstance(m, Stroke) and m.style in ("force-tip", "inertia-tip")
    ]
    acting, (t, q, v) = (
        Actions(motion.mechanism, motion.reference),
        (np.array([0.3]), given.q[None], given.v[None]),
    )
    a = motion.reference.acceleration(q, v, t)
    every = [*acting.applied(t, q, v), *acting.reactions(t, q, v), *acting.inertia(t, q, v, a)]
    mine = [each for each in every if each.body == "rod1" and np.linalg.norm(each.force) > 1e-9]
    assert len(mine) == 4
    for each in mine:
        start, way = given.camera.at(each.origin[0]), given.camera.at(each.force[0])
        style = "inertia-tip" if each.kind == "inertia" else "force-tip"
        fits = [
            np.allclose(
                (tip - start) / math.hypot(*(tip - start)),
                way / math.hypot(*way),
                rtol=0,
                atol=1e-9,
            )
            for s, tip in tips
            if s == style
        ]
        assert any(fits), each.name
        assert any(f"{np.linalg.norm(each.force):.3g} N" in text for text in words(marks)), (
            each.name
        )
    total = sum((each.force[0] for each in mine), np.zeros(3))
    assert total == pytest.approx(np.zeros(3), abs=1e-9)


def test_pictures_of_a_motion(tmp_path: Path) -> None:
    motion = mq.simulate(mq.textbook.load("cart_pole"), q={"q": 1.0}, duration=1.0)
    path = mq.picture(motion, 0.0, tmp_path / "a.svg")
    assert path == tmp_path / "a.svg"
    first = path.read_text(encoding="utf-8")
    assert first == mq.picture(motion, path=tmp_path / "b.svg").read_text(encoding="utf-8")
    assert first != mq.picture(motion, 1.0, tmp_path / "b.svg").read_text(encoding="utf-8")
    assert "cart" in mq.picture(motion, 0.5, tmp_path / "c.svg", free_body="cart").read_text(
        encoding="utf-8"
    )
    assert (
        mq.picture(motion.mechanism, path=tmp_path / "d.svg", q={"q": 1.0, "x": 0.2}).read_text(
            encoding="utf-8"
        )
        != first
    )
    png = mq.picture(motion, 0.0, tmp_path / "e.png").read_bytes()
    assert png.startswith(b"\x89PNG")
    assert mq.picture(motion, 0.0, tmp_path / "e.pdf").read_bytes().startswith(b"%PDF")
    assert mq.picture(motion, 0.0, tmp_path / "f.png").read_bytes() == png
    assert sorted(each.name for each in tmp_path.iterdir()) == [
        "a.svg",
        "b.svg",
        "c.svg",
        "d.svg",
        "e.pdf",
        "e.png",
        "f.png",
    ]


def test_what_cannot_be_drawn_is_refused(tmp_path: Path) -> None:
    mechanism = mq.textbook.load("cart_pole")
    motion = mq.simulate(mechanism, duration=0.1)
    nothing: Any = "cart_pole"
    with pytest.raises(
        mq.InputError, match=r"expected a path that ends in \.svg, \.png, \.pdf, got .*figure\.gif"
    ):
        mq.picture(mechanism, path=tmp_path / "figure.gif")
    with pytest.raises(mq.InputError, match="expected a path in a directory that exists"):
        mq.picture(mechanism, path=tmp_path / "nowhere" / "figure.svg")
    with pytest.raises(mq.InputError, match="expected a Motion or a Mechanism, got str"):
        mq.picture(nothing, path=tmp_path / "figure.svg")
    with pytest.raises(mq.InputError, match="expected no q together with a Motion"):
        mq.picture(motion, path=tmp_path / "figure.svg", q={"x": 1.0})
    with pytest.raises(mq.InputError, match="expected times within the motion"):
        mq.picture(motion, 2.0, tmp_path / "figure.svg")
    for body in ("ground", "wheel"):
        with pytest.raises(UnknownNameError, match="moving body"):
            mq.picture(motion, path=tmp_path / "figure.svg", free_body=body)
    bare = mq.Mechanism("bare", bodies=(mq.Body("ground"),), joints=(), gravity=(0, 0, 0))
    with pytest.raises(mq.InputError, match="bare has nothing that could be drawn"):
        mq.picture(bare, path=tmp_path / "figure.svg")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("theta", [0.0, 4.0])
def test_the_nut_of_a_screw_stands_where_the_screw_starts(theta: float) -> None:
    """The ground holds it still, around the spindle and upwards from the joint's frame."""
    where = seen("screw_press", {"theta": theta})
    marks = list(nuts(where))
    (block,) = (m for m in marks if isinstance(m, Stroke) and m.closed)
    seat = where.camera.at(where.seat(where.mechanism.joint("thread")))
    np.testing.assert_allclose(block.points[:2].mean(axis=0), seat, rtol=0, atol=1e-12)
    np.testing.assert_allclose(block.points.mean(axis=0) - seat, [0.0, -NUT[1]], rtol=0, atol=1e-12)
    grounds = [m for m in marks if isinstance(m, Stroke) and m.style == "ground"]
    threads = [m for m in marks if isinstance(m, Stroke) and m.style == "thin"]
    assert (len(grounds), len(threads)) == (2, THREADS)


def test_only_screws_have_nuts() -> None:
    assert list(nuts(seen("cart_pole"))) == []


@pytest.mark.parametrize(
    ("name", "law"),
    [
        ("kapitza_pendulum", "z=Acos(Wt)"),
        ("crane", "l=l0-wt"),
        ("foucault_pendulum", "φ=Wt"),
    ],
)
def test_prescribed_motions_are_drawn_with_their_law(name: str, law: str) -> None:
    (written,) = [mark for mark in given_motions(seen(name)) if isinstance(mark, Words)]
    text = "".join(piece for piece, _ in written.parts).replace(" ", "").replace("\u2212", "-")
    assert text == law


def test_what_is_not_prescribed_has_no_such_arrow() -> None:
    assert not list(given_motions(seen("double_pendulum")))


def test_steering_seen_from_above_is_drawn_with_its_laws() -> None:
    words = [mark for mark in given_motions(seen("snakeboard")) if isinstance(mark, Words)]
    laws = {"".join(piece for piece, _ in word.parts).replace(" ", "") for word in words}
    assert laws == {"ψ=Asin(Wt)", "φ=Bcos(Wt)", "φback=−Bcos(Wt)"}


def test_springs_of_a_loop_are_not_crushed_and_end_on_level_ground() -> None:
    where = seen("bars_and_springs_loop")
    m = where.mechanism
    for force in m.forces:
        assert isinstance(force, Spring)
        a, b = (where.point(end.body, end.point) for end in force.ends)
        assert np.linalg.norm(b - a) > m.evaluate(force.free_length) / 2
    ground = [mark for mark in connections(where) if mark.style == "ground"]
    for line in ground:
        assert isinstance(line, Stroke)
        assert np.ptp(line.points[:, 1]) < 1e-9 < np.ptp(line.points[:, 0])
    assert len(ground) == 2


def test_a_small_figure_has_letters_of_the_same_size() -> None:
    mechanism = mq.textbook.load("slider_crank")
    large, small = (figure_text(mechanism, small=one) for one in (False, True))
    width = [float(re.findall(r' width="([\d.]+)"', text)[0]) for text in (large, small)]
    assert width[1] < 0.7 * width[0]
    sizes = [set(re.findall(r'font-size="([\d.]+)"', text)) for text in (large, small)]
    assert sizes[0] == sizes[1] != set()


def test_a_robot_of_many_joints_is_drawn_as_its_file_has_it() -> None:
    """Turned by half a radian in each joint, a humanoid is a tangle."""
    arm, humanoid = (mq.read_urdf(mq.robot(name)) for name in ("ur5_robot", "talos_full_v2"))
    assert (posture(arm) != 0).all()
    assert posture(humanoid) == pytest.approx(humanoid.neutral(), rel=1e-12)


def test_the_trunk_of_a_robot_without_meshes_joins_its_limbs(tmp_path: Path) -> None:
    """Each of four legs was drawn by itself; the base of an arm is its support alone."""
    joined = []
    for name in ("solo12", "panda"):
        source = Path(mq.robot(name)).read_text(encoding="utf-8")
        file = tmp_path / f"{name}.urdf"
        file.write_text(source.replace("package://", "package://nowhere_"), encoding="utf-8")
        robot = mq.read_urdf(file)
        at = setting(robot, mq.Reference(robot), posture(robot), np.zeros(robot.nv), 0.0)
        trunk = at.at(robot.ground)
        seats = [at.seat_at(joint) for joint in robot.joints if joint.parent == robot.ground]
        lines = [m.points for m in figure(at) if isinstance(m, Stroke) and len(m.points) == 2]
        ends = [line[1] for line in lines if np.allclose(line[0], trunk, rtol=0, atol=1e-9)]
        joined.append(
            sum(bool(np.isclose(seats, end, rtol=0, atol=1e-9).all(axis=1).any()) for end in ends)
        )
    assert joined == [4, 0]


@pytest.mark.parametrize(
    ("name", "ways"),
    [
        ("atwood_machine", [(0, 1)]),  # the paper's y points down
        ("two_blocks", [(1, 0), (1, 0)]),
        ("rolling_disk", [(-0.415, 0.910), (0.954, 0.301), (0.301, -0.954)]),
    ],
)
def test_arrows_of_coordinates_point_in_their_positive_sense(
    name: str, ways: list[tuple[float, float]]
) -> None:
    """Also where the position drawn has them negative: m1 descends by x, drawn where it is up."""
    marks = coordinates(seen(name))
    heads = [m.points for m in marks if isinstance(m, Stroke) and m.style == "coordinate-tip"]
    found = [head[0] - head[1:].mean(axis=0) for head in heads]
    for arrow, way in zip(found, ways, strict=True):
        np.testing.assert_allclose(arrow / np.hypot(*arrow), way, rtol=0, atol=0.02)


def test_angles_that_nothing_depends_on_are_drawn_turned() -> None:
    coin = mq.textbook.load("rolling_coin")
    q = dict(zip(coin.coordinates, posture(coin), strict=True))
    assert (q["yaw"], q["spin"]) == (0.55, 0.95)
    assert q["lean"] == pytest.approx(0.2, rel=1e-12)
    assert q["z"] == pytest.approx(0.5 * np.cos(0.2), rel=1e-12)
    words = {
        "".join(text for text, _ in m.parts)
        for m in figure(seen("rolling_coin"))
        if isinstance(m, Words)
    }
    assert {"α", "θ", "φ", "r"} <= words  # as in the equations, of yaw, lean and spin


@pytest.mark.parametrize(
    ("name", "body"), [("rolling_coin", "coin"), ("two_wheeled_cart", "left_wheel")]
)
def test_a_height_is_measured_beside_what_is_carried(name: str, body: str) -> None:
    """The center of a coin is carried by slides of which nothing is drawn."""
    shown = seen(name)
    (height,) = (
        mark for mark in coordinates(shown) if isinstance(mark, Words) and mark.parts == rich("z")
    )
    assert height.at[0] > shown.paper(body)[:, 0].max()


def test_angles_that_are_zero_have_their_arcs_too() -> None:
    """Of the bicycle, upright and straight, whose equations are those of roll and steer."""
    marks = [mark for mark in coordinates(seen("whipple_bicycle")) if isinstance(mark, Words)]
    words = {"".join(text for text, _ in mark.parts) for mark in marks}
    assert {"α", "φ", "θ", "δ"} <= words


def test_wheelbase_and_trail_are_measured_on_the_ground() -> None:
    """The trail is how far the steering axis meets the ground ahead of the front wheel's foot."""
    shown = seen("whipple_bicycle")
    words = [mark.parts for mark in figure(shown) if isinstance(mark, Words)]
    assert rich("w") in words
    assert rich("c") in words
    assert not any("wheelbase" in part[0] for parts in words for part in parts)
    values = shown.mechanism.values
    w, c, ground = values["w"], values["c"], -values["rR"]
    feet = {"w": {(0.0, ground), (w, ground)}, "c": {(w, ground), (w + c, ground)}}
    upright = replace(shown, poses=shown.reference.poses(np.zeros(shown.mechanism.nq), 0.0))
    ends = {
        span.name: {(round(x, 9) + 0.0, round(z, 9)) for x, _, z in (span.a, span.b)}
        for span in _spans(upright)
    }
    assert {name: ends[name] for name in feet} == feet
    leaning = [end for span in _spans(shown) if span.name in feet for end in (span.a, span.b)]
    np.testing.assert_allclose([z for _, _, z in leaning], 0.0, rtol=0.0, atol=1e-9)


def test_a_potential_of_several_joints_is_no_spring_in_each_of_them() -> None:
    """A spring between two blocks was drawn as one from each of them to the wall."""
    x, y = mq.coordinate("x"), mq.coordinate("y")
    between = mq.Potential("between", ("x", "y"), 25.0 * (x - y) ** 2)
    alone = mq.Potential("alone", "x", 25.0 * x**2)
    for forces, drawn in (((between,), 0), ((alone,), 1), ((alone, between), 1)):
        blocks = mq.Mechanism(
            "blocks",
            (mq.Body("ground"), *(mq.Body(n, mq.particle(1.0)) for n in ("a", "b"))),
            tuple(
                mq.Prismatic(c, "ground", n, axis=(1, 0, 0), coordinate=c)
                for c, n in (("x", "a"), ("y", "b"))
            ),
            forces=forces,
        )
        assert figure_text(blocks).count('class="spring"') == drawn


def test_a_spring_ends_at_the_dot_of_its_mass() -> None:
    setting = seen("governor")
    marks = figure(setting)
    (spring,) = (
        m.points
        for m in marks
        if isinstance(m, Stroke) and len(m.points) > 12 and m.style == "spring"
    )
    sleeve = setting.camera.at(setting.point("sleeve"))
    assert np.hypot(*(spring[-1] - sleeve)) == pytest.approx(9.0, abs=1e-6)


def test_letters_have_their_subscripts() -> None:
    parts = {mark.parts for mark in figure(seen("whipple_bicycle")) if isinstance(mark, Words)}
    assert rich("m_R") in parts
    assert rich("mR") == rich("m_R")


def test_a_figure_in_latex_is_that_of_the_svg() -> None:
    """Strokes and circles in PDF's operators, letters as mathematics, upside up."""
    mechanism = mq.textbook.load("atwood_machine")
    text = figure_tex(mechanism, mq.textbook.entry("atwood_machine").start)
    shown = seen("atwood_machine")
    marks = figure(shown)
    paints = re.findall(r" [BSfn]$", text, re.MULTILINE)
    assert len(paints) == len([mark for mark in marks if not isinstance(mark, Words)])
    places = {
        letter: float(y)
        for y, letter in re.findall(r"\\put\([^,]+,([^)]+)\)\{\\makebox.*?\$(.+?)\$", text)
    }
    assert {"m_{\\mathrm{1}}", "m_{\\mathrm{2}}", "M", "R", "g"} <= places.keys()
    assert places["M"] > places["m_{\\mathrm{1}}"] > places["m_{\\mathrm{2}}"]
    assert text.count("{") == text.count("}")


@pytest.mark.parametrize(
    ("written", "printed"),
    [("alpha", "\\alpha "), ("a_b", "a_{\\mathrm{b}}"), ("k l²", "k\\mathrm{\\ }l\\mathrm{^2}")],
)
def test_letters_of_a_figure_are_safe_in_latex(written: str, printed: str) -> None:
    mark = Words(np.zeros(2), rich(written))
    assert f"${printed}$" in tex([mark])


def test_a_legend_sets_greek_letters_as_formulas_do() -> None:
    drawn = mq.picture(mq.textbook.load("screw_press")).svg
    assert "lower end at θ = 0" in re.sub(r"<[^>]*>", "", drawn)


def test_an_attraction_is_drawn_on_every_body_that_can_move() -> None:
    """As it acts at the instant: along the line of both ends, or along -grad V of a field."""
    planet = mq.textbook.load("kepler_orbit")
    assert mq.picture(planet).svg.count("attraction") == 1  # the sun stands on the ground
    x, _, z = mq.position()
    saddle = mq.PotentialField("saddle", "bob", (0, 0, 0), 3.0 * (z**2 - x**2))
    pendulum = mq.textbook.load("simple_pendulum")
    bob = pendulum.bodies[-1].name
    pushed = replace(pendulum, forces=(replace(saddle, body=bob, point=(0, 0, -1.0)),))
    where = setting(pushed, mq.Reference(pushed), posture(pushed), np.zeros(1), 0.0)
    (tip,) = [mark for mark in loads(where) if isinstance(mark, Stroke) and mark.closed]
    at = where.point(bob, (0, 0, -1.0))
    along = tip.points[0] - tip.points[1:].mean(axis=0)
    slope = np.array([6.0 * at[0], 6.0 * at[2]])  # -grad V, on paper with y downwards
    np.testing.assert_allclose(
        along / np.hypot(*along), slope / np.hypot(*slope), rtol=1e-9, atol=0
    )


@pytest.mark.parametrize(("angle", "below"), [(0.4, -1.0), (np.pi - 0.4, 1.0)])
def test_a_pivot_that_slides_has_a_rail_away_from_what_it_carries(
    angle: float, below: float
) -> None:
    m, l = mq.Parameter("m", 1.0, "kg"), mq.Parameter("l", 2.0, "m")
    pendulum = mq.Mechanism(
        "moving_pivot",
        (mq.Body("ground"), mq.Body("pivot"), mq.Body("rod", mq.rod(m, l))),
        (
            mq.Prismatic("slide", "ground", "pivot", axis=(1, 0, 0), coordinate="x"),
            mq.Revolute("pin", "pivot", "rod", axis=(0, -1, 0), coordinate="q"),
        ),
        parameters=(m, l),
    )
    q = np.array([0.3, angle])
    where = setting(pendulum, mq.Reference(pendulum), q, np.zeros(2), 0.0)
    lines = [mark for mark in supports(where) if isinstance(mark, Stroke)]
    (rail,) = [mark.points for mark in lines if mark.style == "ground"]
    pin = where.at("pivot")
    np.testing.assert_allclose(rail[:, 1] - pin[1], 8.0 * below, rtol=0, atol=1e-9)
    assert rail[:, 0].min() < pin[0] < rail[:, 0].max()


def test_the_length_of_a_rod_is_drawn_where_no_spring_crosses_it() -> None:
    """Beside the lower of two equal bars, beyond the letters of the particle on it."""
    for name in ("bars_and_springs", "bars_and_springs_loop"):
        view = seen(name)
        spans = [mark.points for mark in lengths(view) if isinstance(mark, Stroke)]
        longest = max(spans, key=lambda ends: float(np.ptp(ends, axis=0).max()))
        middle = longest.mean(axis=0)
        upper, lower = (view.camera.at(view.point(body)) for body in ("ABC", "DEF"))
        assert middle[1] > lower[1] > upper[1]
        axis = view.camera.at(view.point("DEF", (4 * view.mechanism.values["l"], 0, 0))) - lower
        away = abs(float(np.linalg.det([axis, middle - lower]))) / float(np.hypot(*axis))
        assert away > 30.0


def test_a_free_body_shows_the_directions_of_its_place() -> None:
    drawn = mq.picture(mq.textbook.load("free_rigid_body")).svg
    assert [f'font-style="italic">{letter}<' in drawn for letter in "xyz"] == [True] * 3
