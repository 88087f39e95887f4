"""Poisson series: ring axioms, canonical identities, calculus, atoms, refusals."""

from __future__ import annotations

import math
from fractions import Fraction
from typing import Any

import numpy as np
import pytest
from derivation_law import cos, euler, exp, log, sin, sqrt, tan
from hypothesis import given, settings
from hypothesis import strategies as st

from mecanique.derivation.scalars.cancel import divide_by_wave, divide_exactly, integrate, tidy
from mecanique.derivation.scalars.elementary import root_of_square
from mecanique.derivation.scalars.evaluation import Evaluation, Substitution, evaluate
from mecanique.derivation.scalars.functions import function
from mecanique.derivation.scalars.polynomials import (
    REACH,
    Parts,
    exact,
    exponent,
    exponents,
    largest,
    power,
)
from mecanique.derivation.scalars.series import Kind, Ring, Series
from mecanique.errors import DerivationError, UnknownNameError

RING = Ring()
X, Q1, Q2 = RING.coordinate("x"), RING.coordinate("q1"), RING.coordinate("q2")
M, L = RING.parameter("m"), RING.parameter("l")
W, T = RING.parameter("W"), RING.time
NAMES = [g.name for g in RING.generators]

PROPERTY = settings(deadline=None, max_examples=60, derandomize=True)


def _leaf(draw: Any) -> Series:
    plain = st.sampled_from([X, Q1, M, L, RING["x'"], RING["q1'"], 1 / L])
    turn = st.tuples(
        st.sampled_from([sin, cos]), st.integers(-2, 2), st.integers(-2, 2), st.integers(0, 3)
    )
    if draw(st.booleans()):
        letter: Series = draw(plain)
        return letter
    f, k1, k2, quarters = draw(turn)
    series: Series = f(k1 * Q1 + k2 * Q2 + quarters * math.pi / 2)
    return series


@st.composite
def elements(draw: Any) -> Series:
    total = RING.number(draw(st.fractions(-3, 3, max_denominator=6)))
    for _ in range(draw(st.integers(0, 3))):
        term = RING.number(draw(st.integers(-3, 3)))
        for _ in range(draw(st.integers(0, 3))):
            term = term * _leaf(draw)
        total = total + term
    return total


def numbers(ring: Ring = RING, seed: int = 1, states: int = 5) -> dict[str, np.ndarray]:
    rng = np.random.default_rng(seed)
    return {
        g.name: rng.uniform(0.4, 1.6, states) for g in ring.generators if g.kind is not Kind.ATOM
    }


@PROPERTY
@given(elements(), elements(), elements())
def test_it_is_a_commutative_ring(a: Series, b: Series, c: Series) -> None:
    assert a + b == b + a
    assert a * b == b * a
    assert (a + b) + c == a + (b + c)
    assert (a * b) * c == a * (b * c)
    assert a * (b + c) == a * b + a * c
    assert a - a == 0
    assert a * 1 == a
    assert a + 0 == a
    assert hash(a * b) == hash(b * a)
    assert a**2 == a * a


@PROPERTY
@given(elements(), elements())
def test_it_agrees_with_floats(a: Series, b: Series) -> None:
    number = Evaluation(RING, numbers())
    np.testing.assert_allclose(number(a * b), number(a) * number(b), rtol=1e-11, atol=1e-11)
    np.testing.assert_allclose(number(a + b), number(a) + number(b), rtol=1e-11, atol=1e-11)


@PROPERTY
@given(elements(), elements(), st.sampled_from(["x", "q1", "q2", "q1'", "l"]))
def test_derivatives_obey_leibniz_and_commute(a: Series, b: Series, name: str) -> None:
    assert (a * b).diff(name) == a.diff(name) * b + a * b.diff(name)
    assert a.diff(name).diff("q1") == a.diff("q1").diff(name)


@PROPERTY
@given(elements())
def test_time_derivative_is_the_chain_rule(a: Series) -> None:
    rates = {"x": RING["x'"], "q1": RING["q1'"], "q2": RING["q2'"]}
    rates |= {"x'": RING["x''"], "q1'": RING["q1''"]}
    assert a.ddt() == RING.sum([a.diff(name) * rate for name, rate in rates.items()])


