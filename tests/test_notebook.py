"""What results look like in a notebook."""

from __future__ import annotations

import inspect
import re
from dataclasses import fields
from html import escape
from pathlib import Path

import numpy as np
import pytest

import mecanique as mq
from mecanique import notebook
from mecanique.derivation.printing.writers import MathML
from mecanique.figure.draw import figure_text
from mecanique.wording import Legible

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
    assert shown.count('role="math"') == sum(len(step.results) for step in steps)
    assert steps[0]._repr_html_() in shown


def test_single_equations_are_shown_without_a_script() -> None:
    equations = mq.derive(mq.textbook.load("rigid_bar_pendulum"))
    shown = equations.equations[0]
    assert pieces_of(shown._repr_html_()) == content_of(shown.mathml())
    assert pieces_of(shown.left._repr_html_()) == content_of(shown.left.mathml())


def content_of(mathml: str) -> list[str]:
    """Return the tokens of a formula, in their order."""
    return re.findall(r"<m(?:i|n|o)[^>]*>([^<]*)<", mathml.replace("&#x", "").replace(";", ""))


def pieces_of(shown: str) -> list[str]:
    """Return the tokens of a formula that may break, in their order."""
    for invisible in "\u2061\u2062":
        shown = shown.replace(invisible, f"{ord(invisible):x}")
    return content_of(shown.replace("&#x200b;", ""))


def test_equations_wrap_at_their_terms() -> None:
    shown = mq.derive(mq.textbook.load("double_pendulum")).equations[0]
    html = shown._repr_html_()
    assert html.count("<math ") == 4  # two accelerations, a square, gravity with "= 0"
    assert html.count("&#x200b;") == 3
    assert html.endswith('<mo form="infix">=</mo><mrow><mn>0</mn></mrow></math></div>')
    assert f'aria-label="{escape(shown.text(), quote=True)}"' in html


def test_functions_keep_clear_of_letters_below_a_bar() -> None:
    writer = MathML()
    below = [writer.letter("c", False, ""), writer.call("sin", "<mi>q</mi>", "2")]
    space = '<mspace width="0.1667em"/>'
    fraction = writer.term(["<mi>a</mi>"], [*below, *below], [])
    assert fraction.count(f"<mi>c</mi><mo>&#x2062;</mo>{space}<mrow><msup><mi>sin</mi>") == 2
    assert fraction.count(f"</mrow><mo>&#x2062;</mo>{space}<mi>c</mi>") == 1


def test_newton_and_euler_show_their_reactions() -> None:
    pendulum = mq.textbook.load("rigid_bar_pendulum")
    equations = mq.derive(pendulum, "newton_euler")
    html = equations._repr_html_()
    assert "<h4>Reactions</h4>" in html
    reaction = next(step for step in equations.steps if step.title == "Reactions").results[0]
    assert reaction._repr_html_() in html
    assert "force that the ground exerts on the rod in the pin, towards the pin" in html
    assert "<h4>Reactions</h4>" not in mq.derive(pendulum)._repr_html_()


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


class Paper:
    """What a notebook prints on: lines of text."""

    def __init__(self) -> None:
        self.lines = [""]

    def text(self, written: str) -> None:
        self.lines[-1] += written

    def break_(self) -> None:
        self.lines.append("")


def test_results_name_themselves_in_one_line_and_print_whole() -> None:
    pendulum = mq.textbook.load("rigid_bar_pendulum")
    down, up = mq.equilibria(pendulum)
    assert repr(up).startswith("<Equilibrium: rigid_bar_pendulum about the unstable equilibrium q")
    paper = Paper()
    down._repr_pretty_(paper, False)
    assert "\n".join(paper.lines) == str(down)
    wrench = mq.Reference(pendulum).reactions({"q": 0.0})["pin"]
    weight = f"{pendulum.values['m'] * pendulum.values['g']:g}"
    assert repr(wrench).startswith("<Wrench: force: [")
    assert f" {weight}]; " in repr(wrench)
    assert "places" not in repr(wrench)
    motion = mq.simulate(pendulum, q={"q": 1.0}, duration=1.0, samples=61)
    assert repr(motion.audit()) == "<Audit: 4 balances, all within their limits>"
    assert "shape (61,), 0 … 1" in repr(motion.energy())
    track = repr(motion.point("rod", (0, 0, -1)))
    assert track.startswith("<PointMotion: position: shape (61, 3), ")
    quake = mq.Record(np.arange(200.0), np.zeros(200))
    assert repr(quake) == "<Record: times: shape (200,), 0 … 199; values: shape (200,), 0 … 0>"
    orbit = mq.routh(mq.textbook.load("kepler_orbit"))
    assert repr(orbit) == "<Reduction: kepler_orbit without phi>"
    equations = mq.derive(pendulum)
    assert repr(equations.derivation) == f"<Derivation: {len(equations.steps)} steps>"
    assert repr(equations.document) == "<Document: Lagrange's equations of the second kind>"
    shown = [mq.verify(pendulum, samples=3), mq.linearize(pendulum), mq.derive(pendulum).steps[0]]
    shown += [mq.derive(pendulum).equations[0], mq.textbook.entry("rigid_bar_pendulum")]
    shown += [mq.Reference(pendulum), mq.degrees_of_freedom(pendulum)]
    shown += [mq.convert(pendulum, "SDF", states=3), mq.inertial_check(pendulum, motion, 0.8)]
    shown += [mq.derive_modes(pendulum), mq.write_recursion(mq.derive(pendulum))]
    shown += mq.lint("<robot name='r'><link name='a'/><link name='b'/></robot>")
    for result in shown:
        assert repr(result).startswith(f"<{type(result).__name__}")
        assert len(repr(result)) < 120


