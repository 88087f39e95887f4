"""LaTeX compiles with pdflatex and KaTeX, without errors and without lines wider than the page."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
from functools import cache
from pathlib import Path

import pytest
from systems import derive_system

import mecanique as mq
from mecanique import textbook
from mecanique.cli.derive import set_in_rows
from mecanique.derivation import METHODS
from mecanique.derivation.document import to_page
from mecanique.derivation.printing.lines import PAGE, align, display, number_rows, width
from mecanique.derivation.printing.prose import spell_greek, to_html, to_latex
from mecanique.derivation.printing.writers import Latex, MathML
from mecanique.model.mechanism.letters import letters_of_words

ROOT = Path(__file__).parents[2]
FORMULA = re.compile(
    r"(?<!\\)\$(?P<inline>[^$]+)\$|\\begin\{align\*\}(?P<rows>.*?)\\end\{align\*\}", re.DOTALL
)
KATEX = """
const katex = require("katex");
const formulas = JSON.parse(require("fs").readFileSync(0, "utf8"));
for (const formula of formulas)
  katex.renderToString(formula, {displayMode: true, throwOnError: true, strict: "error"});
console.log(formulas.length);
"""


def need(found: bool, what: str, word: str) -> None:
    """Skip, or fail where continuous integration requires it, what cannot be run here."""
    if not found:
        if word in os.environ.get("MECANIQUE_REQUIRE_BROWSERS", "").split():
            pytest.fail(f"no {what} found")
        pytest.skip(f"no {what} found")


def compile_latex(text: str, folder: Path) -> str:
    """Compile a document and return what pdflatex says."""
    need(shutil.which("pdflatex") is not None, "pdflatex (Debian's texlive-latex-base)", "texlive")
    (folder / "all.tex").write_text(text, encoding="utf-8")
    command = ["pdflatex", "-interaction=nonstopmode", "-halt-on-error", "all.tex"]
    done = subprocess.run(command, cwd=folder, capture_output=True, check=False)
    said = done.stdout.decode("utf-8", "replace")
    assert done.returncode == 0, said[-2000:]
    return said


def render_with_katex(formulas: list[str]) -> int:
    """Render formulas with KaTeX, which refuses what it does not know, and return how many."""
    need(shutil.which("node") is not None, "node", "node")
    command = ["node", "-e", KATEX]
    done = subprocess.run(
        command,
        input=json.dumps(formulas),
        cwd=ROOT,
        capture_output=True,
        encoding="utf-8",
        check=False,
    )
    need("Cannot find module 'katex'" not in done.stderr, "KaTeX (npm install)", "node")
    assert done.returncode == 0, done.stderr[-2000:]
    return int(done.stdout)


def formulas_of(fragment: str) -> list[str]:
    """The formulas of a fragment, as they are given to KaTeX."""
    found = []
    for match in FORMULA.finditer(fragment):
        rows = match["rows"]
        whole = f"\\begin{{align*}}{rows}\\end{{align*}}" if rows is not None else match["inline"]
        found.append(whole)
    return found


@cache
def fragments() -> dict[str, str]:
    """Every step of all systems by all methods in which they can be read."""
    found = {}
    for name in textbook.names():
        for method in METHODS:
            equations = derive_system(name, method)
            if equations.symbolic:
                found[f"{name} {method}"] = equations.latex(steps=True)
    return found


@pytest.mark.slow
def test_all_steps_of_all_systems_compile_and_keep_to_the_page(tmp_path: Path) -> None:
    parts = [f"\\typeout{{== {name}}}\\clearpage\n{text}" for name, text in fragments().items()]
    said = compile_latex(to_page(parts), tmp_path)
    assert said.count("== ") >= len(parts) > 100
    at = ""
    wide = []
    for line in said.splitlines():
        at = line if line.startswith("== ") else at
        if line.startswith("Overfull"):
            wide.append(f"{at}: {line}")
    assert not wide, wide


@pytest.mark.slow
def test_all_formulas_of_all_systems_are_rendered_by_katex() -> None:
    formulas = [formula for text in fragments().values() for formula in formulas_of(text)]
    assert render_with_katex(formulas) == len(formulas) > 3000


def test_steps_of_one_system_compile(tmp_path: Path) -> None:
    text = derive_system("bars_and_springs", "newton_euler").latex(steps=True)
    assert "Overfull" not in compile_latex(to_page([text]), tmp_path)


def test_formulas_for_a_notebook_are_rendered_by_katex() -> None:
    names = ("two_blocks", "crane", "slider_crank", "n_link_pendulum")
    formulas = [derive_system(name).latex() for name in names]
    assert render_with_katex(formulas) == len(formulas)


def test_pdflatex_reports_what_is_wider_than_the_page(tmp_path: Path) -> None:
    """The test above can fail: the same text on one line does not fit."""
    terms = " + ".join(f"a_{{{k}}} b_{{{k}}}" for k in range(40))
    assert "Overfull" in compile_latex(to_page([f"\\[ {terms} = 0 \\]"]), tmp_path)
    assert "Overfull" not in compile_latex(to_page([display([f"{terms} = 0"])]), tmp_path)


def test_long_formulas_are_broken_before_a_sign() -> None:
    terms = [f"a_{{{k}}} \\cos(q_{{{k}}})" for k in range(12)]
    rows = align([" + ".join(terms) + " = 0"]).split(" \\\\\n")
    assert len(rows) > 1
    assert all(row.startswith("& \\qquad + ") for row in rows[1:])
    assert all(width(row) <= PAGE + 20 for row in rows)
    assert (
        "".join(row.replace("& \\qquad", "").replace("& ", "", 1) for row in rows).count("a_") == 12
    )


def test_the_letters_before_a_wide_sum_stay_over_its_denominator() -> None:
    """Not \\frac{1}{20} 3 m (…): the fraction is that of the sum's factor."""
    inner = " + ".join(f"m_{{{k}}} l_{{{k}}}^{{2}}" for k in range(20))
    rows = align([f"x = \\frac{{3 m ({inner})}}{{20}} \\ddot{{q}}"])
    assert rows.startswith("x &= \\frac{3 m}{20} \\Bigl(m_{0}")
    wide = "4 (m_{1} + 3 m_{2}) - 9 m_{2} \\cos^{2}(q_{1} - q_{2})"
    (row, *_) = align([f"x = \\frac{{3 m ({inner})}}{{2 l ({wide})}}"]).split(" \\\\\n")
    assert row.startswith(f"x &= \\frac{{3 m}}{{2 l ({wide})}} \\Bigl(m_{{0}}")
    turned = align([f"x = \\frac{{m \\sin ({inner})}}{{20}} \\ddot{{q}}"])
    assert turned.startswith("x &= \\frac{1}{20} m \\sin \\Bigl(m_{0}")


