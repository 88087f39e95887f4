"""Motions with corners on a page: played, with modes and losses named."""

from __future__ import annotations

import json
import math
import subprocess
from collections.abc import Callable
from dataclasses import asdict, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from sides import (
    CORNER,
    TRIPOD,
    make_ball,
    make_block,
    make_braked,
    make_buffer,
    make_corner,
    make_pair,
    make_rod,
    make_sled,
    make_slope,
    make_standing_box,
    make_tow,
    move_in_plane,
)
from viewing_browser import Visit
from viewing_engines import SCRIPTS, engine_of, needs_node, run

import mecanique as mq
from mecanique.motion.motion import Motion
from mecanique.textbook import entry, load
from mecanique.viewing.engine import Maker
from mecanique.viewing.live.view import Computed, follow
from mecanique.viewing.page.panels import safe, write_equations
from mecanique.viewing.scene.from_motion import scene_of
from mecanique.viewing.scene.inspection import inspection_of
from mecanique.viewing.scene.scene import ModeStrip
from mecanique.viewing.show import scene


def move(name: str, duration: float | None = None, **parameters: float) -> Motion:
    """Simulate a textbook system from its usual start."""
    system = entry(name)
    v = {rate.removesuffix("'"): value for rate, value in system.start_velocity.items()}
    mechanism = load(name, **parameters)
    return mq.simulate(mechanism, q=dict(system.start), v=v, duration=duration or system.duration)


def test_losses_are_what_the_energy_lacks() -> None:
    oscillator = move("dry_oscillator")
    lost = oscillator.losses()
    energy = oscillator.energy()
    assert list(lost) == ["dry: friction"]
    assert lost["dry: friction"] == pytest.approx(energy.total[0] - energy.total, abs=1e-10)
    ball = move("bouncing_ball")
    energy = ball.energy()
    total = sum(ball.losses().values())
    assert total == pytest.approx(energy.total[0] - energy.total, abs=1e-9)
    assert "floor: impact: " in ball.summary()


def test_a_moving_belt_does_work_and_heats() -> None:
    motion = move("stick_slip")
    belt = motion.losses()["belt: friction"]
    # what slips heats whichever way the block moves, though the belt feeds it
    assert np.all(np.diff(belt) > -1e-12)
    # the impulse of friction is m Δx' + k ∫ x dt; times the belt's speed it is the belt's work
    p = motion.mechanism.values
    t = np.linspace(0.0, 10.0, 20_001)
    x = motion(t).q[:, 0]
    impulse = p["m"] * (motion["x'"][-1] - motion["x'"][0]) + p["k"] * np.trapezoid(x, t)
    total = motion.energy().total
    assert belt[-1] == pytest.approx(p["v"] * impulse - (total[-1] - total[0]), rel=1e-6)
    spans = [span for span in motion.modes if span.states["belt"] == "sticks"]
    at_ends = motion.losses([spans[1].begin, spans[1].end])["belt: friction"]
    assert at_ends[1] - at_ends[0] == pytest.approx(0.0, abs=1e-12)


def test_a_scene_has_a_strip_for_each_element() -> None:
    ladder = scene(move("ladder", 0.9), equations=(), verdict=None)
    floor, wall = ladder.modes
    assert floor == ModeStrip("floor", ((0.0, 0.9, "closed"),))
    assert [state for _, _, state in wall.spans] == ["closed", "open"]
    assert wall.spans[0][1] == wall.spans[1][0]
    (strip,) = scene(move("pendulum_with_stop"), equations=(), verdict=None).modes
    assert len(strip.impacts) == 7
    # what is touched is drawn: floor and wall as plates whose upper sides are the planes
    ground = ladder.bodies[0].shapes
    assert [shape.kind for shape in ground] == ["box", "box"]
    upper = [s.pose @ (0.0, 0.0, s.size[2] / 2, 1.0) for s in ground]
    assert [upper[0][2], upper[1][0]] == pytest.approx([0.0, 0.0], abs=1e-15)
    assert scene(move("two_blocks", 0.1), equations=(), verdict=None).modes == ()


