"""Small motions in letters: where equilibria are, when forces balance, and how it is printed."""

from __future__ import annotations

import math

import pytest
from systems import derive_system

import mecanique as mq
from mecanique.derivation.linear import linear, linearize_equations
from mecanique.derivation.printing.equations import expression
from mecanique.derivation.symbolic.derivation import Derivation
from mecanique.errors import DerivationError


def test_each_line_is_aligned_once_at_its_equals_sign() -> None:
    """Of one degree of freedom; the natural frequency and the damping ratio follow."""
    small = linearize_equations(derive_system("base_excited_mass").derivation, {"u": 0.0})
    assert small.latex() == "\n".join(
        [
            r"\begin{aligned}",
            r"\ddot{u} + \frac{c}{m} \dot{u} + \frac{k u}{m} &= X W^{2} \sin(W t) \\",
            r"\omega &= \sqrt{\frac{k}{m}} \\",
            r"\zeta &= \frac{c}{2 \sqrt{m k}}",
            r"\end{aligned}",
        ]
    )


def test_the_equations_of_several_stand_one_below_the_other() -> None:
    place = {"x": 0.0, "q": 0.0}
    small = linearize_equations(derive_system("cart_pole").derivation, place)
    lines = small.latex().split("\n")
    assert lines[0] == r"\begin{aligned}"
    assert lines[-1] == r"\end{aligned}"
    assert [line.count("&=") for line in lines[1:-1]] == [1, 1]
    assert [line.endswith(r" \\") for line in lines[1:-1]] == [True, False]


def puck() -> mq.Mechanism:
    """A particle on a table without forces, at r from a pivot that turns: at rest anywhere."""
    m = mq.Parameter("m", 2.0, "kg")
    return mq.Mechanism(
        "puck",
        (mq.Body("ground"), mq.Body("arm", mq.disk(1.0, 0.4)), mq.Body("puck", mq.particle(m))),
        (
            mq.Revolute("pin", "ground", "arm", axis=(0, 0, 1), coordinate="theta"),
            mq.Prismatic("slide", "arm", "puck", axis=(1, 0, 0), coordinate="r"),
        ),
        parameters=(m,),
        gravity=(0, 0, 0),
    )


@pytest.mark.parametrize(
    ("place", "words"),
    [
        (0.0, "0"),
        (-9e-10, "0"),
        (1.1e-9, "r_0"),
        (math.pi / 12, "pi/12"),
        (-5 * math.pi / 12 + 9e-10, "-5 pi/12"),
        (2 * math.pi / 3 - 1.1e-9, "r_0"),
        (4 * math.pi - 9e-10, "4 pi"),
        (1.0, "r_0"),
    ],
)
def test_a_place_within_a_billionth_of_a_multiple_of_15_degrees_is_that(
    place: float, words: str
) -> None:
    """The inertia of what turns is I + m r²: where it rests is seen in the first equation."""
    small = linearize_equations(mq.derive(puck()).derivation, {"theta": 0.0, "r": place})
    value = {name: expression(series).text() for name, series in small.place.items()}
    assert value["r"] == words
    assert small.letters == ({"r_0": place} if words == "r_0" else {})
    assert small.zero is (words == "0")


def hanging(stiffness: float, load: float) -> Derivation:
    """A mass on a spring, drawn by a constant load."""
    m, k, F = mq.Parameter("m", 2.0), mq.Parameter("k", stiffness), mq.Parameter("F", load)
    block = mq.Mechanism(
        "block",
        (mq.Body("ground"), mq.Body("block", mq.particle(m))),
        (mq.Prismatic("slide", "ground", "block", axis=(1, 0, 0), coordinate="x"),),
        forces=(mq.JointSpring("spring", "slide", k), mq.JointForce("load", "slide", F)),
        parameters=(m, k, F),
        gravity=(0, 0, 0),
    )
    return mq.derive(block).derivation


@pytest.mark.parametrize(
    ("stiffness", "load", "x", "balanced"),
    [
        # beside the larger of both forces, 600 N
        (30.0, 600.0, 20 * (1 + 0.9e-7), True),
        (30.0, 600.0, 20 * (1 + 1.2e-7), False),
        (30.0, 600.0, 20 * (1 - 1.2e-7), False),
        # beside what a deviation of 1 makes, 30 N
        (30.0, 2.9e-6, 0.0, True),
        (30.0, 3.1e-6, 0.0, False),
        (0.0, 1e-3, 0.0, False),
        (0.0, 0.0, 0.0, True),
    ],
)
def test_forces_balance_to_a_ten_millionth_of_the_largest(
    stiffness: float, load: float, x: float, balanced: bool
) -> None:
    derivation = hanging(stiffness, load)
    if balanced:
        linearize_equations(derivation, {"x": x})
    else:
        with pytest.raises(DerivationError, match="forces of 'block' do not balance there"):
            linearize_equations(derivation, {"x": x})


