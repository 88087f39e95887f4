"""Engines of pages, run under node or in a browser."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest

import mecanique as mq
from mecanique.viewing.engine import Maker, write_python
from mecanique.viewing.scene.from_motion import scene_of
from mecanique.viewing.scene.scene import PageProgram

SCRIPTS = Path(__file__).parent / "javascript"
ASSETS = Path(mq.__file__).parent / "viewing" / "page" / "assets" / "engine"

needs_node = pytest.mark.skipif(shutil.which("node") is None, reason="no node found")

RUNNER = """
const found = [];
for (const { engine, rtol, times } of JSON.parse(document.getElementById("tasks").textContent)) {
  const script = document.createElement("script");
  script.textContent = engine.script;
  document.head.append(script);
  const machine = new Machine(engine, globalThis.mecaniqueProgram);
  const setting = { ...machine.initial(), rtol };
  const begun = performance.now();
  const path = machine.move(setting, machine.begin(setting), setting.first + setting.duration);
  const ms = performance.now() - begun;
  const states = times.map((t) => [...path.at(t, new Float64Array(path.size))]);
  const { stopped, last, steps } = path;
  found.push({ states, stopped, last, steps, ms });
}
globalThis.found = found;
"""


def engine_of(motion: mq.Motion) -> PageProgram:
    maker = Maker(motion, mq.derive(motion.mechanism))
    scene = maker.thin(scene_of(motion, None, ()))
    return maker.make(scene, write_python(motion.mechanism))


def run(tasks: Any, folder: Path, script: str = "run_engines") -> list[dict[str, Any]]:
    """Run a script on engines under node: move each to its end, or what else it does."""
    path = folder / "tasks.json"
    path.write_text(json.dumps(tasks), encoding="utf-8")
    done = subprocess.run(
        ["node", str(SCRIPTS / f"{script}.js"), str(path)],
        capture_output=True,
        encoding="utf-8",
        check=False,
    )
    assert done.returncode == 0, done.stderr
    found: list[dict[str, Any]] = json.loads(done.stdout)
    return found


def write_runner(tasks: list[dict[str, Any]], path: Path) -> Path:
    """Write a page that moves engines to their ends; what it finds is `found` there."""
    texts = []
    first, law = ("../data/vectors", "tableau", "dop853"), ("bounds", "loops", "law", "corners")
    for name in (*first, *law, "machine"):
        text = (ASSETS / f"{name}.js").read_text(encoding="utf-8")
        texts.append(re.sub(r"^import .*\n|^export ", "", text, flags=re.MULTILINE))
    data = json.dumps(tasks).replace("<", "\\u003c")
    path.write_text(
        '<!DOCTYPE html><meta charset="utf-8"><body class="ready"><p id="notice" hidden></p>'
        f'<script type="text/plain" id="tasks">{data}</script>'
        f"<script>(() => {{\n{''.join(texts)}{RUNNER}}})();</script>",
        encoding="utf-8",
    )
    return path