def test_a_page_names_modes_with_their_equations() -> None:
    motion = move("stick_slip", 1.0)
    document = scene(motion).document
    (modes,) = document.derivations
    headings = [block.heading for block in modes.blocks if block.heading]
    assert headings == ["belt sticks", "belt slips +", "belt slips -"]
    (formula,) = (
        formula for block in modes.blocks for words, formula in block.held if words == "sticks if"
    )
    assert "<mo>|</mo><mrow><mfrac>" in formula
    assert "<mo>≤</mo>" in formula
    assert f'<p class="note">sticks if {safe(formula)}</p>' in write_equations(document)
    assert document.verdict.agrees
    assert "belt" in document.urdf
    assert "R_belt" not in document.figure
    assert document.recorded == ""
    derived = scene(motion, mq.derive_modes(motion.described)).document.derivations
    assert derived == document.derivations
    many = tuple(mq.Friction(f"dry{k}", "slide", 0.1, 1.0) for k in range(5))
    block = mq.Mechanism(
        "block",
        (mq.Body("ground"), mq.Body("block", mq.box(1.0, (0.1, 0.1, 0.1)))),
        (mq.Prismatic("slide", "ground", "block", axis=(1, 0, 0), coordinate="x"),),
        switching=many,
    )
    (left_out,) = scene(mq.simulate(block, v={"x": 1.0}, duration=0.1)).document.derivations
    assert "They are not written out: mechanism 'block' has 243 modes" in left_out.blocks[0].note


def test_what_switches_is_drawn_and_inspected_like_any_mechanism() -> None:
    ball = load("bouncing_ball")
    assert "<svg" in mq.picture(ball).svg
    assert [slider.name for slider in inspection_of(ball, ()).sliders] == ["z"]


def test_a_live_view_streams_what_its_page_cannot_compute() -> None:
    mechanism = load("dry_oscillator")
    with pytest.raises(mq.DerivationError, match="a live view streams motions with corners"):
        Computed(mechanism, None, None, np.inf, 1e-10, 1.0)
    first = move("dry_oscillator", 0.2)
    with pytest.raises(mq.DerivationError, match="a live view streams motions with corners"):
        Computed(first, None, None, np.inf, 1e-10, 1.0)
    last = list(follow(first, 2.0, lambda: 1.0))[-1]
    (x,) = [curve for curve in last.series if curve.name == "x"]
    assert x.values[-1] == pytest.approx(-0.0019, abs=1e-4)


COMPUTED = (
    "bead_leaves_sphere",
    "billiard_ball",
    "block_on_incline",
    "bouncing_ball",
    "capstan",
    "clutch",
    "dry_oscillator",
    "ladder",
    "newtons_cradle",
    "painleve_rod",
    "pendulum_with_stop",
    "rocking_block",
    "slack_cord",
    "stick_slip",
)


@needs_node
def test_a_page_computes_motions_with_corners_as_python_does(tmp_path: Path) -> None:
    compare([move(name, min(entry(name).duration, 3.0)) for name in COMPUTED], tmp_path)


@needs_node
@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "duration"),
    [
        ("clearance_slider_crank", 0.05),  # of 256 modes its guide allows 45
        ("woodpecker", 0.35),
    ],
)
def test_a_page_computes_contacts_of_which_few_close_at_once(
    name: str, duration: float, tmp_path: Path
) -> None:
    compare([move(name, duration)], tmp_path)


@needs_node
def test_last_bounces_end_by_impulses_of_the_bodies_masses(tmp_path: Path) -> None:
    """A particle of 1 kg on a carriage of 3 kg falls on a slope of 30° and slides down it."""
    slope = mq.Placement((0, 0, 0), (0, math.pi / 6, 0))
    mechanism = mq.Mechanism(
        "slope",
        (
            mq.Body("ground"),
            mq.Body("carriage", mq.box(3.0, (0.1, 0.1, 0.1))),
            mq.Body("particle", mq.particle(1.0)),
        ),
        (
            mq.Prismatic("level", "ground", "carriage", axis=(1, 0, 0), coordinate="x"),
            mq.Prismatic("upright", "carriage", "particle", axis=(0, 0, 1), coordinate="z"),
        ),
        switching=(mq.Contact("slope", "particle", plane=slope, restitution=0.5),),
    )
    motion = mq.simulate(mechanism, q={"z": 0.1}, duration=0.8, rtol=1e-12)
    assert motion.modes[-1].states == {"slope": "closed"}
    times = [0.1, 0.3, 0.5, 0.8]
    task = {"engine": asdict(engine_of(motion)), "rtol": 1e-11, "times": times}
    (computed,) = run([task], tmp_path)
    known = motion(times)
    states = np.array(computed["states"])[:, :4]
    np.testing.assert_allclose(states, np.hstack([known.q, known.v]), rtol=0, atol=1e-9)


