"""Masses and inertias beside those of shapes, and what of them the linter reports."""

from __future__ import annotations

import json
import re
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import mecanique as mq
from mecanique.cli import app
from mecanique.model.bodies.visuals import Box, Cylinder, Mesh, Sphere, Visual
from mecanique.model.placement import Placement
from mecanique.urdf.lint.check import mirror_name
from mecanique.urdf.lint.homogeneous import solid_of
from mecanique.urdf.meshes import read_mesh

EDGES = (0.2, 0.3, 0.5)
CORNERS = [(x, y, z) for x in (0, 1) for y in (0, 1) for z in (0, 1)]
FACES = [
    (0, 1, 3), (0, 3, 2), (4, 6, 7), (4, 7, 5), (0, 4, 5), (0, 5, 1),
    (2, 3, 7), (2, 7, 6), (0, 2, 6), (0, 6, 4), (1, 5, 7), (1, 7, 3),
]  # fmt: skip

ROBOT = """<robot name="r"><link name="base"/>
<link name="arm"><inertial><origin xyz="{at}"/><mass value="{mass}"/>
<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>
<visual><origin xyz="0.1 0.2 0.3"/><geometry>{geometry}</geometry></visual></link>
<joint name="j" type="continuous"><parent link="base"/><child link="arm"/><axis xyz="0 0 1"/>
</joint></robot>"""
BOX = '<box size="0.2 0.3 0.5"/>'


def write_mesh(path: Path, faces: list[tuple[int, int, int]] = FACES) -> None:
    """A block with a corner in its origin, in millimeters, as an ASCII STL file."""
    lines = ["solid block"]
    for face in faces:
        lines += ["facet normal 0 0 0", "outer loop"]
        for corner in face:
            x, y, z = (1000 * e * c for e, c in zip(EDGES, CORNERS[corner], strict=True))
            lines.append(f"vertex {x} {y} {z}")
        lines += ["endloop", "endfacet"]
    path.write_text("\n".join([*lines, "endsolid block"]), encoding="utf-8")


def robot(folder: Path, geometry: str, mass: float = 81.0, at: str = "0.1 0.2 0.3") -> Path:
    file = folder / "arm.urdf"
    text = ROBOT.format(geometry=geometry, mass=mass, at=at)
    file.write_text(text, encoding="utf-8")
    return file


def mesh(folder: Path, faces: list[tuple[int, int, int]] = FACES) -> str:
    write_mesh(folder / "block.stl", faces)
    return '<mesh filename="block.stl" scale="0.001 0.001 0.001"/>'


def test_primitives_are_those_of_the_model() -> None:
    place = Placement((0.1, -0.2, 0.3), (0.4, 0.5, 0.6))
    for geometry, shape in (
        (Box(EDGES), mq.box(1.0, EDGES)),
        (Cylinder(0.1, 0.4), mq.cylinder(1.0, 0.1, 0.4)),
        (Sphere(0.2), mq.ball(1.0, 0.2)),
    ):
        solid = solid_of([Visual(geometry, place)], meshes=False)
        assert solid is not None
        assert np.allclose(solid.center, place.xyz, rtol=1e-14, atol=0)
        turned = np.array(shape.at(place.xyz, place.rpy).inertia, float)
        own = solid.inertia / solid.volume
        assert np.allclose(own[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]], turned, rtol=0, atol=1e-15)


def test_two_halves_make_a_whole() -> None:
    halves = [
        Visual(Box((0.1, 0.3, 0.5)), Placement((x, 0.0, 0.0), (0.0, 0.0, 0.0)))
        for x in (-0.05, 0.05)
    ]
    both, whole = solid_of(halves, meshes=False), solid_of([Visual(Box(EDGES))], meshes=False)
    assert both is not None
    assert whole is not None
    for name in ("volume", "center", "inertia", "low", "high"):
        assert np.allclose(getattr(both, name), getattr(whole, name), rtol=1e-14, atol=0), name


@pytest.mark.parametrize(("faces", "kind"), [(FACES, "mesh"), (FACES[:-1], "hull")])
def test_a_mesh_is_the_solid_it_encloses(
    tmp_path: Path, faces: list[tuple[int, int, int]], kind: str
) -> None:
    (link,) = mq.compare_inertias(robot(tmp_path, mesh(tmp_path, faces)), density=2700).links
    assert link.solid.kind == kind
    assert link.by_shape == pytest.approx(2700 * 0.03, rel=1e-6)
    assert np.allclose(link.solid.center, np.array(EDGES) / 2 + (0.1, 0.2, 0.3), rtol=1e-14, atol=0)
    a, b, c = EDGES
    moments = 81 / 12 * np.array([b * b + c * c, a * a + c * c, a * a + b * b])
    assert np.allclose(link.inertia, np.diag(moments), rtol=1e-6, atol=1e-9)


