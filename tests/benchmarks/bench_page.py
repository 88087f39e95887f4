"""Print what a page's own motion costs: growth, time, and the difference from `simulate`.

Usage: python tests/benchmarks/bench_page.py [SYSTEM ...], all of the catalogue by default, under
node, in Chromium and in Firefox, as far as they are installed; in Chromium it also opens the double
pendulum's page and moves a slider. Each figure is of this machine, under whatever else runs on it.
"""

from __future__ import annotations

import gzip
import shutil
import sys
import tempfile
import time
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, TypeAlias, final

import numpy as np

import mecanique as mq
from mecanique.errors import MecaniqueError
from mecanique.textbook import entry, load, names

sys.path.insert(0, str(Path(__file__).parents[1] / "viewing"))

from viewing_engines import engine_of, run, write_runner
from viewing_firefox import firefox, missing

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


def open_page(folder: Path) -> str:
    """Return how long the double pendulum's page takes to move at first, and after a slider."""
    from playwright.sync_api import sync_playwright

    path = mq.export(move("double_pendulum"), folder / "page.html")
    size = path.stat().st_size / 1000
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=shutil.which("chromium"))
        page = browser.new_page()
        found = []
        for _ in range(5):
            begun = time.perf_counter()
            page.goto(path.as_uri())
            page.wait_for_selector("body.ready")
            found.append(time.perf_counter() - begun)
        slid = page.evaluate(SLIDER)
        browser.close()
    return f"page {size:.0f} kB, opens in {sorted(found)[2]:.2f} s, moved slider {slid:.0f} ms"


def main() -> None:
    """Print the table."""
    cases = []
    for name in sys.argv[1:] or names():
        try:
            cases.append(prepare(name))
        except MecaniqueError as error:
            print(f"{name}: {str(error)[:80]}", flush=True)
    with tempfile.TemporaryDirectory() as folder:
        found = run_everywhere(cases, Path(folder))
        heads = ["system", "program, packed [kB]"]
        for browser in found:
            heads += [f"{browser}: first [ms]", "again [ms]", "end at 1e-12"]
        print(f"| {' | '.join(heads)} |\n|{'---|' * len(heads)}")
        for k, case in enumerate(cases):
            print(write_row(case, k, found))
        print(open_page(Path(folder)))


if __name__ == "__main__":
    main()
