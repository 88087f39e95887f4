"""Writing URDF: what stands in the text, exactly, and what hostile input cannot do to it."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import mecanique as mq
from mecanique.errors import InputError, UrdfError
from mecanique.model import (
    Body,
    Box,
    Coordinates,
    Cylinder,
    Damper,
    Fixed,
    Floating,
    Force,
    Input,
    JointDamper,
    JointForce,
    JointSpring,
    Limits,
    Loop,
    Mechanism,
    Mesh,
    Parameter,
    Placement,
    Planar,
    Prismatic,
    Revolute,
    Shape,
    Spherical,
    Spring,
    Torque,
    Universal,
    Visual,
    ball,
    box,
    coordinate,
    massless,
    rod,
    time,
)
from mecanique.model.joints import Joint
from mecanique.model.placement import rpy_rotation
from mecanique.textbook import load, names
from mecanique.urdf import write_urdf
from mecanique.urdf.dialect import EXTENSIONS, SPRING_DAMPER
from mecanique.urdf.write import chains

DRAKE = "{http://drake.mit.edu}"
FILES = Path(__file__).parents[2] / "urdf"


def parsed(text: str) -> ET.Element:
    return ET.fromstring(text, parser=ET.XMLParser(target=ET.TreeBuilder(insert_comments=True)))


def attributes(element: ET.Element | None) -> dict[str, str]:
    assert element is not None
    return dict(element.attrib)


def numbers(element: ET.Element | None, attribute: str) -> list[float]:
    return [float(word) for word in attributes(element)[attribute].split()]


def matrix(rpy: Sequence[float]) -> npt.NDArray[np.float64]:
    return np.array(rpy_rotation(rpy))


def mechanism(*joints: Joint, **fields: object) -> Mechanism:
    """A chain of balls on the given joints."""
    bodies = [Body("ground"), *(Body(joint.child, ball(2.0, 0.1)) for joint in joints)]
    return Mechanism("machine", bodies=tuple(bodies), joints=joints, **fields)  # type: ignore[arg-type]  # any field


def comments(root: ET.Element) -> str:
    return "\n".join(str(node.text) for node in root.iter() if not isinstance(node.tag, str))


EVERYONE = (*names(), *names(corners=True))


@pytest.mark.parametrize("name", EVERYONE)
def test_the_file_of_every_system_is_what_the_writer_gives(name: str) -> None:
    path = FILES / f"{name}.urdf"
    assert path.exists(), "run: python urdf/regenerate.py"
    assert path.read_text(encoding="utf-8") == write_urdf(load(name)), (
        "run: python urdf/regenerate.py"
    )


def test_no_file_is_left_of_a_system_that_is_gone() -> None:
    assert {path.stem for path in FILES.glob("*.urdf")} == set(EVERYONE)


@pytest.mark.parametrize("name", names())
def test_every_inertia_is_read_back_exactly(name: str) -> None:
    system = load(name)
    root = parsed(write_urdf(system))
    for body in system.bodies:
        (link,) = (element for element in root.iter("link") if element.get("name") == body.name)
        inertial = link.find("inertial")
        mass = system.evaluate(body.mass)
        if inertial is None:
            assert mass == 0
            continue
        assert numbers(inertial.find("mass"), "value") == [mass]
        assert numbers(inertial.find("origin"), "xyz") == [system.evaluate(c) for c in body.center]
        assert numbers(inertial.find("origin"), "rpy") == [0, 0, 0]
        for key, entry in zip(
            ("ixx", "iyy", "izz", "ixy", "ixz", "iyz"), body.inertia, strict=True
        ):
            assert numbers(inertial.find("inertia"), key) == [system.evaluate(entry)]


def test_the_text_is_the_same_each_time_and_ends_with_a_newline() -> None:
    text = write_urdf(load("two_blocks"))
    assert text == write_urdf(load("two_blocks"))
    assert text.endswith("</robot>\n")
    assert text.startswith(
        '<?xml version="1.0"?>\n<robot name="two_blocks" xmlns:drake="http://drake.mit.edu">\n'
    )


def test_the_ground_is_welded_to_the_world_for_drake() -> None:
    root = parsed(write_urdf(load("rigid_bar_pendulum")))
    (weld,) = (joint for joint in root.iter("joint") if joint.get("type") == "fixed")
    assert [end.get("link") for end in weld] == ["world", "ground"]
    own = Mechanism(
        "own",
        bodies=(Body("world"), Body("b", ball(1, 0.1))),
        joints=(Revolute("j", "world", "b"),),
        ground="world",
    )
    assert [joint.get("name") for joint in parsed(write_urdf(own)).iter("joint")] == ["j"]


def test_springs_on_a_ground_named_world_end_at_a_link_welded_to_it() -> None:
    system = Mechanism(
        "own",
        bodies=(Body("world"), Body("b", ball(1, 0.1))),
        joints=(Prismatic("j", "world", "b"),),
        forces=(
            Spring("s", "world", (0, 0, 1), "b", (0, 0, 0), 2.0, 0.5),
            JointSpring("k", "j", 3.0),
        ),
        ground="world",
    )
    root = parsed(write_urdf(system))
    (weld,) = (joint for joint in root.iter("joint") if joint.get("type") == "fixed")
    assert [end.get("link") for end in weld] == ["world", "world_anchor"]
    assert attributes(root.find(f".//{DRAKE}linear_spring_damper_body_A")) == {
        "name": "world_anchor"
    }
    assert [frame.get("link") for frame in root.findall("frame")] == ["world_anchor", "b"]


def test_a_hinge_without_bounds_is_continuous_and_one_with_bounds_has_all_four_limits() -> None:
    bounded = Limits(lower=-1.5, upper=math.inf, effort=7.25)
    root = parsed(
        write_urdf(
            mechanism(
                Revolute("free", "ground", "a"),
                Revolute("bounded", "a", "b", limits=bounded),
                Revolute("weak", "b", "c", limits=Limits(effort=2.0)),
                Prismatic("slide", "c", "d"),
            )
        )
    )
    joints = {joint.get("name"): joint for joint in root.iter("joint")}
    assert joints["free"].get("type") == joints["weak"].get("type") == "continuous"
    assert joints["free"].find("limit") is None
    expected = {
        "bounded": {"lower": -1.5, "upper": 1e9, "effort": 7.25, "velocity": 1e9},
        "weak": {"effort": 2.0, "velocity": 1e9},
        "slide": {"lower": -1e9, "upper": 1e9, "effort": 1e9, "velocity": 1e9},
    }
    for name, limits in expected.items():
        element = joints[name].find("limit")
        assert element is not None
        assert {key: float(value) for key, value in element.attrib.items()} == limits
    assert joints["bounded"].get("type") == "revolute"


def test_a_spring_between_points_has_every_tag_drake_demands() -> None:
    root = parsed(write_urdf(load("two_blocks")))
    springs = root.findall(f"{DRAKE}linear_spring_damper")
    assert len(springs) == 2
    second = springs[1]
    assert [child.tag.replace(DRAKE, "drake:") for child in second] == [
        c.tag for c in SPRING_DAMPER.children.values()
    ]
    content = {
        child.tag.removeprefix(DRAKE + "linear_spring_damper_"): dict(child.attrib)
        for child in second
    }
    assert content == {
        "body_A": {"name": "block1"},
        "p_AP": {"value": "0 0 0"},
        "body_B": {"name": "block2"},
        "p_BQ": {"value": "0 0 0"},
        "free_length": {"value": "1"},
        "stiffness": {"value": "20"},
        "damping": {"value": "0"},
    }


def test_a_damper_is_a_spring_without_stiffness_and_a_spring_without_length_is_a_comment() -> None:
    forces = (
        Damper("shock", "ground", (0, 0, 0), "a", (0.1, 0, 0), 3.5),
        Spring("zero", "ground", (0, 0, 1), "a", (0, 0, 0), 8.25),
    )
    root = parsed(write_urdf(mechanism(Prismatic("slide", "ground", "a"), forces=forces)))
    (damper,) = root.findall(f"{DRAKE}linear_spring_damper")
    assert attributes(damper.find(f"{DRAKE}linear_spring_damper_damping")) == {"value": "3.5"}
    assert attributes(damper.find(f"{DRAKE}linear_spring_damper_stiffness")) == {"value": "0"}
    assert "spring zero: 8.25 N/m, free length 0, from ground (0 0 1) to a (0 0 0)" in comments(
        root
    )


def test_dampers_in_a_joint_add_up_and_the_armature_becomes_a_rotor() -> None:
    forces = (JointDamper("one", "slide", 0.25), JointDamper("two", "slide", 0.5))
    root = parsed(
        write_urdf(mechanism(Prismatic("slide", "ground", "a", armature=0.125), forces=forces))
    )
    (slide,) = (joint for joint in root.findall("joint") if joint.get("name") == "slide")
    assert numbers(slide.find("dynamics"), "damping") == [0.75]
    (transmission,) = root.findall("transmission")
    actuator = transmission.find("actuator")
    assert actuator is not None
    assert numbers(actuator.find(f"{DRAKE}rotor_inertia"), "value") == [0.125]
    assert numbers(actuator.find(f"{DRAKE}gear_ratio"), "value") == [1]
    assert transmission.findtext("type") == "transmission_interface/SimpleTransmission"


@pytest.mark.parametrize("axis", [(1, 0, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1), (1, 2, -2)])
@pytest.mark.parametrize("kind", [Revolute, Prismatic])
def test_a_spring_in_a_joint_is_a_bushing_along_its_axis(
    kind: type[Revolute | Prismatic], axis: tuple[float, float, float]
) -> None:
    """Frame A at the reference, frame C on the child: they coincide at the reference."""
    joint = kind("j", "ground", "a", axis=axis, origin=Placement((1, 2, 3), (0.1, 0.2, 0.3)))
    root = parsed(
        write_urdf(mechanism(joint, forces=(JointSpring("s", "j", 12.5, reference=0.4),)))
    )
    frames = {frame.get("name"): frame for frame in root.findall("frame")}
    assert [frames[f"s_frame_{letter}"].get("link") for letter in "AC"] == ["ground", "a"]
    (bushing,) = root.findall(f"{DRAKE}linear_bushing_rpy")
    stiff, soft = ("torque", "force") if kind is Revolute else ("force", "torque")
    assert attributes(bushing.find(f"{DRAKE}bushing_{stiff}_stiffness")) == {"value": "12.5 0 0"}
    assert attributes(bushing.find(f"{DRAKE}bushing_{soft}_stiffness")) == {"value": "0 0 0"}

    placed = matrix((0.1, 0.2, 0.3))
    x, y, z = joint.axis
    if kind is Revolute:
        c, s = math.cos(0.4), math.sin(0.4)
        cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
        turn = np.eye(3) + s * cross + (1 - c) * cross @ cross
        origin = np.array([1.0, 2.0, 3.0])
    else:
        turn = np.eye(3)
        origin = np.array([1.0, 2.0, 3.0]) + 0.4 * placed @ joint.axis
    in_a, in_c = (matrix(numbers(frames[f"s_frame_{letter}"], "rpy")) for letter in "AC")
    assert in_a == pytest.approx(placed @ turn @ in_c, abs=1e-15)
    assert in_c[:, 0] == pytest.approx(joint.axis, abs=1e-15)
    assert numbers(frames["s_frame_A"], "xyz") == pytest.approx(origin, abs=1e-15)


def test_a_planar_joint_is_two_slides_and_a_hinge_in_the_planes_axes() -> None:
    planar = Planar("p", "ground", "a", axis=(0, -1, 0), origin=Placement((1, 0, 0)))
    root = parsed(write_urdf(mechanism(planar)))
    chain = [joint for joint in root.iter("joint") if joint.get("type") != "fixed"]
    assert [joint.get("type") for joint in chain] == ["prismatic", "prismatic", "continuous"]
    assert [numbers(joint.find("axis"), "xyz") for joint in chain] == [
        [1, 0, 0],
        [0, 0, 1],
        [0, -1, 0],
    ]
    assert [
        numbers(joint.find("origin"), "xyz") if joint.find("origin") is not None else None
        for joint in chain
    ] == [
        [1, 0, 0],
        None,
        None,
    ]
    assert chain[-1].get("name") == "p"
    links = [link.get("name") for link in root.iter("link")]
    assert len(links) == len(set(links)) == 5


def test_a_universal_joint_is_two_hinges_and_its_new_names_are_nobodys() -> None:
    first = Universal("u", "ground", "a")
    second = Revolute("u_x", "a", "a_x")
    root = parsed(write_urdf(mechanism(first, second)))
    joints = [joint.get("name") for joint in root.iter("joint")]
    links = [link.get("name") for link in root.iter("link")]
    assert len(joints) == len(set(joints)) == 4
    assert len(links) == len(set(links)) == 5
    assert {joint.get("type") for joint in root.iter("joint")} == {"fixed", "continuous"}


def test_a_ball_joint_is_drakes_own_or_floating_on_request() -> None:
    system = mechanism(Spherical("s", "ground", "a"), Floating("f", "ground", "b"))
    (exact,) = parsed(write_urdf(system)).findall(f"{DRAKE}joint")
    assert exact.get("type") == "ball"
    types = {
        joint.get("name"): joint.get("type")
        for joint in parsed(write_urdf(system, spherical="floating")).iter("joint")
    }
    assert types["s"] == types["f"] == "floating"
    with pytest.raises(InputError, match="expected 'ball' or 'floating'"):
        write_urdf(system, spherical="hinge")  # type: ignore[arg-type]  # that is the point


def test_one_joint_that_follows_another_linearly_gets_a_mimic() -> None:
    k = Parameter("k", 2.5)
    joints = (
        Revolute("a", "ground", "A"),
        Revolute("b", "A", "B"),
        Revolute("c", "B", "C"),
        Prismatic("d", "C", "D"),
    )
    a = coordinate("a")
    system = mechanism(
        *joints,
        parameters=(k,),
        coordinates=Coordinates(("a", "c"), {"b": k * a / 2 + 1, "d": a * coordinate("c")}),
    )
    text = write_urdf(system)
    mimics = {joint.get("name"): joint.find("mimic") for joint in parsed(text).iter("joint")}
    assert mimics["b"] is not None
    assert mimics["b"].attrib == {"joint": "a", "multiplier": "1.25", "offset": "1"}
    assert mimics["a"] is mimics["c"] is mimics["d"] is None
    assert "d = a*c" in text


@pytest.mark.parametrize(
    "expression", [time(), 0.5, coordinate("q") - coordinate("a"), coordinate("a") ** 2]
)
def test_other_maps_are_comments(expression: object) -> None:
    joints = (Revolute("a", "ground", "A"), Revolute("b", "A", "B"))
    names = ("a", "q") if "q" in str(expression) else ("a",)
    text = write_urdf(mechanism(*joints, coordinates=Coordinates(names, {"b": expression})))
    assert parsed(text).find(".//mimic") is None
    assert f"b = {expression}" in text


def test_absolute_angles_are_told_in_a_comment() -> None:
    text = write_urdf(load("double_pendulum"))
    assert "mimic" not in text
    assert "theta2 = -q1 + q2" in text


def test_loads_and_inputs_are_told_in_comments() -> None:
    F = Input("F", lambda t: t, "N", "push")
    forces = (
        Force("pull", "a", (0, 0, 1), (F, 0, 2.5)),
        Torque("twist", "a", (0, 0, 1.5), axes="a"),
        JointForce("drive", "slide", 4.0),
    )
    told = comments(
        parsed(write_urdf(mechanism(Prismatic("slide", "ground", "a"), forces=forces, inputs=(F,))))
    )
    assert "pull: force (F, 0, 2.5) N on a at (0, 0, 1), axes of world" in told
    assert "twist: torque (0, 0, 1.5) N·m on a, axes of a" in told
    assert "drive: 4 on the child of joint slide" in told
    assert "F = a function of t [N]: push" in told


def test_ball_loops_and_rods_are_constraints_of_drake() -> None:
    loops = (
        Loop.ball("pin", "ground", (0, 0, 1), "a", (1, 0, 0)),
        Loop.distance("rope", "ground", (0, 0, 1), "a", (1, 0, 0), 2.5),
    )
    root = parsed(write_urdf(mechanism(Revolute("j", "ground", "a"), loops=loops)))
    (constraint,) = root.findall(f"{DRAKE}ball_constraint")
    assert [child.attrib for child in constraint] == [
        {"name": "ground"},
        {"value": "0 0 1"},
        {"name": "a"},
        {"value": "1 0 0"},
    ]
    assert "distance loop rope, length 2.5 m" in comments(root)
    (rope,) = root.findall(f"{DRAKE}distance_constraint")
    assert [child.attrib for child in rope][4] == {"value": "2.5"}


def test_visuals_keep_shape_place_and_color() -> None:
    pictures = massless(
        Visual(Box((1, 2, 3)), Placement((0.1, 0, 0), (0, 0.2, 0)), (1, 0, 0, 0.5), "lid"),
        Visual(Cylinder(0.1, 2), rgba=(1, 0, 0, 0.5)),
        Visual(Mesh("package://a & b/<c>.stl", scale=(1, 2, 1))),
    )
    system = Mechanism(
        "m",
        bodies=(Body("ground"), Body("b", pictures, ball(1, 0.1))),
        joints=(Fixed("j", "ground", "b"),),
    )
    root = parsed(write_urdf(system))
    first, second, third, fourth = root.findall(".//visual")
    assert first.get("name") == "lid"
    assert numbers(first.find("origin"), "rpy") == [0, 0.2, 0]
    assert numbers(first.find("geometry/box"), "size") == [1, 2, 3]
    assert numbers(second.find("geometry/cylinder"), "length") == [2]
    assert attributes(third.find("geometry/mesh")) == {
        "filename": "package://a & b/<c>.stl",
        "scale": "1 2 1",
    }
    assert third.find("material") is None
    assert numbers(fourth.find("geometry/sphere"), "radius") == [0.1]
    materials = {
        element.get("name"): numbers(element.find("color"), "rgba")
        for element in root.findall("material")
    }
    used = [attributes(visual.find("material"))["name"] for visual in (first, second, fourth)]
    assert used[0] == used[1] != used[2]
    assert materials[used[0]] == [1, 0, 0, 0.5]


HOSTILE = [
    'a"b',
    "a'b",
    "<a>",
    "--> <joint/> <!--",
    "&amp;",
    "é∂ ü",
    "a--",
    "--",
    "{x}",
    "%s",
    "]]>",
]


@pytest.mark.parametrize("name", HOSTILE)
def test_hostile_names_stay_names(name: str) -> None:
    parameter = Parameter("k", 3.0, meaning=f"{name}\n\x00--{name}")
    system = Mechanism(
        name,
        bodies=(Body("ground"), Body(name, ball(1, 0.1))),
        joints=(Prismatic(name, "ground", name),),
        forces=(
            Spring(name, "ground", (0, 0, 0), name, (0, 0, 0), parameter, 1.0),
            JointSpring(name + "2", name, parameter),
            Force(name + "3", name, (0, 0, 0), (coordinate(name), 0, 0)),
        ),
        loops=(Loop.weld(name, "ground", Placement(), name, Placement()),),
        parameters=(parameter,),
    )
    root = parsed(write_urdf(system))
    assert root.get("name") == name
    assert [link.get("name") for link in root.iter("link")] == ["world", "ground", name]
    assert [joint.get("name") for joint in root.iter("joint")] == ["world_to_ground", name]
    assert attributes(
        root.find(f"{DRAKE}linear_spring_damper/{DRAKE}linear_spring_damper_body_B")
    ) == {"name": name}


@settings(deadline=None)
@given(st.floats(1e-200, 1e200), st.floats(-1e200, 1e200), st.floats(-1e200, 1e200))
def test_numbers_are_read_back_as_they_were(mass: float, x: float, y: float) -> None:
    shape = Shape(mass, (x, y, 0.1 + 0.2), (mass, mass, mass, 0.0, 0.0, 0.0))
    body = Body("b", shape)
    system = Mechanism(
        "m",
        bodies=(Body("ground"), body),
        joints=(Fixed("j", "ground", "b", origin=Placement((y, x, 0))),),
    )
    root = parsed(write_urdf(system))
    inertial = root.find(".//inertial")
    assert inertial is not None
    assert numbers(inertial.find("mass"), "value") == [mass]
    assert numbers(inertial.find("origin"), "xyz") == [x, y, 0.1 + 0.2]
    assert numbers(inertial.find("inertia"), "ixx") == [mass]
    origins = [joint.find("origin") for joint in root.iter("joint") if joint.get("name") == "j"]
    assert (origins[0] is None and x == y == 0) or numbers(origins[0], "xyz") == [y, x, 0]


def test_what_is_not_finite_is_refused_by_name() -> None:
    drawn = massless(Visual(Box((1, 1, 1)), Placement((0, float("nan"), 0))))
    system = Mechanism(
        "m", bodies=(Body("ground"), Body("b", drawn)), joints=(Fixed("j", "ground", "b"),)
    )
    with pytest.raises(UrdfError, match=r"finite number for a visual of body 'b', got nan"):
        write_urdf(system)


def test_a_file_is_written_whole_or_not_at_all(tmp_path: Path) -> None:
    path = tmp_path / "pendulum.urdf"
    path.write_text("old", encoding="utf-8")
    text = write_urdf(load("rigid_bar_pendulum"), path)
    assert path.read_bytes() == text.encode()
    assert list(tmp_path.iterdir()) == [path]
    bad = massless(Visual(Box((1, 1, 1)), Placement((0, float("inf"), 0))))
    system = Mechanism(
        "m", bodies=(Body("ground"), Body("b", bad)), joints=(Fixed("j", "ground", "b"),)
    )
    with pytest.raises(UrdfError):
        write_urdf(system, path)
    assert path.read_bytes() == text.encode()
    with pytest.raises(UrdfError, match=r"nowhere.+cannot be written"):
        write_urdf(load("rigid_bar_pendulum"), tmp_path / "nowhere" / "x.urdf")
    assert list(tmp_path.iterdir()) == [path]


def test_a_folder_in_the_files_place_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "taken.urdf").mkdir()
    with pytest.raises(UrdfError, match="cannot be written"):
        write_urdf(load("rigid_bar_pendulum"), tmp_path / "taken.urdf")
    assert [path.name for path in tmp_path.iterdir()] == ["taken.urdf"]


def test_the_table_of_the_dialect_is_consistent() -> None:
    for tag, extension in EXTENSIONS.items():
        assert tag == extension.tag
        assert tag.startswith("drake:")
        for child in extension.children.values():
            assert child.tag.startswith("drake:")
            assert (child.attribute == "name") == (child.count == 0)


def test_the_last_of_a_chain_bears_the_joints_name_and_child() -> None:
    joints = (
        Planar("p", "ground", "a"),
        Universal("u", "a", "b"),
        Revolute("r", "b", "c"),
        Fixed("x", "c", "d"),
    )
    for joint, chain in zip(joints, chains(mechanism(*joints)).values(), strict=True):
        assert (chain[-1].name, chain[-1].child, chain[0].parent) == (
            joint.name,
            joint.child,
            joint.parent,
        )
        for before, after in pairwise(chain):
            assert after.parent == before.child


def test_bodies_without_mass_have_no_inertial_and_rods_stand_where_they_are() -> None:
    m, l = Parameter("m", 3.0), Parameter("l", 0.7)
    system = Mechanism(
        "m",
        bodies=(
            Body("ground"),
            Body("bare"),
            Body("rod", rod(m, l)),
            Body("brick", box(1, (1, 1, 1))),
        ),
        joints=(
            Fixed("a", "ground", "bare"),
            Revolute("b", "bare", "rod", origin=Placement((0, 0, l / 2), (0, 0, m))),
            Fixed("c", "rod", "brick"),
        ),
        parameters=(m, l),
    )
    root = parsed(write_urdf(system))
    links = {link.get("name"): link for link in root.iter("link")}
    assert links["bare"].find("inertial") is None
    (hinge,) = (joint for joint in root.iter("joint") if joint.get("name") == "b")
    assert numbers(hinge.find("origin"), "xyz") == [0, 0, 0.35]
    assert numbers(hinge.find("origin"), "rpy") == [0, 0, 3]


def test_the_spring_of_a_joint_to_the_world_is_read_back() -> None:
    hinge = mq.Revolute("q", "world", "rod", axis=(0, 0.6, 0.8), origin=mq.Placement((1, 2, 3)))
    spring = mq.JointSpring("spring", "q", 3.0, 0.4)
    bodies = (mq.Body("world"), mq.Body("rod", mq.rod(1.0, 1.0)))
    mechanism = mq.Mechanism("m", bodies, (hinge,), forces=(spring,), ground="world")
    text = mq.write_urdf(mechanism)
    assert 'link="world_anchor"' in text
    (read,) = mq.read_urdf(text).forces
    assert isinstance(read, mq.JointSpring)
    assert (read.joint, read.stiffness) == ("q", 3.0)
    assert read.reference == pytest.approx(0.4, rel=1e-14)