@PROPERTY
@given(elements())
def test_derivative_agrees_with_differences(a: Series) -> None:
    at, h = numbers(), 1e-6
    up, down = ({**at, "q1": at["q1"] + s * h} for s in (1, -1))
    slope = (evaluate(a, up) - evaluate(a, down)) / (2 * h)
    np.testing.assert_allclose(evaluate(a.diff("q1"), at), slope, rtol=1e-5, atol=1e-5)


def test_identities_hold_by_construction() -> None:
    assert cos(Q1) ** 2 + sin(Q1) ** 2 == 1
    assert sin(Q1 + Q2) == sin(Q1) * cos(Q2) + cos(Q1) * sin(Q2)
    assert cos(2 * Q1) == 1 - 2 * sin(Q1) ** 2
    assert cos(-Q1) == cos(Q1)
    assert sin(-Q1) == -sin(Q1)
    assert cos(3 * Q1) == 4 * cos(Q1) ** 3 - 3 * cos(Q1)
    assert sin(Q1) ** 4 == (3 - 4 * cos(2 * Q1) + cos(4 * Q1)) / 8


def test_quarter_turns_and_twelfths_are_exact() -> None:
    assert sin(Q1 + math.pi / 2) == cos(Q1)
    assert cos(Q1 - math.pi / 2) == sin(Q1)
    assert sin(Q1 + math.pi) == -sin(Q1)
    ring = Ring()
    for n in range(-14, 15):
        angle = ring.number(n * math.pi / 12)
        assert evaluate(cos(angle), {}) == pytest.approx(math.cos(n * math.pi / 12), abs=1e-15)
        assert cos(angle) ** 2 + sin(angle) ** 2 == 1
    assert cos(ring.number(math.pi / 3)) == Fraction(1, 2)
    assert cos(ring.constant("pi") / 6) == sqrt(ring.number(3)) / 2
    assert [g.name for g in cos(ring.constant("pi") * 2).generators()] == []


def test_a_coordinate_may_turn_and_stretch() -> None:
    assert (Q1**2 / 2 + sin(Q1)).diff("q1") == Q1 + cos(Q1)


def test_explicit_time_turns_and_grows() -> None:
    assert cos(W * T).ddt() == -W * sin(W * T)
    assert (T**2).ddt() == 2 * T
    assert cos(Q1 - W * T).diff("q1") == -sin(Q1 - W * T)
    assert sin(W * T).diff("W") == T * cos(W * T)


def test_rolling_turns_by_a_quotient() -> None:
    ring = Ring()
    x, R = ring.coordinate("x"), ring.parameter("R")
    assert sin(x / R).diff("x") == cos(x / R) / R
    assert cos(x / (2 * ring.parameter("S")) * 4) == 2 * cos(x / ring["S"]) ** 2 - 1


def test_constant_angles_and_parameters_in_sines() -> None:
    ring = Ring()
    q, alpha = ring.coordinate("q"), ring.parameter("alpha")
    assert sin(q + alpha).diff("q") == cos(q + alpha)
    assert sin(alpha).ddt() == 0
    assert cos(ring.number(0.3)) ** 2 + sin(ring.number(0.3)) ** 2 == 1
    assert evaluate(tan(alpha), {"alpha": 0.4}) == pytest.approx(math.tan(0.4), rel=1e-12)


@pytest.mark.parametrize(
    ("number", "fraction"),
    [
        (0.1, Fraction(1, 10)),
        (1 / 3, Fraction(1, 3)),
        (0.1 + 0.2, Fraction(3, 10)),
        (9.81, Fraction(981, 100)),
        (9.80665, Fraction(980665, 100000)),
        (-0.0, Fraction(0)),
        (1e300, Fraction(1e300)),
        (1e-12, Fraction(1, 10**12)),
        (np.float64(2.5), Fraction(5, 2)),
        (np.int64(7), Fraction(7)),
        (math.pi, Fraction(math.pi)),
    ],
)
def test_floats_become_what_they_stand_for(number: float, fraction: Fraction) -> None:
    assert exact(number) == fraction
    assert float(exact(number)) == pytest.approx(number, rel=3e-16)


