"""What stands below the result: small motions, vibration, rotation, orbits and precession."""

from __future__ import annotations

import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import mecanique as mq
from mecanique.derivation import METHODS
from mecanique.derivation.special_motions import special_motions_of
from mecanique.derivation.symbolic.derivation import Ending


def answers(mechanism: mq.Mechanism) -> dict[str, Ending]:
    return {ending.title: ending for ending in special_motions_of(mq.derive(mechanism).derivation)}


def lines(name: str, title: str) -> list[str]:
    ending = answers(mq.textbook.load(name)).get(title)
    return [] if ending is None else [line.text() for line in ending.lines]


@pytest.mark.parametrize(
    ("name", "expected"),
    [
        ("simple_pendulum", ["q'' + g q/l = 0", "omega = sqrt(g/l)"]),
        ("rigid_bar_pendulum", ["q'' + 3 g q/(2 l) = 0", "omega = sqrt(3 g/(2 l))"]),
        # Fundamentals of Dynamics, Example 1.2, and without its restriction to small motion
        ("bars_and_springs", ["q'' + 36 k q/(17 m) = 0", "omega = 6 sqrt(k/(17 m))"]),
        ("bars_and_springs_small", ["omega = 6 sqrt(k/(17 m))"]),
        ("base_excited_mass", ["omega = sqrt(k/m)", "zeta = c/(2 sqrt(m k))"]),
        # the upright position of rest is not stable, and the Atwood machine has none
        ("bar_chain", []),
        ("atwood_machine", []),
        ("kapitza_pendulum", []),
    ],
)
def test_one_coordinate_has_its_linear_equation_and_frequency(
    name: str, expected: list[str]
) -> None:
    assert lines(name, "Small motions") == expected


def test_what_is_damped_does_not_move_with_the_natural_frequency() -> None:
    """Den Hartog, sect. 2.6: u = exp(-zeta omega t) cos(omega sqrt(1 - zeta^2) t)."""
    damped = answers(mq.textbook.load("base_excited_mass"))["Small motions"].sentence
    assert "it does with omega sqrt(1 - zeta^2) where zeta < 1" in damped
    assert "exp(-zeta omega t)" in damped


def test_coupled_pendulums_have_their_modes() -> None:
    """In phase as one alone, against each other with the spring (French, Vibrations, ch. 5)."""
    ending = answers(mq.textbook.load("coupled_pendulums"))["Small motions"]
    assert [line.text() for line in ending.lines] == [
        "m l^2 q1'' + (m g l + k a^2) q1 - k a^2 q2 = 0",
        "m l^2 q2'' - k a^2 q1 + (m g l + k a^2) q2 = 0",
        "omega_1^2 = g/l",
        "omega_2^2 = (m g l + 2 k a^2)/(m l^2)",
    ]
    assert "q1 = q2 = 0 obey linear equations" in ending.sentence
    assert "In the first mode q2 = q1, in the second q2 = -q1." in ending.sentence


def test_two_rods_have_their_frequency_equation() -> None:
    """Its roots are the squares of the frequencies of mq.linearize, which takes numbers."""
    mechanism = mq.textbook.load("double_pendulum")
    *_, equation = lines("double_pendulum", "Small motions")
    values = dict(mechanism.values)
    polynomial = equation.removesuffix(" = 0").replace(" ", "*").replace("^", "**")
    polynomial = polynomial.replace("*+*", "+").replace("*-*", "-")
    frequencies = mq.linearize(mechanism).frequencies
    for omega in frequencies:
        size = eval(polynomial.replace("-", "+"), {**values, "omega": omega})
        assert abs(eval(polynomial, {**values, "omega": omega})) < 1e-12 * size
    assert len(set(frequencies)) == 2


@pytest.mark.parametrize("sprung", [False, True])
def test_a_frequency_equation_of_more_than_twelve_terms_is_left_out(sprung: bool) -> None:
    """That of two rods has eight terms, 2 + 4 + 2, and with a spring at the elbow 2 + 8 + 5."""
    rods = mq.textbook.load("double_pendulum")
    k = mq.Parameter("k", 3.0, "N·m/rad")
    coil = mq.JointSpring("coil", rods.joints[1].name, k)
    if sprung:
        rods = replace(rods, forces=(*rods.forces, coil), parameters=(*rods.parameters, k))
    last = answers(rods)["Small motions"].lines[-1].text()
    assert ("omega^4" in last) == (not sprung)


