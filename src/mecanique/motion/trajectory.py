"""The states of a mechanism by time, and what follows from them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, fields, replace
from functools import cached_property, partial
from typing import TYPE_CHECKING, Any, final

import numpy as np

from mecanique.arrays import spread
from mecanique.errors import UnknownNameError
from mecanique.model import Contact, FloatingState, Mechanism, floating_state
from mecanique.model.mechanism.letters import to_name
from mecanique.motion.compile.along import StateLaw, StateSums
from mecanique.motion.record.curve import Curve, LaterCurve, State, Times
from mecanique.motion.record.events import Event, ModeSpan, Occurrence, Switches, break_names
from mecanique.motion.record.rates import Rates
from mecanique.motion.tolerances import SERIES_ROUNDING
from mecanique.wording import say_count

if TYPE_CHECKING:
    from mecanique.reference import Reference
    from mecanique.reference.engine.answers import PointMotion, Twist, Wrench


@final
@dataclass(frozen=True)
class Statistics:
    """Steps, evaluations and time of an integration.

    Args:
        steps: number of steps.
        evaluations: number of evaluations of the equations.
        seconds: time it took, the reference's construction included [s].
        rtol: relative tolerance of a step.
        atol: absolute tolerance of a step.
        share: part of these tolerances that each step was held to, because errors add up.
    """

    steps: int
    evaluations: int
    seconds: float
    rtol: float
    atol: float
    share: float = 1.0


_MARKS = ("", "'", "''")
"""What a coordinate's name is followed by for itself, its rate and its second rate."""


