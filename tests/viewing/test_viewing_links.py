"""Robots whose meshes are not there: links are drawn from joint to joint, and keep their names."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import mecanique as mq
from mecanique.viewing.scene.drawn import bodies_of, title_of

LINK = """
  <link name="{name}">
    <inertial><origin xyz="0 0 0.1"/><mass value="{mass}"/>
      <inertia ixx="0.01" iyy="0.01" izz="0.005" ixy="0" ixz="0" iyz="0"/></inertial>
    {visual}
  </link>"""
JOINT = """
  <joint name="{name}" type="revolute"><parent link="{parent}"/><child link="{child}"/>
    <origin xyz="{at}"/><axis xyz="0 1 0"/>
    <limit lower="-2" upper="2" effort="1" velocity="1"/></joint>"""
MESH = '<visual><geometry><mesh filename="package://nowhere/part.stl"/></geometry></visual>'
BALL = '<visual><geometry><sphere radius="0.05"/></geometry></visual>'


def read(folder: Path, visuals: tuple[str, str, str]) -> mq.Mechanism:
    links = "".join(
        LINK.format(name=name, mass=mass, visual=visual)
        for name, mass, visual in zip(("upper", "fore", "hand"), (4, 1, 0.2), visuals, strict=True)
    )
    joints = "".join(
        JOINT.format(name=name, parent=parent, child=child, at=at)
        for name, parent, child, at in (
            ("shoulder", "base", "upper", "0 0 0.5"),
            ("elbow", "upper", "fore", "0.3 0 0.4"),
            ("wrist", "fore", "hand", "0 -0.25 0"),
        )
    )
    path = folder / "arm.urdf"
    path.write_text(f'<robot name="my_Arm"><link name="base"/>{links}{joints}</robot>', "utf-8")
    return mq.read_urdf(path)


@pytest.mark.parametrize("visual", ["", MESH])
def test_links_without_pictures_reach_from_joint_to_joint(visual: str, tmp_path: Path) -> None:
    bodies = {body.name: body for body in bodies_of(read(tmp_path, (visual,) * 3))}
    ends = {"base": (0, 0, 0.5), "upper": (0.3, 0, 0.4), "fore": (0, -0.25, 0), "hand": (0, 0, 0.1)}
    radii = {}
    for name, end in ends.items():
        (rod,) = bodies[name].shapes
        radii[name], length = rod.size
        axis, center = np.array(rod.pose)[:3, 2], np.array(rod.pose)[:3, 3]
        np.testing.assert_allclose(center - axis * length / 2, 0, rtol=0, atol=1e-12)
        np.testing.assert_allclose(center + axis * length / 2, end, rtol=0, atol=1e-12)
        rotation = np.array(rod.pose)[:3, :3]
        np.testing.assert_allclose(rotation @ rotation.T, np.eye(3), rtol=0, atol=1e-12)
        assert np.linalg.det(rotation) == pytest.approx(1, rel=1e-12)
    assert radii["upper"] > radii["fore"] > radii["hand"]


def test_what_is_drawn_stays_as_it_is(tmp_path: Path) -> None:
    bodies = {body.name: body for body in bodies_of(read(tmp_path, (BALL, MESH, "")))}
    assert [shape.kind for shape in bodies["upper"].shapes] == ["sphere"]
    assert [shape.kind for shape in bodies["fore"].shapes] == ["cylinder"]
    # where every mesh is there, frames without a picture are none
    plain = {body.name: body for body in bodies_of(read(tmp_path, (BALL, "", "")))}
    assert [len(body.shapes) for body in plain.values()] == [0, 1, 0, 0]


def test_titles_are_the_names_in_the_file(tmp_path: Path) -> None:
    assert title_of(read(tmp_path, ("",) * 3)) == "my_Arm"
    assert title_of(mq.textbook.load("double_pendulum")) == "Double pendulum"
