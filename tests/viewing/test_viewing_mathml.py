"""What looks like MathML passes as MathML and nothing else does."""

from __future__ import annotations

import re
from xml.etree import ElementTree

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mecanique.viewing.page.panels import safe, write_equations
from mecanique.viewing.scene.scene import DerivationStep, SceneText, ShownDerivation


def test_equations_pass() -> None:
    text = "<math display='block'><mrow><mi>x</mi><mo>=</mo><mn>1</mn></mrow></math>"
    inner = "<mrow><mi>x</mi><mo>=</mo><mn>1</mn></mrow>"
    assert safe(text) == f'<math display="inline" alttext="x = 1">{inner}</math>'
    assert safe("<mi>θ</mi>", display=True) == (
        '<math display="block" alttext="θ"><mi>θ</mi></math>'
    )


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("<math><mi onclick='x()'>a</mi></math>", "<mi>a</mi>"),
        ("<math><script>alert(1)</script></math>", "<mtext>alert(1)</mtext>"),
        ("<math href='javascript:x()'><mi>a</mi></math>", "<mi>a</mi>"),
        (
            "<math><annotation-xml><img src='x' onerror='y()'/></annotation-xml></math>",
            "<mtext></mtext>",
        ),
        ("<math><mi>a</mi></math><img src='x'/>", "<math><mi>a</mi></math><mtext></mtext>"),
        ("<marquee>x</marquee>", "<mtext>x</mtext>"),
    ],
)
def test_anything_else_becomes_text(text: str, expected: str) -> None:
    found = re.sub(r' alttext="[^"<>]*"', "", safe(text), count=1)
    assert found == f'<math display="inline">{expected}</math>'


def test_what_is_not_well_formed_is_escaped() -> None:
    assert safe("<math><mi>a</math>") == "&lt;math&gt;&lt;mi&gt;a&lt;/math&gt;"


@settings(deadline=None, max_examples=30)
@given(st.text(max_size=60))
def test_plain_text_is_escaped(text: str) -> None:
    found = safe(text)
    if "<math" not in found:
        assert "<" not in found
    else:
        ElementTree.fromstring(found)


def test_letters_of_a_steps_sentence_are_set() -> None:
    step = DerivationStep("Reactions", "", lead="R_pin_n pulls along the rod.")
    shown = write_equations(SceneText(derivations=(ShownDerivation("Newton", (step,)),)))
    assert "</msub></math> pulls along the rod.</p>" in shown


def test_components_in_a_list_of_symbols_may_stand_in_lines_of_their_own() -> None:
    letters = "<math><mi>F</mi><mo>,</mo><mi>N</mi></math>"
    shown = write_equations(SceneText(symbols=((letters, "force"),)))
    assert len(re.findall("<math.*?</math>", shown)) == 2
    assert "</math>,</span> <math" in shown
