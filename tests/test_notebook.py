"""What results look like in a notebook."""

from __future__ import annotations

import inspect
from dataclasses import fields

import numpy as np
import pytest

import mecanique as mq
from mecanique import notebook
from mecanique.figure.draw import figure_text

JOINTS = (
    mq.Fixed,
    mq.Revolute,
    mq.Prismatic,
    mq.Helical,
    mq.Planar,
    mq.Universal,
    mq.Spherical,
    mq.Floating,
)


@pytest.mark.parametrize("joint", JOINTS)
def test_joints_document_their_arguments(joint: type) -> None:
    text = inspect.getdoc(joint) or ""
    _, _, arguments = text.partition("Args:\n")
    for field in fields(joint):
        assert f"    {field.name}: " in arguments, field.name


def test_degrees_of_freedom_are_a_table() -> None:
    shown = mq.degrees_of_freedom(mq.textbook.load("slider_crank"))._repr_html_()
    assert "<td>degrees of freedom N</td><td>1</td>" in shown
    assert "<td>of them independent</td><td>2</td>" in shown


def test_modes_are_a_table() -> None:
    small = mq.linearize(mq.textbook.load("two_blocks"))
    shown = small._repr_html_()
    assert "<th>ω [rad/s]</th>" in shown
    assert "<th>q1 [m]</th>" in shown
    assert f"<td>{small.frequencies[0]:.6g}</td>" in shown
    assert shown.count("<tr>") == 1 + len(small.frequencies)


def test_steps_are_written_out() -> None:
    steps = mq.derive(mq.textbook.load("rigid_bar_pendulum")).steps
    shown = steps._repr_html_()
    assert shown.count("<h4>") == len(steps)
    assert shown.count("<math ") == sum(len(step.results) for step in steps)
    assert steps[0]._repr_html_() in shown


def test_single_equations_are_shown_without_a_script() -> None:
    equations = mq.derive(mq.textbook.load("rigid_bar_pendulum"))
    shown = equations.equations[0]
    assert shown._repr_html_() == shown.mathml()
    assert shown.left._repr_html_().startswith("<math ")


def test_a_linkage_is_drawn_where_its_motion_starts() -> None:
    """At zero crank and rod lie in one line, and there would be no angles to see."""
    linkage = mq.textbook.load("slider_crank")
    shown = linkage._repr_html_()
    start = figure_text(linkage, mq.textbook.entry("slider_crank").start)
    assert shown == start != figure_text(linkage, {})


def test_a_mechanism_is_shown_by_its_figure(monkeypatch: pytest.MonkeyPatch) -> None:
    mechanism = mq.textbook.load("rigid_bar_pendulum")
    shown = mechanism._repr_html_()
    assert shown is not None
    assert shown.startswith("<svg")
    bare = mq.Mechanism("bare", bodies=(mq.Body("ground"),), joints=(), gravity=(0, 0, 0))
    assert bare._repr_html_() is None
    monkeypatch.setattr(notebook, "_makers", {})
    assert mechanism._repr_html_() is None
    assert np.isfinite(mechanism.neutral()).all()
