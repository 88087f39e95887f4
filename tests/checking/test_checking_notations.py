"""The notations people write equations in, each a right answer that must be accepted."""

from __future__ import annotations

import pytest

import mecanique as mq
from mecanique.checking.grammar.letters import KnownLetters
from mecanique.checking.grammar.reader import read

TWO = (r"2 l_1 (m_1 + 3 m_2) A + 3 l_2 m_2 \cos(B) C + 3 l_2 m_2 \sin(B) D + 3 g (m_1 + 2 m_2) "
       r"\sin E = 0")  # fmt: skip
CART = "(M + m) x'' + m l cos q q'' - m l sin q q'^2 + c x' = F"
POLE = "cos q x'' + l q'' + g sin q = 0"
IN_LATEX = (
    r"(M + m) \ddot x + m l \cos q \, \ddot q - m l \sin q \, \dot q^2 + c \dot x",
    r"\cos q \, \ddot x + l \ddot q + g \sin q",
)

RODS = (
    r"\frac{d^{2}q(t)}{dt^{2}} = -\frac{3g}{2l}\sin(q(t))",
    r"\frac{l^{2} m \frac{d^{2}}{d t^{2}} q{\left(t \right)}}{3} = - \frac{g l m"
    r" \sin{\left(q{\left(t \right)} \right)}}{2}",
    r"\begin{align*} \ddot{q}&=-\frac{3g}{2l}\sin q. \end{align*}",
    r"\[ \boxed{\ddot{q}=-\frac{3g}{2l}\sin q}. \]",
    "ddot(q) = -1.5 g/l sin q",
    "ddq = -1.5 g/l sin q",
    "qdd = -1.5*pow(l, -1)*g*sin(q)",
    "l.^2.*m.*qdd/3 = -g.*l.*m.*sin(q)/2",
    "Matrix([[g*l*m*sin(q(t))/2 + l**2*m*Derivative(q(t), (t, 2))/3]])",
    "<math><mover><mi>q</mi><mo>&uml;</mo></mover><mo>=</mo><mo>&minus;</mo><mfrac><mrow><mn>3</mn>"
    "<mi>g</mi></mrow><mrow><mn>2</mn><mi>l</mi></mrow></mfrac><mi>sin</mi><mo>&ApplyFunction;</mo>"
    "<mrow><mo>(</mo><mi>q</mi><mo>)</mo></mrow></math>",
    "<math><mfrac><mrow><msup><mi>d</mi><mn>2</mn></msup><mi>q</mi></mrow><mrow><mi>d</mi><msup>"
    "<mi>t</mi><mn>2</mn></msup></mrow></mfrac><mo>=</mo><mo>-</mo><mn>1.5</mn><mi>g</mi>"
    "<mo>/</mo><mi>l</mi><mi>sin</mi><mi>q</mi></math>",
)

DOTS = (
    (r"\ddot\theta_1", r"\ddot\theta_2", r"\dot\theta_2^2"),
    (r"\ddot{\theta}_1", r"\ddot{\theta_2}", r"\dot{\theta}_{2}^{2}"),
    (r"\theta_1^{\prime\prime}", r"\theta_2''", r"{\theta_2'}^2"),
    (r"\frac{d^2\theta_1}{dt^2}", r"\frac{\mathrm{d}^2 \theta_2}{\mathrm{d}t^2}",
     r"\left(\frac{d\theta_2}{dt}\right)^2"),
    (r"\ddot{\theta}_1(t)", r"\frac{d^{2}}{d t^{2}} \theta_{2}{\left(t \right)}",
     r"\dot{\theta}_2(t)^2"),
)  # fmt: skip


@pytest.mark.parametrize("text", RODS)
def test_one_equation_is_read_in_many_notations(text: str) -> None:
    found = mq.check(mq.textbook.load("rigid_bar_pendulum"), text)
    assert found.right, str(found)


@pytest.mark.parametrize("dots", DOTS)
def test_dots_and_subscripts_of_latex(dots: tuple[str, str, str]) -> None:
    text = TWO
    angles = r"\theta_1 - \theta_2", r"\theta_1"
    for name, written in zip("ACDBE", (*dots, *angles), strict=True):
        text = text.replace(f" {name} ", f" {written} ").replace(f"({name})", f"({written})")
    text = text.replace(r"\sin E", rf"\sin {angles[1]}")
    let = ["theta1 = q1", "theta2 = q2"]
    found = mq.check(mq.textbook.load("double_pendulum"), text, let=let)
    assert found.outcome == "incomplete"
    assert found.lines[0].outcome == "right", str(found)