def test_no_line_ends_within_the_argument_of_a_function() -> None:
    text = derive_system("double_pendulum").latex(steps=True)
    assert text.count("\\sin(") > 2
    assert re.search(r"\\(cos|sin)(\^\{2\})?\\Big", text) is None


def test_a_term_wider_than_the_page_is_broken_in_its_brackets() -> None:
    inner = " + ".join(f"m_{{{k}}} l_{{{k}}}^{{2}}" for k in range(20))
    rows = align([f"\\frac{{{inner}}}{{3}} \\ddot{{q}} = F"]).split(" \\\\\n")
    assert "\\frac{1}{3} \\Bigl(" in rows[0]
    assert "\\Bigr) \\ddot{q}" in rows[-1]
    assert all(width(row) <= PAGE + 20 for row in rows)


def test_a_denominator_wider_than_the_page_follows_a_stroke() -> None:
    inner = " + ".join(f"m_{{{k}}} l_{{{k}}}^{{2}}" for k in range(20))
    rows = align([f"-\\frac{{a + b}}{{{inner}}} c \\leq 0"]).split(" \\\\\n")
    assert rows[0].startswith("& -(a + b) c / \\Bigl(m_{0}")
    assert rows[-1].endswith("\\Bigr) \\leq 0")
    assert all(width(row) <= PAGE + 20 for row in rows)
    (held, *_, last) = align([f"\\left|\\frac{{a}}{{{inner}}}\\right| \\leq d"]).split(" \\\\\n")
    assert held.startswith("& \\Bigl|a / \\Bigl(")
    assert last.endswith("\\Bigr)\\Bigr| \\leq d")


