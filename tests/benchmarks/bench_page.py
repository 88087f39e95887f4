"""Print what a page's own motion costs: growth, time, and the difference from `simulate`.

Usage: python tests/benchmarks/bench_page.py [--pages] [SYSTEM ...], all of the catalogue by
default, under node, in Chromium and in Firefox, as far as they are installed; in Chromium it also
opens four pages, `--pages` these alone: how long until the mechanism is seen to move and until it
is drawn in three dimensions, and what the main thread spends until then (medians of seven openings,
with WebGL by software); how long a moved slider and ten seconds of motion at a relative tolerance
of 1e-8 take (medians of nine). Each figure is of this machine, under whatever else runs on it.
"""

from __future__ import annotations

import gzip
import json
import shutil
import sys
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import asdict, astuple, dataclass
from pathlib import Path
from statistics import median
from typing import TYPE_CHECKING, Any, TypeAlias, final

import numpy as np

import mecanique as mq
from mecanique.errors import MecaniqueError
from mecanique.textbook import entry, load, names

sys.path.insert(0, str(Path(__file__).parents[1] / "viewing"))

from viewing_browser import FLAGS
from viewing_engines import engine_of, run, write_runner
from viewing_firefox import firefox, missing

if TYPE_CHECKING:
    from playwright.sync_api import Browser

Found: TypeAlias = list[dict[str, Any]]
RTOLS = (1e-8, 1e-12)
SLIDER = """() => {
  const field = document.querySelector('#panel-parameters input[type=range]');
  const spent = [];
  for (let k = 0; k < 9; k++) {
    field.value = Number(field.value) * 1.01;
    const begun = performance.now();
    field.oninput();
    spent.push(performance.now() - begun);
  }
  return spent.sort((a, b) => a - b)[4];
}"""


STRETCH = """() => {
  const { machine } = mecanique.setup.bench;
  const setting = { ...machine.initial(), rtol: 1e-8 };
  const spent = [];
  for (let k = 0; k < 9; k++) {
    const begun = performance.now();
    machine.move(setting, machine.begin(setting), setting.first + 10);
    spent.push(performance.now() - begun);
  }
  return spent.sort((a, b) => a - b)[4];
}"""
PAGES = ("double_pendulum", "slider_crank", "gyroscope", "shear_building")
OPENINGS = 7


@final
@dataclass(frozen=True)
class Opening:
    """How a page opened, in ms.

    Args:
        seen: from the start of the navigation until a frame with a moved mechanism was presented.
        drawn: until the first picture in three dimensions.
        spent: processor time of the page's main thread until it was ready.
    """

    seen: float
    drawn: float
    spent: float


@final
@dataclass(frozen=True)
class Case:
    """A system: what its engine is asked, and where it should end."""

    name: str
    tasks: list[dict[str, Any]]
    end: np.ndarray
    size: float


def move(name: str, **options: Any) -> mq.Motion:
    """Simulate a system of the catalogue from its own start."""
    system = entry(name)
    v = {key.removesuffix("'"): value for key, value in system.start_velocity.items()}
    return mq.simulate(load(name), q=dict(system.start), v=v, duration=system.duration, **options)


def prepare(name: str) -> Case:
    """Return what the engines are asked, and where `simulate` ends."""
    motion = move(name, rtol=1e-13, samples=5)
    engine = asdict(engine_of(motion))
    size = 4 / 3 * len(gzip.compress(engine["script"].encode(), 9)) / 1000
    times = [float(motion.t[-1])]
    tasks = [{"engine": engine, "rtol": rtol, "times": times} for rtol in RTOLS]
    # the first of each is what a page meets, the last what it comes to
    return Case(name, [*tasks, *tasks], np.array([*motion.q[-1], *motion.v[-1]]), size)