def test_a_rest_that_is_not_at_zero_follows_from_linear_equations() -> None:
    ending = answers(mq.textbook.load("elastic_pendulum"))["Small motions"]
    assert "r = (m g + k l0)/k and theta = 0" in ending.sentence
    assert [line.text() for line in ending.lines][2:] == [
        "omega_r^2 = k/m",
        "omega_theta^2 = k g/(m g + k l0)",
    ]


def test_a_rest_that_a_length_hides_ends_the_derivation_without_it() -> None:
    """A slider hangs by a spring from beside its track: its rest is within a square root."""
    bodies = mq.Body("ground"), mq.Body("slider", mq.particle(1.0))
    track = mq.Prismatic("track", "ground", "slider", axis=(0, 0, 1), coordinate="z")
    coil = mq.Spring("coil", "ground", (1, 0, 0), "slider", (0, 0, 0), 3.0, 0.5)
    assert not answers(mq.Mechanism("beside", bodies, (track,), forces=(coil,)))


def test_what_meets_no_force_leaves_one_frequency() -> None:
    """Of Furuta's pendulum with a free arm, a rod of mass M and a particle m: det (K - s M) = 0."""
    assert lines("furuta_pendulum", "Small motions")[-1] == "omega^2 = (M + 3 m) g/(M l)"
    mechanism = mq.textbook.load("furuta_pendulum")
    M, m, g, l = (mechanism.values[letter] for letter in ("M", "m", "g", "l"))
    fastest = mq.linearize(mechanism).frequencies.max()
    assert fastest == pytest.approx(np.sqrt((M + 3 * m) * g / (M * l)), rel=1e-9)


def test_a_base_that_is_shaken_gives_amplitude_transmissibility_and_resonance() -> None:
    """Thomson, Theory of Vibration, sects. 3.4 and 3.5: of the relative motion, W_r above omega."""
    assert lines("base_excited_mass", "Steady vibration") == [
        "A_u = m X W^2/sqrt(c^2 W^2 + (k - m W^2)^2)",
        "tan(phi_u) = c W/(k - m W^2)",
        "H_block_x = sqrt((c^2 W^2 + k^2)/(c^2 W^2 + (k - m W^2)^2))",
        "W_r = sqrt(2 k^2/(2 m k - c^2))",
        "c^2 < 2 m k",
    ]
    mechanism = mq.textbook.load("base_excited_mass")
    m, c, k, X, W = (mechanism.values[letter] for letter in ("m", "c", "k", "X", "W"))
    decay = 2 * m / c
    motion = mq.simulate(mechanism, duration=40 * decay, rtol=1e-10)
    late = np.linspace(30 * decay, 40 * decay, 20_001)
    amplitude = np.abs(motion(late).q).max()
    expected = m * X * W**2 / np.hypot(c * W, k - m * W**2)
    assert amplitude == pytest.approx(expected, rel=1e-5)
    # the force is m X W^2 sin(W t)
    lagging = expected * np.sin(W * late - np.arctan2(c * W, k - m * W**2))
    assert motion(late).q[:, 0] == pytest.approx(lagging, abs=1e-4 * expected)


