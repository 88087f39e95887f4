"""A scene: everything the page and the live view show, as plain arrays and texts."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal, TypeAlias, final

import numpy as np
from numpy.typing import NDArray

from mecanique.errors import InputError
from mecanique.viewing.scene.document import Document
from mecanique.viewing.scene.engine import Engine
from mecanique.viewing.scene.inspection import Inspection

Floats: TypeAlias = NDArray[np.float64]
Rgba: TypeAlias = tuple[float, float, float, float]
ShapeKind: TypeAlias = Literal["box", "cylinder", "sphere", "mesh"]
ArrowKind: TypeAlias = Literal["weight", "spring", "damper", "load", "reaction", "inertia"]
ArrowUnit: TypeAlias = Literal["N", "N·m"]
LineKind: TypeAlias = Literal["spring", "damper", "rod"]

GREY: Rgba = (0.55, 0.58, 0.62, 1.0)
_SIZES = {"box": 3, "cylinder": 2, "sphere": 1, "mesh": 3}


def _nowhere() -> Floats:
    return np.eye(4)


@final
@dataclass(frozen=True, eq=False)
class Shape:
    """A solid at its place in a body.

    Args:
        kind: "box", "cylinder", "sphere" or "mesh".
        size: box: edges along x, y, z [m]; cylinder: radius and length along z [m]; sphere: radius
            [m]; mesh: factors along x, y, z.
        pose: shape (4, 4), the shape's frame, at its center, in the body's frame.
        rgba: color and opacity, each from 0 to 1; a mesh keeps its own colors if this is None or if
            it has several.
        path: the file of a mesh: STL, OBJ or DAE.
    """

    kind: ShapeKind
    size: tuple[float, ...]
    pose: Floats = field(default_factory=_nowhere)
    rgba: Rgba | None = GREY
    path: Path | None = None

    def __post_init__(self) -> None:
        if self.kind not in _SIZES:
            raise InputError(
                f"kind of a shape: expected one of {', '.join(_SIZES)}, got {self.kind!r}"
            )
        if len(self.size) != _SIZES[self.kind] or not np.all(np.isfinite(self.size)):
            raise InputError(
                f"size of a {self.kind}: expected {_SIZES[self.kind]} finite numbers, "
                f"got {self.size!r}"
            )
        if (self.kind == "mesh") != (self.path is not None):
            raise InputError(
                f"path of a {self.kind}: a mesh has a file, other shapes have none; got {self.path}"
            )
        object.__setattr__(self, "pose", _array(self.pose, (4, 4), f"pose of a {self.kind}"))


@final
@dataclass(frozen=True, eq=False)
class SceneBody:
    """A body and how it looks.

    Args:
        name: unique in the scene.
        shapes: what is drawn, in the body's frame.
    """

    name: str
    shapes: tuple[Shape, ...] = ()


@final
@dataclass(frozen=True, eq=False)
class Arrow:
    """A force or a moment over time, in world axes.

    Args:
        name: its label; unique in the scene.
        kind: "weight", "spring", "damper", "load", "reaction", or "inertia" for d'Alembert's −m a
            (N) and −(I α + ω × I ω) about the center of mass (N·m).
        body: the body it acts on.
        origin: shape (n, 3), point of application [m].
        vector: shape (n, 3), in units of `unit`.
        unit: "N" for a force, "N·m" for a moment.
    """

    name: str
    kind: ArrowKind
    body: str
    origin: Floats
    vector: Floats
    unit: ArrowUnit = "N"


@final
@dataclass(frozen=True, eq=False)
class Line:
    """Something drawn between two moving points: a spring, a damper, a massless rod.

    Args:
        name: unique in the scene.
        kind: "spring" draws a coil, "damper" a dashpot, "rod" a thin cylinder.
        points: shape (n, 2, 3), both ends over time [m].
    """

    name: str
    kind: LineKind
    points: Floats


@final
@dataclass(frozen=True, eq=False)
class Trace:
    """The path that a point traces.

    Args:
        name: unique in the scene.
        points: shape (n, 3) [m].
    """

    name: str
    points: Floats


@final
@dataclass(frozen=True, eq=False)
class JointMark:
    """A joint, marked where it sits in its child body.

    Args:
        name: unique in the scene.
        kind: "revolute", "prismatic", "spherical", "fixed" or another word; it chooses the mark.
        body: the child body.
        point: shape (3,), the joint's origin in the child's frame [m].
        axis: shape (3,), its axis in the child's frame; zero if it has none.
    """

    name: str
    kind: str
    body: str
    point: tuple[float, float, float] = (0.0, 0.0, 0.0)
    axis: tuple[float, float, float] = (0.0, 0.0, 0.0)


@final
@dataclass(frozen=True, eq=False)
class Series:
    """A quantity over time, to be plotted.

    Args:
        name: unique in the scene.
        label: how it is written: plain text or MathML.
        unit: e.g. "rad/s"; empty if it has none.
        values: shape (n,).
        group: the heading it is listed under, e.g. "Coordinates".
        shown: whether it is plotted when the page opens.
    """

    name: str
    label: str
    unit: str
    values: Floats
    group: str = ""
    shown: bool = False


@final
@dataclass(frozen=True)
class Break:
    """Where a contact or a cord ceases to hold: what moves on from there is no real mechanism.

    Args:
        name: what would happen, e.g. "rim would pull".
        t: when [s].
    """

    name: str
    t: float


@final
@dataclass(frozen=True, eq=False)
class Frame:
    """A scene at one instant.

    Args:
        t: time [s].
        positions: shape (nb, 3), the bodies' origins [m].
        quaternions: shape (nb, 4), x, y, z, w.
        arrows: shape (na, 2, 3), origin and vector of each arrow.
        lines: shape (nl, 2, 3).
        traces: shape (nt, 3).
        series: shape (ns,), the scene's series, then the ledger's entries row by row.
    """

    t: float
    positions: Floats
    quaternions: Floats
    arrows: Floats
    lines: Floats
    traces: Floats
    series: Floats


@final
@dataclass(frozen=True, eq=False)
class Scene:
    """A motion ready to be shown.

    Args:
        title: the page's title.
        t: shape (n,), increasing [s]; n = 1 is a still.
        bodies: nb bodies; the ground may be one of them.
        positions: shape (n, nb, 3), the bodies' origins in the world [m].
        quaternions: shape (n, nb, 4), x, y, z, w.
        arrows: forces and moments.
        lines: springs, dampers, massless rods.
        traces: paths of points.
        joints: marks at the joints.
        series: quantities to plot.
        document: the texts around the picture.
        planar: whether the motion stays in planes parallel to x–z; such scenes are viewed from −y.
        ground: height of the ground [m]; None puts it below everything.
        bounds: shape (2, 3), the corners of the box the camera frames [m]; None frames the whole
            motion.
        engine: computes the motion in the page; None if the page shows this one alone.
        inspection: a description at rest to be looked into, in place of a motion.
        breaks: where contacts and cords cease to hold, in order of time.
    """

    title: str
    t: Floats
    bodies: tuple[SceneBody, ...]
    positions: Floats
    quaternions: Floats
    arrows: tuple[Arrow, ...] = ()
    lines: tuple[Line, ...] = ()
    traces: tuple[Trace, ...] = ()
    joints: tuple[JointMark, ...] = ()
    series: tuple[Series, ...] = ()
    document: Document = field(default_factory=Document)
    planar: bool = False
    ground: float | None = None
    bounds: Floats | None = None
    engine: Engine | None = None
    inspection: Inspection | None = None
    breaks: tuple[Break, ...] = ()

    def __post_init__(self) -> None:
        n, nb = np.size(self.t), len(self.bodies)
        times = _array(self.t, (n,), "t of a scene")
        if n == 0 or np.any(np.diff(times) <= 0):
            raise InputError("t of a scene: expected at least one instant, strictly increasing")
        object.__setattr__(self, "t", times)
        object.__setattr__(
            self, "positions", _array(self.positions, (n, nb, 3), "positions of a scene")
        )
        object.__setattr__(
            self, "quaternions", _continuous(_array(self.quaternions, (n, nb, 4), "quaternions"))
        )
        for arrow in self.arrows:
            _array(arrow.origin, (n, 3), f"origin of arrow {arrow.name!r}")
            _array(arrow.vector, (n, 3), f"vector of arrow {arrow.name!r}")
        for line in self.lines:
            _array(line.points, (n, 2, 3), f"points of line {line.name!r}")
        for trace in self.traces:
            _array(trace.points, (n, 3), f"points of trace {trace.name!r}")
        for series in self.series:
            _array(series.values, (n,), f"values of series {series.name!r}")
        for row in self.document.ledger.rows:
            _array(
                row.values, (n, len(self.document.ledger.coordinates)), f"ledger row {row.name!r}"
            )
        if self.bounds is not None:
            object.__setattr__(self, "bounds", _array(self.bounds, (2, 3), "bounds of a scene"))
        self._check_names()

    def _check_names(self) -> None:
        groups: dict[str, list[str]] = {
            "body": [each.name for each in self.bodies],
            "arrow": [each.name for each in self.arrows],
            "line": [each.name for each in self.lines],
            "trace": [each.name for each in self.traces],
            "joint": [each.name for each in self.joints],
            "series": [each.name for each in self.series],
        }
        for what, names in groups.items():
            if len(set(names)) < len(names):
                raise InputError(f"two of the scene's {what} names are equal: {sorted(names)}")
        seats = [(a.name, a.body) for a in self.arrows] + [(j.name, j.body) for j in self.joints]
        for name, body in seats:
            if body not in groups["body"]:
                raise InputError(f"{name!r} sits on {body!r}, which is no body of the scene")

    def frame(self, k: int) -> Frame:
        """Return the scene at its k-th instant."""
        ledger = [row.values[k] for row in self.document.ledger.rows]
        return Frame(
            t=float(self.t[k]),
            positions=self.positions[k],
            quaternions=self.quaternions[k],
            arrows=np.array([(a.origin[k], a.vector[k]) for a in self.arrows]).reshape(-1, 2, 3),
            lines=np.array([line.points[k] for line in self.lines]).reshape(-1, 2, 3),
            traces=np.array([trace.points[k] for trace in self.traces]).reshape(-1, 3),
            series=np.concatenate([np.array([s.values[k] for s in self.series]), *ledger]),
        )


def _array(values: Floats, shape: tuple[int, ...], what: str) -> Floats:
    found = np.asarray(values, dtype=np.float64)
    if found.shape != shape:
        raise InputError(f"{what}: expected shape {shape}, got {found.shape}")
    if not np.all(np.isfinite(found)):
        raise InputError(
            f"{what}: expected finite numbers, got {np.sum(~np.isfinite(found))} that are not"
        )
    return found


def _continuous(quaternions: Floats) -> Floats:
    """Normalize, and flip signs so that quaternions vary continuously in time."""
    norm = np.linalg.norm(quaternions, axis=-1, keepdims=True)
    if np.any(np.abs(norm - 1) > 1e-6):
        raise InputError(
            "quaternions: expected unit length, got lengths that differ from 1 by more than 1e-6"
        )
    unit: Floats = quaternions / norm
    turned = np.where(np.sum(unit[1:] * unit[:-1], axis=-1) < 0, -1.0, 1.0)
    unit[1:] *= np.cumprod(turned, axis=0)[..., None]
    return unit
