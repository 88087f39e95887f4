"""Closures of MJCF, files included, what is left out and what is refused."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from pathlib import Path

import mujoco
import numpy as np
import pytest

import mecanique as mq
from mecanique.formats.mjcf import read_mjcf
from mecanique.model.bodies.tensor import tensor_of

ARM = """<body name="{0}" pos="{1}"><joint name="{0}_joint" axis="0 1 0" pos="0 0 0.1"/>
<geom type="capsule" size="0.02" fromto="0 0 0 0 0 -0.5"/>{2}</body>"""


SKEW = '<body pos="1 2 3" euler="10 20 30"><joint axis="1 2 3" pos="0.1 0.2 0.3"/>'


def model(inside: str, rest: str = "") -> str:
    return f'<mujoco model="m"><worldbody>{inside}</worldbody>{rest}</mujoco>'


TWO = ARM.format("a", "0 0 1", "") + ARM.format("b", "0.4 0 1", "")


@pytest.mark.parametrize(
    "closure",
    [
        '<connect body1="a" body2="b" anchor="0.1 0.2 0.3"/>',
        '<connect body1="a" anchor="0.1 0.2 0.3"/>',
        '<weld body1="a" body2="b"/>',
        '<weld body1="a" body2="b" relpose="0.4 0 0 1 0 0 0"/>',
        '<weld body1="a" body2="b" anchor="0.1 0.2 0.3"/>',
        '<weld body1="a" body2="b" anchor="0.1 0 0.3" relpose="0.4 0 0.1 1 0.2 0 0"/>',
        '<connect site1="s" site2="t"/>',
    ],
)
def test_loops_close_where_mujocos_do(closure: str) -> None:
    sites = ('<site name="s" pos="0.2 0 -0.5"/>', '<site name="t" pos="-0.2 0 -0.5"/>')
    text = model(
        ARM.format("a", "0 0 1", sites[0]) + ARM.format("b", "0.4 0 1", sites[1]),
        f"<equality>{closure}</equality>",
    )
    mechanism = read_mjcf(text)
    (loop,) = mechanism.loops
    assert loop.kind == ("weld" if "weld" in closure else "ball")
    engine = mq.Reference(mechanism)
    theirs = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(theirs)
    for q in ([0.0, 0.0], [0.3, -0.2]):
        data.qpos[:] = q
        mujoco.mj_forward(theirs, data)
        poses = [
            engine.pose(body, q) @ _matrix(frame)
            for body, frame in ((loop.body_a, loop.frame_a), (loop.body_b, loop.frame_b))
        ]
        gap = poses[1][:3, 3] - poses[0][:3, 3]
        size = np.linalg.norm(data.efc_pos[:3])
        assert np.linalg.norm(gap) == pytest.approx(size, rel=1e-12, abs=1e-15)


def _matrix(frame: mq.Placement) -> np.ndarray:
    from mecanique.model.placement import pose_of

    return pose_of(frame)


def test_a_joint_follows_another_by_a_polynomial() -> None:
    text = model(
        TWO.replace('name="b_joint"', 'name="b_joint" ref="20"').replace(
            'name="a_joint"', 'name="a_joint" ref="-10"'
        ),
        '<equality><joint joint1="b_joint" joint2="a_joint" polycoef="0.1 2 -0.3 0.2 0.05"/>'
        "</equality>",
    )
    mechanism = read_mjcf(text)
    assert mechanism.nv == 1
    x, x0, y0 = 0.7, np.radians(-10), np.radians(20)
    d = x - x0
    law = y0 + 0.1 + 2 * d - 0.3 * d**2 + 0.2 * d**3 + 0.05 * d**4
    slope = np.array([1.0, 2 - 0.6 * d + 0.6 * d**2 + 0.2 * d**3])
    theirs = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(theirs)
    data.qpos[:] = x, law
    mujoco.mj_forward(theirs, data)
    assert abs(data.efc_pos[0]) < 1e-14
    mass = np.zeros((2, 2))
    for column, unit in zip(mass, np.eye(2), strict=True):
        mujoco.mj_mulM(theirs, data, column, unit)
    found = mq.Reference(mechanism).mass_matrix({"a_joint": x})
    assert found.item() == pytest.approx(slope @ mass @ slope, rel=1e-12)


def test_a_joint_that_follows_meets_the_medium() -> None:
    text = model(
        TWO,
        '<option density="900" viscosity="2"/><equality><joint joint1="b_joint" joint2="a_joint" '
        'polycoef="0.1 2 -0.3"/></equality>',
    )
    mechanism = read_mjcf(text)
    x, rate = 0.7, 0.4
    slope = np.array([1.0, 2 - 0.6 * x])
    theirs = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(theirs)
    data.qpos[:], data.qvel[:] = (x, 0.1 + 2 * x - 0.3 * x**2), slope * rate
    mujoco.mj_forward(theirs, data)
    engines = [mq.Reference(replace(mechanism, forces=f)) for f in (mechanism.forces, ())]
    loaded, bare = (engine.inverse_dynamics([x], [rate], [0]).item() for engine in engines)
    assert bare - loaded == pytest.approx(slope @ data.qfrc_passive, rel=1e-10)


def test_files_are_included_with_their_lines(tmp_path: Path) -> None:
    (tmp_path / "parts").mkdir()
    (tmp_path / "parts" / "arm.xml").write_text(
        f"<mujocoinclude>\n{TWO}\n</mujocoinclude>", encoding="utf-8"
    )
    main = tmp_path / "main.xml"
    main.write_text(model('<include file="parts/arm.xml"/>'), encoding="utf-8")
    assert read_mjcf(main) == read_mjcf(model(TWO))
    (tmp_path / "parts" / "arm.xml").write_text(
        "<mujocoinclude>\n<cat/>\n</mujocoinclude>", encoding="utf-8"
    )
    said = re.escape(f"{tmp_path / 'parts' / 'arm.xml'}:2: <cat> is not read")
    with pytest.raises(mq.InputError, match=said):
        read_mjcf(main)
    main.write_text(model('<include file="main.xml"/>'), encoding="utf-8")
    with pytest.raises(mq.InputError, match="more than 100 files are included"):
        read_mjcf(main)
    main.write_text(model('<include file="no.xml"/>'), encoding="utf-8")
    said = r"main\.xml:1: <include> names .*no\.xml: there is no such file; put it there, or mend"
    with pytest.raises(mq.InputError, match=said):
        read_mjcf(main)


def test_what_is_left_out_is_told() -> None:
    text = model(
        ARM.format("a", "0 0 1", "<camera/>").replace("axis=", 'frictionloss="1" axis='),
        '<actuator><motor joint="a_joint"/></actuator><sensor><clock/><clock/></sensor>'
        '<equality><connect active="false" body1="a" anchor="0 0 0"/></equality>',
    )
    assert read_mjcf(text).about == (
        "Read from MJCF, without actuators (1), cameras and lights (1), contacts of geoms (1), "
        "inactive constraints (1), sensors (2), dry friction of a_joint."
    )


BODY = '<body><joint axis="0 1 0"/>{}</body>'


@pytest.mark.parametrize("beside", [True, False])
def test_files_named_in_included_files_stand_beside_the_main_or_the_included_one(
    tmp_path: Path, beside: bool
) -> None:
    parts = tmp_path / "parts"
    parts.mkdir()
    corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 {}\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n"
    (parts / "m.obj").write_text(corners.format(1), encoding="utf-8")
    if beside:
        (tmp_path / "m.obj").write_text(corners.format(2), encoding="utf-8")
    asset = '<mujoco><asset><mesh name="m" file="m.obj"/></asset></mujoco>'
    (parts / "asset.xml").write_text(asset, encoding="utf-8")
    outer = '<mujoco><include file="asset.xml"/></mujoco>'
    (parts / "outer.xml").write_text(outer, encoding="utf-8")
    main = tmp_path / "main.xml"
    geom = '<body><joint/><geom type="mesh" mesh="m"/></body>'
    main.write_text(
        f'<mujoco><include file="parts/outer.xml"/><worldbody>{geom}</worldbody></mujoco>',
        encoding="utf-8",
    )
    theirs = mujoco.MjModel.from_xml_path(str(main))
    mass = 1000 * (2 if beside else 1) / 6
    assert float(theirs.body_mass[1]) == pytest.approx(mass, rel=1e-12)
    assert read_mjcf(main).bodies[1].mass == pytest.approx(mass, rel=1e-12)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("<sdf/>", "line 1: expected <mujoco> as the outermost element, not <sdf>"),
        ("<mujoco><deformable/></mujoco>", "<deformable> is not read"),
        (model("<composite/>"), "<composite> is not read"),
        (model('<replicate count="0"/>'), "expected a count of copies, got '0'"),
        (model('<replicate count="1e6"><body/></replicate>'), "more than 100,000 elements"),
        (model(BODY.format('<geom mesh="a"/>')), "there is no mesh 'a' among the assets"),
        (model(BODY.format('<geom type="sdf"/>')), "the inertia of a geom of type 'sdf'"),
        (model(BODY.format('<geom size="1" cohesion="1"/>')), "cohesion=… of <geom> is not read"),
        (model(BODY.format('<geom size="-1"/>')), "expected 1 positive sizes of a sphere"),
        (model(BODY.format('<geom size="1" mass="-1"/>')), "no negative mass or density of <geom>"),
        (
            model(BODY.format('<geom size="1" density="-1"/>')),
            "no negative mass or density of <geo",
        ),
        (model(BODY.format('<geom size="1" fromto="0 0 0 0 0 1"/>')), "a sphere has no fromto"),
        (
            model(BODY.format('<geom type="plane" size="1 1 1"/>')),
            "a geom of type 'plane' expects a body that does not move",
        ),
        (model(BODY.format('<inertial pos="0 0 0" mass="-1"/>')), "no negative mass of <inertial>"),
        (
            model(BODY.format(2 * '<inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>')),
            "expected one <inertial> in a body",
        ),
        (
            model(
                BODY.format(
                    '<inertial pos="0 0 0" mass="1" quat="1 0 0 1" fullinertia="1 1 1 0 0 0"/>'
                )
            ),
            "expected fullinertia without quat",
        ),
        (model("<joint/>"), "the world has no <joint>"),
        (model(2 * '<body name="a"/>'), "another body is named 'a', too"),
        (model(2 * '<body><joint name="a"/></body>'), "another joint is named 'a', too"),
        (model('<body mocap="true"><joint/></body>'), "a mocap body expects the world around it"),
        (
            model('<body><joint type="ball"/><joint type="slide"/><joint/></body>'),
            "after a ball joint, a body's other joints expect to slide",
        ),
        (model(f"<body>{7 * '<joint/>'}</body>"), "the joints of a body expect 6 velocities at"),
        (model('<body><joint springdamper="0 1"/></body>'), "positive numbers for springdamper"),
        (model('<body><joint range="2 1" limited="true"/></body>'), "limited is true, so range"),
        (
            model('<body><joint range="1 2"/></body>', '<compiler autolimits="false"/>'),
            "autolimits is false, so range expects limited beside it",
        ),
        (model(BODY.format('<geom size="x"/>')), "expected 3 finite numbers for size of <geom>"),
        (model(BODY.format('<geom size="1" magic="1"/>')), "magic=… of <geom> is not read"),
        (model(BODY.format('<geom size="1" class="no"/>')), "no class of defaults 'no'"),
        (model(BODY.format('<geom size="1" euler="0 0 0" quat="1 0 0 0"/>')), "one orientation"),
        (model(BODY.format('<inertial pos="0 0 0"/>')), "<inertial> has no mass"),
        (model('<body><joint type="screw"/></body>'), "of type hinge, slide, ball or free"),
        (model('<body><joint stiffness="1 2 3 4"/></body>'), "expected 3 finite numbers for"),
        (
            model('<body><joint type="ball" springdamper="1 1"/></body>'),
            "springdamper of a ball joint",
        ),
        (model("<body><body><freejoint/></body></body>"), "expects a body of the world"),
        (
            model(5 * SKEW + 5 * "</body>", '<option density="1"/>'),
            "line 1: forces of a medium on 'body_4', over so many joints, are not read",
        ),
        (
            model(f'{5 * SKEW}<site name="s"/>{5 * "</body>"}<site name="w"/>').replace(
                "</mujoco>",
                '<tendon><spatial name="rope" armature="1"><site site="w"/><site site="s"/>'
                "</spatial></tendon></mujoco>",
            ),
            "line 1: armature, branches and powers of tendon 'rope', over so many joints, are not",
        ),
        (
            model(
                '<body><freejoint/><geom size="1" fluidshape="ellipsoid"/></body>',
                '<option density="1"/>',
            ),
            "fluidshape=… of <geom> is not read",
        ),
        (model("", '<compiler coordinate="global"/>'), "coordinate of <compiler> is not read"),
        (model("", '<default class="a"/>'), "expected 'main' for the outermost class"),
        (model("", "<default><default/></default>"), "inside another needs a name"),
        (
            model("", '<tendon><spatial armature="2"><geom geom="a"/></spatial></tendon>'),
            "a tendon around a <geom> is not read",
        ),
        (
            model("", '<tendon><spatial damping="2"><site site="a"/></spatial></tendon>'),
            "<spatial> names a site that is not there",
        ),
        (model("", '<tendon><fixed class="a"/></tendon>'), "there is no class of defaults 'a'"),
        (model("", '<tendon><fixed><joint joint="a"/></fixed></tendon>'), "'a' is no hinge or"),
        (model("", '<actuator><motor armature="0.1"/></actuator>'), "armature of <motor> at no"),
        (
            model(
                ARM.format("r", "0 0 1", TWO),
                '<tendon><fixed name="f" armature="1"><joint joint="r_joint" coef="1"/>'
                '<joint joint="a_joint" coef="1"/><joint joint="b_joint" coef="1"/></fixed>'
                "</tendon>",
            ),
            "armature of tendon 'f', of which MuJoCo drops what couples branches, is not read",
        ),
        (
            model(
                ARM.format("a", "0 0 1", '<site name="a"/>')
                + ARM.format("b", "0.4 0 1", '<site name="b"/>'),
                '<tendon><spatial armature="1"><site site="a"/><site site="b"/></spatial></tendon>',
            ),
            "armature of tendon 'tendon', of which MuJoCo drops what couples branches",
        ),
        (
            model(
                ARM.format("a", "0 0 1", ARM.format("b", "0 0 0", ""))
                + '<attach body="b" prefix="x_"/>',
                '<tendon><fixed><joint joint="a_joint" coef="1"/><joint joint="b_joint" coef="1"/>'
                "</fixed></tendon>",
            ),
            "an <attach> is not read where <fixed> of line 3 refers to a part of it alone",
        ),
        (model("", '<equality><tendon tendon1="a"/></equality>'), "'a' is no tendon along joints"),
        (model("", '<equality><flex flex="a"/></equality>'), "<flex> among the constraints"),
        (model("", '<equality><joint joint1="a"/></equality>'), "'a' is no hinge or slide"),
        (
            model(TWO, '<equality><joint joint1="a_joint" joint2="c"/></equality>'),
            "'c' is no hinge or slide",
        ),
        (model("", '<equality><weld body1="a"/></equality>'), "names a body that is not there"),
        (model("", '<equality><weld site1="a"/></equality>'), "names a site that is not there"),
        (
            model('<body>\n<joint axis="1e200 1e200 1e200"/></body>'),
            "line 2: expected 3 finite numbers for axis of <joint> of at most 1e+50",
        ),
        (
            model('<body><geom size="1" mass="-1e308"/></body>'),
            "expected 1 finite number for mass of <geom> of at most 1e+50, got '-1e308'",
        ),
        (
            model("", '<compiler eulerseq="xy"/>'),
            "expected three of xyz or XYZ for eulerseq, got 'xy'",
        ),
        (
            model('<body quat="0 0 0 0"/>'),
            "quat of <body>: expected a direction with a length, got [0.0, 0.0, 0.0, 0.0]",
        ),
        (model('<body>\n<joint axis="0 0 0"/></body>'), "line 2: axis of <joint>: expected a dir"),
        (model('<include file="a.xml"/>'), "expected a file beside this one, got 'a.xml'"),
    ],
)
def test_what_is_not_read_is_refused_by_name(text: str, said: str) -> None:
    with pytest.raises(mq.InputError, match=re.escape(said)):
        read_mjcf(text)


def test_joints_that_follow_in_circles_are_refused() -> None:
    circle = "".join(
        f'<joint joint1="{a}_joint" joint2="{b}_joint"/>' for a, b in (("a", "b"), ("b", "a"))
    )
    with pytest.raises(mq.InputError, match="would follow itself"):
        read_mjcf(model(TWO, f"<equality>{circle}</equality>"))


def test_joints_may_follow_joints_that_follow_others() -> None:
    three = TWO + ARM.format("c", "0.8 0 1", "")
    laws = (
        '<joint joint1="c_joint" joint2="b_joint" polycoef="0.1 2"/>'
        '<joint joint1="b_joint" joint2="a_joint" polycoef="0.2 3"/>'
    )
    driven = read_mjcf(model(three, f"<equality>{laws}</equality>")).coordinates.driven
    angle = float(driven["c_joint"].subs({"a_joint": 0.5}))
    assert angle == pytest.approx(0.1 + 2 * (0.2 + 1.5), rel=1e-14)
    twice = '<joint joint1="a_joint"/><joint joint1="a_joint" joint2="b_joint" polycoef="0 1 2"/>'
    with pytest.raises(mq.InputError, match="'a_joint' is tied by several constraints"):
        read_mjcf(model(TWO, f"<equality>{twice}</equality>"))


def test_what_is_attached_says_where_it_is_wrong(tmp_path: Path) -> None:
    rows = '<weld name="e1" body1="b" body2="a"/><weld name="e2" body1="b"/>'
    limb = model(TWO, f'<equality>{rows}</equality><option gravity="0 0 -1"/>')
    (tmp_path / "limb.xml").write_text(limb, encoding="utf-8")
    main = tmp_path / "main.xml"

    def attach(inside: str) -> mq.Mechanism:
        asset = '<asset><model file="limb.xml" name="limb"/></asset>'
        main.write_text(f"<mujoco>{asset}<worldbody>\n{inside}</worldbody></mujoco>", "utf-8")
        return read_mjcf(main)

    alone = attach('<attach model="limb" body="b" prefix="x_"/>')
    assert [loop.name for loop in alone.loops] == ["x_e2"]
    assert alone.gravity == (0.0, 0.0, -9.81)
    assert "options of attached models (1)" in alone.about
    cases = {
        '<attach model="limb"/>': "<attach> has no prefix",
        '<attach model="leg" prefix=""/>': "the models among the assets, 'limb'; got 'leg'",
        '<attach model="limb" body="c" prefix=""/>': "model 'limb' has no body 'c'",
        '<replicate count="0"><attach model="limb" prefix=""/></replicate>': "a count of copies",
    }
    for inside, message in cases.items():
        with pytest.raises(mq.InputError, match=rf"main\.xml:2: .*{re.escape(message)}"):
            attach(inside)


def test_of_several_ties_of_a_joint_linear_ones_are_turned_round() -> None:
    rows = (
        '<joint joint1="a_joint" joint2="c_joint" polycoef="0.1 2 3"/>'
        '<joint joint1="a_joint" joint2="b_joint" polycoef="0.4 -2"/>'
    )
    arm = ARM.replace("axis=", 'ref="20" axis=')
    three = TWO + arm.format("c", "0.8 0 1", "")
    text = model(three, f"<equality>{rows}</equality>")
    driven, x = read_mjcf(text).coordinates.driven, 0.3
    data = mujoco.MjData(theirs := mujoco.MjModel.from_xml_string(text))
    for joint, law in {"c_joint": x, **driven}.items():
        value = x if joint == "c_joint" else law.subs({"c_joint": x})
        data.qpos[theirs.joint(joint).qposadr[0]] = float(value)
    mujoco.mj_forward(theirs, data)
    assert [*driven] == ["a_joint", "b_joint"]
    assert np.abs(data.efc_pos).max() < 1e-14


def test_a_tendon_ties_two_joints() -> None:
    text = model(
        TWO,
        '<tendon><fixed name="t"><joint joint="a_joint" coef="0.5"/><joint joint="b_joint" '
        'coef="-2"/></fixed></tendon><equality><tendon tendon1="t" polycoef="0.3"/></equality>',
    )
    mechanism = read_mjcf(text)
    assert mechanism.nv == 1
    theirs = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(theirs)
    x = 0.7
    law = mechanism.coordinates.driven["b_joint"]
    data.qpos[:] = x, float(law.subs({"a_joint": x}))
    mujoco.mj_forward(theirs, data)
    assert data.qpos[1] == pytest.approx((0.3 - 0.5 * x) / -2, rel=1e-15)
    assert abs(data.efc_pos[0]) < 1e-15


def test_the_spring_of_a_tendon_pulls_in_coordinates_that_are_free() -> None:
    text = model(
        TWO,
        '<tendon><fixed stiffness="2" damping="3"><joint joint="a_joint" coef="1"/>'
        '<joint joint="b_joint" coef="1"/></fixed></tendon><equality><joint joint1="b_joint" '
        'joint2="a_joint" polycoef="0 2"/></equality>',
    )
    mechanism = read_mjcf(text)
    bare = mq.Reference(replace(mechanism, forces=()))
    tau = bare.inverse_dynamics([0.3], [0.2], [0]) - mq.Reference(mechanism).inverse_dynamics(
        [0.3], [0.2], [0]
    )
    # length q + 2 q = 3 q, so both constants count 9 times
    assert tau == pytest.approx([-9 * (2 * 0.3 + 3 * 0.2)], rel=1e-12)


@pytest.mark.parametrize("form", ["stl", "obj", "msh"])
def test_meshes_of_files_weigh_what_mujocos_weigh(form: str, tmp_path: Path) -> None:
    points = np.array([[0, 0, 0], [1, 0, 0.1], [0, 0.7, 0], [0.1, 0.2, 0.9]], dtype="<f4")
    faces = np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]], dtype="<i4")
    data = b""
    if form == "stl":
        head = bytes(80) + len(faces).to_bytes(4, "little")
        facets = [bytes(12) + points[face].tobytes() + bytes(2) for face in faces]
        data = head + b"".join(facets)
    elif form == "obj":
        lines = [f"v {x} {y} {z}" for x, y, z in points.tolist()]
        lines += [f"f {a + 1} {b + 1} {c + 1}" for a, b, c in faces.tolist()]
        data = "\n".join([*lines, "o second", "f 1 2 3"]).encode()
    else:
        head = np.array([4, 0, 0, 4], dtype="<i4").tobytes()
        data = head + points.tobytes() + faces.tobytes()
    (tmp_path / "assets").mkdir()
    (tmp_path / "assets" / f"part.{form}").write_bytes(data)
    text = (
        '<mujoco><compiler meshdir="assets"/><asset>'
        f'<mesh file="part.{form}" scale="2 1 1"/></asset>'
        '<worldbody><body><joint axis="0 1 0"/><geom type="mesh" mesh="part"/></body></worldbody>'
        "</mujoco>"
    )
    file = tmp_path / "robot.xml"
    file.write_text(text, encoding="utf-8")
    body = read_mjcf(file).bodies[1]
    theirs = mujoco.MjModel.from_xml_path(str(file))
    assert body.mass == pytest.approx(theirs.body_mass[1], rel=1e-12)
    assert body.center == pytest.approx(theirs.body_ipos[1].tolist(), rel=1e-12)
    moments = np.linalg.eigvalsh(tensor_of([float(entry) for entry in body.inertia]))
    assert sorted(moments) == pytest.approx(sorted(theirs.body_inertia[1]), rel=1e-9)


def bowl(corners: list[tuple[float, float]]) -> str:
    """An OBJ text of a pyramid over a polygon, whose points stand aslant."""
    turn = np.array([[0.6, 0.8, 0.0], [-0.8, 0.6, 0.0], [0.0, 0.0, 1.0]])[[1, 2, 0]]
    points = np.array([*((x, y, 0.1 * x) for x, y in corners), (0.1, 0.2, 0.5)]) @ turn
    count = len(corners)
    lines = [f"v {x:.5f} {y:.5f} {z:.5f}" for x, y, z in points.tolist()]
    lines.append("f " + " ".join(str(k) for k in range(count, 0, -1)))
    lines += [f"f {k + 1} {(k + 1) % count + 1} {count + 1}" for k in range(count)]
    return "\n".join(lines)


@pytest.mark.parametrize("rule", ["legacy", "exact", "shell"])
@pytest.mark.parametrize(
    ("name", "corners"),
    [
        ("five", [(0.9, 0.0), (0.2, 0.8), (-0.8, 0.5), (-0.7, -0.6), (0.3, -0.9)]),
        ("ell", [(0, 0), (0.4, 0), (0.4, 0.1), (0.1, 0.1), (0.1, 0.5), (0, 0.5)]),
        ("star", [(1.0, 0), (0.2, 0.3), (0, 1.0), (-0.3, 0.2), (-1.0, 0), (-0.2, -0.3), (0, -1.0)]),
        ("edge", [(0, 0), (0.5, 0), (1, 0), (1, 0.5), (1, 1), (0, 1), (0, 0.5)]),
        ("last", [(0.6, -0.2), (0.2, 0.1), (0.3, -1.2), (1.0, -0.5), (1.6, -0.6)]),
        ("round", [(math.cos(k / 17), math.sin(k / 17)) for k in range(101)]),
    ],
)
def test_faces_of_many_corners_are_cut_as_mujoco_cuts_them(
    name: str, corners: list[tuple[float, float]], rule: str, tmp_path: Path
) -> None:
    (tmp_path / f"{name}.obj").write_text(bowl(corners), encoding="utf-8")
    mesh = f'<mujoco><asset><mesh name="a" file="{name}.obj" inertia="{rule}"/></asset>'
    file = tmp_path / "robot.xml"
    file.write_text(f"{mesh}<worldbody>{PART}</worldbody></mujoco>", encoding="utf-8")
    body = read_mjcf(file).bodies[1]
    theirs = mujoco.MjModel.from_xml_path(str(file))
    assert body.mass == pytest.approx(theirs.body_mass[1], rel=1e-12)
    moments = np.linalg.eigvalsh(tensor_of([float(entry) for entry in body.inertia]))
    assert sorted(moments) == pytest.approx(sorted(theirs.body_inertia[1]), rel=1e-9)


def test_meshes_keep_the_products_of_inertia_that_mujoco_leaves(tmp_path: Path) -> None:
    random = np.random.default_rng(5)
    file = tmp_path / "robot.xml"
    for _ in range(30):
        corners = " ".join(f"{x:.3f}" for x in random.uniform(-1, 1, 12))
        file.write_text(MESH.format(f'vertex="{corners}"', PART), encoding="utf-8")
        ours = tensor_of([float(entry) for entry in read_mjcf(file).bodies[1].inertia])
        theirs = mujoco.MjModel.from_xml_path(str(file))
        flat = np.zeros(9)
        mujoco.mju_quat2Mat(flat, theirs.body_iquat[1])
        axes = flat.reshape(3, 3)
        tensor = axes @ np.diag(theirs.body_inertia[1]) @ axes.T
        assert ours == pytest.approx(tensor, rel=0, abs=1e-11 * np.trace(tensor))


def test_faces_whose_points_are_not_there_are_refused(tmp_path: Path) -> None:
    mesh = '<mujoco><asset><mesh name="a" file="{}.obj"/></asset>'
    file = tmp_path / "robot.xml"
    for name, face in (("two", "1 2"), ("far", "1 2 3 9")):
        (tmp_path / f"{name}.obj").write_text(
            "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf " + face, encoding="utf-8"
        )
        file.write_text(f"{mesh.format(name)}<worldbody>{PART}</worldbody></mujoco>", "utf-8")
        with pytest.raises(mq.InputError, match="expected faces of 3 points or more"):
            read_mjcf(file)


def test_files_with_too_many_corners_to_cut_are_refused(tmp_path: Path) -> None:
    face = "\nf" + " 1 2 3 4" * 25
    points = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1"
    (tmp_path / "m.obj").write_text(points + 501 * face, encoding="utf-8")
    file = tmp_path / "robot.xml"
    asset = '<mujoco><asset><mesh name="a" file="m.obj"/></asset>'
    file.write_text(f"{asset}<worldbody>{PART}</worldbody></mujoco>", encoding="utf-8")
    with pytest.raises(mq.InputError, match="expected fewer faces of many points"):
        read_mjcf(file)


MESH = '<mujoco><asset><mesh name="a" {}/></asset><worldbody>{}</worldbody></mujoco>'
PART = BODY.format('<geom type="mesh" mesh="a"/>')
CORNERS = "0 0 0  1 0 0  0 1 0  0 0 1"


@pytest.mark.parametrize(
    ("attributes", "said"),
    [
        ('file="none.stl"', "mesh 'a': mesh file none.stl: there is no such file"),
        ('file="robot.dae"', "expected STL, OBJ or MSH, got '.dae'"),
        ('vertex="0 0 0 1 0 0"', "a mesh expects four points or more"),
        (f'vertex="{CORNERS} 1"', "expected triples of numbers for vertex of <mesh>, got 13"),
        (f'vertex="{CORNERS}" face="0 1 7"', "a face of the mesh names a point that is not there"),
        (f'vertex="{CORNERS}" face="0 1 2"', "the volume of the mesh is too small"),
        (f'vertex="{CORNERS}" inertia="soft"', "inertia='soft' of <mesh> is not read"),
        (f'vertex="{CORNERS}" maxhullvert="8"', "the inertia of a hull with maxhullvert=…"),
        (f'vertex="{CORNERS}" builtin="cone"', "builtin=… of <mesh> is not read"),
        (
            f'vertex="{CORNERS}" inertia="exact" face="0 1 2 0 1 3 0 3 2 1 2 3"',
            "faces of the mesh have inconsistent orientations",
        ),
    ],
)
def test_meshes_that_are_not_read_are_refused_by_name(attributes: str, said: str) -> None:
    with pytest.raises(mq.InputError, match=re.escape(said)):
        read_mjcf(MESH.format(attributes, PART))
