"""One offline HTML page from a scene: self-contained, without requests or foreign scripts.

Key frames: every number of a scene that changes with time is a column of one table. A column is
rounded to its step, differenced as often as it pays (a smooth motion leaves small integers), and
written as variable-length integers; constant columns and points that ride on a body are not written
at all. The page sums the integers back, which loses nothing beyond the rounding.

Meshes: every coordinate is rounded to 1/8192 of the mesh's longest edge, finer than any screen
shows. Equal points become one. Triangles are put in an order in which neighbors follow one another,
and most share an edge with the one before, so that one number says which. Points are numbered in
the order in which triangles first use them; any other corner is written by how far back it was
used, 0 for a new one. The new corner of a triangle lies near the far corner of a parallelogram with
the triangle before; what is written is how it differs. Normals are not written: the page computes
them.
"""

from __future__ import annotations

import base64
import gzip
import hashlib
import json
import math
import posixpath
import re
import struct
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass
from functools import cache, lru_cache
from html import escape
from pathlib import Path, PurePosixPath
from typing import Any, final

import numpy as np
from numpy.typing import NDArray

from mecanique.arrays import spread
from mecanique.errors import EngineError, InputError
from mecanique.files import stem_of
from mecanique.model.quaternions import conjugate, turn
from mecanique.urdf.meshes import Surface, read_mesh
from mecanique.viewing.page.panels import badge, fill, panels, read_asset, safe
from mecanique.viewing.scene.inspection import Inspection
from mecanique.viewing.scene.scene import (
    GREY,
    PLACES,
    Floats,
    Rgba,
    Scene,
    SceneBody,
    SceneShape,
)

FRAME_RATE = 60.0
SHORT, LEAST_FRAMES = 0.5, 241
"""A motion of at most this length [s] has so many frames, as far as there are samples."""

MOST_FRAMES = 7200
POSITION_STEP = 1e-4  # [m] for a scene of 1 m or more; the error is half a step
QUATERNION_STEP = 5e-5
ARROW_STEP = 2e-5  # of the arrow's greatest length
SERIES_STEP = 1e-6  # of the series' greatest magnitude
_MOST_ORDER = 3


@final
@dataclass(frozen=True)
class Packed:
    """Key frames ready for the page."""

    header: dict[str, Any]
    body: bytes  # the columns' integers


def pack(scene: Scene) -> Packed:
    """Pack everything that moves in a scene."""
    extent = float(np.clip(np.ptp(scene.positions, axis=(0, 1)).max(initial=0.0), 1e-6, 1.0))
    t = scene.t if _is_even(scene.t) and len(scene.t) <= MOST_FRAMES else resample(scene.t)
    anchors = _anchors(scene, 1e-6 * extent)
    steps = _steps(scene, POSITION_STEP * extent)
    columns = _sample(scene, t)
    kept: list[bytes] = []
    orders: list[int] = []
    start = columns[0].tolist()
    riding = {column for first, _, _ in anchors for column in range(first, first + 3)}
    for j, (column, step) in enumerate(zip(columns.T, steps, strict=True)):
        # three differences of numbers below 2**28 stay within the 32 bits JavaScript's operators
        # have
        step = steps[j] = max(step, np.abs(column).max() / 2**28, 1e-300)
        whole = np.round(column / step).astype(np.int64)
        if j in riding or not np.any(whole - whole[0]):
            orders.append(-1)
            continue
        order, rest = _cheapest(whole)
        orders.append(order)
        kept.append(varints(rest))
    header = {
        "n": len(t),
        "first": float(t[0]),
        "dt": float(t[1] - t[0]) if len(t) > 1 else 0.0,
        "orders": orders,
        "steps": steps.tolist(),
        "start": start,
        "anchors": [[first, body, *local] for first, body, local in anchors],
    }
    return Packed(header, b"".join(kept))


