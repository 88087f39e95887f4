"""Put a mechanism on ground that turns with the earth.

The base turns about the earth's axis by rheonomic joints, exactly, at any angle and speed: Coriolis
and centrifugal effects follow from the equations of motion, not from formulas for small angles. The
axis is led through the world's origin. That leaves out the uniform part of the centrifugal
acceleration, the one that comes from the distance to the earth's axis, and rightly so: g as a plumb
line shows it, and as a mechanism's gravity states it, contains it already. Weights turn with the
ground. The earth's way around the sun and the tides are left out.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal, final

import numpy as np

from mecanique.errors import InputError, UnknownNameError
from mecanique.model import AnyForce, Body, Coordinates, Fixed, Force, Mechanism, Revolute, time
from mecanique.model.constraint_base import Strung
from mecanique.model.expression import finite
from mecanique.model.force_base import BodyLoad, FieldLoad
from mecanique.model.mechanism_units import characteristic_length, units
from mecanique.motion.analysis.extremes import find_maxima
from mecanique.motion.analysis.forces import Actions
from mecanique.motion.compile.along import StateLaw
from mecanique.motion.motion import Motion, simulate
from mecanique.motion.record.curve import find_crossings
from mecanique.motion.tolerances import INERTIAL_RTOL
from mecanique.wording import Legible

EARTH_RATE = 7.292115e-5
"""Rate of the earth's rotation [rad/s] (WGS 84, NIMA TR8350.2, 2000, table 3.1)."""

_AXES = {"south": (-1.0, 0.0), "east": (0.0, 1.0), "north": (1.0, 0.0), "west": (0.0, -1.0)}
"""Components of north along x and y, by where x points: y is then east, north, west, south."""


def on_turning_earth(
    mechanism: Mechanism,
    latitude: float,
    *,
    facing: Literal["south", "east", "north", "west"] = "south",
    rate: float = EARTH_RATE,
) -> Mechanism:
    """Return the mechanism on ground that turns with the earth [rad/s], in the same coordinates.

    The axis goes through the world's origin, and each body's weight is a force in the ground's
    axes: g contains the centrifugal acceleration that comes from the distance to the earth's axis.
    """
    latitude = finite(latitude, "the latitude")
    if not abs(latitude) <= np.pi / 2:
        raise InputError(
            f"expected a latitude within ±π/2 rad, got {latitude:g}; of degrees take numpy.radians"
        )
    if facing not in _AXES:
        raise InputError(f"expected facing among {', '.join(_AXES)}, got {facing!r}")
    along_x, along_y = (north * float(np.cos(latitude)) for north in _AXES[facing])
    things = (*mechanism.bodies, *mechanism.joints, *mechanism.forces)
    letters = (*mechanism.coordinates, *mechanism.coordinates.driven, *mechanism.values)
    signals = (signal.symbol for signal in mechanism.inputs)
    names = {*(thing.name for thing in things), *letters, *signals, "world"}
    stars, earth, place = (_free(name, names) for name in ("stars", "earth_turn", "place"))
    axis = (along_x, along_y, float(np.sin(latitude)))
    weights = []
    for body in mechanism.bodies:
        if body.name != mechanism.ground and mechanism.evaluate(body.mass) > 0:
            name = _free(f"weight of {body.name}", names)
            pull = tuple(body.mass * g for g in mechanism.gravity)
            weights.append(Force(name, body.name, body.center, pull, axes=place))
    forces = tuple(_turn(force, place) for force in mechanism.forces)
    elements = tuple(
        replace(element, axes=place)
        if isinstance(element, Strung) and element.axes == "world"
        else element
        for element in mechanism.elements
    )
    old = mechanism.coordinates
    return replace(
        mechanism,
        bodies=(Body(stars), *mechanism.bodies, Body(place)),
        joints=(
            Revolute(earth, stars, mechanism.ground, axis=axis, coordinate=earth),
            Fixed(place, mechanism.ground, place),
            *mechanism.joints,
        ),
        forces=(*forces, *weights),
        elements=elements,
        coordinates=Coordinates(old.names, {**old.driven, earth: rate * time()}, old.limits),
        gravity=(0.0, 0.0, 0.0),
        ground=stars,
    )


