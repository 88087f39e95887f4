"""Simulate a mechanism, and ask questions of its motion."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from os import PathLike
from time import perf_counter
from typing import TYPE_CHECKING, final

import numpy as np

from mecanique.errors import UnknownNameError
from mecanique.model.mechanism import Mechanism
from mecanique.model.states import list_left_out
from mecanique.model.values import Given, whole
from mecanique.motion.analysis.audit import Audit, audit
from mecanique.motion.analysis.energies import Energies, energies, losses
from mecanique.motion.output.plot import plot
from mecanique.motion.output.report import summary
from mecanique.motion.output.storage import load, save, to_csv, to_frame, to_parquet
from mecanique.motion.record.curve import Curve, LaterCurve, Times
from mecanique.motion.record.events import Event, ModeSpan, Occurrence, break_names
from mecanique.motion.record.loops import ClosedLoops, begin_on_loops
from mecanique.motion.simulation.choice import COMPILED
from mecanique.motion.simulation.integrate import (
    failure,
    integrate_by_choice,
    refuse_corners,
    refuse_indefinite,
)
from mecanique.motion.simulation.integrators.methods import METHODS, step_accuracy
from mecanique.motion.simulation.problem import (
    Course,
    Integration,
    Problem,
    longest_step,
    refuse_still,
    sample_times,
    span_and_tolerances,
)
from mecanique.motion.simulation.watching import (
    joint_events,
    limit_events,
    record_events,
    refuse_limit,
    report_end,
)
from mecanique.motion.switching.holding import Holding
from mecanique.motion.trajectory import Statistics, Trajectory
from mecanique.notebook import draw
from mecanique.threads import one_thread_for_loops

if TYPE_CHECKING:
    import pandas
    from matplotlib.figure import Figure

    from mecanique.reference import Reference


@final
@dataclass(frozen=True, eq=False, repr=False)
class Motion(Trajectory):
    """The motion of a mechanism, as `simulate` returns it.

    `motion["q"]`, `motion["q'"]` and `motion["q''"]` are the samples of a coordinate, its velocity
    and acceleration, also of a joint that follows the coordinate map; `motion(t)` is the state at
    any time, as accurate as the integration.

    Args:
        mechanism: what moved.
        t: shape (n,), times of the samples [s].
        q: shape (n, nq), positions.
        v: shape (n, nv), velocities.
        path: the motion as a function of time, or what gives it when it is asked for.
        method: which method integrated it and why.
        statistics: what that took.
        events: what took place, in order of time.
        watched: the events that were watched for; None if that is not known, as of a file.
        event_names: their names where these alone are known.
        engine: the mechanism's `Reference`, if one was given.
        rank: how many of the loops' constraints are independent, if that is known.
        modes: which states its elements that switch were in, and when.
        corners: those elements and their forces; None if there are none, or of a file.

    Example:
        >>> pendulum = mq.textbook.load("rigid_bar_pendulum")
        >>> motion = mq.simulate(pendulum, q={"q": 0.1}, duration=2.0)
        >>> motion(0.5).q.round(3)
        array([-0.034])
        >>> motion.reactions("pin", [0.5]).force.round(3)
        array([[0.252, 0.   , 9.867]])
    """

    def energy(self, t: Times | None = None) -> Energies:
        """Return the energies, and the work that changed them.

        Work that has no potential is an integral over six states of each step. Where the motion was
        integrated by Taylor series, which takes a third of a microsecond a step, that may take
        four times as long as the motion; otherwise it takes a part of it.

        Args:
            t: times, shape (n,) [s]; the samples' by default.
        """
        if t is None:
            return self._energies
        times = np.atleast_1d(self.curve.admit(t))
        return energies(self, times)

    @cached_property
    def _energies(self) -> Energies:
        return energies(self, self.t)

    def losses(self, t: Times | None = None) -> dict[str, np.ndarray]:
        """Return what friction and impacts have turned into heat since the start [J].

        By name: "dry: friction" of an element that rubs, "wall: impact" of one that is struck. A
        motion read from a file knows its impacts alone.

        Args:
            t: times, shape (n,) [s]; the samples' by default.

        Returns:
            The energies lost, each of shape (n,).

        Example:
            >>> ball = mq.textbook.load("bouncing_ball")
            >>> motion = mq.simulate(ball, q={"z": 1.0}, duration=5.0)
            >>> motion.losses([5.0])["floor: impact"].round(6)
            array([9.80665])
        """
        return losses(self, self.t if t is None else np.atleast_1d(self.curve.admit(t)))

    def audit(self, *, refine: bool = False, accuracy: float = 1e-6) -> Audit:
        """Check the motion against the balances of energy and momentum.

        It looks at the motion's own steps and between 100 of them, so that what it says does not
        depend on the samples. Momenta, and work that has no potential, of a motion of more than
        1,000 steps are balanced in five stretches, each from its own start, of 67 steps for momenta
        and of 40 for work. It takes about as long as the motion, and up to four times as long where
        a compiled motion meets loops or contacts, which are met anew in every state.

        Args:
            refine: also integrate again with a smaller tolerance, to find until when the motion can
                be trusted, and balance both along the whole motion; it takes longer than that.
            accuracy: the error that is then accepted, relative to the largest coordinate.
        """
        return audit(self, refine=refine, accuracy=accuracy)

    def summary(self) -> str:
        """Return a summary: mechanism, duration, method, energy balance, and range of each value.

        Of a motion of 1,200 steps or more it says how far the values at its end may be off, by
        integrating once more to four times its tolerance, which takes less time than it did. One by
        Taylor series keeps no steps: where its samples are sparse it is integrated twice, which may
        take half as long again as the motion did.
        """
        return summary(self)

    def save(self, path: str | PathLike[str]) -> None:
        """Write the motion to an npz file, whole or not at all.

        Args:
            path: the file; ".npz" is added if it has no ending.

        Raises:
            InputError: if the file cannot be written.
        """
        save(self, path)

    @staticmethod
    def load(path: str | PathLike[str], mechanism: Mechanism | None = None) -> Motion:
        """Read a motion that `save` wrote.

        Args:
            path: the file.
            mechanism: what moved; not needed for a system of the catalogue.

        Raises:
            InputError: if the file is no motion, or another mechanism's.
        """
        return load(path, mechanism, Motion)

    def to_csv(self, path: str | PathLike[str]) -> None:
        """Write t, q, v and a to a CSV file, with units in the header.

        All digits of a number take half a microsecond, a million samples longer than many a motion;
        `save` and `to_parquet` are quicker.

        Args:
            path: the file.

        Raises:
            InputError: if the file cannot be written.
        """
        to_csv(self, path)

    def to_parquet(self, path: str | PathLike[str]) -> None:
        """Write t, q, v and a to a Parquet file, with the units in the schema's metadata.

        Args:
            path: the file.

        Raises:
            InputError: if pyarrow is not installed, or the file cannot be written.
        """
        to_parquet(self, path)

    def to_frame(self) -> pandas.DataFrame:
        """Return t (as index), q, v and a as a pandas DataFrame.

        Raises:
            InputError: if pandas is not installed.
        """
        return to_frame(self)

    def plot(self, what: str = "coordinates", joint: str | None = None) -> Figure:
        """Plot the motion; return the matplotlib Figure.

        Args:
            what: "coordinates", "phase", "energies" or "reactions".
            joint: for "reactions", the joint; the first by default.

        Raises:
            InputError: if matplotlib is not installed, or there is no such plot.
        """
        figure: Figure = plot(self, what, joint)
        return figure

    def _repr_html_(self) -> str | None:
        return draw("motion", self)


@one_thread_for_loops
def simulate(
    mechanism: Mechanism,
    *,
    q: Given = None,
    v: Given = None,
    duration: float = 10.0,
    rtol: float = 1e-10,
    atol: float | None = None,
    method: str = "auto",
    fps: float = 60.0,
    samples: int | Sequence[float] | np.ndarray | None = None,
    t0: float = 0.0,
    max_step: float | None = None,
    max_steps: int = 1_000_000,
    events: Sequence[Event] = (),
    limits: str | float | None = None,
    progress: Callable[[float], object] | None = None,
    reference: Reference | None = None,
) -> Motion:
    """Integrate a mechanism's equations of motion.

    The accelerations are the reference's, or those of the closed form derived in-house once both
    have been compared. Loops are closed at the start, what is given by name staying as it is if
    that is possible, and kept closed by projection. The motion is accurate to the tolerance at any
    time, not only at the samples. Where what rolls would pull at its plane or slip, or a cord would
    have to push, an event of the motion says so, e.g. "rim would pull"; `contact_events` stop it.

    Args:
        mechanism: what moves.
        q: positions at the start: shape (nq,) or by coordinate name, zero where left out.
        v: velocities at the start: shape (nv,) or by name (q or q'), zero where left out. What a
            mapping leaves out is named, with its value at the start, in the motion's `method`.
        duration: how long [s].
        rtol: relative tolerance of each step, in 1e-14…1e-1; where it is 1e-10 or less and dop853
            would take more than 10,000 steps, their tolerance is smaller, because their errors add
            up.
        atol: absolute tolerance of each step, in the units of q and v; as rtol by default.
        method: "auto"; or one of "dop853", "lsoda", "radau", "bdf", on the reference's equations;
            or "closed_form" (dop853 on the closed form), "taylor" (Taylor series of the closed
            form, extra `fast`) or "compiled" (dop853 in C, with a C compiler), which compile first
            and then are faster; not "taylor" where there are loops. "auto" takes dop853 and
            changes to radau if the equations turn out to be stiff, or to a faster method if this
            motion takes long enough to pay for compiling; what ran before has no part in it, so
            that the same call gives the same numbers. To use for many short motions what is
            compiled once, ask for "closed_form" or "taylor"; the latter optimizes its code, which
            then rounds otherwise, once motions of the mechanism have taken 50,000 steps.
        fps: samples per second of the resulting arrays; the last sample is at the end exactly.
        samples: instead of fps, the number of samples, or their times [s], shape (n,).
        t0: time at the start [s].
        max_step: longest step [s]; by default not bounded, but a fiftieth of the duration where an
            input is a function or events are watched.
        max_steps: most steps.
        events: what to watch for.
        limits: what happens where a joint reaches its limits: nothing by default, "stop" ends the
            motion, and a number in 0…1 is the coefficient of restitution of an impact there.
        progress: called with the fraction done, in 0…1, about a hundred times.
        reference: a `Reference` of the mechanism to use and keep; by default that of this thread,
            which is loaded once as long as the mechanism lives.

    Returns:
        The motion, at the steps taken and in between.

    Raises:
        InputError: if an argument is not what is expected, the mechanism cannot move, or what the
            method asked for needs is not installed.
        UnknownNameError: if a coordinate, velocity, method or name in an event does not exist.
        ClosureError: if the loops cannot be closed at the start.
        DerivationError: if the method asked for needs a closed form and there is none.
        IntegrationError: if the integration stops before its end, also by Ctrl-C; it carries the
            motion until then. If an inertia that no real body has makes the mass matrix indefinite
            somewhere on the way, it names the bodies.

    Example:
        >>> motion = mq.simulate(mq.textbook.load('free_particle'), v={'x': 2.0}, duration=1.0)
        >>> round(float(motion['x'][-1]), 6)
        2.0
    """
    begin = perf_counter()
    refuse_still(mechanism)
    t0, end, rtol, atol = span_and_tolerances(t0, duration, rtol, atol)
    corners = None
    if mechanism.switching:
        from mecanique.motion.switching.corners import Corners

        corners = Corners(mechanism, rtol)
        refuse_corners(mechanism, method, reference)
        mechanism = corners.rows.base
    start = np.concatenate([mechanism.position(q), mechanism.velocity(v)])
    times = sample_times(t0, end, fps, samples)
    if method not in ("auto", *METHODS, *COMPILED):
        raise UnknownNameError("method", method, ("auto", *METHODS, *COMPILED))
    max_steps = whole(max_steps, "max_steps")
    events = (*events, *joint_events(mechanism, start, limits))
    ends = limit_events(mechanism, start)
    watched = (*events, *ends)
    longest = longest_step(mechanism, end - t0, max_step, watched)
    shared = reference is not None
    if reference is None:
        from mecanique.reference import Reference

        reference = Reference.of(mechanism)
    refuse_indefinite(reference, np.array([t0]), start[None, : mechanism.nq])
    reference, start, remark = begin_on_loops(reference, q, v, t0)
    started: list[Occurrence] = []
    if corners is not None:
        start, started = corners.begin(t0, start)
        watched = (*watched, *corners.events)
    rank = None if reference.closed is None else reference.closed.most
    remark += list_left_out(mechanism, q, v, start, rank)
    loops = ClosedLoops(reference, rtol) if mechanism.constrained else None
    problem = Problem(
        mechanism=mechanism,
        reference=reference,
        loops=loops if corners is None else corners,
        start=start,
        t0=t0,
        end=end,
        times=times,
        rtol=rtol,
        atol=atol,
        max_step=longest,
        max_steps=max_steps,
        events=watched,
        ends=ends,
        progress=progress,
        corners=corners,
    )

    choice, integration = integrate_by_choice(problem, method)
    if integration.course is None:
        raise failure(problem, integration, None, q)
    share = integration.rtol / step_accuracy(problem)[0]
    if share < 1.0:
        remark += f"; steps to {integration.rtol:.1e}, because the errors of so many add up"
    statistics = Statistics(
        steps=integration.steps,
        evaluations=integration.evaluations,
        seconds=perf_counter() - begin,
        rtol=rtol,
        atol=atol,
        share=share,
    )
    course = integration.course()
    path, happened = course.path, course.events
    modes: tuple[ModeSpan, ...] = ()
    if isinstance(path, LaterCurve) and (events or break_names(mechanism)):
        path = path.make()
    if corners is not None:
        path = path if isinstance(path, Curve) else path.make()
        # an impact at the start is over when the motion begins
        happened += tuple(replace(event, v=event.after) for event in started)
        modes = corners.spans(float(path.t[-1]))
        mechanism, shared = corners.as_loads(path), False
    if isinstance(path, Curve):
        known = Holding(mechanism, reference if shared else None)
        happened += record_events(events, known, path)
    motion = Motion(
        mechanism,
        t=np.asarray(course.samples.t),
        q=course.samples.q,
        v=course.samples.v,
        path=path,
        method=choice.title + remark,
        statistics=statistics,
        events=tuple(sorted(happened, key=lambda occurrence: occurrence.t)),
        watched=tuple(events),
        engine=reference if shared else None,
        rank=rank,
        modes=modes,
        corners=corners,
    )
    integration = _cut_short(integration, course, motion)
    if not integration.outcome.complete:
        raise failure(problem, integration, motion, q)
    refuse_indefinite(reference, motion.t, motion.q)
    refuse_limit(motion)
    report_end(progress, motion)
    return motion


def _cut_short(integration: Integration, course: Course, motion: Motion) -> Integration:
    """Return how the integration ended; earlier if its course could not be followed to the end."""
    if course.outcome is None:
        return integration
    y = np.concatenate([motion.q[-1], motion.v[-1]])
    return replace(integration, outcome=course.outcome, t=float(motion.t[-1]), y=y)
