"""What a live view of 100 bodies costs on the sending side. Run by hand.

    python tests/benchmarks/bench_live.py [bodies]

Frames of bodies with two arrows each are sent, first as fast as they can be, then paced at 60 a
second for ten seconds, to no page, to one that shows every frame at once, and to four of which one
is slow. Given: frames sent a second, frames that arrived a second at the fastest and the slowest
page, and how much of one core the sending program used (the pages run in a process of their own).
"""

from __future__ import annotations

import multiprocessing
import sys
import time
from multiprocessing.synchronize import Event
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).parents[1] / "view"))
from viewing_scenes import swarm
from viewing_watcher import Watcher

from mecanique.viewing.live.live import LiveView

SECONDS = 10.0


def watch(url: str, pause: float, ready: Event, done: Event, counts: Any) -> None:
    """A page in a process of its own."""
    with Watcher(url, pause) as seen:
        seen.until(lambda watcher: bool(watcher.times))
        ready.set()
        first, start = len(seen.times), time.monotonic()
        while not done.wait(0.05):
            pass
        counts.put((pause, (len(seen.times) - first) / (time.monotonic() - start)))


def main() -> None:
    """Measure and print."""
    bodies = int(sys.argv[1]) if len(sys.argv) > 1 else 100
    scene = swarm(bodies, SECONDS)
    frames = [scene.frame(k) for k in range(len(scene.t))]
    spawn = multiprocessing.get_context("spawn")
    print(f"{bodies} bodies, {2 * bodies} arrows")
    with LiveView(scene) as view:
        start = time.perf_counter()
        for frame in frames:
            view.send(frame)
        print(f"unpaced: {len(frames) / (time.perf_counter() - start):.0f} frames/s")
    print(f"{'pages':>6} {'sent/s':>7} {'fastest/s':>10} {'slowest/s':>10} {'CPU':>6}")
    for pauses in ((), (0.0,), (0.0, 0.0, 0.0, 0.1)):
        with LiveView(scene) as view:
            done, counts = spawn.Event(), spawn.Queue()
            pages = []
            for pause in pauses:
                ready = spawn.Event()
                pages.append(
                    spawn.Process(target=watch, args=(view.url, pause, ready, done, counts))
                )
                pages[-1].start()
                ready.wait(20)
            before, wall, cpu = view._server._number, time.perf_counter(), time.process_time()
            view.stream(frames)
            wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
            sent = (view._server._number - before) / wall
            done.set()
            rates = [counts.get(timeout=10)[1] for _ in pages]
            for page in pages:
                page.join(10)
        least, most = (min(rates), max(rates)) if rates else (0.0, 0.0)
        print(f"{len(pauses):6d} {sent:7.1f} {most:10.1f} {least:10.1f} {cpu / wall:6.0%}")


if __name__ == "__main__":
    main()