@dataclass(frozen=True, eq=False)
class Trajectory:
    """The states of a mechanism by time, and what its reference says of them: what a `Motion` is.

    Its arguments are those of `Motion`, which adds what audits, draws and stores it.
    """

    mechanism: Mechanism
    t: np.ndarray
    q: np.ndarray
    v: np.ndarray
    path: Curve | LaterCurve = field(repr=False)
    method: str
    statistics: Statistics
    events: tuple[Occurrence, ...] = ()
    watched: tuple[Event, ...] | None = field(default=None, repr=False)
    event_names: tuple[str, ...] | None = field(default=None, repr=False)
    engine: Reference | None = field(default=None, repr=False)
    rank: int | None = field(default=None, repr=False)
    modes: tuple[ModeSpan, ...] = ()
    corners: Switches | None = field(default=None, repr=False)

    def __post_init__(self) -> None:
        for array in (self.t, self.q, self.v):
            array.flags.writeable = False

    @cached_property
    def curve(self) -> Curve:
        """The motion as a function of time."""
        curve = self.path if isinstance(self.path, Curve) else self.path.make()
        for array in (curve.t, curve.q, curve.v, curve.a):
            array.flags.writeable = False
        return curve

    @property
    def reference(self) -> Reference:
        """The mechanism's `Reference`: the one given to `simulate`, or that of this thread."""
        if self.engine is not None:
            return self.engine
        from mecanique.reference import Reference

        return Reference.of(self.mechanism, self.rank)

    @cached_property
    def a(self) -> np.ndarray:
        """Accelerations at the samples, by the equations of motion, shape (n, nv)."""
        law = StateLaw(self.mechanism, self.reference)
        accelerations = law.accelerations(self.t, self.q, self.v)
        accelerations.flags.writeable = False
        return accelerations

    @property
    def described(self) -> Mechanism:
        """The mechanism as it was given to `simulate`, with its elements that switch."""
        return self.mechanism if self.corners is None else self.corners.mechanism

    @property
    def names(self) -> tuple[str, ...]:
        """Names that the motion knows: coordinates, velocities and accelerations."""
        m = self.mechanism
        return (*m.coordinates.names, *m.velocities, *(f"{name}'" for name in m.velocities))

    def __len__(self) -> int:
        return len(self.t)

    def __getitem__(self, name: str) -> np.ndarray:
        m, name = self.mechanism, to_name(self.mechanism, name)
        for names, values in ((m.coordinates.names, "q"), (m.velocities, "v")):
            if name in names:
                column: np.ndarray = getattr(self, values)[:, names.index(name)]
                return column
        if name.endswith("'") and name[:-1] in m.velocities:
            rates: np.ndarray = self.a[:, m.velocities.index(name[:-1])]
            return rates
        driven = [f"{follower}{marks}" for follower in m.coordinates.driven for marks in _MARKS]
        if name in driven:
            a = self.a if name.endswith("''") else None
            return self.reference.followers(self.q, self.v, a, self.t)[name]
        known = (*self.names, *driven)
        raise UnknownNameError("coordinate, velocity or acceleration", name, known)

    def __call__(self, t: Times) -> State:
        """Return the state at times within the motion, as (t, q, v).

        Args:
            t: a number, or shape (n,) [s].

        Raises:
            InputError: if a time is not within the motion.
        """
        state = self.curve(self.curve.admit(t))
        if not self.mechanism.constrained:
            return state
        return StateLaw(self.mechanism, self.reference).close(state)

    def poses(self, t: Times | None = None) -> np.ndarray:
        """Return the poses of all bodies in the world, in their order, shape (n, nb, 4, 4).

        They take 128 bytes a body and sample; of a million samples, that memory alone may take
        twice as long to fill as the motion took by Taylor series.

        Args:
            t: times [s]: a number, for shape (nb, 4, 4), or shape (n,); the samples' by default.
        """
        from mecanique.motion.compile.derive import poses_of

        def ask(t: np.ndarray, q: np.ndarray, v: np.ndarray) -> np.ndarray:
            return self.reference.poses(q, t).reshape(len(t), -1)

        poses = StateSums(self.mechanism, poses_of, ask)(*self._states(t))
        return _at(poses.reshape(len(poses), -1, 4, 4), t)

    def pose(self, body: str, t: Times | None = None) -> np.ndarray:
        """Return the poses of one body in the world, shape (n, 4, 4).

        Args:
            body: name of the body.
            t: times [s]: a number, for shape (4, 4), or shape (n,); the samples' by default.

        Raises:
            UnknownNameError: if there is no such body.
        """
        poses = self.poses(t)
        pose: np.ndarray = poses[..., self.mechanism.bodies.index(self.mechanism.body(body)), :, :]
        return pose

    def velocity(self, body: str, t: Times | None = None) -> Twist:
        """Return the velocities of a body's origin and its angular ones, (n, 3), world axes.

        Args:
            body: name of the body.
            t: times [s]: a number, for shape (3,), or shape (n,); the samples' by default.

        Raises:
            UnknownNameError: if there is no such body.
        """
        name = self.mechanism.body(body).name

        def ask(t: np.ndarray, q: np.ndarray, v: np.ndarray) -> np.ndarray:
            return np.hstack(self.reference.velocity(name, q, v, t))

        from mecanique.motion.compile.derive import twist_of
        from mecanique.reference.engine.answers import Twist

        write = partial(twist_of, body=name)
        moved = _at(StateSums(self.mechanism, write, ask)(*self._states(t)), t)
        return Twist(moved[..., :3], moved[..., 3:])

    def floating_state(self, t: Times | None = None, joint: str | None = None) -> FloatingState:
        """Return where a free body is, how it is turned and moves, in any convention.

        Args:
            t: times [s]: a number, for shape (3,), or shape (n,); the samples' by default.
            joint: name of the `Floating` or `Spherical` joint; not needed where there is one.

        Raises:
            InputError: if the mechanism has no such joint.
            UnknownNameError: if there is no joint of that name.
        """
        q, v = (_at(part, t) for part in self._states(t)[1:])
        return floating_state(self.mechanism, q, v, joint)

    def reactions(self, joint: str, t: Times | None = None) -> Wrench:
        """Return what a joint's parent does to its child: a `Wrench` of arrays of shape (n, 3).

        Of a loop: what body a does to body b. Of a contact: what is done to its body, about its
        center; zero while it is open.

        Args:
            joint: name of the joint, of a loop or of a contact.
            t: times, shape (n,) [s]; the samples' by default.

        Raises:
            UnknownNameError: if there is no such joint, loop or contact.
        """
        described = self.described
        switching = {} if self.corners is None else {e.name: e for e in described.switching}
        touching = {name: e for name, e in switching.items() if isinstance(e, Contact)}
        known = [part.name for part in described.joints]
        known += [part.name for part in (*described.loops, *described.contacts)]
        if joint not in (*known, *touching):
            raise UnknownNameError("joint, loop or contact", joint, [*known, *touching])
        if joint in touching:
            return self._wrench(touching[joint], t)
        if t is None:
            return self._reactions[joint]
        state = self(t)
        return self.reference.reactions(state.q, state.v, state.t)[joint]

    @cached_property
    def _reactions(self) -> dict[str, Wrench]:
        return StateLaw(self.mechanism, self.reference).reactions(self.t, self.q, self.v)

    def _wrench(self, contact: Contact, t: Times | None) -> Wrench:
        from mecanique.reference.engine.answers import BodyPoses, Wrench, name_components

        assert self.corners is not None, "its contacts switch"
        wrenches, loose, _ = self.corners.push(*self._states(t))
        pushed = _at(wrenches[contact.name], t)
        x, y, z = self.mechanism.evaluate_all(contact.center)
        return Wrench(
            pushed[..., :3],
            pushed[..., 3:],
            name_components(loose[contact.name]),
            parent=contact.on,
            child=contact.body,
            point=(x, y, z),
            body=contact.body,
            places=BodyPoses(lambda: {b.name: self.pose(b.name, t) for b in self.mechanism.bodies}),
        )

    def guide_forces(self, t: Times | None = None) -> dict[str, np.ndarray]:
        """Return the forces of the elements that guide, by name: tensions of cords, shape (n,) [N].

        Of stops, capstans and friction in joints, too, by their letters in `derive_modes`: N_wall,
        R_dry [N or N·m]; NaN where rigid bodies leave open how elements share what they hold.

        Args:
            t: times, shape (n,) [s]; the samples' by default.
        """
        states = self._states(t)
        forces = StateLaw(self.mechanism, self.reference).guide_forces(*states)
        if self.corners is not None:
            forces |= self.corners.push(*states)[2]
        return {name: _at(force, t) for name, force in forces.items()}

    def point(
        self, body: str, xyz: Sequence[float] = (0.0, 0.0, 0.0), t: Times | None = None
    ) -> PointMotion:
        """Return position, velocity, acceleration of a point of a body, shape (n, 3), world axes.

        Args:
            body: name of the body.
            xyz: shape (3,), in the body's frame [m].
            t: times, shape (n,) [s]; the samples' by default.

        Raises:
            UnknownNameError: if there is no such body.
        """
        from mecanique.motion.compile.derive import point_of
        from mecanique.reference.engine.answers import PointMotion, local_point

        name, place, states = self.mechanism.body(body).name, local_point(xyz), self._states(t)

        def ask(t: np.ndarray, q: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
            return np.hstack(self.reference.point(name, place, q, v, a, t))

        law = StateLaw(self.mechanism, self.reference)
        a = self.a if t is None else law.accelerations(*states)
        write = partial(point_of, body=name, xyz=place.tolist())
        moved = _at(StateSums(self.mechanism, write, ask)(*states, a), t)
        return PointMotion(moved[..., :3], moved[..., 3:6], moved[..., 6:])

    def times(self, event: str) -> np.ndarray:
        """Return when an event took place, shape (n,) [s].

        Args:
            event: its name.

        Raises:
            UnknownNameError: if no event of that name was watched for.
        """
        names = self.event_names
        if self.watched is not None:
            names = tuple(watched.name for watched in self.watched)
        if names is not None:
            happened = (occurrence.name for occurrence in self.events)
            known = (*names, *happened, *break_names(self.mechanism))
            if event not in known:
                raise UnknownNameError("event", event, known)
        return np.array([occurrence.t for occurrence in self.events if occurrence.name == event])

    def __repr__(self) -> str:
        span = f"t = {self.t[0]:g}…{self.t[-1]:g} s"
        return f"<Motion of {self.mechanism.name!r}: {say_count(len(self.t), 'sample')}, {span}>"

    def __getstate__(self) -> dict[str, Any]:
        state = {f.name: getattr(self, f.name) for f in fields(self)}
        # Pinocchio's work space is made again where it is needed
        return state | {"path": settle(self), "engine": None}

    def _states(self, t: Times | None) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Times, positions and velocities of the samples, or at times: one row at a single one."""
        if t is None:
            return self.t, self.q, self.v
        state = self(t)
        return np.atleast_1d(state.t), np.atleast_2d(state.q), np.atleast_2d(state.v)


def _at(values: np.ndarray, t: Times | None) -> np.ndarray:
    """Return values by state; those of the only state at a single time."""
    alone: np.ndarray = values if t is None or np.ndim(t) else values[0]
    return alone


PARTS = (2, 4, 8, 16)
"""Into how many parts a step is cut for polynomials through states; the first accurate one counts.
"""

TRIED = 2000
"""In the middle of so many of its intervals a curve is compared with the series."""

CLOSE = 10
"""A curve this many tolerances from the series is accurate."""


def settle(motion: Trajectory) -> Curve:
    """Return a motion's curve by polynomials alone, through enough states of its series."""
    curve, rtol = motion.curve, motion.statistics.rtol
    if curve.series is None:
        return curve
    law, settled = StateLaw(motion.mechanism, motion.reference), replace(curve, series=None)
    for parts in PARTS if len(curve.t) > 1 else ():
        lengths = np.diff(curve.t)[:, None] / parts
        inner = curve.t[:-1, None] + lengths * np.arange(parts)
        t, q, v = curve(np.append(inner.ravel(), curve.t[-1])).arrays
        settled = replace(settled, t=t, q=q, v=v, a=law.accelerations(t, q, v))
        middle = ((t[1:] + t[:-1]) / 2)[spread(len(t) - 1, TRIED)]
        ours, exact = (np.hstack(known(middle)[1:]) for known in (settled, curve))
        # not to the share of the tolerance that steps whose errors add up are taken to
        allowed = rtol + max(rtol, SERIES_ROUNDING) * np.abs(exact)
        if (np.abs(ours - exact) / allowed).max(initial=0.0) <= CLOSE:
            break
    return settled


def start_of(motion: Trajectory) -> State:
    """Return the state at a motion's start, which need not be among its samples."""
    if isinstance(motion.path, LaterCurve):
        return motion.path.start
    return State(float(motion.curve.t[0]), motion.curve.q[0], motion.curve.v[0])


def states_at(motion: Trajectory, t: np.ndarray) -> State:
    """Return the states at times [s]; where all are samples, without the curve."""
    at = np.searchsorted(motion.t, t).clip(max=len(motion.t) - 1)
    if np.array_equal(motion.t[at], t):
        return State(t, motion.q[at], motion.v[at])
    return motion.curve(t)


CLOSER = 8
"""Samples this many times closer than the steps tell all of a motion, without the curve.

Near a center of attraction the steps are shorter than on average.
"""


def steps_of(motion: Trajectory) -> Curve:
    """Return a curve through a motion's steps, or through samples that are much closer.

    Where the motion's own is yet to be made, which takes about as long as the motion, that between
    steps is less accurate than the steps, but no less than what is asked of all of them.
    """
    later = motion.path
    if not isinstance(later, LaterCurve) or "curve" in vars(motion):
        return motion.curve
    if later.through_steps is not None:
        return later.through_steps()
    span = later.end - float(later.start.t)
    most = float(np.diff(motion.t).max(initial=0.0)) * max(motion.statistics.steps, 1) / span
    whole = motion.t[0] == later.start.t and motion.t[-1] == later.end
    if not whole or most * CLOSER > 1:
        return motion.curve
    few = np.arange(0, len(motion.t), int(1 / (most * CLOSER)))
    few = few if few[-1] == len(motion.t) - 1 else np.append(few, len(motion.t) - 1)
    state = State(motion.t[few], motion.q[few], motion.v[few])
    a = StateLaw(motion.mechanism, motion.reference).accelerations(*state.arrays)
    return Curve(*state.arrays, a=a, breaks=np.array([0]), rates=Rates.of(motion.mechanism))


MOST_EVEN, MOST_BETWEEN = 1001, 100
"""Without steps of use a motion is looked at so often; between steps, in the middle of so many."""


def look_along(motion: Trajectory) -> Trajectory:
    """Return a motion sampled at its own steps and between some, however it was sampled.

    Implicit methods have no steps of use: the motion is then sampled evenly.
    """
    curve = steps_of(motion)
    if not curve.smooth:
        times = np.unique(np.linspace(curve.t[0], curve.t[-1], MOST_EVEN))
        return replace(motion, t=times, q=(state := motion(times)).q, v=state.v, path=curve)
    steps = at_steps(replace(motion, path=curve))
    starts = curve.intervals[spread(len(curve.intervals), MOST_BETWEEN)]
    between = curve((curve.t[starts] + curve.t[starts + 1]) / 2)
    if motion.mechanism.constrained:
        between = StateLaw(motion.mechanism, motion.reference).close(between)
    both = State(*map(np.concatenate, zip((steps.t, steps.q, steps.v), between, strict=True)))
    times, at = np.unique(both.t, return_index=True)
    return replace(steps, t=times, q=both.q[at], v=both.v[at])


def at_steps(motion: Trajectory) -> Trajectory:
    """Return a motion sampled at its steps; at a break, after it."""
    curve = motion.curve
    times, at = np.unique(curve.t[::-1], return_index=True)
    at = len(curve.t) - 1 - at
    return replace(motion, t=times, q=curve.q[at], v=curve.v[at], path=curve)


MOST_STEPS = 1000
"""With more steps than this, what is integrated along a motion is balanced in stretches."""

STRETCHES, LENGTH = 5, 40
"""Numbers of these and of the steps in each."""


def stretches_of(motion: Trajectory, length: int = LENGTH) -> list[Trajectory]:
    """Return a motion, or stretches of a long one that are spread over it, sampled at its steps."""
    curve, count = motion.curve, len(motion.curve.intervals)
    if count <= MOST_STEPS:
        return [motion]
    stretches = []
    for first in curve.intervals[spread(count - length + 1, STRETCHES)].tolist():
        events = tuple(event for event in motion.events if event.t > curve.t[first])
        part = replace(motion, path=curve.part(first, first + length + 1), events=events)
        stretches.append(at_steps(part))
    return stretches