@pytest.mark.parametrize(
    "text",
    [
        f"1) {CART}\n2) {POLE}",
        f"(1) {CART}\n(2) {POLE}",
        f"{CART} and {POLE}",
        f"[{CART.removesuffix(' = F')} - F, {POLE.removesuffix(' = 0')}]",
        r"\begin{cases} FIRST = F \\ SECOND = 0 \end{cases}",
        r"\left\{\begin{array}{l} FIRST = F \\ SECOND = 0 \end{array}\right.",
        r"\begin{eqnarray} FIRST &=& F, \\ SECOND &=& 0. \end{eqnarray}",
        r"\begin{bmatrix} M+m & m l \cos q \\ m l \cos q & m l^2 \end{bmatrix}"
        r"\begin{bmatrix} \ddot x \\ \ddot q \end{bmatrix} ="
        r"\begin{bmatrix} F - c \dot x + m l \dot q^2 \sin q \\ - m g l \sin q \end{bmatrix}",
        r"\left[\begin{array}{cc} M+m & m l \cos q \\ \cos q & l \end{array}\right]"
        r"\left[\begin{array}{c} \ddot x \\ \ddot q \end{array}\right] +"
        r"\left(\begin{array}{c} c \dot x - m l \dot q^2 \sin q - F \\ g \sin q \end{array}\right)"
        "= 0",
    ],
)
def test_sets_of_equations_are_read_in_many_notations(text: str) -> None:
    text = text.replace("FIRST", IN_LATEX[0]).replace("SECOND", IN_LATEX[1])
    found = mq.check(mq.textbook.load("cart_pole"), text)
    assert found.right, str(found)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("[[M, m], [m, M]] [x''; q''] = [F; 0; 1]", "expected 2 entries on both sides, got 3"),
        ("[[M, m], [m, M]] [x''; q''; 1] = 0", "2 × 2 cannot be multiplied by one of 3 × 1"),
        ("[x''; q''] + [1; 2; 3] = 0", "2 × 1 and one of 3 × 1 cannot be added"),
        ("[x''; q''] + F = 0", "a matrix and a formula cannot be added"),
        (r"{M \over m} x'' = F", "write \\frac"),
    ],
)
def test_matrices_that_do_not_fit_are_refused(text: str, message: str) -> None:
    with pytest.raises(mq.FormulaError) as caught:
        mq.check(mq.textbook.load("cart_pole"), text)
    assert message in str(caught.value)


def test_lines_that_latex_breaks_belong_to_their_equation() -> None:
    mechanism = mq.textbook.load("planetary_gear")
    text = mq.derive(mechanism).latex()
    assert text.count("\\qquad") > 3
    assert mq.check(mechanism, text).right


def test_a_subscript_may_have_one_of_its_own() -> None:
    letters = KnownLetters({"lambda_P3_x": "other"}, {})
    (found,) = read(r"\lambda_{P_{3},x}", letters)
    assert found.sides[0].name == "lambda_P3_x"


@pytest.mark.parametrize(
    "text",
    [
        "m l^2 q''[t] + m g l Sin[q[t]] == 0",
        "l Derivative[2][q][t] + g Sin[q[t]] == 0",
        "{l D[q[t], {t, 2}] + g Sin[q[t]] == 0}",
        "m*l**2*q.diff(t, 2) + m*g*l*np.sin(q) = 0",
        r"\Rightarrow \mathbf{\ddot q} + \frac{g}{l} \sin q = 0",
        r"\frac{\partial^2 q}{\partial t^2} + \frac gl \sin q = 0",
        "∂²q/∂t² + g/l sin q = 0",
        "q'' tan q cot q + g/l sin q = 0",
        r"\ddot q \sec q \cos q + \frac{g}{l \csc q} = 0",
        "l q'' + g sen q = 0",
        "q̈ + (g∕l)·sin q ＝ 0",
        "q“ + g⁄l sin q = 0",
        "-m g l sin q = m l^2 q''",
    ],
)
def test_notations_of_programs_and_phones_are_read(text: str) -> None:
    verdict = mq.check(mq.textbook.load("simple_pendulum"), text)
    assert verdict.right, str(verdict)