@pytest.mark.parametrize("count", [3, 4])
def test_four_masses_have_their_matrices_on_lines_of_their_own(count: int) -> None:
    k = mq.Parameter("k", 3.0)
    bodies = mq.Body("ground"), *(mq.Body(f"b{i}", mq.particle(1.0)) for i in range(count))
    slides = tuple(
        mq.Prismatic(f"s{i}", "ground", f"b{i}", axis=(1, 0, 0), coordinate=f"x{i}")
        for i in range(count)
    )
    springs = tuple(mq.JointSpring(f"k{i}", f"s{i}", k) for i in range(count))
    row = mq.Mechanism("row", bodies, slides, forces=springs, parameters=(k,))
    small = linear(mq.derive(row).derivation)
    assert small is not None
    heads = [line.split(" ", 1)[0] for line in small.lines()]
    assert len(heads) == 1 if count < 4 else heads == ["M", "M", "K", "q"]


@pytest.mark.parametrize(("k", "c"), [(30.0, 4.0), (30.0, 0.0), (0.0, 4.0), (-30.0, 4.0)])
def test_a_mass_has_a_frequency_if_its_spring_pulls_it_back(k: float, c: float) -> None:
    """ω² = k/m, and ζ = c/(2 √(k m)) if there is a damper."""
    letters = mq.Parameter("m", 2.0), mq.Parameter("k", k), mq.Parameter("c", c)
    spring = mq.Potential("spring", "slide", letters[1] * mq.coordinate("x") ** 2 / 2)
    damper = (mq.JointDamper("damper", "slide", letters[2]),) if c else ()
    block = mq.Mechanism(
        "block",
        (mq.Body("ground"), mq.Body("block", mq.particle(letters[0]))),
        (mq.Prismatic("slide", "ground", "block", axis=(1, 0, 0), coordinate="x"),),
        forces=(spring, *damper),
        parameters=letters,
        gravity=(0, 0, 0),
    )
    small = linearize_equations(mq.derive(block).derivation, {"x": 0.0})
    assert (small.square is None) == (k <= 0)
    assert (small.ratio is None) == (k <= 0 or not c)
    figures = {"omega = sqrt(k/m)": k > 0, "zeta = c/(2 sqrt(m k))": k > 0 and c > 0}
    assert small.text().splitlines()[2:] == [text for text, shown in figures.items() if shown]


def test_only_constant_coefficients_make_matrices() -> None:
    """Not x², x x', a spring that changes with time, a pendulum, nor quaternions or constraints."""
    x, v, t = mq.coordinate("x"), mq.velocity("x"), mq.time()
    m, k = mq.Parameter("m", 2.0), mq.Parameter("k", 3.0)

    def block(load: object) -> Derivation:
        return mq.derive(
            mq.Mechanism(
                "block",
                (mq.Body("ground"), mq.Body("block", mq.particle(m))),
                (mq.Prismatic("slide", "ground", "block", axis=(1, 0, 0), coordinate="x"),),
                forces=(mq.JointForce("load", "slide", load),),
                parameters=(m, k),
                gravity=(0, 0, 0),
            )
        ).derivation

    for load in (x * x, x * v, v * v, mq.cos(t) * x, t * v, mq.sin(x)):
        assert linear(block(load)) is None
    whole = linear(block(mq.cos(t) - k * x - 2 * v + 1))
    assert whole is not None
    assert whole.text().splitlines() == [
        "M q'' + C q' + K q = f",
        "q = [x]",
        "M = [[m]]",
        "C = [[2]]",
        "K = [[k]]",
        "f = [1 + cos(t)]",
    ]
    assert whole.lines() == [whole.latex()]
    assert whole.latex().startswith(r"\begin{bmatrix} m \end{bmatrix}")
    for name in ("rigid_bar_pendulum", "free_rigid_body", "rolling_disk"):
        assert linear(derive_system(name).derivation) is None


def test_quaternions_at_rest_upright_are_numbers() -> None:
    """A box hung in a ball at a depth h: J w' = -m g h δ about each level axis, δ' = w."""
    m, h = 2.0, 0.5
    hung = mq.Mechanism(
        "hung",
        (mq.Body("ground"), mq.Body("b", mq.box(m, (0.3, 0.3, 0.3)).at((0, 0, -h)))),
        (mq.Spherical("s", "ground", "b"),),
        gravity=(0, 0, -10),
    )
    place = dict(zip(hung.coordinates, (0.0, 0.0, 0.0, 1.0), strict=True))
    small = linearize_equations(mq.derive(hung).derivation, place)
    assert not small.letters
    moment = m * (0.3**2 / 6 + h * h)
    lines = small.text().splitlines()
    for axis in "xy":
        (line,) = (line for line in lines if f"s_w{axis}'" in line)
        inertia, weight = (float(term.split()[0]) for term in line.partition(" = ")[0].split(" + "))
        assert weight / inertia == pytest.approx(m * 10 * h / moment, rel=1e-12)


@pytest.mark.parametrize(("name", "damped"), [("simple_pendulum", 0), ("base_excited_mass", 1)])
def test_damping_is_spoken_of_where_there_is_some(name: str, damped: int) -> None:
    said = derive_system(name).text(steps=True)
    assert said.count("Without damping it would oscillate") == damped