def test_a_mirrored_and_turned_mesh_is_the_same_solid(tmp_path: Path) -> None:
    write_mesh(tmp_path / "block.stl")
    place = Placement((7.0, -5.0, 9.0), (0.4, 0.5, 0.6))
    mirrored = (0.001, -0.001, 0.001)
    solid = solid_of([Visual(Mesh("", tmp_path / "block.stl", mirrored), place)], meshes=True)
    middle = np.array(EDGES) / 2 * (1, -1, 1)
    same = solid_of([Visual(Box(EDGES), place)], meshes=False)
    assert solid is not None
    assert same is not None
    assert solid.kind == "mesh"
    assert solid.volume == pytest.approx(0.03, rel=1e-12)
    turn = np.array(place.rotation, float)
    assert np.allclose(solid.center, same.center + turn @ middle, rtol=1e-14, atol=0)
    assert np.allclose(solid.inertia, same.inertia, rtol=0, atol=1e-15)


HEAD = b"\0" * 80
DOUBLED = "".join(
    f'<node id="n{k}"><instance_node url="#n{k + 1}"/><instance_node url="#n{k + 1}"/></node>'
    for k in range(35)
)
SCENE = """<COLLADA><library_visual_scenes><visual_scene id="s"><node><instance_node url="#n0"/>
</node>{}<node id="n35"/></visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#s"/></scene></COLLADA>"""


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("a.stl", HEAD + (50_000_000).to_bytes(4, "little"), "one that breaks off"),
        (
            "b.stl",
            b"version https://git-lfs.github.com/spec/v1",
            "a pointer of Git LFS to the file",
        ),
        ("c.stl", b"", "holds no triangles"),
        ("d.stl", b"solid a\nendsolid a", "it holds no triangles"),
        ("e.stl", b"solid vertex 0 0 0 vertex 1 0 0 vertex 0 1 0", "it encloses no volume"),
        ("a.dae", SCENE.format(DOUBLED).encode(), "at most 100,000 nodes and instances"),
        ("b.dae", b'<COLLADA><asset><unit meter="x"/></asset></COLLADA>', "missing or wrong"),
        ("a.obj", b"v 0 0\n", "line 1: expected numbers, got 'v 0 0'"),
        ("b.obj", b"v 0 0 0\nf 1 9223372036854775809 1\n", "line 2: expected numbers"),
        ("a.ply", b"ply", "expected STL, OBJ or DAE, got 'ply'"),
    ],
)
def test_meshes_that_cannot_be_read_are_found(
    tmp_path: Path, name: str, content: bytes, said: str
) -> None:
    (tmp_path / name).write_bytes(content)
    file = robot(tmp_path, f'<mesh filename="{name}"/>')
    (finding,) = (f for f in mq.lint(file, meshes=True) if f.code == "M508")
    assert said in finding.message
    assert str(tmp_path / name) in finding.message
    assert said in str(mq.compare_inertias(file))


