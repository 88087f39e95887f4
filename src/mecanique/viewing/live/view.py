"""Show a motion live in a browser on this machine."""

from __future__ import annotations

import math
import queue
import threading
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import replace
from typing import Any, final

import numpy as np

from mecanique.derivation import derive, readable
from mecanique.errors import InputError, IntegrationError, MecaniqueError
from mecanique.model.mechanism import Mechanism
from mecanique.model.mechanism.origin import Finding
from mecanique.model.quaternions import from_matrices
from mecanique.motion.motion import Motion
from mecanique.motion.simulation.problem import Values
from mecanique.urdf.lint import lint
from mecanique.verification import verify
from mecanique.viewing.engine import add_row, equip, is_cut_short, judge_page, refuse
from mecanique.viewing.live.live import Changes, LiveView
from mecanique.viewing.scene.drawn import bodies_of, marks_of, title_of
from mecanique.viewing.scene.from_motion import actions_of, fit, names_of, scene_of
from mecanique.viewing.scene.inspection import Inspection, inspection_of
from mecanique.viewing.scene.scene import (
    Scene,
    SceneFrame,
    SceneText,
    ShownDerivation,
    VerdictTable,
)
from mecanique.viewing.scene.texts import derivation_of, document_of, fits_page, ledger_of, table_of
from mecanique.wording import say_count

MOST_DERIVED = 8
"""Above this number of velocities the equations are compared, but not written out."""

Found = Callable[[tuple[ShownDerivation, ...], VerdictTable], None]

Proof = Callable[[VerdictTable], VerdictTable]

WAITING = VerdictTable(headline="checking …")


def pending(mechanism: Mechanism, document: SceneText) -> SceneText:
    """Return a document that says that equations and verdict are on their way."""
    waiting = ShownDerivation("Being derived …", ())
    derivations = (waiting,) if mechanism.nv <= MOST_DERIVED else ()
    return replace(document, derivations=derivations, verdict=WAITING)


@final
class Checking:
    """Derives a mechanism's equations and compares them, in a thread of its own."""

    def __init__(
        self, mechanism: Mechanism, settings: Found, prove: Proof = lambda table: table
    ) -> None:
        self._mechanism = mechanism
        self._found = settings
        self._prove = prove
        self._lock = threading.Lock()
        self._cancelled = False
        self._thread = threading.Thread(target=self._run, name="mecanique check", daemon=True)
        self._thread.start()

    def cancel(self) -> None:
        """Report nothing more; the computation ends at its next step."""
        with self._lock:
            self._cancelled = True

    def finish(self, seconds: float) -> None:
        """Cancel, and wait for the thread."""
        self.cancel()
        self._thread.join(seconds)

    def _run(self) -> None:
        derivations: tuple[ShownDerivation, ...] = ()
        try:
            written_out = self._mechanism.nv <= MOST_DERIVED
            for method in readable(self._mechanism) if written_out else ():
                if self._cancelled:
                    return
                with suppress(MecaniqueError):
                    equations = derive(self._mechanism, method)
                    derivations += (derivation_of(equations),)
                    if not fits_page(equations):
                        break  # the other methods cannot be written out either
            if derivations:
                self._tell(derivations, WAITING)
            if not self._cancelled:
                verdict = table_of(verify(self._mechanism))
                self._tell(derivations, verdict)
                if verdict.agrees and not self._cancelled:
                    self._tell(derivations, self._prove(verdict))
        except Exception as error:  # a page must not wait forever: it says why there is no verdict
            kind = "" if isinstance(error, MecaniqueError) else f"{type(error).__name__}: "
            self._tell(derivations, VerdictTable(headline=f"not checked: {kind}{error}"))

    def _tell(self, derivations: tuple[ShownDerivation, ...], verdict: VerdictTable) -> None:
        # under the lock, so that nothing arrives once `cancel` has returned
        with self._lock:
            if not self._cancelled:
                self._found(derivations, verdict)


STRETCH = 0.5
"""Length of a stretch at the speed at which it is shown [s of wall time]."""

FIRST = 2.0
"""Length of the first stretch of a small mechanism, which sets the frame of the picture."""

PATIENCE = 1.0
"""A stretch that takes longer to compute is cut short, so that something moves [s]."""

FOR_PROGRAMS = "; the motion until then is in the error's .motion"
"""The end of an error's message, meant for code that catches it; a page shows that motion."""