def test_resonance_follows_from_the_power_of_the_rate_in_the_force() -> None:
    """The amplitude W^n/sqrt((k - m W²)² + c² W²) is greatest where its slope is zero."""
    m, k, c = mq.Parameter("m", 2.0, "kg"), mq.Parameter("k", 50.0, "N/m"), mq.Parameter("c", 3.0)
    F, e, W, t = mq.Parameter("F", 1.5), mq.Parameter("e", 0.1), mq.Parameter("W", 4.0), mq.time()

    def stated(law: Any, *, damped: bool) -> list[str]:
        damper = (mq.JointDamper("d", "slide", c),) if damped else ()
        oscillator = mq.Mechanism(
            "oscillator",
            (mq.Body("ground"), mq.Body("block", mq.particle(m))),
            (mq.Prismatic("slide", "ground", "block", axis=(1, 0, 0), coordinate="x"),),
            forces=(mq.JointSpring("s", "slide", k), *damper, mq.JointForce("f", "slide", law)),
            parameters=(m, k, c, F, e, W),
        )
        return [line.text() for line in answers(oscillator)["Steady vibration"].lines]

    greatest = {
        0: ["W_r = sqrt((2 m k - c^2)/(2 m^2))", "c^2 < 2 m k"],
        1: ["W_r = sqrt(k/m)"],
        2: ["W_r = sqrt(2 k^2/(2 m k - c^2))", "c^2 < 2 m k"],
        3: [],
    }
    waves = mq.cos(W * t), mq.sin(W * t), -mq.cos(W * t), -mq.sin(W * t)
    for n, (above, wave) in enumerate(zip(("F", "F W", "F W^2", "F W^3"), waves, strict=True)):
        law = F * W**n * wave
        assert stated(law, damped=True) == [
            f"A_x = {above}/sqrt((k - m W^2)^2 + c^2 W^2)",
            "tan(phi_x) = c W/(k - m W^2)",
            *greatest[n],
        ]
        amplitude, *resonance = stated(law, damped=False)
        assert amplitude == f"A_x = {above}/abs(k - m W^2)"
        assert resonance == ["W_r = sqrt(k/m)"] * (n < 3)
    mixed = stated(F * (1 + e * W) * mq.sin(W * t), damped=True)
    assert mixed[0] == "A_x = F (1 + e W)/sqrt((k - m W^2)^2 + c^2 W^2)"
    assert len(mixed) == 2
    half = stated(F * mq.cos(W * t / 2), damped=True)
    assert half[0] == "A_x = F/sqrt((4 k - m W^2)^2/16 + c^2 W^2/4)"
    assert half[1:] == ["tan(phi_x) = 2 c W/(4 k - m W^2)"]


def test_the_transmissibility_is_stated_by_every_method() -> None:
    """Steps by virtual work list no positions, from which it was read."""
    shaken = mq.textbook.load("base_excited_mass")
    texts = {mq.derive(shaken, method=way).text(steps=True)[-200:] for way in METHODS}
    assert len(texts) == 1
    assert "H_block_x = sqrt(" in texts.pop()


def test_without_a_damper_what_a_base_passes_on_has_no_roots() -> None:
    damped = mq.textbook.load("base_excited_mass")
    spring = tuple(force for force in damped.forces if force.name == "spring")
    undamped = replace(damped, forces=spring)
    stated = [line.text() for line in answers(undamped)["Steady vibration"].lines]
    assert "H_block_x = k/abs(k - m W^2)" in stated


def test_a_resonance_that_is_damped_away_is_not_stated() -> None:
    mechanism = mq.textbook.load("base_excited_mass")
    damped = mechanism.replace(c=3 * np.sqrt(mechanism.values["m"] * mechanism.values["k"]))
    stated = [line.text() for line in answers(damped)["Steady vibration"].lines]
    assert not any("W_r" in line for line in stated)


def test_a_planet_moves_on_a_conic() -> None:
    """Goldstein, Classical Mechanics, 3rd ed., eqs. 3.55 to 3.58 and 3.71, with k = m mu."""
    assert lines("kepler_orbit", "Steady rotation") == [
        "r_0 = p_phi^2/(m^2 mu)",
        "phi' = m^3 mu^2/p_phi^3",
        "omega = m^3 mu^2/p_phi^3",
    ]
    assert lines("kepler_orbit", "Orbit") == [
        "r = r_0/(1 + e cos(phi - phi_0))",
        "e = sqrt(1 + 2 p_phi^2 E/(m^3 mu^2))",
        "r^2 phi'/2 = p_phi/(2 m)",
        "a = -m mu/(2 E)",
        "tau^2 = 4 pi^2 a^3/mu",
    ]
    closed = answers(mq.textbook.load("kepler_orbit"))["Steady rotation"].sentence
    assert closed.endswith("It is the rate of phi, so that the path is closed.")