def test_short_formulas_are_aligned_at_the_sign_of_equality() -> None:
    assert align(["T = 1", "V = 2"]) == "T &= 1 \\\\\nV &= 2"


@pytest.mark.parametrize(
    ("sentence", "latex"),
    [
        (
            "A bar AB of length 2 l is pinned at A, B lies above; both turn by asin(q / (2 l)).",
            r"A bar $AB$ of length $2 l$ is pinned at $A$, $B$ lies above; both turn by "
            r"$\arcsin(q / (2 l))$.",
        ),
        ("a rod of length a, sides a and b > a", r"a rod of length $a$, sides $a$ and $b > a$"),
        (
            "leaves 1 - 3/2 sin(a)^2 or (b + h)^2 of it",
            r"leaves $1 - 3/2 \sin(a)^{2}$ or $(b + h)^{2}$ of it",
        ),
        ("inertia I of a rod; book I, page 2", "inertia $I$ of a rod; book I, page 2"),
        ("for |q| < 4 l² and x = ±R only", r"for $|q| < 4 l^{2}$ and $x = \pm R$ only"),
        ("y = sqrt(l² - x²) at (-l sin(q), 0)", r"$y = \sqrt{l^{2} - x^{2}}$ at ($-l \sin(q)$, 0)"),
        ("the sun turns by (sun - arm) l/R", r"the sun turns by $(\text{sun} - \text{arm}) l/R$"),
        ("z = l cos(arm), in the x-z plane", r"$z = l \cos(\text{arm})$, in the $x$-$z$ plane"),
        ("d'Alembert's axis -y of `two_blocks`", r"d'Alembert's axis $-y$ of \texttt{two\_blocks}"),
        ("R_pin_n and δq", r"$R_{\text{pin},n}$ and $\delta q$"),
        ("the force of a body's spring", "the force of a body's spring"),
        ("resultant is F = -m a and a couple C, minus", None),
        ("that λ ∂Φ/∂q joins 5 % of [kg·m²]", None),
        ("its force F(t) = F0 cos(W t) acts", r"its force $F(t) = F_{0} \cos(W t)$ acts"),
    ],
)
def test_letters_in_sentences_are_mathematics(sentence: str, latex: str | None) -> None:
    expected = {
        "resultant is F = -m a and a couple C, minus": (
            "resultant is $F = -m a$ and a couple $C$, minus"
        ),
        "that λ ∂Φ/∂q joins 5 % of [kg·m²]": (
            r"that $\lambda \frac{\partial \Phi}{\partial q}$ joins 5 \% of "
            r"[kg$\cdot$m\textsuperscript{2}]"
        ),
    }
    names = {"R_pin_n", "δq", "F", "F0", "W", "t", "m", "l", "R", "q", "sun", "arm"}
    names |= {"a"} if "sides" in sentence else set()
    assert to_latex(sentence, names) == (latex or expected[sentence])


def test_letters_that_are_words_do_not_run_together() -> None:
    rim, sun = (Latex().letter(name, False, "") for name in ("rim", "sun"))
    assert Latex().term(["2", rim, sun], [], []) == r"2 \text{rim} \, \text{sun}"
    assert Latex().term(["m", rim], ["k", rim], []) == r"\frac{m \, \text{rim}}{k \, \text{rim}}"
    assert Latex().term([rim, "(a + b)"], [], []) == r"\text{rim} (a + b)"
    assert Latex().term(["m", "l"], [], []) == "m l"
    rim, sun = (MathML().letter(name, False, "") for name in ("rim", "sun"))
    assert "<mspace" in MathML().term([rim, sun], [], [])
    assert "<mspace" not in MathML().term(["<mi>m</mi>", "<mi>l</mi>"], [], [])