def density(speed: float) -> float:
    """Return the samples per second of motion that smooth pictures need at a speed."""
    return 60 / min(speed, 4.0)


def compute(check: Callable[[], None] | None = None, **arguments: Any) -> Motion:
    """Return a stretch of a motion, short enough to be computed without a noticeable wait."""
    from mecanique.motion import simulate

    latest = time.monotonic() + PATIENCE

    def progress(_: float) -> None:
        if check is not None:
            check()
        if time.monotonic() > latest:
            raise _EnoughError

    try:
        return simulate(progress=progress, **arguments)
    except IntegrationError as error:
        done: Motion | None = error.motion
        if isinstance(error.__cause__, _EnoughError) and done is not None and len(done.t) > 1:
            return done
        raise


def compute_first(**arguments: Any) -> tuple[Motion, str]:
    """Return the first stretch of a motion, and why it stops before its end; "" if it does not."""
    try:
        return compute(**arguments), ""
    except IntegrationError as error:
        if error.motion is None or len(error.motion.t) < 2:
            raise
        return error.motion, f"The motion stops here: {str(error).removesuffix(FOR_PROGRAMS)}"


@final
class Stretches:
    """The complete scenes that follow a first stretch of a motion, one after the other."""

    def __init__(self, first: Motion, end: float, speed: Callable[[], float] = lambda: 1.0) -> None:
        self._motion = first
        self._end = end
        self._speed = speed
        self._work = float(first.energy().work[-1])
        self._done: queue.Queue[Scene | Exception | None] = queue.Queue(maxsize=1)
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._run, name="mecanique integration", daemon=True)

    def __iter__(self) -> Iterator[Scene]:
        """Yield the scenes."""
        self._thread.start()
        try:
            while True:
                # short waits, so that Ctrl-C works on every system
                try:
                    made = self._done.get(timeout=0.2)
                except queue.Empty:
                    continue
                if made is None:
                    return
                if isinstance(made, Exception):
                    raise made
                yield made
        finally:
            self._stop.set()
            self._thread.join(timeout=5)

    def _run(self) -> None:
        try:
            while self._end - self._motion.t[-1] > 1e-9:
                last = self._motion
                t0 = float(last.t[-1])
                speed = self._speed()
                self._motion = compute(
                    self._check,
                    mechanism=last.described,
                    q=last.q[-1],
                    v=last.v[-1],
                    t0=t0,
                    duration=min(STRETCH * speed, self._end - t0),
                    rtol=last.statistics.rtol,
                    fps=density(speed),
                )
                self._give(self._stage(self._motion))
            self._give(None)
        except _StoppedError:
            return
        except Exception as error:  # raised again where the motion is shown
            self._finish(error)

    def _finish(self, error: Exception) -> None:
        """Hand over what was computed before the error, then the error."""
        try:
            done = getattr(error, "motion", None)
            if done is not None and len(done.t) > 1:
                self._give(self._stage(done))
            self._give(error)
        except _StoppedError:
            return

    def _stage(self, motion: Motion) -> Scene:
        actions = actions_of(motion)
        scene = scene_of(motion, SceneText(ledger=ledger_of(motion, actions)), actions)
        work, self._work = self._work, self._work + float(motion.energy().work[-1])
        series = (
            replace(s, values=s.values + work) if s.name == "energy work" else s
            for s in scene.series
        )
        return replace(scene, series=tuple(series))

    def _check(self) -> None:
        if self._stop.is_set():
            raise _StoppedError

    def _give(self, made: Scene | Exception | None) -> None:
        while True:
            self._check()
            try:
                self._done.put(made, timeout=0.1)
            except queue.Full:
                continue
            return


class _StoppedError(Exception):
    """Nobody is watching any more."""


class _EnoughError(Exception):
    """The motion computed so far is to be shown first."""


