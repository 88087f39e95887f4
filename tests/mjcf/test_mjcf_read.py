"""Closures of MJCF, files included, what is left out and what is refused."""

from __future__ import annotations

import re
from pathlib import Path

import mujoco
import numpy as np
import pytest

import mecanique as mq
from mecanique.mjcf import read_mjcf

ARM = """<body name="{0}" pos="{1}"><joint name="{0}_joint" axis="0 1 0" pos="0 0 0.1"/>
<geom type="capsule" size="0.02" fromto="0 0 0 0 0 -0.5"/>{2}</body>"""


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
    with pytest.raises(mq.InputError, match=r"no\.xml: there is no such file"):
        read_mjcf(main)


def test_what_is_left_out_is_told() -> None:
    text = model(
        ARM.format("a", "0 0 1", "<camera/>").replace("axis=", 'frictionloss="1" axis='),
        '<actuator><motor joint="a_joint"/></actuator><sensor><clock/><clock/></sensor>'
        '<equality><connect active="false" body1="a" anchor="0 0 0"/></equality>',
    )
    assert read_mjcf(text).about == (
        "Read from MJCF, without 1 actuators, 1 cameras and lights, 1 contacts of geoms, "
        "1 inactive constraints, 2 sensors, dry friction of a_joint."
    )


BODY = '<body><joint axis="0 1 0"/>{}</body>'


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("<sdf/>", "line 1: expected <mujoco> as the outermost element, not <sdf>"),
        ("<mujoco><deformable/></mujoco>", "<deformable> is not read"),
        (model("<composite/>"), "<composite> is not read"),
        (model('<replicate count="2"/>'), "<replicate> is not read"),
        (
            model(BODY.format('<geom type="mesh" mesh="a"/>')),
            "the inertia of a geom of type 'mesh'",
        ),
        (model(BODY.format('<geom size="1" shellinertia="true"/>')), "shellinertia of a geom"),
        (model(BODY.format('<geom size="-1"/>')), "expected 1 positive sizes of a sphere"),
        (model(BODY.format('<geom size="x"/>')), "expected 3 finite numbers for size of <geom>"),
        (model(BODY.format('<geom size="1" magic="1"/>')), "magic=… of <geom> is not read"),
        (model(BODY.format('<geom size="1" class="no"/>')), "no class of defaults 'no'"),
        (model(BODY.format('<geom size="1" euler="0 0 0" quat="1 0 0 0"/>')), "one orientation"),
        (model(BODY.format('<inertial pos="0 0 0"/>')), "<inertial> has no mass"),
        (model('<body><joint type="ball" damping="1"/></body>'), "damping of a ball joint"),
        (model('<body><joint type="screw"/></body>'), "of type hinge, slide, ball or free"),
        (model('<body><joint stiffness="1 2"/></body>'), "expected 1 finite number for stiffness"),
        (model('<body><joint springdamper="1 1"/></body>'), "springdamper=… of <joint>"),
        (model("<body><body><freejoint/></body></body>"), "expects a body of the world"),
        (model('<body><freejoint align="true"/></body>'), "align=… of a free joint"),
        (model("", '<option density="1"/>'), "forces of a medium (density of <option>)"),
        (model("", '<compiler alignfree="true"/>'), "coordinate and alignfree of <compiler>"),
        (model("", '<default class="a"/>'), "expected 'main' for the outermost class"),
        (model("", "<default><default/></default>"), "inside another needs a name"),
        (model("", '<tendon><fixed stiffness="2"/></tendon>'), "stiffness of <fixed> is not read"),
        (model("", '<actuator><motor armature="0.1"/></actuator>'), "armature of <motor>"),
        (model("", "<actuator><plugin/></actuator>"), "plugins are not read"),
        (model("", '<equality><tendon tendon1="a"/></equality>'), "<tendon> among the constraints"),
        (model("", '<equality><joint joint1="a"/></equality>'), "'a' is no hinge or slide"),
        (model("", '<equality><weld body1="a"/></equality>'), "names a body that is not there"),
        (model("", '<equality><weld site1="a"/></equality>'), "names a site that is not there"),
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
    with pytest.raises(mq.InputError, match="is tied by several constraints"):
        read_mjcf(model(TWO, f"<equality>{circle}</equality>"))