def _free(name: str, taken: set[str]) -> str:
    while name in taken:
        name += "_"
    return name


def _turn(force: AnyForce, place: str) -> AnyForce:
    """A force in world axes is one in the ground's axes now."""
    if isinstance(force, FieldLoad):
        raise InputError(
            f"potential field {force.name!r} is a function of places in the world, in which the "
            "ground now turns; expected a Force with its components"
        )
    if isinstance(force, BodyLoad) and force.wrench.axes == "world":
        fixed = {"axes": place}
        return replace(force, **fixed)
    return force


@final
@dataclass(frozen=True)
class InertialRow:
    """How much one quantity changes.

    Args:
        name: what it is.
        size: largest magnitude on ground that is at rest; of a coordinate, its range.
        change: largest change that the earth's rotation makes.
        unit: of both.
        time: when the change is largest [s]; of a period, the end of the motion.
    """

    name: str
    size: float
    change: float
    unit: str
    time: float

    @property
    def relative(self) -> float:
        """The change relative to the size; infinite if something arises from nothing."""
        if self.size > 0:
            return self.change / self.size
        return float("inf") if self.change > 0 else 0.0


@final
@dataclass(frozen=True, eq=False, repr=False)
class InertialCheck(Legible):
    """A motion on fixed ground compared with that on the rotating earth; its text is a table.

    Args:
        latitude: [rad].
        facing: where the world's x axis points.
        rate: of the earth's rotation [rad/s].
        rows: coordinates, reactions in the ground's axes, periods.
        still: the motion on ground at rest.
        turning: the motion on the turning earth.
        tolerance: relative change below which the ground counts as inertial.
        force: largest force on a body, also of a joint or its inertia, to compare forces with [N].
        length: what moments are compared with forces by, a typical length of the mechanism [m].

    Example:
        >>> pendulum = mq.textbook.load("rigid_bar_pendulum")
        >>> motion = mq.simulate(pendulum, q={"q": 0.5}, duration=1.0)
        >>> found = mq.inertial_check(pendulum, motion, latitude=0.8)
        >>> found.inertial, found.worst.name
        (True, 'moment in pin')
    """

    latitude: float
    facing: str
    rate: float
    rows: tuple[InertialRow, ...]
    still: Motion
    turning: Motion
    tolerance: float
    force: float
    length: float

    @property
    def worst(self) -> InertialRow:
        """The row of the largest relative change; values from zero count relative to their unit."""
        return max(self.rows, key=self._weight)

    @property
    def inertial(self) -> bool:
        """Whether every change is within the tolerance: the ground may be taken as inertial."""
        return self._weight(self.worst) <= self.tolerance

    def __getitem__(self, name: str) -> InertialRow:
        for row in self.rows:
            if row.name == name:
                return row
        raise UnknownNameError("row", name, (row.name for row in self.rows))

    def _weight(self, row: InertialRow) -> float:
        return row.change / self._scale(row)

    def _scale(self, row: InertialRow) -> float:
        alike = max(peer.size for peer in self.rows if peer.unit == row.unit)
        # a reaction may arise where there was none: it is small beside what acts on the bodies
        acting = {"N": self.force, "N·m": self.length * self.force}
        size = max(alike, acting.get(row.unit, 0.0))
        # if nothing in this unit changes on ground at rest, the size of the mechanism or 1 counts
        whole = self.length if row.unit == "m" else 1.0
        return size if size > INERTIAL_RTOL * whole else whole

    def __str__(self) -> str:
        width = max(len(row.name) for row in self.rows)
        span = self.still.t[-1] - self.still.t[0]
        lines = [
            f"{self.still.mechanism.name} on the earth at latitude "
            f"{np.degrees(self.latitude):.6g}°, "
            f"x {self.facing}, z up, over {span:.6g} s",
            f"{'quantity':<{width}}  {'size':>16}  {'change':>16}  {'relative':>9}  at t [s]",
        ]
        for row in self.rows:
            rounding = INERTIAL_RTOL * self._scale(row)
            size, change = (
                f"{x if x > rounding else 0:.4g} {row.unit}".rstrip()
                for x in (row.size, row.change)
            )
            lines.append(
                f"{row.name:<{width}}  {size:>16}  {change:>16}  {self._weight(row):9.1e}  "
                f"{row.time:.4g}"
            )
        word = "may" if self.inertial else "may not"
        lines.append(
            f"The ground {word} be taken as inertial within {self.tolerance:g}: "
            f"the most is {self._weight(self.worst):.2g}, in {self.worst.name}."
        )
        lines.append(
            "g contains the centrifugal acceleration of the place; "
            "the rest of the rotation is exact."
        )
        return "\n".join(lines)


