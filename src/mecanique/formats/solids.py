"""Volumes and inertias of MuJoCo's solids and shells, and of meshes by each of its rules."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Literal, TypeAlias, get_args

import numpy as np
from numpy.typing import NDArray

from mecanique.arrays import Array
from mecanique.errors import InputError
from mecanique.urdf.meshes import MOST_BYTES, MOST_TRIANGLES, read_stl
from mecanique.urdf.solids import Corners, Mass, hull_of, inertia_of, moments_of_squares, pyramids

Rule: TypeAlias = Literal["legacy", "exact", "convex", "shell"]

RULES: Mapping[str, Rule] = {rule: rule for rule in get_args(Rule)}

SIZES = {"sphere": 1, "capsule": 2, "cylinder": 2, "ellipsoid": 3, "box": 3}
"""How many sizes each kind of geom has that has a volume."""

_MOST_CORNERS = 100
"""Most corners of a face that MuJoCo reads; it leaves out those with more."""

_MOST_CUTS = 5_000_000
"""Most corners tried in a file, where each may be tried for every other one of its face."""

_SMALL = 1e-15
"""What MuJoCo takes for no volume and no area."""

_LEFT = 1e-7
"""The largest product of inertia that MuJoCo leaves to a mesh, by its largest entry (measured)."""

_ROUNDING = 1e-14
"""The largest product of inertia, by the largest entry, that counts as none."""

_APART = 1e-12
"""Between moments of inertia that differ, MuJoCo's mjEPS of eigenvalues."""

_SKIN = 1e-6
"""How far MuJoCo blows up an ellipsoid to find its shell's inertia [m]."""


def shell_of(form: str, size: Array) -> tuple[float, Array]:
    """Area, and squares of the radii of gyration, of a geom with `shellinertia`."""
    a, b, c = size
    match form:
        case "sphere":
            return 4 * math.pi * a * a, np.full(3, 2 / 3 * a * a)
        case "ellipsoid":
            return _ellipsoid_shell(size)
        case "box":
            faces = 4 * np.array([b * c, a * c, a * b])  # across x, y, z; there are two of each
            squares = 2 * size**2 * (faces + (faces.sum() - faces) / 3)
            area = 2 * float(faces.sum())
            return area, moments_of_squares(squares) / area
        case "cylinder":
            tube, disk = 4 * math.pi * a * b, math.pi * a * a
            across = tube * (a * a / 2 + b * b / 3) + 2 * disk * (a * a / 4 + b * b)
            along = tube * a * a + disk * a * a
            area = tube + 2 * disk
            return area, np.array([across, across, along]) / area
    # a capsule: the centers of its hollow caps lie r/2 beyond its ends
    tube, ball = 4 * math.pi * a * b, 4 * math.pi * a * a
    caps = 2 / 3 * a * a + (b + a / 2) ** 2 - a * a / 4
    across = tube * (a * a / 2 + b * b / 3) + ball * caps
    along = tube * a * a + ball * 2 / 3 * a * a
    return tube + ball, np.array([across, across, along]) / (tube + ball)


def _ellipsoid_shell(size: Array) -> tuple[float, Array]:
    a, b, c = size
    p = 1.6075  # K. Thomsen's formula for the area
    mean = ((a * b) ** p + (b * c) ** p + (c * a) ** p) / 3
    blown = size + _SKIN
    inner, outer = float(np.prod(size)), float(np.prod(blown))
    moments = outer * moments_of_squares(blown**2) - inner * moments_of_squares(size**2)
    return 4 * math.pi * mean ** (1 / p), moments / (outer - inner) / 5


def mesh_of(corners: Corners, rule: Rule) -> Mass:
    """Return a mesh of unit density by one of MuJoCo's rules; of a shell, of unit density an area.

    `legacy` counts every pyramid over a face as positive, its apex first in the center of the
    faces, then in the center of mass that follows: not the true volume of a body with hollows.
    """
    if rule == "convex":
        corners = hull_of(corners.reshape(-1, 3))
    if rule == "exact":
        _check_orientation(corners)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas = np.linalg.norm(normals, axis=1) / 2
    centers = corners.mean(axis=1)
    if areas.sum() < _SMALL:
        raise InputError("the surface of the mesh is too small")
    apex = areas @ centers / areas.sum()
    if rule == "shell":
        weights, middle = areas, apex
    else:
        count = np.abs if rule == "legacy" else np.asarray
        weights = count(pyramids(corners, apex))
        if weights.sum() < _SMALL:
            raise InputError("the volume of the mesh is too small, or its triangles face inwards")
        middle = weights @ (0.75 * centers + 0.25 * apex) / weights.sum()
        weights = count(pyramids(corners, middle))
    inertia = inertia_of(corners - middle, weights, shell=rule == "shell")
    axes = principal_axes(inertia, _LEFT)
    inertia = axes @ np.diag(np.diagonal(axes.T @ inertia @ axes)) @ axes.T
    return Mass(float(weights.sum()), middle, inertia, axes)