@pytest.mark.parametrize("between", [" && ", r" \iff ", r" \\ "])
def test_equations_may_be_joined_in_one_line(between: str) -> None:
    """Mathematica joins equations by &&, LaTeX by arrows and line ends."""
    rows = ["m1 q1'' + (k1 + k2) q1 - k2 q2 == 0", "m2 q2'' + k2 (q2 - q1) - F == 0"]
    verdict = mq.check(mq.textbook.load("two_blocks"), between.join(rows))
    assert verdict.right, str(verdict)
    assert len(verdict.lines) == 2


@pytest.mark.parametrize(
    "text",
    [
        "“q'' = -3 g/(2 l) sin q”,",
        "„q” + 3 g/(2 l) sin q = 0“\r\n",
        "\"q'' = -3 g/(2 l) sin q\".",
        '«q" + 3 g/(2 l) sin q = 0»',
    ],
)
def test_quotation_marks_around_a_line_are_no_primes(text: str) -> None:
    assert mq.check(mq.textbook.load("rigid_bar_pendulum"), text).right


@pytest.mark.parametrize(
    ("text", "notes"),
    [
        ("1.0 q'' + 1,5 g/l sin q = 0", None),
        ("q'' + 1,000 g/l sin q = 0", None),
        ("q'' + 1,5 g/l sin q = 0", ("1,5 is read as 1.5",)),
        (
            "The equation of motion is q'' = -3 g/(2 l) sin(q).",
            ("set aside: 'The equation of motion is'",),
        ),
        ("I get q'' = -3 g/(2 l) sin q", ("set aside: 'I get'",)),
        ("I q'' = -m g l/2 sin q, I = m l^2/3", ("taken as a definition: 'I = m l^2/3'",)),
        ("a = q'' = -3 g/(2 l) sin q", ("taken as a definition: 'a = q'''",)),
        ("Por lo tanto: l q'' = -1.5 g sen q", ("set aside: 'Por lo tanto'",)),
        (
            "q'' + omega0^2 sin q = 0 with omega0^2 = 3 g/(2 l)",
            ("set aside: 'with'", "taken as a definition: 'omega0^2 = 3 g/(2 l)'"),
        ),
        ("J = m l^2/3\nJ q'' + m g l/2 sin q = 0", ("taken as a definition: 'J = m l^2/3'",)),
    ],
)
def test_what_is_not_plain_is_told_or_asked(text: str, notes: tuple[str, ...] | None) -> None:
    rod = mq.textbook.load("rigid_bar_pendulum")
    if notes is None:
        with pytest.raises(mq.FormulaError, match="may be one number or two"):
            mq.check(rod, text)
        return
    verdict = mq.check(rod, text)
    assert verdict.right, str(verdict)
    assert verdict.notes == notes
    assert verdict.to_dict()["notes"] == list(notes)
    assert f"note: {notes[0]}" in str(verdict)


def test_both_signs_are_two_answers() -> None:
    hoop = mq.textbook.load("bead_on_hoop")
    both = mq.check(hoop, r"theta = 0; theta = pi; theta = \pm\arccos(g/(R W^2))", "equilibrium")
    assert both.right
    one = mq.check(hoop, "theta = 0; theta = pi; theta = acos(g/(R W^2))", "equilibrium")
    assert one.outcome == "incomplete"


RODS_MATRIX = "[[(m1/3 + m2) l1^2, m2 l1 l2 cos(q1 - q2)/2], [m2 l1 l2 cos(q1 - q2)/2, m2 l2^2/3]]"


