"""What is proven by algebra, and what is left to many states."""

from __future__ import annotations

import pytest

import mecanique as mq

ROD = "rigid_bar_pendulum"
TWO = "double_pendulum"
MOTION = "equation of motion"

PROVEN = (
    (ROD, "m l^2/3 q'' + m g l/2 sin q = 0", MOTION),
    (ROD, "q'' = -3 g/(2 l) tan(q) cos(q)", MOTION),
    (ROD, "q''/(1 + cos q) + 3 g/(2 l) sin(2 q)/(2 cos q (1 + cos q)) = 0", MOTION),
    (ROD, "q''/sin(q + pi/6) = -1.5 g/l sin(q)/sin(q + pi/6)", MOTION),
    (ROD, "L = m l^2/6 q'^2 + m g l/2 cos q", "Lagrangian"),
    (ROD, "V = m g l (sin(q)^2 + cos(q)^2 - cos q)/2", "potential energy"),
    (ROD, "m l^2/6 q'^2 - m g l/2 cos q = E", "conserved quantity"),
    (ROD, "R_pin_t = m g sin(q)/4", "reaction"),
    ("cart_pole", "[[M + m, m l cos q], [m l cos q, m l^2]]", "mass matrix"),
    ("cart_pole", "(M + m) x' + m l q' cos q", "momentum of x"),
    ("cart_pole", "M x'' = F - c x' - R_pin_x", "equilibrium of cart"),
    ("spherical_pendulum", "m l^2 sin(theta)^2 phi'", "conserved quantity"),
)


@pytest.mark.parametrize(("name", "text", "ask"), PROVEN)
def test_what_has_a_form_in_the_ring_is_proven(name: str, text: str, ask: str) -> None:
    found = mq.check(mq.textbook.load(name), text, ask)
    assert found.right, str(found)
    assert found.exact
    assert "proven by algebra" in found.summary
    assert found.to_dict()["exact"] is True


@pytest.mark.parametrize(
    "name", ["double_pendulum", "gyroscope", "four_bar_linkage", "rolling_coin", "elastic_pendulum"]
)
def test_printed_equations_are_proven(name: str) -> None:
    mechanism = mq.textbook.load(name)
    assert mq.check(mechanism, mq.derive(mechanism).text()).exact


def test_combinations_and_solutions_of_two_equations_are_proven() -> None:
    """The accelerations of cart and pole, one eliminated from the other by hand."""
    mechanism = mq.textbook.load("cart_pole")
    solved = (
        "x'' = (F - c x' + m sin q (l q'^2 + g cos q))/(M + m sin(q)^2)\n"
        "l (M + m (1 - cos(q)^2)) q'' = "
        "-(F - c x') cos q - m l q'^2 sin(2 q)/2 - (M + m) g sin q"
    )
    assert mq.check(mechanism, solved).exact
    wrong = solved.replace("(M + m) g", "M g")
    assert not mq.check(mechanism, wrong).exact


@pytest.mark.parametrize(
    ("text", "ask"),
    [
        ("4 l q'' + 12 g sin(q/2) cos(q/2) = 0", MOTION),
        ("q'' = -1.5 g/l (q'/q') abs(sin q) sign(sin q)", MOTION),
        ("omega = sqrt(3 g/(2 l))", "frequency"),
    ],
)
def test_what_has_no_form_there_is_compared_at_many_states(text: str, ask: str) -> None:
    found = mq.check(mq.textbook.load(ROD), text, ask)
    assert found.right
    assert not found.exact
    assert found.states >= 20
    assert "proven" not in found.summary


@pytest.mark.parametrize(
    "text", ["q'' + 3 g/(2 l) cos q = 0", "q'' + 3*9.81 sin(q)/2 = 0", "q'' + 1.5000001 g/l sin q"]
)
def test_what_is_not_right_in_letters_is_not_proven(text: str) -> None:
    assert not mq.check(mq.textbook.load(ROD), text).exact


BALANCES = (
    (ROD, "rod", "R_pin_n - m g cos q = m l/2 q'^2", "right", ""),
    (ROD, "rod", "m a_rod_t = R_pin_t - m g sin q", "right", ""),
    (ROD, "rod", "m l^2/12 q'' = -l/2 R_pin_t", "right", ""),
    (ROD, "rod", "m l^2/12 q'' = l/2 R_pin_t", "wrong", "the sign of the term"),
    (ROD, "rod", "R_pin_n = m g cos q", "right except for form", "at rest only"),
    ("cart_pole", "cart", "R_slide_z - R_pin_z - M g", "right", ""),
    ("cart_pole", "cart", "M x'' = F - c x' + R_pin_x", "wrong", "sign of the term 'R_pin_x'"),
    ("cart_pole", "pole", "l cos(q) R_pin_x + l sin(q) R_pin_z = 0", "right", ""),
    ("cart_pole", "pole", "R_slide_z = M g + m (g + a_pole_z)", "right except for form",
     "R_slide_z does not act on pole"),
)  # fmt: skip


@pytest.mark.parametrize(("name", "body", "text", "outcome", "words"), BALANCES)
def test_a_free_body_is_in_equilibrium(
    name: str, body: str, text: str, outcome: str, words: str
) -> None:
    found = mq.check(mq.textbook.load(name), text, f"equilibrium of {body}")
    assert found.outcome == outcome, str(found)
    assert words in " ".join([found.form, *(cause.text for cause in found.causes[:1])])


def test_a_body_that_is_none_is_refused() -> None:
    with pytest.raises(mq.UnknownNameError, match="unknown body 'polo'; did you mean 'pole'"):
        mq.check(mq.textbook.load("cart_pole"), "R_pin_x = 0", "equilibrium of polo")


def test_a_letter_of_the_system_may_take_another_meaning() -> None:
    rod = mq.textbook.load(ROD)
    upwards = mq.check(rod, "m l^2/3 q'' - m g l/2 sin q = 0", let=["q = pi - q"])
    assert upwards.exact
    assert mq.check(rod, "4 m l^2/3 q'' + m g l sin q = 0", let=["l = l/2"]).exact
    text = mq.derive(mq.textbook.load(TWO)).text()
    for own, theirs in (
        ("q2''", "(q2'' + q1'')"),
        ("q2'^2", "(q2' + q1')^2"),
        ("q1 - q2", "-q2"),
        ("sin(q2)", "sin(q2 + q1)"),
    ):
        assert own in text
        text = text.replace(own, theirs)
    assert mq.check(mq.textbook.load(TWO), text, let=["q2 = q2 - q1"]).exact
    curve = "u'' (1 + u^2) - 2 u u'^2 + 3 g/(2 l) u (1 + u^2) = 0"
    assert mq.check(rod, curve, let=["u = tan(q/2)"]).right
