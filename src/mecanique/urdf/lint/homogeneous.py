"""Compare masses and inertias with those of homogeneous bodies of the same shape."""

from __future__ import annotations

import json
import math
import os
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from functools import lru_cache, reduce
from pathlib import Path
from typing import final

import numpy as np

from mecanique.arrays import Array
from mecanique.errors import InputError, UnknownNameError
from mecanique.model.bodies.tensor import entries_of, tensor_of
from mecanique.model.bodies.visuals import Box, Cylinder, Mesh, Sphere, Visual
from mecanique.model.placement import Placement
from mecanique.urdf.findings import Report
from mecanique.urdf.lint.blanks import start_tag
from mecanique.urdf.markup import Element
from mecanique.urdf.meshes import read_mesh
from mecanique.urdf.reading.document import read_document
from mecanique.urdf.reading.links import ENTRIES, UrdfLink
from mecanique.urdf.reading.packages import PackagePath
from mecanique.urdf.solids import Mass, hull_of, inertia_of, pyramids, sum_masses
from mecanique.urdf.solids import solid_of as primitive_of
from mecanique.wording import Legible, say_count

_TOGETHER = 1e-8
"""Corners are one if they differ by less, relative to the mesh."""


@final
@dataclass(frozen=True, eq=False)
class HomogeneousSolid:
    """A homogeneous solid of density 1 in the frame of its link.

    Args:
        volume: [m³].
        center: centroid, shape (3,) [m].
        inertia: about the centroid, in the link's axes, shape (3, 3) [m⁵].
        low: the least coordinates, shape (3,) [m].
        high: the greatest, shape (3,) [m].
        kind: "box", "cylinder", "sphere", "mesh", "hull" or "several".
    """

    volume: float
    center: Array
    inertia: Array
    low: Array
    high: Array
    kind: str

    def __add__(self, solid: HomogeneousSolid) -> HomogeneousSolid:
        whole = sum_masses([Mass(x.volume, x.center, x.inertia) for x in (self, solid)])
        low, high = np.minimum(self.low, solid.low), np.maximum(self.high, solid.high)
        return HomogeneousSolid(whole.mass, whole.center, whole.inertia, low, high, "several")

    def outside(self, point: Array) -> float:
        """Return how far a point lies outside of the solid's bounding box [m]."""
        return float(np.linalg.norm(point - np.clip(point, self.low, self.high)))


def solid_of(
    shapes: Sequence[Visual], *, meshes: bool, faults: list[str] | None = None
) -> HomogeneousSolid | None:
    """Return the solid that shapes make together, None if one is unknown; note faults of meshes."""
    parts = []
    for shape in shapes:
        try:
            parts.append(_solid(shape, meshes=meshes))
        except InputError as error:
            parts.append(None)
            if faults is not None:
                faults.append(str(error))
    known = [part for part in parts if part is not None]
    return reduce(HomogeneousSolid.__add__, known) if known and len(known) == len(parts) else None


def _solid(shape: Visual, *, meshes: bool) -> HomogeneousSolid | None:
    turn, shift = np.array(shape.placement.rotation, float), np.array(shape.placement.xyz, float)
    match shape.geometry:
        case Box(size):
            half = np.array(size, float) / 2
            return _primitive("box", half, half, turn, shift)
        case Cylinder(radius, length):
            r, h = float(radius), float(length) / 2
            return _primitive("cylinder", np.array([r, h, 0]), np.array([r, r, h]), turn, shift)
        case Sphere(radius):
            half = np.full(3, float(radius))
            return _primitive("sphere", half, half, np.eye(3), shift)
        case Mesh(path=path, scale=scale) if meshes and path is not None:
            changed = path.stat().st_mtime_ns if path.is_file() else 0
            return _mesh(path, changed, tuple(scale), shape.placement)
    return None


def _primitive(
    kind: str, size: Array, half: Array, turn: Array, shift: Array
) -> HomogeneousSolid | None:
    """Return a primitive, `half` as large as the box around it."""
    volume, radii = primitive_of(kind, size)
    if not volume > 0:
        return None
    reach = np.abs(turn) @ half
    inertia = turn @ np.diag(volume * radii) @ turn.T
    return HomogeneousSolid(volume, shift, inertia, shift - reach, shift + reach, kind)