def resample(t: Floats) -> Floats:
    """Return the evenly spaced times a page plays."""
    if len(t) < 2:
        return t
    length = float(t[-1] - t[0])
    least = min(len(t), LEAST_FRAMES) - 1 if length <= SHORT else 1
    rare = len(t) - 1 <= least or length / (len(t) - 1) >= 0.999 / FRAME_RATE
    if rare and _is_even(t) and len(t) <= MOST_FRAMES:
        return t
    count = int(min(max(round(length * FRAME_RATE), least), MOST_FRAMES - 1)) + 1
    return np.linspace(t[0], t[-1], count)


def _is_even(t: Floats) -> bool:
    return bool(np.allclose(np.diff(t), np.ptp(t) / max(len(t) - 1, 1), rtol=1e-6, atol=0))


def varints(whole: NDArray[np.int64]) -> bytes:
    """Pack integers below 2**34 in magnitude: seven bits per byte, the sign in the lowest."""
    folded = ((whole << 1) ^ (whole >> 63)).astype(np.uint64)
    longest = max(1, math.ceil(int(folded.max(initial=0)).bit_length() / 7))
    rest = folded[:, None] >> np.arange(0, 7 * longest, 7, dtype=np.uint64)
    groups = (rest & np.uint64(0x7F)).astype(np.uint8)
    used = rest > 0
    groups[:, :-1] |= np.where(used[:, 1:], np.uint8(0x80), np.uint8(0))
    used[:, 0] = True
    return bytes(groups[used])


def _cheapest(whole: NDArray[np.int64]) -> tuple[int, NDArray[np.int64]]:
    """The order of differences that leaves the smallest integers, and what it leaves."""
    best, rest = 0, whole
    least, now = float(np.sum(np.log2(1.0 + np.abs(whole)))), whole
    for order in range(1, _MOST_ORDER + 1):
        now = np.diff(now, prepend=0)
        cost = float(np.sum(np.log2(1.0 + np.abs(now))))
        if cost < least:
            best, rest, least = order, now, cost
    return best, rest


def _steps(scene: Scene, step: float) -> Floats:
    """Each column's step."""
    steps: list[float] = []
    for part in scene.columns:
        match part.kind:
            case "body":
                steps += [*[step] * 3, *[QUATERNION_STEP] * 4]
            case "arrow":
                longest = float(np.linalg.norm(part.values[:, 3:], axis=1).max())
                steps += [*[step] * 3, *[ARROW_STEP * longest] * 3]
            case "line" | "trace":
                steps += [step] * part.values.shape[1]
            case _:
                steps += [SERIES_STEP * float(np.abs(column).max()) for column in part.values.T]
    return np.array(steps)


def _sample(scene: Scene, t: Floats) -> Floats:
    """The scene's table at other times, by linear interpolation."""
    if t is scene.t:
        return scene.table
    sampled = np.stack([np.interp(t, scene.t, column) for column in scene.table.T], axis=1)
    nb = len(scene.bodies)
    turned = sampled[:, : 7 * nb].reshape(len(t), nb, 7)
    turned[..., 3:] /= np.linalg.norm(turned[..., 3:], axis=2, keepdims=True)
    return sampled


def _anchors(scene: Scene, tolerance: float) -> list[tuple[int, int, list[float]]]:
    """Points that ride on a body: their first column, the body, the place in its frame."""
    # most forces and springs act at fixed points, which then follow from the body's pose
    if len(scene.t) < 3:
        return []
    first, points = 0, list[tuple[int, Floats]]()
    for part in scene.columns:
        for place in PLACES.get(part.kind, ()):
            points.append((first + place, part.values[:, place : place + 3]))
        first += part.values.shape[1]
    anchors = []
    few = spread(len(scene.t), 24)
    for column, point in points:
        if np.ptp(point, axis=0).max() == 0:
            continue
        for b in range(len(scene.bodies)):
            p, q = scene.positions[:, b], scene.quaternions[:, b]
            near = turn(conjugate(q[few]), point[few] - p[few])
            if np.ptp(near, axis=0).max() > tolerance:
                continue
            local = turn(conjugate(q), point - p)
            if np.ptp(local, axis=0).max() <= tolerance:
                anchors.append((column, b, local.mean(axis=0).tolist()))
                break
    return anchors


