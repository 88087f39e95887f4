"""Mechanisms computed while they are shown: rate, restarts, changes, errors, late forces."""

from __future__ import annotations

import json
import math
import os
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from urllib.parse import urlsplit

import numpy as np
import pytest
from playwright.sync_api import Error
from uncovered import without_coverage
from viewing_browser import Visit, until
from viewing_watcher import Watcher

import mecanique as mq
from mecanique.verification import compare as sources
from mecanique.viewing.live import view as view_module
from mecanique.viewing.live.live import LiveView
from mecanique.viewing.live.view import Checking, Streamed

IN_HOUSE = sources.derive_all


@contextmanager
def shown(source: Streamed, speed: float = 1.0, patient: bool = False) -> Iterator[LiveView]:
    """A view that streams in a thread, as `mecanique.viewing` does in the main one."""
    with LiveView(source.scene) as live:

        def stream() -> None:
            if patient:
                live.wait()
            live.stream(lambda changes: source.frames(live, changes), speed=speed, hold=True)

        streaming = threading.Thread(target=stream, daemon=True)
        streaming.start()
        yield live
    streaming.join(60)
    source.close()
    assert not streaming.is_alive()


def pendulum(q: float = 2.0, end: float = math.inf, **parameters: float) -> Streamed:
    return Streamed(
        mq.textbook.load("rigid_bar_pendulum", **parameters), {"q": q}, None, end, 1e-10
    )


def angle(row: np.ndarray[Any, Any]) -> float:
    """The angle of a pendulum's bar about −y, from the quaternion of body 1."""
    x, y, z, w = row[7 + 3 : 7 + 7]
    assert (x, z) == (0.0, 0.0)
    return math.remainder(2 * math.atan2(-y, w), math.tau)


def swung(t: float, q: float, **parameters: float) -> float:
    motion = mq.simulate(
        mq.textbook.load("rigid_bar_pendulum", **parameters), q={"q": q}, duration=max(t, 0.01)
    )
    return float(motion(t).q[0])


FALLING = [
    *(sys.executable, "-m", "mecanique", "view", "panda"),
    *("--floating", "--move", "--no-browser"),
]


def processor_time(pid: int) -> float:
    """Seconds a process has computed, where the system tells; else infinity."""
    try:
        fields = Path(f"/proc/{pid}/stat").read_text(encoding="ascii").rsplit(")", 1)[1].split()
    except OSError:
        return math.inf
    return (int(fields[11]) + int(fields[12])) / os.sysconf("SC_CLK_TCK")


@pytest.mark.slow
def test_a_robot_falls_in_real_time_and_ctrl_c_leaves_nothing(tmp_path: Path) -> None:
    run = subprocess.Popen(
        FALLING,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        encoding="utf-8",
        cwd=tmp_path,
        env=without_coverage(),
    )
    try:
        assert run.stdout is not None
        address = run.stdout.readline().strip()
        robot = mq.read_urdf(mq.robot("panda"), root="floating")
        root = [body.name for body in robot.bodies].index(robot.joints[0].child)
        with Watcher(address) as seen:
            seen.reach(1.5, 60.0)
            begun = seen.times[-1], seen.walls[-1], processor_time(run.pid)
            seen.reach(4.0, 60.0)
            ended = seen.times[-1], seen.walls[-1], processor_time(run.pid)
            heights = np.array([row[7 * root + 2] for row in seen.rows])
            t = np.array(seen.times)
        # all of it falls as one, from where it stood
        assert heights == pytest.approx(heights[0] - 9.81 * t**2 / 2, abs=1e-3)
        passed, elapsed, worked = np.subtract(ended, begun)
        assert elapsed > 0.85 * passed, "a second takes a second"
        # other work on the machine may hold the program up; its own leaves time to spare
        assert min(elapsed, worked) < 1.15 * passed
        run.send_signal(signal.SIGINT)
        _, complaint = run.communicate(timeout=60)
        assert (run.returncode, complaint) == (0, "")
        with pytest.raises(ConnectionRefusedError):
            socket.create_connection(("127.0.0.1", urlsplit(address).port or 0), timeout=60)
    finally:
        run.kill()
        run.communicate()