def inertial_check(
    mechanism: Mechanism,
    motion: Motion,
    latitude: float,
    *,
    facing: Literal["south", "east", "north", "west"] = "south",
    tolerance: float = 1e-3,
    rate: float = EARTH_RATE,
) -> InertialCheck:
    """Judge whether the ground may be taken as inertial, by integrating on the turning earth.

    Both motions start in the same state relative to the ground. World axes: z up, x where `facing`
    says.

    Args:
        mechanism: what moves; its gravity is that of the place, as measured.
        motion: how it moved.
        latitude: [rad], positive in the north.
        facing: where the world's x axis points.
        tolerance: relative change below which the ground counts as inertial.
        rate: of the earth's rotation [rad/s].

    Returns:
        How the two motions differ.

    Raises:
        InputError: if the latitude is not within ±π/2, or the motion is another mechanism's.
        IntegrationError: if a motion stops before its end.

    Example:
        >>> pendulum = mq.textbook.load("rigid_bar_pendulum")
        >>> motion = mq.simulate(pendulum, q={"q": 0.5}, duration=1.0)
        >>> mq.inertial_check(pendulum, motion, latitude=0.8).inertial
        True
    """
    mechanism.refuse_switching("what follows on the turning earth is not looked for")
    turned = on_turning_earth(mechanism, latitude, facing=facing, rate=rate)
    tolerance = finite(tolerance, "the tolerance")
    if not tolerance > 0:
        raise InputError(f"expected a positive tolerance, got {tolerance:g}")
    if not isinstance(motion, Motion) or motion.mechanism != mechanism:
        raise InputError(
            f"expected a motion of {mechanism.name!r}, as simulate returns it, got {motion!r}"
        )

    def again(which: Mechanism) -> Motion:
        return simulate(
            which,
            q=motion.q[0],
            v=motion.v[0],
            t0=float(motion.t[0]),
            duration=float(motion.t[-1] - motion.t[0]),
            samples=motion.t,
            rtol=INERTIAL_RTOL,
            method="dop853" if motion.method.startswith("dop853") else "auto",
            events=motion.watched or (),
        )

    still, turning = again(mechanism), again(turned)
    rows = [*_list_rows(still, turning, turned), *_period_rows(still, turning)]
    return InertialCheck(
        latitude=float(latitude),
        facing=facing,
        rate=rate,
        rows=tuple(rows),
        still=still,
        turning=turning,
        tolerance=tolerance,
        force=max([_find_largest_force(still), *(row.size for row in rows if row.unit == "N")]),
        length=float(characteristic_length(mechanism)),
    )