def test_subscripts_may_be_joined_on() -> None:
    written = [Latex().letter(name, False, "") for name in ("rs", "mR", "IBxx", "nu", "AB", "tau")]
    assert written == ["r_{s}", "m_{R}", r"I_{\text{Bxx}}", r"\nu", r"\text{AB}", r"\tau"]


def test_names_with_words_have_upright_subscripts() -> None:
    assert Latex().letter("R_pin_n", False, "") == r"R_{\text{pin},n}"
    assert Latex().letter("δW_q1", False, "") == r"\delta W_{q_{1}}"
    assert Latex().letter("lambda_B_x", False, "2") == r"\lambda_{B,x}^{2}"


def test_a_formula_has_its_number_at_its_last_row() -> None:
    long = " + ".join(f"m_{{{k}}} l^{{2}}" for k in range(40))
    written = display(["T = 1", f"V = {long}", "E = 2"])
    numbered = number_rows(f"before\n{written}\nafter")
    rows = numbered.split("\n")
    assert rows[:2] == ["before", "\\begin{align}"]
    assert rows[-2:] == ["\\end{align}", "after"]
    inside = rows[2:-2]
    assert len(inside) > 4
    unnumbered = ["\\nonumber" in row for row in inside]
    assert unnumbered == [False, *[True] * (len(inside) - 3), False, False]
    # no page ends after the first formula, within the second or before the last
    assert ["\\\\*" in row for row in inside] == [*[True] * (len(inside) - 1), False]
    assert (
        re.sub(r" \\nonumber|(?<=\\)\*", "", numbered).replace("{align}", "{align*}")
        == f"before\n{written}\nafter"
    )


def test_a_point_with_a_prime_is_no_rate() -> None:
    """B' is a point beside B; x' is a rate."""
    words, names = "A spring holds the middle B' of ABC while x' = 0.", {"x"}
    assert to_latex(words, names) == "A spring holds the middle $B'$ of ABC while $\\dot{x} = 0$."
    page = to_html(words, names)
    assert "<msup><mi>B</mi><mo>′</mo></msup>" in page
    assert page.count("˙") == 1


def test_a_power_after_brackets_is_raised_on_a_page() -> None:
    assert to_html("leaves 3/2 sin(a)^2 of it").endswith(")<sup>2</sup> of it")


def test_a_page_may_end_after_any_row_of_pictures(tmp_path: Path) -> None:
    rows = set_in_rows(["\\rule{300pt}{250pt}"] * 3)
    assert "Overfull" not in compile_latex(to_page([rows]), tmp_path)


def make_turntable(*names: str, parameter: str = "c") -> mq.Mechanism:
    """Return disks that turn one on another, the first held by a spring."""
    disks = [mq.Body(f"disk{k}", mq.disk(1.0, 1.0)) for k in range(len(names))]
    seats = zip(["ground", *(disk.name for disk in disks)], disks, names, strict=False)
    joints = [mq.Revolute(f"hinge_{disk.name}", on, disk.name, axis=(0, 0, 1), coordinate=name)
              for on, disk, name in seats]  # fmt: skip
    stiffness = mq.Parameter(parameter, 1.0)
    spring = mq.JointSpring("spring", joints[0].name, stiffness)
    bodies = (mq.Body("ground"), *disks)
    return mq.Mechanism(
        "turntable", bodies, tuple(joints), parameters=(stiffness,), forces=(spring,)
    )