def test_ctrl_c_before_any_page_has_come_ends_it_too(tmp_path: Path) -> None:
    run = subprocess.Popen(
        FALLING,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        encoding="utf-8",
        cwd=tmp_path,
        env=without_coverage(),
    )
    try:
        assert run.stdout is not None
        assert run.stdout.readline().startswith("http://127.0.0.1:")
        # its page is being made, or what it shows is being compared
        run.send_signal(signal.SIGINT)
        _, complaint = run.communicate(timeout=60)
        assert (run.returncode, complaint) == (0, "")
    finally:
        run.kill()
        run.communicate()


def test_the_motion_waits_for_its_first_page(tmp_path: Path) -> None:
    script = tmp_path / "wait.py"
    script.write_text(
        # by a function of Python, which no page computes
        "import mecanique as mq\n"
        "m, push = mq.Parameter('m', 2.0), mq.Input('F', lambda t: 1.0)\n"
        "block = mq.Body('block', mq.box(m, (0.4, 0.3, 0.2)))\n"
        "slide = mq.Prismatic('slide', 'ground', 'block', axis=(1, 0, 0), coordinate='x')\n"
        "force = mq.Force('push', 'block', (0, 0, 0), (push, 0, 0))\n"
        "mq.view(mq.Mechanism('pushed', bodies=(mq.Body('ground'), block), joints=(slide,),\n"
        "    forces=(force,), parameters=(m,), inputs=(push,)), open_browser=False)\n",
        encoding="utf-8",
    )
    run = subprocess.Popen(
        [sys.executable, str(script)],
        stdout=subprocess.PIPE,
        encoding="utf-8",
        env=without_coverage(),
    )
    try:
        assert run.stdout is not None
        address = run.stdout.readline().strip()
        time.sleep(1.0)
        with Watcher(address) as seen:
            seen.reach(0.1)
            assert seen.times[0] == pytest.approx(0.0, abs=0.2)
            assert seen.times[1] < 0.8, "it began before the page came"
        run.send_signal(signal.SIGINT)
        run.communicate(timeout=60)
        assert run.returncode == 0
    finally:
        run.kill()
        run.communicate()


def test_a_reset_starts_again_without_loading_the_page_anew() -> None:
    with shown(pendulum()) as live, Watcher(live.url) as seen:
        seen.reach(0.8)
        scene = seen.scene
        seen.forget()
        seen.ask(do="reset")
        seen.until(lambda watcher: any(state["restart"] for state in watcher.states))
        seen.begin_again(0.3)
        frame = seen.reach(0.5)
        assert angle(frame.row) == pytest.approx(swung(frame.t, 2.0), abs=1e-5)
        assert seen.scene == scene