def compare(motions: list[Motion], tmp_path: Path) -> None:
    """Compare states, work and losses of pages at times between corners."""
    tasks = []
    for motion in motions:
        times = (float(motion.t[-1]) * np.array([0.13, 0.37, 0.61, 0.83, 1.0])).tolist()
        tasks.append({"engine": asdict(engine_of(motion)), "rtol": 1e-11, "times": times})
    for motion, task, computed in zip(motions, tasks, run(tasks, tmp_path), strict=True):
        states, times = np.array(computed["states"]), task["times"]
        known, lost = motion(times), motion.losses(times)
        expected = np.hstack([known.q, known.v, motion.energy(times).work[:, None]])
        size = np.abs(expected).max()
        width = expected.shape[1]
        assert computed["stopped"] == ""
        np.testing.assert_allclose(states[:, :width], expected, rtol=0, atol=1e-9 * size)
        names = task["engine"]["switching"]["losses"]
        assert lost.keys() <= set(names)
        for column, name in zip(states.T[width:], names, strict=True):
            taken = lost.get(name, np.zeros(len(times)))
            np.testing.assert_allclose(column, taken, rtol=1e-8, atol=1e-9 * size, err_msg=name)


def test_a_cord_that_a_spring_pulls_is_drawn_once() -> None:
    capstan = load("capstan")
    spring = mq.JointSpring("spring", capstan.joints[0].name, 30.0)
    system = entry("capstan")
    motion = mq.simulate(
        replace(capstan, forces=(*capstan.forces, spring)), q=system.start, duration=0.1
    )
    lines = [(line.name, line.kind) for line in scene_of(motion, None, ()).lines]
    first, second = (f"joint {joint.name}" for joint in capstan.joints[:2])
    assert lines == [(first, "spring"), (second, "rod")]


def test_a_page_that_computes_keeps_forces_that_end_within_the_motion() -> None:
    """A ladder leaves the wall; the weights and contacts of all bodies have their arrows."""
    motion = move("ladder")
    maker = Maker(motion, mq.derive(motion.mechanism))
    shown = {arrow.name for arrow in maker.thin(scene_of(motion)).arrows}
    assert shown >= {"weight of ladder", "floor, normal on ladder", "wall, normal on ladder"}


DOME = move_in_plane(
    mq.ball(1.0, 0.1),
    mq.Contact("dome", "body", radius=0.1, bowl=-1.0, plane=mq.Placement((0, 0, 1.0))),
)

SIDES: dict[str, tuple[mq.Mechanism, dict[str, float], dict[str, float], float]] = {
    "sled": (make_sled(0.4), {"x": -0.5}, {"x": 2.0}, 0.8),
    "block": (make_block(0.4, 0.2, 0.0), {"x": -0.5, "z": 0.1}, {"x": 2.0}, 0.6),
    "ball": (make_ball(0.1, 0.0), {"x": -0.1, "z": 0.1}, {"x": 0.3}, 1.2),
    # 0.1 mm deep, within one step
    "dome": (replace(DOME, gravity=(0, 0, 0)), {"x": -0.23, "z": 1.0999}, {"x": 1.0}, 0.4),
}


@needs_node
def test_a_page_lets_a_wall_bear_what_a_spent_brake_cannot(tmp_path: Path) -> None:
    """The weight swings as 0.3 sin(√10 t) until it pulls the block off by 1 N again."""
    motion = mq.simulate(make_braked(), v={"y": 0.3 * math.sqrt(10)}, duration=3.0, rtol=1e-12)
    times = [0.5, 1.0, 1.5, 2.0, 2.4, 2.6, 2.9, 3.0]
    task = {"engine": asdict(engine_of(motion)), "rtol": 1e-11, "times": times}
    (computed,) = run([task], tmp_path)
    assert computed["stopped"] == ""
    states = np.array(computed["states"])
    still = [[0.0, 0.3 * math.sin(math.sqrt(10) * t)] for t in times[:2]]
    np.testing.assert_allclose(states[:2, :2], still, rtol=0, atol=1e-11)
    known = motion(times)
    np.testing.assert_allclose(states[:, :4], np.hstack([known.q, known.v]), rtol=0, atol=1e-9)


