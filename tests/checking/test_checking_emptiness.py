"""Nothing for nothing: what holds without saying anything, or near the usual states only, is wrong.

The right equation of the pendulum is q'' + g/l sin q = 0; what stands beside it here is made of it.
"""

from __future__ import annotations

import pytest

import mecanique as mq

RIGHT = "(q'' + g/l sin q)"
EMPTY = (
    ("0 = 0", "it holds for any motion"),
    ("q'' = q''", "it holds for any motion"),
    (f"{RIGHT} (q'' + 100 q^2 sin q) = 0", "it holds for other motions, too"),
    ("q''^2 = (g/l sin q)^2", "it holds for other motions, too"),
    (f"sin{RIGHT} = 0", "it holds for other motions, too"),
    (f"abs{RIGHT} = 0", "it only touches zero"),
    (f"{RIGHT}^2 = 0", "it only touches zero"),
    (f"cos{RIGHT} = 1", "it only touches zero"),
    (f"sqrt(abs{RIGHT}) = 0", "it only touches zero"),
    (f"{RIGHT} + g/l exp(-1000000 q^2) = 0", "it holds near the usual states only"),
    (f"{RIGHT} + g/l (q/100)^40 = 0", "it holds near the usual states only"),
    (f"{RIGHT} + g/l (sign(q)^2 - 1) = 0", "it holds near the usual states only"),
    (f"{RIGHT} + 1e-9 q' = 0", "it holds near the usual states only"),
    (f"{RIGHT} + 1e-10 = 0", "it holds near the usual states only"),
    (f"{RIGHT} + exp(-1000000 q^2) = 0", "the units do not match"),
    (f"{RIGHT} + abs(q) - sqrt(q^2) = 0", "the units do not match"),
    (f"{RIGHT} + 1e-13 g/l q = 0", "the term '1e-13 g/l q' is too small to be seen"),
    (f"{RIGHT} + g/l exp(-10000) = 0", "the term 'g/l exp(-10000)' is too small to be seen"),
)


@pytest.mark.parametrize(("text", "reason"), EMPTY)
def test_an_equation_that_says_nothing_is_wrong(text: str, reason: str) -> None:
    found = mq.check(mq.textbook.load("simple_pendulum"), text)
    assert (found.outcome, found.independent) == ("wrong", 0)
    assert found.causes[0].text.startswith(reason)


@pytest.mark.parametrize(
    ("text", "outcome"),
    [
        (f"(2 + cos q) {RIGHT} = 0", "right"),
        (f"{RIGHT}/(q'' + g/l sin q + g/l) = 0", "right except for form"),
        ("g sin(q)/q'' + l = 0", "right except for form"),
        (f"exp({RIGHT} l/g) = 1", "right except for form"),
        (f"{RIGHT} + g/l (abs(q) - sqrt(q^2)) = 0", "right"),
    ],
)
def test_other_forms_of_the_right_equation_hold(text: str, outcome: str) -> None:
    assert mq.check(mq.textbook.load("simple_pendulum"), text).outcome == outcome


_FIRST, _SECOND = "m1 q1'' + (k1 + k2) q1 - k2 q2 = 0", "m2 q2'' + k2 (q2 - q1) = F"


@pytest.mark.parametrize("word", ["or", "oder", "ou"])
def test_of_two_equations_joined_by_or_only_one_is_claimed(word: str) -> None:
    blocks = mq.textbook.load("two_blocks")
    either = mq.check(blocks, f"{_FIRST} {word} {_SECOND}")
    assert (either.outcome, either.independent) == ("wrong", 1)
    assert either.causes[0].text.startswith(f"'{word}' leaves open which of two equations holds")
    # two forms of the same equation leave nothing open
    solved = "q1'' = (k2 q2 - (k1 + k2) q1)/m1"
    assert mq.check(blocks, f"{_FIRST} {word} {solved}, {_SECOND}").right


def test_of_two_reactions_joined_by_or_only_one_is_claimed() -> None:
    incline = mq.textbook.load("rolling_disk")
    N, F = "lambda_contact_normal = m g cos alpha", "lambda_contact_x = -m g sin(alpha)/3"
    assert mq.check(incline, f"{N}, {F}", "reaction").right
    assert mq.check(incline, f"{N} or {F}", "reaction").outcome == "wrong"