def principal_axes(inertia: Array, least: float = _ROUNDING) -> Array:
    """Return principal axes of a tensor by Jacobi's iteration from its own axes, as MuJoCo does.

    It ends where no product of inertia exceeds a least part of the tensor's largest entry; the
    largest moment comes first.
    """
    axes, least = np.eye(3), least * float(np.abs(inertia).max())
    for _ in range(500):
        turned = axes.T @ inertia @ axes
        r, c = max(((1, 2), (0, 2), (0, 1)), key=lambda pair: abs(turned[pair]))
        if abs(turned[r, c]) <= least:
            break
        tau = (turned[c, c] - turned[r, r]) / (2 * turned[r, c])
        tangent = math.copysign(1.0, tau) / (abs(tau) + math.sqrt(1 + tau * tau))
        cosine = 1 / math.sqrt(1 + tangent * tangent)
        step = np.eye(3)
        step[r, r] = step[c, c] = cosine
        step[r, c], step[c, r] = tangent * cosine, -tangent * cosine
        axes = axes @ step
    moments = np.diagonal(axes.T @ inertia @ axes).copy()
    for k in (0, 1, 0):
        if moments[k] + _APART < moments[k + 1]:
            moments[[k, k + 1]] = moments[[k + 1, k]]
            axes[:, [k, k + 1]] = axes[:, [k + 1, k]] * [1.0, -1.0]
    return axes


def _check_orientation(corners: Corners) -> None:
    """Refuse a mesh of which two faces run along an edge in one direction."""
    _, numbers = np.unique(corners.reshape(-1, 3), axis=0, return_inverse=True)
    faces = numbers.reshape(-1, 3)
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    # MuJoCo does not look at the edges of the smallest faces
    faces = faces[np.linalg.norm(normals, axis=1) / 2 > math.sqrt(_SMALL)]
    edges = np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]])
    if len(np.unique(edges, axis=0)) < len(edges):
        raise InputError("faces of the mesh have inconsistent orientations")


def faces_of(points: Array, faces: NDArray[np.int64]) -> Corners:
    """Return triangles by their corners; without faces, those of the convex hull."""
    if len(points) < 4:
        raise InputError("a mesh expects four points or more")
    if not len(faces):
        return hull_of(points)
    if faces.min() < 0 or faces.max() >= len(points):
        raise InputError("a face of the mesh names a point that is not there")
    return np.asarray(points[faces])


def read_solid(path: Path) -> Corners:
    """Return the triangles of a mesh file as MuJoCo reads it: in single precision."""
    readers: dict[str, Callable[[bytes], Corners]] = {
        ".stl": lambda data: read_stl(data)[0].corners,
        ".obj": _read_first_object,
        ".msh": _read_msh,
    }
    reader = readers.get(path.suffix.lower())
    try:
        if reader is None:
            raise InputError(f"expected STL, OBJ or MSH, got {path.suffix!r}")
        if not path.is_file():
            raise InputError("there is no such file")
        with path.open("rb") as stream:
            data = stream.read(MOST_BYTES + 1)
        if len(data) > MOST_BYTES:
            raise InputError(f"expected at most {MOST_BYTES:,} bytes")
        corners = reader(data).astype(np.float32).astype(float)
        if not np.isfinite(corners).all():
            raise InputError("expected finite numbers, got some that are not")
    except OSError as error:
        raise InputError(f"mesh file {path}: {error.strerror or error}") from None
    except InputError as error:
        raise InputError(f"mesh file {path}: {error}") from None
    return corners


def _read_first_object(data: bytes) -> Corners:
    """Return the first object or group of an OBJ file that has faces: MuJoCo reads no further."""
    points: list[list[float]] = []
    faces: list[list[int]] = []
    complete = False
    for line in data.decode("utf-8", "replace").splitlines():
        word, *rest = line.split() or [""]
        complete = complete or (word in ("o", "g") and bool(faces))
        try:
            if word == "v":
                points.append([float(text) for text in rest[:3]])
            elif word == "f" and not complete:
                numbers = [int(corner.partition("/")[0]) for corner in rest]
                faces.append([k - 1 if k > 0 else len(points) + k for k in numbers])
        except ValueError:
            raise InputError(f"expected numbers, got {line.strip()[:60]!r}") from None
        if len(faces) > MOST_TRIANGLES:
            raise InputError(f"expected at most {MOST_TRIANGLES:,} faces")
    if any(len(point) != 3 for point in points):
        raise InputError("expected points of three numbers")
    places = np.array(points, dtype=np.float32).astype(float).reshape(-1, 3)
    if sum(len(face) ** 2 for face in faces if 4 < len(face) <= _MOST_CORNERS) > _MOST_CUTS:
        raise InputError("expected fewer faces of many points: cut them into triangles")
    triangles: list[list[int]] = []
    for face in faces:
        triangles += _cut(face, places)
    return faces_of(places, np.array(triangles, dtype=np.int64).reshape(-1, 3))


