"""Engines of pages, run under node."""

from __future__ import annotations

import json
import shutil
import subprocess
from pathlib import Path
from typing import Any

import pytest

import mecanique as mq
from mecanique.viewing.engine.attach import write_python
from mecanique.viewing.engine.make import Maker
from mecanique.viewing.scene.engine import Engine
from mecanique.viewing.scene.from_motion import scene_of

SCRIPT = Path(__file__).parent / "javascript" / "run_engines.js"

needs_node = pytest.mark.skipif(shutil.which("node") is None, reason="no node found")


def engine_of(motion: mq.Motion) -> Engine:
    maker = Maker(motion, mq.derive(motion.mechanism))
    scene = maker.thin(scene_of(motion, None, (), complete=True))
    return maker.make(scene, write_python(motion.mechanism))


def run(tasks: list[dict[str, Any]], folder: Path) -> list[dict[str, Any]]:
    path = folder / "tasks.json"
    path.write_text(json.dumps(tasks), encoding="utf-8")
    done = subprocess.run(
        ["node", str(SCRIPT), str(path)], capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    found: list[dict[str, Any]] = json.loads(done.stdout)
    return found