def _list_rows(still: Motion, turning: Motion, turned: Mechanism) -> list[InertialRow]:
    """Changes of coordinates and of reactions, these in the ground's axes, at their largest."""
    mechanism, unit = still.mechanism, units(still.mechanism)
    joints = [j.name for j in mechanism.joints if j.name not in still.reference.guided]
    ground = [body.name for body in turned.bodies].index(turned.joints[0].child)
    end = float(turning.curve.t[-1])
    laws = StateLaw(mechanism, still.reference), StateLaw(turned, turning.reference)

    def measure(t: np.ndarray, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        there = turning.curve(t.clip(max=end))
        poses = turning.reference.poses(there.q, there.t)
        back = poses[:, ground, :3, :3].transpose(0, 2, 1)
        at_rest, on_earth = laws[0].reactions(t, q, v), laws[1].reactions(t, there.q, there.v)
        columns = [q, -q, np.abs(there.q - q)]
        for name in joints:
            for what in ("force", "moment"):
                before = getattr(at_rest[name], what)
                after = np.einsum("nij,nj->ni", back, getattr(on_earth[name], what))
                columns += [np.linalg.norm(x, axis=1)[:, None] for x in (before, after - before)]
        values = np.hstack(columns)
        values[t > end] = np.nan
        return values

    most = find_maxima(still.curve, measure)
    sizes, times = most.values, most.times
    highest, lowest, changes = sizes[: 3 * mechanism.nq].reshape(3, -1)
    when = times[2 * mechanism.nq : 3 * mechanism.nq]
    rows = [
        InertialRow(name, float(high + low), float(change), unit[name], float(t))
        for name, high, low, change, t in zip(
            mechanism.coordinates, highest, lowest, changes, when, strict=True
        )
    ]
    names = [(f"{what} in {name}", what) for name in joints for what in ("force", "moment")]
    pairs, when = sizes[3 * mechanism.nq :].reshape(-1, 2), times[3 * mechanism.nq + 1 :: 2]
    rows += [
        InertialRow(name, float(size), float(change), "N" if what == "force" else "N·m", float(t))
        for (name, what), (size, change), t in zip(names, pairs, when, strict=True)
        if max(size, change) > 1e-12
    ]
    return rows


def _find_largest_force(motion: Motion) -> float:
    """Return the largest of all forces and inertia forces along a motion [N]."""
    actions = Actions(motion.mechanism, motion.reference)
    law = StateLaw(motion.mechanism, motion.reference)

    def measure(t: np.ndarray, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        inertia = actions.inertia(t, q, v, law.accelerations(t, q, v))
        acting = [*actions.applied(t, q, v), *inertia]
        sizes = [np.linalg.norm(action.force, axis=1) for action in acting]
        largest: np.ndarray = np.column_stack([np.zeros(len(t)), *sizes]).max(axis=1)
        return largest[:, None]

    return float(find_maxima(motion.curve, measure).values[0])


def _period_rows(still: Motion, turning: Motion) -> list[InertialRow]:
    """Changes of the mean time between maxima, of coordinates that have some."""
    rows: list[InertialRow] = []
    rates = {name[:-1] for name in still.mechanism.velocities}
    for name in (name for name in still.mechanism.coordinates if name in rates):
        before, after = (_maxima(motion, name) for motion in (still, turning))
        count = min(len(before), len(after)) - 1
        if count > 0:
            first, second = ((times[count] - times[0]) / count for times in (before, after))
            end = float(still.t[-1])
            rows.append(InertialRow(f"period of {name}", first, abs(second - first), "s", end))
    return rows


def _maxima(motion: Motion, name: str) -> list[float]:
    """When a coordinate is largest, to rounding."""
    k, curve = motion.mechanism.velocities.index(f"{name}'"), motion.curve
    place = curve.q[:, motion.mechanism.coordinates.index(name)]
    if np.ptp(place) < 1e-9 * (1 + np.abs(place).max()):
        return []
    (crossings,) = find_crossings(curve, lambda t, q, v: v[:, k : k + 1])
    return [crossing.t for crossing in crossings if crossing.sign < 0]