@final
class Presenter:
    """Keep open pages up to date across restarts; derive in the background."""

    def __init__(self, mechanism: Mechanism, complete: Scene) -> None:
        self._mechanism = mechanism
        self._names = names_of(complete)
        self._parameters = _values(mechanism)
        self._checking: Checking | None = None
        self.scene = fit(complete, self._names)

    def check(self, live: LiveView) -> None:
        """Derive and compare what moves, unless this has already begun."""
        if self._checking is None:
            self._checking = Checking(self._mechanism, live.annotate)

    def begin(self, live: LiveView, mechanism: Mechanism, complete: Scene) -> Scene:
        """Return the start of a motion as the view shows it."""
        parameters = _values(mechanism)
        if parameters != self._parameters:
            self._mechanism, self._parameters, self._names = (
                mechanism,
                parameters,
                names_of(complete),
            )
            if self._checking:
                self._checking.cancel()
            self._checking = None
            shown = fit(complete, self._names)
            live.show(shown)
        else:
            shown = self.go_on(live, complete)
        self.check(live)
        return shown

    def go_on(self, live: LiveView, complete: Scene) -> Scene:
        """Return a later stretch as the view shows it."""
        names = self._names | names_of(complete)
        shown = fit(complete, names)
        if names != self._names:
            # a force that acts for the first time is not yet part of the scene
            self._names, before = names, live.scene
            document = replace(before.document, ledger=shown.document.ledger)
            planar = shown.planar and before.planar
            live.show(
                replace(shown, document=document, bounds=before.bounds, planar=planar), keep=True
            )
        return shown

    def close(self) -> None:
        """Cancel the derivation in progress."""
        if self._checking:
            self._checking.finish(2.0)


def _values(mechanism: Mechanism) -> dict[str, float]:
    return {parameter.symbol: parameter.value for parameter in mechanism.parameters}


MOST_AHEAD = 8
"""Above this number of velocities a live view starts with a short stretch, to start at once."""


@final
class LiveMotion:
    """What moves from its start, computed as it is shown; or a motion, till values change."""

    def __init__(
        self,
        shown: Mechanism | Motion,
        q: Values | None = None,
        v: Values | None = None,
        end: float = math.inf,
        rtol: float = 1e-10,
        speed: float = 1.0,
    ) -> None:
        self._end, self._rtol, self._speed = end, rtol, speed
        if isinstance(shown, Motion):
            self._end, self._rtol = float(shown.t[-1]), shown.statistics.rtol
            self._subtitle = ""
            self._restart = shown
        else:
            length = "" if math.isinf(end) else f"{end:g} s, "
            self._subtitle = f"{length}computed while it is shown"
            self._restart = self._start(shown, q, v)
        self._first = _stage(self._restart, self._subtitle)
        self.presenter = Presenter(self._restart.mechanism, self._first)

    def frames(self, live: LiveView, changes: Changes) -> Iterator[SceneFrame]:
        """Yield the motion's instants; the page reports what cannot be computed."""
        live.warn("")
        ending = "There is no motion"
        try:
            motion, scene = self._restart, self._first
            if changes:
                self._speed = live.speed
                motion = self._start(*_restart(motion, changes), t0=float(motion.t[0]))
                scene = _stage(motion, self._subtitle)
            shown = self.presenter.begin(live, motion.mechanism, scene)
            ending = "The motion stops here"
            yield from (shown.frame(k) for k in range(len(shown.t)))
            for complete in Stretches(motion, self._end, lambda: live.speed):
                shown = self.presenter.go_on(live, complete)
                yield from (shown.frame(k) for k in range(1, len(shown.t)))
        except MecaniqueError as error:
            # a reset or the next change starts anew
            live.warn(f"{ending}: {str(error).removesuffix(FOR_PROGRAMS)}")

    def _start(
        self, mechanism: Mechanism, q: Values | None, v: Values | None, t0: float = 0.0
    ) -> Motion:
        length = (FIRST if mechanism.nv <= MOST_AHEAD else STRETCH) * min(self._speed, 1.0)
        # what stops the motion is reported when the next stretch cannot start
        motion, _ = compute_first(
            mechanism=mechanism,
            q=q,
            v=v,
            t0=t0,
            duration=min(length, self._end - t0),
            rtol=self._rtol,
            fps=density(self._speed),
        )
        return motion


def _restart(
    motion: Motion, changes: Changes
) -> tuple[Mechanism, dict[str, float], dict[str, float]]:
    """A motion's mechanism and start with the values set on the page."""
    parameters = {name: value for (kind, name), value in changes.items() if kind == "parameter"}
    mechanism = motion.mechanism.replace(**parameters) if parameters else motion.mechanism
    q = dict(zip(mechanism.coordinates, motion.q[0].tolist(), strict=True))
    v = dict(zip(mechanism.velocities, motion.v[0].tolist(), strict=True))
    for (kind, name), value in changes.items():
        if kind == "initial":
            (q if name in q else v)[name] = value
    return mechanism, q, v


