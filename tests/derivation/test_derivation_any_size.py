"""Equations of any size are written as named results from body to body, and read back."""

from __future__ import annotations

import re
import time
from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
from derivation_reading import value_of_text
from systems import derive_system

import mecanique as mq
from mecanique import derive, textbook, write_recursion
from mecanique.derivation.document import Document
from mecanique.generation.named_results import Written
from mecanique.model.states import States
from mecanique.verification.states import random_states
from mecanique.viewing.scene.texts import document_of

ROLLING = ("ball_in_a_bowl", "ball_on_a_turntable", "rattleback", "snakeboard", "whipple_bicycle")
"""Systems that roll."""

COMPUTED = {
    "whipple_bicycle": ("lagrange", "newton_euler", "virtual_work"),
    "ball_in_a_bowl": ("virtual_work",),
}
"""Methods by which some have no closed form."""


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


def assert_names_are_defined(written: Written) -> None:
    meant = {name for names, _ in written.meanings for name in names}
    known = set(meant) | {"sin", "cos", "tan", "sqrt", "t"}
    for line in (*written.lines, *(f"end = {row}" for row in written.equations)):
        name, formula = line.split(" = ", 1)
        used = set(re.findall(r"(?<![\d.])[^\W\d]\w*'*", re.sub(r"\d[\d.]*e-?\d+", "0", formula)))
        unknown = {n for n in used if n not in known and n.rstrip("'") not in known}
        assert not unknown, line
        itself = re.sub(r"(sin|cos)_(\w+)", r"\1(\2)", name) == formula
        assert itself or name in {*meant, "end"} or re.fullmatch(r"x\d+", name)
        known.add(name)


def test_every_name_in_the_list_is_defined_before_it_is_used() -> None:
    assert_names_are_defined(write_recursion(derive(mq.read_urdf(mq.robot("panda")))))


def test_long_labels_stand_above_what_they_mean() -> None:
    written = write_recursion(derive(mq.read_urdf(mq.robot("panda")))).latex()
    items = [line for line in written.splitlines() if line.startswith("\\item")]
    assert any("\\hfill \\\\ angular acceleration" in line for line in items)
    assert any("\\hfill" not in line for line in items)


def test_the_list_says_what_coordinates_are_and_sets_no_initials_as_letters() -> None:
    written = write_recursion(derive(textbook.load("whipple_bicycle")))
    latex, page = written.latex(), written.mathml()
    said = "angle of the frame from the $x$ axis, positive"
    assert f"\\item[{{\\normalfont $\\alpha$}}] {said}" in latex
    assert "generalized velocity" not in latex
    for text in (latex, page):
        assert "Source: F. J. W. Whipple, Q. J. Pure Appl. Math." in text
    assert "a fork $H$ that turns in it" in latex
    assert "moments of inertia $I_{\\text{Rxx}}$, $I_{\\text{Fxx}}$ about a diameter" in latex
    assert "a fork <math><mi>H</mi></math> that turns in it" in page


@cache
def states_of(name: str) -> States:
    """Three states of a system; each takes a search where it rolls or has loops."""
    return random_states(textbook.load(name), 3, 5, lot=8)


def held(written: Written, equations: mq.Equations, states: States, off: float = 0.0) -> np.ndarray:
    """What is left of the equations of what rolls where it moves as it does, shape (n, rows)."""
    mechanism = equations.mechanism
    values: dict[str, Any] = {**mechanism.values, **states.values, "t": states.t}
    multipliers = equations.multipliers(states.q, states.v, states.t)
    a = np.asarray(equations.acceleration(states.q, states.v, states.t))
    values |= {f"{name}'": row + off for name, row in zip(mechanism.velocities, a.T, strict=True)}
    for row, force in multipliers.items():
        values[f"lambda_{row.replace(': ', '_')}"] = force
    if equations.method != "virtual_work":
        return read_back(written, values)
    # in every displacement that the conditions allow
    names = [f"δ{name.rstrip(chr(39))}" for name in mechanism.velocities]
    values |= dict.fromkeys(names, 0.0)
    columns = [read_back(written, {**values, name: 1.0}) for name in names]
    work, A = np.array(columns)[:, :, 0].T, np.array(columns)[:, :, 1 : 1 + len(multipliers)]
    found = []
    for k, own in enumerate(work):
        _, sizes, right = np.linalg.svd(A[:, k].T)
        free = right[int((sizes > 1e-9).sum()) :]
        found.append(np.concatenate([free @ own, columns[0][k, 1 + len(multipliers) :]]))
    return np.array(found)


@pytest.mark.parametrize("method", ["lagrange", "newton_euler", "virtual_work"])
@pytest.mark.parametrize("name", ROLLING)
def test_what_rolls_reads_back_by_every_method(name: str, method: str) -> None:
    equations = derive_system(name, method)
    assert equations.symbolic == (method not in COMPUTED.get(name, ()))
    written = write_recursion(equations)
    assert_names_are_defined(written)
    mechanism, states = equations.mechanism, states_of(name)
    forces = np.abs([*equations.multipliers(states.q, states.v, states.t).values()]).max()
    assert np.abs(held(written, equations, states)).max() < 1e-9 * max(forces, 1.0)
    assert np.abs(held(written, equations, states, off=1.0)).max() > 1e-3
    shown = {heading for heading, _, _ in written.sections()}
    assert ("Conditions on the displacements" in shown) == (method == "virtual_work")
    motions = 1 if method == "virtual_work" else mechanism.nv
    assert len(written.results[0].lines) == motions
    assert ("lambda" in str(written)) == (method != "virtual_work")