@needs_node
@pytest.mark.parametrize(
    ("mechanism", "q"),
    [
        pytest.param(make_tow(), {"y": 0.05}, id="coin"),
        pytest.param(make_pair(), {}, id="blocks"),
        pytest.param(make_tow(2), {"y1": 0.05, "y2": -0.05}, id="coins", marks=pytest.mark.slow),
    ],
)
def test_a_page_begins_to_slip_in_space_and_of_several_at_once(
    mechanism: mq.Mechanism, q: dict[str, float], tmp_path: Path
) -> None:
    motion = mq.simulate(mechanism, q=q, v={"x": 1.0}, duration=0.08, rtol=1e-11)
    begun = motion.modes[1].begin
    times = [begun + later for later in (1e-6, 1e-4, 1e-3, 1e-2)]
    task = {"engine": asdict(engine_of(motion)), "rtol": 1e-11, "times": times}
    (computed,) = run([task], tmp_path)
    assert computed["stopped"] == ""
    known = motion(times)
    states = np.array(computed["states"])[:, : mechanism.nq + mechanism.nv]
    np.testing.assert_allclose(states, np.hstack([known.q, known.v]), rtol=0, atol=1e-10)


@pytest.mark.slow
@needs_node
@pytest.mark.parametrize(
    "box",
    [make_standing_box(0.3, 3.0), make_standing_box(0.3, 3.2, TRIPOD, aside=0.1)],
    ids=["corners", "tripod"],
)
def test_a_page_begins_to_slide_on_several_feet(box: mq.Mechanism, tmp_path: Path) -> None:
    motion = mq.simulate(box, q={"free_z": 0.1}, duration=0.1, rtol=1e-11)
    times = [1e-6, 1e-3, 0.1]
    task = {"engine": asdict(engine_of(motion)), "rtol": 1e-11, "times": times}
    (computed,) = run([task], tmp_path)
    assert computed["stopped"] == ""
    known = motion(times)
    states = np.array(computed["states"])[:, : box.nq + box.nv]
    np.testing.assert_allclose(states, np.hstack([known.q, known.v]), rtol=0, atol=1e-9)


def test_a_page_of_feet_that_share_static_friction_shows_a_recorded_motion() -> None:
    """It had found no mode, and stayed without equations and forces."""
    at = {"free_z": 0.1}
    pulled = scene(mq.simulate(make_standing_box(0.3, 2.9), q=at, duration=0.1))
    assert "share static friction in the mode sticks, sticks, sticks, sticks" in (
        pulled.document.recorded
    )
    assert not scene(mq.simulate(make_standing_box(0.3), q=at, duration=0.1)).document.recorded


@needs_node
def test_a_page_leaves_an_elastic_stop(tmp_path: Path) -> None:
    speeds = np.arange(1.0, 3.25, 0.25)
    motions = [mq.simulate(make_buffer(), v={"x": v}, duration=1.0) for v in speeds]
    tasks = [{"engine": asdict(engine_of(m)), "rtol": 1e-11, "times": [1.0]} for m in motions]
    for speed, computed in zip(speeds, run(tasks, tmp_path), strict=True):
        left = 1.0 - 0.2 / speed - math.pi / 20
        assert computed["stopped"] == ""
        assert computed["states"][-1][0] == pytest.approx(0.2 - speed * left, rel=0, abs=1e-9)


@needs_node
@pytest.mark.parametrize("name", SIDES)
def test_a_page_computes_what_leaves_a_side_as_python_does(name: str, tmp_path: Path) -> None:
    mechanism, q, v, duration = SIDES[name]
    motion = mq.simulate(mechanism, q=q, v=v, duration=duration, rtol=1e-11)
    assert motion.modes[-1].states == dict.fromkeys(motion.modes[-1].states, "open")
    times = (duration * np.array([0.1, 0.3, 0.5, 0.7, 0.9, 1.0])).tolist()
    task = {"engine": asdict(engine_of(motion)), "rtol": 1e-11, "times": times}
    (computed,) = run([task], tmp_path)
    assert computed["stopped"] == ""
    known = motion(times)
    expected = np.hstack([known.q, known.v])
    states = np.array(computed["states"])[:, : expected.shape[1]]
    np.testing.assert_allclose(states, expected, rtol=0, atol=1e-9)


