"""A scene: everything the page and the live view show, as plain arrays and texts."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Literal, TypeAlias, final

import numpy as np
from numpy.typing import NDArray

from mecanique.errors import InputError
from mecanique.model.bodies.visuals import GeometryKind
from mecanique.model.placement import pose_at
from mecanique.viewing.scene.inspection import Inspection


@final
@dataclass(frozen=True)
class DerivationStep:
    """A step of a derivation."""

    heading: str  # plain text; may be empty
    body: str
    note: str = ""  # a sentence below it; may be empty
    final: bool = False
    lead: str = ""  # a sentence above it; may be empty
    held: tuple[tuple[str, str], ...] = ()  # when it holds: words, and a formula or ""


@final
@dataclass(frozen=True)
class ShownDerivation:
    """The derivation of the equations of motion by one method."""

    method: str
    blocks: tuple[DerivationStep, ...]
    latex: str = ""  # the equations of motion in LaTeX, to be copied; empty if there are none
    listed: bool = False


@final
@dataclass(frozen=True)
class VerdictTable:
    """The outcome of comparing the derivation with the reference."""

    agrees: bool | None = None  # whether all quantities agree; None if nothing was compared
    headline: str = ""
    columns: tuple[str, ...] = ()
    rows: tuple[tuple[str, ...], ...] = ()
    notes: tuple[str, ...] = ()
    own: tuple[tuple[str, str], ...] = ()
    own_note: str = ""


@final
@dataclass(frozen=True)
class Knob:
    """A parameter, or an initial value."""

    name: str
    symbol: str
    value: float
    unit: str = ""  # empty if it has none
    meaning: str = ""
    low: float = 0.0  # least value a live view offers; equal to `high` if it cannot be changed
    high: float = 0.0


@final
@dataclass(frozen=True, eq=False)
class LedgerRow:
    """A force's virtual work, coordinate by coordinate, over time."""

    name: str
    kind: str
    displacement: str
    values: NDArray[np.float64]


@final
@dataclass(frozen=True, eq=False)
class WorkLedger:
    """The principle of virtual work, row by row; each column sums to zero."""

    coordinates: tuple[str, ...] = ()
    units: tuple[str, ...] = ()
    rows: tuple[LedgerRow, ...] = ()


@final
@dataclass(frozen=True, eq=False)
class SceneText:
    """The texts of a page."""

    subtitle: str = ""
    about: str = ""  # what the system is, in sentences; empty if nothing is known
    source: str = ""  # author, work, page; empty if there is none
    figure: str = ""  # the system as a line figure, SVG text; empty if there is none
    symbols: tuple[tuple[str, str], ...] = ()
    derivations: tuple[ShownDerivation, ...] = ()
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
    """A shape whose size or place follows the parameters."""

    body: int
    shape: int  # number of the shape among those of the body that are no meshes
    size: tuple[float, ...]  # what it is drawn with: edges, radius and length, or radius [m]


@final
@dataclass(frozen=True)
class Bound:
    """What ends a motion or sends it back: a number that passes zero."""

    words: str
    direction: int
    must: str = ""  # what a start beyond it violates; "" if a motion may start there
    restitution: float | None = None


@final
@dataclass(frozen=True)
class Condition:
    """What numbers that depend on the parameters must be, see `model.statements.NumberRule`."""

    kind: Literal["finite", "gap", "inertia"]
    where: str
    words: tuple[str, ...]
    count: int
    strict: bool = False
    follows: bool = False  # whether it means something only if the condition before it is kept


@final
@dataclass(frozen=True)
class PageElement:
    """An element that switches, by the numbers of its rows."""

    name: str
    normal: int | None
    tangents: tuple[int, ...]
    pressing: int | None  # the row whose force its friction goes by
    struck: bool = False  # whether it has impacts
    in_turn: bool = False
    by_impulse: bool = False  # whether by Poisson's law
    ends: bool = False  # whether its side has ends