@pytest.mark.parametrize("method", ["lagrange", "newton_euler"])
def test_conditions_that_hold_by_themselves_are_left_out(method: str) -> None:
    """A disk that rolls in a plane does not slip across it."""
    equations = derive_system("rolling_disk", method)
    written, states = write_recursion(equations), states_of("rolling_disk")
    assert len(written.results[-1].lines) == 2
    assert "0 = 0" not in written.text()
    assert np.abs(held(written, equations, states)).max() < 1e-9
    assert np.abs(held(written, equations, states, off=1.0)).max() > 1e-3


def test_a_closed_mechanism_reads_back() -> None:
    equations = derive(textbook.load("four_bar_linkage"))
    states = states_of("four_bar_linkage")
    assert np.abs(held(write_recursion(equations), equations, states)).max() < 1e-9


def test_what_is_not_in_closed_form_points_to_its_list() -> None:
    assert "write_recursion lists them" in str(derive(textbook.load("bricard_linkage")))


def test_the_page_lists_symbols_and_results_of_what_rolls() -> None:
    # one that is not the catalogue's is not written as small deviations from its steady motion
    bicycle = replace(textbook.load("whipple_bicycle"), name="bicycle")
    equations, start = derive(bicycle), textbook.entry("whipple_bicycle").start
    motion = mq.simulate(bicycle, q=dict(start), duration=0.05)
    document = document_of(motion, [equations], None, [])
    meant = [sentence for _, sentence in document.symbols]
    assert "normal force of ground on rear_wheel in rear_contact, along the normal [N]" in meant
    assert "A rear frame B with its rider" in document.about
    blocks = document.derivations[0].blocks
    assert [block.heading for block in blocks if block.heading] == [
        "Constants",
        "Positions",
        "Velocities and accelerations",
        "Forces and moments",
        "Equations of motion",
        "Conditions",
    ]
    assert all(block.body.startswith("<math") for block in blocks)


@pytest.mark.parametrize(
    "limit",
    [
        "mecanique.derivation.equations.MOST_TERMS",
        # a finger with three hinges, free in space, has 1,594 terms; its page was 12.5 MB
        "mecanique.viewing.scene.texts.MOST_WRITTEN_OUT",
    ],
)
def test_the_page_does_not_write_out_steps_that_it_does_not_show(
    monkeypatch: pytest.MonkeyPatch, limit: str
) -> None:
    """A quadruped's steps are 12 MB of formulas, and took most of the time of its page."""
    equations = derive(textbook.load("double_pendulum"))
    motion = mq.simulate(textbook.load("double_pendulum"), duration=0.1)
    about = equations.document.introduction
    monkeypatch.setattr(limit, 3)
    monkeypatch.setattr(Document, "sections", None)
    document = document_of(motion, [equations], None, [])
    assert document.derivations[0].listed
    assert document.about == about


def test_names_of_results_keep_clear_of_the_letters() -> None:
    """A body called x1 has a coordinate x1."""
    rod = mq.Body("rod", mq.rod(2.0, 1.0))
    mechanism = mq.Mechanism(
        "named",
        (mq.Body("ground"), rod),
        (mq.Revolute("pin", "ground", "rod", axis=(0, 1, 0), coordinate="x1"),),
    )
    written = assert_reads_back(mechanism)
    assert not any(line.startswith("x1 =") for line in written.lines)


def test_printing_takes_time_in_proportion_to_what_is_printed() -> None:
    equations = derive(textbook.load("n_link_pendulum", n=12))
    _ = equations.derivation
    derive(textbook.load("double_pendulum")).text()
    start = time.process_time()
    text = equations.text()
    spent = time.process_time() - start
    assert len(text) > 5_000
    assert spent < 2.0  # measured: 0.15 s; the rest is for a busy machine


def test_relative_angles_cost_no_more_a_character_where_there_are_twice_as_many() -> None:
    """From rod to rod the number of terms grows with the fourth power of the links."""

    def spend(links: int) -> float:
        pendulum = textbook.load("n_link_pendulum", n=links)
        angles = tuple(name for joint in pendulum.joints for name in joint.coordinates)
        chain = replace(pendulum, coordinates=mq.Coordinates(angles, {}))
        start = time.process_time()
        text = derive(chain).text()
        return (time.process_time() - start) / len(text)

    spend(3)  # imports
    few, many = (min(spend(links) for _ in range(2)) for links in (4, 8))
    assert many < few  # measured: 0.08 of it


def test_the_terms_of_forces_count() -> None:
    """The springs of four hinges in space were 4,000 terms that nobody counted, a page of 7 MB."""
    blocks = derive(textbook.load("two_blocks"))
    free = derive(replace(textbook.load("two_blocks"), forces=()))
    assert free.terms == 2
    assert blocks.terms == free.terms + sum(map(len, blocks.derivation.Q))
    assert blocks.terms > free.terms