@needs_node
def test_a_page_ends_bounces_with_their_friction(tmp_path: Path) -> None:
    motion = mq.simulate(make_slope(0.1), q={"x": 0.15, "z": 0.26}, duration=2.0, rtol=1e-12)
    assert motion.modes[-1].states == {"slope": "slips +"}
    compare([motion], tmp_path)
    times = [0.5, 1.5, 2.0]
    task = {"engine": asdict(engine_of(motion)), "rtol": 1e-12, "times": times}
    (computed,) = run([task], tmp_path)
    states = np.array(computed["states"])[:, :4]
    known = motion(times)
    np.testing.assert_allclose(states, np.hstack([known.q, known.v]), rtol=0, atol=1e-12)


@needs_node
def test_a_page_computes_bodies_without_weight(tmp_path: Path) -> None:
    """Rows of contacts have no acceleration but that of rounding, which differs."""
    right = mq.Placement((1.0, 0, 0), (0, -math.pi / 2, 0))
    wall = mq.Contact("wall", "body", radius=0.1, plane=right, mu=0.15, restitution=0.9)
    body = replace(move_in_plane(mq.ball(1.0, 0.1), wall), gravity=(0, 0, 0))
    motion = mq.simulate(body, q={"x": 0.5}, v={"x": 2.0, "z": 1.0, "th": 5.0}, duration=1.0)
    compare([motion], tmp_path)


@needs_node
@pytest.mark.parametrize("mu", [0.0, 0.2])
def test_a_page_ends_bounces_while_another_contact_is_held(mu: float, tmp_path: Path) -> None:
    """Of what rests between two rough planes friction is not determined, and nothing slips."""
    motion = mq.simulate(make_corner(mu), q=CORNER, duration=1.5, rtol=1e-12)
    times = [0.3, 0.6, 0.9, 1.2, 1.5]
    (computed,) = run(
        [{"engine": asdict(engine_of(motion)), "rtol": 1e-11, "times": times}], tmp_path
    )
    known = motion(times)
    states = np.array(computed["states"])
    assert computed["stopped"] == ""
    assert computed["steps"] < 1000
    np.testing.assert_allclose(states[:, :4], np.hstack([known.q, known.v]), rtol=0, atol=1e-11)
    lost = sum(motion.losses(times).values())
    np.testing.assert_allclose(states[:, 5:].sum(axis=1), lost, rtol=0, atol=1e-13)
    np.testing.assert_allclose(states[:, 4], -np.array(lost), rtol=0, atol=1e-13)
    assert computed["strips"] == [
        [name, motion.modes[-1].states[name]] for name in ("slope", "wall")
    ]


RESTS: dict[str, tuple[dict[str, float], list[tuple[str, bool, list[list[float | None]]]]]] = {
    "bouncing_ball": ({}, [("closed", True, [[0.0, 0.0]])]),
    # within mu m g/k of where the spring is slack
    "dry_oscillator": ({}, [("sticks", True, [[-0.00981, 0.00981]])]),
    # tan 0.4 = 0.42
    "block_on_incline": ({"mu_0": 0.43}, [("sticks", True, [[None, None]])]),
    "block_on_incline ": ({"mu_0": 0.42}, []),
    # kinetic friction of the belt stretches the spring by mu m g/k
    "stick_slip": ({}, [("slips -", True, [[0.01962, 0.01962]])]),
    "pendulum_with_stop": (
        {},
        [("open", True, [[0.0, 0.0]]), ("open", False, [[math.pi, math.pi]])],
    ),
}


@needs_node
@pytest.mark.parametrize("name", RESTS)
def test_a_page_has_what_rests_in_contact_and_by_friction(name: str, tmp_path: Path) -> None:
    """Each with its mode, its stability, and how far friction holds around it."""
    parameters, expected = RESTS[name]
    motion = move(name.strip(), 0.1, **parameters)
    task = {"engine": asdict(engine_of(motion)), "spans": [math.pi], "turns": [True]}
    rests = run(task, tmp_path, "find_rests")
    assert [(*rest["mode"], rest["stable"]) for rest in rests] == [rest[:2] for rest in expected]
    for rest, (_, _, ranges) in zip(rests, expected, strict=True):
        ends = [x for pair in rest["ranges"] for x in pair]
        known = [x for pair in ranges for x in pair]  # None where it is infinite
        assert ends == [x if x is None else pytest.approx(x, abs=1e-8) for x in known]


