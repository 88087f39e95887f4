"""Mesh files are read as their formats say, and come back from the bytes a page holds."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray
from viewing_scenes import write_page

from mecanique.errors import InputError
from mecanique.motion import simulate
from mecanique.urdf import read_urdf
from mecanique.urdf.meshes import Surface, fan, read_mesh
from mecanique.urdf.robots import robot
from mecanique.viewing.page.page import STEPS, PackedSurface, mesh_parcel, pack_surfaces
from mecanique.viewing.scene.from_motion import scene_of
from mecanique.viewing.scene.scene import SceneBody, SceneShape

ASSETS = Path(__file__).parents[2] / "src" / "mecanique" / "viewing" / "page" / "assets"
TRIANGLE = [[[0, 0, 0], [1, 0, 0], [0, 1, 0]]]


def written(folder: Path, name: str, contents: str | bytes) -> Path:
    path = folder / name
    path.write_bytes(contents.encode() if isinstance(contents, str) else contents)
    return path


def integers(data: bytes) -> list[int]:
    found, value, shift = [], 0, 0
    for byte in data:
        value |= (byte & 0x7F) << shift
        shift += 7
        if byte < 0x80:
            found.append((value >> 1) ^ -(value & 1))
            value, shift = 0, 0
    return found


def unpacked(packed: PackedSurface) -> NDArray[np.float64]:
    """The corners as the page finds them."""
    n, m = packed.points, packed.triangles
    numbers = np.array(integers(packed.body), dtype=np.int64)
    ways, rest = numbers[:m].tolist(), numbers[m:]
    written = ways.count(2)
    firsts, seconds, thirds, moves = np.split(rest, np.cumsum([written, written, m]))
    assert len(moves) == 3 * n
    edges = iter(zip(firsts.tolist(), seconds.tolist(), strict=True))
    grid: list[NDArray[np.int64]] = []

    def corner(back: int, expected: NDArray[np.int64] | int) -> int:
        if not back:
            grid.append(expected + moves.reshape(3, n)[:, len(grid)])
        return len(grid) - (back or 1)

    corners: list[tuple[int, int, int]] = []
    for way, third in zip(ways, thirds.tolist(), strict=True):
        if way == 2:
            back_first, back_second = next(edges)
            i = corner(back_first, grid[-1] if grid else 0)
            j = left = corner(back_second, grid[i])
            m_expected = grid[j]
        else:
            a, b, c = corners[-1]
            i, j, left = (c, b, a) if way == 0 else (a, c, b)
            m_expected = grid[i] + grid[j] - grid[left]
        corners.append((i, j, corner(third, m_expected)))
    assert len(grid) == n
    points = np.array(packed.low) + packed.step * np.array(grid)
    return np.asarray(points[np.array(corners)])


def whole(corners: NDArray[np.float64], step: float) -> list[bytes]:
    """Triangles as they lie on the grid, whichever corner comes first, in order."""
    rounded = np.round(corners / step).astype(np.int64)
    turned = [min(np.roll(triangle, k, axis=0).tolist() for k in range(3)) for triangle in rounded]
    return sorted(np.array(each).tobytes() for each in turned)


def bumpy(n: int, seed: int) -> NDArray[np.float64]:
    """A square sheet of 2 (n − 1)² triangles with random heights."""
    height = np.random.default_rng(seed).normal(size=(n, n))
    grid = np.stack([*np.meshgrid(np.arange(n), np.arange(n), indexing="ij"), height], axis=2)
    a, b, c, d = (grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:])
    return np.concatenate(
        [np.stack(each, axis=2).reshape(-1, 3, 3) for each in ((a, b, c), (a, c, d))]
    )


@settings(deadline=None)
@given(st.integers(2, 12), st.integers(0, 99))
def test_triangles_come_back_to_half_a_step(n: int, seed: int) -> None:
    corners = bumpy(n, seed)
    (packed,) = pack_surfaces([Surface(corners)])
    assert packed.step == pytest.approx(np.ptp(corners, axis=(0, 1)).max() / STEPS, rel=1e-6)
    assert packed.points == n * n
    low = np.array(packed.low)
    found = unpacked(packed)
    assert whole(found - low, packed.step) == whole(corners - low, packed.step)
    assert (
        np.abs(
            np.sort(found.reshape(-1, 3), axis=0) - np.sort(corners.reshape(-1, 3), axis=0)
        ).max()
        < packed.step
    )


def test_neighbors_cost_little() -> None:
    """A sheet takes about a byte a coordinate of its points and two bytes a triangle."""
    corners = bumpy(60, 0)
    corners[..., 2] = 0
    mixed = np.random.default_rng(0).permutation(corners)
    (packed,) = pack_surfaces([Surface(mixed)])
    assert len(packed.body) < 3 * 1.3 * packed.points + 2.6 * packed.triangles


def test_triangles_without_an_area_are_left_out() -> None:
    flat = [[[0, 0, 0], [1, 0, 0], [1, 1e-9, 0]]]
    (packed,) = pack_surfaces([Surface(np.array(TRIANGLE + flat, dtype=float))])
    assert packed.triangles == 1
    assert pack_surfaces([Surface(np.zeros((1, 3, 3)))]) == ()


def test_edges_that_many_triangles_share_lose_none() -> None:
    """Three sheets at one edge, one twice and one turned over: no manifold, but all there."""
    sheets = [
        [[0, 0, 0], [1, 0, 0], point] for point in ([0, 1, 0], [0, 0, 1], [0, -1, 0], [0, 1, 0])
    ]
    corners = np.array([*sheets, sheets[1][::-1]], dtype=float)
    (packed,) = pack_surfaces([Surface(corners)])
    assert whole(unpacked(packed), 0.25) == whole(corners, 0.25)


@pytest.mark.parametrize(
    ("counts", "expected"),
    [
        ([3], [[0, 1, 2]]),
        ([4, 3], [[0, 1, 2], [0, 2, 3], [4, 5, 6]]),
        ([2, 3, 1], [[2, 3, 4]]),
        ([], []),
    ],
)
def test_polygons_are_cut_into_fans(counts: list[int], expected: list[list[int]]) -> None:
    assert fan(np.array(counts, dtype=np.int64)).tolist() == expected


def test_stl_is_read_from_text_and_from_bytes(tmp_path: Path) -> None:
    text = (
        "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\n"
        "endloop\nendfacet\nendsolid"
    )
    facet = np.array([0, 0, 1, *np.ravel(TRIANGLE)], dtype="<f4").tobytes() + b"\0\0"
    for head in (b"made by hand", b"solid in name only"):
        binary = head.ljust(80, b"\0") + (1).to_bytes(4, "little") + facet
        for name, contents in (("a.stl", text), ("b.STL", binary)):
            (surface,) = read_mesh(written(tmp_path, name, contents))
            assert surface.corners.tolist() == TRIANGLE
            assert surface.rgba is None


OBJ = """mtllib colors.mtl
v 0 0 0
v 1 0 0
v 1 1 0
v 0 1 0 1.0
usemtl red
f 1/1/1 2/2/2 3//3 4
usemtl glass
f -4 -3 -2
usemtl nowhere
f 1 2 3
"""
MTL = "newmtl red\nKd 1 0 0\nnewmtl glass\nKd 0 0.5 1\nd 0.25\n"


def test_obj_has_its_polygons_and_colors(tmp_path: Path) -> None:
    path = written(tmp_path, "a.obj", OBJ)
    assert len(read_mesh(path)) == 1
    written(tmp_path, "colors.mtl", MTL)
    red, glass, plain = read_mesh(path)
    assert red.corners.tolist() == [
        [[0, 0, 0], [1, 0, 0], [1, 1, 0]],
        [[0, 0, 0], [1, 1, 0], [0, 1, 0]],
    ]
    assert glass.corners.tolist() == [[[0, 0, 0], [1, 0, 0], [1, 1, 0]]]
    assert (red.rgba, glass.rgba, plain.rgba) == ((1, 0, 0, 1), (0, 0.5, 1, 0.25), None)


def collada(nodes: str, primitive: str, transparent: str = "") -> str:
    return f"""<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><unit meter="0.01"/><up_axis>Y_UP</up_axis></asset>