@lru_cache(maxsize=256)
def _mesh(
    path: Path, changed: int, scale: tuple[float, ...], place: Placement
) -> HomogeneousSolid | None:
    """The solid that a mesh encloses; a file is read again only if it has changed."""
    del changed  # enough to tell one version of the file from the next
    turn, shift = np.array(place.rotation, float), np.array(place.xyz, float)
    surfaces = read_mesh(path)
    if not surfaces:
        raise InputError(f"mesh file {path}: it holds no triangles")
    corners = np.concatenate([surface.corners.reshape(-1, 3) for surface in surfaces])
    corners = (corners * scale) @ turn.T + shift
    low, high = corners.min(axis=0), corners.max(axis=0)
    # about a point within, so that little cancels
    middle, size = (low + high) / 2, float(np.max(high - low))
    triangles = (corners - middle).reshape(-1, 3, 3)
    whole = _is_closed(triangles, size)
    if not whole:
        try:
            triangles = hull_of(triangles.reshape(-1, 3))
        except InputError:
            raise InputError(f"mesh file {path}: it encloses no volume") from None
    weights = pyramids(triangles, np.zeros(3))
    volume = float(weights.sum())
    if abs(volume) <= 1e-9 * size**3:
        raise InputError(f"mesh file {path}: it encloses no volume")
    first = weights @ triangles.mean(axis=1) * 0.75 / volume
    inertia = np.sign(volume) * inertia_of(triangles - first, pyramids(triangles, first))
    return HomogeneousSolid(
        abs(volume), middle + first, inertia, low, high, "mesh" if whole else "hull"
    )


def _is_closed(triangles: Array, size: float) -> bool:
    """Whether each edge is run along as often in one way as in the other."""
    grid = np.round(triangles.reshape(-1, 3) / (_TOGETHER * size)).astype(np.int64)
    numbers = np.unique(grid, axis=0, return_inverse=True)[1].reshape(-1, 3).astype(np.int64)
    start, end = numbers.ravel(), np.roll(numbers, -1, axis=1).ravel()
    forth = start != end
    start, end = start[forth], end[forth]
    key = np.minimum(start, end) * (len(triangles) * 3 + 1) + np.maximum(start, end)
    edges, edge = np.unique(key, return_inverse=True)
    return not np.bincount(edge.ravel(), np.where(start < end, 1.0, -1.0), len(edges)).any()


_OUTSIDE = 0.02
"""How far outside of its shape a center of mass may lie, relative to the shape's diagonal."""

_DENSE, _LIGHT = 23_000.0, 1.2
"""Densities of osmium, and of air [kg/m³]."""


@final
@dataclass(frozen=True, eq=False)
class LinkInertia:
    """Mass and inertia of a link as written, and as its shape would have if homogeneous.

    Args:
        name: of the link.
        mass: as written [kg].
        solid: of density 1.
        by_shape: the mass for which the homogeneous body is computed [kg].
        off: distance of the center of mass from the centroid [m].
        ratio: largest principal moment as written, by that of the homogeneous body.
    """

    name: str
    mass: float
    solid: HomogeneousSolid
    by_shape: float
    off: float
    ratio: float

    @property
    def density(self) -> float:
        """Mass as written by volume [kg/m³]."""
        return self.mass / self.solid.volume

    @property
    def inertia(self) -> Array:
        """Of the homogeneous body about its center, in the link's axes, shape (3, 3) [kg·m²]."""
        return self.solid.inertia * (self.by_shape / self.solid.volume)