@pytest.mark.parametrize(
    ("system", "ask", "text"),
    [
        ("rigid_bar_pendulum", "equilibrium", "q = 0, pi"),
        ("rigid_bar_pendulum", "equilibrium", "q = 0 or q = π"),
        ("bead_on_hoop", "equilibrium", r"\theta = 0, \pi, \pm\arccos\frac{g}{W^2 R}"),
        ("bead_on_hoop", "equilibrium", "theta = pi, 0, acos(g/(W^2 R)), -acos(g/(W^2 R))"),
        (
            *("spherical_pendulum", "steady motion"),
            "phi' = sqrt(g/(l cos theta)), -sqrt(g/(l cos theta))",
        ),
        ("rigid_bar_pendulum", "period", "2*Pi*Sqrt[2*l/(3*g)]"),
        (
            *("simple_pendulum", "period"),
            "Para pequeñas oscilaciones el período es T = 2π √(l/g).",
        ),
        ("simple_pendulum", "kinetic energy", "L'énergie cinétique vaut T = 1/2 m l^2 q'^2"),
        (
            *("spherical_pendulum", "conserved quantity"),
            "Zachowany jest moment pędu: m l² sin²θ φ' = const",
        ),
        ("simple_pendulum", "equation of motion", "Für das Pendel: q̈ + g/l sin(q) = 0"),
        ("simple_pendulum", "equation of motion", "L'equazione del moto è q̈ + g/l sin(q) = 0"),
        ("atwood_machine", "equation of motion", "Gleichung: (m1 + m2 + M/2) x'' = (m1 - m2) g"),
        (
            *("bead_on_hoop", "conserved quantity"),
            "Jacobi-Integral: m R^2 (theta'^2 - W^2 sin(theta)^2)/2 - m g R cos(theta)",
        ),
        (
            *("chaplygin_sleigh", "reaction"),
            "L'effort latéral de la lame : "
            "lambda_edge_side = m I (x' cos(theta) + y' sin(theta)) theta'/(I + m a^2)",
        ),
        (
            *("free_planar_body", "equation of motion"),
            "As equações do movimento são m x'' = 0, m z'' = -m g, m (a² + b²)/12 θ'' = 0",
        ),
        (
            *("elastic_pendulum", "equation of motion"),
            "D'après Lagrange :\nm r̈ − m r θ̇² + k (r − l0) − m g cos θ = 0\n"
            "r θ̈ + 2 ṙ θ̇ + g sin θ = 0",
        ),
        (
            "base_excited_mass",
            "equation of motion",
            "m D(D(u))(t) + c D(u)(t) + k u = m X W^2 sin(W t)",
        ),
        ("free_planar_body", "mass matrix", "DiagonalMatrix[{m, m, m (a^2 + b^2)/12}]"),
        ("particle_on_circle", "equation of motion", "θ' = const, d.h. θ'' = 0"),
        (
            *("rolling_disk", "equation of motion"),
            "Rollbedingung x' = R turn', Kontakt z = R, damit (3/2) m x'' = m g sin(alpha)",
        ),
        ("rigid_bar_pendulum", "equilibrium", "0 and 180 degrees"),
        ("rigid_bar_pendulum", "equilibrium", r"$q \in \{0^\circ, 180^\circ\}$"),
        ("rigid_bar_pendulum", "equilibrium", "q = ±180° or 0°"),
        ("double_pendulum", "mass matrix", f"M(q) = {RODS_MATRIX}"),
        ("two_blocks", "equation of motion", "m1 q̈1 = k2 q2 − (k1+k2) q1; m2 q̈2 = k2 (q1−q2) + F"),
        # decimal commas within brackets, and as LaTeX has them
        ("rigid_bar_pendulum", "equation of motion", "q'' + (1,5 g/l) sin q = 0"),
        ("rigid_bar_pendulum", "equation of motion", r"q'' + \frac{1,5 g}{l} \sin q = 0"),
        ("rigid_bar_pendulum", "frequency", "omega = sqrt(1,5 g/l)"),
        ("rigid_bar_pendulum", "equation of motion", r"\ddot q + 1{,}5 \frac{g}{l} \sin q = 0"),
        # several words before a bracket
        ("atwood_machine", "equation of motion", "Daraus folgt (m1 + m2 + M/2) x'' = (m1 - m2) g"),
        # letters of the mathematical alphabets, as word processors and PDFs have them
        ("rigid_bar_pendulum", "equation of motion", "𝑞̈ + (3𝑔)/(2𝑙) sin 𝑞 = 0"),
        ("bead_on_hoop", "equation of motion", "𝜃̈ = (𝑊² cos 𝜃 − 𝑔/𝑅) sin 𝜃"),
    ],
)
def test_values_in_a_row_and_mathematical_letters_are_read(
    system: str, ask: str, text: str
) -> None:
    assert mq.check(mq.textbook.load(system), text, ask).right


