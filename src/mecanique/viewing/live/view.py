"""Show a motion live in a browser on this machine."""

from __future__ import annotations

import math
import threading
import time
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor, wait
from dataclasses import replace
from typing import Any, final

import numpy as np

from mecanique.derivation import derive
from mecanique.errors import DerivationError, InputError, IntegrationError, MecaniqueError
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
from mecanique.viewing.scene.texts import (
    derivation_of,
    derive_all,
    document_of,
    ledger_of,
    table_of,
)
from mecanique.wording import say_count

MOST_DERIVED = 8
"""Above this number of velocities the equations are compared, but not written out."""

Report = Callable[[tuple[ShownDerivation, ...], VerdictTable], None]

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
        self, mechanism: Mechanism, report: Report, prove: Proof = lambda table: table
    ) -> None:
        self._mechanism = mechanism
        self._report = report
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
            for equations in derive_all(self._mechanism) if written_out else ():
                if self._cancelled:
                    return
                derivations += (derivation_of(equations),)
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
                self._report(derivations, verdict)


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


def follow(first: Motion, end: float, speed: Callable[[], float]) -> Iterator[Scene]:
    """Yield the complete scenes after a first stretch, computed while those before are shown."""
    stopped, last, work = threading.Event(), first, float(first.energy().work[-1])

    def check() -> None:
        if stopped.is_set():
            raise _StoppedError

    def go_on() -> tuple[Scene | None, Exception | None]:
        """The next scene, none at the end, and what stops the motion in it."""
        nonlocal last, work
        t0, error, shown_at = float(last.t[-1]), None, speed()
        if end - t0 <= 1e-9:
            return None, None
        try:
            last = compute(
                check,
                mechanism=last.described,
                q=last.q[-1],
                v=last.v[-1],
                t0=t0,
                duration=min(STRETCH * shown_at, end - t0),
                rtol=last.statistics.rtol,
                fps=density(shown_at),
            )
        except IntegrationError as stop:
            if stop.motion is None or len(stop.motion.t) < 2:
                raise
            last, error = stop.motion, stop
        scene, work = _stage_after(last, work)
        return scene, error

    with ThreadPoolExecutor(1, "mecanique integration") as pool:
        coming = deque([pool.submit(go_on), pool.submit(go_on)])
        try:
            while True:
                # short waits, so that Ctrl-C works on every system
                while not wait(list(coming)[:1], timeout=0.2).done:
                    pass
                scene, error = coming.popleft().result()
                if scene is not None:
                    coming.append(pool.submit(go_on))
                    yield scene
                if error is not None:
                    raise error
                if scene is None:
                    return
        finally:
            stopped.set()


def _stage_after(motion: Motion, work: float) -> tuple[Scene, float]:
    """A later stretch as a scene; the work done before, and at its end."""
    actions = actions_of(motion)
    scene = scene_of(motion, SceneText(ledger=ledger_of(motion, actions)), actions)
    series = (
        replace(s, values=s.values + work) if s.name == "energy work" else s for s in scene.series
    )
    return replace(scene, series=tuple(series)), work + float(motion.energy().work[-1])


class _StoppedError(Exception):
    """Nobody is watching any more."""


class _EnoughError(Exception):
    """The motion computed so far is to be shown first."""


class Shown:
    """A scene as a live view shows it; equations and verdict of what moves arrive meanwhile."""

    _checking: Checking | None = None

    def __init__(self, scene: Scene, mechanism: Mechanism | None = None) -> None:
        self.scene = scene
        self._mechanism = mechanism  # None at rest

    def check(self, live: LiveView) -> None:
        """Derive and compare what moves, unless this has already begun."""
        if self._mechanism is not None and self._checking is None:
            self._checking = Checking(self._mechanism, live.annotate, self._prove)

    def frames(self, live: LiveView, changes: Changes) -> Iterable[SceneFrame]:
        """Return what a server sends to its pages: nothing if they move by themselves."""
        return ()

    def close(self) -> None:
        """Cancel the derivation in progress."""
        if self._checking:
            self._checking.finish(2.0)

    def _prove(self, table: VerdictTable) -> VerdictTable:
        """The verdict, with what else is known of the page."""
        return table


MOST_AHEAD = 8
"""Above this number of velocities a live view starts with a short stretch, to start at once."""