def run_in_chromium(page: Path) -> Found:
    """Move the engines in Chromium."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=shutil.which("chromium"))
        tab = browser.new_page()
        tab.set_default_timeout(600_000)
        tab.goto(page.as_uri())
        found: Found = tab.evaluate("globalThis.found")
        browser.close()
    return found


def run_in_firefox(page: Path) -> Found:
    """Move the engines in Firefox."""
    with tempfile.TemporaryDirectory() as profile, firefox(Path(profile)) as fox:
        fox.open(page.as_uri())
        found: Found = fox.js("globalThis.found")
    return found


def run_everywhere(cases: list[Case], folder: Path) -> dict[str, Found]:
    """Move the engines in each program that is installed."""
    tasks = [task for case in cases for task in case.tasks]
    page = write_runner(tasks, folder / "run.html")
    found = {}
    if shutil.which("node"):
        found["node"] = run(tasks, folder)
    if shutil.which("chromium"):
        found["Chromium"] = run_in_chromium(page)
    if not missing():
        found["Firefox"] = run_in_firefox(page)
    return found


def write_row(case: Case, k: int, found: dict[str, Found]) -> str:
    """Return a row of the table: times at 1e-8 first and again, and the end at 1e-12."""
    cells = [case.name, f"{case.size:.1f}"]
    for results in found.values():
        first, fine, again, _ = results[4 * k : 4 * k + 4]
        gap = np.abs(np.array(fine["states"][0][:-1]) - case.end) / np.maximum(1, np.abs(case.end))
        end = fine["stopped"] or f"{gap.max():.1e}"
        cells += [f"{first['ms']:.0f}", f"{again['ms']:.0f}", end]
    return f"| {' | '.join(cells)} |"


def open_page(browser: Browser, path: Path) -> Opening:
    """Open a page in a fresh context and say when its mechanism was seen to move.

    That is when the first frame with a moved mechanism has been presented, by the browser's own
    trace: the end of the frame during which the page says that it has drawn one.
    """
    context = browser.new_context(viewport={"width": 1280, "height": 800})
    page = context.new_page()
    session = context.new_cdp_session(page)
    session.send("Performance.enable", {"timeDomain": "threadTicks"})
    browser.start_tracing(page=page, categories=["blink.user_timing", "benchmark", "cc"])
    page.goto(path.as_uri())
    page.wait_for_selector("body.ready")
    marks = page.evaluate("performance.getEntriesByType('mark').map(m => [m.name, m.startTime])")
    metrics = session.send("Performance.getMetrics")["metrics"]
    spent = next(each["value"] for each in metrics if each["name"] == "TaskDuration")
    page.wait_for_timeout(300)
    events = json.loads(browser.stop_tracing())["traceEvents"]
    context.close()
    begun = max(
        event["ts"]
        for event in events
        if event["name"] == "navigationStart" and path.name in json.dumps(event["args"])
    )
    said = next(event for event in events if event["name"] == "moving")
    seen = min(end for start, end in frames_of(events, said["pid"]) if start <= said["ts"] <= end)
    return Opening((seen - begun) / 1000, dict(marks)["drawn"], 1000 * spent)


def frames_of(events: Found, process: int) -> Iterator[tuple[float, float]]:
    """Yield when each frame that was presented began, and when it was."""
    begun: dict[str, Any] = {}
    for event in sorted(events, key=lambda each: each.get("ts", 0)):
        if event["name"] != "PipelineReporter" or event["pid"] != process:
            continue
        frame = json.dumps(event.get("id2", event.get("id")))
        if event["ph"] == "b":
            begun[frame] = event
        elif event["ph"] == "e" and frame in begun:
            first = begun.pop(frame)
            if first["args"]["frame_reporter"]["state"].startswith("STATE_PRESENTED"):
                yield first["ts"], event["ts"]


def open_pages(folder: Path) -> Iterator[str]:
    """Yield rows on how long pages take to move at first, and to follow a slider."""
    from playwright.sync_api import sync_playwright

    yield "| page | size [kB] | moves after [ms] | 3-D after | processor time | slider | 10 s |"
    yield f"|{'---|' * 7}"
    paths = [mq.export(move(name), folder / f"{name}.html") for name in PAGES]
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=shutil.which("chromium"), args=FLAGS.split()
        )
        for path in paths:
            found = [astuple(open_page(browser, path)) for _ in range(OPENINGS)]
            medians = [f"{median(column):.0f}" for column in zip(*found, strict=True)]
            page = browser.new_page()
            page.goto(path.as_uri())
            page.wait_for_selector("body.ready")
            own = [f"{page.evaluate(script):.1f}" for script in (SLIDER, STRETCH)]
            size = f"{path.stat().st_size / 1000:.0f}"
            yield f"| {' | '.join([path.stem, size, *medians, *own])} |"
            page.close()
        browser.close()


def compare_everywhere(chosen: Sequence[str], folder: Path) -> Iterator[str]:
    """Yield rows on where motions end, and in what time, in each program that is installed."""
    cases = []
    for name in chosen:
        try:
            cases.append(prepare(name))
        except MecaniqueError as error:
            yield f"{name}: {str(error)[:80]}"
    found = run_everywhere(cases, folder)
    heads = ["system", "program, packed [kB]"]
    for browser in found:
        heads += [f"{browser}: first [ms]", "again [ms]", "end at 1e-12"]
    yield f"| {' | '.join(heads)} |\n|{'---|' * len(heads)}"
    for k, case in enumerate(cases):
        yield write_row(case, k, found)


def main() -> None:
    """Print the tables."""
    chosen = [name for name in sys.argv[1:] if name != "--pages"]
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        if "--pages" not in sys.argv:
            for row in compare_everywhere(chosen or names(), folder):
                print(row, flush=True)
            print()
        for row in open_pages(folder):
            print(row, flush=True)


if __name__ == "__main__":
    main()
