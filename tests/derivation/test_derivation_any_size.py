"""Equations of any size are written as named results from body to body, and read back."""

from __future__ import annotations

import re
import time
from typing import Any

import numpy as np
import pytest
from derivation_reading import value_of_text

import mecanique as mq
from mecanique import derive, textbook
from mecanique.generation.written import Written, write_recursion
from mecanique.model.states import States


def read_back(written: Written, values: dict[str, Any]) -> np.ndarray:
    """The left sides of the equations of motion, from the printed lines alone."""
    known = dict(values)
    for line in written.lines:
        name, formula = line.split(" = ", 1)
        known[name] = value_of_text(formula, known)
    rows = [value_of_text(row.removesuffix(" = 0"), known) for row in written.equations]
    return np.stack(np.broadcast_arrays(*rows), axis=-1)


def assert_reads_back(mechanism: mq.Mechanism, samples: int = 5) -> Written:
    equations = derive(mechanism)
    written = write_recursion(equations)
    rng = np.random.default_rng(3)
    q, v, a = (rng.uniform(-1.0, 1.0, (samples, mechanism.nv)) for _ in range(3))
    states = States.of(mechanism, q, v, 0.3)
    values = {**mechanism.values, "t": 0.3}
    values |= dict(zip(mechanism.coordinates, q.T, strict=True))
    values |= dict(zip(mechanism.velocities, v.T, strict=True))
    values |= {f"{name}'": row for name, row in zip(mechanism.velocities, a.T, strict=True)}
    expected = equations.numeric.inverse_dynamics(states, a) - equations.numeric.forces(states)
    scale = float(np.abs(expected).max())
    np.testing.assert_allclose(read_back(written, values), expected, rtol=0, atol=1e-11 * scale)
    return written


@pytest.mark.parametrize("name", ["double_pendulum", "two_link_arm", "gyroscope", "crane"])
def test_small_systems_read_back(name: str) -> None:
    assert_reads_back(textbook.load(name))


def test_panda_is_a_numbered_list_that_reads_back() -> None:
    panda = mq.read_urdf(mq.robot("panda"))
    assert not derive(panda).symbolic
    written = assert_reads_back(panda)
    text = str(written)
    assert re.search(r"^ +\(1\)  \w+ = ", text, re.MULTILINE)
    assert f"({len(written.lines)})" in text
    assert len(written.equations) == panda.nv


def test_every_name_in_the_list_is_defined_before_it_is_used() -> None:
    written = write_recursion(derive(mq.read_urdf(mq.robot("panda"))))
    meant = {name for names, _ in written.meanings for name in names.split(", ")}
    known = set(meant) | {"sin", "cos"}
    for line in written.lines:
        name, formula = line.split(" = ", 1)
        used = set(re.findall(r"(?<![\d.])[^\W\d]\w*'*", re.sub(r"\d[\d.]*e-?\d+", "0", formula)))
        unknown = {n for n in used if n not in known and n.rstrip("'") not in known}
        assert not unknown, line
        assert name in meant or re.fullmatch(r"x\d+", name)
        known.add(name)


def test_closed_mechanisms_are_refused() -> None:
    with pytest.raises(mq.DerivationError, match="'slider_crank' is closed or rolls"):
        write_recursion(derive(textbook.load("slider_crank")))


def test_printing_takes_time_in_proportion_to_what_is_printed() -> None:
    equations = derive(textbook.load("n_link_pendulum", n=12))
    _ = equations.derivation
    derive(textbook.load("double_pendulum")).text()
    start = time.process_time()
    text = equations.text()
    spent = time.process_time() - start
    assert len(text) > 5_000
    assert spent < 2.0  # measured: 0.15 s; the rest is for a busy machine