def test_a_simulated_planet_stays_on_that_conic() -> None:
    mechanism = mq.textbook.load("kepler_orbit")
    m, mu = mechanism.values["m"], mechanism.values["mu"]
    r, spin = 1.0, 1.2 * np.sqrt(mu)
    motion = mq.simulate(
        mechanism, q={"r": r, "phi": 0.3}, v={"phi": spin}, duration=5.0, rtol=1e-11
    )
    p, E = m * r**2 * spin, m * (r * spin) ** 2 / 2 - m * mu / r
    e = np.sqrt((m**3 * mu**2 + 2 * p**2 * E) / (m**3 * mu**2))
    # it starts where r is least
    conic = p**2 / (m**2 * mu) / (1 + e * np.cos(motion["phi"] - 0.3))
    np.testing.assert_allclose(motion["r"], conic, rtol=1e-8, atol=0)


def turning_spring(letter: str) -> mq.Mechanism:
    kepler = mq.textbook.load("kepler_orbit")
    stiffness = mq.Parameter(letter, 2.0, "N/m", "stiffness")
    spring = mq.JointSpring("spring", "r", stiffness, 0.0)
    kept = tuple(parameter for parameter in kepler.parameters if parameter.symbol != "mu")
    return replace(kepler, forces=(spring,), parameters=(*kept, stiffness))


def test_a_letter_that_a_mechanism_has_is_given_no_second_meaning() -> None:
    assert answers(turning_spring("omega")) == {}


def test_a_mass_on_a_turning_spring_is_no_planet() -> None:
    """With V = k r^2/2 the radius oscillates twice in a turn (Goldstein, sect. 3.6)."""
    found = answers(turning_spring("k"))
    assert "Orbit" not in found
    assert [line.text() for line in found["Steady rotation"].lines] == [
        "r_0^4 = p_phi^2/(m k)",
        "phi' = p_phi/(m r_0^2)",
        "omega = 2 sqrt(k/m)",
    ]


def test_a_conical_pendulum_oscillates_about_its_cone() -> None:
    """Landau & Lifshitz, Mechanics, sect. 14, problem 1: omega^2 = g (1 + 3 cos^2)/(l cos)."""
    assert lines("spherical_pendulum", "Steady rotation") == [
        "phi' = sqrt(g/(l cos(theta)))",
        "omega = sqrt(g (4 - 3 sin(theta)^2)/(l cos(theta)))",
    ]


def test_a_top_precesses_slowly_or_fast_and_sleeps() -> None:
    """Goldstein, eqs. 5.76 to 5.79: with I1 = J_theta and the weight at 3 h/4."""
    assert lines("heavy_top", "Steady precession") == [
        "4 J_theta cos(theta) phi'^2 - 4 p_psi phi' + 3 m g h = 0",
        "p_psi^2 ≥ 3 m J_theta g h cos(theta)",
        "phi' ≈ 3 m g h/(4 p_psi)",
        "phi' ≈ p_psi/(J_theta cos(theta))",
        "omega ≈ p_psi/J_theta",
        "p_psi^2 > 3 m J_theta g h",
    ]
    # in gimbals the axle upright has no such limit: the outer gimbal has inertia of its own
    precession = lines("gyroscope", "Steady precession")
    assert len(precession) == 5
    assert precession[2] == "phi' ≈ w g d/p_psi"
    # V_eff = (p - p_psi cos(theta))^2/(2 D) + V with D = J_phi + J_theta sin(theta)^2
    nutation = "p_psi^2 sin(theta)^2/(J_theta (J_phi + J_theta sin(theta)^2))"
    assert precession[4] == f"omega^2 ≈ {nutation}"


def test_sections_have_titles_and_letters_in_every_format() -> None:
    derived = mq.derive(mq.textbook.load("heavy_top"))
    text = derived.text(steps=True, symbols=True)
    assert "11. Steady precession\n" in text
    page = derived.latex(steps=True, symbols=True)
    assert "\\subsection*{Steady precession}" in page
    assert "\\approx" in page
    assert "<mo>≥</mo>" in derived.mathml(steps=True, symbols=True)
    pendulum = mq.derive(mq.textbook.load("simple_pendulum")).text(steps=True, symbols=True)
    assert re.search(r"^  omega +natural angular frequency \[rad/s\]$", pendulum, re.MULTILINE)