STEPS = 2**13
_BITS = 20  # of a coordinate on the grid, where three are one key

_OVER_LAST, _OVER_FIRST, _ELSEWHERE = 0, 1, 2
"""The edge of the triangle before over which the walk came: third to second corner, or first to
third; or the triangle's edge is written out."""


@final
@dataclass(frozen=True)
class PackedSurface:
    """A surface for the page."""

    points: int
    triangles: int
    step: float  # the grid's [file's units]
    low: tuple[float, float, float]
    rgba: Rgba | None  # color and opacity; None if the file gives none
    body: bytes


def pack_surfaces(surfaces: Sequence[Surface], *, quick: bool = False) -> tuple[PackedSurface, ...]:
    """Pack the surfaces of one file on one grid, so that they still fit together."""
    if not surfaces:
        return ()
    low = np.min([surface.corners.min(axis=(0, 1)) for surface in surfaces], axis=0)
    high = np.max([surface.corners.max(axis=(0, 1)) for surface in surfaces], axis=0)
    step = max(float(np.max(high - low)) / STEPS, 1e-300)
    packed = (_pack_surface(surface, low, step, quick) for surface in surfaces)
    return tuple(surface for surface in packed if surface.triangles)


def _pack_surface(surface: Surface, low: Floats, step: float, quick: bool) -> PackedSurface:
    whole = np.round((surface.corners - low) / step).astype(np.int64).reshape(-1, 3)
    keys = (whole[:, 0] << 2 * _BITS) | (whole[:, 1] << _BITS) | whole[:, 2]
    _, place, numbers = np.unique(keys, return_index=True, return_inverse=True)
    a, b, c = (triangles := numbers.reshape(-1, 3)).T
    walked = triangles[(a != b) & (b != c) & (c != a)]
    if not quick:
        walked = _side_by_side(walked, len(place))
    used, first = np.unique(walked, return_index=True)
    order = used[np.argsort(first)]
    rank = np.empty(len(place), dtype=np.int64)
    rank[order] = np.arange(len(order))
    triangles, points = rank[walked], whole[place[order]]
    flat = triangles.ravel()
    met = np.maximum.accumulate(np.concatenate([[-1], flat]))[:-1] + 1
    back = (met - flat).reshape(-1, 3)
    way, opposite = _ways_in(triangles)
    written = way == _ELSEWHERE
    moves = points - _guess(points, triangles, back == 0, opposite)
    columns = [way, *back[written, :2].T, back[:, 2], *moves.T]
    body = b"".join(map(varints, columns))
    x, y, z = low.tolist()
    return PackedSurface(
        points=len(points),
        triangles=len(triangles),
        step=step,
        low=(x, y, z),
        rgba=surface.rgba,
        body=body,
    )


