"""Mistakes in equations with loops, contacts and blades, made by SymPy or by hand."""

from __future__ import annotations

import pytest
import sympy as sp

import mecanique as mq

COIN = {
    "x'": "r (sin(lean) cos(yaw) yaw' + sin(yaw) cos(lean) lean' + cos(yaw) spin')",
    "y'": "r (sin(yaw) sin(lean) yaw' - cos(yaw) cos(lean) lean' + sin(yaw) spin')",
    "z'": "-r sin(lean) lean'",
}
COIN_WEIGHT = "m*g*r*cos(lean)"


def reduce_energy(name: str, eliminated: dict[str, str], V: str) -> str:
    """Return Lagrange's equations of T with velocities replaced by constraints, which is wrong."""
    mechanism = mq.textbook.load(name)
    velocities = [sp.Symbol(rate) for rate in mechanism.velocities]
    letters = {str(s): s for s in velocities}
    letters |= {rate[:-1]: sp.Symbol(rate[:-1]) for rate in mechanism.velocities}
    letters |= {p.symbol: sp.Symbol(p.symbol) for p in mechanism.parameters}

    def read(text: str) -> sp.Expr:
        for rate in mechanism.velocities:
            text = text.replace(rate, rate[:-1] + "_v")
        names = {key.replace("'", "_v"): value for key, value in letters.items()}
        return sp.parse_expr(text.replace(" ", "*").replace("*+*", "+").replace("*-*", "-"), names)

    v = sp.Matrix(velocities)
    T = (v.T * mq.derive(mechanism).M * v)[0] / 2
    replaced = {sp.Symbol(rate): read(text) for rate, text in eliminated.items()}
    L = T.subs(replaced) - read(V)
    kept = [s for s in velocities if s not in replaced]
    rates = {sp.Symbol(str(s)[:-1]): replaced.get(s, s) for s in velocities}
    rates |= {s: sp.Symbol(f"{s}'") for s in kept}
    rows = []
    for s in kept:
        p = sp.diff(L, s)
        rate = sum((sp.diff(p, one) * its for one, its in rates.items()), sp.Integer(0))
        rows.append(f"{sp.expand(rate - sp.diff(L, sp.Symbol(str(s)[:-1])))} = 0")
    return "\n".join(rows)


@pytest.mark.parametrize(
    ("name", "eliminated", "V"),
    [
        ("rolling_coin", COIN, COIN_WEIGHT),
        ("chaplygin_sleigh", {"y'": "tan(theta) x'"}, "0"),
    ],
)
def test_a_constraint_put_into_the_kinetic_energy_is_named(
    name: str, eliminated: dict[str, str], V: str
) -> None:
    found = mq.check(mq.textbook.load(name), reduce_energy(name, eliminated, V))
    assert found.outcome == "wrong"
    first = found.causes[0]
    assert first.kind == "constraint in T", str(found)
    assert f"substituted into T ({', '.join(eliminated)} eliminated" in first.text


def test_a_contact_that_can_be_integrated_may_be_put_into_the_kinetic_energy() -> None:
    """A disk on a slope: x' = R turn' is the rate of a position, so nothing is lost."""
    text = reduce_energy("rolling_disk", {"x'": "R turn'", "z'": "0"}, "-m*g*R*turn*sin(alpha)")
    assert mq.check(mq.textbook.load("rolling_disk"), f"{text}\nx'' = R turn''\nz'' = 0").right


CRANK = """\
m1 r^2/3 theta'' - (r sin(theta) + l sin(theta + beta)) lambda_B_x + (r cos(theta)
 + l cos(theta + beta)) lambda_B_z + m1 g r/2 cos(theta) = 0
sin(theta + beta) lambda_B_x - cos(theta + beta) lambda_B_z = 0
m2 x'' - lambda_B_x = 0
x - r cos(theta) - l cos(theta + beta) = 0
r sin(theta) + l sin(theta + beta) = 0""".replace("\n +", " +")

LOOPS = (
    ("m1 r^2/3", "m1 r^2/12", "parallel axis", "is taken about its center"),
    ("m1 r^2/3", "m1 r^2/4", "inertia", "as for a particle"),
    ("+ m1 g r/2", "- m1 g r/2", "potential sign", "gravity is wrong"),
    (" + m1 g r/2 cos(theta)", "", "missing", "gravity is missing"),
    ("m2 x'' - lambda_B_x", "m2 x''", "missing", "the force of the constraint B_x"),
    ("m2 x''", "m1 x''", "letter", "m1 in 'm1 x''' should be m2"),
)


@pytest.mark.parametrize(("right", "wrong", "kind", "words"), LOOPS)
def test_a_mistake_in_a_loop_is_named(right: str, wrong: str, kind: str, words: str) -> None:
    mechanism = mq.textbook.load("slider_crank")
    assert mq.check(mechanism, CRANK).right
    found = mq.check(mechanism, CRANK.replace(right, wrong))
    assert found.outcome == "wrong"
    named = [cause for cause in found.causes[:4] if cause.kind == kind and words in cause.text]
    assert named, str(found)


def test_a_disk_without_friction_or_rotation_is_named() -> None:
    mechanism = mq.textbook.load("rolling_disk")
    found = mq.check(mechanism, "m x'' = m g sin(alpha)\nx'' = R turn''\nz'' = 0")
    assert [line.outcome for line in found.lines] == ["wrong", "right", "right"]
    words = " ".join(cause.text for cause in found.causes[:4])
    assert "contact_x (its multiplier) is missing" in words or "particle" in words, str(found)


def test_the_root_of_a_free_wheel_is_a_letter_of_its_equations() -> None:
    wheel = mq.Body("wheel", mq.disk(2.0, 0.2))
    floor = mq.Rolling("floor", "wheel", 0.2, axis=(0.0, 0.0, 1.0))
    free = mq.Floating("free", "ground", "wheel")
    mechanism = mq.Mechanism("wheel", (mq.Body("ground"), wheel), (free,), contacts=(floor,))
    printed = mq.derive(mechanism).text()
    assert "rho" in printed
    assert mq.check(mechanism, printed).right