<library_effects><effect id="e"><profile_COMMON><technique sid="c"><lambert>
<diffuse><color>0 0.5 1 1</color></diffuse>{transparent}</lambert>
</technique></profile_COMMON></effect>
</library_effects>
<library_materials><material id="m"><instance_effect url="#e"/></material></library_materials>
<library_geometries><geometry id="g"><mesh>
<source id="p"><float_array id="a" count="12">0 0 0 100 0 0 100 100 0 0 100 0</float_array>
<technique_common><accessor source="#a" count="4" stride="3"/></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>{primitive}</mesh>
</geometry></library_geometries>
<library_nodes><node id="shared"><translate>0 0 300</translate>
<instance_geometry url="#g"><bind_material><technique_common>
<instance_material symbol="s" target="#m"/>
</technique_common></bind_material></instance_geometry></node></library_nodes>
<library_visual_scenes><visual_scene id="scene">{nodes}</visual_scene></library_visual_scenes>
<scene><instance_visual_scene url="#scene"/></scene></COLLADA>"""


TRIANGLES = (
    '<triangles count="1" material="s"><input semantic="VERTEX" source="#v" offset="1"/>'
    "<p>9 0 9 1 9 3</p></triangles>"
)
POLYLIST = (
    '<polylist count="2" material="s"><input semantic="VERTEX" source="#v" offset="0"/>'
    "<vcount>4 3</vcount><p>0 1 2 3 0 1 3</p></polylist>"
)
POLYGONS = (
    '<polygons count="2" material="s"><input semantic="VERTEX" source="#v" offset="0"/>'
    "<p>0 1 2 3</p><p>0 1 3</p></polygons>"
)
SHARED = '<node><instance_node url="#shared"/></node>'


def test_collada_has_its_unit_nodes_and_colors(tmp_path: Path) -> None:
    turned = f"<node><rotate>0 0 2 90</rotate><scale>2 1 1</scale>{SHARED}</node>"
    (surface,) = read_mesh(written(tmp_path, "a.dae", collada(turned, TRIANGLES)))
    assert surface.corners[0] == pytest.approx(
        np.array([[0, 0, 3], [0, 2, 3], [-1, 0, 3]]), abs=1e-12
    )
    assert surface.rgba == (0, 0.5, 1, 1)
    matrix = f"<node><matrix>0 -1 0 0 1 0 0 0 0 0 1 -300 0 0 0 1</matrix>{SHARED}</node>"
    (surface,) = read_mesh(written(tmp_path, "b.dae", collada(matrix, TRIANGLES)))
    assert surface.corners[0] == pytest.approx(
        np.array([[0, 0, 0], [0, 1, 0], [-1, 0, 0]]), rel=1e-6
    )


def test_a_turn_about_nothing_is_refused(tmp_path: Path) -> None:
    turned = f"<node><rotate>0 0 0 90</rotate>{SHARED}</node>"
    path = written(tmp_path, "a.dae", collada(turned, TRIANGLES))
    with pytest.raises(InputError, match=r"a\.dae: expected a finite vector .* axis of a turn"):
        read_mesh(path)


@pytest.mark.parametrize("primitive", [POLYLIST, POLYGONS])
def test_collada_polygons_are_cut_into_triangles(tmp_path: Path, primitive: str) -> None:
    (surface,) = read_mesh(written(tmp_path, "a.dae", collada(SHARED, primitive)))
    expected = [[[0, 0], [1, 0], [1, 1]], [[0, 0], [1, 1], [0, 1]], [[0, 0], [1, 0], [0, 1]]]
    assert surface.corners[..., :2] == pytest.approx(np.array(expected), rel=1e-6)


@pytest.mark.parametrize(
    ("rule", "alpha", "red", "factor", "opacity"),
    [
        ("A_ONE", 0.5, 1, 0.5, 0.25),
        ("A_ZERO", 0.5, 1, 0.5, 0.75),
        ("RGB_ONE", 1, 0.5, 1, 0.5),
        ("RGB_ZERO", 1, 0.25, 1, 0.75),
        ("A_ONE", 1, 1, 0, 1),
    ],
)
def test_collada_opacity(
    tmp_path: Path, rule: str, alpha: float, red: float, factor: float, opacity: float
) -> None:
    transparent = (
        f'<transparent opaque="{rule}"><color>{red} {red} {red} {alpha}</color></transparent>'
        f"<transparency><float>{factor}</float></transparency>"
    )
    (surface,) = read_mesh(written(tmp_path, "a.dae", collada(SHARED, TRIANGLES, transparent)))
    assert surface.rgba == pytest.approx((0, 0.5, 1, opacity), rel=1e-6)


@pytest.mark.parametrize(
    ("name", "contents", "message"),
    [
        ("a.ply", "ply", r"a\.ply: expected STL, OBJ or DAE, got 'ply'"),
        (
            "a.stl",
            "solid a\nvertex 0 0\n",
            r"a\.stl: expected an STL file, got one that breaks off",
        ),
        (
            "b.stl",
            "vertex 0 0 0 vertex 1 0 0",
            r"b\.stl: expected an STL file, got one that breaks off",
        ),
        ("a.obj", "v 0 0 zero\n", r"a\.obj: line 1: expected numbers, got 'v 0 0 zero'"),
        ("b.obj", "v 0 0 0\nf 1 2 3\n", r"b\.obj: expected faces between 1 points"),
        ("c.obj", "v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", r"c\.obj: expected finite numbers"),
        ("a.dae", "<COLLADA>", r"a\.dae: expected a COLLADA file, got one that is no XML"),
        (
            "a.dae",
            '<!DOCTYPE a [<!ENTITY b "c">]><COLLADA>&b;</COLLADA>',
            "no XML: a document type or entity is declared",
        ),
        (
            "b.dae",
            collada('<node><instance_node url="#no"/></node>', ""),
            r"b\.dae: .* missing or wrong: KeyError\('no'\)",
        ),
        (
            "c.dae",
            collada('<node id="n"><instance_node url="#n"/></node>', ""),
            r"c\.dae: .*endlessly nested nodes",
        ),
    ],
)
def test_what_cannot_be_read_is_named(
    tmp_path: Path, name: str, contents: str, message: str
) -> None:
    with pytest.raises(InputError, match=message):
        read_mesh(written(tmp_path, name, contents))
    with pytest.raises(InputError, match=r"gone\.stl: there is no such file"):
        read_mesh(tmp_path / "gone.stl")


def test_a_file_is_held_once_however_often_it_is_drawn(tmp_path: Path) -> None:
    path = written(tmp_path, "a.obj", OBJ)
    written(tmp_path, "colors.mtl", MTL)
    own, given_color = (
        SceneShape("mesh", (1, 1, 1), rgba=None, path=path),
        SceneShape("mesh", (1, -2, 1), path=path),
    )
    header, data = mesh_parcel(
        [SceneBody("a", (own,)), SceneBody("b", (given_color, SceneShape("sphere", (1.0,))))]
    )
    assert [each["surface"] for each in header["drawn"]] == [0, 1, 2, 0, 1, 2]
    assert [each["body"] for each in header["drawn"]] == [0, 0, 0, 1, 1, 1]
    assert header["drawn"][1]["rgba"] == [0, 0.5, 1, 0.25]
    assert header["drawn"][5]["rgba"] == [0.55, 0.58, 0.62, 1.0]
    assert header["drawn"][3]["matrix"] == np.diag([1.0, -2, 1, 1]).ravel().tolist()
    bodies = [surface.body for surface in pack_surfaces(read_mesh(path))]
    assert data == b"".join(bodies)
    with pytest.raises(InputError, match=r"gone\.stl: there is no such file"):
        mesh_parcel([SceneBody("a", (SceneShape("mesh", (1, 1, 1), path=tmp_path / "gone.stl"),))])


def test_a_color_paints_a_mesh_of_one_color_not_of_several(tmp_path: Path) -> None:
    written(tmp_path, "colors.mtl", MTL)
    several = written(tmp_path, "several.obj", OBJ)
    one = written(tmp_path, "one.obj", "\n".join(OBJ.splitlines()[:7]))
    green = (0.0, 1.0, 0.0, 1.0)

    def colors(path: Path, rgba: tuple[float, float, float, float] | None) -> list[list[float]]:
        header, _ = mesh_parcel(
            [SceneBody("a", (SceneShape("mesh", (1, 1, 1), rgba=rgba, path=path),))]
        )
        return [each["rgba"] for each in header["drawn"]]

    assert colors(one, None) == [[1, 0, 0, 1]]
    assert colors(one, green) == [[0, 1, 0, 1]]
    assert colors(several, green) == [[1, 0, 0, 1], [0, 0.5, 1, 0.25], [0, 1, 0, 1]]


def test_a_file_that_changes_is_read_again(tmp_path: Path) -> None:
    path = written(tmp_path, "a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n")
    body = SceneBody("a", (SceneShape("mesh", (1, 1, 1), path=path),))
    assert mesh_parcel([body])[0]["surfaces"][0]["triangles"] == 1
    path.write_text(path.read_text(encoding="utf-8") + "v 0 0 1\nf 1 2 4\n", encoding="utf-8")
    os.utime(path, ns=(0, 0))
    assert mesh_parcel([body])[0]["surfaces"][0]["triangles"] == 2


def test_a_robot_fits_into_a_page_of_a_megabyte_and_a_half(tmp_path: Path) -> None:
    """Panda's meshes are 10.5 MB of COLLADA with 134,000 triangles."""
    motion = simulate(read_urdf(robot("panda")), duration=1.0)
    path = write_page(scene_of(motion), tmp_path / "panda.html")
    assert path.stat().st_size < 1_500_000