@needs_node
@pytest.mark.parametrize(
    ("name", "start", "target", "place"),
    [
        # the hand, a spring of 40 times the mass, bears the weight; the center is 0.1 above z
        ("bouncing_ball", {"z": 0.0}, [0, 0, 1.1], 1.0 - 9.81 / 40),
        ("bouncing_ball", {"z": 0.0}, [0, 0, 0.2], 0.0),  # too little to lift it
        ("dry_oscillator", {"x": 0.0}, [0.02, 0, 0], 0.0),  # sticks: 0.8 N against 0.981 N
    ],
)
def test_what_is_pulled_keeps_its_contacts_and_its_friction(
    name: str, start: dict[str, float], target: list[float], place: float, tmp_path: Path
) -> None:
    motion = mq.simulate(load(name), q=start, duration=0.1)
    body = [body.name for body in motion.mechanism.bodies].index(motion.mechanism.joints[-1].child)
    task = {"engine": asdict(engine_of(motion)), "body": body, "target": target, "times": 200}
    (pulled,) = run(task, tmp_path, "pull_body")
    assert pulled["q"] == pytest.approx([place], abs=2e-3)
    assert pulled["force"] is None


@needs_node
def test_a_page_stops_where_something_comes_in_below_a_side(tmp_path: Path) -> None:
    top = make_ball(0.1, 0.0).switching[:1]
    motion = mq.simulate(
        move_in_plane(mq.ball(1.0, 0.1), *top),
        q={"x": 0.1, "z": -0.5},
        v={"x": -1.0},
        duration=0.05,
    )
    engine = asdict(engine_of(motion)) | {"duration": 0.3}
    task = {"engine": engine, "rtol": 1e-11, "times": [0.05, 0.2]}
    (computed,) = run([task], tmp_path)
    assert computed["stopped"] == "where top comes in from beyond an end of its side, below it"


@needs_node
def test_a_page_of_painlevés_rod_stops_where_no_mode_follows(tmp_path: Path) -> None:
    """Beyond μ = 4/3 a rod that slides on its end has no solution, or two."""
    engine = asdict(engine_of(move("painleve_rod", 0.05)))
    engine["values"] = [
        3.0 if name == "mu" else value
        for name, value in zip(engine["parameters"], engine["values"], strict=True)
    ]
    task = {"engine": engine, "rtol": 1e-10, "times": []}
    path = tmp_path / "tasks.json"
    path.write_text(json.dumps([task]), encoding="utf-8")
    done = subprocess.run(
        ["node", str(SCRIPTS / "run_engines.js"), str(path)], capture_output=True, encoding="utf-8"
    )
    assert "There is no motion with these values" in done.stderr


@pytest.mark.parametrize(
    ("q", "v"),
    [
        ({"z": 0.9, "th": 0.2}, {"x": 0.3}),  # its slip turns round
        ({"z": 0.9, "th": 1.2}, {"x": -1.0, "th": 1.0}),
    ],
)
@needs_node
def test_a_page_has_poissons_impacts(
    q: dict[str, float], v: dict[str, float], tmp_path: Path
) -> None:
    motion = mq.simulate(make_rod("poisson"), q=q, v=v, duration=0.45, rtol=1e-12)
    times = [0.2, 0.4, 0.45]
    (computed,) = run(
        [{"engine": asdict(engine_of(motion)), "rtol": 1e-11, "times": times}], tmp_path
    )
    known, lost = motion(times), motion.losses(times)
    expected = np.hstack([known.q, known.v])
    states = np.array(computed["states"])
    np.testing.assert_allclose(states[:, :6], expected, rtol=0, atol=1e-11)
    np.testing.assert_allclose(states[:, -1], lost["end: impact"], rtol=0, atol=1e-11)