def test_a_sign_after_a_comma_begins_another_value() -> None:
    """Half a turn either way is no sum of both."""
    pendulum = mq.textbook.load("rigid_bar_pendulum")
    verdict = mq.check(pendulum, "q = pi/2, -pi/2", "equilibrium")
    assert [line.outcome for line in verdict.lines] == ["wrong", "wrong"]


def test_binets_equation_is_read() -> None:
    kepler = mq.textbook.load("kepler_orbit")
    for text in (
        "d^2 u/dphi^2 + u = mu/C^2",
        r"\frac{d^2 u}{d\varphi^2} + u = \frac{\mu}{C^2}",
        "d²u/dφ² + u = mu/C^2",
    ):
        verdict = mq.check(kepler, text, let=["u = 1/r", "C = r^2 phi'"])
        assert verdict.outcome == "incomplete", str(verdict)
        assert verdict.independent == 1
    wrong = mq.check(kepler, "d^2 u/dphi^2 - u = mu/C^2", let=["u = 1/r", "C = r^2 phi'"])
    assert wrong.outcome == "wrong"


def test_a_line_that_repeats_a_definition_is_none_of_the_answer() -> None:
    mass = mq.textbook.load("base_excited_mass")
    answer, let = "u'' + c/m u' + w0^2 u = X W^2 sin(W t)", "w0 = sqrt(k/m)"
    verdict = mq.check(mass, f"w0² = k/m\n{answer}", let=[let])
    assert verdict.right
    assert verdict.notes == ("taken as a definition: 'w0² = k/m'",)
    assert mq.check(mass, "w0² = k/m", let=[let]).outcome == "wrong"
    assert mq.check(mass, f"w0² = 2 k/m\n{answer}", let=[let]).outcome == "wrong"


def test_every_letter_that_derive_prints_is_known() -> None:
    crane = mq.textbook.load("crane")
    text = """(M + m) x'' + m l cos(theta) theta'' - m l sin(theta) theta'^2
      - 2 m w cos(theta) theta' = F
    cos(theta) x'' + l theta'' - 2 w theta' + g sin(theta) = 0"""
    assert mq.check(crane, text).right


@pytest.mark.parametrize("word", ["Lösung", "Lo\u0308sung", "Bewegungsgleichung für die Länge"])
def test_umlauts_of_words_are_no_derivatives(word: str) -> None:
    """The dots of a German word are set aside with it; those of q̈ and ẍ are derivatives."""
    pendulum = mq.textbook.load("simple_pendulum")
    assert mq.check(pendulum, f"{word}: q'' + g/l sin q = 0").right
    assert mq.check(pendulum, "ml q\u0308 + mg sin q = 0").right


@pytest.mark.parametrize(
    ("answer", "outcome"),
    [
        (r"\omega = \pm\sqrt{g/l}", "right"),
        ("T = ± 2 pi sqrt(l/g)", "right"),
        ("omega = ∓ sqrt(g/l)", "right"),
        ("omega^2 = ± g/l", "wrong"),
        ("omega = ± sqrt(2 g/l)", "wrong"),
        ("omega = -sqrt(g/l)", "wrong"),
    ],
)
def test_both_signs_of_a_frequency_are_one_frequency(answer: str, outcome: str) -> None:
    pendulum = mq.textbook.load("simple_pendulum")
    assert mq.check(pendulum, answer, ask="frequency").outcome == outcome