def test_slow_motion_is_as_smooth_and_what_takes_long_comes_piece_by_piece(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    slow = Streamed(
        mq.textbook.load("rigid_bar_pendulum"), {"q": 2.0}, None, math.inf, 1e-10, speed=0.05
    )
    with shown(slow, speed=0.05, patient=True) as live, Watcher(live.url) as seen:
        frame = seen.reach(0.12)
        steps = np.diff([t for t in seen.times if t > 0])
        # a busy machine leaves frames out
        assert np.quantile(steps, 0.2) == pytest.approx(0.05 / 60, rel=0.05)
        assert seen.states[-1]["speed"] == 0.05
        assert angle(frame.row) == pytest.approx(swung(frame.t, 2.0), abs=1e-5)
    monkeypatch.setattr(view_module, "PATIENCE", 0.0)
    impatient = pendulum()
    assert impatient.scene.t[-1] < 0.3
    with shown(impatient) as live, Watcher(live.url) as seen:
        frame = seen.reach(0.6, 60.0)
        assert angle(frame.row) == pytest.approx(swung(frame.t, 2.0), abs=1e-5)
        assert seen.notes["warning"] == ""


def test_a_changed_start_restarts_and_a_changed_parameter_loads_a_new_scene() -> None:
    with shown(pendulum()) as live, Watcher(live.url) as seen, Watcher(live.url) as other:
        seen.reach(0.3)
        scene = seen.scene
        seen.forget()
        seen.ask(do="initial", name="q", value=0.7)
        seen.until(lambda watcher: watcher.states[-1]["values"] == [["initial", "q", 0.7]])
        other.until(lambda watcher: watcher.states[-1]["values"] == [["initial", "q", 0.7]])
        seen.begin_again(0.2)
        frame = seen.reach(0.6)
        assert angle(frame.row) == pytest.approx(swung(frame.t, 0.7), abs=1e-5)
        assert seen.scene == scene
        seen.forget()
        seen.ask(do="parameter", name="l", value=2.5)
        seen.until(lambda watcher: watcher.scene != scene)
        seen.begin_again(0.2)
        frame = seen.reach(0.6)
        assert angle(frame.row) == pytest.approx(swung(frame.t, 0.7, l=2.5), abs=1e-5)
        assert other.scene == seen.scene
        assert (
            live.scene.document.parameters[0].value == 2.5
            or live.scene.document.parameters[1].value == 2.5
        )


def test_a_page_loaded_anew_opens_where_it_was(visit: Callable[..., Visit]) -> None:
    with shown(pendulum(), patient=True) as live:
        seen, other = visit(live.url), visit(live.url)
        seen.page.click("#tab-parameters")
        seen.page.click("[data-camera=side]")
        assert (seen.page.get_attribute("[data-name=q]", "value"), written(seen, "l")) == (
            "2.0",
            "1",
        )
        before = seen.js("mecanique.scene.live.id")
        drag = "([name, value]) => { const s = document.querySelector(`[data-name=${name}]`);"
        drag += " s.value = value; s.oninput(); s.onchange(); }"
        seen.js(drag, ["q", 1.25])
        until(lambda: written(other, "q") == "1.25")
        assert seen.js("mecanique.scene.live.id") == before
        seen.js(drag, ["l", 2])
        until(lambda: asked(seen, "window.mecanique?.scene.live.id") not in (None, before))
        until(lambda: bool(asked(other, "window.mecanique?.clock.time > 0")))
        seen.page.wait_for_selector("body.ready")
        assert seen.page.get_attribute("#tab-parameters", "aria-selected") == "true"
        assert seen.page.get_attribute("[data-camera=side]", "aria-pressed") == "true"
        until(lambda: (written(seen, "q"), written(seen, "l")) == ("1.25", "2"))
        until(lambda: (written(other, "q"), written(other, "l")) == ("1.25", "2"))
        assert seen.errors == other.errors == []


def written(seen: Visit, name: str) -> str:
    """The value beside a slider."""
    found = asked(seen, f"document.querySelector('tr:has([data-name={name}]) output').textContent")
    return str(found)


def test_many_pages_see_the_same_and_one_that_leaves_is_not_missed() -> None:
    with shown(pendulum()) as live, Watcher(live.url) as one, Watcher(live.url, pause=0.25) as slow:
        with Watcher(live.url) as brief:
            brief.reach(0.5)
            assert live.viewers == 3
        one.reach(1.5)
        assert live.viewers == 2
        fast, few = len(one.times), len(slow.times)
        assert 2 * few < fast
        known = dict(zip(one.times, one.rows, strict=True))
        shared = [
            (row, known[t]) for t, row in zip(slow.times, slow.rows, strict=True) if t in known
        ]
        assert shared
        assert all(np.array_equal(row, same) for row, same in shared)


def test_what_goes_wrong_is_told_in_words_and_the_server_stays() -> None:
    def signal_of(t: float) -> float:
        if t > 2.6:
            raise ValueError("the record ends here")
        return 0.0

    with (
        shown(Streamed(pushed(signal_of), None, None, math.inf, 1e-8), speed=4.0) as live,
        Watcher(live.url) as seen,
    ):
        seen.until(lambda watcher: bool(watcher.notes.get("warning")))
        assert seen.notes["warning"].startswith("The motion stops here: ")
        assert seen.notes["warning"].endswith("the record ends here")
        assert 2.4 < seen.times[-1] <= 2.6
        assert live.viewers == 1
        seen.forget()
        seen.ask(do="reset")
        seen.begin_again(0.5)
        # a page that opens later is told too
        seen.until(lambda watcher: watcher.notes["warning"] != "")
        with Watcher(live.url) as late:
            late.until(lambda watcher: "the record ends here" in watcher.notes.get("warning", ""))


def test_a_value_that_makes_no_motion_is_told_and_the_next_one_moves_again() -> None:
    motion = mq.simulate(mq.textbook.load("rigid_bar_pendulum"), q={"q": 1.0}, duration=1.0)
    for source in (pendulum(1.0), Streamed(motion)):
        with shown(source) as live, Watcher(live.url) as seen:
            seen.reach(0.1)
            seen.ask(do="parameter", name="m", value=-1.0)
            seen.until(lambda watcher: "mass is negative" in watcher.notes.get("warning", ""))
            seen.forget()
            seen.ask(do="parameter", name="m", value=3.0)
            seen.until(lambda watcher: watcher.notes["warning"] == "")
            seen.begin_again(0.2)
            seen.reach(0.4)


def pushed(force: Callable[[float], float]) -> mq.Mechanism:
    """A block on a slide, pushed by a function of time."""
    m, push = mq.Parameter("m", 2.0, "kg"), mq.Input("F", force, "N")
    return mq.Mechanism(
        "block",
        bodies=(mq.Body("ground"), mq.Body("block", mq.box(m, (0.4, 0.3, 0.2)))),
        joints=(mq.Prismatic("slide", "ground", "block", axis=(1, 0, 0), coordinate="x"),),
        forces=(mq.Force("push", "block", (0, 0, 0), (push, 0, 0)),),
        parameters=(m,),
        inputs=(push,),
    )


def test_a_force_that_acts_late_gets_its_arrow(visit: Callable[..., Visit]) -> None:
    source = Streamed(pushed(lambda t: 0.0 if t < 2.5 else 8.0), None, {"x": 0.1}, math.inf, 1e-8)
    with shown(source, patient=True) as live:
        seen = visit(live.url)
        names = "() => window.mecanique?.scene.arrows.map(arrow => arrow.name) ?? []"
        before = seen.js(names)
        assert before
        assert not any("push" in name for name in before)
        until(lambda: any("push" in name for name in asked(seen, names) or []))
        assert set(before) < set(seen.js(names))
        seen.page.wait_for_selector("body.ready")
        # x = 0.1 + 0.1 t, until 4 m/s² begin
        until(lambda: bool(asked(seen, "mecanique.clock.time > 3")))
        t, x = seen.js("[mecanique.clock.time, mecanique.clock.row[7]]")
        assert x == pytest.approx(0.1 * t + 2.0 * (t - 2.5) ** 2, abs=1e-3)
        assert seen.errors == []


def asked(seen: Visit, expression: str) -> Any:
    """What a page answers that may be loading just now."""
    try:
        return seen.js(expression)
    except Error:
        return None


def test_equations_and_verdict_arrive_while_it_moves(visit: Callable[..., Visit]) -> None:
    source = pendulum()
    first = source.scene.document
    assert (first.verdict.agrees, first.verdict.headline) == (None, "checking …")
    with shown(source) as live:
        seen = visit(live.url)
        seen.page.wait_for_selector(".badge.good")
        assert seen.page.locator("#panel-equations math").count() > 3
        seen.page.click("#tab-verdict")
        assert "agrees at 100 random states" in seen.page.inner_text("#panel-verdict")
        assert seen.page.locator("#alarm").is_hidden()
        # what comes later is there for a page that opens later, and after a reload
        assert live.scene.document.verdict.agrees is True
        seen.page.reload()
        seen.page.wait_for_selector(".badge.good")
        assert seen.page.locator("#panel-equations math").count() > 3
        assert seen.messages == []
        assert seen.errors == []


def test_a_disagreement_is_told_loudly(
    visit: Callable[..., Visit], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(
        sources, "derive_all", lambda mechanism: IN_HOUSE(mq.textbook.load("cart_pole", m=1.5))
    )
    source = Streamed(mq.textbook.load("cart_pole"), {"q": 1.0}, None, math.inf, 1e-8)
    with shown(source) as live:
        seen = visit(live.url)
        seen.page.wait_for_selector(".badge.bad")
        assert seen.page.inner_text(".badge") == "✗ disagrees"
        assert "Derivation and reference disagree: cart_pole: DISAGREES" in seen.page.inner_text(
            "#alarm"
        )
        moved = seen.js("mecanique.clock.time")
        until(lambda: bool(seen.js("mecanique.clock.time") > moved))
        # a scene that takes its place keeps it, though it was made before the verdict came
        before = seen.js("mecanique.scene.live.id")
        live.show(source.scene, keep=True)
        until(lambda: asked(seen, "window.mecanique?.scene.live.id") not in (None, before))
        seen.page.wait_for_selector("#alarm:not([hidden])")
        assert seen.page.inner_text(".badge") == "✗ disagrees"


def test_a_check_that_fails_is_told_and_a_cancelled_one_is_silent(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    told: list[str] = []

    def broken(mechanism: mq.Mechanism) -> Any:
        raise RuntimeError("no such thing")

    monkeypatch.setattr(sources, "derive_all", broken)
    check = Checking(
        mq.textbook.load("rigid_bar_pendulum"), lambda _, verdict: told.append(verdict.headline)
    )
    check._thread.join(60)
    assert told[-1] == "not checked: RuntimeError: no such thing"
    told.clear()
    check = Checking(
        mq.textbook.load("rigid_bar_pendulum"), lambda _, verdict: told.append(verdict.headline)
    )
    check.finish(60)
    seen = len(told)
    assert not check._thread.is_alive()
    assert len(told) == seen


def test_nothing_piles_up_however_fast_it_runs() -> None:
    before = threading.active_count()
    source = pendulum()
    with shown(source, speed=40.0) as live, Watcher(live.url, pause=0.02) as seen:
        deepest = 0
        while not seen.times or seen.times[-1] < 20.0:
            deepest = max([deepest, *(len(client.sent) for client in live._server.clients)])
            assert len(json.dumps(live._server.notes())) < 1_000_000
            time.sleep(0.005)
            assert threading.active_count() < before + 12
        numbers, late = len(seen.times), live._server._number
    assert 0 < deepest <= 2
    assert numbers < late, "a page that is slow misses frames"
    assert threading.active_count() <= before + 1


def test_what_a_page_keeps_is_bounded(visit: Callable[..., Visit]) -> None:
    with shown(pendulum()) as live:
        seen = visit(live.url)
        until(lambda: bool(seen.js("mecanique.clock.time") > 0.2))
        count = "() => { let n = 0; mecanique.stage.viewer.scene.traverse(() => n++); return n; }"
        objects = seen.js(count)
        kept = seen.js(
            """() => {
                const { clock, traces, row } = mecanique;
                for (let k = 0; k < 12000; k++) {
                    clock.history.add(1e3 + k / 60, row);
                    traces.add(row);
                }
                const { times, rows } = clock.history;
                return [times.length, rows.length, traces.items[0].count];
            }"""
        )
        assert max(kept[:2]) <= 3600
        assert kept[2] <= 1500
        seen.page.click("#tab-plots")
        now = seen.js("mecanique.clock.number")
        until(lambda: bool(seen.js("mecanique.clock.number") > now + 20))
        assert seen.js(count) == objects
        assert seen.js("document.querySelectorAll('#charts figure').length") == 1


def test_a_stretch_whose_very_end_comes_late_is_whole(monkeypatch: pytest.MonkeyPatch) -> None:
    now, simulate = [0.0], mq.simulate

    def simulated(progress: Callable[[float], object], **arguments: Any) -> mq.Motion:
        def late(fraction: float) -> None:
            now[0] = 10 * view_module.PATIENCE if fraction == 1.0 else 0.0
            progress(fraction)

        return simulate(progress=late, **arguments)

    monkeypatch.setattr(mq.motion, "simulate", simulated)
    monkeypatch.setattr(view_module, "time", SimpleNamespace(monotonic=lambda: now[0]))
    motion = view_module.compute(
        mechanism=mq.textbook.load("rigid_bar_pendulum"), q=[1.0], duration=0.5
    )
    assert now[0] > view_module.PATIENCE
    assert motion.t[-1] == 0.5


def test_a_motion_that_ends_at_once_is_shown_up_to_its_end() -> None:
    motion, remark = view_module.compute_first(
        mechanism=mq.textbook.load("double_atwood_machine"),
        q={"x": -0.3, "y": -0.5},
        v=None,
        duration=2.0,
        rtol=1e-9,
    )
    assert motion.t[-1] == pytest.approx(0.93, abs=0.01)
    assert remark.startswith("The motion stops here: y must stay within (-h, h)")
    assert ".motion" not in remark


def test_what_cannot_start_is_refused() -> None:
    with pytest.raises(mq.InputError, match="x must stay within"):
        view_module.compute_first(
            mechanism=mq.textbook.load("atwood_machine"), q={"x": 1.5}, duration=1.0
        )