READ_IN_NODE = """
import { unpackSurface } from "%s";
import { readFileSync } from "node:fs";
const [head, file] = process.argv.slice(1);
const found = unpackSurface(JSON.parse(head), new Uint8Array(readFileSync(file)), 0);
console.log(JSON.stringify([[...found.positions], [...found.corners], found.end]));
"""


def test_the_page_unpacks_what_was_packed(tmp_path: Path) -> None:
    """The page's own script finds the triangles, and where they end among the bytes."""
    node = shutil.which("node")
    if node is None:
        pytest.skip("no node found")
    corners = np.concatenate([bumpy(9, 3), bumpy(4, 5) + 20.0])
    (packed,) = pack_surfaces([Surface(corners)])
    head = {name: getattr(packed, name) for name in ("points", "triangles", "step", "low")}
    (tmp_path / "body").write_bytes(packed.body)
    script = ASSETS / "picture" / "meshes.js"
    command = [node, "--input-type=module", "-e", READ_IN_NODE % script.as_uri()]
    command += [json.dumps(head), str(tmp_path / "body")]
    done = subprocess.run(command, capture_output=True, encoding="utf-8", check=True)
    positions, numbers, end = json.loads(done.stdout)
    assert end == len(packed.body)
    found = np.array(positions).reshape(-1, 3)[np.array(numbers)].reshape(-1, 3, 3)
    assert found == pytest.approx(unpacked(packed), abs=1e-5)