@final
@dataclass(frozen=True, eq=False, repr=False)
class Inertias(Legible):
    """A file's masses and inertias beside those by shape.

    Args:
        links: those whose shape is known.
        unknown: the names of links with mass whose shape is not.
        collisions: whether the shapes are those of <collision>.
        elsewhere: those of the unknown with a shape of the other kind.
        faults: the meshes that cannot be read, with the reason.
        text: of the file.
        elements: of the links, by name.
    """

    links: tuple[LinkInertia, ...]
    unknown: tuple[str, ...]
    collisions: bool
    elsewhere: tuple[str, ...]
    faults: tuple[str, ...]
    text: bytes
    elements: dict[str, Element]

    @property
    def _caption(self) -> str:
        return f"{say_count(len(self.links), 'link')} beside bodies of even density"

    def __str__(self) -> str:
        width = max((len(link.name) for link in self.links), default=4)
        head = (
            f"{'link':<{width}}  {'mass [kg]':>10}  {'by shape':>10}  {'volume [cm³]':>12}  "
            f"{'density':>9}  {'center off':>10}  {'inertia':>8}  shape"
        )
        lines = [head] if self.links else []
        for link in self.links:
            times = f"× {link.ratio:.3g}" if math.isfinite(link.ratio) else "-"
            lines.append(
                f"{link.name:<{width}}  {link.mass:10.4g}  {link.by_shape:10.4g}  "
                f"{1e6 * link.solid.volume:12.4g}  {link.density:9.4g}  "
                f"{1000 * link.off:7.3g} mm  {times:>8}  {link.solid.kind}"
            )
        if self.unknown:
            lines.append(f"no closed shape: {', '.join(self.unknown)}")
        if self.elsewhere:
            kind = "<visual> (without" if self.collisions else "<collision> (with"
            names = ", ".join(self.elsewhere)
            lines.append(f"shapes in {kind} --collisions) alone: {names}")
        lines += self.faults
        return "\n".join(lines) or "no link has a mass or a closed shape"

    def to_json(self) -> str:
        """Return the table for scripts."""
        rows = [
            {
                "link": link.name,
                "mass": link.mass,
                "volume": link.solid.volume,
                "density": link.density,
                "shape": link.solid.kind,
                "center_off": link.off,
                "inertia_ratio": link.ratio if math.isfinite(link.ratio) else None,
                "by_shape": {
                    "mass": link.by_shape,
                    "center": link.solid.center.tolist(),
                    "inertia": dict(zip(ENTRIES, entries_of(link.inertia), strict=True)),
                },
            }
            for link in self.links
        ]
        return json.dumps({"links": rows, "unknown": list(self.unknown)}, indent=2)

    def write(self, links: Collection[str] = ()) -> str:
        """Return the file's text with the homogeneous bodies' masses and inertias."""
        known = {link.name: link for link in self.links}
        for name in links:
            if name not in known:
                raise UnknownNameError("link of a known shape", name, known)
        raw = self.text
        chosen = [known[name] for name in links] if links else list(self.links)
        for link in sorted(chosen, key=lambda link: -self.elements[link.name].offset):
            raw = _replace(raw, self.elements[link.name], link)
        return raw.decode("utf-8-sig")


def compare_inertias(
    path: str | os.PathLike[str],
    *,
    density: float | None = None,
    collisions: bool = False,
    package_path: PackagePath | None = None,
) -> Inertias:
    """Compare a file's masses and inertias with those of homogeneous bodies of the same shape.

    Args:
        path: of a URDF file.
        density: of the homogeneous bodies [kg/m³]; without it each has its link's mass.
        collisions: whether the shapes are those of <collision> instead of <visual>.
        package_path: folders to search for packages.

    Returns:
        The table, to print, and to `write` into a copy of the file.

    Raises:
        UrdfError: if the file cannot be read.
        InputError: if the density is not positive.

    Example:
        >>> print(mq.compare_inertias(mq.robot("double_pendulum")).links[0].solid.kind)
        mesh
    """
    if density is not None and not (density > 0 and math.isfinite(density)):
        raise InputError(f"expected a positive density, got {density!r}")
    document, report = read_document(Path(path), package_path)
    report.refuse(strict=False)
    if document is None:
        raise InputError(f"expected a URDF file, got {path!r}")
    known, unknown, elsewhere = [], [], []
    faults: list[str] = []
    for link in document.links:
        taken, others = link.visuals, link.collisions
        if collisions:
            taken, others = others, taken
        solid = solid_of(taken, meshes=True, faults=faults)
        meshes = (shape.geometry for shape in taken if isinstance(shape.geometry, Mesh))
        faults += [
            f"the mesh {mesh.uri} is not found; name the folder of its package (--package-path DIR)"
            for mesh in meshes
            if mesh.path is None
        ]
        if solid is not None:
            known.append(_compare(link, solid, density))
        elif link.mass:
            unknown.append(link.name)
            elsewhere += [link.name] if others else []
    return Inertias(
        links=tuple(known),
        unknown=tuple(unknown),
        collisions=collisions,
        elsewhere=tuple(elsewhere),
        faults=tuple(dict.fromkeys(faults)),
        text=document.text,
        elements={link.name: link.element for link in document.links},
    )


