"""Print what a page's own motion costs: growth, time, and the difference from `simulate`.

Usage: python tests/benchmarks/bench_page.py [SYSTEM ...], all of the catalogue by default; with
playwright and Chromium it also opens the double pendulum's page and moves a slider. Each figure is
of this machine, under whatever else runs on it.
"""

from __future__ import annotations

import gzip
import json
import shutil
import subprocess
import sys
import tempfile
import time
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np

import mecanique as mq
from mecanique.errors import MecaniqueError
from mecanique.textbook import entry, load, names
from mecanique.viewing.engine.make import Maker
from mecanique.viewing.scene.from_motion import scene_of

ENGINES = Path(__file__).parents[1] / "viewing" / "javascript" / "run_engines.js"
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


def move(name: str, **options: Any) -> mq.Motion:
    """Simulate a system of the catalogue from its own start."""
    system = entry(name)
    v = {key.removesuffix("'"): value for key, value in system.start_velocity.items()}
    return mq.simulate(load(name), q=dict(system.start), v=v, duration=system.duration, **options)


def measure(name: str, folder: Path) -> str:
    """Return a row of the table."""
    motion = move(name, rtol=1e-13, samples=5)
    maker = Maker(motion, mq.derive(motion.mechanism))
    engine = maker.make(maker.thin(scene_of(motion, None, (), complete=True)))
    tasks = [{"engine": asdict(engine), "rtol": r, "times": [motion.t[-1]]} for r in RTOLS]
    # the first of each is what a page meets, the last what it comes to
    path = folder / "tasks.json"
    path.write_text(json.dumps([*tasks, *tasks]))
    done = subprocess.run(
        ["node", str(ENGINES), str(path)], capture_output=True, text=True, check=True
    )
    first, fine, again, _ = json.loads(done.stdout)
    end = np.array([*motion.q[-1], *motion.v[-1]])
    gap = np.abs(np.array(fine["states"][0][:-1]) - end) / np.maximum(1, np.abs(end))
    size = 4 / 3 * len(gzip.compress(engine.script.encode(), 9)) / 1000
    return (
        f"| {name} | {size:.1f} | {first['steps']} | {first['ms']:.0f} | {again['ms']:.0f} "
        f"| {fine['stopped'] or f'{gap.max():.1e}'} |"
    )


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
    print("| system | program, packed [kB] | steps | first [ms] | again [ms] | end at 1e-12 |")
    print("|---|---|---|---|---|---|")
    with tempfile.TemporaryDirectory() as folder:
        for name in sys.argv[1:] or names():
            try:
                print(measure(name, Path(folder)), flush=True)
            except MecaniqueError as error:
                print(f"| {name} | {str(error)[:80]} |||||", flush=True)
        print(open_page(Path(folder)))


if __name__ == "__main__":
    main()