def _side_by_side(triangles: NDArray[np.int64], points: int) -> NDArray[np.int64]:
    """The triangles in the order of a walk, each from the edge over which the walk enters it."""
    # edge 3 k + i of triangle k runs from its corner i to the next
    start, end = triangles.ravel(), np.roll(triangles, -1, axis=1).ravel()
    edges, owner = np.unique(start * points + end, return_index=True)
    # a neighbor runs along the common edge the other way
    turned = end * points + start
    seat = np.minimum(np.searchsorted(edges, turned), max(len(edges) - 1, 0))
    across = np.where(edges[seat] == turned, owner[seat], -1) if len(edges) else owner
    beyond: list[int] = across.tolist()
    new, entered = [True] * len(triangles), list[int]()
    for first in range(0, 3 * len(triangles), 3):
        waiting = [first]
        while waiting:
            edge = waiting.pop()
            k, i = divmod(edge, 3)
            if edge < 0 or not new[k]:
                continue
            new[k] = False
            entered.append(edge)
            if edge == first:
                waiting.append(beyond[edge])
            waiting.append(beyond[3 * k + (i + 2) % 3])
            waiting.append(beyond[3 * k + (i + 1) % 3])
    edges = np.array(entered, dtype=np.int64)[:, None]
    ordered: NDArray[np.int64] = triangles[edges // 3, (edges % 3 + np.arange(3)) % 3]
    return ordered


def _ways_in(triangles: NDArray[np.int64]) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """How each triangle is entered, and the corner of the triangle before that is left behind."""
    before = np.concatenate([np.full((1, 3), -1), triangles[:-1]])
    (a, b, c), (i, j, _) = before.T, triangles.T
    way = np.select([(i == c) & (j == b), (i == a) & (j == c)], [_OVER_LAST, _OVER_FIRST], 2)
    return way, np.where(way == _OVER_LAST, a, np.where(way == _OVER_FIRST, b, -1))


def _guess(
    points: NDArray[np.int64],
    triangles: NDArray[np.int64],
    new: NDArray[np.bool_],
    opposite: NDArray[np.int64],
) -> NDArray[np.int64]:
    """Where a reader expects each point when its first triangle is read."""
    guessed = np.zeros_like(points)
    first, second, third = (triangles[new[:, k], k] for k in range(3))
    guessed[first[1:]] = points[first[1:] - 1]
    guessed[second] = points[triangles[new[:, 1], 0]]
    i, j, _ = triangles[new[:, 2]].T
    left = opposite[new[:, 2]]
    corner = points[i] + points[j] - points[left]
    guessed[third] = np.where(left[:, None] < 0, points[j], corner)
    return guessed


def mesh_parcel(
    bodies: Sequence[SceneBody], *, quick: bool = False
) -> tuple[dict[str, Any], bytes]:
    """Return the meshes of a scene's bodies as plain data for the page's header, and as bytes."""
    places: dict[Path, range] = {}
    surfaces: list[PackedSurface] = []
    drawn = []
    for k, path, shape in _meshes(bodies):
        if path not in places:
            # a file is packed again only if it has changed
            if not path.is_file():
                raise InputError(f"mesh file {path}: there is no such file")
            packed = _remember(path, path.stat().st_mtime_ns, quick)
            places[path] = range(len(surfaces), len(surfaces) + len(packed))
            surfaces += packed
        matrix = (shape.pose @ np.diag([*map(float, shape.size), 1.0])).ravel().tolist()
        for place in places[path]:
            in_file, given = surfaces[place].rgba, shape.rgba
            # one color must not paint over a mesh that has several
            rgba = (in_file or given if len(places[path]) > 1 else given or in_file) or GREY
            kept = [min(max(float(c), 0.0), 1.0) for c in rgba]
            drawn.append({"body": k, "surface": place, "rgba": kept, "matrix": matrix})
    heads = [
        {"points": s.points, "triangles": s.triangles, "step": s.step, "low": s.low}
        for s in surfaces
    ]
    return {"surfaces": heads, "drawn": drawn}, b"".join(surface.body for surface in surfaces)


def _meshes(bodies: Sequence[SceneBody]) -> Iterator[tuple[int, Path, SceneShape]]:
    for k, body in enumerate(bodies):
        for shape in body.shapes:
            if shape.path is not None:
                yield k, shape.path, shape


@lru_cache(maxsize=64)
def _remember(path: Path, changed: int, quick: bool) -> tuple[PackedSurface, ...]:
    del changed  # enough to tell one version of the file from the next
    return pack_surfaces(read_mesh(path), quick=quick)


_KEPT, _FLEETING = 6, 1
"""Compression levels of a page in a file and of a live one; 9 takes half as long again."""


@final
@dataclass(frozen=True)
class Stream:
    """The source from which the page of a live view gets its frames."""

    identity: str
    sources: tuple[str, ...]


def page(scene: Scene, stream: Stream | None = None) -> str:
    """Return a scene as one HTML document that needs no network."""
    packed = pack(scene)
    meshes, mesh_bytes = mesh_parcel(scene.bodies, quick=stream is not None)
    live = stream and {"id": stream.identity, "first": float(scene.t[0])}
    engine = scene.engine
    header = _header(scene) | {
        "table": packed.header,
        "meshes": meshes,
        "live": live,
        "engine": engine and {**asdict(engine), "script": ""},
        "breaks": list(map(asdict, scene.breaks)),
        "modes": list(map(asdict, scene.modes)),
        "inspection": scene.inspection and _inspection(scene.inspection),
    }
    viewer, style, script = _viewer(), read_asset("page.css"), join_scripts()
    boot = read_asset("boot.js")
    connect = " ".join(stream.sources) if stream else "'none'"
    program = [engine.script] if engine else []
    tabs, inner = panels(scene, live=stream is not None and engine is None)
    subtitle = scene.document.subtitle
    parts = {
        "policy": escape(policy([boot, script, viewer, *program], [style], connect)),
        "title": escape(scene.title),
        "subtitle": f'<p dir="auto">{escape(subtitle)}</p>' if subtitle else "",
        "badge": badge(scene),
        "tabs": tabs,
        "panels": inner,
        "licenses": escape(_licenses()),
        "style": style,
        "parcel": _parcel(
            header,
            [packed.body, mesh_bytes, *draw_bodies(scene.bodies)],
            _FLEETING if stream else _KEPT,
        ),
        "viewer": _compress_once(viewer),
        "program": _compress(engine.script.encode(), _KEPT) if engine else "",
        "script": _compress_once(script),
        "boot": boot,
    }
    return fill(read_asset("page.html"), parts)


def policy(scripts: list[str], styles: list[str], connect: str) -> str:
    """Return the Content-Security-Policy that admits the given scripts and styles alone."""
    inner = _viewer_styles()
    style = " ".join(map(_hash, [*styles, *inner])) if inner else "'unsafe-inline'"
    return (
        f"default-src 'none'; script-src {' '.join(map(_hash, scripts))}; style-src {style};"
        f" img-src data: blob:; connect-src {connect}; base-uri 'none'; form-action 'none'"
    )


def _hash(text: str) -> str:
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'"


def _header(scene: Scene) -> dict[str, Any]:
    """The scene's names and kinds, without its numbers."""
    number = {body.name: k for k, body in enumerate(scene.bodies)}
    ledger = scene.document.ledger
    return {
        "fileName": stem_of(scene.document.file_name),
        "planar": scene.planar,
        "ground": scene.ground,
        "bounds": None if scene.bounds is None else scene.bounds.tolist(),
        "bodies": [{"name": body.name, "solids": solids_of(body)} for body in scene.bodies],
        "arrows": [
            {"name": a.name, "kind": a.kind, "body": number[a.body], "unit": a.unit}
            for a in scene.arrows
        ],
        "lines": [{"name": line.name, "kind": line.kind} for line in scene.lines],
        "traces": [{"name": trace.name} for trace in scene.traces],
        "joints": [{**asdict(joint), "body": number[joint.body]} for joint in scene.joints],
        "series": [
            {
                "name": curve.name,
                "text": curve.name,
                "html": safe(curve.label),
                "unit": curve.unit,
                "group": curve.group,
                "shown": curve.shown,
            }
            for curve in scene.series
        ],
        "ledger": {
            "coordinates": list(ledger.coordinates),
            "rows": [row.name for row in ledger.rows],
        },
    }


def _inspection(inspection: Inspection) -> dict[str, Any]:
    """What the page draws of a description at rest."""
    notes = [
        {
            "severity": note.finding.severity,
            "bodies": note.bodies,
            "suspicious": note.suspicious,
        }
        for note in inspection.notes
    ]
    return {**asdict(inspection), "notes": notes}


def _parcel(header: dict[str, Any], parts: list[bytes], effort: int) -> str:
    """Length of the header, the header, and the parts, compressed."""
    text = json.dumps(header | {"parts": [len(part) for part in parts]}, ensure_ascii=True).encode()
    return _compress(b"".join([struct.pack("<I", len(text)), text, *parts]), effort)


def _compress(data: bytes, effort: int) -> str:
    return base64.b64encode(gzip.compress(data, effort, mtime=0)).decode()


@cache
def _compress_once(text: str) -> str:
    """A text that is part of every page, compressed."""
    return _compress(text.encode(), _KEPT)


@cache
def script_modules() -> tuple[str, ...]:
    """Return the names of the page's scripts; each follows those it imports."""
    modules: dict[str, None] = {}

    def load(name: str) -> None:
        folder = PurePosixPath(name).parent
        for source in re.findall(r'^import [^;]* from "(.+)\.js";', read_asset(f"{name}.js"), re.M):
            imported = posixpath.normpath(folder / source)
            if imported not in modules:
                load(imported)
        modules[name] = None

    load("main")
    return tuple(modules)


@cache
def join_scripts() -> str:
    """Return the page's script: all modules in one closure, where they find one another."""
    texts = []
    for name in script_modules():
        text = re.sub(r"^import [^;]*;\n", "", read_asset(f"{name}.js"), flags=re.MULTILINE)
        text = re.sub(r"^export ", "", text, flags=re.MULTILINE)
        texts.append(re.sub(r"^ *(//.*)?\n|^ +", "", text, flags=re.MULTILINE))
    return '(() => {\n"use strict";\n' + "\n".join(texts) + "})();\n"


@cache
def _viewer() -> str:
    return (viewer_directory() / "main.min.js").read_text(encoding="utf-8")


@cache
def _viewer_styles() -> list[str]:
    """The styles meshcat's viewer puts into the page: an empty one and its control panel's."""
    style = re.search(r'"(\.dg ul\{(?:[^"\\]|\\.)*)"', _viewer())
    if not style:  # another version may write it differently
        return []
    plain = (
        style[1].replace("\\n", "\n").replace('\\"', '"').replace("\\'", "'").replace("\\\\", "\\")
    )
    return ["", plain]


@cache
def _licenses() -> str:
    """The notices of meshcat's viewer and of the libraries bundled in it."""
    folder = viewer_directory()
    texts = []
    meshcat = folder.parent / "LICENSE"
    if meshcat.is_file():
        texts.append("meshcat\n\n" + meshcat.read_text(encoding="utf-8"))
    bundled = folder / "main.min.js.THIRD_PARTY_LICENSES.json"
    if bundled.is_file():
        for package in json.loads(bundled.read_text(encoding="utf-8")):
            notice = package.get("licenseText") or package.get("license")
            texts.append(f"{package.get('name')} {package.get('version')}\n\n{notice}")
    return "\n\n----\n\n".join(text.strip() for text in texts)


# Meshcat's viewer, and the commands that put the solids of bodies into it.


def viewer_directory() -> Path:
    """Return the directory of meshcat's built viewer."""
    from importlib.util import find_spec

    spec = find_spec("meshcat")
    for place in (spec.submodule_search_locations or []) if spec else []:
        folder = Path(place) / "viewer" / "dist"
        if (folder / "main.min.js").is_file():
            return folder
    raise EngineError(
        "meshcat's viewer (viewer/dist/main.min.js) is not installed; try: pip install meshcat"
    )


# cylinders of three.js point along y, those of a mechanism along z
_UPRIGHT = np.array([[1.0, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 0, 0, 1]])

_RING = 0.92
"""Inner radius of a ring, in its outer one."""

_ROUND = 50
"""Facets around a cylinder."""


def draw_bodies(bodies: Sequence[SceneBody]) -> list[bytes]:
    """Return the packed commands that draw all shapes but meshes; body k becomes node `n<k>`."""
    import umsgpack

    objects, places = list[dict[str, Any]](), list[dict[str, Any]]()
    for k, body in enumerate(bodies):
        places.append(_move(f"/meshcat/n{k}", np.eye(4)))
        solids = [shape for shape in body.shapes if shape.kind != "mesh"]
        for j, shape in enumerate(solids):
            path = f"/meshcat/n{k}/s{j}"
            objects.append(
                {"type": "set_object", "path": path, "object": _object(shape, f"{k}.{j}")}
            )
            upright = shape.pose @ _UPRIGHT if shape.kind == "cylinder" else shape.pose
            places.append(_move(path, upright))
    return [umsgpack.packb(command) for command in (*objects, *places)]


def solids_of(body: SceneBody) -> list[dict[str, Any]] | None:
    """A body's solids in plain numbers, for the page's first sketch; None where it has a mesh."""
    if any(shape.kind == "mesh" for shape in body.shapes):
        return None
    return [_solid(shape) for shape in body.shapes]


def _solid(shape: SceneShape) -> dict[str, Any]:
    """A solid: turned by a matrix, row by row, and placed in its body's frame."""
    material = _material(shape.rgba or GREY)
    return {
        "kind": shape.kind,
        "size": list(map(float, shape.size)),
        "profile": _profile(shape) if shape.kind == "cylinder" else [],
        "turn": shape.pose[:3, :3].ravel().tolist(),
        "place": shape.pose[:3, 3].tolist(),
        "color": f"#{material['color']:06x}",
        "opacity": material["opacity"],
    }


def _move(path: str, pose: Floats) -> dict[str, Any]:
    return {"type": "set_transform", "path": path, "matrix": pose.T.ravel().tolist()}


def _object(shape: SceneShape, identity: str) -> dict[str, Any]:
    """A solid as three.js reads it."""
    geometry, material = f"geometry {identity}", f"material {identity}"
    return {
        "metadata": {"version": 4.5, "type": "Object"},
        "geometries": [{"uuid": geometry, **_geometry(shape)}],
        "materials": [{"uuid": material, **_material(shape.rgba or GREY)}],
        "object": {
            "uuid": f"solid {identity}",
            "type": "Mesh",
            "geometry": geometry,
            "material": material,
            "matrix": np.eye(4).ravel().tolist(),
        },
    }


def _geometry(shape: SceneShape) -> dict[str, Any]:
    size = tuple(map(float, shape.size))
    match shape.kind:
        case "box":
            width, height, depth = size
            return {"type": "BoxGeometry", "width": width, "height": height, "depth": depth}
        case "sphere":
            (radius,) = size  # meshcat's own 20 segments do not look round
            facets = {"widthSegments": 40, "heightSegments": 28}
            return {"type": "SphereGeometry", "radius": radius, **facets}
        case "cylinder":
            # every corner twice, so that edges are sharp
            points = [{"x": x, "y": y} for x, y in _profile(shape) for _ in (0, 1)]
            return {"type": "LatheGeometry", "points": points, "segments": _ROUND}
    raise ValueError(f"no geometry of kind {shape.kind!r}")


def _profile(shape: SceneShape) -> list[tuple[float, float]]:
    """The distance from its axis and the height of the corners that turn into a round solid."""
    radius, length = map(float, shape.size)
    low, high = -length / 2, length / 2
    match shape.form:
        case "thin ring":
            inner = _RING * radius
            corners = [(inner, low), (radius, low), (radius, high), (inner, high), (inner, low)]
        case "solid cone":  # drawn by its base, an eighth as high as it is
            corners = [(0.0, high - 8 * length), (radius, high), (0.0, high)]
        case _:
            corners = [(0.0, low), (radius, low), (radius, high), (0.0, high)]
    return corners


def _material(rgba: Rgba) -> dict[str, Any]:
    red, green, blue, opacity = (min(max(float(c), 0.0), 1.0) for c in rgba)
    return {
        "type": "MeshPhongMaterial",
        "color": (round(red * 255) << 16) | (round(green * 255) << 8) | round(blue * 255),
        "specular": 0x222222,
        "shininess": 18,
        "reflectivity": 0.5,
        "opacity": opacity,
        "transparent": opacity < 1,
        "side": 2,
    }
