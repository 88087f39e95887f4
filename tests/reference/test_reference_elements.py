"""Actions of cords, belts and teeth against the geometry of tangents and of lines of action."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from sympy import cos, sin, sqrt

import mecanique as mq
from mecanique.model.constraints.loops import CLOSED
from mecanique.reference.engine.forces.elements import Elements
from mecanique.verification.states import random_states

ACROSS = (0.0, -1.0, 0.0)
FLAT = (np.pi / 2, 0.0, 0.0)
BIG, SMALL, PRELOAD, DRIVE = 0.3, 0.1, 20.0, 2.0
PLACE, TILT = (0.2, 0.1, 0.4), (0.5, -0.3, 0.8)


def wheels(*elements: mq.Belt | mq.Gear, second: tuple[float, float, float]) -> mq.Mechanism:
    """Return two wheels on a tilted frame, the second three times as fast as the first."""
    return mq.Mechanism(
        "wheels",
        (
            mq.Body("ground"),
            mq.Body("frame"),
            mq.Body("a", mq.disk(1.0, BIG).at(rpy=FLAT)),
            mq.Body("b", mq.disk(2.0, SMALL).at(rpy=FLAT)),
        ),
        (
            mq.Fixed("mount", "ground", "frame", origin=mq.Placement(PLACE, TILT)),
            mq.Revolute("A", "frame", "a", axis=ACROSS),
            mq.Revolute("B", "frame", "b", axis=ACROSS, origin=mq.Placement(second)),
        ),
        forces=(mq.JointForce("drive", "A", DRIVE),),
        elements=elements,
        coordinates=mq.Coordinates(
            ("A",),
            {
                "B": (-3 if isinstance(g := elements[0], mq.Gear) and not g.internal else 3)
                * mq.coordinate("A"),
            },
        ),
    )


def normal_in_world() -> np.ndarray:
    """Return the axis of the wheels in the world, by Rz Ry Rx."""
    turned: np.ndarray = Rotation.from_euler("xyz", TILT).apply(ACROSS)
    return turned


def test_runs_of_a_belt_are_tangents_in_the_plane_of_its_frame() -> None:
    over = mq.Pulley("a", BIG), mq.Pulley("b", SMALL)
    belt = mq.Belt("belt", over, preload=PRELOAD, normal=ACROSS, axes="frame")
    mechanism = wheels(belt, second=(0.7, 0.0, 0.2))
    reference = mq.Reference(mechanism)
    q, n = [0.4], normal_in_world()
    tensions = reference.guide_forces(q)
    assert sum(tensions.values()) / 2 == pytest.approx(PRELOAD, rel=1e-12)
    actions = reference.guide_actions(q)
    assert len(actions) == 4
    for action in actions:
        center = reference.pose(action.body, q)[:3, 3]
        arm, radius = action.point - center, {"a": BIG, "b": SMALL}[action.body]
        assert np.linalg.norm(arm) == pytest.approx(radius, rel=1e-12)
        assert arm @ n == pytest.approx(0, abs=1e-14)
        assert arm @ action.force == pytest.approx(0, abs=1e-13)
        assert np.linalg.norm(action.force) == pytest.approx(tensions[action.name], rel=1e-12)
    for first, second in zip(actions[::2], actions[1::2], strict=True):
        assert (first.body, first.other) == (second.other, second.body)
        np.testing.assert_allclose(first.force, -second.force, rtol=0, atol=1e-13)
        run = second.point - first.point
        np.testing.assert_allclose(np.cross(run, first.force), 0.0, rtol=0, atol=1e-13)
        assert run @ first.force > 0  # it pulls
    # the moment on the driven wheel about its axis, of both runs, turns three times its inertia
    rate = reference.acceleration(q)[0]
    (inertia,) = {0.5 * 2.0 * SMALL**2}
    moment = sum(
        float(np.cross(action.point - reference.pose("b", q)[:3, 3], action.force) @ n)
        for action in actions
        if action.body == "b"
    )
    assert moment == pytest.approx(inertia * 3 * rate, rel=1e-11)


@pytest.mark.parametrize("offset", [0.0, 0.05])
@pytest.mark.parametrize("internal", [False, True])
def test_teeth_touch_on_the_pitch_circles(offset: float, internal: bool) -> None:
    """Whatever stands between the wheels along their axes does not count."""
    angle = 0.35
    gear = mq.Gear(
        *("mesh", "A", "B", BIG), other_radius=SMALL, internal=internal, pressure_angle=angle
    )
    between = BIG - SMALL if internal else BIG + SMALL
    mechanism = wheels(gear, second=(between, offset, 0.0))
    reference = mq.Reference(mechanism)
    q, n = [0.4], normal_in_world()
    along = Rotation.from_euler("xyz", TILT).apply([1.0, 0.0, 0.0])
    (force,) = reference.guide_forces(q).values()
    actions = reference.guide_actions(q)
    assert {action.body for action in actions} == {"a", "b"}
    for action in actions:
        arm = action.point - reference.pose("a", q)[:3, 3]
        np.testing.assert_allclose(arm - (arm @ n) * n, BIG * along, rtol=0, atol=1e-14)
        assert action.force @ n == pytest.approx(0, abs=1e-13)
        # teeth push the wheels apart, those of a ring towards its center
        outward = 1 if (action.body == "b") != internal else -1
        radial = outward * action.force @ along
        assert radial == pytest.approx(abs(force) * np.sin(angle), rel=1e-12)
    push = next(action.force for action in actions if action.body == "a")
    rate = reference.acceleration(q)[0]
    inertia = 0.5 * 1.0 * BIG**2
    assert BIG * float(push @ np.cross(n, along)) + DRIVE == pytest.approx(
        inertia * rate, rel=1e-11
    )


@pytest.mark.parametrize("sides", [(1, 1), (1, -1), (-1, 1), (-1, -1)])
def test_teeth_of_bevel_wheels_touch_where_their_pitch_circles_do(sides: tuple[int, int]) -> None:
    """At p in the plane of both axes; they push across that plane, and apart across p."""
    slant, angle = 1.1, 0.35
    c, s = np.cos(slant), np.sin(slant)
    x, y = sides[0] * SMALL, sides[1] * BIG
    a, b = (y + c * x) / s, (x + c * y) / s
    apex = np.array([0.4, -0.7, 0.2])
    line, p = np.array([s, 0, c]), apex + np.array([x, 0, a])
    first, second = (mq.Placement(tuple(apex + at)) for at in (np.array([0, 0, a]), b * line))
    bevel = mq.Gear("mesh", "A", "B", SMALL, other_radius=BIG, pressure_angle=angle)
    mechanism = mq.Mechanism(
        "bevel",
        (mq.Body("ground"), mq.Body("a", mq.ball(1.0, SMALL)), mq.Body("b", mq.ball(2.0, BIG))),
        (
            mq.Revolute("A", "ground", "a", axis=(0, 0, 1), origin=first),
            mq.Revolute("B", "ground", "b", axis=(s, 0, c), origin=second),
        ),
        forces=(mq.JointForce("drive", "A", DRIVE),),
        elements=(bevel,),
        gravity=(0, 0, 0),
    )
    reference = mq.Reference(mechanism)
    actions, total = reference.guide_actions([0.3]), dict.fromkeys("ab", np.zeros(3))
    for action in actions:
        np.testing.assert_allclose(action.point, p, rtol=0, atol=1e-14)
        total[action.body] = total[action.body] + action.force
    np.testing.assert_allclose(total["a"], -total["b"], rtol=0, atol=1e-13)
    rate = reference.acceleration([0.3])[0]
    spin = float(mechanism.coordinates.driven["B"].subs({"A": 1.0})) * rate
    ray = p - apex
    pushed = float(np.cross(ray - b * line, total["b"]) @ line)
    assert pushed == pytest.approx(0.4 * 2.0 * BIG**2 * spin, rel=1e-11)
    assert total["b"] @ ray == pytest.approx(0, abs=1e-14)
    (force,) = reference.guide_forces([0.3]).values()
    for axle, body in (("A", "a"), ("B", "b")):  # each bears what its wheel is pushed with
        borne = reference.reactions([0.3])[axle].force
        np.testing.assert_allclose(borne, -total[body], rtol=0, atol=1e-12)
    away = b * line - (b * line @ ray) / (ray @ ray) * ray
    parting = total["b"] @ away / np.linalg.norm(away)
    assert parting == pytest.approx(abs(force) * np.sin(angle), rel=1e-12)


def test_forces_of_a_train_of_gears_belong_to_their_meshes() -> None:
    """Each moves the wheels behind it: F cos(angle) = a (sum of m)/2, a at the pitch circles."""
    radii, masses = (0.3, 0.1, 0.2, 0.15), (4.0, 1.0, 3.0, 2.0)
    centers = np.cumsum([0.0, *(r + R for r, R in pairwise(radii))])
    wheels = [
        mq.Body(f"w{k}", mq.disk(m, r)) for k, (m, r) in enumerate(zip(masses, radii, strict=True))
    ]
    axles = [
        mq.Revolute(f"A{k}", "ground", f"w{k}", axis=(0, 0, 1), origin=mq.Placement((x, 0, 0)))
        for k, x in enumerate(centers)
    ]
    meshes = [
        mq.Gear(f"mesh{k}", f"A{k}", f"A{k + 1}", radius=radii[k], other_radius=radii[k + 1])
        for k in range(3)
    ]
    train = mq.Mechanism(
        "train",
        (mq.Body("ground"), *wheels),
        tuple(axles),
        forces=(mq.JointForce("drive", "A0", DRIVE),),
        elements=tuple(meshes),
    )
    rate = DRIVE / radii[0] / (sum(masses) / 2)
    reference = mq.Reference(train)
    forces = reference.guide_forces([0.3])
    for k in range(3):
        expected = rate * sum(masses[k + 1 :]) / 2 / np.cos(np.radians(20))
        assert abs(forces[f"mesh{k}"]) == pytest.approx(expected, rel=1e-12, abs=0), k
    for action in reference.guide_actions([0.3]):
        mesh = int(action.name.removeprefix("mesh"))
        assert action.body in (f"w{mesh}", f"w{mesh + 1}")
        assert np.linalg.norm(action.force) == pytest.approx(abs(forces[action.name]), rel=1e-12)


def test_a_massless_rod_pushes_along_itself() -> None:
    """A slider crank whose connecting rod is a distance that the coordinate map keeps."""
    r, l, m = mq.Parameter("r", 0.3, "m"), mq.Parameter("l", 1.0, "m"), mq.Parameter("m", 2.0, "kg")
    phi = mq.coordinate("phi")
    mechanism = mq.Mechanism(
        "rod",
        (
            mq.Body("ground"),
            mq.Body("crank", mq.rod(1.0, r, (1, 0, 0))),
            mq.Body("slider", mq.particle(m)),
        ),
        (
            mq.Revolute("A", "ground", "crank", axis=ACROSS, coordinate="phi"),
            mq.Prismatic("rail", "ground", "slider", axis=(1, 0, 0), coordinate="x"),
        ),
        coordinates=mq.Coordinates(
            ("phi",), {"x": r * cos(phi) + sqrt(l**2 - r**2 * sin(phi) ** 2)}
        ),
        gravity=(0.0, 0.0, 0.0),
        elements=(mq.Loop.distance("rod", "crank", (r, 0, 0), "slider", (0, 0, 0), l),),
        parameters=(r, l, m),
    )
    assert mq.verify(mechanism, samples=4).agrees
    reference, q, v = mq.Reference(mechanism), np.array([0.7]), np.array([2.0])
    reactions = reference.reactions(q, v)
    acceleration = reference.followers(q, v, reference.acceleration(q, v))["x''"]
    along = np.array([np.sqrt(1 - (0.3 * np.sin(0.7)) ** 2), 0, -0.3 * np.sin(0.7)])
    pull = 2.0 * acceleration / along[0] * along
    assert reactions["rail"].force == pytest.approx([0, 0, -pull[2]], abs=1e-12)
    about_pin = np.cross(0.3 * np.array([np.cos(0.7), 0, np.sin(0.7)]), -pull)
    spin = 0.3**2 / 3 * reference.acceleration(q, v)[0]
    assert about_pin @ ACROSS == pytest.approx(spin, rel=1e-12)


@pytest.mark.parametrize(
    "name", [name for name in mq.textbook.names() if mq.textbook.load(name).elements]
)
def test_what_an_element_does_to_a_body_is_done_back_to_it(name: str) -> None:
    """Of each pair of bodies the forces of an element, and their moments about a point, cancel."""
    mechanism = mq.textbook.load(name)
    states = random_states(mechanism, 2, 0)
    for q, v in zip(states.q, states.v, strict=True):
        done: dict[tuple[str, str | None, str], np.ndarray] = {}
        for action in mq.Reference(mechanism).guide_actions(q, v):
            moment = np.cross(action.point, action.force) + action.moment
            effect, key = np.append(action.force, moment), (action.body, action.other, action.name)
            done[key] = done.get(key, np.zeros(6)) + effect
        largest = np.max(np.abs([*done.values()]))
        for (body, other, element), effect in done.items():
            back = done[str(other), body, element]
            np.testing.assert_allclose(effect, -back, rtol=0, atol=1e-11 * largest)


@pytest.mark.parametrize("kind", CLOSED)
def test_forces_of_a_loop_act_along_its_rows_where_it_closes(kind: str) -> None:
    """On b at the origin of its frame, in the axes of a's or along the rod, and back on a."""
    here, there = mq.Placement((0.1, 0.2, 0.3), TILT), mq.Placement((-0.3, 0.1, 0.4), PLACE)
    length = {"length": 0.9} if kind == "distance" else {}
    loop = mq.Loop("tie", kind, "c", here, "b", there, **length)  # type: ignore[arg-type]  # parametrized
    second = mq.Placement((0.7, 0.3, -0.2), (0.3, 0.6, -0.5))
    mechanism = mq.Mechanism(
        "two",
        (mq.Body("ground"), *(mq.Body(name, mq.rod(1.0, 0.4)) for name in "abc")),
        (
            mq.Revolute("A", "ground", "a", axis=(0.6, 0, 0.8), origin=mq.Placement(PLACE, TILT)),
            mq.Fixed("C", "a", "c", origin=mq.Placement(TILT, PLACE)),
            mq.Revolute("B", "ground", "b", axis=(0, 0.8, 0.6), origin=second),
        ),
    )
    reference, q = mq.Reference(mechanism), np.array([0.4, -0.9])
    tree = reference._tree
    held = Elements(replace(mechanism, elements=(loop,)), tree.engine, tree.chart, tree.loads.sites)
    tree.move(q, np.zeros(2), 0.0)
    axes = reference.pose("c", q)[:3, :3] @ Rotation.from_euler("xyz", TILT).as_matrix()
    start, end = (
        (reference.pose(body, q) @ [*frame.xyz, 1.0])[:3]
        for body, frame in (("c", here), ("b", there))
    )
    expected = []
    for k, row in enumerate(CLOSED[kind]):
        rod = (end - start) / np.linalg.norm(end - start)
        along = rod if row == "length" else axes[:, "xyz".index(row[-1])]
        for body, other, sign in (("b", "c", 1.0), ("c", "b", -1.0)):
            parts = np.zeros((2, 3))
            parts[int(row.startswith("r"))] = sign * along
            expected.append((k, body, other, False, [*end, *parts.ravel()]))
    units = held.units()
    assert [(u.force, u.body, u.other, u.pressed) for u in units] == [e[:4] for e in expected]
    found = [[*u.action.point, *u.action.force, *u.action.torque] for u in units]
    np.testing.assert_allclose(found, [e[4] for e in expected], rtol=0, atol=1e-14)