@final
@dataclass(frozen=True)
class PageModes:
    """What a page must know of the elements whose modes it solves."""

    elements: tuple[PageElement, ...]
    positional: tuple[bool, ...]  # whether a row is the rate of a gap
    forces: int  # how many of the last parameters are forces of elements
    length: float  # that of the mechanism [m]
    tolerances: dict[str, float]
    losses: tuple[str, ...] = ()  # numbers of the state after the work: what each has taken


@final
@dataclass(frozen=True)
class PageProgram:
    """A mechanism's program in JavaScript, and the start of its motion."""

    # functions (t, y, p, out): rates (of the state, and the work done), row (every number of the
    # scene, a rotation's nine entries for a quaternion), shapes; with loops closure (gap, its rate,
    # Jacobian) and tree (mass matrix and load without them); with bounds bounds and gradients; with
    # conditions rules; with contacts or cords margins, what each has left; with elements that
    # switch terms, press (their forces on bodies, by those along rows), and an impact of each

    script: str
    coordinates: tuple[str, ...]
    velocities: tuple[str, ...]
    parameters: tuple[str, ...]
    values: tuple[float, ...]
    start: tuple[float, ...]  # shape (nq + nv,), the state at the start
    first: float  # time at the start [s]
    duration: float  # length of the motion [s]
    rtol: float
    quaternions: tuple[int, ...] = ()
    loops: int = 0
    restrained: tuple[int, ...] = ()
    unknown: tuple[int, ...] = ()  # columns of the scene's table that the program does not know
    resized: tuple[Resized, ...] = ()  # shapes that follow the parameters
    bounds: tuple[Bound, ...] = ()
    conditions: tuple[Condition, ...] = ()
    holding: tuple[str, ...] = ()
    endless: bool = False
    switching: PageModes | None = None
    python: str = ""
    options: tuple[str, ...] = ()


Floats: TypeAlias = NDArray[np.float64]
Rgba: TypeAlias = tuple[float, float, float, float]
ArrowKind: TypeAlias = Literal["weight", "spring", "damper", "load", "reaction", "inertia"]
ArrowUnit: TypeAlias = Literal["N", "N·m"]
LineKind: TypeAlias = Literal["spring", "damper", "rod", "pull"]

GREY: Rgba = (0.55, 0.58, 0.62, 1.0)
_SIZES = {"box": 3, "cylinder": 2, "sphere": 1, "mesh": 3}


@final
@dataclass(frozen=True, eq=False)
class SceneShape:
    """A solid at its place in a body."""

    kind: GeometryKind
    size: tuple[float, ...]
    pose: Floats = field(default_factory=pose_at)  # shape (4, 4), in the body's frame
    rgba: Rgba | None = GREY  # None keeps the colors of a mesh
    path: Path | None = None
    form: str = ""  # what a cylinder stands for, if that is a ring or a cone

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
    """A body and how it looks."""

    name: str
    shapes: tuple[SceneShape, ...] = ()


@final
@dataclass(frozen=True, eq=False)
class Arrow:
    """A force or a moment over time, in world axes."""

    name: str
    kind: ArrowKind
    body: str
    origin: Floats  # shape (n, 3), point of application [m]
    vector: Floats  # shape (n, 3), in units of `unit`
    unit: ArrowUnit = "N"


@final
@dataclass(frozen=True, eq=False)
class DrawnLine:
    """Something drawn between two moving points: a spring, a damper, a massless rod."""

    name: str
    kind: LineKind
    points: Floats  # shape (n, 2, 3), both ends over time [m]


@final
@dataclass(frozen=True, eq=False)
class Trace:
    """The path that a point traces."""

    name: str
    points: Floats  # shape (n, 3) [m]


@final
@dataclass(frozen=True, eq=False)
class JointMark:
    """A joint, marked where it sits in its child body."""

    name: str
    kind: str
    body: str
    point: tuple[float, float, float] = (0.0, 0.0, 0.0)
    axis: tuple[float, float, float] = (0.0, 0.0, 0.0)
    foot: tuple[
        float, ...
    ] = ()  # of a pin on the ground: its place there, and where its foot points


