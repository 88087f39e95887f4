"""Whether memory stays steady while a live view streams, here and in the browser. By hand.

    python tests/benchmarks/watch_live_memory.py [seconds] [system]

A double pendulum is shown by `mecanique view`, as a user would, for five minutes, to headless
Chromium with the plots open. Every 20 seconds: the time shown, frames taken by the page since the
last line, the program's resident memory, and of the page, after a garbage collection, the
JavaScript heap, the number of DOM nodes and of three.js objects. What is kept of a stream fills up
over the first minute (the last 3600 frames, the traces); the verdict is on what follows."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

from playwright.sync_api import Page, sync_playwright

sys.path.insert(0, str(Path(__file__).parents[1] / "viewing"))
from viewing_browser import FLAGS

EVERY = 20.0
FILLED = 120.0
MOST_GROWTH = 5.0
"""More than this after the first two minutes is a leak [MB]."""


def resident(pid: int) -> float:
    """Resident memory of a process [MB]."""
    for line in Path(f"/proc/{pid}/status").read_text(encoding="ascii").splitlines():
        if line.startswith("VmRSS"):
            return float(line.split()[1]) / 1024
    return float("nan")


def look(page: Page) -> tuple[float, int, float, int, int]:
    """The time shown, the number of the last frame, heap [MB], DOM nodes, three.js objects."""
    session = page.context.new_cdp_session(page)
    session.send("HeapProfiler.collectGarbage")
    heap = float(session.send("Runtime.getHeapUsage")["usedSize"]) / 2**20
    session.detach()
    count = "let n = 0; mecanique.stage.viewer.scene.traverse(() => n++);"
    t, number, nodes, objects = page.evaluate(
        f"() => {{ {count} "
        "return [mecanique.clock.time, mecanique.taken, "
        "document.querySelectorAll('*').length, n]; }"
    )
    return float(t), int(number), heap, int(nodes), int(objects)


def main() -> None:
    """Stream, look, judge."""
    seconds = float(sys.argv[1]) if len(sys.argv) > 1 else 300.0
    system = sys.argv[2] if len(sys.argv) > 2 else "double_pendulum"
    words = [sys.executable, "-m", "mecanique", "view", system, "--no-browser"]
    run = subprocess.Popen(words, stdout=subprocess.PIPE, encoding="utf-8")
    assert run.stdout is not None
    chromium = (
        os.environ.get("MECANIQUE_CHROMIUM")
        or shutil.which("chromium")
        or shutil.which("chromium-browser")
    )
    lines = []
    try:
        address = run.stdout.readline().strip()
        with sync_playwright() as playwright:
            browser = playwright.chromium.launch(executable_path=chromium, args=FLAGS.split())
            page = browser.new_page(viewport={"width": 920, "height": 560})
            faults: list[str] = []
            page.on("pageerror", lambda error: faults.append(str(error)))
            page.goto(address)
            page.wait_for_selector("body.ready")
            page.wait_for_selector(".badge.good")
            page.click("#tab-plots")
            # frames are counted where the page takes them
            page.evaluate(
                """() => { const { clock } = mecanique; const tick = clock.tick.bind(clock);
                mecanique.taken = 0;
                clock.tick = now => {
                const came = tick(now); mecanique.taken += came; return came; }; }"""
            )
            start, before = time.monotonic(), 0
            print(
                f"{'s':>5} {'t':>8} {'frames':>7} {'program MB':>11} {'heap MB':>8} "
                f"{'nodes':>6} {'objects':>8}"
            )
            while True:
                passed = time.monotonic() - start
                t, number, heap, nodes, objects = look(page)
                lines.append((passed, resident(run.pid), heap, nodes, objects))
                row = (passed, t, number - before, *lines[-1][1:])
                print("{:5.0f} {:8.2f} {:7d} {:11.1f} {:8.2f} {:6d} {:8d}".format(*row), flush=True)
                before = number
                if passed >= seconds:
                    break
                page.wait_for_timeout(1000 * (EVERY - (time.monotonic() - start) % EVERY))
            browser.close()
    finally:
        run.send_signal(signal.SIGINT)
        run.communicate(timeout=20)
    late = [line for line in lines if line[0] >= min(FILLED, seconds / 2)]
    program, heap = (late[-1][k] - late[0][k] for k in (1, 2))
    # the number of nodes follows the ticks of the plots
    same = late[-1][4] == late[0][4] and abs(late[-1][3] - late[0][3]) < 50
    steady = program < MOST_GROWTH and heap < MOST_GROWTH and same and not faults
    print(
        f"after {late[0][0]:.0f} s: program {program:+.1f} MB, heap {heap:+.2f} MB, errors "
        f"{len(faults)},"
        f" the program ended with {run.returncode}: {'steady' if steady else 'NOT STEADY'}"
    )


if __name__ == "__main__":
    main()