def test_angles_that_are_called_by_words_have_letters() -> None:
    """Books write psi and phi; text, which is typed, keeps the names."""
    assert letters_of_words(make_turntable("yaw", "crank", "theta1", "rear_spin", "q")) == {
        f"{of}{name}": f"{of}{letter}"
        for of in ("", "δ", "p_", "P_", "pi_", "Q_", "W_", "δW_", "sin_", "cos_")
        for name, letter in (("yaw", "psi"), ("crank", "phi_crank"), ("rear_spin", "phi_rear"))
    }
    equations = mq.derive(make_turntable("yaw"))
    assert equations.latex().count("\\psi") == 2
    assert equations.equations[0].latex().count("\\psi") == 2
    assert "ψ" in equations.mathml()
    assert equations.equations[0].mathml().count("<mi>ψ</mi>") == 2
    assert "yaw''" in str(equations)
    assert {str(symbol) for symbol in equations.Q.free_symbols} == {"c", "yaw"}
    steps = equations.latex(steps=True)
    assert "\\item[{\\normalfont $\\psi$}] yaw, rotation of disk0" in steps
    assert "Operator for $\\psi$" in steps
    assert "\\frac{\\partial T}{\\partial \\dot{\\psi}}" in steps
    assert "\\text{yaw}" not in steps


@pytest.mark.parametrize(
    ("names", "parameter", "letter"),
    [
        (("yaw", "psi"), "c", "phi"),
        (("yaw",), "psi", "phi"),
        (("yaw", "roll"), "psi", "theta"),
        (("yaw", "heading"), "c", "psi"),
    ],
)
def test_no_letter_stands_for_two_words(
    names: tuple[str, ...], parameter: str, letter: str
) -> None:
    mechanism = make_turntable(*names, parameter=parameter)
    letters = letters_of_words(mechanism)
    assert letters["yaw"] == letter
    printed = [letters.get(name, name) for name in (*mechanism.coordinates, parameter)]
    assert len({*printed}) == len(names) + 1


def test_a_condition_of_rolling_keeps_its_letter() -> None:
    """psi = 0 is the condition, so the heading of a coin is another letter."""
    coin = mq.textbook.load("rolling_coin")
    letters = letters_of_words(coin)
    assert [letters[name] for name in ("yaw", "lean", "spin")] == ["alpha", "theta", "phi"]
    written = mq.derive(coin).latex(steps=True)
    assert "$z = r \\cos(\\theta)$" in written
    assert "\\text{lean}" not in written
    # a page sets its prose from text
    said = mq.derive(coin).document.introduction
    assert (
        "the angle α of its heading, its lean to the right and the angle φ about its axis" in said
    )
    wheels = {"rear_spin": "phi_rear", "front_spin": "phi_front"}
    said = spell_greek("the turns rear_spin and front_spin'", {*wheels}, wheels)
    assert said == "the turns φ_rear and φ_front'"


@pytest.mark.parametrize(
    ("sentence", "written"),
    [
        ("The constraints leave x, yaw, lean and spin free.", 4),
        ("M q'' = 0 for q = (lean, spin).", 4),
        ("its axis, turned by -lean about y", 2),
        ("the angle yaw of its heading, its lean to the right and its spin", 1),
        ("The coins spin; their lean, and yaw, and a half-turn.", 0),
    ],
)
def test_words_are_letters_where_they_are_names(sentence: str, written: int) -> None:
    letters = {"yaw": "alpha", "lean": "theta", "spin": "phi"}
    names = {"x", "y", *letters}
    assert to_latex(sentence, names, (), letters).count("$") == 2 * written


def test_lists_of_named_results_have_letters_for_words() -> None:
    coin = mq.derive(mq.textbook.load("rolling_coin"), method="virtual_work")
    page = mq.write_recursion(coin).latex()
    assert "\\text{cos}_{\\alpha} &= \\cos \\alpha" in page
    assert "virtual displacement along $\\dot{\\theta}$" in page
    said = derive_system("rolling_coin", "virtual_work").latex(steps=True)
    assert "leaves 3 independent, $\\delta \\alpha$, $\\delta \\theta$ and" in said
    assert not re.search(r"\\text\{(yaw|lean|spin)\}", page)
    assert "_yaw" not in mq.write_recursion(coin).mathml()
