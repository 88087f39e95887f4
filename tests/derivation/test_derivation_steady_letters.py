"""Linear equations about steady motions in letters, against the numbers of the engine."""

from __future__ import annotations

import numpy as np
import pytest

import mecanique as mq
from mecanique.derivation.scalars.evaluation import evaluate
from mecanique.derivation.steady import steady_letters as letters_of
from mecanique.derivation.symbolic.derivation import Matrix

COIN = mq.textbook.load("rolling_coin")


def numbers(rows: Matrix, values: dict[str, float]) -> np.ndarray:
    return np.array([[evaluate(entry, values) for entry in row] for row in rows], dtype=float)


@pytest.mark.parametrize(
    ("system", "v", "names"),
    [
        ("whipple_bicycle", {"x": 1.0}, ("roll", "steer")),
        ("rolling_coin", {"spin": 1.0}, ("yaw", "lean")),
        ("rolling_coin", {"spin": 2.0}, ("lean", "yaw")),
    ],
)
def test_letters_have_the_numbers_of_the_engine(
    system: str, v: dict[str, float], names: tuple[str, ...]
) -> None:
    mechanism = mq.textbook.load(system)
    ride = mq.expand_in_speed(mechanism, None, v, names)
    letters, values = ride.letters, dict(mechanism.values)
    for rows, expected in (
        (letters.M, ride.M),
        *zip(letters.C, ride.C, strict=True),
        *zip(letters.K, ride.K, strict=True),
    ):
        size = max(1.0, float(np.abs(expected).max()))
        np.testing.assert_allclose(numbers(rows, values), expected, rtol=0, atol=1e-11 * size)


def test_the_bicycle_in_letters_is_that_of_the_benchmark() -> None:
    """J. P. Meijaard et al., Proc. R. Soc. A 463 (2007) 1955, appendix A, at random parameters.

    There z points down: zB and zH, and the entries xz of the tensors, have the other sign.
    """
    bicycle = mq.textbook.load("whipple_bicycle")
    ride = mq.expand_in_speed(bicycle, None, {"x": 1.0}, ("roll", "steer"))
    text = ride.letters.text()
    assert "     K0_11 = -mR rR - mB zB - mH zH - mF rF\n" in text
    assert "     C1_21 = -(IRyy c rF + IFyy (w + c) rR) cos(tilt)/(w rR rF)\n" in text
    assert "     rear_spin' = v/rR\n" in text
    rows = [line for line in text.splitlines() if line.startswith("     M_11 roll''")]
    assert rows == [
        "     M_11 roll'' + M_12 steer'' + v C1_12 steer' + K0_11 g roll + (v^2 K2_12 + K0_12 g) "
        "steer = 0"
    ]
    random = np.random.default_rng(3)
    p = {name: value * random.uniform(0.7, 1.3) for name, value in bicycle.values.items()}
    s, c, w, trail = np.sin(p["tilt"]), np.cos(p["tilt"]), p["w"], p["c"]
    mA = p["mH"] + p["mF"]
    xA = (p["xH"] * p["mH"] + w * p["mF"]) / mA
    zA = -(p["zH"] * p["mH"] + p["rF"] * p["mF"]) / mA
    mT, mu = p["mR"] + p["mB"] + mA, trail / w * c
    xT = (p["xB"] * p["mB"] + p["xH"] * p["mH"] + w * p["mF"]) / mT
    zT = -(p["rR"] * p["mR"] + p["zB"] * p["mB"] + p["zH"] * p["mH"] + p["rF"] * p["mF"]) / mT
    SF = p["IFyy"] / p["rF"]
    ST = p["IRyy"] / p["rR"] + SF
    SA = mA * ((xA - w - trail) * c - zA * s) + mu * mT * xT
    gK0 = p["g"] * np.array([[mT * zT, -SA], [-SA, -SA * s]])
    K2 = [[0, (ST - mT * zT) / w * c], [0, (SA + SF * s) / w * c]]
    letters = ride.letters
    np.testing.assert_allclose(numbers(letters.K[0], p), gK0, rtol=1e-12, atol=0)
    np.testing.assert_allclose(numbers(letters.K[2], p), K2, rtol=1e-12, atol=1e-12)


def test_a_coin_in_letters() -> None:
    """It rolls upright above v² = g r/3 (Neimark & Fufaev, 1972): C12 C21 > M11 K22."""
    ride = mq.expand_in_speed(COIN, None, {"spin": 1.0}, ("yaw", "lean"))
    lines = [line.strip() for line in ride.letters.text().splitlines()]
    assert "M_22 = 5 m r^2/4" in lines
    assert "M_11 yaw'' + u C1_12 lean' = 0" in lines
    assert "M_22 lean'' + u C1_21 yaw' + K0_22 g lean = 0" in lines
    assert "\\ddot{\\theta}" in ride.letters.latex()
    assert "<math" in ride.letters.mathml()


def test_what_is_not_steady_in_letters_is_refused() -> None:
    with pytest.raises(mq.DerivationError, match="expected coordinates that stay independent"):
        letters_of(COIN, {}, {"spin": 1.0}, ("z", "lean"))
    with pytest.raises(mq.DerivationError, match="other coordinates move with lean"):
        letters_of(COIN, {}, {"spin": 1.0}, ("lean",))
    leaning = {"lean": 0.3}
    with pytest.raises(mq.DerivationError, match=r"is not steady .*: .* is left of its forces"):
        letters_of(COIN, leaning, {"spin": 1.0}, ("yaw", "lean"))
    ball = mq.textbook.load("free_rigid_body")
    with pytest.raises(mq.DerivationError, match="turns by a quaternion; describe it by hinges"):
        letters_of(ball, {}, {}, ("x",))
