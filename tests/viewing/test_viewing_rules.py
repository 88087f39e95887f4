"""What a page refuses to compute: the same as `Mechanism`, in the same words."""

from __future__ import annotations

import json
import subprocess
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from viewing_browser import Visit
from viewing_engines import engine_of, needs_node

import mecanique as mq
from mecanique.errors import MechanismError
from mecanique.textbook import entry, load
from mecanique.viewing.page.page import page
from mecanique.viewing.show import scene

SCRIPT = Path(__file__).parent / "javascript" / "judge_settings.js"

SYSTEMS = ("cart_pole", "crane", "gyroscope", "rolling_disk", "rattleback", "slider_crank")


def start_of(name: str) -> dict[str, Any]:
    system = entry(name)
    v = {key.removesuffix("'"): value for key, value in system.start_velocity.items()}
    return {"q": dict(system.start), "v": v}


def faults_in_python(name: str, values: dict[str, float]) -> list[str]:
    try:
        load(name).replace(**values)
    except MechanismError as error:
        return [line.strip() for line in str(error).splitlines()[1:]]
    return []


@needs_node
def test_a_page_refuses_what_a_mechanism_refuses_in_its_words(tmp_path: Path) -> None:
    tasks, expected = [], []
    for name in SYSTEMS:
        engine = engine_of(mq.simulate(load(name), **start_of(name), duration=0.1))
        draw = np.random.default_rng(0)
        settings = []
        for symbol in load(name).values:
            for value in (0.0, 1e3, float(round(draw.uniform(-30, 30), 3))):
                p = dict(zip(engine.parameters, engine.values, strict=True)) | {symbol: value}
                settings.append(list(p.values()))
                expected.append(faults_in_python(name, {symbol: value}))
        tasks.append({"engine": asdict(engine), "settings": settings})
    path = tmp_path / "tasks.json"
    path.write_text(json.dumps(tasks), encoding="utf-8")
    done = subprocess.run(["node", str(SCRIPT), str(path)], capture_output=True, encoding="utf-8")
    assert done.returncode == 0, done.stderr
    told = [faults for system in json.loads(done.stdout) for faults in system]
    assert told == expected
    said = " ".join(fault for faults in told for fault in faults)
    for words in ("mass is negative", "triangle", "damping of at least 0", "radius above 0"):
        assert words in said


@pytest.mark.parametrize(
    ("fragment", "words"),
    [
        ("#p.m=-1", "body 'bob': its mass is negative (-1 kg)"),
        ("#p.g=", "expected a finite number for parameter g, got ''"),
        ("#s.q=1x", "expected a finite number for coordinate q, got '1x'"),
    ],
)
def test_an_address_that_python_refuses_moves_nothing(
    fragment: str, words: str, visit: Callable[..., Visit], tmp_path: Path
) -> None:
    motion = mq.simulate(load("simple_pendulum"), q={"q": 0.5}, duration=1.0)
    path = tmp_path / "pendulum.html"
    path.write_text(page(scene(motion)), encoding="utf-8")
    seen = visit(f"{path.as_uri()}{fragment}", offline=True)
    assert seen.js("document.getElementById('setup-status').textContent") == words
    assert seen.js("mecanique.setup.bench.changes()") == []
    seen.clean()