def test_a_line_multiplied_by_zero_is_no_definition() -> None:
    empty = mq.check(mq.textbook.load("two_blocks"), f"0*({_FIRST[:-4]}) = 0; {_SECOND}")
    assert empty.outcome == "wrong"
    assert empty.causes[0].text == "it holds for any motion"


@pytest.mark.parametrize(
    ("system", "ask", "text", "words"),
    [
        (*("simple_pendulum", "kinetic energy"), "T = m l^2 q'^2/2 (1 + (q/1000)^4)", "too small"),
        ("simple_pendulum", "frequency", "omega = sqrt(g/l (1 + 1e-12))", "too small"),
        # d = 2 a in all states, as loops of any other lengths need not close
        (
            *("four_bar_linkage", "potential energy"),
            "m1 g d sin(phi)/4 + m2 g (a sin(phi) + b sin(phi + theta)/2) + m3 g c sin(psi)/2",
            "it holds for the proportions of this mechanism only",
        ),
        # the motion without any force is no linearized one
        ("particle_on_circle_x", "equation of motion", "x'' = 0", "the centripetal term"),
    ],
)
def test_what_changes_nothing_earns_nothing(system: str, ask: str, text: str, words: str) -> None:
    verdict = mq.check(mq.textbook.load(system), text, ask)
    assert verdict.outcome == "wrong"
    assert words in verdict.causes[0].text


def test_equations_that_follow_from_each_other_count_once() -> None:
    double = mq.textbook.load("double_pendulum")
    first, second = mq.derive(double).text().splitlines()[:2]
    assert mq.check(double, f"{first}\n{second}").independent == 2
    assert mq.check(double, f"{first}\n{first}").independent == 1
    assert mq.check(double, f"{first}\n{first}\n1 = 2\n0 = 0").independent == 1


@pytest.mark.parametrize(
    ("text", "ask", "reason"),
    [
        ("7", "conserved quantity", "it does not depend on the motion at all"),
        ("sin(q)^2 + cos(q)^2", "conserved quantity", "it does not depend on the motion at all"),
        ("q''", "conserved quantity", "a conserved quantity depends on positions and velocities"),
        ("0 = 0", "frequency", "it holds for any value of the quantity in question"),
        ("omega^2 = omega^2", "frequency", "it holds for any value of the quantity in question"),
        ("(omega^2 - g/l)^2 = 0", "frequency", "it only touches zero"),
        ("(omega^2 - g/l)(omega - 4 sqrt(g/l)) = 0", "frequency", "it holds for other values, too"),
        ("T = T", "kinetic energy", "it holds for any value of the quantity in question"),
        ("abs(T - m l^2 q'^2/2) = 0", "kinetic energy", "it only touches zero"),
        ("V = V", "potential energy", "it holds for any value of the quantity in question"),
        ("V", "potential energy", "it holds for any value of the quantity in question"),
        ("2 L - L", "Lagrangian", "it holds for any value of the quantity in question"),
        ("p", "momentum", "it holds for any value of the quantity in question"),
        ("w", "frequency", "it holds for any value of the quantity in question"),
        # a constant is open, but nothing else
        ("1 = 2", "potential energy", "it holds for any value of the quantity in question"),
        ("L = L + 1", "Lagrangian", "it holds for any value of the quantity in question"),
        ("m g l = 2 m g l", "energy", "it holds for any value of the quantity in question"),
        ("V/V = 2", "potential energy", "it holds for any value of the quantity in question"),
        ("(V + m g l cos q)^2 = 0", "potential energy", "it only touches zero"),
        ("cos(V/(m g l) + cos q) = 1", "potential energy", "it only touches zero"),
        ("V^2 = (m g l cos q)^2", "potential energy", "it holds for other values, too"),
        ("T^2 = (m l^2 q'^2/2)^2", "kinetic energy", "it holds for other values, too"),
        ("(V + m g l cos q) (V - 7 m g l) = 0", "potential energy", "it holds for other values"),
        ("(H - p^2/(2 m l^2) + m g l cos q)^2 = 0", "Hamiltonian", "it only touches zero"),
        ("p^2 = (m l^2 q')^2", "momentum", "it holds for other values, too"),
        ("p (p - m l^2 q') = 0", "momentum", "it holds for other values, too"),
        ("(q' - p/(m l^2)) (q' - 1) = 0", "Hamilton's equations", "it holds for other values"),
        ("(q' - p/(m l^2))^2 = 0", "Hamilton's equations", "it only touches zero"),
    ],
)
def test_a_quantity_is_not_had_for_nothing(text: str, ask: str, reason: str) -> None:
    found = mq.check(mq.textbook.load("simple_pendulum"), text, ask)
    assert found.outcome == "wrong"
    assert found.causes[0].text.startswith(reason)