@final
@dataclass(frozen=True, eq=False)
class Plot:
    """A quantity over time, to be plotted."""

    name: str
    label: str
    unit: str  # e.g. "rad/s"; empty if it has none
    values: Floats  # shape (n,)
    group: str = ""
    shown: bool = False


@final
@dataclass(frozen=True)
class Break:
    """Where a contact or a cord ceases to hold: what moves on from there is no real mechanism."""

    name: str
    t: float  # when [s]


@final
@dataclass(frozen=True)
class ModeStrip:
    """The states an element that switches went through."""

    name: str
    spans: tuple[tuple[float, float, str], ...]  # begin and end [s], and the state between
    impacts: tuple[float, ...] = ()  # when it was struck [s]


@final
@dataclass(frozen=True, eq=False)
class SceneFrame:
    """A scene at one instant."""

    t: float  # time [s]
    row: Floats  # of the scene's table


ColumnKind: TypeAlias = Literal["body", "arrow", "line", "trace", "coordinate", "series", "work"]

PLACES: dict[ColumnKind, tuple[int, ...]] = {"arrow": (0,), "line": (0, 3), "trace": (0,)}
"""Where among the columns of what is drawn on bodies the places of points begin."""


@final
@dataclass(frozen=True, eq=False)
class Columns:
    """The numbers over time of one thing in a scene."""

    kind: ColumnKind
    name: str
    values: Floats  # shape (n, columns): of a body x, y, z and its quaternion
    unit: str = ""  # of a curve


@final
@dataclass(frozen=True, eq=False)
class Scene:
    """A motion ready to be shown."""

    title: str
    t: Floats  # shape (n,), increasing [s]; n = 1 is a still
    bodies: tuple[SceneBody, ...]
    positions: Floats  # shape (n, nb, 3), the bodies' origins in the world [m]
    quaternions: Floats  # shape (n, nb, 4), x, y, z, w
    arrows: tuple[Arrow, ...] = ()
    lines: tuple[DrawnLine, ...] = ()
    traces: tuple[Trace, ...] = ()
    joints: tuple[JointMark, ...] = ()
    series: tuple[Plot, ...] = ()
    document: SceneText = field(default_factory=SceneText)
    planar: bool = False
    ground: float | None = None  # height of the ground [m]; None puts it below everything
    bounds: Floats | None = None
    engine: PageProgram | None = None
    inspection: Inspection | None = None
    breaks: tuple[Break, ...] = ()
    modes: tuple[ModeStrip, ...] = ()

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

    @cached_property
    def columns(self) -> tuple[Columns, ...]:
        """Everything that moves, in the order of the table."""
        poses = np.concatenate([self.positions, self.quaternions], axis=2)
        parts = [Columns("body", body.name, poses[:, k]) for k, body in enumerate(self.bodies)]
        for arrow in self.arrows:
            parts.append(Columns("arrow", arrow.name, np.hstack([arrow.origin, arrow.vector])))
        for line in self.lines:
            parts.append(Columns("line", line.name, line.points.reshape(-1, 6)))
        parts += [Columns("trace", trace.name, trace.points) for trace in self.traces]
        for curve in self.series:
            kind: ColumnKind = "coordinate" if curve.group == "Coordinates" else "series"
            parts.append(Columns(kind, curve.name, curve.values[:, None], curve.unit))
        parts += [Columns("work", row.name, row.values) for row in self.document.ledger.rows]
        return tuple(parts)

    @cached_property
    def table(self) -> Floats:
        """All columns side by side, shape (n, columns)."""
        none = np.zeros((len(self.t), 0))
        return np.concatenate([none, *(part.values for part in self.columns)], axis=1)

    @cached_property
    def traced(self) -> NDArray[np.bool_]:
        """Which columns are places on traces, shape (columns,)."""
        widths = [part.values.shape[1] for part in self.columns]
        return np.repeat([part.kind == "trace" for part in self.columns], widths)

    def frame(self, k: int) -> SceneFrame:
        """Return the scene at its k-th instant."""
        return SceneFrame(float(self.t[k]), self.table[k])


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