COUNT = ("F - c*v + m*sin(th)*(l*w**2 + g*cos(th))", "M + m*sin(th)**2")
BLOCKS = ("m1 q1'' = k2 (q2 - q1) - k1 q1", "m2 q2'' = F - k2 (q2 - q1)")
CLASSES = (
    # forces between bodies that are eliminated
    ("atwood_machine", "equation of motion", "m1 g - T1 = m1 x''; T2 - m2 g = m2 x''; "
     "(T1 - T2) R = M R^2/2 x''/R"),
    ("rolling_disk", "equation of motion", "m g sin α - f = m x'', f R = m R^2/2 x''/R"),
    ("rolling_disk", "equation of motion", "m x'' = m g sin α - F; m R²/2 φ'' = F R; x'' = R φ''"),
    # accelerations by their own letters
    ("atwood_machine", "equation of motion", "a = 2 (m1 - m2) g/(2 m1 + 2 m2 + M)"),
    ("atwood_machine", "equation of motion", "m1 g - T1 = m1 a; T2 - m2 g = m2 a; "
     "(T1 - T2) R = J α; a = R α; J = M R^2/2"),
    ("simple_pendulum", "equation of motion", "alpha = -g/l sin q"),
    # programs
    ("simple_pendulum", "state space", "z = [q, q'], dz/dt = [z2, -g/l sin z1]"),
    ("simple_pendulum", "state space", "x = [q; q'], x' = [x2; -g/l sin x1]"),
    ("simple_pendulum", "state space", "def f(t, y):\n  th, om = y\n  return [om, -g/l*sin(th)]"),
    ("simple_pendulum", "state space", "def f(t, x): return np.array([x[1], -g*np.sin(x[0])/l])"),
    ("simple_pendulum", "state space", "f = @(t,y) [y(2); -g/l*sin(y(1))]"),
    ("simple_pendulum", "state space", "function dydt = f(t, y)\ndydt = zeros(2,1);\n"
     "dydt(1) = y(2);\ndydt(2) = -g/l*sin(y(1));\nend"),
    ("simple_pendulum", "state space", "def f(t, s):\n  th, om = s\n  dth = om\n"
     "  dom = -g/l*np.sin(th)\n  return dth, dom"),
    ("cart_pole", "state space", "def f(t, s):\n  x, v, th, w = s\n"
     f"  a = ({COUNT[0]})/({COUNT[1]})\n  return [v, a, w, -(g*sin(th) + a*cos(th))/l]"),
    ("simple_pendulum", "state space", "z1' = z2\nz2' = -g/l sin z1"),
    ("two_blocks", "state space", "x1' = x2, x2' = (k2 (x3 - x1) - k1 x1)/m1, x3' = x4, "
     "x4' = (F - k2 (x3 - x1))/m2"),
    ("two_blocks", "state space", "x1' = x3, x2' = x4, x3' = (k2 (x2 - x1) - k1 x1)/m1, "
     "x4' = (F - k2 (x2 - x1))/m2"),
    # matrices
    ("two_blocks", "mass matrix", "diag(m1, m2)"),
    ("shear_building", "mass matrix", "m I"),
    ("shear_building", "mass matrix", "m*np.eye(5)"),
    ("two_blocks", "mass matrix", "M = np.array([[m1, 0], [0, m2]])"),
    ("two_blocks", "equation of motion", "M q'' + K q = [0, F]^T where M = diag(m1, m2), "
     "K = [[k1+k2, -k2], [-k2, k2]]"),
    ("two_blocks", "frequency", r"\begin{vmatrix} k_1+k_2-m_1\omega^2 & -k_2\\ -k_2 & "
     r"k_2-m_2\omega^2\end{vmatrix} = 0"),
    ("two_blocks", "frequency", "det(K - ω^2 M) = 0, K = [[k1+k2, -k2], [-k2, k2]], "
     "M = [[m1, 0], [0, m2]]"),
    # what a letter stands for
    ("coupled_pendulums", "frequency", "ω0² = g/l; ω1 = ω0; ω2² = ω0² + 2 k a²/(m l²)"),
    ("base_excited_mass", "damped frequency", "ω_d = ω_n √(1 − ζ²), ω_n = √(k/m), "
     "ζ = c/(2 √(k m))"),
    ("rigid_bar_pendulum", "frequency", "ω = √(3g/(2l)), f = ω/(2π)"),
    ("two_blocks", "transfer function of q2 from F", r"\frac{X_2(s)}{F(s)} = "
     "(m1 s^2 + k1 + k2)/((m1 s^2 + k1 + k2)(m2 s^2 + k2) - k2^2)"),
    ("kepler_orbit", "Hamilton's equations", "ṙ = p_r/m, φ' = pφ/(m r²), "
     "ṗ_r = pφ²/(m r³) − m μ/r², pφ' = 0"),
    ("kepler_orbit", "equation of motion", "r² φ̇ = const, r̈ = r φ̇² − μ/r²"),
    ("simple_pendulum", "potential energy", "V = m g l (1 - cos q) + const."),
    ("simple_pendulum", "energy", "E = m l^2 q'^2/2 - m g l cos q = const"),
    ("simple_pendulum", "equilibrium", r"q_{eq} = 0, \pi"),
    ("simple_pendulum", "equilibrium", "q = k*pi, k integer"),
    ("simple_pendulum", "equilibrium", "q = k π for any integer k"),
    ("simple_pendulum", "equilibrium", "q = n π (n is an integer)"),
    ("simple_pendulum", "equilibrium", "q = n π where n = 0, ±1, ±2, …"),
    ("simple_pendulum", "equilibrium", "q_1 = 0 (stable), q_2 = π (unstable)"),
    ("simple_pendulum", "period", r"\tau = 2\pi\sqrt{\frac{\ell}{g}}"),
    ("simple_pendulum", "reaction", "T = m g cos q + m l q'^2"),
    ("rolling_disk", "reaction", "F = 1/3 m g sin α, N = m g cos α"),
    # what names or numbers lines
    *(
        ("two_blocks", "equation of motion", template.format(*BLOCKS))
        for template in (
            "Block 1: {}\nBlock 2: {}", "m1: {}\nm2: {}", "q1: {}\nq2: {}", "i = 1: {}\ni = 2: {}",
            "Equation 1: {}\nEq. 2: {}", "1. {}\n2. {}", "1) {}\n2) {}", "(a) {}\n(b) {}",
            "{} (1)\n{} (2)", "* {}\n* {}", "• {}\n• {}",
        )
    ),
    ("simple_pendulum", "equilibrium", "q = 0: stable, q = π: unstable"),
    (
        *("bead_on_hoop", "equilibrium"),
        "(i) θ = 0 (ii) θ = π (iii) θ = ± arccos(g/(W²R))",
    ),
    ("simple_pendulum", "equation of motion", "eq1 := m*l^2*q'' + m*g*l*sin(q) = 0"),
    # derivatives and their definitions
    ("simple_pendulum", "equation of motion", "q_tt + (g/l) sin q = 0"),
    (
        *("cart_pole", "equation of motion"),
        "(M+m) x_{tt} + m l (q_{tt} cos q - q_t^2 sin q) + c x_t = F; "
        "l q_tt + x_tt cos q + g sin q = 0",
    ),
    ("cart_pole", "momentum of x", "∂L/∂x' = (M+m) x' + m l q' cos q"),
    (
        *("cart_pole", "momentum of x"),
        r"\frac{\partial L}{\partial \dot x} = (M+m)\dot x + m l\dot q\cos q",
    ),
    ("cart_pole", "mass matrix", "m11 = M+m; m12 = m*l*cos(q); m22 = m*l^2"),
    # what stands around
    ("simple_pendulum", "equation of motion", "Newton's second law about O: l q'' = -g sin q"),
    ("simple_pendulum", "equation of motion", r"\sum M_O = J\ddot q:\quad -mg\sin q = ml\ddot q"),
    ("cart_pole", "equation of motion", f"M x'' + c x' + m d²/dt²(x + l sin q) = F; {POLE}"),
)  # fmt: skip