@pytest.mark.parametrize(
    ("text", "ask"),
    [
        ("1/p = 1/(m l^2 q')", "momentum"),
        ("exp(V/(m g l) + cos q) = 1", "potential energy"),
        ("V/(m g l) = 1 - cos q", "potential energy"),
    ],
)
def test_another_form_of_a_quantity_determines_it(text: str, ask: str) -> None:
    assert mq.check(mq.textbook.load("simple_pendulum"), text, ask).right


@pytest.mark.parametrize(
    ("text", "outcome", "reason"),
    [
        ("({0} - {1}) ({0} - {2}) = 0", "right", ""),
        ("({0} - {1}) ({0} - {2}) ({0} - 7 sqrt(g/l)) = 0", "wrong", "it holds for other values"),
        ("({0} - {1})^2 = 0; {0} = {2}", "wrong", "it only touches zero"),
    ],
)
def test_an_equation_may_hold_for_every_frequency(text: str, outcome: str, reason: str) -> None:
    formulas = ("omega", "sqrt(g/l)", "sqrt(g/l + 2 k a^2/(m l^2))")
    coupled = mq.textbook.load("coupled_pendulums")
    found = mq.check(coupled, text.format(*formulas), "frequency")
    assert found.outcome == outcome
    assert reason in " ".join(map(str, found.causes))


@pytest.mark.parametrize(
    ("text", "outcome", "independent"),
    [
        ("tau2 = {0}; tau1 = {1}", "right", 2),
        ("tau2 = {0}; 2 tau2 = 2 {0}; {0} = tau2", "incomplete", 1),
        ("(tau1 - {1}) (tau1 - m1 g l1) = 0; tau2 = {0}", "wrong", 1),
        ("(tau2 - {0})^2 = 0; tau1 = {1}", "wrong", 1),
    ],
)
def test_forces_are_judged_as_a_set(text: str, outcome: str, independent: int) -> None:
    second = "(m2 g l2 cos(q1 + q2)/2)"
    first = f"((m1/2 + m2) g l1 cos(q1) + {second})"
    found = mq.check(
        mq.textbook.load("two_link_arm"), text.format(second, first), "equilibrium force"
    )
    assert (found.outcome, found.independent, found.needed) == (outcome, independent, 2)


def test_reactions_that_are_named_must_all_be_given() -> None:
    rod = mq.textbook.load("rigid_bar_pendulum")
    normal, along = "R_pin_n = m g cos q + m l/2 q'^2", "R_pin_t = m g sin(q)/4"
    both = "reaction of R_pin_n, R_pin_t"
    assert mq.check(rod, normal, "reaction").right
    assert mq.check(rod, f"{normal}\n{along}", both).right
    found = mq.check(rod, normal, both)
    assert (found.outcome, found.form) == ("incomplete", "1 of 2 equations missing")
    with pytest.raises(mq.UnknownNameError, match="unknown reaction 'R_x'"):
        mq.check(rod, normal, "reaction of R_x")


def test_a_letter_of_the_system_keeps_its_unit() -> None:
    pendulum = mq.textbook.load("simple_pendulum")
    with pytest.raises(mq.FormulaError, match="'g' is in m/s², its definition in 1/s²; define"):
        mq.check(pendulum, "q'' + g sin q = 0", let=["g = g/l"])
    assert mq.check(pendulum, "q'' + g/(2 l) sin q = 0", let=["l = l/2"]).right