def test_an_audit_is_a_table() -> None:
    audit = mq.simulate(mq.textbook.load("rigid_bar_pendulum"), q={"q": 1.0}).audit()
    shown = audit._repr_html_()
    assert shown.count("<tr>") == 1 + len(audit.rows)
    assert f"<td>{audit['energy'].residual:.2e} J</td>" in shown
    assert f"<p>{str(audit).splitlines()[-1]}</p>" in shown


def test_what_happened_is_told_in_lines() -> None:
    belt = mq.textbook.load("stick_slip")
    motion = mq.simulate(belt, q={"x": 0.0}, v={"x": 0.1}, duration=0.5)
    assert repr(motion.modes[0]) == "<ModeSpan: 0 to 0.3924 s: belt sticks>"
    assert repr(motion.events[0]) == "<Occurrence: belt: slips -: t = 0.3924 s>"


def test_equations_of_modes_are_set_as_others_are() -> None:
    """A block on a belt: m x'' = −k x − μ m g while it slips forward."""
    shown = mq.derive_modes(mq.textbook.load("stick_slip"))._repr_html_()
    sticks, forward, back = shown.split("<h4>")[1:]
    assert [text.partition("<")[0] for text in (sticks, forward, back)] == [
        "belt sticks",
        "belt slips +",
        "belt slips -",
    ]
    assert 'aria-label="x&#x27;&#x27; = -(m mu g + k x)/m"' in forward
    assert 'aria-label="R_belt = k x"' in sticks
    assert "<mi>μ</mi>" in forward
    assert "<mo>&lt;</mo><mrow><mn>0</mn></mrow></mrow></math></p>" in back


def test_a_picture_is_shown_and_written_only_where_asked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    pendulum = mq.textbook.load("rigid_bar_pendulum")
    drawing = mq.picture(pendulum)
    assert not [*tmp_path.iterdir()]
    assert repr(drawing) == "<Drawing: Rigid bar pendulum>"
    assert drawing.svg in drawing._repr_html_()
    path = mq.picture(pendulum, path="drawn.svg")
    assert path.read_text("utf-8") == drawing.svg


def test_letters_of_sentences_are_set_as_in_formulas() -> None:
    from mecanique.derivation.printing.prose import to_html

    said = to_html("A force R_pin_n acts on a rod, m l²/12 & a couple about O", {"l"})
    assert said == (
        "A force <math><msub><mi>R</mi><mrow><mi>pin</mi><mtext>,</mtext><mi>n</mi></mrow></msub>"
        "</math> acts on a rod, <math><mi>m</mi></math> <math><msup><mi>l</mi><mn>2</mn></msup>"
        "</math>/12 &amp; a couple about <math><mi>O</mi></math>"
    )


def test_derivatives_and_squares_of_rates_are_set_as_in_formulas() -> None:
    from mecanique.derivation.printing.prose import to_html

    theta, rate = "<math><mi>θ</mi></math>", '<mover accent="true"><mi>θ</mi><mo>˙</mo></mover>'
    said = to_html("C = ½ dJ/dtheta, d²K/dtheta² and ∂T/∂theta; L theta'² of dynamics/data")
    assert said == (
        f"<math><mi>C</mi></math> = ½ d<math><mi>J</mi></math>/d{theta}, "
        f"d²<math><mi>K</mi></math>/d{theta}² and ∂<math><mi>T</mi></math>/∂{theta}; "
        f"<math><mi>L</mi></math> <math><msup>{rate}<mn>2</mn></msup></math> of dynamics/data"
    )
    assert to_html("d'Alembert's principle") == "d&#x27;Alembert&#x27;s principle"
    element = to_html("the inertia force -a dm, opposite to its acceleration")
    assert element == (
        "the inertia force -<math><mi>a</mi></math> d<math><mi>m</mi></math>,"
        " opposite to its acceleration"
    )


def test_titles_are_set_as_sentences_are() -> None:
    shown = mq.reduce_loops(mq.textbook.load("slider_crank"), "theta")._repr_html_()
    assert "<h3>Slider crank: the equation in <math><mi>θ</mi></math> alone</h3>" in shown
    assert "<h4>Inertia referred to <math><mi>θ</mi></math></h4>" in shown
    # Jupyter gives terms a fifth of the width they are in, where letters would break apart
    assert "<dt>" not in shown


def test_a_summary_is_printed_line_by_line() -> None:
    summary = mq.simulate(mq.textbook.load("rigid_bar_pendulum"), duration=0.1).summary()
    paper = Paper()
    assert isinstance(summary, Legible)
    summary._repr_pretty_(paper, False)
    assert "\n".join(paper.lines) == summary


def test_initials_of_a_source_are_no_letters() -> None:
    shown = mq.derive(mq.textbook.load("four_bar_linkage"))._repr_html_()
    assert "<p>Source: F. Freudenstein, Trans. ASME 77 (1955) 853;" in shown
    assert "A crank of length <math><mi>a</mi></math> and mass" in shown