@pytest.mark.parametrize(("system", "ask", "text"), CLASSES)
def test_what_students_hand_in_is_read(system: str, ask: str, text: str) -> None:
    """Cut bodies, programs, matrices and determinants, helpers, constants and prose."""
    found = mq.check(mq.textbook.load(system), text, ask)
    assert found.right, str(found)


@pytest.mark.parametrize(
    ("system", "ask", "text", "outcome"),
    [
        ("simple_pendulum", "state space", "def f(t, y): return [y[1], g/l*sin(y[0])]", "wrong"),
        ("simple_pendulum", "state space", "def f(t, y): return [y[0], -g/l*sin(y[0])]", "wrong"),
        ("simple_pendulum", "state space", "def f(t, y): return [y[1], y[1]]", "wrong"),
        ("kepler_orbit", "equation of motion", "r φ̇ = const, r̈ = r φ̇² − μ/r²", "wrong"),
        ("kepler_orbit", "equation of motion", "r² φ̇ = const", "incomplete"),
        ("simple_pendulum", "equation of motion", "7 = const", "wrong"),
        ("simple_pendulum", "energy", "E = m l^2 q'^2/2 + m g l cos q = const", "wrong"),
        ("shear_building", "mass matrix", "2 m I", "wrong"),
        ("two_blocks", "frequency", "det([[1, 0], [0, 1]]) = 1", "wrong"),
        ("coupled_pendulums", "frequency", "ω0²=2 g/l; ω2² = ω0²/2 + 2 k a²/(m l²)", "incomplete"),
        ("coupled_pendulums", "frequency", "ω1² = 2 g/l; ω2² = ω1²/2 + 2 k a²/(m l²)", "wrong"),
        ("base_excited_mass", "damped frequency", "ω_n = √(k/m), ω_d = ω_n", "wrong"),
        ("rigid_bar_pendulum", "frequency", "ω = √(g/l), f = ω √(3/2)/(2π)", "wrong"),
        ("simple_pendulum", "reaction", "T = m g cos q - m l q'^2", "wrong"),
        ("two_blocks", "equation of motion", f"{BLOCKS[0]}\n{BLOCKS[1]} (2)", "wrong"),
        ("two_blocks", "equation of motion", f"2. {BLOCKS[0]}\n3. {BLOCKS[1]}", "wrong"),
        ("simple_pendulum", "equation of motion", "q_tt - (g/l) sin q = 0", "wrong"),
        ("cart_pole", "momentum of x", "∂L/∂x' = (M+m) x'", "wrong"),
        ("cart_pole", "mass matrix", "m11 = M; m12 = m*l*cos(q); m22 = m*l^2", "wrong"),
        ("rolling_disk", "reaction", "F = m g sin α", "wrong"),
        ("rolling_disk", "reaction", "F = -m g sin(alpha)/3", "wrong"),
        ("atwood_machine", "equation of motion", "a = (m1 - m2) g/(m1 + m2 + M)", "wrong"),
        ("atwood_machine", "equation of motion", "a = a", "wrong"),
        ("simple_pendulum", "state space", "z = [q, q'], dz/dt = [z2, g/l sin z1]", "wrong"),
        ("simple_pendulum", "equilibrium", "q = k*pi/2, k integer", "wrong"),
        ("simple_pendulum", "equilibrium", "q = 2 k*pi, k integer", "incomplete"),
        ("simple_pendulum", "equilibrium", "q_1 = 0, q_2 = π/2", "wrong"),
        ("simple_pendulum", "period", r"\tau = 2\pi\sqrt{g/l}", "wrong"),
    ],
)  # fmt: skip
def test_the_same_notations_with_a_slip_are_not_right(
    system: str, ask: str, text: str, outcome: str
) -> None:
    assert mq.check(mq.textbook.load(system), text, ask).outcome == outcome