@needs_node
@pytest.mark.slow
def test_a_page_computes_slip_in_space_as_python_does(tmp_path: Path) -> None:
    """A tippe top slips in a direction that turns round and round, until it rolls at 1.025 s."""
    system = entry("tippe_top")
    v = {rate.removesuffix("'"): value for rate, value in system.start_velocity.items()}
    motion = mq.simulate(system.mechanism(), q=system.start, v=v, duration=1.2, rtol=1e-12)
    assert [dict(span.states) for span in motion.modes] == [{"floor": "slips"}, {"floor": "sticks"}]
    times = [0.3, 0.6, 1.0, 1.1, 1.2]
    task = {"engine": asdict(engine_of(motion)), "rtol": 1e-12, "times": times}
    (computed,) = run([task], tmp_path)
    assert computed["stopped"] == ""
    assert computed["strips"] == [["floor", "sticks"]]
    known = motion(times)
    expected = np.hstack([known.q, known.v])
    states = np.array(computed["states"])
    np.testing.assert_allclose(states[:, : expected.shape[1]], expected, rtol=0, atol=1e-8)
    heat = motion.losses(times)["floor: friction"]
    np.testing.assert_allclose(-states[:, expected.shape[1]], heat, rtol=1e-9, atol=0)


@needs_node
def test_a_page_has_impacts_with_slip_in_space(tmp_path: Path) -> None:
    """A ball at 5 m/s falls 0.2 m and slips as it strikes: μ (1 + e) u < 2/7 · 5 m/s."""
    ball = mq.Mechanism(
        "ball",
        (mq.Body("ground"), mq.Body("ball", mq.ball(1.0, 0.1))),
        (mq.Floating("free", "ground", "ball"),),
        switching=(mq.Contact("floor", "ball", radius=0.1, restitution=0.5, mu=0.2),),
    )
    motion = mq.simulate(
        ball, q={"free_z": 0.3}, v={"free_vx": 3.0, "free_vy": 4.0}, duration=1.0, rtol=1e-12
    )
    fall = math.sqrt(0.4 / 9.81)
    times = [0.1, fall + 0.01, 0.5, 1.0]
    task = {"engine": asdict(engine_of(motion)), "rtol": 1e-12, "times": times}
    (computed,) = run([task], tmp_path)
    assert computed["stopped"] == ""
    known = motion(times)
    states = np.array(computed["states"])[:, :13]
    np.testing.assert_allclose(states, np.hstack([known.q, known.v]), rtol=0, atol=1e-8)
    slowed = 5.0 - 0.2 * 1.5 * 9.81 * fall
    x, y = states[1, :2]
    assert math.hypot(x, y) == pytest.approx(5.0 * fall + 0.01 * slowed, rel=0, abs=1e-9)


SHOWN = """() => [...document.querySelectorAll("#strips .strip")].map((row) => [
    row.querySelector("span").textContent,
    row.querySelectorAll("b").length,
    row.querySelectorAll("u").length,
    row.querySelector("output").textContent,
    parseFloat(row.querySelector("i").style.left)])"""

MIDDLE = """() => {
    const { picture, stage } = mecanique;
    const [x, y] = stage.project(picture.row.slice(7, 10));
    const { left, top } = stage.pane.getBoundingClientRect();
    return [left + x, top + y];
}"""
"""The middle of the first moving body in the window [px]."""