@PROPERTY
@given(st.floats(allow_nan=False, allow_infinity=False))
def test_a_float_keeps_its_value(number: float) -> None:
    assert abs(exact(number) - Fraction(number)) <= Fraction(math.ulp(number))


def test_square_roots_of_squares_are_exact() -> None:
    ring = Ring()
    x, y, l, k = (
        ring.coordinate("x"),
        ring.coordinate("y"),
        ring.parameter("l"),
        ring.parameter("k"),
    )
    assert sqrt((x - l) ** 2) == l - x
    assert sqrt(4 * l**2 * (x + y - 3 * l) ** 2) == 2 * l * (3 * l - x - y)
    assert sqrt(l**2 / 9) == l / 3
    assert sqrt(x**2 * k**4) == x * k**2
    assert sqrt((x - y) ** 2) == x - y
    assert not any(g.kind is Kind.ATOM for g in ring.generators)
    assert sqrt(ring.number(8)) == 2 * sqrt(ring.number(2))
    assert sqrt(ring.number(6)) == sqrt(ring.number(2)) * sqrt(ring.number(3))
    assert sqrt(ring.number(20_014)) == sqrt(ring.number(2)) * sqrt(ring.number(10_007))
    assert sqrt(ring.number(10_007**2)) == 10_007
    assert sqrt(k) ** 2 == k
    assert 1 / sqrt(ring.number(3)) == sqrt(ring.number(3)) / 3
    assert sqrt(k) ** 3 / k == sqrt(k)


def test_a_spring_length_is_an_atom_with_its_chain_rule() -> None:
    ring = Ring()
    x, h = ring.coordinate("x"), ring.parameter("h")
    rho = sqrt(x**2 + h**2)
    assert sqrt(h**2 + x**2) == rho
    assert sqrt(x**2 / 4 + h**2 / 4) == rho / 2
    assert rho**2 == x**2 + h**2
    assert rho.diff("x") == x / rho
    assert rho.ddt() == x * ring["x'"] / rho
    assert rho.diff("x").diff("x") != h**2 / rho**3
    assert (rho.diff("x").diff("x") - h**2 / rho**3).vanishes()
    assert not (rho.diff("x") - 1).vanishes()
    xs = np.array([0.3, -2.0])
    np.testing.assert_allclose(
        evaluate(rho, {"x": xs, "h": 0.7}), np.hypot(xs, 0.7), rtol=1e-14, atol=0
    )


def test_functions_are_atoms_with_their_chain_rules() -> None:
    at = {"x": np.linspace(0.1, 0.6, 4)}
    ring = Ring()
    x = ring.coordinate("x")
    for name in ("tan", "asin", "acos", "atan", "exp", "log", "tanh", "Abs", "sign", "sqrt"):
        f = function(name)
        h = 1e-6
        slope = (f(at["x"] + h) - f(at["x"] - h)) / (2 * h)
        np.testing.assert_allclose(evaluate(f(x), at), f(at["x"]), rtol=1e-14, atol=0)
        np.testing.assert_allclose(evaluate(f(x).diff("x"), at), slope, rtol=1e-8, atol=1e-12)
    assert exp(ring.number(0)) == 1
    assert log(x).diff("x") == x**-1


def test_division_by_a_sum_adjoins_an_inverse() -> None:
    ring = Ring()
    x, m1, m2 = ring.coordinate("x"), ring.parameter("m1"), ring.parameter("m2")
    share = m1 / (m1 + m2)
    assert share.diff("x") == 0
    assert (share + m2 / (m1 + m2) - 1).vanishes()
    assert evaluate(1 / (1 + x**2), {"x": 2.0}) == pytest.approx(0.2, rel=1e-12)
    assert ((1 / (1 + x**2)).diff("x") + 2 * x / (1 + x**2) ** 2).vanishes()