def test_a_letter_that_may_be_a_tangential_force_is_asked_for() -> None:
    with pytest.raises(mq.FormulaError, match="unknown letter 'T'"):
        mq.check(mq.textbook.load("rigid_bar_pendulum"), "T = m g sin(q)/4", "reaction")


@pytest.mark.parametrize(
    ("system", "text"),
    [
        ("atwood_machine", "m1 g - T1 = m1 x''; T2 - m2 g = m2 x''; (T1 - T2) R = M R x''"),
        # beside x'' an acceleration's letter may as well be a length
        ("atwood_machine", "(m1 + m2) x'' + a = m1 g"),
        ("rolling_disk", "m x'' = m g sin α - F; m R²/2 φ'' = -F R; x'' = R φ''"),
        # the force is unread where it stands in one line alone
        ("simple_pendulum", "T - m g cos q = -m l q'^2; l q'' = -g sin q"),
        ("simple_pendulum", "T (q'' + g/l sin q) = 0; T q'' + T g/l sin q = 0"),
    ],
)
def test_unknown_letters_that_lead_to_nothing_right_are_named(system: str, text: str) -> None:
    with pytest.raises(mq.FormulaError, match="unknown letter"):
        mq.check(mq.textbook.load(system), text)


def test_a_coordinate_that_is_a_word_goes_by_its_letter_as_well() -> None:
    disk = mq.textbook.load("rolling_disk")
    for turn in ("turn", "phi", "φ", r"\varphi"):
        assert mq.check(disk, f"3 R {turn}'' = 2 g sin(alpha)").right
    assert not mq.check(disk, "3 R phi'' = g sin(alpha)").right
    # it may as well be a letter of one's own
    assert mq.check(disk, "3 phi'' = 2 g sin(alpha)", let={"phi": "x"}).right
    assert KnownLetters.of(mq.textbook.load("simple_pendulum")).printed == {}