def _stage(motion: Motion, subtitle: str = "") -> Scene:
    """A complete scene with its texts, except those that take long to compute."""
    actions = actions_of(motion)
    document = pending(motion.mechanism, document_of(motion, (), None, actions))
    return scene_of(motion, replace(document, subtitle=subtitle or document.subtitle), actions)


SHOWN = 10.0
"""Length of a motion without end that the page computes at first [s], at the speed of nature."""


@final
class Computing:
    """A motion with the engine of its page; equations and verdict arrive while it moves."""

    def __init__(
        self, motion: Motion, end: float, rtol: float, speed: float, remark: str = ""
    ) -> None:
        mechanism = motion.mechanism
        refuse(mechanism)
        actions = actions_of(motion)
        document = pending(mechanism, document_of(motion, (), None, actions))
        scene, self._maker = equip(motion, document, actions, derive(mechanism))
        assert scene.engine is not None
        endless = math.isinf(end)
        duration = SHOWN * min(speed, 1.0) if endless else end - float(motion.t[0])
        engine = replace(scene.engine, duration=duration, rtol=rtol, endless=endless)
        whole = end <= float(motion.t[-1])
        document = replace(scene.document, method=scene.document.method if whole else "")
        self.scene: Scene = replace(scene, engine=engine, document=document)
        self._mechanism = mechanism
        self._remark = remark
        self._checking: Checking | None = None

    def check(self, live: LiveView) -> None:
        """Derive and compare what moves, and then the page's program, in the background."""
        if self._remark:
            live.warn(self._remark)
        self._checking = Checking(self._mechanism, live.annotate, self._prove)

    def close(self) -> None:
        """Cancel the derivation in progress."""
        if self._checking:
            self._checking.finish(2.0)

    def _prove(self, table: VerdictTable) -> VerdictTable:
        try:
            return add_row(table, judge_page(self._maker))
        except MecaniqueError as error:
            return replace(table, agrees=False, headline=f"the program of this page: {error}")


def begin(
    shown: Motion | Mechanism,
    q: Mapping[str, float] | Sequence[float] | None,
    v: Mapping[str, float] | Sequence[float] | None,
    end: float,
    rtol: float,
    speed: float,
) -> Computing | None:
    """Return a motion that its page computes, or None where the page cannot."""
    remark = ""
    if isinstance(shown, Motion):
        motion, end, rtol = shown, float(shown.t[-1]), shown.statistics.rtol
    else:
        try:
            refuse(shown)
        except MecaniqueError:
            return None
        length = min(FIRST * min(speed, 1.0), end)
        motion, remark = compute_first(
            mechanism=shown, q=q, v=v, duration=length, rtol=rtol, fps=density(speed)
        )
        if is_cut_short(motion):
            remark = ""  # the page finds that by itself
        elif remark:
            end = float(motion.t[-1])
    try:
        return Computing(motion, end, rtol, speed, remark)
    except MecaniqueError:
        return None


def view(
    shown: Motion | Mechanism,
    *,
    q: Mapping[str, float] | Sequence[float] | None = None,
    v: Mapping[str, float] | Sequence[float] | None = None,
    duration: float | None = None,
    rtol: float = 1e-10,
    speed: float = 1.0,
    port: int = 0,
    open_browser: bool = True,
) -> None:
    """Show a motion live in a browser on this machine, until Ctrl-C or the end of the process.

    The page is the one `export` writes: it computes the motion by itself, and equations and verdict
    arrive while it moves. What a page cannot compute (more than 12 velocities, inputs that are
    functions of Python) is computed here and streamed; it starts when the first page shows it, and
    again when parameters or initial values change in the page. The server answers on 127.0.0.1
    only, under a random token.

    Args:
        shown: a mechanism, or what `simulate` returned.
        q: a mechanism's position at the start: by coordinate name or shape (nq,).
        v: its velocity at the start: by name or shape (nv,).
        duration: how long it moves [s]; without end by default.
        rtol: relative tolerance of each step of a mechanism's integration.
        speed: seconds shown per second.
        port: 0 takes any free port.
        open_browser: whether to open the page; its address is printed in any case.

    Raises:
        InputError: if the port is taken, speed or duration is not above 0, or it is neither motion
            nor mechanism.
        MecaniqueError: if the mechanism's motion cannot start.

    Example:
        >>> mq.view(mq.textbook.load("double_pendulum"), q={"q1": 2.0}, open_browser=False)
    """
    if not 0 < speed < float("inf"):
        raise InputError(f"expected a speed above 0, got {speed!r}")
    if isinstance(shown, Mechanism):
        if duration is not None and not 0 < duration < float("inf"):
            raise InputError(f"expected a duration above 0, or None for no end, got {duration!r}")
    elif not (q is None and v is None and duration is None):
        raise InputError("q, v and duration belong to a mechanism; a motion has its own")
    elif not isinstance(shown, Motion):
        raise InputError(
            f"expected a Motion, as simulate returns it, or a Mechanism, got {type(shown).__name__}"
        )
    end = float("inf") if duration is None else duration
    computing = begin(shown, q, v, end, rtol, speed)
    if computing:
        _show(computing, None, port, open_browser, speed)
        return
    motion = LiveMotion(shown, q, v, end, rtol, speed)
    _show(motion.presenter, motion, port, open_browser, speed)