def _cut(face: list[int], places: Array) -> list[list[int]]:
    """Cut a face into triangles as MuJoCo does, a quadrangle along its shorter diagonal."""
    if len(face) == 3:
        return [face]
    if len(face) < 3 or not all(0 <= k < len(places) for k in face):
        raise InputError(
            f"expected faces of 3 points or more that are there, got one of {len(face)}"
        )
    if len(face) > 4:
        return _cut_ears(face, places) if len(face) <= _MOST_CORNERS else []
    a, b, c, d = face
    ac, bd = (places[[c, d]] - places[[a, b]]).astype(np.float32)
    shorter = (ac * ac).sum() < (bd * bd).sum()
    return [[a, b, c], [a, c, d]] if shorter else [[a, b, d], [b, c, d]]


def _cut_ears(face: list[int], places: Array) -> list[list[int]]:
    """Cut off a polygon's corners one by one, in the plane of two axes, in single precision.

    tinyobjloader, which MuJoCo reads OBJ with, compares a corner's turn with the area between its
    first side and the origin, so that what it cuts may overlap; what it cannot cut, or has left
    after the last of its tries, is left out.
    """
    points = places[face].astype(np.float32)
    sides = np.roll(points, -1, axis=0) - points
    turns = np.abs(np.cross(sides, np.roll(sides, -1, axis=0)))
    bent = turns[(turns > np.finfo(np.float32).eps).any(axis=1)]
    x, y, z = bent[0] if len(bent) else (1.0, 0.0, 0.0)
    axes = [0, 2]
    if x > max(y, z):
        axes = [1, 2]
    elif z > max(x, y):
        axes = [0, 1]
    flat = points[:, axes]
    rest, start, tries = [*range(len(face))], 0, len(face)
    triangles: list[list[int]] = []
    while len(rest) > 3 and tries:
        start, tries = start % len(rest), tries - 1
        ahead = rest[start:] + rest[:start]
        a, b, c = ear = flat[ahead[:3]]
        if _area(b - a, c - b) * _area(a, b) < 0 or _holds(ear, flat[ahead[3:]]):
            start += 1
            continue
        triangles.append(ahead[:3])
        del rest[(start + 1) % len(rest)]
        tries = tries and len(rest) + 1
    triangles += [rest] if len(rest) == 3 else []
    return [list(map(face.__getitem__, corners)) for corners in triangles]


def _area(a: Array, b: Array) -> float:
    """The signed area that two vectors of a plane span."""
    return float(a[0] * b[1] - a[1] * b[0])


def _holds(corners: NDArray[np.float32], points: NDArray[np.float32]) -> bool:
    """Whether a ray along x leaves a triangle once, from any of the points of a plane, (n, 2)."""
    (ax, ay), (bx, by) = corners.T[:, :, None], corners[[2, 0, 1]].T[:, :, None]
    x, y = points.T
    crossed = (ay > y) != (by > y)
    height = np.where(crossed, by - ay, 1)
    inside = crossed & (x < (bx - ax) * (y - ay) / height + ax)
    return bool((inside.sum(axis=0) % 2).any())


def _read_msh(data: bytes) -> Corners:
    """MuJoCo's own binary format: four counts, then points, normals, texture, faces."""
    head = np.frombuffer(data[:16], "<i4")
    if len(head) < 4 or (head < 0).any():
        raise InputError("the MSH file breaks off, or its sizes are wrong")
    points, normals, texture, faces = (int(count) for count in head)
    start = 16 + 12 * points + 12 * normals + 8 * texture
    if len(data) != start + 12 * faces:
        raise InputError("the MSH file breaks off, or its sizes are wrong")
    places = np.frombuffer(data, "<f4", 3 * points, 16).reshape(-1, 3).astype(float)
    triples = np.frombuffer(data, "<i4", 3 * faces, start).reshape(-1, 3)
    return faces_of(places, triples.astype(np.int64))
