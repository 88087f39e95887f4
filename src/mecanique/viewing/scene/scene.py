"""A scene: everything the page and the live view show, as plain arrays and texts."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Literal, TypeAlias, final

import numpy as np
from numpy.typing import NDArray

from mecanique.errors import InputError
from mecanique.viewing.scene.inspection import Inspection


@final
@dataclass(frozen=True)
class DerivationStep:
    """A step of a derivation.

    Args:
        heading: plain text; may be empty.
        body: MathML, or plain text.
        note: a sentence below it; may be empty.
        final: whether it is the final result.
        lead: a sentence above it; may be empty.
    """

    heading: str
    body: str
    note: str = ""
    final: bool = False
    lead: str = ""


@final
@dataclass(frozen=True)
class Derivation:
    """The derivation of the equations of motion by one method.

    Args:
        method: e.g. "Lagrange".
        blocks: its steps, in order.
        latex: the equations of motion in LaTeX, to be copied; empty if there are none.
        listed: whether they are a list of named results, because a closed form is too long.
    """

    method: str
    blocks: tuple[DerivationStep, ...]
    latex: str = ""
    listed: bool = False


@final
@dataclass(frozen=True)
class VerdictTable:
    """The outcome of comparing the derivation with the reference.

    Args:
        agrees: whether all quantities agree; None if nothing was compared.
        headline: one sentence.
        columns: the heads of the table.
        rows: its cells, as text.
        notes: sentences below it: likely causes, versions, the seed.
        own: what the program of the page itself differs by: quantities and numbers.
        own_note: how it was compared.
    """

    agrees: bool | None = None
    headline: str = ""
    columns: tuple[str, ...] = ()
    rows: tuple[tuple[str, ...], ...] = ()
    notes: tuple[str, ...] = ()
    own: tuple[tuple[str, str], ...] = ()
    own_note: str = ""


@final
@dataclass(frozen=True)
class Knob:
    """A parameter, or an initial value.

    Args:
        name: unique among its kind.
        symbol: MathML or plain text.
        value: in units of `unit`.
        unit: empty if it has none.
        meaning: a few words.
        low: least value a live view offers; equal to `high` if it cannot be changed.
        high: greatest value.
    """

    name: str
    symbol: str
    value: float
    unit: str = ""
    meaning: str = ""
    low: float = 0.0
    high: float = 0.0


@final
@dataclass(frozen=True, eq=False)
class LedgerRow:
    """A force's virtual work, coordinate by coordinate, over time.

    Args:
        name: the force.
        kind: as in `Arrow.kind`.
        displacement: the virtual displacement it works along: MathML or plain text.
        values: shape (n, nc), its contribution to the generalized force of each coordinate.
    """

    name: str
    kind: str
    displacement: str
    values: NDArray[np.float64]


@final
@dataclass(frozen=True, eq=False)
class WorkLedger:
    """The principle of virtual work, row by row; each column sums to zero.

    Args:
        coordinates: nc symbols, MathML or plain text.
        units: nc units of the generalized forces.
        rows: the forces, d'Alembert's included.
    """

    coordinates: tuple[str, ...] = ()
    units: tuple[str, ...] = ()
    rows: tuple[LedgerRow, ...] = ()


@final
@dataclass(frozen=True, eq=False)
class SceneText:
    """The texts of a page.

    Args:
        subtitle: one line below the title: what the system is.
        about: what the system is, in sentences; empty if nothing is known.
        source: author, work, page; empty if there is none.
        figure: the system as a line figure, SVG text; empty if there is none.
        symbols: each symbol of the equations, MathML, and what it means.
        derivations: method by method.
        verdict: what the comparison found.
        parameters: with their values and units.
        initial: initial values, with sliders in a live view.
        freedom: sentences on the count of degrees of freedom.
        ledger: the virtual work of each force.
        urdf: the mechanism as URDF text.
        file_name: stem of the files that can be saved from the page.
        undetermined: sentences on the forces that are not determined, and why.
        method: how the motion was computed.
        recorded: why the page shows a recorded motion and cannot compute another; empty if it can.
    """

    subtitle: str = ""
    about: str = ""
    source: str = ""
    figure: str = ""
    symbols: tuple[tuple[str, str], ...] = ()
    derivations: tuple[Derivation, ...] = ()
    verdict: VerdictTable = field(default_factory=VerdictTable)
    parameters: tuple[Knob, ...] = ()
    initial: tuple[Knob, ...] = ()
    freedom: tuple[str, ...] = ()
    ledger: WorkLedger = field(default_factory=WorkLedger)
    urdf: str = ""
    file_name: str = "mechanism"
    undetermined: tuple[str, ...] = ()
    method: str = ""
    recorded: str = ""


@final
@dataclass(frozen=True)
class Resized:
    """A shape whose size or place follows the parameters.

    Args:
        body: number of the body.
        shape: number of the shape among those of the body that are no meshes.
        size: what it is drawn with: edges, radius and length, or radius [m].
    """

    body: int
    shape: int
    size: tuple[float, ...]


@final
@dataclass(frozen=True)
class Bound:
    """What ends a motion or sends it back: a number that passes zero.

    Args:
        words: where that is, e.g. "where x comes to its limit h".
        direction: +1 for rising through zero, −1 for falling, 0 for both.
        must: what a start beyond it violates; "" if a motion may start there.
        restitution: of an impact there, after which the motion continues; None if it ends.
    """

    words: str
    direction: int
    must: str = ""
    restitution: float | None = None


@final
@dataclass(frozen=True)
class Condition:
    """What numbers that depend on the parameters must be, see `mechanism.rules.Rule`.

    Args:
        kind: of numbers that are finite, of a gap that is their last, or of a mass and an inertia.
        where: what they belong to.
        words: the fault if they are not so, with a {} for each number; two of an inertia.
        count: how many numbers there are.
        strict: whether a gap must be above 0.
        follows: whether it means something only if the condition before it is kept.
    """

    kind: Literal["finite", "gap", "inertia"]
    where: str
    words: tuple[str, ...]
    count: int
    strict: bool = False
    follows: bool = False


@final
@dataclass(frozen=True)
class PageProgram:
    """A mechanism's program in JavaScript, and the start of its motion.

    The program is the text of functions (t, y, p, out): `rates` of the state and of the work done;
    `row`, every number of the scene in the order of its table, with the nine entries of a rotation
    in place of a quaternion; `shapes`, sizes and places of what follows the parameters; with loops
    `closure`, what they miss, its rate and the rows of its Jacobian; with bounds `bounds`, the
    number that passes zero and how near counts as reached, for each, and `gradients`, for each
    impact, its slopes over time and coordinates; with conditions
    `rules`, the numbers of each; where contacts or cords may cease to hold
    `margins`, three forces a, b, c for each: what it has left is a − √(b² + c²).

    Args:
        script: the text of the functions.
        coordinates: names, in order.
        velocities: names, in order.
        parameters: names, in the order of p.
        values: of the parameters.
        start: shape (nq + nv,), the state at the start.
        first: time at the start [s].
        duration: length of the motion [s].
        rtol: relative tolerance of a step.
        quaternions: where the quaternions stand in the state.
        loops: number of equations that close loops, hold contacts and restrain velocities.
        restrained: which of them restrain velocities alone.
        unknown: columns of the scene's table that the program does not know.
        resized: shapes that follow the parameters.
        bounds: what ends a motion or sends it back.
        conditions: what the numbers of a sound mechanism keep to.
        holding: what would happen where each of the margins passes zero, e.g. "rim would pull".
        endless: whether the motion continues beyond its end.
        python: text of the Python that makes the mechanism, e.g. 'mq.textbook.load("crane")'.
        options: further arguments of `simulate`, e.g. 'limits="stop"'.
    """

    script: str
    coordinates: tuple[str, ...]
    velocities: tuple[str, ...]
    parameters: tuple[str, ...]
    values: tuple[float, ...]
    start: tuple[float, ...]
    first: float
    duration: float
    rtol: float
    quaternions: tuple[int, ...] = ()
    loops: int = 0
    restrained: tuple[int, ...] = ()
    unknown: tuple[int, ...] = ()
    resized: tuple[Resized, ...] = ()
    bounds: tuple[Bound, ...] = ()
    conditions: tuple[Condition, ...] = ()
    holding: tuple[str, ...] = ()
    endless: bool = False
    python: str = ""
    options: tuple[str, ...] = ()


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
class Plot:
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
class SceneFrame:
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
    series: tuple[Plot, ...] = ()
    document: SceneText = field(default_factory=SceneText)
    planar: bool = False
    ground: float | None = None
    bounds: Floats | None = None
    engine: PageProgram | None = None
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
            "body": [part.name for part in self.bodies],
            "arrow": [part.name for part in self.arrows],
            "line": [part.name for part in self.lines],
            "trace": [part.name for part in self.traces],
            "joint": [part.name for part in self.joints],
            "series": [part.name for part in self.series],
        }
        for what, names in groups.items():
            if len(set(names)) < len(names):
                raise InputError(f"two of the scene's {what} names are equal: {sorted(names)}")
        seats = [(a.name, a.body) for a in self.arrows] + [(j.name, j.body) for j in self.joints]
        for name, body in seats:
            if body not in groups["body"]:
                raise InputError(f"{name!r} sits on {body!r}, which is no body of the scene")

    def frame(self, k: int) -> SceneFrame:
        """Return the scene at its k-th instant."""
        ledger = [row.values[k] for row in self.document.ledger.rows]
        return SceneFrame(
            t=float(self.t[k]),
            positions=self.positions[k],
            quaternions=self.quaternions[k],
            arrows=np.array([(a.origin[k], a.vector[k]) for a in self.arrows]).reshape(-1, 2, 3),
            lines=np.array([line.points[k] for line in self.lines]).reshape(-1, 2, 3),
            traces=np.array([trace.points[k] for trace in self.traces]).reshape(-1, 3),
            series=np.concatenate([np.array([s.values[k] for s in self.series]), *ledger]),
        )


def _array(values: Floats, shape: tuple[int, ...], what: str) -> Floats:
    array = np.asarray(values, dtype=np.float64)
    if array.shape != shape:
        raise InputError(f"{what}: expected shape {shape}, got {array.shape}")
    if not np.all(np.isfinite(array)):
        raise InputError(
            f"{what}: expected finite numbers, got {np.sum(~np.isfinite(array))} that are not"
        )
    return array


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