def test_what_nothing_describes_beside_a_belt_leaves_it_its_forces() -> None:
    """A sled and an arm that follow another sled, on the ground of the belt's wheels."""
    over = mq.Pulley("a", BIG), mq.Pulley("b", SMALL)
    belt = mq.Belt("belt", over, preload=PRELOAD, normal=ACROSS, axes="frame")
    drive, x = wheels(belt, second=(0.7, 0.0, 0.2)), mq.coordinate("left")
    held = replace(
        drive,
        bodies=(drive.bodies[0], *(mq.Body(name, mq.rod(2.0, 0.4)) for name in ("c", "d", "e"))),
        joints=(
            mq.Prismatic("left", "ground", "c", axis=(0.6, 0, 0.8)),
            mq.Prismatic("right", "c", "d", axis=(0, 0.6, 0.8)),
            mq.Revolute("arm", "d", "e", axis=ACROSS, origin=mq.Placement((0.1, 0.2, 0.3))),
        ),
        forces=(),
        elements=(),
        coordinates=mq.Coordinates(("left",), {"right": -0.7 * x, "arm": 2.5 * x}),
    )
    both = replace(
        drive,
        bodies=(*drive.bodies, *held.bodies[1:]),
        joints=(*drive.joints, *held.joints),
        coordinates=mq.Coordinates(
            ("A", "left"), {**drive.coordinates.driven, **held.coordinates.driven}
        ),
    )
    alone, beside, together = (mq.Reference(each) for each in (drive, held, both))
    given = {"A": 0.4, "left": 0.3}, {"A": -1.2, "left": 0.9}
    expected = {**alone.reactions([0.4], [-1.2]), **beside.reactions([0.3], [0.9])}
    for name, wrench in together.reactions(*given).items():
        for kind in ("force", "moment"):
            ours, theirs = getattr(wrench, kind), getattr(expected[name], kind)
            np.testing.assert_allclose(ours, theirs, rtol=1e-11, atol=1e-11)
        assert wrench.undetermined == expected[name].undetermined
    assert together.reactions(*given)["right"].undetermined
    tensions = alone.guide_forces([0.4], [-1.2])
    for name, tension in together.guide_forces(*given).items():
        assert tension == pytest.approx(tensions[name], rel=1e-12)