@pytest.mark.parametrize(
    ("mass", "ask", "text"),
    [
        ("T", "kinetic energy", "1/2 T l^2 q'^2"),
        ("K", "kinetic energy", "Ek = 1/2 K l^2 q'^2"),
        ("E", "energy", "1/2 E l^2 q'^2 - E g l cos q"),
        ("L", "Lagrangian", "1/2 L l^2 q'^2 + L g l cos q"),
        ("p", "momentum", "p l^2 q'"),
        ("p", "Hamiltonian", "pq^2/(2 p l^2) - p g l cos q"),
        ("omega", "frequency", "sqrt(g/l)"),
    ],
)
def test_a_letter_of_the_system_does_not_mean_the_quantity(mass: str, ask: str, text: str) -> None:
    """A mass T is no kinetic energy, neither in its value nor in its unit."""
    m, l, g = mq.Parameter(mass, 1.3, "kg"), mq.Parameter("l", 0.7, "m"), mq.Parameter("g", 9.81)
    pendulum = mq.Mechanism(
        "pendulum",
        (mq.Body("ground"), mq.Body("bob", mq.particle(m).at((0, 0, -l)))),
        (mq.Revolute("pin", "ground", "bob", axis=(0, -1, 0), coordinate="q"),),
        parameters=(m, l, g),
        gravity=(0, 0, -g),
    )
    assert mq.check(pendulum, text, ask).right
    assert mq.check(pendulum, text.replace("1/2", "1/3").replace("l", "2 l"), ask).right is False


@pytest.mark.parametrize("text", ["V = 0", "0"])
def test_a_quantity_may_be_zero(text: str) -> None:
    assert mq.check(mq.textbook.load("tennis_racket"), text, "potential energy").right


@pytest.mark.parametrize(
    ("system", "text", "outcome", "words"),
    [
        ("simple_pendulum", "q = 0", "incomplete", "q = π is missing"),
        ("simple_pendulum", "q = 0\nq = pi", "right", ""),
        ("simple_pendulum", "sin q = 0", "right", ""),
        ("simple_pendulum", "q = 0\nq = 2 pi", "incomplete", "q = π is missing"),
        ("simple_pendulum", "q = 0.3\nq = 0\nq = pi", "wrong", ""),
        ("double_pendulum", "q1 = q2", "wrong", "it is a condition: q2 is not given"),
        ("double_pendulum", "q1 = 0", "wrong", "q2 is not given"),
        ("double_pendulum", "q1 = 0, q2 = 0", "incomplete", "q1 = π, q2 = π is missing"),
        ("double_pendulum", "sin q1 = 0\nsin q2 = 0", "right", ""),
        ("bead_on_hoop", "sin theta = 0\ncos(theta) = g/(R W^2)", "right", ""),
        ("bead_on_hoop", "sin theta = 0", "incomplete", "theta = -1.02 (for "),
        ("spherical_pendulum", "theta = pi\ntheta = 0", "right", ""),
        # inputs rest, as in mecanique.equilibria
        ("two_blocks", "q1 = 0\nq2 = 0", "right", "with F = 0"),
        ("two_blocks", "q1 = 0.1\nq2 = 0", "wrong", ""),
    ],
)
def test_equilibria_are_judged_as_a_set(system: str, text: str, outcome: str, words: str) -> None:
    found = mq.check(mq.textbook.load(system), text, "equilibrium")
    assert found.outcome == outcome, str(found)
    assert words in " ".join([found.form, *found.notes, *map(str, found.causes)])


def test_frequencies_are_counted_by_those_that_are_named() -> None:
    """Two ways to write one frequency are one."""
    coupled = mq.textbook.load("coupled_pendulums")
    found = mq.check(coupled, "omega^2 = g/l\nomega = sqrt(g/l)", "frequency")
    assert (found.outcome, found.form) == ("incomplete", "1 of 2 frequencies missing")


@pytest.mark.parametrize(
    ("text", "outcome", "independent"),
    [
        ("0 = 0", "wrong", 0),
        ("sin(turn)^2 + cos(turn)^2 = 1", "wrong", 0),
        ("lambda_contact_x = lambda_contact_x", "wrong", 0),
        ("x' - R turn' = 0", "incomplete", 1),
        ("x' - R turn' = 0; 2 x' = 2 R turn'; cos(turn) (x' - R turn') = 0", "incomplete", 1),
        ("x' - R turn' = 0; z = R", "incomplete", 2),
    ],
)
def test_constraints_give_no_equations_for_nothing(
    text: str, outcome: str, independent: int
) -> None:
    """The rolling disk's two constraints bind three accelerations, whatever an answer says."""
    verdict = mq.check(mq.textbook.load("rolling_disk"), text)
    assert (verdict.outcome, verdict.independent) == (outcome, independent)