def test_coefficients_read_off_mass_matrix_and_bias() -> None:
    ring = Ring()
    q, m, l, g = ring.coordinate("q"), *(ring.parameter(n) for n in "mlg")
    v, a = ring["q'"], ring["q''"]
    E = m * l**2 * a + m * g * l * sin(q) + v**2
    (mass,), bias = E.linear(["q''"])
    assert mass == m * l**2
    assert bias == m * g * l * sin(q) + v**2
    assert E.coefficients(["q'", "q''"])[2, 0] == 1
    with pytest.raises(DerivationError, match="expected a series linear in q', got"):
        E.linear(["q'"])


def test_inputs_have_the_rates_they_were_given() -> None:
    ring = Ring()
    z, F = ring.input("z", derivatives=2), ring.input("F")
    assert (z**2).ddt() == 2 * z * ring["z'"]
    with pytest.raises(DerivationError, match="the rate of the input 'F' is not known"):
        F.ddt()
    with pytest.raises(DerivationError, match="the rate of the input \"z''\" is not known"):
        z.ddt().ddt().ddt()


def test_exponents_pack_and_unpack() -> None:
    packed = power(0, -3) + power(2, REACH) + power(5, -REACH)
    assert list(exponents(packed)) == [(0, -3), (2, REACH), (5, -REACH)]
    assert [exponent(packed, i) for i in range(7)] == [-3, 0, REACH, 0, 0, -REACH, 0]


def test_overflowing_exponents_are_refused() -> None:
    high = X ** (REACH - 1) * X
    assert high.diff("x") == REACH * X ** (REACH - 1)
    with pytest.raises(DerivationError, match="beyond ±2047"):
        high * X
    turned = cos(REACH * Q1)
    with pytest.raises(DerivationError, match="beyond ±2047"):
        turned * cos(Q1)
    with pytest.raises(DerivationError, match="expected integer multiples"):
        cos((REACH + 1) * Q1)