def check(link: UrdfLink, report: Report, *, meshes: bool) -> None:
    """Note a center of mass outside of the link's shape, and a density that no material has."""
    if not link.mass > 0:
        return
    # what is drawn may lack a motor; what collides may be larger than the part
    shapes = (*link.visuals, *link.collisions)
    faults: list[str] = []
    whole = solid_of(shapes, meshes=meshes, faults=faults)
    for fault in dict.fromkeys(faults):
        report.add("M508", link, fault)
    if whole is None:
        return
    off = whole.outside(np.array(link.frame.xyz, float))
    if off > max(_OUTSIDE * float(np.linalg.norm(whole.high - whole.low)), 1e-3):
        message = f"its center of mass lies {1000 * off:.3g} mm outside of its shape"
        report.add("M213", link, message)
    parts = (solid_of(drawn, meshes=meshes) for drawn in (link.visuals, link.collisions) if drawn)
    solids = [part for part in parts if part is not None]
    densities = [link.mass / part.volume for part in solids]
    if densities and not any(_LIGHT < density < _DENSE for density in densities):
        listed = " or ".join(f"{density:.3g}" for density in dict.fromkeys(densities))
        message = f"its density would be {listed} kg/m³ by the volume of its shape"
        report.add("M214", link, message)


def _compare(link: UrdfLink, solid: HomogeneousSolid, density: float | None) -> LinkInertia:
    mass = link.mass if density is None else density * solid.volume
    center = np.array(link.frame.xyz, float) if link.mass else solid.center
    written = np.linalg.eigvalsh(tensor_of(link.inertia)).max()
    by_shape = np.linalg.eigvalsh(solid.inertia * (mass / solid.volume)).max()
    off = float(np.linalg.norm(center - solid.center))
    return LinkInertia(
        name=link.name,
        mass=link.mass,
        solid=solid,
        by_shape=mass,
        off=off,
        ratio=float(written / by_shape) if by_shape > 0 else math.inf,
    )


def _replace(raw: bytes, element: Element, link: LinkInertia) -> bytes:
    """Put the <inertial> of a homogeneous body into a link, instead of its own if it has one."""
    old = element.child("inertial")
    if old is not None:
        tag = start_tag(old, raw)
        assert tag is not None, "an element that was parsed has a start tag"
        closed = tag.group().endswith(b"/>")
        end = b"</inertial>"
        until = tag.end() if closed else raw.index(end, tag.end()) + len(end)
        return raw[: tag.start()] + _inertial(link).encode() + raw[until:]
    tag = start_tag(element, raw)
    assert tag is not None, "an element that was parsed has a start tag"
    return raw[: tag.end()] + f"\n    {_inertial(link)}".encode() + raw[tag.end() :]


def _inertial(link: LinkInertia) -> str:
    center = " ".join(f"{value:.9g}" for value in link.solid.center)
    entries = zip(ENTRIES, entries_of(link.inertia), strict=True)
    inertia = " ".join(f'{name}="{value:.9g}"' for name, value in entries)
    return (
        f'<inertial>\n      <origin xyz="{center}" rpy="0 0 0"/>\n'
        f'      <mass value="{link.by_shape:.9g}"/>\n      <inertia {inertia}/>\n    </inertial>'
    )