def _show(
    shown: Computing | Presenter,
    streamed: LiveMotion | None,
    port: int,
    open_browser: bool,
    speed: float,
) -> None:
    """Serve a page that computes its motion by itself, or stream one that is computed here."""

    def frames(changes: Changes) -> Iterable[SceneFrame]:
        return streamed.frames(live, changes) if streamed else ()

    with LiveView(shown.scene, port=port, open_browser=open_browser, at_once=True) as live:
        try:
            live.announce()
            shown.check(live)
            if streamed:
                # a page takes its time to load, but shows the motion from its start
                live.wait()
            live.stream(frames, speed=speed, hold=True)
        except KeyboardInterrupt:
            return
        finally:
            shown.close()


def inspect(
    mechanism: Mechanism,
    findings: Sequence[Finding] | None = None,
    *,
    q: Mapping[str, float] | Sequence[float] | None = None,
    port: int = 0,
    open_browser: bool = True,
) -> None:
    """Show a description at rest in a browser, with its findings beside it, until Ctrl-C.

    Sliders move the joints. Centers of mass, ellipsoids of inertia and the axes of joints are shown
    on request; links with an error or a warning are tinted. Nothing is simulated or derived.

    Args:
        mechanism: what `read_urdf` returned, or any mechanism.
        findings: what `lint` returned; by default the text it was read from is checked.
        q: where it stands at first: by coordinate name or shape (nq,).
        port: 0 takes any free port.
        open_browser: whether to open the page; its address is printed in any case.

    Raises:
        InputError: if it is no mechanism, or the port is taken.

    Example:
        >>> mq.inspect(mq.read_urdf(mq.robot("ur5_robot")), open_browser=False)
    """
    if not isinstance(mechanism, Mechanism):
        raise InputError(f"expected a Mechanism, got {type(mechanism).__name__}")
    if findings is None:
        findings = _lint(mechanism)
    start = None if q is None else mechanism.position(q)
    scene = scene_at_rest(mechanism, inspection_of(mechanism, findings, start))
    with LiveView(scene, port=port, open_browser=open_browser, at_once=True) as live:
        try:
            live.announce()
            live.stream(lambda changes: (), hold=True)
        except KeyboardInterrupt:
            return


def _lint(mechanism: Mechanism) -> tuple[Finding, ...]:
    origin = mechanism.origin
    if origin is None:
        return ()
    return lint(origin.file or origin.text.decode("utf-8-sig", "replace"))


def scene_at_rest(mechanism: Mechanism, inspection: Inspection) -> Scene:
    """Return the scene of a description at rest."""
    poses = inspection.poses()
    counted = say_count(len(mechanism.bodies) - 1, "moving link", "moving links")
    text = mechanism.origin.text.decode("utf-8", "replace") if mechanism.origin else ""
    return Scene(
        title=title_of(mechanism),
        t=np.zeros(1),
        bodies=bodies_of(mechanism),
        positions=poses[None, :, :3, 3],
        quaternions=from_matrices(poses[None, :, :3, :3]),
        joints=marks_of(mechanism),
        document=SceneText(
            subtitle=f"{counted}, {say_count(mechanism.nv, 'velocity', 'velocities')}, at rest",
            urdf=text,
            file_name=mechanism.name,
        ),
        inspection=inspection,
    )