@final
class Streamed(Shown):
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
            self._motion = shown
        else:
            length = "" if math.isinf(end) else f"{end:g} s, "
            self._subtitle = f"{length}computed while it is shown"
            self._motion = self._start(shown, q, v)
        self._first = _stage(self._motion, self._subtitle)
        self._names = names_of(self._first)
        super().__init__(fit(self._first, self._names), self._motion.mechanism)

    def frames(self, live: LiveView, changes: Changes) -> Iterator[SceneFrame]:
        """Yield the motion's instants; the page reports what cannot be computed."""
        live.warn("")
        # a page takes its time to load, but shows the motion from its start
        live.wait()
        ending = "There is no motion"
        try:
            motion, complete = self._motion, self._first
            if changes:
                self._speed = live.speed
                motion = self._start(*_restart(motion, changes), t0=float(motion.t[0]))
                complete = _stage(motion, self._subtitle)
            shown = self._begin(live, motion.mechanism, complete)
            ending = "The motion stops here"
            yield from (shown.frame(k) for k in range(len(shown.t)))
            for complete in follow(motion, self._end, lambda: live.speed):
                shown = self._go_on(live, complete)
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

    def _begin(self, live: LiveView, mechanism: Mechanism, complete: Scene) -> Scene:
        """The start of a motion as the view shows it; with other parameters it is another scene."""
        if self._mechanism is not None and mechanism.values == self._mechanism.values:
            shown = self._go_on(live, complete)
        else:
            self._mechanism, self._names = mechanism, names_of(complete)
            if self._checking:
                self._checking.cancel()
            self._checking = None
            shown = fit(complete, self._names)
            live.show(shown)
        self.check(live)
        return shown

    def _go_on(self, live: LiveView, complete: Scene) -> Scene:
        """A later stretch as the view shows it."""
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
class Computed(Shown):
    """A motion with the engine of its page."""

    def __init__(
        self,
        shown: Mechanism | Motion,
        q: Values | None,
        v: Values | None,
        end: float,
        rtol: float,
        speed: float,
    ) -> None:
        self._remark = ""
        if (shown.described if isinstance(shown, Motion) else shown).switching:
            raise DerivationError("a live view streams motions with corners")
        if isinstance(shown, Motion):
            motion, end, rtol = shown, float(shown.t[-1]), shown.statistics.rtol
        else:
            refuse(shown)
            length = min(FIRST * min(speed, 1.0), end)
            motion, remark = compute_first(
                mechanism=shown, q=q, v=v, duration=length, rtol=rtol, fps=density(speed)
            )
            if remark and not is_cut_short(motion):  # that the page finds by itself
                self._remark, end = remark, float(motion.t[-1])
        refuse(motion.mechanism)
        mechanism = motion.mechanism
        actions = actions_of(motion)
        document = pending(mechanism, document_of(motion, (), None, actions))
        scene, self._maker = equip(motion, document, actions, derive(mechanism))
        assert scene.engine is not None
        endless = math.isinf(end)
        duration = SHOWN * min(speed, 1.0) if endless else end - float(motion.t[0])
        engine = replace(scene.engine, duration=duration, rtol=rtol, endless=endless)
        whole = end <= float(motion.t[-1])
        document = replace(scene.document, method=scene.document.method if whole else "")
        super().__init__(replace(scene, engine=engine, document=document), mechanism)

    def check(self, live: LiveView) -> None:
        """Derive and compare what moves, and then the page's program."""
        if self._remark:
            live.warn(self._remark)
        super().check(live)

    def _prove(self, table: VerdictTable) -> VerdictTable:
        try:
            return add_row(table, judge_page(self._maker))
        except MecaniqueError as error:
            return replace(table, agrees=False, headline=f"the program of this page: {error}")


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
    showing: Shown
    try:
        showing = Computed(shown, q, v, end, rtol, speed)
    except MecaniqueError:  # no page computes it; it says itself why nothing moves
        showing = Streamed(shown, q, v, end, rtol, speed)
    _show(showing, port, open_browser, speed)


def _show(showing: Shown, port: int, open_browser: bool, speed: float = 1.0) -> None:
    """Serve a page until Ctrl-C."""
    with LiveView(showing.scene, port=port, open_browser=open_browser) as live:
        try:
            live.announce()
            showing.check(live)
            live.stream(lambda changes: showing.frames(live, changes), speed=speed, hold=True)
        except KeyboardInterrupt:
            return
        finally:
            showing.close()


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
    _show(Shown(scene), port, open_browser)


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
        joints=marks_of(mechanism, poses),
        document=SceneText(
            subtitle=f"{counted}, {say_count(mechanism.nv, 'velocity', 'velocities')}, at rest",
            urdf=text,
            file_name=mechanism.name,
        ),
        inspection=inspection,
    )