def test_large_meshes_are_refused_before_they_are_held(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    count = 2_000_001
    path = tmp_path / "a.stl"
    with path.open("wb") as file:
        file.write(HEAD + count.to_bytes(4, "little"))
        file.truncate(84 + 50 * count)
    with pytest.raises(mq.InputError, match="at most 100,000,000 bytes, got 100,000,134"):
        read_mesh(path)
    monkeypatch.setattr("mecanique.urdf.meshes.MOST_BYTES", 200_000_000)
    with pytest.raises(mq.InputError, match="at most 2,000,000 triangles, got 2,000,001"):
        read_mesh(path)
    monkeypatch.setattr("mecanique.urdf.meshes.MOST_TRIANGLES", 1)
    for name, text in (
        ("a.obj", "v 0 0 0\n" * 4 + "f 1 2 3 4\n"),
        ("b.stl", "solid " + "vertex 0 0 0 " * 6),
    ):
        (tmp_path / name).write_text(text, encoding="utf-8")
        with pytest.raises(mq.InputError, match="at most 1 triangles, got 2"):
            read_mesh(tmp_path / name)


def test_the_copy_has_the_inertias_by_shape(tmp_path: Path) -> None:
    file = robot(tmp_path, BOX, mass=3.0, at="0 0 0")
    table = mq.compare_inertias(file)
    assert "inertia" in str(table)
    read = mq.read_urdf(table.write(["arm"]))
    body, shape = read.body("arm"), mq.box(3.0, EDGES)
    assert body.mass == 3.0
    assert body.center == pytest.approx((0.1, 0.2, 0.3), rel=1e-12)
    assert np.allclose(body.inertia, np.array(shape.inertia, float), rtol=1e-8, atol=0)
    again = robot(tmp_path, BOX)
    again.write_text(table.write(), encoding="utf-8")
    (link,) = mq.compare_inertias(again).links
    assert (link.off, link.ratio) == pytest.approx((0.0, 1.0), abs=1e-8)
    with pytest.raises(mq.UnknownNameError, match="base"):
        table.write(["base"])
    with pytest.raises(mq.InputError, match="positive density"):
        mq.compare_inertias(file, density=0.0)


def test_shapes_of_the_other_kind_are_named(tmp_path: Path) -> None:
    file = tmp_path / "r.urdf"
    text = ROBOT.format(at="0 0 0", mass=2, geometry=BOX)
    file.write_text(text.replace("visual>", "collision>"), encoding="utf-8")
    hint = "shapes in <collision> (with --collisions) alone: arm"
    assert str(mq.compare_inertias(file)) == f"no closed shape: arm\n{hint}"
    assert mq.compare_inertias(file, collisions=True).links[0].solid.kind == "box"
    file.write_text(text, encoding="utf-8")
    hint = "shapes in <visual> (without --collisions) alone: arm"
    assert str(mq.compare_inertias(file, collisions=True)) == f"no closed shape: arm\n{hint}"
    file.write_text(text.replace("<inertial", "<none").replace("inertial>", "none>"), "utf-8")
    assert str(mq.compare_inertias(file, collisions=True)) == "no link has a mass or a closed shape"


def test_a_mesh_that_is_not_there_is_named(tmp_path: Path) -> None:
    file = robot(tmp_path, '<mesh filename="package://gone/arm.stl"/>')
    assert str(mq.compare_inertias(file)) == (
        "no closed shape: arm\nthe mesh package://gone/arm.stl is not found; name the folder of "
        "its package (--package-path DIR)"
    )


def test_meshes_are_linted_when_asked(tmp_path: Path) -> None:
    file = robot(tmp_path, mesh(tmp_path), mass=2000.0, at="0.9 0.2 0.3")
    assert {"M213", "M214"}.isdisjoint(finding.code for finding in mq.lint(file))
    found = {f.code: f.message for f in mq.lint(file, meshes=True)}
    assert found["M213"] == "its center of mass lies 600 mm outside of its shape"
    assert found["M214"] == "its density would be 6.67e+04 kg/m³ by the volume of its shape"


def test_the_command_compares_and_writes(tmp_path: Path) -> None:
    file, new = robot(tmp_path, BOX), tmp_path / "new.urdf"
    run = CliRunner().invoke(app, ["inertia", str(file), "--density", "2700", "-o", str(new)])
    assert run.exit_code == 0, run.output
    assert "81" in run.stdout
    assert mq.read_urdf(new).body("arm").mass == pytest.approx(81.0, rel=1e-12)
    rows = json.loads(CliRunner().invoke(app, ["inertia", str(file), "--json"]).stdout)["links"]
    assert rows[0]["density"] == pytest.approx(2700.0, rel=1e-12)
    refused = CliRunner().invoke(app, ["inertia", str(file), "--link", "arm"])
    assert refused.exit_code == 2


@pytest.mark.parametrize(
    ("left", "right"),
    [
        ("left_hip", "right_hip"),
        ("FL_thigh", "FR_thigh"),
        ("l_foot", "r_foot"),
        ("LeftShoulder", "RightShoulder"),
        ("arm_l", "arm_r"),
        ("lhip", "rhip"),
        ("LLEG_LINK1", "RLEG_LINK1"),
        ("torso", ""),
        ("left_left", ""),
    ],
)
def test_names_of_the_other_side(left: str, right: str) -> None:
    assert mirror_name(left) == right


def test_a_sign_that_was_not_mirrored_is_found() -> None:
    text = mq.robot("simple_humanoid").read_text(encoding="utf-8")
    assert not [f for f in mq.lint(text) if f.code == "M212"]
    start = text.index('<link name="RLEG_LINK2"')
    link = text[start : text.index("</link>", start)]
    x, y, z = re.findall(r'<origin[^>]*xyz="([^"]*)"', link[link.index("<inertial") :])[0].split()
    slip = link.replace(f"{x} {y} {z}", f"{x} {float(y) + 0.01} {z}", 1)
    (finding,) = (f for f in mq.lint(text.replace(link, slip)) if f.code == "M212")
    assert finding.where == "link 'RLEG_LINK2'"
    assert "10 mm away" in finding.message