def test_a_page_plays_a_ball_that_bounces_to_rest(show: Callable[..., Visit]) -> None:
    motion = move("bouncing_ball")
    seen = show(scene(motion))
    impacts = sum(event.impact for event in motion.events)
    seen.seek(2.0)
    assert seen.js(SHOWN) == [["floor", 2, impacts, "open", 40.0]]
    seen.seek(4.5)
    assert seen.js(SHOWN)[0][3] == "closed"
    place = motion.poses(4.5)[1, :3, 3]
    assert seen.body(1)[:3] == pytest.approx(place, abs=1e-3)
    seen.page.click("#tab-ledger")
    rows: dict[str, Any] = dict(
        seen.js(
            "[...document.querySelectorAll('#energy-table tr')].map((row) => "
            "[row.cells[0].textContent, row.cells[1].textContent])"
        )
    )
    lost = float(motion.losses([4.5])["floor: impact"][0])
    assert float(rows["lost by impact, floor"]) == pytest.approx(lost, rel=1e-3)
    assert rows["Sum"] == rows["At the start, and work of drives and other loads since"]
    # a click on the strip moves the clock
    seen.page.click("#strips .track", position={"x": 3, "y": 5})
    assert seen.js("mecanique.clock.time") < 0.3
    # and the page plays on from there
    before = seen.js("mecanique.clock.time")
    seen.page.click("#play")
    seen.until(f"mecanique.clock.time > {before}")
    # from half the height the last bounce ends √2 sooner, and the strip says so
    seen.page.click("#tab-parameters")
    seen.page.fill("#panel-parameters [data-kind=initial][data-name=z]", "0.5")
    rest = "mecanique.setup.bench.table.path.corners.strips(5)[0].spans.at(-1)[0]"
    lower = mq.simulate(load("bouncing_ball"), q={"z": 0.5}, duration=5.0)
    begin = lower.modes[-1].begin
    assert begin == pytest.approx(motion.modes[-1].begin / np.sqrt(2), abs=2e-4)
    seen.until(f"mecanique.setup.bench.table && Math.abs({rest} - {begin}) < 1e-6")
    assert seen.js(SHOWN)[0][1] == 2
    seen.page.click("#tab-ledger")
    assert seen.js("document.querySelectorAll('#energy-table tfoot td')[0].textContent") == seen.js(
        "document.querySelectorAll('#energy-table tfoot td')[1].textContent"
    )
    # a hand lifts the ball, and does not press it into the ground
    heights = []
    for lift in (60, -500):
        seen.seek(0)
        x, y = seen.js(MIDDLE)
        seen.page.mouse.move(x, y)
        seen.page.mouse.down()
        seen.page.mouse.move(x, y - lift)
        assert seen.js("mecanique.picture.row[9]") >= 0.1 - 1e-9  # the floor holds as it is held
        seen.page.mouse.up()
        heights.append(seen.js("mecanique.setup.bench.setting.start[0]"))
    assert heights[0] > 0.6
    assert heights[1] == pytest.approx(motion.q[-1, 0], abs=1e-9)
    # where it rests; what it is pulled by lifts it from there
    seen.page.click("#tab-parameters")
    seen.page.click("#modes-find")
    seen.until("document.getElementById('modes-find').textContent === 'Find rest and modes'")
    told = "At rest where z = 0, floor closed: stable. Nothing is free to move there."
    assert seen.page.inner_text("#modes-told") == told
    assert seen.page.is_hidden("#modes")
    seen.page.select_option("#drag", "pull")
    seen.seek(0)
    x, y = seen.js(MIDDLE)
    seen.page.mouse.move(x, y)
    seen.page.mouse.down()
    seen.page.mouse.move(x, y - 200)
    seen.until("mecanique.picture.row[9] > 0.3")
    seen.page.mouse.up()
    assert seen.js("mecanique.setup.bench.setting.start[0]") > 0.2
    seen.clean()


BARS = """() => [...document.querySelectorAll("#strips b")].map((bar) => [
    bar.dataset.state, getComputedStyle(bar).backgroundColor, bar.getBoundingClientRect().width])"""


def test_a_bar_has_a_color_for_each_state(show: Callable[..., Visit]) -> None:
    """A block goes up an incline, turns and slips down: bars as long as it does so."""
    motion = move("block_on_incline")
    seen = show(scene(motion))
    (up, first, short), (down, second, long) = seen.js(BARS)
    assert (up, down) == ("slips -", "slips +")
    assert (first, second) == ("rgb(240, 228, 66)", "rgb(230, 159, 0)")
    turn = motion.modes[0].end
    assert short / (short + long) == pytest.approx(turn / float(motion.t[-1]), abs=0.01)
    seen.clean()


def test_arrows_of_friction_are_opposite_to_slip() -> None:
    for name, arrow in (("block_on_incline", "dry on block"), ("stick_slip", "belt on block")):
        motion = move(name)
        (friction,) = [a for a in scene_of(motion).arrows if a.name == arrow]
        rates = motion.v[:, 0] - motion.mechanism.values.get("v", 0.0)
        slips = np.abs(rates) > 1e-6
        joint = motion.poses()[:, 1, :3, 3]
        way = joint[np.argmax(motion.q[:, 0])] - joint[np.argmin(motion.q[:, 0])]
        along = friction.vector @ way
        assert slips.any()
        assert (along[slips] * rates[slips] < 0).all()


def test_strips_fit_a_phone(show: Callable[..., Visit]) -> None:
    seen = show(scene(move("stick_slip")), viewport={"width": 390, "height": 844})
    seen.seek(5.0)
    (row,) = seen.js(SHOWN)
    assert row[1] == 25
    assert seen.js("document.documentElement.scrollWidth") <= 390
    box = seen.page.locator("#strips .track").bounding_box()
    assert box is not None
    assert box["width"] > 200
    seen.clean()