@pytest.fixture
def reaching(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let every series be asked for exponents beyond its reach, those on the way as well."""
    plain = Series.__init__

    def asked(self: Series, ring: Ring, parts: Parts, denominator: int, reach: int) -> None:
        assert largest(parts) <= reach
        plain(self, ring, parts, denominator, reach)

    monkeypatch.setattr(Series, "__init__", asked)


@pytest.mark.usefixtures("reaching")
def test_no_exponent_is_beyond_the_reach_by_which_products_are_refused() -> None:
    ring = Ring()
    a, b, x = (ring.coordinate(name) for name in "abx")
    h = ring.parameter("h")
    waves = [f(k * a - n * b) for f in (sin, cos) for k, n in ((1, 2), (2, -1), (3, 0))]
    root = sqrt(h**2 + x**2)
    some = [*waves, x**3 * h, 2 / x**4, root, (x + h) / root**3, 1 / (h + x) ** 2, h * x + a]
    for one in some:
        for name in "abx":
            one.diff(name).diff(name)
        one.coefficients(["x"])
        (one / root - 1 / (one + h)).vanishes()
        tidy(ring.sum([one / root, root]) / (h + x))
        integrate(one, "x")
        for other in some:
            one * other + other**2
    for wave in waves:
        ((key, (sign,)),) = ((trig, part.values()) for trig, part in wave.parts.items())
        for other in (*waves, x**2 * cos(a) + h * sin(b)):
            assert divide_by_wave(other * wave, key) == sign * other
            assert divide_exactly(other * wave * x, wave * x) == other
    assert not (x - 1 / root).vanishes()
    both = ring.monomial(power(ring.index(h), 3) + power(ring.index(x), 2))
    assert divide_exactly(both + h**3, x**2 + 1) == h**3
    summed = cos(2 * a - 2 * b) + cos(2 * b)
    assert divide_by_wave(summed, *cos(a - 2 * b).parts) == 2 * cos(a)
    assert divide_exactly((x**3 - h) * (x + h) ** 2, (x + h) ** 2) == x**3 - h
    assert root_of_square(cos(3 * a - b) ** 2) == cos(3 * a - b)
    assert sqrt((x**3 - h) ** 2 * h**4) == h**2 * (h - x**3)
    with pytest.raises(AssertionError):
        Series(ring, (x**3).parts, 1, 2)


def test_too_many_terms_are_refused() -> None:
    ring = Ring(most_terms=100)
    total = ring.sum([ring.parameter(f"p{i}") for i in range(12)])
    with pytest.raises(
        DerivationError, match=r"more than 100 terms, too many .*; use the numeric derivation"
    ):
        total**3
    with pytest.raises(DerivationError, match="more than 100 terms"):
        ring.sum([total**2, *(ring.parameter(f"r{i}") for i in range(30))])


def test_refusals_say_what_is_wrong() -> None:
    with pytest.raises(DerivationError, match="division by zero"):
        X / (X - X)
    with pytest.raises(DerivationError, match=r"expected an integer exponent, got 0\.5"):
        X**0.5  # type: ignore[operator]  # what is not typed is refused, too
    with pytest.raises(DerivationError, match="expected a finite real number, got nan"):
        X + math.nan
    with pytest.raises(DerivationError, match="expected a finite real number, got 'l'"):
        X * "l"
    with pytest.raises(
        DerivationError, match="expected an integer combination of angles in sin or cos"
    ):
        sin(sin(Q1))
    cos(Q2)
    with pytest.raises(DerivationError, match=r"sine or cosine of 0\.5 × q2, of which 1 × occurs"):
        cos(Q2 / 2)
    with pytest.raises(DerivationError, match="square root of a positive series, got sqrt"):
        sqrt(-M)
    with pytest.raises(DerivationError, match="series of two rings"):
        X + Ring().coordinate("x")
    with pytest.raises(DerivationError, match="the name 'm' already stands for a parameter"):
        RING.coordinate("m")
    with pytest.raises(DerivationError, match="expected a generator of the ring, got"):
        X.diff(X * M)
    with pytest.raises(UnknownNameError, match="unknown generator 'q3'"):
        X.diff("q3")
    with pytest.raises(UnknownNameError, match="unknown value 'x'"):
        evaluate(X, {"y": 1.0})
    with pytest.raises(UnknownNameError, match="did you mean 'sin'"):
        function("sine")
    with pytest.raises(DerivationError, match="atan2 has no closed form"):
        function("atan2")(X, M)


def test_half_angles_are_fine_when_met_first() -> None:
    ring = Ring()
    q = ring.coordinate("q")
    assert cos(q / 2) ** 2 == (1 + cos(q)) / 2


def _chain(n: int, scalars: Any) -> Any:
    """Lagrangian of n hanging point masses, absolute angles, the pivot moved by A cos W t."""
    g, A, W, m, l = scalars

    def L(q: Any, v: Any, t: Any) -> Any:
        z, vx, vz, total = A * cos(W * t), 0, -A * W * sin(W * t), 0
        for i in range(n):
            z = z - l[i] * cos(q[i])
            vx, vz = vx + l[i] * cos(q[i]) * v[i], vz + l[i] * sin(q[i]) * v[i]
            total = total + m[i] * (vx * vx + vz * vz) / 2 - m[i] * g * z
        return total

    return L


def test_euler_operator_in_the_ring_is_that_of_jets() -> None:
    n, rng = 4, np.random.default_rng(0)
    ring = Ring()
    q = [ring.coordinate(f"q{i}") for i in range(n)]
    v = [ring[f"q{i}'"] for i in range(n)]
    names = ["g", "A", "W", *(f"m{i}" for i in range(n)), *(f"l{i}" for i in range(n))]
    p = [ring.parameter(name) for name in names]
    L = _chain(n, (*p[:3], p[3 : 3 + n], p[3 + n :]))(q, v, ring.time)
    E = [operated.value for operated in ring.euler(L)]
    numbers = rng.uniform(0.5, 2.0, len(names))
    state = rng.normal(size=(3, n, 6))
    t = rng.uniform(0.0, 3.0, 6)
    expected = euler(
        _chain(n, (*numbers[:3], numbers[3 : 3 + n], numbers[3 + n :])),
        state[0],
        state[1],
        state[2],
        t,
    )
    at: dict[str, Any] = dict(zip(names, numbers, strict=True)) | {"t": t}
    for order, values in zip(("", "'", "''"), state, strict=True):
        at |= {f"q{i}{order}": x for i, x in enumerate(values)}
    number = Evaluation(ring, at)
    np.testing.assert_allclose([number(e) for e in E], expected, rtol=1e-13, atol=1e-12)
    assert sum(map(len, E)) < 100


def test_absolute_angles_keep_long_chains_short() -> None:
    n = 10
    ring = Ring()
    q = [ring.coordinate(f"q{i}") for i in range(n)]
    v = [ring[f"q{i}'"] for i in range(n)]
    p = [
        ring.parameter(name)
        for name in ("g", *(f"m{i}" for i in range(n)), *(f"l{i}" for i in range(n)))
    ]
    L = _chain(n, (p[0], 0, 0, p[1 : 1 + n], p[1 + n :]))(q, v, 0)
    E = [operated.value for operated in ring.euler(L)]
    assert sum(map(len, E)) == 770


@pytest.mark.parametrize(
    "size", [1, 2**302, Fraction(1, 2**298)], ids=["near one", "large", "small"]
)
@pytest.mark.parametrize("bits", [1100, 4100])
def test_a_root_of_coefficients_beyond_all_floats_has_a_value(bits: int, size: Fraction) -> None:
    # a spring far out on turned bodies: coefficients of exact floats without a common square
    ring = Ring()
    x = ring.coordinate("x")
    far = size * Fraction(3 ** (bits * 7 // 11), 2**bits + 1)
    near = size * Fraction(5, 2 ** (bits * 9 // 11) + 1)
    square = far * x**2 + near
    root = sqrt(square)
    assert root**2 == square
    value = math.sqrt(far * 4 + near)
    assert evaluate(root, {"x": 2.0}) == pytest.approx(value, rel=1e-14)
    # a power of four stands outside, so that no other root does
    assert len({atom.function for atom in ring.atoms.values()}) == len(ring.atoms) == 1
    assert sqrt((far * x + 1) ** 2) == far * x + 1
    assert sqrt(far**2 * x**2 + 1) ** 2 == far**2 * x**2 + 1


def test_what_a_series_depends_on_is_what_it_contains() -> None:
    ring = Ring()
    a, b, x = (ring.coordinate(name) for name in "abx")
    h, k = ring.parameter("h"), ring.parameter("k")
    cos(a)
    for series, names in (
        (sin(b), {"b"}),
        (cos(2 * b), {"b"}),
        (sin(a - 3 * b) * k, {"a", "b", "k"}),
        (1 / x, {"x"}),
        (1 / (h + x) + ring.number(2), {"h", "x"}),
        (sqrt(x**2 + h**2), {"x", "h"}),
    ):
        letters = {g.name for g in series.generators() if g.kind is not Kind.ATOM}
        assert letters == names
        assert (Kind.PARAMETER in series.kinds) == bool(names & {"h", "k"})
    assert ring.number(3).is_number
    assert ring.number(0).is_number
    assert not any(series.is_number for series in (x, sin(b), 1 + x, 1 + cos(a)))
    assert all(series.is_unit for series in (x, 2 * h / x, ring.number(3)))
    assert not any(series.is_unit for series in (ring.number(0), 1 + x, cos(a), x * cos(a)))


def test_constants_have_their_values_and_letters_the_given_ones() -> None:
    ring = Ring()
    pi, e = ring.constant("pi"), ring.constant("E")
    assert evaluate(2 * pi + e, {}) == 2 * math.pi + math.e
    modulus = Ring().parameter("E")
    assert evaluate(modulus, {"E": 2.5}) == 2.5
    assert evaluate(X**-1, {"x": np.array([2, 4])}).tolist() == [0.5, 0.25]


def test_derivatives_beyond_the_largest_exponent_are_refused() -> None:
    lowest = X**-REACH
    with pytest.raises(DerivationError, match="beyond ±2047"):
        (lowest.diff("x") * X**0) * X**-1
    assert (X ** (1 - REACH)).diff("x") == (1 - REACH) * lowest


def test_a_series_is_zero_however_its_roots_stand() -> None:
    """ρ² = s below a fraction bar as above, also of roots within roots."""
    ring = Ring()
    x, h = ring.coordinate("x"), ring.parameter("h")
    s = x**2 + h**2
    rho = sqrt(s)
    sigma = sqrt(h + rho)
    for zero in (
        s / rho - rho,
        1 / rho - rho / s,
        x**2 / rho**2 + h**2 / rho**2 - 1,
        1 / rho**3 - 1 / (s * rho),
        (h + rho) / sigma - sigma,
        sigma**-2 * sigma**4 - h - rho,
    ):
        assert zero.vanishes()
        assert not (zero + rho).vanishes()
        assert not (zero + 1 / sigma).vanishes()


def test_substitution_is_exact() -> None:
    ring = Ring()
    q, x, h, pi = (
        ring.coordinate("q"),
        ring.coordinate("x"),
        ring.parameter("h"),
        ring.constant("pi"),
    )
    numbers = {"h": 0.7}
    series = 3 * x**2 * sin(q) / h + cos(2 * q) * x - sqrt(h**2 + x**2) + 1 / (h + x)
    assert Substitution({"q": pi / 6, "x": h}, numbers)(series) == (
        3 * h / 2 + h / 2 - sqrt(ring.number(2)) * h + 1 / (2 * h)
    )
    put = Substitution({"x": ring.number(0)}, numbers)
    assert put(series) == 1 / h - h
    assert put(series - 1 / h + h) == 0
    assert Substitution({"q": 2 * q}, numbers)(sin(3 * q) * q) == 2 * q * sin(6 * q)
    assert Substitution({}, numbers)(series) == series
    # a root stays positive where what is below it becomes a square: √(x² + y²) at y = 0 is |x|
    y = ring.coordinate("y")
    for number, sign in ((-0.4, -1), (0.4, 1)):
        alone = Substitution({"y": ring.number(0)}, {**numbers, "x": number})
        assert alone(sqrt(x**2 + y**2)) == sign * x
    # a root keeps its sign: √((x − h)²) is h − x as a series, and positive where it was
    shifted = sqrt(x**2 + h**2 / 4)
    assert evaluate(Substitution({"x": -h}, numbers)(shifted), numbers) == pytest.approx(
        math.sqrt(1.25) * 0.7, rel=1e-15
    )
    root = sqrt(h**2 - 2 * h * x + 2 * x**2)
    assert Substitution({"x": h}, numbers)(root) == h


def test_roots_of_squares_and_lengths_of_vectors_are_cosines_where_they_are() -> None:
    ring = Ring()
    a, b, x = ring.coordinate("a"), ring.coordinate("b"), ring.parameter("x")
    assert root_of_square(ring.number(1)) == 1
    assert root_of_square(cos(a) ** 2 + sin(a) ** 2) == 1
    assert root_of_square(cos(a) ** 2) == cos(a)
    assert root_of_square(cos(a - 2 * b) ** 2) == cos(a - 2 * b)
    odd = (1 + sin(2 * a)) / 2, (1 + cos(a)) / 2  # squares of cosines of π/4 − a and a/2
    for other in (sin(a) ** 2, 2 * cos(a) ** 2, cos(a), *odd, x * cos(a) ** 2 + 1 - x):
        assert root_of_square(other) is None
    for angle in (a, 2 * a, a - 2 * b, a + b):
        for part in (ring.number(1), sin(b), cos(a) * x, sin(a - b) + x, sin(2 * a) * cos(b) + 3):
            assert tidy(tidy(cos(angle) * part) / cos(angle)) == part