@pytest.mark.parametrize("size", [1e-6, 1.0, 1e6])
def test_what_belts_share_is_undetermined_at_any_size(size: float) -> None:
    """One belt pulls by its preload and the torque it hands on, 2/0.1 of which 4/5 turn the drum.

    Two side by side share that in a ratio that nothing says, but together pull on the axles alike.
    """
    bodies = (
        mq.Body("ground"),
        mq.Body("motor", mq.disk(1.0, 0.1 * size)),
        mq.Body("drum", mq.disk(4.0, 0.3 * size)),
    )
    hinges = (
        mq.Revolute("shaft", "ground", "motor"),
        mq.Revolute("axle", "ground", "drum", origin=mq.Placement((size, 0, 0))),
    )
    belts = tuple(
        mq.Belt(
            name,
            (mq.Pulley("motor", 0.1 * size), mq.Pulley("drum", 0.3 * size)),
            40.0 * size,
            (0.0, 0.0, 1.0),
        )
        for name in ("one", "two")
    )
    drive = mq.JointForce("torque", "shaft", 2.0 * size**2)
    single, double = (
        mq.Reference(mq.Mechanism("drive", bodies, hinges, forces=(drive,), elements=belts[:count]))
        for count in (1, 2)
    )
    q = np.zeros(single.mechanism.nq)
    v = np.zeros(single.mechanism.nv)
    # of 2 size² N·m, 5 kg r²/2 = 0.025 size² kg·m² take part at the motor's radius
    assert single.acceleration(q, v).tolist() == pytest.approx([80.0], rel=1e-12)
    assert double.acceleration(q, v).tolist() == pytest.approx([80.0], rel=1e-12)
    tensions = single.guide_forces(q, v)
    assert sum(tensions.values()) == pytest.approx(80.0 * size, rel=1e-12)
    assert tensions["one_2"] - tensions["one_1"] == pytest.approx(16.0 * size, rel=1e-12)
    assert np.isnan([*double.guide_forces(q, v).values()]).all()
    for name, factor in (("shaft", 1.0), ("axle", -1.0)):
        pull = factor * 80.0 * size * np.sqrt(1 - 0.2**2)
        force = single.reactions(q, v)[name].force
        assert force[0] == pytest.approx(-pull, rel=1e-12)
        both = double.reactions(q, v)[name]
        assert both.force[0] == pytest.approx(-2 * pull, rel=1e-12)
        assert both.force[1] == pytest.approx(force[1], rel=1e-9)
